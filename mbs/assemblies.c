/* Loops over the complex numbers: of a direction u = e^{i phi}, phi complex, both u and its counterpart v = 1/u
 * (conjugates where phi is real) are kept, and of a loop sum C u + ... = 0 its counterpart sum C' v + ... = 0, where
 * C = x + iy, C' = x - iy with complex x and y.  Newton's method in phi and d. */
#include "mbs/assemblies.h"

#include <complex.h>
#include <stdlib.h>
#include <string.h>
#include "base/rng.h"
#include "mbs/plan_internal.h"

#undef I
#define J ((double complex){ 0.0 + 1.0*_Complex_I })
typedef double complex cplx;

/* Numbers the loops depend on: dimensions, then x and y of each known point. */
#define NUMBER_MAX (LW_DIM_MAX + 2*LW_HIGHER_TERM_MAX)
typedef struct numbers { cplx v[NUMBER_MAX]; } numbers;
typedef struct solution { cplx u[LW_UNKNOWN_MAX], v[LW_UNKNOWN_MAX], d[LW_UNKNOWN_MAX + 1]; } solution;

typedef struct search {
    const lw_plan   *plan;
    const lw_higher *g;
    int      n, n_number;
    double   size;
    lw_vec2  reg[LW_REG_MAX];
    const double *dim;
    lw_rng   rng;
    cplx     f[LW_UNKNOWN_MAX], jac[LW_UNKNOWN_MAX][LW_UNKNOWN_MAX];
    cplx     du[LW_HIGHER_DIR_MAX], dv[LW_HIGHER_DIR_MAX];
    int      n_found;
    solution found[LW_ASSEMBLY_MAX];
} search;

/* ---- loops ---------------------------------------------------------------------------------------------- */

static void directions(search *q, const solution *s)
{
    const lw_higher *g = q->g;
    for (int a = 0; a < g->n_dir; a++) {
        const lw_higher_dir *d = &g->dir[a];
        if (d->base < 0) {
            q->du[a] = d->root >= 0 ? s->u[d->root] : q->reg[d->reg].x + J*q->reg[d->reg].y;
            q->dv[a] = d->root >= 0 ? s->v[d->root] : q->reg[d->reg].x - J*q->reg[d->reg].y;
            continue;
        }
        lw_vec2 by = d->dim >= 0 ? lw_v2_polar(1, q->dim[d->dim]) : q->reg[d->reg];
        double y = d->input < 0 ? -by.y : by.y;
        q->du[a] = q->du[d->base]*(by.x + J*y);
        q->dv[a] = q->dv[d->base]*(by.x - J*y);
    }
}

/* Add a vector c u (counterpart t v) of direction `dir` to its loop, and to the column of the turn that moves it. */
static void add_vector(search *q, int loop, int dir, cplx cu, cplx tv)
{
    int root = q->g->dir[dir].root;
    q->f[2*loop] += cu;
    q->f[2*loop + 1] += tv;
    if (root < 0)
        return;
    q->jac[2*loop][root] += J*cu;
    q->jac[2*loop + 1][root] -= J*tv;
}

static void loops(search *q, const numbers *p, const solution *s)
{
    const lw_higher *g = q->g;
    memset(q->f, 0, sizeof q->f);
    memset(q->jac, 0, sizeof q->jac);
    directions(q, s);
    for (int i = 0; i < g->n_point; i++) {
        cplx x = p->v[q->plan->n_dim + 2*i], y = p->v[q->plan->n_dim + 2*i + 1];
        q->f[2*g->point[i].loop] += g->point[i].sign*(x + J*y);
        q->f[2*g->point[i].loop + 1] += g->point[i].sign*(x - J*y);
    }
    for (int i = 0; i < g->n_vector; i++) {
        const lw_higher_vector *v = &g->vector[i];
        cplx x = v->x < 0 ? 0 : p->v[v->x], y = v->y < 0 ? 0 : p->v[v->y];
        add_vector(q, v->loop, v->dir, v->sign*(x + J*y)*q->du[v->dir], v->sign*(x - J*y)*q->dv[v->dir]);
    }
    for (int i = 0; i < g->n_slide; i++) {
        const lw_higher_slide *v = &g->slide[i];
        add_vector(q, v->loop, v->dir, v->sign*s->d[v->disp]*q->du[v->dir], v->sign*s->d[v->disp]*q->dv[v->dir]);
        if (v->disp < g->n_disp) {
            q->jac[2*v->loop][g->n_turn + v->disp] += v->sign*q->du[v->dir];
            q->jac[2*v->loop + 1][g->n_turn + v->disp] += v->sign*q->dv[v->dir];
        }
    }
}

/* Solve jac x = f in place; false when it is singular. */
static bool solve(search *q)
{
    int n = q->n;
    for (int c = 0; c < n; c++) {
        int best = c;
        for (int r = c + 1; r < n; r++)
            if (cabs(q->jac[r][c]) > cabs(q->jac[best][c]))
                best = r;
        if (!(cabs(q->jac[best][c]) > 1e-14*q->size))
            return false;
        for (int k = 0; k < n; k++) {
            cplx t = q->jac[c][k];
            q->jac[c][k] = q->jac[best][k];
            q->jac[best][k] = t;
        }
        cplx t = q->f[c];
        q->f[c] = q->f[best];
        q->f[best] = t;
        for (int r = c + 1; r < n; r++) {
            cplx a = q->jac[r][c]/q->jac[c][c];
            for (int k = c; k < n; k++)
                q->jac[r][k] -= a*q->jac[c][k];
            q->f[r] -= a*q->f[c];
        }
    }
    for (int c = n - 1; c >= 0; c--) {
        for (int k = c + 1; k < n; k++)
            q->f[c] -= q->jac[c][k]*q->f[k];
        q->f[c] /= q->jac[c][c];
    }
    return true;
}

/* One step of Newton's method; its length, INFINITY when there is none. */
static double newton(search *q, const numbers *p, solution *s)
{
    const lw_higher *g = q->g;
    double length = 0;
    loops(q, p, s);
    if (!solve(q))
        return INFINITY;
    for (int a = 0; a < q->n; a++) {
        double size = cabs(q->f[a])/(a < g->n_turn ? 1 : q->size);
        length = fmax(length, isfinite(size) ? size : INFINITY);
    }
    if (!(length < 1))
        return INFINITY;
    for (int a = 0; a < g->n_turn; a++) {
        cplx turn = cexp(-J*q->f[a]);
        s->u[a] *= turn;
        s->v[a] = 1/s->u[a];
    }
    for (int d = 0; d < g->n_disp; d++)
        s->d[d] -= q->f[g->n_turn + d];
    return length;
}

/* ---- ways ------------------------------------------------------------------------------------------------ */

/* Carry s from numbers a to b along a straight line, in steps on which Newton's method gains at least a digit a
 * step from a first one that is short. */
static bool carry(search *q, const numbers *a, const numbers *b, solution *s)
{
    double at = 0, step = 0.05;
    for (int i = 0; i < 4000 && at < 1; i++) {
        double to = at + step >= 1 ? 1 : at + step;
        numbers p;
        solution t = *s;
        for (int k = 0; k < q->n_number; k++)
            p.v[k] = a->v[k] + to*(b->v[k] - a->v[k]);
        double first = newton(q, &p, &t), next = first < 0.08 ? newton(q, &p, &t) : INFINITY, last = next;
        for (int k = 0; k < 3 && last < 0.1*first && last > 1e-13; k++)
            last = newton(q, &p, &t);
        if (next < 0.1*first && last < 1e-10) {
            *s = t;
            at = to;
            step *= first < 0.02 ? 2 : 1;
        } else if ((step *= 0.4) < 1e-7)
            return false;
    }
    return at >= 1;
}

static bool same(const search *q, const solution *a, const solution *b)
{
    for (int i = 0; i < q->g->n_turn; i++)
        if (cabs(a->u[i] - b->u[i]) > 1e-6*(cabs(a->u[i]) + 1e-3) || cabs(a->v[i] - b->v[i]) > 1e-6*(cabs(a->v[i]) + 1e-3))
            return false;
    for (int i = 0; i < q->g->n_disp; i++)
        if (cabs(a->d[i] - b->d[i]) > 1e-6*(q->size + cabs(a->d[i])))
            return false;
    return true;
}

static bool keep(search *q, const solution *s)
{
    for (int i = 0; i < q->n_found; i++)
        if (same(q, &q->found[i], s))
            return false;
    if (q->n_found == LW_ASSEMBLY_MAX)
        return false;
    q->found[q->n_found++] = *s;
    return true;
}

static void by_chance(search *q, const numbers *centre, numbers *p)
{
    for (int k = 0; k < q->n_number; k++)
        p->v[k] = centre->v[k] + q->size*(lw_rng_range(&q->rng, -1, 1) + J*lw_rng_range(&q->rng, -1, 1));
}

/* All known solutions round a triangle of numbers; how many new ones came back. */
static int go_round(search *q, const numbers *base, const numbers *centre)
{
    numbers a, b;
    int before = q->n_found, n = 0;
    by_chance(q, centre, &a);
    by_chance(q, centre, &b);
    for (int i = 0; i < before; i++) {
        solution s = q->found[i];
        if (carry(q, base, &a, &s) && carry(q, &a, &b, &s) && carry(q, &b, base, &s))
            n += keep(q, &s);
    }
    return n;
}

/* ---- the whole ------------------------------------------------------------------------------------------- */

/* Three links on one, each joined to it and to known links by pins. */
static bool is_triad(const lw_higher *g) { return g->n_link == 4 && g->n_disp == 0 && g->n_turn == 4; }

static bool start(search *q, const double *mode, double input, numbers *real, solution *s)
{
    const lw_higher *g = q->g;
    if (lw_pose_registers(q->plan, q->dim, mode, input, q->reg) < 0)
        return false;
    for (int d = 0; d < q->plan->n_dim; d++)
        real->v[d] = q->dim[d];
    for (int i = 0; i < g->n_point; i++) {
        real->v[q->plan->n_dim + 2*i] = q->reg[g->point[i].reg].x;
        real->v[q->plan->n_dim + 2*i + 1] = q->reg[g->point[i].reg].y;
    }
    q->n_number = q->plan->n_dim + 2*g->n_point;
    memset(s, 0, sizeof *s);
    for (int a = 0; a < g->n_turn; a++) {
        lw_vec2 u = q->reg[g->turn_reg[a]];
        s->u[a] = u.x + J*u.y;
        s->v[a] = u.x - J*u.y;
    }
    for (int d = 0; d < g->n_disp + g->disp_input; d++)
        s->d[d] = q->reg[g->disp_reg[d]].x;
    return true;
}

/* Is s a posture?  Then put it into row i. */
static bool posture(search *q, const numbers *real, const solution *s, double *mode, double *residual)
{
    const lw_higher *g = q->g;
    solution t = *s;
    double scatter = 0;
    for (int a = 0; a < g->n_turn; a++) {
        if (!(fabs(cabs(s->u[a]) - 1) < 1e-7))
            return false;
        t.u[a] = s->u[a]/cabs(s->u[a]);
        t.v[a] = conj(t.u[a]);
    }
    for (int d = 0; d < g->n_disp; d++) {
        if (!(fabs(cimag(s->d[d])) < 1e-7*q->size))
            return false;
        t.d[d] = creal(s->d[d]);
    }
    for (int i = 0; i < 3; i++)
        newton(q, real, &t);
    loops(q, real, &t);
    for (int r = 0; r < q->n; r++)
        scatter = fmax(scatter, cabs(q->f[r])/q->size);
    *residual = fmax(*residual, scatter);
    for (int a = 0; a < g->n_turn; a++)
        *mode++ = carg(t.u[a]);
    for (int d = 0; d < g->n_disp; d++)
        *mode++ = creal(t.d[d])/q->size;
    return true;
}

/* Carry a solution to the dimensions wanted and keep it; another way round when it is lost or one that is there already. */
static bool arrive(search *q, const numbers *base, const numbers *real, const solution *from, solution *t)
{
    for (int tries = 0; tries < 5; tries++) {
        numbers by = *base;
        *t = *from;
        if (tries > 0)
            by_chance(q, real, &by);
        if ((tries == 0 || carry(q, base, &by, t)) && carry(q, &by, real, t) && keep(q, t))
            return true;
    }
    return false;
}

static lw_status run(search *q, const double *mode, double input, int patience, lw_assemblies *found)
{
    numbers real, base;
    solution s;
    if (!start(q, mode, input, &real, &s))
        return LW_OPEN;
    for (int tries = 0; tries < 20 && q->n_found == 0; tries++) {
        solution t = s;
        by_chance(q, &real, &base);
        if (carry(q, &real, &base, &t))
            keep(q, &t);
    }
    int bound = is_triad(q->g) ? 6 : LW_ASSEMBLY_MAX;
    for (int quiet = 0; quiet < patience && q->n_found < bound; found->rounds++)
        quiet = go_round(q, &base, &real) ? 0 : quiet + 1;
    found->n_complex = q->n_found;
    found->complete = is_triad(q->g) && q->n_found == 6;
    int n = q->n_found;
    q->n_found = 0;
    for (int i = 0; i < n; i++) {
        const solution from = q->found[i];
        solution t;
        if (arrive(q, &base, &real, &from, &t) &&
            posture(q, &real, &t, found->mode[found->n_real], &found->residual))
            found->n_real++;
    }
    return n == LW_ASSEMBLY_MAX ? LW_STOPPED : LW_OK;
}

lw_status lw_assemblies_find(const lw_plan *plan, const double *dim, const double *mode, double input, int group,
                             uint64_t seed, int patience, lw_assemblies *found, lw_error *e)
{
    memset(found, 0, sizeof *found);
    if (group < 0 || group >= plan->n_higher)
        return lw_error_set(e, LW_E_ARG, "there is no higher group %d; the plan has %d", group + 1, plan->n_higher);
    if (plan->higher[group].n_gear > 0)
        return lw_error_set(e, LW_E_KIND, "assemblies are found of groups of pins and slides; this one has gears");
    search *q = calloc(1, sizeof *q);
    if (!q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for the assemblies of a group");
    q->plan = plan;
    q->g = &plan->higher[group];
    q->n = 2*q->g->n_loop;
    q->dim = dim;
    q->size = lw_plan_size(plan, dim);
    lw_rng_seed(&q->rng, seed, 77);
    lw_status s = run(q, mode, input, patience > 0 ? patience : 12, found);
    free(q);
    return s;
}
