/* catalogues/exchange/export_space.h - a spatial model as a file that another program runs.
 *
 * As catalogues/exchange/export.h: text in SI units, out is freed after a failure, LW_E_KIND names what the format
 * cannot express: laws and forces that are not constant, elastic links in MJCF, superelements, stops that rebound. */
#ifndef LW_CATALOGUES_EXCHANGE_EXPORT_SPACE_H
#define LW_CATALOGUES_EXCHANGE_EXPORT_SPACE_H

#include "base/bytes.h"
#include "catalogues/exchange/tree.h"
#include "grammar/model/spatial.h"

/* MuJoCo's MJCF. Bodies are the links, nested along a spanning tree of the joints, parallel to the world in the posture
 * of the file; equality constraints close the other joints. Drives (or the driven inputs) have actuators, whose
 * controls are the coordinates of their joints. Velocities at the start are in the keyframe. */
lw_status lw_export_space_mjcf(const lw_spatial *m, lw_bytes *out, lw_error *e);

/* A dataset of ADAMS/Solver, and the commands that run it. An elastic link is a part for each node (link i of the expanded model,
 * mbs/elastic/expand_space.h, is part i + 1) and a BEAM for each element. Motions of inputs are written in the words of ADAMS;
 * LW_E_KIND also: a motion has others (profile, table), a joint has a stop. */
lw_status lw_export_space_adams(const lw_spatial *m, lw_bytes *out, lw_error *e);
lw_status lw_export_space_adams_commands(const lw_spatial *m, lw_bytes *out, lw_error *e);

/* ---- for the writers ------------------------------------------------------------------------------- */

/* Joints that are no revolute or spherical ones first, then driven and loaded ones, spherical ones last. LW_E_KIND: a
 * free joint between two links that move, unless the model is in the plane; LW_E_MEMORY. Free it after a failure too. */
lw_status lw_space_tree_make(const lw_spatial *m, bool plane, lw_export_tree *t, lw_error *e);

/* LW_E_KIND, naming it: a law, a force that varies, an elastic link (beams: a superelement). */
lw_status lw_export_space_loads(const lw_spatial *m, const char *format, bool beams, lw_error *e);

bool lw_space_weighed(const lw_spatial *m);      /* Has a link a mass? */

#endif
