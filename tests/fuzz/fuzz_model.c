/* Any bytes are a model with a valid linkage and sane numbers, or have an error with a place. */
#include <math.h>

#include "grammar/model/model.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static lw_model m;
    lw_error e = { .text = "" };
    lw_status s = lw_model_read((const char *)data, size, "f", &m, &e);
    if (refused(s, &e))
        return 0;
    demand(lw_assembly_check(&m.linkage, &e) == LW_OK);
    for (int i = 0; i < m.linkage.n_link; i++)
        demand(m.body[i].mass >= 0 && m.body[i].inertia >= 0 && isfinite(m.body[i].mass));
    for (int i = 0; i < m.n_spring; i++)
        demand(m.spring[i].link[0] != m.spring[i].link[1] && m.spring[i].stiffness >= 0);
    for (int i = 0; i < m.n_force; i++)
        demand(m.force[i].force[0] || m.force[i].force[1] || m.force[i].torque[2]);
    lw_model_free(&m);
    return 0;
}
