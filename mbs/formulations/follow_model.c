/* mbs/formulations/follow_model.c - a model made ready to be followed. */
#include "mbs/dynamics/follow_internal.h"
#include "mbs/formulations/follow_model.h"
#include "mbs/formulations/formulations.h"

lw_status lw_follow_create(const lw_model *m, lw_input_function *motion, void *context, double t,
                           const volatile sig_atomic_t *stop, lw_follow **out, lw_error *e)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    o.analysis = LW_ANALYSIS_KINEMATIC;
    o.hold_inputs = true;
    o.rigid = true;
    o.from = t;
    o.to = t + 1;
    o.stop = stop;
    *out = NULL;
    lw_status s = lw_dynamics_make(m, &o, &d, e);
    if (s != LW_OK)
        return s;
    s = lw_follow_ready(d, motion, context, t, out, e);
    if (s == LW_OK)
        lw_follow_own(*out, lw_dynamics_free);
    else
        lw_dynamics_free(d);
    return s;
}
