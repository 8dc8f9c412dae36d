/* catalogues/draw/run_scene.h - a scene whose frames are the postures of a simulated planar model. */
#ifndef LW_CATALOGUES_DRAW_RUN_SCENE_H
#define LW_CATALOGUES_DRAW_RUN_SCENE_H

#include "catalogues/draw/scene.h"
#include "mbs/dynamics/dynamics.h"

/* q: n postures of lw_dynamics_system(d), the equations of m, which outlives the scene.  The curves are the paths of the tracers over
 * these postures; elastic links bend.  LW_E_MEMORY.  Free the scene with lw_scene_free, also after a failure. */
lw_status lw_scene_of_run(const lw_model *m, const lw_dynamics *d, size_t n, const double *q, lw_scene *scene, lw_error *e);

#endif
