/* mbs/constraints/system.c - make the equations of a linkage: bodies, joints and rows. */
#include "mbs/constraints/system.h"

#include <stdlib.h>
#include <string.h>

/* ---- scale ------------------------------------------------------------------------------------- */

/* A gear has no position of its own, and a weld may be drawn anywhere. */
/* Middle and size of the posture.  Differences are taken before sums, so that a posture far from the origin keeps its
 * digits. If all joints are at one point, the tracers define the size; without tracers any size will do, because
 * links only turn about that point. */
static void measure_posture(const lw_assembly *assembly, lw_system *s)
{
    lw_vec2 first = { 0.0, 0.0 }, sum = { 0.0, 0.0 };
    int n = 0;
    s->unit = 0.0;
    for (int j = 0; j < assembly->n_joint; j++)
        if (lw_joint_has_position(assembly->joint[j].kind)) {
            first = n == 0 ? assembly->joint[j].at : first;
            sum = lw_v2_add(sum, lw_v2_sub(assembly->joint[j].at, first));
            n++;
        }
    s->origin = lw_v2_add(first, lw_v2_scale(sum, 1.0/(n > 0 ? n : 1)));
    for (int j = 0; j < assembly->n_joint; j++)
        if (lw_joint_has_position(assembly->joint[j].kind))
            s->unit = fmax(s->unit, lw_v2_norm(lw_v2_sub(assembly->joint[j].at, s->origin)));
    for (int i = 0; i < assembly->n_tracer && s->unit == 0.0; i++)
        s->unit = lw_v2_norm(lw_v2_sub(assembly->tracer[i].at, s->origin));
    s->unit = s->unit > 0.0 ? s->unit : 1.0;
}

static lw_vec2 scaled(const lw_system *s, lw_vec2 at)
{
    return lw_v2_scale(lw_v2_sub(at, s->origin), 1.0/s->unit);
}

/* ---- parts ------------------------------------------------------------------------------------- */

static void make_bodies(const lw_assembly *assembly, const lw_vec2 *reference, lw_system *s)
{
    lw_vec2 *sum = s->reference;             /* by link; body b is at most link b, so each is read before it is replaced */
    int *n = s->link;
    for (int j = 0; j < assembly->n_joint; j++)
        for (int end = 0; end < 2; end++)
            if (lw_joint_has_position(assembly->joint[j].kind)) {
                int l = assembly->joint[j].link[end];
                sum[l] = lw_v2_add(sum[l], scaled(s, assembly->joint[j].at));
                n[l]++;
            }
    for (int l = 0; l < assembly->n_link; l++) {
        s->body[l] = l == assembly->ground ? -1 : s->n_body;
        if (l == assembly->ground)
            continue;
        s->reference[s->n_body] = reference ? scaled(s, reference[l]) : lw_v2_scale(sum[l], 1.0/(n[l] > 0 ? n[l] : 1));
        s->link[s->n_body] = l;
        s->n_body++;
    }
    s->n_q = 3*s->n_body;
}

static void add_row(lw_system *s, int joint, const char *what)
{
    s->row[s->n_row++] = (lw_system_row){ joint, what };
}

static lw_status make_gear(const lw_assembly *assembly, int j, lw_system *s, lw_error *e)
{
    lw_system_joint *q = &s->joint[j];
    lw_gear g;
    lw_status status = lw_assembly_gear(assembly, j, &g, NULL, e);
    if (status != LW_OK)
        return status;
    q->carrier = s->body[g.carrier];
    for (int side = 0; side < 2; side++) {
        q->arm[side] = lw_system_arm(s, q->carrier, assembly->joint[j].at);
        q->slider[side] = g.slider[side];
        q->slider_sign[side] = g.way[side];
    }
    q->ratio = assembly->joint[j].ratio/lw_linkage_gear_unit(&g, s->unit);
    return LW_OK;
}

static lw_status make_joint(const lw_assembly *assembly, int j, lw_system *s, lw_error *e)
{
    const lw_joint *from = &assembly->joint[j];
    lw_system_joint *q = &s->joint[j];
    *q = (lw_system_joint){ .kind = from->kind, .carrier = -1, .sign = 1.0, .along = from->along, .row = s->n_row,
                            .slider = { -1, -1 } };
    for (int end = 0; end < 2; end++) {
        q->body[end] = s->body[from->link[end]];
        q->arm[end] = lw_system_arm(s, q->body[end], from->at);
    }
    if (lw_joint_turns(q->kind) && q->body[1] < 0)
        q->sign = -1.0;
    if (lw_joint_holds_point(q->kind)) {
        add_row(s, j, "x");
        add_row(s, j, "y");
    } else if (lw_joint_slides(q->kind))
        add_row(s, j, "across");
    if (lw_joint_holds_rotation(q->kind))
        add_row(s, j, "turn");
    if (!lw_joint_has_ratio(q->kind))
        return LW_OK;
    add_row(s, j, "ratio");
    return make_gear(assembly, j, s, e);
}

static void make_inputs(const lw_assembly *assembly, lw_system *s)
{
    s->n_input = lw_assembly_free_inputs(assembly);
    s->n_tie = assembly->n_input - s->n_input;
    s->tie_row = s->n_row;
    for (int i = 0; i < assembly->n_input; i++) {
        s->input_joint[i] = assembly->input[i].joint;
        s->input_value[i] = assembly->input[i].value;
    }
    for (int i = 0; i < s->n_tie; i++) {
        int tied = s->n_input + i;
        s->tie[i] = assembly->input[tied].ratio/lw_assembly_tie_unit(assembly, tied, s->unit);
        add_row(s, assembly->input[tied].joint, "tie");
    }
}

typedef struct part { void *to; size_t n, size; } part;

/* Zeroed memory of the arrays; row: most rows. */
static lw_status reserve(lw_system *s, size_t links, size_t joints, size_t inputs, size_t tracers)
{
    const part parts[] = {
        { &s->joint, joints, sizeof *s->joint }, { &s->row, 3*joints + inputs, sizeof *s->row },
        { &s->reference, links, sizeof *s->reference }, { &s->tracer_arm, tracers, sizeof *s->tracer_arm },
        { &s->input_value, inputs, sizeof *s->input_value }, { &s->tie, inputs, sizeof *s->tie },
        { &s->link, links, sizeof *s->link }, { &s->body, links, sizeof *s->body },
        { &s->input_joint, inputs, sizeof *s->input_joint }, { &s->tracer_body, tracers, sizeof *s->tracer_body },
    };
    size_t all = 0, used = 0;
    for (size_t i = 0; i < sizeof parts/sizeof *parts; i++)
        all += parts[i].n*parts[i].size;
    s->memory = calloc(all + 1, 1);
    if (!s->memory)
        return LW_E_MEMORY;
    for (size_t i = 0; i < sizeof parts/sizeof *parts; i++) {
        void *at = (char *)s->memory + used;
        memcpy(parts[i].to, &at, sizeof at);
        used += parts[i].n*parts[i].size;
    }
    return LW_OK;
}

void lw_system_free(lw_system *s)
{
    free(s->memory);
    memset(s, 0, sizeof *s);
}

lw_status lw_system_make(const lw_linkage *linkage, const lw_vec2 *reference, double unit, lw_system *s, lw_error *e)
{
    memset(s, 0, sizeof *s);
    lw_status status = lw_linkage_check(linkage, e);
    lw_assembly a = lw_linkage_view(linkage);
    return status == LW_OK ? lw_system_assemble(&a, reference, unit, s, e) : status;
}

lw_status lw_system_assemble(const lw_assembly *assembly, const lw_vec2 *reference, double unit, lw_system *s, lw_error *e)
{
    memset(s, 0, sizeof *s);
    lw_status status = lw_assembly_check(assembly, e);
    if (status != LW_OK)
        return status;
    if (reserve(s, (size_t)assembly->n_link, (size_t)assembly->n_joint, (size_t)assembly->n_input, (size_t)assembly->n_tracer) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (unit > 0.0)
        s->unit = unit;
    else
        measure_posture(assembly, s);
    make_bodies(assembly, reference, s);
    s->n_joint = assembly->n_joint;
    for (int j = 0; status == LW_OK && j < assembly->n_joint; j++)
        status = make_joint(assembly, j, s, e);
    make_inputs(assembly, s);
    s->n_tracer = assembly->n_tracer;
    for (int i = 0; i < assembly->n_tracer; i++) {
        s->tracer_body[i] = s->body[assembly->tracer[i].link];
        s->tracer_arm[i] = lw_system_arm(s, s->tracer_body[i], assembly->tracer[i].at);
    }
    return status;
}

lw_status lw_system_choose_inputs(const lw_system *from, const int *inputs, int n, lw_system *s)
{
    size_t all = (size_t)(from->n_input + from->n_tie);
    *s = *from;
    if (reserve(s, (size_t)from->n_body + 1, (size_t)from->n_joint, all, (size_t)from->n_tracer) != LW_OK) {
        memset(s, 0, sizeof *s);
        return LW_E_MEMORY;
    }
    memcpy(s->link, from->link, (size_t)from->n_body*sizeof *s->link);
    memcpy(s->body, from->body, (size_t)(from->n_body + 1)*sizeof *s->body);
    memcpy(s->reference, from->reference, (size_t)from->n_body*sizeof *s->reference);
    memcpy(s->joint, from->joint, (size_t)from->n_joint*sizeof *s->joint);
    memcpy(s->row, from->row, (size_t)from->n_row*sizeof *s->row);
    memcpy(s->tie, from->tie, (size_t)from->n_tie*sizeof *s->tie);
    memcpy(s->tracer_body, from->tracer_body, (size_t)from->n_tracer*sizeof *s->tracer_body);
    memcpy(s->tracer_arm, from->tracer_arm, (size_t)from->n_tracer*sizeof *s->tracer_arm);
    s->n_input = n;
    for (int i = 0; i < n + from->n_tie; i++) {
        int old = i < n ? inputs[i] : from->n_input + i - n;
        s->input_joint[i] = from->input_joint[old];
        s->input_value[i] = from->input_value[old];
    }
    return LW_OK;
}

/* ---- postures ---------------------------------------------------------------------------------- */

void lw_system_posture(const lw_system *s, double *q)
{
    for (int b = 0; b < s->n_body; b++) {
        q[3*b] = s->reference[b].x;
        q[3*b + 1] = s->reference[b].y;
        q[3*b + 2] = 0.0;
    }
}

/* b < 0: the ground, which has no coordinates. */
static void add_body(int body[LW_SYSTEM_ROW_BODIES], int b)
{
    int n = 0;
    while (n < LW_SYSTEM_ROW_BODIES && body[n] >= 0 && body[n] != b)
        n++;
    if (b >= 0 && n < LW_SYSTEM_ROW_BODIES)
        body[n] = b;
}

static void add_joint_bodies(const lw_system *s, int j, int body[LW_SYSTEM_ROW_BODIES])
{
    const lw_system_joint *q = &s->joint[j];
    for (int side = 0; side < 2; side++)
        if (lw_joint_has_ratio(q->kind) && q->slider[side] >= 0) {
            add_body(body, s->joint[q->slider[side]].body[0]);
            add_body(body, s->joint[q->slider[side]].body[1]);
        } else {
            add_body(body, q->body[side]);
            add_body(body, lw_joint_has_ratio(q->kind) ? q->carrier : -1);
        }
}

void lw_system_joint_bodies(const lw_system *s, int j, int body[LW_SYSTEM_ROW_BODIES])
{
    for (int i = 0; i < LW_SYSTEM_ROW_BODIES; i++)
        body[i] = -1;
    add_joint_bodies(s, j, body);
}

void lw_system_row_bodies(const lw_system *s, int row, int body[LW_SYSTEM_ROW_BODIES])
{
    lw_system_joint_bodies(s, s->row[row].joint, body);
    if (row >= s->tie_row)
        add_joint_bodies(s, s->input_joint[0], body);
}

lw_vec2 lw_system_arm(const lw_system *s, int body, lw_vec2 at)
{
    lw_vec2 p = scaled(s, at);
    return body < 0 ? p : lw_v2_sub(p, s->reference[body]);
}

lw_vec2 lw_system_point(const lw_system *s, int body, lw_vec2 arm, const double *q)
{
    const double *c = q + 3*body;
    lw_vec2 p = body < 0 ? arm : lw_v2_add(lw_v2(c[0], c[1]), lw_v2_turn(arm, lw_v2_polar(1.0, c[2])));
    return lw_v2_add(s->origin, lw_v2_scale(p, s->unit));
}

static double turn_of(int body, const double *q) { return body < 0 ? 0.0 : q[3*body + 2]; }

void lw_system_write(const lw_system *s, const double *q, lw_linkage *linkage)
{
    for (int j = 0; j < s->n_joint; j++) {
        const lw_system_joint *p = &s->joint[j];
        int end = lw_joint_has_slot(p->kind) ? 1 : 0;
        int body = lw_joint_has_ratio(p->kind) ? p->carrier : p->body[end];
        linkage->joint[j].at = lw_system_point(s, body, p->arm[end], q);
        if (lw_joint_slides(p->kind))
            linkage->joint[j].along = lw_v2_turn(p->along, lw_v2_polar(1.0, turn_of(p->body[0], q)));
    }
    for (int i = 0; i < s->n_tracer; i++) {
        linkage->tracer[i].at = lw_system_point(s, s->tracer_body[i], s->tracer_arm[i], q);
        linkage->tracer[i].angle += turn_of(s->tracer_body[i], q);
    }
    for (int i = 0; i < s->n_input + s->n_tie; i++) {
        int j = s->input_joint[i];
        linkage->input[i].value = s->input_value[i] + lw_system_measure(s, j, q, NULL)*lw_system_joint_unit(s, j);
    }
}
