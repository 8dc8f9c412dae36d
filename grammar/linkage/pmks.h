/* grammar/linkage/pmks.h - the joint table of PMKS, the Planar Mechanism Kinematic Simulator, as text
 * (docs/notation.md, "PMKS"):
 *
 *     ground,crank,R,0,0,ffft
 *     crank,rod,R,0,30,tfff
 *     ground,rod,RP,80,0,15,ffff
 *
 * One joint on each line (or between bars, as in web addresses of PMKS): links, kind, x, y, angle of a slide line in
 * degrees, and four letters t or f: show position, show velocity, show acceleration, joint is driven. */
#ifndef LW_GRAMMAR_LINKAGE_PMKS_H
#define LW_GRAMMAR_LINKAGE_PMKS_H

#include "grammar/linkage/assembly.h"

/* As lw_pyslvs_read.  If no joint is marked as driven, the first one between the ground and a link named "input" is. */
lw_status lw_pmks_read(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e);

/* As lw_pyslvs_write. */
char *lw_pmks_write(const lw_assembly *linkage, lw_error *e);

#endif
