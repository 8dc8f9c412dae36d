/* grammar/model/spatial_loads.c - the joints, tracers and links that the loads of a spatial model name, from JSON. */
#include <stdio.h>
#include <string.h>

#include "grammar/model/model_internal.h"

lw_status lw_spatial_read_link(const lw_json_node *n, const void *model, int *out, lw_error *e)
{
    const lw_spatial *m = model;
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

/* The joint of a motor: revolute or prismatic. */
static lw_status read_motor_place(const lw_json_node *object, const void *model, int *joint, lw_error *e)
{
    const lw_spatial *m = model;
    lw_json_node n;
    lw_status s = lw_read_need(object, "joint", &n, e);
    if (s == LW_OK)
        s = lw_read_name_of(&n, "joint", LW_NAMES(m->joint, m->n_joint, lw_spatial_joint), joint, e);
    lw_spatial_kind k = s == LW_OK ? m->joint[*joint].kind : LW_SPATIAL_REVOLUTE;
    return k == LW_SPATIAL_REVOLUTE || k == LW_SPATIAL_PRISMATIC ? s
         : lw_json_fault(&n, e, "joint \"%s\" is %s; only revolute and prismatic joints have motors", m->joint[*joint].name,
                         lw_spatial_kind_of(k)->word);
}

static void add_motor_spring(int joint, const char *name, void *model, lw_motor_joint *out)
{
    lw_spatial *m = model;
    lw_spatial_joint_spring *push = &m->joint_spring[m->n_joint_spring++];
    const lw_spatial_joint *j = &m->joint[joint];
    bool turns = j->kind == LW_SPATIAL_REVOLUTE;
    snprintf(push->name, sizeof push->name, "%s", name);
    push->measure = (lw_spatial_measure){ turns ? LW_OF_TURN : LW_OF_SLIDE, joint };
    *out = (lw_motor_joint){ joint, { j->link[0], j->link[1] }, m->ground,
                             lw_variable(turns ? LW_QUANTITY_V : LW_QUANTITY_VS, joint), turns, j->name, &push->law };
}

lw_reading lw_spatial_reading(lw_spatial *m)
{
    return (lw_reading){ m, &m->states, &m->units, &m->n_profile, &m->profile, &m->spring, &m->force, &m->motor, &m->n_spring, &m->n_force,
                         &m->n_motor, look_up_state, lw_spatial_read_link, read_motor_place, add_motor_spring, read_joint_spring, true };
}
