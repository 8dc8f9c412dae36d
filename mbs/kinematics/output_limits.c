/* mbs/kinematics/output_limits.c - sign changes of the speed of links at the ground. */
#include "mbs/kinematics/output_limits.h"

#include "base/real.h"
#include "mbs/batch/posture.h"

#define N_SAMPLE 256

/* A link at the ground. */
typedef struct output {
    const lw_plan    *plan;
    const lw_linkage *k;
    const double     *dim, *mode;
    int               joint, link;
    int               pin;        /* for a slider: a pin of the link, else -1                      */
    double            still;      /* speeds up to this are rounding                                 */
} output;

/* The speed (order 1) or acceleration (2) of the link by the input; NAN where the linkage does not close. */
static double rate(const output *o, double input, int order)
{
    lw_posture posture;
    if (lw_posture_solve(o->plan, o->dim, o->mode, input, order, &posture) != LW_OK || !(posture.margin > 0))
        return NAN;
    if (o->pin < 0)
        return posture.angle[o->link][order];
    return lw_v2_dot(posture.joint[o->pin][order], o->k->joint[o->joint].along);
}

/* The zero of `rate` between a, where its sign is that of fa, and b, where it is the opposite; bisection to
 * neighbouring numbers. */
static double zero(const output *o, double a, double b, double fa, int order)
{
    for (int i = 0; i < 200; i++) {
        double m = 0.5*(a + b);
        if (m == a || m == b)
            break;
        double f = rate(o, m, order);
        if ((f > 0) == (fa > 0))
            a = m;
        else
            b = m;
    }
    return 0.5*(a + b);
}

static int add(const output *o, double first, double last, double input, lw_output_limits *out, int n, int max)
{
    if (fabs(input) < 1e-14*(last - first))
        input = 0;
    if (n < max)
        out[n++] = (lw_output_limits){ o->link, o->joint, input };
    return n;
}

/* Find the changes of sign of the speed between samples where the link does not stand still; a link that never moves
 * has none. */
static int limits_of(const output *o, double first, double last, lw_output_limits *out, int n, int max)
{
    double step = (last - first)/N_SAMPLE;
    double a = first, fa = NAN, ga = NAN;
    for (int i = 0; i <= N_SAMPLE; i++) {
        double b = first + step*(i == 0 ? 1e-9 : i == N_SAMPLE ? N_SAMPLE - 1e-9 : i);
        double fb = rate(o, b, 1), gb = rate(o, b, 2);
        if (fabs(fb) <= o->still)
            continue;
        if (fa*fb < 0) {
            n = add(o, first, last, zero(o, a, b, fa, 1), out, n, max);
        } else if (fa*fb > 0 && ga*gb < 0 && fa*ga < 0) {      /* the speed has a minimum     */
            double dip = zero(o, a, b, ga, 2), fd = rate(o, dip, 1);
            if (fd*fa < 0 && fabs(fd) > o->still) {
                n = add(o, first, last, zero(o, a, dip, fa, 1), out, n, max);
                n = add(o, first, last, zero(o, dip, b, fd, 1), out, n, max);
            }
        }
        a = b; fa = fb; ga = gb;
    }
    return n;
}

/* The diagonal of the box around the joints [m]. */
static double size_of(const lw_linkage *linkage)
{
    lw_vec2 lo = linkage->joint[0].at, hi = lo;
    for (int j = 1; j < linkage->n_joint; j++) {
        lo = lw_v2(fmin(lo.x, linkage->joint[j].at.x), fmin(lo.y, linkage->joint[j].at.y));
        hi = lw_v2(fmax(hi.x, linkage->joint[j].at.x), fmax(hi.y, linkage->joint[j].at.y));
    }
    return lw_v2_norm(lw_v2_sub(hi, lo));
}

static int pin_on(const lw_linkage *linkage, int link)
{
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_turns(linkage->joint[j].kind) && (linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link))
            return j;
    return -1;
}

int lw_output_limits_find(const lw_plan *plan, const lw_linkage *linkage, const double *dim, const double *mode,
                          double first, double last, lw_output_limits *out, int max)
{
    int n = 0;
    double size = size_of(linkage), by = plan->input_is_slider ? size : 1;
    for (int j = 0; j < linkage->n_joint; j++) {
        const lw_joint *q = &linkage->joint[j];
        if (j == linkage->input[0].joint || (q->link[0] != linkage->ground && q->link[1] != linkage->ground))
            continue;
        int link = q->link[0] == linkage->ground ? q->link[1] : q->link[0];
        output o = { plan, linkage, dim, mode, j, link, -1, 1e-12/by };
        if (lw_joint_translates(q->kind)) {
            o.pin = pin_on(linkage, link);
            o.still *= size;
        }
        if (lw_joint_turns(q->kind) || o.pin >= 0)
            n = limits_of(&o, first, last, out, n, max);
    }
    return n;
}
