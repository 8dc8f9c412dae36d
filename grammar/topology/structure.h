/* grammar/topology/structure.h - Franke structures: circles (links with three joints or more) and lines
 * (strings of binary links), and the ear rules that grow them.
 *
 * A structure is a multigraph, 2-connected, without self-loops, every circle on three lines or more.
 * Circles are numbered from 0.  Lines are kept sorted by their circles, lower circle first, so that
 * parallel lines stand side by side.  Plain data, copied with '='; nothing here allocates. */
#ifndef LW_GRAMMAR_TOPOLOGY_STRUCTURE_H
#define LW_GRAMMAR_TOPOLOGY_STRUCTURE_H

#include <stdbool.h>
#include <stdint.h>
#include "base/error.h"
#include "grammar/topology/chain.h"

/* 15 loops are the most that chains of LW_LINK_MAX links have (P = 2 L + F + 1); then there are at
 * most 2 (L - 1) circles and 3 (L - 1) lines. */
#define LW_LOOP_MAX   15
#define LW_CIRCLE_MAX (2*(LW_LOOP_MAX - 1))
#define LW_LINE_MAX   (3*(LW_LOOP_MAX - 1))

typedef struct lw_structure {
    uint8_t n_circle, n_line;
    uint8_t end[LW_LINE_MAX][2];     /* circles joined, [0] < [1], rows in rising order; unused 0 */
} lw_structure;

/* L = E - V + 1. */
static inline int lw_structure_loops(const lw_structure *s) { return s->n_line - s->n_circle + 1; }

/* Lines at each circle.  degree (n_circle). */
void lw_structure_degrees(const lw_structure *s, uint8_t *degree);

/* Circles next to each circle, as bits.  row (n_circle). */
void lw_structure_rows(const lw_structure *s, uint32_t *row);

/* True if removing line `line` leaves a structure with one loop less (a circle that keeps two lines becomes a point
 * of a line).  False for every line of the theta structure. */
bool lw_structure_removable(const lw_structure *s, int line);

/* Rename circle i to to[i] and sort the lines again. */
void lw_structure_relabel(const lw_structure *s, const uint8_t *to, lw_structure *out);

bool lw_structure_same(const lw_structure *a, const lw_structure *b);

/* The chain with weight[e] >= 0 binary links on line e.  Links 0 .. V-1 are the circles; the binary links follow
 * line by line, from end[0] to end[1].  LW_E_ARG, *c unspecified, when there are more than LW_LINK_MAX links or
 * two parallel lines have no binary link. */
lw_status lw_structure_chain(const lw_structure *s, const uint8_t *weight, lw_chain *c);

/* ---- ears: Whitney's decomposition as a grammar -------------------------------------------------
 * Every structure comes from the theta structure by adding one line at a time (Whitney 1932). */
typedef enum lw_ear_rule {
    LW_EAR_CIRCLES = 1,        /* between two circles a < b                                          */
    LW_EAR_CIRCLE_LINE,        /* between circle a and a new circle on line b                        */
    LW_EAR_LINES,              /* between new circles on two lines a < b                             */
    LW_EAR_LINE                /* between two new circles on line a = b                              */
} lw_ear_rule;

typedef struct lw_ear { uint8_t rule, a, b; } lw_ear;

/* A structure with L loops grows from the theta structure by L - 2 ears; a and b number the circles
 * and lines of the structure before the ear.  New circles get the next numbers. */
typedef struct lw_derivation {
    int    n_ear;
    lw_ear ear[LW_LOOP_MAX - 2];
} lw_derivation;

/* Two circles, three lines. */
lw_structure lw_structure_theta(void);

/* out = s with an ear; out may be s.  LW_E_ARG, out untouched, when a or b is out of range or the result
 * would have more than LW_LOOP_MAX loops. */
lw_status lw_structure_grow(const lw_structure *s, lw_ear ear, lw_structure *out);

/* Replay a derivation. */
lw_status lw_derivation_replay(const lw_derivation *d, lw_structure *out);

#endif
