/* base/rng.h - the seeded generator: xoshiro256** (Blackman & Vigna 2018), seeded by splitmix64.
 *
 * The caller owns the state.  The same seed and stream give the same numbers on every machine and for any number of
 * threads.  `stream` selects one of many independent sequences of a seed. */
#ifndef LW_BASE_RNG_H
#define LW_BASE_RNG_H

#include <stdint.h>

typedef struct lw_rng { uint64_t s[4]; } lw_rng;

void     lw_rng_seed(lw_rng *r, uint64_t seed, uint64_t stream);
uint64_t lw_rng_bits(lw_rng *r);
double   lw_rng_uniform(lw_rng *r);                        /* [0, 1), 53 bits           */
double   lw_rng_range(lw_rng *r, double lo, double hi);    /* [lo, hi)                  */
double   lw_rng_normal(lw_rng *r);                         /* mean 0, deviation 1       */

#endif
