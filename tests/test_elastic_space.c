/* tests/test_elastic_space.c - elastic links in space: vibrations of bars, the planar model turned into space, large deflections,
 * spins, a DELTA robot. */
#include "mbs/equilibrium/modes.h"
#include "mbs/elastic/expand_space.h"
#include "tests/space_run.h"
#include "tests/temporary.h"

#define SQUARE "{'shape': 'rectangle', 'width': 0.1, 'height': 0.1}"
#define STEEL  "{'E': 210e9, 'nu': 0.3, 'density': 7850}"

/* ---- runs -------------------------------------------------------------------------------------------------- */

static lw_status read_text(lw_spatial *m, lw_error *e, const char *format, ...) __attribute__((format(printf, 3, 4)));
static lw_status read_text(lw_spatial *m, lw_error *e, const char *format, ...)
{
    static char text[1 << 16];
    va_list arg;
    va_start(arg, format);
    vsnprintf(text, sizeof text, format, arg);
    va_end(arg);
    json_quotes(text);
    *e = (lw_error){ 0 };
    return lw_spatial_read(text, strlen(text), "test", m, e);
}

/* Run m, which is freed. */
static void run(lw_spatial *m, lw_dynamics_options o, srun *r)
{
    srun_go(m, &o, r);
    lw_spatial_free(m);
}

/* The slowest frequencies about the posture of the file [Hz]. */
static void frequencies(lw_spatial *m, bool hold, int n, double *out)
{
    OWN(lw_modes) modes = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    o.analysis = LW_ANALYSIS_STATIC;
    o.hold_inputs = hold;
    lw_status st = lw_dynamics_make_spatial(m, &o, &d, &check_error);
    memset(out, 0, (size_t)n*sizeof *out);
    if (st == LW_OK) {
        FREED double *q = calloc((size_t)lw_dynamics_space(d)->n_q + (size_t)lw_dynamics_space(d)->n_v, sizeof *q);
        lw_dynamics_start(d, q, q + lw_dynamics_space(d)->n_q);
        st = lw_modes_find_large(d, &(lw_modes_options){ .hold_inputs = hold }, n, 0, q, &modes, &check_error);
        for (int i = 0; i < n && i < modes.n_mode; i++)
            out[i] = modes.mode[i].frequency;
        CHECK(modes.n_mode >= n);
    }
    CHECK_OK(st);
    lw_dynamics_free(d);
    lw_spatial_free(m);
}

/* ---- bars -------------------------------------------------------------------------------------------------- */

/* A cantilever along any direction: Timoshenko's frequencies twice each, torsion (2k - 1)/(4L) sqrt(G It/(rho Ip)), stretch. */
TEST(cantilever)
{
    static const struct { double length, f[2], within[2]; } known[] = {
        { 2, { 20.8463981, 129.1206174 }, { 8e-6, 3e-4 } }, { 0.5, { 324.108992, 1745.519003 }, { 8.5e-5, 2.3e-3 } } };
    lw_rng rng = check_rng(0);
    for (int k = 0; k < 2; k++) {
        lw_spatial m;
        double f[9], l = known[k].length, u[3], size = 0;
        for (int i = 0; i < 3; i++) {
            u[i] = lw_rng_range(&rng, -1, 1);
            size += u[i]*u[i];
        }
        for (int i = 0; i < 3; i++)
            u[i] *= l/sqrt(size);
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': " SQUARE ", 'material': "
                           STEEL ", 'segments': 8, 'mass': 'consistent'}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': "
                           "['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [%.17g, %.17g, %.17g]}]}",
                           u[0], u[1], u[2]));
        const lw_elastic *p = &m.elastic[1];
        double torsion = sqrt(p->material.g*p->section.it/(p->material.density*(p->section.iy + p->section.iz)))/(4*l);
        double stretch = sqrt(p->material.e/p->material.density)/(4*l);
        frequencies(&m, false, 9, f);
        int bend = 0, twist = 0, pull = 0;
        for (int i = 0; i < 9; i++) {
            for (int j = 0; j < 2; j++)
                bend += fabs(f[i]/known[k].f[j] - 1) < known[k].within[j];
            twist += fabs(f[i]/torsion - 1) < 1.7e-3;          /* (pi/16)^2/24 */
            pull += fabs(f[i]/stretch - 1) < 1.7e-3;
        }
        CHECK_INT(bend, 4);
        CHECK_INT(twist, 1);
        CHECK_INT(pull, 1);
    }
}

/* The radii of gyration of the mass may be others than those of the area (Simo & Vu-Quoc 1988: rho A 1, rho I 20, 10, 10): first torsion of a chain
 * of n lumps, pi c/(2 L) sin(x)/x, x = pi/(4n). */
TEST(mass_beside_the_area)
{
    lw_spatial m;
    double f[1], x = LW_PI/32, c = sqrt(1e-3*1e2/(0.1*0.1 + 0.2*0.2));
    CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'general', 'area': 1, 'Iy': 1, 'Iz': 1, "
                       "'It': 1e-3, 'gyration_y': 0.1, 'gyration_z': 0.2}, 'height': [0, 1, 0], 'material': {'E': 1e6, 'G': 1e2, 'density': 1}, 'segments': 8}}], "
                       "'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', "
                       "'at': [2, 0, 0]}]}"));
    frequencies(&m, false, 1, f);
    CHECK_NEAR(f[0], c/8*sin(x)/x, 0, 1e-9);
    CHECK_FAILS(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'general', 'area': 1, 'Iy': 1, 'Iz': 1, "
                          "'It': 1, 'gyration_y': 0.1}, 'material': 'steel'}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, "
                          "0]}]}"), LW_E_NOTATION, "\"height\"");
}

/* The weak and the strong direction of a section follow its height; unequal ends and either order of the axis give the same. */
TEST(height)
{
    static const char *const height[] = { "[0, 0, 1]", "[0, 1, 0]", "[3, 0, 2]" };
    static srun r;
    double z[3];
    for (int k = 0; k < 3; k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.analysis = LW_ANALYSIS_STATIC;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', "
                           "'height': 0.1, 'width': 0.05}, 'material': " STEEL ", 'segments': 4, 'height': %s, 'axis': %s}}], 'joints': "
                           "[{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', "
                           "'link': 'bar', 'at': [2, 0, 0]}], 'forces': [{'link': 'bar', 'at': [2, 0, 0], 'fz': -1}]}", height[k],
                           k == 2 ? "[[2, 0, 0], [0, 0, 0]]" : "[[0, 0, 0], [2, 0, 0]]"));
        const lw_section q = m.elastic[1].section;
        double i = k == 1 ? q.iy : q.iz, zeta = k == 1 ? q.zeta_z : q.zeta_y;
        double exact = -8/(3*210e9*i) - 2*zeta*2.6/(210e9*q.area), stress = k == 1 ? 2*q.z/q.iy : 2*q.y/q.iz;
        run(&m, o, &r);
        z[k] = r.at[0].tracer[0].z;
        CHECK_NEAR(z[k], exact, 0, 1e-7);
        if (k < 2)
            CHECK_NEAR(fabs(r.inner[0].stress), stress, 0, 1e-6);
    }
    CHECK_NEAR(z[2], z[0], 1e-12, 0);
}

#define SOFT_WITH(more) "{'section': " SQUARE ", 'material': {'E': 1e8, 'nu': 0.3, 'density': 1000}, 'segments': 3, 'damping': 1e-4" more "}"
#define SOFT SOFT_WITH("")

/* An elastic pendulum with a bob, in a plane of any direction, moves as in the plane: `flat_more` and `more` of its elastic link. */
static void swing_as_in_the_plane(const char *flat_more, const char *more)
{
    char planar[1000];
    snprintf(planar, sizeof planar, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'bar', 'elastic': " SOFT_WITH("%s") "}, {'name': 'bob', "
        "'mass': 3, 'centre': [1, -0.2], 'inertia': 0.05}], 'joints': [{'name': 'A', 'links': ['ground', 'bar'], 'at': [0, 0]}, {'name': "
        "'B', 'links': ['bar', 'bob'], 'at': [1, 0]}], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [1, -0.2]}]}", flat_more);
    static srun r;
    static flat_run flat;
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_model f;
    lw_spatial m;
    lw_rng rng = check_rng(1);
    o.intervals = 20;
    o.relative = o.absolute = 1e-8;
    read_planar(planar, "test", &f);
    flat_go(&f, o.to, o.intervals, o.relative, &flat);
    lw_mat3 t = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3(lw_rng_range(&rng, -2, 2), lw_rng_range(&rng, -2, 2),
                                                                   lw_rng_range(&rng, -2, 2))));
    lw_vec3 b = lw_m3_column(&t, 0), c = lw_m3_apply(&t, lw_v3(1, -0.2, 0)), z = lw_m3_column(&t, 2);
    lw_vec3 g = lw_m3_apply(&t, lw_v3(0, -9.81, 0));
    CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'gravity': [%.17g, %.17g, %.17g], 'links': ['ground', {'name': 'bar', 'elastic': " SOFT_WITH("%s")
                       "}, {'name': 'bob', 'mass': 3, 'centre': [%.17g, %.17g, %.17g], 'inertia': [0.05, 0.05, 0.05]}], 'joints': "
                       "[{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [%.17g, %.17g, %.17g]}, "
                       "{'name': 'B', 'kind': 'revolute', 'links': ['bar', 'bob'], 'at': [%.17g, %.17g, %.17g], 'axis': [%.17g, %.17g, "
                       "%.17g]}], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [%.17g, %.17g, %.17g]}]}", g.x, g.y, g.z, more, c.x, c.y, c.z,
                       z.x, z.y, z.z, b.x, b.y, b.z, z.x, z.y, z.z, c.x, c.y, c.z));
    run(&m, o, &r);
    CHECK_INT(r.n, 21);
    CHECK_INT(flat.n, 21);
    for (int i = 0; i < 21; i++) {
        lw_vec3 want = lw_m3_apply(&t, lw_v3(flat.tracer[i].x, flat.tracer[i].y, 0));
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(r.at[i].tracer[0], want)), 0, 2e-6, 0);
    }
}

TEST(as_in_the_plane)
{
    swing_as_in_the_plane("", "");
    swing_as_in_the_plane(", 'superelements': 1", ", 'superelements': 1");
    swing_as_in_the_plane(", 'superelements': 1, 'modes': 6", ", 'superelements': 1, 'modes': 12");          /* all of them */
}

/* Bathe & Bolourchi's bend (1979): an arc of 45 degrees, radius 100, loaded across its plane.  Published ends of eight elements of
 * other kinds lie about (15.8, 47.2, 53.4) with 47.2 along the radius at the root. */
TEST(bend)
{
    static srun r;
    char axis[1024] = "[[0, 0, 0]";
    lw_vec3 end = { 0, 0, 0 };
    for (int i = 1; i <= 8; i++) {
        double turn = i*LW_PI/32;
        end = lw_v3(100*sin(turn), 100 - 100*cos(turn), 0);
        snprintf(axis + strlen(axis), sizeof axis - strlen(axis), ", [%.17g, %.17g, 0]", end.x, end.y);
    }
    lw_spatial m;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'arc', 'elastic': {'section': {'shape': 'general', 'area': 1, "
                       "'Iy': 0.083333333333333329, 'Iz': 0.083333333333333329, 'It': 0.140577, 'zeta': 1.2}, 'material': {'E': 1e7, "
                       "'G': 5e6, 'density': 1}, 'segments': 8, 'axis': %s]}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': "
                       "['ground', 'arc'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'arc', 'at': [%.17g, %.17g, 0]}], "
                       "'forces': [{'link': 'arc', 'at': [%.17g, %.17g, 0], 'fz': 600}]}", axis, end.x, end.y, end.x, end.y));
    run(&m, o, &r);
    CHECK_NEAR(r.at[0].tracer[0].y, 15.8, 0.3, 0);
    CHECK_NEAR(r.at[0].tracer[0].x, 47.2, 0.3, 0);
    CHECK_NEAR(r.at[0].tracer[0].z, 53.4, 0.3, 0);
}

/* The Princeton beam (Dowell & Traybar 1975; data of Bauchau et al. 2016): an aluminium bar 0.508 m long, 12.77 by 3.2024 mm, whose height is
 * turned by an angle out of the direction of the load at its end, so that it bends both ways and twists.  Its tip by a Cosserat rod, solved
 * by shooting with 400 Runge-Kutta steps; two meshes are extrapolated.  At the clamp the inner forces are those of the load on its arm. */
TEST(princeton)
{
    static const struct { double load, angle, tip[3]; } known[] = {
        { 4.448, 15, { 0.5074929303, 0.0182424101, -0.0097997612 } }, { 4.448, 45, { 0.5044789262, 0.0358860996, -0.0409950378 } },
        { 4.448, 90, { 0.5011635086, 0, -0.0757886518 } }, { 13.345, 15, { 0.5030766085, 0.0563952736, -0.0306761999 } },
        { 13.345, 45, { 0.4792891826, 0.0978990055, -0.1177859798 } }, { 13.345, 90, { 0.4599413578, 0, -0.1962341829 } } };
    static srun r;
    for (size_t k = 0; k < sizeof known/sizeof *known; k++) {
        double c = cos(known[k].angle*LW_PI/180), n = sin(known[k].angle*LW_PI/180), load = known[k].load, tip[2][3];
        for (int fine = 0; fine < 2; fine++) {
            lw_spatial m;
            lw_dynamics_options o = lw_dynamics_options_default();
            o.analysis = LW_ANALYSIS_STATIC;
            CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', "
                               "'width': 0.0032024, 'height': 0.01277}, 'material': {'E': 71.7e9, 'nu': 0.31, 'density': 2800}, 'segments': %d, "
                               "'axis': [[0, 0, 0], [0.508, 0, 0]], 'height': [0, %.17g, %.17g]}}], 'joints': [{'name': 'A', 'kind': 'fixed', "
                               "'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [0.508, 0, 0]}], "
                               "'forces': [{'link': 'bar', 'at': [0.508, 0, 0], 'fz': %g}]}", fine ? 32 : 16, n, c, -load));
            run(&m, o, &r);
            const lw_space_inner *root = &r.inner[0];
            lw_vec3 at = r.at[0].tracer[0];
            CHECK_NEAR(root->torque, -load*at.y, 1e-8, 0);
            CHECK_NEAR(root->bending[0], load*at.x*n, 1e-8, 0);       /* y of the section is (0, n, c), z (0, -c, n) */
            CHECK_NEAR(root->bending[1], -load*at.x*c, 1e-8, 0);
            CHECK_NEAR(root->normal, 0, 1e-7, 0);
            CHECK_NEAR(root->shear[0], -load*c, 1e-7, 0);
            CHECK_NEAR(root->shear[1], -load*n, 1e-7, 0);
            tip[fine][0] = at.x, tip[fine][1] = at.y, tip[fine][2] = at.z;
        }
        for (int i = 0; i < 3; i++)
            CHECK_NEAR((4*tip[1][i] - tip[0][i])/3, known[k].tip[i], 1e-6, 0);
    }
}

/* A swinging chain of three elastic bars.  At a loose tolerance it is followed by generalised alpha, at a fine one by Radau's method; the
 * errors of both are of the size of the tolerance.  An auxiliary acceleration that damps nothing keeps the energy longer. */
TEST(generalised_alpha)
{
    static const char text[] = "{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground', {'name': 'a', 'elastic': " SOFT "}, {'name': 'b', "
                               "'elastic': " SOFT "}, {'name': 'c', 'elastic': " SOFT "}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, "
                               "0, 0], 'axis': [0, 1, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [1, 0, 0], 'axis': [0, 1, 1]}, {'name': 'C', 'links': "
                               "['b', 'c'], 'at': [2, 0, 0], 'axis': [0, 1, 0]}], 'tracers': [{'name': 'P', 'link': 'c', 'at': [3, 0, 0]}]}";
    static srun exact, r;
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_spatial m;
    o.to = 0.5, o.intervals = 5;
    double lost[3];
    for (int i = 0; i < 5; i++) {
        static const double tolerance[] = { 1e-9, 1e-5, 1e-4, 1e-4, 1e-6 };
        o.formulation = i == 4 ? LW_FORMULATION_GGL : LW_FORMULATION_AUTO;       /* whose orders above 2 would not be stable */
        o.relative = o.absolute = tolerance[i];
        o.rho = i == 3 ? 0 : 1;
        CHECK_OK(read_text(&m, &check_error, text));
        lw_dynamics *d;
        CHECK_OK(lw_dynamics_make_spatial(&m, &o, &d, &check_error));
        CHECK_INT(lw_dynamics_choice(d)->formulation, i == 4 ? LW_FORMULATION_GGL : i ? LW_FORMULATION_ALPHA : LW_FORMULATION_RADAU);
        lw_dynamics_free(d);
        run(&m, o, i ? &r : &exact);
        for (int k = 0; k < 6 && i; k++)
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(r.at[k].tracer[0], exact.at[k].tracer[0])), 0, 30*tolerance[i], 0);
        if (i > 1)
            lost[i - 2] = exact.at[5].total - r.at[5].total;
    }
    CHECK(lost[1] > 3*fabs(lost[0]));
}

/* A free bar on a hub that tumbles keeps momentum and energy over a hundred turns. */
TEST(tumbles)
{
    static srun r;
    lw_spatial m;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.to = 100, o.intervals = 100;
    o.relative = o.absolute = 1e-12;
    o.formulation = LW_FORMULATION_INDEX1;
    CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'hub', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [0.02, 0.03, "
                       "0.04], 'angular_velocity': [0.6, 0, 6.283185307179586], 'velocity': [0.1, 0, -0.2]}, {'name': 'bar', 'elastic': "
                       "{'section': " SQUARE ", 'material': {'E': 2e6, 'nu': 0.3, 'density': 1000}, 'segments': 2}}], 'joints': [{'name': 'F', 'kind': "
                       "'free', 'links': ['ground', 'hub'], 'at': [0, 0, 0]}, {'name': 'W', 'kind': 'fixed', 'links': ['hub', 'bar'], 'at': [0, 0, 0]}], "
                       "'tracers': [{'name': 'P', 'link': 'bar', 'at': [0.5, 0, 0]}, {'name': 'Q', 'link': 'bar', 'at': [-0.5, 0, 0]}]}"));
    run(&m, o, &r);
    CHECK_INT(r.n, 101);
    double most = 0;
    for (int i = 0; i < r.n; i++) {
        most = fmax(most, fabs(r.at[i].total/r.at[0].total - 1));
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(r.at[i].linear, r.at[0].linear)), 0, 1e-12, 0);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(r.at[i].angular, r.at[0].angular)), 0, 1e-12*lw_v3_norm(r.at[0].angular)*10, 0);
    }
    CHECK(most < 1e-8);
}

/* The DELTA robot with elastic arms and bars of eight elements, motors held: its six slowest frequencies [Hz].  Shear factors are 1.2 for the box
 * and 2 for the tube, as in the independent model of the same declared data whose values the tests below have. */
static void delta_robot(const lw_material *arm, const lw_material *bar, double diameter, double wall, double second, double polar, double f[6])
{
    double r = diameter/2, in = r - wall, i = LW_PI/4*(pow(r, 4) - pow(in, 4));
    lw_spatial m;
    load_spatial("delta-elastic", &m);
    m.gravity = lw_v3(0, 0, 0);
    for (int b = 0; b < m.n_link; b++) {
        lw_elastic *e = &m.elastic[b];
        if (!e->given)
            continue;
        bool is_arm = e->n_axis > 0;
        e->segments = 8;
        if (is_arm)
            e->section.zeta_y = e->section.zeta_z = 1.2;
        else
            e->section = (lw_section){ LW_PI*(r*r - in*in), i, i, 2*i, 2, 2, r, r, .round = true };
        if (is_arm ? arm : bar)
            e->material = is_arm ? *arm : *bar;
        if (second > 0)
            e->section.iy = e->section.iz = second, e->section.it = polar > 0 ? polar : e->section.it;
    }
    frequencies(&m, true, 6, f);
}

/* Modes come in pairs by symmetry; bars between balls do not spin. */
TEST(delta)
{
    static const double known[6] = { 127.98, 127.98, 147.85, 150.84, 154.33, 154.33 };
    double f[6];
    delta_robot(NULL, NULL, 0.014, 0.001, 0, 0, f);
    for (int i = 0; i < 6; i++)
        CHECK_NEAR(f[i], known[i], 5e-3, 0);
    CHECK_NEAR(f[0], f[1], 0, 1e-9);
    CHECK_NEAR(f[4], f[5], 0, 1e-9);
}

/* The sections and materials of table 1 of paper B, arms and bars: lowest frequencies of the independent model.  The table prints 69.71, 66.19,
 * 69.65, 80.88, 66.61 Hz, which do not follow from its data, nor from E = 16 GPa or the second moments of area of its text
 * (docs/spatial-values.md).  Only the second row is wider than a digit: 84.8125 here.  With G = 3 GPa in the arms it depends most on the
 * shear of the box (84.09 for a factor of 1.52); which constant differs in the independent model is not known. */
TEST(table_of_delta)
{
    static const lw_material q45 = { 100e9, 40e9, 1600 }, f0 = { 250e9, 3e9, 1600 }, alu = { 70e9, 26e9, 2700 }, soft = { 16e9, 8e9, 1600 };
    static const struct { const lw_material *arm, *bar; double diameter, wall, second, polar, known, digit; } row[] = {
        { &q45, &f0, 0.014, 0.001, 0, 0, 127.98, 5e-3 }, { &f0, &f0, 0.014, 0.001, 0, 0, 84.80, 2e-2 }, { &alu, &f0, 0.014, 0.001, 0, 0, 110.82, 5e-3 },
        { &q45, &f0, 0.016, 0.001, 0, 0, 130.45, 5e-3 }, { &q45, &f0, 0.014, 0.002, 0, 0, 115.26, 5e-3 },
        { &soft, &soft, 0.014, 0.001, 0, 0, 38.6, 0.05 },                 /* G is not printed: 38.5 to 38.8 for 6 to 40 GPa */
        { &q45, &f0, 0.014, 0.001, 1.79e-6, 0, 10, 0.05 },                /* twisting as the sections have it */
        { &q45, &f0, 0.014, 0.001, 1.79e-6, 2*1.79e-6, 393, 0.5 },        /* as round ones of this second moment have it */
    };
    for (size_t k = 0; k < sizeof row/sizeof *row; k++) {
        double f[6];
        delta_robot(row[k].arm, row[k].bar, row[k].diameter, row[k].wall, row[k].second, row[k].polar, f);
        CHECK_NEAR(f[0], row[k].known, row[k].digit, 0);
    }
}

/* As rigid bars: mass, centre and inertia of a frame of two bars, against sums by hand. */
TEST(rigid)
{
    lw_spatial m, rigid;
    CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'frame', 'elastic': {'section': {'shape': 'rectangle', 'height': 0.06, "
                       "'width': 0.02}, 'height': [0, 1, 0], 'material': {'E': 1e9, 'nu': 0.3, 'density': 1000}, 'segments': 3, 'axis': [[0, 0, 0], [2, "
                       "0, 0], [2, 0, 1]]}}], 'joints': [{'name': 'A', 'kind': 'spherical', 'links': ['ground', 'frame'], 'at': [0, 0, 0]}]}"));
    CHECK_OK(lw_spatial_rigid(&m, &rigid, &check_error));
    const lw_spatial_body *b = &rigid.body[1];
    CHECK_NEAR(b->mass, 3.6, 1e-12, 0);
    CHECK_NEAR(b->centre.x, (2.4*1 + 1.2*2)/3.6, 1e-12, 0);
    CHECK_NEAR(b->centre.z, 1.2*0.5/3.6, 1e-12, 0);
    double cx = b->centre.x, cz = b->centre.z, polar = (0.06*0.06 + 0.02*0.02)/12;
    double about_y = 2.4*(4./12 + 0.02*0.02/12 + (1 - cx)*(1 - cx) + cz*cz)
                   + 1.2*(1./12 + 0.02*0.02/12 + (2 - cx)*(2 - cx) + (0.5 - cz)*(0.5 - cz));
    double about_x = 2.4*(polar + cz*cz) + 1.2*(1./12 + 0.06*0.06/12 + (0.5 - cz)*(0.5 - cz));
    CHECK_NEAR(b->inertia[1], about_y, 1e-12, 0);
    CHECK_NEAR(b->inertia[0], about_x, 1e-12, 0);
    CHECK_NEAR(b->inertia[4], -(2.4*(1 - cx)*(0 - cz) + 1.2*(2 - cx)*(0.5 - cz)), 1e-12, 0);
    lw_spatial_rigid_free(&rigid);
    lw_spatial_free(&m);
}

/* A disc in the middle of a light shaft whose ends are clamped in bearings and turn at W, from rest in all else.  Out of centre by e it
 * moves as Jeffcott (1919) has it, below and above the critical speed w: z'' + w^2 z = e W^2 exp(i W t).  Tilted by a on the shaft, it
 * tilts by I p'' - i W J p' + k p = (I - J) a W^2 exp(i W t), J its inertia about the shaft: backward and forward whirl (Genta 2005). */
TEST(a_disc_whirls)
{
    static const struct { double speed, beside, tilt; } known[] = { { 0.5, 1e-4, 0 }, { 1.5, 1e-4, 0 }, { 0.6, 0, 1e-3 }, { 2, 0, 1e-3 } };
    const double d = 0.02, e = 210e9, i4 = LW_PI*pow(d, 4)/64, ga = e/2.6*LW_PI*d*d/4*0.9, mass = 20, across = 0.3, along = 0.5;
    const double h = 0.5, shear = 12*e*i4/(ga*h*h), lift = 24*e*i4/(h*h*h*(1 + shear)), turn = 2*(4 + shear)/(1 + shear)*e*i4/h;
    static srun r;
    for (int k = 0; k < 4; k++) {
        lw_spatial m;
        lw_error error;
        lw_dynamics_options o = lw_dynamics_options_default();
        bool tilts = known[k].tilt > 0;
        double own = tilts ? sqrt(turn/across) : sqrt(lift/mass), w = known[k].speed*own, c = cos(known[k].tilt), s = sin(known[k].tilt);
        double gyro = tilts ? w*along/across : 0, root = sqrt(0.25*gyro*gyro + own*own), f = 0.5*gyro + root, b = 0.5*gyro - root;
        double steady = (tilts ? (1 - along/across)*known[k].tilt : known[k].beside)*w*w/(own*own - w*w + gyro*w);
        double back = steady*(f - w)/(b - f), forth = -steady - back;
        o.to = 4*2*LW_PI/own;
        o.intervals = 40;
        o.relative = o.absolute = 1e-8;
        CHECK_INT(read_text(&m, &error, "{'linkwright': 1, 'links': ['ground', {'name': 's', 'elastic': {'section': {'shape': 'round', 'diameter': %g}, "
                            "'material': {'E': 210e9, 'nu': 0.3, 'density': 1}, 'segments': 4, 'axis': [[0, 0, 0], [1, 0, 0]]}}, {'name': 'disc', "
                            "'mass': 20, 'centre': [0.5, %g, 0], 'inertia': [0.5, 0.3, 0.3], 'frame': {'x': [%.17g, %.17g, 0], 'y': [%.17g, %.17g, "
                            "0]}}], 'joints': [{'name': 'A', 'kind': 'revolute', 'links': ['ground', 's'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}, "
                            "{'name': 'B', 'kind': 'cylindrical', 'links': ['ground', 's'], 'at': [1, 0, 0], 'axis': [1, 0, 0]}, {'name': 'W', "
                            "'kind': 'fixed', 'links': ['s', 'disc'], 'at': [0.5, 0, 0]}], 'input': {'joint': 'A', 'motion': '%.17g*t'}, "
                            "'tracers': [{'name': 'P', 'link': 'disc', 'at': [%g, 0, 0]}]}", d, known[k].beside, c, s, -s, c, w, tilts ? 0.6 : 0.5),
                  LW_OK);
        run(&m, o, &r);
        CHECK_INT(r.n, 41);
        for (int i = 0; i < r.n; i++) {
            double t = o.to*i/40, arm = tilts ? 0.1 : 1;
            CHECK_NEAR(r.at[i].tracer[0].y, arm*(steady*cos(w*t) + forth*cos(f*t) + back*cos(b*t)), 5e-4*arm*fabs(steady), 0);
            CHECK_NEAR(r.at[i].tracer[0].z, arm*(steady*sin(w*t) + forth*sin(f*t) + back*sin(b*t)), 5e-4*arm*fabs(steady), 0);
        }
    }
}

/* ---- line loads ----------------------------------------------------------------------------------------------- */

/* What a load of density q[0] at `from` to q[1] at `to` does to a cantilever of 2 m: shear force and bending moment at its clamp,
 * deflection of its end by bending and shear; sums of point loads. */
static void cantilever_under(double from, double to, const double q[2], double bending, double shearing, double out[3])
{
    enum { N = 20000 };
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < N; i++) {
        double part = (i + 0.5)/N, x = from + part*(to - from), force = (q[0] + part*(q[1] - q[0]))*fabs(to - from)/N;
        out[0] += force;
        out[1] += force*x;
        out[2] += force*(x*x*(6 - x)/(6*bending) + x/shearing);
    }
}

/* Clamped bars under even and linear loads on all of their axis and on parts of it, either way, in both planes: whole bars, also of as
 * few elements as the load has ends, and condensed ones.  A rigid body feels the same at its joint. */
TEST(line_loads)
{
    static const struct { double from, to, q[2]; } rows[] = {
        { 0, 2, { 1, 1 } }, { 0, 2, { 0, 1 } }, { 2, 0, { 0.5, -1 } }, { 0.5, 1.5, { 2, 2 } }, { 1.5, 0.4, { 1, 3 } },
    };
    static const char *const how[] = { "'segments': 1", "'segments': 9", "'segments': 9, 'superelements': 1" };
    static srun got;
    const double u[3] = { 2./3, -1./3, 2./3 }, y[3] = { 1/sqrt(5), 2/sqrt(5), 0 };
    lw_vec3 z = lw_v3_cross(lw_v3(u[0], u[1], u[2]), lw_v3(y[0], y[1], y[2]));
    double shearing = 210e9/2.6*0.02*0.03/1.2, ei[2] = { 210e9*0.02*pow(0.03, 3)/12, 210e9*0.03*pow(0.02, 3)/12 };
    for (size_t i = 0; i < 3*sizeof rows/sizeof *rows; i++) {
        double from = rows[i/3].from, to = rows[i/3].to, plane[2] = { 1e-2, -2e-2 }, want[2][3], q[3][2];
        lw_spatial m;
        lw_error e;
        lw_dynamics_options o = lw_dynamics_options_default();
        for (int k = 0; k < 2; k++) {
            double by[2] = { plane[k]*rows[i/3].q[0], plane[k]*rows[i/3].q[1] };
            cantilever_under(from, to, by, ei[k], shearing, want[k]);
            const double axis[3] = { z.x, z.y, z.z };
            for (int c = 0; c < 3; c++)
                q[c][k] = rows[i/3].q[k]*(plane[0]*y[c] + plane[1]*axis[c]);
        }
        CHECK_INT(read_text(&m, &e, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', 'width': "
                            "0.02, 'height': 0.03}, 'height': [%.17g, %.17g, 0], 'material': " STEEL ", 'axis': [[0, 0, 0], [%.17g, %.17g, %.17g]], %s}}], "
                            "'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', "
                            "'link': 'bar', 'at': [%.17g, %.17g, %.17g]}], 'forces': [{'link': 'bar', 'along': [[%.17g, %.17g, %.17g], [%.17g, %.17g, "
                            "%.17g]], 'fx': [%.17g, %.17g], 'fy': ['%.17g', %.17g], 'fz': [%.17g, '%.17g']}]}", y[0], y[1], 2*u[0], 2*u[1], 2*u[2],
                            how[i%3], 2*u[0], 2*u[1], 2*u[2], from*u[0], from*u[1], from*u[2], to*u[0], to*u[1], to*u[2], q[0][0], q[0][1],
                            q[1][0], q[1][1], q[2][0], q[2][1]), LW_OK);
        CHECK_TEXT(e.text, "");
        o.analysis = LW_ANALYSIS_STATIC;
        run(&m, o, &got);
        lw_vec3 moved = lw_v3_sub(got.at[0].tracer[0], lw_v3(2*u[0], 2*u[1], 2*u[2]));
        double size = (i%3 ? 1 : 3)*fabs(want[1][2]);      /* the shear in an element under a linear load is left out */
        CHECK_NEAR(lw_v3_dot(moved, lw_v3(y[0], y[1], y[2])), want[0][2], 2e-5*size, 0);
        CHECK_NEAR(lw_v3_dot(moved, z), want[1][2], 2e-5*size, 0);
        CHECK_NEAR(got.inner[0].shear[0], want[0][0], 1e-7, 0);
        CHECK_NEAR(got.inner[0].shear[1], want[1][0], 1e-7, 0);
        CHECK_NEAR(got.inner[0].bending[1], want[0][1], 1e-7, 0);
        CHECK_NEAR(got.inner[0].bending[0], -want[1][1], 1e-7, 0);
        for (int k = 0; k < 2; k++) {
            CHECK_NEAR(got.inner[got.n_inner - 1].shear[k], 0, 1e-7, 0);
            CHECK_NEAR(got.inner[got.n_inner - 1].bending[k], 0, 1e-7, 0);
        }
    }
    static const struct { const char *force, *says; lw_status status; } bad[] = {
        { "'along': [[0, 0, 0], [1, 0.1, 0]], 'fz': 1", "straight part", LW_E_ARG }, { "'along': [[0, 0, 0], [0, 0, 0]], 'fz': 1", "no length", LW_E_NOTATION },
        { "'along': [[0, 0, 0], [1, 0, 0]]", "[N/m]", LW_E_NOTATION }, { "'along': [[0, 0, 0], [1, 0, 0]], 'fz': 1, 'tx': 1", "spread", LW_E_NOTATION },
        { "'along': [[0, 0, 0], [1, 0, 0]], 'fz': [1, 2, 3]", "list of 2", LW_E_NOTATION }, { "'along': [[0, 0, 0]], 'fz': 1", "list of 2", LW_E_NOTATION },
        { "'along': [[0, 0, 0], [3, 0, 0]], 'fz': 1", "straight part", LW_E_ARG },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        lw_spatial m;
        lw_error e;
        lw_dynamics_options o = lw_dynamics_options_default();
        lw_dynamics *d;
        lw_status st = read_text(&m, &e, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': " SQUARE ", 'material': " STEEL
                                 ", 'axis': [[0, 0, 0], [2, 0, 0]]}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': "
                                 "[0, 0, 0]}], 'forces': [{'link': 'bar', %s}]}", bad[i].force);
        if (st == LW_OK) {
            st = lw_dynamics_make_spatial(&m, &o, &d, &e);
            lw_spatial_free(&m);
        }
        CHECK_INT(st, bad[i].status);
        CHECK_HAS(e.text, bad[i].says);
    }
}

/* A free body, rigid or elastic, under a load along it that grows: F/m, and the turn about its centre by the load's moment. */
TEST(a_line_load_pushes_a_body)
{
    static srun got;
    for (int elastic = 0; elastic < 2; elastic++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        double mass = 7850*0.01*2, turning = mass*(4 + 0.01)/12;
        char body[300];
        snprintf(body, sizeof body, elastic ? "'elastic': {'section': " SQUARE ", 'material': " STEEL ", 'axis': [[0, 0, 0], [2, 0, 0]], 'segments': 20}"
                 : "'mass': 157, 'centre': [1, 0, 0], 'inertia': [0.26166666666666666, %.17g, %.17g]", turning, turning);
        CHECK_SILENT(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', %s}], 'joints': [{'name': 'O', 'kind': 'free', 'links': "
                               "['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [1, 0, 0]}], 'forces': "
                               "[{'link': 'bar', 'along': [[0, 0, 0], [2, 0, 0]], 'frame': 'link', 'fz': ['0', '3*t']}]}", body));
        o.to = 0.5;
        o.intervals = 1;
        run(&m, o, &got);
        /* F = 3 t at 4/3 m: p = 3/2 t^2, L about the centre -t^2/2 about y */
        CHECK_NEAR(got.at[1].linear.z, 0.375, elastic ? 1e-5 : 1e-6, 0);
        CHECK_NEAR(got.at[1].angular.y + lw_v3_cross(got.at[1].tracer[0], got.at[1].linear).y*-1, -0.125, elastic ? 1e-5 : 1e-9, 0);
    }
}

/* A four-bar with an elastic coupler and rocker whose crank turns at once, so that the rigid model has no freedom: all parts move at the
 * start as those of the rigid model do, and have its momentum; then the bars bend little. */
TEST(driven_from_the_start)
{
    static srun bent, stiff;
    for (int i = 0; i < 2; i++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_SILENT(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 0.2, 'centre': [0.05, 0, 0], 'inertia': [1e-4, 1e-4, "
                               "1e-4]}, {'name': 'coupler', 'elastic': {'section': " SQUARE ", 'material': " STEEL ", 'axis': [[0.1, 0, 0], [0.4, 0, 0.2]], "
                               "'segments': 4}}, {'name': 'rocker', 'elastic': {'section': " SQUARE ", 'material': " STEEL ", 'axis': [[0.4, 0, 0.2], [0.35, 0, "
                               "0]], 'segments': 4}}], 'joints': [{'name': 'O', 'kind': 'revolute', 'links': ['ground', 'crank'], 'at': [0, 0, 0], 'axis': [0, "
                               "-1, 0]}, {'name': 'A', 'kind': 'revolute', 'links': ['crank', 'coupler'], 'at': [0.1, 0, 0], 'axis': [0, 1, 0]}, {'name': 'B', "
                               "'kind': 'spherical', 'links': ['coupler', 'rocker'], 'at': [0.4, 0, 0.2]}, {'name': 'D', 'kind': 'revolute', 'links': ['rocker', "
                               "'ground'], 'at': [0.35, 0, 0], 'axis': [0, 1, 0]}], 'input': {'joint': 'O', 'motion': '30*t'}, 'tracers': [{'name': 'P', 'link': "
                               "'coupler', 'at': [0.25, 0, 0.1]}]}"));
        o.to = 0.01;
        o.intervals = 10;
        o.rigid = i == 1;
        run(&m, o, i ? &stiff : &bent);
    }
    CHECK(lw_v3_norm(stiff.at[0].linear) > 10);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(bent.at[0].linear, stiff.at[0].linear)), 0, 1e-9, 0);
    for (int k = 0; k < bent.n; k++)                  /* a thick bar: quasi-static bending is some um */
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(bent.at[k].tracer[0], stiff.at[k].tracer[0])), 0, 5e-5, 0);
}

/* ---- superelements -------------------------------------------------------------------------------------------- */

/* A bar of 2 m along x, clamped at 0, with a tracer and a force at its end; `more` belongs to "elastic". */
static lw_status read_bar(lw_spatial *m, const char *elastic, double gravity, double force)
{
    lw_status st = read_text(m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {%s}}], 'joints': [{'name': 'A', 'kind': "
                             "'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [2, 0, "
                             "0]}], 'gravity': [0, 0, %.17g], 'forces': [{'link': 'bar', 'at': [2, 0, 0], 'fz': %.17g}]}", elastic, gravity, force);
    CHECK_OK(st);
    return st;
}

#define BAR "'section': {'shape': 'box', 'width': 0.05, 'height': 0.08, 'wall': 0.004}, 'height': [0, 0, 1], 'material': " STEEL \
            ", 'axis': [[0, 0, 0], [2, 0, 0]]"

static srun sagged;

static double sag(const char *elastic, double gravity, double force)
{
    lw_spatial m;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    if (read_bar(&m, elastic, gravity, force) != LW_OK)
        return NAN;
    run(&m, o, &sagged);
    return sagged.at[0].tracer[0].z;
}

/* Clapeyron: half the work of a load is strain energy, of a weight what the whole potential loses. */
static void check_strain(const char *elastic)
{
    double w = sag(elastic, 0, -1);
    CHECK_NEAR(sagged.strain, -w/2, 0, 1e-6);
    sag(elastic, -0.1, 0);
    CHECK_NEAR(sagged.strain, -sagged.at[0].total, 0, 1e-6);
}

static void write_matrix(const char *path, int n, const double *a)
{
    FILE *f = fopen(path, "w");
    fprintf(f, "%%%%MatrixMarket matrix array real general\n%% by columns\n%d %d\n", n, n);
    for (int i = 0; f && i < n*n; i++)
        fprintf(f, "%.17g\n", a[i%n*n + i/n]);
    if (f)
        fclose(f);
}

/* Small loads bend a bar condensed to any number of pieces as the whole one, by its weight too; the frequencies come from above to
 * those of the whole bar; matrices from files are the same superelement. */
TEST(condensed)
{
    double whole = sag(BAR ", 'segments': 20", -0.1, -1), f[3][4], before = INFINITY;
    lw_spatial m;
    CHECK(whole < -1e-6);
    check_strain(BAR ", 'segments': 20");
    read_bar(&m, BAR ", 'segments': 20", 0, 0);
    frequencies(&m, false, 4, f[0]);
    for (int pieces = 1; pieces <= 5; pieces = 2*pieces + pieces/2) {        /* 1, 2, 5 */
        char text[500];
        snprintf(text, sizeof text, BAR ", 'segments': 20, 'superelements': %d", pieces);
        CHECK_NEAR(sag(text, -0.1, -1)/whole, 1, 1e-10, 0);
        CHECK_INT(sagged.n_inner, pieces + 1);
        for (int i = 0; i <= pieces; i++) {  /* statics of a bar: what hangs beyond a node */
            double beyond = 2 - 2.0*i/pieces, line = 0.1*7850*(0.05*0.08 - 0.042*0.072);
            CHECK_NEAR(sagged.inner[i].shear[0], -line*beyond - 1, 1e-5, 0);
            CHECK_NEAR(sagged.inner[i].bending[1], -line*beyond*beyond/2 - beyond, 1e-5, 0);
            CHECK_NEAR(sagged.inner[i].normal, 0, 1e-4, 0);
        }
        check_strain(text);
        read_bar(&m, text, 0, 0);
        frequencies(&m, false, 4, f[1]);
        double error = f[1][0]/f[0][0] - 1;                          /* of a cubic: 0.5 % */
        CHECK(error > 0 && error < 0.15*before && error < 0.006);
        before = error;
    }
    OWN(lw_spatial_expansion) x = { 0 };
    read_bar(&m, BAR ", 'segments': 20, 'superelements': 1", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    lw_superelement *p = x.model.super;
    char path[2][300], text[1000];
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
    double most = 0, rigid = 0;              /* rigid motions cause no force */
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < 12; i++) {
            double force = 0;
            for (int j = 0; j < 2; j++) {
                lw_vec3 axis = lw_v3(k%3 == 0, k%3 == 1, k%3 == 2), move = k < 3 ? axis : lw_v3_cross(axis, p->at[j]);
                const double by[6] = { move.x, move.y, move.z, k > 2 ? axis.x : 0, k > 2 ? axis.y : 0, k > 2 ? axis.z : 0 };
                for (int c = 0; c < 6; c++) {
                    force += p->stiffness[12*i + 6*j + c]*by[c];
                    most = fmax(most, fabs(p->stiffness[12*i + 6*j + c]));
                }
            }
            rigid = fmax(rigid, fabs(force));
        }
    CHECK(rigid < 1e-9*most);
    write_matrix(path[0], 12, p->stiffness);
    write_matrix(path[1], 12, p->rate);
    frequencies(&m, false, 4, f[1]);
    snprintf(text, sizeof text, "'nodes': [[0, 0, 0], [2, 0, 0]], 'stiffness': '%s', 'mass': '%s'", path[0], path[1]);
    CHECK_NEAR(sag(text, -0.1, -1)/whole, 1, 1e-9, 0);
    check_strain(text);
    read_bar(&m, text, 0, 0);
    frequencies(&m, false, 4, f[2]);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(f[2][i], f[1][i], 0, 1e-9);
}

/* A planar bar on a hinge and a slide: two frequencies [Hz], the turn at the hinge under its weight [rad], and the energy of its strains [J]; elastic:
 * "elastic" of its link. */
static void hinged_bar(const char *elastic, lw_elastic_expansion *x, double out[4])
{
    char text[1500];
    OWN(lw_model) m = { 0 };
    OWN(lw_modes) modes = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d = NULL;
    lw_rest rest;
    snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -0.01], 'links': ['ground', {'name': 'bar', 'elastic': {%s}}], 'joints': [{'name': 'A', "
             "'links': ['ground', 'bar'], 'at': [0, 0]}, {'name': 'B', 'kind': 't', 'links': ['ground', 'bar'], 'at': [0.6, 0.8], 'along': [0.6, 0.8]}]}", elastic);
    o.analysis = LW_ANALYSIS_STATIC;
    read_planar(text, "test", &m);
    lw_status st = lw_dynamics_make(&m, &o, &d, &check_error);
    CHECK_OK(st);
    if (st == LW_OK) {
        const lw_system *s = lw_dynamics_system(d);
        FREED double *q = calloc(2*(size_t)s->n_q, sizeof *q);
        lw_dynamics_start(d, q, q + s->n_q);
        CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ 0 }, 3, 0, q, &modes, &check_error));
        for (int i = 0; i < 2; i++)
            out[i] = i < modes.n_mode ? modes.mode[i].frequency : NAN;
        CHECK_OK(lw_statics_rest(d, 0, q, &rest, &check_error));
        out[2] = q[2];
        out[3] = lw_forces_strain(lw_dynamics_forces(d), q);
    }
    if (x)
        CHECK_OK(lw_elastic_expand(&m, false, x, &check_error));
    lw_dynamics_free(d);
}

/* In the plane, a bar condensed to pieces rests as its elements do and has their frequencies, from above, and nearer with modes, which are those in the
 * plane; its matrices from files are the same superelement. */
TEST(condensed_in_the_plane)
{
    enum { PIECES = 12, ROWS = 6*(PIECES + 1) };
    static double matrix[2][ROWS*ROWS];
    static const char bar[] = "'section': {'shape': 'rectangle', 'width': 0.02, 'height': 0.03}, 'material': 'steel', 'segments': 12";
    double whole[4], got[4], same[4];
    char text[2000], path[2][300], nodes[1000] = "";
    OWN(lw_elastic_expansion) x = { 0 };
    hinged_bar(bar, NULL, whole);
    snprintf(text, sizeof text, "%s, 'superelements': 4", bar);
    hinged_bar(text, NULL, got);
    CHECK(got[0] > whole[0] && got[0] < 1.001*whole[0] && got[1] > whole[1] && got[1] < 1.01*whole[1]);
    CHECK_NEAR(got[2], whole[2], 0, 1e-6);
    snprintf(text, sizeof text, "%s, 'superelements': 2", bar);
    hinged_bar(text, &x, got);
    CHECK_NEAR(got[2], whole[2], 0, 1e-6);
    CHECK_INT(x.model.n_super, 2);
    lw_elastic_expansion_free(&x);
    snprintf(text, sizeof text, "%s, 'superelements': 1", bar);
    hinged_bar(text, &x, got);
    lw_superelement *p = x.model.super;
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/flat-%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
    write_matrix(path[0], 12, p->stiffness);
    write_matrix(path[1], 12, p->rate);
    lw_elastic_expansion_free(&x);
    snprintf(text, sizeof text, "'nodes': [[0, 0], [0.6, 0.8]], 'stiffness': '%s', 'mass': '%s'", path[0], path[1]);
    hinged_bar(text, NULL, same);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(same[i], got[i], 0, i < 2 ? 1e-9 : 1e-7);
    snprintf(text, sizeof text, "%s, 'superelements': 1, 'modes': 6", bar);
    hinged_bar(text, NULL, got);
    CHECK(got[0] > whole[0] && got[0] < (1 + 1e-6)*whole[0] && got[1] > whole[1] && got[1] < (1 + 1e-4)*whole[1]);
    CHECK_NEAR(got[2], whole[2], 0, 1e-6);
    snprintf(text, sizeof text, "%s, 'superelements': %d", bar, PIECES);
    hinged_bar(text, &x, same);
    for (int k = 0; k < PIECES; k++)
        for (int i = 0; i < 144; i++) {
            int to = (6*k + i/12)*ROWS + 6*k + i%12;
            matrix[0][to] += x.model.super[k].stiffness[i];
            matrix[1][to] += x.model.super[k].rate[i];
        }
    for (int i = 0; i <= PIECES; i++)
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "%s[%.17g, %.17g]", i ? ", " : "", 0.6*i/PIECES, 0.8*i/PIECES);
    for (int i = 0; i < 2; i++)
        write_matrix(path[i], ROWS, matrix[i]);
    snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': 6", nodes, path[0], path[1]);
    hinged_bar(text, NULL, same);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(same[i], got[i], 0, i < 2 ? 1e-9 : 1e-7);
}

/* Lumps at the nodes of n elements have 1 + 2/n^2 times the inertia of a slender bar, and this is told. */
TEST(lumps_have_too_much_inertia)
{
    for (int n = 1; n <= 16; n *= 2) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_spatial_expansion) x = { 0 };
        char text[300];
        snprintf(text, sizeof text, "'section': {'shape': 'round', 'diameter': 0.002}, 'material': " STEEL ", 'axis': [[0, 0, 0], [2, 0, 0]], 'segments': %d", n);
        read_bar(&m, text, 0, 0);
        CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
        CHECK_NEAR(x.chain[0].too_much, 2.0/n/n, 1e-5, 0);
    }
    OWN(lw_spatial) m = { 0 };
    OWN(lw_spatial_expansion) x = { 0 };
    read_bar(&m, BAR ", 'segments': 20, 'superelements': 1", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    CHECK_NEAR(x.chain[0].too_much, 0, 0, 0);        /* superelements move with their whole mass */
}

/* Craig and Bampton's modes: the frequencies come from above to those of the whole bar, clamped and free, ever nearer with more
 * modes, and much nearer than Guyan's; at rest the ends stay where Guyan has them; matrices of a mesh are the same. */
TEST(craig_bampton)
{
    enum { PIECES = 10, ROWS = 6*(PIECES + 1), COUNT_OF = 8 };
    static const char *const joint[] = { "fixed", "free" };
    static double matrix[2][ROWS*ROWS];
    double whole[COUNT_OF], f[COUNT_OF];
    OWN(lw_spatial) m = { 0 };
    for (int free_free = 0; free_free < 2; free_free++) {
        double before = INFINITY, guyan = 0;
        for (int modes = -6; modes <= 48; modes = modes < 6 ? modes + 6 : 2*modes) {
            const char *more[] = { "", ", 'superelements': 1", ", 'superelements': 1, 'modes': " };
            int skip = 6*free_free;
            double worst = 0, all[COUNT_OF + 6];
            char number[20];
            snprintf(number, sizeof number, "%d", modes);
            CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {" BAR ", 'segments': 20%s%s}}], 'joints': "
                               "[{'name': 'A', 'kind': '%s', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}]%s}", more[modes < 0 ? 0 : modes ? 2 : 1],
                               modes > 0 ? number : "", joint[free_free], free_free ? "" : ", 'gravity': [0, 0, 0]"));
            int n = modes == 0 ? (free_free ? 8 : 4) : skip + 5;      /* Guyan has few */
            frequencies(&m, false, n, all);
            for (int i = 0; i < n - skip; i++) {
                f[i] = all[skip + i];
                whole[i] = modes < 0 ? f[i] : whole[i];
                worst = fmax(worst, f[i]/whole[i] - 1);
                CHECK(f[i] > whole[i]*(1 - 1e-9));
            }
            if (modes < 0)
                continue;
            guyan = modes == 0 ? worst : guyan;
            CHECK(worst < before && (modes < 6 || worst < 0.05*guyan));
            before = worst;
        }
        CHECK(before < 1e-5);
    }
    for (int modes = 0; modes < 2; modes++) {        /* a tracer cuts off a piece of one element, which has no modes */
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {" BAR ", 'segments': 20%s}}], 'joints': [{'name': 'A', "
                           "'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [0.1, 0, 0]}]}",
                           modes ? ", 'superelements': 1, 'modes': 24" : ""));
        frequencies(&m, false, 4, modes ? f : whole);
    }
    for (int i = 0; i < 4; i++)
        CHECK(f[i] > whole[i] && f[i] < (1 + 1e-4)*whole[i]);
    for (int modes = 0; modes <= 24; modes += 12) {
        char text[500];
        snprintf(text, sizeof text, BAR ", 'segments': 20, 'superelements': 1, 'modes': %d", modes);
        whole[modes/12] = sag(text, -0.1, -1);
        CHECK_NEAR(whole[modes/12]/whole[0], 1, 1e-11, 0);
    }
    OWN(lw_spatial_expansion) x = { 0 };
    read_bar(&m, BAR ", 'segments': 20, 'superelements': 10", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    for (int k = 0; k < PIECES; k++)
        for (int i = 0; i < 144; i++) {
            int to = (6*k + i/12)*ROWS + 6*k + i%12;
            matrix[0][to] += x.model.super[k].stiffness[i];
            matrix[1][to] += x.model.super[k].rate[i];
        }
    char nodes[1000] = "", path[2][300], text[2000];
    for (int i = 0; i <= PIECES; i++)
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "%s[%.17g, 0, 0]", i ? ", " : "", 2.*i/PIECES);
    lw_spatial_expansion_free(&x);
    frequencies(&m, false, 4, whole);
    double before = INFINITY;
    for (int modes = 0; modes <= 24; modes = modes ? 2*modes : 6) {
        double worst = 0;
        for (int i = 0; i < 2; i++) {
            snprintf(path[i], sizeof path[i], "%s/mesh-%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
            write_matrix(path[i], ROWS, matrix[i]);
        }
        snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': %d", nodes, path[0], path[1], modes);
        read_bar(&m, text, 0, 0);
        frequencies(&m, false, 4, f);
        for (int i = 0; i < 4; i++)
            worst = fmax(worst, fabs(f[i]/whole[i] - 1));
        CHECK(modes ? worst < before : worst < 1e-9);
        before = modes ? worst : before;
    }
    CHECK(before < 1e-3);
    static srun r[3];                      /* in time the clamped bar falls 1.6 mm by its weight: ten pieces, the mesh, the mesh by modes */
    for (int k = 0; k < 3; k++) {
        lw_dynamics_options o = lw_dynamics_options_default();
        snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': %d", nodes, path[0], path[1], k == 2 ? 12 : 0);
        read_bar(&m, k ? text : BAR ", 'segments': 20, 'superelements': 10", -9.81, 0);
        o.to = 0.1, o.intervals = 50;
        o.relative = o.absolute = 1e-8;
        run(&m, o, &r[k]);
        double most = 0;
        for (int i = 0; i < r[k].n; i++) {
            most = fmax(most, fabs(r[k].at[i].tracer[0].z));
            CHECK_NEAR(r[k].at[i].tracer[0].z, r[0].at[i].tracer[0].z, k == 2 ? 1e-6 : 5e-9, 0);
            CHECK_NEAR(r[k].at[i].tracer[0].x, r[0].at[i].tracer[0].x, 0.1*r[0].at[i].tracer[0].z*r[0].at[i].tracer[0].z + 1e-8, 0);       /* foreshortening, of second order */
        }
        CHECK(most > 1e-3);
    }
    snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': 60", nodes, path[0], path[1]);
    read_bar(&m, text, 0, 0);
    CHECK_FAILS(lw_spatial_expand(&m, false, &x, &check_error), LW_E_ARG, "9 inner nodes, which has 54");
}

/* A soft bar (48 N m by its weight) falls about a hinge, whole and condensed: modes bring its tip a hundred times nearer to that of the whole
 * mesh, where K of small strains leaves the rest, which falls with the square of the number of pieces; no energy is lost, and nothing pulls
 * at its free end. */
TEST(condensed_swing)
{
    static const struct { const char *more; double off; } row[] = {
        { "", 0 }, { ", 'superelements': 1", 2e-3 }, { ", 'superelements': 1, 'modes': 6", 2.5e-5 }, { ", 'superelements': 1, 'modes': 12", 2.5e-5 },
        { ", 'superelements': 2, 'modes': 12", 8e-6 },
    };
    static srun whole, r;
    for (int k = 0; k < (int)(sizeof row/sizeof *row); k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'round', 'diameter': "
                           "0.02}, 'material': " STEEL ", 'axis': [[0, 0, 0], [2, 0, 0]], 'segments': 20%s}}], 'joints': [{'name': 'A', 'kind': "
                           "'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', "
                           "'at': [2, 0, 0]}], 'gravity': [0, 0, -9.81]}", row[k].more));
        o.to = 0.3;
        o.intervals = 60;
        o.relative = o.absolute = 1e-8;
        run(&m, o, k ? &r : &whole);
        double worst = 0, lost = 0;
        for (int i = 0; k && i < r.n; i++) {
            worst = fmax(worst, lw_v3_norm(lw_v3_sub(r.at[i].tracer[0], whole.at[i].tracer[0])));
            lost = fmax(lost, fabs(r.at[i].total - r.at[0].total));
        }
        CHECK(worst <= row[k].off && lost < 1e-6);
        if (k) {                             /* nothing pulls at the free end; the bar weighs 24 N */
            const lw_space_inner *end = &r.inner[r.n_inner - 1];
            CHECK_NEAR(end->normal, 0, 1e-4, 0);
            CHECK_NEAR(hypot(end->shear[0], end->shear[1]), 0, 1e-4, 0);
        }
    }
}

/* A thick bar falls about a hinge, in 4 elements of consistent mass, as the rigid bar does whose angle follows from its energy; in 4 elements with
 * lumped mass the bar has too much inertia. */
TEST(consistent_swing)
{
    static srun r;
    for (int lumped = 0; lumped < 2; lumped++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', 'width': 0.1, 'height': "
                           "0.1}, 'material': " STEEL ", 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 4, 'mass': '%s'}}], 'joints': [{'name': 'A', 'kind': "
                           "'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', "
                           "'at': [1, 0, 0]}], 'gravity': [0, 0, -9.81]}", lumped ? "lumped" : "consistent"));
        o.to = 0.25;
        o.intervals = 20;
        run(&m, o, &r);
        double angle = 0, rate = 0, drive = 9.81/2/(1./3 + 0.1*0.1/12), worst = 0, lost = 0, step = 1e-4;
        for (int i = 1; i < r.n; i++) {
            for (int k = 0; k < 125; k++) {              /* angle'' = drive cos(angle), leapfrog */
                rate += step/2*drive*cos(angle);
                angle += step*rate;
                rate += step/2*drive*cos(angle);
            }
            worst = fmax(worst, hypot(r.at[i].tracer[0].x - cos(angle), r.at[i].tracer[0].z + sin(angle)));
            lost = fmax(lost, fabs(r.at[i].total - r.at[0].total));
        }
        CHECK(r.n == 21 && lost < 1e-3);
        CHECK(lumped ? worst > 1e-2 : worst < 3e-5);
    }
}

/* A condensed bar on a hub that tumbles freely: momentum, angular momentum and energy are kept, by radau and by the explicit method, which
 * agree. */
TEST(condensed_tumbles)
{
    static srun r[2];
    for (int k = 0; k < 2; k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.to = 0.1, o.intervals = 20;
        o.relative = o.absolute = k ? 1e-10 : 1e-12;
        o.formulation = k ? LW_FORMULATION_INDEX1 : LW_FORMULATION_RADAU;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'hub', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [0.02, 0.03, "
                           "0.04], 'angular_velocity': [0.6, 0, 6.283185307179586], 'velocity': [0.1, 0, -0.2]}, {'name': 'bar', 'elastic': "
                           "{'section': {'shape': 'rectangle', 'width': 0.1, 'height': 0.05}, 'height': [0, 0, 1], 'material': {'E': 2e7, 'nu': 0.3, "
                           "'density': 1000}, 'axis': [[0, 0, 0], [0.5, 0.1, 0]], 'segments': 10, 'superelements': 1, 'modes': 6}}], 'joints': "
                           "[{'name': 'F', 'kind': 'free', 'links': ['ground', 'hub'], 'at': [0, 0, 0]}, {'name': 'W', 'kind': 'fixed', 'links': "
                           "['hub', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [0.5, 0.1, 0]}]}"));
        run(&m, o, &r[k]);
        CHECK_INT(r[k].n, 21);
        for (int i = 0; i < r[k].n; i++) {
            CHECK_NEAR(r[k].at[i].total/r[k].at[0].total, 1, 1e-9, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[k].at[i].linear, r[k].at[0].linear)), 0, 1e-12, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[k].at[i].angular, r[k].at[0].angular)), 0, 1e-12, 0);
        }
    }
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[0].at[20].tracer[0], r[1].at[20].tracer[0])), 0, 1e-9, 0);
}

/* The spin-up of Simo & Vu-Quoc (1986), tip across the arm that turns as given: -.571 at 7 s, -.559 at 7.5 s, -.3625 at 10 s (+-.001, from
 * ever finer chains).  A condensed piece is not stiffened by the tension in it, so the error falls with the square of the number of pieces. */
TEST(condensed_spin_up)
{
    static srun r;
    double before = 0;
    for (int pieces = 4; pieces <= 16; pieces *= 2) {
        static const double want[] = { -.571, -.559, -.3625 }, t[] = { 7, 7.5, 10 };
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.to = 10, o.intervals = 20;
        o.relative = o.absolute = 1e-5;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'arm', 'elastic': {'section': {'shape': 'general', 'area': 1, 'Iz': "
                           "5e-4, 'Iy': 5e-4, 'It': 1e-3, 'zeta': 1}, 'material': {'E': 2.8e7, 'G': 1e7, 'density': 1.2}, 'axis': [[0, 0, 0], [10, 0, "
                           "0]], 'segments': 32, 'superelements': %d}}], 'joints': [{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'arm'], "
                           "'at': [0, 0, 0], 'axis': [0, 0, 1]}], 'input': {'joint': 'A', 'motion': '0.4*(t^2/2 + (7.5/pi)^2*(cos(2*pi*t/15) - 1))'}, "
                           "'gravity': [0, 0, 0], 'tracers': [{'name': 'P', 'link': 'arm', 'at': [10, 0, 0]}]}", pieces));
        run(&m, o, &r);
        double off = 0;
        for (int k = 0; k < 3 && r.n == 21; k++) {
            double psi = 0.4*(t[k]*t[k]/2 + pow(7.5/LW_PI, 2)*(cos(2*LW_PI*t[k]/15) - 1));
            lw_vec3 at = r.at[(int)(2*t[k])].tracer[0];
            off = fmax(off, fabs(at.y*cos(psi) - at.x*sin(psi) - want[k]));
        }
        CHECK_INT(r.n, 21);
        CHECK(pieces == 4 || off < 0.4*before);
        CHECK(pieces < 16 || off < 2.5e-3);
        before = off;
    }
}

/* A bar of 40 elements swung slowly about its end: in four superelements its tip is where the whole one has it, though each has two nodes. */
TEST(condensed_swung)
{
    static srun r[2];
    for (int k = 0; k < 2; k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', 'width': 0.01, "
                           "'height': 0.02}, 'height': [0, 0, 1], 'material': " STEEL ", 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 40%s}}], 'joints': "
                           "[{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}], 'input': {'joint': 'A', "
                           "'motion': '0.3*sin(6*t)'}, 'tracers': [{'name': 'P', 'link': 'bar', 'at': [1, 0, 0]}]}", k ? ", 'superelements': 4" : ""));
        o.to = 0.3, o.intervals = 60;
        o.relative = o.absolute = 1e-7;
        run(&m, o, &r[k]);
    }
    for (int i = 0; i <= 60; i++)
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[1].at[i].tracer[0], r[0].at[i].tracer[0])), 0, 1.5e-6, 0);
}

/* A shaft that is turned faster and faster about its axis, whole and condensed: the torque at its driven end accelerates all of it,
 * nothing acts on its free end.  The angle 5 t^3 is slow against its vibrations (800 Hz, damped). */
TEST(condensed_shaft)
{
    static srun got;
    for (int pieces = 0; pieces <= 2; pieces++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        char more[60] = "";
        if (pieces)
            snprintf(more, sizeof more, ", 'superelements': %d", pieces);
        CHECK_SILENT(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'shaft', 'elastic': {'section': {'shape': 'round', 'diameter': 0.1}, "
                               "'material': " STEEL ", 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 8, 'damping': 2e-4%s}}], 'joints': [{'name': 'A', 'kind': "
                               "'revolute', 'links': ['ground', 'shaft'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}], 'input': {'joint': 'A', 'motion': '5*t^3'}, "
                               "'tracers': [{'name': 'P', 'link': 'shaft', 'at': [1, 0, 0]}]}", more));
        o.to = 0.1;
        o.intervals = 1;
        o.relative = o.absolute = 1e-9;
        run(&m, o, &got);
        double torque = 7850*LW_PI*pow(0.1, 4)/32*30*0.1;
        /* of the whole bar, half an element at either end is the joint's and the free end's own */
        CHECK_NEAR(-got.inner[0].torque/torque, pieces ? 1 : 15./16, 2e-4, 0);
        CHECK_NEAR(-got.inner[got.n_inner - 1].torque/torque, pieces ? 0 : 1./16, 2e-4, 0);
    }
}

/* A bent bar whose centre of mass is beside the line of its ends sags under its weight as the whole one, in one piece too. */
TEST(condensed_frame)
{
    static srun r[3];
    for (int i = 0; i < 3; i++) {
        static const char *const more[] = { "", ", 'superelements': 1", ", 'superelements': 1, 'modes': 12" };
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.analysis = LW_ANALYSIS_STATIC;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'box', 'width': 0.05, "
                           "'height': 0.08, 'wall': 0.004}, 'height': [0.1, 1, 0.3], 'material': " STEEL ", 'axis': [[0, 0, 0], [0.2, 0.3, 1], "
                           "[2, 0, 1]], 'segments': 20%s}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, "
                           "0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [2, 0, 1]}], 'gravity': [0.02, 0.03, -0.05]}", more[i]));
        run(&m, o, &r[i]);
        lw_vec3 off = lw_v3_sub(r[i].at[0].tracer[0], r[0].at[0].tracer[0]), sag = lw_v3_sub(r[0].at[0].tracer[0], lw_v3(2, 0, 1));
        CHECK(lw_v3_norm(off) < 1e-4*lw_v3_norm(sag));
    }
}

/* Elastica, P L^2/EI = 5: w/L .713791524; the error falls with the square of the number of pieces. */
TEST(condensed_elastica)
{
    double before = 0;
    for (int pieces = 4; pieces <= 16; pieces *= 2) {
        char text[500];
        snprintf(text, sizeof text, "'section': {'shape': 'general', 'area': 1, 'Iz': 1e-8, 'Iy': 1e-8, 'It': 1e-8, 'zeta': 1e-12}, 'material': "
                 "{'E': 1e9, 'G': 1e9, 'density': 1}, 'axis': [[0, 0, 0], [2, 0, 0]], 'segments': %d, 'superelements': %d", 2*pieces, pieces);
        double off = sag(text, 0, 5*10/4.)/2 - .713791524;
        CHECK_NEAR(off, 0, 0.15/(pieces*pieces), 0);
        CHECK(pieces == 4 || (fabs(off) < 0.3*before && fabs(off) > 0.2*before));
        before = fabs(off);
    }
}

/* Forces of a superelement between four nodes in any posture against differences of its energy, and their derivatives against
 * differences of the forces; forces and moments balance. */
TEST(superelement_derivatives)
{
    enum { N = 4, ROWS = 6*N };
    double stiffness[ROWS*ROWS], first[3*ROWS], lump[N], force[3][ROWS], by_x[ROWS*ROWS], by_v[ROWS*ROWS], power;
    lw_vec3 at[N];
    lw_mat3 turn[N];
    lw_beam_node node[N];
    OWN(lw_super) s = { 0 };
    lw_rng rng = check_rng(0);
    for (int i = 0; i < ROWS*ROWS; i++)
        stiffness[i] = lw_rng_range(&rng, -1, 1);
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < i; j++)
            stiffness[ROWS*i + j] = stiffness[ROWS*j + i];
    for (int i = 0; i < 3*ROWS; i++)
        first[i] = lw_rng_range(&rng, -0.1, 0.1);
    for (int i = 0; i < N; i++) {
        lump[i] = 0.1;
        at[i] = lw_v3(i, lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1));
        lw_vec3 away = lw_v3(lw_rng_range(&rng, -.3, .3), lw_rng_range(&rng, -.3, .3), lw_rng_range(&rng, -.3, .3));
        lw_vec3 about = lw_v3(2 + lw_rng_range(&rng, -.4, .4), lw_rng_range(&rng, -.4, .4), lw_rng_range(&rng, -.4, .4));
        turn[i] = lw_quaternion_matrix(lw_quaternion_of_vector(away));
        node[i] = (lw_beam_node){ .at = lw_v3_add(at[i], away) };
        node[i].turn = lw_quaternion_matrix(lw_quaternion_times(lw_quaternion_of_vector(about), lw_quaternion_of_matrix(&turn[i])));
    }
    lw_superelement p = { .n = N, .at = at, .stiffness = stiffness, .first = first, .lump = lump, .beside = { 0.2, -0.1, 0.3 } };
    CHECK_INT(lw_super_make(&p, turn, lw_v3(1, -2, 9), &s), LW_OK);
    lw_super_at(&s, node, force[0], by_x, by_v, &power);
    double h = 1e-5;
    for (int c = 0; c < ROWS; c++) {
        double energy[2];
        for (int way = 0; way < 2; way++) {
            lw_beam_node old = node[c/6];
            lw_vec3 by = lw_v3_scale(lw_v3(c%3 == 0, c%3 == 1, c%3 == 2), way ? h : -h);
            lw_quaternion more = lw_quaternion_of_vector(by);
            if (c%6 < 3)
                node[c/6].at = lw_v3_add(old.at, by);
            else
                node[c/6].turn = lw_quaternion_matrix(lw_quaternion_times(more, lw_quaternion_of_matrix(&old.turn)));
            energy[way] = lw_super_at(&s, node, force[1 + way], NULL, NULL, &power);
            node[c/6] = old;
        }
        CHECK_NEAR(force[0][c], -(energy[1] - energy[0])/(2*h), 1e-8, 0);
        for (int r = 0; r < ROWS; r++)
            CHECK_NEAR(by_x[ROWS*r + c], (force[2][r] - force[1][r])/(2*h), 1e-7, 0);
    }
    lw_super_free(&s);
    CHECK_INT(lw_super_make(&p, turn, lw_v3(0, 0, 0), &s), LW_OK);
    lw_super_at(&s, node, force[0], NULL, NULL, &power);
    lw_vec3 pull = { 0, 0, 0 }, twist = { 0, 0, 0 };
    for (int i = 0; i < N; i++) {
        const double *f = force[0] + 6*i;
        pull = lw_v3_add(pull, lw_v3(f[0], f[1], f[2]));
        twist = lw_v3_add(twist, lw_v3_add(lw_v3(f[3], f[4], f[5]), lw_v3_cross(node[i].at, lw_v3(f[0], f[1], f[2]))));
    }
    CHECK(lw_v3_norm(pull) < 1e-12 && lw_v3_norm(twist) < 1e-12);
}

/* Nodes of a superelement, and their accelerations, after a time t (to its second order). */
static void move_nodes(int n, const lw_beam_node *node, const lw_vec3 *rate, double t, lw_beam_node *out)
{
    for (int i = 0; i < n; i++) {
        lw_vec3 turn = lw_v3_add(lw_v3_scale(node[i].omega, t), lw_v3_scale(rate[2*i + 1], t*t/2));
        out[i].at = lw_v3_add(node[i].at, lw_v3_add(lw_v3_scale(node[i].v, t), lw_v3_scale(rate[2*i], t*t/2)));
        out[i].turn = lw_quaternion_matrix(lw_quaternion_times(lw_quaternion_of_vector(turn), lw_quaternion_of_matrix(&node[i].turn)));
        out[i].v = lw_v3_add(node[i].v, lw_v3_scale(rate[2*i], t));
        out[i].omega = lw_v3_add(node[i].omega, lw_v3_scale(rate[2*i + 1], t));
    }
}

enum { INERTIA_NODES = 4 };

/* Inertia of a superelement between three nodes and one that carries modes, of any matrices, in any motion: its momenta are the
 * derivatives of its energy by velocities; its forces follow from these by Lagrange's equations, where rates of angular velocities are
 * not those of coordinates: d/dt(dT/dw) + dT/dw x w - dT/d(turn); momentum and angular momentum are kept. */
static void check_inertia(const lw_super *s, lw_beam_node *node, const lw_vec3 *a)
{
    enum { N = INERTIA_NODES, ROWS = 6*N };
    const double h = 1e-5;
    double force[ROWS], p[3][ROWS];
    lw_beam_node near[N];
    double energy = lw_super_inertia(s, node, a, force, p[0]), twice = 0;
    for (int way = 0; way < 2; way++) {
        move_nodes(N, node, a, way ? h : -h, near);
        lw_super_inertia(s, near, NULL, NULL, p[1 + way]);
    }
    lw_vec3 pull = { 0, 0, 0 }, twist = { 0, 0, 0 }, rates[2] = { { 0, 0, 0 }, { 0, 0, 0 } };
    for (int c = 0; c < ROWS; c++) {
        double by_v[2], by_x[2];
        lw_beam_node *k = &node[c/6], old = *k;
        for (int way = 0; way < 2; way++) {
            lw_vec3 by = lw_v3_scale(lw_v3(c%3 == 0, c%3 == 1, c%3 == 2), way ? h : -h);
            *(c%6 < 3 ? &k->v : &k->omega) = lw_v3_add(c%6 < 3 ? old.v : old.omega, by);
            by_v[way] = lw_super_inertia(s, node, NULL, NULL, NULL);
            *k = old;
            if (c%6 < 3)
                k->at = lw_v3_add(old.at, by);
            else
                k->turn = lw_quaternion_matrix(lw_quaternion_times(lw_quaternion_of_vector(by), lw_quaternion_of_matrix(&old.turn)));
            by_x[way] = lw_super_inertia(s, node, NULL, NULL, NULL);
            *k = old;
        }
        CHECK_NEAR(p[0][c], (by_v[1] - by_v[0])/(2*h), 1e-8, 0);
        const double *q = p[0] + 6*(c/6) + 3, w[3] = { old.omega.x, old.omega.y, old.omega.z };
        double across = c%6 < 3 ? 0 : q[(c + 1)%3]*w[(c + 2)%3] - q[(c + 2)%3]*w[(c + 1)%3];
        CHECK_NEAR(force[c], (p[2][c] - p[1][c])/(2*h) + across - (by_x[1] - by_x[0])/(2*h), 1e-7, 0);
        twice += p[0][c]*(c%6 < 3 ? c%3 == 0 ? old.v.x : c%3 == 1 ? old.v.y : old.v.z : w[c%3]);
    }
    CHECK_NEAR(twice, 2*energy, 1e-12, 0);
    for (int i = 0; i < N; i++) {
        const double *f = force + 6*i, *now = p[0] + 6*i;
        pull = lw_v3_add(pull, lw_v3(f[0], f[1], f[2]));
        twist = lw_v3_add(twist, lw_v3_add(lw_v3(f[3], f[4], f[5]), lw_v3_cross(node[i].at, lw_v3(f[0], f[1], f[2]))));
        for (int way = 0; way < 2; way++) {
            const double *m = p[1 + way] + 6*i;
            lw_vec3 push = lw_v3_scale(lw_v3(m[0], m[1], m[2]), (way ? 1 : -1)/(2*h)), spin = lw_v3_scale(lw_v3(m[3], m[4], m[5]), (way ? 1 : -1)/(2*h));
            rates[0] = lw_v3_add(rates[0], push);
            rates[1] = lw_v3_add(rates[1], lw_v3_add(spin, lw_v3_cross(node[i].at, push)));
        }
        rates[1] = lw_v3_add(rates[1], lw_v3_cross(node[i].v, lw_v3(now[0], now[1], now[2])));
    }
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(pull, rates[0])), 0, 1e-7, 0);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(twist, rates[1])), 0, 1e-7, 0);
}

TEST(superelement_inertia)
{
    enum { N = INERTIA_NODES, ROWS = 6*N };
    double stiffness[ROWS*ROWS], rate[ROWS*ROWS], parts[9*ROWS*ROWS], first[3*ROWS] = { 0 }, lump[N] = { 0 };
    lw_vec3 at[N], a[2*N];
    lw_mat3 turn[N];
    lw_beam_node node[N];
    OWN(lw_super) s = { 0 };
    lw_rng rng = check_rng(0);
    for (int i = 0; i < 9*ROWS*ROWS; i++) {
        int k = i/(ROWS*ROWS), row = i/ROWS%ROWS, column = i%ROWS;
        parts[i] = k > 2 && row > column ? parts[k*ROWS*ROWS + column*ROWS + row] : lw_rng_range(&rng, -1, 1);
        if (k == 0)
            rate[i] = row > column ? rate[column*ROWS + row] : lw_rng_range(&rng, -1, 1), stiffness[i] = 0;
    }
    for (int i = 0; i < N; i++) {
        double x[15];
        for (int k = 0; k < 15; k++)
            x[k] = lw_rng_range(&rng, -.4, .4);
        at[i] = i == 3 ? at[0] : lw_v3(i, x[0], x[1]);
        turn[i] = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3(x[2], x[3], x[4])));
        node[i] = (lw_beam_node){ .at = lw_v3_add(at[i], lw_v3(x[5], x[6], x[7])), .v = lw_v3(x[8], x[9], 5*x[10]), .omega = lw_v3(x[11], 5*x[12], x[13]) };
        lw_quaternion about = lw_quaternion_of_vector(lw_v3(2 + x[14], x[1], x[2]));
        node[i].turn = lw_quaternion_matrix(lw_quaternion_times(about, lw_quaternion_of_matrix(&turn[i])));
        a[2*i] = lw_v3(3*x[3], -x[6], x[9]), a[2*i + 1] = lw_v3(x[1], 4*x[8], -x[12]);
    }
    lw_superelement own = { .n = N, .n_bound = 3, .at = at, .stiffness = stiffness, .rate = rate, .turn = parts, .first = first, .lump = lump };
    CHECK_INT(lw_super_make(&own, turn, lw_v3(0, 0, 0), &s), LW_OK);
    for (int still = 0; still < 2; still++) {
        if (still)                           /* the frame does not turn, but strains and node 1 do */
            node[s.a].omega = node[s.b].omega = lw_v3(0, 0, 0);
        check_inertia(&s, node, a);
    }
}

/* Matrices that are no body's are refused, each with what is wrong: a skew stiffness; an indefinite one; a body that is fixed somewhere; a
 * mass that differs from one direction to the other; an indefinite mass; a matrix of another size. */
TEST(bad_matrices)
{
    static const char *const says[] = { "is not symmetric", "a displacement with negative energy", "resists a motion of the whole body",
                                        "differs from one direction to the other", "not positive definite", "has 18 rows" };
    OWN(lw_spatial) m = { 0 };
    OWN(lw_spatial_expansion) x = { 0 };
    char path[2][300], text[1000];
    read_bar(&m, BAR ", 'segments': 4, 'superelements': 1", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/bad-%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
    for (int k = 0; k < 6; k++) {
        double a[2][18*18] = { { 0 } }, *K = a[0], *M = a[1];
        memcpy(K, x.model.super[0].stiffness, 144*sizeof *K);
        memcpy(M, x.model.super[0].rate, 144*sizeof *M);
        double most = K[0];
        if (k == 0)
            K[1] += 1e-3*most;
        for (int i = 0; k == 1 && i < 144; i++)
            K[i] = -K[i];
        if (k == 2)
            K[0] += most;
        if (k == 3)
            M[0] *= 1.1;
        if (k == 4)
            M[13*3 + 6] += 2*M[13*3], M[13*9 - 6] += 2*M[13*3];
        write_matrix(path[0], k == 5 ? 18 : 12, K);
        write_matrix(path[1], 12, M);
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'nodes': [[0, 0, 0], [2, 0, 0]], 'stiffness': "
                 "'%s', 'mass': '%s'}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}]}", path[0], path[1]);
        OWN(lw_spatial) bad = { 0 };
        CHECK_FAILS(read_text(&bad, &check_error, "%s", text), LW_E_NOTATION, says[k]);
    }
}

TEST(refused)
{
    static const struct { const char *link, *says; } bad[] = {
        { "'elastic': {'section': {'shape': 'rectangle', 'width': 0.1, 'height': 0.2}, 'material': 'steel'}", "\"height\"" },
        { "'elastic': {'section': {'shape': 'general', 'area': 1e-4, 'Iz': 1e-8}, 'material': 'steel'}", "\"Iy\"" },
        { "'mass': 1, 'elastic': {'section': " SQUARE ", 'material': 'steel'}", "mass" },
        { "'angular_velocity': [0, 0, 1], 'elastic': {'section': " SQUARE ", 'material': 'steel'}", "speed" },
        { "'elastic': {'section': " SQUARE ", 'material': 'steel', 'axis': [[0, 0], [1, 0]]}", "3" },
        { "'elastic': {'section': " SQUARE ", 'material': 'steel', 'height': [0, 0, 0]}", "direction" },
        { "'elastic': {'nodes': [[0, 0, 0], [1, 0, 0]], 'stiffness': 'nowhere.mtx', 'mass': 'nowhere.mtx'}", "cannot be read" },
        { "'elastic': {'nodes': [[0, 0, 0], [0, 0, 0]], 'stiffness': 'a.mtx', 'mass': 'a.mtx'}", "one place" },
        { "'elastic': {'nodes': [[0, 0, 0], [1, 0, 0]], 'stiffness': 'a.txt', 'mass': 'a.mtx'}", "NAME.mtx" },
        { "'elastic': {'section': " SQUARE ", 'material': 'steel', 'superelements': 1.5}", "whole" },
        { "'elastic': {'section': " SQUARE ", 'material': 'steel', 'superelements': 1, 'modes': 4}", "multiple of 6" },
        { "'elastic': {'section': " SQUARE ", 'material': 'steel', 'modes': 6}", "superelements" },
    };
    OWN(lw_spatial) m = { 0 };
    lw_error e;
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        CHECK_INT(read_text(&m, &e, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', %s}], 'joints': [{'name': 'A', 'kind': 'fixed', "
                            "'links': ['ground', 'bar'], 'at': [0, 0, 0]}]}", bad[i].link), LW_E_NOTATION);
        CHECK_HAS(e.text, bad[i].says);
        CHECK(e.line == 1 && e.column > 0);
    }
    CHECK_FAILS(read_text(&m, &check_error, "{'linkwright': 1, 'links': [{'name': 'ground', 'elastic': {'section': " SQUARE ", 'material': 'steel'}}, "
                          "'a'], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'a'], 'at': [0, 0, 0]}]}"), LW_E_NOTATION, "ground");
    CHECK_INT(read_text(&m, &e, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', 'width': "
                        "0.1, 'height': 0.2}, 'material': 'steel', 'height': [1, 0, 0]}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': "
                        "['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [1, 0, 0]}]}"), LW_OK);
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    CHECK_FAILS(lw_dynamics_make_spatial(&m, &o, &d, &check_error), LW_E_ARG, "along its axis");
}

/* A thin strip under the load EI/L^2 bends in space as in the plane: the elastica, with 16 elements. */
TEST(a_thin_strip)
{
    static srun r;
    lw_spatial m;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'b', 'elastic': {'section': {'shape': 'rectangle', 'width': 1e-5, "
                       "'height': 1e-5}, 'material': 'steel', 'height': [0, 1, 0], 'segments': 16}}], 'joints': [{'name': 'A', 'kind': 'fixed', "
                       "'links': ['ground', 'b'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'b', 'at': [1, 0, 0]}], 'forces': [{"
                       "'link': 'b', 'at': [1, 0, 0], 'fy': %.17g}]}", 210e9*1e-20/12));
    run(&m, o, &r);
    CHECK(r.rest.stable);
    CHECK_NEAR(r.at[0].tracer[0].y, 0.301720774, 1e-4, 0);
    CHECK_NEAR(r.at[0].tracer[0].x, 1 - 0.056433236, 1e-4, 0);
}

/* A strut in any direction under a load along it: the square of its first frequency falls to 0 at Euler's load pi^2 EI/(4 L^2), less
 * by the shear (1 in 1e4); beyond it the end stands aside as Timoshenko & Gere (1961, section 2.7) have it, by 2 k L/K(k) where
 * P L^2/EI = K(k)^2 and the end turns by 2 asin k.  It stands so on every side, whether the section is round or square. */
TEST(a_strut_buckles)
{
    static const struct { double part, aside; } known[] = { { 0.9, 0 }, { 0.99, 0 }, { 1.0154, 0.2194 }, { 1.2938, 0.7195 }, { 1.8848, 0.8032 } };
    static const char *const shape[] = { "'round', 'diameter': 0.02", "'rectangle', 'width': 0.02, 'height': 0.02" };
    static srun r;
    for (int square = 0; square < 2; square++) {
        double euler = LW_PI*LW_PI/4*210e9*pow(0.02, 4)*(square ? 1./12 : LW_PI/64), first[2];
        for (int i = 0; i < 5; i++) {
            lw_spatial m;
            lw_dynamics_options o = lw_dynamics_options_default();
            lw_dynamics *p;
            lw_modes modes = { 0 };
            double load = -known[i].part*euler;
            o.analysis = LW_ANALYSIS_STATIC;
            for (int statics = 0; statics < 2; statics++) {
                CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'c', 'elastic': {'section': {'shape': %s}, 'material': "
                                   "{'E': 210e9, 'G': 81e9, 'density': 7850}, 'axis': [[0, 0, 0], [0.48, 0.64, 0.6]], 'height': [0.6, -0.8, 0.1], "
                                   "'segments': 32}}], 'joints': [{'name': 'W', 'kind': 'fixed', 'links': ['ground', 'c'], 'at': [0, 0, 0]}], "
                                   "'tracers': [{'name': 'T', 'link': 'c', 'at': [0.48, 0.64, 0.6]}], 'forces': [{'link': 'c', 'at': [0.48, 0.64, "
                                   "0.6], 'fx': %.17g, 'fy': %.17g, 'fz': %.17g}]}", shape[square], 0.48*load, 0.64*load, 0.6*load));
                if (statics) {
                    run(&m, o, &r);
                    CHECK(i < 2 ? r.rest.stable && !r.rest.neutral : r.rest.neutral && !r.rest.stable);
                    lw_vec3 u = lw_v3(0.48, 0.64, 0.6);
                    CHECK_NEAR(lw_v3_norm(lw_v3_cross(u, r.at[0].tracer[0])), known[i].aside, 2e-3, 0);
                    continue;
                }
                CHECK_OK(lw_dynamics_make_spatial(&m, &o, &p, &check_error));
                double *q = calloc((size_t)lw_dynamics_space(p)->n_q + (size_t)lw_dynamics_space(p)->n_v, sizeof *q);
                lw_dynamics_start(p, q, q + lw_dynamics_space(p)->n_q);
                CHECK_OK(lw_modes_find_large(p, &(lw_modes_options){ .rest = true }, 2, 0, q, &modes, &check_error));
                if (i < 2) {
                    first[i] = modes.mode[0].frequency*modes.mode[0].frequency;
                    CHECK_NEAR(modes.mode[1].frequency, modes.mode[0].frequency, 0, 1e-6);
                } else
                    CHECK(modes.mode[0].natural < 1e-3*modes.mode[1].frequency);
                free(q);
                lw_modes_free(&modes);
                lw_dynamics_free(p);
                lw_spatial_free(&m);
            }
        }
        CHECK_NEAR(known[1].part + first[1]*(known[1].part - known[0].part)/(first[0] - first[1]), 1, 2e-3, 0);
    }
}

/* A strut whose sides differ by 1e-6, under 1.3 times Euler's load, bends about its weaker axis and is stable there, though it sways across
 * at 0.2 rad/s only; one of equal sides may turn without any force. */
TEST(a_strut_nearly_square)
{
    static srun r;
    lw_spatial m;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    for (int square = 0; square < 2; square++) {
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'c', 'elastic': {'section': {'shape': 'rectangle', 'width': 0.02, "
                           "'height': %.17g}, 'material': {'E': 210e9, 'G': 81e9, 'density': 7850}, 'height': [0, 1, 0], 'segments': 8}}], 'joints': "
                           "[{'name': 'W', 'kind': 'fixed', 'links': ['ground', 'c'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'T', 'link': 'c', 'at': "
                           "[1, 0, 0]}], 'forces': [{'link': 'c', 'at': [1, 0, 0], 'fx': %.17g}]}", square ? 0.02 : 0.02*(1 + 1e-6),
                           -1.2938*LW_PI*LW_PI/4*210e9*pow(0.02, 4)/12));
        run(&m, o, &r);
        CHECK(r.rest.stable == !square && r.rest.neutral == square);
    }
}

/* Square of the lowest frequency about the equilibrium. */
static double lowest_square(const lw_spatial *m)
{
    lw_dynamics *p;
    OWN(lw_modes) modes = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    CHECK_OK(lw_dynamics_make_spatial(m, &o, &p, &check_error));
    double *q = calloc((size_t)lw_dynamics_space(p)->n_q + (size_t)lw_dynamics_space(p)->n_v, sizeof *q);
    lw_dynamics_start(p, q, q + lw_dynamics_space(p)->n_q);
    CHECK_OK(lw_modes_find_large(p, &(lw_modes_options){ .rest = true }, 2, 0, q, &modes, &check_error));
    double square = modes.n_mode ? modes.mode[0].frequency*modes.mode[0].frequency : NAN;
    free(q);
    lw_dynamics_free(p);
    return square;
}

/* Deep bars that are bent about their stiff axis buckle sideways with a twist, where the square of the lowest frequency falls to 0: a cantilever at
 * 4.0126 sqrt(E Iy G It)/L^2 (Timoshenko & Gere 1961, section 6.3; its deflection before adds 0.2 % here), and the right-angle frame of Argyris et al.
 * (1979) at 1.088 and -0.68. */
TEST(deep_bars_buckle_sideways)
{
    static const double iy = 0.06*0.002*0.002*0.002/12, it = 0.06*0.002*0.002*0.002/3*(1 - 0.63*0.002/0.06);
    const double strip = 4.0126*210e9*sqrt(iy*it/2.6);
    const struct { bool frame; double near, load; } known[] = { { false, 0.97, 1.002 }, { true, 1.0, 1.088 }, { true, -0.62, -0.68 } };
    for (int i = 0; i < 3; i++) {
        double square[2], part[2] = { known[i].near, 0.2*known[i].near + 0.8*known[i].load };
        for (int k = 0; k < 2; k++) {
            OWN(lw_spatial) m = { 0 };
            if (known[i].frame)
                CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'elastic': {'section': {'shape': 'general', 'area': 18, 'Iz': "
                   "1350, 'Iy': 0.54, 'It': 2.16, 'height': 30, 'width': 0.6}, 'material': {'E': 71240, 'nu': 0.31, 'density': 1e-6}, 'axis': [[0, 0, 0], "
                   "[240, 0, 0]], 'segments': 10, 'height': [0, 1, 0]}}, {'name': 'b', 'elastic': {'section': {'shape': 'general', 'area': 18, 'Iz': 1350, "
                   "'Iy': 0.54, 'It': 2.16, 'height': 30, 'width': 0.6}, 'material': {'E': 71240, 'nu': 0.31, 'density': 1e-6}, 'axis': [[240, 0, 0], "
                   "[240, -240, 0]], 'segments': 10, 'height': [1, 0, 0]}}], 'joints': [{'name': 'F', 'kind': 'fixed', 'links': ['ground', 'a'], 'at': "
                   "[0, 0, 0]}, {'name': 'W', 'kind': 'fixed', 'links': ['a', 'b'], 'at': [240, 0, 0]}], 'forces': [{'link': 'b', 'at': [240, -240, 0], "
                   "'fx': %.17g}]}", part[k]));
            else
                CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'b', 'elastic': {'section': {'shape': 'rectangle', 'width': 0.002, "
                   "'height': 0.06}, 'material': {'E': 210e9, 'nu': 0.3, 'density': 7850}, 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 16, 'height': "
                   "[0, 0, 1]}}], 'joints': [{'name': 'F', 'kind': 'fixed', 'links': ['ground', 'b'], 'at': [0, 0, 0]}], 'forces': [{'link': 'b', 'at': "
                   "[1, 0, 0], 'fz': %.17g}]}", -part[k]*strip));
            square[k] = lowest_square(&m);
        }
        CHECK_NEAR((part[0] + (part[1] - part[0])*square[0]/(square[0] - square[1]))/known[i].load, 1, 3e-3, 0);
    }
}
