/* mbs/kernel_follow_internal.h - following the higher groups of a plan from their seed along the input.  Included by
 * mbs/kernel.c alone.
 *
 * A step is tried in eight lengths at once, each half the one before; the longest that is sure is taken.  Sure
 * is a step when Newton's method arrives and the directions have moved by no more than half of what the margin
 * allows at its start and at its end (kernel_higher_internal.h).  At a limit of motion the margin falls to 0 and
 * the steps with it, until they are too short to matter: there the way ends. */
#ifndef LW_MBS_KERNEL_FOLLOW_INTERNAL_H
#define LW_MBS_KERNEL_FOLLOW_INTERNAL_H

#include "mbs/kernel_higher_internal.h"
#include "mbs/kernel_steps_internal.h"

#define PAST 6                             /* postures a predictor looks back on                      */
#define STRIDE_MAX 0.35                    /* longest step: [rad], or times the size                  */
#define COARSE 1e-17                       /* where a full step of Newton's method follows            */
#define FINE 1e-24                         /* where none does                                         */
#define SURE 0.25                          /* a half, squared                                         */

/* A posture of the higher groups. */
typedef struct place { double t, row[LW_ROW_MAX]; } place;

typedef struct follower {
    run     k;                             /* eight lanes                                             */
    const lw_plan *plan;
    const double  *dim, *mode;
    double  size;
    place   past[PAST];                    /* the present one first                                   */
    int     n_past;
    bool    lost;                          /* no posture near the seed                                */
    double  fine;                          /* squared length of a last step: the next is shorter by far */
    double  allowed[LW_HIGHER_MAX];        /* squared movement within which the present is alone      */
    lanes8  c, s;
    lanes8  row[LW_ROW_MAX];               /* of the last trial                                       */
    lanes8  margin[LW_HIGHER_MAX];
    bool    sure[LW_GROUP];
    double  inverse[LW_INVERSE_MAX];       /* of the present                                          */
    double *trial_inverse;                 /* of the last trial, by lanes                             */
} follower;

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

/* Weights of the past in the polynomial through it, of as high an order as the step is not long for. */
static int weights(const follower *f, const lanes8 t, lanes8 *weight)
{
    static const double reach[PAST] = { 0, 0.25, 0.5, 0.6, 0.8, 1 };
    double longest = 0;
    int n = 1;
    for (int j = 0; j < LW_GROUP; j++)
        longest = fmax(longest, fabs(t[j] - f->past[0].t));
    while (n < f->n_past && fabs(f->past[n].t - f->past[0].t) >= reach[n]*longest)
        n++;
    for (int a = 0; a < n; a++) {
        double bottom = 1;
        LW_EIGHT weight[a][j] = 1;
        for (int b = 0; b < n; b++) {
            double at = f->past[b].t;
            if (b == a)
                continue;
            bottom *= f->past[a].t - at;
            LW_EIGHT weight[a][j] *= t[j] - at;
        }
        double by = 1/bottom;
        LW_EIGHT weight[a][j] *= by;
    }
    return n;
}

static void predict(const follower *f, eight *w, int n, lanes8 *weight)
{
    const lw_higher *g = w->g;
    int row = g->first_row;
    for (int a = 0; a < g->n_turn; a++, row += 2) {
        int at = direction_of(g, a);
        double *ux = w->ux[at], *uy = w->uy[at];
        LW_EIGHT ux[j] = uy[j] = 0;
        for (int p = 0; p < n; p++)
            LW_EIGHT {
                ux[j] += weight[p][j]*f->past[p].row[row];
                uy[j] += weight[p][j]*f->past[p].row[row + 1];
            }
        LW_EIGHT {
            double m = 1/sqrt(ux[j]*ux[j] + uy[j]*uy[j] + LW_TINY2);
            ux[j] *= m;
            uy[j] *= m;
        }
    }
    for (int d = 0; d < g->n_disp; d++, row++) {
        LW_EIGHT w->d[d][j] = 0;
        for (int p = 0; p < n; p++)
            LW_EIGHT w->d[d][j] += weight[p][j]*f->past[p].row[row];
    }
    turn_directions(w);
}

/* Newton's method, with the inverse at hand as long as it gains two digits a step.  Lanes that go further in one
 * step than `allowed` (squared) are given up: they will not be sure.  Squared length of the last step. */
static void arrive(eight *w, lanes8 last, bool have_inverse, double allowed, double fine, int most)
{
    double before = INFINITY;
    lanes8 alive;
    LW_EIGHT alive[j] = 1;
    for (int i = 0; i < most; i++) {
        double now = 0;
        if (!have_inverse)
            factor(w);
        newton_step(w);
        go(w, last);
        LW_EIGHT alive[j] = last[j] <= allowed ? alive[j] : 0;
        for (int j = 0; j < LW_GROUP; j++)
            now = alive[j] > 0 && last[j] > now ? last[j] : now;
        if (!(now > fine))
            break;
        have_inverse = have_inverse && i < 6 && now < 0.05*before && now < 1e-2;
        before = now;
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

static void keep_rows(follower *f, const eight *w)
{
    const lw_higher *g = w->g;
    int row = g->first_row;
    for (int a = 0; a < g->n_turn; a++, row += 2) {
        memcpy(f->row[row], w->ux[direction_of(g, a)], sizeof(lanes8));
        memcpy(f->row[row + 1], w->uy[direction_of(g, a)], sizeof(lanes8));
    }
    for (int d = 0; d < g->n_disp; d++)
        memcpy(f->row[row + d], w->d[d], sizeof(lanes8));
}

/* Squared movement since the present posture. */
static void movement(const follower *f, const lw_higher *g, lanes8 moved)
{
    int row = g->first_row;
    LW_EIGHT moved[j] = 0;
    for (int a = 0; a < 2*g->n_turn; a++, row++)
        LW_EIGHT moved[j] += (f->row[row][j] - f->past[0].row[row])*(f->row[row][j] - f->past[0].row[row]);
    for (int d = 0; d < g->n_disp; d++, row++)
        LW_EIGHT {
            double m = (f->row[row][j] - f->past[0].row[row])/f->size;
            moved[j] += m*m;
        }
}

/* Group g in the eight lanes; from the seed when there is no past. */
static void solve_group(follower *f, eight *w, const lw_higher *g, const lanes8 t)
{
    int number = (int)(g - f->plan->higher);
    lanes8 weight[PAST], last, moved;
    load_vectors(&f->k, w, g, 0, 0);
    load_known(&f->k, w, 0, 0);
    w->size = f->size;
    int n = weights(f, t, weight);
    predict(f, w, n, weight);
    const double *from = f->inverse + inverse_at(f, g);
    for (int r = 0; f->allowed[number] > 0 && r < w->n; r++)
        for (int c = 0; c < w->n; c++)
            LW_EIGHT w->inv[r][c][j] = from[r*w->n + c];
    bool on_way = f->allowed[number] > 0;
    arrive(w, last, on_way, on_way ? SURE*f->allowed[number] : INFINITY, f->fine, on_way ? 8 : 40);
    factor(w);
    put_group(&f->k, w, 0);
    keep_rows(f, w);
    movement(f, g, moved);
    double *to = f->trial_inverse + inverse_at(f, g)*LW_GROUP;
    for (int r = 0; r < w->n; r++)
        for (int c = 0; c < w->n; c++, to += LW_GROUP)
            memcpy(to, w->inv[r][c], sizeof(lanes8));
    for (int j = 0; j < LW_GROUP; j++) {
        double here = w->margin[j]/w->n;
        f->margin[number][j] = w->margin[j];
        f->sure[j] = f->sure[j] && last[j] <= fmax(f->fine, 1e-20) && here > 0;
        if (f->allowed[number] > 0)
            f->sure[j] = f->sure[j] && moved[j] <= SURE*f->allowed[number] && moved[j] <= SURE*here;
    }
}

static void trial(follower *f, const lanes8 t)
{
    eight w;
    const lw_plan *p = f->plan;
    set_input(f, t);
    for (int j = 0; j < LW_GROUP; j++)
        f->sure[j] = true;
    for (int i = 0, left = p->n_higher; left > 0 && i < p->n_step; i++) {
        const lw_step *s = &p->step[i];
        if (s->kind != LW_STEP_HIGHER) {
            forward_shared_pose(&f->k, s, LW_GROUP);
            continue;
        }
        solve_group(f, &w, &p->higher[s->dim[0]], t);
        left--;
    }
}

/* Lane j of the last trial becomes the present. */
static void accept(follower *f, double t, int j)
{
    bool same = f->n_past > 0 && f->past[0].t == t;
    if (!same && f->n_past < PAST)
        f->n_past++;
    for (int a = f->n_past - 1; !same && a > 0; a--)
        f->past[a] = f->past[a - 1];
    f->past[0].t = t;
    for (int r = 0; r < f->plan->n_row; r++)
        f->past[0].row[r] = f->row[r][j];
    size_t n = lw_inverse_rows(f->plan);
    for (size_t i = 0; i < n; i++)
        f->inverse[i] = f->trial_inverse[i*LW_GROUP + (size_t)j];
    for (int g = 0; g < f->plan->n_higher; g++)
        f->allowed[g] = f->margin[g][j]/(2*f->plan->higher[g].n_loop);
}

/* ---- the way -------------------------------------------------------------------------------------------- */

/* work: lw_follow_size doubles. */
static void follow_from_seed(follower *f, const lw_plan *plan, const double *dim, const double *mode, double fine,
                             double *work)
{
    lanes8 t;
    double input = mode[plan->n_mode - 1];
    size_t n = lw_inverse_rows(plan);
    f->plan = plan;
    f->fine = fine;
    f->dim = dim;
    f->mode = mode;
    f->size = lw_plan_size(plan, dim);
    f->trial_inverse = work;
    f->k = start(plan, LW_GROUP, work + n*LW_GROUP);
    f->k.c = f->c;
    f->k.s = f->s;
    f->k.dim = dim;
    f->k.mode = mode;
    f->k.dim_row = f->k.mode_row = 1;
    ground_rows(&f->k, LW_GROUP);
    set_turns(&f->k, plan->n_angle, 0, 1);
    f->n_past = 1;
    f->past[0].t = input;
    for (int g = 0; g < plan->n_higher; g++) {
        const lw_higher *h = &plan->higher[g];
        const double *from = mode + h->first_mode;
        double *row = f->past[0].row + h->first_row;
        f->allowed[g] = 0;
        for (int a = 0; a < h->n_turn; a++, from++) {
            *row++ = cos(*from);
            *row++ = sin(*from);
        }
        for (int d = 0; d < h->n_disp; d++)
            *row++ = *from++*f->size;
    }
    LW_EIGHT t[j] = input;
    trial(f, t);
    f->lost = !f->sure[0];
    f->n_past = f->lost;
    if (!f->lost)
        accept(f, input, 0);
}

/* To the input t; false when it ends before, at a limit. */
static bool advance(follower *f, double to)
{
    double unit = f->plan->input_is_slider ? f->size : 1, cap = STRIDE_MAX*unit;
    for (int i = 0; i < 4000 && f->past[0].t != to; i++) {
        double left = to - f->past[0].t, first = fabs(left) < cap ? left : copysign(cap, left);
        lanes8 t;
        int j = 0;
        for (int h = 0; h < LW_GROUP; h++)
            t[h] = f->past[0].t + ldexp(first, -h);
        if (first == left)
            t[0] = to;
        trial(f, t);
        while (j < LW_GROUP && !f->sure[j])
            j++;
        if (j < LW_GROUP && t[j] != f->past[0].t) {
            accept(f, t[j], j);
            cap = fmin(STRIDE_MAX*unit, 8*fabs(ldexp(first, -j)));
            continue;
        }
        cap = fabs(ldexp(first, -LW_GROUP));
        if (cap < 1e-12*unit)
            return false;
    }
    return f->past[0].t == to;
}

/* ---- a chunk of lanes ------------------------------------------------------------------------------------ */

typedef struct chunk {
    size_t  n, row;                        /* lanes, doubles from row to row of the seats             */
    double *seat;
    double  t[LW_CHUNK + LW_GROUP];        /* input, in the order gone                                */
    unsigned short lane[LW_CHUNK + LW_GROUP];
    bool    ordered, falls;                /* the lanes were in order, from the greatest down         */
} chunk;

/* Lane j of the last trial, as a lane that is reached. */
static void put_trial(const follower *f, const chunk *q, size_t at, int j)
{
    for (int r = 0; r < f->plan->n_row; r++)
        q->seat[(size_t)r*q->row + at] = f->row[r][j];
    q->seat[(size_t)f->plan->n_row*q->row + at] = 0;
}

static void put_seat(const follower *f, const chunk *q, size_t at, double out_of_reach)
{
    for (int r = 0; r < f->plan->n_row; r++)
        q->seat[(size_t)r*q->row + at] = f->past[0].row[r];
    q->seat[(size_t)f->plan->n_row*q->row + at] = out_of_reach;
}

/* Inputs of the lanes as one run of numbers: each lane of a pin at most half a turn from the one before. */
static void unroll(const follower *f, const lw_lanes *in, chunk *q)
{
    int up = 0, down = 0;
    for (size_t i = 0; i < q->n; i++) {
        q->lane[i] = (unsigned short)i;
        q->t[i] = f->plan->input_is_slider ? in->c[i] : atan2(in->s[i], in->c[i]);
        if (i == 0)
            continue;
        double step = q->t[i] - q->t[i - 1];
        if (!f->plan->input_is_slider && fabs(step) > LW_PI)
            q->t[i] = q->t[i - 1] + (step = remainder(step, 2*LW_PI));
        up += step > 0;
        down += step < 0;
    }
    q->ordered = !up || !down;
    q->falls = down > up;
}

/* Lanes in no order: by their input within a turn of the present. */
static void sort_lanes(const follower *f, chunk *q)
{
    double now = f->past[0].t;
    for (size_t i = 0; i < q->n; i++) {
        if (!f->plan->input_is_slider)
            q->t[i] = now + remainder(q->t[i] - now, 2*LW_PI);
        double t = q->t[i];
        unsigned short from = q->lane[i];
        size_t k = i;
        for (; k > 0 && q->t[k - 1] > t; k--) {
            q->t[k] = q->t[k - 1];
            q->lane[k] = q->lane[k - 1];
        }
        q->t[k] = t;
        q->lane[k] = from;
    }
}

static void turn_round(chunk *q)
{
    for (size_t i = 0; i < q->n/2; i++) {
        double t = q->t[i];
        unsigned short from = q->lane[i];
        q->t[i] = q->t[q->n - 1 - i];
        q->lane[i] = q->lane[q->n - 1 - i];
        q->t[q->n - 1 - i] = t;
        q->lane[q->n - 1 - i] = from;
    }
}

/* Up to eight lanes from i on in one trial; how many of them were sure. */
static size_t leap(follower *f, chunk *q, size_t i, size_t step)
{
    lanes8 t;
    size_t n = 0, last = i, sure = 0;
    for (; n < LW_GROUP; n++) {
        t[n] = q->t[last];
        last = last + step < q->n ? last + step : last;
    }
    trial(f, t);
    for (size_t at = i; sure < n && at < q->n && f->sure[sure]; at += step)
        put_trial(f, q, q->lane[at], (int)sure++);
    if (sure > 0)
        accept(f, t[sure - 1], (int)sure - 1);
    return sure;
}

/* The lanes from `first` on, in this direction (1 or -1), until the way ends. */
static void go_along(follower *f, chunk *q, size_t first, size_t step)
{
    double unit = f->plan->input_is_slider ? f->size : 1;
    bool open = false;
    for (size_t i = first; i < q->n; ) {
        size_t n = open ? 0 : leap(f, q, i, step);
        if (n == 0) {
            open = open || !advance(f, q->t[i]);
            put_seat(f, q, q->lane[i], open ? fmax(fabs(q->t[i] - f->past[0].t)/unit, 1e-12) : 0);
            n = 1;
        }
        i += n*step;
    }
}

/* All lanes of a chunk that share dimensions and seed; f goes on from where it stands and is left at the last lane
 * when the lanes are in order, else where it was. */
static void follow_chunk(follower *f, const lw_lanes *in, chunk *q)
{
    const follower here = *f;
    size_t first = 0;
    unroll(f, in, q);
    if (!q->ordered)
        sort_lanes(f, q);
    else if (q->falls)
        turn_round(q);
    if (q->ordered && !f->plan->input_is_slider) {
        double shift = 2*LW_PI*nearbyint((f->past[0].t - 0.5*(q->t[0] + q->t[q->n - 1]))/(2*LW_PI));
        for (size_t i = 0; i < q->n; i++)
            q->t[i] += shift;
    }
    while (first < q->n && q->t[first] < f->past[0].t)
        first++;
    if (q->falls || !q->ordered) {
        go_along(f, q, first, 1);
        *f = here;
        go_along(f, q, first - 1, (size_t)-1);
        if (q->ordered && first == 0)
            advance(f, q->t[0]);
    } else {
        go_along(f, q, first - 1, (size_t)-1);
        *f = here;
        go_along(f, q, first, 1);
        if (first == q->n)
            advance(f, q->t[q->n - 1]);
    }
    if (!q->ordered)
        *f = here;
}

/* Lanes with dimensions or seeds of their own, each for itself. */
static void follow_lane(follower *f, const lw_plan *plan, const lw_lanes *in, size_t at, double *work, chunk *q)
{
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    for (int d = 0; d < plan->n_dim; d++)
        dim[d] = in->dim_stride ? in->dim[(size_t)d*in->dim_stride + at] : in->dim[d];
    for (int m = 0; m < plan->n_mode; m++)
        mode[m] = in->mode_stride ? in->mode[(size_t)m*in->mode_stride + at] : in->mode[m];
    follow_from_seed(f, plan, dim, mode, COARSE, work);
    double to = plan->input_is_slider ? in->c[at] : atan2(in->s[at], in->c[at]), now = f->past[0].t, out = 1;
    if (!plan->input_is_slider)
        to = now + remainder(to - now, 2*LW_PI);
    if (!f->lost)
        out = advance(f, to) ? 0 : fmax(fabs(to - f->past[0].t)/(plan->input_is_slider ? f->size : 1), 1e-12);
    put_seat(f, q, at, out);
}

/* Seats of all lanes of a chunk (in), the last one repeated to a full group. */
static void seat_chunk(follower *f, const lw_plan *plan, const lw_lanes *in, double *work, chunk *q)
{
    q->n = in->n;
    if (in->dim_stride || in->mode_stride)
        for (size_t i = 0; i < in->n; i++)
            follow_lane(f, plan, in, i, work, q);
    else if (f->lost)
        for (size_t i = 0; i < in->n; i++)
            put_seat(f, q, i, 1);
    else
        follow_chunk(f, in, q);
    for (size_t i = in->n; i%LW_GROUP; i++)
        for (int r = 0; r <= plan->n_row; r++)
            q->seat[(size_t)r*q->row + i] = q->seat[(size_t)r*q->row + in->n - 1];
}

/* One posture for mbs/pose.c. */
static void kernel_seat(const lw_plan *plan, const double *dim, const double *mode, double input, void *work, lw_seat *seat)
{
    follower f;
    follow_from_seed(&f, plan, dim, mode, FINE, work);
    double to = input;
    if (!plan->input_is_slider)
        to = f.past[0].t + remainder(input - f.past[0].t, 2*LW_PI);
    bool there = !f.lost && advance(&f, to);
    memset(seat, 0, sizeof *seat);
    memcpy(seat->row, f.past[0].row, (size_t)plan->n_row*sizeof(double));
    seat->margin = 1;
    if (!there)
        seat->margin = f.lost ? -1 : -fmax(fabs(to - f.past[0].t)/(plan->input_is_slider ? f.size : 1), 1e-12);
    else
        memcpy(seat->inverse, f.inverse, lw_inverse_rows(plan)*sizeof(double));
    for (int g = 0; there && g < plan->n_higher; g++)
        seat->margin = fmin(seat->margin, f.allowed[g]*(2*plan->higher[g].n_loop));
}
#endif
