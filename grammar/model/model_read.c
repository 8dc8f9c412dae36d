/* grammar/model/model_read.c - a model from JSON (docs/notation.md, "Model"): first the linkage, by its own reader, then
 * drives and loads.  Positions and angles are in the units of the file, all other values in SI units. */
#include "base/real.h"
#include "grammar/model/model_internal.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "grammar/linkage/read_internal.h"

/* ---- expressions ------------------------------------------------------------------------------- */

/* A variable of the state of the linkage: word(name). */
static int look_up_state(const void *model, lw_json *json, const char *word, const char *name, char *why)
{
    static const struct { const char *word; lw_quantity quantity; char of; } known[] = {
        { "q", LW_QUANTITY_Q, 'j' }, { "v", LW_QUANTITY_V, 'j' }, { "x", LW_QUANTITY_X, 't' },
        { "y", LW_QUANTITY_Y, 't' }, { "vx", LW_QUANTITY_VX, 't' }, { "vy", LW_QUANTITY_VY, 't' },
        { "angle", LW_QUANTITY_ANGLE, 'l' }, { "omega", LW_QUANTITY_OMEGA, 'l' },
    };
    const lw_assembly *assembly = &((const lw_model *)model)->linkage;
    for (int i = 0; i < COUNT(known); i++) {
        if (strcmp(word, known[i].word) != 0)
            continue;
        char of = known[i].of;
        const char *what = of == 'j' ? "joint" : of == 't' ? "tracer" : "link";
        if (!name) {
            snprintf(why, LW_WHY_SIZE, "%s needs the name of a %s: %s(...)", word, what, word);
            return -1;
        }
        int at = of == 'j'   ? lw_read_find_or_say(json, what, name, (const char *)assembly->joint + offsetof(lw_joint, name),
                                         sizeof *assembly->joint, assembly->n_joint, why)
                 : of == 't' ? lw_read_find_or_say(json, what, name, (const char *)assembly->tracer + offsetof(lw_tracer, name),
                                         sizeof *assembly->tracer, assembly->n_tracer, why)
                             : lw_read_find_or_say(json, what, name, (const char *)assembly->link_name, sizeof *assembly->link_name,
                                         assembly->n_link, why);
        if (at >= 0 && of == 'j' && !lw_joint_can_drive(assembly->joint[at].kind))
            snprintf(why, LW_WHY_SIZE, "joint \"%.40s\" is neither a pin nor a slider: it counts nothing", name);
        else if (at >= 0)
            return lw_variable(known[i].quantity, at);
        return -1;
    }
    return -1;
}

/* ---- links and inputs -------------------------------------------------------------------------- */

static lw_status read_body(const lw_json_node *link, lw_model *m, int i, lw_error *e)
{
    lw_json_node n;
    lw_body *b = &m->body[i];
    const lw_number_key numbers[] = {
        { "mass", 1, 0, INFINITY, &b->mass, &b->given },
        { "inertia", 1, 0, INFINITY, &b->inertia, NULL },
    };
    if (lw_json_kind_of(link) != LW_JSON_OBJECT)
        return LW_OK;
    const lw_number_key omega = { "omega", 1, LW_ANY, &b->omega, &b->has_velocity };
    bool centre = lw_json_member(link, "centre", &n);
    lw_status s = centre ? lw_read_pair(&n, m->linkage.units.metre, &b->centre, e) : LW_OK;
    if (s == LW_OK)
        s = lw_read_numbers(link, numbers, COUNT(numbers), e);
    if (s == LW_OK && !b->given && (centre || lw_json_member(link, "inertia", &n)))
        s = lw_json_fault(link, e, "link \"%s\" has %s but no \"mass\"; write one [kg], 0 is allowed",
                          m->linkage.link_name[i], centre ? "a centre of mass" : "an inertia");
    if (s == LW_OK && b->mass > 0 && !centre)
        s = lw_json_fault(link, e, "link \"%s\" has a mass but no \"centre\" where it acts", m->linkage.link_name[i]);
    if (s == LW_OK)
        s = lw_read_numbers(link, &omega, 1, e);
    if (s == LW_OK && lw_json_member(link, "velocity", &n)) {
        b->has_velocity = true;
        s = lw_read_pair(&n, 1, &b->velocity, e);
    }
    if (s == LW_OK && b->has_velocity && i == m->linkage.ground)
        s = lw_json_fault(link, e, "the ground does not move: leave \"velocity\" and \"omega\" out");
    return s;
}

static lw_status read_bodies(const lw_json_node *root, lw_model *m, lw_error *e)
{
    lw_json_node links, gravity, elastic;
    lw_status s = LW_OK;
    if (lw_json_member(root, "links", &links))
        for (int i = 0; s == LW_OK && i < m->linkage.n_link; i++) {
            lw_json_node link = lw_json_element(&links, (size_t)i);
            s = read_body(&link, m, i, e);
            if (s != LW_OK || lw_json_kind_of(&link) != LW_JSON_OBJECT || !lw_json_member(&link, "elastic", &elastic))
                continue;
            if ((s = lw_elastic_check_link(&link, &elastic, i == m->linkage.ground, e)) == LW_OK)
                s = lw_elastic_read(&elastic, m->linkage.units.metre, false, &m->elastic[i], e);
            m->n_elastic++;
        }
    if (s == LW_OK)
        s = lw_model_check_elastic(root, m, e);
    if (s == LW_OK && lw_json_member(root, "gravity", &gravity))
        s = lw_read_pair(&gravity, 1, &m->gravity, e);
    return s;
}

static lw_status check_centres(const lw_json_node *root, const lw_model *m, lw_error *e)
{
    const lw_assembly *a = &m->linkage;
    double extent = 0;
    lw_status s = LW_OK;
    for (int i = 0; i < a->n_joint; i++)
        extent = lw_joint_has_position(a->joint[i].kind) ? fmax(extent, lw_v2_norm(lw_v2_sub(a->joint[i].at, a->joint[0].at))) : extent;
    for (int i = 0; i < a->n_tracer; i++)
        extent = fmax(extent, lw_v2_norm(lw_v2_sub(a->tracer[i].at, a->joint[0].at)));
    for (int i = 0; s == LW_OK && i < 2*a->n_joint; i++) {
        const lw_joint *j = &a->joint[i/2];
        int link = j->link[i % 2];
        if (lw_joint_has_position(j->kind) && m->body[link].mass > 0)
            s = lw_read_check_centre(root, link, a->link_name[link], lw_v2_norm(lw_v2_sub(m->body[link].centre, j->at)), extent, e);
    }
    return s;
}

static lw_status read_motion(const lw_json_node *input, const lw_reading *r, int i, lw_error *e)
{
    lw_model *m = r->model;
    const lw_number_key speed = { "speed", 1, LW_ANY, &m->speed[i], &m->has_speed[i] };
    lw_json_node n;
    lw_status s = lw_read_numbers(input, &speed, 1, e);
    if (s == LW_OK && m->has_speed[i] && lw_json_member(input, "motion", &n))
        return lw_json_fault(&n, e, "\"motion\" says where the input is at every time, \"speed\" how fast it "
                             "starts before it runs freely; keep one");
    return s == LW_OK ? lw_read_expression(input, "motion", r, LW_OF_TIME, &m->motion[i], e) : s;
}

static lw_status read_motions(const lw_json_node *root, const lw_reading *r, lw_error *e)
{
    const lw_model *m = r->model;
    lw_json_node one, many;
    if (lw_json_member(root, "input", &one))
        return read_motion(&one, r, 0, e);
    lw_status s = LW_OK;
    if (lw_json_member(root, "inputs", &many))
        for (int i = 0; s == LW_OK && i < m->linkage.n_input; i++) {
            one = lw_json_element(&many, (size_t)i);
            s = read_motion(&one, r, i, e);
        }
    return s;
}

/* ---- joints ------------------------------------------------------------------------------------ */

/* The unit of a joint's displacement in the file. */
static double joint_unit(const lw_model *m, int joint)
{
    return lw_joint_turns(m->linkage.joint[joint].kind) ? m->linkage.units.radian : m->linkage.units.metre;
}

static const char pins[] = "pins (\"r\")", drives[] = "pins (\"r\") and sliders (\"t\")";

static lw_status need_kind(const lw_json_node *n, const lw_model *m, int joint, bool (*has_it)(lw_joint_kind),
                           const char *kinds, const char *what, lw_error *e)
{
    const lw_joint *j = &m->linkage.joint[joint];
    if (has_it(j->kind))
        return LW_OK;
    return lw_json_fault(n, e, "joint \"%s\" is of kind \"%c\"; only %s have %s", j->name, (char)j->kind, kinds, what);
}

static lw_status read_friction(const lw_json_node *n, lw_model *m, int joint, lw_error *e)
{
    lw_status s = need_kind(n, m, joint, lw_joint_has_position, "pins, sliders and slots", "friction", e);
    return s == LW_OK ? lw_read_friction(n, m->linkage.units.metre, lw_joint_turns(m->linkage.joint[joint].kind),
                                         &m->friction[joint], e) : s;
}

static lw_status read_stop(const lw_json_node *n, lw_model *m, int joint, lw_error *e)
{
    lw_status s = lw_json_expect(n, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = need_kind(n, m, joint, lw_joint_can_drive, drives, "stops", e);
    return s == LW_OK ? lw_read_stop(n, joint_unit(m, joint), &m->stop[joint], e) : s;
}

static lw_status read_clearance(const lw_json_node *n, lw_model *m, int joint, lw_error *e)
{
    lw_status s = need_kind(n, m, joint, lw_joint_turns, pins, "a clearance", e);
    return s == LW_OK ? lw_read_clearance(n, m->linkage.units.metre, &m->clearance[joint], e) : s;
}

static lw_status read_joint_extras(const lw_json_node *root, lw_model *m, lw_error *e)
{
    lw_json_node joints, n;
    lw_status s = lw_read_need(root, "joints", &joints, e);
    for (int i = 0; s == LW_OK && i < m->linkage.n_joint; i++) {
        lw_json_node joint = lw_json_element(&joints, (size_t)i);
        if (lw_json_member(&joint, "friction", &n))
            s = read_friction(&n, m, i, e);
        if (s == LW_OK && lw_json_member(&joint, "stop", &n))
            s = read_stop(&n, m, i, e);
        if (s == LW_OK && lw_json_member(&joint, "clearance", &n))
            s = read_clearance(&n, m, i, e);
    }
    return s;
}

/* ---- loads ------------------------------------------------------------------------------------- */

static lw_status read_load_joint(const lw_json_node *object, const char *what, const lw_model *m, int *joint, lw_error *e)
{
    lw_json_node n;
    lw_status s = lw_read_need(object, "joint", &n, e);
    if (s == LW_OK)
        s = lw_read_joint(&n, &m->linkage, joint, e);
    return s == LW_OK ? need_kind(&n, m, *joint, lw_joint_can_drive, drives, what, e) : s;
}

static lw_status read_link(const lw_json_node *n, const void *model, int *out, lw_error *e)
{
    return lw_read_link(n, &((const lw_model *)model)->linkage, out, e);
}

static lw_status read_motor_place(const lw_json_node *object, const void *model, int *joint, lw_error *e)
{
    return read_load_joint(object, "motors", model, joint, e);
}

static void add_motor_spring(int joint, const char *name, void *model, lw_motor_joint *out)
{
    lw_model *m = model;
    lw_joint_spring *push = &m->joint_spring[m->n_joint_spring++];
    const lw_joint *j = &m->linkage.joint[joint];
    push->joint = joint;
    snprintf(push->name, sizeof push->name, "%s", name);
    *out = (lw_motor_joint){ joint, { j->link[0], j->link[1] }, m->linkage.ground, lw_variable(LW_QUANTITY_V, joint),
                             lw_joint_turns(j->kind), j->name, &push->law };
}

static lw_status read_joint_spring(const lw_json_node *object, const char *what, size_t index, const lw_reading *r, lw_error *e)
{
    lw_model *m = r->model;
    lw_joint_spring *p = &m->joint_spring[m->n_joint_spring];
    lw_status s = lw_read_own_name(object, what, index, p->name, e);
    if (s == LW_OK)
        s = read_load_joint(object, what, m, &p->joint, e);
    if (s != LW_OK)
        return s;
    m->n_joint_spring++;
    return lw_read_spring_numbers(object, r, LW_OF_DISPLACEMENT, joint_unit(m, p->joint), &p->stiffness, &p->damping, &p->free, &p->law, e);
}

static lw_reading reading_of(lw_model *m)
{
    return (lw_reading){ m, &m->states, &m->linkage.units, &m->n_profile, &m->profile, &m->spring, &m->force, &m->motor, &m->n_spring,
                         &m->n_force, &m->n_motor, look_up_state, read_link, read_motor_place, add_motor_spring, read_joint_spring, false };
}

/* ---- all loads ------------------------------------------------------------------------------------ */

static lw_status reserve_loads(const lw_json_node *root, lw_model *m, lw_error *e)
{
    size_t springs = lw_read_count(root, "springs") + lw_read_count(root, "dampers") + 1;
    size_t motors = lw_read_count(root, "motors") + 1;
    m->spring = calloc(springs + lw_read_count(root, "cylinders"), sizeof *m->spring);
    m->joint_spring = calloc(springs + motors, sizeof *m->joint_spring);
    m->states.rotor = calloc(motors, sizeof *m->states.rotor);
    m->force = calloc(2*lw_read_count(root, "forces") + 1, sizeof *m->force);
    m->motor = calloc(motors, sizeof *m->motor);
    m->contact = calloc(lw_read_count(root, "contacts") + 1, sizeof *m->contact);
    m->rope = calloc(lw_read_count(root, "ropes") + 1, sizeof *m->rope);
    return m->spring && m->joint_spring && m->force && m->motor && m->states.rotor && m->contact && m->rope
         ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

lw_status lw_model_read(const char *text, size_t size, const char *file, lw_model *m, lw_error *e)
{
    return lw_model_read_result(text, size, file, 0, m, e);
}

lw_status lw_model_read_result(const char *text, size_t size, const char *file, int which, lw_model *m, lw_error *e)
{
    static const struct { const char *key; lw_read_one *read; } load[] = {
        { "springs", lw_read_spring }, { "dampers", lw_read_damper }, { "cylinders", lw_states_read_cylinder_ends },
        { "controllers", lw_states_read_controller }, { "forces", lw_read_force }, { "motors", lw_read_motor },
        { "contacts", lw_model_read_contact }, { "ropes", lw_model_read_rope }
    };
    lw_json json;
    const lw_reading r = reading_of(m);
    lw_json_node place[4];
    memset(m, 0, sizeof *m);
    m->linkage.units = lw_units_si();
    lw_status s = lw_json_open(text, size, file, &json, e);
    if (s != LW_OK)
        return s;
    const lw_json_node *root = &place[3];
    if ((s = lw_read_result(&json, which, place, e)) == LW_OK)
        s = lw_assembly_read_root(root, &m->linkage, e);
    if (s == LW_OK && lw_model_reserve(m) != LW_OK)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        s = reserve_loads(root, m, e);
    if (s == LW_OK)
        s = read_bodies(root, m, e);
    if (s == LW_OK)
        s = check_centres(root, m, e);
    if (s == LW_OK)
        s = lw_moves_read_profiles(root, &m->n_profile, &m->profile, e);
    if (s == LW_OK)
        s = read_motions(root, &r, e);
    if (s == LW_OK)
        s = read_joint_extras(root, m, e);
    if (s == LW_OK)
        s = lw_model_read_shapes(root, m, e);
    if (s == LW_OK)
        s = lw_states_name(root, &m->states, e);
    for (int i = 0; s == LW_OK && i < COUNT(load); i++)
        s = lw_read_each(root, load[i].key, load[i].read, &r, e);
    if (s == LW_OK)
        s = lw_states_read(root, &r, e);
    if (s == LW_OK)
        s = lw_model_add_rotors(root, m, e);
    lw_json_close(&json);
    if (s != LW_OK)
        lw_model_free(m);
    return s;
}
