/* mbs/run/stick.c - set-valued Coulomb friction of joints in a run: they slip, or stick.
 *
 * A joint that sticks holds its measure by a row, whose multiplier is the friction; one that slips is pushed by the
 * coefficient times its reaction against its slip.  Between events these states are fixed and the motion is smooth.  An event
 * is where a slip comes to rest, or where the row would need more than friction can hold.  There all joints at rest are
 * tried as sticking, and those that cannot hold are let go, one after another, towards where they are pushed; one that is
 * pushed back sticks again.  A joint at its limit that others hold at rest stays pushed without slip. */
#include <string.h>
#include "base/real.h"
#include "mbs/run/run_internal.h"

/* friction_row[j], which space does not need otherwise: is the slip of joint j watched?  Not if others hold it at rest. */
static const double still = 1e-11;           /* a rate below this part of the fastest velocity is rest          */
static const double dependent = 1e-10;       /* response below this part of that without joints: rounding       */
static const double spare = 1e-9;            /* part of the friction by which a row may exceed it               */
static const double late = 1e-13;            /* events happen where their functions are below minus this        */

bool lw_stick_suits(const lw_dynamics *d)
{
    bool yes = d->space && d->n_friction > 0 && d->n_friction <= LW_STOP_ROW_MAX && d->n_stop == 0 && !d->large && !d->eq.next_piece;
    for (int j = 0; yes && j < d->n_friction; j++) {
        lw_spatial_kind k = d->space->s.joint[d->friction[j].joint].kind;
        yes = d->friction[j].ideal && (k == LW_SPATIAL_REVOLUTE || k == LW_SPATIAL_PRISMATIC);
    }
    return yes;
}

/* The stop that stands for sticking joint j. */
static lw_rigid_stop *row_of(lw_dynamics *d, int j) { return &d->stop[j]; }

static double rate_of(lw_dynamics *d, int j, const double *v)
{
    double value, rate;
    lw_spatial_measure of = lw_space_stop_measure(&d->space->s, d->friction[j].joint);
    lw_space_measured(&d->space->s, d->space->frame, of, 0, v, &value, &rate);
    return rate/lw_space_scale(&d->space->s, of);
}

/* What a sticking joint needs over what friction can hold, in d->l; row: its place among those that are rested on. */
static double load_of(lw_dynamics *d, int j, int row, double *limit)
{
    *limit = d->friction[j].coefficient*d->friction[j].lever_arm*lw_mbs_reaction(d, j)*
             d->eq.measure_unit(d->eq.context, row_of(d, j)->measure);
    return d->l[d->n_row + d->n_driven + row];
}

lw_status lw_run_stick_events(void *context, double t, const double *y, double *g)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    lw_status s = LW_OK;
    if (run->kinks)
        g[d->n_friction] = lw_run_kink_ahead(run, t, y);
    if (d->n_resting > 0)
        s = lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL);
    d->eq.place(d->eq.context, y);
    for (int j = 0; s == LW_OK && j < d->n_friction; j++)
        g[j] = d->friction_row[j] && !row_of(d, j)->resting ? d->friction[j].part*rate_of(d, j, y + d->n_q) + late : 1;
    for (int k = 0; s == LW_OK && k < d->n_resting; k++) {
        double limit, load = load_of(d, d->resting[k], k, &limit);
        g[d->resting[k]] = (limit*(1 + spare) - fabs(load))/(limit + fabs(load) + 1e-300) + late;
    }
    return s;
}

/* Rows of the joints that stick, the posture and velocities on them, accelerations and multipliers. */
static lw_status solve(lw_run *run, double t, double *y, const bool *sticks)
{
    lw_dynamics *d = run->d;
    d->n_resting = 0;
    d->eq.place(d->eq.context, y);
    for (int j = 0; j < d->n_friction; j++) {
        lw_rigid_stop *p = row_of(d, j);
        double row[LW_ROW_SIZE] = { 0 };
        int block[LW_ROW_BLOCKS];
        d->eq.measure_blocks(d->eq.context, p->measure, block);
        p->resting = sticks[j];
        if (!sticks[j])
            continue;
        p->limit = d->eq.measure(d->eq.context, p->measure, row, block);
        d->friction[j].part = 0;
        d->resting[d->n_resting++] = j;
    }
    lw_status s = lw_mbs_arrange(d, t, y);
    if (s == LW_OK)
        s = lw_run_project(run, t, y);
    return s == LW_OK ? lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL) : s;
}

/* Second rate of the slip of joint j, by the accelerations d->a. */
static double second_rate(lw_dynamics *d, int j, const double *v)
{
    return rate_of(d, j, d->a) + d->eq.measure_bias(d->eq.context, row_of(d, j)->measure, v);
}

/* Can joint j, whose slip has a rate of 0, stick?  Not where its measure has an extreme while the model moves on: to hold it would
 * stop the motion.  Rows are factored without those of friction. */
static bool can_stick(lw_dynamics *d, int j, const double *v, double fastest)
{
    double row[LW_ROW_SIZE] = { 0 }, *g = d->hold, *change = d->small_v, most = 0;
    int block[LW_ROW_BLOCKS];
    d->eq.measure_blocks(d->eq.context, row_of(d, j)->measure, block);
    d->eq.measure(d->eq.context, row_of(d, j)->measure, row, block);
    memset(g, 0, (size_t)d->n_v*sizeof *g);
    for (int i = 0; i < LW_ROW_SIZE && block[i/LW_BLOCK] >= 0; i++)
        g[LW_BLOCK*block[i/LW_BLOCK] + i%LW_BLOCK] += row[i];
    double whole = lw_mbs_impulse(d, g, change), rate = rate_of(d, j, v), alone = 0;
    for (int i = 0; i < d->n_v; i++) {
        most = fmax(most, fabs(change[i]));
        alone += g[i]*g[i]*d->by_mass[i];
    }
    return whole > dependent*alone && fabs(rate)*most <= 1e-6*fastest*whole;
}

/* The sticking joint that exceeds its friction most, relative to it; -1: none does. */
static int find_loose(lw_dynamics *d, double *sense)
{
    int worst = -1;
    double most = spare;
    for (int k = 0; k < d->n_resting; k++) {
        double limit, load = load_of(d, d->resting[k], k, &limit), over = (fabs(load) - limit)/(limit + 1e-300);
        if (fabs(load) > 1e-300 && over > most)
            most = over, worst = d->resting[k], *sense = load > 0 ? 1 : -1;
    }
    return worst;
}

lw_status lw_run_stick(lw_run *run, double t, double *y, unsigned long long events)
{
    lw_dynamics *d = run->d;
    bool sticks[LW_STOP_ROW_MAX] = { false }, rests[LW_STOP_ROW_MAX] = { false }, none[LW_STOP_ROW_MAX] = { false };
    bool resting[LW_STOP_ROW_MAX];
    int stuck_again[LW_STOP_ROW_MAX] = { 0 };
    double fastest = 0, sense = 0;
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    d->eq.place(d->eq.context, y);
    for (int j = 0; j < d->n_friction; j++)
        resting[j] = row_of(d, j)->resting;
    double before = d->eq.kinetic(d->eq.context, y + d->n_q);
    lw_status s = solve(run, t, y, none);
    for (int i = 0; s == LW_OK && i < d->n_v; i++)       /* or what free accelerations reach over the size */
        fastest = fmax(fastest, fmax(fabs(y[d->n_q + i]), sqrt(fabs(d->a[i]))));
    for (int j = 0; j < d->n_friction; j++) {
        double rate = rate_of(d, j, y + d->n_q);
        rests[j] = fabs(rate) <= still*fastest || resting[j] || events >> j & 1;
        d->friction[j].held = true;
        d->friction[j].part = rests[j] ? 0 : rate > 0 ? 1 : -1;
    }
    if (s == LW_OK)
        s = solve(run, t, y, none);
    for (int j = 0; s == LW_OK && j < d->n_friction; j++) {
        sticks[j] = rests[j] && can_stick(d, j, y + d->n_q, fastest);
        if (rests[j] && !sticks[j])
            d->friction[j].part = second_rate(d, j, y + d->n_q) > 0 ? 1 : -1, rests[j] = false;
    }
    for (int tries = 0; tries < 20*d->n_friction + 20; tries++) {
        if (s != LW_OK || (s = solve(run, t, y, sticks)) != LW_OK)
            return s;
        int j = find_loose(d, &sense);
        if (j >= 0) {
            sticks[j] = false;
            d->friction[j].part = sense;
            continue;
        }
        for (j = 0; j < d->n_friction; j++)          /* pushed back, against the sense of its slip */
            if (rests[j] && !sticks[j] && d->friction[j].part*second_rate(d, j, y + d->n_q) < -1e-9 && stuck_again[j]++ < 3)
                break;
        if (j == d->n_friction)
            break;
        sticks[j] = true;
    }
    for (int j = 0; j < d->n_friction; j++)
        d->friction_row[j] = !(rests[j] && !sticks[j] && fabs(second_rate(d, j, y + d->n_q)) <= 1e-9);
    if (run->has_work)
        y[d->n_q + d->n_v] += d->eq.kinetic(d->eq.context, y + d->n_q) - before;
    return s;
}

void lw_run_stick_begin(lw_run *run)
{
    lw_dynamics *d = run->d;
    for (int j = 0; j < d->n_friction; j++)
        *row_of(d, j) = (lw_rigid_stop){ .joint = d->friction[j].joint, .sign = 1,
            .measure = lw_spatial_number(d->space, lw_space_stop_measure(&d->space->s, d->friction[j].joint)) };
}
