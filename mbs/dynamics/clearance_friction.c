/* mbs/dynamics/clearance_friction.c - Coulomb friction of joints without clearance: their reactions are multipliers. */
#include <string.h>
#include "mbs/dynamics/clearance_internal.h"
#include "mbs/dynamics/friction.h"

/* Generalised force of joint i for a reaction of 1 N, out (n_u); the state is placed, w->q and w->v written. */
static void rub(lw_clearance_work *w, int i, double *out)
{
    const lw_rough *f = &w->c->rough[i];
    const lw_system *s = &w->c->s;
    double rate = 0.0, scale = s->joint[f->joint].kind == LW_JOINT_REVOLUTE ? 1.0 : s->unit;
    lw_system_measure(s, f->joint, w->q, w->row);
    for (int k = 0; k < s->n_q; k++)
        rate += scale*w->row[k]*w->v[k];
    double push = scale*lw_friction_push(f->coefficient, f->speed, f->arm, rate);
    for (int k = 0; k < s->n_q; k++)
        w->row[k] *= push;
    memset(out, 0, sizeof(double)*(size_t)w->n_u);
    lw_clearance_through_tree(w, w->row, out);
}

/* Reaction of joint i [N] in multipliers l: both rows of a pin, the row across a line */
static lw_vec2 press(const lw_clearance_work *w, int i, const double *l)
{
    bool pin = w->c->s.joint[w->c->rough[i].joint].kind == LW_JOINT_REVOLUTE;
    double unit = w->c->s.unit;
    const double *row = l + w->rough_row[i];
    return lw_v2(row[0]/unit, pin ? row[1]/unit : 0.0);
}

lw_status lw_clearance_friction(lw_clearance_work *w, const double *du, double *ddu)
{
    int n = w->c->n_rough, all = w->n_u + w->n_c;
    double b[LW_SYSTEM_Q_MAX + LW_SYSTEM_ROW_MAX + LW_INPUT_MAX + LW_CLEARANCE_STOP_MAX], size[LW_JOINT_MAX];
    lw_vec2 rest[LW_JOINT_MAX], response[LW_JOINT_MAX*LW_JOINT_MAX];
    lw_tree_write(&w->c->tree, &w->state, du, w->q, w->v);
    for (int k = 0; k < n; k++) {
        memset(b, 0, sizeof(double)*(size_t)all);
        rub(w, k, b);
        lw_clearance_solve_again(w, b, w->response + k*all);
    }
    for (int j = 0; j < n; j++) {
        rest[j] = press(w, j, w->lambda);
        for (int k = 0; k < n; k++)
            response[j + n*k] = press(w, j, w->response + k*all + w->n_u);
    }
    if (lw_friction_presses(n, rest, response, size) != LW_OK) {
        w->undetermined = w->c->rough[0].joint;
        return LW_E_NUMERIC;
    }
    for (int k = 0; k < n; k++) {
        const double *from = w->response + k*all;
        for (int i = 0; i < w->n_u; i++)
            ddu[i] += size[k]*from[i];
        for (int i = 0; i < w->n_c; i++)
            w->lambda[i] += size[k]*from[w->n_u + i];
    }
    return LW_OK;
}
