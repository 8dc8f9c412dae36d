/* cli/draw/draw.h - the two halves of `linkwright draw`: a linkage, and chains and mechanisms. */
#ifndef CLI_DRAW_DRAW_H
#define CLI_DRAW_DRAW_H

#include "catalogues/pages/draw.h"
#include "cli/program/output.h"

typedef struct cli_draw_settings {
    const char *target, *title;
    int         size[2], grid[2];
    int         steps, result, format, caption;
    double      until, azimuth, elevation;
    bool        all_modes, each, numbers, keep_going;
} cli_draw_settings;

/* Values of --caption. */
enum { CLI_CAPTION_NUMBER, CLI_CAPTION_GRAPH6, CLI_CAPTION_JOINTS, CLI_CAPTION_ASSORTMENT, CLI_CAPTION_NONE };

/* Draw sheets of the topologies in `file` (NULL: standard input). Returns the exit code. */
int cli_draw_chains(const cli_call *call, const char *file, lw_draw_kind kind);

#endif
