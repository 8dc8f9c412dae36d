/* test_curves.c - curves drawn at random: they are those of their linkages, wherever these are laid. */
#include "catalogues/curves/curves.h"

#include "catalogues/draw/scene.h"
#include "mbs/plan/types.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "tests/check.h"

static double distance_to(lw_vec2 p, const lw_vec2 *q, size_t n, bool closed)
{
    double near = INFINITY;
    for (size_t i = 0; i + 1 < n + closed; i++)
        near = fmin(near, lw_v2_segment_distance(p, q[i], q[(i + 1)%n]));
    return near;
}

/* The curve as the program draws it (scene.h), by the linkage's own posture. */
static void check_against_scene(const lw_linkage *k, const lw_vec2 *p, bool closed, double size)
{
    OWN(lw_scene) scene = { 0 };
    lw_scene_options o = lw_scene_options_default();
    o.n_curve_point = 8000;
    CHECK_OK(lw_scene_make(k, NULL, &o, &scene, &check_error));
    CHECK(scene.n_curve > 0);
    double worst = 0;
    for (int i = 0; i < LW_CURVE_POINTS && scene.n_curve > 0; i += 5)
        worst = fmax(worst, distance_to(p[i], scene.curve[0].p, scene.curve[0].n, closed));
    CHECK_NEAR(worst, 0, 2e-3*size, 0);
}

static void draws(lw_curve_maker *m, size_t n)
{
    int n_made[2] = { 0, 0 };
    static double u[400*LW_CURVE_DRAWS];
    lw_curve_work *work = NULL;
    CHECK_INT(lw_curve_work_create(m, &work), LW_OK);
    lw_rng rng = check_rng(5);
    CHECK(lw_low_discrepancy(&rng, n, LW_CURVE_DRAWS, u));
    for (size_t i = 0; i < n; i++) {
        lw_curve_row row;
        lw_vec2 p[LW_CURVE_POINTS];
        lw_linkage k;
        lw_descriptor d;
        bool closed = i%2;
        if (lw_curve_draw(m, u + i*LW_CURVE_DRAWS, closed, work, &row) != LW_OK)
            continue;
        CHECK_INT(lw_curve_points(m, &row, closed, work, p, NULL), LW_OK);
        if (lw_descriptor_make(p, LW_CURVE_POINTS, closed, &d) != LW_OK)
            continue;
        n_made[closed]++;
        if (lw_curve_linkage(m, &row, closed, work, &k) != LW_OK)
            continue;
        CHECK_OK(lw_linkage_check(&k, &check_error));
        if (i%8 < 2)
            check_against_scene(&k, p, closed && row.mode != 0, d.size);
    }
    CHECK(n_made[0] > (int)n/4 && n_made[1] > (int)n/6);
    lw_curve_work_free(work);
    lw_curve_maker_free(m);
}

static lw_curve_maker *of_types(const char *types)
{
    lw_curve_maker *m = NULL;
    CHECK_INT(lw_curve_maker_create(types, &m, NULL), LW_OK);
    return m;
}

static lw_curve_maker *of_families(const char *families)
{
    lw_curve_maker *m = NULL;
    CHECK_INT(lw_curve_maker_of(families, &m, NULL), LW_OK);
    return m;
}

static lw_curve_maker *of_links(int links, const char *kinds)
{
    lw_curve_maker *m = NULL;
    CHECK_INT(lw_curve_maker_links(links, kinds, 1, NULL, &m, NULL), LW_OK);
    return m;
}

TEST(curves_are_those_of_their_linkages) { draws(of_types("fourbar"), 400); }
TEST(all_types) { draws(of_types("all"), 400); }
TEST(eight_links) { draws(of_links(8, "r"), 150); }
TEST(six_links_with_sliders) { draws(of_links(6, "rt"), 150); }

/* Eight links with sliders: more families than a byte counts.  A row says by itself which of them it is, also to a maker that
 * was made from the text; samples reach beyond the first 256. */
TEST(many_families)
{
    lw_curve_maker *m = NULL, *again = NULL;
    lw_curve_work *work[2];
    static double u[200*LW_CURVE_DRAWS];
    int n_made = 0, n_beyond = 0;
    char name[64];
    /* 600 families: three, again and again under other names */
    static const char *const three[] = { "=1-2r.1-3r.1-5r.2-4r.2-6r.3-4r.5-6r=g3i2t5", "=1-3r.1-5r.1-6r.2-4r.2-5r.2-6r.3-4r=g1i2t4",
                                         "=1-2r.2-3r.3-4r.4-1r.3-5r.5-6r.6-1t=g1i1t5" };
    FREED char *text = malloc(600*64);
    size_t n = 0;
    for (int i = 0; i < 600; i++)
        n += (size_t)sprintf(text + n, "%sf%d%s", i ? "," : "", i, three[i%3]);
    CHECK_OK(lw_curve_maker_of(text, &m, &check_error));
    CHECK_TEXT(lw_curve_maker_families(m), text);
    CHECK_OK(lw_curve_maker_of(lw_curve_maker_families(m), &again, &check_error));
    CHECK_INT(lw_curve_work_create(m, &work[0]), LW_OK);
    CHECK_INT(lw_curve_work_create(again, &work[1]), LW_OK);
    lw_rng rng = check_rng(7);
    CHECK(lw_low_discrepancy(&rng, 200, LW_CURVE_DRAWS, u));
    for (int i = 0; i < 200; i++) {
        lw_curve_row row;
        lw_linkage one, two;
        const char *type;
        if (lw_curve_draw(m, u + i*LW_CURVE_DRAWS, i%2, work[0], &row) != LW_OK)
            continue;
        int family = (int)(u[i*LW_CURVE_DRAWS]*600);
        CHECK_INT(row.family + 256*(int)row.more, family);
        CHECK(lw_curve_family(again, &row, name, &type) && !type);
        CHECK_INT(atoi(name + 1), family);
        CHECK_INT(lw_curve_linkage(m, &row, i%2, work[0], &one), LW_OK);
        CHECK_INT(lw_curve_linkage(again, &row, i%2, work[1], &two), LW_OK);
        CHECK_INT(memcmp(&one.joint, &two.joint, sizeof one.joint), 0);
        n_made++;
        n_beyond += family >= 256;
        row.more = 77;
        CHECK(!lw_curve_family(m, &row, name, &type));
        CHECK_INT(lw_curve_linkage(m, &row, i%2, work[0], &one), LW_OPEN);
    }
    CHECK(n_made > 60 && n_beyond > 30);
    for (int i = 0; i < 2; i++)
        lw_curve_work_free(work[i]);
    lw_curve_maker_free(again);
    lw_curve_maker_free(m);
    /* a family that is no family is found when it is needed; some of four links are too many */
    memcpy(strstr(text, "f500="), "f500=9", 6);
    CHECK_OK(lw_curve_maker_of(text, &m, &check_error));
    CHECK_INT(lw_curve_work_create(m, &work[0]), LW_OK);
    u[0] = 500.5/600;
    CHECK(lw_curve_draw(m, u, true, work[0], &(lw_curve_row){ 0 }) < 0);
    lw_curve_work_free(work[0]);
    lw_curve_maker_free(m);
    memcpy(text, "crank-rocker,f=", 15);                             /* "crank-rocker,f=" and the rest of the first two families */
    CHECK(lw_curve_maker_of(text, &m, &check_error) < 0);
}

/* Watt I, Stephenson III, and an eight-link chain with a slider, as text. */
#define WATT       "Watt I; point on link 5=1-2r.3-1r.1-5r.2-4r.2-6r.3-4r.5-6r=g3i2t5"
#define STEPHENSON "Stephenson III=1-3r.1-5r.1-6r.2-4r.2-5r.2-6r.3-4r=g1i2t4"
#define SLIDER     "a rocker's slider=1-2r.2-3r.3-4r.4-1r.3-5r.5-6r.6-1t=g1i1t5"

TEST(more_links) { draws(of_families(WATT "," STEPHENSON "," SLIDER), 300); }

/* The text says all: another maker, made of a linkage, draws the same members; texts that say nothing are refused. */
TEST(topologies_as_text)
{
    static const char *const bad[] = {
        "x=1-2r.2-3r=g1i1t5", "x=1-2r.2-3r.3-4r.4-1r=g5i1t3", "x=1-2r.2-3r.3-4r.4-1r=g1i9t3", "x=1-2r.1-2r=g1i1t2",
        "x=1-99r=g1i1t2", "x=", "x=1-2r.2-3r.3-4r.4-1r", "x=1-2r.2-3r.3-4r.4-1r=g1i1t3x", "x=1-2q.2-3r=g1i1t3",
    };
    lw_curve_maker *m, *again;
    double u[LW_CURVE_DRAWS] = { 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8 };
    lw_curve_row row;
    lw_linkage k, same;
    CHECK_OK(lw_curve_maker_of(STEPHENSON, &m, &check_error));
    lw_curve_work *work = NULL;
    CHECK_INT(lw_curve_work_create(m, &work), LW_OK);
    while (lw_curve_draw(m, u, true, work, &row) != LW_OK && u[1] < 0.9)
        u[1] += 0.01;
    CHECK_INT(lw_curve_linkage(m, &row, true, work, &k), LW_OK);
    char name[64];
    const char *type = "?";
    CHECK(lw_curve_family(m, &row, name, &type) && !type);
    CHECK_TEXT(name, "Stephenson III");
    CHECK_OK(lw_curve_maker_create(NULL, &again, &check_error));
    CHECK_INT(lw_curve_draw(again, u, true, work, &row), LW_OPEN);         /* of no family, no curve */
    CHECK_OK(lw_curve_maker_add(again, "Stephenson III", &k, &check_error));
    CHECK_TEXT(lw_curve_maker_families(again), STEPHENSON);
    CHECK_INT(lw_curve_linkage(again, &row, true, work, &same), LW_OK);
    CHECK_INT(memcmp(&k.joint, &same.joint, sizeof k.joint), 0);
    k.n_input = 2;
    CHECK_INT(lw_curve_maker_add(again, "two inputs", &k, &check_error), LW_E_ARG);
    lw_curve_work_free(work);
    lw_curve_maker_free(m);
    lw_curve_maker_free(again);
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++)
        CHECK(lw_curve_maker_of(bad[i], &m, &check_error) < 0);
}


/* A linkage that is mirrored, turned, stretched and moved traces the curve that is. */
TEST(laid_elsewhere)
{
    static const char *const types[] = { "fourbar", "slidercrank", "inverted", "trammel", "sliderdriven", "oldham" };
    lw_rng rng = check_rng(6);
    for (size_t t = 0; t < 2*sizeof types/sizeof *types; t++) {
        lw_linkage k, laid;
        OWN(lw_scene) a = { 0 }, b = { 0 };
        bool mirrored = t%2;
        double turn = lw_rng_range(&rng, -3, 3), size = exp(lw_rng_range(&rng, -2, 2));
        lw_vec2 shift = lw_v2(lw_rng_range(&rng, -5, 5), 2);
        lw_type_linkage(lw_type_find(types[t/2]), &k);
        laid = k;
        lw_linkage_lay(&laid, mirrored, turn, size, shift);
        CHECK_OK(lw_linkage_check(&laid, &check_error));
        if (laid.joint[laid.input[0].joint].kind == LW_JOINT_REVOLUTE)
            CHECK_NEAR(remainder(laid.input[0].value - lw_linkage_posture_input(&laid, laid.input[0].joint), 2*LW_PI), 0, 1e-12, 0);
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &a, &check_error));
        CHECK_OK(lw_scene_make(&laid, NULL, NULL, &b, &check_error));
        CHECK(a.n_curve > 0 && b.n_curve > 0);
        for (size_t i = 0; i < a.curve[0].n; i += 9) {
            lw_vec2 p = a.curve[0].p[i];
            p = lw_v2_add(shift, lw_v2_turn(lw_v2(p.x, mirrored ? -p.y : p.y), lw_v2_polar(size, turn)));
            CHECK_NEAR(distance_to(p, b.curve[0].p, b.curve[0].n, b.curve[0].closed), 0, 2e-3*size, 0);
        }
    }
}

TEST(names_and_families)
{
    lw_curve_maker *m, *again;
    CHECK_FAILS(lw_curve_maker_create("fourbar,nonsense", &m, &check_error), LW_E_ARG, "nonsense");
    CHECK_INT(lw_curve_maker_create("", &m, &check_error), LW_E_ARG);
    CHECK_OK(lw_curve_maker_create("slidercrank,fourbar", &m, &check_error));
    CHECK_TEXT(lw_curve_maker_families(m), "slider-crank,any slider-crank,crank-rocker,drag-link,any four-bar");
    CHECK_OK(lw_curve_maker_of(lw_curve_maker_families(m), &again, &check_error));
    CHECK_TEXT(lw_curve_maker_families(again), lw_curve_maker_families(m));
    lw_curve_maker_free(m);
    lw_curve_maker_free(again);
    CHECK_INT(lw_curve_maker_of("crank-rocker,flying carpet", &m, &check_error), LW_E_NOTATION);
    lw_curve_row row = { .family = 200 };
    CHECK_OK(lw_curve_maker_create("all", &m, &check_error));
    char name[64];
    const char *type;
    lw_curve_work *work = NULL;
    CHECK(!lw_curve_family(m, &row, name, &type));
    CHECK_INT(lw_curve_work_create(m, &work), LW_OK);
    lw_linkage k;
    CHECK_INT(lw_curve_linkage(m, &row, true, work, &k), LW_OPEN);
    lw_curve_work_free(work);
    lw_curve_maker_free(m);
}
