/* linkwright clearance - does a pin keep contact with its bush? */
#include <string.h>

#include "base/clock.h"
#include "cli/motion/clearance.h"
#include "cli/program/model.h"

typedef struct settings {
    const char *speed, *stiffness, *damping, *model, *plot, *passes, *path, *force, *history;
    double      end, settle, tolerance, refine, every;
    int         unit, start;
    bool        limits;
} settings;

static const cli_option options[] = {
    { "speeds", 0, CLI_TEXT, offsetof(settings, speed), "LIST", NULL,
      "speeds of the input at the start: numbers and ranges FROM:TO:STEP, separated by commas; without it the speed in the file", 0, 0, NULL, NULL },
    { "speed-unit", 0, CLI_CHOICE, offsetof(settings, unit), "rpm|rad/s|m/s", "rpm",
      "unit of the speeds; m/s for inputs that slide", 0, 0, NULL, NULL },
    { "stiffness", 'K', CLI_TEXT, offsetof(settings, stiffness), "LIST", NULL,
      "stiffness of the contact [N/m], instead of the value in the file", 0, 0, NULL, NULL },
    { "damping", 0, CLI_TEXT, offsetof(settings, damping), "LIST", NULL,
      "damping of the contact [N s/m], instead of the value in the file", 0, 0, NULL, NULL },
    { "model", 0, CLI_TEXT, offsetof(settings, model), "LIST", NULL,
      "models of the clearance to compare: zero, link, mlsd, impact, hunt-crossley, lankarani-nikravesh; instead of "
      "the one in the file", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, offsetof(settings, end), "T", "1.25", "end time of a run [s]", 1e-9, 1e9, NULL, NULL },
    { "settle", 0, CLI_REAL, offsetof(settings, settle), "T", "0.4", "time after which contact is judged [s]", 0, 1e9, NULL, NULL },
    { "start", 0, CLI_CHOICE, offsetof(settings, start), "closed|seated|crank", "closed",
      "closed: the pin is in the middle of its bush and all links have the speeds of the linkage without clearance; "
      "seated: the pin is pressed into the bush by the reaction force; crank: only the driven link moves",
      0, 0, NULL, NULL },
    { "tolerance", 0, CLI_REAL, offsetof(settings, tolerance), "E", "1e-9",
      "error allowed in a step, divided by the size of the linkage", 1e-14, 1e-3, NULL, NULL },
    { "limits", 0, CLI_FLAG, offsetof(settings, limits), NULL, NULL,
      "print only the speeds at which contact is lost, and kept again, as the speed rises", 0, 0, NULL, NULL },
    { "refine", 0, CLI_REAL, offsetof(settings, refine), "W", NULL, "narrow down each of these speeds to this width", 0, 1e9, NULL, NULL },
    { "plot", 'p', CLI_PLOT, offsetof(settings, plot), "FILE", NULL,
      "picture of speed and stiffness that shows where contact is kept or lost (.svg, .pdf, .png)", 0, 0, NULL, NULL },
    { "passes", 0, CLI_PLOT, offsetof(settings, passes), "FILE", NULL,
      "picture of the pin's direction in its bush each time the input passes its start, over speed. A regular motion "
      "gives few points, an irregular one a cloud; use long runs (--to)", 0, 0, NULL, NULL },
    { "path", 0, CLI_PLOT, offsetof(settings, path), "FILE", NULL,
      "picture of the path of the pin in its bush; for one speed and one model", 0, 0, NULL, NULL },
    { "force-plot", 0, CLI_PLOT, offsetof(settings, force), "FILE", NULL,
      "picture of the force over time; for one speed and one model", 0, 0, NULL, NULL },
    { "history", 0, CLI_OUTPUT, offsetof(settings, history), "FILE", NULL,
      "table of path and force over time (CSV); for one speed and one model", 0, 0, NULL, NULL },
    { "every", 0, CLI_REAL, offsetof(settings, every), "T", NULL,
      "time between rows and points of these files [s]; without it a ten-thousandth of the run", 1e-12, 1e9, NULL, NULL },
    { .name = NULL }
};

static lw_status set_unit(const cli_call *call, cli_clearance *c, lw_error *e)
{
    static const char *const name[] = { "rpm", "rad/s", "m/s" };
    static const double size[] = { 2*LW_PI/60, 1, 1 };
    const settings *s = call->settings;
    const lw_assembly *k = &c->model->linkage;
    bool slides = k->n_input > 0 && lw_joint_slides(k->joint[k->input[0].joint].kind);
    int unit = slides && !cli_given(&call->parsed, "speed-unit") ? 2 : s->unit;
    if (s->speed && k->n_input == 0)
        return lw_error_at(e, LW_E_ARG, call->parsed.word[0], 0, 0,
                           "--speeds is for the input, and the model has none; add \"input\" to the file");
    if (s->speed && c->model->motion[0])
        return lw_error_at(e, LW_E_ARG, call->parsed.word[0], 0, 0,
                           "--speeds is for an input that runs freely, but its \"motion\" is prescribed; give it a \"speed\" instead");
    if (k->n_input > 0 && (unit == 2) != slides)
        return lw_error_set(e, LW_E_ARG, "--speed-unit %s does not go with an input that %s", name[unit], slides ? "slides" : "turns");
    c->unit = name[unit];
    c->o.unit = size[unit];
    return LW_OK;
}

static lw_status prepare(const cli_call *call, cli_clearance *c, lw_error *e)
{
    const settings *s = call->settings;
    lw_status st = set_unit(call, c, e);
    if (st != LW_OK)
        return st;
    lw_clearance_options *o = &c->o.run;
    *o = lw_clearance_options_default();
    o->time = s->end;
    o->settle = s->settle;
    o->tolerance = s->tolerance;
    o->start = (lw_clearance_start)s->start;
    o->every = s->every;
    c->o.refine = s->refine;
    c->o.passes = s->passes != NULL;
    c->o.jobs = call->common.jobs;
    o->stop = cli_stop_flag();
    if (call->common.time > 0)
        o->until = lw_clock_wall() + call->common.time;
    return cli_clearance_make(c, s->model, s->stiffness, s->damping, s->speed, e);
}

/* Exit code of the sweep; report what failed. */
static int judge(const cli_call *call, const cli_clearance *c)
{
    int n_failed = 0, n_missing = 0;
    const lw_sweep_row *first = NULL;
    for (int i = 0; i < c->sweep.n_row; i++) {
        bool failed = c->sweep.row[i].done && c->sweep.row[i].status != LW_OK;
        first = failed && !first ? &c->sweep.row[i] : first;
        n_failed += failed;
        n_missing += !c->sweep.row[i].done;
    }
    if (n_failed)
        fprintf(stderr, "linkwright %s: %d of %d runs failed, the first at %g %s: %s\n", call->command->name, n_failed,
                c->sweep.n_row, first->speed, c->unit, first->why);
    if (n_missing)
        cli_note(call, "%d of %d runs were not made", n_missing, c->sweep.n_row);
    return n_missing ? CLI_LIMIT : n_failed ? cli_exit_code(first->status) : CLI_DONE;
}

static int write_tables(const cli_call *call, const cli_clearance *c)
{
    const settings *s = call->settings;
    lw_output o;
    lw_error e = { 0 };
    int code = judge(call, c);
    if (cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    if (call->common.json)
        cli_clearance_json(c, o.f);
    else if (s->limits)
        cli_clearance_limits(c, o.f);
    else
        cli_clearance_csv(c, o.f);
    code = cli_close(call, &o, code);
    char partial[LW_PATH_SIZE + 16];
    const char *to;
    if ((s->plot && (to = cli_picture_path(call, s->plot, code, partial)) && cli_clearance_plot(c, to, &e) != LW_OK)
        || (s->passes && (to = cli_picture_path(call, s->passes, code, partial)) && cli_clearance_passes(c, to, &e) != LW_OK))
        return cli_fail(call, &e);
    return code;
}

static int work(const cli_call *call, cli_clearance *c)
{
    const settings *s = call->settings;
    lw_error e = { 0 };
    if (prepare(call, c, &e) != LW_OK)
        return cli_fail(call, &e);
    bool detail = s->path || s->force || s->history;
    if (detail && c->sweep.n_row > 1)
        return cli_usage(call, "--path, --force-plot and --history show one run, but the lists make %d; give one speed "
                         "and one law", c->sweep.n_row);
    if (cli_clearance_run(c, &e) != LW_OK)
        return cli_fail(call, &e);
    lw_status st = detail ? cli_clearance_detail(c, s->history, s->path, s->force, &e) : LW_OK;
    if (st != LW_OK && st != LW_STOPPED)
        return cli_fail(call, &e);
    return write_tables(call, c);
}

static int run(const cli_call *call)
{
    lw_error e = { 0 };
    lw_model *m = cli_read_model(call->parsed.word[0], 0, &e);
    if (!m)
        return cli_fail(call, &e);
    cli_clearance c = { .call = call, .model = m };
    int code = work(call, &c);
    cli_clearance_free(&c);
    cli_free_model(m);
    return code;
}

const cli_command cli_clearance_command = {
    .name = "clearance",
    .words = "MODEL.json",
    .title = "does a pin keep contact with its bush? speeds, stiffnesses and models of joint clearance",
    .examples =
        "  linkwright clearance examples/clearance-four-bar.json --speeds 80:120:2             kept or lost\n"
        "  linkwright clearance model.json --speeds 80:400:2 --stiffness 1e6,1e7,1e8 --limits  between which speeds\n"
        "  linkwright clearance model.json --speeds 80:400:2 --stiffness 1e6,1e7,1e8 --plot map.svg\n"
        "  linkwright clearance model.json --speeds 80:130:1 --to 8 --settle 4 --passes cloud.svg\n"
        "  linkwright clearance model.json --speeds 94 --path path.svg --force-plot force.svg       one run in full\n"
        "  linkwright clearance model.json --speeds 92,94 --model impact,mlsd,link,zero        by four models\n",
    .about =
        "Joints with a \"clearance\" in the file (pins only) get their gap, and the linkage moves from the posture\n"
        "and speed of the file. The input moves freely unless it has a \"motion\". A row of the table is one joint\n"
        "in one run: whether contact was kept after the time --settle; when it was lost first, how often, and for\n"
        "which part of the time; the greatest force and the greatest distance of the centres; the criterion of\n"
        "Earles and Wu for the model without gap (contact is kept below 1); and the range of the input's speed.\n"
        "Contact is lost when the distance of the centres falls to the gap; in the model with a massless link,\n"
        "when the force in the link changes its sign.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1,
    .run = run,
};
