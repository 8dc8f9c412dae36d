/* mbs/space/space_rows.c - rows of spatial joints.
 *
 * Rows are made of three kinds, with a, b vectors fixed in body 0 and body 1, d = p1 - p0 between the joint's points:
 *
 *     e . d            e fixed in the ground        common point
 *     a . d            a carried by body 0          a line or a plane
 *     a . b            turns
 *
 * With omega in ground axes  (a . b)' = (omega0 - omega1) . (a x b)  and  (a . d)' = omega0 . (a x d) + a . d'. */
#include "mbs/space/space.h"

#include <string.h>

typedef struct ends {            /* of a joint at one posture */
    double  unit;                /* of translations */
    lw_vec3 arm[2], d;           /* from the centres of mass to the points; between the points */
    const lw_mat3 *turn[2];
} ends;

static ends ends_of(const lw_space *s, const lw_space_joint *j, const lw_space_frame *frame)
{
    ends n = { .unit = s->unit };
    for (int i = 0; i < 2; i++) {
        n.turn[i] = &frame[j->body[i] + 1].turn;
        n.arm[i] = lw_m3_apply(n.turn[i], j->arm[i]);
    }
    n.d = lw_v3_sub(lw_v3_add(frame[j->body[1] + 1].at, n.arm[1]), lw_v3_add(frame[j->body[0] + 1].at, n.arm[0]));
    return n;
}

static void put(double *to, const ends *n, int end, lw_vec3 force, lw_vec3 moment)
{
    lw_vec3 m = lw_m3_unapply(n->turn[end], moment);
    to[0] = n->unit*force.x, to[1] = n->unit*force.y, to[2] = n->unit*force.z, to[3] = m.x, to[4] = m.y, to[5] = m.z;
}

static void point_row(const ends *n, lw_vec3 e, double scale, double *phi, double *jac)
{
    *phi = scale*lw_v3_dot(e, n->d);
    e = lw_v3_scale(e, scale);
    put(jac, n, 0, lw_v3_scale(e, -1), lw_v3_cross(e, n->arm[0]));
    put(jac + 6, n, 1, e, lw_v3_cross(n->arm[1], e));
}

static void line_row(const ends *n, lw_vec3 a, double scale, double *phi, double *jac)
{
    *phi = scale*lw_v3_dot(a, n->d);
    a = lw_v3_scale(a, scale);
    put(jac, n, 0, lw_v3_scale(a, -1), lw_v3_cross(a, lw_v3_add(n->d, n->arm[0])));
    put(jac + 6, n, 1, a, lw_v3_cross(n->arm[1], a));
}

static void turn_row(const ends *n, lw_vec3 a, lw_vec3 b, double fixed, double *phi, double *jac)
{
    lw_vec3 c = lw_v3_cross(a, b), none = lw_v3(0, 0, 0);
    *phi = lw_v3_dot(a, b) - fixed;
    put(jac, n, 0, none, c);
    put(jac + 6, n, 1, none, lw_v3_scale(c, -1));
}

/* Angle from x[0] to x[1] about z[0], the one nearest to `near`, and its derivatives. */
static double angle_of(const lw_space_joint *j, const ends *n, double near, double *jac)
{
    lw_vec3 x0 = lw_m3_apply(n->turn[0], j->x[0]), y0 = lw_m3_apply(n->turn[0], j->y[0]);
    lw_vec3 x1 = lw_m3_apply(n->turn[1], j->x[1]), axis = lw_m3_apply(n->turn[0], j->z[0]), none = lw_v3(0, 0, 0);
    double angle = atan2(lw_v3_dot(y0, x1), lw_v3_dot(x0, x1));
    if (jac) {
        put(jac, n, 0, none, lw_v3_scale(axis, -1));
        put(jac + 6, n, 1, none, axis);
    }
    double off = angle - near;
    return near + (fabs(off) < LW_PI ? off : remainder(off, 2*LW_PI));
}

static int point_rows(const ends *n, double scale, double *phi, double *jac)
{
    for (int i = 0; i < 3; i++)
        point_row(n, lw_v3(i == 0, i == 1, i == 2), scale, phi + i, jac + i*LW_SPACE_ROW);
    return 3;
}

/* z[0] stays parallel to z[1]. */
static int parallel_rows(const lw_space_joint *j, const ends *n, double *phi, double *jac)
{
    lw_vec3 z = lw_m3_apply(n->turn[1], j->z[1]);
    turn_row(n, lw_m3_apply(n->turn[0], j->x[0]), z, 0, phi, jac);
    turn_row(n, lw_m3_apply(n->turn[0], j->y[0]), z, 0, phi + 1, jac + LW_SPACE_ROW);
    return 2;
}

static int line_rows(const lw_space_joint *j, const ends *n, double scale, double *phi, double *jac)
{
    line_row(n, lw_m3_apply(n->turn[0], j->x[0]), scale, phi, jac);
    line_row(n, lw_m3_apply(n->turn[0], j->y[0]), scale, phi + 1, jac + LW_SPACE_ROW);
    return 2;
}

void lw_space_joint_rows(const lw_space *s, int joint, const lw_space_frame *frame, double *phi, double *jac)
{
    const lw_space_joint *j = &s->joint[joint];
    ends n = ends_of(s, j, frame);
    double scale = 1/s->unit;
    int r = 0;
#define PHI phi + r, jac + r*LW_SPACE_ROW
    switch (j->kind) {
    case LW_SPATIAL_SPHERICAL:
        point_rows(&n, scale, PHI);
        break;
    case LW_SPATIAL_REVOLUTE:
        r += point_rows(&n, scale, PHI);
        parallel_rows(j, &n, PHI);
        break;
    case LW_SPATIAL_UNIVERSAL:
        r += point_rows(&n, scale, PHI);
        turn_row(&n, lw_m3_apply(n.turn[0], j->x[0]), lw_m3_apply(n.turn[1], j->x[1]), j->fixed, PHI);
        break;
    case LW_SPATIAL_FIXED:
    case LW_SPATIAL_PRISMATIC:
        r += j->kind == LW_SPATIAL_FIXED ? point_rows(&n, scale, PHI) : line_rows(j, &n, scale, PHI);
        r += parallel_rows(j, &n, PHI);
        turn_row(&n, lw_m3_apply(n.turn[0], j->y[0]), lw_m3_apply(n.turn[1], j->x[1]), 0, PHI);
        break;
    case LW_SPATIAL_CYLINDRICAL:
    case LW_SPATIAL_SCREW:
        r += line_rows(j, &n, scale, PHI);
        r += parallel_rows(j, &n, PHI);
        if (j->kind == LW_SPATIAL_SCREW) {   /* slide less pitch times the turn nearest to it */
            double turn[LW_SPACE_ROW], slide;
            line_row(&n, lw_m3_apply(n.turn[0], j->z[0]), scale, &slide, jac + r*LW_SPACE_ROW);
            phi[r] = slide - scale*j->pitch*angle_of(j, &n, slide/(scale*j->pitch), turn);
            for (int i = 0; i < LW_SPACE_ROW; i++)
                jac[r*LW_SPACE_ROW + i] -= scale*j->pitch*turn[i];
        }
        break;
    case LW_SPATIAL_PLANAR:
        line_row(&n, lw_m3_apply(n.turn[0], j->z[0]), scale, PHI);
        r++;
        parallel_rows(j, &n, PHI);
        break;
    case LW_SPATIAL_FREE:
        break;
    }
#undef PHI
}

void lw_space_rows(const lw_space *s, const lw_space_frame *frame, double *phi, double *jac)
{
    for (int i = 0; i < s->n_joint; i++)
        lw_space_joint_rows(s, i, frame, phi + s->joint[i].row, jac + s->joint[i].row*LW_SPACE_ROW);
}

/* ---- what velocities add ------------------------------------------------------------------------------- */

typedef struct rates { lw_vec3 omega[2], dd, rest; } rates;     /* rest: d'' without the accelerations */

static rates rates_of(const lw_space_joint *j, const ends *n, const lw_space_frame *frame, const double *v)
{
    rates z;
    lw_vec3 dp[2], ddp[2];
    for (int i = 0; i < 2; i++) {
        int b = j->body[i];
        z.omega[i] = lw_space_omega(frame, b, v);
        lw_vec3 turn = lw_v3_cross(z.omega[i], n->arm[i]);
        dp[i] = b < 0 ? turn : lw_v3_add(turn, lw_v3_scale(lw_v3(v[6*b], v[6*b + 1], v[6*b + 2]), n->unit));
        ddp[i] = lw_v3_cross(z.omega[i], turn);
    }
    z.dd = lw_v3_sub(dp[1], dp[0]);
    z.rest = lw_v3_sub(ddp[1], ddp[0]);
    return z;
}

/* Second rate of a . d, without the accelerations; a carried by body 0. */
static double line_bias(const rates *z, const ends *n, lw_vec3 a)
{
    lw_vec3 da = lw_v3_cross(z->omega[0], a);
    return lw_v3_dot(lw_v3_cross(z->omega[0], da), n->d) + 2*lw_v3_dot(da, z->dd) + lw_v3_dot(a, z->rest);
}

static double turn_bias(const rates *z, lw_vec3 a, lw_vec3 b)
{
    lw_vec3 da = lw_v3_cross(z->omega[0], a), db = lw_v3_cross(z->omega[1], b);
    return lw_v3_dot(lw_v3_sub(z->omega[0], z->omega[1]), lw_v3_add(lw_v3_cross(da, b), lw_v3_cross(a, db)));
}

static double angle_bias(const lw_space_joint *j, const rates *z, const ends *n)
{
    lw_vec3 axis = lw_m3_apply(n->turn[0], j->z[0]);
    return lw_v3_dot(lw_v3_cross(z->omega[0], axis), lw_v3_sub(z->omega[1], z->omega[0]));
}

void lw_space_joint_bias(const lw_space *s, int joint, const lw_space_frame *frame, const double *v, double *to)
{
    double scale = 1/s->unit;
    const lw_space_joint *j = &s->joint[joint];
    lw_spatial_kind k = j->kind;
    if (k == LW_SPATIAL_FREE)
        return;
    ends n = ends_of(s, j, frame);
    rates z = rates_of(j, &n, frame, v);
    lw_vec3 x0 = lw_m3_apply(n.turn[0], j->x[0]), y0 = lw_m3_apply(n.turn[0], j->y[0]);
    lw_vec3 z0 = lw_m3_apply(n.turn[0], j->z[0]), z1 = lw_m3_apply(n.turn[1], j->z[1]);
    if (k == LW_SPATIAL_SPHERICAL || k == LW_SPATIAL_REVOLUTE || k == LW_SPATIAL_UNIVERSAL || k == LW_SPATIAL_FIXED) {
        to[0] = -scale*z.rest.x, to[1] = -scale*z.rest.y, to[2] = -scale*z.rest.z;
        to += 3;
    } else if (k == LW_SPATIAL_PLANAR)
        *to++ = -scale*line_bias(&z, &n, z0);
    else {
        *to++ = -scale*line_bias(&z, &n, x0);
        *to++ = -scale*line_bias(&z, &n, y0);
    }
    if (k == LW_SPATIAL_SPHERICAL)
        return;
    if (k == LW_SPATIAL_UNIVERSAL) {
        *to = -turn_bias(&z, x0, lw_m3_apply(n.turn[1], j->x[1]));
        return;
    }
    *to++ = -turn_bias(&z, x0, z1);
    *to++ = -turn_bias(&z, y0, z1);
    if (k == LW_SPATIAL_FIXED || k == LW_SPATIAL_PRISMATIC)
        *to = -turn_bias(&z, y0, lw_m3_apply(n.turn[1], j->x[1]));
    if (k == LW_SPATIAL_SCREW)
        *to = -scale*(line_bias(&z, &n, z0) - j->pitch*angle_bias(j, &z, &n));
}

double lw_space_coupling_bias(const lw_space *s, int coupling, const lw_space_frame *frame, const double *v)
{
    const lw_space_coupling *c = &s->coupling[coupling];
    double sum = 0;
    for (int i = 0; i < c->n; i++) {
        const lw_space_term *t = &c->term[i];
        ends n = ends_of(s, &t->joint, frame);
        rates z = rates_of(&t->joint, &n, frame, v);
        sum -= t->factor*(t->turn ? angle_bias(&t->joint, &z, &n) : line_bias(&z, &n, lw_m3_apply(n.turn[0], t->joint.z[0]))/s->unit);
    }
    return sum;
}

void lw_space_bias(const lw_space *s, const lw_space_frame *frame, const double *v, double *out)
{
    for (int i = 0; i < s->n_joint; i++)
        lw_space_joint_bias(s, i, frame, v, out + s->joint[i].row);
    for (int i = 0; i < s->n_coupling; i++)
        out[s->n_joint_row + i] = lw_space_coupling_bias(s, i, frame, v);
}

/* ---- measures ---------------------------------------------------------------------------------------------- */

double lw_space_scale(const lw_space *s, lw_spatial_measure of)
{
    return of.of == LW_OF_TURN || of.of >= LW_OF_TURN_X ? 1 : s->unit;
}

void lw_space_bodies(const lw_space *s, const lw_space_extra *x, int body[2])
{
    body[1] = -1;
    if (x->spin)
        body[0] = x->body;
    else if (x->measure.of >= LW_OF_X)
        body[0] = s->tracer[x->measure.index].body;
    else
        body[0] = s->joint[x->measure.index].body[0], body[1] = s->joint[x->measure.index].body[1];
}

static lw_vec3 ground_axis(lw_spatial_of of)
{
    return lw_v3(of == LW_OF_X || of == LW_OF_TURN_X, of == LW_OF_Y || of == LW_OF_TURN_Y, of == LW_OF_Z || of == LW_OF_TURN_Z);
}

/* How the body of a tracer has turned since s->from, in ground axes. */
static lw_quaternion turned_by(const lw_space *s, const lw_space_frame *frame, int tracer)
{
    const lw_mat3 *from = &s->from[tracer], back = lw_m3_columns(from->row[0], from->row[1], from->row[2]);
    lw_mat3 turn = lw_m3_times(&frame[s->tracer[tracer].body + 1].turn, &back);
    return lw_quaternion_of_matrix(&turn);
}

/* Twice a coordinate of the vector of that quaternion, whose rate is (w omega + omega x vector)/2. */
static double turn_of_tracer(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double *jac)
{
    lw_quaternion q = turned_by(s, frame, of.index);
    lw_vec3 e = ground_axis(of.of), vector = lw_v3(q.x, q.y, q.z);
    if (jac) {
        lw_vec3 m = lw_v3_add(lw_v3_scale(e, q.w), lw_v3_cross(vector, e));
        m = lw_m3_unapply(&frame[s->tracer[of.index].body + 1].turn, m);
        const double row[LW_SPACE_ROW] = { 0, 0, 0, m.x, m.y, m.z };
        memcpy(jac, row, sizeof row);
    }
    return 2*lw_v3_dot(e, vector);
}

double lw_space_measure(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double near, double *jac)
{
    double none[LW_SPACE_ROW], value;
    if (of.of >= LW_OF_TURN_X)
        return turn_of_tracer(s, frame, of, jac);
    if (of.of >= LW_OF_X) {
        lw_space_point p = s->tracer[of.index];
        const lw_space_frame *f = &frame[p.body + 1];
        lw_vec3 e = ground_axis(of.of), arm = lw_m3_apply(&f->turn, p.arm);
        if (jac) {
            lw_vec3 m = lw_v3_scale(lw_m3_unapply(&f->turn, lw_v3_cross(arm, e)), 1/s->unit);
            const double row[LW_SPACE_ROW] = { e.x, e.y, e.z, m.x, m.y, m.z };
            memcpy(jac, row, sizeof row);
        }
        return lw_v3_dot(e, lw_v3_add(f->at, arm))/s->unit;
    }
    const lw_space_joint *j = &s->joint[of.index];
    ends n = ends_of(s, j, frame);
    if (of.of == LW_OF_TURN)
        return angle_of(j, &n, near, jac);
    line_row(&n, lw_m3_apply(n.turn[0], j->z[0]), 1/s->unit, &value, jac ? jac : none);
    return value;
}

double lw_space_measure_bias(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, const double *v)
{
    if (of.of >= LW_OF_X) {
        lw_space_point p = s->tracer[of.index];
        lw_vec3 omega = lw_space_omega(frame, p.body, v), arm = lw_m3_apply(&frame[p.body + 1].turn, p.arm);
        if (of.of >= LW_OF_TURN_X) {
            lw_quaternion q = turned_by(s, frame, of.index);
            return -0.5*lw_v3_dot(omega, omega)*lw_v3_dot(ground_axis(of.of), lw_v3(q.x, q.y, q.z));
        }
        return lw_v3_dot(ground_axis(of.of), lw_v3_cross(omega, lw_v3_cross(omega, arm)))/s->unit;
    }
    const lw_space_joint *j = &s->joint[of.index];
    ends n = ends_of(s, j, frame);
    rates z = rates_of(j, &n, frame, v);
    return of.of == LW_OF_TURN ? angle_bias(j, &z, &n) : line_bias(&z, &n, lw_m3_apply(n.turn[0], j->z[0]))/s->unit;
}

void lw_space_measured(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double near,
                       const double *v,
                       double *value, double *rate)
{
    double jac[LW_SPACE_ROW], scale = lw_space_scale(s, of);
    int body[2];
    lw_space_bodies(s, &(lw_space_extra){ .measure = of }, body);
    *value = scale*lw_space_measure(s, frame, of, near, jac);
    *rate = 0;
    for (int k = 0; k < 2; k++)
        for (int i = 0; body[k] >= 0 && i < 6; i++)
            *rate += scale*jac[6*k + i]*v[6*body[k] + i];
}

/* ---- couplings -------------------------------------------------------------------------------------------- */

/* The sum, and its derivatives unless jac is NULL.  Angles are known but for whole turns, here those near `turn`.  The joint with the least factor turns
 * fastest, more than half a turn in a step where it is geared up.  Its whole turns are those that bring the sum nearest to 0: by the angle
 * *more [rad] beyond those near `turn`, of joint *fastest (-1: none turns). */
static double coupling_sum(const lw_space *s, const lw_space_coupling *c, const lw_space_frame *frame, const double *turn, double *jac, int *fastest,
                           double *more)
{
    double sum = 0, least = INFINITY;
    *fastest = -1;
    *more = 0;
    for (int i = 0; i < c->n; i++) {
        const lw_space_term *t = &c->term[i];
        ends n = ends_of(s, &t->joint, frame);
        double value, row[LW_SPACE_ROW];
        if (t->turn)
            value = angle_of(&t->joint, &n, turn[t->index], row);
        else
            line_row(&n, lw_m3_apply(n.turn[0], t->joint.z[0]), 1/s->unit, &value, row);
        if (t->turn && fabs(t->factor) < fabs(least))
            least = t->factor, *fastest = t->index;
        sum += t->factor*(value - t->start);
        for (int k = 0; jac && k < LW_SPACE_ROW; k++)
            if (t->side[k/6] >= 0)
                jac[6*t->side[k/6] + k%6] += t->factor*row[k];
    }
    if (*fastest >= 0)
        *more = -2*LW_PI*round(sum/(2*LW_PI*least));
    return *fastest >= 0 ? sum + least**more : sum;
}

void lw_space_coupling_row(const lw_space *s, int coupling, const lw_space_frame *frame, const double *turn, double *phi, double *jac)
{
    const lw_space_coupling *c = &s->coupling[coupling];
    int fastest;
    double more;
    memset(jac, 0, 6*(size_t)c->n_side*sizeof *jac);
    *phi = coupling_sum(s, c, frame, turn, jac, &fastest, &more);
}

void lw_space_count_turns(const lw_space *s, const lw_space_frame *frame, double *turn)
{
    for (int j = 0; j < s->n_joint; j++)
        if (lw_spatial_kind_of(s->joint[j].kind)->turns)
            turn[j] = lw_space_measure(s, frame, (lw_spatial_measure){ LW_OF_TURN, j }, turn[j], NULL);
    for (int i = 0; i < s->n_coupling; i++) {
        int fastest;
        double more;
        coupling_sum(s, &s->coupling[i], frame, turn, NULL, &fastest, &more);
        if (more != 0)
            turn[fastest] += more;
    }
}

/* ---- second derivatives ------------------------------------------------------------------------------------- */

/* A displacement of the two bodies of a joint: of their centres [m], turns about their own axes. */
typedef struct small { lw_vec3 move[2], turn[2]; } small;

static small unit_displacement(const lw_space *s, int c)
{
    small d = { { { 0, 0, 0 } }, { { 0, 0, 0 } } };
    lw_vec3 e = lw_v3(c%3 == 0, c%3 == 1, c%3 == 2);
    if (c%6 < 3)
        d.move[c/6] = lw_v3_scale(e, s->unit);
    else
        d.turn[c/6] = e;
    return d;
}

static void put_change(const ends *n, lw_vec3 pull, lw_vec3 moment0, lw_vec3 moment1, double *out)
{
    const double all[12] = { -n->unit*pull.x, -n->unit*pull.y, -n->unit*pull.z, moment0.x, moment0.y, moment0.z,
                             n->unit*pull.x, n->unit*pull.y, n->unit*pull.z, moment1.x, moment1.y, moment1.z };
    memcpy(out, all, sizeof all);
}

/* Changes of the derivatives of point_row, line_row, turn_row and angle_of; a, b in the axes of the bodies that carry them. */
static void point_change(const lw_space_joint *j, const ends *n, lw_vec3 e, const small *d, double *out)
{
    lw_vec3 e0 = lw_m3_unapply(n->turn[0], e), e1 = lw_m3_unapply(n->turn[1], e);
    put_change(n, lw_v3(0, 0, 0), lw_v3_cross(lw_v3_cross(e0, d->turn[0]), j->arm[0]),
               lw_v3_cross(j->arm[1], lw_v3_cross(e1, d->turn[1])), out);
}

static void line_change(const lw_space_joint *j, const ends *n, lw_vec3 a, const small *d, double *out)
{
    lw_vec3 da = lw_m3_apply(n->turn[0], lw_v3_cross(d->turn[0], a)), own = lw_m3_unapply(n->turn[1], lw_m3_apply(n->turn[0], a));
    lw_vec3 y = lw_m3_unapply(n->turn[0], lw_v3_add(n->d, n->arm[0]));
    lw_vec3 moved = lw_v3_sub(lw_v3_add(d->move[1], lw_m3_apply(n->turn[1], lw_v3_cross(d->turn[1], j->arm[1]))), d->move[0]);
    lw_vec3 dy = lw_v3_add(lw_m3_unapply(n->turn[0], moved), lw_v3_cross(y, d->turn[0]));
    lw_vec3 down = lw_v3_add(lw_m3_unapply(n->turn[1], da), lw_v3_cross(own, d->turn[1]));
    put_change(n, da, lw_v3_cross(a, dy), lw_v3_cross(j->arm[1], down), out);
}

static void turn_change(const ends *n, lw_vec3 a, lw_vec3 b, const small *d, double *out)
{
    lw_vec3 b0 = lw_m3_unapply(n->turn[0], lw_m3_apply(n->turn[1], b)), a1 = lw_m3_unapply(n->turn[1], lw_m3_apply(n->turn[0], a));
    lw_vec3 db = lw_m3_unapply(n->turn[0], lw_m3_apply(n->turn[1], lw_v3_cross(d->turn[1], b)));
    lw_vec3 da = lw_m3_unapply(n->turn[1], lw_m3_apply(n->turn[0], lw_v3_cross(d->turn[0], a)));
    db = lw_v3_add(db, lw_v3_cross(b0, d->turn[0]));
    da = lw_v3_add(da, lw_v3_cross(a1, d->turn[1]));
    put_change(n, lw_v3(0, 0, 0), lw_v3_cross(a, db), lw_v3_cross(b, da), out);
}

static void angle_change(const lw_space_joint *j, const ends *n, const small *d, double *out)
{
    lw_vec3 z1 = lw_m3_unapply(n->turn[1], lw_m3_apply(n->turn[0], j->z[0]));
    lw_vec3 dz = lw_m3_unapply(n->turn[1], lw_m3_apply(n->turn[0], lw_v3_cross(d->turn[0], j->z[0])));
    put_change(n, lw_v3(0, 0, 0), lw_v3(0, 0, 0), lw_v3_add(dz, lw_v3_cross(z1, d->turn[1])), out);
}

/* Row k of a joint. */
static void row_change(const lw_space *s, const lw_space_joint *j, const ends *n, int k, const small *d, double *out)
{
    double scale = 1/s->unit;
    bool holds_point = j->kind == LW_SPATIAL_SPHERICAL || j->kind == LW_SPATIAL_REVOLUTE || j->kind == LW_SPATIAL_UNIVERSAL ||
                       j->kind == LW_SPATIAL_FIXED;
    int line = holds_point ? 3 : j->kind == LW_SPATIAL_PLANAR ? 1 : 2;
    if (k < line && holds_point)
        point_change(j, n, lw_v3(scale*(k == 0), scale*(k == 1), scale*(k == 2)), d, out);
    else if (k < line)
        line_change(j, n, lw_v3_scale(line == 1 ? j->z[0] : k == 0 ? j->x[0] : j->y[0], scale), d, out);
    else if (j->kind == LW_SPATIAL_UNIVERSAL)
        turn_change(n, j->x[0], j->x[1], d, out);
    else if (k < line + 2)
        turn_change(n, k == line ? j->x[0] : j->y[0], j->z[1], d, out);
    else if (j->kind == LW_SPATIAL_SCREW) {
        double turn[12];
        line_change(j, n, lw_v3_scale(j->z[0], scale), d, out);
        angle_change(j, n, d, turn);
        for (int i = 0; i < 12; i++)
            out[i] -= scale*j->pitch*turn[i];
    } else
        turn_change(n, j->y[0], j->x[1], d, out);
}

int lw_space_row_bends(const lw_space *s, const lw_space_frame *frame, int joint, int k, lw_space_bend *out)
{
    int count = 0;
    const lw_space_joint *j = &s->joint[joint];
    ends n = ends_of(s, j, frame);
    for (int b = 0; b < 12; b++) {
        double change[12];
        small d = unit_displacement(s, b);
        if (j->body[b/6] < 0)
            continue;
        row_change(s, j, &n, k, &d, change);
        for (int a = 0; a < 12; a++)
            if (change[a] != 0 && j->body[a/6] >= 0)
                out[count++] = (lw_space_bend){ 6*j->body[a/6] + a%6, 6*j->body[b/6] + b%6, change[a] };
    }
    return count;
}

int lw_space_coupling_bends(const lw_space *s, const lw_space_frame *frame, int coupling, lw_space_bend *out)
{
    const lw_space_coupling *c = &s->coupling[coupling];
    int count = 0;
    for (int i = 0; i < c->n; i++) {
        const lw_space_term *t = &c->term[i];
        ends n = ends_of(s, &t->joint, frame);
        for (int b = 0; b < 12; b++) {
            double change[12];
            small d = unit_displacement(s, b);
            if (t->side[b/6] < 0)
                continue;
            if (t->turn)
                angle_change(&t->joint, &n, &d, change);
            else
                line_change(&t->joint, &n, lw_v3_scale(t->joint.z[0], 1/s->unit), &d, change);
            for (int a = 0; a < 12; a++)
                if (change[a] != 0 && t->side[a/6] >= 0)
                    out[count++] = (lw_space_bend){ 6*t->joint.body[a/6] + a%6, 6*t->joint.body[b/6] + b%6, t->factor*change[a] };
        }
    }
    return count;
}

void lw_space_measure_bends(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double h[12][12])
{
    const lw_space_joint *j = of.of >= LW_OF_X ? NULL : &s->joint[of.index];
    ends n = { 0 };
    if (j)
        n = ends_of(s, j, frame);
    for (int b = 0; b < 12; b++) {
        double change[12] = { 0 };
        small d = unit_displacement(s, b);
        if (of.of == LW_OF_TURN)
            angle_change(j, &n, &d, change);
        else if (of.of == LW_OF_SLIDE)
            line_change(j, &n, lw_v3_scale(j->z[0], 1/s->unit), &d, change);
        else {
            lw_space_point p = s->tracer[of.index];
            lw_vec3 own = lw_m3_unapply(&frame[p.body + 1].turn, ground_axis(of.of));
            lw_vec3 m = lw_v3_scale(lw_v3_cross(p.arm, lw_v3_cross(own, d.turn[0])), 1/s->unit);
            change[3] = m.x, change[4] = m.y, change[5] = m.z;
        }
        for (int a = 0; a < 12; a++)
            h[a][b] = change[a];
    }
}

/* ---- names --------------------------------------------------------------------------------------------------- */

/* Row k of a joint. */
static const char *name_of_row(const lw_space_joint *j, int k)
{
    static const char *const point[] = { "x", "y", "z", "tilt 1", "tilt 2", "turn" };
    static const char *const line[] = { "across 1", "across 2", "tilt 1", "tilt 2", "turn" };
    static const char *const plane[] = { "off the plane", "tilt 1", "tilt 2" };
    switch (j->kind) {
    case LW_SPATIAL_PLANAR: return plane[k];
    case LW_SPATIAL_SCREW: return k == 4 ? "lead" : line[k];
    case LW_SPATIAL_PRISMATIC: case LW_SPATIAL_CYLINDRICAL: return line[k];
    case LW_SPATIAL_UNIVERSAL: return k == 3 ? "turn" : point[k];
    default: return point[k];
    }
}

const char *lw_space_row_name(const lw_space *s, int row, int *joint)
{
    for (int i = 0; i < s->n_joint; i++) {
        int k = row - s->joint[i].row;
        if (k < 0 || k >= lw_spatial_kind_of(s->joint[i].kind)->rows)
            continue;
        *joint = i;
        return name_of_row(&s->joint[i], k);
    }
    *joint = s->n_joint + row - s->n_joint_row;
    return row >= s->n_joint_row && row < s->n_row ? "sum" : "";
}

bool lw_space_row_turns(const lw_space *s, int joint, int k)
{
    return name_of_row(&s->joint[joint], k)[0] == 't';       /* tilt, turn */
}
