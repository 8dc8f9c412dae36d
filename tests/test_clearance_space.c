/* Spherical and revolute joints with clearance in space: closed forms of a bouncing ball and of the contact laws, the
 * limits of no clearance and of a stiff contact, the same linkage in the plane, a pretensioned joint, a DELTA robot. */
#include "mbs/clearance/clearance.h"
#include "tests/clearance_models.h"
#include "tests/space_run.h"

static srun k;

static lw_dynamics_report run(const lw_spatial *m, lw_formulation f, double to, int intervals, double tolerance, bool closed)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.formulation = f, o.to = to, o.intervals = intervals, o.relative = o.absolute = tolerance;
    o.rigid = true, o.closed = closed;
    srun_go(m, &o, &k);
    return k.r;
}

/* A ball of mass 2 kg in a socket at the origin; more: parts of the model. */
static void read_ball_with(const char *clearance, const char *rest, const char *more, lw_spatial *m)
{
    char text[2048];
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'ball', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [0.01, 0.01, "
                     "0.01]%s}], 'joints': [{'name': 'S', 'kind': 'spherical', 'links': ['ground', 'ball'], 'at': [0, 0, 0], 'clearance': {%s}}], "
                     "'tracers': [{'name': 'P', 'link': 'ball', 'at': [0, 0, 0]}]%s}", rest, clearance, more);
    read_spatial(text, "ball", m);
}

static void read_ball(const char *clearance, const char *rest, lw_spatial *m) { read_ball_with(clearance, rest, "", m); }

static lw_vec3 random_direction(lw_rng *r)
{
    lw_vec3 v;
    do
        v = lw_v3(lw_rng_range(r, -1, 1), lw_rng_range(r, -1, 1), lw_rng_range(r, -1, 1));
    while (!(lw_v3_norm(v) > 0.1));
    return lw_v3_scale(v, 1/lw_v3_norm(v));
}

/* Free fall over the gap, half an oscillation in contact, and back: m x'' = m g - K x from x = 0, x' = v lasts
 * 2 (pi - atan(v w/g))/w. */
TEST(a_ball_bounces)
{
    static const lw_formulation how[] = { LW_FORMULATION_RADAU, LW_FORMULATION_INDEX1 };
    lw_rng r = check_rng(0);
    for (int trial = 0; trial < 4; trial++) {
        OWN(lw_spatial) m = { 0 };
        double gap = 1e-3, K = 1e6, g = 9.81, w = sqrt(K/2), v = sqrt(2*g*gap), fall = sqrt(2*gap/g);
        double contact = 2*(LW_PI - atan(v*w/g))/w, period = 2*fall + contact;
        read_ball("'model': 'impact', 'gap': 0.001, 'stiffness': 1e6", "", &m);
        lw_vec3 down = random_direction(&r);
        m.gravity = lw_v3_scale(down, g);
        lw_dynamics_report q = run(&m, how[trial%2], 5*period, 20, 1e-12, false);
        for (int i = 0; i < k.n; i++) {
            double t = fmod(k.at[i].t + 1e-12, period) - 1e-12, depth = g/(w*w)*(1 - cos(w*(t - fall))) + v/w*sin(w*(t - fall));
            double want = t < fall ? g*t*t/2 : t < fall + contact ? gap + depth : g*(period - t)*(period - t)/2;
            CHECK_NEAR(lw_v3_dot(k.at[i].tracer[0], down), want, 2e-9, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_cross(k.at[i].tracer[0], down)), 0, 1e-11, 0);
        }
        CHECK(q.energy_error < 1e-9*q.energy_scale);
        CHECK_INT(k.contact[0].losses, 5);
        CHECK_NEAR(k.contact[0].apart, 5*2*fall, 1e-8, 0);
        double depth = g/(w*w) + sqrt(g*g/(w*w*w*w) + v*v/(w*w));
        CHECK_NEAR(k.contact[0].distance_most, gap + depth, 0, 2e-5);
        CHECK_NEAR(k.contact[0].force_most, K*depth, 0, 1e-4);
    }
}

/* m x'' = m g - K x^1.5 (1 + D x') by the classical Runge-Kutta method from x = 0, x' = v until x = 0 again; returns its
 * duration, *v becomes the speed then. */
static double rebound(double m, double g, double K, double D, double *v)
{
    double x = 0, u = *v, t = 0, h = 1e-7;
    while (x >= 0) {
        double kx[5] = { 0 }, ku[5] = { 0 };
        for (int i = 0; i < 4; i++) {
            double c = i == 0 ? 0 : i == 3 ? 1 : 0.5, at = x + c*h*kx[i], w = u + c*h*ku[i];
            kx[i + 1] = w, ku[i + 1] = g - K/m*pow(fmax(at, 0), 1.5)*(1 + D*w);
        }
        double dx = h*(kx[1] + 2*kx[2] + 2*kx[3] + kx[4])/6, du = h*(ku[1] + 2*ku[2] + 2*ku[3] + ku[4])/6;
        if (x + dx < 0) {                        /* back at x = 0: the force is nothing there */
            *v = fabs(u);
            return t + x/fabs(u);
        }
        x += dx, u += du, t += h;
    }
    return t;
}

/* The highest point after one bounce. */
TEST(rebound_of_damped_laws)
{
    static const char *const law[] = { "hunt-crossley", "lankarani-nikravesh" };
    for (int i = 0; i < 4; i++) {
        char text[160];
        OWN(lw_spatial) m = { 0 };
        double e = i < 2 ? 0.9 : 0.5, g = 9.81, v = sqrt(2*g*1e-3), D = i%2 ? 0.75*(1 - e*e)/v : 1.5*(1 - e)/v, back = v;
        double t = v/g + rebound(2, g, 1e9, D, &back) + back/g;
        snprintf(text, sizeof text, "'model': '%s', 'gap': 0.001, 'stiffness': 1e9, 'exponent': 1.5, 'restitution': %g", law[i%2], e);
        read_ball(text, "", &m);
        m.gravity = lw_v3(0.6*g, 0, -0.8*g);
        run(&m, LW_FORMULATION_AUTO, t, 1, 1e-12, false);
        CHECK_NEAR(k.at[1].distance, 1e-3 - back*back/(2*g), 1e-8, 0);
    }
}

/* The laws' derivatives beside differences, in all phases. */
TEST(derivatives_of_laws)
{
    static const lw_clearance_model model[] = { LW_CLEARANCE_MLSD, LW_CLEARANCE_IMPACT, LW_CLEARANCE_HUNT_CROSSLEY,
                                                LW_CLEARANCE_LANKARANI };
    for (int i = 0; i < 8; i++) {
        lw_clearance c = { .model = model[i%4], .gap = 1e-4, .stiffness = 1e7, .exponent = i < 4 ? 1 : 1.5, .damping = 300,
                           .depth = 1e-5, .restitution = 0.7 };
        for (int phase = LW_CONTACT_APART; phase <= LW_CONTACT_FULL; phase++) {
            double x = phase == LW_CONTACT_FULL ? 3e-5 : 5e-6, u = 0.2, h = 1e-5, by_x, by_u, none[2];
            double f = lw_contact_gradient(&c, (lw_contact_phase)phase, x, u, 0.3, &by_x, &by_u);
            double up = lw_contact_gradient(&c, (lw_contact_phase)phase, x*(1 + h), u, 0.3, &none[0], &none[1]);
            double down = lw_contact_gradient(&c, (lw_contact_phase)phase, x*(1 - h), u, 0.3, &none[0], &none[1]);
            CHECK_NEAR((up - down)/(2*h*x), by_x, 1e-3, 1e-7);
            up = lw_contact_force(&c, (lw_contact_phase)phase, x, u*(1 + h), 0.3);
            down = lw_contact_force(&c, (lw_contact_phase)phase, x, u*(1 - h), 0.3);
            CHECK_NEAR((up - down)/(2*h*u), by_u, 1e-6, 1e-7);
            CHECK_NEAR(f, lw_contact_force(&c, (lw_contact_phase)phase, x, u, 0.3), 0, 0);
        }
    }
}

/* At rest the centres are apart by the gap and the deflection of the contact. */
TEST(a_ball_comes_to_rest)
{
    for (int stiff = 0; stiff < 3; stiff++) {
        char text[160];
        OWN(lw_spatial) m = { 0 };
        double K = pow(10, 5 + stiff), c = sqrt(2*2*K);
        snprintf(text, sizeof text, "'model': 'impact', 'gap': 1e-4, 'stiffness': %g, 'damping': %.17g, 'depth': 1e-6", K, c);
        read_ball(text, "", &m);
        m.gravity = lw_v3(0, 6, -8);
        run(&m, LW_FORMULATION_AUTO, 0.5, 2, 1e-10, false);
        CHECK_NEAR(k.at[k.n - 1].distance, 1e-4 + 2*10/K, 1e-10, 0);
        CHECK_NEAR(k.at[k.n - 1].force, 20, 0, 1e-5);
    }
}

typedef struct plane_run { int n; lw_clearance_sample at[16]; } plane_run;

static lw_status keep_plane(void *context, const lw_clearance_sample *s)
{
    plane_run *p = context;
    p->at[p->n++] = *s;
    return LW_OK;
}

/* The four-bar of the source in the plane by mbs/clearance/clearance.h and in space; friction: where pin and bush touch. */
static void compare_with_the_plane(double friction)
{
    static const double seconds = 0.06, radius = 0.02;
    OWN(lw_model) p = { 0 };
    char text[4096];
    size_t n = 0;
    CHECK_OK(paper_c("m", 1, 0, false, &p, &check_error));
    int joint = 2;
    p.clearance[joint].friction = friction, p.clearance[joint].friction_speed = 0.05, p.friction[joint].radius = radius;
    const lw_assembly *a = &p.linkage;
    n += (size_t)snprintf(text + n, sizeof text - n, "{'linkwright': 1, 'ground': '%s', 'gravity': [%.17g, 0, %.17g], 'links': [",
                          a->link_name[a->ground], p.gravity.x, p.gravity.y);
    for (int i = 0; i < a->n_link; i++)
        if (i == a->ground)
            n += (size_t)snprintf(text + n, sizeof text - n, "%s'%s'", i ? "," : "", a->link_name[i]);
        else
            n += (size_t)snprintf(text + n, sizeof text - n, "%s{'name': '%s', 'mass': %.17g, 'centre': [%.17g, 0, %.17g], "
                                  "'inertia': [%.17g, %.17g, %.17g]}", i ? "," : "", a->link_name[i], p.body[i].mass,
                                  p.body[i].centre.x, p.body[i].centre.y, p.body[i].inertia, p.body[i].inertia, p.body[i].inertia);
    n += (size_t)snprintf(text + n, sizeof text - n, "], 'joints': [");
    for (int j = 0; j < a->n_joint; j++) {
        const lw_clearance *c = &p.clearance[j];
        n += (size_t)snprintf(text + n, sizeof text - n, "%s{'name': '%s', 'kind': 'r', 'links': ['%s', '%s'], 'at': "
                              "[%.17g, 0, %.17g], 'axis': [0, -1, 0]", j ? "," : "", a->joint[j].name,
                              a->link_name[a->joint[j].link[0]], a->link_name[a->joint[j].link[1]], a->joint[j].at.x, a->joint[j].at.y);
        if (j == joint)
            n += (size_t)snprintf(text + n, sizeof text - n, ", 'clearance': {'model': 'impact', 'gap': %.17g, 'stiffness': "
                                  "%.17g, 'exponent': %.17g, 'damping': %.17g, 'depth': %.17g, 'friction': %g, 'friction_speed': "
                                  "0.05}, 'friction': {'coefficient': 0, 'radius': %g}", c->gap, c->stiffness, c->exponent,
                                  c->damping, c->depth, friction, radius);
        n += (size_t)snprintf(text + n, sizeof text - n, "}");
    }
    snprintf(text + n, sizeof text - n, "], 'inputs': [{'joint': '%s', 'value': %.17g, 'speed': %.17g}]}",
             a->joint[a->input[0].joint].name, a->input[0].value, 9.0);
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "four-bar", &m);
    run(&m, LW_FORMULATION_AUTO, seconds, 10, 1e-11, false);
    lw_clearance_scene *scene;
    lw_clearance_result r;
    lw_clearance_options o = lw_clearance_options_default();
    CHECK_OK(lw_clearance_make(&p, &scene, &check_error));
    plane_run plane = { 0 };
    o.time = seconds, o.settle = 0, o.tolerance = 1e-12, o.speed = 9, o.every = seconds/10, o.sink = keep_plane, o.context = &plane;
    CHECK_OK(lw_clearance_run(scene, &o, &r, &check_error));
    for (int i = 0; i < plane.n && i < k.n; i++) {
        CHECK_NEAR(k.at[i].input, plane.at[i].input, 1e-8, 0);
        CHECK_NEAR(k.at[i].distance, lw_v2_norm(plane.at[i].point[0].pin), 1e-8, 0);
    }
    CHECK_INT(plane.n, k.n);
    CHECK_INT(k.contact[0].losses, r.joint[0].losses);
    CHECK_NEAR(k.contact[0].apart/seconds, r.joint[0].apart, 1e-5, 0);   /* contact begins to a thousandth of the gap */
    CHECK_NEAR(k.contact[0].distance_most, r.joint[0].distance_most, 1e-7, 0);
    lw_clearance_free(scene);
}

TEST(as_in_the_plane) { compare_with_the_plane(0); }
TEST(friction_as_in_the_plane) { compare_with_the_plane(0.3); }

/* A ball of weight W that spins in its socket climbs until its weight acts beside the contact by the friction circle: the drag slows
 * it by R W sin(atan(mu)).  Dampers along three axes take what is left of the climb, which would whirl. */
TEST(a_ball_spins_down)
{
    lw_rng r = check_rng(0);
    for (int trial = 0; trial < 3; trial++) {
        char rest[400];
        OWN(lw_spatial) m = { 0 };
        double mu = 0.1 + 0.2*trial, radius = 0.02, weight = 20, turn[2];
        lw_vec3 down = random_direction(&r), side = random_direction(&r);
        lw_vec3 axis = lw_v3_cross(down, side), spin = lw_v3_scale(axis, 100/lw_v3_norm(axis));
        snprintf(rest, sizeof rest, ", 'angular_velocity': [%.17g, %.17g, %.17g]", spin.x, spin.y, spin.z);
        read_ball_with("'model': 'impact', 'gap': 1e-4, 'stiffness': 1e6, 'damping': 2000, 'depth': 1e-6", rest,
                       ", 'dampers': [{'links': ['ground', 'ball'], 'at': [[9, 0, 0], [0, 0, 0]], 'damping': 900}, {'links': ['ground', 'ball'], 'at': "
                       "[[0, 9, 0], [0, 0, 0]], 'damping': 900}, {'links': ['ground', 'ball'], 'at': [[0, 0, 9], [0, 0, 0]], 'damping': 900}]", &m);
        m.gravity = lw_v3_scale(down, weight/2);
        m.joint[0].friction = (lw_friction){ mu, radius, trial ? 0.01 : 0 };
        lw_dynamics_report q = run(&m, LW_FORMULATION_AUTO, 1, 4, 1e-10, false);
        for (int i = 0; i < 2; i++)
            turn[i] = lw_v3_dot(k.at[i ? 4 : 2].omega, lw_v3_scale(spin, 0.01));
        CHECK_NEAR((turn[0] - turn[1])/0.5, radius*weight*sin(atan(mu))/0.01, 0, 1e-6);
        CHECK_NEAR(lw_v3_norm(k.at[4].joint[0].force), weight, 0, 1e-6);
        CHECK_NEAR(lw_v3_norm(k.at[4].joint[0].moment), radius*weight*sin(atan(mu)), 0, 1e-6);
        CHECK(q.energy_error < 1e-6*q.energy_scale);
        CHECK_INT(q.smooth_friction, trial == 0);
    }
}

typedef struct matrix { double by_q[12][12], by_v[12][12]; } matrix;

static void add_entry(void *context, int row, int column, double by_q, double by_v)
{
    matrix *to = context;
    to->by_q[row][column] += by_q, to->by_v[row][column] += by_v;
}

/* Of contact with friction, slow and fast against its speed: by differences. */
TEST(derivatives_of_friction)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.2, 0.1, -0.3], 'inertia': [0.3, 0.2, 0.25]}, "
        "{'name': 'b', 'mass': 1, 'centre': [-0.1, 0.3, 0.2], 'inertia': [0.1, 0.15, 0.12]}], 'joints': [{'name': 'F', 'kind': 'free', 'links': "
        "['ground', 'a'], 'at': [0, 0, 0]}, {'name': 'S', 'kind': 'spherical', 'links': ['a', 'b'], 'at': [0, 0, 0], 'friction': {'coefficient': 0.4, "
        "'radius': 0.05, 'speed': 0.3}, 'clearance': {'model': 'hunt-crossley', 'gap': 0.01, 'stiffness': 3000, 'exponent': 1.5, 'restitution': 0.8}}]}";
    const double h = 1e-6;
    lw_spatial m, open;
    OWN(lw_space) s = { 0 };
    OWN(lw_space_forces) f = { 0 };
    lw_space_frame frame[3];
    lw_rng r = check_rng(0);
    read_spatial(text, "friction", &m);
    CHECK_OK(lw_spatial_open(&m, &open, &check_error));
    CHECK_OK(lw_space_make(&open, &s, &check_error));
    CHECK_OK(lw_space_forces_make(&s, &f, &check_error));
    f.contact[0].phase = LW_CONTACT_FULL, f.contact[0].struck = 0.5;
    for (int trial = 0; trial < 6; trial++) {
        double q[14], at[14], by[12], v[12], force[2][12], power, work = 0, most = 0, off = 0;
        matrix d = { { { 0 } }, { { 0 } } };
        for (int i = 0; i < 12; i++)
            v[i] = (trial < 3 ? 1 : 1e-4)*lw_rng_range(&r, -1, 1), by[i] = lw_rng_range(&r, -0.5, 0.5);
        memcpy(q, s.start, sizeof q);
        lw_space_move(&s, q, by);
        lw_space_place(&s, q, frame);                    /* the ball beyond its gap */
        lw_vec3 apart = lw_v3_sub(lw_space_point_at(frame, f.contact[0].end[1]), lw_space_point_at(frame, f.contact[0].end[0]));
        apart = lw_v3_sub(apart, lw_v3_scale(random_direction(&r), 0.013));
        q[7] -= apart.x/s.unit, q[8] -= apart.y/s.unit, q[9] -= apart.z/s.unit;
        lw_space_place(&s, q, frame);
        lw_space_forces_apply(&f, 0, frame, v, force[0], &power, &(lw_space_sink){ &d, add_entry, NULL });
        for (int side = 0; side < 2; side++) {           /* of the force with friction, less that without: its power */
            f.contact[0].friction.coefficient = side ? 0.4 : 0;
            double own;
            lw_space_forces_apply(&f, 0, frame, v, force[side], &own, NULL);
            for (int i = 0; i < 12; i++)
                work += (side ? 1 : -1)*force[side][i]*v[i];
            work -= (side ? 1 : -1)*own;
        }
        CHECK_NEAR(work, 0, 1e-12, 0);
        for (int i = 0; i < 24; i++) {
            for (int side = 0; side < 2; side++) {
                double w[12], step[12] = { 0 };
                memcpy(at, q, sizeof at), memcpy(w, v, sizeof w);
                *(i < 12 ? &step[i] : &w[i - 12]) += side ? h : -h;
                lw_space_move(&s, at, step);
                lw_space_place(&s, at, frame);
                lw_space_forces_apply(&f, 0, frame, w, force[side], NULL, NULL);
            }
            for (int a = 0; a < 12; a++) {
                double want = i < 12 ? d.by_q[a][i] : d.by_v[a][i - 12];
                most = fmax(most, fabs(want));
                off = fmax(off, fabs((force[1][a] - force[0][a])/(2*h) - want));
            }
        }
        CHECK_NEAR(off, 0, 1e-7*most, 0);
    }
    lw_spatial_open_free(&open);
    lw_spatial_free(&m);
}

/* A spring presses the ball down with 100 N; a load lifts it more and more.  Contact holds until the load exceeds the spring. */
TEST(pretension)
{
    OWN(lw_spatial) m = { 0 };
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'ball', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [0.01, 0.01, 0.01]}], "
        "'joints': [{'name': 'S', 'kind': 'spherical', 'links': ['ground', 'ball'], 'at': [0, 0, 0], 'clearance': {'model': 'impact', 'gap': 5e-5, "
        "'stiffness': 1e7, 'damping': 2e4, 'depth': 1e-6}}], 'springs': [{'name': 'P', 'links': ['ground', 'ball'], 'at': [[0, 0, -1], [0, 0, 0]], "
        "'stiffness': 100, 'free': 0}], 'forces': [{'link': 'ball', 'at': [0, 0, 0], 'fz': '200*t'}]}";
    read_spatial(text, "pretension", &m);
    run(&m, LW_FORMULATION_AUTO, 1, 100, 1e-9, false);
    for (int i = 2; i < k.n; i++)
        if (k.at[i].t < 0.495)
            CHECK_NEAR(k.at[i].force, 100 - 200*k.at[i].t, 0.05, 0);
        else if (k.at[i].t > 0.52)               /* lifted to the other side of its socket */
            CHECK_NEAR(k.at[i].force, 200*k.at[i].t - 100, 0.2, 0);
}

/* The error of the tool grows like the gap, and contact is kept longer the smaller it is.  The first 20 ms. */
TEST(a_delta_with_clearance)
{
    OWN(lw_spatial) m = { 0 };
    double off[2], apart[2], worst = 0;
    lw_vec3 ideal[8];
    load_spatial("delta-clearance", &m);
    run(&m, LW_FORMULATION_AUTO, 0.02, 4, 1e-9, true);
    for (int i = 0; i < k.n; i++)
        ideal[i] = k.at[i].tracer[0];
    for (int pass = 0; pass < 2; pass++) {
        for (int j = 0; j < m.n_joint; j++)
            if (lw_spatial_has_clearance(&m.joint[j])) {
                m.joint[j].clearance.gap = pass ? 1e-5 : 1e-4;
                m.joint[j].clearance.depth = m.joint[j].clearance.gap/5;
                m.joint[j].clearance.stiffness = 1e8;
            }
        lw_dynamics_report q = run(&m, LW_FORMULATION_AUTO, 0.02, 4, 1e-7, false);
        CHECK_INT(q.formulation, LW_FORMULATION_RADAU);
        CHECK(q.energy_error < 1e-3*q.energy_scale);
        off[pass] = apart[pass] = 0;
        for (int i = 0; i < k.n; i++)
            off[pass] = fmax(off[pass], lw_v3_norm(lw_v3_sub(k.at[i].tracer[0], ideal[i])));
        for (int i = 0; i < 12; i++) {
            apart[pass] += k.contact[i].apart/12;
            worst = fmax(worst, k.contact[i].distance_most/m.joint[k.contact[i].joint].clearance.gap);
        }
    }
    CHECK_NEAR(log10(off[0]/off[1]), 1, 0.1, 0);
    CHECK(apart[1] < 0.6*apart[0]);
    CHECK(worst < 1.5);
}

TEST(refused)
{
    static const struct { const char *joint, *why; } bad[] = {
        { "'kind': 'prismatic', 'axis': [0, 0, 1], 'clearance': {'model': 'impact', 'gap': 1e-4, 'stiffness': 1e6}",
          "only spherical and revolute joints" },
        { "'kind': 'spherical', 'clearance': {'model': 'link', 'gap': 1e-4}", "known in the plane only" },
        { "'kind': 'spherical', 'clearance': {'model': 'impact', 'gap': 1e-4}", "stiffness" },
        { "'kind': 'spherical', 'clearance': {'model': 'impact', 'gap': 0, 'stiffness': 1e6}", "greater than 0" },
        { "'kind': 'spherical', 'clearance': {'model': 'impact', 'gap': 1e-4, 'stiffness': 1e6, 'friction': 0.1}",
          "give the joint \"friction\"" },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        char text[1024];
        lw_spatial m;
        int n = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], "
                         "'joints': [{'name': 'J', 'links': ['ground', 'A'], 'at': [0, 0, 0], %s}]}", bad[i].joint);
        CHECK_FAILS(lw_spatial_read(json_quotes(text), (size_t)n, "bad", &m, &check_error), LW_E_NOTATION, bad[i].why);
    }
}
