/* The loops over lanes: each step of the plan is one loop over a block, forwards and backwards.
 *
 * Compiled once per instruction set (LW_ISA, see the Makefile); everything but the table at the end
 * is static, so that no instruction of one set leaks into another. */
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
        lw_rrp z = lw_rrp_solve(lw_v2(ax[i], ay[i]), lw_v2(qx[i], qy[i]), lw_v2(wx[i], wy[i]), per_lane ? r[i] : r0,
                                per_lane ? mode[i] : mode0);
        if (want)
            keep_margin(&margin[i], &aux[i], lw_rrp_margin(&z), z.y, want);
        ux[i] = z.u.x;
        uy[i] = z.u.y;
        cx[i] = z.c.x;
        cy[i] = z.c.y;
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

/* ---- lanes in blocks ----------------------------------------------------------------------------------- */

static size_t round_up(size_t n) { return (n + LW_GROUP - 1)/LW_GROUP*LW_GROUP; }

/* Share out the work memory; rows are as short as n allows, to stay in cache. */
static run start(const lw_plan *plan, size_t n, void *work)
{
    run k = { .plan = plan, .nb = n >= LW_BLOCK ? LW_BLOCK : round_up(n) };
    double *w = work;
    size_t nb = k.nb;
    k.reg = w;         w += 2*(size_t)plan->n_reg*nb;
    k.bar = w;         w += 2*(size_t)plan->n_reg*nb;
    k.margin = w;      w += nb;
    k.spare = w;       w += 3*nb;
    k.aux = w;         w += (size_t)plan->n_dyad*nb;
    k.spread_mode = w; w += (size_t)plan->n_dyad*nb;
    k.turn = w;        w += 2*(size_t)plan->n_angle*nb;
    k.spread_dim = w;  w += (size_t)plan->n_dim*nb;
    k.row = w;         w += (size_t)plan->n_dim*nb;
    k.row_row = nb;
    k.tail = w;
    for (size_t i = 0; i < nb; i++) {
        reg_x(&k, 0)[i] = reg_y(&k, 0)[i] = reg_y(&k, 1)[i] = 0;
        reg_x(&k, 1)[i] = 1;
    }
    return k;
}

/* One set of numbers copied to every lane. */
static void spread(double *to, const double *from, int count, size_t nb)
{
    for (int d = 0; d < count; d++)
        for (size_t i = 0; i < nb; i++)
            to[(size_t)d*nb + i] = from[d];
}

/* Dimensions and modes of the lanes: both shared, or both per lane. */
static int set_numbers(run *k, const lw_lanes *in, size_t first)
{
    int per_lane = in->dim_stride || in->mode_stride;
    k->dim = in->dim_stride ? in->dim + first : in->dim;
    k->dim_row = in->dim_stride ? in->dim_stride : 1;
    k->mode = in->mode_stride ? in->mode + first : in->mode;
    k->mode_row = in->mode_stride ? in->mode_stride : 1;
    if (per_lane && !in->dim_stride) {
        spread(k->spread_dim, in->dim, k->plan->n_dim, k->nb);
        k->dim = k->spread_dim;
        k->dim_row = k->nb;
    }
    if (per_lane && !in->mode_stride) {
        spread(k->spread_mode, in->mode, k->plan->n_dyad, k->nb);
        k->mode = k->spread_mode;
        k->mode_row = k->nb;
    }
    return per_lane;
}

/* Cosine and sine of the angles among the dimensions; those far beyond a turn by the library. */
static void set_turns(run *k, int per_lane, size_t n)
{
    k->turn_row = per_lane ? k->nb : 1;
    if (!per_lane)
        n = 1;
    for (int a = 0; a < k->plan->n_angle; a++) {
        const double *angle = dim_of(k, k->plan->angle[a]);
        double *restrict c = k->turn + 2*(size_t)a*k->turn_row, *restrict s = c + k->turn_row;
        LW_LANES(n) {
            lw_vec2 u = lw_sincos(angle[i]);
            c[i] = u.x;
            s[i] = u.y;
        }
        for (size_t i = 0; i < n; i++)
            if (!(fabs(angle[i]) < LW_SINCOS_MAX)) {
                c[i] = cos(angle[i]);
                s[i] = sin(angle[i]);
            }
    }
}

/* The lanes from `first` on, fewer than a group, as a full group: the last one repeated. */
static lw_lanes pad(const run *k, const lw_lanes *in, size_t first)
{
    const lw_plan *p = k->plan;
    double *c = k->tail, *s = c + LW_GROUP, *mode = s + LW_GROUP, *dim = mode + (size_t)p->n_dyad*LW_GROUP;
    lw_lanes out = { LW_GROUP, c, s, in->dim_stride ? dim : in->dim, in->dim_stride ? LW_GROUP : 0,
                     in->mode_stride ? mode : in->mode, in->mode_stride ? LW_GROUP : 0 };
    for (size_t i = 0; i < LW_GROUP; i++) {
        size_t from = first + i < in->n ? first + i : in->n - 1;
        c[i] = in->c[from];
        s[i] = p->input_is_slider ? 0 : in->s[from];
        for (int d = 0; in->dim_stride && d < p->n_dim; d++)
            dim[(size_t)d*LW_GROUP + i] = in->dim[(size_t)d*in->dim_stride + from];
        for (int d = 0; in->mode_stride && d < p->n_dyad; d++)
            mode[(size_t)d*LW_GROUP + i] = in->mode[(size_t)d*in->mode_stride + from];
    }
    return out;
}

/* Where a padded group puts its outputs, after its inputs. */
static double *tail_rows(const run *k)
{
    return k->tail + (2 + (size_t)k->plan->n_dyad + (size_t)k->plan->n_dim)*LW_GROUP;
}

static void copy_out(double *to, const double *from, size_t n)
{
    if (to)
        memcpy(to, from, n*sizeof *to);
}

static double *at(double *row, size_t first) { return row ? row + first : NULL; }

/* ---- points and frames ----------------------------------------------------------------------------------- */

typedef struct rows { double *x, *y, *u, *v, *margin; } rows;

/* (x, y) += or turned by theta0 into the plane. */
LW_INLINE void move(const run *k, size_t n, const double *px, const double *py, double *restrict x, double *restrict y,
                    const int per_lane, const int shift)
{
    const lw_plan *p = k->plan;
    const double *c = cos_of(k, p->n_angle - 1), *s = sin_of(k, p->n_angle - 1);
    const double *x0 = dim_of(k, p->i_x0), *y0 = dim_of(k, p->i_y0), c0 = *c, s0 = *s, x00 = *x0, y00 = *y0;
    LW_LANES(n) {
        lw_vec2 q = lw_v2_turn(lw_v2(px[i], py[i]), lw_v2(per_lane ? c[i] : c0, per_lane ? s[i] : s0));
        x[i] = shift ? q.x + (per_lane ? x0[i] : x00) : q.x;
        y[i] = shift ? q.y + (per_lane ? y0[i] : y00) : q.y;
    }
}

static void move_out(const run *k, size_t n, int reg, double *x, double *y, int per_lane, int shift)
{
    const double *px = reg_x(k, reg), *py = reg_y(k, reg);
    if (per_lane && shift)
        move(k, n, px, py, x, y, 1, 1);
    else if (per_lane)
        move(k, n, px, py, x, y, 1, 0);
    else if (shift)
        move(k, n, px, py, x, y, 0, 1);
    else
        move(k, n, px, py, x, y, 0, 0);
}

static void block_point(run *k, const lw_lanes *in, int which, size_t first, size_t n, const rows *out, int frame)
{
    const lw_plan *p = k->plan;
    int per_lane = set_numbers(k, in, first), want = out->margin ? WITH_MARGIN : POSE_ONLY;
    k->c = in->c + first;
    k->s = in->s ? in->s + first : NULL;
    set_turns(k, per_lane, n);
    forward(k, which, n, per_lane, want);
    copy_out(out->margin, k->margin, n);
    int o = frame ? p->link_origin[p->output_link[which]] : p->output_point[which], d = p->output_dir[which];
    if (frame) {
        copy_out(out->x, reg_x(k, o), n);
        copy_out(out->y, reg_y(k, o), n);
        copy_out(out->u, reg_x(k, d), n);
        copy_out(out->v, reg_y(k, d), n);
        return;
    }
    move_out(k, n, o, out->x, out->y, per_lane, 1);
    if (out->u && out->v)
        move_out(k, n, d, out->u, out->v, per_lane, 0);
}

static void points(const lw_plan *plan, const lw_lanes *in, int which, void *work, const rows *out, int frame)
{
    run k = start(plan, in->n, work);
    size_t full = in->n/LW_GROUP*LW_GROUP, rest = in->n - full;
    for (size_t first = 0; first < full; first += LW_BLOCK) {
        rows to = { at(out->x, first), at(out->y, first), at(out->u, first), at(out->v, first), at(out->margin, first) };
        block_point(&k, in, which, first, full - first < LW_BLOCK ? full - first : LW_BLOCK, &to, frame);
    }
    if (rest) {
        lw_lanes last = pad(&k, in, full);
        double *t = tail_rows(&k);
        rows to = { t, t + 8, t + 16, t + 24, t + 32 };
        block_point(&k, &last, which, 0, LW_GROUP, &to, frame);
        copy_out(at(out->x, full), to.x, rest);
        copy_out(at(out->y, full), to.y, rest);
        copy_out(at(out->u, full), to.u, rest);
        copy_out(at(out->v, full), to.v, rest);
        copy_out(at(out->margin, full), to.margin, rest);
    }
}

static void kernel_point(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                         double *x, double *y, double *u, double *v, double *margin)
{
    points(plan, in, which, work, &(rows){ x, y, u, v, margin }, 0);
}

static void kernel_frame(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                         double *ox, double *oy, double *dx, double *dy, double *margin)
{
    points(plan, in, which, work, &(rows){ ox, oy, dx, dy, margin }, 1);
}

/* ---- Jacobian --------------------------------------------------------------------------------------------- */

/* One component: seeds on the output's point or direction, derivatives to `row`, by the input to `input`. */
static void component(run *k, int which, size_t n, lw_vec2 seed, double turn, double *row, size_t ld, double *input)
{
    const lw_plan *p = k->plan;
    double *px = bar_x(k, p->output_point[which]), *py = bar_y(k, p->output_point[which]), *d = bar_x(k, p->output_dir[which]);
    k->row = row;
    k->row_row = ld;
    memset(k->bar, 0, 2*(size_t)p->n_reg*k->nb*sizeof(double));
    memset(input, 0, n*sizeof(double));
    for (int i = 0; i < p->n_dim; i++)
        memset(row + (size_t)i*ld, 0, n*sizeof(double));
    for (size_t i = 0; i < n; i++) {
        px[i] = seed.x;
        py[i] = seed.y;
        d[i] += turn;
    }
    backward(k, which, n, input);
}

static void fill(double *row, double v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        row[i] = v;
}

static void block_jacobian(run *k, const lw_lanes *in, int which, size_t first, size_t n, const lw_jacobian *out)
{
    const lw_plan *p = k->plan;
    const rows at_place = { out->x, out->y, out->u, out->v, out->margin };
    set_numbers(k, in, first);
    k->c = in->c + first;
    k->s = in->s ? in->s + first : NULL;
    set_turns(k, 0, n);
    forward(k, which, n, 0, WITH_ROOTS);
    copy_out(at_place.margin, k->margin, n);
    move_out(k, n, p->output_point[which], out->x, out->y, 0, 1);
    if (out->u && out->v)
        move_out(k, n, p->output_dir[which], out->u, out->v, 0, 0);
    double c = *cos_of(k, p->n_angle - 1), s = *sin_of(k, p->n_angle - 1), *scrap = k->spare + k->nb;
    component(k, which, n, lw_v2(c, -s), 0, out->jx, out->ld, out->tx ? out->tx : scrap);
    component(k, which, n, lw_v2(s, c), 0, out->jy, out->ld, out->ty ? out->ty : scrap);
    fill(out->jx + (size_t)p->i_x0*out->ld, 1, n);
    fill(out->jy + (size_t)p->i_y0*out->ld, 1, n);
    for (size_t i = 0; i < n; i++) {
        out->jx[(size_t)p->i_theta0*out->ld + i] = in->dim[p->i_y0] - out->y[i];
        out->jy[(size_t)p->i_theta0*out->ld + i] = out->x[i] - in->dim[p->i_x0];
    }
    if (out->jt) {
        component(k, which, n, lw_v2(0, 0), 1, out->jt, out->ld, out->tt ? out->tt : scrap);
        fill(out->jt + (size_t)p->i_theta0*out->ld, 1, n);
    }
}

static lw_jacobian shift_jacobian(const lw_jacobian *o, size_t first)
{
    return (lw_jacobian){ at(o->x, first), at(o->y, first), at(o->u, first), at(o->v, first), at(o->margin, first),
                          at(o->jx, first), at(o->jy, first), at(o->jt, first), at(o->tx, first), at(o->ty, first),
                          at(o->tt, first), o->ld };
}

static void copy_jacobian(const lw_jacobian *to, const lw_jacobian *from, int n_dim, size_t n)
{
    double *const single[][2] = { { to->x, from->x }, { to->y, from->y }, { to->u, from->u }, { to->v, from->v },
                                  { to->margin, from->margin }, { to->tx, from->tx }, { to->ty, from->ty },
                                  { to->tt, from->tt } };
    for (size_t i = 0; i < sizeof single/sizeof *single; i++)
        copy_out(single[i][0], single[i][1], n);
    for (int d = 0; d < n_dim; d++) {
        copy_out(to->jx + (size_t)d*to->ld, from->jx + (size_t)d*from->ld, n);
        copy_out(to->jy + (size_t)d*to->ld, from->jy + (size_t)d*from->ld, n);
        if (to->jt)
            copy_out(to->jt + (size_t)d*to->ld, from->jt + (size_t)d*from->ld, n);
    }
}

static void kernel_jacobian(const lw_plan *plan, const lw_lanes *in, int which, void *work, const lw_jacobian *out)
{
    run k = start(plan, in->n, work);
    size_t full = in->n/LW_GROUP*LW_GROUP, rest = in->n - full;
    for (size_t first = 0; first < full; first += LW_BLOCK) {
        lw_jacobian to = shift_jacobian(out, first);
        block_jacobian(&k, in, which, first, full - first < LW_BLOCK ? full - first : LW_BLOCK, &to);
    }
    if (rest) {
        lw_lanes last = pad(&k, in, full);
        double *t = tail_rows(&k), *j = t + 8*LW_GROUP;
        size_t size = (size_t)plan->n_dim*LW_GROUP;
        lw_jacobian to = { t, t + 8, t + 16, t + 24, t + 32, j, j + size, out->jt ? j + 2*size : NULL,
                           t + 40, t + 48, t + 56, LW_GROUP };
        block_jacobian(&k, &last, which, 0, LW_GROUP, &to);
        lw_jacobian here = shift_jacobian(out, full);
        copy_jacobian(&here, &to, plan->n_dim, rest);
    }
}

/* ---- sum of squares with gradient ---------------------------------------------------------------------------- */

/* Eight sums, lane by lane number modulo eight, so that vector width does not change their order. */
LW_INLINE void accumulate(double *restrict acc, const double *row, size_t n)
{
    for (size_t i = 0; i < n; i += LW_GROUP)
        for (size_t j = 0; j < LW_GROUP; j++)
            acc[j] += row[i + j];
}

static double total(const double *acc)
{
    return ((acc[0] + acc[4]) + (acc[2] + acc[6])) + ((acc[1] + acc[5]) + (acc[3] + acc[7]));
}

typedef struct target { const double *x, *y, *w; } target;

/* Residuals to seeds: the adjoint of the point in the ground frame; adds up f and the place's share. */
static void block_sum(run *k, const lw_lanes *in, int which, size_t first, size_t n, const target *t, double *acc)
{
    const lw_plan *p = k->plan;
    set_numbers(k, in, first);
    k->c = in->c + first;
    k->s = in->s ? in->s + first : NULL;
    forward(k, which, n, 0, WITH_ROOTS);
    memset(k->bar, 0, 2*(size_t)p->n_reg*k->nb*sizeof(double));
    memset(k->row, 0, (size_t)p->n_dim*k->nb*sizeof(double));
    const double c = *cos_of(k, p->n_angle - 1), s = *sin_of(k, p->n_angle - 1), x0 = in->dim[p->i_x0], y0 = in->dim[p->i_y0];
    const double *px = reg_x(k, p->output_point[which]), *py = reg_y(k, p->output_point[which]);
    const double *tx = t->x, *ty = t->y, *w = t->w;
    double *restrict bx = bar_x(k, p->output_point[which]), *restrict by = bar_y(k, p->output_point[which]);
    double *restrict gx = dim_bar(k, p->i_x0), *restrict gy = dim_bar(k, p->i_y0), *restrict gt = dim_bar(k, p->i_theta0);
    double *restrict f = k->spare + 2*k->nb;
    LW_LANES(n) {
        lw_vec2 q = lw_v2_turn(lw_v2(px[i], py[i]), lw_v2(c, s));
        double ex = q.x + x0 - tx[i], ey = q.y + y0 - ty[i], hx = w ? w[i]*ex : ex, hy = w ? w[i]*ey : ey;
        f[i] = ex*hx + ey*hy;
        gx[i] = 2*hx;
        gy[i] = 2*hy;
        gt[i] = 2*(q.x*hy - q.y*hx);
        bx[i] = 2*(c*hx + s*hy);
        by[i] = 2*(c*hy - s*hx);
    }
    backward(k, which, n, k->spare + k->nb);
    for (int d = 0; d < p->n_dim; d++)
        accumulate(acc + d*LW_GROUP, dim_bar(k, d), n);
    accumulate(acc + p->n_dim*LW_GROUP, f, n);
}

static double least(const double *margin, size_t n, double so_far)
{
    for (size_t i = 0; i < n; i++)
        so_far = margin[i] < so_far ? margin[i] : so_far;
    return so_far;
}

/* The targets of a padded group; weight 0 for the padding. */
static target pad_target(const run *k, const target *t, size_t first, size_t rest)
{
    double *x = tail_rows(k), *y = x + LW_GROUP, *w = y + LW_GROUP;
    for (size_t i = 0; i < LW_GROUP; i++) {
        x[i] = i < rest ? t->x[first + i] : 0;
        y[i] = i < rest ? t->y[first + i] : 0;
        w[i] = i >= rest ? 0 : t->w ? t->w[first + i] : 1;
    }
    return (target){ x, y, w };
}

static double kernel_sum(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                         const double *tx, const double *ty, const double *w, double *grad, double *margin)
{
    run k = start(plan, in->n, work);
    target t = { tx, ty, w };
    size_t full = in->n/LW_GROUP*LW_GROUP, rest = in->n - full;
    double *acc = tail_rows(&k) + 3*LW_GROUP, smallest = 1;
    memset(acc, 0, (size_t)(plan->n_dim + 1)*LW_GROUP*sizeof(double));
    set_numbers(&k, in, 0);
    set_turns(&k, 0, 1);
    for (size_t first = 0; first < full; first += LW_BLOCK) {
        size_t n = full - first < LW_BLOCK ? full - first : LW_BLOCK;
        target here = { tx + first, ty + first, w ? w + first : NULL };
        block_sum(&k, in, which, first, n, &here, acc);
        smallest = least(k.margin, n, smallest);
    }
    if (rest) {
        lw_lanes last = pad(&k, in, full);
        target here = pad_target(&k, &t, full, rest);
        block_sum(&k, &last, which, 0, LW_GROUP, &here, acc);
        smallest = least(k.margin, LW_GROUP, smallest);
    }
    for (int d = 0; grad && d < plan->n_dim; d++)
        grad[d] = total(acc + d*LW_GROUP);
    if (margin)
        *margin = smallest;
    return total(acc + plan->n_dim*LW_GROUP);
}

#define LW_TABLE_OF(isa) lw_kernels_##isa
#define LW_TABLE(isa)    LW_TABLE_OF(isa)
extern const lw_kernels LW_TABLE(LW_ISA);
const lw_kernels LW_TABLE(LW_ISA) = { LW_ISA_NAME, kernel_point, kernel_frame, kernel_jacobian, kernel_sum };
