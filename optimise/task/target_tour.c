/* Points of a path in no order: put them in the order of a short tour through all of them. */
#include <stdlib.h>
#include <string.h>

#include "optimise/task/target_internal.h"
#include "optimise/task/target_tour.h"

#define JUMBLED 2                  /* the polygon of points in no order is longer than so many tours: that of a curve is not */
#define MANY    10000              /* points: of more the order is not looked at                     */
enum { NEAR = 8 };                 /* stations next to each one that are tried to come next to it    */

/* A closed tour of n nodes.  The node t->n, if there is one, has the distance 0 from all others: without it the tour is open. */
typedef struct tour {
    const lw_target *t;
    size_t           n;
    size_t          *node, *place;                /* in the order of the tour; where each stands               (n) */
    size_t         (*near)[NEAR];                 /* the nearest stations of each, the nearest first        (t->n) */
    size_t           n_near;
} tour;

/* Distance of two stations, over all points. */
static double step(const lw_target *t, size_t i, size_t k)
{
    double d = hypot(t->x[k] - t->x[i], t->y[k] - t->y[i]);
    for (int p = 0; p < t->n_also; p++)
        if (t->also[p].x)
            d = hypot(d, hypot(t->also[p].x[k] - t->also[p].x[i], t->also[p].y[k] - t->also[p].y[i]));
    return d;
}

static double between(const tour *o, size_t i, size_t k) { return i == o->t->n || k == o->t->n ? 0 : step(o->t, i, k); }
static size_t at(const tour *o, size_t place) { return o->node[place % o->n]; }

static void find_near(tour *o)
{
    o->n_near = o->t->n - 1 < NEAR ? o->t->n - 1 : NEAR;
    for (size_t i = 0; i < o->t->n; i++) {
        double far[NEAR];
        size_t n = 0;
        for (size_t k = 0; k < o->t->n; k++) {
            double d = step(o->t, i, k);
            if (k == i || (n == o->n_near && d >= far[n - 1]))
                continue;
            size_t to = n < o->n_near ? n++ : n - 1;
            for (; to > 0 && far[to - 1] > d; to--) {
                far[to] = far[to - 1];
                o->near[i][to] = o->near[i][to - 1];
            }
            far[to] = d;
            o->near[i][to] = k;
        }
    }
}

/* From each node to the nearest one left. */
static void begin(tour *o)
{
    for (size_t i = 0; i < o->n; i++)
        o->node[i] = o->n - 1 - i;
    for (size_t i = 0; i + 2 < o->n; i++) {
        size_t best = i + 1;
        double least = INFINITY;
        for (size_t k = i + 1; k < o->n; k++) {
            double d = between(o, o->node[i], o->node[k]);
            best = d < least ? k : best;
            least = fmin(d, least);
        }
        size_t next = o->node[best];
        o->node[best] = o->node[i + 1];
        o->node[i + 1] = next;
    }
    for (size_t i = 0; i < o->n; i++)
        o->place[o->node[i]] = i;
}

/* Turn the nodes at the places first .. last round. */
static void reverse(tour *o, size_t first, size_t last)
{
    for (; first < last; first++, last--) {
        size_t a = o->node[first], b = o->node[last];
        o->place[o->node[first] = b] = first;
        o->place[o->node[last] = a] = last;
    }
}

/* Replace the steps behind two places by two shorter ones, if they are (2-opt, Croes 1958). */
static bool uncross_at(tour *o, size_t i, size_t k)
{
    if (i > k) {
        size_t other = i;
        i = k;
        k = other;
    }
    size_t a = o->node[i], b = at(o, i + 1), c = o->node[k], d = at(o, k + 1);
    if (!(between(o, a, c) + between(o, b, d) < (between(o, a, b) + between(o, c, d))*(1 - 1e-12)))
        return false;
    reverse(o, i + 1, k);
    return true;
}

static bool uncross(tour *o)
{
    bool better = false;
    for (size_t a = 0; a < o->t->n; a++)
        for (size_t j = 0; j < o->n_near; j++) {
            const size_t c = o->near[a][j];
            better |= uncross_at(o, o->place[a], o->place[c]);
            better |= uncross_at(o, (o->place[a] + o->n - 1) % o->n, (o->place[c] + o->n - 1) % o->n);
        }
    return better;
}

/* Move the run of nodes at the places first .. last behind the node at place k, turned round or not. */
static void move_run(tour *o, size_t first, size_t last, size_t k, bool turned)
{
    const size_t length = last - first + 1;
    const bool later = k > last;
    size_t low = later ? first : k + 1, high = later ? k : last, run = later ? high + 1 - length : low;
    reverse(o, low, high);
    reverse(o, later ? low : run + length, later ? run - 1 : high);
    if (!turned)
        reverse(o, run, run + length - 1);
}

/* Move the run at these places behind place k if that makes the tour shorter (Or 1976). */
static bool move_behind(tour *o, size_t i, size_t last, size_t k)
{
    if (k + 1 >= i && k <= last)
        return false;
    size_t before = o->node[i - 1], first = o->node[i], end = o->node[last], after = at(o, last + 1), p = o->node[k], q = at(o, k + 1);
    double now = between(o, before, first) + between(o, end, after) + between(o, p, q), gone = between(o, before, after);
    double ahead = gone + between(o, p, first) + between(o, end, q), turned = gone + between(o, p, end) + between(o, first, q);
    if (!(fmin(ahead, turned) < now*(1 - 1e-12)))
        return false;
    move_run(o, i, last, k, turned < ahead);
    return true;
}

/* Move runs of one to three nodes next to a station that is near one of their ends. */
static bool move_runs(tour *o)
{
    bool better = false;
    for (size_t length = 1; length <= 3; length++)
        for (size_t i = 1; i + length < o->n; i++)
            for (size_t j = 0; j < 4*o->n_near; j++) {
                size_t last = i + length - 1, end = o->node[j % 2 ? i : last];
                if (end == o->t->n)
                    continue;
                size_t k = o->place[o->near[end][j/4]];
                better |= move_behind(o, i, last, j/2 % 2 ? k : (k + o->n - 1) % o->n);
            }
    return better;
}

static double length_of(const tour *o)
{
    double sum = 0;
    for (size_t i = 0; i < o->n; i++)
        sum += between(o, o->node[i], at(o, i + 1));
    return sum;
}

/* Memory for the work on n stations: that of a tour, the order it gives, and n numbers. */
typedef struct desk { size_t (*near)[NEAR], *node, *place, *order; double *number; } desk;

static lw_status make_desk(size_t n, desk *d, lw_error *e)
{
    d->near = malloc(n*sizeof *d->near + (3*n + 2)*sizeof *d->node + n*sizeof *d->number);
    if (!d->near)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for the order of %zu points", n);
    d->node = (size_t *)(d->near + n);
    d->place = d->node + n + 1;
    d->order = d->place + n + 1;
    d->number = (double *)(d->order + n);
    return LW_OK;
}

/* The stations in the order of a short tour: a closed one begins at the first station, an open one at the end with the smaller number.
 * Returns its length. */
static double find(const lw_target *t, bool closed, const desk *d)
{
    tour o = { .t = t, .n = t->n + !closed, .node = d->node, .place = d->place, .near = d->near };
    find_near(&o);
    begin(&o);
    for (bool better = true; better; ) {
        better = uncross(&o);
        better |= move_runs(&o);
    }
    size_t first = o.place[closed ? 0 : t->n];
    bool back = at(&o, first + 1) > at(&o, first + o.n - 1);
    for (size_t i = 0; i < t->n; i++)
        d->order[i] = at(&o, first + (back ? o.n - i - !closed : i + !closed));
    return length_of(&o);
}

/* The stations of points in no order are further apart than half of their mean distance from the centre; a tour need not be found to say
 * that those of a curve are not. */
static bool may_be_jumbled(const lw_target *t)
{
    double x = 0, y = 0, away = 0, along = 0, n = (double)t->n;
    for (size_t i = 0; i < t->n; i++) {
        x += t->x[i]/n;
        y += t->y[i]/n;
    }
    for (size_t i = 0; i < t->n; i++) {
        away += hypot(t->x[i] - x, t->y[i] - y);
        along += hypot(t->x[i] - t->x[i > 0 ? i - 1 : 0], t->y[i] - t->y[i > 0 ? i - 1 : 0]);
    }
    return along > away/2;
}

/* The length of the polygon through the stations. */
static double length_now(const lw_target *t)
{
    double sum = t->closed ? step(t, t->n - 1, 0) : 0;
    for (size_t i = 1; i < t->n; i++)
        sum += step(t, i - 1, i);
    return sum;
}

/* Put the stations in this order, and measure the target again. */
static lw_status put(lw_target *t, const size_t *order, int closed, double *number, lw_error *e)
{
    lw_target_place place;
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++) {
        double *of = lw_target_array(t, (lw_target_field)role);
        if (!of || (role != LW_TARGET_FIELD_WEIGHT && of == t->weight))          /* a point may have the weights of the first */
            continue;
        for (size_t i = 0; i < t->n; i++)
            number[i] = of[order[i]];
        memcpy(of, number, t->n*sizeof *of);
    }
    long *line = (long *)number;
    for (size_t i = 0; i < t->n; i++)
        line[i] = t->line[order[i]];
    memcpy(t->line, line, t->n*sizeof *line);
    return lw_target_finish(t, closed, &place, e);
}

/* Is the path through the stations closed, which an open tour of this length goes through in the order d->order?  It is if to close it takes no more
 * than one and a half of its longest step, or a twentieth of its length. */
static bool closes(const lw_target *t, double open, const desk *d)
{
    double longest = 0;
    for (size_t i = 1; i < t->n; i++)
        longest = fmax(longest, step(t, d->order[i - 1], d->order[i]));
    return find(t, true, d) - open <= fmax(1.5*longest, open/20);
}

static bool has_order(const lw_target *t) { return !t->x || t->angle || t->n > MANY || !may_be_jumbled(t); }

lw_status lw_target_look_at_order(lw_target *t, int closed, lw_error *e)
{
    desk d;
    lw_target_place place;
    if (has_order(t))
        return LW_OK;
    lw_status s = make_desk(t->n, &d, e);
    double least = s == LW_OK ? find(t, closed > 0, &d) : INFINITY;
    if (length_now(t) > JUMBLED*least && closed < 0) {
        bool closed_now = closes(t, least, &d);
        s = lw_target_finish(t, closed_now, &place, e);
        least = find(t, closed_now, &d);
    }
    if (length_now(t) > JUMBLED*least)
        lw_target_add_note(t, "the points jump to and fro: the polygon through them is %.2g times as long as a short tour, whose order they get "
                           "with timing none", length_now(t)/least);
    free(d.near);
    return s;
}

lw_status lw_target_put_in_order(lw_target *t, lw_error *e)
{
    desk d;
    if (has_order(t))
        return LW_OK;
    lw_status s = make_desk(t->n, &d, e);
    if (s == LW_OK && length_now(t) > JUMBLED*find(t, t->closed, &d)) {
        s = put(t, d.order, t->closed, d.number, e);
        lw_target_add_note(t, "they are put in its order");
    }
    free(d.near);
    return s;
}
