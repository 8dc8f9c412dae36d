/* enumerate/estimate.c - see estimate.h. */
#include "base/clock.h"
#include "enumerate/estimate.h"
#include "base/real.h"
#include "enumerate/structures.h"
#include "enumerate/synthesis.h"
#include "enumerate/weighting.h"

/* Number of structures sampled of one level: 0.1 to 0.2 s of work. */
static size_t sample_size(int dof) { return dof < 2 ? 2000 : dof < 3 ? 800 : dof < 4 ? 400 : dof < 5 ? 250 : 100; }
#define LIST_STEP 16            /* one of 16 of these is also listed */

/* Structures with L loops.  Up to 9 they are counted.  Above, the sum of 1/|automorphisms| of all structures, which
 * follows from generating functions (none_is_missing in tests/test_structure.c), times 4.93: the ratio was 5.36, 5.075
 * and 4.970 for 7, 8 and 9 loops. */
static double structure_count(int loops)
{
    static const double known[LW_LOOP_MAX + 1] = { 0, 0, 1, 4, 17, 118, 1198, 17133, 311757, 6803203, 171120005, 4.85e9,
                                                   1.52e11, 5.25e12, 1.97e14, 8.0e15 };
    return known[loops];
}

/* Means over a sample of the structures of one level. */
typedef struct level_mean { double chains, prepare_seconds, count_seconds, list_seconds; } level_mean;

static lw_status nothing(void *context, const uint8_t *weight)
{
    (void)context;
    (void)weight;
    return LW_OK;
}

/* The enumeration that is sampled. */
typedef struct sampling {
    const lw_structures *set;
    int    dof;
    bool (*go_on)(void *context);         /* NULL: always */
    void  *context;
} sampling;

/* Prepare every `step`-th structure, count its chains if `sum` is not NULL, and list them if asked; the seconds taken. */
static lw_status time_structures(const sampling *a, int loops, size_t step, uint64_t *sum, bool list, double *seconds)
{
    lw_weighting *w = lw_weighting_create();
    lw_status status = w ? LW_OK : LW_E_MEMORY;
    size_t n = 0;
    double start = lw_clock_cpu();
    for (size_t k = step/2; k < lw_structures_count(a->set, loops) && status == LW_OK; k += step) {
        lw_structure s;
        lw_tally tally = { 0, 0, 0 };
        lw_structures_get(a->set, loops, k, &s);
        status = lw_weighting_prepare(w, &s, a->dof);
        if (status == LW_OK && sum)
            status = lw_weighting_count(w, &tally);
        if (status == LW_OK && list)
            status = lw_weighting_each(w, nothing, NULL);
        if (sum)
            *sum += tally.n_chain;
        if (status == LW_OK && ++n % 64 == 0 && a->go_on && !a->go_on(a->context))
            status = LW_STOPPED;
    }
    *seconds = lw_clock_cpu() - start;
    lw_weighting_free(w);
    return status;
}

static lw_status sample_level(const sampling *a, int loops, level_mean *mean)
{
    size_t n = lw_structures_count(a->set, loops), most = sample_size(a->dof), step = n > most ? n/most : 1;
    size_t few = n > LIST_STEP*step ? LIST_STEP*step : step;
    double seen = (double)((n - step/2 + step - 1)/step), seen_few = (double)((n - few/2 + few - 1)/few);
    double all, prepare, count, list;
    uint64_t chains = 0, few_chains = 0;
    lw_status status = time_structures(a, loops, step, &chains, false, &all);
    if (status == LW_OK)
        status = time_structures(a, loops, few, NULL, false, &prepare);
    if (status == LW_OK)
        status = time_structures(a, loops, few, &few_chains, false, &count);
    if (status == LW_OK)
        status = time_structures(a, loops, few, NULL, true, &list);
    if (status != LW_OK)
        return status;
    *mean = (level_mean){ (double)chains/seen, prepare/seen_few, fmax(all/seen - prepare/seen_few, 0),
                          few_chains ? fmax(list - prepare, 0)*(double)chains/seen/(double)few_chains : 0 };
    return status;
}

/* How many more chains a second are counted and listed with one loop more than `loops`: partial weightings are shared
 * by more chains.  Measured for F = 1 .. 4. */
static double count_rate_growth(int loops) { return loops < 7 ? 1.8 : loops < 8 ? 1.4 : loops < 9 ? 1.2 : 1.1; }
static double list_rate_growth(int loops) { return loops < 8 ? 1.15 : 1; }

/* Means at `loops`; if that level is too large to sample, extrapolated from the two levels below.  The ratio of the
 * chains of two levels falls by about `bend` from level to level, twice as fast before seven loops (measured up to
 * nine loops). */
static lw_status mean_at(const sampling *a, int loops, level_mean *mean)
{
    static const double bends[LW_DOF_MAX + 1] = { 1, 0.97, 0.955, 0.945, 0.92, 0.91, 0.9, 0.89, 0.88, 0.88, 0.88 };
    int top = lw_structures_loops(a->set), dof = a->dof;
    level_mean below;
    lw_status status = sample_level(a, top, mean);
    if (status != LW_OK || loops <= top)
        return status;
    status = sample_level(a, top - 1, &below);
    double ratio = mean->chains/below.chains;
    for (int l = top; l < loops; l++) {
        ratio *= l < 7 ? bends[dof]*bends[dof] : bends[dof];
        mean->chains *= ratio;
        mean->count_seconds *= ratio/count_rate_growth(l);
        mean->list_seconds *= ratio/list_rate_growth(l);
        mean->prepare_seconds *= 1.6;
    }
    return status;
}

static bool grow_tick(void *context, int loops, size_t found)
{
    const sampling *a = context;
    (void)loops;
    (void)found;
    return !a->go_on || a->go_on(a->context);
}

lw_status lw_chains_estimate(int n_link, int dof, lw_estimate *estimate, lw_error *e)
{
    return lw_chains_estimate_while(n_link, dof, NULL, NULL, estimate, e);
}

lw_status lw_chains_estimate_while(int n_link, int dof, bool (*go_on)(void *context), void *context, lw_estimate *estimate, lw_error *e)
{
    sampling a = { .dof = dof, .go_on = go_on, .context = context };
    lw_numbers numbers;
    lw_structures *set;
    level_mean mean;
    lw_status status = lw_numbers_for_links(n_link, dof, 0, &numbers, e);
    if (status != LW_OK)
        return status;
    *estimate = (lw_estimate){ .chains = 1 };
    if (numbers.n_loop == 1)
        return LW_OK;
    /* the largest level that can be made and sampled in much less time than the work itself needs */
    int top = numbers.n_loop <= 6 ? numbers.n_loop : numbers.n_loop >= 8 && dof < 4 ? 7 : 6;
    if (lw_structures_create(5 < top ? 5 : top, 1, &set) == LW_OK)       /* loads what is loaded with the first call */
        lw_structures_free(set);
    double start = lw_clock_cpu();
    status = lw_structures_create_while(top, 1, grow_tick, &a, &set);
    double made = lw_clock_cpu() - start;
    if (status != LW_OK)
        return lw_error_set(e, status, "%s", lw_status_text(status));
    a.set = set;
    status = mean_at(&a, numbers.n_loop, &mean);
    lw_structures_free(set);
    double n = structure_count(numbers.n_loop);
    *estimate = (lw_estimate){ n, n*mean.chains, made*n/structure_count(top),
                               n*(mean.prepare_seconds + mean.count_seconds),
                               n*(mean.prepare_seconds + mean.list_seconds), n*(32.0 + 6.0*numbers.n_loop) };
    return status == LW_OK ? LW_OK : lw_error_set(e, status, "%s", lw_status_text(status));
}
