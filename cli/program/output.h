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

/* Open what -o names, or standard output; then write to o->f. */
lw_status cli_open(const cli_call *call, lw_output *o, lw_error *e);

/* Commit, and turn the outcome into the exit code: `code` when all went well.  After Ctrl-C commands
 * commit what there is all the same; main.c makes the code CLI_INTERRUPTED. */
int cli_close(const cli_call *call, lw_output *o, int code);

/* Watch for Ctrl-C (and a polite kill): the first sets the flag, a second ends the program at once.  The flag is what
 * the library is given to look at. */
void cli_watch_interrupt(void);
const volatile sig_atomic_t *cli_stop_flag(void);
#define cli_interrupted() (*cli_stop_flag() != 0)

#endif
