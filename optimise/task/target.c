/* The stations of a target in memory: allocation, checks, size. */
#include "base/real.h"
#include "optimise/task/target_internal.h"

#include <stdlib.h>

#include "base/linalg.h"

#define TURN      (2*LW_PI)
#define ANGLE_EPS 1e-9               /* angles closer than this part of a turn are equal */

double *lw_target_array(const lw_target *t, lw_target_field role)
{
    switch (role) {
    case LW_TARGET_FIELD_X:      return t->x;
    case LW_TARGET_FIELD_Y:      return t->y;
    case LW_TARGET_FIELD_THETA:  return t->theta;
    case LW_TARGET_FIELD_ANGLE:  return t->angle;
    case LW_TARGET_FIELD_WEIGHT: return t->weight;
    default:              break;
    }
    const lw_also *a = &t->also[((int)role - LW_TARGET_FIELD_ALSO)/4];
    switch (lw_field_first(role)) {
    case LW_TARGET_FIELD_X:      return a->x;
    case LW_TARGET_FIELD_Y:      return a->y;
    case LW_TARGET_FIELD_THETA:  return a->theta;
    default:              return a->weight;
    }
}

/* Set the pointers to the arrays of further points. A point without weights uses those of the stations. */
static void hand_out(lw_target *t, double *const p[LW_TARGET_FIELD_COUNT])
{
    t->n_also = 0;
    for (int i = 0; i < LW_ALSO_MAX; i++) {
        double *const *mine = p + lw_field_also(LW_TARGET_FIELD_X, i);
        if (mine[0] || mine[2])
            t->also[t->n_also++] = (lw_also){ .x = mine[0], .y = mine[1], .theta = mine[2],
                                              .weight = mine[3] ? mine[3] : t->weight };
    }
}

lw_status lw_target_allocate(lw_target *t, size_t n, const bool has[LW_TARGET_FIELD_COUNT], lw_error *e)
{
    double *p[LW_TARGET_FIELD_COUNT] = { NULL };
    size_t many = 0;
    *t = (lw_target){ .n = n, .units = lw_units_si() };
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++)
        many += has[role] || role == LW_TARGET_FIELD_WEIGHT;
    double *block = malloc(n*(many*sizeof(double) + sizeof(long)));
    if (!block)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", n);
    t->store = block;
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++)
        if (has[role] || role == LW_TARGET_FIELD_WEIGHT) {
            p[role] = block;
            block += n;
        }
    t->x = p[LW_TARGET_FIELD_X];
    t->y = p[LW_TARGET_FIELD_Y];
    t->theta = p[LW_TARGET_FIELD_THETA];
    t->angle = p[LW_TARGET_FIELD_ANGLE];
    t->weight = p[LW_TARGET_FIELD_WEIGHT];
    t->line = (long *)block;
    hand_out(t, p);
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

/* Check the weights of the stations, or of a further point (counted from 0; -1: the first point). */
static lw_status check_weights(const lw_target *t, int point, lw_target_place *place, lw_error *e)
{
    const double *weight = point < 0 ? t->weight : t->also[point].weight;
    lw_target_field role = point < 0 ? LW_TARGET_FIELD_WEIGHT : lw_field_also(LW_TARGET_FIELD_WEIGHT, point);
    double most = 0;
    for (size_t i = 0; i < t->n; i++) {
        *place = (lw_target_place){ i, role };
        if (!(weight[i] >= 0))
            return lw_error_set(e, LW_E_ARG, "a weight is at least 0, this one is %g; 0 leaves the station out", weight[i]);
        most = fmax(most, weight[i]);
    }
    place->station = 0;
    return most > 0 ? LW_OK : lw_error_set(e, LW_E_ARG, "all weights are 0, so nothing is asked for; give one "
                                           "station at least a positive weight");
}

static double step(const double *x, const double *y, size_t i, size_t k)
{
    return hypot(x[k] - x[i], y[k] - y[i]);
}

/* Returns the length of the open polygon through n points; *longest: its longest side. */
static double run_along(const double *x, const double *y, size_t n, double *longest)
{
    double length = 0;
    *longest = 0;
    for (size_t i = 1; i < n; i++) {
        double d = step(x, y, i - 1, i);
        *longest = fmax(*longest, d);
        length += d;
    }
    return length;
}

/* Extend the box, in axes with this direction, by n points. */
static void put_in_box(const double *x, const double *y, size_t n, lw_vec2 direction, lw_vec2 *lo, lw_vec2 *hi)
{
    for (size_t i = 0; i < n; i++) {
        lw_vec2 p = { direction.x*x[i] + direction.y*y[i], direction.x*y[i] - direction.y*x[i] };
        *lo = lw_v2(fmin(lo->x, p.x), fmin(lo->y, p.y));
        *hi = lw_v2(fmax(hi->x, p.x), fmax(hi->y, p.y));
    }
}

/* The diagonal of the rectangle with a side in this direction around the path and the first n_also further ones. */
static double diagonal_along(const lw_target *t, int n_also, double angle)
{
    lw_vec2 lo = { INFINITY, INFINITY }, hi = { -INFINITY, -INFINITY }, direction = { cos(angle), sin(angle) };
    put_in_box(t->x, t->y, t->n, direction, &lo, &hi);
    for (int i = 0; i < n_also; i++)
        if (t->also[i].x)
            put_in_box(t->also[i].x, t->also[i].y, t->n, direction, &lo, &hi);
    return hypot(hi.x - lo.x, hi.y - lo.y);
}

/* The least diagonal over all directions: the size of a target does not depend on how it is turned. */
static double diagonal(const lw_target *t, int n_also)
{
    enum { DIRECTIONS = 32 };
    const double apart = LW_PI/2/DIRECTIONS, less = 1 - 1e-13;          /* of the least so far, so that rounding decides nothing */
    double at = 0, least = diagonal_along(t, n_also, 0), now;
    for (int k = 1; k < DIRECTIONS; k++)
        if ((now = diagonal_along(t, n_also, k*apart)) < less*least) {
            least = now;
            at = k*apart;
        }
    for (double h = apart/2; h > 1e-12; h /= 2)
        for (int side = -1; side <= 1; side += 2)
            if ((now = diagonal_along(t, n_also, at + side*h)) < less*least) {
                least = now;
                at += side*h;
                break;
            }
    return least;
}

/* The gap of a closed target from its last station to the first, in longest steps: 1.28 at most of those that people handed in as
 * closed, 1.46 at least of strokes that bend, such as the poses of a folding table. */
#define CLOSING_STEP 1.35

/* Do angles at the stations come back to the first one, as far as their steps tell?  Input angles have to go on to whole turns, body
 * angles may also turn back. */
static bool angles_close(const double *angle, size_t n, bool input)
{
    double longest = 0, all = 0;
    for (size_t i = 1; i < n; i++) {
        double d = remainder(angle[i] - angle[i-1], TURN);
        longest = fmax(longest, fabs(d));
        all += d;
    }
    all = fabs(all);
    double gap = input ? TURN*fmax(1, ceil(all/TURN - ANGLE_EPS)) - all : fabs(remainder(all, TURN));
    return gap <= fmax(CLOSING_STEP*longest, all/20);
}

/* Is a path closed whose file does not say so?  Input angles decide, if there are any: the point comes back when the input has turned.
 * Else the gap is at most CLOSING_STEP longest steps, or a twentieth of the path (dense curves need not end where they begin).  Angles
 * of a body close, too.  Three points without input angles are no curve: they are places on a stroke. */
static bool looks_closed(const lw_target *t, double gap, double longest)
{
    return t->n > (t->angle ? 2 : 3) && t->size > 0 && (!t->theta || angles_close(t->theta, t->n, false)) &&
           (t->angle ? angles_close(t->angle, t->n, true) : gap <= fmax(CLOSING_STEP*longest, t->length/20));
}

/* Set sizes, length, and whether the path is closed. */
static void measure(lw_target *t, int closed)
{
    double longest, other, gap = step(t->x, t->y, t->n - 1, 0);
    t->length = run_along(t->x, t->y, t->n, &longest);
    t->size = t->extent = diagonal(t, 0);
    t->closed = closed >= 0 ? closed > 0 : looks_closed(t, gap, longest);
    if (t->closed)
        t->length += gap;
    for (int i = 0; i < t->n_also; i++) {
        lw_also *a = &t->also[i];
        if (!a->x)
            continue;
        a->length = run_along(a->x, a->y, t->n, &other);
        if (t->closed)
            a->length += step(a->x, a->y, t->n - 1, 0);
    }
    if (t->n_also > 0)
        t->extent = diagonal(t, t->n_also);
}

lw_status lw_target_finish(lw_target *t, int closed, lw_target_place *place, lw_error *e)
{
    lw_status s = check_weights(t, -1, place, e);
    for (int i = 0; s == LW_OK && i < t->n_also; i++)
        if (t->also[i].weight != t->weight)
            s = check_weights(t, i, place, e);
    if (s != LW_OK)
        return s;
    if (t->x)
        measure(t, closed);
    else
        t->closed = closed >= 0 ? closed > 0 : t->n > 2 && angles_close(t->angle, t->n, true) && angles_close(t->theta, t->n, false);
    return t->angle ? lw_target_order(t, place, e) : LW_OK;
}

static lw_status fill(lw_target *t, const double *const from[LW_TARGET_FIELD_COUNT], lw_error *e)
{
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++) {
        double *to = lw_target_array(t, (lw_target_field)role);
        double most = lw_field_most((lw_target_field)role);
        for (size_t i = 0; from[role] && i < t->n; i++) {
            if (!(fabs(from[role][i]) <= most))
                return lw_error_set(e, LW_E_ARG, "station %zu has a number that is not finite or beyond %g", i + 1, most);
            to[i] = from[role][i];
        }
    }
    return LW_OK;
}

static lw_status check_also(const lw_also *a, bool path, int number, lw_error *e)
{
    if (!a->x != !a->y || (!a->x && !a->theta))
        return lw_error_set(e, LW_E_ARG, "point %d needs x and y, or an angle theta, or both", number);
    if (a->x && !path)
        return lw_error_set(e, LW_E_ARG, "point %d has x and y but the first one has none: number points with a path first", number);
    return LW_OK;
}

lw_status lw_target_make_all(size_t n, const double *x, const double *y, const double *theta, const double *angle,
                             const double *weight, const lw_also *also, int n_also, int closed, lw_target *t,
                             lw_error *e)
{
    const double *from[LW_TARGET_FIELD_COUNT] = { x, y, theta, angle, weight };
    bool has[LW_TARGET_FIELD_COUNT];
    lw_target_place place;
    lw_status s = LW_OK;
    *t = (lw_target){ .n = 0 };
    if (n < 1 || n > LW_STATION_MAX)
        return lw_error_set(e, LW_E_ARG, "a target has 1 to %d stations, not %zu", LW_STATION_MAX, n);
    if (!x != !y || (!x && !(theta && angle)))
        return lw_error_set(e, LW_E_ARG, "a path needs x and y, a function angle and theta");
    if (n_also < 0 || n_also > LW_ALSO_MAX)
        return lw_error_set(e, LW_E_ARG, "a target has %d points at most", LW_ALSO_MAX + 1);
    for (int i = 0; i < n_also && s == LW_OK; i++) {
        const double **mine = from + lw_field_also(LW_TARGET_FIELD_X, i);
        mine[0] = also[i].x;
        mine[1] = also[i].y;
        mine[2] = also[i].theta;
        mine[3] = also[i].weight == weight ? NULL : also[i].weight;
        s = check_also(&also[i], x != NULL, i + 2, e);
    }
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++)
        has[role] = from[role] != NULL;
    if (s == LW_OK)
        s = lw_target_allocate(t, n, has, e);
    if (s == LW_OK)
        s = fill(t, from, e);
    if (s == LW_OK)
        s = lw_target_finish(t, closed, &place, e);
    if (s != LW_OK)
        lw_target_free(t);
    return s;
}

lw_status lw_target_make(size_t n, const double *x, const double *y, const double *theta, const double *angle,
                         const double *weight, int closed, lw_target *t, lw_error *e)
{
    return lw_target_make_all(n, x, y, theta, angle, weight, NULL, 0, closed, t, e);
}

double lw_target_distance(const lw_target *t, lw_vec2 p)
{
    double least = hypot(p.x - t->x[0], p.y - t->y[0]);
    size_t last = t->closed ? t->n : t->n - 1;
    for (size_t i = 0; i < last; i++) {
        size_t k = i + 1 < t->n ? i + 1 : 0;
        least = lw_v2_nearer(p, lw_v2(t->x[i], t->y[i]), lw_v2(t->x[k], t->y[k]), least);
    }
    return least;
}

#define LEAST_ARC (LW_PI/2)          /* between two stations a point may go on an arc of this angle */

double lw_target_arc(const lw_target *t)
{
    double most = 0;
    for (size_t i = 0; i < (t->closed ? t->n : t->n - 1); i++) {
        size_t k = (i + 1) % t->n;
        double turn = t->theta ? fabs(remainder(t->theta[k] - t->theta[i], 2*LW_PI)) : 0;
        most = fmax(most, 0.5*hypot(t->x[k] - t->x[i], t->y[k] - t->y[i])*tan(0.25*fmax(turn, t->n == 2 ? LEAST_ARC : 0)));
    }
    return most;
}

double lw_target_circle(const lw_target *t, lw_vec2 *centre, double *radius)
{
    size_t n = t->x ? t->n : 0;
    double *a = n >= 6 ? malloc(sizeof *a*4*n) : NULL, *b = a + 3*n, diag[3], most = 0;
    if (!a)
        return INFINITY;
    for (size_t i = 0; i < n; i++) {                 /* 2 c . p + (r^2 - c^2) = p^2, from the first point, in sizes */
        double x = (t->x[i] - t->x[0])/t->size, y = (t->y[i] - t->y[0])/t->size;
        a[i] = 2*x;
        a[n + i] = 2*y;
        a[2*n + i] = 1;
        b[i] = x*x + y*y;
    }
    bool round = lw_qr_factor((int)n, 3, a, diag) > 1e-4;
    if (round) {
        lw_qr_solve((int)n, 3, a, diag, b);
        *radius = t->size*sqrt(fmax(b[2] + b[0]*b[0] + b[1]*b[1], 0));
        *centre = lw_v2(t->x[0] + t->size*b[0], t->y[0] + t->size*b[1]);
    }
    for (size_t i = 0; round && i < n; i++)
        most = fmax(most, fabs(hypot(t->x[i] - centre->x, t->y[i] - centre->y) - *radius));
    free(a);
    return round ? most : INFINITY;
}

double lw_target_pivot(const lw_target *t, lw_vec2 *pivot)
{
    size_t n = t->x && t->theta ? t->n : 0, m = 2*n;
    double *a = n >= 2 ? calloc(5*m, sizeof *a) : NULL, *b = a + 4*m, diag[4], most = 0;
    if (!a)
        return INFINITY;
    for (size_t i = 0; i < n; i++) {                 /* pivot - R(theta) q = p, from the first point, in sizes */
        double c = cos(t->theta[i]), s = sin(t->theta[i]);
        double row[2][4] = { { 1, 0, -c, s }, { 0, 1, -s, -c } };
        for (int k = 0; k < 4; k++)
            for (size_t axis = 0; axis < 2; axis++)
                a[2*i + axis + m*(size_t)k] = row[axis][k];
        b[2*i] = (t->x[i] - t->x[0])/t->size;
        b[2*i + 1] = (t->y[i] - t->y[0])/t->size;
    }
    bool turns = lw_qr_factor((int)m, 4, a, diag) > 1e-2;
    if (turns) {
        lw_qr_solve((int)m, 4, a, diag, b);
        *pivot = lw_v2(t->x[0] + t->size*b[0], t->y[0] + t->size*b[1]);
    }
    for (size_t i = 0; turns && i < n; i++) {
        lw_vec2 arm = lw_v2_turn(lw_v2(t->size*b[2], t->size*b[3]), lw_v2_polar(1, t->theta[i]));
        most = fmax(most, lw_v2_norm(lw_v2_sub(lw_v2_sub(*pivot, arm), lw_v2(t->x[i], t->y[i]))));
    }
    free(a);
    return turns ? most : INFINITY;
}

double lw_target_straight(const lw_target *t)
{
    double xx = 0, xy = 0, yy = 0, least = INFINITY, most = -INFINITY;
    lw_vec2 mean = lw_v2(0, 0);
    if (!t->x)
        return INFINITY;
    for (size_t i = 0; i < t->n; i++)
        mean = lw_v2_add(mean, lw_v2((t->x[i] - t->x[0])/(double)t->n, (t->y[i] - t->y[0])/(double)t->n));
    for (size_t i = 0; i < t->n; i++) {
        double x = t->x[i] - t->x[0] - mean.x, y = t->y[i] - t->y[0] - mean.y;
        xx += x*x;
        xy += x*y;
        yy += y*y;
    }
    lw_vec2 along = lw_v2_polar(1, 0.5*atan2(2*xy, xx - yy));          /* the greater principal axis */
    for (size_t i = 0; i < t->n; i++) {
        double off = lw_v2_cross(along, lw_v2(t->x[i] - t->x[0], t->y[i] - t->y[0]));
        least = fmin(least, off);
        most = fmax(most, off);
    }
    return (most - least)/2;
}

double lw_target_swing(const lw_target *t)
{
    double least = INFINITY, most = -INFINITY;
    for (size_t i = 0; t->theta && i < t->n; i++) {
        least = fmin(least, t->theta[i]);
        most = fmax(most, t->theta[i]);
    }
    return fmax(0, fmin(most - least, 2*LW_PI));
}

enum { PARTS_MOST = 12, TURNED = 200 };      /* stations that are turned, at most */

int lw_target_parts(const lw_target *t, double off)
{
    size_t n = t->x && t->closed ? t->n : 0;
    lw_vec2 sum = lw_v2(0, 0);
    double length = 0;
    int parts = PARTS_MOST;
    for (size_t i = 0; i < n; i++) {
        lw_vec2 a = lw_v2(t->x[i], t->y[i]), b = lw_v2(t->x[(i + 1)%n], t->y[(i + 1)%n]);
        double side = lw_v2_norm(lw_v2_sub(b, a));
        sum = lw_v2_add(sum, lw_v2_scale(lw_v2_add(a, b), 0.5*side));
        length += side;
    }
    if (!(length > 0))
        return 1;
    lw_vec2 centre = lw_v2_scale(sum, 1/length);
    double least = off, worst[PARTS_MOST + 1];
    for (int k = 3; k <= PARTS_MOST; k++) {
        lw_vec2 turn = lw_v2_polar(1, 2*LW_PI/k);
        worst[k] = 0;
        for (size_t i = 0; i < n && worst[k] <= off; i += 1 + n/TURNED) {
            lw_vec2 turned = lw_v2_turn(lw_v2_sub(lw_v2(t->x[i], t->y[i]), centre), turn);
            worst[k] = fmax(worst[k], lw_target_distance(t, lw_v2_add(centre, turned)));
        }
        least = fmin(least, worst[k]);
    }
    while (parts > 2 && !(worst[parts] <= fmin(off, 2*least + 0.05*off)))       /* six parts are three parts, too */
        parts--;
    return parts > 2 ? parts : 1;
}
