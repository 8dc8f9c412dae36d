/* MJCF: the text, and the model run by MuJoCo itself.  Without libmujoco (Debian: libmujoco-dev) the second half
 * is skipped with a message. */
#include "catalogues/exchange/export.h"

#include "mbs/constraints/newton.h"
#include "tests/dynamics_run.h"
#include "tests/example_linkage.h"
#include "tests/large_models.h"
#include "tests/loaded_models.h"
#include "tests/mujoco.h"

static lw_bytes mjcf(const lw_linkage *k)
{
    lw_bytes b = { 0 };
    lw_error e = { 0 };
    lw_status s = lw_export_mjcf(LW_VIEW(k), NULL, &b, &e);
    if (s != LW_OK)
        fprintf(stderr, "    %s: %s\n", k->name, e.text);
    CHECK_INT(s, LW_OK);
    return b;
}

/* ---- text ------------------------------------------------------------------------------------------ */

static void a_four_bar_closes_by_one_connect(void)
{
    lw_linkage k = example("hoeken");
    OWN(lw_bytes) b = mjcf(&k);
    CHECK_HAS(b.data, "<mujoco model=\"Hoeken straight-line linkage\">");
    CHECK_HAS(b.data, "<body name=\"crank\" pos=\"0 0 0\">");
    CHECK_HAS(b.data, "<body name=\"coupler\" pos=\"0 0.02 0\">");
    CHECK_HAS(b.data, "<joint type=\"hinge\" name=\"O\" axis=\"0 0 1\" ref=\"1.5707963267949\" armature=");
    CHECK_HAS(b.data, "<site name=\"P\" pos=\"0.08 0.06 0\"");
    CHECK_HAS(b.data, "<connect body1=\"rocker\" anchor=\"0 -0.05 0\"/>");
    CHECK_HAS(b.data, "<framepos objtype=\"site\" objname=\"P\"/>");
    CHECK(strstr(strstr(b.data, "<connect") + 1, "<connect") == NULL);
}

static void names_are_escaped(void)
{
    lw_linkage k = example("hoeken");
    snprintf(k.link_name[1], LW_NAME_SIZE, "<&\">");
    snprintf(k.link_name[2], LW_NAME_SIZE, "world");
    OWN(lw_bytes) b = mjcf(&k);
    CHECK_HAS(b.data, "<body name=\"&lt;&amp;&quot;&gt;\"");
    CHECK_HAS(b.data, "<body name=\"world link\"");
}

/* An SDF has a joint for each joint, with the loops; a slot is two. */
static void sdf_has_all_joints(void)
{
    static const struct { const char *name; int links, joints; } rows[] = {
        { "hoeken", 3, 4 }, { "slider-crank", 3, 4 }, { "jansen", 7, 10 }, { "pendulum", 1, 1 }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_linkage k = example(rows[i].name);
        OWN(lw_bytes) b = { 0 };
        int links = 0, joints = 0;
        CHECK_OK(lw_export_sdf(LW_VIEW(&k), NULL, &b, &check_error));
        for (const char *c = b.data; (c = strstr(c, "<link name=")); c++)
            links++;
        for (const char *c = b.data; (c = strstr(c, "<joint name=")); c++)
            joints++;
        CHECK_INT(links, rows[i].links);
        CHECK_INT(joints, rows[i].joints);
        CHECK((strstr(b.data, "close a loop") != NULL) == (k.n_joint >= k.n_link));
    }
}

/* A cam has no carrier. */
static void refusals(void)
{
    lw_linkage k;
    lw_bytes b = { 0 };
    lw_error e = { 0 };
    blank_linkage(&k, 3);
    add_pin(&k, 0, 1, lw_v2(0, 0));
    add_slide(&k, 0, 2, lw_v2(1, 1), 1);
    k.joint[1].kind = LW_JOINT_SLOT;
    add_gear(&k, 1, 2, lw_v2(0.5, 0.5), 2);
    add_input(&k, 0, 0);
    CHECK_INT(lw_export_mjcf(LW_VIEW(&k), NULL, &b, &e), LW_E_KIND);
    CHECK(e.text[0] != 0);
    CHECK(b.data == NULL);
}

/* The slide of the trammel has 100 mm to each side of the middle; the crank of the inversor, without a drive, turns by +-2 acos((5 - 3)/3). */
static void limits_are_told(void)
{
    static const char *const file[] = { "examples/trammel.json", "examples/dynamics/inversor.json" };
    for (int i = 0; i < 2; i++) {
        static drun d;
        lw_bytes b = { 0 };
        drun_read(&d, file[i]);
        strcpy(d.model.linkage.joint[0].name, "A--B");           /* two hyphens would end a comment */
        lw_export_options o = { .model = &d.model, .clearance = -1 };
        CHECK_SILENT(lw_export_mjcf(&d.model.linkage, &o, &b, &check_error));
        double limit[2] = { 0, 0 };
        const char *at = strstr(b.data, i ? "limits of the linkage at " : "ctrlrange=\"");
        CHECK(at != NULL);
        if (at)
            CHECK_INT(sscanf(at, i ? "limits of the linkage at %lf and %lf" : "ctrlrange=\"%lf %lf", &limit[0], &limit[1]), 2);
        for (int k = 0; k < 2; k++)
            CHECK_NEAR(fabs(limit[k]), i ? 2*acos(2.0/3) : 0.099, i ? 2e-4 : 7e-4, 0);
        for (const char *c = b.data; (c = strstr(c, "<!--")) != NULL; c += 4)
            CHECK(strstr(c + 4, "--") == strstr(c + 4, "-->"));
        lw_bytes_free(&b);
    }
}

/* ---- by MuJoCo ------------------------------------------------------------------------------------- */

#if __has_include(<mujoco/mujoco.h>)
#define DOF_MAX 64

typedef struct run { const mjModel *m; mjData *d; bool held[DOF_MAX]; } run;

/* x of (A + tiny) x = b for a symmetric A (n x n), which is overwritten: Cholesky. */
static bool solve(double *a, double *x, int n)
{
    for (int i = 0; i < n; i++) {
        for (int l = 0; l < i; l++) {
            for (int c = 0; c < l; c++)
                a[i*n + l] -= a[i*n + c]*a[l*n + c];
            a[i*n + l] /= a[l*n + l];
            a[i*n + i] -= a[i*n + l]*a[i*n + l];
        }
        if (!(a[i*n + i] > 0))
            return false;
        a[i*n + i] = sqrt(a[i*n + i]);
        for (int c = 0; c < i; c++)
            x[i] -= a[i*n + c]*x[c];
        x[i] /= a[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int c = i + 1; c < n; c++)
            x[i] -= a[c*n + i]*x[c];
        x[i] /= a[i*n + i];
    }
    return true;
}

/* Newton on MuJoCo's own equality constraints, the inputs held; the largest violation left. */
static double close_loops(run *r)
{
    int n = r->m->nv;
    double worst = 0;
    for (int step = 0; step < 30; step++) {
        static double a[DOF_MAX*DOF_MAX], x[DOF_MAX];
        mj.position(r->m, r->d);
        worst = 0;
        memset(a, 0, sizeof a);
        memset(x, 0, sizeof x);
        for (int c = 0; c < r->d->ne; c++) {
            const double *row = r->d->efc_J + c*n;
            worst = fmax(worst, fabs(r->d->efc_pos[c]));
            for (int i = 0; i < n; i++)
                for (int l = 0; !r->held[i] && l < n; l++)
                    a[i*n + l] += r->held[l] ? 0 : row[i]*row[l];
            for (int i = 0; i < n; i++)
                x[i] -= r->held[i] ? 0 : row[i]*r->d->efc_pos[c];
        }
        for (int i = 0; i < n; i++)
            a[i*n + i] += 1e-13*(a[i*n + i] + 1e-10) + (r->held[i] ? 1 : 0);
        if (worst < 1e-13 || !solve(a, x, n))
            break;
        for (int i = 0; i < n; i++)
            r->d->qpos[i] += x[i];
    }
    return worst;
}

static mjModel *load_bytes(const lw_linkage *k, lw_bytes b)
{
    mjModel *m = mujoco_load(strstr(b.data, "<robot") ? "urdf" : "xml", b.data, b.size);
    if (!m)
        fprintf(stderr, "    %s\n", k->name);
    CHECK(m != NULL);
    lw_bytes_free(&b);
    return m;
}

static mjModel *load(const lw_linkage *k) { return load_bytes(k, mjcf(k)); }

/* Both driven from the posture by `way` in n steps: the tracers stay together within 1e-4 of the size (and far
 * nearer: both are solved to rounding).  Returns the worst distance over the size. */
static double apart(const lw_linkage *k, double way, int n)
{
    lw_newton *s = NULL;
    lw_error e = { 0 };
    mjModel *m = load(k);
    double worst = 0, start = k->input[0].value;
    if (!m || lw_newton_create(k, &s, &e) != LW_OK) {
        CHECK_TEXT(e.text, "");
        return INFINITY;
    }
    m->opt.jacobian = mjJAC_DENSE;
    run r = { .m = m, .d = mj.make(m) };
    CHECK(m->nv <= DOF_MAX && m->nq == m->nv);
    for (int i = 0; i < lw_linkage_free_inputs(k); i++)
        r.held[m->jnt_qposadr[mj.find(m, mjOBJ_JOINT, k->joint[k->input[i].joint].name)]] = true;
    int drive = m->jnt_qposadr[mj.find(m, mjOBJ_JOINT, k->joint[k->input[0].joint].name)];
    CHECK_NEAR(r.d->qpos[drive], start, 1e-12, 1e-12);             /* counts as ours does */
    int moved = -1;
    for (int i = 0; i <= n; i++, moved++) {
        double at = start + way*i/n;
        if (lw_newton_move(s, at, NULL) != LW_OK)
            break;
        r.d->qpos[drive] = at;
        CHECK(close_loops(&r) < 1e-9*fmax(lw_export_size(LW_VIEW(k)), 1e-3));
        for (int t = 0; t < k->n_tracer; t++) {
            const double *p = r.d->site_xpos + 3*mj.find(m, mjOBJ_SITE, k->tracer[t].name);
            worst = fmax(worst, lw_v2_norm(lw_v2_sub(lw_v2(p[0], p[1]), lw_newton_tracer(s, t))));
            CHECK_NEAR(p[2], 0, 1e-12, 0);
        }
    }
    CHECK(moved >= n/4);
    lw_newton_free(s);
    mj.free_data(r.d);
    mj.free_model(m);
    return worst/lw_export_size(LW_VIEW(k));
}

static void examples_move_alike(void)
{
    static const struct { const char *name; double way; } rows[] = {
        { "hoeken", 2*LW_PI }, { "chebyshev", 0.4 }, { "inverted-slider-crank", 2*LW_PI }, { "jansen", -2*LW_PI },
        { "klann", 2*LW_PI }, { "scott-russell", 0.5 }, { "slider-crank", 2*LW_PI }, { "trammel", 0.03 },
        { "geared-five-bar", 4*LW_PI }, { "tied-five-bar", 2*LW_PI }, { "five-bar", 0.3 }, { "loader", 0.4 }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_linkage k = example(rows[i].name);
        CHECK_NEAR(apart(&k, rows[i].way, 120), 0, 1e-8, 0);
    }
}

/* Stepped for 10 s by its drives, there and back once: the greatest distance of a tracer from where the drives ask it
 * to
 * be, over the size. */
static double follows(const lw_linkage *k, double way)
{
    lw_newton *s = NULL;
    mjModel *m = load(k);
    double worst = 0;
    int n = lw_linkage_free_inputs(k);
    if (!m || lw_newton_create(k, &s, &check_error) != LW_OK)
        return INFINITY;
    mjData *d = mj.make(m);
    CHECK_INT(m->nu, n);
    int every = (int)(0.1/m->opt.timestep + 0.5);
    for (long i = 0; (double)i*m->opt.timestep < 10; i++) {
        double go = way*(1 - cos(0.2*LW_PI*(double)(i + 1)*m->opt.timestep))/2;
        for (int a = 0; a < n; a++)
            d->ctrl[a] = k->input[a].value + (a == 0 ? go : 0);
        mj.step(m, d);
        if (i % every != every - 1)
            continue;
        mj.position(m, d);
        if (lw_newton_move(s, k->input[0].value + go, NULL) != LW_OK)
            return INFINITY;
        for (int t = 0; t < k->n_tracer; t++) {
            const double *p = d->site_xpos + 3*mj.find(m, mjOBJ_SITE, k->tracer[t].name);
            double off = lw_v2_norm(lw_v2_sub(lw_v2(p[0], p[1]), lw_newton_tracer(s, t)));
            worst = off > worst || isnan(off) ? off : worst;
        }
    }
    lw_newton_free(s);
    mj.free_data(d);
    mj.free_model(m);
    return worst/lw_export_size(LW_VIEW(k));
}

static void examples_are_stable(void)
{
    static const struct { const char *name; double way; } rows[] = {
        { "hoeken", 1 }, { "chebyshev", 0.3 }, { "inverted-slider-crank", 1 }, { "jansen", -1 }, { "klann", 1 },
        { "scott-russell", 0.3 }, { "slider-crank", 1 }, { "trammel", 0.02 }, { "geared-five-bar", 1 },
        { "tied-five-bar", 1 }, { "five-bar", 0.3 }, { "loader", 0.3 }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_linkage k = example(rows[i].name);
        double off = follows(&k, rows[i].way);
        if (!(off < 1e-3))
            fprintf(stderr, "    %s: %g\n", rows[i].name, off);
        CHECK(off < 1e-3);
    }
}

/* A swing against its stop, a slide that hits both of its stops, a small wheel on a stiff spring, strong dampers, a stiff motor. */
static const char *const stiff[] = {
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1}], 'joints': [{'name': 'A', "
    "'links': ['ground', 'a'], 'at': [0, 0], 'stop': {'least': -1, 'greatest': 2}}], 'gravity': [0, -9.81], "
    "'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0]}]}",
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0], 'inertia': 0.01}, {'name': 's', 'mass': 0.5, "
    "'centre': [0.4, 0.1], 'inertia': 0.01}, {'name': 'b', 'mass': 1, 'centre': [0.6, 0.3], 'inertia': 0.02}], 'joints': [{'name': 'A', "
    "'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'S', 'kind': 't', 'links': ['a', 's'], 'at': [0.4, 0.1], 'along': [1, 0.2], "
    "'stop': {'least': -0.2, 'greatest': 0.3}}, {'name': 'E', 'links': ['s', 'b'], 'at': [0.5, 0.2]}], 'gravity': [0, -9.81], "
    "'springs': [{'joint': 'S', 'stiffness': 100, 'damping': 3}], 'dampers': [{'joint': 'E', 'damping': 0.1}, {'joint': 'A', "
    "'damping': 0.3}], 'tracers': [{'name': 'P', 'link': 'b', 'at': [0.8, 0.4]}]}",
    "{'linkwright': 1, 'links': ['ground', {'name': 'w', 'mass': 0.01, 'centre': [0.002, 0], 'inertia': 1e-8}, {'name': 'b', 'mass': 1, "
    "'centre': [0.5, 0.2], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'w'], 'at': [0, 0]}, {'name': 'B', 'links': "
    "['ground', 'b'], 'at': [0.5, 0]}], 'gravity': [0, -9.81], 'springs': [{'joint': 'A', 'stiffness': 1, 'damping': 0.0001, 'free': "
    "0.4}], 'dampers': [{'joint': 'B', 'damping': 400}], 'tracers': [{'name': 'P', 'link': 'w', 'at': [1, 0]}]}",
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1}], 'joints': [{'name': 'A', "
    "'links': ['ground', 'a'], 'at': [0, 0]}], 'gravity': [0, -9.81], 'motors': [{'joint': 'A', 'stall': 2000, 'free_speed': 2}], "
    "'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0]}]}",
};

/* A slider and a slot that close loops and one that does not, a free body on springs, two free bodies, one of them on the other: all start
 * with speeds. */
static const char *const moving[] = {
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0.1], 'inertia': 0.01}, {'name': 'b', 'mass': 1, "
    "'centre': [0.5, 0.1], 'inertia': 0.02}, {'name': 'c', 'mass': 1, 'centre': [0.9, 0], 'inertia': 0.02}], 'joints': [{'name': 'A', "
    "'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.2, 0.3]}, {'name': 'C', 'links': ['b', 'c'], "
    "'at': [0.9, 0]}, {'name': 'S', 'kind': 't', 'links': ['ground', 'c'], 'at': [0.9, 0], 'along': [1, 0.2]}], 'input': {'joint': 'A', "
    "'speed': 5}, 'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'b', 'at': [0.5, 0.4]}]}",
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0], 'inertia': 0.01}, {'name': 'b', 'mass': 2, 'centre': "
    "[0.2, -0.2], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['b', 'ground'], "
    "'at': [0, -0.5]}, {'name': 'S', 'kind': 'p', 'links': ['b', 'a'], 'at': [0.2, 0], 'along': [0.4, 1]}], 'input': {'joint': 'A', 'speed': "
    "-7}, 'tracers': [{'name': 'P', 'link': 'b', 'at': [0.3, 0.2]}]}",
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0], 'inertia': 0.01}, {'name': 'b', 'mass': 0.2, 'centre': "
    "[0.2, 0.1], 'inertia': 0.002}, {'name': 'c', 'mass': 0.2, 'centre': [0.3, 0.1], 'inertia': 0.002}], 'joints': [{'name': 'A', 'links': "
    "['ground', 'a'], 'at': [0, 0]}, {'name': 'S', 'kind': 'p', 'links': ['b', 'a'], 'at': [0.2, 0], 'along': [1, 0.3]}, {'name': 'T', 'kind': "
    "'p', 'links': ['a', 'c'], 'at': [0.3, 0], 'along': [-1, 0.2]}], 'input': {'joint': 'A', 'speed': 3}, 'springs': [{'links': ['ground', 'b'], 'at': "
    "[[0.4, 0.4], [0.2, 0.1]], 'stiffness': 5, 'damping': 0.1}, {'links': ['ground', 'c'], 'at': [[0.4, -0.4], [0.3, 0.1]], 'stiffness': 5, "
    "'damping': 0.2}], 'tracers': [{'name': 'P', 'link': 'c', 'at': [0.3, 0.2]}]}",
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0.2], 'inertia': 0.01, 'velocity': [0.5, 0.1], 'omega': 3}], "
    "'joints': [{'name': 'F', 'kind': 'n', 'links': ['a', 'ground']}], 'gravity': [0, -9.81], 'springs': [{'links': ['ground', 'a'], 'at': [[-1, 1], "
    "[0, 0.1]], 'stiffness': 50, 'damping': 0.3}, {'links': ['a', 'ground'], 'at': [[0.2, 0.3], [1, 1]], 'stiffness': 40}], 'tracers': [{'name': 'P', "
    "'link': 'a', 'at': [0.3, 0.2]}]}",
    "{'linkwright': 1, 'links': [{'name': 'a', 'mass': 1, 'centre': [0.1, 0.2], 'inertia': 0.01, 'velocity': [1, 2], 'omega': 5}, 'ground', {'name': "
    "'b', 'mass': 0.5, 'centre': [0.3, 0.2], 'inertia': 0.02, 'velocity': [-1, 0.3], 'omega': -2}], 'joints': [{'name': 'F', 'kind': 'n', 'links': "
    "['ground', 'a']}, {'name': 'G', 'kind': 'n', 'links': ['a', 'b']}], 'springs': [{'links': ['a', 'b'], 'at': [[0, 0.1], [0.5, 0.1]], 'stiffness': "
    "20, 'free': 0.4}], 'tracers': [{'name': 'P', 'link': 'b', 'at': [0.3, 0.4]}]}",
};

/* MuJoCo's run of the file from its keyframe, with the step of time that stands in it, and our own: within 1e-3 of the size. */
static void run_alike(drun *d, double to)
{
    CHECK_INT(drun_to(d, d->model.n_rope ? LW_FORMULATION_AUTO : LW_FORMULATION_INDEX1, 1e-9, to, 20), LW_OK);
    CHECK_TEXT(d->e.text, "");
    lw_bytes b = { 0 };
    lw_export_options o = { .model = &d->model, .clearance = -1 };
    CHECK_SILENT(lw_export_mjcf(LW_VIEW(d->model.small), &o, &b, &check_error));
    mjModel *m = load_bytes(d->model.small, b);
    double size = lw_export_size(LW_VIEW(d->model.small)), worst = 0, moved = 0;
    if (m) {
        mjData *s = mj.make(m);
        if (m->nkey > 0)
            mj.reset(m, s, 0);
        long every = lround(to/20/m->opt.timestep);
        CHECK_NEAR((double)every*m->opt.timestep, to/20, 1e-9, 0);
        CHECK(m->opt.timestep <= 5e-4);
        for (long n = 1; n <= 20*every; n++) {
            mj.step(m, s);
            if (n % every != 0)
                continue;
            mj.position(m, s);
            const double *p = s->site_xpos + 3*mj.find(m, mjOBJ_SITE, d->model.linkage.tracer[0].name);
            lw_vec2 want = d->tracer[n/every];
            double off = hypot(p[0] - want.x, p[1] - want.y);
            worst = off > worst || isnan(off) ? off : worst;
            moved = fmax(moved, lw_v2_norm(lw_v2_sub(want, d->tracer[0])));
        }
        CHECK(worst < 1e-3*size);
        CHECK(moved > 0.1*size);
        if (!(worst < 1e-3*size))
            fprintf(stderr, "    %g of the size, moved %g: %s\n", worst/size, moved, d->model.linkage.link_name[1]);
        mj.free_data(s);
        mj.free_model(m);
    }
}

static void runs_alike(const char *model, double to)
{
    static drun d;
    drun_read_format(&d, model, 0, 0);
    run_alike(&d, to);
}

static void speeds_start_alike(void)
{
    static const struct { const char *name; double to[2]; } rows[] = {
        { "dynamics/governor", { 1, 10 } }, { "two-four-bars", { 1, 10 } },
        { "dynamics/rope", { 0.8, 4 } }, { "dynamics/inversor", { 0.8 } }       /* singular at 0.89 s */
    };
    static drun d;
    for (size_t i = 0; i < sizeof moving/sizeof *moving; i++)
        runs_alike(moving[i], 1);
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        for (int n = 0; n < 2 && rows[i].to[n] > 0; n++) {
            char file[80];
            snprintf(file, sizeof file, "examples/%s.json", rows[i].name);
            drun_read(&d, file);
            run_alike(&d, rows[i].to[n]);
        }
}

static void loads_act_alike(void)
{
    for (size_t i = 0; i < LOADED_COUNT; i++)
        runs_alike(loaded[i], 2);
    for (size_t i = 0; i < sizeof stiff/sizeof *stiff; i++)
        runs_alike(stiff[i], 4);
}

/* The bodies of a URDF, as MuJoCo reads it, move with its joints as those of the MJCF file do. */
static void urdf_moves_alike(void)
{
    static const char *const names[] = { "hoeken", "slider-crank", "klann", "jansen", "inverted-slider-crank",
                                         "yoke", "pendulum" };
    lw_rng rng = check_rng(0);
    for (size_t i = 0; i < sizeof names/sizeof *names; i++) {
        lw_linkage k = strcmp(names[i], "yoke") == 0 ? scotch_yoke(1) : example(names[i]);
        lw_bytes b = { 0 };
        CHECK_SILENT(lw_export_urdf(LW_VIEW(&k), NULL, &b, &check_error));
        CHECK((strstr(b.data, "close a loop") != NULL) == (k.n_joint >= k.n_link));
        mjModel *m[2] = { load(&k), load_bytes(&k, b) };
        if (!m[0] || !m[1])
            continue;
        mjData *d[2] = { mj.make(m[0]), mj.make(m[1]) };
        int same = 0;
        for (int j = 0; j < m[0]->njnt; j++) {
            const char *name = m[0]->names + m[0]->name_jntadr[j];
            int other = mj.find(m[1], mjOBJ_JOINT, name);
            double go = 0.3*lw_rng_uniform(&rng);
            if (other < 0)                           /* of a body that only closes a loop */
                continue;
            d[0]->qpos[m[0]->jnt_qposadr[j]] = m[0]->qpos0[m[0]->jnt_qposadr[j]] + go;
            d[1]->qpos[m[1]->jnt_qposadr[other]] = go;
            same++;
        }
        CHECK_INT(same, m[1]->njnt);
        mj.position(m[0], d[0]);
        mj.position(m[1], d[1]);
        for (int link = 0; link < k.n_link; link++) {
            int p = mj.find(m[0], mjOBJ_BODY, k.link_name[link]), q = mj.find(m[1], mjOBJ_BODY, k.link_name[link]);
            if (link == k.ground)
                continue;
            CHECK(p > 0 && q > 0);
            for (int c = 0; c < 9 && p > 0 && q > 0; c++) {
                CHECK_NEAR(d[0]->xmat[9*p + c], d[1]->xmat[9*q + c], 1e-9, 0);
                CHECK_NEAR(d[0]->xpos[3*p + c/3], d[1]->xpos[3*q + c/3], 1e-9*lw_export_size(LW_VIEW(&k)), 0);
            }
            CHECK_NEAR(m[0]->body_mass[p], m[1]->body_mass[q], 0, 0.2);       /* capsules and balls against rods */
        }
        for (int n = 0; n < 2; n++) {
            mj.free_data(d[n]);
            mj.free_model(m[n]);
        }
    }
}

/* Loops that sliders and slots close: wedges; a Scotch yoke with its joints in both orders. */
static void loops_closed_by_sliders(void)
{
    lw_linkage k;
    blank_linkage(&k, 3);
    add_joints(&k, JOINTS(SLIDE(0, 1, 0, 0, 0), SLIDE(1, 2, 1, 1, 0.5), SLIDE(2, 0, 2, 1, 1.4)));
    add_input(&k, 0, 0.25);
    add_tracer(&k, 2, lw_v2(2, 3));
    CHECK_NEAR(apart(&k, 2, 20), 0, 1e-8, 0);
    for (int order = 0; order < 4; order++) {
        k = scotch_yoke(order);
        CHECK_NEAR(apart(&k, 2*LW_PI, 90), 0, 1e-8, 0);
    }
}

/* A link welded on, and one more weld that closes a loop. */
static void welds(void)
{
    lw_linkage k = example("hoeken");
    int link = k.n_link++;
    snprintf(k.link_name[link], LW_NAME_SIZE, "plate");
    for (int i = 0; i < 2; i++) {
        int j = add_joint(&k, LW_JOINT_FIXED, 2, link, lw_v2(0.06, 0.06 + 0.01*i), 0);
        k.joint[j].along = lw_v2(0, 0);
        snprintf(k.joint[j].name, LW_NAME_SIZE, "W%d", i);
    }
    k.tracer[0].link = link;
    CHECK_NEAR(apart(&k, 2*LW_PI, 60), 0, 1e-8, 0);
}

/* MuJoCo has room for the rows of all loops, in a model of any size. */
static void many_loops(void)
{
    OWN(lw_model) row = { 0 };
    OWN(lw_bytes) b = { 0 };
    read_row(170, &row);
    CHECK_OK(lw_export_mjcf(&row.linkage, NULL, &b, &check_error));
    mjModel *m = mujoco_load("xml", b.data, b.size);
    mjData *d = m ? mj.make(m) : NULL;
    if (!d)
        return;
    mj.step(m, d);
    CHECK_INT(d->warning[mjWARN_CNSTRFULL].number, 0);
    CHECK_INT(d->nefc, 3*170);
    mj.free_data(d);
    mj.free_model(m);
}
#else
static void examples_move_alike(void) { }
static void examples_are_stable(void) { }
static void loads_act_alike(void) { }
static void speeds_start_alike(void) { }
static void urdf_moves_alike(void) { }
static void loops_closed_by_sliders(void) { }
static void welds(void) { }
static void many_loops(void) { }
#endif

CHECK_MAIN
{
    RUN(a_four_bar_closes_by_one_connect);
    RUN(names_are_escaped);
    RUN(refusals);
    RUN(sdf_has_all_joints);
    RUN(limits_are_told);
    if (have_mujoco()) {
        RUN(examples_move_alike);
        RUN(examples_are_stable);
        RUN(loads_act_alike);
        RUN(speeds_start_alike);
        RUN(urdf_moves_alike);
        RUN(loops_closed_by_sliders);
        RUN(welds);
        RUN(many_loops);
    } else {
        puts("skipped: MuJoCo is not installed (libmujoco-dev)");
    }
    return check_end();
}
