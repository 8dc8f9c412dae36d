/* tests/test_motion.c - arcs and circuits against the closed forms of the four-bar, against margins
 * sampled through the posture, and against the verifier, which runs into every limit. */
#include "mbs/kinematics/motion.h"
#include "mbs/kinematics/fourbar.h"
#include "mbs/constraints/newton.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/types.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

static lw_plan plan_of(const lw_linkage *k)
{
    lw_plan plan;
    CHECK_OK(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, &check_error));
    return plan;
}

static lw_plan plan_of_type(const char *name, lw_linkage *k)
{
    lw_type_linkage(lw_type_find(name), k);
    return plan_of(k);
}

/* --- four-bars --- */

static void draw_lengths(lw_rng *rng, double r[4])
{
    lw_fourbar_class c;
    do {
        for (int i = 0; i < 4; i++)
            r[i] = lw_rng_range(rng, 0.1, 1.0);
    } while (lw_fourbar_classify(r, 1e-12, &c, NULL) != LW_OK);
}

static const lw_arc *arc_at(const lw_motion *m, double mode, double input)
{
    for (int i = 0; i < m->n_arc; i++) {
        const lw_arc *a = &m->arc[i];
        double middle = 0.5*(a->first + a->last);
        if (a->mode[0] == mode && fabs(remainder(input - middle, 2.0*LW_PI)) <= 0.5*(a->last - a->first))
            return a;
    }
    return NULL;
}

static void check_fourbar(const lw_plan *plan, const double *dim, const lw_fourbar_class *c)
{
    lw_motion m;
    CHECK_INT(lw_motion_find(plan, dim, &m), LW_OK);
    CHECK_INT(m.n_arc, 2*c->n_range);
    CHECK_INT(m.n_circuit, c->circuits);
    CHECK_INT(m.change_point, c->number >= 9);
    double least = LW_PI, most = 0.0;
    for (double mode = -1.0; mode <= 1.0; mode += 2.0)
        for (int i = 0; i < c->n_range; i++) {
            const lw_arc *a = arc_at(&m, mode, 0.5*(c->range[i][0] + c->range[i][1]));
            CHECK(a != NULL);
            if (!a)
                continue;
            CHECK_INT(a->turns, c->crank);
            CHECK(a->limit[0] == !c->crank && a->limit[1] == !c->crank);
            CHECK_NEAR(a->last - a->first, c->range[i][1] - c->range[i][0], 1e-15, 1e-15);
            if (!c->crank)
                CHECK_NEAR(remainder(a->first - c->range[i][0], 2.0*LW_PI), 0.0, 1e-15, 0);
            least = fmin(least, a->transmission_min);
            most = fmax(most, a->transmission_max);
            CHECK_INT(lw_motion_arc(plan, &m, &mode, 0.5*(a->first + a->last)), a - m.arc);
        }
    CHECK_NEAR(least, c->transmission[0], 1e-7, 0);             /* 0 and pi by a square root */
    CHECK_NEAR(most, c->transmission[1], 1e-7, 0);
    CHECK_NEAR(cos(least), cos(c->transmission[0]), 1e-14, 0);
    CHECK_NEAR(cos(most), cos(c->transmission[1]), 1e-14, 0);
}

TEST(fourbars_as_classified)
{
    lw_linkage k;
    lw_rng rng = check_rng(1);
    lw_plan plan = plan_of_type("fourbar", &k);
    for (int trial = 0; trial < 300; trial++) {
        double dim[LW_DIM_MAX] = { 0 };
        lw_fourbar_class c;
        draw_lengths(&rng, dim);
        lw_fourbar_classify(dim, LW_FOURBAR_TOLERANCE, &c, NULL);
        check_fourbar(&plan, dim, &c);
    }
}

TEST(change_points_join_circuits)
{
    static const double r[][4] = {
        { 2, 4, 5, 3 }, { 4, 2, 5, 3 }, { 5, 4, 2, 3 }, { 5, 3, 4, 2 },          /* classes 9 to 12 */
        { 5, 2, 5, 2 }, { 2, 2, 5, 5 }, { 5, 2, 2, 5 }, { 5, 5, 2, 2 }, { 2, 5, 5, 2 }, { 3, 3, 3, 3 },
    };
    lw_linkage k;
    lw_plan plan = plan_of_type("fourbar", &k);
    for (size_t i = 0; i < sizeof r/sizeof *r; i++) {
        double dim[LW_DIM_MAX] = { 0 };
        lw_fourbar_class c;
        memcpy(dim, r[i], sizeof r[i]);
        lw_fourbar_classify(dim, LW_FOURBAR_TOLERANCE, &c, NULL);
        check_fourbar(&plan, dim, &c);
    }
}

TEST(circuits_of_a_double_rocker)
{
    lw_linkage k;
    lw_plan plan = plan_of_type("fourbar", &k);
    double dim[LW_DIM_MAX] = { 5, 6, 2, 7 };                    /* coupler shortest, Grashof */
    lw_motion m;
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    CHECK_INT(m.n_arc, 4);
    CHECK_INT(m.n_circuit, 2);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            bool same_side = remainder(m.arc[i].first - m.arc[j].first, 2.0*LW_PI) == 0.0;
            CHECK_INT(m.arc[i].circuit == m.arc[j].circuit, same_side);
        }
    double open[LW_DIM_MAX] = { 10, 1, 1, 1 };
    CHECK_INT(lw_motion_find(&plan, open, &m), LW_OPEN);
    CHECK_INT(m.n_arc, 0);
    open[0] = NAN;
    CHECK_INT(lw_motion_find(&plan, open, &m), LW_E_ARG);
}

/* --- against the verifier --- */

/* Draw the linkage in the middle of the arc and let Newton's method run into both ends. */
static int run_into_ends(const lw_plan *plan, const double *dim, const lw_arc *a, double size, lw_linkage *k)
{
    double middle = a->first + 0.4637*(a->last - a->first), reached;
    lw_newton *s;
    if (lw_plan_write(plan, dim, a->mode, middle, k) != LW_OK || lw_newton_create(k, &s, NULL) != LW_OK) {
        CHECK(!"an arc's posture can be drawn");
        return 0;
    }
    double shift = k->input[0].value - middle;
    int crossings = 0;
    for (int e = 0; e < 2; e++) {
        double end = e ? a->last : a->first, way = e ? 1.0 : -1.0;
        lw_newton_reset(s);
        if (a->limit[e]) {
            lw_status status = lw_newton_move(s, end + shift + 0.1*way*size, &reached);
            CHECK_INT(status, LW_OPEN);
            CHECK_NEAR((reached - shift - end)/size, 0.0, 1e-10, 0);
        } else {
            double most = plan->input_is_slider ? fmin(fabs(end - middle), 3.0*size) : fabs(end - middle);
            lw_status status = lw_newton_move(s, middle + way*0.99*most + shift, &reached);
            CHECK_INT(status, LW_OK);
        }
        crossings += lw_newton_crossings(s);
    }
    lw_newton_free(s);
    return crossings;
}

/* At a limit the linkage passes into another arc of its circuit: same end, same posture. */
static void check_joints_of_arcs(const lw_plan *plan, const double *dim, const lw_motion *m)
{
    static lw_posture p, q;
    for (int i = 0; i < 2*m->n_arc; i++) {
        const lw_arc *a = &m->arc[i/2];
        int e = i % 2, n_met = 0;
        double at = e ? a->last : a->first;
        if (!a->limit[e])
            continue;
        lw_posture_solve(plan, dim, a->mode, at, 0, &p);
        for (int j = 0; j < m->n_arc; j++) {
            const lw_arc *b = &m->arc[j];
            if (b == a || b->circuit != a->circuit || fabs((e ? b->last : b->first) - at) > 1e-12*fabs(at))
                continue;
            lw_posture_solve(plan, dim, b->mode, at, 0, &q);
            n_met += lw_v2_norm(lw_v2_sub(p.tracer[0][0], q.tracer[0][0])) < 1e-5;
        }
        CHECK(n_met > 0);
    }
}

/* Lengths and offsets of the type's posture, each changed by up to 60 %. */
static double draw_dimensions(lw_rng *rng, const lw_plan *plan, const double *from, double *dim)
{
    double size = 0.0;
    for (int d = 0; d < plan->n_dim; d++) {
        bool coordinate = plan->dim[d].kind == LW_DIM_COORDINATE;
        dim[d] = from[d]*lw_rng_range(rng, 0.4, 1.6);
        if (coordinate || plan->dim[d].kind == LW_DIM_ANGLE)
            dim[d] += lw_rng_range(rng, -0.5, 0.5);
        if (plan->dim[d].kind == LW_DIM_LENGTH)
            size = fmax(size, fabs(dim[d]));
    }
    return plan->input_is_slider ? fmax(size, 1.0) : 1.0;
}

static bool closes_at(const lw_plan *plan, const double *dim, const double *mode, double input)
{
    static lw_posture posture;
    return lw_posture_solve(plan, dim, mode, input, 0, &posture) == LW_OK;
}

/* Samples close where an arc says so and nowhere else.  The motion of a slider without a limit is cut. */
static void check_samples(const lw_plan *plan, const double *dim, const lw_motion *m, double size, int n)
{
    double cut = INFINITY;
    for (int i = 0; i < m->n_arc && plan->input_is_slider; i++)
        cut = !m->arc[i].limit[0] ? -m->arc[i].first : !m->arc[i].limit[1] ? m->arc[i].last : cut;
    for (int i = 0; i < n; i++) {
        double mode[LW_MODE_MAX], t = plan->input_is_slider ? (8.0*i/n - 4.0)*size : 2.0*LW_PI*i/n;
        for (int bits = 0; bits < 1 << plan->n_dyad; bits++) {
            for (int d = 0; d < plan->n_dyad; d++)
                mode[d] = bits >> d & 1 ? -1.0 : 1.0;
            int a = lw_motion_arc(plan, m, mode, t);
            double inside = -1.0;
            if (a >= 0) {
                double middle = 0.5*(m->arc[a].first + m->arc[a].last), half = m->arc[a].last - middle;
                inside = half - fabs(plan->input_is_slider ? t - middle : remainder(t - middle, 2.0*LW_PI));
            }
            if (fabs(inside) > 1e-9 && fabs(t) < cut)
                CHECK_INT(closes_at(plan, dim, mode, t), inside > 0.0);
        }
    }
}

TEST(every_type_by_samples_and_newton)
{
    lw_rng rng = check_rng(2);
    for (const lw_type *t = lw_type_table; t->letters; t++) {
        lw_linkage k;
        double from[LW_DIM_MAX], dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
        int n_closed = 0;
        lw_plan plan = plan_of_type(t->name, &k);
        CHECK_INT(lw_plan_read(&plan, &k, from, mode, &input, NULL), LW_OK);
        for (int trial = 0; trial < 60; trial++) {
            static lw_motion m;
            double size = draw_dimensions(&rng, &plan, from, dim);
            lw_status status = lw_motion_find(&plan, dim, &m);
            CHECK(status == LW_OK || status == LW_OPEN);
            n_closed += status == LW_OK;
            check_samples(&plan, dim, &m, size, 60);
            check_joints_of_arcs(&plan, dim, &m);
            for (int i = 0; i < m.n_arc; i++) {
                CHECK(isfinite(m.arc[i].first) && isfinite(m.arc[i].last) && m.arc[i].first < m.arc[i].last);
                CHECK_INT(run_into_ends(&plan, dim, &m.arc[i], size, &k), 0);
            }
        }
        CHECK(n_closed > 30);
    }
}

/* Slider-crank with offset e: the crank turns when rod >= r + |e|; its limits otherwise are where
 * r sin t + e = +-rod, by the textbook. */
TEST(slider_crank_by_textbook)
{
    lw_linkage k;
    lw_plan plan = plan_of_type("slidercrank", &k);
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
    int r2 = lw_plan_dim(&plan, "r2"), r3 = lw_plan_dim(&plan, "r3"), e1 = lw_plan_dim(&plan, "e1");
    CHECK(r2 >= 0 && r3 >= 0 && e1 >= 0);
    if (r2 < 0 || r3 < 0 || e1 < 0)
        return;
    lw_motion m;
    dim[r2] = 1.0, dim[r3] = 3.0, dim[e1] = 0.5;
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    CHECK(m.n_arc == 2 && m.n_circuit == 2 && m.arc[0].turns && m.arc[1].turns);
    /* rod against the normal of the slide: cos = (e - r sin t)/rod */
    CHECK_NEAR(m.arc[0].transmission_min, acos(1.5/3.0), 1e-14, 0);
    CHECK_NEAR(m.arc[0].transmission_max, acos(-0.5/3.0), 1e-14, 0);
    dim[r3] = 1.2;
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    CHECK(m.n_arc == 2 && m.n_circuit == 1 && !m.arc[0].turns);
    double limit = asin((0.5 - 1.2)/1.0);                       /* e - r sin t = rod */
    CHECK_NEAR(sin(m.arc[0].first), sin(limit), 1e-15, 0);
    CHECK_NEAR(sin(m.arc[0].last), sin(limit), 1e-15, 0);
    CHECK_NEAR(m.arc[0].transmission_min, 0.0, 0, 0);
}

/* --- several dyads --- */

static const int watt[7][2] = { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,3} };
static const int watt_two[7][2] = { {0,1},{1,2},{2,3},{3,0},{3,4},{4,5},{5,0} };
static const int stephenson[7][2] = { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,0} };

/* The angle at pin b between pins a and c, folded to at most pi/2. */
static double folded_angle(const lw_posture *p, int a, int b, int c)
{
    lw_vec2 u = lw_v2_sub(p->joint[a][0], p->joint[b][0]), v = lw_v2_sub(p->joint[c][0], p->joint[b][0]);
    double angle = fabs(atan2(lw_v2_cross(u, v), lw_v2_dot(u, v)));
    return fmin(angle, LW_PI - angle);
}

/* Least angle at `pin` among samples between two inputs, which move to both sides of the least. */
static double least_angle(const lw_plan *plan, const double *dim, const double *mode, int pin, double *from, double *to)
{
    enum { N = 250 };
    double least = LW_PI, step = (*to - *from)/N, at = *from;
    for (int i = 0; i <= N; i++) {
        static lw_posture p;
        double angle = lw_posture_solve(plan, dim, mode, *from + step*i, 0, &p) == LW_OK ? folded_angle(&p, pin - 1, pin, pin + 1) : LW_PI;
        if (angle < least)
            least = angle, at = *from + step*i;
    }
    *from = at - step, *to = at + step;
    return least;
}

/* The transmission angles of an arc are those of both dyads, which join at pins 2 and 5. */
static void check_transmission(const lw_plan *plan, const double *dim, const lw_arc *a, int *n_inner)
{
    double least[2], said = fmin(a->transmission_min, LW_PI - a->transmission_max);
    bool limit = a->limit[0] || a->limit[1];
    for (int i = 0; i < 2; i++) {
        double from = a->first, to = a->last;
        least[i] = least_angle(plan, dim, a->mode, 2 + 3*i, &from, &to);
        if (!limit)                                           /* an angle that falls to 0 has a corner there */
            least[i] = fmin(least[i], least_angle(plan, dim, a->mode, 2 + 3*i, &from, &to));
    }
    double both = fmin(least[0], least[1]);
    CHECK(said <= both + 1e-7);
    if (limit)                                                /* a limit is a flat posture */
        CHECK_NEAR(said, 0, 0, 0);
    else
        CHECK_NEAR(said, both, 1e-5, 0);
    *n_inner += a->turns && least[0] < least[1];
}

/* Postures drawn at random; all arcs of all modes are run into by the verifier. */
TEST(six_bars_by_newton)
{
    const int (*kind[3])[2] = { watt, watt_two, stephenson };
    lw_rng rng = check_rng(3);
    int n_arc = 0, n_inner = 0, n_first = 0;
    for (int trial = 0; trial < 90; trial++) {
        lw_linkage k;
        double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
        static lw_motion m;
        blank_linkage(&k, 6);
        for (int j = 0; j < 7; j++)
            add_pin(&k, kind[trial % 3][j][0], kind[trial % 3][j][1], lw_v2(lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1)));
        add_input(&k, 0, lw_linkage_posture_input(&k, 0));
        add_tracer(&k, 5, lw_v2(0.5, 0.5));
        lw_plan plan = plan_of(&k);
        CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
        CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
        int here = lw_motion_arc(&plan, &m, mode, input);
        CHECK(here >= 0);
        check_samples(&plan, dim, &m, 1.0, 40);
        check_joints_of_arcs(&plan, dim, &m);
        for (int i = 0; i < m.n_arc; i++) {
            run_into_ends(&plan, dim, &m.arc[i], 1.0, &k);
            check_transmission(&plan, dim, &m.arc[i], &n_first);
            n_arc++;
            n_inner += m.arc[i].limit[0];
        }
    }
    CHECK(n_arc > 200 && n_inner > 150 && n_first > 0);
}

/* --- Jansen's leg --- */

/* Crank 15 about (0, 0); links with the published lengths; pins of three links are two joints. */
static void jansen(lw_linkage *k, double t)
{
    lw_vec2 o = lw_v2(0.0, 0.0), g = lw_v2(-38.0, -7.8), pin = lw_v2_polar(15.0, t);
    lw_vec2 j2 = meet(pin, 50.0, g, 41.5, -1.0), j3 = meet(j2, 55.8, g, 40.1, -1.0);
    lw_vec2 j4 = meet(pin, 61.9, g, 39.3, 1.0), j5 = meet(j3, 39.4, j4, 36.7, -1.0);
    static const int joint[10][2] = {        /* ground, crank, j, upper triangle, k, c, f, lower triangle */
        { 0, 1 }, { 1, 2 }, { 1, 4 }, { 2, 3 }, { 0, 3 }, { 0, 5 }, { 4, 5 }, { 5, 7 }, { 3, 6 }, { 6, 7 }
    };
    lw_vec2 at[10] = { o, pin, pin, j2, g, g, j4, j4, j3, j5 };
    blank_linkage(k, 8);
    for (int i = 0; i < 10; i++)
        add_pin(k, joint[i][0], joint[i][1], at[i]);
    add_input(k, 0, t);
    add_tracer(k, 7, meet(j4, 49.0, j5, 65.7, 1.0));
}

/* Foot at every 60 degrees of the crank, computed with 22 digits. */
TEST(jansens_leg)
{
    static const double foot[6][2] = {
        { -43.16011052410472333668, -91.75693292612322376457 }, { -18.15029468117372965496, -91.57132466831302641137 },
        { -3.668421915931004280858, -88.52194859008367642267 }, { -33.72972953816961718420, -73.51709740981948253653 },
        { -69.73798086638603615752, -85.37097908567156220787 }, { -64.15292573010785780831, -91.44710309377925465952 }
    };
    lw_linkage k;
    lw_newton *s;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    jansen(&k, 0.2);
    lw_plan plan = plan_of(&k);
    CHECK_INT(plan.n_dyad, 3);
    CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
    CHECK_INT(lw_newton_create(&k, &s, NULL), LW_OK);
    for (int i = 0; s && i < 6; i++) {
        static lw_posture p;
        CHECK_INT(lw_newton_move(s, i*LW_PI/3.0, NULL), LW_OK);
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + i*LW_PI/3.0 - 0.2, 0, &p), LW_OK);
        lw_vec2 q = lw_newton_tracer(s, 0), r = p.tracer[0][0];
        CHECK_NEAR(hypot(q.x - foot[i][0], q.y - foot[i][1]), 0.0, 1e-12, 0);
        CHECK_NEAR(hypot(r.x - foot[i][0], r.y - foot[i][1]), 0.0, 1e-12, 0);
    }
    lw_newton_free(s);

    static lw_motion m;
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    int a = lw_motion_arc(&plan, &m, mode, input);
    CHECK(a >= 0 && m.arc[a].turns);
    check_samples(&plan, dim, &m, 1.0, 90);
    check_joints_of_arcs(&plan, dim, &m);
    for (int i = 0; i < m.n_arc; i++)
        run_into_ends(&plan, dim, &m.arc[i], 1.0, &k);
}
