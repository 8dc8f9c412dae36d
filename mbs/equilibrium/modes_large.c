/* mbs/equilibrium/modes_large.c - the slowest modes of models of any size: Lanczos's method on the inverse.
 *
 * (K + s M) z + J^T l = M x, J z = 0 gives z from x; the eigenvalues of this map are 1/(w^2 + s) (Ericsson & Ruhe 1980).  The
 * shift s makes the matrix regular where motions are free; a smaller one is taken for modes that are very slow beside it.
 * Vectors stay orthogonal in the metric of the masses by full orthogonalisation.  A run that starts anew, orthogonal to the modes
 * found, finds the further ones of equal frequency; it is repeated until it finds none below the greatest.  Models with few freedoms and no elastic
 * links are reduced to all their motions instead, which accelerations under random forces span, and solved as matrices.  Damped modes are those of
 * the equations reduced to twice as many undamped modes as are wanted, which is exact where damping is proportional to the stiffness; and, where it
 * is not, to what its forces and the masses bend besides (K z = C x, K z = M x), as a Krylov space of the damped equations has it (Bai & Su 2005).
 * Under loads without a potential, up to LW_SYSTEM_Q_MAX freedoms are solved as matrices, too.  More are reduced to a Krylov space that begins with
 * random vectors; those of its modes are kept that solve the whole equations. */
#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/rng.h"
#include "base/vector.h"
#include "base/eigen.h"
#include "mbs/dynamics/tangent_internal.h"
#include "mbs/equilibrium/vibration_internal.h"
#include "mbs/equations/limits_internal.h"

static const double shift_part = 1e-9;   /* of the greatest stiffness over mass */
static const double least_part = 1e-15;  /* the same, for modes that are slower still */
static const double doubtful = 1e-15;    /* the same for squares of rates that may be rounding */
enum { RANDOM_VECTORS = 4 };             /* at the start of a Krylov space: so many modes of equal frequency are told apart */

typedef struct lanczos {
    lw_dynamics *d;
    lw_tangent  *tangent;
    int     n, most;                 /* velocities; vectors */
    double  scale, shift;            /* greatest stiffness over mass; s */
    double t;
    const double *q;
    double *basis, *heavy;           /* (most + 1 vectors of n) vectors, and M times these */
    double *found, *found_heavy, *value;     /* modes, M times these, w^2 */
    int     n_found, n_mode;         /* n_mode of those found are modes */
    double *b;                       /* (n + c) */
} lanczos;

/* a.b as eight sums side by side: one sum waits for each addition. */
static double dot(int n, const double *a, const double *b)
{
    enum { LANES = 8 };
    double sum[LANES] = { 0 };
    int i = 0;
    for (; i + LANES <= n; i += LANES)
        for (int k = 0; k < LANES; k++)
            sum[k] += a[i + k]*b[i + k];
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7])) + lw_dot(n - i, a + i, b + i);
}

/* x loses its part along the modes found and along the first k vectors, twice; returns its length in the metric of the
 * masses, and M x in heavy. */
static double orthogonal(lanczos *z, double *x, double *heavy, int k)
{
    for (int twice = 0; twice < 2; twice++) {
        for (int j = 0; j < z->n_found; j++) {
            double part = dot(z->n, x, z->found_heavy + (size_t)j*(size_t)z->n);
            for (int i = 0; i < z->n; i++)
                x[i] -= part*z->found[(size_t)j*(size_t)z->n + (size_t)i];
        }
        for (int j = 0; j < k; j++) {
            double part = dot(z->n, x, z->heavy + (size_t)j*(size_t)z->n);
            for (int i = 0; i < z->n; i++)
                x[i] -= part*z->basis[(size_t)j*(size_t)z->n + (size_t)i];
        }
    }
    lw_tangent_mass(z->tangent, z->q, x, heavy);
    double size = sqrt(fmax(lw_dot(z->n, x, heavy), 0));
    for (int i = 0; size > 0 && i < z->n; i++) {
        x[i] /= size;
        heavy[i] /= size;
    }
    return size;
}

/* x = the map of what has the heavy vector `from`. */
static void apply(lanczos *z, const double *from, double *x)
{
    memcpy(z->b, from, (size_t)z->n*sizeof *z->b);
    memset(z->b + z->n, 0, (size_t)z->tangent->c*sizeof *z->b);
    lw_tangent_solve(z->tangent, z->b);
    memcpy(x, z->b, (size_t)z->n*sizeof *x);
}

/* Eigenvalues w of the tridiagonal matrix and their order by size; how many of the greatest have converged, at most `wanted`.
 * vectors (k rows): the last component of each eigenvector, or with rows = k whole vectors. */
static int ritz(int k, const double *alpha, const double *beta, int wanted, int rows, double *beside, double *vectors, double *w, int *order)
{
    int good = 0;
    memset(vectors, 0, (size_t)k*(size_t)rows*sizeof *vectors);
    for (int i = k - rows; i < k; i++)
        vectors[i*rows + i - (k - rows)] = 1;
    memcpy(w, alpha, (size_t)k*sizeof *w);
    memcpy(beside, beta, (size_t)k*sizeof *beside);
    if (k == 0 || lw_eigen_tridiagonal(k, w, beside, rows, vectors) != LW_OK)
        return 0;
    for (int i = 0; i < k; i++) {
        int at = i;
        for (; at > 0 && fabs(w[order[at - 1]]) < fabs(w[i]); at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
    while (good < wanted && good < k && fabs(w[order[good]]) > 0
           && fabs(beta[k - 1]*vectors[order[good]*rows + rows - 1]) <= 1e-10*fabs(w[order[good]]))
        good++;
    return good;
}

static lw_status look_at_limits(const lanczos *z) { return lw_limits_check(z->d->o.stop, z->d->o.until, true, z->t, NULL); }

/* One run of at most z->most vectors from a random one, until the modes wanted have converged.  Adds those that have, of the
 * greatest |1/(w^2 + s)| first and at most `wanted`; returns how many.  -1: out of memory. */
static int one_run(lanczos *z, lw_rng *rng, int wanted)
{
    int n = z->n, k = 0, look = wanted > 10 ? wanted : 10, good = 0, *order;
    size_t m = (size_t)z->most;
    double *work = calloc(m*m + 6*m + 5, sizeof *work), *alpha = work + m*m, *beta = alpha + m + 1, *w = beta + m + 1, *beside = w + m + 1;
    if (!work)
        return -1;
    order = (int *)(void *)(beside + m + 1);
    for (int i = 0; i < n; i++)
        z->heavy[i] = lw_rng_uniform(rng) - 0.5;
    for (int i = 0; i < n; i++)
        z->heavy[i] *= z->d->eq.mass[i];
    apply(z, z->heavy, z->basis);
    double size = orthogonal(z, z->basis, z->heavy, 0), least = 0;
    apply(z, z->heavy, z->basis);            /* twice: into the motions that the rows allow */
    size = orthogonal(z, z->basis, z->heavy, 0);
    for (k = 0; k < z->most && size > least && look_at_limits(z) == LW_OK; k++) {
        double *x = z->basis + (size_t)(k + 1)*(size_t)n, *heavy = z->heavy + (size_t)(k + 1)*(size_t)n;
        apply(z, z->heavy + (size_t)k*(size_t)n, x);
        alpha[k] = lw_dot(n, x, z->heavy + (size_t)k*(size_t)n);
        beta[k] = size = orthogonal(z, x, heavy, k + 1);
        least = 1e-13*fabs(alpha[0]);
        if (k + 1 == look && look < z->most) {
            look += look/8 + 2;
            good = ritz(k + 1, alpha, beta, wanted, 1, beside, work, w, order);
            size = good < wanted ? size : 0;
        }
    }
    good = ritz(k, alpha, beta, wanted, k, beside, work, w, order);
    for (int pick = 0; pick < good; pick++) {
        const double *vector = work + (size_t)order[pick]*(size_t)k;
        double *to = z->found + (size_t)z->n_found*(size_t)n, *heavy = z->found_heavy + (size_t)z->n_found*(size_t)n;
        memset(to, 0, (size_t)n*sizeof *to);
        for (int j = 0; j < k; j++)
            for (int i = 0; i < n; i++)
                to[i] += vector[j]*z->basis[(size_t)j*(size_t)n + (size_t)i];
        lw_tangent_mass(z->tangent, z->q, to, heavy);
        double length = sqrt(lw_dot(n, to, heavy));
        for (int i = 0; i < n; i++) {
            to[i] /= length;
            heavy[i] /= length;
        }
        z->value[z->n_found++] = 1/w[order[pick]] - z->shift;
    }
    free(work);
    return good;
}

/* Fill the modes: at least `wanted` of the slowest, if there are as many. */
static lw_status find_modes(lanczos *z, int wanted, int room)
{
    lw_rng rng;
    lw_rng_seed(&rng, 1, 0);
    for (int run = 0; run < 20 && z->n_found < room; run++) {
        int before = z->n_found, ask = before < wanted ? wanted - before : 1;
        double slow = 0;
        for (int i = 0; i < before; i++)
            slow = fmax(slow, fabs(z->value[i]));
        int added = one_run(z, &rng, ask < room - before ? ask : room - before);
        if (added < 0)
            return LW_E_MEMORY;
        if (look_at_limits(z) != LW_OK)
            return LW_STOPPED;
        if (wanted == 1 && added > 0)        /* the slowest; others as slow make no difference */
            break;
        bool new_one = false;
        for (int i = before; i < z->n_found; i++)
            new_one = new_one || fabs(z->value[i]) < slow*(1 - 1e-9);
        if (added == 0 || (before >= wanted && !new_one))
            break;
    }
    return z->n_found > 0 ? LW_OK : LW_NOTHING;
}

static lw_status factor(lanczos *z, const double *q, double part, const double *l, double *still)
{
    z->shift = part*z->scale;
    lw_status s = lw_mbs_rows(z->d, z->t, q);
    return s == LW_OK ? lw_tangent_factor(z->tangent, z->t, q, still, l, (double[]){ z->shift, 0 }, (double[]){ 0, 0 }) : s;
}

static bool is_doubtful(const lanczos *z, int i) { return fabs(z->value[i]) < doubtful*z->scale; }

/* A mode this slow may be a free motion whose rate is rounding.  Its rate is found again in a posture displaced by rounding; if it differs by
 * 5 % there, the motion is free and its value becomes 0.  *slow: number of the others. */
static lw_status find_free(lanczos *z, const double *l, double *still, int *slow)
{
    size_t n = (size_t)z->n, n_q = (size_t)z->d->n_q;
    lw_rng rng;
    lw_rng_seed(&rng, 2, 0);
    double *q = calloc(n_q + 2*n, sizeof *q), *by = q + n_q, *x = by + n;
    if (!q)
        return LW_E_MEMORY;
    memcpy(q, z->q, n_q*sizeof *q);
    for (size_t i = 0; i < n; i++)
        by[i] = 4*DBL_EPSILON*(lw_rng_uniform(&rng) - 0.5);
    z->d->eq.move(z->d->eq.context, q, by);
    lw_status s = factor(z, q, least_part, l, still);
    for (int i = 0; i < z->n_found; i++) {
        const double *heavy = z->found_heavy + (size_t)i*n;
        if (!is_doubtful(z, i))
            continue;
        if (s == LW_OK)
            apply(z, heavy, x);
        double other = s == LW_OK ? 1/dot(z->n, x, heavy) - z->shift : 0;
        z->value[i] = fabs(other - z->value[i]) < 0.05*fabs(z->value[i]) ? z->value[i] : 0;
        *slow += z->value[i] != 0;
    }
    free(q);
    return s == LW_E_NUMERIC ? LW_OK : s;
}

/* Modes with the shift `part`, and which of them are free: *slow of those that are doubtful are not, of *doubted. */
static lw_status find_with_shift(lanczos *z, double part, int wanted, int room, const double *l, double *still, int *slow, int *doubted)
{
    *slow = *doubted = z->n_found = 0;
    lw_status s = factor(z, z->q, part, l, still);
    s = s == LW_OK ? find_modes(z, wanted, room) : s;
    for (int i = 0; i < z->n_found; i++)
        *doubted += is_doubtful(z, i);
    if (s == LW_OK && *doubted > 0 && (s = find_free(z, l, still, slow)) == LW_OK)
        s = factor(z, z->q, part, l, still);
    return s;
}

/* Exchange the doubtful modes, so many, for those of a smaller shift.  It loses the digits of faster modes, which stay. */
static lw_status find_slower(lanczos *z, int doubted, int room, const double *l, double *still)
{
    size_t n = (size_t)z->n;
    int fast = 0, slow, again, left = 0;
    double *keep = malloc((2*n + 1)*((size_t)z->n_found + 1)*sizeof *keep);
    if (!keep)
        return LW_E_MEMORY;
    for (int i = 0; i < z->n_found; i++) {
        double *to = keep + (2*n + 1)*(size_t)fast;
        memcpy(to, z->found + (size_t)i*n, n*sizeof *to);
        memcpy(to + n, z->found_heavy + (size_t)i*n, n*sizeof *to);
        to[2*n] = z->value[i];
        fast += !is_doubtful(z, i);
    }
    lw_status s = find_with_shift(z, least_part, doubted, room, l, still, &slow, &again);
    for (int i = 0; s == LW_OK && i < z->n_found + fast && left < room; i++) {
        const double *from = keep + (2*n + 1)*(size_t)(i - z->n_found);
        bool new_one = i < z->n_found;
        if (new_one && !is_doubtful(z, i))
            continue;
        memmove(z->found + (size_t)left*n, new_one ? z->found + (size_t)i*n : from, n*sizeof *from);
        memmove(z->found_heavy + (size_t)left*n, new_one ? z->found_heavy + (size_t)i*n : from + n, n*sizeof *from);
        z->value[left++] = new_one ? z->value[i] : from[2*n];
    }
    free(keep);
    z->n_found = s == LW_OK ? left : 0;
    return s == LW_OK ? factor(z, z->q, shift_part, l, still) : s;
}

/* The slowest modes, with a shift that the squares of most rates exceed; those far below it again with a smaller one. */
static lw_status find_slow(lanczos *z, int wanted, int room, const double *l, double *still)
{
    int slow, doubted;
    lw_status s = find_with_shift(z, shift_part, wanted, room, l, still, &slow, &doubted);
    if (s == LW_NOTHING)
        return find_with_shift(z, least_part, wanted, room, l, still, &slow, &doubted);
    return s == LW_OK && slow > 0 ? find_slower(z, doubted, room, l, still) : s;
}

static void see_damping(void *context, int row, int column, double by_q, double by_v)
{
    (void)row, (void)column, (void)by_q;
    *(bool *)context |= by_v != 0;
}

/* x^T A y of all pairs of modes for A = K or C, by columns of the derivatives. */
typedef struct product { const double *x; double *k, *c; } product;

static void multiply(void *context, int row, int column, double by_q, double by_v)
{
    product *p = context;
    p->k[row] -= by_q*p->x[column];
    p->c[row] -= by_v*p->x[column];
}

/* k, c (n) = K x, C x at rest; l NULL: of forces alone. */
static void multiply_all(lanczos *z, double t, const double *l, double *still, const double *x, double *k, double *c)
{
    lw_dynamics *d = z->d;
    product p = { x, k, c };
    memset(k, 0, (size_t)z->n*sizeof *k);
    memset(c, 0, (size_t)z->n*sizeof *c);
    d->eq.derivatives(d->eq.context, t, z->q, still, d->force, &(lw_force_sink){ .context = &p, .add = multiply });
    for (int r = 0; l && r < z->tangent->c; r++)
        for (int b = 0, count = lw_mbs_bends(d, d->kept[r]); b < count; b++)
            k[d->bend[b].a] += l[r]*d->bend[b].h*x[d->bend[b].b];
}

/* Remove from x the part that the rows of the joints forbid.  heavy: scratch. */
static lw_status project(lanczos *z, double *x, double *heavy)
{
    lw_dynamics *d = z->d;
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    for (int i = 0; i < z->n; i++)
        heavy[i] = x[i]/d->by_mass[i];
    return lw_mbs_linear(d, heavy, d->rhs, x, d->l);
}

/* Add to the vectors found what the damping forces and the masses of their motion bend, and those of what was added, in so many rounds;
 * at most `room` vectors in all. */
static void add_responses(lanczos *z, int rounds, int room, double t, double *still, double *k, double *c)
{
    static const double own = 1e-9;          /* part of a vector that is not in the others; less is rounding */
    int first = 0;
    for (int round = 0; round < rounds && first < z->n_found; round++) {
        int end = z->n_found;
        for (int j = first; j < end; j++) {
            size_t n = (size_t)z->n;
            multiply_all(z, t, NULL, still, z->found + (size_t)j*n, k, c);
            const double *push[2] = { c, z->found_heavy + (size_t)j*n };
            for (int i = 0; i < 2 && z->n_found < room; i++) {
                double *to = z->found + (size_t)z->n_found*n, *heavy = z->found_heavy + (size_t)z->n_found*n;
                apply(z, push[i], to);
                lw_tangent_mass(z->tangent, z->q, to, heavy);
                double whole = sqrt(fmax(lw_dot(z->n, to, heavy), 0));
                bool new_one = orthogonal(z, to, heavy, 0) > own*whole && project(z, to, heavy) == LW_OK;
                z->n_found += new_one && orthogonal(z, to, heavy, 0) > 0;
            }
        }
        first = end;
    }
}

/* A basis of all motions that the rows allow, instead of modes: for few freedoms. */
static lw_status find_basis(lanczos *z, int freedom)
{
    lw_rng rng;
    lw_rng_seed(&rng, 1, 0);
    for (z->n_found = 0; z->n_found < freedom; z->n_found++) {
        double *x = z->found + (size_t)z->n_found*(size_t)z->n, *heavy = z->found_heavy + (size_t)z->n_found*(size_t)z->n;
        for (int i = 0; i < z->n; i++)
            x[i] = lw_rng_uniform(&rng) - 0.5;
        for (int twice = 0; twice < 2; twice++)              /* rounding, too, stays in the motions that the rows allow */
            if (project(z, x, heavy) != LW_OK || !(orthogonal(z, x, heavy, 0) > 0))
                return LW_E_NUMERIC;
    }
    return LW_OK;
}

/* Matrices of the modes or of the basis; damping: with C, and of a basis as they are.  false: the loads have no potential, the stiffness
 * is not symmetric. */
static bool reduce(lanczos *z, bool are_modes, bool damping, double t, const double *l, lw_vibration *v, double *k, double *c, double *still)
{
    lw_dynamics *d = z->d;
    int n = z->n, m = z->n_found;
    for (int i = 0; i < m*m && are_modes; i++) {
        v->mass[i] = i/m == i%m;
        v->damping[i] = 0;
        v->stiffness[i] = i/m == i%m && i/m < z->n_mode ? z->value[i/m] : 0;
    }
    if (are_modes && d->eq.conservative)
        return true;
    for (int j = 0; j < m; j++) {
        const double *x = z->found + (size_t)j*(size_t)n;
        multiply_all(z, t, l, still, x, k, c);
        lw_tangent_mass(z->tangent, z->q, x, z->heavy);
        for (int i = 0; i < m; i++) {
            const double *y = z->found + (size_t)i*(size_t)n;
            v->stiffness[i*m + j] = dot(n, y, k);
            v->damping[i*m + j] = dot(n, y, c);
            v->mass[i*m + j] = are_modes ? i == j : lw_dot(n, y, z->heavy);
        }
    }
    for (int i = 0; i < m*m && !damping; i++)
        v->damping[i] = 0;
    if (damping && !are_modes && !d->eq.conservative)
        return true;
    /* stiffness of a potential is symmetric, in the modes diagonal and 0 between them and what is orthogonal to them, but for rounding */
    double rounding = 64*DBL_EPSILON*z->scale;
    for (int i = 0; i < m*m && !d->eq.conservative; i++) {
        int row = i/m, column = i%m;
        double size = sqrt(fabs(v->stiffness[row*m + row]*v->stiffness[column*m + column]));
        bool part = !are_modes || (row < z->n_mode && column < z->n_mode);
        if (part && fabs(v->stiffness[i] - v->stiffness[column*m + row]) > 1e-7*size + rounding)
            return false;
    }
    for (int i = 0; i < m*m; i++)
        if (are_modes && (i/m < z->n_mode || i%m < z->n_mode))
            v->stiffness[i] = i/m == i%m ? z->value[i/m] : 0;
        else
            v->stiffness[i] = v->stiffness[i%m*m + i/m] = 0.5*(v->stiffness[i] + v->stiffness[i%m*m + i/m]);
    return true;
}

/* Keep the modes of the reduced equations, from the slowest up to the first that does not solve the whole equations.  A mode with rate s and
 * shape x does if the part of x that the rows forbid, and (K + s' M)^-1 (s^2 M + s C + K) x with the shift s', are smaller than `exact` times x. */
static void keep_exact(lanczos *z, int wanted, double t, const double *l, double *still, double *k, double *c, lw_modes *modes)
{
    static const double exact = 1e-6;
    const size_t n = (size_t)z->n;
    double *x = z->basis, *heavy = x + n, *left[2] = { heavy + n, heavy + 2*n };
    for (int i = 0; i < modes->n_mode && i < wanted; i++) {
        const lw_mode *m = &modes->mode[i];
        const double square[2] = { m->re*m->re - m->im*m->im, 2*m->re*m->im };
        double size = 0, off = 0;
        memset(left[0], 0, 2*n*sizeof *x);
        for (int part = 0; part < 2; part++) {           /* real and imaginary */
            for (size_t j = 0; j < n; j++)
                x[j] = m->shape[j]*(part ? sin(m->phase[j]) : cos(m->phase[j]));
            multiply_all(z, t, l, still, x, k, c);
            lw_tangent_mass(z->tangent, z->q, x, heavy);
            size += dot(z->n, x, heavy);
            for (size_t j = 0; j < n; j++) {
                left[part][j] += square[0]*heavy[j] + m->re*c[j] + k[j];
                left[!part][j] += (part ? -1 : 1)*(square[1]*heavy[j] + m->im*c[j]);
            }
            memcpy(c, x, n*sizeof *x);
            off = project(z, x, heavy) == LW_OK ? off : INFINITY;
            for (size_t j = 0; j < n; j++)
                x[j] -= c[j];
            lw_tangent_mass(z->tangent, z->q, x, heavy);
            off += dot(z->n, x, heavy);
        }
        for (int part = 0; part < 2; part++) {
            apply(z, left[part], x);
            lw_tangent_mass(z->tangent, z->q, x, heavy);
            off += dot(z->n, x, heavy);
        }
        modes->cut = !(off < exact*exact*size);
        modes->n_mode = modes->cut ? i : modes->n_mode;
    }
}

/* Do forces depend on velocities in the posture? */
static bool has_damping(lw_dynamics *d, double t, const double *q)
{
    bool damped = false;
    if (d->eq.conservative || lw_mbs_rows(d, t, q) != LW_OK)
        return false;
    memset(d->v_try, 0, (size_t)d->n_v*sizeof *d->v_try);
    d->eq.derivatives(d->eq.context, t, q, d->v_try, d->force, &(lw_force_sink){ .context = &damped, .add = see_damping });
    return damped;
}

/* Multipliers l (n_c) at rest, where `still` (n_v) is 0, the derivatives there, and the scale of the squares of rates: the greatest stiffness of the
 * diagonal over its mass.  modes->unbalanced: the greatest force that is left over the greatest force. */
static lw_status find_rest(lanczos *z, const double *still, double *l, lw_modes *modes)
{
    static const double rounding = 4*DBL_EPSILON, tiny = 1e-8;        /* a force left over counts against that of a displacement this small, too */
    lw_dynamics *d = z->d;
    double left = 0, force = 0, ratio = 0, stiffest = 0;
    lw_status s = lw_tangent_at_rest(d, z->t, z->q, still, d->a, l);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < z->n; i++) {
        left = fmax(left, fabs(d->eq.mass[i]*d->a[i]));
        force = fmax(force, fabs(d->force[i]));
    }
    lw_tangent_fill(z->tangent, z->t, z->q, still, l, (double[]){ 0, 0 }, (double[]){ 0, 0 });
    for (int i = 0; i < z->n; i++) {
        double stiffness = fabs(z->tangent->value[lw_columns_find(&z->tangent->columns, i, i)]);
        ratio = fmax(ratio, stiffness/d->eq.mass[i]);
        stiffest = fmax(stiffest, stiffness);
    }
    force = fmax(force, tiny*stiffest);
    /* what rounding of places leaves of the stiffness is no force */
    modes->unbalanced = force > 0 && left > rounding*stiffest ? left/force : 0;
    z->scale = ratio > 0 ? ratio : 1;
    return LW_OK;
}

lw_status lw_modes_about(lw_dynamics *d, int wanted, bool damping, lw_tangent *kept, double t, double *q, lw_modes *modes, lw_error *e)
{
    size_t n = (size_t)d->n_v, c = (size_t)d->n_kept;
    modes->freedom = d->n_v - d->n_kept;
    modes->redundant = d->n_c - d->n_kept;
    if (modes->freedom <= 0)
        return lw_error_set(e, LW_NOTHING, "no freedom is left to vibrate");
    bool damped = damping && has_damping(d, t, q);
    int aim = damped ? 2*wanted : wanted, room = aim + 4 < modes->freedom ? aim + 4 : modes->freedom;
    bool small = !d->elastic && modes->freedom <= 2*LW_MODES_DEFAULT;
    room = small ? modes->freedom : room;
    int most = 2*room + 20 < modes->freedom ? 2*room + 20 : modes->freedom, all = room;      /* all: with responses to damping, or a basis */
    if (damping && !d->eq.conservative && !small)
        all = LW_SYSTEM_Q_MAX < modes->freedom ? LW_SYSTEM_Q_MAX : modes->freedom;
    size_t vectors = 2*((size_t)most + 1) + 2*((size_t)all + 1), square = (size_t)all*(size_t)all;
    double *memory = calloc(vectors*n + (size_t)room + 5*n + 2*c + 3*square + 8, sizeof *memory), *p = memory;
    lw_tangent own = { 0 };
    lanczos z = { .d = d, .n = d->n_v, .most = most, .t = t, .q = q, .tangent = kept ? kept : &own };
    lw_status s = memory && lw_tangent_renew(d, false, true, z.tangent) == LW_OK ? LW_OK
                : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        z.basis = p, p += ((size_t)most + 1)*n, z.heavy = p, p += ((size_t)most + 1)*n;
        z.found = p, p += ((size_t)all + 1)*n, z.found_heavy = p, p += ((size_t)all + 1)*n, z.value = p, p += room;
        double *still = p, *k = p + n, *damp = p + 2*n, *l = p + 3*n;
        z.b = l + c;
        lw_vibration v = { .eq = &d->eq, .n_q = d->n_v, .null = z.found };
        v.mass = z.b + n + c, v.damping = v.mass + square, v.stiffness = v.damping + square;
        s = find_rest(&z, still, l, modes);
        lw_status found = s != LW_OK ? s : small ? find_basis(&z, room) : find_slow(&z, aim < room ? aim : room, room, l, still);
        if (found != s && found == LW_E_MEMORY)
            lw_error_set(e, found, "out of memory");
        if (found != s && found == LW_E_NUMERIC && !small)
            lw_error_set(e, found, "the stiffness is singular in this posture");
        s = found;
        if (s == LW_STOPPED)
            s = lw_limits_check(d->o.stop, d->o.until, true, t, e);
        if (s == LW_NOTHING)
            s = lw_error_set(e, LW_E_NUMERIC, "no mode was found: Lanczos's method does not converge here");
        if (s == LW_OK) {
            z.n_mode = z.n_found;
            if (damped && !small)
                add_responses(&z, 3, all, t, still, k, damp);
            v.n_free = z.n_found;
            bool known = reduce(&z, !small, damping, t, l, &v, k, damp, still);
            bool whole = known || all == modes->freedom;                  /* few enough for their matrices as they are */
            if (!known && damping) {
                s = find_basis(&z, whole ? all : RANDOM_VECTORS);
                if (s == LW_OK && !whole)
                    add_responses(&z, all, all, t, still, k, damp);
                v.n_free = z.n_found;
                known = s == LW_OK && reduce(&z, false, true, t, l, &v, k, damp, still);
            }
            if (s == LW_OK)
                s = known ? lw_modes_solve(&v, modes, e)
                  : lw_error_set(e, LW_E_KIND, "whether it is stable is not known: a moment in space, "
                                 "or a force that turns with its link or depends on others, has no potential");
            if (s == LW_OK && !whole) {
                keep_exact(&z, wanted, t, l, still, k, damp, modes);
                s = modes->n_mode > 0 ? s : lw_error_set(e, LW_E_NUMERIC, "no mode was found: "
                                                             "Krylov's method does not converge under loads without a potential");
            }
        }
        if (s == LW_OK && modes->n_mode > wanted)
            modes->n_mode = wanted;
    }
    lw_tangent_free(&own);
    free(memory);
    return s;
}
