/* mbs/plan/types.h - the four-link chains with a crank or slider input, by name.
 *
 * Letters name the joints in loop order starting with the input joint at the ground; the tracer sits
 * on the coupler (the link that touches neither ground joint).
 *     RRRR four-bar             RRRP slider-crank          RRPR inverted slider-crank
 *     RPRR slotted crank        PRRP elliptic trammel      PRRR slider-driven crank
 *     RPRP  RRPP  RPPR  PRPR ...  the rest that moves with F = 1 */
#ifndef LW_MBS_PLAN_TYPES_H
#define LW_MBS_PLAN_TYPES_H

#include "mbs/plan/plan.h"

typedef struct lw_type {
    const char *letters;        /* "RRRR"                                                         */
    const char *name;           /* "fourbar": what --type takes                                   */
    const char *title;          /* "four-bar"                                                     */
    bool        input_is_slider;
} lw_type;

/* The table; ends with letters == NULL. */
extern const lw_type lw_type_table[];

const lw_type *lw_type_find(const char *name_or_letters);

/* A linkage of this type in some non-singular posture: gives the topology from which lw_plan_make
 * makes the plan.  Links: ground, crank (or slider), coupler, rocker (or slider, block). */
void lw_type_linkage(const lw_type *t, lw_linkage *k);

#endif
