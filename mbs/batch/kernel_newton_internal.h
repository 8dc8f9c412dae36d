/* mbs/batch/kernel_newton_internal.h - the loops of higher groups and Newton's method on them, eight lanes at a time.
 *
 * The columns of the Jacobian are turned vectors of the loops.  With the columns scaled to unit vectors (N),
 *     margin = n / |N^-1|^2  (Frobenius norm),  n the number of unknowns.
 * This is the harmonic mean of the squared singular values of N: 1 for orthogonal columns, 0 at a singular posture.
 * For a dyad it is the squared sine of mbs/batch/batch.h. */
#ifndef LW_MBS_BATCH_KERNEL_NEWTON_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_NEWTON_INTERNAL_H

#include "mbs/batch/kernel_gear_internal.h"

/* Define name(parameters), which calls name##_of(n, ...).  The most frequent numbers of unknowns n have functions of
 * their own, in which n is a constant and the loops over the unknowns are unrolled.  These functions are not inlined,
 * because the compiler takes minutes for one function that holds them all. */
#define LW_APART static __attribute__((noinline))
#define LW_BY_SIZE(name, parameters, ...)                                       \
    LW_APART void name##_2 parameters { name##_of(2, __VA_ARGS__); }            \
    LW_APART void name##_4 parameters { name##_of(4, __VA_ARGS__); }            \
    LW_APART void name##_6 parameters { name##_of(6, __VA_ARGS__); }            \
    LW_APART void name##_any parameters { name##_of(w->n, __VA_ARGS__); }       \
    LW_INLINE void name parameters                                              \
    {                                                                           \
        switch (w->n) {                                                         \
        case 2:  name##_2(__VA_ARGS__); break;                                  \
        case 4:  name##_4(__VA_ARGS__); break;                                  \
        case 6:  name##_6(__VA_ARGS__); break;                                  \
        default: name##_any(__VA_ARGS__);                                       \
        }                                                                       \
    }

#define BEYOND_LEAST 1e-12                 /* least distance of a lane that is out of reach           */

/* Unroll loops over the unknowns, so that their values stay in registers. */
#if defined(__clang__)
#define LW_UNROLL _Pragma("clang loop unroll(full)")
#else
#define LW_UNROLL _Pragma("GCC unroll 4")
#endif

/* A higher group in eight lanes. */
typedef struct eight {
    const lw_higher *g;
    int    n;                                                        /* unknowns                      */
    double size;
    pack   ux[LW_HIGHER_DIR_MAX], uy[LW_HIGHER_DIR_MAX];             /* directions                    */
    pack   vx[LW_HIGHER_DIR_MAX], vy[LW_HIGHER_DIR_MAX];             /* turns of directions from base */
    pack   d[LW_UNKNOWN_MAX + 1];                                    /* displacements                 */
    pack   cx[LW_HIGHER_TERM_MAX], cy[LW_HIGHER_TERM_MAX];           /* sums of vectors, by entry     */
    pack   k[LW_UNKNOWN_MAX], f[LW_UNKNOWN_MAX], step[LW_UNKNOWN_MAX];     /* constant part, residual */
    pack   jac[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX], inv[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX];      /* row by row */
    pack   margin;
    meshes mesh;                                                     /* dimensions of its gears       */
    int    at[LW_UNKNOWN_MAX];                                       /* direction of each turn        */
    int    order[LW_UNKNOWN_MAX];                                    /* rows in the order of pivots   */
    bool   driven;                                                   /* is the input a joint of it?   */
    bool   ends;                                                     /* do racks have ends? (the input turns) */
    bool   moves[LW_HIGHER_DIR_MAX];                                 /* does the input turn these directions? */
} eight;

/* ---- data of the lanes -------------------------------------------------------------------------------- */

/* Number of the direction of unknown turn a: the only one without a base and with this root. */
static int direction_of(const lw_higher *g, int a)
{
    int d = 0;
    while (g->dir[d].root != a || g->dir[d].base >= 0)
        d++;
    return d;
}

static void take_group(eight *w, const lw_higher *g)
{
    w->g = g;
    w->n = g->n_unknown;
    for (int a = 0; a < g->n_turn; a++)
        w->at[a] = direction_of(g, a);
    for (int r = 0; r < w->n; r++)
        w->order[r] = r;
    w->driven = g->disp_input;
    for (int d = 0; d < g->n_dir; d++) {
        w->moves[d] = g->dir[d].input || (g->dir[d].base >= 0 && w->moves[g->dir[d].base]);
        w->driven |= w->moves[d];
    }
}

LW_INLINE void load_vectors(const run *k, eight *w, size_t i, const int per_lane)
{
    const lw_higher *g = w->g;
    for (int e = 0; e < g->n_entry; e++)
        w->cx[e] = w->cy[e] = (pack){ 0 };
    for (int v = 0; v < g->n_vector; v++) {
        const lw_higher_vector *q = &g->vector[v];
        double sign = q->sign;
        if (q->x >= 0)
            w->cx[q->entry] += sign*lane_row(dim_of(k, q->x), i, per_lane);
        if (q->y >= 0)
            w->cy[q->entry] += sign*lane_row(dim_of(k, q->y), i, per_lane);
    }
}

/* Angles that are the same in all lanes. */
static void load_angles(const run *k, eight *w)
{
    for (int a = 0; a < w->g->n_dir; a++) {
        const lw_higher_dir *q = &w->g->dir[a];
        pack *ux = q->base < 0 ? w->ux : w->vx, *uy = q->base < 0 ? w->uy : w->vy;
        if (q->angle >= 0) {
            ux[a] = all8(*cos_of(k, q->angle));
            uy[a] = all8(*sin_of(k, q->angle));
        }
    }
}

LW_INLINE void load_known(const run *k, eight *w, size_t i, const int per_lane)
{
    const lw_higher *g = w->g;
    for (int r = 0; r < w->n; r++)
        w->k[r] = (pack){ 0 };
    for (int p = 0; p < g->n_point; p++) {
        const lw_higher_point *q = &g->point[p];
        double sign = q->sign;
        w->k[2*q->loop] += sign*get8(reg_x(k, q->reg) + i);
        w->k[2*q->loop + 1] += sign*get8(reg_y(k, q->reg) + i);
    }
    for (int a = 0; a < g->n_dir; a++) {
        const lw_higher_dir *q = &g->dir[a];
        pack *ux = q->base < 0 ? w->ux : w->vx, *uy = q->base < 0 ? w->uy : w->vy;
        double sign = q->input < 0 ? -1 : 1;
        if (q->angle >= 0 && per_lane) {
            ux[a] = get8(cos_of(k, q->angle) + i);
            uy[a] = get8(sin_of(k, q->angle) + i);
        } else if (q->angle < 0 && (q->root < 0 || q->base >= 0)) {
            ux[a] = get8(reg_x(k, q->reg) + i);
            uy[a] = sign*get8(reg_y(k, q->reg) + i);
        }
    }
    if (g->disp_input)
        w->d[g->n_disp] = get8(reg_x(k, g->disp_reg[g->n_disp]) + i);
}

static void turn_directions(eight *w)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_dir; a++) {
        int b = g->dir[a].base;
        if (b < 0)
            continue;
        pack x = w->ux[b], y = w->uy[b];
        w->ux[a] = x*w->vx[a] - y*w->vy[a];
        w->uy[a] = x*w->vy[a] + y*w->vx[a];
    }
}

/* ---- equations ---------------------------------------------------------------------------------------- */

LW_INLINE void add_turned(eight *w, const int n, int loop, int root, pack x, pack y)
{
    pack *j = w->jac + 2*loop*n + root;
    j[0] -= y;
    j[n] += x;
}

/* The rows of gears, behind those of the loops. */
static void gear_equations(eight *w, int n, bool both)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_gear; a++) {
        const lw_higher_gear *q = &g->gear[a];
        int r = 2*g->n_loop + a;
        w->f[r] = mesh_left(q, &w->mesh, a, w->ux, w->uy, w->d);
        for (int h = 0; both && h < q->n_term; h++)
            if (g->dir[q->dir[h]].root >= 0)
                w->jac[r*n + g->dir[q->dir[h]].root] += (double)q->power[h]/q->count;
        if (both && q->disp >= 0 && q->disp < g->n_disp)
            w->jac[r*n + g->n_turn + q->disp] -= w->mesh.by_rho[a];
    }
}

/* Residuals f; with `both` also their Jacobian. */
LW_INLINE void equations(const int n, eight *w, const int both)
{
    const lw_higher *g = w->g;
    for (int r = 0; r < n; r++)
        w->f[r] = w->k[r];
    for (int i = 0; both && i < n*n; i++)
        w->jac[i] = (pack){ 0 };
    for (int e = 0; e < g->n_entry; e++) {
        int dir = g->entry[e].dir, loop = g->entry[e].loop, root = g->dir[dir].root;
        pack cx = w->cx[e], cy = w->cy[e], ux = w->ux[dir], uy = w->uy[dir];
        pack x = cx*ux - cy*uy, y = cx*uy + cy*ux;
        w->f[2*loop] += x;
        w->f[2*loop + 1] += y;
        if (both && root >= 0)
            add_turned(w, n, loop, root, x, y);
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        double sign = q->sign;
        pack x = sign*w->ux[q->dir], y = sign*w->uy[q->dir], d = w->d[q->disp];
        w->f[2*q->loop] += d*x;
        w->f[2*q->loop + 1] += d*y;
        if (both && g->dir[q->dir].root >= 0)
            add_turned(w, n, q->loop, g->dir[q->dir].root, d*x, d*y);
        if (both && q->disp < g->n_disp) {
            w->jac[2*q->loop*n + g->n_turn + q->disp] += x;
            w->jac[(2*q->loop + 1)*n + g->n_turn + q->disp] += y;
        }
    }
    if (g->n_gear)
        gear_equations(w, n, both);
}

/* ---- the inverse -------------------------------------------------------------------------------------- */

#define PIVOT_LEAST 0.1                    /* least ratio of a pivot to the largest candidate         */

/* Invert by Gauss-Jordan elimination in place, with the rows in w->order.  The inverse is wrong in the lanes in which a
 * pivot is weak; *weak_lanes marks them. */
LW_INLINE void invert_in_order_of(const int n, eight *w, mask *weak_lanes)
{
    pack a[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX];
    mask weak = { 0 };
    LW_UNROLL for (int r = 0; r < n; r++)
        LW_UNROLL for (int c = 0; c < n; c++)
            a[r*n + c] = w->jac[w->order[r]*n + c];
    LW_UNROLL for (int p = 0; p < n; p++) {
        pack own = abs8(a[p*n + p]), most = all8(LW_TINY);
        LW_UNROLL for (int r = p + 1; r < n; r++)
            most = more8(abs8(a[r*n + p]), most);
        weak |= ~(mask)(own >= PIVOT_LEAST*most);
        pack by = 1/a[p*n + p];
        a[p*n + p] = all8(1);
        LW_UNROLL for (int c = 0; c < n; c++)
            a[p*n + c] *= by;
        LW_UNROLL for (int r = 0; r < n; r++) {
            if (r == p)
                continue;
            pack t = a[r*n + p];
            a[r*n + p] = (pack){ 0 };
            LW_UNROLL for (int c = 0; c < n; c++)
                a[r*n + c] -= t*a[p*n + c];
        }
    }
    LW_UNROLL for (int r = 0; r < n; r++)
        LW_UNROLL for (int c = 0; c < n; c++)
            w->inv[r*n + w->order[c]] = a[r*n + c];
    *weak_lanes = weak;
}
LW_BY_SIZE(invert_in_order, (eight *w, mask *weak_lanes), w, weak_lanes)

/* Invert in lane j alone, with the largest pivots; store their order for the other lanes.  With a pivot of 0 the
 * inverse is 0. */
static void invert_lane(eight *w, int n, int j)
{
    double a[LW_UNKNOWN_MAX][LW_UNKNOWN_MAX];
    int order[LW_UNKNOWN_MAX];
    bool sound = true;
    for (int r = 0; r < n; r++) {
        order[r] = r;
        for (int c = 0; c < n; c++)
            a[r][c] = w->jac[r*n + c][j];
    }
    for (int p = 0; p < n && sound; p++) {
        int best = p;
        for (int r = p + 1; r < n; r++)
            best = fabs(a[r][p]) > fabs(a[best][p]) ? r : best;
        int was = order[p];
        order[p] = order[best];
        order[best] = was;
        for (int c = 0; c < n; c++) {
            double from = a[p][c];
            a[p][c] = a[best][c];
            a[best][c] = from;
        }
        sound = fabs(a[p][p]) > LW_TINY;
        double by = 1/(sound ? a[p][p] : 1);
        a[p][p] = 1;
        for (int c = 0; c < n; c++)
            a[p][c] *= by;
        for (int r = 0; r < n; r++) {
            double t = r == p ? 0 : a[r][p];
            a[r][p] = r == p ? a[r][p] : 0;
            for (int c = 0; c < n; c++)
                a[r][c] -= t*a[p][c];
        }
    }
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++)
            w->inv[r*n + order[c]][j] = sound ? a[r][c] : 0;
    if (sound)
        memcpy(w->order, order, (size_t)n*sizeof *order);
}

/* Invert again where a pivot was weak: first in the order of the first weak lane, then lane by lane. */
LW_APART void invert_weak(eight *w, mask weak)
{
    int j = 0;
    while (!weak[j])
        j++;
    invert_lane(w, w->n, j);
    invert_in_order(w, &weak);
    for (j = 0; j < LW_GROUP; j++)
        if (weak[j])
            invert_lane(w, w->n, j);
}

/* Rows of gears are angles, rows of loops are lengths.  The squared factor between them is the mean square of the
 * vectors that turn. */
static pack gear_weight(const eight *w, int n)
{
    const lw_higher *g = w->g;
    pack sum = { 0 };
    for (int r = 0; r < 2*g->n_loop; r++)
        for (int c = 0; c < g->n_turn; c++)
            sum += w->jac[r*n + c]*w->jac[r*n + c];
    mask some = (mask)(sum > 0);
    return choose8(some, sum*(1.0/(g->n_turn ? g->n_turn : 1)), all8(1));
}

/* The margin from the Jacobian and its inverse.  weight: squared factor of the rows behind the first `loops` rows. */
LW_INLINE void measure_rows(eight *w, const int n, const int loops, pack weight)
{
    pack sum = { 0 }, by_weight = 1/weight;
    for (int c = 0; c < n; c++) {
        pack length = { 0 }, row = { 0 };
        for (int r = 0; r < loops; r++) {
            length += w->jac[r*n + c]*w->jac[r*n + c];
            row += w->inv[c*n + r]*w->inv[c*n + r];
        }
        for (int r = loops; r < n; r++) {
            length += weight*w->jac[r*n + c]*w->jac[r*n + c];
            row += by_weight*w->inv[c*n + r]*w->inv[c*n + r];
        }
        sum += row*length;
    }
    mask some = (mask)(sum > 0);
    w->margin = where8(some, n/choose8(some, sum, all8(1)));
}

LW_INLINE void measure_of(const int n, eight *w)
{
    if (!w->g->n_gear) {
        measure_rows(w, n, n, all8(1));
        return;
    }
    measure_rows(w, n, 2*w->g->n_loop, gear_weight(w, n));
    w->margin = w->ends ? less8(rack_room(w->g, &w->mesh, w->d), w->margin) : w->margin;
}
LW_BY_SIZE(measure, (eight *w), w)

/* ---- Newton's method ---------------------------------------------------------------------------------- */

/* The step from the residual and the inverse. */
LW_INLINE void newton_step(const int n, eight *w)
{
    for (int r = 0; r < n; r++) {
        pack s = { 0 };
        for (int c = 0; c < n; c++)
            s -= w->inv[r*n + c]*w->f[c];
        w->step[r] = s;
    }
}

/* The step of Newton's method, with the Jacobian at this posture. */
LW_INLINE void newton_of(const int n, eight *w)
{
    mask weak;
    equations(n, w, 1);
    invert_in_order_of(n, w, &weak);
    if (any8(weak))
        invert_weak(w, weak);
    newton_step(n, w);
}
LW_BY_SIZE(newton, (eight *w), w)

/* The same with the last inverse. */
LW_INLINE void newton_again_of(const int n, eight *w)
{
    equations(n, w, 0);
    newton_step(n, w);
}

LW_INLINE pack within8(pack a, pack most) { return more8(less8(a, most), -most); }

/* Apply the step, at most half a radian or half the size.  Returns the square of its length. */
LW_INLINE pack apply_step(eight *w)
{
    const lw_higher *g = w->g;
    double by_size = 1/w->size;
    pack most = all8(0.5*w->size), half = all8(0.5), length = { 0 };
    for (int a = 0; a < g->n_turn; a++) {
        pack *ux = &w->ux[w->at[a]], *uy = &w->uy[w->at[a]], step = w->step[a];
        pack t = within8(step, half), z = t*t;
        pack c = 1 - z*(0.5 - z*(1.0/24)), s = t - t*z*(1.0/6 - z*(1.0/120));
        pack x = *ux*c - *uy*s, y = *ux*s + *uy*c, m = 1.5 - 0.5*(x*x + y*y);
        *ux = x*m;
        *uy = y*m;
        length += step*step;
    }
    for (int d = 0; d < g->n_disp; d++) {
        pack step = w->step[g->n_turn + d];
        w->d[d] += within8(step, most);
        length += step*by_size*(step*by_size);
    }
    turn_directions(w);
    return length;
}

static void put_group(const run *k, const eight *w, size_t i)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_turn; a++) {
        put8(reg_x(k, g->turn_reg[a]) + i, w->ux[w->at[a]]);
        put8(reg_y(k, g->turn_reg[a]) + i, w->uy[w->at[a]]);
    }
    for (int d = 0; d < g->n_disp; d++) {
        put8(reg_x(k, g->disp_reg[d]) + i, w->d[d]);
        put8(reg_y(k, g->disp_reg[d]) + i, (pack){ 0 });
    }
}

#endif
