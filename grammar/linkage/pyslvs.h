/* grammar/linkage/pyslvs.h - the mechanism expression of Pyslvs (docs/notation.md, "Pyslvs"):
 *
 *     M[J[R, color[Green], P[0, 0], L[ground, crank]], J[P, A[30], P[51.4, -12.6], L[ground, slider]]]
 *
 * The grammar is that of pyslvs.expression_parser (pyslvs 19 to 22).  It has no inputs.  linkwright writes them in a
 * comment behind the expression, "# input 0 1": the point at the base and the point on the driven link, as in
 * Pyslvs' examples. */
#ifndef LW_GRAMMAR_LINKAGE_PYSLVS_H
#define LW_GRAMMAR_LINKAGE_PYSLVS_H

#include "grammar/linkage/assembly.h"

/* Lengths are in units->length.  Joints and tracers are named P0, P1, ... after the numbers of the points; several
 * links at one point make several joints, P3, P3_1, ...  LW_E_NOTATION with line and column.
 * Free the linkage by lw_assembly_free. */
lw_status lw_pyslvs_read(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e);

/* In its units; free with free().  NULL with e filled: LW_E_KIND for gears and welds,
 * LW_E_MEMORY.  The text does not contain ranges of inputs, input values that differ from the posture, and
 * directions of tools. */
char *lw_pyslvs_write(const lw_assembly *linkage, lw_error *e);

#endif
