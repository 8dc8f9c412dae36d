/* mbs/equations/timed.h - where steps in time must end for the sake of functions of time alone: at their kinks, where a solver
 * begins anew, and so often that no pulse lies between two steps. */
#ifndef LW_MBS_EQUATIONS_TIMED_H
#define LW_MBS_EQUATIONS_TIMED_H

#include <stdbool.h>
#include "grammar/functions/expression.h"

typedef struct lw_timed {
    void  (*expressions)(void *context, lw_expression_sink *see, void *of);      /* shows the functions; NULL: there are none */
    void   *context;
    double  from, to;                        /* of the run */
    double  kink, calm, spacing;             /* the next kink; until when no pulse lies between samples that are so far apart */
} lw_timed;

/* Shows the expressions of forces, laws and rates, one after the other, with the values of their variables at (t, q, v); force (n_v) gets the
 * forces. */
typedef void lw_timed_values(void *context, double t, const double *q, const double *v, double *force, lw_expression_sink_at *see, void *of);

/* The sides of the kinks, and of the jumps, of these expressions (lw_expression_breaks). */
void lw_timed_sides(lw_timed_values *values, void *context, double t, const double *q, const double *v, double *force, double *kink, double *jump);

/* How often the functions jump, or have kinks, where something else than the time changes (lw_expression_breaks). */
int lw_timed_breaks(const lw_timed *w, bool jumps);

/* The first kink between t and end; infinite: none. */
double lw_timed_next_kink(const lw_timed *w, double t, double end);

/* The start of the run, or the time just behind it if it is a kink: the functions there may be those of neither side. */
double lw_timed_begin(const lw_timed *w);

/* Where the next step from t must end: just before a kink, within the interval that is calm, or at the end of the run.  near: of
 * a method that evaluates the functions at the end of a step alone. */
double lw_timed_end(lw_timed *w, double t);
double lw_timed_near(lw_timed *w, double t);

/* Is t, the end of a step, just before a kink?  The time just behind the kink, at most the end of the run. */
bool   lw_timed_at_kink(const lw_timed *w, double t);
double lw_timed_behind(const lw_timed *w);

#endif
