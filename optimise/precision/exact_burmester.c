/* optimise/precision/exact_burmester.c - guides of a body through two to five poses (Burmester 1888).
 *
 * With the first pose as the frame of both bodies, a pin k of the moving one and g of the fixed one keep
 * their distance at a pose (p, e^{ia}) when
 *
 *     |p|^2/2 + p.(e^{ia} k) - p.g + (1 - cos a) k.g - sin a (k x g) = 0
 *
 * which is linear in (1, k, g, u, v) with u = k.g, v = k x g.  Four poses besides the first leave a plane of these
 * seven (projective) numbers, and the two quadrics  w u = k.g,  w v = k x g  cut the plane in four points.  All four
 * are guides: where w = 0, k or g is at infinity and the other follows from u + iv = conj(k) g. */
#include "base/real_complex.h"
#include "optimise/precision/exact_internal.h"

#include <string.h>
#include "base/linalg.h"
#include "base/vector.h"

#define INDEPENDENT 1e-11     /* a row that keeps less of its length says nothing new                 */
#define AT_INFINITY 1e-9      /* w against z: pins farther than 1e9 sizes make a slide                */

enum { Z = LW_GUIDE_Z, W = 0, KX, KY, GX, GY, U, V };

/* ---- rows ----------------------------------------------------------------------------------------- */

/* Subtract from v its components along n orthonormal vectors.  Returns the length that is left. */
static double take_out(int n, const double (*by)[Z], double *v)
{
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < n; k++) {
            double c = lw_dot(Z, by[k], v);
            for (int i = 0; i < Z; i++)
                v[i] -= c*by[k][i];
        }
    return sqrt(lw_dot(Z, v, v));
}

static bool append(int n, double (*to)[Z], const double *row, double least)
{
    double length = sqrt(lw_dot(Z, row, row));
    if (!(length > 0) || n >= Z)
        return false;
    for (int i = 0; i < Z; i++)
        to[n][i] = row[i]/length;
    double left = take_out(n, (const double (*)[Z])to, to[n]);
    for (int i = 0; i < Z; i++)
        to[n][i] /= left;
    return left > least;
}

bool lw_guide_rows_add(lw_guide_rows *r, const double row[LW_GUIDE_Z])
{
    if (!append(r->n, r->row, row, INDEPENDENT))
        return false;
    memcpy(r->raw[r->n++], row, sizeof r->raw[0]);
    return true;
}

/* The row of a pose, in the frame of the first pose. */
static void pose_row(const lw_guide_rows *r, lw_vec2 at, double angle, double *row)
{
    lw_vec2 p = lw_v2_scale(lw_v2_sub(at, r->origin), 1/r->unit);
    double a = angle - r->turn, c = cos(a), s = sin(a), h = sin(0.5*a);
    row[W] = 0.5*lw_v2_dot(p, p);
    row[KX] = p.x*c + p.y*s;
    row[KY] = p.y*c - p.x*s;
    row[GX] = -p.x;
    row[GY] = -p.y;
    row[U] = 2*h*h;
    row[V] = -s;
}

void lw_guide_rows_make(const lw_poses *at, double size, lw_guide_rows *r)
{
    *r = (lw_guide_rows){ .origin = at->p[0], .turn = at->angle[0], .unit = size };
    for (size_t j = 1; j < at->n; j++)
        r->unit = fmax(r->unit, lw_v2_norm(lw_v2_sub(at->p[j], at->p[0])));
    if (!(r->unit > 0))
        r->unit = 1;
    for (size_t j = 1; j < at->n; j++) {
        double row[Z];
        pose_row(r, at->p[j], at->angle[j], row);
        lw_guide_rows_add(r, row);
    }
}

/* ---- two conics in the remaining plane ----------------------------------------------------------- */

typedef struct conics { double n[3][Z]; double q[2][3][3]; } conics;

/* The quadrics as symmetric forms of two vectors. */
static double form(int which, const double *a, const double *b)
{
    if (which == 0)
        return 0.5*(a[W]*b[U] + a[U]*b[W] - a[KX]*b[GX] - a[GX]*b[KX] - a[KY]*b[GY] - a[GY]*b[KY]);
    return 0.5*(a[W]*b[V] + a[V]*b[W] - a[KX]*b[GY] - a[GY]*b[KX] + a[KY]*b[GX] + a[GX]*b[KY]);
}

/* An orthonormal basis of the remaining space, turned by a fixed amount so that no solution lies on an axis. */
static void make_conics(const lw_guide_rows *r, conics *c)
{
    static const double turn[3][3] = {          /* orthogonal: a Householder reflector at (3, 5, 7) */
        { 65/83.0, -30/83.0, -42/83.0 }, { -30/83.0, 33/83.0, -70/83.0 }, { -42/83.0, -70/83.0, -15/83.0 }
    };
    double all[Z][Z], *b[3] = { all[4], all[5], all[6] };
    memcpy(all, r->row, sizeof all);
    for (int n = 4; n < Z; n++) {
        int best = 0;
        double most = -1;
        for (int i = 0; i < Z; i++) {                          /* the axis with most outside the span */
            double in = 0;
            for (int k = 0; k < n; k++)
                in += all[k][i]*all[k][i];
            if (1 - in > most) {
                most = 1 - in;
                best = i;
            }
        }
        double axis[Z] = { 0 };
        axis[best] = 1;
        append(n, all, axis, 0);
    }
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < Z; k++)
            c->n[i][k] = turn[i][0]*b[0][k] + turn[i][1]*b[1][k] + turn[i][2]*b[2][k];
    for (int w = 0; w < 2; w++)
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                c->q[w][i][k] = form(w, c->n[i], c->n[k]);
}

static void multiply(const double *a, int na, const double *b, int nb, double sign, double *out)
{
    for (int i = 0; i <= na; i++)
        for (int k = 0; k <= nb; k++)
            out[i + k] += sign*a[i]*b[k];
}

/* On s = (x, y, 1) a conic is  a y^2 + b(x) y + c(x).  The resultant by y:
 * (a1 c2 - a2 c1)^2 - (a1 b2 - a2 b1)(b1 c2 - b2 c1). */
static void resultant(const conics *c, double ac[3], double ab[2], double out[5])
{
    double a[2], b[2][2], k[2][3], bc[4] = { 0 };
    for (int w = 0; w < 2; w++) {
        const double (*q)[3] = c->q[w];
        a[w] = q[1][1];
        b[w][0] = 2*q[1][2];
        b[w][1] = 2*q[0][1];
        k[w][0] = q[2][2];
        k[w][1] = 2*q[0][2];
        k[w][2] = q[0][0];
    }
    for (int i = 0; i < 3; i++)
        ac[i] = a[0]*k[1][i] - a[1]*k[0][i];
    for (int i = 0; i < 2; i++)
        ab[i] = a[0]*b[1][i] - a[1]*b[0][i];
    multiply(b[0], 1, k[1], 2, 1, bc);
    multiply(b[1], 1, k[0], 2, -1, bc);
    memset(out, 0, 5*sizeof *out);
    multiply(ac, 2, ac, 2, 1, out);
    multiply(ab, 1, bc, 3, -1, out);
}

/* All roots of a quartic at once (Aberth 1973).  false: it vanishes, or its degree is lower. */
static bool quartic_roots(const double c[5], double complex z[4])
{
    double most = 0;
    for (int i = 0; i < 5; i++)
        most = fmax(most, fabs(c[i]));
    if (!(fabs(c[4]) > 1e-13*most))
        return false;
    for (int i = 0; i < 4; i++)
        z[i] = cexp(I*(0.4 + 0.5*LW_PI*i));
    for (int pass = 0; pass < 200; pass++) {
        double moved = 0;
        for (int i = 0; i < 4; i++) {
            double complex f = c[4], d = 0, s = 0;
            for (int k = 3; k >= 0; k--) {
                d = d*z[i] + f;
                f = f*z[i] + c[k];
            }
            for (int k = 0; k < 4; k++)
                if (k != i && z[k] != z[i])
                    s += 1/(z[i] - z[k]);
            double complex step = f/(d - f*s);
            if (!(cabs(step) < INFINITY))
                continue;
            z[i] -= step;
            moved = fmax(moved, cabs(step)/(1 + cabs(z[i])));
        }
        if (moved < 1e-16)
            break;
    }
    return true;
}

static double value(const double q[3][3], const double *s, double *slope)
{
    double f = 0;
    for (int i = 0; i < 3; i++) {
        double row = q[i][0]*s[0] + q[i][1]*s[1] + q[i][2]*s[2];
        slope[i] = 2*row;
        f += s[i]*row;
    }
    return f;
}

static void normalise(double *s)
{
    double l = sqrt(s[0]*s[0] + s[1]*s[1] + s[2]*s[2]);
    for (int i = 0; i < 3; i++)
        s[i] /= l;
}

/* Newton's method on both conics with steps orthogonal to s.  Returns the residual. */
static double polish(const conics *c, double *s)
{
    double f[2], g[2][3];
    for (int pass = 0; pass < 30; pass++) {
        normalise(s);
        for (int w = 0; w < 2; w++)
            f[w] = value(c->q[w], s, g[w]);
        /* solve (g0; g1; s) d = (-f0, -f1, 0): d = -f0 (g1 x s)/D - f1 (s x g0)/D */
        double a[3] = { g[1][1]*s[2] - g[1][2]*s[1], g[1][2]*s[0] - g[1][0]*s[2], g[1][0]*s[1] - g[1][1]*s[0] };
        double b[3] = { s[1]*g[0][2] - s[2]*g[0][1], s[2]*g[0][0] - s[0]*g[0][2], s[0]*g[0][1] - s[1]*g[0][0] };
        double det = g[0][0]*a[0] + g[0][1]*a[1] + g[0][2]*a[2], size = 0;
        if (det == 0)
            break;
        for (int i = 0; i < 3; i++) {
            double d = -(f[0]*a[i] + f[1]*b[i])/det;
            s[i] += d;
            size = fmax(size, fabs(d));
        }
        if (size < 1e-16)
            break;
    }
    normalise(s);
    return fmax(fabs(value(c->q[0], s, g[0])), fabs(value(c->q[1], s, g[1])));
}

/* Polish finite pins by Newton's method on the four rows as given: the orthogonal rows lose digits if the poses are
 * nearly dependent. */
static void polish_pins(const lw_guide_rows *r, double *z)
{
    double q[4] = { z[KX]/z[W], z[KY]/z[W], z[GX]/z[W], z[GY]/z[W] }, least = INFINITY;
    for (int pass = 0; pass < 4; pass++) {
        double a[16], d[4], f[4], size = 0, far = 1;
        for (int i = 0; i < 4; i++) {
            const double *c = r->raw[i];
            f[i] = c[W] + c[KX]*q[0] + c[KY]*q[1] + c[GX]*q[2] + c[GY]*q[3] + c[U]*(q[0]*q[2] + q[1]*q[3])
                 + c[V]*(q[0]*q[3] - q[1]*q[2]);
            a[i] = c[KX] + c[U]*q[2] + c[V]*q[3];
            a[i + 4] = c[KY] + c[U]*q[3] - c[V]*q[2];
            a[i + 8] = c[GX] + c[U]*q[0] - c[V]*q[1];
            a[i + 12] = c[GY] + c[U]*q[1] + c[V]*q[0];
            size = fmax(size, fabs(f[i]));
            far = fmax(far, fabs(q[i]));
        }
        if (!(size < least) || !(lw_qr_factor(4, 4, a, d) > 1e-13))
            return;
        least = size;
        memcpy(z + KX, q, sizeof q);
        z[W] = 1;
        lw_qr_solve(4, 4, a, d, f);
        for (int i = 0; i < 4; i++) {
            q[i] -= f[i];
            if (!(fabs(f[i]) < 1e-3*far))
                return;
        }
    }
}

/* Polish a slide on the four rows as given, which are linear in what remains of z when a pin is at infinity; far: its
 * coordinates in z, KX or GX.  The roots of the quartic lose digits where they are close together. */
static void polish_slide(const lw_guide_rows *r, int far, double *z)
{
    const int of[4] = { far, far + 1, U, V };
    double a[20], d[4], f[5] = { 0, 0, 0, 0, 1 }, size = 0;
    for (int c = 0; c < 4; c++)
        size = hypot(size, z[of[c]]);
    for (int c = 0; c < 4; c++) {
        for (int i = 0; i < 4; i++)
            a[5*c + i] = r->raw[i][of[c]];
        a[5*c + 4] = z[of[c]]/size;
    }
    if (!(lw_qr_factor(5, 4, a, d) > 1e-13))
        return;
    lw_qr_solve(5, 4, a, d, f);
    for (int c = 0; c < 4; c++)
        z[of[c]] = f[c];
}

/* ---- guides of points z ---------------------------------------------------------------------------- */

static lw_vec2 divide(lw_vec2 a, lw_vec2 b)
{
    return lw_v2_scale(lw_v2_unturn(a, b), 1/lw_v2_dot(b, b));
}

static lw_vec2 conjugate(lw_vec2 a) { return lw_v2(a.x, -a.y); }

static lw_guide guide_of(const lw_guide_rows *r, double *z)
{
    lw_guide out = { .kind = LW_GUIDE_RR };
    bool finite = fabs(z[W]) > AT_INFINITY*sqrt(lw_dot(Z, z, z)), slides = hypot(z[GX], z[GY]) > hypot(z[KX], z[KY]);
    if (finite && r->n == 4)
        polish_pins(r, z);
    else if (r->n == 4)
        polish_slide(r, slides ? GX : KX, z);
    lw_vec2 k = lw_v2(z[KX], z[KY]), g = lw_v2(z[GX], z[GY]), m = lw_v2(z[U], z[V]);
    if (finite) {
        k = lw_v2_scale(k, 1/z[W]);
        g = lw_v2_scale(g, 1/z[W]);
    } else if (slides) {                                       /* the fixed pin is at infinity         */
        out.kind = LW_GUIDE_PR;
        out.along = lw_v2_perp(lw_v2_scale(g, 1/lw_v2_norm(g)));
        k = conjugate(divide(m, g));
        g = k;
    } else {                                                   /* the moving one                       */
        out.kind = LW_GUIDE_RP;
        out.along = lw_v2_turn(lw_v2_perp(lw_v2_scale(k, 1/lw_v2_norm(k))), lw_v2_polar(1, -r->turn));
        g = divide(m, conjugate(k));
        k = g;
    }
    out.point = lw_v2_turn(lw_v2_scale(k, r->unit), lw_v2_polar(1, -r->turn));
    out.centre = lw_v2_add(r->origin, lw_v2_scale(g, r->unit));
    return out;
}

static bool already(double (*s)[3], int n, const double *now)
{
    for (int i = 0; i < n; i++) {
        double c = fabs(s[i][0]*now[0] + s[i][1]*now[1] + s[i][2]*now[2]);
        if (c > 1 - 1e-13)
            return true;
    }
    return false;
}

int lw_guide_rows_solve(const lw_guide_rows *r, lw_guide out[4])
{
    conics c;
    double ac[3], ab[2], quartic[5], s[4][3];
    double complex x[4];
    int n = 0;
    if (r->n != 4)
        return -1;
    make_conics(r, &c);
    resultant(&c, ac, ab, quartic);
    if (!quartic_roots(quartic, x))
        return -1;
    for (int i = 0; i < 4; i++) {
        double at = creal(x[i]), z[Z] = { 0 };
        if (fabs(cimag(x[i])) > 1e-5*(1 + fabs(at)))           /* double roots stand half their digits apart */
            continue;
        s[n][0] = at;
        s[n][1] = -(ac[0] + at*(ac[1] + at*ac[2]))/(ab[0] + at*ab[1]);
        s[n][2] = 1;
        if (!(polish(&c, s[n]) < 1e-14) || already(s, n, s[n]))
            continue;
        for (int k = 0; k < Z; k++)
            for (int b = 0; b < 3; b++)
                z[k] += s[n][b]*c.n[b][k];
        out[n++] = guide_of(r, z);
    }
    return n;
}

/* ---- free choices ------------------------------------------------------------------------------------ */

/* The rows for a given pin (w, a), which are linear in the other pin q.  `moving`: the given pin is k. */
static void linear_in_other(const double *row, double w, lw_vec2 a, bool moving, double out[3])
{
    double s = moving ? 1 : -1;
    out[0] = w*row[W] + (moving ? row[KX]*a.x + row[KY]*a.y : row[GX]*a.x + row[GY]*a.y);
    out[1] = w*(moving ? row[GX] : row[KX]) + row[U]*a.x - s*row[V]*a.y;
    out[2] = w*(moving ? row[GY] : row[KY]) + row[U]*a.y + s*row[V]*a.x;
}

/* The other pin from two rows, or from one row the pin nearest to `near`. */
static bool other_pin(const lw_guide_rows *r, double w, lw_vec2 a, bool moving, lw_vec2 near, lw_vec2 *q)
{
    double l[2][3] = { { 0 } };
    for (int i = 0; i < r->n && i < 2; i++)
        linear_in_other(r->row[i], w, a, moving, l[i]);
    if (r->n == 1) {
        double d2 = l[0][1]*l[0][1] + l[0][2]*l[0][2], off = l[0][0] + l[0][1]*near.x + l[0][2]*near.y;
        *q = lw_v2(near.x - off*l[0][1]/d2, near.y - off*l[0][2]/d2);
        return d2 > 0;
    }
    double det = l[0][1]*l[1][2] - l[0][2]*l[1][1];
    *q = lw_v2((l[0][2]*l[1][0] - l[0][0]*l[1][2])/det, (l[0][0]*l[1][1] - l[0][1]*l[1][0])/det);
    return fabs(det) > 1e-9;
}

static int draw_given_pin(const lw_guide_rows *r, const double *u, lw_vec2 a, lw_vec2 near, bool slides, lw_guide *out)
{
    /* the fixed pin is given; with slides a quarter of the guides have it, or the moving pin, at infinity */
    bool moving = slides && u[4] < 0.125, far = slides && u[4] < 0.25;
    lw_vec2 q, given = far ? lw_v2_polar(1, LW_PI*u[0]) : a;
    double w = far ? 0 : 1;
    if (!other_pin(r, w, given, moving, near, &q))
        return 0;
    lw_vec2 k = moving ? given : q, g = moving ? q : given;
    double z[Z] = { w, w*k.x, w*k.y, w*g.x, w*g.y, lw_v2_dot(k, g), lw_v2_cross(k, g) };
    if (far) {
        z[moving ? KX : GX] = given.x;
        z[moving ? KY : GY] = given.y;
    }
    *out = guide_of(r, z);
    return 1;
}

int lw_guide_rows_draw(const lw_guide_rows *r, const double *u, double reach, bool slides, lw_guide out[4])
{
    double d = reach*sqrt(u[0]), o = reach*sqrt(u[2]);
    if (r->n <= 2 && r->n >= 1)
        return draw_given_pin(r, u, lw_v2_polar(d, 2*LW_PI*u[1]), lw_v2_polar(o, 2*LW_PI*u[3]), slides, out);
    if (r->n != 3)
        return 0;
    /* A line of the fixed plane, or of the moving one, on which the pin lies: lines drawn evenly cut
     * a curve in points spread evenly over its length (Crofton 1868). */
    lw_guide_rows with = *r;
    bool moving = u[4] >= 0.5;
    lw_vec2 across = lw_v2_polar(1, LW_PI*u[1]);
    double row[Z] = { [W] = -reach*(2*u[0] - 1) };
    row[moving ? KX : GX] = across.x;
    row[moving ? KY : GY] = across.y;
    if (!lw_guide_rows_add(&with, row))
        return 0;
    int n = lw_guide_rows_solve(&with, out), kept = 0;
    for (int i = 0; i < n; i++)
        if (slides || out[i].kind == LW_GUIDE_RR)
            out[kept++] = out[i];
    return kept;
}
