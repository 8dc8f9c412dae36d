/* mbs/batch/kernel_higher_internal.h - higher groups, eight lanes at a time: the loops, Newton's method on them, their
 * derivatives.  Included by mbs/batch/kernel.c alone.
 *
 * The unknowns' columns of the Jacobian are turned vectors, so that a column's length tells how much its
 * unknown counts.  With the columns made unit vectors (N),
 *     margin = n / |N^-1|^2  (Frobenius),  n the number of unknowns:
 * the harmonic mean of the squared singular values of N, 1 for orthogonal columns, 0 at a singular posture;
 * of a dyad it is the squared sine by which dyads are measured.  A turn by delta changes a column by at most
 * |delta|; so while  sum of delta^2 < 1/|N^-1|^2 = margin/n  the Jacobian stays regular and there is no second
 * solution (mean value theorem): steps are kept to a half of that. */
#ifndef LW_MBS_BATCH_KERNEL_HIGHER_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_HIGHER_INTERNAL_H

#include "mbs/batch/kernel_gear_internal.h"

/* name(parameters) does what name##_of(n, ...) does; each of the commonest numbers of unknowns n has a function of its
 * own, in which n is a constant and the loops over the unknowns are unrolled.  They are kept apart because the compiler
 * takes minutes over one function that holds them all. */
#define LW_APART static __attribute__((noinline))
#define LW_BY_SIZE(name, parameters, ...)                                       \
    LW_APART void name##_2 parameters { name##_of(2, __VA_ARGS__); }            \
    LW_APART void name##_4 parameters { name##_of(4, __VA_ARGS__); }            \
    LW_APART void name##_6 parameters { name##_of(6, __VA_ARGS__); }            \
    LW_APART void name##_any parameters { name##_of(w->n, __VA_ARGS__); }       \
    static void name parameters                                                 \
    {                                                                           \
        switch (w->n) {                                                         \
        case 2:  name##_2(__VA_ARGS__); break;                                  \
        case 4:  name##_4(__VA_ARGS__); break;                                  \
        case 6:  name##_6(__VA_ARGS__); break;                                  \
        default: name##_any(__VA_ARGS__);                                       \
        }                                                                       \
    }

/* Loops over the unknowns whose values stay in registers, for the commonest sizes. */
#if defined(__clang__)
#define LW_UNROLL _Pragma("clang loop unroll(full)")
#else
#define LW_UNROLL _Pragma("GCC unroll 4")
#endif

typedef struct eight {
    const lw_higher *g;
    int    n;                                                        /* unknowns                      */
    double size;
    pack   ux[LW_HIGHER_DIR_MAX], uy[LW_HIGHER_DIR_MAX];             /* directions                    */
    pack   vx[LW_HIGHER_DIR_MAX], vy[LW_HIGHER_DIR_MAX];             /* what turns them               */
    pack   d[LW_UNKNOWN_MAX + 1];
    pack   cx[LW_HIGHER_TERM_MAX], cy[LW_HIGHER_TERM_MAX];           /* sums of vectors, by entry     */
    pack   k[LW_UNKNOWN_MAX], f[LW_UNKNOWN_MAX], step[LW_UNKNOWN_MAX];
    pack   jac[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX], inv[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX];      /* row by row */
    pack   margin;
    meshes mesh;                                                     /* its gears                     */
    int    at[LW_UNKNOWN_MAX];                                       /* direction of each turn        */
    int    order[LW_UNKNOWN_MAX];                                    /* rows by the pivots they give  */
    bool   driven;                                                   /* the input is a joint of it    */
    bool   ends;                                                     /* racks do: the input turns     */
    bool   moves[LW_HIGHER_DIR_MAX];                                 /* directions that it turns      */
} eight;

/* ---- what the lanes have ------------------------------------------------------------------------------ */

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

/* Angles that do not differ from lane to lane. */
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

/* The rows of gears, past those of the loops. */
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

/* Residuals f, and their Jacobian (both). */
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

#define PIVOT_LEAST 0.1                    /* a pivot over the largest that there was to choose from  */

/* Gauss and Jordan in place, rows taken in the order kept; lanes in which a pivot was weak are spoilt, and told. */
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

/* The same in lane j alone, each pivot the largest there is, whose order is kept for other lanes; with a pivot of 0 the
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

/* The lanes in which the order of rows that was good for others gave a weak pivot. */
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

/* Rows of gears count angles, those of loops lengths: what makes the ones the others, squared, is the mean square of
 * the vectors that turn. */
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

/* Margin at the Jacobian and inverse of w; weight (2): of the first `loops` rows, of those after them. */
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

/* How far to go, from f and the inverse. */
LW_INLINE void newton_step(const int n, eight *w)
{
    for (int r = 0; r < n; r++) {
        pack s = { 0 };
        for (int c = 0; c < n; c++)
            s -= w->inv[r*n + c]*w->f[c];
        w->step[r] = s;
    }
}

/* A step of Newton's method by the inverse of the Jacobian here. */
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

/* The same by the last inverse. */
LW_INLINE void newton_again_of(const int n, eight *w)
{
    equations(n, w, 0);
    newton_step(n, w);
}

LW_INLINE pack within8(pack a, pack most) { return more8(less8(a, most), -most); }

/* Go the step, at most half a radian or half the size; the square of its length. */
LW_INLINE pack go(eight *w)
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

/* ---- as a step of the plan ---------------------------------------------------------------------------- */

static double *inverse_rows(const run *k, const lw_higher *g)
{
    double *at = k->inverse;
    for (const lw_higher *h = k->plan->higher; h < g; h++)
        at += (size_t)(h->n_unknown*h->n_unknown)*k->nb;
    return at;
}

static void take_seat(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    const double *row = k->seat + (size_t)g->first_row*k->seat_row + i;
    for (int a = 0; a < g->n_turn; a++, row += 2*k->seat_row) {
        w->ux[w->at[a]] = get8(row);
        w->uy[w->at[a]] = get8(row + k->seat_row);
    }
    for (int d = 0; d < g->n_disp; d++, row += k->seat_row)
        w->d[d] = get8(row);
    turn_directions(w);
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

#define ASTRAY 0.03                        /* a step as long leaves the seat: [rad], or times the size */
#define BEYOND_LEAST 1e-12                 /* by how much a lane out of reach is so, at least         */

/* Lanes whose step is too long, where it is made 0. */
LW_INLINE mask hold_astray(const int n, eight *w, mask within)
{
    mask near = within;
    for (int r = 0; r < n; r++)
        near &= (mask)(abs8(w->step[r]) < ASTRAY*(r < w->g->n_turn ? 1 : w->size));
    for (int r = 0; r < n; r++)
        w->step[r] = where8(near, w->step[r]);
    return within & ~near;
}

/* From the seat, which is right to 1e-10 or so, or to a part of a thousandth between others, to rounding; lanes out of
 * reach stay where they are.  A seat from which that would be a long way is none: that lane counts as out of reach too. */
LW_INLINE void settle_of(const int n, eight *w, const double *out_of_reach, int want)
{
    const double enough = want == WITH_ROOTS ? 1e-20 : 1e-16;         /* squared; inverses are those before the step */
    const pack beyond = get8(out_of_reach);
    mask astray = { 0 };
    for (int i = 0; i < 5; i++) {
        newton_of(n, w);
        if (want >= WITH_MARGIN)
            measure_of(n, w);
        astray |= hold_astray(n, w, (mask)(beyond <= 0));
        if (!(most8(go(w)) >= enough))
            break;
    }
    w->margin = choose8(astray, all8(-BEYOND_LEAST), w->margin);
    w->margin = choose8((mask)(beyond > 0), -beyond, w->margin);
}
LW_BY_SIZE(settle, (eight *w, const double *out_of_reach, int want), w, out_of_reach, want)

/* What displacements are measured by, from the dimensions of lane i. */
static double size_at(const run *k, size_t i)
{
    double dim[LW_DIM_MAX];
    for (int d = 0; d < k->plan->n_dim; d++)
        dim[d] = dim_of(k, d)[i];
    return lw_plan_size(k->plan, dim);
}

static void higher(const run *k, const lw_step *s, size_t n, int per_lane, int want)
{
    const lw_higher *g = &k->plan->higher[s->dim[0]];
    const double *reach = k->seat + (size_t)k->plan->n_row*k->seat_row;
    double *inverse = inverse_rows(k, g);
    eight w;
    take_group(&w, g);
    w.size = size_at(k, 0);
    w.ends = !k->plan->input_is_slider;
    w.margin = (pack){ 0 };
    if (!per_lane) {
        load_vectors(k, &w, 0, 0);
        load_angles(k, &w);
        load_meshes(k, g, 0, 0, &w.mesh);
    }
    for (size_t i = 0; i < n; i += LW_GROUP) {
        if (per_lane) {
            w.size = size_at(k, i);
            load_vectors(k, &w, i, 1);
            load_meshes(k, g, i, 1, &w.mesh);
            load_known(k, &w, i, 1);
        } else
            load_known(k, &w, i, 0);
        take_seat(k, &w, i);
        settle(&w, reach + i, want);
        put_group(k, &w, i);
        if (want >= WITH_MARGIN)
            put8(k->margin + i, less8(w.margin, get8(k->margin + i)));
        mask sound = (mask)(w.margin > LW_MARGIN_FLAT);
        for (int c = 0; want == WITH_ROOTS && c < w.n*w.n; c++)
            put8(inverse + (size_t)c*k->nb + i, where8(sound, w.inv[c]));
    }
}

static void turn_step(const run *k, const lw_step *s, size_t n)
{
    const in_rows u = in_reg(k, s->in[0]), v = in_reg(k, s->in[1]);
    const out_rows o = out_reg(k, s->out[0]);
    const double sign = s->dim[0];
    LW_LANES(n) put(o, i, lw_v2_turn(get(u, i), lw_v2(v.x[i], sign*v.y[i])));
}

static void slide_step(const run *k, const lw_step *s, size_t n)
{
    const in_rows q = in_reg(k, s->in[0]), w = in_reg(k, s->in[1]), d = in_reg(k, s->in[2]);
    const out_rows o = out_reg(k, s->out[0]);
    LW_LANES(n) put(o, i, lw_frame_point(get(q, i), get(w, i), d.x[i], 0));
}

/* ---- backwards ---------------------------------------------------------------------------------------- */

static void back_turn(const run *k, const lw_step *s, size_t n)
{
    const double *o = bar_x(k, s->out[0]), sign = s->dim[0];
    double *u = bar_x(k, s->in[0]), *v = bar_x(k, s->in[1]);
    LW_LANES(n) {
        u[i] += o[i];
        v[i] += sign*o[i];
    }
}

static void back_slide(const run *k, const lw_step *s, size_t n)
{
    const in_rows w = in_reg(k, s->in[1]), d = in_reg(k, s->in[2]), o_bar = in_bar(k, s->out[0]);
    const out_rows q_bar = out_bar(k, s->in[0]);
    double *w_bar = bar_x(k, s->in[1]), *d_bar = bar_x(k, s->in[2]);
    LW_LANES(n) {
        lw_vec2 o = get(o_bar, i), u = get(w, i);
        d_bar[i] += lw_v2_dot(o, u);
        w_bar[i] += d.x[i]*lw_v2_dot(o, lw_v2_perp(u));
        add_to(q_bar, i, o);
    }
}

/* F = 0 gives J dx = -dF: with J' lambda = bar, whatever moves F adds -lambda dF. */
static void multipliers(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    const double *inverse = inverse_rows(k, g) + i;
    for (int r = 0; r < w->n; r++)
        w->f[r] = (pack){ 0 };
    for (int c = 0; c < w->n; c++) {
        pack bar = get8(bar_x(k, c < g->n_turn ? g->turn_reg[c] : g->disp_reg[c - g->n_turn]) + i);
        for (int r = 0; r < w->n; r++)
            w->f[r] -= get8(inverse + (size_t)(c*w->n + r)*k->nb)*bar;
    }
}

LW_INLINE void add8(double *to, pack v) { put8(to, get8(to) + v); }

/* Turns of the directions, from the last to those known or given. */
static void back_directions(const run *k, eight *w, size_t i, pack *turn)
{
    const lw_higher *g = w->g;
    for (int a = g->n_dir - 1; a >= 0; a--) {
        const lw_higher_dir *q = &g->dir[a];
        if (q->base < 0 && q->root >= 0)
            continue;
        double sign = q->input < 0 ? -1 : 1;
        add8((q->dim >= 0 ? dim_bar(k, q->dim) : bar_x(k, q->reg)) + i, sign*turn[a]);
        if (q->base >= 0)
            turn[q->base] += turn[a];
    }
}

/* What phases, racks and known directions do to the rows of gears. */
static void back_gears(const run *k, const eight *w, size_t i, pack *turn)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_gear; a++) {
        const lw_higher_gear *q = &g->gear[a];
        pack f = w->f[2*g->n_loop + a];
        for (int h = 0; h < q->n_term; h++)
            turn[q->dir[h]] += (double)q->power[h]/q->count*f;
        if (q->phase >= 0)
            add8(dim_bar(k, q->phase) + i, -f);
        if (q->disp < 0)
            continue;
        pack by_rho = f*w->mesh.by_rho[a];
        add8(dim_bar(k, q->shift) + i, by_rho);
        add8(dim_bar(k, q->rho) + i, by_rho*rolled(&w->mesh, a, w->d[q->disp]));
        if (q->disp == g->n_disp)
            add8(bar_x(k, g->disp_reg[q->disp]) + i, -by_rho);
    }
}

static void back_eight(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    pack turn[LW_HIGHER_DIR_MAX];
    for (int a = 0; a < g->n_dir; a++)
        turn[a] = (pack){ 0 };
    for (int p = 0; p < g->n_point; p++) {
        const lw_higher_point *q = &g->point[p];
        double sign = q->sign;
        add8(bar_x(k, q->reg) + i, sign*w->f[2*q->loop]);
        add8(bar_y(k, q->reg) + i, sign*w->f[2*q->loop + 1]);
    }
    for (int v = 0; v < g->n_vector; v++) {
        const lw_higher_vector *q = &g->vector[v];
        pack fx = w->f[2*q->loop], fy = w->f[2*q->loop + 1], ux = w->ux[q->dir], uy = w->uy[q->dir];
        double sign = q->sign;
        if (q->x >= 0)
            add8(dim_bar(k, q->x) + i, sign*(fx*ux + fy*uy));
        if (q->y >= 0)
            add8(dim_bar(k, q->y) + i, sign*(fy*ux - fx*uy));
    }
    for (int e = 0; e < g->n_entry; e++) {
        int dir = g->entry[e].dir, loop = g->entry[e].loop;
        pack cx = w->cx[e], cy = w->cy[e], ux = w->ux[dir], uy = w->uy[dir];
        turn[dir] += w->f[2*loop + 1]*(cx*ux - cy*uy) - w->f[2*loop]*(cx*uy + cy*ux);
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        pack fx = w->f[2*q->loop], fy = w->f[2*q->loop + 1], ux = w->ux[q->dir], uy = w->uy[q->dir];
        double sign = q->sign;
        turn[q->dir] += sign*w->d[q->disp]*(fy*ux - fx*uy);
        if (q->disp == g->n_disp)
            add8(bar_x(k, g->disp_reg[q->disp]) + i, sign*(fx*ux + fy*uy));
    }
    back_gears(k, w, i, turn);
    back_directions(k, w, i, turn);
}

static void back_higher(const run *k, const lw_step *s, size_t n)
{
    const lw_higher *g = &k->plan->higher[s->dim[0]];
    eight w;
    take_group(&w, g);
    load_vectors(k, &w, 0, 0);
    load_angles(k, &w);
    load_meshes(k, g, 0, 0, &w.mesh);
    for (size_t i = 0; i < n; i += LW_GROUP) {
        load_known(k, &w, i, 0);
        for (int a = 0; a < g->n_turn; a++) {
            w.ux[w.at[a]] = get8(reg_x(k, g->turn_reg[a]) + i);
            w.uy[w.at[a]] = get8(reg_y(k, g->turn_reg[a]) + i);
        }
        for (int d = 0; d < g->n_disp; d++)
            w.d[d] = get8(reg_x(k, g->disp_reg[d]) + i);
        turn_directions(&w);
        multipliers(k, &w, i);
        back_eight(k, &w, i);
    }
}

#endif
