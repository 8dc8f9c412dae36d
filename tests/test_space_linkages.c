/* Overconstrained linkages in space, by Denavit and Hartenberg's parameters: mobility, postures over their whole motion against closed
 * forms, runs in time.
 *
 *     Bennett 1903         a, alpha, b, beta, sin(alpha)/a = sin(beta)/b;  tan(t1/2) tan(t2/2) = sin((beta + alpha)/2)/sin((beta - alpha)/2)
 *     Goldberg 1943        two of them with one link in common, which is left out: 5R
 *     Myard 1931           two of them, each with a twist of 90 degrees, mirrored: 5R, symmetric to a plane
 *     Waldron 1968         two of them on one axis, whose pin is left out: 6R
 *     Altmann 1954         6R with two lengths, all neighbours at right angles
 *     Schatz 1942          six axes at right angles to their neighbours but for two parallel ones (Phillips 1990)
 *     Bricard 1897         line-symmetric, plane-symmetric 6R
 *     Bricard 1897         flexible octahedra
 *     RCCC                 turns of a spherical four-bar; slides without bound at its limits
 *     Sarrus, Bennett's own example files: test_spatial.c */
#include <string.h>

#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"
#include "mbs/space/space_adjust.h"
#include "mbs/space/space_mobility.h"
#include "mbs/space/space_trace.h"
#include "tests/spatial_models.h"

/* Frame of a joint: z its axis, x along the normal from the joint before. */
typedef struct frame { lw_vec3 at, x, z; } frame;

static lw_vec3 turned(lw_vec3 v, lw_vec3 about, double angle)        /* v square to the axis */
{
    return lw_v3_add(lw_v3_scale(v, cos(angle)), lw_v3_scale(lw_v3_cross(about, v), sin(angle)));
}

static frame next(frame f, double turn, double offset, double length, double twist)
{
    f.x = turned(f.x, f.z, turn);
    f.at = lw_v3_add(f.at, lw_v3_add(lw_v3_scale(f.z, offset), lw_v3_scale(f.x, length)));
    f.z = turned(f.z, f.x, twist);
    f.z = lw_v3_scale(f.z, 1/lw_v3_norm(f.z));               /* rounding does not grow along a row of loops */
    f.x = lw_v3_sub(f.x, lw_v3_scale(f.z, lw_v3_dot(f.x, f.z)));
    f.x = lw_v3_scale(f.x, 1/lw_v3_norm(f.x));
    return f;
}

static const frame origin = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 } };

/* How far the chain of n links is from closing at these turns: places, directions. */
static double gap(int n, const double *length, const double *twist, const double *offset, const double *turn)
{
    frame f = origin;
    for (int i = 0; i < n; i++)
        f = next(f, turn[i], offset[i], length[i], twist[i]);
    return lw_v3_norm(f.at) + lw_v3_norm(lw_v3_sub(f.x, origin.x)) + lw_v3_norm(lw_v3_sub(f.z, origin.z));
}

typedef struct axis { frame f; const char *kind; char link[2][8]; } axis;

static axis pin(frame f, const char *from, int i, const char *to, int k)
{
    axis a = { .f = f, .kind = "revolute" };
    snprintf(a.link[0], sizeof a.link[0], i < 0 ? "ground" : "%s%d", from, i);
    snprintf(a.link[1], sizeof a.link[1], k < 0 ? "ground" : "%s%d", to, k);
    return a;
}

/* The model with joints J0 .. and masses; J0 is the input. */
static void make_model(int n, const axis *a, bool runs, lw_spatial *m)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    fputs("{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground'", f);
    for (int i = 0; i < n; i++)              /* each link where it comes second first */
        for (int k = 0; k <= i; k++)
            if (strcmp(a[k].link[1], a[i].link[1]) == 0) {
                if (k == i && strcmp(a[i].link[1], "ground") != 0)
                    fprintf(f, ", {'name': '%s', 'mass': %g, 'centre': [%.17g, %.17g, %.17g], 'inertia': [0.02, 0.03, 0.025]}", a[i].link[1],
                            1 + 0.1*i, a[i].f.at.x + 0.1, a[i].f.at.y - 0.2, a[i].f.at.z + 0.15);
                break;
            }
    fprintf(f, "], 'input': {'joint': 'J0'%s}, 'joints': [", runs ? ", 'speed': 3" : "");
    for (int i = 0; i < n; i++)
        fprintf(f, "%s{'name': 'J%d', 'kind': '%s', 'links': ['%s', '%s'], 'at': [%.17g, %.17g, %.17g], 'axis': [%.17g, %.17g, %.17g]}",
                i ? ", " : "", i, a[i].kind, a[i].link[0], a[i].link[1], a[i].f.at.x, a[i].f.at.y, a[i].f.at.z, a[i].f.z.x, a[i].f.z.y, a[i].f.z.z);
    fputs("]}", f);
    fclose(f);
    read_spatial(text, "linkage", m);
}

static lw_status see_place(void *context, double u, const double *input, const lw_space_tracer *t)
{
    (void)u, (void)input;
    lw_vec3 **to = context;
    *(*to)++ = t->place;
    return LW_OK;
}

static lw_vec3 rounded(lw_vec3 v, double by, lw_rng *rng)
{
    return lw_v3_add(v, lw_v3(lw_rng_range(rng, -by, by), lw_rng_range(rng, -by, by), lw_rng_range(rng, -by, by)));
}

/* With a tracer on the link behind joint 1. */
static void make_traced(int n, const axis *a, lw_vec3 at, lw_spatial *m)
{
    make_model(n, a, false, m);
    free(m->tracer);
    m->tracer = calloc(1, sizeof *m->tracer);
    m->n_tracer = 1;
    m->tracer[0] = (lw_spatial_tracer){ .name = "P", .link = m->joint[1].link[1], .at = at, .frame = { 1, 0, 0, 0 } };
}

/* Drawn with rounded numbers it is adjusted by less than twice as much, and its middle goes where that of the exact one goes. */
static void check_rounded(int n, const axis *exact, double by, lw_rng rng)
{
    enum { ROWS = 5 };
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space_adjusted) adjusted = { 0 };
    OWN(lw_space_mobility) got = { 0 };
    lw_vec3 place[2][ROWS];
    axis a[16];
    make_traced(n, exact, exact[2].f.at, &m);
    lw_vec3 *to = place[0];
    lw_space_trace t = { .from = -0.2, .to = 0, .intervals = ROWS - 1 };
    if (lw_space_trace_run(&m, &t, see_place, &to, &check_error) != LW_OK) {       /* a limit is near on that side */
        to = place[0];
        t = (lw_space_trace){ .from = 0, .to = 0.2, .intervals = ROWS - 1 };
        CHECK_OK(lw_space_trace_run(&m, &t, see_place, &to, &check_error));
    }
    CHECK(t.moved == 0 && t.turned == 0);
    lw_spatial_free(&m);
    for (int i = 0; i < n; i++) {
        a[i] = exact[i];
        a[i].f.at = rounded(a[i].f.at, by, &rng);
        a[i].f.z = rounded(a[i].f.z, by, &rng);
    }
    make_traced(n, a, exact[2].f.at, &m);
    to = place[1];
    CHECK_OK(lw_space_trace_run(&m, &t, see_place, &to, &check_error));
    CHECK(t.open < 1e-12);
    CHECK(t.moved > 0.1*by && t.moved < 2*by && t.turned > 0.1*by && t.turned < 2*by);
    for (int i = 0; i < ROWS; i++)
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(place[0][i], place[1][i])), 0, 20*by, 0);
    CHECK_OK(lw_space_adjust(&m, &adjusted, &check_error));
    CHECK_OK(lw_space_mobility_find(&adjusted.model, 1e-12, check_seed(), NULL, &got, &check_error));
    CHECK_INT(got.freedom, 1);
}

static void check_mobility(int n, const axis *a, int count, int redundant)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space_mobility) got = { 0 };
    make_model(n, a, false, &m);
    CHECK_OK(lw_space_mobility_find(&m, 1e-12, check_seed(), NULL, &got, &check_error));
    CHECK_INT(got.count, count);
    CHECK_INT(got.freedom, 1);
    CHECK_INT(got.n_redundant, redundant);
    CHECK(!got.shaky && got.residual < 1e-12);
    for (double by = 1e-6; redundant > 0 && n <= 16 && by < 2e-3; by *= 10)
        check_rounded(n, a, by, check_rng((uint64_t)n));
}

typedef struct seen { double off, off_rate, energy[2]; bool unique; } seen;

static lw_status watch(void *context, const lw_moment *m)
{
    seen *s = context;
    double energy = m->kinetic + m->potential;
    s->off = fmax(s->off, m->off);
    s->off_rate = fmax(s->off_rate, m->off_rate);
    s->energy[0] = fmin(s->energy[0], energy);
    s->energy[1] = fmax(s->energy[1], energy);
    s->unique = s->unique && m->unique;
    return LW_OK;
}

/* In time: joints closed to 1e-12, energy kept, and reactions said not to be unique, at rest too. */
static void check_motion(int n, const axis *a, int redundant)
{
    static const lw_formulation way[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_RADAU, LW_FORMULATION_CVODE };
    OWN(lw_spatial) m = { 0 };
    lw_dynamics *d;
    make_model(n, a, true, &m);
    for (size_t i = 0; i < sizeof way/sizeof *way; i++) {
        lw_dynamics_options o = lw_dynamics_options_default();
        lw_dynamics_report r;
        seen s = { .energy = { INFINITY, -INFINITY }, .unique = true };
        o.formulation = way[i];
        o.to = 1;
        o.intervals = 4;
        CHECK_OK(lw_dynamics_make_spatial(&m, &o, &d, &check_error));
        CHECK_SILENT(lw_dynamics_analyse(d, watch, &s, &r, NULL, &check_error));
        CHECK_INT(r.freedom, 1);
        CHECK_INT(r.redundant, redundant);
        CHECK(s.off < 1e-12 && s.off_rate < 1e-11);
        CHECK(s.energy[1] - s.energy[0] < (i < 3 ? 1e-9 : 1e-6)*r.energy_scale);
        lw_dynamics_free(d);
    }
}

/* The turns of all joints while the first one turns by `to`, in `steps`. */
typedef void on_turns(void *context, const double *turn);

static lw_status own_value(void *context, double u, double (*out)[3])
{
    (void)context;
    out[0][0] = u, out[0][1] = 1, out[0][2] = 0;
    return LW_OK;
}

static void turn_input(int n, const axis *a, double to, int steps, on_turns *see, void *context)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space) s = { 0 };
    OWN(lw_space_follow) f = { 0 };
    double *turn = calloc((size_t)n, sizeof *turn), *near = calloc((size_t)n, sizeof *near);
    make_model(n, a, false, &m);
    CHECK_OK(lw_space_make(&m, &s, &check_error));
    CHECK_OK(lw_space_follow_make(&s, &m.input[0].measure, 1, false, &f, &check_error));
    for (int k = 1; k <= steps; k++) {
        CHECK_SILENT(lw_space_follow_to(&f, own_value, NULL, to*k/steps, &check_error));
        lw_space_place(&s, f.q, f.z.frame);
        lw_space_count_turns(&s, f.z.frame, near);
        see(context, near);
    }
    free(turn), free(near);
}

/* ---- Bennett ------------------------------------------------------------------------------------------------------ */

typedef struct bennett { double a, alpha, b, beta, k, turn[4]; frame f[5]; } bennett;

/* The loop from a frame on, whose first turn is t. */
static bennett make_bennett(double a, double alpha, double b, double t, frame from)
{
    bennett l = { .a = a, .alpha = alpha, .b = b, .beta = asin(b*sin(alpha)/a) };
    l.k = sin((l.beta + alpha)/2)/sin((l.beta - alpha)/2);
    l.turn[0] = t, l.turn[1] = 2*atan(l.k/tan(t/2)), l.turn[2] = -t, l.turn[3] = -l.turn[1];
    l.f[0] = from;
    for (int i = 0; i < 4; i++)
        l.f[i + 1] = next(l.f[i], l.turn[i], 0, i%2 ? b : a, i%2 ? l.beta : alpha);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(l.f[4].at, from.at)) + lw_v3_norm(lw_v3_sub(l.f[4].z, from.z)), 0, 1e-14, 0);
    return l;
}

enum { LOOPS = 6 };
typedef struct chain { int n; bennett l; int seen; } chain;

static void see_chain(void *context, const double *turn)
{
    chain *c = context;
    for (int k = 0; k < c->n; k++) {         /* the crank of loop k is joint 3 k, or joint 0; both ways of Bennett's relation */
        double first = c->l.turn[0] + (k ? -turn[3*k] : turn[0]), second = c->l.turn[1] + turn[3*k + 1];
        CHECK_NEAR(sin(first/2)*sin(second/2) - c->l.k*cos(first/2)*cos(second/2), 0, 1e-10, 0);
        CHECK_NEAR(turn[3*k + 2], k ? turn[3*k] : -turn[0], 1e-9, 0);
        CHECK_NEAR(turn[3*k + 3], -turn[3*k + 1], 1e-9, 0);
    }
    c->seen++;
}

/* Loops in a row, each turned by the crank of the one before: one freedom, 3 rows too many in each. */
TEST(bennetts_in_a_row)
{
    axis a[3*LOOPS + 1];
    frame from = origin;
    chain c = { 0 };
    for (int k = 0; k < LOOPS; k++) {
        c.l = make_bennett(1, 1.2, 0.6, 0.9, from);
        if (k == 0)
            a[0] = pin(c.l.f[0], "g", -1, "c", 0);
        a[3*k + 1] = pin(c.l.f[1], "c", k, "m", k);
        a[3*k + 2] = pin(c.l.f[2], "m", k, "c", k + 1);
        a[3*k + 3] = pin(c.l.f[3], "c", k + 1, "g", -1);
        from = c.l.f[3];
        from.x = turned(from.x, from.z, 0.4);
        c.n = k + 1;
        if (k == 0 || k == 2 || k == LOOPS - 1) {
            check_mobility(3*c.n + 1, a, 1 - 3*c.n, 3*c.n);
            check_motion(3*c.n + 1, a, 3*c.n);
            c.seen = 0;
            turn_input(3*c.n + 1, a, 2*LW_PI, 60, see_chain, &c);
            CHECK_INT(c.seen, 60);
        }
    }
}

static void see_goldberg(void *context, const double *turn)
{
    const bennett *l = context;
    double t[4] = { l[0].turn[0] + turn[0], l[0].turn[1] + turn[1], l[1].turn[2] - turn[4], l[1].turn[3] - turn[3] };
    for (int i = 0; i < 2; i++)
        CHECK_NEAR(sin(t[2*i]/2)*sin(t[2*i + 1]/2) - l[i].k*cos(t[2*i]/2)*cos(t[2*i + 1]/2), 0, 1e-10, 0);
}

/* Link 34 of the first loop is link 12 of the second; the ground is link 41 of the first and link 23 of the second. */
TEST(goldberg)
{
    bennett l[2] = { make_bennett(1, 1.2, 0.6, 0.9, origin) };
    frame from = l[0].f[2];
    from.x = turned(from.x, from.z, l[0].turn[2] - 1.3);
    l[1] = make_bennett(1, 1.2, 0.45, 1.3, from);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(l[1].f[1].z, l[0].f[3].z)) + lw_v3_norm(lw_v3_sub(l[1].f[1].at, l[0].f[3].at)), 0, 1e-14, 0);
    axis a[] = { pin(l[0].f[0], "g", -1, "l", 0), pin(l[0].f[1], "l", 0, "l", 1), pin(l[0].f[2], "l", 1, "l", 2),
                 pin(l[1].f[3], "l", 2, "l", 3), pin(l[1].f[2], "l", 3, "g", -1) };
    check_mobility(5, a, -1, 2);
    check_motion(5, a, 2);
    turn_input(5, a, 2*LW_PI, 60, see_goldberg, l);
}

/* ---- six pins -------------------------------------------------------------------------------------------------------- */

/* A loop by its parameters, and the range of the turn of its last joint. */
typedef struct loop { int n; double length[6], twist[6], offset[6], turn[6]; double least, most; } loop;

static void see_loop(void *context, const double *turn)
{
    loop *s = context;
    double all[6];
    for (int i = 0; i < s->n; i++)
        all[i] = s->turn[i] + turn[i];
    CHECK_NEAR(gap(s->n, s->length, s->twist, s->offset, all), 0, 1e-10, 0);
    s->least = fmin(s->least, turn[s->n - 1]);
    s->most = fmax(s->most, turn[s->n - 1]);
}

static void ring(int n, const frame *f, axis *a)
{
    for (int i = 0; i < n; i++)
        a[i] = pin(f[i], i ? "l" : "g", i - 1, i < n - 1 ? "l" : "g", i < n - 1 ? i : -1);
}

/* The posture was found by closing the chain. */
static void check_loop(loop *s, int redundant, double to)
{
    frame f[7] = { origin };
    axis a[6];
    for (int i = 0; i < s->n; i++)
        f[i + 1] = next(f[i], s->turn[i], s->offset[i], s->length[i], s->twist[i]);
    CHECK_NEAR(gap(s->n, s->length, s->twist, s->offset, s->turn), 0, 1e-14, 0);
    ring(s->n, f, a);
    check_mobility(s->n, a, s->n - 6, redundant);
    check_motion(s->n, a, redundant);
    turn_input(s->n, a, to, 90, see_loop, s);
}

/* The inversion of the trihedral Bricard linkage by Schatz (Turbula): both shafts turn round and round. */
TEST(schatz_turns)
{
    loop s = { 6, { 0, 1, 1, 1, 0, sqrt(3) }, { LW_PI/2, LW_PI/2, LW_PI/2, LW_PI/2, LW_PI/2, 0 }, { 0.37, 0, 0, 0, 0, -0.37 },
               { 0.7, 2.2947778426653254, -1.6801651936623394, -1.4479630317408574, -0.7307137299637271, 2.6058768592693617 }, 0, 0 };
    check_loop(&s, 1, 2*LW_PI);
    CHECK_NEAR(s.most - s.least, 2*LW_PI, 1e-9, 0);
}

TEST(myard)
{
    double twist = 0.9;                      /* the common length of the Bennett linkages is 1, the other sin(twist) */
    loop s = { 5, { sin(twist), 1, 0, 1, sin(twist) }, { twist, LW_PI/2, LW_PI - 2*twist, LW_PI/2, LW_PI - twist }, { 0 },
               { 1.1, 2.0278872101479504, 1.0207963267948965, -2.120796326794897, -2.0278872101479504 }, 0, 0 };
    check_loop(&s, 2, 2*LW_PI);
}

/* Through the posture whose first turn is 0, which is singular: the 45th of 90 steps. */
TEST(altmann)
{
    loop s = { 6, { 1, 0, 0.7, 1, 0, 0.7 }, { LW_PI/2, LW_PI/2, 1.5*LW_PI, LW_PI/2, LW_PI/2, 1.5*LW_PI }, { 0 },
               { 1, -0.6567584273665714, -2.646732981101197, -1, 0.6567584273665714, 2.646732981101197 }, 0, 0 };
    check_loop(&s, 1, -2);
}

static void see_waldron(void *context, const double *turn)
{
    const bennett *l = context;
    double t[2][2] = { { l[0].turn[1] + turn[0], l[0].turn[2] + turn[1] }, { l[1].turn[1] - turn[5], l[1].turn[2] - turn[4] } };
    for (int i = 0; i < 2; i++)
        CHECK_NEAR(sin(t[i][0]/2)*sin(t[i][1]/2) + l[i].k*cos(t[i][0]/2)*cos(t[i][1]/2), 0, 1e-10, 0);
    CHECK_NEAR(turn[4], -turn[1], 1e-10, 0);
}

/* Two Bennett linkages on one axis turn alike about it, so its pin is not needed. */
TEST(waldron)
{
    bennett l[2] = { make_bennett(1, 1.2, 0.6, 0.9, origin) };
    frame from = { { 0, 0, 0.6 }, { cos(0.4), sin(0.4), 0 }, { 0, 0, 1 } };
    l[1] = make_bennett(0.8, 0.9, 0.5, 1.7, from);
    axis a[6];
    frame f[6] = { l[0].f[1], l[0].f[2], l[0].f[3], l[1].f[3], l[1].f[2], l[1].f[1] };
    ring(6, f, a);
    check_mobility(6, a, 0, 1);
    for (uint64_t seed = 4; seed < 13; seed += 4) {       /* rounded so, it leads to neither motion where two nearly meet, few steps from the posture */
        lw_rng near_branch;
        lw_rng_seed(&near_branch, seed, 6);
        check_rounded(6, a, 1e-3, near_branch);
    }
    check_motion(6, a, 1);
    turn_input(6, a, 1, 40, see_waldron, l);
}

static lw_vec3 unit(double x, double y, double z)
{
    lw_vec3 v = lw_v3(x, y, z);
    return lw_v3_scale(v, 1/lw_v3_norm(v));
}

static void see_symmetric(void *context, const double *turn)
{
    if (context) {                           /* a half turn about z takes joint i to joint i + 3 */
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(turn[i + 3], turn[i], 1e-10, 0);
    } else {                                 /* the mirror takes joint 1 to 5 and 2 to 4; going round the other way, and a turn mirrored */
        CHECK_NEAR(turn[5], turn[1], 1e-10, 0);
        CHECK_NEAR(turn[4], turn[2], 1e-10, 0);
    }
}

TEST(symmetric_bricards)
{
    frame f[6];
    axis a[6];
    /* axes 0 and 3 in the plane x = 0, 1 and 2 anywhere, 5 and 4 their images (axes are pseudovectors) */
    f[0] = (frame){ .at = { 0, 0, 0 }, .z = unit(0, 0.3, 1) }, f[3] = (frame){ .at = { 0, 1.2, 0.2 }, .z = unit(0, 1, 0.4) };
    f[1] = (frame){ .at = { 0.6, 0.1, 0.3 }, .z = unit(0.2, 1, 0.5) }, f[2] = (frame){ .at = { 0.7, 0.9, -0.2 }, .z = unit(1, 0.3, 0.6) };
    for (int i = 1; i < 3; i++)
        f[6 - i] = (frame){ .at = { -f[i].at.x, f[i].at.y, f[i].at.z }, .z = lw_v3(-f[i].z.x, f[i].z.y, f[i].z.z) };
    ring(6, f, a);
    check_mobility(6, a, 0, 1);
    check_motion(6, a, 1);
    turn_input(6, a, 2*LW_PI, 60, see_symmetric, NULL);
    /* three axes anywhere and their images by a half turn about z */
    f[0] = (frame){ .at = { 0.5, 0.1, 0 }, .z = unit(0.1, 0.2, 1) }, f[1] = (frame){ .at = { 0.9, 0.7, 0.4 }, .z = unit(1, 0.3, 0.2) };
    f[2] = (frame){ .at = { 0.1, 1, 0.8 }, .z = unit(0.2, -1, 0.3) };
    for (int i = 0; i < 3; i++)
        f[i + 3] = (frame){ .at = { -f[i].at.x, -f[i].at.y, f[i].at.z }, .z = lw_v3(-f[i].z.x, -f[i].z.y, f[i].z.z) };
    ring(6, f, a);
    check_mobility(6, a, 0, 1);
    check_motion(6, a, 1);
    turn_input(6, a, -1.5, 30, see_symmetric, a);
}

/* Flexible octahedra (Bricard 1897, kinds with a line and a plane of symmetry): six of their faces, hinged at edges that meet in threes.  All edges
 * keep their lengths as they move.  Vertices are A, B, C and a, b, c opposite to them; face k has the vertices of face[k]. */
static const char *const face[6] = { "ABc", "aBc", "aBC", "abC", "AbC", "Abc" };

typedef struct octahedron { lw_vec3 vertex[6]; int rows; double off; } octahedron;

static lw_status see_octahedron(void *context, double u, const double *input, const lw_space_tracer *t)
{
    octahedron *o = context;                 /* tracers: 18 vertices of the faces in turn */
    (void)u, (void)input;
    for (int i = 0; i < 18; i++)
        for (int k = 0; k < i; k++) {
            int a = face[i/3][i%3] - 'A', b = face[k/3][k%3] - 'A';
            a = a < 3 ? a : a - 29, b = b < 3 ? b : b - 29;      /* a, b, c are 3, 4, 5 */
            if (abs(a - b) == 3)
                continue;                    /* a diagonal */
            double length = lw_v3_norm(lw_v3_sub(o->vertex[a], o->vertex[b])), now = lw_v3_norm(lw_v3_sub(t[i].place, t[k].place));
            o->off = fmax(o->off, fabs(now - length));
        }
    o->rows++;
    return LW_OK;
}

static void check_octahedron(octahedron *o)
{
    axis a[6];
    OWN(lw_spatial) m = { 0 };
    lw_error e = { 0 };
    for (int i = 0; i < 6; i++) {            /* the two vertices that a face shares with the next */
        lw_vec3 end[2];
        int n = 0;
        for (const char *p = face[i]; *p; p++)
            if (strchr(face[(i + 1)%6], *p))
                end[n++] = o->vertex[*p < 'a' ? *p - 'A' : *p - 'a' + 3];
        lw_vec3 z = lw_v3_sub(end[1], end[0]);
        a[i] = pin((frame){ .at = end[0], .z = lw_v3_scale(z, 1/lw_v3_norm(z)) }, i ? "l" : "g", i - 1, i < 5 ? "l" : "g", i < 5 ? i : -1);
    }
    make_model(6, a, false, &m);
    free(m.tracer);
    m.tracer = calloc(18, sizeof *m.tracer);
    m.n_tracer = 18;
    for (int i = 0; i < 18; i++) {
        char c = face[i/3][i%3];
        m.tracer[i] = (lw_spatial_tracer){ .link = i < 3 ? m.ground : m.joint[i/3 - 1].link[1], .at = o->vertex[c < 'a' ? c - 'A' : c - 'a' + 3], .frame = { 1, 0, 0, 0 } };
        snprintf(m.tracer[i].name, sizeof m.tracer[i].name, "P%d", i);
    }
    lw_space_trace t = { .whole = true, .intervals = 12 };
    lw_status st = lw_space_trace_run(&m, &t, see_octahedron, o, &e);
    CHECK(st == LW_OK || (st == LW_OPEN && strstr(e.text, "singular posture")));     /* one that is flat ends there */
    CHECK(o->off < 1e-11);
}

TEST(flexible_octahedra)
{
    static const lw_vec3 hard[2][3] = { { { 0.1, 0.5, 0.49 }, { 0.73, -0.43, 0.93 }, { 0.13, 0.49, 0.51 } },
        { { 0.87710038839959137, -0.093367333918416451, 0.86081796417577339 }, { 0.73486287239502923, -0.56993818883367076, 0.87553911522781225 },
          { -0.83809853244844801, 0.31786879397896639, -0.9114789031699817 } } };       /* a basis of its rows found in one posture is bad in others */
    octahedron o = { 0 };
    int rows = 0;
    lw_rng rng = check_rng(6);
    for (int n = 0; n < 40; n++) {
        for (int i = 0; i < 3; i++) {
            lw_vec3 *v = o.vertex + i;
            if (n == 0 || n == 2)
                *v = hard[n/2][i];
            else
                *v = lw_v3(lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1));
            v[3] = n%2 ? lw_v3(-v->x, v->y, v->z) : lw_v3(-v->x, -v->y, v->z);
        }
        if (n%2) {                           /* two opposite vertices in the plane */
            o.vertex[2].x = 0;
            o.vertex[5] = lw_v3(0, lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1));
        }
        o.rows = 0, o.off = 0;
        check_octahedron(&o);
        rows += o.rows;
    }
    CHECK(rows > 35*13);
}

/* ---- Wren's platform -------------------------------------------------------------------------------------------------- */

/* Six equal legs between equal hexagons, the upper one turned: they are lines of one hyperboloid, of rank 3 in every posture of the screw
 * motion, which is the only one.  Each leg spins, too. */
TEST(wren)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    OWN(lw_spatial) m = { 0 };
    OWN(lw_space_mobility) got = { 0 };
    fputs("{'linkwright': 1, 'links': ['ground', 'platform'", f);
    for (int i = 0; i < 6; i++)
        fprintf(f, ", 'l%d'", i);
    fputs("], 'joints': [", f);
    for (int i = 0; i < 12; i++)
        fprintf(f, "%s{'name': 'J%d', 'kind': 'spherical', 'links': ['%s', 'l%d'], 'at': [%.17g, %.17g, %d]}", i ? ", " : "", i,
                i%2 ? "platform" : "ground", i/2, cos(i/2*LW_PI/3 + i%2*0.5), sin(i/2*LW_PI/3 + i%2*0.5), i%2);
    fputs("]}", f);
    fclose(f);
    read_spatial(text, "wren", &m);
    free(text);
    CHECK_OK(lw_space_mobility_find(&m, 1e-12, check_seed(), NULL, &got, &check_error));
    CHECK_INT(got.idle, 6);
    CHECK_INT(got.freedom, 7);
    CHECK_INT(got.instant, 9);
}

/* ---- singular postures ------------------------------------------------------------------------------------------------ */

/* A parallelogram in space whose crank turns by 2 t from upright, beside and through its flat postures: the coupler's centre moves in a circle. */
static const char parallelogram[] = "{'linkwright': 1, 'gravity': [0, -9.81, 0], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5, 0], "
    "'inertia': [0.1, 0.1, 0.1]}, {'name': 'b', 'mass': 1, 'centre': [1, 1, 0], 'inertia': [0.1, 0.1, 0.1]}, {'name': 'c', 'mass': 1, 'centre': [2, 0.5, "
    "0], 'inertia': [0.1, 0.1, 0.1]}], 'joints': [{'name': 'A', 'kind': 'r', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'B', "
    "'kind': 'r', 'links': ['a', 'b'], 'at': [0, 1, 0], 'axis': [0, 0, 1]}, {'name': 'C', 'kind': 'r', 'links': ['b', 'c'], 'at': [2, 1, 0], 'axis': [0, "
    "0, 1]}, {'name': 'D', 'kind': 'r', 'links': ['c', 'ground'], 'at': [2, 0, 0], 'axis': [0, 0, 1]}], 'input': {'joint': 'A', 'motion': '2*t'}, "
    "'tracers': [{'name': 'P', 'link': 'b', 'at': [1, 1, 0]}]}";

static lw_status see_circle(void *context, double u, const double *input, const lw_space_tracer *tracer)
{
    (void)input;
    double s = sin(2*u), c = cos(2*u);       /* rates by the time */
    lw_vec3 off[3] = { lw_v3_sub(tracer->place, lw_v3(1 - s, c, 0)), lw_v3_sub(tracer->velocity, lw_v3(-2*c, -2*s, 0)), lw_v3_sub(tracer->acceleration, lw_v3(4*s, -4*c, 0)) };
    CHECK_NEAR(lw_v3_norm(off[0]), 0, 1e-12, 0);
    CHECK_NEAR(lw_v3_norm(off[1]), 0, 1e-10, 0);
    CHECK_NEAR(lw_v3_norm(off[2]), 0, 2e-8, 0);
    ++*(int *)context;
    return LW_OK;
}

typedef struct push { int seen, empty; double crossed; lw_dynamics *d; } push;

/* The crank carries the weights of two cranks at half and of a coupler at full radius.  Near a flat posture the torque of 9.81 N m of the
 * other crank and half the coupler comes through the coupler, whose lever is the distance from the posture. */
static lw_status see_push(void *context, const lw_moment *m)
{
    push *p = context;
    lw_space_moment out;
    CHECK_OK(lw_dynamics_space_moment(p->d, m, &out, &check_error));
    CHECK_NEAR(out.drive[0], -2*9.81*sin(2*m->t), 1e-8, 0);
    double beside = fabs(cos(2*m->t)), x = out.joint[0].force.x;
    p->empty += !isfinite(x);
    if (isfinite(x) && beside < 0.05)
        CHECK_NEAR(fabs(x)*beside, 9.81, 2e-2*9.81, 0);
    p->seen++;
    return LW_OK;
}

TEST(beside_flat_postures)
{
    static const double beside[] = { 0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 0.1 };
    OWN(lw_spatial) m = { 0 };
    read_spatial(parallelogram, "parallelogram", &m);
    for (size_t i = 0; i < sizeof beside/sizeof *beside; i++)
        for (int side = -1; side < 2; side += 2) {
            double to = LW_PI/4 + side*beside[i]/2;
            int rows = 0;
            lw_space_trace t = { .in_time = true, .from = 0, .to = to, .intervals = 1 };
            CHECK_SILENT(lw_space_trace_run(&m, &t, see_circle, &rows, &check_error));
            CHECK_INT(rows, 2);
            push p = { 0 };
            lw_dynamics_report r;
            lw_dynamics_options o = lw_dynamics_options_default();
            o.to = to;
            o.intervals = 1;
            CHECK_OK(lw_dynamics_make_spatial(&m, &o, &p.d, &check_error));
            CHECK_SILENT(lw_dynamics_analyse(p.d, see_push, &p, &r, NULL, &check_error));
            CHECK_INT(p.seen, 2);
            CHECK_INT(p.empty, beside[i] < 1e-8);
            CHECK_INT(r.without_forces, p.empty);
            lw_dynamics_free(p.d);
        }
}

/* ---- RCCC -------------------------------------------------------------------------------------------------------------- */

typedef struct spherical { double twist[4], turn[4]; } spherical;

static void see_rccc(void *context, const double *turn)
{
    const spherical *s = context;
    static const double none[4] = { 0 };
    double all[4];
    for (int i = 0; i < 4; i++)
        all[i] = s->turn[i] + turn[i];
    CHECK_NEAR(gap(4, none, s->twist, none, all), 0, 1e-10, 0);
}

/* Its turns are those of the spherical four-bar of the same twists (Kotelnikov's principle of transference), a crank-rocker. */
TEST(rccc_turns_as_a_spherical_four_bar)
{
    spherical s = { .twist = { 0.5, 1.1, 1.2, 1.3 } };
    double length[4] = { 0.3, 1, 0.8, 1.1 }, offset[4] = { 0.1, -0.2, 0.3, 0.2 }, c;
    frame f[5] = { origin };
    axis a[4];
    /* close the directions by hand: the axes 2 and 3 lie where the arcs of 1.1 and 1.2 meet */
    lw_vec3 z0 = lw_v3(0, 0, 1), z1 = lw_v3(sin(0.5), 0, cos(0.5)), z3 = lw_v3(sin(1.3)*cos(1.1), sin(1.3)*sin(1.1), cos(1.3)), z2;
    double d = lw_v3_dot(z1, z3), p = (cos(1.1) - d*cos(1.2))/(1 - d*d), q = (cos(1.2) - d*cos(1.1))/(1 - d*d);
    lw_vec3 in = lw_v3_add(lw_v3_scale(z1, p), lw_v3_scale(z3, q)), n = lw_v3_cross(z1, z3);
    c = sqrt((1 - lw_v3_dot(in, in))/lw_v3_dot(n, n));
    z2 = lw_v3_add(in, lw_v3_scale(n, c));
    const lw_vec3 z[] = { z0, z1, z2, z3 };
    for (int i = 0; i < 4; i++) {            /* normals along z[i] x z[i + 1], which the twists turn z about */
        lw_vec3 before = lw_v3_cross(z[(i + 3)%4], z[i]), after = lw_v3_cross(z[i], z[(i + 1)%4]);
        s.turn[i] = atan2(lw_v3_dot(z[i], lw_v3_cross(before, after)), lw_v3_dot(before, after));
    }
    for (int i = 0; i < 4; i++)
        f[i + 1] = next(f[i], s.turn[i], offset[i], length[i], s.twist[i]);
    for (int i = 0; i < 4; i++) {
        a[i] = pin(f[i], i ? "l" : "g", i - 1, i < 3 ? "l" : "g", i < 3 ? i : -1);
        a[i].kind = i ? "cylindrical" : "revolute";
    }
    check_mobility(4, a, 1, 0);
    check_motion(4, a, 0);
    turn_input(4, a, 2*LW_PI, 60, see_rccc, &s);
}

static lw_status see_row(void *context, double u, const double *input, const lw_space_tracer *tracer)
{
    (void)u, (void)input, (void)tracer;
    ++*(int *)context;
    return LW_OK;
}

static lw_vec3 random_direction(lw_rng *rng)
{
    lw_vec3 v = lw_v3(lw_rng_normal(rng), lw_rng_normal(rng), lw_rng_normal(rng));
    return lw_v3_scale(v, 1/lw_v3_norm(v));
}

/* At a limit of the input the axes z1, z2, z3 lie in a plane, z1.z3 = cos(a +- b), and links slide away without bound.  z1.z3 is
 * A + B cos u + C sin u for the turn u of the input. */
TEST(rccc_is_traced_between_limits_where_links_slide_away)
{
    /* of these the first linkages hold hard ones: limits far out, where a link is hundreds of sizes away, one passed by a hair, two side by side */
    const uint64_t seed[] = { check_seed(), 25, 30, 33 };
    int limits = 0, turning = 0;
    lw_rng rng;
    for (int trial = 0; trial < 40; trial++) {
        if (trial%10 == 0)
            lw_rng_seed(&rng, seed[trial/10], 7);
        frame f[4];
        axis a[4];
        OWN(lw_spatial) m = { 0 };
        int rows = 0;
        for (int i = 0; i < 4; i++) {
            f[i] = (frame){ .at = random_direction(&rng), .z = random_direction(&rng) };
            a[i] = pin(f[i], i ? "l" : "g", i - 1, i < 3 ? "l" : "g", i < 3 ? i : -1);
            a[i].kind = i ? "cylindrical" : "revolute";
        }
        lw_vec3 z0 = f[0].z, z1 = f[1].z, z2 = f[2].z, z3 = f[3].z;
        double along = lw_v3_dot(z0, z1)*lw_v3_dot(z0, z3), b = lw_v3_dot(z1, z3) - along, c = lw_v3_dot(lw_v3_cross(z0, z1), z3);
        double arc[2] = { acos(lw_v3_dot(z1, z2)), acos(lw_v3_dot(z2, z3)) }, to[2] = { 10, -10 };
        for (int k = 0; k < 4; k++) {        /* the nearest solutions on both sides */
            double by = (cos(k%2 ? arc[0] + arc[1] : arc[0] - arc[1]) - along)/hypot(b, c);
            if (fabs(by) >= 1)
                continue;
            double u = remainder(atan2(c, b) + (k/2 ? 1 : -1)*acos(by), 2*LW_PI), up = u > 0 ? u : u + 2*LW_PI;
            to[0] = fmin(to[0], up), to[1] = fmax(to[1], up - 2*LW_PI);
        }
        bool turns = to[0] > 9;
        make_model(4, a, false, &m);
        lw_space_trace o = { .whole = true, .intervals = 12 };
        lw_status st = lw_space_trace_run(&m, &o, see_row, &rows, &check_error);
        if (st == LW_E_ARG && fmin(to[0], -to[1]) < 1e-5 && strstr(check_error.text, "the posture is singular for it"))
            continue;                        /* the posture drawn is a limit but for rounding */
        CHECK_OK(st);
        CHECK_INT(rows, 13);
        CHECK_INT(o.limit[1], !turns);
        if (turns)
            turning++;
        else {
            CHECK(o.from > to[1] && o.to < to[0]);
            for (int k = 0; k < 2; k++) {    /* a slide c/sqrt(left) is 100 sizes at (c/100)^2, 0.03 for the greatest c drawn */
                CHECK_NEAR(k ? o.to : o.from, to[!k], o.away[k] < 0 ? 1e-6 : o.distance[k] < 95 ? 1e-2 : 0.1, 0);
                CHECK(o.distance[k] < 100.5);
            }
            limits += (o.away[0] >= 0) + (o.away[1] >= 0);
        }
    }
    CHECK(limits > 0 && turning > 0);
}
