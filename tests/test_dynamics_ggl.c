/* The derivatives of the stabilised index-2 residual against central differences, off the constraints too. */
#include "mbs/formulations/ggl.c"
#include "tests/dynamics_run.h"
#include "tests/spatial_models.h"

#define MOST 120

/* A rod that slides through a swinging block, on a crank; %s: joint S a slider, or a pin of the block in a slot. */
static const char swinging_block[] =
    "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"crank\", \"mass\": 2, \"inertia\": 0.3, \"centre\": [0.2, 0.1]},"
    " {\"name\": \"rod\", \"mass\": 1, \"inertia\": 0.5, \"centre\": [1.1, 0.3]}%s], \"joints\": ["
    "{\"name\": \"O\", \"kind\": \"r\", \"links\": [\"ground\", \"crank\"], \"at\": [0, 0]},"
    "{\"name\": \"A\", \"kind\": \"r\", \"links\": [\"crank\", \"rod\"], \"at\": [0.3, 0.4]},%s],"
    "\"input\": {\"joint\": \"O\"}, \"gravity\": [0, -9.81]}";
static const char block[] = ", {\"name\": \"block\", \"mass\": 0.5, \"inertia\": 0.1, \"centre\": [1.2, 0.1]}";
static const char by_slider[] =
    "{\"name\": \"S\", \"kind\": \"t\", \"links\": [\"block\", \"rod\"], \"at\": [1.2, 0], \"along\": [0.9, -0.4]},"
    "{\"name\": \"C\", \"kind\": \"r\", \"links\": [\"block\", \"ground\"], \"at\": [1.2, 0]}";
static const char by_slot[] =
    "{\"name\": \"S\", \"kind\": \"p\", \"links\": [\"rod\", \"ground\"], \"at\": [1.2, 0], \"along\": [0.9, -0.4]}";

static void compare(lw_dynamics *made, lw_dynamics_report *report, lw_error *e)
{
    static double jac[MOST*MOST], value[MOST*MOST], by[4*MOST];
    static int at[5*MOST];
    lw_rng rng;
    lw_rng_seed(&rng, 7, 0);
    CHECK(lw_mbs_has_derivatives(made));
    lw_run run = { .d = made, .e = e, .r = report, .has_work = made->space != NULL };
    ggl g = { .run = &run, .q = made->n_q, .v = made->n_v, .c = made->n_kept, .least_mass = 0.01, .by = by, .n_at = at + 4*MOST,
              .at = made->space ? at : NULL };
    int n = unknowns(&g);
    double y[MOST], dy[MOST], up[MOST], down[MOST], c = 1.7, h = 1e-5;
    CHECK(n <= MOST);
    for (int i = 0; i < n; i++) {
        y[i] = lw_rng_range(&rng, -1, 1) + (i < g.q ? made->start_q[i] : 0);
        dy[i] = lw_rng_range(&rng, -1, 1);
    }
    if (made->eq.accept)
        made->eq.accept(made->eq.context, y);
    memset(jac, 0, sizeof jac);
    memset(value, 0, sizeof value);
    CHECK_INT(find_pattern(&g), LW_OK);
    CHECK_INT(jacobian(&g, 0, c, y, dy, value), LW_OK);
    for (int j = 0; j < n; j++)
        for (int k = g.columns.at[j]; k < g.columns.at[j + 1]; k++)
            jac[g.columns.row[k] + n*j] = value[k];      /* 0 outside the pattern */
    int work = run.has_work ? n - made->eq.n_z - 1 : -1, turned = g.at ? g.v : g.q;      /* its row is left out */
    for (int j = 0; j < n - g.q + turned; j++) {         /* in space along displacements, where quaternions keep their length */
        double was[MOST], rate[MOST], along[MOST] = { 0 };
        memcpy(was, y, sizeof was);
        memcpy(rate, dy, sizeof rate);
        if (g.at && j < turned)
            for (int k = 0; k < g.n_at[j]; k++)
                along[at[4*j + k]] = by[4*j + k];
        else
            along[j - turned + g.q] = 1;
        for (int side = 1; side >= -1; side -= 2) {
            for (int i = 0; i < n; i++)
                y[i] = was[i] + side*h*along[i], dy[i] = rate[i] + side*c*h*along[i];
            residual(&g, 0, y, dy, side > 0 ? up : down);
        }
        memcpy(y, was, sizeof was);
        memcpy(dy, rate, sizeof rate);
        find_columns(&g, y);
        for (int i = 0; i < n; i++) {
            double sum = 0;
            for (int k = 0; k < n; k++)
                sum += jac[i + n*k]*along[k];
            if (i != work)
                CHECK_NEAR(sum, (up[i] - down[i])/(2*h), 1e-6, 1e-6);
        }
    }
    lw_columns_free(&g.columns);
    lw_dynamics_free(made);
}

static void compare_derivatives(drun *d)
{
    lw_dynamics *made = NULL;
    CHECK_INT(lw_dynamics_make(&d->model, &d->o, &made, &d->e), LW_OK);
    if (made)
        compare(made, &d->report, &d->e);
}

/* A spatial slider-crank: revolute, universal, spherical and prismatic joints. */
TEST(joints_in_space)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics_report report = { 0 };
    lw_dynamics *made = NULL;
    OWN(lw_spatial) m = { 0 };
    load_spatial("slider-crank", &m);
    CHECK_OK(lw_dynamics_make_spatial(&m, &o, &made, &check_error));
    if (made)
        compare(made, &report, &check_error);
}

TEST(pins)
{
    static drun d;
    drun_read(&d, "examples/andrews.json");
    compare_derivatives(&d);
}

TEST(sliders)
{
    static drun d;
    char text[2048];
    snprintf(text, sizeof text, swinging_block, block, by_slider);
    drun_read_text(&d, text);
    compare_derivatives(&d);
}

TEST(slots)
{
    static drun d;
    char text[2048];
    snprintf(text, sizeof text, swinging_block, "", by_slot);
    drun_read_text(&d, text);
    compare_derivatives(&d);
    for (int f = 0; f < 2; f++)
        CHECK_INT(drun_to(&d, f ? LW_FORMULATION_GGL : LW_FORMULATION_INDEX1, 1e-9, 1, 1), LW_OK);
    double q[9], v[9];
    memcpy(q, d.q, sizeof q);
    memcpy(v, d.v, sizeof v);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-11, 1, 1), LW_OK);
    for (int i = 0; i < d.system.n_q; i++) {
        CHECK_NEAR(q[i], d.q[i], 1e-5, 0);
        CHECK_NEAR(v[i], d.v[i], 1e-4, 0);
    }
}
