/* mbs/space/robot.h - a spatial model as a robot: drives move a tool.
 *
 * The drives are the model's "drives", or its inputs if it has none.  They must leave no freedom.  The Jacobian is that of
 * the tool's twist (velocity of its point, and of its turn) by the rates of the drives:
 *
 *     [ v; omega ] = J q',   tau = J^T [ F; M ]        (Makkonen 1999, eq. 9-15)
 *
 * It comes from the rows of the joints, one solve for each drive, so it holds for serial and parallel robots alike. */
#ifndef LW_MBS_SPACE_ROBOT_H
#define LW_MBS_SPACE_ROBOT_H

#include "mbs/space/space_hold.h"

#define LW_ROBOT_DRIVES 12

typedef struct lw_robot {
    const lw_spatial *model;
    int    tool;                                 /* tracer                                              */
    int    n_drive;
    int    rank;                                 /* of the tool's velocity, where it is not singular: 2 in a plane */
    int    freedoms;                             /* of the tool's velocity and turn together, where they are not singular */
    lw_vec3 normal;                              /* of the plane in which the model moves; 0: it moves in space */
    bool   turns;                                /* the tool's turn is a part of its pose: six drives or more, in the plane three, or fewer
                                                  * with which it can shift in all directions and turn besides (SCARA) */
    bool   only_turns;                           /* the tool's place is at rest (centre of a wrist): measures below are those of its turn */
    lw_vec3 spin;                                /* with four drives: the axis about which it turns; else 0 */
    lw_space space;
    lw_space_follow follow;                      /* the drives as inputs                                */
    lw_space_follow by_tool;                     /* as many drives as the tool's pose has coordinates: these as inputs; memory NULL: none */
    lw_spatial_of pose[6];                       /* (by_tool.n_input) these coordinates                 */
    double drive[LW_ROBOT_DRIVES];               /* where the path below goes                           */
    double from[LW_ROBOT_DRIVES];
    lw_vec3 goal, begin, spin_to_goal;           /* the same of the tool; its turn on the way           */
    lw_spatial_measure measure[LW_ROBOT_DRIVES];  /* of the drives                                       */
    lw_space_hold hold;                          /* columns: velocities of unit drive rates             */
    bool lost;                                   /* the drives lost the tool within the last step       */
    double *start;                               /* (n_q) posture of the file                           */
    double *square;                              /* (n_v * (n_v + 1)) scratch; NULL: an open chain        */
    double determinant;                          /* of the Jacobian at the last posture of a way, where it is square and the condition has a
                                                  * limit; 0: not known */
    char   limit[120];                           /* of the last move: what ended it; empty: it came to its end */
    lw_status broken;                            /* of the last move: what went wrong besides a limit, such as LW_E_MEMORY */
    double condition_limit;                      /* going ends where the condition number exceeds it; 0: no limit (0) */
    double least;                                /* of the size: a limit is found so well (1e-8) */
    bool   free;                                 /* only what the links can reach ends it: no stop, no cone, and no posture in
                                                  * which the drives lose the tool (false) */
} lw_robot;

typedef struct lw_robot_pose {
    lw_vec3 place;                               /* of the tool [m]                                     */
    lw_quaternion turn;
    double  drive[LW_ROBOT_DRIVES];              /* as the model counts them [rad] or [m]               */
    double  jacobian[6][LW_ROBOT_DRIVES];        /* [m/rad], [m/m]; below [rad/rad], [rad/m]            */
    double  singular[3];                         /* singular values of the upper three rows (of a tool that only turns, the lower three),
                                                  * the greatest first                                   */
    int     rank;                                /* of those rows, where they are not singular: 2 where the tool moves in a plane */
    int     freedoms;                            /* rank of all six rows: of velocity and turn together  */
    double  condition;                           /* greatest over least of `rank` singular values; infinite in a singular posture */
    double  manipulability;                      /* their product (Yoshikawa 1985)                      */
    lw_mat3 axes;                                /* columns: directions that belong to them             */
    double  mass[3];                             /* principal values of (J M^-1 J^T)^-1 of these rows, M the mass matrix of the drives:
                                                  * the mass that a force on the tool moves [kg], or the inertia that a moment on a
                                                  * tool that only turns moves [kg m^2], rising, `rank` values; 0: not known, since the
                                                  * posture is singular or drives move no mass */
    lw_mat3 mass_axes;
} lw_robot_pose;

/* tool NULL: the first tracer.  The model must outlive r.  LW_E_ARG with a text: no tracer of that name, no drives, or
 * drives that leave a freedom or do not move the tool; LW_E_MEMORY. */
lw_status lw_robot_make(const lw_spatial *m, const char *tool, lw_robot *r, lw_error *e);
void      lw_robot_free(lw_robot *r);

/* Back to the posture of the file. */
void lw_robot_reset(lw_robot *r);

/* Orientation of the tool in the posture reached. */
lw_quaternion lw_robot_turn(lw_robot *r);

/* All about the posture reached.  LW_OPEN: the drives do not hold the tool there (a singularity of the drives). */
lw_status lw_robot_measure(lw_robot *r, lw_robot_pose *out, lw_error *e);

/* The point of the tool's link that no drive moves in the posture reached, such as the centre of a spherical wrist.  false: there is none, or
 * more than one. */
bool lw_robot_centre(lw_robot *r, lw_vec3 *centre);

/* Forward kinematics: move the drives to these values (n_drive), without a jump to another branch.  LW_OPEN with a text:
 * they cannot go there; the robot is where they stopped. */
lw_status lw_robot_drive(lw_robot *r, const double *value, lw_error *e);

/* Inverse kinematics: move the tool to a place along a straight line, with an even turn (turn NULL: a robot whose
 * `turns` is set keeps its turn, of others it comes as it does).  LW_OPEN with a text: a limit of the workspace, of a stop, a cone or the condition lies
 * before; the robot is at it, to `least`.  LW_E_MEMORY, LW_E_NUMERIC. */
lw_status lw_robot_move(lw_robot *r, lw_vec3 place, const lw_quaternion *turn, lw_error *e);

/* How far the tool gets from where it is in a direction, at most `most` [m]; the robot is there then, and r->limit says
 * what ended the way, if anything did.  LW_E_MEMORY, LW_E_NUMERIC. */
lw_status lw_robot_reach(lw_robot *r, lw_vec3 direction, double most, double *far, lw_error *e);

/* The same of a turn about `axis` (ground axes, a unit vector) in its place, for robots whose `turns` is set: most below pi, far [rad]. */
lw_status lw_robot_tilt(lw_robot *r, lw_vec3 axis, double most, double *far, lw_error *e);

#endif
