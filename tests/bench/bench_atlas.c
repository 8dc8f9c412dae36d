/* bench_atlas.c - curves drawn in a second by one core, and the twenty nearest of a million: processor time of the
 * library, and wall time of the whole program where LW_PROGRAM or build/linkwright is there.  Best of five. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include "base/clock.h"
#include "catalogues/store/nearest.h"

#define SAMPLES 1250000

static char path[64];

static lw_store *open_store(bool write)
{
    lw_store *s;
    lw_error e;
    lw_store_options o = { .write = write, .create = write };
    if (lw_store_open(path, &o, &s, &e) == LW_OK)
        return s;
    fprintf(stderr, "%s\n", e.text);
    exit(1);
}

/* Returns how many curves there are. */
static size_t fill(void)
{
    lw_curve_maker *maker;
    lw_error e;
    lw_store *s = open_store(true);
    lw_store_run run = { "curves", "bench", "bench", 1 };
    double drawn = 0, all = lw_clock_cpu();
    size_t n = 0;
    if (lw_curve_maker_create("fourbar", &maker, &e) != LW_OK)
        exit(1);
    lw_atlas_sweep sweep = { .families = lw_curve_maker_families(maker), .seed = 1 };
    lw_store_begin(s, &e);
    lw_store_run_begin(s, &run, &e);
    lw_store_sweep_begin(s, &sweep, &e);
    for (size_t at = 0, number = 0; at < SAMPLES; at += LW_SEGMENT_MAX, number++) {
        lw_atlas_tree tree[2];
        size_t some = SAMPLES - at < LW_SEGMENT_MAX ? SAMPLES - at : LW_SEGMENT_MAX;
        double t = lw_clock_cpu();
        if (lw_atlas_segment(maker, 1, number, some, LW_ATLAS_BOTH, 1, NULL, tree) != LW_OK)
            exit(1);
        drawn += lw_clock_cpu() - t;
        lw_store_put_segment(s, tree, some, &e);
        n += tree[0].n + tree[1].n;
        lw_atlas_tree_free(&tree[0]);
        lw_atlas_tree_free(&tree[1]);
    }
    lw_store_commit(s, &e);
    lw_store_close(s);
    lw_curve_maker_free(maker);
    all = lw_clock_cpu() - all;
    printf("%-34s %10.0f /s a core\n", "curves drawn", (double)n/drawn);
    printf("%-34s %10.0f /s a core\n", "curves drawn and stored", (double)n/all);
    return n;
}

static void search(const char *what, const lw_vec2 *p, size_t n, bool closed)
{
    double best = INFINITY;
    lw_atlas_search count = { 0 };
    for (int trial = 0; trial < 5; trial++) {
        lw_atlas_hit hit[20];
        lw_error e;
        int found;
        double t = lw_clock_cpu();
        lw_store *s = open_store(false);
        if (lw_store_nearest(s, p, n, closed, NULL, 20, hit, &found, &count, &e) != LW_OK)
            exit(1);
        lw_store_close(s);
        best = fmin(best, lw_clock_cpu() - t);
    }
    printf("%-34s %10.2f ms, %llu of %llu blocks, %llu of %llu curves compared\n", what, 1e3*best,
           (unsigned long long)count.n_read, (unsigned long long)count.n_block, (unsigned long long)count.n_compared,
           (unsigned long long)count.n_curve);
}

static void whole_program(const char *target)
{
    const char *program = getenv("LW_PROGRAM");
    char line[400];
    double best = INFINITY;
    snprintf(line, sizeof line, "%s catalogue nearest %s %s --results 20 > /dev/null 2>&1", program ? program : "build/linkwright",
             path, target);
    for (int trial = 0; trial < 5; trial++) {
        double t = lw_clock_wall();
        if (system(line) != 0)
            return;
        best = fmin(best, lw_clock_wall() - t);
    }
    printf("%-34s %10.2f ms wall with the start of program and shell\n", target, 1e3*best);
}

int main(void)
{
    lw_vec2 p[100];
    snprintf(path, sizeof path, "/tmp/lw-bench-atlas-XXXXXX");
    int f = mkstemp(path);
    if (f < 0)
        return 1;
    close(f);
    printf("%zu curves\n", fill());
    for (int i = 0; i < 100; i++)
        p[i] = lw_v2(2*cos(2*LW_PI*i/100), sin(2*LW_PI*i/100));
    search("nearest to an ellipse", p, 100, true);
    for (int i = 0; i < 100; i++)
        p[i] = lw_v2(2*sin(2*LW_PI*i/100), sin(4*LW_PI*i/100));
    search("nearest to an eight", p, 100, true);
    for (int i = 0; i < 100; i++)
        p[i] = lw_v2(i, 20*sin(0.06*i));
    search("nearest to a wave", p, 100, false);
    whole_program("examples/ellipse.csv");
    whole_program("examples/walking-foot.csv");
    whole_program("examples/pick-and-place.csv");
    unlink(path);
    return 0;
}
