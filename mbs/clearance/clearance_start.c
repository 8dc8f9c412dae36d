/* mbs/clearance/clearance_start.c - places and speeds at t = 0.
 *
 * Without clearance, the posture of the file and the speeds of the inputs determine everything; the reaction of each
 * journal then says where in its bush the pin sits (Makkonen 1999, eqs. 26-27). */
#include <string.h>
#include "base/real.h"
#include "mbs/clearance/clearance_internal.h"

/* Step of central differences along the motion; the error is its square */
#define FLOW_STEP 1e-5

static lw_row_choice closed(const lw_clearance_scene *c, bool all_inputs)
{
    lw_row_choice choice = { 0 };
    for (int i = 0; i < c->n_journal; i++)
        choice.hold[i] = true;
    for (int i = 0; i < c->s.n_input; i++)
        choice.input[i] = all_inputs || c->m->motion[i];
    return choice;
}

lw_status lw_clearance_reaction_rate(lw_clearance_work *w, double t, const double *y, int i, lw_vec2 *f, lw_vec2 *rate)
{
    int n = w->n_u;
    double du0[LW_SYSTEM_Q_MAX], a[LW_SYSTEM_Q_MAX], u[LW_SYSTEM_Q_MAX], du[LW_SYSTEM_Q_MAX], fast = 1/w->o.time;
    lw_vec2 side[2];
    memcpy(du0, y + n, sizeof(double)*(size_t)n);
    lw_status s = lw_clearance_accelerate(w, t, y, du0, a);
    if (s != LW_OK)
        return s;
    *f = lw_clearance_reaction(w, i);
    for (int k = 0; k < n; k++)
        fast = fmax(fast, fabs(du0[k]) + sqrt(fabs(a[k])));
    double h = FLOW_STEP/fast;
    for (int e = 0; e < 2; e++) {
        double d = e ? h : -h, trash[LW_SYSTEM_Q_MAX];
        for (int k = 0; k < n; k++) {
            u[k] = y[k] + d*du0[k] + 0.5*d*d*a[k];
            du[k] = du0[k] + d*a[k];
        }
        if ((s = lw_clearance_accelerate(w, t + d, u, du, trash)) != LW_OK)
            return s;
        side[e] = lw_clearance_reaction(w, i);
    }
    *rate = lw_v2_scale(lw_v2_sub(side[1], side[0]), 0.5/h);
    return LW_OK;
}

/* Place and rate of the pin of journal i in its bush, from the reaction without clearance. */
static lw_status seat(lw_clearance_work *w, const double *y, int i)
{
    const lw_clearance *c = w->c->journal[i].c;
    double unit = w->c->s.unit;
    lw_vec2 f, rate;
    lw_status s = lw_clearance_reaction_rate(w, 0.0, y, i, &f, &rate);
    if (s != LW_OK)
        return s;
    double size = lw_v2_norm(f);
    if (!(size > 0.0))
        return LW_OK;                    /* no force on it: it stays in the middle */
    lw_vec2 n = lw_v2_scale(f, -1.0/size);
    double turn = lw_v2_cross(f, rate)/(size*size), grow = lw_v2_dot(f, rate)/size;
    double depth = c->model == LW_CLEARANCE_LINK ? 0.0 : lw_contact_depth(c, size);
    double exponent = c->model == LW_CLEARANCE_MLSD ? 1.0 : c->exponent;
    double r = c->gap + depth, dr = depth/(exponent*size)*grow;
    w->offset[i] = lw_v2_scale(n, r/unit);
    w->offset_rate[i] = lw_v2_add(lw_v2_scale(n, dr/unit), lw_v2_scale(lw_v2_perp(n), turn*r/unit));
    return LW_OK;
}

static bool is_seated(const lw_clearance_work *w, int i)
{
    lw_clearance_model m = w->c->journal[i].c->model;
    return m == LW_CLEARANCE_LINK || m == LW_CLEARANCE_MLSD
        || (w->o.start == LW_CLEARANCE_SEATED && m != LW_CLEARANCE_ZERO);
}

/* Only the driven links move. */
static lw_status let_follow(lw_clearance_work *w, const lw_row_choice *all, double *u, double *du)
{
    lw_row_choice choice = *all;
    memset(choice.hold, 0, sizeof choice.hold);
    memset(du, 0, sizeof(double)*(size_t)w->n_u);
    return lw_clearance_project(w, &choice, 0.0, u, du);
}

static lw_status begin_closed(lw_clearance_work *w, const lw_row_choice *all, double *u, double *du, lw_error *e)
{
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX] = { 0.0 };
    lw_system_posture(&w->c->s, q);
    lw_tree_read(&w->c->tree, q, v, u, du);
    lw_status s = lw_clearance_project(w, all, 0.0, u, du);
    if (s != LW_OK)
        lw_error_set(e, s, "the linkage has no posture near the drawn one that fits its joints and inputs at t = 0");
    return s;
}

lw_status lw_clearance_begin(lw_clearance_work *w, double *u, double *du, lw_error *e)
{
    const lw_clearance_scene *c = w->c;
    lw_row_choice all = closed(c, true), run = w->rows;
    lw_status s = begin_closed(w, &all, u, du, e);
    if (s != LW_OK)
        return s;
    bool any = false;
    double *y = w->y;
    memcpy(y, u, sizeof(double)*(size_t)w->n_u);
    memcpy(y + w->n_u, du, sizeof(double)*(size_t)w->n_u);
    w->rows = closed(c, false);
    for (int i = 0; s == LW_OK && i < c->n_journal; i++)
        if (is_seated(w, i)) {
            any = true;
            s = seat(w, y, i);
        }
    if (s == LW_OK && any)
        s = lw_clearance_project(w, &all, 0.0, u, du);
    w->rows = run;
    if (s == LW_OK && w->o.start == LW_CLEARANCE_CRANK)
        s = let_follow(w, &all, u, du);
    if (s != LW_OK)
        return lw_error_set(e, s, "the pins cannot be seated in their bushes at the start: %s", lw_status_text(s));
    lw_tree_place(&c->tree, u, du, &w->state);
    for (int i = 0; i < c->n_journal; i++) {
        lw_play p = lw_clearance_play(w, i, du);
        double r = lw_v2_norm(p.d);
        w->phase[i] = lw_contact_phase_at(c->journal[i].c, r*c->s.unit - c->journal[i].c->gap);
        w->struck[i] = r > 0.0 ? fabs(lw_v2_dot(p.d, p.rate))/r*c->s.unit : 0.0;
        w->offset[i] = w->offset_rate[i] = lw_v2(0.0, 0.0);
    }
    return LW_OK;
}
