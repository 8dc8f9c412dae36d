#include "grammar/model.h"

#include <string.h>

void lw_model_from_linkage(const lw_linkage *k, lw_model *m)
{
    memset(m, 0, sizeof *m);
    m->linkage = *k;
}

static int time_alone(void *context, const char *word, const char *name, char *why)
{
    (void)context, (void)why;
    return strcmp(word, "t") == 0 && !name ? lw_variable(LW_QUANTITY_T, 0) : -1;
}

lw_status lw_model_drive(lw_model *m, int input, const char *motion, lw_error *e)
{
    lw_expression *x;
    lw_status s = lw_expression_parse(motion, strlen(motion), time_alone, NULL, &x, e);
    if (s != LW_OK)
        return s;
    lw_expression_free(m->motion[input]);
    m->motion[input] = x;
    m->has_speed[input] = false;
    return LW_OK;
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
