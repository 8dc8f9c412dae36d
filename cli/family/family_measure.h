/* cli/family/family_measure.h - figures of a variant: formulas over its parameters, and figures of a run of its
 * model. */
#ifndef CLI_FAMILY_FAMILY_MEASURE_H
#define CLI_FAMILY_FAMILY_MEASURE_H

#include "cli/family/family.h"

#define CLI_MEASURE_MAX 32

typedef struct cli_measure {
    char text[128], unit[64];            /* as written; unit: after a run                              */
    int  figure;                         /* -1: a formula                                              */
    char column[96];
} cli_measure;

/* Read the list of --measure.  LW_E_ARG. */
lw_status cli_measures_read(const char *list, int *n, cli_measure *m, lw_error *e);

/* Without --measure: peak and rms of each drive, and its greatest speed; the inputs are those of the variant. */
lw_status cli_measures_default(const cli_call *call, lw_variant *v, int *n, cli_measure *m, lw_error *e);

/* Check and expand the variant, move its model, fill value (n) and the units.  An error names the place in the
 * master. */
lw_status cli_measures_run(const cli_call *call, lw_variant *v, int n, cli_measure *m, double *value, lw_error *e);

#endif
