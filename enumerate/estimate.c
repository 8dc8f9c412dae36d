/* enumerate/estimate.c - see estimate.h. */
#include "base/clock.h"
#include "enumerate/estimate.h"
#include "base/real.h"
#include "enumerate/structures.h"
#include "enumerate/synthesis.h"
#include "enumerate/weighting.h"

#define SAMPLE_LOOPS 6          /* the largest number of loops that is sampled      */
#define SAMPLE       96         /* number of structures sampled of one level        */

/* Structures with L loops.  Known up to 8; there the ratio of neighbours is 4.3, 6.9, 10.2, 14.3, 18.2 and
 * keeps growing by about 4. */
static double structure_count(int loops)
{
    static const double known[] = { 0, 0, 1, 4, 17, 118, 1198, 17133, 311757 };
    double n = known[loops < 8 ? loops : 8];
    for (int l = 9; l <= loops; l++)
        n *= 18.2 + 4.0*(l - 8);
    return n;
}

/* Means over a sample of the structures of one level. */
typedef struct level_mean { double chains, count_seconds, list_seconds; } level_mean;

static lw_status nothing(void *context, const uint8_t *weight)
{
    (void)context;
    (void)weight;
    return LW_OK;
}

static lw_status sample_level(const lw_structures *set, int loops, int dof, level_mean *mean)
{
    size_t n = lw_structures_count(set, loops), step = n > SAMPLE ? n/SAMPLE : 1, n_seen = 0;
    lw_weighting *w = lw_weighting_create();
    lw_status status = w ? LW_OK : LW_E_MEMORY;
    *mean = (level_mean){ 0 };
    for (size_t k = step/2; k < n && status == LW_OK; k += step, n_seen++) {
        lw_structure s;
        lw_tally tally = { 0, 0 };
        lw_structures_get(set, loops, k, &s);
        double start = lw_clock_cpu();
        status = lw_weighting_prepare(w, &s, dof);
        double ready = lw_clock_cpu();
        if (status == LW_OK)
            status = lw_weighting_count(w, &tally);
        double counted = lw_clock_cpu();
        if (status == LW_OK)
            status = lw_weighting_each(w, nothing, NULL);
        mean->chains += (double)tally.n_chain;
        mean->count_seconds += counted - start;
        mean->list_seconds += lw_clock_cpu() - counted + ready - start;
    }
    lw_weighting_free(w);
    mean->chains /= (double)n_seen;
    mean->count_seconds /= (double)n_seen;
    mean->list_seconds /= (double)n_seen;
    return status;
}

/* Means at `loops`; if that level is too large to sample, extrapolated from two levels below. */
static lw_status mean_at(const lw_structures *set, int loops, int dof, level_mean *mean)
{
    int top = lw_structures_loops(set);
    lw_status status = sample_level(set, top, dof, mean);
    if (status != LW_OK || loops <= top)
        return status;
    level_mean below;
    status = sample_level(set, top - 1, dof, &below);
    double growth = pow(mean->chains/below.chains, loops - top);
    mean->chains *= growth;
    mean->count_seconds *= growth;
    mean->list_seconds *= growth;
    return status;
}

lw_status lw_chains_estimate(int n_link, int dof, lw_estimate *estimate, lw_error *e)
{
    lw_numbers numbers;
    lw_structures *set;
    level_mean mean;
    lw_status status = lw_numbers_for_links(n_link, dof, 0, &numbers, e);
    if (status != LW_OK)
        return status;
    *estimate = (lw_estimate){ .chains = 1 };
    if (numbers.n_loop == 1)
        return LW_OK;
    int top = numbers.n_loop < SAMPLE_LOOPS ? numbers.n_loop : SAMPLE_LOOPS;
    double start = lw_clock_cpu();
    status = lw_structures_create(top, 1, &set);
    double made = lw_clock_cpu() - start;
    if (status != LW_OK)
        return lw_error_set(e, status, "out of memory");
    status = mean_at(set, numbers.n_loop, dof, &mean);
    lw_structures_free(set);
    double n = structure_count(numbers.n_loop);
    *estimate = (lw_estimate){ n, n*mean.chains, made*n/structure_count(top), n*mean.count_seconds,
                               n*mean.list_seconds, n*(32.0 + 6.0*numbers.n_loop) };
    return status == LW_OK ? LW_OK : lw_error_set(e, status, "out of memory");
}
