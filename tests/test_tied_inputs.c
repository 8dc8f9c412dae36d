/* Inputs tied to the first one: as text, as rows of the loop equations, as wheels of a plan; every five- and seven-link
 * chain of two freedoms. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "catalogues/draw/scene.h"
#include "catalogues/exchange/export.h"
#include "enumerate/chains.h"
#include "enumerate/mechanisms.h"
#include "grammar/linkage/sketch.h"
#include "grammar/model/model.h"
#include "mbs/analysis/reactions.h"
#include "mbs/batch/batch.h"
#include "mbs/batch/posture.h"
#include "mbs/clearance/clearance.h"
#include "mbs/constraints/mobility.h"
#include "mbs/constraints/newton.h"
#include "mbs/constraints/prescribed_motion.h"
#include "mbs/formulations/formulations.h"
#include "tests/check.h"
#include "tests/kept_system.h"
#include "tests/mbs_linkage.h"

static const lw_plan_options all = { .tracers = 1, .all_joints = true, .kind = LW_PLAN_GEARED };

static void tie(lw_linkage *k, int joint, double ratio)
{
    add_input(k, joint, lw_linkage_posture_input(k, joint));
    k->input[k->n_input - 1].ratio = ratio;
}

/* Two cranks on the ground, joined by two bars; the tie as such, or as a pair of wheels. */
static void five_bar(lw_linkage *k, double ratio, bool geared)
{
    blank_linkage(k, 5);
    add_pin(k, 0, 1, lw_v2(0, 0));
    if (geared)
        add_gear(k, 1, 2, lw_v2(20, 0), ratio);
    add_joints(k, JOINTS(PIN(0, 2, 60, 0), PIN(1, 3, 10, 10), PIN(3, 4, 30, 70), PIN(4, 2, 70, 16)));
    tie(k, 0, 0);
    if (!geared)
        tie(k, 1, ratio);
    add_tracer(k, 3, lw_v2(35, 85));
}

/* A crank and a slide on the ground that goes with it, 5 a radian. */
static void crank_and_slide(lw_linkage *k)
{
    blank_linkage(k, 5);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 10, 10), PIN(2, 3, 30, 70), PIN(3, 4, 70, 16), SLIDE(0, 4, 70, 16, 0.3)));
    tie(k, 0, 0);
    tie(k, 4, 5);
    add_tracer(k, 2, lw_v2(35, 85));
}

/* ---- text ------------------------------------------------------------------------------------------- */

TEST(written_and_read_back)
{
    static const char *const length[] = { "m", "mm" };
    for (int i = 0; i < 4; i++) {
        lw_linkage k, back;
        lw_error e = { .text = "" };
        if (i < 2)
            five_bar(&k, -1.0/3, false);
        else
            crank_and_slide(&k);
        CHECK(lw_units_set_length(&k.units, length[i % 2]) && lw_units_set_angle(&k.units, "deg"));
        FREED char *text = lw_linkage_write(&k, 2);
        CHECK(text && lw_linkage_read(text, strlen(text), "k", &back, &e) == LW_OK);
        CHECK_NEAR(back.input[1].ratio, k.input[1].ratio, 0, 4e-16);
        CHECK(lw_linkage_free_inputs(&back) == 1 && back.n_input == 2);
        if (i >= 2)
            CHECK_HAS(text, i == 3 ? "\"ratio\": 5000" : "\"ratio\": 5}");
    }
}

TEST(bad_ties_are_refused)
{
    static const struct { const char *inputs, *why; } row[] = {
        { "{\"joint\": \"A\", \"ratio\": 2}, {\"joint\": \"B\"}", "the first input, at joint \"A\", has a ratio" },
        { "{\"joint\": \"A\"}, {\"joint\": \"B\", \"ratio\": 0}", "a ratio of 0" },
        { "{\"joint\": \"A\"}, {\"joint\": \"B\", \"ratio\": \"2\"}", "number" },
        { "{\"joint\": \"A\"}, {\"joint\": \"B\", \"ratio\": 2, \"motion\": \"t\"}", "\"motion\" is for inputs that move by" },
        { "{\"joint\": \"A\"}, {\"joint\": \"B\", \"ratio\": 2, \"first\": 0, \"last\": 1}", "\"first\" is for inputs" },
        { "{\"joint\": \"A\"}, {\"joint\": \"B\", \"ratio\": 2}, {\"joint\": \"C\"}", "put it before that one" },
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        char text[700];
        lw_linkage k;
        lw_error e = { .text = "" };
        int n = snprintf(text, sizeof text, "{\"linkwright\": 1, \"ground\": \"g\", \"joints\": ["
            "{\"name\": \"A\", \"links\": [\"g\", \"a\"], \"at\": [0, 0]}, {\"name\": \"B\", \"links\": [\"g\", \"b\"], \"at\": [1, 0]},"
            "{\"name\": \"C\", \"links\": [\"a\", \"c\"], \"at\": [0, 1]}, {\"name\": \"D\", \"links\": [\"b\", \"c\"], \"at\": [1, 1]}],\n"
            " \"inputs\": [%s]}", row[i].inputs);
        CHECK_INT(lw_linkage_read(text, (size_t)n, "k.json", &k, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, row[i].why);
        CHECK_INT(e.line, 2);
    }
}

/* ---- loop equations --------------------------------------------------------------------------------- */

TEST(rows_against_differences)
{
    lw_rng r;
    lw_rng_seed(&r, 3, 0);
    for (int trial = 0; trial < 40; trial++) {
        static double jac[LW_SYSTEM_ROW_MAX*LW_SYSTEM_Q_MAX];
        double q[3*LW_SYSTEM_Q_MAX], phi[3][LW_SYSTEM_ROW_MAX], series[3*LW_SYSTEM_ROW_MAX];
        lw_linkage k;
        KEPT_SYSTEM s = { 0 };
        if (trial % 2)
            five_bar(&k, -1.5, false);
        else
            crank_and_slide(&k);
        CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
        CHECK_INT(s.n_row, s.n_q - 1);
        CHECK_INT(s.n_input, 1);
        for (int i = 0; i < 3*s.n_q; i++)
            q[i] = lw_rng_range(&r, -1, 1);
        lw_system_rows(&s, q, phi[0], jac);
        for (int i = 0; i < s.n_q; i++) {
            double keep = q[i], h = 1e-6;
            for (int side = 0; side < 2; side++) {
                q[i] = keep + (side ? h : -h);
                lw_system_rows(&s, q, phi[1 + side], NULL);
            }
            q[i] = keep;
            CHECK_NEAR(jac[s.tie_row*s.n_q + i], (phi[2][s.tie_row] - phi[1][s.tie_row])/(2*h), 1e-9, 0);
        }
        lw_system_series(&s, 2, q, series);                     /* along q0 + q1 x + q2 x^2: values at -h, 0, h */
        double at[3], h = 1e-3, p[LW_SYSTEM_Q_MAX];
        for (int side = -1; side <= 1; side++) {
            for (int i = 0; i < s.n_q; i++)
                p[i] = q[i] + side*h*(q[s.n_q + i] + side*h*q[2*s.n_q + i]);
            lw_system_rows(&s, p, phi[0], NULL);
            at[side + 1] = phi[0][s.tie_row];
        }
        CHECK_NEAR(series[s.tie_row], at[1], 1e-15, 1e-14);
        CHECK_NEAR(series[s.n_row + s.tie_row], (at[2] - at[0])/(2*h), 1e-5, 0);
        CHECK_NEAR(series[2*s.n_row + s.tie_row], (at[2] - 2*at[1] + at[0])/(2*h*h), 1e-5, 0);
    }
}

/* The same motion as with a pair of wheels on the ground, over two turns. */
TEST(moves_as_a_gear_pair)
{
    static const double ratio[] = { -1, 2, -0.5, 3 };
    for (size_t i = 0; i < sizeof ratio/sizeof *ratio; i++) {
        lw_linkage tied, geared;
        lw_newton *a, *b;
        five_bar(&tied, ratio[i], false);
        five_bar(&geared, ratio[i], true);
        CHECK_INT(lw_newton_create(&tied, &a, NULL), LW_OK);
        CHECK_INT(lw_newton_create(&geared, &b, NULL), LW_OK);
        for (int s = 0; s <= 90; s++) {
            double to = tied.input[0].value + 4*LW_PI*s/90, reached[2];
            lw_status one = lw_newton_move(a, to, &reached[0]), two = lw_newton_move(b, to, &reached[1]);
            CHECK_INT(one, two);
            CHECK_NEAR(reached[0], reached[1], 1e-9, 0);
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(lw_newton_tracer(a, 0), lw_newton_tracer(b, 0))), 0, one == LW_OK ? 1e-10 : 1e-4, 0);
            CHECK_NEAR(lw_newton_angle(a, 2), ratio[i]*lw_newton_angle(a, 1), 1e-11, 0);
        }
        lw_newton_free(a);
        lw_newton_free(b);
    }
}

/* In time the tied input goes with the motion of the first; written as a posture, it has its value. */
TEST(goes_with_the_first_in_time)
{
    for (int slides = 0; slides < 2; slides++) {
        OWN(lw_model) m = { 0 };
        lw_linkage k, there;
        KEPT_SYSTEM s = { 0 };
        lw_prescribed_motion *d;
        if (slides)
            crank_and_slide(&k);
        else
            five_bar(&k, -2, false);
        lw_model_from_linkage(&k, &m);
        CHECK_INT(lw_model_drive(&m, 0, "0.7853981633974483 + 0.3*sin(2*t)", NULL), LW_OK);
        CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
        CHECK_INT(lw_prescribed_motion_create(&s, NULL, lw_prescribed_motion_of_model, &m, 0, &d, NULL), LW_OK);
        for (int i = 0; i <= 20; i++) {
            double u[2*LW_INPUT_MAX], t = 0.2*i;
            CHECK_INT(lw_prescribed_motion_to(d, t), LW_OK);
            lw_prescribed_motion_of_model(&m, t, 1, u);
            there = k;
            lw_system_write(&s, lw_prescribed_motion_posture(d), &there);
            CHECK_NEAR(there.input[0].value, LW_PI/4 + 0.3*sin(2*t), 1e-12, 0);
            CHECK_NEAR(there.input[1].value, k.input[1].value + k.input[1].ratio*0.3*sin(2*t), 1e-11, 0);
            CHECK_NEAR(there.input[1].value, u[2], 1e-11, 0);
            CHECK_NEAR(u[3], k.input[1].ratio*0.6*cos(2*t), 1e-12, 0);
        }
        lw_prescribed_motion_free(d);
    }
}

TEST(one_freedom_is_left)
{
    lw_linkage k;
    const lw_mobility_options o = lw_mobility_options_default();
    FREED lw_mobility *m = malloc(sizeof *m);
    five_bar(&k, 2, false);
    CHECK_INT(lw_linkage_mobility(&k), 2);
    CHECK_INT(lw_mobility_find(&k, &o, m, NULL), LW_OK);
    CHECK_INT(m->freedom, 1);
    CHECK_INT(m->driven, 1);
    CHECK_INT(m->n_redundant, 0);
}

/* ---- forces ----------------------------------------------------------------------------------------- */

typedef struct sampled { const lw_dynamics *d; int n; double drive[21][2], rate[21][2], tracer[21], energy; } sampled;

static lw_status sample(void *context, const lw_moment *m)
{
    sampled *s = context;
    const lw_system *y = lw_dynamics_system(s->d);
    lw_reactions_driving(s->d, m, s->drive[s->n]);
    for (int i = 0; i < 2 && i < y->n_input + y->n_tie; i++) {
        double row[LW_SYSTEM_Q_MAX];
        bool pin = y->joint[y->input_joint[i]].kind == LW_JOINT_REVOLUTE;
        lw_system_measure(y, y->input_joint[i], m->q, row);
        for (int c = 0; c < y->n_q; c++)
            s->rate[s->n][i] += (pin ? 1 : y->unit)*row[c]*m->v[c];
    }
    s->energy = m->kinetic + m->potential;
    s->tracer[s->n++] = lw_system_point(y, y->tracer_body[0], y->tracer_arm[0], m->q).x;
    return LW_OK;
}

static void run_model(lw_model *m, lw_analysis analysis, lw_formulation formulation, sampled *out)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d = NULL;
    lw_dynamics_report r;
    lw_error e = { .text = "" };
    memset(out, 0, sizeof *out);
    o.analysis = analysis;
    o.formulation = formulation;
    o.intervals = 20;
    CHECK_INT(lw_dynamics_make(m, &o, &d, &e), LW_OK);
    out->d = d;
    CHECK_INT(d ? lw_dynamics_run(d, sample, out, &r, &e) : LW_E_ARG, LW_OK);
    CHECK_TEXT(e.text, "");
    CHECK_INT(out->n, 21);
    lw_dynamics_free(d);
}

static void load(const lw_linkage *k, lw_model *m)
{
    lw_model_from_linkage(k, m);
    for (int i = 1; i < k->n_link; i++)
        m->body[i] = (lw_body){ .given = true, .mass = 0.1 + 0.1*i, .centre = lw_v2(10.0*i, 5.0 + 3*i),
                                .inertia = 20.0*i };
    m->gravity = lw_v2(0, -98);
}

/* Torques of two motors that keep a ratio are those of two motions that do; a slide too. */
TEST(motors_as_with_two_motions)
{
    for (int slides = 0; slides < 2; slides++) {
        static sampled tied, two;
        static lw_model m;
        lw_linkage k;
        char text[200];
        if (slides)
            crank_and_slide(&k);
        else
            five_bar(&k, -2, false);
        load(&k, &m);
        CHECK_INT(lw_model_drive(&m, 0, "0.7853981633974483 + 0.3*sin(2*t)", NULL), LW_OK);
        run_model(&m, LW_ANALYSIS_KINEMATIC, LW_FORMULATION_AUTO, &tied);
        snprintf(text, sizeof text, "%.17g + %.17g*0.3*sin(2*t)", k.input[1].value, k.input[1].ratio);
        m.linkage.input[1].ratio = 0;
        CHECK_INT(lw_model_drive(&m, 1, text, NULL), LW_OK);
        run_model(&m, LW_ANALYSIS_KINEMATIC, LW_FORMULATION_AUTO, &two);
        for (int i = 0; i < 21; i++)
            for (int h = 0; h < 2; h++) {
                CHECK_NEAR(tied.drive[i][h], two.drive[i][h], 1e-8, 1e-9);
                CHECK_NEAR(tied.rate[i][h], two.rate[i][h], 1e-9, 1e-9);
            }
        lw_model_free(&m);
    }
}

/* Left to itself it falls as with a pair of wheels, and what the tie takes from one side it gives to the other. */
TEST(falls_as_a_gear_pair)
{
    static const lw_formulation way[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_GGL, LW_FORMULATION_CVODE };
    for (int i = 0; i < 3; i++) {
        static sampled tied, geared;
        static lw_model m;
        lw_linkage k;
        double off = i == 0 ? 1e-6 : 1e-3;
        five_bar(&k, 2, false);
        load(&k, &m);
        run_model(&m, LW_ANALYSIS_DYNAMIC, way[i], &tied);
        lw_model_free(&m);
        five_bar(&k, 2, true);
        load(&k, &m);
        run_model(&m, LW_ANALYSIS_DYNAMIC, way[i], &geared);
        lw_model_free(&m);
        CHECK_NEAR(tied.energy, geared.energy, off, 0);
        CHECK(fabs(tied.tracer[20] - tied.tracer[0]) > 1);
        for (int s = 0; s < 21; s++) {
            CHECK_NEAR(tied.tracer[s], geared.tracer[s], off, 0);
            CHECK_NEAR(tied.rate[s][1], 2*tied.rate[s][0], 1e-8, 1e-8);
            CHECK_NEAR(tied.drive[s][0] + 2*tied.drive[s][1], 0, 1e-9, 1e-9);
        }
    }
}

TEST(clearance_knows_no_ties)
{
    static lw_model m;
    lw_linkage k;
    lw_clearance_scene *scene;
    lw_error e = { .text = "" };
    five_bar(&k, 2, false);
    load(&k, &m);
    m.clearance[3] = (lw_clearance){ .model = LW_CLEARANCE_MLSD, .gap = 1e-3, .stiffness = 1e6, .exponent = 1 };
    CHECK_INT(lw_clearance_make(&m, &scene, &e), LW_E_KIND);
    CHECK_HAS(e.text, "input \"J2\" is tied to the first one");
    lw_model_free(&m);
}

/* ---- plans ------------------------------------------------------------------------------------------ */

TEST(planned_as_a_gear_pair)
{
    static const double ratio[] = { -1, 2, -0.5, 2.0/3 };
    for (size_t i = 0; i < sizeof ratio/sizeof *ratio; i++) {
        lw_linkage k[2];
        lw_plan plan[2];
        double dim[2][LW_DIM_MAX], mode[2][LW_MODE_MAX], input[2];
        for (int h = 0; h < 2; h++) {
            five_bar(&k[h], ratio[i], h);
            CHECK_INT(lw_plan_make(&k[h], all, &plan[h], NULL), LW_OK);
            CHECK_INT(lw_plan_read(&plan[h], &k[h], dim[h], mode[h], &input[h], NULL), LW_OK);
        }
        CHECK_INT(plan[0].n_dim, plan[1].n_dim);
        CHECK_INT(plan[0].input_turns_per_period, plan[1].input_turns_per_period);
        CHECK(memcmp(dim[0], dim[1], sizeof(double)*(size_t)plan[0].n_dim) == 0);
        CHECK(lw_plan_dim(&plan[0], "phi3") >= 0);
        for (int s = 0; s < 40; s++) {
            static lw_posture a, b;
            lw_status one = lw_posture_solve(&plan[0], dim[0], mode[0], input[0] + 0.15*s, 0, &a);
            lw_status two = lw_posture_solve(&plan[1], dim[1], mode[1], input[1] + 0.15*s, 0, &b);
            CHECK_INT(one, two);
            CHECK(one != LW_OK || (a.tracer[0][0].x == b.tracer[0][0].x && a.tracer[0][0].y == b.tracer[0][0].y));
        }
    }
}

TEST(what_has_no_plan_says_why)
{
    lw_linkage k;
    lw_plan plan;
    five_bar(&k, 2, false);
    CHECK_FAILS(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true, .kind = LW_PLAN_HIGHER }, &plan, &check_error), LW_E_KIND, "are tied");
    k.input[1].ratio = 0;
    CHECK_FAILS(lw_plan_make(&k, all, &plan, &check_error), LW_E_KIND, "needs one input, this linkage has 2");
    k.input[1].ratio = sqrt(2);
    CHECK_FAILS(lw_plan_make(&k, all, &plan, &check_error), LW_E_KIND, "tied input \"J2\": plans take ratios of whole numbers");
    k.input[1] = (lw_input){ .joint = 3, .ratio = 2 };
    CHECK_FAILS(lw_plan_make(&k, all, &plan, &check_error), LW_E_KIND, "turn on the ground");
    k.input[1] = (lw_input){ .joint = 1, .ratio = 2 };
    add_pin(&k, 0, 3, lw_v2(5, 5));
    CHECK_FAILS(lw_plan_make(&k, all, &plan, &check_error), LW_E_KIND, "F = 0; its inputs need F = 2");
    crank_and_slide(&k);
    CHECK_INT(lw_plan_make(&k, all, &plan, &check_error), LW_E_KIND);
}

TEST(explained)
{
    lw_linkage k;
    lw_plan plan;
    char text[2000];
    five_bar(&k, 2, false);
    CHECK_INT(lw_plan_make(&k, all, &plan, NULL), LW_OK);
    lw_plan_explain(&plan, &k, text, sizeof text);
    CHECK_HAS(text, "turned by the tied input \"J2\"");
}

/* Both cranks turn in pictures; the tie stands in what other programs read. */
TEST(shown_and_exported)
{
    lw_linkage k;
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) out = { 0 };
    lw_error e = { .text = "" };
    five_bar(&k, -1, false);
    k.joint[1].at = lw_v2(30, 0);
    k.joint[4].at = lw_v2(34, 8);
    CHECK_INT(lw_scene_make(&k, NULL, &(lw_scene_options){ .n_frame = 40, .n_curve_point = 40 }, &s, &e), LW_OK);
    CHECK_INT((int)s.n_frame, 40);
    for (size_t f = 0; f < s.n_frame && s.n_frame == 40; f++) {
        const lw_place *p = &s.place[f*5];
        lw_vec2 both = lw_v2_turn(p[1].turn, p[2].turn);
        CHECK_POINT(both, 1, 0, 1e-9, 0);
    }
    CHECK_INT(lw_export_adams(LW_VIEW(&k), NULL, &out, &e), LW_OK);
    CHECK_HAS(out.data, "COUPLER/01, JOINTS = 01, 02\n, TYPE = R:R\n, SCALES = -1, -1");
    CHECK(!strstr(out.data, "MOTION/02"));
    lw_bytes_free(&out);
    CHECK_INT(lw_export_mjcf(LW_VIEW(&k), NULL, &out, &e), LW_OK);
    CHECK_HAS(out.data, "joint1=\"J2\" joint2=\"J1\" polycoef=\"0 -1 0 0 0\"");
    CHECK(!strstr(out.data, "J2 drive"));
}

/* ---- every chain ------------------------------------------------------------------------------------ */

static struct { lw_rng rng; int chains, mechanisms, planned, higher, postures, derivatives; } sum;

/* Coordinates of a posture in the system of the posture it came from. */
static void coordinates(const lw_system *s, const lw_linkage *k, const lw_posture *here, const lw_posture *there, double *q)
{
    for (int b = 0; b < s->n_body; b++) {
        int link = s->link[b], j = 0;
        while (k->joint[j].link[0] != link && k->joint[j].link[1] != link)
            j++;
        double turn = there->angle[link][0] - here->angle[link][0];
        lw_vec2 arm = lw_v2_turn(lw_system_arm(s, b, k->joint[j].at), lw_v2_polar(1, turn));
        lw_vec2 at = lw_v2_sub(lw_v2_scale(lw_v2_sub(there->joint[j][0], s->origin), 1/s->unit), arm);
        q[3*b] = at.x;
        q[3*b + 1] = at.y;
        q[3*b + 2] = turn;
    }
}

/* Rows that hold turns are good to a whole number of them times the ratio. */
static double residual(const lw_system *s, const double *q)
{
    double phi[LW_SYSTEM_ROW_MAX], most = 0;
    lw_system_rows(s, q, phi, NULL);
    for (int r = 0; r < s->tie_row; r++)
        most = fmax(most, fabs(phi[r]));
    for (int i = 0; i < s->n_tie; i++) {
        double scale = 1 + fabs(s->tie[i]), turn = scale*phi[s->tie_row + i];
        most = fmax(most, fabs(remainder(turn, 2*LW_PI))/scale);
    }
    return most;
}

static void derivatives(const lw_plan *plan, double *dim, const double *mode, double input)
{
    enum { N = 3 };
    double c[N], s[N], row[13][N], jx[LW_DIM_MAX*N], jy[LW_DIM_MAX*N], jt[LW_DIM_MAX*N];
    for (int i = 0; i < N; i++) {
        c[i] = cos(input + 0.001*i);
        s[i] = sin(input + 0.001*i);
    }
    FREED void *work = aligned_alloc(64, (lw_batch_work_size(plan) + 63)/64*64 + 64);
    lw_lanes in = { .n = N, .c = c, .s = s, .dim = dim, .mode = mode };
    lw_jacobian out = { row[0], row[1], row[2], row[3], row[4], jx, jy, jt, row[5], row[6], row[7], N, NULL, NULL };
    lw_batch_jacobian(plan, &in, 0, work, &out);
    for (int d = 0; d < plan->n_dim; d++) {
        double keep = dim[d], x[2][N], y[2][N], u[2][N], v[2][N], h = 1e-6;
        for (int up = 0; up < 2; up++) {
            dim[d] = keep + (up ? h : -h);
            lw_batch_point(plan, &in, 0, work, x[up], y[up], u[up], v[up], NULL);
        }
        dim[d] = keep;
        for (int i = 0; i < N; i++) {
            CHECK_NEAR(jx[d*N + i], (x[1][i] - x[0][i])/(2*h), 1e-6, 1e-6);
            CHECK_NEAR(jy[d*N + i], (y[1][i] - y[0][i])/(2*h), 1e-6, 1e-6);
        }
    }
    sum.derivatives++;
}

/* About its posture, where it closes well enough. */
static void check_postures(const lw_linkage *k, const lw_plan *plan, double *dim, double *mode, double input)
{
    static lw_posture here, there;
    KEPT_SYSTEM s = { 0 };
    double q[LW_SYSTEM_Q_MAX];
    CHECK_INT(lw_system_make(k, NULL, 0, &s, NULL), LW_OK);
    CHECK_INT(s.n_row, s.n_q - 1);
    CHECK_INT(lw_posture_solve(plan, dim, mode, input, 0, &here), LW_OK);
    CHECK_NEAR(lw_v2_norm(lw_v2_sub(here.tracer[0][0], k->tracer[0].at)), 0, 1e-11, 0);
    for (int i = -3; i <= 3; i++) {
        if (i == 0 || lw_posture_solve(plan, dim, mode, input + 0.02*i, 0, &there) != LW_OK || there.margin < 0.05)
            continue;
        lw_linkage moved = *k;
        CHECK_INT(lw_plan_write(plan, dim, mode, input + 0.02*i, &moved), LW_OK);
        for (int h = 0; h < 2; h++) {
            double by = plan->input_turns_per_period*0.02*i*(h ? k->input[h].ratio : 1);
            CHECK_NEAR(remainder(moved.input[h].value - k->input[h].value - by, 2*LW_PI), 0, 1e-11, 0);
        }
        coordinates(&s, k, &here, &there, q);
        CHECK(residual(&s, q) <= 1e-12);
        sum.postures++;
        if (i == 1 && here.margin > 0.01)                /* a seed next to a limit leads nowhere */
            derivatives(plan, dim, mode, input + 0.02);
    }
}

static lw_status check_inputs(void *context, const lw_mechanism *m)
{
    static const double ratio[] = { -1, 1, 2, -2, 0.5, -1.0/3, 1.5 };
    (void)context;
    lw_linkage k;
    static lw_plan plan;
    lw_error e = { .text = "" };
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    CHECK_INT(lw_linkage_sketch(m, &sum.rng, &k), LW_OK);
    k.input[1].ratio = ratio[sum.mechanisms++ % 7];
    if (sum.mechanisms % 2) {
        lw_input first = k.input[0];
        k.input[0].joint = k.input[1].joint;
        k.input[0].value = k.input[1].value;
        k.input[1].joint = first.joint;
        k.input[1].value = first.value;
    }
    lw_status st = lw_plan_make(&k, all, &plan, &e);
    CHECK(st == LW_OK);
    if (st != LW_OK || lw_plan_read(&plan, &k, dim, mode, &input, NULL) != LW_OK)
        return LW_OK;
    sum.planned++;
    sum.higher += plan.n_higher > 0;
    check_postures(&k, &plan, dim, mode, input);
    return LW_OK;
}

static lw_status check_output(void *context, const lw_mechanism *m)
{
    return lw_inputs_each(m, 2, true, check_inputs, context);
}

static lw_status check_chain(void *context, const lw_chain_item *item)
{
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    const lw_mechanism_steps steps = { .ground = true, .kinds = "r", .output = true };
    sum.chains++;
    CHECK_INT(lw_mechanism_from_chain(item->chain, &m), LW_OK);
    return lw_mechanisms_each(&m, &steps, &counts, check_output, NULL, context);
}

/* A mechanism drives by its pair of inputs or is not visited; each has a plan. */
TEST(every_chain_with_five_and_seven_links)
{
    lw_rng_seed(&sum.rng, 11, 0);
    for (int links = 5; links <= 7; links += 2) {
        lw_chains *chains;
        const lw_chain_walk how = lw_chain_walk_default();
        CHECK_INT(lw_chains_create(links, 2, 1, &chains, NULL), LW_OK);
        CHECK_INT(lw_chains_each(chains, &how, check_chain, NULL), LW_OK);
        lw_chains_free(chains);
    }
    CHECK_INT(sum.chains, 1 + 3);
    CHECK_INT(sum.planned, sum.mechanisms);
    CHECK(sum.postures >= 4*sum.planned);
    CHECK(3*sum.derivatives >= sum.planned);
    printf("# %d mechanisms, %d with a higher group, %d postures\n", sum.mechanisms, sum.higher, sum.postures);
}
