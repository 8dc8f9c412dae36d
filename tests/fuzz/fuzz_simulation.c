/* A model, in the plane or in space, of a family or alone, or a servo axis that can be read is simulated for some steps, put at rest, traced,
 * and asked for its mobility, vibrations or poles: no crash, and every sample's energy is finite. */
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

/* ---- space, servo axes ------------------------------------------------------------------------------------- */

static lw_status look_in_space(void *context, const lw_spatial_sample *s)
{
    (void)context;
    if (!isfinite(s->kinetic) || !isfinite(s->t) || !isfinite(s->residual))
        abort();
    return LW_OK;
}

static lw_status look_at_trace(void *context, double at, const double *input, const lw_frame_motion *tracer)
{
    const int *n = context;
    (void)input;
    for (int i = 0; i < *n; i++)
        if (!isfinite(tracer[i].place.x) || !isfinite(tracer[i].turn.w))
            abort();
    return isfinite(at) ? LW_OK : LW_E_NUMERIC;
}

static void run_in_space(const lw_spatial *m)
{
    static const char *const analyses[] = { "transient", "static", "dynamic" };
    lw_mobility_info info;
    lw_error e;
    int n = lw_spatial_count(m, 't');
    if (lw_spatial_count(m, 'l') > 30)
        return;
    for (int i = 0; i < 3; i++) {
        lw_simulation_options o = lw_simulation_options_default();
        o.analysis = analyses[i];
        o.to = 0.01;
        o.intervals = 3;
        o.tolerance = 1e-6;
        o.max_steps = 50;
        o.max_seconds = 1;
        (void)lw_spatial_simulate(m, &o, look_in_space, NULL, NULL, &e);
    }
    (void)lw_spatial_trace(m, false, 0, 0, 4, look_at_trace, &n, &e);
    (void)lw_spatial_trace(m, true, 0, 0.01, 2, look_at_trace, &n, &e);
    if (lw_spatial_analyse_mobility(m, 1e-8, 1, &info, &e) == LW_OK && info.freedom < 0)
        abort();
}

static void run_servo(const lw_servo *s)
{
    lw_servo_options o = lw_servo_options_default();
    lw_servo_report report;
    lw_error e;
    double re[16], im[16];
    int n = 0;
    o.to = 1e-3;
    o.intervals = 4;
    o.tolerance = 1e-6;
    if (lw_servo_run(s, &o, NULL, NULL, &report, &e) == LW_OK && (!isfinite(report.heat) || report.steps < 0))
        abort();
    if (lw_servo_poles(s, &n, re, im, &e) == LW_OK && (n < 0 || n > 16))
        abort();
}

/* A model text, in the plane or in space. */
static bool run_text(const char *text, size_t size)
{
    lw_model *m = NULL;
    lw_spatial *spatial = NULL;
    lw_error e;
    if (lw_spatial_text(text, size) && lw_spatial_parse(text, size, "f", &spatial, &e) == LW_OK)
        run_in_space(spatial);
    lw_spatial_destroy(spatial);
    if (spatial || lw_model_parse(text, size, "f", &m, &e) != LW_OK)
        return spatial != NULL;
    run(m, "transient");
    run(m, "static");
    run(m, "dynamic");
    (void)lw_model_vibrations(m, false, false, look_at_vibration, NULL, &e);
    lw_model_destroy(m);
    return true;
}

static void run_family(const lw_master *master)
{
    lw_variant *v = NULL;
    char *text = NULL;
    size_t size;
    lw_error e;
    if (lw_variant_create(master, &v) == LW_OK && lw_variant_text(v, &text, &size, &e) == LW_OK)
        (void)run_text(text, size);
    lw_free(text);
    lw_variant_destroy(v);
}

static int one_input(const uint8_t *data, size_t size)
{
    lw_servo *servo = NULL;
    lw_master *master = NULL;
    lw_error e;
    if (run_text((const char *)data, size))
        return 0;
    if (lw_servo_parse((const char *)data, size, "f", &servo, &e) == LW_OK)
        run_servo(servo);
    else if (lw_master_parse((const char *)data, size, "f", &master, &e) == LW_OK)
        run_family(master);
    lw_servo_destroy(servo);
    lw_master_destroy(master);
    return 0;
}
