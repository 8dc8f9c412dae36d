/* Through singular postures by every formulation, by place and motion curve; near misses; runs that are stopped
 * within a step. */
#include "mbs/analysis/reactions.h"
#include "mbs/ode/integrate.h"
#include "tests/dynamics_run.h"

OWNS(lw_dynamics)

static drun d, other;

static const lw_formulation all[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                      LW_FORMULATION_GGL };

/* Greatest turn over all samples of bodies that should not turn; end of the first crank at last. */
typedef struct watch { int first, n; const lw_system *s; double turned, q[LW_SYSTEM_Q_MAX]; } watch;

static lw_status look(void *context, const lw_moment *m)
{
    watch *w = context;
    for (int b = w->first; b < w->first + w->n; b++)
        w->turned = fmax(w->turned, fabs(m->q[3*b + 2]));
    memcpy(w->q, m->q, (size_t)w->s->n_q*sizeof *w->q);
    return LW_OK;
}

static lw_vec2 crank_end(lw_formulation f, double tolerance, double to, watch *w)
{
    OWNED(lw_dynamics) *made = NULL;
    lw_vec2 at = { NAN, NAN };
    d.o.formulation = f;
    d.o.relative = d.o.absolute = tolerance;
    d.o.to = to;
    d.o.intervals = 200;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
    if (!made)
        return at;
    w->s = lw_dynamics_system(made);
    w->turned = 0;
    CHECK_INT(lw_dynamics_run(made, look, w, &d.report, &d.e), LW_OK);
    at = lw_system_point(w->s, w->s->tracer_body[0], w->s->tracer_arm[0], w->q);
    CHECK(d.report.worst_off < 1e-12);
    return at;
}

/* N-four-bar, N = 2 (A02), through ten singular postures: 20 digits by elliptic functions.  For all formulations the
 * error is a multiple of the tolerance.  At loose ones, too, a step that ends on another branch or with another energy is refused. */
TEST(two_four_bars)
{
    static const struct { int least, most; double times; } with[] = { { 3, 13, 3000 }, { 3, 13, 3000 }, { 7, 11, 3e4 },
                                                                      { 8, 11, 5e4 } };
    drun_read(&d, "examples/two-four-bars.json");
    for (int f = 0; f < 4; f++)
        for (int k = with[f].least; k <= with[f].most; k++) {
            watch w = { .first = 3, .n = 2 };
            lw_vec2 at = crank_end(all[f], pow(10, -k), 10, &w);
            CHECK_POINT(at, 0.32845811154081537865, 0.94451853817860096216, with[f].times*pow(10, -k), 0);
            CHECK(w.turned < 1e-9);
        }
    for (int k = 0; k < 3; k++) {            /* over hundreds of singular postures, in steps that end far from them or very near */
        watch w = { .first = 3, .n = 2 };
        crank_end(LW_FORMULATION_INDEX1, (double[]){ 3e-4, 1e-4, 3e-5 }[k], 1000, &w);
        CHECK(w.turned < 1e-9 && d.report.energy_error < 1e-5*d.report.energy_scale);
    }
}

/* A third crank makes one row redundant: the kept rows become dependent in postures that are not singular.  Up to
 * the first singular posture it moves as the pendulum in test_dynamics_hard.c. */
#define CRANK(n, x) "{'name': 'A" n "', 'links': ['ground', 'c" n "'], 'at': [" x ", 0]}," \
                    "{'name': 'B" n "', 'links': ['c" n "', 'coupler'], 'at': [" x ".6, 0.8]}"
static const char three_cranks[] = "{'linkwright': 1, 'links': ['ground',{'name': 'c0', 'mass': 1, 'centre': [0.3, 0.4]}, {'name': 'c1', 'mass': 1, "
    "'centre': [1.3, 0.4]},{'name': 'c2', 'mass': 1, 'centre': [2.3, 0.4]},{'name': 'coupler', 'mass': 2, 'centre': [1.1, 0.8], 'inertia': 1}],'joints': "
    "[" CRANK("0", "0") "," CRANK("1", "1") "," CRANK("2", "2") "],'input': {'joint': 'A0', 'speed': 0.3}, 'gravity': [0, -9.81],'tracers': "
    "[{'name': 'P', 'link': 'c0', 'at': [0.6, 0.8]}]}";

TEST(redundant_rows)
{
    static const double tolerance[] = { 0, 1e-12, 1e-10, 1e-10 }, slack[] = { 0, 1e-8, 3e-6, 3e-6 };
    drun_read_format(&other, "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 1,'centre': [0.47142857142857142857, "
        "0.62857142857142857143]}],'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at': [0, 0]}], 'input': {'joint': 'A', 'speed': 0.3},'gravity': "
        "[0, -9.81], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [0.6, 0.8]}]}", 0, 0);
    CHECK_INT(drun_to(&other, LW_FORMULATION_REDUCED, 1e-13, 4, 4), LW_OK);
    drun_read_format(&d, three_cranks, 0, 0);
    for (int f = 1; f < 4; f++) {
        watch w = { .first = 3, .n = 1 };
        lw_vec2 at = crank_end(all[f], tolerance[f], 4, &w);
        CHECK_POINT(at, other.tracer[4].x, other.tracer[4].y, slack[f], 0);
        CHECK(w.turned < 1e-9);
    }
}

/* A parallelogram that swings near its singular posture on a spring, from rest at 0.2 rad: 0.2 cos(w t), w^2 = k/(2
 * I + m) with the mass of the coupler at the radius 1. */
TEST(swings_about_it)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0],'inertia': 0.5}, {'name': 'b', 'mass': 1, "
        "'centre': [%.17g, %.17g], 'inertia': 0.1},{'name': 'c', 'mass': 1, 'centre': [2, 0], 'inertia': 0.5}], 'joints': [{'name': 'A', 'links': "
        "['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [%s]},{'name': 'C', 'links': ['b', 'c'], 'at': [%s]}, {'name': 'D', "
        "'links': ['ground', 'c'], 'at': [2, 0]}],'input': {'joint': 'A'}, 'springs': [{'joint': 'A', 'stiffness': 8, 'free': -0.2}],'tracers': [{'name': "
        "'P', 'link': 'a', 'at': [%s]}]}";
    char first[64], second[64], whole[2000];
    double x = cos(0.2), y = sin(0.2);
    snprintf(first, sizeof first, "%.17g, %.17g", x, y);
    snprintf(second, sizeof second, "%.17g, %.17g", x + 2, y);
    snprintf(whole, sizeof whole, text, x + 1, y, first, second, first);
    drun_read_format(&d, whole, 0, 0);
    for (int f = 0; f < 4; f++) {
        watch w = { .first = 1, .n = 1 };
        lw_vec2 at = crank_end(all[f], f < 2 ? 1e-12 : 1e-10, 7, &w);
        double angle = 0.2*cos(7*sqrt(8/2.0));
        CHECK_POINT(at, cos(angle), sin(angle), f < 2 ? 1e-10 : 1e-6, 0);
        CHECK(w.turned < 1e-9);
    }
}

/* A pendulum on the bar of a parallelogram, which passes singular postures at any place of the pendulum: there is no
 * curve, so every method goes over by one step.  The tracer is the bob. */
TEST(two_freedoms)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5],'inertia': 0.083}, {'name': 'b', "
        "'mass': 1, 'centre': [0.5, 1], 'inertia': 0.083},{'name': 'c', 'mass': 1, 'centre': [1, 0.5], 'inertia': 0.083},{'name': 'bob', 'mass': 0.5, "
        "'centre': [0.5, 0.6], 'inertia': 0.02}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], "
        "'at': [0, 1]},{'name': 'C', 'links': ['b', 'c'], 'at': [1, 1]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0]},{'name': 'P', 'links': "
        "['b', 'bob'], 'at': [0.5, 1]}], 'input': {'joint': 'A', 'speed': -1},'gravity': [0, -9.81], 'tracers': [{'name': 'T', 'link': 'bob', 'at': [0.5, "
        "0.6]}]}";
    static const int tightest[] = { 0, 11, 11, 10 };
    watch w = { .first = 1, .n = 1 };
    drun_read_format(&d, text, 0, 0);
    lw_vec2 want = crank_end(LW_FORMULATION_INDEX1, 1e-12, 3, &w);
    CHECK(d.report.energy_error < 1e-10*d.report.energy_scale);
    for (int f = 1; f < 4; f++)
        for (int k = 7; k <= tightest[f]; k++) {
            lw_vec2 at = crank_end(all[f], pow(10, -k), 3, &w);
            CHECK_POINT(at, want.x, want.y, (f == 1 ? 300 : 1e4)*pow(10, -k), 0);
            CHECK(w.turned < 1e-9);
        }
}

/* Change-point four-bars: ground, crank, coupler, rocker; the crank's angle and speed at the start, the side of the
 * rocker's pin.  Parallelogram, antiparallelogram, kites, rhombus in two of its three ways. */
static const struct { double length[4], angle, side, speed; } change_point[] = {
    { { 4, 1, 4, 1 }, 1, 1, 6 }, { { 4, 1, 4, 1 }, 1, -1, 6 },
    { { 3, 1, 1, 3 }, 1, 1, 6 }, { { 3, 1, 1, 3 }, 1, -1, 6 },
    { { 1, 1, 1, 1 }, 1.2, 1, 6 }, { { 1, 1, 1, 1 }, 2, -1, -6 },
};

static void read_change_point(int k)
{
    const double *l = change_point[k].length, angle = change_point[k].angle;
    lw_vec2 b = lw_v2_polar(l[1], angle), to = lw_v2_sub(lw_v2(l[0], 0), b);
    double d2 = lw_v2_dot(to, to), along = 0.5*(d2 + l[2]*l[2] - l[3]*l[3])/d2;
    double off = change_point[k].side*sqrt(l[2]*l[2]/d2 - along*along);
    lw_vec2 c = lw_v2(b.x + along*to.x - off*to.y, b.y + along*to.y + off*to.x);
    char text[2000];
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground',{'name': 'a', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.1},{'name': 'b', "
        "'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.2},{'name': 'c', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.3}], 'joints': [{'name': "
        "'A', 'links': ['ground', 'a'], 'at': [0, 0]},{'name': 'B', 'links': ['a', 'b'], 'at': [%.17g, %.17g]},{'name': 'C', 'links': ['b', 'c'], 'at': "
        "[%.17g, %.17g]},{'name': 'D', 'links': ['ground', 'c'], 'at': [%.17g, 0]}], 'input': {'joint': 'A', 'speed': %.17g},'gravity': [0, -9.81], "
        "'tracers': [{'name': 'P', 'link': 'a', 'at': [%.17g, %.17g]}]}", b.x/2, b.y/2,
        (b.x + c.x)/2, (b.y + c.y)/2, (l[0] + c.x)/2, c.y/2, b.x, b.y, c.x, c.y, l[0], change_point[k].speed,
        b.x, b.y);
    drun_read_format(&d, text, 0, 0);
}

TEST(change_points)
{
    for (size_t k = 0; k < sizeof change_point/sizeof *change_point; k++) {
        read_change_point((int)k);
        watch w = { .n = 0 };
        lw_vec2 want = crank_end(LW_FORMULATION_REDUCED, 1e-13, 5, &w);
        CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
        for (int e = 6; e <= 12; e += 2) {
            lw_vec2 at = crank_end(LW_FORMULATION_INDEX1, pow(10, -e), 5, &w);
            CHECK_POINT(at, want.x, want.y, 300*pow(10, -e), 0);
        }
        for (int f = 2; f < 4; f++) {
            lw_vec2 at = crank_end(all[f], 1e-9, 5, &w);
            CHECK_POINT(at, want.x, want.y, 3e-4, 0);
        }
    }
}

/* A slider (2 kg) on a crank and a rod (1 m, 1 kg each) is the input and passes the pivot of the crank, which lies on one side of its
 * start alone.  With the crank at the angle s: M s'' + M' s'^2/2 = Q, M = 2/3 + 10 sin^2 s. */
static lw_status rate_over_pivot(void *context, double t, const double *y, double *dy)
{
    double push = *(const double *)context;
    (void)t;
    double c = cos(y[0]), s = sin(y[0]), mass = 2./3 + 10*s*s;
    dy[0] = y[1];
    dy[1] = (-9.81*c + push*-2*s - 10*s*c*y[1]*y[1])/mass;
    return LW_OK;
}

TEST(slider_over_a_pivot)
{
    static const lw_formulation some[] = { LW_FORMULATION_AUTO, LW_FORMULATION_REDUCED, LW_FORMULATION_QUADRATURE, LW_FORMULATION_INDEX1 };
    for (int side = -1; side <= 1; side += 2)
        for (int f = 0; f < 4; f++) {
            char text[2000];
            double c = side*cos(1), s = sin(1), push = -30*side;
            snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': %.17g},"
                     "{'name': 'b', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': %.17g}, {'name': 'c', 'mass': 2, 'centre': [%.17g, 0]}],"
                     "'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [%.17g, %.17g]},"
                     "{'name': 'C', 'links': ['b', 'c'], 'at': [%.17g, 0]}, {'name': 'S', 'kind': 't', 'links': ['ground', 'c'],"
                     "'at': [%.17g, 0], 'along': [1, 0]}], 'input': {'joint': 'S', 'speed': 0}, 'gravity': [0, -9.81],"
                     "'forces': [{'link': 'c', 'at': [%.17g, 0], 'fx': %.17g}], 'tracers': [{'name': 'P', 'link': 'a', 'at': [%.17g, %.17g]}]}",
                     c/2, s/2, 1./12, 1.5*c, s/2, 1./12, 2*c, c, s, 2*c, 2*c, 2*c, push, c, s);
            drun_read_format(&d, text, 0, 0);
            CHECK_INT(drun_to(&d, some[f], 1e-11, 0.6, 30), LW_OK);
            double y[2] = { side > 0 ? 1 : LW_PI - 1, 0 };
            for (int i = 1; i < d.n_moment; i++) {
                drun_exact(&(lw_ode){ .n = 2, .rate = rate_over_pivot, .context = &push }, d.t[i - 1], y, d.t[i]);
                CHECK_POINT(d.tracer[i], cos(y[0]), sin(y[0]), 1e-7, 0);
            }
            CHECK(side*cos(y[0]) < -0.1);                                   /* beyond the pivot */
            CHECK(d.report.energy_error < 1e-8*d.report.energy_scale);
        }
}

/* A crank as long as the frame moves a block along a swinging bar through the pivot of the bar: the bar turns half as fast as the crank, at
 * (s + pi)/2, and the inertia of all is constant, so that the crank turns evenly without loads. */
TEST(block_over_a_pivot)
{
    static const lw_formulation some[] = { LW_FORMULATION_AUTO, LW_FORMULATION_REDUCED, LW_FORMULATION_QUADRATURE, LW_FORMULATION_INDEX1 };
    const double s = 1, w = -2;
    const struct { char joint; double speed; } input[] = { { 'A', w }, { 'B', -w/2 }, { 'S', w*cos(s/2) }, { 'G', w/2 } };
    for (int k = 0; k < 4; k++)
        for (int f = 0; f < 4; f++) {
            char text[2000];
            double x = cos(s), y = sin(s), ux = cos((s + LW_PI)/2), uy = sin((s + LW_PI)/2);
            snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.1},"
                     "{'name': 'b', 'mass': 2, 'centre': [1, 0], 'inertia': 0.5}, {'name': 'c', 'mass': 1, 'centre': [%.17g, %.17g],'inertia': 0.1}], "
                     "'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'c'],'at': [%.17g, %.17g]}, {'name': "
                     "'S', 'kind': 't', 'links': ['b', 'c'], 'at': [%.17g, %.17g], 'along': [%.17g, %.17g]},{'name': 'G', 'links': ['ground', 'b'], 'at': "
                     "[1, 0]}], 'input': {'joint': '%c', 'speed': %.17g},'tracers': [{'name': 'P', 'link': 'b', 'at': [%.17g, %.17g]}]}",
                     x/2, y/2, x, y, x, y, x, y, ux, uy, input[k].joint, input[k].speed, 1 + ux, uy);
            drun_read_format(&d, text, 0, 0);
            CHECK_INT(drun_to(&d, some[f], 1e-11, 1.5, 30), LW_OK);
            for (int i = 0; i < d.n_moment; i++) {
                double turned = (s + w*d.t[i] + LW_PI)/2;
                CHECK_POINT(d.tracer[i], 1 + cos(turned), sin(turned), 1e-8, 0);
            }
            CHECK_INT(d.n_moment, 31);
        }
}

/* Cranks of a parallelogram that come to rest in the flat posture at 1 s, or turn back there, slowly or at once. */
TEST(rests_in_a_flat_posture)
{
    static const char *const motion[] = { "1 - step(t, 0, 0, 1, 1)", "(t - 1)^4", "(t - 1)^6", "abs(1 - t)", "max(1 - t, 0)", "(1 - t)^5" };
    for (int k = 0; k < 6; k++)
        for (int n = 20; n <= 37; n += 17) {
            char text[1500];
            snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 1}, {'name': 'b',"
                     "'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 1}, {'name': 'c', 'mass': 1, 'centre': [2, 0], 'inertia': 1}], 'joints': ["
                     "{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [%.17g, %.17g]},"
                     "{'name': 'C', 'links': ['b', 'c'], 'at': [%.17g, %.17g]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [2, 0]}],"
                     "'input': {'joint': 'A', 'value': 1, 'motion': '%s'}, 'tracers': [{'name': 'P', 'link': 'c', 'at': [%.17g, %.17g]}]}",
                     1 + cos(1), sin(1), cos(1), sin(1), 2 + cos(1), sin(1), motion[k], 2 + cos(1), sin(1));
            drun_read_format(&d, text, 0, 0);
            CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 2, n), LW_OK);
            CHECK_INT(d.n_moment, n + 1);
            for (int i = 0; i < d.n_moment; i++) {
                double x = fabs(1 - d.t[i]), t = d.t[i], rest = fmin(t, 1), s = 0;
                s = k == 0 ? 1 - rest*rest*(3 - 2*rest) : k == 1 ? pow(x, 4) : k == 2 ? pow(x, 6) : k == 3 ? x : k == 4 ? 1 - rest : pow(1 - t, 5);
                CHECK_POINT(d.tracer[i], 2 + cos(s), sin(s), 1e-8, 0);
            }
            for (int i = 0; i < 9; i++)
                CHECK(isfinite(d.a[i]));
        }
}

/* The last moment of a run, and its drives. */
typedef struct last_moment { const lw_dynamics *made; int n; double q[18], v[18], a[18], drive[2]; } last_moment;

static lw_status keep_last(void *context, const lw_moment *m)
{
    last_moment *z = context;
    memcpy(z->q, m->q, sizeof z->q), memcpy(z->v, m->v, sizeof z->v), memcpy(z->a, m->a, sizeof z->a);
    lw_reactions_driving(z->made, m, z->drive);
    z->n++;
    return LW_OK;
}

static void run_to_last(double to, int n, last_moment *z)
{
    OWNED(lw_dynamics) *made = NULL;
    d.o.to = to, d.o.intervals = n, z->n = 0;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
    z->made = made;
    CHECK_INT(lw_dynamics_run(made, keep_last, z, &d.report, &d.e), LW_OK);
    CHECK_INT(z->n, n + 1);
}

/* Of two parallelograms on the ground one turns steadily, the other turns back at once, slowly or ever more slowly, or rests, in its flat
 * posture at 0.5 s, where the first one may be flat, too: their cranks turn as given, and so do the links opposite, there too.  Without
 * friction and weight nothing moves by itself, and a crank, its link opposite and the bar resist with 3 kg m^2. */
TEST(one_of_two_inputs_turns_back_in_a_flat_posture)
{
    static const struct { const char *motion; double begin, there; } second[] = {
        { "pi - 9*(t - 0.5)^2", LW_PI - 2.25, -18 }, { "pi - 4*abs(t - 0.5)", LW_PI - 2, NAN }, { "pi - 1 + step(t, 0, 0, 0.5, 1)", LW_PI - 1, NAN },
        { "pi - 16*(t - 0.5)^4", LW_PI - 1, 0 } };
    for (int k = 0; k < 8; k++)
        for (int n = 10; n <= (k < 3 ? 25 : 10); n += 15) {
            char links[1200] = "'ground'", joints[2000] = "";
            double first = k < 4 ? 1 : LW_PI - 1.5, begin = second[k%4].begin, there = second[k%4].there;
            for (int p = 0; p < 2; p++) {
                double u = p ? begin : first, x = cos(u), y = sin(u) + 5*p;
                snprintf(links + strlen(links), sizeof links - strlen(links), ", {'name': 'a%d', 'mass': 1, 'centre': [0, %d], 'inertia': 1}, {'name':"
                         "'b%d', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 1}, {'name': 'c%d', 'mass': 1, 'centre': [2, %d], 'inertia': 1}",
                         p, 5*p, p, 1 + x, y, p, 5*p);
                snprintf(joints + strlen(joints), sizeof joints - strlen(joints), "%s{'name': 'A%d', 'links': ['ground', 'a%d'], 'at': [0, %d]},"
                         "{'name': 'B%d', 'links': ['a%d', 'b%d'], 'at': [%.17g, %.17g]}, {'name': 'C%d', 'links': ['b%d', 'c%d'], 'at': [%.17g, "
                         "%.17g]}, {'name': 'D%d', 'links': ['ground', 'c%d'], 'at': [2, %d]}", p ? "," : "", p, p, 5*p, p, p, p, x, y, p, p,
                         p, 2 + x, y, p, p, 5*p);
            }
            char text[4000];
            last_moment z;
            snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, 0], 'links': [%s], 'joints': [%s], 'inputs': [{'joint': 'A0', 'value': %.17g, "
                     "'motion': '%.17g + 3*t'}, {'joint': 'A1', 'value': %.17g, 'motion': '%s'}]}", links, joints, first, first, begin, second[k%4].motion);
            drun_read_format(&d, text, 0, 0);
            d.o.formulation = LW_FORMULATION_AUTO;
            run_to_last(0.5, n, &z);                     /* its last row is the flat posture */
            for (int b = 0; b < 6; b++) {
                bool turns = b%3 != 1, late = b > 2;
                CHECK_NEAR(remainder(z.q[3*b + 2], 2*LW_PI), !turns ? 0 : remainder(late ? LW_PI - begin : 1.5, 2*LW_PI), 1e-9, 0);
                if (k%4 == 1)                            /* speeds and accelerations jump at this moment */
                    continue;
                CHECK_NEAR(z.v[3*b + 2], turns && !late ? 3 : 0, 1e-7, 0);
                if (isfinite(there))
                    CHECK_NEAR(z.a[3*b + 2], turns && late ? there : 0, 1e-6, 0);
            }
            if (isfinite(there)) {
                CHECK_NEAR(z.drive[0], 0, 1e-6, 0);
                CHECK_NEAR(z.drive[1], 3*there, 1e-6, 0);
            }
            run_to_last(0.7, n, &z);
            double end[] = { LW_PI - 9*0.04, LW_PI - 0.8, LW_PI, LW_PI - 16*0.0016 };
            CHECK_NEAR(remainder(z.q[17] - (end[k%4] - begin), 2*LW_PI), 0, 1e-9, 0);
            CHECK_NEAR(remainder(z.q[14], 2*LW_PI), 0, 1e-9, 0);
        }
}

/* A five-bar is longest in one place of its two inputs alone, where its rods are in line.  The motion goes straight on through it, also if a row
 * lies there: it ends in the mirror image of its start. */
TEST(straight_on_where_a_five_bar_is_longest)
{
    for (int n = 9; n <= 20; n += 11) {
        char text[2000];
        lw_vec2 b = lw_v2_polar(1, LW_PI - 0.5), e = lw_v2_add(lw_v2(2, 0), lw_v2_polar(1, -0.3)), half = lw_v2_scale(lw_v2_sub(e, b), 0.5);
        double high = sqrt(4 - lw_v2_dot(half, half))/lw_v2_norm(half);
        lw_vec2 c = lw_v2_add(lw_v2_add(b, half), lw_v2(-high*half.y, high*half.x));
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'a', 'b', 'r', 's'], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},"
                 "{'name': 'E', 'links': ['ground', 'b'], 'at': [2, 0]}, {'name': 'B', 'links': ['a', 'r'], 'at': [%.17g, %.17g]}, {'name': 'D', 'links': "
                 "['b', 's'], 'at': [%.17g, %.17g]}, {'name': 'C', 'links': ['r', 's'], 'at': [%.17g, %.17g]}], 'inputs': [{'joint': 'A', 'value': %.17g, "
                 "'motion': 'pi + 0.5*(t - 1)'}, {'joint': 'E', 'value': -0.3, 'motion': '0.3*(t - 1)'}], 'tracers': [{'name': 'P', 'link': 'r', 'at': "
                 "[%.17g, %.17g]}]}", b.x, b.y, e.x, e.y, c.x, c.y, LW_PI - 0.5, c.x, c.y);
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 2, n), LW_OK);
        CHECK_INT(d.n_moment, n + 1);
        for (int i = 0; i < d.n_moment; i++) {
            CHECK_NEAR(d.tracer[i].x, d.tracer[n - i].x, 1e-9, 0);
            CHECK_NEAR(d.tracer[i].y, -d.tracer[n - i].y, 1e-9, 0);
        }
        CHECK_NEAR(d.tracer[0].y, c.y, 1e-9, 0);
    }
}

/* Ten parallelograms in a row, whose change points all have to be found as one; the motion is that of one crank, s''
 * = -g 15.5/(11/3 + 10) cos s. */
static lw_status rate_of_ten(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1];
    dy[1] = -9.81*15.5/(11./3 + 10)*cos(y[0]);
    return LW_OK;
}

TEST(ten_in_a_row)
{
    static char text[12000];
    int n = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
    for (int i = 0; i <= 10; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': 'c%d', 'mass': 1, 'centre': [%d, 0.5],'inertia': 0.083333333333333333}", i, i);
    for (int i = 0; i < 10; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': 'b%d', 'mass': 1, 'centre': [%d.5, 1],'inertia': 0.083333333333333333}", i, i);
    n += snprintf(text + n, sizeof text - (size_t)n, "], 'joints': [{'name': 'A', 'links': ['ground', 'c0'],'at': [0, 0]}");
    for (int i = 0, k = 1; i < 10; i++, k++)
        n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': 'A%d', 'links': ['ground', 'c%d'],'at': [%d, 0]}, {'name': 'B%d', 'links': ['c%d', "
                      "'b%d'], 'at': [%d, 1]},{'name': 'C%d', 'links': ['b%d', 'c%d'], 'at': [%d, 1]}", i, k, k, i, i, i, i, i, i, k, k);
    snprintf(text + n, sizeof text - (size_t)n, "], 'input': {'joint': 'A', 'speed': -1}, 'gravity': [0, -9.81],"
             "'tracers': [{'name': 'P', 'link': 'c0', 'at': [0, 1]}]}");
    json_quotes(text);
    lw_ode ode = { .n = 2, .rate = rate_of_ten };
    lw_ode_options o = { .relative = 1e-14, .absolute = 1e-14 };
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double work[LW_INTEGRATE_WORK(2, 0)], y[2] = { LW_PI/2, -1 };
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0, y, NULL), LW_OK);
    while (stop != LW_ODE_END && lw_integrate_step(&w, 5, &stop, NULL) == LW_OK) {
    }
    drun_read_text(&d, text);
    for (int f = -1; f < 2; f++) {
        watch of = { .first = 11, .n = 10 };
        lw_vec2 at = crank_end(f < 0 ? LW_FORMULATION_AUTO : all[f], 1e-11, 5, &of);
        CHECK_POINT(at, cos(w.y[0]), sin(w.y[0]), 1e-8, 0);
        CHECK(of.turned < 1e-9);
    }
}

/* Two rhombi in a row without gravity turn at a constant speed through the flat posture, before a stop without loss: the angle is a
 * triangular wave in every row.  Where the stop is too near for the tolerance, the run says so. */
TEST(stop_beside_a_flat_posture)
{
    static const double low[] = { -0.02, -0.05, -0.08, -0.2, -0.4 };
    double up = 0.38, speed = 2.7, high = 0.56, x[3], y = sin(up);
    int right = 0;
    char text[3000];
    for (int i = 0; i < 3; i++)
        x[i] = i + cos(up);
    for (int k = 0; k < 5; k++) {
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'c0', 'mass': 1, 'centre': [0, 0], 'inertia': 0.3},"
            "{'name': 'k0', 'mass': 1.2, 'centre': [%.17g, %.17g], 'inertia': 0.06}, {'name': 'c1', 'mass': 1.1, 'centre': [1, 0], 'inertia': 0.33},"
            "{'name': 'k1', 'mass': 1.2, 'centre': [%.17g, %.17g], 'inertia': 0.06}, {'name': 'c2', 'mass': 1.2, 'centre': [2, 0], 'inertia': 0.36}],"
            "'joints': [{'name': 'A', 'links': ['ground', 'c0'], 'at': [0, 0]}, {'name': 'B', 'links': ['ground', 'c1'], 'at': [1, 0]},"
            "{'name': 'C', 'links': ['ground', 'c2'], 'at': [2, 0]}, {'name': 'D', 'links': ['c0', 'k0'], 'at': [%.17g, %.17g]},"
            "{'name': 'E', 'links': ['k0', 'c1'], 'at': [%.17g, %.17g]}, {'name': 'F', 'links': ['c1', 'k1'], 'at': [%.17g, %.17g]},"
            "{'name': 'G', 'links': ['k1', 'c2'], 'at': [%.17g, %.17g], 'stop': {'least': %.17g, 'greatest': %.17g, 'restitution': 1}}],"
            "'input': {'joint': 'A', 'speed': %.17g}, 'tracers': [{'name': 'P', 'link': 'c0', 'at': [%.17g, %.17g]}]}", x[0] + 0.5, y, x[1] + 0.5, y, x[0], y, x[1], y, x[1], y, x[2], y, low[k] - up, high - up, -speed, x[0], y);
        drun_read_format(&d, text, 0, 0);
        for (double tolerance = 1e-6; tolerance > 1e-11; tolerance *= 1e-2) {
            int rows = k == 3 ? 8 : 20;      /* of 8, two lie in the flat posture */
            lw_status status = drun_to(&d, LW_FORMULATION_INDEX1, tolerance, k == 3 ? 4*(high - low[k])/speed : 2, rows);
            CHECK(status == LW_OK || status == LW_E_NUMERIC);
            right += status == LW_OK;
            for (int i = 0; status == LW_OK && i <= rows; i++) {
                double way = fmod(speed*d.t[i] + high - up, 2*(high - low[k]));
                CHECK_NEAR(d.tracer[i].y, sin(low[k] + fabs(high - low[k] - way)), 100*tolerance, 0);
                CHECK_NEAR(d.energy[i], d.energy[0], 1000*tolerance*d.energy[0], 0);      /* velocities */
            }
        }
    }
    CHECK(right >= 11);
}

typedef struct flat { lw_dynamics *d; lw_reaction at[4]; } flat;

static lw_status keep_flat(void *context, const lw_moment *m)
{
    flat *f = context;
    if (fabs(m->t - 0.25) < 1e-9)
        lw_reactions_joints(f->d, m, f->at);
    return LW_OK;
}

/* In the flat posture of a parallelogram forces along it have no limit; those across it carry the weights: half of the coupler at either end. */
TEST(reactions_across_a_flat_posture)
{
    static const double across[4] = { 1.5*9.81, 0.5*9.81, -0.5*9.81, 1.5*9.81 };
    flat f = { 0 };
    drun_read_text(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5], 'inertia': 0.1}, {'name': 'b', 'mass': 1, 'centre': "
                   "[2, 1], 'inertia': 0.1}, {'name': 'c', 'mass': 1, 'centre': [4, 0.5], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
                   "'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, 1]}, {'name': 'C', 'links': ['b', 'c'], 'at': [4, 1]}, {'name': 'D', 'links': "
                   "['ground', 'c'], 'at': [4, 0]}], 'gravity': [0, -9.81], 'input': {'joint': 'A', 'motion': 'pi/2 + 2*pi*t'}}");
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_QUASISTATIC, o.intervals = 4;
    CHECK_INT(lw_dynamics_make(&d.model, &o, &f.d, &d.e), LW_OK);
    CHECK_INT(lw_dynamics_run(f.d, keep_flat, &f, &d.report, &d.e), LW_OK);
    for (int j = 0; j < 4; j++) {
        CHECK(isnan(f.at[j].force.x) && f.at[j].moment == 0);
        CHECK_NEAR(f.at[j].force.y, across[j], 1e-7, 0);
    }
    lw_dynamics_free(f.d);
}

/* Drawn flat, a parallelogram can go on in two ways, however its crank is driven; no constraint is redundant.  A row of 20 is a large model. */
TEST(driven_from_a_flat_posture)
{
    static const char *motion[] = { "t", "t^2", "1 - cos(3*t)" };
    for (int n = 1; n <= 20; n += 19)
        for (int m = 0; m < 3; m++) {
            char text[9000];
            int k = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
            for (int i = 0; i <= n; i++)
                k += snprintf(text + k, sizeof text - (size_t)k, ", {'name': 'c%d', 'mass': 1, 'centre': [%d, 0], 'inertia': 0.1}", i, 3*i);
            for (int i = 0; i < n; i++)
                k += snprintf(text + k, sizeof text - (size_t)k, ", {'name': 'k%d', 'mass': 1, 'centre': [%d, 0], 'inertia': 0.1}", i, 3*i + 2);
            k += snprintf(text + k, sizeof text - (size_t)k, "], 'joints': [{'name': 'A', 'links': ['ground', 'c0'], 'at': [0, 0]}");
            for (int i = 0; i < n; i++)
                k += snprintf(text + k, sizeof text - (size_t)k, ", {'name': 'A%d', 'links': ['ground', 'c%d'], 'at': [%d, 0]}, {'name': 'B%d', "
                              "'links': ['c%d', 'k%d'], 'at': [%d, 0]}, {'name': 'C%d', 'links': ['k%d', 'c%d'], 'at': [%d, 0]}",
                              i + 1, i + 1, 3*i + 3, i, i, i, 3*i + 1, i, i, i + 1, 3*i + 4);
            snprintf(text + k, sizeof text - (size_t)k, "], 'gravity': [0, -9.81], 'input': {'joint': 'A', 'motion': '%s'}}", motion[m]);
            json_quotes(text);
            OWNED(lw_dynamics) *made = NULL;
            drun_read_text(&d, text);
            CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_E_NUMERIC);
            CHECK_HAS(d.e.text, "start is singular");
        }
}

/* ---- near misses --------------------------------------------------------------------------------- */

/* A rhombus whose coupler is longer by eps: no crank of it turns fully. */
static void read_rhombus(double eps)
{
    double b[2] = { 0.5, 0.5*sqrt(3) }, span = 1, along = (span*span + (1 + eps)*(1 + eps) - 1)/(2*span);
    double off = sqrt((1 + eps)*(1 + eps) - along*along);
    lw_vec2 to = lw_v2(1 - b[0], -b[1]), c = lw_v2(b[0] + along*to.x - off*to.y, b[1] + along*to.y + off*to.x);
    char text[2000];
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground',{'name': 'a', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.083},{'name': 'b', "
        "'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.083},{'name': 'c', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.083}], 'joints': ["
        "{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},{'name': 'B', 'links': ['a', 'b'], 'at': [%.17g, %.17g]},{'name': 'C', 'links': ['b', "
        "'c'], 'at': [%.17g, %.17g]},{'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0]}], 'input': {'joint': 'A', 'speed': -1},'gravity': [0, -9.81], "
        "'tracers': [{'name': 'P', 'link': 'c', 'at': [%.17g, %.17g]}]}", b[0]/2, b[1]/2,
        (b[0] + c.x)/2, (b[1] + c.y)/2, (1 + c.x)/2, c.y/2, b[0], b[1], c.x, c.y, c.x, c.y);
    drun_read_format(&d, text, 0, 0);
}

/* Equal crank and rod turn back 0.006 rad before the crank stands across the slide, where the slider's other motion begins.  Forces are great there, but
 * every row has them, the same by two formulations. */
TEST(forces_beside_a_flat_posture)
{
    drun_read_text(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'c', 'mass': 1.76, 'centre': [-0.763, 1.201], 'inertia': 0.42944}, {'name': 'r', "
        "'mass': 2.56, 'centre': [-0.985, 1.675], 'inertia': 0.76288}, {'name': 's', 'mass': 0.73, 'centre': [-1.231, 1.023], 'inertia': 0.17739}], "
        "'joints': [{'name': 'A', 'links': ['ground', 'c'], 'at': [-0.921, 1.182]}, {'name': 'B', 'links': ['c', 'r'], 'at': [-1.0121258450991724, "
        "1.6328836660990966]}, {'name': 'C', 'links': ['r', 's'], 'at': [-1.1032516901983447, 1.182]}, {'name': 'S', 'kind': 't', 'links': ['ground', "
        "'s'], 'at': [-1.1032516901983447, 1.182], 'along': [1, 0]}], 'springs': [{'links': ['r', 'ground'], 'at': [[0.414, 1.264], [-0.8, -0.719]], "
        "'stiffness': 23, 'free': 0.5}], 'input': {'joint': 'A', 'speed': -3.55}}");
    double l[2][8] = { { 0 } }, most = 0;
    for (int f = 0; f < 2; f++) {
        CHECK_INT(drun_to(&d, f ? LW_FORMULATION_AUTO : LW_FORMULATION_INDEX1, 1e-10, 0.11, 55), LW_OK);
        CHECK_INT(d.report.without_forces, 0);
        memcpy(l[f], d.l, sizeof l[f]);
    }
    for (int i = 0; i < 8; i++)
        most = fmax(most, fabs(l[0][i]));
    for (int i = 0; i < 8; i++)
        CHECK_NEAR(l[1][i], l[0][i], 1e-8*most, 0);
    lw_model_free(&d.model);
}

/* Where motion curves come near each other but do not meet, no formulation goes straight on: the input turns back
 * before its dead point, and all agree.  Curves nearer than the tolerance meet. */
TEST(near_misses)
{
    static const double eps[] = { 1e-2, -1e-2, 1e-3, 1e-4, -1e-4 };
    for (int k = 0; k < 5; k++) {
        read_rhombus(eps[k]);
        for (int f = 0; f < 2; f++) {
            watch w = { .n = 0 };
            lw_vec2 at = crank_end(f ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, 1e-12, 1.5, &w);
            double c = 1 + eps[k];
            CHECK(w.q[2] > (c > 1 ? -LW_PI/3 : -2*LW_PI));
            if (f)
                CHECK_POINT(at, other.tracer[0].x, other.tracer[0].y, 1e-8, 0);
            other.tracer[0] = at;
            CHECK(d.report.energy_error < 1e-10*d.report.energy_scale);
        }
    }
    read_rhombus(1e-9);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, 1.5, 10), LW_E_NUMERIC);
    CHECK_HAS(d.e.text, "two motion curves come within");
    CHECK_HAS(d.e.text, "greater tolerance");
    CHECK_INT(d.report.formulation, LW_FORMULATION_INDEX1);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 1.5, 10), LW_OK);
    other.tracer[0] = d.tracer[10];
    read_rhombus(0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-12, 1.5, 10), LW_OK);
    CHECK_POINT(d.tracer[10], other.tracer[0].x, other.tracer[0].y, 1e-5, 0);
}

/* ---- limits -------------------------------------------------------------------------------------- */

static volatile sig_atomic_t halt;

typedef struct counter { long calls, at, after; } counter;

static void count(void *context, double t, const lw_link_motion *link, lw_link_load *load)
{
    counter *c = context;
    (void)t, (void)link, (void)load;
    if (++c->calls == c->at)
        halt = 1;
    c->after += halt && c->calls > c->at;
}

/* Ctrl-C in the middle of a step ends the run at the next evaluation, however long the step would be repeated.  Implicit methods first
 * end the derivatives that they are working out, two differences for each of the 15 places and velocities. */
TEST(stopped_within_a_step)
{
    drun_read(&d, "examples/two-four-bars.json");
    for (int f = 1; f < 4; f++)
        for (long at = 500; at < 510; at++) {
            counter c = { .at = at };
            halt = 0;
            d.o.stop = &halt;
            d.o.force = (lw_caller_force){ .context = &c, .apply = count };
            CHECK_INT(drun_to(&d, all[f], 1e-10, 1e6, 1000000), LW_STOPPED);
            CHECK_HAS(d.e.text, "stopped at");
            CHECK(c.calls >= at && c.after <= (all[f] == LW_FORMULATION_GGL ? 2*2*15 : 2));
            CHECK(d.n_moment >= 1 && d.report.t < 10);
        }
}

/* A run makes as many steps as were allowed and no more, over all restarts behind singular postures. */
TEST(steps_allowed)
{
    drun_read(&d, "examples/two-four-bars.json");
    for (int f = 0; f < 4; f++)
        for (long most = 10; most <= 2000; most *= 200) {
            d.o.max_step = most;
            CHECK_INT(drun_to(&d, all[f], 1e-10, 1e5, 10), LW_STOPPED);
            CHECK(d.report.steps + d.report.refused >= most && d.report.steps <= most + 20);
            CHECK(d.report.t > 0 && d.report.t < 1000);
        }
}

/* Peaucellier's inversor, where its crank is thrown back at the end of its range, cos(x/2) = 2/3, while links without mass turn
 * infinitely fast.  A formulation may stop there, but `auto` must not continue with one that arrives elsewhere (0.1 m off at
 * 7e-8).  Reference: (J + m y'^2) x'' + m y' y'' x'^2 = -c x' with y = 16/3 tan(x/2), thrown back without loss, by Runge and Kutta's
 * method with steps of 5e-6 s. */
TEST(thrown_back_at_a_limit)
{
    double angle = -1.5142875007846848;
    int arrived = 0;
    drun_read(&d, "examples/dynamics/inversor.json");
    for (double tolerance = 1e-5; tolerance > 5e-10; tolerance /= 1.25) {
        lw_status status = drun_to(&d, LW_FORMULATION_AUTO, tolerance, 1, 10);
        CHECK(status == LW_OK || status == LW_E_NUMERIC);
        arrived += status == LW_OK;
        if (status == LW_OK)
            CHECK_NEAR(d.tracer[10].y, 16/3.*tan(0.5*angle), 5e-5, 0);
    }
    CHECK(arrived >= 20);
}
