/* optimise/precision/exact_nine.c - all four-bars whose curve passes through nine points (Wampler, Morgan & Sommese
 * 1992: 1442 Roberts triples over the complex numbers), by monodromy (Duff et al. 2019).
 *
 * A linkage is chosen first, at random in complex numbers, and then nine points p of its curve; so one solution at p
 * is known. Many paths lead from p to other points q: the equations keep their form when all plane numbers are
 * multiplied by s and their conjugates by s^, so each pair (s, s^) is a path from p to (s q, s^ q^), and by that to
 * q.  All known solutions are followed back and forth on four paths until all 1442 at p are known.  From there they
 * are followed to the target's points.  Of each triple (six solutions: three cognates, each with its two guides in
 * either order) one is followed.  A path that passes near a singular solution may be lost; then the conjugates of what was
 * found are added, and if some are still missing all are followed once more on another way, on which other paths are
 * difficult.
 *
 * Five points with both fixed pins given (Morgan & Wampler 1990: at most 36 solutions over the complex numbers) go the
 * same way: the fixed pins belong to the points, and there are no cognates, so that each solution is one of its own. */
#include "optimise/precision/exact_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "optimise/precision/exact_track_internal.h"

enum {
    TRIPLES = 1442, FIVES = 36, CAPACITY = 1600, PATHS = 4, PATHS_MAX = 10, ROUND = 96, AIMED = 48, TRIES = 3, ROUTES = 4
};
#define SAME 1e-9               /* of the sum of the fixed pins: one triple                              */
#define REAL 1e-9               /* a number and the conjugate of its partner                             */

typedef struct triple {
    lw_cx    v[8], key[2];
    unsigned used;              /* bits: paths followed from here                                        */
    int      tries;             /* to follow it to the target's points; TRIES: given up, or arrived       */
    int      arrived;           /* number of the solution there; -1                                      */
    lw_track end;               /* of the last path there                                                */
} triple;

typedef struct task {
    int   set, i, path;          /* path -1: to the target's points                                      */
    lw_cx v[8];
    lw_track end;
} task;

typedef struct nine {
    const lw_fit_options *o;
    double  started, unit;
    lw_vec2 origin, step[8];
    lw_nine at[2], wanted;
    lw_cx   by[PATHS_MAX][2];
    int     n[3], n_path, n_task;
    int     points, all;         /* displacements; how many solutions there are                          */
    int     route;               /* which way to the target's points is used now                         */
    triple *of[3];              /* at p, at q, at the target's points                     (CAPACITY) */
    task    job[ROUND];
} nine;

/* ---- triples ------------------------------------------------------------------------------------------ */

/* The sum of the three fixed pins, which the cognates share, and of their conjugates; with given pivots a sum of the
 * moving pins. */
static void make_key(const nine *s, const lw_cx *v, lw_cx key[2])
{
    for (int h = 0; h < 2; h++) {
        lw_cx x = v[h], a = v[2 + h], y = v[4 + h], b = v[6 + h];
        if (s->wanted.pivots) {
            key[h] = cx_add(x, cx_scale(y, 1.6180339887));       /* a sum that no symmetry keeps */
            continue;
        }
        lw_cx c = cx_mul(cx_sub(cx_mul(a, y), cx_mul(b, x)), cx_inverse(cx_sub(y, x)));
        key[h] = cx_add(cx_add(a, b), c);
    }
}

/* Number of the triple in a set; a new one is added.  -1: the set is full, or the key is not finite. */
static int number_of(nine *s, int set, const lw_cx *v)
{
    triple now = { .used = 0, .arrived = -1 };
    make_key(s, v, now.key);
    double size = 1 + cx_norm1(now.key[0]) + cx_norm1(now.key[1]);
    if (!(size < INFINITY))
        return -1;
    for (int i = 0; i < s->n[set]; i++) {
        const lw_cx *k = s->of[set][i].key;
        if (cx_norm1(cx_sub(k[0], now.key[0])) + cx_norm1(cx_sub(k[1], now.key[1])) < SAME*size)
            return i;
    }
    if (s->n[set] == CAPACITY)
        return -1;
    memcpy(now.v, v, sizeof now.v);
    s->of[set][s->n[set]] = now;
    return s->n[set]++;
}

/* ---- the first points --------------------------------------------------------------------------- */

static lw_cx draw(lw_rng *rng) { return (lw_cx){ lw_rng_normal(rng), lw_rng_normal(rng) }; }

/* A displacement to a point of the curve of v: draw d and solve for d^. */
static bool draw_point(lw_rng *rng, const lw_cx *v, lw_cx *d, lw_cx *dh)
{
    lw_cx f, by[8], by_d, by_dh;
    double moved = INFINITY;
    *d = draw(rng);
    *dh = draw(rng);
    for (int k = 0; k < 60 && moved > 1e-15; k++) {
        lw_nine_equation(v, *d, *dh, &f, by, &by_d, &by_dh);
        lw_cx step = cx_mul(f, cx_inverse(by_dh));
        *dh = cx_sub(*dh, step);
        moved = cx_norm1(step);
    }
    return moved < 1e-13 && cx_norm1(*dh) < 4 && cx_norm1(*dh) > 0.2;
}

static void begin(nine *s)
{
    lw_rng rng;
    lw_cx v[8];
    lw_rng_seed(&rng, s->o->seed, 9);
    for (int i = 0; i < 8; i++)
        v[i] = draw(&rng);
    for (int j = 0; j < s->points; j++)
        while (!draw_point(&rng, v, &s->at[0].d[j], &s->at[0].dh[j]))
            ;
    for (int j = 0; j < s->points; j++) {
        s->at[1].d[j] = draw(&rng);
        s->at[1].dh[j] = draw(&rng);
    }
    for (int j = 0; j < 4; j++) {
        s->at[0].pivot[j] = v[(j < 2 ? 2 : 4) + j];
        s->at[1].pivot[j] = draw(&rng);
    }
    s->at[0].pivots = s->at[1].pivots = s->wanted.pivots;
    for (int e = 0; e < PATHS_MAX; e++)
        for (int h = 0; h < 2; h++) {
            double turn = 2*LW_PI*lw_rng_uniform(&rng);
            s->by[e][h] = (lw_cx){ cos(turn), sin(turn) };
        }
    s->n_path = PATHS;
    number_of(s, 0, v);
}

static void set_wanted(nine *s, const lw_vec2 *p, const lw_vec2 *pivot)
{
    double square = 0;
    s->points = pivot ? 4 : 8;
    s->all = pivot ? FIVES : TRIPLES;
    s->wanted.pivots = pivot != NULL;
    s->origin = p[0];
    for (int j = 1; j <= s->points; j++)
        square += lw_v2_dot(lw_v2_sub(p[j], p[0]), lw_v2_sub(p[j], p[0]));
    s->unit = sqrt(square/s->points);
    for (int j = 0; j < 4 && pivot; j++) {
        lw_vec2 a = lw_v2_scale(lw_v2_sub(pivot[j/2], p[0]), 1/s->unit);
        s->wanted.pivot[j] = (lw_cx){ a.x, j & 1 ? -a.y : a.y };
    }
    for (int j = 0; j < s->points; j++) {
        lw_vec2 d = lw_v2_scale(lw_v2_sub(p[j + 1], p[0]), 1/s->unit);
        s->step[j] = d;
        s->wanted.d[j] = (lw_cx){ d.x, d.y };
        s->wanted.dh[j] = (lw_cx){ d.x, -d.y };
    }
}

/* ---- one round ------------------------------------------------------------------------------------------- */

static bool stopped(const nine *s)
{
    return (s->o->interrupt && *s->o->interrupt)
        || (s->o->max_seconds > 0 && lw_clock_wall() - s->started >= s->o->max_seconds);
}

/* Points with all plane numbers multiplied by by[0] and their conjugates by by[1]; the same for a solution. */
static lw_nine scaled(const lw_nine *p, const lw_cx by[2], int points)
{
    lw_nine q = *p;
    for (int j = 0; j < points; j++) {
        q.d[j] = cx_mul(q.d[j], by[0]);
        q.dh[j] = cx_mul(q.dh[j], by[1]);
    }
    for (int j = 0; j < 4; j++)
        q.pivot[j] = cx_mul(q.pivot[j], by[j & 1]);
    return q;
}

static void scale_solution(lw_cx v[8], const lw_cx by[2])
{
    for (int i = 0; i < 8; i++)
        v[i] = cx_mul(v[i], by[i & 1]);
}

static void follow(void *context, size_t job, int thread)
{
    static const double care[TRIES] = { 1, 0.1, 0.01 };
    nine *s = context;
    task *k = &s->job[job];
    const triple *from = &s->of[k->set][k->i];
    long steps = 0;
    (void)thread;
    k->end = LW_TRACK_LOST;
    if (stopped(s))
        return;
    memcpy(k->v, from->v, sizeof k->v);
    if (k->path < 0) {
        static const lw_cx same[2] = { { 1, 0 }, { 1, 0 } };
        const lw_cx *turn = s->route > 0 ? s->by[s->route - 1] : same;
        lw_nine p = scaled(&s->at[0], turn, s->points);
        scale_solution(k->v, turn);
        k->end = lw_nine_track(&p, &s->wanted, care[from->tries], k->v, &steps);
        return;
    }
    const lw_cx *by = s->by[k->path];
    lw_nine q = scaled(&s->at[1], by, s->points);
    if (k->set == 1)
        scale_solution(k->v, by);
    k->end = k->set == 0 ? lw_nine_track(&s->at[0], &q, 1, k->v, &steps) : lw_nine_track(&q, &s->at[0], 1, k->v, &steps);
    for (int i = 0; i < 8 && k->set == 0; i++)
        k->v[i] = cx_mul(k->v[i], cx_inverse(by[i & 1]));
}

static void give(nine *s, int set, int i, int path)
{
    s->job[s->n_task++] = (task){ .set = set, .i = i, .path = path };
}

/* The target's points are real, so each solution there with all numbers replaced by the conjugates of their partners is
 * one, too. */
static void add_conjugates(nine *s)
{
    for (int i = 0; i < s->n[2]; i++) {
        lw_cx v[8];
        for (int k = 0; k < 8; k++)
            v[k] = cx_conj(s->of[2][i].v[k ^ 1]);
        number_of(s, 2, v);
    }
}

/* List what to follow next: solutions at p to the target's points, and all solutions on paths not used yet; at last, if
 * some did not arrive, all once more on another way. */
static void choose(nine *s)
{
    s->n_task = 0;
    int aimed = s->n[0] < s->all ? AIMED : ROUND;
    for (int i = 0; i < s->n[0] && s->n_task < aimed; i++)
        if (s->of[0][i].tries < TRIES)
            give(s, 0, i, -1);
    for (int set = 0; set < 2 && s->n[0] < s->all; set++)
        for (int i = 0; i < s->n[set]; i++)
            for (int e = 0; e < s->n_path && s->n_task < ROUND; e++)
                if (!(s->of[set][i].used >> e & 1))
                    give(s, set, i, e);
    if (s->n_task == 0 && s->n[0] < s->all && s->n_path < PATHS_MAX) {
        s->n_path++;
        choose(s);
    }
    if (s->n_task == 0 && s->n[2] < s->all)
        add_conjugates(s);
    if (s->n_task == 0 && s->n[2] < s->all && s->route + 1 < ROUTES) {
        s->route++;                                      /* another way permutes the solutions, and leads to all */
        for (int i = 0; i < s->n[0]; i++) {
            s->of[0][i].tries = 0;
            s->of[0][i].arrived = -1;
        }
        choose(s);
    }
}

/* A solution arrived at the target's points.  If two arrive at the same one, a tracker jumped: follow both again with
 * smaller steps. */
static int arrive(nine *s, const task *k)
{
    triple *from = &s->of[0][k->i];
    int before = s->n[2], at = k->end == LW_TRACK_ARRIVED ? number_of(s, 2, k->v) : -1;
    from->tries++;
    from->end = k->end;
    if (at < 0)
        return -1;
    for (int i = 0; i < s->n[0] && at < before; i++)
        if (i != k->i && s->of[0][i].arrived == at && s->of[0][i].tries == TRIES) {
            s->of[0][i].tries = from->tries < TRIES ? from->tries : TRIES;
            s->of[0][i].arrived = -1;
            return -1;
        }
    from->arrived = at;
    from->tries = TRIES;
    return at == before ? at : -1;
}

/* ---- real solutions --------------------------------------------------------------------------------------------- */

static bool is_real(const lw_cx *v)
{
    for (int i = 0; i < 8; i += 2)
        if (cx_norm1(cx_sub(v[i + 1], cx_conj(v[i]))) > REAL*(1 + cx_norm1(v[i])))
            return false;
    return true;
}

static lw_vec2 plane(lw_cx a) { return lw_v2(a.re, a.im); }

static void offer(const nine *s, lw_ranking *r, lw_vec2 x, lw_vec2 a, lw_vec2 y, lw_vec2 b, const double *angle)
{
    lw_guide g = { .kind = LW_GUIDE_RR, .centre = lw_v2_add(s->origin, lw_v2_scale(a, s->unit)),
                   .point = lw_v2_scale(x, s->unit) };
    lw_guide h = { .kind = LW_GUIDE_RR, .centre = lw_v2_add(s->origin, lw_v2_scale(b, s->unit)),
                   .point = lw_v2_scale(y, s->unit) };
    lw_ranking_offer(r, &g, &h, angle);
}

/* Angles of the coupler, e_j = 1 + N/E (exact_track.c). */
static void coupler_angles(const nine *s, const lw_cx *v, double *angle)
{
    angle[0] = 0;
    for (int j = 0; j < s->points; j++) {
        lw_cx d = s->wanted.d[j], dh = s->wanted.dh[j];
        lw_cx a1 = cx_mul(v[0], cx_sub(dh, v[3])), b1 = cx_conj(a1);
        lw_cx a2 = cx_mul(v[4], cx_sub(dh, v[7])), b2 = cx_conj(a2);
        double dd = cx_mul(d, dh).re, d1 = 2*cx_mul(dh, cx_sub(v[0], v[2])).re + dd;
        double d2 = 2*cx_mul(dh, cx_sub(v[4], v[6])).re + dd;
        lw_cx e = cx_sub(cx_mul(a1, b2), cx_mul(a2, b1)), n = cx_sub(cx_scale(b1, d2), cx_scale(b2, d1));
        lw_cx turn = cx_add((lw_cx){ 1, 0 }, cx_mul(n, cx_inverse(e)));
        angle[j + 1] = atan2(turn.im, turn.re);
    }
}

/* Angles of the link from the fixed pin a to the moving pin x. */
static void link_angles(const nine *s, lw_vec2 x, lw_vec2 a, const double *coupler, double *angle)
{
    lw_vec2 first = lw_v2_sub(x, a);
    angle[0] = 0;
    for (int j = 0; j < 8; j++) {
        lw_vec2 pin = lw_v2_add(plane(s->wanted.d[j]), lw_v2_turn(x, lw_v2_polar(1, coupler[j + 1])));
        lw_vec2 u = lw_v2_unturn(lw_v2_sub(pin, a), first);
        angle[j + 1] = atan2(u.y, u.x);
    }
}

static lw_vec2 divide(lw_vec2 a, lw_vec2 b)
{
    return lw_v2_scale(lw_v2_unturn(a, b), 1/lw_v2_dot(b, b));
}

/* The three linkages of a triple, or the one of a solution with given pivots.  The cognates
 * (mbs/kinematics/cognate.c): with c = -x/(y - x), the one on the pins a and a + c (b - a) has a coupler that turns as
 * the link at a, and moving pins a - x and a + c (y - a). */
static void offer_triple(const nine *s, lw_ranking *r, const lw_cx *v)
{
    double coupler[9], link[9];
    lw_vec2 pin[4] = { plane(v[0]), plane(v[2]), plane(v[4]), plane(v[6]) };
    coupler_angles(s, v, coupler);
    if (s->wanted.pivots) {
        offer(s, r, pin[0], pin[1], pin[2], pin[3], coupler);
        return;
    }
    lw_path_settle(9, s->step, pin, coupler);       /* eliminating the angles has cost some digits */
    lw_vec2 x = pin[0], a = pin[1], y = pin[2], b = pin[3];
    offer(s, r, x, a, y, b, coupler);
    for (int side = 0; side < 2; side++) {
        lw_vec2 c = divide(x, lw_v2_sub(x, y));
        link_angles(s, x, a, coupler, link);
        offer(s, r, lw_v2_sub(a, x), a, lw_v2_add(a, lw_v2_turn(c, lw_v2_sub(y, a))), lw_v2_add(a, lw_v2_turn(c, lw_v2_sub(b, a))), link);
        lw_vec2 swap = x;
        x = y;
        y = swap;
        swap = a;
        a = b;
        b = swap;
    }
}

/* ---- all rounds ------------------------------------------------------------------------------------------------ */

static void take_in(nine *s, lw_ranking *r, lw_exact *out)
{
    for (int k = 0; k < s->n_task; k++) {
        const task *t = &s->job[k];
        if (t->path < 0) {
            int at = arrive(s, t);
            if (at >= 0 && is_real(s->of[2][at].v)) {
                out->n_real_triple++;
                offer_triple(s, r, s->of[2][at].v);
            }
            continue;
        }
        s->of[t->set][t->i].used |= 1u << t->path;
        int at = t->end == LW_TRACK_ARRIVED ? number_of(s, 1 - t->set, t->v) : -1;
        if (at >= 0)
            s->of[1 - t->set][at].used |= 1u << t->path;
    }
}

static double share_done(const nine *s)
{
    int done = 0;
    for (int i = 0; i < s->n[0]; i++)
        done += s->of[0][i].tries == TRIES;
    return (double)done/s->all;
}

lw_status lw_nine_solve(const lw_vec2 *p, const lw_vec2 *pivot, const lw_fit_options *o, lw_ranking *r, lw_exact *out)
{
    nine *s = calloc(1, sizeof *s);
    triple *memory = calloc(3*CAPACITY, sizeof *memory);
    lw_status st = s && memory ? LW_OK : LW_E_MEMORY;
    if (st == LW_OK) {
        s->o = o;
        s->started = lw_clock_wall();
        for (int k = 0; k < 3; k++)
            s->of[k] = memory + k*CAPACITY;
        set_wanted(s, p, pivot);
        begin(s);
        for (int round = 0; st == LW_OK && (o->max_rounds < 1 || round < o->max_rounds); round++) {
            choose(s);
            if (s->n_task == 0)
                break;
            st = lw_parallel(o->jobs, (size_t)s->n_task, follow, s);
            take_in(s, r, out);
            if (stopped(s))
                break;
            if (o->progress)
                o->progress(o->context, share_done(s), lw_clock_wall() - s->started, 0);
        }
        out->n_triple = s->n[2];
        out->n_general = s->n[0];
        out->n_theory = s->all;
        out->complete = s->n[2] == s->all;
        for (int i = 0; i < s->n[0]; i++)
            out->n_singular += s->of[0][i].arrived < 0 && s->of[0][i].end == LW_TRACK_SINGULAR;
        out->n_singular = fmin(out->n_singular, s->all - s->n[2]);
        out->fit.starts = s->n[0];
    }
    free(memory);
    free(s);
    return st;
}
