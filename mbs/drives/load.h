/* mbs/drives/load.h - loads of the drives of a model over a cycle, by inverse dynamics. */
#ifndef LW_MBS_DRIVES_LOAD_H
#define LW_MBS_DRIVES_LOAD_H

#include <signal.h>
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"

typedef struct lw_load_options {
    double from, to;                     /* [s] */
    int    intervals;                    /* samples less one */
    const volatile sig_atomic_t *stop;   /* may be NULL */
} lw_load_options;

/* Move the model as its inputs prescribe.  The drives are the inputs with a motion (tied ones too), or the "drives" of a
 * spatial model.  *out needs lw_loads_free also after a failure.  LW_E_ARG: no drives, from >= to, or inputs without a
 * motion; else as lw_dynamics_make. */
lw_status lw_loads_planar(const lw_model *m, const lw_load_options *o, lw_loads *out, lw_error *e);
lw_status lw_loads_spatial(const lw_spatial *m, const lw_load_options *o, lw_loads *out, lw_error *e);

#endif
