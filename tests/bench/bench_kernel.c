/* What a point costs in the batch, against a loop written by hand for the one linkage, compiled with the
 * same flags for the same instruction set and timed in the same run.
 *
 * CSV: what, lanes, ns a point, the same by hand (empty where there is no hand-written loop), their
 * ratio, instruction set.  Each figure is the median of RUNS batches of about two milliseconds of
 * processor time. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/rng.h"
#include "mbs/batch/batch.h"
#include "mbs/batch/kernels_internal.h"
#include "mbs/plan/types.h"

#define HAND(name) name##_v1
#define TARGET
#include "hand.h"
#undef HAND
#undef TARGET
#ifdef __x86_64__
#define HAND(name) name##_v3
#define TARGET __attribute__((target("arch=x86-64-v3")))
#include "hand.h"
#undef HAND
#undef TARGET
#define HAND(name) name##_v4
#ifdef __clang__
#define TARGET __attribute__((target("arch=x86-64-v4")))
#else
#define TARGET __attribute__((target("arch=x86-64-v4,prefer-vector-width=512")))
#endif
#include "hand.h"
#define BY_HAND(isa, name, ...) \
    (strstr(isa, "v4") ? name##_v4(__VA_ARGS__) : strstr(isa, "v3") ? name##_v3(__VA_ARGS__) : name##_v1(__VA_ARGS__))
#else
#define BY_HAND(isa, name, ...) name##_v1(__VA_ARGS__)
#endif

#define RUNS  41
#define LANES 4096
#define STRIDE (LANES + 8)         /* not a power of two: rows must not fall on one cache set */

typedef struct bench {
    lw_plan plan;
    lw_lanes in;
    size_t n;
    double *work, *c, *s, *dim, *mode, *x, *y, *u, *v, *margin, *tx, *ty, *jac;
    double one[LW_DIM_MAX], sign[LW_MODE_MAX], bar[15];
    double sink;
} bench;

static double *doubles(size_t n)
{
    double *p = aligned_alloc(64, (n*sizeof *p + 63)/64*64);
    if (!p)
        exit(1);
    memset(p, 0, n*sizeof *p);
    return p;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Two functions timed in turn, so that a busy neighbour slows both: medians in ns a lane. */
static void race(bench *b, void (*first)(bench *), void (*second)(bench *), double *t1, double *t2)
{
    double t[2][RUNS], once = lw_clock_cpu();
    first(b);
    once = fmax(lw_clock_cpu() - once, 4e-9*(double)b->n);
    size_t repeat = (size_t)(2e-3/once) + 1;
    for (int r = -1; r < RUNS; r++)
        for (int f = 0; f < 2; f++) {
            void (*run)(bench *) = f ? second : first;
            double start = lw_clock_cpu();
            for (size_t i = 0; run && i < repeat; i++)
                run(b);
            if (r >= 0)
                t[f][r] = (lw_clock_cpu() - start)*1e9/((double)repeat*(double)b->n);
        }
    qsort(t[0], RUNS, sizeof(double), by_size);
    qsort(t[1], RUNS, sizeof(double), by_size);
    *t1 = t[0][RUNS/2];
    *t2 = second ? t[1][RUNS/2] : NAN;
}

static void report(bench *b, const char *what, void (*ours)(bench *), void (*hand)(bench *))
{
    double t1, t2;
    race(b, ours, hand, &t1, &t2);
    printf("%s,%zu,%.3f,", what, b->n, t1);
    if (hand)
        printf("%.3f,%.2f", t2, t1/t2);
    else
        printf(",");
    printf(",%s\n", lw_kernels_of(&b->plan)->isa);
    fflush(stdout);
}

/* ---- what is timed -------------------------------------------------------------------------------------- */

static void ours_point(bench *b) { lw_batch_point(&b->plan, &b->in, 0, b->work, b->x, b->y, NULL, NULL, NULL); }
static void ours_margin(bench *b) { lw_batch_point(&b->plan, &b->in, 0, b->work, b->x, b->y, NULL, NULL, b->margin); }
static void ours_frame(bench *b) { lw_batch_frame(&b->plan, &b->in, 0, b->work, b->x, b->y, b->u, b->v, NULL); }

static void ours_sum(bench *b)
{
    double g[LW_DIM_MAX], m;
    b->sink += lw_batch_sum(&b->plan, &b->in, 0, b->work, b->tx, b->ty, NULL, g, &m) + g[0];
}

static void jacobian(bench *b, int angle)
{
    size_t ld = b->n + 8, size = (size_t)b->plan.n_dim*ld;         /* rows off the same cache set */
    double *t = b->jac + 3*size;
    lw_jacobian j = { b->x, b->y, b->u, b->v, b->margin, b->jac, b->jac + size, angle ? b->jac + 2*size : NULL,
                      t, t + ld, angle ? t + 2*ld : NULL, ld, NULL, NULL };
    lw_batch_jacobian(&b->plan, &b->in, 0, b->work, &j);
}
static void ours_jacobian(bench *b) { jacobian(b, 0); }
static void ours_jacobian_angle(bench *b) { jacobian(b, 1); }

static const char *isa_of(const bench *b) { return lw_kernels_of(&b->plan)->isa; }
static void hand_fourbar(bench *b) { BY_HAND(isa_of(b), fourbar_angles, b->n, b->c, b->s, b->one, 1, b->x, b->y); }
static void hand_slidercrank(bench *b)
{
    BY_HAND(isa_of(b), slidercrank_angles, b->n, b->c, b->s, b->one, 1, b->x, b->y);
}
static void hand_inverted(bench *b) { BY_HAND(isa_of(b), inverted_angles, b->n, b->c, b->s, b->one, 1, b->x, b->y); }
static void hand_jansen(bench *b) { BY_HAND(isa_of(b), jansen_angles, b->n, b->c, b->s, b->bar, b->x, b->y); }
static void hand_stephenson(bench *b) { BY_HAND(isa_of(b), sixbar_angles, b->n, b->u, b->v, b->bar, 0, b->x, b->y); }
static void hand_watt(bench *b) { BY_HAND(isa_of(b), sixbar_angles, b->n, b->u, b->v, b->bar, 1, b->x, b->y); }
static void hand_frame(bench *b)
{
    BY_HAND(isa_of(b), fourbar_candidates, b->n, b->c, b->s, b->dim, STRIDE, b->mode, b->x, b->y, b->u, b->v);
}
static void hand_places(bench *b)
{
    BY_HAND(isa_of(b), fourbar_places, b->n, b->c, b->s, b->dim, STRIDE, b->mode, b->x, b->y);
}
static void hand_sum(bench *b)
{
    double g[9];
    b->sink += BY_HAND(isa_of(b), fourbar_sum, b->n, b->c, b->s, b->one, 1, b->tx, b->ty, g) + g[0];
}

/* ---- linkages --------------------------------------------------------------------------------------------- */

static void fill_lanes(bench *b)
{
    lw_rng r;
    lw_rng_seed(&r, 1, 0);
    for (int i = 0; i < LANES; i++) {
        double t = 2*LW_PI*i/LANES;
        b->c[i] = cos(t);
        b->s[i] = sin(t);
        b->tx[i] = 1 + 0.1*cos(t);
        b->ty[i] = 2 + 0.1*sin(t);
        b->mode[i] = lw_rng_uniform(&r) < 0.5 ? -1 : 1;
        for (int d = 0; d < b->plan.n_dim; d++)
            b->dim[d*STRIDE + i] = b->one[d]*lw_rng_range(&r, 0.95, 1.05);
    }
}

static void set_type(bench *b, const char *type, const double *dim)
{
    lw_linkage k;
    const lw_kernels *kernels = b->plan.kernels;
    lw_type_linkage(lw_type_find(type), &k);
    if (lw_plan_make(&k, (lw_plan_options){ .tracers = 1 }, &b->plan, NULL) != LW_OK)
        exit(1);
    b->plan.kernels = kernels;
    memcpy(b->one, dim, (size_t)b->plan.n_dim*sizeof *dim);
    b->sign[0] = 1;
    fill_lanes(b);
}

static void pin(lw_linkage *k, int from, int to, double x, double y)
{
    lw_joint *j = &k->joint[k->n_joint++];
    snprintf(j->name, sizeof j->name, "j%d", k->n_joint);
    j->kind = LW_JOINT_REVOLUTE;
    j->link[0] = from;
    j->link[1] = to;
    j->at = lw_v2(x, y);
}

static void begin(lw_linkage *k, int n_link)
{
    memset(k, 0, sizeof *k);
    k->n_link = n_link;
    k->n_input = k->n_tracer = 1;
    k->units = lw_units_si();
    for (int i = 0; i < n_link; i++)
        snprintf(k->link_name[i], LW_NAME_SIZE, "link%d", i);
}

/* Its plan and dimensions, for a tracer at a place of a link. */
static void plan_of(bench *b, lw_linkage *k, int link, lw_vec2 at)
{
    const lw_kernels *kernels = b->plan.kernels;
    double input;
    lw_error e;
    strcpy(k->tracer[0].name, "tracer");
    k->tracer[0].link = link;
    k->tracer[0].at = at;
    if (lw_plan_make(k, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_HIGHER }, &b->plan, &e) != LW_OK ||
        lw_plan_read(&b->plan, k, b->one, b->sign, &input, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        exit(1);
    }
    b->plan.kernels = kernels;
}

/* Jansen's leg from eleven bars and the ground; dimensions a b c d e f g h i j k l m from Jansen's site, in
 * the places of data/jansen.csv at 0 degrees. */
static void set_jansen(bench *b)
{
    static const double bar[13] = { 38, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49, 50, 61.9, 7.8, 15 };
    const lw_vec2 m = { 15, 0 }, g = { -38, -7.8 }, p2 = { -24.01353509712779, 31.272097454842681 };
    const lw_vec2 p3 = { -74.79436538093605, 8.143170205896143 }, p4 = { -26.952107031572960, -45.51517017008117 };
    const lw_vec2 p5 = { -59.23151496141500, -28.052930230747767 }, foot = { -43.16011052410472, -91.75693292612322 };
    enum { GROUND, M, J, B, E, D, K, C, F, G, I, H, N };
    static lw_linkage k;
    begin(&k, N);
    memcpy(b->bar, bar, sizeof bar);
    pin(&k, GROUND, M, 0, 0);
    pin(&k, M, J, m.x, m.y);     pin(&k, J, K, m.x, m.y);
    pin(&k, GROUND, B, g.x, g.y); pin(&k, GROUND, D, g.x, g.y); pin(&k, GROUND, C, g.x, g.y);
    pin(&k, J, B, p2.x, p2.y);   pin(&k, B, E, p2.x, p2.y);
    pin(&k, E, D, p3.x, p3.y);   pin(&k, D, F, p3.x, p3.y);
    pin(&k, K, C, p4.x, p4.y);   pin(&k, C, G, p4.x, p4.y);   pin(&k, G, I, p4.x, p4.y);
    pin(&k, F, G, p5.x, p5.y);   pin(&k, G, H, p5.x, p5.y);
    pin(&k, I, H, foot.x, foot.y);
    plan_of(b, &k, I, foot);
    double turn = b->one[b->plan.i_theta0];
    fill_lanes(b);
    for (int i = 0; i < LANES; i++) {                          /* the same crank angles in the ground frame */
        b->c[i] = cos(2*LW_PI*i/LANES - turn);
        b->s[i] = sin(2*LW_PI*i/LANES - turn);
    }
}

static double side(lw_vec2 a, lw_vec2 b, lw_vec2 c)
{
    return lw_v2_cross(lw_v2_sub(b, a), lw_v2_sub(c, a)) > 0 ? 1 : -1;
}

/* p on the link from a to b, as its x and y along and across it */
static lw_vec2 on(lw_vec2 a, lw_vec2 b, lw_vec2 p)
{
    return lw_v2_unturn(lw_v2_sub(p, a), lw_v2_scale(lw_v2_sub(b, a), 1/lw_v2_norm(lw_v2_sub(b, a))));
}

static double apart(lw_vec2 a, lw_vec2 b) { return lw_v2_norm(lw_v2_sub(b, a)); }

/* Both ways must give the same points. */
static void compare(bench *b, void (*hand)(bench *))
{
    double off = 0;
    b->n = LANES;
    b->in = (lw_lanes){ LANES, b->c, b->s, b->one, 0, b->sign, 0 };
    ours_point(b);
    memcpy(b->tx, b->x, LANES*sizeof *b->x);
    memcpy(b->ty, b->y, LANES*sizeof *b->y);
    hand(b);
    for (int i = 0; i < LANES; i++)
        off = fmax(off, fabs(b->tx[i] - b->x[i]) + fabs(b->ty[i] - b->y[i]));
    if (!(off < 1e-11)) {
        fprintf(stderr, "by hand and by plan the points are %g apart\n", off);
        exit(1);
    }
}

/* Stephenson III, or Watt I, in the posture of its joints. */
static void set_sixbar(bench *b, bool watt)
{
    const lw_vec2 a = { 0, 0 }, at_b = { 0.5, 0.8 }, c = { 2.6, 2.1 }, d = { 3, 0 }, e = { 1.1, 2.4 };
    const lw_vec2 f = watt ? lw_v2(3.5, 5) : lw_v2(-0.4, 5.2), g = watt ? lw_v2(4.2, 2.2) : lw_v2(-3, 2.5);
    const lw_vec2 p = { 0.2, 2.9 }, on_bc = on(at_b, c, e), on_ef = on(e, f, p), on_dc = on(d, c, g);
    static lw_linkage k;
    begin(&k, 6);
    pin(&k, 0, 1, a.x, a.y); pin(&k, 1, 2, at_b.x, at_b.y); pin(&k, 2, 3, c.x, c.y); pin(&k, 0, 3, d.x, d.y);
    pin(&k, 2, 4, e.x, e.y); pin(&k, 4, 5, f.x, f.y); pin(&k, watt ? 3 : 0, 5, g.x, g.y);
    plan_of(b, &k, 4, p);
    fill_lanes(b);
    for (int i = 0; i < LANES; i++) {
        double world = 2*LW_PI*i/LANES + b->one[b->plan.i_theta0];
        b->u[i] = cos(world);
        b->v[i] = sin(world);
    }
    const double bar[15] = { apart(a, at_b), apart(at_b, c), apart(c, d), d.x, d.y, on_bc.x, on_bc.y, apart(e, f),
                             apart(f, g), on_ef.x, on_ef.y, watt ? on_dc.x : g.x, watt ? on_dc.y : g.y, side(at_b, d, c),
                             side(e, g, f) };
    memcpy(b->bar, bar, sizeof bar);
    compare(b, watt ? hand_watt : hand_stephenson);
}

/* Eight bars twice: a crank, a triad and a dyad on it; or a crank and three dyads.  The tracer is on a link of the last
 * dyad of both. */
static void set_eightbar(bench *b, bool triad)
{
    static lw_linkage k;
    begin(&k, 8);
    pin(&k, 0, 1, 0, 0);
    pin(&k, 1, 2, 0.1, 0);
    if (triad) {
        pin(&k, 2, 5, 1.5, 2); pin(&k, 0, 3, 3, 0); pin(&k, 3, 5, 3.2, 2.2); pin(&k, 0, 4, 5, 1); pin(&k, 4, 5, 3, 3.2);
        pin(&k, 5, 6, 4, 3.5);
    } else {
        pin(&k, 2, 3, 1.5, 2); pin(&k, 3, 0, 3, 0); pin(&k, 2, 4, 2, 2.5); pin(&k, 4, 5, 4, 3); pin(&k, 5, 0, 5, 1);
        pin(&k, 4, 6, 4, 3.5);
    }
    pin(&k, 6, 7, 6, 3);
    pin(&k, 7, 0, 6, 0.5);
    plan_of(b, &k, 6, lw_v2(5, 4));
    fill_lanes(b);
    b->in = (lw_lanes){ LANES, b->c, b->s, b->one, 0, b->sign, 0 };
    lw_batch_point(&b->plan, &b->in, 0, b->work, b->x, b->y, b->u, b->v, b->margin);
    for (int i = 0; i < LANES; i++)
        if (!(b->margin[i] > 0)) {
            fprintf(stderr, "the eight-bar does not close at %.3f rad\n", 2*LW_PI*i/LANES);
            exit(1);
        }
}

/* ---- the runs ---------------------------------------------------------------------------------------------- */

static void over_angles(bench *b, size_t n)
{
    b->n = n;
    b->in = (lw_lanes){ n, b->c, b->s, b->one, 0, b->sign, 0 };
}

static void over_candidates(bench *b, size_t n)
{
    b->n = n;
    b->in = (lw_lanes){ n, b->c, b->s, b->dim, STRIDE, b->mode, STRIDE };
}

/* What a local solver asks for: few lanes, so that the cost of a call counts. */
static void few_lanes(bench *b, const char *type)
{
    static const size_t n[] = { 5, 18, 60, 512 };
    char what[64];
    for (size_t i = 0; i < sizeof n/sizeof *n; i++) {
        over_angles(b, n[i]);
        snprintf(what, sizeof what, "%s jacobian", type);
        report(b, what, ours_jacobian, NULL);
        snprintf(what, sizeof what, "%s jacobian with angle", type);
        report(b, what, ours_jacobian_angle, NULL);
        snprintf(what, sizeof what, "%s sum+gradient", type);
        report(b, what, ours_sum, NULL);
    }
}

/* Few lanes over a full turn: here the way between them is what costs. */
static void sparse_lanes(bench *b, const char *name)
{
    static const size_t n[] = { 512, 60, 18 };
    char what[64];
    for (size_t i = 0; i < sizeof n/sizeof *n; i++) {
        for (size_t k = 0; k < n[i]; k++) {
            b->c[k] = cos(2*LW_PI*(double)k/(double)n[i]);
            b->s[k] = sin(2*LW_PI*(double)k/(double)n[i]);
        }
        over_angles(b, n[i]);
        snprintf(what, sizeof what, "%s over a turn", name);
        report(b, what, ours_point, NULL);
        snprintf(what, sizeof what, "%s sum+gradient over a turn", name);
        report(b, what, ours_sum, NULL);
    }
}

static void run_higher(bench *b)
{
    for (int triad = 0; triad < 2; triad++) {
        const char *name = triad ? "eightbar with a triad" : "eightbar of dyads";
        char what[64];
        set_eightbar(b, triad);
        over_angles(b, LANES);
        snprintf(what, sizeof what, "%s over angles", name);
        report(b, what, ours_point, NULL);
        snprintf(what, sizeof what, "%s sum+gradient by %d", name, b->plan.n_dim);
        report(b, what, ours_sum, NULL);
        few_lanes(b, name);
        sparse_lanes(b, name);
    }
}

/* Linkages of several dyads. */
static void run_dyads(bench *b)
{
    set_sixbar(b, false);
    over_angles(b, LANES);
    report(b, "stephenson III points over angles", ours_point, hand_stephenson);
    set_sixbar(b, true);
    over_angles(b, LANES);
    report(b, "watt I points over angles", ours_point, hand_watt);
    set_jansen(b);
    over_angles(b, LANES);
    report(b, "jansen foot over angles", ours_point, hand_jansen);
    report(b, "jansen sum+gradient by seventeen", ours_sum, NULL);
}

static void run_all(bench *b)
{
    static const double fourbar[9] = { 3, 1, 2.5, 2.8, 1.2, 0.7, 0.1, 0.2, 0.3 };
    static const double slidercrank[8] = { 1, 2.5, 0.3, 1.2, 0.7, 0.1, 0.2, 0.3 };
    static const double inverted[8] = { 3, 1, 0.4, 1.2, 0.7, 0.1, 0.2, 0.3 };
    set_type(b, "fourbar", fourbar);
    over_angles(b, LANES);
    report(b, "fourbar points over angles", ours_point, hand_fourbar);
    report(b, "fourbar points and margins", ours_margin, hand_fourbar);
    report(b, "fourbar sum+gradient by nine", ours_sum, hand_sum);
    over_candidates(b, LANES);
    report(b, "fourbar frames over candidates", ours_frame, hand_frame);
    report(b, "fourbar points over candidates", ours_point, hand_places);
    few_lanes(b, "fourbar");
    set_type(b, "slidercrank", slidercrank);
    over_angles(b, LANES);
    report(b, "slidercrank points over angles", ours_point, hand_slidercrank);
    report(b, "slidercrank sum+gradient by eight", ours_sum, NULL);
    few_lanes(b, "slidercrank");
    set_type(b, "inverted", inverted);
    over_angles(b, LANES);
    report(b, "inverted points over angles", ours_point, hand_inverted);
    report(b, "inverted sum+gradient by eight", ours_sum, NULL);
    few_lanes(b, "inverted");
    run_dyads(b);
    few_lanes(b, "jansen");
    run_higher(b);
}
int main(int argc, char **argv)
{
    static bench b;
    b.c = doubles(LANES); b.s = doubles(LANES); b.mode = doubles(LANES);
    b.x = doubles(LANES); b.y = doubles(LANES); b.u = doubles(LANES); b.v = doubles(LANES); b.margin = doubles(LANES);
    b.tx = doubles(LANES); b.ty = doubles(LANES);
    b.dim = doubles((size_t)LW_DIM_MAX*STRIDE);
    b.jac = doubles((size_t)(3*LW_DIM_MAX + 3)*STRIDE);
    b.work = doubles(1 << 20);
    printf("what,lanes,ns,hand_ns,ratio,isa\n");
    for (int i = 0; lw_kernels_supported(i); i++) {
        if (i > 0 && !(argc > 1 && strcmp(argv[1], "all") == 0))
            break;                                             /* "all": the lesser instruction sets too */
        b.plan.kernels = lw_kernels_supported(i);
        if (argc > 1 && strcmp(argv[1], "higher") == 0)
            run_higher(&b);
        else if (argc > 1 && strcmp(argv[1], "dyads") == 0)
            run_dyads(&b);
        else
            run_all(&b);
    }
    return b.sink == 0.12345;
}
