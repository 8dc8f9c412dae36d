/* linkwright trace - what the tracers of a linkage do over every range of its input. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/suggest.h"
#include "cli/model.h"
#include "cli/output.h"
#include "cli/trace.h"

typedef struct settings {
    int         steps, mode;
    const char *tracer;
    double      from, to, speed;
} settings;

enum { MODE_BOTH, MODE_FILE };

static const cli_option options[] = {
    { "steps", 'n', CLI_INT, offsetof(settings, steps), "N", "360",
      "intervals per arc; their ends are exact", 1, 10000000, NULL, NULL },
    { "tracer", 't', CLI_TEXT, offsetof(settings, tracer), "NAME", NULL,
      "only this tracer; without it all of them", 0, 0, NULL, NULL },
    { "mode", 'm', CLI_CHOICE, offsetof(settings, mode), "both|file", "both",
      "arcs of all assembly modes, or only the arc that holds the posture of the file", 0, 0, NULL, NULL },
    { "from", 0, CLI_REAL, offsetof(settings, from), "A", NULL,
      "least input, in the unit of the file", 0, 0, "to", NULL },
    { "to", 0, CLI_REAL, offsetof(settings, to), "B", NULL,
      "greatest input", 0, 0, "from", NULL },
    { "speed", 's', CLI_REAL, offsetof(settings, speed), "W", NULL,
      "constant speed of the input [rad/s, or length unit/s for a slider]: derivatives are by time "
      "instead of by the input", 0, 0, NULL, NULL },
    { .name = NULL }
};

static lw_status choose_tracers(const settings *s, const char *file, const lw_linkage *k,
                                unsigned *tracers, lw_error *e)
{
    const char *names[LW_TRACER_MAX];
    if (k->n_tracer == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "the linkage has no tracer, so there is nothing to "
                           "trace; add \"tracers\" to the file");
    *tracers = (1u << k->n_tracer) - 1;
    if (!s->tracer)
        return LW_OK;
    for (int i = 0; i < k->n_tracer; i++) {
        names[i] = k->tracer[i].name;
        if (strcmp(names[i], s->tracer) == 0) {
            *tracers = 1u << i;
            return LW_OK;
        }
    }
    const char *near = lw_suggest(s->tracer, names, k->n_tracer);
    return lw_error_at(e, LW_E_ARG, file, 0, 0, "there is no tracer '%s'; %s '%s'", s->tracer,
                       near ? "did you mean" : "the first is", near ? near : names[0]);
}

static void set_window(const settings *s, const cli_call *call, cli_trace *t)
{
    const lw_input *in = &t->k.input[0];
    t->whole = !cli_given(&call->parsed, "from") && in->first == in->last;
    t->from = t->to = 0;
    if (cli_given(&call->parsed, "from")) {
        double unit = t->plan.input_is_slider ? t->k.units.metre : t->k.units.radian;
        t->from = s->from*unit;
        t->to = s->to*unit;
    } else if (!t->whole) {
        t->from = fmin(in->first, in->last);
        t->to = fmax(in->first, in->last);
    }
}

/* The tool of a tracer turns with its link: read their angle off the posture of the file. */
static void set_tools(cli_trace *t)
{
    lw_pose pose;
    lw_pose_solve(&t->plan, t->dim, t->mode, t->input, 0, &pose);
    for (int i = 0; i < t->k.n_tracer; i++)
        t->tool[i] = t->k.tracer[i].angle - pose.angle[t->k.tracer[i].link][0];
}

static lw_status prepare(const cli_call *call, cli_trace *t, lw_error *e)
{
    const settings *s = call->settings;
    const char *file = call->parsed.word[0];
    lw_status st = cli_read_linkage(file, 0, &t->k, e);
    if (st == LW_OK)
        st = choose_tracers(s, file, &t->k, &t->tracers, e);
    if (st == LW_OK)
        st = lw_plan_make(&t->k, (lw_want){ .tracers = t->tracers, .all_joints = true }, &t->plan, e);
    if (st == LW_OK)
        st = lw_plan_read(&t->plan, &t->k, t->dim, t->mode, &t->input, e);
    if (st != LW_OK)
        return st;
    st = lw_motion_find(&t->plan, t->dim, &t->motion);
    if (st < 0)
        return lw_error_at(e, st, file, 0, 0, "its motion cannot be found: %s", lw_status_text(st));
    if (st == LW_STOPPED)
        cli_note(call, "the linkage has more arcs than the %d that are traced", LW_ARC_MAX);
    set_tools(t);
    set_window(s, call, t);
    t->speed = cli_given(&call->parsed, "speed") ? s->speed : 0;
    t->timed = cli_given(&call->parsed, "speed");
    t->steps = s->steps;
    cli_trace_pieces(t, s->mode == MODE_FILE);
    return LW_OK;
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    if (cli_given(&call->parsed, "from") && !(s->from < s->to))
        return cli_usage(call, "--from must be less than --to");
    double start = lw_clock_wall();
    cli_trace *t = calloc(1, sizeof *t);
    lw_error e = { 0 };
    lw_output o;
    if (!t)
        lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (!t || prepare(call, t, &e) != LW_OK || cli_open(call, &o, &e) != LW_OK) {
        free(t);
        return cli_fail(call, &e);
    }
    t->f = o.f;
    t->line = call->line;
    t->stop = cli_stop_flag();
    t->until = call->common.time > 0 ? start + call->common.time : 0;
    cli_progress progress = cli_progress_begin(call, "trace", "rows");
    t->progress = &progress;
    if (call->common.json)
        cli_trace_json(t);
    else
        cli_trace_csv(t);
    cli_progress_end(&progress);
    int code = t->cut_short ? CLI_LIMIT : t->n_piece > 0 ? CLI_DONE : CLI_NOTHING;
    if (code == CLI_NOTHING)
        cli_note(call, "%s", t->motion.n_arc ? "the linkage does not reach that range of the input"
                                             : "the linkage closes nowhere");
    free(t);
    return cli_close(call, &o, code);
}

const cli_command cli_trace_command = {
    .name = "trace",
    .words = "MODEL.json",
    .title = "curves, velocities, accelerations and jerks of the tracers of a linkage",
    .examples =
        "  linkwright trace examples/hoeken.json                    all arcs, as CSV\n"
        "  linkwright trace examples/slider-crank.json --speed 10   per second, at 10 rad/s\n"
        "  linkwright trace model.json --mode file --steps 36       one arc, 37 rows\n"
        "  linkwright trace model.json --from -90 --to 90 --json    part of the input, as JSON\n",
    .about =
        "An arc is a range of the input in one assembly mode; its ends, where they are limits of\n"
        "the motion, are found to 1e-10 and are the first and last row. Lengths and angles are in\n"
        "the units of the file, derivatives (v, a, j) by the input in rad or in its length unit,\n"
        "those of the tool's angle in rad. At a limit they do not exist: the fields are empty (null\n"
        "in JSON). Lines that begin with # tell units, arcs, limits and dead points. MODEL may be\n"
        "- for standard input.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1,
    .run = run,
};
