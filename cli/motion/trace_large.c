#include "cli/motion/trace_large.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "cli/program/output.h"
#include "mbs/formulations/follow_model.h"

/* Rates have no bound at a limit of the input: rows end before it by this share of the range. */
static const double limit_inside = 1e-7;

/* The traced values at one moment. */
typedef struct tracing {
    cli_trace_large *t;
    lw_follow       *f;
    double          *shift, *lead, (*value)[CLI_ROW_MOST];
    bool             begun;
} tracing;

static double unit(const lw_assembly *a, int input) { return cli_input_slides(a, input) ? a->units.metre : a->units.radian; }

static void put_row(tracing *w)
{
    static const double factorial[] = { 1, 1, 2, 6 };
    cli_trace_large *t = w->t;
    const lw_assembly *a = &t->model->linkage;
    const lw_system *s = lw_follow_system(w->f);
    const double *series = lw_follow_series(w->f);
    double by = t->time_range ? 1 : t->timed ? t->speed : cli_input_slides(a, 0) ? a->units.metre : 1, now = lw_follow_time(w->f), length = now;
    cli_row row = { .arc = 1, .mode = ".", .n_lead = t->time_range ? 1 + a->n_input : 1, .lead = w->lead, .rates = true,
                    .value = w->value };
    for (int k = 0; k < a->n_tracer; k++) {
        lw_vec2 p[CLI_ROW_ORDER + 1];
        double turn[CLI_ROW_ORDER + 1], scale = 1;
        int body = s->tracer_body[k];
        if (!cli_rows_want(&t->rows, k))
            continue;
        lw_system_point_series(s, body, s->tracer_arm[k], CLI_ROW_ORDER, series, p);
        for (int order = 0; order <= CLI_ROW_ORDER; order++, scale *= by) {
            p[order] = lw_v2_scale(p[order], scale*factorial[order]);
            turn[order] = body < 0 ? 0 : series[order*s->n_q + 3*body + 2]*factorial[order]*scale;
        }
        double angle = a->tracer[k].angle + turn[0];
        if (!w->begun)
            w->shift[k] = angle - remainder(angle, 2*LW_PI);
        cli_row_values(&t->rows, p, turn, angle - w->shift[k], w->value[k]);
    }
    w->begun = true;
    if (t->time_range) {
        w->lead[0] = now;
        for (int i = 0; i < a->n_input; i++) {
            lw_system_measure_series(s, a->input[i].joint, 0, series, &length);
            w->lead[1 + i] = (length*lw_system_joint_unit(s, a->input[i].joint) + a->input[i].value)/unit(a, i);
        }
    } else
        w->lead[0] = now/unit(a, 0);
    cli_rows_put(&t->rows, &row);
}

/* How far the first input gets from the posture of the file towards `to`, and whether a limit ends it. */
static lw_status reach(const cli_trace_large *t, double to, double *end, bool *limit, lw_error *e)
{
    lw_follow *f;
    lw_error why = { 0 };
    double start = t->model->linkage.input[0].value;
    lw_status st = lw_follow_create(t->model, lw_prescribed_motion_first_alone, (void *)t->model, start, t->rows.stop, &f, e);
    if (st != LW_OK)
        return st;
    st = lw_follow_to(f, to, &why);
    *limit = st == LW_OPEN;
    *end = *limit ? lw_follow_time(f)*(1 - limit_inside) + start*limit_inside : to;
    lw_follow_free(f);
    if (st != LW_OK && st != LW_OPEN)
        *e = why;
    return st == LW_OPEN ? LW_OK : st;
}

/* Ends of the first input: of the range asked for, of the file's, or a whole turn, as far as it goes.  LW_NOTHING: it does not
 * reach the range. */
static lw_status find_ends(const cli_trace_large *t, double ends[2], bool limit[2], lw_error *e)
{
    const lw_assembly *a = &t->model->linkage;
    const lw_input *in = &a->input[0];
    double start = in->value;
    bool whole = !t->input_range && in->first == in->last;
    lw_status st = LW_OK;
    if (whole && cli_input_slides(a, 0))
        return lw_error_set(e, LW_E_ARG, "the range of the input is needed: give it \"first\" and \"last\" in the file, or --input-range");
    ends[0] = whole ? start : t->input_range ? t->input_range[0] : fmin(in->first, in->last);
    ends[1] = whole ? start + 2*LW_PI : t->input_range ? t->input_range[1] : fmax(in->first, in->last);
    if (ends[1] > start)
        st = reach(t, ends[1], &ends[1], &limit[1], e);
    if (whole && limit[1])
        ends[0] = start - 2*LW_PI;
    if (st == LW_OK && ends[0] < start)
        st = reach(t, ends[0], &ends[0], &limit[0], e);
    return st == LW_OK && !(ends[0] < ends[1]) ? LW_NOTHING : st;
}

static void begin(const cli_call *call, cli_trace_large *t, cli_json *json, const double ends[2], const bool limit[2], char *lead)
{
    const lw_assembly *a = &t->model->linkage;
    size_t size = 64 + 32*(size_t)a->n_input;
    const char *by = t->time_range || t->timed ? "s" : cli_input_slides(a, 0) ? cli_input_unit(a, 0) : "rad";
    if (t->time_range)
        cli_time_columns(a, true, lead, size);
    else
        snprintf(lead, size, "input %s", cli_input_unit(a, 0));
    if (t->rows.json) {
        cli_json_head(json, call->line);
        cli_json_text(json, "name", a->name);
        cli_json_text(json, "way", t->time_range ? "time" : "large");
        cli_json_object(json, "units");
        cli_json_text(json, "length", a->units.length);
        cli_json_text(json, "angle", a->units.angle);
        cli_json_text(json, "rates_by", t->time_range || t->timed ? "s" : cli_input_slides(a, 0) ? "length" : "rad");
        cli_json_end(json);
    } else {
        fprintf(t->rows.f, "# %s\n", call->line);
        cli_rows_units(&t->rows, lead, by);
    }
    for (int end = 0; !t->rows.json && !t->time_range && end < 2; end++) {
        fputs(end ? " to " : "# arc 1: input ", t->rows.f);
        cli_row_number(t->rows.f, ends[end]/unit(a, 0));
        fputs(limit[end] ? " (limit)" : "", t->rows.f);
        fputs(end ? "\n" : "", t->rows.f);
    }
    if (t->time_range)
        cli_time_columns(a, false, lead, size);
    cli_rows_head(&t->rows, t->time_range ? lead : "input");
    if (!t->rows.json)
        return;
    cli_json_array(json, "arcs");
    cli_json_object(json, NULL);
    cli_json_int(json, "arc", 1);
    if (!t->time_range) {
        cli_json_reals(json, "range", (double[]){ ends[0]/unit(a, 0), ends[1]/unit(a, 0) }, 2);
        cli_json_bool(json, "first_is_limit", limit[0]);
        cli_json_bool(json, "last_is_limit", limit[1]);
    }
    cli_json_array(json, "rows");
}

static lw_status print_rows(tracing *w, double from, double to, double n, lw_error *e)
{
    lw_status st = LW_OK;
    for (double i = 0; i <= n && st == LW_OK && !cli_rows_stopped(&w->t->rows); i++) {
        st = lw_follow_to(w->f, i == n ? to : from + (to - from)*(i/n), e);
        if (st == LW_OPEN)
            lw_error_set(e, st, "the motions lead beyond a limit of the linkage (a dead point of its inputs) at %s %.12g; the "
                         "rows end before it", w->t->time_range ? "t [s] =" : "the input [rad or m]", lw_follow_time(w->f));
        if (st == LW_OK)
            put_row(w);
    }
    return st;
}

int cli_trace_large_run(const cli_call *call, cli_trace_large *t)
{
    const lw_assembly *a = &t->model->linkage;
    double ends[2] = { 0, 0 }, n = t->steps;
    bool limit[2] = { false, false };
    tracing w = { .t = t };
    lw_error e = { 0 };
    lw_output o;
    lw_status st = a->n_input > 0 ? LW_OK : lw_error_set(&e, LW_E_ARG, "the model has no input, so there is nothing to move");
    if (st == LW_OK && t->time_range) {
        n = floor((t->time_range[1] - t->time_range[0])/t->time_range[2]*(1 + 1e-12));
        ends[0] = t->time_range[0], ends[1] = t->time_range[0] + n*t->time_range[2];
    } else if (st == LW_OK)
        st = find_ends(t, ends, limit, &e);
    if (st == LW_NOTHING) {
        cli_note(call, "the linkage does not reach that range of the input from the posture of the file");
        return CLI_NOTHING;
    }
    size_t inputs = (size_t)a->n_input + 1, tracers = (size_t)a->n_tracer + 1;
    w.shift = calloc(tracers + inputs, sizeof *w.shift);
    w.value = calloc(tracers, sizeof *w.value);
    char *lead = malloc(64 + 32*inputs);
    if (st == LW_OK && (!w.shift || !w.value || !lead))
        st = lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        st = lw_follow_create(t->model, t->time_range ? lw_prescribed_motion_of_model : lw_prescribed_motion_first_alone, (void *)t->model, ends[0],
                              t->rows.stop, &w.f, &e);
    bool open = st == LW_OK && (st = cli_open(call, &o, &e)) == LW_OK;
    int code = CLI_DONE;
    if (open) {
        cli_progress progress = cli_progress_begin(call, "trace", "rows");
        cli_json json = cli_json_begin(o.f, 1);
        w.lead = w.shift + tracers;
        t->rows.f = o.f;
        t->rows.json = call->common.json ? &json : NULL;
        t->rows.progress = &progress;
        t->rows.total = n + 1;
        begin(call, t, &json, ends, limit, lead);
        st = print_rows(&w, ends[0], ends[1], n, &e);
        if (t->rows.json)
            cli_json_end(&json);
        cli_rows_arc_end(&t->rows, 1);
        for (int i = 0; t->rows.json && i < 3; i++)
            cli_json_end(&json);
        cli_progress_end(&progress);
    }
    if (st != LW_OK) {
        if (!e.file[0] && st != LW_E_MEMORY)
            snprintf(e.file, sizeof e.file, "%s", call->parsed.word[0]);
        code = cli_fail(call, &e);
    } else if (t->rows.cut_short)
        code = CLI_LIMIT;
    if (open && t->rows.done == 0 && st != LW_OK)
        lw_output_abandon(&o);
    else if (open)
        code = cli_close(call, &o, st == LW_OPEN ? CLI_LIMIT : code);
    lw_follow_free(w.f);
    free(w.shift), free(w.value), free(lead);
    return code;
}
