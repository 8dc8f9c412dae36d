#include "grammar/model.h"

#include <string.h>

void lw_model_from_linkage(const lw_linkage *k, lw_model *m)
{
    memset(m, 0, sizeof *m);
    m->linkage = *k;
}

void lw_model_free(lw_model *m)
{
    for (int i = 0; i < LW_INPUT_MAX; i++)
        lw_expression_free(m->motion[i]);
    for (int i = 0; i < LW_LOAD_MAX; i++) {
        lw_expression_free(m->spring[i].law);
        lw_expression_free(m->joint_spring[i].law);
        lw_expression_free(m->force[i].fx);
        lw_expression_free(m->force[i].fy);
        lw_expression_free(m->force[i].torque);
    }
    memset(m, 0, sizeof *m);
}
