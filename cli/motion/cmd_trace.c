/* linkwright trace - motion of the tracers of a linkage over every range of its input. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "cli/motion/trace.h"
#include "cli/motion/trace_curve.h"
#include "cli/motion/trace_large.h"
#include "cli/motion/spatial.h"
#include "mbs/constraints/adjust.h"
#include "mbs/constraints/mobility.h"

typedef struct settings {
    int         steps, mode, result;
    const char *tracer, *range;
    double      input_range[2];
    const char *speed, *plot;
    bool        cycle, all, explain, geometry;
} settings;

enum { MODE_BOTH, MODE_FILE };

/* Data that all kinds of trace need. */
typedef struct job {
    const cli_call *call;
    const settings *s;
    const lw_model *m;
    lw_linkage     *k;                /* of the model, without idle freedoms; NULL: it is too large */
    int             only;             /* the tracer that is printed; -1: all                       */
    double          until, half;      /* wall time [s] at which rows, and the search for circuits, stop; 0: never */
    double          speed;            /* of the input [rad/s] or [m/s]; 0: not given               */
    cli_kept       *kept;             /* rows for the plot; NULL: none                             */
} job;

static const cli_option options[] = {
    { "steps", 'n', CLI_INT, offsetof(settings, steps), "N", "360",
      "number of intervals on each arc; the ends of an arc are exact", 1, 10000000, NULL, NULL },
    { "result", 'r', CLI_INT, offsetof(settings, result), "N", "0",
      "number of the result in a file that 'linkwright fit' wrote, 1 is the best; without it the best, or the one "
      "linkage in the file", 0, 1000000, NULL, NULL },
    { "tracer", 0, CLI_TEXT, offsetof(settings, tracer), "NAME", NULL, "only this point (tracer); without it all of them", 0, 0, NULL, NULL },
    { "mode", 'm', CLI_CHOICE, offsetof(settings, mode), "both|file", "both",
      "both: arcs of all assembly modes; file: only the arc that contains the posture of the file", 0, 0, NULL, NULL },
    { "input-range", 0, CLI_RANGE, offsetof(settings, input_range), "MIN:MAX", NULL,
      "only this part of the input, in the unit of the file", -1e9, 1e9, NULL, NULL },
    { "speed", 's', CLI_TEXT, offsetof(settings, speed), "W", NULL,
      "constant speed of the input [rad/s, or length unit/s for a slider], or with a unit: \"60 rpm\"; derivatives are "
      "then with respect to time instead of the input", 0, 0, NULL, NULL },
    { "plot", 'p', CLI_PLOT, offsetof(settings, plot), "FILE", NULL,
      "draw place, velocity and acceleration of the tracers over the input or the time (.svg, .pdf, .png); of the arc "
      "that contains the posture of the file, unless --mode both is given; rows are then printed only with -o or "
      "--json", 0, 0, NULL, NULL },
    { "geometry", 0, CLI_FLAG, offsetof(settings, geometry), NULL, NULL,
      "more columns: curvature of the path; instant centre of the tracer's link at the ground (pole_x, pole_y: fixed "
      "centrode), the same on the link (pole_u, pole_v from the tracer along the tool: moving centrode); far end of the "
      "inflection circle's diameter; and the double points of the path; with --plot panels of them. In space: curvature, "
      "a point of the screw axis (along w) about which the link moves, and its pitch", 0, 0, NULL, NULL },
    { "cycle", 0, CLI_FLAG, offsetof(settings, cycle), NULL, NULL,
      "follow the motion past the limits of the input until it closes, and print one closed curve with rows at equal "
      "distances", 0, 0, NULL, "input-range" },
    { "all-assemblies", 0, CLI_FLAG, offsetof(settings, all), NULL, NULL,
      "search for every circuit, also if the linkage is not made of dyads; the search is random (--seed)", 0, 0, NULL, NULL },
    { "explain", 'e', CLI_FLAG, offsetof(settings, explain), NULL, NULL,
      "print how the linkage would be solved, group by group, and which parts are not needed; then end", 0, 0, NULL, NULL },
    { "time-range", 0, CLI_TEXT, offsetof(settings, range), "T0:T1:DT", NULL,
      "move all inputs by their \"motion\" from time T0 to T1 [s], with a row every DT", 0, 0, NULL, "input-range" },
    { .name = NULL }
};

/* Without tracers: the pins between two moving links, each place once, as far as there is room. */
static void trace_pins(const cli_call *call, lw_assembly *linkage, int room)
{
    int left_out = 0;
    for (int i = 0; i < linkage->n_joint; i++) {
        const lw_joint *j = &linkage->joint[i];
        bool fresh = lw_joint_turns(j->kind) && j->link[0] != linkage->ground && j->link[1] != linkage->ground;
        for (int q = 0; q < linkage->n_tracer; q++)
            fresh = fresh && (linkage->tracer[q].at.x != j->at.x || linkage->tracer[q].at.y != j->at.y);
        if (!fresh)
            continue;
        if (linkage->n_tracer == room) {
            left_out++;
            continue;
        }
        lw_tracer *t = &linkage->tracer[linkage->n_tracer++];
        *t = (lw_tracer){ .link = j->link[0], .at = j->at };
        snprintf(t->name, sizeof t->name, "%s", j->name);
    }
    if (linkage->n_tracer > 0)
        cli_note(call, "the file has no tracers: its moving pins are traced");
    if (left_out > 0)
        cli_note(call, "%d more moving pin%s left out; name the points you want in \"tracers\"", left_out, left_out == 1 ? " is" : "s are");
}

static lw_status choose_tracers(const settings *s, const char *file, const lw_assembly *linkage, int *only, lw_error *e)
{
    if (linkage->n_tracer == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "the linkage has no tracer and no pin between moving links, so "
                           "there is nothing to trace; add \"tracers\" to the file");
    *only = -1;
    if (!s->tracer)
        return LW_OK;
    for (int i = 0; i < linkage->n_tracer; i++)
        *only = strcmp(linkage->tracer[i].name, s->tracer) == 0 ? i : *only;
    if (*only >= 0)
        return LW_OK;
    const char *near = LW_SUGGEST(s->tracer, linkage->tracer, linkage->n_tracer, name);
    return lw_error_at(e, LW_E_ARG, file, 0, 0, "there is no tracer '%s'; %s '%s'%s", s->tracer,
                       near ? "did you mean" : "the first is", near ? near : linkage->tracer[0].name, near ? "?" : "");
}

static void set_window(const settings *s, const cli_call *call, cli_trace *t)
{
    const lw_input *in = &t->k.input[0];
    t->whole = !cli_given(&call->parsed, "input-range") && in->first == in->last;
    t->from = t->to = 0;
    if (cli_given(&call->parsed, "input-range")) {
        double unit = t->plan.input_is_slider ? t->k.units.metre : t->k.units.radian;
        t->from = s->input_range[0]*unit;
        t->to = s->input_range[1]*unit;
    } else if (!t->whole) {
        t->from = fmin(in->first, in->last);
        t->to = fmax(in->first, in->last);
    }
}

/* The tool of a tracer turns with its link: read its angle from the posture in the file. */
static void set_tools(cli_trace *t)
{
    lw_posture posture;
    lw_posture_solve(&t->plan, t->dim, t->mode, t->input, 0, &posture);
    for (int i = 0; i < t->k.n_tracer; i++)
        t->tool[i] = t->k.tracer[i].angle - posture.angle[t->k.tracer[i].link][0];
}

static unsigned tracer_bits(const job *j) { return j->only < 0 ? (1u << j->k->n_tracer) - 1 : 1u << j->only; }

/* ---- by the plan ------------------------------------------------------------------------------- */

static cli_rows make_rows(const job *j, const lw_linkage *linkage)
{
    return (cli_rows){ .k = linkage ? lw_linkage_view(linkage) : j->m->linkage, .only = j->only, .stop = cli_stop_flag(), .until = j->until,
                       .kept = j->kept, .geometry = j->s->geometry };
}

/* Needs t->k and t->plan. */
static lw_status prepare(const job *j, cli_trace *t, lw_error *e)
{
    const settings *s = j->s;
    const cli_call *call = j->call;
    const char *file = call->parsed.word[0];
    lw_status st = lw_plan_read(&t->plan, &t->k, t->dim, t->mode, &t->input, e);
    if (st != LW_OK)
        return st;
    st = lw_motion_find(&t->plan, t->dim, &t->motion);
    if (st < 0)
        return lw_error_at(e, st, file, 0, 0, "its motion cannot be found: %s", lw_status_text(st));
    t->more_arcs = st == LW_STOPPED && (s->mode != MODE_FILE || lw_motion_arc(&t->plan, &t->motion, t->mode, t->input) < 0);
    set_tools(t);
    set_window(s, call, t);
    t->speed = j->speed;
    t->timed = cli_given(&call->parsed, "speed");
    t->steps = s->steps;
    t->rows = make_rows(j, &t->k);
    if (j->kept && !cli_given(&call->parsed, "mode"))      /* one assembly mode is easier to read */
        j->kept->only = lw_motion_arc(&t->plan, &t->motion, t->mode, t->input) + 1;
    cli_trace_pieces(t, s->mode == MODE_FILE);
    t->rows.total = (double)t->n_piece*(t->steps + 1);
    return LW_OK;
}

/* Is something left out of the output? Report arcs that are left out. */
static bool cut_short(const cli_call *call, const cli_rows *r, bool dropped, int most)
{
    if (dropped)
        cli_note(call, "there are more arcs than the %d that are traced; narrow --input-range", most);
    return r->cut_short || dropped;
}

static int print_plan(const cli_call *call, cli_trace *t)
{
    lw_error e = { 0 };
    lw_output o;
    if (cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    t->rows.f = o.f;
    t->line = call->line;
    cli_progress progress = cli_progress_begin(call, "trace", "rows");
    t->rows.progress = &progress;
    if (call->common.json)
        cli_trace_json(t);
    else
        cli_trace_csv(t);
    cli_progress_end(&progress);
    bool some = cut_short(call, &t->rows, t->dropped, CLI_PIECE_MAX) || t->more_arcs;
    int code = some ? CLI_LIMIT : t->n_piece ? CLI_DONE : CLI_NOTHING;
    if (code == CLI_NOTHING)
        cli_note(call, "%s", t->motion.n_arc ? "the linkage does not reach that range of the input" : "the linkage closes nowhere");
    return cli_close(call, &o, code);
}

/* ---- along curves of postures, and in time ----------------------------------------------------- */

static lw_status read_range(const settings *s, double range[3], lw_error *e)
{
    char text[128], *part = text, *rest;
    int n = 0;
    snprintf(text, sizeof text, "%s", s->range);
    static const cli_option row = { "time-range", 0, CLI_REAL, 0, "T0:T1:DT", NULL, NULL, 0, 0, NULL, NULL };
    for (; part && n < 3; part = rest) {
        rest = strchr(part, ':');
        if (rest)
            *rest++ = 0;
        lw_status st = cli_value(&row, "time-range", part, &range[n++], e);
        if (st != LW_OK)
            return st;
    }
    if (n < 3 || part || !(range[0] < range[1]) || !(range[2] > 0) || (range[1] - range[0])/range[2] > 1e7)
        return lw_error_set(e, LW_E_ARG, "--time-range: three numbers are wanted, T0:T1:DT with T0 < T1 and at most "
                            "1e7 steps of DT > 0, as in 0:1:0.01");
    return LW_OK;
}

/* Add the file's name to an error of the library. */
static int fail_in(const cli_call *call, lw_error *e)
{
    if (!e->file[0] && e->status != LW_E_MEMORY)
        snprintf(e->file, sizeof e->file, "%s", call->parsed.word[0]);
    return cli_fail(call, e);
}

/* Keep only the stretch that contains the posture of the file. */
static void keep_posture_stretch(cli_curve_trace *t)
{
    double start = lw_motion_curve_start(t->curves.curve[0]);
    for (int i = 0; i < t->n_stretch; i++) {
        const cli_stretch *s = &t->stretch[i];
        if (s->curve == 0 && (s->n_part > 1 || (s->part[0].from <= start && start <= s->part[0].to))) {
            t->stretch[0] = *s;
            t->n_stretch = 1;
            return;
        }
    }
}

static lw_status find_curves(const cli_call *call, cli_curve_trace *t, bool all, double until, lw_error *e)
{
    lw_motion_curve_options o = { .input = 0, .stop = cli_stop_flag(), .until = until };
    lw_status st = lw_circuits_find(&t->s, t->drawn, &o, all ? 300 : 0, call->common.seed, &t->curves, e);
    if (st == LW_OK && all)
        cli_note(call, "%d circuit%s found so far; the last %d of %d postures that closed were on them%s",
                 t->curves.n, lw_plural(t->curves.n), t->curves.since, t->curves.closed,
                 t->curves.late ? "; half of --time ended the search" : "");
    for (int i = 0; st == LW_OK && i < t->curves.n; i++) {
        lw_motion_curve_end end = lw_motion_curve_ended(t->curves.curve[i]);
        if (end == LW_MOTION_CURVE_LOST || end == LW_MOTION_CURVE_STOPPED)
            cli_note(call, "circuit %d is not followed to its end: %s", i + 1, end == LW_MOTION_CURVE_LOST
                     ? "no step is short enough at a singular posture" : "it has not closed after 20000 steps");
    }
    return st;
}

static void curve_window(const job *j, cli_curve_trace *t)
{
    const settings *s = j->s;
    const cli_call *call = j->call;
    const lw_input *in = &t->k.input[0];
    double unit = t->k.n_input ? cli_curve_unit(t, 0) : 1;
    bool given = cli_given(&call->parsed, "input-range");
    t->whole = !given && in->first == in->last;
    t->from = given ? s->input_range[0]*unit : fmin(in->first, in->last);
    t->to = given ? s->input_range[1]*unit : fmax(in->first, in->last);
    t->timed = cli_given(&call->parsed, "speed");
    t->speed = j->speed;
    t->steps = s->steps;
}

static void json_top(const cli_call *call, cli_curve_trace *t, const char *way)
{
    cli_json *j = t->rows.json;
    const lw_input *in = &t->k.input[0];
    bool slider = t->k.n_input && lw_joint_slides(t->k.joint[in->joint].kind);
    bool timed = t->timed || strcmp(way, "time") == 0;
    cli_json_head(j, call->line);
    cli_json_text(j, "name", t->k.name);
    cli_json_text(j, "way", way);
    cli_json_object(j, "units");
    cli_json_text(j, "length", t->k.units.length);
    cli_json_text(j, "angle", t->k.units.angle);
    cli_json_text(j, "rates_by", timed ? "s" : slider ? "length" : "rad");
    cli_json_end(j);
}

static bool all_rest(const cli_curve_trace *t)
{
    bool rest = true;
    for (int i = 0; i < t->curves.n; i++)
        rest = rest && lw_motion_curve_rests(t->curves.curve[i]);
    return rest;
}

static int print_curves(const cli_call *call, cli_curve_trace *t, const double *range)
{
    const settings *s = call->settings;
    lw_output o;
    lw_error e = { 0 };
    if (cli_open(call, &o, &e) != LW_OK)
        return fail_in(call, &e);
    cli_progress progress = cli_progress_begin(call, "trace", "rows");
    cli_json json = cli_json_begin(o.f, 1);
    lw_status st = LW_OK;
    t->rows.f = o.f;
    t->rows.progress = &progress;
    t->line = call->line;
    if (call->common.json) {
        t->rows.json = &json;
        json_top(call, t, range ? "time" : s->cycle ? "cycle" : "curve");
    }
    if (range)
        st = cli_time_print(call, t, range, &e);
    else
        cli_curve_print(t, s->cycle);
    if (t->rows.json && st >= 0)
        cli_json_end(&json);
    cli_progress_end(&progress);
    if (st != LW_OK) {
        int code = fail_in(call, &e);
        if (t->rows.done == 0) {
            lw_output_abandon(&o);
            return code;
        }
        return cli_close(call, &o, st == LW_OPEN ? CLI_LIMIT : code);
    }
    bool nothing = !range && !s->cycle && t->n_stretch == 0;
    if (nothing)
        cli_note(call, all_rest(t) ? "the input stands still while parts move; --cycle shows how"
                                   : "the linkage does not reach that range of the input");
    bool some = cut_short(call, &t->rows, t->dropped, t->n_stretch);
    return cli_close(call, &o, some || t->curves.late ? CLI_LIMIT : nothing ? CLI_NOTHING : CLI_DONE);
}

static void free_curves(cli_curve_trace *t)
{
    if (!t)
        return;
    lw_circuits_free(&t->curves);
    lw_system_free(&t->s);
    free(t->groups);
    free(t->drawn);
    free(t->series);
    free(t->stretch);
    free(t);
}

/* An overconstrained linkage that is drawn with rounded numbers is made to move. */
static lw_status adjust(const job *j, cli_curve_trace *t, lw_error *e)
{
    double by;
    if (!(t->drawn = malloc((size_t)t->s.n_q*sizeof *t->drawn)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_system_posture(&t->s, t->drawn);
    lw_status st = lw_system_adjust(&t->s, t->drawn, &by, e);
    if (st == LW_OK)
        lw_note_adjusted(cli_notes(j->call), by*t->s.unit, 0);
    return st == LW_NOTHING ? LW_OK : st;
}

/* Prepare the curves. all: every circuit, not only that of the posture in the file. */
static lw_status make_curves(const job *j, bool timed, bool all, cli_curve_trace **out, lw_error *e)
{
    cli_curve_trace *t = *out = calloc(1, sizeof *t);
    if (!t)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    t->model = j->m;
    t->rows = make_rows(j, j->k);
    t->k = t->rows.k;
    lw_status st = lw_system_assemble(&t->k, NULL, 0, &t->s, e);
    if (st == LW_OK)
        st = cli_curve_room(t, e);
    if (st == LW_OK && j->k)
        st = adjust(j, t, e);
    if (st == LW_OK)
        curve_window(j, t);
    if (st != LW_OK || timed || (st = find_curves(j->call, t, all, j->half, e)) != LW_OK)
        return st;
    t->groups = j->s->cycle || !j->k ? NULL : cli_groups_make(j->k, tracer_bits(j));
    st = cli_curve_stretches(t, e);
    if (st == LW_OK && j->s->mode == MODE_FILE)
        keep_posture_stretch(t);
    return st;
}

/* Trace along curves; range: the range of time, or NULL. */
static int run_curves(const job *j, const double *range)
{
    cli_curve_trace *t;
    lw_error e = { 0 };
    lw_status st = make_curves(j, range != NULL, j->s->all, &t, &e);
    int code = st == LW_OK ? print_curves(j->call, t, range) : fail_in(j->call, &e);
    free_curves(t);
    return code;
}

/* ---- the plan as text --------------------------------------------------------------------------- */

static int explain(const cli_call *call, const lw_linkage *linkage, unsigned tracers)
{
    static lw_plan plan;
    char text[8192];
    lw_error e = { 0 };
    lw_output o;
    bool dyads = lw_plan_make(linkage, (lw_plan_options){ .tracers = tracers }, &plan, &e) == LW_OK;
    lw_status st = lw_plan_make(linkage, (lw_plan_options){ .tracers = tracers, .kind = LW_PLAN_HIGHER }, &plan, &e);
    if ((st != LW_OK && st != LW_E_KIND) || cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    if (st == LW_E_KIND)
        fprintf(o.f, "traced along its motion curve, all links at once: %s\n", e.text);
    else {
        lw_plan_explain(&plan, linkage, text, sizeof text);
        fprintf(o.f, "%straced %s\n", text, dyads ? "in closed form over all arcs, unless they pass change points"
                : "along its motion curve, which passes limits; between the postures of the curve by these groups");
    }
    return cli_close(call, &o, CLI_DONE);
}

/* ---- which way --------------------------------------------------------------------------------- */

static int in_time(const job *j)
{
    const lw_linkage *k = j->k;
    lw_error e = { 0 };
    double range[3];
    bool moved = false;
    for (int i = 0; i < k->n_input; i++)
        moved = moved || j->m->motion[i];
    if (read_range(j->s, range, &e) != LW_OK)
        return cli_usage(j->call, "%s", e.text);
    if (!moved)
        return lw_error_at(&e, LW_E_ARG, j->call->parsed.word[0], 0, 0, "no input has a \"motion\", so nothing "
                           "moves in time; give one, or leave --time-range out"), cli_fail(j->call, &e);
    for (int i = 0; i < k->n_input; i++)
        if (lw_motion_check(j->m->motion[i], k->joint[k->input[i].joint].name, range[0], range[1], &e) != LW_OK)
            return cli_fail(j->call, &e);
    cli_note(j->call, "followed in time by Newton's method");
    return run_curves(j, range);
}

/* Trace with the plan, dyad by dyad. At a change point an assembly mode of a dyad turns off, while the linkage itself
 * goes straight on into the other mode: then trace along the curves, unless the posture is a branch point with too many
 * branches. */
static int by_plan(const job *j, cli_trace *t)
{
    cli_curve_trace *c = NULL;
    lw_error e = { 0 };
    int code;
    if (prepare(j, t, &e) != LW_OK)
        return cli_fail(j->call, &e);
    lw_status st = t->motion.change_point || t->more_arcs ? make_curves(j, false, j->s->mode != MODE_FILE, &c, &e) : LW_NOTHING;
    if (st == LW_OK) {
        cli_note(j->call, "traced along its motion curves, because it %s", t->motion.change_point ? "passes change points"
                 : "has more arcs than are found in closed form");
        code = print_curves(j->call, c, NULL);
    } else if (st == LW_E_MEMORY) {
        code = cli_fail(j->call, &e);
    } else {
        cli_note(j->call, "in closed form, dyad by dyad (%d)", t->plan.n_dyad);
        if (t->more_arcs)
            cli_note(j->call, "the linkage has more arcs than the %d that are printed: %s", LW_ARC_MAX, e.text);
        if (t->motion.change_point)
            cli_note(j->call, "it passes change points, and the rows do not continue through them: %s", e.text);
        code = print_plan(j->call, t);
    }
    free_curves(c);
    return code;
}

static int choose_way(const job *j)
{
    const cli_call *call = j->call;
    const lw_linkage *k = j->k;
    lw_error e = { 0 };
    if (j->s->explain)
        return explain(call, k, tracer_bits(j));
    cli_note_nearly_flat(call, k);
    if (j->s->range)
        return in_time(j);
    int own = lw_linkage_free_inputs(k);
    if (own > 1)
        cli_note(call, "input 1 moves, the other%s; --time-range moves all by their motions", own > 2 ? "s rest" : " rests");
    if (j->s->cycle)
        return run_curves(j, NULL);
    cli_trace *t = calloc(1, sizeof *t);
    if (!t)
        return lw_error_set(&e, LW_E_MEMORY, "out of memory"), cli_fail(call, &e);
    t->k = *k;
    lw_status st = lw_plan_make(k, (lw_plan_options){ .tracers = tracer_bits(j), .all_joints = true }, &t->plan, &e);
    int code;
    if (st == LW_OK)
        code = by_plan(j, t);
    else if (st == LW_E_KIND) {
        cli_note(call, "traced along its motion curve, because it is not made of dyads (%s)", e.text);
        code = run_curves(j, NULL);
    } else
        code = cli_fail(call, &e);
    free(t);
    return code;
}

/* Hold joints whose motion moves no tracer, so that they need no input, and report each. */
static lw_status hold_idle(const cli_call *call, lw_linkage *linkage, lw_error *e)
{
    uint64_t held = 0;
    if (lw_linkage_mobility(linkage) <= lw_linkage_free_inputs(linkage))
        return LW_OK;
    lw_status st = lw_mobility_hold_idle(linkage, &held, e);
    for (int j = 0; j < linkage->n_joint; j++)
        if (held >> j & 1)
            cli_note(call, "%s is held still: its motion moves no tracer", linkage->joint[j].name);
    return st;
}

static int explain_large(const cli_call *call, const lw_model *m)
{
    const lw_assembly *a = &m->linkage;
    lw_error e = { 0 };
    lw_output o;
    if (cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    fprintf(o.f, "%d links and %d joints, all at once: %d coordinates are followed along the input by their Taylor series of order %d, with\n"
                 "sparse matrices, and closed in every row; more than 32 links, 64 joints, 8 inputs or 16 tracers are not split into groups\n",
            a->n_link, a->n_joint, 3*(a->n_link - 1), LW_SERIES_ORDER_MAX);
    return cli_close(call, &o, CLI_DONE);
}

/* A planar model with more parts than a linkage holds. */
static int run_large(const job *j)
{
    const cli_call *call = j->call;
    const settings *s = j->s;
    double range[3], window[2];
    lw_error e = { 0 };
    if (s->explain)
        return explain_large(call, j->m);
    if ((s->cycle || s->all) && !s->range)
        return run_curves(j, NULL);
    if (s->range && read_range(s, range, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (s->mode != MODE_FILE && !s->range)
        cli_note(call, "followed from the posture of the file; other assembly modes are not looked for in a model of this size");
    cli_trace_large t = { .model = j->m, .rows = make_rows(j, NULL), .steps = s->steps, .time_range = s->range ? range : NULL,
                          .timed = cli_given(&call->parsed, "speed"), .speed = j->speed };
    const lw_assembly *a = &j->m->linkage;
    double unit = a->n_input && lw_joint_slides(a->joint[a->input[0].joint].kind) ? a->units.metre : a->units.radian;
    window[0] = s->input_range[0]*unit, window[1] = s->input_range[1]*unit;
    t.input_range = cli_given(&call->parsed, "input-range") ? window : NULL;
    return cli_trace_large_run(call, &t);
}

static int run_spatial(const cli_call *call, const lw_spatial *m)
{
    static const char *const planar[] = { "result", "mode", "cycle", "all-assemblies", "explain", NULL };
    const settings *s = call->settings;
    double range[3];
    lw_error e = { 0 };
    cli_spatial_trace o = { .steps = s->steps, .tracer = s->tracer, .speed = s->speed, .plot = s->plot, .geometry = s->geometry,
                            .input_range = cli_given(&call->parsed, "input-range") ? s->input_range : NULL };
    int code = cli_spatial_refuse(call, planar);
    if (code != CLI_DONE)
        return code;
    if (s->range && read_range(s, range, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    o.time_range = s->range ? range : NULL;
    return cli_spatial_trace_run(call, m, &o);
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    if (cli_given(&call->parsed, "input-range") && !(s->input_range[0] < s->input_range[1]))
        return cli_usage(call, "--input-range wants two different inputs, the smaller first");
    double now = lw_clock_wall(), time = call->common.time;
    lw_error e = { 0 };
    lw_model *m;
    lw_spatial *spatial;
    if (cli_read_any_model(call->parsed.word[0], s->result, &m, &spatial, &e) != LW_OK)
        return cli_fail(call, &e);
    if (spatial) {
        int code = run_spatial(call, spatial);
        cli_free_spatial(spatial);
        return code;
    }
    cli_kept kept = { 0 };
    job j = { .call = call, .s = s, .m = m, .k = m->small, .until = time > 0 ? now + time : 0, .half = time > 0 ? now + time/2 : 0,
              .kept = s->plot ? &kept : NULL };
    lw_assembly parts = j.k ? lw_linkage_view(j.k) : m->linkage;
    bool good = true;
    if (parts.n_tracer == 0 && !j.k) {                    /* room for as many as there are joints */
        parts.tracer = m->linkage.tracer = realloc(parts.tracer, ((size_t)parts.n_joint + 1)*sizeof *parts.tracer);
        good = parts.tracer || lw_error_set(&e, LW_E_MEMORY, "out of memory") == LW_OK;
    }
    if (good && parts.n_tracer == 0)
        trace_pins(call, &parts, j.k ? LW_TRACER_MAX : parts.n_joint);
    *(j.k ? &j.k->n_tracer : &m->linkage.n_tracer) = parts.n_tracer;
    good = good && choose_tracers(s, call->parsed.word[0], &parts, &j.only, &e) == LW_OK
           && (!j.k || hold_idle(call, j.k, &e) == LW_OK);
    if (good && s->speed) {
        bool slides = parts.n_input && lw_joint_slides(parts.joint[parts.input[0].joint].kind);
        if (cli_speed(s->speed, slides, slides ? parts.units.metre : 1, &j.speed, &e) != LW_OK) {
            cli_free_model(m);
            return cli_usage(call, "%s", e.text);
        }
    }
    int code = !good ? fail_in(call, &e) : j.k ? choose_way(&j) : run_large(&j);
    char partial[LW_PATH_SIZE + 16];
    const char *to = s->plot && (code == CLI_DONE || kept.n > 0) ? cli_picture_path(call, s->plot, code, partial) : NULL;
    if (to) {
        cli_rows rows = make_rows(&j, j.k);
        if (cli_rows_plot(&rows, to, &e) != LW_OK)
            code = cli_fail(call, &e);
    }
    free(kept.row);
    cli_free_model(m);
    return code;
}

const cli_command cli_trace_command = {
    .name = "trace",
    .words = "MODEL.json",
    .title = "paths, velocities, accelerations and jerks of the points of a linkage",
    .examples =
        "  linkwright trace examples/hoeken.json                    all arcs, as CSV\n"
        "  linkwright trace examples/slider-crank.json --speed 10   per second, at 10 rad/s\n"
        "  linkwright trace examples/slider-crank.json --speed 60rpm --plot piston.svg\n"
        "  linkwright trace model.json --mode file --steps 36       one arc, 37 rows\n"
        "  linkwright trace model.json --input-range -90:90 --json  part of the input, as JSON\n"
        "  linkwright trace examples/chebyshev.json --cycle         over both limits and back\n"
        "  linkwright trace model.json --tracer foot --explain      how it is solved\n"
        "  linkwright trace examples/loader.json --time-range 0:2:0.02   inputs as functions of time\n"
        "  linkwright trace examples/space/bricard.json             a model in space: places, turns as quaternions\n",
    .about =
        "Prints a row for each position of the input. An arc is a range of the input in one assembly mode. If an\n"
        "arc ends at a limit of the motion, the limit is found to 1e-10 and is the first or last row. Lengths and\n"
        "angles are in the units of the file. The derivatives (v, a, j) are with respect to the input in rad, or\n"
        "in its length unit for a slider; those of the tool angle are in rad. At a limit derivatives do not\n"
        "exist: their fields are empty (null in JSON). Lines that begin with # give units, arcs, limits and dead\n"
        "points. Without tracers in the file its moving pins are traced. MODEL may be - for standard input.\n"
        "\n"
        "Linkages made of dyads are solved in closed form. All others, and those that pass a change point, are\n"
        "followed step by step, with steps small enough never to jump to another assembly mode; standard error\n"
        "and --explain tell which method is used. In the second case only the circuit of the file's posture is\n"
        "printed; --all-assemblies searches for the others. Without it and --cycle, models of more than 32 links are\n"
        "followed from the posture of the file, a whole turn or to the limits of the input (found to 1e-7).\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1,
    .run = run,
};
