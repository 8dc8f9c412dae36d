/* grammar/topology/franke.h - Franke's notation (Makkonen 1999, section 3.2): circles are links with three or
 * more joints, lines are strings of w >= 0 binary links.
 *
 *     (3 3) 1-2:0 1-2:2 1-2:2        Watt: two circles of three joints, lines with 0, 2, 2 binary links
 *     () :4                          the four-bar: one closed line, no circle
 *
 * A line may begin and end at the same circle (a chain fractionated at that link).  This
 * notation cannot express joints of two freedoms. */
#ifndef LW_GRAMMAR_TOPOLOGY_FRANKE_H
#define LW_GRAMMAR_TOPOLOGY_FRANKE_H

#include <stddef.h>
#include "grammar/topology/chain.h"

#define LW_FRANKE_LINE_MAX 64
#define LW_FRANKE_SIZE     (LW_LINK_MAX*3 + LW_FRANKE_LINE_MAX*12)

typedef struct lw_franke {
    int     n_circle, n_line;                   /* n_circle 0: a ring, its one line closed               */
    uint8_t end[LW_FRANKE_LINE_MAX][2];         /* circles from 0, the lower first; rows in rising order */
    uint8_t weight[LW_FRANKE_LINE_MAX];         /* binary links; in rising order among equal rows        */
} lw_franke;

/* Circles are numbered in the order of their links.  LW_E_KIND: joints of two freedoms; LW_E_ARG: not
 * connected, a link with fewer than two joints, more than LW_FRANKE_LINE_MAX lines. */
lw_status lw_franke_from_chain(const lw_chain *c, lw_franke *f);

/* The chain: links 0 .. n_circle-1 are the circles, then the binary links line by line.  LW_E_ARG: more
 * than LW_LINK_MAX links, two joints between the same two links, a link joined to itself, not
 * connected, a circle on fewer than three lines. */
lw_status lw_franke_chain(const lw_franke *f, lw_chain *c);

/* One line without line end; returns the length as snprintf does. */
size_t lw_franke_print(const lw_franke *f, char *buf, size_t size);

/* Read one line and check it as lw_franke_chain does; lines may stand in any order.  LW_E_NOTATION with
 * the column, also when the number given for a circle is not the number of lines that end there. */
lw_status lw_franke_read(const char *text, size_t size, const char *file, lw_franke *f, lw_error *e);

#endif
