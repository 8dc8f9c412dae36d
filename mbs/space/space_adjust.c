#include "mbs/space/space_adjust.h"

#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "mbs/constraints/adjust.h"
#include "mbs/space/space.h"

/* Dimensions of a joint: its place over the size of the model, turns of its axis and its second axis about two lines across. */
enum { AT = 0, AXIS = 3, SECOND = 5, DIMENSIONS = 7, POSTURES = 16 };

typedef struct drawing {
    lw_space s;
    lw_spatial *model;           /* adjusted                                 */
    const lw_spatial_joint *drawn;
    lw_space_frame *frame;       /* (n_body + 1)                             */
    double *sparse;              /* (n_joint_row * LW_SPACE_ROW)             */
} drawing;

static lw_vec3 turn(lw_vec3 axis, const double *by)
{
    if (!(lw_v3_norm(axis) > 0))
        return axis;
    lw_vec3 x = lw_v3_across(axis), y = lw_v3_cross(axis, x);
    lw_mat3 m = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3_add(lw_v3_scale(x, by[0]), lw_v3_scale(y, by[1]))));
    return lw_m3_apply(&m, axis);
}

static void change(void *context, const double *by)
{
    drawing *d = context;
    for (int i = 0; i < d->model->n_joint; i++, by += DIMENSIONS) {
        lw_spatial_joint *to = &d->model->joint[i];
        const lw_spatial_joint *from = &d->drawn[i];
        to->at = lw_v3_add(from->at, lw_v3_scale(lw_v3(by[AT], by[AT + 1], by[AT + 2]), d->s.unit));
        to->axis = turn(from->axis, by + AXIS);
        to->second = turn(from->second, by + SECOND);
    }
    lw_space_joints(&d->s, d->drawn);
}

static void rows(void *context, const double *place, double *phi, double *jac)
{
    drawing *d = context;
    const lw_space *s = &d->s;
    lw_space_place(s, place, d->frame);
    lw_space_rows(s, d->frame, phi, d->sparse);
    if (!jac)
        return;
    memset(jac, 0, (size_t)s->n_joint_row*(size_t)s->n_v*sizeof *jac);
    for (int i = 0; i < s->n_joint; i++)
        for (int r = s->joint[i].row; r < s->joint[i].row + lw_spatial_kind_of(s->joint[i].kind)->rows; r++)
            for (int c = 0; c < LW_SPACE_ROW; c++)
                if (s->joint[i].body[c/6] >= 0)
                    jac[(size_t)r*(size_t)s->n_v + (size_t)(6*s->joint[i].body[c/6] + c%6)] = d->sparse[r*LW_SPACE_ROW + c];
}

static void move(void *context, double *place, const double *by) { lw_space_move(&((drawing *)context)->s, place, by); }

void lw_space_adjusted_free(lw_space_adjusted *a)
{
    if (a->moved > 0 || a->turned > 0)
        free(a->model.joint);
    memset(a, 0, sizeof *a);
}

lw_status lw_space_adjust(const lw_spatial *m, lw_space_adjusted *out, lw_error *e)
{
    drawing d = { .model = &out->model, .drawn = m->joint };
    size_t joints = (size_t)m->n_joint*sizeof *m->joint;
    lw_spatial_joint *joint = malloc(joints + 1);
    *out = (lw_space_adjusted){ .model = *m };
    if (!joint)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    out->model.joint = memcpy(joint, m->joint, joints);
    out->model.n_coupling = 0;
    lw_status st = lw_space_make(&out->model, &d.s, e);
    if (st == LW_OK) {
        lw_adjustable a = { &d, d.s.n_q, d.s.n_v, d.s.n_joint_row, DIMENSIONS*m->n_joint, POSTURES, false, change, rows, move };
        size_t q = (size_t)d.s.n_q, dims = (size_t)a.n_dim;
        double *by = calloc(dims + q + (size_t)d.s.n_joint_row*LW_SPACE_ROW + 1, sizeof *by);
        d.frame = calloc((size_t)d.s.n_body + 1, sizeof *d.frame);
        if (by && d.frame) {
            double *place = memcpy(by + dims, d.s.start, q*sizeof *by);
            d.sparse = place + q;
            st = lw_adjust(&a, place, by, e);
        } else
            st = lw_error_set(e, LW_E_MEMORY, "out of memory");
        for (int i = 0; st == LW_OK && i < m->n_joint; i++) {
            out->moved = fmax(out->moved, lw_v3_norm(lw_v3_sub(joint[i].at, m->joint[i].at)));
            out->turned = fmax(out->turned, lw_greatest(DIMENSIONS - AXIS, by + (size_t)(DIMENSIONS*i + AXIS)));
        }
        free(by), free(d.frame);
    }
    lw_space_free(&d.s);
    out->model.n_coupling = m->n_coupling;
    if (st != LW_OK) {
        free(joint);
        out->model = *m;
    }
    return st;
}
