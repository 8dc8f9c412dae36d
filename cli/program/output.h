/* cli/program/output.h - what the commands share at their ends: messages, exit codes, -o, Ctrl-C. */
#ifndef CLI_PROGRAM_OUTPUT_H
#define CLI_PROGRAM_OUTPUT_H

#include <signal.h>
#include "base/file.h"
#include "cli/program/command.h"

/* Exit code for a failed or limited call of the library. */
int cli_exit_code(lw_status s);

/* "linkwright trace: file:line:column: text" on standard error; returns cli_exit_code. */
int cli_fail(const cli_call *call, const lw_error *e);

/* A wrong way to call the command: text and where to find help; returns CLI_USAGE. */
int cli_usage(const cli_call *call, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A remark on standard error, silent with --quiet. */
void cli_note(const cli_call *call, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* May the command write the file `path`?  CLI_DONE, or CLI_USAGE after a message that says what to do: the file is an
 * input of the same run (by device and inode, so links and other spellings of the path count), or it exists, linkwright
 * did not write it (lw_file_is_own) and --force is missing.  Devices, pipes and new files are fine. */
int cli_may_write(const cli_call *call, const char *path);

/* The same for the file FOLDER/NAME, with a printf format for the name. */
int cli_may_write_in(const cli_call *call, const char *folder, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same for -o and all options of kind CLI_OUTPUT, no two of which may name one file.  main.c asks this before the
 * command runs. */
int cli_check_outputs(const cli_call *call);

/* Make the folder and those above it; CLI_BAD_INPUT with a message when that fails or the folder cannot be written. */
int cli_make_folder(const cli_call *call, const char *folder);

/* Open what -o names, or standard output; then write to o->f. */
lw_status cli_open(const cli_call *call, lw_output *o, lw_error *e);

/* Commit, and turn the outcome into the exit code: `code` when all went well.  After Ctrl-C commands
 * commit what there is all the same; main.c makes the exit code. */
int cli_close(const cli_call *call, lw_output *o, int code);

/* Watch for Ctrl-C (SIGINT) and SIGTERM.  The first sets the flag to its number and ends standard input, so that a
 * command which waits for input goes on at once; a second ends the program.  Functions of the library take the flag as
 * their sign to stop.  main.c turns it into exit code 130 or 143. */
void cli_watch_interrupt(void);
const volatile sig_atomic_t *cli_stop_flag(void);
#define cli_interrupted() (*cli_stop_flag() != 0)

/* lw_file_read for a file of the user.  If path is "-" and standard input is a terminal, say what the command waits
 * for: "a linkage (JSON)".  LW_STOPPED after Ctrl-C. */
lw_status cli_read_file(const char *path, const char *what, char **text, size_t *size, lw_error *e);

/* Say so when standard input is a terminal. */
void cli_say_waiting(const char *what);

#endif
