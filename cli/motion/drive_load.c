/* What a cycle of a model asks of its drives. */
#include "cli/motion/drive.h"

#include <stdlib.h>

#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/simulate.h"
#include "cli/program/model.h"
#include "cli/program/output.h"

/* Values at evenly spaced times of one drive: the torque drives in the direction of the speed. */
typedef struct load { const char *joint; bool slides; size_t n; double step; const double *speed, *torque; } load;

typedef struct load_figures {
    double torque_peak, torque_rms, speed_peak, power_peak, power_mean, power_least;
    double energy_out, energy_back;          /* of the drive into the load; from the load into the drive [J] */
} load_figures;

/* Integrals by the trapezoidal rule; the power is taken as straight between two samples. */
static load_figures figures_of(const load *l)
{
    load_figures f = { .power_least = INFINITY, .power_peak = -INFINITY };
    double square = 0;
    for (size_t i = 0; i < l->n; i++) {
        double power = l->speed[i]*l->torque[i];
        f.torque_peak = fmax(f.torque_peak, fabs(l->torque[i]));
        f.speed_peak = fmax(f.speed_peak, fabs(l->speed[i]));
        f.power_peak = fmax(f.power_peak, power);
        f.power_least = fmin(f.power_least, power);
        if (i == 0)
            continue;
        double before = l->speed[i - 1]*l->torque[i - 1], a = l->torque[i - 1], b = l->torque[i];
        double cross = power != before ? before/(before - power) : 0;      /* where the power changes its sign */
        square += (a*a + a*b + b*b)/3;
        if (before*power < 0) {
            *(before > 0 ? &f.energy_out : &f.energy_back) += fabs(before)*cross/2*l->step;
            *(power > 0 ? &f.energy_out : &f.energy_back) += fabs(power)*(1 - cross)/2*l->step;
        } else
            *(before + power > 0 ? &f.energy_out : &f.energy_back) += fabs(before + power)/2*l->step;
    }
    double time = (double)(l->n - 1)*l->step;
    f.torque_rms = sqrt(square*l->step/time);
    double energy = f.energy_out - f.energy_back;
    f.power_mean = fabs(energy) > 1e-12*f.energy_out ? energy/time : 0;
    return f;
}

static void print(const cli_call *call, FILE *f, int n, const load *l)
{
    if (!call->common.json)
        fprintf(f, "%-16s %-12s %-12s %-12s %-12s %-12s %-12s %-12s\n%-16s %-12s %-12s %-12s %-12s %-12s %-12s %-12s\n",
                "drive", "peak", "rms", "speed", "peak power", "mean power", "energy out", "energy back",
                "", "[N m] or [N]", "[N m] or [N]", "[rad/s, m/s]", "[W]", "[W]", "[J]", "[J]");
    cli_json j = cli_json_begin(f, 2);
    if (call->common.json) {
        cli_json_object(&j, NULL);
        cli_json_text(&j, "version", LW_VERSION);
        cli_json_text(&j, "command", call->line);
        cli_json_array(&j, "drives");
    }
    for (int i = 0; i < n; i++) {
        load_figures g = figures_of(&l[i]);
        if (!call->common.json) {
            fprintf(f, "%-16s %-12.6g %-12.6g %-12.6g %-12.6g %-12.6g %-12.6g %.6g\n", l[i].joint, g.torque_peak,
                    g.torque_rms, g.speed_peak, g.power_peak, g.power_mean, g.energy_out, g.energy_back);
            continue;
        }
        const double values[] = { g.torque_peak, g.torque_rms, g.speed_peak, g.power_peak, g.power_least, g.power_mean,
                                  g.energy_out, g.energy_back };
        static const char *const turning[] = { "torque_peak", "torque_rms" }, *const sliding[] = { "force_peak", "force_rms" };
        static const char *const names[] = { "speed_peak", "power_peak", "power_least", "power_mean", "energy_out",
                                             "energy_back" };
        cli_json_object(&j, NULL);
        cli_json_text(&j, "joint", l[i].joint);
        for (int k = 0; k < 8; k++)
            cli_json_real(&j, k < 2 ? (l[i].slides ? sliding : turning)[k] : names[k - 2], values[k]);
        cli_json_end(&j);
    }
    if (call->common.json) {
        cli_json_end(&j);
        cli_json_end(&j);
    }
}

static lw_status draw(int n, const load *l, const char *path, lw_error *e)
{
    lw_plot plot[LW_PANEL_MAX] = { 0 };
    lw_series series[LW_PANEL_MAX];
    if (n > LW_PANEL_MAX)
        return lw_error_set(e, LW_E_ARG, "one plot shows at most %d drives, the model has %d", LW_PANEL_MAX, n);
    for (int i = 0; i < n; i++) {
        series[i] = (lw_series){ .name = l[i].joint, .n = l[i].n, .x = l[i].speed, .y = l[i].torque };
        plot[i] = (lw_plot){ .x_label = l[i].slides ? "speed [m/s]" : "speed [rad/s]",
                             .y_label = l[i].slides ? "force [N]" : "torque [N m]", .n_series = 1, .series = &series[i] };
    }
    return lw_draw_plots(n, plot, path, e);
}

static lw_status run_model(const cli_call *call, cli_simulate *c, lw_error *e)
{
    const cli_drive_settings *s = call->settings;
    const char *file = call->parsed.word[1];
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_KINEMATIC;
    o.from = s->from;
    o.to = s->to;
    o.intervals = s->steps;
    o.stop = cli_stop_flag();
    c->call = call;
    c->keep = true;
    c->model = cli_read_model(file, 0, e);
    lw_status st = c->model ? cli_simulate_speed(c->model, s->speed, file, e) : e->status;
    if (st == LW_OK && c->model->linkage.n_input == 0)
        st = lw_error_at(e, LW_E_ARG, file, 0, 0, "the model has no drive; name its \"input\"");
    if (st == LW_OK)
        st = cli_simulate_make(c, &o, file, e);
    return st == LW_OK ? lw_dynamics_run(c->d, cli_simulate_row, c, &c->report, e) : st;
}

/* Copy the speed and the torque of each drive into `value`, series after series. */
static void take_loads(const cli_simulate *c, double step, double *value, load *l)
{
    const lw_assembly *k = &c->model->linkage;
    for (int i = 0; i < k->n_input; i++) {
        const lw_joint *j = &k->joint[k->input[i].joint];
        double *speed = value + (size_t)(2*i)*c->n_row, *torque = speed + c->n_row;
        for (size_t r = 0; r < c->n_row; r++) {
            speed[r] = c->row[r*(size_t)c->n_column + (size_t)(2 + 3*i)];
            torque[r] = c->row[r*(size_t)c->n_column + (size_t)(3 + 3*i)];
        }
        l[i] = (load){ j->name, lw_joint_slides(j->kind), c->n_row, step, speed, torque };
    }
}

int cli_drive_load(const cli_call *call)
{
    const cli_drive_settings *s = call->settings;
    cli_simulate *c = calloc(1, sizeof *c);
    lw_error e = { 0 };
    lw_draw_kind kind;
    lw_output o;
    if (s->plot && lw_draw_kind_of(s->plot, &kind, &e) != LW_OK)
        return free(c), cli_usage(call, "%s", e.text);
    if (!(s->from < s->to))
        return free(c), cli_usage(call, "--from must be less than --to");
    lw_status st = c ? run_model(call, c, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    int n = st == LW_OK ? c->model->linkage.n_input : 0;
    double *value = st == LW_OK ? malloc(2*(size_t)n*c->n_row*sizeof *value) : NULL;
    load *l = calloc((size_t)n + 1, sizeof *l);
    if (st == LW_OK && (!value || !l))
        st = lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        take_loads(c, (s->to - s->from)/s->steps, value, l);
        st = cli_open(call, &o, &e);
    }
    int code = st == LW_OK ? CLI_DONE : cli_fail(call, &e);
    if (st == LW_OK) {
        print(call, o.f, n, l);
        code = cli_close(call, &o, code);
        if (code == CLI_DONE && s->plot && draw(n, l, s->plot, &e) != LW_OK)
            code = cli_fail(call, &e);
    }
    free(l);
    free(value);
    if (c)
        cli_simulate_free(c);
    free(c);
    return code;
}
