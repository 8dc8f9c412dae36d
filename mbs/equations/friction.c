#include "mbs/equations/friction.h"

#include <assert.h>
#include <string.h>
#include "base/linalg.h"
#include "base/real.h"
#include "base/vec3.h"

static const double singular = 1e-3;         /* a determinant below this: the reactions are not determined */

lw_friction_joint lw_friction_joint_of(const lw_model *m, int j)
{
    const lw_friction *f = &m->friction[j];
    bool ideal = !(f->speed > 0);
    return (lw_friction_joint){ .joint = j, .coefficient = f->coefficient, .ideal = ideal,
                                .speed = ideal ? LW_FRICTION_SPEED : f->speed,
                                .lever_arm = lw_joint_turns(m->linkage.joint[j].kind) ? f->radius : 1 };
}

double lw_friction_push(const lw_friction_joint *f, double rate)
{
    return -f->coefficient*f->lever_arm*(f->held ? f->part : tanh(f->lever_arm*rate/f->speed));
}

double lw_friction_force(const lw_system *s, const lw_friction_joint *f, const double *q, const double *v,
                         double *force)
{
    lw_measure m;
    lw_measure_joint(s, f->joint, q, v, false, &m);
    double push = lw_friction_push(f, m.rate);
    memset(force, 0, (size_t)s->n_q*sizeof *force);
    for (int i = 0; i < 6; i++)
        if (m.body[i/3] >= 0)
            force[3*m.body[i/3] + i%3] += push*m.g[i];
    return push*m.rate;
}

lw_vec2 lw_friction_reaction(const lw_system *s, int joint, const double *multiplier)
{
    bool pin = lw_joint_turns(s->joint[joint].kind);
    return lw_v2(multiplier[0]/s->unit, pin ? multiplier[1]/s->unit : 0);
}

/* The size of reaction j of n, of which the last n_signed keep their sign. */
static double size_of(const double *r, int dim, bool is_signed)
{
    return is_signed ? r[0] : dim == 2 ? hypot(r[0], r[1]) : lw_v3_norm(lw_v3(r[0], r[1], r[2]));
}

lw_status lw_friction_sizes(int n, int n_signed, int dim, const double *rest, const double *response, double *size,
                            double *determinant)
{
    double matrix[LW_JOINT_MAX*LW_JOINT_MAX], diag[LW_JOINT_MAX], left[LW_JOINT_MAX], scale = 0;
    assert(n > 0 && n <= LW_JOINT_MAX && (dim == 2 || dim == 3));
    for (int j = 0; j < n; j++) {
        size[j] = size_of(rest + dim*j, dim, j >= n - n_signed);
        scale = fmax(scale, fabs(size[j]));
    }
    for (int pass = 0; pass < 60; pass++) {
        double off = 0;
        for (int j = 0; j < n; j++) {
            double r[3] = { rest[dim*j], rest[dim*j + 1], dim == 3 ? rest[dim*j + 2] : 0 };
            for (int k = 0; k < n; k++)
                for (int x = 0; x < dim; x++)
                    r[x] += size[k]*response[dim*(j + n*k) + x];
            bool is_signed = j >= n - n_signed;
            double norm = size_of(r, dim, is_signed);
            left[j] = norm - size[j];
            off = fmax(off, fabs(left[j]));
            for (int k = 0; k < n; k++) {
                const double *by = response + dim*(j + n*k);
                double dot = r[0]*by[0] + r[1]*by[1];
                for (int x = 2; x < dim; x++)
                    dot += r[x]*by[x];
                matrix[j + n*k] = (j == k) - (is_signed ? by[0] : norm > 0 ? dot/norm : 0);
            }
        }
        if (off <= 1e-13*scale && !(determinant && pass == 0))
            return LW_OK;
        lw_qr_factor(n, n, matrix, diag);
        double value = lw_qr_determinant(n, diag);
        if (determinant)
            *determinant = value;
        if (!((n_signed ? fabs(value) : value) > singular))
            break;
        lw_qr_solve(n, n, matrix, diag, left);
        for (int j = 0; j < n; j++) {
            size[j] += left[j];
            if (j < n - n_signed)
                size[j] = fmax(0, size[j]);
            scale = fmax(scale, fabs(size[j]));
        }
    }
    return LW_E_NUMERIC;
}

lw_status lw_friction_add(const lw_friction_scene *scene, int n, const lw_friction_joint *joint, double *response, double t,
                          int n_a, double *a, int n_l, double *l, double *size, double *determinant, lw_error *e)
{
    const int stride = n_a + n_l, dim = scene->dim;
    int n_signed = 0;
    assert(n > 0 && n <= LW_JOINT_MAX);
    double rest[3*LW_JOINT_MAX], *change = response + n*stride;
    for (int j = 0; j < n; j++) {
        n_signed += joint[j].joint < 0;
        scene->reaction(scene->context, j, l, rest + dim*j);
        for (int k = 0; k < n; k++)
            scene->reaction(scene->context, j, response + k*stride + n_a, change + dim*(j + n*k));
    }
    lw_status found = lw_friction_sizes(n, n_signed, dim, rest, change, size, determinant);
    if (found != LW_OK && n_signed > 0)      /* the caller of contacts knows what follows */
        return LW_OPEN;
    if (found != LW_OK)
        return lw_error_set(e, LW_E_NUMERIC, "friction at joint \"%s\" leaves its reaction undetermined for rigid "
                            "links (Painleve's paradox) at t = %.9g s; lower the coefficient or give the joint "
                            "compliance", scene->name(scene->context, 0), t);
    for (int k = 0; k < n; k++) {
        const double *from = response + k*stride;
        for (int i = 0; i < n_a; i++)
            a[i] += size[k]*from[i];
        for (int i = 0; i < n_l; i++)
            l[i] += size[k]*from[n_a + i];
    }
    return LW_OK;
}
