/* mbs/clearance/clearance_scene.c - a scene: which joints are opened, which are kept. */
#include "base/real.h"
#include "mbs/clearance/clearance.h"

#include <assert.h>
#include <stdlib.h>
#include "mbs/clearance/clearance_internal.h"

lw_clearance_options lw_clearance_options_default(void)
{
    return (lw_clearance_options){ .time = 1.25, .settle = 0.4, .tolerance = 1e-9, .speed = NAN,
                                   .max_step = 10000000 };
}

/* ---- what is refused ----------------------------------------------------------------------------- */

static lw_status check_journal(const lw_model *m, int j, lw_error *e)
{
    const lw_clearance *c = &m->clearance[j];
    const char *name = m->linkage.joint[j].name;
    if (!lw_joint_turns(m->linkage.joint[j].kind))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" is no pin: only pins (kind r) can have clearance", name);
    if (!(c->gap > 0.0) || !isfinite(c->gap))
        return lw_error_set(e, LW_E_ARG, "the gap of joint \"%s\" must be above 0", name);
    if (c->model == LW_CLEARANCE_LINK && (c->friction > 0.0 || m->friction[j].coefficient > 0.0))
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" has friction, but a massless link has no surface for it; leave "
                            "the friction out, or take a model with contact", name);
    bool stiff = c->model >= LW_CLEARANCE_MLSD;
    if (stiff && (!(c->stiffness > 0.0) || !(c->exponent >= 1.0) || !(c->damping >= 0.0)))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\": the model of clearance needs a stiffness above 0, an "
                            "exponent of 1 or more and a damping of 0 or more", name);
    return LW_OK;
}

static lw_status check_masses(const lw_model *m, lw_error *e)
{
    for (int l = 0; l < m->linkage.n_link; l++)
        if (l != m->linkage.ground && !m->body[l].given)
            return lw_error_set(e, LW_E_ARG, "link \"%s\" has no mass: motion with clearance needs mass, centre "
                                "and inertia of every moving link", m->linkage.link_name[l]);
    return LW_OK;
}

static lw_status find_journals(const lw_model *m, lw_clearance_scene *c, lw_error *e)
{
    for (int j = 0; j < m->linkage.n_joint; j++) {
        bool open = m->clearance[j].model != LW_CLEARANCE_NONE;
        if (!open)
            continue;
        lw_status s = check_journal(m, j, e);
        if (s != LW_OK)
            return s;
        if (c->n_journal == LW_CLEARANCE_JOINT_MAX)
            return lw_error_set(e, LW_E_ARG, "more than %d joints with clearance", LW_CLEARANCE_JOINT_MAX);
        lw_journal *p = &c->journal[c->n_journal++];
        *p = (lw_journal){ .joint = j, .c = &m->clearance[j], .pin = m->friction[j].radius };
        if (!(p->c->friction > 0.0) && m->friction[j].coefficient > 0.0) {
            p->own = *p->c;
            p->own.friction = m->friction[j].coefficient;
            p->own.friction_speed = lw_friction_joint_of(m, j).speed;
            p->c = &p->own;
        }
    }
    if (c->n_journal == 0)
        return lw_error_set(e, LW_E_ARG, "no joint has clearance: give one pin of the model a \"clearance\"");
    return LW_OK;
}

/* ---- making -------------------------------------------------------------------------------------- */

/* Find whole turns between the posture and the start of a motion. */
static void count_turns(lw_clearance_scene *c)
{
    for (int i = 0; i < c->m->linkage.n_input; i++) {
        const lw_expression *x = c->m->motion[i];
        const int *which;
        if (!x || !lw_joint_turns(c->s.joint[c->s.input_joint[i]].kind))
            continue;
        double t = 0.0, first = lw_expression_variables(x, &which) <= 1 ? lw_expression_value(x, &t) : NAN;
        if (isfinite(first))
            c->turns[i] = 2.0*LW_PI*round((first - c->s.input_value[i])/(2.0*LW_PI));
    }
}

/* Joints whose friction depends on a reaction: apart from the tree, so that the reaction is a multiplier. */
static void find_friction(lw_clearance_scene *c, const bool *opened, bool *apart)
{
    for (int j = 0; j < c->s.n_joint; j++) {
        if (opened[j] || !(c->m->friction[j].coefficient > 0.0))
            continue;
        apart[j] = true;
        c->friction_journal[c->n_friction] = -1;
        c->friction[c->n_friction++] = lw_friction_joint_of(c->m, j);
    }
    for (int i = 0; i < c->n_journal; i++) {
        const lw_journal *p = &c->journal[i];
        if (p->c->model != LW_CLEARANCE_ZERO || !(p->c->friction > 0.0))
            continue;
        c->friction_journal[c->n_friction] = i;
        c->friction[c->n_friction++] = (lw_friction_joint){ .joint = p->joint, .coefficient = p->c->friction,
                                                                 .speed = p->c->friction_speed, .lever_arm = p->pin };
    }
}

lw_status lw_clearance_make(const lw_model *m, lw_clearance_scene **scene, lw_error *e)
{
    *scene = NULL;
    if (m->states.n_state)
        return lw_error_set(e, LW_E_KIND, "the model has first-order states (\"%s\"), which runs with clearance do not know",
                            m->states.state[0].name);
    lw_clearance_scene *c = calloc(1, sizeof *c);
    if (!c)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a scene with clearance");
    c->m = m;
    lw_status s = find_journals(m, c, e);
    if (s == LW_OK)
        s = check_masses(m, e);
    if (s == LW_OK)
        s = lw_forces_system(m, false, &c->s, e);
    if (s == LW_OK && c->s.n_tie > 0)
        s = lw_error_set(e, LW_E_KIND, "input \"%s\" is tied to the first one, which is not possible with "
                         "clearance; give each input its \"motion\"",
                         m->linkage.joint[c->s.input_joint[c->s.n_input]].name);
    if (s == LW_OK)
        s = lw_forces_make(m, &c->s, NULL, &c->f, e);
    if (s != LW_OK) {
        lw_clearance_free(c);
        return s;
    }
    bool opened[LW_JOINT_MAX] = { false }, apart[LW_JOINT_MAX] = { false };
    for (int i = 0; i < c->n_journal; i++) {
        lw_journal *j = &c->journal[i];
        const lw_system_joint *p = &c->s.joint[j->joint];
        opened[j->joint] = true;
        for (int end = 0; end < 2; end++) {
            j->body[end] = p->body[end];
            j->arm[end] = p->arm[end];
        }
    }
    find_friction(c, opened, apart);
    assert(c->n_friction <= LW_JOINT_MAX);
    c->n_stop = lw_rigid_stops_find(m, &c->s, c->stop);
    if (c->n_stop > LW_CLEARANCE_STOP_MAX) {
        lw_clearance_free(c);
        return lw_error_set(e, LW_E_ARG, "more than %d rigid stops in a model with clearance", LW_CLEARANCE_STOP_MAX);
    }
    lw_tree_make(&c->s, opened, apart, &c->tree);
    count_turns(c);
    *scene = c;
    return LW_OK;
}

void lw_clearance_free(lw_clearance_scene *scene)
{
    if (scene) {
        lw_forces_free(&scene->f);
        lw_system_free(&scene->s);
    }
    free(scene);
}
