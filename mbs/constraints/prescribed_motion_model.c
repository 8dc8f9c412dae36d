/* mbs/constraints/prescribed_motion_model.c - the inputs of a model as functions of time. */
#include "mbs/constraints/prescribed_motion.h"

#include "grammar/model/model.h"

void lw_prescribed_motion_of_model(void *context, double t, int order, double *u)
{
    const lw_model *m = context;
    double at[LW_SERIES_ORDER_MAX + 1] = { t, 1 };
    for (int i = 0; i < m->linkage.n_input; i++) {
        double *out = u + i*(order + 1);
        if (m->motion[i]) {
            lw_expression_series(m->motion[i], order, at, out);
            continue;
        }
        double ratio = m->linkage.input[i].ratio;
        for (int k = 0; k <= order; k++)
            out[k] = ratio != 0 ? ratio*u[k] : 0;
        out[0] = ratio != 0 ? lw_assembly_tied_input(&m->linkage, i, u[0]) : m->linkage.input[i].value;
    }
}

void lw_prescribed_motion_first_alone(void *context, double t, int order, double *u)
{
    const lw_assembly *a = &((const lw_model *)context)->linkage;
    for (int i = 0; i < lw_assembly_free_inputs(a); i++)
        for (int k = 0; k <= order; k++)
            u[i*(order + 1) + k] = k == 0 ? (i == 0 ? t : a->input[i].value) : i == 0 && k == 1;
}
