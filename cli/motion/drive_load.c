/* What a cycle of a model asks of its drives. */
#include "cli/motion/drive.h"

#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"

static void print(const cli_call *call, FILE *f, int n, const lw_load *l)
{
    if (!call->common.json)
        fprintf(f, "%-16s %-12s %-12s %-12s %-12s %-12s %-12s %-12s %s\n%-16s %-12s %-12s %-12s %-12s %-12s %-12s "
                   "%-12s %s\n",
                "drive", "peak", "rms", "speed", "peak power", "mean power", "energy out", "energy back", "inertia",
                "", "[N m] or [N]", "[N m] or [N]", "[rad/s, m/s]", "[W]", "[W]", "[J]", "[J]", "[kg m^2] or [kg]");
    cli_json j = cli_json_begin(f, 2);
    if (call->common.json) {
        cli_json_object(&j, NULL);
        cli_json_text(&j, "version", LW_VERSION);
        cli_json_text(&j, "command", call->line);
        cli_json_array(&j, "drives");
    }
    for (int i = 0; i < n; i++) {
        lw_load_figures g = lw_load_figures_of(&l[i]);
        if (!call->common.json) {
            fprintf(f, "%-16s %-12.6g %-12.6g %-12.6g %-12.6g %-12.6g %-12.6g %-12.6g ", l[i].name, g.torque_peak,
                    g.torque_rms, g.speed_peak, g.power_peak, g.power_mean, g.energy_out, g.energy_back);
            if (isnan(l[i].inertia[0]))
                fputs("not known\n", f);
            else if (l[i].inertia[1] - l[i].inertia[0] <= 1e-9*fabs(l[i].inertia[1]))
                fprintf(f, "%.6g\n", l[i].inertia[1]);
            else
                fprintf(f, "%.6g to %.6g\n", l[i].inertia[0], l[i].inertia[1]);
            continue;
        }
        const double values[] = { g.torque_peak, g.torque_rms, g.speed_peak, g.power_peak, g.power_least, g.power_mean,
                                  g.energy_out, g.energy_back };
        static const char *const turning[] = { "torque_peak", "torque_rms" }, *const sliding[] = { "force_peak",
             "force_rms" };
        static const char *const names[] = { "speed_peak", "power_peak", "power_least", "power_mean", "energy_out",
                                             "energy_back" };
        cli_json_object(&j, NULL);
        cli_json_text(&j, "joint", l[i].name);
        for (int k = 0; k < 8; k++)
            cli_json_real(&j, k < 2 ? (l[i].slides ? sliding : turning)[k] : names[k - 2], values[k]);
        cli_json_reals(&j, "reflected_inertia", l[i].inertia, 2);
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

/* The motion of an input with an acceleration of `extra` from time t on; extra 0: the motion itself. */
static lw_status disturb(lw_model *planar, lw_spatial *spatial, int i, const char *motion, double extra, double t,
                         lw_error *e)
{
    size_t size = strlen(motion) + 128;
    char *text = malloc(size);
    if (!text)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (extra != 0)
        snprintf(text, size, "%s + %.17g*max(t - %.17g, 0)^2", motion, extra/2, t);
    else
        snprintf(text, size, "%s", motion);
    lw_status s = planar ? lw_model_drive(planar, i, text, e) : lw_spatial_set_motion(spatial, i, text, e);
    free(text);
    return s;
}

/* Reflected inertia of each drive: what its torque rises by when only its acceleration rises.  An acceleration that
 * begins at a sample changes neither the posture nor the speeds there. */
static lw_status find_inertias(const cli_call *call, lw_model *planar, lw_spatial *spatial, const cli_table_options *o,
                               cli_table *t,
                               lw_error *e)
{
    enum { PLACES = 9 };
    const double extra = 1000;
    int n = planar ? lw_assembly_free_inputs(&planar->linkage) : spatial->n_drive ? 0 : spatial->n_input;
    lw_status s = LW_OK;
    for (int i = 0; i < t->n_drive; i++)
        t->drive[i].inertia[0] = t->drive[i].inertia[1] = NAN;
    for (int i = 0; s == LW_OK && i < n; i++) {
        const lw_expression *x = planar ? planar->motion[i] : spatial->input[i].motion;
        char *motion = x ? strdup(lw_expression_text(x)) : NULL;
        for (int k = 1; motion && s == LW_OK && k <= PLACES; k++) {
            size_t row = (t->n_row - 1)*(size_t)k/PLACES;
            cli_table at;
            cli_table_options part = *o;
            if (row == 0)
                continue;
            part.to = cli_table_at(t, row, 0);
            part.steps = (int)row;
            part.speed = NULL;
            s = disturb(planar, spatial, i, motion, extra, part.to, e);
            if (s != LW_OK)
                break;
            s = cli_table_run(call, planar, spatial, &part, &at, e);
            if (s == LW_OK) {
                double j = (cli_table_at(&at, row, at.drive[i].drive) - cli_table_at(t, row, t->drive[i].drive))/extra;
                t->drive[i].inertia[0] = fmin(t->drive[i].inertia[0], j);         /* of NaN and a number: the number */
                t->drive[i].inertia[1] = fmax(t->drive[i].inertia[1], j);
            }
            cli_table_free(&at);
        }
        if (motion && s == LW_OK)
            s = disturb(planar, spatial, i, motion, 0, 0, e);
        free(motion);
    }
    return s;
}

lw_status cli_drive_run(const cli_call *call, cli_table *t, lw_error *e)
{
    const cli_drive_settings *s = call->settings;
    const char *file = call->parsed.word[1];
    const cli_table_options o = { .from = s->from, .to = s->to, .steps = s->steps, .driven = true, .speed = s->speed };
    lw_model *planar;
    lw_spatial *spatial;
    *t = (cli_table){ 0 };
    lw_status st = cli_read_any_model(file, 0, &planar, &spatial, e);
    if (st == LW_OK)
        st = cli_table_run(call, planar, spatial, &o, t, e);
    if (st == LW_OK && t->n_drive == 0)
        st = lw_error_set(e, LW_E_ARG, "the model has no drive; name its \"input\"");
    if (st == LW_OK)
        st = find_inertias(call, planar, spatial, &o, t, e);
    if (st != LW_OK && !e->file[0])
        snprintf(e->file, sizeof e->file, "%s", file);
    cli_free_model(planar);
    cli_free_spatial(spatial);
    return st;
}

lw_status cli_drive_loads(const cli_table *t, double step, double **value, lw_load **load, lw_error *e)
{
    *value = malloc(2*(size_t)t->n_drive*t->n_row*sizeof **value);
    *load = calloc((size_t)t->n_drive, sizeof **load);
    if (!*value || !*load)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < t->n_drive; i++) {
        const cli_table_drive *d = &t->drive[i];
        double *speed = *value + (size_t)(2*i)*t->n_row, *torque = speed + t->n_row;
        for (size_t r = 0; r < t->n_row; r++) {
            speed[r] = cli_table_at(t, r, d->rate);
            torque[r] = cli_table_at(t, r, d->drive);
        }
        (*load)[i] = (lw_load){ d->name, d->slides, t->n_row, step, speed, torque, d->acceleration,
                                { d->inertia[0], d->inertia[1] } };
    }
    return LW_OK;
}

int cli_drive_load(const cli_call *call)
{
    const cli_drive_settings *s = call->settings;
    cli_table t = { 0 };
    lw_load *l = NULL;
    double *value = NULL;
    lw_error e = { 0 };
    lw_draw_kind kind;
    lw_output o;
    if (s->plot && lw_draw_kind_of(s->plot, &kind, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (!(s->from < s->to))
        return cli_usage(call, "--from must be less than --to");
    lw_status st = cli_drive_run(call, &t, &e);
    if (st == LW_OK)
        st = cli_drive_loads(&t, (s->to - s->from)/s->steps, &value, &l, &e);
    if (st == LW_OK)
        st = cli_open(call, &o, &e);
    int code = st == LW_OK ? CLI_DONE : cli_fail(call, &e);
    if (st == LW_OK) {
        print(call, o.f, t.n_drive, l);
        code = cli_close(call, &o, code);
        if (code == CLI_DONE && s->plot && draw(t.n_drive, l, s->plot, &e) != LW_OK)
            code = cli_fail(call, &e);
    }
    free(l);
    free(value);
    cli_table_free(&t);
    return code;
}
