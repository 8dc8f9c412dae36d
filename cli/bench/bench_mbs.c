/* cli/bench/bench_mbs.c - run every formulation of the multibody solver on every reference problem, at every tolerance.
 */
#include "cli/bench/bench_mbs.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "base/vec2.h"
#include "cli/bench/flexible_crank.h"
#include "cli/program/progress.h"
#include "mbs/clearance/clearance.h"
#include "mbs/elastic/contact.h"
#include "mbs/formulations/formulations.h"

enum { REPEAT_MAX = 50 };
static const double give_up = 5;             /* [s] of wall time                                            */

/* ---- files --------------------------------------------------------------------------------------------------- */

static lw_status read_line(char *line, cli_mbs_reference *r, int *capacity)
{
    int n = 0;
    for (char *field; (field = strsep(&line, ",")); n++) {
        if (r->n_row*r->n_column + n >= *capacity) {
            double *more = realloc(r->value, sizeof *more*2*(size_t)*capacity);
            if (!more)
                return LW_E_MEMORY;
            r->value = more;
            *capacity *= 2;
        }
        if (lw_number_parse(field, strlen(field), &r->value[r->n_row*r->n_column + n]) != LW_OK)
            return LW_E_NOTATION;
    }
    if (r->n_row > 0 && n != r->n_column)
        return LW_E_NOTATION;
    r->n_column = n;
    r->n_row++;
    return LW_OK;
}

static lw_status read_reference(const char *name, cli_mbs_reference *r, lw_error *e)
{
    char path[CLI_PATH_SIZE], *text = NULL, *line;
    size_t size;
    int capacity = 64, number = 0;
    lw_status st = cli_mbs_read(name, "csv", path, &text, &size, e);
    *r = (cli_mbs_reference){ .value = st == LW_OK ? malloc(sizeof(double)*(size_t)capacity) : NULL };
    if (st == LW_OK && !r->value)
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (char *rest = text; st == LW_OK && (line = strsep(&rest, "\n"));) {
        number++;
        if (*line == '#' || *line == 't' || !*line)
            continue;
        st = read_line(line, r, &capacity);
        if (st != LW_OK)
            lw_error_at(e, st, path, number, 0, "no row of numbers, or another number of columns than before");
    }
    free(text);
    return st;
}

static lw_status read_model(const char *name, lw_model *m, lw_error *e)
{
    char path[CLI_PATH_SIZE], *text = NULL;
    size_t size;
    lw_status st = cli_mbs_read(name, "json", path, &text, &size, e);
    if (st == LW_OK)
        st = lw_model_read(text, size, path, m, e);
    free(text);
    return st;
}

/* A row of n four-bars: n + 1 upright cranks on the ground, their ends joined by rods; all links 1 m and 1 kg. */
static lw_status make_row(int n, lw_model *m, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    fputs("{\"linkwright\": 1, \"gravity\": [0, -9.81], \"input\": {\"joint\": \"A0\", \"speed\": -1},\n\"links\": "
          "[\"ground\"", f);
    for (int i = 0; i <= n; i++)
        fprintf(f, ",\n{\"name\": \"c%d\", \"mass\": 1, \"centre\": [%d, 0.5], \"inertia\": 0.083333333333333329}", i,
                i);
    for (int i = 0; i < n; i++)
        fprintf(f, ",\n{\"name\": \"r%d\", \"mass\": 1, \"centre\": [%.1f, 1], \"inertia\": 0.083333333333333329}", i,
                i + 0.5);
    fputs("],\n\"joints\": [{\"name\": \"A0\", \"links\": [\"ground\", \"c0\"], \"at\": [0, 0]}", f);
    for (int i = 1; i <= n; i++)
        fprintf(f, ",\n{\"name\": \"A%d\", \"links\": [\"ground\", \"c%d\"], \"at\": [%d, 0]},\n"
                "{\"name\": \"B%d\", \"links\": [\"c%d\", \"r%d\"], \"at\": [%d, 1]},\n"
                "{\"name\": \"C%d\", \"links\": [\"r%d\", \"c%d\"], \"at\": [%d, 1]}",
                i, i, i, i, i - 1, i - 1, i - 1, i, i - 1, i, i);
    fputs("]}\n", f);
    bool bad = ferror(f) != 0;
    bad = fclose(f) != 0 || bad;
    lw_status st = bad ? lw_error_set(e, LW_E_MEMORY, "out of memory") : lw_model_read(text, size, "row of four-bars",
                                                                                       m, e);
    free(text);
    return st;
}

/* ---- rows ---------------------------------------------------------------------------------------------------- */

typedef struct keeper { cli_mbs_motion motion; const lw_system *system; } keeper;

static lw_status keep(void *context, const lw_moment *m)
{
    keeper *k = context;
    if (!k->system)
        return LW_OK;
    double *to = k->motion.place + 3*(k->motion.n_moment++*k->motion.n_body);
    for (int b = 0; b < k->system->n_body; b++, to += 3) {
        lw_vec2 at = lw_system_point(k->system, b, lw_v2(0, 0), m->q);
        to[0] = at.x, to[1] = at.y, to[2] = m->q[3*b + 2];
    }
    return LW_OK;
}

/* Set up and run once; the row keeps the shorter times. */
static lw_status run_once(const lw_model *m, const lw_dynamics_options *o, keeper *k, bool timed, cli_mbs_row *row,
                          lw_dynamics_report *report, lw_error *e)
{
    lw_dynamics *d;
    double start = lw_clock_cpu();
    lw_status st = lw_dynamics_make(m, o, &d, e);
    double made = lw_clock_cpu();
    if (st != LW_OK)
        return st;
    k->system = timed ? NULL : lw_dynamics_system(d);
    st = lw_dynamics_run(d, keep, k, report, e);
    st = st == LW_OK ? cli_mbs_own(report, o, e) : st;
    if (timed) {
        row->make = fmin(row->make, made - start);           /* fmin ignores NAN                             */
        row->seconds = fmin(row->seconds, lw_clock_cpu() - made);
    }
    lw_dynamics_free(d);
    return st;
}

static void fail(cli_mbs_row *row, const lw_error *e)
{
    row->error = row->off = row->energy = NAN;
    snprintf(row->note, sizeof row->note, "%.150s", e->text);
    row->note[strcspn(row->note, "\n")] = 0;
}

static lw_status one_row(cli_mbs *b, const cli_mbs_problem *p, const lw_model *m, const cli_mbs_reference *r,
                         lw_formulation f, double tolerance, cli_mbs_row **out)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    cli_mbs_row *row = *out = cli_mbs_add(b, p->name, lw_formulation_name(f), tolerance);
    keeper k = { .motion = { .n_body = m->linkage.n_link - 1 } };
    lw_dynamics_report report;
    lw_error e = { 0 };
    k.motion.place = malloc(sizeof(double)*3*(size_t)(r->n_row*k.motion.n_body));
    if (!row || !k.motion.place) {
        free(k.motion.place);
        return LW_E_MEMORY;
    }
    o.formulation = f;
    o.to = p->to;
    o.intervals = r->n_row - 1;
    o.relative = o.absolute = tolerance;
    o.max_step = 100000;
    o.stop = cli_stop_flag();
    o.until = lw_clock_wall() + give_up;
    lw_status st = run_once(m, &o, &k, false, row, &report, &e);
    if (st == LW_OK) {
        row->error = p->measure(&k.motion, r, &row->off);
        row->energy = report.energy_error/report.energy_scale;
        row->steps = report.steps;
        row->rates = report.rates;
    }
    o.intervals = 1;
    double until = lw_clock_wall() + b->time;
    o.until = 0;
    for (int i = 0; i < REPEAT_MAX && st == LW_OK && (i == 0 || lw_clock_wall() < until) && !cli_interrupted(); i++)
        st = run_once(m, &o, &k, true, row, &report, &e);
    if (st != LW_OK)
        fail(row, &e);
    free(k.motion.place);
    return LW_OK;
}

static lw_status run_model(cli_mbs *b, const cli_mbs_problem *p, lw_error *e)
{
    static const lw_formulation every[] = { LW_FORMULATION_QUADRATURE, LW_FORMULATION_REDUCED,
                                            LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL };
    lw_model *m = malloc(sizeof *m);
    cli_mbs_reference r;
    cli_mbs_row *row;
    int implicit = b->tightest < p->implicit ? b->tightest : p->implicit;
    lw_status st = !m ? lw_error_set(e, LW_E_MEMORY, "out of memory")
                 : p->n_loop > 0 ? make_row(p->n_loop, m, e) : read_model(p->file, m, e);
    if (st != LW_OK) {
        free(m);
        return st;
    }
    st = read_reference(p->file, &r, e);
    for (int f = 0; f < 5 && st == LW_OK; f++)
        for (int k = b->loosest, failed = 0;
             k <= (f < 3 ? b->tightest : implicit) && failed < 2 && st == LW_OK && !cli_interrupted(); k++) {
            st = one_row(b, p, m, &r, every[f], pow(10, -k), &row);
            failed = st == LW_OK && row->note[0] ? failed + 1 : 0;
            if (st == LW_OK && row->seconds > CLI_MBS_TOO_SLOW)
                break;
        }
    if (st == LW_OK)
        st = cli_mbs_peers(b, p, m, &r, e);
    free(r.value);
    lw_model_free(m);
    free(m);
    return st;
}

/* ---- the other two ------------------------------------------------------------------------------------------- */

/* Reference: order 8 at 1e-14, which agrees with the published end values in all digits that the published start gives.
 */
static lw_status run_flexible(cli_mbs *b, const cli_mbs_problem *p, lw_error *e)
{
    lw_flexible_crank c;
    lw_flexible_run exact, r;
    lw_flexible_crank_published(&c);
    lw_status st = lw_flexible_crank_run(&c, LW_FLEXIBLE_EXPLICIT, 1e-14, p->to, &exact, e);
    for (int m = 0; m < LW_FLEXIBLE_METHODS && st == LW_OK; m++)
        for (int k = b->loosest; k <= b->tightest && !cli_interrupted(); k++) {
            lw_error why = { 0 };
            cli_mbs_row *row = cli_mbs_add(b, p->name, lw_flexible_method_name((lw_flexible_method)m), pow(10, -k));
            lw_status ran = LW_OK;
            if (!row)
                return lw_error_set(e, LW_E_MEMORY, "out of memory");
            double until = lw_clock_wall() + b->time;
            for (int i = 0; i < REPEAT_MAX && ran == LW_OK && (i == 0 || lw_clock_wall() < until); i++) {
                double start = lw_clock_cpu();
                ran = lw_flexible_crank_run(&c, (lw_flexible_method)m, row->tolerance, p->to, &r, &why);
                row->seconds = fmin(row->seconds, lw_clock_cpu() - start);
            }
            row->error = 0;
            for (int i = 3; i < LW_FLEXIBLE_N; i++)
                row->error = fmax(row->error, fabs(r.p[i] - exact.p[i]));
            row->steps = r.steps;
            row->rates = r.rates;
            if (ran != LW_OK)
                fail(row, &why);
            if (row->seconds > 0.3*CLI_MBS_TOO_SLOW)
                break;
        }
    return st;
}

static lw_status keep_pin(void *context, const lw_clearance_sample *s)
{
    *(lw_vec2 *)context = s->point[0].pin;
    return LW_OK;
}

static lw_status clearance_row(cli_mbs *b, const cli_mbs_problem *p, const lw_clearance_scene *scene,
                               const char *solver, double tolerance, const lw_vec2 *exact)
{
    lw_clearance_options o = lw_clearance_options_default();
    lw_clearance_result r = { 0 };
    lw_vec2 pin;
    lw_error e = { 0 };
    cli_mbs_row *row = cli_mbs_add(b, p->name, solver, tolerance);
    lw_status st = row ? LW_OK : LW_E_MEMORY;
    if (st != LW_OK)
        return st;
    o.tolerance = tolerance;
    o.speed = (exact ? 80 : 250)*2*LW_PI/60;
    o.start = exact ? LW_CLEARANCE_SEATED : o.start;
    if (exact) {
        o.every = o.time, o.sink = keep_pin, o.context = &pin;
    }
    double until = lw_clock_wall() + b->time;
    for (int i = 0; i < REPEAT_MAX && st == LW_OK && (i == 0 || lw_clock_wall() < until) && !cli_interrupted(); i++) {
        double start = lw_clock_cpu();
        st = lw_clearance_run(scene, &o, &r, &e);
        row->seconds = fmin(row->seconds, lw_clock_cpu() - start);
    }
    row->error = exact ? lw_v2_norm(lw_v2_sub(pin, *exact)) : NAN;
    row->steps = r.steps;
    row->rates = r.rates;
    if (st != LW_OK)
        fail(row, &e);
    return LW_OK;
}

/* Rows of one contact law. Reference: the same law at 1e-13, where the motion is regular. */
static lw_status clearance_rows(cli_mbs *b, const cli_mbs_problem *p, const lw_model *m, const char *solver,
                                lw_error *e)
{
    lw_clearance_scene *scene;
    lw_clearance_result r;
    lw_clearance_options o = lw_clearance_options_default();
    lw_vec2 exact = { 0, 0 };
    bool regular = strcmp(p->name, "clearance") == 0;
    lw_status st = lw_clearance_make(m, &scene, e);
    if (st != LW_OK)
        return st;
    o.tolerance = 1e-13, o.speed = 80*2*LW_PI/60, o.start = LW_CLEARANCE_SEATED;
    o.every = o.time, o.sink = keep_pin, o.context = &exact;
    if (regular)
        st = lw_clearance_run(scene, &o, &r, e);
    for (int k = b->loosest < 6 ? 6 : b->loosest; k <= b->tightest && k < 13 && st == LW_OK && !cli_interrupted(); k++)
        st = clearance_row(b, p, scene, solver, pow(10, -k), regular ? &exact : NULL);
    lw_clearance_free(scene);
    return st;
}

static lw_status run_clearance(cli_mbs *b, const cli_mbs_problem *p, lw_error *e)
{
    static const struct { lw_clearance_model law; double stiffness; } law[] = {
        { LW_CLEARANCE_IMPACT, 1e8 }, { LW_CLEARANCE_IMPACT, 1e6 }, { LW_CLEARANCE_MLSD, 1e8 },
        { LW_CLEARANCE_LINK, 1e8 } };
    lw_model *m = malloc(sizeof *m);
    lw_status st = m ? read_model("clearance-four-bar", m, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    bool read = st == LW_OK;
    for (int i = 0; i < 4 && st == LW_OK; i++) {
        char solver[40];
        for (int j = 0; j < m->linkage.n_joint; j++)
            if (m->clearance[j].model != LW_CLEARANCE_NONE) {
                m->clearance[j].model = law[i].law;
                m->clearance[j].stiffness = law[i].stiffness;
            }
        snprintf(solver, sizeof solver, law[i].law == LW_CLEARANCE_LINK ? "%s" : "%s K=%.0e",
                 lw_clearance_name(law[i].law),
                 law[i].stiffness);
        st = clearance_rows(b, p, m, solver, e);
    }
    if (read)
        lw_model_free(m);
    free(m);
    return st;
}

/* ---- all -------------------------------------------------------------------------------------------------------- */

static lw_status choose(const char *list, uint64_t *wanted, lw_error *e)
{
    const char *names[64];
    int n = 0;
    for (; cli_mbs_problems[n].name; n++)
        names[n] = cli_mbs_problems[n].name;
    *wanted = list ? 0 : (1ull << (n - 1)) - 1;          /* all but the last, choice, which takes minutes */
    for (; list && *list; list += strcspn(list, ","), list += *list == ',') {
        char word[64];
        int i = 0;
        snprintf(word, sizeof word, "%.*s", (int)strcspn(list, ","), list);
        size_t length = strncmp(word, "choice:", 7) == 0 ? 6 : strlen(word);
        while (i < n && !(strlen(names[i]) == length && strncmp(names[i], word, length) == 0))
            i++;
        const char *near = lw_suggest(word, names, n);
        if (i == n)
            return lw_error_set(e, LW_E_ARG, "there is no problem '%s'; %s%s%s", word,
                                near ? "did you mean '" : "there are pendulum, two-four-bars, row-of-15, row-of-40, "
                                "row-of-400, andrews, space-slider-crank, space-bricard, space-governor, space-chain, "
                                "space-arm, space-stewart, space-delta, flexible-crank, clearance, clearance-250, choice",
                                near ? near : "",
                                near ? "'?" : "");
        *wanted |= 1ull << i;
    }
    return LW_OK;
}

lw_status cli_mbs_run(cli_mbs *b, const char *cases, const char *folder, lw_error *e)
{
#ifdef __GLIBC__                             /* memory stays with the process: pages are not cleared anew for every repetition */
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
#endif
    lw_status st = choose(cases, &b->wanted, e);
    cli_progress line = cli_progress_begin(b->call, "bench", "problems");
    for (int i = 0; cli_mbs_problems[i].name && st == LW_OK && !cli_interrupted(); i++) {
        const cli_mbs_problem *p = &cli_mbs_problems[i];
        if (!(b->wanted >> i & 1))
            continue;
        cli_progress_show(&line, i, 6, p->name);
        st = strcmp(p->name, "choice") == 0 ? cli_mbs_choice(b, cases, folder, e) : p->file ? run_model(b, p, e)
           : strncmp(p->name, "space-", 6) == 0 ? cli_mbs_space(b, p, e)
           : strcmp(p->name, "flexible-crank") == 0 ? run_flexible(b, p, e) : run_clearance(b, p, e);
    }
    cli_progress_end(&line);
    if (st == LW_OK && folder)
        st = cli_mbs_save(b, folder, e);
    if (st == LW_OK)
        cli_mbs_tables(b, stdout);
    return st;
}

void cli_mbs_free(cli_mbs *b)
{
    free(b->row);
    *b = (cli_mbs){ 0 };
}
