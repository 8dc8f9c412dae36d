/* grammar/model/spatial_loads.c - springs, forces, motors and cylinders of a spatial model, and the joints, tracers and links that they
 * name, from JSON. */
#include <stdio.h>
#include <string.h>

#include "grammar/model/model_internal.h"

lw_status lw_spatial_read_link(const lw_json_node *n, const lw_spatial *m, int *out, lw_error *e)
{
    return lw_read_name_of(n, "link", LW_NAMES(m->body, m->n_link, lw_spatial_body), out, e);
}

/* ---- expressions ------------------------------------------------------------------------------- */

static int look_up_state(const void *model, lw_json *json, const char *word, const char *name, char *why)
{
    static const struct { const char *word; lw_quantity turns, slides; } known[] = {
        { "q", LW_QUANTITY_Q, LW_QUANTITY_S }, { "v", LW_QUANTITY_V, LW_QUANTITY_VS }, { "s", LW_QUANTITY_S, LW_QUANTITY_S },
        { "vs", LW_QUANTITY_VS, LW_QUANTITY_VS }, { "x", LW_QUANTITY_X, 0 }, { "y", LW_QUANTITY_Y, 0 },
        { "z", LW_QUANTITY_Z, 0 }, { "vx", LW_QUANTITY_VX, 0 }, { "vy", LW_QUANTITY_VY, 0 }, { "vz", LW_QUANTITY_VZ, 0 },
    };
    const lw_spatial *m = model;
    for (int i = 0; i < COUNT(known); i++) {
        if (strcmp(word, known[i].word) != 0)
            continue;
        bool joint = i < 4;
        if (!name) {
            snprintf(why, LW_WHY_SIZE, "%s needs the name of a %s: %s(...)", word, joint ? "joint" : "tracer", word);
            return -1;
        }
        int at = joint ? lw_read_find_or_say(json, "joint", name, LW_NAMES(m->joint, m->n_joint, lw_spatial_joint), why)
                       : lw_read_find_or_say(json, "tracer", name, LW_NAMES(m->tracer, m->n_tracer, lw_spatial_tracer), why);
        if (at < 0)
            return -1;
        lw_quantity v = known[i].turns;
        if (joint) {
            const lw_spatial_kind_row *k = lw_spatial_kind_of(m->joint[at].kind);
            if (i < 2 ? !k->turns && !k->slides : !k->slides) {
                snprintf(why, LW_WHY_SIZE, "joint \"%.40s\" of kind %s has no such coordinate", name, k->word);
                return -1;
            }
            if (!k->turns)
                v = known[i].slides;
        }
        return lw_variable(v, at);
    }
    return -1;
}

/* ---- coordinates ------------------------------------------------------------------------------ */

lw_status lw_spatial_read_measure(const lw_json_node *object, const lw_spatial *m, bool tracers, const char *what,
                                  lw_spatial_measure *out, lw_error *e)
{
    static const char *const of_joint[] = { "turn", "slide" }, *const of_tracer[] = { "x", "y", "z" };
    lw_json_node joint, tracer, n;
    bool has_tracer = tracers && lw_json_member(object, "tracer", &tracer), has = lw_json_member(object, "coordinate",
            &n);
    int which = 0;
    if (has_tracer) {
        if (lw_json_member(object, "joint", &joint))
            return lw_json_fault(&joint, e, "keep \"joint\" or \"tracer\"");
        lw_status s = lw_read_name_of(&tracer, "tracer", LW_NAMES(m->tracer, m->n_tracer, lw_spatial_tracer), &out->index,
                                      e);
        if (s == LW_OK && (s = lw_read_need(object, "coordinate", &n, e)) == LW_OK)
            s = lw_read_look_up(&n, "coordinate of a tracer", of_tracer, 3, &which, e);
        out->of = (lw_spatial_of)(LW_OF_X + which);
        return s;
    }
    lw_status s = lw_read_need(object, "joint", &joint, e);
    if (s == LW_OK)
        s = lw_read_name_of(&joint, "joint", LW_NAMES(m->joint, m->n_joint, lw_spatial_joint), &out->index, e);
    if (s == LW_OK && has)
        s = lw_read_look_up(&n, "coordinate of a joint", of_joint, 2, &which, e);
    if (s != LW_OK)
        return s;
    const lw_spatial_joint *j = &m->joint[out->index];
    const lw_spatial_kind_row *k = lw_spatial_kind_of(j->kind);
    out->of = has ? (lw_spatial_of)which : k->turns ? LW_OF_TURN : LW_OF_SLIDE;
    if (j->kind == LW_SPATIAL_CYLINDRICAL && !has)
        return lw_json_fault(object, e, "joint \"%s\" turns and slides: say which with \"coordinate\": \"turn\" or "
                                        "\"slide\"",
                             j->name);
    return (out->of == LW_OF_TURN ? k->turns : k->slides) ? LW_OK
         : lw_json_fault(has ? &n : &joint, e, "joint \"%s\" is %s: it has no %s for %s", j->name, k->word,
                         has ? of_joint[which] : "single coordinate", what);
}

double lw_spatial_measure_unit(const lw_spatial *m, lw_spatial_measure of)
{
    return of.of == LW_OF_TURN ? m->units.radian : m->units.metre;
}

/* ---- loads ------------------------------------------------------------------------------------- */

/* "links" and "at" of a spring between two points; its free length. */
static lw_status read_ends(const lw_json_node *object, lw_spatial *m, lw_spatial_spring *p, lw_error *e)
{
    lw_json_node links, at;
    lw_status s = lw_read_need(object, "links", &links, e);
    if (s == LW_OK && (s = lw_read_list(&links, 2, 2, e)) == LW_OK && (s = lw_read_need(object, "at", &at, e)) == LW_OK)
        s = lw_read_list(&at, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node link = lw_json_element(&links, end), point = lw_json_element(&at, end);
        s = lw_spatial_read_link(&link, m, &p->link[end], e);
        if (s == LW_OK)
            s = lw_read_triple(&point, m->units.metre, &p->at[end], e);
    }
    if (s == LW_OK && p->link[0] == p->link[1])
        s = lw_json_fault(&links, e, "both ends are on link \"%s\": nothing between them can move", m->body[p->link[0]].name);
    p->free = lw_v3_norm(lw_v3_sub(p->at[1], p->at[0]));
    return s;
}

static lw_status read_line_spring(const lw_json_node *object, const char *what, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    lw_spatial_spring *p = &m->spring[m->n_spring++];
    lw_status s = lw_read_own_name(object, what, index, p->name, e);
    if (s == LW_OK)
        s = read_ends(object, m, p, e);
    return s != LW_OK ? s : lw_read_spring_numbers(object, r, LW_OF_LENGTH, m->units.metre, &p->stiffness, &p->damping, &p->free, &p->law, e);
}

static lw_status read_joint_spring(const lw_json_node *object, const char *what, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    lw_spatial_joint_spring *p = &m->joint_spring[m->n_joint_spring++];
    lw_status s = lw_read_own_name(object, what, index, p->name, e);
    if (s == LW_OK)
        s = lw_spatial_read_measure(object, m, false, what, &p->measure, e);
    return s != LW_OK ? s : lw_read_spring_numbers(object, r, LW_OF_DISPLACEMENT, lw_spatial_measure_unit(m, p->measure), &p->stiffness, &p->damping, &p->free,
                                                   &p->law, e);
}

/* A load on the line between two places, in the last force of the model, as forces at its ends. */
static lw_status read_line(const lw_json_node *object, const lw_json_node *along, const lw_reading *r, lw_spatial *m, lw_error *e)
{
    static const char *const other[] = { "at", "tx", "ty", "tz" }, *const key[] = { "fx", "fy", "fz" };
    lw_spatial_force *f = &m->force[m->n_force - 1], *end = f + 1;
    lw_json_node n;
    bool varies = false, any = false;
    *end = *f;
    snprintf(end->name, sizeof end->name, "%.*s end", (int)sizeof end->name - 5, f->name);
    m->n_force++;
    lw_status s = lw_read_list(along, 2, 2, e);
    for (int i = 0; s == LW_OK && i < 2; i++) {
        n = lw_json_element(along, (size_t)i);
        s = lw_read_triple(&n, m->units.metre, &f[i].at, e);
    }
    for (int i = 0; s == LW_OK && i < COUNT(other); i++)
        if (lw_json_member(object, other[i], &n))
            return lw_json_fault(&n, e, "a force \"along\" a line is spread over it and has \"fx\", \"fy\", \"fz\" [N/m] only");
    double length = lw_v3_norm(lw_v3_sub(end->at, f->at));
    if (s == LW_OK && !(length > 0))
        s = lw_json_fault(along, e, "this line has no length");
    for (int i = 0; s == LW_OK && i < 3; i++) {
        s = lw_read_line_load(object, key[i], r, length, &f->force[i], &end->force[i], &varies, e);
        any = any || f->force[i];
    }
    f->line = varies ? LW_LINE_VARYING : LW_LINE_EVEN, end->line = LW_LINE_SECOND;
    return s != LW_OK || any ? s : lw_json_fault(object, e, "a force along a line needs one of \"fx\", \"fy\", \"fz\" [N/m]");
}

lw_status lw_spatial_read_force(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    static const char *const known[] = { "name", "link", "at", "frame", "fx", "fy", "fz", "tx", "ty", "tz", "along" };
    static const char *const frames[] = { "ground", "link" };
    lw_spatial_force *f = &m->force[m->n_force++];
    lw_json_node n, along;
    int frame = 0, forces = 0, torques = 0;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_own_name(object, "force", index, f->name, e)) == LW_OK && (s = lw_read_need(object, "link", &n,
                e)) == LW_OK)
        s = lw_spatial_read_link(&n, m, &f->link, e);
    if (s == LW_OK && lw_json_member(object, "frame", &n))
        s = lw_read_look_up(&n, "frame", frames, COUNT(frames), &frame, e);
    f->follows = frame == 1;
    if (s == LW_OK && lw_json_member(object, "along", &along))
        return read_line(object, &along, r, m, e);
    for (int i = 0; s == LW_OK && i < 3; i++) {
        s = lw_read_expression(object, known[4 + i], r, LW_OF_STATE, &f->force[i], e);
        if (s == LW_OK)
            s = lw_read_expression(object, known[7 + i], r, LW_OF_STATE, &f->torque[i], e);
        forces += f->force[i] != NULL, torques += f->torque[i] != NULL;
    }
    if (s != LW_OK)
        return s;
    if (!forces && !torques)
        return lw_json_fault(object, e, "a force needs one of \"fx\", \"fy\", \"fz\", \"tx\", \"ty\", \"tz\"");
    if (lw_json_member(object, "at", &n))
        return lw_read_triple(&n, m->units.metre, &f->at, e);
    return forces ? lw_read_need(object, "at", &n, e) : LW_OK;
}

/* The joint of a motor: revolute or prismatic. */
static lw_status read_motor_place(const lw_json_node *object, const lw_spatial *m, int *joint, lw_error *e)
{
    lw_json_node n;
    lw_status s = lw_read_need(object, "joint", &n, e);
    if (s == LW_OK)
        s = lw_read_name_of(&n, "joint", LW_NAMES(m->joint, m->n_joint, lw_spatial_joint), joint, e);
    lw_spatial_kind k = s == LW_OK ? m->joint[*joint].kind : LW_SPATIAL_REVOLUTE;
    return k == LW_SPATIAL_REVOLUTE || k == LW_SPATIAL_PRISMATIC ? s
         : lw_json_fault(&n, e, "joint \"%s\" is %s; only revolute and prismatic joints have motors", m->joint[*joint].name,
                         lw_spatial_kind_of(k)->word);
}

lw_status lw_spatial_read_motor(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    if (lw_is_driven_motor(object))
        return lw_states_read_motor(object, index, r, e);
    lw_motor *p = &m->motor[m->n_motor++];
    lw_status s = lw_read_motor_name(object, index, p, e);
    if (s == LW_OK)
        s = read_motor_place(object, m, &p->joint, e);
    return s == LW_OK ? lw_read_motor_line(object, p, e) : s;
}

/* ---- for expressions and states ---------------------------------------------------------------- */

static int find_spring(const void *model, lw_json *json, const char *name, char *why)
{
    const lw_spatial *m = model;
    return lw_read_find_or_say(json, "spring or cylinder between two points", name, LW_NAMES(m->spring, m->n_spring, lw_spatial_spring), why);
}

static lw_status read_cylinder_ends(const lw_json_node *object, const char *name, void *model, lw_error *e)
{
    lw_spatial *m = model;
    lw_spatial_spring *p = &m->spring[m->n_spring++];
    snprintf(p->name, sizeof p->name, "%s", name);
    return read_ends(object, m, p, e);
}

static lw_expression **find_cylinder(void *model, lw_json *json, const char *name, const double extent[2], int *spring, double *length)
{
    lw_spatial *m = model;
    int i = lw_read_find(json, name, m->spring->name, sizeof *m->spring, m->n_spring);
    *spring = i;
    *length = m->spring[i].free;
    memcpy(m->spring[i].extent, extent, sizeof m->spring[i].extent);
    return &m->spring[i].law;
}

static lw_status read_motor_joint(const lw_json_node *object, const char *name, void *model, lw_motor_joint *out, lw_error *e)
{
    lw_spatial *m = model;
    lw_spatial_joint_spring *push = &m->joint_spring[m->n_joint_spring];
    int joint;
    lw_status s = read_motor_place(object, m, &joint, e);
    if (s != LW_OK)
        return s;
    const lw_spatial_joint *j = &m->joint[joint];
    bool turns = j->kind == LW_SPATIAL_REVOLUTE;
    m->n_joint_spring++;
    snprintf(push->name, sizeof push->name, "%s", name);
    push->measure = (lw_spatial_measure){ turns ? LW_OF_TURN : LW_OF_SLIDE, joint };
    *out = (lw_motor_joint){ joint, { j->link[0], j->link[1] }, m->ground,
                             lw_variable(turns ? LW_QUANTITY_V : LW_QUANTITY_VS, joint), turns, j->name, &push->law };
    return LW_OK;
}

lw_reading lw_spatial_reading(lw_spatial *m)
{
    return (lw_reading){ m, &m->states, &m->units, &m->n_profile, &m->profile, look_up_state, find_spring,
                         read_cylinder_ends, find_cylinder, read_motor_joint, { read_line_spring, read_joint_spring }, true };
}
