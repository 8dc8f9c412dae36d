/* mbs/kernel_higher_internal.h - higher groups, eight lanes at a time: the loops, Newton's method on them, their
 * derivatives.  Included by mbs/kernel.c alone.
 *
 * The unknowns' columns of the Jacobian are turned vectors, so that a column's length tells how much its
 * unknown counts.  With the columns made unit vectors (N),
 *     margin = n / |N^-1|^2  (Frobenius),  n the number of unknowns:
 * the harmonic mean of the squared singular values of N, 1 for orthogonal columns, 0 at a singular posture;
 * of a dyad it is the squared sine by which dyads are measured.  A turn by delta changes a column by at most
 * |delta|; so while  sum of delta^2 < 1/|N^-1|^2 = margin/n  the Jacobian stays regular and there is no second
 * solution (mean value theorem): steps are kept to a half of that. */
#ifndef LW_MBS_KERNEL_HIGHER_INTERNAL_H
#define LW_MBS_KERNEL_HIGHER_INTERNAL_H

#include "mbs/kernel_run_internal.h"

#define LW_EIGHT LW_INDEPENDENT for (int j = 0; j < LW_GROUP; j++)

typedef double lanes8[LW_GROUP];

typedef struct eight {
    const lw_higher *g;
    int    n;                                                        /* unknowns                      */
    double size;
    lanes8 ux[LW_HIGHER_DIR_MAX], uy[LW_HIGHER_DIR_MAX];             /* directions                    */
    lanes8 vx[LW_HIGHER_DIR_MAX], vy[LW_HIGHER_DIR_MAX];             /* what turns them               */
    lanes8 d[LW_UNKNOWN_MAX + 1];
    lanes8 cx[LW_HIGHER_TERM_MAX], cy[LW_HIGHER_TERM_MAX];           /* sums of vectors, by entry     */
    lanes8 k[LW_UNKNOWN_MAX], f[LW_UNKNOWN_MAX], step[LW_UNKNOWN_MAX];
    lanes8 inv[LW_UNKNOWN_MAX][LW_UNKNOWN_MAX], jac[LW_UNKNOWN_MAX][LW_UNKNOWN_MAX];
    bool   keep;                                                     /* the Jacobian too, in jac      */
    lanes8 scale[LW_UNKNOWN_MAX];                                    /* squared lengths of columns    */
    lanes8 margin;
} eight;

/* ---- what the lanes have ------------------------------------------------------------------------------ */

LW_INLINE void load_lane_row(lanes8 to, const double *from, size_t i, const int per_lane)
{
    const double one = from[0];
    LW_EIGHT to[j] = per_lane ? from[i + (size_t)j] : one;
}

static void load_vectors(const run *k, eight *w, const lw_higher *g, size_t i, const int per_lane)
{
    w->g = g;
    w->n = 2*g->n_loop;
    for (int e = 0; e < g->n_entry; e++)
        LW_EIGHT w->cx[e][j] = w->cy[e][j] = 0;
    for (int v = 0; v < g->n_vector; v++) {
        const lw_higher_vector *q = &g->vector[v];
        double *cx = w->cx[q->entry], *cy = w->cy[q->entry], sign = q->sign;
        lanes8 a;
        if (q->x >= 0) {
            load_lane_row(a, dim_of(k, q->x), i, per_lane);
            LW_EIGHT cx[j] += sign*a[j];
        }
        if (q->y >= 0) {
            load_lane_row(a, dim_of(k, q->y), i, per_lane);
            LW_EIGHT cy[j] += sign*a[j];
        }
    }
}

static void load_known(const run *k, eight *w, size_t i, const int per_lane)
{
    const lw_higher *g = w->g;
    for (int r = 0; r < w->n; r++)
        LW_EIGHT w->k[r][j] = 0;
    for (int p = 0; p < g->n_point; p++) {
        const double *x = reg_x(k, g->point[p].reg) + i, *y = reg_y(k, g->point[p].reg) + i, sign = g->point[p].sign;
        double *kx = w->k[2*g->point[p].loop], *ky = w->k[2*g->point[p].loop + 1];
        LW_EIGHT {
            kx[j] += sign*x[j];
            ky[j] += sign*y[j];
        }
    }
    for (int a = 0; a < g->n_dir; a++) {
        const lw_higher_dir *q = &g->dir[a];
        double *ux = q->base < 0 ? w->ux[a] : w->vx[a], *uy = q->base < 0 ? w->uy[a] : w->vy[a], sign = q->input < 0 ? -1 : 1;
        if (q->angle >= 0) {
            load_lane_row(ux, cos_of(k, q->angle), i, per_lane);
            load_lane_row(uy, sin_of(k, q->angle), i, per_lane);
        } else if (q->root < 0 || q->base >= 0) {
            const double *x = reg_x(k, q->reg) + i, *y = reg_y(k, q->reg) + i;
            LW_EIGHT {
                ux[j] = x[j];
                uy[j] = sign*y[j];
            }
        }
    }
    if (g->disp_input) {
        const double *x = reg_x(k, g->disp_reg[g->n_disp]) + i;
        LW_EIGHT w->d[g->n_disp][j] = x[j];
    }
}

static void turn_directions(eight *w)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_dir; a++) {
        int b = g->dir[a].base;
        if (b >= 0)
            LW_EIGHT {
                w->ux[a][j] = w->ux[b][j]*w->vx[a][j] - w->uy[b][j]*w->vy[a][j];
                w->uy[a][j] = w->ux[b][j]*w->vy[a][j] + w->uy[b][j]*w->vx[a][j];
            }
    }
}

/* Number of the direction of unknown turn a: the only one without a base and with this root. */
static int direction_of(const lw_higher *g, int a)
{
    int d = 0;
    while (g->dir[d].root != a || g->dir[d].base >= 0)
        d++;
    return d;
}

/* ---- equations ---------------------------------------------------------------------------------------- */

static void residual(eight *w)
{
    const lw_higher *g = w->g;
    for (int r = 0; r < w->n; r++)
        LW_EIGHT w->f[r][j] = w->k[r][j];
    for (int e = 0; e < g->n_entry; e++) {
        double *fx = w->f[2*g->entry[e].loop], *fy = w->f[2*g->entry[e].loop + 1];
        const double *cx = w->cx[e], *cy = w->cy[e], *ux = w->ux[g->entry[e].dir], *uy = w->uy[g->entry[e].dir];
        LW_EIGHT {
            fx[j] += cx[j]*ux[j] - cy[j]*uy[j];
            fy[j] += cx[j]*uy[j] + cy[j]*ux[j];
        }
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        double *fx = w->f[2*q->loop], *fy = w->f[2*q->loop + 1], sign = q->sign;
        const double *d = w->d[q->disp], *ux = w->ux[q->dir], *uy = w->uy[q->dir];
        LW_EIGHT {
            fx[j] += sign*d[j]*ux[j];
            fy[j] += sign*d[j]*uy[j];
        }
    }
}

LW_INLINE void add_turned(eight *w, int loop, int column, const double *vx, const double *vy)
{
    double *jx = w->inv[2*loop][column], *jy = w->inv[2*loop + 1][column];
    LW_EIGHT {
        jx[j] -= vy[j];
        jy[j] += vx[j];
    }
}

/* Into w->inv, which the inverse replaces. */
static void jacobian(eight *w)
{
    const lw_higher *g = w->g;
    lanes8 vx, vy;
    for (int r = 0; r < w->n; r++)
        for (int c = 0; c < w->n; c++)
            LW_EIGHT w->inv[r][c][j] = 0;
    for (int e = 0; e < g->n_entry; e++) {
        int dir = g->entry[e].dir, root = g->dir[dir].root;
        const double *cx = w->cx[e], *cy = w->cy[e], *ux = w->ux[dir], *uy = w->uy[dir];
        if (root < 0)
            continue;
        LW_EIGHT {
            vx[j] = cx[j]*ux[j] - cy[j]*uy[j];
            vy[j] = cx[j]*uy[j] + cy[j]*ux[j];
        }
        add_turned(w, g->entry[e].loop, root, vx, vy);
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        const double *d = w->d[q->disp], *ux = w->ux[q->dir], *uy = w->uy[q->dir], sign = q->sign;
        if (g->dir[q->dir].root >= 0) {
            LW_EIGHT {
                vx[j] = sign*d[j]*ux[j];
                vy[j] = sign*d[j]*uy[j];
            }
            add_turned(w, q->loop, g->dir[q->dir].root, vx, vy);
        }
        if (q->disp < g->n_disp) {
            double *jx = w->inv[2*q->loop][g->n_turn + q->disp], *jy = w->inv[2*q->loop + 1][g->n_turn + q->disp];
            LW_EIGHT {
                jx[j] += sign*ux[j];
                jy[j] += sign*uy[j];
            }
        }
    }
}

/* Exchange rows where the later one has the greater pivot, in every lane for itself. */
LW_INLINE void exchange(eight *w, const int n, int row, int other, int column, lanes8 mask)
{
    const double *a = w->inv[row][column], *b = w->inv[other][column];
    LW_EIGHT mask[j] = fabs(b[j]) > fabs(a[j]) ? 1 : 0;
    for (int c = 0; c < n; c++) {
        double *x = w->inv[row][c], *y = w->inv[other][c];
        LW_EIGHT {
            double from = x[j], to = y[j];
            x[j] = mask[j] != 0 ? to : from;
            y[j] = mask[j] != 0 ? from : to;
        }
    }
}

typedef struct swap { int row, other; lanes8 mask; } swap;

/* Rows are exchanged only where a pivot is less than a tenth of what there is: growth stays bounded, and in most
 * postures nothing moves. */
LW_INLINE int pivot(eight *w, const int n, int column, swap *list, int n_swap)
{
    lanes8 most = { 0 };
    const double *own = w->inv[column][column];
    int weak = 0;
    for (int r = column + 1; r < n; r++)
        LW_EIGHT most[j] = fabs(w->inv[r][column][j]) > most[j] ? fabs(w->inv[r][column][j]) : most[j];
    for (int j = 0; j < LW_GROUP; j++)
        weak |= fabs(own[j]) < 0.1*most[j];
    for (int r = column + 1; weak && r < n; r++) {
        list[n_swap].row = column;
        list[n_swap].other = r;
        exchange(w, n, column, r, column, list[n_swap].mask);
        n_swap++;
    }
    return n_swap;
}

#define LW_SWAP_MAX (LW_UNKNOWN_MAX*(LW_UNKNOWN_MAX - 1)/2)

/* Gauss and Jordan in place; with a pivot of 0 the inverse is 0. */
LW_INLINE void invert(eight *w, const int n)
{
    swap list[LW_SWAP_MAX];
    int n_swap = 0;
    lanes8 sound, inv;
    LW_EIGHT sound[j] = 1;
    for (int p = 0; p < n; p++) {
        n_swap = pivot(w, n, p, list, n_swap);
        double *d = w->inv[p][p];
        LW_EIGHT {
            int zero = !(fabs(d[j]) > LW_TINY);
            sound[j] = zero ? 0 : sound[j];
            inv[j] = (zero ? 0.0 : 1.0)/(zero ? 1.0 : d[j]);
            d[j] = 1;
        }
        for (int c = 0; c < n; c++)
            LW_EIGHT w->inv[p][c][j] *= inv[j];
        for (int r = 0; r < n; r++) {
            if (r == p)
                continue;
            lanes8 a;
            LW_EIGHT {
                a[j] = w->inv[r][p][j];
                w->inv[r][p][j] = 0;
            }
            for (int c = 0; c < n; c++)
                LW_EIGHT w->inv[r][c][j] -= a[j]*w->inv[p][c][j];
        }
    }
    for (int s = n_swap - 1; s >= 0; s--)
        for (int r = 0; r < n; r++) {
            double *x = w->inv[r][list[s].row], *y = w->inv[r][list[s].other];
            const double *mask = list[s].mask;
            LW_EIGHT {
                double from = x[j], to = y[j];
                x[j] = mask[j] != 0 ? to : from;
                y[j] = mask[j] != 0 ? from : to;
            }
        }
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++)
            LW_EIGHT w->inv[r][c][j] = sound[j] != 0 ? w->inv[r][c][j] : 0;
}

/* Inverse and margin at the directions and displacements of w. */
LW_INLINE void factor_of(eight *w, const int n)
{
    lanes8 sum = { 0 };
    jacobian(w);
    for (int c = 0; c < n; c++) {
        LW_EIGHT w->scale[c][j] = 0;
        for (int r = 0; r < n; r++)
            LW_EIGHT w->scale[c][j] += w->inv[r][c][j]*w->inv[r][c][j];
    }
    for (int r = 0; w->keep && r < n; r++)
        memcpy(w->jac[r], w->inv[r], (size_t)n*sizeof(lanes8));
    invert(w, n);
    for (int r = 0; r < n; r++) {
        lanes8 row = { 0 };
        for (int c = 0; c < n; c++)
            LW_EIGHT row[j] += w->inv[r][c][j]*w->inv[r][c][j];
        LW_EIGHT sum[j] += row[j]*w->scale[r][j];
    }
    LW_EIGHT {
        int some = sum[j] > 0;
        w->margin[j] = some ? n/(some ? sum[j] : 1) : 0;
    }
}

/* The commonest sizes as code of their own. */
static void factor(eight *w)
{
    switch (w->n) {
    case 2:  factor_of(w, 2); break;
    case 4:  factor_of(w, 4); break;
    case 6:  factor_of(w, 6); break;
    default: factor_of(w, w->n);
    }
}

/* ---- Newton's method ---------------------------------------------------------------------------------- */

LW_INLINE void step_of(eight *w, const int n)
{
    for (int r = 0; r < n; r++) {
        lanes8 s = { 0 };
        for (int c = 0; c < n; c++)
            LW_EIGHT s[j] -= w->inv[r][c][j]*w->f[c][j];
        LW_EIGHT w->step[r][j] = s[j];
    }
}

static void newton_step(eight *w)
{
    residual(w);
    switch (w->n) {
    case 2:  step_of(w, 2); break;
    case 4:  step_of(w, 4); break;
    case 6:  step_of(w, 6); break;
    default: step_of(w, w->n);
    }
}

LW_INLINE double within(double a, double most) { return a > most ? most : a < -most ? -most : a; }

/* Go the step, at most half a radian or half the size; the square of its length. */
static void go(eight *w, lanes8 length)
{
    const lw_higher *g = w->g;
    double most = 0.5*w->size, by_size = 1/w->size;
    LW_EIGHT length[j] = 0;
    for (int a = 0; a < g->n_turn; a++) {
        int at = direction_of(g, a);
        double *ux = w->ux[at], *uy = w->uy[at];
        const double *step = w->step[a];
        LW_EIGHT {
            double t = within(step[j], 0.5), z = t*t;
            double c = 1 - z*(0.5 - z*(1.0/24)), s = t - t*z*(1.0/6 - z*(1.0/120));
            double x = ux[j]*c - uy[j]*s, y = ux[j]*s + uy[j]*c, m = 1.5 - 0.5*(x*x + y*y);
            ux[j] = x*m;
            uy[j] = y*m;
            length[j] += step[j]*step[j];
        }
    }
    for (int d = 0; d < g->n_disp; d++) {
        const double *step = w->step[g->n_turn + d];
        LW_EIGHT {
            w->d[d][j] += within(step[j], most);
            length[j] += step[j]*by_size*(step[j]*by_size);
        }
    }
    turn_directions(w);
}

LW_INLINE double largest(const lanes8 a)
{
    double m = a[0];
    for (int j = 1; j < LW_GROUP; j++)
        m = a[j] > m ? a[j] : m;
    return m;
}

/* ---- as a step of the plan ---------------------------------------------------------------------------- */

static double *inverse_rows(const run *k, const lw_higher *g)
{
    double *at = k->inverse;
    for (const lw_higher *h = k->plan->higher; h < g; h++)
        at += (size_t)(4*h->n_loop*h->n_loop)*k->nb;
    return at;
}

static void take_seat(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    const double *row = k->seat + (size_t)g->first_row*k->seat_row + i;
    for (int a = 0; a < g->n_turn; a++, row += 2*k->seat_row) {
        int at = direction_of(g, a);
        LW_EIGHT {
            w->ux[at][j] = row[j];
            w->uy[at][j] = row[k->seat_row + (size_t)j];
        }
    }
    for (int d = 0; d < g->n_disp; d++, row += k->seat_row)
        LW_EIGHT w->d[d][j] = row[j];
    turn_directions(w);
}

static void put_group(const run *k, const eight *w, size_t i)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_turn; a++) {
        int at = direction_of(g, a);
        double *x = reg_x(k, g->turn_reg[a]) + i, *y = reg_y(k, g->turn_reg[a]) + i;
        LW_EIGHT {
            x[j] = w->ux[at][j];
            y[j] = w->uy[at][j];
        }
    }
    for (int d = 0; d < g->n_disp; d++) {
        double *x = reg_x(k, g->disp_reg[d]) + i, *y = reg_y(k, g->disp_reg[d]) + i;
        LW_EIGHT {
            x[j] = w->d[d][j];
            y[j] = 0;
        }
    }
}

/* From the seat, which is right to 1e-10 or so, or to a part of a thousandth between others, to rounding; lanes out of
 * reach stay where they are. */
static void settle(eight *w, const double *out_of_reach, int want)
{
    const double enough = want == WITH_ROOTS ? 1e-20 : 1e-16;         /* squared; inverses are those before the step */
    lanes8 length;
    for (int i = 0; i < 5; i++) {
        factor(w);
        newton_step(w);
        for (int r = 0; r < w->n; r++)
            LW_EIGHT w->step[r][j] = out_of_reach[j] > 0 || !(fabs(w->step[r][j]) < 0.03*(r < w->g->n_turn ? 1 : w->size))
                                     ? 0 : w->step[r][j];
        go(w, length);
        if (largest(length) < enough)
            break;
    }
    LW_EIGHT w->margin[j] = out_of_reach[j] > 0 ? -out_of_reach[j] : w->margin[j];
}

static void higher(const run *k, const lw_step *s, size_t n, int per_lane, int want)
{
    const lw_higher *g = &k->plan->higher[s->dim[0]];
    const double *reach = k->seat + (size_t)k->plan->n_row*k->seat_row;
    double *inverse = inverse_rows(k, g);
    eight w;
    w.size = 1;
    w.keep = false;
    for (size_t i = 0; i < n; i += LW_GROUP) {
        if (per_lane || i == 0)
            load_vectors(k, &w, g, i, per_lane);
        load_known(k, &w, i, per_lane);
        take_seat(k, &w, i);
        settle(&w, reach + i, want);
        put_group(k, &w, i);
        double *margin = k->margin + i;
        if (want >= WITH_MARGIN)
            LW_EIGHT margin[j] = lw_at_most(w.margin[j], margin[j]);
        for (int r = 0; want == WITH_ROOTS && r < w.n; r++)
            for (int c = 0; c < w.n; c++)
                LW_EIGHT inverse[(size_t)(r*w.n + c)*k->nb + i + (size_t)j] =
                    w.margin[j] > LW_MARGIN_FLAT ? w.inv[r][c][j] : 0;
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
    LW_LANES(n) put(o, i, lw_point(get(q, i), get(w, i), d.x[i], 0));
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
        LW_EIGHT w->f[r][j] = 0;
    for (int c = 0; c < w->n; c++) {
        const double *bar = bar_x(k, c < g->n_turn ? g->turn_reg[c] : g->disp_reg[c - g->n_turn]) + i;
        for (int r = 0; r < w->n; r++)
            LW_EIGHT w->f[r][j] -= inverse[(size_t)(c*w->n + r)*k->nb + (size_t)j]*bar[j];
    }
}

/* Turns of the directions, from the last to those known or given. */
static void back_directions(const run *k, eight *w, size_t i, lanes8 *turn)
{
    const lw_higher *g = w->g;
    for (int a = g->n_dir - 1; a >= 0; a--) {
        const lw_higher_dir *q = &g->dir[a];
        if (q->base < 0 && q->root >= 0)
            continue;
        double *to = (q->dim >= 0 ? dim_bar(k, q->dim) : bar_x(k, q->reg)) + i, sign = q->input < 0 ? -1 : 1;
        LW_EIGHT to[j] += sign*turn[a][j];
        if (q->base >= 0)
            LW_EIGHT turn[q->base][j] += turn[a][j];
    }
}

static void back_eight(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    lanes8 turn[LW_HIGHER_DIR_MAX];
    for (int a = 0; a < g->n_dir; a++)
        LW_EIGHT turn[a][j] = 0;
    for (int p = 0; p < g->n_point; p++) {
        double *x = bar_x(k, g->point[p].reg) + i, *y = bar_y(k, g->point[p].reg) + i, sign = g->point[p].sign;
        const double *fx = w->f[2*g->point[p].loop], *fy = w->f[2*g->point[p].loop + 1];
        LW_EIGHT {
            x[j] += sign*fx[j];
            y[j] += sign*fy[j];
        }
    }
    for (int v = 0; v < g->n_vector; v++) {
        const lw_higher_vector *q = &g->vector[v];
        const double *fx = w->f[2*q->loop], *fy = w->f[2*q->loop + 1], *ux = w->ux[q->dir], *uy = w->uy[q->dir];
        double sign = q->sign, *x = dim_bar(k, q->x), *y = dim_bar(k, q->y);
        if (q->x >= 0)
            LW_EIGHT x[i + (size_t)j] += sign*(fx[j]*ux[j] + fy[j]*uy[j]);
        if (q->y >= 0)
            LW_EIGHT y[i + (size_t)j] += sign*(fy[j]*ux[j] - fx[j]*uy[j]);
    }
    for (int e = 0; e < g->n_entry; e++) {
        int dir = g->entry[e].dir;
        const double *fx = w->f[2*g->entry[e].loop], *fy = w->f[2*g->entry[e].loop + 1];
        const double *cx = w->cx[e], *cy = w->cy[e], *ux = w->ux[dir], *uy = w->uy[dir];
        LW_EIGHT {
            double vx = cx[j]*ux[j] - cy[j]*uy[j], vy = cx[j]*uy[j] + cy[j]*ux[j];
            turn[dir][j] += fy[j]*vx - fx[j]*vy;
        }
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        const double *fx = w->f[2*q->loop], *fy = w->f[2*q->loop + 1], *ux = w->ux[q->dir], *uy = w->uy[q->dir];
        double sign = q->sign, *d_bar = bar_x(k, g->disp_reg[q->disp]) + i;
        LW_EIGHT turn[q->dir][j] += sign*w->d[q->disp][j]*(fy[j]*ux[j] - fx[j]*uy[j]);
        if (q->disp == g->n_disp)
            LW_EIGHT d_bar[j] += sign*(fx[j]*ux[j] + fy[j]*uy[j]);
    }
    back_directions(k, w, i, turn);
}

static void back_higher(const run *k, const lw_step *s, size_t n)
{
    const lw_higher *g = &k->plan->higher[s->dim[0]];
    eight w;
    load_vectors(k, &w, g, 0, 0);
    for (size_t i = 0; i < n; i += LW_GROUP) {
        load_known(k, &w, i, 0);
        for (int a = 0; a < g->n_turn; a++) {
            int at = direction_of(g, a);
            const double *x = reg_x(k, g->turn_reg[a]) + i, *y = reg_y(k, g->turn_reg[a]) + i;
            LW_EIGHT {
                w.ux[at][j] = x[j];
                w.uy[at][j] = y[j];
            }
        }
        for (int d = 0; d < g->n_disp; d++) {
            const double *x = reg_x(k, g->disp_reg[d]) + i;
            LW_EIGHT w.d[d][j] = x[j];
        }
        turn_directions(&w);
        multipliers(k, &w, i);
        back_eight(k, &w, i);
    }
}

#endif
