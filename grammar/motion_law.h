/* grammar/motion_law.h - laws of motion from rest to rest over a unit of way in a unit of time, as cam and drive
 * engineers choose them (VDI 2143; Makkonen 1999, L899-933). */
#ifndef LW_GRAMMAR_MOTION_LAW_H
#define LW_GRAMMAR_MOTION_LAW_H

typedef struct lw_motion_law {
    const char *name;                  /* "cycloid"                                                    */
    const char *words;                 /* one line                                                     */
    double      speed_peak, acceleration_peak, jerk_peak;       /* Cv, Ca, Cj: over way/T^k; infinite: a step   */
    double      copper_loss;           /* integral of the squared acceleration: heat of a motor [T^3/way^2]    */
} lw_motion_law;

/* The laws by number; NULL past the last one. */
const lw_motion_law *lw_motion_law_get(int law);

/* Number of a law by its name; -1: there is none. */
int lw_motion_law_find(const char *name);

/* Way, speed, acceleration and jerk at u; 0 and 1 outside [0, 1].  At a step they are those after it. */
void lw_motion_law_at(int law, double u, double out[4]);

/* Taylor coefficients 0 .. order of the way at u; at a step those behind it, with direction < 0 those before it. */
void lw_motion_law_series(int law, double u, int direction, int order, double *out);

/* The i-th place inside at which the law changes its formula; 1: there is none. */
double lw_motion_law_border(int law, int i);

#endif
