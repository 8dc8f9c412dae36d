/* The four-link types: dimensions by name, no type forgotten, postures that say what their plan says. */
#include "check.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/types.h"

/* What a plan of the type with its tracer on the coupler must call its dimensions. */
static const struct { const char *type, *dims; } known[] = {
    { "RRRR", "r1 r2 r3 r4 cx cy x0 y0 theta0" },
    { "RRRP", "r2 r3 e1 cx cy x0 y0 theta0" },
    { "RRPR", "r1 r2 e3 cx cy x0 y0 theta0" },
    { "PRRP", "r3 beta1 cx cy x0 y0 theta0" },
    { "RPRR", "r1 e2 r4 cx cy x0 y0 theta0" },
    { "PRRR", "r3 r4 e1 cx cy x0 y0 theta0" },
    { "PRPR", "e3 e1 cx cy x0 y0 theta0" },
    { "RPRP", "e2 e1 cx cy x0 y0 theta0" },
    { "RPPR", "r1 beta3 cx cy x0 y0 theta0" },
    { "RRPP", "r2 cx cy x0 y0 theta0" },
    { "PPRR", "beta2 r4 cx cy x0 y0 theta0" },
};

static void names_of(const lw_plan *p, char *text, size_t size)
{
    size_t n = 0;
    for (int d = 0; d < p->n_dim; d++)
        n += (size_t)snprintf(text + n, size - n, "%s%s", d ? " " : "", p->dim[d].name);
}

TEST(dimensions_have_their_names)
{
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_linkage k;
        lw_plan p;
        char text[256];
        lw_type_linkage(lw_type_find(known[i].type), &k);
        CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1 }, &p, NULL), LW_OK);
        names_of(&p, text, sizeof text);
        CHECK_TEXT(text, known[i].dims);
        CHECK_INT(lw_plan_dim(&p, "theta0"), p.i_theta0);
        CHECK_INT(lw_plan_dim(&p, "r9"), -1);
    }
}

/* Every word of four letters R and P with at most two P, up to reading the loop from the other end of
 * the coupler's side, has its row: the first letter is the input, so the words are all different. */
TEST(no_type_is_forgotten)
{
    int n = 0;
    for (const lw_type *t = lw_type_table; t->letters; t++) {
        n++;
        CHECK_INT(t->input_is_slider, t->letters[0] == 'P');
        CHECK(lw_type_find(t->name) == t && lw_type_find(t->letters) == t);
        for (const lw_type *o = lw_type_table; o != t; o++)
            CHECK(strcmp(o->letters, t->letters) != 0 && strcmp(o->name, t->name) != 0);
    }
    CHECK_INT(n, 1 + 4 + 6);                          /* no slider, one, two of four joints */
    CHECK(lw_type_find("RPPP") == NULL && lw_type_find("") == NULL && lw_type_find(NULL) == NULL);
}

TEST(postures_are_sound)
{
    for (const lw_type *t = lw_type_table; t->letters; t++) {
        lw_linkage k;
        lw_plan p;
        lw_posture posture;
        double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
        lw_type_linkage(t, &k);
        CHECK_OK(lw_linkage_check(&k, &check_error));
        CHECK_INT(lw_linkage_mobility(&k), 1);
        CHECK_OK(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &p, &check_error));
        CHECK_OK(lw_plan_read(&p, &k, dim, mode, &input, &check_error));
        CHECK_INT(p.input_is_slider, t->input_is_slider);
        CHECK_NEAR(k.input[0].value, input, 1e-15, 0);
        CHECK_INT(lw_posture_solve(&p, dim, mode, input, 0, &posture), LW_OK);
        CHECK(posture.margin > 0.1);
        CHECK_POINT(posture.tracer[0][0], k.tracer[0].at.x, k.tracer[0].at.y, 4e-15, 0);
    }
}
