/* catalogues/draw/scene.h - everything to show of a linkage: its posture, its coupler curves, its motion as a list of
 * postures, and the target it was made for. Numbers in metres; no picture yet.
 *
 * The motion is the one through the posture in the file: a full turn of the input if it can turn, else from limit to
 * limit and, through the limits, back in the other assembly mode; only the range of the input that the linkage asks
 * for (lw_input.first, last), if it does. Linkages of dyads move by their plan. All others (higher groups, gears,
 * welds, inputs between moving links) move along their motion curve (motion_path.h) until it closes. Several inputs
 * move together, by their motions in time or else through their ranges; without either, the first moves and the
 * others rest. */
#ifndef LW_CATALOGUES_DRAW_SCENE_H
#define LW_CATALOGUES_DRAW_SCENE_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include "grammar/linkage/assembly.h"
#include "mbs/plan/plan.h"
#include "optimise/task/target.h"

#define LW_CURVE_MAX 64            /* room for curves, besides one for each tracer */

struct lw_model;                  /* grammar/model/model.h */

/* Where a link is: the place of its reference point (lw_scene.origin), and its rotation since the posture shown as a
 * unit vector.  A point p of the link is at  at + turn * (p - origin). */
typedef struct lw_place { lw_vec2 at, turn; } lw_place;

typedef struct lw_curve {
    int      tracer;
    bool     shown_branch;        /* false: of another circuit or assembly mode, or outside the range
                                   * of the input that the linkage asks for (drawn dashed)           */
    bool     compared;                       /* of the linkage that this one is compared with        */
    bool     outline;                        /* of a link of that linkage, in its posture               */
    bool     closed;              /* the last point is followed by the first                         */
    size_t   n;
    lw_vec2 *p;                   /* [m]; a point that is not finite interrupts the line    (n)      */
} lw_curve;

/* A bar of an elastic link: points along it in every frame, [frame*n + i] [m]. */
typedef struct lw_bent_bar { int link, n; lw_vec2 *p; } lw_bent_bar;

typedef struct lw_scene {
    char       title[128];
    lw_assembly linkage;                      /* in the posture shown                                */
    lw_vec2   *origin;                        /* reference point of each link in that posture [m] (n_link) */
    size_t     n_station;
    lw_vec2   *station;                       /* target points [m]; none for a function (n_station)  */
    size_t     n_each;                        /* points for each tracer that has a target, tracer after
                                               * tracer; 0: all points belong to one tracer         */
    bool       station_closed;
    int        n_curve, max_curve;            /* max_curve: room for so many, LW_CURVE_MAX or more    */
    lw_curve  *curve;
    size_t     n_frame;                       /* postures of the motion; 1: it does not move         */
    size_t     first_frame;                   /* the frame of the posture shown                      */
    bool       loops;                         /* true: the first frame follows the last; false: the
                                               * motion goes back and forth                          */
    lw_place  *place;                         /* [frame * n_link + link]           (n_frame*n_link)  */
    double    *input;                         /* of each frame [rad] or [m]        (n_frame)         */
    int        n_dim;                         /* 0 when no plan could be made                        */
    char       dim_name[LW_DIM_MAX][16];
    double     dim[LW_DIM_MAX];               /* [m] or [rad]                                        */
    lw_dim_kind dim_kind[LW_DIM_MAX];
    int        dim_link[LW_DIM_MAX];
    const struct lw_model *model;             /* whose shapes, ropes and springs are drawn; the caller's;
                                               * NULL: none                                          */
    int        n_bend;                        /* drawn by animations                                   */
    lw_bent_bar *bend;
    char       note[256];                     /* why it does not move; "" when it does               */
    const volatile sig_atomic_t *stop;        /* ends an animation after the frame that is drawn; may be NULL */
} lw_scene;

typedef struct lw_scene_options {
    const char *title;            /* NULL: the linkage's name                                        */
    size_t      n_frame;          /* of the motion                                            (120)  */
    size_t      n_curve_point;    /* of each curve, at least; 0: no curves                    (360)  */
    bool        other_branches;   /* curves of the other assembly modes and circuits too     (false) */
    bool        draft;            /* quickly, while it is dragged: no other branches, no proof that no gap was
                                   * passed over; places to 1e-5 of the size                  (false) */
    const struct lw_model *model; /* how several inputs move in time; its shapes, ropes and springs are
                                   * drawn and it has to outlive the scene; NULL: unknown            */
    double      until;            /* show that motion from 0 to this time [s]; 0: until it repeats or
                                   * comes to rest, else 1 s                                         */
    const volatile sig_atomic_t *stop;       /* ends the motion: a note says so, and it is shown without motion;
                                   * may be NULL                                                     */
} lw_scene_options;

lw_scene_options lw_scene_options_default(void);

/* Compute the scene of a linkage. t (may be NULL) gives the target points. o NULL: defaults. A linkage that has no
 * input, cannot move or does not close still gives a scene, with one frame and a note. Motions in time that end at a
 * dead point give the frames up to there and a note. LW_E_ARG as lw_linkage_check; LW_E_MEMORY. Free with
 * lw_scene_free, also after a failure. */
lw_status lw_scene_make(const lw_linkage *linkage, const lw_target *t, const lw_scene_options *o, lw_scene *s, lw_error *e);
/* The same of any number of parts; m (may be NULL) is their model.  Where a linkage cannot hold them (mbs/dynamics/follow.h):
 * through a whole turn of the first input or between its limits, or in time by the motions of all inputs. */
lw_status lw_scene_make_any(const lw_assembly *parts, const struct lw_model *m, const lw_target *t, const lw_scene_options *o,
                            lw_scene *s, lw_error *e);
void      lw_scene_free(lw_scene *s);

/* Show another linkage in the same picture: the curves of its tracers and the outlines of its links, in the posture of
 * its file.  Curves beyond LW_CURVE_MAX are left out.  LW_E_MEMORY. */
lw_status lw_scene_compare(lw_scene *s, const lw_scene *other, lw_error *e);

/* Dimension i for display: in the linkage's units, and 0 when it is rounding noise (below 1e-9 of the linkage's size,
 * or 1e-12 rad). */
double lw_scene_dimension(const lw_scene *s, int i);

/* Place of point p of a link in a frame [m]; p is given in the posture shown. */
lw_vec2 lw_scene_at(const lw_scene *s, size_t frame, int link, lw_vec2 p);

/* Write to an empty note that a motion goes beyond a limit, "stroke of cylinder" or "stop of joint", if it does: the least and the greatest value over the
 * motion, and those of the limit (+-INFINITY: none), in radians (angle) or metres. */
void lw_scene_note_limit(char note[256], const char *limit, const char *name, const double reached[2], const double allowed[2], bool angle,
                         const lw_units *units);

#endif
