/* test_robot.c - robots: the DELTA robot of Makkonen 1999 (upper arms 0.35 m, lower bars 0.75 m, base less plate 0.15 m)
 * against its closed form (intersections of spheres, Clavel 1991) and against values worked out independently; a Stewart
 * platform and an arm against differences, unit forces and their inverse. */
#include "mbs/analysis/held.h"

#include "base/vec3.h"
#include "mbs/equilibrium/modes.h"
#include "mbs/formulations/formulations.h"
#include "mbs/space/space_adjust.h"
#include "mbs/space/space_mobility.h"
#include "tests/planar_models.h"
#include "tests/spatial_models.h"

/* The robot of a file; one that cannot be made ends the test. */
static void make(const char *file, lw_spatial *m, lw_robot *r)
{
    lw_error e = { 0 };
    load_spatial_file(file, m);
    if (lw_robot_make(m, NULL, r, &e) != LW_OK) {
        fprintf(stderr, "%s: %s\n", file, e.text);
        exit(1);
    }
}

static lw_robot_pose pose_now(lw_robot *r)
{
    lw_robot_pose p = { .condition = NAN };
    CHECK_OK(lw_robot_measure(r, &p, &check_error));
    return p;
}

/* The pose with the tool moved to a place. */
static lw_robot_pose pose_at(lw_robot *r, lw_vec3 place)
{
    CHECK_OK(lw_robot_move(r, place, NULL, &check_error));
    return pose_now(r);
}

/* ---- the closed form of the DELTA robot ---------------------------------------------------------------- */

static const double arm = 0.35, bar = 0.75, apart = 0.15;

/* Angle of arm i below the level, for the tool at p: the knee lies outside. */
static double closed_angle(int i, lw_vec3 p)
{
    double c = cos(2*LW_PI*i/3), s = sin(2*LW_PI*i/3);
    double x = c*p.x + s*p.y - apart, y = c*p.y - s*p.x, z = p.z;           /* tool from the arm's axis, x outwards */
    double reach = (x*x + y*y + z*z + arm*arm - bar*bar)/(2*arm);           /* x cos q - z sin q */
    return atan2(-z, x) - acos(reach/sqrt(x*x + z*z));                      /* knee outside: the smaller angle */
}

/* A place that every arm reaches, 2 % before the end of its reach: beyond, differences of the closed form are not exact enough. */
static lw_vec3 random_place(lw_rng *rng)
{
    for (;;) {
        lw_vec3 p = lw_v3(lw_rng_range(rng, -0.4, 0.4), lw_rng_range(rng, -0.4, 0.4), lw_rng_range(rng, -0.85, -0.55));
        double sum = 0;
        for (int i = 0; i < 3; i++)
            sum += closed_angle(i, lw_v3_scale(p, 1.02));
        if (isfinite(sum))
            return p;
    }
}

/* The model counts from the posture of its file, the tool at (0, 0, -0.65). */
static const lw_vec3 home = { 0, 0, -0.65 };

TEST(delta_poses)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    make("examples/space/delta.json", &m, &r);
    CHECK_NEAR(closed_angle(0, home)*180/LW_PI, 13.60812855, 5e-9, 0);
    CHECK_NEAR(closed_angle(0, lw_v3(0.2, 0, -0.65))*180/LW_PI, -6.282352804, 5e-10, 0);
    CHECK_NEAR(closed_angle(1, lw_v3(0.2, 0, -0.65))*180/LW_PI, 29.88751143, 5e-9, 0);
    lw_rng rng = check_rng(0);
    for (int n = 0; n < 200; n++) {
        lw_vec3 at = n == 0 ? lw_v3(0.2, 0, -0.65) : random_place(&rng);
        p = pose_at(&r, at);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(p.place, at)), 0, 1e-14, 0);
        double level = lw_v3_norm(lw_quaternion_vector(p.turn));
        CHECK_NEAR(level, 0, 1e-14, 0);                                  /* the plate does not turn */
        double angle[3];
        for (int i = 0; i < 3; i++) {
            CHECK_NEAR(p.drive[i], closed_angle(i, at) - closed_angle(i, home), 1e-14, 0);
            angle[i] = p.drive[i];
        }
        for (int i = 0; i < 3; i++) {                                    /* J against differences of the closed form */
            double h = 1e-6, sum[3] = { 0 };
            for (int k = 0; k < 3; k++) {
                double d[] = { h*(k == 0), h*(k == 1), h*(k == 2) };
                double rate = (closed_angle(i, lw_v3(at.x + d[0], at.y + d[1], at.z + d[2]))
                               - closed_angle(i, lw_v3(at.x - d[0], at.y - d[1], at.z - d[2])))/(2*h);
                for (int j = 0; j < 3; j++)
                    sum[j] += rate*p.jacobian[k][j];
            }
            for (int j = 0; j < 3; j++)
                CHECK_NEAR(sum[j], i == j, 1e-7, 0);
        }
        if (n % 20 == 0) {                                               /* forwards again */
            CHECK_OK(lw_robot_move(&r, home, NULL, &check_error));
            CHECK_OK(lw_robot_drive(&r, angle, &check_error));
            p = pose_now(&r);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(p.place, at)), 0, 1e-14, 0);
        }
    }
}

/* Singular values of J and condition numbers, worked out independently from the closed form. */
TEST(delta_jacobian)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    make("examples/space/delta.json", &m, &r);
    p = pose_at(&r, home);
    CHECK_NEAR(p.singular[0], 0.388889893, 5e-10, 0);
    CHECK_NEAR(p.singular[1], 0.388889893, 5e-10, 0);
    CHECK_NEAR(p.singular[2], 0.237454472, 5e-10, 0);
    CHECK_NEAR(p.condition, 1.637745080, 5e-10, 0);
    p = pose_at(&r, lw_v3(0.2, 0, -0.65));
    CHECK_NEAR(p.singular[0], 0.433671173, 5e-10, 0);
    CHECK_NEAR(p.singular[1], 0.376908018, 5e-10, 0);
    CHECK_NEAR(p.singular[2], 0.236663863, 5e-10, 0);
    CHECK_NEAR(p.condition, 1.832435114, 5e-10, 0);
    double least = INFINITY, at = 0;                                     /* the best height on the axis */
    for (double z = -0.50; z > -0.62; z -= 0.002) {
        p = pose_at(&r, lw_v3(0, 0, z));
        if (p.condition < least)
            least = p.condition, at = z;
    }
    CHECK_NEAR(least, 1.581, 5e-4, 0);
    CHECK_NEAR(at, -0.56, 5e-3, 0);
    static const double far[][2] = { { 0.45, 2.72 }, { 0.5, 3.20 } };    /* towards arm 1 to "almost three" (Makkonen 1999) */
    for (int i = 0; i < 2; i++) {
        p = pose_at(&r, lw_v3(far[i][0], 0, -0.65));
        CHECK_NEAR(p.condition, far[i][1], 5e-3, 0);
    }
    CHECK_NEAR(p.singular[0], 0.63, 5e-3, 0);                            /* from 0.389: the source says that it hardly varies */
    CHECK_NEAR(p.singular[2], 0.198, 5e-4, 0);
}

/* The lowest place of the tool, and the area that it reaches at z = -0.65 where only the links limit it. */
TEST(delta_workspace)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    double far, area = 0, first = 0, before = 0;
    enum { RAYS = 90 };
    make("examples/space/delta.json", &m, &r);
    r.free = true;
    CHECK_OK(lw_robot_move(&r, home, NULL, &check_error));
    CHECK_OK(lw_robot_reach(&r, lw_v3(0, 0, -1), 2, &far, &check_error));
    p = pose_now(&r);
    CHECK_NEAR(p.place.z, -1.0897247, 2e-7, 0);
    for (int i = 0; i <= RAYS; i++) {
        double a = 2*LW_PI*i/RAYS;
        lw_robot_reset(&r);
        CHECK_OK(lw_robot_reach(&r, lw_v3(cos(a), sin(a), 0), 2, &far, &check_error));
        double least = 0.6, most = 0.8, middle;                /* the closed form along the same ray */
        while (most - least > 1e-9) {
            middle = 0.5*(least + most);
            lw_vec3 at = lw_v3(middle*cos(a), middle*sin(a), -0.65);
            bool closes = isfinite(closed_angle(0, at)) && isfinite(closed_angle(1, at)) && isfinite(closed_angle(2, at));
            *(closes ? &least : &most) = middle;
        }
        CHECK_NEAR(far, least, 1e-6, 0);
        area += i ? 0.5*before*far*sin(2*LW_PI/RAYS) : 0;
        first = i ? first : far;
        before = far;
    }
    CHECK_NEAR(before, first, 1e-6, 0);
    CHECK_NEAR(area, 1.511, 0.0015, 0);                       /* a polygon of 90 corners is 0.001 smaller */
}

/* ---- postures in which the drives lose the tool ------------------------------------------------------------ */

typedef struct proportions { double base, plate, arm, bar, z, stop, cone; } proportions;     /* stop of arms and cone of knees [rad]; 0: none */

/* Place of the knee of arm i, in closed form as above; NAN out of reach. */
static lw_vec3 knee_of(const proportions *d, int i, lw_vec3 p)
{
    double c = cos(2*LW_PI*i/3), s = sin(2*LW_PI*i/3), x = c*p.x + s*p.y - (d->base - d->plate), y = c*p.y - s*p.x;
    double reach = (x*x + y*y + p.z*p.z + d->arm*d->arm - d->bar*d->bar)/(2*d->arm);
    double q = atan2(-p.z, x) - acos(reach/hypot(x, p.z)), far = d->base + d->arm*cos(q);
    return lw_v3(c*far, s*far, -d->arm*sin(q));
}

/* Volume of the three bars, of one side of the parallelograms: the tool is lost where they lie in one plane. */
static double bars_apart(const proportions *d, lw_vec3 p)
{
    lw_vec3 u[3];
    for (int i = 0; i < 3; i++)
        u[i] = lw_v3_sub(lw_v3_add(p, lw_v3(d->plate*cos(2*LW_PI*i/3), d->plate*sin(2*LW_PI*i/3), 0)), knee_of(d, i, p));
    return lw_v3_dot(u[0], lw_v3_cross(u[1], u[2]));
}

/* The same of the axes about which the parallelograms let the plate turn: where they lie in one plane, it tilts. */
static double plate_held(const proportions *d, lw_vec3 p)
{
    lw_vec3 u[3];
    for (int i = 0; i < 3; i++) {
        double c = cos(2*LW_PI*i/3), s = sin(2*LW_PI*i/3);
        lw_vec3 along = lw_v3_sub(lw_v3_add(p, lw_v3(d->plate*c, d->plate*s, 0)), knee_of(d, i, p));
        u[i] = lw_v3_cross(lw_v3_scale(along, 1/d->bar), lw_v3(-s, c, 0));
    }
    return fabs(lw_v3_dot(u[0], lw_v3_cross(u[1], u[2])));
}

static bool make_delta(const proportions *d, lw_spatial *m, lw_robot *r)
{
    static char text[8192];
    size_t n = 0, size = sizeof text;
    lw_error e = { 0 };
    n += (size_t)snprintf(text, size, "{'linkwright': 1, 'links': ['ground', {'name': 'plate'}");
    for (int i = 0; i < 3; i++)
        n += (size_t)snprintf(text + n, size - n, ", {'name': 'a%d'}, {'name': 'l%d'}, {'name': 'r%d'}", i, i, i);
    n += (size_t)snprintf(text + n, size - n, "], 'joints': [");
    for (int i = 0; i < 3; i++) {
        double c = cos(2*LW_PI*i/3), s = sin(2*LW_PI*i/3);
        lw_vec3 knee = knee_of(d, i, lw_v3(0, 0, d->z));
        n += (size_t)snprintf(text + n, size - n, "%s{'name': 'M%d', 'links': ['ground', 'a%d'], 'at': [%.17g, %.17g, 0], 'axis': [%.17g, %.17g, 0]",
                              i ? ", " : "", i, i, d->base*c, d->base*s, -s, c);
        n += d->stop > 0 ? (size_t)snprintf(text + n, size - n, ", 'stop': {'least': %.17g, 'greatest': %.17g}}", -d->stop, d->stop)
                         : (size_t)snprintf(text + n, size - n, "}");
        lw_vec3 along = lw_v3_sub(lw_v3(d->plate*c, d->plate*s, d->z), knee);
        for (int side = 0; side < 2; side++) {
            double x = side ? 0.05*s : -0.05*s, y = side ? -0.05*c : 0.05*c;
            n += (size_t)snprintf(text + n, size - n, ", {'name': 'E%d%d', 'kind': 'b', 'links': ['a%d', '%c%d'], 'at': [%.17g, %.17g, %.17g], 'cone': {'axis': "
                                  "[%.17g, %.17g, %.17g], 'angle': %.17g}}, {'name': 'P%d%d', 'kind': 'b', 'links': ['plate', '%c%d'], 'at': [%.17g, %.17g, %.17g]}", i, side, i,
                                  side ? 'r' : 'l', i, knee.x + x, knee.y + y, knee.z, along.x, along.y, along.z, d->cone > 0 ? d->cone : LW_PI, i, side, side ? 'r' : 'l', i, d->plate*c + x, d->plate*s + y, d->z);
        }
    }
    n += (size_t)snprintf(text + n, size - n, "], 'drives': [{'joint': 'M0'}, {'joint': 'M1'}, {'joint': 'M2'}], 'tracers': [{'name': 'T', "
                          "'link': 'plate', 'at': [0, 0, %.17g]}]}", d->z);
    return lw_spatial_read(json_quotes(text), n, "delta", m, &e) == LW_OK && lw_robot_make(m, NULL, r, &e) == LW_OK;
}

/* A way ends where the three bars lie in one plane, also if the robot could be assembled beyond: DELTA robots of any proportions. */
TEST(tools_that_their_drives_lose)
{
    lw_rng rng = check_rng(2);
    int lost = 0, made = 0;
    while (made < 8) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        proportions d = { lw_rng_range(&rng, 0.1, 0.5), lw_rng_range(&rng, 0.05, 0.3), lw_rng_range(&rng, 0.2, 0.5), lw_rng_range(&rng, 0.4, 0.9),
                          lw_rng_range(&rng, -0.9, -0.2), 0, 0 };
        double first = bars_apart(&d, lw_v3(0, 0, d.z));
        if (!(fabs(first) > 0.02))
            continue;
        made++;
        bool good = make_delta(&d, &m, &r);
        CHECK(good);
        for (int ray = 0; good && ray < 5; ray++) {
            double a = 1.2*ray + made, far, least = 0, step = 2e-4;
            lw_robot_reset(&r);
            CHECK_OK(lw_robot_reach(&r, lw_v3(cos(a), sin(a), 0), 3, &far, &check_error));
            while (bars_apart(&d, lw_v3((least + step)*cos(a), (least + step)*sin(a), d.z))*first > 0)
                least += step;
            if (plate_held(&d, lw_v3(least*cos(a), least*sin(a), d.z)) < 0.02)
                continue;
            CHECK_NEAR(far, least + step/2, step, 0);
            lost += isfinite(bars_apart(&d, lw_v3((least + step)*cos(a), (least + step)*sin(a), d.z)));
        }
    }
    CHECK(lost > 5);
}

/* How far a way or a tilt (azimuth, elevation) goes from the posture [0, 0, z], to where the determinant of the bars' lines of force is 0: roots
 * by Brent's method of the closed forms.  On mirror planes of a DELTA and of a Stewart platform solving for the drives loses many digits there. */
TEST(singular_postures_are_met_to_their_digits)
{
    static const struct { const char *file; double z; bool tilts; double azimuth, elevation, far; } known[] = {
        { "examples/space/delta.json", -0.65, false, 0, -16.1276202, 0.58529144644 }, { "examples/space/delta.json", -0.65, false, 240, -16.1276202, 0.58529144644 },
        { "examples/space/delta.json", -0.65, false, 0, 3.18473854, 0.69043570216 }, { "examples/space/delta.json", -0.65, false, 10, 9.59406823, 0.72956538573 },
        { "examples/space/stewart.json", 0.8, false, 0, -30, 1.6 }, { "examples/space/stewart.json", 0.8, false, 200, -46.2382573, 1.10769229 },
        { "examples/space/stewart.json", 0.8, true, 0, 0, 125.0429911748 }, { "examples/space/stewart.json", 0.8, true, 20, 0, 84.26180409971 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        double a = known[i].azimuth*LW_PI/180, b = known[i].elevation*LW_PI/180, far;
        make(known[i].file, &m, &r);
        CHECK_OK(lw_robot_move(&r, lw_v3(0, 0, known[i].z), NULL, &check_error));
        if (known[i].tilts)
            CHECK_OK(lw_robot_tilt(&r, lw_v3(-sin(a), cos(a), 0), 3, &far, &check_error));
        else
            CHECK_OK(lw_robot_reach(&r, lw_v3(cos(a)*cos(b), sin(a)*cos(b), sin(b)), 3, &far, &check_error));
        CHECK_NEAR(known[i].tilts ? far*180/LW_PI : far, known[i].far, known[i].tilts ? 2e-6 : 2e-8, 0);     /* the last step is shorter than 1e-8 of the size */
    }
}

/* Does a stop of an arm or the cone of a knee end the way at p?  Turns count from the posture of the file, the cone's axis lies along the bar there. */
static bool stopped_at(const proportions *d, lw_vec3 p)
{
    for (int i = 0; i < 3; i++) {
        lw_vec3 c = lw_v3(cos(2*LW_PI*i/3), sin(2*LW_PI*i/3), 0), axis = lw_v3(-c.y, c.x, 0), along[2], upper[2];
        for (int k = 0; k < 2; k++) {
            lw_vec3 at = k ? p : lw_v3(0, 0, d->z), knee = knee_of(d, i, at);
            along[k] = lw_v3_sub(lw_v3_add(at, lw_v3_scale(c, d->plate)), knee);
            upper[k] = lw_v3_sub(knee, lw_v3_scale(c, d->base));
        }
        double turn = atan2(lw_v3_dot(axis, lw_v3_cross(upper[0], upper[1])), lw_v3_dot(upper[0], upper[1]));
        lw_quaternion by = lw_quaternion_of_vector(lw_v3_scale(axis, turn));
        lw_mat3 m = lw_quaternion_matrix(by);
        double tilt = acos(lw_v3_dot(lw_m3_apply(&m, along[0]), along[1])/lw_v3_dot(along[1], along[1]));
        if (!(d->stop > 0 && fabs(turn) <= d->stop) && !(d->cone > 0 && tilt <= d->cone))
            return true;
    }
    return false;
}

/* Ends of ways at the stops of arms, or the cones of knees, in closed form. */
TEST(stops_and_cones_of_a_delta)
{
    for (int by_cone = 0; by_cone < 2; by_cone++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        proportions d = { 0.4, 0.25, 0.35, 0.75, -0.65, by_cone ? 0 : 0.4, by_cone ? 0.5 : 0 };
        bool good = make_delta(&d, &m, &r);
        CHECK(good);
        for (int ray = 0; good && ray < 7; ray++) {
            double a = 0.9*ray, far, least = 0, most = 0.6;
            lw_robot_reset(&r);
            CHECK_FAILS(lw_robot_reach(&r, lw_v3(cos(a), sin(a), 0), 3, &far, &check_error), LW_OK,
                        by_cone ? "the cone of joint \"E" : "the stop of joint \"M");
            while (most - least > 1e-10) {
                double middle = 0.5*(least + most);
                *(stopped_at(&d, lw_v3(middle*cos(a), middle*sin(a), d.z)) ? &most : &least) = middle;
            }
            CHECK_NEAR(far, least, 5e-8, 0);
        }
    }
}

/* A stop beyond half a turn: the drive at 190 degrees of -10 to 200 is free, and is stopped at 200. */
TEST(a_stop_beyond_half_a_turn)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a'}, {'name': 'b'}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
        "'at': [0, 0, 0], 'axis': [0, 0, 1], 'stop': {'least': -0.17453292519943295, 'greatest': 3.4906585039886591}}, {'name': 'E', 'links': ['a', 'b'], "
        "'at': [1, 0, 0], 'axis': [0, 0, 1]}], 'drives': [{'joint': 'A'}, {'joint': 'E'}], 'tracers': [{'name': 'T', 'link': 'b', 'at': [1, 0.8, 0]}]}";
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    const double at = 190*LW_PI/180;
    read_spatial(text, "arm", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    CHECK_OK(lw_robot_drive(&r, (const double[]){ at, 0 }, &check_error));
    p = pose_now(&r);
    CHECK_OK(lw_robot_move(&r, lw_v3(p.place.x, p.place.y + 0.01, 0), NULL, &check_error));
    CHECK_FAILS(lw_robot_move(&r, lw_v3(p.place.x, p.place.y - 1, 0), NULL, &check_error), LW_OPEN, "the stop of joint \"A\"");
    p = pose_now(&r);
    CHECK_NEAR(p.drive[0], 200*LW_PI/180, 1e-6, 0);
}

/* A five-bar whose rods come into one line 0.22 along this way, where the next posture of the same cranks is near. */
TEST(a_five_bar_is_stretched)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', 'a', 'b', 'c', 'd'], 'joints': [{'name': 'A', 'kind': 'r', 'links': ['ground', 'a'], "
        "'at': [-0.3323, 0]}, {'name': 'B', 'kind': 'r', 'links': ['ground', 'b'], 'at': [0.3662, -0.0158]}, {'name': 'C', 'kind': 'r', 'links': ['a', "
        "'c'], 'at': [-0.371, 0.4874]}, {'name': 'D', 'kind': 'r', 'links': ['b', 'd'], 'at': [0.6394, 0.4602]}, {'name': 'P', 'kind': 'r', 'links': "
        "['c', 'd'], 'at': [-0.3779, 0.58]}], 'inputs': [{'joint': 'A'}, {'joint': 'B'}], 'tracers': [{'name': 'P', 'link': 'c', 'at': [-0.3779, 0.58]}]}";
    const lw_vec3 axis[] = { { -0.3323, 0, 0 }, { 0.3662, -0.0158, 0 } }, at = { -0.3779, 0.58, 0 }, way = { cos(-LW_PI/6), sin(-LW_PI/6), 0 };
    const lw_vec3 knee[] = { { -0.371, 0.4874, 0 }, { 0.6394, 0.4602, 0 } };
    OWN(lw_model) p = { 0 };
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    double far, least = 0, first = 0;
    read_planar(text, "five-bar", &p);
    CHECK_OK(lw_spatial_of_planar(&p, &m, &check_error));
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    CHECK_OK(lw_robot_reach(&r, way, 2, &far, &check_error));
    for (double step = 1e-5; least < 1; least += step) {             /* the rods by intersecting circles */
        lw_vec3 place = lw_v3_add(at, lw_v3_scale(way, least)), rod[2];
        for (int i = 0; i < 2; i++) {
            double crank = lw_v3_norm(lw_v3_sub(knee[i], axis[i])), length = lw_v3_norm(lw_v3_sub(at, knee[i]));
            lw_vec3 d = lw_v3_sub(place, axis[i]), first_d = lw_v3_sub(at, axis[i]);
            double c = lw_v3_norm(d), along = (crank*crank - length*length + c*c)/(2*c), across = sqrt(crank*crank - along*along);
            double side = lw_v3_cross(first_d, lw_v3_sub(knee[i], axis[i])).z > 0 ? 1 : -1;
            rod[i] = lw_v3_sub(d, lw_v3_add(lw_v3_scale(d, along/c), lw_v3_scale(lw_v3_cross(lw_v3(0, 0, side), d), across/c)));
        }
        double turn = lw_v3_cross(rod[0], rod[1]).z;
        first = least > 0 ? first : turn;
        if (!(turn*first > 0))
            break;
    }
    CHECK_NEAR(least, 0.221, 5e-4, 0);
    CHECK_NEAR(far, least, 2e-5, 0);
}

/* Five-bars of random proportions and assembly: each ray ends where a circle of a knee is left, or where the rods come into one line. */
typedef struct five_bar { double axis[2], crank[2], rod[2], side[2]; } five_bar;

static bool knee_at(const five_bar *g, int i, lw_vec3 p, lw_vec3 *knee)
{
    lw_vec3 d = lw_v3(p.x - g->axis[i], p.y, 0);
    double far = lw_v3_norm(d), along = (far*far + g->crank[i]*g->crank[i] - g->rod[i]*g->rod[i])/(2*far), across = g->crank[i]*g->crank[i] - along*along;
    if (!(across >= 0))
        return false;
    across = g->side[i]*sqrt(across);
    *knee = lw_v3(g->axis[i] + (along*d.x - across*d.y)/far, (along*d.y + across*d.x)/far, 0);
    return true;
}

/* Cross product of the rods; NAN: it does not close. */
static double rods_apart(const five_bar *g, lw_vec3 p)
{
    lw_vec3 knee[2];
    return knee_at(g, 0, p, &knee[0]) && knee_at(g, 1, p, &knee[1]) ? lw_v3_cross(lw_v3_sub(p, knee[0]), lw_v3_sub(p, knee[1])).z : NAN;
}

static void check_five_bars(lw_rng rng)
{
    for (int n = 0; n < 12;) {
        five_bar g;
        lw_vec3 knee[2], at = lw_v3(lw_rng_range(&rng, -0.2, 0.2), lw_rng_range(&rng, 0.1, 0.5), 0);
        for (int i = 0; i < 2; i++) {
            g.axis[i] = (i ? 1 : -1)*lw_rng_range(&rng, 0.05, 0.2);
            g.crank[i] = lw_rng_range(&rng, 0.15, 0.4);
            g.rod[i] = lw_rng_range(&rng, 0.15, 0.4);
            g.side[i] = lw_rng_range(&rng, -1, 1) > 0 ? 1 : -1;
        }
        double begin = rods_apart(&g, at);
        if (!(fabs(begin) > 3e-3) || !knee_at(&g, 0, at, &knee[0]) || !knee_at(&g, 1, at, &knee[1]))
            continue;
        n++;
        char text[1200];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'a', 'b', 'c', 'd'], 'joints': ["
            "{'name': 'A', 'kind': 'r', 'links': ['ground', 'a'], 'at': [%.17g, 0]}, {'name': 'B', 'kind': 'r', 'links': ['ground', "
            "'b'], 'at': [%.17g, 0]}, {'name': 'C', 'kind': 'r', 'links': ['a', 'c'], 'at': [%.17g, %.17g]}, {'name': 'D', "
            "'kind': 'r', 'links': ['b', 'd'], 'at': [%.17g, %.17g]}, {'name': 'P', 'kind': 'r', 'links': ['c', 'd'], 'at': "
            "[%.17g, %.17g]}], 'inputs': [{'joint': 'A'}, {'joint': 'B'}], 'tracers': [{'name': 'P', 'link': 'c', 'at': [%.17g, %.17g]}]}",
            g.axis[0], g.axis[1], knee[0].x, knee[0].y, knee[1].x, knee[1].y, at.x, at.y, at.x, at.y);
        OWN(lw_model) p = { 0 };
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        read_planar(text, "five-bar", &p);
        CHECK_OK(lw_spatial_of_planar(&p, &m, &check_error));
        CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
        for (int i = 0; i < 12; i++) {                     /* one after the other: none begins with what the end of another left */
            lw_vec3 way = lw_v3(cos(LW_PI*i/6), sin(LW_PI*i/6), 0);
            double far, least = 0, most, step = 2e-4;
            while (rods_apart(&g, lw_v3_add(at, lw_v3_scale(way, least + step)))*begin > 0)
                least += step;
            for (most = least + step; most - least > 1e-10;) {
                double middle = 0.5*(least + most);
                *(rods_apart(&g, lw_v3_add(at, lw_v3_scale(way, middle)))*begin > 0 ? &least : &most) = middle;
            }
            lw_robot_reset(&r);
            CHECK_OK(lw_robot_reach(&r, way, 3, &far, &check_error));
            CHECK_NEAR(far, least, 1e-6, 0);       /* the Jacobian is not known nearer to a posture in which the drives lose the tool */
        }
    }
}

TEST(five_bars_in_closed_form)
{
    lw_rng near_an_axis;                     /* the tool of the last one passes an axis; just behind it the rods come into one line */
    lw_rng_seed(&near_an_axis, 1, 0);
    check_five_bars(near_an_axis);
    check_five_bars(check_rng(0));
}

/* Unit forces (eq. 9-15): drive torques that hold a force on the tool are J^T of it.  The second opinion is the multiplier
 * of each drive's row. */
static void unit_forces(const char *file)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    make(file, &m, &r);
    p = pose_now(&r);
    lw_space_follow *f = &r.follow;
    int n_v = r.space.n_v, body = r.space.tracer[r.tool].body;
    double *force = calloc((size_t)n_v, sizeof *force), *l = calloc((size_t)f->z.n_row, sizeof *l);
    for (int k = 0; k < 3; k++) {
        lw_vec3 unit = lw_v3(k == 0, k == 1, k == 2), arm_now;
        const lw_space_frame *frame = &f->z.frame[body + 1];
        arm_now = lw_m3_apply(&frame->turn, r.space.tracer[r.tool].arm);
        lw_vec3 moment = lw_m3_unapply(&frame->turn, lw_v3_cross(arm_now, unit));
        double size = r.space.unit, of[] = { size*unit.x, size*unit.y, size*unit.z, moment.x, moment.y, moment.z };
        memset(force, 0, (size_t)n_v*sizeof *force);
        memcpy(force + 6*body, of, sizeof of);
        lw_space_rows_carry(&f->z, force, l);
        for (int i = 0; i < r.n_drive; i++) {
            lw_spatial_measure drive = m.n_drive ? m.drive[i] : m.input[i].measure;
            double torque = l[r.space.n_row + f->n_idle + i]/lw_space_scale(&r.space, drive);
            CHECK_NEAR(torque, p.jacobian[k][i], 1e-12, 0);
        }
    }
    free(force);
    free(l);
}

TEST(forces_of_delta) { unit_forces("examples/space/delta.json"); }
TEST(forces_of_stewart) { unit_forces("examples/space/stewart.json"); }

/* J of any robot against differences of its forward kinematics; its inverse kinematics come back. */
static void against_differences(const char *file, double stroke)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p, plus, minus;
    double value[LW_ROBOT_DRIVES], h = 1e-5;
    lw_rng rng = check_rng(0);
    make(file, &m, &r);
    lw_space_follow_values(&r.follow, value);
    for (int i = 0; i < r.n_drive; i++)
        value[i] += lw_rng_range(&rng, -stroke, stroke);
    if (!m.n_drive)
        for (int i = 0; i < r.n_drive; i++)
            value[i] += lw_spatial_offset(&m.input[i]);
    CHECK_OK(lw_robot_drive(&r, value, &check_error));
    p = pose_now(&r);
    for (int i = 0; i < r.n_drive; i++) {
        value[i] += h;
        CHECK_OK(lw_robot_drive(&r, value, &check_error));
        CHECK_OK(lw_robot_measure(&r, &plus, &check_error));
        value[i] -= 2*h;
        CHECK_OK(lw_robot_drive(&r, value, &check_error));
        CHECK_OK(lw_robot_measure(&r, &minus, &check_error));
        value[i] += h;
        lw_vec3 v = lw_v3_scale(lw_v3_sub(plus.place, minus.place), 1/(2*h));
        lw_vec3 w = lw_v3_scale(lw_quaternion_vector(lw_quaternion_times(plus.turn, lw_quaternion_inverse(minus.turn))),
                                1/(2*h));
        double of[] = { v.x, v.y, v.z, w.x, w.y, w.z };
        for (int k = 0; k < 6; k++)
            CHECK_NEAR(p.jacobian[k][i], of[k], 1e-8*fmax(1, r.space.unit), 1e-7);
    }
    lw_robot_reset(&r);                                       /* there by the tool's pose */
    CHECK_OK(lw_robot_move(&r, p.place, &p.turn, &check_error));
    CHECK_OK(lw_robot_measure(&r, &plus, &check_error));
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(plus.place, p.place)), 0, 1e-10*r.space.unit, 0);
    if (r.turns)
        CHECK_NEAR(lw_v3_norm(lw_quaternion_vector(lw_quaternion_times(plus.turn, lw_quaternion_inverse(p.turn)))), 0,
                   1e-10, 0);
}

TEST(stewart) { against_differences("examples/space/stewart.json", 0.03); }
TEST(delta) { against_differences("examples/space/delta.json", 0.2); }

TEST(bad_robots)
{
    OWN(lw_spatial) m = { 0 };
    lw_robot r;
    load_spatial("delta", &m);
    CHECK_FAILS(lw_robot_make(&m, "tol", &r, &check_error), LW_E_ARG, "tool");
    lw_spatial_free(&m);
    load_spatial("top", &m);
    CHECK_INT(lw_robot_make(&m, NULL, &r, &check_error), LW_E_ARG);
}

/* ---- planar robots --------------------------------------------------------------------------------------- */

static bool make_planar(const char *file, lw_spatial *m, lw_robot *r)
{
    lw_error e = { 0 };
    OWN(lw_model) p = { 0 };
    load_planar(file, &p);
    lw_status s = lw_spatial_of_planar(&p, m, &e);
    return s == LW_OK && lw_robot_make(m, NULL, r, &e) == LW_OK;
}

/* 3-RRR, arms 0.25, rods 0.3, radii 0.4 and 0.1: the angle of an arm in closed form; a rod keeps its length, so the velocities of
 * its ends have the same part along it.  Straight down from the middle the first leg is stretched at 0.25. */
TEST(three_rrr)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    lw_rng rng = check_rng(1);
    bool good = make_planar("examples/3-rrr.json", &m, &r);
    CHECK(good);
    for (int trial = 0; good && trial < 20; trial++) {
        lw_vec3 at = lw_v3(lw_rng_range(&rng, -0.1, 0.1), lw_rng_range(&rng, -0.1, 0.1), 0);
        p = pose_at(&r, at);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(p.place, at)), 0, 1e-8, 0);
        CHECK_NEAR(p.turn.z, 0, 1e-8, 0);
        for (int i = 0; i < 3; i++) {
            double a = LW_PI/2 + 2*LW_PI*i/3;
            lw_vec3 c = lw_v3(0.1*cos(a), 0.1*sin(a), 0), base = lw_v3(0.4*cos(a), 0.4*sin(a), 0);
            lw_vec3 d = lw_v3_sub(lw_v3_add(p.place, c), base);
            double far = lw_v3_norm(d), angle = atan2(d.y, d.x) + acos((0.25*0.25 + far*far - 0.3*0.3)/(2*0.25*far));
            CHECK_NEAR(remainder(p.drive[i] - angle, 2*LW_PI), 0, 1e-7, 0);
            lw_vec3 crank = lw_v3(0.25*cos(angle), 0.25*sin(angle), 0), rod = lw_v3_sub(d, crank);
            for (int j = 0; j < 3; j++) {
                lw_vec3 v = lw_v3_add(lw_v3(p.jacobian[0][j], p.jacobian[1][j], 0), lw_v3_cross(lw_v3(0, 0, p.jacobian[5][j]), c));
                double knee = i == j ? lw_v3_dot(rod, lw_v3_cross(lw_v3(0, 0, 1), crank)) : 0;
                CHECK_NEAR(lw_v3_dot(rod, v), knee, 1e-8, 0);
            }
        }
    }
    double far;
    CHECK_OK(lw_robot_move(&r, lw_v3(0, 0, 0), NULL, &check_error));
    CHECK_OK(lw_robot_reach(&r, lw_v3(0, -1, 0), 1, &far, &check_error));
    CHECK_NEAR(far, 0.25, 0, 1e-6);
}

/* A SCARA arm keeps the direction of its hand; its Jacobian is made of the arms from the joints to the tool. */
TEST(scara)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    bool good = make_planar("examples/scara.json", &m, &r);
    CHECK(good);
    if (!good)
        return;
    p = pose_at(&r, lw_v3(0.2, 0.35, 0));
    CHECK_NEAR(2*atan2(p.turn.z, p.turn.w), 1, 1e-8, 0);
    /* an input is the angle of the first link from x, then of the next against the one before */
    double drawn[3] = { 0.3, 1.2, -0.5 }, length[3] = { 0.4, 0.3, 0.1 }, turn = 0;
    lw_vec3 joint[4] = { { 0, 0, 0 } };
    lw_robot_pose begin;
    lw_robot_reset(&r);
    CHECK_OK(lw_robot_measure(&r, &begin, &check_error));
    for (int k = 0; k < 3; k++) {
        turn += drawn[k] + p.drive[k] - begin.drive[k];
        joint[k + 1] = lw_v3_add(joint[k], lw_v3(length[k]*cos(turn), length[k]*sin(turn), 0));
    }
    CHECK_NEAR(turn, 1, 1e-7, 0);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(joint[3], lw_v3(0.2, 0.35, 0))), 0, 1e-7, 0);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(p.jacobian[0][k], -(joint[3].y - joint[k].y), 1e-7, 0);
        CHECK_NEAR(p.jacobian[1][k], joint[3].x - joint[k].x, 1e-7, 0);
        CHECK_NEAR(p.jacobian[5][k], 1, 1e-12, 0);
    }
}

/* Pins in slots become a slide and a pin: a Scotch yoke of any crank moves as the cosine of its angle. */
TEST(slots_in_space)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    bool good = make_planar("examples/gallery/scotch-yoke.json", &m, &r);
    CHECK(good);
    if (!good)
        return;
    p = pose_now(&r);
    double first = p.place.x, from = p.drive[0], at[3];
    for (int k = 0; k < 3; k++) {
        double value = from + 0.4*(k + 1);
        CHECK_OK(lw_robot_drive(&r, &value, &check_error));
        p = pose_now(&r);
        at[k] = p.place.x - first;
    }
    /* x = c cos(from + s) + d: the second differences of equal steps are in the ratio of the cosines */
    double one = at[1] - 2*at[0], two = at[2] - 2*at[1] + at[0];
    CHECK_NEAR(one*cos(from + 0.8) - two*cos(from + 0.4), 0, 1e-9*m.units.metre + 1e-9*fabs(one), 0);
    CHECK(fabs(one) > 1e-6);
}

/* ---- the lowest eigenfrequency over the workspace ------------------------------------------------------- */

static double lowest(lw_held *h, lw_robot *r, double radius, double angle)
{
    double f = NAN;
    lw_robot_reset(r);
    CHECK_OK(lw_robot_move(r, lw_v3(radius*cos(angle), radius*sin(angle), -0.65), NULL, &check_error));
    CHECK_SILENT(lw_held_frequency(h, r, &f, &check_error));
    return f;
}

/* The DELTA robot with elastic arms and bars of 4 elements, towards an arm: an independent model of the same declared data.  What it
 * does not state is read as: shear factor of the box A/(2 h t) in both directions, of the tube 2, the plate without inertia. */
TEST(frequencies_over_the_workspace)
{
    static const double at[] = { 0, 0.2, 0.3, 0.4, 0.5, 0.55 }, hertz[] = { 128.33, 120.31, 106.78, 87.64, 63.52, 49.24 };
    lw_spatial m;
    lw_robot r;
    lw_held h;
    lw_robot_pose pose;
    lw_error e = { 0 };
    make("examples/space/delta-elastic.json", &m, &r);
    for (int i = 0; i < m.n_link; i++) {
        lw_section *q = &m.elastic[i].section;
        q->zeta_y = q->zeta_z = q->round ? 2 : q->area/2e-4;
        for (int k = 0; k < 3 && !m.elastic[i].given; k++)
            m.body[i].inertia[k] *= 1e-3;
    }
    CHECK_INT(lw_held_make(&m, &h, &e), LW_OK);
    for (int i = 0; i < 6; i++) {
        double f = lowest(&h, &r, at[i], 0);
        CHECK_NEAR(f, hertz[i], 0, 2.5e-3);
        CHECK_NEAR(lowest(&h, &r, at[i], 2*LW_PI/3), f, 0, 1e-9);
        CHECK_NEAR(lowest(&h, &r, at[i], -2*LW_PI/3), f, 0, 1e-9);
    }
    CHECK_NEAR(lowest(&h, &r, 0.35, 0.3), lowest(&h, &r, 0.35, -0.3), 0, 1e-9);           /* the arm's plane of symmetry */
    /* the same posture by the start of a run, whose motions put the drives there */
    double f = lowest(&h, &r, 0.35, 0.7);
    CHECK_INT(lw_robot_measure(&r, &pose, &e), LW_OK);
    lw_held_free(&h);
    for (int i = 0; i < m.n_input; i++) {
        char motion[40];
        snprintf(motion, sizeof motion, "%.17g", pose.drive[i]);
        CHECK_INT(lw_spatial_set_motion(&m, i, motion, &e), LW_OK);
    }
    m.gravity = lw_v3(0, 0, 0);
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    OWN(lw_modes) modes = { 0 };
    o.analysis = LW_ANALYSIS_STATIC;
    CHECK_INT(lw_dynamics_make_spatial(&m, &o, &d, &e), LW_OK);
    double *q = calloc((size_t)(lw_dynamics_space(d)->n_q + lw_dynamics_space(d)->n_v), sizeof *q);
    lw_dynamics_start(d, q, q + lw_dynamics_space(d)->n_q);
    CHECK_INT(lw_modes_find_large(d, &(lw_modes_options){ .hold_inputs = true }, 3, 0, q, &modes, &e), LW_OK);
    CHECK_NEAR(modes.mode[0].frequency, f, 0, 1e-9);
    free(q);
    lw_dynamics_free(d);
    lw_robot_free(&r);
    lw_spatial_free(&m);
    /* drives of their own, and nothing elastic */
    make("examples/space/delta.json", &m, &r);
    CHECK_INT(lw_held_make(&m, &h, &e), LW_E_ARG);
    CHECK(strstr(e.text, "elastic") != NULL);
    lw_held_free(&h);
    lw_robot_free(&r);
    lw_spatial_free(&m);
}

/* Where links are not asked to bend, elastic ones are rigid bars: the masses of the rigid model, whose bars have those of the
 * sections to 0.2 %. */
TEST(elastic_links_as_rigid_bars)
{
    static const char *const file[] = { "examples/space/delta.json", "examples/space/delta-elastic.json" };
    lw_robot_pose pose[2];
    for (int k = 0; k < 2; k++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        make(file[k], &m, &r);
        CHECK_OK(lw_robot_measure(&r, &pose[k], &check_error));
    }
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(pose[1].mass[i], pose[0].mass[i], 0, 3e-3);
}

/* A stretched arm of two links in its plane: no motion along the arm, whether the file or a move brings it there. */
TEST(a_straight_arm_is_singular)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a'}, {'name': 'b'}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
        "'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'E', 'links': ['a', 'b'], 'at': [1, 0, 0], 'axis': [0, 0, 1]}], 'drives': [{'joint': 'A'}, "
        "{'joint': 'E'}], 'tracers': [{'name': 'T', 'link': 'b', 'at': [2, 0, 0]}]}";
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    read_spatial(text, "arm", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    for (int i = 0; i < 2; i++) {
        p = pose_now(&r);
        CHECK_INT(p.rank, 2);
        CHECK(isinf(p.condition) && p.manipulability == 0);
        CHECK(p.freedoms == 2 && r.freedoms == 2);              /* turn and place: different rates of both drives show */
        CHECK_NEAR(p.singular[0], sqrt(5), 1e-14, 0);
        CHECK_OK(lw_robot_drive(&r, (const double[]){ 0.3, 0.5 }, &check_error));
        p = pose_now(&r);
        CHECK_NEAR(p.manipulability, sin(0.5), 1e-12, 0);
        CHECK_OK(lw_robot_drive(&r, (const double[]){ 0, 0 }, &check_error));
    }
    CHECK_INT(lw_robot_move(&r, lw_v3(2.1, 0, 0), NULL, &check_error), LW_OPEN);
}

/* A head on two belts: r a = x + y, r b = x - y; and a pointer behind a belt of a ratio that no teeth have, which is turned many
 * times and put back. */
TEST(robots_with_couplings)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a'}, {'name': 'b'}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
        "'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'B', 'links': ['ground', 'b'], 'at': [1, 0, 0], 'axis': [0, 0, 1]}], 'couplings': [{'name': "
        "'belt', 'terms': [{'joint': 'A', 'factor': 0.617}, {'joint': 'B', 'factor': -1}]}], 'drives': [{'joint': 'A'}], 'tracers': [{'name': 'T', "
        "'link': 'b', 'at': [1.5, 0, 0]}]}";
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    make("examples/space/corexy.json", &m, &r);
    p = pose_at(&r, lw_v3(0.12, -0.07, 0));
    CHECK_NEAR(p.drive[0], 0.05/0.008, 1e-9, 0);
    CHECK_NEAR(p.drive[1], 0.19/0.008, 1e-9, 0);
    for (int i = 0; i < 2; i++) {
        CHECK_NEAR(p.jacobian[0][i], 0.004, 1e-14, 0);
        CHECK_NEAR(p.jacobian[1][i], i ? -0.004 : 0.004, 1e-14, 0);
    }
    CHECK_FAILS(lw_robot_move(&r, lw_v3(0.25, 0, 0), NULL, &check_error), LW_OPEN, "the stop of joint \"X\"");
    lw_robot_free(&r);
    lw_spatial_free(&m);
    read_spatial(text, "belt", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    for (int i = 0; i < 4; i++) {
        double to = (const double[]){ 40, -25, 3, 100 }[i];
        if (i == 2)
            lw_robot_reset(&r);
        CHECK_OK(lw_robot_drive(&r, &to, &check_error));
        p = pose_now(&r);
        CHECK_POINT(p.place, 1 + 0.5*cos(0.617*to), 0.5*sin(0.617*to), 1e-11, 0);
        CHECK_NEAR(p.jacobian[5][0], 0.617, 1e-13, 0);
    }
}

/* Three slides on screws of 5 mm, one left-handed: 24, 14 and 6.6 turns of their motors. */
TEST(drives_turn_many_times)
{
    static char text[3000];
    static const char name[] = "xyz";
    const double to[] = { 0.12, -0.07, 0.033 }, lead[] = { 0.005, -0.005, 0.005 };
    size_t n = (size_t)snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
    for (int i = 0; i < 3; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, ", {'name': 's%c'}, {'name': 'n%c'}", name[i], name[i]);
    n += (size_t)snprintf(text + n, sizeof text - n, "], 'joints': [");
    for (int i = 0; i < 3; i++) {
        char on[8], axis[48];
        snprintf(on, sizeof on, i ? "n%c" : "ground", i ? name[i - 1] : 0);
        snprintf(axis, sizeof axis, "'at': [0, 0, 0], 'axis': [%d, %d, %d]", i == 0, i == 1, i == 2);
        n += (size_t)snprintf(text + n, sizeof text - n, "%s{'name': 'P%c', 'kind': 't', 'links': ['%s', 'n%c'], %s}, {'name': 'R%c', 'links': "
                              "['%s', 's%c'], %s}, {'name': 'H%c', 'kind': 'h', 'links': ['s%c', 'n%c'], 'lead': %g, %s}", i ? ", " : "", name[i],
                              on, name[i], axis, name[i], on, name[i], axis, name[i], name[i], name[i], lead[i], axis);
    }
    n += (size_t)snprintf(text + n, sizeof text - n, "], 'drives': [{'joint': 'Rx'}, {'joint': 'Ry'}, {'joint': 'Rz'}], "
                          "'tracers': [{'name': 'T', 'link': 'nz', 'at': [0, 0, 0]}]}");
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    read_spatial(text, "screws", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    p = pose_at(&r, lw_v3(to[0], to[1], to[2]));
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(p.drive[i], -2*LW_PI*to[i]/lead[i], 1e-9, 0);
}

/* Three legs prismatic, revolute, spherical at home: the point moves up and down only, and the plate tilts about x and y.  By hand: the ball of
 * leg i stays in the leg's plane, so z_i = rate of slide i at radius 0.2. */
TEST(a_plate_that_tilts_at_home)
{
    static char text[4096];
    int n = 0;
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    n += snprintf(text + n, sizeof text - (size_t)n, "{'linkwright': 1, 'links': ['ground', {'name': 'plate'}");
    for (int i = 0; i < 3; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': 's%d'}, {'name': 'l%d'}", i, i);
    n += snprintf(text + n, sizeof text - (size_t)n, "], 'joints': [");
    for (int i = 0; i < 3; i++) {
        double c = cos(2*LW_PI*i/3), s = sin(2*LW_PI*i/3);
        n += snprintf(text + n, sizeof text - (size_t)n, "%s{'name': 'P%d', 'kind': 't', 'links': ['ground', 's%d'], 'at': [%.17g, %.17g, 0.5], 'axis': [0, 0, 1]}, "
                        "{'name': 'R%d', 'links': ['s%d', 'l%d'], 'at': [%.17g, %.17g, 0.5], 'axis': [%.17g, %.17g, 0]}, "
                        "{'name': 'S%d', 'kind': 'b', 'links': ['l%d', 'plate'], 'at': [%.17g, %.17g, 0]}", i ? ", " : "",
                        i, i, 0.4*c, 0.4*s, i, i, i, 0.4*c, 0.4*s, -s, c, i, i, 0.2*c, 0.2*s);
    }
    n += snprintf(text + n, sizeof text - (size_t)n, "], 'drives': [{'joint': 'P0'}, {'joint': 'P1'}, {'joint': 'P2'}], 'tracers': "
                    "[{'name': 'T', 'link': 'plate', 'at': [0, 0, 0]}]}");
    read_spatial(text, "3-PRS", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    p = pose_now(&r);
    CHECK(isinf(p.condition));
    CHECK_INT(p.freedoms, 3);
    CHECK_INT(r.freedoms, 3);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(p.jacobian[2][i], 1.0/3, 1e-13, 0);
        CHECK_NEAR(p.jacobian[3][i], sin(2*LW_PI*i/3)*2/3/0.2, 1e-12, 0);
        CHECK_NEAR(p.jacobian[4][i], -cos(2*LW_PI*i/3)*2/3/0.2, 1e-12, 0);
    }
}

/* ---- tools that turn ------------------------------------------------------------------------------------- */

/* Three arms and bars between axes through one point (Gosselin & Hamel 1994): the base's u, the knee's w and the plate's v. */
typedef struct wrist { lw_vec3 u[3], w[3], v[3]; double bar; } wrist;

static lw_vec3 unit(double angle, double height, double c)
{
    return lw_v3(cos(angle)*sqrt(1 - height*height)*c, sin(angle)*sqrt(1 - height*height)*c, height*c);
}

static int write_axis(char *text, size_t size, const char *name, int i, const char *a, const char *b, lw_vec3 axis)
{
    return snprintf(text, size, "%s{'name': '%s%d', 'links': ['%s', '%s'], 'at': [%.17g, %.17g, %.17g], 'axis': [%.17g, %.17g, %.17g]}",
                    i || name[0] != 'U' ? ", " : "", name, i, a, b, 0.2*axis.x, 0.2*axis.y, 0.2*axis.z, axis.x, axis.y, axis.z);
}

/* The tool is the centre: only its turn is moved, and measured. */
static bool make_spherical(const wrist *g, lw_spatial *m, lw_robot *r)
{
    static char text[6000];
    size_t n = (size_t)snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'plate'}");
    lw_error e = { 0 };
    for (int i = 0; i < 3; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, ", {'name': 'a%d'}, {'name': 'b%d'}", i, i);
    n += (size_t)snprintf(text + n, sizeof text - n, "], 'joints': [");
    for (int i = 0; i < 3; i++) {
        char arm_name[4], bar_name[4];
        snprintf(arm_name, sizeof arm_name, "a%d", i);
        snprintf(bar_name, sizeof bar_name, "b%d", i);
        n += (size_t)write_axis(text + n, sizeof text - n, "U", i, "ground", arm_name, g->u[i]);
        n += (size_t)write_axis(text + n, sizeof text - n, "W", i, arm_name, bar_name, g->w[i]);
        n += (size_t)write_axis(text + n, sizeof text - n, "V", i, bar_name, "plate", g->v[i]);
    }
    n += (size_t)snprintf(text + n, sizeof text - n, "], 'drives': [{'joint': 'U0'}, {'joint': 'U1'}, {'joint': 'U2'}], "
                          "'tracers': [{'name': 'T', 'link': 'plate', 'at': [0, 0, 0]}]}");
    bool good = lw_spatial_read(json_quotes(text), n, "wrist", m, &e) == LW_OK && lw_robot_make(m, NULL, r, &e) == LW_OK;
    CHECK_TEXT(e.text, "");
    return good;
}

static bool make_wrist(lw_rng *rng, wrist *g, lw_spatial *m, lw_robot *r)
{
    double arm_angle = lw_rng_range(rng, 1, 1.4);
    g->bar = lw_rng_range(rng, 1.3, 1.6);
    for (int i = 0; i < 3; i++) {
        g->u[i] = unit(2*LW_PI*i/3, -0.55, 1);
        g->v[i] = unit(2*LW_PI*i/3 + 1 + lw_rng_range(rng, -0.1, 0.1), 0.55, 1);
        double c = lw_v3_dot(g->u[i], g->v[i]), det = 1 - c*c;                 /* w = a u + b v + c u x v at these angles from both */
        double a = (cos(arm_angle) - c*cos(g->bar))/det, b = (cos(g->bar) - c*cos(arm_angle))/det;
        lw_vec3 in = lw_v3_add(lw_v3_scale(g->u[i], a), lw_v3_scale(g->v[i], b)), across = lw_v3_cross(g->u[i], g->v[i]);
        g->w[i] = lw_v3_add(in, lw_v3_scale(across, sqrt((1 - lw_v3_dot(in, in))/det)));
    }
    return make_spherical(g, m, r);
}

TEST(a_wrist_turns_about_its_centre)
{
    lw_rng rng = check_rng(0);
    for (int n = 0; n < 20; n++) {
        wrist g;
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        lw_robot_pose p;
        if (!make_wrist(&rng, &g, &m, &r))
            return;
        CHECK(r.only_turns && r.turns);
        lw_quaternion turn = lw_quaternion_of_vector(lw_v3(lw_rng_range(&rng, -0.2, 0.2), lw_rng_range(&rng, -0.2, 0.2), lw_rng_range(&rng, -0.2, 0.2)));
        CHECK_OK(lw_robot_move(&r, lw_v3(0, 0, 0), &turn, &check_error));
        p = pose_now(&r);
        lw_mat3 plate = lw_quaternion_matrix(turn);
        double j[3][3];
        for (int i = 0; i < 3; i++) {
            lw_mat3 arm_turn = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3_scale(g.u[i], p.drive[i])));
            lw_vec3 w = lw_m3_apply(&arm_turn, g.w[i]), v = lw_m3_apply(&plate, g.v[i]), across = lw_v3_cross(w, v);
            CHECK_NEAR(lw_v3_dot(w, v), cos(g.bar), 1e-9, 0);
            for (int k = 0; k < 3; k++) {                                    /* (w x v) . (omega - u q') = 0 */
                double rate = lw_v3_dot(across, lw_v3(p.jacobian[3][k], p.jacobian[4][k], p.jacobian[5][k]));
                CHECK_NEAR(rate, i == k ? lw_v3_dot(across, g.u[i]) : 0, 1e-9, 0);
                j[i][k] = p.jacobian[3 + i][k];
            }
        }
        double det = 0, trace = 0;                      /* product and sum of squares of the singular values, of the turn */
        for (int i = 0; i < 3; i++) {
            det += j[0][i]*(j[1][(i + 1)%3]*j[2][(i + 2)%3] - j[1][(i + 2)%3]*j[2][(i + 1)%3]);
            trace += j[i][0]*j[i][0] + j[i][1]*j[i][1] + j[i][2]*j[i][2];
        }
        CHECK_NEAR(p.manipulability, fabs(det), 0, 1e-9);
        CHECK_NEAR(p.singular[0]*p.singular[0] + p.singular[1]*p.singular[1] + p.singular[2]*p.singular[2], trace, 0, 1e-12);
    }
}

/* The Agile Eye (Gosselin & Hamel 1994), all angles right: it is alike about the diagonal, so its ways are, whether or not the way before ended in a
 * singular posture.  Arms and plate meet (u = -v) at 101.54 degrees on every fourth way, and at half a turn on those beside. */
TEST(ways_do_not_depend_on_the_ways_before)
{
    static const lw_vec3 axis[3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    const lw_vec3 right = lw_v3(sqrt(0.5), -sqrt(0.5), 0), ahead = lw_v3(1/sqrt(6), 1/sqrt(6), -2/sqrt(6));
    wrist g = { .bar = LW_PI/2 };
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    for (int i = 0; i < 3; i++) {
        g.u[i] = axis[i], g.v[i] = axis[(i + 1)%3];
        g.w[i] = lw_v3_cross(g.u[i], g.v[i]);
    }
    if (!make_spherical(&g, &m, &r))
        return;
    for (int k = 0; k < 12; k++) {
        double far, a = LW_PI*k/6, want = k%4 == 0 ? 101.5369590328155 : 180;
        lw_robot_reset(&r);
        CHECK_OK(lw_robot_tilt(&r, lw_v3_add(lw_v3_scale(ahead, cos(a)), lw_v3_scale(right, -sin(a))), LW_PI*(1 - 1e-9), &far, &check_error));
        CHECK_NEAR(far*180/LW_PI, want, 0.02, 0);
    }
    for (int k = 0; k < 3; k++) {            /* about the axis of an arm: at a right angle another drive turns its arm alone, and the plate is free */
        double far;
        lw_robot_reset(&r);
        CHECK_OK(lw_robot_tilt(&r, axis[k], 1.8, &far, &check_error));
        CHECK_NEAR(far, LW_PI/2, 1e-6, 0);
        CHECK(strstr(r.limit, "do not hold the tool"));
    }
    for (int k = 0; k < 2; k++) {            /* driven past that posture: it is seen between two others */
        const double to = k ? 1.5 : 2;
        lw_space_watch w;
        lw_robot_reset(&r);
        CHECK_OK(lw_space_watch_begin(&w, &r.follow, &check_error));
        CHECK_OK(lw_robot_drive(&r, (const double[]){ to, 0, 0 }, &check_error));
        CHECK_INT(w.lost, !k);
        CHECK(k || (w.between[0]*to < LW_PI/2 && w.between[1]*to > LW_PI/2));
        lw_space_watch_end(&w);
    }
    /* A drive at a right angle: arm and plate of another leg turn about one axis, so that the drives hold two freedoms of three.  Beyond, they hold all. */
    lw_robot_pose p;
    lw_robot_reset(&r);
    CHECK_OK(lw_robot_drive(&r, (const double[]){ LW_PI/2, 0, 0 }, &check_error));
    CHECK_INT(lw_robot_measure(&r, &p, &check_error), LW_OPEN);
    CHECK_OK(lw_robot_drive(&r, (const double[]){ LW_PI, 0, 0 }, &check_error));
    p = pose_now(&r);
    CHECK_NEAR(p.condition, 1, 1e-9, 0);
}

static lw_vec3 rounded(lw_vec3 v) { return lw_v3(round(1e4*v.x)/1e4, round(1e4*v.y)/1e4, round(1e4*v.z)/1e4); }

/* Axes with four digits do not meet in one point any more: the linkage would be rigid.  It is adjusted to its three freedoms. */
TEST(rounded_wrists_are_adjusted)
{
    lw_rng rng = check_rng(1);
    for (int n = 0; n < 10; n++) {
        wrist g;
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        OWN(lw_space_adjusted) a = { 0 };
        OWN(lw_space_mobility) got = { 0 };
        if (!make_wrist(&rng, &g, &m, &r))
            return;
        CHECK_INT(lw_space_adjust(&m, &a, &check_error), LW_NOTHING);
        for (int i = 0; i < m.n_joint; i++) {
            lw_vec3 z = rounded(m.joint[i].axis);
            m.joint[i].at = rounded(m.joint[i].at);
            m.joint[i].axis = lw_v3_scale(z, 1/lw_v3_norm(z));
        }
        CHECK_OK(lw_space_adjust(&m, &a, &check_error));
        CHECK(a.moved > 1e-6 && a.moved < 1e-3 && a.turned > 1e-6 && a.turned < 1e-3);
        CHECK_OK(lw_space_mobility_find(&a.model, 1e-12, check_seed(), NULL, &got, &check_error));
        CHECK_INT(got.freedom, 3);
        CHECK(got.residual < 1e-12);
    }
}

/* A SCARA arm in space (two arms, quill, hand) keeps the direction of its hand over the workspace: the wrist reaches a ring about the base. */
TEST(four_drives_keep_the_hand)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a'}, {'name': 'b'}, {'name': 'q'}, {'name': 'h'}], 'joints': "
        "[{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0, 0.5], 'axis': [0, 0, 1]}, {'name': 'B', 'links': ['a', 'b'], 'at': "
        "[0.4, 0, 0.5], 'axis': [0, 0, 1]}, {'name': 'Z', 'kind': 't', 'links': ['b', 'q'], 'at': [0.4, 0.3, 0.5], 'axis': [0, 0, 1]}, "
        "{'name': 'R', 'links': ['q', 'h'], 'at': [0.4, 0.3, 0.3], 'axis': [0, 0, 1]}], 'drives': [{'joint': 'A'}, {'joint': 'B'}, "
        "{'joint': 'Z'}, {'joint': 'R'}], 'tracers': [{'name': 'T', 'link': 'h', 'at': [0.45, 0.3, 0.3]}]}";
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    read_spatial(text, "scara", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    CHECK(r.turns && !r.only_turns);
    for (int i = 0; i < 24; i++) {
        double a = 2*LW_PI*i/24, far, c = cos(a), s = sin(a);
        lw_robot_reset(&r);
        CHECK_OK(lw_robot_reach(&r, lw_v3(c, s, 0), 3, &far, &check_error));
        p = pose_now(&r);
        CHECK_NEAR(lw_v3_norm(lw_quaternion_vector(p.turn)), 0, 1e-9, 0);
        double along = 0.4*c + 0.3*s, across2 = 0.25 - along*along;          /* of the wrist: where its ray meets the circles of 0.1 and 0.7 */
        double in = 0.01 - across2 > 0 && along < 0 ? -along - sqrt(0.01 - across2) : INFINITY;
        CHECK_NEAR(far, fmin(in, -along + sqrt(0.49 - across2)), 1e-7, 0);
    }
    lw_robot_reset(&r);
    lw_quaternion turn = lw_quaternion_of_vector(lw_v3(0, 0, 1));
    CHECK_OK(lw_robot_move(&r, lw_v3(0.45, 0.3, 0.2), &turn, &check_error));
    p = pose_now(&r);
    CHECK_NEAR(p.drive[0] + p.drive[1] + p.drive[3], 1, 1e-9, 0);
    CHECK_NEAR(p.drive[2], -0.1, 1e-12, 0);
    turn = lw_quaternion_of_vector(lw_v3(0.1, 0, 0));
    CHECK_INT(lw_robot_move(&r, lw_v3(0.45, 0.3, 0.2), &turn, &check_error), LW_OPEN);
}

/* A rod of length 1 between two slides at right angles, x^2 + y^2 = 1: the drive of y loses the tool at x = 0, and reaches no farther than x = 1.  With
 * one drive, and on a gantry with five. */
TEST(drives_that_are_not_as_many_as_freedoms_lose_the_tool)
{
    static const char *const on[] = { "ground", "gr" };
    for (int k = 0; k < 2; k++) {
        char text[4096];
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        lw_robot_pose p;
        lw_error e = { 0 };
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', %s{'name': 'a'}, {'name': 'rod'}, {'name': 'b'}],'joints': [%s{'name': 'Y', "
            "'kind': 't', 'links': ['%s', 'a'], 'at': [0, 0.8, 0], 'axis': [0, 1, 0]},{'name': 'A', 'kind': 'b', 'links': ['a', 'rod'], 'at': [0, 0.8, "
            "0]}, {'name': 'B', 'kind': 'b', 'links': ['rod', 'b'], 'at': [0.6, 0, 0]}, {'name': 'X', 'kind': 't', 'links': ['%s', 'b'], 'at': [0.6, 0, "
            "0], 'axis': [1, 0, 0]}],'drives': [%s{'joint': 'Y'}], 'tracers': [{'name': 'T', 'link': 'b', 'at': [0.6, 0, 0]}]}",
            k ? "{'name': 'gx'}, {'name': 'gy'}, {'name': 'gz'}, {'name': 'gr'}, " : "",
            k ? "{'name': 'GX', 'kind': 't', 'links': ['ground', 'gx'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}, {'name': 'GY', 'kind': 't', "
                "'links': ['gx', 'gy'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}, {'name': 'GZ', 'kind': 't', 'links': ['gy', 'gz'], 'at': "
                "[0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'GR', 'links': ['gz', 'gr'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, " : "",
            on[k], on[k], k ? "{'joint': 'GX'}, {'joint': 'GY'}, {'joint': 'GZ'}, {'joint': 'GR'}, " : "");
        read_spatial(text, "trammel", &m);
        CHECK_INT(lw_robot_make(&m, NULL, &r, &e), LW_OK);
        CHECK_INT(lw_robot_move(&r, lw_v3(-1, 0, 0), NULL, &e), LW_OPEN);
        CHECK(strstr(e.text, "the drives do not hold the tool"));
        CHECK_INT(lw_robot_measure(&r, &p, &e), LW_OK);
        CHECK_NEAR(p.place.x - (k ? p.drive[0] : 0), 0, 2e-5, 0);
        lw_robot_reset(&r);
        if (k == 0) {
            CHECK_INT(lw_robot_move(&r, lw_v3(1.1, 0, 0), NULL, &e), LW_OPEN);
            CHECK(strstr(e.text, "what the drives can reach"));
            CHECK_INT(lw_robot_measure(&r, &p, &e), LW_OK);
            CHECK_NEAR(p.place.x, 1, 1e-7, 0);
        }
    }
}

/* A 3-RRR robot with the pivot of one leg on a rail has four drives for three coordinates of its tool.  To the right the lines of the outer bars meet in
 * one point at 0.5067 (Python model that integrates the least rates of the drives: 0.5063); above, two legs are stretched. */
TEST(more_drives_than_coordinates)
{
    static char text[3000];
    const double inner = 0.62, outer = 0.55;
    size_t n = (size_t)snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'plate', 'rail', 'a0', 'b0', 'a1', 'b1', 'a2', 'b2'], 'joints': [{'name': 'S', "
                                "'kind': 't', 'links': ['ground', 'rail'], 'at': [1, 0, 0], 'axis': [0, 1, 0]}");
    for (int i = 0; i < 3; i++) {
        double a = 2*LW_PI*i/3 + 0.2*i;
        lw_vec2 base = lw_v2(cos(a), sin(a)), plate = lw_v2(0.25*cos(a + 0.4), 0.25*sin(a + 0.4)), d = lw_v2_sub(plate, base);
        double far = lw_v2_norm(d), x = (far*far + inner*inner - outer*outer)/(2*far), h = sqrt(inner*inner - x*x);
        lw_vec2 elbow = lw_v2(base.x + (x*d.x - h*d.y)/far, base.y + (x*d.y + h*d.x)/far);
        n += (size_t)snprintf(text + n, sizeof text - n, ", {'name': 'A%d', 'links': ['%s', 'a%d'], 'at': [%.17g, %.17g, 0], 'axis': [0, 0, 1]}, {'name': 'B%d', 'links': "
                              "['a%d', 'b%d'], 'at': [%.17g, %.17g, 0], 'axis': [0, 0, 1]}, {'name': 'C%d', 'links': ['b%d', 'plate'], 'at': [%.17g, %.17g, 0], "
                              "'axis': [0, 0, 1]}", i, i ? "ground" : "rail", i, base.x, base.y, i, i, i, elbow.x, elbow.y, i, i, plate.x, plate.y);
    }
    snprintf(text + n, sizeof text - n, "], 'drives': [{'joint': 'S'}, {'joint': 'A0'}, {'joint': 'A1'}, {'joint': 'A2'}], 'tracers': [{'name': 'T', 'link': 'plate', "
             "'at': [0, 0, 0]}]}");
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    lw_robot_pose p;
    read_spatial(text, "3-RRR on a rail", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    CHECK_FAILS(lw_robot_move(&r, lw_v3(1, 0, 0), NULL, &check_error), LW_OPEN, "the drives do not hold the tool");
    p = pose_now(&r);
    CHECK_NEAR(p.place.x, 0.5063, 1e-3, 0);
    lw_robot_reset(&r);
    CHECK_FAILS(lw_robot_move(&r, lw_v3(0, 1, 0), NULL, &check_error), LW_OPEN, "what the drives can reach");
    p = pose_now(&r);
    double left = LW_PI*2/3 + 0.2, x = cos(left) - 0.25*cos(left + 0.4), y = sin(left) - 0.25*sin(left + 0.4), right = LW_PI*4/3 + 0.4;
    double of_left = y + sqrt((inner + outer)*(inner + outer) - x*x);
    x = cos(right) - 0.25*cos(right + 0.4), y = sin(right) - 0.25*sin(right + 0.4);
    CHECK_NEAR(p.place.y, fmin(of_left, y + sqrt((inner + outer)*(inner + outer) - x*x)), 1e-6, 0);
}

/* Masses that forces on the tool of a planar robot move: of a gantry its slides, of an arm with all mass at its tip that mass. */
TEST(masses_in_a_plane)
{
    static const char *const text[] = {
        "{'linkwright': 1, 'links': ['ground', {'name': 'x', 'mass': 3, 'centre': [0, 0, 0]}, {'name': 'y', 'mass': 2, 'centre': [0, 0, 0]}], 'joints': "
        "[{'name': 'X', 'kind': 't', 'links': ['ground', 'x'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}, {'name': 'Y', 'kind': 't', 'links': ['x', 'y'], 'at': "
        "[0, 0, 0], 'axis': [0, 1, 0]}], 'drives': [{'joint': 'X'}, {'joint': 'Y'}], 'tracers': [{'name': 'T', 'link': 'y', 'at': [0, 0, 0]}]}",
        "{'linkwright': 1, 'links': ['ground', {'name': 'a'}, {'name': 'b', 'mass': 4, 'centre': [1, 1, 0]}], 'joints': [{'name': 'A', "
        "'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'B', 'links': ['a', 'b'], 'at': [1, 0, 0], "
        "'axis': [0, 0, 1]}], 'drives': [{'joint': 'A'}, {'joint': 'B'}], 'tracers': [{'name': 'T', 'link': 'b', 'at': [1, 1, 0]}]}" };
    static const double mass[2][2] = { { 2, 5 }, { 4, 4 } };
    for (int k = 0; k < 2; k++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        lw_robot_pose p;
        read_spatial(text[k], "robot", &m);
        CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
        p = pose_now(&r);
        CHECK_INT(p.rank, 2);
        CHECK_NEAR(p.mass[0], mass[k][0], 1e-12, 0);
        CHECK_NEAR(p.mass[1], mass[k][1], 1e-12, 0);
        CHECK(p.mass[2] == 0);
    }
}
