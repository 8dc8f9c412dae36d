/* mbs/analysis/held.c - modes of a robot whose drives are held. */
#include "mbs/analysis/held.h"

#include <stdlib.h>
#include "mbs/equilibrium/modes.h"
#include "mbs/dynamics/tangent_internal.h"
#include "mbs/formulations/formulations.h"

lw_status lw_held_make(const lw_spatial *m, lw_held *h, lw_error *e)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    int n = m->n_drive ? m->n_drive : m->n_input;
    *h = (lw_held){ .model = *m };
    if (m->n_elastic == 0 && m->n_spring == 0 && m->n_joint_spring == 0)
        return lw_error_set(e, LW_E_ARG, "nothing vibrates while the drives are held: the model has neither elastic links nor springs "
                            "(docs/notation.md, \"Elastic links\")");
    h->input = calloc((size_t)n + 1, sizeof *h->input);
    if (!h->input)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < n; i++)
        h->input[i].measure = m->n_drive ? m->drive[i] : m->input[i].measure;
    h->model.input = h->input, h->model.n_input = n;
    h->model.n_drive = h->model.n_force = h->model.n_motor = 0;
    h->model.gravity = lw_v3(0, 0, 0);
    o.analysis = LW_ANALYSIS_STATIC;
    o.hold_inputs = true;
    lw_status s = lw_dynamics_make_spatial(&h->model, &o, &h->d, e);
    if (s != LW_OK)
        return s;
    if (lw_dynamics_massless(h->d))
        return lw_error_set(e, LW_E_ARG, "link \"%s\" needs a \"mass\" and an \"inertia\" to vibrate", lw_dynamics_massless(h->d));
    h->q = calloc((size_t)lw_dynamics_space(h->d)->n_q, sizeof *h->q);
    h->kept = calloc(1, sizeof *h->kept);
    return h->q && h->kept ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void lw_held_free(lw_held *h)
{
    if (h->kept)
        lw_tangent_free(h->kept);
    free(h->kept);
    lw_dynamics_free(h->d);
    free(h->input);
    free(h->q);
    *h = (lw_held){ .q = NULL };
}

lw_status lw_held_frequency(lw_held *h, const lw_robot *r, double *frequency, lw_error *e)
{
    lw_modes modes;
    lw_status s = lw_dynamics_place_on_rigid(h->d, &r->space, r->follow.q, h->q, e);
    if (s != LW_OK)
        return s;
    s = lw_modes_find_large(h->d, &(lw_modes_options){ .hold_inputs = true, .kept = h->kept }, 1, 0, h->q, &modes, e);
    if (s == LW_OK)
        *frequency = modes.mode[0].frequency;
    lw_modes_free(&modes);
    return s;
}
