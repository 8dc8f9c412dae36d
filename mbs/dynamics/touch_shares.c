/* mbs/dynamics/touch_shares.c - places that share a load which rigid bodies do not determine.
 *
 * A box that stands on two corners sticks with both, but one row holds it; the other is left out, since it depends on the rows that are held, and
 * so are the normal forces of a third point in line.  How much each place carries is not determined; that friction holds means that some
 * sharing keeps to all limits:
 *
 *     x_k = held force k by its row - sum over j of s_j c_kj,   N_k >= 0,  |T_k| <= mu N_k,
 *
 * with the redundant forces s_j, of which c_j are the multipliers that a unit of s_j takes from the rows.  The sharing that stays farthest from the
 * limits is a linear program. */
#include "base/real.h"
#include "mbs/dynamics/touch_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/lcp.h"

/* Conditions, each  a.s + b >= margin : one of a normal force, two of a tangential one; and the bound of the margin. */
static int condition_max(const struct lw_touching *w) { return 2*(w->n_row + w->n_redundant) + 1; }

static int unknown_max(const struct lw_touching *w) { return 2*w->n_redundant + 1 + condition_max(w); }

lw_status lw_mbs_touch_share_make(lw_dynamics *d)
{
    struct lw_touching *w = d->touch;
    size_t n = (size_t)unknown_max(w), forces = (size_t)(w->n_row + w->n_redundant);
    free(w->share);
    w->share = NULL;
    if (w->n_redundant == 0)
        return LW_OK;
    w->share = calloc((size_t)w->n_redundant + n*n + 2*n + lw_lcp_work((int)n) + (forces + (size_t)condition_max(w))*((size_t)w->n_redundant + 2) + 2*(size_t)d->n_v, sizeof *w->share);
    return w->share ? LW_OK : LW_E_MEMORY;
}

static lw_touch_row force_at(const struct lw_touching *w, int k) { return k < w->n_row ? w->row[k] : w->redundant[k - w->n_row]; }

/* Forces (rows of 1 + n_redundant numbers): by the rows, and per unit of each redundant force.  A redundant force that would change the friction of a place
 * that slips is left 0. */
static void find_forces(lw_dynamics *d, const double *v, const double *l, double *force, double *row, double *change)
{
    struct lw_touching *w = d->touch;
    int first = d->n_c - w->n_row, width = 1 + w->n_redundant;
    memset(force, 0, (size_t)((w->n_row + w->n_redundant)*width)*sizeof *force);
    for (int k = 0; k < w->n_row; k++)
        force[k*width] = -l[first + k];
    for (int j = 0; j < w->n_redundant; j++) {
        const lw_touch *p = &w->list.touch[w->redundant[j].touch];
        lw_touch_motion m;
        bool slips = d->by_rank;                         /* then there are no multipliers */
        lw_touch_at(p, &d->eq, d->frames, v, &m);
        memset(row, 0, (size_t)d->n_v*sizeof *row);
        for (int i = 0; i < 6; i++)
            if (p->body[i/3] >= 0)
                row[3*p->body[i/3] + i%3] += (w->redundant[j].tangent ? m.t : m.n)[i];
        if (!slips)
            lw_mbs_impulse(d, row, change);
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

double lw_mbs_touch_share(lw_dynamics *d, const double *v, const double *l)
{
    struct lw_touching *w = d->touch;
    int r = w->n_redundant, width = 1 + r, all = unknown_max(w), forces = w->n_row + r;
    double *redundant = w->share, *m = redundant + r, *q = m + (size_t)all*(size_t)all, *z = q + all, *work = z + all, *force = work + lw_lcp_work(all);
    double *c = force + forces*width, *row = c + condition_max(w)*(width + 1), least = INFINITY, scale = 0;
    find_forces(d, v, l, force, row, row + d->n_v);
    int n = list_conditions(d, v, force, c), first = 2*r + 1;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < r; j++)                      /* the redundant forces found last often do */
            c[i*(width + 1)] += redundant[j]*c[i*(width + 1) + 1 + j];
        least = fmin(least, c[i*(width + 1)]);
        scale = fmax(scale, fabs(c[i*(width + 1)]));
    }
    if (least > 0 || n == 0)
        return least;
    double margin = solve_program(w, n, c, least, scale, m, q, z, work);
    for (int j = 0; margin > 0 && j < r; j++)
        redundant[j] += scale*(z[j] - z[r + j]);
    if (margin > 0)
        return margin;
    for (int k = 0; k < forces; k++)
        w->list.touch[force_at(w, k).touch].yields = false;
    for (int i = 0; i < n; i++) {
        lw_touch_row own = force_at(w, (int)c[i*(width + 1) + width]);
        if (own.tangent && z[first + i] > 1e-9)
            w->list.touch[own.touch].yields = true;
    }
    return margin;
}
