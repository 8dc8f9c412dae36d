/* A linkage that can be read is moved: plan, input ranges, postures with rates, a trace, its mechanism, pictures' text.  Every
 * number that a successful call gives is finite. */
#include <math.h>
#include "linkwright.h"
#include "tests/fuzz/fuzz.h"

enum { N = 32 };

static lw_status count_range(void *context, const lw_input_range *range)
{
    (void)range;
    return ++*(int *)context < 100 ? LW_OK : LW_STOPPED;
}

static void move(lw_kinematics *m)
{
    double first = lw_kinematics_input(m), input[N], x[N], y[N], margin[N];
    int n_range = 0;
    char *text = NULL;
    lw_linkage *there = NULL;
    (void)lw_kinematics_ranges(m, count_range, &n_range);
    if (lw_kinematics_explain(m, &text) == LW_OK)
        lw_free(text);
    for (int i = 0; i < N; i++)
        input[i] = first + 0.3*i;
    if (lw_kinematics_trace(m, 0, N, input, x, y, NULL, margin) == LW_OK)
        for (int i = 0; i < N; i++)
            demand(!(margin[i] >= 0) || (isfinite(x[i]) && isfinite(y[i])));
    if (lw_kinematics_linkage(m, first + 0.1, &there, NULL) == LW_OK)
        lw_linkage_destroy(there);
}

static int one_input(const uint8_t *data, size_t size)
{
    lw_linkage *k = NULL;
    lw_kinematics *m = NULL;
    lw_mechanism *topology = NULL;
    lw_error e;
    if (lw_linkage_parse((const char *)data, size, "f", NULL, &k, &e) != LW_OK)
        return 0;
    (void)lw_linkage_mobility(k);
    if (lw_linkage_mechanism(k, &topology, &e) == LW_OK)
        lw_mechanism_destroy(topology);
    if (lw_kinematics_create(k, &m, &e) == LW_OK)
        move(m);
    lw_kinematics_destroy(m);
    lw_linkage_destroy(k);
    return 0;
}
