/* optimise/task/target_outline.h - targets from drawings: curves of an SVG or a DXF file.
 *
 *     SVG   path, polyline, polygon, line, rect, circle, ellipse and clones of them (use), with all transforms.  Each
 *           part of a path that begins with M is a curve.  What is hidden or only defined is left out.  y runs down in
 *           an SVG and is turned up: (x, y) becomes the station (x, -y).
 *     DXF   LINE, ARC, CIRCLE, ELLIPSE, SPLINE, LWPOLYLINE, POLYLINE, and INSERTs of blocks that hold them.  Open
 *           pieces of one layer that meet end to end, two at a point, are one curve.  Layers that are off or frozen,
 *           and the paper space, are left out.  A drawing of POINTs alone gives them as stations, in their order.
 *
 * A drawing with one curve is a target.  Of several curves the options name one, or up to LW_ALSO_MAX + 1, which become
 * the points of one linkage.  Stations are placed by length and curvature; corners are stations.  A curve is closed if
 * the file says so, or if the gap between its ends is at most a twentieth of its length.
 *
 * Unit: that of the file ($INSUNITS; width, height and viewBox), else the millimetre; the options overrule it. */
#ifndef LW_OPTIMISE_TASK_TARGET_OUTLINE_H
#define LW_OPTIMISE_TASK_TARGET_OUTLINE_H

#include "optimise/task/target.h"

#define LW_OUTLINE_STATIONS 60

/* Read a target from a drawing. LW_E_NOTATION with line and column; LW_E_ARG for options; t is set as by
 * lw_target_read. */
lw_status lw_target_read_svg(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);
lw_status lw_target_read_dxf(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);

#endif
