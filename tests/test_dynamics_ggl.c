/* The derivatives of the stabilised index-2 residual against central differences, off the constraints too. */
#include "mbs/dynamics/dynamics_ggl.c"
#include "base/rng.h"
#include "tests/dynamics_run.h"

#define MOST 120

/* A rod that slides through a swinging block, on a crank; %s: joint S a slider, or a pin of the block in a slot. */
static const char swinging_block[] =
    "{\"linkwright\": 1, \"links\": [\"ground\","
    " {\"name\": \"crank\", \"mass\": 2, \"inertia\": 0.3, \"centre\": [0.2, 0.1]},"
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

static void compare_derivatives(drun *d)
{
    static double jac[MOST*MOST], value[MOST*MOST];
    lw_dynamics *made = NULL;
    lw_rng rng;
    lw_rng_seed(&rng, 7, 0);
    CHECK_INT(lw_dynamics_make(&d->model, &d->o, &made, &d->e), LW_OK);
    if (!made)
        return;
    CHECK(lw_mbs_has_derivatives(made));
    lw_run run = { .d = made, .e = &d->e, .r = &d->report };
    ggl g = { .run = &run, .q = made->n_q, .c = made->n_kept, .least_mass = 0.01 };
    int n = 2*(g.q + g.c);
    double y[MOST], dy[MOST], up[MOST], down[MOST], c = 1.7, h = 1e-5;
    CHECK(n <= MOST);
    for (int i = 0; i < n; i++) {
        y[i] = lw_rng_range(&rng, -1, 1) + (i < g.q ? made->start_q[i] : 0);
        dy[i] = lw_rng_range(&rng, -1, 1);
    }
    memset(jac, 0, sizeof jac);
    memset(value, 0, sizeof value);
    CHECK_INT(find_pattern(&g), LW_OK);
    CHECK_INT(jacobian(&g, 0, c, y, dy, value), LW_OK);
    for (int j = 0; j < n; j++)
        for (int k = g.columns.at[j]; k < g.columns.at[j + 1]; k++)
            jac[g.columns.row[k] + n*j] = value[k];      /* 0 outside the pattern */
    for (int j = 0; j < n; j++) {
        double was = y[j], rate = dy[j];
        y[j] = was + h, dy[j] = rate + c*h;
        residual(&g, 0, y, dy, up);
        y[j] = was - h, dy[j] = rate - c*h;
        residual(&g, 0, y, dy, down);
        y[j] = was, dy[j] = rate;
        for (int i = 0; i < n; i++)
            CHECK_NEAR(jac[i + n*j], (up[i] - down[i])/(2*h), 1e-7, 1e-7);
    }
    lw_columns_free(&g.columns);
    lw_dynamics_free(made);
}

TEST(pins)
{
    static drun d;
    drun_read(&d, "examples/andrews.json");
    compare_derivatives(&d);
    lw_model_free(&d.model);
}

TEST(sliders)
{
    static drun d;
    char text[2048];
    snprintf(text, sizeof text, swinging_block, block, by_slider);
    drun_read_text(&d, text);
    compare_derivatives(&d);
    lw_model_free(&d.model);
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
    lw_model_free(&d.model);
}
