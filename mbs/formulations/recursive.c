/* mbs/formulations/recursive.c - forward dynamics of a spatial model in the coordinates of its joints (mbs/space/recursive.h)
 * by collocation with eight states at once, if the loads are simple; else by an explicit method of order 8, or BDF methods (CVODE) where
 * dampers would keep its steps short.  Loops are closed after steps in which they opened noticeably, and for rows of output.  Singular
 * postures of the loops are passed in the coordinates of the bodies. */
#include "base/number.h"
#include "base/real.h"
#include "base/vector.h"
#include "mbs/formulations/formulations_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/ode/collocation.h"
#include "mbs/ode/cvode.h"
#include "mbs/ode/integrate.h"
#include "mbs/space/recursive.h"
#include "mbs/space/recursive_stages.h"

static const double near_singular = 1e-4;    /* least pivot of the loops over that of the start: too small for steps, */
static const double far_from_singular = 1e-2;            /* great enough for forces of samples, and to come back to joints' coordinates */
static const double clear = 0.02;            /* least pivot of all rows, at which this is looked at */
static const double same_place = 1e-12;         /* difference of places and velocities that are the same but for rounding */
static const double closed = 1e-9;           /* loops that stay farther open after all passes fail [sizes, rad] */
static const double left_open = 0.02;        /* misfit of loops after a step, over the error allowed in it, that waits for the next row of output */
static const double same_posture = 1e-9;     /* joints that do not reproduce the posture of the start better fail */
enum { MOST_ROWS = 48 };                     /* of loops: more are faster in the coordinates of all bodies */

/* BDF methods (and Newton's method of collocation) are taken where the explicit one needs more steps for stability than they do for
 * accuracy: about decay/6 a second against powers of the tolerance; their derivatives by differences cost an evaluation for each coordinate. */
static const double most_accurate = 0.9e-10;   /* tolerance */
static const double damped = 1e3;            /* decay [1/s] times the length of the run, */
static const double damped_from = 1e-8;      /* which grows with powers of this over the tolerance */
enum { MOST_DIFFERENCES = 40 };
static const double most_turn = 3;           /* of a joint in one step: turns are counted from step to step [rad] */

typedef struct motion {
    lw_run *run;
    lw_recursive r;                          /* both of d->tree; */
    lw_tree_stages stages;                   /* of trees with simple loads, else without bodies */
    const double *before;                    /* state at the beginning of the step; NULL: BDF methods */
    bool staged;                             /* by collocation */
    lw_space_extra *extra;
    double (*wanted)[3], *near;              /* (extra) */
    double *body, *shown, *free;             /* states of the bodies (run->n), the second after steps; scratch (n_u) */
    double *dependence;                      /* (n_c) for each row left out: scratch for samples */
    double *turned;                          /* scratch (n_x): coordinates without whole turns */
    double least, first;                     /* least pivot of the loops in the last step, at the start */
    bool open;                               /* the loops were not closed after the last step */
    bool start_known;                        /* stages.dy is the rates of the start */
} motion;

/* ---- rows of loops ---------------------------------------------------------------------------------------------- */

/* The motions wanted of the inputs, and the angles near which their measures count. */
static lw_status want(motion *m, double t)
{
    lw_dynamics *d = m->run->d;
    for (int i = 0, k = d->space->n_idle; i < d->n_driven; i++, k++) {
        lw_spatial_measure of = m->extra[k].measure;
        m->near[k] = of.of == LW_OF_TURN ? d->space->f.turn[of.index] : 0;
        if (lw_mbs_motion(d, i, t, m->wanted[k]) != LW_OK)
            return lw_error_set(m->run->e, LW_E_NUMERIC, "the motion of input \"%s\", its rate or its acceleration is not a number at t = %.9g s",
                                d->eq.name(d->eq.context, LW_NAMED_INPUT, d->driven[i]), t);
    }
    return LW_OK;
}

static lw_status place(motion *m, double t, const double *x, const double *u, double *q, double *v)
{
    lw_recursive_place(&m->r, x, q);
    lw_recursive_velocities(&m->r, u, v);
    return want(m, t);
}

static lw_status factor(motion *m)
{
    lw_status s = lw_recursive_factor(&m->r);
    m->least = fmin(m->least, s == LW_OK ? m->r.weak : 0);
    return s == LW_OK ? LW_OK : LW_OPEN;
}

/* Rates of the loops' rows that are missing, into r.l; the greatest. */
static double missing_rates(motion *m, const double *v)
{
    double most = 0;
    for (int i = 0; i < m->r.n_row; i++) {
        const lw_recursive_row *row = &m->r.row[i];
        int extra = i - (m->r.n_row - m->r.n_extra);
        double rate = extra >= 0 ? m->wanted[extra][1] : 0;
        for (int k = 0; k < 6*m->r.s->n_side; k++)
            rate -= row->body[k/6] < 0 ? 0 : row->jac[k]*v[6*row->body[k/6] + k%6];
        m->r.l[i] = rate;
        most = fmax(most, fabs(rate));
    }
    return most;
}

/* The greatest misfit of the rows at the posture placed last. */
static double misfit(const motion *m)
{
    double off = 0;
    for (int i = 0; i < m->r.n_row; i++)
        off = fmax(off, fabs(m->r.row[i].phi));
    return off;
}

static void place_rows(motion *m, const double *x, double *q)
{
    lw_recursive_place(&m->r, x, q);
    lw_recursive_rows(&m->r, m->near, (const double (*)[3])m->wanted, m->run->d->space->f.turn, NULL);
}

static lw_status close_loops(motion *m, double t, double *x, double *u, double *q, double *v)
{
    double before = INFINITY, most = 0, off = 0;
    if (m->r.n_row == 0)
        return place(m, t, x, u, q, v);
    lw_status s = want(m, t);
    for (int pass = 0; s == LW_OK && pass < 12; pass++) {
        if (pass > 0) {
            lw_recursive_solve(&m->r, NULL, LW_WANT_CLOSED, m->free);
            lw_recursive_move(&m->r, x, m->free);
        }
        place_rows(m, x, q);
        off = misfit(m);
        if (!(off < 0.1))
            return LW_OPEN;
        if (pass == 0 || off > 1e-7) {
            lw_recursive_velocities(&m->r, u, v);        /* for the axes */
            if ((s = factor(m)) != LW_OK)
                return s;
        }
        if (off <= 4e-16*(m->r.n_u + 4) || (off < 1e-12 && off >= 0.5*before))
            break;
        before = off;
    }
    if (s != LW_OK || off > closed)
        return s != LW_OK ? s : LW_OPEN;
    lw_recursive_velocities(&m->r, u, v);
    for (int i = 0; i < m->run->d->n_v; i++)
        most = fmax(most, fabs(v[i]));
    for (int pass = 0; pass < 6 && missing_rates(m, v) > 4e-16*most; pass++) {
        lw_recursive_solve(&m->r, NULL, LW_WANT_GIVEN, m->free);
        for (int k = 0; k < m->r.n_u; k++)
            u[k] += m->free[k];
        lw_recursive_velocities(&m->r, u, v);
    }
    return LW_OK;
}

/* ---- the solver's functions ---------------------------------------------------------------------------------- */

static lw_status rate(void *context, double t, const double *y, double *dy)
{
    motion *m = context;
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    int n = m->r.n_x + m->r.n_u, tail = n + run->has_work;
    double *q = m->body, *v = q + d->n_q, power = 0;
    lw_status s = lw_run_busy(run, t);
    if (s == LW_OK)
        s = place(m, t, y, y + m->r.n_x, q, v);
    if (s != LW_OK)
        return s;
    d->eq.place_states(d->eq.context, y + tail);
    d->eq.forces(d->eq.context, t, q, v, d->force, run->has_work ? &power : NULL);
    for (int i = 0; i < d->n_v; i++)
        if (!isfinite(d->force[i]))
            return lw_run_failed_rates(run, t, lw_error_set(run->e, LW_E_NUMERIC, "a force on link \"%s\" is not a number at t = %.9g s",
                                                            d->eq.name(d->eq.context, LW_NAMED_BLOCK, i/LW_BLOCK), t));
    if (m->r.n_row)
        lw_recursive_rows(&m->r, m->near, (const double (*)[3])m->wanted, d->space->f.turn, v);
    if ((s = factor(m)) != LW_OK)
        return s;
    lw_recursive_solve(&m->r, d->force, LW_WANT_MOTION, dy + m->r.n_x);
    lw_recursive_rates(&m->r, y, y + m->r.n_x, dy);
    for (int i = 0; i < d->n_driven; i++)
        power -= m->r.l[m->r.n_row - d->n_driven + i]*m->wanted[d->space->n_idle + i][1];
    if (run->has_work)
        dy[n] = power;
    return d->eq.n_z ? lw_run_failed_rates(run, t, lw_mbs_state_rates(d, t, q, v, dy + tail)) : LW_OK;
}

/* Places a state after a step whose misfit is far below its error.  False: where the loops are to be closed; also near singular postures
 * and where rows are left out, since closing them chooses the rows for the next step. */
static bool stays_open(motion *m, const double *x, const double *u, double *q, double *v)
{
    const lw_dynamics_options *o = &m->run->d->o;
    double fastest = 0;
    if (!m->before || m->r.n_row == 0 || m->r.rank < m->r.n_row || m->least < far_from_singular*m->first)
        return false;
    place_rows(m, x, q);
    if (!(misfit(m) <= left_open*(o->absolute + o->relative)))
        return false;
    lw_recursive_velocities(&m->r, u, v);
    for (int k = 0; k < m->r.n_u; k++)
        fastest = fmax(fastest, fabs(u[k]));
    return missing_rates(m, v) <= left_open*(o->absolute + o->relative*fastest);
}

static lw_status project(void *context, double t, double *y)
{
    motion *m = context;
    lw_dynamics *d = m->run->d;
    double *q = m->body, *v = q + d->n_q, *u = y + m->r.n_x;
    for (int k = 0; m->before && k < m->r.n_x; k++)
        if (!(fabs(y[k] - m->before[k]) < most_turn))
            return LW_OPEN;
    lw_recursive_normalise(&m->r, y);
    m->open = stays_open(m, y, u, q, v);
    lw_status s = m->open ? LW_OK : close_loops(m, t, y, u, q, v);
    if (s != LW_OK)
        return s;
    if (m->staged) {                         /* the joints' coordinates count their turns */
        lw_space_normalise(&d->space->s, q);
        lw_recursive_count_turns(&m->r, y, d->space->f.turn);
    }
    else
        d->eq.accept(d->eq.context, q);
    if (d->eq.keep_momenta) {
        lw_run_hold(m->run, t, q, v);
        lw_recursive_of_bodies(&m->r, q, v, m->turned, u);
        for (int i = 0; i < d->space->s.n_body; i++)     /* place and quaternion of a body that flies, which may be turned */
            if (m->r.body[i].n_u == 6)
                memcpy(y + m->r.body[i].x, m->turned + m->r.body[i].x, 7*sizeof *y);
        return LW_OK;
    }
    double held = lw_run_held(m->run, q, v, NULL);
    for (int k = 0; k < m->r.n_u; k++)
        u[k] -= u[k]*held;
    for (int i = 0; i < d->n_v; i++)
        v[i] -= v[i]*held;
    return LW_OK;
}

/* The state of the bodies at a state of the tree; placed: the one that was placed last. */
static lw_status to_bodies(motion *m, double t, const double *y, bool placed, double *out)
{
    lw_dynamics *d = m->run->d;
    int n = m->r.n_x + m->r.n_u;
    lw_status s = placed ? LW_OK : place(m, t, y, y + m->r.n_x, out, out + d->n_q);
    if (placed)
        memcpy(out, m->body, (size_t)(d->n_q + d->n_v)*sizeof *y);
    memcpy(out + d->n_q + d->n_v, y + n, (size_t)(m->run->has_work + d->eq.n_z)*sizeof *y);
    return s;
}

/* One of three solvers. */
typedef struct stepper {
    motion *m;
    bool implicit, staged;                   /* by BDF methods; by collocation */
    lw_integrator explicit_one;
    lw_sundials implicit_one;
    lw_collocation stages;
    lw_ode ode;
    lw_stages_ode at_stages;
    const double *start;
    double *y;
    double ready[LW_STAGES];                 /* times of the samples that are worked out in m->stages, */
    int    n_ready;                          /* and how many */
} stepper;

/* ---- forces of samples -------------------------------------------------------------------------------------------- */

typedef struct joint_row { lw_vec3 move, turn; double *l; } joint_row;      /* derivatives by the body at the outer end; its multiplier */

/* l of up to three independent vectors: the sum of l_i a_i is x, or as near to it as it can be. */
static void share(int n, lw_vec3 *a, double **l, lw_vec3 x)
{
    if (n == 0)
        return;
    if (n == 1) {
        *l[0] = lw_v3_dot(a[0], x)/lw_v3_dot(a[0], a[0]);
        return;
    }
    if (n == 2)
        a[2] = lw_v3_cross(a[0], a[1]);
    double volume = lw_v3_dot(a[0], lw_v3_cross(a[1], a[2]));
    for (int i = 0; i < n; i++)
        *l[i] = lw_v3_dot(x, lw_v3_cross(a[(i + 1)%3], a[(i + 2)%3]))/volume;
}

/* The multipliers of a joint of the tree that put a force and a moment on this body.  Rows with a force have forces at right angles to each
 * other; at most three others are moments alone. */
static void joint_multipliers(int n, const joint_row *row, lw_vec3 force, lw_vec3 moment)
{
    lw_vec3 turn[3];
    double *l[3];
    int turns = 0;
    for (int i = 0; i < n; i++) {
        double size = lw_v3_dot(row[i].move, row[i].move);
        if (size == 0) {
            turn[turns] = row[i].turn;
            l[turns++] = row[i].l;
            continue;
        }
        *row[i].l = lw_v3_dot(row[i].move, force)/size;
        moment = lw_v3_sub(moment, lw_v3_scale(row[i].turn, *row[i].l));
    }
    share(turns, turn, l, moment);
}

/* Take the force J^T l of a row off the bodies. */
static void take_off(const lw_dynamics *d, int row, double l, double *force)
{
    const double *jac = lw_mbs_jac(d, row);
    const int *block = lw_mbs_blocks(d, row);
    for (int k = 0; k < d->eq.n_slot && block[k] >= 0; k++)
        for (int i = 0; i < LW_BLOCK; i++)
            force[LW_BLOCK*block[k] + i] -= l*jac[LW_BLOCK*k + i];
}

static lw_vec3 three(const double *x) { return lw_v3(x[0], x[1], x[2]); }

/* The multipliers of the joints of the tree, from the leaves inwards.  force (n_v): what all joints of the tree put on the bodies, whose
 * outer joints are taken off. */
static void tree_multipliers(const motion *m, double *force)
{
    const lw_dynamics *d = m->run->d;
    for (int i = m->r.s->n_body - 1; i >= 0; i--) {
        const lw_recursive_body *p = &m->r.body[i], *inner = &m->r.body[p->parent];
        const lw_space_joint *j = p->joint < 0 ? NULL : &m->r.s->joint[p->joint];
        lw_vec3 move = three(force + 6*p->body), turn = three(force + 6*p->body + LW_BLOCK);
        int n = j ? lw_spatial_kind_of(j->kind)->rows : 0;
        joint_row row[6];
        for (int k = 0; k < n; k++) {
            const double *jac = lw_mbs_jac(d, j->row + k);
            const int *block = lw_mbs_blocks(d, j->row + k);
            row[k] = (joint_row){ .l = &d->l[j->row + k] };
            for (int s = 0; s < d->eq.n_slot && block[s] >= 0; s++) {
                int part = block[s] - 2*p->body;
                if (part == 0 || part == 1)
                    *(part ? &row[k].turn : &row[k].move) = three(jac + LW_BLOCK*s);
            }
        }
        joint_multipliers(n, row, move, turn);
        if (p->parent < 0)
            continue;
        turn = lw_v3_add(lw_m3_apply(&p->axes, turn), lw_v3_cross(p->from_parent, move));
        turn = lw_m3_unapply(&inner->axes, turn);
        double *to = force + 6*inner->body;
        to[0] += move.x, to[1] += move.y, to[2] += move.z, to[3] += turn.x, to[4] += turn.y, to[5] += turn.z;
    }
}

/* Is the tree placed at (q, v)? */
static bool is_placed(const motion *m, const double *q, const double *v)
{
    bool same = true;
    for (int i = 0; i < m->r.s->n_body; i++) {
        const lw_recursive_body *p = &m->r.body[i];
        lw_vec3 at = lw_v3_sub(p->at, three(q + 7*p->body)), w = p->velocity.move, off = lw_v3_sub(w, three(v + 6*p->body));
        same = same && lw_v3_dot(at, at) <= same_place*same_place && lw_v3_dot(off, off) <= same_place*same_place*(1 + lw_v3_dot(w, w));
    }
    return same;
}

/* Are all rows those of joints, and those left out those that depend on others? */
static bool rows_are_of_joints(const motion *m)
{
    const lw_dynamics *d = m->run->d;
    return m->r.n_extra + m->r.s->n_coupling == 0 && d->n_c == m->r.s->n_joint_row && d->n_c - d->rank == m->r.n_row - m->r.rank;
}

/* Multipliers d->l from those of the loops, r.l, and d->hold, what all joints put on the bodies. */
static void spread_over_joints(const motion *m)
{
    const lw_dynamics *d = m->run->d;
    for (int i = 0, row = 0; i < m->r.n_cut; i++) {
        const lw_space_joint *j = &m->r.s->joint[m->r.cut[i]];
        for (int k = 0; k < lw_spatial_kind_of(j->kind)->rows; k++, row++) {
            d->l[j->row + k] = m->r.l[row];
            take_off(d, j->row + k, m->r.l[row], d->hold);
        }
    }
    tree_multipliers(m, d->hold);
}

/* Take the part along a unit vector off x. */
static void take_part_along(int n, const double *way, double *x)
{
    double part = lw_dot(n, way, x);
    for (int i = 0; i < n; i++)
        x[i] -= part*way[i];
}

/* Multipliers that put nothing on any body, an orthonormal basis of them. */
static void find_dependences(motion *m)
{
    const lw_dynamics *d = m->run->d;
    for (int i = 0; i < m->r.n_row - m->r.rank; i++) {
        double *column = m->dependence + i*d->n_c, size;
        lw_recursive_dependence(&m->r, i);
        memset(d->hold, 0, (size_t)d->n_v*sizeof *d->hold);
        spread_over_joints(m);
        memcpy(column, d->l, (size_t)d->n_c*sizeof *column);
        for (int k = 0; k < i; k++)
            take_part_along(d->n_c, m->dependence + k*d->n_c, column);
        size = sqrt(lw_dot(d->n_c, column, column));
        for (int r = 0; r < d->n_c; r++)
            column[r] /= size;
    }
}

/* Accelerations and forces of a sample from the joints' coordinates. */
static lw_status solve_sample(void *solver, double t, const double *q, const double *v)
{
    motion *m = ((stepper *)solver)->m;
    lw_dynamics *d = m->run->d;
    if (!rows_are_of_joints(m) || !is_placed(m, q, v))
        return LW_OPEN;
    d->eq.forces(d->eq.context, t, q, v, d->force, NULL);
    for (int i = 0; i < d->n_v; i++)
        if (!isfinite(d->force[i]))
            return LW_OPEN;
    if (m->r.n_row)
        lw_recursive_rows(&m->r, m->near, (const double (*)[3])m->wanted, d->space->f.turn, v);
    if (lw_recursive_factor(&m->r) != LW_OK || m->r.weak < far_from_singular*m->first)
        return LW_OPEN;
    find_dependences(m);
    lw_recursive_solve(&m->r, d->force, LW_WANT_MOTION, m->free);
    lw_recursive_accelerations(&m->r, m->free, d->a);
    for (int i = 0; i < d->n_v; i++)
        d->hold[i] = d->force[i] - d->eq.mass[i]*d->a[i];
    spread_over_joints(m);
    for (int i = 0; i < m->r.n_row - m->r.rank; i++)     /* those of least norm */
        take_part_along(d->n_c, m->dependence + i*d->n_c, d->l);
    return LW_OK;
}

static double *time_at(stepper *w) { return w->implicit ? &w->implicit_one.t : w->staged ? &w->stages.t : &w->explicit_one.t; }
static double time_of(stepper *w) { return *time_at(w); }
static const double *now(const stepper *w) { return w->implicit ? w->implicit_one.y : w->staged ? w->stages.y : w->explicit_one.y; }

static lw_status rates(void *context, const double t[LW_STAGES], bool again, const double *y, double *dy)
{
    motion *m = context;
    lw_status s = lw_run_busy(m->run, t[0]);
    const bool known = m->start_known && memcmp(y, m->stages.y, 8*(size_t)(m->r.n_x + m->r.n_u)*sizeof *y) == 0;
    m->start_known = false;
    if (s == LW_OK && known)
        memcpy(dy + 8*m->r.n_x, m->stages.dy + 8*m->r.n_x, 8*(size_t)(m->r.n_u + m->run->has_work)*sizeof *dy);
    else if (s == LW_OK)
        s = lw_tree_stages_rates(&m->stages, again, y, dy) == LW_OK ? LW_OK : LW_OPEN;
    m->least = m->stages.weak;               /* of the last improvement, or near it; states before may be far off */
    return s;
}

static void joints_move(void *context, const double *y, double *dx)
{
    const motion *m = context;
    lw_tree_stages_motion(&m->stages, y, dx);
}

static lw_status restart(stepper *w, const double *y)
{
    if (w->staged) {
        lw_collocation_restart(&w->stages, y);
        return LW_OK;
    }
    return w->implicit ? lw_cvode_restart(&w->implicit_one, y, 0, w->m->run->e) : lw_integrate_restart(&w->explicit_one, y, w->m->run->e);
}

static lw_status state_at(void *context, double t, double *out)
{
    stepper *p = context;
    motion *m = p->m;
    double *q = m->body;
    const bool within = t != time_of(p), closes = within || m->open;
    lw_status s = LW_OK;
    if (!within)
        memcpy(p->y, now(p), (size_t)p->ode.n*sizeof *p->y);
    else if (p->staged)
        lw_collocation_dense(&p->stages, t, p->y);
    else
        s = p->implicit ? lw_sundials_dense(&p->implicit_one, t, p->y) : lw_integrate_dense(&p->explicit_one, t, p->y);
    if (s == LW_OK && closes)
        s = close_loops(m, t, p->y, p->y + m->r.n_x, q, q + m->run->d->n_q);
    return s == LW_OK ? to_bodies(m, t, p->y, closes, out) : LW_E_NUMERIC;       /* loops that are closed are placed */
}

/* Samples within a step from eight states at once; the start, whose places and velocities are kept to the bit, from eight that are the same. */
static lw_status whole_sample(void *context, double t, double t_end, lw_moment *of)
{
    stepper *w = context;
    motion *m = w->m;
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    lw_tree_stages *s = &m->stages;
    const bool begun = w->stages.ode;
    int k = 0;
    if (!w->staged || !rows_are_of_joints(m) || m->r.rank < m->r.n_row || (begun ? t_end != time_of(w) : !is_placed(m, m->shown, m->shown + d->n_q)))
        return LW_OPEN;
    while (k < w->n_ready && w->ready[k] != t)
        k++;
    if (k == w->n_ready) {
        double at[LW_STAGES] = { t };
        int n = 1;
        for (int i = 1; i < LW_STAGES; i++) {
            double next = run->next + i <= d->o.intervals ? lw_run_time(d, run->next + i) : INFINITY;
            at[i] = next <= t_end ? next : at[i - 1];
            n += next <= t_end;
        }
        if (begun)
            lw_collocation_dense_eight(&w->stages, at, s->y);
        else {
            for (int i = 0; i < w->ode.n; i++)
                for (int lane = 0; lane < 8; lane++)
                    s->y[8*i + lane] = w->start[i];
            lw_tree_stages_keep_rows(s, &m->r);
        }
        w->n_ready = 0, k = 0;
        if (lw_tree_stages_moments(s, begun, n) != LW_OK || s->weak < far_from_singular*m->first)
            return LW_OPEN;
        m->start_known = !begun;
        memcpy(w->ready, at, sizeof at);
        w->n_ready = n;
    }
    const double *q = s->moment + (size_t)k*(size_t)s->n_moment, *v = q + d->n_q, *a = v + d->n_v, *l = a + d->n_v;
    if (!begun)
        q = m->shown, v = q + d->n_q;
    const double work = run->has_work ? s->y[8*(m->r.n_x + m->r.n_u) + k] : 0;
    *of = (lw_moment){ .t = t, .q = q, .v = v, .a = a, .l = l, .z = d->eq.z, .work = work + run->impulse_work, .off = l[d->n_c], .off_rate = l[d->n_c + 1],
                       .potential = d->eq.potential(d->eq.context, q), .kinetic = d->eq.kinetic(d->eq.context, v), .unique = true };
    return LW_OK;
}

static lw_status kink_ahead(void *context, double t, const double *y, double *ahead)
{
    motion *m = context;
    lw_status s = to_bodies(m, t, y, false, m->run->y);
    *ahead = s == LW_OK ? lw_run_kink_ahead(m->run, t, m->run->y) : 0;
    return s;
}

/* One step, in which no joint turns so far that its turns are miscounted. */
static lw_status step(stepper *w, double end, lw_ode_stop *stop)
{
    motion *m = w->m;
    double fastest = 1e-300;
    m->before = w->implicit ? NULL : w->staged ? w->stages.y_old : w->explicit_one.y_old;
    m->staged = w->staged;
    if (w->implicit)
        return lw_sundials_step(&w->implicit_one, end, stop, m->run->e);
    for (int k = 0; k < m->r.n_u; k++)
        fastest = fmax(fastest, fabs(now(w)[m->r.n_x + k]));
    *(w->staged ? &w->stages.o.greatest : &w->explicit_one.o.greatest) = 0.8*most_turn/fastest;
    if (!w->staged)
        return lw_integrate_step(&w->explicit_one, end, stop, m->run->e);
    lw_tree_stages_keep_rows(&m->stages, &m->r);
    return lw_collocation_step(&w->stages, end, stop, m->run->e);
}

/* ---- the run ------------------------------------------------------------------------------------------------------ */

/* LW_OPEN: *t and out are the last good state, from which bodies' coordinates have to go on. */
static lw_status run_steps(motion *m, stepper *w, double *t, double *out)
{
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    lw_ode_stop stop = LW_ODE_STEP;
    lw_status s = LW_OK;
    *t = time_of(w);
    for (long k = 1; s == LW_OK && stop != LW_ODE_END; k++) {
        m->least = 1;
        double end = w->implicit ? lw_run_near(run, time_of(w)) : lw_run_end(run, time_of(w));
        s = step(w, end, &stop);
        if (s == LW_STOPPED || s == LW_E_MEMORY)
            break;
        if (s != LW_OK || m->least < near_singular*m->first) {
            s = m->r.n_row ? LW_OPEN : s;
            break;
        }
        bool placed = !w->implicit && !run->kinks, kink = stop == LW_ODE_EVENT;       /* kinks are looked for after the last projection */
        s = to_bodies(m, time_of(w), now(w), placed, out);
        *t = run->r->t = time_of(w);
        stop = lw_run_stop(run, *t, kink ? LW_ODE_STEP : stop);
        if (s == LW_OK && !placed)
            d->eq.accept(d->eq.context, out);
        if (s == LW_OK) {
            lw_run_watch(run, out);
            s = lw_run_jumps(run, *t, out);
        }
        w->n_ready = 0;
        if (s == LW_OK)
            s = lw_run_samples(run, *t, state_at, w);
        memcpy(w->y, now(w), (size_t)w->ode.n*sizeof *w->y);
        if (s == LW_OK && lw_run_at_kink(run, *t)) {
            s = lw_run_pass_kink(run, time_at(w), state_at, w);
            stop = lw_run_stop(run, time_of(w), LW_ODE_STEP);
            if (s == LW_OK && run->pushed && stop != LW_ODE_END)         /* by drives, whose impulse changes all velocities */
                s = project(m, time_of(w), w->y);
            if (s == LW_OK && stop != LW_ODE_END)
                s = restart(w, w->y);
        }
        if (s == LW_OK && lw_run_pass_kinks(run, *t, out, kink) && stop != LW_ODE_END)
            s = restart(w, w->y);
        if (s == LW_OK && stop != LW_ODE_END && !w->implicit && lw_recursive_wrap(&m->r, w->y))
            s = restart(w, w->y);            /* samples are done with the old angles */
        if (s == LW_OK)
            s = lw_run_limits(run, *t, k);
    }
    run->r->steps += w->implicit ? w->implicit_one.n_step : w->staged ? w->stages.n_step : w->explicit_one.n_step;
    run->r->refused += w->implicit ? w->implicit_one.n_refused : w->staged ? w->stages.n_refused : w->explicit_one.n_refused;
    run->r->rates += w->implicit ? w->implicit_one.n_rate : w->staged ? w->stages.n_rate : w->explicit_one.n_rate;
    return s;
}

/* Decay of the fastest damped motion times the length of the run; from `damped` on dampers shorten the steps of explicit methods. */
static double decays(const lw_dynamics *d) { return d->decay_known ? d->decay*(d->o.to - d->o.from) : 0; }

static bool takes_bdf(const motion *m)
{
    const lw_dynamics *d = m->run->d;
    double tolerance = fmax(d->o.relative, d->o.absolute);
    return m->r.n_row == 0 && m->r.n_u + d->eq.n_z <= MOST_DIFFERENCES && tolerance >= most_accurate
        && decays(d) > damped*fmax(1, pow(damped_from/tolerance, 0.15));
}

/* out: the start to the bit, from which a run that is saved there goes on. */
static lw_status start(motion *m, double *y, double *out)
{
    lw_dynamics *d = m->run->d;
    double *x = y, *u = y + m->r.n_x, *q = m->body, *v = q + d->n_q;
    lw_dynamics_start(d, q, v);
    memcpy(out, q, (size_t)(d->n_q + d->n_v)*sizeof *out);
    lw_recursive_of_bodies(&m->r, q, v, x, u);
    lw_status s = close_loops(m, d->o.from, x, u, q, v);
    for (int i = 0; s == LW_OK && i < d->n_v; i++)
        s = fabs(v[i] - out[d->n_q + i]) <= same_posture*(1 + fabs(v[i])) ? LW_OK : LW_OPEN;
    m->first = m->r.weak;
    memcpy(u + m->r.n_u + m->run->has_work, d->start_z, (size_t)d->eq.n_z*sizeof *y);
    memset(out + d->n_q + d->n_v, 0, m->run->has_work*sizeof *y);
    memcpy(out + d->n_q + d->n_v + m->run->has_work, d->start_z, (size_t)d->eq.n_z*sizeof *y);
    d->eq.place_states(d->eq.context, d->start_z);
    return s;
}

/* Go on in the coordinates of the bodies from the state out at run->r->t.  LW_NOTHING: y is the state behind the singular posture, far
 * enough from it; other statuses end the run. */
static lw_status pass_singular(motion *m, double *y, double *out)
{
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    double *u = y + m->r.n_x, *q = m->body, *v = q + d->n_q;
    for (;; run->clear *= 2) {
        run->solve_sample = NULL, run->whole_sample = NULL;
        lw_status s = lw_run_go_on(run, out);
        run->solve_sample = solve_sample, run->whole_sample = whole_sample;
        if (s != LW_NOTHING)
            return s;
        memcpy(q, out, (size_t)(d->n_q + d->n_v)*sizeof *q);
        lw_recursive_of_bodies(&m->r, q, v, y, u);
        memcpy(u + m->r.n_u, out + d->n_q + d->n_v, (size_t)(run->has_work + d->eq.n_z)*sizeof *y);
        if (close_loops(m, run->r->t, y, u, q, v) == LW_OK && m->r.weak >= far_from_singular*m->first)
            return s;
    }
}

static lw_status begin_steps(stepper *w, const lw_ode_options *o, double *work, double t, const double *y)
{
    if (w->implicit)
        return lw_cvode_make(&w->implicit_one, &w->ode, o, LW_CVODE_BDF, t, y, w->m->run->e);
    if (!w->staged)
        return lw_integrate_start(&w->explicit_one, &w->ode, o, work, t, y, w->m->run->e);
    lw_collocation_start(&w->stages, &w->at_stages, o, work, t, y);
    return LW_OK;
}

static lw_status run_one(motion *m, double *y, double *work)
{
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    stepper w = { .m = m, .ode = { .n = m->r.n_x + m->r.n_u + run->has_work + d->eq.n_z, .context = m, .rate = rate } };
    const lw_ode *ode = &w.ode;
    lw_ode_options o = lw_ode_options_default();
    double *out = m->shown, *each = NULL, t = d->o.from;
    lw_mbs_is_stiff(d);                      /* for its decay */
    bool stiff = decays(d) > damped && m->r.n_u <= LW_IMPLICIT_MAX && m->r.n_x == m->r.n_u && m->r.n_row == 0;
    m->stages.has_work = run->has_work;
    w.staged = m->stages.body && !d->space->f.held && (stiff || !takes_bdf(m));      /* loads held may have come since the tree was made */
    w.implicit = !w.staged && takes_bdf(m);
    w.ode.project = w.implicit ? NULL : project;
    w.ode.n_event = run->kinks != NULL;
    w.ode.breaks = 1;
    w.ode.event = kink_ahead;
    w.ode.direction[0] = -1;
    w.at_stages = (lw_stages_ode){ w.ode.n, m->r.n_x, m->r.n_u, stiff, m, rates, m->r.n_x > m->r.n_u ? joints_move : NULL, project, m->stages.isa };
    w.start = y, w.y = y + ode->n;
    o.relative = w.implicit ? lw_run_bdf_tolerance(d->o.relative) : d->o.relative;
    o.absolute = w.implicit ? lw_run_bdf_tolerance(d->o.absolute) : d->o.absolute;
    o.max_step = d->o.max_step;
    o.smooth = d->eq.smooth;
    lw_status s = start(m, y, out);
    if (s == LW_OK && d->eq.n_z) {           /* states have sizes of their own */
        int first = ode->n - d->eq.n_z;
        each = malloc((size_t)ode->n*sizeof *each);
        s = each ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
        for (int i = 0; each && i < ode->n; i++)
            each[i] = o.absolute*(i < first ? 1 : d->eq.state_scale(d->eq.context, i - first));
        o.absolute_each = each;
    }
    run->solve_sample = solve_sample, run->whole_sample = whole_sample, run->solver = &w;
    if (s == LW_OK)
        s = lw_run_begin(run, out);
    for (bool again = true; again;) {
        double from = t;
        bool begun = s == LW_OK && (s = begin_steps(&w, &o, work, t, y)) == LW_OK;
        if (begun && t < d->o.to)
            s = run_steps(m, &w, &t, out);
        if (begun && w.implicit)
            lw_sundials_free(&w.implicit_one);
        again = s == LW_OPEN || (s == LW_E_NUMERIC && m->r.n_row);
        if (again) {
            run->r->t = t;
            run->clear = t > from ? clear : 4*run->clear;        /* no step: it was too early, or would be in vain from the start */
            s = pass_singular(m, y, out);
            again = s == LW_NOTHING;
            s = again ? LW_OK : s;
            t = run->r->t;
        }
    }
    run->solve_sample = NULL, run->whole_sample = NULL;
    free(each);
    return s;
}

/* The tree of d, made once: rows beside the joints' are spins that are held, inputs with a motion. */
static lw_status take_tree(motion *m, lw_dynamics *d, lw_error *e)
{
    const lw_spatial_scene *c = d->space;
    int n = c->n_idle + d->n_driven;
    lw_status s = LW_OK;
    if (!d->tree) {
        lw_space_tree *t = d->tree = lw_space_tree_new(n);
        if (!t)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        memcpy(t->extra, c->idle, (size_t)c->n_idle*sizeof *t->extra);
        for (int i = 0; i < d->n_driven; i++)
            t->extra[c->n_idle + i] = (lw_space_extra){ .measure = lw_spatial_numbered(c, d->driven_measure[i]) };
        s = lw_recursive_make(&c->s, d->eq.mass, t->extra, n, &t->r, e);
        if (s == LW_OK && lw_tree_stages_make(&t->r, &c->f, &t->stages) == LW_E_MEMORY)
            s = lw_error_set(e, LW_E_MEMORY, "out of memory");
        if (s != LW_OK) {
            lw_space_tree_free(t);
            d->tree = NULL;
            return s;
        }
    }
    m->r = d->tree->r, m->stages = d->tree->stages;
    m->extra = d->tree->extra, m->wanted = d->tree->wanted, m->near = d->tree->near;
    m->r.rank = d->rank - (6*c->s.n_body - m->r.n_u);    /* rows of the tree are independent */
    return s;
}

static size_t work_size(int n) { return lw_integrate_work(n, 1) > lw_collocation_work(n, true) ? lw_integrate_work(n, 1) : lw_collocation_work(n, true); }

static lw_status run_recursive(lw_run *run)
{
    motion m = { .run = run, .least = 1, .first = 1 };
    lw_status s = take_tree(&m, run->d, run->e);
    if (s == LW_OK) {
        int n = m.r.n_x + m.r.n_u + run->has_work + run->d->eq.n_z;
        size_t dependence = (size_t)(m.r.n_row - m.r.rank)*(size_t)run->d->n_c;
        size_t states = 2*(size_t)n + 3*(size_t)run->n + (size_t)(m.r.n_u + m.r.n_x) + dependence;
        double *y = malloc((states + work_size(n))*sizeof *y);
        s = y ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
        if (y) {
            memset(y, 0, 2*(size_t)n*sizeof *y);         /* the rest, which is larger, need not be clear */
            m.body = y + 2*n;
            m.shown = m.body + run->n;
            run->y = m.shown + run->n;
            m.free = run->y + run->n;
            m.turned = m.free + m.r.n_u;
            m.dependence = m.turned + m.r.n_x;
            s = run_one(&m, y, y + states);
        }
        free(y);
    }
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    char why[sizeof r->why];
    if (!d->space)
        return lw_formulation_say(r, LW_E_KIND, 0, "it is for models in space");
    if (d->eq.next_piece)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no contacts");
    if (d->touch || d->n_friction || d->n_stop || d->has_zero_mass || d->elastic)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no rigid stops, friction, massless or elastic links");
    if (!asked && lw_mbs_is_stiff(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "dampers make the equations stiff");
    motion m = { .least = 1 };
    lw_error e;
    lw_status s = take_tree(&m, d, &e);
    int rows = m.r.n_row, n = m.r.n_x + m.r.n_u, legs = rows > 0 ? m.stages.n_leg : 0;
    char apart[48] = "";
    if (s == LW_OK && m.r.n_u > 0 && rows <= MOST_ROWS) {     /* has every motion a mass, and are the loops as counted? */
        double *x = calloc((size_t)(n + m.r.n_u + d->n_q + d->n_v), sizeof *x);
        s = x ? LW_OK : LW_E_MEMORY;
        if (x) {
            double *u = x + m.r.n_x;
            m.run = &(lw_run){ .d = d, .e = &e };
            m.free = u + m.r.n_u;
            lw_recursive_of_bodies(&m.r, d->start_q, d->start_v, x, u);
            s = close_loops(&m, d->o.from, x, u, m.free + m.r.n_u, m.free + m.r.n_u + d->n_q);
            if (s == LW_OK && rows == 0)
                s = factor(&m);
        }
        free(x);
    }
    if (legs > 0)
        snprintf(apart, sizeof apart, ", %d leg%s solved one by one", legs, lw_plural(legs));
    snprintf(why, sizeof why, rows ? "%scoordinates of %d joint%s; %d joint%s cut, %d rows of loops%s" : "%scoordinates of %d joint%s, "
             "an open chain", asked ? "asked for; " : "", d->space->s.n_body, lw_plural(d->space->s.n_body), m.r.n_cut, lw_plural(m.r.n_cut), rows, apart);
    bool none = m.r.n_u == 0;
    if (s != LW_OK || none || rows > MOST_ROWS) {
        lw_space_tree_free(d->tree);
        d->tree = NULL;
    }
    if (s == LW_E_MEMORY)
        return s;
    if (rows > MOST_ROWS || none)
        return lw_formulation_say(r, LW_E_KIND, 0, none ? "no joint moves" : "too many rows close its loops");
    if (s != LW_OK)
        return lw_formulation_say(r, LW_E_KIND, 0, "in its first posture a joint moves no mass, or the loops are singular");
    return lw_formulation_say(r, LW_OK, n, strncat(why, asked ? "" : lw_mbs_is_planar(d), sizeof why - strlen(why) - 1));
}

const lw_formulation_row lw_formulation_recursive = { able, run_recursive };
