/* mbs/formulations/capture.c - many rigid contacts at once: rest, stick and slip are captured in steps, and so are impacts where many follow each
 * other (Moreau 1988, Jean 1999).  A chain of a thousand links that falls on the ground has more impacts than can be located one by one.
 *
 * A step of length h covers its first half with the old velocities v.  In its middle bodies that approach and have a restitution bounce, by the law of
 * impact of mbs/run/touch.c.  Then it finds the new velocities v' and covers the other half:
 *
 *     M (v' - v) = h Q - J^T l + N^T p + T^T f,   J v' = rates of the inputs,
 *     p >= 0,  N v' >= 0,  one of them 0;   |f| <= mu p, and f = -mu p against the slip T v'
 *
 * over the places that are closed in the middle of the step.  Newton's method for complementarity finds which of them
 * press and which stick: it solves for a guess and changes the places that contradict it (Hintermueller, Ito & Kunisch 2002).
 * At places that slip, friction is proportional to the normal force, so the system is not symmetric.  All rows stay in
 * its pattern; inactive rows become 0, so that a pass is one sparse factorisation.  Rows of contacts have a compliance of
 * the size of rounding errors, which shares undetermined loads.
 *
 * While no contact closes, the new velocities satisfy the constraints at the end of the step to second order:
 * the rows of joints, and those of the contacts that press and stick.  (If they satisfied them in its middle, a linkage would lose energy in proportion
 * to h, and a body that is let go would leave with a velocity off in proportion to h.)  So the error is of second order then, except for forces that depend
 * on velocities.
 *
 * If few places are struck within a step, the step ends at the first impact: at the root of the gap, predicted from its rate and the accelerations of
 * the last step, and corrected by repeating the step.  After an impact, a step of a moment gives the accelerations.  All places that are closed there take
 * part in the impact, as at a located event.  So the times of impacts are of second order, too.
 * A step ends where a slip ends, too: friction keeps its sense in a step, and the velocity would be off in proportion to h if the slip turned back.
 * Impacts that follow each other within a part of a step, or many impacts in one step, are captured in its middle: their times, and overlaps, are of
 * first order.  The report gives the longest step that captured an impact.
 *
 * Forces are those in the middle of the step, which is explicit: stiff springs, dampers and oil limit its length. */
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/sparse_lu.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/equations/complementarity.h"

static const double finest = 1e-4, coarsest = 0.1;       /* distance that a body moves in a step, over its size */
static const double slow = 0.1;              /* below this fraction, steps of slow bodies are proportional to it, as the duration of a low bounce is */
static const double closed = 1e-2;           /* a gap below this fraction of that distance is closed */
/* An overlap below this fraction of it is captured at any time of the step; so is an impact slower than this fraction of what forces change in a step. */
static const double shallow = 0.1;
static const double unseen = 0.5;            /* a step with an overlap above this fraction of it is repeated in shorter steps */
static const double ahead = 6;              /* places that are at most this many steps away are in the pattern */
static const double turns = 0.25;            /* rates of gaps change by this fraction of the greatest speed until then */
/* Rates below this times the speed count as 0: first, and if the passes do not converge with it. */
static const double exact = 1e-8, allowed = 1e-5;
static const double give = 1e-9;             /* compliance of the rows of contacts, over their diagonals */
static const double resolved = 0.1;          /* step over the time constant of a compliant place */
static const double stable = 2.5;            /* square of the step times the greatest frequency of other forces, over the distance moved in a step */
static const double nudge = 1e-6;            /* way that shows how forces change, scaled */
static const double unstable = 1e-4;         /* change of a state whose rate changes its sign, over the change allowed for other states */
static const double slightest = 1e-3;        /* slip with which friction gives way, over the change of velocities by forces */
static const double moment = 1e-8;           /* step that gives the forces at the start, over the length of the run */
static const double soonest = 1/16.0;        /* an impact after less than this fraction of a step is captured in it */
static const double reached = 1e-3;          /* a step ends at an impact if the gap is then below this fraction of that distance */
static const double ended = 1e-3;            /* so is a slip that ends after less than this fraction */
enum { MOMENTS = 3 };                        /* that give the accelerations after an impact */
enum { CORRECTIONS = 4 };                    /* of the length of a step that ends at an impact */
enum { STRUCK_MOST = 12 };                   /* impacts at more places than this in a step are captured */
enum { ITERATIONS = 30 };                  /* for that frequency, in a step */
enum { PASSES = 120, HARD = 40, LATE = 100, TOGETHER = 12, DENSE_SOON = 60, DENSE_MOST = 250,
       LEAST_CONTACTS = 24, HALVINGS = 8, BOUNCES = 200, TOGETHER_MOST = 60 };

/* A place in the pattern: its index, the first of its rows (gap, then slip if it has friction), its state. */
typedef struct place {
    int    touch, row;
    bool   rubs, shut, presses, pressed;     /* shut: closed in the middle of the step; pressed: before the step */
    int    slips;                            /* 0: sticks */
    double mu, normal, across;               /* impulses */
    double target, glide;                    /* least rate of the gap; rate of the slip while it sticks */
    double closes;                           /* rate in the middle with which a place that did not press closes at the end of the step */
    double pull;                             /* change of the rate of the gap that the forces on its two bodies cause in the step, at most */
} place;

typedef struct capture {
    lw_run *run;
    lw_dynamics *d;
    int     n, n_kept, *kept;                /* places in the pattern; independent rows of the joints */
    place  *at, *before;                     /* before: as they were before the step, */
    double work_before;                      /* and `work`, for repeats */
    double  part;                            /* way of a body in a step over `size`; change of a state in it */
    double  size, *arm;                      /* extents of the smallest body that touches, and of each body (n_q/3), scaled */
    double *q, *v, *after, *next_q, *next_v, *still, *momentum, *wanted, *force, *full, *push, *stiffest;
    lw_columns pattern;                      /* of the system, */
    lw_sparse_lu *lu;                        /* its factors, */
    double *value;                           /* its entries: where pairs of rows and their own products go */
    int    *to, *diagonal;
    bool    hits;                            /* a step ended at an impact, which is still to be applied */
    int     strikes;                         /* the place that strikes at the end of the step and is open until then (index in the list), else -1 */
    double  rest;                            /* speed of the fastest bounce so far that counts as rest, scaled */
    double  late;                            /* the step captures an impact: its length, else 0 */
    double  t, work, power;                  /* power of forces without potential after the impacts of the step [W] */
    double *z, *next_z, *mean_z, *try_z, *rate, *other;      /* first-order states, their mean over a step, their rates (n_z) */
} capture;

/* ---- states and compliant places ---------------------------------------------------------------------------- */

/* Rates of the states z at (t, q, v). */
static lw_status rates_of(capture *g, double t, const double *q, const double *v, const double *z, double *rate)
{
    g->d->eq.place_states(g->d->eq.context, z);
    return lw_mbs_state_rates(g->d, t, q, v, rate);
}

/* Move the states z over `whole` from t on, at (q, v), and set mean (n_z, unless NULL) to their mean; by the midpoint rule, in so many parts that its two
 * rates hardly differ: the states of motors are far faster than steps of contact.  Near rest the rates differ little in steps that are too
 * long for the rule to be stable; there a rate must not turn to a greater one of the other sign. */
static lw_status move_states(capture *g, double t, double whole, const double *q, const double *v, double *z, double *mean)
{
    const lw_equations *eq = &g->d->eq;
    double done = 0, h = whole;
    lw_status s = LW_OK;
    if (eq->n_z == 0)
        return LW_OK;
    eq->place(eq->context, q);
    if (mean)
        memset(mean, 0, (size_t)eq->n_z*sizeof *mean);
    while (s == LW_OK && done < whole) {
        double off = 0, grows = 0;
        h = fmin(h, whole - done);
        if ((s = rates_of(g, t + done, q, v, z, g->rate)) != LW_OK)
            break;
        for (int i = 0; i < eq->n_z; i++)
            g->try_z[i] = z[i] + 0.5*h*g->rate[i];
        if ((s = rates_of(g, t + done + 0.5*h, q, v, g->try_z, g->other)) != LW_OK)
            break;
        for (int i = 0; i < eq->n_z; i++) {
            double change = h*fabs(g->other[i] - g->rate[i])/(fabs(z[i]) + eq->state_scale(eq->context, i));
            off = fmax(off, change);
            if (fabs(g->other[i] - g->rate[i]) > fabs(g->rate[i]))
                grows = fmax(grows, change);
        }
        if (!(off < g->part && grows < unstable*g->part) && h > 1e-6*whole) {
            h *= 0.5;
            continue;
        }
        for (int i = 0; i < eq->n_z; i++) {
            z[i] += h*g->other[i];
            if (mean)
                mean[i] += h/whole*g->try_z[i];
        }
        done = h < whole - done ? done + h : whole;
        h *= off < 0.2*g->part ? 2 : 1;
    }
    return s;
}

/* Set mean_z, whose first half is known, to the mean of the states over a step of length h: the second half follows from their rates in the middle. */
static lw_status mean_states(capture *g, double h)
{
    const lw_equations *eq = &g->d->eq;
    lw_status s = eq->n_z ? rates_of(g, g->t + 0.5*h, g->next_q, g->v, g->next_z, g->rate) : LW_OK;
    for (int i = 0; i < eq->n_z; i++)
        g->mean_z[i] = 0.5*(g->mean_z[i] + g->next_z[i] + 0.25*h*g->rate[i]);
    return s;
}

/* The longest step in which compliant places that press, or may do so within a step `h`, are well resolved: a part of the
 * period of the bodies there on the stiffness of the place. */
static double compliant_step(capture *g, double h)
{
    lw_dynamics *d = g->d;
    for (int i = 0; i < d->touch->list.n; i++) {
        const lw_touch *p = &d->touch->list.touch[i];
        lw_touch_motion m;
        if (!(p->surface->stiffness > 0))
            continue;
        lw_touch_at(p, &d->eq, d->frames, g->v, &m);
        double depth = fmax(-m.gap, fabs(m.rate)*h), gives = 0;
        if (m.gap > fabs(m.rate)*h)
            continue;
        for (int k = 0; k < 6; k++)
            if (p->body[k/3] >= 0)
                gives += m.n[k]*m.n[k]*d->by_mass[3*p->body[k/3] + k%3];
        double stiff = (lw_touch_force(p->surface, d->s.unit, 1.01*depth, 0) - lw_touch_force(p->surface, d->s.unit, 0.99*depth, 0))
                     /fmax(0.02*depth, 1e-300)*d->s.unit;
        double damped = (lw_touch_force(p->surface, d->s.unit, depth, fabs(m.rate) + 1e-3) - lw_touch_force(p->surface, d->s.unit, depth, fabs(m.rate)))
                      /1e-3*d->s.unit;
        if (stiff*gives > 0)
            h = fmin(h, resolved/(sqrt(stiff*gives) + damped*gives));
    }
    return h;
}

/* Set force (n_v) to the forces without those of places at (q, v), with the states z (n_z) that have moved over h at these velocities. */
static lw_status forces_behind(capture *g, double h, const double *q, const double *v, double *z, double *force)
{
    const lw_equations *eq = &g->d->eq;
    double power = 0;
    memcpy(z, g->z, (size_t)eq->n_z*sizeof *z);
    lw_status s = move_states(g, g->t, h, q, v, z, NULL);
    eq->place(eq->context, q);
    eq->place_states(eq->context, z);
    eq->forces(eq->context, g->t, q, v, force, &power);
    return s;
}

/* Shorten the step *h to one that stiff springs, dampers, and states such as the pressure of oil leave stable: its forces are those of a posture and velocities
 * foretold from the old ones.  With K and C their derivatives by places and velocities, the greatest eigenvalue of (h^2 K + h C)/M tells, by power
 * iteration, whose vector g->stiffest is kept from step to step. */
static lw_status stable_step(capture *g, double *h)
{
    const lw_dynamics *d = g->d;
    double *u = g->stiffest, *q = g->next_q, *v = g->next_v, *way = d->hold;
    bool begins = g->run->r->steps == 0;
    double most_growth = stable*g->part;
    lw_status s = LW_OK;
    for (int pass = 0; s == LW_OK && pass < ITERATIONS; pass++) {
        double most = lw_greatest(d->n_v, u), before = 0, behind = 0;
        for (int i = 0; !(most > 0) && i < d->n_v; i++)
            u[i] = sqrt(d->by_mass[i])*(0.5 + (double)((unsigned)i*2654435761u >> 16)/65536);
        most = most > 0 ? most : lw_greatest(d->n_v, u);
        for (int i = 0; i < d->n_v; i++) {
            way[i] = nudge*u[i]/most;
            v[i] = g->v[i] + way[i]/ *h;
        }
        memcpy(q, g->q, (size_t)d->n_q*sizeof *q);
        d->eq.move(d->eq.context, q, way);
        s = forces_behind(g, *h, g->q, g->v, g->mean_z, g->force);
        s = s == LW_OK ? forces_behind(g, *h, q, v, g->next_z, g->momentum) : s;
        for (int i = 0; i < d->n_v; i++) {
            double mass = d->by_mass[i] > 0 ? 1/d->by_mass[i] : 0;
            before += mass*u[i]*u[i]/(most*most);
            u[i] = (g->force[i] - g->momentum[i])*d->by_mass[i]/nudge;
            behind += mass*u[i]*u[i];
        }
        double grows = *h**h*sqrt(behind/fmax(before, 1e-300));
        if (!(grows > most_growth) && !begins)
            break;
        *h *= grows > most_growth ? fmax(0.1, sqrt(most_growth/grows)) : 1;
    }
    return s;
}

/* ---- the pattern ------------------------------------------------------------------------------------------ */

/* The acceleration of a gap that the forces on its two bodies, without those of joints and rigid places, cause if joints turn them into its direction. */
static double pull_on(const capture *g, const lw_touch *p, const lw_touch_motion *m)
{
    double sum = 0;
    for (int k = 0; k < 2; k++)
        if (p->body[k] >= 0) {
            const double *n = m->n + 3*k, *f = g->force + 3*p->body[k], *by = g->d->by_mass + 3*p->body[k];
            sum += hypot(n[0], n[1])*hypot(f[0]*by[0], f[1]*by[1]) + fabs(n[2]*f[2]*by[2]);
        }
    return sum;
}

/* Time until the gap has decreased by `way`, from its rate and the accelerations of the last step; INFINITY: never.  *rate: that of the gap then. */
static double closes_in(const capture *g, const lw_touch *p, const lw_touch_motion *m, double way, double *rate)
{
    double curve = m->bias;
    for (int i = 0; i < 6; i++)
        if (p->body[i/3] >= 0)
            curve += m->n[i]*g->d->a[3*p->body[i/3] + i%3];
    double square = m->rate*m->rate - 2*curve*way, root = square > 0 ? sqrt(square) : 0;
    *rate = -root;
    if (m->rate > 0)
        return curve < 0 && square > 0 ? (m->rate + root)/-curve : INFINITY;
    return way > 0 && square > 0 ? 2*way/(root - m->rate) : INFINITY;
}

/* Time until the first event within h, INFINITY: there is none; n places are struck, or end their slip, within h.  The first is an impact
 * of place `strikes` of the list, or the end of a slip (-1). */
typedef struct ahead_of { double h, first; int n, strikes; } ahead_of;

static void note_ahead(ahead_of *to, double in, int strikes)
{
    to->strikes = in < to->first ? strikes : to->strikes;
    to->first = fmin(to->first, in);
    to->n++;
}

/* Does a corner come to an end of a face just where that end slides off a side of the corner's own body, on which it has pressed so far?  Tips pass each other
 * then.  in: the time until the gap closes. */
static bool slides_off(const capture *g, const lw_touch *p, const lw_touch_motion *m, double in)
{
    double along = m->place + m->place_rate*in, near = closed*g->part*g->size;
    bool first = fabs(along) < near;
    if (p->kind != LW_TOUCH_FACE || p->state == LW_TOUCH_HELD || p->radius[0] > 0 || p->radius[1] > 0 || !(first || fabs(along - p->length) < near))
        return false;
    lw_vec2 end = first ? p->arm[1] : lw_v2_add(p->arm[1], lw_v2_scale(p->along, p->length));
    for (int k = 0; k < g->n; k++) {
        const lw_touch *o = &g->d->touch->list.touch[g->at[k].touch];
        lw_vec2 side = lw_v2_scale(o->along, o->length);
        bool on = o->kind == LW_TOUCH_FACE && o->state == LW_TOUCH_HELD && o->length < INFINITY && o->body[0] == p->body[1] && o->body[1] == p->body[0];
        if (on && lw_v2_norm(lw_v2_sub(o->arm[0], end)) < LW_TOUCH_END
            && fmin(lw_v2_norm(lw_v2_sub(p->arm[0], o->arm[1])), lw_v2_norm(lw_v2_sub(p->arm[0], lw_v2_add(o->arm[1], side)))) < LW_TOUCH_END)
            return true;
    }
    return false;
}

/* Note the impact of a place.  Very slow ones, as of bodies at rest, are left to be captured if they overlap by a small fraction of the distance moved in a
 * step at most. */
static void look_ahead(const capture *g, const lw_touch *p, const lw_touch_motion *m, ahead_of *to)
{
    double way = g->part*g->size, rate, later, in = closes_in(g, p, m, m->straight, &rate), along = m->place + m->place_rate*in;
    bool on = p->kind != LW_TOUCH_FACE || !(p->length < INFINITY) || (along >= 0 && along <= p->length);
    if (!((m->straight > 0 || m->rate > 0) && in <= to->h) || !on || slides_off(g, p, m, in))
        return;
    bool overlaps = m->straight > closed*way && closes_in(g, p, m, m->straight + shallow*way, &later) < to->h;
    if (!(rate < -shallow*to->h*pull_on(g, p, m) || overlaps))
        return;
    note_ahead(to, in, (int)(p - g->d->touch->list.touch));
}

/* Note the end of the slip of a place that presses, by the accelerations of the last step: the friction of a step keeps its sense. */
static void look_at_slip(const capture *g, const lw_touch *p, const lw_touch_motion *m, ahead_of *to)
{
    double rate = m->slip_bias;
    for (int i = 0; i < 6; i++)
        if (p->body[i/3] >= 0)
            rate += m->t[i]*g->d->a[3*p->body[i/3] + i%3];
    double in = m->slip*rate < 0 ? -m->slip/rate : INFINITY;
    if (in > ended*to->h && in < to->h)
        note_ahead(to, in, -1);
}

/* Is the gap smaller than `near`, or may it become so within the time `in`? */
static bool comes_near(const lw_touch_motion *m, double in, double speed, double near) { return m->gap < near + in*(fmax(0, -m->rate) + turns*speed); }

/* Return the speed of the fastest place, scaled.  *missing becomes true if a place outside the pattern may close within two steps of length h, at this
 * speed; *to: the impacts ahead, unless NULL. */
static double look(capture *g, double h, double speed, bool *missing, ahead_of *to)
{
    lw_touch_list *list = &g->d->touch->list;
    double fastest = 0;
    int k = 0;
    g->d->eq.place(g->d->eq.context, g->q);
    for (int i = 0; i < list->n; i++) {
        lw_touch_motion m;
        lw_touch_at(&list->touch[i], &g->d->eq, g->d->frames, g->v, &m);
        fastest = fmax(fastest, hypot(m.rate, m.slip));
        if (list->touch[i].surface->stiffness > 0)
            continue;
        while (k < g->n && g->at[k].touch < i)
            k++;
        bool in = k < g->n && g->at[k].touch == i;
        *missing = *missing || (!in && comes_near(&m, 2*h, speed, closed*g->part*g->size));
        if (to && !(in && g->at[k].presses))
            look_ahead(g, &list->touch[i], &m, to);
        else if (to && g->at[k].slips != 0)
            look_at_slip(g, &list->touch[i], &m, to);
    }
    return fastest;
}

static void free_pattern(capture *g)
{
    lw_sparse_lu_free(g->lu);
    lw_columns_free(&g->pattern);
    free(g->value);
    free(g->to);
    g->lu = NULL;
    g->value = NULL;
    g->to = NULL;
}

/* Make the pattern of the system: two rows that share a body have an entry. */
static lw_status make_pattern(capture *g)
{
    lw_dynamics *d = g->d;
    long n = d->n_pair;
    free_pattern(g);
    int *entry = malloc((4*(size_t)n + 1)*sizeof *entry);
    g->to = malloc((2*(size_t)n + (size_t)d->n_kept + 1)*sizeof *g->to);
    if (!entry || !g->to) {
        free(entry);
        return LW_E_MEMORY;
    }
    g->diagonal = g->to + 2*n;
    for (long k = 0; k < n; k++) {
        int i = d->place[d->pair[k].row/d->row_size], j = d->place[d->pair[k].other/d->row_size];
        memcpy(entry + 4*k, (int[]){ i, j, j, i }, 4*sizeof *entry);
    }
    bool ok = lw_columns_make(&g->pattern, d->n_kept, entry, 2*n);
    for (long k = 0; ok && k < n; k++) {
        g->to[2*k] = lw_columns_find(&g->pattern, entry[4*k], entry[4*k + 1]);
        g->to[2*k + 1] = lw_columns_find(&g->pattern, entry[4*k + 1], entry[4*k]);
    }
    for (int i = 0; ok && i < d->n_kept; i++)
        g->diagonal[i] = lw_columns_find(&g->pattern, i, i);
    free(entry);
    ok = ok && (g->value = malloc(((size_t)g->pattern.at[d->n_kept] + 1)*sizeof *g->value)) != NULL;
    ok = ok && (g->lu = lw_sparse_lu_create(&g->pattern, false, false)) != NULL;
    return ok ? LW_OK : LW_E_MEMORY;
}

/* Put the places into the pattern that may close within the time `in`, at a speed; the frames are those at q. */
static lw_status choose_places(capture *g, double in, double speed)
{
    lw_dynamics *d = g->d;
    struct lw_touching *w = d->touch;
    int n = 0, old = g->n, k = 0;
    place *was = malloc(((size_t)old + 1)*sizeof *was);
    if (!was)
        return LW_E_MEMORY;
    memcpy(was, g->at, (size_t)old*sizeof *was);
    w->n_row = 0;
    for (int i = 0; i < w->list.n; i++) {
        const lw_touch *p = &w->list.touch[i];
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, g->v, &m);
        while (k < old && was[k].touch < i)
            k++;
        bool known = k < old && was[k].touch == i;
        if (p->surface->stiffness > 0 || (!comes_near(&m, in, speed, 0.1*g->size) && !(known && was[k].presses)))
            continue;
        place *to = &g->at[n++];
        *to = known ? was[k] : (place){ .touch = i, .mu = p->surface->friction };
        to->rubs = p->kind <= LW_TOUCH_DISCS && to->mu > 0;
        to->row = d->n_row + d->n_driven + w->n_row;
        w->row[w->n_row++] = (lw_touch_row){ i, false };
        if (to->rubs)
            w->row[w->n_row++] = (lw_touch_row){ i, true };
    }
    free(was);
    g->n = n;
    lw_status s = lw_mbs_arrange_touch(d, g->kept, g->n_kept);
    return s == LW_OK ? make_pattern(g) : s;
}

/* ---- a step ------------------------------------------------------------------------------------------------ */

static void clear_row(lw_dynamics *d, int row) { memset(lw_mbs_jac(d, row), 0, (size_t)d->row_size*sizeof *d->jac); }

static int first_row(const lw_dynamics *d) { return d->n_row + d->n_driven; }

/* Restore all rows of places as they are in the middle of the step. */
static void restore_rows(const capture *g)
{
    lw_dynamics *d = g->d;
    memcpy(lw_mbs_jac(d, first_row(d)), g->full, (size_t)((d->n_c - first_row(d))*d->row_size)*sizeof *d->jac);
}

/* Fill in the system for the guess, J M^-1 P^T.  P holds the directions in which the multipliers act: the rows, but at a
 * place that slips the row of the gap less friction. */
static lw_status factor_guess(capture *g)
{
    lw_dynamics *d = g->d;
    memcpy(g->push, d->jac, (size_t)(d->n_c*d->row_size)*sizeof *g->push);
    for (int k = 0; k < g->n; k++) {
        const place *p = &g->at[k];
        double *gap = g->push + p->row*d->row_size, *slip = gap + d->row_size;
        for (int i = 0; p->presses && p->slips && i < d->row_size; i++)
            gap[i] -= p->mu*p->slips*slip[i];
        if (!p->presses)
            clear_row(d, p->row), memset(gap, 0, (size_t)d->row_size*sizeof *gap);
        if (p->rubs && (!p->presses || p->slips))
            clear_row(d, p->row + 1), memset(slip, 0, (size_t)d->row_size*sizeof *slip);
    }
    memset(g->value, 0, (size_t)g->pattern.at[g->pattern.n]*sizeof *g->value);
    for (int k = 0; k < d->n_pair; k++) {
        const lw_row_pair *pair = &d->pair[k];
        int row = pair->row/d->row_size, slot = pair->row%d->row_size/LW_BLOCK;
        const double *m = d->by_mass + LW_BLOCK*lw_mbs_blocks(d, row)[slot], *a = d->jac + pair->row, *b = d->jac + pair->other;
        const double *x = g->push + pair->row, *y = g->push + pair->other;
        g->value[g->to[2*k]] += a[0]*y[0]*m[0] + a[1]*y[1]*m[1] + a[2]*y[2]*m[2];
        if (row != pair->other/d->row_size)
            g->value[g->to[2*k + 1]] += b[0]*x[0]*m[0] + b[1]*x[1]*m[1] + b[2]*x[2]*m[2];
    }
    for (int i = 0; i < d->n_kept; i++) {
        double *diagonal = &g->value[g->diagonal[i]];
        *diagonal = *diagonal == 0 ? 1 : d->kept[i] >= first_row(d) ? *diagonal*(1 + give) : *diagonal;
    }
    return lw_sparse_lu_factor(g->lu, g->value);
}

/* x += the rows given, each by its number in l. */
static void add_rows(const lw_dynamics *d, const double *rows, const double *l, double *x)
{
    for (int r = 0; r < d->n_c; r++) {
        const int *block = lw_mbs_blocks(d, r);
        for (int k = 0; l[r] != 0 && k < d->eq.n_slot && block[k] >= 0; k++)
            for (int i = 0; i < 3; i++)
                x[LW_BLOCK*block[k] + i] += l[r]*rows[r*d->row_size + 3*k + i];
    }
}

/* Project v (n_v) so that the factored rows have the rates `wanted` (n_c; NULL: 0); the multipliers are d->l. */
static void hold_back(capture *g, const double *wanted, double *v)
{
    lw_dynamics *d = g->d;
    double *b = d->small, *x = g->momentum;
    for (int i = 0; i < d->n_kept; i++)
        b[i] = lw_mbs_row_rate(d, d->kept[i], v) - (wanted ? wanted[d->kept[i]] : 0);
    lw_sparse_lu_solve(g->lu, b);
    memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
    for (int i = 0; i < d->n_kept; i++)
        d->l[d->kept[i]] = b[i];
    memset(x, 0, (size_t)d->n_v*sizeof *x);
    add_rows(d, g->push, d->l, x);
    for (int i = 0; i < d->n_v; i++)
        v[i] -= x[i]*d->by_mass[i];
}

/* Solve for the velocities next_v and multipliers d->l with the states of the places as guessed. */
static lw_status solve_guess(capture *g, double h)
{
    lw_dynamics *d = g->d;
    lw_status s = factor_guess(g);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < d->n_v; i++)
        g->next_v[i] = g->after[i] + h*g->force[i]*d->by_mass[i];
    for (int k = 0; k < g->n; k++) {
        const place *p = &g->at[k];
        g->wanted[p->row] = p->presses ? p->target : 0;
        if (p->rubs)
            g->wanted[p->row + 1] = p->presses && p->slips == 0 ? p->glide : 0;
    }
    hold_back(g, g->wanted, g->next_v);
    return LW_OK;
}

/* Change the state of place p if it contradicts the velocities next_v and multipliers l; returns whether it was changed.  A place
 * that begins to press keeps its slip; a place that sticks begins to slip before it opens. */
static bool revise_place(capture *g, place *p, const double *l, double tiny)
{
    const lw_dynamics *d = g->d;
    double slip = p->rubs ? lw_mbs_row_rate(d, p->row + 1, g->next_v) - p->glide : 0;
    p->normal = p->presses ? -l[p->row] : 0;
    p->across = 0;
    if (!p->presses) {
        p->presses = lw_mbs_row_rate(d, p->row, g->next_v) < p->target - tiny;
        p->slips = fabs(slip) > tiny ? slip > 0 ? 1 : -1 : 0;
        return p->presses;
    }
    if (p->rubs && p->slips == 0) {
        p->across = -l[p->row + 1];
        if (fabs(p->across) <= p->mu*p->normal*(1 + 1e-6))
            return false;
        p->slips = p->across > 0 ? -1 : 1;               /* friction acts against the slip */
        return true;
    }
    if (p->normal < 0) {
        p->presses = false;
        p->normal = 0;
        return true;
    }
    p->across = -p->slips*p->mu*p->normal;
    if (!(p->slips*slip < -tiny))
        return false;
    p->slips = 0;
    return true;
}

/* Change all places that contradict the solution; in later passes, which may cycle, a random half of them.
 * Returns the number of contradictions. */
static int revise(capture *g, const double *l, int pass, double tiny)
{
    int changes = 0;
    for (int k = 0; k < g->n; k++) {
        place was = g->at[k];
        if (!was.shut || !revise_place(g, &g->at[k], l, tiny))
            continue;
        changes++;
        if (pass >= TOGETHER && ((unsigned)k*2654435761u + (unsigned)pass*2246822519u + (unsigned)g->run->r->refused*3266489917u) >> 31)
            g->at[k].presses = was.presses, g->at[k].slips = was.slips;
    }
    return changes;
}

/* Set v (n_v) to the velocities that a unit impulse along a row causes. */
static void respond(capture *g, int row, double *v)
{
    const lw_dynamics *d = g->d;
    const double *jac = lw_mbs_jac(d, row);
    const int *block = lw_mbs_blocks(d, row);
    memset(v, 0, (size_t)d->n_v*sizeof *v);
    for (int k = 0; k < d->eq.n_slot && block[k] >= 0; k++)
        for (int i = 0; i < LW_BLOCK; i++)
            v[LW_BLOCK*block[k] + i] += jac[LW_BLOCK*k + i]*d->by_mass[LW_BLOCK*block[k] + i];
    hold_back(g, NULL, v);
}

/* Set the velocities next_v and multipliers d->l for impulses (two each: normal, across) at the m closed places. */
static void adopt(capture *g, double h, int m, const int *row, const double *impulse)
{
    lw_dynamics *d = g->d;
    memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
    memset(g->momentum, 0, (size_t)d->n_v*sizeof *g->momentum);
    for (int i = 0; i < 2*m; i++)
        if (row[i] >= 0)
            d->l[row[i]] = impulse[i];
    add_rows(d, d->jac, d->l, g->momentum);
    for (int i = 0; i < d->n_v; i++)
        g->next_v[i] = g->after[i] + (h*g->force[i] + g->momentum[i])*d->by_mass[i];
    hold_back(g, g->wanted, g->next_v);
    for (int k = 0, i = 0; k < g->n; k++) {
        place *p = &g->at[k];
        if (!p->shut)
            continue;
        p->normal = impulse[2*i];
        p->across = impulse[2*i++ + 1];
        p->presses = p->normal > 0;
        p->slips = !p->rubs || fabs(p->across) < (1 - 1e-9)*p->mu*p->normal ? 0 : p->across > 0 ? -1 : 1;
        d->l[p->row] = -p->normal;
        if (p->rubs)
            d->l[p->row + 1] = p->slips ? 0 : -p->across;
    }
}

/* The m closed places of a step as a dense problem: responses of the rates to impulses, rates without impulses, rows in the pattern (-1: none). */
typedef struct dense { double *w, *b, *impulse, *rate; lw_touch_law *law; int *row; } dense;

static void free_dense(dense *p)
{
    free(p->w);
    free(p->law);
    free(p->row);
}

/* Places are left without forces, and next_v is the velocity without them. */
static lw_status make_dense(capture *g, double h, int m, dense *to)
{
    const lw_dynamics *d = g->d;
    size_t r = 2*(size_t)m;
    *to = (dense){ calloc(r*r + 3*r + (size_t)d->n_v + 1, sizeof *to->w), .law = calloc((size_t)m + 1, sizeof *to->law),
                   .row = malloc((r + 1)*sizeof *to->row) };
    if (!to->w || !to->law || !to->row)
        return LW_E_MEMORY;
    to->b = to->w + r*r;
    to->impulse = to->b + r;
    to->rate = to->impulse + r;
    double *v = to->rate + r;
    int n = 0;
    for (int k = 0; k < g->n; k++) {
        place *p = &g->at[k];
        p->presses = false;
        if (!p->shut)
            continue;
        to->law[n].friction = p->rubs ? p->mu : 0;
        to->row[2*n] = p->row;
        to->row[2*n + 1] = p->rubs ? p->row + 1 : -1;
        to->b[2*n + 1] = -p->glide;
        to->b[2*n++] = -p->target;
    }
    lw_status s = solve_guess(g, h);
    restore_rows(g);
    for (size_t j = 0; s == LW_OK && j < r; j++) {
        if (to->row[j] < 0)
            continue;
        to->b[j] += lw_mbs_row_rate(d, to->row[j], g->next_v);
        respond(g, to->row[j], v);
        for (size_t i = 0; i < r; i++)
            to->w[i*r + j] = to->row[i] < 0 ? 0 : lw_mbs_row_rate(d, to->row[i], v);
    }
    return s;
}

/* Used if the guesses of a step cycle: Lemke's method over the m closed places, a dense problem.  Bodies that are wedged by friction
 * have many solutions, and Newton's method may find none of them.  LW_NOTHING: no solution was found. */
static lw_status solve_densely(capture *g, double h, int m)
{
    dense p;
    lw_status s = make_dense(g, h, m, &p);
    if (s == LW_OK)
        s = lw_complementarity(m, p.w, p.b, p.law, p.impulse, p.rate);
    if (s == LW_OK)
        adopt(g, h, m, p.row, p.impulse);
    free_dense(&p);
    return s;
}

/* Of the m closed places, a place that stuck before the step slips behind it, by forces that change velocities by `pull`.  Could friction have held it by other
 * impulses?  Then rigid bodies have both motions.  The solution of the step remains. */
static lw_status note_jam(capture *g, double h, int m, double pull)
{
    lw_dynamics *d = g->d;
    int worst = -1, touch = -1;
    double slip = slightest*pull;
    if (g->run->r->jammed || g->late > 0 || m > DENSE_SOON)
        return LW_OK;
    for (int k = 0, i = 0; k < g->n; k++) {
        const place *p = &g->at[k];
        if (!p->shut)
            continue;
        double before = p->rubs ? lw_mbs_row_rate(d, p->row + 1, g->after) : 0, rate = p->rubs ? lw_mbs_row_rate(d, p->row + 1, g->next_v) : 0;
        if (p->presses && p->slips != 0 && d->touch->list.touch[p->touch].sticks && fabs(before) <= pull && fabs(rate) > fabs(slip))
            worst = i, touch = p->touch, slip = rate;
        i++;
    }
    if (worst < 0)
        return LW_OK;
    size_t n_v = (size_t)d->n_v, n_c = (size_t)d->n_c, n = (size_t)g->n;
    double *kept = malloc((n_v + n_c)*sizeof *kept);
    place *at = malloc(n*sizeof *at);
    lw_status s = kept && at ? LW_OK : LW_E_MEMORY;
    if (s == LW_OK) {
        dense p;
        memcpy(kept, g->next_v, n_v*sizeof *kept);
        memcpy(kept + n_v, d->l, n_c*sizeof *kept);
        memcpy(at, g->at, n*sizeof *at);
        s = make_dense(g, h, m, &p);
        for (int i = 0; s == LW_OK && i < m; i++)
            p.law[i].holds = true;
        if (s == LW_OK && lw_complementarity(m, p.w, p.b, p.law, p.impulse, p.rate) == LW_OK
            && lw_complementarity_held(m, p.law, p.impulse, p.rate, worst, slip))
            lw_run_touch_jammed(g->run, g->t, touch);
        free_dense(&p);
        memcpy(g->next_v, kept, n_v*sizeof *kept);
        memcpy(d->l, kept + n_v, n_c*sizeof *kept);
        memcpy(g->at, at, n*sizeof *at);
    }
    free(kept);
    free(at);
    return s;
}

/* Does a place press that did not before the step? */
static bool closes_one(const capture *g)
{
    for (int k = 0; k < g->n; k++)
        if (g->at[k].presses && !g->at[k].pressed)
            return true;
    return false;
}

/* If a contact closes in a step, velocities jump, and its end cannot be predicted from the old ones: satisfy the rows in its middle.  Gaps close at its end at
 * the soonest. */
static lw_status aim_at_middle(capture *g, double t)
{
    lw_status s = lw_mbs_rate_wanted(g->d, t);
    memcpy(g->wanted, g->d->rhs, (size_t)g->d->n_c*sizeof *g->wanted);
    for (int k = 0; k < g->n; k++) {
        g->at[k].glide = 0;
        g->at[k].target = g->at[k].closes;
    }
    return s;
}

/* Does the gap stay open to the end of the step, of which `half` is left?  Example: a wheel and the next joint of a rail. */
static bool stays_open(const lw_touch_motion *m, double half)
{
    return m->gap > 0 && m->rate < 0 && m->gap + half*(m->rate + 0.5*half*m->bias) > 0;
}

/* Find the places that are closed in the middle of a step, of which `half` is left (0: at an impact, at which those that are just leaving have no
 * part); returns their number. */
static int find_shut(capture *g, double half)
{
    lw_dynamics *d = g->d;
    double near = closed*g->part*g->size, touching = 2*reached*g->part*g->size;
    int shut = 0;
    for (int k = 0; k < g->n; k++) {
        place *p = &g->at[k];
        lw_touch *touch = &d->touch->list.touch[p->touch];
        lw_touch_motion m;
        lw_touch_at(touch, &d->eq, d->frames, g->v, &m);
        if (!p->presses && m.gap < 0) {
            lw_touch_round_end(touch, &m, 2*half);
            lw_touch_at(touch, &d->eq, d->frames, g->v, &m);
        }
        bool open = !p->presses && (half > 0 ? p->touch == g->strikes || stays_open(&m, half) : m.gap > touching && m.rate > 0);
        p->shut = m.gap < near && !open && !lw_touch_past_end(touch, &m)
               && !lw_touch_goes_on(touch, d->frames, &m, near) && !lw_touch_beside_end(touch, d->frames, &m)
               && !(m.rate < 0 && slides_off(g, touch, &m, fmin(m.gap/-m.rate, half)));
        shut += p->shut;
        p->presses = p->presses && p->shut;
        p->normal = p->across = 0;
    }
    return shut;
}

/* Find the forces in the middle of the step, at the mean of the states and the velocities v; returns the power of those without potential [W]. */
static double find_forces(capture *g, double t, const double *v)
{
    lw_dynamics *d = g->d;
    double power = 0;
    d->eq.place_states(d->eq.context, g->mean_z);
    d->eq.forces(d->eq.context, t, g->next_q, v, g->force, &power);
    lw_mbs_touch_forces(d, v, g->force, &power);
    return power;
}

static void set_pulls(capture *g, double h)
{
    const lw_dynamics *d = g->d;
    for (int k = 0; k < g->n; k++) {
        const lw_touch *p = &d->touch->list.touch[g->at[k].touch];
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, NULL, &m);
        g->at[k].pull = h*pull_on(g, p, &m);
    }
}

/* Find the forces at the velocities after the impacts of the step, and what they change in h; *pull: the greatest change of a velocity. */
static lw_status find_pull(capture *g, double t, double h, double *pull)
{
    const lw_dynamics *d = g->d;
    *pull = 0;
    g->power = find_forces(g, t, g->after);
    for (int i = 0; i < d->n_v; i++) {
        if (!isfinite(g->force[i]))
            return LW_E_NUMERIC;
        *pull = fmax(*pull, fabs(h*g->force[i]*d->by_mass[i]));
    }
    set_pulls(g, h);
    return LW_OK;
}

/* Change of the rate of a gap that presses in half a step because bodies turn. */
static double bend(const place *p, const lw_touch_motion *m, double h) { return p->presses ? -0.5*h*m->bias : 0; }

/* Does the place approach faster than forces move bodies at rest in a step?  At a located impact (h = 0) the threshold is lower. */
static bool is_struck(const place *p, const lw_touch_motion *m, double h)
{
    return m->rate < -(h > 0 ? 3 : shallow)*(p->pull + fabs(bend(p, m, h)));
}

/* Let bodies that approach faster than bodies at rest bounce in the middle of the step, by the law of impact of located events (mbs/run/touch.c): at the
 * places that approach, then at those that approach because of these impacts.  Without restitution the step itself ends the approach; at a located
 * impact (h = 0) all closed places then take part. */
static lw_status bounce(capture *g, double t, double h)
{
    lw_dynamics *d = g->d;
    const lw_touch *touch = d->touch->list.touch;
    bool plastic = true;
    for (int k = 0; k < g->n; k++)
        plastic = plastic && !(g->at[k].shut && touch[g->at[k].touch].surface->restitution > 0);
    lw_status s = LW_OK;
    for (int pass = 0; s == LW_OK && pass < (plastic ? 1 : BOUNCES); pass++) {
        int n = 0, struck[TOGETHER_MOST];
        bool bounces = false;
        for (int k = 0; k < g->n && n < TOGETHER_MOST; k++) {
            lw_touch_motion m;
            if (!g->at[k].shut)
                continue;
            lw_touch_at(&touch[g->at[k].touch], &d->eq, d->frames, g->after, &m);
            bool hit = is_struck(&g->at[k], &m, h);
            if (hit || (plastic && h == 0))
                struck[n++] = g->at[k].touch;
            g->late = hit && h > 0 ? h : g->late;
            bounces = bounces || (hit && (h == 0 || touch[g->at[k].touch].surface->restitution > 0));
        }
        if (!bounces)
            break;
        for (int r = first_row(d); pass == 0 && r < d->n_c; r++)
            clear_row(d, r);                 /* only joints constrain the response to an impulse */
        s = pass == 0 ? lw_mbs_factor_touch(d) : LW_OK;
        if (s == LW_OK)
            s = lw_run_touch_impact(g->run, t, n, struck, g->after);
    }
    restore_rows(g);
    return s == LW_NOTHING ? LW_OPEN : s;
}

/* Keep a copy of the rows of places, since bounce and the passes of a step clear inactive rows. */
static void keep_rows(capture *g)
{
    const lw_dynamics *d = g->d;
    memcpy(g->full, lw_mbs_jac(d, first_row(d)), (size_t)((d->n_c - first_row(d))*d->row_size)*sizeof *d->jac);
}

/* Find the new velocities for a step of length h with its middle at next_q.  LW_OPEN: the passes do not converge. */
static lw_status solve_step(capture *g, double t, double h)
{
    lw_dynamics *d = g->d;
    double fastest = 0, pull = 0;
    lw_status s = lw_mbs_rows(d, t, g->next_q);
    if (s != LW_OK)
        return s;
    keep_rows(g);
    g->late = 0;
    memcpy(g->after, g->v, (size_t)d->n_v*sizeof *g->v);
    int shut = find_shut(g, 0.5*h);
    s = find_pull(g, t, h, &pull);
    if (s == LW_OK)
        s = bounce(g, t, h);
    if (s == LW_OK && memcmp(g->after, g->v, (size_t)d->n_v*sizeof *g->v) != 0)
        s = find_pull(g, t, h, &pull);
    if (s == LW_OK)
        s = lw_mbs_rate_wanted(d, t);
    if (s != LW_OK)
        return s;
    memcpy(g->wanted, d->rhs, (size_t)d->n_c*sizeof *g->wanted);
    if ((s = lw_mbs_acceleration_wanted(d, t, g->after)) != LW_OK)
        return s;
    for (int r = 0; r < first_row(d); r++)
        g->wanted[r] += 0.5*h*d->rhs[r];
    for (int i = 0; i < d->n_driven; i++) {              /* the motion of an input is known at the end of the step */
        double middle[3], end[3];
        if (lw_mbs_motion(d, i, t, middle) != LW_OK || lw_mbs_motion(d, i, t + 0.5*h, end) != LW_OK)
            return LW_E_NUMERIC;
        g->wanted[d->n_row + i] += end[1] - middle[1] - 0.5*h*middle[2];
    }
    for (int i = 0; i < d->n_v; i++)
        fastest = fmax(fastest, fabs(g->after[i]));
    for (int k = 0; k < g->n; k++) {
        place *p = &g->at[k];
        lw_touch_motion m;
        lw_touch_at(&d->touch->list.touch[p->touch], &d->eq, d->frames, g->after, &m);
        p->pressed = p->presses;
        p->closes = p->presses || is_struck(p, &m, h) ? 0 : fmin(0, -2*m.gap/h - 0.25*h*m.bias);
        p->target = is_struck(p, &m, h) ? 0 : p->presses ? bend(p, &m, h) : p->closes;
        if (p->shut && d->touch->list.touch[p->touch].state != LW_TOUCH_HELD)
            g->rest = fmax(g->rest, -m.rate*d->touch->list.touch[p->touch].surface->restitution);
        p->glide = p->presses && p->slips == 0 ? -0.5*h*m.slip_bias : 0;
    }
    bool middle = false;
    for (int pass = 0; pass < PASSES; pass++) {
        bool densely = shut <= DENSE_SOON ? pass == TOGETHER : pass == LATE && shut <= DENSE_MOST;
        s = densely ? solve_densely(g, h, shut) : LW_NOTHING;
        if (s != LW_NOTHING)
            return s == LW_OK ? note_jam(g, h, shut, pull) : s;
        s = LW_OK;
        if (!middle && closes_one(g))
            middle = true, s = aim_at_middle(g, t);
        if (s == LW_OK)
            s = solve_guess(g, h);
        restore_rows(g);
        if (s != LW_OK || revise(g, d->l, pass, (pass < HARD ? exact : allowed)*(fastest + pull)) == 0)
            return s == LW_OK ? note_jam(g, h, shut, pull) : s;
    }
    return LW_OPEN;
}

/* Project q onto the rows of the joints and out of overlaps; returns the greatest overlap before, scaled. */
static lw_status put_back(capture *g, double t, double *q, double *overlap)
{
    lw_dynamics *d = g->d;
    for (int pass = 0; pass < 12; pass++) {
        lw_status s = lw_mbs_rows(d, t, q);
        double off = 0;
        if (s != LW_OK)
            return s;
        for (int r = 0; r < d->n_row + d->n_driven; r++) {
            g->wanted[r] = -d->phi[r];
            off = fmax(off, fabs(d->phi[r]));
        }
        for (int k = 0; k < g->n; k++) {
            const place *p = &g->at[k];
            bool held = d->touch->list.touch[p->touch].state == LW_TOUCH_HELD, in = p->presses && (held || d->phi[p->row] < 0);
            g->wanted[p->row] = in ? -d->phi[p->row] : 0;
            *overlap = pass || !p->presses ? *overlap : fmax(*overlap, -d->phi[p->row]);
            off = in ? fmax(off, 1e-3*fabs(d->phi[p->row])) : off;
            if (!in)
                clear_row(d, p->row);
            if (p->rubs) {
                g->wanted[p->row + 1] = 0;
                clear_row(d, p->row + 1);
            }
        }
        if (off < 1e-13*fmax(1, fabs(q[0])) || pass == 11)
            return LW_OK;
        if ((s = lw_mbs_factor_touch(d)) != LW_OK)
            return s;
        lw_mbs_linear(d, NULL, g->wanted, d->hold, d->l_each);
        d->eq.move(d->eq.context, q, d->hold);
    }
    return LW_OK;
}

/* What the impulses of a step do at the places: mean of the rates before and behind it.  Where a place held before, and sticks on, its rates are
 * errors of the step, and no work. */
static double work_of_places(const capture *g)
{
    const lw_dynamics *d = g->d;
    double sum = 0;
    for (int k = 0; k < g->n; k++) {
        const place *p = &g->at[k];
        const lw_touch *was = &d->touch->list.touch[p->touch];
        if (was->state != LW_TOUCH_HELD)
            sum += 0.5*p->normal*(lw_mbs_row_rate(d, p->row, g->after) + lw_mbs_row_rate(d, p->row, g->next_v));
        if (p->rubs && !(was->sticks && p->slips == 0))
            sum += 0.5*p->across*(lw_mbs_row_rate(d, p->row + 1, g->after) + lw_mbs_row_rate(d, p->row + 1, g->next_v));
    }
    return sum;
}

/* One step of length h: next_q, next_v; d->a and d->l are means over it. */
static lw_status step(capture *g, double h, double *overlap)
{
    lw_dynamics *d = g->d;
    double *way = d->hold, gained = 0, motion[3];
    size_t n_v = (size_t)d->n_v;
    for (size_t i = 0; i < n_v; i++)
        way[i] = 0.5*h*g->v[i];
    memcpy(g->next_q, g->q, (size_t)d->n_q*sizeof *g->q);
    d->eq.move(d->eq.context, g->next_q, way);
    memcpy(g->next_z, g->z, (size_t)d->eq.n_z*sizeof *g->z);
    lw_status s = move_states(g, g->t, 0.5*h, g->next_q, g->v, g->next_z, g->mean_z);
    if (s == LW_OK)
        s = mean_states(g, h);
    if (s == LW_OK)
        s = solve_step(g, g->t + 0.5*h, h);
    if (s == LW_OK) {
        gained = 0.5*h*(g->power + find_forces(g, g->t + 0.5*h, g->next_v));
        s = move_states(g, g->t + 0.5*h, 0.5*h, g->next_q, g->next_v, g->next_z, NULL);
    }
    if (s != LW_OK)
        return s;
    for (int i = 0; i < d->n_c; i++)
        d->l[i] /= h;
    gained += work_of_places(g) + d->eq.kinetic(d->eq.context, g->after) - d->eq.kinetic(d->eq.context, g->v);
    for (size_t i = 0; i < n_v; i++) {
        d->a[i] = (g->next_v[i] - g->after[i])/h;
        way[i] = 0.5*h*g->next_v[i];
    }
    for (int i = 0; i < d->n_driven; i++)
        if (lw_mbs_motion(d, i, g->t + 0.5*h, motion) == LW_OK)
            gained -= h*d->l[d->n_row + i]*motion[1];
    d->eq.move(d->eq.context, g->next_q, way);
    g->work += gained;
    return put_back(g, g->t + h, g->next_q, overlap);
}

/* Has a step ended with an overlap of more than half the distance moved in it, at a place that does not press?  Example: the body in front is stopped. */
static bool overlaps_unseen(const capture *g)
{
    const lw_dynamics *d = g->d;
    const lw_touch_list *list = &d->touch->list;
    d->eq.place(d->eq.context, g->next_q);
    for (int i = 0, k = 0; i < list->n; i++) {
        while (k < g->n && g->at[k].touch < i)
            k++;
        bool presses = k < g->n && g->at[k].touch == i && g->at[k].presses;
        if (i != g->strikes && !(list->touch[i].surface->stiffness > 0) && !presses
            && lw_touch_gap(&list->touch[i], &d->eq, d->frames) < -unseen*g->part*g->size)
            return true;
    }
    return false;
}

/* Correct the length *h of a step that has ended near the impact of place g->strikes; returns whether it is to be repeated. */
static bool miss(capture *g, double *h)
{
    const lw_dynamics *d = g->d;
    const lw_touch *p = &d->touch->list.touch[g->strikes];
    lw_touch_motion m;
    d->eq.place(d->eq.context, g->next_q);
    lw_touch_at(p, &d->eq, d->frames, g->next_v, &m);
    g->hits = m.rate < 0 || m.straight < reached*g->part*g->size;       /* else it has turned back before */
    if (!(m.rate < 0) || fabs(m.straight) <= reached*g->part*g->size)
        return false;
    *h -= fmin(fmax(m.straight/m.rate, -*h), 0.5**h);
    return true;
}

/* Apply the impact at which a step of length h has ended. */
static lw_status hit(capture *g, double h, double *overlap)
{
    lw_dynamics *d = g->d;
    size_t n_v = (size_t)d->n_v;
    lw_status s = lw_mbs_rows(d, g->t, g->q);
    if (s != LW_OK || find_shut(g, 0) >= TOGETHER_MOST)
        return s;                            /* too many: the next step captures it */
    for (int k = 0; k < g->n; k++)
        g->at[k].presses = g->at[k].shut;
    s = put_back(g, g->t, g->q, overlap);
    if (s == LW_OK)
        s = lw_mbs_rows(d, g->t, g->q);
    if (s != LW_OK)
        return s;
    keep_rows(g);
    set_pulls(g, h);
    memcpy(g->after, g->v, n_v*sizeof *g->v);
    s = bounce(g, g->t, 0);
    if (s != LW_OK)
        return s == LW_OPEN ? LW_OK : s;
    g->work += d->eq.kinetic(d->eq.context, g->after) - d->eq.kinetic(d->eq.context, g->v);
    memcpy(g->v, g->after, n_v*sizeof *g->v);
    for (int k = 0; k < g->n; k++)           /* where bodies bounce off each other, their next impact is to be located, too */
        g->at[k].presses = g->at[k].presses && lw_mbs_row_rate(d, g->at[k].row, g->v) <= shallow*g->at[k].pull;
    return LW_OK;
}

static void keep_places(capture *g)
{
    memcpy(g->before, g->at, (size_t)g->n*sizeof *g->at);
    g->work_before = g->work;
}

static void restore_places(capture *g)
{
    memcpy(g->at, g->before, (size_t)g->n*sizeof *g->at);
    g->work = g->work_before;
}

/* Did velocities jump in the last step, as a place closed in it?  Then their change over its length is no acceleration. */
static bool jumped(const capture *g) { return g->late > 0 || closes_one(g); }

/* Find the accelerations at (q, v), by steps of a moment that are not taken.  The first of them put the velocities on the rows, and end what is left
 * of impacts. */
static lw_status look_around(capture *g)
{
    double *v = g->v, *next = g->next_v;
    lw_status s = LW_OK;
    keep_places(g);
    for (int pass = 0; s == LW_OK && pass < MOMENTS; pass++) {
        s = step(g, moment*(g->d->o.to - g->d->o.from), &(double){ 0 });
        if (s != LW_OK || (pass > 0 && !jumped(g)))
            break;
        memcpy(g->still, g->next_v, (size_t)g->d->n_v*sizeof *g->still);
        g->v = g->still;
    }
    g->v = v, g->next_v = next;
    restore_places(g);
    return s == LW_OPEN ? LW_OK : s;
}

/* ---- the run ------------------------------------------------------------------------------------------------- */

static void note_impacts(capture *g, double t)
{
    lw_dynamics *d = g->d;
    lw_dynamics_report *r = g->run->r;
    for (int k = 0; k < g->n; k++) {
        lw_touch *p = &d->touch->list.touch[g->at[k].touch];
        bool held = p->state == LW_TOUCH_HELD;
        if (g->at[k].presses != held) {
            bool stop = p->kind == LW_TOUCH_STOP;
            if (r->n_event < LW_REPORT_EVENT_MAX)
                r->event[r->n_event++] = (lw_run_event){ t, stop ? p->owner : -1, p->sign < 0, !held,
                                                         lw_mbs_row_rate(d, g->at[k].row, g->v)*d->s.unit,
                                                         stop ? d->model->linkage.joint[p->owner].name
                                                              : lw_touch_name(d->model, p), !stop };
            r->n_event_seen++;
        }
        p->state = g->at[k].presses ? LW_TOUCH_HELD : LW_TOUCH_APART;
        p->sticks = g->at[k].presses && g->at[k].rubs && g->at[k].slips == 0;
        p->slips = g->at[k].presses && g->at[k].rubs ? g->at[k].slips : 0;
    }
}

static double *fill_state(const capture *g, double *y)
{
    const lw_dynamics *d = g->d;
    memcpy(y, g->q, (size_t)d->n_q*sizeof *y);
    memcpy(y + d->n_q, g->v, (size_t)d->n_v*sizeof *y);
    y[d->n_q + d->n_v] = g->work;
    memcpy(y + lw_run_states(g->run), g->z, (size_t)d->eq.n_z*sizeof *y);
    return y;
}

/* Velocities satisfy the rows of the middle of the step; for the sample, project them onto the rows at its end. */
static lw_status show(capture *g, double *y)
{
    lw_dynamics *d = g->d;
    fill_state(g, y);
    lw_status s = lw_mbs_rows(d, g->t, g->q);
    for (int r = d->n_row + d->n_driven; r < d->n_c; r++)
        clear_row(d, r);
    if (s == LW_OK)
        s = lw_mbs_factor_touch(d);
    if (s == LW_OK)
        s = lw_mbs_project_v(d, g->t, y + d->n_q);
    return s == LW_OK ? lw_run_show_solved(g->run, lw_run_time(d, g->run->next), y) : s;      /* a kink at this time is passed already */
}

static lw_status say_unsolved(const capture *g)
{
    return lw_error_set(g->run->e, LW_E_NUMERIC, "at t = %.9g s no forces of contact were found that satisfy all conditions; give the "
                        "contacts a \"stiffness\"", g->t);
}

/* The latest end of a step from t: the next row, or a time before it where a function of time changes fast.  If such a time differs from the row by
 * rounding only, it is the row: a step between them would be so short that its forces are noise. */
static double step_end(lw_run *run, double t)
{
    double row = lw_run_time(run->d, run->next), end = lw_run_near(run, t);
    return row - end < 1e-9*(row - t) && !lw_run_at_kink(run, end) ? row : fmin(row, end);
}

/* The longest step from here.  Where functions of time limit it, the limit does not depend on the tolerance.  The run takes a part of it, so that the steps of
 * the coarser run beside it can be longer: with equal steps the difference of the two runs would not show the error. */
static double longest_step(const capture *g)
{
    const lw_dynamics_options *o = &g->d->o;
    double spacing = g->run->timed.spacing, most = spacing > 0 ? spacing : INFINITY;
    return fmin(g->part*(o->to - o->from), 0.35*fmax(1, o->coarse)*most);
}

static lw_status run_steps(capture *g, double *y)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    lw_touch_list *list = &d->touch->list;
    double part = g->part, h = INFINITY;
    lw_status s = LW_OK;
    while (s == LW_OK && run->next <= d->o.intervals) {
        bool missing = false;
        double speed = look(g, 0, 0, &missing, NULL), pull = 0, end = step_end(run, g->t);
        for (int i = 0; i < d->n_v; i++)
            pull = fmax(pull, fabs(d->a[i])*(i%3 == 2 ? g->arm[i/3] : 1));
        h = fmin(longest_step(g), fmin(2*h, part*g->size/fmax(speed, sqrt(fmax(part, slow)*g->size*pull))));
        h = compliant_step(g, h);
        if ((s = stable_step(g, &h)) != LW_OK)
            return s;
        missing = false;
        double overlap = 0, left = end - g->t, whole = left/ceil(left/h - 1e-9);     /* a short last step would have wrong mean forces */
        ahead_of to = { .h = whole, .first = INFINITY };
        look(g, h, speed, &missing, &to);
        if (missing)
            s = choose_places(g, ahead*h, speed);
        bool locates = to.n <= STRUCK_MOST && to.first < whole && (to.first > soonest*whole || !g->hits);
        whole = locates ? to.first : whole;
        g->strikes = locates ? to.strikes : -1;
        g->hits = g->strikes >= 0;
        s = s == LW_OK ? LW_OPEN : s;
        keep_places(g);
        for (int k = 0, corrected = 0; s == LW_OPEN && k < HALVINGS; k++) {
            bool last = g->t + whole > end - 1e-9*whole;
            s = step(g, last ? end - g->t : whole, &overlap);
            if (s == LW_OK && g->strikes >= 0 && corrected < CORRECTIONS && miss(g, &whole)) {
                locates = g->t + whole <= end;       /* else later, in another step */
                whole = fmin(whole, end - g->t);
                corrected++, k--;
                s = LW_OPEN;
            } else if (s == LW_OPEN || (s == LW_OK && k < HALVINGS - 1 && overlaps_unseen(g))) {
                whole *= 0.5;
                locates = false;
                s = LW_OPEN;
            }
            if (s == LW_OPEN) {
                g->strikes = locates ? g->strikes : -1;
                g->hits = g->strikes >= 0;
                run->r->refused++;
                restore_places(g);
                continue;
            }
            h = last || locates ? h : whole;
            note_impacts(g, g->t);
            g->t = last ? end : g->t + whole;
        }
        g->strikes = -1;
        if (s != LW_OK)
            return s == LW_OPEN ? say_unsolved(g) : s;
        bool jumps = jumped(g);
        double *q = g->q, *v = g->v, *z = g->z;
        g->q = g->next_q, g->next_q = q;
        g->z = g->next_z, g->next_z = z;
        g->v = g->next_v, g->next_v = v;
        run->r->t = g->t;
        run->r->steps++;
        run->r->captured_step = fmax(run->r->captured_step, whole);
        run->r->captured_late = fmax(run->r->captured_late, g->late);
        d->eq.place(d->eq.context, g->q);
        for (int i = 0; i < list->n; i++)
            if (list->touch[i].state == LW_TOUCH_APART)
                lw_touch_choose_side(&list->touch[i], d->frames, false, g->part*g->size);       /* an overlap of this size is allowed */
        s = lw_run_touch_crossed(run, g->t, g->part*g->size);
        lw_run_watch(run, fill_state(g, y));
        if (s == LW_OK && lw_run_at_kink(run, g->t))
            s = lw_run_pass_kink(run, &g->t, NULL, NULL);
        if (s == LW_OK && g->t >= lw_run_time(d, run->next)) {
            s = show(g, y);
            run->next++;
        }
        if (s == LW_OK && g->hits)
            s = hit(g, whole, &overlap);
        if (s == LW_OK && (g->hits || jumps))
            s = look_around(g);
        run->r->overlap = fmax(run->r->overlap, overlap*d->s.unit);
        run->r->captured_rest = g->rest*d->s.unit;
        if (s == LW_OK)
            s = lw_run_limits(run, g->t, 0);
    }
    return s;
}

/* Set arm (per body) to the extents of the bodies that touch, from the centre to the farthest disc, scaled, and for others to 1; returns the least one. */
static double find_arms(const lw_dynamics *d, double *arm)
{
    const lw_touch_list *list = &d->touch->list;
    double least = INFINITY;
    for (int i = 0; i < d->n_q/3; i++)
        arm[i] = 0;
    for (int i = 0; i < list->n; i++) {
        const lw_touch *p = &list->touch[i];
        for (int end = 0; p->kind <= LW_TOUCH_DISCS && end <= (p->kind == LW_TOUCH_DISCS); end++)
            if (p->body[end] >= 0)
                arm[p->body[end]] = fmax(arm[p->body[end]], lw_v2_norm(p->arm[end]) + p->radius[end]);
    }
    for (int i = 0; i < d->n_q/3; i++) {
        least = arm[i] > 0 ? fmin(least, arm[i]) : least;
        arm[i] = arm[i] > 0 ? arm[i] : 1;
    }
    return least < INFINITY ? least : 1;
}

/* The moment at the start may stop slips by friction, as where a brake jams.  They still slip at the start. */
static void forget_slips(capture *g)
{
    lw_dynamics *d = g->d;
    d->eq.place(d->eq.context, g->q);
    for (int k = 0; k < g->n; k++) {
        lw_touch *p = &d->touch->list.touch[g->at[k].touch];
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, g->v, &m);
        p->sticks = p->sticks && fabs(m.slip) <= exact;
    }
}

static lw_status run_capture(lw_run *run)
{
    lw_dynamics *d = run->d;
    size_t n_q = (size_t)d->n_q, n_v = (size_t)d->n_v, rows = (size_t)d->n_c + (size_t)d->touch->row_max;
    capture g = { .run = run, .d = d, .t = d->o.from, .n_kept = d->n_kept,
                  .part = fmax(1, d->o.coarse)*fmin(fmax(pow(d->o.relative, 0.2), finest), coarsest) };
    size_t n_z = (size_t)d->eq.n_z;
    double *memory = calloc(6*n_z + 3*n_q + 7*n_v + rows + 2*rows*(size_t)d->row_size + (size_t)run->n + 4, sizeof *memory), *p = memory, *y;
    g.at = calloc(2*(size_t)d->touch->list.n + 2, sizeof *g.at);
    g.before = g.at + d->touch->list.n + 1;
    g.strikes = -1;
    g.kept = calloc((size_t)d->n_kept + 1, sizeof *g.kept);
    lw_status s = memory && g.at && g.kept ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        g.q = p, p += n_q, g.next_q = p, p += n_q, g.v = p, p += n_v, g.after = p, p += n_v, g.next_v = p, p += n_v;
        g.momentum = p, p += n_v, g.still = p, p += n_v, g.stiffest = p, p += n_v, g.force = p, p += n_v, g.wanted = p, p += rows, g.arm = p, p += n_q;
        g.full = p, p += rows*(size_t)d->row_size, g.push = p, p += rows*(size_t)d->row_size;
        g.z = p, p += n_z, g.next_z = p, p += n_z, g.mean_z = p, p += n_z, g.try_z = p, p += n_z, g.rate = p, p += n_z, g.other = p, p += n_z, y = p;
        g.size = find_arms(d, g.arm);
        memcpy(g.kept, d->kept, (size_t)d->n_kept*sizeof *g.kept);
        lw_dynamics_start(d, g.q, g.v);
        if (n_z)
            memcpy(g.z, d->start_z, n_z*sizeof *g.z);
        d->touch->events = false;            /* compliant places press by their depth alone */
        fill_state(&g, y);
        d->eq.place(d->eq.context, g.q);
        s = lw_run_touch_choose_sides(run);
        if (s == LW_OK && !d->touch->goes_on)
            s = lw_run_touch_check(run, g.t);
        d->touch->captured = true;
        for (int i = 0; i < d->touch->list.n; i++)
            d->touch->list.touch[i].loose = g.part*g.size;
        if (s == LW_OK)
            s = choose_places(&g, 0, 0);
        if (s == LW_OK)                      /* a moment, for accelerations and forces at the start */
            s = step(&g, moment*(d->o.to - d->o.from), &(double){ 0 });
        s = s == LW_OPEN ? say_unsolved(&g) : s;
        g.work = 0;
        note_impacts(&g, g.t);
        forget_slips(&g);
        if (s == LW_OK)
            s = lw_run_begin_solved(run, y);
        if (s == LW_OK)
            s = run_steps(&g, y);
        d->touch->captured = false;
        for (int i = 0; i < d->touch->list.n; i++)
            d->touch->list.touch[i].loose = 0;
    }
    free_pattern(&g);
    free(g.at);
    free(g.kept);
    free(memory);
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    if (!d->touch)
        return lw_formulation_say(r, LW_E_KIND, 0, "it is for contacts and ropes");
    int rigid = 0;
    for (int i = 0; i < d->touch->list.n; i++) {
        const lw_surface *p = d->touch->list.touch[i].surface;
        rigid += !(p->stiffness > 0);
        if (p->stiffness > 0 && p->friction > 0 && !(p->friction_speed > 0))
            return lw_formulation_say(r, LW_E_KIND, 0, "it knows friction of compliant contacts with a \"friction_speed\" only");
    }
    if (!asked && (rigid == 0 || d->eq.n_z))
        return lw_formulation_say(r, LW_E_KIND, 0, "without rigid contacts, and with first-order states, index1 is of higher order");
    if (d->space || d->elastic || d->n_friction || d->has_zero_mass)
        return lw_formulation_say(r, LW_E_KIND, 0, d->space ? "it knows no spatial models" : d->elastic ? "it knows no elastic links" : d->n_friction
                                  ? "it knows no friction of joints" : "every link needs a mass and an inertia");
    if (!asked && d->model->n_contact < LEAST_CONTACTS)
        return lw_formulation_say(r, LW_E_KIND, 0, "few contacts: index1 locates each event");
    return lw_formulation_say(r, LW_OK, d->n_v + d->n_c, asked ? "asked for" : "many contacts: they are captured in steps, "
                              "instead of locating each event (index1)");
}

const lw_formulation_row lw_formulation_capture = { able, run_capture };
