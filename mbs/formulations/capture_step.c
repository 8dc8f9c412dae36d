/* mbs/formulations/capture_step.c - a step of captured contacts: forces, impacts and velocities at the places that are closed in its middle. */
#include "base/real.h"
#include "mbs/formulations/capture_internal.h"
#include "mbs/formulations/formulations_internal.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/equations/complementarity.h"

static const double aside = 0.02;            /* such a part of the forces on two bodies may turn towards their gap in a step */
static const double unseen = 0.5;            /* a step with an overlap above this fraction of the distance moved in it is repeated in shorter steps */
static const double allowed = 1e-5;          /* as `lw_capture_exact`, if the passes do not converge with it */
static const double give = 1e-9;             /* compliance of the rows of contacts, over their diagonals */
static const double unstable = 1e-4;         /* change of a state whose rate changes its sign, over the change allowed for other states */
static const double slightest = 1e-3;        /* slip with which friction gives way, over the change of velocities by forces */
static const double reached = 1e-3;          /* a step ends at an impact if the gap is then below this fraction of the distance moved in a step */
static const double at_once = 1e-6;          /* strikes within less than this fraction of a step are told to be at once, as they are to rounding */
enum { PASSES = 120, HARD = 40, LATE = 100, DENSE_SOON = 60, DENSE_MOST = 250, BOUNCES = 200, TOGETHER_MOST = 60 };

/* ---- states ------------------------------------------------------------------------------------------------- */

/* Rates of the states z at (t, q, v). */
static lw_status rates_of(lw_capture *g, double t, const double *q, const double *v, const double *z, double *rate)
{
    g->d->eq.place_states(g->d->eq.context, z);
    return lw_mbs_state_rates(g->d, t, q, v, rate);
}

/* Move the states z over `whole` from t on, at (q, v), and set mean (n_z, unless NULL) to their mean; by the midpoint rule, in so many parts that its two
 * rates hardly differ: the states of motors are far faster than steps of contact.  Near rest the rates differ little in steps that are too
 * long for the rule to be stable; there a rate must not turn to a greater one of the other sign. */
lw_status lw_capture_move_states(lw_capture *g, double t, double whole, const double *q, const double *v, double *z, double *mean)
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
static lw_status mean_states(lw_capture *g, double h)
{
    const lw_equations *eq = &g->d->eq;
    lw_status s = eq->n_z ? rates_of(g, g->t + 0.5*h, g->next_q, g->v, g->next_z, g->rate) : LW_OK;
    for (int i = 0; i < eq->n_z; i++)
        g->mean_z[i] = 0.5*(g->mean_z[i] + g->next_z[i] + 0.25*h*g->rate[i]);
    return s;
}

/* ---- places ------------------------------------------------------------------------------------------------- */

/* The acceleration of a gap that the forces on its two bodies, without those of joints and rigid places, cause if joints turn them into its direction; where
 * nothing presses, the accelerations of the last step tell it, and little of this. */
double lw_capture_pull_on(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m)
{
    double turned = 0, sum = 0;
    for (int k = 0; k < 2; k++)
        if (p->body[k] >= 0) {
            const double *n = m->n + 3*k, *f = g->force + 3*p->body[k], *by = g->d->by_mass + 3*p->body[k], *a = g->d->a + 3*p->body[k];
            turned += hypot(n[0], n[1])*hypot(f[0]*by[0], f[1]*by[1]) + fabs(n[2]*f[2]*by[2]);
            sum += fabs(n[0]*a[0] + n[1]*a[1] + n[2]*a[2]);
        }
    return p->state == LW_TOUCH_HELD ? turned : fmin(turned, sum + aside*turned);
}

/* Does a corner come to an end of a face just where that end slides off a side of the corner's own body, on which it has pressed so far?  Tips pass each other
 * then.  in: the time until the gap closes. */
bool lw_capture_slides_off(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m, double in)
{
    double along = m->place + m->place_rate*in, near = lw_capture_closed*g->part*g->size;
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

/* ---- a step ------------------------------------------------------------------------------------------------ */

void lw_capture_clear_row(lw_dynamics *d, int row) { memset(lw_mbs_jac(d, row), 0, (size_t)d->row_size*sizeof *d->jac); }

static int first_row(const lw_dynamics *d) { return d->n_row + d->n_driven; }

/* Restore all rows of places as they are in the middle of the step. */
static void restore_rows(const lw_capture *g)
{
    lw_dynamics *d = g->d;
    memcpy(lw_mbs_jac(d, first_row(d)), g->full, (size_t)((d->n_c - first_row(d))*d->row_size)*sizeof *d->jac);
}

/* Fill in the system for the guess, J M^-1 P^T.  P holds the directions in which the multipliers act: the rows, but at a
 * place that slips the row of the gap less friction. */
static lw_status factor_guess(lw_capture *g)
{
    lw_dynamics *d = g->d;
    memcpy(g->push, d->jac, (size_t)(d->n_c*d->row_size)*sizeof *g->push);
    for (int k = 0; k < g->n; k++) {
        const lw_capture_place *p = &g->at[k];
        double *gap = g->push + p->row*d->row_size, *slip = gap + d->row_size;
        for (int i = 0; p->presses && p->slips && i < d->row_size; i++)
            gap[i] -= p->mu*p->slips*slip[i];
        if (!p->presses)
            lw_capture_clear_row(d, p->row), memset(gap, 0, (size_t)d->row_size*sizeof *gap);
        if (p->rubs && (!p->presses || p->slips))
            lw_capture_clear_row(d, p->row + 1), memset(slip, 0, (size_t)d->row_size*sizeof *slip);
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
static void hold_back(lw_capture *g, const double *wanted, double *v)
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
static lw_status solve_guess(lw_capture *g, double h)
{
    lw_dynamics *d = g->d;
    lw_status s = factor_guess(g);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < d->n_v; i++)
        g->next_v[i] = g->after[i] + h*g->force[i]*d->by_mass[i];
    for (int k = 0; k < g->n; k++) {
        const lw_capture_place *p = &g->at[k];
        g->wanted[p->row] = p->presses ? p->target : 0;
        if (p->rubs)
            g->wanted[p->row + 1] = p->presses && p->slips == 0 ? p->glide : 0;
    }
    hold_back(g, g->wanted, g->next_v);
    return LW_OK;
}

/* Change the state of place p if it contradicts the velocities next_v and multipliers l; returns whether it was changed.  A place
 * that begins to press keeps its slip; a place that sticks begins to slip before it opens. */
static bool revise_place(lw_capture *g, lw_capture_place *p, const double *l, double tiny)
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

/* Change all places that contradict the solution, or if passes go round in circles, a random half of them.  Returns the number of contradictions. */
static int revise(lw_capture *g, const double *l, int pass, bool circles, double tiny)
{
    int changes = 0;
    for (int k = 0; k < g->n; k++) {
        lw_capture_place was = g->at[k];
        if (!was.shut || !revise_place(g, &g->at[k], l, tiny))
            continue;
        changes++;
        if (circles && ((unsigned)k*2654435761u + (unsigned)pass*2246822519u + (unsigned)g->run->r->refused*3266489917u) >> 31)
            g->at[k].presses = was.presses, g->at[k].slips = was.slips;
    }
    return changes;
}

/* Set v (n_v) to the velocities that a unit impulse along a row causes. */
static void respond(lw_capture *g, int row, double *v)
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
static void adopt(lw_capture *g, double h, int m, const int *row, const double *impulse)
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
        lw_capture_place *p = &g->at[k];
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
static lw_status make_dense(lw_capture *g, double h, int m, dense *to)
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
        lw_capture_place *p = &g->at[k];
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
static lw_status solve_densely(lw_capture *g, double h, int m)
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

/* Of the m closed places, a place that stuck before the step slips after it, by forces that change velocities by `pull`.  Could friction have held it by other
 * impulses?  Then rigid bodies have both motions.  The solution of the step remains. */
static lw_status note_jam(lw_capture *g, double h, int m, double pull)
{
    lw_dynamics *d = g->d;
    int worst = -1, touch = -1;
    double slip = slightest*pull;
    if (g->run->r->jammed || g->late > 0 || m > DENSE_SOON)
        return LW_OK;
    for (int k = 0, i = 0; k < g->n; k++) {
        const lw_capture_place *p = &g->at[k];
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
    lw_capture_place *at = malloc(n*sizeof *at);
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
bool lw_capture_closes_one(const lw_capture *g)
{
    for (int k = 0; k < g->n; k++)
        if (g->at[k].presses && !g->at[k].pressed)
            return true;
    return false;
}

/* If a contact closes in a step, velocities jump, and its end cannot be predicted from the old ones: satisfy the rows in its middle.  Gaps close at its end at
 * the soonest. */
static lw_status aim_at_middle(lw_capture *g, double t)
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
static int find_shut(lw_capture *g, double half)
{
    lw_dynamics *d = g->d;
    double near = lw_capture_closed*g->part*g->size, leaving = lw_capture_exact*lw_greatest(d->n_v, g->v);
    int shut = 0;
    for (int k = 0; k < g->n; k++) {
        lw_capture_place *p = &g->at[k];
        lw_touch *touch = &d->touch->list.touch[p->touch];
        lw_touch_motion m;
        lw_touch_at(touch, &d->eq, d->frames, g->v, &m);
        if (!p->presses && m.gap < 0) {
            lw_touch_round_end(touch, &m, 2*half);
            lw_touch_at(touch, &d->eq, d->frames, g->v, &m);
        }
        bool open = !p->presses && (half > 0 ? p->touch == g->strikes || stays_open(&m, half) : m.gap > 0 && m.rate > leaving);
        p->shut = m.gap < near && !open && !lw_touch_past_end(touch, &m)
               && !lw_touch_goes_on(touch, d->frames, &m, near) && !lw_touch_beside_end(touch, d->frames, &m)
               && !(m.rate < 0 && lw_capture_slides_off(g, touch, &m, fmin(m.gap/-m.rate, half)));
        shut += p->shut;
        p->presses = p->presses && p->shut;
        p->normal = p->across = 0;
    }
    return shut;
}

/* Find the forces in the middle of the step, at the mean of the states and the velocities v; returns the power of those without potential [W]. */
static double find_forces(lw_capture *g, double t, const double *v)
{
    lw_dynamics *d = g->d;
    double power = 0;
    d->eq.place_states(d->eq.context, g->mean_z);
    d->eq.forces(d->eq.context, t, g->next_q, v, g->force, &power);
    lw_mbs_touch_forces(d, v, g->force, &power);
    return power;
}

static void set_pulls(lw_capture *g, double h)
{
    const lw_dynamics *d = g->d;
    for (int k = 0; k < g->n; k++) {
        const lw_touch *p = &d->touch->list.touch[g->at[k].touch];
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, NULL, &m);
        g->at[k].pull = h*lw_capture_pull_on(g, p, &m);
    }
}

/* Find the forces at the velocities after the impacts of the step, and what they change in h; *pull: the greatest change of a velocity. */
static lw_status find_pull(lw_capture *g, double t, double h, double *pull)
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
static double bend(const lw_capture_place *p, const lw_touch_motion *m, double h) { return p->presses ? -0.5*h*m->bias : 0; }

/* Does the place approach faster than forces move bodies at rest in a step?  At a located impact (h = 0) the threshold is lower. */
static bool is_struck(const lw_capture_place *p, const lw_touch_motion *m, double h)
{
    return m->rate < -(h > 0 ? 3 : lw_capture_shallow)*(p->pull + fabs(bend(p, m, h)));
}

/* Let bodies that approach faster than bodies at rest bounce in the middle of the step, by the law of impact of located events (mbs/run/touch.c): at the
 * places that approach, then at those that approach because of these impacts.  Without restitution the step itself ends the approach; at a located
 * impact (h = 0) all closed places then take part. */
static lw_status bounce(lw_capture *g, double t, double h)
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
            lw_capture_clear_row(d, r);                 /* only joints constrain the response to an impulse */
        s = pass == 0 ? lw_mbs_factor_touch(d) : LW_OK;
        if (s == LW_OK)
            s = lw_run_touch_impact(g->run, t, n, struck, g->after);
    }
    restore_rows(g);
    return s == LW_NOTHING ? LW_OPEN : s;
}

/* Keep a copy of the rows of places, since bounce and the passes of a step clear inactive rows. */
static void keep_rows(lw_capture *g)
{
    const lw_dynamics *d = g->d;
    memcpy(g->full, lw_mbs_jac(d, first_row(d)), (size_t)((d->n_c - first_row(d))*d->row_size)*sizeof *d->jac);
}

/* A number for the guess: equal guesses have equal ones. */
static unsigned long long guess_number(const lw_capture *g)
{
    unsigned long long x = 14695981039346656037u;
    for (int k = 0; k < g->n; k++)
        x = (x ^ (unsigned)(4*g->at[k].presses + g->at[k].slips + 1))*1099511628211u;
    return x;
}

/* Find the velocities after a step with `shut` closed places: guess which of them press and stick, and change the guess until nothing contradicts it.  `fastest`: the
 * greatest velocity; forces change velocities by up to `pull`.  LW_OPEN: the passes do not converge. */
static lw_status guess_places(lw_capture *g, double t, double h, int shut, double fastest, double pull)
{
    bool middle = false, circles = false, tried = false;
    unsigned long long seen[PASSES];
    for (int pass = 0; pass < PASSES; pass++) {
        seen[pass] = guess_number(g);
        for (int k = 0; k < pass && !circles; k++)
            circles = seen[k] == seen[pass];
        bool densely = !tried && (shut <= DENSE_SOON ? circles : pass == LATE && shut <= DENSE_MOST);
        lw_status s = densely ? solve_densely(g, h, shut) : LW_NOTHING;
        tried = tried || densely;
        if (s != LW_NOTHING)
            return s == LW_OK ? note_jam(g, h, shut, pull) : s;
        s = LW_OK;
        if (!middle && lw_capture_closes_one(g))
            middle = true, s = aim_at_middle(g, t);
        if (s == LW_OK)
            s = solve_guess(g, h);
        restore_rows(g);
        if (s != LW_OK || revise(g, g->d->l, pass, circles, (pass < HARD ? lw_capture_exact : allowed)*(fastest + pull)) == 0)
            return s == LW_OK ? note_jam(g, h, shut, pull) : s;
    }
    return LW_OPEN;
}

/* Find the new velocities for a step of length h with its middle at next_q.  LW_OPEN: the passes do not converge. */
static lw_status solve_step(lw_capture *g, double t, double h)
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
        lw_capture_place *p = &g->at[k];
        lw_touch_motion m;
        lw_touch_at(&d->touch->list.touch[p->touch], &d->eq, d->frames, g->after, &m);
        p->pressed = p->presses;
        p->closes = p->presses || is_struck(p, &m, h) ? 0 : fmin(0, -2*m.gap/h - 0.25*h*m.bias);
        p->target = is_struck(p, &m, h) ? 0 : p->presses ? bend(p, &m, h) : p->closes;
        if (p->shut && d->touch->list.touch[p->touch].state != LW_TOUCH_HELD)
            g->rest = fmax(g->rest, -m.rate*d->touch->list.touch[p->touch].surface->restitution);
        p->glide = p->presses && p->slips == 0 ? -0.5*h*m.slip_bias : 0;
    }
    return guess_places(g, t, h, shut, fastest, pull);
}

/* Project q onto the rows of the joints and out of overlaps; returns the greatest overlap before, scaled. */
static lw_status put_back(lw_capture *g, double t, double *q, double *overlap)
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
            const lw_capture_place *p = &g->at[k];
            bool held = d->touch->list.touch[p->touch].state == LW_TOUCH_HELD, in = p->presses && (held || d->phi[p->row] < 0);
            g->wanted[p->row] = in ? -d->phi[p->row] : 0;
            *overlap = pass || !p->presses ? *overlap : fmax(*overlap, -d->phi[p->row]);
            off = in ? fmax(off, 1e-3*fabs(d->phi[p->row])) : off;
            if (!in)
                lw_capture_clear_row(d, p->row);
            if (p->rubs) {
                g->wanted[p->row + 1] = 0;
                lw_capture_clear_row(d, p->row + 1);
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

/* What the impulses of a step do at the places: mean of the rates before and after it.  Where a place held before, and sticks on, its rates are
 * errors of the step, and no work. */
static double work_of_places(const lw_capture *g)
{
    const lw_dynamics *d = g->d;
    double sum = 0;
    for (int k = 0; k < g->n; k++) {
        const lw_capture_place *p = &g->at[k];
        const lw_touch *was = &d->touch->list.touch[p->touch];
        if (was->state != LW_TOUCH_HELD)
            sum += 0.5*p->normal*(lw_mbs_row_rate(d, p->row, g->after) + lw_mbs_row_rate(d, p->row, g->next_v));
        if (p->rubs && !(was->sticks && p->slips == 0))
            sum += 0.5*p->across*(lw_mbs_row_rate(d, p->row + 1, g->after) + lw_mbs_row_rate(d, p->row + 1, g->next_v));
    }
    return sum;
}

/* One step of length h: next_q, next_v; d->a and d->l are means over it. */
lw_status lw_capture_step(lw_capture *g, double h, double *overlap)
{
    lw_dynamics *d = g->d;
    double *way = d->hold, gained = 0, motion[3];
    size_t n_v = (size_t)d->n_v;
    for (size_t i = 0; i < n_v; i++)
        way[i] = 0.5*h*g->v[i];
    memcpy(g->next_q, g->q, (size_t)d->n_q*sizeof *g->q);
    d->eq.move(d->eq.context, g->next_q, way);
    memcpy(g->next_z, g->z, (size_t)d->eq.n_z*sizeof *g->z);
    lw_status s = lw_capture_move_states(g, g->t, 0.5*h, g->next_q, g->v, g->next_z, g->mean_z);
    if (s == LW_OK)
        s = mean_states(g, h);
    if (s == LW_OK)
        s = solve_step(g, g->t + 0.5*h, h);
    if (s == LW_OK) {
        gained = 0.5*h*(g->power + find_forces(g, g->t + 0.5*h, g->next_v));
        s = lw_capture_move_states(g, g->t + 0.5*h, 0.5*h, g->next_q, g->next_v, g->next_z, NULL);
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
bool lw_capture_overlaps_unseen(const lw_capture *g)
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
bool lw_capture_miss(lw_capture *g, double *h)
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

/* Of the closed places that did not press before: the time between the first and the last strike, if each struck by itself. */
static double time_between_strikes(const lw_capture *g)
{
    double first = INFINITY, last = -INFINITY;
    for (int k = 0; k < g->n; k++) {
        lw_touch_motion m;
        if (!g->at[k].shut || g->at[k].presses)
            continue;
        lw_touch_at(&g->d->touch->list.touch[g->at[k].touch], &g->d->eq, g->d->frames, g->v, &m);
        if (m.rate < 0)
            first = fmin(first, -m.gap/m.rate), last = fmax(last, -m.gap/m.rate);
    }
    return last > first ? last - first : 0;
}

/* Apply the impact at which a step of length h has ended. */
lw_status lw_capture_hit(lw_capture *g, double h, double *overlap)
{
    lw_dynamics *d = g->d;
    size_t n_v = (size_t)d->n_v;
    lw_status s = lw_mbs_rows(d, g->t, g->q);
    if (s != LW_OK || find_shut(g, 0) >= TOGETHER_MOST)
        return s;                            /* too many: the next step captures it */
    double between = time_between_strikes(g);
    if (between > at_once*h)
        g->run->r->captured_late = fmax(g->run->r->captured_late, between);
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
        g->at[k].presses = g->at[k].presses && lw_mbs_row_rate(d, g->at[k].row, g->v) <= lw_capture_shallow*g->at[k].pull;
    return LW_OK;
}
