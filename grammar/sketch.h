/* grammar/sketch.h - a linkage with the topology of a mechanism, in a general posture: what a plan can be
 * made from before anybody knows dimensions. */
#ifndef LW_GRAMMAR_SKETCH_H
#define LW_GRAMMAR_SKETCH_H

#include "base/rng.h"
#include "grammar/mechanism.h"

/* Joints at random places of the unit square, slides in random directions; joint k of m is joint k, named J1,
 * J2, ...; links L1, L2, ..., the ground "ground"; the inputs of m; one tracer P on the output link.  A gear's
 * ratio is random too.  LW_E_ARG: no ground, or no output. */
lw_status lw_linkage_sketch(const lw_mechanism *m, lw_rng *rng, lw_linkage *k);

#endif
