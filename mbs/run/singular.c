/* mbs/run/singular.c - through singular postures.
 *
 * There the rows lose rank and two motion curves meet.  At the distance theta from it, velocities and accelerations
 * from the rows are off by rounding over theta^2 and theta^3.  A method with error control takes that for roughness:
 * the tighter its tolerance, the sooner its steps become very short.
 *
 * With one freedom, in the plane: the motion curve that the linkage is on is a smooth curve q(s).  It is interpolated from places on
 * both sides, far enough away to be known to the last digits, and between them the motion is that of one coordinate:
 *
 *     s' = p/sqrt(M),   p' = q'.Q/sqrt(M),   M = q'.M q'
 *
 * with p^2/2 the kinetic energy.  The curve is Newton's polynomial through twelve places, the images under square
 * root of Chebyshev's points on [gap^2, 1]: the best ones for an interval with a gap in its middle.  It has to
 * satisfy the rows within the gap; where motion curves come near each other but do not meet, it does not. */
#include "base/real.h"
#include "mbs/run/passage_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/ode/integrate.h"

/* ---- over it by one step --------------------------------------------------------------------------------- */

/* With more freedoms, or where no curve is found: one step whose nodes lie well on both sides of the singular posture,
 * from some distance before it to the same distance behind it.  The motion itself is smooth there.  The state at the
 * end must have the energy of the state before.
 *
 * Motions that turn back near the singular posture meet it twice within a short time, or just not.  Their step has the turn in
 * its middle, and no node between the two times. */
static const double unresolved = 1e-8;       /* difference of orders 20 and 18, and of energies, that is still allowed, scaled */
static const double resolved = 1e-13;        /* such a difference that a shorter gap need not improve */
static const double shortest_half = 0.01;    /* half the length of a gap, scaled: rounding grows in shorter ones */
static const double longest_turn = 0.4;      /* the same about a turn */
static const double turn_outside = 1.2;      /* a turn so far behind, over half the length, is outside of the gap */
static const double clear_of_crossing = 0.1, clear_of_turn = 0.015;    /* least distance of a node from a singular posture, over half the length */
static const double turn_before = 0.01;      /* a turn so far before a singular posture loses no digits */
static const double beside_jam = 0.5;        /* root of the least pivot above which friction does not jam */
static const double half_explicit = 0.03;    /* half the length of an explicit step, where there is no polynomial */

/* Samples on the way: integrated from `first` at `good`; in the gap from its polynomial. */
typedef struct on_the_way { lw_run *run; double good; const double *first; const lw_passage *gap; } on_the_way;

static lw_status state_on_the_way(void *context, double t, double *y)
{
    const on_the_way *w = context;
    const lw_passage *z = w->gap;
    if (t <= z->start || !z->rule) {
        bool beyond = t > z->start;
        memcpy(y, beyond ? z->begun : w->first, (size_t)w->run->n*sizeof *y);
        return t > w->good ? lw_passage_integrate(w->run, beyond ? z->start : w->good, t, y, beyond) : LW_OK;
    }
    lw_passage_state(z, (t - z->start)/z->length, y);
    return LW_OK;
}

/* Is a stop perhaps struck on the way to `end`?  Gaps are looked at so densely that one which closes in between changes by more than
 * twice its size from one look to the next.  A gap that opens from 0 is no impact. */
static bool is_struck(on_the_way *w, double end, double *y)
{
    enum { LOOKS = 64 };
    const lw_dynamics *d = w->run->d;
    double gap[2][LW_EVENT_MAX] = { 0 };
    for (int k = 0; d->n_stop && k <= LOOKS; k++) {
        double t = w->good + (end - w->good)*k/LOOKS, *now = gap[k%2], *before = gap[!(k%2)];
        if (state_on_the_way(w, t, y) != LW_OK || lw_run_stop_events(w->run, t, y, now) != LW_OK)
            return true;
        for (int i = 0; k > 0 && i < d->n_stop; i++)
            if (!(now[i] > 0.5*fabs(now[i] - before[i])) || (k > 1 && !(before[i] > 0.5*fabs(now[i] - before[i]))))
                return true;
    }
    return false;
}

/* Move the posture q for so long at the velocities v and the accelerations a, NULL: 0.  way (n_v): work. */
static void go_straight(lw_dynamics *d, double time, double *q, const double *v, const double *a, double *way)
{
    for (int i = 0; i < d->n_v; i++)
        way[i] = time*(v[i] + (a ? 0.5*time*a[i] : 0));
    d->eq.move(d->eq.context, q, way);
}

/* The greatest velocity of the state y. */
static double fastest(const lw_dynamics *d, const double *y)
{
    double most = 0;
    for (int i = 0; i < d->n_v; i++)
        most = fmax(most, fabs(y[d->n_q + i]));
    return most;
}

/* How the root w of the least pivot goes on from the time t: w - rate s + bend s^2/2 after the time s. */
typedef struct approach { double t, w, rate, bend; } approach;

/* Find rate and bend of w at (t, y) by differences over a short time.  Its values at the ends of steps are not enough: between them
 * it may have been 0, or greater. */
static lw_status find_approach(lw_run *run, double t, const double *y, double w, approach *a)
{
    lw_dynamics *d = run->d;
    size_t n = (size_t)run->n, n_q = (size_t)d->n_q;
    double *rate = malloc(2*n*sizeof *rate), *q = rate ? rate + n : NULL, root[2] = { 0 };
    double little = 0.1*w/fastest(d, y);
    lw_status s = rate ? lw_run_rate(run, t, y, rate) : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < 2 && s == LW_OK; i++) {
        double time = i ? little : -little;
        memcpy(q, y, n_q*sizeof *q);
        go_straight(d, time, q, y + n_q, rate + n_q, rate);
        d->by_rank = false;                  /* else the pivot is not found */
        s = lw_mbs_rows(d, t + time, q);
        if (s == LW_OK)
            s = lw_mbs_factor(d, false);
        root[i] = sqrt(fmax(d->weak, 0));
    }
    free(rate);
    *a = (approach){ t, w, (root[0] - root[1])/(2*little), (root[0] + root[1] - 2*w)/(little*little) };
    return s;
}

/* The motion turns back near the singular posture at the time t.  beyond: distance of the turn behind the posture; negative: before
 * it; infinite: there is no turn.  bend as above. */
typedef struct turn { double t, beyond, bend; } turn;

static turn foretold_turn(const approach *a)
{
    bool turns = a->bend > 0 && a->rate > 0;
    return (turn){ a->t + a->rate/a->bend, turns ? a->rate*a->rate/(2*a->bend) - a->w : INFINITY, a->bend };
}

/* Time from a->t to the singular posture, or to where the motion turns back before it. */
static double time_to_it(const approach *a)
{
    return 2*a->w/(a->rate + sqrt(fmax(a->rate*a->rate - 2*a->bend*a->w, 0)));
}

/* Is the state before the gap about half its length from the singular posture?  Else the way there has led over another
 * one, or the motion turns back. */
static bool is_apart(const lw_passage *z, double half)
{
    lw_dynamics *d = z->run->d;
    d->by_rank = false;                      /* else the pivot is not found */
    return lw_mbs_rows(d, z->start, z->begun) == LW_OK && lw_mbs_factor(d, false) == LW_OK
        && d->weak > 0.1*half*half && d->weak < 10*half*half;
}

/* Begin at half the length from the singular posture, before or behind `good`, where the state is `first`.  back: where the motion
 * turns back near the posture, found better here, is put into the middle; NULL: the posture.  LW_OPEN: there is no such place. */
static lw_status begin_gap(lw_passage *z, double half, turn *back, const approach *a, double good, const double *first)
{
    double middle = back ? back->t : a->t + time_to_it(a), before;
    before = back ? sqrt(2*(half + back->beyond)/back->bend) : (middle - a->t)*half/a->w;
    z->start = middle - before > z->run->d->o.from ? middle - before : good;
    z->length = 2*(middle - z->start);
    memcpy(z->begun, first, (size_t)z->run->n*sizeof *first);
    lw_status s = z->start == good ? LW_OK : lw_passage_integrate(z->run, good, z->start, z->begun, false);
    if (s == LW_E_NUMERIC || (s == LW_OK && z->start != good && !is_apart(z, half)))
        return LW_OPEN;
    for (int pass = back ? 2 : 1; s == LW_OK && (s = lw_passage_guess(z)) == LW_OK && pass > 0; pass--)
        if (!(back ? lw_passage_centre_turn(z, &back->t, &back->beyond, &back->bend) : lw_passage_centre(z)))
            s = LW_OPEN;
    return s == LW_E_NUMERIC ? LW_OPEN : s;
}

enum { PLACES = 400, COARSE = 8 };           /* on the way over a singular posture; every eighth is looked at first */

/* Does friction jam at this place of the way from the state `from` to y?  left: how far it is from that, by the rows and by the
 * friction.  scratch (n). */
static bool jams_at(lw_run *run, double t, const double *from, const double *y, int place, double left[2], double *scratch)
{
    lw_dynamics *d = run->d;
    lw_status s = LW_OK;
    for (int i = 0; i < run->n; i++)
        scratch[i] = from[i] + (y[i] - from[i])*place/PLACES;
    left[0] = left[1] = 0;
    if (lw_mbs_rows(d, t, scratch) == LW_OK && lw_mbs_factor(d, true) == LW_OK) {
        s = lw_mbs_solve(d, t, scratch, scratch + d->n_q, d->a, d->l, NULL);
        left[0] = d->rank_of.weakest, left[1] = d->friction_determinant;
    }
    return s == LW_E_NUMERIC;
}

/* Reactions have poles in singular postures.  Where their friction grows with them, its equations lose their solution on
 * the way, and the linkage jams.  Returns which share of the way from the state `from` to y behind the singular posture that
 * is; 0: they do not.  All places are looked at beside those that are nearest to a singular posture or to jamming.  At a
 * distance of x places from a pole the determinant of friction is 1 - c/x; c < 1/2 is too narrow to be seen. */
static double jams(lw_run *run, double t, const double *from, const double *y, double *scratch)
{
    static const double clear = 1 - 0.5/(COARSE/2);
    lw_error was = *run->e;
    double left[3][2] = { { INFINITY, INFINITY }, { INFINITY, INFINITY } };
    int found = 0;
    for (int k = 0; k <= PLACES + COARSE && !found && run->d->n_friction && !run->d->touch; k += COARSE) {
        bool within = k > 0 && k < PLACES, jam = false;
        left[2][0] = left[2][1] = INFINITY;
        if (k <= PLACES)
            jam = jams_at(run, t, from, y, k, left[2], scratch) && within;
        bool dip = k > 0 && ((left[1][0] <= left[0][0] && left[1][0] <= left[2][0])
                             || (left[1][1] <= left[0][1] && left[1][1] <= left[2][1] && left[1][1] < clear));
        int first = dip ? k - 2*COARSE : k - COARSE, last = k < PLACES ? k : PLACES;
        for (int i = first > 0 ? first : 1; (dip || jam) && i < last && !found; i++)
            found = jams_at(run, t, from, y, i, (double[2]){ 0 }, scratch) ? i : 0;
        found = found == 0 && jam ? k : found;
        memmove(left, left + 1, 2*sizeof *left);
    }
    *run->e = was;
    return (double)found/PLACES;
}

/* With friction: has the last step, or the one before, to y gone over a singular posture in which the linkage jams? */
static lw_status jumped(lw_run *run, double fall, double t, const double *y)
{
    const lw_dynamics *d = run->d;
    size_t n = (size_t)run->n;
    bool first = !run->behind;
    if (!d->n_friction || d->touch)
        return LW_OK;
    if (first && !(run->behind = malloc((3*n + 2)*sizeof *y)))
        return LW_E_MEMORY;
    double *older = run->behind, *old = older + n, *when = old + 2*n, share;
    bool least = !first && fall < 0 && run->fell > 0 && run->pivot < beside_jam;
    run->fell = fall;
    if (least && (share = jams(run, t, older, y, old + n)) > 0) {
        run->jam = run->r->t = when[0] + share*(t - when[0]);
        return LW_E_NUMERIC;
    }
    when[0] = first ? t : when[1];
    when[1] = t;
    memcpy(older, first ? y : old, n*sizeof *y);
    memcpy(old, y, n*sizeof *y);
    return LW_OK;
}

/* Half the length of the gap tried in turn k; even ones are about a turn. */
static double half(int k) { return k%2 ? ldexp(LW_SINGULAR_STEP_HALF, -(k/2)) : longest_turn*pow(0.7, k/2); }

/* Find the longest gap whose polynomial is resolved, from y at `good`, and the state at its end, y.  LW_OPEN: there is none.
 * first (n): y; z: as begun. */
static lw_status find_gap(lw_passage *z, const approach *a, double good, const double *first, double *y)
{
    lw_run *run = z->run;
    double before = lw_run_energy(run, y), best = INFINITY, tail = 0, relative = run->d->o.relative;
    turn back = foretold_turn(a), best_back = back;
    int best_k = 0;
    for (int k = 0; half(k & ~1) > shortest_half; k++) {
        if (k%2 ? half(k) < shortest_half || back.beyond < turn_outside*half(k) : back.beyond > 0.5*half(k))
            continue;
        turn here = back;
        lw_status s = begin_gap(z, half(k), k%2 ? NULL : &here, a, good, first);
        s = s == LW_OK ? lw_passage_solve(z, y, &tail) : s;
        if (s == LW_STOPPED || s == LW_E_MEMORY)
            return s;
        if (s != LW_OK || !lw_passage_is_clear(z, (k%2 ? clear_of_crossing : clear_of_turn)*half(k))
            || !lw_passage_meets(z, fmax(10*run->d->o.absolute, 3*tail)))
            continue;
        back = here;                         /* known better now */
        tail = fmax(tail, fabs(lw_run_energy(run, y) - before)/fmax(run->r->energy_scale, 1e-300));
        if (tail <= fmax(fmax(resolved, 0.01*relative), 0.1*z->rounding))     /* rounding grows in a shorter gap */
            return LW_OK;
        if (tail < best)
            best = tail, best_k = k, best_back = back;
    }
    if (!(best < fmax(unresolved, 10*relative)))
        return LW_OPEN;
    lw_status s = begin_gap(z, half(best_k), best_k%2 ? NULL : &best_back, a, good, first);
    return s == LW_OK ? lw_passage_solve(z, y, &tail) : s;
}

/* From y at time `good` over the singular posture met at about `place`, which the motion comes near as `a` tells.  stuck: there is no
 * other way on. */
static lw_status step_over(lw_run *run, double good, const approach *a, bool stuck, double place, double *t, double *y)
{
    size_t n = (size_t)run->n;
    double before = lw_run_energy(run, y), *old = run->state;
    double *first = malloc(n*(4 + 2*LW_PASSAGE_NODES)*sizeof *first);
    lw_passage z = { .run = run, .start = good };
    lw_status s = first ? lw_passage_begin(&z) : LW_E_MEMORY;
    if (s != LW_OK) {
        free(first);
        return s;
    }
    z.begun = first + n;
    z.rate = z.begun + n;
    z.state = z.rate + LW_PASSAGE_NODES*n;
    run->state = z.state + LW_PASSAGE_NODES*n;
    memcpy(first, y, n*sizeof *first);
    run->e->text[0] = '\0';
    s = find_gap(&z, a, good, first, y);
    double end = z.start + z.length;
    if (s == LW_OPEN && (stuck || a->w <= half_explicit)) {    /* else there may be a polynomial from nearer */
        z.rule = NULL;
        z.start = fmax(good, place - half_explicit/a->rate);
        memcpy(z.begun, first, n*sizeof *first);
        s = z.start > good ? lw_passage_integrate(run, good, z.start, z.begun, false) : LW_OK;
        end = 2*place - z.start;
        memcpy(y, z.begun, n*sizeof *y);
        if (s == LW_OK)
            s = lw_passage_integrate(run, z.start, end, y, true);
    }
    if (s == LW_OK)
        s = lw_run_project(run, end, y);
    double allowed = fmin(1e-6, (stuck ? 100 : 10)*(run->d->o.relative + 1e-11))*fmax(run->r->energy_scale, 1e-300);
    if (s == LW_OK && !(fabs(lw_run_energy(run, y) - before) <= allowed))
        s = LW_OPEN;
    if (s == LW_OPEN || s == LW_E_NUMERIC) { /* no motion was found behind it: does friction jam on the way there? */
        end = 2*place - good;
        memcpy(y, first, n*sizeof *y);
        go_straight(run->d, end - good, y, first + run->d->n_q, NULL, run->state);
    }
    double share = s >= 0 || s == LW_E_NUMERIC ? jams(run, place, first, y, run->state) : 0;
    if (share > 0)
        run->jam = run->r->t = good + share*(end - good), s = LW_E_NUMERIC;
    on_the_way way = { run, good, first, &z };
    bool struck = s == LW_OK && is_struck(&way, end, run->y);
    if (s == LW_OK && !struck)
        s = lw_run_samples(run, nextafter(end, good), state_on_the_way, &way);
    free(first);
    run->state = old;
    if (struck)
        return lw_error_set(run->e, LW_E_NUMERIC, "a rigid stop is struck close to the singular posture at t = %.9g s, where impacts are not known",
                            place);
    if (s == LW_OK)
        run->e->text[0] = '\0';             /* of shorter and longer gaps */
    *t = end;
    s = s == LW_E_NUMERIC && run->apart > 0 && !(share > 0) ? LW_OPEN : s;      /* near another motion curve: lw_dynamics_run says so */
    return s == LW_OK || s == LW_STOPPED ? s
         : lw_error_set(run->e, s, "at t = %.9g s the linkage comes to a singular posture with speed, and no "
                        "motion was found behind it that keeps the energy: a dead point, the end of its way, or too great a tolerance", place);
}

/* From the state y (overwritten) at *t, where the root of the least pivot is *w, halve the time left to the singular posture at `place` until *w is small:
 * from afar its rate does not foretell where it is 0. */
static lw_status come_near(lw_run *run, double place, double *t, double *w, double *y)
{
    lw_dynamics *d = run->d;
    lw_status s = LW_OK;
    for (int k = 0; s == LW_OK && *w > 2*LW_SINGULAR_STEP_HALF && k < 16; k++) {
        double next = 0.5*(*t + place);
        if ((s = lw_passage_integrate(run, *t, next, y, false)) != LW_OK)
            break;
        *t = next;
        d->by_rank = false;                  /* else the pivot is not found */
        s = lw_mbs_rows(d, *t, y);
        if (s == LW_OK)
            s = lw_mbs_factor(d, false);
        *w = sqrt(fmax(d->weak, 0));
    }
    return s;
}

lw_status lw_run_singular_step(lw_run *run, double good, double weak, double place, double *t, double *y)
{
    approach a;
    double w = sqrt(weak), at = good, *near = malloc((size_t)run->n*sizeof *near);
    if (!near)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    memcpy(near, y, (size_t)run->n*sizeof *near);
    lw_status s = come_near(run, place, &at, &w, near);
    s = s == LW_OK ? find_approach(run, at, near, w, &a) : s;
    free(near);
    if (s == LW_E_MEMORY || s == LW_STOPPED)
        return s;
    if (s != LW_OK || !(a.rate > 0))
        a = (approach){ at, w, w/(place - at), 0 };
    return step_over(run, good, &a, true, place, t, y);
}

/* ---- through it on a curve ---------------------------------------------------------------------------------- */

enum { N_SIDE = 6, N_PLACES = 2*N_SIDE, N_KNOWN = N_PLACES + 6 };

static const double node[N_SIDE] = { 0.280, 0.447, 0.640, 0.808, 0.929, 0.992 };     /* as fractions of half the length */

static const double outside = 0.55;          /* distance from the middle beyond which the rows serve again */
static const double longest_half = 0.3;           /* half of the longest curve, scaled: about radians */
static const double beside = 0.45;           /* root of the least pivot at which to look ahead */
static const double too_near = 1e-3;         /* root of the least pivot too small to begin at */
static const double finer = 0.01;            /* tolerance on the curve over that of the run: it costs little */

/* A polynomial in Newton's form: columns of divided differences. */
typedef struct curve { int n, n_q; double x[N_KNOWN], *c; } curve;

typedef struct crossing {
    lw_run *run;
    lw_dynamics *d;
    lw_integrator *w;
    int    along;                            /* coordinate that measures s */
    double sense, zero;                        /* its direction; its value at the start: s = sense (q - zero) */
    double at, half;                         /* the singular posture; half the length */
    double root;                             /* sqrt(M) at the start */
    int    n_visited;
    double visited[N_KNOWN], pivot[N_KNOWN];    /* places known, root of the least pivot there */
    curve  known, path;
    double *q, *v, *guess;                   /* (n_q) */
} crossing;

/* ---- the curve -------------------------------------------------------------------------------------- */

static void add(curve *p, double x, const double *q)
{
    double *row = p->c + p->n*p->n_q;
    assert(p->n < N_KNOWN);
    memcpy(row, q, (size_t)p->n_q*sizeof *row);
    for (int k = 0; k < p->n; k++) {
        double by = 1/(x - p->x[k]);
        const double *c = p->c + k*p->n_q;
        for (int i = 0; i < p->n_q; i++)
            row[i] = (row[i] - c[i])*by;
    }
    p->x[p->n++] = x;
}

/* Value and, when given, derivative at x. */
static void value(const curve *p, double x, double *q, double *dq)
{
    int n = p->n_q;
    memcpy(q, p->c + (p->n - 1)*n, (size_t)n*sizeof *q);
    if (dq)
        memset(dq, 0, (size_t)n*sizeof *dq);
    for (int k = p->n - 2; k >= 0; k--) {
        double z = x - p->x[k];
        const double *c = p->c + k*n;
        for (int i = 0; dq && i < n; i++)
            dq[i] = dq[i]*z + q[i];
        for (int i = 0; i < n; i++)
            q[i] = q[i]*z + c[i];
    }
}

static double place(const crossing *z, const double *q) { return z->sense*(q[z->along] - z->zero); }

/* Add a place near x to the curve: predicted from the places known, put on the rows.  A correction longer than a
 * small part of the distance to the other curve would be a jump to it. */
static lw_status add_place(crossing *z, double x, const double *foretold)
{
    lw_dynamics *d = z->d;
    if (foretold)
        memcpy(z->guess, foretold, (size_t)d->n_q*sizeof *z->guess);
    else
        value(&z->known, x, z->guess, NULL);
    memcpy(z->q, z->guess, (size_t)d->n_q*sizeof *z->q);
    d->by_rank = false;                             /* else the pivot is not found */
    if (lw_mbs_project_q(d, z->run->r->t, z->q, 0.1) != LW_OK || lw_mbs_factor(d, false) != LW_OK)
        return LW_NOTHING;
    double moved = 0;
    for (int i = 0; i < d->n_q; i++)
        moved = fmax(moved, fabs(z->q[i] - z->guess[i]));
    z->visited[z->n_visited] = place(z, z->q);
    z->pivot[z->n_visited] = sqrt(fmax(d->weak, 0));
    if (!(moved < 0.1*z->pivot[z->n_visited]))
        return LW_NOTHING;
    add(&z->known, z->visited[z->n_visited++], z->q);
    return LW_OK;
}

/* Where the pivot vanishes, by the parabola s(pivot) through the three places nearest to it on this side. */
static bool find_middle(crossing *z)
{
    int best[3] = { -1, -1, -1 };
    for (int k = 0; k < z->n_visited; k++)
        for (int j = 0, who = k; j < 3; j++)
            if (best[j] < 0 || z->pivot[who] < z->pivot[best[j]]) {
                int was = best[j];
                best[j] = who;
                if ((who = was) < 0)
                    break;
            }
    double w[3], s[3];
    for (int j = 0; j < 3; j++) {
        w[j] = z->pivot[best[j]];
        s[j] = z->visited[best[j]];
        if (j && !(s[j] < s[j - 1] && w[j] > w[j - 1]))
            return false;
    }
    double a = s[0] - w[0]*(s[1] - s[0])/(w[1] - w[0]), b = s[1] - w[1]*(s[2] - s[1])/(w[2] - w[1]);
    z->at = a - w[0]*(b - a)/(w[2] - w[0]);
    return z->at > s[0] && z->at < 2*longest_half;
}

/* Add a few places behind the start, the first predicted by the velocities. */
static lw_status look_back(crossing *z, const double *q, const double *v)
{
    static const double back[] = { 0.02, 0.045, 0.08, 0.13 };
    double speed = z->sense*v[z->along];
    lw_status s = lw_mbs_rows(z->d, z->run->r->t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(z->d, false);
    if (s != LW_OK)
        return s == LW_OPEN ? LW_NOTHING : s;
    add(&z->known, 0, q);
    z->visited[0] = 0;
    z->pivot[0] = sqrt(z->d->weak);
    z->n_visited = 1;
    for (int i = 0; i < z->d->n_q; i++)
        z->v[i] = q[i] - back[0]*v[i]/speed;
    for (int k = 0; k < 4; k++)
        if (add_place(z, -back[k], k ? NULL : z->v) != LW_OK)
            return LW_NOTHING;
    return find_middle(z) ? LW_OK : LW_NOTHING;
}

/* Add places on this side, then beyond, each predicted from its nearest neighbours. */
static lw_status collect(crossing *z, double q[N_PLACES][LW_SYSTEM_Q_MAX], double x[N_PLACES])
{
    int inner = 0;
    while (inner < N_SIDE - 1 && node[inner]*z->half < z->at)
        inner++;
    z->known.n = z->n_visited = 5;
    for (int k = 0; k < N_PLACES; k++) {
        /* before the middle: from the start backwards, then forwards; then behind the middle */
        int m = k < N_SIDE - inner ? inner + k : k < N_SIDE ? N_SIDE - 1 - k : k - N_SIDE;
        int to = k < N_SIDE ? m : N_SIDE + m;
        if (add_place(z, z->at + (k < N_SIDE ? -1 : 1)*node[m]*z->half, NULL) != LW_OK)
            return LW_NOTHING;
        x[to] = z->visited[z->n_visited - 1];
        memcpy(q[to], z->q, (size_t)z->d->n_q*sizeof(double));
    }
    return LW_OK;
}

/* Does the polynomial satisfy the rows in the gap and beside it?  Lengths that differ by less than the tolerance
 * count as equal: a parallelogram written with ten digits is meant to be one. */
static bool closes(crossing *z)
{
    lw_dynamics *d = z->d;
    double off = 0;
    for (int k = -8; k <= 8; k++) {
        value(&z->path, z->at + z->half*k/8, z->guess, NULL);
        if (lw_mbs_rows(d, z->run->r->t, z->guess) != LW_OK)
            return false;
        for (int r = 0; r < d->n_c; r++)
            off = !(fabs(d->phi[r]) <= off) ? fabs(d->phi[r]) : off;
    }
    z->run->apart = off;
    return lw_passage_fits(off, d->o.absolute);
}

/* Find the longest curve that satisfies the rows. */
static lw_status find_curve(crossing *z)
{
    static const int order[N_SIDE] = { 5, 0, 3, 1, 4, 2 };       /* far apart first: rounding grows less */
    double q[N_PLACES][LW_SYSTEM_Q_MAX], x[N_PLACES];
    for (z->half = longest_half; z->at < z->half; z->half *= 0.5) {
        if (collect(z, q, x) != LW_OK)
            return LW_NOTHING;
        z->path.n = 0;
        for (int k = 0; k < N_SIDE; k++)
            for (int side = 0; side < 2; side++)
                add(&z->path, x[order[k] + side*N_SIDE], q[order[k] + side*N_SIDE]);
        if (closes(z))
            return LW_OK;
    }
    return LW_NOTHING;
}

/* Is no stop struck anywhere on the curve?  What happens there is not looked for while the linkage moves on it. */
static bool clear_of_stops(crossing *z)
{
    lw_dynamics *d = z->d;
    double left[LW_EVENT_MAX] = { 0 };
    for (int k = -64; d->n_stop && k <= 64; k++) {
        value(&z->path, z->at + z->half*k/64, z->guess, NULL);
        if (lw_run_stop_events(z->run, z->run->r->t, z->guess, left) != LW_OK)
            return false;
        for (int i = 0; i < d->n_stop; i++)
            if (!(left[i] > 0))
                return false;
    }
    return true;
}

/* ---- motion on it -------------------------------------------------------------------------------------- */

/* Equations of motion of y = s, p over the root of M at the start, work. */
static lw_status rate(void *context, double t, const double *y, double *dy)
{
    crossing *z = context;
    lw_dynamics *d = z->d;
    double mass = 0, push = 0, power = 0;
    lw_status s = lw_run_busy(z->run, t);
    if (s != LW_OK)
        return s;
    value(&z->path, y[0], z->q, z->v);
    for (int i = 0; i < d->n_q; i++)
        mass += d->eq.mass[i]*z->v[i]*z->v[i];
    double root = sqrt(mass), speed = y[1]*z->root/root;
    memcpy(z->guess, z->v, (size_t)d->n_q*sizeof *z->guess);
    for (int i = 0; i < d->n_q; i++)
        z->v[i] *= speed;
    d->eq.forces(d->eq.context, t, z->q, z->v, d->force, z->run->has_work ? &power : NULL);
    for (int i = 0; i < d->n_q; i++)
        push += z->guess[i]*d->force[i];
    dy[0] = speed;
    dy[1] = push/(root*z->root);
    if (z->run->has_work)
        dy[2] = power;
    return isfinite(dy[0]) && isfinite(dy[1]) ? LW_OK : LW_E_NUMERIC;
}

/* The state of the run on the curve. */
static void bodies_state(const crossing *z, const double *s, double *y)
{
    const lw_dynamics *d = z->d;
    double mass = 0, *v = y + d->n_q;
    value(&z->path, s[0], y, v);
    for (int i = 0; i < d->n_q; i++)
        mass += d->eq.mass[i]*v[i]*v[i];
    for (int i = 0; i < d->n_q; i++)
        v[i] *= s[1]*z->root/sqrt(mass);
    if (z->run->has_work)
        y[2*d->n_q] = s[2];
}

/* The state of the run at t, within the last step. */
static lw_status state_at(void *context, double t, double *y)
{
    const crossing *z = context;
    double s3[3];
    memcpy(s3, z->w->y, (size_t)z->w->ode->n*sizeof *s3);
    lw_status s = t == z->w->t ? LW_OK : lw_integrate_dense(z->w, t, s3);
    if (s == LW_OK)
        bodies_state(z, s3, y);
    return s;
}

/* Move until the linkage is well outside the middle, on either side, and moves away from it. */
static lw_status move(crossing *z, double *t, double *y)
{
    lw_run *run = z->run;
    lw_dynamics *d = z->d;
    lw_ode ode = { .n = 2 + run->has_work, .context = z, .rate = rate };
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double memory[LW_INTEGRATE_WORK(3, 0)], s[3] = { 0, 0, run->has_work ? y[2*d->n_q] : 0 }, mass = 0;
    z->w = &w;
    z->root = 1;
    rate(z, *t, (double[]){ 0, 1, 0 }, (double[3]){ 0 });
    for (int i = 0; i < d->n_q; i++)
        mass += d->eq.mass[i]*z->guess[i]*z->guess[i];
    z->root = sqrt(mass);
    /* rate of s, in the metric of the masses */
    for (int i = 0; i < d->n_q; i++)
        s[1] += d->eq.mass[i]*z->guess[i]*y[d->n_q + i]/mass;
    o.relative = finer*d->o.relative;
    o.absolute = finer*d->o.absolute;
    o.max_step = lw_run_steps_left(run);
    o.greatest = 0.35*z->half/fmax(fabs(s[1]), 1e-300);
    lw_status st = lw_integrate_start(&w, &ode, &o, memory, *t, s, run->e);
    w.h = st == LW_OK ? fmin(o.greatest, d->o.to - *t) : 0;
    for (long k = 1; st == LW_OK && stop != LW_ODE_END; k++) {
        st = lw_integrate_step(&w, d->o.to, &stop, run->e);
        if (st != LW_OK)
            break;
        bodies_state(z, w.y, y);
        run->r->t = *t = w.t;
        lw_run_watch(run, y);
        st = lw_run_samples(run, w.t, state_at, z);
        if (st == LW_OK)
            st = lw_run_limits(run, w.t, k);
        double off = (w.y[0] - z->at)/z->half;
        if (fabs(off) > outside && off*w.y[1] > 0)
            break;
        w.o.greatest = 0.35*z->half/fmax(fabs(w.y[1]), 1e-300);
    }
    run->r->steps += w.n_step;
    run->r->refused += w.n_refused;
    run->r->rates += w.n_rate;
    return st;
}

/* ---- when ------------------------------------------------------------------------------------------------- */

static lw_status cross_on_curve(lw_run *run, double *t, double *y)
{
    lw_dynamics *d = run->d;
    size_t n = (size_t)d->n_q;
    crossing z = { .run = run, .d = d, .zero = 0 };
    double *memory = calloc(n*(2*N_KNOWN + 3), sizeof *memory), most = 0;
    if (!memory)
        return LW_E_MEMORY;
    z.known = (curve){ .n_q = d->n_q, .c = memory };
    z.path = (curve){ .n_q = d->n_q, .c = memory + n*N_KNOWN };
    z.q = memory + 2*n*N_KNOWN;
    z.v = z.q + n;
    z.guess = z.v + n;
    for (int i = 0; i < d->n_q; i++) {
        double size = fabs(y[n + (size_t)i])*(i%3 == 2 ? 3 : 1);         /* turns are preferred */
        z.along = size > most ? i : z.along;
        most = fmax(most, size);
    }
    z.sense = y[d->n_q + z.along] < 0 ? -1 : 1;
    z.zero = y[z.along];
    lw_status s = most > 0 ? look_back(&z, y, y + n) : LW_NOTHING;
    s = s == LW_OK ? find_curve(&z) : s;
    s = s == LW_OK && !clear_of_stops(&z) ? LW_NOTHING : s;
    if (s == LW_OK)
        s = move(&z, t, y);
    free(memory);
    return s;
}

lw_status lw_run_rechoose(lw_run *run, double t, const double *y, double *weak)
{
    lw_dynamics *d = run->d;
    run->chosen = fmax(run->chosen, *weak);
    if (d->n_c == d->rank || *weak > 0.1*run->chosen)
        return LW_NOTHING;
    int rank = d->rank;
    double scale = d->weak_scale;
    lw_status s = lw_mbs_arrange(d, t, y);
    if (s == LW_OK && d->rank < rank)
        return LW_E_NUMERIC;
    d->weak_scale = scale;                   /* of the start: this posture may be near a singular one */
    if (s == LW_OK && (s = lw_mbs_factor(d, false)) < 0)
        return s;
    *weak = run->chosen = d->weak;
    return s;
}

lw_status lw_run_singular_crossing(lw_run *run, double weak, const double *before, double *t, double *y)
{
    const lw_dynamics *d = run->d;
    double w = sqrt(fmax(weak, 0)), fall = run->pivot - w, since = *t - run->pivot_t;
    bool one = d->freedom == 1 && !d->space && !d->n_driven && !d->n_friction && !d->eq.n_z;
    bool stops = one ? d->n_resting > 0 : d->n_stop > 0;
    double from = one ? beside : 2*LW_SINGULAR_STEP_HALF, reach = one ? longest_half : 3*LW_SINGULAR_STEP_HALF;
    lw_status jam = jumped(run, fall, *t, y);
    if (jam != LW_OK)
        return jam;
    run->pivot = w;
    run->pivot_t = *t;
    run->ahead = fall > 0 && w < 1 ? since*w/fall : 0;
    bool near = w < too_near && (one || !before);
    if (stops || w > from || near)
        run->pivot_tried = 1;
    run->apart = w > beside ? 0 : run->apart;
    if (stops || w > from || near || !(fall > 0) || w > 0.7*run->pivot_tried || *t >= d->o.to)
        return LW_NOTHING;
    approach a = { *t, w, fall/since, 0 };
    lw_status s = one ? LW_OK : find_approach(run, *t, y, w, &a);
    if (s == LW_E_MEMORY || s == LW_STOPPED)
        return s;
    if (s != LW_OK || !(a.rate > 0) || foretold_turn(&a).beyond < -turn_before)
        return LW_NOTHING;
    double place = *t + time_to_it(&a);
    if (fastest(d, y)*(place - *t) > reach || place - *t > 2*(d->o.to - *t))      /* far in space, or behind the end of the run */
        return LW_NOTHING;
    run->pivot_tried = w;
    lw_error was = *run->e;
    if (!one && w < LW_SINGULAR_STEP_HALF && before) {        /* the state before is known better */
        memcpy(y, before, (size_t)run->n*sizeof *y);
        *t -= since;
    }
    s = one ? cross_on_curve(run, t, y) : step_over(run, *t, &a, false, place, t, y);
    if (s == LW_OK && !one) {
        run->r->t = *t;
        lw_run_watch(run, y);
    }
    s = one || s == LW_OK || s == LW_STOPPED ? s : LW_NOTHING;
    if (s == LW_NOTHING)
        *run->e = was;
    else
        run->pivot = run->apart = 0, run->pivot_tried = 1;
    return s;
}
