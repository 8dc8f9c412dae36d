/* The loads of the drives of a model in a work cycle. */
#include "cli/motion/drive.h"


#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "mbs/drives/load.h"

static void print(const cli_call *call, FILE *f, int n, const lw_load *load)
{
    enum { VALUES = 9 };
    static const char *const heads[] = { "peak", "rms", "speed", "peak power", "braking power", "mean power", "energy out",
                                         "energy back" };
    static const char *const turning[] = { "N m", "N m", "rad/s", "W", "W", "W", "J", "J", "kg m^2" };
    static const char *const sliding[] = { "N", "N", "m/s", "W", "W", "W", "J", "J", "kg" };
    static const char *const keys[] = { "speed_peak", "power_peak", "power_least", "power_mean", "energy_out",
                                        "energy_back" };
    cli_json j = cli_json_begin(f, 2);
    if (call->common.json) {
        cli_json_head(&j, call->line);
        cli_json_array(&j, "drives");
    } else {
        fprintf(f, "%-16s", "drive");
        for (int k = 0; k < VALUES - 1; k++)
            fprintf(f, " %-15s", heads[k]);
        fputs(" inertia\n", f);
    }
    for (int i = 0; i < n; i++) {
        const lw_load *l = &load[i];
        lw_load_figures g = lw_load_figures_of(l);
        const char *const *unit = l->slides ? sliding : turning;
        if (!call->common.json) {
            const double shown[] = { g.torque_peak, g.torque_rms, g.speed_peak, g.power_peak, fmax(0, -g.power_least), g.power_mean,
                                     g.energy_out, g.energy_back };
            fprintf(f, "%-16s", l->name);
            for (int k = 0; k < VALUES - 1; k++) {
                char text[48];
                snprintf(text, sizeof text, "%.6g %s", shown[k], unit[k]);
                fprintf(f, " %-15s", text);
            }
            if (isnan(l->inertia[0]))
                fputs(" not known\n", f);
            else if (l->inertia[1] - l->inertia[0] <= 1e-9*fabs(l->inertia[1]))
                fprintf(f, " %.6g %s\n", l->inertia[1], unit[VALUES - 1]);
            else
                fprintf(f, " %.6g to %.6g %s\n", l->inertia[0], l->inertia[1], unit[VALUES - 1]);
            continue;
        }
        const double values[] = { g.speed_peak, g.power_peak, g.power_least, g.power_mean, g.energy_out, g.energy_back };
        cli_json_object(&j, NULL);
        cli_json_text(&j, "joint", l->name);
        cli_json_real(&j, l->slides ? "force_peak" : "torque_peak", g.torque_peak);
        cli_json_real(&j, l->slides ? "force_rms" : "torque_rms", g.torque_rms);
        for (int k = 0; k < 6; k++)
            cli_json_real(&j, keys[k], values[k]);
        cli_json_reals(&j, "reflected_inertia", l->inertia, 2);
        cli_json_end(&j);
    }
    if (call->common.json) {
        cli_json_end(&j);
        cli_json_end(&j);
    }
}

static lw_status draw(int n, const lw_load *l, const char *path, lw_error *e)
{
    lw_plot plot[LW_PANEL_MAX] = { 0 };
    lw_series series[LW_PANEL_MAX];
    if (n > LW_PANEL_MAX)
        return lw_error_set(e, LW_E_ARG, "one plot shows at most %d drives, the model has %d", LW_PANEL_MAX, n);
    for (int i = 0; i < n; i++) {
        series[i] = (lw_series){ .name = l[i].name, .n = l[i].n, .x = l[i].speed, .y = l[i].torque };
        plot[i] = (lw_plot){ .x_label = l[i].slides ? "speed [m/s]" : "speed [rad/s]",
                             .y_label = l[i].slides ? "force [N]" : "torque [N m]", .n_series = 1, .series
                                 = &series[i] };
    }
    return lw_draw_plots(n, plot, path, e);
}

lw_status cli_drive_run(const cli_call *call, lw_loads *l, lw_error *e)
{
    const cli_drive_settings *s = call->settings;
    const char *file = call->parsed.word[1];
    const lw_load_options o = { .from = s->from, .to = s->to, .intervals = s->steps, .stop = cli_stop_flag() };
    lw_model *planar;
    lw_spatial *spatial;
    *l = (lw_loads){ 0 };
    lw_status st = cli_read_any_model(file, 0, &planar, &spatial, e);
    if (st == LW_OK)
        st = spatial ? cli_spatial_speed(spatial, s->speed, e) : cli_simulate_speed(planar, s->speed, file, e);
    if (st == LW_OK)
        st = spatial ? lw_loads_spatial(spatial, &o, l, e) : lw_loads_planar(planar, &o, l, e);
    if (st != LW_OK && !e->file[0])
        snprintf(e->file, sizeof e->file, "%s", file);
    cli_free_model(planar);
    cli_free_spatial(spatial);
    return st;
}

int cli_drive_load(const cli_call *call)
{
    const cli_drive_settings *s = call->settings;
    lw_loads l = { 0 };
    lw_error e = { 0 };
    lw_output o;
    if (!(s->from < s->to))
        return cli_usage(call, "--from must be less than --to");
    lw_status st = cli_drive_run(call, &l, &e);
    if (st == LW_OK)
        st = cli_open(call, &o, &e);
    int code = st == LW_OK ? CLI_DONE : cli_fail(call, &e);
    if (st == LW_OK) {
        print(call, o.f, l.n, l.load);
        code = cli_close(call, &o, code);
        if (code == CLI_DONE && s->plot && draw(l.n, l.load, s->plot, &e) != LW_OK)
            code = cli_fail(call, &e);
    }
    lw_loads_free(&l);
    return code;
}
