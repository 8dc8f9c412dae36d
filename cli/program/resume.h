/* cli/program/resume.h - listings in a file, one item per line, that continue after an interruption.
 *
 * A listing is written to FILE.partial, which is renamed to FILE at the end. A program that was killed leaves
 * FILE.partial; a program that was asked to stop leaves FILE. --resume continues the file with more complete lines. */
#ifndef CLI_PROGRAM_RESUME_H
#define CLI_PROGRAM_RESUME_H

#include <stdint.h>
#include "cli/program/output.h"

typedef struct cli_resume {
    uint64_t n_line;               /* complete lines so far                                         */
    char    *last;                 /* the last of them with its line end; NULL: none; free()       */
    size_t   size;                 /* of `last`                                                    */
} cli_resume;

/* Open the listing that -o names: empty, or, with `resume`, positioned after its complete lines. */
lw_status cli_resume_open(const cli_call *call, bool resume, lw_output *o, cli_resume *r, lw_error *e);

#endif
