/* Scenes: links stay rigid and joined in every frame, curves are where the tracer goes, limits are the
 * four-bar's own, motion is followed through them, size does not matter. */
#include "catalogues/draw/scene.h"
#include "catalogues/draw/walk.h"
#include "grammar/model/model.h"
#include "mbs/kinematics/fourbar.h"
#include "mbs/plan/types.h"
#include "tests/check.h"
#include "tests/large_models.h"
#include "tests/scene_models.h"

static double distance(lw_vec2 a, lw_vec2 b) { return lw_v2_norm(lw_v2_sub(a, b)); }

/* Every pin is at one place whichever of its two links carries it; sliders stay on their lines. */
static void check_joined(const lw_scene *s, double size, double share)
{
    const lw_assembly *k = &s->linkage;
    for (size_t f = 0; f < s->n_frame; f++)
        for (int i = 0; i < k->n_joint; i++) {
            const lw_joint *j = &k->joint[i];
            lw_vec2 d = lw_v2_sub(lw_scene_at(s, f, j->link[0], j->at), lw_scene_at(s, f, j->link[1], j->at));
            if (j->kind == LW_JOINT_REVOLUTE || j->kind == LW_JOINT_FIXED)
                CHECK_NEAR(lw_v2_norm(d), 0, share*size, 0);
            else if (j->kind != LW_JOINT_GEAR) {
                lw_vec2 turn = s->place[f*(size_t)k->n_link + (size_t)j->link[0]].turn;
                CHECK_NEAR(lw_v2_cross(d, lw_v2_turn(j->along, turn)), 0, share*size, 0);
            }
        }
}

/* Distance of p from the polygon of a curve. */
static double from_curve(const lw_curve *c, lw_vec2 p)
{
    double best = INFINITY;
    for (size_t i = 0; i + (c->closed ? 0 : 1) < c->n; i++) {
        lw_vec2 a = c->p[i], d = lw_v2_sub(c->p[(i + 1) % c->n], a);
        double l2 = lw_v2_dot(d, d), t = l2 > 0 ? lw_v2_dot(lw_v2_sub(p, a), d)/l2 : 0;
        best = fmin(best, distance(p, lw_v2_add(a, lw_v2_scale(d, fmin(fmax(t, 0), 1)))));
    }
    return best;
}

static void check_on_curve(const lw_scene *s, double size)
{
    for (int i = 0; i < s->n_curve; i++) {
        const lw_tracer *t = &s->linkage.tracer[s->curve[i].tracer];
        for (size_t f = 0; s->curve[i].shown_branch && f < s->n_frame; f++)
            CHECK_NEAR(from_curve(&s->curve[i], lw_scene_at(s, f, t->link, t->at)), 0, 2e-3*size, 0);
    }
}

static void check_first_frame(const lw_scene *s, double size)
{
    CHECK(s->first_frame < s->n_frame);
    for (int i = 0; i < s->linkage.n_joint; i++) {
        const lw_joint *j = &s->linkage.joint[i];
        CHECK_NEAR(distance(lw_scene_at(s, s->first_frame, j->link[1], j->at), j->at), 0, 1e-7*size, 0);
    }
}

TEST(examples_move_as_one)
{
    for (size_t i = 0; i < MODEL_FILES; i++) {
        lw_linkage k;
        OWN(lw_scene) s = { 0 };
        k = example(model_files[i]);
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        CHECK_TEXT(s.note, "");
        CHECK_INT(s.n_frame, 120);
        check_joined(&s, 0.2, 1e-9);
        check_on_curve(&s, 0.2);
        check_first_frame(&s, 0.2);
    }
}

/* Gears, inputs between moving links, more bars than needed: along their curves of postures. */
TEST(what_is_not_made_of_dyads_moves)
{
    static const struct { const char *name; bool loops; double size; int turns; } known[] = {
        { "geared-five-bar", true, 0.1, 2 }, { "five-bar", true, 0.2, 1 }, { "loader", true, 3, 0 },
        { "mobility/parallelogram", true, 5, 1 }, { "mobility/focal", true, 3, 0 },
        { "mobility/roller", true, 3, 1 },                                 /* the roller is made fast */
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_linkage k;
        OWN(lw_scene) s = { 0 };
        k = example(known[i].name);
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        CHECK_TEXT(s.note, "");
        CHECK_INT(s.n_frame, 120);
        CHECK_INT(s.loops, known[i].loops);
        CHECK_INT(s.first_frame, 0);
        CHECK_INT(s.n_curve, k.n_tracer);
        check_joined(&s, known[i].size, 1e-9);
        check_on_curve(&s, known[i].size);
        check_first_frame(&s, known[i].size);
        if (known[i].turns)
            CHECK_NEAR(s.input[119] - s.input[0], 2*LW_PI*known[i].turns*119/120, 1e-6, 0);
    }
}

/* Quick motions: joined as well, from the same posture, on the curves of the motion that is followed with proof. */
TEST(drafts_lie_on_the_whole_curves)
{
    static const struct { const char *name; double size; } known[] = {
        { "geared-five-bar", 0.1 }, { "loader", 3 }, { "mobility/roller", 3 }, { "gallery/peaucellier", 0.3 },
        { "gallery/scott-russell", 0.3 }, { "gallery/excavator", 3 }, { "gallery/scissor-lift", 0.8 },
        { "gallery/evans", 0.3 }, { "gallery/strandbeest", 0.3 }, { "tied-five-bar", 0.2 }, { "hoeken", 0.1 },
        { "inverted-slider-crank", 0.2 }, { "gallery/scotch-yoke", 0.2 }, { "gallery/watt", 0.3 }, { "gallery/ackermann", 2 },
        { "jansen", 0.2 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_linkage k;
        OWN(lw_scene) whole = { 0 }, s = { 0 };
        lw_scene_options o = { .n_frame = 60, .n_curve_point = 600 };
        k = example(known[i].name);
        CHECK_OK(lw_scene_make(&k, NULL, &o, &whole, &check_error));
        check_joined(&whole, known[i].size, 1e-5);
        o.draft = true;
        CHECK_OK(lw_scene_make(&k, NULL, &o, &s, &check_error));
        CHECK(s.note[0] == 0 && s.n_frame >= 59 && s.n_frame <= 61 && s.n_curve >= k.n_tracer);
        check_joined(&s, known[i].size, 1e-5);
        check_on_curve(&s, known[i].size);
        check_first_frame(&s, known[i].size);
        double far = 0;
        for (int c = 0; c < s.n_curve; c++)
            for (size_t p = 0; p < s.curve[c].n && s.curve[c].shown_branch; p++) {
                double best = INFINITY;
                for (int d = 0; d < whole.n_curve; d++)
                    if (whole.curve[d].tracer == s.curve[c].tracer)
                        best = fmin(best, from_curve(&whole.curve[d], s.curve[c].p[p]));
                far = fmax(far, best);
            }
        CHECK_NEAR(far, 0, 2e-3*known[i].size, 0);
    }
}

/* Wheel and pinion of the geared five-bar turn against each other as the teeth tell. */
TEST(gears_turn_against_each_other)
{
    lw_linkage k;
    OWN(lw_scene) s = { 0 };
    k = example("geared-five-bar");
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    double before[2] = { 0, 0 }, sum[2] = { 0, 0 };
    for (size_t f = 1; f < s.n_frame; f++) {
        for (int i = 0; i < 2; i++) {
            lw_vec2 turn = s.place[f*(size_t)k.n_link + (size_t)k.joint[5].link[i]].turn;
            double angle = atan2(turn.y, turn.x);
            sum[i] += remainder(angle - before[i], 2*LW_PI);
            before[i] = angle;
        }
        CHECK_NEAR(sum[1], k.joint[5].ratio*sum[0], 1e-9, 0);
    }
    CHECK_NEAR(fabs(sum[0]), 4*LW_PI*119/120, 1e-6, 0);
}

/* Part of the input's range, on a curve that turns and on one that swings: there and back. */
TEST(wanted_range_of_a_curve)
{
    static const struct { const char *name; double first, last; } known[] = {
        { "geared-five-bar", -0.5, 4.5 }, { "loader", -0.1, 0.5 }, { "mobility/parallelogram", -1, 0.5 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_linkage k;
        OWN(lw_scene) s = { 0 };
        k = example(known[i].name);
        k.n_input = 1;
        if (i == 1) {                                               /* the other cylinder is shut */
            k.joint[6].kind = LW_JOINT_FIXED;
            k.joint[6].along = lw_v2(0, 0);
        }
        double now = k.input[0].value;
        k.input[0].first = now + known[i].first;
        k.input[0].last = now + known[i].last;
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        CHECK_TEXT(s.note, "");
        CHECK(!s.loops);
        CHECK_NEAR(s.input[0], now + known[i].first, 1e-9, 0);
        CHECK_NEAR(s.input[s.n_frame - 1], now + known[i].last, 1e-9, 0);
        CHECK_INT(s.n_curve, 2*k.n_tracer);
        CHECK(!s.curve[0].shown_branch && s.curve[1].shown_branch && !s.curve[1].closed);
        check_joined(&s, 3, 1e-9);
        check_first_frame(&s, 3);
    }
}

static lw_status timed_scene(const char *path, double until, lw_model *m, lw_scene *s)
{
    lw_error e;
    lw_scene_options o = lw_scene_options_default();
    load_planar(path, m);
    o.model = m;
    o.until = until;
    return lw_scene_make(m->small, NULL, &o, s, &e);
}

/* Both cylinders of the loader run out together and rest after 2 s; both motors of the five-bar begin again after 1 s. */
TEST(several_inputs_move_together)
{
    OWN(lw_model) m = { 0 };
    OWN(lw_scene) s = { 0 };
    CHECK_INT(timed_scene("examples/loader.json", 0, &m, &s), LW_OK);
    CHECK_TEXT(s.note, "");
    CHECK(!s.loops);
    CHECK_NEAR(s.input[0], 0, 1e-12, 0);
    CHECK_NEAR(s.input[s.n_frame - 1], 0.55, 1e-12, 0);
    check_joined(&s, 3, 1e-9);
    check_on_curve(&s, 3);
    check_first_frame(&s, 3);
    lw_scene_free(&s);
    lw_model_free(&m);
    CHECK_INT(timed_scene("examples/five-bar.json", 0, &m, &s), LW_OK);
    CHECK(s.loops && s.curve[0].closed);
    check_joined(&s, 0.2, 1e-9);
    check_on_curve(&s, 0.2);
    lw_scene_free(&s);
    lw_model_free(&m);
    CHECK_INT(timed_scene("examples/five-bar.json", 0.25, &m, &s), LW_OK);
    CHECK(!s.loops);
    CHECK_NEAR(s.input[s.n_frame - 1], s.input[0] + 0.3, 1e-6, 0);
}

/* Ranges of two inputs: both go from end to end at once; beyond reach the motion ends before, and says so. */
TEST(ranges_of_several_inputs)
{
    lw_linkage k;
    OWN(lw_scene) s = { 0 };
    k = example("five-bar");
    for (int i = 0; i < 2; i++) {
        k.input[i].first = k.input[i].value;
        k.input[i].last = k.input[i].value + (i ? -0.2 : 0.3);
    }
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    CHECK_TEXT(s.note, "");
    CHECK_NEAR(s.input[s.n_frame - 1] - s.input[0], 0.3, 1e-12, 0);
    check_joined(&s, 0.2, 1e-9);
    lw_scene_free(&s);
    k.joint[1].at.x += 0.03;                                /* stretched, the cranks pull the rods straight */
    k.input[0].last = k.input[0].value + 0.9273;
    k.input[1].last = k.input[1].value - 1.5708;
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    CHECK_HAS(s.note, "Shown in part");
    CHECK(s.n_frame == 120 && s.input[119] - s.input[0] < 0.92);
    check_joined(&s, 0.2, 1e-9);
}

TEST(crank_turns_once)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene(NULL, 0, &s), LW_OK);
    CHECK(s.loops);
    CHECK_INT(s.first_frame, 0);
    CHECK_INT(s.n_dim, 9);
    CHECK_TEXT(s.title, "Four-bar");
    for (int i = 0; i < 9; i++)
        CHECK_NEAR(s.dim[i], model_crank_rocker[i], 1e-12, 0);
    for (size_t f = 1; f < s.n_frame; f++)
        CHECK_NEAR(s.input[f] - s.input[f - 1], 2*LW_PI/120, 1e-12, 0);
    CHECK(s.curve[0].closed && s.curve[0].shown_branch && s.curve[0].n >= 360);
}

/* Random four-bars: the walk's limits are those of the closed form, and its circuit is one of Barker's:
 * through the limits where the input has them, back where it began. */
TEST(walks_end_at_the_limits_of_the_four_bar)
{
    lw_rng r = check_rng(3);
    int n_turning = 0, n_limited = 0;
    for (int trial = 0; trial < 300; trial++) {
        double d[9] = { 0, 0, 0, 0, 0.5, 0.7, 1, 2, 0.4 }, t = lw_rng_range(&r, 0, 2*LW_PI);
        for (int i = 0; i < 4; i++)
            d[i] = lw_rng_range(&r, 0.5, 3);
        lw_fourbar_class c;
        double reach = sqrt(d[0]*d[0] + d[1]*d[1] - 2*d[0]*d[1]*cos(t));
        if (lw_fourbar_classify(d, 1e-12, &c, &check_error) != LW_OK || c.margin < 0.02
            || reach > 0.97*(d[2] + d[3]) || reach < 1.03*fabs(d[2] - d[3]))
            continue;
        lw_linkage k = model_four_bar(d, t, trial & 1 ? 1 : -1);
        lw_plan plan;
        double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
        lw_motion m;
        lw_walk w;
        CHECK_OK(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, &check_error));
        CHECK_OK(lw_plan_read(&plan, &k, dim, mode, &input, &check_error));
        CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
        lw_walk_make(&plan, dim, &m, lw_motion_arc(&plan, &m, mode, input), input, &w);
        CHECK_INT(w.turns, c.crank);
        CHECK(w.loops);
        CHECK_INT(w.n_stage, c.crank ? 1 : 2);
        n_turning += w.turns;
        for (int i = 0; i < w.n_stage && !w.turns; i++, n_limited++) {
            double off[2] = { INFINITY, INFINITY }, end[2] = { w.stage[i].from, w.stage[i].to };
            for (int q = 0; q < 2*c.n_limit; q++)
                off[q % 2] = fmin(off[q % 2], fabs(remainder(end[q % 2] - c.limit[q/2], 2*LW_PI)));
            CHECK_NEAR(off[0], 0, 1e-9, 0);
            CHECK_NEAR(off[1], 0, 1e-9, 0);
        }
    }
    CHECK(n_turning > 20 && n_limited > 20);
}

/* Without jumps: neighbouring frames of a motion through limits are near each other. */
TEST(motion_through_limits_is_smooth)
{
    const double d[9] = { 3, 2.5, 1.2, 2, 0.6, 0.5, 0, 0, 0 }; /* the crank cannot turn fully */
    lw_linkage k = model_four_bar(d, 0.9, 1);
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    CHECK(s.loops && s.curve[0].closed);
    for (size_t f = 0; f < s.n_frame; f++)
        for (int i = 0; i < k.n_joint; i++) {
            lw_vec2 a = lw_scene_at(&s, f, k.joint[i].link[1], k.joint[i].at);
            lw_vec2 b = lw_scene_at(&s, (f + 1) % s.n_frame, k.joint[i].link[1], k.joint[i].at);
            CHECK(distance(a, b) < 0.3);
        }
    check_joined(&s, 5, 1e-9);
    check_on_curve(&s, 5);
    check_first_frame(&s, 5);
}

TEST(wanted_range_only)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    k.input[0].first = k.input[0].value - 0.25;
    k.input[0].last = k.input[0].value + 0.75;
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    CHECK(!s.loops);
    CHECK_INT(s.n_curve, 2);                                    /* what is wanted, and the rest */
    CHECK(!s.curve[0].shown_branch && s.curve[1].shown_branch && !s.curve[1].closed);
    CHECK_NEAR(s.input[s.n_frame - 1] - s.input[0], 1, 1e-12, 0);
    for (size_t f = 1; f < s.n_frame; f++)
        CHECK(s.input[f] > s.input[f - 1]);
    check_first_frame(&s, 3);
}

/* Scaling by a power of two scales every number exactly. */
TEST(size_does_not_matter)
{
    for (int power = -30; power <= 30; power += 60) {
        double by = ldexp(1, power), d[9];
        for (int i = 0; i < 9; i++)
            d[i] = model_crank_rocker[i]*(i < 8 ? by : 1);
        lw_linkage k = model_four_bar(model_crank_rocker, 1, 1), big = model_four_bar(d, 1, 1);
        OWN(lw_scene) s = { 0 }, t = { 0 };
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        CHECK_OK(lw_scene_make(&big, NULL, NULL, &t, &check_error));
        CHECK_INT(t.curve[0].n, s.curve[0].n);
        for (size_t i = 0; i < s.curve[0].n; i++)
            CHECK_POINT(t.curve[0].p[i], by*s.curve[0].p[i].x, by*s.curve[0].p[i].y, 1e-14*by, 1e-13);
    }
}

TEST(target_points_are_kept)
{
    const double x[] = { 1, 2, 3 }, y[] = { 4, 5, 7 }, angle[] = { 0, 1, 2 };
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    OWN(lw_target) t = { 0 };
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_target_make(3, x, y, NULL, angle, NULL, 1, &t, &check_error));
    CHECK_OK(lw_scene_make(&k, &t, NULL, &s, &check_error));
    CHECK_INT(s.n_station, 3);
    CHECK(s.station_closed);
    CHECK(s.station[2].x == 3 && s.station[2].y == 7);
    lw_scene_free(&s);
    lw_target_free(&t);
    CHECK_OK(lw_target_make(3, NULL, NULL, y, angle, NULL, 0, &t, &check_error));      /* a function */
    CHECK_OK(lw_scene_make(&k, &t, NULL, &s, &check_error));
    CHECK_INT(s.n_station, 0);
}

/* What no plan can solve is shown as it stands, and says why. */
TEST(unsolvable_linkages_stand_still)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    k.n_input = 0;
    OWN(lw_scene) s = { 0 };
    lw_error e = { .status = LW_OK };
    CHECK_INT(lw_scene_make(&k, NULL, NULL, &s, &e), LW_OK);
    CHECK_INT(s.n_frame, 1);
    CHECK_INT(s.n_curve, 0);
    CHECK_HAS(s.note, "Shown without motion");
    check_first_frame(&s, 3);
    lw_scene_free(&s);
    k.joint[0].link[0] = 9;
    CHECK_INT(lw_scene_make(&k, NULL, NULL, &s, &e), LW_E_ARG);
}

/* A crank-rocker has two circuits, a four-bar in which nothing turns fully one; the two are mirrored
 * assemblies: same lengths, so the tracer is as far from A on both. */
TEST(other_circuits_are_found)
{
    static const struct { double r[9]; int n_curve; } known[] = {
        { { 2, 1, 2.5, 2.4, 1.5, 1.2, 0.3, -0.2, 0.2 }, 2 },
        { { 3, 2.5, 2, 2, 0.6, 0.5, 0, 0, 0 }, 1 },                 /* s + l > p + q */
        { { 3, 2.5, 1, 2.4, 0.6, 0.5, 0, 0, 0 }, 2 },              /* double rocker, Grashof */
    };
    for (int i = 0; i < 3; i++) {
        lw_linkage k = model_four_bar(known[i].r, 0.75, 1);
        lw_scene_options o = lw_scene_options_default();
        o.other_branches = true;
        OWN(lw_scene) s = { 0 };
        CHECK_OK(lw_scene_make(&k, NULL, &o, &s, &check_error));
        CHECK_INT(s.n_curve, known[i].n_curve);
        int n_shown = 0;
        for (int c = 0; c < s.n_curve; c++) {
            n_shown += s.curve[c].shown_branch;
            CHECK(s.curve[c].closed);
            for (size_t p = 0; p < s.curve[c].n; p++) {           /* A runs on a circle about A0 */
                double d = distance(s.curve[c].p[p], k.joint[0].at), r = hypot(known[i].r[4], known[i].r[5]);
                CHECK(d >= fabs(known[i].r[1] - r) - 1e-9 && d <= known[i].r[1] + r + 1e-9);
            }
        }
        CHECK_INT(n_shown, 1);
    }
}

/* The tangent mechanism runs off to infinity and comes back from the other side: no line of its curve
 * crosses the picture on the way. */
TEST(asymptotes_leave_no_line)
{
    lw_linkage k;
    lw_scene_options o = lw_scene_options_default();
    OWN(lw_scene) s = { 0 };
    lw_type_linkage(lw_type_find("RPRP"), &k);
    o.other_branches = true;
    CHECK_OK(lw_scene_make(&k, NULL, &o, &s, &check_error));
    for (int q = 0; q < s.n_curve; q++) {
        const lw_curve *c = &s.curve[q];
        CHECK(c->n < 20000);
        for (size_t i = 0; i + 1 < c->n; i++) {
            bool whole = isfinite(c->p[i].x) && isfinite(c->p[i + 1].x);
            CHECK(!whole || c->p[i].x*c->p[i + 1].x > 0 || distance(c->p[i], c->p[i + 1]) < 1);
        }
    }
}

TEST(rounding_noise_reads_as_nothing)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene(NULL, 0, &s), LW_OK);
    s.dim[5] = 1e-11;
    s.linkage.units = (lw_units){ "mm", "deg", 1e-3, LW_PI/180 };
    CHECK(lw_scene_dimension(&s, 5) == 0);
    CHECK_NEAR(lw_scene_dimension(&s, 0), 2000, 1e-9, 0);
    CHECK_NEAR(lw_scene_dimension(&s, 8), 0.2*180/LW_PI, 1e-12, 0);
}

/* More inputs than a linkage holds: every pendulum is where its motion takes it, and one period is shown. */
TEST(each_of_forty_inputs_moves)
{
    enum { N = 40 };
    text t = { 0 };
    OWN(lw_model) m = { 0 };
    OWN(lw_scene) s = { 0 };
    lw_scene_options o = lw_scene_options_default();
    put(&t, "{'linkwright': 1, 'joints': [");
    for (int i = 0; i < N; i++)
        put(&t, "%s{'name': 'A%d', 'links': ['ground', 'p%d'], 'at': [%d, 0]}", i ? "," : "", i, i, i);
    put(&t, "], 'inputs': [");
    for (int i = 0; i < N; i++)
        put(&t, "%s{'joint': 'A%d', 'motion': '%.1f*sin(2*pi*t/0.5)'}", i ? "," : "", i, 0.1*i);
    put(&t, "]}");
    read_text(&t, &m);
    CHECK_OK(lw_scene_make_any(&m.linkage, &m, NULL, &o, &s, &check_error));
    CHECK(s.n_frame > 10);
    CHECK_NEAR(s.input[s.n_frame - 1], 0.5, 0.5/(double)o.n_frame, 0);
    for (size_t f = 0; f < s.n_frame; f++)
        for (int i = 0; i < N; i++) {
            lw_vec2 turn = s.place[f*(size_t)s.linkage.n_link + (size_t)m.linkage.joint[i].link[1]].turn;
            CHECK_NEAR(distance(turn, lw_v2_polar(1, 0.1*i*sin(4*LW_PI*s.input[f]))), 0, 1e-6, 0);
        }
    lw_scene_free(&s);
    const volatile sig_atomic_t now = 1;
    o.stop = &now;
    CHECK_OK(lw_scene_make_any(&m.linkage, &m, NULL, &o, &s, &check_error));
    CHECK_INT((int)s.n_frame, 1);
    CHECK_HAS(s.note, "stopped");
}
