/* mbs/dynamics/touch_shares.c - places that share a load which rigid bodies do not determine.
 *
 * A box that stands on two corners sticks with both, but one row holds it; the other is left out, since it depends on the rows that are held, and
 * so are the normal forces of a third point in line.  How much each place carries is not determined; that friction holds means that some
 * sharing keeps to all limits:
 *
 *     x_k = held force k by its row - sum over j of s_j c_kj,   N_k >= 0,  |T_k| <= mu N_k,
 *
 * with the redundant forces s_j, of which c_j are the multipliers that a unit of s_j takes from the rows.  The sharing that stays farthest from the
 * limits is a linear program; the one that is printed, with the least sum of squares of all forces within the limits, as equal places that give way would
 * share, is a quadratic one. */
#include "base/real.h"
#include "mbs/dynamics/touch_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/lcp.h"

/* Conditions, each  a.s + b >= margin : one of a normal force, two of a tangential one; and the bound of the margin. */
static int condition_max(const struct lw_touching *w) { return 2*(w->n_row + w->n_redundant) + 1; }

static const double within = 1e-9;           /* how far a printed force may be beyond its limit, over the greatest force */

static int unknown_max(const struct lw_touching *w) { return 2*w->n_redundant + 1 + condition_max(w); }

lw_status lw_mbs_touch_share_make(lw_dynamics *d)
{
    struct lw_touching *w = d->touch;
    size_t n = (size_t)unknown_max(w), forces = (size_t)(w->n_row + w->n_redundant);
    free(w->share);
    w->share = NULL;
    if (w->n_redundant == 0)
        return LW_OK;
    w->share = calloc((size_t)w->n_redundant + n*n + 2*n + lw_lcp_work((int)n) + (forces + (size_t)condition_max(w))*((size_t)w->n_redundant + 2) +
                      2*(size_t)d->n_v, sizeof *w->share);
    return w->share ? LW_OK : LW_E_MEMORY;
}

static lw_touch_row force_at(const struct lw_touching *w, int k) { return k < w->n_row ? w->row[k] : w->redundant[k - w->n_row]; }

/* The multipliers d->l_each (n_c) by which the rows take the load `row` (n_v), which depends on them; change: scratch (n_v). */
static void take_load(lw_dynamics *d, const double *row, double *change)
{
    if (!d->by_rank) {
        lw_mbs_impulse(d, row, change);
        return;
    }
    memcpy(change, row, (size_t)d->n_v*sizeof *change);
    lw_rank_solve(&d->rank_of, change, d->l_each);
}

/* Add `by` times the direction in which redundant force j pushes to row (n_v). */
static void add_load(const lw_dynamics *d, int j, double by, double *row)
{
    const lw_touch *p = &d->touch->list.touch[d->touch->redundant[j].touch];
    lw_touch_motion m;
    lw_touch_at(p, &d->eq, d->frames, NULL, &m);
    for (int i = 0; i < 6; i++)
        if (p->body[i/3] >= 0)
            row[3*p->body[i/3] + i%3] += by*(d->touch->redundant[j].tangent ? m.t : m.n)[i];
}

/* Forces (rows of 1 + n_redundant numbers): by the rows, and per unit of each redundant force.  A redundant force that would change the friction of a place
 * that slips is left 0. */
static void find_forces(lw_dynamics *d, const double *l, double *force, double *row, double *change)
{
    struct lw_touching *w = d->touch;
    int first = d->n_c - w->n_row, width = 1 + w->n_redundant;
    memset(force, 0, (size_t)((w->n_row + w->n_redundant)*width)*sizeof *force);
    for (int k = 0; k < w->n_row; k++)
        force[k*width] = -l[first + k];
    for (int j = 0; j < w->n_redundant; j++) {
        bool slips = false;
        memset(row, 0, (size_t)d->n_v*sizeof *row);
        add_load(d, j, 1, row);
        take_load(d, row, change);
        for (int k = 0; k < w->n_row && !slips; k++)
            slips = slips || (w->list.touch[w->row[k].touch].slips != 0 && fabs(d->l_each[first + k]) > 1e-9);
        for (int k = 0; k < w->n_row && !slips; k++)
            force[k*width + 1 + j] = -d->l_each[first + k];
        force[(w->n_row + j)*width + 1 + j] = !slips;
    }
}

/* The number of the normal force at the place; -1: it has none. */
static int normal_at(const struct lw_touching *w, int touch)
{
    for (int k = 0; k < w->n_row + w->n_redundant; k++)
        if (force_at(w, k).touch == touch && !force_at(w, k).tangent)
            return k;
    return -1;
}

/* Conditions (rows of 2 + n_redundant numbers): b, a, and the number of the force.  Returns how many. */
static int list_conditions(lw_dynamics *d, const double *v, const double *force, double *to)
{
    const struct lw_touching *w = d->touch;
    int width = 1 + w->n_redundant, n = 0;
    for (int k = 0; k < w->n_row + w->n_redundant; k++) {
        lw_touch_row own = force_at(w, k);
        const lw_touch *p = &w->list.touch[own.touch];
        int normal = own.tangent ? normal_at(w, own.touch) : -1;
        lw_touch_motion m;
        double pressed = 0;
        if (own.tangent && normal < 0) {                 /* a compliant place */
            lw_touch_at(p, &d->eq, d->frames, v, &m);
            pressed = lw_touch_force(p->surface, d->s.unit, -m.gap, -m.rate)*d->s.unit;
        }
        for (int sign = 1; sign >= (own.tangent ? -1 : 1); sign -= 2) {
            double *c = to + n++*(width + 1);
            for (int i = 0; i < width; i++)
                c[i] = sign*force[k*width + i] + (normal >= 0 ? p->surface->friction*force[normal*width + i] : 0);
            c[0] += w->least_force + p->surface->friction*pressed;
            c[width] = k;
        }
    }
    return n;
}

/* The greatest margin, not above `scale`, from n conditions; `least` is that without further redundant forces.  As a complementarity problem with
 * z = (redundant forces upwards, downwards, margin beyond `least`, multipliers of the conditions). */
static double solve_program(const struct lw_touching *w, int n, const double *c, double least, double scale, double *m, double *q, double *z, double *work)
{
    int r = w->n_redundant, x = 2*r + 1, all = x + n + 1;
    memset(m, 0, (size_t)all*(size_t)all*sizeof *m);
    memset(q, 0, (size_t)all*sizeof *q);
    q[2*r] = -1;
    for (int i = 0; i <= n; i++) {                       /* the last is the bound */
        const double *a = c + i*(r + 2);
        q[x + i] = ((i < n ? a[0] : scale) - least)/scale;
        for (int j = 0; j < x; j++) {
            double by = j == 2*r ? 1 : i == n ? 0 : j < r ? -a[1 + j] : a[1 + j - r];
            m[(x + i)*all + j] = -by;
            m[j*all + x + i] = by;
        }
    }
    return lw_lcp_solve(all, m, q, work, z) == LW_OK ? least + scale*z[2*r] : least;
}

/* The redundant forces with which the sum of squares of all forces is least, within n conditions that may be off by `slack`; false: not found.  force: as
 * find_forces gives it. */
static bool solve_squares(const struct lw_touching *w, int n, const double *c, const double *force, double slack, double *m, double *q, double *z, double *work)
{
    int r = w->n_redundant, x = 2*r, all = x + n, width = 1 + r;
    memset(m, 0, (size_t)all*(size_t)all*sizeof *m);
    memset(q, 0, (size_t)all*sizeof *q);
    for (int k = 0; k < w->n_row + r; k++) {
        const double *f = force + k*width;
        for (int i = 0; i < x; i++) {
            double by = i < r ? f[1 + i] : -f[1 + i - r];
            q[i] += by*f[0];
            for (int j = 0; j < x; j++)
                m[i*all + j] += by*(j < r ? f[1 + j] : -f[1 + j - r]);
        }
    }
    for (int i = 0; i < n; i++) {
        const double *a = c + i*(r + 2);
        q[x + i] = a[0] + slack;
        for (int j = 0; j < x; j++) {
            double by = j < r ? a[1 + j] : -a[1 + j - r];
            m[(x + i)*all + j] = by;
            m[j*all + x + i] = -by;
        }
    }
    return lw_lcp_solve(all, m, q, work, z) == LW_OK;
}

/* Where the parts of w->share begin; see lw_mbs_touch_share_make. */
typedef struct program { double *redundant, *m, *q, *z, *work, *force, *c, *row, *change; } program;

static program parts(const lw_dynamics *d)
{
    const struct lw_touching *w = d->touch;
    int r = w->n_redundant, all = unknown_max(w);
    program p = { .redundant = w->share, .m = w->share + r };
    p.q = p.m + (size_t)all*(size_t)all;
    p.z = p.q + all;
    p.work = p.z + all;
    p.force = p.work + lw_lcp_work(all);
    p.c = p.force + (w->n_row + r)*(1 + r);
    p.row = p.c + condition_max(w)*(2 + r);
    p.change = p.row + d->n_v;
    return p;
}

double lw_mbs_touch_share(lw_dynamics *d, const double *v, const double *l)
{
    struct lw_touching *w = d->touch;
    program p = parts(d);
    int r = w->n_redundant, width = 1 + r, forces = w->n_row + r;
    double *c = p.c, least = INFINITY, scale = 0;
    find_forces(d, l, p.force, p.row, p.change);
    int n = list_conditions(d, v, p.force, c), first = 2*r + 1;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < r; j++)                      /* the redundant forces found last often do */
            c[i*(width + 1)] += p.redundant[j]*c[i*(width + 1) + 1 + j];
        least = fmin(least, c[i*(width + 1)]);
        scale = fmax(scale, fabs(c[i*(width + 1)]));
    }
    if (least > 0 || n == 0)
        return least;
    double margin = solve_program(w, n, c, least, scale, p.m, p.q, p.z, p.work);
    for (int j = 0; margin > 0 && j < r; j++)
        p.redundant[j] += scale*(p.z[j] - p.z[r + j]);
    if (margin > 0)
        return margin;
    for (int k = 0; k < forces; k++)
        w->list.touch[force_at(w, k).touch].yields = false;
    for (int i = 0; i < n; i++) {
        lw_touch_row own = force_at(w, (int)c[i*(width + 1) + width]);
        if (own.tangent && p.z[first + i] > 1e-9)
            w->list.touch[own.touch].yields = true;
    }
    return margin;
}

void lw_mbs_touch_spread(lw_dynamics *d, const double *v, double *l)
{
    struct lw_touching *w = d->touch;
    if (w->n_redundant == 0)
        return;
    program p = parts(d);
    int r = w->n_redundant;
    double greatest = 0;
    find_forces(d, l, p.force, p.row, p.change);
    int n = list_conditions(d, v, p.force, p.c);
    for (int k = 0; k < w->n_row + r; k++)
        greatest = fmax(greatest, fabs(p.force[k*(1 + r)]));
    bool found = solve_squares(w, n, p.c, p.force, within*greatest, p.m, p.q, p.z, p.work);
    memset(p.row, 0, (size_t)d->n_v*sizeof *p.row);
    for (int j = 0; j < r; j++) {
        p.redundant[j] = found ? p.z[j] - p.z[r + j] : p.redundant[j];
        add_load(d, j, p.redundant[j], p.row);
    }
    take_load(d, p.row, p.change);
    for (int i = 0; i < d->n_c; i++)
        l[i] += d->l_each[i];
}
