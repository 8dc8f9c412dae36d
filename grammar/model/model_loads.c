/* grammar/model/model_loads.c - what loads of planar and of spatial models have in common. */
#include "base/real.h"
#include "grammar/model/model_internal.h"

#include <stdio.h>

/* ---- springs and dampers --------------------------------------------------------------------------------- */

lw_status lw_read_spring_numbers(const lw_json_node *object, const lw_reading *r, lw_expression_scope scope, double unit, double *stiffness,
                                 double *damping, double *free, lw_expression **law, lw_error *e)
{
    const lw_number_key numbers[] = {
        { "stiffness", 1, LW_NOT_NEGATIVE, stiffness, NULL }, { "damping", 1, LW_NOT_NEGATIVE, damping, NULL },
        { "free", unit, scope == LW_OF_LENGTH ? 0 : -INFINITY, INFINITY, free, NULL },
    };
    lw_json_node n;
    double drawn = *free;
    lw_status s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    if (s == LW_OK && scope == LW_OF_LENGTH && *stiffness > 0 && drawn < 1e-12**free && lw_json_member(object, "free", &n))
        s = lw_json_fault(&n, e, "both ends of this spring are at one place in the posture, where its force has no direction; draw them apart, or set "
                            "\"free\" to 0");
    if (s == LW_OK)
        s = lw_read_expression(object, "law", r, scope, law, e);
    for (int i = 0; s == LW_OK && *law && i < COUNT(numbers); i++)
        if (lw_json_member(object, numbers[i].key, &n))
            s = lw_json_fault(&n, e, "\"law\" says all of the force; leave \"%s\" out", numbers[i].key);
    return s;
}

/* A spring between two points.  Without "free" its free length is that in the posture. */
static lw_status read_line_spring(const lw_json_node *object, const char *what, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spring *p = &(*r->spring)[*r->n_spring];
    lw_status s = lw_read_own_name(object, what, index, p->name, e);
    if (s == LW_OK)
        s = lw_read_ends(object, r, e);
    return s != LW_OK ? s : lw_read_spring_numbers(object, r, LW_OF_LENGTH, r->units->metre, &p->stiffness, &p->damping, &p->free, &p->law, e);
}

static lw_status read_spring_or_damper(const lw_json_node *object, size_t index, bool damper, const lw_reading *r, lw_error *e)
{
    static const char *const spring[] = { "name", "links", "at", "joint", "coordinate", "stiffness", "damping", "free", "law" };
    static const char *const dashpot[] = { "name", "links", "at", "joint", "coordinate", "damping" };
    const char *known[COUNT(spring)], *what = damper ? "damper" : "spring";
    int n_known = 0;
    lw_json_node n, joint;
    for (int i = 0; i < (damper ? COUNT(dashpot) : COUNT(spring)); i++)
        if (r->spatial || strcmp(spring[i], "coordinate") != 0)
            known[n_known++] = damper ? dashpot[i] : spring[i];
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(object, known, n_known, e);
    if (s != LW_OK)
        return s;
    bool at_joint = lw_json_member(object, "joint", &joint);
    if (at_joint && (lw_json_member(object, "links", &n) || lw_json_member(object, "at", &n)))
        return lw_json_fault(&n, e, "a %s acts at a \"joint\" or between the points \"at\" of two \"links\"; keep one", what);
    if (!lw_json_member(object, damper ? "damping" : "stiffness", &n) && (damper || !lw_json_member(object, "law", &n)))
        return lw_json_fault(object, e, damper ? "\"damping\" is missing" : "\"stiffness\" or \"law\" is missing");
    return (at_joint ? r->joint_spring : read_line_spring)(object, what, index, r, e);
}

lw_status lw_read_spring(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    return read_spring_or_damper(object, index, false, r, e);
}

lw_status lw_read_damper(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    return read_spring_or_damper(object, index, true, r, e);
}

/* ---- forces ---------------------------------------------------------------------------------------------- */

/* A component in a file: at 0 .. 2 of the force, 3 .. 5 of the torque. */
typedef struct component { const char *key; int at; } component;

static const component in_plane[] = { { "fx", 0 }, { "fy", 1 }, { "torque", 5 } };
static const component in_space[] = { { "fx", 0 }, { "tx", 3 }, { "fy", 1 }, { "ty", 4 }, { "fz", 2 }, { "tz", 5 } };

static const component *components(const lw_reading *r, int *n)
{
    *n = r->spatial ? COUNT(in_space) : COUNT(in_plane);
    return r->spatial ? in_space : in_plane;
}

static lw_expression **part(lw_force *f, int at) { return at < 3 ? &f->force[at] : &f->torque[at - 3]; }

/* A load on the line between two places, in the last force of the model, as forces at its ends. */
static lw_status read_line(const lw_json_node *object, const lw_json_node *along, const lw_reading *r, lw_error *e)
{
    lw_force *f = &(*r->force)[*r->n_force - 1], *end = f + 1;
    lw_json_node n;
    int count;
    const component *c = components(r, &count);
    const char *keys = r->spatial ? "\"fx\", \"fy\", \"fz\"" : "\"fx\" and \"fy\"";
    bool varies = false, any = false;
    *end = *f;
    snprintf(end->name, sizeof end->name, "%.*s end", (int)sizeof end->name - 5, f->name);
    ++*r->n_force;
    lw_status s = lw_read_list(along, 2, 2, e);
    for (int i = 0; s == LW_OK && i < 2; i++) {
        n = lw_json_element(along, (size_t)i);
        s = lw_read_place(&n, r->units->metre, r->spatial, &f[i].at, e);
    }
    for (int i = -1; s == LW_OK && i < count; i++)
        if ((i < 0 || c[i].at >= 3) && lw_json_member(object, i < 0 ? "at" : c[i].key, &n))
            return lw_json_fault(&n, e, "a force \"along\" a line is spread over it and has %s [N/m] only", keys);
    lw_vec3 line = lw_v3_sub(end->at, f->at);
    double length = r->spatial ? lw_v3_norm(line) : lw_v2_norm(lw_v3_xy(line));
    if (s == LW_OK && !(length > 0))
        s = lw_json_fault(along, e, "this line has no length");
    for (int i = 0; s == LW_OK && i < count; i++)
        if (c[i].at < 3) {
            s = lw_read_line_load(object, c[i].key, r, length, part(f, c[i].at), part(end, c[i].at), &varies, e);
            any = any || *part(f, c[i].at);
        }
    f->line = varies ? LW_LINE_VARYING : LW_LINE_EVEN, end->line = LW_LINE_SECOND;
    return s != LW_OK || any ? s : lw_json_fault(object, e, "a force along a line needs %s [N/m]",
                                                 r->spatial ? "one of \"fx\", \"fy\", \"fz\"" : "\"fx\" or \"fy\"");
}

lw_status lw_read_force(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    const char *known[5 + COUNT(in_space)] = { "name", "link", "at", "frame", "along" };
    const char *const frames[] = { r->spatial ? "ground" : "plane", "link" };
    lw_force *f = &(*r->force)[(*r->n_force)++];
    lw_json_node n, along;
    int frame = 0, count, forces = 0, torques = 0;
    const component *c = components(r, &count);
    for (int i = 0; i < count; i++)
        known[5 + i] = c[i].key;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, 5 + count, e)) == LW_OK &&
        (s = lw_read_own_name(object, "force", index, f->name, e)) == LW_OK && (s = lw_read_need(object, "link", &n, e)) == LW_OK)
        s = r->link(&n, r->model, &f->link, e);
    if (s == LW_OK && lw_json_member(object, "frame", &n))
        s = lw_read_look_up(&n, "frame", frames, COUNT(frames), &frame, e);
    f->follows = frame == 1;
    if (s == LW_OK && lw_json_member(object, "along", &along))
        return read_line(object, &along, r, e);
    for (int i = 0; s == LW_OK && i < count; i++) {
        s = lw_read_expression(object, c[i].key, r, LW_OF_STATE, part(f, c[i].at), e);
        *(c[i].at < 3 ? &forces : &torques) += *part(f, c[i].at) != NULL;
    }
    if (s != LW_OK)
        return s;
    if (!forces && !torques)
        return lw_json_fault(object, e, "a force needs %s", r->spatial ? "one of \"fx\", \"fy\", \"fz\", \"tx\", \"ty\", \"tz\""
                                                                       : "\"fx\", \"fy\" or \"torque\"");
    if (lw_json_member(object, "at", &n))
        return lw_read_place(&n, r->units->metre, r->spatial, &f->at, e);
    return forces ? lw_read_need(object, "at", &n, e) : LW_OK;
}

/* ---- motors ---------------------------------------------------------------------------------------------- */

lw_status lw_read_motor(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    static const char *const known[] = { "name", "joint", "stall", "free_speed" };
    if (lw_is_driven_motor(object))
        return lw_states_read_motor(object, index, r, e);
    lw_motor *p = &(*r->motor)[(*r->n_motor)++];
    const lw_number_key numbers[] = { { "stall", 1, LW_ANY, &p->stall, NULL }, { "free_speed", 1, LW_ANY, &p->free_speed, NULL } };
    lw_json_node n;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_own_name(object, "motor", index, p->name, e)) == LW_OK)
        s = r->motor_place(object, r->model, &p->joint, e);
    for (int i = 0; s == LW_OK && i < COUNT(numbers); i++)
        s = lw_read_need(object, numbers[i].key, &n, e);
    if (s == LW_OK)
        s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    if (s == LW_OK && !(p->stall*p->free_speed > 0))
        s = lw_json_fault(object, e, "\"stall\" and \"free_speed\" of a motor have the same sign, that of its motion, and are not 0");
    return s;
}
