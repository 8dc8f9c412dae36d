/* cli/fit/plasma.c - print the tables of PLASMA. */
#include "cli/fit/plasma.h"

#include <stdlib.h>

#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "mbs/batch/posture.h"

void cli_plasma_matrix(const lw_lam *a, FILE *f)
{
    char text[LW_LAM_SIZE];
    fputs("Dimension Synthesis Preprocessor LAM- matrix:\n\n", f);
    lw_lam_print(a, text, LW_LAM_SIZE);
    fputs(text, f);
    fprintf(f, "\nParts: %d Joints: %d\n\n", a->n_link, a->n_joint);
}

static int type_number(lw_joint_kind kind)
{
    switch (kind) {
    case LW_JOINT_REVOLUTE: return 11;
    case LW_JOINT_SLIDER:   return 12;
    case LW_JOINT_SLOT: case LW_JOINT_GEAR: case LW_JOINT_FIXED: case LW_JOINT_FREE: break;
    }
    return 13;
}

void cli_plasma_joints(const lw_linkage *linkage, FILE *f)
{
    int marker[LW_LINK_MAX] = { 0 };
    fprintf(f, "  Jnt  Prt1  Prt2  Mar1  Mar2  Jtyp          X:          Y:      F:\n");
    for (int n = 1; n <= linkage->n_joint; n++) {
        const lw_joint *p = &linkage->joint[n - 1];
        int a = p->link[0], b = p->link[1];
        fprintf(f, "%5d %5d %5d %5d %5d %5d %11.5g %11.5g %7.4g\n", n, a + 1, b + 1, 100 * (a + 1) + ++marker[a],
                100 * (b + 1) + ++marker[b], type_number(p->kind), p->at.x / linkage->units.metre,
                p->at.y / linkage->units.metre, lw_joint_turns(p->kind) ? 0 : atan2(p->along.y, p->along.x));
    }
    fputc('\n', f);
}

/* A linkage with what the tables need to evaluate it. */
typedef struct moved { lw_plan plan; double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input; lw_posture posture; } moved;

static lw_status make(const lw_linkage *linkage, moved **out, lw_error *e)
{
    moved *m = calloc(1, sizeof *m);
    if (!m)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a plan");
    lw_status s = lw_plan_make(linkage, (lw_plan_options){ .tracers = 1, .all_joints = true, .kind = LW_PLAN_HIGHER },
                               &m->plan, e);
    if (s == LW_OK)
        s = lw_plan_read(&m->plan, linkage, m->dim, m->mode, &m->input, e);
    if (s != LW_OK)
        free(m);
    else
        *out = m;
    return s;
}

lw_status cli_plasma_dimensions(const lw_linkage *linkage, FILE *f, lw_error *e)
{
    moved *m = NULL;
    lw_status s = make(linkage, &m, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < m->plan.n_dim; i++)
        fprintf(f, "  %-8s %14.8g\n", m->plan.dim[i].name,
                m->dim[i]/(m->plan.dim[i].kind == LW_DIM_ANGLE ? linkage->units.radian : linkage->units.metre));
    fputc('\n', f);
    free(m);
    return LW_OK;
}

/* Displacement of the input and its two derivatives by time. */
static void law_at(const lw_export_law *law, double t, double u[3])
{
    double w = 2*LW_PI, a = w*t + law->phase;
    u[0] = law->turns ? w*t : law->half*(sin(a) - sin(law->phase));
    u[1] = law->turns ? w : law->half*w*cos(a);
    u[2] = law->turns ? 0 : -law->half*w*w*sin(a);
}

/* Turn position and its two derivatives by the input into position, velocity and acceleration in time, in the file's
 * unit. */
static void in_time(const lw_vec2 *p, const double *u, double metre, lw_vec2 out[3])
{
    out[0] = lw_v2_scale(p[0], 1/metre);
    out[1] = lw_v2_scale(p[1], u[1]/metre);
    out[2] = lw_v2_scale(lw_v2_add(lw_v2_scale(p[2], u[1]*u[1]), lw_v2_scale(p[1], u[2])), 1/metre);
}

static lw_status posture_at(moved *m, const lw_export_law *law, int i, int points, double *t, double u[3])
{
    *t = points > 1 ? (double)i/(points - 1) : 0;
    law_at(law, *t, u);
    return lw_posture_solve(&m->plan, m->dim, m->mode, m->input + u[0], 2, &m->posture);
}

static bool path_table(moved *m, const lw_export_law *law, double metre, int points, FILE *f)
{
    bool closes = true;
    fputs(" PNT   Time        PosX        PosY        VelM        VelX        VelY        AccM        AccX        AccY\n", f);
    for (int i = 0; i < points; i++) {
        double t, u[3];
        lw_vec2 p[3];
        if (posture_at(m, law, i, points, &t, u) != LW_OK) {
            fprintf(f, "%4d %6.3f  does not close\n", i + 1, t);
            closes = false;
            continue;
        }
        in_time(m->posture.tracer[0], u, metre, p);
        fprintf(f, "%4d %6.3f %11.5g %11.5g %11.5g %11.5g %11.5g %11.5g %11.5g %11.5g\n", i + 1, t, p[0].x, p[0].y,
                lw_v2_norm(p[1]), p[1].x, p[1].y, lw_v2_norm(p[2]), p[2].x, p[2].y);
    }
    return closes;
}

static void acceleration_table(const lw_linkage *linkage, moved *m, const lw_export_law *law, int points, FILE *f)
{
    fputs("\nAccelerations of the joints:\n\n PNT", f);
    for (int n = 1; n <= linkage->n_joint; n++)
        fprintf(f, "  %8s%-2d", "Jnt", n);
    for (int i = 0; i < points; i++) {
        double t, u[3];
        fprintf(f, "\n%4d", i + 1);
        if (posture_at(m, law, i, points, &t, u) != LW_OK) {
            fputs("  does not close", f);
            continue;
        }
        for (int n = 1; n <= linkage->n_joint; n++) {
            lw_vec2 p[3];
            in_time(m->posture.joint[n - 1], u, linkage->units.metre, p);
            fprintf(f, " %11.5g", lw_v2_norm(p[2]));
        }
    }
    fputs("\n\n", f);
}

lw_status cli_plasma_path(const lw_linkage *linkage, int points, FILE *f, lw_error *e)
{
    moved *m = NULL;
    lw_export_law law;
    lw_status s = lw_export_law_of(LW_VIEW(linkage), NULL, 0, &law);
    if (s != LW_OK)
        return lw_error_set(e, s, "out of memory");
    s = make(linkage, &m, e);
    if (s != LW_OK)
        return s;
    bool closes = path_table(m, &law, linkage->units.metre, points, f);
    acceleration_table(linkage, m, &law, points, f);
    free(m);
    return closes ? LW_OK : LW_OPEN;
}
