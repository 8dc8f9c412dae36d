/* catalogues/draw/scene_internal.h - the steps of making a scene: what scene_frames.c, scene_draft.c, scene.c and scene_model.c share. */
#ifndef LW_CATALOGUES_DRAW_SCENE_INTERNAL_H
#define LW_CATALOGUES_DRAW_SCENE_INTERNAL_H

#include "catalogues/draw/motion_path.h"
#include "catalogues/draw/scene.h"
#include "catalogues/draw/walk.h"

/* Data that the steps of lw_scene_make share. */
typedef struct lw_scene_work {
    lw_scene  *s;
    const lw_linkage *given;
    lw_linkage linkage;                    /* with an extra tracer for every link without a pin    */
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    int        pin[LW_LINK_MAX];           /* a joint of the link, or -1 - (index of its tracer)   */
    lw_posture    start, posture;          /* posture shown; posture being computed                */
    lw_motion  motion;
    lw_walk    walk;                       /* through the circuit that holds the posture shown     */
    bool       by_path;                    /* no closed-form plan: the motion comes from `path`, not from `walk` */
    lw_motion_path path;
    double     q[LW_SYSTEM_Q_MAX];         /* coordinates of the posture being computed             */
    bool       no_memory;                  /* while looking for a plan or a walk                    */
} lw_scene_work;

static inline bool lw_scene_work_is_stopped(const lw_scene_work *w) { return w->s->stop && *w->s->stop; }

/* The motion runs over t = 0 .. lw_scene_work_length. */
static inline double lw_scene_work_length(const lw_scene_work *w) { return w->by_path ? 1 : w->walk.n_stage; }

static inline bool lw_scene_work_loops(const lw_scene_work *w) { return w->by_path ? w->path.loops : w->walk.loops; }

/* ---- scene_frames.c ----------------------------------------------------------------------------------------- */

/* Title, parts, target and room of a scene.  False: out of memory, in all of these. */
bool lw_scene_begin(lw_scene *s, const lw_assembly *parts, const lw_target *t, const lw_scene_options *o);

/* Room for n frames, all in the posture shown. */
bool lw_scene_make_frames(lw_scene *s, size_t n);

/* Fill the frames of the motion: place of each link relative to the posture shown. */
bool lw_scene_take_frames(lw_scene_work *w, size_t n);

/* Size of the linkage: diagonal of the box around its joints, in the posture shown. */
double lw_scene_span(const lw_assembly *linkage);

/* Make plan, dimensions and starting posture. False: there is no plan in closed form, or the posture does not close.
 * Dimensions are filled whenever there is a plan. */
bool lw_scene_work_prepare(lw_scene_work *w);

/* Move to t of the motion. Returns the input there. */
double lw_scene_work_move_to(lw_scene_work *w, double t);

/* The place of the reference point of a link in a posture. */
lw_vec2 lw_scene_work_reference(const lw_scene_work *w, const lw_posture *posture, int link);

/* ---- scene_draft.c ------------------------------------------------------------------------------------------- */

/* Frames of w, and curves through twice as many.  False: out of memory. */
bool lw_scene_draft_frames(lw_scene_work *w, const lw_scene_options *o);

/* The walk from the posture shown, along the plan: a full turn, or from limit to limit and back in the other assembly
 * modes.  False: near a change point. */
bool lw_scene_draft_walk(lw_scene_work *w);

/* Curves of all tracers through the frames, with about n points each: cubics with the slopes of Catmull and Rom. */
lw_status lw_scene_draft_curves(lw_scene *s, size_t n);

/* Drop every second frame, but not the one of the posture shown. */
void lw_scene_draft_thin(lw_scene *s);

/* The draft of any linkage by steps.  LW_E_MEMORY, LW_E_ARG: as lw_newton_create, without a scene.  Other faults of
 * lw_newton_create give a scene that does not move. */
lw_status lw_scene_draft_steps(lw_scene *s, const lw_linkage *linkage, const double *range, const lw_scene_options *o);

/* ---- scene.c ------------------------------------------------------------------------------------------------ */

/* How long a motion in time is shown [s]. */
lw_status lw_scene_duration(const lw_model *m, const lw_scene_options *o, double *out);

#endif
