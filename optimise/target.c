/* The stations of a target in memory: allocation, checks, size. */
#include "optimise/target_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double *lw_target_array(const lw_target *t, lw_field role)
{
    switch (role) {
    case LW_FIELD_X:      return t->x;
    case LW_FIELD_Y:      return t->y;
    case LW_FIELD_THETA:  return t->theta;
    case LW_FIELD_ANGLE:  return t->angle;
    case LW_FIELD_WEIGHT: return t->weight;
    case LW_FIELD_COUNT:  break;
    }
    return NULL;
}

lw_status lw_target_allocate(lw_target *t, size_t n, const bool has[LW_FIELD_COUNT], lw_error *e)
{
    double *p[LW_FIELD_COUNT] = { NULL };
    *t = (lw_target){ .n = n, .units = lw_units_si() };
    double *block = malloc(n*(LW_FIELD_COUNT*sizeof(double) + sizeof(long)));
    if (!block)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", n);
    t->store = block;
    for (int role = 0; role < LW_FIELD_COUNT; role++)
        if (has[role] || role == LW_FIELD_WEIGHT)
            p[role] = block + (size_t)role*n;
    t->x = p[LW_FIELD_X];
    t->y = p[LW_FIELD_Y];
    t->theta = p[LW_FIELD_THETA];
    t->angle = p[LW_FIELD_ANGLE];
    t->weight = p[LW_FIELD_WEIGHT];
    t->line = (long *)(block + (size_t)LW_FIELD_COUNT*n);
    for (size_t i = 0; i < n; i++) {
        t->weight[i] = 1;
        t->line[i] = 0;
    }
    return LW_OK;
}

void lw_target_free(lw_target *t)
{
    free(t->store);
    *t = (lw_target){ .n = 0 };
}

static lw_status check_weights(const lw_target *t, lw_target_place *place, lw_error *e)
{
    double most = 0;
    for (size_t i = 0; i < t->n; i++) {
        *place = (lw_target_place){ i, LW_FIELD_WEIGHT };
        if (!(t->weight[i] >= 0))
            return lw_error_set(e, LW_E_ARG, "a weight is at least 0, this one is %g; 0 leaves the station out",
                                t->weight[i]);
        most = fmax(most, t->weight[i]);
    }
    place->station = 0;
    return most > 0 ? LW_OK : lw_error_set(e, LW_E_ARG, "all weights are 0, so nothing is asked for; give one "
                                           "station at least a positive weight");
}

static double step(const lw_target *t, size_t i, size_t k)
{
    return hypot(t->x[k] - t->x[i], t->y[k] - t->y[i]);
}

/* Bounding box, closed or not (by guess: the gap is no longer than one and a half of the longest step,
 * or than a twentieth of the path: dense curves need not end at their beginning), length. */
static void measure(lw_target *t, int closed)
{
    lw_vec2 lo = { t->x[0], t->y[0] }, hi = lo;
    double longest = 0;
    for (size_t i = 1; i < t->n; i++) {
        double d = step(t, i - 1, i);
        lo = lw_v2(fmin(lo.x, t->x[i]), fmin(lo.y, t->y[i]));
        hi = lw_v2(fmax(hi.x, t->x[i]), fmax(hi.y, t->y[i]));
        longest = fmax(longest, d);
        t->length += d;
    }
    double gap = step(t, t->n - 1, 0);
    t->size = hypot(hi.x - lo.x, hi.y - lo.y);
    t->closed = closed >= 0 ? closed > 0 : t->n > 2 && t->size > 0 && gap <= fmax(1.5*longest, t->length/20);
    if (t->closed)
        t->length += gap;
}

lw_status lw_target_finish(lw_target *t, int closed, lw_target_place *place, lw_error *e)
{
    lw_status s = check_weights(t, place, e);
    if (s != LW_OK)
        return s;
    if (t->x)
        measure(t, closed);
    else
        t->closed = closed > 0;
    return t->angle ? lw_target_order(t, place, e) : LW_OK;
}

static lw_status fill(lw_target *t, const double *const from[LW_FIELD_COUNT], lw_error *e)
{
    for (int role = 0; role < LW_FIELD_COUNT; role++) {
        double *to = lw_target_array(t, (lw_field)role);
        double most = lw_field_most((lw_field)role);
        for (size_t i = 0; from[role] && i < t->n; i++) {
            if (!(fabs(from[role][i]) <= most))
                return lw_error_set(e, LW_E_ARG, "station %zu has a number that is not finite or beyond %g", i + 1,
                                    most);
            to[i] = from[role][i];
        }
    }
    return LW_OK;
}

lw_status lw_target_make(size_t n, const double *x, const double *y, const double *theta, const double *angle,
                         const double *weight, int closed, lw_target *t, lw_error *e)
{
    const double *const from[LW_FIELD_COUNT] = { x, y, theta, angle, weight };
    bool has[LW_FIELD_COUNT];
    lw_target_place place;
    *t = (lw_target){ .n = 0 };
    for (int role = 0; role < LW_FIELD_COUNT; role++)
        has[role] = from[role] != NULL;
    if (n < 1 || n > LW_STATION_MAX)
        return lw_error_set(e, LW_E_ARG, "a target has 1 to %d stations, not %zu", LW_STATION_MAX, n);
    if (!x != !y || (!x && !(theta && angle)))
        return lw_error_set(e, LW_E_ARG, "a path needs x and y, a function angle and theta");
    lw_status s = lw_target_allocate(t, n, has, e);
    if (s == LW_OK)
        s = fill(t, from, e);
    if (s == LW_OK)
        s = lw_target_finish(t, closed, &place, e);
    if (s != LW_OK)
        lw_target_free(t);
    return s;
}
