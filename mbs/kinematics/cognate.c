/* mbs/kinematics/cognate.c - the three four-bars of one coupler curve (Roberts 1875).
 *
 * With c = (cx + i cy)/r3 the coupler point is P = A + c (B - A).  The ground pins of the three four-bars are the
 * corners of a triangle similar to the coupler: A0, B0 and C0 = A0 + c (B0 - A0).  Parallelograms on A0 A P and B0 B P
 * give the moving pins.  Divided by the size of its frame, each cognate is the given quadrilateral A0 A B B0 with two
 * neighbouring sides exchanged (Dijksman 1976):
 *
 *     out[0]   frame C0 B0, factor 1 - c:   A0, A, A + (B0 - B), B0      coupler and output exchanged
 *     out[1]   frame A0 C0, factor c:       A0, A0 + (B - A), B, B0      crank and coupler exchanged
 *
 * Exchanging coupler and output mirrors the triangle A B B0 at the perpendicular bisector of A B0, so that the mode
 * changes its sign in every posture. */
#include "mbs/kinematics/fourbar.h"
#include <string.h>
#include "base/vec2.h"

static lw_vec2 divide(lw_vec2 a, lw_vec2 b)
{
    return lw_v2_scale(lw_v2_unturn(a, b), 1.0/lw_v2_dot(b, b));
}

/* Write the nine numbers of a four-bar: its four lengths times |factor|, with the ground from `origin` along `frame`
 * and the tracer at `ratio` times the coupler. */
static void build(double g, double a, double b, double h, lw_vec2 factor, lw_vec2 ratio, lw_vec2 origin, lw_vec2 frame, double out[9])
{
    double size = lw_v2_norm(factor);
    lw_vec2 tracer = lw_v2_scale(ratio, size*b);
    double numbers[9] = { size*g, size*a, size*b, size*h, tracer.x, tracer.y, origin.x, origin.y,
                          atan2(frame.y, frame.x) };
    memcpy(out, numbers, sizeof numbers);
}

/* The place of B (origin A0) and the unit direction of the coupler at an input angle, both in the frame. */
static lw_status close_loop(const double r[4], double mode, double angle, lw_vec2 *b, lw_vec2 *coupler)
{
    lw_vec2 a = lw_v2_polar(r[1], angle), line = lw_v2_sub(lw_v2(r[0], 0.0), a);
    double d = lw_v2_norm(line);
    if (!(d <= r[2] + r[3] && d >= fabs(r[2] - r[3]) && d > 0.0))
        return LW_OPEN;
    /* half-angle formula for the angle at A between the diagonal and the coupler */
    double t = 2.0*atan2(sqrt(fmax(0.0, (r[3] - d + r[2])*(r[3] + d - r[2]))), sqrt(fmax(0.0, (d + r[2] - r[3])*(d + r[2] + r[3]))));
    *coupler = lw_v2_turn(lw_v2_scale(line, 1.0/d), lw_v2_polar(1.0, mode < 0.0 ? -t : t));
    *b = lw_v2_add(a, lw_v2_scale(*coupler, r[2]));
    return LW_OK;
}

lw_status lw_fourbar_cognate_posture(const double in[9], double mode, double angle, double out_angle[2], double out_mode[2])
{
    lw_fourbar_class c;
    lw_status status = lw_fourbar_classify(in, LW_FOURBAR_TOLERANCE, &c, NULL);
    if (status != LW_OK)
        return status;
    lw_vec2 b, coupler;
    status = close_loop(in, mode, angle, &b, &coupler);
    if (status != LW_OK)
        return status;
    lw_vec2 crank = lw_v2_scale(coupler, in[2]), b0 = lw_v2(in[0], 0.0);
    double side = lw_v2_cross(lw_v2_sub(b0, crank), lw_v2_sub(b, crank));
    out_angle[0] = remainder(angle, 2.0*LW_PI);
    out_angle[1] = atan2(coupler.y, coupler.x);
    out_mode[0] = mode < 0.0 ? 1.0 : -1.0;
    out_mode[1] = side < 0.0 ? -1.0 : 1.0;
    return LW_OK;
}

lw_status lw_fourbar_cognates(const double in[9], double mode, double out[2][9], double out_mode[2])
{
    memset(out, 0, 2*sizeof *out);
    lw_fourbar_class class;
    lw_status status = lw_fourbar_classify(in, LW_FOURBAR_TOLERANCE, &class, NULL);
    if (status != LW_OK)
        return status;
    double posture[2], third = (2.0*class.range[0][0] + class.range[0][1])/3.0;
    status = lw_fourbar_cognate_posture(in, mode, third, posture, out_mode);
    if (status != LW_OK)
        return status;

    lw_vec2 c = lw_v2(in[4]/in[2], in[5]/in[2]), rest = lw_v2(1.0 - c.x, -c.y);
    lw_vec2 a0 = lw_v2(in[6], in[7]), frame = lw_v2_polar(in[0], in[8]);
    lw_vec2 c0 = lw_v2_add(a0, lw_v2_turn(c, frame));
    const double nearest = 1e-12;
    bool at_a = lw_v2_norm(c) < nearest, at_b = lw_v2_norm(rest) < nearest;
    if (!at_b)
        build(in[0], in[1], in[3], in[2], rest, lw_v2_scale(divide(c, rest), -1.0), c0, lw_v2_turn(rest, frame), out[0]);
    if (!at_a)
        build(in[0], in[2], in[1], in[3], c, divide(lw_v2(1.0, 0.0), c), a0, lw_v2_turn(c, frame), out[1]);
    return at_a || at_b ? LW_E_NUMERIC : LW_OK;
}
