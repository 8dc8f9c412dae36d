/* mbs/analysis/elastic_rules.h - how to analyse a model with elastic links: the rules that Makkonen (1999) names.
 *
 * Vibrations stay small where the lowest eigenfrequency is at least 20 times the frequency of the drive (Sanders & Tesar 1978). */
#ifndef LW_MBS_ANALYSIS_ELASTIC_RULES_H
#define LW_MBS_ANALYSIS_ELASTIC_RULES_H

#include "mbs/dynamics/dynamics_space.h"

enum { LW_RULE_HARMONICS = 4, LW_RULE_SAMPLES = 10 };     /* N and S of eq. 21 */

typedef struct lw_elastic_rules {
    double first;               /* lowest eigenfrequency in the posture of the file, inputs held [Hz]; 0: not found                    */
    double drive;               /* greatest frequency of an input, lw_motion_frequency [rad/s]; 0: the inputs stand                    */
    double ratio;               /* first over drive; 0: one of them is 0                                                               */
    bool   quasi_static;        /* ratio > 20                                                                                          */
    double harmonic_step;       /* longest step that shows LW_RULE_HARMONICS harmonics with LW_RULE_SAMPLES each (eq. 21) [s]; or INFINITY */
    double wave_step;           /* time in which a wave passes the shortest element of a beam (eq. 22) [s]; or INFINITY                 */
} lw_elastic_rules;

/* solved: made of m, which has elastic links; inputs are looked at between these times [s]. */
lw_elastic_rules lw_elastic_rules_find(const lw_model *m, const lw_dynamics *solved, double from, double to);
lw_elastic_rules lw_elastic_rules_find_spatial(const lw_spatial *m, const lw_dynamics *solved, double from, double to);

#endif
