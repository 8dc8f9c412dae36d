/* mbs/space/space_mobility.c - freedoms of a spatial model.
 *
 * The model is displaced along a random motion of first order and its joints are closed again, by least squares, as the
 * rows may depend on each other.  If they close in another posture, the model moves, and the rank there is that of the
 * motion; if they close only where it was, it is shaky.  Where rows depend on others, motions of first order may be shaky along the whole
 * motion (Wren's platform on a hyperboloid of legs), which their second order tells.  Large models each of whose rows is clearly independent of the others or
 * dependent on them are solved without full matrices: all rows hold where the independent ones lead. */
#include "mbs/space/space_mobility.h"

#include <stdlib.h>
#include <string.h>
#include "base/rng.h"
#include "base/vector.h"
#include "mbs/space/space_idle.h"

void lw_space_mobility_free(lw_space_mobility *m)
{
    free(m->redundant), free(m->idle_link);
    memset(m, 0, sizeof *m);
}

typedef struct search {
    const lw_space *s;
    lw_space_rows_set z;
    lw_space_dense d;
    double *q, *moved, *by, *v, *b;          /* moved: a posture that closes beside that of the file */
    double least;                /* diagonal of a factorisation below which a row depends on others */
    double rounding;             /* residual of closed rows */
    const volatile sig_atomic_t *stop;
} search;

/* most: the rank is not greater; 0: not known. */
static int rank_at(search *x, const double *q, int most)
{
    lw_space_rows_fill(&x->z, q, NULL);
    x->d.rank.most = most;
    lw_space_dense_factor(&x->z, &x->d, x->least);
    return x->d.rank.rank;
}

static double residual(const search *x)
{
    double most = 0;
    for (int r = 0; r < x->z.n_row; r++)
        most = fmax(most, fabs(x->z.phi[r]));
    return most;
}

/* Close the joints near x->q by least squares, with rows of rank `most`: rows that depend on others where the joints
 * are closed are independent beside, and would lead far away. */
static double close_rows(search *x, int most)
{
    double off = INFINITY;
    for (int round = 0; round < 60 && !(x->stop && *x->stop); round++) {
        rank_at(x, x->q, most);
        double now = residual(x);
        if (now < 1e-15 || (round > 3 && now < x->rounding && now > off/2))
            return now;
        off = now;
        memcpy(x->b, x->z.phi, (size_t)x->z.n_row*sizeof *x->b);
        lw_rank_solve_transposed(&x->d.rank, x->b, x->by);
        for (int i = 0; i < x->s->n_v; i++)
            x->by[i] = -x->by[i];
        double length = lw_space_length(x->s, x->by);
        if (!isfinite(length) || length > 1)
            return INFINITY;
        lw_space_move(x->s, x->q, x->by);
    }
    rank_at(x, x->q, most);
    return residual(x);
}

/* A random motion of first order in the posture of the file, of length 1. */
static void draw_motion(search *x, lw_rng *rng)
{
    const lw_space *s = x->s;
    int free = s->n_v - rank_at(x, s->start, 0);
    memset(x->v, 0, (size_t)s->n_v*sizeof *x->v);
    for (int k = 0; k < free; k++) {
        double c = 2*lw_rng_uniform(rng) - 1;
        lw_rank_left_null(&x->d.rank, k, x->by);
        for (int i = 0; i < s->n_v; i++)
            x->v[i] += c*x->by[i];
    }
    double length = lw_space_length(s, x->v);
    for (int i = 0; i < s->n_v; i++)
        x->v[i] /= length > 0 ? length : 1;
}

/* Distance between x->q and the posture of the file. */
static double distance(const search *x)
{
    double most = 0;
    for (int b = 0; b < x->s->n_body; b++) {
        const double *p = x->q + 7*b, *o = x->s->start + 7*b;
        lw_quaternion t = lw_quaternion_times(lw_quaternion_inverse((lw_quaternion){ o[3], o[4], o[5], o[6] }),
                                              (lw_quaternion){ p[3], p[4], p[5], p[6] });
        most = fmax(most, lw_v3_norm(lw_quaternion_vector(t)));
        most = fmax(most, lw_v3_norm(lw_v3(p[0] - o[0], p[1] - o[1], p[2] - o[2])));
    }
    return most;
}

static void name_row(const search *x, int r, lw_space_mobility *m)
{
    lw_space_redundant *p = &m->redundant[m->n_redundant++];
    p->row = lw_space_row_name(x->s, r, &p->joint);
}

/* Of a large model: is each row clearly independent of the others or dependent on them, does the model move a little along a random
 * motion that the independent ones leave, and do all rows hold there?  Fills m then; else LW_NOTHING. */
static lw_status find_clear(search *x, uint64_t seed, lw_space_mobility *m, lw_error *e)
{
    static const double length = 0.01;
    const lw_space *s = x->s;
    int rank = x->z.n_kept, free = s->n_v - rank;
    lw_rng rng;
    lw_rng_seed(&rng, seed, 0);
    lw_space_rows_fill(&x->z, s->start, NULL);
    if (s->n_row <= LW_SPACE_MANY_ROWS || !lw_space_rows_factor(&x->z) || x->z.weak < LW_SPACE_CLEAR_SHARE)
        return LW_NOTHING;
    for (int i = 0; i < s->n_v; i++)
        x->v[i] = 2*lw_rng_uniform(&rng) - 1;
    lw_space_rows_solve(&x->z, x->v, NULL, true, x->by, x->b);
    double most = lw_space_length(s, x->by);
    for (int i = 0; i < s->n_v; i++)
        x->by[i] *= length/most;
    memcpy(x->q, s->start, (size_t)s->n_q*sizeof *x->q);
    if (free > 0)
        lw_space_move(s, x->q, x->by);
    if (lw_space_rows_close(&x->z, x->q, NULL, 0) != LW_OK)
        return LW_NOTHING;
    lw_space_rows_fill(&x->z, x->q, NULL);
    double far = distance(x), off = residual(x);
    if (!lw_space_rows_factor(&x->z) || x->z.weak < LW_SPACE_CLEAR_SHARE || (free > 0 && far < 0.3*length)
        || (free > 0 && rank < s->n_row && !(off < x->rounding)))
        return LW_NOTHING;
    if (rank < s->n_row) {                   /* those that depend on others there */
        x->z.rank = 0;
        lw_status st = lw_space_rows_arrange(&x->z, x->q, e);
        if (st != LW_OK)
            return st;
        if (x->z.n_kept != rank)
            return LW_NOTHING;
    }
    m->rank = rank;
    m->instant = m->freedom = free;
    m->moved = free > 0 ? far : 0;
    m->residual = free > 0 ? off*s->unit : 0;
    for (int r = 0; rank < s->n_row && r < s->n_row; r++)
        if (x->z.place[r] < 0)
            name_row(x, r, m);
    return LW_OK;
}

/* How many of the motions y of first order in the posture x->q, where the rank stays as it is along the motion, are tangents?  For rows that
 * depend on others, l^T J = 0, the derivative of l^T J k = 0 along a tangent y gives l^T dJ(y) k = 0 for all motions k of first order. */
static lw_status count_tangents(search *x, int *tangents, lw_error *e)
{
    const lw_space *s = x->s;
    int n_motion = s->n_v - rank_at(x, x->q, 0), rows = x->z.n_row;
    size_t n = (size_t)s->n_v, f = (size_t)n_motion;
    *tangents = n_motion;
    if (n_motion < 2 || x->d.rank.rank == rows)
        return LW_OK;
    double *motion = malloc((f*n + f*(size_t)rows + f*f + (size_t)rows)*sizeof *motion);
    if (!motion)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double *part = motion + f*n, *gram = part + f*(size_t)rows, *less = gram + f*f, most = 1e4*x->least*x->least;
    memset(gram, 0, f*f*sizeof *gram);
    for (int k = 0; k < n_motion; k++)
        lw_rank_left_null(&x->d.rank, k, motion + (size_t)k*n);
    for (int k = 0; k < n_motion && !(x->stop && *x->stop); k++) {
        for (int j = 0; j < n_motion; j++) {
            double *to = part + (size_t)j*(size_t)rows;
            for (int i = 0; i < s->n_v; i++) {
                x->by[i] = motion[(size_t)j*n + (size_t)i] + motion[(size_t)k*n + (size_t)i];
                x->v[i] = motion[(size_t)j*n + (size_t)i] - motion[(size_t)k*n + (size_t)i];
            }
            lw_space_rows_bias(&x->z, x->by, to);
            lw_space_rows_bias(&x->z, x->v, less);
            for (int r = 0; r < rows; r++)
                to[r] = (to[r] - less[r])/4;
            lw_rank_null_part(&x->d.rank, to);
            for (int i = 0; i <= j; i++)
                gram[(size_t)i*f + (size_t)j] = gram[(size_t)j*f + (size_t)i] += lw_dot(rows, part + (size_t)i*(size_t)rows, to);
        }
    }
    for (int step = 0; step < n_motion; step++) {                /* its rank, by elimination with the greatest pivot */
        size_t p = 0;
        for (size_t i = 1; i < f; i++)
            p = gram[i*f + i] > gram[p*f + p] ? i : p;
        double pivot = gram[p*f + p];
        if (!(pivot > most))
            break;
        --*tangents;
        memcpy(motion, gram + p*f, f*sizeof *motion);
        for (size_t i = 0; i < f; i++)
            for (size_t j = 0; j < f; j++)
                gram[i*f + j] -= motion[i]*motion[j]/pivot;
    }
    free(motion);
    return LW_OK;
}

static lw_status find(search *x, uint64_t seed, double tolerance, lw_space_mobility *m, lw_error *e)
{
    static const double length = 0.05;
    const lw_space *s = x->s;
    double closed = fmax(tolerance, 1e-12);
    lw_rng rng;
    lw_rng_seed(&rng, seed, 0);
    m->instant = s->n_v - rank_at(x, s->start, 0);
    m->rank = s->n_v - m->instant;
    m->shaky = m->instant > 0;
    for (int trial = 0; trial < (m->shaky ? 12 : 6) && m->instant > 0 && !(x->stop && *x->stop); trial++) {
        double step = length*(trial < 6 ? 1 : 0.2);
        draw_motion(x, &rng);
        memcpy(x->q, s->start, (size_t)s->n_q*sizeof *x->q);
        for (int i = 0; i < s->n_v; i++)
            x->by[i] = step*x->v[i];
        lw_space_move(s, x->q, x->by);
        double off = close_rows(x, s->n_v - m->instant);
        if (!(off < closed))
            off = close_rows(x, 0);
        double far = distance(x);
        if (!(off < closed) || far < 0.3*step)
            continue;
        int freedom, rank;
        lw_status st = count_tangents(x, &freedom, e);
        if (st != LW_OK)
            return st;
        rank = x->d.rank.rank;
        if (m->shaky || freedom > m->freedom) {
            memcpy(x->moved, x->q, (size_t)s->n_q*sizeof *x->moved);
            m->freedom = freedom;
            m->rank = rank;
            m->moved = far;
            m->residual = off*s->unit;
        }
        m->shaky = false;
    }
    return LW_OK;
}

/* Rows that follow from those before them, in the posture moved to: one by one, rows that add no rank. */
static lw_status name_redundant(search *x, lw_space_mobility *m, lw_error *e)
{
    const lw_space *s = x->s;
    int rows = x->z.n_row, n = s->n_v;
    double *basis = malloc(((size_t)n*(size_t)n + (size_t)n)*sizeof *basis), *row = basis ? basis + (size_t)n*(size_t)n
        : NULL;
    if (!basis)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    int rank = 0;
    lw_space_rows_fill(&x->z, m->freedom > 0 ? x->moved : s->start, NULL);
    for (int r = 0; r < rows; r++) {
        memset(row, 0, (size_t)n*sizeof *row);
        for (int k = x->z.at[r]; k < x->z.at[r + 1]; k++)
            if (x->z.body[k/6] >= 0)
                row[6*x->z.body[k/6] + k%6] = x->z.jac[k];
        double before = 0, after = 0;
        for (int i = 0; i < n; i++)
            before += row[i]*row[i];
        for (int twice = 0; twice < 2; twice++)
            for (int k = 0; k < rank; k++) {
                double along = lw_dot(n, row, basis + (size_t)k*(size_t)n);
                for (int i = 0; i < n; i++)
                    row[i] -= along*basis[(size_t)k*(size_t)n + (size_t)i];
            }
        for (int i = 0; i < n; i++)
            after += row[i]*row[i];
        if (rank < n && sqrt(after) > 10*x->least*sqrt(before)) {
            for (int i = 0; i < n; i++)
                basis[(size_t)rank*(size_t)n + (size_t)i] = row[i]/sqrt(after);
            rank++;
        } else
            name_row(x, r, m);
    }
    free(basis);
    return LW_OK;
}

lw_status lw_space_mobility_find(const lw_spatial *model, double tolerance, uint64_t seed, const volatile sig_atomic_t *stop,
                                 lw_space_mobility *m, lw_error *e)
{
    lw_space s;
    search x = { .s = &s, .least = fmax(1e-9, 10*sqrt(tolerance)*1e-3), .rounding = fmax(tolerance, 1e-13), .stop = stop };
    memset(m, 0, sizeof *m);
    lw_status st = lw_space_make(model, &s, e);
    if (st != LW_OK)
        return st;
    double *weight = malloc((2*(size_t)s.n_q + 3*(size_t)s.n_v + (size_t)s.n_row + 1)*sizeof *weight);
    lw_space_extra *idle = calloc((size_t)s.n_body + 1, sizeof *idle);
    m->idle_link = calloc((size_t)s.n_body + 1, sizeof *m->idle_link);
    m->redundant = calloc((size_t)s.n_row + 1, sizeof *m->redundant);
    if (!weight || !idle || !m->idle_link || !m->redundant)
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        x.q = weight + s.n_v, x.moved = x.q + s.n_q, x.by = x.moved + s.n_q, x.v = x.by + s.n_v, x.b = x.v + s.n_v;
        lw_space_metric(&s, weight);
        m->n_body = s.n_body;
        m->n_row = s.n_row;
        m->count = s.n_v - s.n_row;
        m->idle = lw_space_idle(&s, false, idle);
        for (int i = 0; i < m->idle; i++)
            m->idle_link[i] = s.link_of[idle[i].body];
        st = lw_space_rows_make(&s, NULL, 0, weight, s.start, &x.z, e);
    }
    if (st == LW_OK && (st = find_clear(&x, seed, m, e)) == LW_NOTHING && (st = lw_space_dense_make(&x.z, &x.d, e)) == LW_OK) {
        x.d.rank.stop = stop;
        if ((st = find(&x, seed, tolerance, m, e)) == LW_OK)
            st = stop && *stop ? lw_error_set(e, LW_STOPPED, "stopped before the freedoms were found") : name_redundant(&x, m, e);
        lw_space_dense_free(&x.d);
    }
    lw_space_rows_free(&x.z);
    free(weight), free(idle);
    lw_space_free(&s);
    if (st != LW_OK)
        lw_space_mobility_free(m);
    return st;
}
