/* mbs/plan/steps_internal.h - the formulas of all kinds of steps: value and margin; derivatives backwards (see
 * mbs/plan/dyad_internal.h); Taylor series; first derivative.  Internal to mbs.
 *
 * They are inlined into the single posture (mbs/batch/posture.c), into the loops over many lanes
 * (mbs/batch/kernel_steps.c), where `kind` is a constant, and into the equation in one coordinate
 * (mbs/reduced/steps.c). */
#ifndef LW_MBS_PLAN_STEPS_INTERNAL_H
#define LW_MBS_PLAN_STEPS_INTERNAL_H

#include "mbs/plan/jet_internal.h"
#include "mbs/plan/sincos_internal.h"

/* Columns of LW_STEP_LIST. */
#define LW_STEP_COLUMN(function, column)                                       \
    LW_INLINE int function(const lw_step_kind kind)                            \
    {                                                                          \
        switch (kind) { LW_STEP_LIST(column) case LW_STEP_HIGHER: break; }     \
        return 0;                                                              \
    }
#define LW_STEP_INPUTS(name, inputs, points, outputs, dims)  case LW_STEP_##name: return inputs;
#define LW_STEP_POINTS(name, inputs, points, outputs, dims)  case LW_STEP_##name: return points;
#define LW_STEP_OUTPUTS(name, inputs, points, outputs, dims) case LW_STEP_##name: return outputs;
#define LW_STEP_DIMS(name, inputs, points, outputs, dims)    case LW_STEP_##name: return dims;
LW_STEP_COLUMN(lw_step_inputs, LW_STEP_INPUTS)
LW_STEP_COLUMN(lw_step_points, LW_STEP_POINTS)
LW_STEP_COLUMN(lw_step_outputs, LW_STEP_OUTPUTS)
LW_STEP_COLUMN(lw_step_dims, LW_STEP_DIMS)

LW_INLINE bool lw_step_is_input(const lw_step_kind kind)
{
    return kind == LW_STEP_INPUT_PIN || kind == LW_STEP_INPUT_SLIDE;
}

/* The numbers of a step: its dimensions (0 where there is none) and mode; `turn` is the cosine and sine of the
 * dimension that is an angle, or the input as a unit vector or (displacement, 0); by and flat are set by
 * lw_step_prepare: 1/dim[0], 1/dim[1] and lw_rrr_flat. */
typedef struct lw_step_numbers { double dim[3], mode, by[2], flat; lw_vec2 turn; int power[2]; } lw_step_numbers;

/* A step in one posture.  Displacements are (d, 0); the adjoint of a direction or displacement stands in x.  `inv` is
 * the reciprocal of `root`, the only division that derivatives need; `open`: circles or lines do not meet. */
typedef struct lw_step_lane {
    lw_vec2   in[4], out[3], in_bar[4], out_bar[3];
    double    dim_bar[3], input_bar, margin, root, inv;
    long long open;
} lw_step_lane;

LW_INLINE void lw_step_prepare(const lw_step_kind kind, lw_step_numbers *q)
{
    if (kind == LW_STEP_RRR || kind == LW_STEP_ROLL)
        q->by[0] = 1/lw_away_from_zero(q->dim[0]);
    if (kind == LW_STEP_RRR) {
        q->by[1] = 1/lw_away_from_zero(q->dim[1]);
        q->flat = lw_rrr_flat(q->dim[0], q->dim[1]);
    }
}

/* u times v to the power n. */
LW_INLINE lw_vec2 lw_times_power(lw_vec2 u, lw_vec2 v, int n)
{
    v.y = n < 0 ? -v.y : v.y;
    for (int i = 0; i < (n < 0 ? -n : n); i++)
        u = lw_v2_turn(u, v);
    return u;
}

/* The outputs; of a dyad or rack also the margin, and the root of a dyad.  met: are the circles of RRR known to meet?
 * Higher groups are solved together, not here. */
LW_INLINE void lw_step_value(const lw_step_kind kind, lw_step_lane *z, const lw_step_numbers *q, const int met)
{
    const lw_vec2 *in = z->in;
    switch (kind) {
    case LW_STEP_INPUT_PIN:
        z->out[0] = q->turn;
        break;
    case LW_STEP_INPUT_SLIDE:
        z->out[0] = lw_frame_point(in[0], in[1], q->turn.x, 0);
        break;
    case LW_STEP_POINT:
        z->out[0] = lw_frame_point(in[0], in[1], q->dim[0], q->dim[1]);
        break;
    case LW_STEP_LINE:
        z->out[1] = lw_v2_turn(q->turn, in[1]);
        z->out[0] = lw_frame_point(in[0], z->out[1], 0, q->dim[0]);
        break;
    case LW_STEP_RRR: {
        lw_rrr d = lw_rrr_solve_met(in[0], in[1], q->dim[0], q->dim[1], q->mode, met);
        lw_vec2 arm = lw_rrr_arm(&d);
        z->out[2] = lw_v2_add(in[0], arm);
        z->out[0] = lw_v2_scale(arm, q->by[0]);
        z->out[1] = lw_v2_scale(lw_rrr_other(&d, lw_v2_sub(z->out[2], in[1]), met), q->by[1]);
        z->margin = lw_rrr_margin(&d, q->flat);
        z->root = d.y;
        z->open = d.h >= 0 ? 0 : 1;
        break;
    }
    case LW_STEP_RRP: {
        lw_rrp d = lw_rrp_solve_along(in[0], in[1], in[2], q->dim[0], q->mode);
        z->out[0] = lw_rrp_direction(&d);
        z->out[1] = lw_v2_add(in[0], d.arm);
        z->margin = lw_rrp_margin(&d);
        z->root = d.y;
        break;
    }
    case LW_STEP_RPR: {
        lw_rpr d = lw_rpr_solve(in[0], in[1], q->dim[0], q->mode);
        z->out[0] = d.u;
        z->margin = lw_rpr_margin(&d);
        z->root = d.y;
        break;
    }
    case LW_STEP_PRP:
    case LW_STEP_PPR: {
        lw_prp d = lw_prp_solve(in[0], in[1], in[2], in[3]);
        z->out[0] = d.c;
        z->margin = lw_prp_margin(&d);
        z->root = d.sine;
        break;
    }
    case LW_STEP_TURN:
        z->out[0] = lw_v2_turn(in[0], lw_v2(in[1].x, q->power[0]*in[1].y));
        break;
    case LW_STEP_SLIDE:
        z->out[0] = lw_frame_point(in[0], in[1], in[2].x, 0);
        break;
    case LW_STEP_GEAR:                         /* by repeated products: the powers are small */
        z->out[0] = lw_times_power(lw_times_power(q->turn, in[0], q->power[0]), in[1], q->power[1]);
        break;
    case LW_STEP_ALONG:
        z->out[0] = lw_v2(lw_v2_dot(lw_v2_sub(in[2], in[0]), in[1]), 0);
        break;
    case LW_STEP_ROLL:
        z->out[0] = lw_v2_turn(in[0], lw_sincos(lw_rolled(in[1].x, q->dim[0], q->dim[1])));
        break;
    case LW_STEP_RACK: {
        lw_vec2 a = lw_v2_unturn(in[0], in[1]);
        double off = lw_off_middle(lw_bearing(a.x, a.y), q->dim[2]);
        z->out[0] = lw_v2(q->dim[1] + q->dim[0]*(q->dim[2] + off), 0);
        z->margin = lw_rack_margin(off);
        break;
    }
    case LW_STEP_HIGHER:
        break;
    }
}

/* Set the adjoint of point `second` to `pull`, and that of point 0 to the adjoint of the tip minus `pull`. */
LW_INLINE void lw_step_pull(lw_step_lane *z, const int second, lw_vec2 tip, lw_vec2 pull)
{
    z->in_bar[0] = lw_v2_sub(tip, pull);
    z->in_bar[second] = pull;
}

/* The adjoints of the inputs and dimensions from those of the outputs.  The middle of a rack has none: it only selects
 * a turn. */
LW_INLINE void lw_step_back(const lw_step_kind kind, lw_step_lane *z, const lw_step_numbers *q)
{
    const lw_vec2 *in = z->in, *out = z->out, bar = z->out_bar[0];
    switch (kind) {
    case LW_STEP_INPUT_PIN:
        z->input_bar = bar.x;
        break;
    case LW_STEP_INPUT_SLIDE:
        z->input_bar = lw_v2_dot(bar, in[1]);
        z->in_bar[0] = bar;
        z->in_bar[1].x = q->turn.x*lw_v2_dot(bar, lw_v2_perp(in[1]));
        break;
    case LW_STEP_POINT: {
        double along = lw_v2_dot(bar, in[1]), across = lw_v2_dot(bar, lw_v2_perp(in[1]));
        z->dim_bar[0] = along;
        z->dim_bar[1] = across;
        z->in_bar[0] = bar;
        z->in_bar[1].x = q->dim[0]*across - q->dim[1]*along;
        break;
    }
    case LW_STEP_LINE: {
        double turn = z->out_bar[1].x - q->dim[0]*lw_v2_dot(bar, out[1]);
        z->dim_bar[0] = lw_v2_dot(bar, lw_v2_perp(out[1]));
        z->dim_bar[1] = turn;
        z->in_bar[0] = bar;
        z->in_bar[1].x = turn;
        break;
    }
    case LW_STEP_RRR: {
        const double r1 = q->dim[0], r2 = q->dim[1];
        lw_vec2 u1 = out[0], tip = lw_frame_point(in[0], u1, r1, 0), c = z->out_bar[2];
        lw_vec2 u2 = lw_v2_scale(lw_v2_sub(tip, in[1]), q->by[1]);
        double d1 = lw_v2_dot(c, u1), d2 = 0, turn = bar.x + r1*lw_v2_dot(c, lw_v2_perp(u1));
        lw_step_pull(z, 1, c, lw_rrr_back(u1, u2, r1, r2, z->inv, turn, z->out_bar[1].x, &d1, &d2));
        z->dim_bar[0] = d1;
        z->dim_bar[1] = d2;
        break;
    }
    case LW_STEP_RRP: {
        lw_vec2 c = z->out_bar[1];
        double t = lw_v2_dot(lw_v2_sub(out[1], in[1]), in[2]), d = lw_v2_dot(c, out[0]), dw = 0;
        double turn = bar.x + q->dim[0]*lw_v2_dot(c, lw_v2_perp(out[0]));
        lw_step_pull(z, 1, c, lw_rrp_back(out[0], in[2], t, z->inv, turn, &d, &dw));
        z->dim_bar[0] = d;
        z->in_bar[2].x = dw;
        break;
    }
    case LW_STEP_RPR: {
        double d = 0;
        lw_step_pull(z, 1, lw_v2(0, 0), lw_rpr_back(out[0], z->inv, bar.x, &d));
        z->dim_bar[0] = d;
        break;
    }
    case LW_STEP_PRP:
    case LW_STEP_PPR: {
        double t1 = lw_v2_dot(lw_v2_sub(out[0], in[0]), in[1]), t2 = lw_v2_dot(lw_v2_sub(out[0], in[2]), in[3]);
        double d1 = 0, d2 = 0;
        lw_step_pull(z, 2, bar, lw_prp_back(in[1], in[3], t1, t2, z->inv, bar, &d1, &d2));
        z->in_bar[1].x = d1;
        z->in_bar[3].x = d2;
        break;
    }
    case LW_STEP_TURN:
        z->in_bar[0].x = bar.x;
        z->in_bar[1].x = q->power[0]*bar.x;
        break;
    case LW_STEP_SLIDE:
        z->in_bar[0] = bar;
        z->in_bar[1].x = in[2].x*lw_v2_dot(bar, lw_v2_perp(in[1]));
        z->in_bar[2].x = lw_v2_dot(bar, in[1]);
        break;
    case LW_STEP_GEAR:
        z->in_bar[0].x = q->power[0]*bar.x;
        z->in_bar[1].x = q->power[1]*bar.x;
        z->dim_bar[0] = bar.x;
        break;
    case LW_STEP_ALONG:
        z->in_bar[0] = lw_v2_scale(in[1], -bar.x);
        z->in_bar[1].x = bar.x*lw_v2_dot(lw_v2_sub(in[2], in[0]), lw_v2_perp(in[1]));
        z->in_bar[2] = lw_v2_scale(in[1], bar.x);
        break;
    case LW_STEP_ROLL:
        z->in_bar[0].x = bar.x;
        z->in_bar[1].x = bar.x*q->by[0];
        z->dim_bar[0] = -(bar.x*q->by[0]*lw_rolled(in[1].x, q->dim[0], q->dim[1]));
        z->dim_bar[1] = -(bar.x*q->by[0]);
        break;
    case LW_STEP_RACK:
        z->in_bar[0].x = q->dim[0]*bar.x;
        z->in_bar[1].x = -(q->dim[0]*bar.x);
        z->dim_bar[0] = bar.x*lw_rolled(out[0].x, q->dim[0], q->dim[1]);
        z->dim_bar[1] = bar.x;
        z->dim_bar[2] = 0;
        break;
    case LW_STEP_HIGHER:
        break;
    }
}

/* The adjoints of the margin, for dyads and racks. */
LW_INLINE void lw_step_margin_back(const lw_step_kind kind, lw_step_lane *z, const lw_step_numbers *q)
{
    const lw_vec2 *in = z->in;
    switch (kind) {
    case LW_STEP_RRR: {                        /* 1 - cos^2 of the triangle r1, r2, d */
        lw_vec2 span = lw_joint_span(in[0], in[1]);
        double r1 = lw_away_from_zero(q->dim[0]), r2 = lw_away_from_zero(q->dim[1]);
        double cosine = (r1*r1 + r2*r2 - lw_v2_dot(span, span))/(2*r1*r2);
        lw_step_pull(z, 1, lw_v2(0, 0), lw_v2_scale(span, 2*cosine/(r1*r2)));
        z->dim_bar[0] = -2*cosine*(1/r2 - cosine/r1);
        z->dim_bar[1] = -2*cosine*(1/r1 - cosine/r2);
        break;
    }
    case LW_STEP_RRP: {                        /* 1 - (away/r)^2 */
        lw_vec2 off = lw_v2_sub(in[1], in[0]);
        double r = lw_away_from_zero(q->dim[0]), away = lw_v2_cross(in[2], off), by_away = -2*away/(r*r);
        lw_step_pull(z, 1, lw_v2(0, 0), lw_v2_scale(lw_v2_perp(in[2]), by_away));
        z->dim_bar[0] = -by_away*away/r;
        z->in_bar[2].x = -by_away*lw_v2_dot(in[2], off);
        break;
    }
    case LW_STEP_RPR: {                        /* 1 - e^2/d^2 */
        lw_vec2 span = lw_joint_span(in[0], in[1]);
        double e = q->dim[0], d2 = lw_v2_dot(span, span);
        lw_step_pull(z, 1, lw_v2(0, 0), lw_v2_scale(span, 2*e*e/(d2*d2)));
        z->dim_bar[0] = -2*e/d2;
        break;
    }
    case LW_STEP_PRP:
    case LW_STEP_PPR: {                        /* sine^2 */
        double turn = 2*lw_v2_cross(in[1], in[3])*lw_v2_dot(in[1], in[3]);
        z->in_bar[1].x = -turn;
        z->in_bar[3].x = turn;
        break;
    }
    case LW_STEP_RACK: {
        lw_vec2 a = lw_v2_unturn(in[0], in[1]);
        double by_off = -2*lw_off_middle(lw_bearing(a.x, a.y), q->dim[2])/(LW_RACK_REACH*LW_RACK_REACH);
        z->in_bar[0].x = by_off;
        z->in_bar[1].x = -by_off;
        z->dim_bar[2] = -by_off;
        break;
    }
    case LW_STEP_INPUT_PIN: case LW_STEP_INPUT_SLIDE: case LW_STEP_POINT: case LW_STEP_LINE: case LW_STEP_HIGHER:
    case LW_STEP_TURN: case LW_STEP_SLIDE: case LW_STEP_GEAR: case LW_STEP_ALONG: case LW_STEP_ROLL:
        break;                                 /* no margin */
    }
}

/* ---- Taylor series by the input -------------------------------------------------------------------------- */

static inline void lw_series_rrr(const lw_jet2 *in, const lw_step_numbers *q, lw_jet2 *out)
{
    double r1 = q->dim[0], r2 = q->dim[1], sum = r1 + r2, dif = r1 - r2;
    lw_jet2 span = lw_jet2_sub(in[1], in[0]);
    lw_jet d2 = lw_jet2_dot(span, span), p = lw_jet_constant(sum*dif);
    lw_jet y = lw_jet_scale(lw_jet_root(lw_jet_mul(lw_jet_sub(lw_jet_constant(sum*sum), d2),
                                                   lw_jet_sub(d2, lw_jet_constant(dif*dif)))), q->mode);
    lw_jet2 u1 = lw_jet2_turn(span, (lw_jet2){ lw_jet_add(d2, p), y });
    lw_jet2 u2 = lw_jet2_turn(span, (lw_jet2){ lw_jet_sub(p, d2), y });
    out[0] = lw_jet2_scale(u1, lw_jet_divide(lw_jet_constant(0.5/r1), d2));
    out[1] = lw_jet2_scale(u2, lw_jet_divide(lw_jet_constant(0.5/r2), d2));
    out[2] = lw_jet2_point(in[0], out[0], r1, 0);
}

static inline void lw_series_rrp(const lw_jet2 *in, const lw_step_numbers *q, lw_jet2 *out)
{
    lw_jet r = lw_jet_constant(q->dim[0]), away = lw_jet2_cross(in[2], lw_jet2_sub(in[1], in[0]));
    lw_jet y = lw_jet_scale(lw_jet_root(lw_jet_mul(lw_jet_sub(r, away), lw_jet_add(r, away))), q->mode);
    lw_jet2 arm = lw_jet2_turn((lw_jet2){ y, away }, in[2]);
    out[0] = lw_jet2_scale(arm, lw_jet_constant(1/q->dim[0]));
    out[1] = lw_jet2_add(in[0], arm);
}

static inline lw_jet2 lw_series_rpr(const lw_jet2 *in, const lw_step_numbers *q)
{
    double e = q->dim[0];
    lw_jet2 span = lw_jet2_sub(in[1], in[0]);
    lw_jet d2 = lw_jet2_dot(span, span);
    lw_jet y = lw_jet_scale(lw_jet_root(lw_jet_sub(d2, lw_jet_constant(e*e))), q->mode);
    return lw_jet2_scale(lw_jet2_turn(span, lw_jet2_conjugate((lw_jet2){ y, lw_jet_constant(e) })),
                         lw_jet_divide(lw_jet_constant(1), d2));
}

static inline lw_jet2 lw_series_rack(const lw_jet2 *in, const lw_step_numbers *q)
{
    lw_jet2 a = lw_jet2_turn(in[0], lw_jet2_conjugate(in[1]));
    double off = lw_off_middle(lw_bearing(a.x.c[0], a.y.c[0]), q->dim[2]);
    return (lw_jet2){ lw_jet_add(lw_jet_constant(q->dim[1]), lw_jet_scale(lw_jet_angle(&a, q->dim[2] + off),
                                                                      q->dim[0])),
                      lw_jet_constant(0) };
}

static inline lw_jet2 lw_jet2_power(lw_jet2 u, lw_jet2 v, int n)
{
    v = n < 0 ? lw_jet2_conjugate(v) : v;
    for (int i = 0; i < (n < 0 ? -n : n); i++)
        u = lw_jet2_turn(u, v);
    return u;
}

/* As lw_step_value, for steps that close. */
static inline void lw_step_series(lw_step_kind kind, const lw_jet2 *in, const lw_step_numbers *q, lw_jet2 *out)
{
    const lw_jet2 turn = lw_jet2_constant(q->turn.x, q->turn.y);
    switch (kind) {
    case LW_STEP_INPUT_PIN:                    /* u' = i u */
        out[0] = turn;
        for (int m = 1; m < LW_JET; m++) {
            out[0].x.c[m] = -out[0].y.c[m - 1]/m;
            out[0].y.c[m] = out[0].x.c[m - 1]/m;
        }
        break;
    case LW_STEP_INPUT_SLIDE:
        out[0] = lw_jet2_add(in[0], lw_jet2_scale(in[1], (lw_jet){ { q->turn.x, 1 } }));
        break;
    case LW_STEP_POINT:
        out[0] = lw_jet2_point(in[0], in[1], q->dim[0], q->dim[1]);
        break;
    case LW_STEP_LINE:
        out[1] = lw_jet2_turn(turn, in[1]);
        out[0] = lw_jet2_point(in[0], out[1], 0, q->dim[0]);
        break;
    case LW_STEP_RRR: lw_series_rrr(in, q, out); break;
    case LW_STEP_RRP: lw_series_rrp(in, q, out); break;
    case LW_STEP_RPR: out[0] = lw_series_rpr(in, q); break;
    case LW_STEP_PRP:
    case LW_STEP_PPR: {
        lw_jet t = lw_jet_divide(lw_jet2_cross(lw_jet2_sub(in[2], in[0]), in[3]), lw_jet2_cross(in[1], in[3]));
        out[0] = lw_jet2_add(in[0], lw_jet2_scale(in[1], t));
        break;
    }
    case LW_STEP_TURN:
        out[0] = lw_jet2_turn(in[0], q->power[0] < 0 ? lw_jet2_conjugate(in[1]) : in[1]);
        break;
    case LW_STEP_SLIDE:
        out[0] = lw_jet2_add(in[0], lw_jet2_scale(in[1], in[2].x));
        break;
    case LW_STEP_GEAR:
        out[0] = lw_jet2_power(lw_jet2_power(turn, in[0], q->power[0]), in[1], q->power[1]);
        break;
    case LW_STEP_ALONG:
        out[0] = (lw_jet2){ lw_jet2_dot(lw_jet2_sub(in[2], in[0]), in[1]), lw_jet_constant(0) };
        break;
    case LW_STEP_ROLL: {
        lw_jet travel = lw_jet_sub(in[1].x, lw_jet_constant(q->dim[1]));
        out[0] = lw_jet2_turn(in[0], lw_jet_polar(lw_jet_scale(travel, q->by[0])));
        break;
    }
    case LW_STEP_RACK:
        out[0] = lw_series_rack(in, q);
        break;
    case LW_STEP_HIGHER:
        break;
    }
}

/* ---- first derivative by the input: points, lines and dyads --------------------------------------------------
 *
 * The velocities of a dyad are linear in those of the links it is joined to.  For RRR, c = a + r1 u1 = b + r2 u2, x =
 * cross(u1, u2):
 *     r1 x w1 = (b' - a').u2,    r2 x w2 = (b' - a').u1. */

/* A point with its derivative by the input; a direction: u in p, the rate of its angle in d.x. */
typedef struct lw_reg1 { lw_vec2 p, d; } lw_reg1;

/* A step of the plan with its dimensions.  r1 is the offset of RPR; sum2, dif2 = (r1 +- r2)^2. */
typedef struct lw_dyad_step {
    lw_step_kind kind;
    int     in[4], out[4], dyad;
    double  r1, r2, sum2, dif2, product, inv1, inv2, flat;
    lw_vec2 at, line;
} lw_dyad_step;

/* A point of a link, with its derivative; origin -1: on ground. */
static inline lw_reg1 lw_rate_point(const lw_reg1 *reg, int origin, int dir, lw_vec2 arm)
{
    if (origin < 0)
        return (lw_reg1){ arm, { 0, 0 } };
    const lw_reg1 *o = &reg[origin], *u = &reg[dir];
    lw_vec2 r = lw_v2_turn(arm, u->p);
    double w = u->d.x;
    return (lw_reg1){ lw_v2_add(o->p, r), lw_v2(o->d.x - w*r.y, o->d.y + w*r.x) };
}

static inline lw_dyad_step lw_dyad_step_of(const lw_step *from, const double *dim)
{
    lw_dyad_step st = { .kind = from->kind, .dyad = from->dyad };
    double a = from->dim[0] < 0 ? 0 : dim[from->dim[0]], b = from->dim[1] < 0 ? 0 : dim[from->dim[1]];
    for (int i = 0; i < 4; i++) {
        st.in[i] = from->in[i];
        st.out[i] = from->out[i];
    }
    st.r1 = a;
    st.r2 = b;
    st.sum2 = (a + b)*(a + b);
    st.dif2 = (a - b)*(a - b);
    st.product = (a + b)*(a - b);
    st.inv1 = 1/a;
    st.inv2 = 1/b;
    st.flat = 0.25/(a*a*b*b);
    st.at = from->kind == LW_STEP_LINE ? lw_v2(0, a) : lw_v2(a, b);
    st.line = lw_v2_polar(1, b);
    return st;
}

static inline lw_reg1 lw_rate_direction(lw_vec2 u, double w) { return (lw_reg1){ u, { w, 0 } }; }

/* a + r u */
static inline lw_reg1 lw_rate_arm_end(const lw_reg1 *a, const lw_reg1 *u, double r)
{
    double w = r*u->d.x;
    return (lw_reg1){ lw_v2_add(a->p, lw_v2_scale(u->p, r)), lw_v2(a->d.x - w*u->p.y, a->d.y + w*u->p.x) };
}

/* One square root and beside it one division; the places need nothing else.  With (b - a)^2 = d2 and y = mode
 * sqrt(h) as in mbs/plan/dyad_internal.h, r1 r2 cross(u1, u2) = y/2. */
static inline double lw_rates_rrr(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *b = &reg[st->in[1]];
    lw_vec2 span = lw_joint_span(a->p, b->p), e = lw_v2_sub(b->d, a->d);
    double d2 = lw_v2_dot(span, span), h = (st->sum2 - d2)*(d2 - st->dif2);
    double y = mode*sqrt(h > 0 ? h : 0), over_d2 = 0.5/d2, over_y = 2/y;
    lw_vec2 u1 = lw_v2_scale(lw_v2_turn(span, lw_v2(d2 + st->product, y)), over_d2*st->inv1);
    lw_vec2 u2 = lw_v2_scale(lw_v2_turn(span, lw_v2(st->product - d2, y)), over_d2*st->inv2);
    reg[st->out[0]] = lw_rate_direction(u1, st->r2*over_y*lw_v2_dot(e, u2));
    if (st->out[1] >= 0)
        reg[st->out[1]] = lw_rate_direction(u2, st->r1*over_y*lw_v2_dot(e, u1));
    reg[st->out[2]] = lw_rate_arm_end(a, &reg[st->out[0]], st->r1);
    return d2 > 2*LW_TINY2 ? h*st->flat : fmin(h*st->flat, 0);
}

/* With t = (c - q).w the place on the line and n = i w:   r (u.w) w1 = (q' - a').n + t ww. */
static inline double lw_rates_rrp(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *q = &reg[st->in[1]], *w = &reg[st->in[2]];
    lw_rrp z = lw_rrp_solve_along(a->p, q->p, w->p, st->r1, mode);
    lw_vec2 u = lw_rrp_direction(&z), n = lw_v2_perp(w->p);
    double t = lw_v2_dot(lw_v2_sub(lw_v2_add(a->p, z.arm), q->p), w->p);
    double top = lw_v2_dot(lw_v2_sub(q->d, a->d), n) + t*w->d.x;
    reg[st->out[0]] = lw_rate_direction(u, top/(st->r1*lw_v2_dot(u, w->p)));
    reg[st->out[1]] = lw_rate_arm_end(a, &reg[st->out[0]], st->r1);
    return lw_rrp_margin(&z);
}

/* With t = (b - a).u:   t w = (b' - a').n. */
static inline double lw_rates_rpr(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *b = &reg[st->in[1]];
    lw_rpr z = lw_rpr_solve(a->p, b->p, st->r1, mode);
    double t = lw_v2_dot(lw_v2_sub(b->p, a->p), z.u);
    reg[st->out[0]] = lw_rate_direction(z.u, lw_v2_cross(z.u, lw_v2_sub(b->d, a->d))/t);
    return lw_rpr_margin(&z);
}

/* c on both lines:  (c' - q2').n2 = t2 w2,  c = q1 + t1 w1. */
static inline double lw_rates_prp(const lw_dyad_step *st, lw_reg1 *reg)
{
    const lw_reg1 *q1 = &reg[st->in[0]], *w1 = &reg[st->in[1]], *q2 = &reg[st->in[2]], *w2 = &reg[st->in[3]];
    lw_prp z = lw_prp_solve(q1->p, w1->p, q2->p, w2->p);
    lw_vec2 n1 = lw_v2_perp(w1->p), n2 = lw_v2_perp(w2->p);
    double t2 = lw_v2_dot(lw_v2_sub(z.c, q2->p), w2->p), a1 = z.t1*w1->d.x;
    double dt1 = -z.inv*(t2*w2->d.x + lw_v2_dot(lw_v2_sub(q2->d, q1->d), n2) - a1*lw_v2_dot(n1, n2));
    reg[st->out[0]] = (lw_reg1){ z.c, lw_v2_add(q1->d, lw_v2_add(lw_v2_scale(w1->p, dt1), lw_v2_scale(n1, a1))) };
    return lw_prp_margin(&z);
}

static inline double lw_step_rates(const lw_dyad_step *st, const double *mode, double input, lw_reg1 *reg)
{
    double c, s;
    switch (st->kind) {
    case LW_STEP_INPUT_PIN:
        sincos(input, &s, &c);
        reg[st->out[0]] = lw_rate_direction(lw_v2(c, s), 1);
        return 1;
    case LW_STEP_INPUT_SLIDE:
        reg[st->out[0]] = (lw_reg1){ lw_frame_point(reg[st->in[0]].p, reg[st->in[1]].p, input, 0), reg[st->in[1]].p };
        return 1;
    case LW_STEP_POINT:
        reg[st->out[0]] = lw_rate_point(reg, st->in[0], st->in[1], st->at);
        return 1;
    case LW_STEP_LINE:
        reg[st->out[1]] = lw_rate_direction(lw_v2_turn(st->line, reg[st->in[1]].p), reg[st->in[1]].d.x);
        reg[st->out[0]] = lw_rate_point(reg, st->in[0], st->out[1], st->at);
        return 1;
    case LW_STEP_RRR: return lw_rates_rrr(st, mode[st->dyad], reg);
    case LW_STEP_RRP: return lw_rates_rrp(st, mode[st->dyad], reg);
    case LW_STEP_RPR: return lw_rates_rpr(st, mode[st->dyad], reg);
    case LW_STEP_PRP:
    case LW_STEP_PPR: return lw_rates_prp(st, reg);
    case LW_STEP_HIGHER: case LW_STEP_TURN: case LW_STEP_SLIDE: case LW_STEP_GEAR: case LW_STEP_ALONG:
    case LW_STEP_ROLL:
    case LW_STEP_RACK: break;                              /* not in plans of dyads alone */
    }
    return 1;
}

#endif
