/* Losses of linkages of one freedom: Coulomb friction with rest, against equations written by hand and against the
 * regularised friction of the bodies' coordinates; springs, dampers, motors and forces at any joint of random
 * linkages. */
#include "tests/dynamics_run.h"
#include "tests/model_text.h"

static drun d, other;

/* ---- a block -------------------------------------------------------------------------------------------- */

static const double g = 9.81, mass = 2;

static void read_block(double slope, double mu, double speed, const char *force)
{
    used = 0;
    put("{'linkwright': 1, 'links': ['ground', {'name': 'block', 'mass': 2, 'centre': [0.1, 0.2], 'inertia': 0.1}],"
        "'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'block'], 'at': [0, 0], 'along': [%.17g, %.17g],"
        "'friction': {'coefficient': %.17g}}], 'input': {'joint': 'S', 'speed': %.17g}, 'gravity': [0, -9.81],"
        "'tracers': [{'name': 'P', 'link': 'block', 'at': [0, 0]}]", cos(slope), sin(slope), mu, speed);
    if (force)
        put(", 'forces': [{'link': 'block', 'at': [0, 0], 'fx': '%s'}]", force);
    put("}");
    drun_read_text(&d, text);
}

/* A block rests for ever on a slope that is not too steep; with speed it slides up, stops, and rests or comes back. */
TEST(block_on_a_slope)
{
    read_block(0.4, 0.43, 0, NULL);                         /* tan 0.4 = 0.4228 */
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 1e6, 10), LW_OK);
    CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
    CHECK(fabs(d.tracer[10].x) < 1e-15 && d.v[0] == 0 && fabs(d.a[0]) < 1e-13);
    for (int k = 0; k < 2; k++) {
        double mu = k ? 0.3 : 0.43, v = 3;
        double up = g*(sin(0.4) + mu*cos(0.4)), stop = v/up, down = g*(sin(0.4) - mu*cos(0.4));
        read_block(0.4, mu, v, NULL);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 2, 40), LW_OK);
        for (int i = 0; i <= 40; i++) {
            double t = d.t[i], back = fmax(t - stop, 0), s = t < stop ? v*t - up*t*t/2 : v*stop/2;
            s -= down > 0 ? down*back*back/2 : 0;
            CHECK_NEAR(d.tracer[i].x, s*cos(0.4), 1e-11, 0);
        }
        CHECK(d.report.energy_error < 1e-9*d.report.energy_scale);
    }
}

/* A force that grows moves it when it exceeds the friction; one that swings moves it a little at a time. */
TEST(block_under_changing_force)
{
    double hold = 0.5*mass*g, start = hold/6;
    read_block(0, 0.5, 0, "6*t");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 4, 16), LW_OK);
    for (int i = 0; i <= 16; i++)
        CHECK_NEAR(d.tracer[i].x, d.t[i] > start ? pow(d.t[i] - start, 3)*6/(6*mass) : 0, 1e-9, 0);
    read_block(0, 0.5, 0, "15*sin(2*t)");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 10, 1), LW_OK);
    /* by hand: slides from asin(hold/15)/2 in each half period until its speed is 0 again, and rests */
    double from = asin(hold/15)/2, to = 1.5, low = from + 0.01, x;
    for (int i = 0; i < 100; i++) {
        to = i ? to : 3;
        double t = 0.5*(low + to), v = 7.5*(cos(2*from) - cos(2*t)) - hold*(t - from);
        *(v > 0 ? &low : &to) = t;
    }
    x = 7.5*(cos(2*from)*(to - from) - (sin(2*to) - sin(2*from))/2) - hold*(to - from)*(to - from)/2;
    double part = 10 - 6*LW_PI/2 - from;                     /* six whole half periods cancel; then it slides again */
    double t = from + fmin(part, to - from);
    x = 7.5*(cos(2*from)*(t - from) - (sin(2*t) - sin(2*from))/2) - hold*(t - from)*(t - from)/2;
    CHECK_NEAR(d.tracer[1].x, x/mass, 1e-12, 0);
}

/* ---- a pendulum whose pin rubs ------------------------------------------------------------------------------ */

/* N in I a = -m g l sin x - c N sense by N = m |(l a + g sin x, l w^2 + g cos x)|, by iteration. */
static const double arm = 0.5, rub = 0.03;       /* distance of the centre of mass; mu times radius */
static const double spin = 0.6;                  /* inertia about the pin */

static double swing(double x, double w, double sense)
{
    double a = 0;
    for (int i = 0; i < 100; i++) {
        double n = mass*hypot(arm*a + g*sin(x), arm*w*w + g*cos(x));
        a = (-mass*g*arm*sin(x) - rub*n*sense)/spin;
    }
    return a;
}

static lw_status swing_rate(void *context, double t, const double *y, double *dy)
{
    (void)t;
    dy[0] = y[1];
    dy[1] = swing(y[0], y[1], *(double *)context);
    return LW_OK;
}

static lw_status swing_rests(void *context, double t, const double *y, double *out)
{
    (void)t;
    *out = *(double *)context*y[1];
    return LW_OK;
}

/* Swings get smaller until it sticks, not in the middle. */
TEST(pendulum)
{
    double sense = -1, y[2] = { 2, 0 }, work[LW_INTEGRATE_WORK(2, 1)];
    lw_ode ode = { .n = 2, .context = &sense, .rate = swing_rate, .n_event = 1, .event = swing_rests,
                   .direction = { -1 } };
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop;
    o.relative = o.absolute = 1e-13;
    used = 0;
    put("{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': 2, 'centre': [%.17g, %.17g], 'inertia': %.17g}],"
        "'joints': [{'name': 'A', 'links': ['ground', 'rod'], 'at': [0, 0],"
        "'friction': {'coefficient': 0.6, 'radius': 0.05}}], 'input': {'joint': 'A'}, 'gravity': [0, -9.81]}",
        arm*sin(2), -arm*cos(2), spin - mass*arm*arm);
    drun_read_text(&d, text);
    double before = 0;
    bool stuck = false;
    CHECK_OK(lw_integrate_start(&w, &ode, &o, work, 0, y, &check_error));
    for (int k = 1; k <= 40 && !stuck; k++) {
        while (lw_integrate_step(&w, 1e3, &stop, &check_error) == LW_OK && stop == LW_ODE_STEP)
            ;
        y[0] = w.y[0], y[1] = 0;
        double t = 0.5*(before + w.t);
        before = w.t;
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, w.t, 1), LW_OK);
        CHECK_NEAR(d.q[2], y[0] - 2, 1e-9, 0);
        (void)t;
        stuck = swing(y[0], 0, 1) <= 0 && swing(y[0], 0, -1) >= 0;
        sense = -sense;
        w.events = 0;
        CHECK_OK(lw_integrate_restart(&w, y, &check_error));
    }
    CHECK(stuck && fabs(y[0]) > 1e-4);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 1000, 1), LW_OK);
    CHECK_NEAR(d.q[2], y[0] - 2, 1e-9, 0);
    CHECK(d.v[2] == 0 && fabs(d.a[2]) < 1e-11);
}

/* ---- random linkages ------------------------------------------------------------------------------------------ */

static double friction;                          /* coefficient of the joints, 0: none */

static void put_joint(const char *name, char kind, const char *links, double x, double y, double angle)
{
    put("%s{'name': '%s', 'kind': '%c', 'links': [%s], 'at': [%.17g, %.17g]", *name == 'A' ? "" : ", ", name, kind,
        links, x, y);
    if (kind == 't')
        put(", 'along': [%.17g, %.17g]", cos(angle), sin(angle));
    if (friction > 0 && kind == 't')
        put(", 'friction': {'coefficient': %.17g}", friction);
    if (friction > 0 && kind == 'r')
        put(", 'friction': {'coefficient': %.17g, 'radius': %.17g}", friction, between(0.01, 0.05));
    put("}");
}

/* A crank, a dyad of one of five forms, and a further dyad of pins on its second link.  The crank turns fully. */
static void write_linkage(int form)
{
    double a = between(0, 6), cx = 0.3*cos(a), cy = 0.3*sin(a);
    used = 0;
    put("{'linkwright': 1, 'gravity': [0.5, -9.81], 'links': ['ground'");
    put_link("crank", cx/2, cy/2);
    put_link("two", 1, 0.5);
    put_link("three", 1.5, 0.5);
    put_link("four", 2, 1);
    put_link("five", 2.5, 0.5);
    put("], 'joints': [");
    put_joint("A", 'r', "'ground', 'crank'", 0, 0, 0);
    put_joint("B", 'r', "'crank', 'two'", cx, cy, 0);
    switch (form) {
    case 0:                                      /* RRR */
        put_joint("C", 'r', "'two', 'three'", 1.2, 1.1, 0);
        put_joint("D", 'r', "'ground', 'three'", 1.6, 0, 0);
        break;
    case 1:                                      /* RRP */
        put_joint("C", 'r', "'two', 'three'", 1.6, 0.2, 0);
        put_joint("D", 't', "'ground', 'three'", 1.6, 0.2, 0.2);
        break;
    case 2:                                      /* RPR: two slides along three, which turns on the ground */
        put_joint("C", 't', "'three', 'two'", cx, cy, atan2(cy - 0.1, cx - 1));
        put_joint("D", 'r', "'ground', 'three'", 1, 0.1, 0);
        break;
    default:                                     /* the same with the slide's links the other way round */
        put_joint("C", 'r', "'three', 'two'", 1.7, -0.1, 0);
        put_joint("D", 't', "'three', 'ground'", 1.7, -0.1, -0.1);
    }
    put_joint("E", 'r', "'three', 'four'", 1.4, 0.6, 0);
    put_joint("F", 'r', "'four', 'five'", 2.1, 1.2, 0);
    put_joint("G", 'r', "'five', 'ground'", 2.6, -0.1, 0);
    put("], 'input': {'joint': 'A', 'speed': %.17g}", between(3, 6)*(form%2 ? 1 : -1));
}

/* Springs, dampers, motors and forces of every kind, at any joint. */
static void put_loads(bool state)
{
    put(", 'springs': [{'joint': 'G', 'stiffness': %.17g, 'damping': 0.05, 'free': 0.3},"
        "{'joint': 'C', 'stiffness': 3}, {'joint': 'E', 'law': '-2*sin(displacement) - 0.1*rate + 0.2*t'},"
        "{'links': ['ground', 'four'], 'at': [[3, 2], [2, 1]], 'stiffness': 20, 'damping': 0.4},"
        "{'links': ['two', 'five'], 'at': [[1, 0.4], [2.5, 0.5]], 'law': '5*(length - 1.5) + 0.1*rate'}],"
        "'dampers': [{'joint': 'D', 'damping': 0.1}, {'joint': 'B', 'damping': 0.02}],"
        "'motors': [{'joint': 'A', 'stall': 3, 'free_speed': 20}, {'joint': 'G', 'stall': 1, 'free_speed': 10}]",
        between(1, 5));
    put(", 'forces': [{'link': 'three', 'at': [1.5, 0.5], 'frame': 'link', 'fx': 'sin(3*t)', 'torque': 0.2},"
        "{'link': 'five', 'at': [2.5, 0.6], 'fx': %s, 'fy': -1}]",
        state ? "'-0.5*v(G) + 0.1*q(C) - 0.1*omega(four)'" : "0.3");
}

static const int runs = 24;

/* Loads without friction: the same motion as in the bodies' coordinates. */
TEST(loads_of_every_kind)
{
    friction = 0;
    int done = 0;
    for (int k = 0; k < runs; k++) {
        lw_rng_seed(&rng, check_seed(), (uint64_t)k);
        write_linkage(k%4);
        put_loads(k%3 == 0);
        put("}");
        drun_read_text(&d, text);
        lw_status s = drun_to(&d, LW_FORMULATION_REDUCED, 1e-11, 2, 10);
        CHECK_INT(s, LW_OK);
        drun_read_text(&other, text);
        s = drun_to(&other, LW_FORMULATION_INDEX1, 1e-11, 2, 10);
        CHECK_INT(s, LW_OK);
        for (int i = 0; i < d.system.n_q && d.n_moment == 11 && other.n_moment == 11; i++) {
            CHECK_NEAR(d.q[i], other.q[i], 1e-7, 0);
            CHECK_NEAR(d.v[i], other.v[i], 1e-6, 1e-6);
            CHECK_NEAR(d.a[i], other.a[i], 1e-5, 1e-5);
        }
        CHECK(d.report.energy_error < 1e-8*d.report.energy_scale);
        done += d.n_moment == 11;
    }
    CHECK_INT(done, runs);
}

/* Ideal friction is the limit of the regularised one.  Added: a crank that turns back slowly near a singular posture, and a reaction
 * that falls to a sixth within a step. */
TEST(ideal_against_regularised)
{
    static const struct { uint64_t seed; int k; } hard[] = { { 1, 2 }, { 22, 3 } };
    for (int n = 0; n < 10; n++) {
        int k = n < 8 ? n : hard[n - 8].k;
        lw_rng_seed(&rng, n < 8 ? check_seed() : hard[n - 8].seed, 100 + (uint64_t)k);
        friction = between(0.05, 0.2);
        write_linkage(k%4);
        put_loads(false);
        put("}");
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 5), LW_OK);
        CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
        CHECK(d.report.energy_error < 1e-7*d.report.energy_scale);
        drun_read_text(&other, text);
        for (int j = 0; j < d.model.linkage.n_joint; j++)
            other.model.friction[j].speed = 1e-5;
        other.o.max_step = 100000;
        CHECK_INT(drun_to(&other, LW_FORMULATION_CVODE, 1e-8, 1, 5), LW_OK);
        double apart[2] = { 0, 0 }, pulls = 0;
        for (int i = 0; i < d.system.n_q; i++) {
            apart[0] = fmax(apart[0], fabs(d.q[i] - other.q[i]));
            pulls = fmax(pulls, fabs(d.a[i] - other.a[i])/(1 + fabs(other.a[i])));
        }
        if (apart[0] > 1e-4 || pulls > 1e-2) {               /* a model that feels the creep more: it falls with the speed */
            for (int j = 0; j < d.model.linkage.n_joint; j++)
                other.model.friction[j].speed = 1e-7;
            other.o.max_step = 1000000;
            CHECK_INT(drun_to(&other, LW_FORMULATION_CVODE, 1e-9, 1, 5), LW_OK);
            for (int i = 0; i < d.system.n_q; i++)
                apart[1] = fmax(apart[1], fabs(d.q[i] - other.q[i]));
            CHECK_NEAR(apart[1], 0, 1e-4, 0);
            CHECK(apart[1] < 0.05*apart[0]);
        }
        /* the error falls with the tolerance */
        double q[LW_SYSTEM_Q_MAX];
        memcpy(q, d.q, sizeof q);
        for (int p = 6; p <= 8; p += 2) {
            CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, pow(10, -p), 1, 5), LW_OK);
            for (int i = 0; i < d.system.n_q; i++)
                CHECK_NEAR(d.q[i], q[i], 100*pow(10, -p), 0);
        }
    }
}

/* A crank that drives n rockers one after another, up to nine. */
static void read_dyads(int n)
{
    lw_rng_seed(&rng, check_seed(), 200);
    used = 0;
    put("{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground'");
    for (int i = 0; i <= n; i++)
        put_link((char[]){ 'c', (char)('0' + i), 0 }, i, 0.4);
    for (int i = 0; i < n; i++)
        put_link((char[]){ 'r', (char)('0' + i), 0 }, i + 0.5, 0.8);
    put("], 'joints': [{'name': 'A0', 'links': ['ground', 'c0'], 'at': [0, 0]}");
    for (int i = 1; i <= n; i++)
        put(",{'name': 'A%d', 'links': ['ground', 'c%d'], 'at': [%d, 0]},{'name': 'B%d', 'links': ['c%d', 'r%d'], 'at': [%d, %g]},"
            "{'name': 'C%d', 'links': ['r%d', 'c%d'], 'at': [%d, %g]}", i, i, i, i, i - 1, i - 1, i - 1, i > 1 ? 0.79 + 0.01*i : 0.3,
            i, i - 1, i, i, 0.8 + 0.01*i);
    put("], 'input': {'joint': 'A0', 'speed': -8}}");
    drun_read_text(&d, text);
}

/* Friction in all 28 pins.  Velocities are integrals of accelerations: those of the
 * coordinate, whose friction is solved dyad by dyad, of those that rows take from the equations of all bodies. */
TEST(friction_in_all_pins_of_nine_dyads)
{
    static const double h = 2.5e-4;
    double v[3][LW_SYSTEM_Q_MAX], a[3][LW_SYSTEM_Q_MAX], most = 0;
    read_dyads(9);
    for (int j = 0; j < d.model.linkage.n_joint; j++)
        d.model.friction[j] = (lw_friction){ 0.1, between(0.05, 0.1), 0 };
    for (int k = 0; k < 3; k++) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, 0.3 + h*k, 1), LW_OK);
        CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
        memcpy(v[k], d.v, sizeof v[k]);
        memcpy(a[k], d.a, sizeof a[k]);
    }
    for (int i = 0; i < d.system.n_q; i++) {
        most = fmax(most, fabs(a[1][i]));
        CHECK_NEAR(v[2][i] - v[0][i], h/3*(a[0][i] + 4*a[1][i] + a[2][i]), 1e-9, 0);      /* Simpson's rule */
    }
    CHECK(most > 1 && d.report.energy_error < 1e-9*d.report.energy_scale);
}

/* Reactions that fall to nearly 0 and rise again hardly add to the error, however the steps and panels lie, and cost few evaluations. */
TEST(reactions_that_fall_to_nearly_0)
{
    static const int dyads[] = { 1, 2, 3, 9 };
    long rates = 0;
    for (int k = 0; k < 4; k++) {
        const int n = dyads[k];
        double exact[LW_SYSTEM_Q_MAX];
        read_dyads(n);
        for (int j = 0; j < d.model.linkage.n_joint; j++)
            if (j == 0 || j%3 == 1)
                d.model.friction[j] = (lw_friction){ 0.05, 0.1, 0 };
        free(d.model.motor);
        d.model.motor = calloc(1, sizeof *d.model.motor);
        d.model.motor[d.model.n_motor++] = (lw_motor){ .name = "motor", .joint = 0, .stall = 15, .free_speed = 20 };
        for (int p = 11; p >= 7; p -= p > 8 ? 3 : 1) {
            CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, pow(10, -p), 5, 1), LW_OK);
            for (int i = 0; p < 11 && i < d.system.n_q; i++)
                CHECK_NEAR(d.q[i], exact[i], 100*pow(10, -p), 0);
            if (p == 11)
                memcpy(exact, d.q, sizeof exact);
            else
                rates += d.report.rates;
        }
    }
    CHECK(rates < 40000);                                /* of six seeds: without panels 46000 to 56000, with them 25000 to 34000 */
}

/* Three links of Jansen's leg meet at a pin, in two places and on the ground: each pin there rubs by the load of its own links. */
TEST(several_pins_at_a_place)
{
    double end[2][3*16];
    for (int smooth = 0; smooth < 2; smooth++) {
        drun_read(&d, "examples/jansen.json");
        for (int i = 0; i < d.model.linkage.n_link; i++)
            d.model.body[i] = (lw_body){ i != d.model.linkage.ground, 1, { 0.002*i, 0.001*i }, 1e-3, false, { 0, 0 }, 0 };
        for (int j = 0; j < d.model.linkage.n_joint; j++)
            d.model.friction[j] = (lw_friction){ 0.05 + 0.01*j, 1e-3, smooth ? 1e-6 : 0 };
        d.model.has_speed[0] = true;
        d.model.speed[0] = 30;
        CHECK_INT(drun_to(&d, smooth ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, 1e-9, 0.1, 2), LW_OK);
        CHECK_INT(d.report.formulation, smooth ? LW_FORMULATION_INDEX1 : LW_FORMULATION_REDUCED);
        memcpy(end[smooth], d.q, (size_t)d.system.n_q*sizeof *d.q);
        CHECK(d.report.energy_error < 1e-7*d.report.energy_scale);
    }
    for (int i = 0; i < d.system.n_q; i++)
        CHECK_NEAR(end[0][i], end[1][i], 1e-6, 0);
}

/* A block that friction stops on a slope, after 9/(2 a) with a = g (mu cos + sin), where it creeps at less than the speed of its friction.  Tolerances far
 * above that speed let Newton's method of cvode step over the friction, which then pushed on. */
TEST(speed_below_the_tolerance)
{
    const double slope = 0.4, stops = 4.5/(9.81*(0.8*cos(slope) + sin(slope)));
    for (int by = 0; by < 2; by++)
        for (double speed = 1e-3; speed > 1e-7; speed *= 0.1)
            for (double tolerance = 1e-2; tolerance > 1e-9; tolerance *= 0.1) {
                drun_read_format(&d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'block', 'mass': 2, 'centre': [0, 0],"
                                 " 'inertia': 0.1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'block'], 'at': [0, 0], 'along':"
                                 " [0.9210609940028851, 0.3894183423086505], 'friction': {'coefficient': 0.8, 'speed': %.17g}}],"
                                 " 'input': {'joint': 'S', 'speed': 3}}", speed, 0);
                CHECK_INT(drun_to(&d, by ? LW_FORMULATION_CVODE : LW_FORMULATION_AUTO, tolerance, 1, 2), LW_OK);
                CHECK_NEAR(hypot(d.q[0], d.q[1])*d.system.unit, stops, 5*tolerance + 3*speed, 0);
                CHECK(d.report.rates < 5000);
            }
}

/* Smooth friction is left to the explicit method until joints that rest make the equations stiff. */
TEST(choice_of_a_method)
{
    for (int stiff = 0; stiff < 2; stiff++) {
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1}, {'name': 'b',"
                         " 'mass': 1, 'centre': [1.5, 0], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0],"
                         " 'friction': {'coefficient': 0.2, 'radius': %g, 'speed': %g}}, {'name': 'B', 'links': ['a', 'b'], 'at': [1, 0]}],"
                         " 'gravity': [0, -9.81]}", stiff ? 0.5 : 0.02, stiff ? 1e-6 : 0.01);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 20, 2), LW_OK);
        CHECK_INT(d.report.formulation, stiff ? LW_FORMULATION_RADAU : LW_FORMULATION_INDEX1);
    }
    double end[2][6];                                    /* a damped chain: implicit, of high order, and the same by index1 */
    for (int f = 0; f < 2; f++) {
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0], 'inertia': 0.004}, {'name': 'b',"
                         " 'mass': 1, 'centre': [0.3, 0], 'inertia': 0.004}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},"
                         " {'name': 'B', 'links': ['a', 'b'], 'at': [0.2, 0]}], 'gravity': [0, -9.81], 'springs': [{'joint': 'A', 'stiffness': 0,"
                         " 'damping': %g}, {'joint': 'B', 'stiffness': 0, 'damping': 10}]}", 10, 0);
        CHECK_INT(drun_to(&d, f ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, 1e-10, 1, 10), LW_OK);
        CHECK_INT(d.report.formulation, f ? LW_FORMULATION_INDEX1 : LW_FORMULATION_RADAU);
        memcpy(end[f], d.q, sizeof end[f]);
    }
    for (int i = 0; i < 6; i++)
        CHECK_NEAR(end[0][i], end[1][i], 1e-8, 0);
}

static const char double_pendulum[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1}, {'name': 'b', 'mass': 1, 'centre': [1.5, 0],"
    " 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [1, 0]}],"
    " 'gravity': [0, -9.81], 'springs': [";

/* A stiff spring in a joint is left to radau while the vibration is below the tolerance or damped, and goes on by index1 where it has to be
 * followed; a soft one is index1's.  Four dampers in a joint are one that is four times as strong. */
TEST(choice_with_springs)
{
    static const struct { double stiffness, damping, tolerance; lw_formulation by; } of[] = {
        { 1e6, 0, 1e-4, LW_FORMULATION_RADAU }, { 1e6, 5, 1e-7, LW_FORMULATION_RADAU }, { 1e6, 0, 1e-8, LW_FORMULATION_INDEX1 },
        { 1e3, 0, 1e-8, LW_FORMULATION_INDEX1 } };
    for (int k = 0; k < 4; k++) {
        double end[6];
        char format[1000];
        snprintf(format, sizeof format, "%s{'joint': 'B', 'stiffness': %%g, 'damping': %%g}]}", double_pendulum);
        drun_read_format(&d, format, of[k].stiffness, of[k].damping);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-11, 1, 10), LW_OK);
        long rates = d.report.rates;
        memcpy(end, d.q, sizeof end);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, of[k].tolerance, 1, 10), LW_OK);
        CHECK_INT(d.report.formulation, of[k].by);
        CHECK((strncmp(d.report.why, "radau to", 8) == 0) == (k == 2));
        CHECK(k > 1 || 2*d.report.rates < rates);
        for (int i = 0; i < 6; i++)
            CHECK_NEAR(d.q[i], end[i], 100*of[k].tolerance, 0);
    }
    for (int four = 0; four < 3; four++) {               /* one, four and one of these alone */
        lw_dynamics *m = NULL;
        char format[2000];
        int end = snprintf(format, sizeof format, "%s", double_pendulum);
        for (int k = 0; k < (four == 1 ? 4 : 1); k++)
            end += snprintf(format + end, sizeof format - (size_t)end, "%s{'joint': 'B', 'stiffness': 0, 'damping': %s}", k ? "," : "",
                             four ? "15" : "60");
        snprintf(format + end, sizeof format - (size_t)end, "]}");
        drun_read_format(&d, format, 0, 0);
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &m, &d.e), LW_OK);
        CHECK_INT(lw_dynamics_choice(m)->formulation, four == 2 ? LW_FORMULATION_INDEX1 : LW_FORMULATION_RADAU);
        lw_dynamics_free(m);
    }
}

/* A rhombus whose pins rub comes to a flat posture, where friction jams it: `cvode` hands the run over, with a reason, and `index1` names the jam. */
TEST(a_jam_is_named)
{
    const char *pin = "'friction': {'coefficient': 0.05, 'radius': 0.028, 'speed': 0.01}";
    json_format(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -9.81], 'input': {'joint': 'A', 'speed': -1}, 'links': ['ground', {'name': 'crank', 'mass': 1, "
        "'centre': [0, 0.5], 'inertia': 0.0833}, {'name': 'rocker', 'mass': 1, 'centre': [1, 0.5], 'inertia': 0.0833}, {'name': 'rod', 'mass': 1, 'centre': "
        "[0.5, 1], 'inertia': 0.0833}], 'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0], %s}, {'name': 'B', 'links': ['ground', 'rocker'], "
        "'at': [1, 0], %s}, {'name': 'C', 'links': ['crank', 'rod'], 'at': [0, 1], %s}, {'name': 'D', 'links': ['rod', 'rocker'], 'at': [1, 1], %s}]}",
        pin, pin, pin, pin);
    drun_read_json(&d, text);
    CHECK_INT(drun_to(&d, LW_FORMULATION_CVODE, 1e-4, 2, 20), LW_E_NUMERIC);
    CHECK_INT(d.report.gave_up, LW_FORMULATION_CVODE);
    CHECK(strncmp(d.report.why, "cvode gave up: ", 15) == 0 && d.report.why[15] != '\0');
    CHECK(strstr(d.e.text, "friction jams the linkage") != NULL);
}

/* Smooth friction in one coordinate is that of the bodies' coordinates.  With set-valued friction in a pin beside it, the motion is the limit of a falling
 * speed there, and the linkage comes to rest. */
TEST(smooth_friction_in_one_coordinate)
{
    static const struct { const char *pin; double to, off; lw_formulation by, other; } part[] = {
        { ", 'speed': 0.01", 1, 1e-7, LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1 },
        { ", 'speed': 0.01", 1, 1e-7, LW_FORMULATION_REDUCED, LW_FORMULATION_RADAU },
        { "", 1, 3e-6, LW_FORMULATION_REDUCED, LW_FORMULATION_CVODE }, { "", 12, 1e-5, LW_FORMULATION_REDUCED, LW_FORMULATION_CVODE } };
    for (size_t k = 0; k < sizeof part/sizeof *part; k++) {
        double end[2][9];
        for (int f = 0; f < 2; f++) {
            const char *smooth = "'friction': {'coefficient': 0.2, 'radius': 0.03, 'speed': 0.01}";
            json_format(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -9.81], 'input': {'joint': 'A', 'speed': -3}, 'links': ['ground', "
                "{'name': 'crank', 'mass': 1, 'centre': [0, 0.25], 'inertia': 0.03}, {'name': 'rod', 'mass': 1, 'centre': [0.6, 0.8], 'inertia': 0.1}, "
                "{'name': 'rocker', 'mass': 1, 'centre': [1.1, 0.5], 'inertia': 0.08}], 'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0], "
                "%s}, {'name': 'B', 'links': ['crank', 'rod'], 'at': [0, 0.5], %s}, {'name': 'C', 'links': ['rod', 'rocker'], 'at': [1.2, 1], %s}, "
                "{'name': 'D', 'links': ['ground', 'rocker'], 'at': [1, 0], 'friction': {'coefficient': 0.3, 'radius': 0.05%s}}]}",
                smooth, smooth, smooth, f && !*part[k].pin ? ", 'speed': 1e-7" : part[k].pin);
            drun_read_json(&d, text);
            CHECK_INT(drun_to(&d, f ? part[k].other : part[k].by, 1e-10, part[k].to, 20), LW_OK);
            CHECK_INT(d.report.formulation, f ? part[k].other : LW_FORMULATION_REDUCED);
            memcpy(end[f], d.q, sizeof end[f]);
        }
        for (int i = 0; i < 9; i++)
            CHECK_NEAR(end[0][i], end[1][i], part[k].off, 0);
        CHECK(part[k].to < 2 || d.report.energy_error < 1e-4);
    }
}

/* A slip that changes its sign within a step of the explicit method, or falls to nearly 0 and rises again, is not missed: two links that swing and come to
 * rest, by formulations that share no steps. */
TEST(slips_that_reverse_within_a_step)
{
    static const struct { const char *friction; double to; } part[] = {
        { "'coefficient': 0.5, 'radius': 0.1, 'speed': 1e-3", 3 }, { "'coefficient': 0.2, 'radius': 0.03, 'speed': 1e-5", 5 } };
    for (size_t k = 0; k < sizeof part/sizeof *part; k++) {
        json_format(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', "
            "{'name': 'b0', 'mass': 1, 'centre': [0.25, 0], 'inertia': 0.020833333333333332}, {'name': 'b1', 'mass': 1, 'centre': [0.75, 0], 'inertia': "
            "0.020833333333333332}], 'joints': [{'name': 'J0', 'links': ['ground', 'b0'], 'at': [0, 0], 'friction': {%s}}, {'name': 'J1', 'links': ['b0', "
            "'b1'], 'at': [0.5, 0], 'friction': {%s}}]}", part[k].friction, part[k].friction);
        drun_read_json(&d, text);
        drun_read_json(&other, text);
        CHECK_INT(drun_to(&other, LW_FORMULATION_RADAU, 1e-11, part[k].to, 20), LW_OK);
        for (int f = 0; f < 2; f++)
            for (double tolerance = 1e-4; tolerance > 0.5e-8; tolerance *= 0.1) {
                CHECK_INT(drun_to(&d, f ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, tolerance, part[k].to, 20), LW_OK);
                for (int i = 0; i < 6; i++)
                    CHECK_NEAR(d.q[i], other.q[i], 30*tolerance, 0);
            }
    }
}

/* With enough friction a linkage at rest stays so, in balance with the part of the friction that acts. */
TEST(linkage_rests)
{
    int rests = 0;
    for (int k = 0; k < 8; k++) {
        lw_rng_seed(&rng, check_seed(), 200 + (uint64_t)k);
        friction = 0.2;
        write_linkage(k%4);
        put("}");
        drun_read_text(&d, text);
        d.model.has_speed[0] = false;
        for (int j = 0; j < d.model.linkage.n_joint; j++)       /* enough to hold most of them */
            d.model.friction[j].radius *= 6;
        lw_status s = drun_to(&d, LW_FORMULATION_AUTO, 1e-8, 5, 5);
        CHECK_INT(s, LW_OK);
        double most = 0;
        for (int i = 0; i < d.system.n_q; i++)
            most = fmax(most, fabs(d.v[i]));
        for (int i = 0; i < d.system.n_q && most == 0; i++)
            CHECK_NEAR(d.a[i], 0, 1e-7, 0);      /* the tolerance of the reactions */
        rests += most == 0;
    }
    CHECK(rests > 4);
}
