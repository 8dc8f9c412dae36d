/* grammar/functions/moves.h - the motion of an axis as a list of moves from rest to rest with rests between them: in least time within
 * limits, in a given time, or by a law of motion; as model files and servo axes give it. */
#ifndef LW_GRAMMAR_FUNCTIONS_MOVES_H
#define LW_GRAMMAR_FUNCTIONS_MOVES_H

#include "grammar/functions/profile.h"
#include "grammar/text/json_internal.h"

typedef struct lw_move {                 /* then rest until the next one */
    double start, duration, from, way;
    int    law;                          /* grammar/functions/motion_law.h; -1: the profile */
    lw_profile profile;                  /* its time begins at 0 */
} lw_move;

typedef struct lw_moves {
    char     name[32];                   /* first, for lw_moves_find */
    int      n;
    lw_move *move;
    double   end;                        /* of the last move */
} lw_moves;

/* From the keys "speed", "acceleration", "jerk" (limits), "from" (0), "start" (0 s) and "moves" of an object, in SI
 * units.  m needs lw_moves_free also after a failure. */
lw_status lw_moves_read(const lw_json_node *object, lw_moves *m, lw_error *e);
void      lw_moves_free(lw_moves *m);

/* The list "profiles" of a model into *all (*n), which is allocated and needs lw_moves_free for each, then free(), also
 * after a failure.  The one of a name; NULL: there is none; json as in lw_read_find. */
lw_status lw_moves_read_profiles(const lw_json_node *root, int *n, lw_moves **all, lw_error *e);
const lw_moves *lw_moves_find(lw_json *json, int n, const lw_moves *all, const char *name);

/* Taylor coefficients 0 .. order <= 8 of the position at t; at a kink (direction < 0) those before it, else behind it. */
void lw_moves_series(const lw_moves *m, double t, int direction, int order, double *out);

lw_axis_state lw_moves_at(const lw_moves *m, double t);

/* The first time after t at which the acceleration or the jerk steps; infinite: none. */
double lw_moves_next_kink(const lw_moves *m, double t);

#endif
