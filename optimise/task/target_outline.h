/* optimise/task/target_outline.h - targets from drawings: one curve out of an SVG or a DXF file.
 *
 *     SVG   the first <path> (M L H V C S Q T A Z, either case), <polyline> or <polygon> that is shown, with the
 *           transforms of its groups.  y of an SVG runs down and is turned up: (x, y) becomes the station (x, -y).
 *           Lengths are millimetres unless width and viewBox of the file say what a unit is.
 *     DXF   the one LWPOLYLINE or POLYLINE of the file (with bulges), else its LINEs, ARCs and CIRCLE, which must
 *           make one curve.  Lengths are millimetres unless $INSUNITS says otherwise.
 *
 * The corners of a polygon are the stations, as many as there are; anything bent becomes
 * LW_OUTLINE_STATIONS stations in equal steps along it.  A curve is closed when it ends where it begins or the file
 * says so.  The options are those of target.h, a length unit overrules the file. */
#ifndef LW_OPTIMISE_TASK_TARGET_OUTLINE_H
#define LW_OPTIMISE_TASK_TARGET_OUTLINE_H

#include "optimise/task/target.h"

#define LW_OUTLINE_STATIONS 60

/* Read a target from a drawing. LW_E_NOTATION with line and column; LW_E_ARG for options; t is set as by
 * lw_target_read. */
lw_status lw_target_read_svg(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t,
                             lw_error *e);
lw_status lw_target_read_dxf(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t,
                             lw_error *e);

#endif
