/* mbs/kinematics/fourbar.c - class, limits and transmission angle of a four-bar from its four lengths.
 *
 * In an extreme posture of a four-bar two links are in line, so that the four links form a triangle.  By the half-angle
 * formula an angle of the triangle is a quotient of signed sums of the four lengths (Heron's factors).  Eight sums
 * occur:
 *
 *     all = g + a + b + h                                g frame, a input, b coupler, h output
 *     less[i]: all with link i negative                  > 0 for all i when it can be assembled
 *     pair[i]: frame plus link i minus the other two     0 at a change point
 *
 * Near a change point acos would lose half the digits; these quotients lose none. */
#include "mbs/kinematics/fourbar.h"
#include <stdio.h>
#include <string.h>
#include "base/real.h"
#include "base/sum.h"
#include "base/vec2.h"
#include "base/vector.h"

enum { G, A, B, H };                      /* frame, input, coupler, output */

typedef struct sums {
    double all, less[4], pair[4];         /* pair[G] is not used           */
    double equal;                         /* |pair| <= equal counts as 0   */
} sums;

static sums make_sums(const double r[4], double tolerance)
{
    sums s;
    s.all = lw_sum4(r[G], r[A], r[B], r[H]);
    for (int i = 0; i < 4; i++)
        s.less[i] = lw_sum4(i == G ? -r[G] : r[G], i == A ? -r[A] : r[A], i == B ? -r[B] : r[B], i == H ? -r[H] : r[H]);
    s.pair[G] = s.all;
    for (int i = 1; i < 4; i++)
        s.pair[i] = lw_sum4(r[G], i == A ? r[A] : -r[A], i == B ? r[B] : -r[B], i == H ? r[H] : -r[H]);
    s.equal = tolerance*s.all;
    return s;
}

/* The sign of pair[i]; 0 within the tolerance. */
static int sign(const sums *s, int i)
{
    return s->pair[i] > s->equal ? 1 : s->pair[i] < -s->equal ? -1 : 0;
}

/* The angle t in [0, pi] with  tan^2(t/2) = (n1 n2)/(d1 d2). */
static double half_angle(double n1, double n2, double d1, double d2)
{
    return 2.0*atan2(sqrt(fabs(n1))*sqrt(fabs(n2)), sqrt(fabs(d1))*sqrt(fabs(d2)));
}

/* The diagonal from the crank pin to the rocker pivot is at most b + h and at least |b - h|.  So the input has an outer
 * limit when g + a > b + h and an inner limit when |g - a| < |b - h|. */
static bool outer_limit(const sums *s, double *t)
{
    *t = half_angle(s->less[G], s->less[A], s->pair[A], s->all);
    return sign(s, A) > 0;
}

static bool inner_limit(const sums *s, double *t)
{
    *t = half_angle(s->pair[H], s->pair[B], s->less[B], s->less[H]);
    return sign(s, H)*sign(s, B) < 0;
}

/* Has the output neither limit?  Exchange a and h in the conditions for the input. */
static bool output_turns(const sums *s)
{
    return sign(s, H) <= 0 && sign(s, A)*sign(s, B) >= 0;
}

static void find_ranges(const sums *s, lw_fourbar_class *c)
{
    double out, in;
    bool has_out = outer_limit(s, &out), has_in = inner_limit(s, &in);
    c->crank = !has_out && !has_in;
    c->n_range = has_out && has_in ? 2 : 1;
    if (has_out && has_in) {
        double range[2][2] = { { -out, -in }, { in, out } };
        memcpy(c->range, range, sizeof range);
    } else if (has_in) {
        c->range[0][0] = in;
        c->range[0][1] = 2.0*LW_PI - in;
    } else {
        c->range[0][0] = has_out ? -out : -LW_PI;
        c->range[0][1] = has_out ? out : LW_PI;
    }
    c->n_limit = 0;
    if (has_out)
        c->limit[c->n_limit++] = -out;
    if (has_in) {
        c->limit[c->n_limit++] = -in;
        c->limit[c->n_limit++] = in;
    }
    if (has_out)
        c->limit[c->n_limit++] = out;
}

/* Add t and -t, but only once where they are the same angle. */
static int add_pair(double *list, int n, double t)
{
    if (t > 0.0 && t < LW_PI)
        list[n++] = -t;
    list[n++] = t;
    return n;
}

/* Dead points: crank and coupler are in line.  Extended, they form a triangle with g and h when a + b <= g + h; folded,
 * when |a - b| >= |g - h|.  Equality is a change point, where they lie along the frame.  With a = b (then g = h) the
 * folded links leave the rocker pin on the crank pivot at any angle, which is no dead point. */
static void find_dead_points(const sums *s, const double r[4], lw_fourbar_class *c)
{
    int n = 0, drawn = sign(s, H), fold_a = sign(s, A), fold_b = sign(s, B);
    if (drawn > 0)
        n = add_pair(c->dead, n, half_angle(s->less[G], s->pair[H], s->less[H], s->all));
    else if (drawn == 0)
        n = add_pair(c->dead, n, 0.0);
    if (fold_a*fold_b < 0)
        n = add_pair(c->dead, n, half_angle(s->pair[B], s->less[A], s->pair[A], s->less[B]));
    else if (fabs(r[A] - r[B]) > s->equal && fold_a*fold_b == 0)
        n = add_pair(c->dead, n, fold_b == 0 ? 0.0 : LW_PI);
    lw_sort((size_t)n, c->dead);
    c->n_dead = n;
}

/* The transmission angle grows with the diagonal.  The diagonal is extreme where frame and input are in line, or else
 * at limits of motion, where coupler and output are in line. */
static void find_transmission(const sums *s, lw_fourbar_class *c)
{
    c->transmission[0] = sign(s, H)*sign(s, B) <= 0 ? 0.0
                       : half_angle(s->pair[H], s->pair[B], s->less[G], s->less[A]);
    c->transmission[1] = sign(s, A) >= 0 ? LW_PI
                       : half_angle(s->less[B], s->less[H], s->pair[A], s->all);
}

static const struct { const char *symbol, *name; } class_table[15] = {
    [1]  = { "GCCC",  "double crank" },
    [2]  = { "GCRR",  "crank-rocker" },
    [3]  = { "GRCR",  "double rocker with a turning coupler" },
    [4]  = { "GRRC",  "rocker-crank" },
    [5]  = { "RRR1",  "triple rocker, frame longest" },
    [6]  = { "RRR2",  "triple rocker, input longest" },
    [7]  = { "RRR3",  "triple rocker, coupler longest" },
    [8]  = { "RRR4",  "triple rocker, output longest" },
    [9]  = { "CPCCC", "change-point double crank" },
    [10] = { "CPCRR", "change-point crank-rocker" },
    [11] = { "CPRCR", "change-point double rocker" },
    [12] = { "CPRRC", "change-point rocker-crank" },
    [13] = { "CP2X",  "double change point, two equal pairs" },
    [14] = { "CP3X",  "triple change point, all links equal" },
};

/* Barker's number of the class, from the links sorted by length and the sign of s + l - p - q. */
static int class_number(const double r[4], const int order[4], int excess, double equal)
{
    if (excess < 0)
        return 1 + order[0];
    if (excess > 0)
        return 5 + order[3];
    if (r[order[3]] - r[order[0]] <= equal)
        return 14;
    if (r[order[1]] - r[order[0]] <= equal && r[order[3]] - r[order[2]] <= equal)
        return 13;
    return 9 + order[0];
}

static void sort_links(const double r[4], int order[4])
{
    for (int i = 0; i < 4; i++) {
        int k = i;
        for (; k > 0 && r[order[k - 1]] > r[i]; k--)
            order[k] = order[k - 1];
        order[k] = i;
    }
}

/* s + l - p - q (shortest plus longest minus the other two): the pair of the frame and its partner, or its negative. */
static double change_sum(const sums *s, const int order[4])
{
    bool outer = order[0] == G || order[3] == G;
    int one = order[outer ? 0 : 1], other = order[outer ? 3 : 2];
    int partner = one == G ? other : one;
    return outer ? s->pair[partner] : -s->pair[partner];
}

static lw_status check_lengths(const double r[4], const int order[4], lw_error *e)
{
    static const char *const link[4] = { "frame", "input", "coupler", "output" };
    for (int i = 0; i < 4; i++)
        if (!(r[i] > 0.0 && isfinite(r[i])))
            return lw_error_set(e, LW_E_ARG, "the length of the %s is %g; it must be positive and finite", link[i], r[i]);
    int longest = order[3];
    double others = lw_sum4(r[order[0]], r[order[1]], r[order[2]], 0.0);
    double excess = lw_sum4(r[longest], -r[order[0]], -r[order[1]], -r[order[2]]);
    if (excess < 0.0)
        return LW_OK;
    char by[48] = "equals it";
    if (excess > 0.0)
        snprintf(by, sizeof by, "exceeds it by %.3g", excess);
    return lw_error_set(e, LW_E_ARG,
        "the four-bar cannot be assembled: its longest link, the %s (%.9g), must be shorter than the "
        "sum of the other three (%.9g), and %s; shorten it or lengthen another link",
        link[longest], r[longest], others, by);
}

lw_status lw_fourbar_classify(const double r[4], double tolerance, lw_fourbar_class *c, lw_error *e)
{
    memset(c, 0, sizeof *c);
    if (!(tolerance >= 0.0 && tolerance < 0.1))
        return lw_error_set(e, LW_E_ARG, "the tolerance is %g; it must be at least 0 and less than 0.1", tolerance);
    int order[4], shift;
    sort_links(r, order);
    lw_status status = check_lengths(r, order, e);
    if (status != LW_OK)
        return status;

    frexp(r[order[3]], &shift);           /* scale to size 1 by a power of two: no rounding */
    double unit[4];
    for (int i = 0; i < 4; i++)
        unit[i] = ldexp(r[i], -shift);
    sums s = make_sums(unit, tolerance);
    double change = change_sum(&s, order);
    int excess = change > s.equal ? 1 : change < -s.equal ? -1 : 0;

    c->number = class_number(unit, order, excess, s.equal);
    c->symbol = class_table[c->number].symbol;
    c->name = class_table[c->number].name;
    c->grashof = excess <= 0;
    c->circuits = excess < 0 ? 2 : 1;
    c->change = change/s.all + 0.0;        /* 0, not -0 */
    c->margin = fmin(fabs(s.pair[A]), fmin(fabs(s.pair[B]), fabs(s.pair[H])))/s.all;
    c->rocker_turns = output_turns(&s);
    find_ranges(&s, c);
    find_dead_points(&s, unit, c);
    find_transmission(&s, c);
    return LW_OK;
}
