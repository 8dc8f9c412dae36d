/* Mechanisms of textbooks, examples/dynamics: every formulation that takes them against the equations of the
 * textbooks, in as few coordinates as there are freedoms. */
#include "base/rank.h"
#include "mbs/equilibrium/modes.h"
#include "tests/dynamics_run.h"

static drun d;

static const lw_formulation all[] = { LW_FORMULATION_QUADRATURE, LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1,
                                      LW_FORMULATION_CVODE, LW_FORMULATION_GGL };
static const double g = 9.81;

/* Place of the tracer at the end of the textbook's equations: where(y, t), started at y0. */
typedef struct book {
    const char *file;
    double      to;
    lw_ode      ode;
    double      start[6];
    lw_vec2   (*where)(const double *y, double t);
} book;

static void compare(const book *b)
{
    double y[6];
    int n_run = 0;
    memcpy(y, b->start, sizeof y);
    drun_exact(&b->ode, 0, y, b->to);
    lw_vec2 want = b->where(y, b->to);
    drun_read(&d, b->file);
    for (int f = 0; f < 5; f++) {
        bool tight = f < 3;
        lw_status s = drun_to(&d, all[f], tight ? 1e-12 : 1e-9, b->to, 4);
        if (f < 2 && s == LW_E_KIND)
            continue;
        CHECK_INT(s, LW_OK);
        CHECK_POINT(d.tracer[4], want.x, want.y, tight ? 1e-8 : 2e-5, 0);
        CHECK(d.report.energy_error < (tight ? 1e-10 : 1e-5)*d.report.energy_scale);
        n_run++;
    }
    CHECK(n_run >= 3);
}

/* ---- trebuchet ------------------------------------------------------------------------------------- */

/* Parts of mass m, at the sum of arm[i] along angle i; the beam has an inertia besides. */
static const struct { double mass, arm[3]; } part[] = { { 10, { 0.75, 0, 0 } }, { 200, { -0.5, 0.6, 0 } },
                                                        { 2, { 2, 0, 1.5 } } };

/* sum over j of K_ij (cos(a_i - a_j) a_j'' + sin(a_i - a_j) a_j'^2) = -g G_i cos a_i */
static lw_status trebuchet_rate(void *context, double t, const double *y, double *dy)
{
    double m[9], right[3] = { 0 }, work[64];
    int ints[16];
    lw_rank r;
    (void)context, (void)t;
    lw_rank_place(&r, 3, 3, work, ints);
    for (int i = 0; i < 3; i++) {
        dy[i] = y[3 + i];
        for (int j = 0; j < 3; j++) {
            double k = 0;
            for (int p = 0; p < 3; p++)
                k += part[p].mass*part[p].arm[i]*part[p].arm[j];
            m[i + 3*j] = k*cos(y[i] - y[j]) + (i == 0 && j == 0 ? 4 : 0);
            right[i] -= k*sin(y[i] - y[j])*y[3 + j]*y[3 + j];
        }
        for (int p = 0; p < 3; p++)
            right[i] -= g*part[p].mass*part[p].arm[i]*cos(y[i]);
    }
    memcpy(r.a, m, sizeof m);
    lw_rank_factor(&r, 1e-14);
    lw_rank_solve(&r, right, dy + 3);
    return LW_OK;
}

static lw_vec2 stone(const double *y, double t)
{
    (void)t;
    return lw_v2_add(lw_v2_polar(2, y[0]), lw_v2_polar(1.5, y[2]));
}

TEST(trebuchet)
{
    compare(&(book){ "examples/dynamics/trebuchet.json", 1.5, { .n = 6, .rate = trebuchet_rate },
                     { -LW_PI/4 - 0.2, -LW_PI/2, 0 }, stone });
}

/* ---- one freedom ------------------------------------------------------------------------------------- */

/* Its middle on a circle of radius L/2: that pendulum with inertia m L^2/12. */
static lw_status ladder_rate(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1];
    dy[1] = -0.75*g*cos(y[0]);
    return LW_OK;
}

static lw_vec2 middle(const double *y, double t)
{
    (void)t;
    return lw_v2_polar(1, y[0]);
}

/* r 0.3, centre of mass 0.1 below the wheel's: (I + m (r^2 + e^2 - 2 r e cos q)) q'' + m r e sin q q'^2
 * = -m g e sin q. */
static lw_status wheel_rate(void *context, double t, const double *y, double *dy)
{
    const double r = 0.3, e = 0.1, m = 2;
    (void)context, (void)t;
    dy[0] = y[1];
    dy[1] = -m*e*sin(y[0])*(g + r*y[1]*y[1])/(0.05 + m*(r*r + e*e - 2*r*e*cos(y[0])));
    return LW_OK;
}

static lw_vec2 wheel(const double *y, double t)
{
    (void)t;
    return lw_v2(0.3*y[0], 0.3);
}

/* The pivot at 0.02 cos 200 t: it stays up, for 0.02*200 > sqrt(2 g l). */
static lw_status shaken_rate(void *context, double t, const double *y, double *dy)
{
    (void)context;
    dy[0] = y[1];
    dy[1] = (g - 0.02*200*200*cos(200*t))/0.2*sin(y[0]);
    return LW_OK;
}

static lw_vec2 shaken(const double *y, double t)
{
    CHECK(fabs(y[0]) < 0.2);
    return lw_v2(0.2*sin(y[0]), 0.02*cos(200*t) + 0.2*cos(y[0]));
}

/* Inversion OP OQ = 16, OP = 3 cos(q/2), so that Q goes along x = 16/3 at 16/3 tan(q/2); damped by 0.5 q'. */
static lw_status inversor_rate(void *context, double t, const double *y, double *dy)
{
    double c = cos(0.5*y[0]), slope = 8/(3*c*c), bend = slope*tan(0.5*y[0]);      /* derivatives of y of Q by q */
    (void)context, (void)t;
    dy[0] = y[1];
    dy[1] = -(0.5*y[1] + slope*bend*y[1]*y[1])/(0.05 + slope*slope);
    return LW_OK;
}

static lw_vec2 on_the_line(const double *y, double t)
{
    (void)t;
    return lw_v2(16./3, 16./3*tan(0.5*y[0]));
}

TEST(one_freedom)
{
    compare(&(book){ "examples/dynamics/inversor.json", 0.8, { .n = 2, .rate = inversor_rate }, { 0.6, -3 },
                     on_the_line });
    compare(&(book){ "examples/dynamics/falling-ladder.json", 2, { .n = 2, .rate = ladder_rate }, { 1.2, 0 },
                     middle });
    compare(&(book){ "examples/dynamics/rolling-wheel.json", 3, { .n = 2, .rate = wheel_rate }, { 2, 0 }, wheel });
    compare(&(book){ "examples/dynamics/shaken-pendulum.json", 1, { .n = 2, .rate = shaken_rate }, { 0.1, 0 },
                     shaken });
}

/* ---- governor ------------------------------------------------------------------------------------------ */

/* (I + 2 m r^2) w is kept; m r'' = m r w^2 - k (r - 0.2). */
static lw_status governor_rate(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[2];
    dy[1] = y[3];
    dy[2] = -2*y[1]*y[3]*y[2]/(0.05 + y[1]*y[1]);
    dy[3] = y[1]*y[2]*y[2] - 400*(y[1] - 0.2);
    return LW_OK;
}

static lw_vec2 slid(const double *y, double t)
{
    (void)t;
    return lw_v2_polar(y[1], y[0]);
}

TEST(governor)
{
    compare(&(book){ "examples/dynamics/governor.json", 2, { .n = 4, .rate = governor_rate },
                     { 0, 0.2, 15, 0 }, slid });
}

/* ---- beam ---------------------------------------------------------------------------------------------- */

/* Of n links of length 1/n with springs E I n between them, twice that at the wall; E I = 1, mass and length 1. */
static double lowest(int n, int mode)
{
    static char text[20000];
    static lw_modes modes;
    OWN(lw_system) s = { 0 };
    OWN(lw_forces) f = { 0 };
    double q[LW_SYSTEM_Q_MAX];
    int at = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
    for (int k = 0; k < n; k++)
        at += snprintf(text + at, sizeof text - at, ",{'name': 'b%d', 'mass': %.17g, 'centre': [%.17g, 0],"
                       "'inertia': %.17g}", k, 1./n, (k + 0.5)/n, 1./12/n/n/n);
    at += snprintf(text + at, sizeof text - at, "], 'joints': [");
    for (int k = 0; k < n; k++)
        at += snprintf(text + at, sizeof text - at, "%s{'name': 'J%d', 'links': ['%s%.0d', 'b%d'], 'at': [%.17g, 0]}",
                       k ? "," : "", k, k == 0 ? "ground" : k == 1 ? "b0" : "b", k > 1 ? k - 1 : 0, k, (double)k/n);
    at += snprintf(text + at, sizeof text - at, "], 'springs': [");
    for (int k = 0; k < n; k++)
        at += snprintf(text + at, sizeof text - at, "%s{'joint': 'J%d', 'stiffness': %d}", k ? "," : "", k,
                       k ? n : 2*n);
    snprintf(text + at, sizeof text - at, "]}");
    json_quotes(text);
    drun_read_text(&d, text);
    CHECK_OK(lw_forces_system(&d.model, false, &s, &check_error));
    CHECK_OK(lw_forces_make(&d.model, &s, NULL, &f, &check_error));
    lw_system_posture(&s, q);
    CHECK_OK(lw_modes_find(&f, &(lw_modes_options){ 0 }, 0, q, &modes, &check_error));
    CHECK_INT(modes.n_mode, n);
    double rate = modes.mode[mode].im;
    lw_modes_free(&modes);
    return rate;
}

/* (b L)^2 sqrt(E I/m), cos b cosh b = -1; lower by a part that falls with the square of the length of a link. */
TEST(cantilever)
{
    static const double b[] = { 1.8751040687119611, 4.6940911329741746, 7.8547574382376126 };
    for (int mode = 0; mode < 3; mode++) {
        double want = b[mode]*b[mode], off[3];
        for (int k = 0; k < 3; k++)
            off[k] = 1 - lowest(7 << k, mode)/want;
        CHECK(off[2] > 0 && off[2] < 0.001*(1 + 3*mode));
        CHECK_NEAR(off[0]/off[1], 4, 0, 0.12);
        CHECK_NEAR(off[1]/off[2], 4, 0, 0.04);
    }
}

/* ---- slides tied to each other on a link that turns -------------------------------------------------------------- */

/* Turn p of the arm and slide s of the first weight, the second one slides 0.6 s: Lagrange's equations. */
static lw_status tied_rate(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    double p = y[0], s = y[1], dp = y[2], ds = y[3], r = 0.3 + s, l = 0.5 + 0.6*s;
    double inertia = 0.12 + r*r + 0.01 + 0.7*l*l, cross = -0.1, mass = 1 + 0.7*0.36, change = 2*(r + 0.7*0.6*l);
    double moment = -change*ds*dp - g*(cos(p)*r - sin(p)*0.1) - 0.7*g*sin(p)*l;
    double force = 0.5*change*dp*dp - g*sin(p) + 0.7*g*0.6*cos(p) - 200*s, det = inertia*mass - cross*cross;
    dy[0] = dp, dy[1] = ds;
    dy[2] = (mass*moment - cross*force)/det;
    dy[3] = (inertia*force - cross*moment)/det;
    return LW_OK;
}

TEST(slides_tied_on_a_turning_link)
{
    static const lw_formulation way[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL, LW_FORMULATION_RADAU };
    double y[4] = { 0 };
    drun_exact(&(lw_ode){ .n = 4, .rate = tied_rate }, 0, y, 2);
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 0.5, 'centre': [0, 0], 'inertia': 0.1}, {'name': 'b', 'mass': 1, "
        "'centre': [0.3, 0.1], 'inertia': 0.01}, {'name': 'c', 'mass': 0.7, 'centre': [0, -0.5], 'inertia': 0.01}], 'joints': [{'name': 'A', 'links': "
        "['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'kind': 't', 'links': ['a', 'b'], 'at': [0.3, 0.1], 'along': [1, 0]}, {'name': 'C', 'kind': 't', "
        "'links': ['a', 'c'], 'at': [0, -0.5], 'along': [0, -1]}], 'gravity': [0, -9.81], 'springs': [{'joint': 'B', 'stiffness': 200}], 'inputs': "
        "[{'joint': 'B'}, {'joint': 'C', 'ratio': 0.6}], 'tracers': [{'name': 'P', 'link': 'b', 'at': [0.3, 0.1]}]}", 0, 0);
    for (size_t i = 0; i < sizeof way/sizeof *way; i++) {
        double allowed = i == 0 || i == 3 ? 1e-7 : 1e-4, c = cos(y[0]), s = sin(y[0]);
        CHECK_INT(drun_to(&d, way[i], 1e-9, 2, 1), LW_OK);
        CHECK_POINT(d.tracer[1], c*(0.3 + y[1]) - s*0.1, s*(0.3 + y[1]) + c*0.1, allowed, 0);
        CHECK(d.report.steps < 20000);
    }
}
