/* catalogues/exchange/start.h - velocities of the links at the start of a run, for formats that hold them. */
#ifndef LW_CATALOGUES_EXCHANGE_START_H
#define LW_CATALOGUES_EXCHANGE_START_H

#include "base/vec3.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"

/* Of a link: of its point at the origin [m/s], and of its turn [rad/s]. */
typedef struct lw_export_twist { lw_vec3 velocity, omega; } lw_export_twist;

/* Velocities of the links of m with its elastic links expanded (m itself without those), as a run begins.  *out (n_link of expanded):
 * to be freed; NULL: all links start at rest, or none has a mass. LW_E_KIND: some input has a motion and another part a speed;
 * failures of lw_dynamics_make_spatial. */
lw_status lw_export_space_start(const lw_spatial *m, const lw_spatial *expanded, lw_export_twist **out, lw_error *e);

/* The same of a planar model, in the plane z = 0; m NULL: at rest.  Failures of lw_dynamics_make too. */
lw_status lw_export_start(const lw_model *m, lw_export_twist **out, lw_error *e);

/* Velocity of `link` against `from`: of a point, and of the turn.  all NULL: 0. */
lw_export_twist lw_export_relative(const lw_export_twist *all, int link, int from, lw_vec3 at);

#endif
