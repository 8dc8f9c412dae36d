/* The four-link chains with a driven link at the ground.
 *
 * A chain is a loop of four links with at most two sliders.  With three or more sliders no pin turns, since the sum of
 * the turns around the loop is zero.  Such a chain is a wedge or a rigid body on slides, and its mobility is not
 * 3(P - 1) - 2 n1. */
#include "mbs/plan/types.h"

#include <string.h>

const lw_type lw_type_table[] = {
    { "RRRR", "fourbar",       "four-bar",                                    false },
    { "RRRP", "slidercrank",   "slider-crank",                                false },
    { "RRPR", "inverted",      "inverted slider-crank",                       false },
    { "PRRP", "trammel",       "elliptic trammel",                            true  },
    { "RPRR", "slottedcrank",  "slotted crank",                               false },
    { "PRRR", "sliderdriven",  "slider-driven crank",                         true  },
    { "PRPR", "sliderrocker",  "slider-driven rocking slide",                 true  },
    { "RPRP", "tangent",       "tangent mechanism",                           false },
    { "RPPR", "oldham",        "Oldham coupling",                             false },
    { "RRPP", "yoke",          "Scotch yoke",                                 false },
    { "PPRR", "wedge",         "slider-driven yoke",                          true  },
    { NULL, NULL, NULL, false }
};

const lw_type *lw_type_find(const char *name)
{
    for (const lw_type *t = lw_type_table; name && t->letters; t++)
        if (strcmp(t->letters, name) == 0 || strcmp(t->name, name) == 0)
            return t;
    return NULL;
}

/* A posture of each type that is far from singular: pins or slide points in loop order, and the directions of slides.
 * A slide point at the place of a neighbouring pin is the pin that slides. */
typedef struct posture { const char *letters; lw_vec2 at[4]; double slide[4]; } posture;

/* Joints: crank-ground, crank-coupler, coupler-rocker, rocker-ground. */
static const posture posture_table[] = {
    { "RRRR", { { 0, 0 }, { 0.5, 1 }, { 3, 2.5 }, { 3, 0 } },   { 0 } },
    { "RRRP", { { 0, 0 }, { 0.5, 1 }, { 3, 0.5 }, { 3, 0.5 } }, { 0, 0, 0, 0 } },
    { "RRPR", { { 0, 0 }, { 0.5, 1 }, { 3, 0 }, { 3, 0 } },     { 0, 0, -0.25, 0 } },
    { "PRRP", { { 2, 0 }, { 2, 0 }, { 0, 1.5 }, { 0, 1.5 } },   { 0, 0, 0, LW_PI/2 } },
    { "RPRR", { { 0, 0 }, { 1.5, 0.8 }, { 1.5, 0.8 }, { 3, 0 } }, { 0, 0.3, 0, 0 } },
    { "PRRR", { { -1, 1 }, { -1, 1 }, { 1, 2 }, { 0, 0 } },     { 0, 0, 0, 0 } },
    { "PRPR", { { -1, 1 }, { -1, 1 }, { 0, 0 }, { 0, 0 } },     { 0, 0, -0.6, 0 } },
    { "RPRP", { { 0, 0 }, { 1, 1.5 }, { 1, 1.5 }, { 1, 1.5 } }, { 0, 1.1, 0, 0 } },
    { "RPPR", { { 0, 0 }, { 1, 0.75 }, { 2, 0 }, { 2, 0 } },    { 0, 0.6435011087932844, 2.2, 0 } },
    { "RRPP", { { 0, 0 }, { 0.5, 1 }, { 0.5, 1 }, { 0, 0 } },   { 0, 0, LW_PI/2, 0 } },
    { "PPRR", { { 0, 0 }, { 1, 1 }, { 1, 1 }, { 0, 0 } },       { 0, LW_PI/3, 0, 0 } },
};

static void set_joint(lw_linkage *linkage, const posture *p, int i)
{
    static const char *const name[] = { "A", "B", "C", "D" };
    lw_joint *j = &linkage->joint[i];
    strcpy(j->name, name[i]);
    j->kind = p->letters[i] == 'R' ? LW_JOINT_REVOLUTE : LW_JOINT_SLIDER;
    j->link[0] = i;
    j->link[1] = (i + 1)%4;
    j->at = p->at[i];
    if (i == 3) {                                   /* the ground comes first, as at joint A */
        j->link[0] = 0;
        j->link[1] = 3;
    }
    if (lw_joint_translates(j->kind))
        j->along = lw_v2_polar(1, p->slide[i]);
}

static void name_links(lw_linkage *linkage, const lw_type *t)
{
    static const char *const pinned[] = { "ground", "crank", "coupler", "rocker" };
    for (int i = 0; i < 4; i++)
        strcpy(linkage->link_name[i], pinned[i]);
    if (t->letters[0] == 'P')
        strcpy(linkage->link_name[1], "slider");
    if (t->letters[3] == 'P')
        strcpy(linkage->link_name[3], t->letters[0] == 'P' ? "block" : "slider");
}

/* Set the input to the value that the plan reads (the ground frame lies along x in every posture). */
static void set_input(lw_linkage *linkage)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    if (lw_plan_make(linkage, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL) == LW_OK)
        lw_plan_read(&plan, linkage, dim, mode, &linkage->input[0].value, NULL);
}

void lw_type_linkage(const lw_type *t, lw_linkage *linkage)
{
    memset(linkage, 0, sizeof *linkage);
    const posture *p = posture_table;
    while (strcmp(p->letters, t->letters) != 0)
        p++;
    strcpy(linkage->name, t->name);
    linkage->n_link = linkage->n_joint = 4;
    linkage->n_input = linkage->n_tracer = 1;
    linkage->units = lw_units_si();
    name_links(linkage, t);
    for (int i = 0; i < 4; i++)
        set_joint(linkage, p, i);
    strcpy(linkage->tracer[0].name, "P");
    linkage->tracer[0].link = 2;
    linkage->tracer[0].at = lw_v2_add(lw_v2_scale(lw_v2_add(p->at[1], p->at[2]), 0.5), lw_v2(0.25, 1));
    set_input(linkage);
}
