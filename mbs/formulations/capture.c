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
 * the last step, and corrected by repeating the step.  After an impact, a very short step that is not taken gives the accelerations.  All places that are closed there take
 * part in the impact, as at a located event.  So the times of impacts are of second order, too.
 * A step ends where a slip ends, too: friction keeps its sense in a step, and the velocity would be off in proportion to h if the slip turned back.
 * Impacts that follow each other within a part of a step, or many impacts in one step, are captured in its middle: their times, and overlaps, are of
 * first order.  The report gives the longest step that captured an impact.
 *
 * Forces are those in the middle of the step, which is explicit: stiff springs, dampers and oil limit its length. */
#include "base/real.h"
#include "mbs/formulations/capture_internal.h"
#include "mbs/formulations/formulations_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/sparse_lu.h"
#include "mbs/dynamics/touch_internal.h"

static const double finest = 1e-4, coarsest = 0.1;       /* distance that a body moves in a step, over its size */
static const double slow = 0.1;              /* below this fraction, steps of slow bodies are proportional to it, as the duration of a low bounce is */
static const double ahead = 6;               /* places that are at most this many steps away are in the pattern */
static const double turns = 0.25;            /* rates of gaps change by this fraction of the greatest speed until then */
static const double resolved = 0.1;          /* step over the time constant of a compliant place */
static const double stable = 2.5;            /* square of the step times the greatest frequency of other forces, over the distance moved in a step */
static const double nudge = 1e-6;            /* way that shows how forces change, scaled */
static const double moment = 1e-8;           /* step that gives the forces at the start, over the length of the run */
static const double soonest = 1/16.0;        /* an impact after less than this fraction of a step is captured in it */
static const double ended = 1e-3;            /* so is a slip that ends after less than this fraction */
enum { MOMENTS = 3 };                        /* that give the accelerations after an impact */
enum { CORRECTIONS = 4 };                    /* of the length of a step that ends at an impact */
enum { SOON_MOST = 2 };                     /* such impacts are located, if no more than this follow each other */
enum { STRUCK_MOST = 12 };                   /* impacts at more places than this in a step are captured */
enum { ITERATIONS = 30 };                    /* for the greatest frequency, in a step */
enum { LEAST_CONTACTS = 24, HALVINGS = 8 };

/* ---- the length of a step ------------------------------------------------------------------------------- */

/* The longest step in which compliant places that press, or may do so within a step `h`, are well resolved: a part of the
 * period of the bodies there on the stiffness of the place. */
static double compliant_step(lw_capture *g, double h)
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
static lw_status forces_behind(lw_capture *g, double h, const double *q, const double *v, double *z, double *force)
{
    const lw_equations *eq = &g->d->eq;
    double power = 0;
    memcpy(z, g->z, (size_t)eq->n_z*sizeof *z);
    lw_status s = lw_capture_move_states(g, g->t, h, q, v, z, NULL);
    eq->place(eq->context, q);
    eq->place_states(eq->context, z);
    eq->forces(eq->context, g->t, q, v, force, &power);
    return s;
}

/* Shorten the step *h to one that stiff springs, dampers, and states such as the pressure of oil leave stable: its forces are those of a posture and velocities
 * foretold from the old ones.  With K and C their derivatives by places and velocities, the greatest eigenvalue of (h^2 K + h C)/M tells, by power
 * iteration, whose vector g->stiffest is kept from step to step. */
static lw_status stable_step(lw_capture *g, double *h)
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

/* Time until the gap has decreased by `way`, from its rate and the accelerations of the last step; INFINITY: never.  *rate: that of the gap then. */
static double closes_in(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m, double way, double *rate)
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

/* Note the impact of a place.  Very slow ones, as of bodies at rest, are left to be captured if they overlap by a small fraction of the distance moved in a
 * step at most. */
static void look_ahead(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m, ahead_of *to)
{
    double way = g->part*g->size, rate, later, in = closes_in(g, p, m, m->straight, &rate), along = m->place + m->place_rate*in;
    bool on = p->kind != LW_TOUCH_FACE || !(p->length < INFINITY) || (along >= 0 && along <= p->length);
    if (!((m->straight > 0 || m->rate > 0) && in <= to->h) || !on || lw_capture_slides_off(g, p, m, in))
        return;
    bool overlaps = m->straight > lw_capture_closed*way && closes_in(g, p, m, m->straight + lw_capture_shallow*way, &later) < to->h;
    if (!(rate < -lw_capture_shallow*to->h*lw_capture_pull_on(g, p, m) || overlaps))
        return;
    note_ahead(to, in, (int)(p - g->d->touch->list.touch));
}

/* Note the end of the slip of a place that presses, by the accelerations of the last step: the friction of a step keeps its sense. */
static void look_at_slip(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m, ahead_of *to)
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

/* Greatest speed of two bodies at points of both, or as far outside as they are large, scaled.  A disc that is far away has a slip as if the other body
 * reached to it. */
static double fastest_at(const lw_capture *g, const lw_touch *p)
{
    lw_vec2 apart = lw_v2(0, 0);
    double turns_with = 0;
    if (p->kind > LW_TOUCH_DISCS)
        return INFINITY;
    for (int k = 0; k < 2; k++)
        if (p->body[k] >= 0) {
            const double *v = g->v + 3*p->body[k];
            apart = lw_v2_add(apart, lw_v2_scale(lw_v2(v[0], v[1]), k ? -1 : 1));
            turns_with += 2*fabs(v[2])*g->arm[p->body[k]];
        }
    return lw_v2_norm(apart) + turns_with;
}

/* Return the speed of the fastest place, scaled.  *missing becomes true if a place outside the pattern may close within two steps of length h, at this
 * speed; *to: the impacts ahead, unless NULL. */
static double look(lw_capture *g, double h, double speed, bool *missing, ahead_of *to)
{
    lw_touch_list *list = &g->d->touch->list;
    double fastest = 0;
    int k = 0;
    g->d->eq.place(g->d->eq.context, g->q);
    for (int i = 0; i < list->n; i++) {
        lw_touch_motion m;
        lw_touch_at(&list->touch[i], &g->d->eq, g->d->frames, g->v, &m);
        fastest = fmax(fastest, fmin(hypot(m.rate, m.slip), fastest_at(g, &list->touch[i])));
        if (list->touch[i].surface->stiffness > 0)
            continue;
        while (k < g->n && g->at[k].touch < i)
            k++;
        bool in = k < g->n && g->at[k].touch == i;
        *missing = *missing || (!in && comes_near(&m, 2*h, speed, lw_capture_closed*g->part*g->size));
        if (to && !(in && g->at[k].presses))
            look_ahead(g, &list->touch[i], &m, to);
        else if (to && g->at[k].slips != 0)
            look_at_slip(g, &list->touch[i], &m, to);
    }
    return fastest;
}

static void free_pattern(lw_capture *g)
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
static lw_status make_pattern(lw_capture *g)
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
static lw_status choose_places(lw_capture *g, double in, double speed)
{
    lw_dynamics *d = g->d;
    struct lw_touching *w = d->touch;
    int n = 0, old = g->n, k = 0;
    lw_capture_place *was = malloc(((size_t)old + 1)*sizeof *was);
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
        lw_capture_place *to = &g->at[n++];
        *to = known ? was[k] : (lw_capture_place){ .touch = i, .mu = p->surface->friction };
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

/* ---- the run ------------------------------------------------------------------------------------------------- */

static void keep_places(lw_capture *g)
{
    memcpy(g->before, g->at, (size_t)g->n*sizeof *g->at);
    g->work_before = g->work;
}

static void restore_places(lw_capture *g)
{
    memcpy(g->at, g->before, (size_t)g->n*sizeof *g->at);
    g->work = g->work_before;
}

/* Did velocities jump in the last step, as a place closed in it?  Then their change over its length is no acceleration. */
static bool jumped(const lw_capture *g) { return g->late > 0 || lw_capture_closes_one(g); }

/* Find the accelerations at (q, v), by very short steps that are not taken.  The first of them put the velocities on the rows, and end what is left
 * of impacts. */
static lw_status look_around(lw_capture *g)
{
    double *v = g->v, *next = g->next_v;
    lw_status s = LW_OK;
    keep_places(g);
    for (int pass = 0; s == LW_OK && pass < MOMENTS; pass++) {
        s = lw_capture_step(g, moment*(g->d->o.to - g->d->o.from), &(double){ 0 });
        if (s != LW_OK || (pass > 0 && !jumped(g)))
            break;
        memcpy(g->still, g->next_v, (size_t)g->d->n_v*sizeof *g->still);
        g->v = g->still;
    }
    g->v = v, g->next_v = next;
    restore_places(g);
    return s == LW_OPEN ? LW_OK : s;
}

static void note_impacts(lw_capture *g, double t)
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

static double *fill_state(const lw_capture *g, double *y)
{
    const lw_dynamics *d = g->d;
    memcpy(y, g->q, (size_t)d->n_q*sizeof *y);
    memcpy(y + d->n_q, g->v, (size_t)d->n_v*sizeof *y);
    y[d->n_q + d->n_v] = g->work;
    memcpy(y + lw_run_states(g->run), g->z, (size_t)d->eq.n_z*sizeof *y);
    return y;
}

/* Velocities satisfy the rows of the middle of the step; for the sample, project them onto the rows at its end. */
static lw_status show(lw_capture *g, double *y)
{
    lw_dynamics *d = g->d;
    fill_state(g, y);
    lw_status s = lw_mbs_rows(d, g->t, g->q);
    for (int r = d->n_row + d->n_driven; r < d->n_c; r++)
        lw_capture_clear_row(d, r);
    if (s == LW_OK)
        s = lw_mbs_factor_touch(d);
    if (s == LW_OK)
        s = lw_mbs_project_v(d, g->t, y + d->n_q);
    return s == LW_OK ? lw_run_show_solved(g->run, lw_run_time(d, g->run->next), y) : s;      /* a kink at this time is passed already */
}

static lw_status say_unsolved(const lw_capture *g)
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
static double longest_step(const lw_capture *g)
{
    const lw_dynamics_options *o = &g->d->o;
    double spacing = g->run->timed.spacing, most = spacing > 0 ? spacing : INFINITY;
    return fmin(g->part*(o->to - o->from), 0.35*fmax(1, o->coarse)*most);
}

static lw_status run_steps(lw_capture *g, double *y)
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
        bool soon = g->hits && to.first <= soonest*whole, locates = to.n <= STRUCK_MOST && to.first < whole && !(soon && g->soon >= SOON_MOST);
        g->soon = soon && locates ? g->soon + 1 : 0;
        whole = locates ? to.first : whole;
        g->strikes = locates ? to.strikes : -1;
        g->hits = g->strikes >= 0;
        s = s == LW_OK ? LW_OPEN : s;
        keep_places(g);
        for (int k = 0, corrected = 0; s == LW_OPEN && k < HALVINGS; k++) {
            bool last = g->t + whole > end - 1e-9*whole;
            s = lw_capture_step(g, last ? end - g->t : whole, &overlap);
            if (s == LW_OK && g->strikes >= 0 && corrected < CORRECTIONS && lw_capture_miss(g, &whole)) {
                locates = g->t + whole <= end;       /* else later, in another step */
                whole = fmin(whole, end - g->t);
                corrected++, k--;
                s = LW_OPEN;
            } else if (s == LW_OPEN || (s == LW_OK && k < HALVINGS - 1 && lw_capture_overlaps_unseen(g))) {
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
            s = lw_capture_hit(g, whole, &overlap);
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
static void forget_slips(lw_capture *g)
{
    lw_dynamics *d = g->d;
    d->eq.place(d->eq.context, g->q);
    for (int k = 0; k < g->n; k++) {
        lw_touch *p = &d->touch->list.touch[g->at[k].touch];
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, g->v, &m);
        p->sticks = p->sticks && fabs(m.slip) <= lw_capture_exact;
    }
}

static lw_status run_capture(lw_run *run)
{
    lw_dynamics *d = run->d;
    size_t n_q = (size_t)d->n_q, n_v = (size_t)d->n_v, rows = (size_t)d->n_c + (size_t)d->touch->row_max;
    lw_capture g = { .run = run, .d = d, .t = d->o.from, .n_kept = d->n_kept,
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
            s = lw_capture_step(&g, moment*(d->o.to - d->o.from), &(double){ 0 });
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
