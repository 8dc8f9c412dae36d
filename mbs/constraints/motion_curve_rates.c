/* mbs/constraints/motion_curve_rates.c - derivatives with respect to the inputs along a motion curve. */
#include "mbs/constraints/motion_curve_internal.h"

#include <string.h>

/* Near a branch point the k-th derivative loses k + 1 digits for each digit of the distance, although the curve is
 * smooth. There, derivatives come from a polynomial through points on both sides and their tangents. */
static const double beside = 0.025;                       /* use the polynomial within this arc of a branch point */
static const double knot[LW_MOTION_CURVE_KNOTS] = { -0.1, -0.06, -0.03, 0.03, 0.06, 0.1 };
enum { KNOTS = LW_MOTION_CURVE_KNOTS, TERMS = 2*KNOTS };
static const double least_rate = 1e-8;     /* d input / d arc; below this the input turns back or rests    */

static bool input_turns(const lw_motion_curve *b, int input)
{
    return lw_joint_turns(b->s->joint[b->s->input_joint[input]].kind);
}

bool lw_motion_curve_rates(lw_motion_curve *b, int order, const double *motion, double *q)
{
    double *scaled = b->motion;
    for (int i = 0; i < b->s->n_input; i++)
        for (int k = 0; k <= order; k++)
            scaled[i*(order + 1) + k] = motion[i*(order + 1) + k]/(input_turns(b, i) ? 1.0 : b->s->unit);
    if (!(lw_continuation_factor(&b->driven, q) > 1e-13))
        return false;
    lw_continuation_series(&b->driven, order, scaled, q);
    return true;
}

/* Taylor coefficients at 0 of the Hermite polynomial with values f and derivatives df at x[0], x[2], .., by divided
 * differences.  Only every other element of f and df is used. */
static void taylor(int n, const double *x, const double *f, const double *df, int order, double *out)
{
    double d[TERMS], c[TERMS] = { 0 };
    memcpy(d, f, (size_t)n*sizeof *d);
    for (int k = 1; k < n; k++)
        for (int i = n - 1; i >= k; i--)
            d[i] = x[i] == x[i - k] ? df[i] : (d[i] - d[i - 1])/(x[i] - x[i - k]);
    for (int i = n - 1; i >= 0; i--) {                    /* c = c (y - x_i) + d_i, in powers of y */
        for (int k = n - 1; k > 0; k--)
            c[k] = c[k]*-x[i] + c[k - 1];
        c[0] = c[0]*-x[i] + d[i];
    }
    memcpy(out, c, (size_t)(order + 1)*sizeof *out);
}

/* Posture and tangent at arc length `arc + away`, past the end of a closed curve if necessary; whole turns relative
 * to q. */
static void posture_beside(lw_motion_curve *b, double arc, double away, const double *q, double *p, double *tangent)
{
    double length = lw_motion_curve_length(b), at = arc + fmin(1.0, length)*away;
    if (b->end == LW_MOTION_CURVE_CLOSED)
        at -= length*floor(at/length);
    lw_motion_curve_posture(b, lw_motion_curve_station(b, fmin(fmax(at, 0.0), length)), p, tangent);
    for (int i = 2; i < b->n; i += 3)
        p[i] -= 2.0*LW_PI*round((p[i] - q[i])/(2.0*LW_PI));
}

/* The curve through posture q near the branch point at `arc`, as a series in the distance along its direction. */
static void series_beside(lw_motion_curve *b, double arc, const double *q, const double *direction, int order, double *out)
{
    double x[TERMS], *f = b->beside, *df = f + TERMS*b->n, one[LW_MOTION_CURVE_ORDER + 1];
    int n = 0;
    for (int k = 0; k < KNOTS; k++) {
        double *p = b->a, *t = b->b, along = 0.0, distance = 0.0;
        posture_beside(b, arc, knot[k], q, p, t);
        for (int i = 0; i < b->n; i++) {
            along += direction[i]*t[i];
            distance += direction[i]*(p[i] - q[i]);
        }
        if (n > 0 && distance <= x[n - 1])                /* at the end of an open curve */
            continue;
        x[n] = x[n + 1] = distance;
        for (int i = 0; i < b->n; i++) {
            f[i*TERMS + n] = f[i*TERMS + n + 1] = p[i];
            df[i*TERMS + n] = df[i*TERMS + n + 1] = t[i]/along;
        }
        n += 2;
    }
    for (int i = 0; i < b->n; i++) {
        taylor(n, x, f + i*TERMS, df + i*TERMS, order, one);
        out[i] = q[i];
        for (int k = 1; k <= order; k++)
            out[k*b->n + i] = one[k];
    }
}

/* power[j][k]: coefficient k of d(x)^j, where d solves  sum of u_j d^j = sum of w_k x^k,  j, k = 1 .. order.  Each d_k
 * follows from the earlier ones. */
static void invert(int order, const double *u, const double *w, double power[][LW_MOTION_CURVE_ORDER + 1])
{
    for (int k = 1; k <= order; k++) {
        double rest = w[k];
        for (int j = 2; j <= order; j++) {
            power[j][k] = 0.0;
            for (int i = 1; i < k; i++)
                power[j][k] += power[1][i]*power[j - 1][k - i];
            rest -= u[j]*power[j][k];
        }
        power[1][k] = rest/u[1];
    }
}

/* The curve and its free input are series in a distance; inverting the second and substituting it into the first
 * gives the motion. */
static bool motion_beside(lw_motion_curve *b, double arc, const double *direction, int order, const double *w, double *q)
{
    double *curve = b->beside + 2*TERMS*b->n, u[LW_MOTION_CURVE_ORDER + 1];
    double power[LW_MOTION_CURVE_ORDER + 1][LW_MOTION_CURVE_ORDER + 1] = { { 0 } };
    series_beside(b, arc, q, direction, order, curve);
    lw_system_measure_series(b->s, b->s->input_joint[b->input], order, curve, u);
    if (!(fabs(u[1]) > least_rate))
        return false;
    invert(order, u, w, power);
    for (int k = 1; k <= order; k++)
        for (int i = 0; i < b->n; i++) {
            q[k*b->n + i] = 0.0;
            for (int j = 1; j <= k; j++)
                q[k*b->n + i] += power[j][k]*curve[j*b->n + i];
        }
    return true;
}

/* The arc of the branch point near `arc`; false if there is none. */
static bool branch_point_near(const lw_motion_curve *b, double arc, double *at)
{
    double most = fmin(1.0, lw_motion_curve_length(b))*beside, length = lw_motion_curve_length(b);
    for (int i = 0; i < b->n_event; i++) {
        if (b->event[i].kind != LW_EVENT_CROSSING)
            continue;
        double gap = fabs(arc - (*at = lw_motion_curve_arc(b, b->event[i].station)));
        if (gap < most || (b->end == LW_MOTION_CURVE_CLOSED && length - gap < most))
            return true;
    }
    return false;
}

bool lw_motion_curve_motion(lw_motion_curve *b, double station, int order, const double *motion, double *q)
{
    double *direction = b->beside + (LW_MOTION_CURVE_BESIDE - 1)*b->n, at;
    double *all = b->motion + b->s->n_input*(LW_MOTION_CURVE_ORDER + 1);
    memset(all, 0, (size_t)b->s->n_input*(LW_MOTION_CURVE_ORDER + 1)*sizeof *all);
    double *own = all + b->input*(order + 1), unit = input_turns(b, b->input) ? 1.0 : b->s->unit;
    lw_motion_curve_posture(b, station, q, direction);
    if (b->rests)
        return false;
    for (int k = 1; k <= order; k++)
        own[k] = motion[k];
    if (!branch_point_near(b, lw_motion_curve_arc(b, station), &at))
        return lw_motion_curve_rates(b, order, all, q);
    for (int k = 1; k <= order; k++)
        own[k] /= unit;
    return motion_beside(b, at, direction, order, own, q);
}
