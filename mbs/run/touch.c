/* mbs/run/touch.c - contact, ropes and rigid stops during a run: rest, stick, slip, departure.
 *
 * Between events the states of all places are fixed and the motion is smooth.  At an event a gap closes, a contact force
 * becomes tensile, friction no longer holds a place that sticks, a slip ends, or a disc leaves a face over its end.
 * Each event decides the states of all closed places together, after the impacts (mbs/run/touch_impact.c).
 *
 * The accelerations after the event and the forces satisfy the same conditions (mbs/equations/complementarity.h);
 * they decide which places are held, stick or slip.  If there are several solutions, the method takes the first one that
 * it finds, starting without contact forces.  If there is none (Painleve 1895), friction stops slips at once, by impulses
 * at places that do not approach. */
#include "base/real.h"
#include "mbs/run/closed_internal.h"

#include <stdlib.h>
#include <string.h>

static const double missed = 1e-9;           /* a gap below minus this: its closure was missed, scaled          */
static const double late = 1e-14;            /* an event is located where the gap passes minus this, scaled     */
/* Rates of gaps below this times a speed count as 0.  The speed is the greatest velocity, or the speed that
 * the free accelerations reach over the size of the linkage. */
static const double still = 1e-12;
static const double rounded = 1e-6;          /* slips that may be rounding errors, over the greatest velocity */
static const double least_share = 1e-10;     /* pivot of a row that depends on others, over its diagonal       */
static const double undetermined = 2e-6;     /* friction equations below this determinant are not solved       */
static const double resolved_turn = 0.4;     /* angle of a body in a step while one of its discs may touch [rad] */
enum { STALLED_MOST = 5000 };

/* ---- events -------------------------------------------------------------------------------------------- */

enum { GAP, PULL, STICK, SLIP, END, COMPLIANT, DETERMINANT };

static double pressed_force(const lw_dynamics *d, const lw_touch *p, const lw_touch_motion *m)
{
    return lw_touch_force(p->surface, d->s.unit, -m->gap, -m->rate)*d->s.unit;
}

static void least(double *g, double value) { *g = fmin(*g, value); }

lw_status lw_run_touch_events(void *context, double t, const double *y, double *g)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    struct lw_touching *w = d->touch;
    const double *v = y + d->n_q;
    for (int i = 0; i < LW_TOUCH_EVENTS; i++)
        g[i] = 1;
    if (run->kinks)
        g[LW_TOUCH_EVENTS] = lw_run_kink_ahead(run, t, y);
    if (w->n_row > 0) {
        d->eq.place_states(d->eq.context, y + lw_run_states(run));
        lw_status s = lw_mbs_accelerate(d, t, y, v, d->a, d->l, NULL);
        if (s != LW_OK)
            return s;
    }
    w->sense = w->sense != 0 ? w->sense : w->determinant < 0 ? -1 : 1;
    if (w->n_slip > 0)                           /* relative to its sign at the last event, since it may cross 0 within a step */
        g[DETERMINANT] = w->sense*w->determinant - undetermined;
    const double *l = d->l + d->n_c - w->n_row;
    d->eq.place(d->eq.context, y);
    for (int k = 0; k < w->n_row; k++)
        if (!w->row[k].tangent) {
            double force = w->list.touch[w->row[k].touch].force = -l[k];
            least(&g[PULL], fmin(w->n_redundant ? INFINITY : force + w->least_force, w->most_force - force));
        }
    if (w->n_redundant)                          /* one function for pull and stick: at the limit a second one would jump and could not be located */
        least(&g[STICK], lw_mbs_touch_share(d, v, d->l));
    for (int k = 0; k < w->n_row && !w->n_redundant; k++) {
        lw_touch *p = &w->list.touch[w->row[k].touch];
        if (!w->row[k].tangent)
            continue;
        p->yields = true;
        lw_touch_motion m;
        double normal = p->force;
        if (p->state == LW_TOUCH_PRESSED) {
            lw_touch_at(p, &d->eq, d->frames, v, &m);
            normal = pressed_force(d, p, &m);
        }
        least(&g[STICK], p->surface->friction*normal - fabs(l[k]) + w->least_force);
    }
    for (int i = 0; i < w->list.n; i++) {
        const lw_touch *p = &w->list.touch[i];
        bool compliant = p->surface->stiffness > 0;
        if (compliant && !w->events)
            continue;
        lw_touch_motion m;
        if (p->state == LW_TOUCH_HELD || p->slips != 0)
            lw_touch_at(p, &d->eq, d->frames, v, &m);
        else
            m.gap = lw_touch_gap(p, &d->eq, d->frames);
        if (p->state == LW_TOUCH_APART)
            least(&g[compliant ? COMPLIANT : GAP], m.gap + late + p->passed);
        else if (p->state == LW_TOUCH_PASSIVE)
            least(&g[GAP], m.gap + LW_TOUCH_CLOSED + p->passed);
        else if (p->state == LW_TOUCH_PRESSED)
            least(&g[COMPLIANT], -m.gap + late);
        if (p->slips != 0)
            least(&g[SLIP], p->slips*m.slip + late);
        if (p->state == LW_TOUCH_HELD && p->kind == LW_TOUCH_FACE && isfinite(p->length))
            least(&g[END], fmin(m.place, p->length - m.place) + LW_TOUCH_END);
    }
    return LW_OK;
}

lw_status lw_run_touch_accept(lw_run *run, double t, const double *y)
{
    lw_dynamics *d = run->d;
    d->eq.place(d->eq.context, y);
    for (int i = 0; i < d->touch->list.n; i++) {
        lw_touch *p = &d->touch->list.touch[i];
        bool rigid_apart = p->state == LW_TOUCH_APART && lw_touch_is_rigid(p);
        if (rigid_apart || p->state == LW_TOUCH_PASSIVE) {
            double gap = lw_touch_gap(p, &d->eq, d->frames);
            if (gap + p->passed < -missed)
                return lw_error_set(run->e, LW_E_NUMERIC, "contact \"%s\" was closed before t = %.9g s without being seen; "
                                    "ask for a smaller tolerance", lw_touch_name(d->model, p), t);
            bool open = gap > LW_TOUCH_CLOSED;
            p->state = p->state == LW_TOUCH_PASSIVE && open ? LW_TOUCH_APART : p->state;
            p->passed = open ? 0 : p->passed;            /* the next closure is where the gap is 0 again */
        }
        if (p->state == LW_TOUCH_APART)
            lw_touch_choose_side(p, d->frames, false, LW_TOUCH_END);
    }
    return lw_run_touch_crossed(run, t, lw_touch_overlap);
}

lw_status lw_run_touch_crossed(lw_run *run, double t, double by)
{
    const lw_dynamics *d = run->d;
    for (int i = 0; i < d->touch->list.n; i++)
        if (lw_touch_is_rigid(&d->touch->list.touch[i]) && lw_touch_crosses(&d->touch->list.touch[i], d->frames, by))
            return lw_error_set(run->e, LW_E_NUMERIC, "\"%s\": a corner has passed the other shape unseen before t = %.9g s; "
                                "sharp corners that meet end on need round ends, as those of a segment with a \"radius\"",
                                lw_touch_name(d->model, &d->touch->list.touch[i]), t);
    return LW_OK;
}

/* Time in which a disc with this speed and acceleration covers the distance `way`. */
static double time_over(double way, double speed, double pull)
{
    double root = speed + sqrt(speed*speed + 2*pull*way);
    return way < INFINITY && root > 0 ? 2*way/root : INFINITY;
}

/* Events are detected at four points of a step.  Between two of these points a disc must not pass through a thin body, and must not enter
 * and leave a body because its own body turns. */
double lw_run_touch_step(lw_run *run, const double *y)
{
    lw_dynamics *d = run->d;
    const double *v = y + d->n_q;
    double longest = INFINITY;
    d->eq.place(d->eq.context, y);
    for (int i = 0; i < d->touch->list.n; i++) {
        const lw_touch *p = &d->touch->list.touch[i];
        lw_touch_motion m;
        if (p->state != LW_TOUCH_APART || p->kind == LW_TOUCH_STOP)
            continue;
        lw_touch_at(p, &d->eq, d->frames, v, &m);
        double speed = hypot(m.rate, m.slip), pull = 0, turn = 0, size = lw_touch_size(p, &m);
        for (int end = 0; end < 2; end++) {
            const int b = 3*p->body[end];
            double lever = end ? 1 : lw_v2_norm(p->arm[0]);
            if (b < 0 || lever == 0)
                continue;
            pull += fabs(d->a[b]) + fabs(d->a[b + 1]) + fabs(d->a[b + 2]) + v[b + 2]*v[b + 2]*lever;
            turn = fmax(turn, fabs(v[b + 2]));
        }
        double arrival = time_over(0.5*fmax(m.gap, 0), speed, pull);
        longest = fmin(longest, fmin(time_over(fmax(0.5*size, 0.5*m.gap), speed, pull), fmax(arrival, resolved_turn/turn)));
    }
    return longest;
}

/* ---- forces and states -------------------------------------------------------------------------------- */

/* Find the accelerations of gaps and slips without contact forces, c->b, and the forces at compliant places. */
static lw_status find_free(lw_run *run, double t, const double *y, lw_closed *c)
{
    lw_dynamics *d = run->d;
    const double *v = y + d->n_q;
    lw_status s = lw_mbs_solve(d, t, y, v, d->a, d->l, NULL);
    for (int i = 0; s == LW_OK && i < c->m; i++) {
        const lw_touch *p = &d->touch->list.touch[c->place[i]];
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, v, &m);
        c->b[2*i] = lw_touch_row_dot(p, c->row + 12*i, d->a) + m.bias;
        c->b[2*i + 1] = lw_touch_row_dot(p, c->row + 12*i + 6, d->a) + m.slip_bias;
        c->law[i].least = lw_touch_is_rigid(p) ? 0 : pressed_force(d, p, &m);
    }
    return s;
}

static void set_laws(const lw_dynamics *d, const lw_closed *c, double speed)
{
    for (int i = 0; i < c->m; i++) {
        const lw_touch *p = &d->touch->list.touch[c->place[i]];
        double slip = c->u[2*i + 1];
        bool rubs = lw_touch_has_set_valued_friction(p);
        c->law[i].fixed = !lw_touch_is_rigid(p);
        c->law[i].friction = rubs ? p->surface->friction : 0;
        c->law[i].slips = !rubs || fabs(slip) <= fmax(lw_touch_no_slip*speed, c->slow) ? 0 : slip > 0 ? 1 : -1;
    }
}

/* Find the forces at the places at rest, whose gaps have no rate.  A bounce lower than the least height counts as rest. */
static lw_status find_forces(lw_closed *c, double tiny)
{
    for (int i = 0; i < c->m; i++)
        c->in[i] = c->law[i].fixed || fabs(c->u[2*i]) <= tiny;
    for (bool again = true; again;) {
        lw_status s = lw_closed_solve(c, c->b, c->force, c->rate);
        again = false;
        if (s != LW_OK)
            return s;
        for (int i = 0; i < c->m; i++) {
            double u = c->u[2*i], a = c->rate[2*i];
            bool low = !c->in[i] && u > 0 && a < 0 && u*u <= -2*a*LW_STOP_LEAST_BOUNCE;
            c->in[i] = c->in[i] || low;
            again = again || low;
        }
    }
    return LW_OK;
}

/* Rows of c that are independent of each other, by Cholesky's method on W. */
typedef struct independent {
    const lw_closed *c;
    double       *factor;                /* (most + 1, most) the factor of the rows                         */
    int          *taken, n, most;        /* (n) numbers of the rows in c, 2 place for a gap, + 1 for a slip */
    double        top, fastest;          /* the greatest normal force, the greatest rate of a gap or slip   */
} independent;

/* Is row k of c independent of the rows taken?  Then it becomes the next one if h->n is counted up. */
static bool take_row(independent *h, int k)
{
    const lw_closed *c = h->c;
    double *factor = h->factor;
    int *taken = h->taken, n = h->n, most = h->most;
    size_t r = 2*(size_t)c->m;
    double *to = factor + (size_t)n*(size_t)most, whole = c->w[(size_t)k*r + (size_t)k], left = whole;
    for (int j = 0; j < n; j++) {
        const double *row = factor + (size_t)j*(size_t)most;
        double sum = c->w[(size_t)k*r + (size_t)taken[j]];
        for (int i = 0; i < j; i++)
            sum -= to[i]*row[i];
        to[j] = sum/row[j];
        left -= to[j]*to[j];
    }
    if (!(left > least_share*whole))
        return false;
    to[n] = sqrt(left);
    taken[n] = k;
    return true;
}

/* Anchor a place that begins to stick where it is now; the frames are those of the event. */
static void set_anchor(const lw_dynamics *d, lw_touch *p)
{
    lw_touch_motion m;
    lw_touch_at(p, &d->eq, d->frames, NULL, &m);
    p->anchor_angle = atan2(m.normal.y, m.normal.x);
    lw_touch_at(p, &d->eq, d->frames, NULL, &m);
    p->anchor = m.path;
}

/* Express the row that take_row refused as a sum of the rows taken: its factors x (n). */
static const double *find_shares(const independent *h)
{
    const double *factor = h->factor;
    int n = h->n, most = h->most;
    const double *left = factor + (size_t)n*(size_t)most;        /* forward substitution is done already */
    double *x = h->c->sub;                                       /* free at this point */
    for (int i = n - 1; i >= 0; i--) {
        x[i] = left[i];
        for (int j = i + 1; j < n; j++)
            x[i] -= factor[(size_t)j*(size_t)most + (size_t)i]*x[j];
        x[i] /= factor[(size_t)i*(size_t)most + (size_t)i];
    }
    return x;
}

/* Does the row that take_row refused depend on the normal force of a place that slips? */
static bool shares_with_slip(const struct lw_touching *w, const independent *h)
{
    const double *x = find_shares(h);
    bool shares = false;
    for (int i = 0; i < h->n; i++)
        shares = shares || (h->taken[i]%2 == 0 && fabs(x[i]) > 1e-9 && w->list.touch[h->c->place[h->taken[i]/2]].slips != 0);
    return shares;
}

/* Friction at place i per unit of its normal force if it is at its limit, else 0.  Without a normal force it counts as at its limit. */
static double friction_at_limit(const lw_closed *c, int i)
{
    double mu = c->law[i].friction, across = c->force[2*i + 1], sense = across != 0 ? across : -c->rate[2*i + 1];
    if (c->law[i].slips != 0)
        return -c->law[i].slips*mu;
    return fabs(across) < mu*c->force[2*i]*(1 - 1e-9) ? 0 : sense > 0 ? mu : sense < 0 ? -mu : 0;
}

/* Place `own`, whose row depends on the rows taken, can take over a part of their normal forces.  Does friction then change the motion? */
static bool moves_otherwise(const independent *h, int own)
{
    const lw_closed *c = h->c;
    const int *taken = h->taken, n = h->n;
    const double *x = find_shares(h);
    double *f = c->sub + n, change = 0, size = 0;
    size_t r = 2*(size_t)c->m;
    for (int a = 0; a <= n; a++) {
        int i = a < n ? taken[a]/2 : own;
        f[a] = (a < n ? -x[a] : 1)*friction_at_limit(c, i);
        for (int b = 0; b <= a; b++) {
            int j = b < n ? taken[b]/2 : own;
            double part = (a == b ? 1 : 2)*f[a]*f[b]*c->w[(2*(size_t)i + 1)*r + 2*(size_t)j + 1];
            change += part;
            size += fabs(part);
        }
    }
    return change > 1e-9*size;
}

/* Report if friction allows several motions, because a place at its limit can share its load with others in several ways.  The rows taken are all
 * normal forces.  If a place sticks, it may balance the difference, and nothing is reported. */
static void note_several_motions(lw_run *run, double t, independent *h)
{
    const lw_closed *c = h->c;
    bool slips = false, sticks = false;
    for (int i = 0; i < c->m; i++)
        if (c->in[i] && c->law[i].friction > 0) {
            bool at_limit = friction_at_limit(c, i) != 0;
            slips |= at_limit;
            sticks |= !at_limit;
        }
    for (int i = 0; slips && !sticks && !run->r->undetermined && i < c->m; i++) {
        const lw_touch *p = &run->d->touch->list.touch[c->place[i]];
        if (c->in[i] && p->state == LW_TOUCH_PASSIVE && !take_row(h, 2*i) && moves_otherwise(h, i)) {
            run->r->undetermined = lw_touch_name(run->d->model, p);
            run->r->undetermined_t = t;
        }
    }
}

/* The gap of place i is held by rows that are there already. */
static void set_redundant(struct lw_touching *w, const independent *h, int i)
{
    w->list.touch[h->c->place[i]].redundant = true;
    w->redundant[w->n_redundant++] = (lw_touch_row){ h->c->place[i], false };
}

/* Closed places that the solution leaves without a force, and whose rows depend on the rows taken, share the load of these: so equal places carry
 * equal loads.  The other places that were held and do not press are released. */
static void keep_passive(lw_run *run, double t, independent *h)
{
    const lw_closed *c = h->c;
    struct lw_touching *w = run->d->touch;
    for (int i = 0; i < c->m; i++) {
        lw_touch *p = &w->list.touch[c->place[i]];
        if (lw_touch_is_rigid(p) && p->state == LW_TOUCH_PASSIVE && !p->redundant && !take_row(h, 2*i))
            set_redundant(w, h, i);
        if (lw_touch_is_rigid(p) && p->held && p->state != LW_TOUCH_HELD && !p->redundant)
            lw_run_touch_note(run, c->place[i], t, false, 0);
    }
}

/* Hold a row of place i, which take_row took. */
static void hold(struct lw_touching *w, independent *h, int i, bool tangent)
{
    w->row[h->n++] = (lw_touch_row){ h->c->place[i], tangent };
}

static bool presses(const struct lw_touching *w, const lw_closed *c, int i) { return c->in[i] && c->force[2*i] > w->least_force; }

/* Set the state of the gap of a rigid place. */
static void set_gap(struct lw_touching *w, independent *h, int i)
{
    const lw_closed *c = h->c;
    lw_touch *p = &w->list.touch[c->place[i]];
    bool leaves = !c->in[i] || c->rate[2*i] > 1e-9*h->fastest;
    p->state = leaves ? LW_TOUCH_APART : LW_TOUCH_PASSIVE;
    p->passed = fmax(0, -c->gap[i]);
    if (!presses(w, c, i))
        return;
    bool taken = take_row(h, 2*i);
    p->state = taken ? LW_TOUCH_HELD : LW_TOUCH_PASSIVE;
    if (taken)
        hold(w, h, i, false);
    else
        set_redundant(w, h, i);
}

/* Set whether a place that bears a load slips, in the first pass, or sticks: places that press in the second one, those that could press
 * in the third. */
static void set_slip(const lw_dynamics *d, independent *h, int i, int pass, bool lets_go)
{
    struct lw_touching *w = d->touch;
    const lw_closed *c = h->c;
    lw_touch *p = &w->list.touch[c->place[i]];
    bool bears = p->state == LW_TOUCH_HELD || p->state == LW_TOUCH_PRESSED || p->redundant;
    if (!bears || !(c->law[i].friction > 0))
        return;
    double slip = c->rate[2*i + 1], across = c->force[2*i + 1], reserve = c->law[i].friction*c->force[2*i] - fabs(across);
    bool stands = fabs(slip) <= 1e-9*h->fastest, at_limit = reserve <= 1e-9*h->top, starts = lets_go && p->stuck && p->yields && at_limit && stands;
    bool holds = c->law[i].slips == 0 && !starts && (stands || !at_limit);
    if (pass == 0 && !holds && !p->redundant)
        p->slips = c->law[i].slips != 0 ? c->law[i].slips : (starts ? -across : slip) > 0 ? 1 : -1;
    if (!holds || pass != (presses(w, c, i) ? 1 : 2))
        return;
    bool taken = take_row(h, 2*i + 1);
    p->sticks = true;
    if (taken && presses(w, c, i))
        hold(w, h, i, true);
    else if (taken)
        p->sticks = false;                       /* without a normal force there is no friction to hold it */
    else if (at_limit && !p->redundant && shares_with_slip(w, h)) {
        p->sticks = false;                       /* friction is at its limit, though the place does not slip yet */
        p->slips = across > 0 ? -1 : 1;
    } else
        w->redundant[w->n_redundant++] = (lw_touch_row){ c->place[i], true };
    if (p->sticks && !p->stuck)
        set_anchor(d, p);
}

/* Count the rows held, give friction to those that slip, and make room for their shares. */
static lw_status set_friction(lw_dynamics *d, int n)
{
    struct lw_touching *w = d->touch;
    int slipping = 0;
    w->n_row = n;
    for (int k = 0; k < n; k++) {
        const lw_touch *p = &w->list.touch[w->row[k].touch];
        if (w->row[k].tangent || p->slips == 0)
            continue;
        int at = d->n_friction + slipping++;
        d->friction[at] = (lw_friction_joint){ .joint = -1 };
        d->friction_row[at] = d->n_row + d->n_driven + d->n_resting + k;
    }
    w->n_slip = slipping;
    free(w->response);
    size_t rows = (size_t)(d->n_row + d->n_driven + d->n_resting + n), rubs = (size_t)(d->n_friction + slipping);
    w->response = calloc(rubs*((size_t)d->n_q + rows + 2) + lw_friction_doubles((int)rubs, 2) + 1, sizeof *w->response);
    return w->response ? lw_mbs_touch_share_make(d) : LW_E_MEMORY;
}

/* Set the states of the places from forces and rates, and the rows that are held.  lets_go: friction no longer holds a place that
 * stuck; its slip has no acceleration yet. */
static lw_status set_states(lw_run *run, double t, const lw_closed *c, bool lets_go)
{
    struct lw_touching *w = run->d->touch;
    independent h = { .c = c, .most = 2*c->m };
    for (int i = 0; i < c->m; i++) {
        h.top = fmax(h.top, c->force[2*i]);
        h.fastest = fmax(h.fastest, fmax(fabs(c->rate[2*i]), fabs(c->rate[2*i + 1])));
        h.fastest = fmax(h.fastest, fmax(fabs(c->b[2*i]), fabs(c->b[2*i + 1])));
    }
    w->least_force = 1e-11*h.top;
    w->most_force = 100*h.top;
    w->n_redundant = 0;
    h.factor = calloc((size_t)(h.most + 1)*(size_t)h.most + 1, sizeof *h.factor);
    h.taken = calloc((size_t)h.most + 1, sizeof *h.taken);
    bool room = h.factor && h.taken;
    for (int frictionless = 0; room && frictionless < 2; frictionless++)
        for (int i = 0; i < c->m; i++)
            if (frictionless == !(c->law[i].friction > 0) && lw_touch_is_rigid(&w->list.touch[c->place[i]]))
                set_gap(w, &h, i);
    if (room) {
        note_several_motions(run, t, &h);
        keep_passive(run, t, &h);
    }
    for (int pass = 0; room && pass < 3; pass++)
        for (int i = 0; i < c->m; i++)
            set_slip(run->d, &h, i, pass, lets_go);
    free(h.factor);
    free(h.taken);
    return room ? set_friction(run->d, h.n) : LW_E_MEMORY;
}

/* Duration of the shortest bounce that begins now, from the accelerations found; 0: none. */
static double find_flight(const lw_closed *c)
{
    double flight = 0;
    for (int i = 0; i < c->m; i++) {
        double u = c->u[2*i], a = c->rate[2*i], f = !c->in[i] && u > 0 && a < 0 ? -2*u/a : 0;
        if (f > 0 && (flight == 0 || f < flight))
            flight = f;
    }
    return flight;
}

static double greatest_of(const lw_dynamics *d, const double *v)
{
    double most = 0;
    for (int i = 0; i < d->n_q; i++)
        most = fmax(most, fabs(v[i]));
    return most;
}

static lw_status decide(lw_run *run, double t, double *y, lw_closed *c, bool undecided, bool *any)
{
    lw_dynamics *d = run->d;
    double *v = y + d->n_q;
    lw_status s = find_free(run, t, y, c);
    double speed = fmax(greatest_of(d, v), sqrt(greatest_of(d, d->a))), tiny = still*speed;
    lw_closed_rates(d, v, c);
    for (int tries = 0; s == LW_OK && tries < 20; tries++) {
        s = lw_run_touch_strike(run, t, c, &tiny, v, any);
        if (s == LW_OK)
            s = find_free(run, t, y, c);
        if (s != LW_OK)
            return s;
        set_laws(d, c, speed);
        s = find_forces(c, tiny);
        if ((s == LW_OK && !undecided) || (s != LW_OK && s != LW_NOTHING))
            return s;
        bool impulsive, known = s == LW_OK;
        undecided = false;
        s = lw_run_touch_impulses(run, t, c, speed, v, &impulsive);
        *any = *any || impulsive;
        if (s == LW_NOTHING)
            break;
        if (s == LW_OK && !impulsive) {
            set_laws(d, c, speed);
            return known ? find_forces(c, tiny) : LW_OK;     /* impulses are less accurate */
        }
    }
    return lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s no forces of rigid contact with friction go on with the motion "
                        "(Painleve's paradox); give the contacts a \"stiffness\"", t);
}

/* LW_E_NUMERIC: many events in a row without progress in time. */
static lw_status check_progress(lw_run *run, double t)
{
    struct lw_touching *w = run->d->touch;
    const lw_dynamics_options *o = &run->d->o;
    bool still_here = t - w->last < 1e-12*(o->to - o->from);
    w->stalled = still_here ? w->stalled + 1 : 0;
    w->last = still_here ? w->last : t;
    return w->stalled < STALLED_MOST ? LW_OK
         : lw_error_set(run->e, LW_E_NUMERIC, "contacts close and open without end at t = %.9g s", t);
}

/* Projecting y onto the constraints can close open gaps by a rounding error: their next event counts from the present gap. */
static void note_gaps(lw_dynamics *d, const double *y)
{
    d->eq.place(d->eq.context, y);
    for (int i = 0; i < d->touch->list.n; i++) {
        lw_touch *p = &d->touch->list.touch[i];
        if (!lw_touch_is_rigid(p) || (p->state != LW_TOUCH_APART && p->state != LW_TOUCH_PASSIVE))
            continue;
        p->passed = fmax(p->passed, -lw_touch_gap(p, &d->eq, d->frames));
    }
}

/* Greatest slip of a place against the direction that was found for it. */
static double slip_against(lw_dynamics *d, const double *y)
{
    double most = 0;
    d->eq.place(d->eq.context, y);
    for (int i = 0; i < d->touch->list.n; i++) {
        const lw_touch *p = &d->touch->list.touch[i];
        lw_touch_motion m;
        if (p->slips == 0)
            continue;
        lw_touch_at(p, &d->eq, d->frames, y + d->n_q, &m);
        most = fmax(most, -p->slips*m.slip);
    }
    return most;
}

static const double sudden = 1e-3;           /* such a part of the greatest acceleration by loads alone */

static bool slips_at_once(const lw_dynamics *d, const lw_closed *c, int i)
{
    return c->in[i] && c->law[i].slips == 0 && c->law[i].friction > 0 && !c->law[i].fixed && fabs(c->rate[2*i + 1]) > sudden*greatest_of(d, d->a);
}

void lw_run_touch_jammed(lw_run *run, double t, int place)
{
    run->r->jammed = lw_touch_name(run->d->model, &run->d->touch->list.touch[place]);
    run->r->jammed_t = t;
}

/* Friction that gives way does so with no acceleration at first, if loads are continuous.  Does a place that `stuck` slip with one by the forces found,
 * though friction could hold all of them by other forces?  Then rigid bodies have both motions.  Changes the forces and rates of c. */
static void note_jam(lw_run *run, double t, const lw_closed *c)
{
    const lw_dynamics *d = run->d;
    int worst = -1;
    for (int i = 0; i < c->m && !run->r->jammed; i++)
        if (d->touch->list.touch[c->place[i]].stuck && slips_at_once(d, c, i) && (worst < 0 || fabs(c->rate[2*i + 1]) > fabs(c->rate[2*worst + 1])))
            worst = i;
    if (worst < 0)
        return;
    double slip = c->rate[2*worst + 1];
    for (int i = 0; i < c->m; i++)
        c->law[i].holds = true;
    if (lw_closed_solve(c, c->b, c->force, c->rate) == LW_OK && lw_complementarity_held(c->m, c->law, c->force, c->rate, worst, slip))
        lw_run_touch_jammed(run, t, c->place[worst]);
}

/* Take the rows of all places away, and factor those of the joints at (t, y). */
static lw_status factor_joints(lw_dynamics *d, double t, const double *y)
{
    struct lw_touching *w = d->touch;
    bool had = w->n_row > 0;
    w->n_row = w->n_slip = w->n_redundant = 0;
    w->determinant = 1;
    w->sense = 0;
    lw_status s = had ? lw_mbs_arrange(d, t, y) : LW_OK;
    if (s == LW_OK)
        s = lw_mbs_rows(d, t, y);
    return s == LW_OK ? lw_mbs_factor(d, false) : s;
}

/* Apply impulses and find the states of all places.  Slips below `slow` count as 0. */
static lw_status find_states(lw_run *run, double t, double *y, unsigned long long events, double slow)
{
    lw_dynamics *d = run->d;
    struct lw_touching *w = d->touch;
    lw_closed c = { .slow = slow };
    bool any = false;
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    double before = d->eq.kinetic(d->eq.context, y + d->n_q);
    lw_status s = check_progress(run, t);
    for (int i = 0; i < w->list.n; i++) {
        w->list.touch[i].stuck = w->list.touch[i].sticks;
        w->list.touch[i].sticks = false;
        w->list.touch[i].slips = 0;
        w->list.touch[i].passed = 0;
        w->list.touch[i].redundant = false;
        w->list.touch[i].held = w->list.touch[i].state == LW_TOUCH_HELD;
        if (w->list.touch[i].held)
            w->list.touch[i].state = LW_TOUCH_PASSIVE;
    }
    if (s == LW_OK)
        s = factor_joints(d, t, y);
    if (s == LW_OK && t == d->o.from)
        s = lw_run_touch_choose_sides(run);
    for (int i = 0; s == LW_OK && i < w->list.n; i++)
        if (w->list.touch[i].state == LW_TOUCH_APART)            /* a disc may have passed around an end since the last step */
            lw_touch_choose_side(&w->list.touch[i], d->frames, false, LW_TOUCH_END);
    if (s == LW_OK)
        s = lw_closed_find(run, t, y, &c);
    if (s == LW_OK)
        s = decide(run, t, y, &c, events >> DETERMINANT & 1, &any);
    if (s == LW_OK)
        s = set_states(run, t, &c, events >> STICK & 1);
    run->flight = s == LW_OK ? find_flight(&c) : 0;
    if (s == LW_OK)
        note_jam(run, t, &c);
    lw_closed_free(&c);
    if (s == LW_OK && w->n_row > 0)
        s = lw_mbs_arrange(d, t, y);
    if (s == LW_OK)
        s = lw_run_project(run, t, y);
    if (s == LW_OK)
        note_gaps(d, y);
    if (s == LW_OK)
        y[2*d->n_q] += d->eq.kinetic(d->eq.context, y + d->n_q) - before;
    return s;
}

/* If impulses of a heavy body move a light one, its rates have rounding errors above lw_touch_no_slip, and the projection onto the constraints
 * can reverse a slip.  Its end would be missed then, and friction would accelerate it.  So the states are found again, with slips up to twice
 * the reversed one counted as 0. */
lw_status lw_run_touch(lw_run *run, double t, double *y, unsigned long long events)
{
    lw_status s = LW_OK;
    double slow = 0, against = 0;
    for (int tries = 0; tries < 4 && s == LW_OK && (tries == 0 || against > late); tries++) {
        s = find_states(run, t, y, events, slow);
        against = s == LW_OK ? slip_against(run->d, y) : 0;
        slow = against < rounded*greatest_of(run->d, y + run->d->n_q) ? 2*against : slow;
    }
    return s;
}

lw_status lw_run_touch_end(lw_run *run, double t, double *y)
{
    lw_dynamics *d = run->d;
    struct lw_touching *w = d->touch;
    lw_closed c = { 0 };
    if (run->r->jammed || w->n_redundant == 0)
        return LW_OK;
    const struct lw_touching old = *w;
    lw_touch *touch = malloc((size_t)w->list.n*sizeof *touch);
    if (!touch)
        return LW_E_MEMORY;
    memcpy(touch, w->list.touch, (size_t)w->list.n*sizeof *touch);
    for (int i = 0; i < w->list.n; i++)
        w->list.touch[i].stuck = w->list.touch[i].sticks;
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    lw_status s = factor_joints(d, t, y);
    if (s == LW_OK)
        s = lw_closed_find(run, t, y, &c);
    if (s == LW_OK)
        s = find_free(run, t, y, &c);
    if (s == LW_OK) {
        double speed = fmax(greatest_of(d, y + d->n_q), sqrt(greatest_of(d, d->a)));
        lw_closed_rates(d, y + d->n_q, &c);
        set_laws(d, &c, speed);
        if ((s = find_forces(&c, still*speed)) == LW_OK)
            note_jam(run, t, &c);
    }
    lw_closed_free(&c);
    memcpy(w->list.touch, touch, (size_t)w->list.n*sizeof *touch);
    free(touch);
    w->n_row = old.n_row, w->n_slip = old.n_slip, w->n_redundant = old.n_redundant, w->determinant = old.determinant, w->sense = old.sense;
    if (s == LW_E_MEMORY || s == LW_E_ARG)
        return s;
    return lw_mbs_arrange(d, t, y);          /* what cannot be solved here without the places is no failure of the run */
}

void lw_run_touch_jams(lw_run *run, double t)
{
    const struct lw_touching *w = run->d->touch;
    const lw_touch *first = NULL;
    for (int k = 0; k < w->n_row && !first; k++)
        first = w->list.touch[w->row[k].touch].slips != 0 ? &w->list.touch[w->row[k].touch] : NULL;
    if (first && fabs(w->determinant) < undetermined)
        lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s friction leaves the force of contact \"%s\" undetermined for rigid bodies "
                     "(Painleve's paradox); give the contacts a \"stiffness\"", t, lw_touch_name(run->d->model, first));
}
