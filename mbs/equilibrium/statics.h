/* mbs/equilibrium/statics.h - equilibrium: forces balanced on the constraints. */
#ifndef LW_MBS_EQUILIBRIUM_STATICS_H
#define LW_MBS_EQUILIBRIUM_STATICS_H

#include "mbs/dynamics/dynamics.h"

typedef struct lw_rest {
    int    iterations;
    double residual;            /* greatest force left along the constraints [J] */
    bool   stable;              /* the stiffness is positive definite; else a saddle or a neutral equilibrium */
    bool   neutral;             /* nothing resists one motion (a buckled round column turns about its axis); stable is false */
    bool   unknown;             /* stability is not known: large models and elastic links under forces without a potential; stable is false */
} lw_rest;

/* "stable", "neutral", "not stable", or that and why it is not known. */
const char *lw_rest_text(const lw_rest *r);

#endif
