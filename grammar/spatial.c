/* grammar/spatial.c - a spatial model in memory: kinds of joints, size, motions, release. */
#include "grammar/spatial.h"

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
    for (int i = 0; i < m->n_spring; i++)
        lw_expression_free(m->spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        lw_expression_free(m->joint_spring[i].law);
    for (int i = 0; i < m->n_force; i++)
        for (int k = 0; k < 3; k++) {
            lw_expression_free(m->force[i].force[k]);
            lw_expression_free(m->force[i].torque[k]);
        }
    lw_states_free(&m->states);
    for (int i = 0; m->profile && i < m->n_profile; i++)
        lw_moves_free(&m->profile[i]);
    for (int i = 0; m->elastic && i < m->n_link; i++)
        lw_elastic_free(&m->elastic[i]);
    void *const array[] = { m->profile, m->body, m->joint, m->input, m->drive, m->tracer, m->spring, m->joint_spring,
                            m->force, m->motor, m->elastic, m->beam };
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

static int time_alone(void *context, const char *word, const char *name, char *why)
{
    (void)context, (void)why;
    return strcmp(word, "t") == 0 && !name ? lw_variable(LW_QUANTITY_T, 0) : -1;
}

static const struct lw_moves *find_profile(void *context, const char *name)
{
    const lw_spatial *m = context;
    return lw_moves_find(m->n_profile, m->profile, name);
}

lw_status lw_spatial_set_motion(lw_spatial *m, int i, const char *motion, lw_error *e)
{
    lw_expression *x;
    lw_expression_words words = { .context = m, .variable = time_alone, .moves = find_profile };
    lw_status s = lw_expression_parse_words(motion, strlen(motion), &words, &x, e);
    if (s != LW_OK)
        return s;
    lw_expression_free(m->input[i].motion);
    m->input[i].motion = x;
    m->input[i].has_speed = false;
    return LW_OK;
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

void lw_spatial_measure_name(const lw_spatial *m, lw_spatial_measure of, char *text, size_t size)
{
    static const char axis[] = "xyz";
    if (of.of >= LW_OF_X)
        snprintf(text, size, "%c of %s", axis[of.of - LW_OF_X], m->tracer[of.index].name);
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
