/* cli/program/resume.h - listings in a file, one item a line, that are gone on with after an interruption.
 *
 * They are written to FILE.partial, which becomes FILE in the end.  A program that was killed leaves FILE.partial,
 * one that was asked to stop leaves FILE: --resume goes on with the one that holds more whole lines. */
#ifndef CLI_PROGRAM_RESUME_H
#define CLI_PROGRAM_RESUME_H

#include <stdint.h>
#include "cli/program/output.h"

typedef struct cli_resume {
    uint64_t n_line;               /* that are there already                                       */
    char    *last;                 /* the last of them with its line end, NULL without; free()     */
    size_t   size;                 /* of it                                                        */
} cli_resume;

/* Open the listing that -o names: empty, or with `resume` behind the lines that are there. */
lw_status cli_resume_open(const cli_call *call, bool resume, lw_output *o, cli_resume *r, lw_error *e);

#endif
