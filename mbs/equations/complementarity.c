#include "mbs/equations/complementarity.h"

#include <stdlib.h>
#include <string.h>
#include "base/lcp.h"
#include "base/real.h"

/* Unknowns of the complementarity problem: at each place the normal force beyond `least`, then with set-valued friction
 * the two senses of the tangential force and the speed of the slip; or the forces along the two edges of the friction cone. */
typedef struct unknown { int place; enum { NORMAL, UP, DOWN, SPEED, EDGE, OTHER_EDGE } kind; } unknown;

static bool is_cone(const lw_touch_law *law) { return law->holds && !law->fixed && law->friction > 0 && law->slips == 0; }

static int list_unknowns(int n, const lw_touch_law *law, unknown *to)
{
    int count = 0;
    for (int i = 0; i < n; i++) {
        for (int k = EDGE; k <= OTHER_EDGE && is_cone(&law[i]); k++)
            to[count++] = (unknown){ i, k };
        if (is_cone(&law[i]))
            continue;
        if (!law[i].fixed)
            to[count++] = (unknown){ i, NORMAL };
        for (int k = UP; k <= SPEED && law[i].friction > 0 && law[i].slips == 0; k++)
            to[count++] = (unknown){ i, k };
    }
    return count;
}

/* The force (2n) that a unit of an unknown is; false: it is a speed. */
static bool force_of(unknown u, const lw_touch_law *law, double f[2])
{
    double mu = law[u.place].friction;
    f[0] = u.kind == NORMAL || u.kind >= EDGE;
    f[1] = u.kind == EDGE ? mu : u.kind == OTHER_EDGE ? -mu : u.kind == NORMAL ? -mu*law[u.place].slips
         : u.kind == UP ? 1 : u.kind == DOWN ? -1 : 0;
    return u.kind != SPEED;
}

/* The condition that belongs to an unknown: rate of the gap, rate of the slip (either sense) and its speed, or what
 * friction could still hold; for rates `rate`, forces f (2n) and speed. */
static double condition(unknown u, const lw_touch_law *law, const double *rate, const double *f, double speed)
{
    const double *r = rate + 2*u.place, *force = f + 2*u.place;
    switch (u.kind) {
    case NORMAL: return r[0];
    case UP:     return r[1] + speed;
    case DOWN:   return speed - r[1];
    case EDGE:   return r[0] + law[u.place].friction*r[1];
    case OTHER_EDGE: return r[0] - law[u.place].friction*r[1];
    default:     return law[u.place].friction*force[0];
    }
}

lw_status lw_complementarity(int n, const double *w, const double *b, const lw_touch_law *law, double *force, double *rate)
{
    size_t m = 2*(size_t)n;
    double heavy = 0, fast = 0;
    for (size_t i = 0; i < m; i++) {
        heavy = fmax(heavy, w[i*m + i]);
        fast = fmax(fast, fabs(b[i]));
    }
    for (int i = 0; i < n; i++)
        fast = fmax(fast, law[i].least*heavy);
    memset(force, 0, m*sizeof *force);
    memcpy(rate, b, m*sizeof *rate);
    if (!(fast > 0))
        return LW_OK;
    unknown *u = malloc(4*(size_t)n*sizeof *u);
    int count = u ? list_unknowns(n, law, u) : 0;
    size_t c = (size_t)count;
    double *matrix = malloc((c*c + 2*c + lw_lcp_work(count) + 2*m)*sizeof *matrix);
    if (!u || !matrix) {
        free(u);
        free(matrix);
        return LW_E_MEMORY;
    }
    double *q = matrix + c*c, *z = q + c, *r = z + c, *f = r + m, *work = f + m, per = heavy > 0 ? fast/heavy : 1;
    for (int j = -1; j < count; j++) {                   /* -1: the constant part */
        double own[2] = { 0, 0 };
        memset(f, 0, m*sizeof *f);
        if (j >= 0 && force_of(u[j], law, own))
            memcpy(f + 2*u[j].place, own, sizeof own);
        for (int i = 0; j < 0 && i < n; i++) {
            f[2*i] = law[i].least/per;
            f[2*i + 1] = -law[i].friction*law[i].slips*f[2*i];
        }
        for (size_t i = 0; i < m; i++) {
            double sum = j < 0 ? b[i]/fast : 0;
            for (int p = 0; p < n; p++)
                if (j < 0 || p == u[j].place) {
                    bool outside = j < 0 && law[p].fixed;     /* its normal force is in b already */
                    sum += (w[i*m + 2*(size_t)p]*(outside ? 0 : f[2*p]) + w[i*m + 2*(size_t)p + 1]*f[2*p + 1])/heavy;
                }
            r[i] = sum;
        }
        for (int i = 0; i < count; i++) {
            double speed = j >= 0 && u[j].kind == SPEED && u[j].place == u[i].place;
            double value = condition(u[i], law, r, f, speed);
            if (u[i].kind == SPEED && j >= 0 && u[j].place == u[i].place && (u[j].kind == UP || u[j].kind == DOWN))
                value -= 1;
            if (j < 0)
                q[i] = value;
            else
                matrix[(size_t)i*c + (size_t)j] = value;
        }
    }
    lw_status s = lw_lcp_solve(count, matrix, q, work, z);
    for (int i = 0; i < n; i++) {
        force[2*i] = law[i].least;
        force[2*i + 1] = -law[i].friction*law[i].slips*law[i].least;
    }
    for (int j = 0; s == LW_OK && j < count; j++) {
        double own[2];
        if (!force_of(u[j], law, own))
            continue;
        force[2*u[j].place] += own[0]*z[j]*per;
        force[2*u[j].place + 1] += own[1]*z[j]*per;
    }
    for (size_t i = 0; i < m; i++)
        for (int p = 0; p < n; p++)
            rate[i] += (law[p].fixed ? 0 : w[i*m + 2*(size_t)p]*force[2*p]) + w[i*m + 2*(size_t)p + 1]*force[2*p + 1];
    free(u);
    free(matrix);
    return s == LW_E_NUMERIC ? LW_NOTHING : s;
}

static bool rests(const double *rate, int i, double tiny) { return fabs(rate[2*i]) <= tiny && fabs(rate[2*i + 1]) <= tiny; }

bool lw_complementarity_held(int n, const lw_touch_law *law, const double *force, const double *rate, int which, double slip)
{
    const double tiny = 1e-3*fabs(slip);
    double top = 0;
    for (int i = 0; i < n; i++)
        top = fmax(top, force[2*i]);
    bool held = rests(rate, which, tiny);
    for (int i = 0; i < n; i++)
        held = held && (!is_cone(&law[i]) || force[2*i] <= 1e-9*top || rests(rate, i, tiny));
    return held;
}
