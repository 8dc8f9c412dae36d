/* mbs/kinematics/motion.c - the ranges of a linkage's input.  One dyad after the other, in each of its modes, cuts the
 * input's range into the pieces where it closes.  The pieces where all dyads close are the arcs. */
#include "mbs/kinematics/motion_internal.h"
#include <stdlib.h>
#include <string.h>

typedef struct walk {
    const lw_plan *plan;
    const double  *dim;
    lw_motion     *motion;
    const lw_step *step[LW_DYAD_MAX];
    lw_motion_span span[LW_DYAD_MAX];
    double         reach;                       /* where a slider input is cut, to either side    */
    lw_motion_piece piece[LW_ARC_MAX];          /* of each arc                                    */
    lw_motion_piece part[LW_DYAD_MAX][LW_PIECE_MAX];      /* of the pieces that are cut now, by dyad */
    bool           full;                        /* there are more arcs than LW_ARC_MAX            */
} walk;

/* ---- pieces in closed form ---------------------------------------------------------------------- */

static lw_mark limit(const lw_motion_span *s, double v, int dyad)
{
    return (lw_mark){ s->centre + v, dyad };
}

/* The ranges of the input in one turn that a span allows.  Returns their number; 0 when there is no bound. */
static int span_ranges(const walk *w, int dyad, lw_mark range[2][2])
{
    const lw_motion_span *s = &w->span[dyad];
    bool pin = !w->plan->input_is_slider;
    if (s->kind == LW_SPAN_HALVES) {
        for (int i = 0; i < 2; i++)
            for (int e = 0; e < 2; e++)
                range[i][e] = limit(s, (i + e)*LW_PI, -1);
        return 2;
    }
    if (!s->has_in && !s->has_out)
        return 0;
    double out = s->has_out ? s->out : 4.0*w->reach;
    if (!s->has_in || (pin && !s->has_out)) {
        range[0][0] = limit(s, s->has_in ? s->in : -out, dyad);
        range[0][1] = limit(s, s->has_in ? 2.0*LW_PI - s->in : out, dyad);
        return 1;
    }
    for (int i = 0; i < 2; i++) {
        range[i][0] = limit(s, i ? s->in : -out, dyad);
        range[i][1] = limit(s, i ? out : -s->in, dyad);
    }
    return 2;
}

/* The same angle in (-pi, pi]. */
static double wrapped(double at)
{
    double a = remainder(at, 2.0*LW_PI);
    return a <= -LW_PI ? LW_PI : a;
}

/* Add a touch to the piece if it lies in it, apart from whole turns. */
static void keep_touch(const walk *w, lw_motion_piece *p, double at, int dyad)
{
    int turns = w->plan->input_is_slider ? 0 : 2;
    for (int k = -turns; k <= turns && p->n_touch < LW_MARK_MAX; k++) {
        double x = (turns ? wrapped(at) : at) + 2.0*LW_PI*k;
        if (p->turns || (x >= p->end[0].at && x <= p->end[1].at)) {
            p->touch[p->n_touch++] = (lw_mark){ x, dyad };
            return;
        }
    }
}

/* Remove the touches that do not lie in the piece. */
static void sift_touches(const walk *w, lw_motion_piece *p)
{
    lw_motion_piece old = *p;
    p->n_touch = 0;
    for (int i = 0; i < old.n_touch; i++)
        keep_touch(w, p, old.touch[i].at, old.touch[i].dyad);
}

/* The part of `whole` in `range` moved by `shift`; false when it is empty. */
static bool overlap(const lw_motion_piece *whole, const lw_mark range[2], double shift, lw_motion_piece *p)
{
    lw_mark lo = { range[0].at + shift, range[0].dyad }, hi = { range[1].at + shift, range[1].dyad };
    *p = *whole;
    p->turns = false;
    if (whole->turns || lo.at >= whole->end[0].at)
        p->end[0] = lo;
    if (whole->turns || hi.at <= whole->end[1].at)
        p->end[1] = hi;
    return p->end[1].at - p->end[0].at > 1e-12*(fabs(p->end[0].at) + fabs(p->end[1].at));
}

static int cut_by_span(const walk *w, int dyad, const lw_motion_piece *whole, lw_motion_piece *part)
{
    const lw_motion_span *s = &w->span[dyad];
    lw_mark range[2][2];
    int n = 0, n_range = s->kind == LW_SPAN_ALL ? 0 : span_ranges(w, dyad, range);
    if (n_range == 0)
        part[n++] = *whole;
    for (int i = 0; i < n_range; i++) {
        double base = w->plan->input_is_slider ? 0.0 : wrapped(range[i][0].at) - range[i][0].at;
        int turns = whole->turns || w->plan->input_is_slider ? 0 : 2;
        for (int k = -turns; k <= turns && n < LW_PIECE_MAX; k++)
            n += overlap(whole, range[i], base + 2.0*LW_PI*k, &part[n]);
    }
    for (int i = 0; i < n; i++) {
        if (s->touch_in)
            keep_touch(w, &part[i], s->centre, dyad);
        if (s->touch_out)
            keep_touch(w, &part[i], s->centre + LW_PI, dyad);
    }
    return n;
}

/* ---- arcs --------------------------------------------------------------------------------------- */

static void add_arc(walk *w, const lw_motion_piece *p)
{
    lw_motion *m = w->motion;
    if (m->n_arc == LW_ARC_MAX) {
        w->full = true;
        return;
    }
    lw_arc *a = &m->arc[m->n_arc];
    w->piece[m->n_arc++] = *p;
    a->first = p->end[0].at;
    a->last = p->end[1].at;
    a->turns = p->turns;
    memcpy(a->mode, p->mode, sizeof a->mode);
    for (int e = 0; e < 2; e++) {
        a->flips[e] = p->turns ? -1 : p->end[e].dyad;
        a->limit[e] = a->flips[e] >= 0;
    }
    a->transmission_min = a->transmission_max = 0.5*LW_PI;
    for (int k = 0; k < w->plan->n_dyad; k++) {
        double angle[2];
        lw_piece_transmission(w->plan, w->dim, k, w->step[k], p, angle);
        a->transmission_min = k > 0 ? fmin(a->transmission_min, angle[0]) : angle[0];
        a->transmission_max = k > 0 ? fmax(a->transmission_max, angle[1]) : angle[1];
    }
}

static void explore(walk *w, int dyad, const lw_motion_piece *whole)
{
    if (dyad == w->plan->n_dyad) {
        add_arc(w, whole);
        return;
    }
    lw_motion_piece *part = w->part[dyad];
    int n = 0;
    if (w->span[dyad].kind == LW_SPAN_UNKNOWN)
        n = lw_piece_search(w->plan, w->dim, dyad, w->step[dyad], whole, part);
    else if (w->span[dyad].kind != LW_SPAN_NEVER)
        n = cut_by_span(w, dyad, whole, part);
    int n_mode = lw_step_has_modes(w->step[dyad]) ? 2 : 1;
    for (int i = 0; i < n && !w->full; i++) {
        sift_touches(w, &part[i]);
        for (int mode = 0; mode < n_mode; mode++) {
            part[i].mode[dyad] = mode ? -1.0 : 1.0;
            explore(w, dyad + 1, &part[i]);
        }
    }
}

/* ---- circuits ----------------------------------------------------------------------------------- */

static bool same_input(const walk *w, double a, double b)
{
    double gap = w->plan->input_is_slider ? (a - b)/w->reach : remainder(a - b, 2.0*LW_PI);
    return fabs(gap) < 1e-9;
}

/* The only dyad whose mode differs between two arcs; -1 when there is not exactly one. */
static int flipped(const walk *w, int p, int q)
{
    int dyad = -1, n = 0;
    for (int i = 0; i < w->plan->n_dyad; i++)
        if (w->piece[p].mode[i] != w->piece[q].mode[i]) {
            dyad = i;
            n++;
        }
    return n == 1 ? dyad : -1;
}

static bool share_limit(const walk *w, int p, int q, int dyad)
{
    const lw_motion_piece *a = &w->piece[p], *b = &w->piece[q];
    for (int e = 0; e < 2; e++)
        if (!a->turns && !b->turns && a->end[e].dyad == dyad && b->end[e].dyad == dyad && same_input(w, a->end[e].at, b->end[e].at))
            return true;
    return false;
}

static bool share_touch(const walk *w, int p, int q, int dyad)
{
    const lw_motion_piece *a = &w->piece[p], *b = &w->piece[q];
    for (int i = 0; i < a->n_touch; i++)
        for (int j = 0; j < b->n_touch; j++)
            if (a->touch[i].dyad == dyad && b->touch[j].dyad == dyad && same_input(w, a->touch[i].at, b->touch[j].at))
                return true;
    return false;
}

/* Join two circuits.  Until all are joined, the number of a circuit is that of its first arc. */
static void join(lw_motion *m, int p, int q)
{
    int a = m->arc[p].circuit, b = m->arc[q].circuit, keep = a < b ? a : b;
    for (int i = 0; i < m->n_arc; i++)
        if (m->arc[i].circuit == a || m->arc[i].circuit == b)
            m->arc[i].circuit = keep;
}

/* Join the circuits of two arcs when they differ in one dyad only and share a limit or touch of this dyad. */
static void join_circuits(walk *w)
{
    lw_motion *m = w->motion;
    for (int p = 0; p < m->n_arc; p++)
        m->arc[p].circuit = p;
    for (int p = 0; p < m->n_arc; p++)
        for (int q = 0; q < p; q++) {
            int dyad = flipped(w, p, q);
            if (dyad < 0)
                continue;
            bool touch = share_touch(w, p, q, dyad);
            m->change_point |= touch;
            if (touch || share_limit(w, p, q, dyad))
                join(m, p, q);
        }
    int number[LW_ARC_MAX];
    m->n_circuit = 0;
    for (int p = 0; p < m->n_arc; p++) {
        int first = m->arc[p].circuit;
        if (first == p)
            number[p] = m->n_circuit++;
        m->arc[p].circuit = number[first];
    }
}

/* ---- the whole ---------------------------------------------------------------------------------- */

static void set_walk(walk *w, const lw_plan *plan, const double *dim, lw_motion *m)
{
    w->plan = plan;
    w->dim = dim;
    w->motion = m;
    w->full = false;
    w->reach = 0.0;
    for (int d = 0; d < plan->n_dim; d++)
        if (plan->dim[d].kind != LW_DIM_ANGLE && d != plan->i_x0 && d != plan->i_y0)
            w->reach += 10.0*fabs(dim[d]);
    for (int i = 0; i < plan->n_step; i++) {
        const lw_step *s = &plan->step[i];
        if (s->dyad >= 0) {
            w->step[s->dyad] = s;
            w->span[s->dyad] = lw_dyad_span(plan, dim, s);
        }
    }
}

lw_status lw_motion_find(const lw_plan *plan, const double *dim, lw_motion *m)
{
    lw_motion_piece all = { .turns = !plan->input_is_slider };
    memset(m, 0, sizeof *m);
    for (int d = 0; d < plan->n_dim; d++)
        if (!isfinite(dim[d]))
            return LW_E_ARG;
    if (plan->n_higher)
        return LW_E_KIND;
    walk *w = malloc(sizeof *w);
    if (!w)
        return LW_E_MEMORY;
    set_walk(w, plan, dim, m);
    for (int i = 0; i < LW_MODE_MAX; i++)
        all.mode[i] = 1.0;
    all.end[0] = (lw_mark){ plan->input_is_slider ? -w->reach : 0.0, -1 };
    all.end[1] = (lw_mark){ plan->input_is_slider ? w->reach : 2.0*LW_PI, -1 };
    explore(w, 0, &all);
    join_circuits(w);
    bool full = w->full;
    free(w);
    return full ? LW_STOPPED : m->n_arc == 0 ? LW_OPEN : LW_OK;
}

/* The distance of the input from an arc, apart from whole turns; 0 inside. */
static double distance_to(const lw_plan *plan, const lw_arc *a, double input)
{
    if (a->turns)
        return 0.0;
    double middle = 0.5*(a->first + a->last), half = 0.5*(a->last - a->first);
    double away = plan->input_is_slider ? input - middle : remainder(input - middle, 2.0*LW_PI);
    return fmax(0.0, fabs(away) - half);
}

/* Are the modes equal for all dyads that have modes? */
static bool same_modes(const lw_plan *plan, const double *a, const double *b)
{
    for (int i = 0; i < plan->n_step; i++) {
        const lw_step *s = &plan->step[i];
        if (s->dyad >= 0 && lw_step_has_modes(s) && (a[s->dyad] < 0.0) != (b[s->dyad] < 0.0))
            return false;
    }
    return true;
}

int lw_motion_arc(const lw_plan *plan, const lw_motion *m, const double *mode, double input)
{
    int best = -1;
    double least = INFINITY;
    for (int i = 0; i < m->n_arc; i++) {
        double d = distance_to(plan, &m->arc[i], input);
        if (d < least && same_modes(plan, m->arc[i].mode, mode)) {
            least = d;
            best = i;
        }
    }
    return best;
}

double lw_motion_nearly_flat(const lw_motion *m, int circuit, bool pin)
{
    static const double near = 0.06, reached = 1e-7;     /* dimensions off by up to 1e-3 of the size; at a limit it is 0 */
    double least = near;
    for (int i = 0; i < m->n_arc; i++) {
        const lw_arc *a = &m->arc[i];
        double left[2] = { a->transmission_min, LW_PI - a->transmission_max };
        for (int e = 0; a->circuit == circuit && e < 2; e++)
            least = left[e] > reached ? fmin(least, left[e]) : least;
        for (int j = 0; j < m->n_arc && pin && a->circuit == circuit; j++)       /* limits on both sides of one */
            for (int e = 0; e < 2 && m->arc[j].circuit != circuit; e++)
                if (a->limit[e] && m->arc[j].limit[1 - e])
                    least = fmin(least, 0.5*fabs(remainder(e ? m->arc[j].first - a->last : m->arc[j].last - a->first, 2*LW_PI)));
    }
    return least < near ? least : 0;
}
