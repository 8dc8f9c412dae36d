/* catalogues/draw/space_scene.h - everything to show of a spatial model: its links as bars and plates, its joints, the
 * paths of its tracers, and its motion as a list of poses.  Places in metres; no picture yet.
 *
 * The motion is that of the inputs in time if one has a "motion", else the first input through its range, or as far as it
 * can go.  Shapes belong to a link and are given in the posture of the file; a pose moves each link from there. */
#ifndef LW_CATALOGUES_DRAW_SPACE_SCENE_H
#define LW_CATALOGUES_DRAW_SPACE_SCENE_H

#include <signal.h>
#include "catalogues/draw/drawing.h"
#include "grammar/model/spatial.h"

typedef enum lw_space_shape_kind {
    LW_SPACE_BAR,                /* a line from point 0 to 1                                           */
    LW_SPACE_PLATE,              /* a flat polygon: a link, the plane of a planar joint, a weld        */
    LW_SPACE_PIN,                /* an axis from point 0 to 1: hinge, cylinder or screw                */
    LW_SPACE_BALL,               /* at point 0                                                         */
    LW_SPACE_GUIDE,              /* the line of a slide from point 0 to 1                              */
    LW_SPACE_TRACER,             /* at point 0                                                         */
    LW_SPACE_TIE                 /* a spring, a damper or a hydraulic cylinder from point 0 to 1       */
} lw_space_shape_kind;

#define LW_SPACE_POINTS 16

typedef struct lw_space_shape {
    lw_space_shape_kind kind;
    int     link, item;          /* it moves with; number of its link, joint, tracer or spring         */
    int     to;                  /* an elastic element or a tie: the link that its last point moves with; else -1 */
    double  tube;                /* of a cylinder: length of its tube from point 0 on [m]; 0           */
    bool    grounded;            /* a joint at the ground                                              */
    int     n;
    lw_vec3 p[LW_SPACE_POINTS];  /* in the posture of the file [m]                                     */
} lw_space_shape;

/* A point p of a link is at  at + turn (p - origin). */
typedef struct lw_space_pose { lw_vec3 at; lw_quaternion turn; } lw_space_pose;

typedef struct lw_space_scene {
    const lw_spatial *model;     /* its names and units are shown; it outlives the scene              */
    char     title[128];
    char     note[256];          /* why it does not move, or stops; "" when there is nothing to say    */
    int      n_link, n_tracer, n_shape;
    lw_space_shape *shape;       /* (n_shape)                                                          */
    lw_vec3 *origin;             /* (n_link) reference point of each link in the posture of the file   */
    size_t   n_frame;            /* 1: it does not move                                                */
    bool     loops;              /* the first pose follows the last; else the motion goes back and forth, */
    bool     ends;               /* or ends and begins anew                                            */
    double   seconds;            /* that the frames last; 0: the motion is not in time                 */
    lw_space_pose *pose;         /* [frame*n_link + link]                                              */
    size_t   n_path;             /* points of each path: those of the frames, in time or by the input also some between */
    lw_vec3 *path;               /* [point*n_tracer + tracer]                                          */
    lw_vec3  up, middle;         /* upwards: against gravity, or z; middle and radius of all places    */
    double   radius;
    const volatile sig_atomic_t *stop;       /* ends an animation after the frame that is drawn; may be NULL */
} lw_space_scene;

typedef struct lw_space_scene_options {
    const char *title;           /* NULL: the name of the model                                        */
    size_t      n_frame;         /* of the motion (120)                                                */
    double      until;           /* length of a motion in time [s]; 0: until the inputs repeat or come to rest, else 1 s */
    const lw_space_pose *pose;   /* a motion that is known [frame*n_link + link]; NULL: that of the inputs */
    const lw_vec3 *path, *origin;            /* its [frame*n_tracer + tracer] and (n_link), as of the scene */
    const volatile sig_atomic_t *stop;      /* the motion ends there, with a note; may be NULL         */
} lw_space_scene_options;

/* LW_E_MEMORY.  A model that cannot move gives one pose and a note.  Free it also after a failure. */
lw_status lw_space_scene_make(const lw_spatial *m, const lw_space_scene_options *o, lw_space_scene *s, lw_error *e);
void      lw_space_scene_free(lw_space_scene *s);

/* Place of a point of a link in a frame. */
lw_vec3 lw_space_scene_at(const lw_space_scene *s, size_t frame, int link, lw_vec3 p);

/* Point k of a shape in a frame. */
lw_vec3 lw_space_scene_point(const lw_space_scene *s, size_t frame, const lw_space_shape *shape, int k);

/* Seen from a direction: azimuth about the upward axis, elevation above the level plane [rad].  names: of links and tracers,
 * as far as there is room, for still pictures. */
typedef struct lw_space_view { double azimuth, elevation; bool names; } lw_space_view;
lw_space_view lw_space_view_default(void);           /* 35 degrees, 25 degrees */

/* Axes of the picture: to the right, upwards, to the viewer. */
void lw_space_view_axes(const lw_space_scene *s, lw_space_view view, lw_vec3 axis[3]);

/* A parallel projection of a frame [px] with a scale bar; what is nearer covers what is farther.  The scale is the same for all frames. */
lw_status lw_space_draw(const lw_space_scene *s, size_t frame, lw_space_view view, int width, int height, lw_drawing *d, lw_error *e);

#endif
