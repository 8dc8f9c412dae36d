/* All steps of the most frequent plans (lw_fast_dyad in mbs/plan/plan.h) in one loop, with the same dyad formulas as
 * the loops of single steps.
 *
 * `pin` (is the input a crank, not a slider?) and `dyad` are constants wherever these functions are inlined. */
#include "mbs/batch/kernel_run_internal.h"

/* The slide line of RRP is parallel to x, or turned and through the origin (FAST_RRP_TURNED). */
enum { FAST_RRR, FAST_RRP, FAST_RRP_TURNED, FAST_RPR };

static int fast_kind(const lw_fast_dyad *f)
{
    return f->dyad == LW_STEP_RRR ? FAST_RRR : f->dyad == LW_STEP_RPR ? FAST_RPR
         : f->beta < 0 ? FAST_RRP : FAST_RRP_TURNED;
}

/* The dimensions of one lane; wc, ws and ct, st are the cosines and sines of beta and theta0. */
typedef struct numbers { double r2, e_in, b, e, wc, ws, d1, d2, cx, cy, x0, y0, ct, st, mode; } numbers;

/* The solution of one lane; the tracer is a + arm. */
typedef struct lane { lw_vec2 a, u, arm, tip; double y, margin; } lane;

/* Rows of the dimensions: one number that all lanes share, or one a lane. */
typedef struct number_rows {
    const double *r2, *e_in, *b, *e, *wc, *ws, *d1, *d2, *cx, *cy, *x0, *y0, *ct, *st, *mode;
} number_rows;

static const double zeros[LW_ZEROS];

LW_INLINE const double *fast_dim(const run *k, int d) { return d < 0 ? zeros : dim_of(k, d); }

static number_rows fast_rows(const run *k, int which)
{
    const lw_plan *p = k->plan;
    const lw_fast_dyad *f = &p->output_fast_dyad[which];
    int turn = p->n_angle - 1;
    return (number_rows){
        fast_dim(k, f->r2), fast_dim(k, f->e_in), fast_dim(k, f->b), fast_dim(k, f->e),
        f->beta < 0 ? zeros : cos_of(k, f->beta), f->beta < 0 ? zeros : sin_of(k, f->beta),
        fast_dim(k, f->d1), fast_dim(k, f->d2), fast_dim(k, p->i_cx[which]), fast_dim(k, p->i_cy[which]),
        dim_of(k, p->i_x0), dim_of(k, p->i_y0), cos_of(k, turn), sin_of(k, turn), k->mode
    };
}

LW_INLINE numbers numbers_at(const number_rows *r, size_t i)
{
    return (numbers){ r->r2[i], r->e_in[i], r->b[i], r->e[i], r->wc[i], r->ws[i], r->d1[i], r->d2[i], r->cx[i],
                      r->cy[i], r->x0[i], r->y0[i], r->ct[i], r->st[i], r->mode[i] };
}

LW_INLINE lane fast_solve(double c, double s, const numbers *g, double flat, const int pin, const int dyad)
{
    lane z;
    z.a = pin ? lw_v2(g->r2*c, g->r2*s) : lw_v2(c, g->e_in);
    z.tip = z.a;
    if (dyad == FAST_RRR) {
        lw_rrr d = lw_rrr_solve(z.a, lw_v2(g->b, 0), g->d1, g->d2, g->mode);
        z.u = lw_rrr_first(&d);
        z.y = d.y;
        z.margin = lw_rrr_margin(&d, flat);
    } else if (dyad == FAST_RRP || dyad == FAST_RRP_TURNED) {
        lw_rrp d = dyad == FAST_RRP ? lw_rrp_solve(g->e - z.a.y, g->d1, g->mode)
                                     : lw_rrp_solve_along(z.a, lw_v2(0, 0), lw_v2(g->wc, g->ws), g->d1, g->mode);
        z.u = lw_rrp_direction(&d);
        z.y = d.y;
        z.tip = lw_v2_add(z.a, d.arm);
        z.margin = lw_rrp_margin(&d);
    } else {
        lw_rpr d = lw_rpr_solve(z.a, lw_v2(g->b, 0), g->d1, g->mode);
        z.u = d.u;
        z.y = d.y;
        z.margin = lw_rpr_margin(&d);
    }
    z.arm = lw_v2_turn(lw_v2(g->cx, g->cy), z.u);
    return z;
}

LW_INLINE lw_vec2 fast_point(const lane *z, const numbers *g)
{
    lw_vec2 p = lw_v2_turn(lw_v2_add(z->a, z->arm), lw_v2(g->ct, g->st));
    return lw_v2(p.x + g->x0, p.y + g->y0);
}

/* Derivatives of one scalar by the dimensions and the input. */
typedef struct bars { double r2, e_in, b, e, beta, d1, d2, cx, cy, input; } bars;

/* The derivatives, from the adjoints of the tracer in the ground frame (bar) and of the link's angle. */
LW_INLINE bars fast_back(double c, double s, const numbers *g, const lane *z, double inv, double by_d2,
                          lw_vec2 bar, double angle, const int pin, const int dyad)
{
    bars o = { 0 };
    lw_vec2 a = bar, pull;
    double turn = lw_v2_cross(z->arm, bar) + angle;
    o.cx = lw_v2_dot(bar, z->u);
    o.cy = lw_v2_dot(bar, lw_v2_perp(z->u));
    if (dyad == FAST_RRR) {
        lw_vec2 tip = lw_v2_add(z->a, lw_v2_scale(z->u, g->d1));
        lw_vec2 u2 = lw_v2_scale(lw_v2(tip.x - g->b, tip.y), by_d2);
        pull = lw_rrr_back(z->u, u2, g->d1, g->d2, inv, turn, 0, &o.d1, &o.d2);
    } else if (dyad == FAST_RRP) {                      /* lw_rrp_back with w along x */
        double k = turn*inv;
        o.d1 = -k*z->u.y;
        pull = lw_v2(0, k);
    } else if (dyad == FAST_RRP_TURNED) {
        lw_vec2 w = lw_v2(g->wc, g->ws);
        pull = lw_rrp_back(z->u, w, lw_v2_dot(z->tip, w), inv, turn, &o.d1, &o.beta);
    } else
        pull = lw_rpr_back(z->u, inv, turn, &o.d1);
    a = lw_v2_sub(a, pull);
    o.b = pull.x;
    o.e = pull.y;
    o.r2 = pin ? a.x*c + a.y*s : 0;
    o.e_in = a.y;
    o.input = pin ? g->r2*(a.y*c - a.x*s) : a.x;
    return o;
}

/* ---- loops ------------------------------------------------------------------------------------------------- */

/* The outputs of a loop over points. */
enum { PLACE, PLACE_MARGIN, PLACE_TURN, PLACE_TURN_MARGIN, FRAME, FRAME_MARGIN };

LW_INLINE void fast_points(const run *k, const number_rows *r, size_t n, const rows *out, const int per_lane,
                            const int form, const int pin, const int dyad)
{
    const double *c = k->c, *s = pin ? k->s : k->c;
    const numbers g0 = numbers_at(r, 0);
    const double flat0 = lw_rrr_flat(g0.d1, g0.d2);
    double *restrict x = out->x, *restrict y = out->y, *restrict u = out->u, *restrict v = out->v;
    double *restrict margin = out->margin;
    const number_rows q = *r;
    LW_LANES(n) {
        numbers g = per_lane ? numbers_at(&q, i) : g0;
        lane z = fast_solve(c[i], s[i], &g, per_lane ? lw_rrr_flat(g.d1, g.d2) : flat0, pin, dyad);
        lw_vec2 p = form >= FRAME ? z.a : fast_point(&z, &g);
        x[i] = p.x;
        y[i] = p.y;
        if (form >= PLACE_TURN) {
            lw_vec2 d = form >= FRAME ? z.u : lw_v2_turn(z.u, lw_v2(g.ct, g.st));
            u[i] = d.x;
            v[i] = d.y;
        }
        if (form & PLACE_MARGIN)
            margin[i] = z.margin;
    }
}

/* Rows of the Jacobian by the names of lw_fast_dyad; a spare row where the plan has no such dimension. */
typedef struct bar_rows { double *r2, *e_in, *b, *e, *beta, *d1, *d2, *cx, *cy, *turn, *input; } bar_rows;

static bar_rows fast_bars(const run *k, int which, double *base, size_t ld, double *input)
{
    const lw_plan *p = k->plan;
    const lw_fast_dyad *f = &p->output_fast_dyad[which];
    const int d[10] = { f->r2, f->e_in, f->b, f->e, f->beta < 0 ? -1 : p->angle[f->beta], f->d1, f->d2,
                        p->i_cx[which], p->i_cy[which], p->i_theta0 };
    double *row[10], *spare = k->spare + 2*k->nb;
    for (int i = 0; i < 10; i++)
        row[i] = d[i] < 0 ? spare : base + (size_t)d[i]*ld;
    return (bar_rows){ row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9],
                       input ? input : spare };
}

LW_INLINE void put_bars(const bar_rows *r, const bars *o, double turn, size_t i, const int pin, const int dyad)
{
    if (pin)
        r->r2[i] = o->r2;
    else
        r->e_in[i] = o->e_in;
    if (dyad == FAST_RRP)
        r->e[i] = o->e;
    else if (dyad == FAST_RRP_TURNED)
        r->beta[i] = o->beta;
    else
        r->b[i] = o->b;
    r->d1[i] = o->d1;
    if (dyad == FAST_RRR)
        r->d2[i] = o->d2;
    r->cx[i] = o->cx;
    r->cy[i] = o->cy;
    r->turn[i] = turn;
    r->input[i] = o->input;
}

LW_INLINE double fast_inverse(const lane *z)
{
    int firm = z->margin > LW_MARGIN_FLAT;
    return (firm ? 1.0 : 0.0)/(firm ? z->y : 1.0);
}

/* The derivatives of a loop: by the input alone; by all dimensions; of the angle, too. */
enum { TANGENT, JACOBIAN, JACOBIAN_ANGLE };

/* u, v, margin and rows of missing dimensions may be spare rows. */
LW_INLINE void fast_jacobian(const run *k, const number_rows *r, size_t n, const rows *out, const bar_rows bar[3],
                              const int form, const int pin, const int dyad)
{
    const double *c = k->c, *s = pin ? k->s : k->c;
    const numbers g = numbers_at(r, 0);
    const double flat = lw_rrr_flat(g.d1, g.d2), by_d2 = 1/lw_away_from_zero(g.d2);
    double *restrict x = out->x, *restrict y = out->y, *restrict u = out->u, *restrict v = out->v;
    double *restrict margin = out->margin;
    const bar_rows bx = bar[0], by = bar[1], bt = bar[2];
    LW_LANES(n) {
        double ci = c[i], si = s[i];
        lane z = fast_solve(ci, si, &g, flat, pin, dyad);
        double inv = fast_inverse(&z);
        lw_vec2 p = fast_point(&z, &g), d = lw_v2_turn(z.u, lw_v2(g.ct, g.st));
        bars ox = fast_back(ci, si, &g, &z, inv, by_d2, lw_v2(g.ct, -g.st), 0, pin, dyad);
        bars oy = fast_back(ci, si, &g, &z, inv, by_d2, lw_v2(g.st, g.ct), 0, pin, dyad);
        if (form == TANGENT) {
            bx.input[i] = ox.input;
            by.input[i] = oy.input;
        } else {
            put_bars(&bx, &ox, g.y0 - p.y, i, pin, dyad);
            put_bars(&by, &oy, p.x - g.x0, i, pin, dyad);
        }
        if (form == JACOBIAN_ANGLE) {
            bars ot = fast_back(ci, si, &g, &z, inv, by_d2, lw_v2(0, 0), 1, pin, dyad);
            put_bars(&bt, &ot, 1, i, pin, dyad);
        }
        x[i] = p.x;
        y[i] = p.y;
        u[i] = d.x;
        v[i] = d.y;
        margin[i] = z.margin;
    }
}

LW_INLINE void add_bars(sums *a, const bars *o, size_t j, const int pin, const int dyad)
{
    if (pin)
        a->r2[j] += o->r2;
    else
        a->e_in[j] += o->e_in;
    if (dyad == FAST_RRP)
        a->e[j] += o->e;
    else if (dyad == FAST_RRP_TURNED)
        a->beta[j] += o->beta;
    else
        a->b[j] += o->b;
    a->d1[j] += o->d1;
    if (dyad == FAST_RRR)
        a->d2[j] += o->d2;
    a->cx[j] += o->cx;
    a->cy[j] += o->cy;
}

LW_INLINE void fast_sum(const run *k, const number_rows *r, size_t n, const target *t, sums *total, const int weighted,
                         const int pin, const int dyad)
{
    const double *c = k->c, *s = pin ? k->s : k->c, *tx = t->x, *ty = t->y, *w = t->w;
    const numbers g = numbers_at(r, 0);
    const double flat = lw_rrr_flat(g.d1, g.d2), by_d2 = 1/lw_away_from_zero(g.d2);
    sums a = *total;
    for (size_t i = 0; i < n; i += LW_GROUP)
        for (size_t j = 0; j < LW_GROUP; j++) {
            double ci = c[i + j], si = s[i + j];
            lane z = fast_solve(ci, si, &g, flat, pin, dyad);
            lw_vec2 q = lw_v2_turn(lw_v2_add(z.a, z.arm), lw_v2(g.ct, g.st));
            double ex = q.x + g.x0 - tx[i + j], ey = q.y + g.y0 - ty[i + j];
            double hx = weighted ? w[i + j]*ex : ex, hy = weighted ? w[i + j]*ey : ey;
            bars o = fast_back(ci, si, &g, &z, fast_inverse(&z), by_d2, lw_v2(g.ct*hx + g.st*hy, g.ct*hy - g.st*hx), 0, pin, dyad);
            add_bars(&a, &o, j, pin, dyad);
            a.x0[j] += hx;
            a.y0[j] += hy;
            a.turn[j] += q.x*hy - q.y*hx;
            a.f[j] += ex*hx + ey*hy;
            a.margin[j] = z.margin < a.margin[j] ? z.margin : a.margin[j];
        }
    *total = a;
}

/* One copy of a loop for each kind of input and dyad. */
#define LW_EACH_DYAD(f, loop, pin, ...)                                                        \
    switch (fast_kind(f)) {                                                                   \
    case FAST_RRR:        loop(__VA_ARGS__, pin, FAST_RRR); break;                           \
    case FAST_RRP:        loop(__VA_ARGS__, pin, FAST_RRP); break;                           \
    case FAST_RRP_TURNED: loop(__VA_ARGS__, pin, FAST_RRP_TURNED); break;                    \
    default:               loop(__VA_ARGS__, pin, FAST_RPR);                                  \
    }
#define LW_EACH_FAST_DYAD(f, loop, ...)                                                            \
    do {                                                                                       \
        if (k->plan->input_is_slider)                                                          \
            LW_EACH_DYAD(f, loop, 0, __VA_ARGS__)                                              \
        else                                                                                   \
            LW_EACH_DYAD(f, loop, 1, __VA_ARGS__)                                              \
    } while (0)

void lw_fast_points(const run *k, int which, size_t n, const rows *out, int per_lane, int frame)
{
    const lw_fast_dyad *f = &k->plan->output_fast_dyad[which];
    const number_rows r = fast_rows(k, which);
    rows to = { out->x, out->y, out->u, out->v, out->margin ? out->margin : k->margin };
    int form = (frame ? FRAME : out->u ? PLACE_TURN : PLACE) + (out->margin || (out->u && !frame));
    switch (form + 8*per_lane) {
    case PLACE:                 LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 0, PLACE); break;
    case PLACE_MARGIN:          LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 0, PLACE_MARGIN); break;
    case PLACE_TURN_MARGIN:     LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 0, PLACE_TURN_MARGIN); break;
    case FRAME:                 LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 0, FRAME); break;
    case FRAME_MARGIN:          LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 0, FRAME_MARGIN); break;
    case 8 + PLACE:             LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 1, PLACE); break;
    case 8 + PLACE_MARGIN:      LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 1, PLACE_MARGIN); break;
    case 8 + PLACE_TURN_MARGIN: LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 1, PLACE_TURN_MARGIN); break;
    case 8 + FRAME:             LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 1, FRAME); break;
    default:                    LW_EACH_FAST_DYAD(f, fast_points, k, &r, n, &to, 1, FRAME_MARGIN);
    }
}

void lw_fast_sum(const run *k, int which, size_t n, const target *t, sums *a)
{
    const lw_fast_dyad *f = &k->plan->output_fast_dyad[which];
    const number_rows r = fast_rows(k, which);
    if (t->w)
        LW_EACH_FAST_DYAD(f, fast_sum, k, &r, n, t, a, 1);
    else
        LW_EACH_FAST_DYAD(f, fast_sum, k, &r, n, t, a, 0);
}

/* Set the derivatives by dimensions that the output does not depend on to 0. */
static void clear_others(const lw_plan *p, int which, size_t n, const lw_jacobian *out)
{
    const lw_fast_dyad *f = &p->output_fast_dyad[which];
    const int used[] = { f->r2, f->e_in, f->b, f->e, f->beta < 0 ? -1 : p->angle[f->beta], f->d1, f->d2, p->i_cx[which],
                         p->i_cy[which], p->i_x0, p->i_y0, p->i_theta0 };
    for (int d = 0; d < p->n_dim; d++) {
        bool any = false;
        for (size_t i = 0; i < sizeof used/sizeof *used; i++)
            any |= used[i] == d;
        if (any)
            continue;
        fill(out->jx + (size_t)d*out->ld, 0, n);
        fill(out->jy + (size_t)d*out->ld, 0, n);
        if (out->jt)
            fill(out->jt + (size_t)d*out->ld, 0, n);
    }
}

void lw_fast_jacobian(const run *k, int which, size_t n, const lw_jacobian *out)
{
    const lw_plan *p = k->plan;
    const lw_fast_dyad *f = &p->output_fast_dyad[which];
    const number_rows r = fast_rows(k, which);
    rows to = { out->x, out->y, out->u ? out->u : k->spare, out->v ? out->v : k->spare + k->nb,
                out->margin ? out->margin : k->margin };
    if (!out->jx) {
        const bar_rows tangent[3] = { { .input = out->tx }, { .input = out->ty ? out->ty : k->spare + 2*k->nb } };
        LW_EACH_FAST_DYAD(f, fast_jacobian, k, &r, n, &to, tangent, TANGENT);
        return;
    }
    if (p->n_output > 1 || p->n_link > 4)                  /* otherwise it depends on all */
        clear_others(p, which, n, out);
    bar_rows bar[3] = { fast_bars(k, which, out->jx, out->ld, out->tx),
                        fast_bars(k, which, out->jy, out->ld, out->ty) };
    if (out->jt) {
        bar[2] = fast_bars(k, which, out->jt, out->ld, out->tt);
        fill(out->jt + (size_t)p->i_x0*out->ld, 0, n);
        fill(out->jt + (size_t)p->i_y0*out->ld, 0, n);
        LW_EACH_FAST_DYAD(f, fast_jacobian, k, &r, n, &to, bar, JACOBIAN_ANGLE);
    } else
        LW_EACH_FAST_DYAD(f, fast_jacobian, k, &r, n, &to, bar, JACOBIAN);
    fill(out->jx + (size_t)p->i_x0*out->ld, 1, n);
    fill(out->jx + (size_t)p->i_y0*out->ld, 0, n);
    fill(out->jy + (size_t)p->i_x0*out->ld, 0, n);
    fill(out->jy + (size_t)p->i_y0*out->ld, 1, n);
}
