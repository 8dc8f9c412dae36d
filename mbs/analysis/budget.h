/* mbs/analysis/budget.h - error budget of a robot's tool: how far it can stray from where its drives should hold it.
 *
 *     clearance     the centres of pin and bush, or ball and socket, lie apart by the gap in any direction
 *     play          a drive lies off by up to the play of its gear
 *     elastic       an elastic link gives way under the weight and a load on the tool
 *
 * To first order, from the constraint rows of the posture: row errors e move the tool by T J^-1 e, and the links by the stiffness
 * of their elements while the drives are held. */
#ifndef LW_MBS_ANALYSIS_BUDGET_H
#define LW_MBS_ANALYSIS_BUDGET_H

#include "mbs/dynamics/dynamics_space.h"
#include "mbs/space/robot.h"

typedef struct lw_budget_options {
    double  clearance;           /* of spherical and revolute joints that give none in the file [m]; 0: none           */
    double  play[2];             /* half of the play of each drive that turns [rad], that slides [m]                   */
    lw_vec3 load;                /* on the tool [N], ground axes                                                       */
    bool    weight;              /* gravity acts on elastic links                                                      */
} lw_budget_options;

typedef enum lw_budget_kind { LW_BUDGET_CLEARANCE, LW_BUDGET_PLAY, LW_BUDGET_ELASTIC } lw_budget_kind;

/* The contribution of one joint, drive or link [m].  worst: the greatest displacement of the tool; rms: root of the mean square,
 * for centres anywhere on the sphere or circle of the gap, drives anywhere within their play; an elastic displacement is what it
 * is.  by: columns of the displacements, clearance along three axes (revolute: two), play and elastic in the first. */
typedef struct lw_budget_source {
    lw_budget_kind kind;
    char    name[LW_NAME_SIZE + 16];
    int     index;               /* joint, drive or link                                                               */
    double  worst, rms;
    lw_mat3 by;
} lw_budget_source;

/* All sources at once: the worst case over all their directions, the direction of that error, the sum of the mean squares. */
typedef struct lw_budget {
    int     n;
    lw_budget_source *source;    /* (n), the greatest contributor to `rms` first                                       */
    double  worst, rms;
    lw_vec3 direction;
    lw_vec3 bent;                /* displacement by the elastic links together [m]                                     */
} lw_budget;

/* Elastic links one at a time, for budgets of one model in many postures.  The model must outlive s.  LW_E_MEMORY; the errors of
 * lw_dynamics_make_spatial.  s needs lw_budget_stiffness_free, after a failure too. */
typedef struct lw_budget_stiffness {
    int      n, *link;           /* (n) elastic links                                                                  */
    struct lw_budget_part *part; /* (n)                                                                                */
} lw_budget_stiffness;
lw_status lw_budget_stiffness_make(const lw_spatial *m, const lw_budget_options *o, lw_budget_stiffness *s, lw_error *e);
void      lw_budget_stiffness_free(lw_budget_stiffness *s);

/* In the posture that r stands in.  s NULL: links are rigid.  LW_OPEN: the drives do not hold the tool there.  b needs
 * lw_budget_free, after a failure too. */
lw_status lw_budget_make(lw_robot *r, lw_budget_stiffness *s, const lw_budget_options *o, lw_budget *b, lw_error *e);
void      lw_budget_free(lw_budget *b);

#endif
