/* mbs/formulations/ggl.c - stabilised index 2 (Gear, Gupta & Leimkuhler 1985), by IDA:
 *
 *     G^-1 q' = v - W J^T m,   M v' = Q - J^T l,   0 = Phi(t, q),   0 = J v - (prescribed rates)
 *
 * W = 1/M keeps both equations in one metric; J has the kept rows.  In space G^-1 gives three rates from the four of a
 * quaternion p, whose length has a row p p = 1 of its own.  Friction uses the multipliers of the state.  y = (q, v, l, m, work,
 * z); the rows come in the same order, those of quaternions after the n_v rows of q'. */
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"
#include "mbs/dynamics/tangent_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/sparse_lu.h"
#include "mbs/ode/ida.h"

/* Absolute tolerance of the multipliers: no error test.  Rounding in q and v reaches them times mass over step; with
 * short steps, masses of different size or large units Newton's method would not converge by them. */
static const double unjudged = 1e300;
static const long worth_restart = 20;                /* steps after which a restart is worth trying */

typedef struct ggl {
    lw_run *run;
    int    q, v, c;                          /* coordinates, velocities, kept rows */
    double least_mass;
    int    *at, *n_at;                       /* in space (4 v), (v): the coordinates that velocity i moves, */
    double *by;                              /* (4 v) and the column of G over the square of its length */
    lw_sundials *ida;
    double *dense;                           /* (n of IDA) scratch */
    unsigned char *algebraic;                /* (n of IDA) */
    double *each;                            /* absolute tolerances */
    lw_columns columns;                      /* pattern of the Jacobian; n 0: it is found by differences */
    double *value;                           /* its entries while they are filled */
    int    *pair;                            /* entries while the pattern is listed */
    long   n_pair, most_pair;
    bool   failed;                           /* no memory for the pairs */
    long   since;                            /* number of steps at the last start */
} ggl;

static double mass_of(const ggl *g, int i) { return fmax(g->run->d->eq.mass[i], g->least_mass); }

/* J^T l of the kept rows. */
static void push(const lw_dynamics *d, const double *l, double *out)
{
    memset(out, 0, (size_t)d->n_v*sizeof *out);
    lw_tangent_push(d, l, out);
}

/* Friction for the multipliers l of the kept rows counts among the forces. */
static double add_friction(lw_dynamics *d, const double *q, const double *v, const double *l)
{
    double power = 0;
    for (int f = 0; f < d->n_friction; f++) {
        const lw_system_joint *j = &d->s.joint[d->friction[f].joint];
        int x = d->place[j->row], y = lw_joint_turns(j->kind) ? d->place[j->row + 1] : -1;
        power += lw_friction_force(&d->s, &d->friction[f], q, v, hypot(x < 0 ? 0 : l[x], y < 0 ? 0 : l[y])/d->s.unit, d->force);
    }
    return power;
}

/* Columns of G at q. */
static void find_columns(ggl *g, const double *q)
{
    const lw_equations *eq = &g->run->d->eq;
    for (int i = 0; i < g->v && eq->column; i++) {
        double *by = g->by + 4*i, square = 0;
        g->n_at[i] = eq->column(eq->context, q, i, g->at + 4*i, by);
        for (int k = 0; k < g->n_at[i]; k++)
            square += by[k]*by[k];
        for (int k = 0; k < g->n_at[i]; k++)
            by[k] /= square;
    }
}

/* The row of G^-1 that gives velocity i from rates of coordinates. */
static double velocity_of(const ggl *g, int i, const double *dq)
{
    double sum = g->at ? 0 : dq[i];
    for (int k = 0; g->at && k < g->n_at[i]; k++)
        sum += g->by[4*i + k]*dq[g->at[4*i + k]];
    return sum;
}

/* First coordinate of a quaternion that velocity i begins; -1: none does. */
static int quaternion_at(const ggl *g, int i) { return g->at && i%LW_BLOCK == 0 && g->n_at[i] == 4 ? g->at[4*i] : -1; }

static lw_status residual(void *context, double t, const double *y, const double *dy, double *r)
{
    ggl *g = context;
    lw_dynamics *d = g->run->d;
    int n = g->q, c = g->c, first = n + g->v;
    const double *q = y, *v = y + n, *l = y + first, *m = l + c;
    double power = 0;
    lw_status s = lw_run_busy(g->run, t);
    int work = first + 2*c, z = work + g->run->has_work;
    d->eq.place_states(d->eq.context, y + z);
    if (s == LW_OK)
        s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_rate_wanted(d, t);
    if (s != LW_OK)
        return s;
    d->eq.forces(d->eq.context, t, q, v, d->force, &power);
    power += add_friction(d, q, v, l);
    push(d, m, d->bias);
    find_columns(g, q);
    for (int i = 0, norm = g->v; i < g->v; i++) {
        int p = quaternion_at(g, i);
        r[i] = velocity_of(g, i, dy) - v[i] + d->bias[i]/mass_of(g, i);
        if (p >= 0)
            r[norm++] = q[p]*q[p] + q[p + 1]*q[p + 1] + q[p + 2]*q[p + 2] + q[p + 3]*q[p + 3] - 1;
    }
    push(d, l, d->bias);
    for (int i = 0; i < g->v; i++)
        r[n + i] = d->eq.mass[i]*dy[n + i] - d->force[i] + d->bias[i];
    for (int k = 0; k < c; k++) {
        int row = d->kept[k];
        double rate = lw_mbs_row_rate(d, row, v) - d->rhs[row];
        r[first + k] = d->phi[row];
        r[first + c + k] = rate;
        if (row >= d->n_row)
            power -= l[k]*d->rhs[row];
    }
    if (g->run->has_work)
        r[work] = dy[work] - power;
    if (d->eq.n_z)
        s = lw_mbs_state_rates(d, t, q, v, r + z);
    for (int i = 0; i < d->eq.n_z; i++)
        r[z + i] = dy[z + i] - r[z + i];
    return s;
}

/* ---- derivatives of the residual ----------------------------------------------------------------- */

/* Number of unknowns. */
static int unknowns(const ggl *g) { return g->q + g->v + 2*g->c + g->run->has_work + g->run->d->eq.n_z; }

/* Add x to entry (row, column) of the pattern; before there is one, list the entry. */
static void put(ggl *g, double *jac, int row, int column, double x)
{
    if (g->columns.at) {
        jac[lw_columns_find(&g->columns, row, column)] += x;
        return;
    }
    if (g->n_pair == g->most_pair) {
        long most = 2*g->most_pair + 4096;
        int *more = realloc(g->pair, 2*(size_t)most*sizeof *more);
        g->failed = g->failed || !more;
        if (!more)
            return;
        g->pair = more;
        g->most_pair = most;
    }
    g->pair[2*g->n_pair] = row;
    g->pair[2*g->n_pair++ + 1] = column;
}

/* Add the derivative x by a displacement along velocity i. */
static void put_moved(ggl *g, double *jac, int row, int i, double x)
{
    if (!g->at)
        put(g, jac, row, i, x);
    for (int k = 0; g->at && k < g->n_at[i]; k++)
        put(g, jac, row, g->at[4*i + k], x*g->by[4*i + k]);
}

/* Derivatives of the forces. */
static void put_force(void *context, int row, int column, double by_q, double by_v)
{
    ggl *g = context;
    put_moved(g, g->value, g->q + row, column, -by_q);
    put(g, g->value, g->q + row, g->q + column, -by_v);
}

/* Derivatives of and by states: rows and columns as in lw_force_sink. */
static void put_state(void *context, int row, int column, double by_q, double by_v)
{
    ggl *g = context;
    int z = g->q + 2*g->c + g->run->has_work, to = row < g->v ? g->q + row : z + row;
    if (column >= g->v)
        put(g, g->value, to, z + column, -by_q);
    else {
        put_moved(g, g->value, to, column, -by_q);
        put(g, g->value, to, g->q + column, -by_v);
    }
}

/* Add the part of kept row k and its multipliers. */
static void add_row_derivatives(ggl *g, int k, const double *y, double *jac)
{
    const lw_dynamics *d = g->run->d;
    int n = g->q, c = g->c, first = n + g->v, row = d->kept[k];
    const double *v = y + n;
    double l = y[first + k], m = y[first + c + k];
    const int *block = lw_mbs_blocks(d, row);
    const lw_bend *each = d->bend;
    for (int b = 0; b < d->eq.n_slot && block[b] >= 0; b++)
        for (int k0 = 0; k0 < 3; k0++) {
            int i = LW_BLOCK*block[b] + k0;
            double x = lw_mbs_jac(d, row)[LW_BLOCK*b + k0];
            put(g, jac, i, first + c + k, x/mass_of(g, i));
            put(g, jac, n + i, first + k, x);
            put_moved(g, jac, first + k, i, x);
            put(g, jac, first + c + k, n + i, x);
        }
    for (int e = lw_mbs_bends(d, row) - 1; e >= 0; e--) {
        int a = each[e].a, b = each[e].b;
        put_moved(g, jac, a, b, m*each[e].h/mass_of(g, a));
        put_moved(g, jac, n + a, b, l*each[e].h);
        put_moved(g, jac, first + c + k, b, each[e].h*v[a]);
    }
}

/* Add the part of the rows of q' and of quaternions.  The rates that G^-1 gives are p x p', so that their derivative by p is that
 * by p' with p' for p and the other sign. */
static void add_rates(ggl *g, double c, const double *y, const double *dy, double *jac)
{
    const lw_equations *eq = &g->run->d->eq;
    for (int i = 0, norm = g->v; i < g->v; i++) {
        int p = quaternion_at(g, i), at[4], n = 0;
        double by[4];
        put_moved(g, jac, i, i, c);
        put(g, jac, i, g->q + i, -1);
        if (g->at && g->n_at[i] == 4)
            n = eq->column(eq->context, dy, i, at, by);
        for (int k = 0; k < n; k++)
            put(g, jac, i, at[k], -4*by[k]);
        for (int k = 0; p >= 0 && k < 4; k++)
            put(g, jac, norm, p + k, 2*y[p + k]);
        norm += p >= 0;
    }
}

/* The row of the work is left out: nothing depends on it, so Newton's method finds the work one pass later. */
static lw_status jacobian(void *context, double t, double c, const double *y, const double *dy, double *jac)
{
    ggl *g = context;
    lw_dynamics *d = g->run->d;
    int n = g->q, work = g->q + g->v + 2*g->c, last = unknowns(g) - 1;
    d->eq.place_states(d->eq.context, y + work + g->run->has_work);
    lw_status s = lw_mbs_rows(d, t, y);
    if (s != LW_OK)
        return s;
    g->value = jac;
    find_columns(g, y);
    d->eq.derivatives(d->eq.context, t, y, y + n, d->force, &(lw_force_sink){ g, put_force, put_state });
    add_rates(g, c, y, dy, jac);
    for (int i = 0; i < g->v; i++)
        put(g, jac, n + i, n + i, c*d->eq.mass[i]);
    for (int k = 0; k < g->c; k++)
        add_row_derivatives(g, k, y, jac);
    for (int i = work; i <= last; i++)                    /* work and states */
        put(g, jac, i, i, c);
    return LW_OK;
}

/* List the entries that the Jacobian can have. */
static lw_status find_pattern(ggl *g)
{
    lw_dynamics *d = g->run->d;
    int n = g->q, first = n + g->v, last = unknowns(g) - 1;
    g->columns.n = last + 1;
    find_columns(g, d->start_q);
    d->eq.pattern(d->eq.context, &(lw_force_sink){ g, put_force, put_state });
    add_rates(g, 1, d->start_q, d->start_q, NULL);
    for (int i = 0; i < g->v; i++)
        put(g, NULL, n + i, n + i, 1);
    for (int k = 0; k < g->c; k++) {
        const int *block = lw_mbs_blocks(d, d->kept[k]);
        int l = first + k, m = l + g->c;
        for (int b = 0; b < d->row_size && block[b/LW_BLOCK] >= 0; b++) {
            int i = LW_BLOCK*block[b/LW_BLOCK] + b%LW_BLOCK;
            put(g, NULL, i, m, 1);
            put(g, NULL, n + i, l, 1);
            put_moved(g, NULL, l, i, 1);
            put_moved(g, NULL, m, i, 1);
            put(g, NULL, m, n + i, 1);
            for (int c = 0; c < d->row_size && block[c/LW_BLOCK] >= 0; c++) {
                put_moved(g, NULL, i, LW_BLOCK*block[c/LW_BLOCK] + c%LW_BLOCK, 1);
                put_moved(g, NULL, n + i, LW_BLOCK*block[c/LW_BLOCK] + c%LW_BLOCK, 1);
            }
        }
    }
    for (int i = first + 2*g->c; i <= last; i++)
        put(g, NULL, i, i, 1);
    bool ok = !g->failed && lw_columns_make(&g->columns, last + 1, g->pair, g->n_pair);
    free(g->pair);
    g->pair = NULL;
    return ok ? LW_OK : lw_error_set(g->run->e, LW_E_MEMORY, "out of memory");
}

/* The state as other formulations have it: q, v, work, z. */
static void unpack(const ggl *g, const double *y, double *out)
{
    int n = g->q + g->v;
    memcpy(out, y, (size_t)n*sizeof *out);
    memcpy(out + n, y + n + 2*g->c, (size_t)(g->run->has_work + g->run->d->eq.n_z)*sizeof *out);
}

/* The state at t, within the last step of IDA. */
static lw_status state_at(void *context, double t, double *state)
{
    ggl *g = context;
    lw_status s = lw_sundials_dense(g->ida, t, g->dense);
    if (s != LW_OK)
        return s;
    unpack(g, g->dense, state);
    return lw_run_correct(g->run, t, state);
}

static lw_status kink_ahead(void *context, double t, const double *y, double *ahead)
{
    ggl *g = context;
    unpack(g, y, g->dense);
    *ahead = lw_run_kink_ahead(g->run, t, g->dense);
    return LW_OK;
}

/* y and dy for the state (q, v, work, z), which satisfies the constraints. */
static lw_status pack(const ggl *g, double t, const double *state, double *y, double *dy)
{
    lw_dynamics *d = g->run->d;
    int n = g->q, c = g->c, first = n + g->v;
    double power = 0;
    memcpy(y, state, (size_t)first*sizeof *y);
    d->eq.rates(d->eq.context, state, state + n, dy);
    memset(y + first, 0, 2*(size_t)c*sizeof *y);
    memset(dy + first, 0, 2*(size_t)c*sizeof *dy);
    int z = first + 2*c + g->run->has_work;
    memcpy(y + z, state + lw_run_states(g->run), (size_t)d->eq.n_z*sizeof *y);
    d->eq.place_states(d->eq.context, y + z);
    lw_status s = lw_mbs_accelerate(d, t, state, state + n, dy + n, d->l, &power);
    if (s == LW_OK && d->eq.n_z)
        s = lw_mbs_state_rates(d, t, state, state + n, dy + z);
    for (int k = 0; k < c; k++)
        y[first + k] = d->l[d->kept[k]];
    for (int i = 0; s == LW_OK && i < d->n_driven; i++) {
        double motion[3];
        s = lw_mbs_motion(d, i, t, motion);
        power -= d->l[d->n_row + i]*motion[1];
    }
    if (g->run->has_work) {
        y[first + 2*c] = state[first];
        dy[first + 2*c] = power;
    }
    return s;
}

/* Begin again at (t, state) with the rows that are kept now. */
static lw_status begin_again(ggl *g, lw_sundials *w, double t, double *y, double *dy)
{
    lw_run *run = g->run;
    w->t = t;
    lw_status s = lw_run_project(run, t, run->state);
    if (s == LW_OK && run->d->n_kept != g->c)
        s = LW_E_NUMERIC;
    if (s == LW_OK)
        s = pack(g, t, run->state, y, dy);
    g->since = w->n_step;
    return s == LW_OK ? lw_ida_restart(w, y, dy, run->e) : s;
}

/* Begin again at the present state, at first order and with the multipliers of the posture. */
static lw_status after_failure(ggl *g, lw_sundials *w, double *y, double *dy)
{
    g->run->e->text[0] = '\0';
    unpack(g, w->y, g->run->state);
    return begin_again(g, w, w->t, y, dy);
}

/* Square of the distance of the kept rows from dependence; 1 where no other rows exist.  lw_mbs_factor does not give
 * it: with massless links it looks at all rows. */
static double apart(const lw_dynamics *d)
{
    lw_rank r;
    if (d->n_c == d->rank)
        return 1;
    lw_rank_place(&r, d->n_v, d->n_kept, d->rank_work, d->rank_ints);
    for (int k = 0; k < d->n_kept; k++)
        lw_mbs_row(d, d->kept[k], r.a + k*d->n_v);
    lw_rank_factor(&r, LW_RANK_TOLERANCE);
    return r.rank < d->n_kept ? 0 : r.weakest*r.weakest;
}

/* Pass through the singular posture ahead, if there is one.  Choose other rows where the kept ones have become
 * nearly dependent. */
static lw_status pass_singular(ggl *g, lw_sundials *w, double *y, double *dy)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    double t = w->t, weak;
    unpack(g, w->y, run->state);
    if (d->large)                            /* the solver steps over its singular postures, or ends there */
        return LW_OK;
    lw_status s = lw_mbs_rows(d, t, run->state);
    weak = apart(d);
    bool chosen = s == LW_OK && (s = lw_run_rechoose(run, t, run->state, &weak)) == LW_OK;
    if (s >= 0)
        s = lw_mbs_factor(d, false);
    if (s != LW_OK)
        return s == LW_OPEN ? LW_OK : s;
    weak = d->weak;
    if (s >= 0 && (s = lw_run_singular_crossing(run, weak, NULL, &t, run->state)) == LW_OK && t < d->o.to) {
        s = lw_mbs_arrange(d, t, run->state);
        chosen = true;
    }
    if (s == LW_OK && t >= d->o.to)
        w->t = t;
    return s >= 0 && chosen && t < d->o.to ? begin_again(g, w, t, y, dy) : s == LW_NOTHING ? LW_OK : s;
}

/* Start the run.  dae, algebraic and g->each must outlive w. */
static lw_status begin(ggl *g, lw_sundials *w, const lw_dae *dae, double *y, double *dy)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    lw_dynamics_start(d, run->state, run->state + g->q);
    memcpy(run->state + lw_run_states(run), d->start_z, (size_t)d->eq.n_z*sizeof *y);
    lw_status s = pack(g, d->o.from, run->state, y, dy);
    if (s == LW_OK)
        s = lw_run_begin(run, run->state);
    lw_ode_options o = lw_ode_options_default();
    double absolute = lw_run_bdf_tolerance(d->o.absolute);
    o.relative = lw_run_bdf_tolerance(d->o.relative);
    o.absolute_each = g->each;
    for (int i = 0; i < dae->n; i++)
        g->each[i] = dae->algebraic[i] ? unjudged : absolute;
    for (int i = 0; i < d->eq.n_z; i++)
        g->each[dae->n - d->eq.n_z + i] *= d->eq.state_scale(d->eq.context, i);
    o.max_step = lw_run_steps_left(run);
    o.order = d->elastic ? 2 : 0;            /* higher orders are not stable for vibrations without damping */
    o.first = 1e-6*(d->o.to - d->o.from);    /* shorter first steps make Newton's matrix singular */
    return s == LW_OK ? lw_ida_make(w, dae, &o, d->o.from, y, dy, run->e) : s;
}

static lw_status run_ida(ggl *g, lw_sundials *w, double *y, double *dy)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    unsigned char *algebraic = g->algebraic;
    memset(algebraic + g->q + g->v, 1, 2*(size_t)g->c);
    lw_dae dae = { .n = unknowns(g), .context = g, .residual = residual,
                   .jacobian = lw_mbs_has_derivatives(d) ? jacobian : NULL, .algebraic = algebraic, .pattern = g->columns.n ? &g->columns : NULL,
                   .n_event = run->kinks != NULL, .event = kink_ahead, .direction = { -1 } };
    lw_ode_stop stop = LW_ODE_STEP;
    lw_status s = begin(g, w, &dae, y, dy);
    if (s != LW_OK)
        return s;
    long n_hidden = 0;
    for (long k = 1; s == LW_OK && stop != LW_ODE_END; k++) {
        double from = w->t;
        s = lw_sundials_step(w, lw_run_near(run, w->t), &stop, run->e);
        run->r->t = w->t;
        if (s == LW_E_NUMERIC && w->n_step > g->since + worth_restart) {
            s = after_failure(g, w, y, dy);
            stop = LW_ODE_STEP;
            continue;
        }
        if (s != LW_OK)
            break;
        bool kink = stop == LW_ODE_EVENT;
        stop = lw_run_stop(run, w->t, kink ? LW_ODE_STEP : stop);
        unpack(g, w->y, run->y);
        s = lw_run_check_rounding(run, w->t - from, run->y, &n_hidden);
        if (s != LW_OK)
            break;
        if (d->eq.accept)
            d->eq.accept(d->eq.context, run->y);
        lw_run_watch(run, run->y);
        s = lw_run_jumps(run, w->t, run->y);
        if (s == LW_OK)
            s = lw_run_samples(run, w->t, state_at, g);
        if (s == LW_OK)
            s = lw_run_limits(run, w->t, k);
        if (s == LW_OK && lw_run_at_kink(run, w->t)) {
            unpack(g, w->y, run->state);
            s = lw_run_pass_kink(run, &w->t, state_at, g);
            stop = lw_run_stop(run, w->t, LW_ODE_STEP);
            if (s == LW_OK && stop != LW_ODE_END)
                s = begin_again(g, w, w->t, y, dy);
        }
        if (s == LW_OK && stop != LW_ODE_END) {
            unpack(g, w->y, run->state);
            if (lw_run_pass_kinks(run, w->t, run->state, kink))
                s = begin_again(g, w, w->t, y, dy);
        }
        if (s == LW_OK && stop != LW_ODE_END) {
            s = pass_singular(g, w, y, dy);
            stop = lw_run_stop(run, w->t, stop);
        }
    }
    run->r->steps += w->n_step;
    run->r->refused += w->n_refused;
    run->r->rates += w->n_rate;
    if (s == LW_E_NUMERIC)
        unpack(g, w->y, run->state);
    lw_sundials_free(w);
    if (s == LW_E_NUMERIC)
        s = lw_run_hand_over(run, run->state);
    size_t said = strlen(run->e->text);
    if (s == LW_E_NUMERIC && d->space && !run->r->gave_up)
        snprintf(run->e->text + said, sizeof run->e->text - said, " ggl does not pass singular postures of models in space; if this is "
                 "one, leave the formulation to auto, or take recursive or index1");
    return s;
}

static lw_status run_ggl(lw_run *run)
{
    lw_dynamics *d = run->d;
    ggl g = { .run = run, .q = d->n_q, .v = d->n_v, .c = d->n_kept };
    lw_sundials w = { 0 };
    for (int i = 0; i < d->n_v; i++)
        g.least_mass = fmax(g.least_mass, 1e-3*d->eq.mass[i]);
    size_t n = (size_t)(g.q + g.v + 2*g.c) + 1 + (size_t)d->eq.n_z, columns = d->eq.column ? (size_t)g.v : 0;
    double *y = calloc(3*n + 2*(size_t)run->n + 4*columns, sizeof *y);
    g.algebraic = calloc(n, 1);
    g.at = columns ? calloc(5*columns, sizeof *g.at) : NULL;
    lw_status s = y && g.algebraic && (g.at || !columns) ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        run->y = y + 2*n;
        run->state = run->y + run->n;
        g.each = run->state + run->n;
        g.by = g.each + n;
        g.n_at = g.at + 4*columns;
        g.ida = &w;
        g.dense = y;
        if (lw_mbs_has_derivatives(d))
            s = find_pattern(&g);
    }
    if (s == LW_OK)
        s = run_ida(&g, &w, y, y + n);
    free(y);
    free(g.at);
    free(g.algebraic);
    lw_columns_free(&g.columns);
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    if (d->space && (!asked || d->n_friction || d->eq.next_piece))
        return lw_formulation_say(r, LW_E_KIND, 0, "in space it is taken where it is asked for, and knows no friction or contacts");
    if (d->touch)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no contacts");
    if (d->large && !lw_mbs_has_derivatives(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "a model of this size with gears, friction, tied inputs, driven sliders or "
                                  "forces of the caller's has no sparse derivatives");
    if (d->large)
        return lw_formulation_say(r, LW_OK, d->n_q + d->n_v + 2*d->n_kept, asked ? "asked for"
                                  : "dampers make the equations stiff: an implicit method with sparse derivatives");
    if (!asked && !lw_mbs_suits_ggl(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "it is taken for stiff dampers and where it is asked for");
    if (!asked)
        return lw_formulation_say(r, LW_OK, d->n_q + d->n_v + 2*d->n_kept,
                                  "dampers make the equations stiff: an implicit method with exact derivatives");
    return d->n_stop ? lw_formulation_say(r, LW_E_KIND, 0, "it knows no rigid stops; give them a \"stiffness\"")
                     : lw_formulation_say(r, LW_OK, d->n_q + d->n_v + 2*d->n_kept, "asked for");
}

const lw_formulation_row lw_formulation_ggl = { able, run_ggl };
