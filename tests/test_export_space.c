/* Files of spatial models for other programs: the model as MuJoCo runs it against our own run; the markers of an ADAMS
 * dataset, read by a parser of this test. */
#include "catalogues/exchange/format.h"

#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"
#include "tests/mujoco.h"
#include "tests/spatial_models.h"

static lw_bytes export(const lw_spatial *m, const char *format)
{
    lw_bytes b = { 0 };
    lw_error e = { 0 };
    lw_status s = lw_format_write_space(lw_format_find(format), m, &b, &e);
    CHECK_TEXT(e.text, "");
    CHECK_INT(s, LW_OK);
    return b;
}

#if __has_include(<mujoco/mujoco.h>)

/* Every kind of joint closes a loop once; and springs, dampers, forces and motors. */
static const char *const closing[] = {
    "'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.3, 0, 0], 'inertia': [0.1, 0.2, 0.2]}], 'joints': [{'name': 'E', 'kind': 'planar', "
    "'links': ['a', 'ground'], 'at': [0, 0, 0], 'axis': [0, 0, 1]},{'name': 'C', 'kind': 'cylindrical', 'links': ['ground', 'a'], 'at': [0, 0.5, 0], "
    "'axis': [1, 0, 0]}], 'gravity': [1, -2, -9.81],'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0.5, 0]}]",
    "'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.3, 0, 0], 'inertia': [0.1, 0.2, 0.2]}], 'joints': [{'name': 'C', 'kind': 'cylindrical', "
    "'links': ['ground', 'a'], 'at': [0, 0.5, 0], 'axis': [1, 0, 0]},{'name': 'E', 'kind': 'planar', 'links': ['a', 'ground'], 'at': [0, 0, 0], 'axis': "
    "[0, 0, 1]}], 'gravity': [1, -2, -9.81],'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0.5, 0]}],'springs': [{'name': 'k', 'links': ['ground', "
    "'a'], 'at': [[2, 1, 0.5], [1, 0, 0]], 'stiffness': 30, 'damping': 1, 'free': 0.9}]",
    "'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.3, 0.2, 0], 'inertia': [0.1, 0.2, 0.2]}], 'joints': [{'name': 'C', 'kind': 'cylindrical', "
    "'links': ['a', 'ground'], 'at': [0, 0.5, 0], 'axis': [1, 0, 0]},{'name': 'H', 'kind': 'screw', 'links': ['ground', 'a'], 'at': [0, 0.5, 0], 'axis': "
    "[1, 0, 0], 'lead': 0.3}],'gravity': [5, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0, 0]}], 'forces': [{'name': 'wind', 'link': "
    "'a', 'along': [[0, 0.5, 0], [0.6, 0.7, 0.1]], 'fx': [1, 4], 'fz': 2}]",
    "'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.3, 0.2, 0], 'inertia': [0.1, 0.2, 0.2]},{'name': 'b', 'mass': 1, 'centre': [0.3, 0.9, 0], "
    "'inertia': [0.1, 0.1, 0.1]},{'name': 'c', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [0.1, 0.1, 0.1]},{'name': 'd', 'mass': 1, 'centre': [0, 0, 1], "
    "'inertia': [0.1, 0.1, 0.1], 'velocity': [0, 0, 2]}], 'joints': [{'name': 'H', 'kind': 'screw', 'links': ['a', 'ground'], 'at': [0, 0.5, 0], 'axis': "
    "[1, 0, 0], 'lead': 0.3},{'name': 'W', 'kind': 'fixed', 'links': ['a', 'b'], 'at': [0, 0.5, 0]},{'name': 'V', 'kind': 'fixed', 'links': ['b', 'a'], "
    "'at': [0, 0.7, 0]},{'name': 'T', 'kind': 'prismatic', 'links': ['ground', 'c'], 'at': [0, 0, 0], 'axis': [1, 0, 0]},{'name': 'F', 'kind': 'free', "
    "'links': ['ground', 'd'], 'at': [0, 0, 1]},{'name': 'U', 'kind': 'prismatic', 'links': ['c', 'd'], 'at': [0.1, 0, 1], 'axis': [0, 0, 1]}], "
    "'gravity': [5, 0, -9.81],'forces': [{'name': 'f', 'link': 'c', 'at': [0, 0, 0.1], 'fx': 3, 'tz': 1}], 'tracers': [{'name': 'P', 'link': 'b', 'at': "
    "[1, 0, 0]},{'name': 'Q', 'link': 'd', 'at': [0, 0, 1]}]",
    "'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [0.1, 0.2, 0.2]},{'name': 'b', 'mass': 2, 'centre': [0, 0, 0], "
    "'inertia': [0.1, 0.2, 0.2]}], 'joints': [{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'a'], 'at': [-1, 0, 0], 'axis': [1, 0, 0], 'stop': "
    "{'least': -1000}},{'name': 'B', 'kind': 'revolute', 'links': ['ground', 'b'], 'at': [0.8, 0.6, 0], 'axis': [0.8, 0.6, 0]},{'name': 'K', 'kind': "
    "'universal', 'links': ['a', 'b'], 'at': [0, 0, 0], 'axis': [0, 0, 1], 'second_axis': [-0.6, 0.8, 0]}],'input': {'joint': 'A', 'speed': 3}, 'motors': "
    "[{'name': 'm', 'joint': 'A', 'stall': 0.4, 'free_speed': 20}],'dampers': [{'joint': 'A', 'damping': 0.05}], 'tracers': [{'name': 'P', 'link': 'b', "
    "'at': [0, 0, 1]},{'name': 'Q', 'link': 'a', 'at': [0, 0, 1]}]",
    /* a driven hinge in a loop without another one: a shaft with two universal joints */
    "'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [-0.5, 0, 0], 'inertia': [0.1, 0.2, 0.2]},{'name': 'b', 'mass': 1, 'centre': [0.4, 0.3, 0], "
    "'inertia': [0.1, 0.1, 0.1]},{'name': 'c', 'mass': 2, 'centre': [1.8, 0.6, 0], 'inertia': [0.1, 0.2, 0.2]}], 'joints': [{'name': 'A', 'kind': 'revolute', "
    "'links': ['ground', 'a'], 'at': [-1, 0, 0], 'axis': [1, 0, 0]},{'name': 'U', 'kind': 'universal', 'links': ['a', 'b'], 'at': [0, 0, 0], 'axis': [0, 1, 0], "
    "'second_axis': [0, 0, 1]},{'name': 'V', 'kind': 'universal', 'links': ['b', 'c'], 'at': [0.8, 0.6, 0], 'axis': [0, 0, 1], 'second_axis': [0, 1, 0]},{'name': "
    "'C', 'kind': 'cylindrical', 'links': ['ground', 'c'], 'at': [2, 0.6, 0], 'axis': [1, 0, 0]}], 'input': {'joint': 'A', 'speed': 3}, 'motors': [{'name': 'm', "
    "'joint': 'A', 'stall': 0.4, 'free_speed': 20}], 'tracers': [{'name': 'P', 'link': 'b', 'at': [0, 0, 1]},{'name': 'Q', 'link': 'c', 'at': [2, 0.6, 1]}]",
};

static void read_closing(size_t i, lw_spatial *m)
{
    char text[4000];
    json_format(text, sizeof text, "{'linkwright': 1, %s}", closing[i]);
    read_spatial(text, "closing", m);
}

#define SAMPLES 2000

static struct {
    int             n;
    const lw_space *s;
    lw_dynamics    *d;
    double          control[SAMPLES + 1][8];
    lw_vec3         tracer[SAMPLES + 1][8];
} ours;

/* What the drives measure, and the tracers. */
static lw_status keep(void *context, const lw_moment *moment)
{
    lw_space_moment o;
    lw_error e;
    (void)context;
    lw_status st = lw_dynamics_space_moment(ours.d, moment, &o, &e);
    const lw_spatial *m = ours.s->model;
    for (int i = 0; i < m->n_input && i < 8 && !m->n_drive; i++)
        ours.control[ours.n][i] = o.input[i];
    for (int i = 0; i < m->n_drive && i < 8; i++) {
        double rate;
        lw_space_measured(ours.s, o.frame, m->drive[i], ours.n ? ours.control[ours.n - 1][i] : 0, o.v, &ours.control[ours.n][i], &rate);
    }
    for (int t = 0; t < m->n_tracer && t < 8; t++)
        ours.tracer[ours.n][t] = lw_space_point_at(o.frame, ours.s->tracer[t]);
    ours.n++;
    return st;
}

/* Both from the posture of the file for `to` seconds: the greatest distance of a tracer over the size. */
static double apart(lw_spatial *m, double to)
{
    lw_dynamics_report report;
    lw_dynamics_options o = lw_dynamics_options_default();
    double worst = 0, moved = 0;
    bool driven = m->n_input > 0 && m->input[0].motion;
    o.to = to;
    o.intervals = SAMPLES;
    o.relative = o.absolute = 1e-9;
    ours.n = 0;
    CHECK_SILENT(lw_dynamics_make_spatial(m, &o, &ours.d, &check_error));
    ours.s = lw_dynamics_space(ours.d);
    CHECK_SILENT(lw_dynamics_analyse(ours.d, keep, NULL, &report, NULL, &check_error));
    OWN(lw_bytes) b = export(m, "mjcf");
    mjModel *model = mujoco_load("xml", b.data, b.size);
    CHECK(model != NULL && ours.n == SAMPLES + 1);
    if (!model)
        return INFINITY;
    mjData *d = mj.make(model);
    if (model->nkey > 0)
        mj.reset(model, d, 0);
    int steps = (int)(to/model->opt.timestep + 0.5);
    for (int k = 1; k <= steps; k++) {
        double at = (double)k*SAMPLES/steps;
        int before = at < SAMPLES ? (int)at : SAMPLES - 1;
        for (int a = 0; driven && a < model->nu; a++) {
            const double *from = ours.control[before], *end = ours.control[before + 1];
            d->ctrl[a] = from[a] + (at - before)*(end[a] - from[a]);
        }
        mj.step(model, d);
        if (k % (steps/20) != 0)
            continue;
        mj.position(model, d);
        int row = (int)(at + 0.5);
        for (int t = 0; t < m->n_tracer; t++) {
            const double *p = d->site_xpos + 3*mj.find(model, mjOBJ_SITE, m->tracer[t].name);
            double off = lw_v3_norm(lw_v3_sub(lw_v3(p[0], p[1], p[2]), ours.tracer[row][t]));
            worst = off > worst || isnan(off) ? off : worst;
            moved = fmax(moved, lw_v3_norm(lw_v3_sub(ours.tracer[row][t], ours.tracer[0][t])));
        }
    }
    CHECK(moved > 0.02*lw_spatial_size(m));
    mj.free_data(d);
    mj.free_model(model);
    lw_dynamics_free(ours.d);
    return worst/lw_spatial_size(m);
}

TEST(mujoco_runs_the_examples_alike)
{
    static const struct { const char *name; double to; const char *motion[3]; } rows[] = {
        { "top", 1, { NULL } }, { "bricard", 1, { NULL } }, { "governor", 1, { NULL } },
            { "slider-crank", 1, { NULL } },
        { "arm", 1, { NULL } }, { "stewart", 1, { NULL } }, { "differential", 1, { NULL } },
        { "corexy", 1, { "0.1*sin(3*t)", "0.05*(1 - cos(3*t))" } },
        { "delta", 1, { "0.1*(1 - cos(pi*t))", "0.1*(1 - cos(pi*t))*sin(pi*t)", "-0.65 + 0.05*(1 - cos(pi*t))" } }
    };
    for (size_t i = 0; have_mujoco() && i < sizeof rows/sizeof *rows; i++) {
        OWN(lw_spatial) m = { 0 };
        load_spatial(rows[i].name, &m);
        for (int j = 0; j < m.n_joint; j++)
            m.joint[j].stop = (lw_joint_stop){ .has_least = false };       /* those of the arm give way */
        for (int k = 0; k < 3 && rows[i].motion[k]; k++)
            CHECK_OK(lw_spatial_set_motion(&m, k, rows[i].motion[k], &check_error));
        CHECK_NEAR(apart(&m, rows[i].to), 0, 1e-3, 0);
    }
}

TEST(every_joint_closes_a_loop_in_mujoco)
{
    for (size_t i = 0; have_mujoco() && i < sizeof closing/sizeof *closing; i++) {
        OWN(lw_spatial) m = { 0 };
        read_closing(i, &m);
        CHECK_NEAR(apart(&m, 1), 0, 1e-3, 0);
    }
}
#endif

/* ---- ADAMS ---------------------------------------------------------------------------------------------- */

typedef struct marker { int part; lw_vec3 at; lw_mat3 turn; } marker;
static marker found[20000];

static lw_mat3 about(char axis, double angle)
{
    lw_quaternion q = lw_quaternion_of_vector(axis == 'z' ? lw_v3(0, 0, angle) : lw_v3(angle, 0, 0));
    return lw_quaternion_matrix(q);
}

static void read_markers(const char *text)
{
    memset(found, 0, sizeof found);
    for (const char *c = text; (c = strstr(c, "\nMARKER/")); c++) {
        int id, part;
        double x, y, z, a = 0, b = 0, g = 0;
        CHECK_INT(sscanf(c, "\nMARKER/%d, PART = %d, QP = %lf, %lf, %lf\n, REULER = %lf, %lf, %lf", &id, &part, &x, &y,
                         &z, &a, &b, &g) >= 5, 1);
        CHECK(id > 0 && id < 20000 && found[id].part == 0);
        lw_mat3 one = about('z', a), two = about('x', b), three = about('z', g), both = lw_m3_times(&two, &three);
        found[id % 20000] = (marker){ part, lw_v3(x, y, z), lw_m3_times(&one, &both) };
    }
}

/* The statement of that kind and number; "" after a failure. */
static const char *statement(const char *text, const char *kind, int number)
{
    char head[40];
    snprintf(head, sizeof head, "\n%s/%02d", kind, number);
    const char *at = strstr(text, head);
    CHECK(at != NULL);
    return at ? at : "";
}

static int number_after(const char *text, const char *key)
{
    const char *at = strstr(text, key);
    int n = 0;
    CHECK(at && sscanf(at + strlen(key), "%d", &n) == 1);
    return n > 0 && n < 20000 ? n : 0;
}

/* Markers of joints lie on their links at the joint, with z along its axis; masses have their tensors again. */
TEST(datasets_of_adams_say_the_same)
{
    static const char *const names[] = { "top", "bricard", "governor", "slider-crank", "stewart", "delta", "bennett" };
    for (size_t i = 0; i < sizeof names/sizeof *names; i++) {
        OWN(lw_spatial) m = { 0 };
        load_spatial(names[i], &m);
        if (strcmp(names[i], "delta") == 0)
            CHECK_INT(lw_spatial_set_motion(&m, 0, "-0.2 + 80*t^2", NULL), LW_OK);
        OWN(lw_bytes) b = export(&m, "adams");
        read_markers(b.data);
        for (int j = 0; j < m.n_joint; j++) {
            const lw_spatial_joint *p = &m.joint[j];
            const char *text = statement(b.data, "JOINT", j + 1);
            int id[2] = { number_after(text, ", J = "), number_after(text, ", I = ") };
            for (int side = 0; side < 2; side++) {
                const marker *k = &found[id[side]];
                lw_vec3 axis = p->kind == LW_SPATIAL_UNIVERSAL && side ? p->second : p->axis;
                CHECK_INT(k->part, p->link[side] + 1);
                CHECK_NEAR(lw_v3_norm(lw_v3_sub(k->at, p->at)), 0, 1e-13, 0);
                if (lw_v3_norm(axis) > 0)
                    CHECK_NEAR(lw_v3_norm(lw_v3_sub(lw_m3_column(&k->turn, 2), axis)), 0, 1e-12, 0);
            }
        }
        for (int l = 0; l < m.n_link; l++) {
            const lw_spatial_body *body = &m.body[l];
            if (body->mass == 0)
                continue;
            const char *text = statement(b.data, "PART", l + 1), *at = strstr(text, "IP = ");
            const marker *k = &found[number_after(text, ", CM = ")];
            double v[3];
            CHECK(at && sscanf(at, "IP = %lf, %lf, %lf", &v[0], &v[1], &v[2]) == 3);
            lw_vec3 x = lw_m3_column(&k->turn, 0), y = lw_m3_column(&k->turn, 1), z = lw_m3_column(&k->turn, 2);
            double size = fabs(body->inertia[0]) + fabs(body->inertia[1]) + fabs(body->inertia[2]) + 1e-30;
            CHECK_NEAR((v[0]*x.x*x.x + v[1]*y.x*y.x + v[2]*z.x*z.x - body->inertia[0])/size, 0, 1e-12, 0);
            CHECK_NEAR((v[0]*x.x*x.y + v[1]*y.x*y.y + v[2]*z.x*z.y - body->inertia[3])/size, 0, 1e-12, 0);
            CHECK_NEAR((v[0]*x.y*x.z + v[1]*y.y*y.z + v[2]*z.y*z.z - body->inertia[5])/size, 0, 1e-12, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(k->at, body->centre)), 0, 1e-13, 0);
        }
        if (strcmp(names[i], "delta") == 0)
            CHECK_HAS(b.data, ", X\n, FUNCTION = -0.2 + 80*TIME**2 + 0\n");
        if (strcmp(names[i], "top") == 0)
            CHECK_HAS(b.data, "WX = 29.2287422925743, WY = 0, WZ = 52.4068100720631\n");
    }
}

/* An elastic bar by the statements of its dataset alone: what the manual of ADAMS says of BEAM, element after element from the
 * root to the tip.  The tip moves as closed forms say under a force along each axis of the section and under a torque. */
TEST(beams_of_adams_bend_alike)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'box', 'width': 0.03, 'height': "
        "0.05, 'wall': 0.002}, 'material': 'steel', 'axis': [[0, 0, 0], [0.3, 0.6, 0.6]], 'height': [0.2, -0.7, 0.6], 'segments': 5, 'damping': 3e-5}}, "
        "{'name': 'load', 'mass': 2, 'centre': [0.3, 0.6, 0.6], 'inertia': [0.01, 0.01, 0.01]}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': "
        "['ground', 'bar'], 'at': [0, 0, 0]}, {'name': 'W', 'kind': 'fixed', 'links': ['bar', 'load'], 'at': [0.3, 0.6, 0.6]}]}";
    const double length = 0.9;
    const lw_vec3 tip = lw_v3(0.3, 0.6, 0.6);
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "bar", &m);
    const lw_section *q = &m.elastic[1].section;
    const lw_material *p = &m.elastic[1].material;
    OWN(lw_bytes) b = export(&m, "adams");
    read_markers(b.data);
    int part = found[number_after(statement(b.data, "JOINT", 1), ", I = ")].part, n = 0;
    double moved[4] = { 0 }, mass = 0;
    for (const char *c = b.data; (c = strstr(c, "\nBEAM/")); c++, n++) {
        int id, to, from;
        double h, area, ixx, iyy, izz, asy, asz, e, g, ratio;
        CHECK_INT(sscanf(c, "\nBEAM/%d, I = %d, J = %d, LENGTH = %lf\n, AREA = %lf, IXX = %lf, IYY = %lf, IZZ = %lf\n, ASY = %lf, ASZ = %lf, "
                         "EMODULUS = %lf, GMODULUS = %lf, CRATIO = %lf", &id, &to, &from, &h, &area, &ixx, &iyy, &izz, &asy, &asz, &e, &g,
                         &ratio), 13);
        const marker *root = &found[from], *end = &found[to];
        lw_vec3 x = lw_m3_column(&root->turn, 0), y = lw_m3_column(&root->turn, 1), z = lw_m3_column(&root->turn, 2);
        CHECK_INT(root->part, part);                     /* the chain has no gap */
        part = end->part;
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(lw_v3_add(root->at, lw_v3_scale(x, h)), end->at)), 0, 1e-13, 0);
        CHECK_NEAR(ratio, 3e-5, 1e-12, 0);
        double arm = lw_v3_dot(lw_v3_sub(tip, end->at), x);
        for (int way = 0; way < 2; way++) {              /* a force across, of 1 N: its force and moment bend this element */
            double i = way ? iyy : izz, py = 12*e*i*(way ? asz : asy)/(g*area*h*h), k = e*i/(h*h*h*(1 + py));
            double k22 = 12*k, k26 = -6*k*h, k66 = (4 + py)*k*h*h, det = k22*k66 - k26*k26;
            double shift = (k66 - k26*arm)/det, turn = (k22*arm - k26)/det;
            moved[1 + way] += shift + turn*arm;
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(lw_v3_cross(z, x), y)), 0, 1e-12, 0);
        }
        moved[0] += h/(e*area);
        moved[3] += h/(g*ixx);
    }
    CHECK_INT(n, 5);
    CHECK_INT(found[number_after(statement(b.data, "JOINT", 2), ", J = ")].part, part);
    CHECK_NEAR(moved[0]*p->e*q->area/length, 1, 1e-12, 0);
    CHECK_NEAR(moved[1]/(length*length*length/(3*p->e*q->iz) + q->zeta_y*length/(p->g*q->area)), 1, 1e-12, 0);
    CHECK_NEAR(moved[2]/(length*length*length/(3*p->e*q->iy) + q->zeta_z*length/(p->g*q->area)), 1, 1e-12, 0);
    CHECK_NEAR(moved[3]*p->g*q->it/length, 1, 1e-12, 0);
    for (const char *c = b.data; (c = strstr(c, "MASS = ")); c++)
        mass += c[7] == 'K' ? 0 : strtod(c + 7, NULL);
    CHECK_NEAR(mass, 2 + p->density*q->area*length, 1e-12, 0);
    lw_vec3 height = lw_m3_column(&found[number_after(strstr(b.data, "\nBEAM/"), ", J = ")].turn, 1);
    CHECK(lw_v3_dot(height, lw_v3(0.2, -0.7, 0.6)) > 0.9);
}

/* ---- refusals ------------------------------------------------------------------------------------------- */

TEST(what_has_no_form_is_named)
{
    static const struct { const char *model, *format, *says; } rows[] = {
        { "arm", "mjcf", "stop that rebounds" }, { "arm", "adams", "has a stop" },
            { "delta-elastic", "mjcf", "is elastic" }, { "superelement", "adams", "is a superelement" }, { "superelement", "acf", "is a superelement" },
        { "corexy", "adams", "has a stop" },
        { "top", "urdf", "planar linkages only" },
        { "delta", "adams", "MAX" }, { "differential", "adams", "JOINTS = 02, 04\n, TYPE = R:R\n, SCALES = 23, 17" }     /* known to ADAMS */
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        OWN(lw_spatial) m = { 0 };
        lw_error e = { 0 };
        OWN(lw_bytes) b = { 0 };
        load_spatial(rows[i].model, &m);
        lw_status s = lw_format_write_space(lw_format_find(rows[i].format), &m, &b, &e);
        if (i + 2 >= sizeof rows/sizeof *rows)
            CHECK(s == LW_OK && strstr(b.data, rows[i].says));
        else {
            CHECK_INT(s, LW_E_KIND);
            CHECK_HAS(e.text, rows[i].says);
            CHECK(b.data == NULL);
        }
    }
}

/* A chain, whose bodies stand inside each other; its joints from the last to the first. */
static size_t bytes_of_chain(int n)
{
    size_t room = 200 + 200*(size_t)n, used = 0;
    FREED char *text = malloc(room);
    used += (size_t)snprintf(text, room, "{'linkwright': 1, 'joints': [");
    for (int i = n; i > 0; i--)
        used += (size_t)snprintf(text + used, room - used, "{'name': 'J%04d', 'links': ['b%04d', 'b%04d'], 'at': [%d, 0, 0], "
                                 "'axis': [0, 0, 1]}%s", i, i - 1, i, 1000 + i, i > 1 ? ", " : "], 'ground': 'b0000'}");
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "chain", &m);
    OWN(lw_bytes) b = export(&m, "mjcf");
    size_t size = b.size, bodies = 0;
    for (const char *at = b.data; (at = strstr(at, "<body ")); at++)
        bodies++;
    CHECK_INT((int)bodies, n);
    return size;
}

TEST(files_grow_as_the_model_does)
{
    CHECK((double)bytes_of_chain(2400) < 8.5*(double)bytes_of_chain(300));
}
