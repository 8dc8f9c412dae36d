/* Each kind of step as one loop over a block of lanes, forwards and backwards. */
#include "mbs/batch/kernel_run_internal.h"

/* ---- steps forwards ----------------------------------------------------------------------------------
 * per_lane: do dimensions and modes differ between lanes?  It is a constant wherever these functions are inlined. */

static void input_pin(const run *k, const lw_step *s, size_t n)
{
    memcpy(reg_x(k, s->out[0]), k->c, n*sizeof(double));
    memcpy(reg_y(k, s->out[0]), k->s, n*sizeof(double));
}

static void input_slide(const run *k, const lw_step *s, size_t n)
{
    const in_rows q = in_reg(k, s->in[0]), w = in_reg(k, s->in[1]);
    const out_rows o = out_reg(k, s->out[0]);
    const double *d = k->c;
    LW_LANES(n) put(o, i, lw_frame_point(get(q, i), get(w, i), d[i], 0));
}

LW_INLINE void point(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const in_rows o = in_reg(k, s->in[0]), d = in_reg(k, s->in[1]);
    const out_rows p = out_reg(k, s->out[0]);
    const double *x = dim_of(k, s->dim[0]), *y = dim_of(k, s->dim[1]), x0 = *x, y0 = *y;
    LW_LANES(n) put(p, i, lw_frame_point(get(o, i), get(d, i), per_lane ? x[i] : x0, per_lane ? y[i] : y0));
}

LW_INLINE void line(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const in_rows o = in_reg(k, s->in[0]), d = in_reg(k, s->in[1]);
    const out_rows q = out_reg(k, s->out[0]), w = out_reg(k, s->out[1]);
    const double *e = dim_of(k, s->dim[0]), *c = cos_of(k, s->dim[2]), *t = sin_of(k, s->dim[2]);
    const double e0 = *e, c0 = *c, t0 = *t;
    LW_LANES(n) {
        lw_vec2 along = lw_v2_turn(lw_v2(per_lane ? c[i] : c0, per_lane ? t[i] : t0), get(d, i));
        lw_vec2 at = lw_frame_point(get(o, i), along, 0, per_lane ? e[i] : e0);
        put(w, i, along);
        put(q, i, at);
    }
}

/* Keep the least margin, and the reciprocal that derivatives need (0 where they do not exist). */
LW_INLINE void keep_margin(double *margin, double *aux, double m, double y, const int outputs)
{
    if (outputs >= WITH_MARGIN)
        *margin = lw_at_most(m, *margin);
    if (outputs == WITH_ROOTS)
        *aux = (m > LW_MARGIN_FLAT ? 1.0 : 0.0)/(m > LW_MARGIN_FLAT ? y : 1.0);
}

/* RRR dyads.  turns: bits 1 and 2 tell whether out[0] and out[1] are stored.  met: are all circles assumed to meet?
 * Returns false if that is wrong. */
LW_INLINE bool rrr_lanes(const run *k, const lw_step *s, size_t n, const int per_lane, const int outputs,
                         const int turns, const int met)
{
    const in_rows a = in_reg(k, s->in[0]), b = in_reg(k, s->in[1]);
    const out_rows c = out_reg(k, s->out[2]);
    const out_rows u = turns & 1 ? out_reg(k, s->out[0]) : c, v = turns & 2 ? out_reg(k, s->out[1]) : c;
    const double *r1 = dim_of(k, s->dim[0]), *r2 = dim_of(k, s->dim[1]), *mode = mode_of(k, s->dyad);
    const double r10 = *r1, r20 = *r2, mode0 = *mode, flat0 = lw_rrr_flat(r10, r20);
    const double by_r10 = 1/lw_away_from_zero(r10), by_r20 = 1/lw_away_from_zero(r20);
    double *margin = k->margin, *aux = aux_row(k, s->dyad);
    long long open = 0;
    LW_LANES(n) {
        double p = per_lane ? r1[i] : r10, q = per_lane ? r2[i] : r20;
        lw_vec2 from = get(a, i), to = get(b, i);
        lw_rrr z = lw_rrr_solve_met(from, to, p, q, per_lane ? mode[i] : mode0, met);
        lw_vec2 arm = lw_rrr_arm(&z), tip = lw_v2_add(from, arm);
        open |= z.h >= 0 ? 0 : 1;
        if (outputs)
            keep_margin(&margin[i], &aux[i], lw_rrr_margin(&z, per_lane ? lw_rrr_flat(p, q) : flat0), z.y, outputs);
        if (turns & 1)
            put(u, i, lw_v2_scale(arm, per_lane ? 1/z.r1 : by_r10));
        if (turns & 2)
            put(v, i, lw_v2_scale(lw_rrr_other(&z, lw_v2_sub(tip, to), met), per_lane ? 1/z.r2 : by_r20));
        put(c, i, tip);
    }
    return !(met && open);
}

/* Try first the cheaper loop for circles that all meet.  Both loops give the same bits in lanes whose circles meet. */
LW_INLINE void rrr(const run *k, const lw_step *s, size_t n, const int per_lane, const int outputs, const int turns)
{
    if (!rrr_lanes(k, s, n, per_lane, outputs, turns, 1))
        rrr_lanes(k, s, n, per_lane, outputs, turns, 0);
}

LW_INLINE void rrp(const run *k, const lw_step *s, size_t n, const int per_lane, const int outputs)
{
    const in_rows a = in_reg(k, s->in[0]), q = in_reg(k, s->in[1]), w = in_reg(k, s->in[2]);
    const out_rows u = out_reg(k, s->out[0]), c = out_reg(k, s->out[1]);
    const double *r = dim_of(k, s->dim[0]), *mode = mode_of(k, s->dyad), r0 = *r, mode0 = *mode;
    double *margin = k->margin, *aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        lw_vec2 from = get(a, i);
        lw_rrp z = lw_rrp_solve_along(from, get(q, i), get(w, i), per_lane ? r[i] : r0, per_lane ? mode[i] : mode0);
        if (outputs)
            keep_margin(&margin[i], &aux[i], lw_rrp_margin(&z), z.y, outputs);
        put(u, i, lw_rrp_direction(&z));
        put(c, i, lw_v2_add(from, z.arm));
    }
}

LW_INLINE void rpr(const run *k, const lw_step *s, size_t n, const int per_lane, const int outputs)
{
    const in_rows a = in_reg(k, s->in[0]), b = in_reg(k, s->in[1]);
    const out_rows u = out_reg(k, s->out[0]);
    const double *e = dim_of(k, s->dim[0]), *mode = mode_of(k, s->dyad), e0 = *e, mode0 = *mode;
    double *margin = k->margin, *aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        lw_rpr z = lw_rpr_solve(get(a, i), get(b, i), per_lane ? e[i] : e0, per_lane ? mode[i] : mode0);
        if (outputs)
            keep_margin(&margin[i], &aux[i], lw_rpr_margin(&z), z.y, outputs);
        put(u, i, z.u);
    }
}

LW_INLINE void prp(const run *k, const lw_step *s, size_t n, const int outputs)
{
    const in_rows p = in_reg(k, s->in[0]), u = in_reg(k, s->in[1]), q = in_reg(k, s->in[2]), w = in_reg(k, s->in[3]);
    const out_rows c = out_reg(k, s->out[0]);
    double *margin = k->margin, *aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        lw_prp z = lw_prp_solve(get(p, i), get(u, i), get(q, i), get(w, i));
        if (outputs)
            keep_margin(&margin[i], &aux[i], lw_prp_margin(&z), z.sine, outputs);
        put(c, i, z.c);
    }
}

static void turn_step(const run *k, const lw_step *s, size_t n)
{
    const in_rows u = in_reg(k, s->in[0]), v = in_reg(k, s->in[1]);
    const out_rows o = out_reg(k, s->out[0]);
    const double sign = s->dim[0];
    LW_LANES(n) put(o, i, lw_v2_turn(get(u, i), lw_v2(v.x[i], sign*v.y[i])));
}

static void slide_step(const run *k, const lw_step *s, size_t n)
{
    const in_rows q = in_reg(k, s->in[0]), w = in_reg(k, s->in[1]), d = in_reg(k, s->in[2]);
    const out_rows o = out_reg(k, s->out[0]);
    LW_LANES(n) put(o, i, lw_frame_point(get(q, i), get(w, i), d.x[i], 0));
}

static void times(const out_rows o, in_rows u, double sign, size_t n)
{
    LW_LANES(n) {
        lw_vec2 a = lw_v2(o.x[i], o.y[i]), b = get(u, i);
        put(o, i, lw_v2_turn(a, lw_v2(b.x, sign*b.y)));
    }
}

/* e^{i phase} u^m v^n by repeated products; m and n are small. */
LW_INLINE void gear(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const out_rows o = out_reg(k, s->out[0]);
    const double *c = s->dim[0] < 0 ? reg_x(k, 1) : cos_of(k, s->dim[2]);
    const double *t = s->dim[0] < 0 ? reg_y(k, 1) : sin_of(k, s->dim[2]);
    const double c0 = *c, t0 = *t;
    LW_LANES(n) put(o, i, lw_v2(per_lane && s->dim[0] >= 0 ? c[i] : c0, per_lane && s->dim[0] >= 0 ? t[i] : t0));
    for (int h = 0; h < 2 && s->in[h] >= 0; h++)
        for (int m = 0; m < (s->power[h] < 0 ? -s->power[h] : s->power[h]); m++)
            times(o, in_reg(k, s->in[h]), s->power[h] < 0 ? -1 : 1, n);
}

static void along(const run *k, const lw_step *s, size_t n)
{
    const in_rows q = in_reg(k, s->in[0]), w = in_reg(k, s->in[1]), p = in_reg(k, s->in[2]);
    const out_rows o = out_reg(k, s->out[0]);
    LW_LANES(n) put(o, i, lw_v2(lw_v2_dot(lw_v2_sub(get(p, i), get(q, i)), get(w, i)), 0));
}

LW_INLINE void roll(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const in_rows u = in_reg(k, s->in[0]), d = in_reg(k, s->in[1]);
    const out_rows o = out_reg(k, s->out[0]);
    const double *rho = dim_of(k, s->dim[0]), *shift = dim_of(k, s->dim[1]), rho0 = *rho, shift0 = *shift;
    LW_LANES(n) put(o, i, lw_v2_turn(get(u, i), lw_sincos(lw_rolled(d.x[i], per_lane ? rho[i] : rho0,
                                                                    per_lane ? shift[i] : shift0))));
}

LW_INLINE void rack(const run *k, const lw_step *s, size_t n, const int per_lane, const int outputs)
{
    const in_rows v = in_reg(k, s->in[0]), u = in_reg(k, s->in[1]);
    const out_rows o = out_reg(k, s->out[0]);
    const double *rho = dim_of(k, s->dim[0]), *shift = dim_of(k, s->dim[1]), *middle = dim_of(k, s->dim[2]);
    const double rho0 = *rho, shift0 = *shift, middle0 = *middle;
    double *margin = k->margin;
    LW_LANES(n) {
        lw_vec2 a = lw_v2_unturn(get(v, i), get(u, i));
        double m = per_lane ? middle[i] : middle0, by = lw_off_middle(lw_bearing(a.x, a.y), m);
        if (outputs)
            margin[i] = lw_at_most(lw_rack_margin(by), margin[i]);
        put(o, i, lw_v2((per_lane ? shift[i] : shift0) + (per_lane ? rho[i] : rho0)*(m + by), 0));
    }
}

/* One copy of each loop for each combination of per_lane and outputs. */
LW_INLINE void step_forward(const run *k, const lw_step *s, int keep, size_t n, const int per_lane, const int outputs)
{
    switch (s->kind) {
    case LW_STEP_INPUT_PIN:   input_pin(k, s, n); break;
    case LW_STEP_INPUT_SLIDE: input_slide(k, s, n); break;
    case LW_STEP_POINT:       point(k, s, n, per_lane); break;
    case LW_STEP_LINE:        line(k, s, n, per_lane); break;
    case LW_STEP_RRR:
        if (outputs == WITH_ROOTS)
            keep |= 1;
        switch (s->out[1] < 0 ? keep & 1 : keep & 3) {
        case 0:  rrr(k, s, n, per_lane, outputs, 0); break;
        case 1:  rrr(k, s, n, per_lane, outputs, 1); break;
        case 2:  rrr(k, s, n, per_lane, outputs, 2); break;
        default: rrr(k, s, n, per_lane, outputs, 3);
        }
        break;
    case LW_STEP_RRP:         rrp(k, s, n, per_lane, outputs); break;
    case LW_STEP_RPR:         rpr(k, s, n, per_lane, outputs); break;
    case LW_STEP_PRP:
    case LW_STEP_PPR:         prp(k, s, n, outputs); break;
    case LW_STEP_HIGHER:      break;                       /* see lw_forward */
    case LW_STEP_TURN:        turn_step(k, s, n); break;
    case LW_STEP_SLIDE:       slide_step(k, s, n); break;
    case LW_STEP_GEAR:        gear(k, s, n, per_lane); break;
    case LW_STEP_ALONG:       along(k, s, n); break;
    case LW_STEP_ROLL:        roll(k, s, n, per_lane); break;
    case LW_STEP_RACK:        rack(k, s, n, per_lane, outputs); break;
    }
}

#define FORWARD(name, per_lane, outputs)                                      \
    static void name(const run *k, const lw_step *s, int keep, size_t n)   \
    {                                                                      \
        step_forward(k, s, keep, n, per_lane, outputs);                       \
    }
FORWARD(forward_shared_posture, 0, POSTURE_ONLY)
FORWARD(forward_shared_margin, 0, WITH_MARGIN)
FORWARD(forward_shared_roots, 0, WITH_ROOTS)
FORWARD(forward_lanes_posture, 1, POSTURE_ONLY)
FORWARD(forward_lanes_margin, 1, WITH_MARGIN)

void lw_forward_step(const run *k, const lw_step *s, size_t n) { forward_shared_margin(k, s, ~0, n); }

void lw_forward(const run *k, int which, size_t n, int per_lane, int outputs)
{
    static void (*const step[2][3])(const run *, const lw_step *, int, size_t) = {
        { forward_shared_posture, forward_shared_margin, forward_shared_roots },
        { forward_lanes_posture, forward_lanes_margin, NULL }
    };
    const lw_plan *p = k->plan;
    double *margin = k->margin;
    for (size_t i = 0; outputs && i < n; i++)
        margin[i] = 1;
    for (int i = 0; i < n_step_of(p, which); i++) {
        const lw_step *s = step_of(p, which, i);
        if (s->kind == LW_STEP_HIGHER)
            lw_higher_forward(k, s, n, per_lane, outputs);
        else
            step[per_lane][outputs](k, s, keep_of(p, which, i), n);
    }
}

/* ---- steps backwards: see mbs/plan/dyad_internal.h --------------------------------------------------
 * Several inputs of a step may be one register, so that its adjoint is read again after it is written. */

static void back_input_pin(const run *k, const lw_step *s, size_t n, double *input_bar)
{
    const double *u = bar_x(k, s->out[0]);
    LW_LANES(n) input_bar[i] += u[i];
}

static void back_input_slide(const run *k, const lw_step *s, size_t n, double *input_bar)
{
    const in_rows w = in_reg(k, s->in[1]), o_bar = in_bar(k, s->out[0]);
    const out_rows q_bar = out_bar(k, s->in[0]);
    const double *d = k->c;
    double *w_bar = bar_x(k, s->in[1]);
    LW_LANES(n) {
        lw_vec2 o = get(o_bar, i), u = get(w, i);
        input_bar[i] += lw_v2_dot(o, u);
        w_bar[i] += d[i]*lw_v2_dot(o, lw_v2_perp(u));
        add_to(q_bar, i, o);
    }
}

static void back_point(const run *k, const lw_step *s, size_t n)
{
    const in_rows d = in_reg(k, s->in[1]), p_bar = in_bar(k, s->out[0]);
    const out_rows o_bar = out_bar(k, s->in[0]);
    const double x = *dim_of(k, s->dim[0]), y = *dim_of(k, s->dim[1]);
    double *d_bar = bar_x(k, s->in[1]), *x_bar = dim_bar(k, s->dim[0]), *y_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        lw_vec2 p = get(p_bar, i), u = get(d, i);
        double along = lw_v2_dot(p, u), across = lw_v2_dot(p, lw_v2_perp(u));
        x_bar[i] += along;
        y_bar[i] += across;
        d_bar[i] += x*across - y*along;
        add_to(o_bar, i, p);
    }
}

static void back_line(const run *k, const lw_step *s, size_t n)
{
    const in_rows w = in_reg(k, s->out[1]), q_bar = in_bar(k, s->out[0]);
    const out_rows o_bar = out_bar(k, s->in[0]);
    const double e = *dim_of(k, s->dim[0]), *w_bar = bar_x(k, s->out[1]);
    double *d_bar = bar_x(k, s->in[1]), *e_bar = dim_bar(k, s->dim[0]), *beta_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        lw_vec2 q = get(q_bar, i), u = get(w, i);
        double turn = w_bar[i] - e*lw_v2_dot(q, u);
        e_bar[i] += lw_v2_dot(q, lw_v2_perp(u));
        beta_bar[i] += turn;
        d_bar[i] += turn;
        add_to(o_bar, i, q);
    }
}

/* Add `pull` to the adjoint of b, and the adjoint of the tip minus `pull` to that of a. */
LW_INLINE void share_pull(out_rows a_bar, out_rows b_bar, size_t i, lw_vec2 tip, lw_vec2 pull)
{
    add_to(a_bar, i, lw_v2_sub(tip, pull));
    add_to(b_bar, i, pull);
}

static void back_rrr(const run *k, const lw_step *s, size_t n)
{
    const in_rows a = in_reg(k, s->in[0]), b = in_reg(k, s->in[1]), u = in_reg(k, s->out[0]),
        c_bar = in_bar(k, s->out[2]);
    const out_rows a_bar = out_bar(k, s->in[0]), b_bar = out_bar(k, s->in[1]);
    const double r1 = *dim_of(k, s->dim[0]), r2 = *dim_of(k, s->dim[1]), by_r2 = 1/lw_away_from_zero(r2);
    const double *inv = aux_row(k, s->dyad), *u_bar = bar_x(k, s->out[0]);
    const double *v_bar = s->out[1] < 0 ? reg_x(k, 0) : bar_x(k, s->out[1]);
    double *r1_bar = dim_bar(k, s->dim[0]), *r2_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        lw_vec2 u1 = get(u, i), c = get(c_bar, i), tip = lw_frame_point(get(a, i), u1, r1, 0);
        lw_vec2 u2 = lw_v2_scale(lw_v2_sub(tip, get(b, i)), by_r2);
        double d1 = lw_v2_dot(c, u1), d2 = 0, turn = u_bar[i] + r1*lw_v2_dot(c, lw_v2_perp(u1));
        lw_vec2 pull = lw_rrr_back(u1, u2, r1, r2, inv[i], turn, v_bar[i], &d1, &d2);
        r1_bar[i] += d1;
        r2_bar[i] += d2;
        share_pull(a_bar, b_bar, i, c, pull);
    }
}

static void back_rrp(const run *k, const lw_step *s, size_t n)
{
    const in_rows q = in_reg(k, s->in[1]), w = in_reg(k, s->in[2]), u = in_reg(k, s->out[0]), c = in_reg(k, s->out[1]);
    const in_rows c_bar = in_bar(k, s->out[1]);
    const out_rows a_bar = out_bar(k, s->in[0]), q_bar = out_bar(k, s->in[1]);
    const double r = *dim_of(k, s->dim[0]), *inv = aux_row(k, s->dyad), *u_bar = bar_x(k, s->out[0]);
    double *w_bar = bar_x(k, s->in[2]), *r_bar = dim_bar(k, s->dim[0]);
    LW_LANES(n) {
        lw_vec2 u1 = get(u, i), w1 = get(w, i), bar = get(c_bar, i);
        double t = lw_v2_dot(lw_v2_sub(get(c, i), get(q, i)), w1);
        double d = lw_v2_dot(bar, u1), dw = 0, turn = u_bar[i] + r*lw_v2_dot(bar, lw_v2_perp(u1));
        lw_vec2 pull = lw_rrp_back(u1, w1, t, inv[i], turn, &d, &dw);
        r_bar[i] += d;
        w_bar[i] += dw;
        share_pull(a_bar, q_bar, i, bar, pull);
    }
}

static void back_rpr(const run *k, const lw_step *s, size_t n)
{
    const in_rows u = in_reg(k, s->out[0]);
    const out_rows a_bar = out_bar(k, s->in[0]), b_bar = out_bar(k, s->in[1]);
    const double *u_bar = bar_x(k, s->out[0]), *inv = aux_row(k, s->dyad);
    double *e_bar = dim_bar(k, s->dim[0]);
    LW_LANES(n) {
        double d = 0;
        lw_vec2 pull = lw_rpr_back(get(u, i), inv[i], u_bar[i], &d);
        e_bar[i] += d;
        share_pull(a_bar, b_bar, i, lw_v2(0, 0), pull);
    }
}

static void back_prp(const run *k, const lw_step *s, size_t n)
{
    const in_rows p = in_reg(k, s->in[0]), u = in_reg(k, s->in[1]), q = in_reg(k, s->in[2]), w = in_reg(k, s->in[3]);
    const in_rows c = in_reg(k, s->out[0]), c_bar = in_bar(k, s->out[0]);
    const out_rows p_bar = out_bar(k, s->in[0]), q_bar = out_bar(k, s->in[2]);
    const double *inv = aux_row(k, s->dyad);
    double *u_bar = bar_x(k, s->in[1]), *w_bar = bar_x(k, s->in[3]);
    LW_LANES(n) {
        lw_vec2 tip = get(c, i), u1 = get(u, i), u2 = get(w, i), bar = get(c_bar, i);
        double t1 = lw_v2_dot(lw_v2_sub(tip, get(p, i)), u1), t2 = lw_v2_dot(lw_v2_sub(tip, get(q, i)), u2);
        double d1 = 0, d2 = 0;
        lw_vec2 pull = lw_prp_back(u1, u2, t1, t2, inv[i], bar, &d1, &d2);
        u_bar[i] += d1;
        w_bar[i] += d2;
        share_pull(p_bar, q_bar, i, bar, pull);
    }
}

static void back_turn(const run *k, const lw_step *s, size_t n)
{
    const double *o = bar_x(k, s->out[0]), sign = s->dim[0];
    double *u = bar_x(k, s->in[0]), *v = bar_x(k, s->in[1]);
    LW_LANES(n) {
        u[i] += o[i];
        v[i] += sign*o[i];
    }
}

static void back_slide(const run *k, const lw_step *s, size_t n)
{
    const in_rows w = in_reg(k, s->in[1]), d = in_reg(k, s->in[2]), o_bar = in_bar(k, s->out[0]);
    const out_rows q_bar = out_bar(k, s->in[0]);
    double *w_bar = bar_x(k, s->in[1]), *d_bar = bar_x(k, s->in[2]);
    LW_LANES(n) {
        lw_vec2 o = get(o_bar, i), u = get(w, i);
        d_bar[i] += lw_v2_dot(o, u);
        w_bar[i] += d.x[i]*lw_v2_dot(o, lw_v2_perp(u));
        add_to(q_bar, i, o);
    }
}

static void back_gear(const run *k, const lw_step *s, size_t n)
{
    const double *o = bar_x(k, s->out[0]);
    for (int h = 0; h < 2 && s->in[h] >= 0; h++) {
        double *u = bar_x(k, s->in[h]);
        const double power = s->power[h];
        LW_LANES(n) u[i] += power*o[i];
    }
    if (s->dim[0] >= 0) {
        double *phase_bar = dim_bar(k, s->dim[0]);
        LW_LANES(n) phase_bar[i] += o[i];
    }
}

static void back_along(const run *k, const lw_step *s, size_t n)
{
    const in_rows q = in_reg(k, s->in[0]), w = in_reg(k, s->in[1]), p = in_reg(k, s->in[2]);
    const out_rows q_bar = out_bar(k, s->in[0]), p_bar = out_bar(k, s->in[2]);
    const double *d_bar = bar_x(k, s->out[0]);
    double *w_bar = bar_x(k, s->in[1]);
    LW_LANES(n) {
        lw_vec2 u = get(w, i), offset = lw_v2_sub(get(p, i), get(q, i));
        add_to(p_bar, i, lw_v2_scale(u, d_bar[i]));
        add_to(q_bar, i, lw_v2_scale(u, -d_bar[i]));
        w_bar[i] += d_bar[i]*lw_v2_dot(offset, lw_v2_perp(u));
    }
}

static void back_roll(const run *k, const lw_step *s, size_t n)
{
    const double *o = bar_x(k, s->out[0]), *d = reg_x(k, s->in[1]);
    const double rho = *dim_of(k, s->dim[0]), shift = *dim_of(k, s->dim[1]), by_rho = 1/lw_away_from_zero(rho);
    double *u_bar = bar_x(k, s->in[0]), *d_bar = bar_x(k, s->in[1]);
    double *rho_bar = dim_bar(k, s->dim[0]), *shift_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        u_bar[i] += o[i];
        d_bar[i] += o[i]*by_rho;
        shift_bar[i] -= o[i]*by_rho;
        rho_bar[i] -= o[i]*by_rho*lw_rolled(d[i], rho, shift);
    }
}

/* The middle of a rack has no derivative: it only selects a turn. */
static void back_rack(const run *k, const lw_step *s, size_t n)
{
    const double *d_bar = bar_x(k, s->out[0]), *d = reg_x(k, s->out[0]);
    const double rho = *dim_of(k, s->dim[0]), shift = *dim_of(k, s->dim[1]);
    double *v_bar = bar_x(k, s->in[0]), *u_bar = bar_x(k, s->in[1]);
    double *rho_bar = dim_bar(k, s->dim[0]), *shift_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        v_bar[i] += rho*d_bar[i];
        u_bar[i] -= rho*d_bar[i];
        shift_bar[i] += d_bar[i];
        rho_bar[i] += d_bar[i]*lw_rolled(d[i], rho, shift);
    }
}

void lw_backward(const run *k, int which, size_t n, double *input_bar)
{
    const lw_plan *p = k->plan;
    for (int i = n_step_of(p, which) - 1; i >= 0; i--) {
        const lw_step *s = step_of(p, which, i);
        switch (s->kind) {
        case LW_STEP_INPUT_PIN:   back_input_pin(k, s, n, input_bar); break;
        case LW_STEP_INPUT_SLIDE: back_input_slide(k, s, n, input_bar); break;
        case LW_STEP_POINT:       back_point(k, s, n); break;
        case LW_STEP_LINE:        back_line(k, s, n); break;
        case LW_STEP_RRR:         back_rrr(k, s, n); break;
        case LW_STEP_RRP:         back_rrp(k, s, n); break;
        case LW_STEP_RPR:         back_rpr(k, s, n); break;
        case LW_STEP_PRP:
        case LW_STEP_PPR:         back_prp(k, s, n); break;
        case LW_STEP_HIGHER:      lw_higher_backward(k, s, n); break;
        case LW_STEP_TURN:        back_turn(k, s, n); break;
        case LW_STEP_SLIDE:       back_slide(k, s, n); break;
        case LW_STEP_GEAR:        back_gear(k, s, n); break;
        case LW_STEP_ALONG:       back_along(k, s, n); break;
        case LW_STEP_ROLL:        back_roll(k, s, n); break;
        case LW_STEP_RACK:        back_rack(k, s, n); break;
        }
    }
}

/* ---- the margin and its adjoints ------------------------------------------------------------------------ */

/* Margin of step s in lane i.  With `seed` also add its adjoints.  Steps without a margin and higher groups: 1. */
static double step_margin(const run *k, const lw_step *s, size_t i, bool seed)
{
    switch (s->kind) {
    case LW_STEP_RRR: {
        double r1 = *dim_of(k, s->dim[0]), r2 = *dim_of(k, s->dim[1]);
        lw_rrr z = lw_rrr_solve(get(in_reg(k, s->in[0]), i), get(in_reg(k, s->in[1]), i), r1, r2, 1);
        if (seed) {                                        /* 1 - cos^2 of the triangle r1, r2, d       */
            double cosine = (z.r1*z.r1 + z.r2*z.r2 - z.d2)/(2*z.r1*z.r2);
            lw_vec2 pull = lw_v2_scale(z.span, 2*cosine/(z.r1*z.r2));
            dim_bar(k, s->dim[0])[i] -= 2*cosine*(1/z.r2 - cosine/z.r1);
            dim_bar(k, s->dim[1])[i] -= 2*cosine*(1/z.r1 - cosine/z.r2);
            add_to(out_bar(k, s->in[0]), i, lw_v2_scale(pull, -1));
            add_to(out_bar(k, s->in[1]), i, pull);
        }
        return lw_rrr_margin(&z, lw_rrr_flat(r1, r2));
    }
    case LW_STEP_RRP: {
        lw_vec2 w = get(in_reg(k, s->in[2]), i);
        lw_vec2 off = lw_v2_sub(get(in_reg(k, s->in[1]), i), get(in_reg(k, s->in[0]), i));
        lw_rrp z = lw_rrp_solve(lw_v2_cross(w, off), *dim_of(k, s->dim[0]), 1);
        if (seed) {                                        /* 1 - (away/r)^2                            */
            double away = lw_v2_cross(w, off), by_away = -2*away/(z.r*z.r);
            lw_vec2 pull = lw_v2_scale(lw_v2_perp(w), by_away);
            dim_bar(k, s->dim[0])[i] -= by_away*away/z.r;
            bar_x(k, s->in[2])[i] -= by_away*lw_v2_dot(w, off);
            add_to(out_bar(k, s->in[0]), i, lw_v2_scale(pull, -1));
            add_to(out_bar(k, s->in[1]), i, pull);
        }
        return lw_rrp_margin(&z);
    }
    case LW_STEP_RPR: {
        double e = *dim_of(k, s->dim[0]);
        lw_vec2 a = get(in_reg(k, s->in[0]), i), b = get(in_reg(k, s->in[1]), i);
        lw_rpr z = lw_rpr_solve(a, b, e, 1);
        if (seed) {                                        /* 1 - e^2/d^2                               */
            lw_vec2 pull = lw_v2_scale(lw_joint_span(a, b), 2*e*e/(z.d2*z.d2));
            dim_bar(k, s->dim[0])[i] -= 2*e/z.d2;
            add_to(out_bar(k, s->in[0]), i, lw_v2_scale(pull, -1));
            add_to(out_bar(k, s->in[1]), i, pull);
        }
        return lw_rpr_margin(&z);
    }
    case LW_STEP_PRP:
    case LW_STEP_PPR: {
        lw_vec2 u = get(in_reg(k, s->in[1]), i), w = get(in_reg(k, s->in[3]), i);
        double sine = lw_v2_cross(u, w), turn = 2*sine*lw_v2_dot(u, w);
        if (seed) {
            bar_x(k, s->in[1])[i] -= turn;
            bar_x(k, s->in[3])[i] += turn;
        }
        return sine*sine;
    }
    case LW_STEP_RACK: {
        double middle = *dim_of(k, s->dim[2]);
        lw_vec2 a = lw_v2_unturn(get(in_reg(k, s->in[0]), i), get(in_reg(k, s->in[1]), i));
        double off = lw_off_middle(lw_bearing(a.x, a.y), middle), by_off = -2*off/(LW_RACK_REACH*LW_RACK_REACH);
        if (seed) {
            bar_x(k, s->in[0])[i] += by_off;
            bar_x(k, s->in[1])[i] -= by_off;
            dim_bar(k, s->dim[2])[i] -= by_off;
        }
        return lw_rack_margin(off);
    }
    case LW_STEP_INPUT_PIN: case LW_STEP_INPUT_SLIDE: case LW_STEP_POINT: case LW_STEP_LINE: case LW_STEP_HIGHER:
    case LW_STEP_TURN: case LW_STEP_SLIDE: case LW_STEP_GEAR: case LW_STEP_ALONG: case LW_STEP_ROLL:
        return 1;
    }
    return 1;
}

/* Margins of dyads are computed twice, by other expressions: this much apart they are the same. */
#define SAME_MARGIN 1e-9

void lw_seed_margin(const run *k, int which, size_t n, bool *known)
{
    const lw_plan *p = k->plan;
    for (size_t i = 0; i < n; i++) {
        int best = -1;
        double least = INFINITY;
        for (int j = 0; j < n_step_of(p, which); j++) {
            double m = step_margin(k, step_of(p, which, j), i, false);
            if (m < least) {
                least = m;
                best = j;
            }
        }
        known[i] = p->n_higher == 0 || least <= k->margin[i] + SAME_MARGIN;
        if (best >= 0 && known[i])
            step_margin(k, step_of(p, which, best), i, true);
    }
}
