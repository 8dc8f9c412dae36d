/* mbs/plan/types.h - the four-link chains with a crank or slider input, by name.
 *
 * Letters name the joints in loop order, starting with the input joint at the ground.  The tracer is on the coupler,
 * the link without a ground joint.
 *     RRRR four-bar             RRRP slider-crank          RRPR inverted slider-crank
 *     RPRR slotted crank        PRRP elliptic trammel      PRRR slider-driven crank
 *     RPRP  RRPP  RPPR  PRPR  PPRR   the other chains with F = 1 */
#ifndef LW_MBS_PLAN_TYPES_H
#define LW_MBS_PLAN_TYPES_H

#include "mbs/plan/plan.h"

typedef struct lw_type {
    const char *letters;        /* "RRRR"                                                         */
    const char *name;           /* "fourbar": the value of --type                                  */
    const char *title;          /* "four-bar"                                                     */
    bool        input_is_slider;
} lw_type;

/* The table; ends with letters == NULL. */
extern const lw_type lw_type_table[];

/* The type of this name or these letters; NULL when there is none. */
const lw_type *lw_type_find(const char *name_or_letters);

/* Make a linkage of this type in a posture that is not singular, for lw_plan_make.  Links: ground, crank (or slider),
 * coupler, rocker (or slider, block). */
void lw_type_linkage(const lw_type *type, lw_linkage *linkage);

#endif
