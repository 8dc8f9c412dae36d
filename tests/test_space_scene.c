/* test_space_scene.c - scenes of spatial models: links stay rigid, joints stay together, closed motions close; the
 * projection; pages that a reader of JSON understands. */
#include "catalogues/draw/space_scene.h"

#include <jansson.h>
#include <stdlib.h>
#include "base/bytes.h"
#include "base/vec3.h"
#include "catalogues/draw/labels.h"
#include "catalogues/pages/draw.h"
#include "mbs/elastic/expand_space.h"
#include "tests/spatial_models.h"

static const char *const examples[] = {
    "examples/space/bennett.json", "examples/space/bricard.json", "examples/space/sarrus.json",
    "examples/space/slider-crank.json", "examples/space/stewart.json", "examples/space/delta.json",
    "examples/space/arm.json",
};
enum { N_EXAMPLE = sizeof examples/sizeof *examples };

enum { PATH_STEPS = 4 };                 /* points of a path from frame to frame */

static lw_space_scene make_scene(const lw_spatial *m, double until)
{
    lw_space_scene s;
    lw_space_scene_options o = { .n_frame = 24, .until = until };
    CHECK_OK(lw_space_scene_make(m, &o, &s, &check_error));
    return s;
}

/* The place of a joint by each of its links: together, or for those that slide on the axis or in the plane. */
static double gap(const lw_space_scene *s, const lw_spatial_joint *j, size_t frame)
{
    lw_vec3 a = lw_space_scene_at(s, frame, j->link[0], j->at), b = lw_space_scene_at(s, frame, j->link[1], j->at);
    lw_vec3 d = lw_v3_sub(b, a), axis = lw_v3_sub(lw_space_scene_at(s, frame, j->link[0], lw_v3_add(j->at, j->axis)), a);
    switch (j->kind) {
    case LW_SPATIAL_PRISMATIC: case LW_SPATIAL_CYLINDRICAL: case LW_SPATIAL_SCREW:
        return lw_v3_norm(lw_v3_sub(d, lw_v3_scale(axis, lw_v3_dot(d, axis))));
    case LW_SPATIAL_PLANAR: return fabs(lw_v3_dot(d, axis));
    case LW_SPATIAL_FREE:   return 0;
    default:                return lw_v3_norm(d);
    }
}

TEST(joints_stay_together)
{
    for (int i = 0; i < N_EXAMPLE; i++) {
        OWN(lw_spatial) m = { 0 };
        load_spatial_file(examples[i], &m);
        OWN(lw_space_scene) s = make_scene(&m, 0.1);
        CHECK(s.n_frame > 10);
        double moved = 0;
        for (size_t f = 0; f < s.n_frame; f++) {
            for (int j = 0; j < m.n_joint; j++)
                CHECK(gap(&s, &m.joint[j], f) < 1e-9*s.radius);
            for (int k = 0; k < s.n_tracer; k++) {        /* the path of a tracer is that of its point on the link */
                lw_vec3 p = lw_space_scene_at(&s, f, m.tracer[k].link, m.tracer[k].at);
                CHECK(lw_v3_norm(lw_v3_sub(p, s.path[PATH_STEPS*f*(size_t)s.n_tracer + (size_t)k])) < 1e-9*s.radius);
                moved = fmax(moved, lw_v3_norm(lw_v3_sub(p, s.path[k])));
            }
        }
        CHECK(moved > 0.01*s.radius);
    }
}

/* A slide is drawn as long as its block moves: on a ground that rests and on a link that moves and turns. */
TEST(blocks_stay_on_their_guides)
{
    OWN(lw_spatial) m = { 0 };
    read_spatial("{'linkwright': 1, 'links': ['ground', 'bridge', 'arm', 'mast'], 'joints': ["
                 "{'name': 'X', 'kind': 'prismatic', 'links': ['ground', 'bridge'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}, "
                 "{'name': 'R', 'kind': 'revolute', 'links': ['bridge', 'arm'], 'at': [0, 0.2, 0], 'axis': [0, 1, 0]}, "
                 "{'name': 'Z', 'kind': 'prismatic', 'links': ['arm', 'mast'], 'at': [0, 0.2, -0.3], 'axis': [0.6, 0, 0.8]}], 'inputs': ["
                 "{'joint': 'X', 'motion': '2*sin(t)'}, {'joint': 'R', 'motion': '3*t'}, {'joint': 'Z', 'motion': '-3*t'}], "
                 "'tracers': [{'name': 'P', 'link': 'mast', 'at': [0, 0.2, -0.5]}]}", "slides", &m);
    OWN(lw_space_scene) s = make_scene(&m, 1);
    int guides = 0;
    for (int i = 0; i < s.n_shape; i++) {
        if (s.shape[i].kind != LW_SPACE_GUIDE)
            continue;
        const lw_spatial_joint *j = &m.joint[s.shape[i].item];
        double least = INFINITY, most = 0;
        for (size_t f = 0; f < s.n_frame; f++) {
            lw_vec3 block = lw_space_scene_at(&s, f, j->link[1], j->at);
            lw_vec3 a = lw_space_scene_point(&s, f, &s.shape[i], 0), b = lw_space_scene_point(&s, f, &s.shape[i], 1);
            double past = lw_v3_norm(lw_v3_sub(block, a)) + lw_v3_norm(lw_v3_sub(block, b)) - lw_v3_norm(lw_v3_sub(a, b));
            CHECK_NEAR(past, 0, 1e-9*s.radius, 0);
            least = fmin(least, lw_v3_norm(lw_v3_sub(block, a)));
            most = fmax(most, lw_v3_norm(lw_v3_sub(block, a)));
        }
        CHECK(most - least > 1.6);
        guides++;
    }
    CHECK_INT(guides, 2);
}

/* Ties lead from link to link; a cylinder is no shorter than its tube on its stroke, and the links reach to the ends of both. */
TEST(ties)
{
    OWN(lw_spatial) m = { 0 };
    read_spatial("{'linkwright': 1, 'links': ['ground', {'name': 'boom', 'mass': 1, 'centre': [2, 0, 0], 'inertia': [1, 1, 1]}], 'joints': ["
                 "{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'boom'], 'at': [0, 0, 0], 'axis': [0, -1, 0]}], 'input': {'joint': 'A', 'first': 0, "
                 "'last': 0.5}, 'cylinders': [{'name': 'C', 'links': ['ground', 'boom'], 'at': [[0.4, 0, -0.8], [1, 0, 0]], 'bore': 0.1, 'retracted': 0.9, "
                 "'stroke': 0.6, 'dead_volume': 1e-3}], 'springs': [{'name': 'S', 'links': ['boom', 'ground'], 'at': [[1.5, 0, -0.2], [2, 0, 2]], "
                 "'stiffness': 100}], 'tracers': [{'name': 'tip', 'link': 'boom', 'at': [3, 0, 0]}]}", "ties", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    int ties = 0, corners = 0;
    for (int i = 0; i < s.n_shape; i++) {
        const lw_space_shape *t = &s.shape[i];
        if (t->kind == LW_SPACE_PLATE && t->link == 1)
            corners = t->n;
        if (t->kind != LW_SPACE_TIE)
            continue;
        const lw_spring *of = &m.spring[t->item];
        for (size_t f = 0; f < s.n_frame; f++) {
            lw_vec3 end[2];
            for (int k = 0; k < 2; k++) {
                end[k] = lw_space_scene_point(&s, f, t, k);
                CHECK(lw_v3_norm(lw_v3_sub(end[k], lw_space_scene_at(&s, f, of->link[k], of->at[k]))) < 1e-12);
            }
            CHECK(t->tube == 0 || lw_v3_norm(lw_v3_sub(end[1], end[0])) > t->tube);
        }
        CHECK((t->tube > 0) == (strcmp(of->name, "C") == 0));
        ties++;
    }
    CHECK_INT(ties, 2);
    CHECK_INT(corners, 3);                   /* the pin and the tip, with the cylinder's pin between them, and the spring below */
}

/* A body with nodes shows its mesh: where its matrix is full, the shortest tree between the nodes, in the order that they lie in; else the edges that
 * the matrix has.  In an animation each end moves with its node. */
TEST(meshes)
{
    enum { N = 4 };
    static const lw_vec3 at[N] = { { 0, 0, 0 }, { 2, 0, 0 }, { 1, 0, 0 }, { 3, 0, 0.5 } };
    static const int ring[N][2] = { { 0, 1 }, { 0, 2 }, { 1, 3 }, { 2, 3 } }, row[N - 1][2] = { { 0, 2 }, { 2, 1 }, { 1, 3 } };
    for (int full = 0; full < 2; full++) {
        double k[36*N*N] = { 0 };
        for (int e = 0; e < N*(N - 1)/2; e++) {
            static const int all[N*(N - 1)/2][2] = { { 0, 1 }, { 0, 2 }, { 1, 3 }, { 2, 3 }, { 0, 3 }, { 1, 2 } };
            for (int a = 0; a < 3 && (full || e < N); a++)
                for (int side = 0; side < 2; side++) {
                    int i = all[e][side], j = all[e][!side];
                    k[(6*i + a)*6*N + 6*i + a] += 1;
                    k[(6*i + a)*6*N + 6*j + a] = -1;
                }
        }
        int link[N] = { 1, 2, 3, 4 };
        lw_superelement body = { .n = N, .n_bound = N, .link = link, .at = (lw_vec3 *)(uintptr_t)at, .stiffness = k };
        lw_spatial_body node[N + 1] = { { .name = "ground" } };
        for (int i = 0; i < N; i++)
            node[i + 1] = (lw_spatial_body){ .given = true, .mass = 1, .centre = at[i] };
        lw_spatial m = { .n_link = N + 1, .body = node, .n_super = 1, .super = &body };
        OWN(lw_space_scene) s = make_scene(&m, 0);
        const int (*edge)[2] = full ? row : ring;
        CHECK_INT(s.n_shape, full ? N - 1 : N);
        for (int i = 0; i < s.n_shape; i++) {
            CHECK_INT(s.shape[i].link, link[edge[i][0]]);
            CHECK_INT(s.shape[i].to, link[edge[i][1]]);
        }
    }
}

/* Between its frames a path is that with four times as many frames, to 1e-3 where it is fastest; chords are 0.03 off. */
TEST(paths_between_frames)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial_file("examples/space/bennett.json", &m);
    lw_space_scene_options fine = { .n_frame = PATH_STEPS*24 };
    lw_space_scene s = make_scene(&m, 0), many;
    CHECK_OK(lw_space_scene_make(&m, &fine, &many, &check_error));
    CHECK_INT(s.n_path, PATH_STEPS*s.n_frame);
    CHECK_INT(s.n_path, many.n_frame);
    for (size_t i = 0; i < s.n_path && i < many.n_frame; i++)
        CHECK(lw_v3_norm(lw_v3_sub(s.path[i], many.path[PATH_STEPS*i])) < 1e-3*s.radius);
    lw_space_scene_free(&many);
    lw_space_scene_free(&s);
}

TEST(closed_motion)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("bennett", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    CHECK(s.loops);                                       /* the input of Bennett's linkage turns fully */
    CHECK_INT(s.n_frame, 24);
}

/* Axes are a right-handed set of unit vectors, and every shape is on the page. */
TEST(projection)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("stewart", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    for (int i = 0; i < 40; i++) {
        lw_space_view view = { .azimuth = 0.37*i, .elevation = -1.5707 + 0.08*i };
        lw_vec3 a[3];
        OWN(lw_drawing) d = { 0 };
        lw_space_view_axes(&s, view, a);
        for (int p = 0; p < 3; p++) {
            CHECK_NEAR(lw_v3_dot(a[p], a[p]), 1, 1e-14, 0);
            CHECK_NEAR(lw_v3_dot(a[p], a[(p + 1) % 3]), 0, 1e-14, 0);
        }
        CHECK_NEAR(lw_v3_dot(lw_v3_cross(a[0], a[1]), a[2]), 1, 1e-14, 0);
        CHECK_NEAR(lw_v3_dot(s.up, a[2]), sin(view.elevation), 1e-14, 0);
        CHECK_OK(lw_space_draw(&s, (size_t)i % s.n_frame, view, 400, 300, &d, &check_error));
        for (size_t k = 0; k < d.n_shape; k++)
            for (size_t p = 0; d.shape[k].kind == LW_SHAPE_PATH && p < d.shape[k].n; p++) {
                lw_vec2 at = d.point[d.shape[k].first + p];
                CHECK(at.x >= 0 && at.x <= 400 && at.y >= 0 && at.y <= 300);
            }
    }
}

/* From every side balls and tracers cover the ends of the bars that meet there. */
TEST(balls_cover_the_ends_of_bars)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("delta", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0.1);
    for (int i = 0; i < 40; i++) {
        OWN(lw_drawing) d = { 0 };
        int covered = 0;
        CHECK_OK(lw_space_draw(&s, 0, (lw_space_view){ .azimuth = 0.37*i, .elevation = -1.5707 + 0.08*i }, 400, 300, &d, &check_error));
        for (size_t k = 0; k < d.n_shape; k++)
            for (size_t b = 0; d.shape[k].kind == LW_SHAPE_CIRCLE && b < d.n_shape; b++) {
                const lw_shape *bar = &d.shape[b];
                bool meets = false;
                for (size_t p = 0; bar->role == LW_ROLE_LINK && bar->stroke == LW_INK_LINK && !bar->closed && p < bar->n; p++)
                    meets |= lw_v2_norm(lw_v2_sub(d.point[bar->first + p], d.shape[k].at)) < 1e-9;
                covered += meets;
                CHECK(!meets || b < k);
            }
        CHECK(covered >= 12);
    }
}

/* From every side all postures together fill the page between its margins, in one direction, and stand in its middle. */
TEST(pictures_are_filled)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("boom", &m);
    OWN(lw_space_scene) s = make_scene(&m, 10);
    for (int i = 0; i < 5; i++) {
        lw_box all = { INFINITY, INFINITY, -INFINITY, -INFINITY };
        for (size_t f = 0; f < s.n_frame; f++) {
            OWN(lw_drawing) d = { 0 };
            CHECK_OK(lw_space_draw(&s, f, (lw_space_view){ .azimuth = 0.9*i, .elevation = 0.3*i }, 400, 300, &d, &check_error));
            for (size_t k = 0; k < d.n_shape; k++) {
                const lw_shape *shape = &d.shape[k];
                bool path = shape->kind == LW_SHAPE_PATH;
                if (shape->kind == LW_SHAPE_TEXT || shape->role == LW_ROLE_PAPER || shape->role == LW_ROLE_AXIS || shape->role == LW_ROLE_SCALE)
                    continue;
                for (size_t p = 0; p < (path ? shape->n : 1); p++) {
                    lw_vec2 at = path ? d.point[shape->first + p] : shape->at;
                    all = (lw_box){ fmin(all.x0, at.x), fmin(all.y0, at.y), fmax(all.x1, at.x), fmax(all.y1, at.y) };
                }
            }
        }
        CHECK_NEAR(fmax((all.x1 - all.x0)/(400 - 72), (all.y1 - all.y0)/(300 - 96)), 1, 1e-9, 0);
        CHECK_NEAR(all.x0 + all.x1, 400, 1e-9, 0);
        CHECK_NEAR(all.y0 + all.y1, 300 + 24, 1e-9, 0);
    }
}

/* Until the inputs rest or repeat; a motion that ends at a limit lasts as long as its frames. */
TEST(motions_in_time_are_shown_to_their_end)
{
    static const struct { const char *motion; double seconds; bool loops; } of[] = {
        { "0.5*step(t, 0, 0, 3, 1)", 5, false }, { "0.5*sin(pi*t)", 2, true }, { "t", 1, false } };
    lw_spatial m;
    for (int i = 0; i < 3; i++) {
        load_spatial("arm", &m);
        for (int k = 0; k < m.n_input; k++)
            CHECK_OK(lw_spatial_set_motion(&m, k, of[i].motion, &check_error));
        OWN(lw_space_scene) s = make_scene(&m, 0);
        CHECK_NEAR(s.seconds, of[i].seconds, 1e-12, 0);
        CHECK_INT(s.loops, of[i].loops);
        lw_spatial_free(&m);
    }
    load_spatial("delta", &m);
    OWN(lw_space_scene) s = make_scene(&m, 1);
    CHECK(s.note[0] && s.n_frame > 1 && s.n_frame < 25);
    CHECK_NEAR(s.seconds, (double)(s.n_frame - 1)/24, 1e-12, 0);
    lw_spatial_free(&m);
}

/* The scale bar has its round length in the plane of the picture; names stand in still pictures, none on another. */
TEST(scale_and_names)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("stewart", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    for (int named = 0; named < 2; named++) {
        lw_space_view view = { .azimuth = 1, .elevation = 0.4, .names = named };
        OWN(lw_drawing) d = { 0 };
        lw_vec3 axis[3];
        lw_box name[64];
        lw_vec2 from[2] = { { 0, 0 } };                 /* place on the page and in the plane of the picture, of the first ball */
        double pixels = 0, length = 0;
        int n_name = 0, n_ball = 0;
        lw_space_view_axes(&s, view, axis);
        CHECK_OK(lw_space_draw(&s, 0, view, 1000, 750, &d, &check_error));
        for (size_t k = 0; k < d.n_shape; k++) {
            const lw_shape *shape = &d.shape[k];
            if (shape->role == LW_ROLE_SCALE && shape->kind == LW_SHAPE_PATH)
                pixels = d.point[shape->first + 2].x - d.point[shape->first + 1].x;
            else if (shape->role == LW_ROLE_SCALE)
                length = atof(d.text + shape->first)*m.units.metre;
            else if (shape->kind == LW_SHAPE_TEXT && (shape->role == LW_ROLE_LINK || shape->role == LW_ROLE_TRACER))
                name[n_name++] = (lw_box){ shape->at.x, shape->at.y - 8, shape->at.x + lw_text_width(d.text + shape->first, shape->width), shape->at.y };
        }
        CHECK(length > 0 && pixels > 50);
        for (size_t k = 0; k < d.n_shape; k++) {
            const lw_shape *shape = &d.shape[k];
            if (shape->kind != LW_SHAPE_CIRCLE || shape->role != LW_ROLE_JOINT)
                continue;
            lw_vec3 at = lw_space_scene_at(&s, 0, m.joint[shape->item].link[0], m.joint[shape->item].at);
            lw_vec2 flat = lw_v2(lw_v3_dot(at, axis[0]), -lw_v3_dot(at, axis[1]));
            if (n_ball++ == 0)
                from[0] = shape->at, from[1] = flat;
            lw_vec2 page = lw_v2_sub(shape->at, from[0]), far = lw_v2_scale(lw_v2_sub(flat, from[1]), pixels/length);
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(page, far)), 0, 1e-9*pixels, 0);
        }
        CHECK_INT(n_ball, 6);
        CHECK_INT(n_name, named ? m.n_link - 1 + m.n_tracer : 0);
        for (int i = 0; i < n_name; i++)
            for (int k = 0; k < i; k++)
                CHECK(name[i].x1 < name[k].x0 || name[k].x1 < name[i].x0 || name[i].y1 < name[k].y0 || name[k].y1 < name[i].y0);
    }
}

/* An element of an elastic link ends at its nodes, which move on their own. */
TEST(elastic_links_bend)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_spatial_expansion) x = { 0 };
    load_spatial("delta-elastic", &m);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    size_t links = (size_t)x.model.n_link;
    lw_vec3 *origin = calloc(links, sizeof *origin), *path = calloc((size_t)m.n_tracer + 1, sizeof *path);
    lw_space_pose *pose = calloc(links, sizeof *pose);
    int moved = x.chain[0].node[2], found = 0;
    lw_vec3 off = lw_v3(0.01, 0.02, 0.03);
    for (size_t i = 0; i < links; i++) {
        origin[i] = x.model.body[i].centre;
        pose[i] = (lw_space_pose){ (int)i == moved ? lw_v3_add(origin[i], off) : origin[i], { 1, 0, 0, 0 } };
    }
    lw_space_scene_options o = { .n_frame = 1, .pose = pose, .path = path, .origin = origin, .until = 1 };
    OWN(lw_space_scene) s = { 0 };
    CHECK_OK(lw_space_scene_make(&x.model, &o, &s, &check_error));
    for (int i = 0; i < s.n_shape; i++)
        for (int k = 0; s.shape[i].to >= 0 && k < 2; k++) {
            bool of_node = (k ? s.shape[i].to : s.shape[i].link) == moved;
            lw_vec3 d = lw_v3_sub(lw_space_scene_point(&s, 0, &s.shape[i], k), s.shape[i].p[k]);
            CHECK_NEAR(lw_v3_norm(d), of_node ? lw_v3_norm(off) : 0, 1e-15, 1e-12);
            found += of_node;
        }
    CHECK_INT(found, 2);
    free(origin), free(path), free(pose);
}

/* An element between two nodes at the ends of an arc, each turned along it, is drawn along the arc.  The cubic with slopes of the length of the arc
 * is 2 sin(angle/2)/8 high in its middle, 0.00132 less than the arc, whose chord is 0.0987 off. */
TEST(elements_bend_between_nodes)
{
    double k[144] = { 0 }, angle = 0.8, radius = 1/angle;
    for (int i = 0; i < 3; i++)
        k[12*i + i] = k[12*(6 + i) + 6 + i] = 1, k[12*i + 6 + i] = k[12*(6 + i) + i] = -1;
    int link[2] = { 1, 2 };
    lw_vec3 at[2] = { { 0, 0, 0 }, { 1, 0, 0 } }, origin[3] = { { 0, 0, 0 }, at[0], at[1] }, path[1], axis[3];
    lw_superelement body = { .n = 2, .n_bound = 2, .link = link, .at = at, .stiffness = k };
    lw_spatial_body node[3] = { { .name = "ground" }, { .given = true, .mass = 1 }, { .given = true, .mass = 1, .centre = at[1] } };
    lw_spatial m = { .n_link = 3, .body = node, .n_super = 1, .super = &body };
    lw_vec3 end = lw_v3(radius*sin(angle), 0, radius*(1 - cos(angle)));
    lw_space_pose pose[3] = { { origin[0], { 1, 0, 0, 0 } }, { at[0], { 1, 0, 0, 0 } }, { end, { cos(angle/2), 0, -sin(angle/2), 0 } } };
    lw_space_scene_options o = { .n_frame = 1, .pose = pose, .path = path, .origin = origin, .until = 1 };
    OWN(lw_space_scene) s = { 0 };
    CHECK_OK(lw_space_scene_make(&m, &o, &s, &check_error));
    lw_space_view view = { .azimuth = -0.5*LW_PI };
    OWN(lw_drawing) d = { 0 };
    lw_space_view_axes(&s, view, axis);
    CHECK_NEAR(fabs(axis[2].y), 1, 1e-12, 0);
    CHECK_OK(lw_space_draw(&s, 0, view, 800, 600, &d, &check_error));
    lw_vec2 place[2] = { { 0, 0 }, { lw_v3_dot(end, axis[0]), -lw_v3_dot(end, axis[1]) } }, first = { 0, 0 }, last = { 0, 0 };
    double scale = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0, n = 0; i < d.n_shape; i++)
            for (size_t p = 0; d.shape[i].role == LW_ROLE_LINK && d.shape[i].stroke == LW_INK_LINK && p < d.shape[i].n; p++, n++) {
                lw_vec2 dot = d.point[d.shape[i].first + p];
                if (pass == 0) {                 /* the ends are the leftmost and the rightmost point */
                    first = n == 0 || dot.x < first.x ? dot : first;
                    last = n == 0 || dot.x > last.x ? dot : last;
                    scale = lw_v2_norm(lw_v2_sub(last, first))/lw_v2_norm(place[1]);
                    continue;
                }
                lw_vec2 from = lw_v2_scale(lw_v2_sub(dot, place[1].x > 0 ? first : last), 1/scale);
                lw_vec2 centre = { 0, -radius*axis[1].z };
                CHECK_NEAR(lw_v2_norm(lw_v2_sub(from, centre)), radius, 0.00133, 0);
            }
    CHECK(scale > 100);
}

/* A frame of three bars whose joint lies beside the second: three bars along its axis, an arm, and across its end the flange on the ground. */
TEST(elastic_frames_have_corners)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'f', 'elastic': {'section': {'shape': 'round', "
        "'diameter': 0.02}, 'material': 'steel', 'axis': [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1]]}}], 'joints': [{'name': 'A', "
        "'kind': 'fixed', 'links': ['ground', 'f'], 'at': [0.5, 0, 1.2]}]}";
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "frame", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    CHECK_INT(s.n_shape, 5);
    for (int i = 0; i < 3 && i < s.n_shape; i++)
        for (int k = 0; k < 2; k++)
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(s.shape[i].p[k], m.elastic[1].axis[i + k])), 0, 0, 0);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(s.shape[3].p[0], lw_v3(0.5, 0, 1))), 0, 1e-15, 0);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(s.shape[3].p[1], lw_v3(0.5, 0, 1.2))), 0, 1e-15, 0);
    CHECK(s.shape[4].kind == LW_SPACE_PLATE && s.shape[4].grounded);
    for (int k = 0; k < 4; k++) {
        CHECK_NEAR(s.shape[4].p[k].z, 1.2, 1e-12, 0);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(s.shape[4].p[k], lw_v3(0.5, 0, 1.2))), 1.2*0.035*lw_spatial_size(&m)*sqrt(2), 0.05, 0);
    }
}

/* Joints in a plane make a plate, and a tool beside the plane stands on it.  A weld on a hinge has no sign of its own, another one has. */
TEST(platforms_and_welds)
{
    OWN(lw_spatial) m = { 0 };
    read_spatial("{'linkwright': 1, 'links': ['ground', 'hub', 'platform', 'foot'], 'joints': ["
                 "{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'hub'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, "
                 "{'name': 'W', 'kind': 'fixed', 'links': ['hub', 'platform'], 'at': [0, 0, 0]}, "
                 "{'name': 'B', 'kind': 'spherical', 'links': ['platform', 'foot'], 'at': [1, 0, 0]}, "
                 "{'name': 'V', 'kind': 'fixed', 'links': ['platform', 'foot'], 'at': [0, 1, 0]}], "
                 "'tracers': [{'name': 'tool', 'link': 'platform', 'at': [0.2, 0.4, 0.7]}]}", "platform", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    int plates = 0, flanges = 0, arms = 0;
    for (int i = 0; i < s.n_shape; i++) {
        const lw_space_shape *t = &s.shape[i];
        plates += t->kind == LW_SPACE_PLATE && t->n == 3 && t->link == 2;
        flanges += t->kind == LW_SPACE_PLATE && t->n == 4 && t->item == 3 && !t->grounded;
        arms += t->kind == LW_SPACE_BAR && t->link == 2 && lw_v3_norm(lw_v3_sub(t->p[0], lw_v3(1.0/3, 1.0/3, 0))) < 1e-15;
    }
    CHECK_INT(plates, 1);
    CHECK_INT(flanges, 1);
    CHECK_INT(arms, 1);
    CHECK_INT(s.n_shape, 7);                 /* the foot, the pin, the ball and the tool, too */
}

/* An input without a range is shown between the ends of the stop of its joint, a turn and a slide, from its value in the file. */
TEST(stops_limit_the_input)
{
    for (int slides = 0; slides < 2; slides++) {
        OWN(lw_spatial) m = { 0 };
        char text[600];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'a'], 'joints': [{'name': 'A', 'kind': '%s', 'links': ['ground', 'a'], "
                 "'at': [0, 0, 0], 'axis': [0, 0, 1], 'stop': {'least': -0.2, 'greatest': 0.5}}], 'inputs': [{'joint': 'A', 'value': 3}], "
                 "'tracers': [{'name': 'T', 'link': 'a', 'at': [1, 0, 0]}]}", slides ? "prismatic" : "revolute");
        read_spatial(text, "stops", &m);
        OWN(lw_space_scene) s = make_scene(&m, 0);
        CHECK_TEXT(s.note, "");
        CHECK(!s.loops);
        for (int end = 0; end < 2; end++) {
            double u = end ? 0.5 : -0.2;
            lw_vec3 at = lw_space_scene_at(&s, end ? s.n_frame - 1 : 0, 1, lw_v3(1, 0, 0));
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(at, slides ? lw_v3(1, 0, u) : lw_v3(cos(u), sin(u), 0))), 0, 1e-12, 0);
        }
    }
}

TEST(files)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("slider-crank", &m);
    OWN(lw_space_scene) s = make_scene(&m, 0);
    static const struct { lw_draw_kind kind; const char *begin; } file[] = {
        { LW_DRAW_SVG, "<?xml" }, { LW_DRAW_PDF, "%PDF" }, { LW_DRAW_PNG, "\x89PNG" }, { LW_DRAW_GIF, "GIF89a" },
        { LW_DRAW_HTML, "<!DOCTYPE html>" }
    };
    for (size_t i = 0; i < sizeof file/sizeof *file; i++) {
        OWN(lw_bytes) out = { 0 };
        CHECK_OK(lw_draw_space(&s, lw_space_view_default(), file[i].kind, 200, 150, &out, &check_error));
        CHECK(out.size > 500 && memcmp(out.data, file[i].begin, strlen(file[i].begin)) == 0);
        if (file[i].kind == LW_DRAW_HTML && out.data) {
            const char *from = strstr(out.data, "id=\"data\">"), *to = from ? strstr(from, "</script>") : NULL;
            json_auto_t *data = to ? json_loadb(from + 10, (size_t)(to - from) - 10, 0, NULL) : NULL;
            CHECK(data != NULL);
            CHECK_INT(json_array_size(json_object_get(data, "frames")), s.n_frame);
            CHECK_INT(json_array_size(json_array_get(json_object_get(data, "frames"), 0)), 7*s.n_link);
            CHECK_INT(json_array_size(json_object_get(data, "shapes")), s.n_shape);
            CHECK_NEAR(json_number_value(json_object_get(data, "radius"))*m.units.metre, s.radius, 0, 1e-5);
            CHECK_TEXT(json_string_value(json_object_get(data, "unit")), m.units.length[0] ? m.units.length : "m");
        }
    }
}
