/* catalogues/draw/draft.h - a motion quickly, for a linkage that is being dragged: postures by Newton's method
 * (mbs/constraints/newton.h), the curves smooth through them.  Nothing proves that the motion stays on its branch between
 * two postures, and past a limit of the input the other assembly mode is left out: lw_scene_make without `draft` does both. */
#ifndef LW_CATALOGUES_DRAW_DRAFT_H
#define LW_CATALOGUES_DRAW_DRAFT_H

#include "catalogues/draw/scene.h"

/* Fill frames of s, which has its linkage and origins: a full turn of the input or as many as bring back the posture,
 * else from limit to limit; only the inputs range[0] to range[1], if range is not NULL.  Fails, with s unchanged, as
 * lw_newton_create and lw_newton_move do. */
lw_status lw_draft_frames(lw_scene *s, const double *range, size_t n);

/* Curves of all tracers through the frames, with about n points each: cubics with the slopes of Catmull and Rom. */
lw_status lw_draft_curves(lw_scene *s, size_t n);

/* Drop every second frame, but not the one of the posture shown. */
void      lw_draft_thin(lw_scene *s);

#endif
