/* bench_enumerate.c - how fast topologies are counted and listed, beside geng with a filter, and how it grows.
 *
 *     bench_enumerate              the rows of docs/theory.md that take a second or two each
 *     bench_enumerate full         18 links too (a minute or two)
 *     bench_enumerate plot F.svg   seconds and numbers per loop as a picture
 *     geng -C -t -d2 14 19:19 | bench_enumerate filter     the graphs that move, by the pebble game
 *
 * Seconds of the wall clock and of the processor (all threads), best of three below half a second. */
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "base/clock.h"
#include "base/file.h"
#include "base/parallel.h"
#include "catalogues/draw/plot.h"
#include "catalogues/draw/svg.h"
#include "enumerate/chains.h"
#include "enumerate/invert.h"
#include "grammar/topology/graph6.h"

typedef enum work { COUNT, LIST, GROUND } work;

static lw_status visit_ground(void *context, const lw_chain_item *item)
{
    uint8_t lowest[LW_LINK_MAX], ground[LW_LINK_MAX];
    (void)lw_chain_item_orbits(item, lowest);
    *(uint64_t *)context += (uint64_t)lw_ground_choices(lowest, item->chain->n_link, ground);
    return LW_OK;
}

static lw_status print_graph6(void *context, const lw_chain_item *item, char *text, size_t most, size_t *length)
{
    (void)context;
    *length = lw_graph6_print(item->chain, text, most);
    text[(*length)++] = '\n';
    return LW_OK;
}

typedef struct output { FILE *f; uint64_t bytes; } output;

static lw_status write_text(void *context, const char *text, size_t size)
{
    output *o = context;
    o->bytes += size;
    return fwrite(text, 1, size, o->f) == size ? LW_OK : LW_E_IO;
}

typedef struct result { uint64_t n; double wall, cpu; } result;

static double processor_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}

static uint64_t walk(work what, const lw_chains *chains, const lw_chain_walk *how)
{
    uint64_t n = 0;
    if (what == COUNT) {
        lw_chain_table table;
        if (lw_chains_count(chains, how, &table) == LW_OK)
            n = table.total.n_chain;
        lw_chain_table_free(&table);
    } else if (what == LIST) {
        int n_link = lw_chains_numbers(chains)->n_link;
        output o = { fopen("/dev/null", "w"), 0 };
        if (o.f && lw_chains_print(chains, how, LW_GRAPH6_SIZE + 1, print_graph6, write_text, &o) == LW_OK)
            n = o.bytes/(uint64_t)(2 + (n_link*(n_link - 1)/2 + 5)/6);
        if (o.f)
            fclose(o.f);
    } else {
        (void)lw_chains_each(chains, how, visit_ground, &n);
    }
    return n;
}

/* One run, structures and all. */
static result run(work what, int n_link, int dof, int n_thread)
{
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    result r = { 0, lw_clock_wall(), processor_seconds() };
    how.n_thread = n_thread;
    if (lw_chains_create(n_link, dof, n_thread, &chains, NULL) == LW_OK) {
        r.n = walk(what, chains, &how);
        lw_chains_free(chains);
    }
    r.wall = lw_clock_wall() - r.wall;
    r.cpu = processor_seconds() - r.cpu;
    return r;
}

static result report(work what, int n_link, int dof, int n_thread)
{
    static const char *const name[] = { "count", "list graph6", "ground links" };
    result best = run(what, n_link, dof, n_thread);
    for (int k = 1; k < 3 && best.wall < 0.5; k++) {
        result r = run(what, n_link, dof, n_thread);
        best.wall = r.wall < best.wall ? r.wall : best.wall;
        best.cpu = r.cpu < best.cpu ? r.cpu : best.cpu;
    }
    printf("%s,%d,%d,%d,%llu,%.4f,%.4f,%.1f\n", name[what], n_link, dof, n_thread, (unsigned long long)best.n,
           best.wall, best.cpu, 1e9*best.cpu/(double)(best.n ? best.n : 1));
    fflush(stdout);
    return best;
}

/* ---- geng and a filter ---------------------------------------------------------------------------- */

static int filter(void)
{
    char line[1024];
    uint64_t n = 0;
    while (fgets(line, sizeof line, stdin)) {
        lw_chain c;
        if (lw_graph6_read(line, strlen(line), "-", &c, NULL) != LW_OK)
            return 3;
        n += !lw_chain_rigid(&c, lw_chain_mobility(&c) == 0, NULL);
    }
    printf("%llu\n", (unsigned long long)n);
    return 0;
}

static void compare_with_geng(const char *program, int n_link, int n_joint, result count, result list)
{
    const char *geng = system("command -v nauty-geng >/dev/null 2>&1") == 0 ? "nauty-geng"
                     : system("command -v geng >/dev/null 2>&1") == 0 ? "geng" : NULL;
    char command[512], answer[64] = "";
    if (!geng) {
        printf("# geng is not installed: no comparison\n");
        return;
    }
    snprintf(command, sizeof command, "%s -q -C -t -d2 %d %d:%d | '%s' filter", geng, n_link, n_joint, n_joint, program);
    double start = lw_clock_wall();
    FILE *f = popen(command, "r");
    if (!f || !fgets(answer, sizeof answer, f))
        snprintf(answer, sizeof answer, "0");
    if (f)
        pclose(f);
    double seconds = lw_clock_wall() - start;
    printf("# geng and filter: %lld of %d links in %.3f s (wall), %.1f times our counting, %.1f times our listing\n",
           atoll(answer), n_link, seconds, seconds/count.wall, seconds/list.wall);
    fflush(stdout);
}

/* ---- growth --------------------------------------------------------------------------------------- */

#define LOOPS_FIRST 2
#define LOOPS_LAST  7
#define N_LOOPS     (LOOPS_LAST - LOOPS_FIRST + 1)

static int plot(const char *path)
{
    double loops[N_LOOPS], chains[N_LOOPS], structures[N_LOOPS], micro[N_LOOPS];
    for (int k = 0; k < N_LOOPS; k++) {
        lw_structures *set;
        result r = run(COUNT, 2*(LOOPS_FIRST + k) + 2, 1, 1);
        loops[k] = LOOPS_FIRST + k;
        chains[k] = (double)r.n;
        micro[k] = 1e6*r.cpu;
        if (lw_structures_create(LOOPS_FIRST + k, 1, &set) != LW_OK)
            return 1;
        structures[k] = (double)lw_structures_count(set, LOOPS_FIRST + k);
        lw_structures_free(set);
    }
    lw_series series[] = { { "chains, F = 1", N_LOOPS, loops, chains, false },
                           { "structures", N_LOOPS, loops, structures, false },
                           { "us to count them, one core", N_LOOPS, loops, micro, false } };
    lw_plot p = { .title = "Chains with L loops", .x_label = "loops L", .y_label = "number, microseconds", .log_y = true,
                  .n_series = 3, .series = series };
    lw_drawing drawing = { 0 };
    lw_bytes bytes = { 0 };
    lw_error e = { 0 };
    lw_status status = lw_plot_draw(&p, &drawing, &e);
    if (status == LW_OK)
        status = lw_svg_write(&drawing, &bytes, &e);
    if (status == LW_OK)
        status = lw_file_write(path, bytes.data, bytes.size, &e);
    if (status != LW_OK)
        fprintf(stderr, "bench_enumerate: %s\n", e.text);
    lw_bytes_free(&bytes);
    lw_drawing_free(&drawing);
    return status != LW_OK;
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "filter") == 0)
        return filter();
    if (argc > 2 && strcmp(argv[1], "plot") == 0)
        return plot(argv[2]);
    printf("# enumerate: structures and all, nothing kept between rows\n");
    printf("work,links,dof,threads,found,wall s,cpu s,cpu ns each\n");
    for (int n_link = 6; n_link <= 12; n_link += 2)
        (void)report(COUNT, n_link, 1, 1);
    result count = report(COUNT, 14, 1, 1), list = report(LIST, 14, 1, 1);
    compare_with_geng(argv[0], 14, 19, count, list);
    result one = report(COUNT, 16, 1, 1);
    report(LIST, 16, 1, 1);
    report(COUNT, 17, 2, 1);
    report(GROUND, 12, 1, 1);
    if (lw_core_count() > 1) {
        result two = report(COUNT, 16, 1, 2);
        printf("# two threads: %.2f times as fast as one, with %.2f times the processor time\n", one.wall/two.wall, two.cpu/one.cpu);
    }
    if (argc > 1 && strcmp(argv[1], "full") == 0)
        report(COUNT, 18, 1, 0);
    return 0;
}
