/* cli/draw/convert.h - the formats of linkages that `linkwright convert` reads and writes, one row each. */
#ifndef CLI_DRAW_CONVERT_H
#define CLI_DRAW_CONVERT_H

#include <stdbool.h>
#include "cli/program/output.h"
#include "grammar/linkage.h"

typedef struct cli_text {              /* what was read                                            */
    const char *path;                  /* for messages                                             */
    char       *text;                  /* malloc                                                   */
    size_t      size;
    int         result;                /* of a file that fit wrote; 0: the first                   */
    lw_units    units;                 /* of numbers without a unit of their own                   */
} cli_text;

typedef struct cli_format {
    const char *name, *title;
    const char *end;                   /* of a file's name, ".json"                                */
    bool      (*begins)(const cli_text *t);                      /* does the text look like it?    */
    lw_status (*read)(cli_text *t, lw_linkage *k, lw_error *e);          /* NULL: written only      */
    lw_status (*write)(const lw_linkage *k, FILE *f, lw_error *e);       /* NULL: read only        */
} cli_format;

/* Ends with a row without name; asked in this order whether a text is theirs. */
extern const cli_format cli_formats[];

#endif
