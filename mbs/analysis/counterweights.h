/* mbs/analysis/counterweights.h - counterweights that hold the common centre of mass still.
 *
 * The shaking force of the moving masses is minus the total mass times the acceleration of their common centre.  A
 * counterweight m at the place a (from a pin J of its link, in the frame of the link) adds m J(t) and m a, turned by
 * the angle of the link; with p = m a the condition is
 *     sum of m c(t) + sum over links of (m_l J_l(t) + turn_l(t) p_l)  =  constant.
 * On links that turn about ground pins J stands still, and this is linear in the p: least squares over the postures.
 * Where they do not remove all of the motion, floating links get counterweights too, the one that helps most first
 * (orthogonal matching pursuit: an orthonormal basis of what the counterweights so far can do grows by each of them);
 * their masses |p|/radius are found by repetition.  Where a deviation remains, no such counterweights remove all of it:
 * every link must reach ground by pins alone (Berkof & Lowen 1969). */
#ifndef LW_MBS_ANALYSIS_COUNTERWEIGHTS_H
#define LW_MBS_ANALYSIS_COUNTERWEIGHTS_H

#include "grammar/model/model.h"
#include "mbs/constraints/system.h"

typedef struct lw_counterweights {
    int    n;
    lw_counterweight *weight;                    /* (n) owned */
    double deviation_before, deviation_after;    /* of mass times common centre from its mean, RMS [kg m] */
    bool   balanced;
} lw_counterweights;

/* Counterweights for a model of any size whose postures q (n_posture x n_q, mbs/constraints/system.h) cover its motion.
 * LW_E_KIND: no link turns about a ground pin, or some are elastic; LW_E_ARG: fewer than n_body + 2 postures.  Free with
 * lw_counterweights_free, after a failure too. */
void      lw_counterweights_free(lw_counterweights *c);
lw_status lw_counterweights_find(const lw_model *m, const lw_system *s, size_t n_posture, const double *q,
                                 lw_counterweights *out, lw_error *e);

#endif
