/* Rows of a trace along motion curves. */
#include "cli/motion/trace_curve.h"

#include <stdlib.h>
#include <string.h>
#include "base/growable_array.h"
#include "base/number.h"
#include "base/real.h"
#include "cli/program/output.h"
#include "mbs/analysis/notes.h"

/* ---- shared ------------------------------------------------------------------------------------ */

double cli_curve_unit(const cli_curve_trace *t, int input)
{
    return cli_input_slides(&t->k, input) ? t->k.units.metre : t->k.units.radian;
}

/* Compute the values of all tracers from a series of a posture (4 x n_q) into row. */
static void tracer_values(cli_curve_trace *t, const double *series, bool first, cli_row *row)
{
    static const double factorial[] = { 1, 1, 2, 6 };
    for (int k = 0; k < t->k.n_tracer; k++) {
        int body = t->s.tracer_body[k];
        lw_vec2 p[CLI_ROW_ORDER + 1];
        double a[CLI_ROW_ORDER + 1];
        lw_system_point_series(&t->s, body, t->s.tracer_arm[k], CLI_ROW_ORDER, series, p);
        for (int order = 0; order <= CLI_ROW_ORDER; order++) {
            p[order] = lw_v2_scale(p[order], factorial[order]);
            a[order] = body < 0 ? 0 : series[order*t->s.n_q + 3*body + 2]*factorial[order];
        }
        double angle = t->k.tracer[k].angle + a[0];
        if (first)
            t->shift[k] = angle - remainder(angle, 2*LW_PI);
        cli_row_values(&t->rows, p, a, angle - t->shift[k], row->value[k]);
    }
}

lw_status cli_curve_room(cli_curve_trace *t, lw_error *e)
{
    size_t n = (size_t)t->s.n_q, tracers = (size_t)t->k.n_tracer, leads = 2 + (size_t)t->k.n_input;
    t->series = calloc((CLI_ROW_ORDER + 2)*n + leads + tracers*(1 + CLI_ROW_MOST), sizeof *t->series);
    if (!t->series)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    t->q = t->series + (CLI_ROW_ORDER + 1)*n;
    t->lead = t->q + n;
    t->shift = t->lead + leads;
    t->value = (double (*)[CLI_ROW_MOST])(t->shift + tracers);
    return LW_OK;
}

/* ---- stretches --------------------------------------------------------------------------------- */

static double input_at(const cli_curve_trace *t, lw_motion_curve *motion, double station)
{
    lw_motion_curve_posture(motion, station, t->q, NULL);
    return lw_motion_curve_input(motion, t->q);
}

static void add_stretch(cli_curve_trace *t, cli_stretch s)
{
    bool enough = !t->whole && t->n_stretch >= CLI_STRETCH_MAX;      /* a wide range repeats them at every turn */
    cli_stretch *grown = enough ? NULL : lw_array_grow(t->stretch, t->n_stretch, &t->room, sizeof *grown);
    t->dropped = t->dropped || enough;
    t->no_memory = t->no_memory || (!enough && !grown);
    if (!grown)
        return;
    t->stretch = grown;
    t->stretch[t->n_stretch++] = s;
}

/* Add the parts of a stretch in the requested range of the input, shifted by whole turns. */
static void cut_stretch(cli_curve_trace *t, cli_stretch s)
{
    double low = fmin(s.first, s.last), high = fmax(s.first, s.last), turn = cli_input_slides(&t->k, 0) ? 0 : 2*LW_PI;
    if (!t->whole && s.input_per_round != 0) {
        s.first = t->from;
        s.last = t->to;
    }
    if (t->whole || s.input_per_round != 0) {
        add_stretch(t, s);
        return;
    }
    double n0 = turn > 0 ? ceil((t->from - high)/turn) : 0, n1 = turn > 0 ? floor((t->to - low)/turn) : 0;
    for (double n = n0; n <= n1 && !t->dropped; n++) {
        cli_stretch c = s;
        double lo = fmax(low + n*turn, t->from), hi = fmin(high + n*turn, t->to);
        if (!(lo <= hi))
            continue;
        bool rises = s.last >= s.first;
        c.first = rises ? lo : hi;
        c.last = rises ? hi : lo;
        for (int end = 0; end < 2; end++)
            c.limit[end] = s.limit[end] && (end ? c.last : c.first) == (end ? s.last : s.first) + n*turn;
        for (int p = 0; p < c.n_part; p++)
            c.part[p].more += n*turn;
        add_stretch(t, c);
    }
}

static void stretch_from_to(cli_curve_trace *t, int curve, double from, double to, bool limit0, bool limit1)
{
    lw_motion_curve *motion = t->curves.curve[curve];
    double end = lw_motion_curve_segments(motion);
    cli_stretch s = { .curve = curve, .limit = { limit0, limit1 }, .n_part = 1 };
    s.part[0].from = from;
    s.part[0].to = fmin(to, end);
    s.first = input_at(t, motion, from);
    if (to > end) {                                       /* past the end of a closed curve */
        s.n_part = 2;
        s.part[1].to = to - end;
        s.part[1].more = input_at(t, motion, end) - input_at(t, motion, 0);
        s.last = input_at(t, motion, to - end) + s.part[1].more;
    } else
        s.last = input_at(t, motion, to);
    s.turns = lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED && !limit0 && !limit1;
    s.zero = s.first;
    s.input_per_round = s.turns && lw_motion_curve_turns(motion, -1) != 0 ? s.last - s.first : 0;
    cut_stretch(t, s);
}

/* Divide a curve at its limits. On a closed curve, the part before the first limit continues the part after the last.
 */
static void cut_curve(cli_curve_trace *t, int curve)
{
    lw_motion_curve *motion = t->curves.curve[curve];
    double first = -1, last = -1, end = lw_motion_curve_segments(motion);
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    bool closed = lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED;
    if (lw_motion_curve_rests(motion))
        return;
    for (int i = 0; i < n; i++) {
        if (e[i].kind != LW_EVENT_LIMIT)
            continue;
        if (last >= 0)
            stretch_from_to(t, curve, last, e[i].station, true, true);
        else if (!closed)
            stretch_from_to(t, curve, 0, e[i].station, false, true);
        last = e[i].station;
        first = first < 0 ? last : first;
    }
    if (last < 0)
        stretch_from_to(t, curve, 0, end, false, false);
    else
        stretch_from_to(t, curve, last, closed ? first + end : end, true, closed);
}

lw_status cli_curve_stretches(cli_curve_trace *t, lw_error *e)
{
    t->n_stretch = 0;
    t->dropped = false;
    for (int i = 0; i < t->curves.n; i++)
        cut_curve(t, i);
    return t->no_memory ? lw_error_set(e, LW_E_MEMORY, "out of memory") : LW_OK;
}

/* ---- rows -------------------------------------------------------------------------------------- */

/* How many rounds of a closed curve are complete where the input of a stretch is u. */
static double rounds_at(const cli_curve_trace *t, lw_motion_curve *motion, const cli_stretch *s, double u)
{
    if (s->input_per_round != 0)
        return floor((u - s->zero)/s->input_per_round);
    return s->n_part > 1 && (u - input_at(t, motion, s->part[0].to) - s->part[0].more)*(s->last - s->first) > 0;
}

/* Station of the curve where the input is u; the stretch must contain u. */
static double station_at(lw_motion_curve *motion, const cli_stretch *s, double u, double rounds)
{
    int part = s->input_per_round == 0 && rounds > 0;
    return lw_motion_curve_find(motion, s->part[part].from, s->part[part].to, u - s->part[part].more - rounds*s->input_per_round);
}

/* Add the turns of the links: every round of a closed curve adds as many turns as the first. */
static void count_turns(const cli_curve_trace *t, const lw_motion_curve *motion, double rounds, double *q)
{
    for (int body = 0; body < t->s.n_body; body++)
        q[3*body + 2] += 2*LW_PI*rounds*lw_motion_curve_turns(motion, t->s.link[body]);
}

/* Unit of what derivatives are taken by: the free input's own unit, or time. */
static double rate_unit(const cli_curve_trace *t)
{
    return t->timed ? t->speed : cli_input_slides(&t->k, 0) ? t->k.units.metre : 1;
}

/* Compute the posture at a station and its derivatives. False: there are no derivatives. */
static bool fill_series(cli_curve_trace *t, lw_motion_curve *motion, double station, double *series)
{
    double rates[CLI_ROW_ORDER + 1] = { 0, rate_unit(t) };
    bool good = lw_motion_curve_motion(motion, station, CLI_ROW_ORDER, rates, series);
    if (!good)
        memset(series + t->s.n_q, 0, (size_t)(CLI_ROW_ORDER*t->s.n_q)*sizeof *series);
    return good;
}

/* Compute row `i` of a stretch, at input u, from the curve. */
static void curve_row(cli_curve_trace *t, const cli_stretch *s, int i, double u, cli_row *row)
{
    lw_motion_curve *motion = t->curves.curve[s->curve];
    double *series = t->series;
    bool limit = (i == 0 && s->limit[0]) || (i == t->steps && s->limit[1]);
    double rounds = rounds_at(t, motion, s, u);
    row->rates = fill_series(t, motion, station_at(motion, s, u, rounds), series) && !limit;
    count_turns(t, motion, rounds, series);
    tracer_values(t, series, i == 0, row);
    if (t->groups && (i == 0 || i == t->steps) && (s->limit[0] || s->limit[1]))
        t->groups->seeded = false;                            /* both sides of a limit have nearly the same input */
    else if (t->groups)
        cli_groups_seed(t->groups, &t->s, series, u, &t->rows, row);
}

/* After a branch point a group may be in another assembly mode than its seed before that point. */
static bool crosses(const lw_motion_curve *motion)
{
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    for (int i = 0; i < n; i++)
        if (e[i].kind == LW_EVENT_CROSSING)
            return true;
    return false;
}

static void stretch_rows(cli_curve_trace *t, int index)
{
    const cli_stretch *s = &t->stretch[index];
    lw_motion_curve *motion = t->curves.curve[s->curve];
    double middle = 0.5*(s->first + s->last);
    int side = lw_motion_curve_side(motion, station_at(motion, s, middle, rounds_at(t, motion, s, middle)));
    bool groups = t->groups && !crosses(motion);
    for (int i = 0; i <= t->steps && !cli_rows_stopped(&t->rows); i++) {
        bool between = groups && i % CLI_GROUP_ROWS != 0 && i < t->steps;
        double u = i == t->steps ? s->last : s->first + (s->last - s->first)*i/t->steps;
        cli_row row = { .arc = index + 1, .mode = side > 0 ? "+" : side < 0 ? "-" : "0", .n_lead = 1, .lead = t->lead, .value = t->value };
        row.lead[0] = u/cli_curve_unit(t, 0);
        if (!between || !cli_groups_row(t->groups, u, rate_unit(t), &t->rows, &row))
            curve_row(t, s, i, u, &row);
        cli_rows_put(&t->rows, &row);
    }
}

static void cycle_rows(cli_curve_trace *t, int curve)
{
    lw_motion_curve *motion = t->curves.curve[curve];
    double *series = t->series, length = lw_motion_curve_length(motion);
    for (int i = 0; i <= t->steps && !cli_rows_stopped(&t->rows); i++) {
        cli_row row = { .arc = curve + 1, .n_lead = 2, .lead = t->lead, .value = t->value };
        double arc = length*i/t->steps;
        double station = i == t->steps ? lw_motion_curve_segments(motion) : lw_motion_curve_station(motion, arc);
        int side = lw_motion_curve_side(motion, station);
        row.mode = side > 0 ? "+" : side < 0 ? "-" : "0";
        row.rates = fill_series(t, motion, station, series);
        row.lead[0] = arc;
        row.lead[1] = lw_motion_curve_input(motion, series)/cli_curve_unit(t, 0);
        tracer_values(t, series, i == 0, &row);
        cli_rows_put(&t->rows, &row);
    }
}

/* ---- description of a curve -------------------------------------------------------------------- */

static const char *end_text(const cli_curve_trace *t, const lw_motion_curve *motion, char text[128])
{
    int turns = lw_motion_curve_turns(motion, -1);
    switch (lw_motion_curve_ended(motion)) {
    case LW_MOTION_CURVE_CLOSED:
        if (turns != 0)
            snprintf(text, 128, "closes after %d turn%s of the input", abs(turns), lw_plural(abs(turns)));
        else if (lw_motion_curve_rests(motion))
            snprintf(text, 128, "closes, the input stands still");
        else
            snprintf(text, 128, "closes, the input swings%s", cli_input_slides(&t->k, 0) ? " to and fro" : "");
        return text;
    case LW_MOTION_CURVE_FAR:
        return "leaves for beyond 30 sizes of the linkage, where it is cut";
    case LW_MOTION_CURVE_LOST:
        return "ends at a singular posture that could not be passed";
    case LW_MOTION_CURVE_STOPPED:
        break;
    }
    return "is not at its end after the steps that are allowed";
}

/* The circuit that crosses `curve` at an event; -1: no circuit that was found crosses there. */
static int crossing_circuit(const cli_curve_trace *t, int curve, const lw_motion_curve_event *e)
{
    if (e->kind != LW_EVENT_CROSSING)
        return -1;
    lw_motion_curve_posture(t->curves.curve[curve], e->station, t->q, NULL);
    for (int i = 0; i < t->curves.n; i++)
        if (i != curve && lw_motion_curve_holds(t->curves.curve[i], t->q))
            return i;
    return -1;
}

static void event_text(const cli_curve_trace *t, int curve, const lw_motion_curve_event *e, char text[128])
{
    const char *slides = e->joint >= 0 && lw_joint_slides(t->k.joint[e->joint].kind) ? "slider" : "pin";
    int other = crossing_circuit(t, curve, e);
    if (other >= 0)
        snprintf(text, 128, "branch point, passed straight on; circuit %d crosses", other + 1);
    else if (e->kind == LW_EVENT_CROSSING)
        snprintf(text, 128, "branch point, passed straight on");
    else
        snprintf(text, 128, "%s: %s %s turns back", e->kind == LW_EVENT_LIMIT ? "limit of the input" : "dead point",
                 slides, t->k.joint[e->joint].name);
}

static void csv_curve(cli_curve_trace *t, int curve)
{
    const lw_motion_curve *motion = t->curves.curve[curve];
    char text[128];
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    fprintf(t->rows.f, "# circuit %d: %s; arc length %.6g, residual %.2g\n", curve + 1, end_text(t, motion, text),
            lw_motion_curve_length(motion), lw_motion_curve_worst(motion)/t->k.units.metre);
    for (int i = 0; i < n; i++) {
        event_text(t, curve, &e[i], text);
        fprintf(t->rows.f, "# circuit %d: %s, at input ", curve + 1, text);
        cli_row_number(t->rows.f, e[i].input/cli_curve_unit(t, 0));
        fprintf(t->rows.f, ", arc %.10g\n", lw_motion_curve_arc(motion, e[i].station));
    }
}

static void csv_stretch(cli_curve_trace *t, int index)
{
    const cli_stretch *s = &t->stretch[index];
    fprintf(t->rows.f, "# arc %d: circuit %d, input ", index + 1, s->curve + 1);
    cli_row_number(t->rows.f, s->first/cli_curve_unit(t, 0));
    fputs(s->limit[0] ? " (limit) to " : " to ", t->rows.f);
    cli_row_number(t->rows.f, s->last/cli_curve_unit(t, 0));
    fprintf(t->rows.f, "%s%s\n", s->limit[1] ? " (limit)" : "", s->turns && t->whole ? ", turns fully" : "");
}

static void json_events(cli_curve_trace *t, int curve)
{
    const lw_motion_curve *motion = t->curves.curve[curve];
    static const char *const kind[] = { "limit", "dead_point", "branch_point" };
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    cli_json_array(t->rows.json, "events");
    for (int i = 0; i < n; i++) {
        cli_json_object(t->rows.json, NULL);
        cli_json_text(t->rows.json, "kind", kind[e[i].kind]);
        cli_json_text(t->rows.json, "joint", e[i].joint < 0 ? NULL : t->k.joint[e[i].joint].name);
        cli_json_real(t->rows.json, "input", e[i].input/cli_curve_unit(t, 0));
        cli_json_real(t->rows.json, "along", lw_motion_curve_arc(motion, e[i].station));
        int other = crossing_circuit(t, curve, &e[i]);
        if (other >= 0)
            cli_json_int(t->rows.json, "circuit", other + 1);
        cli_json_end(t->rows.json);
    }
    cli_json_end(t->rows.json);
}

static void json_circuit(cli_curve_trace *t, int curve)
{
    static const char *const end[] = { "closed", "far", "singular", "stopped" };
    const lw_motion_curve *motion = t->curves.curve[curve];
    cli_json *j = t->rows.json;
    cli_json_object(j, NULL);
    cli_json_int(j, "circuit", curve + 1);
    cli_json_text(j, "ends", end[lw_motion_curve_ended(motion)]);
    cli_json_int(j, "turns", lw_motion_curve_turns(motion, -1));
    cli_json_real(j, "length", lw_motion_curve_length(motion));
    cli_json_real(j, "residual", lw_motion_curve_worst(motion)/t->k.units.metre);
    json_events(t, curve);
    cli_json_end(j);
}

static void json_stretch(cli_curve_trace *t, int index)
{
    const cli_stretch *s = &t->stretch[index];
    cli_json *j = t->rows.json;
    cli_json_object(j, NULL);
    cli_json_int(j, "arc", index + 1);
    cli_json_int(j, "circuit", s->curve + 1);
    cli_json_reals(j, "range", (double[]){ s->first/cli_curve_unit(t, 0), s->last/cli_curve_unit(t, 0) }, 2);
    cli_json_bool(j, "first_is_limit", s->limit[0]);
    cli_json_bool(j, "last_is_limit", s->limit[1]);
    cli_json_bool(j, "turns", s->turns);
    cli_json_array(j, "rows");
    stretch_rows(t, index);
    cli_json_end(j);
    cli_rows_arc_end(&t->rows, index + 1);
    cli_json_end(j);
}

/* ---- all of it --------------------------------------------------------------------------------- */

static void print_csv(cli_curve_trace *t, bool cycle)
{
    char lead[128];
    fprintf(t->rows.f, "# %s\n", t->line);
    snprintf(lead, sizeof lead, "%sinput %s", cycle ? "along 1; " : "", cli_input_unit(&t->k, 0));
    cli_rows_units(&t->rows, lead, t->timed ? "s" : cli_input_slides(&t->k, 0) ? cli_input_unit(&t->k, 0) : "rad");
    for (int i = 0; i < t->curves.n; i++)
        csv_curve(t, i);
    for (int i = 0; i < t->n_stretch && !cycle; i++)
        csv_stretch(t, i);
    cli_rows_head(&t->rows, cycle ? "along,input" : "input");
    for (int i = 0; i < (cycle ? t->curves.n : t->n_stretch) && !t->rows.cut_short; i++) {
        if (cycle)
            cycle_rows(t, i);
        else
            stretch_rows(t, i);
        cli_rows_arc_end(&t->rows, i + 1);
    }
}

static void print_json(cli_curve_trace *t, bool cycle)
{
    cli_json *j = t->rows.json;
    cli_rows_head(&t->rows, cycle ? "along,input" : "input");
    cli_json_array(j, "circuits");
    for (int i = 0; i < t->curves.n; i++)
        json_circuit(t, i);
    cli_json_end(j);
    cli_json_array(j, "arcs");
    for (int i = 0; i < (cycle ? t->curves.n : t->n_stretch) && !t->rows.cut_short; i++)
        if (cycle) {
            cli_json_object(j, NULL);
            cli_json_int(j, "arc", i + 1);
            cli_json_int(j, "circuit", i + 1);
            cli_json_array(j, "rows");
            cycle_rows(t, i);
            cli_json_end(j);
            cli_rows_arc_end(&t->rows, i + 1);
            cli_json_end(j);
        } else
            json_stretch(t, i);
    cli_json_end(j);
}

void cli_curve_print(cli_curve_trace *t, bool cycle)
{
    t->rows.total = (double)(cycle ? t->curves.n : t->n_stretch)*(t->steps + 1);
    if (t->rows.json)
        print_json(t, cycle);
    else
        print_csv(t, cycle);
}

/* ---- in time ------------------------------------------------------------------------------------- */

static void begin(cli_curve_trace *t)
{
    char text[512];
    if (!t->rows.json) {
        fprintf(t->rows.f, "# %s\n", t->line);
        cli_time_columns(&t->k, true, text, sizeof text);
        cli_rows_units(&t->rows, text, "s");
        for (int i = 0; i < t->k.n_input; i++) {
            const lw_expression *x = t->model->motion[i];
            fprintf(t->rows.f, "# input %d, %s: %s\n", i + 1, t->k.joint[t->k.input[i].joint].name,
                    x ? lw_expression_text(x) : t->k.input[i].ratio != 0 ? "goes with input 1" : "rests");
        }
    }
    cli_time_columns(&t->k, false, text, sizeof text);
    cli_rows_head(&t->rows, text);
    if (t->rows.json) {
        cli_json_array(t->rows.json, "arcs");
        cli_json_object(t->rows.json, NULL);
        cli_json_int(t->rows.json, "arc", 1);
        cli_json_array(t->rows.json, "rows");
    }
}

static void put_posture(cli_curve_trace *t, lw_prescribed_motion *d, bool first)
{
    double *series = t->series, u[LW_INPUT_MAX];
    memset(series, 0, (CLI_ROW_ORDER + 1)*(size_t)t->s.n_q*sizeof *series);
    cli_row row = { .arc = 1, .mode = ".", .n_lead = 1 + t->k.n_input, .lead = t->lead, .value = t->value };
    row.rates = lw_prescribed_motion_rates(d, CLI_ROW_ORDER, series);
    memcpy(series, lw_prescribed_motion_posture(d), (size_t)t->s.n_q*sizeof *series);
    row.lead[0] = lw_prescribed_motion_time(d);
    lw_prescribed_motion_of_model((void *)t->model, lw_prescribed_motion_time(d), 0, u);
    for (int i = 0; i < t->k.n_input; i++)
        row.lead[1 + i] = u[i]/cli_curve_unit(t, i);
    tracer_values(t, series, first, &row);
    cli_rows_put(&t->rows, &row);
}

lw_status cli_time_print(const cli_call *call, cli_curve_trace *t, const double range[3], lw_error *e)
{
    lw_prescribed_motion *d;
    lw_status s = lw_prescribed_motion_create(&t->s, t->drawn, lw_prescribed_motion_of_model, (void *)t->model, range[0], &d, e);
    if (s != LW_OK)
        return s;
    double n = floor((range[1] - range[0])/range[2]*(1 + 1e-12));
    t->rows.total = n + 1;
    begin(t);
    for (double i = 0; i <= n && s == LW_OK && !cli_rows_stopped(&t->rows); i++) {
        s = lw_prescribed_motion_to(d, range[0] + i*range[2]);
        if (s == LW_OK)
            put_posture(t, d, i == 0);
    }
    if (s != LW_OK)
        lw_prescribed_motion_ended(d, s, &t->k, e);
    double last, between[2];
    char how[LW_PRESCRIBED_MOTION_TEXT];
    if (lw_prescribed_motion_lost(d, &t->k, between, how))
        lw_note_lost(cli_notes(call), "t", between, 1, "s", how);
    int crossings = lw_prescribed_motion_crossings(d, &last);
    if (crossings > 0 && !t->rows.json)
        fprintf(t->rows.f, "# branch points passed straight on: %d, the last at time %.12g\n", crossings, last);
    if (!t->rows.json)
        cli_rows_arc_end(&t->rows, 1);
    if (t->rows.json) {
        cli_json_end(t->rows.json);
        cli_rows_arc_end(&t->rows, 1);
        cli_json_int(t->rows.json, "branch_points", crossings);
        cli_json_end(t->rows.json);
        cli_json_end(t->rows.json);
    }
    lw_prescribed_motion_free(d);
    return s;
}

/* ---- rows between two seeds, computed by groups ------------------------------------------------- */

#define LEAST_MARGIN 1e-5              /* nearer to a dead point of a group, use the curve           */

cli_groups *cli_groups_make(const lw_linkage *linkage, unsigned tracers)
{
    cli_groups *g = calloc(1, sizeof *g);
    double input;
    lw_status s = LW_E_MEMORY;
    if (g) {
        g->k = *linkage;
        s = lw_plan_make(linkage, (lw_plan_options){ .tracers = tracers, .all_joints = true, .kind = LW_PLAN_HIGHER },
                         &g->plan, NULL);
    }
    if (s == LW_OK)
        s = lw_plan_read(&g->plan, linkage, g->dim, g->mode, &input, NULL);
    if (s == LW_OK)
        return g;
    if (s == LW_E_MEMORY)
        cli_lost();
    free(g);
    return NULL;
}

static bool solve(cli_groups *g, double u)
{
    lw_status s = lw_posture_solve(&g->plan, g->dim, g->mode, u + g->more, CLI_ROW_ORDER, &g->posture);
    if (s == LW_E_MEMORY)
        cli_lost();
    return s == LW_OK && g->posture.margin > LEAST_MARGIN;
}

void cli_groups_seed(cli_groups *g, const lw_system *s, const double *q, double u, const cli_rows *rows, const cli_row *row)
{
    double dim[LW_DIM_MAX], input;
    lw_system_write(s, q, &g->k);
    g->seeded = lw_plan_read(&g->plan, &g->k, dim, g->mode, &input, NULL) == LW_OK;
    g->more = input - u;
    g->seeded = g->seeded && solve(g, u);
    for (int i = 0; i < g->k.n_tracer && g->seeded; i++) {
        g->angle[i] = row->value[i][8]*rows->k.units.radian;
        g->tool[i] = g->angle[i] - g->posture.angle[g->k.tracer[i].link][0];
    }
}

bool cli_groups_row(cli_groups *g, double u, double by, const cli_rows *rows, cli_row *row)
{
    if (!g->seeded || !solve(g, u))
        return false;
    for (int i = 0; i < g->k.n_tracer; i++) {
        lw_vec2 p[CLI_ROW_ORDER + 1];
        double a[CLI_ROW_ORDER + 1], scale = 1;
        if (!cli_rows_want(rows, i))
            continue;
        const double *turn = g->posture.angle[g->k.tracer[i].link];
        for (int order = 0; order <= CLI_ROW_ORDER; order++, scale *= by) {
            p[order] = lw_v2_scale(g->posture.tracer[i][order], scale);
            a[order] = turn[order]*scale;
        }
        g->angle[i] += remainder(turn[0] + g->tool[i] - g->angle[i], 2*LW_PI);
        cli_row_values(rows, p, a, g->angle[i], row->value[i]);
    }
    row->rates = true;
    return true;
}
