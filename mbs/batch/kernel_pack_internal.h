/* mbs/batch/kernel_pack_internal.h - one number of each of eight lanes as one value.  It stays in registers, where
 * arrays would pass through memory from loop to loop.  An operation is one instruction with AVX-512, two with AVX2,
 * four with SSE2; the bits are the same. */
#ifndef LW_MBS_BATCH_KERNEL_PACK_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_PACK_INTERNAL_H

#include "mbs/batch/kernel_run_internal.h"

typedef double pack __attribute__((vector_size(64)));
typedef double pack_anywhere __attribute__((vector_size(64), aligned(8), may_alias));
typedef long long mask __attribute__((vector_size(64)));          /* result of a comparison: -1 or 0 */

LW_INLINE pack get8(const double *from) { return *(const pack_anywhere *)from; }
LW_INLINE void put8(double *to, pack v) { *(pack_anywhere *)to = v; }
LW_INLINE pack all8(double v) { return v - (pack){ 0 }; }
LW_INLINE pack choose8(mask m, pack yes, pack no) { return (pack)((m & (mask)yes) | (~m & (mask)no)); }
LW_INLINE pack where8(mask m, pack v) { return (pack)(m & (mask)v); }                     /* else 0 */
LW_INLINE pack abs8(pack a) { return (pack)((mask)a & 0x7fffffffffffffffLL); }
LW_INLINE pack more8(pack a, pack b) { return choose8((mask)(a > b), a, b); }
LW_INLINE pack less8(pack a, pack b) { return choose8((mask)(a < b), a, b); }

LW_INLINE pack root8(pack a)
{
    pack r;
    for (int j = 0; j < LW_GROUP; j++)
        r[j] = sqrt(a[j]);
    return r;
}

LW_INLINE bool any8(mask m)
{
    long long some = 0;
    for (int j = 0; j < LW_GROUP; j++)
        some |= m[j];
    return some != 0;
}

LW_INLINE double most8(pack a)
{
    double m = a[0];
    for (int j = 1; j < LW_GROUP; j++)
        m = a[j] > m ? a[j] : m;
    return m;
}

/* The number of the lane before; for the first lane it is `first`. */
LW_INLINE pack before8(pack a, double first)
{
    return __builtin_shufflevector(all8(first), a, 0, 8, 9, 10, 11, 12, 13, 14);
}

#endif
