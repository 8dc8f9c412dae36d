/* mbs/kinematics/motion_search.c - the parts of a piece of the input's range where a dyad closes, by samples.
 *
 * Near a limit of an earlier dyad postures vary like the square root of the distance to it.  With
 *     input = middle - half cos(pi s)
 * the margin is a smooth function of s in [0, 1] up to both ends, and samples at equal steps of s are dense there. */
#include "mbs/kinematics/motion_internal.h"
#include "mbs/batch/posture.h"

enum { N_SAMPLE = 256 };

static const double touch_margin = 1e-13;          /* a margin this small touches 0 */

typedef struct track {
    const lw_plan  *plan;
    const double   *dim;
    const lw_step  *step;
    const lw_motion_piece *piece;
} track;

static double input_at(const lw_motion_piece *p, double s)
{
    double first = p->end[0].at, last = p->end[1].at;
    if (p->turns)
        return first + s*(last - first);
    return 0.5*(first + last) - 0.5*(last - first)*cos(LW_PI*s);
}

static lw_opening opening_at(const track *k, double s)
{
    lw_vec2 reg[LW_REG_MAX];
    lw_posture_registers(k->plan, k->dim, k->piece->mode, input_at(k->piece, s), reg);
    return lw_dyad_opening(k->dim, k->step, reg);
}

static double margin_at(const track *k, double s)
{
    lw_opening o = opening_at(k, s);
    return o.less*o.more;
}

static double angle_at(const track *k, double s)
{
    lw_opening o = opening_at(k, s);
    return 2.0*atan2(sqrt(fmax(o.less, 0.0)), sqrt(fmax(o.more, 0.0)));
}

/* The s in [lo, hi] of the least sign*of, by golden sections; *f is the value there. */
static double extreme(const track *k, double (*of)(const track *, double), double sign, double lo, double hi, double *f)
{
    const double golden = 0.6180339887498949;
    double a = hi - golden*(hi - lo), b = lo + golden*(hi - lo);
    double fa = sign*of(k, a), fb = sign*of(k, b);
    while (hi - lo > 1e-9) {
        if (fa < fb) {
            hi = b, b = a, fb = fa;
            a = hi - golden*(hi - lo);
            fa = sign*of(k, a);
        } else {
            lo = a, a = b, fa = fb;
            b = lo + golden*(hi - lo);
            fb = sign*of(k, b);
        }
    }
    *f = sign*fmin(fa, fb);
    return fa < fb ? a : b;
}

/* The root of the margin between lo and hi, by bisection to the last bit. */
static double root(const track *k, double lo, double hi, bool outside_at_lo)
{
    for (;;) {
        double s = 0.5*(lo + hi);
        if (s <= lo || s >= hi)
            return s;
        if ((margin_at(k, s) < 0.0) == outside_at_lo)
            lo = s;
        else
            hi = s;
    }
}

/* ---- roots and touches -------------------------------------------------------------------------- */

typedef struct findings {
    int    n_root, n_touch;
    double root[LW_PIECE_MAX], touch[LW_MARK_MAX];         /* rising s */
} findings;

static void add_root(findings *f, double s)
{
    if (f->n_root < LW_PIECE_MAX)
        f->root[f->n_root++] = s;
}

/* The margin has one sign at lo and hi and an extremum near 0 between them: add two roots, or a touch. */
static void look_closer(const track *k, findings *f, double lo, double hi, bool outside)
{
    double least, s = extreme(k, margin_at, outside ? -1.0 : 1.0, lo, hi, &least);
    if ((least < 0.0) != outside && fabs(least) > touch_margin) {
        add_root(f, root(k, lo, s, outside));
        add_root(f, root(k, s, hi, !outside));
    } else if (!outside && fabs(least) <= touch_margin && f->n_touch < LW_MARK_MAX)
        f->touch[f->n_touch++] = s;
}

static void find_roots(const track *k, findings *f)
{
    double m[N_SAMPLE + 1], h = 1.0/N_SAMPLE;
    for (int j = 0; j <= N_SAMPLE; j++)
        m[j] = margin_at(k, j*h);
    f->n_root = f->n_touch = 0;
    for (int j = 0; j <= N_SAMPLE; j++) {
        bool inside = k->piece->turns || (j > 0 && j < N_SAMPLE);
        double before = m[j > 0 ? j - 1 : N_SAMPLE - 1], after = m[j < N_SAMPLE ? j + 1 : 1];
        bool outside = m[j] < 0.0, same = (before < 0.0) == outside && (after < 0.0) == outside;
        if (inside && j < N_SAMPLE && same && fabs(m[j]) <= fabs(before) && fabs(m[j]) < fabs(after))
            look_closer(k, f, (j - 1)*h, (j + 1)*h, outside);
        if (j < N_SAMPLE && (after < 0.0) != outside)
            add_root(f, root(k, j*h, (j + 1)*h, outside));
    }
}

/* ---- pieces ------------------------------------------------------------------------------------- */

static lw_mark mark_at(const track *k, double s, int dyad)
{
    return (lw_mark){ input_at(k->piece, s), dyad };
}

/* The whole piece with the touches found in it.  The caller removes those that do not lie in a part. */
static lw_motion_piece with_touches(const track *k, const findings *f, int dyad)
{
    lw_motion_piece p = *k->piece;
    for (int i = 0; i < f->n_touch && p.n_touch < LW_MARK_MAX; i++)
        p.touch[p.n_touch++] = mark_at(k, f->touch[i], dyad);
    return p;
}

int lw_piece_search(const lw_plan *plan, const double *dim, int dyad, const lw_step *step,
                    const lw_motion_piece *whole, lw_motion_piece *part)
{
    track k = { plan, dim, step, whole };
    findings f;
    find_roots(&k, &f);
    lw_motion_piece touched = with_touches(&k, &f, dyad);
    bool round = whole->turns && f.n_root > 0;              /* the first root follows the last        */
    int n = 0, n_gap = round ? f.n_root : f.n_root + 1;
    for (int i = 0; i < n_gap && n < LW_PIECE_MAX; i++) {
        bool from_start = !round && i == 0, to_end = !round && i == f.n_root;
        int first = round ? i : i - 1, last = round ? (i + 1)%f.n_root : i;
        double lo = from_start ? 0.0 : f.root[first];
        double hi = to_end ? 1.0 : f.root[last] + (round && last <= first ? 1.0 : 0.0);
        if (margin_at(&k, lo + 0.37*(hi - lo)) < 0.0)
            continue;
        lw_motion_piece *p = &part[n++];
        *p = touched;
        p->turns = whole->turns && !round;
        if (!from_start)
            p->end[0] = mark_at(&k, lo, dyad);
        if (!to_end)
            p->end[1] = mark_at(&k, hi, dyad);
    }
    return n;
}

/* At limits and touches of this dyad the angle is exactly 0 or pi; samples have only half of the digits. */
static void snap(double at, double range[2])
{
    if (at < 0.5*LW_PI)
        range[0] = 0.0;
    else
        range[1] = LW_PI;
}

void lw_piece_transmission(const lw_plan *plan, const double *dim, int dyad, const lw_step *step, const lw_motion_piece *p, double range[2])
{
    track k = { plan, dim, step, p };
    double a[N_SAMPLE + 1], h = 1.0/N_SAMPLE, f;
    for (int j = 0; j <= N_SAMPLE; j++)
        a[j] = angle_at(&k, j*h);
    range[0] = range[1] = a[0];
    for (int j = 0; j <= N_SAMPLE; j++)
        for (int side = 0; side < 2; side++) {
            double sign = side ? -1.0 : 1.0, lo = fmax(j - 1, 0)*h, hi = fmin(j + 1, N_SAMPLE)*h;
            if (sign*(a[j] - range[side]) > 0.0 || (j > 0 && sign*(a[j - 1] - a[j]) < 0.0) ||
                (j < N_SAMPLE && sign*(a[j + 1] - a[j]) < 0.0))
                continue;
            extreme(&k, angle_at, sign, lo, hi, &f);
            range[side] = sign*fmin(sign*f, sign*a[j]);
        }
    for (int end = 0; end < 2; end++)
        if (!p->turns && p->end[end].dyad == dyad)
            snap(a[end ? N_SAMPLE : 0], range);
    for (int i = 0; i < p->n_touch; i++)
        if (p->touch[i].dyad == dyad)
            snap(range[0] < LW_PI - range[1] ? range[0] : range[1], range);
}
