/* Forward dynamics against published and exact solutions, all formulations against each other. */
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "tests/dynamics_run.h"

OWNS(lw_dynamics)

static drun d;

static const lw_formulation every[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                        LW_FORMULATION_GGL };

/* Exact: sin(phi/2) = k sn(...), 30 digits by elliptic functions; IFToMM benchmark A01 at 10 s. */
TEST(simple_pendulum)
{
    static const double allowed[] = { 2e-12, 2e-12, 3e-6, 3e-6 };
    drun_read(&d, "examples/pendulum.json");
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, every[f], f < 2 ? 1e-13 : 1e-9, 10, 1), LW_OK);
        CHECK_INT(d.report.formulation, every[f]);
        CHECK_POINT(d.tracer[1], -0.2750874625761168600544, -0.9614192050991250642651, allowed[f], 0);
    }
}

/* Andrews' squeezer at 0.03 s, in quad precision: angles of the crank, of link K3 (gamma), K5 (delta), K7 (epsilon),
 * with rates. */
TEST(andrews)
{
    static const double allowed[] = { 1e-10, 1e-10, 2e-5, 2e-4 };
    static const struct { int body; double angle0, angle, rate; } want[] = {
        { 0, -0.06171389001427644963589484580010, 15.81077119515370709711938730, 1139.920302259106064198096847 },
        { 2, 0.4552798191630703802559123824491, 0.04082224011964580485828231960, 11.03291191061859374532731137 },
        { 4, 0.4873649795438425502255989535298, 0.5244099658799540693716557999, 0.5735699148295024538176878654 },
        { 6, 1.230547444549821192497350155678, 1.048080741041937873068515472, 0.3231791492491308749907483932 },
    };
    drun_read(&d, "examples/andrews.json");
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, every[f], f == 0 ? 1e-11 : f == 1 ? 1e-10 : f == 2 ? 1e-8 : 1e-7, 0.03, 3), LW_OK);
        for (int i = 0; i < 4; i++) {
            CHECK_NEAR(d.q[3*want[i].body + 2] + want[i].angle0, want[i].angle, allowed[f], 0);
            CHECK_NEAR(d.v[3*want[i].body + 2], want[i].rate, 1000*allowed[f], 0);
        }
        CHECK(d.report.worst_off < 1e-12);
        if (f == 1)
            CHECK(d.report.rates < 2000);
        if (f < 2)
            CHECK(d.report.energy_error < 1e-9*d.report.energy_scale);
    }
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 0.001, 1), LW_OK);
    CHECK_INT(d.report.formulation, LW_FORMULATION_QUADRATURE);
    CHECK_INT(d.report.freedom, 1);
    CHECK_INT(d.report.redundant, 0);
}

/* N-four-bar, N = 2 (A02): through five singular postures, by place and motion curve, for every tolerance. */
TEST(two_four_bars)
{
    drun_read(&d, "examples/two-four-bars.json");
    for (int f = 0; f < 2; f++)
        for (int k = 6; k <= 12; k += f == 0 ? 1 : 2) {
            double tolerance = pow(10, -k);
            CHECK_INT(drun_to(&d, every[f], tolerance, 10, 100), LW_OK);
            double allowed = fmax(f == 0 ? 3e-10 : 2e-6, 3000*tolerance);
            CHECK_POINT(d.tracer[100], 0.32845811154081537865, 0.94451853817860096216, allowed, 0);
            for (int bar = 0; bar < 2; bar++)                  /* the bars never turn */
                CHECK_NEAR(d.q[3*(3 + bar) + 2], 0, 1e-9, 0);
        }
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-11, 10, 100), LW_OK);
    CHECK_NEAR(d.tracer[100].x, 0.32845811154081537865, 1e-8, 0);
}

/* Newton's equations at every sample: M a + J^T l = Q, summed joint by joint from rows that are independent of the
 * order of elimination in the solver; greatest residual over the greatest term. */
typedef struct balance { const lw_dynamics *d; double off; int n; } balance;

static lw_status look_at_balance(void *context, const lw_moment *m)
{
    balance *b = context;
    const lw_system *s = lw_dynamics_system(b->d);
    const lw_forces *f = lw_dynamics_forces(b->d);
    double sum[LW_SYSTEM_Q_MAX], force[LW_SYSTEM_Q_MAX], jac[LW_SYSTEM_Q_MAX], most = 0, off = 0;
    lw_forces_apply(f, m->t, m->q, m->v, force, NULL, NULL, NULL);
    for (int i = 0; i < s->n_q; i++) {
        sum[i] = f->mass[i]*m->a[i] - force[i];
        most = fmax(most, fabs(force[i]));
    }
    lw_mbs_system_rows(b->d, m->q);
    for (int r = 0; r < s->n_row; r++) {
        lw_mbs_row(b->d, r, jac);
        for (int i = 0; i < s->n_q; i++) {
            sum[i] += m->l[r]*jac[i];
            most = fmax(most, fabs(m->l[r]*jac[i]));
        }
    }
    for (int i = 0; i < s->n_q; i++)
        off = fmax(off, fabs(sum[i]));
    b->off = fmax(b->off, off/most);
    b->n++;
    return LW_OK;
}

TEST(forces_balance)
{
    static const char *const models[] = { "examples/andrews.json", "examples/pendulum.json",
                                          "examples/two-four-bars.json" };
    for (size_t i = 0; i < sizeof models/sizeof *models; i++) {
        OWNED(lw_dynamics) *made = NULL;
        drun_read(&d, models[i]);
        d.o.formulation = LW_FORMULATION_INDEX1;
        d.o.to = i ? 2 : 0.03;
        d.o.intervals = 50;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
        balance b = { .d = made };
        CHECK_INT(lw_dynamics_run(made, look_at_balance, &b, &d.report, &d.e), LW_OK);
        CHECK_INT(b.n, 51);
        CHECK(b.off < 1e-12);
    }
}

/* ---- a force of the caller's own ----------------------------------------------------------------- */

/* Weight, and a torque that damps the turn. */
static void weight_and_damper(void *context, double t, const lw_link_motion *link, lw_link_load *load)
{
    const lw_model *m = context;
    (void)t;
    for (int l = 0; l < m->linkage.n_link; l++) {
        load[l].force.y = -9.81*m->body[l].mass;
        load[l].torque = -0.5*link[l].angular_velocity;
    }
}

/* A force of the caller acts like the same force in the model, in every formulation that takes it, and in
 * equilibrium. */
TEST(callers_force)
{
    static drun same;
    double q[LW_SYSTEM_Q_MAX];
    OWNED(lw_dynamics) *made = NULL;
    lw_rest rest;
    drun_read(&same, "examples/pendulum.json");
    same.model.joint_spring[same.model.n_joint_spring++] = (lw_joint_spring){ .joint = 0, .damping = 0.5 };
    CHECK_INT(drun_to(&same, LW_FORMULATION_INDEX1, 1e-11, 3, 4), LW_OK);
    drun_read(&d, "examples/pendulum.json");
    d.model.gravity = lw_v2(0, 0);
    d.o.force = (lw_caller_force){ &d.model, weight_and_damper };
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, every[f], 1e-10, 3, 4), LW_OK);
        CHECK_POINT(d.tracer[4], same.tracer[4].x, same.tracer[4].y, f == 1 ? 1e-9 : 1e-6, 0);
        CHECK(d.report.energy_error < 1e-6*d.report.energy_scale);
    }
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-11, 3, 4), LW_OK);
    CHECK_NEAR(d.tracer[4].x, same.tracer[4].x, 1e-9, 0);
    d.o.formulation = LW_FORMULATION_AUTO;
    d.o.analysis = LW_ANALYSIS_STATIC;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
    CHECK_INT(lw_statics_rest(made, 0, q, &rest, &d.e), LW_OK);
    lw_vec2 bob = lw_system_point(lw_dynamics_system(made), 0, lw_v2(0, 0), q);
    CHECK_POINT(bob, 0, -1, 1e-9, 0);
}

/* ---- an energy account that does not hold --------------------------------------------------------- */

static lw_status stiffen(void *context, const lw_moment *m)
{
    d.n_moment++;
    if (m->t >= 0.5)
        *(double *)context = 10;
    return LW_OK;
}

/* The test makes a spring stiffer during the run, which adds energy that no work accounts for: the run ends there and says how much.
 * At a tolerance so loose that its errors could be as great, the run goes on. */
TEST(energy_from_nowhere_is_refused)
{
    static const lw_formulation each[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_RADAU, LW_FORMULATION_INDEX1, LW_FORMULATION_GGL };
    for (int k = 0; k < 4; k++)
        for (int tight = 0; tight < 2; tight++) {
            OWNED(lw_dynamics) *made = NULL;
            drun_read(&d, "examples/pendulum.json");
            d.model.joint_spring[d.model.n_joint_spring++] = (lw_joint_spring){ .joint = 0, .stiffness = 5 };
            d.model.body[1].inertia = 0.1;               /* radau wants some */
            d.o.formulation = each[k];
            d.o.relative = d.o.absolute = tight ? 1e-9 : 1e-2;
            d.n_moment = 0;
            CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
            d.status = lw_dynamics_run(made, stiffen, &d.model.joint_spring[0].stiffness, &d.report, &d.e);
            CHECK_INT(d.status, tight ? LW_E_NUMERIC : LW_OK);
            if (tight) {
                CHECK_HAS(d.e.text, "the energy is off by");
                CHECK(d.n_moment > 50 && d.n_moment < 60);
                CHECK_NEAR(d.report.t, 0.5, 0.2, 0);
            }
        }
}

/* A slider-crank that its slider drives, in its dead point: no velocities give the slider a speed. */
TEST(velocities_that_do_not_exist)
{
    OWNED(lw_dynamics) *made = NULL;
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 1}, {'name': 'b', 'mass': 1, 'centre': "
                     "[0, 1], 'inertia': 1}, {'name': 'c', 'mass': 1, 'centre': [%.17g, 0], 'inertia': 1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
                     "'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, 1]}, {'name': 'C', 'links': ['b', 'c'], 'at': [%.17g, 0]}, {'name': 'S', "
                     "'kind': 't', 'links': ['ground', 'c'], 'at': [0, 0], 'along': [1, 0]}], 'inputs': [{'joint': 'S', 'motion': 't'}], 'tracers': []}",
                     sqrt(3), sqrt(3));
    d.o = lw_dynamics_options_default();
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
    if (made) {
        double unit = made->eq.unit, flat[] = { 0, 0, -LW_PI/2, 1/unit, -1/unit, LW_PI/6, (3 - sqrt(3))/unit, 0, 0 }, v[9] = { 0 };
        CHECK_INT(lw_mbs_project_v(made, 0, made->start_v), LW_OK);
        memcpy(made->start_q, flat, sizeof flat);
        lw_mbs_arrange(made, 0, flat);
        lw_mbs_factor(made, false);
        CHECK_INT(lw_mbs_project_v(made, 0, v), LW_OPEN);
    }
}

/* A driven cart with a pendulum by generalised alpha, whose own accelerations are off by several percent: those shown meet the motion of the input, and
 * the equation of the pendulum at the place of the sample. */
TEST(alpha_shows_accelerations_of_the_place)
{
    const double x = 0.5, y = -0.3;          /* of the centre from the pin */
    for (double tolerance = 1e-3; tolerance > 0.5e-6; tolerance *= 0.1) {
        drun_read_format(&d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [0, 0], 'inertia': 0.1}, "
            "{'name': 'bob', 'mass': 1, 'centre': [0.5, -0.3], 'inertia': 0.1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': "
            "[0, 0], 'along': [1, 0]}, {'name': 'P', 'links': ['cart', 'bob'], 'at': [0, 0]}], 'inputs': [{'joint': 'S', 'motion': '0.3*sin(7*t)'}], "
            "'tracers': [{'name': 'C', 'link': 'cart', 'at': [0, 0]}]}", 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_ALPHA, tolerance, 2, 7), LW_OK);
        double turn = d.q[5], dx = x*cos(turn) - y*sin(turn), dy = x*sin(turn) + y*cos(turn), push = -0.3*49*sin(14);
        CHECK_NEAR(d.a[0]*d.system.unit, push, 1e-10, 0);
        CHECK_NEAR((0.1 + x*x + y*y)*d.a[5], dy*push - 9.81*dx, 10*tolerance, 0);
    }
}
