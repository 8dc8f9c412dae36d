#include "enumerate/mechanisms.h"

typedef struct walk {
    const lw_mechanism_steps *steps;
    lw_mechanism_counts      *counts;
    lw_mechanism_visit       *visit;
    lw_void_visit            *left_out;
    void                     *context;
    int                       n_input;
} walk;

/* Each of these functions counts a result of one step and passes it to the next step. */

static lw_status finished(void *context, const lw_mechanism *m)
{
    walk *w = context;
    return w->visit ? w->visit(w->context, m) : LW_OK;
}

static lw_status with_output(void *context, const lw_mechanism *m)
{
    walk *w = context;
    w->counts->n_output++;
    return finished(w, m);
}

static lw_status to_output(walk *w, const lw_mechanism *m)
{
    return w->steps->output ? lw_outputs_each(m, with_output, w) : finished(w, m);
}

static lw_status with_input(void *context, const lw_mechanism *m)
{
    walk *w = context;
    w->counts->n_driven++;
    return to_output(w, m);
}

static lw_status to_input(walk *w, const lw_mechanism *m)
{
    if (w->steps->input == LW_INPUT_LEFT)
        return to_output(w, m);
    return lw_inputs_each(m, w->n_input, w->steps->input == LW_INPUT_GROUND, with_input, w);
}

static lw_status with_kinds(void *context, const lw_mechanism *m)
{
    walk *w = context;
    w->counts->n_labelled++;
    return to_input(w, m);
}

static lw_status is_void(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints)
{
    walk *w = context;
    w->counts->n_void[reason]++;
    return w->left_out ? w->left_out(w->context, m, reason, joints) : LW_OK;
}

static lw_status to_kinds(walk *w, const lw_mechanism *m)
{
    if (!w->steps->kinds)
        return to_input(w, m);
    lw_mechanism chosen = *m;
    chosen.directed = w->steps->slider_direction;
    chosen.translating_cams = w->steps->translating_cams;
    return lw_kinds_each(&chosen, w->steps->kinds, with_kinds, is_void, w);
}

static lw_status with_ground(void *context, const lw_mechanism *m)
{
    walk *w = context;
    w->counts->n_ground++;
    return to_kinds(w, m);
}

lw_status lw_mechanisms_each(const lw_mechanism *m, const lw_mechanism_steps *steps, lw_mechanism_counts *counts,
                             lw_mechanism_visit *visit, lw_void_visit *left_out, void *context)
{
    walk w = { steps, counts, visit, left_out, context, 0 };
    lw_chain c;
    lw_mechanism_chain(m, &c);
    w.n_input = lw_chain_mobility(&c);
    counts->n_chain++;
    return steps->ground ? lw_grounds_each(m, with_ground, &w) : to_kinds(&w, m);
}
