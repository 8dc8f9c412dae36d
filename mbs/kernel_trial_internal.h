/* mbs/kernel_trial_internal.h - one step in following the higher groups of a plan along the input: eight postures
 * tried, and which of them are sure to be on the way.  Included by mbs/kernel.c alone.
 *
 * Eight inputs further and further along the way are tried at once, each from a polynomial through the postures
 * behind. The way between two neighbouring postures is sure when Newton's method arrived at both and no posture near
 * the curve through them is singular at any input in between: that of the first half as seen from the one, of the
 * second from the other.  With J the Jacobian at one end, K a quarter turn of every loop's two rows and B = J^-1 K
 * J, a column of the Jacobian that is turned by t changes J^-1 J' by  sin t B_j - (1 - cos t) e_j  and no more; so
 * in a box |x' - x| <= r, with z second order in r,
 *     |J^-1 (J' - J)| r <= |B| z(r) + r t^2/2 <= CONTRACTION r < r
 * (Krawczyk 1969; Neumaier 1990, section 5.1) keeps all of its Jacobians regular and its solutions apart.  r is half
 * the movement, what it bends, and how far the polynomial was wrong at the further end, which bounds its error in
 * between; it is widened where that helps. */
#ifndef LW_MBS_KERNEL_TRIAL_INTERNAL_H
#define LW_MBS_KERNEL_TRIAL_INTERNAL_H

#include "mbs/kernel_higher_internal.h"
#include "mbs/kernel_steps_internal.h"

#define PAST 16                            /* postures kept behind                                    */
#define NODES 6                            /* postures a polynomial goes through                      */
#define COARSE 1e-10                       /* squared step of Newton's method after which one more,   */
#define COARSE_LAST 1e-14                  /* with the old inverse, is enough when as short as this   */
#define FINE 1e-24                         /* where none follows                                      */
#define CONTRACTION 0.7

/* A posture of the higher groups. */
typedef struct place { double t, row[LW_ROW_MAX]; } place;

/* How far the way has been gone. */
typedef struct stand {
    place   past[PAST];                    /* a ring; the newest at `head`                            */
    int     head, n_past;
    double  stride;                        /* step to try next, > 0                                   */
    lw_vec2 known[LW_HIGHER_MAX][LW_HIGHER_DIR_MAX];     /* known directions of slides                */
    double  bend[LW_INVERSE_MAX];          /* |B| of each group                                       */
} stand;

typedef struct follower {
    stand   at;
    run     k;                             /* eight lanes                                             */
    const lw_plan *plan;
    double  size;
    bool    on_way;                        /* past the seed                                           */
    bool    lost;                          /* no posture near the seed                                */
    bool    fine;                          /* postures are wanted to rounding, with their inverses    */
    lanes8  c, s;
    lanes8  row[LW_ROW_MAX];               /* of the last trial                                       */
    lanes8  guess[LW_ROW_MAX];             /* where it began                                          */
    lanes8  bend[LW_INVERSE_MAX];          /* |B|                                                     */
    lanes8  margin[LW_HIGHER_MAX];
    lanes8  known_x[LW_HIGHER_MAX][LW_HIGHER_DIR_MAX], known_y[LW_HIGHER_MAX][LW_HIGHER_DIR_MAX];
    bool    sure[LW_GROUP];
    double  need[LW_GROUP];                /* room it takes over what there is          */
    int     at_lane;                       /* of the last trial: the present                          */
    double *trial_inverse;                 /* of the last trial, by lanes                             */
} follower;

static const place *back(const stand *a, int n) { return &a->past[(a->head + n)%PAST]; }

/* ---- one trial in eight lanes ---------------------------------------------------------------------------- */

static void set_input(follower *f, const lanes8 t)
{
    for (int j = 0; j < LW_GROUP; j++) {
        lw_vec2 u = f->plan->input_is_slider ? lw_v2(t[j], 0)
                  : fabs(t[j]) < LW_SINCOS_MAX ? lw_sincos(t[j]) : lw_v2(cos(t[j]), sin(t[j]));
        f->c[j] = u.x;
        f->s[j] = u.y;
    }
}

/* A posture a polynomial goes through: row r is row[r*step]. */
typedef struct node { double t; const double *row; size_t step; } node;

/* Weights of n nodes in the polynomial through them, at t. */
static void weights(const node *at, int n, const lanes8 t, lanes8 *weight)
{
    for (int a = 0; a < n; a++) {
        double bottom = 1, by;
        for (int b = 0; b < n; b++)
            bottom *= b == a ? 1 : at[a].t - at[b].t;
        by = 1/bottom;
        LW_EIGHT weight[a][j] = by;
        for (int b = 0; b < n; b++) {
            double where = at[b].t;
            if (b != a)
                LW_EIGHT weight[a][j] *= t[j] - where;
        }
    }
}

/* Those behind that are as far apart as the step is long. */
static int nodes_behind(const stand *a, double longest, node *to)
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

/* Row by row the nodes' weighted sum, directions made unit vectors. */
static void blend(const lw_higher *g, const node *at, int n, lanes8 *weight, lanes8 *row)
{
    int first = g->first_row, count = 2*g->n_turn + g->n_disp;
    for (int r = first; r < first + count; r++) {
        double *to = row[r];
        LW_EIGHT to[j] = 0;
        for (int p = 0; p < n; p++) {
            double v = at[p].row[(size_t)r*at[p].step];
            LW_EIGHT to[j] += weight[p][j]*v;
        }
    }
    for (int a = 0; a < g->n_turn; a++) {
        double *x = row[first + 2*a], *y = row[first + 2*a + 1];
        LW_EIGHT {
            double m = 1/sqrt(x[j]*x[j] + y[j]*y[j] + LW_TINY2);
            x[j] *= m;
            y[j] *= m;
        }
    }
}

static void take_rows(eight *w, lanes8 *from)
{
    const lw_higher *g = w->g;
    int row = g->first_row;
    for (int a = 0; a < g->n_turn; a++, row += 2) {
        memcpy(w->ux[direction_of(g, a)], from[row], sizeof(lanes8));
        memcpy(w->uy[direction_of(g, a)], from[row + 1], sizeof(lanes8));
    }
    for (int d = 0; d < g->n_disp; d++)
        memcpy(w->d[d], from[row + d], sizeof(lanes8));
    turn_directions(w);
}

static void keep_rows(follower *f, const eight *w)
{
    const lw_higher *g = w->g;
    int row = g->first_row, number = (int)(g - f->plan->higher);
    for (int a = 0; a < g->n_turn; a++, row += 2) {
        memcpy(f->row[row], w->ux[direction_of(g, a)], sizeof(lanes8));
        memcpy(f->row[row + 1], w->uy[direction_of(g, a)], sizeof(lanes8));
    }
    for (int d = 0; d < g->n_disp; d++)
        memcpy(f->row[row + d], w->d[d], sizeof(lanes8));
    for (int e = 0; e < g->n_slide; e++) {
        int dir = g->slide[e].dir;
        if (g->dir[dir].root >= 0)
            continue;
        memcpy(f->known_x[number][dir], w->ux[dir], sizeof(lanes8));
        memcpy(f->known_y[number][dir], w->uy[dir], sizeof(lanes8));
    }
}

/* Newton's method until its steps are short.  A lane whose steps do not shrink is given up, and those behind it, which
 * could not be sure either; `last` is then infinite, else the squared length of the last step. */
static void arrive(eight *w, lanes8 last, bool on_way, bool fine)
{
    lanes8 before, alive;
    LW_EIGHT {
        alive[j] = 1;
        before[j] = INFINITY;
    }
    for (int i = 0; i < (on_way ? 8 : 40); i++) {
        double now = 0;
        factor(w);
        newton_step(w);
        go(w, last);
        for (int j = 0; on_way && j < LW_GROUP; j++) {
            bool shrinks = last[j] <= 0.25 && last[j] <= fmax(0.25*before[j], COARSE_LAST);
            alive[j] = shrinks && (j == 0 || alive[j - 1] > 0) ? alive[j] : 0;
        }
        for (int j = 0; j < LW_GROUP; j++)
            now = alive[j] > 0 && last[j] > now ? last[j] : now;
        if (!(now > (fine ? FINE : COARSE)))
            break;
        memcpy(before, last, sizeof before);
    }
    if (fine)
        factor(w);
    else {
        newton_step(w);
        go(w, last);
    }
    LW_EIGHT last[j] = alive[j] > 0 ? last[j] : INFINITY;
}

/* Where the inverse of a group begins. */
static size_t inverse_at(const follower *f, const lw_higher *g)
{
    size_t at = 0;
    for (const lw_higher *h = f->plan->higher; h < g; h++)
        at += (size_t)(4*h->n_loop*h->n_loop);
    return at;
}

/* ---- what is sure ----------------------------------------------------------------------------------------- */

/* Of the lane before; of the first, the present's. */
LW_INLINE void shift(const double *own, double present, lanes8 before)
{
    before[0] = present;
    for (int j = 1; j < LW_GROUP; j++)
        before[j] = own[j - 1];
}

/* By how much a group has moved since the lane before, and how far off its polynomial was. */
static void movement(const follower *f, const lw_higher *g, lanes8 *moved, lanes8 *off)
{
    const double *present = back(&f->at, 0)->row;
    int row = g->first_row;
    lanes8 x, y;
    for (int a = 0; a < g->n_turn; a++, row += 2) {
        const double *ux = f->row[row], *uy = f->row[row + 1], *gx = f->guess[row], *gy = f->guess[row + 1];
        shift(ux, present[row], x);
        shift(uy, present[row + 1], y);
        LW_EIGHT {
            moved[a][j] = sqrt((ux[j] - x[j])*(ux[j] - x[j]) + (uy[j] - y[j])*(uy[j] - y[j]));
            off[a][j] = sqrt((ux[j] - gx[j])*(ux[j] - gx[j]) + (uy[j] - gy[j])*(uy[j] - gy[j]));
        }
    }
    for (int d = 0; d < g->n_disp; d++, row++) {
        shift(f->row[row], present[row], x);
        LW_EIGHT {
            moved[g->n_turn + d][j] = fabs(f->row[row][j] - x[j]);
            off[g->n_turn + d][j] = fabs(f->row[row][j] - f->guess[row][j]);
        }
    }
}

/* What moves the columns beside the unknowns: the input where it is a joint of the group, slides on known links. */
typedef struct drift { lanes8 input, known[LW_HIGHER_DIR_MAX]; } drift;

static void drifts(const follower *f, const lw_higher *g, const lanes8 t, drift *to)
{
    int number = (int)(g - f->plan->higher);
    lanes8 x, y;
    shift(t, back(&f->at, 0)->t, to->input);
    LW_EIGHT to->input[j] = f->plan->input_is_slider ? 0 : fabs(t[j] - to->input[j]);
    for (int e = 0; e < g->n_slide; e++) {
        int dir = g->slide[e].dir;
        const double *ux = f->known_x[number][dir], *uy = f->known_y[number][dir];
        if (g->dir[dir].root >= 0)
            continue;
        shift(ux, f->at.known[number][dir].x, x);
        shift(uy, f->at.known[number][dir].y, y);
        LW_EIGHT to->known[dir][j] = sqrt((ux[j] - x[j])*(ux[j] - x[j]) + (uy[j] - y[j])*(uy[j] - y[j]));
    }
}

/* z: by how much each column changes in a box of sides r, times r. */
static void bend(const lw_higher *g, const drift *by, lanes8 *r, lanes8 *z)
{
    for (int a = 0; a < g->n_turn; a++)
        LW_EIGHT z[a][j] = r[a][j]*r[a][j];
    for (int d = 0; d < g->n_disp; d++)
        LW_EIGHT z[g->n_turn + d][j] = 0;
    for (int a = 0; a < g->n_dir; a++)
        if (g->dir[a].input && g->dir[a].root >= 0) {
            double *to = z[g->dir[a].root];
            const double *side = r[g->dir[a].root];
            LW_EIGHT to[j] += side[j]*by->input[j];
        }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        if (q->disp >= g->n_disp)
            continue;
        double *to = z[g->n_turn + q->disp];
        const double *side = r[g->n_turn + q->disp], *turn = g->dir[q->dir].root >= 0 ? r[g->dir[q->dir].root] : NULL;
        if (turn)
            LW_EIGHT to[j] = lw_at_least(2*side[j]*turn[j], to[j]);
        else
            LW_EIGHT to[j] = lw_at_least(side[j]*by->known[q->dir][j], to[j]);
    }
}

/* |B| z, B = J^-1 K J. */
LW_INLINE void bent(const int n, lanes8 *b, lanes8 *z, lanes8 *to)
{
    for (int r = 0; r < n; r++) {
        LW_EIGHT to[r][j] = 0;
        for (int c = 0; c < n; c++)
            LW_EIGHT to[r][j] += b[r*n + c][j]*z[c][j];
    }
}

LW_INLINE void quarter(const eight *w, const int n, lanes8 *b)
{
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) {
            lanes8 s = { 0 };
            for (int l = 0; l < n; l += 2)
                LW_EIGHT s[j] += w->inv[r][l + 1][j]*w->jac[l][c][j] - w->inv[r][l][j]*w->jac[l + 1][c][j];
            LW_EIGHT b[r*n + c][j] = fabs(s[j]);
        }
}

/* Are the Jacobians in the box, or in a wider one, regular?  need: the room that it takes over what there is, <= 1. */
LW_INLINE void regular(const lw_higher *g, const int n, lanes8 *b, const drift *by, lanes8 *box, lanes8 need)
{
    lanes8 r[LW_UNKNOWN_MAX], z[LW_UNKNOWN_MAX], s[LW_UNKNOWN_MAX];
    memcpy(r, box, (size_t)n*sizeof *r);
    for (int again = 0; again < 4; again++) {
        bend(g, by, r, z);
        bent(n, b, z, s);
        LW_EIGHT need[j] = 0;
        for (int i = 0; i < n; i++) {
            double turns = i < g->n_turn ? 0.5 : 0;
            LW_EIGHT {
                double needs = (s[i][j] + turns*r[i][j]*r[i][j]*r[i][j])*(1/CONTRACTION);
                need[j] = lw_at_least(needs/lw_at_least(r[i][j], LW_TINY), need[j]);
                r[i][j] = lw_at_least(1.1*needs, r[i][j]);
            }
        }
        if (largest(need) <= 1)
            break;
    }
}

LW_INLINE void compare_of(follower *f, const eight *w, const int n, const lanes8 t)
{
    const lw_higher *g = w->g;
    drift by;
    lanes8 *b = f->bend + inverse_at(f, g), before[LW_UNKNOWN_MAX*LW_UNKNOWN_MAX];
    lanes8 r[LW_UNKNOWN_MAX], z[LW_UNKNOWN_MAX], s[LW_UNKNOWN_MAX], off[LW_UNKNOWN_MAX], most = { 0 }, here, there;
    drifts(f, g, t, &by);
    movement(f, g, r, off);
    for (int i = 0; i < n*n; i++)
        shift(b[i], f->at.bend[inverse_at(f, g) + (size_t)i], before[i]);
    bend(g, &by, r, z);
    bent(n, b, z, s);
    for (int i = 0; i < n; i++) {
        double by_unit = i < g->n_turn ? 1 : 1/f->size;
        LW_EIGHT most[j] = lw_at_least(r[i][j]*by_unit, most[j]);
    }
    for (int i = 0; i < n; i++) {
        double least = 0.05*(i < g->n_turn ? 1 : f->size);
        LW_EIGHT r[i][j] = 0.5*r[i][j] + 0.25*s[i][j] + off[i][j] + least*most[j];
    }
    regular(g, n, b, &by, r, here);
    regular(g, n, before, &by, r, there);
    for (int j = 0; j < LW_GROUP; j++)
        f->need[j] = fmax(f->need[j], f->sure[j] ? fmax(here[j], there[j]) : INFINITY);
    for (int j = 0; j < LW_GROUP; j++)
        f->sure[j] = f->sure[j] && f->need[j] <= 1;
}

static void bend_here(follower *f, const eight *w)
{
    lanes8 *b = f->bend + inverse_at(f, w->g);
    switch (w->n) {
    case 2:  quarter(w, 2, b); break;
    case 4:  quarter(w, 4, b); break;
    case 6:  quarter(w, 6, b); break;
    default: quarter(w, w->n, b);
    }
}

static void compare(follower *f, const eight *w, const lanes8 t)
{
    switch (w->n) {
    case 2:  compare_of(f, w, 2, t); break;
    case 4:  compare_of(f, w, 4, t); break;
    case 6:  compare_of(f, w, 6, t); break;
    default: compare_of(f, w, w->n, t);
    }
}

/* Group g in the eight lanes. */
static void solve_group(follower *f, eight *w, const lw_higher *g, const lanes8 t, const node *behind, int n,
                        lanes8 *weight)
{
    int number = (int)(g - f->plan->higher);
    lanes8 last;
    load_vectors(&f->k, w, g, 0, 0);
    load_known(&f->k, w, 0, 0);
    w->size = f->size;
    w->keep = true;
    blend(g, behind, n, weight, f->guess);
    take_rows(w, f->guess);
    arrive(w, last, f->on_way, f->fine);
    put_group(&f->k, w, 0);
    keep_rows(f, w);
    bend_here(f, w);
    double *to = f->trial_inverse + inverse_at(f, g)*LW_GROUP, most = f->fine ? 1e-20 : COARSE_LAST;
    for (int r = 0; f->fine && r < w->n; r++)
        for (int c = 0; c < w->n; c++, to += LW_GROUP)
            memcpy(to, w->inv[r][c], sizeof(lanes8));
    for (int j = 0; j < LW_GROUP; j++) {
        f->margin[number][j] = w->margin[j];
        f->sure[j] = f->sure[j] && last[j] <= most && w->margin[j] > 0;
    }
    if (f->on_way)
        compare(f, w, t);
}

static void trial(follower *f, const lanes8 t)
{
    eight w;
    node behind[NODES];
    lanes8 weight[NODES];
    const lw_plan *p = f->plan;
    double longest = 0;
    for (int j = 0; j < LW_GROUP; j++)
        longest = fmax(longest, fabs(t[j] - back(&f->at, 0)->t));
    int n = nodes_behind(&f->at, longest, behind);
    weights(behind, n, t, weight);
    set_input(f, t);
    for (int j = 0; j < LW_GROUP; j++) {
        f->sure[j] = true;
        f->need[j] = 0;
    }
    for (int i = 0, left = p->n_higher; left > 0 && i < p->n_step; i++) {
        const lw_step *s = &p->step[i];
        if (s->kind != LW_STEP_HIGHER) {
            forward_shared_pose(&f->k, s, LW_GROUP);
            continue;
        }
        solve_group(f, &w, &p->higher[s->dim[0]], t, behind, n, weight);
        left--;
    }
}

/* Lanes first .. last of the trial become the past. */
static void accept(follower *f, const lanes8 t, int count)
{
    stand *a = &f->at;
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
    for (int h = 0; h < f->plan->n_higher; h++)
        for (int e = 0; e < f->plan->higher[h].n_slide; e++) {
            int dir = f->plan->higher[h].slide[e].dir;
            a->known[h][dir] = lw_v2(f->known_x[h][dir][f->at_lane], f->known_y[h][dir][f->at_lane]);
        }
}

#endif
