/* mbs/equations/equations_planar.h - the equations of motion of a planar model. */
#ifndef LW_MBS_EQUATIONS_EQUATIONS_PLANAR_H
#define LW_MBS_EQUATIONS_EQUATIONS_PLANAR_H

#include "mbs/constraints/system_internal.h"
#include "mbs/equations/equations.h"
#include "mbs/equations/forces.h"

/* Measures are those of joints (mbs/constraints/system.h).  frames (n_body + 1) is scratch that holds the bodies at the q
 * placed last; hold_inputs: inputs without a motion stay where they are; n_kink, n_jump: of the
 * equations. */
typedef struct lw_planar { const lw_system *s; const lw_forces *f; lw_body_frame *frames; bool hold_inputs; int n_kink, n_jump; } lw_planar;
lw_equations lw_planar_equations(lw_planar *p);

/* Are all derivatives known?  Not those of gears and ties, nor of forces of the caller's in large models. */
bool lw_planar_exact(const lw_planar *p);

#endif
