/* catalogues/draw/scene.h - what there is to show of a linkage: its posture, the curves of its tracers, its
 * motion as a row of postures, and the target it was made for.  Plain numbers in metres; no picture yet.
 *
 * The motion is that of the branch which holds the posture of the file: a full turn of the input when
 * it can turn, otherwise from limit to limit and, through the limits, back on the other side; only the
 * range of the input that the linkage asks for (lw_input.first, last) when it asks for one.  Linkages of dyads move by
 * their plan, all others - higher groups, gears, welds, inputs between moving links - along their curve of postures
 * (catalogues/draw/motion_path.h): through all turns until it closes.  Several inputs move together, by their motions in time or
 * else through their ranges; without either the first moves and the others rest. */
#ifndef LW_CATALOGUES_DRAW_SCENE_H
#define LW_CATALOGUES_DRAW_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include "grammar/linkage.h"
#include "mbs/plan/plan.h"
#include "optimise/task/target.h"

#define LW_CURVE_MAX 64

struct lw_model;                  /* grammar/model.h */

/* Where a link is: its reference point (lw_scene.origin of the posture) now, and the turn since the
 * posture as unit vector, so that a point p of the link is now at  at + turn * (p - origin). */
typedef struct lw_place { lw_vec2 at, turn; } lw_place;

typedef struct lw_curve {
    int      tracer;
    bool     shown_branch;        /* false: of another circuit or assembly mode, or beyond the range
                                   * of the input that the linkage asks for (drawn dashed)           */
    bool     closed;              /* the last point is followed by the first                         */
    size_t   n;
    lw_vec2 *p;                   /* [m]; one that is not finite breaks the line            (n)      */
} lw_curve;

typedef struct lw_scene {
    char       title[128];
    lw_linkage linkage;                       /* in the posture shown                                */
    lw_vec2    origin[LW_LINK_MAX];           /* reference point of each link in that posture [m]    */
    size_t     n_station;
    lw_vec2   *station;                       /* target points [m]; none for a function (n_station)  */
    size_t     n_each;                        /* so many for each tracer that has some, one after the other;
                                               * 0: all are of one                                  */
    bool       station_closed;
    int        n_curve;
    lw_curve   curve[LW_CURVE_MAX];
    size_t     n_frame;                       /* postures of the motion; 1: it does not move         */
    size_t     first_frame;                   /* the frame that is the posture shown                  */
    bool       loops;                         /* the last is followed by the first, else by the one
                                               * before it, back and forth                           */
    lw_place  *place;                         /* [frame * n_link + link]           (n_frame*n_link)  */
    double    *input;                         /* of each frame [rad] or [m]        (n_frame)         */
    int        n_dim;                         /* 0 when no plan could be made                        */
    char       dim_name[LW_DIM_MAX][16];
    double     dim[LW_DIM_MAX];               /* [m] or [rad]                                        */
    lw_dim_kind dim_kind[LW_DIM_MAX];
    int        dim_link[LW_DIM_MAX];
    char       note[256];                     /* why it does not move; "" when it does               */
} lw_scene;

typedef struct lw_scene_options {
    const char *title;            /* NULL: the linkage's name                                        */
    size_t      n_frame;          /* of the motion                                            (120)  */
    size_t      n_curve_point;    /* of each curve, at least                                  (360)  */
    bool        other_branches;   /* curves of the other assembly modes and circuits too     (false) */
    const struct lw_model *model; /* how several inputs move in time; NULL: not said                 */
    double      until;            /* that motion is shown from 0 to here [s]; 0: to where it begins
                                   * again or comes to rest, else 1 s                                */
} lw_scene_options;

lw_scene_options lw_scene_options_default(void);

/* Work out the scene of k.  t (may be NULL) gives the target points.  o NULL: defaults.  A linkage
 * without input or that cannot move, or whose posture does not close, still gives a scene, of one frame and with
 * a note; so does one whose motions end at a dead point, as far as they go.  LW_E_ARG as lw_linkage_check; LW_E_MEMORY.  Free with lw_scene_free, also after a failure. */
lw_status lw_scene_make(const lw_linkage *k, const lw_target *t, const lw_scene_options *o,
                        lw_scene *s, lw_error *e);
void      lw_scene_free(lw_scene *s);

/* Dimension i as people read it: in the linkage's units, and 0 when it is rounding noise (1e-9 of the
 * linkage's size, 1e-12 rad). */
double lw_scene_dimension(const lw_scene *s, int i);

/* Where point p of a link (in the posture shown) is in a frame [m]. */
lw_vec2 lw_scene_at(const lw_scene *s, size_t frame, int link, lw_vec2 p);

#endif
