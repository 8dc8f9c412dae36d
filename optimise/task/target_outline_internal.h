/* optimise/task/target_outline_internal.h - a curve that is read from a drawing, point by point. */
#ifndef LW_OPTIMISE_TASK_TARGET_OUTLINE_INTERNAL_H
#define LW_OPTIMISE_TASK_TARGET_OUTLINE_INTERNAL_H

#include "base/vec2.h"
#include "optimise/task/target_outline.h"

#define LW_OUTLINE_MAX  1000000       /* points of a curve                                          */
#define LW_OUTLINE_ARCS 128           /* steps of a curve segment, or of a turn of an arc           */

typedef struct lw_outline {
    size_t   n, room;
    lw_vec2 *p;                       /* malloc; in the drawing's units                             */
    long    *line;                    /* line of the file of each point                             */
    bool     curved;                  /* a part of it is curved                                     */
    bool     closed;                  /* the file says so                                           */
    bool     failed;                  /* no memory, or more than LW_OUTLINE_MAX                     */
} lw_outline;

void lw_outline_free(lw_outline *c);
void lw_outline_add(lw_outline *c, lw_vec2 p, long line);        /* a repeated point is passed over  */

/* Add an arc from the last point of c about `at` by `sweep` [rad, either direction]; it ends exactly at `end`. */
void lw_outline_arc(lw_outline *c, lw_vec2 at, double sweep, lw_vec2 end, long line);

/* Make stations in metres; unit: name of the drawing's length unit. Frees c. */
lw_status lw_outline_target(lw_outline *c, const char *file, const char *unit, const lw_target_options *o, lw_target *t,
                            lw_error *e);

#endif
