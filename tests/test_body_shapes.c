/* Bodies of a drawing: pistons stay in their tubes, teeth mesh in every frame, welds join what they weld. */
#include "catalogues/draw/body_shapes.h"
#include "grammar/model/model.h"
#include "tests/check.h"
#include "tests/scene_models.h"

static const char planet_text[] =
    "{\"linkwright\":1,\"name\":\"planet\",\"links\":[\"ground\",\"carrier\",\"planet\",\"arm\",\"pinion\",\"rack\"],\"joints\":["
    "{\"name\":\"O\",\"links\":[\"ground\",\"carrier\"],\"at\":[0,0]},{\"name\":\"Q\",\"links\":[\"carrier\",\"planet\"],\"at\":[2,0]},"
    "{\"name\":\"R\",\"kind\":\"g\",\"links\":[\"ground\",\"planet\"],\"at\":[3.2,0],\"ratio\":2.6666666666666665},"
    "{\"name\":\"W\",\"kind\":\"f\",\"links\":[\"planet\",\"arm\"],\"at\":[2.6,0.4]},"
    "{\"name\":\"U\",\"links\":[\"ground\",\"pinion\"],\"at\":[-4.5,0]},"
    "{\"name\":\"V\",\"kind\":\"t\",\"links\":[\"ground\",\"rack\"],\"at\":[-3,-1.2],\"along\":[1,0]},"
    "{\"name\":\"Z\",\"kind\":\"g\",\"links\":[\"pinion\",\"rack\"],\"at\":[-4.5,-0.8],\"ratio\":0.8},"
    "{\"name\":\"Y\",\"kind\":\"g\",\"links\":[\"carrier\",\"pinion\"],\"at\":[-1,0],\"ratio\":-1.25}],"
    "\"input\":{\"joint\":\"O\",\"first\":-1,\"last\":1},\"tracers\":[{\"name\":\"P\",\"link\":\"arm\",\"at\":[1.2,1.4]}]}";

static void planet_scene(lw_scene *s)
{
    lw_linkage k;
    lw_error e = { .text = "" };
    CHECK_INT(lw_linkage_read(planet_text, strlen(planet_text), "planet", &k, &e), LW_OK);
    CHECK_INT(lw_scene_make(&k, NULL, NULL, s, &e), LW_OK);
    CHECK_TEXT(s->note, "");
}

static double turn_of(const lw_scene *s, size_t frame, int link)
{
    lw_vec2 t = s->place[frame*(size_t)s->linkage.n_link + (size_t)link].turn;
    return atan2(t.y, t.x);
}

/* The place of w's nearest tooth (or gap) on the pitch line at the pitch point, in pitches, as the drawing turns it:
 * `at` the direction from its centre to the pitch point, now. */
static double phase(const lw_scene *s, size_t frame, const lw_wheel *w, double at, double before)
{
    double off = (at - before - turn_of(s, frame, w->link))/(2*LW_PI)*w->teeth;
    return off - round(off);
}

/* Tooth meets gap at the pitch point in every frame: what one has turned on the other has. */
static void check_mesh(const lw_scene *s, int joint)
{
    lw_wheel w[2];
    CHECK(lw_body_shapes_gear(s, joint, w));
    CHECK_NEAR(w[0].pitch, w[1].pitch, 0, 1e-9);
    lw_vec2 contact = lw_v2_add(w[0].centre, lw_v2_scale(w[0].along, w[0].radius));
    lw_gear g;
    CHECK_INT(lw_assembly_gear(&s->linkage, joint, &g, NULL, NULL), LW_OK);
    for (size_t f = 0; f < s->n_frame; f++) {
        double way[2];
        for (int i = 0; i < 2; i++) {                                 /* the pitch point turns with the carrier */
            double before = atan2(w[i].along.y, w[i].along.x);
            double now = before + turn_of(s, f, g.carrier);
            way[i] = phase(s, f, &w[i], now, before);
        }
        double sum = w[1].gap ? way[0] + way[1] : way[0] - way[1];   /* internal: both turn the same way */
        CHECK_NEAR(sum - round(sum), 0, 1e-6, 0);
    }
    CHECK_NEAR(lw_v2_norm(lw_v2_sub(contact, lw_v2_add(w[1].centre, lw_v2_scale(w[1].along, w[1].radius)))), 0, 1e-9*w[0].pitch, 1e-9);
}

TEST(teeth_mesh)
{
    OWN(lw_scene) s = { 0 };
    lw_linkage k;
    lw_wheel w[2];
    k = example("geared-five-bar");
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    check_mesh(&s, 5);
    CHECK(lw_body_shapes_gear(&s, 5, w));
    CHECK_NEAR(w[0].radius, 0.02, 1e-12, 0);
    CHECK_NEAR(w[1].radius, 0.04, 1e-12, 0);
    CHECK_INT(w[1].teeth, 2*w[0].teeth);
    CHECK(w[1].gap && !w[0].gap && !w[0].ring && !w[1].ring);
    CHECK(!lw_body_shapes_gear(&s, 0, w));
    lw_scene_free(&s);
    planet_scene(&s);
    check_mesh(&s, 2);
    check_mesh(&s, 7);
    CHECK(lw_body_shapes_gear(&s, 2, w));
    CHECK(w[0].ring && !w[1].ring && !w[1].gap);
    CHECK_NEAR(w[0].radius, 3.2, 1e-9, 0);
}

/* The rack reaches as far as the pinion rolls: 0.8 a radian of it, over 1.25 radians each way. */
TEST(racks_are_long_enough)
{
    OWN(lw_scene) s = { 0 };
    lw_wheel w[2];
    planet_scene(&s);
    CHECK(lw_body_shapes_gear(&s, 6, w));
    CHECK(!w[0].rack && w[1].rack && w[1].gap);
    CHECK_NEAR(w[0].radius, 0.8, 1e-12, 0);
    CHECK_NEAR(w[1].hi, 1, 1e-9, 0);
    CHECK_NEAR(w[1].lo, -1, 1e-9, 0);
    CHECK_NEAR(w[0].pitch, w[1].pitch, 0, 1e-12);
}

static bool has_node(const lw_scene *s, int link, lw_vec2 at)
{
    lw_vec2 node[LW_NODE_MAX];
    int n = lw_body_shapes_nodes(s, link, node, LW_NODE_MAX);
    for (int i = 0; i < n; i++)
        if (lw_v2_norm(lw_v2_sub(node[i], at)) < 1e-12)
            return true;
    return false;
}

TEST(welds_join_their_links)
{
    OWN(lw_scene) s = { 0 };
    planet_scene(&s);
    CHECK(has_node(&s, 2, lw_v2(2.6, 0.4)) && has_node(&s, 3, lw_v2(2.6, 0.4)));
    CHECK(!has_node(&s, 1, lw_v2(2.6, 0.4)));
    for (size_t f = 0; f < s.n_frame; f++)
        CHECK_NEAR(remainder(turn_of(&s, f, 2) - turn_of(&s, f, 3), 2*LW_PI), 0, 1e-9, 0);
}

/* Of both cylinders of the loader, in every frame: the rod's pin stands outside of the tube, the piston inside. */
TEST(pistons_stay_in_their_tubes)
{
    OWN(lw_scene) s = { 0 };
    OWN(lw_model) m = { 0 };
    lw_scene_options o = lw_scene_options_default();
    load_planar("examples/loader.json", &m);
    o.model = &m;
    CHECK_OK(lw_scene_make(m.small, NULL, &o, &s, &check_error));
    for (int j = 2; j <= 6; j += 4) {
        lw_cylinder c;
        CHECK(lw_body_shapes_cylinder(&s, j, &c));
        CHECK_INT(c.tube, m.linkage.joint[j].link[0]);
        CHECK_INT(c.rod, m.linkage.joint[j].link[1]);
        for (size_t f = 0; f < s.n_frame; f++) {
            lw_vec2 a = lw_scene_at(&s, f, c.tube, c.pin[0]), b = lw_scene_at(&s, f, c.rod, c.pin[1]);
            double length = lw_v2_norm(lw_v2_sub(b, a)), piston = length - c.rod_length;
            CHECK(length > c.tube_length && piston > 0 && piston < c.tube_length);
        }
    }
    CHECK(!lw_body_shapes_cylinder(&s, 0, &(lw_cylinder){ .tube = 0 }));
}
