/* grammar/model/spatial.c - a spatial model in memory: kinds of joints, size, motions, release. */
#include "grammar/model/spatial.h"
#include "grammar/model/model_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const lw_spatial_kind_row *lw_spatial_kind_of(lw_spatial_kind kind)
{
    static const lw_spatial_kind_row table[] = {
#define X(id, letter, word, rows, turns, slides) { letter, word, rows, turns, slides },
        LW_SPATIAL_KIND_LIST(X)
#undef X
    };
    return &table[kind];
}

void lw_spatial_free(lw_spatial *m)
{
    for (int i = 0; i < m->n_input; i++)
        lw_expression_free(m->input[i].motion);
    lw_springs_and_forces_free(m->n_spring, m->spring, m->n_force, m->force);
    for (int i = 0; i < m->n_joint_spring; i++)
        lw_expression_free(m->joint_spring[i].law);
    lw_states_free(&m->states);
    for (int i = 0; m->profile && i < m->n_profile; i++)
        lw_moves_free(&m->profile[i]);
    for (int i = 0; m->elastic && i < m->n_link; i++)
        lw_elastic_free(&m->elastic[i]);
    for (int i = 0; m->coupling && i < m->n_coupling; i++) {
        free(m->coupling[i].of);
        free(m->coupling[i].factor);
    }
    void *const array[] = { m->profile, m->body, m->joint, m->coupling, m->input, m->drive, m->tracer, m->joint_spring,
                            m->motor, m->elastic, m->beam, m->files };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
    memset(m, 0, sizeof *m);
}

bool lw_spatial_has_clearance(const lw_spatial_joint *j) { return j->clearance.model > LW_CLEARANCE_ZERO; }

lw_status lw_spatial_open(const lw_spatial *m, lw_spatial *open, lw_error *e)
{
    *open = *m;
    open->joint = malloc(((size_t)m->n_joint + 1)*sizeof *open->joint);
    open->contact = malloc(((size_t)m->n_joint + 1)*sizeof *open->contact);
    if (!open->joint || !open->contact)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(open->joint, m->joint, (size_t)m->n_joint*sizeof *m->joint);
    for (int j = 0; j < m->n_joint; j++)
        if ((open->joint[j].opened = lw_spatial_has_clearance(&m->joint[j]))) {
            open->joint[j].kind = m->joint[j].kind == LW_SPATIAL_SPHERICAL ? LW_SPATIAL_FREE : LW_SPATIAL_PLANAR;
            open->contact[open->n_contact++] = j;
        }
    return LW_OK;
}

void lw_spatial_open_free(lw_spatial *open)
{
    free(open->joint);
    free(open->contact);
    memset(open, 0, sizeof *open);
}

lw_status lw_spatial_set_motion(lw_spatial *m, int i, const char *motion, lw_error *e)
{
    return lw_motion_replace(motion, &m->n_profile, &m->profile, &m->input[i].motion, &m->input[i].has_speed, e);
}

/* Place k of the joints, tracers and centres of mass; false: there is none. */
static bool place_of(const lw_spatial *m, int k, lw_vec3 *out)
{
    *out = k < m->n_joint ? m->joint[k].at : k < m->n_joint + m->n_tracer ? m->tracer[k - m->n_joint].at
         : m->body[k - m->n_joint - m->n_tracer].centre;
    return k < m->n_joint ? lw_spatial_kind_of(lw_spatial_kind_given(&m->joint[k]))->rows > 0
         : k < m->n_joint + m->n_tracer || m->body[k - m->n_joint - m->n_tracer].mass > 0;
}

double lw_spatial_size(const lw_spatial *m)
{
    lw_vec3 middle = lw_v3(0, 0, 0), p;
    double size = 1e-9;
    int n = m->n_joint + m->n_tracer + m->n_link, count = 0;
    for (int k = 0; k < n; k++)
        if (place_of(m, k, &p)) {
            middle = lw_v3_add(middle, p);
            count++;
        }
    middle = lw_v3_scale(middle, 1.0/(count > 0 ? count : 1));
    for (int k = 0; k < n; k++)
        if (place_of(m, k, &p))
            size = fmax(size, lw_v3_norm(lw_v3_sub(p, middle)));
    return size > 1e-9 ? size : 1;
}

bool lw_spatial_coupling_slides(const lw_spatial_coupling *c)
{
    for (int i = 0; i < c->n; i++)
        if (c->of[i].of == LW_OF_SLIDE)
            return true;
    return false;
}

void lw_spatial_measure_name(const lw_spatial *m, lw_spatial_measure of, char *text, size_t size)
{
    static const char *const word[] = { "x", "y", "z", "turn about x", "turn about y", "turn about z" };
    if (of.of >= LW_OF_X)
        snprintf(text, size, "%s of %s", word[of.of - LW_OF_X], m->tracer[of.index].name);
    else if (m->joint[of.index].kind == LW_SPATIAL_CYLINDRICAL && of.of == LW_OF_SLIDE)
        snprintf(text, size, "slide of %s", m->joint[of.index].name);
    else
        snprintf(text, size, "%s", m->joint[of.index].name);
}

bool lw_spatial_is_planar(const lw_spatial *m, lw_vec3 *normal)
{
    static const double parallel = 1e-9;
    bool known = false;
    if (m->n_elastic > 0)
        return false;                        /* links bend out of the plane, too */
    for (int j = 0; j < m->n_joint; j++) {
        const lw_spatial_joint *p = &m->joint[j];
        if (p->kind == LW_SPATIAL_FIXED || p->kind == LW_SPATIAL_PRISMATIC)
            continue;
        if (p->kind != LW_SPATIAL_REVOLUTE && p->kind != LW_SPATIAL_PLANAR)
            return false;
        if (!known)
            *normal = p->axis;
        known = true;
        if (lw_v3_norm(lw_v3_cross(*normal, p->axis)) > parallel)
            return false;
    }
    for (int j = 0; known && j < m->n_joint; j++)
        if (m->joint[j].kind == LW_SPATIAL_PRISMATIC && fabs(lw_v3_dot(*normal, m->joint[j].axis)) > parallel)
            return false;
    return known;
}

/* ---- planar models in space -------------------------------------------------------------------------------------- */

static lw_vec3 in_plane(lw_vec2 a) { return lw_v3(a.x, a.y, 0); }

static lw_spatial_joint joint_of(const lw_model *p, int j)
{
    const lw_joint *from = &p->linkage.joint[j];
    lw_spatial_joint to = { .link = { from->link[0], from->link[1] }, .at = in_plane(from->at), .axis = lw_v3(0, 0, 1), .stop = p->stop[j],
                            .friction = p->friction[j], .clearance = p->clearance[j] };
    memcpy(to.name, from->name, sizeof to.name);
    switch (from->kind) {
    case LW_JOINT_REVOLUTE:
        to.kind = LW_SPATIAL_REVOLUTE;
        if (from->link[1] == p->linkage.ground)          /* a pin at the ground turns as the other link does, whichever is named first */
            to.link[0] = from->link[1], to.link[1] = from->link[0];
        return to;
    case LW_JOINT_SLIDER: to.kind = LW_SPATIAL_PRISMATIC, to.axis = in_plane(from->along); return to;
    case LW_JOINT_SLOT:   to.kind = LW_SPATIAL_PLANAR, to.second = in_plane(from->along);  return to;
    case LW_JOINT_FIXED:  to.kind = LW_SPATIAL_FIXED;  break;
    case LW_JOINT_GEAR:   to.kind = LW_SPATIAL_FREE, to.link[0] = to.link[1] = -1; break;
    case LW_JOINT_FREE:   to.kind = LW_SPATIAL_FREE;   break;
    }
    to.axis = lw_v3(0, 0, 0);
    return to;
}

lw_status lw_spatial_joint_by_joint(const lw_model *p, lw_spatial *m, lw_error *e)
{
    const lw_assembly *k = &p->linkage;
    size_t joints = 2*(size_t)k->n_joint + 1, links = (size_t)(k->n_link + k->n_joint) + 1;
    lw_status s = LW_OK;
    *m = (lw_spatial){ .n_link = k->n_link, .ground = k->ground, .gravity = in_plane(p->gravity), .units = k->units };
    memcpy(m->name, k->name, sizeof m->name);
    m->body = calloc(links, sizeof *m->body);
    m->joint = calloc(joints, sizeof *m->joint);
    m->input = calloc((size_t)k->n_input + 1, sizeof *m->input);
    m->tracer = calloc((size_t)k->n_tracer + 1, sizeof *m->tracer);
    m->spring = calloc((size_t)p->n_spring + 1, sizeof *m->spring);
    m->joint_spring = calloc((size_t)p->n_joint_spring + 1, sizeof *m->joint_spring);
    m->elastic = calloc(links, sizeof *m->elastic);
    if (!m->body || !m->joint || !m->input || !m->tracer || !m->spring || !m->joint_spring || !m->elastic)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < k->n_link; i++) {
        const lw_body *b = &p->body[i];
        lw_spatial_body *to = &m->body[i];
        *to = (lw_spatial_body){ .given = b->given, .mass = b->mass, .centre = in_plane(b->centre),
                                 .inertia = { 0.5*b->inertia, 0.5*b->inertia, b->inertia } };
        memcpy(to->name, k->link_name[i], sizeof to->name);
    }
    for (int j = 0; s == LW_OK && j < k->n_joint; j++)
        m->joint[m->n_joint++] = joint_of(p, j);
    for (int i = 0; s == LW_OK && i < lw_assembly_free_inputs(k); i++) {
        const lw_input *in = &k->input[i];
        m->input[m->n_input++] = (lw_spatial_input){ .measure = { lw_joint_slides(k->joint[in->joint].kind) ? LW_OF_SLIDE : LW_OF_TURN,
            in->joint }, .value = in->value, .has_range = in->first != in->last, .first = in->first, .last = in->last };
    }
    for (int i = 0; s == LW_OK && i < k->n_tracer; i++) {
        lw_spatial_tracer *to = &m->tracer[m->n_tracer++];
        *to = (lw_spatial_tracer){ .link = k->tracer[i].link, .at = in_plane(k->tracer[i].at),
                                   .frame = lw_quaternion_of_vector(lw_v3(0, 0, k->tracer[i].angle)) };
        memcpy(to->name, k->tracer[i].name, sizeof to->name);
    }
    for (int i = 0; s == LW_OK && i < p->n_spring; i++) {
        m->spring[m->n_spring] = p->spring[i];
        m->spring[m->n_spring++].law = NULL;
    }
    for (int i = 0; s == LW_OK && i < p->n_joint_spring; i++) {
        const lw_joint_spring *c = &p->joint_spring[i];
        lw_spatial_joint_spring *to = &m->joint_spring[m->n_joint_spring++];
        *to = (lw_spatial_joint_spring){ .measure = { lw_joint_slides(k->joint[c->joint].kind) ? LW_OF_SLIDE : LW_OF_TURN, c->joint },
                                         .stiffness = c->stiffness, .damping = c->damping, .free = c->free };
        memcpy(to->name, c->name, sizeof c->name);
    }
    if (s != LW_OK)
        lw_spatial_free(m);
    return s;
}

/* Refuse what stays in the plane. */
static lw_status check_parts(const lw_model *p, lw_error *e)
{
    const lw_assembly *k = &p->linkage;
    if (p->n_elastic)
        return lw_error_set(e, LW_E_KIND, "a planar model with elastic links stays in the plane: write its places with three numbers");
    for (int j = 0; j < k->n_joint; j++)
        if (lw_joint_has_ratio(k->joint[j].kind) || lw_joint_freedoms(k->joint[j].kind) == 3)
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a %s: models with such joints stay in the plane", k->joint[j].name,
                                lw_joint_word(k->joint[j].kind));
    for (int i = 0; i < k->n_input; i++)
        if (k->input[i].ratio != 0)
            return lw_error_set(e, LW_E_KIND, "input \"%s\" is tied to another one: such models stay in the plane",
                                k->joint[k->input[i].joint].name);
    for (int i = 0; i < p->n_spring + p->n_joint_spring; i++) {
        bool between = i < p->n_spring;
        const lw_joint_spring *at_joint = &p->joint_spring[between ? 0 : i - p->n_spring];
        if (between ? p->spring[i].law != NULL : at_joint->law != NULL)
            return lw_error_set(e, LW_E_KIND, "spring \"%s\" has a law: such models stay in the plane",
                                between ? p->spring[i].name : at_joint->name);
    }
    return LW_OK;
}

/* A pin in a slot: the joint becomes a slide on link 0, and a pin behind the joints of the file joins its runner to link 1. */
static void split_slot(lw_spatial *m, int j)
{
    lw_spatial_joint slide = m->joint[j], pin = slide;
    lw_spatial_body *runner = &m->body[m->n_link];
    pin.kind = LW_SPATIAL_REVOLUTE;
    pin.stop = (lw_joint_stop){ .has_least = false };
    snprintf(pin.name, sizeof pin.name, "%.24s pin", slide.name);
    slide.kind = LW_SPATIAL_PRISMATIC;
    slide.axis = slide.second;
    slide.second = pin.second = lw_v3(0, 0, 0);
    slide.link[1] = pin.link[0] = m->n_link++;
    snprintf(runner->name, sizeof runner->name, "%.20s runner", slide.name);
    m->joint[j] = slide;
    m->joint[m->n_joint++] = pin;
}

lw_status lw_spatial_of_planar(const lw_model *p, lw_spatial *m, lw_error *e)
{
    *m = (lw_spatial){ .n_link = 0 };
    lw_status s = check_parts(p, e);
    if (s == LW_OK)
        s = lw_spatial_joint_by_joint(p, m, e);
    for (int j = 0; s == LW_OK && j < p->linkage.n_joint; j++)
        if (p->linkage.joint[j].kind == LW_JOINT_SLOT)
            split_slot(m, j);
    return s;
}
