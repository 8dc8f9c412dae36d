/* Rows by the plan of the groups, from seeds on the curve of postures. */
#include "cli/motion/trace_groups.h"

#include <math.h>
#include <stdlib.h>

#define LEAST_MARGIN 1e-5              /* nearer to a dead point of a group the curve is asked       */

cli_groups *cli_groups_make(const lw_linkage *k, unsigned tracers)
{
    cli_groups *g = calloc(1, sizeof *g);
    double input;
    if (g)
        g->k = *k;
    if (g && lw_plan_make(k, (lw_plan_options){ .tracers = tracers, .all_joints = true, .kind = LW_PLAN_HIGHER },
                          &g->plan, NULL) == LW_OK
        && lw_plan_read(&g->plan, k, g->dim, g->mode, &input, NULL) == LW_OK)
        return g;
    free(g);
    return NULL;
}

static bool solve(cli_groups *g, double u)
{
    return lw_pose_solve(&g->plan, g->dim, g->mode, u + g->more, CLI_ROW_ORDER, &g->pose) == LW_OK
           && g->pose.margin > LEAST_MARGIN;
}

void cli_groups_seed(cli_groups *g, const lw_system *s, const double *q, double u, const cli_rows *rows,
                     const cli_row *row)
{
    double dim[LW_DIM_MAX], input;
    lw_system_write(s, q, &g->k);
    g->seeded = lw_plan_read(&g->plan, &g->k, dim, g->mode, &input, NULL) == LW_OK;
    g->more = input - u;
    g->seeded = g->seeded && solve(g, u);
    for (int i = 0; i < g->k.n_tracer && g->seeded; i++) {
        g->angle[i] = row->value[i][8]*rows->k->units.radian;
        g->tool[i] = g->angle[i] - g->pose.angle[g->k.tracer[i].link][0];
    }
}

bool cli_groups_row(cli_groups *g, double u, double by, const cli_rows *rows, cli_row *row)
{
    if (!g->seeded || !solve(g, u))
        return false;
    for (int i = 0; i < g->k.n_tracer; i++) {
        lw_vec2 p[CLI_ROW_ORDER + 1];
        double a[CLI_ROW_ORDER + 1], scale = 1;
        if (!(rows->tracers >> i & 1))
            continue;
        const double *turn = g->pose.angle[g->k.tracer[i].link];
        for (int order = 0; order <= CLI_ROW_ORDER; order++, scale *= by) {
            p[order] = lw_v2_scale(g->pose.tracer[i][order], scale);
            a[order] = turn[order]*scale;
        }
        g->angle[i] += remainder(turn[0] + g->tool[i] - g->angle[i], 2*LW_PI);
        cli_row_values(rows, p, a, g->angle[i], row->value[i]);
    }
    row->rates = true;
    return true;
}
