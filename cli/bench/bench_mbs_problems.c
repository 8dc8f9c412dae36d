/* cli/bench/bench_mbs_problems.c - the reference problems of `linkwright bench mbs`, their files, and a row of results. */
#include "cli/bench/bench_mbs.h"

#include <stdlib.h>
#include <string.h>

#include "base/growable_array.h"
#include "base/real.h"
#include "base/vec2.h"
#include "cli/program/data.h"
#include "mbs/dynamics/dynamics.h"

/* ---- errors ------------------------------------------------------------------------------------------------ */

static const double *place(const cli_mbs_motion *m, int k, int body) { return m->place + 3*(k*m->n_body + body); }

static double pendulum_error(const cli_mbs_motion *m, const cli_mbs_reference *r, double *off)
{
    double worst = 0;
    for (int k = 0; k < m->n_moment; k++) {
        const double *at = place(m, k, 0), *expected = r->value + k*r->n_column;
        worst = fmax(worst, hypot(at[0] - expected[1], at[1] - expected[2]));
    }
    *off = NAN;
    return worst;
}

/* Upper end of crank k; each crank is 1 m long and starts upright. */
static lw_vec2 crank_end(const cli_mbs_motion *m, int k, int crank)
{
    const double *at = place(m, k, crank);
    return lw_v2(at[0] - 0.5*sin(at[2]), at[1] + 0.5*cos(at[2]));
}

/* Error of the row of four-bars, whose cranks are the first bodies. *off: distance from the right assembly mode, |B_(i+1) - B_i - (1, 0)|; there the
 * couplers stay horizontal. */
static double four_bars_error(const cli_mbs_motion *m, const cli_mbs_reference *r, double *off)
{
    double worst = 0;
    *off = 0;
    for (int k = 0; k < m->n_moment; k++) {
        const double *expected = r->value + k*r->n_column;
        lw_vec2 b0 = crank_end(m, k, 0), before = b0;
        worst = fmax(worst, hypot(b0.x - expected[1], b0.y - expected[2]));
        for (int i = 1; i < (m->n_body + 1)/2; i++) {
            lw_vec2 b = crank_end(m, k, i);
            *off = fmax(*off, hypot(b.x - before.x - 1, b.y - before.y));
            before = b;
        }
    }
    return worst;
}

/* Error of the place of the tracer. */
static double space_error(const cli_mbs_motion *m, const cli_mbs_reference *r, double *off)
{
    double worst = 0;
    for (int k = 0; k < m->n_moment; k++) {
        const double *at = place(m, k, 0), *expected = r->value + k*r->n_column;
        worst = fmax(worst, hypot(hypot(at[0] - expected[0], at[1] - expected[1]), at[2] - expected[2]));
    }
    *off = NAN;
    return worst;
}

/* Error in the angles of the crank and of the links that pivot on the ground. */
static double andrews_error(const cli_mbs_motion *m, const cli_mbs_reference *r, double *off)
{
    static const struct { int body, column; } angle[] = { { 0, 1 }, { 2, 3 }, { 4, 5 }, { 6, 7 } };
    double worst = 0;
    for (int k = 0; k < m->n_moment; k++)
        for (int i = 0; i < 4; i++) {
            double expected = r->value[k*r->n_column + angle[i].column] - r->value[angle[i].column];
            worst = fmax(worst, fabs(place(m, k, angle[i].body)[2] - expected));
        }
    *off = NAN;
    return worst;
}

/* at 1e-13 the corrector of BDF reaches rounding error */
const cli_mbs_problem cli_mbs_problems[] = {
    { "pendulum", "simple pendulum (A01), 10 s", "place of the bob [m], every 0.1 s", "pendulum", 10, 12,
      pendulum_error, 0 },
    { "two-four-bars", "N-four-bar, N = 2 (A02), 10 s through ten singular postures", "place of B0 [m], every 0.1 s",
      "two-four-bars", 10, 12, four_bars_error, 0 },
    { "row-of-15", "N-four-bar, N = 15: 31 moving links, 10 s", "place of B0 [m], every 0.1 s", "row-of-15-four-bars",
      10, 12,
      four_bars_error, 15 },
    { "row-of-40", "N-four-bar, N = 40: 81 moving links, 10 s", "place of B0 [m], every 0.1 s", "row-of-40-four-bars",
      10, 10,
      four_bars_error, 40 },
    { "row-of-400", "N-four-bar, N = 400: 801 moving links, 10 s", "place of B0 [m], every 0.1 s",
      "row-of-400-four-bars", 10, 8,
      four_bars_error, 400 },
    { "andrews", "Andrews' squeezer (A03), 0.03 s", "angles [rad], every ms", "andrews", 0.03, 12, andrews_error, 0 },
    { "space-slider-crank", "spatial slider-crank (IFToMM), 1 s", "place of the slider [m], every 0.05 s", NULL, 1, 12,
      space_error, 0 },
    { "space-bricard", "Bricard's six-bar (A04), 10 s", "place of P3 [m], every 0.5 s", NULL, 10, 12, space_error, 0 },
    { "space-governor", "flyball governor (A05), stiff dampers, 1 s", "place of the slider [m], every 0.05 s", NULL, 1,
      10, space_error, 0 },
    { "space-chain", "chain of 100 bars in space, 0.2 s", "place of its end [m], every 0.01 s", NULL, 0.2, 12,
      space_error, 100 },
    { "space-arm", "arm with seven joints, falling, 1 s", "place of its tool [m], every 0.05 s", NULL, 1, 12, space_error, 0 },
    { "space-stewart", "Stewart platform on springs, 1 s", "place of its tool [m], every 0.05 s", NULL, 1, 12, space_error,
      0 },
    { "space-delta", "DELTA robot, inverse dynamics of 101 postures of a cycle", "torques of its drives [N m]", NULL, 0.1, 12,
      space_error, -1 },
    { "flexible-crank", "slider-crank with flexible coupler, 0.1 s", "elastic coordinates at 0.1 s [m]", NULL, 0.1, 13, NULL,
      0 },
    { "clearance", "four-bar with clearance, 80 r/min, seated, 1.25 s", "pin in its bush at 1.25 s [m]", NULL, 1.25, 13,
      NULL, 0 },
    { "clearance-250", "four-bar with clearance, 250 r/min, 1.25 s (chaotic: no error)", "", NULL, 1.25, 13, NULL, 0 },
    { "choice", "69 models by every formulation, and by auto", "", NULL, 0, 13, NULL, 0 },
    { .name = NULL }
};

lw_status cli_mbs_read(const char *name, const char *ending, char *path, char **text, size_t *size, lw_error *e)
{
    char file[128];
    snprintf(file, sizeof file, "mbs/%s.%s", name, ending);
    cli_data_path(file, path, CLI_PATH_SIZE);
    return lw_file_read(path, text, size, e);
}

cli_mbs_row *cli_mbs_add(cli_mbs *b, const char *problem, const char *solver, double tolerance)
{
    cli_mbs_row *more = lw_array_grow(b->row, b->n, &b->capacity, sizeof *more);
    if (!more)
        return NULL;
    b->row = more;
    cli_mbs_row *r = &b->row[b->n++];
    *r = (cli_mbs_row){ .problem = problem, .tolerance = tolerance, .make = NAN, .seconds = NAN, .error = NAN,
                        .off = NAN, .energy = NAN, .known = NAN };
    snprintf(r->solver, sizeof r->solver, "%s", solver);
    return r;
}

lw_status cli_mbs_own(const lw_dynamics_report *r, const lw_dynamics_options *o, lw_error *e)
{
    return o->formulation == LW_FORMULATION_AUTO || r->gave_up == LW_FORMULATION_AUTO ? LW_OK
         : lw_error_set(e, LW_STOPPED, "%s gave up at t = %.6g s", lw_formulation_name(o->formulation), r->gave_up_t);
}
