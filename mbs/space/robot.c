#include "mbs/space/robot.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/linalg.h"
#include "base/number.h"
#include "base/rank.h"
#include "base/suggest.h"
#include "base/vec3.h"

#define ROUNDING 1e-12           /* a drive that moves the tool by less of the size, or of a turn, does not move it */
#define CLOSE 1e-11              /* of the size, and [rad]: the tool is there                          */
#define LONGEST_STEP 0.1         /* of the size: stops and cones are looked at so often                 */
#define SURE_STEP 0.005          /* so far on, or no farther than half of the way to where the drives seem to lose the tool */
#define CONDITION_STEP 0.02      /* the same of a limit of the condition: it is exceeded in a tube about singular postures of an arm,
                                  * whose radius is about the size over the limit                       */

/* ---- making ---------------------------------------------------------------------------------------------- */

static lw_status find_tool(const lw_spatial *m, const char *name, int *tool, lw_error *e)
{
    if (m->n_tracer == 0)
        return lw_error_set(e, LW_E_ARG, "the model has no tracer: its tool is one, \"tracers\"");
    *tool = 0;
    if (!name)
        return LW_OK;
    for (*tool = 0; *tool < m->n_tracer; ++*tool)
        if (strcmp(m->tracer[*tool].name, name) == 0)
            return LW_OK;
    const char *near = LW_SUGGEST(name, m->tracer, m->n_tracer, name);
    return lw_error_set(e, LW_E_ARG, "there is no tracer \"%.40s\"%s%s%s", name, LW_DID_YOU_MEAN(near));
}

static bool drive_turns(const lw_robot *r, int i) { return r->measure[i].of == LW_OF_TURN; }

/* Principal values and axes, the greatest first. */
static void principal(const double a[6], double value[3], lw_mat3 *axes)
{
    lw_mat3 by;
    double v[3];
    int order[3] = { 0, 1, 2 };
    lw_m3_principal(a, v, &by);
    for (int i = 0; i < 2; i++)
        for (int k = i + 1; k < 3; k++)
            if (v[order[k]] > v[order[i]]) {
                int o = order[i];
                order[i] = order[k];
                order[k] = o;
            }
    for (int i = 0; i < 3; i++)
        value[i] = v[order[i]];
    *axes = lw_m3_columns(lw_m3_column(&by, order[0]), lw_m3_column(&by, order[1]), lw_m3_column(&by, order[2]));
}

static void fill_tensor(int n, double (*row)[LW_ROBOT_DRIVES], double a[6])
{
    static const int at[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    for (int k = 0; k < 6; k++) {
        a[k] = 0;
        for (int i = 0; i < n; i++)
            a[k] += row[at[k][0]][i]*row[at[k][1]][i];
    }
}

/* Rank of the whole Jacobian, lengths over the robot's size; with shifts = 3, of it and the three pure shifts of the tool. */
static int rank_with(const lw_robot *r, const lw_robot_pose *p, int shifts)
{
    double number[6*(LW_ROBOT_DRIVES + 3) + 3*(6 + LW_ROBOT_DRIVES + 3)];      /* lw_rank_doubles */
    int place[LW_ROBOT_DRIVES + 3];
    lw_rank a;
    lw_rank_place(&a, 6, r->n_drive + shifts, number, place);
    for (int k = 0; k < 6; k++) {
        for (int i = 0; i < r->n_drive; i++) {
            double moved = p->jacobian[k][i]/(k < 3 ? r->space.unit : 1)*(drive_turns(r, i) ? 1 : r->space.unit);
            a.a[k + 6*i] = fabs(moved) > ROUNDING ? moved : 0;
        }
        for (int i = 0; i < shifts; i++)
            a.a[k + 6*(r->n_drive + i)] = k == i;
    }
    lw_rank_factor(&a, 1e-9);
    return a.rank;
}

/* Which freedoms does the tool have?  The posture of the file may be singular: look nearby, too. */
static lw_status find_freedoms(lw_robot *r, lw_error *e)
{
    static const double step = 0.01;         /* rad, or of the size */
    lw_robot_pose pose[2] = { { .rank = 0 }, { .rank = 0 } };
    bool known[2];
    known[0] = lw_robot_measure(r, &pose[0], NULL) == LW_OK;
    for (int i = 0; i < r->n_drive; i++)
        pose[1].drive[i] = pose[0].drive[i] + step*(1 + 0.1*i)*(drive_turns(r, i) ? 1 : r->space.unit);
    known[1] = known[0] && (lw_robot_drive(r, pose[1].drive, NULL), lw_robot_measure(r, &pose[1], NULL) == LW_OK);
    for (int k = 0; k < 2 && known[k]; k++) {
        r->rank = pose[k].rank > r->rank ? pose[k].rank : r->rank;
        r->freedoms = pose[k].freedoms > r->freedoms ? pose[k].freedoms : r->freedoms;
    }
    lw_robot_pose *p = &pose[known[1] && pose[1].freedoms == r->freedoms];
    r->only_turns = known[0] && r->rank == 0;
    if (r->only_turns && r->freedoms > 0)
        r->turns = true, r->rank = r->freedoms;
    else if (known[0] && !r->turns && r->rank == 3 && r->freedoms > 3 && rank_with(r, p, 3) == r->freedoms)
        r->turns = true;
    if (r->turns && r->n_drive == 4 && r->freedoms == 4) {       /* about which axis? */
        double tensor[6], value[3];
        lw_mat3 axes;
        fill_tensor(r->n_drive, p->jacobian + 3, tensor);
        principal(tensor, value, &axes);
        r->spin = lw_m3_column(&axes, 0);
    }
    lw_robot_reset(r);
    return !known[0] || r->freedoms > 0 ? LW_OK
         : lw_error_set(e, LW_E_ARG, "the drives do not move the tool \"%.40s\"", r->model->tracer[r->tool].name);
}

/* Make r->by_tool where the drives are as many as coordinates of the tool's pose in ground axes. */
static lw_status follow_tool(lw_robot *r, lw_error *e)
{
    static const double aligned = 1e-12;
    lw_spatial_measure pose[6];
    int n = 0;
    bool flat = lw_v3_norm(r->normal) > 0;
    lw_vec3 about = flat ? r->normal : r->spin;          /* the tool turns about this axis alone; 0: about all */
    for (int k = 0; k < 6; k++) {
        double along = fabs(lw_v3_dot(k < 3 ? r->normal : about, lw_v3(k%3 == 0, k%3 == 1, k%3 == 2)));
        if (k < 3 ? along < aligned : r->turns && (along > 1 - aligned || lw_v3_norm(about) == 0)) {
            r->pose[n] = (lw_spatial_of)(LW_OF_X + k);
            pose[n] = (lw_spatial_measure){ r->pose[n], r->tool };
            n++;
        }
    }
    lw_status s = n == r->n_drive && !r->only_turns ? lw_space_follow_make(&r->space, pose, n, false, &r->by_tool, NULL) : LW_OK;
    if (s != LW_OK)
        r->by_tool.memory = NULL;
    return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory") : LW_OK;        /* other failures: the tool moves in a plane */
}

lw_status lw_robot_make(const lw_spatial *m, const char *tool, lw_robot *r, lw_error *e)
{
    *r = (lw_robot){ .model = m, .least = 1e-8 };
    lw_status s = find_tool(m, tool, &r->tool, e);
    if (s != LW_OK)
        return s;
    r->n_drive = m->n_drive ? m->n_drive : m->n_input;
    if (r->n_drive == 0 || r->n_drive > LW_ROBOT_DRIVES)
        return lw_error_set(e, LW_E_ARG, r->n_drive ? "the model has more than %d drives" :
                            "the model has no drives: name the joints that motors move, \"drives\" (at most %d)",
                            LW_ROBOT_DRIVES);
    for (int i = 0; i < r->n_drive; i++)
        r->measure[i] = m->n_drive ? m->drive[i] : m->input[i].measure;
    bool flat = lw_spatial_is_planar(m, &r->normal);
    if (!flat)
        r->normal = lw_v3(0, 0, 0);
    r->turns = r->n_drive >= (flat ? 3 : 6);
    s = lw_space_make(m, &r->space, e);
    if (s != LW_OK)
        return s;
    s = lw_space_follow_make(&r->space, r->measure, r->n_drive, false, &r->follow, e);
    int lost = s == LW_OK ? lw_space_lost_freedoms(&r->follow) : 0;
    if (lost > 0)
        s = lw_error_set(e, LW_E_ARG, "the posture of the file is singular: the links have %d freedom%s of motion, not one for each of the %d drives; "
                         "take another "
                         "posture of the motion", r->n_drive - lost, lw_plural(r->n_drive - lost), r->n_drive);
    size_t n_v = (size_t)r->space.n_v, n_q = (size_t)r->space.n_q;
    bool loops = r->space.n_joint > r->space.n_body;
    size_t square = loops ? n_v*(n_v + 1) : 0;
    if (s == LW_OK)
        s = lw_space_hold_make(r->n_drive, r->space.n_v, &r->hold, e);
    if (s == LW_OK && !(r->start = calloc(n_q + square, sizeof *r->start)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s != LW_OK) {
        lw_robot_free(r);
        return s;
    }
    memcpy(r->start, r->follow.q, n_q*sizeof *r->start);
    r->square = loops ? r->start + n_q : NULL;
    lw_space_follow_values(&r->follow, r->drive);
    s = find_freedoms(r, e);
    if (s == LW_OK)
        s = follow_tool(r, e);
    if (s != LW_OK)
        lw_robot_free(r);
    return s;
}

void lw_robot_free(lw_robot *r)
{
    if (r->follow.memory)
        lw_space_follow_free(&r->follow);
    if (r->by_tool.memory)
        lw_space_follow_free(&r->by_tool);
    lw_space_free(&r->space);
    lw_space_hold_free(&r->hold);
    free(r->start);
    *r = (lw_robot){ 0 };
}

/* Values as the model counts them are those of the joints and an offset. */
static double offset_of(const lw_robot *r, int i)
{
    return r->model->n_drive ? 0 : lw_spatial_offset(&r->model->input[i]);
}

void lw_robot_reset(lw_robot *r)
{
    memcpy(r->follow.q, r->start, (size_t)r->space.n_q*sizeof *r->start);
    memset(r->follow.z.near, 0, (size_t)r->follow.z.n_near*sizeof *r->follow.z.near);
    r->follow.u = 0;
}

/* ---- the posture reached --------------------------------------------------------------------------------- */

/* Columns of J, and the velocities of all bodies that belong to them, where the rows are filled.  NULL, or why not. */
static const char *find_columns(lw_robot *r, double jacobian[6][LW_ROBOT_DRIVES])
{
    lw_space_follow *f = &r->follow;
    const lw_space *s = &r->space;
    if (f->z.n_kept < s->n_v || !lw_space_rows_factor_near(&f->z))
        return "the drives do not hold the tool in this posture: it is singular";
    if (!lw_space_rows_motions(&f->z, r->n_drive, s->n_row + f->n_idle, r->hold.column))
        return "the posture is too near to a singular one to find how the drives move the tool";
    for (int i = 0; i < r->n_drive; i++) {
        double *v = r->hold.column + (size_t)i*(size_t)s->n_v, scale = lw_space_scale(s, r->measure[i]);
        for (int k = 0; k < s->n_v; k++)
            v[k] /= scale;
        lw_vec3 p = lw_space_point_velocity(s, f->z.frame, s->tracer[r->tool], v);
        lw_vec3 w = lw_space_omega(f->z.frame, s->tracer[r->tool].body, v);
        double of[] = { p.x, p.y, p.z, w.x, w.y, w.z };
        for (int k = 0; k < 6; k++)
            jacobian[k][i] = of[k];
    }
    return NULL;
}

static lw_status fill_jacobian(lw_robot *r, double jacobian[6][LW_ROBOT_DRIVES], lw_error *e)
{
    lw_space_follow *f = &r->follow;
    if (memcmp(f->z.filled, f->q, (size_t)r->space.n_q*sizeof *f->q) != 0)   /* else the way here has filled them */
        lw_space_rows_fill(&f->z, f->q, f->z.near);
    const char *why = find_columns(r, jacobian);
    if (why && f->z.n_kept < f->z.n_row) {       /* the basis kept may be that of the end of another way */
        lw_status s = lw_space_rows_arrange(&f->z, f->q, e);
        if (s != LW_OK)
            return s;
        why = find_columns(r, jacobian);
    }
    return why ? lw_error_set(e, LW_OPEN, "%s", why) : LW_OK;
}

static void tool_pose(const lw_robot *r, lw_vec3 *place, lw_quaternion *turn)
{
    const lw_space *s = &r->space;
    lw_space_point p = s->tracer[r->tool];
    const double *q = r->follow.q + 7*p.body;
    *turn = r->model->tracer[r->tool].frame;
    if (p.body >= 0)
        *turn = lw_quaternion_times(lw_quaternion_times((lw_quaternion){ q[3], q[4], q[5], q[6] },
                                                        lw_quaternion_inverse(s->axes[p.body])), *turn);
    *turn = lw_quaternion_unit(*turn);
    *place = lw_space_point_at(r->follow.z.frame, p);
}

lw_quaternion lw_robot_turn(lw_robot *r)
{
    lw_vec3 place;
    lw_quaternion turn;
    lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
    tool_pose(r, &place, &turn);
    return turn;
}

/* A direction of the posture of the file as a body carries it now. */
static lw_vec3 carried(const lw_robot *r, int body, lw_vec3 direction)
{
    if (body < 0)
        return direction;
    lw_mat3 axes = lw_quaternion_matrix(r->space.axes[body]);
    return lw_m3_apply(&r->follow.z.frame[body + 1].turn, lw_m3_unapply(&axes, direction));
}

/* Masses that forces on the tool move: J M^-1 J^T = A A^T with A = J L^-T, M = L L^T.  row: of J, three. */
static void fill_masses(const lw_robot *r, double (*row)[LW_ROBOT_DRIVES], lw_robot_pose *out)
{
    double m[LW_ROBOT_DRIVES][LW_ROBOT_DRIVES], a[6][LW_ROBOT_DRIVES], tensor[6], value[3];
    int n = r->n_drive;
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= i; k++) {
            m[i][k] = 0;
            for (int j = 0; j < r->space.n_v; j++)
                m[i][k] += r->hold.column[i*r->space.n_v + j]*r->space.mass[j]*r->hold.column[k*r->space.n_v + j];
        }
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= i; k++) {
            double sum = m[i][k];
            for (int j = 0; j < k; j++)
                sum -= m[i][j]*m[k][j];
            if (i == k && !(sum > 0))
                return;                                        /* massless in a direction of the drives */
            m[i][k] = i == k ? sqrt(sum) : sum/m[k][k];
        }
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < n; i++) {
            double sum = row[j][i];
            for (int k = 0; k < i; k++)
                sum -= m[i][k]*a[j][k];
            a[j][i] = sum/m[i][i];
        }
    fill_tensor(n, a, tensor);
    principal(tensor, value, &out->mass_axes);
    for (int i = 0; i < out->rank; i++)
        out->mass[i] = 1/value[i];
}

bool lw_robot_centre(lw_robot *r, lw_vec3 *centre)
{
    lw_robot_pose p;
    double tensor[6] = { 0 }, value[3], off = 0, size = 0;
    lw_vec3 b = { 0, 0, 0 }, from = { 0, 0, 0 };
    lw_mat3 axes;
    if (lw_robot_measure(r, &p, NULL) != LW_OK)
        return false;
    const double (*j)[LW_ROBOT_DRIVES] = (const double (*)[LW_ROBOT_DRIVES])p.jacobian;
    for (int pass = 0; pass < 2; pass++) {                   /* the least squares of v + w x from; what they leave */
        for (int i = 0; i < r->n_drive; i++) {
            lw_vec3 v = lw_v3(j[0][i], j[1][i], j[2][i]), w = lw_v3(j[3][i], j[4][i], j[5][i]);
            double square = lw_v3_dot(w, w), add[6] = { square - w.x*w.x, square - w.y*w.y, square - w.z*w.z, -w.x*w.y, -w.x*w.z, -w.y*w.z };
            for (int k = 0; k < 6 && !pass; k++)
                tensor[k] += add[k];
            b = lw_v3_add(b, lw_v3_cross(w, v));
            off = fmax(off, lw_v3_norm(lw_v3_add(v, lw_v3_cross(w, from))));
            size = fmax(size, lw_v3_norm(w));
        }
        if (pass)
            break;
        lw_m3_principal(tensor, value, &axes);
        for (int k = 0; k < 3; k++) {
            if (!(value[k] > 1e-9*size*size))
                return false;
            lw_vec3 axis = lw_m3_column(&axes, k);
            from = lw_v3_add(from, lw_v3_scale(axis, lw_v3_dot(axis, b)/value[k]));
        }
        off = 0;
    }
    *centre = lw_v3_add(p.place, from);
    return off <= 1e-9*size*r->space.unit;
}

lw_status lw_robot_measure(lw_robot *r, lw_robot_pose *out, lw_error *e)
{
    double tensor[6], square[3];
    memset(out, 0, sizeof *out);
    lw_space_follow_values(&r->follow, out->drive);
    for (int i = 0; i < r->n_drive; i++)
        out->drive[i] += offset_of(r, i);
    lw_status s = fill_jacobian(r, out->jacobian, e);
    if (s != LW_OK)
        return s;
    tool_pose(r, &out->place, &out->turn);
    out->freedoms = rank_with(r, out, 0);
    double (*row)[LW_ROBOT_DRIVES] = out->jacobian + (r->only_turns ? 3 : 0), least = 0;
    for (int i = 0; i < r->n_drive; i++)
        least = fmax(least, ROUNDING*(r->only_turns ? 1 : r->space.unit)/(drive_turns(r, i) ? 1 : r->space.unit));
    fill_tensor(r->n_drive, row, tensor);
    principal(tensor, square, &out->axes);
    out->manipulability = 1;
    for (int i = 0; i < 3; i++) {
        out->singular[i] = square[i] > fmax(1e-14*square[0], least*least) ? sqrt(square[i]) : 0;      /* squares know nothing smaller */
        if (out->singular[i] > 0) {
            out->rank = i + 1;
            out->manipulability *= out->singular[i];
            out->condition = out->singular[0]/out->singular[i];
        }
    }
    if (out->rank >= r->rank)
        fill_masses(r, row, out);
    else {
        out->rank = r->rank;
        out->manipulability = 0;
        out->condition = INFINITY;
    }
    return LW_OK;
}

/* ---- moving ---------------------------------------------------------------------------------------------- */

static lw_status to_drives(void *context, double u, double (*out)[3])
{
    const lw_robot *r = context;
    for (int i = 0; i < r->n_drive; i++) {
        out[i][0] = r->from[i] + u*(r->drive[i] - r->from[i]);
        out[i][1] = r->drive[i] - r->from[i];
        out[i][2] = 0;
    }
    return LW_OK;
}

/* Move the drives to r->drive. */
static lw_status go(lw_robot *r, lw_error *e)
{
    lw_space_follow_values(&r->follow, r->from);
    r->follow.u = 0;
    return lw_space_follow_to(&r->follow, to_drives, r, 1, e);
}

lw_status lw_robot_drive(lw_robot *r, const double *value, lw_error *e)
{
    for (int i = 0; i < r->n_drive; i++)
        r->drive[i] = value[i] - offset_of(r, i);
    return go(r, e);
}

/* Is a stop or a cone passed in this posture?  r->limit names it. */
static bool passed(lw_robot *r)
{
    const lw_spatial *m = r->model;
    double drive[LW_ROBOT_DRIVES];
    lw_space_follow_values(&r->follow, drive);
    for (int j = 0; j < m->n_joint && !r->free; j++) {
        const lw_spatial_joint *p = &m->joint[j];
        const lw_space_joint *q = &r->space.joint[j];
        if (p->has_cone) {
            lw_vec3 first = carried(r, q->body[0], p->cone_axis), second = carried(r, q->body[1], p->cone_axis);
            double tilt = atan2(lw_v3_norm(lw_v3_cross(first, second)), lw_v3_dot(first, second));
            if (tilt > p->cone) {
                snprintf(r->limit, sizeof r->limit, "the cone of joint \"%s\"", p->name);
                return true;
            }
        }
        if (!p->stop.has_least && !p->stop.has_greatest)
            continue;
        lw_spatial_measure of = { p->kind == LW_SPATIAL_PRISMATIC ? LW_OF_SLIDE : LW_OF_TURN, j };
        double near = 0, value;
        for (int i = 0; i < r->n_drive && of.of == LW_OF_TURN; i++)        /* drives count their turns, stops may lie beyond half of one */
            if (r->measure[i].of == of.of && r->measure[i].index == j)
                near = drive[i];
        value = lw_space_scale(&r->space, of)*lw_space_measure(&r->space, r->follow.z.frame, of, near, NULL);
        if ((p->stop.has_least && value < p->stop.least) || (p->stop.has_greatest && value > p->stop.greatest)) {
            snprintf(r->limit, sizeof r->limit, "the stop of joint \"%s\"", p->name);
            return true;
        }
    }
    return false;
}

/* Change of the drives that brings the tool nearer by `error` (place, and turn): least squares, the least change. */
static void solve_drives(const lw_robot *r, double jacobian[6][LW_ROBOT_DRIVES], const double error[6],
                         double change[LW_ROBOT_DRIVES])
{
    int rows = r->turns ? 6 : 3, n = r->n_drive;
    double a[(6 + LW_ROBOT_DRIVES)*6], diag[6], top = 0;
    /* (J J^T + small^2) y = error, change = J^T y: Q R of J^T over a small multiple of the unit matrix */
    for (int k = 0; k < rows; k++)
        for (int i = 0; i < n; i++)
            top = fmax(top, fabs(jacobian[k][i]));
    double small = 1e-7*top;
    int m = n + rows;
    for (int k = 0; k < rows; k++) {
        for (int i = 0; i < n; i++)
            a[k*m + i] = jacobian[k][i];
        for (int i = 0; i < rows; i++)
            a[k*m + n + i] = i == k ? small : 0;
    }
    lw_qr_factor(m, rows, a, diag);
    /* R^T R y = error */
    double y[6];
    for (int i = 0; i < rows; i++) {
        double sum = error[i];
        for (int k = 0; k < i; k++)
            sum -= a[i*m + k]*y[k];
        y[i] = sum/diag[i];
    }
    for (int i = rows - 1; i >= 0; i--) {
        double sum = y[i];
        for (int k = i + 1; k < rows; k++)
            sum -= a[k*m + i]*y[k];
        y[i] = sum/diag[i];
    }
    for (int i = 0; i < n; i++) {
        change[i] = 0;
        for (int k = 0; k < rows; k++)
            change[i] += jacobian[k][i]*y[k];
    }
}

/* The tool's distance from a pose: place [m], turn [rad]. */
static double pose_error(const lw_robot *r, lw_vec3 place, const lw_quaternion *turn, double error[6])
{
    lw_vec3 at, d, w = { 0, 0, 0 };
    lw_quaternion now;
    tool_pose(r, &at, &now);
    d = lw_v3_sub(place, at);
    if (turn && r->turns)
        w = lw_quaternion_vector(lw_quaternion_times(*turn, lw_quaternion_inverse(now)));
    double of[] = { d.x, d.y, d.z, w.x, w.y, w.z };
    memcpy(error, of, sizeof of);
    return lw_v3_norm(d)/r->space.unit + lw_v3_norm(w);
}

/* Straight to the goal, with an even turn. */
static lw_status to_pose(void *context, double u, double (*out)[3])
{
    const lw_robot *r = context;
    double angle = lw_v3_norm(r->spin_to_goal), s = sin(u*angle/2), c = cos(u*angle/2);
    lw_vec3 way = lw_v3_sub(r->goal, r->begin), at = lw_v3_add(r->begin, lw_v3_scale(way, u));
    lw_vec3 axis = lw_v3_scale(r->spin_to_goal, angle > 0 ? 1/angle : 0);
    const double of[] = { at.x, at.y, at.z, 2*s*axis.x, 2*s*axis.y, 2*s*axis.z };
    const double rate[] = { way.x, way.y, way.z, angle*c*axis.x, angle*c*axis.y, angle*c*axis.z };
    for (int i = 0; i < r->by_tool.n_input; i++) {
        int k = (int)(r->pose[i] - LW_OF_X);
        out[i][0] = of[k], out[i][1] = rate[k], out[i][2] = k < 3 ? 0 : -angle*angle/4*of[k];
    }
    return LW_OK;
}

static const char not_held[] = "a posture in which the drives do not hold the tool";
static const char out_of_reach[] = "the limit of what the drives can reach";

/* Determinant of all rows, those of the drives among them, over their lengths: it is 0 where the drives lose the tool, and where the joints allow
 * several motions.  0: not known, since rows depend on others; an open chain. */
static double determinant_of_rows(lw_robot *r)
{
    const lw_space_rows_set *z = &r->follow.z;
    size_t n = (size_t)r->space.n_v;
    if (!r->square || z->n_row != r->space.n_v)
        return 0;
    double *diag = r->square + n*n;
    memset(r->square, 0, n*n*sizeof *r->square);
    for (int i = 0; i < z->n_row; i++) {
        double *row = r->square + (size_t)i*n, length = 0;
        for (int c = z->at[i]; c < z->at[i + 1]; c++) {
            int b = z->body[c/6];
            if (b >= 0)
                row[6*b + (c - z->at[i])%6] += z->jac[c];
        }
        for (size_t c = 0; c < n; c++)
            length = hypot(length, row[c]);
        for (size_t c = 0; c < n; c++)
            row[c] /= length;
    }
    lw_qr_factor((int)n, (int)n, r->square, diag);
    return lw_qr_determinant((int)n, diag);
}

/* As many drives as coordinates of the tool's pose that they command: its place, its turn, or both. */
static bool is_square(const lw_robot *r)
{
    bool flat = lw_v3_norm(r->normal) > 0;
    return r->n_drive == (flat ? (r->only_turns ? 0 : r->turns ? 3 : 2) : r->only_turns || !r->turns ? 3 : lw_v3_norm(r->spin) > 0 ? 4 : 6);
}

/* Determinant of the Jacobian of these coordinates. */
static double determinant(const lw_robot *r, const lw_robot_pose *p)
{
    double a[6*6], diag[6];
    int n = r->n_drive;
    bool flat = lw_v3_norm(r->normal) > 0, one = lw_v3_norm(r->spin) > 0;
    lw_vec3 right = lw_v3_across(r->normal), ahead = lw_v3_cross(r->normal, right);
    for (int i = 0; i < n; i++) {
        lw_vec3 v = lw_v3(p->jacobian[0][i], p->jacobian[1][i], p->jacobian[2][i]), w = lw_v3(p->jacobian[3][i], p->jacobian[4][i], p->jacobian[5][i]);
        double space[] = { v.x, v.y, v.z, one ? lw_v3_dot(r->spin, w) : w.x, w.y, w.z };
        double plane[] = { lw_v3_dot(right, v), lw_v3_dot(ahead, v), lw_v3_dot(r->normal, w) };
        memcpy(a + i*n, flat ? plane : space + (r->only_turns ? 3 : 0), (size_t)n*sizeof *a);
    }
    lw_qr_factor(n, n, a, diag);
    return lw_qr_determinant(n, diag);
}

/* Is the tool itself moved, and do the drives follow?  Otherwise the drives are moved until the tool is there. */
static bool is_pulled(const lw_robot *r) { return r->by_tool.memory && !(r->condition_limit > 0); }

/* The posture reached, for pulling the tool from there. */
static void begin_to_pull(lw_robot *r)
{
    lw_space_follow *f = &r->by_tool;
    memcpy(f->q, r->follow.q, (size_t)r->space.n_q*sizeof *f->q);
    if (r->space.n_coupling)
        memcpy(f->z.near + f->z.n_extra, r->follow.z.near + r->follow.z.n_extra, (size_t)r->space.n_joint*sizeof *f->z.near);
    r->space.from[r->tool] = r->follow.z.frame[r->space.tracer[r->tool].body + 1].turn;
}

/* Remember a failure that is no limit of the motion. */
static lw_status watched(lw_robot *r, lw_status s)
{
    if (s != LW_OK && s != LW_OPEN)
        r->broken = s;
    return s;
}

/* Rates of the drives where the tool is pulled: by the tool's pose, which is smooth where the drives lose the tool, or else, where the tool can move no
 * farther, by the drives. */
static bool fill_rates_pulled(lw_robot *r, double *a)
{
    lw_space_follow *const by[] = { &r->by_tool, &r->follow };
    for (int k = 0; k < 2; k++) {
        lw_space_follow *f = by[k];
        if (memcmp(f->z.filled, f->q, (size_t)r->space.n_q*sizeof *f->q) != 0)
            lw_space_rows_fill(&f->z, f->q, f->z.near);
        if (lw_space_hold_rates(&r->hold, f, r->measure, a))
            return true;
        if (f->z.n_kept < f->z.n_row                     /* the basis kept may be that of the end of another way */
            && (watched(r, lw_space_rows_arrange(&f->z, f->q, NULL)) != LW_OK || lw_space_hold_rates(&r->hold, f, r->measure, a)))
            return r->broken == LW_OK;
    }
    return false;
}

/* What moves in the posture reached while the drives stand still, which do not hold the tool there. */
static void tell_free_motion(lw_robot *r, char how[LW_SPACE_MOTION_TEXT])
{
    double a[LW_ROBOT_DRIVES*LW_ROBOT_DRIVES];
    int n = r->n_drive, n_v = r->space.n_v;
    if (!r->by_tool.memory)
        return;
    begin_to_pull(r);
    if (fill_rates_pulled(r, a) && lw_space_unheld(n, n_v, a, r->hold.column, r->hold.motions[1])) {
        lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
        lw_space_motion_text(&r->space, r->follow.z.frame, r->hold.motions[1], how);
    }
}

/* lw_space_hold_now.  0: not known; an open chain, whose drives lose nothing. */
static double drives_hold(lw_robot *r)
{
    double a[LW_ROBOT_DRIVES*LW_ROBOT_DRIVES];
    bool pulled = is_pulled(r);
    if (!r->square || (pulled && !fill_rates_pulled(r, a)))
        return 0;
    return lw_space_hold_now(&r->hold, pulled ? a : NULL);
}

/* How far may the next step go, after one of h over which r->hold.holds changed from `before`?  A second zero may be near a first one, so the first
 * has to fall between two steps. */
static double wary(const lw_robot *r, double before, double h)
{
    double now = r->hold.holds, rate = (now - before)/h;
    return before != 0 && now*rate < 0 ? fmax(-0.5*now/rate, SURE_STEP) : LONGEST_STEP;
}

/* The fastest motion or turn of the tool by a unit rate of a drive, in sizes: it grows without limit where the drives lose the tool. */
static double fastest(const lw_robot *r, const lw_robot_pose *p)
{
    double most = 0;
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < r->n_drive; i++)
            most = fmax(most, fabs(p->jacobian[k][i])*lw_space_scale(&r->space, r->measure[i])/(k < 3 ? r->space.unit : 1));
    return most;
}

/* drives_hold; where the Jacobian is not square, joints that allow several motions count, too. */
static double holds_now(lw_robot *r) { return is_pulled(r) || is_square(r) || r->follow.z.n_row != r->space.n_v ? drives_hold(r) : determinant_of_rows(r); }

/* Is the posture reached one in which the robot may be? */
static bool may_be_there(lw_robot *r)
{
    lw_robot_pose now;
    bool limited = r->condition_limit > 0;
    if (r->free)
        return true;
    if (!is_pulled(r) && watched(r, lw_robot_measure(r, &now, NULL)) != LW_OK) {
        snprintf(r->limit, sizeof r->limit, not_held);
        return false;
    }
    double det = limited && is_square(r) ? determinant(r, &now) : 0;
    if (limited && (now.condition > r->condition_limit || det*r->determinant < 0)) {
        snprintf(r->limit, sizeof r->limit, "the limit of the condition number");
        return false;
    }
    if (passed(r))
        return false;
    if (r->lost || lw_space_hold_lost(&r->hold, holds_now(r))) {
        snprintf(r->limit, sizeof r->limit, limited ? "the limit of the condition number" : not_held);
        return false;
    }
    r->determinant = det;
    return r->broken == LW_OK;
}

/* Along the way of the tool, step by step: drives measure the turn nearest to `near`, which is counted on, and whether they hold the tool is told by the
 * motions nearest to those of the step before (a crank may turn by half a turn while the tool passes its axis). */
static void see_way(void *context, const double *q)
{
    lw_robot *r = context;
    (void)q;
    for (int i = 0; i < r->n_drive; i++) {
        double *near = &r->follow.z.near[r->follow.n_idle + i];
        *near = lw_space_measure(&r->space, r->by_tool.z.frame, r->measure[i], *near, NULL);
    }
    double a[LW_ROBOT_DRIVES*LW_ROBOT_DRIVES];
    if (is_pulled(r) && r->square && !r->free && !r->lost && lw_space_hold_rates(&r->hold, &r->by_tool, r->measure, a))
        r->lost = lw_space_hold_lost(&r->hold, lw_space_hold_now(&r->hold, a));
}

/* As many drives as the tool's pose has coordinates: the tool itself is moved, and the drives follow.  *end: the links reach no farther, the tool is
 * where they do.  length: of the way there, as lw_robot_move counts. */
static bool pull_tool(lw_robot *r, lw_vec3 place, const lw_quaternion *turn, double length, bool *end)
{
    lw_space_follow *f = &r->by_tool;
    lw_quaternion now;
    begin_to_pull(r);
    tool_pose(r, &r->begin, &now);
    r->goal = place;
    r->spin_to_goal = r->turns ? lw_quaternion_vector(lw_quaternion_times(*turn, lw_quaternion_inverse(now))) : lw_v3(0, 0, 0);
    lw_vec3 across = lw_v3_cross(r->spin_to_goal, lw_v3_add(r->normal, r->spin));        /* turns that the robot does not have */
    if (lw_v3_norm(across) > CLOSE) {
        snprintf(r->limit, sizeof r->limit, out_of_reach);
        f->u = 0;
        return false;
    }
    f->u = 0;
    f->least = fmin(0.1*r->least/length, 0.1);
    f->passed = see_way;
    f->passed_by = r;
    *end = watched(r, lw_space_follow_to(f, to_pose, r, 1, NULL)) != LW_OK;
    memcpy(r->follow.q, f->q, (size_t)r->space.n_q*sizeof *f->q);
    lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
    if (r->space.n_coupling)
        memcpy(r->follow.z.near + r->follow.z.n_extra, f->z.near + f->z.n_extra, (size_t)r->space.n_joint*sizeof *f->z.near);
    if (!may_be_there(r)) {
        *end = false;
        return false;
    }
    if (*end)
        snprintf(r->limit, sizeof r->limit, "the limit of what the links can reach");
    return !*end;
}

/* Bring the tool to a near pose by Newton's method on the drives. */
static bool close_tool(lw_robot *r, lw_vec3 place, const lw_quaternion *turn)
{
    lw_robot_pose now;
    double error[6], change[LW_ROBOT_DRIVES], before = INFINITY;
    for (int round = 0; round < 12; round++) {
        if (watched(r, lw_robot_measure(r, &now, NULL)) != LW_OK) {
            snprintf(r->limit, sizeof r->limit, not_held);
            return false;
        }
        double far = pose_error(r, place, turn, error);
        if (far < CLOSE)
            return may_be_there(r);
        snprintf(r->limit, sizeof r->limit, out_of_reach);
        if (far > 0.7*before)
            return false;
        before = far;
        solve_drives(r, now.jacobian, error, change);
        lw_space_follow_values(&r->follow, r->drive);
        for (int i = 0; i < r->n_drive; i++) {
            double scale = lw_space_scale(&r->space, r->measure[i]);
            if (!(fabs(change[i]) < 0.5*scale))
                return false;
            r->drive[i] += change[i];
        }
        if (watched(r, go(r, NULL)) != LW_OK)
            return false;
    }
    return false;
}

/* A straight path of the tool, on which it turns about one axis, and the last posture on it that closes. */
typedef struct tool_path {
    lw_vec3       first, way, spin;    /* place at the start, from there to the end [m], rotation vector [rad] */
    lw_quaternion from;
    double        length, fastest;     /* over the unit, plus radians; `fastest` at the start               */
    double       *q, *near;            /* (n_q) (n_near) of the posture                                     */
} tool_path;

static void free_path(tool_path *p) { free(p->q), free(p->near); }

/* Free it after a failure too. */
static lw_status make_path(lw_robot *r, lw_vec3 place, const lw_quaternion *turn, tool_path *p)
{
    const lw_space *s = &r->space;
    *p = (tool_path){ .fastest = INFINITY };
    p->q = malloc((size_t)s->n_q*sizeof *p->q + 1);
    p->near = malloc((size_t)r->follow.z.n_near*sizeof *p->near + 1);
    if (!p->q || !p->near)
        return LW_E_MEMORY;
    lw_space_place(s, r->follow.q, r->follow.z.frame);
    tool_pose(r, &p->first, &p->from);
    p->way = lw_v3_sub(place, p->first);
    p->spin = lw_quaternion_vector(lw_quaternion_times(turn ? *turn : p->from, lw_quaternion_inverse(p->from)));
    p->length = lw_v3_norm(p->way)/s->unit + (r->turns ? lw_v3_norm(p->spin) : 0);
    return LW_OK;
}

static void keep_posture(const lw_robot *r, tool_path *p)
{
    memcpy(p->q, r->follow.q, (size_t)r->space.n_q*sizeof *p->q);
    memcpy(p->near, r->follow.z.near, (size_t)r->follow.z.n_near*sizeof *p->near);
}

static void go_back(lw_robot *r, const tool_path *p)
{
    memcpy(r->follow.q, p->q, (size_t)r->space.n_q*sizeof *p->q);
    memcpy(r->follow.z.near, p->near, (size_t)r->follow.z.n_near*sizeof *p->near);
    lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
    lw_space_hold_back(&r->hold);
    r->lost = false;
}

/* Measure the posture at the start: what the drives hold there, and how fast the tool is. */
static void measure_start(lw_robot *r, tool_path *p)
{
    lw_robot_pose begin;
    r->broken = LW_OK;
    r->determinant = 0;
    r->lost = false;
    lw_space_hold_begin(&r->hold);
    if (is_pulled(r)) {
        begin_to_pull(r);
        lw_space_hold_lost(&r->hold, holds_now(r));
    } else if (watched(r, lw_robot_measure(r, &begin, NULL)) == LW_OK) {
        r->determinant = is_square(r) ? determinant(r, &begin) : 0;
        lw_space_hold_lost(&r->hold, holds_now(r));
        p->fastest = fastest(r, &begin);
    }
}

/* LW_OPEN: the tool stops where it is, and why. */
static lw_status tell_stop(lw_robot *r, const tool_path *p, bool at_start, lw_error *e)
{
    lw_robot_pose pose;
    lw_vec3 place;
    lw_quaternion turn;
    bool measured = lw_robot_measure(r, &pose, NULL) == LW_OK;
    if (at_start && measured && pose.freedoms < r->freedoms)
        snprintf(r->limit, sizeof r->limit, "the posture is singular, and the drives cannot move it this way; begin from another one");
    else if (at_start && measured && isinf(pose.condition))
        snprintf(r->limit, sizeof r->limit, "the posture is singular, or the robot lacks this freedom; begin from another one");
    else if (strcmp(r->limit, out_of_reach) == 0 && (!measured || fastest(r, &pose) > 100*p->fastest))
        snprintf(r->limit, sizeof r->limit, not_held);           /* at the end of a reach the tool is not fast */
    tool_pose(r, &place, &turn);
    char turned[60] = "", how[LW_SPACE_MOTION_TEXT] = "";
    if (lw_v3_norm(p->spin) > 1e-12)
        snprintf(turned, sizeof turned, ", turned by %.6g of %.6g degrees",
                 lw_v3_norm(lw_quaternion_vector(lw_quaternion_times(turn, lw_quaternion_inverse(p->from))))*180/LW_PI, lw_v3_norm(p->spin)*180/LW_PI);
    const lw_units *units = &r->model->units;
    double by[3] = { place.x, place.y, place.z };
    for (int i = 0; i < 3; i++)                      /* rounding counts as 0 */
        by[i] = fabs(by[i]) < 1e-13*r->space.unit ? 0 : by[i]/units->metre;
    if (e && strcmp(r->limit, not_held) == 0)
        tell_free_motion(r, how);
    return lw_error_set(e, LW_OPEN, "the tool stops at (%.9g, %.9g, %.9g) %s%s: %s%s%s", by[0], by[1], by[2], units->length[0] ? units->length : "m",
                        turned, r->limit, *how ? "; while they stand still, " : "", how);
}

/* Move along the path in steps that are halved where they do not close. */
static lw_status go_along(lw_robot *r, tool_path *p, lw_error *e)
{
    double at = 0, h = fmin(p->length, 0.5*LONGEST_STEP);
    while (at < p->length) {
        h = fmin(h, r->condition_limit > 0 ? CONDITION_STEP : LONGEST_STEP);
        double next = fmin(at + h, p->length), before = r->hold.holds, part = next/p->length;
        lw_quaternion turn = lw_quaternion_times(lw_quaternion_of_vector(lw_v3_scale(p->spin, part)), p->from);
        lw_vec3 place = lw_v3_add(p->first, lw_v3_scale(p->way, part));
        bool end = false;
        keep_posture(r, p);
        lw_space_hold_keep(&r->hold);
        bool closed = r->by_tool.memory ? pull_tool(r, place, &turn, next - at, &end) : close_tool(r, place, &turn);
        if (closed) {
            h = fmin(2*h, wary(r, before, next - at));
            at = next;
        }
        if (r->broken != LW_OK)
            return lw_error_set(e, r->broken, "the tool could not be moved: %s", lw_status_text(r->broken));
        if (closed)
            continue;
        if (r->by_tool.memory && !end)           /* the links themselves may have ended the step early */
            h = fmax(fmin(h, r->by_tool.u*(next - at)), r->least);
        if (end)
            keep_posture(r, p);
        go_back(r, p);
        h *= end ? 0 : 0.5;
        if (h < r->least)
            return tell_stop(r, p, at == 0, e);
    }
    r->limit[0] = 0;
    return LW_OK;
}

lw_status lw_robot_move(lw_robot *r, lw_vec3 place, const lw_quaternion *turn, lw_error *e)
{
    tool_path p;
    lw_status s = make_path(r, place, turn, &p);
    if (s == LW_OK) {
        measure_start(r, &p);
        s = r->broken == LW_OK ? go_along(r, &p, e)
          : lw_error_set(e, r->broken, "the tool could not be moved: %s", lw_status_text(r->broken));
    } else
        lw_error_set(e, s, "out of memory");
    free_path(&p);
    return s;
}

lw_status lw_robot_reach(lw_robot *r, lw_vec3 direction, double most, double *far, lw_error *e)
{
    lw_vec3 first, last;
    lw_quaternion turn;
    lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
    tool_pose(r, &first, &turn);
    lw_status s = lw_robot_move(r, lw_v3_add(first, lw_v3_scale(direction, most)), NULL, e);
    lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
    tool_pose(r, &last, &turn);
    *far = lw_v3_norm(lw_v3_sub(last, first));
    return s == LW_OPEN ? LW_OK : s;
}

lw_status lw_robot_tilt(lw_robot *r, lw_vec3 axis, double most, double *far, lw_error *e)
{
    lw_vec3 place;
    lw_quaternion first, last;
    lw_space_place(&r->space, r->follow.q, r->follow.z.frame);
    tool_pose(r, &place, &first);
    lw_quaternion to = lw_quaternion_times(lw_quaternion_of_vector(lw_v3_scale(axis, most)), first);
    lw_status s = lw_robot_move(r, place, &to, e);
    last = lw_robot_turn(r);
    *far = lw_v3_norm(lw_quaternion_vector(lw_quaternion_times(last, lw_quaternion_inverse(first))));
    return s == LW_OPEN ? LW_OK : s;
}
