/* mbs/dynamics/dynamics_friction.c - Coulomb friction, regularised, of joints whose reactions it depends on itself.
 *
 * The reactions are the multipliers of the joints' rows (mbs/dynamics/friction.h); where they are not determined
 * (Painleve 1895) the run ends and says so. */
#include "mbs/dynamics/dynamics_internal.h"

#include <string.h>
#include "mbs/dynamics/friction.h"

double lw_mbs_friction_direction(const lw_dynamics *d, int joint, const double *q, const double *v, double *out)
{
    const lw_friction *p = &d->model->friction[joint];
    lw_measure m;
    lw_measure_joint(&d->s, joint, q, v, false, &m);
    double arm = d->s.joint[joint].kind == LW_JOINT_REVOLUTE ? p->radius : 1;
    double push = lw_friction_push(p->coefficient, p->speed, arm, m.rate);
    memset(out, 0, (size_t)d->n_q*sizeof *out);
    for (int i = 0; i < 6; i++)
        if (m.body[i/3] >= 0)
            out[3*m.body[i/3] + i%3] += push*m.g[i];
    return push*m.rate;
}

/* The reaction of a joint that presses, [N]: both rows of a pin, the row across a line. */
static lw_vec2 press(const lw_dynamics *d, int joint, const double *l)
{
    const lw_system_joint *j = &d->s.joint[joint];
    bool pin = j->kind == LW_JOINT_REVOLUTE;
    return lw_v2(l[j->row]/d->s.unit, pin ? l[j->row + 1]/d->s.unit : 0);
}

static lw_status undetermined(const lw_dynamics *d, int joint)
{
    return lw_error_set(d->e, LW_E_NUMERIC, "friction at joint \"%s\" leaves its reaction undetermined for rigid links "
                        "(Painleve's paradox); lower the coefficient or give the joint compliance",
                        d->model->linkage.joint[joint].name);
}

/* N (n) from the multipliers without friction and the responses. */
static lw_status find_presses(const lw_dynamics *d, const double *l, double *n)
{
    int count = d->n_friction, stride = d->n_q + d->n_c;
    lw_vec2 rest[LW_JOINT_MAX], response[LW_JOINT_MAX*LW_JOINT_MAX];
    for (int j = 0; j < count; j++) {
        rest[j] = press(d, d->friction[j], l);
        for (int k = 0; k < count; k++)
            response[j + count*k] = press(d, d->friction[j], d->response + k*stride + d->n_q);
    }
    return lw_friction_presses(count, rest, response, n) == LW_OK ? LW_OK : undetermined(d, d->friction[0]);
}

lw_status lw_mbs_friction(lw_dynamics *d, const double *q, const double *v, double *a, double *l, double *power)
{
    int stride = d->n_q + d->n_c;
    double n[LW_JOINT_MAX], unit_power[LW_JOINT_MAX];
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    lw_status s = LW_OK;
    for (int j = 0; s == LW_OK && j < d->n_friction; j++) {
        double *to = d->response + j*stride;
        unit_power[j] = lw_mbs_friction_direction(d, d->friction[j], q, v, d->force);
        s = lw_mbs_linear(d, d->force, d->rhs, to, to + d->n_q);
    }
    if (s == LW_OK)
        s = find_presses(d, l, n);
    for (int j = 0; s == LW_OK && j < d->n_friction; j++) {
        const double *from = d->response + j*stride;
        for (int i = 0; i < d->n_q; i++)
            a[i] += n[j]*from[i];
        for (int i = 0; i < d->n_c; i++)
            l[i] += n[j]*from[d->n_q + i];
        if (power)
            *power += n[j]*unit_power[j];
    }
    return s;
}
