/* mbs/assemblies.h - all ways in which a group can be put together while everything before it stands still.
 *
 * A dyad has the two its sign tells.  A higher group has the isolated solutions of its loops over the complex
 * numbers, of which those with unit directions are postures: 6 for a triad of pins, at most.  They are found by
 * monodromy: one solution is carried round random closed ways of the dimensions and known points through the
 * complex numbers and comes back as another (Sottile, White & Sommese; Duff et al. 2019), until nothing new has
 * come for many rounds; then all are carried to the dimensions wanted.  What is found is proved by its
 * residual and counted once; that nothing is missing is not proved, except where a bound is reached. */
#ifndef LW_MBS_ASSEMBLIES_H
#define LW_MBS_ASSEMBLIES_H

#include <stdint.h>
#include "mbs/plan.h"

#define LW_ASSEMBLY_MAX 512

typedef struct lw_assemblies {
    int    n_complex;         /* solutions found at dimensions by chance: what linkages of this kind have */
    int    n_real;            /* postures at these dimensions                                     */
    bool   complete;          /* as many as the group can have: 6 for triads of pins              */
    int    rounds;            /* ways gone round                                                  */
    double residual;          /* largest of a posture's loops, over lw_plan_size                  */
    double mode[LW_ASSEMBLY_MAX][LW_UNKNOWN_MAX];   /* of each posture: what stands in mode[] for this group */
} lw_assemblies;

/* Those of higher group `group` at the input.  mode: a seed from which the posture at the input can be reached; the
 * groups before this one stay in it.  patience: rounds without anything new before it ends, 0: 12.
 * LW_OPEN: the seed does not reach the input; LW_E_ARG: no such group; LW_STOPPED: more than LW_ASSEMBLY_MAX;
 * LW_E_MEMORY. */
lw_status lw_assemblies_find(const lw_plan *plan, const double *dim, const double *mode, double input, int group,
                             uint64_t seed, int patience, lw_assemblies *found, lw_error *e);

#endif
