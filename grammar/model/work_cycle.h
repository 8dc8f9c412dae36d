/* grammar/model/work_cycle.h - the cycle of a machine with several axes: moves one after the other or overlapping, with
 * payloads and rests; each in least time within the limits of its axes (docs/profile.md, "Work cycles"). */
#ifndef LW_GRAMMAR_MODEL_WORK_CYCLE_H
#define LW_GRAMMAR_MODEL_WORK_CYCLE_H

#include <stdbool.h>
#include "grammar/functions/profile.h"

#define LW_CYCLE_NAME 64

typedef struct lw_cycle_axis { char name[LW_CYCLE_NAME]; lw_axis_limits limits; double start; } lw_cycle_axis;

typedef struct lw_cycle_move {
    char        name[LW_CYCLE_NAME];
    double      start, duration, dwell;  /* [s]; the rest follows the move */
    double      payload;                 /* [kg] */
    bool       *moves;                   /* (n_axis) */
    double     *to;                      /* (n_axis) goals */
    lw_profile *profile;                 /* (n_axis) its time begins at 0 */
} lw_cycle_move;

struct lw_work_cycle {
    char           name[256];
    int            n_axis, n_move;
    lw_cycle_axis *axis;
    lw_cycle_move *move;
    double         end;                  /* of all moves and rests [s] */
    double         wanted;               /* greatest time of the cycle [s]; 0: not given */
};

/* Read and plan.  LW_E_NOTATION with line and column, also for moves that the limits do not allow; then
 * there is nothing to free. */
lw_status lw_work_cycle_read(const char *text, size_t size, const char *file, lw_work_cycle *c, lw_error *e);
void      lw_work_cycle_free(lw_work_cycle *c);

/* lw_work_cycle_at and lw_work_cycle_payload are declared in linkwright.h. */

#endif
