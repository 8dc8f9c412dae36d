/* Labels: never on each other, never outside, away from ink where there is room. */
#include "catalogues/draw/drawing.h"
#include "catalogues/draw/labels.h"
#include "tests/check.h"

static lw_box box_of(lw_vec2 at, const char *text, double size)
{
    return (lw_box){ at.x, at.y - 0.8*size, at.x + lw_text_width(text, size), at.y + 0.25*size };
}

static int overlap(lw_box a, lw_box b)
{
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

TEST(crowds_do_not_overlap)
{
    lw_rng r = check_rng(4);
    for (int trial = 0; trial < 40; trial++) {
        OWN(lw_label_map) m = { 0 };
        CHECK_OK(lw_label_map_make(&m, 500, 400, &check_error));
        for (int i = 0; i < 20; i++)
            lw_label_map_line(&m, lw_v2(lw_rng_range(&r, 0, 500), lw_rng_range(&r, 0, 400)),
                              lw_v2(lw_rng_range(&r, 0, 500), lw_rng_range(&r, 0, 400)), 1);
        lw_box within = { 10, 20, 490, 380 }, taken[200];
        int n = 0, n_asked = 0;
        for (int i = 0; i < 100; i++, n_asked++) {
            lw_vec2 a = lw_v2(lw_rng_range(&r, 0, 500), lw_rng_range(&r, 0, 400)), at;
            lw_vec2 b = i % 2 ? a : lw_v2(lw_rng_range(&r, 0, 500), lw_rng_range(&r, 0, 400));
            if (!lw_label_map_place(&m, "r3 = 12.5", 12, a, b, 8, within, &at))
                continue;
            lw_box box = box_of(at, "r3 = 12.5", 12);
            CHECK(box.x0 >= within.x0 && box.x1 <= within.x1);
            CHECK(box.y0 >= within.y0 && box.y1 <= within.y1);
            for (int k = 0; k < n; k++)
                CHECK(!overlap(box, taken[k]));
            taken[n++] = box;
        }
        CHECK(n > 25);
    }
}

/* A wall on three sides: the label goes to the free one. */
TEST(the_free_side_is_taken)
{
    for (int side = 0; side < 4; side++) {
        OWN(lw_label_map) m = { 0 };
        CHECK_OK(lw_label_map_make(&m, 200, 200, &check_error));
        lw_vec2 c = { 100, 100 }, at;
        for (int k = 0; k < 4; k++) {
            lw_vec2 u = lw_v2_polar(1, k*LW_PI/2), p = lw_v2_perp(u);
            for (double d = 6; k != side && d < 60; d += 3)
                lw_label_map_line(&m, lw_v2_add(c, lw_v2_add(lw_v2_scale(u, d), lw_v2_scale(p, d))),
                                  lw_v2_add(c, lw_v2_sub(lw_v2_scale(u, d), lw_v2_scale(p, d))), 1);
        }
        CHECK(lw_label_map_place(&m, "A", 12, c, c, 8, (lw_box){ 0, 0, 200, 200 }, &at));
        lw_box b = box_of(at, "A", 12);
        lw_vec2 to = lw_v2((b.x0 + b.x1)/2 - c.x, (b.y0 + b.y1)/2 - c.y), u = lw_v2_polar(1, side*LW_PI/2);
        CHECK(lw_v2_dot(to, u) > 0.6*lw_v2_norm(to));
    }
}

TEST(no_room_is_said)
{
    OWN(lw_label_map) m = { 0 };
    lw_vec2 at, c = { 50, 50 };
    CHECK_OK(lw_label_map_make(&m, 100, 100, &check_error));
    lw_label_map_take(&m, (lw_box){ 0, 0, 100, 100 });
    CHECK(!lw_label_map_place(&m, "A", 12, c, c, 8, (lw_box){ 0, 0, 100, 100 }, &at));
    CHECK(!lw_label_map_place(&m, "a text wider than the page", 12, c, c, 8, (lw_box){ 0, 0, 100, 100 }, &at));
    lw_label_map_line(&m, lw_v2(NAN, 0), lw_v2(1e300, 5), 1);                /* nothing to draw there */
}
