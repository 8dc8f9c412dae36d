/* cli/motion/table_run.h - a run of a planar or a spatial model as a table. */
#ifndef CLI_MOTION_TABLE_RUN_H
#define CLI_MOTION_TABLE_RUN_H

#include "cli/motion/table.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"

typedef struct cli_table_options {
    double      from, to;
    int         steps;
    const char *speed;                   /* of inputs without a motion; NULL: they run freely */
} cli_table_options;

/* One of planar and spatial is the model, which may be changed.  t needs cli_table_free also after a failure. */
lw_status cli_table_run(const cli_call *call, lw_model *planar, lw_spatial *spatial, const cli_table_options *o, cli_table *t, lw_error *e);

#endif
