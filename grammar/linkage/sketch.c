#include "grammar/linkage/sketch.h"

#include <stdio.h>
#include <string.h>

static lw_vec2 anywhere(lw_rng *rng)
{
    double x = lw_rng_uniform(rng), y = lw_rng_uniform(rng);
    return lw_v2(x, y);
}

static void sketch_joint(const lw_mechanism *m, int i, lw_rng *rng, lw_joint *j)
{
    snprintf(j->name, sizeof j->name, "J%d", i + 1);
    j->kind = (lw_joint_kind)m->kind[i];
    j->link[0] = m->link[i][0];
    j->link[1] = m->link[i][1];
    if (j->link[1] == m->ground) {                       /* the ground first: an input is measured from it */
        j->link[0] = m->ground;
        j->link[1] = m->link[i][0];
    }
    j->at = anywhere(rng);
    double turn = lw_rng_range(rng, 0, 2*LW_PI), ratio = lw_rng_range(rng, 0.5, 3);
    if (lw_joint_slides(j->kind))
        j->along = lw_v2_polar(1, turn);
    if (lw_joint_has_ratio(j->kind))
        j->ratio = -ratio;
}

lw_status lw_linkage_sketch(const lw_mechanism *m, lw_rng *rng, lw_linkage *linkage)
{
    memset(linkage, 0, sizeof *linkage);
    if (m->ground == LW_NONE || m->output == LW_NONE)
        return LW_E_ARG;
    linkage->n_link = m->n_link;
    linkage->n_joint = m->n_joint;
    linkage->ground = m->ground;
    linkage->units = lw_units_si();
    for (int i = 0; i < m->n_link; i++) {
        snprintf(linkage->link_name[i], sizeof linkage->link_name[i], "L%d", i + 1);
        if (i == m->ground)
            snprintf(linkage->link_name[i], sizeof linkage->link_name[i], "ground");
    }
    for (int i = 0; i < m->n_joint; i++)
        sketch_joint(m, i, rng, &linkage->joint[i]);
    linkage->n_input = m->n_input;
    for (int i = 0; i < m->n_input; i++) {
        linkage->input[i].joint = m->input[i];
        linkage->input[i].value = lw_linkage_posture_input(linkage, m->input[i]);
    }
    linkage->n_tracer = 1;
    snprintf(linkage->tracer[0].name, sizeof linkage->tracer[0].name, "P");
    linkage->tracer[0].link = m->output;
    linkage->tracer[0].at = anywhere(rng);
    return LW_OK;
}
