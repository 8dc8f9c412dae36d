/* Pages: nothing from outside, nothing unescaped, postures that put every pin in its place. */
#include <jansson.h>

#include "catalogues/pages/page.h"
#include "catalogues/store/sha256.h"
#include "tests/check.h"
#include "tests/scene_models.h"
#include "tests/xml_scan.h"

static lw_page_result result_of(const lw_scene *s)
{
    return (lw_page_result){ .scene = s, .type = "four-bar", .class_name = "GCRR crank-rocker",
                             .transmission_min = NAN, .objective = 1.25e-5, .error_mean = 2e-3, .error_max = 5e-3,
                             .angle_mean = NAN, .angle_max = NAN, .error_percent = 0.125 };
}

/* A page of two targets, with texts of our choice. */
static lw_bytes write_page(const lw_scene *s, int n_scene, const char *text)
{
    lw_page_result r[4];
    for (int i = 0; i < n_scene; i++) {
        r[i] = result_of(&s[i]);
        r[i].note = text;
    }
    lw_page_target t[2] = { { .name = text, .about = text, .n_result = n_scene, .result = r },
                            { .name = "second", .n_result = 1, .result = r } };
    lw_page p = { .title = text, .about = text, .n_target = 2, .target = t };
    lw_bytes b;
    CHECK_OK(lw_page_write(&p, &b, &check_error));
    return b;
}

static int occurrences(const char *text, const char *part)
{
    int n = 0;
    for (const char *s = text; (s = strstr(s, part)) != NULL; s += strlen(part))
        n++;
    return n;
}

TEST(nothing_comes_from_outside)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 8, &s), LW_OK);
    OWN(lw_bytes) b = write_page(&s, 1, "A page");
    CHECK_INT(occurrences(b.data, "://"), occurrences(b.data, "xmlns=\"http://www.w3.org/2000/svg\""));
    static const char *const barred[] = { " src=", "<link", "<iframe", "<object", "<img", "@import",
                                          " style=\"", " onclick", " onload", "javascript:", "eval(",
                                          "fetch(", "XMLHttp", "innerHTML" };
    for (size_t i = 0; i < sizeof barred/sizeof *barred; i++)
        CHECK_INT(occurrences(b.data, barred[i]), 0);
    CHECK_HAS(b.data, "default-src 'none'");
    CHECK_HAS(b.data, "<meta charset=\"utf-8\">");
    CHECK_HAS(b.data, "width=device-width");
    CHECK_HAS(b.data, "prefers-color-scheme: dark");
}

/* The policy names the hash of what stands between the tags, to the byte. */
TEST(policy_allows_just_this_script_and_style)
{
    static const char *const tag[][3] = { { "<style>", "</style>", "style-src 'sha256-" },
                                          { "]</script>\n<script>", "</script>", "script-src 'sha256-" } };
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 0, &s), LW_OK);
    OWN(lw_bytes) b = write_page(&s, 1, "A page");
    for (int i = 0; i < 2; i++) {
        const char *from = strstr(b.data, tag[i][0]) + strlen(tag[i][0]), *to = strstr(from, tag[i][1]);
        char hash[LW_SHA256_TEXT], want[128];
        lw_sha256_base64(from, (size_t)(to - from), hash);
        snprintf(want, sizeof want, "%s%s'", tag[i][2], hash);
        CHECK_HAS(b.data, want);
    }
    CHECK_INT(occurrences(b.data, "<style"), 1);
    CHECK_INT(occurrences(b.data, "<script"), 2);
}

TEST(hostile_texts_stay_texts)
{
    const char *hostile = "</script><script>alert(1)</script><img src=x onerror='a'>\"&\xff{{";
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    strcpy(k.joint[0].name, "</svg><b>");
    strcpy(k.name, "--><!-- <");
    lw_scene_options o = lw_scene_options_default();
    o.title = hostile;
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, &o, &s, &check_error));
    OWN(lw_bytes) b = write_page(&s, 1, hostile);
    CHECK_INT(occurrences(b.data, "<script"), 2);
    CHECK_INT(occurrences(b.data, "</script>"), 2);
    CHECK_INT(occurrences(b.data, "<img"), 0);
    CHECK_INT(occurrences(b.data, "</svg>"), occurrences(b.data, "<svg "));
    CHECK_HAS(b.data, "&lt;/script&gt;");
}

static json_t *motions_of(const lw_bytes *b)
{
    const char *open = "<script type=\"application/json\" id=\"motions\">";
    const char *from = strstr(b->data, open) + strlen(open), *to = strstr(from, "</script>");
    json_error_t why;
    json_t *j = json_loadb(from, (size_t)(to - from), JSON_REJECT_DUPLICATES, &why);
    CHECK(json_is_array(j));
    return j;
}

typedef struct pin { int wanted; double x, y; int link; } pin;

static void find_pin(const xml_element *e, void *context)
{
    pin *p = context;
    if (xml_is(e, "joint") && atoi(xml_get(e, "data-item")) == p->wanted) {
        p->x = xml_number(e, "cx");
        p->y = xml_number(e, "cy");
        p->link = xml_get(e, "data-link") ? atoi(xml_get(e, "data-link")) : -1;
    }
}

static long whole(const json_t *a, size_t i)
{
    CHECK(json_is_integer(json_array_get(a, i)));
    return (long)json_integer_value(json_array_get(a, i));
}

/* Where the script puts a point of a link in a frame (page.js, `unpack` and `move`). */
static lw_vec2 moved(const json_t *link, size_t frame, lw_vec2 q)
{
    double from[2] = { whole(link, 2)/10.0, whole(link, 3)/10.0 }, sum[3] = { 0, 0, 0 };
    for (size_t f = 0; f <= frame; f++)
        for (size_t i = 0; i < 3; i++)
            sum[i] += (double)whole(link, 4 + 3*f + i);
    lw_vec2 d = lw_v2_turn(lw_v2_sub(q, lw_v2(from[0], from[1])), lw_v2_polar(1, sum[2]/10000));
    return lw_v2(sum[0]/10 + d.x, sum[1]/10 + d.y);
}

/* B is carried by coupler and rocker: wherever the script moves the pin, both links must agree, and the
 * distances to A and B0 stay the lengths of the links. */
TEST(postures_keep_the_links_together)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 8, &s), LW_OK);
    OWN(lw_bytes) b = write_page(&s, 1, "A page");
    char *svg = strndup(strstr(b.data, "<svg "), (size_t)(strstr(b.data, "</svg>") + 6 - strstr(b.data, "<svg ")));
    pin a = { .wanted = 1 }, joint = { .wanted = 2 }, b0 = { .wanted = 3 };
    CHECK(xml_scan(svg, find_pin, &a) > 20);
    xml_scan(svg, find_pin, &joint);
    xml_scan(svg, find_pin, &b0);
    CHECK_INT(b0.link, -1);
    json_t *motions = motions_of(&b), *m = json_array_get(motions, 0);
    json_t *links = json_object_get(m, "links");
    CHECK_INT(json_array_size(motions), 2);
    CHECK(json_is_true(json_object_get(m, "loops")));
    CHECK_INT(json_integer_value(json_object_get(m, "first")), 0);
    CHECK_INT(json_array_size(links), 3);
    json_t *coupler = json_array_get(links, 1), *rocker = json_array_get(links, 2);
    CHECK_INT(json_array_size(coupler), 4 + 3*s.n_frame);
    CHECK_INT(whole(coupler, 0), 2);
    CHECK_INT(whole(rocker, 0), 3);
    double length = hypot(joint.x - b0.x, joint.y - b0.y);
    for (size_t f = 0; f < s.n_frame; f++) {
        lw_vec2 p = moved(coupler, f, lw_v2(joint.x, joint.y)), q = moved(rocker, f, lw_v2(joint.x, joint.y));
        CHECK_NEAR(p.x, q.x, 0.3, 0);                     /* rounded to 0.1 px and 1e-4 rad */
        CHECK_NEAR(p.y, q.y, 0.3, 0);
        CHECK_NEAR(hypot(q.x - b0.x, q.y - b0.y), length, 0.3, 0);
    }
    json_decref(motions);
    free(svg);
}

static void look_for_id(const xml_element *e, void *context)
{
    int *n = context;
    *n += xml_get(e, "id") != NULL;
}

/* Every picture is well-formed by itself and all ids are different. */
TEST(many_results_on_one_page)
{
    lw_scene s[4];
    for (int i = 0; i < 4; i++)
        CHECK_INT(model_scene("Crank-rocker", 4, &s[i]), LW_OK);
    OWN(lw_bytes) b = write_page(s, 4, "A page");
    CHECK_INT(occurrences(b.data, "<figure"), 5);
    CHECK_INT(occurrences(b.data, "<section"), 2);
    CHECK_INT(occurrences(b.data, "<input type=\"radio\""), 4);             /* one result alone has no rank */
    CHECK_INT(occurrences(b.data, " checked> 1<"), 1);
    CHECK_INT(occurrences(b.data, "<caption>"), 1);
    int n_id = 0;
    const char *next = b.data;
    while ((next = strstr(next, "<svg ")) != NULL) {
        const char *end = strstr(next, "</svg>") + 6;
        char *svg = strndup(next, (size_t)(end - next));
        CHECK(xml_scan(svg, look_for_id, &n_id) > 20);
        free(svg);
        next = end;
    }
    CHECK_INT(n_id, 5);
    for (int t = 1; t <= 2; t++)
        for (int r = 1; r <= (t == 1 ? 4 : 1); r++) {
            char id[64];
            snprintf(id, sizeof id, "id=\"t%dr%d-clip0\"", t, r);
            CHECK_INT(occurrences(b.data, id), 1);
        }
    CHECK(b.size < 200000);
    for (int i = 0; i < 4; i++)
        lw_scene_free(&s[i]);
}

TEST(empty_columns_are_left_out)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 0, &s), LW_OK);
    lw_page_result r = { .scene = &s, .transmission_min = NAN, .objective = NAN, .error_mean = NAN, .error_max = NAN,
                         .angle_mean = NAN, .angle_max = NAN, .error_percent = 0.5 };
    lw_page_target t = { .name = "one", .n_result = 1, .result = &r };
    lw_page p = { .title = "One", .n_target = 1, .target = &t };
    lw_bytes b;
    CHECK_OK(lw_page_write(&p, &b, &check_error));
    CHECK(!strstr(b.data, "Mean error") && !strstr(b.data, "Objective") && !strstr(b.data, ">Type<"));
    CHECK_HAS(b.data, "% of path");
    CHECK_HAS(b.data, "r4 = 2.4");
    CHECK(!strstr(b.data, "<nav"));
    lw_bytes_free(&b);
    r.scene = NULL;                                              /* a row without a picture */
    CHECK_OK(lw_page_write(&p, &b, &check_error));
    CHECK(!strstr(b.data, "<figure"));
    lw_bytes_free(&b);
    t.n_result = 0;
    CHECK_INT(lw_page_write(&p, &b, &check_error), LW_E_ARG);
    CHECK(b.data == NULL);
}

TEST(same_input_same_bytes)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 8, &s), LW_OK);
    OWN(lw_bytes) a = write_page(&s, 1, "A page"), b = write_page(&s, 1, "A page");
    CHECK(a.size == b.size && memcmp(a.data, b.data, a.size) == 0);
}
