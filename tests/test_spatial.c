/* Spatial models: what is read and refused, postures along inputs, mobility of linkages whose answer is known. */
#include <unistd.h>
#include "mbs/space/space_mobility.h"
#include "mbs/space/space_trace.h"
#include "tests/spatial_models.h"
#include "tests/temporary.h"

/* ---- reading ----------------------------------------------------------------------------------------------- */

/* A pendulum with `link` for the other members of its link, `joint` for those of its joint, and `more`. */
static lw_status read_pendulum(const char *link, const char *joint, const char *more, lw_spatial *m, lw_error *e)
{
    char text[1024];
    int n = snprintf(text, sizeof text, "{'linkwright': 1,\n'links': ['ground', {'name': 'a'%s}],\n'joints': [{'name': 'A', 'links': ['ground', 'a'], "
                                        "'at': [0, 0, 0]%s}]%s}", link, joint, more);
    *e = (lw_error){ 0 };
    return lw_spatial_read(json_quotes(text), (size_t)n, "f", m, e);
}

TEST(refuses_what_no_model_has)
{
    static const struct { const char *link, *joint, *more, *says; int line; } bad[] = {
        { "", ", 'axis': [0, 0, 0]", "", "[0, 0, 0]", 3 },
        { "", "", "", "needs its \"axis\"", 3 },
        { "", ", 'kind': 'b', 'axis': [0, 0, 1]", "", "has no axis", 3 },
        { "", ", 'kind': 'u', 'axis': [0, 0, 1], 'second_axis': [0, 0, -2]", "", "parallel", 3 },
        { "", ", 'kind': 'h', 'axis': [0, 0, 1]", "", "\"lead\"", 3 },
        { "", ", 'kind': 'revolut', 'axis': [0, 0, 1]", "", "did you mean \"revolute\"", 3 },
        { "", ", 'kind': 'g'", "", "in space they are \"couplings\"", 3 },
        { ", 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 2.1]", ", 'axis': [0, 0, 1]", "", "exceed", 2 },
        { ", 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 1, 2, 0, 0]", ", 'axis': [0, 0, 1]", "",
          "negative", 2 },
        { ", 'mass': 1, 'centre': [0, 0, 0], 'frame': {'x': [1, 0, 0], 'y': [0.1, 1, 0]}",
          ", 'axis': [0, 0, 1]", "",
          "84.2894 degrees", 2 },
        { ", 'mass': 1, 'centre': [0, 0, 0], 'frame': {'x': [1, 0, 0], 'y': [0, 1, 0], 'z': [0, 0, -1]}",
          ", 'axis': [0, 0, 1]", "", "left-handed", 2 },
        { ", 'mass': 1", ", 'axis': [0, 0, 1]", "", "no \"centre\"", 2 },
        { ", 'mass': -1, 'centre': [0, 0, 0]", ", 'axis': [0, 0, 1]", "", "negative", 2 },
        { ", 'mass': 1, 'centre': [1e30, 0, 0]", ", 'axis': [0, 0, 1]", ",\n'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0, 0]}]", "lies 1e+30 m from its joint", 2 },
        { "}, {'name': 'b'", ", 'axis': [0, 0, 1]", "", "connects link \"b\"", 3 },
        { "", ", 'axis': [0, 0, 1]", ",\n'input': {'tracer': 'P', 'coordinate': 'x'}", "no tracer", 4 },
        { "", ", 'kind': 'b'", ",\n'input': {'joint': 'A'}", "no single coordinate", 4 },
        { "", ", 'axis': [0, 0, 1], 'friction': {}", "", "\"coefficient\"", 3 },
        { "", ", 'axis': [0, 0, 1, 4]", "", "list of 3", 3 },
        { ", 'elastic': {'section': {'shape': 'round', 'diameter': 0.1}, 'material': 'steel', 'axis': [[0, 0, 0], [0, 0, 0]]}",
          ", 'axis': [0, 0, 1]", "", "length 0", 2 },
        { ", 'velocity': [1, 0, 0]", ", 'axis': [0, 0, 1]", ",\n'ground': 'a'", "the ground does not move", 2 },
        { "", ", 'axis': [0, 0, 1]", ",\n'gravity': [0, -9.81]", "list of 3", 4 },
        { "", ", 'axis': [0, 0, 1]", ",\n'couplings': [{'name': 'g', 'terms': [{'joint': 'A', 'factor': 1}]}]", "at least 2", 4 },
        { "", ", 'axis': [0, 0, 1]", ",\n'couplings': [{'name': 'g', 'terms': [{'joint': 'A', 'factor': 1}, {'joint': 'A', "
          "'factor': 2}]}]", "a term already", 4 },
        { "", ", 'axis': [0, 0, 1]", ",\n'couplings': [{'name': 'g', 'terms': [{'joint': 'A', 'factor': 0}, {'joint': 'A', 'factor': 2}]}]", "factor", 4 },
        { "", ", 'axis': [0, 0, 1]", ",\n'couplings': [{'name': 'g', 'terms': [{'joint': 'A', 'coordinate': 'slide', 'factor': 1}, "
          "{'joint': 'A', 'factor': 2}]}]", "no slide for a coupling", 4 },
        { "", ", 'axis': [0, 0, 1]", ",\n'contacts': [{'links': ['ground', 'a']}]", "\"contacts\" is for planar models", 4 },
        { ", 'shapes': []", ", 'axis': [0, 0, 1]", "", "\"shapes\" is for planar models", 2 },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        lw_spatial m;
        lw_error e;
        CHECK_INT(read_pendulum(bad[i].link, bad[i].joint, bad[i].more, &m, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, bad[i].says);
        CHECK_INT(e.line, bad[i].line);
        CHECK(e.column > 0);
    }
}

/* ---- meshes ------------------------------------------------------------------------------------------------- */

static void put_float(FILE *f, float x)
{
    fwrite(&x, 4, 1, f);
}

/* A cube of edge 1 beside the origin, its faces outwards or inwards, the first `n` triangles; as bytes. */
static void write_cube(const char *path, bool outwards, uint32_t n)
{
    static const int face[6][4] = { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 4, 6, 2 }, { 1, 3, 7, 5 } };
    char head[80] = "solid is not what this is";
    FILE *f = fopen(path, "wb");
    fwrite(head, 80, 1, f);
    fwrite(&n, 4, 1, f);
    for (uint32_t i = 0; i < n; i++) {
        const int *q = face[i/2], corner[3] = { q[0], q[i%2 ? 2 : 1], q[i%2 ? 3 : 2] };
        for (int k = 0; k < 3; k++)
            put_float(f, 0);
        for (int k = 0; k < 3; k++) {
            int c = corner[outwards ? k : 2 - k];
            put_float(f, 2 + (float)(c & 1));
            put_float(f, (float)(c >> 1 & 1));
            put_float(f, (float)(c >> 2));
        }
        put_float(f, 0);
        fseek(f, -2, SEEK_CUR);
    }
    fclose(f);
    CHECK_INT(truncate(path, 84 + 50*(long)n), 0);
}

static lw_vec3 on_torus(int i, int k, int n, int around)
{
    double a = 2*LW_PI*(i%n)/n, b = 2*LW_PI*(k%around)/around, r = 0.3 + 0.1*cos(b);
    return lw_v3(0.2 + r*cos(a), r*sin(a) - 0.1, 0.1*sin(b) + 0.7);
}

/* Write the torus; integrals over its faces by a rule of degree 3 and Gauss's theorem:
 * volume, first moments, xx, yy, zz, xy, xz, yz. */
static void write_torus(const char *path, double sum[10])
{
    enum { N = 24, AROUND = 10 };
    static const double rule[4][4] = { { 1./3, 1./3, 1./3, -27./48 }, { 0.6, 0.2, 0.2, 25./48 }, { 0.2, 0.6, 0.2, 25./48 }, { 0.2, 0.2, 0.6, 25./48 } };
    FILE *f = fopen(path, "w");
    memset(sum, 0, 10*sizeof *sum);
    fprintf(f, "solid torus\n");
    for (int t = 0; t < 2*N*AROUND; t++) {
        int i = t/2/AROUND, k = t/2%AROUND;
        lw_vec3 p[3] = { on_torus(i, k, N, AROUND), on_torus(i + 1, k + t%2, N, AROUND), on_torus(i + !(t%2), k + 1, N, AROUND) };
        fprintf(f, "facet normal 0 0 0\n outer loop\n");
        for (int c = 0; c < 3; c++)
            fprintf(f, "  vertex %.17g %.17g %.17g\n", p[c].x, p[c].y, p[c].z);
        fprintf(f, " endloop\nendfacet\n");
        lw_vec3 area = lw_v3_scale(lw_v3_cross(lw_v3_sub(p[1], p[0]), lw_v3_sub(p[2], p[0])), 0.5);
        for (int g = 0; g < 4; g++) {
            const double *r = rule[g];
            double x = r[0]*p[0].x + r[1]*p[1].x + r[2]*p[2].x, y = r[0]*p[0].y + r[1]*p[1].y + r[2]*p[2].y;
            double z = r[0]*p[0].z + r[1]*p[1].z + r[2]*p[2].z, ax = r[3]*area.x, ay = r[3]*area.y, az = r[3]*area.z;
            const double by[10] = { x*ax, x*x/2*ax, y*y/2*ay, z*z/2*az, x*x*x/3*ax, y*y*y/3*ay, z*z*z/3*az, x*x*y/2*ax, x*x*z/2*ax, y*y*z/2*ay };
            for (int m = 0; m < 10; m++)
                sum[m] += by[m];
        }
    }
    fprintf(f, "endsolid\n");
    fclose(f);
}

/* The mass of closed meshes is that of their polyhedron; meshes with holes and inside out are refused. */
TEST(mass_of_meshes)
{
    char path[2][300], text[700];
    lw_spatial m;
    double s[10];
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/%s.stl", temporary_folder(), i ? "torus" : "cube");
    write_cube(path[0], true, 12);
    snprintf(text, sizeof text, ", 'mesh': {'file': '%s', 'density': 1, 'at': [0, 0, 1]}, 'frame': {'x': [0, 1, 0], 'y': [0, 0, 1]}", path[0]);
    CHECK_SILENT(read_pendulum(text, ", 'axis': [0, 0, 1]", "", &m, &check_error));
    const lw_spatial_body *b = &m.body[1];
    CHECK_NEAR(b->mass, 1, 1e-12, 0);
    CHECK_NEAR(b->centre.x, 0.5, 1e-12, 0);
    CHECK_NEAR(b->centre.y, 2.5, 1e-12, 0);
    CHECK_NEAR(b->centre.z, 1.5, 1e-12, 0);
    for (int i = 0; i < 6; i++)
        CHECK_NEAR(b->inertia[i], i < 3 ? 1./6 : 0, 1e-12, 0);
    lw_spatial_free(&m);

    write_torus(path[1], s);
    snprintf(text, sizeof text, ", 'mass': 5, 'mesh': {'file': '%s', 'unit': 'cm'}", path[1]);
    CHECK_SILENT(read_pendulum(text, ", 'axis': [0, 0, 1]", "", &m, &check_error));
    b = &m.body[1];
    double xx = s[4] - s[1]*s[1]/s[0], yy = s[5] - s[2]*s[2]/s[0], zz = s[6] - s[3]*s[3]/s[0], scale = 5/s[0]*1e-4;
    const double want[6] = { yy + zz, xx + zz, xx + yy, s[1]*s[2]/s[0] - s[7], s[1]*s[3]/s[0] - s[8], s[2]*s[3]/s[0] - s[9] };
    CHECK_NEAR(s[0], 2*LW_PI*LW_PI*0.3*0.01, 0, 0.08);            /* the polyhedron is inside the torus */
    CHECK_NEAR(b->mass, 5, 0, 0);
    CHECK_NEAR(b->centre.x, 0.01*s[1]/s[0], 0, 1e-12);
    CHECK_NEAR(b->centre.z, 0.01*s[3]/s[0], 0, 1e-12);
    for (int i = 0; i < 6; i++)
        CHECK_NEAR(b->inertia[i], scale*want[i], 1e-12*scale*want[2], 0);
    lw_spatial_free(&m);

    static const struct { bool outwards; uint32_t n; const char *says, *more; } bad[] = {
        { true, 11, "not closed", ", 'density': 1}" }, { false, 12, "inwards", ", 'density': 1}" }, { true, 0, "no triangles", ", 'density': 1}" },
        { true, 12, "\"density\"", "}" }, { true, 12, "greater than 0", ", 'density': -1}" }, { true, 12, "keep one", ", 'density': 1}, 'mass': 2" },
        { true, 12, "follow from its mesh", ", 'density': 1}, 'mass': 1, 'centre': [0, 0, 0]" },
        { true, 12, "unit of length", ", 'density': 1, 'unit': 'parsec'}" },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        write_cube(path[0], bad[i].outwards, bad[i].n);
        snprintf(text, sizeof text, ", 'mesh': {'file': '%s'%s", path[0], bad[i].more);
        CHECK_FAILS(read_pendulum(text, ", 'axis': [0, 0, 1]", "", &m, &check_error), LW_E_NOTATION, bad[i].says);
    }
}

/* A tensor in a turned frame is R I R^T; the principal values come back, whatever the frame. */
TEST(tensors_turn_with_their_frame)
{
    lw_rng rng = check_rng(0);
    for (int k = 0; k < 100; k++) {
        double value[3], got[3], tensor[6];
        lw_mat3 r, axes;
        for (int i = 0; i < 3; i++)
            value[i] = 1 + lw_rng_uniform(&rng);
        r = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3(lw_rng_normal(&rng), lw_rng_normal(&rng), lw_rng_normal(&rng))));
        for (int i = 0; i < 6; i++) {
            static const int row[] = { 0, 1, 2, 0, 0, 1 }, column[] = { 0, 1, 2, 1, 2, 2 };
            lw_vec3 a = r.row[row[i]], b = r.row[column[i]];
            tensor[i] = a.x*value[0]*b.x + a.y*value[1]*b.y + a.z*value[2]*b.z;
        }
        lw_m3_principal(tensor, got, &axes);
        CHECK_NEAR(got[0] + got[1] + got[2], value[0] + value[1] + value[2], 1e-14, 0);
        CHECK_NEAR(got[0]*got[1]*got[2], value[0]*value[1]*value[2], 1e-13, 0);
        lw_vec3 c = lw_v3_cross(lw_m3_column(&axes, 0), lw_m3_column(&axes, 1));
        CHECK_NEAR(lw_v3_dot(c, lw_m3_column(&axes, 2)), 1, 1e-14, 0);
        lw_quaternion q = lw_quaternion_of_matrix(&axes);
        lw_mat3 back = lw_quaternion_matrix(q);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(back.row[i], axes.row[i])), 0, 1e-14, 0);
        lw_vec3 turn = lw_v3(0.3*k/10, 0.1, -0.2);
        if (lw_v3_norm(turn) < LW_PI)
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(lw_quaternion_vector(lw_quaternion_of_vector(turn)), turn)), 0, 1e-14, 0);
    }
}

/* ---- mobility ---------------------------------------------------------------------------------------------------- */

TEST(mobility_is_real)
{
    /* Bennett, Bricard, Sarrus: mobility 1 against counts of -2, 0, 0 (Hunt 1978); the redundant rows are 6 bodies -
     * rank */
    static const struct { const char *file; int count, freedom, idle, redundant; } known[] = {
        { "bennett", -2, 1, 0, 3 }, { "bricard", 0, 1, 0, 1 }, { "sarrus", 0, 1, 0, 1 }, { "slider-crank", 1, 1, 0, 0 },
        { "delta", 9, 9, 6, 0 }, { "stewart", 6, 6, 0, 0 }, { "arm", 7, 7, 0, 0 }, { "top", 3, 3, 0, 0 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_space_mobility) got = { 0 };
        load_spatial(known[i].file, &m);
        CHECK_OK(lw_space_mobility_find(&m, 1e-12, check_seed(), NULL, &got, &check_error));
        CHECK_INT(got.count, known[i].count);
        CHECK_INT(got.freedom, known[i].freedom);
        CHECK_INT(got.idle, known[i].idle);
        CHECK_INT(got.n_redundant, known[i].redundant);
        CHECK(got.residual < 1e-12 && !got.shaky);
    }
}

/* n four-bars in a row, rods with a ball at one end and a universal joint at the other; or with pins: three rows of each loop
 * depend on the others. */
static void read_space_row(int n, bool pins, lw_spatial *m)
{
    const char *b = pins ? "'revolute', 'axis': [0, 1, 0]" : "'spherical'";
    const char *c = pins ? b : "'universal', 'axis': [0, 0, 1], 'second_axis': [0, 1, 0]";
    FREED char *at = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&at, &size);
    fprintf(f, "{'linkwright': 1, 'joints': [");
    for (int i = 0; i <= n; i++)
        fprintf(f, "%s{'name': 'A%d', 'kind': 'revolute', 'links': ['ground', 'c%d'], 'at': [%d, 0, 0], 'axis': [0, 1, 0]}", i ? ", " : "",
            i, i, i);
    for (int i = 0; i < n; i++)
        fprintf(f, ", {'name': 'B%d', 'kind': %s, 'links': ['c%d', 'r%d'], 'at': [%d, 0, 1]}"
            ", {'name': 'C%d', 'kind': %s, 'links': ['r%d', 'c%d'], 'at': [%d, 0, 1]}",
            i, b, i, i + 1, i, i, c, i + 1, i + 1, i + 1);
    fprintf(f, "], 'input': {'joint': 'A0'}}");
    fclose(f);
    read_spatial(at, "row", m);
}

/* A row of loops moves with one freedom, however long: 4 loops by full matrices, more rows than LW_SPACE_MANY_ROWS by sparse ones (in seconds
 * where full ones take hours). */
TEST(long_rows_of_loops_move)
{
    static const int size[] = { 4, 40, 1000 };
    for (int i = 0; i < 6; i++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_space_mobility) got = { 0 };
        int n = size[i/2], pins = i % 2;
        read_space_row(n, pins, &m);
        CHECK_OK(lw_space_mobility_find(&m, 1e-12, check_seed(), NULL, &got, &check_error));
        CHECK_INT(got.count, 1 - 3*n*pins);
        CHECK_INT(got.freedom, 1);
        CHECK_INT(got.n_redundant, 3*n*pins);
        CHECK(got.moved > 3e-3 && !got.shaky);
    }
}

/* One pin of a long row stands askew by 1e-2: no crank turns any more. */
TEST(a_long_row_with_a_skew_pin_is_rigid)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space_mobility) got = { 0 };
    read_space_row(200, true, &m);
    m.joint[401].axis = lw_v3(1e-2, sqrt(1 - 1e-4), 0);
    CHECK_OK(lw_space_mobility_find(&m, 1e-12, check_seed(), NULL, &got, &check_error));
    CHECK_INT(got.freedom, 0);
    CHECK_INT(got.instant, 0);
}

/* Bennett's condition broken by a part in a thousand: nothing moves. */
TEST(a_broken_bennett_is_rigid)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space_mobility) got = { 0 };
    load_spatial("bennett", &m);
    m.joint[2].axis = lw_v3_add(m.joint[2].axis, lw_v3(1e-3, 0, 0));
    m.joint[2].axis = lw_v3_scale(m.joint[2].axis, 1/lw_v3_norm(m.joint[2].axis));
    CHECK_OK(lw_space_mobility_find(&m, 1e-12, check_seed(), NULL, &got, &check_error));
    CHECK_INT(got.freedom, 0);
}

/* ---- postures ---- */

static lw_status line(void *context, double u, double (*out)[3])
{
    const double (*ends)[3] = context;         /* from, to */
    for (int i = 0; i < 3; i++)
        out[i][0] = ends[0][i] + u*(ends[1][i] - ends[0][i]), out[i][1] = ends[1][i] - ends[0][i], out[i][2] = 0;
    return LW_OK;
}

static double turn_of(const lw_space_follow *f, int joint)
{
    return lw_space_measure(f->z.s, f->z.frame, (lw_spatial_measure){ LW_OF_TURN, joint }, 0, NULL);
}

static lw_status itself(void *context, double u, double (*out)[3])
{
    (void)context;
    out[0][0] = u, out[0][1] = 1, out[0][2] = 0;
    return LW_OK;
}

/* All cranks of a row turn alike, beside flat postures and beyond them too. */
TEST(cranks_of_long_rows_turn_alike)
{
    static const double place[] = { 0.6, 1.5, 4.6, 20 };
    enum { LOOPS = 300 };
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space) s = { 0 };
    OWN(lw_space_follow) f = { 0 };
    read_space_row(LOOPS, false, &m);
    CHECK_OK(lw_space_make(&m, &s, &check_error));
    CHECK_OK(lw_space_follow_make(&s, &(lw_spatial_measure){ LW_OF_TURN, 0 }, 1, false, &f, &check_error));
    for (size_t k = 0; k < sizeof place/sizeof *place; k++) {
        double off[2] = { 0, 0 };
        CHECK_OK(lw_space_follow_to(&f, itself, NULL, place[k], &check_error));
        lw_space_follow_second(&f);
        for (int b = 0; b < s.n_body; b++) {
            const double *w = f.v + 6*b + 3, *a = f.a + 6*b + 3;
            bool crank = m.body[s.link_of[b]].name[0] == 'c';
            off[0] = fmax(off[0], fabs(lw_v3_norm(lw_v3(w[0], w[1], w[2])) - crank));
            off[1] = fmax(off[1], lw_v3_norm(lw_v3(a[0], a[1], a[2])));
        }
        CHECK(off[0] < 1e-8 && off[1] < 1e-7);
    }
}

/* Inverse kinematics of the DELTA (l_u .35, l_l .75, R - r .15; worked out from its closed form), and back. */
TEST(delta_postures)
{
    static const double degrees = 180/LW_PI, start = 13.60812855, other[] = { -6.282352804, 29.88751143, 29.88751143 };
    double ends[2][3] = { { 0, 0, -.65 }, { .2, 0, -.65 } }, motor[3];
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space) s = { 0 };
    OWN(lw_space_follow) f = { 0 };
    lw_error e = { 0 };
    load_spatial("delta", &m);
    CHECK_INT(lw_space_make(&m, &s, &e), LW_OK);
    lw_spatial_measure tool[3] = { { LW_OF_X, 0 }, { LW_OF_Y, 0 }, { LW_OF_Z, 0 } };
    CHECK_INT(lw_space_follow_make(&s, tool, 3, false, &f, &e), LW_OK);
    CHECK_INT(f.n_idle, 6);
    CHECK_INT(lw_space_follow_to(&f, line, ends, 1, &e), LW_OK);
    for (int i = 0; i < 3; i++) {
        motor[i] = turn_of(&f, m.drive[i].index);
        CHECK_NEAR(start + motor[i]*degrees, other[i], 2e-8, 0);
    }
    lw_space_follow_free(&f);
    CHECK_INT(lw_space_follow_make(&s, m.drive, 3, false, &f, &e), LW_OK);
    double back[2][3] = { { 0, 0, 0 }, { motor[0], motor[1], motor[2] } };
    CHECK_INT(lw_space_follow_to(&f, line, back, 1, &e), LW_OK);
    lw_vec3 p = lw_space_point_at(f.z.frame, s.tracer[0]);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(p, lw_v3(.2, 0, -.65))), 0, 1e-14, 0);
    lw_space_follow_free(&f);
    /* the lowest point of its workspace is z = -1.0897247; below it, a bar is too short */
    double deep[2][3] = { { 0, 0, -.65 }, { 0, 0, -1.2 } };
    CHECK_INT(lw_space_follow_make(&s, tool, 3, false, &f, &e), LW_OK);
    CHECK_INT(lw_space_follow_to(&f, line, deep, 1, &e), LW_OPEN);
    CHECK_NEAR(-.65 - .55*f.u, -1.0897247, 1e-6, 0);
    CHECK_HAS(e.text, "open");
}

static lw_status rest_to_rest(void *context, double u, double (*out)[3])
{
    (void)context;
    const double at[3] = { 0.2*u*u*(3 - 2*u), 1.2*u*(1 - u), 1.2 - 2.4*u };
    memset(out, 0, 3*sizeof *out);
    memcpy(out[0], at, sizeof at);
    out[2][0] = -.65;
    return LW_OK;
}

static void count(void *context, const double *q) { (void)q, ++*(int *)context; }

/* The tangent grows from 0 and falls to 0 there, which no short steps need to show. */
TEST(motions_from_rest_to_rest_take_few_steps)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space) s = { 0 };
    OWN(lw_space_follow) f = { 0 };
    lw_spatial_measure tool[3] = { { LW_OF_X, 0 }, { LW_OF_Y, 0 }, { LW_OF_Z, 0 } };
    int steps = 0, rows = 20;
    load_spatial("delta", &m);
    CHECK_OK(lw_space_make(&m, &s, &check_error));
    CHECK_OK(lw_space_follow_make(&s, tool, 3, false, &f, &check_error));
    f.passed = count, f.passed_by = &steps;
    for (int k = 1; k <= rows; k++)
        CHECK_OK(lw_space_follow_to(&f, rest_to_rest, NULL, (double)k/rows, &check_error));
    CHECK(steps >= rows && steps <= rows + 5);
    CHECK_NEAR(13.60812855 + turn_of(&f, m.drive[0].index)*180/LW_PI, -6.282352804, 2e-8, 0);
}

/* Rates of tracers against central differences, of every example with motions. */
typedef struct series { int n; lw_vec3 place[64], velocity[64], acceleration[64]; double alpha[64], omega[64]; } series;

static lw_status collect(void *context, double u, const double *input, const lw_space_tracer *t)
{
    series *s = context;
    (void)u, (void)input;
    s->place[s->n] = t[0].place, s->velocity[s->n] = t[0].velocity, s->acceleration[s->n] = t[0].acceleration;
    s->n++;
    return LW_OK;
}

TEST(rates_are_derivatives)
{
    static const char *const files[] = { "slider-crank", "bricard", "bennett", "sarrus", "delta", "stewart", "arm" };
    for (size_t k = 0; k < sizeof files/sizeof *files; k++) {
        OWN(lw_spatial) m = { 0 };
        series got = { 0 };
        load_spatial(files[k], &m);
        bool in_time = m.input[0].motion != NULL;
        double from = in_time ? 0.004 : 0.1, h = 1e-3;
        lw_space_trace o = { .in_time = in_time, .from = from, .to = from + 40*h, .intervals = 40 };
        CHECK_OK(lw_space_trace_run(&m, &o, collect, &got, &check_error));
        for (int i = 2; i + 2 < got.n; i++) {
            lw_vec3 v = lw_v3_scale(lw_v3_sub(lw_v3_scale(lw_v3_sub(got.place[i + 1], got.place[i - 1]), 8),
                                              lw_v3_sub(got.place[i + 2], got.place[i - 2])), 1/(12*h));
            lw_vec3 a = lw_v3_scale(lw_v3_sub(lw_v3_scale(lw_v3_sub(got.velocity[i + 1], got.velocity[i - 1]), 8),
                                              lw_v3_sub(got.velocity[i + 2], got.velocity[i - 2])), 1/(12*h));
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(v, got.velocity[i])), 0, 1e-9, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(a, got.acceleration[i])), 0, 1e-8, 0);
        }
    }
}

/* Bricard's linkage turns from -30 to 210 degrees of its first hinge, where it folds. */
TEST(bricard_has_limits)
{
    OWN(lw_spatial) m = { 0 };
    series got = { 0 };
    load_spatial("bricard", &m);
    lw_space_trace o = { .whole = true, .intervals = 12 };
    CHECK_OK(lw_space_trace_run(&m, &o, collect, &got, &check_error));
    CHECK(o.limit[0] && o.limit[1]);
    CHECK_NEAR(o.from, -LW_PI/6, 1e-12, 0);
    CHECK_NEAR(o.to, 7*LW_PI/6, 1e-12, 0);
    for (int end = 0; end < 13; end += 12) {                  /* rates do not exist there */
        CHECK_NEAR(fabs(got.place[end].x), sqrt(0.75), 1e-9, 0);
        CHECK(isnan(got.velocity[end].x) && isnan(got.acceleration[end].z));
    }
}
