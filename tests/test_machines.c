/* The gantry and the boom of the examples, run through the library as a user would: the motion that the source prints,
 * forces of single axes, a beam with a mass, a move that leaves no swing, a boom on its cylinder, parallel holes.
 * Reference values were worked out by independent models of the declared data. */
#include "linkwright.h"

#include "base/vec2.h"
#include "base/vec3.h"
#include "tests/json_text.h"

#define MAX 12000

typedef struct run { int n; double t[MAX], x[MAX], v[MAX], a[MAX], drive[3][MAX]; lw_vec3 tool[MAX]; } run;
static run r;
static int link_seen;                          /* the link whose acceleration along x is kept */

static lw_status keep(void *context, const lw_spatial_sample *s)
{
    int i = r.n++;
    (void)context;
    if (r.n > MAX)
        return LW_E_ARG;
    r.t[i] = s->t;
    r.x[i] = s->input[0];
    r.v[i] = s->rate[0];
    r.a[i] = s->link[link_seen].acceleration.x;
    for (int k = 0; k < 3; k++)
        r.drive[k][i] = s->drive[k];
    r.tool[i] = s->tracer[0].place;
    return LW_OK;
}

static struct { int n; double power[2001], energy[2001]; lw_frame_motion first[9]; double length; } holes;

static lw_spatial *variant(const char *master, const char *view, const char *const *set)
{
    lw_master *m = NULL;
    lw_variant *v = NULL;
    lw_spatial *out = NULL;
    CHECK_OK(lw_master_load(master, &m, &check_error));
    CHECK_INT(lw_variant_create(m, &v), LW_OK);
    CHECK_OK(lw_variant_look(v, view, &check_error));
    for (; *set; set += 2)
        CHECK_OK(lw_variant_set(v, set[0], set[1], &check_error));
    CHECK_SILENT(lw_variant_spatial(v, &out, &check_error));
    lw_variant_destroy(v);
    lw_master_destroy(m);
    return out;
}

static int number_of(const lw_spatial *m, char what, const char *name)
{
    for (int i = 0; i < lw_spatial_count(m, what); i++)
        if (strcmp(lw_spatial_name(m, what, i), name) == 0)
            return i;
    CHECK(false);
    return 0;
}

static void simulate(const lw_spatial *m, const char *analysis, double to, int intervals, lw_spatial_callback *visit)
{
    lw_simulation_options o = lw_simulation_options_default();
    lw_simulation_report report;
    o.analysis = analysis;
    o.to = to;
    o.intervals = intervals;
    o.tolerance = visit == keep && strcmp(analysis, "transient") == 0 ? 1e-7 : o.tolerance;
    r.n = 0;
    CHECK_SILENT(lw_spatial_simulate(m, &o, visit, (void *)(size_t)m, &report, &check_error));
    CHECK_INT(visit == keep ? r.n : holes.n, intervals + 1);
}

static double peak(const double *v, double from, double to)
{
    double most = 0;
    for (int i = 0; i < r.n; i++)
        if (r.t[i] >= from && r.t[i] <= to)
            most = fmax(most, fabs(v[i]));
    return most;
}

/* ---- gantry ------------------------------------------------------------------------------------------------- */

#define GANTRY "examples/families/gantry.json"

/* The program of the X axis that Makkonen 1999, paper A, prints: it needs 1033 m/s^2 where paper D allows 20. */
TEST(the_printed_program)
{
    static const char motion[] =
        "0.001*(havsin(t, 0, 0, 0.05, 250)*step(t, 0, 0, 0.01, 1)*step(t, 0.04, 1, 0.06, 0)+ 250*step(t, 0.04, 0, "
        "0.06, 1)*step(t, 0.54, 1, 0.56, 0)+ havsin(t, 0.55, 250, 0.82, -700)*step(t, 0.54, 0, 0.56, 1)*step(t, 0.81, "
        "1, 0.83, 0)+ havsin(t, 0.82, -700, 1.05, 0)*step(t, 0.81, 0, 0.83, 1)*step(t, 1.04, 1, 1.06, 0))";
    static const double want[][2] = { { 0.025, 0.125 }, { 0.05, 0.25 }, { 0.3, 0.25 }, { 0.685, -0.225 },
                                     { 0.82, -0.7 },
                                      { 0.935, -0.35 }, { 1.05, 0 } };
    lw_spatial *m = variant(GANTRY, "dynamic", (const char *const[]){ NULL });
    CHECK_OK(lw_spatial_set_motion(m, number_of(m, 'i', "x"), motion, &check_error));
    link_seen = number_of(m, 'l', "bridge");
    simulate(m, "kinematic", 1.07, 10700, keep);
    for (size_t i = 0; i < sizeof want/sizeof *want; i++)
        CHECK_NEAR(r.x[(int)(want[i][0]*1e4 + 0.5)], want[i][1], 1e-9, 0);
    CHECK_NEAR(peak(r.v, 0, 1.07), 7.854, 5e-4, 0);
    double before = 3*fabs(r.a[99]) - 3*fabs(r.a[98]) + fabs(r.a[97]);     /* at 0.010 s it falls to 399 at once */
    double turn = LW_PI/0.05, want_before = fabs(0.125*turn*turn*cos(0.2*LW_PI) - 0.125*(1 - cos(0.2*LW_PI))*6e4);
    CHECK_NEAR(want_before, 1033.14, 0.005, 0);
    CHECK_NEAR(before, want_before, 0.05, 0);
    CHECK_NEAR(fabs(r.a[100]), 399, 0.5, 0);
    CHECK(peak(r.a, 0, 0.53) < before);
    CHECK_NEAR(peak(r.a, 0.53, 0.825), 85.5, 0.06, 0);         /* it still rises at 0.825 s */
    CHECK_NEAR(peak(r.a, 0.825, 1.07), 86.1, 0.05, 0);
    CHECK_OK(lw_spatial_set_motion(m, number_of(m, 'i', "x"), "0.001*havsin(t, 0.55, 250, 0.82, -700)", &check_error));
    simulate(m, "kinematic", 1.07, 1070, keep);
    CHECK_NEAR(peak(r.a, 0.55, 0.82), 64.3, 0.05, 0);          /* the second move without its windows */
    lw_spatial_destroy(m);
}

/* Three axes at right angles do not disturb each other: each drive carries what hangs on it. */
TEST(axes_alone_and_together)
{
    lw_spatial *m = variant(GANTRY, "dynamic", (const char *const[]){ NULL });
    double area = 0.2*0.2 - 0.188*0.188, bridge = area*3*2700 + 20,
        mass[3] = { bridge + 15 + 12 + 12, 15 + 12 + 12, 12 + 12 };
    static const char *const motion[] = { "step(t, 0.3, 0, 0.9, 0.5)", "step(t, 0.3, 0, 0.9, 1)",
                                          "step(t, 0, 0, 0.36, 0.2) - step(t, 0.84, 0, 1.2, 0.8)" };
    static const double from[3][2] = { { 0.3, 0.9 }, { 0.3, 0.9 }, { 0, 0.36 } }, way[3] = { 0.5, 1, 0.2 };
    link_seen = number_of(m, 'l', "bridge");
    for (int k = 0; k < 3; k++)
        CHECK_INT(lw_spatial_set_motion(m, number_of(m, 'i', (const char *const[]){ "x", "y", "z" }[k]), motion[k], &check_error),
                  LW_OK);
    simulate(m, "kinematic", 1.2, 240, keep);
    for (int i = 0; i < r.n; i++)
        for (int k = 0; k < 3; k++) {
            double begin = from[k][0], end = from[k][1], u = (r.t[i] - begin)/(end - begin), t = end - begin;
            double a = u > 0 && u < 1 ? way[k]*(6 - 12*u)/(t*t) : 0;
            bool kink = fabs(u) < 1e-9 || fabs(u - 1) < 1e-9;
            if (kink || (k == 2 && r.t[i] > 0.8))
                continue;
            double alone = mass[k]*(a + (k == 2 ? 9.81 : 0));
            CHECK_NEAR(r.drive[number_of(m, 'i', (const char *const[]){ "x", "y", "z" }[k])][i], alone,
                       1e-10*(100 + fabs(alone)), 0);
        }
    lw_spatial_destroy(m);
}

static double found[8];
static int n_found;
static lw_status keep_frequency(void *context, const lw_vibration_info *v)
{
    (void)context;
    if (n_found < 8)
        found[n_found++] = v->natural;
    return LW_OK;
}

/* A quick move that lets the acceleration rise over whole periods leaves the gripper at rest. */
TEST(a_move_without_swing)
{
    const char *set[] = { "ramp", "limits", "lift", "0", "lower", "0", "damping", "0", "swing", NULL, NULL };
    double left[2];
    char hertz[40];
    set[8] = NULL;
    lw_spatial *m = variant(GANTRY, "elastic", set);
    n_found = 0;
    CHECK_OK(lw_spatial_vibrations(m, true, true, keep_frequency, NULL, &check_error));
    lw_spatial_destroy(m);
    snprintf(hertz, sizeof hertz, "%.9f", found[0]);
    for (int shaped = 0; shaped < 2; shaped++) {
        set[8] = shaped ? "swing" : NULL;
        set[9] = hertz;
        m = variant(GANTRY, "elastic", set);
        simulate(m, "transient", 1.2, 480, keep);
        double least = 1, most = -1;
        for (int i = 0; i < r.n; i++)
            if (r.t[i] > 0.75) {
                least = fmin(least, r.tool[i].x);
                most = fmax(most, r.tool[i].x);
            }
        left[shaped] = most - least;
        CHECK_NEAR((most + least)/2, 0.5, 1e-4, 0);
        lw_spatial_destroy(m);
    }
    CHECK(left[0] > 5e-4);
    CHECK(left[1] < 0.01*left[0]);
}

/* A hinged beam with a mass in its middle: the root of 2 = mass/beam u (tan u - tanh u), f = (2u/L)^2 sqrt(E I/rho
 * A)/(2 pi). */
TEST(a_beam_with_a_mass)
{
    static const char format[] = "{'linkwright': 1, 'links': ['ground', {'name': 'bridge', 'elastic': {'section': {'shape': 'box', 'width': 0.1, "
        "'height': 0.1, 'wall': 0.004}, 'material': {'E': 70e9, 'G': 1e15, 'density': 2700}, 'segments': 16, 'axis': [[0, 0, 0], [0, 3, 0], [0, 6, 0]]}}, "
        "{'name': 'carriage', 'mass': %g, 'centre': [0, 3, 0], 'inertia': [1e-6, 1e-6, 1e-6]},{'name': 'end', 'mass': 1e-3, 'centre': [0, 6, 0], "
        "'inertia': [1e-6, 1e-6, 1e-6]}],'joints': [{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'bridge'], 'at': [0, 0, 0], 'axis': [1, 0, "
        "0]},{'name': 'B', 'kind': 'spherical', 'links': ['end', 'bridge'], 'at': [0, 6, 0]},{'name': 'S', 'kind': 'prismatic', 'links': ['ground', "
        "'end'], 'at': [0, 6, 0], 'axis': [0, 1, 0]},{'name': 'W', 'kind': 'fixed', 'links': ['bridge', 'carriage'], 'at': [0, 3, 0]}], 'tracers': []}";
    static const double mass[] = { 5, 30, 200 };
    double area = 0.1*0.1 - 0.092*0.092, second = (pow(0.1, 4) - pow(0.092, 4))/12, beam = 2700*area*6;
    for (int i = 0; i < 3; i++) {
        char text[2000];
        lw_spatial *m = NULL;
        json_format(text, sizeof text, format, mass[i]);
        double low = 0.1, high = LW_PI/2 - 1e-9;
        while (high - low > 1e-14) {
            double u = (low + high)/2;
            *(mass[i]/beam*u*(tan(u) - tanh(u)) > 2 ? &high : &low) = u;
        }
        double want = pow(2*low/6, 2)*sqrt(70e9*second/(2700*area))/(2*LW_PI);
        n_found = 0;
        CHECK_SILENT(lw_spatial_parse(text, strlen(text), "beam", &m, &check_error));
        if (!m)
            continue;
        CHECK_SILENT(lw_spatial_vibrations(m, false, false, keep_frequency, NULL, &check_error));
        bool there = false;
        for (int k = 0; k < n_found; k++)
            there |= fabs(found[k] - want) < 2e-3*want;
        CHECK(there);
        if (!there)
            fprintf(stderr, "    %g: %g %g %g\n", want, found[0], found[1], found[2]);
        lw_spatial_destroy(m);
    }
}

/* ---- boom --------------------------------------------------------------------------------------------------- */

static lw_status keep_rest(void *context, const lw_simulation_sample *s)
{
    double *out = context;
    out[0] = s->tracer[0].y;
    out[1] = s->joint[0].force.x;
    return LW_OK;
}

/* The declared boom: a steel box of 5 m with 400 kg, on a cylinder that gives way as its oil does, and on a rigid one.
 * The reference is linear: a thousandth of the weight, a thousand times the deflection. */
TEST(a_boom_on_its_cylinder)
{
    static const char format[] = "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'boom', 'elastic': {'section': {'shape': "
        "'box', 'width': 0.2, 'height': 0.2, 'wall': 0.008}, 'material': {'E': 210e9, 'nu': 0.3, 'density': 7850}, 'segments': %d, 'mass': '%s', 'axis': "
        "[[0, 0], [5, 0]]}}, {'name': 'load', 'mass': 400, 'centre': [5, 0], 'inertia': 1e-6}], 'joints': [{'name': 'pin', 'links': ['ground', 'boom'], "
        "'at': [0, 0]}, {'name': 'weld', 'kind': 'f', 'links': ['boom', 'load'], 'at': [5, 0]}], 'springs': [{'name': 'cylinder', 'links': ['ground', "
        "'boom'], 'at': [[0.4, -0.8], [1, 0]], 'stiffness': %g, 'free': 1}], 'gravity': [0, -9.81e-3], 'tracers': [{'name': 'tip', 'link': 'load', 'at': "
        "[5, 0]}], 'input': {'joint': 'pin'}}";
    static const struct { double stiffness, tip, hertz[3]; int segments; const char *mass; } rows[] = {
        { 6.819319e7, -19.100, { 3.7284, 46.130, 116.117 }, 80, "consistent" }, { 1e15, -16.175, { 4.0406, 0, 0 }, 80, "lumped" },
        { 6.819319e7, -19.100, { 3.7284, 0, 0 }, 20, "lumped" }
    };                                                         /* with the elastic cylinder limits of many elements, which consistent masses have */
    for (int i = 0; i < 3; i++) {
        char text[2000];
        lw_model *m = NULL;
        lw_simulation *s = NULL;
        double rest[2] = { 0 };
        lw_simulation_options o = lw_simulation_options_default();
        o.analysis = "static";
        json_format(text, sizeof text, format, rows[i].segments, rows[i].mass, rows[i].stiffness);
        CHECK_SILENT(lw_model_parse(text, strlen(text), "boom", &m, &check_error));
        CHECK_OK(lw_simulation_create(m, &o, &s, &check_error));
        CHECK_SILENT(lw_simulation_run(s, keep_rest, rest, NULL, &check_error));
        CHECK_NEAR(rest[0]*1e6, rows[i].tip, rows[i].segments == 80 ? 5e-4 : 5e-3, 0);        /* [mm]; weights are lumped at the nodes */
        if (i == 0)
            CHECK_NEAR(-rest[1]/0.6*1e3, 31917.816, 0.02, 0);            /* the push of the cylinder [N],
                and large deflections */
        n_found = 0;
        CHECK_OK(lw_model_vibrations(m, false, false, keep_frequency, NULL, &check_error));
        for (int k = 0; k < 3 && rows[i].hertz[k] > 0; k++)
            CHECK_NEAR(found[k], rows[i].hertz[k], rows[i].segments < 80 ? 2e-4*rows[i].hertz[k] : k ? 5e-4 : 5e-5, 0);
        lw_simulation_destroy(s);
        lw_model_destroy(m);
    }
}

static lw_vec3 turned(lw_quaternion q, lw_vec3 v)
{
    lw_mat3 m = lw_quaternion_matrix(q);
    return lw_m3_apply(&m, v);
}

/* Velocity of the point of a link that is at p now. */
static lw_vec3 velocity_at(const lw_frame_motion *k, lw_vec3 p)
{
    return lw_v3_add(k->velocity, lw_v3_cross(k->omega, lw_v3_sub(p, k->place)));
}


/* Posts, boom and head as the file has them; powers of the drives by the motion of the links alone. */
static lw_status keep_holes(void *context, const lw_spatial_sample *s)
{
    const lw_spatial *m = context;
    const lw_vec3 along = lw_v3(cos(LW_PI/12), 0, sin(LW_PI/12)), foot = lw_v3(0.45, 0, 0.25);
    const lw_frame_motion *post = &s->link[number_of(m, 'l', "post")], *boom = &s->link[number_of(m, 'l', "boom")];
    const lw_frame_motion *inner = &s->link[number_of(m, 'l', "telescope")],
        *roller = &s->link[number_of(m, 'l', "roller")];
    const lw_frame_motion *cradle = &s->link[number_of(m, 'l', "cradle")];
    int i = holes.n++;
    if (i > 2000)
        return LW_E_ARG;
    if (i == 0) {
        holes.first[0] = *boom, holes.first[1] = *inner;
        holes.length = 0;
    }
    lw_vec3 u = turned(boom->turn, along), y = turned(roller->turn, lw_v3(0, -1, 0));
    lw_vec3 eye_first = lw_v3_add(lw_v3(0.3, 0, 0.8), lw_v3_add(lw_v3_scale(along, 1.1), lw_v3_scale(lw_v3(-along.z, 0, along.x), -0.12)));
    lw_vec3 eye = lw_v3_add(boom->place, turned(boom->turn, lw_v3_sub(eye_first, holes.first[0].place)));
    lw_vec3 base = turned(post->turn, foot), rod = lw_v3_sub(eye, base), out = lw_v3_sub(inner->place, boom->place);
    double length = lw_v3_norm(rod), swing = 2*atan2(post->turn.z, post->turn.w)*180/LW_PI;
    if (i == 0)
        holes.length = length;
    double reach = lw_v3_dot(out, u) - lw_v3_dot(lw_v3_sub(holes.first[1].place, holes.first[0].place), along);
    double rate[5] = { post->omega.z, lw_v3_dot(lw_v3_sub(velocity_at(boom, eye), velocity_at(post, base)), rod)/length,
                       lw_v3_dot(lw_v3_sub(inner->velocity, velocity_at(boom, inner->place)), u),
                       lw_v3_dot(lw_v3_sub(roller->omega, inner->omega), u),
                           lw_v3_dot(lw_v3_sub(cradle->omega, roller->omega), y) };
    for (int k = 0; k < 5; k++)
        holes.power[i] += s->drive[k]*rate[k];
    holes.energy[i] = s->kinetic + s->potential;
    const lw_vec3 *bit = &s->tracer[0].place, *tail = &s->tracer[1].place;
    CHECK_NEAR(bit->y - tail->y, 0, 1e-9, 0);
    CHECK_NEAR(bit->z - tail->z, 0, 1e-9, 0);
    CHECK_NEAR(bit->x - tail->x, 4, 1e-9, 0);
    CHECK(fabs(swing) < 20 && reach > -1e-9 && reach < 1.5 && length - holes.length > -0.25 && length - holes.length < 0.45);
    return LW_OK;
}

/* The holes are parallel, no joint leaves its range, and the drives do the work that the energy shows. */
TEST(parallel_holes)
{
    lw_spatial *m = NULL;
    CHECK_SILENT(lw_spatial_load("examples/space/boom.json", &m, &check_error));
    simulate(m, "kinematic", 10, 2000, keep_holes);
    double most = 0, off = 0;
    for (int i = 1; i + 1 < holes.n; i++) {
        double t = 0.005*i, slope = (holes.energy[i + 1] - holes.energy[i - 1])/0.01;
        most = fmax(most, fabs(holes.power[i]));
        if (t < 3 || t > 3.02)                     /* the step along x ends there */
            off = fmax(off, fabs(slope - holes.power[i]));
    }
    CHECK(most > 1000);
    CHECK_NEAR(off/most, 0, 2e-3, 0);
    lw_spatial_destroy(m);
}
