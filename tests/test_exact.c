/* Precision points: guides of random linkages found again, published guides, Freudenstein's equation, defects
 * against the motion worked out in full, and every linkage moved through its stations by independent code. */
#include <string.h>

#include "mbs/kinematics/motion.h"
#include "optimise/precision/exact_internal.h"
#include "optimise/report/report.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

static lw_rng rng;

static double between(double lo, double hi) { return lw_rng_range(&rng, lo, hi); }

/* A random four-bar that closes at n inputs in a row of one mode. */
typedef struct sample {
    double  dim[9], mode, input[9];
    lw_vec2 p[9];
    double  turn[9], x[9], y[9], output[9];
    lw_vec2 a, b;                                   /* moving pins in the frame of the tool         */
} sample;

static bool draw(sample *s, size_t n)
{
    double from = between(-3, 3), step = between(0.2, 0.5), tool = between(-1, 1);
    for (int i = 0; i < 6; i++)
        s->dim[i] = between(0.5, 3);
    s->dim[6] = between(-2, 2);
    s->dim[7] = between(-2, 2);
    s->dim[8] = between(-3, 3);
    s->mode = between(-1, 1) < 0 ? -1 : 1;
    for (size_t j = 0; j < n; j++) {
        double in = s->input[j] = from + step*(double)j;
        double d = hypot(s->dim[0] - s->dim[1]*cos(in), s->dim[1]*sin(in));
        if (d > 0.97*(s->dim[2] + s->dim[3]) || d < 1.03*fabs(s->dim[2] - s->dim[3]) || d < 0.05)
            return false;
        fourbar_joints q = fourbar_at(s->dim, s->mode, in);
        lw_vec2 ab = lw_v2_sub(q.b, q.a), c = lw_v2_sub(q.b, q.b0);
        s->p[j] = q.p;
        s->x[j] = q.p.x;
        s->y[j] = q.p.y;
        s->turn[j] = atan2(ab.y, ab.x) + tool;
        s->output[j] = atan2(c.y, c.x) + (j > 0 ? 2*LW_PI*round((s->output[j - 1] - atan2(c.y, c.x))/(2*LW_PI)) : 0);
        lw_vec2 u = lw_v2_polar(1, s->turn[j]);
        s->a = lw_v2_unturn(lw_v2_sub(q.a, q.p), u);
        s->b = lw_v2_unturn(lw_v2_sub(q.b, q.p), u);
    }
    return true;
}

static sample draw_good(size_t n)
{
    sample s = { .mode = 1 };
    while (!draw(&s, n))
        ;
    return s;
}

static double nearest(const lw_guide *g, int n, lw_vec2 centre, lw_vec2 point)
{
    double least = INFINITY;
    for (int i = 0; i < n; i++)
        least = fmin(least, hypot(lw_v2_norm(lw_v2_sub(g[i].centre, centre)), lw_v2_norm(lw_v2_sub(g[i].point, point))));
    return least;
}

/* The greatest deviation over the poses from the distance that the guide keeps. */
static double guide_error(const lw_guide *g, const lw_poses *at)
{
    double least = INFINITY, most = -INFINITY;
    for (size_t j = 0; j < at->n; j++) {
        lw_vec2 u = lw_v2_polar(1, at->angle[j]), k = lw_v2_add(at->p[j], lw_v2_turn(g->point, u));
        lw_vec2 d = lw_v2_sub(k, g->centre);
        double kept = g->kind == LW_GUIDE_RR ? lw_v2_norm(d)
                    : g->kind == LW_GUIDE_PR ? lw_v2_cross(g->along, d) : lw_v2_cross(lw_v2_turn(g->along, u), d);
        least = fmin(least, kept);
        most = fmax(most, kept);
    }
    return most - least;
}

/* The number of guides through five poses; -1: the poses are not independent. */
static int guides_through(const lw_poses *at, lw_guide out[4])
{
    lw_guide_rows r;
    lw_guide_rows_make(at, 0, &r);
    return lw_guide_rows_solve(&r, out);
}

/* Both guides of the linkage the poses come from are found, every guide found suits the poses, and they
 * are an even number (with multiplicity), two at least. */
TEST(guides_of_random_linkages)
{
    int four = 0;
    for (int trial = 0; trial < 500; trial++) {
        sample s = draw_good(5);
        lw_poses at = { 5, s.p, s.turn };
        lw_guide g[4];
        int n = guides_through(&at, g);
        CHECK(n == 2 || n == 4);
        four += n == 4;
        lw_vec2 a0 = lw_v2(s.dim[6], s.dim[7]), b0 = lw_v2_add(a0, lw_v2_polar(s.dim[0], s.dim[8]));
        CHECK_NEAR(nearest(g, n, a0, s.a), 0, 1e-6, 0);         /* poses in 16 digits hold no more in bad cases */
        CHECK_NEAR(nearest(g, n, b0, s.b), 0, 1e-6, 0);
        for (int i = 0; i < n; i++)
            CHECK_NEAR(guide_error(&g[i], &at), 0, 1e-12*(1 + lw_v2_norm(g[i].point) + lw_v2_norm(g[i].centre)), 0);
    }
    CHECK(four > 50);
}

/* A four-bar of lengths 3.2, 1.1, 2.9, 2.4 with tracer (1.6, 1.1); its other two guides by 20000 starts of Newton's
 * method, ten digits of them. */
TEST(four_guides_known)
{
    static const double known[4][4] = {
        { 0.5, -0.2, -1.902057767, -0.3900977457 }, { 5.50001923, 6.519679597, 5.506215315, -4.018218573 },
        { 3.557076765, 0.7456646613, 0.7690191157, -1.519410938 }, { 68.39626339, -67.605912, 5.473615408, 4.967573409 }
    };
    static const double dim[9] = { 3.2, 1.1, 2.9, 2.4, 1.6, 1.1, 0.5, -0.2, 0.3 };
    static const double input[5] = { 0.2, 0.9, 1.7, 2.4, 3.3 };
    lw_vec2 p[5];
    double turn[5];
    lw_guide g[4];
    for (int j = 0; j < 5; j++) {
        fourbar_joints q = fourbar_at(dim, 1, input[j]);
        p[j] = q.p;
        turn[j] = atan2(q.b.y - q.a.y, q.b.x - q.a.x) + 0.4;
    }
    int n = guides_through(&(lw_poses){ 5, p, turn }, g);
    CHECK_INT(n, 4);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(nearest(g, n, lw_v2(known[i][0], known[i][1]), lw_v2(known[i][2], known[i][3])), 0, 1e-7, 0);
    CHECK_NEAR(nearest(g, n, lw_v2(0.5, -0.2), lw_v2_turn(lw_v2(-1.6, -1.1), lw_v2_polar(1, -0.4))), 0, 1e-12, 0);
}

/* Poses of a slider-crank and of an inverted one: the slide is recognised and its line is right. */
TEST(slides_are_recognised)
{
    for (int trial = 0; trial < 200; trial++) {
        bool inverted = trial % 2;
        double r = between(0.5, 1), l = between(2, 3), e = between(-0.5, 0.5), from = between(0, 6);
        double tool = between(-3, 3);
        lw_vec2 p[5], at = lw_v2(between(-1, 1), between(-1, 1)), k = lw_v2(0, 0), w = lw_v2(1, 0);
        double turn[5];
        for (int j = 0; j < 5; j++) {                      /* slide along x at height e, or through the pin (l, e) */
            lw_vec2 a = lw_v2_polar(r, from + 0.4*j), b = lw_v2(a.x + sqrt(l*l - (a.y - e)*(a.y - e)), e);
            lw_vec2 d = lw_v2_sub(inverted ? lw_v2(l, e) : b, a), u = lw_v2_scale(d, 1/lw_v2_norm(d));
            p[j] = lw_v2_add(a, lw_v2_turn(at, u));
            turn[j] = atan2(u.y, u.x) + tool;
            k = lw_v2_unturn(lw_v2_sub(inverted ? a : b, p[j]), lw_v2_polar(1, turn[j]));
            w = inverted ? lw_v2_polar(1, -tool) : lw_v2(1, 0);
        }
        lw_poses poses = { 5, p, turn };
        lw_guide g[4];
        int n = guides_through(&poses, g), found = 0;
        CHECK(n > 0);
        for (int i = 0; i < n; i++) {
            /* a pin at infinity is known to rounding over the distance of the quartic's roots */
            CHECK_NEAR(guide_error(&g[i], &poses), 0, (g[i].kind == LW_GUIDE_RR ? 1e-11 : 1e-9)
                       *(1 + lw_v2_norm(g[i].point) + lw_v2_norm(g[i].centre)), 0);
            if (g[i].kind == LW_GUIDE_RR)
                continue;
            found++;
            CHECK_INT(g[i].kind, inverted ? LW_GUIDE_RP : LW_GUIDE_PR);
            CHECK_NEAR(fabs(lw_v2_cross(g[i].along, w)), 0, 1e-9, 0);
            if (inverted)
                CHECK_NEAR(lw_v2_norm(lw_v2_sub(g[i].centre, lw_v2(l, e))), 0, 1e-8, 0);
            else
                CHECK_NEAR(lw_v2_norm(lw_v2_sub(g[i].point, k)), 0, 1e-8, 0);
        }
        CHECK_INT(found, 1);
    }
}

TEST(dependent_poses_are_refused)
{
    lw_vec2 p[5] = { { 0, 0 }, { 1, 0 }, { 2, 1 }, { 0, 3 }, { 1, 0 } };
    double same[5] = { 0, 0, 0, 0, 0 }, turn[5] = { 0, 0.3, 0.7, 1, 0.3 };
    lw_guide g[4];
    CHECK_INT(guides_through(&(lw_poses){ 5, p, same }, g), -1);
    CHECK_INT(guides_through(&(lw_poses){ 5, p, turn }, g), -1);
    CHECK_INT(guides_through(&(lw_poses){ 4, p, turn }, g), -1);
}

/* ---- functions --------------------------------------------------------------------------------------- */

/* How far a generator is from closing at the pairs, and from `s`. */
static void check_bar(const lw_function_bar *b, size_t n, const double *angle, const double *theta)
{
    for (size_t j = 0; j < n; j++) {
        lw_vec2 a = lw_v2_polar(b->length[1], b->input0 + angle[j] - angle[0]);
        lw_vec2 o = lw_v2_add(lw_v2(b->length[0], 0), lw_v2_polar(b->length[3], b->output0 + theta[j] - theta[0]));
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(o, a)), b->length[2], 1e-11*(b->length[1] + b->length[3]), 0);
    }
}

TEST(functions_of_random_linkages)
{
    for (int trial = 0; trial < 600; trial++) {
        size_t n = 3 + (size_t)trial%3;
        bool input_free = n == 5 || trial % 2, output_free = n == 5 || (n == 4 && !input_free);
        sample s = draw_good(n);
        double angle[5], theta[5], least = INFINITY, a0 = input_free && n > 3 ? between(-1, 1) : 0;
        double b0 = output_free ? between(-1, 1) : 0;
        lw_function_bar bar[LW_FREUDENSTEIN_MAX];
        int m;
        for (size_t j = 0; j < n; j++) {
            angle[j] = s.input[j] - a0;
            theta[j] = s.output[j] - s.dim[8] - b0;
        }
        CHECK_INT(lw_freudenstein(n, angle, theta, bar, &m, NULL), LW_OK);
        for (int i = 0; i < m; i++) {
            double off = 0;
            check_bar(&bar[i], n, angle, theta);
            for (int k = 0; k < 4; k++)
                off = fmax(off, fabs(bar[i].length[k] - s.dim[k]/s.dim[0]));
            least = fmin(least, off);
        }
        CHECK_NEAR(least, 0, 1e-5, 0);
    }
}

/* ---- the whole ------------------------------------------------------------------------------------------ */

static lw_exact solve(const lw_target *t, lw_task task, int results, int jobs)
{
    lw_fit_options o = lw_fit_options_default();
    lw_exact x;
    o.spec.task = task;
    o.spec.timing = task == LW_TASK_FUNCTION ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
    o.types = NULL;
    o.n_result = results;
    o.max_rounds = 1;
    o.jobs = jobs;
    CHECK_OK(lw_exact_run(t, &o, &x, &check_error));
    return x;
}

/* The defects again, from all arcs of the motion. */
static unsigned defects_again(const lw_candidate *c, size_t n, bool function)
{
    lw_linkage k;
    lw_plan plan;
    lw_motion m;
    unsigned found = 0;
    lw_type_linkage(lw_type_find(c->family->type), &k);
    k.tracer[0].link = function ? 3 : 2;
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_motion_find(&plan, c->dim, &m), LW_OK);
    int first = lw_motion_arc(&plan, &m, &c->mode_of[0], c->input[0]);
    for (size_t j = 0; j < n && first >= 0; j++) {
        int at = lw_motion_arc(&plan, &m, &c->mode_of[j], c->input[j]);
        if (at < 0 || m.arc[at].circuit != m.arc[first].circuit)
            return LW_DEFECT_CIRCUIT;
        found |= at != first ? LW_DEFECT_BRANCH : 0;
    }
    return found;
}

static void check_results(const lw_target *t, lw_task task, const lw_exact *x)
{
    lw_fit_spec spec = lw_fit_spec_default();
    spec.task = task;
    spec.timing = task == LW_TASK_FUNCTION ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
    for (int i = 0; i < x->fit.n; i++) {
        lw_fit_report r;
        const lw_candidate *c = &x->fit.candidate[i];
        CHECK_INT(lw_fit_report_make(t, &spec, c, &r, NULL), LW_OK);
        CHECK_NEAR(r.objective, 0, 1e-18*(1 + t->size*t->size), 0);
        CHECK(!isnan(r.objective));
        CHECK_INT(x->defect[i] & ~(unsigned)LW_DEFECT_ORDER, defects_again(c, t->n, task == LW_TASK_FUNCTION));
        if (x->defect[i] & LW_DEFECT_CIRCUIT)
            CHECK(!r.verified);
        else if (x->defect[i] & LW_DEFECT_ORDER)
            CHECK(r.verified || strstr(r.fault, "out of order"));
        else {
            CHECK_TEXT(r.fault, "");
            CHECK(r.verified);                        /* moved there by Newton's method                */
        }
        CHECK(i == 0 || x->defect[i - 1] <= x->defect[i]);
        for (size_t j = 1; j < t->n && x->defect[i] == 0; j++)
            CHECK(c->intended.sense*(c->input[j] - c->input[j - 1]) >= 0);
    }
    CHECK_INT(x->n_clean + x->n_order + x->n_branch + x->n_circuit, x->n_real);
}

TEST(linkages_move_through_all_stations)
{
    for (int trial = 0; trial < 21; trial++) {
        lw_task task = (lw_task)(trial % 3);
        size_t n = task == LW_TASK_FUNCTION ? 3 + (size_t)trial/3 % 3
                 : 2 + (size_t)trial/3 % (task == LW_TASK_PATH ? 7 : 4);
        sample s = draw_good(n);
        OWN(lw_target) t = { 0 };
        bool function = task == LW_TASK_FUNCTION;
        CHECK_INT(lw_target_make(n, function ? NULL : s.x, function ? NULL : s.y,
                                 function ? s.output : task == LW_TASK_MOTION ? s.turn : NULL,
                                 function ? s.input : NULL, NULL, 0, &t, NULL), LW_OK);
        if (function && n < 5)                       /* angles count from the frame there            */
            for (size_t j = 0; j < n; j++)
                t.theta[j] -= s.dim[8];
        OWN(lw_exact) x = solve(&t, task, 40, 0);
        CHECK(x.n_real > 0);
        check_results(&t, task, &x);
    }
}

static double ratio_of(const double *dim)
{
    return fmax(fmax(dim[0], dim[1]), fmax(dim[2], dim[3]))/fmin(fmin(dim[0], dim[1]), fmin(dim[2], dim[3]));
}

static lw_exact solve_with(const lw_target *t, const lw_fit_spec *s)
{
    lw_fit_options o = lw_fit_options_default();
    lw_exact x;
    o.spec = *s;
    o.types = "fourbar";
    o.n_result = 64;
    lw_status st = lw_exact_run(t, &o, &x, NULL);
    CHECK(st == LW_OK || st == LW_NOTHING);
    return x;
}

/* Linkages under a condition are those without it that meet it. */
TEST(conditions_leave_linkages_out)
{
    int left_out = 0, stayed = 0;
    for (int trial = 0; trial < 40; trial++) {
        sample s = draw_good(5);
        OWN(lw_target) t = { 0 };
        lw_fit_spec all = lw_fit_spec_default(), lengths, zone, quick;
        CHECK_INT(lw_target_make(5, s.x, s.y, s.turn, NULL, NULL, 0, &t, NULL), LW_OK);
        all.task = LW_TASK_MOTION;
        all.timing = LW_TIMING_FREE;
        lengths = zone = quick = all;
        lengths.length_ratio = 4;
        quick.max_acceleration = 1.5*t.size;
        zone.n_zone = 1;
        zone.zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_BOX, .at = { -3, -3 }, .to = { 3, 3 }, .reach = 0 };
        OWN(lw_exact) x = solve_with(&t, &all), by_length = solve_with(&t, &lengths), by_zone = solve_with(&t, &zone);
        OWN(lw_exact) by_speed = solve_with(&t, &quick);
        int n_length = 0, n_zone = 0, n_quick = 0;
        for (int i = 0; i < x.fit.n; i++) {
            const lw_candidate *c = &x.fit.candidate[i];
            lw_fit_report r;
            n_length += ratio_of(c->dim) <= 4;
            double bx = c->dim[6] + c->dim[0]*cos(c->dim[8]), by = c->dim[7] + c->dim[0]*sin(c->dim[8]);
            n_zone += fmax(fmax(fabs(c->dim[6]), fabs(c->dim[7])), fmax(fabs(bx), fabs(by))) <= 3;
            CHECK_INT(lw_fit_report_make(&t, &all, c, &r, NULL), LW_OK);
            n_quick += r.acceleration_max <= quick.max_acceleration && !(x.defect[i] & ~1u);
        }
        for (int i = 0; i < by_speed.fit.n; i++) {
            lw_fit_report r;
            CHECK_INT(lw_fit_report_make(&t, &quick, &by_speed.fit.candidate[i], &r, NULL), LW_OK);
            CHECK(r.meets || (by_speed.defect[i] & ~1u));
            n_quick -= !(by_speed.defect[i] & ~1u);
        }
        CHECK_INT(by_length.n_real, n_length);
        CHECK_INT(by_zone.n_real, n_zone);
        CHECK(n_quick <= 0);                             /* less: some may be driven from the other side */
        left_out += 2*x.n_real - n_length - n_zone > 0;
        stayed += n_length + n_zone > 0;
        lw_exact_free(&by_length);
        lw_exact_free(&by_zone);
    }
    CHECK(left_out > 10 && stayed > 10);
}

TEST(threads_do_not_matter)
{
    sample s = draw_good(4);
    OWN(lw_target) t = { 0 };
    CHECK_INT(lw_target_make(4, s.x, s.y, s.turn, NULL, NULL, 0, &t, NULL), LW_OK);
    OWN(lw_exact) one = solve(&t, LW_TASK_MOTION, 20, 1), three = solve(&t, LW_TASK_MOTION, 20, 3);
    CHECK_INT(one.n_real, three.n_real);
    CHECK_INT(one.fit.n, three.fit.n);
    for (int i = 0; i < one.fit.n && i < three.fit.n; i++)
        CHECK(memcmp(one.fit.candidate[i].dim, three.fit.candidate[i].dim, 9*sizeof(double)) == 0);
}

TEST(wrong_numbers_of_stations)
{
    static const double x[10] = { 0, .1, .2, .3, .4, .5, .6, .7, .8, .9 }, y[10] = { 0, 1, 0, 2, 0, 3, 0, 1, 2, 5 };
    static const struct { size_t n; lw_task task; } wrong[] = {
        { 1, LW_TASK_PATH }, { 10, LW_TASK_PATH }, { 1, LW_TASK_MOTION }, { 6, LW_TASK_MOTION },
        { 2, LW_TASK_FUNCTION }, { 6, LW_TASK_FUNCTION }
    };
    for (size_t i = 0; i < sizeof wrong/sizeof *wrong; i++) {
        OWN(lw_target) t = { 0 };
        lw_exact out;
        lw_fit_options o = lw_fit_options_default();
        o.spec.task = wrong[i].task;
        bool function = wrong[i].task == LW_TASK_FUNCTION;
        CHECK_OK(lw_target_make(wrong[i].n, function ? NULL : x, function ? NULL : y, y, x, NULL, 0, &t, &check_error));
        CHECK_FAILS(lw_exact_run(&t, &o, &out, &check_error), LW_E_ARG, "exactly");
    }
}

CHECK_MAIN
{
    lw_rng_seed(&rng, check_seed(), 0);
    check_run();
    return check_end();
}
