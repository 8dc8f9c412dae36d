/* Contact between shapes, ropes and free links: formulas of textbooks, and the laws of contact themselves at random. */
#include "mbs/equations/complementarity.h"
#include "tests/touch_run.h"

/* ---- the laws, at random ------------------------------------------------------------------------------- */

static void check_laws(lw_rng rng)
{
    for (int trial = 0; trial < 2000; trial++) {
        int n = 1 + (int)(5*lw_rng_uniform(&rng)), dof = 1 + (int)(6*lw_rng_uniform(&rng));
        double row[10][7], w[100], b[10], v[7], force[10], rate[10];
        lw_touch_law law[5];
        for (int k = 0; k < dof; k++)
            v[k] = 2*lw_rng_uniform(&rng) - 1;
        double near = trial%2 ? 0 : pow(10, lw_rng_range(&rng, -10, -7));
        for (int i = 0; i < 2*n; i++) {                  /* rows repeat now and then, all but: contacts that share a load */
            bool twin = i >= 2 && lw_rng_uniform(&rng) < 0.3;
            for (int k = 0; k < dof; k++)
                row[i][k] = twin ? row[i - 2][k]*(1 + near*lw_rng_uniform(&rng)) : 2*lw_rng_uniform(&rng) - 1;
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

TEST(complementarity)
{
    lw_rng four_alike;                                   /* trial 422: four of five places differ by 1e-8 */
    lw_rng_seed(&four_alike, 1001, 0);
    check_laws(four_alike);
    check_laws(check_rng(0));
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
}

/* A pendulum whose disc grazes a floor, a small disc or the end of a rope while it swings through: its loose run, which
 * takes a few steps a swing, strikes whenever the fine one does. */
TEST(grazing_passes)
{
    static const char *const contact = "'contacts': [{'name': 'c', 'links': ['ground', 'b'], 'restitution': %.17g}]";
    lw_rng rng = check_rng(12);
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
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [%s]}, {'name': 'b', 'mass': 1, 'centre': [%.17g, %.17g], "
                 "'inertia': 0.01, 'shapes': [{'circle': [%.17g, %.17g], 'radius': 0.05}]}], 'joints': [{'name': 'A', 'links': ['ground', 'b'], 'at': [0, "
                 "0]}], %s, 'input': {'joint': 'A', 'speed': %.17g}, 'gravity': [0, -9.81]}", shape, x, y, x, y, own,
                 lw_rng_range(&rng, -1, 1));
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 2, 2), LW_OK);
        double angle = d.q[2];
        int struck = d.report.n_event_seen;
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-6, 2, 2), LW_OK);
        CHECK_INT(d.report.n_event_seen, struck);
        CHECK_NEAR(d.q[2], angle, 1e-3, 0);
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
    free_model(incline, mu, 0);                          /* slides */
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, t, 10), LW_OK);
    CHECK_NEAR(state(d.q, 0), 0.95 - 0.5*a*t*t*cos(slope), 1e-12, 0);
    CHECK_NEAR(state(d.q, 1), 0.6 - 0.5*a*t*t*sin(slope), 1e-12, 0);
    CHECK_NEAR(d.q[2], 0, 1e-13, 0);
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
    CHECK_POINT(d.tracer[1], x + 0.5*vx, y + 0.5*vy - 0.125*g, 1e-9, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, 2, 10), LW_OK);
    CHECK_NEAR(d.report.event[0].t, lo, 1e-9, 0);
    CHECK_NEAR(d.report.event[1].t, lo + flight, 1e-9, 0);
    CHECK(!d.report.event[0].impact && d.report.event[1].impact);
    CHECK_NEAR(lw_v2_norm(d.tracer[10]), 1, 1e-12, 0);   /* taut again, without restitution */
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
}

/* ---- several bodies --------------------------------------------------------------------------------------- */

/* Free balls of radius 0.1 in a plane without gravity, and which of them can touch. */
typedef struct ball { double mass, x, y, vx, vy; } ball;

static void read_balls(const ball *b, int n, double restitution)
{
    char format[6000];
    size_t used = (size_t)snprintf(format, sizeof format, "{'linkwright': 1, 'links': ['ground'");
    for (int i = 0; i < n; i++)
        used += (size_t)snprintf(format + used, sizeof format - used, ", {'name': 'b%d', 'mass': %.17g, 'centre': [%.17g, %.17g], 'inertia': 0.01,"
                                 " 'velocity': [%.17g, %.17g], 'shapes': [{'circle': [%.17g, %.17g], 'radius': 0.1}]}", i, b[i].mass,
                                 b[i].x, b[i].y, b[i].vx, b[i].vy, b[i].x, b[i].y);
    for (int i = 0; i < n; i++)
        used += (size_t)snprintf(format + used, sizeof format - used, "%s{'name': 'f%d', 'kind': 'n', 'links': ['ground', 'b%d']}",
                                 i == 0 ? "], 'joints': [" : ", ", i, i);
    for (int i = 0; i < n; i++)
        for (int k = i + 1; k < n; k++)
            used += (size_t)snprintf(format + used, sizeof format - used, "%s{'links': ['b%d', 'b%d'], 'restitution': %.17g}",
                                     i + k == 1 ? "], 'contacts': [" : ", ", i, k, restitution);
    snprintf(format + used, sizeof format - used, "]}");
    free_model(format, 0, 0);
}

/* Of the model that was run: momentum along x, and kinetic energy. */
static void totals(const ball *b, int n, double *momentum, double *energy)
{
    *momentum = *energy = 0;
    for (int i = 0; i < n; i++) {
        double x = state(d.v, 3*i), y = state(d.v, 3*i + 1);
        *momentum += b[i].mass*x;
        *energy += 0.5*b[i].mass*(x*x + y*y);
    }
}

/* A ball strikes a row of balls that touch: the impact travels from pair to pair, until none approach.  Where both ends are struck at
 * once momentum stays, energy does not grow and stays with restitution 1, and equal speeds end equal. */
TEST(rows_of_balls)
{
    for (int k = 0; k < 60; k++) {
        lw_rng rng;
        ball b[6] = { { 0 } };
        double e = k%3 == 0 ? 1 : k%3 == 1 ? 0 : lw_rng_range(&rng, 0, 1), want[6], momentum, energy, had, before;
        lw_rng_seed(&rng, check_seed(), 200 + (uint64_t)k);
        int n = 3 + k%4;
        bool both = k%5 == 0, mirrored = k%10 == 0;
        for (int i = 0; i < n; i++)
            b[i] = (ball){ .mass = k%2 || mirrored ? 1 : lw_rng_range(&rng, 0.2, 3), .x = 0.2*i };
        b[0].vx = lw_rng_range(&rng, 0.5, 2);
        b[n - 1].vx = both ? mirrored ? -b[0].vx : -lw_rng_range(&rng, 0.5, 2) : 0;
        had = b[0].mass*b[0].vx + b[n - 1].mass*b[n - 1].vx;
        before = 0.5*(b[0].mass*b[0].vx*b[0].vx + b[n - 1].mass*b[n - 1].vx*b[n - 1].vx);
        for (int i = 0; i < n; i++)
            want[i] = b[i].vx, b[i].x -= 0.2*b[i].vx;                       /* they strike after 0.2 s */
        for (bool approach = true; approach;) {
            approach = false;
            for (int i = 0; i + 1 < n; i++) {
                double by = (1 + e)*(want[i] - want[i + 1])/(1/b[i].mass + 1/b[i + 1].mass);
                if (want[i] - want[i + 1] <= 1e-13)
                    continue;
                want[i] -= by/b[i].mass;
                want[i + 1] += by/b[i + 1].mass;
                approach = true;
            }
        }
        read_balls(b, n, e);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 0.2001, 2), LW_OK);
        totals(b, n, &momentum, &energy);
        CHECK_NEAR(momentum, had, 1e-12, 0);
        CHECK(energy <= before + 1e-12 && (e < 1 || energy > before - 1e-12));
        for (int i = 0; i < n; i++) {
            if (!both)
                CHECK_NEAR(state(d.v, 3*i), want[i], 1e-10, 0);
            CHECK(!mirrored || fabs(state(d.v, 3*i) + state(d.v, 3*(n - 1 - i))) < 1e-12);
            CHECK(i == 0 || state(d.v, 3*i) > state(d.v, 3*i - 3) - 1e-11);
        }
    }
}

/* A ball strikes two that touch, between them: it comes back with a fifth of its speed. */
TEST(ball_against_two)
{
    double across = 0.1*sqrt(3), momentum, energy;
    ball b[3] = { { 1, -across - 0.2, 0, 1, 0 }, { 1, 0, 0.1, 0, 0 }, { 1, 0, -0.1, 0, 0 } };
    read_balls(b, 3, 1);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 0.3, 2), LW_OK);
    totals(b, 3, &momentum, &energy);
    CHECK_NEAR(momentum, 1, 1e-12, 0);
    CHECK_NEAR(energy, 0.5, 1e-12, 0);
    CHECK_NEAR(state(d.v, 0), -0.2, 1e-10, 0);
    CHECK_NEAR(state(d.v, 4), 0.2*sqrt(3), 1e-10, 0);
    CHECK_NEAR(state(d.v, 7), -0.2*sqrt(3), 1e-10, 0);
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
}

/* A run that is interrupted, at whatever evaluation, in a step, at an event or behind one, says that it was stopped. */
typedef struct interrupt { volatile sig_atomic_t stop; int calls, last; } interrupt;

static void count_calls(void *context, double t, const lw_link_motion *link, lw_link_load *load)
{
    interrupt *i = context;
    (void)t, (void)link, (void)load;
    i->stop = ++i->calls >= i->last;
}

TEST(interrupted_runs_say_so)
{
    lw_status s = LW_STOPPED;
    interrupt i = { 0 };
    free_model(FREE(FLOOR, "'mass': 1, 'centre': [0, 0.3], 'inertia': 0.01", "{'circle': [0, 0.3], 'radius': 0.1}", "'restitution': 0.5"), 0, 0);
    for (int last = 40; s == LW_STOPPED && last < 2000; last += 7) {
        i = (interrupt){ .last = last };
        d.o.stop = &i.stop;
        d.o.force = (lw_caller_force){ &i, count_calls };
        s = drun_to(&d, LW_FORMULATION_INDEX1, 1e-8, 0.5, 5);
        CHECK(s == LW_OK || (s == LW_STOPPED && strncmp(d.e.text, "stopped at t = ", 15) == 0));
    }
    CHECK_INT(s, LW_OK);
    CHECK(i.calls > 100 && d.report.n_event_seen > 1);
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
    OWNED(lw_dynamics) *m = NULL;
    loads l = { 0 };
    free_model(FREE("{'polygon': [[-2, 2], [-2, -1], [2, -1], [2, 2], [0, 0]]}", "'mass': 2, 'centre': [0, 1], 'inertia': 0.5",
                    "{'circle': [0, 1], 'radius': 0.7071067811865476}", "'friction': 0.1"), 0, 0);
    d.o.to = 3;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
    l.m = m;
    CHECK_INT(lw_dynamics_run(m, keep_loads, &l, &d.report, &d.e), LW_OK);
    CHECK_NEAR(l.fy, 2*g, 1e-9, 0);
    CHECK_NEAR(l.most_x, 0, 1e-9, 0);
}

/* Two jaws hold a part by friction.  Rigid bodies do not determine how its weight is shared, but each contact keeps to its limit, and the jaws carry as much. */
static lw_status check_jaws(void *context, const lw_moment *m)
{
    const loads *l = context;
    lw_vec2 f[2];
    lw_reaction r[4];
    lw_reactions_contacts(l->m, m, f, NULL);
    lw_reactions_joints(l->m, m, r);
    CHECK_NEAR(f[0].y + f[1].y, g, 1e-9, 0);
    for (int i = 0; i < 2; i++) {
        CHECK(fabs(f[i].y) <= 0.5*fabs(f[i].x) + 1e-7);
        CHECK_NEAR(r[i].force.y, f[i].y + 0.2*g, 1e-9, 0);
    }
    return LW_OK;
}

TEST(gripper_shares_within_friction)
{
    for (int k = 0; k < 4; k++) {
        OWNED(lw_dynamics) *m = NULL;
        loads l = { 0 };
        drun_read_format(&d, "{'linkwright': 1, 'links': [{'name': 'ground'}, {'name': 'a', 'mass': 0.2, 'centre': [-0.06, 0], 'inertia': 1e-4, 'shapes': ["
            "{'polygon': [[-0.08, -0.03], [-0.05, -0.03], [-0.05, 0.03], [-0.08, 0.03]]}]}, {'name': 'b', 'mass': 0.2, 'centre': [0.06, 0], 'inertia': 1e-4,"
            "'shapes': [{'polygon': [[0.05, -0.03], [0.08, -0.03], [0.08, 0.03], [0.05, 0.03]]}]}, {'name': 'part', 'mass': 1, 'centre': [%g, 0], 'inertia': 1e-3,"
            "'shapes': [{'polygon': [[-0.05, -0.02], [0.05, -0.02], [0.05, 0.02], [-0.05, 0.02]]}]}], 'joints': [{'name': 'A', 'kind': 't', 'links': ["
            "'ground', 'a'], 'at': [-0.06, 0], 'along': [1, 0]}, {'name': 'B', 'kind': 't', 'links': ['ground', 'b'], 'at': [0.06, 0], 'along': [1, 0]},"
            "{'name': 'P', 'kind': 'n', 'links': ['ground', 'part']}], 'forces': [{'link': 'a', 'at': [-0.06, 0], 'fx': %g}, {'link': 'b', 'at': [0.06, 0], 'fx':"
            "'-10-4*t'}], 'springs': [{'joint': 'A', 'law': '4*t'}], 'contacts': [{'links': ['a', 'part'], 'friction': 0.5}, {'links': ['b', 'part'], 'friction':"
            "0.5}], 'gravity': [0, -9.81]}", k*0.001, 10);
        d.o.to = 1;
        d.o.formulation = LW_FORMULATION_INDEX1;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
        l.m = m;
        CHECK_INT(lw_dynamics_run(m, check_jaws, &l, &d.report, &d.e), LW_OK);
    }
}

/* A hand whose jaws are pressed together by springs closes on a box, each jaw with two corners, and lifts it off the floor: both carry as much at every moment,
 * also in a turned drawing. */
static lw_status check_hand(void *context, const lw_moment *m)
{
    const loads *l = context;
    lw_vec2 f[3];
    lw_reactions_contacts(l->m, m, f, NULL);
    if (m->t > 0.1) {
        CHECK_NEAR(l->most_x*f[0].x + l->least_x*f[0].y, 18, 1e-6, 0);
        CHECK_NEAR(l->most_x*(f[0].y - f[1].y) - l->least_x*(f[0].x - f[1].x), 0, 1e-6, 0);
    }
    return LW_OK;
}

TEST(hand_lifts_a_box_with_equal_forces)
{
    static const double corner[][2] = { { 1, 0 }, { 0, 0.2 }, { -0.065, 0.05 }, { -0.06, 0.02 }, { -0.06, 0.08 }, { -0.07, 0.08 }, { -0.07, 0.02 }, { 0.065, 0.05 },
        { 0.06, 0.02 }, { 0.06, 0.08 }, { 0.07, 0.08 }, { 0.07, 0.02 }, { 0, 0.05 }, { -0.05, 0 }, { 0.05, 0 }, { 0.05, 0.1 }, { -0.05, 0.1 }, { 0, 0.2 }, { 0, 1 },
        { -0.065, 0.05 }, { 1, 0 }, { 0.065, 0.05 }, { -1, 0 }, { -0.2, 0.05 }, { -0.07, 0.05 }, { 0.2, 0.05 }, { 0.07, 0.05 }, { 0, -9.81 } };
    static const char scene[] = "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], @]}]}, {'name': 'hand', 'mass': 1, 'centre': @, 'inertia': 0.01}, "
        "{'name': 'L', 'mass': 0.2, 'centre': @, 'inertia': 1e-4, 'shapes': [{'polygon': [@, @, @, @]}]}, {'name': 'R', 'mass': 0.2, 'centre': @, 'inertia': 1e-4, "
        "'shapes': [{'polygon': [@, @, @, @]}]}, {'name': 'box', 'mass': 1, 'centre': @, 'inertia': 2e-3, 'shapes': [{'polygon': [@, @, @, @]}]}], 'joints': ["
        "{'name': 'Z', 'kind': 't', 'links': ['ground', 'hand'], 'at': @, 'along': @}, {'name': 'A', 'kind': 't', 'links': ['hand', 'L'], 'at': @, 'along': @}, "
        "{'name': 'B', 'kind': 't', 'links': ['hand', 'R'], 'at': @, 'along': @}, {'name': 'F', 'kind': 'n', 'links': ['ground', 'box']}], "
        "'input': {'joint': 'Z', 'motion': '0.2*havsin(t, 0.3, 0, 0.8, 1)'}, 'contacts': [{'links': ['L', 'box'], 'friction': 0.5}, {'links': ['R', 'box'], "
        "'friction': 0.5}, {'links': ['ground', 'box'], 'friction': 0.3}], 'springs': [{'links': ['hand', 'L'], 'at': [@, @], 'stiffness': 300, 'free': 0.2, "
        "'damping': 10}, {'links': ['hand', 'R'], 'at': [@, @], 'stiffness': 300, 'free': 0.2, 'damping': 10}], 'gravity': @}";
    for (int k = 0; k < 2; k++) {
        double turn = 0.7*k;
        char text[3000];
        int n = 0, next = 0;
        for (const char *c = scene; *c; c++)
            n += *c != '@' ? snprintf(text + n, sizeof text - (size_t)n, "%c", *c)
                : snprintf(text + n, sizeof text - (size_t)n, "[%.17g, %.17g]", corner[next][0]*cos(turn) - corner[next][1]*sin(turn),
                           corner[next][0]*sin(turn) + corner[next][1]*cos(turn)), next += *c == '@';
        lw_dynamics *m;
        loads l = { .most_x = cos(turn), .least_x = sin(turn) };
        drun_read_text(&d, text);
        d.o.intervals = 10;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
        l.m = m;
        CHECK_INT(lw_dynamics_run(m, check_hand, &l, &d.report, &d.e), LW_OK);
        lw_dynamics_free(m);
    }
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
    OWNED(lw_dynamics) *m = NULL;
    double weight = 0;
    d.o.analysis = LW_ANALYSIS_STATIC;
    for (int b = 0; b < d.model.linkage.n_link; b++)
        weight += g*d.model.body[b].mass;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
    l.m = m;
    CHECK_INT(lw_dynamics_analyse(m, add_loads, &l, &d.report, &rest, &d.e), expected);
    CHECK_NEAR(l.fy, expected == LW_OK ? weight : 0, 0, 1e-6);
    CHECK_NEAR(l.most_x, 0, 1e-6*weight, 0);
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

/* A triangle that spins falls on the floor, in metres and in micrometres, with times to suit: one free link has no other size than its outline. */
TEST(one_free_link_of_any_size)
{
    double place[2][3];
    for (int k = 0; k < 2; k++) {
        double s = k ? 1e-6 : 1, slow = sqrt(s);
        char text[2000];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], [1, 0]]}]}, {'name': 'b', 'mass': 1.5, 'centre': [0, %.17g],"
                 "'inertia': %.17g, 'velocity': [%.17g, 0], 'omega': %.17g, 'shapes': [{'polygon': [[%.17g, %.17g], [%.17g, %.17g], [0, %.17g]]}]}],"
                 "'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', 'b']}], 'contacts': [{'links': ['ground', 'b'], 'friction': 0.2, 'restitution': 0.3}],"
                 "'gravity': [0, -9.81]}", 0.1*s, 0.003*s*s, 0.5*slow, -3/slow, -0.1*s, 0.06*s, 0.12*s, 0.06*s, 0.2*s);
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-9, 0.6*slow, 5), LW_OK);
        for (int i = 0; i < 3; i++)
            place[k][i] = i < 2 ? state(d.q, i)/s : d.q[2];
    }
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(place[1][i], place[0][i], 1e-7, 0);
}

TEST(hook_holds)
{
    drun_read(&d, "examples/dynamics/hook.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 3, 300), LW_OK);
    for (int k = 0; k <= 300; k++)                       /* the bar hangs on its pin, 0.184 long, within the hook */
        CHECK(d.tracer[k].y < -0.09 && d.tracer[k].y > -0.2 && fabs(d.tracer[k].x) < 0.2);
    CHECK(d.report.energy_error < 1e-8*d.report.energy_scale);
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
}

/* ---- prescribed motion, and rest -------------------------------------------------------------------------- */

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
        CHECK_INT(carry(k ? LW_ANALYSIS_QUASISTATIC : LW_ANALYSIS_KINEMATIC, to, 3, &z, keep_carried), LW_OK);
        double normal = k ? push : push*(1 + 0.5*2*c), slip = -2*s - 2*0.1, across = k ? 0 : -0.3*normal*tanh(slip/0.01);
        CHECK_NEAR(z.contact.y, normal, 0, 1e-11);
        CHECK_NEAR(z.contact.x, across, 1e-11, 1e-11);
        /* about the pin: weight, and contact at the deepest point of the disc; no angular acceleration */
        CHECK_NEAR(z.drive, 2*g*0.5*c - c*normal - (s + 0.1)*across, 0, 1e-10);
        CHECK(d.report.no_friction == (k == 1));
    }
    for (int n = 3; n < 200; n *= 8) {
        free_model(TURNING(""), -1.0999999, -1.0999999);
        CHECK_INT(carry(LW_ANALYSIS_KINEMATIC, 1.6, n, &z, keep_carried), LW_E_NUMERIC);
        CHECK_HAS(d.e.text, "touch at t = 0.785");
        free_model(TURNING(""), -1.1000001, -1.1000001);
        CHECK_INT(carry(LW_ANALYSIS_KINEMATIC, 1.6, n, &z, keep_carried), LW_OK);
    }
    free_model(TURNING(", 'stiffness': 1e4, 'friction': 0.3"), -1.05, -1.05);
    CHECK_INT(carry(LW_ANALYSIS_KINEMATIC, 1.6, 3, &z, keep_carried), LW_E_KIND);
    CHECK_HAS(d.e.text, "friction_speed");
}

/* A bar that lies on a compliant support: pin and support carry its weight, and its moment. */
TEST(compliant_rest)
{
    carried z;
    free_model("{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'circle': [2, -0.5], 'radius': 0.5}]}, {'name': 'bar',"
               " 'mass': 1, 'centre': [%.9g, 0.1], 'inertia': 0.3, 'shapes': [{'segment': [[0.5, 0.1], [3, 0.1]], 'radius': 0.05}]}], 'joints': [{'name': 'A',"
               " 'links': ['ground', 'bar'], 'at': [0, 0.1]}], 'contacts': [{'links': ['ground', 'bar'], 'stiffness': %.9g, 'damping': 10}]}", 1, 1e7);
    CHECK_INT(carry(LW_ANALYSIS_STATIC, 1, 1, &z, keep_carried), LW_OK);
    CHECK_NEAR(z.contact.y + z.pin.force.y, g, 0, 1e-7);
    CHECK_NEAR(z.contact.x + z.pin.force.x, 0, 1e-6, 0);
    CHECK_NEAR(z.contact.y, g/2, 0, 0.01);               /* the bar sinks by the gap of 0.05: its slope is 0.025 */
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
        json_quotes(text);
        drun_read_text(&d, text);
        complete += drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 20) == LW_OK;
        CHECK(d.status == LW_OK || d.e.text[0]);
        CHECK(d.report.energy_error < 1e-7*d.report.energy_scale);
        for (int k = 1; k < d.n_moment; k++)
            CHECK(d.energy[k] <= d.energy[k - 1] + 1e-7*d.report.energy_scale);
        for (int b = 0; b < n; b++)
            CHECK(fabs(state(d.q, 3*b)) < 1.5 && state(d.q, 3*b + 1) > 0.029);
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
    CHECK_HAS(d.e.text, "overlap");
    d.o.analysis = LW_ANALYSIS_QUASISTATIC;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_E_KIND);
    d.o.analysis = LW_ANALYSIS_TRANSIENT;
    for (lw_formulation f = LW_FORMULATION_QUADRATURE; f <= LW_FORMULATION_GGL; f++) {
        d.o.formulation = f;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), f == LW_FORMULATION_INDEX1 || f == LW_FORMULATION_CAPTURE ? LW_OK : LW_E_KIND);
        lw_dynamics_free(m);
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
}

/* A puck on the floor, and a cart at its rigid stop, are pushed off by a load that jumps at 0.5 s: by 2 kg, at 1 and 2 m/s^2 from there.
 * Then the load jumps back, and they come to rest again. */
TEST(loads_that_jump_lift_what_rests)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE };
    for (int f = 0; f < 5; f++) {
        double a = f < 3 ? 1 : 2;
        drun_read_format(&d, f < 3 ? "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 2, 'centre': [0, 0], 'inertia': 1}], 'joints': ["
                         "{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': [0, 0], 'along': [0, 1], 'stop': {'least': 0}}],"
                         "'forces': [{'link': 'cart', 'at': [0, 0], 'fy': '-1 + 3*max(0, sign(t - 0.5)*sign(1 - t))'}], 'tracers': [{'name':"
                         "'P', 'link': 'cart', 'at': [0, 0]}]}"
                         : "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [" FLOOR "]}, {'name': 'puck', 'mass': 2, 'centre': [0, 0.2],"
                         "'inertia': 1, 'shapes': [{'circle': [0, 0.2], 'radius': 0.2}]}], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', "
                         "'puck']}], 'contacts': [{'links': ['ground', 'puck'], 'restitution': 0}], 'gravity': [0, -1], 'forces': [{'link': 'puck', 'at': "
                         "[0, 0.2], 'fy': '6*max(0, sign(t - 0.5)*sign(1 - t))'}], 'tracers': [{'name': 'P', 'link':'puck', 'at': [0, 0]}]}", 0, 0);
        CHECK_INT(drun_to(&d, each[f%3], 1e-9, 4, 16), LW_OK);
        double fall = f < 3 ? 0.5 : 1, up = a/2, high = a/8, end = 1 + (up + sqrt(up*up + 2*fall*high))/fall;
        for (int k = 0; k < d.n_moment; k++) {
            double t = d.t[k], s = t - 1;
            double y = t < 0.5 || t > end ? 0 : t < 1 ? a*(t - 0.5)*(t - 0.5)/2 : high + up*s - fall*s*s/2;
            CHECK_NEAR(d.tracer[k].y, y, 1e-6, 0);
        }
    }
}

/* The simplest walker (Garcia, Chatterjee, Ruina & Coleman 1998): a mass at the hip, feet of 1e-7 or 1e-8 of it, length and gravity 1, slope 0.009.  It walks from its
 * fixed point, theta = 0.200311 and -0.199832, with equal steps; each foot has stones of its own, so that legs pass each other.  Rates of the light feet are rounded
 * by impulses of the heavy hip. */
TEST(simplest_walker)
{
    static const char format[] = "{'linkwright': 1, 'gravity': [%.17g, %.17g], 'links': ['ground', {'name': 'stones', 'mass': 1, 'centre': [0, 0], 'inertia': 1,"
        "'shapes': [{'polygon': [[-0.1, 0], [0.1, 0], [0, -0.1]]}, {'polygon': [[0.7, 0], [0.9, 0], [0.8, -0.1]]}]}, {'name': 'others', 'mass': 1, 'centre': [0, 0],"
        "'inertia': 1, 'shapes': [{'polygon': [[-0.5, 0], [-0.3, 0], [-0.4, -0.1]]}, {'polygon': [[0.3, 0], [0.5, 0], [0.4, -0.1]]}, {'polygon': [[1.1, 0], [1.3, 0],"
        "[1.2, -0.1]]}]}, {'name': 'hip', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 1e-3, 'velocity': [%.17g, %.17g], 'omega': 0}, {'name': 'leg', 'mass': %.17g,"
        "'centre': [0, 0], 'inertia': 0, 'velocity': [0, 0], 'omega': %.17g, 'shapes': [{'segment': [[%.17g, %.17g], [0, 0]]}]}, {'name': 'swing', 'mass': %.17g,"
        "'centre': [%.17g, 0], 'inertia': 0, 'velocity': [%.17g, %.17g], 'omega': %.17g, 'shapes': [{'segment': [[%.17g, %.17g], [%.17g, 0]]}]}], 'joints': ["
        "{'name': 'S', 'kind': 'f', 'links': ['ground', 'stones'], 'at': [0, 0]}, {'name': 'O', 'kind': 'f', 'links': ['ground', 'others'], 'at': [0, 0]},"
        "{'name': 'F', 'kind': 'n', 'links': ['ground', 'hip']}, {'name': 'L', 'links': ['hip', 'leg'], 'at': [%.17g, %.17g]}, {'name': 'R', 'links': ['hip', 'swing'],"
        "'at': [%.17g, %.17g]}], 'contacts': [{'links': ['stones', 'leg'], 'friction': 2}, {'links': ['others', 'swing'], 'friction': 2}]}";
    double a = 0.200310900544287, w = -0.199832473004977, x = -sin(a), y = cos(a), turn = w*cos(2*a);   /* the swing leg turns at w cos 2a behind the impact */
    char text[4000];
    for (int k = 0; k < 3; k++) {
        double foot = k < 2 ? 1e-7 : 1e-8, strike[4] = { 0 };
        int n = 0;
        snprintf(text, sizeof text, format, sin(0.009), -cos(0.009), x, y, -w*y, w*x, foot, w, x, y, foot, 2*x, (turn - w)*y, (turn + w)*x, turn, x, y, 2*x, x, y,
                 x, y);
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, k == 1 ? 1e-10 : 1e-8, 12, 4), LW_OK);
        for (int i = 0; i < d.report.n_event && n < 4; i++)
            if (d.report.event[i].impact && d.report.event[i].t > (n ? strike[n - 1] : 0))       /* both feet take part in one */
                strike[n++] = d.report.event[i].t;
        CHECK_INT(n, 3);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(strike[i], 3.88246*(i + 1), 1e-4, 0);
        lw_model_free(&d.model);
    }
}

/* A beam on three feet is pushed along the floor.  If they rub alike, or not at all, it moves in one way however they share the load; if one rubs
 * that depends on its share, which is said from where it slips. */
TEST(feet_that_rub_differently)
{
    static const char format[] = "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [" FLOOR "]}, {'name': 'beam', 'mass': 1,"
        "'centre': [0, 0.2], 'inertia': 0.05, 'shapes': [{'circle': [-0.5, 0.1], 'radius': 0.1}, {'circle': [0.1, 0.1], 'radius': 0.1}]}, {'name': 'foot', 'mass':"
        "0.01, 'centre': [0.5, 0.1], 'inertia': 1e-5, 'shapes': [{'circle': [0.5, 0.1], 'radius': 0.1}]}], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground',"
        "'beam']}, {'name': 'W', 'kind': 'f', 'links': ['beam', 'foot'], 'at': [0.5, 0.15]}], 'contacts': [{'name': 'two', 'links': ['ground', 'beam'], 'friction':"
        "%.17g}, {'name': 'one', 'links': ['ground', 'foot'], 'friction': %.17g}], 'forces': [{'link': 'beam', 'at': [0, 0.2], 'fx': '2.5*t'}]}";
    static const struct { double two, one, from; } each[] = { { 0.3, 0.3, INFINITY }, { 0, 0, INFINITY }, { 0, 0.3, 0 }, { 0.3, 0, 0.1 } };
    for (int k = 0; k < 4; k++) {
        drun_read_format(&d, format, each[k].two, each[k].one);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-8, 2, 2), LW_OK);
        CHECK((d.report.undetermined != NULL) == isfinite(each[k].from));
        CHECK(!d.report.undetermined || d.report.undetermined_t >= each[k].from);
    }
}
