/* grammar/topology/derivation.h - derivations of structures as text (the ears of structure.h).
 *
 *     theta 1(1,2) 3(2,5)         seed; rule 1 between circles 1 and 2; rule 3 between lines 2 and 5
 *
 * Circles and lines count from 1, lines in the order of the structure before the ear; rule 2 is
 * 2(circle,line), rule 4 is 4(line). */
#ifndef LW_GRAMMAR_TOPOLOGY_DERIVATION_H
#define LW_GRAMMAR_TOPOLOGY_DERIVATION_H

#include <stddef.h>
#include "grammar/topology/structure.h"

#define LW_DERIVATION_SIZE (8 + 10*LW_LOOP_MAX)

/* One line without line end; returns the length as snprintf does. */
size_t lw_derivation_print(const lw_derivation *d, char *buf, size_t size);

/* Read one line, with or without line end, and replay it.  LW_E_NOTATION with the column: no seed, an unknown
 * rule, a circle or line that does not exist at that step, too many ears. */
lw_status lw_derivation_read(const char *text, size_t size, const char *file, lw_derivation *d, lw_error *e);

/* "(3 3 4) 1-2 1-3 ...": lines at each circle, then the lines; no line end.  Length as snprintf does. */
#define LW_STRUCTURE_SIZE (4*LW_CIRCLE_MAX + 6*LW_LINE_MAX + 4)
size_t lw_structure_print(const lw_structure *s, char *buf, size_t size);

#endif
