/* tests/test_dynamics_large.c - models of any size: the sparse way alone gives the motion that both ways give together on
 * models small enough for both; long chains and rows of loops keep their energy. */
#include "mbs/analysis/freedoms.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/equilibrium/modes.h"
#include "mbs/formulations/stepping.h"
#include "tests/dynamics_run.h"

#include "grammar/model/spatial.h"
#include "mbs/analysis/reactions.h"
#include "mbs/formulations/follow_model.h"
#include "tests/large_models.h"
#include "tests/planar_models.h"

/* ---- runs ----------------------------------------------------------------------------------------------- */

/* The last sample; the energy of all. */
typedef struct kept { int n_q, n_sample; double unit, *q, energy[2], off; lw_reaction joint; lw_dynamics *d; } kept;

static lw_status keep(void *context, const lw_moment *m)
{
    kept *k = context;
    double energy = m->kinetic + m->potential - m->work;
    memcpy(k->q, m->q, (size_t)k->n_q*sizeof *k->q);
    k->energy[0] = k->n_sample ? fmin(k->energy[0], energy) : energy;
    k->energy[1] = k->n_sample++ ? fmax(k->energy[1], energy) : energy;
    k->off = fmax(k->off, m->off);
    FREED lw_reaction *all = calloc((size_t)lw_dynamics_system(k->d)->n_joint, sizeof *all);
    lw_reactions_joints(k->d, m, all);
    k->joint = all[0];
    return LW_OK;
}

static lw_status run_by(lw_formulation f, const lw_model *m, double to, double tolerance, kept *k, lw_dynamics_report *r, lw_error *e)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.formulation = f;
    o.to = to, o.intervals = 4, o.relative = o.absolute = tolerance;
    *k = (kept){ 0 };
    lw_status s = lw_dynamics_make(m, &o, &k->d, e);
    if (s != LW_OK)
        return s;
    k->n_q = lw_dynamics_system(k->d)->n_q;
    k->unit = lw_dynamics_system(k->d)->unit;
    k->q = calloc((size_t)k->n_q, sizeof *k->q);
    s = lw_dynamics_run(k->d, keep, k, r, e);
    lw_dynamics_free(k->d);
    return s;
}

static lw_status run(const lw_model *m, double to, double tolerance, kept *k, lw_dynamics_report *r, lw_error *e)
{
    return run_by(LW_FORMULATION_INDEX1, m, to, tolerance, k, r, e);
}

static int by_derivatives;                   /* models that the implicit method ran */

/* The same model by both ways and, without its small copy, by the sparse way alone. */
static void agree(lw_model *m, double to, double tight)
{
    kept both, sparse;
    lw_dynamics_report r;
    CHECK_OK(run(m, to, 1e-11, &both, &r, &check_error));
    free(m->small);
    m->small = NULL;
    CHECK_OK(run(m, to, 1e-11, &sparse, &r, &check_error));
    CHECK_INT(sparse.n_q, both.n_q);
    CHECK_INT(sparse.n_sample, both.n_sample);
    for (int i = 0; both.q && sparse.q && i < both.n_q; i++)
        CHECK_NEAR(sparse.q[i], both.q[i], tight, 0);
    CHECK_POINT(sparse.joint.force, both.joint.force.x, both.joint.force.y, 1e-6, 1e-6);
    CHECK(sparse.off < 1e-12);
    free(sparse.q);
    lw_status s = run_by(LW_FORMULATION_GGL, m, to, 1e-8, &sparse, &r, &check_error);      /* sparse derivatives */
    CHECK(s == LW_OK || s == LW_E_KIND);
    for (int i = 0; s == LW_OK && i < both.n_q; i++)
        CHECK_NEAR(sparse.q[i], both.q[i], 1e-5, 0);
    by_derivatives += s == LW_OK;
    if (s == LW_OK)
        free(sparse.q);
    free(both.q);
    lw_model_free(m);
}

/* ---- tests ---------------------------------------------------------------------------------------------- */

TEST(chains_and_rows_agree)
{
    lw_model m;
    read_chain(8, 0, &m);
    agree(&m, 0.5, 1e-7);
    read_row(5, &m);
    agree(&m, 1, 1e-8);
}

/* Velocities that are left open are the least ones in a small model and those of least energy in a large one: give all links those of the small one. */
static void give_velocities(lw_model *m)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d = NULL;
    CHECK_OK(lw_dynamics_make(m, &o, &d, &check_error));
    const lw_system *s = lw_dynamics_system(d);
    double *start = calloc(2*(size_t)s->n_q, sizeof *start), *v = start + s->n_q;
    lw_dynamics_start(d, start, v);
    for (int b = 0; b < s->n_body; b++) {
        m->body[s->link[b]].has_velocity = true;
        m->body[s->link[b]].velocity = lw_v2_scale(lw_v2(v[3*b], v[3*b + 1]), s->unit);
        m->body[s->link[b]].omega = v[3*b + 2];
    }
    free(start);
    lw_dynamics_free(d);
}

/* Velocities that links are given at the start. */
TEST(velocities_agree)
{
    lw_model m;
    read_chain(6, 0, &m);
    for (int l = 1; l < 6; l += 2) {            /* b0 about its pin; b2 and b4 as they like */
        m.body[l].has_velocity = true;
        m.body[l].velocity = lw_v2(0, l == 1 ? 0.25 : 0.4*l);
        m.body[l].omega = l == 1 ? 3 : 1 - l;
    }
    give_velocities(&m);
    agree(&m, 0.3, 1e-7);
    read_row(3, &m);
    m.has_speed[0] = false;
    m.body[1].has_velocity = true;              /* about its pin, which is half a length away */
    m.has_speed[0] = false;                     /* that of the row is another */
    m.body[1].omega = 2;
    m.body[1].velocity = lw_v2_scale(lw_v2_turn(lw_v2_sub(m.body[1].centre, m.linkage.joint[0].at), lw_v2(0, 1)), 2);
    agree(&m, 0.3, 1e-7);
}

/* Rigid stops in pins: in a small model they are events of their own, in a large one places that touch. */
TEST(stops_agree)
{
    for (int k = 0; k < 2; k++) {
        lw_model m;
        read_chain(6, 0, &m);
        m.stop[2] = (lw_joint_stop){ .has_greatest = true, .greatest = 0.2, .restitution = 0.4*k };
        m.stop[4] = (lw_joint_stop){ .has_least = true, .least = -0.1, .restitution = 0.4*k };
        agree(&m, 0.4, 1e-7);
    }
}

/* A rope whose pins turn by 0.1 either way at most, with more stops than an integrator has events: no stop is passed, and the
 * energy is that of the impacts. */
TEST(stops_in_any_number)
{
    enum { N = 40 };
    const double most = 0.1;
    OWN(lw_model) m = { 0 };
    kept k;
    lw_dynamics_report r;
    read_chain(N, 1e-4, &m);
    for (int j = 1; j < N; j++)
        m.stop[j] = (lw_joint_stop){ .has_least = true, .least = -most, .has_greatest = true, .greatest = most };
    CHECK_SILENT(run(&m, 0.6, 1e-9, &k, &r, &check_error));
    CHECK(r.n_event_seen > N/4);
    for (int j = 1; j < N; j++)
        CHECK(fabs(k.q[3*j + 2] - k.q[3*j - 1]) < most + 1e-7);
    CHECK(k.energy[1] - k.energy[0] < 1e-8);
    free(k.q);
}

static void read_example(const char *name, lw_model *m)
{
    char path[100];
    snprintf(path, sizeof path, "examples/%s.json", name);
    load_planar(path, m);
}

TEST(examples_agree)
{
    static const char *const name[] = { "andrews", "pendulum", "two-four-bars", "loader" };
    for (size_t i = 0; i < sizeof name/sizeof *name; i++) {
        lw_model m;
        read_example(name[i], &m);
        for (int l = 0; l < m.linkage.n_link; l++)           /* each link has a mass */
            if (!(m.body[l].mass > 0 && m.body[l].inertia > 0)) {
                int j = 0;
                while (m.linkage.joint[j].link[0] != l && m.linkage.joint[j].link[1] != l)
                    j++;
                m.body[l] = (lw_body){ .given = true, .mass = 1, .centre = m.linkage.joint[j].at, .inertia = 0.1 };
            }
        for (int k = 0; k < m.linkage.n_input; k++) {         /* and runs freely */
            lw_expression_free(m.motion[k]);
            m.motion[k] = NULL;
        }
        agree(&m, i == 0 ? 0.01 : 0.2, 1e-7);
    }
}

/* Pins, a gear, a slider and an input with a motion; the second rod of a parallelogram is redundant. */
TEST(mixed_agree)
{
    static const char *const format[] = {
        "{'linkwright': 1, 'gravity': [1, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0.1], 'inertia': 0.2}, {'name': 'b', "
        "'mass': 2, 'centre': [1.5, 0.2], 'inertia': 0.3}, {'name': 'c', 'mass': 1.5, 'centre': [2.5, 0], 'inertia': 0.1}, {'name': 'w', 'mass': 1, "
        "'centre': [0, 1], 'inertia': 0.4}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': "
        "[1, 0]},{'name': 'S', 'kind': 't', 'links': ['b', 'c'], 'at': [2, 0], 'along': [1, 0.3]},{'name': 'W', 'links': ['ground', 'w'], 'at': [0, 1]}, "
        "{'name': 'G', 'kind': 'g', 'links': ['w', 'a'], 'at': [0, 0.5], 'ratio': -0.7}], 'inputs': [{'joint': 'B', 'motion': '0.2*sin(3*t)'}, {'joint': "
        "'A', 'speed': 2}],'springs': [{'joint': 'S', 'stiffness': 300, 'damping': 2}]}",
        "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5], 'inertia': 0.1}, {'name': 'b', 'mass': "
        "1, 'centre': [1, 0.5], 'inertia': 0.1}, {'name': 'c', 'mass': 1, 'centre': [2, 0.5], 'inertia': 0.1}, {'name': 'bar', 'mass': 2, 'centre': [1, "
        "1], 'inertia': 0.5}],'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['ground', 'b'], 'at': [1, 0]}, "
        "{'name': 'C', 'links': ['ground', 'c'], 'at': [2, 0]}, {'name': 'D', 'links': ['a', 'bar'], 'at': [0, 1]}, {'name': 'E', 'links': ['b', 'bar'], "
        "'at': [1, 1]}, {'name': 'F', 'links': ['c', 'bar'], 'at': [2, 1]}], 'input': {'joint': 'A', 'speed': 1}}",
    };
    for (int i = 0; i < 2; i++) {
        text t = { .at = strdup(format[i]), .n = strlen(format[i]) };
        OWN(lw_model) m = { 0 };
        read_text(&t, &m);
        if (i == 0) {
            give_velocities(&m);
            agree(&m, 0.5, 1e-8);
            continue;
        }
        kept k;                                  /* reactions are not unique: only the motion is compared */
        lw_dynamics_report r;
        CHECK_OK(run(&m, 0.5, 1e-11, &k, &r, &check_error));
        double turn = k.q[2];
        CHECK_INT(r.redundant, 1);
        free(k.q);
        free(m.small);
        m.small = NULL;
        CHECK_OK(run(&m, 0.5, 1e-11, &k, &r, &check_error));
        CHECK_INT(r.redundant, 1);
        CHECK_NEAR(k.q[2], turn, 1e-9, 0);
        CHECK(k.off < 1e-12);
        free(k.q);
    }
}

/* n four-bars whose rods share the pin at the crank's end. */
static void read_star(int n, lw_model *m)
{
    text t = { 0 };
    put(&t, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'c', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1}");
    for (int i = 0; i < n; i++) {
        double a = 2*LW_PI*(i + 0.5)/n, x = 5*cos(a) + 2.5*cos(a + 2), y = 5*sin(a) + 2.5*sin(a + 2);
        put(&t, ",{'name': 'r%d', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 1},{'name': 'k%d', 'mass': 1, 'centre': "
            "[%.17g, %.17g], 'inertia': 1}", i, 0.5*(x + 1), 0.5*y, i, 0.5*(x + 5*cos(a)), 0.5*(y + 5*sin(a)));
    }
    put(&t, "], 'joints': [{'name': 'A', 'links': ['ground', 'c'], 'at': [0, 0]}");
    for (int i = 0; i < n; i++) {
        double a = 2*LW_PI*(i + 0.5)/n, x = 5*cos(a) + 2.5*cos(a + 2), y = 5*sin(a) + 2.5*sin(a + 2);
        put(&t, ",{'name': 'B%d', 'links': ['c', 'r%d'], 'at': [1, 0]},{'name': 'C%d', 'links': ['r%d', 'k%d'], 'at': [%.17g, %.17g]}"
            ",{'name': 'D%d', 'links': ['k%d', 'ground'], 'at': [%.17g, %.17g]}", i, i, i, i, i, x, y, i, i, 5*cos(a), 5*sin(a));
    }
    put(&t, "], 'input': {'joint': 'A', 'speed': 1}}");
    read_text(&t, m);
}

/* A link with many pins: rows divided among welded parts give what IDA gives with the whole matrix. */
TEST(many_links_on_one_pin)
{
    OWN(lw_model) m = { 0 };
    kept explicit, implicit;
    lw_dynamics_report r;
    read_star(40, &m);
    CHECK_OK(run(&m, 0.5, 1e-11, &explicit, &r, &check_error));
    CHECK(explicit.off < 1e-13);
    CHECK_NEAR(explicit.energy[1] - explicit.energy[0], 0, 1e-9*r.energy_scale, 0);
    CHECK_OK(run_by(LW_FORMULATION_GGL, &m, 0.5, 1e-9, &implicit, &r, &check_error));
    for (int i = 0; i < explicit.n_q; i++)
        CHECK_NEAR(implicit.q[i], explicit.q[i], 1e-6, 0);
    CHECK_POINT(implicit.joint.force, explicit.joint.force.x, explicit.joint.force.y, 1e-3, 1e-4);
    free(explicit.q), free(implicit.q);
}

/* A plate on n upright cranks of 1 m, which together have mass 1. */
static void read_plate(int n, lw_model *m)
{
    text t = { 0 };
    put(&t, "{'linkwright': 1, 'gravity': [3, -9.81], 'links': ['ground', {'name': 'plate', 'mass': 2, 'centre': [0.5, 1.2], 'inertia': 1}");
    for (int i = 0; i < n; i++)
        put(&t, ",{'name': 'c%d', 'mass': %.17g, 'centre': [%.17g, 0.5], 'inertia': %.17g}", i, 1./n, (double)i/(n - 1), 0.1/n);
    put(&t, "], 'joints': [");
    for (int i = 0; i < n; i++)
        put(&t, "%s{'name': 'A%d', 'links': ['ground', 'c%d'], 'at': [%.17g, 0]},{'name': 'B%d', 'links': ['c%d', 'plate'], 'at': "
            "[%.17g, 1]}", i ? "," : "", i, i, (double)i/(n - 1), i, i, (double)i/(n - 1));
    put(&t, "], 'input': {'joint': 'A0', 'speed': 1}}");
    read_text(&t, m);
}

/* Most of the rows of a plate on many cranks depend on others; it moves as on two. */
TEST(many_redundant_pins_on_one_link)
{
    enum { N = 40 };
    OWN(lw_model) m = { 0 };
    kept many, two;
    lw_dynamics_report r;
    read_plate(2, &m);
    CHECK_OK(run(&m, 0.7, 1e-11, &two, &r, &check_error));
    lw_model_free(&m);
    read_plate(N, &m);
    CHECK_OK(run(&m, 0.7, 1e-11, &many, &r, &check_error));
    CHECK_INT(r.redundant, N - 2);
    CHECK(many.off < 1e-12);
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(many.q[k]*many.unit, two.q[k]*two.unit, 1e-9, 0);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(many.q[3*(i + 1) + 2], two.q[5], 1e-9, 0);
    free(many.q), free(two.q);
}

/* Weight and some drag as forces of the caller's own. */
static void weight_and_drag(void *context, double t, const lw_link_motion *link, lw_link_load *load)
{
    const lw_model *m = context;
    (void)t;
    for (int l = 0; l < m->linkage.n_link; l++) {
        load[l].force = lw_v2(-0.1*link[l].velocity.x, -9.81*m->body[l].mass - 0.1*link[l].velocity.y);
        load[l].torque = -1e-4*link[l].angular_velocity;
    }
}

static lw_status run_with(const lw_model *m, lw_formulation f, double *q, lw_dynamics_report *r, lw_error *e)
{
    kept k = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    o.formulation = f, o.relative = o.absolute = 1e-9, o.intervals = 4, o.to = 0.5;
    o.force = (lw_caller_force){ (void *)(uintptr_t)m, weight_and_drag };
    lw_status s = lw_dynamics_make(m, &o, &k.d, e);
    if (s != LW_OK)
        return s;
    k.n_q = lw_dynamics_system(k.d)->n_q, k.q = q;
    s = lw_dynamics_run(k.d, keep, &k, r, e);
    lw_dynamics_free(k.d);
    return s;
}

/* A bar on a torsion spring that a strong damper holds back, c/I = 1e5 1/s, moves by exp(-t k/c) after it has come to rest: Radau's method and, at
 * tolerances for its order, generalised alpha keep to theirs, though steps are 1e5 times as long as the fast decay. */
TEST(strong_dampers)
{
    static const double tolerance[] = { 1e-4, 1e-6, 1e-8, 1e-10, 1e-4, 1e-6 };
    for (int i = 0; i < 6; i++) {
        static drun d;
        double c = 1e5, k = 2e5, slow = (sqrt(c*c - 4*k) - c)/2, fast = k/slow, t = 2, turn = 0.5, rate = -3;
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'mass': 1, 'centre': [0, 0], 'inertia': 1}], 'joints': [{'name': "
                         "'A', 'links': ['ground', 'bar'], 'at': [0, 0]}], 'springs': [{'name': 's', 'joint': 'A', 'stiffness': %.17g, 'damping': %.17g, "
                         "'free': -0.5}], 'input': {'joint': 'A', 'speed': -3}}", k, c);
        CHECK_INT(drun_to(&d, i < 4 ? LW_FORMULATION_RADAU : LW_FORMULATION_ALPHA, tolerance[i], t, 4), LW_OK);
        double a = (rate - fast*turn)/(slow - fast), b = turn - a;
        CHECK_NEAR(d.q[2] + 0.5, a*exp(slow*t) + b*exp(fast*t), 10*tolerance[i], 0);
        CHECK(d.report.steps < (i < 4 ? 300 : 3000));
    }
}

/* Stiff dampers are followed by the implicit method with a caller's force, too, and in pieces. */
TEST(callers_force_keeps_the_implicit_method)
{
    OWN(lw_model) m = { 0 };
    double q[2][3*6];
    lw_dynamics_report r[2];
    read_chain(6, 1, &m);
    m.gravity = lw_v2(0, 0);
    CHECK_OK(run_with(&m, LW_FORMULATION_AUTO, q[0], &r[0], &check_error));
    CHECK_INT(r[0].formulation, LW_FORMULATION_RADAU);
    CHECK_OK(run_with(&m, LW_FORMULATION_INDEX1, q[1], &r[1], &check_error));
    CHECK(r[0].steps < r[1].steps/10);
    for (int i = 0; i < 3*6; i++)
        CHECK_NEAR(q[0][i], q[1][i], 1e-7, 0);
    lw_model_free(&m);
    read_chain(40, 0.1, &m);
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_stepping *s = NULL;
    CHECK_OK(lw_stepping_make(&m, &o, &s, &check_error));
    CHECK_OK(lw_stepping_advance(s, 0.1, NULL, NULL, &r[0], &check_error));
    CHECK_INT(r[0].formulation, LW_FORMULATION_RADAU);
    lw_stepping_free(s);
}

/* A row turns through flat postures like a pendulum.  Steps over these do not grow shorter and shorter where rounding, not their
 * length, limits them: 222 steps in all, not 608. */
TEST(a_row_passes_flat_postures_at_a_tight_tolerance)
{
    enum { N = 40, STEPS = 20000 };
    OWN(lw_model) m = { 0 };
    kept k;
    lw_dynamics_report r;
    double by = 9.81*(0.5*(N + 1) + N)/((N + 1)/3. + N), h = 5./STEPS, turn = LW_PI/2, rate = 1;
    for (int i = 0; i < STEPS; i++) {                        /* by Runge and Kutta */
        double a = -by*cos(turn), b = -by*cos(turn + 0.5*h*rate), c = -by*cos(turn + 0.5*h*rate + 0.25*h*h*a);
        double d = -by*cos(turn + h*rate + 0.5*h*h*b);
        turn += h*rate + h*h/6*(a + b + c);
        rate += h/6*(a + 2*b + 2*c + d);
    }
    read_row(N, &m);
    CHECK_OK(run(&m, 5, 1e-11, &k, &r, &check_error));
    CHECK_NEAR(k.q[2], turn - LW_PI/2, 1e-8, 0);
    CHECK(k.off < 1e-12);
    CHECK(r.steps < 400);
    free(k.q);
}

/* Beside a flat posture a row of 15 loops is solved by its sparse rows, and as accurately as by a full factorisation: its cranks turn
 * as a pendulum does. */
TEST(a_row_beside_a_flat_posture_is_solved_by_its_rows)
{
    enum { N = 15 };
    lw_model m;
    lw_dynamics *d;
    lw_dynamics_options o = lw_dynamics_options_default();
    read_row(N, &m);
    o.formulation = LW_FORMULATION_INDEX1;
    CHECK_OK(lw_dynamics_make(&m, &o, &d, &check_error));
    const lw_system *sys = lw_dynamics_system(d);
    int n = sys->n_q;
    double *q = calloc(6*(size_t)n, sizeof *q), *v = q + n, *start = v + n, *a = start + 2*n, *l = a + n;
    double by = 9.81*(0.5*(N + 1) + N)/((N + 1)/3. + N);
    lw_dynamics_start(d, start, start + n);
    for (int k = 0; k < 3; k++) {
        double turn = LW_PI/2 - 5e-3*pow(0.1, k), rate = 3;
        for (int b = 0; b < sys->n_body; b++) {
            double rise = sys->origin.y/sys->unit + start[3*b + 1], spin = rise*sys->unit < 0.75;
            q[3*b] = start[3*b] - rise*sin(turn), v[3*b] = -rise*cos(turn)*rate;
            q[3*b + 1] = start[3*b + 1] + rise*(cos(turn) - 1), v[3*b + 1] = -rise*sin(turn)*rate;
            q[3*b + 2] = spin*turn, v[3*b + 2] = spin*rate;
        }
        CHECK_INT(lw_mbs_rows(d, 0, q), LW_OK);
        CHECK_INT(lw_mbs_factor(d, false), LW_OK);
        CHECK(!d->by_rank);
        CHECK_INT(lw_mbs_solve(d, 0, q, v, a, l, NULL), LW_OK);
        for (int i = 2; i < 3*(N + 1); i += 3)
            CHECK_NEAR(a[i], by*sin(turn), 1e-10, 0);
    }
    free(q);
    lw_dynamics_free(d);
    lw_model_free(&m);
}

/* ---- driven -------------------------------------------------------------------------------------------------- */

enum { MOMENTS = 41 };
typedef struct moments { lw_dynamics *d; int n, n_c; double *value; } moments;

/* q, v, a and multipliers of every sample. */
static lw_status keep_all(void *context, const lw_moment *m)
{
    moments *k = context;
    int n = lw_dynamics_system(k->d)->n_q, width = 3*n + k->n_c;
    double *to = k->value + k->n++*width;
    for (int i = 0; i < n; i++)
        to[i] = m->q[i], to[n + i] = m->v[i], to[2*n + i] = m->a[i];
    memcpy(to + 3*n, m->l, (size_t)k->n_c*sizeof *to);
    return LW_OK;
}

static lw_status run_driven(const lw_model *m, lw_analysis analysis, double to, moments *k, lw_dynamics_report *r, lw_error *e)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = analysis;
    o.to = to, o.intervals = MOMENTS - 1;
    *k = (moments){ .n = 0 };
    lw_status s = lw_dynamics_make(m, &o, &k->d, e);
    if (s != LW_OK)
        return s;
    const lw_system *sys = lw_dynamics_system(k->d);
    k->n_c = sys->n_row + sys->n_input;
    k->value = calloc((size_t)MOMENTS*(size_t)(3*sys->n_q + k->n_c), sizeof *k->value);
    s = lw_dynamics_run(k->d, keep_all, k, r, e);
    lw_dynamics_free(k->d);
    return s;
}

/* A driven model gives the same by certified steps and dense rows, and by the series and sparse rows of large models. */
static void driven_agree(lw_model *m, lw_analysis analysis, double to, double tight)
{
    moments small, large;
    lw_dynamics_report r, certified;
    lw_error e = { 0 };
    int n_q = 3*(m->linkage.n_link - 1);
    lw_linkage *plan = m->small;
    CHECK_INT(run_driven(m, analysis, to, &small, &certified, &e), LW_OK);
    m->small = NULL;
    CHECK_INT(run_driven(m, analysis, to, &large, &r, &e), LW_OK);
    m->small = plan;
    if (e.text[0])
        fprintf(stderr, "%s\n", e.text);
    CHECK_INT(large.n, small.n);
    CHECK_NEAR(r.worst_off, 0, 1e-11, 0);       /* an interpolated posture */
    int width = 3*n_q + small.n_c;
    for (int i = 0; i < small.n*width; i++) {
        double a = small.value[i], b = large.value[i];
        bool drive = m->linkage.n_input == 1 && i%width == width - 1;    /* of a single input: known in flat postures too */
        if (i%width < 3*n_q || (isfinite(a) && (drive || isfinite(b))))
            CHECK_NEAR(b, a, tight, tight);
    }
    CHECK(certified.without_forces <= r.without_forces);
    CHECK_INT(r.lost, certified.lost);          /* a singular posture is told, at a row and between two */
    if (certified.lost)
        CHECK_NEAR(r.lost_t[0], certified.lost_t[0], 1e-6, 0);
    free(small.value), free(large.value);
}

TEST(driven_agree_with_certified_steps)
{
    static const struct { const char *name, *motion; } example[] = {
        { "slider-crank", "%.17g + 3*t + 0.4*sin(5*t)" }, { "jansen", "%.17g + 6.3*t" }, { "klann", "%.17g - 6.3*t" },
        { "geared-five-bar", "%.17g + 2*t^2" }, { "andrews", "%.17g + 6.3*t" }, { "trammel", "%.17g - 0.05*t" },
        { "loader", NULL }, { "five-bar", NULL }, { "tied-five-bar", "%.17g + t" } };
    lw_model m;
    for (size_t i = 0; i < sizeof example/sizeof *example; i++) {
        char law[100];
        read_example(example[i].name, &m);
        if (example[i].motion) {
            snprintf(law, sizeof law, example[i].motion, m.linkage.input[0].value);
            CHECK_OK(lw_model_drive(&m, 0, law, &check_error));
        }
        driven_agree(&m, i%2 ? LW_ANALYSIS_QUASISTATIC : LW_ANALYSIS_KINEMATIC, 1, 1e-8);
        lw_model_free(&m);
    }
    for (int grid = 0; grid < 3; grid++) {       /* flat postures: at a sample, near one, between two */
        static const char *const motion[] = { "1.5707963267948966 + 3.1415926535897931*t", "1.5707963267948966 + 3.1406*t",
                                              "1.5707963267948966 - 5.9*t" };
        read_row(4, &m);
        CHECK_OK(lw_model_drive(&m, 0, motion[grid], &check_error));
        driven_agree(&m, LW_ANALYSIS_KINEMATIC, 1, 2e-6);
        lw_model_free(&m);
    }
}

/* A row of n four-bars, driven for a turn: all cranks stay parallel, through two flat postures. */
static void row_turns(int n)
{
    OWN(lw_model) m = { 0 };
    moments k;
    lw_dynamics_report r;
    read_row(n, &m);
    CHECK_OK(lw_model_drive(&m, 0, "1.5707963267948966 + 6.2831853071795862*t", &check_error));
    CHECK_OK(run_driven(&m, LW_ANALYSIS_KINEMATIC, 1, &k, &r, &check_error));
    int n_q = 3*(2*n + 1), width = 3*n_q + k.n_c;
    for (int s = 0; s < k.n; s++)
        for (int b = 0; b < 2*n + 1; b++)
            CHECK_NEAR(k.value[s*width + 3*b + 2], b <= n ? 2*LW_PI*s/(MOMENTS - 1) : 0, 1e-8, 0);
    free(k.value);
}

TEST(rows_of_loops_turn_through_flat_postures)
{
    row_turns(40);
    row_turns(400);
}

/* Mobility by sparse factors and by rank-revealing ones. */
/* A tower of n four-bars, each on the rung of the one below, with legs leaning to either side in turn; every left leg is
 * driven by the same angle. */
static void read_tower(int n, lw_model *m)
{
    text t = { 0 };
    const double lean = 80*LW_PI/180;
    put(&t, "{'linkwright': 1, 'ground': 'ground', 'links': ['ground'");
    for (int i = 0; i < n; i++)
        put(&t, ",'a%d','b%d','r%d'", i, i, i);
    put(&t, "], 'joints': [");
    lw_vec2 p = { 0, 0 };
    char below[16] = "ground";
    for (int i = 0; i < n; i++) {
        lw_vec2 top = lw_v2_add(p, lw_v2_polar(1, i % 2 ? LW_PI - lean : lean));
        put(&t, "%s{'name': 'A%d', 'links': ['%s', 'a%d'], 'at': [%.17g, %.17g]},", i ? "," : "", i, below, i, p.x, p.y);
        put(&t, "{'name': 'B%d', 'links': ['%s', 'b%d'], 'at': [%.17g, %.17g]},", i, below, i, p.x + 1, p.y);
        put(&t, "{'name': 'C%d', 'links': ['a%d', 'r%d'], 'at': [%.17g, %.17g]},", i, i, i, top.x, top.y);
        put(&t, "{'name': 'D%d', 'links': ['b%d', 'r%d'], 'at': [%.17g, %.17g]}", i, i, i, top.x + 1, top.y);
        snprintf(below, sizeof below, "r%d", i);
        p = top;
    }
    put(&t, "], 'tracers': [{'name': 'T', 'link': '%s', 'at': [%.17g, %.17g]}], 'inputs': [", below, p.x, p.y);
    for (int i = 0; i < n; i++)
        put(&t, "%s{'joint': 'A%d', 'value': 0, 'motion': '0.3*t'}", i ? "," : "", i);
    put(&t, "]}");
    read_text(&t, m);
}

/* Its rows have a condition of about n^2, whose square is beyond a double: it was called singular.  The top by a formula. */
TEST(tall_towers_are_not_singular)
{
    for (int n = 50; n <= 5000; n *= 10) {
        OWN(lw_model) m = { 0 };
        lw_follow *f;
        read_tower(n, &m);
        CHECK_OK(lw_follow_create(&m, lw_prescribed_motion_of_model, &m, 0, NULL, &f, &check_error));
        CHECK_SILENT(lw_follow_to(f, 1, &check_error));
        const lw_system *s = lw_follow_system(f);
        lw_vec2 top = lw_system_point(s, s->tracer_body[0], s->tracer_arm[0], lw_follow_series(f));
        CHECK_POINT(top, -n*sin(80*LW_PI/180)*sin(0.3), n*sin(80*LW_PI/180)*cos(0.3), 1e-8*n, 0);
        lw_follow_free(f);
    }
}

TEST(mobility_agrees)
{
    static const char *const name[] = { "slider-crank", "jansen", "klann", "geared-five-bar", "andrews", "trammel", "loader",
                                        "five-bar", "tied-five-bar", "chebyshev", "mobility/focal", "two-four-bars", "pendulum" };
    lw_model m;
    lw_freedoms f;
    static lw_mobility want;
    for (size_t i = 0; i < sizeof name/sizeof *name; i++) {
        read_example(name[i], &m);
        lw_mobility_options o = lw_mobility_options_default();
        CHECK_OK(lw_mobility_find(m.small, &o, &want, &check_error));
        CHECK_OK(lw_freedoms_find(&m, o.tolerance, 1, &f, &check_error));
        CHECK_INT(f.kind, want.kind);
        CHECK_INT(f.count, want.count);
        CHECK_INT(f.freedom, want.freedom);
        CHECK_INT(f.instant, want.instant);
        CHECK_INT(f.rank, want.rank);
        CHECK_INT(f.n_redundant, want.n_redundant);
        CHECK_INT(f.driven, want.driven);
        for (int l = 0; f.still && l < m.linkage.n_link; l++)
            CHECK_INT(f.still[l], want.still_links >> l & 1);
        lw_freedoms_free(&f);
        lw_model_free(&m);
    }
    static const char *const special[] = {          /* flat four-bar that cannot move, three equal rods, a braced frame */
        "{'linkwright': 1, 'links': ['ground', 'a', 'b'], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': "
        "'B', 'links': ['a', 'b'], 'at': [1, 0]}, {'name': 'C', 'links': ['b', 'ground'], 'at': [3, 0]}]}",
        "{'linkwright': 1, 'links': ['ground', 'a', 'b', 'c', 'bar'], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},{'name': 'B', "
        "'links': ['ground', 'b'], 'at': [1, 0]}, {'name': 'C', 'links': ['ground', 'c'], 'at': [2.5, 0]}, {'name': 'D', 'links': ['a', 'bar'], 'at': "
        "[0.3, 1]}, {'name': 'E', 'links': ['b', 'bar'], 'at': [1.3, 1]}, {'name': 'F', 'links': ['c', 'bar'], 'at': [2.8, 1]}], 'input': {'joint': 'A'}}",
        "{'linkwright': 1, 'links': ['ground', 'a', 'b', 'c', 'bar'], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},{'name': 'B', "
        "'links': ['ground', 'b'], 'at': [1, 0]}, {'name': 'C', 'links': ['ground', 'c'], 'at': [2.5, 0.1]}, {'name': 'D', 'links': ['a', 'bar'], 'at': "
        "[0.3, 1]}, {'name': 'E', 'links': ['b', 'bar'], 'at': [1.3, 1]}, {'name': 'F', 'links': ['c', 'bar'], 'at': [2.9, 1]}]}" };
    for (size_t i = 0; i < sizeof special/sizeof *special; i++) {
        text t = { .at = strdup(special[i]), .n = strlen(special[i]) };
        read_text(&t, &m);
        lw_mobility_options o = lw_mobility_options_default();
        CHECK_OK(lw_mobility_find(m.small, &o, &want, &check_error));
        CHECK_OK(lw_freedoms_find(&m, o.tolerance, 1, &f, &check_error));
        CHECK_INT(f.kind, want.kind);
        CHECK_INT(f.freedom, want.freedom);
        CHECK_INT(f.instant, want.instant);
        lw_freedoms_free(&f);
        lw_model_free(&m);
    }
    read_row(400, &m);
    CHECK_OK(lw_freedoms_find(&m, 1e-12, 1, &f, &check_error));
    CHECK_INT(f.freedom, 1);
    CHECK_INT(f.driven, 1);
    for (int l = 0; l < m.linkage.n_link; l++)
        CHECK(!f.loose[l] && !f.still[l]);
    lw_freedoms_free(&f);
    lw_model_free(&m);
}

/* A rope with dampers in all pins, which make it stiff: the implicit method is chosen, and it agrees with the explicit
 * one. */
TEST(damped_ropes)
{
    OWN(lw_model) m = { 0 };
    kept k[2];
    lw_dynamics_report r;
    read_chain(60, 1e-3, &m);
    CHECK_OK(run(&m, 0.1, 1e-10, &k[0], &r, &check_error));
    CHECK_OK(run_by(LW_FORMULATION_GGL, &m, 0.1, 1e-9, &k[1], &r, &check_error));
    for (int i = 0; i < k[0].n_q; i++)
        CHECK_NEAR(k[1].q[i], k[0].q[i], 1e-6, 0);
    for (int i = 0; i < 60; i++)
        m.joint_spring[i].damping = 10;
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    CHECK_OK(lw_dynamics_make(&m, &o, &d, &check_error));
    CHECK_INT(lw_dynamics_choice(d)->formulation, LW_FORMULATION_RADAU);
    lw_dynamics_free(d);
    for (int i = 0; i < 2; i++)
        free(k[i].q);
}

/* A rope that is let go: far from its pin it falls freely. */
TEST(thousand_links)
{
    OWN(lw_model) m = { 0 };
    kept k;
    lw_dynamics_report r;
    read_chain(1000, 0, &m);
    CHECK(!m.small);
    CHECK_SILENT(run(&m, 0.02, 1e-10, &k, &r, &check_error));
    CHECK_INT(r.freedom, 1000);
    CHECK(k.energy[1] - k.energy[0] < 1e-9*9.81);
    CHECK(k.off < 1e-12);
    CHECK_NEAR(k.unit*k.q[3*900 + 1], -9.81*0.02*0.02/2, 1e-9, 0);      /* far from the pin it falls freely */
    free(k.q);
}

/* The row of n loops in one coordinate, the turn of its cranks: y = turn and its rate. */
static lw_status row_rate(void *context, double t, const double *y, double *dy)
{
    double n = *(const double *)context, inertia = (n + 1)/3 + n, weight = 9.81*(0.5*(n + 1) + n);
    (void)t;
    dy[0] = y[1];
    dy[1] = weight*sin(y[0])/inertia;
    return LW_OK;
}

/* They pass the flat posture, in which every loop is singular, at 1.24 s. */
TEST(rows_of_loops)
{
    for (double n = 40; n <= 400; n *= 10) {
        OWN(lw_model) m = { 0 };
        kept k;
        lw_dynamics_report r;
        double y[2] = { 0, 1 };
        read_row((int)n, &m);
        CHECK_SILENT(run(&m, 1.5, 1e-9, &k, &r, &check_error));
        CHECK_INT(r.freedom, 1);
        CHECK_INT(r.redundant, 0);
        CHECK(k.energy[1] - k.energy[0] < 1e-7*n*9.81);
        drun_exact(&(lw_ode){ .n = 2, .context = &n, .rate = row_rate }, 0, y, 1.5);
        CHECK(y[0] > 0.5*LW_PI);
        for (int i = 0; i <= n; i++)
            CHECK_NEAR(k.q[3*i + 2], y[0], 1e-7, 0);
        free(k.q);
    }
}

/* Ten times through the flat posture at loose tolerances: long steps over it do not end on the other branch. */
TEST(rows_of_loops_at_loose_tolerances)
{
    static const double tolerance[] = { 1e-4, 1e-5, 1e-6 };
    double n = 400, y[2] = { 0, 1 };
    drun_exact(&(lw_ode){ .n = 2, .context = &n, .rate = row_rate }, 0, y, 10);
    for (int t = 0; t < 3; t++) {
        OWN(lw_model) m = { 0 };
        kept k;
        lw_dynamics_report r;
        read_row((int)n, &m);
        CHECK_OK(run(&m, 10, tolerance[t], &k, &r, &check_error));
        for (int i = 0; i <= n; i++)
            CHECK_NEAR(k.q[3*i + 2], y[0], 1e3*tolerance[t], 0);
        free(k.q);
    }
}

/* A rope drawn horizontally comes to rest hanging down.  Its first frequencies there are those of a hanging chain,
 * j/2 sqrt(g/L) with the zeros j of J_0, and the links in line with the vertical. */
TEST(rope_at_rest)
{
    OWN(lw_model) m = { 0 };
    lw_dynamics *d;
    lw_rest rest;
    OWN(lw_modes) modes = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    read_chain(60, 0, &m);
    o.analysis = LW_ANALYSIS_STATIC;
    CHECK_OK(lw_dynamics_make(&m, &o, &d, &check_error));
    double *q = calloc(180, sizeof *q);
    CHECK_OK(lw_statics_rest(d, 0, q, &rest, &check_error));
    CHECK(rest.stable);
    for (int b = 0; b < 60; b++) {
        lw_vec2 at = lw_system_point(lw_dynamics_system(d), b, lw_v2(0, 0), q);
        CHECK_POINT(at, 0, -(b + 0.5)/60, 1e-9, 0);
    }
    CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ 0 }, 3, 0, q, &modes, &check_error));
    static const double zero[] = { 2.404825558, 5.520078110, 8.653727913 };
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(modes.mode[i].im, zero[i]/2*sqrt(9.81), 0, 2e-3);
    lw_dynamics_free(d);
    free(q);
}

/* An arch of n links of length and mass 1 whose pins lie on the line of thrust of their weights, turned over: it stands in
 * equilibrium, which is not stable; side -1: it hangs in it. */
static void read_arch(int n, double side, lw_model *m)
{
    text t = { 0 };
    put(&t, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground'");
    lw_vec2 at = { 0, 0 }, along = { 0, 0 };
    for (int pass = 0; pass < 2; pass++) {
        at = lw_v2(0, 0);
        for (int i = 0; i < n; i++, at = lw_v2_add(at, along)) {
            double turn = atan2(side*(0.5*(n - 1) - i), 0.4*n);
            along = lw_v2(cos(turn), sin(turn));
            if (pass == 0)
                put(&t, ",{'name': 'l%d', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.0833}", i, at.x + along.x/2,
                    at.y + along.y/2);
            else
                put(&t, "{'name': 'J%d', 'links': ['%s%.0d', 'l%d'], 'at': [%.17g, %.17g]},", i,
                    i == 0 ? "ground" : i == 1 ? "l0" : "l", i > 1 ? i - 1 : 0, i, at.x, at.y);
        }
        put(&t, pass == 0 ? "], 'joints': [" : "{'name': 'end', 'links': ['l%d', 'ground'], 'at': [%.17g, %.17g]}]}", n - 1, at.x, at.y);
    }
    read_text(&t, m);
}

/* Standing arches fall without a false end, and keep their energy; hanging ones stay. */
TEST(arches_in_equilibrium)
{
    for (int n = 100; n <= 1000; n *= 10)
        for (int side = -1; side <= 1; side += 2) {
            OWN(lw_model) m = { 0 };
            kept k;
            lw_dynamics_report r;
            read_arch(n, side, &m);
            CHECK_SILENT(run(&m, 1, 1e-10, &k, &r, &check_error));
            CHECK(k.off < 1e-12);
            CHECK(k.energy[1] - k.energy[0] < 1e-10*n*n*9.81);
            for (int i = 0; side < 0 && i < n; i++)
                CHECK_NEAR(k.q[3*i + 2], 0, 1e-8, 0);
            free(k.q);
        }
}

/* Where the middles of the n links of the model, which is freed, are at rest. */
static void rest_of(lw_model *m, int n, lw_vec2 *middle)
{
    lw_dynamics *d;
    lw_rest rest = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    CHECK_OK(lw_dynamics_make(m, &o, &d, &check_error));
    double *q = calloc(3*(size_t)n, sizeof *q);
    CHECK_SILENT(lw_statics_rest(d, 0, q, &rest, &check_error));
    CHECK(rest.stable);
    for (int b = 0; b < n; b++)
        middle[b] = lw_system_point(lw_dynamics_system(d), b, lw_v2(0, 0), q);
    free(q);
    lw_dynamics_free(d);
    lw_model_free(m);
}

/* A standing arch comes to rest as the hanging one, a long row of upright cranks hanging down. */
TEST(large_models_at_rest)
{
    enum { ARCH = 1000, ROW = 3000 };
    lw_model m;
    FREED lw_vec2 *at = calloc(2*ROW + 1, sizeof *at);
    for (int k = 0; k < 2; k++) {
        read_arch(ARCH, k ? 1 : -1, &m);
        rest_of(&m, ARCH, at + k*ARCH);
    }
    for (int b = 0; b < ARCH; b++)
        CHECK_POINT(at[ARCH + b], at[b].x, at[b].y, 1e-7, 0);
    read_row(ROW, &m);
    rest_of(&m, 2*ROW + 1, at);
    for (int i = 0; i <= ROW; i++)
        CHECK_NEAR(at[i].y, -0.5, 1e-9, 0);
}

/* n four-bars side by side, with friction in each pin. */
static void read_copies(int n, double radius, lw_model *m)
{
    text t = { 0 };
    put(&t, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground'");
    for (int i = 0; i < n; i++)
        put(&t, ",{'name': 'c%d', 'mass': 1, 'centre': [%.17g, 0.4], 'inertia': 0.1}, {'name': 'k%d', 'mass': 1, 'centre': [%.17g, 1.4],"
            "'inertia': 0.3}, {'name': 'o%d', 'mass': 1, 'centre': [%.17g, 1], 'inertia': 0.4}", i, 10*i + 0.3, i, 10*i + 2.4, i, 10*i + 3.9);
    put(&t, "], 'joints': [");
    for (int i = 0; i < n; i++) {
        const struct { const char *name, *from, *to; double x, y; } pin[] = {
            { "A", "ground", "c", 0, 0 }, { "B", "c", "k", 0.6, 0.8 }, { "C", "k", "o", 4.3, 2 }, { "D", "ground", "o", 3.5, 0 },
        };
        for (int j = 0; j < 4; j++) {
            put(&t, "%s{'name': '%s%d', 'links': ['%s", i || j ? "," : "", pin[j].name, i, pin[j].from);
            if (j == 1 || j == 2)
                put(&t, "%d", i);
            put(&t, "', '%s%d'], 'at': [%.17g, %g], 'friction': {'coefficient': 0.5, 'radius': %g, 'speed': 0.01}}", pin[j].to, i,
                10*i + pin[j].x, pin[j].y, radius);
        }
    }
    put(&t, "], 'inputs': [");
    for (int i = 0; i < n; i++)
        put(&t, "%s{'joint': 'A%d', 'speed': 1}", i ? "," : "", i);
    put(&t, "]}");
    read_text(&t, m);
}

/* Friction in more joints than 64; each copy moves as one alone.  At a radius of 0.6 the determinant of all joints is below
 * 1e-3 from eight copies on, though each is far from Painleve's paradox. */
TEST(friction_in_any_number_of_joints)
{
    static const int number[] = { 1, 8, 33, 50 };
    static const double radius[] = { 0.02, 0.6 };
    for (int r = 0; r < 2; r++) {
        double alone[9] = { 0 };
        for (size_t i = 0; i < sizeof number/sizeof *number; i++) {
            OWN(lw_model) m = { 0 };
            kept k;
            lw_dynamics_report report;
            read_copies(number[i], radius[r], &m);
            CHECK_OK(run(&m, 0.2, 1e-9, &k, &report, &check_error));
            CHECK_INT(k.n_sample, 5);
            CHECK_INT(k.n_q, 9*number[i]);
            for (int c = 0; k.q && c < number[i]; c++)
                for (int q = 0; q < 9; q++) {
                    double value = k.q[9*c + q]*(q%3 == 2 ? 1 : k.unit) - (q%3 == 0 ? 10*c : 0);
                    if (i == 0)
                        alone[q] = value;
                    CHECK_NEAR(value, alone[q], 1e-8, 0);
                }
            free(k.q);
        }
        CHECK(fabs(alone[2]) > 0.01);
    }
}

/* Friction in pins that load each other, in passes over all of them, beside IDA, whose unknowns the reactions are; the equations of all
 * joints, quadratic in memory, are made only where passes do not do. */
TEST(friction_in_passes)
{
    lw_model m;
    kept one, all;
    lw_dynamics_report report;
    read_rising_row(8, 0.05, &m);
    for (int j = 0; j < m.linkage.n_joint; j++)
        m.friction[j] = (lw_friction){ .coefficient = 0.3, .radius = 0.05, .speed = 0.02 };
    CHECK_OK(run_by(LW_FORMULATION_GGL, &m, 0.3, 1e-10, &one, &report, &check_error));
    CHECK_OK(run(&m, 0.3, 1e-11, &all, &report, &check_error));
    CHECK(one.n_q == all.n_q && fabs(all.q[2] - LW_PI/2) > 0.01);
    for (int i = 0; i < one.n_q; i++)
        CHECK_NEAR(all.q[i], one.q[i], 1e-8, 0);
    free(one.q);
    free(all.q);
    lw_model_free(&m);
    for (int wide = 0; wide < 2; wide++) {
        lw_dynamics_options o = lw_dynamics_options_default();
        lw_dynamics *d;
        read_copies(100, wide ? 0.6 : 0.02, &m);
        o.to = 0.01, o.intervals = 1, o.formulation = LW_FORMULATION_INDEX1;
        CHECK_OK(lw_dynamics_make(&m, &o, &d, &check_error));
        CHECK_OK(lw_dynamics_run(d, NULL, NULL, &report, &check_error));
        CHECK((d->response != NULL) == wide);
        lw_dynamics_free(d);
        lw_model_free(&m);
    }
}

/* Velocities of all rows of a run. */
typedef struct rates { int n, rows; double *v; } rates;

static lw_status keep_rates(void *context, const lw_moment *m)
{
    rates *r = context;
    memcpy(r->v + r->rows++*r->n, m->v, (size_t)r->n*sizeof *r->v);
    return LW_OK;
}

static void run_rates(const lw_model *m, lw_formulation f, double tolerance, double to, int rows, rates *r)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics_report report;
    lw_dynamics *d;
    o.formulation = f;
    o.to = to, o.intervals = rows, o.relative = o.absolute = tolerance;
    CHECK_OK(lw_dynamics_make(m, &o, &d, &check_error));
    *r = (rates){ .n = lw_dynamics_system(d)->n_q };
    r->v = calloc((size_t)(r->n*(rows + 1)), sizeof *r->v);
    CHECK_OK(lw_dynamics_run(d, keep_rates, r, &report, &check_error));
    CHECK_INT(r->rows, rows + 1);
    lw_dynamics_free(d);
}

static double greatest_difference(int n, const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* Velocities in the rows within the steps of radau, and in those at which steps end, are as accurate as the tolerance. */
TEST(rows_within_steps)
{
    enum { ROWS = 360 };
    OWN(lw_model) m = { 0 };
    rates exact, all, end;
    read_chain(10, 0, &m);
    run_rates(&m, LW_FORMULATION_INDEX1, 1e-11, 0.35, ROWS, &exact);
    for (double tolerance = 1e-4; tolerance > 1e-9; tolerance *= 1e-2) {
        double within = 0, at_ends = 0;
        run_rates(&m, LW_FORMULATION_RADAU, tolerance, 0.35, ROWS, &all);
        for (int k = 1; k <= ROWS; k++)
            within = fmax(within, greatest_difference(all.n, all.v + k*all.n, exact.v + k*exact.n));
        for (int k = 30; k <= ROWS; k += 30) {
            run_rates(&m, LW_FORMULATION_RADAU, tolerance, 0.35*k/ROWS, 1, &end);
            at_ends = fmax(at_ends, greatest_difference(end.n, end.v + end.n, exact.v + k*exact.n));
            free(end.v);
        }
        CHECK(within < 10*tolerance && at_ends < 10*tolerance);
        free(all.v);
    }
    free(exact.v);
}

TEST(refusals_say_why)
{
    OWN(lw_model) m = { 0 };
    lw_dynamics *d;
    lw_dynamics_options o = lw_dynamics_options_default();
    read_chain(40, 0, &m);
    o.analysis = LW_ANALYSIS_KINEMATIC;
    CHECK_FAILS(lw_dynamics_make(&m, &o, &d, &check_error), LW_E_ARG, "40 more freedoms");
    o.analysis = LW_ANALYSIS_DYNAMIC;
    m.body[7].inertia = 0;
    CHECK_FAILS(lw_dynamics_make(&m, &o, &d, &check_error), LW_E_ARG, "\"b6\" needs");
    m.body[7].inertia = 1;
    for (int n = 3; n <= 40; n += 37) {                  /* a four-bar with two driven cranks among n pendulums */
        OWN(lw_model) two = { 0 };
        text t = { 0 };
        put(&t, "{'linkwright': 1, 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, 1]},"
                "{'name': 'C', 'links': ['b', 'c'], 'at': [2, 1.2]}, {'name': 'D', 'links': ['c', 'ground'], 'at': [2, 0]}");
        for (int i = 0; i < n; i++)
            put(&t, ", {'name': 'P%d', 'links': ['ground', 'p%d'], 'at': [%d, 0]}", i, i, i + 3);
        put(&t, "], 'inputs': [{'joint': 'P0', 'motion': 't'}, {'joint': 'A', 'motion': '0.3*t'}, {'joint': 'D', 'motion': '0.9*t'}, "
                "{'joint': 'P1', 'motion': '2*t'}]}");
        json_quotes(t.at);
        CHECK_INT(lw_model_read(t.at, t.n, "two", &two, &check_error), LW_OK);
        free(t.at);
        CHECK_FAILS(lw_dynamics_make(&two, &o, &d, &check_error), LW_E_ARG, "leave motions out, as that of \"D\"");
    }
}

CHECK_MAIN
{
    check_run();
    CHECK(by_derivatives >= 4);
    return check_end();
}

/* 500 bars, each on one before it, in the order of a shuffle; with `odd`, a second link or joint is called as the seventh,
 * and a tracer is on the link `of`. */
static lw_status read_bars(bool space, bool list, int odd, const char *of, void *model, lw_error *e)
{
    enum { N = 500 };
    text t = { 0 };
    const char *z = space ? ", 0" : "", *axis = space ? ", 'axis': [0, 0, 1]" : "";
    put(&t, "{'linkwright': 1, ");
    for (int i = 0; list && i <= N; i++)
        put(&t, i == 0 ? "'links': ['ground'" : i == odd ? ", 'b%d', 'b7'" : ", 'b%d'", i);
    put(&t, list ? "], 'joints': [" : "'joints': [");
    for (int i = 1; i <= N; i++) {
        int at = 7*i % (N + 1);                           /* visits each once: 7 and 501 have no common factor */
        put(&t, "%s{'name': 'J%d', 'links': ['%s%.0d', 'b%d'], 'at': [%d, %d%s]%s}", i > 1 ? ", " : "", !list && at == odd ? 7 : at,
            at > 1 ? "b" : "ground", at > 1 ? at/2 : 0, at, at, at % 3, z, axis);
    }
    put(&t, "], 'tracers': [{'name': 'P', 'link': '%s', 'at': [0, 0%s]}]}", of, z);
    json_quotes(t.at);
    *e = (lw_error){ 0 };
    lw_status s = space ? lw_spatial_read(t.at, t.n, "bars", model, e) : lw_model_read(t.at, t.n, "bars", model, e);
    free(t.at);
    return s;
}

TEST(names_among_many)
{
    lw_model m;
    lw_spatial s;
    lw_error e;
    char name[16], base[16];
    for (int list = 0; list < 2; list++) {
        CHECK_INT(read_bars(false, list, -1, "b300", &m, &e), LW_OK);
        CHECK_INT(read_bars(true, list, -1, "b300", &s, &e), LW_OK);
        CHECK_INT(m.linkage.n_link, 501);
        CHECK_INT(s.n_link, 501);
        for (int j = 0; j < m.linkage.n_joint; j++) {
            int at = (int)m.linkage.joint[j].at.x;
            snprintf(name, sizeof name, "b%d", at);
            snprintf(base, sizeof base, at > 1 ? "b%d" : "ground", at/2);
            CHECK_TEXT(m.linkage.link_name[m.linkage.joint[j].link[0]], base);
            CHECK_TEXT(m.linkage.link_name[m.linkage.joint[j].link[1]], name);
            CHECK_TEXT(s.body[s.joint[j].link[0]].name, base);
            CHECK_TEXT(s.body[s.joint[j].link[1]].name, name);
        }
        CHECK_TEXT(m.linkage.link_name[m.linkage.tracer[0].link], "b300");
        CHECK_TEXT(s.body[s.tracer[0].link].name, "b300");
        lw_model_free(&m);
        lw_spatial_free(&s);
        for (int space = 0; space < 2; space++) {
            void *model = space ? (void *)&s : (void *)&m;
            CHECK(read_bars(space, list, 400, "b300", model, &e) < 0);
            CHECK_HAS(e.text, list ? "b7" : "J7");
            CHECK(read_bars(space, list, -1, "b30x", model, &e) < 0);
            CHECK_HAS(e.text, "there is no link \"b30x\"; did you mean \"b30");
        }
    }
}
