/* linkwright structures - list every Franke structure with L loops, built by adding ears. */
#include <string.h>
#include <unistd.h>
#include "base/clock.h"
#include "cli/program/json.h"
#include "cli/program/mpi_jobs.h"
#include "cli/program/output.h"
#include "cli/program/progress.h"
#include "enumerate/canon.h"
#include "enumerate/estimate.h"
#include "enumerate/filter.h"
#include "enumerate/structures.h"
#include "grammar/topology/derivation.h"

typedef struct settings {
    int         loops;
    bool        count, derive, planar, non_planar;
    const char *replay, *structures, *part;
} settings;

static const cli_option options[] = {
    { "loops", 0, CLI_INT, offsetof(settings, loops), "L", NULL, "number of independent loops", 2, LW_LOOP_MAX, NULL, NULL },
    { "count", 'c', CLI_FLAG, offsetof(settings, count), NULL, NULL,
      "print only the number of structures, for each number of circles (links with three or more joints)", 0, 0, NULL, NULL },
    { "derive", 0, CLI_FLAG, offsetof(settings, derive), NULL, NULL, "print how each structure grows from the first one", 0, 0, NULL, "count" },
    { "planar", 0, CLI_FLAG, offsetof(settings, planar), NULL, NULL, "only structures with a planar graph", 0, 0, NULL, "non-planar" },
    { "non-planar", 0, CLI_FLAG, offsetof(settings, non_planar), NULL, NULL, "only structures with a non-planar graph", 0, 0, NULL, NULL },
    { "structures", 0, CLI_STORE, offsetof(settings, structures), "FILE", NULL,
      "read the structures from FILE; if there is no such file, write it", 0, 0, NULL, "replay" },
    { "part", 0, CLI_TEXT, offsetof(settings, part), "R/M", NULL,
      "count part R of M (R = 1 .. M) without storing structures, only those with fewer loops; the parts add up to all", 0, 0, "count", "planar" },
    { "replay", 0, CLI_TEXT, offsetof(settings, replay), "DERIVATION", NULL,
      "print the structure that this derivation makes, step by step", 0, 0, NULL, "loops" },
    { .name = NULL }
};

static void write_structure(const cli_call *call, FILE *f, const lw_structure *s, const lw_derivation *d)
{
    char structure[LW_STRUCTURE_SIZE], derivation[LW_DERIVATION_SIZE];
    (void)lw_structure_print(s, structure, sizeof structure);
    if (d)
        (void)lw_derivation_print(d, derivation, sizeof derivation);
    if (!call->common.json) {
        fprintf(f, d ? "%s | %s\n" : "%s\n", structure, derivation);
        return;
    }
    cli_json j = cli_json_begin(f, 0);
    cli_json_object(&j, NULL);
    cli_json_int(&j, "loops", lw_structure_loops(s));
    cli_json_int(&j, "circles", s->n_circle);
    cli_json_array(&j, "lines");
    for (int e = 0; e < s->n_line; e++) {
        cli_json_array(&j, NULL);
        cli_json_int(&j, NULL, s->end[e][0] + 1);
        cli_json_int(&j, NULL, s->end[e][1] + 1);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    if (d)
        cli_json_text(&j, "derivation", derivation);
    cli_json_end(&j);
}

static void write_counts(const cli_call *call, FILE *f, int loops, const lw_structures_tally *by_circles, bool weights)
{
    uint64_t total = 0;
    cli_json j = cli_json_begin(f, 0);
    if (call->common.json) {
        cli_json_object(&j, NULL);
        cli_json_int(&j, "loops", loops);
        cli_json_array(&j, "by_circles");
    } else {
        fprintf(f, "# circles  structures%s\n", weights ? "  sum of 1/|automorphisms|" : "");
    }
    for (int v = 2; v <= 2*(loops - 1); v++) {
        total += by_circles[v].n;
        if (call->common.json)
            cli_json_int(&j, NULL, (long long)by_circles[v].n);
        else
            fprintf(f, weights ? "%9d%12llu%26.12Lf\n" : "%9d%12llu\n", v, (unsigned long long)by_circles[v].n, by_circles[v].weight);
    }
    if (call->common.json) {
        cli_json_end(&j);
        cli_json_int(&j, "structures", (long long)total);
        cli_json_end(&j);
    } else {
        fprintf(f, "%9s%12llu\n", "all", (unsigned long long)total);
    }
}

static int walk(const cli_call *call, FILE *f, const lw_structures *set)
{
    const settings *s = call->settings;
    const lw_filter *filter = lw_filter_find(s->planar ? "planar" : s->non_planar ? "non-planar" : "");
    lw_structures_tally by_circles[LW_CIRCLE_MAX + 1] = { 0 };
    size_t n = 0;
    for (size_t k = 0; k < lw_structures_count(set, s->loops) && !cli_interrupted(); k++) {
        lw_structure structure;
        lw_derivation d;
        lw_structures_get(set, s->loops, k, &structure);
        bool keep = true;
        lw_error e = { .text = "" };
        if (lw_graph_error(&e, filter ? filter->structure(&structure, &keep) : LW_OK) != LW_OK)
            return cli_fail(call, &e);
        if (!keep)
            continue;
        n++;
        by_circles[structure.n_circle].n++;
        lw_structures_derive(set, s->loops, k, &d);
        if (!s->count)
            write_structure(call, f, &structure, s->derive ? &d : NULL);
    }
    if (s->count)
        write_counts(call, f, s->loops, by_circles, false);
    return n > 0 || s->count ? CLI_DONE : CLI_NOTHING;
}

static int replay(const cli_call *call)
{
    const settings *s = call->settings;
    lw_derivation d;
    lw_output o;
    lw_error e = { 0 };
    if (lw_derivation_read(s->replay, strlen(s->replay), "--replay", &d, &e) != LW_OK || cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    for (int n = 0, n_ear = d.n_ear; n <= n_ear; n++) {
        lw_structure structure;
        d.n_ear = n;
        if (lw_derivation_replay(&d, &structure) == LW_OK)
            write_structure(call, o.f, &structure, &d);
    }
    return cli_close(call, &o, CLI_DONE);
}

typedef struct watch { const cli_call *call; cli_progress progress; double start; } watch;

static bool tick(void *context, int loops, size_t found)
{
    watch *w = context;
    double limit = w->call->common.time;
    (void)loops;
    cli_progress_show(&w->progress, (double)found, 0, NULL);
    return !cli_interrupted() && (limit <= 0 || lw_clock_wall() - w->start < limit);
}

static bool not_stopped(void *nothing)
{
    (void)nothing;
    return !cli_interrupted();
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    lw_structures *set;
    lw_output o;
    lw_error e = { 0 };
    int part = 0, n_part = 1;
    if (s->replay)
        return replay(call);
    if (!s->loops)
        return cli_usage(call, "how many loops? give --loops L");
    if (s->part && s->loops < 3)
        return cli_usage(call, "--part needs --loops 3 or more");
    int code = s->part ? cli_read_part(call, s->part, &part, &n_part) : CLI_DONE;
    if (code != CLI_DONE)
        return code;
    int stored = s->part ? s->loops - 1 : s->loops;
    if (stored > 8 && !(s->structures && access(s->structures, R_OK) == 0))
        cli_note(call, "9 loops take minutes, each further loop 20 to 40 times as long");
    lw_estimate size;
    lw_status guessed = stored > 8 ? lw_chains_estimate_while(2*stored + 2, 1, not_stopped, NULL, &size, &e) : LW_OK;
    if (guessed == LW_STOPPED)
        lw_error_set(&e, guessed, "stopped before the number of structures was known");
    if (guessed == LW_STOPPED || guessed == LW_E_MEMORY)
        return cli_fail(call, &e);
    if (stored > 8 && guessed == LW_OK && size.bytes > cli_memory(call)) {
        lw_error_set(&e, LW_E_MEMORY, "the structures with %d loops need about %.2g GB", s->loops, size.bytes/1e9);
        return cli_fail(call, &e);
    }
    watch w = { call, cli_progress_begin(call, "structures", "structures"), lw_clock_wall() };
    lw_structures_tally by_circles[LW_CIRCLE_MAX + 1];
    lw_status status = lw_structures_stored(s->structures, stored, call->common.jobs, tick, &w, &set, &e);
    if (status == LW_OK && s->part) {
        if (lw_structures_loops(set) == stored)
            status = lw_structures_count_next(set, part, n_part, call->common.jobs, tick, &w, by_circles);
        else
            status = lw_error_set(&e, LW_E_ARG, "%s holds more than %d loops, which --part grows from", s->structures, stored);
        if (status != LW_OK) {
            lw_structures_free(set);
            lw_graph_error(&e, status);
        }
    }
    cli_progress_end(&w.progress);
    if (status != LW_OK)
        return cli_interrupted() && !cli_timed_out() ? CLI_DONE : cli_fail(call, &e);
    if (cli_open(call, &o, &e) != LW_OK)
        code = cli_fail(call, &e);
    else if (s->part) {
        write_counts(call, o.f, s->loops, by_circles, true);
        code = cli_close(call, &o, CLI_DONE);
    }
    else
        code = cli_close(call, &o, walk(call, o.f, set));
    lw_structures_free(set);
    return code;
}

const cli_command cli_structures_command = {
    .name = "structures",
    .words = "--loops L",
    .title = "list all Franke structures with L loops, with a derivation of each",
    .examples =
        "  linkwright structures --loops 3                  the four structures of eight-link chains\n"
        "  linkwright structures --loops 6 --count          1198, for each number of circles\n"
        "  linkwright structures --loops 4 --derive         how each structure grows\n"
        "  linkwright structures --loops 9 --count --structures 9.bin   grow them once, for many later runs\n"
        "  linkwright structures --loops 10 --count --part 3/40 --structures 9.bin   a part of a count, without memory for all\n"
        "  linkwright structures --replay 'theta 3(1,2)'    follow a derivation\n",
    .about =
        "A structure shows the links with three or more joints as circles, and each string of binary links\n"
        "between them as a line. It is printed as the numbers of lines at each circle, and the lines: (3 3) 1-2\n"
        "1-2 1-2 is the first structure, theta. A derivation adds one line at each step, with the numbers of the\n"
        "structure before that step:\n"
        "    1(a,b) between circles a and b          2(a,b) between circle a and a new circle on line b\n"
        "    3(a,b) between new circles on lines a and b          4(a) between two new circles on line a\n"
        "Structures with fewer circles come first; the order is always the same.\n"
        "--count --part R/M grows the structures with one loop fewer, stores only those, and counts the children of each\n"
        "R-th of M that have it as their one canonical parent (docs/twenty-links.md); also sums 1/|automorphisms|.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .most_words = 0,
    .run = run,
    .writes = "text",
};
