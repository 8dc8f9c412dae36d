/* The motion as numbers: curves come back as targets, poses carry the tracer along the curve. */
#include "catalogues/exchange/export.h"

#include "catalogues/draw/scene.h"
#include "optimise/task/target_outline.h"
#include "tests/example_linkage.h"

static const char *const names[] = { "hoeken", "klann", "slider-crank", "chebyshev" };

TEST(a_curve_comes_back_as_target)
{
    for (size_t i = 0; i < sizeof names/sizeof *names; i++) {
        lw_linkage k = example(names[i]);
        OWN(lw_bytes) b = { 0 };
        OWN(lw_scene) s = { 0 };
        OWN(lw_target) t = { 0 };
        CHECK_OK(lw_export_svg(LW_VIEW(&k), NULL, &b, &check_error));
        lw_target_options drawn = { .closed = -1, .curve = "1", .stations = -1 };
        CHECK_SILENT(lw_target_read_svg(b.data, b.size, "t", &drawn, &t, &check_error));
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        CHECK_INT(t.n, s.curve[0].n);
        CHECK_INT(t.closed, s.curve[0].closed);
        for (size_t n = 0; n < t.n && n < s.curve[0].n; n++) {
            CHECK_NEAR(t.x[n], s.curve[0].p[n].x, 1e-11*lw_export_size(LW_VIEW(&k)), 0);
            CHECK_NEAR(t.y[n], s.curve[0].p[n].y, 1e-11*lw_export_size(LW_VIEW(&k)), 0);
        }
    }
}

/* Every row of the table puts the link's pins where the rows of its neighbours put them. */
TEST(poses_keep_pins_together)
{
    static double x[LW_EXPORT_FRAMES][8], y[LW_EXPORT_FRAMES][8], turn[LW_EXPORT_FRAMES][8];
    lw_linkage k = example("klann");
    OWN(lw_bytes) b = { 0 };
    OWN(lw_scene) s = { 0 };
    CHECK_INT(lw_export_poses(LW_VIEW(&k), NULL, &b, NULL), LW_OK);
    CHECK_INT(lw_scene_make(&k, NULL, NULL, &s, NULL), LW_OK);
    CHECK_HAS(b.data, "# units: m deg\nframe,input,link,x,y,turn\n0,");
    char *row = strstr(b.data, "\n0,") + 1;
    int rows = 0;
    for (; *row; row = strchr(row, '\n') + 1, rows++) {
        int f, link = 0;
        double input, v[3];
        char name[40];
        CHECK_INT(sscanf(row, "%d,%lf,%39[^,],%lf,%lf,%lf", &f, &input, name, &v[0], &v[1], &v[2]), 6);
        while (link < k.n_link && strcmp(k.link_name[link], name) != 0)
            link++;
        CHECK(f >= 0 && f < LW_EXPORT_FRAMES && link < k.n_link);
        x[f][link] = v[0];
        y[f][link] = v[1];
        turn[f][link] = v[2]*LW_PI/180;
    }
    CHECK_INT(rows, LW_EXPORT_FRAMES*k.n_link);
    for (int f = 0; f < LW_EXPORT_FRAMES; f++)
        for (int j = 0; j < k.n_joint; j++) {
            lw_vec2 at[2];
            for (int i = 0; i < 2; i++) {
                int link = k.joint[j].link[i];
                lw_vec2 arm = lw_v2_sub(k.joint[j].at, s.origin[link]);
                at[i] = lw_v2_add(lw_v2(x[f][link], y[f][link]), lw_v2_turn(arm, lw_v2_polar(1, turn[f][link])));
            }
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(at[0], at[1])), 0, 1e-10, 0);
        }
}

TEST(joints_as_json)
{
    lw_linkage k = example("slider-crank");
    lw_bytes b = { 0 };
    snprintf(k.link_name[1], LW_NAME_SIZE, "a\"b\\");
    CHECK_OK(lw_export_joints(LW_VIEW(&k), NULL, &b, &check_error));
    CHECK_HAS(b.data, "\"type\": \"prismatic\", \"coord\": [96.7654746701, 10], \"angle\": 0, \"ground\": true}");
    CHECK_HAS(b.data, "{\"name\": \"a\\\"b\\\\\", \"ground\": false, \"joints\": [0, 1]}");
    CHECK_HAS(b.data, "\"actuators\": [0]");
    CHECK_HAS(b.data, "\"closed\": true, \"curve\": [[");
    lw_bytes_free(&b);
    k = example("hoeken");
    k.n_input = 0;
    CHECK_FAILS(lw_export_joints(LW_VIEW(&k), NULL, &b, &check_error), LW_E_KIND, "the motion is not known");
    k = example("slider-crank");
    k.n_tracer = 0;
    CHECK_INT(lw_export_svg(LW_VIEW(&k), NULL, &b, &check_error), LW_E_KIND);
}
