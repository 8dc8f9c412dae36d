/* grammar/linkage/sketch.h - a linkage with the topology of a mechanism, in a random posture.  A plan can be made from it
 * before the dimensions are known. */
#ifndef LW_GRAMMAR_LINKAGE_SKETCH_H
#define LW_GRAMMAR_LINKAGE_SKETCH_H

#include "base/rng.h"
#include "grammar/linkage/linkage.h"
#include "grammar/topology/mechanism.h"

/* Joints get random places in the unit square, slides random directions, gears random ratios.  Joint i of m becomes
 * joint i; joints are named J1, J2, ..., links L1, L2, ..., the ground "ground".  The inputs are those of m; one
 * tracer P is on the output link.  LW_E_ARG: no ground, or no output. */
lw_status lw_linkage_sketch(const lw_mechanism *m, lw_rng *rng, lw_linkage *linkage);

#endif
