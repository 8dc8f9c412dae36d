/* cli/fit/fit_stages.h - what a search goes through: four links by type, then the topologies of pins with six, eight, ...
 * links (of several freedoms: these alone), and linkages to start from, each with those of its own number; then the
 * topologies with sliders, last those with slots and gears, so that what comes before is the same search as without
 * them. */
#ifndef CLI_FIT_FIT_STAGES_H
#define CLI_FIT_FIT_STAGES_H

#include "optimise/topology/mechanism_set.h"

/* Linkages that somebody has already: results of an earlier fit, or drawn by hand. */
typedef struct cli_fit_known {
    int         n;
    lw_linkage *linkage;             /* (n) owned */
    lw_family  *family;              /* (n) owned */
} cli_fit_known;

/* Add those of a file as cli_read_linkage takes it, all results of it. */
lw_status cli_fit_known_read(const char *path, cli_fit_known *k, lw_error *e);

/* Add those of a catalogue whose curves are nearest to a target with points. */
lw_status cli_fit_known_atlas(const char *path, const lw_target *t, int links, cli_fit_known *k, lw_error *e);
void      cli_fit_known_free(cli_fit_known *k);

typedef struct cli_fit_stages {
    int              n;
    lw_search_stage         stage[LW_STAGE_MAX];
    lw_families_pair pair[LW_STAGE_MAX];     /* topologies of a stage, and what is known            */
} cli_fit_stages;

/* In this order; t, k and s must stay where they are.  Tells t's stages which stages of the search their mechanisms of
 * pins alone, and the others, are in. */
void cli_fit_stages_make(lw_mechanism_set *t, const cli_fit_known *k, cli_fit_stages *s);

#endif
