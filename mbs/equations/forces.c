/* mbs/equations/forces.c - loads on the coordinates of a system. */
#include "mbs/equations/forces.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/elastic/beam.h"

/* ---- making ------------------------------------------------------------------------------------ */

static void reach(lw_vec2 at, lw_vec2 box[2], bool *any)
{
    if (!*any)
        box[0] = box[1] = at;
    *any = true;
    box[0] = lw_v2(fmin(box[0].x, at.x), fmin(box[0].y, at.y));
    box[1] = lw_v2(fmax(box[1].x, at.x), fmax(box[1].y, at.y));
}

static double diagonal(const lw_vec2 box[2]) { return lw_v2_norm(lw_v2_sub(box[1], box[0])); }

/* Size of the model, masses included [m]; 1 for a model without extent. */
static double size_of_model(const lw_model *m)
{
    const lw_assembly *linkage = &m->linkage;
    lw_vec2 box[2] = { { 0, 0 }, { 0, 0 } };
    bool any = false;
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_has_position(linkage->joint[j].kind))
            reach(linkage->joint[j].at, box, &any);
    for (int l = 0; l < linkage->n_link; l++)
        if (l != linkage->ground && m->body[l].mass > 0)
            reach(m->body[l].centre, box, &any);
    const bool alone = !(any && diagonal(box) > 0);
    for (int i = 0; alone && i < m->n_shape; i++)            /* one free link: its outlines tell the size */
        for (int k = 0; k < m->shape[i].n && m->shape[i].link != linkage->ground; k++) {
            double r = m->shape[i].radius;
            reach(lw_v2_add(m->shape[i].at[k], lw_v2(r, r)), box, &any);
            reach(lw_v2_sub(m->shape[i].at[k], lw_v2(r, r)), box, &any);
        }
    double size = any ? 0.5*diagonal(box) : 0;
    return size > 0 ? size : 1;
}

/* Reference points of the links (n_link): centres of mass; of links without mass a joint. */
static void find_centres(const lw_model *m, lw_vec2 *centre)
{
    const lw_assembly *linkage = &m->linkage;
    for (int l = 0; l < linkage->n_link; l++)
        centre[l] = m->body[l].centre;
    for (int j = linkage->n_joint - 1; j >= 0; j--)
        for (int end = 0; end < 2; end++)
            if (!(m->body[linkage->joint[j].link[end]].mass > 0))
                centre[linkage->joint[j].link[end]] = linkage->joint[j].at;
}

lw_status lw_forces_system(const lw_model *m, bool any_size, lw_system *s, lw_error *e)
{
    const lw_assembly *linkage = &m->linkage;
    memset(s, 0, sizeof *s);
    if (m->n_elastic)
        return lw_error_set(e, LW_E_KIND, "this analysis takes no elastic links, and the model has %d; \"linkwright simulate\" "
                            "does, or make them rigid", m->n_elastic);
    if (!any_size && (m->n_contact || m->n_rope))
        return lw_error_set(e, LW_E_KIND, "contacts and ropes take part in runs in time, in prescribed motion and in statics of \"linkwright simulate\"; "
                            "this analysis knows none");
    if (!any_size && (linkage->n_link > LW_LINK_MAX || linkage->n_joint > LW_JOINT_MAX || linkage->n_input > LW_INPUT_MAX
                      || linkage->n_tracer > LW_TRACER_MAX))
        return lw_error_set(e, LW_E_KIND, "%d links and %d joints are too many for this analysis: at most %d and %d; only "
                            "dynamic runs of \"linkwright simulate\" have no limit", linkage->n_link, linkage->n_joint,
                            LW_LINK_MAX, LW_JOINT_MAX);
    lw_vec2 *centre = malloc((size_t)linkage->n_link*sizeof *centre);
    if (!centre)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    find_centres(m, centre);
    lw_status status = lw_system_assemble(linkage, centre, size_of_model(m), s, e);
    free(centre);
    return status;
}

static void make_stops(lw_forces *f)
{
    for (int j = 0; j < f->system->n_joint; j++) {
        const lw_joint_stop *p = &f->model->stop[j];
        if ((p->has_least || p->has_greatest) && p->stiffness > 0) {
            f->stop_joint[f->n_stop++] = j;
            f->conservative = f->conservative && p->damping == 0;
        }
    }
}

/* Does a law depend on its own measure and t alone? */
static bool is_own_law(const lw_expression *law)
{
    const int *which;
    int n = lw_expression_variables(law, &which);
    for (int i = 0; i < n; i++) {
        lw_quantity what = lw_variable_quantity(which[i]);
        if (what != LW_QUANTITY_LENGTH && what != LW_QUANTITY_RATE && what != LW_QUANTITY_T)
            return false;
    }
    return true;
}

lw_status lw_forces_make(const lw_model *m, const lw_system *s, const lw_caller_force *caller, lw_forces *f, lw_error *e)
{
    size_t n = (size_t)s->n_q, springs = (size_t)m->n_spring, forces = (size_t)m->n_force, beams = (size_t)m->n_beam;
    *f = (lw_forces){ .model = m, .system = s, .conservative = m->n_force == 0 && m->n_motor == 0 };
    size_t calls = caller && caller->apply ? 1 : 0, links = calls*(size_t)m->linkage.n_link;
    f->memory = calloc((2 + 3*calls)*n + 4*springs + 2*forces + 1 + beams + (size_t)m->states.n_state, sizeof *f->memory);
    f->stop_joint = calloc((size_t)s->n_joint + 1, sizeof *f->stop_joint);
    f->caller_link = calloc(links + 1, sizeof *f->caller_link);
    f->caller_load = calloc(links + 1, sizeof *f->caller_load);
    if (!f->memory || !f->stop_joint || !f->caller_link || !f->caller_load) {
        lw_forces_free(f);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    f->mass = f->memory;
    f->weight = f->mass + n;
    f->spring_arm = (lw_vec2 (*)[2])(void *)(f->weight + n);
    f->force_arm = (lw_vec2 *)(void *)(f->weight + n + 4*springs);
    f->caller_x = f->weight + n + 4*springs + 2*forces;
    f->pull = f->caller_x + 3*calls*n;
    f->z = f->pull + beams;
    for (int i = 0; i < m->n_beam; i++)
        f->pull[i] = NAN;
    for (int b = 0; b < s->n_body; b++) {
        const lw_body *body = &m->body[s->link[b]];
        f->mass[3*b] = f->mass[3*b + 1] = body->mass*s->unit*s->unit;
        f->mass[3*b + 2] = body->inertia;
        f->weight[3*b] = body->mass*m->gravity.x*s->unit;
        f->weight[3*b + 1] = body->mass*m->gravity.y*s->unit;
    }
    for (int i = 0; i < m->states.n_rotor; i++) {
        int b = s->body[m->states.rotor[i].link];
        if (lw_joint_turns(m->linkage.joint[m->states.rotor[i].joint].kind))
            f->mass[3*b + 2] += m->states.rotor[i].inertia;
        else
            for (int axis = 0; axis < 2; axis++)
                f->mass[3*b + axis] += m->states.rotor[i].inertia*s->unit*s->unit;
    }
    for (int i = 0; i < m->n_super; i++)         /* these weigh by themselves */
        for (int k = 0; k < m->super[i].n; k++) {
            int b = s->body[m->super[i].link[k]];
            f->weight[3*b] -= m->super[i].lump[k]*m->gravity.x*s->unit;
            f->weight[3*b + 1] -= m->super[i].lump[k]*m->gravity.y*s->unit;
        }
    f->coupled = m->states.n_state > 0;
    for (int i = 0; i < m->n_spring; i++) {
        f->coupled = f->coupled || (m->spring[i].law && !is_own_law(m->spring[i].law));
        for (int end = 0; end < 2; end++)
            f->spring_arm[i][end] = lw_system_arm(s, s->body[m->spring[i].link[end]], lw_v3_xy(m->spring[i].at[end]));
        f->conservative = f->conservative && !m->spring[i].law && m->spring[i].damping == 0;
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        f->coupled = f->coupled || (m->joint_spring[i].law && !is_own_law(m->joint_spring[i].law));
        f->conservative = f->conservative && !m->joint_spring[i].law && m->joint_spring[i].damping == 0;
    }
    for (int i = 0; i < m->n_force; i++)
        f->force_arm[i] = lw_system_arm(s, s->body[m->force[i].link], lw_v3_xy(m->force[i].at));
    for (int i = 0; i < m->n_beam; i++)
        f->conservative = f->conservative && m->beam[i].damping == 0;
    for (int i = 0; i < m->n_super; i++)
        f->conservative = f->conservative && m->super[i].damping == 0;
    if (lw_superelements_make(m, s, &f->superelements) != LW_OK) {
        lw_forces_free(f);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    make_stops(f);
    f->any_state = m->n_spring || m->n_joint_spring || m->n_force || m->n_motor || f->n_stop || m->n_beam || m->n_super;
    if (caller && caller->apply) {
        f->caller = *caller;
        f->conservative = false;
        f->any_state = true;
    }
    return LW_OK;
}

void lw_forces_free(lw_forces *f)
{
    free(f->memory);
    free(f->stop_joint);
    free(f->caller_link);
    free(f->caller_load);
    lw_superelements_free(&f->superelements);
    memset(f, 0, sizeof *f);
}

lw_status lw_input_motion(const lw_model *m, const lw_system *s, int i, double t, double out[3])
{
    double series[3] = { t, 1, 0 };
    double scale = 1/lw_system_joint_unit(s, s->input_joint[i]);
    lw_expression_series(m->motion[i], 2, series, out);
    out[0] = (out[0] - s->input_value[i])*scale;
    out[1] *= scale;
    out[2] *= 2*scale;
    return isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]) ? LW_OK : LW_E_NUMERIC;
}

/* ---- one load along one measure ---------------------------------------------------------------- */

/* The sums that loads add to. */
typedef struct sum { int n; double *force, *dq, *dv, power; const lw_force_sink *sink; bool second; } sum;

static inline void put(const sum *to, int row, int column, double by_q, double by_v)
{
    if (to->sink) {
        to->sink->add(to->sink->context, row, column, by_q, by_v);
        return;
    }
    to->dq[row*to->n + column] += by_q;
    to->dv[row*to->n + column] += by_v;
}

/* Add force f along m; by_value, by_rate: derivatives of f by the measure and by its rate. */
static void add(sum *to, const lw_measure *m, const double *v, double f, double by_value, double by_rate)
{
    for (int i = 0; i < 6; i++) {
        int row = 3*m->body[i/3] + i%3;
        if (m->body[i/3] < 0)
            continue;
        to->force[row] += f*m->g[i];
        for (int j = 0; to->second && j < 6; j++) {
            if (m->body[j/3] < 0)
                continue;
            int column = 3*m->body[j/3] + j%3;
            double turn = 0;                  /* rate of the gradient: (H v)_j */
            for (int k = 0; by_rate != 0 && k < 6; k++)
                turn += m->body[k/3] < 0 ? 0 : m->h[j][k]*v[3*m->body[k/3] + k%3];
            put(to, row, column, m->g[i]*(by_value*m->g[j] + by_rate*turn) + f*m->h[i][j], by_rate*m->g[i]*m->g[j]);
        }
    }
}

/* Pull of a spring with a law, and its derivatives by length and rate. */
static double law_at(const lw_forces *f, const lw_expression *law, const lw_measure *m, double t, double by[2])
{
    const int *which;
    double v[LW_EXPRESSION_VARIABLE_MAX], d[LW_EXPRESSION_VARIABLE_MAX];
    int n = lw_expression_variables(law, &which);
    for (int i = 0; i < n; i++)
        v[i] = which[i] == lw_variable(LW_QUANTITY_LENGTH, 0) ? m->value
             : which[i] == lw_variable(LW_QUANTITY_RATE, 0) ? m->rate : t;
    if (f->see)
        f->see(f->see_of, law, v);
    double pull = lw_expression_gradient(law, v, d);
    by[0] = by[1] = 0;
    for (int i = 0; i < n; i++)
        if (which[i] != lw_variable(LW_QUANTITY_T, 0))
            by[which[i] == lw_variable(LW_QUANTITY_RATE, 0)] = d[i];
    return pull;
}

/* ---- expressions --------------------------------------------------------------------------------- */

/* The measure of a variable of an expression, `own` for that of the law; *rate: the variable is the rate of it. */
static void measure_of(const lw_forces *f, int variable, const lw_measure *own, const double *q, const double *v,
                       bool second, lw_measure *m, bool *rate)
{
    const lw_system *s = f->system;
    lw_quantity what = lw_variable_quantity(variable);
    int i = lw_variable_index(variable);
    *rate = what == LW_QUANTITY_V || what == LW_QUANTITY_VX || what == LW_QUANTITY_VY || what == LW_QUANTITY_OMEGA ||
            what == LW_QUANTITY_RATE || what == LW_QUANTITY_SPRING_RATE;
    switch (what) {
    case LW_QUANTITY_Q: case LW_QUANTITY_V:
        lw_measure_joint(s, i, q, v, second, m);
        break;
    case LW_QUANTITY_ANGLE: case LW_QUANTITY_OMEGA:
        lw_measure_point(s, s->body[i], lw_v2(0, 0), 2, q, v, second, m);
        break;
    case LW_QUANTITY_LENGTH: case LW_QUANTITY_RATE:
        *m = *own;
        break;
    case LW_QUANTITY_SPRING_LENGTH: case LW_QUANTITY_SPRING_RATE: {
        const lw_spring *p = &f->model->spring[i];
        lw_measure_length(s, (int[]){ s->body[p->link[0]], s->body[p->link[1]] }, f->spring_arm[i], q, v, second, m);
        break;
    }
    default:
        lw_measure_point(s, s->tracer_body[i], s->tracer_arm[i], what == LW_QUANTITY_Y || what == LW_QUANTITY_VY, q, v, second, m);
    }
}

/* The target of an expression's value: rows `at` (-1: none) of the forces grow by it times sense, or the rate of a
 * state by it. */
typedef struct rows_of { int n, at[6]; double sense[6]; bool state; } rows_of;

static void put_column(const sum *to, const rows_of *rows, int column, double by_q, double by_v)
{
    for (int r = 0; r < rows->n; r++) {
        if (rows->at[r] < 0)
            continue;
        if (!rows->state && column < to->n)
            put(to, rows->at[r], column, rows->sense[r]*by_q, rows->sense[r]*by_v);
        else if (to->sink && to->sink->add_state)
            to->sink->add_state(to->sink->context, rows->at[r], column, rows->sense[r]*by_q, rows->sense[r]*by_v);
    }
}

/* Value of an expression, and its derivatives in the rows it acts on. */
static double evaluate(const lw_forces *f, const lw_expression *x, const lw_measure *own, double t, const double *q,
                       const double *v, const rows_of *rows, const sum *to)
{
    const int *which;
    double value[LW_EXPRESSION_VARIABLE_MAX], d[LW_EXPRESSION_VARIABLE_MAX];
    lw_measure m[LW_EXPRESSION_VARIABLE_MAX];
    bool rate[LW_EXPRESSION_VARIABLE_MAX];
    int n = lw_expression_variables(x, &which);
    for (int i = 0; i < n; i++) {
        lw_quantity what = lw_variable_quantity(which[i]);
        value[i] = what == LW_QUANTITY_STATE ? f->z[lw_variable_index(which[i])] : t;
        if (what == LW_QUANTITY_STATE || what == LW_QUANTITY_T)
            continue;
        measure_of(f, which[i], own, q, v, to->second, &m[i], &rate[i]);
        value[i] = rate[i] ? m[i].rate : m[i].value;
    }
    if (f->see)
        f->see(f->see_of, x, value);
    if (!to->second)
        return lw_expression_value(x, value);
    double result = lw_expression_gradient(x, value, d);
    for (int i = 0; i < n; i++) {
        lw_quantity what = lw_variable_quantity(which[i]);
        if (what == LW_QUANTITY_STATE)
            put_column(to, rows, to->n + lw_variable_index(which[i]), d[i], 0);
        if (what == LW_QUANTITY_STATE || what == LW_QUANTITY_T)
            continue;
        for (int j = 0; j < 6; j++) {
            if (m[i].body[j/3] < 0)
                continue;
            double by_q = m[i].g[j], by_v = 0;
            if (rate[i]) {
                by_v = by_q;
                by_q = 0;
                for (int k = 0; k < 6; k++)
                    by_q += m[i].body[k/3] < 0 ? 0 : m[i].h[j][k]*v[3*m[i].body[k/3] + k%3];
            }
            put_column(to, rows, 3*m[i].body[j/3] + j%3, d[i]*by_q, d[i]*by_v);
        }
    }
    return result;
}

/* Add a law of other quantities than the measure m along which it pushes: `sense` times its value.  Returns that. */
static double add_law(const lw_forces *f, const lw_expression *law, double sense, const lw_measure *m, double t,
                      const double *q, const double *v, sum *to)
{
    rows_of rows = { .n = 6 };
    for (int i = 0; i < 6; i++) {
        rows.at[i] = m->body[i/3] < 0 ? -1 : 3*m->body[i/3] + i%3;
        rows.sense[i] = sense*m->g[i];
    }
    double push = sense*evaluate(f, law, m, t, q, v, &rows, to);
    add(to, m, v, push, 0, 0);
    return push;
}

/* ---- springs, stops, motors ------------------------------------------------------------------------ */

static void apply_springs(const lw_forces *f, double t, const double *q, const double *v, sum *to)
{
    lw_measure m;
    double by[2];
    for (int i = 0; i < f->model->n_spring; i++) {
        const lw_spring *p = &f->model->spring[i];
        int body[2] = { f->system->body[p->link[0]], f->system->body[p->link[1]] };
        lw_measure_length(f->system, body, f->spring_arm[i], q, v, to->second, &m);
        if (p->law && f->coupled) {
            to->power += add_law(f, p->law, -1, &m, t, q, v, to)*m.rate;
        } else if (p->law) {
            double pull = law_at(f, p->law, &m, t, by);
            add(to, &m, v, -pull, -by[0], -by[1]);
            to->power -= pull*m.rate;
        } else {
            add(to, &m, v, -p->stiffness*(m.value - p->free) - p->damping*m.rate, -p->stiffness, -p->damping);
            to->power -= p->damping*m.rate*m.rate;
        }
    }
    for (int i = 0; i < f->model->n_joint_spring; i++) {
        const lw_joint_spring *p = &f->model->joint_spring[i];
        lw_measure_joint(f->system, p->joint, q, v, to->second, &m);
        if (p->law && f->coupled) {
            to->power += add_law(f, p->law, 1, &m, t, q, v, to)*m.rate;
        } else if (p->law) {
            double push = law_at(f, p->law, &m, t, by);
            add(to, &m, v, push, by[0], by[1]);
            to->power += push*m.rate;
        } else {
            add(to, &m, v, -p->stiffness*(m.value - p->free) - p->damping*m.rate, -p->stiffness, -p->damping);
            to->power -= p->damping*m.rate*m.rate;
        }
    }
}

/* Depth of a joint beyond the nearer end of its stop, < 0 before it; *sense: direction of the push. */
static double depth(const lw_joint_stop *p, double value, double *sense)
{
    double least = p->has_least ? p->least - value : -INFINITY, greatest = p->has_greatest ? value - p->greatest : -INFINITY;
    *sense = least > greatest ? 1 : -1;
    return fmax(least, greatest);
}

/* The damper of a stop pushes but does not pull. */
static void apply_stops(const lw_forces *f, const double *q, const double *v, sum *to)
{
    lw_measure m;
    for (int i = 0; i < f->n_stop; i++) {
        const lw_joint_stop *p = &f->model->stop[f->stop_joint[i]];
        double sense;
        lw_measure_joint(f->system, f->stop_joint[i], q, v, to->second, &m);
        double in = depth(p, m.value, &sense), push = p->stiffness*in - sense*p->damping*m.rate;
        if (!(in > 0))
            continue;
        bool held = push > 0;
        add(to, &m, v, held ? sense*push : 0, held ? -p->stiffness : 0, held ? -p->damping : 0);
        to->power += held ? -p->damping*m.rate*m.rate : -sense*p->stiffness*in*m.rate;
    }
}

void lw_forces_stop_sides(const lw_forces *f, const double *q, const double *v, double *side)
{
    lw_measure m;
    for (int i = 0; i < f->n_stop; i++) {
        const lw_joint_stop *p = &f->model->stop[f->stop_joint[i]];
        double sense;
        lw_measure_joint(f->system, f->stop_joint[i], q, v, false, &m);
        double in = depth(p, m.value, &sense);
        side[2*i] = in;
        side[2*i + 1] = p->stiffness*in - (in > 0 ? sense*p->damping*m.rate : 0);
    }
}

static void apply_motors(const lw_forces *f, const double *q, const double *v, sum *to)
{
    lw_measure m;
    for (int i = 0; i < f->model->n_motor; i++) {
        const lw_motor *p = &f->model->motor[i];
        lw_measure_joint(f->system, p->joint, q, v, to->second, &m);
        double torque = p->stall*(1 - m.rate/p->free_speed);
        add(to, &m, v, torque, 0, -p->stall/p->free_speed);
        to->power += torque*m.rate;
    }
}

/* ---- applied forces ---------------------------------------------------------------------------- */

/* Add component c (0, 1: of the force; 2: the torque) of an applied force.  Q = value sense, and sense turns with
 * the link. */
static void apply_component(const lw_forces *f, int i, int c, const lw_expression *x, double t, const double *q, const double *v, sum *to)
{
    const lw_force *p = &f->model->force[i];
    int body = f->system->body[p->link], turn = 3*body + 2;
    rows_of rows = { .n = 3, .at = { 3*body, 3*body + 1, turn }, .sense = { 0, 0, 1 } };
    double unit = f->system->unit, *sense = rows.sense, dway[3] = { 0, 0, 0 };
    const int *at = rows.at;
    if (!x || body < 0)
        return;
    lw_vec2 u = lw_v2_polar(1, q[turn]), w = lw_v2(c == 0, c == 1), r = lw_v2_turn(f->force_arm[i], u);
    if (c < 2) {
        w = p->follows ? lw_v2_turn(w, u) : w;
        lw_vec2 dw = p->follows ? lw_v2_perp(w) : lw_v2(0, 0);
        sense[0] = unit*w.x;
        sense[1] = unit*w.y;
        sense[2] = unit*lw_v2_cross(r, w);
        dway[0] = unit*dw.x;
        dway[1] = unit*dw.y;
        dway[2] = unit*(lw_v2_cross(lw_v2_perp(r), w) + lw_v2_cross(r, dw));
    }
    double value = evaluate(f, x, NULL, t, q, v, &rows, to);
    for (int r3 = 0; r3 < 3; r3++) {
        to->force[at[r3]] += value*sense[r3];
        to->power += value*sense[r3]*v[at[r3]];
        if (to->second)
            put(to, at[r3], turn, value*dway[r3], 0);
    }
}

lw_vec2 lw_forces_applied(const lw_forces *f, int i, double t, const double *q, const double *v, double *moment)
{
    const lw_force *p = &f->model->force[i];
    const lw_expression *x[3] = { p->force[0], p->force[1], p->torque[2] };
    int body = f->system->body[p->link];
    double value[3];
    for (int k = 0; k < 3; k++)
        value[k] = x[k] ? evaluate(f, x[k], NULL, t, q, v, NULL, &(sum){ .n = f->system->n_q }) : 0;
    lw_vec2 u = body < 0 ? lw_v2(1, 0) : lw_v2_polar(1, q[3*body + 2]), force = lw_v2(value[0], value[1]);
    force = p->follows ? lw_v2_turn(force, u) : force;
    *moment = value[2] + f->system->unit*lw_v2_cross(lw_v2_turn(f->force_arm[i], u), force);
    return force;
}

bool lw_forces_caller_exact(const lw_forces *f) { return !f->caller.apply || f->system->n_q <= LW_SYSTEM_Q_MAX; }

/* Adds the generalised forces of the caller's loads; returns their power [W]. */
static double add_caller(const lw_forces *f, double t, const double *q, const double *v, double *force)
{
    const lw_system *s = f->system;
    lw_link_motion *link = f->caller_link;
    lw_link_load *load = f->caller_load;
    double power = 0;
    memset(load, 0, (size_t)f->model->linkage.n_link*sizeof *load);
    for (int b = 0; b < s->n_body; b++)
        link[s->link[b]] = (lw_link_motion){ lw_system_point(s, b, lw_v2(0, 0), q),
                                             lw_v2_scale(lw_v2(v[3*b], v[3*b + 1]), s->unit), q[3*b + 2], v[3*b + 2] };
    f->caller.apply(f->caller.context, t, link, load);
    for (int b = 0; b < s->n_body; b++) {
        const lw_link_load *p = &load[s->link[b]];
        double own[3] = { p->force.x*s->unit, p->force.y*s->unit, p->torque };
        for (int i = 0; i < 3; i++) {
            force[3*b + i] += own[i];
            power += own[i]*v[3*b + i];
        }
    }
    return power;
}

/* Adds the derivatives of the caller's loads by q or v: central differences.  In large models all links are moved at once, and each
 * load counts as one of its own link's motion. */
static void add_caller_derivatives(const lw_forces *f, double t, const double *q, const double *v, bool by_rate, const sum *to)
{
    const double step = 1e-6;                /* the error is about its square */
    int n = to->n, passes = lw_forces_caller_exact(f) ? n : 3;
    double *x = f->caller_x, *side[2] = { x + n, x + 2*n };
    for (int pass = 0; pass < passes; pass++) {
        for (int k = 0; k < 2; k++) {
            memcpy(x, by_rate ? v : q, (size_t)n*sizeof *x);
            memset(side[k], 0, (size_t)n*sizeof *side[k]);
            for (int column = pass; column < n; column += passes)
                x[column] += k ? step : -step;
            add_caller(f, t, by_rate ? q : x, by_rate ? x : v, side[k]);
        }
        for (int column = pass; column < n; column += passes)
            for (int row = passes < n ? column - pass : 0, i = 0; i < passes; i++, row++) {
                double slope = (side[1][row] - side[0][row])/(2*step);
                put(to, row, column, by_rate ? 0 : slope, by_rate ? slope : 0);
            }
    }
}

/* Coordinates of the nodes of a beam element in m and rad, and their rates. */
static void beam_nodes(const lw_forces *f, const lw_beam *b, const double *q, const double *v, double x[6], double rate[6])
{
    for (int i = 0; i < 6; i++) {
        int at = 3*f->system->body[b->link[i/3]] + i%3;
        double unit = i%3 == 2 ? 1 : f->system->unit;
        x[i] = unit*q[at];
        rate[i] = unit*v[at];
    }
}

void lw_forces_beam(const lw_forces *f, int beam, const double *q, const double *v, bool derivatives, lw_beam_state *out)
{
    double x[6], rate[6];
    beam_nodes(f, &f->model->beam[beam], q, v, x, rate);
    lw_beam_at(&f->model->beam[beam], x, rate, derivatives, isnan(f->pull[beam]) ? NULL : &f->pull[beam], out);
}

void lw_forces_foresee(const lw_forces *f, const double *q, const double *by)
{
    lw_beam_state z;
    for (int i = 0; i < f->model->n_beam; i++) {
        if (by)
            lw_forces_beam(f, i, q, by, false, &z);
        f->pull[i] = by ? f->model->beam[i].stiffness[0]*(z.e[0] + z.rate[0]) : NAN;
    }
}

static void apply_beams(const lw_forces *f, const double *q, const double *v, sum *to)
{
    lw_beam_state z;
    for (int k = 0; k < f->model->n_beam; k++) {
        const lw_beam *b = &f->model->beam[k];
        int first[2] = { 3*f->system->body[b->link[0]], 3*f->system->body[b->link[1]] };
        lw_forces_beam(f, k, q, v, to->second, &z);
        for (int i = 0; i < 6; i++) {
            double unit = i%3 == 2 ? 1 : f->system->unit;
            to->force[first[i/3] + i%3] += unit*z.force[i];
            for (int j = 0; to->second && j < 6; j++) {
                double both = unit*(j%3 == 2 ? 1 : f->system->unit);
                put(to, first[i/3] + i%3, first[j/3] + j%3, both*z.by_x[i][j], both*z.by_v[i][j]);
            }
        }
        for (int i = 0; i < 3; i++)
            to->power -= b->stiffness[i]*b->damping*z.rate[i]*z.rate[i];
    }
}

static void add_entry(void *context, int row, int column, double by_q, double by_v) { put(context, row, column, by_q, by_v); }

static void apply_all(const lw_forces *f, double t, const double *q, const double *v, sum *to)
{
    memcpy(to->force, f->weight, (size_t)to->n*sizeof *to->force);
    if (!f->any_state)
        return;
    apply_springs(f, t, q, v, to);
    apply_stops(f, q, v, to);
    apply_motors(f, q, v, to);
    apply_beams(f, q, v, to);
    lw_superelements_forces(&f->superelements, q, v, to->force, &to->power, to->second ? &(lw_force_sink){ .context = to, .add = add_entry } : NULL);
    for (int i = 0; i < f->model->n_force; i++) {
        apply_component(f, i, 0, f->model->force[i].force[0], t, q, v, to);
        apply_component(f, i, 1, f->model->force[i].force[1], t, q, v, to);
        apply_component(f, i, 2, f->model->force[i].torque[2], t, q, v, to);
    }
}

void lw_forces_apply(const lw_forces *f, double t, const double *q, const double *v, double *force, double *dq, double *dv, double *power)
{
    int n = f->system->n_q;
    sum to = { .n = n, .force = force, .dq = dq, .dv = dv, .second = dq != NULL };
    if (dq)
        memset(dq, 0, (size_t)n*(size_t)n*sizeof *dq);
    if (dv)
        memset(dv, 0, (size_t)n*(size_t)n*sizeof *dv);
    apply_all(f, t, q, v, &to);
    if (f->caller.apply) {
        to.power += add_caller(f, t, q, v, force);
        for (int by_rate = 0; dq && by_rate < 2; by_rate++)
            add_caller_derivatives(f, t, q, v, by_rate, &to);
    }
    if (power)
        *power = to.power;
}

void lw_forces_derivatives(const lw_forces *f, double t, const double *q, const double *v, double *force, const lw_force_sink *sink)
{
    sum to = { .n = f->system->n_q, .force = force, .sink = sink, .second = true };
    apply_all(f, t, q, v, &to);
    if (f->caller.apply)
        add_caller(f, t, q, v, force);
    for (int by_rate = 0; f->caller.apply && by_rate < 2; by_rate++)
        add_caller_derivatives(f, t, q, v, by_rate, &to);
    for (int i = 0; sink->add_state && i < f->model->states.n_state; i++)
        evaluate(f, f->model->states.state[i].rate, NULL, t, q, v, &(rows_of){ 1, { to.n + i }, { 1 }, true }, &to);
}

void lw_forces_values(const lw_forces *f, double t, const double *q, const double *v, double *force, lw_expression_sink_at *see, void *of)
{
    lw_forces noting = *f;
    noting.see = see;
    noting.see_of = of;
    sum to = { .n = f->system->n_q, .force = force };
    apply_all(&noting, t, q, v, &to);
    for (int i = 0; i < f->model->states.n_state; i++)
        evaluate(&noting, f->model->states.state[i].rate, NULL, t, q, v, NULL, &to);
}

/* ---- states -------------------------------------------------------------------------------------- */

void lw_forces_state_rates(const lw_forces *f, double t, const double *q, const double *v, double *rate)
{
    for (int i = 0; i < f->model->states.n_state; i++)
        rate[i] = evaluate(f, f->model->states.state[i].rate, NULL, t, q, v, NULL, &(sum){ .n = f->system->n_q });
}

void lw_forces_state_start(const lw_forces *f, double t, const double *q, const double *v, double *z)
{
    for (int i = 0; i < f->model->states.n_state; i++)
        z[i] = f->z[i] = f->model->states.state[i].start;
    for (int i = 0; i < f->model->states.n_state; i++)
        if (f->model->states.state[i].start_at)
            z[i] = f->z[i] = evaluate(f, f->model->states.state[i].start_at, NULL, t, q, v, NULL, &(sum){ .n = f->system->n_q });
}

double lw_forces_signal(const lw_forces *f, int i, double t, const double *q, const double *v)
{
    return evaluate(f, f->model->states.signal[i].value, NULL, t, q, v, NULL, &(sum){ .n = f->system->n_q });
}

/* All coordinates of body a by all of body b. */
static void add_block(const lw_force_sink *sink, int a, int b)
{
    for (int i = 0; a >= 0 && b >= 0 && i < 9; i++)
        sink->add(sink->context, 3*a + i/3, 3*b + i%3, 1, 1);
}

static void add_pair(const lw_force_sink *sink, const int body[2])
{
    for (int i = 0; i < 4; i++)
        add_block(sink, body[i/2], body[i%2]);
}

/* The bodies that a variable of an expression measures, -1: none. */
static void bodies_of(const lw_forces *f, int variable, int body[2])
{
    const lw_system *s = f->system;
    int k = lw_variable_index(variable);
    body[0] = body[1] = -1;
    switch (lw_variable_quantity(variable)) {
    case LW_QUANTITY_Q: case LW_QUANTITY_V:
        body[0] = s->joint[k].body[0];
        body[1] = s->joint[k].body[1];
        break;
    case LW_QUANTITY_SPRING_LENGTH: case LW_QUANTITY_SPRING_RATE:
        body[0] = s->body[f->model->spring[k].link[0]];
        body[1] = s->body[f->model->spring[k].link[1]];
        break;
    case LW_QUANTITY_ANGLE: case LW_QUANTITY_OMEGA:
        body[0] = s->body[k];
        break;
    case LW_QUANTITY_X: case LW_QUANTITY_Y: case LW_QUANTITY_VX: case LW_QUANTITY_VY:
        body[0] = s->tracer_body[k];
        break;
    case LW_QUANTITY_T: case LW_QUANTITY_LENGTH: case LW_QUANTITY_RATE: case LW_QUANTITY_STATE: case LW_QUANTITY_S:
    case LW_QUANTITY_VS: case LW_QUANTITY_Z: case LW_QUANTITY_VZ:
        break;
    }
}

/* An expression that acts on two bodies (-1: none), or (state >= 0) is the rate of a state. */
static void add_expression(const lw_forces *f, const int acts_on[2], int state, const lw_expression *x, const lw_force_sink *sink)
{
    const int *which;
    int n = x ? lw_expression_variables(x, &which) : 0, n_q = f->system->n_q, row[6], rows = 0;
    for (int i = 0; state < 0 && i < 6; i++)
        if (acts_on[i/3] >= 0)
            row[rows++] = 3*acts_on[i/3] + i%3;
    if (state >= 0)
        row[rows++] = n_q + state;
    for (int i = 0; i < n; i++) {
        int body[2];
        bodies_of(f, which[i], body);
        if (lw_variable_quantity(which[i]) == LW_QUANTITY_STATE)
            for (int r = 0; r < rows && sink->add_state; r++)
                sink->add_state(sink->context, row[r], n_q + lw_variable_index(which[i]), 1, 1);
        for (int c = 0; c < 6; c++)
            for (int r = 0; r < rows && body[c/3] >= 0; r++) {
                if (state < 0)
                    sink->add(sink->context, row[r], 3*body[c/3] + c%3, 1, 1);
                else if (sink->add_state)
                    sink->add_state(sink->context, row[r], 3*body[c/3] + c%3, 1, 1);
            }
    }
}

void lw_forces_pattern(const lw_forces *f, const lw_force_sink *sink)
{
    const lw_system *s = f->system;
    const lw_model *m = f->model;
    for (int a = 0; f->caller.apply && a < s->n_body; a++)
        for (int b = 0; b < s->n_body; b++)
            if (a == b || lw_forces_caller_exact(f))
                add_block(sink, a, b);
    for (int i = 0; i < m->n_spring; i++) {
        int body[2] = { s->body[m->spring[i].link[0]], s->body[m->spring[i].link[1]] };
        add_pair(sink, body);
        add_expression(f, body, -1, m->spring[i].law, sink);
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        add_pair(sink, s->joint[m->joint_spring[i].joint].body);
        add_expression(f, s->joint[m->joint_spring[i].joint].body, -1, m->joint_spring[i].law, sink);
    }
    for (int i = 0; i < m->states.n_state; i++)
        add_expression(f, NULL, i, m->states.state[i].rate, sink);
    for (int i = 0; i < f->n_stop; i++)
        add_pair(sink, s->joint[f->stop_joint[i]].body);
    for (int i = 0; i < m->n_motor; i++)
        add_pair(sink, s->joint[m->motor[i].joint].body);
    for (int i = 0; i < m->n_beam; i++)
        add_pair(sink, (int[]){ s->body[m->beam[i].link[0]], s->body[m->beam[i].link[1]] });
    lw_superelements_pattern(&f->superelements, sink);
    for (int i = 0; i < m->n_force; i++) {
        int body[2] = { s->body[m->force[i].link], -1 };
        add_block(sink, body[0], body[0]);
        add_expression(f, body, -1, m->force[i].force[0], sink);
        add_expression(f, body, -1, m->force[i].force[1], sink);
        add_expression(f, body, -1, m->force[i].torque[2], sink);
    }
}

/* ---- energies ---------------------------------------------------------------------------------- */

double lw_forces_kinetic(const lw_forces *f, const double *v)
{
    double twice = 0;
    for (int i = 0; i < f->system->n_q; i++)
        twice += f->mass[i]*v[i]*v[i];
    return 0.5*twice;
}

double lw_forces_strain(const lw_forces *f, const double *q)
{
    double energy = lw_superelements_strain(&f->superelements, q), x[6], rate[6];
    for (int i = 0; i < f->model->n_beam; i++) {
        beam_nodes(f, &f->model->beam[i], q, q, x, rate);
        energy += lw_beam_energy(&f->model->beam[i], x);
    }
    return energy;
}

double lw_forces_potential(const lw_forces *f, const double *q)
{
    const lw_system *s = f->system;
    const lw_model *m = f->model;
    lw_measure l;
    double energy = 0, sense;
    for (int b = 0; b < s->n_body; b++)
        energy -= f->weight[3*b]*(q[3*b] - s->reference[b].x) + f->weight[3*b + 1]*(q[3*b + 1] - s->reference[b].y);
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spring *p = &m->spring[i];
        int body[2] = { s->body[p->link[0]], s->body[p->link[1]] };
        if (p->law)
            continue;
        lw_measure_length(s, body, f->spring_arm[i], q, q, false, &l);
        energy += 0.5*p->stiffness*(l.value - p->free)*(l.value - p->free);
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_joint_spring *p = &m->joint_spring[i];
        if (p->law)
            continue;
        lw_measure_joint(s, p->joint, q, q, false, &l);
        energy += 0.5*p->stiffness*(l.value - p->free)*(l.value - p->free);
    }
    for (int i = 0; i < f->n_stop; i++) {
        const lw_joint_stop *p = &m->stop[f->stop_joint[i]];
        lw_measure_joint(s, f->stop_joint[i], q, q, false, &l);
        double in = fmax(depth(p, l.value, &sense), 0);
        energy += 0.5*p->stiffness*in*in;
    }
    /* strains of superelements are in both */
    return energy + lw_forces_strain(f, q) + lw_superelements_potential(&f->superelements, q) - lw_superelements_strain(&f->superelements, q);
}

/* ---- measures ---------------------------------------------------------------------------------- */

/* A point of a body: place, arm from the reference point, rate; scaled. */
typedef struct point { lw_vec2 p, r, v; } point;

static point point_of(int body, lw_vec2 arm, const double *q, const double *v)
{
    if (body < 0)
        return (point){ arm, { 0, 0 }, { 0, 0 } };
    const double *c = q + 3*body, *d = v + 3*body;
    lw_vec2 r = lw_v2_turn(arm, lw_v2_polar(1, c[2]));
    return (point){ lw_v2_add(lw_v2(c[0], c[1]), r), r,
                    lw_v2_add(lw_v2(d[0], d[1]), lw_v2_scale(lw_v2_perp(r), d[2])) };
}

/* Gradient of w . p by the three coordinates of the body of p, w fixed. */
static void along(lw_vec2 w, const point *p, double sign, double *g)
{
    g[0] = sign*w.x;
    g[1] = sign*w.y;
    g[2] = sign*lw_v2_cross(p->r, w);
}

static void finish(lw_measure *m, double unit, const double *v)
{
    m->value *= unit;
    m->rate = 0;
    for (int i = 0; i < 6; i++) {
        m->g[i] *= unit;
        if (m->body[i/3] >= 0)
            m->rate += m->g[i]*v[3*m->body[i/3] + i%3];
        for (int j = 0; m->second && j < 6; j++)
            m->h[i][j] *= unit;
    }
}

static void begin(lw_measure *m, int a, int b, bool second)
{
    m->body[0] = a;
    m->body[1] = b;
    m->second = second;
    memset(m->g, 0, sizeof m->g);
    if (second)
        memset(m->h, 0, sizeof m->h);
}

void lw_measure_length(const lw_system *s, const int body[2], const lw_vec2 arm[2], const double *q,
                       const double *v, bool second, lw_measure *m)
{
    point a = point_of(body[0], arm[0], q, v), b = point_of(body[1], arm[1], q, v);
    lw_vec2 d = lw_v2_sub(b.p, a.p);
    double l = lw_v2_norm(d);
    /* where both ends are at one point no direction is better than another: no force */
    lw_vec2 u = l > 0 ? lw_v2_scale(d, 1/l) : lw_v2(0, 0);
    begin(m, body[0], body[1], second);
    m->value = l;
    along(u, &a, -1, m->g);
    along(u, &b, 1, m->g + 3);
    if (second && l > 0) {
        double across[6];                    /* of the direction u: l du = n (n . dd), n = i u */
        along(lw_v2_perp(u), &a, -1, across);
        along(lw_v2_perp(u), &b, 1, across + 3);
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++)
                m->h[i][j] = across[i]*across[j]/l;
        m->h[2][2] += lw_v2_dot(u, a.r);
        m->h[5][5] -= lw_v2_dot(u, b.r);
    }
    finish(m, s->unit, v);
}

void lw_measure_point(const lw_system *s, int body, lw_vec2 arm, int axis, const double *q, const double *v, bool second, lw_measure *m)
{
    begin(m, body, -1, second);
    if (axis == 2) {
        m->value = body < 0 ? 0 : q[3*body + 2];
        m->g[2] = body < 0 ? 0 : 1;
        finish(m, 1, v);
        return;
    }
    point p = point_of(body, arm, q, v);
    lw_vec2 w = lw_v2(axis == 0, axis == 1);
    m->value = lw_v2_dot(w, p.p);
    if (body >= 0)
        along(w, &p, 1, m->g);
    if (second)
        m->h[2][2] = -lw_v2_dot(w, p.r);
    finish(m, s->unit, v);
    m->value += axis == 0 ? s->origin.x : s->origin.y;
}

/* Measure u . (p1 - p0), where u turns with body 0; derivatives as in mbs/constraints/system_rows.c. */
static void measure_slide(const lw_system_joint *j, const double *q, const double *v, bool second, lw_measure *m)
{
    point a = point_of(j->body[0], j->arm[0], q, v), b = point_of(j->body[1], j->arm[1], q, v);
    lw_vec2 u = lw_v2_turn(j->along, lw_v2_polar(1, j->body[0] < 0 ? 0 : q[3*j->body[0] + 2]));
    lw_vec2 n = lw_v2_perp(u), d = lw_v2_sub(b.p, a.p);
    m->value = lw_v2_dot(u, d);
    along(u, &a, -1, m->g);
    along(u, &b, 1, m->g + 3);
    m->g[2] += lw_v2_dot(n, d);
    if (!second)
        return;
    double mixed[6];                         /* gradient of n . d, n fixed */
    along(n, &a, -1, mixed);
    along(n, &b, 1, mixed + 3);
    for (int i = 0; i < 6; i++) {
        m->h[2][i] += mixed[i];
        m->h[i][2] += mixed[i];
    }
    m->h[2][2] += lw_v2_dot(u, a.r) - lw_v2_dot(u, d);
    m->h[5][5] -= lw_v2_dot(u, b.r);
}

void lw_measure_joint(const lw_system *s, int joint, const double *q, const double *v, bool second, lw_measure *m)
{
    const lw_system_joint *j = &s->joint[joint];
    begin(m, j->body[0], j->body[1], second);
    m->value = 0;
    if (lw_joint_turns(j->kind)) {
        double turn[2] = { j->body[0] < 0 ? 0 : q[3*j->body[0] + 2], j->body[1] < 0 ? 0 : q[3*j->body[1] + 2] };
        m->value = j->sign*(turn[1] - turn[0]);
        m->g[2] = -j->sign;
        m->g[5] = j->sign;
        finish(m, 1, v);
        return;
    }
    if (lw_joint_slides(j->kind))
        measure_slide(j, q, v, second, m);
    finish(m, s->unit, v);
}
