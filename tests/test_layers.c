/* Layers: nothing touches in twice as many postures, by shapes of another making; no fewer layers would do. */
#include "catalogues/exchange/layers.h"

#include "catalogues/exchange/export.h"
#include "tests/example_linkage.h"

static lw_scene scene_of(const lw_linkage *k, size_t n)
{
    lw_scene s;
    CHECK_INT(lw_scene_make(k, NULL, &(lw_scene_options){ .n_frame = n, .n_curve_point = 8 }, &s, NULL), LW_OK);
    return s;
}

/* ---- convex shapes ---------------------------------------------------------------------------------------- */

/* Least distance of points sown over the edges, or 0 when a corner of one lies in the other. */
static double sown_distance(const lw_vec2 *a, int n, const lw_vec2 *b, int m)
{
    double least = INFINITY;
    for (int i = 0; i < n; i++)
        for (int u = 0; u < 40; u++) {
            lw_vec2 p = lw_v2_add(a[i], lw_v2_scale(lw_v2_sub(a[(i + 1) % n], a[i]), u/40.0));
            bool inside = m > 2;
            for (int j = 0; j < m; j++) {
                lw_vec2 c = b[j], d = b[(j + 1) % m];
                least = fmin(least, lw_v2_segment_distance(p, c, d));
                inside = inside && lw_v2_cross(lw_v2_sub(d, c), lw_v2_sub(p, c)) > 0;
            }
            if (inside)
                return 0;
        }
    return least;
}

TEST(distances)
{
    const lw_vec2 square[] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } }, far[] = { { 3, 0.5 } };
    const lw_vec2 bar[] = { { -1, 0.5 }, { 2, 0.5 } }, over[] = { { 0, 2 }, { 1, 3 } };
    CHECK_NEAR(lw_hull_distance(square, 4, far, 1), 2, 1e-15, 0);
    CHECK_NEAR(lw_hull_distance(far, 1, square, 4), 2, 1e-15, 0);
    CHECK_NEAR(lw_hull_distance(square, 4, bar, 2), 0, 0, 0);           /* through it, no corner inside */
    CHECK_NEAR(lw_hull_distance(square, 4, over, 2), 1, 1e-15, 0);
    CHECK_NEAR(lw_hull_distance(bar, 2, over, 2), 1.5, 1e-15, 0);
    lw_rng rng = check_rng(0);
    for (int i = 0; i < 400; i++) {
        lw_vec2 a[3], b[3];
        for (int c = 0; c < 3; c++) {
            a[c] = lw_v2_polar(1 + lw_rng_uniform(&rng), 2.1*c);
            b[c] = lw_v2_add(lw_v2_polar(0.5 + lw_rng_uniform(&rng), 2.1*c + 0.3), lw_v2(0.01*i, 0.5));
        }
        double d = lw_hull_distance(a, 3, b, 3), want = fmin(sown_distance(a, 3, b, 3), sown_distance(b, 3, a, 3));
        CHECK_NEAR(d, want, 0.02, 0);
        CHECK(d <= want + 1e-12 || want == 0);
    }
}

/* ---- layers ------------------------------------------------------------------------------------------------- */

enum { CORNERS = 64 };

static int place_all(const lw_scene *s, int link, size_t f, const lw_layers *l, lw_vec2 *p)
{
    for (int c = 0; c < l->plate[link].n_corner; c++)
        p[c] = lw_scene_at(s, f, link, l->plate[link].corner[c]);
    return l->plate[link].n_corner;
}

/* The least room seen in the postures of s, by the shapes' own distance. */
static double room_seen(const lw_scene *s, const lw_layers *l)
{
    lw_vec2 p[CORNERS], q[CORNERS];
    double least = INFINITY;
    for (size_t f = 0; f < s->n_frame; f++) {
        for (int a = 0; a < s->linkage.n_link; a++) {
            int n = place_all(s, a, f, l, p);
            for (int b = 0; b < a; b++)
                if (l->layer[a] == l->layer[b])
                    least = fmin(least, lw_hull_distance(p, n, q, place_all(s, b, f, l, q)) - 2*l->radius);
            for (int i = 0; i < l->n_pin; i++) {
                lw_vec2 at = lw_scene_at(s, f, l->pin[i].owner, l->pin[i].at);
                if (!lw_pin_joins(&l->pin[i], a) && l->layer[a] > l->pin[i].low && l->layer[a] < l->pin[i].high)
                    least = fmin(least, lw_hull_distance(&at, 1, p, n) - l->radius - l->bore);
            }
        }
    }
    return least;
}

static bool clear_in_layer(const lw_scene *s, const lw_layers *l)
{
    lw_vec2 p[CORNERS], q[CORNERS];
    int n = s->linkage.n_link;
    for (size_t f = 0; f < s->n_frame; f++)
        for (int a = 0; a < n; a++)
            for (int b = 0; b < a; b++)
                if (l->layer[a] == l->layer[b]) {
                    int i = place_all(s, a, f, l, p), j = place_all(s, b, f, l, q);
                    if (sown_distance(p, i, q, j) <= 2*l->radius || sown_distance(q, j, p, i) <= 2*l->radius)
                        return false;
                }
    return true;
}

static bool pins_clear(const lw_scene *s, const lw_layers *l)
{
    lw_vec2 q[CORNERS];
    for (size_t f = 0; f < s->n_frame; f++)
        for (int p = 0; p < l->n_pin; p++)
            for (int a = 0; a < s->linkage.n_link; a++)
                if (!lw_pin_joins(&l->pin[p], a) && l->layer[a] > l->pin[p].low && l->layer[a] < l->pin[p].high) {
                    lw_vec2 at = lw_scene_at(s, f, l->pin[p].owner, l->pin[p].at);
                    if (sown_distance(&at, 1, q, place_all(s, a, f, l, q)) <= l->radius + l->bore)
                        return false;
                }
    return true;
}

static void check_layers(const lw_linkage *k, int most)
{
    OWN(lw_scene) s = scene_of(k, 240), fine = scene_of(k, 4801);
    static lw_layers l;
    CHECK_SILENT(lw_layers_find(&s, NULL, &l, &check_error));
    CHECK(l.n_layer >= 2 && l.n_layer <= most);
    CHECK_INT(l.layer[k->ground], 0);
    for (int j = 0; j < k->n_joint; j++)
        CHECK(l.layer[k->joint[j].link[0]] != l.layer[k->joint[j].link[1]]);
    for (int p = 0; p < l.n_pin; p++)
        for (int i = 0; i < k->n_link; i++)
            if (lw_pin_joins(&l.pin[p], i))
                CHECK(l.layer[i] >= l.pin[p].low && l.layer[i] <= l.pin[p].high);
    CHECK(clear_in_layer(&fine, &l));
    CHECK(pins_clear(&fine, &l));
    double seen = room_seen(&fine, &l);
    CHECK(l.room > 0 && l.room <= seen && (isinf(seen) || l.room > 0.3*seen));
    lw_layers_free(&l);
}

TEST(examples_pass_themselves)
{
    static const struct { const char *name; int most; } rows[] = {
        { "hoeken", 4 }, { "chebyshev", 4 }, { "klann", 6 }, { "jansen", 8 }, { "slider-crank", 4 },
        { "scott-russell", 4 }, { "inverted-slider-crank", 4 }, { "trammel", 4 }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_linkage k = example(rows[i].name);
        check_layers(&k, rows[i].most);
    }
}

/* What is said to be free is free in twenty times as many postures, also where motions turn back. */
TEST(room_of_random_linkages)
{
    static const char *const name[] = { "hoeken", "klann", "jansen", "slider-crank", "inverted-slider-crank" };
    static lw_layers l;
    int n_found = 0;
    lw_rng rng = check_rng(1);
    for (int i = 0; i < 60; i++) {
        lw_linkage k = example(name[i % 5]);
        for (int j = 0; j < k.n_joint; j++)
            if (k.joint[j].kind == LW_JOINT_REVOLUTE && i % 5 < 3)
                k.joint[j].at = lw_v2_add(k.joint[j].at, lw_v2_polar(0.1*lw_export_size(LW_VIEW(&k))*lw_rng_uniform(&rng),
                                                                     2*LW_PI*lw_rng_uniform(&rng)));
            else if (k.joint[j].kind == LW_JOINT_REVOLUTE)
                k.joint[j].at.x += 0.1*lw_export_size(LW_VIEW(&k))*lw_rng_uniform(&rng);
        OWN(lw_scene) s = scene_of(&k, 60), fine = scene_of(&k, 1201);
        lw_layers_free(&l);
        if (s.n_frame > 2 && lw_layers_find(&s, NULL, &l, NULL) == LW_OK) {
            double seen = room_seen(&fine, &l);
            CHECK(l.room > 0 && l.room <= seen);
            n_found += isfinite(l.room);
        }
    }
    lw_layers_free(&l);
    CHECK(n_found > 20);
}

/* Do two links, or a pin and a link, come nearer than `limit` in the frames? -1: too near to it to say. */
static int meet_in(const lw_scene *s, const lw_layers *l, int link, const lw_pin *pin, int other, double limit)
{
    lw_vec2 p[CORNERS], q[CORNERS];
    double least = INFINITY;
    for (size_t f = 0; f < s->n_frame; f++) {
        int n = pin ? 1 : place_all(s, link, f, l, p);
        if (pin)
            p[0] = lw_scene_at(s, f, pin->owner, pin->at);
        least = fmin(least, lw_hull_distance(p, n, q, place_all(s, other, f, l, q)));
    }
    return fabs(least - limit) < 0.05*l->radius ? -1 : least < limit;
}

/* The fewest layers of up to six links by trying all ways; 0: there are none; -1: not decided. */
static int fewest_by_trial(const lw_scene *s, const lw_layers *l)
{
    enum { N = 6 };
    int n = s->linkage.n_link, ground = s->linkage.ground, meet[N][N] = { 0 }, hit[16][N] = { 0 }, fewest = 0, ways = 1, layer[N];
    for (int a = 0; a < n; a++)
        for (int b = 0; b < a; b++) {
            bool joined = false;
            for (int p = 0; p < l->n_pin; p++)
                joined = joined || (lw_pin_joins(&l->pin[p], a) && lw_pin_joins(&l->pin[p], b));
            meet[a][b] = joined ? 1 : a == ground || b == ground ? 0 : meet_in(s, l, a, NULL, b, 2*l->radius);
            if (meet[a][b] < 0)
                return -1;
        }
    for (int p = 0; p < l->n_pin; p++)
        for (int a = 0; a < n; a++) {
            if (a != ground && !lw_pin_joins(&l->pin[p], a))
                hit[p][a] = meet_in(s, l, 0, &l->pin[p], a, l->radius + l->bore);
            if (hit[p][a] < 0)
                return -1;
        }
    for (int i = 1; i < n; i++)
        ways *= n - 1;
    for (int way = 0; way < ways; way++) {
        bool fits = true;
        int top = 0;
        for (int i = 0, rest = way; i < n; i++) {
            layer[i] = i == ground ? 0 : 1 + rest % (n - 1);
            rest = i == ground ? rest : rest/(n - 1);
            top = layer[i] > top ? layer[i] : top;
        }
        for (int a = 0; a < n && fits; a++)
            for (int b = 0; b < a; b++)
                fits = fits && !(meet[a][b] && layer[a] == layer[b]);
        for (int p = 0; p < l->n_pin && fits; p++) {
            int low = n, high = 0;
            for (int i = 0; i < l->pin[p].n_link; i++) {
                low = layer[l->pin[p].link[i]] < low ? layer[l->pin[p].link[i]] : low;
                high = layer[l->pin[p].link[i]] > high ? layer[l->pin[p].link[i]] : high;
            }
            for (int a = 0; a < n; a++)
                fits = fits && !(hit[p][a] && layer[a] > low && layer[a] < high);
        }
        if (fits && (fewest == 0 || top + 1 < fewest))
            fewest = top + 1;
    }
    return fewest;
}

/* As few layers as a search through all ways finds, and none where it finds none.  Drawn until there are enough of both kinds. */
TEST(fewest_of_all_ways)
{
    int n_none = 0, n_some = 0;
    lw_rng rng = check_rng(7);
    for (int i = 0; i < 120 || (i < 1200 && (n_none <= 3 || n_some <= 10)); i++) {
        lw_linkage k = example("klann");
        lw_error e = { 0 };
        for (int j = 0; j < k.n_joint; j++)
            k.joint[j].at = lw_v2_add(k.joint[j].at, lw_v2_polar(0.15*lw_rng_uniform(&rng), 2*LW_PI*lw_rng_uniform(&rng)));
        OWN(lw_scene) s = scene_of(&k, 240);
        lw_layers l;
        lw_plate_size size = { .radius = (0.01 + 0.3*lw_rng_uniform(&rng)), .bore = 0.004, .clearance = -1 };
        lw_status st = s.n_frame > 1 ? lw_layers_find(&s, &size, &l, &e) : LW_E_KIND;
        int fewest = st == LW_E_KIND ? -1 : fewest_by_trial(&s, &l);
        if (fewest >= 0) {
            CHECK_INT(st, fewest ? LW_OK : LW_NOTHING);
            CHECK(st != LW_OK || (l.n_layer == fewest && l.fewest));
            n_none += fewest == 0;
            n_some += fewest > 0;
        }
        if (st != LW_E_KIND)
            lw_layers_free(&l);
    }
    CHECK(n_none > 3 && n_some > 10);
}

/* The same leg so many times on one crank, all driven by it. */
static lw_assembly legs(const char *name, int n)
{
    lw_linkage one = example(name);
    lw_assembly a = { .ground = one.ground, .units = one.units };
    int joint = one.input[0].joint, crank = one.joint[joint].link[one.joint[joint].link[0] == one.ground], link[LW_LINK_MAX] = { 0 };
    a.link_name = calloc((size_t)(n*one.n_link), sizeof *a.link_name);
    a.joint = calloc((size_t)(n*one.n_joint), sizeof *a.joint);
    a.input = calloc(1, sizeof *a.input);
    a.tracer = calloc((size_t)(n*one.n_tracer), sizeof *a.tracer);
    for (int leg = 0; leg < n; leg++) {
        for (int i = 0; i < one.n_link; i++)
            if (leg == 0 || (i != one.ground && i != crank)) {
                link[i] = a.n_link;
                snprintf(a.link_name[a.n_link++], LW_NAME_SIZE, "%.20s %d", one.link_name[i], leg);
            }
        for (int j = 0; j < one.n_joint; j++)
            if (leg == 0 || j != joint) {
                lw_joint *p = &a.joint[a.n_joint];
                *p = one.joint[j];
                p->link[0] = link[p->link[0]];
                p->link[1] = link[p->link[1]];
                a.input[0] = j == joint ? (lw_input){ .joint = a.n_joint, .value = one.input[0].value } : a.input[0];
                snprintf(p->name, LW_NAME_SIZE, "%.20s %d", one.joint[j].name, leg);
                a.n_joint++;
            }
        for (int t = 0; t < one.n_tracer; t++) {
            a.tracer[a.n_tracer] = one.tracer[t];
            a.tracer[a.n_tracer].link = link[one.tracer[t].link];
            snprintf(a.tracer[a.n_tracer++].name, LW_NAME_SIZE, "%.20s %d", one.tracer[t].name, leg);
        }
    }
    a.ground = link[one.ground];
    a.n_input = 1;
    return a;
}

/* Six of Jansen's legs stand one upon the other, three layers each; of Klann's, whose rods pass the shafts of the next leg, there are
 * no layers for three or more. Both are decided in few steps, and a stop ends it. */
TEST(many_legs)
{
    static const struct { const char *name; int n, layers; } row[] = {
        { "jansen", 3, 10 }, { "jansen", 6, 19 }, { "klann", 2, 7 }, { "klann", 3, 0 }, { "klann", 12, 0 }
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        OWN(lw_assembly) a = legs(row[i].name, row[i].n);
        OWN(lw_scene) s = { 0 };
        OWN(lw_layers) l = { 0 };
        const volatile sig_atomic_t stop = 1;
        CHECK_OK(lw_scene_make_any(&a, NULL, NULL, &(lw_scene_options){ .n_frame = 240 }, &s, &check_error));
        CHECK_INT(lw_layers_find(&s, NULL, &l, &check_error), row[i].layers ? LW_OK : LW_NOTHING);
        if (row[i].layers) {
            CHECK_INT(l.n_layer, row[i].layers);
            double seen = room_seen(&s, &l);
            CHECK(l.room > 0 && l.room <= seen);
        }
        lw_layers_free(&l);
        s.stop = &stop;
        CHECK_INT(lw_layers_find(&s, NULL, &l, &check_error), LW_STOPPED);
    }
}

/* A leg whose own input rests draws a point: its curve is not refined down to rounding. */
TEST(a_resting_leg_is_a_point)
{
    lw_linkage both = example("klann");
    int n = both.n_link, joints = both.n_joint;
    for (int i = 0; i < n; i++)
        if (i != both.ground)
            snprintf(both.link_name[both.n_link++], LW_NAME_SIZE, "second %d", i);
    for (int j = 0; j < joints; j++) {
        lw_joint *p = &both.joint[both.n_joint++];
        *p = both.joint[j];
        snprintf(p->name, LW_NAME_SIZE, "second %d", j);
        p->at.x += 5;
        for (int end = 0; end < 2; end++)
            p->link[end] += p->link[end] == both.ground ? 0 : n - 1;
    }
    both.tracer[both.n_tracer++] = (lw_tracer){ .name = "second", .link = both.tracer[0].link + n - 1, .at = { 5, 0 } };
    both.input[both.n_input++] = (lw_input){ .joint = both.input[0].joint + joints, .value = both.input[0].value };
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_scene_make(&both, NULL, NULL, &s, &check_error));
    CHECK_INT(s.n_curve, 2);
    CHECK(s.n_curve == 2 && s.curve[0].n < 5000 && s.curve[1].n < 5000);
}

TEST(refusals)
{
    static lw_layers l;
    lw_linkage k = example("geared-five-bar");
    OWN(lw_scene) s = scene_of(&k, 12);
    CHECK_FAILS(lw_layers_find(&s, NULL, &l, &check_error), LW_E_KIND, "gears");
    lw_scene_free(&s);
    k = example("hoeken");
    k.n_input = 0;
    s = scene_of(&k, 12);
    CHECK_FAILS(lw_layers_find(&s, NULL, &l, &check_error), LW_E_KIND, "need the motion");
}

/* ---- plates in files ------------------------------------------------------------------------------------------ */

typedef struct ends { int n; lw_vec2 p[400]; int circles; } ends;

static void add_end(ends *w, double x, double y)
{
    if (w->n < 400)
        w->p[w->n++] = lw_v2(x, y);
}

/* Entities of a DXF: ends of lines and arcs. */
static ends read_ends(const char *text)
{
    ends w = { 0 };
    char kind[32] = "", value[64];
    double v[100] = { 0 };
    int code, skip;
    bool entities = false;
    while (sscanf(text, "%d\n%63[^\n]\n%n", &code, value, &skip) == 2) {
        text += skip;
        if (code == 0) {
            if (strcmp(kind, "LINE") == 0) {
                add_end(&w, v[10], v[20]);
                add_end(&w, v[11], v[21]);
            } else if (strcmp(kind, "ARC") == 0) {
                add_end(&w, v[10] + v[40]*cos(v[50]*LW_PI/180), v[20] + v[40]*sin(v[50]*LW_PI/180));
                add_end(&w, v[10] + v[40]*cos(v[51]*LW_PI/180), v[20] + v[40]*sin(v[51]*LW_PI/180));
            }
            w.circles += strcmp(kind, "CIRCLE") == 0;
            snprintf(kind, sizeof kind, "%.31s", value);
        }
        entities = entities || strcmp(value, "ENTITIES") == 0;
        if (code >= 10 && code < 60)
            v[code] = atof(value);
    }
    CHECK_TEXT(kind, "EOF");
    CHECK(entities);
    return w;
}

/* Every end of a line meets exactly one of an arc: the outlines are closed. */
TEST(outlines_are_closed)
{
    static const char *const names[] = { "hoeken", "klann", "slider-crank", "trammel" };
    for (size_t i = 0; i < sizeof names/sizeof *names; i++) {
        lw_linkage k = example(names[i]);
        OWN(lw_bytes) b = { 0 };
        CHECK_INT(lw_export_dxf(LW_VIEW(&k), NULL, &b, NULL), LW_OK);
        ends w = read_ends(b.data);
        CHECK(w.n >= 4*k.n_link - 4 && w.circles >= k.n_joint);
        for (int a = 0; a < w.n; a++) {
            int met = 0;
            for (int c = 0; c < w.n; c++)
                met += c != a && lw_v2_norm(lw_v2_sub(w.p[a], w.p[c])) < 1e-6;
            CHECK_INT(met, 1);
        }
        CHECK_HAS(b.data, "AC1009");
    }
}

TEST(openscad_is_balanced)
{
    lw_linkage k = example("klann");
    OWN(lw_bytes) b = { 0 };
    static const char brackets[] = "()[]{}";
    int depth[3] = { 0 };
    snprintf(k.link_name[1], LW_NAME_SIZE, "*/ cube(9); /*");
    CHECK_INT(lw_export_openscad(LW_VIEW(&k), NULL, &b, NULL), LW_OK);
    for (const char *c = b.data; *c; c++) {
        const char *in = strchr(brackets, *c);
        if (in)
            depth[(in - brackets)/2] += (in - brackets) % 2 ? -1 : 1;
    }
    CHECK_INT(depth[0], 0);
    CHECK_INT(depth[1], 0);
    CHECK_INT(depth[2], 0);
    CHECK_HAS(b.data, "module link5()");
    CHECK_HAS(b.data, "// */ cube(9); /*");
    CHECK_HAS(b.data, "cylinder(r = pin, h = ");
}
