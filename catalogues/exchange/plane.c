/* catalogues/exchange/plane.c - a planar model lent to the writers of spatial models. */
#include "catalogues/exchange/plane.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "catalogues/exchange/export.h"

/* Couple the coordinates of two joints: factor[0] q[0] + factor[1] q[1] keeps its value. */
static lw_status couple(lw_export_plane *p, const char *name, const char *more, const int joint[2], const double factor[2])
{
    lw_spatial_coupling *c = &p->space.coupling[p->space.n_coupling++];
    *c = (lw_spatial_coupling){ .n = 2, .of = calloc(2, sizeof *c->of), .factor = calloc(2, sizeof *c->factor) };
    if (!c->of || !c->factor)
        return LW_E_MEMORY;
    snprintf(c->name, sizeof c->name, "%s%s", name, more);
    for (int i = 0; i < 2; i++) {
        c->of[i] = (lw_spatial_measure){ lw_joint_slides(p->model.linkage.joint[joint[i]].kind) ? LW_OF_SLIDE : LW_OF_TURN, joint[i] };
        c->factor[i] = factor[i];
    }
    return LW_OK;
}

static lw_status add_couplings(lw_export_plane *p, lw_error *e)
{
    const lw_assembly *k = &p->model.linkage;
    lw_status s = LW_OK;
    p->space.coupling = calloc((size_t)(k->n_joint + k->n_input) + 1, sizeof *p->space.coupling);
    if (!p->space.coupling)
        return LW_E_MEMORY;
    for (int j = 0; s == LW_OK && j < k->n_joint; j++) {
        int joint[2];
        double sign[2];
        if (lw_joint_has_ratio(k->joint[j].kind) && (s = lw_export_gear(k, j, joint, sign, e)) == LW_OK)
            s = couple(p, k->joint[j].name, "", joint, (double[]){ k->joint[j].ratio*sign[0], -sign[1] });
    }
    for (int i = lw_assembly_free_inputs(k); s == LW_OK && i < k->n_input; i++)
        s = couple(p, k->joint[k->input[i].joint].name, " tie", (int[]){ k->input[0].joint, k->input[i].joint },
                   (double[]){ k->input[i].ratio, -1 });
    return s;
}

/* Lend the expressions and motors of the model, which lw_export_plane_free takes back. */
static lw_status lend(lw_export_plane *p)
{
    const lw_model *m = &p->model;
    lw_spatial *space = &p->space;
    space->motor = m->motor;
    space->n_motor = m->n_motor;
    for (int i = 0; i < space->n_input; i++)
        space->input[i].motion = m->motion[i];
    for (int i = 0; i < m->n_spring; i++)
        space->spring[i].law = m->spring[i].law;
    for (int i = 0; i < m->n_joint_spring; i++)
        space->joint_spring[i].law = m->joint_spring[i].law;
    space->force = calloc((size_t)m->n_force + 1, sizeof *space->force);
    if (!space->force)
        return LW_E_MEMORY;
    if (m->n_force)
        memcpy(space->force, m->force, (size_t)m->n_force*sizeof *m->force);
    space->n_force = m->n_force;
    return LW_OK;
}

lw_status lw_export_plane_make(const lw_assembly *linkage, const lw_model *m, lw_export_plane *p, lw_error *e)
{
    memset(p, 0, sizeof *p);
    lw_status s = lw_assembly_check(linkage, e);
    if (s != LW_OK)
        return s;
    p->given = m != NULL;
    if (m) {
        p->model = *m;
        p->model.linkage = *linkage;
    } else
        s = lw_model_from_assembly(linkage, &p->model);
    if (s == LW_OK)
        s = lw_spatial_joint_by_joint(&p->model, &p->space, e);
    if (s == LW_OK)
        s = lend(p);
    if (s == LW_OK)
        s = add_couplings(p, e);
    if (s == LW_OK && !p->space.name[0])
        strcpy(p->space.name, "linkage");
    return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory") : s;
}

void lw_export_plane_free(lw_export_plane *p)
{
    for (int i = 0; i < p->space.n_input; i++)
        p->space.input[i].motion = NULL;
    for (int i = 0; i < p->space.n_spring; i++)
        p->space.spring[i].law = NULL;
    for (int i = 0; i < p->space.n_joint_spring; i++)
        p->space.joint_spring[i].law = NULL;
    p->space.n_force = 0;
    p->space.motor = NULL;
    lw_spatial_free(&p->space);
    if (!p->given)
        lw_model_free(&p->model);
}
