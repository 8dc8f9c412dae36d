/* cli/program/progress.h - one line on standard error that is overwritten: progress, rate, time left.
 *
 * Nothing is shown with --quiet, if standard error is not a terminal, and during the first second. */
#ifndef CLI_PROGRAM_PROGRESS_H
#define CLI_PROGRAM_PROGRESS_H

#include "cli/program/command.h"

typedef struct cli_progress {
    bool        on;
    const char *what, *unit;      /* "fit", "starts"                                               */
    double      start, shown;     /* clock [s]                                                     */
    int         width;            /* of the line on the screen                                     */
} cli_progress;

cli_progress cli_progress_begin(const cli_call *call, const char *what, const char *unit);

/* Show done of total (total 0: unknown); `note` (or NULL) is printed at the end of the line. May be called often, but
 * from one thread only. */
void cli_progress_show(cli_progress *p, double done, double total, const char *note);

/* The same for work whose end is not known: the seconds since the beginning, and the note. */
void cli_progress_tell(cli_progress *p, const char *note);

void cli_progress_end(cli_progress *p);       /* wipes the line */

#endif
