/* linkwright plasma - from a link adjacency matrix and a target to dimensions, in the steps of PLASMA. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/rng.h"
#include "catalogues/exchange/export.h"
#include "cli/fit/plasma.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "grammar/linkage/sketch.h"
#include "mbs/batch/posture.h"
#include "optimise/report/report.h"
#include "optimise/search/start.h"

typedef struct settings {
    const char *target, *save, *length_unit;
    int         ground, input, tracer, points, first;
    double      budget;
    bool        crank_only;
} settings;

static const cli_option options[] = {
    { "target", 't', CLI_INPUT, offsetof(settings, target), "FILE", NULL,
      "the path that the point shall follow: CSV, SVG or DXF, as for 'linkwright fit'; required", 0, 0, NULL, NULL },
    { "ground", 0, CLI_INT, offsetof(settings, ground), "PART", "1", "number of the fixed part", 1, LW_LINK_MAX, NULL, NULL },
    { "input-joint", 0, CLI_INT, offsetof(settings, input), "JOINT", NULL,
      "number of the driven joint, a pin or a slider; without it the first joint at the ground from which all parts "
      "can be computed", 1, LW_JOINT_MAX, NULL, NULL },
    { "tracer-link", 0, CLI_INT, offsetof(settings, tracer), "PART", NULL,
      "number of the part that carries the point; without it the first part that is not joined to the ground and whose "
      "position depends on all parts", 1, LW_LINK_MAX, NULL, NULL },
    { "first", 0, CLI_INT, offsetof(settings, first), "N", "200",
      "the first dimensions are the best of N random ones that can be assembled", 1, 1e6, NULL, NULL },
    { "points", 0, CLI_INT, offsetof(settings, points), "N", "50", "number of rows in the tables of motion", 2, 10000, NULL, NULL },
    { "budget", 0, CLI_REAL, offsetof(settings, budget), "N", "3e5", "number of evaluations of the objective", 1e3, 1e12, NULL, NULL },
    { "crank-only", 0, CLI_FLAG, offsetof(settings, crank_only), NULL, NULL, "the input turns fully", 0, 0, NULL, NULL },
    { "length-unit", 0, CLI_TEXT, offsetof(settings, length_unit), "UNIT", NULL,
      "unit of the lengths in the target; without it as the file says, else m", 0, 0, NULL, NULL },
    { "save", 0, CLI_TEXT, offsetof(settings, save), "FOLDER", NULL,
      "write first.adm, first.acf, final.adm, final.acf, first.json and final.json into this folder", 0, 0, NULL, NULL },
    { .name = NULL }
};

typedef struct job {
    const cli_call *call;
    const settings *s;
    lw_lam          lam;
    lw_mechanism    m;
    uint8_t         number[LW_JOINT_MAX];      /* number of joint j in the matrix                    */
    lw_linkage      sketch, first;
    lw_family       family;
    lw_fit_spec     spec;
    lw_target       target;
    lw_output       out;
} job;

/* ---- which input, which tracer --------------------------------------------------------------------------- */

static bool at_ground(const lw_mechanism *m, int j) { return m->link[j][0] == m->ground || m->link[j][1] == m->ground; }

/* Number of links that move the point with this input and tracer; 0: it cannot be computed. */
static int try_choice(job *b, int input, int tracer, lw_linkage *linkage)
{
    lw_rng rng;
    lw_mechanism m = b->m;
    lw_plan *plan = malloc(sizeof *plan);
    int links = 0;
    m.n_input = 1;
    m.input[0] = (uint8_t)input;
    m.output = tracer;
    lw_rng_seed(&rng, b->call->common.seed, 7);
    lw_status st = plan ? lw_linkage_sketch(&m, &rng, linkage) : LW_E_MEMORY;
    if (st == LW_OK)
        st = lw_plan_make(linkage, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_HIGHER }, plan, NULL);
    if (st == LW_OK)
        links = plan->n_link;
    if (st == LW_E_MEMORY)
        cli_lost();
    free(plan);
    return links;
}

static int joint_of_number(const job *b, int number)
{
    for (int j = 0; j < b->m.n_joint; j++)
        if (b->number[j] == number)
            return j;
    return -1;
}

/* Sort the joints by their numbers in the matrix and name them so. */
static void order_joints(const job *b, const lw_linkage *from, lw_linkage *linkage)
{
    *linkage = *from;
    for (int j = 0; j < from->n_joint; j++) {
        lw_joint *p = &linkage->joint[b->number[j] - 1];
        *p = from->joint[j];
        snprintf(p->name, sizeof p->name, "J%d", b->number[j]);
    }
    linkage->input[0].joint = b->number[from->input[0].joint] - 1;
}

static lw_status check_choice(const job *b, lw_error *e)
{
    const settings *s = b->s;
    if (s->ground > b->lam.n_link || s->tracer > b->lam.n_link)
        return lw_error_set(e, LW_E_ARG, "there is no part %d; the matrix has %d", s->ground > b->lam.n_link ? s->ground
                            : s->tracer, b->lam.n_link);
    if (s->input > b->lam.n_joint)
        return lw_error_set(e, LW_E_ARG, "there is no joint %d; the matrix has %d", s->input, b->lam.n_joint);
    if (s->input && !lw_joint_can_drive(b->lam.kind[s->input - 1]))
        return lw_error_set(e, LW_E_ARG, "joint %d is no pin or slider and cannot be driven", s->input);
    if (s->tracer == s->ground)
        return lw_error_set(e, LW_E_ARG, "the point is on part %d, which is the ground", s->ground);
    return LW_OK;
}

/* Try inputs at the ground first and tracers away from it first. Take the first choice in which all links move the
 * point, else the one with the most. */
static lw_status choose(job *b, lw_error *e)
{
    int best = 0;
    lw_status st = check_choice(b, e);
    if (st != LW_OK)
        return st;
    b->m.ground = b->s->ground - 1;
    for (int pass = 0; pass < 2 && best < b->m.n_link; pass++)
        for (int n = 1; n <= b->lam.n_joint; n++)
            for (int t = 0; t < b->m.n_link; t++) {
                int j = joint_of_number(b, n);
                bool near = lw_mechanism_joint(&b->m, b->m.ground, t) != LW_NONE;
                bool may = b->s->input ? n == b->s->input : lw_joint_can_drive(b->m.kind[j]) && at_ground(&b->m, j);
                lw_linkage k;
                if (!may || t == b->m.ground || (b->s->tracer ? t != b->s->tracer - 1 : near != (pass == 1)))
                    continue;
                int links = try_choice(b, j, t, &k);
                if (links > best) {
                    best = links;
                    order_joints(b, &k, &b->sketch);
                }
            }
    return best > 0 ? LW_OK
         : lw_error_set(e, LW_E_KIND, "no input and tracer part were found with which this mechanism can be worked "
                        "out; it needs one freedom and pins, sliders, pins in slots");
}

static lw_status read_matrix(job *b, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    const char *path = b->call->parsed.n_word > 0 ? b->call->parsed.word[0] : "-";
    lw_status st = cli_read_file(path, "a link adjacency matrix", &text, &size, e);
    if (st == LW_OK)
        st = lw_lam_read(text, size, path, &b->lam, e);
    free(text);
    if (st != LW_OK)
        return st;
    lw_lam_mechanism(&b->lam, &b->m, b->number);
    int freedom = 3*(b->m.n_link - 1);
    for (int j = 0; j < b->m.n_joint; j++)
        freedom -= lw_joint_equations(b->m.kind[j]);
    return freedom == 1 ? LW_OK
         : lw_error_at(e, LW_E_KIND, path, 0, 0, "this mechanism has %d degrees of freedom; it must have one", freedom);
}

/* ---- first dimensions --------------------------------------------------------------------------------------- */

static void make_spec(job *b)
{
    double m = b->target.units.metre;
    b->spec = lw_fit_spec_default();
    b->spec.task = lw_task_suggested(&b->target);
    b->spec.timing = b->target.angle ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
    b->spec.a = 1/(m*m);
    b->spec.crank_only = b->s->crank_only;
}

/* Write the posture of variables x into the linkage, at an input at which it closes.  LW_OPEN: there is none; LW_E_MEMORY. */
static lw_status put_posture(job *b, const lw_problem *p, const double *x, lw_linkage *linkage)
{
    double dim[LW_VAR_MAX], mode[LW_MODE_MAX];
    lw_plan *plan = malloc(sizeof *plan);
    const lw_plan_options whole = { .tracers = 1, .all_joints = true, .kind = LW_PLAN_HIGHER };
    lw_status made = plan ? lw_plan_make(&b->sketch, whole, plan, NULL) : LW_E_MEMORY, st = LW_OPEN;
    double scale = made == LW_OK && plan->input_is_slider ? p->unit : 1;
    double mid = p->intended.turns ? 0 : p->intended.mid*scale;
    memcpy(mode, p->intended.mode, sizeof mode);
    lw_problem_to_dims(p, x, dim);
    for (int i = 0; made == LW_OK && st != LW_OK && st != LW_E_MEMORY && i < 73; i++) {
        double input = mid + (p->intended.turns ? 2*LW_PI : 2*p->intended.half*scale)*(i % 2 ? 1 : -1)*(i/2)/72.0;
        *linkage = b->sketch;
        st = lw_plan_write(plan, dim, mode, input, linkage);
    }
    free(plan);
    linkage->units = b->target.units;
    if (st == LW_OK)
        linkage->input[0].value = lw_linkage_posture_input(linkage, linkage->input[0].joint);
    return made == LW_E_MEMORY ? made : st;
}

static lw_status first_dimensions(job *b, double *objective, lw_error *e)
{
    lw_problem *p = calloc(1, sizeof *p);
    lw_rng rng;
    double best = INFINITY, x[LW_VAR_MAX];
    lw_linkage k;
    if (!p)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a problem");
    lw_status st = lw_problem_make(&b->target, &b->spec, &b->family, 1, 1, p, e);
    if (st != LW_OK) {
        free(p);
        return st;
    }
    void *work = aligned_alloc(64, (lw_problem_work_size(p) + 127) & ~(size_t)63);
    if (work)
        lw_problem_work_init(p, work);
    else
        st = LW_E_MEMORY;
    lw_rng_seed(&rng, b->call->common.seed, 8);
    for (int trial = 0; st != LW_E_MEMORY && trial < b->s->first && !cli_interrupted(); trial++) {
        double u[LW_START_DRAWS];
        for (int i = 0; i < LW_START_DRAWS; i++)
            u[i] = lw_rng_uniform(&rng);
        double f = lw_start(p, u, x, work);
        if (f < best && (st = put_posture(b, p, x, &k)) == LW_OK) {
            best = f;
            b->first = k;
        }
    }
    *objective = best*p->scale;
    free(work);
    lw_problem_free(p);
    free(p);
    return st == LW_E_MEMORY ? lw_error_set(e, st, "out of memory") : best < INFINITY ? LW_OK
         : lw_error_set(e, LW_NOTHING, "no first dimensions were found that close at all points of the target; try "
                        "more with --first, or another input or ground");
}

/* ---- results --------------------------------------------------------------------------------------------------- */

static lw_status print_dataset(const lw_linkage *linkage, FILE *f, lw_error *e)
{
    lw_bytes b = { 0 };
    lw_status st = lw_export_adams(LW_VIEW(linkage), NULL, &b, e);
    if (st == LW_OK)
        fprintf(f, "MSA-program Data Set File:\n\n%s\n", b.data);
    lw_bytes_free(&b);
    return st;
}

static lw_status save_bytes(const job *b, const char *name, const char *end, const lw_bytes *bytes, lw_error *e)
{
    char path[CLI_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s%s", b->s->save, name, end);
    return lw_file_write(path, bytes->data, bytes->size, e);
}

static lw_status save(const job *b, const lw_linkage *linkage, const char *name, lw_error *e)
{
    lw_linkage named = *linkage;
    lw_bytes bytes[2] = { { 0 }, { 0 } };
    if (!b->s->save)
        return LW_OK;
    snprintf(named.name, sizeof named.name, "%s", name);
    lw_status st = lw_export_adams(LW_VIEW(&named), NULL, &bytes[0], e);
    if (st == LW_OK)
        st = lw_export_adams_commands(LW_VIEW(&named), NULL, &bytes[1], e);
    if (st == LW_OK)
        st = save_bytes(b, name, ".adm", &bytes[0], e);
    if (st == LW_OK)
        st = save_bytes(b, name, ".acf", &bytes[1], e);
    lw_bytes_free(&bytes[0]);
    lw_bytes_free(&bytes[1]);
    char *text = st == LW_OK ? lw_linkage_write(&named, 2) : NULL;
    if (st == LW_OK)
        st = text ? save_bytes(b, name, ".json", &(lw_bytes){ .data = text, .size = strlen(text) }, e)
           : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    free(text);
    return st;
}

/* A line of --json. */
static lw_status print_json(const job *b, const lw_linkage *linkage, const char *name, lw_error *e)
{
    lw_linkage named = *linkage;
    snprintf(named.name, sizeof named.name, "%s", name);
    char *text = lw_linkage_write(&named, 0);
    if (!text)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    fprintf(b->out.f, "%s\n", text);
    free(text);
    return LW_OK;
}

static lw_status print_motion(const job *b, const lw_linkage *linkage, lw_error *e)
{
    fputs("Coupler path:\n\n", b->out.f);
    lw_status st = cli_plasma_path(linkage, b->s->points, b->out.f, e);
    return st == LW_OPEN ? LW_OK : st;
}

static lw_status print_first(const job *b, double objective, lw_error *e)
{
    FILE *f = b->out.f;
    fputs("Preprocessor has constructed Joint Data Structure:\n\n", f);
    cli_plasma_joints(&b->first, f);
    fprintf(f, "First dimensions, objective %.6g:\n\n", objective);
    lw_status st = cli_plasma_dimensions(&b->first, f, e);
    if (st == LW_OK)
        st = print_dataset(&b->first, f, e);
    return st == LW_OK ? print_motion(b, &b->first, e) : st;
}

static lw_status run_first(job *b, lw_error *e)
{
    double objective = 0;
    lw_status st = first_dimensions(b, &objective, e);
    if (st == LW_OK)
        st = b->call->common.json ? print_json(b, &b->first, "first", e) : print_first(b, objective, e);
    return st == LW_OK ? save(b, &b->first, "first", e) : st;
}

/* The best candidate that a second simulation confirms. */
static const lw_candidate *best_of(const job *b, const lw_fit *fit, lw_fit_report *r, lw_error *e, lw_status *st)
{
    *st = LW_OK;
    for (int i = 0; i < fit->n && *st == LW_OK; i++) {
        *st = lw_fit_report_make(&b->target, &b->spec, &fit->candidate[i], r, e);
        if (*st == LW_OK && r->verified)
            return &fit->candidate[i];
    }
    if (*st == LW_OK)
        *st = lw_error_set(e, LW_NOTHING, "no dimensions were found with which this mechanism runs through the target");
    return NULL;
}

static lw_status print_final(const job *b, const lw_fit *fit, const lw_candidate *c, const lw_fit_report *r, lw_error *e)
{
    FILE *f = b->out.f;
    fprintf(f, "Optimisation: %ld starts, %ld local fits, %ld evaluations; objective %.6g, average path deviation "
            "%.4g %% of the path length\n\n", fit->starts, fit->improved, fit->evals, c->objective,
            r->error_percent);
    fputs("Final dimensions:\n\n", f);
    lw_status st = cli_plasma_dimensions(&r->linkage, f, e);
    cli_plasma_joints(&r->linkage, f);
    return st == LW_OK ? print_motion(b, &r->linkage, e) : st;
}

static lw_status give_final(const job *b, const lw_fit *fit, lw_error *e)
{
    lw_status st;
    lw_fit_report *r = calloc(1, sizeof *r);
    if (!r)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a report");
    const lw_candidate *c = best_of(b, fit, r, e, &st);
    if (c) {
        r->linkage.units = b->target.units;
        st = b->call->common.json ? print_json(b, &r->linkage, "final", e) : print_final(b, fit, c, r, e);
        if (st == LW_OK)
            st = save(b, &r->linkage, "final", e);
    }
    free(r);
    return st;
}

static lw_status run_final(job *b, lw_error *e)
{
    lw_fit fit;
    lw_fit_options o = lw_fit_options_default();
    o.spec = b->spec;
    lw_families one = lw_families_of(&b->family, 1);
    o.families = &one;
    o.budget = (long)b->s->budget;
    o.seed = b->call->common.seed;
    o.jobs = b->call->common.jobs;
    o.max_seconds = b->call->common.time;
    o.n_result = 5;
    o.interrupt = cli_stop_flag();
    lw_status st = lw_fit_run(&b->target, &o, &fit, e), why;
    if (st == LW_NOTHING)
        lw_error_set(e, st, "no dimensions were found with which this mechanism runs through the target");
    if (st < 0 || st == LW_NOTHING)
        return st;
    why = give_final(b, &fit, e);
    lw_fit_free(&fit);
    return why == LW_OK ? st : why;
}

static lw_status run_all(job *b, lw_error *e)
{
    lw_target_options o = { .closed = -1, .length_unit = b->s->length_unit };
    lw_status st = cli_read_target(b->s->target, &o, &b->target, e);
    if (st != LW_OK)
        return st;
    if (b->target.n_also > 0)
        return lw_error_at(e, LW_E_ARG, b->s->target, 0, 0, "the target must be one path; 'linkwright fit' takes several points");
    if (!b->target.x)
        return lw_error_at(e, LW_E_ARG, b->s->target, 0, 0, "the target must be a path, with columns x and y");
    make_spec(b);
    b->family = (lw_family){ .name = "mechanism", .linkage = &b->sketch, .links = b->m.n_link };
    if (!b->call->common.json)
        cli_plasma_matrix(&b->lam, b->out.f);
    st = run_first(b, e);
    return st == LW_OK ? run_final(b, e) : st;
}

/* Before the search starts, check that all files can be written. */
static int check_folder(const cli_call *call, const char *folder)
{
    static const char *const name[] = { "first", "final" }, *const end[] = { "adm", "acf", "json" };
    int code = folder ? cli_make_folder(call, folder) : CLI_DONE;
    for (int i = 0; folder && i < 6 && code == CLI_DONE; i++)
        code = cli_may_write_in(call, folder, "%s.%s", name[i/3], end[i%3]);
    return code;
}

static int run(const cli_call *call)
{
    lw_error e = { 0 };
    int code = check_folder(call, ((const settings *)call->settings)->save);
    if (code != CLI_DONE)
        return code;
    job *b = calloc(1, sizeof *b);
    if (b)
        *b = (job){ .call = call, .s = call->settings };
    if (b && !b->s->target) {
        free(b);
        return cli_usage(call, "--target is missing: the path that the point shall follow");
    }
    lw_status st = b ? read_matrix(b, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        st = choose(b, &e);
    if (st == LW_OK)
        st = cli_open(call, &b->out, &e);
    if (st != LW_OK) {
        free(b);
        return cli_fail(call, &e);
    }
    st = run_all(b, &e);
    lw_target_free(&b->target);
    if (st == LW_OK || st == LW_STOPPED) {
        code = cli_close(call, &b->out, st == LW_OK ? CLI_DONE : CLI_LIMIT);
    } else {
        lw_output_abandon(&b->out);
        code = cli_fail(call, &e);
    }
    free(b);
    return code;
}

const cli_command cli_plasma_command = {
    .name = "plasma",
    .words = "[LAM.txt]",
    .title = "find the dimensions of one given mechanism, in the steps of the program PLASMA",
    .examples =
        "  linkwright chains --links 4 --format lam | linkwright plasma --target examples/ellipse.csv\n"
        "  linkwright plasma lam.txt --target examples/walking-foot.csv --crank-only --save out\n",
    .about =
        "The mechanism is a link adjacency matrix, from LAM.txt or standard input: row and column are parts, an\n"
        "entry is the number of the joint between them or 0, and a letter behind the number gives its kind, as\n"
        "4t. As PLASMA did (Makkonen 1999), the command prints\n"
        "    the joints of first dimensions that can be assembled, and the data set for the analysis program ADAMS\n"
        "    the coupler curve with velocity and acceleration over one second, and the accelerations of the joints\n"
        "    the final dimensions after optimisation, with their coupler curve\n"
        "A marker has the number 100 part + count. Joint types are 11 pin, 12 slider, 13 pin in a slot; F is the\n"
        "direction of a slide [rad]. Lengths are in the unit of the target. The same seed gives the same answer.\n"
        "--json prints two linkages instead, one a line: \"first\" and \"final\".\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 0,
    .most_words = 1,
    .run = run,
};
