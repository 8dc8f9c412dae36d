/* linkwright bench - measure speed and error, as tables and plots. */
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/real.h"
#include "base/suggest.h"
#include "cli/bench/bench.h"
#include "cli/bench/bench_mbs.h"
#include "cli/program/mpi_jobs.h"
#include "cli/program/progress.h"

typedef struct settings {
    const char *output, *problems, *solvers;
    double      time, limit, budget;
    int         seeds;
    const char *links, *cases, *peers, *keep, *part;
    bool        both_ways, mpi;
    double      tolerance[2];
} settings;

static const cli_option options[] = {
    { "output", 'o', CLI_TEXT, offsetof(settings, output), "FOLDER", NULL,
      "write CSV files and a plot of each problem into this folder", 0, 0, NULL, NULL },
    { "problems", 0, CLI_TEXT, offsetof(settings, problems), "FOLDER", NULL,
      "fit: folder with targets as CSV files; without it the published problems that come with linkwright", 0, 0, NULL, NULL },
    { "solvers", 0, CLI_TEXT, offsetof(settings, solvers), "NAME,...", "all",
      "fit: solvers to compare: 'default' (the complete method of 'linkwright fit'), names from 'linkwright fit "
      "--solver help\', 'all' or 'none'", 0, 0, NULL, NULL },
    { "time", 0, CLI_REAL, offsetof(settings, time), "SECONDS", "0.3",
      "time limit; fit: of each solver on each problem; mbs: of the repetitions of a row", 1e-3, 1e6, NULL, NULL },
    { "seeds", 0, CLI_INT, offsetof(settings, seeds), "N", "20",
      "fit: number of complete fits of each problem, with the seeds --seed, --seed + 1, ...", 0, 10000, NULL, NULL },
    { "reach-time", 0, CLI_REAL, offsetof(settings, limit), "SECONDS", "5", "fit: time limit of each of these fits", 1e-3, 1e6, NULL, NULL },
    { "links", 'l', CLI_TEXT, offsetof(settings, links), "P,...", NULL,
      "fit: instead, search all mechanisms with up to 6 or up to 6,8 links and print error against number of links", 0, 0, NULL, NULL },
    { "budget", 0, CLI_REAL, offsetof(settings, budget), "N", "3e5",
      "fit: with --links, number of evaluations for each number of links", 1e3, 1e12, NULL, NULL },
    { "both-ways", 0, CLI_FLAG, offsetof(settings, both_ways), NULL, NULL,
      "fit: with --links, compare paths without input angles in both directions, target to curve and curve to target", 0, 0, NULL, NULL },
    { "keep", 0, CLI_INPUT, offsetof(settings, keep), "FILE", NULL,
      "fit: keep every run in FILE, and leave out those that FILE holds already", 0, 0, NULL, NULL },
    { "part", 0, CLI_TEXT, offsetof(settings, part), "R/M", NULL,
      "fit: with --keep, do part R of M (R = 1 .. M) of the runs; join the files with cat for the tables", 0, 0, "keep", NULL },
    { "mpi", 0, CLI_FLAG, offsetof(settings, mpi), NULL, NULL,
      "fit: share the runs among all processes that mpirun started; process 0 prints", 0, 0, NULL, "part" },
    { "cases", 0, CLI_TEXT, offsetof(settings, cases), "NAME,...", NULL,
      "mbs: pendulum, two-four-bars, row-of-15, row-of-40, row-of-400, andrews, space-slider-crank, space-bricard, "
      "space-governor, space-chain, space-arm, space-stewart, space-delta, flexible-crank, clearance, clearance-250, choice (is auto "
      "the fastest formulation, over 69 models; choice:TEXT takes those with TEXT in their name, choice:hard the hard cases, drawn in "
      "mbs-choice.svg); without it all but choice",
      0, 0, NULL, NULL },
    { "tolerance-range", 0, CLI_RANGE, offsetof(settings, tolerance), "MIN:MAX", "1e-13:1e-4",
      "mbs: tolerances to use, a row for each power of ten", 1e-13, 1e-1, NULL, NULL },
    { "peers", 0, CLI_TEXT, offsetof(settings, peers), "FOLDER", NULL,
      "mbs: compare with the programs in this folder ('make peers' builds those of Simbody and MuJoCo), or \'none\'; "
      "without it 'peers' beside linkwright, if there is such a folder", 0, 0, NULL, NULL },
    { .name = NULL }
};

enum { SOLVER_MAX = 64 };

/* Solvers whose curves are recorded; NULL is the default strategy. */
typedef struct chosen { int n; const lw_solver *solver[SOLVER_MAX]; } chosen;

static void choose_all(chosen *c)
{
    c->solver[c->n++] = NULL;
    for (const lw_solver *s = lw_solver_table; s->name && c->n < SOLVER_MAX; s++)
        c->solver[c->n++] = s;
}

static lw_status choose_one(const char *word, chosen *c, lw_error *e)
{
    const char *names[SOLVER_MAX + 1] = { "default" };
    int n = 1;
    const lw_solver *s = lw_solver_find(word);
    for (const lw_solver *row = lw_solver_table; row->name && n < SOLVER_MAX; row++)
        names[n++] = row->name;
    const char *near = lw_suggest(word, names, n);
    if (!s && strcmp(word, "default") != 0)
        return lw_error_set(e, LW_E_ARG, "there is no solver '%s'%s%s%s", word, near ? "; did you mean '" : "",
                            near ? near : "; 'linkwright fit --solver help' lists them", near ? "'?" : "");
    for (int i = 0; i < c->n; i++)
        if (c->solver[i] == s)
            return lw_error_set(e, LW_E_ARG, "--solvers names '%s' twice", word);
    c->solver[c->n++] = s;
    return LW_OK;
}

static lw_status choose(const char *list, chosen *c, lw_error *e)
{
    lw_status st = LW_OK;
    c->n = 0;
    if (strcmp(list, "none") == 0)
        return LW_OK;
    if (strcmp(list, "all") == 0) {
        choose_all(c);
        return LW_OK;
    }
    while (*list && st == LW_OK && c->n < SOLVER_MAX) {
        char word[32];
        size_t n = strcspn(list, ",");
        snprintf(word, sizeof word, "%.*s", (int)(n < sizeof word ? n : sizeof word - 1), list);
        st = choose_one(word, c, e);
        list += n + (list[n] == ',');
    }
    return st;
}

/* ---- runs ------------------------------------------------------------------------------------------ */

/* The tasks of a benchmark: first the complete fits, problem after problem and seed after seed, then each solver on each
 * problem; or with --links a search of each problem. */
typedef struct runs {
    const cli_call *call;
    cli_bench      *b;
    const chosen   *c;
    cli_bench_links *links;              /* NULL: not with --links                                      */
    cli_kept       *kept;
    size_t          n_task;
    int             part, n_part;
    cli_progress    line;
    lw_error       *e;
} runs;

static lw_status reach_once(const cli_bench *b, const cli_bench_problem *p, uint64_t seed, cli_bench_reach *r, lw_error *e)
{
    cli_bench_curve c = { .problem = p, .solver = "default", .seed = seed };
    double enough = CLI_WITHIN*p->known->reachable;
    lw_status st = cli_bench_run(NULL, b->limit, b->jobs, enough, &c, e);
    const cli_bench_point *last = c.n ? &c.point[c.n - 1] : NULL;
    *r = (cli_bench_reach){ .seed = seed, .error = c.verified, .seconds = last ? last->seconds : NAN,
                            .evals = last ? last->evals : 0 };
    r->reached = r->error <= enough && r->seconds <= b->limit;
    free(c.point);
    return st;
}

static size_t reaches(const runs *r) { return (size_t)r->b->n_problem*(size_t)r->b->n_seed; }

/* Problem of a task. */
static int problem_of(const runs *r, size_t k)
{
    return r->links ? (int)k : (int)(k < reaches(r) ? k/(size_t)r->b->n_seed : (k - reaches(r))/(size_t)r->c->n);
}

static lw_status run_task(void *context, size_t k, lw_bytes *answer)
{
    runs *r = context;
    int i = problem_of(r, k);
    lw_status st;
    if (r->links)
        return cli_bench_links_one(&r->b->problem[i], r->links, answer, r->e);
    if (k < reaches(r)) {
        cli_bench_reach *done = &r->b->reach[k];
        st = reach_once(r->b, &r->b->problem[i], r->call->common.seed + k%(size_t)r->b->n_seed, done, r->e);
        lw_bytes_add(answer, done, sizeof *done);
    } else {
        const lw_solver *s = r->c->solver[(k - reaches(r))%(size_t)r->c->n];
        cli_bench_curve curve = { .problem = &r->b->problem[i], .solver = s ? s->name : "default",
                                  .seed = r->call->common.seed };
        st = cli_bench_run(s, r->b->seconds, 1, 0, &curve, r->e);
        lw_bytes_add(answer, &curve.verified, sizeof curve.verified);
        lw_bytes_add(answer, curve.point, curve.n*sizeof *curve.point);
        free(curve.point);
    }
    return st == LW_OK && cli_interrupted() ? LW_STOPPED : st;
}

static lw_status use_task(runs *r, size_t k, const char *answer, size_t size)
{
    int i = problem_of(r, k);
    if (r->links)
        return cli_bench_links_take(r->links, i, answer, size, r->e);
    if (k < reaches(r)) {
        if (size != sizeof *r->b->reach)
            return lw_error_set(r->e, LW_E_NOTATION, "the kept runs are of another benchmark");
        memcpy(&r->b->reach[k], answer, size);
        r->b->reach_done[i] = (int)(k%(size_t)r->b->n_seed) + 1;
        return LW_OK;
    }
    const lw_solver *s = r->c->solver[(k - reaches(r))%(size_t)r->c->n];
    cli_bench_curve *curve = &r->b->curve[r->b->n_curve++];
    *curve = (cli_bench_curve){ .problem = &r->b->problem[i], .solver = s ? s->name : "default", .seed = r->call->common.seed };
    if (size < sizeof curve->verified || (size - sizeof curve->verified)%sizeof *curve->point != 0)
        return lw_error_set(r->e, LW_E_NOTATION, "the kept runs are of another benchmark");
    memcpy(&curve->verified, answer, sizeof curve->verified);
    curve->n = curve->size = (size - sizeof curve->verified)/sizeof *curve->point;
    curve->point = malloc((curve->n + 1)*sizeof *curve->point);
    if (!curve->point)
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    memcpy(curve->point, answer + sizeof curve->verified, curve->n*sizeof *curve->point);
    return LW_OK;
}

/* Kept answers are used at the end, others at once; both in the order of the tasks. */
static lw_status take_task(void *context, size_t k, const char *answer, size_t size)
{
    runs *r = context;
    cli_progress_show(&r->line, (double)k + 1, (double)r->n_task, r->b->problem[problem_of(r, k)].name);
    return r->kept ? cli_kept_add(r->kept, k, answer, size, r->e) : use_task(r, k, answer, size);
}

static bool task_left_out(void *context, size_t k)
{
    runs *r = context;
    size_t size;
    bool unknown = !r->links && k < reaches(r) && !(r->b->problem[problem_of(r, k)].known->reachable > 0);
    return unknown || k%(size_t)r->n_part != (size_t)r->part || cli_kept_get(r->kept, k, &size);
}

/* *whole: all runs are there. */
static lw_status use_kept(runs *r, bool *whole)
{
    size_t n_mine = 0, n_left = 0, size;
    runs all = *r;
    all.part = 0;
    all.n_part = 1;
    for (size_t k = 0; k < r->n_task; k++) {
        n_left += !task_left_out(&all, k);
        n_mine += !task_left_out(r, k);
    }
    *whole = n_left == 0;
    if (n_left > 0)
        cli_note(r->call, n_mine > 0 ? "%zu of %zu runs are missing in the file; the same command does them"
                 : "this part is done; of all, %zu of %zu runs are missing. Join the files of the parts with cat", n_left, r->n_task);
    lw_status st = LW_OK;
    for (size_t k = 0; k < r->n_task && *whole && st == LW_OK; k++) {
        const char *answer = cli_kept_get(r->kept, k, &size);
        if (answer)
            st = use_task(r, k, answer, size);
    }
    return st;
}

/* Do all tasks. *served: the other processes under mpirun have been served. */
static lw_status run_all(runs *r, bool mpi, bool *served, bool *whole)
{
    cli_mpi_work w = { r->n_task, run_task, take_task, r, task_left_out, 0 };
    *whole = true;
    r->line = cli_progress_begin(r->call, "bench", "runs");
    *served = true;
    lw_status st = mpi ? cli_mpi_run(&w) : cli_tasks_run(&w);
    cli_progress_end(&r->line);
    if (st == LW_OK || st == LW_STOPPED) {
        lw_status sum = r->kept ? use_kept(r, whole) : LW_OK;
        st = sum < 0 ? sum : LW_OK;
    } else if (r->e->status == LW_OK)
        lw_error_set(r->e, st, "%s", lw_status_text(st));
    return st;
}

static lw_status make_memory(cli_bench *b, const chosen *c, lw_error *e)
{
    size_t n = (size_t)b->n_problem;
    b->reach_done = calloc(n, sizeof *b->reach_done);
    b->reach = calloc(n*(size_t)b->n_seed + 1, sizeof *b->reach);
    b->curve = calloc(n*(size_t)c->n + 1, sizeof *b->curve);
    return b->reach_done && b->reach && b->curve ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

static void free_all(cli_bench *b)
{
    for (int i = 0; i < b->n_curve; i++)
        free(b->curve[i].point);
    free(b->curve);
    free(b->reach);
    free(b->reach_done);
    cli_bench_free(b->problem, b->n_problem);
}

static int finish(const cli_call *call, const cli_bench *b)
{
    const settings *s = call->settings;
    lw_error e = { 0 };
    if (s->output && cli_bench_save(b, call->line, s->output, &e) != LW_OK)
        return cli_fail(call, &e);
    cli_bench_tables(b, stdout);
    return CLI_DONE;
}

/* Make the folder of -o, and check for each file that it may be written there. */
static int check_folder(const cli_call *call, const char *csv, const char *prefix, const cli_bench *b)
{
    const char *folder = ((const settings *)call->settings)->output;
    int code = folder ? cli_make_folder(call, folder) : CLI_DONE;
    if (folder && code == CLI_DONE)
        code = cli_may_write_in(call, folder, "%s", csv);
    for (int i = 0; folder && b && i < b->n_problem && code == CLI_DONE; i++)
        code = cli_may_write_in(call, folder, "%s%s.svg", prefix, b->problem[i].name);
    for (int i = 0; folder && !b && cli_mbs_problems[i].name && code == CLI_DONE; i++)
        code = cli_may_write_in(call, folder, "%s%s.svg", prefix, cli_mbs_problems[i].name);
    return code;
}

/* The last number of a list such as "6,8"; 0 if the text is no such list. */
static int most_links(const char *list)
{
    int most = 0;
    for (const char *at = list; *at;) {
        char *end;
        long links = strtol(at, &end, 10);
        if (end == at || (*end && *end != ',') || links < 4 || links > 10 || links % 2)
            return 0;
        most = links > most ? (int)links : most;
        at = end + (*end == ',');
    }
    return most;
}

#define NO_JSON "--json has no meaning here; -o FOLDER writes CSV"

static int run_mbs(const cli_call *call)
{
    const settings *s = call->settings;
    if (call->common.json)
        return cli_usage(call, NO_JSON);
    lw_error e = { 0 };
    cli_mbs b = { .call = call, .time = s->time,
                  .loosest = (int)lrint(-log10(s->tolerance[1])), .tightest = (int)lrint(-log10(s->tolerance[0])) };
    int code = check_folder(call, "mbs.csv", "mbs-", NULL);
    if (code != CLI_DONE)
        return code;
    cli_bench_machine(b.machine, sizeof b.machine);
    lw_status st = cli_mbs_find_peers(&b, s->peers, &e);
    if (st == LW_OK)
        st = cli_mbs_run(&b, s->cases, s->output, &e);
    cli_mbs_free(&b);
    if (st == LW_E_ARG)
        return cli_usage(call, "%s", e.text);
    return st < 0 ? cli_fail(call, &e) : CLI_DONE;
}

/* Load the problems, do the runs, and print; process 0, or one of the others under mpirun. */
static int run_fit_as(const cli_call *call, runs *r, int rank, bool *served)
{
    const settings *s = call->settings;
    cli_bench *b = r->b;
    bool whole = false;
    lw_status st = cli_bench_load(s->problems, &b->problem, &b->n_problem, r->e);
    int code = st != LW_OK ? cli_fail(call, r->e) : rank > 0 ? CLI_DONE
             : r->links ? check_folder(call, "links.csv", "links-", b) : check_folder(call, "curves.csv", "", b);
    if (code == CLI_DONE && !r->links && s->output && rank == 0)
        code = cli_may_write_in(call, s->output, "reach.csv");
    if (code != CLI_DONE)
        return code;
    r->n_task = r->links ? (size_t)b->n_problem : reaches(r) + (size_t)b->n_problem*(size_t)r->c->n;
    st = r->links ? cli_bench_links_begin(b, r->links, r->e) : make_memory(b, r->c, r->e);
    if (st == LW_OK && rank == 0 && s->keep) {
        const char **file = calloc((size_t)b->n_problem + 1, sizeof *file);
        for (int i = 0; file && i < b->n_problem; i++)
            file[i] = b->problem[i].path;
        uint64_t kept_run = 0;
        st = !file ? lw_error_set(r->e, LW_E_MEMORY, "out of memory") : cli_kept_run(call->line, b->n_problem, file, &kept_run, r->e);
        if (st == LW_OK)
            st = cli_kept_open(s->keep, kept_run, &r->kept, r->e);
        free(file);
    }
    if (st == LW_OK)
        st = run_all(r, s->mpi, served, &whole);
    if (rank > 0 || (st >= 0 && !whole))
        return CLI_DONE;
    if (st < 0)
        return cli_fail(call, r->e);
    return r->links ? (cli_bench_links_end(b, r->links, r->e) == LW_OK ? CLI_DONE : cli_fail(call, r->e)) : finish(call, b);
}

static int run_fit(const cli_call *call)
{
    const settings *s = call->settings;
    cli_bench b = { .n_seed = s->seeds, .seconds = s->time, .limit = s->limit,
                    .jobs = s->mpi ? 1 : call->common.jobs > 0 ? call->common.jobs : lw_core_count() };
    cli_bench_links links = { .links = s->links ? most_links(s->links) : 0, .jobs = b.jobs, .budget = (long)s->budget,
                              .seed = call->common.seed, .folder = s->output, .both_ways = s->both_ways };
    chosen c;
    lw_error e = { 0 };
    runs r = { .call = call, .b = &b, .c = &c, .links = s->links ? &links : NULL, .n_part = 1, .e = &e };
    bool served = false;
    if (call->common.json)
        return cli_usage(call, NO_JSON);
    if (choose(s->solvers, &c, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (s->links && links.links == 0)
        return cli_usage(call, "--links takes even numbers from 4 to 10, as 6 or 6,8, not '%s'", s->links);
    int code = s->part ? cli_read_part(call, s->part, &r.part, &r.n_part) : CLI_DONE;
    if (code == CLI_DONE && s->mpi)
        code = cli_mpi_check(call);
    if (code != CLI_DONE)
        return code;
    cli_bench_machine(b.machine, sizeof b.machine);
    code = run_fit_as(call, &r, s->mpi ? cli_mpi_begin() : 0, &served);
    cli_kept_close(r.kept);
    cli_bench_links_free(&links);
    free_all(&b);
    if (s->mpi)
        cli_mpi_end(served);
    return code;
}

static const cli_action actions[] = {
    { "fit", "",
      "Prints two tables in Markdown. The first tells how often, and after how much time, a complete fit comes\n"
      "within 1 % of the smallest error known, over many seeds and with all threads. The second tells what each\n"
      "solver reaches on one core within --time. Local solvers start from the starting points of 'linkwright\n"
      "fit', global solvers search the whole box of bounds. With -o, curves.csv holds every improvement,\n"
      "reach.csv every fit. Errors and numbers of evaluations depend on the seed only; times depend on the\n"
      "machine. --keep FILE survives interruptions; several machines each do --part R/M, or share the runs\n"
      "under mpirun with --mpi (docs/cluster.md).\n", 0, 0, run_fit, 0, NULL },
    { "mbs", "",
      "Solves reference problems of multibody dynamics with every formulation and every tolerance. A row gives\n"
      "the error against an exact solution, or against a solution with more digits, and the shortest processor\n"
      "time of several runs. A solver that needs more than a second, or fails twice, is not run with smaller\n"
      "tolerances. Other programs (--peers) get the same models and are measured in the same way. With -o, the\n"
      "rows go to mbs.csv.\n", 0, 0, run_mbs, 0, NULL },
    { .name = NULL }
};

const cli_command cli_bench_command = {
    .name = "bench",
    .words = "fit|mbs",
    .title = "measure speed and error of the fits and simulations of this machine",
    .examples =
        "  linkwright bench fit                                      published problems, all solvers\n"
        "  linkwright bench fit -o out                               with CSV and a plot of each problem\n"
        "  linkwright bench fit --solvers lm,slsqp --time 2 --seeds 0\n"
        "  linkwright bench fit --problems my-targets --solvers default,lm,crs\n"
        "  linkwright bench fit --links 6,8                          error against number of links\n"
        "  linkwright bench fit --links 8 --problems examples/letters -o out\n"
        "  linkwright bench fit --seeds 1000 --keep 3.kept --part 3/20   one of twenty jobs of a cluster\n"
        "  linkwright bench mbs -o out                               problems of dynamics, all solvers\n"
        "  linkwright bench mbs --cases andrews\n"
        "  linkwright bench mbs --cases andrews --peers none         without other programs\n",
    .about =
        "Measures the search for linkages (fit) and the simulation (mbs).\n",
    .options = options,
    .settings_size = sizeof(settings),
    .actions = actions,
};
