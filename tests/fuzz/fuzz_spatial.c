/* Any bytes are a spatial model with sane numbers, which closes in its posture, or have an error with a place. */
#include <math.h>

#include "mbs/space/space_solve.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static lw_spatial m;
    lw_error e = { .text = "" };
    lw_status s = lw_spatial_read((const char *)data, size, "f", &m, &e);
    lw_spatial_text((const char *)data, size);
    if (refused(s, &e))
        return 0;
    lw_space space;
    demand(m.ground >= 0 && m.ground < m.n_link);
    for (int i = 0; i < m.n_link; i++)
        demand(m.body[i].mass >= 0 && isfinite(m.body[i].mass) && isfinite(m.body[i].inertia[3]));
    for (int j = 0; j < m.n_joint; j++)
        demand(m.joint[j].link[0] != m.joint[j].link[1]);
    if (m.n_link < 100 && m.n_joint < 100 && lw_space_make(&m, &space, &e) == LW_OK) {
        lw_space_rows_set z;
        double *metric = calloc((size_t)space.n_v + 1, sizeof *metric);
        lw_space_metric(&space, metric);
        if (metric && lw_space_rows_make(&space, NULL, 0, metric, space.start, &z, &e) == LW_OK) {
            lw_space_rows_fill(&z, space.start, NULL);
            for (int r = 0; r < z.n_row; r++)
                demand(fabs(z.phi[r]) < 1e-6);
            lw_space_rows_free(&z);
        }
        free(metric);
        lw_space_free(&space);
    }
    lw_spatial_free(&m);
    return 0;
}
