/* test_atlas.c - atlases of curves: the nearest against a comparison with every curve; the same for any number of
 * threads; what is found traces the target. */
#include "catalogues/store/nearest.h"

#include <unistd.h>
#include "catalogues/build/build.h"
#include "catalogues/draw/scene.h"
#include "tests/check.h"
#include "tests/temporary.h"

#define SAMPLES 16000

static char path[300];
static lw_curve_maker *maker;
static lw_atlas_tree tree[2];          /* closed, open */

static lw_store *open_store(bool write)
{
    lw_store *s;
    lw_store_options o = { .write = write, .create = write };
    CHECK_OK(lw_store_open(path, &o, &s, &check_error));
    return s;
}

TEST(draws_the_same_for_any_threads)
{
    lw_atlas_tree again[2];
    CHECK_INT(lw_atlas_segment(maker, 7, 3, SAMPLES, LW_ATLAS_BOTH, 1, NULL, tree), LW_OK);
    CHECK_INT(lw_atlas_segment(maker, 7, 3, SAMPLES, LW_ATLAS_BOTH, 3, NULL, again), LW_OK);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(tree[i].n, again[i].n);
        CHECK_INT(tree[i].closed, i == 0);
        CHECK(tree[i].n > SAMPLES/3);
        CHECK(memcmp(tree[i].terms, again[i].terms, tree[i].n*sizeof *tree[i].terms) == 0);
        CHECK(memcmp(tree[i].row, again[i].row, tree[i].n*sizeof *tree[i].row) == 0);
        CHECK(memcmp(tree[i].box, again[i].box, tree[i].n_block*sizeof *tree[i].box) == 0);
        lw_atlas_tree_free(&again[i]);
    }
    CHECK_INT(lw_atlas_segment(maker, 7, 3, 1000, LW_ATLAS_CLOSED, 2, NULL, again), LW_OK);
    CHECK(again[0].n > 400 && again[1].n == 0);
    lw_atlas_tree_free(&again[0]);
    lw_atlas_tree_free(&again[1]);
}

/* A good share of the linkages has an input that turns and a transmission angle of 30 degrees; others are there too. */
TEST(linkages_for_designers)
{
    for (int i = 0; i < 2; i++) {
        size_t good = 0;
        for (size_t k = 0; k < tree[i].n; k++)
            good += tree[i].row[k].turns == 2 && tree[i].row[k].transmission > 60;
        CHECK(good > tree[i].n/3 && good < 3*tree[i].n/4);
    }
}

/* Blocks hold all curves, within their boxes. */
TEST(blocks)
{
    for (int i = 0; i < 2; i++) {
        size_t at = 0;
        for (size_t b = 0; b < tree[i].n_block; b++)
            for (uint32_t k = 0; k < tree[i].box[b].n; k++, at++) {
                float size[LW_TERMS];
                lw_packed_size(&tree[i].terms[at], size);
                for (int j = 0; j < LW_TERMS; j++) {
                    CHECK(size[j]*LW_TERM_ONE >= tree[i].box[b].least[j] - 0.51);
                    CHECK(size[j]*LW_TERM_ONE <= tree[i].box[b].most[j] + 0.51);
                }
            }
        CHECK_INT(at, tree[i].n);
    }
}

TEST(into_the_store)
{
    lw_store *s = open_store(true);
    lw_store_run run = { "curves", "test", "test", 7 };
    lw_atlas_sweep sweep = { .families = lw_curve_maker_families(maker), .kinds = LW_ATLAS_BOTH, .seed = 7 };
    CHECK_OK(lw_store_begin(s, &check_error));
    CHECK_OK(lw_store_run_begin(s, &run, &check_error));
    CHECK_OK(lw_store_sweep_begin(s, &sweep, &check_error));
    CHECK_INT(sweep.samples, 0);
    CHECK_OK(lw_store_put_segment(s, tree, SAMPLES, &check_error));
    CHECK_OK(lw_store_sweep_begin(s, &sweep, &check_error));
    CHECK_INT(sweep.samples, SAMPLES);
    CHECK_INT(sweep.segments, 1);
    CHECK_OK(lw_store_commit(s, &check_error));
    CHECK_OK(lw_store_verify(s, &check_error));
    lw_store_close(s);
}

/* All numbers of all curves, as one number. */
static lw_status hash_row(void *context, int n_column, const char *const *name, const lw_value *v)
{
    uint64_t *hash = context;
    (void)name;
    for (int i = 0; i < n_column; i++) {
        bool bytes = v[i].kind == LW_VALUE_TEXT || v[i].kind == LW_VALUE_BLOB;
        const unsigned char *p = bytes ? (const unsigned char *)v[i].text : (const unsigned char *)&v[i].integer;
        for (size_t k = 0; k < (bytes ? v[i].size : sizeof v[i].integer); k++)
            *hash = (*hash ^ p[k])*1099511628211u;
    }
    return LW_OK;
}

static uint64_t hash_curves(lw_store *s)
{
    static const char *const sql[] = {
        "SELECT * FROM sweep ORDER BY id", "SELECT * FROM curve_block ORDER BY id",
        "SELECT id, sweep, number, closed, n, first_block, boxes FROM curve_segment ORDER BY id" };
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < 3; i++) {
        lw_store_query q = { .sql = sql[i], .row = hash_row, .context = &hash };
        CHECK_OK(lw_store_ask(s, &q, &check_error));
    }
    return hash;
}

static lw_store *store_at(const char *name, bool write)
{
    char file[400];
    lw_store *s = NULL;
    snprintf(file, sizeof file, "%s-%s", path, name);
    CHECK_OK(lw_store_open(file, &(lw_store_options){ .write = write, .create = write }, &s, &check_error));
    return s;
}

static lw_status draw_part(const char *name, int part, int n_part, int jobs, bool (*goes_on)(void *, double, double))
{
    lw_build_control control = { .jobs = jobs, .seed = 5, .part = part, .n_part = n_part, .segment = 700,
                                 .goes_on = goes_on };
    lw_build_counts n;
    lw_error e = { 0 };
    lw_store *s = store_at(name, true);
    lw_status status = lw_build_curves(s, maker, LW_ATLAS_BOTH, 3300, "test", &control, &n, &e);
    lw_store_close(s);
    return status;
}

static bool stop_after_one(void *context, double done, double total)
{
    (void)context, (void)total;
    return done == 0;
}

/* Parts of a sequence, joined, are the catalogue of the whole: 5 segments in 1 + 2 + 2.  They are joined in order only,
 * and only when complete. */
TEST(parts_joined_are_the_whole)
{
    static const char *const names[] = { "part-1", "part-2", "part-3" };
    static const lw_store_run run = { "add", "test", "test", 0 };
    char file[400];
    uint64_t n;
    CHECK_INT(draw_part("whole", 0, 0, 2, NULL), LW_OK);
    CHECK_INT(draw_part("part-1", 0, 3, 1, NULL), LW_OK);
    CHECK_INT(draw_part("part-2", 1, 3, 3, stop_after_one), LW_STOPPED);
    CHECK_INT(draw_part("part-3", 2, 3, 1, NULL), LW_OK);
    CHECK_INT(draw_part("part-3", 1, 3, 1, NULL), LW_E_ARG);
    CHECK_INT(draw_part("part-6", 5, 6, 1, NULL), LW_E_ARG);        /* more parts than segments */
    lw_store *s = store_at("joined", true);
    for (int i = 2; i >= 0; i--) {
        snprintf(file, sizeof file, "%s-%s", path, names[i]);
        CHECK_FAILS(lw_store_add_curves(s, file, &run, &n, &check_error), i == 0 ? LW_OK : LW_E_ARG,
                    i == 0 ? "" : i == 1 ? "not complete" : "add part 1 first");
    }
    CHECK_INT(draw_part("part-2", 1, 3, 3, NULL), LW_OK);
    for (int i = 0; i < 3; i++) {
        snprintf(file, sizeof file, "%s-%s", path, names[i]);
        CHECK_INT(lw_store_add_curves(s, file, &run, &n, &check_error), i == 0 ? LW_NOTHING : LW_OK);
    }
    CHECK_OK(lw_store_verify(s, &check_error));
    lw_store *whole = store_at("whole", false);
    CHECK(hash_curves(s) == hash_curves(whole));
    lw_store_close(whole);
    whole = store_at("part-1", false);
    CHECK(hash_curves(s) != hash_curves(whole));
    lw_store_close(whole);
    lw_store_close(s);
}

/* A curve of the atlas, elsewhere, larger, turned, mirrored: the first answer is itself. */
static void finds_itself(const lw_atlas_tree *t, size_t which, lw_store *s)
{
    lw_vec2 p[LW_CURVE_POINTS];
    lw_atlas_hit hit[5];
    lw_atlas_search count;
    int n;
    lw_curve_work *work = NULL;
    CHECK_INT(lw_curve_work_create(maker, &work), LW_OK);
    CHECK_INT(lw_curve_points(maker, &t->row[which], t->closed, work, p, NULL), LW_OK);
    lw_curve_work_free(work);
    for (int i = 0; i < LW_CURVE_POINTS; i++)
        p[i] = lw_v2_add(lw_v2(100, -50), lw_v2_turn(lw_v2(p[i].x, which%2 ? -p[i].y : p[i].y), lw_v2_polar(3, 0.5)));
    CHECK_OK(lw_store_nearest(s, p, LW_CURVE_POINTS, t->closed, NULL, 5, hit, &n, &count, &check_error));
    CHECK_INT(n, 5);
    CHECK_INT(count.n_curve, t->n);
    CHECK_NEAR(hit[0].distance, 0, 1e-6, 0);
    for (int i = 1; i < n; i++)
        CHECK(hit[i].distance >= hit[i - 1].distance);
    /* its linkage runs through the target, apart from what the nearest of so few curves is away */
    OWN(lw_scene) scene = { 0 };
    lw_scene_options o = lw_scene_options_default();
    lw_descriptor d;
    double worst = 0;
    o.n_curve_point = 3000;
    CHECK_INT(lw_descriptor_make(p, LW_CURVE_POINTS, t->closed, &d), LW_OK);
    CHECK_OK(lw_scene_make(&hit[0].linkage, NULL, &o, &scene, &check_error));
    const lw_curve *c = scene.curve;                           /* of an open curve the matched part */
    while (c && c + 1 < scene.curve + scene.n_curve && !c->shown_branch)
        c++;
    for (int i = 0; i < LW_CURVE_POINTS && scene.n_curve > 0; i += 3) {
        double near = INFINITY;
        for (size_t k = 0; k + 1 < c->n + c->closed; k++)
            near = fmin(near, lw_v2_segment_distance(p[i], c->p[k], c->p[(k + 1)%c->n]));
        worst = fmax(worst, near);
    }
    for (size_t k = 0; scene.n_curve > 0 && !t->closed && k < c->n; k += 30) {      /* and nothing else */
        double near = INFINITY;
        for (int i = 0; i + 1 < LW_CURVE_POINTS; i++)
            near = fmin(near, lw_v2_segment_distance(c->p[k], p[i], p[i + 1]));
        worst = fmax(worst, near);
    }
    CHECK(scene.n_curve > 0);
    CHECK_NEAR(worst, 0, 0.02*d.size, 0);
}

TEST(curves_find_themselves)
{
    lw_store *s = open_store(false);
    for (size_t i = 11; i < 2600; i += 500)
        for (int kind = 0; kind < 2; kind++)
            finds_itself(&tree[kind], i%tree[kind].n, s);
    lw_store_close(s);
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* A target of 200 points, in another place, size and direction; closed ones also from another start. */
static void target_of(int shape, bool closed, lw_vec2 *p)
{
    for (int i = 0; i < 200; i++) {
        double a = closed ? 2*LW_PI*i/200 : 2.0*i/200;
        p[i] = shape == 0 && closed ? lw_v2(2*cos(a), sin(a))
             : lw_v2(3*cos(a) + 0.6*cos(2*a + shape), 2*sin(a) + 0.3*sin(3*a + shape));
    }
}

static void disguise(lw_rng *rng, bool closed, const lw_vec2 *p, lw_vec2 *q)
{
    size_t start = closed ? (size_t)(200*lw_rng_uniform(rng)) : 0;
    bool backwards = lw_rng_uniform(rng) < 0.5, mirrored = lw_rng_uniform(rng) < 0.5;
    lw_vec2 turn = lw_v2_polar(exp(4*lw_rng_uniform(rng) - 2), 7*lw_rng_uniform(rng));
    for (size_t i = 0; i < 200; i++) {
        lw_vec2 at = p[(start + (backwards ? 199 - i : i))%200];
        q[i] = lw_v2_add(lw_v2(5, -7), lw_v2_turn(lw_v2(at.x, mirrored ? -at.y : at.y), turn));
    }
}

/* The distances of all curves, each drawn again, from the target. */
static double *all_distances(const lw_atlas_tree *t, const lw_vec2 *target)
{
    lw_curve_work *work = NULL;
    CHECK_INT(lw_curve_work_create(maker, &work), LW_OK);
    double *d = malloc(t->n*sizeof *d);
    lw_descriptor a, b;
    CHECK_INT(lw_descriptor_make(target, 200, t->closed, &a), LW_OK);
    for (size_t i = 0; i < t->n; i++) {
        lw_vec2 p[LW_CURVE_POINTS];
        lw_match m = { .distance = INFINITY };
        if (lw_curve_points(maker, &t->row[i], t->closed, work, p, NULL) == LW_OK
            && lw_descriptor_make(p, LW_CURVE_POINTS, t->closed, &b) == LW_OK)
            lw_descriptor_match(&a, &b, &m);
        d[i] = m.distance;
    }
    qsort(d, t->n, sizeof *d, rising);
    lw_curve_work_free(work);
    return d;
}

/* The least distances and the answer are the same, for any number of answers and for the target in disguise. */
TEST(as_by_force)
{
    lw_store *s = open_store(false);
    lw_atlas_hit *hit = malloc(500*sizeof *hit);
    lw_rng rng = check_rng(4);
    for (int trial = 0; trial < 6; trial++) {
        bool closed = trial%3 != 2;
        lw_vec2 p[200], q[200];
        int n;
        target_of(trial, closed, p);
        FREED double *d = all_distances(&tree[!closed], p);
        for (int count = 1; count <= 500; count = count == 1 ? 20 : count*5) {
            memcpy(q, p, sizeof q);
            if (count == 20)
                disguise(&rng, closed, p, q);
            CHECK_OK(lw_store_nearest(s, q, 200, closed, NULL, count, hit, &n, NULL, &check_error));
            CHECK_INT(n, count);
            for (int i = 0; i < n; i++)
                CHECK_NEAR(hit[i].distance, d[i], 1e-9, 0);
        }
    }
    free(hit);
    lw_store_close(s);
}

/* Length between two pins. */
static double side(const lw_linkage *k, int a, int b) { return lw_v2_norm(lw_v2_sub(k->joint[a].at, k->joint[b].at)); }

/* The traits of a four-bar with a closed curve, by Grashof's rule and the cosine rule at the extreme diagonals. */
static void check_traits(const lw_atlas_hit *h)
{
    double a = side(&h->linkage, 0, 1), b = side(&h->linkage, 1, 2), c = side(&h->linkage, 2, 3);
    double d = side(&h->linkage, 3, 0), least = 1;
    double longest = fmax(fmax(a, b), fmax(c, d)), shortest = fmin(fmin(a, b), fmin(c, d));
    bool turns = shortest + longest < a + b + c + d - shortest - longest && (shortest == a || shortest == d);
    CHECK_INT(h->turns, turns);
    for (int i = -1; i <= 1 && turns; i += 2) {
        double x = (b*b + c*c - (d + i*a)*(d + i*a))/(2*b*c);
        least = fmin(least, 1 - x*x);
    }
    CHECK_NEAR(sin(h->transmission)*sin(h->transmission), turns ? least : 0, 1e-6, 0);
}

static bool lengths_within(const lw_linkage *k, double min, double max)
{
    for (int i = 0; i < 4; i++)
        if (side(k, i, (i + 1)%4) < min || side(k, i, (i + 1)%4) > max)
            return false;
    for (int i = 0; i < 4; i++)
        for (int end = 0; end < 2; end++)
            if (k->joint[i].link[end] == k->tracer[0].link && lw_v2_norm(lw_v2_sub(k->joint[i].at, k->tracer[0].at)) > max)
                return false;
    return true;
}

/* A search with conditions gives the curves that meet them of a search without. */
TEST(conditions_inside_the_search)
{
    enum { MANY = 1500 };
    lw_store *s = open_store(false);
    lw_atlas_hit *all = malloc(MANY*sizeof *all), *some = malloc(MANY*sizeof *some);
    for (int trial = 0; trial < 6; trial++) {
        bool closed = trial < 4;
        lw_atlas_filter f = { .turns = trial%2 == 0, .min_transmission = trial == 1 ? 0 : 0.5 };
        lw_vec2 p[200];
        int n, n_some = 0, n_pass = 0;
        f.min_length = trial%3 == 1 ? 0.5 : 0;
        f.max_length = trial%3 == 1 ? 9 : 0;
        target_of(trial, closed, p);
        CHECK_OK(lw_store_nearest(s, p, 200, closed, NULL, MANY, all, &n, NULL, &check_error));
        CHECK_INT(n, MANY);
        for (int i = 0; i < n; i++) {
            bool pins = strcmp(all[i].type, "RRRR") == 0;
            if (closed && pins)
                check_traits(&all[i]);
            bool pass = (all[i].turns || !f.turns) && all[i].transmission >= f.min_transmission;
            if (pass && f.max_length > 0 && pins)
                pass = lengths_within(&all[i].linkage, f.min_length, f.max_length);
            all[n_pass] = all[i];
            n_pass += pass && (pins || !(f.max_length > 0));
        }
        CHECK(n_pass > 2 && n_pass < MANY);
        CHECK_OK(lw_store_nearest(s, p, 200, closed, &f, n_pass, some, &n, NULL, &check_error));
        for (int i = 0, k = 0; i < n && k < n_pass; i++) {
            if (f.max_length > 0 && strcmp(some[i].type, "RRRR") != 0)
                continue;
            CHECK_NEAR(some[i].distance, all[k++].distance, 1e-12, 0);
            n_some++;
        }
        CHECK(n_some > 2 && (f.max_length > 0 || n_some == n_pass));
    }
    lw_atlas_filter none = { .turns = true, .min_transmission = 1.58 };         /* over 90 degrees */
    lw_vec2 p[200];
    int n;
    target_of(0, true, p);
    CHECK_FAILS(lw_store_nearest(s, p, 200, true, &none, 5, all, &n, NULL, &check_error), LW_NOTHING, "conditions");
    free(all);
    free(some);
    lw_store_close(s);
}

/* Few points: the smooth curve through them does not depend on the first one. */
TEST(few_points_from_any_start)
{
    lw_store *s = open_store(false);
    lw_vec2 p[7], q[7];
    lw_atlas_hit hit[5], again[5];
    int n;
    for (int i = 0; i < 7; i++)
        p[i] = lw_v2(3*cos(0.9*i), sin(0.9*i) + 0.4*cos(2.0*i));
    CHECK_OK(lw_store_nearest(s, p, 7, true, NULL, 5, hit, &n, NULL, &check_error));
    for (int start = 1; start < 7; start++) {
        for (int i = 0; i < 7; i++)
            q[i] = p[(start + (start%2 ? i : 7 - i))%7];
        CHECK_OK(lw_store_nearest(s, q, 7, true, NULL, 5, again, &n, NULL, &check_error));
        for (int i = 0; i < n; i++)
            CHECK_NEAR(again[i].distance, hit[i].distance, 1e-9, 0);
    }
    lw_store_close(s);
}

TEST(refusals)
{
    lw_store *s = open_store(false);
    lw_vec2 p[3] = { { 1, 1 }, { 1, 1 }, { 1, 1 } };
    lw_atlas_hit hit[3];
    int n;
    CHECK_INT(lw_store_nearest(s, p, 3, true, NULL, 3, hit, &n, NULL, &check_error), LW_E_ARG);
    CHECK_INT(lw_store_nearest(s, p, 0, true, NULL, 3, hit, &n, NULL, &check_error), LW_E_ARG);
    CHECK_INT(lw_store_nearest(s, p, 3, true, NULL, 0, hit, &n, NULL, &check_error), LW_E_ARG);
    p[1].x = 5;
    CHECK_OK(lw_store_nearest(s, p, 2, false, NULL, 3, hit, &n, NULL, &check_error));
    lw_store_close(s);
}

CHECK_MAIN
{
    snprintf(path, sizeof path, "%s/atlas.db", temporary_folder());
    if (lw_curve_maker_create("all", &maker, &check_error) != LW_OK)
        return 1;
    check_run();
    lw_atlas_tree_free(&tree[0]);
    lw_atlas_tree_free(&tree[1]);
    lw_curve_maker_free(maker);
    return check_end();
}
