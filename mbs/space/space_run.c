/* mbs/space/space_run.c - runs of spatial models. */
#include "mbs/space/space_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "mbs/ode/cvode.h"

struct lw_space_run {
    const lw_spatial *m;
    lw_space_options  o;
    lw_space          s;
    lw_space_forces   f;
    lw_space_rows_set z;         /* joints, spins, inputs with a motion                                      */
    lw_space_rows_set drives;    /* joints, spins, drives: which carries the forces of a driven run          */
    bool              has_drives, by_rank;
    int               n_idle, n_driven, *driven;
    lw_space_follow   follow;    /* of a driven run                                                           */
    lw_space_dense    dense;     /* by rank: J^T, and for reactions that are not unique                      */
    int               freedom;
    double *q, *v, *a, *l, *force, *target, *rhs, *rates, *y, *null, *mass_null, *small, *input, *input_rate, *drive;
    double (*path)[3];
    lw_space_reaction *joint;
    void   *memory;
    lw_space_report r;
    lw_space_moment_sink *sink;
    void   *context;
    lw_error *e;
    double energy0, potential0, energy_off, energy_least;
    int    next;
    long   n_busy;
};

lw_space_options lw_space_options_default(void)
{
    return (lw_space_options){ .to = 1, .intervals = 100, .relative = 1e-10 };
}

const lw_space        *lw_space_run_space(const lw_space_run *r) { return &r->s; }
const lw_space_report *lw_space_run_report(const lw_space_run *r) { return &r->r; }

void lw_space_run_free(lw_space_run *r)
{
    if (!r)
        return;
    lw_space_rows_free(&r->z);
    lw_space_rows_free(&r->drives);
    lw_space_follow_free(&r->follow);
    lw_space_dense_free(&r->dense);
    lw_space_forces_free(&r->f);
    lw_space_free(&r->s);
    free(r->memory);
    free(r->driven);
    free(r);
}

static bool is_driven(const lw_space_run *r) { return r->r.formulation == LW_SPACE_DRIVEN; }

const char *lw_space_formulation_name(lw_space_formulation f)
{
    static const char *const names[] = { "auto", "driven", "index1", "cvode", "equilibrium" };
    return names[f];
}

/* ---- making -------------------------------------------------------------------------------------------------- */

static lw_status reserve(lw_space_run *r, lw_error *e)
{
    size_t q = (size_t)r->s.n_q, v = (size_t)r->s.n_v, in = (size_t)r->m->n_input + (size_t)r->m->n_drive + 1;
    size_t extras = (size_t)r->s.n_body + in, rows = (size_t)r->s.n_row + extras, free_max = v;
    size_t joints = (size_t)r->m->n_joint;
    size_t null = r->by_rank ? v*free_max : 0, bytes;
    double **const to[] = { &r->q, &r->v, &r->a, &r->l, &r->force, &r->target, &r->rhs, &r->rates, &r->y, &r->null,
                            &r->mass_null, &r->small, &r->input, &r->input_rate, &r->drive };
    const size_t n[] = { q, v, v, rows, v, extras, rows, rows, q + v + 1, null, null, 2*v + 2*rows, in, in, in };
    size_t all = 0;
    for (size_t i = 0; i < sizeof n/sizeof *n; i++)
        all += n[i];
    bytes = (all + 3*in)*sizeof(double) + joints*sizeof *r->joint;
    double *at = r->memory = calloc(1, bytes);
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < sizeof n/sizeof *n; i++) {
        *to[i] = at;
        at += n[i];
    }
    r->path = (double (*)[3])(void *)at, at += 3*in;
    r->joint = (lw_space_reaction *)(void *)at;
    return LW_OK;
}

/* Spins that are held need an inertia, which does not act. */
static void weigh(lw_space_run *r, const lw_space_extra *idle, double *weight)
{
    const lw_space *s = &r->s;
    for (int i = 0; i < s->n_v; i++)
        weight[i] = s->mass[i];
    for (int i = 0; i < r->n_idle; i++) {
        double *w = weight + 6*idle[i].body + 3, top = fmax(w[0], fmax(w[1], w[2]));
        const double axis[] = { idle[i].axis.x, idle[i].axis.y, idle[i].axis.z };
        for (int k = 0; k < 3; k++)
            if (w[k] == 0 && fabs(axis[k]) > 1 - 1e-12)
                w[k] = top;
    }
    r->by_rank = false;
    for (int i = 0; i < s->n_v; i++)
        r->by_rank = r->by_rank || !(weight[i] > 0);
    for (int i = 0; i < s->n_v; i++)
        weight[i] = r->by_rank ? 1 : 1/weight[i];
}

static lw_status check_model(const lw_spatial *m, lw_error *e)
{
    for (int j = 0; j < m->n_joint; j++) {
        const lw_joint_stop *p = &m->joint[j].stop;
        if ((p->has_least || p->has_greatest) && !(p->stiffness > 0))
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" has a rigid stop, which spatial models do not know: give "
                                              "it a "
                                "\"stiffness\" [N/m or N m/rad]", m->joint[j].name);
    }
    return LW_OK;
}

/* A spin that is held changes nothing where the body is symmetric about its axis and not set spinning.  Others run. */
static int keep_exact_spins(const lw_space_run *r, lw_space_extra *x)
{
    int n = 0;
    for (int i = 0; i < r->n_idle; i++) {
        const double *inertia = r->s.mass + 6*x[i].body + 3;
        const double axis[] = { fabs(x[i].axis.x), fabs(x[i].axis.y), fabs(x[i].axis.z) };
        int k = axis[0] > axis[1] && axis[0] > axis[2] ? 0 : axis[1] > axis[2] ? 1 : 2;
        double a = inertia[(k + 1)%3], b = inertia[(k + 2)%3];
        bool along = axis[k] > 1 - 1e-12 || fabs(a - inertia[k]) + fabs(b - inertia[k]) <= 1e-12*a;
        if (along && fabs(a - b) <= 1e-9*fmax(a, b) && !r->m->body[r->s.link_of[x[i].body]].has_omega)
            x[n++] = x[i];
    }
    return n;
}

/* Are there as many motions of inputs as freedoms that are not spins between balls? */
static bool every_freedom_is_driven(const lw_space_run *r)
{
    int motions = 0, rows = r->s.n_row + r->n_idle;
    for (int i = 0; i < r->m->n_input; i++)
        motions += r->m->input[i].motion != NULL;
    return motions > 0 && motions >= r->s.n_v - rows;
}

/* Rows with the inputs that have a motion. */
static lw_status make_rows(lw_space_run *r, lw_error *e)
{
    const lw_spatial *m = r->m;
    size_t v = (size_t)r->s.n_v;
    lw_space_extra *x = calloc((size_t)r->s.n_body + (size_t)m->n_input + (size_t)m->n_drive + 1, sizeof *x);
    double *weight = calloc(v + 1, sizeof *weight), *metric = calloc(v + 1, sizeof *metric);
    r->driven = calloc((size_t)m->n_input + 1, sizeof *r->driven);
    lw_status st = x && weight && metric && r->driven ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        lw_space_metric(&r->s, metric);
        r->n_idle = lw_space_idle(&r->s, x);
        if (!every_freedom_is_driven(r))
            r->n_idle = keep_exact_spins(r, x);
        weigh(r, x, weight);
        for (int i = 0; i < m->n_input; i++)
            if (m->input[i].motion) {
                x[r->n_idle + r->n_driven] = (lw_space_extra){ .measure = m->input[i].measure };
                r->driven[r->n_driven++] = i;
            }
        st = lw_space_rows_make(&r->s, x, r->n_idle + r->n_driven, weight, r->s.start, &r->z, e);
    }
    if (st == LW_OK) {
        lw_space_rows_set joints;
        st = lw_space_rows_make(&r->s, x, r->n_idle, metric, r->s.start, &joints, e);
        if (st == LW_OK) {
            if (r->z.n_kept < joints.n_kept + r->n_driven)
                st = lw_error_set(e, LW_E_ARG, "%d inputs with a motion move only %d of %d freedoms in the posture "
                                               "of the file: "
                                  "they contradict each other, or the posture is singular for them", r->n_driven,
                                  r->z.n_kept - joints.n_kept, r->s.n_v - joints.n_kept);
            r->r.redundant = r->s.n_row + r->n_idle - joints.n_kept;
            r->r.freedom = r->s.n_v - joints.n_kept;
            r->freedom = r->s.n_v - r->z.n_kept;
            r->r.idle = r->n_idle;
            lw_space_rows_free(&joints);
        }
    }
    if (st == LW_OK && m->n_drive > 0) {
        for (int i = 0; i < m->n_drive; i++)
            x[r->n_idle + i] = (lw_space_extra){ .measure = m->drive[i] };
        r->has_drives = true;
        st = lw_space_rows_make(&r->s, x, r->n_idle + m->n_drive, metric, r->s.start, &r->drives, e);
        int independent = r->s.n_v - r->r.freedom;
        if (st == LW_OK && r->freedom == 0 && r->drives.n_kept < independent + m->n_drive)
            st = lw_error_set(e, LW_E_ARG, "%d drives carry only %d forces in the posture of the file: there are "
                                           "more drives than "
                              "freedoms, so that their forces are not unique, or the posture is singular for them",
                                  m->n_drive,
                              r->drives.n_kept - independent);
    }
    free(x), free(weight), free(metric);
    return st;
}

/* ---- motions of the inputs --------------------------------------------------------------------------------------- */

/* Targets of the rows at t; the rates that the rows want (order 1) or their second rates (order 2), into out
 * (n_row). */
static lw_status aim(lw_space_run *r, double t)
{
    lw_status st = lw_space_motions((void *)(uintptr_t)r->m, t, r->path);
    for (int i = 0; i < r->n_driven && st == LW_OK; i++) {
        const double *p = r->path[r->driven[i]];
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) {
            char name[64];
            lw_spatial_measure_name(r->m, r->m->input[r->driven[i]].measure, name, sizeof name);
            return lw_error_set(r->e, LW_E_NUMERIC, "the motion of input \"%s\" is not a number at t = %.9g s", name,
                                t);
        }
        r->target[r->n_idle + i] = p[0]/lw_space_scale(&r->s, r->m->input[r->driven[i]].measure);
    }
    return st;
}

static void wanted(lw_space_run *r, int rate, double *out)
{
    if (rate == 1)
        memset(out, 0, (size_t)r->z.n_row*sizeof *out);
    for (int i = 0; i < r->n_driven; i++) {
        double scale = lw_space_scale(&r->s, r->m->input[r->driven[i]].measure);
        out[r->s.n_row + r->n_idle + i] += r->path[r->driven[i]][rate]/scale;
    }
}

/* ---- accelerations ---- */

/* Cholesky's method on N^T M N, N an orthonormal basis of the motions that the rows allow, and the free part of a. */
static lw_status add_free(lw_space_run *r, double *a)
{
    const lw_space *s = &r->s;
    int n = s->n_v - r->dense.rank.rank, v = s->n_v;
    double *m = r->mass_null, *b = r->small, top = 0;
    for (int i = 0; i < n; i++) {
        lw_rank_left_null(&r->dense.rank, i, r->null + i*v);
        for (int k = 0; k < v; k++)
            r->null[i*v + k] *= sqrt(r->z.weight[k]);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (int k = 0; k < v; k++)
                sum += r->null[i*v + k]*s->mass[k]*r->null[j*v + k];
            for (int k = 0; k < j; k++)
                sum -= m[i*n + k]*m[j*n + k];
            top = i == j ? fmax(top, sum) : top;
            if (j < i)
                m[i*n + j] = sum/m[j*n + j];
            else if (!(sum > 1e-13*top)) {
                int worst = 0;
                for (int k = 0; k < v; k++)
                    worst = fabs(r->null[i*v + k]) > fabs(r->null[i*v + worst]) ? k : worst;
                return lw_error_set(r->e, LW_E_ARG, "link \"%s\" can move without moving any mass: give it a "
                                                    "\"mass\" and an "
                                    "\"inertia\", or hold it", r->m->body[s->link_of[worst/6]].name);
            } else
                m[i*n + i] = sqrt(sum);
        }
    for (int i = 0; i < n; i++) {
        b[i] = 0;
        for (int k = 0; k < v; k++)
            b[i] += r->null[i*v + k]*(r->force[k] - s->mass[k]*a[k]);
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= m[i*n + k]*b[k];
        b[i] /= m[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= m[k*n + i]*b[k];
        b[i] /= m[i*n + i];
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < v; k++)
            a[k] += b[i]*r->null[i*v + k];
    return LW_OK;
}

/* l of least norm with J^T l = force - M a, by the factors of r->dense, made from z. */
static void carry_least(lw_space_run *r, const lw_space_rows_set *z, const double *a, double *l)
{
    double *b = r->small;
    for (int i = 0; i < r->s.n_v; i++)
        b[i] = (r->force[i] - r->s.mass[i]*a[i])*sqrt(z->weight[i]);
    lw_rank_solve(&r->dense.rank, b, l);
}

/* a and l at a posture and velocity whose rows are filled and factored. */
static lw_status accelerate(lw_space_run *r, double t, const double *v, double *a, double *l, double *power)
{
    lw_space_forces_apply(&r->f, t, r->z.frame, v, r->force, power);
    lw_space_rows_bias(&r->z, v, r->rhs);
    wanted(r, 2, r->rhs);
    if (!r->by_rank) {
        lw_space_rows_solve(&r->z, r->force, r->rhs, false, a, l);
        return LW_OK;
    }
    r->dense.rank.most = r->z.n_kept;
    lw_space_dense_factor(&r->z, &r->dense, 1e-10);
    double *b = r->small;
    memcpy(b, r->rhs, (size_t)r->z.n_row*sizeof *b);
    lw_rank_solve_transposed(&r->dense.rank, b, a);
    for (int i = 0; i < r->s.n_v; i++)
        a[i] *= sqrt(r->z.weight[i]);
    lw_status st = add_free(r, a);
    if (st == LW_OK)
        carry_least(r, &r->z, a, l);
    return st;
}

static lw_status rows_at(lw_space_run *r, double t, const double *q)
{
    lw_status st = aim(r, t);
    if (st != LW_OK)
        return st;
    lw_space_rows_fill(&r->z, q, r->target);
    return lw_space_rows_factor(&r->z) ? LW_OK : LW_OPEN;
}

/* Put q and v on the rows; the rows are left filled and factored at q. */
static lw_status settle(lw_space_run *r, double t, double *q, double *v)
{
    lw_space_normalise(&r->s, q);
    lw_status st = aim(r, t);
    if (st == LW_OK)
        st = lw_space_rows_close(&r->z, q, r->target, 0.5, NULL);
    if (st == LW_OK)
        st = rows_at(r, t, q);
    if (st != LW_OK)
        return st;
    wanted(r, 1, r->rates);
    lw_space_rows_correct(&r->z, r->rates, v);
    return LW_OK;
}

/* ---- samples ---- */

/* Do the drives carry the forces, in place of inputs that leave no freedom? */
static bool drives_carry(const lw_space_run *r) { return r->has_drives && r->freedom == 0; }

static void reactions(lw_space_run *r, const double *l)
{
    const lw_space *s = &r->s;
    const lw_space_rows_set *z = drives_carry(r) ? &r->drives : is_driven(r) ? &r->follow.z : &r->z;
    for (int i = 0; i < s->n_joint; i++) {
        const lw_space_joint *j = &s->joint[i];
        lw_vec3 load[2] = { { 0, 0, 0 }, { 0, 0, 0 } }, twist[2] = { { 0, 0, 0 }, { 0, 0, 0 } };
        for (int k = 0; k < lw_spatial_kind_of(j->kind)->rows; k++)
            for (int end = 0; end < 2; end++) {
                const double *jac = z->jac + (j->row + k)*LW_SPACE_ROW + 6*end;
                double f = -l[j->row + k];
                load[end] = lw_v3_add(load[end], lw_v3_scale(lw_v3(jac[0], jac[1], jac[2]), f/s->unit));
                twist[end] = lw_v3_add(twist[end], lw_v3_scale(lw_v3(jac[3], jac[4], jac[5]), f));
            }
        lw_vec3 p[2];
        for (int end = 0; end < 2; end++)
            p[end] = lw_space_point_at(z->frame, (lw_space_point){ j->body[end], j->arm[end] });
        int end = j->body[1] >= 0 ? 1 : 0;   /* from the side that is a body, about its centre,
            to the point on link[1] */
        lw_vec3 about = lw_m3_apply(&z->frame[j->body[end] + 1].turn, twist[end]);
        lw_vec3 lever = lw_v3_sub(z->frame[j->body[end] + 1].at, p[1]);
        about = lw_v3_add(about, lw_v3_cross(lever, load[end]));
        r->joint[i].force = lw_v3_scale(load[end], end == 1 ? 1 : -1);
        r->joint[i].moment = lw_v3_scale(about, end == 1 ? 1 : -1);
    }
}

/* The drives of a driven run: l (n_row of drives) with J^T l = Q - M a. */
static lw_status load_drives(lw_space_run *r, double t, const double *q, const double *a)
{
    lw_space_rows_set *z = &r->drives;
    double most = 0, left = 0, *b = r->small;
    lw_space_rows_fill(z, q, NULL);
    if (!lw_space_rows_factor(z))
        return LW_OPEN;
    for (int i = 0; i < r->s.n_v; i++)
        b[i] = r->force[i] - r->s.mass[i]*a[i];
    lw_space_rows_carry(z, b, r->l);
    for (int i = 0; i < r->s.n_v; i++) {
        most = fmax(most, fabs(b[i])*sqrt(z->weight[i]));
        b[i] = -b[i];
    }
    lw_space_rows_add(z, 1, r->l, b);
    for (int i = 0; i < r->s.n_v; i++)
        left = fmax(left, fabs(b[i])*sqrt(z->weight[i]));
    if (left > 1e-7*most + 1e-12)
        return lw_error_set(r->e, LW_E_ARG, "at t = %.9g s the drives cannot move the model: %.3g of %.3g N m "
                                            "(forces times the "
                            "size) are left; are there as many drives as inputs?", t, left, most);
    for (int i = 0; i < r->m->n_drive; i++)
        r->drive[i] = -r->l[r->s.n_row + r->n_idle + i]/lw_space_scale(&r->s, r->m->drive[i]);
    return LW_OK;
}

/* Hand out the moment (t, q, v) with a and l, whose rows are filled at q. */
static lw_status hand_out(lw_space_run *r, double t, const double *q, const double *v, const double *a, double work)
{
    const lw_spatial *m = r->m;
    const lw_space_rows_set *z = is_driven(r) ? &r->follow.z : &r->z;
    lw_space_moment out = { .t = t, .q = q, .v = v, .a = a, .frame = z->frame, .input = r->input, .input_rate =
                            r->input_rate,
                            .drive = r->drive, .joint = r->joint, .work = work };
    bool tool = drives_carry(r);
    lw_space_rows_times(z, v, r->rates);
    wanted(r, 1, r->rhs);
    for (int i = 0; i < z->n_row; i++) {
        out.off = fmax(out.off, fabs(z->phi[i]));
        out.off_rate = fmax(out.off_rate, fabs(r->rates[i] - r->rhs[i]));
    }
    if (!tool && r->r.redundant > 0 && (is_driven(r) || !r->by_rank)) {
        r->dense.rank.most = z->n_kept;
        lw_space_dense_factor(z, &r->dense, 1e-10);
        carry_least(r, z, a, r->l);
    }
    lw_status st = tool ? load_drives(r, t, q, a) : LW_OK;
    if (st == LW_OPEN)
        return lw_error_set(r->e, LW_OPEN, "at t = %.9g s the drives cannot hold the posture: it is singular for them",
                            t);
    if (st != LW_OK)
        return st;
    for (int i = 0; i < m->n_input; i++) {
        lw_spatial_measure of = m->input[i].measure;
        double near = of.of == LW_OF_TURN ? r->f.turn[of.index] : 0;
        lw_space_measured(&r->s, z->frame, of, near, v, &r->input[i], &r->input_rate[i]);
        r->input[i] += lw_spatial_offset(&m->input[i]);
    }
    for (int i = 0; i < m->n_input && !r->has_drives; i++)
        r->drive[i] = 0;                     /* drives that carry nothing run freely: 0 */
    for (int i = 0; i < r->n_driven && !r->has_drives; i++)
        r->drive[r->driven[i]] = -r->l[r->s.n_row + r->n_idle + i]/lw_space_scale(&r->s,
                                                                                  m->input[r->driven[i]].measure);
    reactions(r, r->l);
    out.kinetic = lw_space_kinetic(&r->s, v);
    out.potential = lw_space_potential(&r->f, z->frame);
    r->r.samples++;
    r->r.worst_off = fmax(r->r.worst_off, out.off);
    r->r.worst_off_rate = fmax(r->r.worst_off_rate, out.off_rate);
    r->r.t = t;
    return r->sink ? r->sink(r->context, &out) : LW_OK;
}

static double sample_time(const lw_space_run *r, int k)
{
    return k == r->o.intervals ? r->o.to : r->o.from + (r->o.to - r->o.from)*k/r->o.intervals;
}

static lw_status check_limits(lw_space_run *r, double t, bool look_at_clock)
{
    if (r->o.stop && *r->o.stop)
        return lw_error_set(r->e, LW_STOPPED, "stopped at t = %.9g s", t);
    if (r->o.until > 0 && look_at_clock && lw_clock_wall() > r->o.until)
        return lw_error_set(r->e, LW_STOPPED, "the time allowed was used up at t = %.9g s", t);
    return LW_OK;
}

/* ---- driven ---- */

static lw_status motions(void *context, double t, double (*out)[3])
{
    lw_space_run *r = context;
    lw_status st = lw_space_motions((void *)(uintptr_t)r->m, t, r->path);
    for (int i = 0; i < r->n_driven; i++)
        memcpy(out[i], r->path[r->driven[i]], sizeof *out);
    return st;
}

static lw_status run_driven(lw_space_run *r)
{
    lw_space_follow *f = &r->follow;
    lw_status st = LW_OK;
    for (int k = 0; st == LW_OK && k <= r->o.intervals; k++) {
        double t = sample_time(r, k);
        if ((st = check_limits(r, t, true)) != LW_OK || (st = lw_space_follow_to(f, motions, r, t, r->e)) != LW_OK)
            break;
        lw_space_forces_accept(&r->f, f->z.frame);
        memcpy(r->v, f->v, (size_t)r->s.n_v*sizeof *r->v);
        memcpy(r->a, f->a, (size_t)r->s.n_v*sizeof *r->a);
        bool still = r->o.analysis == LW_SPACE_QUASISTATIC;
        lw_space_forces_apply(&r->f, t, f->z.frame, r->v, r->force, NULL);
        if (still) {                         /* forces without inertia: neither accelerations nor gyroscopic ones */
            double *none = r->small;
            memset(none, 0, (size_t)r->s.n_v*sizeof *none);
            lw_space_forces_apply(&r->f, t, f->z.frame, none, r->force, NULL);
            memset(r->a, 0, (size_t)r->s.n_v*sizeof *r->a);
        }
        for (int i = 0; i < r->s.n_v; i++)
            r->y[i] = r->force[i] - r->s.mass[i]*r->a[i];
        if (!r->has_drives)
            lw_space_rows_carry(&f->z, r->y, r->l);
        st = hand_out(r, t, f->q, r->v, r->a, NAN);
        r->r.steps++;
    }
    return st;
}

/* ---- in time ---- */

static bool has_work(const lw_space_run *r) { return !r->f.conservative || r->n_driven > 0; }

static lw_status rate(void *context, double t, const double *y, double *dy)
{
    lw_space_run *r = context;
    int q = r->s.n_q, n = q + r->s.n_v;
    double power = 0;
    lw_status st = check_limits(r, t, (++r->n_busy & 255) == 0);
    if (st == LW_OK)
        st = rows_at(r, t, y);
    if (st == LW_OK)
        st = accelerate(r, t, y + q, dy + q, r->l, &power);
    if (st != LW_OK)
        return st;
    lw_space_rates(&r->s, y, y + q, dy);
    if (has_work(r)) {
        for (int i = 0; i < r->n_driven; i++)
            power -= r->l[r->s.n_row + r->n_idle + i]*r->path[r->driven[i]][1]/lw_space_scale(&r->s,
                    r->m->input[r->driven[i]].measure);
        dy[n] = power;
    }
    return LW_OK;
}

static lw_status project(void *context, double t, double *y)
{
    static const double beside = 1e-7;
    lw_space_run *r = context;
    lw_status st = settle(r, t, y, y + r->s.n_q);
    if (st == LW_OK && r->z.weak < beside && r->z.n_kept < r->z.n_row)
        st = lw_space_rows_arrange(&r->z, y, r->e);
    if (st == LW_OK) {
        lw_space_place(&r->s, y, r->z.frame);
        lw_space_forces_accept(&r->f, r->z.frame);
    }
    return st;
}

static lw_status show(lw_space_run *r, double t, double *y)
{
    int q = r->s.n_q, n = q + r->s.n_v;
    lw_status st = settle(r, t, y, y + q);
    if (st == LW_OK)
        st = accelerate(r, t, y + q, r->a, r->l, NULL);
    if (st != LW_OK)
        return st == LW_OPEN ? lw_error_set(r->e, st, "at t = %.9g s the model stands in a singular posture, from "
                                                      "which it can "
                                            "go on in several ways", t) : st;
    return hand_out(r, t, y, y + q, r->a, has_work(r) ? y[n] : 0);
}

/* Follow the energy.  A step over a singular posture can end on another branch: then the energy jumps, which ends the
 * run. */
static lw_status watch(lw_space_run *r, double t, const double *y)
{
    static const double jump = 1e-4, jump_share = 1e6;   /* of the greatest energy; the same over the tolerance */
    int q = r->s.n_q, n = q + r->s.n_v;
    lw_space_place(&r->s, y, r->z.frame);
    double kinetic = lw_space_kinetic(&r->s, y + q), potential = lw_space_potential(&r->f, r->z.frame);
    if (r->r.samples == 0)
        r->energy0 = kinetic + potential, r->potential0 = potential;
    double off = kinetic + potential - r->energy0 - (has_work(r) ? y[n] : 0), before = r->energy_off;
    r->energy_off = off;
    r->r.energy_error = fmax(r->r.energy_error, fabs(off));
    r->r.energy_scale = fmax(r->r.energy_scale, fmax(kinetic, fabs(potential - r->potential0)));
    if (r->r.samples == 0) {                 /* at rest: what forces do over the size */
        memset(r->small, 0, (size_t)r->s.n_v*sizeof *r->small);
        lw_space_forces_apply(&r->f, t, r->z.frame, y + q, r->small, NULL);
        for (int i = 0; i < r->s.n_v; i++)
            r->energy_least += fabs(r->small[i]);
    }
    if (fabs(off - before) <= (jump + jump_share*r->o.relative)*fmax(r->r.energy_scale, r->energy_least))
        return LW_OK;
    return lw_error_set(r->e, LW_E_NUMERIC, "at t = %.9g s the energy changes by %.3g of %.3g J in one step: the "
                                            "model passes "
                        "a singular posture, or the tolerance is too great", t, off - before, r->r.energy_scale);
}

/* One of two integrators. */
typedef struct stepper { bool implicit; lw_integrator e; lw_cvode i; double t; const double *y; } stepper;

static lw_status begin(stepper *w, const lw_ode *ode, const lw_ode_options *o, double *work, double t, const double *y,
                       lw_error *e)
{
    return w->implicit ? lw_cvode_make(&w->i, ode, o, LW_CVODE_BDF, t, y, e) : lw_integrate_start(&w->e, ode, o, work,
            t, y, e);
}

static lw_status step(stepper *w, double end, lw_ode_stop *stop, lw_space_report *r, lw_error *e)
{
    lw_status st = w->implicit ? lw_cvode_step(&w->i, end, stop, e) : lw_integrate_step(&w->e, end, stop, e);
    r->t = w->t = w->implicit ? w->i.t : w->e.t;
    w->y = w->implicit ? w->i.y : w->e.y;
    r->steps = w->implicit ? w->i.n_step : w->e.n_step;
    r->refused = w->implicit ? w->i.n_refused : w->e.n_refused;
    r->rates = w->implicit ? w->i.n_rate : w->e.n_rate;
    return st;
}

static lw_status dense(stepper *w, double t, double *y)
{
    return w->implicit ? lw_cvode_dense(&w->i, t, y) : lw_integrate_dense(&w->e, t, y);
}

static lw_status run_in_time(lw_space_run *r)
{
    int q = r->s.n_q, v = r->s.n_v, n = q + v + has_work(r);
    stepper w = { .implicit = r->r.formulation == LW_SPACE_CVODE };
    lw_ode ode = { .n = n, .context = r, .rate = rate, .project = project };
    lw_ode_options o = lw_ode_options_default();
    lw_ode_stop stop = LW_ODE_STEP;
    double *each = malloc((size_t)n*sizeof *each), *work = calloc(lw_integrate_work(n, 0), sizeof *work), *y = r->y;
    lw_status st = each && work ? LW_OK : lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    bool begun = false;
    for (int i = 0; each && i < n; i++)
        each[i] = r->o.relative*(i < q ? i%7 < 3 ? 1 : 0.5 : 1);
    memcpy(y, r->q, (size_t)q*sizeof *y);
    memcpy(y + q, r->v, (size_t)v*sizeof *y);
    if (has_work(r)) {
        y[n - 1] = 0;
        if (each)
            each[n - 1] = r->o.relative*fmax(1e-6, lw_space_kinetic(&r->s, r->v));
    }
    o.relative = o.absolute = r->o.relative;
    o.absolute_each = each;
    o.smooth = true;
    o.max_step = 0;
    watch(r, r->o.from, y);
    if (st == LW_OK)
        st = show(r, r->o.from, y);
    if (st == LW_OK)
        begun = (st = begin(&w, &ode, &o, work, r->o.from, y, r->e)) == LW_OK;
    r->next = 1;
    while (st == LW_OK && stop != LW_ODE_END) {
        st = step(&w, r->o.to, &stop, &r->r, r->e);
        if (st != LW_OK)
            break;
        st = watch(r, w.t, w.y);
        while (st == LW_OK && r->next <= r->o.intervals && sample_time(r, r->next) <= w.t) {
            double at = sample_time(r, r->next);
            if (at == w.t)
                memcpy(y, w.y, (size_t)n*sizeof *y);
            else
                st = dense(&w, at, y);
            if (st == LW_OK)
                st = show(r, at, y);
            r->next++;
        }
        if (st == LW_OK && r->o.max_step > 0 && r->r.steps + r->r.refused >= r->o.max_step && stop != LW_ODE_END)
            st = lw_error_set(r->e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", w.t, r->o.max_step);
    }
    if (begun && w.implicit)
        lw_cvode_free(&w.i);
    if (st == LW_E_NUMERIC && r->z.weak < 1e-6)
        st = lw_error_set(r->e, st, "at t = %.9g s the model comes to a singular posture, and no motion was found "
                                    "behind it", r->r.t);
    free(each), free(work);
    return st;
}

/* ---- start ---- */

/* Go from the posture of the file to where the motions begin, as straight as the joints allow. */
static lw_status start_posture(lw_space_run *r, lw_error *e)
{
    lw_spatial_measure *input = calloc((size_t)r->n_driven + 1, sizeof *input);
    if (!input)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < r->n_driven; i++)
        input[i] = r->m->input[r->driven[i]].measure;
    lw_status st = lw_space_follow_make(&r->s, input, r->n_driven, true, &r->follow, e);
    free(input);
    r->follow.u = r->o.from;
    if (st == LW_OK)
        st = lw_space_follow_to(&r->follow, motions, r, r->o.from, e);
    if (st == LW_OK)
        memcpy(r->q, r->follow.q, (size_t)r->s.n_q*sizeof *r->q);
    return st;
}

/* The velocities that satisfy the joints, the motions and the speeds, and keep those that links are given. */
static lw_status start_velocity(lw_space_run *r, lw_error *e)
{
    const lw_spatial *m = r->m;
    const lw_space *s = &r->s;
    lw_space_rows_set z;
    lw_space_extra *x = calloc((size_t)r->z.n_extra + (size_t)m->n_input + 1, sizeof *x);
    double *weight = malloc(((size_t)s->n_v + 1)*sizeof *weight), *rhs = NULL, top = 0, off = 0;
    int n = r->z.n_extra, worst = 0;
    if (!x || !weight) {
        free(x), free(weight);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    memcpy(x, r->z.extra, (size_t)n*sizeof *x);
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].has_speed)
            x[n++] = (lw_space_extra){ .measure = m->input[i].measure };
    memcpy(weight, r->z.weight, (size_t)s->n_v*sizeof *weight);
    lw_space_place(s, r->q, r->z.frame);
    for (int b = 0; b < s->n_body; b++) {
        const lw_spatial_body *p = &m->body[s->link_of[b]];
        lw_vec3 w = lw_m3_unapply(&r->z.frame[b + 1].turn, p->omega);
        double *v = r->v + 6*b, given[6] = { p->velocity.x/s->unit, p->velocity.y/s->unit, p->velocity.z/s->unit, w.x, w.y, w.z };
        for (int i = 0; i < 6; i++) {
            bool has = i < 3 ? p->has_velocity : p->has_omega;
            v[i] = has ? given[i] : 0;
            weight[6*b + i] = has ? 0 : weight[6*b + i];
            top = fmax(top, fabs(v[i]));
        }
    }
    lw_status st = lw_space_rows_make(s, x, n, weight, r->q, &z, e);
    if (st == LW_OK && !(rhs = calloc(2*(size_t)z.n_row + 1, sizeof *rhs)))
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && (st = aim(r, r->o.from)) == LW_OK) {
        wanted(r, 1, rhs);
        for (int i = 0, k = r->z.n_row; i < m->n_input; i++)
            if (m->input[i].has_speed)
                rhs[k++] = m->input[i].speed/lw_space_scale(s, m->input[i].measure);
        lw_space_rows_fill(&z, r->q, NULL);
        lw_space_rows_factor(&z);
        lw_space_rows_correct(&z, rhs, r->v);
        lw_space_rows_correct(&z, rhs, r->v);
        double *got = rhs + z.n_row;
        lw_space_rows_times(&z, r->v, got);
        for (int i = 0; i < z.n_row; i++) {
            top = fmax(top, fabs(rhs[i]));
            if (fabs(got[i] - rhs[i]) > off)
                off = fabs(got[i] - rhs[i]), worst = i;
        }
        if (!(off <= 1e-9*top + 1e-12)) {
            int joint;
            lw_space_row_name(s, worst, &joint);
            st = lw_error_set(e, LW_E_ARG, "the speeds and velocities given contradict each other%s%s%s: they are "
                                           "off by %.3g (of "
                              "%.3g), lengths over the size of the model", joint >= 0 ? " at joint \"" : "",
                              joint >= 0 ? m->joint[joint].name : "", joint >= 0 ? "\"" : "", off, top);
        }
    }
    lw_space_rows_free(&z);
    free(x), free(weight), free(rhs);
    return st;
}

/* ---- static ---- */

/* Forces along the motions that the rows allow at q: out (n) along basis, n_v x n; both made at q. */
static lw_status free_forces(lw_space_run *r, double t, const double *q, const double *basis, int n, double *out)
{
    const lw_space *s = &r->s;
    lw_status st = rows_at(r, t, q);
    if (st != LW_OK)
        return st;
    double *none = r->small;
    memset(none, 0, (size_t)s->n_v*sizeof *none);
    lw_space_forces_apply(&r->f, t, r->z.frame, none, r->force, NULL);
    for (int k = 0; k < n; k++) {            /* basis is of another posture: take what the rows allow of it */
        for (int i = 0; i < s->n_v; i++)
            r->a[i] = basis[k*s->n_v + i];
        memset(r->rates, 0, (size_t)r->z.n_row*sizeof *r->rates);
        lw_space_rows_correct(&r->z, r->rates, r->a);
        out[k] = 0;
        for (int i = 0; i < s->n_v; i++)
            out[k] += r->a[i]*r->force[i];
    }
    return LW_OK;
}

static bool solve_small(int n, double *a, double *b)
{
    for (int i = 0; i < n; i++) {
        int p = i;
        for (int k = i + 1; k < n; k++)
            p = fabs(a[k*n + i]) > fabs(a[p*n + i]) ? k : p;
        if (!(fabs(a[p*n + i]) > 0))
            return false;
        for (int k = 0; k < n && p != i; k++) {
            double x = a[i*n + k];
            a[i*n + k] = a[p*n + k], a[p*n + k] = x;
        }
        double x = b[i];
        b[i] = b[p], b[p] = x;
        for (int k = i + 1; k < n; k++) {
            double c = a[k*n + i]/a[i*n + i];
            for (int j = i; j < n; j++)
                a[k*n + j] -= c*a[i*n + j];
            b[k] -= c*b[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= a[i*n + k]*b[k];
        b[i] /= a[i*n + i];
    }
    return true;
}

/* Is the symmetric part of a, with `shift` added to its diagonal, positive definite?  work (n*n). */
static bool is_positive(int n, const double *a, double shift, double *work)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double sum = (a[i*n + j] + a[j*n + i])/2 + (i == j ? shift : 0);
            for (int k = 0; k < j; k++)
                sum -= work[i*n + k]*work[j*n + k];
            if (i == j && !(sum > 0))
                return false;
            work[i*n + j] = i == j ? sqrt(sum) : sum/work[j*n + j];
        }
    return true;
}

/* Newton's method in the freedoms, with stiffnesses by central differences along closed postures.  Where the
 * stiffness is not positive definite, a multiple of the unit matrix is added, so that steps go downhill. */
static lw_status run_static(lw_space_run *r)
{
    const lw_space *s = &r->s;
    int n = r->freedom, v = s->n_v;
    double t = r->o.from, h = 1e-6, *basis = malloc(((size_t)n*(size_t)v + 1)*sizeof *basis), last = INFINITY, shift =
        0;
    double *g = malloc((3*(size_t)n + (size_t)n*(size_t)n + 2*(size_t)n*(size_t)n + (size_t)s->n_q + 1)*sizeof *g);
    lw_status st = basis && g ? LW_OK : lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    double *plus = g ? g + n : NULL, *minus = g ? plus + n*n : NULL, *step = g ? minus + n : NULL, *stiff = g ?
        step + n : NULL;
    double *trial = g ? stiff + 2*n*n : NULL;
    int round = 0;
    bool done = n == 0;
    r->r.stable = true;
    if (st == LW_OK)
        st = rows_at(r, t, r->q);
    for (; st == LW_OK && !done && round < 200; round++) {
        if ((st = rows_at(r, t, r->q)) != LW_OK)
            break;
        r->dense.rank.most = r->z.n_kept;
        lw_space_dense_factor(&r->z, &r->dense, 1e-10);
        for (int k = 0; k < n; k++) {
            lw_rank_left_null(&r->dense.rank, k, basis + k*v);
            for (int i = 0; i < v; i++)
                basis[k*v + i] *= sqrt(r->z.weight[i]);
        }
        st = free_forces(r, t, r->q, basis, n, g);
        for (int k = 0; k < n && st == LW_OK; k++)
            for (int side = -1; side <= 1 && st == LW_OK; side += 2) {
                memcpy(trial, r->q, (size_t)s->n_q*sizeof *trial);
                double length = lw_space_length(s, basis + k*v);
                for (int i = 0; i < v; i++)
                    r->z.full[i] = side*h/length*basis[k*v + i];
                lw_space_move(s, trial, r->z.full);
                if ((st = lw_space_rows_close(&r->z, trial, r->target, 0, NULL)) == LW_OK)
                    st = free_forces(r, t, trial, basis, n, side < 0 ? minus : plus);
                for (int i = 0; i < n && side > 0; i++)
                    stiff[i*n + k] = -(plus[i] - minus[i])*length/(2*h);
            }
        if (st != LW_OK)
            break;
        double size = 0, off = 0, diagonal = 0;
        r->r.stable = true;
        for (int k = 0; k < n; k++)
            size = fmax(size, fabs(g[k])), diagonal = fmax(diagonal, fabs(stiff[k*n + k]));
        if (size > 1.5*last && shift == 0)
            shift = 1e-3*diagonal;
        for (int tries = 0; tries < 60; tries++) {
            memcpy(stiff + n*n, stiff, (size_t)n*(size_t)n*sizeof *stiff);
            for (int k = 0; k < n; k++)
                stiff[n*n + k*n + k] += shift, step[k] = g[k];
            if (is_positive(n, stiff, shift, plus) && solve_small(n, stiff + n*n, step))
                break;
            r->r.stable = false;
            shift = shift > 0 ? 4*shift : 1e-6*diagonal + 1e-300;
        }
        memset(r->z.full, 0, (size_t)v*sizeof *r->z.full);
        for (int k = 0; k < n; k++)
            for (int i = 0; i < v; i++)
                r->z.full[i] += step[k]*basis[k*v + i];
        off = lw_space_length(s, r->z.full);
        for (int i = 0; i < v && off > 0.2; i++)
            r->z.full[i] *= 0.2/off;
        lw_space_move(s, r->q, r->z.full);
        if (lw_space_rows_close(&r->z, r->q, r->target, 0, NULL) != LW_OK)
            st = LW_OPEN;
        lw_space_place(s, r->q, r->z.frame);
        lw_space_forces_accept(&r->f, r->z.frame);
        done = off < 1e-12 || (off < 1e-9 && size >= last);
        shift = size < last ? shift/8 : shift;
        last = size;
    }
    free(basis), free(g);
    if (st == LW_OK && !done)
        return lw_error_set(r->e, LW_E_NUMERIC, "no equilibrium was found near the posture of the file: after %d "
                                                "iterations a force "
                            "of %.3g (over the size) is left", round, last);
    if (st != LW_OK)
        return st == LW_OPEN ? lw_error_set(r->e, LW_OPEN, "on the way to equilibrium the joints cannot be closed")
            : st;
    memset(r->v, 0, (size_t)v*sizeof *r->v);
    memset(r->a, 0, (size_t)v*sizeof *r->a);
    st = rows_at(r, t, r->q);
    if (st != LW_OK)
        return st;
    lw_space_forces_apply(&r->f, t, r->z.frame, r->v, r->force, NULL);
    lw_space_rows_carry(&r->z, r->force, r->l);
    memset(r->path, 0, 3*((size_t)r->m->n_input + 1)*sizeof(double));
    r->r.steps = round;
    return hand_out(r, t, r->q, r->v, r->a, NAN);
}

/* ---- the whole ---- */

/* Fastest decay by dampers in the posture of the file [1/s]. */
static double decay(lw_space_run *r)
{
    const lw_spatial *m = r->m;
    const lw_space *s = &r->s;
    double most = 0, *push = r->a;
    if (r->by_rank)
        return 0;
    lw_space_rows_fill(&r->z, s->start, NULL);
    lw_space_rows_factor(&r->z);
    for (int i = 0; i < m->n_spring + m->n_joint_spring; i++) {
        bool line = i < m->n_spring;
        double c = line ? m->spring[i].damping : m->joint_spring[i - m->n_spring].damping, sum = 0;
        if (!(c > 0))
            continue;
        memset(push, 0, (size_t)s->n_v*sizeof *push);
        lw_space_forces_unit(&r->f, r->z.frame, i, push);
        lw_space_rows_solve(&r->z, push, NULL, false, r->v, r->l);
        for (int k = 0; k < s->n_v; k++)
            sum += push[k]*r->v[k];
        most = fmax(most, c*sum);
    }
    memset(r->v, 0, (size_t)s->n_v*sizeof *r->v);
    return most;
}

/* Decays over the length of a run from which the implicit method, which is less accurate, is taken: below it the
 * explicit one needs less than about a million steps. */
static const double stiff_run = 1e6;

static lw_status choose(lw_space_run *r, lw_error *e)
{
    lw_space_analysis a = r->o.analysis;
    lw_vec3 normal;
    const char *planar = lw_spatial_is_planar(r->m, &normal) ? "; all axes are parallel: written with two numbers a "
                                                               "place, the model "
                         "is planar and runs faster" : "";
    bool driven = r->freedom == 0 && a != LW_SPACE_STATIC;
    if ((a == LW_SPACE_KINEMATIC || a == LW_SPACE_QUASISTATIC) && r->freedom > 0)
        return lw_error_set(e, LW_E_ARG, "%d of %d freedoms have no prescribed motion: give the inputs a \"motion\", "
                                         "or ask for "
                            "--analysis dynamic", r->freedom, r->r.freedom);
    if (a == LW_SPACE_DYNAMIC && r->freedom == 0)
        return lw_error_set(e, LW_E_ARG, "every freedom is driven, there is nothing left for dynamics; ask for "
                                         "--analysis kinematic");
    if (r->has_drives && r->freedom > 0 && r->n_driven > 0)
        return lw_error_set(e, LW_E_KIND, "\"drives\" carry the forces of a model whose inputs leave no freedom; "
                                          "here %d freedoms are "
                            "left", r->freedom);
    lw_space_formulation wish = r->o.formulation;
    bool stiff = !driven && a != LW_SPACE_STATIC && decay(r)*(r->o.to - r->o.from) > stiff_run;
    if (wish != LW_SPACE_AUTO && a != LW_SPACE_STATIC && (wish == LW_SPACE_DRIVEN) != driven)
        return lw_error_set(e, LW_E_KIND, driven ? "every freedom is driven: the %s formulation has nothing to do"
                            : "the %s formulation cannot do this model: %d freedoms are not driven",
                            lw_space_formulation_name(wish), r->freedom);
    r->r.formulation = a == LW_SPACE_STATIC ? LW_SPACE_EQUILIBRIUM : driven ? LW_SPACE_DRIVEN : wish != LW_SPACE_AUTO ?
        wish
                     : stiff ? LW_SPACE_CVODE : LW_SPACE_INDEX1;
    const char *how = r->r.formulation == LW_SPACE_CVODE ? wish == LW_SPACE_CVODE ? "implicit method"
                    : "implicit method, because dampers make the equations stiff" : "explicit method of order 8";
    r->r.unknowns = driven ? r->z.n_kept : a == LW_SPACE_STATIC ? r->freedom : r->s.n_q + r->s.n_v + has_work(r);
    if (driven || a == LW_SPACE_STATIC)
        snprintf(r->r.why, sizeof r->r.why, "%s%s", driven ? "every freedom is driven: kinematics, then forces"
                 : "equilibrium by Newton's method in the freedoms", planar);
    else
        snprintf(r->r.why, sizeof r->r.why, "places and quaternions of all bodies, %s%s%s", how,
                 r->by_rank ? "; massless parts are solved by rank" : "", planar);
    return LW_OK;
}

/* The full matrix, where it is needed: large models have none. */
static lw_status make_dense(lw_space_run *r, lw_error *e)
{
    bool needed = r->by_rank || r->r.redundant > 0 || r->o.analysis == LW_SPACE_STATIC;
    return needed ? lw_space_dense_make(&r->z, &r->dense, e) : LW_OK;
}

lw_status lw_space_run_make(const lw_spatial *m, const lw_space_options *o, lw_space_run **out, lw_error *e)
{
    lw_error own = { 0 };
    lw_space_run *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    r->m = m;
    r->o = *o;
    r->e = e = e ? e : &own;
    lw_status st = check_model(m, e);
    if (st == LW_OK && (st = lw_space_make(m, &r->s, e)) == LW_OK && (st = lw_space_forces_make(&r->s, &r->f, e)) ==
        LW_OK &&
        (st = make_rows(r, e)) == LW_OK && (st = reserve(r, e)) == LW_OK && (st = choose(r, e)) == LW_OK &&
        (st = make_dense(r, e)) == LW_OK && (st = start_posture(r, e)) == LW_OK) {
        lw_space_place(&r->s, r->q, r->z.frame);
        lw_space_forces_accept(&r->f, r->z.frame);
        if (!is_driven(r) && o->analysis != LW_SPACE_STATIC)
            st = start_velocity(r, e);
    }
    if (st == LW_OK && r->by_rank && !is_driven(r) && o->analysis !=
        LW_SPACE_STATIC) {      /* names a link without mass */
        st = rows_at(r, o->from, r->q);
        if (st == LW_OK)
            st = accelerate(r, o->from, r->v, r->a, r->l, NULL);
    }
    if (st != LW_OK) {
        lw_space_run_free(r);
        return st;
    }
    *out = r;
    return LW_OK;
}

lw_status lw_space_run_go(lw_space_run *r, lw_space_moment_sink *sink, void *context, lw_error *e)
{
    lw_error own = { 0 };
    r->e = e ? e : &own;
    r->sink = sink;
    r->context = context;
    lw_status st = is_driven(r) ? run_driven(r) : r->o.analysis == LW_SPACE_STATIC ? run_static(r) : run_in_time(r);
    long samples = r->o.analysis == LW_SPACE_STATIC ? 1 : r->o.intervals + 1L;
    if (st == LW_OPEN && !r->e->text[0])
        lw_error_set(r->e, st, "at t = %.9g s the model comes to a singular posture", r->r.t);
    if (st == LW_OK && r->r.samples != samples)
        st = lw_error_set(r->e, LW_E_NUMERIC, "the run ended at t = %.9g s after %ld of %ld samples", r->r.t,
                          r->r.samples, samples);
    if (st < 0 && !r->e->text[0])
        lw_error_set(r->e, st, "the run ended at t = %.9g s: %s", r->r.t, lw_status_text(st));
    return st;
}

void lw_space_run_redundant(const lw_space_run *r, char *text, size_t size)
{
    size_t used = 0;
    int last = -1;
    *text = '\0';
    for (int i = 0; i < r->s.n_row && used < size; i++) {
        int joint;
        lw_space_row_name(&r->s, i, &joint);
        if (r->z.place[i] < 0 && joint != last) {
            used += (size_t)snprintf(text + used, size - used, " %s", r->m->joint[joint].name);
            last = joint;
        }
    }
}

void lw_space_links(const lw_space *s, const lw_space_moment *m, lw_frame_motion *out)
{
    for (int i = 0; i < s->model->n_link; i++) {
        int b = s->body_of[i];
        out[i] = (lw_frame_motion){ .turn = { 1, 0, 0, 0 } };
        if (b < 0)
            continue;
        const double *q = m->q + 7*b, *v = m->v + 6*b, *a = m->a + 6*b, u = s->unit;
        lw_quaternion turn = lw_quaternion_times((lw_quaternion){ q[3], q[4], q[5], q[6] },
                                                 lw_quaternion_inverse(s->axes[b]));
        out[i] = (lw_frame_motion){ { u*q[0], u*q[1], u*q[2] }, { u*v[0], u*v[1], u*v[2] }, { u*a[0], u*a[1], u*a[2] },
                                    lw_quaternion_unit(turn),
                                    lw_space_omega(m->frame, b, m->v), lw_space_omega(m->frame, b, m->a) };
    }
}
