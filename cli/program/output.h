/* cli/program/output.h - what all commands share: messages, exit codes, -o, Ctrl-C. */
#ifndef CLI_PROGRAM_OUTPUT_H
#define CLI_PROGRAM_OUTPUT_H

#include <signal.h>
#include "base/file.h"
#include "cli/program/command.h"
#include "mbs/analysis/notes.h"
#include "optimise/solvers/solver.h"

/* Exit code for a status of the library that is not LW_OK. */
int cli_exit_code(lw_status s);

/* "linkwright trace: file:line:column: text" on standard error; returns cli_exit_code. */
int cli_fail(const cli_call *call, const lw_error *e);

/* Report a wrong use of the command: the text, and where to find help. Returns CLI_USAGE. */
int cli_usage(const cli_call *call, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Print a remark on standard error, unless --quiet is given. */
void cli_note(const cli_call *call, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The same for what the library has to say. */
lw_note_sink cli_notes(const cli_call *call);

/* May the command write the file `path`? CLI_DONE; else CLI_USAGE after a message that says what to do: the file is an
 * input of the same run (compared by device and inode, so links and other spellings of the path count), or it exists,
 * linkwright did not write it (lw_file_is_own), and --force is not given. Devices, pipes and new files may be written.
 */
int cli_may_write(const cli_call *call, const char *path);

/* The same for the file FOLDER/NAME, with a printf format for the name. */
int cli_may_write_in(const cli_call *call, const char *folder, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same for -o and all options that name a file to write; no two of them may name one file. The ends of their names
 * must go with what is written. main.c calls this before the command runs. */
int cli_check_outputs(const cli_call *call);

/* Room for a path in a folder that cli_make_folder made, or of data: a name in it has at most 400 bytes. */
#define CLI_PATH_SIZE (LW_PATH_SIZE + 400)

/* Count a file that is named inside an input (the target of a task file) as an input too, and check all outputs
 * again. */
int cli_add_input(const cli_call *call, const char *path);

/* The same where no call is at hand, after cli_check_outputs. LW_E_ARG: the file is an output of this run. */
lw_status cli_name_input(const char *path, lw_error *e);

/* Write n bytes of text as one field of a CSV row: quoted if it holds a comma, a quote or a line end, inner quotes doubled (RFC 4180). */
void cli_csv_field(FILE *f, const char *text, size_t n);

/* The same of a text that ends with a zero. */
void cli_csv_text(FILE *f, const char *text);

/* Make the folder and those above it. CLI_BAD_INPUT with a message: this failed, or the folder cannot be written. */
int cli_make_folder(const cli_call *call, const char *folder);

/* The command ends with `code`: unless this is CLI_DONE, remove those of the folders it made that are empty. */
void cli_end_folders(int code);

/* Does the name of a file end in one of the words, as in "svg pdf png"? NULL does not. */
bool cli_ends_in(const char *path, const char *words);

/* Open the file of -o, or standard output; then write to o->f. Data beside a plot or an animation are written only with
 * -o or --json, else nowhere. */
lw_status cli_open(const cli_call *call, lw_output *o, lw_error *e);

/* Commit the output. Returns `code` if this succeeded, else the exit code of the failure. If the code is an error or
 * CLI_LIMIT, or a signal or --time ended the work, the output so far goes to FILE.partial and FILE stays as it was. */
int cli_close(const cli_call *call, lw_output *o, int code);

/* A part of the output could not be made for lack of memory: the command then ends with a message and CLI_NUMERIC. */
void cli_lost(void);

/* The file of a picture of a run that ended with `code`: `path` after CLI_DONE, else "plot.partial.svg" for "plot.svg", so
 * that a picture of a part replaces no whole one.  NULL after a message: the user has a file of this name. */
const char *cli_picture_path(const cli_call *call, const char *path, int code, char partial[LW_PATH_SIZE + 16]);

/* The same for an output that says itself that it is not complete: it always goes to FILE. */
int cli_close_marked(const cli_call *call, lw_output *o, int code);

/* Watch for Ctrl-C (SIGINT), SIGTERM, SIGHUP and the end of --time (SIGALRM). The first of them sets the flag to its
 * number and ends standard input, so that a command that waits for input continues at once; a second signal ends the
 * program. Functions of the library stop when the flag is set. A phase that does not stop by itself is ended by force
 * less than a second later, except while the file of -o is committed; the rows that are on the disk become FILE.partial. */
void cli_watch_signals(void);
void cli_limit_time(double seconds);         /* from now on; only the first call with seconds > 0 counts */
void cli_hold(void);                         /* results are written: nothing ends the program by force ... */
void cli_go_on(void);                        /* ... until this; the limits hold again, for pictures */
const volatile sig_atomic_t *cli_stop_flag(void);
#define cli_interrupted() (*cli_stop_flag() != 0)
#define cli_timed_out()   (*cli_stop_flag() == SIGALRM)

/* The memory that the program may use [byte], by --memory and the machine. cli_limit_memory makes the system hold it:
 * allocations beyond it fail. */
double cli_memory(const cli_call *call);
void   cli_limit_memory(const cli_call *call);

/* lw_stop_text, which for LW_STOP_USER says what ended the command: --time, or which signal. */
const char *cli_stop_text(lw_stop s);

/* The exit code of a command that ended with `code`: 5 after --time, 128 + the signal's number after a signal. */
int cli_end_code(int code);

/* lw_file_read for a file of the user. If path is "-" and standard input is a terminal, print what the command waits
 * for, such as "a linkage (JSON)". LW_STOPPED: after Ctrl-C. */
lw_status cli_read_file(const char *path, const char *what, char **text, size_t *size, lw_error *e);

/* If standard input is a terminal, print what the command waits for. */
void cli_say_waiting(const char *what);

#endif
