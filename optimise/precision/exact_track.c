/* optimise/precision/exact_track.c - nine points of a path: the equations of Wampler, Morgan & Sommese (1992) and a
 * tracker that follows one solution while the points move, in complex numbers.
 *
 * With the first point as origin, d_j the others, a fixed pin a and its moving pin x from the tracer, and e_j the
 * turn of the coupler, |d_j + x e_j - a| = |x - a| reads, for g = e_j - 1 and a hat for the conjugate,
 *
 *     A g + B g^ + D = 0,   A = x (d^ - a^),  B = x^ (d - a),  D = d^ (x - a) + d (x^ - a^) + d d^
 *
 * for both pairs of pins.  Cramer's rule in  g + g^ + g g^ = 0  leaves, per point, one equation in the eight numbers
 * x x^ a a^ y y^ b b^:   N N^ + E (N + N^) = 0  with  E = A1 B2 - A2 B1,  N = B1 D2 - B2 D1,  N^ = A2 D1 - A1 D2.
 * Over the complex numbers the hats are independent variables.  Five points with both fixed pins given have four such
 * equations in x x^ y y^ (Morgan & Wampler 1990). */
#include "base/real.h"
#include "optimise/precision/exact_track_internal.h"

#include <string.h>

enum { X, XH, A, AH, Y, YH, B, BH };

/* ---- equations ------------------------------------------------------------------------------------------ */

void lw_nine_equation(const lw_cx *v, lw_cx d, lw_cx dh, lw_cx *f, lw_cx by[8], lw_cx *by_d, lw_cx *by_dh)
{
    lw_cx da = cx_sub(d, v[A]), ha = cx_sub(dh, v[AH]), db = cx_sub(d, v[B]), hb = cx_sub(dh, v[BH]);
    lw_cx xa = cx_sub(v[X], v[A]), xah = cx_sub(v[XH], v[AH]), yb = cx_sub(v[Y], v[B]), ybh = cx_sub(v[YH], v[BH]);
    lw_cx dd = cx_mul(d, dh);
    lw_cx a1 = cx_mul(v[X], ha), b1 = cx_mul(v[XH], da), a2 = cx_mul(v[Y], hb), b2 = cx_mul(v[YH], db);
    lw_cx d1 = cx_add(cx_add(cx_mul(dh, xa), cx_mul(d, xah)), dd);
    lw_cx d2 = cx_add(cx_add(cx_mul(dh, yb), cx_mul(d, ybh)), dd);
    lw_cx e = cx_sub(cx_mul(a1, b2), cx_mul(a2, b1)), n = cx_sub(cx_mul(b1, d2), cx_mul(b2, d1));
    lw_cx nh = cx_sub(cx_mul(a2, d1), cx_mul(a1, d2)), r = cx_add(n, nh), p = cx_add(nh, e), q = cx_add(n, e);
    *f = cx_add(cx_mul(n, nh), cx_mul(e, r));
    lw_cx fa1 = cx_sub(cx_mul(r, b2), cx_mul(q, d2)), fb1 = cx_sub(cx_mul(p, d2), cx_mul(r, a2));
    lw_cx fd1 = cx_sub(cx_mul(q, a2), cx_mul(p, b2)), fa2 = cx_sub(cx_mul(q, d1), cx_mul(r, b1));
    lw_cx fb2 = cx_sub(cx_mul(r, a1), cx_mul(p, d1)), fd2 = cx_sub(cx_mul(p, b1), cx_mul(q, a1));
    lw_cx fb1x = cx_mul(fb1, v[XH]), fa1x = cx_mul(fa1, v[X]), fb2y = cx_mul(fb2, v[YH]), fa2y = cx_mul(fa2, v[Y]);
    lw_cx d1h = cx_mul(fd1, dh), d1d = cx_mul(fd1, d), d2h = cx_mul(fd2, dh), d2d = cx_mul(fd2, d);
    by[X] = cx_add(cx_mul(fa1, ha), d1h);
    by[XH] = cx_add(cx_mul(fb1, da), d1d);
    by[A] = cx_neg(cx_add(fb1x, d1h));
    by[AH] = cx_neg(cx_add(fa1x, d1d));
    by[Y] = cx_add(cx_mul(fa2, hb), d2h);
    by[YH] = cx_add(cx_mul(fb2, db), d2d);
    by[B] = cx_neg(cx_add(fb2y, d2h));
    by[BH] = cx_neg(cx_add(fa2y, d2d));
    *by_d = cx_add(cx_add(fb1x, cx_mul(fd1, cx_add(xah, dh))), cx_add(fb2y, cx_mul(fd2, cx_add(ybh, dh))));
    *by_dh = cx_add(cx_add(fa1x, cx_mul(fd1, cx_add(xa, d))), cx_add(fa2y, cx_mul(fd2, cx_add(yb, d))));
}

/* ---- the same in twice the precision ----------------------------------------------------------------------- */

/* A number is hi + lo, |lo| at most half a unit in the last place of hi (Dekker 1971; products by fma). */
typedef struct twice { double hi, lo; } twice;
typedef struct cx2 { twice re, im; } cx2;

static twice two_sum(double a, double b)
{
    double s = a + b, v = s - a;
    return (twice){ s, (a - (s - v)) + (b - v) };
}

static twice add2(twice a, twice b)
{
    twice s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
    twice u = two_sum(s.hi, s.lo + t.hi);
    return two_sum(u.hi, u.lo + t.lo);
}

static twice mul2(twice a, twice b)
{
    double p = a.hi*b.hi;
    return two_sum(p, fma(a.hi, b.hi, -p) + (a.hi*b.lo + a.lo*b.hi));
}

static twice neg2(twice a)        { return (twice){ -a.hi, -a.lo }; }
static cx2   cx2_add(cx2 a, cx2 b) { return (cx2){ add2(a.re, b.re), add2(a.im, b.im) }; }
static cx2   cx2_sub(cx2 a, cx2 b) { return (cx2){ add2(a.re, neg2(b.re)), add2(a.im, neg2(b.im)) }; }
static cx2   cx2_of(lw_cx a)       { return (cx2){ { a.re, 0 }, { a.im, 0 } }; }

static cx2 cx2_mul(cx2 a, cx2 b)
{
    return (cx2){ add2(mul2(a.re, b.re), neg2(mul2(a.im, b.im))), add2(mul2(a.re, b.im), mul2(a.im, b.re)) };
}

/* The value of lw_nine_equation: near a solution the products cancel, and what is left decides how near it is. */
static lw_cx equation_twice(const lw_cx *v, lw_cx at, lw_cx at_hat)
{
    cx2 d = cx2_of(at), h = cx2_of(at_hat), dd = cx2_mul(d, h), w[8];
    for (int i = 0; i < 8; i++)
        w[i] = cx2_of(v[i]);
    cx2 a1 = cx2_mul(w[X], cx2_sub(h, w[AH])), b1 = cx2_mul(w[XH], cx2_sub(d, w[A]));
    cx2 a2 = cx2_mul(w[Y], cx2_sub(h, w[BH])), b2 = cx2_mul(w[YH], cx2_sub(d, w[B]));
    cx2 d1 = cx2_add(cx2_add(cx2_mul(h, cx2_sub(w[X], w[A])), cx2_mul(d, cx2_sub(w[XH], w[AH]))), dd);
    cx2 d2 = cx2_add(cx2_add(cx2_mul(h, cx2_sub(w[Y], w[B])), cx2_mul(d, cx2_sub(w[YH], w[BH]))), dd);
    cx2 e = cx2_sub(cx2_mul(a1, b2), cx2_mul(a2, b1)), n = cx2_sub(cx2_mul(b1, d2), cx2_mul(b2, d1));
    cx2 nh = cx2_sub(cx2_mul(a2, d1), cx2_mul(a1, d2));
    cx2 f = cx2_add(cx2_mul(n, nh), cx2_mul(e, cx2_add(n, nh)));
    return (lw_cx){ f.re.hi, f.im.hi };
}

/* ---- a system of eight --------------------------------------------------------------------------------- */

typedef struct system8 {
    lw_cx m[8][8], f[8], by_t[8];
} system8;

/* At t between the points of `from` and `to`; fine: values in twice the precision. */
static void set_up(const lw_nine *from, const lw_nine *to, double t, const lw_cx *v, bool fine, system8 *s)
{
    static const int fixed[4] = { A, AH, B, BH };
    int points = from->pivots ? 4 : 8;
    for (int j = points; j < 8; j++) {
        lw_cx step = cx_sub(to->pivot[j - 4], from->pivot[j - 4]);
        memset(s->m[j], 0, sizeof s->m[j]);
        s->m[j][fixed[j - 4]] = (lw_cx){ 1, 0 };
        s->f[j] = cx_sub(v[fixed[j - 4]], cx_add(from->pivot[j - 4], cx_scale(step, t)));
        s->by_t[j] = cx_neg(step);
    }
    for (int j = 0; j < points; j++) {
        lw_cx step = cx_sub(to->d[j], from->d[j]), steph = cx_sub(to->dh[j], from->dh[j]), by_d, by_dh;
        lw_cx d = cx_add(from->d[j], cx_scale(step, t)), dh = cx_add(from->dh[j], cx_scale(steph, t));
        lw_nine_equation(v, d, dh, &s->f[j], s->m[j], &by_d, &by_dh);
        s->by_t[j] = cx_add(cx_mul(by_d, step), cx_mul(by_dh, steph));
        if (fine)
            s->f[j] = equation_twice(v, d, dh);
    }
}

/* Solve m z = f and m w = by_t together by elimination with rows scaled; false: singular. */
static bool solve(system8 *s, lw_cx z[8], lw_cx w[8])
{
    for (int k = 0; k < 8; k++) {                               /* the rows differ in size by their points */
        double most = 0;
        for (int i = 0; i < 8; i++)
            most = fmax(most, cx_norm1(s->m[k][i]));
        double by = most > 0 ? 1/most : 0;
        for (int i = 0; i < 8; i++)
            s->m[k][i] = cx_scale(s->m[k][i], by);
        s->f[k] = cx_scale(s->f[k], by);
        s->by_t[k] = cx_scale(s->by_t[k], by);
    }
    lw_cx *row[8];
    int at[8];
    for (int k = 0; k < 8; k++) {
        row[k] = s->m[k];
        at[k] = k;
    }
    for (int k = 0; k < 8; k++) {
        int best = k;
        for (int i = k + 1; i < 8; i++)
            if (cx_norm1(row[i][k]) > cx_norm1(row[best][k]))
                best = i;
        lw_cx *swap = row[k];
        row[k] = row[best];
        row[best] = swap;
        int swap_at = at[k];
        at[k] = at[best];
        at[best] = swap_at;
        if (!(cx_norm1(row[k][k]) > 1e-250))
            return false;
        lw_cx pivot = cx_inverse(row[k][k]);
        row[k][k] = pivot;
        for (int i = k + 1; i < 8; i++) {
            lw_cx l = cx_mul(row[i][k], pivot);
            for (int c = k + 1; c < 8; c++)
                row[i][c] = cx_sub(row[i][c], cx_mul(l, row[k][c]));
            s->f[at[i]] = cx_sub(s->f[at[i]], cx_mul(l, s->f[at[k]]));
            s->by_t[at[i]] = cx_sub(s->by_t[at[i]], cx_mul(l, s->by_t[at[k]]));
        }
    }
    for (int k = 7; k >= 0; k--) {
        lw_cx p = s->f[at[k]], q = s->by_t[at[k]];
        for (int c = k + 1; c < 8; c++) {
            p = cx_sub(p, cx_mul(row[k][c], z[c]));
            q = cx_sub(q, cx_mul(row[k][c], w[c]));
        }
        z[k] = cx_mul(p, row[k][k]);
        w[k] = cx_mul(q, row[k][k]);
    }
    return true;
}

/* ---- tracking ---------------------------------------------------------------------------------------------- */

#define AIM      1e-3          /* what the predictor may be off, of the numbers' own size         */
#define NEAR     1e-7          /* corrections end below this                                       */
#define SETTLED  1e-11         /* what a solution may be off in the end                             */
#define LEAST    1e-13         /* shortest step                                                    */
#define FAR      1e12          /* solutions beyond are taken to go to infinity                     */
#define ARRIVING 0.999         /* a path that goes on from here, but not to the end, ends at a singular solution */
enum { STEPS = 6000 };

static double relative(const lw_cx *step, const lw_cx *v)
{
    double most = 0;
    for (int i = 0; i < 8; i++)
        most = fmax(most, cx_norm1(step[i])/(cx_norm1(v[i]) + 0.01));
    return most;
}

/* Newton's method at t from v, with the tangent there.  Returns the first correction, or INFINITY if it does not
 * converge. */
static double correct(const lw_nine *from, const lw_nine *to, double t, int most, bool fine, lw_cx *v, lw_cx *tangent)
{
    double first = 0, before = INFINITY;
    for (int pass = 0; pass < most; pass++) {
        system8 s;
        lw_cx step[8];
        set_up(from, to, t, v, fine, &s);
        if (!solve(&s, step, tangent))
            return INFINITY;
        double size = relative(step, v);
        if (!(size < 0.1) || (pass > 0 && !(size < 0.2*before) && size > NEAR))
            return INFINITY;
        for (int i = 0; i < 8; i++)
            v[i] = cx_sub(v[i], step[i]);
        if (pass == 0)
            first = size;
        before = size;
        if (size < NEAR)
            break;
    }
    if (!(before < NEAR))
        return INFINITY;
    for (int i = 0; i < 8; i++)
        tangent[i] = cx_neg(tangent[i]);
    return first;
}

/* Newton's method until it stops improving, with the equations in twice the precision: so the solution is exact to
 * rounding as far as its matrix is regular in double precision. */
static bool settle(const lw_nine *to, lw_cx *v)
{
    double before = INFINITY;
    for (int pass = 0; pass < 40; pass++) {
        system8 s;
        lw_cx step[8], tangent[8];
        set_up(to, to, 0, v, true, &s);
        if (!solve(&s, step, tangent))
            return false;
        double size = relative(step, v);
        if (!(size < 0.5*before))
            break;
        for (int i = 0; i < 8; i++)
            v[i] = cx_sub(v[i], step[i]);
        before = size;
    }
    return before < SETTLED;
}

/* Extrapolate by h the cubic through two points with their tangents (Hermite). */
static void predict(const lw_cx *v0, const lw_cx *d0, const lw_cx *v1, const lw_cx *d1, double before, double h, lw_cx *v)
{
    if (before <= 0) {
        for (int i = 0; i < 8; i++)
            v[i] = cx_add(v1[i], cx_scale(d1[i], h));
        return;
    }
    double u = 1 + h/before, u2 = u*u, u3 = u2*u;
    double a = 2*u3 - 3*u2 + 1, b = (u3 - 2*u2 + u)*before, c = 3*u2 - 2*u3, d = (u3 - u2)*before;
    for (int i = 0; i < 8; i++)
        v[i] = cx_add(cx_add(cx_scale(v0[i], a), cx_scale(d0[i], b)), cx_add(cx_scale(v1[i], c), cx_scale(d1[i], d)));
}

lw_track lw_nine_track(const lw_nine *from, const lw_nine *to, double care, lw_cx v[8], long *steps)
{
    lw_cx v0[8], d0[8] = { { 0, 0 } }, d1[8], next[8], dn[8];
    double t = 0, h = 1e-3, before = 0, aim = AIM*care;
    bool fine = care < 1;
    if (!(correct(from, to, 0, 6, fine, v, d1) < INFINITY))
        return LW_TRACK_LOST;
    memcpy(v0, v, sizeof v0);
    for (int k = 0; k < STEPS && t < 1; k++) {
        bool last = t + h >= 1;
        double step = last ? 1 - t : h;
        predict(v0, d0, v, d1, before, step, next);
        double off = correct(from, to, t + step, 3, fine, next, dn);
        ++*steps;
        if (!(off < 100*aim)) {
            h = 0.4*step;
            if (h < LEAST)
                break;
            continue;
        }
        memcpy(v0, v, sizeof v0);
        memcpy(d0, d1, sizeof d0);
        memcpy(v, next, sizeof v0);
        memcpy(d1, dn, sizeof d0);
        before = step;
        t = last ? 1 : t + step;
        double grow = 0.9*sqrt(sqrt(aim/fmax(off, 1e-12)));
        h = step*fmin(2, fmax(0.3, grow));
        for (int i = 0; i < 8; i++)
            if (!(cx_norm1(v[i]) < FAR))
                return LW_TRACK_SINGULAR;
    }
    return t >= 1 && settle(to, v) ? LW_TRACK_ARRIVED : t > ARRIVING ? LW_TRACK_SINGULAR : LW_TRACK_LOST;
}
