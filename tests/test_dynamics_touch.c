/* Contact between shapes, ropes and free links: formulas of textbooks, and the laws of contact themselves at random. */
#include "base/rng.h"
#include "mbs/analysis/reactions.h"
#include "mbs/dynamics/statics.h"
#include "mbs/equations/complementarity.h"
#include "tests/dynamics_run.h"

static drun d;

static const double g = 9.81;

/* A model of the ground and one free link: its shape, mass and place, contact and gravity. */
#define FREE(ground, link, shape, contact)                                                                    \
    "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [" ground "]}, {'name': 'b', " link             \
    ", 'shapes': [" shape "]}], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', 'b']}],"            \
    " 'contacts': [{'name': 'c', 'links': ['ground', 'b'], " contact "}], 'gravity': [0, -9.81],"             \
    " 'tracers': [{'name': 'P', 'link': 'b', 'at': [0, 0]}]}"
#define FLOOR "{'line': [[0, 0], [1, 0]]}"

static void free_model(const char *format, double a, double b)
{
    drun_read_format(&d, format, a, b);
}

static double state(const double *q, int i) { return q[i]*(i%3 < 2 ? d.system.unit : 1); }

/* ---- the laws, at random ------------------------------------------------------------------------------- */

TEST(complementarity)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 0);
    for (int trial = 0; trial < 2000; trial++) {
        int n = 1 + (int)(5*lw_rng_uniform(&rng)), dof = 1 + (int)(6*lw_rng_uniform(&rng));
        double row[10][7], w[100], b[10], v[7], force[10], rate[10];
        lw_touch_law law[5];
        for (int k = 0; k < dof; k++)
            v[k] = 2*lw_rng_uniform(&rng) - 1;
        for (int i = 0; i < 2*n; i++) {                  /* rows repeat now and then: contacts that share a load */
            bool twin = i >= 2 && lw_rng_uniform(&rng) < 0.3;
            for (int k = 0; k < dof; k++)
                row[i][k] = twin ? row[i - 2][k] : 2*lw_rng_uniform(&rng) - 1;
        }
        for (int i = 0; i < 2*n; i++) {
            b[i] = 0;
            for (int k = 0; k < dof; k++)
                b[i] += row[i][k]*v[k];
            for (int j = 0; j < 2*n; j++) {
                w[i*2*n + j] = 0;
                for (int k = 0; k < dof; k++)
                    w[i*2*n + j] += row[i][k]*row[j][k];
            }
        }
        for (int i = 0; i < n; i++)
            law[i] = (lw_touch_law){ .friction = trial%3 ? 1.5*lw_rng_uniform(&rng) : 0,
                                     .least = trial%4 == 0 ? 0.3*lw_rng_uniform(&rng) : 0 };
        CHECK_INT(lw_complementarity(n, w, b, law, force, rate), LW_OK);
        double lost = 0;
        for (int i = 0; i < n; i++) {
            const double *f = force + 2*i, *r = rate + 2*i;
            double left = law[i].friction*f[0] - fabs(f[1]);
            CHECK(f[0] >= law[i].least - 1e-9 && r[0] >= -1e-8);
            CHECK(fmin(f[0] - law[i].least, r[0]) <= 1e-7);
            CHECK(left >= -1e-8);
            CHECK(left <= 1e-7 || fabs(r[1]) <= 1e-7);            /* sticks, or all friction acts, */
            CHECK(fabs(r[1]) <= 1e-7 || f[1]*r[1] <= 1e-12);      /* against the slip */
            lost += 0.5*(f[0]*(b[2*i] + r[0]) + f[1]*(b[2*i + 1] + r[1]));
        }
        if (trial%4 != 0)
            CHECK(lost <= 1e-9);                         /* impacts without restitution gain no energy */
    }
}

/* ---- one body ------------------------------------------------------------------------------------------- */

TEST(bouncing_ball)
{
    double e = 0.6, h = 1, t = sqrt(2*h/g), v = e*g*t;
    free_model(FREE(FLOOR, "'mass': 2, 'centre': [0, 1.1], 'inertia': 0.01", "{'circle': [0, 1.1], 'radius': 0.1}",
                    "'restitution': 0.6"), 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 3, 300), LW_OK);
    for (int k = 0; k < 20; k++) {
        CHECK_NEAR(d.report.event[k].t, t, 1e-12, 0);
        CHECK_NEAR(d.report.event[k].speed, -v/e, 1e-9, 0);
        t += 2*v/g;
        v *= e;
    }
    CHECK_NEAR(state(d.q, 1), 0.1, 1e-15, 0);
    CHECK_NEAR(d.v[1], 0, 1e-100, 0);
    CHECK_NEAR(d.report.energy_error, 0, 1e-11*d.report.energy_scale, 0);
    lw_model_free(&d.model);
}

/* A pendulum whose disc grazes a floor, a small disc or the end of a rope while it swings through: its loose run, which
 * takes a few steps a swing, strikes whenever the fine one does. */
TEST(grazing_passes)
{
    static const char *const contact = "'contacts': [{'name': 'c', 'links': ['ground', 'b'], 'restitution': %.17g}]";
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 12);
    for (int trial = 0; trial < 30; trial++) {
        double length = lw_rng_range(&rng, 0.5, 1.5), from = lw_rng_range(&rng, -2.2, -0.5), x = length*sin(from);
        double depth = length*pow(10, lw_rng_range(&rng, -6, -2)), e = lw_rng_range(&rng, 0.5, 0.9), y = -length*cos(from);
        char text[1500], shape[200] = "", own[300];
        if (trial%3 == 0)
            snprintf(shape, sizeof shape, "{'line': [[-1, %.17g], [1, %.17g]]}", depth - length - 0.05, depth - length - 0.05);
        else if (trial%3 == 1)
            snprintf(shape, sizeof shape, "{'circle': [0, %.17g], 'radius': 0.003}", depth - length - 0.053);
        snprintf(own, sizeof own, trial%3 < 2 ? contact : "'ropes': [{'name': 'c', 'links': ['ground', 'b'], "
                 "'restitution': %.17g, 'at': [[0, 0.7], [%.17g, %.17g]], 'length': %.17g}]", e, x, y, length + 0.7 - depth);
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [%s]}, {'name': 'b', 'mass': 1, "
                 "'centre': [%.17g, %.17g], 'inertia': 0.01, 'shapes': [{'circle': [%.17g, %.17g], 'radius': 0.05}]}], "
                 "'joints': [{'name': 'A', 'links': ['ground', 'b'], 'at': [0, 0]}], %s, "
                 "'input': {'joint': 'A', 'speed': %.17g}, 'gravity': [0, -9.81]}", shape, x, y, x, y, own,
                 lw_rng_range(&rng, -1, 1));
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 2, 2), LW_OK);
        double angle = d.q[2];
        int struck = d.report.n_event_seen;
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-6, 2, 2), LW_OK);
        CHECK_INT(d.report.n_event_seen, struck);
        CHECK_NEAR(d.q[2], angle, 1e-3, 0);
        lw_model_free(&d.model);
    }
}

TEST(block_on_incline)
{
    const char *incline = FREE("{'line': [[0, 0], [2, 1]]}", "'mass': 2, 'centre': [0.95, 0.6], 'inertia': 0.02",
                               "{'polygon': [[0.8, 0.4], [1.2, 0.6], [1.1, 0.8], [0.7, 0.6]]}", "'friction': %.17g");
    double slope = atan(0.5), mu = 0.3, a = g*(sin(slope) - mu*cos(slope)), t = 2;
    free_model(incline, 0.501, 0);                       /* rests, for long */
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1e5, 10), LW_OK);
    CHECK_NEAR(state(d.q, 0), 0.95, 1e-13, 0);
    CHECK_NEAR(state(d.q, 1), 0.6, 1e-13, 0);
    CHECK_NEAR(d.v[0], 0, 1e-15, 0);
    lw_model_free(&d.model);
    free_model(incline, mu, 0);                          /* slides */
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, t, 10), LW_OK);
    CHECK_NEAR(state(d.q, 0), 0.95 - 0.5*a*t*t*cos(slope), 1e-12, 0);
    CHECK_NEAR(state(d.q, 1), 0.6 - 0.5*a*t*t*sin(slope), 1e-12, 0);
    CHECK_NEAR(d.q[2], 0, 1e-13, 0);
    lw_model_free(&d.model);
}

/* A ball rolls with 5/7 of the acceleration of a frictionless block, a disc with 2/3; with too little friction both slip. */
TEST(rolling_wheel)
{
    double slope = 0.3, r = 0.2, t = 1.5;
    char line[1500];
    for (int k = 0; k < 3; k++) {
        double share = k == 0 ? 0.4 : 0.5, mu = k < 2 ? 0.5 : 0.05, a = g*sin(slope)/(1 + share), alpha = -a/r;
        if (k == 2) {
            a = g*(sin(slope) - mu*cos(slope));
            alpha = -mu*g*cos(slope)/(share*r);
        }
        snprintf(line, sizeof line, FREE("{'line': [[0, 0], [%.17g, %.17g]]}", "'mass': 3, 'centre': [%.17g, %.17g], 'inertia': %.17g",
                                         "{'circle': [%.17g, %.17g], 'radius': 0.2}", "'friction': %.17g"),
                 cos(slope), -sin(slope), r*sin(slope), r*cos(slope), share*3*r*r, r*sin(slope), r*cos(slope), mu);
        drun_read_format(&d, line, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, t, 6), LW_OK);
        CHECK_NEAR(state(d.q, 0), r*sin(slope) + 0.5*a*t*t*cos(slope), 1e-12, 0);
        CHECK_NEAR(state(d.q, 1), r*cos(slope) - 0.5*a*t*t*sin(slope), 1e-12, 0);
        CHECK_NEAR(d.q[2], 0.5*alpha*t*t, 1e-12, 0);
        CHECK(d.report.energy_error < 1e-12*d.report.energy_scale);
        lw_model_free(&d.model);
    }
}

/* A bowling ball slips until t = 2 v/(7 mu g), then rolls at 5/7 v. */
TEST(bowling_ball)
{
    double v = 7, mu = 0.2, until = 2*v/(7*mu*g), t = 2;
    free_model(FREE(FLOOR, "'mass': 2, 'centre': [0, 0.2], 'inertia': 0.032, 'velocity': [7, 0]",
                    "{'circle': [0, 0.2], 'radius': 0.2}", "'friction': 0.2"), 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, t, 10), LW_OK);
    CHECK_NEAR(state(d.v, 0), 5*v/7, 1e-11, 0);
    CHECK_NEAR(d.v[2], -5*v/7/0.2, 1e-10, 0);
    CHECK_NEAR(state(d.q, 0), v*until - 0.5*mu*g*until*until + 5*v/7*(t - until), 1e-11, 0);
    lw_model_free(&d.model);
}

/* A rod of length 1 falls from the angle a0; its foot, at the origin, slips where friction no longer holds it.
 * y: angle, rate, place and speed of the foot.  mode 0: sticks, N and T from the motion. */
typedef struct foot { double mu; int slips; } foot;

static void foot_forces(const double *y, double *normal, double *across)
{
    double a = y[0], w = y[1], alpha = -1.5*g*cos(a);            /* about the foot, length 1 */
    *normal = g + 0.5*(alpha*cos(a) - w*w*sin(a));               /* per mass */
    *across = 0.5*(-alpha*sin(a) - w*w*cos(a));
}

static lw_status rod_rate(void *context, double t, const double *y, double *dy)
{
    const foot *f = context;
    double a = y[0], w = y[1], s = f->slips, c = cos(a), n = sin(a), alpha = -1.5*g*c;
    (void)t;
    if (f->slips) {
        /* N = g + (alpha c - w^2 n)/2,  T = -mu s N,  alpha/12 = -N c/2 + T n/2 (lever arms of the foot) */
        double lever = -0.5*c - 0.5*f->mu*s*n;
        alpha = 12*lever*(g - 0.5*w*w*n)/(1 - 6*lever*c);
        double normal = g + 0.5*(alpha*c - w*w*n);
        dy[3] = -f->mu*s*normal + 0.5*(alpha*n + w*w*c);         /* of the foot */
    } else
        dy[3] = 0;
    dy[0] = w;
    dy[1] = alpha;
    dy[2] = f->slips ? y[3] : 0;
    return LW_OK;
}

TEST(falling_rod)
{
    double mu = 0.2, a0 = 80*LW_PI/180, y[4] = { a0, 0, 0, 0 }, normal, across, lo = 0.1, hi = 0.5, end = 0.55;
    foot f = { mu, 0 };
    lw_ode ode = { .n = 4, .context = &f, .rate = rod_rate };
    for (int i = 0; i < 60; i++) {                       /* when does friction end? */
        double at[4] = { a0, 0, 0, 0 }, t = 0.5*(lo + hi);
        drun_exact(&ode, 0, at, t);
        foot_forces(at, &normal, &across);
        *(fabs(across) > mu*normal ? &hi : &lo) = t;
    }
    drun_exact(&ode, 0, y, lo);
    foot_forces(y, &normal, &across);
    f.slips = across > 0 ? -1 : 1;
    drun_exact(&ode, lo, y, end);
    free_model(FREE(FLOOR, "'mass': 3, 'centre': [%.17g, %.17g], 'inertia': 0.25",
                    "{'segment': [[0, 0], [0.1736481776669304, 0.984807753012208]]}", "'friction': 0.2"), 0.5*cos(a0), 0.5*sin(a0));
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, end, 10), LW_OK);
    CHECK_NEAR(d.q[2], y[0] - a0, 1e-9, 0);
    CHECK_NEAR(d.tracer[10].x, y[2], 1e-9, 0);
    CHECK_NEAR(d.tracer[10].y, 0, 1e-14, 0);
    CHECK(d.report.energy_error < 1e-10*d.report.energy_scale);
    lw_model_free(&d.model);
}

/* Painleve's rod: its foot slides ahead of it with mu = 2, where no force goes on with the motion.  An impulse at the
 * foot ends the slip: the angular momentum about the foot stays. */
TEST(painleve)
{
    double a = LW_PI/3, v = 5, inertia = 1/12.0 + 0.25;
    free_model(FREE(FLOOR, "'mass': 1, 'centre': [-0.25, 0.4330127018922193], 'inertia': 0.08333333333333333, 'velocity': [%.17g, 0]",
                    "{'segment': [[0, 0], [-0.5, 0.8660254037844386]]}", "'friction': 2"), v, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1e-9, 1), LW_OK);
    CHECK_NEAR(d.v[2], -v*0.5*sin(a)/inertia, 1e-7, 0);
    CHECK_NEAR(state(d.v, 0), -d.v[2]*0.5*sin(a), 1e-7, 0);      /* the foot is at rest */
    CHECK_NEAR(state(d.v, 1), -d.v[2]*0.5*cos(a), 1e-7, 0);
    CHECK(d.report.n_event == 1 && d.report.event[0].impact);
    lw_model_free(&d.model);
}

/* A weight on a rope, v at the lowest point with 2 g L < v^2 < 5 g L: slack where cos = (v^2 - 2 g L)/(3 g L). */
static lw_status pendulum_rate(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1];
    dy[1] = -g*sin(y[0]);
    return LW_OK;
}

TEST(slack_rope)
{
    double v = 5.86, up = (v*v - 2*g)/(3*g), slack = acos(-up), lo = 0.2, hi = 0.6;
    lw_ode ode = { .n = 2, .rate = pendulum_rate };
    for (int i = 0; i < 60; i++) {
        double y[2] = { 0, v }, t = 0.5*(lo + hi);
        drun_exact(&ode, 0, y, t);
        *(y[0] > slack ? &hi : &lo) = t;
    }
    double speed = sqrt(g*up), x = sin(slack), y = -cos(slack), vx = speed*cos(slack), vy = speed*sin(slack);
    double flight = 4*speed*sin(slack)/g;                /* the parabola meets the circle again */
    drun_read(&d, "examples/dynamics/rope.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, lo + 0.5, 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, x + 0.5*vx, 1e-9, 0);
    CHECK_NEAR(d.tracer[1].y, y + 0.5*vy - 0.125*g, 1e-9, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, 2, 10), LW_OK);
    CHECK_NEAR(d.report.event[0].t, lo, 1e-9, 0);
    CHECK_NEAR(d.report.event[1].t, lo + flight, 1e-9, 0);
    CHECK(!d.report.event[0].impact && d.report.event[1].impact);
    CHECK_NEAR(lw_v2_norm(d.tracer[10]), 1, 1e-12, 0);   /* taut again, without restitution */
    lw_model_free(&d.model);
}

/* Compliant, without damping: the ball comes back to where it fell from; contact lasts  2 (pi - atan(v w/g))/w. */
TEST(compliant_ball)
{
    double stiffness = 1e4, mass = 2, h = 1, w = sqrt(stiffness/mass), fall = sqrt(2*h/g), v = g*fall;
    double lasts = 2*(LW_PI - atan(v*w/g))/w;
    free_model(FREE(FLOOR, "'mass': 2, 'centre': [0, 1.1], 'inertia': 0.01", "{'circle': [0, 1.1], 'radius': 0.1}",
                    "'stiffness': 1e4"), 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, 2*fall + lasts, 10), LW_OK);
    CHECK_NEAR(state(d.q, 1), 1.1, 1e-9, 0);
    CHECK_NEAR(state(d.v, 1), 0, 1e-9, 0);
    lw_model_free(&d.model);
}

/* ---- several bodies --------------------------------------------------------------------------------------- */

#define BALL(name, x, v)                                                                                          \
    "{'name': '" name "', 'mass': 1, 'centre': [" x ", 0], 'inertia': 0.01, 'velocity': [" v ", 0], 'shapes': ["   \
    "{'circle': [" x ", 0], 'radius': 0.1}]}"
#define TIE(name) "{'name': '" name "', 'kind': 'n', 'links': ['ground', '" name "']}"

TEST(cradle)
{
    static const double want[2][3] = { { 0, 0, 1 }, { 1/3.0, 1/3.0, 1/3.0 } };
    for (int k = 0; k < 2; k++) {
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', " BALL("a", "0", "1") ", " BALL("b", "0.5", "0") ", "
                         BALL("c", "0.7", "0") "], 'joints': [" TIE("a") ", " TIE("b") ", " TIE("c") "], 'contacts': ["
                         "{'links': ['a', 'b'], 'restitution': %g}, {'links': ['b', 'c'], 'restitution': %g}]}",
                         k == 0, k == 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 2), LW_OK);
        for (int b = 0; b < 3; b++)
            CHECK_NEAR(state(d.v, 3*b), want[k][b], 1e-12, 0);
        lw_model_free(&d.model);
    }
}

/* The cradle of the examples for two impacts: all of the swing goes through the middle ball, whatever rows are asked for,
 * and none of it is lost to the rounding of an impact. */
TEST(hanging_cradle)
{
    static const int rows[] = { 5, 10, 20, 40, 77 };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        drun_read(&d, "examples/dynamics/newtons-cradle.json");
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, rows[i]), LW_OK);
        CHECK_NEAR(d.v[2], -4.5518, 1e-4, 0);            /* the first ball swings, the others hang */
        CHECK_NEAR(d.v[5], 0, 1e-6, 0);
        CHECK_NEAR(d.v[8], 0, 1e-6, 0);
        CHECK_NEAR(0.5*0.1*0.3*0.3*d.v[2]*d.v[2], 0.1*9.81*(0.15 - (state(d.q, 1))), 1e-6, 0);
        lw_model_free(&d.model);
    }
}

/* Boxes fall on each other, bounce, rock and stay. */
TEST(boxes)
{
    drun_read(&d, "examples/dynamics/boxes.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 4, 4), LW_OK);
    for (int i = 0; i < 9; i++)
        CHECK(fabs(d.v[i]) < 1e-14);
    for (int b = 0; b < 3; b++) {
        CHECK_NEAR(state(d.q, 3*b + 1), 0.1 + 0.2*b, 1e-12, 0);
        CHECK_NEAR(d.q[3*b + 2], 0, 1e-12, 0);
    }
    CHECK(d.report.energy_error < 1e-8*d.report.energy_scale);
    lw_model_free(&d.model);
}

/* A disc in a groove: both sides carry, N = m g/(2 cos a). */
typedef struct loads { double least_x, most_x, fy; const lw_dynamics *m; } loads;

static lw_status keep_loads(void *context, const lw_moment *m)
{
    loads *l = context;
    lw_vec2 f[2];
    lw_reactions_contacts(l->m, m, f, NULL);
    l->fy = f[0].y;
    l->most_x = f[0].x;
    return LW_OK;
}

TEST(groove)
{
    lw_dynamics *m;
    loads l = { 0 };
    free_model(FREE("{'polygon': [[-2, 2], [-2, -1], [2, -1], [2, 2], [0, 0]]}", "'mass': 2, 'centre': [0, 1], 'inertia': 0.5",
                    "{'circle': [0, 1], 'radius': 0.7071067811865476}", "'friction': 0.1"), 0, 0);
    d.o.to = 3;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
    l.m = m;
    CHECK_INT(lw_dynamics_run(m, keep_loads, &l, &d.report, &d.e), LW_OK);
    CHECK_NEAR(l.fy, 2*g, 1e-9, 0);
    CHECK_NEAR(l.most_x, 0, 1e-9, 0);
    lw_dynamics_free(m);
    lw_model_free(&d.model);
}

/* ---- at rest --------------------------------------------------------------------------------------------- */

static lw_status add_loads(void *context, const lw_moment *m)
{
    loads *l = context;
    lw_vec2 f[8];
    lw_reactions_contacts(l->m, m, f, NULL);
    for (int i = 0; i < d.model.n_contact; i++)
        l->fy += f[i].y, l->most_x += f[i].x;
    CHECK(m->v[0] == 0 && m->a[0] == 0);
    return LW_OK;
}

/* Contacts carry the weight of the model that was read, at rest; or `expected`. */
static void settle(lw_status expected)
{
    loads l = { 0 };
    lw_rest rest;
    lw_dynamics *m = NULL;
    double weight = 0;
    d.o.analysis = LW_ANALYSIS_STATIC;
    for (int b = 0; b < d.model.linkage.n_link; b++)
        weight += g*d.model.body[b].mass;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
    l.m = m;
    CHECK_INT(lw_dynamics_analyse(m, add_loads, &l, &d.report, &rest, &d.e), expected);
    CHECK_NEAR(l.fy, expected == LW_OK ? weight : 0, 0, 1e-6);
    CHECK_NEAR(l.most_x, 0, 1e-6*weight, 0);
    lw_dynamics_free(m);
    lw_model_free(&d.model);
}

TEST(statics)
{
    static const char *const examples[] = { "examples/dynamics/hook.json", "examples/dynamics/walking-machine.json" };
    const char *incline = FREE("{'line': [[0, 0], [2, 1]]}", "'mass': 2, 'centre': [0.95, 0.6], 'inertia': 0.02",
                               "{'polygon': [[0.8, 0.4], [1.2, 0.6], [1.1, 0.8], [0.7, 0.6]]}", "'friction': %.17g");
    for (int i = 0; i < 2; i++) {
        drun_read(&d, examples[i]);
        settle(LW_OK);
    }
    free_model(incline, 0.501, 0);
    settle(LW_OK);
    free_model(incline, 0.499, 0);                       /* slips for ever */
    settle(LW_NOTHING);
    free_model(FREE("{'polygon': [[-2, 2], [-2, -1], [2, -1], [2, 2], [0, 0]]}", "'mass': 2, 'centre': [0, 1.3], 'inertia': 0.5",
                    "{'circle': [0, 1.3], 'radius': 0.7071067811865476}", "'friction': 0.1"), 0, 0);
    settle(LW_OK);
}

TEST(hook_holds)
{
    drun_read(&d, "examples/dynamics/hook.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 3, 300), LW_OK);
    for (int k = 0; k <= 300; k++)                       /* the bar hangs on its pin, 0.184 long, within the hook */
        CHECK(d.tracer[k].y < -0.09 && d.tracer[k].y > -0.2 && fabs(d.tracer[k].x) < 0.2);
    CHECK(d.report.energy_error < 1e-8*d.report.energy_scale);
    lw_model_free(&d.model);
}

/* Four legs stand, then walk: forward, upright, without falling. */
TEST(walking_machine)
{
    drun_read(&d, "examples/dynamics/walking-machine.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-7, 3, 60), LW_OK);
    for (int k = 0; k <= 60; k++) {
        CHECK_NEAR(d.tracer[k].y, d.tracer[0].y, 0.006, 0);
        CHECK(k < 10 || d.tracer[k].x > d.tracer[k - 5].x);
    }
    CHECK(d.tracer[60].x > 0.6 && fabs(d.q[2]) < 0.02);
    CHECK(d.report.energy_error < 1e-6*d.report.energy_scale);
    lw_model_free(&d.model);
}

/* A wavy chain of n links falls on the ground: rigid, or compliant, which has no size limit. */
typedef struct fallen { double q[24], push, energy; lw_dynamics *d; } fallen;

static lw_status keep_fallen(void *context, const lw_moment *m)
{
    fallen *f = context;
    const lw_model *model = lw_dynamics_model(f->d);
    lw_vec2 *contact = calloc((size_t)model->n_contact + 1, sizeof *contact);
    double none[1];
    lw_reactions_contacts(f->d, m, contact, none);
    memcpy(f->q, m->q, sizeof f->q);
    f->energy = m->kinetic;
    f->push = 0;
    for (int i = 0; i < model->n_contact; i++)
        f->push += contact[i].y;
    free(contact);
    return LW_OK;
}

static fallen falling_chain(int n, const char *law, double to, lw_formulation formulation, double tolerance, double energy)
{
    size_t size = 600*(size_t)n + 1000, used = 0;
    char *text = malloc(size);
    used += (size_t)snprintf(text + used, size - used, "{\"linkwright\": 1, \"gravity\": [0, -9.81], \"links\": [{\"name\": \"ground\", "
                             "\"shapes\": [{\"line\": [[0, 0], [1, 0]]}]}");
    for (int i = 0; i < n; i++) {
        double x = 0.1*i, y0 = 0.2 + 0.05*sin(0.6*i), y1 = 0.2 + 0.05*sin(0.6*(i + 1));
        used += (size_t)snprintf(text + used, size - used, ", {\"name\": \"l%d\", \"mass\": 0.1, \"centre\": [%.9g, %.9g], "
                                 "\"inertia\": 1e-4, \"shapes\": [{\"segment\": [[%.9g, %.9g], [%.9g, %.9g]], \"radius\": 0.005}]}",
                                 i, x + 0.05, 0.5*(y0 + y1), x, y0, x + 0.1, y1);
    }
    used += (size_t)snprintf(text + used, size - used, "], \"joints\": [{\"name\": \"F\", \"kind\": \"n\", \"links\": [\"ground\", \"l0\"]}");
    for (int i = 1; i < n; i++)
        used += (size_t)snprintf(text + used, size - used, ", {\"name\": \"j%d\", \"links\": [\"l%d\", \"l%d\"], \"at\": [%.9g, %.9g]}",
                                 i, i - 1, i, 0.1*i, 0.2 + 0.05*sin(0.6*i));
    used += (size_t)snprintf(text + used, size - used, "], \"contacts\": [");
    for (int i = 0; i < n; i++)
        used += (size_t)snprintf(text + used, size - used, "%s{\"name\": \"c%d\", \"links\": [\"ground\", \"l%d\"], %s}", i ? ", " : "",
                                 i, i, law);
    snprintf(text + used, size - used, "]}");
    lw_model m;
    lw_dynamics *run;
    lw_error e = { 0 };
    lw_dynamics_report r = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    o.relative = o.absolute = tolerance;
    o.formulation = formulation;
    o.to = to;
    o.intervals = 4;
    fallen f = { .d = NULL };
    CHECK_INT(lw_model_read(text, strlen(text), "text", &m, &e), LW_OK);
    CHECK_INT(lw_dynamics_make(&m, &o, &run, &e), LW_OK);
    f.d = run;
    CHECK_INT(lw_dynamics_run(run, keep_fallen, &f, &r, &e), LW_OK);
    if (r.samples != 5)
        fprintf(stderr, "chain of %d: %s\n", n, e.text);
    CHECK(r.energy_error < energy*r.energy_scale);
    CHECK(r.overlap <= 0.06*pow(tolerance, 0.2));        /* the way within a step */
    lw_dynamics_free(run);
    lw_model_free(&m);
    free(text);
    return f;
}

/* ---- prescribed motion, and rest -------------------------------------------------------------------------- */

typedef struct carried { const lw_dynamics *d; double drive; lw_vec2 contact; lw_reaction pin; } carried;

static lw_status keep_carried(void *context, const lw_moment *m)
{
    carried *z = context;
    double rope[1];
    lw_reactions_driving(z->d, m, &z->drive);
    lw_reactions_joints(z->d, m, &z->pin);
    lw_reactions_contacts(z->d, m, &z->contact, rope);
    return LW_OK;
}

static lw_status carry(lw_analysis analysis, double to, int intervals, carried *z)
{
    lw_dynamics *m = NULL;
    lw_rest rest;
    d.o.analysis = analysis;
    d.o.to = to;
    d.o.intervals = intervals;
    d.e.text[0] = 0;
    lw_status s = lw_dynamics_make(&d.model, &d.o, &m, &d.e);
    z->d = m;
    s = s == LW_OK ? lw_dynamics_analyse(m, keep_carried, z, &d.report, &rest, &d.e) : s;
    lw_dynamics_free(m);
    return s;
}

/* A bar of length 1 with a round end, 0.1, that turns from the level at -2 rad/s over a floor. */
#define TURNING(contact) "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'line': [[0, %.17g], [1, %.17g]]}]}," \
    " {'name': 'bar', 'mass': 2, 'centre': [0.5, 0], 'inertia': 0.3, 'shapes': [{'circle': [1, 0], 'radius': 0.1}]}], 'joints': [{'name': 'A'," \
    " 'links': ['ground', 'bar'], 'at': [0, 0]}], 'contacts': [{'links': ['ground', 'bar']" contact "}], 'input': {'joint': 'A', 'motion': '-2*t'}}"

/* A compliant floor presses by its law, with and without inertia.  A rigid one is named at the time at which it is
 * touched, also between the samples; a floor just below is not. */
TEST(prescribed_motion)
{
    carried z;
    const double to = 0.8, c = cos(2*to), s = sin(2*to), depth = s + 0.1 - 1.05, push = 1e4*depth;
    for (int k = 0; k < 2; k++) {
        free_model(TURNING(", 'stiffness': 1e4, 'damping': 0.5, 'friction': 0.3, 'friction_speed': 0.01"), -1.05, -1.05);
        CHECK_INT(carry(k ? LW_ANALYSIS_QUASISTATIC : LW_ANALYSIS_KINEMATIC, to, 3, &z), LW_OK);
        double normal = k ? push : push*(1 + 0.5*2*c), slip = -2*s - 2*0.1, across = k ? 0 : -0.3*normal*tanh(slip/0.01);
        CHECK_NEAR(z.contact.y, normal, 0, 1e-11);
        CHECK_NEAR(z.contact.x, across, 1e-11, 1e-11);
        /* about the pin: weight, and contact at the deepest point of the disc; no angular acceleration */
        CHECK_NEAR(z.drive, 2*g*0.5*c - c*normal - (s + 0.1)*across, 0, 1e-10);
        CHECK(d.report.no_friction == (k == 1));
        lw_model_free(&d.model);
    }
    for (int n = 3; n < 200; n *= 8) {
        free_model(TURNING(""), -1.0999999, -1.0999999);
        CHECK_INT(carry(LW_ANALYSIS_KINEMATIC, 1.6, n, &z), LW_E_KIND);
        CHECK_HAS(d.e.text, "touch at t = 0.785");
        lw_model_free(&d.model);
        free_model(TURNING(""), -1.1000001, -1.1000001);
        CHECK_INT(carry(LW_ANALYSIS_KINEMATIC, 1.6, n, &z), LW_OK);
        lw_model_free(&d.model);
    }
    free_model(TURNING(", 'stiffness': 1e4, 'friction': 0.3"), -1.05, -1.05);
    CHECK_INT(carry(LW_ANALYSIS_KINEMATIC, 1.6, 3, &z), LW_E_KIND);
    CHECK_HAS(d.e.text, "friction_speed");
    lw_model_free(&d.model);
}

/* A bar that lies on a compliant support: pin and support carry its weight, and its moment. */
TEST(compliant_rest)
{
    carried z;
    free_model("{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'circle': [2, -0.5], 'radius': 0.5}]}, {'name': 'bar',"
               " 'mass': 1, 'centre': [%.9g, 0.1], 'inertia': 0.3, 'shapes': [{'segment': [[0.5, 0.1], [3, 0.1]], 'radius': 0.05}]}], 'joints': [{'name': 'A',"
               " 'links': ['ground', 'bar'], 'at': [0, 0.1]}], 'contacts': [{'links': ['ground', 'bar'], 'stiffness': %.9g, 'damping': 10}]}", 1, 1e7);
    CHECK_INT(carry(LW_ANALYSIS_STATIC, 1, 1, &z), LW_OK);
    CHECK_NEAR(z.contact.y + z.pin.force.y, g, 0, 1e-7);
    CHECK_NEAR(z.contact.x + z.pin.force.x, 0, 1e-6, 0);
    CHECK_NEAR(z.contact.y, g/2, 0, 0.01);               /* the bar sinks by the gap of 0.05: its slope is 0.025 */
    lw_model_free(&d.model);
}

/* ---- random scenes ------------------------------------------------------------------------------------------ */

static lw_rng scene;

static double draw(double lo, double hi) { return lw_rng_range(&scene, lo, hi); }

/* A disc, a bar, a box or a triangle about (x, y). */
static int put_shape(char *to, size_t size, double x, double y)
{
    int kind = (int)draw(0, 4), n = 0;
    double a = draw(0, 6.28), corner[4][2], w = draw(0.1, 0.2), h = draw(0.1, 0.2);
    if (kind == 0)
        return snprintf(to, size, "{'circle': [%.9g, %.9g], 'radius': 0.15}", x, y);
    if (kind == 1)
        return snprintf(to, size, "{'segment': [[%.9g, %.9g], [%.9g, %.9g]], 'radius': 0.03}", x - 0.2*cos(a), y - 0.2*sin(a),
                        x + 0.2*cos(a), y + 0.2*sin(a));
    int corners = kind + 1 == 3 ? 3 : 4;
    for (int k = 0; k < corners; k++) {
        double u = corners == 4 ? (k == 0 || k == 3 ? -w : w) : 0.2*cos(2.1*k), v = corners == 4 ? (k < 2 ? -h : h) : 0.2*sin(2.1*k);
        corner[k][0] = x + u*cos(a) - v*sin(a);
        corner[k][1] = y + u*sin(a) + v*cos(a);
    }
    n += snprintf(to, size, "{'polygon': [");
    for (int k = 0; k < corners; k++)
        n += snprintf(to + n, size - (size_t)n, "%s[%.9g, %.9g]", k ? ", " : "", corner[k][0], corner[k][1]);
    return n + snprintf(to + n, size - (size_t)n, "]}");
}

/* Bodies thrown into a box, with any friction and restitution: energy is accounted for, none comes from contact, and
 * nothing leaves the box.  Every scene runs to its end.  LW_SCAN=N takes N scenes. */
TEST(random_scenes)
{
    static char text[8000];
    int complete = 0, trials = getenv("LW_SCAN") ? atoi(getenv("LW_SCAN")) : 10;
    lw_rng_seed(&scene, check_seed(), 3);
    for (int trial = 0; trial < trials; trial++) {
        int n = 1 + (int)draw(0, 3);
        size_t used = 0;
        double mu = draw(0, 0.7), e = draw(0, 1) < 0.5 ? 0 : draw(0, 0.9);
        used += (size_t)snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': "
                                 "[{'polygon': [[-2, -1], [2, -1], [2, 3], [1.5, 3], [1.5, 0], [-1.5, 0], [-1.5, 3], [-2, 3]]}]}");
        for (int i = 0; i < n; i++) {
            double x = draw(-1, 1), y = 0.6 + 0.5*i;
            used += (size_t)snprintf(text + used, sizeof text - used, ", {'name': 'b%d', 'mass': 1, 'centre': [%.9g, %.9g], 'inertia': 0.01, "
                                     "'velocity': [%.9g, %.9g], 'omega': %.9g, 'shapes': [", i, x, y, draw(-1, 1), draw(-1, 1), draw(-3, 3));
            used += (size_t)put_shape(text + used, sizeof text - used, x, y);
            used += (size_t)snprintf(text + used, sizeof text - used, "]}");
        }
        used += (size_t)snprintf(text + used, sizeof text - used, "], 'joints': [");
        for (int i = 0; i < n; i++)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s{'name': 'F%d', 'kind': 'n', 'links': ['ground', 'b%d']}",
                                     i ? ", " : "", i, i);
        used += (size_t)snprintf(text + used, sizeof text - used, "], 'contacts': [");
        for (int i = 0; i < n; i++)
            for (int j = -1; j < i; j++) {
                char other[16] = "ground";
                if (j >= 0)
                    snprintf(other, sizeof other, "b%d", j);
                used += (size_t)snprintf(text + used, sizeof text - used, "%s{'links': ['%s', 'b%d'], 'friction': %.9g, 'restitution': %.9g}",
                                         i + j >= 0 ? ", " : "", other, i, mu, e);
            }
        snprintf(text + used, sizeof text - used, "]}");
        for (char *c = text; *c; c++)
            *c = *c == '\'' ? '"' : *c;
        drun_read_text(&d, text);
        complete += drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 20) == LW_OK;
        CHECK(d.status == LW_OK || d.e.text[0]);
        CHECK(d.report.energy_error < 1e-7*d.report.energy_scale);
        for (int k = 1; k < d.n_moment; k++)
            CHECK(d.energy[k] <= d.energy[k - 1] + 1e-7*d.report.energy_scale);
        for (int b = 0; b < n; b++)
            CHECK(fabs(state(d.q, 3*b)) < 1.5 && state(d.q, 3*b + 1) > 0.029);
        lw_model_free(&d.model);
    }
    CHECK_INT(complete, trials);
}

/* ---- refused ---------------------------------------------------------------------------------------------- */

TEST(refused)
{
    lw_dynamics *m;
    free_model(FREE(FLOOR, "'mass': 2, 'centre': [0, 0.05], 'inertia': 0.01", "{'circle': [0, 0.05], 'radius': 0.1}",
                    "'restitution': 0.6"), 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 10), LW_E_ARG);
    CHECK(strstr(d.e.text, "overlap") != NULL);
    d.o.analysis = LW_ANALYSIS_QUASISTATIC;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_E_KIND);
    d.o.analysis = LW_ANALYSIS_TRANSIENT;
    for (lw_formulation f = LW_FORMULATION_QUADRATURE; f <= LW_FORMULATION_GGL; f++) {
        d.o.formulation = f;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), f == LW_FORMULATION_INDEX1 || f == LW_FORMULATION_CAPTURE ? LW_OK : LW_E_KIND);
        lw_dynamics_free(m);
    }
    lw_model_free(&d.model);
}

TEST(falling_chains)
{
    const char *rigid = "\"friction\": 0.5";
    falling_chain(60, "\"friction\": 0.5, \"friction_speed\": 0.02, \"stiffness\": 3000, \"damping\": 1", 0.25, LW_FORMULATION_AUTO,
                  1e-6, 1e-5);
    /* captured contacts come near the located ones, the nearer the smaller the tolerance */
    fallen exact = falling_chain(8, rigid, 0.5, LW_FORMULATION_AUTO, 1e-6, 1e-5);
    for (int k = 0; k < 2; k++) {
        fallen f = falling_chain(8, rigid, 0.5, LW_FORMULATION_CAPTURE, k ? 1e-10 : 1e-5, k ? 3e-3 : 2e-2);
        for (int i = 0; i < 24; i++)
            CHECK_NEAR(f.q[i], exact.q[i], k ? 2e-3 : 0.02, 0);
    }
    /* many links come to rest on the ground, which carries their weight */
    fallen many = falling_chain(100, rigid, 1, LW_FORMULATION_AUTO, 1e-6, 2e-2);
    CHECK(many.energy < 1e-6);
    CHECK_NEAR(many.push, 100*0.1*g, 0, 1e-3);
}

/* A ball that flies free, with nothing near it, falls as Galileo says; captured, it has no rows to solve for. */
TEST(captured_far_from_contact)
{
    drun_read_text(&d, "{\"linkwright\": 1, \"gravity\": [0, -9.81], \"links\": [{\"name\": \"ground\", \"shapes\": [{\"line\": [[0, 0], [1, 0]]}]}, "
        "{\"name\": \"ball\", \"mass\": 2, \"centre\": [0.5, 9], \"inertia\": 0.03, \"shapes\": [{\"circle\": [0.5, 9], \"radius\": 0.2}]}], "
        "\"joints\": [{\"name\": \"F\", \"kind\": \"n\", \"links\": [\"ground\", \"ball\"]}], "
        "\"contacts\": [{\"name\": \"floor\", \"links\": [\"ground\", \"ball\"]}]}");
    double start = 0;
    for (int k = 0; k < 2; k++) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_CAPTURE, 1e-8, k ? 1 : 1e-6, 4), LW_OK);
        start = k ? start : state(d.q, 1);
    }
    CHECK_NEAR(state(d.q, 1), start - 0.5*9.81, 0.03, 0);        /* steps of first order */
    lw_model_free(&d.model);
}

/* A motor swings an arm down on a ball that rests on the ground, and strikes it rigidly or compliantly.  Captured
 * contacts come near the located ones, the nearer the smaller the tolerance. */
TEST(captured_with_states_and_compliance)
{
    static const char format[] = "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], [1, 0]]}]}, "
        "{'name': 'arm', 'mass': 1, 'centre': [0.5, 1], 'inertia': 0.1, 'shapes': [{'circle': [1, 1], 'radius': 0.1}]}, {'name': 'ball', 'mass': 2, "
        "'centre': [0.8, 0.2], 'inertia': 0.03, 'shapes': [{'circle': [0.8, 0.2], 'radius': 0.2}]}], 'joints': [{'name': 'A', 'links': ['ground', 'arm'], "
        "'at': [0, 1]}, {'name': 'F', 'kind': 'n', 'links': ['ground', 'ball']}], 'contacts': [{'name': 'floor', 'links': ['ground', 'ball'], "
        "'friction': 0.4}, {'name': 'hit', 'links': ['arm', 'ball']%s}], 'motors': [{'name': 'M', 'joint': 'A', 'voltage': -10, 'resistance': 2, "
        "'inductance': 1e-3, 'torque_constant': 0.5, 'inertia': 0.001}]}";
    for (int compliant = 0; compliant < 2; compliant++) {
        char text[3000];
        double want[6], off[2];
        snprintf(text, sizeof text, format, compliant ? ", 'stiffness': 2000, 'damping': 0.3" : "");
        for (char *c = text; *c; c++)
            *c = *c == '\'' ? '"' : *c;
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 0.7, 10), LW_OK);
        CHECK(d.report.n_event > 0 || compliant);
        for (int i = 0; i < 6; i++)
            want[i] = state(d.q, i);
        CHECK(want[3] > 0.05);                                   /* the ball has been struck and rolls */
        for (int k = 0; k < 2; k++) {
            CHECK_INT(drun_to(&d, LW_FORMULATION_CAPTURE, k ? 1e-15 : 1e-8, 0.7, 10), LW_OK);
            off[k] = 0;
            for (int i = 0; i < 6; i++)
                off[k] = fmax(off[k], fabs(state(d.q, i) - want[i]));
        }
        CHECK(off[1] < 2e-3 && off[1] < 0.3*off[0]);
        lw_model_free(&d.model);
    }
}

/* A pin with friction beside a rope or a contact that stays open: the motion is that without them.  A rope that ends the swing is
 * tight at its length. */
TEST(friction_in_a_joint)
{
    static const char format[] = "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [{'line': [[0, -3], [1, -3]]}]}, {'name': 'bob', 'mass': 1,"
        "'centre': [1, 0], 'inertia': 0.1, 'shapes': [{'circle': [1, 0], 'radius': 0.1}]}], 'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at':"
        "[0, 0], 'friction': {'coefficient': 0.2, 'radius': 0.05, 'speed': 0.1}}], 'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'bob', 'at':"
        "[1, 0]}]%s}";
    static const char *const beside[] = { "", ", 'contacts': [{'links': ['ground', 'bob'], 'friction': 0.3}]",
        ", 'ropes': [{'links': ['ground', 'bob'], 'at': [[0, 1], [1, 0]], 'length': 2.5}]",
        ", 'ropes': [{'links': ['ground', 'bob'], 'at': [[0, 1], [1, 0]], 'length': 1.9}]" };
    double free = 0;
    for (int k = 0; k < 4; k++) {
        char text[2000];
        snprintf(text, sizeof text, format, beside[k]);
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1.2, 20), LW_OK);
        if (k < 3)
            CHECK_NEAR(d.q[2], k ? free : d.q[2], 1e-8, 0);
        free = k ? free : d.q[2];
        for (int i = 0; k == 3 && i <= 20; i++)
            CHECK(hypot(d.tracer[i].x, d.tracer[i].y - 1) < 1.9 + 1e-9);
        lw_model_free(&d.model);
    }
    CHECK(free < -1.5);
}

/* A disc that rests is pushed for 1 ms in the middle of the run. */
TEST(short_pulse)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_CAPTURE };
    drun_read_format(&d, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], [1, 0]]}]}, {'name': 'puck', 'mass': 2,"
                     "'centre': [0, 0.2], 'inertia': 1, 'shapes': [{'circle': [0, 0.2], 'radius': 0.2}]}], 'joints': [{'name': 'F', 'kind': 'n',"
                     "'links': ['ground', 'puck']}], 'contacts': [{'links': ['ground', 'puck']}], 'gravity': [0, -9.81], 'forces': [{'link':"
                     "'puck', 'at': [0, 0.2], 'fx': 'step(t, 0.5, 0, 0.5005, 1000) - step(t, 0.5005, 0, 0.501, 1000)'}]}", 0, 0);
    for (int f = 0; f < 2; f++)
        for (int n = 1; n <= 2; n++) {
            CHECK_INT(drun_to(&d, each[f], 1e-8, 1, n), LW_OK);
            CHECK_NEAR(d.v[0]*d.system.unit, 0.25, 1e-6, 0);
            CHECK_NEAR(d.t[n], 1, 0, 0);
        }
    lw_model_free(&d.model);
}

int main(void)
{
    check_run();
    lw_system_free(&d.system);
    return check_end();
}
