/* mbs/constraints/mobility.c - conclusions about a linkage from the walks of mobility_drift.c. */
#include "mbs/constraints/mobility.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "mbs/constraints/mobility_internal.h"

#define WALKS     4           /* walks that start at the posture */
#define ATTEMPTS  8           /* first steps that fall back before the linkage counts as shaky */
#define MISFIT    0.05        /* forced displacement of a linkage that cannot move */
#define STILL     1e-7        /* smaller rates or displacements count as 0 */

typedef struct search {
    lw_drift    d;
    lw_system  *s;
    lw_mobility *m;
    double      q0[LW_SYSTEM_Q_MAX];
    double     *block;        /* memory of the following arrays */
    double     *q;            /* (2 WALKS, n_q): the middle and the end of each walk */
    lw_mobility_posture    best, now; /* the posture with most motions; the present posture */
    int         n_q, n_stand;
    bool        moved[LW_LINK_MAX], worked[LW_JOINT_MAX];
} search;

lw_mobility_options lw_mobility_options_default(void)
{
    return (lw_mobility_options){ .tolerance = 1e-12, .seed = 1 };
}

const char *lw_mobility_kind_text(lw_mobility_kind kind)
{
    return kind == LW_MOBILITY_RIGID ? "rigid" : kind == LW_MOBILITY_SHAKY ? "shaky" : "moves";
}

/* ---- moving links and joints --------------------------------------------------------------------- */

/* Velocity of a point when the coordinates move by dq, in units. */
static lw_vec2 velocity(const lw_system *s, int body, lw_vec2 arm, const double *q, const double *dq)
{
    double series[2*LW_SYSTEM_Q_MAX];
    lw_vec2 out[2];
    memcpy(series, q, (size_t)s->n_q*sizeof *q);
    memcpy(series + s->n_q, dq, (size_t)s->n_q*sizeof *q);
    lw_system_point_series(s, body, arm, 1, series, out);
    return lw_v2_scale(out[1], 1/s->unit);
}

/* Does joint j move?  Gears move if the joints of their wheels do. */
static bool works(const lw_system *s, int j, const double *q, const double *dq)
{
    const lw_system_joint *g = &s->joint[j];
    double turn[2];
    lw_vec2 v[2];
    if (lw_joint_has_ratio(g->kind))
        return true;
    for (int end = 0; end < 2; end++) {
        turn[end] = g->body[end] < 0 ? 0 : dq[3*g->body[end] + 2];
        v[end] = velocity(s, g->body[end], g->arm[end], q, dq);
    }
    return fabs(turn[1] - turn[0]) > STILL
        || (!lw_joint_turns(g->kind) && lw_v2_norm(lw_v2_sub(v[1], v[0])) > STILL);
}

/* Mark links and joints that move at a posture. */
static void mark_moving(search *f, const lw_mobility_posture *t)
{
    const lw_system *s = f->s;
    for (int i = 0; i < t->freedom; i++) {
        const double *dq = t->motion + (size_t)i*(size_t)f->n_q;
        for (int b = 0; b < s->n_body; b++)
            f->moved[s->link[b]] |= lw_greatest(3, dq + 3*b) > STILL;
        for (int j = 0; j < s->n_joint; j++)
            f->worked[j] = f->worked[j] || works(s, j, t->q, dq);
    }
}

static void list_still(search *f)
{
    lw_mobility *m = f->m;
    for (int b = 0; b < f->s->n_body; b++)
        if (!f->moved[f->s->link[b]])
            m->still_links |= 1u << f->s->link[b];
    for (int j = 0; j < f->s->n_joint; j++)
        if (!f->worked[j] && lw_joint_has_position(f->s->joint[j].kind))
            m->still_joints |= (uint64_t)1 << j;
}

/* ---- motions that affect inputs and tracers -------------------------------------------------------- */

/* Rows of watched quantities, one column for each of the f->best.freedom motions. */
typedef struct watch { int n_row, n; double *a; } watch;

static void watch_value(watch *w, int column, int row, double v)
{
    w->a[row*w->n + column] = fabs(v) > STILL ? v : 0;
}

static void watch_inputs(const search *f, watch *w)
{
    const lw_system *s = f->s;
    double row[LW_SYSTEM_Q_MAX];
    for (int i = 0; i < s->n_input; i++) {
        lw_system_measure(s, s->input_joint[i], f->best.q, row);
        for (int c = 0; c < w->n; c++) {
            double v = 0;
            for (int k = 0; k < f->n_q; k++)
                v += row[k]*f->best.motion[c*f->n_q + k];
            watch_value(w, c, w->n_row + i, v);
        }
    }
    w->n_row += s->n_input;
}

static void watch_tracers(const search *f, watch *w)
{
    const lw_system *s = f->s;
    for (int i = 0; i < s->n_tracer; i++)
        for (int c = 0; c < w->n; c++) {
            lw_vec2 v = velocity(s, s->tracer_body[i], s->tracer_arm[i], f->best.q, f->best.motion + c*f->n_q);
            watch_value(w, c, w->n_row + 2*i, v.x);
            watch_value(w, c, w->n_row + 2*i + 1, v.y);
        }
    w->n_row += 2*s->n_tracer;
}

/* Watch all bodies except b. */
static void watch_others(const search *f, int b, watch *w)
{
    int n = 0;
    for (int k = 0; k < f->n_q; k++) {
        if (k/3 == b)
            continue;
        for (int c = 0; c < w->n; c++)
            watch_value(w, c, w->n_row + n, f->best.motion[c*f->n_q + k]);
        n++;
    }
    w->n_row += n;
}

/* Rank of the watched rows; *links: links that move while all watched quantities rest. */
static int unseen(search *f, const watch *w, uint32_t *links)
{
    double *null = f->d.null;
    *links = 0;
    /* nothing watched: one row of zeros */
    memset(w->a + w->n_row*w->n, 0, (size_t)w->n*sizeof *w->a);
    int rank = lw_drift_factor(&f->d, w->n_row + 1, w->n, w->a, LW_RANK_ZERO);
    lw_drift_null(&f->d, null);
    for (int i = 0; i < w->n - rank; i++)
        for (int k = 0; k < f->n_q; k++) {
            double v = 0;
            for (int c = 0; c < w->n; c++)
                v += null[i*w->n + c]*f->best.motion[c*f->n_q + k];
            if (fabs(v) > STILL)
                *links |= 1u << f->s->link[k/3];
        }
    return rank;
}

/* Without tracers: links that can move while all others and the inputs stand still. */
static void idle_alone(search *f, watch *w)
{
    for (int b = 0; b < f->s->n_body; b++) {
        uint32_t links;
        w->n_row = 0;
        watch_inputs(f, w);
        watch_others(f, b, w);
        f->m->idle += w->n - unseen(f, w, &links);
        f->m->idle_links |= links;
    }
}

static lw_status find_idle(search *f)
{
    lw_mobility *m = f->m;
    int n = f->best.freedom, rows = f->n_q + LW_DRIFT_EXTRA;
    watch w = { .n = n, .a = calloc((size_t)rows*(size_t)n, sizeof *w.a) };
    if (!w.a)
        return LW_E_MEMORY;
    watch_inputs(f, &w);
    m->driven = unseen(f, &w, &m->loose_links);
    if (f->s->n_tracer > 0) {
        watch_tracers(f, &w);
        m->idle = n - unseen(f, &w, &m->idle_links);
    } else {
        idle_alone(f, &w);
    }
    m->loose_links &= ~m->idle_links;
    free(w.a);
    return LW_OK;
}

/* ---- redundant rows ------------------------------------------------------------------------------- */

/* The joints of the rows `basis` that make up row `row`. */
static uint64_t partners(search *f, const double *jac, const int *basis, int n_basis, int row)
{
    int n = f->n_q;
    uint64_t joints = 0;
    double *a = f->now.motion, x[LW_SYSTEM_Q_MAX];         /* reused for the basis */
    if (n_basis == 0)
        return 0;
    for (int k = 0; k < n_basis; k++)
        memcpy(a + k*n, jac + basis[k]*n, (size_t)n*sizeof *a);
    lw_drift_factor(&f->d, n_basis, n, a, LW_RANK_ZERO);
    lw_rank_solve_transposed(&f->d.rank, jac + row*n, x);
    for (int k = 0; k < n_basis; k++)
        if (fabs(x[k]) > LW_RANK_ZERO)
            joints |= (uint64_t)1 << f->s->row[basis[k]].joint;
    return joints & ~((uint64_t)1 << f->s->row[row].joint);
}

/* Find the rows that depend on earlier rows, in the order of the file. */
static void find_redundant(search *f)
{
    int n = f->n_q, basis[LW_SYSTEM_Q_MAX], n_basis = 0;
    double *square = f->d.null, *jac = f->d.jac;            /* orthonormal basis of the rows so far */
    lw_system_rows(f->s, f->best.q, f->d.phi, jac);
    for (int row = 0; row < f->s->n_row; row++) {
        double v[LW_SYSTEM_Q_MAX], length = 0;
        memcpy(v, jac + row*n, (size_t)n*sizeof *v);
        for (int pass = 0; pass < 2; pass++)               /* twice is enough (Kahan, Parlett) */
            for (int i = 0; i < n_basis; i++) {
                double share = 0;
                for (int k = 0; k < n; k++)
                    share += square[i*n + k]*v[k];
                for (int k = 0; k < n; k++)
                    v[k] -= share*square[i*n + k];
            }
        for (int k = 0; k < n; k++)
            length += v[k]*v[k];
        length = sqrt(length);
        if (length > 10*fmax(LW_RANK_ZERO, 10*f->d.tolerance) && n_basis < f->best.rank) {
            for (int k = 0; k < n; k++)
                square[n_basis*n + k] = v[k]/length;
            basis[n_basis++] = row;
        } else {
            f->m->redundant[f->m->n_redundant++] =
                (lw_redundant){ f->s->row[row], partners(f, jac, basis, n_basis, row) };
        }
    }
}

/* ---- no motion ------------------------------------------------------------------------------------ */

/* Extend the one motion of first order, order by order: J q_k = -(terms of lower order). */
static void find_order(search *f)
{
    enum { TOP = LW_SYSTEM_ORDER_MAX };
    int n = f->n_q, m = f->s->n_row;
    double *series = f->now.motion, *phi = series + (TOP + 1)*n, want[LW_SYSTEM_ROW_MAX];
    memset(series, 0, (size_t)(TOP + 1)*(size_t)n*sizeof *series);
    memcpy(series, f->q0, (size_t)n*sizeof *series);
    lw_drift_rank(&f->d, f->q0, LW_RANK_ZERO);
    memcpy(series + n, f->d.null, (size_t)n*sizeof *series);
    double *jac = f->d.jac;
    f->m->order = 1;
    for (int k = 2; k <= TOP; k++) {
        lw_system_series(f->s, k, series, phi);
        for (int i = 0; i < m; i++)
            want[i] = -phi[k*m + i];
        memcpy(f->d.goal, want, (size_t)m*sizeof *want);
        lw_rank_solve(&f->d.rank, f->d.goal, series + k*n);
        for (int i = 0; i < m; i++) {
            double left = want[i];
            for (int c = 0; c < n; c++)
                left -= jac[i*n + c]*series[k*n + c];
            if (fabs(left) > LW_RANK_ZERO*(1 + lw_greatest(m, want)))
                return;
        }
        f->m->order = k;
    }
}

/* The direction of least resistance, and the residual when the linkage is forced along it. */
static void find_misfit(search *f)
{
    int n = f->n_q, loose = 0;
    double q[LW_SYSTEM_Q_MAX], along[LW_SYSTEM_Q_MAX];
    for (double zero = LW_RANK_ZERO; loose == 0 && zero < 0.1; zero *= 3)
        loose = n - lw_drift_rank(&f->d, f->q0, zero);
    f->m->misfit = NAN;
    if (loose == 0)
        return;
    memcpy(along, f->d.null, (size_t)n*sizeof *along);
    for (int k = 0; k < n; k++)
        q[k] = f->q0[k] + MISFIT*along[k];
    double left = lw_drift_settle(&f->d, f->q0, along, MISFIT, q);
    if (isfinite(left))
        f->m->misfit = left*f->s->unit;
}

/* ---- other dimensions ------------------------------------------------------------------------------ */

/* Move joints at random (joints at one place together), turn slide lines, change ratios. */
static void disturb(lw_linkage *linkage, double size, lw_rng *r)
{
    lw_vec2 old[LW_JOINT_MAX];
    for (int j = 0; j < linkage->n_joint; j++) {
        lw_joint *q = &linkage->joint[j];
        lw_vec2 push = lw_v2_scale(lw_v2(lw_rng_normal(r), lw_rng_normal(r)), 0.3*size);
        old[j] = q->at;
        for (int i = 0; i < j; i++)
            if (lw_v2_norm(lw_v2_sub(old[i], old[j])) <= 1e-9*size)
                push = lw_v2_sub(linkage->joint[i].at, old[i]);
        q->at = lw_v2_add(q->at, push);
        q->along = lw_v2_turn(q->along, lw_v2_polar(1, lw_rng_normal(r)));
        double length = lw_v2_norm(q->along);
        if (length > 0)
            q->along = lw_v2_scale(q->along, 1/length);
        q->ratio *= 1 + 0.3*lw_rng_uniform(r);
    }
}

static void find_generic(search *f, const lw_linkage *linkage, uint64_t seed)
{
    lw_linkage other = *linkage;
    lw_system s;
    double q[LW_SYSTEM_Q_MAX];
    lw_rng r;
    lw_rng_seed(&r, seed, ATTEMPTS);
    disturb(&other, f->s->unit, &r);
    f->m->generic = -1;
    if (lw_system_make(&other, NULL, 0, &s, NULL) == LW_OK) {
        const lw_system *own = f->d.s;
        lw_system_posture(&s, q);
        f->d.s = &s;
        f->m->generic = f->n_q - lw_drift_rank(&f->d, q, LW_RANK_ZERO);
        f->d.s = own;
    }
    lw_system_free(&s);
}

/* ---- the whole analysis --------------------------------------------------------------------------- */

static void keep_best(search *f)
{
    lw_mobility *m = f->m;
    lw_mobility_posture *t = &f->now;
    bool first = f->n_stand++ == 0;
    mark_moving(f, t);
    m->least_freedom = first || t->freedom < m->least_freedom ? t->freedom : m->least_freedom;
    if (first || t->freedom > f->best.freedom || (t->freedom == f->best.freedom && t->rank > f->best.rank)) {
        lw_mobility_posture swap = f->best;
        f->best = *t;
        *t = swap;
    }
}

static void examine_posture(search *f, const double *q)
{
    memcpy(f->now.q, q, (size_t)f->n_q*sizeof *q);
    lw_drift_stand(&f->d, true, &f->now);
    keep_best(f);
}

/* Walk from the posture in different directions, and from each end once more as far. */
static void walk_about(search *f, uint64_t seed)
{
    double q[LW_SYSTEM_Q_MAX];
    for (int attempt = 0, done = 0; attempt < ATTEMPTS && done < WALKS; attempt++) {
        lw_rng r;
        lw_rng_seed(&r, seed, (uint64_t)attempt);
        memcpy(q, f->q0, (size_t)f->n_q*sizeof *q);
        double residual = 0, way = lw_drift_walk(&f->d, &r, q, &residual);
        if (way == 0)
            continue;
        done++;
        examine_posture(f, q);
        way += lw_drift_walk(&f->d, &r, q, &residual);
        examine_posture(f, q);
        f->m->distance = fmax(f->m->distance, way);
        f->m->residual = fmax(f->m->residual, residual*f->s->unit);
    }
}

static lw_status look(search *f, const lw_linkage *linkage, uint64_t seed)
{
    lw_mobility *m = f->m;
    lw_system_posture(f->s, f->q0);
    memcpy(f->best.q, f->q0, (size_t)f->n_q*sizeof *f->q0);
    lw_drift_stand(&f->d, false, &f->best);
    m->posture_rank = m->rank = f->best.rank;
    m->instant = m->along = f->best.first_order;
    m->count = f->n_q - f->s->n_row;
    find_generic(f, linkage, seed);
    if (m->instant > 0)
        walk_about(f, seed);
    m->misfit = 0;
    if (f->n_stand == 0) {
        m->kind = m->instant > 0 ? LW_MOBILITY_SHAKY : LW_MOBILITY_RIGID;
        if (m->instant == 1)
            find_order(f);
        find_misfit(f);
    } else {
        m->kind = LW_MOBILITY_MOVES;
        m->freedom = f->best.freedom;
        m->along = f->best.first_order;
        m->rank = f->best.rank;
        list_still(f);
    }
    find_redundant(f);
    return m->freedom > 0 ? find_idle(f) : LW_OK;
}

lw_status lw_mobility_find(const lw_linkage *linkage, const lw_mobility_options *o, lw_mobility *m, lw_error *e)
{
    static const char memory[] = "out of memory for the mobility of a linkage";
    memset(m, 0, sizeof *m);
    if (!(o->tolerance >= 0 && o->tolerance <= 1e-4))
        return lw_error_set(e, LW_E_ARG, "the tolerance is %g; it must be 0 to 1e-4", o->tolerance);
    lw_system system;
    search f = { .s = &system, .m = m };
    lw_status status = lw_system_make(linkage, NULL, 0, &system, e);
    if (status != LW_OK) {
        lw_system_free(&system);
        return status;
    }
    m->n_body = system.n_body;
    m->n_q = system.n_q;
    m->n_row = system.n_row;
    m->unit = system.unit;
    size_t n = (size_t)f.s->n_q, top = LW_SYSTEM_ORDER_MAX + 1;
    size_t room = 2*n*n + top*(n + (size_t)f.s->n_row);    /* 2 n columns of motions; series in find_order */
    f.n_q = f.s->n_q;
    f.block = calloc(2*(n + room), sizeof *f.block);
    status = lw_drift_create(f.s, o->tolerance, &f.d);
    if (status != LW_OK || !f.block) {
        if (status == LW_OK)
            lw_drift_free(&f.d);
        free(f.block);
        lw_system_free(&system);
        return lw_error_set(e, LW_E_MEMORY, memory);
    }
    f.best = (lw_mobility_posture){ .q = f.block, .motion = f.block + n };
    f.now = (lw_mobility_posture){ .q = f.block + n + room, .motion = f.block + 2*n + room };
    status = look(&f, linkage, o->seed);
    lw_drift_free(&f.d);
    free(f.block);
    lw_system_free(&system);
    return status == LW_OK ? LW_OK : lw_error_set(e, status, memory);
}
