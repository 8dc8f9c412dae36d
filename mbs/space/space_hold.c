/* mbs/space/space_hold.c - how well drives hold a spatial model along a motion. */
#include "mbs/space/space_hold.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/vector.h"

static const double least_same = 0.5;        /* determinant of the cosines between the motions at two postures; less: too different */

lw_status lw_space_hold_make(int n, int n_v, lw_space_hold *h, lw_error *e)
{
    size_t columns = (size_t)n*(size_t)n_v;
    *h = (lw_space_hold){ .n = n, .n_v = n_v, .column = malloc(4*columns*sizeof *h->column + 1) };
    h->motions[0] = h->column + columns;
    h->motions[1] = h->motions[0] + columns;
    h->motions[2] = h->motions[1] + columns;
    return h->column ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void lw_space_hold_free(lw_space_hold *h)
{
    free(h->column);
    *h = (lw_space_hold){ 0 };
}

void lw_space_hold_begin(lw_space_hold *h)
{
    h->holds = 0;
    h->unsure = false;
}

void lw_space_hold_keep(lw_space_hold *h)
{
    h->kept = h->holds;
    if (h->holds != 0)
        memcpy(h->motions[2], h->motions[0], (size_t)h->n*(size_t)h->n_v*sizeof *h->column);
}

void lw_space_hold_back(lw_space_hold *h)
{
    double *last = h->motions[0];
    h->motions[0] = h->motions[2];
    h->motions[2] = last;
    h->holds = h->kept;
    h->unsure = false;
}

bool lw_space_hold_rates(lw_space_hold *h, lw_space_follow *f, const lw_spatial_measure *drive, double *a)
{
    const lw_space *s = f->z.s;
    int n = h->n;
    bool known = f->column == h->column && f->has_column;
    if (!known && !(lw_space_rows_factor_near(&f->z) && lw_space_rows_motions(&f->z, n, s->n_row + f->n_idle, h->column)))
        return false;
    for (int k = 0; k < n; k++) {
        int body[2];
        double jac[LW_SPACE_ROW];
        lw_space_measure(s, f->z.frame, drive[k], 0, jac);
        lw_space_bodies(s, &(lw_space_extra){ .measure = drive[k] }, body);
        for (int i = 0; i < n; i++) {
            a[i*n + k] = 0;
            for (int side = 0; side < 2; side++)
                if (body[side] >= 0)
                    a[i*n + k] += lw_dot(6, jac + 6*side, h->column + i*s->n_v + 6*body[side]);
        }
    }
    return true;
}

/* Make the n columns v (n_v each) orthonormal.  Returns the determinant of the columns in this basis; 0: they are dependent. */
static double orthonormalise(int n_v, int n, double *v)
{
    double det = 1;
    for (int i = 0; i < n; i++) {
        double *a = v + (size_t)i*(size_t)n_v;
        for (int pass = 0; pass < 2; pass++)             /* the second one removes the rounding of the first */
            for (int k = 0; k < i; k++) {
                const double *b = v + (size_t)k*(size_t)n_v;
                double along = lw_dot(n_v, a, b);
                for (int j = 0; j < n_v; j++)
                    a[j] -= along*b[j];
            }
        double length = sqrt(lw_dot(n_v, a, a));
        if (!(length > 0))
            return 0;
        for (int j = 0; j < n_v; j++)
            a[j] /= length;
        det *= length;
    }
    return det;
}

/* Determinant of a (n x n), which is changed. */
static double determinant(int n, double *a)
{
    double diag[LW_SPACE_HELD];
    lw_qr_factor(n, n, a, diag);
    return lw_qr_determinant(n, diag);
}

double lw_space_hold_now(lw_space_hold *h, double *a)
{
    int n = h->n, n_v = h->n_v;
    double cosine[LW_SPACE_HELD*LW_SPACE_HELD], holds = a ? determinant(n, a) : 1;
    memcpy(h->motions[1], h->column, (size_t)n*(size_t)n_v*sizeof *h->column);
    double det = orthonormalise(n_v, n, h->motions[1]);
    h->unsure = false;
    if (!(det > 0))
        return 0;
    if (h->holds == 0)
        return holds/det;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            cosine[i*n + k] = lw_dot(n_v, h->motions[0] + (size_t)i*(size_t)n_v, h->motions[1] + (size_t)k*(size_t)n_v);
    double same = determinant(n, cosine);
    h->unsure = fabs(same) < least_same;
    return same < 0 ? -holds/det : holds/det;
}

static void take(lw_space_hold *h, double holds)
{
    double *last = h->motions[0];
    h->motions[0] = h->motions[1];
    h->motions[1] = last;
    h->holds = holds;
}

bool lw_space_hold_lost(lw_space_hold *h, double holds)
{
    if (holds*h->holds < 0 || h->unsure)
        return true;
    if (holds != 0)
        take(h, holds);
    return false;
}

/* ---- motions that the drives do not hold ------------------------------------------------------------------ */

/* Solve A x = b (n x n), or its transpose, in place. */
static void solve(int n, const double *a, bool transposed, double *b)
{
    double of[LW_SPACE_HELD*LW_SPACE_HELD], diag[LW_SPACE_HELD];
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            of[i*n + k] = transposed ? a[k*n + i] : a[i*n + k];
    lw_qr_factor(n, n, of, diag);
    lw_qr_solve(n, n, of, diag, b);
}

/* Inverse iteration for c with |A c| least beside |V c|. */
bool lw_space_unheld(int n, int n_v, const double *a, const double *column, double *v)
{
    enum { ROUNDS = 4 };
    double by[LW_SPACE_HELD*LW_SPACE_HELD], c[LW_SPACE_HELD], w[LW_SPACE_HELD], most = 0;
    for (int i = 0; i < n*n; i++)
        most = fmax(most, fabs(a[i]));
    memcpy(by, a, (size_t)(n*n)*sizeof *by);
    for (int i = 0; i < n; i++)
        by[i*n + i] += 1e-15*most, c[i] = 1 + 0.1*i;     /* never quite singular */
    for (int round = 0; round < ROUNDS; round++) {
        memset(v, 0, (size_t)n_v*sizeof *v);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n_v; j++)
                v[j] += c[i]*column[i*n_v + j];
        double length = lw_norm(n_v, v);
        if (!(length > 0 && isfinite(length)))
            return false;
        for (int j = 0; j < n_v; j++)
            v[j] /= length;
        for (int i = 0; i < n; i++)
            w[i] = lw_dot(n_v, column + (size_t)i*(size_t)n_v, v);
        solve(n, by, true, w);
        solve(n, by, false, w);
        memcpy(c, w, (size_t)n*sizeof *c);
    }
    return true;
}

static double rounded(double x, double step) { return step*round(x/step) + 0.0; }

/* Speed of a body over the size of the model, and angular velocity. */
static double moves(const lw_space *s, const double *v, int body) { return lw_norm(3, v + 6*body)/s->unit + lw_norm(3, v + 6*body + 3); }

void lw_space_motion_text(const lw_space *s, const lw_space_frame *frame, const double *v, char text[LW_SPACE_MOTION_TEXT])
{
    static const double none = 1e-3;
    const lw_units *units = &s->model->units;
    int best = 0, tool = s->model->n_tracer > 0 ? s->body_of[s->model->tracer[0].link] : -1;
    for (int b = 1; b < s->n_body; b++)
        best = moves(s, v, b) > moves(s, v, best) ? b : best;
    if (tool >= 0 && moves(s, v, tool) > 0.1*moves(s, v, best))
        best = tool;
    lw_space_point centre = { best, { 0, 0, 0 } };
    lw_vec3 at = lw_space_point_at(frame, centre), speed = lw_space_point_velocity(s, frame, centre, v), turn = lw_space_omega(frame, best, v);
    double w = lw_v3_norm(turn);
    bool turns = w*s->unit > none*lw_v3_norm(speed);
    lw_vec3 along = lw_v3_scale(turns ? turn : speed, 1/(turns ? w : lw_v3_norm(speed)));
    double sum = along.x + along.y + along.z;                /* of the two directions */
    along = lw_v3_scale(along, sum < 0 ? -1 : 1);
    int used = snprintf(text, LW_SPACE_MOTION_TEXT, "link \"%.40s\" %s (%.2f, %.2f, %.2f)", s->model->body[s->link_of[best]].name,
                        turns ? "turns about the axis" : "slides along", rounded(along.x, 0.01), rounded(along.y, 0.01), rounded(along.z, 0.01));
    if (!turns)
        return;
    double step = pow(10, floor(log10(0.02*s->unit/units->metre)));
    bool slides = fabs(lw_v3_dot(turn, speed)) > 0.01*s->unit*w*w;
    at = lw_v3_add(at, lw_v3_scale(lw_v3_cross(turn, speed), 1/(w*w)));
    snprintf(text + used, LW_SPACE_MOTION_TEXT - (size_t)used, " through (%.9g, %.9g, %.9g) %s%s", rounded(at.x/units->metre, step),
             rounded(at.y/units->metre, step), rounded(at.z/units->metre, step), units->length[0] ? units->length : "m", slides ? " and slides along it" : "");
}

/* ---- along a path ---------------------------------------------------------------------------------------- */

/* Between the last posture and this one, at such a part of the way. */
static void tell_free_motion(lw_space_watch *w, const double *rates, double part)
{
    lw_space_follow *f = w->f;
    const lw_space *s = f->z.s;
    int n = w->hold.n, n_v = w->hold.n_v;
    double *v = w->motion, *now = v + n_v, *q = now + n_v, *before = w->last + (size_t)n*(size_t)n_v;
    if (!lw_space_unheld(n, n_v, w->rates, w->last, v) || !lw_space_unheld(n, n_v, rates, w->hold.column, now))
        return;
    double same = lw_dot(n_v, v, now) < 0 ? -1 : 1;
    for (int i = 0; i < n_v; i++)
        v[i] = (1 - part)*v[i] + part*same*now[i];
    for (int i = 0; i < s->n_q; i++)
        q[i] = (1 - part)*before[i] + part*f->q[i];
    lw_space_normalise(s, q);
    lw_space_place(s, q, f->z.frame);
    lw_space_motion_text(s, f->z.frame, v, w->how);
    lw_space_place(s, f->q, f->z.frame);
}

static void look(void *context, const double *q)
{
    (void)q;                                 /* that of f */
    lw_space_watch *w = context;
    double a[LW_SPACE_HELD*LW_SPACE_HELD], rates[LW_SPACE_HELD*LW_SPACE_HELD], before = w->hold.holds, holds = 0;
    size_t n = (size_t)w->hold.n, columns = n*(size_t)w->hold.n_v;
    bool known = lw_space_hold_rates(&w->hold, w->f, w->drive, rates);
    if (known) {
        memcpy(a, rates, n*n*sizeof *a);
        holds = lw_space_hold_now(&w->hold, a);
    }
    if (lw_space_hold_lost(&w->hold, holds)) {
        if (!w->lost && !w->hold.unsure) {
            w->lost = true, w->between[0] = fmin(w->at, w->f->u), w->between[1] = fmax(w->at, w->f->u);
            tell_free_motion(w, rates, before/(before - holds));
        }
        take(&w->hold, holds);
    }
    w->at = w->f->u;
    if (known) {
        memcpy(w->rates, rates, n*n*sizeof *rates);
        memcpy(w->last, w->hold.column, columns*sizeof *w->last);
        memcpy(w->last + columns, w->f->q, (size_t)w->f->z.s->n_q*sizeof *w->last);
    }
}

lw_status lw_space_watch_begin(lw_space_watch *w, lw_space_follow *f, lw_error *e)
{
    const lw_space *s = f->z.s;
    const lw_spatial *m = s->model;
    int n = f->n_input;
    *w = (lw_space_watch){ .f = f };
    if (s->n_joint <= s->n_body || f->freedom > 0 || n > LW_SPACE_HELD || (m->n_drive ? m->n_drive != n : n < 2))
        return LW_OK;
    for (int i = 0; i < n; i++)
        w->drive[i] = m->n_drive ? m->drive[i] : f->z.extra[f->n_idle + i].measure;
    lw_status st = lw_space_hold_make(n, s->n_v, &w->hold, e);
    size_t columns = (size_t)n*(size_t)s->n_v;
    if (st == LW_OK && !(w->last = calloc(columns + 2*(size_t)(s->n_q + s->n_v), sizeof *w->last)))
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    w->motion = w->last ? w->last + columns + s->n_q : NULL;
    if (st == LW_OK)
        f->passed = look, f->passed_by = w, w->at = f->u, f->column = w->hold.column;
    return st;
}

void lw_space_watch_end(lw_space_watch *w)
{
    if (w->hold.column)
        w->f->passed = NULL, w->f->column = NULL, w->f->has_column = false;
    lw_space_hold_free(&w->hold);
    free(w->last);
    w->last = NULL;
}
