/* linkwright simulate - motion of a model under its loads, and the forces in its joints. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "cli/motion/dynamics_report.h"
#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "cli/motion/simulate_linear.h"
#include "mbs/formulations/formulations.h"

typedef struct settings {
    int         analysis, formulation, steps, max_steps;
    double      from, to, tolerance, rho;
    bool        explain, balance, planar;
    const char *speed, *plot, *columns, *gif;
    cli_linear  linear;
} settings;

#define ANALYSIS_LINEAR (LW_ANALYSIS_DYNAMIC + 1)    /* follows the analyses of the library */

static const double ELASTIC_TOLERANCE = 1e-7;

#define CHOICE(id, name, text) "|" #name
#define HELP(id, name, text)   "  " #name " - " text "\n"
static const cli_option options[] = {
    { "analysis", 'a', CLI_CHOICE, offsetof(settings, analysis), "transient|static|quasistatic|kinematic|dynamic|linear", "transient",
      "transient: motion in time, kinematic if every degree of freedom is driven, else dynamic; linear: small vibrations", 0, 0, NULL, NULL },
    { "formulation", 0, CLI_CHOICE, offsetof(settings, formulation), "auto" LW_FORMULATION_LIST(CHOICE), "auto",
      "equations and method, listed above; auto takes the first that suits, see --explain", 0, 0, NULL, NULL },
    { "explain", 'e', CLI_FLAG, offsetof(settings, explain), NULL, NULL,
      "print which formulation is used, why, and its number of unknowns", 0, 0, NULL, NULL },
    { "from", 0, CLI_REAL, offsetof(settings, from), "T", "0", "start time [s]", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, offsetof(settings, to), "T", "1", "end time [s]", 0, 0, NULL, NULL },
    { "steps", 'n', CLI_INT, offsetof(settings, steps), "N", "100", "number of time intervals; there is one row more", 1, 10000000, NULL, NULL },
    { "speed", 's', CLI_TEXT, offsetof(settings, speed), "W", NULL,
      "drive the inputs without a motion at this constant speed [rad/s] or [m/s], or with a unit: \"60 rpm\"", 0, 0, NULL, NULL },
    { "tolerance", 0, CLI_REAL, offsetof(settings, tolerance), "E", "1e-10",
      "error allowed in a step: of angles, and of lengths divided by the size of the linkage; 1e-7 with elastic links", 1e-14, 0.1, NULL, NULL },
    { "rho", 0, CLI_REAL, offsetof(settings, rho), "R", "0.8",
      "with --formulation alpha: the part of infinitely fast vibrations that a step leaves; 1 damps none", 0, 1, NULL, NULL },
    { "max-steps", 0, CLI_INT, offsetof(settings, max_steps), "N", "100000000", "greatest number of steps of the integration", 1, 2e9, NULL, NULL },
    { "rigid", 0, CLI_FLAG, offsetof(settings, linear.rigid), NULL, NULL, "take elastic links as rigid bars of the same mass", 0, 0, NULL, NULL },
    { "planar", 0, CLI_FLAG, offsetof(settings, planar), NULL, NULL,
      "solve a model in space whose axes are all parallel as a planar one; reactions across the plane are left out", 0, 0, NULL, NULL },
    { "balance", 'b', CLI_FLAG, offsetof(settings, balance), NULL, NULL,
      "print counterweights that cancel the static shaking force, as JSON", 0, 0, NULL, NULL },
    { "plot", 'p', CLI_PLOT, offsetof(settings, plot), "FILE", NULL,
      "plot columns over time as SVG, PDF or PNG; with --plot or --gif rows are printed only with -o or --json", 0, 0, NULL, NULL },
    { "columns", 0, CLI_TEXT, offsetof(settings, columns), "NAME,...", NULL,
      "columns to plot: their names, or the part of the name before the point; without it the drives, or the energies "
      "if there is no drive", 0, 0, "plot", NULL },
    { "gif", 'g', CLI_GIF, offsetof(settings, gif), "FILE", NULL,
      "animation of the motion in true time, at most 50 frames in a second; motions shorter than half a second slower", 0, 0, NULL, NULL },
    { "rest", 0, CLI_FLAG, offsetof(settings, linear.rest), NULL, NULL,
      "with --analysis linear: vibrations about the static equilibrium near the posture of the file", 0, 0, NULL, NULL },
    { "hold", 0, CLI_FLAG, offsetof(settings, linear.hold), NULL, NULL,
      "with --analysis linear: keep the inputs fixed; inputs with a motion always are", 0, 0, NULL, NULL },
    { "along", 0, CLI_INT, offsetof(settings, linear.along), "N", NULL,
      "with --analysis linear: in N + 1 postures from the first to the last value of the input, or over one turn", 1, 1000000, NULL, NULL },
    { "modes", 0, CLI_INT, offsetof(settings, linear.modes), "N", "20",
      "with --analysis linear, for elastic links and more than 32 links: number of slowest modes", 1, 40, NULL, NULL },
    { "fft", 0, CLI_FLAG, offsetof(settings, linear.fft), NULL, NULL,
      "with --analysis linear: compare with the peaks in the spectrum of a small free vibration", 0, 0, NULL, NULL },
    { .name = NULL }
};

static lw_dynamics_options dynamics_options(const cli_call *call, bool elastic)
{
    const settings *s = call->settings;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = (lw_analysis)s->analysis;
    o.formulation = (lw_formulation)s->formulation;
    o.from = s->from;
    o.to = s->to;
    o.intervals = s->steps;
    o.rigid = s->linear.rigid;
    o.relative = o.absolute = elastic && !o.rigid && !cli_given(&call->parsed, "tolerance") ? ELASTIC_TOLERANCE : s->tolerance;
    o.rho = s->rho;
    o.max_step = s->max_steps;
    o.until = call->common.time > 0 ? lw_clock_wall() + call->common.time : 0;
    o.stop = cli_stop_flag();
    o.compare = true;
    return o;
}

static lw_status prepare(const cli_call *call, cli_simulate *c, lw_error *e)
{
    const settings *s = call->settings;
    lw_dynamics_options o = dynamics_options(call, c->model->n_elastic > 0);
    c->call = call;
    c->json = call->common.json;
    c->keep = s->balance || s->plot || s->gif;
    lw_status st = cli_simulate_speed(c->model, s->speed, call->parsed.word[0], e);
    if (st != LW_OK)
        return st;
    return cli_simulate_make(c, &o, call->parsed.word[0], e);
}

static lw_status run_it(const cli_call *call, cli_simulate *c, lw_error *e)
{
    const settings *s = call->settings;
    cli_simulate_head(c);
    lw_rest r;
    lw_status st = lw_dynamics_analyse(c->d, cli_simulate_row, c, &c->report, &r, e);
    if (s->analysis == LW_ANALYSIS_STATIC && c->report.samples > 0)
        cli_note(call, "at rest after %d iterations, force left %.3g J, %s", r.iterations, r.residual, lw_rest_text(&r));
    cli_simulate_tail(c, st, e);
    if (st == LW_OK && s->balance)
        st = cli_simulate_balance(c, stdout, e);
    return st;
}

/* Draw the rows of a run that ended with `code`. */
static int pictures(const cli_call *call, const cli_simulate *c, int code)
{
    const settings *s = call->settings;
    char partial[LW_PATH_SIZE + 16];
    const char *to;
    lw_error e = { 0 };
    lw_status st = LW_OK;
    if (s->plot && (to = cli_picture_path(call, s->plot, code, partial)))
        st = cli_table_plot(&(cli_table){ c->n_column, c->column, c->n_row, c->row }, c->model->linkage.name, s->columns, to, &e);
    if (st == LW_OK && s->gif && (to = cli_picture_path(call, s->gif, code, partial)))
        st = cli_simulate_gif(c, to, &e);
    return st == LW_OK ? code : cli_fail(call, &e);
}

static int linear(const cli_call *call, lw_model *m)
{
    cli_linear o = ((const settings *)call->settings)->linear;
    o.t = ((const settings *)call->settings)->from;
    int code = cli_simulate_linear(call, m, NULL, &o);
    cli_free_model(m);
    return code;
}

static int run_spatial(const cli_call *call, lw_spatial *m)
{
    static const char *const planar[] = { "balance", "along", NULL };
    const settings *s = call->settings;
    lw_dynamics_options o = dynamics_options(call, m->n_elastic > 0);
    int code = cli_spatial_refuse(call, planar);
    if (code != CLI_DONE)
        return code;
    if (s->analysis == ANALYSIS_LINEAR) {
        cli_linear l = s->linear;
        l.t = s->from;
        return cli_simulate_linear(call, NULL, m, &l);
    }
    cli_spatial_pictures p = { s->plot, s->columns, s->gif };
    return cli_spatial_simulate(call, m, &o, s->speed, s->explain, &p);
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    const cli_linear *l = &s->linear;
    bool linear_only = l->rest || l->hold || l->fft || l->along;
    if (s->analysis != ANALYSIS_LINEAR && linear_only)
        return cli_usage(call, "--rest, --hold, --along and --fft go with --analysis linear");
    if (s->analysis == ANALYSIS_LINEAR && (s->plot || s->gif))
        return cli_usage(call, "--plot and --gif show a motion in time or an equilibrium, not --analysis linear");
    static const char *const in_time[] = { "speed", "balance", "formulation" };
    for (int i = 0; s->analysis == ANALYSIS_LINEAR && i < 3; i++)
        if (cli_given(&call->parsed, in_time[i]))
            return cli_usage(call, "--%s does not go with --analysis linear", in_time[i]);
    lw_error e = { 0 };
    lw_output o;
    lw_model *m;
    lw_spatial *spatial;
    if (s->analysis != ANALYSIS_LINEAR && s->analysis != LW_ANALYSIS_STATIC && !(s->from < s->to))
        return cli_usage(call, "--from must be less than --to");
    if (cli_read_any_model(call->parsed.word[0], 0, &m, &spatial, &e) != LW_OK)
        return cli_fail(call, &e);
    if (spatial && s->planar) {
        lw_error why = { 0 };
        m = calloc(1, sizeof *m);
        lw_status in_plane = m ? lw_spatial_in_plane(spatial, m, &why) : lw_error_set(&why, LW_E_MEMORY, "out of memory");
        cli_free_spatial(spatial);
        if (in_plane != LW_OK) {
            free(m);
            lw_error_at(&e, in_plane, call->parsed.word[0], 0, 0, "%s", why.text);
            return cli_fail(call, &e);
        }
    } else if (spatial) {
        int code = run_spatial(call, spatial);
        cli_free_spatial(spatial);
        return code;
    }
    if (s->analysis == ANALYSIS_LINEAR)
        return linear(call, m);
    cli_simulate *c = calloc(1, sizeof *c);
    if (c)
        c->model = m;
    else
        cli_free_model(m);
    if (!c)
        lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (!c || prepare(call, c, &e) != LW_OK
        || cli_open(call, &o, &e) != LW_OK) {
        if (c)
            cli_simulate_free(c);
        free(c);
        return cli_fail(call, &e);
    }
    c->f = s->balance ? NULL : o.f;
    c->report = *lw_dynamics_choice(c->d);
    if (s->explain && s->analysis != LW_ANALYSIS_STATIC)
        cli_dynamics_explain(call, &c->report);
    if (s->explain)
        cli_explain_elastic(c->call, c->model, c->d, s->from, s->to);
    lw_status st = run_it(call, c, &e);
    if (s->explain && !c->report.gave_up && strcmp(c->report.why, lw_dynamics_choice(c->d)->why) != 0)
        cli_note(call, "in the run: %s", c->report.why);
    cli_dynamics_notes(call, c->d, &c->report);
    cli_suction_note(call, &c->suction);
    cli_note_pull(call, &c->pull, c->pull.chain ? lw_dynamics_model(c->d)->linkage.link_name[c->pull.chain->node[0]] : "");
    int code = st == LW_OK ? CLI_DONE : c->n_row > 0 && st == LW_STOPPED ? CLI_LIMIT : cli_fail(call, &e);
    if (code == CLI_LIMIT)
        cli_note(call, "%s; the rows so far are kept", e.text);
    code = cli_close(call, &o, code);
    if (c->n_row > 0)
        code = pictures(call, c, code);
    cli_simulate_free(c);
    free(c);
    return code;
}

const cli_command cli_simulate_command = {
    .name = "simulate",
    .words = "MODEL.json",
    .title = "forces and motion of a linkage with masses and loads: statics, dynamics, vibrations",
    .examples =
        "  linkwright simulate examples/andrews.json --to 0.03 --explain     dynamics, as CSV\n"
        "  linkwright simulate examples/pendulum.json --to 10 -n 1000 --json\n"
        "  linkwright simulate examples/space/delta.json --to 0.1            torques of a DELTA robot's motors\n"
        "  linkwright simulate model.json --speed \"60 rpm\" --plot torque.svg  drive its input, plot the torque\n"
        "  linkwright simulate model.json --analysis static                 static equilibrium\n"
        "  linkwright simulate model.json --speed 6.283185307179586 --balance\n"
        "  linkwright simulate model.json --analysis linear --rest --fft     eigenfrequencies, compared with a vibration\n",
    .about =
        "The model is a linkage with masses, gravity, springs, dampers, forces, motors, friction and stops\n"
        "(docs/notation.md, \"Model\"). Columns are the time t; for each input its value, its rate and its driving\n"
        "force or torque; the tracers; for each link the centre of mass and the angle, with velocities and\n"
        "accelerations; the joint reactions on the second link, about the joint, without the friction, springs,\n"
        "motors and drives there; the shaking force and moment on the frame; states, controllers and voltages;\n"
        "energies; the residuals of the constraints, divided by the size of the linkage. Standard error reports\n"
        "the errors of energy, momentum and constraints. A run that fails (exit code 4) or is stopped by a limit (exit\n"
        "code 5) keeps its rows and says where it ended. It fails, too, if its energy is off by far more than the\n"
        "tolerance explains, or if a second, coarser run of a model with contacts differs by more than tolerance^(1/5) of the\n"
        "size of the linkage and its motion (1 % at 1e-10, at most 10 %).\n"
        "\n"
        "With --analysis linear a row is one mode of small vibrations: frequency and natural frequency [Hz],\n"
        "damping ratio and eigenvalue [1/s]; --json adds the mode shapes. The model is linearised about the\n"
        "posture of the file at time --from, as if it were at rest there; 'unbalanced' tells how far this posture\n"
        "is from equilibrium.\n"
        "\n"
        "Spatial models (places with three numbers, docs/notation.md, \"Spatial model\") know all analyses;\n"
        "--explain says which formulation suits them. Their modes are those of an equilibrium.\n"
        "\n"
        "Formulations; auto takes the first that suits the model, see --explain:\n"
        LW_FORMULATION_LIST(HELP),
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1,
    .run = run,
};
