/* mbs/dynamics/reduced.h - one freedom, one coordinate: the motion of a rigid linkage of dyads along the curve of its
 * postures.
 *
 *     M(s) s'' + M'(s)/2 s'^2 = Q(s, s'),     M = sum of m |c'|^2 + I phi'^2,   Q = sum of F.c' + T phi'
 *
 * (primes of c and phi: by the input s of the plan).  With p = sqrt(M) s', so that p^2/2 is the kinetic energy, it is
 *     s' = p/sqrt(M),   p' = Q/sqrt(M)
 * and M' is not wanted: p p' = s' (M s'' + M'/2 s'^2).  Everything comes from the plan's closed forms and their first
 * derivatives, nothing is solved.  Where a dyad passes through a position in which its two
 * assemblies meet and part again (change points: parallelograms), the velocities continue, so its mode
 * changes; near such a place, where the closed forms lose digits, M and Q are taken from a polynomial through
 * places beside it. */
#ifndef LW_MBS_DYNAMICS_REDUCED_H
#define LW_MBS_DYNAMICS_REDUCED_H

#include "mbs/dynamics/dynamics.h"
#include "mbs/plan/plan.h"

/* LW_OK, and d is ready for it; or LW_E_KIND with the reason in text. */
lw_status lw_reduced_able(lw_dynamics *d, char *text, size_t size);

#endif
