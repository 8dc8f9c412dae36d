/* grammar/topology/multiple.h - a chain with multiple joints: the links on each pin.
 *
 *     1-2-5 1-3 2-4       links count from 1; three links share the first pin
 *
 * A pin that holds d links counts as d - 1 joints of one freedom.  Plain data, copied with '='. */
#ifndef LW_GRAMMAR_TOPOLOGY_MULTIPLE_H
#define LW_GRAMMAR_TOPOLOGY_MULTIPLE_H

#include "grammar/topology/mechanism.h"

#define LW_MULTIPLE_SIZE (LW_JOINT_MAX*12)

typedef struct lw_multiple {
    int      n_link, n_pin;
    uint32_t pin[LW_JOINT_MAX];     /* links on each pin, as bits: two or more; falling by number, then by bits */
} lw_multiple;

/* Bring the pins into their order. */
void lw_multiple_sort(lw_multiple *m);

/* Joints of one freedom: the sum of d - 1.  F = 3 (n_link - 1) - 2 joints. */
int lw_multiple_joints(const lw_multiple *m);

/* One line without line end; returns the length as snprintf does. */
size_t lw_multiple_print(const lw_multiple *m, char *buf, size_t size);

/* Read one line.  LW_E_NOTATION with the column: a link twice on a pin or on no pin, two links on two pins, a pin of one
 * link, more than LW_LINK_MAX links or LW_JOINT_MAX pins. */
lw_status lw_multiple_read(const char *text, size_t size, const char *file, lw_multiple *m, lw_error *e);

/* The same with simple joints alone: every pin of more than two links becomes a link of its own, behind the others,
 * with a joint to each.  axes: these links, as bits.  LW_E_ARG: more than LW_LINK_MAX links or LW_JOINT_MAX joints. */
lw_status lw_multiple_mechanism(const lw_multiple *m, lw_mechanism *out, uint32_t *axes);

#endif
