/* mbs/clearance/clearance_equations.c - accelerations in tree coordinates, with rows for loops, links, stops and
 * inputs. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/clearance/clearance_internal.h"
#include "mbs/equations/friction.h"

enum { ROW_MAX = LW_SYSTEM_Q_MAX + LW_SYSTEM_ROW_MAX + LW_INPUT_MAX + LW_CLEARANCE_STOP_MAX };

/* ---- memory -------------------------------------------------------------------------------------- */

int lw_clearance_count_rows(const lw_clearance_scene *c, const lw_row_choice *choice)
{
    int n = c->tree.n_row;
    for (int i = 0; i < c->n_journal; i++)
        n += choice->hold[i] ? 2 : choice->link[i] ? 1 : 0;
    for (int i = 0; i < c->n_stop; i++)
        n += choice->stop[i];
    for (int i = 0; i < c->s.n_input; i++)
        n += choice->input[i];
    return n;
}

static double *take(double **p, size_t n)
{
    double *at = *p;
    *p += n;
    return at;
}

lw_status lw_clearance_work_make(const lw_clearance_scene *c, const lw_clearance_options *o, lw_clearance_work *w)
{
    size_t u = (size_t)c->tree.n_u, q = (size_t)c->s.n_q, rows = (size_t)c->s.n_row;
    size_t c_max = (size_t)c->tree.n_row + 2*(size_t)c->n_journal + (size_t)c->s.n_input
                 + (size_t)c->n_stop, all = u + c_max;
    size_t columns = 2*u*(size_t)c->s.n_body;
    size_t n = columns + 3*q + 3*q + rows*q + 3*rows + q + u*u + u + c_max*u + 3*c_max + all + 4*u
             + (size_t)c->n_friction*all + lw_friction_doubles(c->n_friction, 2) + lw_rank_doubles((int)all, (int)all)
             + lw_rank_doubles((int)c_max + 1, (int)u);
    memset(w, 0, sizeof *w);
    w->c = c;
    w->o = *o;
    w->n_u = c->tree.n_u;
    memcpy(w->stop, c->stop, sizeof w->stop);
    w->memory = calloc(n, sizeof *w->memory);
    w->ints = calloc(all + u + 2, sizeof *w->ints);
    w->planar = (lw_planar){ .s = &c->s, .f = &c->f };
    w->eq = lw_planar_equations(&w->planar);
    if (!w->memory || !w->ints || lw_kinks_make(&w->eq, &w->kinks) != LW_OK) {
        lw_clearance_work_free(w);
        return LW_E_MEMORY;
    }
    double *p = w->memory;
    w->state.b = (lw_vec2 *)take(&p, columns);
    w->q = take(&p, q), w->v = take(&p, q), w->force = take(&p, q);
    w->series = take(&p, 3*q), w->jac = take(&p, rows*q), w->phi = take(&p, 3*rows), w->row = take(&p, q);
    w->mass = take(&p, u*u), w->load = take(&p, u), w->a = take(&p, c_max*u);
    w->off = take(&p, c_max), w->wanted = take(&p, c_max), w->lambda = take(&p, c_max), w->answer = take(&p, all);
    w->response = take(&p, (size_t)c->n_friction*all + lw_friction_doubles(c->n_friction, 2));
    w->y = take(&p, 2*u), w->rate = take(&p, 2*u);
    lw_rank_place(&w->kkt, (int)all, (int)all, p, w->ints);
    p += lw_rank_doubles((int)all, (int)all);
    lw_rank_place(&w->fit, (int)c_max + 1, (int)u, p, w->ints + all);
    return LW_OK;
}

void lw_clearance_work_free(lw_clearance_work *w)
{
    free(w->memory);
    free(w->ints);
    lw_kinks_free(w->kinks);
}

/* ---- journals ------------------------------------------------------------------------------------ */

lw_play lw_clearance_play(const lw_clearance_work *w, int i, const double *du)
{
    const lw_journal *j = &w->c->journal[i];
    const lw_tree_state *s = &w->state;
    lw_play p;
    for (int end = 0; end < 2; end++)
        p.r[end] = lw_v2_turn(j->arm[end], s->dir[j->body[end] + 1]);
    p.d = lw_v2_sub(lw_v2_add(s->at[j->body[1] + 1], p.r[1]), lw_v2_add(s->at[j->body[0] + 1], p.r[0]));
    p.rate = !du ? lw_v2(0.0, 0.0) : lw_v2_sub(lw_tree_velocity(&w->c->tree, s, j->body[1], p.r[1], du),
                                               lw_tree_velocity(&w->c->tree, s, j->body[0], p.r[0], du));
    return p;
}

/* Acceleration of the pin from the bush by velocities alone */
static lw_vec2 play_bias(const lw_clearance_work *w, int i, const lw_play *p)
{
    const lw_journal *j = &w->c->journal[i];
    lw_vec2 a[2];
    for (int end = 0; end < 2; end++) {
        int b = j->body[end] + 1;
        double spin = w->state.spin[b];
        a[end] = lw_v2_sub(w->state.bias[b], lw_v2_scale(p->r[end], spin*spin));
    }
    return lw_v2_sub(a[1], a[0]);
}

/* out (n_u) += generalised force of f at the pin and -f at the bush */
static void push_apart(const lw_clearance_work *w, int i, const lw_play *p, lw_vec2 f, double *out)
{
    const lw_journal *j = &w->c->journal[i];
    lw_tree_push(&w->c->tree, &w->state, j->body[1], p->r[1], f, 0.0, out);
    lw_tree_push(&w->c->tree, &w->state, j->body[0], p->r[0], lw_v2_scale(f, -1.0), 0.0, out);
}

static double contact_force(const lw_clearance_work *w, int i, const lw_play *p, double *distance)
{
    const lw_clearance *c = w->c->journal[i].c;
    double unit = w->c->s.unit, r = lw_v2_norm(p->d);
    *distance = r;
    if (r == 0.0)
        return 0.0;
    return lw_contact_force(c, w->phase[i], r*unit - c->gap, lw_v2_dot(p->d, p->rate)/r*unit, w->struck[i]);
}

double lw_clearance_press(const lw_clearance_work *w, int i, const lw_play *p)
{
    double r;
    lw_vec2 f = lw_clearance_reaction(w, i);
    if (w->rows.hold[i])
        return lw_v2_norm(f);
    return w->rows.link[i] ? -lw_v2_dot(f, p->d)/lw_v2_norm(p->d) : contact_force(w, i, p, &r);
}

/* Add contact force and friction of journal i to the load.  Friction acts where the surfaces touch, at the pin's
 * radius from its centre. */
static void add_contact(lw_clearance_work *w, int i, const double *du)
{
    const lw_journal *j = &w->c->journal[i];
    if (w->phase[i] == LW_CONTACT_APART || w->rows.hold[i] || w->rows.link[i])
        return;
    lw_play p = lw_clearance_play(w, i, du);
    double r, unit = w->c->s.unit, f = contact_force(w, i, &p, &r);
    if (r == 0.0)
        return;
    lw_vec2 n = lw_v2_scale(p.d, 1.0/r), pull = lw_v2_scale(n, -f*unit);
    if (j->c->friction > 0.0) {
        lw_vec2 along = lw_v2_perp(n);
        double pin = j->pin/unit, spin1 = w->state.spin[j->body[1] + 1], spin0 = w->state.spin[j->body[0] + 1];
        /* d turns with the bush by spin0 r; the rest is slip */
        double slip = lw_v2_dot(along, p.rate) + spin1*pin - spin0*(pin + r);
        double drag = lw_contact_friction(j->c, f, slip*unit)*unit;
        pull = lw_v2_sub(pull, lw_v2_scale(along, drag));
        lw_tree_push(&w->c->tree, &w->state, j->body[1], p.r[1], lw_v2(0.0, 0.0), -drag*pin, w->load);
        lw_tree_push(&w->c->tree, &w->state, j->body[0], p.r[0], lw_v2(0.0, 0.0), drag*(pin + r), w->load);
    }
    push_apart(w, i, &p, pull, w->load);
}

/* ---- rows ---------------------------------------------------------------------------------------- */

/* Derivatives by the bodies' coordinates, times B */
void lw_clearance_through_tree(const lw_clearance_work *w, const double *row, double *out)
{
    const lw_tree *t = &w->c->tree;
    for (int b = 0; b < t->n_body; b++) {
        const double *g = row + 3*b;
        if (g[0] != 0.0 || g[1] != 0.0 || g[2] != 0.0)
            lw_tree_push(t, &w->state, b, lw_v2(0.0, 0.0), lw_v2(g[0], g[1]), g[2], out);
    }
}

/* q, dq/dt and half of d2q/dt2 without d2u as a series, for the rows of the system */
static void write_series(lw_clearance_work *w, const double *du)
{
    const lw_tree *t = &w->c->tree;
    size_t n = (size_t)w->c->s.n_q;
    lw_tree_write(t, &w->state, du, w->series, du ? w->series + n : NULL);
    for (int b = 0; b < t->n_body; b++) {
        double *h = w->series + 2*n + 3*b;
        h[0] = 0.5*w->state.bias[b + 1].x, h[1] = 0.5*w->state.bias[b + 1].y, h[2] = 0.0;
    }
}

/* Value, rate and second rate at t that the row of input i must have, scaled, from the posture */
static lw_status wanted_motion(const lw_clearance_work *w, int i, double t, double m[3])
{
    const lw_clearance_scene *c = w->c;
    double scale = lw_system_joint_unit(&c->s, c->s.input_joint[i]);
    m[0] = w->held ? w->held[i] : 0.0;
    m[1] = m[2] = 0.0;
    if (w->held)
        return LW_OK;
    if (!c->m->motion[i]) {              /* starts only: from the posture, at its speed */
        m[1] = (i == 0 && !isnan(w->o.speed) ? w->o.speed : c->m->has_speed[i] ? c->m->speed[i] : 0.0)/scale;
        return LW_OK;
    }
    lw_status s = lw_input_motion(c->m, &c->s, i, t, m);
    m[0] -= c->turns[i];
    return s;
}

static lw_status input_rows(lw_clearance_work *w, const lw_row_choice *choice, double t, bool series, int *n)
{
    const lw_system *s = &w->c->s;
    for (int i = 0; i < s->n_input; i++) {
        double m[3], h[3] = { 0.0 };
        if (!choice->input[i])
            continue;
        lw_status status = wanted_motion(w, i, t, m);
        if (status != LW_OK)
            return status;
        h[0] = lw_system_measure(s, s->input_joint[i], w->series, w->row);
        lw_clearance_through_tree(w, w->row, w->a + *n*w->n_u);
        if (series)
            lw_system_measure_series(s, s->input_joint[i], 2, w->series, h);
        w->off[*n] = h[0] - m[0];
        w->wanted[*n] = series ? m[2] - 2.0*h[2] : m[1];
        ++*n;
    }
    return LW_OK;
}

/* Rows of the joints that close loops */
static void loop_rows(lw_clearance_work *w, bool series, int *n)
{
    const lw_tree *t = &w->c->tree;
    const lw_system *s = &w->c->s;
    if (t->n_close == 0)
        return;
    lw_system_rows(s, w->series, w->phi, w->jac);
    if (series)
        lw_system_series(s, 2, w->series, w->phi);
    for (int c = 0; c < t->n_close; c++) {
        for (int i = 0; i < w->c->n_friction; i++)
            if (w->c->friction_journal[i] < 0 && w->c->friction[i].joint == t->close[c])
                w->friction_row[i] = *n;
        for (int r = s->joint[t->close[c]].row; r < s->n_row && s->row[r].joint == t->close[c]; r++) {
            lw_clearance_through_tree(w, w->jac + (long)r*s->n_q, w->a + *n*w->n_u);
            w->off[*n] = w->phi[r];
            w->wanted[*n] = series ? -2.0*w->phi[2*s->n_row + r] : 0.0;
            ++*n;
        }
    }
}

static void journal_rows(lw_clearance_work *w, const lw_row_choice *choice, const double *du, bool series, int *n)
{
    static const lw_vec2 axis[2] = { { 1.0, 0.0 }, { 0.0, 1.0 } };
    for (int i = 0; i < w->c->n_journal; i++) {
        if (!choice->hold[i] && !choice->link[i])
            continue;
        lw_play p = lw_clearance_play(w, i, du);
        lw_vec2 bias = series ? play_bias(w, i, &p) : lw_v2(0.0, 0.0);
        for (int k = 0; k < w->c->n_friction; k++)
            if (w->c->friction_journal[k] == i)
                w->friction_row[k] = *n;
        for (int k = 0; k < 2 && choice->hold[i]; k++, ++*n) {
            push_apart(w, i, &p, axis[k], w->a + *n*w->n_u);
            w->off[*n] = lw_v2_dot(axis[k], lw_v2_sub(p.d, w->offset[i]));
            w->wanted[*n] = series ? -lw_v2_dot(axis[k], bias) : lw_v2_dot(axis[k], w->offset_rate[i]);
        }
        if (!choice->link[i])
            continue;
        double gap = w->c->journal[i].c->gap/w->c->s.unit;
        push_apart(w, i, &p, lw_v2_scale(p.d, 1.0/gap), w->a + *n*w->n_u);
        w->off[*n] = (lw_v2_dot(p.d, p.d) - gap*gap)/(2.0*gap);
        w->wanted[*n] = series ? -(lw_v2_dot(p.rate, p.rate) + lw_v2_dot(p.d, bias))/gap : 0.0;
        ++*n;
    }
}

/* Rows of the stops that are rested on, from row *n */
static void stop_rows(lw_clearance_work *w, const lw_row_choice *choice, bool series, int *n)
{
    const lw_system *s = &w->c->s;
    for (int i = 0; i < w->c->n_stop; i++) {
        const lw_rigid_stop *p = &w->stop[i];
        double h[3] = { 0.0 };
        if (!choice->stop[i])
            continue;
        w->off[*n] = lw_system_measure(s, p->joint, w->series, w->row) - p->limit;
        lw_clearance_through_tree(w, w->row, w->a + *n*w->n_u);
        if (series)
            lw_system_measure_series(s, p->joint, 2, w->series, h);
        w->wanted[*n] = series ? -2.0*h[2] : 0.0;
        ++*n;
    }
}

/* First row of the stops */
static int first_row(const lw_clearance_work *w)
{
    int n = w->c->tree.n_row;
    for (int i = 0; i < w->c->n_journal; i++)
        n += w->rows.hold[i] ? 2 : w->rows.link[i] ? 1 : 0;
    return n;
}

double lw_clearance_stop_press(const lw_clearance_work *w, int i)
{
    int n = first_row(w);
    for (int k = 0; k < i; k++)
        n += w->rows.stop[k];
    return w->stop[i].sign*w->lambda[n];
}

/* Fill w->a, w->off and w->wanted for the placed state: wanted rates or, with `series`, wanted accelerations. */
static lw_status fill_rows(lw_clearance_work *w, const lw_row_choice *choice, double t, const double *du, bool series)
{
    int n = 0;
    w->n_c = lw_clearance_count_rows(w->c, choice);
    assert(w->n_u + w->n_c <= ROW_MAX);
    memset(w->a, 0, sizeof(double)*(size_t)(w->n_c*w->n_u));
    bool inputs = false;
    for (int i = 0; i < w->c->s.n_input; i++)
        inputs = inputs || choice->input[i];
    for (int i = 0; i < w->c->n_stop; i++)
        inputs = inputs || choice->stop[i];
    if (inputs || w->c->tree.n_close > 0)
        write_series(w, du);
    journal_rows(w, choice, du, series, &n);
    loop_rows(w, series, &n);
    stop_rows(w, choice, series, &n);
    lw_status s = input_rows(w, choice, t, series, &n);
    assert(s != LW_OK || n == w->n_c);
    return s;
}

lw_vec2 lw_clearance_reaction(const lw_clearance_work *w, int i)
{
    int n = 0;
    double unit = w->c->s.unit;
    for (int k = 0; k < i; k++)
        n += w->rows.hold[k] ? 2 : w->rows.link[k] ? 1 : 0;
    if (w->rows.hold[i])
        return lw_v2_scale(lw_v2(w->lambda[n], w->lambda[n + 1]), 1.0/unit);
    if (!w->rows.link[i])
        return lw_v2(0.0, 0.0);
    lw_play p = lw_clearance_play(w, i, NULL);
    return lw_v2_scale(p.d, w->lambda[n]/w->c->journal[i].c->gap);
}

/* ---- accelerations ------------------------------------------------------------------------------- */

static void fill_mass(lw_clearance_work *w)
{
    const lw_tree *t = &w->c->tree;
    const double *mass = w->c->f.mass;
    int n = w->n_u;
    memset(w->mass, 0, sizeof(double)*(size_t)(n*n));
    for (int b = 0; b < t->n_body; b++) {
        const lw_tree_joint *p = &t->hang[b];
        const lw_vec2 *col = w->state.b + (size_t)b*(size_t)n;
        double m = mass[3*b];
        for (int i = 0; m > 0.0 && i < p->n_path; i++)
            for (int k = 0; k < p->n_path; k++)
                if (p->path[k] <= p->path[i])
                    w->mass[p->path[i]*n + p->path[k]] += m*lw_v2_dot(col[p->path[i]], col[p->path[k]]);
        if (p->turn >= 0)
            w->mass[p->turn*n + p->turn] += mass[3*b + 2];
    }
    w->heaviest = 0.0;
    for (int i = 0; i < n; i++)
        w->heaviest = fmax(w->heaviest, w->mass[i*n + i]);
}

static void fill_load(lw_clearance_work *w, double t, const double *du)
{
    const lw_tree *tree = &w->c->tree;
    const lw_forces *f = &w->c->f;
    const double *force = f->weight;
    memset(w->load, 0, sizeof(double)*(size_t)w->n_u);
    if (f->any_state) {
        lw_tree_write(tree, &w->state, du, w->q, w->v);
        lw_forces_apply(f, t, w->q, w->v, w->force, NULL, NULL, NULL);
        force = w->force;
    }
    for (int b = 0; b < tree->n_body; b++) {
        double m = f->mass[3*b];
        lw_vec2 p = lw_v2(force[3*b] - m*w->state.bias[b + 1].x, force[3*b + 1] - m*w->state.bias[b + 1].y);
        lw_tree_push(tree, &w->state, b, lw_v2(0.0, 0.0), p, force[3*b + 2], w->load);
    }
    for (int i = 0; i < w->c->n_journal; i++)
        add_contact(w, i, du);
}

/* Cholesky's method on the lower half of w->mass; x is the load, then the answer. */
static lw_status solve_free(lw_clearance_work *w, double *x)
{
    int n = w->n_u;
    double *m = w->mass, most = 0.0;
    for (int i = 0; i < n; i++)
        most = fmax(most, m[i*n + i]);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k <= i; k++) {
            double sum = m[i*n + k];
            for (int l = 0; l < k; l++)
                sum -= m[i*n + l]*m[k*n + l];
            if (k < i)
                m[i*n + k] = sum/m[k*n + k];
            else if (sum > 1e-15*most)
                m[i*n + i] = sqrt(sum);
            else
                return isfinite(sum) ? LW_E_NUMERIC : LW_OPEN;
        }
        double sum = x[i];
        for (int l = 0; l < i; l++)
            sum -= m[i*n + l]*x[l];
        x[i] = sum/m[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int l = i + 1; l < n; l++)
            x[i] -= m[l*n + i]*x[l];
        x[i] /= m[i*n + i];
    }
    return LW_OK;
}

/* Factor M x - A^T l = load, A x = wanted for least squares of least norm, which allows redundant rows.  Rows are
 * scaled to the size of the masses so that the rank can be judged. */
static lw_status factor_constrained(lw_clearance_work *w)
{
    int n = w->n_u, all = n + w->n_c;
    double most = w->heaviest;
    if (!(most > 0.0))
        return isfinite(most) ? LW_E_NUMERIC : LW_OPEN;
    lw_rank *r = &w->kkt;
    lw_rank_place(r, all, all, r->a, r->column);
    memset(r->a, 0, sizeof(double)*(size_t)(all*all));
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= i; k++)
            r->a[i + all*k] = r->a[k + all*i] = w->mass[i*n + k];
    for (int c = 0; c < w->n_c; c++)
        for (int k = 0; k < n; k++) {
            r->a[n + c + all*k] = most*w->a[c*n + k];
            r->a[k + all*(n + c)] = -most*w->a[c*n + k];
        }
    lw_rank_factor(r, 1e-12);
    return r->rank == 0 ? LW_OPEN : LW_OK;
}

/* One more solution of the factored equations: x for b (n_u + n_c), which is overwritten */
static void solve_again(lw_clearance_work *w, double *b, double *x)
{
    for (int c = 0; c < w->n_c; c++)
        b[w->n_u + c] *= w->heaviest;
    lw_rank_solve(&w->kkt, b, x);
    for (int c = 0; c < w->n_c; c++)
        x[w->n_u + c] *= w->heaviest;
}

static lw_status solve_constrained(lw_clearance_work *w, double *ddu)
{
    int n = w->n_u;
    double b[ROW_MAX];
    lw_status s = factor_constrained(w);
    if (s != LW_OK)
        return s;
    memcpy(b, w->load, sizeof(double)*(size_t)n);
    memcpy(b + n, w->wanted, sizeof(double)*(size_t)w->n_c);
    solve_again(w, b, w->answer);
    memcpy(ddu, w->answer, sizeof(double)*(size_t)n);
    memcpy(w->lambda, w->answer + n, sizeof(double)*(size_t)w->n_c);
    return LW_OK;
}

/* ---- friction of joints without clearance ----------------------------------------------------------- */

static void reaction_of(const void *context, int j, const double *multiplier, double *out)
{
    const lw_clearance_work *w = context;
    lw_vec2 f = lw_friction_reaction(&w->c->s, w->c->friction[j].joint, multiplier + w->friction_row[j]);
    out[0] = f.x, out[1] = f.y;
}

static const char *name_of(const void *context, int j)
{
    const lw_clearance_scene *c = ((const lw_clearance_work *)context)->c;
    return c->m->linkage.joint[c->friction[j].joint].name;
}

/* Change ddu and the multipliers, found without friction, to those with it. */
static lw_status add_friction(lw_clearance_work *w, double t, const double *du, double *ddu)
{
    const lw_clearance_scene *c = w->c;
    double b[ROW_MAX], force[LW_SYSTEM_Q_MAX], size[LW_JOINT_MAX];
    int all = w->n_u + w->n_c;
    lw_tree_write(&c->tree, &w->state, du, w->q, w->v);
    for (int k = 0; k < c->n_friction; k++) {
        memset(b, 0, sizeof(double)*(size_t)all);
        memset(force, 0, sizeof(double)*(size_t)c->s.n_q);
        lw_friction_force(&c->s, &c->friction[k], w->q, w->v, 1, force);
        lw_clearance_through_tree(w, force, b);
        solve_again(w, b, w->response + k*all);
    }
    return lw_friction_add(&(lw_friction_scene){ w, 2, reaction_of, name_of }, c->n_friction, c->friction, w->response, t, w->n_u,
                           ddu, w->n_c, w->lambda, size, NULL, &w->undetermined);
}

/* ---- accelerations ------------------------------------------------------------------------------- */

lw_status lw_clearance_accelerate(lw_clearance_work *w, double t, const double *u, const double *du, double *ddu)
{
    lw_tree_place(&w->c->tree, u, du, &w->state);
    fill_mass(w);
    fill_load(w, t, du);
    w->n_c = lw_clearance_count_rows(w->c, &w->rows);
    if (w->n_c == 0) {
        memcpy(ddu, w->load, sizeof(double)*(size_t)w->n_u);
        return solve_free(w, ddu);
    }
    lw_status s = fill_rows(w, &w->rows, t, du, true);
    if (s == LW_OK)
        s = solve_constrained(w, ddu);
    return s == LW_OK && w->c->n_friction > 0 ? add_friction(w, t, du, ddu) : s;
}

lw_status lw_clearance_respond(lw_clearance_work *w, double t, const double *u, const double *du, const double *g, double *out)
{
    double b[ROW_MAX] = { 0.0 };
    size_t bytes = sizeof(double)*(size_t)w->n_u;
    lw_tree_place(&w->c->tree, u, du, &w->state);
    fill_mass(w);
    w->n_c = lw_clearance_count_rows(w->c, &w->rows);
    if (w->n_c == 0) {
        memcpy(out, g, bytes);
        return solve_free(w, out);
    }
    lw_status s = fill_rows(w, &w->rows, t, du, true);
    if (s == LW_OK)
        s = factor_constrained(w);
    if (s != LW_OK)
        return s;
    memcpy(b, g, bytes);
    solve_again(w, b, w->answer);
    memcpy(out, w->answer, bytes);
    return LW_OK;
}

double lw_clearance_compliance(lw_clearance_work *w, int i, const double *u, const double *du)
{
    double most = 0.0, g[LW_SYSTEM_Q_MAX], unit = w->c->s.unit;
    for (int axis = 0; axis < 2; axis++) {
        lw_tree_place(&w->c->tree, u, du, &w->state);
        fill_mass(w);
        lw_play p = lw_clearance_play(w, i, du);
        memset(g, 0, sizeof(double)*(size_t)w->n_u);
        push_apart(w, i, &p, axis ? lw_v2(0.0, unit) : lw_v2(unit, 0.0), g);
        memcpy(w->load, g, sizeof(double)*(size_t)w->n_u);
        if (solve_free(w, w->load) != LW_OK)
            return 0.0;
        double sum = 0.0;
        for (int k = 0; k < w->n_u; k++)
            sum += g[k]*w->load[k];
        most = fmax(most, sum);
    }
    return most;
}

int lw_clearance_lightest(lw_clearance_work *w, const double *u)
{
    const lw_tree *t = &w->c->tree;
    int least = 0, body = 0;
    lw_tree_place(t, u, NULL, &w->state);
    fill_mass(w);
    for (int k = 1; k < w->n_u; k++)
        least = w->mass[k*w->n_u + k] < w->mass[least*w->n_u + least] ? k : least;
    for (int b = 0; b < t->n_body; b++) {
        int first = t->hang[b].coordinate, n = t->hang[b].kind == LW_TREE_FREE ? 3 : 1;
        body = first >= 0 && least >= first && least < first + n ? b : body;
    }
    return body;
}

/* ---- projection ---------------------------------------------------------------------------------- */

/* The least x (n_u) with A x = b (n_c, overwritten) */
static void fit_rows(lw_clearance_work *w, double *b, double *x)
{
    lw_rank_place(&w->fit, w->n_c, w->n_u, w->fit.a, w->fit.column);
    for (int c = 0; c < w->n_c; c++)
        for (int k = 0; k < w->n_u; k++)
            w->fit.a[c + w->n_c*k] = w->a[c*w->n_u + k];
    lw_rank_factor(&w->fit, 1e-11);
    lw_rank_solve(&w->fit, b, x);
}

lw_status lw_clearance_project(lw_clearance_work *w, const lw_row_choice *choice, double t, double *u, double *du)
{
    double x[LW_SYSTEM_Q_MAX], before = INFINITY;
    if (lw_clearance_count_rows(w->c, choice) == 0)
        return LW_OK;
    for (int round = 0; ; round++) {
        lw_tree_place(&w->c->tree, u, du, &w->state);
        lw_status s = fill_rows(w, choice, t, du, false);
        if (s != LW_OK)
            return s;
        double off = 0.0;
        for (int c = 0; c < w->n_c; c++)
            off = fmax(off, fabs(w->off[c]));
        if (off <= 1e-15 || (off < 1e-12 && off > 0.25*before))
            break;
        if (!(off < 1e3) || round == 60)
            return LW_OPEN;
        before = off;
        fit_rows(w, w->off, x);
        for (int k = 0; k < w->n_u; k++)
            u[k] -= x[k];
    }
    for (int c = 0; c < w->n_c; c++)
        for (int k = 0; k < w->n_u; k++)
            w->wanted[c] -= w->a[c*w->n_u + k]*du[k];
    fit_rows(w, w->wanted, x);
    for (int k = 0; k < w->n_u; k++)
        du[k] += x[k];
    return LW_OK;
}
