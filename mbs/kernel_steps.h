/* mbs/kernel_steps.h - each step of a plan as one loop over a block, forwards and backwards.  Included by
 * mbs/kernel.c alone. */
#ifndef LW_MBS_KERNEL_STEPS_H
#define LW_MBS_KERNEL_STEPS_H

#include "mbs/kernel_run.h"

/* ---- steps forwards ----------------------------------------------------------------------------------
 * per_lane: dimensions and modes differ from lane to lane; a constant wherever these are inlined. */

static void input_pin(const run *k, const lw_step *s, size_t n)
{
    memcpy(reg_x(k, s->out[0]), k->c, n*sizeof(double));
    memcpy(reg_y(k, s->out[0]), k->s, n*sizeof(double));
}

static void input_slide(const run *k, const lw_step *s, size_t n)
{
    const double *qx = reg_x(k, s->in[0]), *qy = reg_y(k, s->in[0]), *wx = reg_x(k, s->in[1]), *wy = reg_y(k, s->in[1]);
    const double *d = k->c;
    double *restrict ox = reg_x(k, s->out[0]), *restrict oy = reg_y(k, s->out[0]);
    LW_LANES(n) {
        lw_vec2 p = lw_point(lw_v2(qx[i], qy[i]), lw_v2(wx[i], wy[i]), d[i], 0);
        ox[i] = p.x;
        oy[i] = p.y;
    }
}

LW_INLINE void point(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const double *ox = reg_x(k, s->in[0]), *oy = reg_y(k, s->in[0]), *dx = reg_x(k, s->in[1]), *dy = reg_y(k, s->in[1]);
    const double *x = dim_of(k, s->dim[0]), *y = dim_of(k, s->dim[1]), x0 = *x, y0 = *y;
    double *restrict px = reg_x(k, s->out[0]), *restrict py = reg_y(k, s->out[0]);
    LW_LANES(n) {
        lw_vec2 p = lw_point(lw_v2(ox[i], oy[i]), lw_v2(dx[i], dy[i]), per_lane ? x[i] : x0, per_lane ? y[i] : y0);
        px[i] = p.x;
        py[i] = p.y;
    }
}

LW_INLINE void line(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const double *ox = reg_x(k, s->in[0]), *oy = reg_y(k, s->in[0]), *dx = reg_x(k, s->in[1]), *dy = reg_y(k, s->in[1]);
    const double *e = dim_of(k, s->dim[0]), *c = cos_of(k, s->dim[2]), *t = sin_of(k, s->dim[2]);
    const double e0 = *e, c0 = *c, t0 = *t;
    double *restrict qx = reg_x(k, s->out[0]), *restrict qy = reg_y(k, s->out[0]);
    double *restrict wx = reg_x(k, s->out[1]), *restrict wy = reg_y(k, s->out[1]);
    LW_LANES(n) {
        lw_vec2 w = lw_v2_turn(lw_v2(per_lane ? c[i] : c0, per_lane ? t[i] : t0), lw_v2(dx[i], dy[i]));
        lw_vec2 q = lw_point(lw_v2(ox[i], oy[i]), w, 0, per_lane ? e[i] : e0);
        wx[i] = w.x;
        wy[i] = w.y;
        qx[i] = q.x;
        qy[i] = q.y;
    }
}

LW_INLINE void keep_margin(double *margin, double *aux, double m, double y, const int want)
{
    if (want >= WITH_MARGIN)
        *margin = m < *margin ? m : *margin;
    if (want == WITH_ROOTS)
        *aux = (m > LW_MARGIN_FLAT ? 1.0 : 0.0)/(m > LW_MARGIN_FLAT ? y : 1.0);
}

LW_INLINE void rrr(const run *k, const lw_step *s, size_t n, const int per_lane, const int want, const int second)
{
    const double *ax = reg_x(k, s->in[0]), *ay = reg_y(k, s->in[0]), *bx = reg_x(k, s->in[1]), *by = reg_y(k, s->in[1]);
    const double *r1 = dim_of(k, s->dim[0]), *r2 = dim_of(k, s->dim[1]), *mode = mode_of(k, s->dyad);
    const double r10 = *r1, r20 = *r2, mode0 = *mode, flat0 = lw_rrr_flat(r10, r20);
    double *restrict ux = reg_x(k, s->out[0]), *restrict uy = reg_y(k, s->out[0]);
    double *restrict vx = second ? reg_x(k, s->out[1]) : NULL, *restrict vy = second ? reg_y(k, s->out[1]) : NULL;
    double *restrict cx = reg_x(k, s->out[2]), *restrict cy = reg_y(k, s->out[2]);
    double *restrict margin = k->margin, *restrict aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        double p = per_lane ? r1[i] : r10, q = per_lane ? r2[i] : r20;
        lw_vec2 a = lw_v2(ax[i], ay[i]);
        lw_rrr z = lw_rrr_solve(a, lw_v2(bx[i], by[i]), p, q, per_lane ? mode[i] : mode0);
        lw_vec2 u = lw_rrr_first(&z), c = lw_point(a, u, p, 0);
        if (second) {
            lw_vec2 v = lw_rrr_second(&z);
            vx[i] = v.x;
            vy[i] = v.y;
        }
        if (want)
            keep_margin(&margin[i], &aux[i], lw_rrr_margin(&z, per_lane ? lw_rrr_flat(p, q) : flat0), z.y, want);
        ux[i] = u.x;
        uy[i] = u.y;
        cx[i] = c.x;
        cy[i] = c.y;
    }
}

LW_INLINE void rrp(const run *k, const lw_step *s, size_t n, const int per_lane, const int want)
{
    const double *ax = reg_x(k, s->in[0]), *ay = reg_y(k, s->in[0]), *qx = reg_x(k, s->in[1]), *qy = reg_y(k, s->in[1]);
    const double *wx = reg_x(k, s->in[2]), *wy = reg_y(k, s->in[2]);
    const double *r = dim_of(k, s->dim[0]), *mode = mode_of(k, s->dyad), r0 = *r, mode0 = *mode;
    double *restrict ux = reg_x(k, s->out[0]), *restrict uy = reg_y(k, s->out[0]);
    double *restrict cx = reg_x(k, s->out[1]), *restrict cy = reg_y(k, s->out[1]);
    double *restrict margin = k->margin, *restrict aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        lw_vec2 a = lw_v2(ax[i], ay[i]);
        lw_rrp z = lw_rrp_solve_along(a, lw_v2(qx[i], qy[i]), lw_v2(wx[i], wy[i]), per_lane ? r[i] : r0,
                                      per_lane ? mode[i] : mode0);
        lw_vec2 u = lw_rrp_direction(&z), c = lw_v2_add(a, z.arm);
        if (want)
            keep_margin(&margin[i], &aux[i], lw_rrp_margin(&z), z.y, want);
        ux[i] = u.x;
        uy[i] = u.y;
        cx[i] = c.x;
        cy[i] = c.y;
    }
}

LW_INLINE void rpr(const run *k, const lw_step *s, size_t n, const int per_lane, const int want)
{
    const double *ax = reg_x(k, s->in[0]), *ay = reg_y(k, s->in[0]), *bx = reg_x(k, s->in[1]), *by = reg_y(k, s->in[1]);
    const double *e = dim_of(k, s->dim[0]), *mode = mode_of(k, s->dyad), e0 = *e, mode0 = *mode;
    double *restrict ux = reg_x(k, s->out[0]), *restrict uy = reg_y(k, s->out[0]);
    double *restrict margin = k->margin, *restrict aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        lw_rpr z = lw_rpr_solve(lw_v2(ax[i], ay[i]), lw_v2(bx[i], by[i]), per_lane ? e[i] : e0, per_lane ? mode[i] : mode0);
        if (want)
            keep_margin(&margin[i], &aux[i], lw_rpr_margin(&z), z.y, want);
        ux[i] = z.u.x;
        uy[i] = z.u.y;
    }
}

LW_INLINE void prp(const run *k, const lw_step *s, size_t n, const int want)
{
    const double *px = reg_x(k, s->in[0]), *py = reg_y(k, s->in[0]), *ux = reg_x(k, s->in[1]), *uy = reg_y(k, s->in[1]);
    const double *qx = reg_x(k, s->in[2]), *qy = reg_y(k, s->in[2]), *wx = reg_x(k, s->in[3]), *wy = reg_y(k, s->in[3]);
    double *restrict cx = reg_x(k, s->out[0]), *restrict cy = reg_y(k, s->out[0]);
    double *restrict margin = k->margin, *restrict aux = aux_row(k, s->dyad);
    LW_LANES(n) {
        lw_prp z = lw_prp_solve(lw_v2(px[i], py[i]), lw_v2(ux[i], uy[i]), lw_v2(qx[i], qy[i]), lw_v2(wx[i], wy[i]));
        if (want)
            keep_margin(&margin[i], &aux[i], lw_prp_margin(&z), z.sine, want);
        cx[i] = z.c.x;
        cy[i] = z.c.y;
    }
}

/* One copy of each loop for every constant combination: dimensions shared or per lane, and what is kept. */
LW_INLINE void step_forward(const run *k, const lw_step *s, size_t n, const int per_lane, const int want)
{
    switch (s->kind) {
    case LW_STEP_INPUT_PIN:   input_pin(k, s, n); break;
    case LW_STEP_INPUT_SLIDE: input_slide(k, s, n); break;
    case LW_STEP_POINT:       point(k, s, n, per_lane); break;
    case LW_STEP_LINE:        line(k, s, n, per_lane); break;
    case LW_STEP_RRR:
        if (s->out[1] < 0)
            rrr(k, s, n, per_lane, want, 0);
        else
            rrr(k, s, n, per_lane, want, 1);
        break;
    case LW_STEP_RRP:         rrp(k, s, n, per_lane, want); break;
    case LW_STEP_RPR:         rpr(k, s, n, per_lane, want); break;
    case LW_STEP_PRP:
    case LW_STEP_PPR:         prp(k, s, n, want); break;
    }
}

#define FORWARD(name, per_lane, want) \
    static void name(const run *k, const lw_step *s, size_t n) { step_forward(k, s, n, per_lane, want); }
FORWARD(forward_shared_pose, 0, POSE_ONLY)
FORWARD(forward_shared_margin, 0, WITH_MARGIN)
FORWARD(forward_shared_roots, 0, WITH_ROOTS)
FORWARD(forward_lanes_pose, 1, POSE_ONLY)
FORWARD(forward_lanes_margin, 1, WITH_MARGIN)

/* All steps output `which` depends on. */
static void forward(const run *k, int which, size_t n, int per_lane, int want)
{
    static void (*const step[2][3])(const run *, const lw_step *, size_t) = {
        { forward_shared_pose, forward_shared_margin, forward_shared_roots },
        { forward_lanes_pose, forward_lanes_margin, NULL }
    };
    const lw_plan *p = k->plan;
    double *margin = k->margin;
    for (size_t i = 0; want && i < n; i++)
        margin[i] = 1;
    for (int i = 0; i < p->n_output_step[which]; i++)
        step[per_lane][want](k, &p->step[p->output_step[which][i]], n);
}

/* ---- steps backwards: see mbs/dyad.h -------------------------------------------------------------------
 * Several adjoints may be one register, which is read again after it is written. */

static void back_input_slide(const run *k, const lw_step *s, size_t n, double *input_bar)
{
    const double *wx = reg_x(k, s->in[1]), *wy = reg_y(k, s->in[1]), *d = k->c;
    const double *ox = bar_x(k, s->out[0]), *oy = bar_y(k, s->out[0]);
    double *qx = bar_x(k, s->in[0]), *qy = bar_y(k, s->in[0]), *w = bar_x(k, s->in[1]);
    LW_LANES(n) {
        lw_vec2 o = lw_v2(ox[i], oy[i]), u = lw_v2(wx[i], wy[i]);
        input_bar[i] += lw_v2_dot(o, u);
        w[i] += d[i]*lw_v2_dot(o, lw_v2_perp(u));
        qx[i] += o.x;
        qy[i] += o.y;
    }
}

static void back_point(const run *k, const lw_step *s, size_t n)
{
    const double *dx = reg_x(k, s->in[1]), *dy = reg_y(k, s->in[1]);
    const double x = *dim_of(k, s->dim[0]), y = *dim_of(k, s->dim[1]);
    const double *px = bar_x(k, s->out[0]), *py = bar_y(k, s->out[0]);
    double *ox = bar_x(k, s->in[0]), *oy = bar_y(k, s->in[0]), *d = bar_x(k, s->in[1]);
    double *x_bar = dim_bar(k, s->dim[0]), *y_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        lw_vec2 p = lw_v2(px[i], py[i]), u = lw_v2(dx[i], dy[i]);
        double along = lw_v2_dot(p, u), across = lw_v2_dot(p, lw_v2_perp(u));
        x_bar[i] += along;
        y_bar[i] += across;
        d[i] += x*across - y*along;
        ox[i] += p.x;
        oy[i] += p.y;
    }
}

static void back_line(const run *k, const lw_step *s, size_t n)
{
    const double *wx = reg_x(k, s->out[1]), *wy = reg_y(k, s->out[1]), e = *dim_of(k, s->dim[0]);
    const double *qx = bar_x(k, s->out[0]), *qy = bar_y(k, s->out[0]), *w = bar_x(k, s->out[1]);
    double *ox = bar_x(k, s->in[0]), *oy = bar_y(k, s->in[0]), *d = bar_x(k, s->in[1]);
    double *e_bar = dim_bar(k, s->dim[0]), *beta_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        lw_vec2 q = lw_v2(qx[i], qy[i]), u = lw_v2(wx[i], wy[i]);
        double turn = w[i] - e*lw_v2_dot(q, u);
        e_bar[i] += lw_v2_dot(q, lw_v2_perp(u));
        beta_bar[i] += turn;
        d[i] += turn;
        ox[i] += q.x;
        oy[i] += q.y;
    }
}

static void back_rrr(const run *k, const lw_step *s, size_t n)
{
    const double *px = reg_x(k, s->in[0]), *py = reg_y(k, s->in[0]), *qx = reg_x(k, s->in[1]), *qy = reg_y(k, s->in[1]);
    const double *ux = reg_x(k, s->out[0]), *uy = reg_y(k, s->out[0]), *inv = aux_row(k, s->dyad);
    const double r1 = *dim_of(k, s->dim[0]), r2 = *dim_of(k, s->dim[1]), by_r2 = 1/lw_away_from_zero(r2);
    const double *u = bar_x(k, s->out[0]), *cx = bar_x(k, s->out[2]), *cy = bar_y(k, s->out[2]);
    const double *v = s->out[1] < 0 ? reg_x(k, 0) : bar_x(k, s->out[1]);
    double *ax = bar_x(k, s->in[0]), *ay = bar_y(k, s->in[0]), *bx = bar_x(k, s->in[1]), *by = bar_y(k, s->in[1]);
    double *r1_bar = dim_bar(k, s->dim[0]), *r2_bar = dim_bar(k, s->dim[1]);
    LW_LANES(n) {
        lw_vec2 u1 = lw_v2(ux[i], uy[i]), c = lw_v2(cx[i], cy[i]);
        lw_vec2 tip = lw_point(lw_v2(px[i], py[i]), u1, r1, 0);
        lw_vec2 u2 = lw_v2_scale(lw_v2_sub(tip, lw_v2(qx[i], qy[i])), by_r2);
        double d1 = lw_v2_dot(c, u1), d2 = 0;
        lw_vec2 pull = lw_rrr_back(u1, u2, r1, r2, inv[i], u[i] + r1*lw_v2_dot(c, lw_v2_perp(u1)), v[i], &d1, &d2);
        r1_bar[i] += d1;
        r2_bar[i] += d2;
        ax[i] += c.x - pull.x;
        ay[i] += c.y - pull.y;
        bx[i] += pull.x;
        by[i] += pull.y;
    }
}

static void back_rrp(const run *k, const lw_step *s, size_t n)
{
    const double *qx = reg_x(k, s->in[1]), *qy = reg_y(k, s->in[1]), *wx = reg_x(k, s->in[2]), *wy = reg_y(k, s->in[2]);
    const double *ux = reg_x(k, s->out[0]), *uy = reg_y(k, s->out[0]), *tx = reg_x(k, s->out[1]), *ty = reg_y(k, s->out[1]);
    const double r = *dim_of(k, s->dim[0]), *inv = aux_row(k, s->dyad);
    const double *u = bar_x(k, s->out[0]), *cx = bar_x(k, s->out[1]), *cy = bar_y(k, s->out[1]);
    double *ax = bar_x(k, s->in[0]), *ay = bar_y(k, s->in[0]), *bx = bar_x(k, s->in[1]), *by = bar_y(k, s->in[1]);
    double *w = bar_x(k, s->in[2]), *r_bar = dim_bar(k, s->dim[0]);
    LW_LANES(n) {
        lw_vec2 u1 = lw_v2(ux[i], uy[i]), w1 = lw_v2(wx[i], wy[i]), c = lw_v2(cx[i], cy[i]);
        double t = lw_v2_dot(lw_v2_sub(lw_v2(tx[i], ty[i]), lw_v2(qx[i], qy[i])), w1);
        double d = lw_v2_dot(c, u1), dw = 0;
        lw_vec2 pull = lw_rrp_back(u1, w1, t, inv[i], u[i] + r*lw_v2_dot(c, lw_v2_perp(u1)), &d, &dw);
        r_bar[i] += d;
        w[i] += dw;
        ax[i] += c.x - pull.x;
        ay[i] += c.y - pull.y;
        bx[i] += pull.x;
        by[i] += pull.y;
    }
}

static void back_rpr(const run *k, const lw_step *s, size_t n)
{
    const double *ux = reg_x(k, s->out[0]), *uy = reg_y(k, s->out[0]), *u = bar_x(k, s->out[0]);
    const double *inv = aux_row(k, s->dyad);
    double *ax = bar_x(k, s->in[0]), *ay = bar_y(k, s->in[0]), *bx = bar_x(k, s->in[1]), *by = bar_y(k, s->in[1]);
    double *e_bar = dim_bar(k, s->dim[0]);
    LW_LANES(n) {
        double d = 0;
        lw_vec2 pull = lw_rpr_back(lw_v2(ux[i], uy[i]), inv[i], u[i], &d);
        e_bar[i] += d;
        ax[i] -= pull.x;
        ay[i] -= pull.y;
        bx[i] += pull.x;
        by[i] += pull.y;
    }
}

static void back_prp(const run *k, const lw_step *s, size_t n)
{
    const double *px = reg_x(k, s->in[0]), *py = reg_y(k, s->in[0]), *ux = reg_x(k, s->in[1]), *uy = reg_y(k, s->in[1]);
    const double *qx = reg_x(k, s->in[2]), *qy = reg_y(k, s->in[2]), *wx = reg_x(k, s->in[3]), *wy = reg_y(k, s->in[3]);
    const double *tx = reg_x(k, s->out[0]), *ty = reg_y(k, s->out[0]), *inv = aux_row(k, s->dyad);
    const double *cx = bar_x(k, s->out[0]), *cy = bar_y(k, s->out[0]);
    double *ax = bar_x(k, s->in[0]), *ay = bar_y(k, s->in[0]), *u = bar_x(k, s->in[1]);
    double *bx = bar_x(k, s->in[2]), *by = bar_y(k, s->in[2]), *w = bar_x(k, s->in[3]);
    LW_LANES(n) {
        lw_vec2 tip = lw_v2(tx[i], ty[i]), c = lw_v2(cx[i], cy[i]), u1 = lw_v2(ux[i], uy[i]), u2 = lw_v2(wx[i], wy[i]);
        double t1 = lw_v2_dot(lw_v2_sub(tip, lw_v2(px[i], py[i])), u1);
        double t2 = lw_v2_dot(lw_v2_sub(tip, lw_v2(qx[i], qy[i])), u2);
        double d1 = 0, d2 = 0;
        lw_vec2 pull = lw_prp_back(u1, u2, t1, t2, inv[i], c, &d1, &d2);
        u[i] += d1;
        w[i] += d2;
        ax[i] += c.x - pull.x;
        ay[i] += c.y - pull.y;
        bx[i] += pull.x;
        by[i] += pull.y;
    }
}

/* From the adjoints of output `which`, set in k->bar, to k->row and the input's row. */
static void backward(const run *k, int which, size_t n, double *input_bar)
{
    const lw_plan *p = k->plan;
    for (int i = p->n_output_step[which] - 1; i >= 0; i--) {
        const lw_step *s = &p->step[p->output_step[which][i]];
        switch (s->kind) {
        case LW_STEP_INPUT_PIN:
            for (size_t j = 0; j < n; j++)
                input_bar[j] += bar_x(k, s->out[0])[j];
            break;
        case LW_STEP_INPUT_SLIDE: back_input_slide(k, s, n, input_bar); break;
        case LW_STEP_POINT:       back_point(k, s, n); break;
        case LW_STEP_LINE:        back_line(k, s, n); break;
        case LW_STEP_RRR:         back_rrr(k, s, n); break;
        case LW_STEP_RRP:         back_rrp(k, s, n); break;
        case LW_STEP_RPR:         back_rpr(k, s, n); break;
        case LW_STEP_PRP:
        case LW_STEP_PPR:         back_prp(k, s, n); break;
        }
    }
}

#endif
