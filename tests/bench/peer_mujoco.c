/* peer_mujoco.c - scenes of `linkwright bench mbs` in MuJoCo 2.2 (peer.h says what comes in and goes out): the model
 * that linkwright exports, with the masses put into its bodies; loops are closed by soft constraints as stiff as the
 * step allows. */
#include <math.h>
#include <mujoco/mujoco.h>
#include <setjmp.h>
#include "tests/bench/peer.h"

static peer_scene *scene;
static int body_of[PEER_MAX];                   /* MuJoCo's number of link k; 0: the world       */
static double arm[PEER_MAX][2][3];              /* ends of springs in their bodies' frames       */
static jmp_buf give_up;
static char why[160];

static void on_error(const char *text)
{
    snprintf(why, sizeof why, "%.150s", text);
    longjmp(give_up, 1);
}

/* A warning is an instability or a singular mass matrix: the run is lost. */
static void on_warning(const char *text) { on_error(text); }

/* ---- the model ------------------------------------------------------------------------------------------- */

static mjModel *load(const char *xml)
{
    static mjVFS files;
    char text[1000] = "";
    int size = (int)strlen(xml);
    mj_defaultVFS(&files);
    if (mj_makeEmptyFileVFS(&files, "linkage.xml", size) != 0)
        on_error("no room for the model");
    memcpy(files.filedata[0], xml, (size_t)size);
    mjModel *m = mj_loadXML("linkage.xml", &files, text, sizeof text);
    mj_deleteVFS(&files);
    if (!m)
        on_error(text);
    return m;
}

static int find(const mjModel *m, int link)
{
    int b = link ? mj_name2id(m, mjOBJ_BODY, scene->body[link - 1].name) : 0;
    if (b < 0)
        on_error("a link is not in the model that was exported");
    return b;
}

/* Behind <body name="..." pos="x y z"> of the export; origin: of the body's frame. */
static void put_mass(const peer_body *b, const double *origin)
{
    char begin[PEER_NAME + 32], mass[256];
    snprintf(begin, sizeof begin, "<body name=\"%s\" ", b->name);
    char *at = strstr(scene->xml, begin), *end = at ? strchr(at, '>') : NULL;
    int n = snprintf(mass, sizeof mass,
                     "<inertial pos=\"%.17g %.17g 0\" mass=\"%.17g\" diaginertia=\"%.17g %.17g %.17g\"/>",
                     b->x - origin[0], b->y - origin[1], b->mass, 0.5*b->inertia, 0.5*b->inertia, b->inertia);
    if (!end || strlen(scene->xml) + (size_t)n >= PEER_XML)
        on_error("the masses cannot be put into the model that was exported");
    memmove(end + 1 + n, end + 1, strlen(end + 1) + 1);
    memcpy(end + 1, mass, (size_t)n);
}

static void end_of(const mjData *d, int link, double x, double y, double *out)
{
    out[0] = x - d->xpos[3*body_of[link]];
    out[1] = y - d->xpos[3*body_of[link] + 1];
    out[2] = 0;
}

static void set_options(mjModel *m)
{
    m->opt.solver = mjSOL_NEWTON;
    memset(m->dof_armature, 0, (size_t)m->nv*sizeof *m->dof_armature);      /* of drives, which are off */
    m->opt.tolerance = 1e-14;
    m->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_FRICTIONLOSS | mjDSBL_ACTUATION | mjDSBL_SENSOR
                         | mjDSBL_REFSAFE;
}

/* Compiled twice: the first time tells where the frames of the bodies are.  A model in space has its masses. */
static mjModel *make_model(void)
{
    mjModel *m = load(scene->xml);
    if (scene->space) {
        set_options(m);
        return m;
    }
    mjData *d = mj_makeData(m);
    mj_kinematics(m, d);
    for (int k = 1; k <= scene->n_body; k++) {
        body_of[k] = find(m, k);
        put_mass(&scene->body[k - 1], d->xpos + 3*body_of[k]);
    }
    for (int k = 0; k < scene->n_spring; k++) {
        const peer_spring *c = &scene->spring[k];
        end_of(d, c->a, c->ax, c->ay, arm[k][0]);
        end_of(d, c->b, c->bx, c->by, arm[k][1]);
    }
    mj_deleteData(d);
    mj_deleteModel(m);
    m = load(scene->xml);
    m->opt.gravity[0] = scene->gx;
    m->opt.gravity[1] = scene->gy;
    set_options(m);
    return m;
}

/* ---- forces and the start ---------------------------------------------------------------------------------- */

static void springs(const mjModel *m, mjData *d)
{
    for (int k = 0; k < scene->n_spring; k++) {
        const peer_spring *c = &scene->spring[k];
        const int body[2] = { body_of[c->a], body_of[c->b] };
        mjtNum end[2][3], force[3], torque[3] = { 0 };
        for (int i = 0; i < 2; i++) {
            mju_rotVecMat(end[i], arm[k][i], d->xmat + 9*body[i]);
            mju_addTo3(end[i], d->xpos + 3*body[i]);
        }
        mju_sub3(force, end[1], end[0]);
        double length = mju_normalize3(force);
        mju_scl3(force, force, c->stiffness*(length - c->free));
        mj_applyFT(m, d, force, torque, end[0], body[0], d->qfrc_passive);
        mju_scl3(force, force, -1);
        mj_applyFT(m, d, force, torque, end[1], body[1], d->qfrc_passive);
    }
}

static double omega_of(int body)
{
    for (int k = 1; k <= scene->n_body; k++)
        if (body_of[k] == body)
            return scene->body[k - 1].omega;
    return 0;
}

/* Every joint is a hinge about z or against it. */
static double sign_of(const mjModel *m, int joint) { return m->jnt_axis[3*joint + 2] < 0 ? -1 : 1; }

static void start(const mjModel *m, mjData *d)
{
    mj_resetData(m, d);
    if (scene->space && m->nkey > 0)
        mj_resetDataKeyframe(m, d, 0);
    for (int j = 0; !scene->space && j < m->njnt; j++) {
        int b = m->jnt_bodyid[j];
        d->qvel[m->jnt_dofadr[j]] = sign_of(m, j)*(omega_of(b) - omega_of(m->body_parentid[b]));
    }
    for (int k = 0; k < scene->n_torque; k++)
        d->xfrc_applied[6*body_of[scene->torque[k].body] + 5] += scene->torque[k].value;
}

static double turn(const mjModel *m, const mjData *d, int body)
{
    double sum = 0;
    for (int b = body; b; b = m->body_parentid[b])
        for (int j = m->body_jntadr[b]; j >= 0 && j < m->body_jntadr[b] + m->body_jntnum[b]; j++)
            sum += sign_of(m, j)*(d->qpos[m->jnt_qposadr[j]] - m->qpos0[m->jnt_qposadr[j]]);
    return sum;
}

static void print(const mjModel *m, mjData *d)
{
    mj_kinematics(m, d);
    if (scene->space) {
        const double *x = d->site_xpos + 3*mj_name2id(m, mjOBJ_SITE, scene->point_name);
        printf("%.17g %.17g %.17g\n", x[0], x[1], x[2]);
    }
    for (int k = 1; k <= scene->n_body; k++) {
        const double *x = d->xipos + 3*body_of[k];
        printf("%.17g %.17g %.17g%c", x[0], x[1], turn(m, d, body_of[k]), k == scene->n_body ? '\n' : ' ');
    }
}

/* ---- rows ---------------------------------------------------------------------------------------------------- */

/* As stiff as the step lets them be: time constant of one or two steps, impedance next to 1. */
static void set_step(mjModel *m, double step)
{
    bool rk4 = m->opt.integrator == mjINT_RK4;
    m->opt.timestep = step;
    for (int e = 0; e < m->neq; e++) {
        m->eq_solref[mjNREF*e] = rk4 ? step : 2*step;
        m->eq_solref[mjNREF*e + 1] = 1;
        m->eq_solimp[mjNIMP*e] = m->eq_solimp[mjNIMP*e + 1] = 0.9999;
    }
}

/* Seconds of the best run. */
static double row(mjModel *m, mjData *d, const char *name, int each, double set_up)
{
    int n = each*(scene->moments - 1), rates = m->opt.integrator == mjINT_RK4 ? 4 : 1;
    double best = INFINITY, spent = 0;
    set_step(m, scene->end/n);
    for (int k = 0; k < PEER_REPEAT && (k == 0 || spent < scene->repeat); k++) {
        start(m, d);
        double t0 = peer_clock();
        for (int i = 0; i < n; i++)
            mj_step(m, d);
        double t = peer_clock() - t0;
        best = fmin(best, t);
        spent += t;
    }
    start(m, d);
    printf("run %g %.9g %.9g %d %d %s\n", m->opt.timestep, set_up, best, n, rates*n, name);
    print(m, d);
    for (int i = 1; i <= n; i++) {
        mj_step(m, d);
        if (i % each == 0)
            print(m, d);
    }
    fflush(stdout);
    return best;
}

typedef struct one_row { mjModel *m; mjData *d; const char *name; int each; double set_up; } one_row;

static double row_apart(void *context)
{
    one_row *r = context;
    if (!setjmp(give_up))
        return row(r->m, r->d, r->name, r->each, r->set_up);
    printf("fail %g %s: %s\n", r->m->opt.timestep, r->name, why);
    return 0;
}

static void rows(mjModel *m, int integrator, const char *name, double set_up)
{
    one_row r = { m, mj_makeData(m), name, 1, set_up };
    bool slow = false;
    m->opt.integrator = integrator;
    for (; r.each < 1 << 20 && !slow; r.each *= 2)
        slow = peer_apart(scene, row_apart, &r, scene->end/(r.each*(scene->moments - 1)), name);
    mj_deleteData(r.d);
}

int main(void)
{
    scene = peer_read();
    if (scene->n_at3) {
        puts("fail 0 inverse: MuJoCo's inverse dynamics takes the forces of soft constraints from their gaps");
        return 0;
    }
    mju_user_error = on_error;
    mju_user_warning = on_warning;
    if (setjmp(give_up)) {
        fprintf(stderr, "peer_mujoco: %s\n", why);
        return 4;
    }
    double begun = peer_clock();
    mjModel *m = make_model();
    double set_up = peer_clock() - begun;
    mjcb_passive = scene->space ? NULL : springs;
    rows(m, mjINT_RK4, "RK4", set_up);
    rows(m, mjINT_EULER, "Euler", set_up);
    mj_deleteModel(m);
    return 0;
}
