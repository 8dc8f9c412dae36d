/* A model that can be read is simulated for some steps, put at rest, and asked for its vibrations: no crash, and every
 * sample's energy is finite. */
#include <math.h>
#include "linkwright.h"
#include "tests/fuzz/fuzz.h"

static lw_status look(void *context, const lw_simulation_sample *s)
{
    (void)context;
    if (!isfinite(s->kinetic) || !isfinite(s->t))
        abort();
    return LW_OK;
}

static lw_status look_at_vibration(void *context, const lw_vibration_info *v)
{
    (void)context;
    if (isnan(v->re) || isnan(v->im))
        abort();
    return LW_OK;
}

static void run(const lw_model *m, const char *analysis)
{
    lw_simulation_options o = lw_simulation_options_default();
    lw_simulation *s = NULL;
    lw_error e;
    o.analysis = analysis;
    o.to = 0.01;
    o.intervals = 3;
    o.tolerance = 1e-6;
    o.max_steps = 50;
    o.max_seconds = 1;
    if (lw_simulation_create(m, &o, &s, &e) == LW_OK)
        (void)lw_simulation_run(s, look, NULL, NULL, &e);
    lw_simulation_destroy(s);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_model *m = NULL;
    lw_error e;
    if (lw_model_parse((const char *)data, size, "f", &m, &e) != LW_OK)
        return 0;
    run(m, "transient");
    run(m, "static");
    run(m, "dynamic");
    (void)lw_model_vibrations(m, false, false, look_at_vibration, NULL, &e);
    lw_model_destroy(m);
    return 0;
}
