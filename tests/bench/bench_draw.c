/* bench_draw.c - pictures of chains: how long one takes, and how good the worst is.
 * Processor time of one thread. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "catalogues/draw/chain_drawing.h"
#include "catalogues/draw/svg.h"
#include "tests/all_chains.h"

static double milliseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3*(double)t.tv_sec + 1e-6*(double)t.tv_nsec;
}

static int by_size(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Every `step`-th chain; with a ground link its first. */
static int draw_all(int n_link, int dof, int step, bool grounded)
{
    chain_list list = all_chains(n_link, dof);
    double *time = malloc((size_t)list.n*sizeof *time), angle = 180, gap = 9, sum = 0;
    int n = 0, n_planar = 0, n_cross = 0;
    for (int i = 0; time && i < list.n; i += step) {
        lw_mechanism m;
        lw_chain_layout l;
        lw_bytes svg;
        lw_chain_style style = { .width = 320, .height = 240 };
        lw_drawing d;
        lw_mechanism_from_chain(&list.chain[i], &m);
        m.ground = grounded ? 0 : LW_NONE;
        double begun = milliseconds();
        if (lw_chain_layout_make(&m, &l, NULL) != LW_OK || lw_chain_draw(&m, &l, &style, &d, NULL) != LW_OK
            || lw_svg_write(&d, &svg, NULL) != LW_OK)
            return 1;
        lw_drawing_free(&d);
        time[n] = milliseconds() - begun;
        sum += time[n++];
        lw_bytes_free(&svg);
        n_planar += l.planar;
        n_cross += l.n_cross;
        angle = fmin(angle, l.least_angle*180/LW_PI);
        gap = fmin(gap, l.least_gap);
    }
    if (time)
        qsort(time, (size_t)n, sizeof *time, by_size);
    if (n > 0)
        printf("%5d %3d %7s %8d %8d %9d %8.2f %8.2f %8.2f %7.1f %6.2f\n", n_link, dof, grounded ? "yes" : "no", n,
               n_planar, n_cross, sum/n, time[n/2], time[n - 1], angle, gap);
    free(time);
    free(list.chain);
    return 0;
}

int main(void)
{
    static const struct { int n_link, dof, step; bool grounded; } row[] = {
        { 6, 1, 1, false }, { 8, 1, 1, false }, { 9, 2, 1, false }, { 10, 1, 1, false }, { 10, 1, 1, true },
        { 12, 1, 10, false }, { 13, 2, 40, false } };
    printf("links dof  ground pictures   planar crossings  mean ms   median  slowest  angle    gap\n");
    for (size_t i = 0; i < sizeof row/sizeof *row; i++)
        if (draw_all(row[i].n_link, row[i].dof, row[i].step, row[i].grounded))
            return 1;
    return 0;
}
