#include "optimise/task/specification.h"

#include <assert.h>
#include "base/real.h"

#define X(id, name, place, angle, prescribed) { name, place, angle, prescribed },
const lw_task_row lw_task_table[LW_TASKS] = { LW_TASK_LIST(X) };
#undef X
#define X(id, name) name,
const char *const lw_timing_names[LW_TIMINGS] = { LW_TIMING_LIST(X) };
#undef X

lw_task lw_task_suggested(const lw_target *t)
{
    return !t->x ? LW_TASK_FUNCTION : t->theta ? LW_TASK_MOTION : LW_TASK_PATH;
}

lw_fit_spec lw_fit_spec_default(void)
{
    return (lw_fit_spec){ .task = LW_TASK_PATH, .timing = LW_TIMING_FREE, .datum = LW_DATUM_FREE,
                          .a = 1, .b = 1 };
}

bool lw_pin_does(const lw_target *t, const lw_fit_spec *s, lw_vec2 *pivot, double *off)
{
    if (s->task != LW_TASK_MOTION || s->timing == LW_TIMING_PRESCRIBED || t->n_also > 0)
        return false;
    *off = lw_target_pivot(t, pivot);
    return *off <= LW_EXACT_ENOUGH*t->extent && hypot(pivot->x - t->x[0], pivot->y - t->y[0]) < LW_DEFAULT_MAX_SIZE*t->extent;
}

void lw_fit_spec_weigh_angles(lw_fit_spec *s, const lw_target *t, double length)
{
    bool place = lw_task_has_place(s->task) && t->extent > 0;
    s->angle_length = !place ? 0 : length > 0 ? length : 0.5*t->extent;
    s->b = place ? s->a*s->angle_length*s->angle_length : 1;
}

void lw_fit_spec_set_limits(lw_fit_spec *s, const lw_target *t, unsigned given)
{
    s->by_default = LW_LIMIT_ALL & ~given;
    if (s->by_default & LW_LIMIT_TRANSMISSION)
        s->min_transmission = LW_DEFAULT_TRANSMISSION_DEG*LW_PI/180;
    if (s->by_default & LW_LIMIT_RATIO)
        s->length_ratio = LW_DEFAULT_LENGTH_RATIO;
    if (s->by_default & LW_LIMIT_SIZE)
        s->max_size = LW_DEFAULT_MAX_SIZE;
    if (s->by_default & LW_LIMIT_MARGIN)
        s->class_margin = LW_DEFAULT_CLASS_MARGIN;
    if (s->by_default & LW_LIMIT_MOTION) {
        s->within_limits = true;
        if (t->closed && lw_task_has_place(s->task) && !s->crank_only) {
            s->crank_only = true;
            s->by_default |= LW_LIMIT_TURN;
        }
    }
}

lw_status lw_zone_settle(lw_zone *z, lw_error *e)
{
    double area = 0, turned = 0;
    int n = z->n_corner;
    if (!lw_zone_is_polygon(z))
        return LW_OK;
    if (n < 3 || n > LW_ZONE_CORNERS)
        return lw_error_set(e, LW_E_ARG, "a polygon of a zone has 3 to %d corners, not %d", LW_ZONE_CORNERS, n);
    z->at = z->to = z->corner[0];
    for (int i = 0; i < n; i++) {
        lw_vec2 a = z->corner[i];
        area += lw_v2_cross(lw_v2_sub(a, z->corner[0]), lw_v2_sub(z->corner[(i + 1) % n], z->corner[0]));
        z->at = lw_v2(fmin(z->at.x, a.x), fmin(z->at.y, a.y));
        z->to = lw_v2(fmax(z->to.x, a.x), fmax(z->to.y, a.y));
    }
    for (int i = 0; i < n/2 && area < 0; i++) {
        lw_vec2 a = z->corner[i];
        z->corner[i] = z->corner[n - 1 - i];
        z->corner[n - 1 - i] = a;
    }
    for (int i = 0; i < n; i++) {
        lw_vec2 in = lw_v2_sub(z->corner[(i + 1) % n], z->corner[i]), out = lw_v2_sub(z->corner[(i + 2) % n], z->corner[(i + 1) % n]);
        double turn = atan2(lw_v2_cross(in, out), lw_v2_dot(in, out));
        turned += turn;
        if (!(turn > -1e-12) || !(lw_v2_dot(in, in) > 0))
            return lw_error_set(e, LW_E_ARG, "corner %d of the polygon points inwards or stands on the next; cut the zone into "
                                "polygons without such corners", (area < 0 ? n - 1 - (i + 1) % n : (i + 1) % n) + 1);
    }
    return fabs(turned - 2*LW_PI) < 1e-6 && area != 0 ? LW_OK : lw_error_set(e, LW_E_ARG, "the sides of the polygon cross");
}

enum { EDGES = 2 + 2*LW_ZONE_MAX };

/* Does a forbidden zone contain a whole box? */
static bool swallows(const lw_zone *no, lw_vec2 lower, lw_vec2 upper)
{
    if (no->kind == LW_ZONE_NO_POLYGON)
        return lw_zone_outside(no, lower) <= 0 && lw_zone_outside(no, upper) <= 0
            && lw_zone_outside(no, lw_v2(lower.x, upper.y)) <= 0 && lw_zone_outside(no, lw_v2(upper.x, lower.y)) <= 0;
    if (no->kind == LW_ZONE_NO_BOX)
        return no->at.x <= lower.x && no->at.y <= lower.y && no->to.x >= upper.x && no->to.y >= upper.y;
    lw_vec2 far = lw_v2(fmax(fabs(lower.x - no->at.x), fabs(upper.x - no->at.x)), fmax(fabs(lower.y - no->at.y), fabs(upper.y - no->at.y)));
    return no->kind == LW_ZONE_NO_CIRCLE && lw_v2_norm(far) <= no->reach;
}

static double along(lw_vec2 p, bool y) { return y ? p.y : p.x; }

/* Places where the edges of the zones cut a box in one direction, in ascending order, with the box's own ends. */
static int cuts(const lw_fit_spec *s, const lw_zone *box, bool y, double edge[EDGES])
{
    double lo = along(box->at, y), hi = along(box->to, y);
    int n = 0;
    edge[n++] = lo;
    edge[n++] = hi;
    for (int i = 0; i < s->n_zone; i++) {
        const lw_zone *z = &s->zone[i];
        double side[2] = { along(z->at, y) - z->reach, z->kind == LW_ZONE_NO_CIRCLE ? along(z->at, y) + z->reach
                                                                                  : along(z->to, y) };
        for (int k = 0; k < 2 && lw_zone_forbids(z); k++)
            if (side[k] > lo && side[k] < hi)
                edge[n++] = side[k];
    }
    assert(n <= EDGES);
    for (int i = 1; i < n; i++)
        for (int k = i; k > 0 && edge[k - 1] > edge[k]; k--) {
            double swap = edge[k];
            edge[k] = edge[k - 1];
            edge[k - 1] = swap;
        }
    return n;
}

/* Is every piece of the box inside one of the zones? */
static bool all_forbidden(const lw_fit_spec *s, const lw_zone *box)
{
    double x[EDGES], y[EDGES];
    int nx = cuts(s, box, false, x), ny = cuts(s, box, true, y);
    for (int i = 0; i + 1 < nx; i++)
        for (int j = 0; j + 1 < ny; j++) {
            bool held = false;
            for (int k = 0; k < s->n_zone && !held; k++)
                held = lw_zone_forbids(&s->zone[k])
                    && swallows(&s->zone[k], lw_v2(x[i], y[j]), lw_v2(x[i + 1], y[j + 1]));
            if (!held)
                return false;
        }
    return true;
}

/* Is the zone of the pivots outside the square of the permitted positions? */
static bool out_of_range(const lw_fit_spec *s, const lw_zone *z)
{
    double lo = s->position_lo, hi = s->position_hi, least = INFINITY, most = -INFINITY;
    if (z->kind != LW_ZONE_PIVOTS_LINE)
        return z->at.x > hi || z->at.y > hi || z->to.x < lo || z->to.y < lo;
    for (int i = 0; i < 4; i++) {
        double off = lw_v2_cross(z->to, lw_v2_sub(lw_v2(i & 1 ? lo : hi, i & 2 ? lo : hi), z->at));
        least = fmin(least, off);
        most = fmax(most, off);
    }
    return least > z->reach || most < -z->reach;
}

const char *lw_contradiction(const lw_fit_spec *s)
{
    for (int i = 0; i < s->n_zone; i++) {
        const lw_zone *z = &s->zone[i];
        if (lw_zone_forbids(z))
            continue;
        if (s->position_lo < s->position_hi && out_of_range(s, z))
            return "the pivots have to be where the range of positions does not reach";
        if (z->kind == LW_ZONE_PIVOTS_BOX && all_forbidden(s, z))
            return "forbidden zones hold the whole box in which the pivots have to be";
    }
    return NULL;
}
