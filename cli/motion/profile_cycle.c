#include "cli/motion/profile_cycle.h"

#include <stdlib.h>

#include "base/number.h"
#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "grammar/model/work_cycle.h"

/* Greatest speed and acceleration of an axis in a move. */
static void peaks(const lw_cycle_move *m, int axis, double *v, double *a)
{
    lw_axis_limits k = lw_profile_extremes(&m->profile[axis]);
    *v = fmax(k.v[1], -k.v[0]);
    *a = fmax(k.a[1], -k.a[0]);
}

static void write_text(const lw_work_cycle *c, FILE *f)
{
    fprintf(f, "%s%s%-20s %12s %12s %12s %10s  %s\n", c->name, *c->name ? "\n" : "", "move", "start [s]",
            "duration [s]", "rest [s]",
            "load [kg]", "axis: goal, greatest speed, greatest acceleration");
    for (int i = 0; i < c->n_move; i++) {
        const lw_cycle_move *m = &c->move[i];
        fprintf(f, "%-20s %12.9g %12.9g %12.9g %10.6g ", m->name, m->start, m->duration, m->dwell, m->payload);
        for (int k = 0; k < c->n_axis; k++)
            if (m->moves[k]) {
                double v, a;
                peaks(m, k, &v, &a);
                fprintf(f, " %s: %.6g, %.6g, %.6g;", c->axis[k].name, m->to[k], v, a);
            }
        fputc('\n', f);
    }
    fprintf(f, "%-20s %12s %12.10g\n", "whole cycle", "", c->end);
    if (c->wanted > 0)
        fprintf(f, "%-20s %12s %12.10g   %s\n", "wanted", "", c->wanted, c->end <= c->wanted ? "kept" : "NOT kept");
}

static void write_rows(const lw_work_cycle *c, FILE *f, int n)
{
    char text[LW_NUMBER_SIZE], name[sizeof c->axis[0].name + 2];
    fputs("t", f);
    for (int k = 0; k < c->n_axis; k++)
        for (int d = 0; d < 4; d++) {
            snprintf(name, sizeof name, "%s%s", c->axis[k].name, (const char *const[]){ "", ".v", ".a", ".j" }[d]);
            fputc(',', f), cli_csv_text(f, name);
        }
    fputs(",payload\n", f);
    for (int r = 0; r <= n && !cli_interrupted(); r++) {
        double t = c->end*r/n;
        lw_number_print(t, text);
        fputs(text, f);
        for (int k = 0; k < c->n_axis; k++) {
            double j;
            lw_axis_state s = lw_work_cycle_at(c, k, t, &j);
            const double value[4] = { s.x, s.v, s.a, j };
            for (int d = 0; d < 4; d++) {
                lw_number_print(value[d] + 0.0, text);
                fprintf(f, ",%s", text);
            }
        }
        lw_number_print(lw_work_cycle_payload(c, t), text);
        fprintf(f, ",%s\n", text);
    }
}

static void write_json(const cli_call *call, const lw_work_cycle *c, FILE *f)
{
    cli_json j = cli_json_begin(f, 2);
    cli_json_head(&j, call->line);
    cli_json_text(&j, "name", c->name);
    cli_json_real(&j, "cycle_time", c->end);
    if (c->wanted > 0) {
        cli_json_real(&j, "wanted", c->wanted);
        cli_json_bool(&j, "kept", c->end <= c->wanted);
    }
    cli_json_array(&j, "moves");
    for (int i = 0; i < c->n_move; i++) {
        const lw_cycle_move *m = &c->move[i];
        cli_json_object(&j, NULL);
        cli_json_text(&j, "name", m->name);
        cli_json_real(&j, "start", m->start);
        cli_json_real(&j, "duration", m->duration);
        cli_json_real(&j, "dwell", m->dwell);
        cli_json_real(&j, "payload", m->payload);
        cli_json_array(&j, "axes");
        for (int k = 0; k < c->n_axis; k++)
            if (m->moves[k]) {
                double v, a;
                peaks(m, k, &v, &a);
                cli_json_object(&j, NULL);
                cli_json_text(&j, "axis", c->axis[k].name);
                cli_json_real(&j, "to", m->to[k]);
                cli_json_real(&j, "speed_peak", v);
                cli_json_real(&j, "acceleration_peak", a);
                cli_json_reals(&j, "phases", m->profile[k].t, (size_t)m->profile[k].n + 1);
                cli_json_end(&j);
            }
        cli_json_end(&j);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_end(&j);
}

static lw_status draw(const lw_work_cycle *c, const char *path, lw_error *e)
{
    enum { N = 4000, AXES = 8 };
    static const char *const labels[4] = { "position", "speed [1/s]", "acceleration [1/s^2]", "jerk [1/s^3]" };
    lw_series series[4][AXES];
    lw_plot plot[4];
    if (c->n_axis > AXES)
        return lw_error_set(e, LW_E_ARG, "a plot shows at most %d axes, this cycle has %d", AXES, c->n_axis);
    double *v = malloc((1 + 4*(size_t)c->n_axis)*(N + 1)*sizeof *v);
    if (!v)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i <= N; i++) {
        v[i] = c->end*i/N;
        for (int k = 0; k < c->n_axis; k++) {
            double j;
            lw_axis_state s = lw_work_cycle_at(c, k, v[i], &j);
            const double value[4] = { s.x, s.v, s.a, j };
            for (int d = 0; d < 4; d++)
                v[(1 + 4*k + d)*(N + 1) + i] = value[d];
        }
    }
    for (int d = 0; d < 4; d++) {
        for (int k = 0; k < c->n_axis; k++)
            series[d][k] = (lw_series){ .name = c->axis[k].name, .n = N + 1, .x = v, .y = v + (1 + 4*k + d)*(N + 1) };
        plot[d] = (lw_plot){ .y_label = labels[d], .x_label = d == 3 ? "time [s]" : NULL, .n_series = c->n_axis,
                             .series = series[d] };
    }
    plot[0].title = c->name;
    lw_status s = lw_draw_plots(4, plot, path, e);
    free(v);
    return s;
}

int cli_profile_cycle(const cli_call *call, const char *given, size_t given_size, int rows, const char *plot)
{
    const char *file = call->parsed.word[0];
    lw_work_cycle c = { 0 };
    lw_error e = { 0 };
    lw_output out;
    char *text = NULL;
    size_t size = 0;
    lw_status s = given ? LW_OK : cli_read_file(file, "a work cycle (JSON)", &text, &size, &e);
    if (s == LW_OK)
        s = lw_work_cycle_read(given ? given : text, given ? given_size : size, given ? "" : file, &c, &e);
    if (given)
        e.line = e.column = 0;                             /* of a text that nobody sees */
    free(text);
    if (s == LW_OK)
        s = cli_open(call, &out, &e);
    int code = s == LW_OK ? CLI_DONE : cli_fail(call, &e);
    if (s == LW_OK) {
        bool late = c.wanted > 0 && c.end > c.wanted;
        if (call->common.json)
            write_json(call, &c, out.f);
        else if (rows > 0)
            write_rows(&c, out.f, rows);
        else
            write_text(&c, out.f);
        if (late)
            cli_note(call, "the cycle takes %.10g s, %.4g s more than wanted", c.end, c.end - c.wanted);
        code = cli_close(call, &out, late ? CLI_NOTHING : CLI_DONE);
        if ((code == CLI_DONE || code == CLI_NOTHING) && plot && draw(&c, plot, &e) != LW_OK)
            code = cli_fail(call, &e);
    }
    lw_work_cycle_free(&c);
    return code;
}
