/* test_atlas.c - atlases of curves: the nearest against a comparison with every curve; the same for any number of
 * threads; what is found traces the target. */
#include "catalogues/store/nearest.h"

#include <unistd.h>
#include "base/rng.h"
#include "catalogues/draw/scene.h"
#include "tests/check.h"
#include "tests/temporary.h"

#define SAMPLES 6000

static char path[300];
static lw_curve_maker *maker;
static lw_atlas_tree tree[2];          /* closed, open */

static lw_store *open_store(bool write)
{
    lw_store *s;
    lw_error e = { 0 };
    lw_store_options o = { .write = write, .create = write };
    CHECK_INT(lw_store_open(path, &o, &s, &e), LW_OK);
    return s;
}

static void draws_the_same_for_any_threads(void)
{
    lw_atlas_tree again[2];
    CHECK_INT(lw_atlas_segment(maker, 7, 3, SAMPLES, LW_ATLAS_BOTH, 1, tree), LW_OK);
    CHECK_INT(lw_atlas_segment(maker, 7, 3, SAMPLES, LW_ATLAS_BOTH, 3, again), LW_OK);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(tree[i].n, again[i].n);
        CHECK_INT(tree[i].closed, i == 0);
        CHECK(tree[i].n > SAMPLES/3);
        CHECK(memcmp(tree[i].terms, again[i].terms, tree[i].n*sizeof *tree[i].terms) == 0);
        CHECK(memcmp(tree[i].row, again[i].row, tree[i].n*sizeof *tree[i].row) == 0);
        CHECK(memcmp(tree[i].box, again[i].box, tree[i].n_block*sizeof *tree[i].box) == 0);
        lw_atlas_tree_free(&again[i]);
    }
    CHECK_INT(lw_atlas_segment(maker, 7, 3, 1000, LW_ATLAS_CLOSED, 2, again), LW_OK);
    CHECK(again[0].n > 400 && again[1].n == 0);
    lw_atlas_tree_free(&again[0]);
    lw_atlas_tree_free(&again[1]);
}

/* Blocks hold all curves, within their boxes. */
static void blocks(void)
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

static void into_the_store(void)
{
    lw_error e = { 0 };
    lw_store *s = open_store(true);
    lw_store_run run = { "curves", "test", "test", 7 };
    lw_atlas_sweep sweep = { .families = lw_curve_maker_families(maker), .kinds = LW_ATLAS_BOTH, .seed = 7 };
    CHECK_INT(lw_store_begin(s, &e), LW_OK);
    CHECK_INT(lw_store_run_begin(s, &run, &e), LW_OK);
    CHECK_INT(lw_store_sweep_begin(s, &sweep, &e), LW_OK);
    CHECK_INT(sweep.samples, 0);
    CHECK_INT(lw_store_put_segment(s, tree, SAMPLES, &e), LW_OK);
    CHECK_INT(lw_store_sweep_begin(s, &sweep, &e), LW_OK);
    CHECK_INT(sweep.samples, SAMPLES);
    CHECK_INT(sweep.segments, 1);
    CHECK_INT(lw_store_commit(s, &e), LW_OK);
    CHECK_INT(lw_store_verify(s, &e), LW_OK);
    lw_store_close(s);
}

/* A curve of the atlas, elsewhere, larger, turned, mirrored: the first answer is itself. */
static void finds_itself(const lw_atlas_tree *t, size_t which, lw_store *s)
{
    lw_vec2 p[LW_CURVE_POINTS];
    lw_atlas_hit hit[5];
    lw_atlas_search count;
    lw_error e = { 0 };
    int n;
    void *work = aligned_alloc(64, lw_curve_work_size(maker));
    CHECK_INT(lw_curve_points(maker, &t->row[which], t->closed, work, p), LW_OK);
    free(work);
    for (int i = 0; i < LW_CURVE_POINTS; i++)
        p[i] = lw_v2_add(lw_v2(100, -50), lw_v2_turn(lw_v2(p[i].x, which%2 ? -p[i].y : p[i].y), lw_v2_polar(3, 0.5)));
    CHECK_INT(lw_store_nearest(s, p, LW_CURVE_POINTS, t->closed, 5, hit, &n, &count, &e), LW_OK);
    CHECK_INT(n, 5);
    CHECK_INT(count.n_curve, t->n);
    CHECK_NEAR(hit[0].distance, 0, 2e-3, 0);
    for (int i = 1; i < n; i++)
        CHECK(hit[i].distance >= hit[i - 1].distance);
    /* its linkage runs through the target, apart from what the nearest of so few curves is away */
    lw_scene scene;
    lw_scene_options o = lw_scene_options_default();
    lw_descriptor d;
    lw_describer tables;
    double worst = 0;
    o.n_curve_point = 3000;
    lw_describer_make(&tables);
    CHECK_INT(lw_descriptor_make(&tables, p, LW_CURVE_POINTS, t->closed, &d), LW_OK);
    CHECK_INT(lw_scene_make(&hit[0].linkage, NULL, &o, &scene, &e), LW_OK);
    for (int i = 0; i < LW_CURVE_POINTS && scene.n_curve > 0; i += 3) {
        double near = INFINITY;
        const lw_curve *c = &scene.curve[0];
        for (size_t k = 0; k + 1 < c->n + c->closed; k++)
            near = fmin(near, lw_v2_segment_distance(p[i], c->p[k], c->p[(k + 1)%c->n]));
        worst = fmax(worst, near);
    }
    CHECK(scene.n_curve > 0);
    CHECK_NEAR(worst, 0, 0.02*d.size, 0);
    lw_scene_free(&scene);
}

static void curves_find_themselves(void)
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

/* The twenty least distances by comparing every curve. */
static void as_by_force(void)
{
    lw_store *s = open_store(false);
    lw_describer tables;
    lw_error e;
    lw_rng rng;
    lw_describer_make(&tables);
    lw_rng_seed(&rng, check_seed(), 4);
    for (int trial = 0; trial < 6; trial++) {
        bool closed = trial%2;
        const lw_atlas_tree *t = &tree[!closed];
        lw_vec2 p[200];
        lw_atlas_hit hit[20];
        lw_descriptor target, curve;
        int n;
        for (int i = 0; i < 200; i++) {
            double a = closed ? 2*LW_PI*i/200 : 2.0*i/200;
            p[i] = lw_v2(3*cos(a) + 0.6*cos(2*a + trial), 2*sin(a) + 0.3*sin(3*a + trial));
        }
        double *d = malloc(t->n*sizeof *d);
        CHECK_INT(lw_descriptor_make(&tables, p, 200, closed, &target), LW_OK);
        for (size_t i = 0; i < t->n; i++) {
            lw_match m;
            lw_descriptor_unpack(&t->terms[i], closed, &curve);
            lw_descriptor_match(&target, &curve, &m);
            d[i] = m.distance;
        }
        qsort(d, t->n, sizeof *d, rising);
        CHECK_INT(lw_store_nearest(s, p, 200, closed, 20, hit, &n, NULL, &e), LW_OK);
        CHECK_INT(n, 20);
        for (int i = 0; i < n; i++)
            CHECK_NEAR(hit[i].distance, d[i], 1e-3, 0.01);     /* packed terms; starts between the 64 tried */
        free(d);
    }
    lw_store_close(s);
}

static void refusals(void)
{
    lw_store *s = open_store(false);
    lw_vec2 p[3] = { { 1, 1 }, { 1, 1 }, { 1, 1 } };
    lw_atlas_hit hit[3];
    lw_error e;
    int n;
    CHECK_INT(lw_store_nearest(s, p, 3, true, 3, hit, &n, NULL, &e), LW_E_ARG);
    CHECK_INT(lw_store_nearest(s, p, 0, true, 3, hit, &n, NULL, &e), LW_E_ARG);
    CHECK_INT(lw_store_nearest(s, p, 3, true, 0, hit, &n, NULL, &e), LW_E_ARG);
    p[1].x = 5;
    CHECK_INT(lw_store_nearest(s, p, 2, false, 3, hit, &n, NULL, &e), LW_OK);
    lw_store_close(s);
}

int main(void)
{
    lw_error e;
    snprintf(path, sizeof path, "%s/atlas.db", temporary_folder());
    if (lw_curve_maker_create("all", &maker, &e) != LW_OK)
        return 1;
    RUN(draws_the_same_for_any_threads);
    RUN(blocks);
    RUN(into_the_store);
    RUN(curves_find_themselves);
    RUN(as_by_force);
    RUN(refusals);
    lw_atlas_tree_free(&tree[0]);
    lw_atlas_tree_free(&tree[1]);
    lw_curve_maker_free(maker);
    return check_end();
}
