/* mbs/batch/kernel_certified_step_internal.h - one step of the continuation of higher groups: try eight postures and
 * prove which of them lie on the motion curve.  Included by kernel_continuation.c alone.
 *
 * The eight inputs follow each other along the path.  Newton's method starts at each from a polynomial through the
 * postures before.  The step between two neighbouring postures is certified when Newton's method has converged at both
 * and no posture near the curve between them is singular.  Each end proves this for its half of the step.
 *
 * Let J be the Jacobian at one end, K a quarter turn of every loop's two rows and B = J^-1 K J.  Turning column j of
 * the Jacobian by t changes J^-1 J' by  sin t B_j - (1 - cos t) e_j.  All Jacobians in a box |x' - x| <= r are regular,
 * and the box has at most one solution, when
 *     |J^-1 (J' - J)| r <= |B| z(r) + r t^2/2 <= CONTRACTION r < r
 * with z of second order in r (Krawczyk 1969; Neumaier 1990, section 5.1).  If the input is a joint of the group, it
 * changes the columns by dQ of its own, which adds |J^-1 dQ| r.  The box r holds half the movement, its curvature, and
 * the error of the polynomial at the far end, which bounds the error in between.  It is widened when that helps. */
#ifndef LW_MBS_BATCH_KERNEL_CERTIFIED_STEP_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_CERTIFIED_STEP_INTERNAL_H

#include "mbs/batch/kernel_newton_internal.h"

#define PAST 16                            /* postures kept from the steps before                     */
#define NODES 6                            /* postures that a polynomial passes through               */
#define COARSE 1e-10                       /* after this squared step of Newton's method one more step */
#define COARSE_LAST 1e-14                  /* with the old inverse follows, which must be this short   */
#define FINE 1e-24                         /* after this squared step none follows                     */
#define ROUNDING 1e-28                     /* divided by the margin: squared step left by 50 roundings  */
#define SINGULAR 1e-24                     /* a smaller margin is that of a singular Jacobian and rounding */
#define CONTRACTION 0.7
#define GEARED_MOST 0.5                    /* largest turn in a box of a group with gears             */

/* A posture of the higher groups. */
typedef struct place { double t, row[LW_GROUP_ROW_MAX]; } place;

/* The progress of the continuation. */
typedef struct progress {
    place   past[PAST];                    /* a ring; the newest at `head`                            */
    int     head, n_past;
    double  stride;                        /* next step to try, > 0                                   */
    lw_vec2 known[LW_HIGHER_MAX][LW_HIGHER_DIR_MAX];     /* known directions of slides                */
    double  bend[LW_INVERSE_MAX];          /* |B| of each group                                       */
    double  push[LW_INVERSE_MAX];          /* |J^-1 dQ| of each column, by the input                  */
} progress;

typedef struct follower {
    progress   at;
    run     k;                             /* eight lanes                                             */
    const lw_plan *plan;
    double  size;
    bool    past_seed;                     /* false while Newton's method looks for the seed posture  */
    bool    pushed;                        /* the input is a joint of a group                         */
    bool    tight;                         /* near the limit of a group or dyad: do not interpolate   */
    bool    lost;                          /* no posture near the seed                                */
    bool    fine;                          /* converge to rounding, with an inverse at the solution   */
    int     at_lane;                       /* the last posture accepted is this one of the last try   */
    pack    c, s;
    pack    row[LW_GROUP_ROW_MAX];         /* rows of the last try                                    */
    pack    guess[LW_GROUP_ROW_MAX];       /* its first guess                                         */
    pack    bend[LW_INVERSE_MAX], push[LW_INVERSE_MAX];
    pack    bend_before[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX], push_before[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX];
    pack    known_x[LW_HIGHER_MAX][LW_HIGHER_DIR_MAX], known_y[LW_HIGHER_MAX][LW_HIGHER_DIR_MAX];
    mask    certified;
    pack    margin;                        /* the least of all groups                                 */
    pack    need;                          /* size needed for the box over its size, <= 1: certified  */
    eight   group[LW_HIGHER_MAX];
} follower;

static const place *back(const progress *a, int n) { return &a->past[(a->head + n)%PAST]; }

/* ---- postures at eight inputs ---------------------------------------------------------------------------- */

static void set_input(follower *f, pack t)
{
    double angle[LW_GROUP], c[LW_GROUP], s[LW_GROUP];
    f->c = t;
    f->s = (pack){ 0 };
    if (f->plan->input_is_slider)
        return;
    put8(angle, t);
    turns(angle, LW_GROUP, c, s);
    f->c = get8(c);
    f->s = get8(s);
}

/* A posture that a polynomial passes through: row r is row[r*step]. */
typedef struct node { double t; const double *row; size_t step; } node;

/* The constants of the polynomial through n nodes: products of 1/(t_a - t_b). */
static void constants(const node *at, int n, double *by)
{
    for (int a = 0; a < n; a++) {
        double bottom = 1;
        for (int b = 0; b < n; b++)
            bottom *= b == a ? 1 : at[a].t - at[b].t;
        by[a] = 1/bottom;
    }
}

/* Weights of the n nodes in the polynomial through them, at t. */
LW_INLINE void weights(const node *at, int n, const double *by, pack t, pack *weight)
{
    pack before = all8(1), after = all8(1);
    for (int a = 0; a < n; a++) {
        weight[a] = by[a]*before;
        before *= t - at[a].t;
    }
    for (int a = n - 1; a >= 0; a--) {
        weight[a] *= after;
        after *= t - at[a].t;
    }
}

/* Select earlier postures whose distances suit the length of the step. */
static int nodes_behind(const progress *a, double longest, node *to)
{
    static const double reach[NODES] = { 0, 0.25, 0.5, 0.6, 0.8, 1 };
    double now = back(a, 0)->t;
    int n = 0;
    for (int i = 0; i < a->n_past && n < NODES; i++) {
        const place *p = back(a, i);
        if (i == 0 || (fabs(p->t - now) >= reach[n]*longest && p->t != to[n - 1].t))
            to[n++] = (node){ p->t, p->row, 1 };
    }
    return n;
}

/* The weighted sum of the nodes, with directions made unit vectors.  near: their lengths are within 0.001 of 1. */
LW_INLINE void blend(const lw_higher *g, const node *at, int n, const pack *weight, const int near, pack *row)
{
    int first = g->first_row, turned = first + 2*g->n_turn;
    for (int r = first; r < turned + g->n_disp; r++) {
        pack sum = weight[0]*at[0].row[(size_t)r*at[0].step];
        for (int p = 1; p < n; p++)
            sum += weight[p]*at[p].row[(size_t)r*at[p].step];
        row[r] = sum;
    }
    for (int r = first; r < turned; r += 2) {
        pack x = row[r], y = row[r + 1], z = x*x + y*y, m = near ? 1.5 - 0.5*z : 1/root8(z + LW_TINY2);
        row[r] = x*m;
        row[r + 1] = y*m;
    }
}

static void take_rows(eight *w, const pack *from)
{
    const lw_higher *g = w->g;
    from += g->first_row;
    for (int a = 0; a < g->n_turn; a++) {
        w->ux[w->at[a]] = *from++;
        w->uy[w->at[a]] = *from++;
    }
    for (int d = 0; d < g->n_disp; d++)
        w->d[d] = *from++;
    turn_directions(w);
}

static void keep_rows(follower *f, const eight *w)
{
    const lw_higher *g = w->g;
    int number = (int)(g - f->plan->higher);
    pack *to = f->row + g->first_row;
    for (int a = 0; a < g->n_turn; a++) {
        *to++ = w->ux[w->at[a]];
        *to++ = w->uy[w->at[a]];
    }
    for (int d = 0; d < g->n_disp; d++)
        *to++ = w->d[d];
    for (int e = 0; e < g->n_slide; e++) {
        int dir = g->slide[e].dir;
        if (g->dir[dir].root >= 0)
            continue;
        f->known_x[number][dir] = w->ux[dir];
        f->known_y[number][dir] = w->uy[dir];
    }
}

/* The number of lanes, from the first on, whose steps are short or become shorter. */
static int shrinking(pack last, pack before, int n)
{
    mask not = ~((mask)(last <= 0.25) & (mask)(last <= more8(0.25*before, all8(COARSE_LAST))));
    for (int j = 0; any8(not) && j < n; j++)
        if (not[j])
            return j;
    return n;
}

/* Apply Newton's method until its steps are short.  A lane whose steps do not become shorter is given up, with all
 * lanes behind it, which could not be certified.  *last: squared length of the last step; infinite where given up. */
LW_INLINE void converge(const int n, eight *w, bool past_seed, bool fine, pack *last)
{
    pack before = all8(INFINITY);
    int alive = LW_GROUP;
    for (int i = 0; i < (past_seed ? 8 : 40); i++) {
        double now = 0;
        newton_of(n, w);
        *last = apply_step(w);
        if (past_seed)
            alive = shrinking(*last, before, alive);
        for (int j = 0; j < alive; j++)
            now = (*last)[j] > now ? (*last)[j] : now;
        if (!(now > (fine ? FINE : COARSE)))
            break;
        before = *last;
    }
    if (fine) {
        newton(w);
        measure(w);
    } else {
        newton_again_of(n, w);
        *last = apply_step(w);
    }
    for (int j = alive; j < LW_GROUP; j++)
        (*last)[j] = INFINITY;
}

/* The index at which the inverse of a group begins. */
static size_t inverse_at(const follower *f, const lw_higher *g)
{
    size_t at = 0;
    for (const lw_higher *h = f->plan->higher; h < g; h++)
        at += (size_t)(h->n_unknown*h->n_unknown);
    return at;
}

/* ---- certificates ----------------------------------------------------------------------------------------- */

/* moved: movement of each unknown since the lane before; off: bound of the error of its polynomial. */
static void movement(const follower *f, const lw_higher *g, pack *moved, pack *off)
{
    const double *present = back(&f->at, 0)->row + g->first_row;
    const pack *row = f->row + g->first_row, *guess = f->guess + g->first_row;
    for (int a = 0; a < g->n_turn; a++, row += 2, guess += 2, present += 2) {
        pack x = row[0] - before8(row[0], present[0]), y = row[1] - before8(row[1], present[1]);
        moved[a] = root8(x*x + y*y);
        off[a] = abs8(row[0] - guess[0]) + abs8(row[1] - guess[1]);
    }
    for (int d = 0; d < g->n_disp; d++) {
        moved[g->n_turn + d] = abs8(row[d] - before8(row[d], present[d]));
        off[g->n_turn + d] = abs8(row[d] - guess[d]);
    }
}

/* Other movements that change columns: the input, if it is a joint of the group, and turns of slides on known links. */
typedef struct drift { pack input, known[LW_HIGHER_DIR_MAX]; } drift;

static void drifts(const follower *f, const lw_higher *g, pack t, drift *to)
{
    int number = (int)(g - f->plan->higher);
    to->input = f->plan->input_turns_per_period*abs8(t - before8(t, back(&f->at, 0)->t));
    for (int e = 0; e < g->n_slide; e++) {
        int dir = g->slide[e].dir;
        if (g->dir[dir].root >= 0)
            continue;
        lw_vec2 present = f->at.known[number][dir];
        pack ux = f->known_x[number][dir], uy = f->known_y[number][dir];
        pack x = ux - before8(ux, present.x), y = uy - before8(uy, present.y);
        to->known[dir] = root8(x*x + y*y);
    }
}

/* z: the change of each column in a box of sides r, times r. */
LW_INLINE void bend(const eight *w, const drift *by, const pack *r, pack *z)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_turn; a++)
        z[a] = r[a]*r[a];
    for (int d = 0; d < g->n_disp; d++)
        z[g->n_turn + d] = (pack){ 0 };
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        int root = g->dir[q->dir].root;
        if (q->disp >= g->n_disp)
            continue;
        pack *to = &z[g->n_turn + q->disp], side = r[g->n_turn + q->disp];
        pack turned = root >= 0 ? 2*r[root] : by->known[q->dir];
        if (root >= 0 && w->moves[q->dir])
            turned += by->input;
        *to = more8(side*turned, *to);
    }
}

/* to = |B| z and the part of the input: |J^-1 (J' - J)| r without the term r t^2/2. */
LW_INLINE void bent(const int n, const eight *w, const pack *b, const pack *push, const drift *by, const pack *r, const pack *z, pack *to)
{
    for (int i = 0; i < n; i++) {
        to[i] = b[i*n]*z[0];
        for (int c = 1; c < n; c++)
            to[i] += b[i*n + c]*z[c];
        for (int c = 0; w->driven && c < n; c++)
            to[i] += push[i*n + c]*r[c]*by->input;
    }
}

/* B = J^-1 K J, where K turns the rows of loops. */
LW_INLINE void quarter_rows(const int n, const eight *w, const int loops, pack *b)
{
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) {
            pack s = { 0 };
            for (int l = 0; l < loops; l += 2)
                s += w->inv[r*n + l + 1]*w->jac[l*n + c] - w->inv[r*n + l]*w->jac[(l + 1)*n + c];
            b[r*n + c] = abs8(s);
        }
}

/* The rows G of gears do not change when a column is turned.  So the second order (1 - cos t) e_j lacks a part
 * J^-1 (0, G), of which t/4 is an upper bound for turns t below GEARED_MOST; larger turns are rejected. */
LW_INLINE void quarter_of(const int n, const eight *w, pack *b)
{
    if (!w->g->n_gear) {
        quarter_rows(n, w, n, b);
        return;
    }
    const int loops = 2*w->g->n_loop;
    quarter_rows(n, w, loops, b);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) {
            pack s = { 0 };
            for (int l = loops; l < n; l++)
                s += w->inv[r*n + l]*w->jac[l*n + c];
            b[r*n + c] += 0.25*abs8(s);
        }
}

/* Add |J^-1 dQ|, where dQ has (x, y) in column c and the two rows of a loop. */
LW_INLINE void push_loop(const eight *w, const int n, int loop, int c, pack x, pack y, pack *push)
{
    for (int r = 0; r < n; r++)
        push[r*n + c] += abs8(w->inv[r*n + 2*loop]*x + w->inv[r*n + 2*loop + 1]*y);
}

/* |J^-1 dQ| for a change of the input by 1: the input turns some columns (a quarter of the second order is added, for
 * steps below 1/2) and displaces others. */
LW_INLINE void pushes_of(const int n, const eight *w, pack *push)
{
    const lw_higher *g = w->g;
    for (int i = 0; i < n*n; i++)
        push[i] = (pack){ 0 };
    for (int e = 0; e < g->n_entry; e++) {
        int dir = g->entry[e].dir, root = g->dir[dir].root;
        if (root < 0 || !w->moves[dir])
            continue;
        pack cx = w->cx[e], cy = w->cy[e], ux = w->ux[dir], uy = w->uy[dir], x = cx*ux - cy*uy, y = cx*uy + cy*ux;
        push_loop(w, n, g->entry[e].loop, root, x, y, push);
        push_loop(w, n, g->entry[e].loop, root, -0.25*y, 0.25*x, push);
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        int root = g->dir[q->dir].root;
        pack d = w->d[q->disp], x = w->ux[q->dir], y = w->uy[q->dir];
        if (root >= 0 && w->moves[q->dir]) {
            push_loop(w, n, q->loop, root, d*x, d*y, push);
            push_loop(w, n, q->loop, root, -0.25*d*y, 0.25*d*x, push);
        }
        if (root >= 0 && q->disp == g->n_disp)
            push_loop(w, n, q->loop, root, -y, x, push);
    }
}
LW_BY_SIZE(pushes, (const eight *w, pack *push), w, push)

/* Test whether all Jacobians in the box, or in a wider one, are regular: *need <= 1. */
LW_INLINE void regular_of(const int n, const eight *w, const pack *b, const pack *push, const drift *by, const pack *box, pack *need)
{
    pack r[LW_UNKNOWN_MAX], z[LW_UNKNOWN_MAX], s[LW_UNKNOWN_MAX];
    for (int i = 0; i < n; i++)
        r[i] = box[i];
    for (int again = 0; again < 4; again++) {
        bend(w, by, r, z);
        bent(n, w, b, push, by, r, z, s);
        *need = (pack){ 0 };
        for (int i = 0; i < n; i++) {
            double turned = i < w->g->n_turn ? 0.5 : 0;
            pack needs = (s[i] + turned*r[i]*r[i]*r[i])*(1/CONTRACTION);
            *need = more8(needs/more8(r[i], all8(LW_TINY)), *need);
            r[i] = more8(1.1*needs, r[i]);
            if (w->g->n_gear && i < w->g->n_turn)
                *need = choose8((mask)(r[i] <= GEARED_MOST), *need, all8(INFINITY));
        }
        if (!any8(~(mask)(*need <= 1)))
            break;
    }
}
LW_BY_SIZE(regular, (const eight *w, const pack *b, const pack *push, const drift *by, const pack *box, pack *need),
           w, b, push, by, box, need)

/* Certify the steps of the eight lanes, each from the lane before. */
LW_INLINE void certify(const int n, follower *f, const eight *w, pack t)
{
    const lw_higher *g = w->g;
    drift by;
    size_t first = inverse_at(f, g);
    const pack *b = f->bend + first, *push = f->push + first;
    pack *b_before = f->bend_before, *push_before = f->push_before;
    pack r[LW_UNKNOWN_MAX], z[LW_UNKNOWN_MAX], s[LW_UNKNOWN_MAX], off[LW_UNKNOWN_MAX], most = { 0 }, here, there;
    drifts(f, g, t, &by);
    movement(f, g, r, off);
    for (int i = 0; i < n*n; i++)
        b_before[i] = before8(b[i], f->at.bend[first + (size_t)i]);
    for (int i = 0; w->driven && i < n*n; i++)
        push_before[i] = before8(push[i], f->at.push[first + (size_t)i]);
    bend(w, &by, r, z);
    bent(n, w, b, push, &by, r, z, s);
    for (int i = 0; i < n; i++)
        most = more8(r[i]*(i < g->n_turn ? 1 : 1/f->size), most);
    for (int i = 0; i < n; i++)
        r[i] = 0.5*r[i] + 0.25*s[i] + off[i] + 0.05*(i < g->n_turn ? 1 : f->size)*most;
    regular(w, b, push, &by, r, &here);
    regular(w, b_before, push_before, &by, r, &there);
    f->need = more8(more8(here, there), f->need);
    f->need = choose8(f->certified, f->need, all8(INFINITY));
    f->certified &= (mask)(f->need <= 1);
}

/* Solve group w in the eight lanes. */
LW_INLINE void solve_of(const int n, eight *w, follower *f, pack t)
{
    pack last, row = { 0 }, most = all8(COARSE_LAST);
    converge(n, w, f->past_seed, f->fine, &last);
    if (!f->fine)
        measure_of(n, w);
    f->margin = less8(w->margin, f->margin);
    if (f->fine)
        most = more8(all8(1e-20), ROUNDING/more8(w->margin, all8(SINGULAR)));
    put_group(&f->k, w, 0);
    keep_rows(f, w);
    quarter_of(n, w, f->bend + inverse_at(f, w->g));
    if (w->driven)
        pushes(w, f->push + inverse_at(f, w->g));
    for (int c = 0; c < n; c++)                              /* 0 for a singular Jacobian */
        row += w->inv[c]*w->inv[c];
    mask singular = ~(mask)(row > 0) | ((mask)(w->margin >= 0) & (mask)(w->margin < SINGULAR));      /* < 0: a rack ends */
    f->certified &= (mask)(last <= most) & ~singular;
    if (f->past_seed)
        certify(n, f, w, t);
}
LW_BY_SIZE(solve, (eight *w, follower *f, pack t), w, f, t)

/* Find the postures at eight inputs; f->certified, need, margin and row hold the results. */
static void try_steps(follower *f, pack t)
{
    node behind[NODES];
    pack weight[NODES];
    const lw_plan *p = f->plan;
    double by[NODES];
    int n = nodes_behind(&f->at, most8(abs8(t - back(&f->at, 0)->t)), behind);
    constants(behind, n, by);
    weights(behind, n, by, t, weight);
    set_input(f, t);
    f->certified = ~(mask){ 0 };
    f->need = (pack){ 0 };
    f->margin = all8(1);
    put8(f->k.margin, all8(1));
    for (int i = 0, left = p->n_higher; left > 0 && i < p->n_step; i++) {
        const lw_step *s = &p->step[i];
        if (s->kind != LW_STEP_HIGHER) {
            lw_forward_step(&f->k, s, LW_GROUP);
            continue;
        }
        eight *w = &f->group[s->dim[0]];
        load_known(&f->k, w, 0, 0);
        blend(w->g, behind, n, weight, 0, f->guess);
        take_rows(w, f->guess);
        solve(w, f, t);
        left--;
    }
}

/* Accept the first `count` postures of the last try. */
static void accept(follower *f, pack t, int count)
{
    progress *a = &f->at;
    for (int j = 0; j < count; j++) {
        if (a->n_past == 0 || back(a, 0)->t != t[j]) {
            a->head = (a->head + PAST - 1)%PAST;
            a->n_past += a->n_past < PAST;
        }
        place *p = &a->past[a->head];
        p->t = t[j];
        for (int r = 0; r < f->plan->n_row; r++)
            p->row[r] = f->row[r][j];
    }
    f->at_lane = count - 1;
    for (size_t i = 0, n = lw_inverse_rows(f->plan); i < n; i++)
        a->bend[i] = f->bend[i][f->at_lane];
    for (size_t i = 0, n = f->pushed ? lw_inverse_rows(f->plan) : 0; i < n; i++)
        a->push[i] = f->push[i][f->at_lane];
    for (int h = 0; h < f->plan->n_higher; h++)
        for (int e = 0; e < f->plan->higher[h].n_slide; e++) {
            int dir = f->plan->higher[h].slide[e].dir;
            a->known[h][dir] = lw_v2(f->known_x[h][dir][f->at_lane], f->known_y[h][dir][f->at_lane]);
        }
}

#endif
