#include "base/real.h"
#include "grammar/model/model_internal.h"

#include <stdlib.h>
#include <string.h>

lw_status lw_model_reserve(lw_model *m)
{
    size_t joints = (size_t)m->linkage.n_joint, links = (size_t)m->linkage.n_link, inputs = (size_t)m->linkage.n_input;
    m->motion = calloc(inputs + 1, sizeof *m->motion);
    m->has_speed = calloc(inputs + 1, sizeof *m->has_speed);
    m->speed = calloc(inputs + 1, sizeof *m->speed);
    m->body = calloc(links + 1, sizeof *m->body);
    m->friction = calloc(joints + 1, sizeof *m->friction);
    m->stop = calloc(joints + 1, sizeof *m->stop);
    m->clearance = calloc(joints + 1, sizeof *m->clearance);
    m->elastic = calloc(links + 1, sizeof *m->elastic);
    m->small = malloc(sizeof *m->small);
    if (m->small && lw_assembly_linkage(&m->linkage, m->small, NULL) != LW_OK) {
        free(m->small);
        m->small = NULL;
    } else if (!m->small)
        return LW_E_MEMORY;
    return m->motion && m->has_speed && m->speed && m->body && m->elastic && m->friction && m->stop
        && m->clearance ? LW_OK : LW_E_MEMORY;
}

lw_status lw_model_from_linkage(const lw_linkage *linkage, lw_model *m)
{
    return lw_model_from_assembly(LW_VIEW(linkage), m);
}

lw_status lw_model_from_assembly(const lw_assembly *linkage, lw_model *m)
{
    memset(m, 0, sizeof *m);
    lw_status s = lw_assembly_copy(linkage, &m->linkage);
    if (s == LW_OK)
        s = lw_model_reserve(m);
    if (s != LW_OK)
        lw_model_free(m);
    return s;
}

lw_status lw_model_small(const lw_model *m, const lw_linkage **linkage, lw_error *e)
{
    lw_linkage any;
    *linkage = m->small;
    return *linkage ? LW_OK : lw_assembly_linkage(&m->linkage, &any, e);
}

void lw_states_expressions(const lw_states *s, lw_expression_sink *see, void *context)
{
    for (int i = 0; i < s->n_state; i++)
        see(context, s->state[i].rate);
}

void lw_model_expressions(const lw_model *m, lw_expression_sink *see, void *context)
{
    for (int i = 0; i < m->linkage.n_input; i++)
        see(context, m->motion[i]);
    for (int i = 0; i < m->n_spring; i++)
        see(context, m->spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        see(context, m->joint_spring[i].law);
    for (int i = 0; i < m->n_force; i++) {
        see(context, m->force[i].force[0]);
        see(context, m->force[i].force[1]);
        see(context, m->force[i].torque[2]);
    }
    lw_states_expressions(&m->states, see, context);
}

lw_status lw_model_drive(lw_model *m, int input, const char *motion, lw_error *e)
{
    return lw_motion_replace(motion, &m->n_profile, &m->profile, &m->motion[input], &m->has_speed[input], e);
}

void lw_states_free(lw_states *s)
{
    for (int i = 0; i < s->n_state; i++) {
        lw_expression_free(s->state[i].rate);
        lw_expression_free(s->state[i].start_at);
    }
    for (int i = 0; i < s->n_signal; i++)
        lw_expression_free(s->signal[i].value);
    for (int i = 0; i < 2; i++)
        lw_key_table_free(&s->named[i]);
    free(s->state), free(s->signal), free(s->rotor);
}

void lw_springs_and_forces_free(int n_spring, lw_spring *spring, int n_force, lw_force *force)
{
    for (int i = 0; i < n_spring; i++)
        lw_expression_free(spring[i].law);
    for (int i = 0; i < 6*n_force; i++)
        lw_expression_free(i%6 < 3 ? force[i/6].force[i%3] : force[i/6].torque[i%3]);
    free(spring), free(force);
}

void lw_model_free(lw_model *m)
{
    for (int i = 0; m->motion && i < m->linkage.n_input; i++)
        lw_expression_free(m->motion[i]);
    lw_springs_and_forces_free(m->n_spring, m->spring, m->n_force, m->force);
    for (int i = 0; i < m->n_joint_spring; i++)
        lw_expression_free(m->joint_spring[i].law);
    lw_states_free(&m->states);
    for (int i = 0; m->elastic && i < m->linkage.n_link; i++)
        lw_elastic_free(&m->elastic[i]);
    for (int i = 0; i < m->n_shape; i++)
        free(m->shape[i].at);
    for (int i = 0; i < m->n_profile; i++)
        lw_moves_free(&m->profile[i]);
    void *const array[] = { m->profile, m->shape, m->contact, m->rope, m->motion,
                            m->has_speed, m->speed, m->body, m->joint_spring, m->motor, m->friction, m->stop,
                            m->clearance, m->small, m->elastic, m->beam };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
    lw_assembly_free(&m->linkage);
    memset(m, 0, sizeof *m);
}
