/* optimise/problem/constraint_zones.c - conditions of zones: fixed pivots inside them, no pin and no tracer inside forbidden ones. */
#include "optimise/problem/constraint_internal.h"

#include <string.h>
#include "base/vector.h"

enum { ZONE_POSTURES = LW_ZONE_SAMPLES + 1 };

/* Derivatives of fixed pivots in the plane: of the place of number `of` by variable d. */
static lw_vec2 pivot_slope(const lw_problem *p, const lw_pivots *v, lw_vec2 turn, int of, int d)
{
    lw_vec2 by = lw_v2((d == p->plan.i_x0) + (d == v->of[of][0] ? turn.x : 0) - (d == v->of[of][1] ? turn.y : 0),
                       (d == p->plan.i_y0) + (d == v->of[of][0] ? turn.y : 0) + (d == v->of[of][1] ? turn.x : 0));
    return d == p->plan.i_theta0 ? lw_v2_add(by, lw_v2_perp(lw_v2_turn(v->at[of], turn))) : by;
}

static void pivot_conditions(const lw_problem *p, const lw_zone *z, const lw_pivots *v, const double *x, double *g, double *j)
{
    static const lw_vec2 box[4] = { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } };
    lw_vec2 turn = lw_v2_polar(1, x[p->plan.i_theta0]), base = lw_v2(x[p->plan.i_x0], x[p->plan.i_y0]);
    for (int k = 0; k < v->n; k++) {
        lw_vec2 at = lw_v2_add(base, lw_v2_turn(v->at[k], turn)), across = lw_v2(-z->to.y, z->to.x);
        bool in_box = z->kind == LW_ZONE_PIVOTS_BOX, in_polygon = lw_zone_is_polygon(z);
        for (int i = 0; i < lw_zone_sides(z); i++, g++) {
            lw_vec2 n = in_polygon ? lw_v2_scale(lw_zone_normal(z, i), -1) : in_box ? box[i] : lw_v2_scale(across, i ? 1 : -1);
            lw_vec2 from = in_polygon ? z->corner[i] : in_box && i % 2 ? z->to : z->at;
            *g = lw_v2_dot(n, lw_v2_sub(at, from)) + (z->kind == LW_ZONE_PIVOTS_LINE ? z->reach : 0);
            for (int d = 0; j && d < p->n_var; d++)
                *j++ = lw_v2_dot(n, pivot_slope(p, v, turn, k, d));
        }
    }
}

/* Lengths are scaled, so hypot, which avoids overflow, is not needed: it costs a fifth of the time here. */
static double length_of(lw_vec2 a) { return sqrt(lw_v2_dot(a, a)); }

/* outside_between of a polygon; least: at the ends.  Inside, the distance is the greatest of those from the sides, which are
 * linear along the line: its least is where two of them cross.  Outside, it is least beside a corner. */
static double outside_of_polygon(const lw_zone *z, lw_vec2 a, lw_vec2 line, double least, double *where)
{
    double base[LW_ZONE_CORNERS], slope[LW_ZONE_CORNERS], lo[2] = { -INFINITY, 0 }, hi[2] = { -INFINITY, 0 };
    int n = z->n_corner;
    for (int i = 0; i < n; i++) {
        lw_vec2 normal = lw_zone_normal(z, i);
        base[i] = lw_v2_dot(normal, lw_v2_sub(a, z->corner[i]));
        slope[i] = lw_v2_dot(normal, line);
        if (base[i] > lo[0])
            lo[0] = base[i], lo[1] = slope[i];
        if (base[i] + slope[i] > hi[0])
            hi[0] = base[i] + slope[i], hi[1] = slope[i];
    }
    double deepest = fmin(lo[0], hi[0]), at = lo[0] <= hi[0] ? 0 : 1;
    for (int step = 0; step <= n && lo[1] < 0 && hi[1] > 0; step++) {
        double t = (hi[0] - hi[1] - lo[0])/(lo[1] - hi[1]), top = -INFINITY, steep = 0;
        double crossing = lo[0] + lo[1]*t;
        for (int i = 0; i < n; i++)
            if (base[i] + slope[i]*t > top)
                top = base[i] + slope[i]*t, steep = slope[i];
        deepest = top;
        at = t;
        if (top <= crossing + 1e-14*(1 + fabs(crossing)))
            break;
        if (steep < 0)
            lo[0] = top - steep*t, lo[1] = steep;
        else
            hi[0] = top + steep*(1 - t), hi[1] = steep;
    }
    if (deepest <= 0) {
        *where = deepest < least ? at : *where;
        return fmin(deepest, least);
    }
    for (int i = 0; i < n; i++) {
        double t = lw_v2_dot(lw_v2_sub(z->corner[i], a), line)/lw_v2_dot(line, line);
        double d = t > 0 && t < 1 ? length_of(lw_v2_sub(lw_v2_add(a, lw_v2_scale(line, t)), z->corner[i])) : INFINITY;
        if (d < least)
            least = d, *where = t;
    }
    return least;
}

/* The least distance to a zone along the straight line from a to b, which has this length and is `from` and `to` off at
 * its ends, and where on it, 0 .. 1.  To a box it is least at an end, beside a corner, or where the nearest side
 * changes: on an axis of the box, or where two sides are equally far. */
static double outside_between(const lw_zone *z, lw_vec2 a, lw_vec2 b, double from, double to, double length, double *where)
{
    lw_vec2 line = lw_v2_sub(b, a);
    double least = fmin(from, to);
    *where = from <= to ? 0 : 1;
    if (length == 0)
        return least;
    if (z->kind == LW_ZONE_NO_CIRCLE) {
        *where = fmax(0, fmin(1, lw_v2_dot(lw_v2_sub(z->at, a), line)/(length*length)));
        return length_of(lw_v2_off_segment(z->at, a, b)) - z->reach;
    }
    if (lw_zone_is_polygon(z))
        return outside_of_polygon(z, a, line, least, where);
    lw_vec2 off = lw_v2_sub(a, lw_v2_scale(lw_v2_add(z->at, z->to), 0.5));
    lw_vec2 half = lw_v2_scale(lw_v2_sub(z->to, z->at), 0.5);
    double at[10] = { -off.x/line.x, -off.y/line.y };      /* divisions by 0 give no number in (0, 1) */
    for (int i = 0; i < 4; i++) {
        double sx = i & 1 ? 1 : -1, sy = i & 2 ? 1 : -1;
        at[2 + i] = (half.x - half.y - sx*off.x + sy*off.y)/(sx*line.x - sy*line.y);
        at[6 + i] = lw_v2_dot(lw_v2_sub(lw_v2(sx*half.x, sy*half.y), off), line)/(length*length);
    }
    for (int i = 0; i < 10; i++) {
        if (!(at[i] > 0 && at[i] < 1))
            continue;
        double d = lw_zone_outside(z, lw_v2_add(a, lw_v2_scale(line, at[i])));
        if (d < least) {
            least = d;
            *where = at[i];
        }
    }
    return least;
}

/* How far a path may leave a chord between two of its postures a, b, c, from its curvature at b. */
static double bulge(lw_vec2 a, lw_vec2 b, lw_vec2 c)
{
    return 0.125*length_of(lw_v2_sub(lw_v2_add(a, c), lw_v2_scale(b, 2)));
}

/* A box that holds points: its corners with the least and the greatest coordinates. */
typedef struct box { lw_vec2 least, most; } box;

static void extend(box *b, lw_vec2 at)
{
    *b = (box){ lw_v2(lw_lesser(b->least.x, at.x), lw_lesser(b->least.y, at.y)),
                lw_v2(-lw_lesser(-b->most.x, -at.x), -lw_lesser(-b->most.y, -at.y)) };
}

static box box_of_zone(const lw_zone *z)
{
    lw_vec2 reach = lw_v2(z->reach, z->reach);
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return (box){ lw_v2_sub(z->at, reach), lw_v2_add(z->at, reach) };
    box b = { z->at, z->to };
    if (lw_zone_is_polygon(z))
        b = (box){ z->corner[0], z->corner[0] };
    for (int i = 0; lw_zone_is_polygon(z) && i < z->n_corner; i++)
        extend(&b, z->corner[i]);
    return b;
}

/* Square of the distance between two boxes. */
static double apart(box a, box b)
{
    double x = fmax(0, fmax(a.least.x - b.most.x, b.least.x - a.most.x));
    double y = fmax(0, fmax(a.least.y - b.most.y, b.least.y - a.most.y));
    return x*x + y*y;
}

/* The pins and tracers whose places are checked, each place once; which: as lw_batch_jacobian has it.  Their paths are in boxes,
 * from which they may stick out by `out`.  From posture k - 1 to k: the length of the chord, and how far the path may leave it. */
typedef struct places {
    int n, which[LW_PLACE_MAX];
    bool closes[ZONE_POSTURES], measured[LW_PLACE_MAX];
    box within[LW_PLACE_MAX];
    double out[LW_PLACE_MAX];
    double length[LW_PLACE_MAX][ZONE_POSTURES], bulge[LW_PLACE_MAX][ZONE_POSTURES];
} places;

static lw_vec2 place(const lw_work *w, int i, size_t k)
{
    return lw_v2(w->place_x[(size_t)i*LW_CURVE_SAMPLES + k], w->place_y[(size_t)i*LW_CURVE_SAMPLES + k]);
}

/* The first of the three postures that give the bulge between k - 1 and k. */
static size_t bulge_from(size_t k) { return k > 1 ? k - 2 : 0; }

static void find_box(const lw_work *w, places *all, int i)
{
    box b = { place(w, i, 0), place(w, i, 0) };
    double bend2 = 0;
    for (size_t k = 1; k < ZONE_POSTURES; k++)
        extend(&b, place(w, i, k));
    for (size_t k = 2; k < ZONE_POSTURES; k++) {
        lw_vec2 bend = lw_v2_sub(lw_v2_add(place(w, i, k - 2), place(w, i, k)), lw_v2_scale(place(w, i, k - 1), 2));
        bend2 = -lw_lesser(-bend2, -lw_v2_dot(bend, bend));
    }
    all->within[i] = b;
    all->out[i] = 0.125*sqrt(bend2);
    all->measured[i] = false;
}

static void find_places(const lw_problem *p, const double *x, lw_work *w, places *out)
{
    out->n = 0;
    for (int j = 0; j < LW_JOINT_MAX; j++) {
        bool seen = p->plan.joint_point[j] < 0;
        for (int i = 0; i < j && !seen; i++)
            seen = p->plan.joint_point[i] == p->plan.joint_point[j];
        if (!seen)
            out->which[out->n++] = LW_BATCH_JOINT(j);
    }
    for (int i = 0; i <= p->n_also; i++)
        out->which[out->n++] = i;
    lw_jacobian all[LW_PLACE_MAX];
    double margin[ZONE_POSTURES];
    for (int i = 0; i < out->n; i++)
        all[i] = (lw_jacobian){ .x = w->place_x + i*LW_CURVE_SAMPLES, .y = w->place_y + i*LW_CURVE_SAMPLES,
                                .margin = i == 0 ? margin : NULL, .ld = w->posture.ld };   /* that of a pin: of the plan */
    lw_checked_jacobians(p, x, w, out->n, out->which, w->check_c, w->check_s, ZONE_POSTURES, all);
    for (size_t k = 0; k < ZONE_POSTURES; k++)
        out->closes[k] = margin[k] >= 0;
    for (int i = 0; i < out->n; i++)
        find_box(w, out, i);
}

/* Lengths and bulges of the chords of place i. */
static void measure_chords(const lw_work *w, places *all, int i)
{
    for (size_t k = 1; k < ZONE_POSTURES && !all->measured[i]; k++) {
        size_t from = bulge_from(k);
        all->length[i][k] = length_of(lw_v2_sub(place(w, i, k), place(w, i, k - 1)));
        all->bulge[i][k] = bulge(place(w, i, from), place(w, i, from + 1), place(w, i, from + 2));
    }
    all->measured[i] = true;
}

/* Where a condition is least: of which place, how far from posture k - 1 to posture k, with the bulge or not. */
typedef struct nearest { int place; double where; bool bulges; } nearest;

/* The least distances between each posture and the one before, of places no farther than `enough` from the zone. 0 if one of them
 * does not close; another condition covers that. */
static void least_distances(const lw_work *w, places *all, const lw_zone *z, double enough, double *g, nearest *at)
{
    const box zone = box_of_zone(z);
    double least[ZONE_POSTURES], outside[ZONE_POSTURES], where;
    for (size_t k = 1; k < ZONE_POSTURES; k++) {
        least[k] = INFINITY;
        at[k] = (nearest){ .place = -1 };
    }
    for (int i = 0; i < all->n; i++) {
        double far = enough + all->out[i];
        if (apart(zone, all->within[i]) > far*far)
            continue;
        measure_chords(w, all, i);
        for (size_t k = 0; k < ZONE_POSTURES; k++)
            outside[k] = lw_zone_outside(z, place(w, i, k));
        for (size_t k = 1; k < ZONE_POSTURES; k++) {
            bool bulges = all->closes[bulge_from(k)] && all->closes[bulge_from(k) + 2];
            double out = bulges ? all->bulge[i][k] : 0;
            if (!(0.5*(outside[k - 1] + outside[k] - all->length[i][k]) - out < least[k]))
                continue;                                   /* no place of the chord is nearer than one found before */
            double d = outside_between(z, place(w, i, k - 1), place(w, i, k), outside[k - 1], outside[k], all->length[i][k], &where) - out;
            if (d < least[k]) {
                least[k] = d;
                at[k] = (nearest){ i, where, bulges };
            }
        }
    }
    for (size_t k = 1; k < ZONE_POSTURES; k++) {
        bool closes = all->closes[k] && all->closes[k - 1];
        g[k - 1] = closes ? least[k] : 0;
        at[k].place = closes ? at[k].place : -1;
    }
}

#define KINK 1e-10      /* sides of a box this close together are equally far */

/* The same as outwards: beyond a corner away from it, else across the farthest side, or the mean of the two farthest. */
static lw_vec2 outwards_of_polygon(const lw_zone *z, lw_vec2 at, lw_vec2 line)
{
    double far[2] = { -INFINITY, -INFINITY }, least = INFINITY;
    lw_vec2 normal[2] = { { 0, 0 }, { 0, 0 } }, edge = at;
    for (int i = 0; i < z->n_corner; i++) {
        lw_vec2 a = z->corner[i], side = lw_v2_sub(z->corner[(i + 1) % z->n_corner], a), n = lw_zone_normal(z, i);
        lw_vec2 foot = lw_v2_add(a, lw_v2_scale(side, fmin(fmax(lw_v2_dot(lw_v2_sub(at, a), side)/lw_v2_dot(side, side), 0), 1)));
        double d = lw_v2_dot(n, lw_v2_sub(at, a)), away = length_of(lw_v2_sub(at, foot));
        if (away < least)
            least = away, edge = foot;
        int k = d > far[0] ? 0 : 1;
        if (k == 0)
            far[1] = far[0], normal[1] = normal[0];
        if (d > far[k])
            far[k] = d, normal[k] = n;
    }
    if (far[0] > 1e-9)
        return lw_v2_scale(lw_v2_sub(at, edge), 1/fmax(least, 1e-300));
    double s = lw_v2_dot(normal[0], line), t = lw_v2_dot(normal[1], line);
    if (far[0] - far[1] < 1e3*KINK && s*t < 0)
        return lw_v2_add(lw_v2_scale(normal[0], t/(t - s)), lw_v2_scale(normal[1], -s/(t - s)));
    return normal[0];
}

/* Gradient of lw_zone_outside at a point where it is least along `line`, which may be 0.  Where the nearest side
 * changes there, it is the mean of the gradients to both sides that is normal to the line. */
static lw_vec2 outwards(const lw_zone *z, lw_vec2 at, lw_vec2 line)
{
    lw_vec2 off = lw_v2_sub(at, z->at);
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return lw_v2_scale(off, 1/fmax(length_of(off), 1e-300));
    if (lw_zone_is_polygon(z))
        return outwards_of_polygon(z, at, line);
    bool left = z->at.x - at.x > at.x - z->to.x, below = z->at.y - at.y > at.y - z->to.y;
    lw_vec2 beyond = lw_v2(left ? z->at.x - at.x : at.x - z->to.x, below ? z->at.y - at.y : at.y - z->to.y);
    lw_vec2 sign = lw_v2(left ? -1 : 1, below ? -1 : 1);
    if (beyond.x > 0 && beyond.y > 0)
        return lw_v2_scale(lw_v2(sign.x*beyond.x, sign.y*beyond.y), 1/length_of(beyond));
    double x = sign.x*line.x, y = sign.y*line.y;
    if (fabs(beyond.x - beyond.y) < KINK && x*y < 0)
        return lw_v2(sign.x*y/(y - x), -sign.y*x/(y - x));
    if (lw_v2_dot(line, line) > 0 && fabs(beyond.x > beyond.y ? 2*at.x - z->at.x - z->to.x : 2*at.y - z->at.y - z->to.y) < KINK)
        return lw_v2(0, 0);
    return beyond.x > beyond.y ? lw_v2(sign.x, 0) : lw_v2(0, sign.y);
}

/* Add pull . dP/dx of the place in the scratch's Jacobian at posture k to a row. */
static void add_place(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, size_t k, lw_vec2 pull, double *row)
{
    size_t ld = w->posture.ld;
    const double *jx = w->posture.jx + k, *jy = w->posture.jy + k;
    double by_input = pull.x*w->posture_u[k] + pull.y*w->posture_v[k];
    for (int d = 0; d < p->n_var; d++) {
        if (d < p->n_dim)
            row[d] += pull.x*jx[(size_t)d*ld] + pull.y*jy[(size_t)d*ld];
        if (lw_checked_inputs_move(p, w, m))
            row[d] += by_input*lw_checked_input_slope(p, w, m, &w->check_at[k], (double)k/LW_ZONE_SAMPLES, d);
    }
}

static void nearest_row(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, const lw_zone *z, size_t k, const nearest *at, double *row)
{
    lw_vec2 b = place(w, at->place, k - 1), c = place(w, at->place, k), pull[3] = { { 0, 0 } };
    size_t from = bulge_from(k);
    bool end = at->where == 0 || at->where == 1;
    lw_vec2 out = outwards(z, lw_v2_add(lw_v2_scale(b, 1 - at->where), lw_v2_scale(c, at->where)), end ? lw_v2(0, 0) : lw_v2_sub(c, b));
    pull[k - 1 - from] = lw_v2_scale(out, 1 - at->where);
    pull[k - from] = lw_v2_scale(out, at->where);
    if (at->bulges) {
        lw_vec2 middle = place(w, at->place, from + 1);
        lw_vec2 bend = lw_v2_sub(lw_v2_add(place(w, at->place, from), place(w, at->place, from + 2)), lw_v2_scale(middle, 2));
        double size = length_of(bend);
        bend = lw_v2_scale(bend, size > 0 ? -0.125/size : 0);
        pull[0] = lw_v2_add(pull[0], bend);
        pull[1] = lw_v2_sub(pull[1], lw_v2_scale(bend, 2));
        pull[2] = lw_v2_add(pull[2], bend);
    }
    for (size_t i = 0; i < 3; i++)
        add_place(p, w, m, from + i, pull[i], row);
}

/* The least distances of all pins and points from the forbidden zones, between each posture and the next. */
static void forbidden(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *const *g, double *const *j)
{
    places all;
    nearest at[LW_ZONE_MAX][ZONE_POSTURES];
    size_t chosen[LW_ZONE_MAX][LW_ZONE_SAMPLES], needed[LW_ZONE_MAX];
    lw_checked_sample_motion(p, w, m, ZONE_POSTURES);
    find_places(p, x, w, &all);
    for (int i = 0; i < p->n_zone; i++)
        if (g[i])
            least_distances(w, &all, &p->zone[i], enough, g[i], at[i]);
    for (int i = 0; i < p->n_zone; i++)
        needed[i] = j && g[i] ? lw_rows_choose(g[i], LW_ZONE_SAMPLES, enough, chosen[i]) : 0;
    for (int q = 0; j && q < all.n; q++) {
        bool any = false;
        for (int i = 0; i < p->n_zone; i++)
            for (size_t c = 0; c < needed[i]; c++) {
                size_t k = chosen[i][c] + 1;
                if (at[i][k].place != q)
                    continue;
                if (!any) {
                    lw_jacobian jac = w->posture;
                    jac.tx = w->posture_u;
                    jac.ty = w->posture_v;
                    lw_checked_jacobian(p, x, w, all.which[q], w->check_c, w->check_s, ZONE_POSTURES, &jac);
                    any = true;
                }
                nearest_row(p, w, m, &p->zone[i], k, &at[i][k], j[i] + (k - 1)*(size_t)p->n_var);
            }
    }
}

void lw_check_zones(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *g, double *j)
{
    double *of[LW_ZONE_MAX] = { NULL }, *row[LW_ZONE_MAX];
    lw_pivots v;
    bool any = false;
    lw_problem_fixed_pivots(p, x, &v);
    for (int i = 0; i < p->n_zone; i++) {
        const lw_zone *z = &p->zone[i];
        size_t n = lw_zone_forbids(z) ? LW_ZONE_SAMPLES : (size_t)(v.n*lw_zone_sides(z));
        if (lw_zone_forbids(z)) {
            of[i] = g;
            row[i] = j;
            any = true;
            if (j)
                memset(j, 0, sizeof *j*n*(size_t)p->n_var);
        } else
            pivot_conditions(p, z, &v, x, g, j);
        g += n;
        j += j ? n*(size_t)p->n_var : 0;
    }
    if (any)
        forbidden(p, x, w, m, enough, of, j ? row : NULL);
}
