/* Any bytes are a closed mesh with a volume and finite integrals, or have an error. */
#include <math.h>

#include "grammar/model/mesh.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_error e = { .text = "" };
    lw_mesh_integrals m;
    if (lw_mesh_read((const char *)data, size, "f", &m, &e) != LW_OK) {
        demand(e.text[0]);
        return 0;
    }
    demand(m.volume > 0 && isfinite(m.volume) && isfinite(m.centre.x + m.centre.y + m.centre.z));
    for (int i = 0; i < 6; i++)
        demand(isfinite(m.inertia[i]));
    return 0;
}
