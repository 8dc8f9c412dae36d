/* mbs/equations/equations_space.c - the equations of a spatial model: rows of its joints and of spins that are held, in blocks
 * of three velocities; forces. */
#include "mbs/equations/equations_space.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/equations/timed.h"
#include "mbs/space/space_idle.h"

/* ---- making ------------------------------------------------------------------------------------------------ */

/* A spin that is held changes nothing where the body has no inertia about its axis, or is symmetric about it and not set spinning.  Others run. */
static int keep_exact_spins(const lw_spatial_scene *c, lw_space_extra *x, int count)
{
    int n = 0;
    for (int i = 0; i < count; i++) {
        const double *inertia = c->s.mass + 6*x[i].body + 3;
        const double axis[] = { fabs(x[i].axis.x), fabs(x[i].axis.y), fabs(x[i].axis.z) };
        int k = axis[0] > axis[1] && axis[0] > axis[2] ? 0 : axis[1] > axis[2] ? 1 : 2;
        double a = inertia[(k + 1)%3], b = inertia[(k + 2)%3];
        bool along = axis[k] > 1 - 1e-12 || fabs(a - inertia[k]) + fabs(b - inertia[k]) <= 1e-12*a;
        bool begins = c->model->body[c->s.link_of[x[i].body]].has_omega || fabs(a - b) > 1e-9*fmax(a, b);
        if (along && (inertia[k] == 0 || !begins))
            x[n++] = x[i];
    }
    return n;
}

/* Are there as many motions of inputs as freedoms that are not spins between balls? */
static bool every_freedom_is_driven(const lw_spatial_scene *c)
{
    int motions = 0, rows = c->s.n_row + c->n_idle;
    for (int i = 0; i < c->model->n_input; i++)
        motions += c->model->input[i].motion != NULL;
    return motions > 0 && motions >= c->s.n_v - rows;
}

/* Spins that are held need an inertia, which does not act. */
static void weigh_spins(lw_spatial_scene *c)
{
    memcpy(c->mass, c->s.mass, (size_t)c->s.n_v*sizeof *c->mass);
    for (int i = 0; i < c->n_idle; i++) {
        double *w = c->mass + 6*c->idle[i].body + 3, top = fmax(w[0], fmax(w[1], w[2]));
        const double axis[] = { c->idle[i].axis.x, c->idle[i].axis.y, c->idle[i].axis.z };
        for (int k = 0; k < 3; k++)
            if (w[k] == 0 && fabs(axis[k]) > 1 - 1e-12)
                w[k] = top;
    }
}

lw_status lw_spatial_weigh_massless(lw_spatial_scene *c, bool at_rest, lw_error *e)
{
    double top = 0;
    for (int i = 0; i < c->s.n_v; i++)
        top = fmax(top, c->mass[i]);
    for (int i = 0; i < c->s.n_v; i++)
        if (!at_rest && !(c->mass[i] > 0))
            return lw_error_set(e, LW_E_ARG, "link \"%s\" needs a \"mass\" and an \"inertia\" about every axis: in large models and beside elastic links "
                                "every link has them", c->model->body[c->s.link_of[i/6]].name);
        else if (!(c->mass[i] > 0))
            c->mass[i] = top > 0 ? 1e-3*top : 1, c->massless = i/6;
    return LW_OK;
}

static void set_slots(lw_space_slots *t, const int body[2], bool turns_only)
{
    t->n = 0;
    for (int k = 0; k < 4; k++) {
        if (body[k/2] < 0 || (turns_only && k%2 == 0))
            continue;
        t->from[t->n] = LW_BLOCK*k;
        t->block[t->n++] = 2*body[k/2] + k%2;
    }
}

static void put_spin(lw_spatial_scene *c, int i)
{
    c->slots[c->s.n_row + i] = (lw_space_slots){ .joint = -1, .n = 1, .block = { 2*c->idle[i].body + 1 } };
}

lw_status lw_spatial_scene_make(const lw_spatial *m, lw_spatial_scene *c, lw_error *e)
{
    *c = (lw_spatial_scene){ .model = m, .massless = -1 };
    lw_status st = lw_space_make(m, &c->s, e);
    if (st == LW_OK)
        st = lw_space_forces_make(&c->s, &c->f, e);
    if (st != LW_OK)
        return st;
    size_t bodies = (size_t)c->s.n_body + 1, rows = (size_t)c->s.n_row + bodies;
    c->frame = calloc(bodies, sizeof *c->frame);
    c->idle = calloc(bodies, sizeof *c->idle);
    c->slots = calloc(rows, sizeof *c->slots);
    c->mass = calloc(6*bodies, sizeof *c->mass);
    c->sum = malloc(6*(size_t)c->s.n_side*sizeof *c->sum);
    c->bend = malloc((size_t)c->s.n_term*LW_SPACE_BENDS*sizeof *c->bend);
    if (!c->frame || !c->idle || !c->slots || !c->mass || !c->sum || !c->bend)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    c->n_idle = lw_space_idle(&c->s, true, c->idle);
    if (!every_freedom_is_driven(c))
        c->n_idle = keep_exact_spins(c, c->idle, c->n_idle);
    weigh_spins(c);
    for (int j = 0; j < c->s.n_joint; j++)
        for (int k = 0; k < lw_spatial_kind_of(c->s.joint[j].kind)->rows; k++) {
            lw_space_slots *t = &c->slots[c->s.joint[j].row + k];
            t->joint = j;
            set_slots(t, c->s.joint[j].body, lw_space_row_turns(&c->s, j, k));
        }
    c->n_slot = LW_ROW_BLOCKS;
    for (int i = 0; i < c->s.n_coupling; i++) {
        c->slots[c->s.n_joint_row + i].joint = -1;
        c->n_slot = c->s.coupling[i].n_part > c->n_slot ? c->s.coupling[i].n_part : c->n_slot;
    }
    for (int i = 0; i < c->n_idle; i++)
        put_spin(c, i);
    return lw_flying_make(&c->s, &c->flying, e);
}

void lw_spatial_scene_hold(lw_spatial_scene *c, int body, lw_vec3 axis)
{
    c->idle[c->n_idle] = (lw_space_extra){ .spin = true, .body = body, .axis = axis };
    put_spin(c, c->n_idle++);
}

void lw_spatial_scene_free(lw_spatial_scene *c)
{
    if (c->follow.memory)
        lw_space_follow_free(&c->follow);
    lw_space_dense_free(&c->drives_least);
    lw_space_rows_free(&c->drives);
    free(c->drive_l);
    free(c->drive_f);
    free(c->joint);
    free(c->pull);
    lw_flying_free(&c->flying);
    free(c->frame);
    free(c->idle);
    free(c->slots);
    free(c->sum);
    free(c->bend);
    free(c->mass);
    lw_space_forces_free(&c->f);
    lw_space_free(&c->s);
    *c = (lw_spatial_scene){ 0 };
}

/* ---- measures ---------------------------------------------------------------------------------------------- */

int lw_spatial_number(const lw_spatial_scene *c, lw_spatial_measure of)
{
    return of.of < LW_OF_X ? 2*of.index + (of.of == LW_OF_SLIDE) : 2*c->s.n_joint + 3*of.index + (int)(of.of - LW_OF_X);
}

lw_spatial_measure lw_spatial_numbered(const lw_spatial_scene *c, int number)
{
    int tracer = number - 2*c->s.n_joint;
    return tracer < 0 ? (lw_spatial_measure){ number%2 ? LW_OF_SLIDE : LW_OF_TURN, number/2 }
                      : (lw_spatial_measure){ (lw_spatial_of)(LW_OF_X + tracer%3), tracer/3 };
}

static lw_space_slots measure_slots(const lw_spatial_scene *c, lw_spatial_measure of)
{
    lw_space_slots t = { 0 };
    int body[2];
    lw_space_bodies(&c->s, &(lw_space_extra){ .measure = of }, body);
    set_slots(&t, body, of.of == LW_OF_TURN);
    return t;
}

static void put_blocks(const lw_space_slots *t, int *block)
{
    for (int k = 0; k < LW_ROW_BLOCKS; k++)
        block[k] = k < t->n ? t->block[k] : -1;
}

static int block_of_part(const lw_space_coupling *p, int k) { return 2*p->body[p->part[k]/2] + p->part[k]%2; }

static void row_blocks(void *context, int row, int *block)
{
    const lw_spatial_scene *c = context;
    int i = row - c->s.n_joint_row;
    bool couples = i >= 0 && i < c->s.n_coupling;
    for (int k = 0; k < c->n_slot; k++)
        block[k] = couples && k < c->s.coupling[i].n_part ? block_of_part(&c->s.coupling[i], k) : -1;
    if (!couples)
        put_blocks(&c->slots[row], block);
}

static void measure_blocks(void *context, int measure, int *block)
{
    const lw_spatial_scene *c = context;
    lw_space_slots t = measure_slots(c, lw_spatial_numbered(c, measure));
    put_blocks(&t, block);
}

static double measure(void *context, int number, double *row, const int *block)
{
    const lw_spatial_scene *c = context;
    lw_spatial_measure of = lw_spatial_numbered(c, number);
    lw_space_slots t = measure_slots(c, of);
    double jac[LW_SPACE_ROW];
    (void)block;                             /* they are those of measure_blocks */
    double value = lw_space_measure(&c->s, c->frame, of, of.of == LW_OF_TURN ? c->f.turn[of.index] : 0, jac);
    for (int k = 0; k < t.n; k++)
        for (int i = 0; i < LW_BLOCK; i++)
            row[LW_BLOCK*k + i] += jac[t.from[k] + i];
    return value;
}

static double measure_unit(void *context, int number)
{
    const lw_spatial_scene *c = context;
    return lw_space_scale(&c->s, lw_spatial_numbered(c, number));
}

static double measure_bias(void *context, int number, const double *v)
{
    const lw_spatial_scene *c = context;
    return lw_space_measure_bias(&c->s, c->frame, lw_spatial_numbered(c, number), v);
}

static lw_status prescribed(void *context, int input, double t, double out[3])
{
    const lw_spatial_scene *c = context;
    const lw_spatial_input *in = &c->model->input[input];
    double series[3] = { lw_spatial_offset(in), 0, 0 }, scale = lw_space_scale(&c->s, in->measure);
    const double at[3] = { t, 1, 0 };
    if (in->motion)
        lw_expression_series(in->motion, 2, at, series);
    out[0] = (series[0] - lw_spatial_offset(in))/scale, out[1] = series[1]/scale, out[2] = 2*series[2]/scale;
    return isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]) ? LW_OK : LW_E_NUMERIC;
}

/* ---- rows --------------------------------------------------------------------------------------------------- */

static void place(void *context, const double *q)
{
    const lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
}

static void rows(void *context, double *phi, double *jac, int *block)
{
    const lw_spatial_scene *c = context;
    int size = LW_BLOCK*c->n_slot;
    (void)block;
    _Static_assert(LW_ROW_SIZE == LW_SPACE_ROW, "rows of two bodies fill rows of the layer");
    lw_space_rows(&c->s, c->frame, phi, jac);
    for (int r = c->s.n_joint_row - 1; size > LW_SPACE_ROW && r >= 0; r--) {     /* to where they belong, the last one first */
        memmove(jac + r*size, jac + r*LW_SPACE_ROW, LW_SPACE_ROW*sizeof *jac);
        memset(jac + r*size + LW_SPACE_ROW, 0, (size_t)(size - LW_SPACE_ROW)*sizeof *jac);
    }
    for (int r = 0; r < c->s.n_joint_row; r++) {
        double *to = jac + r*size;
        const lw_space_slots *t = &c->slots[r];
        for (int k = 0; k < t->n; k++)
            if (t->from[k] > LW_BLOCK*k)
                memcpy(to + LW_BLOCK*k, to + t->from[k], LW_BLOCK*sizeof *to);
    }
    for (int i = 0, r = c->s.n_joint_row; i < c->s.n_coupling; i++, r++) {
        const lw_space_coupling *p = &c->s.coupling[i];
        lw_space_coupling_row(&c->s, i, c->frame, c->f.turn, &phi[r], c->sum);
        for (int k = 0; k < p->n_part; k++)
            memcpy(jac + r*size + LW_BLOCK*k, c->sum + LW_BLOCK*p->part[k], LW_BLOCK*sizeof *jac);
    }
    for (int i = 0; i < c->n_idle; i++) {
        double *to = jac + (c->s.n_row + i)*size;
        lw_vec3 axis = c->idle[i].axis;
        phi[c->s.n_row + i] = 0;
        to[0] = axis.x, to[1] = axis.y, to[2] = axis.z;
    }
}

static void bias(void *context, const double *v, double *out)
{
    const lw_spatial_scene *c = context;
    lw_space_bias(&c->s, c->frame, v, out);
}

static int bends(void *context, int row, lw_bend *out)
{
    const lw_spatial_scene *c = context;
    int joint = c->slots[row].joint, n = joint >= 0 ? lw_space_row_bends(&c->s, c->frame, joint, row - c->s.joint[joint].row, c->bend)
          : row < c->s.n_row ? lw_space_coupling_bends(&c->s, c->frame, row - c->s.n_joint_row, c->bend) : 0;
    for (int i = 0; i < n; i++)
        out[i] = (lw_bend){ c->bend[i].a, c->bend[i].b, c->bend[i].h };
    return n;
}

static int measure_bends(void *context, int number, lw_bend *out)
{
    const lw_spatial_scene *c = context;
    lw_spatial_measure of = lw_spatial_numbered(c, number);
    double h[12][12];
    int body[2], n = 0;
    lw_space_bodies(&c->s, &(lw_space_extra){ .measure = of }, body);
    lw_space_measure_bends(&c->s, c->frame, of, h);
    for (int a = 0; a < 12; a++)
        for (int b = 0; b < 12; b++)
            if (h[a][b] != 0 && body[a/6] >= 0 && body[b/6] >= 0)
                out[n++] = (lw_bend){ 6*body[a/6] + a%6, 6*body[b/6] + b%6, h[a][b] };
    return n;
}

/* ---- forces and energies ------------------------------------------------------------------------------------- */

static void forces(void *context, double t, const double *q, const double *v, double *force, double *power)
{
    const lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_forces_apply(&c->f, t, c->frame, v, force, power, NULL);
}

static void derivatives(void *context, double t, const double *q, const double *v, double *force, const lw_force_sink *sink)
{
    const lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_forces_apply(&c->f, t, c->frame, v, force, NULL, &(lw_space_sink){ sink->context, sink->add, sink->add_state });
}

static void foresee(void *context, const double *q, const double *by)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_foresee(&c->f, c->frame, by);
}

static void more_mass(void *context, const double *q, const lw_force_sink *sink)
{
    const lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_more_mass(&c->f, c->frame, &(lw_space_sink){ sink->context, sink->add, sink->add_state });
}

static void more_inertia(void *context, const double *q, const double *v, const double *a, double *out)
{
    const lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_more_inertia(&c->f, c->frame, v, a, out);
}

static void pattern(void *context, const lw_force_sink *sink)
{
    lw_space_forces_pattern(&((const lw_spatial_scene *)context)->f, &(lw_space_sink){ sink->context, sink->add, sink->add_state });
}

static double damper(void *context, int k, const double *q, const double *v, double *g)
{
    const lw_spatial_scene *c = context;
    (void)v;
    lw_space_place(&c->s, q, c->frame);
    return lw_space_damper(&c->f, k, c->frame, g);
}

/* ---- friction ------------------------------------------------------------------------------------------------- */

/* A push along a measure; returns its power. */
static double push_along(const lw_spatial_scene *c, lw_spatial_measure of, double push, const double *v, double *force)
{
    double jac[LW_SPACE_ROW], scale = lw_space_scale(&c->s, of), rate = 0;
    int body[2];
    lw_space_bodies(&c->s, &(lw_space_extra){ .measure = of }, body);
    lw_space_measure(&c->s, c->frame, of, of.of == LW_OF_TURN ? c->f.turn[of.index] : 0, jac);
    for (int a = 0; a < LW_SPACE_ROW; a++)
        if (body[a/6] >= 0) {
            int at = 6*body[a/6] + a%6;
            rate += scale*jac[a]*v[at];
            force[at] += push*scale*jac[a];
        }
    return push*rate;
}

/* A torque on body 1, from body 0; returns its power. */
static double push_torque(const lw_spatial_scene *c, const int body[2], lw_vec3 torque, const double *v, double *force)
{
    double power = 0;
    for (int k = 0; k < 2; k++) {
        if (body[k] < 0)
            continue;
        lw_vec3 own = lw_v3_scale(lw_m3_unapply(&c->frame[body[k] + 1].turn, torque), k ? 1 : -1);
        double *to = force + 6*body[k] + 3;
        const double *w = v + 6*body[k] + 3;
        to[0] += own.x, to[1] += own.y, to[2] += own.z;
        power += own.x*w[0] + own.y*w[1] + own.z*w[2];
    }
    return power;
}

double lw_spatial_rub(const lw_spatial_scene *c, const lw_friction_joint *f, const double *v, double size, double *force)
{
    const lw_space_joint *j = &c->s.joint[f->joint];
    double rate[2], value, slip, push;
    const lw_spatial_measure of[2] = { { LW_OF_TURN, f->joint }, { LW_OF_SLIDE, f->joint } };
    lw_vec3 w = lw_v3_sub(lw_space_omega(c->frame, j->body[1], v), lw_space_omega(c->frame, j->body[0], v));
    switch (j->kind) {
    case LW_SPATIAL_REVOLUTE:
    case LW_SPATIAL_PRISMATIC: {
        const lw_spatial_measure *one = &of[j->kind == LW_SPATIAL_PRISMATIC];
        lw_space_measured(&c->s, c->frame, *one, 0, v, &value, rate);
        return push_along(c, *one, size*lw_friction_push(f, rate[0]), v, force);
    }
    case LW_SPATIAL_CYLINDRICAL:
        for (int k = 0; k < 2; k++)
            lw_space_measured(&c->s, c->frame, of[k], 0, v, &value, &rate[k]);
        slip = hypot(f->lever_arm*rate[0], rate[1]);
        push = -size*f->coefficient*(slip > 1e-9*f->speed ? tanh(slip/f->speed)/slip : 1/f->speed);
        return push_along(c, of[0], push*f->lever_arm*f->lever_arm*rate[0], v, force) + push_along(c, of[1], push*rate[1], v, force);
    case LW_SPATIAL_SPHERICAL:
        slip = f->lever_arm*lw_v3_norm(w);
        push = -size*f->coefficient*f->lever_arm*f->lever_arm*(slip > 1e-9*f->speed ? tanh(slip/f->speed)/slip : 1/f->speed);
        return push_torque(c, j->body, lw_v3_scale(w, push), v, force);
    case LW_SPATIAL_UNIVERSAL: {             /* rates about a and b are those along a*, b*, with a*.a = 1, a*.b = 0 */
        lw_vec3 a = lw_m3_apply(&c->frame[j->body[0] + 1].turn, j->x[0]), b = lw_m3_apply(&c->frame[j->body[1] + 1].turn, j->x[1]);
        double dot = lw_v3_dot(a, b), wide = 1/(1 - dot*dot);
        lw_vec3 dual[2] = { lw_v3_scale(lw_v3_sub(a, lw_v3_scale(b, dot)), wide), lw_v3_scale(lw_v3_sub(b, lw_v3_scale(a, dot)), wide) };
        value = 0;
        for (int k = 0; k < 2; k++)
            value += push_torque(c, j->body, lw_v3_scale(dual[k], size*lw_friction_push(f, lw_v3_dot(dual[k], w))), v, force);
        return value;
    }
    default:
        return 0;
    }
}

static void expressions(void *context, lw_expression_sink *see, void *of)
{
    const lw_spatial *m = ((const lw_spatial_scene *)context)->model;
    for (int i = 0; i < m->n_input; i++)
        see(of, m->input[i].motion);
    for (int i = 0; i < m->n_spring; i++)
        see(of, m->spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        see(of, m->joint_spring[i].law);
    for (int i = 0; i < m->n_force; i++)
        for (int k = 0; k < 3; k++) {
            see(of, m->force[i].force[k]);
            see(of, m->force[i].torque[k]);
        }
    lw_states_expressions(&m->states, see, of);
}

static double piece_left(void *context, const double *q)
{
    const lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    return lw_space_piece_left(&c->f, c->frame);
}

static void next_piece(void *context, const double *q, const double *v, bool start)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_next_piece(&c->f, c->frame, v, start);
}

static void watch(void *context, double t, const double *q, const double *v, bool first)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_watch_contacts(&c->f, c->frame, v, t, first);
}

static void place_states(void *context, const double *z)
{
    const lw_spatial_scene *c = context;
    for (int i = 0; i < c->model->states.n_state; i++)
        c->f.z[i] = z[i];
}

static void state_rates(void *context, double t, const double *q, const double *v, double *rate)
{
    place(context, q);
    lw_space_state_rates(&((const lw_spatial_scene *)context)->f, t, ((const lw_spatial_scene *)context)->frame, v, rate);
}

static void state_start(void *context, double t, const double *q, const double *v, double *z)
{
    place(context, q);
    lw_space_state_start(&((const lw_spatial_scene *)context)->f, t, ((const lw_spatial_scene *)context)->frame, v, z);
}

static double state_scale(void *context, int i) { return ((const lw_spatial_scene *)context)->model->states.state[i].scale; }

static double kinetic(void *context, const double *v)
{
    const lw_spatial_scene *c = context;
    return lw_space_kinetic(&c->s, v) + lw_space_more_inertia(&c->f, c->frame, v, NULL, NULL);
}

static double potential(void *context, const double *q)
{
    const lw_spatial_scene *c = context;
    return lw_space_potential(&c->f, q, c->frame);
}

/* ---- motion --------------------------------------------------------------------------------------------------- */

static void move(void *context, double *q, const double *by) { lw_space_move(&((const lw_spatial_scene *)context)->s, q, by); }

static void along(void *context, const double *by, double *rate)
{
    lw_space_along(&((const lw_spatial_scene *)context)->s, by, rate);
}

static void rates(void *context, const double *q, const double *v, double *dq)
{
    lw_space_rates(&((const lw_spatial_scene *)context)->s, q, v, dq);
}

static int column(void *context, const double *q, int i, int *at, double *by)
{
    (void)context;
    const double *p = q + 7*(i/6) + 3;
    int k = i%6 - 3;
    for (int c = 0; c < 4; c++)
        at[c] = k < 0 ? 7*(i/6) + k + 3 : 7*(i/6) + 3 + c;
    by[0] = 1;
    if (k < 0)
        return 1;
    lw_quaternion t = lw_quaternion_times((lw_quaternion){ p[0], p[1], p[2], p[3] },
                                          (lw_quaternion){ 0, 0.5*(k == 0), 0.5*(k == 1), 0.5*(k == 2) });
    by[0] = t.w, by[1] = t.x, by[2] = t.y, by[3] = t.z;
    return 4;
}

static void accept(void *context, double *q)
{
    lw_spatial_scene *c = context;
    lw_space_normalise(&c->s, q);
    lw_space_place(&c->s, q, c->frame);
    lw_space_forces_accept(&c->f, c->frame);
}

static const char *name(void *context, lw_named what, int i)
{
    const lw_spatial_scene *c = context;
    lw_spatial_measure of = what == LW_NAMED_INPUT ? c->model->input[i].measure
                          : lw_spatial_numbered(c, what == LW_NAMED_MEASURE ? i : 0);
    switch (what) {
    case LW_NAMED_BLOCK: return c->model->body[c->s.link_of[i/2]].name;
    case LW_NAMED_ROW:
        return i >= c->s.n_row ? c->model->body[c->s.link_of[c->idle[i - c->s.n_row].body]].name
             : i >= c->s.n_joint_row ? c->model->coupling[i - c->s.n_joint_row].name : c->model->joint[c->slots[i].joint].name;
    case LW_NAMED_INPUT: case LW_NAMED_MEASURE:
        return of.of < LW_OF_X ? c->model->joint[of.index].name : c->model->tracer[of.index].name;
    case LW_NAMED_STATE: return c->model->states.state[i].name;
    }
    return "";
}

static bool has_expressions(const lw_spatial_scene *c)
{
    bool any = c->model->n_force + c->model->n_spring + c->model->n_joint_spring + c->model->states.n_state > 0;
    for (int i = 0; i < c->model->n_input; i++)
        any = any || c->model->input[i].motion;
    return any;
}

static int count_stops(const lw_spatial_scene *c)
{
    int n = 0;
    for (int i = 0; i < c->model->n_joint; i++)
        n += 2*(c->model->joint[i].stop.stiffness > 0);
    return n;
}

static void values(void *context, double t, const double *q, const double *v, double *force, lw_expression_sink_at *see, void *of)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_values(&c->f, t, c->frame, v, force, see, of);
}

static void switches(void *context, double t, const double *q, const double *v, double *force, double *side)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_stop_sides(&c->f, c->frame, v, side);
    if (c->n_kink + c->n_jump > 0) {
        double *kink = side + count_stops(c);
        lw_timed_sides(values, c, t, q, v, force, kink, kink + c->n_kink);
    }
}

static void note_momenta(void *context, double t, const double *q, const double *v)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_flying_note(&c->f, c->frame, v, t, &c->flying);
}

static void keep_momenta(void *context, double t, double *q, double *v, double *rigid)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    if (c->f.held)                           /* the caller's loads change them */
        memset(rigid, 0, (size_t)c->s.n_v*sizeof *rigid);
    else
        lw_flying_hold(&c->f, t, q, c->frame, v, rigid, &c->flying);
}

lw_equations lw_spatial_equations(lw_spatial_scene *c)
{
    bool flies = c->flying.n > 0 && c->n_idle == 0;
    const lw_timed shown = { .expressions = expressions, .context = c };
    c->n_kink = lw_timed_breaks(&shown, false);
    c->n_jump = lw_timed_breaks(&shown, true);
    return (lw_equations){ .n_q = c->s.n_q, .n_v = c->s.n_v, .n_block = 2*c->s.n_body, .n_row = c->s.n_row + c->n_idle,
                           .n_slot = c->n_slot, .bend_most = c->s.n_term*LW_SPACE_BENDS,      /* of a measure 144 */
                           .n_damper = lw_space_dampers(&c->s), .mass = c->mass, .weight = c->f.weight, .unit = c->s.unit,
                           .conservative = c->f.conservative, .smooth = true, .exact = true, .context = c, .name = name,
                           .row_blocks = row_blocks, .measure_blocks = measure_blocks, .place = place, .rows = rows,
                           .measure = measure, .measure_unit = measure_unit, .bias = bias, .measure_bias = measure_bias,
                           .bends = bends, .measure_bends = measure_bends, .motion = prescribed, .forces = forces, .derivatives = derivatives,
                           .pattern = pattern, .foresee = c->model->n_beam ? foresee : NULL,
                           .more_mass = lw_space_more_mass(&c->f, NULL, NULL) ? more_mass : NULL,
                           .more_inertia = c->model->n_super ? more_inertia : NULL,
                           .damper = damper, .n_z = c->model->states.n_state, .z = c->f.z, .place_states = place_states, .state_rates = state_rates,
                           .state_start = state_start, .state_scale = state_scale,
                           .n_switch = count_stops(c) + c->n_kink + c->n_jump, .n_kink = c->n_kink, .n_jump = c->n_jump, .switches = switches,
                           .values = values,
                           .piece_left = c->model->n_contact ? piece_left : NULL,
                           .next_piece = c->model->n_contact ? next_piece : NULL,
                           .watch = c->model->n_contact ? watch : NULL, .expressions = has_expressions(c) ? expressions : NULL, .kinetic = kinetic,
                           .note_momenta = flies ? note_momenta : NULL, .keep_momenta = flies ? keep_momenta : NULL,
                           .potential = potential, .move = move, .along = along, .rates = rates, .column = column, .accept = accept };
}
