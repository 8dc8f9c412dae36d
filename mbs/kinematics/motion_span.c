/* mbs/kinematics/motion_span.c - the inputs at which a dyad closes, in closed form, when only the input link moves its
 * outer joints.
 *
 * With a pin input, the squared distance of the outer joints, or the distance of a pin from a line, is a constant minus
 * a multiple of cos v, where v is the input measured from `centre`.  The dyad bounds this distance on one or both
 * sides, so that limits are given by cos v.  By the half-angle formula  tan^2(v/2) = (1 - cos v)/(1 + cos v)  they are
 * quotients of sums of lengths.  With a slider input, v is a displacement and the distance is |w + i v|. */
#include "mbs/kinematics/motion_internal.h"
#include "mbs/plan/sincos_internal.h"
#include "base/sum.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/dyad_internal.h"
#include "mbs/plan/plan_internal.h"

static const double change_tolerance = 1e-14;      /* of the size: nearer counts as a change point */

/* ---- movement of registers ---- */

/* Does a register stand still, move with the input link as one body, or move otherwise? */
typedef enum moves { STILL, DRIVEN, OTHER } moves;

static moves both(moves a, moves b) { return a > b ? a : b; }

/* The movement of a point in the frame (o, d).  If o stands still and d moves with the input link, the point moves with
 * that link only when o is its pivot. */
static moves carried(const lw_plan *plan, const lw_step *s, const moves *reg)
{
    moves o = reg[s->in[0]], d = reg[s->in[1]];
    bool at_origin = s->kind == LW_STEP_LINE ? s->dim[0] < 0 : s->dim[0] < 0 && s->dim[1] < 0;
    if (at_origin || o == d || plan->input_is_slider)
        return o;
    return o == STILL && s->in[0] == plan->link_origin[plan->link[1]] ? d : OTHER;
}

static void find_moves(const lw_plan *plan, moves *reg)
{
    for (int r = 0; r < plan->n_reg; r++)
        reg[r] = OTHER;
    reg[LW_ORIGIN_REG] = reg[LW_AXIS_REG] = STILL;
    for (int i = 0; i < plan->n_step; i++) {
        const lw_step *s = &plan->step[i];
        switch (s->kind) {
        case LW_STEP_INPUT_PIN:
        case LW_STEP_INPUT_SLIDE: reg[s->out[0]] = DRIVEN; break;
        case LW_STEP_LINE:        reg[s->out[1]] = reg[s->in[1]];    /* the point follows */
                                  __attribute__((fallthrough));
        case LW_STEP_POINT:       reg[s->out[0]] = carried(plan, s, reg); break;
        default: break;
        }
    }
}

/* The posture at input 0. */
typedef struct scene {
    const lw_plan *plan;
    const lw_step *step;
    moves          reg_moves[LW_REG_MAX];
    lw_vec2        reg[LW_REG_MAX];
    lw_vec2        pivot;             /* pivot of a pin input                                    */
    lw_vec2        along;             /* direction of a slider input                             */
} scene;

static void set_scene(scene *c, const lw_plan *plan, const double *dim, const lw_step *step)
{
    static const double any_mode[LW_MODE_MAX];
    c->plan = plan;
    c->step = step;
    find_moves(plan, c->reg_moves);
    lw_posture_registers(plan, dim, any_mode, 0.0, c->reg);
    c->pivot = c->reg[plan->link_origin[plan->link[1]]];
    c->along = lw_v2(0.0, 0.0);
    for (int i = 0; i < plan->n_step; i++)
        if (plan->step[i].kind == LW_STEP_INPUT_SLIDE)
            c->along = c->reg[plan->step[i].in[1]];
}

static double angle(lw_vec2 a) { return atan2(a.y, a.x); }

/* ---- rings ---- */

static double half_angle(double n1, double n2, double d1, double d2)
{
    return 2.0*atan2(sqrt(fabs(n1))*sqrt(fabs(n2)), sqrt(fabs(d1))*sqrt(fabs(d2)));
}

static int sign(double x, double equal) { return x > equal ? 1 : x < -equal ? -1 : 0; }

/* RPR: the distance d,  d^2 = p^2 + q^2 - 2 p q cos v,  is at least `least`. */
static lw_motion_span ring_of_offset(double centre, double p, double q, double least)
{
    lw_motion_span s = { .kind = p + q <= least ? LW_SPAN_NEVER : LW_SPAN_RING, .centre = centre };
    int near = sign(least - fabs(p - q), change_tolerance*(p + q + least));
    s.has_in = near > 0;
    s.touch_in = near == 0;
    if (s.has_in)
        s.in = half_angle(least - p + q, least + p - q, p + q - least, p + q + least);
    return s;
}

/* RRR: the same distance is between |r1 - r2| and r1 + r2; limits by sums of the four lengths. */
static lw_motion_span ring_of_links(double centre, double p, double q, double r1, double r2)
{
    lw_motion_span s = { .kind = LW_SPAN_RING, .centre = centre };
    double all = p + q + r1 + r2, equal = change_tolerance*all;
    double pq = lw_sum4(p, q, -r1, -r2), pr = lw_sum4(p, -q, r1, -r2), ps = lw_sum4(p, -q, -r1, r2);
    double less_p = lw_sum4(-p, q, r1, r2), less_q = lw_sum4(p, -q, r1, r2);
    double less_1 = lw_sum4(p, q, -r1, r2), less_2 = lw_sum4(p, q, r1, -r2);
    if (fmin(fmin(less_p, less_q), fmin(less_1, less_2)) <= 0.0)
        s.kind = LW_SPAN_NEVER;
    s.has_out = sign(pq, equal) > 0;
    s.touch_out = sign(pq, equal) == 0;
    s.has_in = sign(pr, equal)*sign(ps, equal) < 0;
    s.touch_in = sign(pr, equal) == 0 || sign(ps, equal) == 0;
    if (s.has_out)
        s.out = half_angle(less_p, less_q, pq, all);
    if (s.has_in)
        s.in = half_angle(pr, ps, less_1, less_2);
    return s;
}

/* RRP: the distance  e - p cos v  is between -r and r. */
static lw_motion_span ring_of_line(double centre, double e, double p, double r)
{
    lw_motion_span s = { .kind = LW_SPAN_RING, .centre = centre };
    double equal = change_tolerance*(fabs(e) + p + r);
    double near = lw_sum4(p, -e, -r, 0.0), far = lw_sum4(p, e, -r, 0.0);
    if (lw_sum4(p, e, r, 0.0) < 0.0 || lw_sum4(p, -e, r, 0.0) < 0.0)
        s.kind = LW_SPAN_NEVER;
    s.has_in = sign(near, equal) > 0;
    s.touch_in = sign(near, equal) == 0;
    s.has_out = sign(far, equal) > 0;
    s.touch_out = sign(far, equal) == 0;
    if (s.has_in)
        s.in = half_angle(near, 1.0, lw_sum4(p, e, r, 0.0), 1.0);
    if (s.has_out)
        s.out = half_angle(lw_sum4(p, -e, r, 0.0), 1.0, far, 1.0);
    return s;
}

/* The distance |w + i v| is between least (negative: no bound) and most; v is a displacement. */
static lw_motion_span ring_of_slide(double centre, double w, double least, double most)
{
    lw_motion_span s = { .kind = w >= most ? LW_SPAN_NEVER : LW_SPAN_RING, .centre = centre };
    s.has_out = !isinf(most);
    s.out = s.has_out ? sqrt((most - w)*(most + w)) : 0.0;
    int near = least < 0.0 ? -1 : sign(least - w, change_tolerance*(least + w));
    s.has_in = near > 0;
    s.touch_in = near == 0;
    s.in = s.has_in ? sqrt((least - w)*(least + w)) : 0.0;
    return s;
}

static lw_motion_span constant(bool closes)
{
    return (lw_motion_span){ .kind = closes ? LW_SPAN_ALL : LW_SPAN_NEVER };
}

/* ---- dyads ---- */

/* RRR and RPR: the dyad bounds the distance of pins a and b. */
static lw_motion_span span_of_pins(const scene *c, const double *dim)
{
    const lw_step *s = c->step;
    bool rrr = s->kind == LW_STEP_RRR;
    double r1 = fabs(dim[s->dim[0]]), r2 = rrr ? fabs(dim[s->dim[1]]) : 0.0;
    double least = rrr ? fabs(r1 - r2) : r1, most = rrr ? r1 + r2 : INFINITY;
    moves ma = c->reg_moves[s->in[0]], mb = c->reg_moves[s->in[1]];
    lw_vec2 still = c->reg[s->in[ma == STILL ? 0 : 1]], driven = c->reg[s->in[ma == STILL ? 1 : 0]];
    if (both(ma, mb) == OTHER)
        return (lw_motion_span){ .kind = LW_SPAN_UNKNOWN };
    if (ma == mb) {
        double d = lw_v2_norm(lw_v2_sub(driven, still));
        return constant(d >= least && d <= most);
    }
    if (c->plan->input_is_slider) {
        lw_vec2 gap = lw_v2_sub(driven, still);
        return ring_of_slide(-lw_v2_dot(gap, c->along), fabs(lw_v2_cross(c->along, gap)), least, most);
    }
    lw_vec2 f = lw_v2_sub(still, c->pivot), g = lw_v2_sub(driven, c->pivot);
    double centre = angle(f) - angle(g), p = lw_v2_norm(f), q = lw_v2_norm(g);
    return rrr ? ring_of_links(centre, p, q, r1, r2) : ring_of_offset(centre, p, q, least);
}

/* RRP: the dyad bounds the distance of pin a from the line (q, w). */
static lw_motion_span span_of_pin_and_line(const scene *c, const double *dim)
{
    const lw_step *s = c->step;
    double r = fabs(dim[s->dim[0]]);
    moves ma = c->reg_moves[s->in[0]], ml = both(c->reg_moves[s->in[1]], c->reg_moves[s->in[2]]);
    if (both(ma, ml) == OTHER)
        return (lw_motion_span){ .kind = LW_SPAN_UNKNOWN };
    lw_vec2 a = c->reg[s->in[0]], q = c->reg[s->in[1]], w = c->reg[s->in[2]];
    double away = lw_v2_cross(w, lw_v2_sub(q, a));
    if (ma == ml)
        return constant(fabs(away) <= r);
    if (c->plan->input_is_slider) {
        double rate = lw_v2_cross(w, c->along)*(ma == DRIVEN ? -1.0 : 1.0);
        if (fabs(rate) < 1e-15)
            return constant(fabs(away) <= r);
        return ring_of_slide(-away/rate, 0.0, -1.0, r/fabs(rate));
    }
    /* the pin moves on a circle about the pivot, or the line turns: measured in the frame of the line */
    lw_vec2 arm = lw_v2_sub(a, c->pivot);
    double foot = lw_v2_cross(w, lw_v2_sub(q, c->pivot)), turn = angle(w) + 0.5*LW_PI - angle(arm);
    return ring_of_line(ma == DRIVEN ? turn : -turn, foot, lw_v2_norm(arm), r);
}

/* PRP and PPR: the slides must not be parallel.  Those of PPR have a constant angle. */
static lw_motion_span span_of_slides(const scene *c)
{
    const lw_step *s = c->step;
    moves m1 = c->reg_moves[s->in[1]], m2 = c->reg_moves[s->in[3]];
    lw_vec2 w1 = c->reg[s->in[1]], w2 = c->reg[s->in[3]];
    if (s->kind == LW_STEP_PPR || (m1 == m2 && m1 != OTHER) || (c->plan->input_is_slider && both(m1, m2) != OTHER))
        return constant(fabs(lw_v2_cross(w1, w2)) > 1e-15);
    if (both(m1, m2) == OTHER)
        return (lw_motion_span){ .kind = LW_SPAN_UNKNOWN };
    return (lw_motion_span){ .kind = LW_SPAN_HALVES,
                      .centre = m1 == DRIVEN ? angle(w2) - angle(w1) : angle(w1) - angle(w2) };
}

lw_motion_span lw_dyad_span(const lw_plan *plan, const double *dim, const lw_step *step)
{
    scene c;
    set_scene(&c, plan, dim, step);
    switch (step->kind) {
    case LW_STEP_RRR:
    case LW_STEP_RPR: return span_of_pins(&c, dim);
    case LW_STEP_RRP: return span_of_pin_and_line(&c, dim);
    case LW_STEP_RACK: return (lw_motion_span){ .kind = LW_SPAN_UNKNOWN };
    default:          return span_of_slides(&c);
    }
}

/* The place where a range of a slider without end is cut (mbs/kinematics/motion.h). */
static double slide_end(const lw_plan *plan, const double *dim)
{
    double sum = 0.0;
    for (int d = 0; d < plan->n_dim; d++)
        if (plan->dim[d].role == LW_ROLE_R || plan->dim[d].role == LW_ROLE_E)
            sum += 10.0*fabs(dim[d]);
    return sum;
}

static lw_range ring_range(const lw_plan *plan, const double *dim, const lw_motion_span *s, double side)
{
    lw_range r = { .limits = s->has_in || s->has_out };
    bool pin = !plan->input_is_slider;
    r.turns = pin && !r.limits;
    double end = pin ? 2.0*LW_PI - s->in : slide_end(plan, dim);
    double out = s->has_out ? s->out : end, in = s->has_in ? s->in : -out;
    bool mirrored = s->has_in && (s->has_out || !pin) && side < 0.0;
    r.limits &= pin || s->has_out;
    r.first = s->centre + (mirrored ? -out : in);
    r.last = s->centre + (mirrored ? -in : out);
    return r;
}

lw_status lw_motion_range(const lw_plan *plan, const double *dim, double side, lw_range *r)
{
    const lw_step *step = NULL;
    for (int i = 0; i < plan->n_step; i++)
        if (plan->step[i].dyad >= 0)
            step = &plan->step[i];
    if (plan->n_dyad != 1 || !step)
        return LW_E_KIND;
    lw_motion_span s = lw_dyad_span(plan, dim, step);
    double end = slide_end(plan, dim);
    switch (s.kind) {
    case LW_SPAN_NEVER:
        return LW_OPEN;
    case LW_SPAN_ALL:
        *r = (lw_range){ .first = plan->input_is_slider ? -end : -LW_PI,
                         .last = plan->input_is_slider ? end : LW_PI, .turns = !plan->input_is_slider };
        return LW_OK;
    case LW_SPAN_RING:
        *r = ring_range(plan, dim, &s, side);
        return LW_OK;
    case LW_SPAN_HALVES:
        *r = (lw_range){ .first = s.centre + (side < 0.0 ? LW_PI : 0.0) };
        r->last = r->first + LW_PI;
        return LW_OK;
    case LW_SPAN_UNKNOWN:
        break;
    }
    return LW_E_KIND;
}

/* ---- one posture ---- */

lw_opening lw_dyad_opening(const double *dim, const lw_step *s, const lw_vec2 *reg)
{
    double r = s->dim[0] < 0 ? 0.0 : dim[s->dim[0]];
    if (s->kind == LW_STEP_RRR) {
        double t = dim[s->dim[1]], d = lw_v2_norm(lw_v2_sub(reg[s->in[1]], reg[s->in[0]]));
        double twice = 2.0*lw_away_from_zero(r*t);
        return (lw_opening){ (d - r + t)*(d + r - t)/twice, (r + t - d)*(r + t + d)/twice };
    }
    if (s->kind == LW_STEP_RACK) {
        lw_vec2 a = lw_v2_unturn(reg[s->in[0]], reg[s->in[1]]);
        double t = lw_off_middle(atan2(a.y, a.x), dim[s->dim[2]])/LW_RACK_REACH;
        return (lw_opening){ 1.0 - t, 1.0 + t };
    }
    double cosine;
    if (s->kind == LW_STEP_RRP) {
        r = lw_away_from_zero(r);
        cosine = lw_v2_cross(reg[s->in[2]], lw_v2_sub(reg[s->in[1]], reg[s->in[0]]))/r;
    } else if (s->kind == LW_STEP_RPR)
        cosine = r/lw_away_from_zero(lw_v2_norm(lw_v2_sub(reg[s->in[1]], reg[s->in[0]])));
    else
        cosine = lw_v2_dot(reg[s->in[1]], reg[s->in[3]]);
    return (lw_opening){ 1.0 - cosine, 1.0 + cosine };
}
