#include "mbs/turning.h"

#include <math.h>
#include "mbs/pose.h"

#define N_SAMPLE 256

/* speed of one link in its ground joint, and its derivative, as functions of the input */
typedef struct output {
    const lw_plan    *plan;
    const lw_linkage *k;
    const double     *dim, *mode;
    int               joint, link;
    int               pin;        /* for a slide: a pin the link carries, else -1                  */
} output;

/* order 1: speed, 2: acceleration; NAN where the linkage does not close. */
static double rate(const output *o, double input, int order)
{
    lw_pose pose;
    if (lw_pose_solve(o->plan, o->dim, o->mode, input, order, &pose) != LW_OK || !(pose.margin > 0))
        return NAN;
    if (o->pin < 0)
        return pose.angle[o->link][order];
    return lw_v2_dot(pose.joint[o->pin][order], o->k->joint[o->joint].along);
}

/* Zero of rate between a and b, where it has the signs of fa and -fa: bisection to neighbouring
 * numbers, because a turning is printed, not iterated on. */
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

static int add(const output *o, double input, lw_turning *out, int n, int max)
{
    if (n < max)
        out[n++] = (lw_turning){ o->link, o->joint, input };
    return n;
}

static int turnings_of(const output *o, double first, double last, lw_turning *out, int n, int max)
{
    double step = (last - first)/N_SAMPLE;
    double a = first + 1e-9*step, fa = rate(o, a, 1), ga = rate(o, a, 2);
    for (int i = 1; i <= N_SAMPLE; i++) {
        double b = first + step*(i < N_SAMPLE ? i : N_SAMPLE - 1e-9);
        double fb = rate(o, b, 1), gb = rate(o, b, 2);
        if (fa*fb < 0) {
            n = add(o, zero(o, a, b, fa, 1), out, n, max);
        } else if (fb == 0 && i < N_SAMPLE) {
            n = add(o, b, out, n, max);
        } else if (fa*fb > 0 && ga*gb < 0 && fa*ga < 0) {      /* the speed dips towards zero */
            double dip = zero(o, a, b, ga, 2), fd = rate(o, dip, 1);
            if (fd*fa < 0) {
                n = add(o, zero(o, a, dip, fa, 1), out, n, max);
                n = add(o, zero(o, dip, b, fd, 1), out, n, max);
            }
        }
        a = b; fa = fb; ga = gb;
    }
    return n;
}

static int pin_on(const lw_linkage *k, int link)
{
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].kind == LW_JOINT_REVOLUTE && (k->joint[j].link[0] == link || k->joint[j].link[1] == link))
            return j;
    return -1;
}

int lw_turning_find(const lw_plan *plan, const lw_linkage *k, const double *dim, const double *mode,
                    double first, double last, lw_turning *out, int max)
{
    int n = 0;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *q = &k->joint[j];
        if (j == k->input[0].joint || (q->link[0] != k->ground && q->link[1] != k->ground))
            continue;
        int link = q->link[0] == k->ground ? q->link[1] : q->link[0];
        output o = { plan, k, dim, mode, j, link, -1 };
        if (q->kind == LW_JOINT_SLIDER)
            o.pin = pin_on(k, link);
        if (q->kind == LW_JOINT_REVOLUTE || o.pin >= 0)
            n = turnings_of(&o, first, last, out, n, max);
    }
    return n;
}
