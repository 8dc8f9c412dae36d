#include "optimise/problem/work.h"

#include <string.h>

/* Take the next 64-byte aligned piece of memory; base NULL: count only. */
static void *piece(char *base, size_t *at, size_t bytes)
{
    size_t here = *at;
    *at = (*at + bytes + 63) & ~(size_t)63;
    return base ? base + here : NULL;
}

/* Lay out the lanes of one point, with the turn of its link if requested. */
static void lay_out_lanes(const lw_problem *p, size_t ld, bool turn, lw_jacobian *j, char *base, size_t *at)
{
    double **each[] = { &j->x, &j->y, &j->u, &j->v, &j->margin, &j->tx, &j->ty, &j->tt };
    for (size_t i = 0; i < sizeof each/sizeof *each; i++)
        *each[i] = piece(base, at, ld*sizeof(double));
    j->jx = piece(base, at, ld*sizeof(double)*(size_t)p->n_dim);
    j->jy = piece(base, at, ld*sizeof(double)*(size_t)p->n_dim);
    j->jt = turn ? piece(base, at, ld*sizeof(double)*(size_t)p->n_dim) : NULL;
    j->ld = ld;
    if (!turn)
        j->tt = NULL;
}

static size_t lay_out(const lw_problem *p, lw_work *w, char *base)
{
    size_t at = (sizeof *w + 63) & ~(size_t)63;
    size_t lanes = lw_problem_lane_count(p), ld = (lanes + 7) & ~(size_t)7, v = sizeof(double);
    size_t m = LW_CURVE_SAMPLES;
    w->n_lane = lanes;
    w->ld = ld;
    w->n_row = lw_problem_component_count(p);
    double **lane_arrays[] = { &w->phase, &w->input, &w->rate, &w->normal_x, &w->normal_y,
                               &w->by_input, &w->c, &w->s, &w->around, &w->psi_c, &w->psi_s };
    for (size_t i = 0; i < sizeof lane_arrays/sizeof *lane_arrays; i++)
        *lane_arrays[i] = piece(base, &at, ld*v);
    lay_out_lanes(p, ld, p->theta, &w->jac, base, &at);
    for (int k = 0; k < p->n_also; k++) {
        lw_also_work *a = &w->also[k];
        lay_out_lanes(p, ld, p->also[k].theta, &a->jac, base, &at);
        double **curve[] = { &a->curve_x, &a->curve_y, &a->curve_u, &a->curve_v };
        for (size_t i = 0; i < sizeof curve/sizeof *curve; i++)
            *curve[i] = piece(base, &at, m*v);
    }
    size_t dyads = (size_t)(p->plan.n_dyad > 0 ? p->plan.n_dyad : 1);
    w->mode = piece(base, &at, ld*v*dyads);
    w->turn_mode = piece(base, &at, m*v*dyads);
    w->leg = piece(base, &at, ld*sizeof *w->leg);
    w->row = piece(base, &at, ld*v*(size_t)(w->n_row*p->n_var));
    w->res = piece(base, &at, ld*v*(size_t)w->n_row);
    w->base_res = piece(base, &at, ld*v*(size_t)w->n_row);
    w->tangent = piece(base, &at, ld*v*(size_t)w->n_row);
    w->tangent2 = piece(base, &at, ld*v);
    w->block = piece(base, &at, p->n*sizeof *w->block);
    double **curve[] = { &w->turn_c, &w->turn_s, &w->curve_x, &w->curve_y, &w->curve_m,
                         &w->curve_u, &w->curve_v,
                         &w->foot_x, &w->foot_y, &w->turn, &w->check_c, &w->check_s };
    for (size_t i = 0; i < sizeof curve/sizeof *curve; i++)
        *curve[i] = piece(base, &at, m*v);
    w->check_at = piece(base, &at, m*sizeof *w->check_at);
    w->place_x = piece(base, &at, p->n_zone > 0 ? LW_PLACE_MAX*m*v : 0);
    w->place_y = piece(base, &at, p->n_zone > 0 ? LW_PLACE_MAX*m*v : 0);
    size_t postures = ld > m ? ld : m, g = lw_problem_constraint_most(p) + 1;
    double **posture[] = { &w->posture_c, &w->posture_s, &w->posture_x, &w->posture_y, &w->posture_u, &w->posture_v,
                           &w->posture_m, &w->posture.x, &w->posture.y, &w->posture.u, &w->posture.v,
                           &w->posture.margin };
    for (size_t i = 0; i < sizeof posture/sizeof *posture; i++)
        *posture[i] = piece(base, &at, postures*v);
    w->posture.jx = piece(base, &at, postures*v*(size_t)p->n_dim);
    w->posture.jy = piece(base, &at, postures*v*(size_t)p->n_dim);
    w->posture.jt = w->posture.tt = NULL;
    w->posture.ld = postures;
    for (int i = 0; i < 4; i++)
        w->slope[i] = piece(base, &at, postures*v*(size_t)(p->n_dim + 1));
    w->g_now = piece(base, &at, g*v);
    w->g_try = piece(base, &at, g*v);
    size_t variables = (size_t)p->n_var;                /* for all conditions that a search may add later */
    w->g_row = piece(base, &at, g*variables*v);
    w->g_try_row = piece(base, &at, g*variables*v);
    w->step_a = piece(base, &at, (2*variables + (size_t)p->n_linear + g)*variables*v);
    w->step_b = piece(base, &at, (2*variables + (size_t)p->n_linear + g)*v);
    w->step_first = piece(base, &at, (2*variables + (size_t)p->n_linear + 1)*sizeof *w->step_first);
    w->step_column = piece(base, &at, (2 + (size_t)p->n_linear)*variables*sizeof *w->step_column);
    w->step_h = piece(base, &at, 4*variables*variables*v);
    w->cost = piece(base, &at, p->n*LW_COST_ROW*v);
    w->least = piece(base, &at, p->n*LW_COST_ROW*v);
    w->order = piece(base, &at, 2*p->n*sizeof(short));
    w->try_theta = piece(base, &at, 3*ld*v);
    w->pool = piece(base, &at, 3*ld*v);
    w->slide = piece(base, &at, ld*v*(size_t)p->n_var);
    w->keep_theta = piece(base, &at, ld*v);
    w->best_theta = piece(base, &at, ld*v);
    w->slip = piece(base, &at, ld*v);
    w->tie = piece(base, &at, ld*sizeof(bool));
    w->registers = piece(base, &at, 2*(size_t)p->plan.n_reg*m*v);
    w->batch = piece(base, &at, lw_batch_work_size(&p->plan));
    return at;
}

size_t lw_problem_work_size(const lw_problem *p)
{
    lw_work w;
    return lay_out(p, &w, NULL);
}

void lw_problem_work_init(const lw_problem *p, void *work)
{
    lw_work *w = work;
    memset(work, 0, lay_out(p, w, NULL));         /* lanes beyond the last stay zero in sums        */
    lay_out(p, w, work);
    lw_problem_work_intended(p, w);
}

void lw_problem_work_intended(const lw_problem *p, lw_work *w)
{
    for (int j = 0; j < LW_CURVE_SAMPLES; j++) {
        w->turn[j] = 2*LW_PI*(j + (p->intended.turns ? 0 : 0.5))/LW_CURVE_SAMPLES;
        w->turn_c[j] = cos(w->turn[j]);
        w->turn_s[j] = sin(w->turn[j]);
    }
    w->least_margin = lw_problem_has_modes(p) ? -1e-9 : 0;
    w->swing.known = false;
}
