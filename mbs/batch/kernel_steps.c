/* Each kind of step as one loop over a block of lanes, forwards and backwards, by the formulas of
 * mbs/plan/steps_internal.h. */
#include "mbs/batch/kernel_run_internal.h"
#include "mbs/plan/plan_internal.h"
#include "mbs/plan/steps_internal.h"

/* ---- the rows of a step ------------------------------------------------------------------------------------
 * Constants wherever these functions are inlined: kind; per_lane: do dimensions and modes differ between lanes? */

/* Rows of the numbers of a step; a row of zeros for a dimension that it lacks. */
typedef struct number_rows { const double *dim[3], *mode, *c, *s; } number_rows;

LW_INLINE number_rows number_rows_of(const run *k, const lw_step *s, const lw_step_kind kind)
{
    const int dims = lw_step_dims(kind);
    number_rows r = { { dim_of(k, dims > 0 ? s->dim[0] : -1), dim_of(k, dims > 1 ? s->dim[1] : -1),
                        dim_of(k, dims > 2 ? s->dim[2] : -1) },
                      s->dyad < 0 ? reg_x(k, LW_ORIGIN_REG) : mode_of(k, s->dyad),
                      reg_x(k, LW_AXIS_REG), reg_y(k, LW_AXIS_REG) };
    if (lw_step_is_input(kind)) {
        r.c = k->c;
        r.s = kind == LW_STEP_INPUT_PIN ? k->s : k->c;
    } else if (kind == LW_STEP_LINE) {
        r.c = cos_of(k, s->dim[2]);
        r.s = sin_of(k, s->dim[2]);
    }
    return r;
}

LW_INLINE lw_step_numbers numbers_at(const number_rows *r, const lw_step *s, size_t i, const lw_step_kind kind)
{
    lw_step_numbers q = { { r->dim[0][i], r->dim[1][i], r->dim[2][i] }, r->mode[i], { 0, 0 }, 0,
                          lw_v2(r->c[i], r->s[i]), { s->power[0], s->power[1] } };
    lw_step_prepare(kind, &q);
    return q;
}

/* Registers of input and output h; the origin for one that is not used.  Only gears and RRR may lack one. */
LW_INLINE int in_of(const lw_step *s, const lw_step_kind kind, const int h)
{
    return h >= lw_step_inputs(kind) || (kind == LW_STEP_GEAR && s->in[h] < 0) ? LW_ORIGIN_REG : s->in[h];
}
LW_INLINE int out_of(const lw_step *s, const lw_step_kind kind, const int h)
{
    return h >= lw_step_outputs(kind) || (kind == LW_STEP_RRR && h == 1 && s->out[h] < 0) ? LW_ORIGIN_REG : s->out[h];
}

/* ---- steps forwards ------------------------------------------------------------------------------------- */

/* Keep the least margin, and the reciprocal that derivatives need (0 where they do not exist). */
LW_INLINE void keep_margin(double *margin, double *aux, double m, double y, const int outputs)
{
    if (outputs >= WITH_MARGIN)
        *margin = lw_at_most(m, *margin);
    if (outputs == WITH_ROOTS && aux)
        *aux = (m > LW_MARGIN_FLAT ? 1.0 : 0.0)/(m > LW_MARGIN_FLAT ? y : 1.0);
}

/* One step over n lanes.  keep: bit h, is output h stored?  met: are all circles of RRR assumed to meet?  Returns false
 * if that is wrong. */
LW_INLINE bool forward_lanes(const run *k, const lw_step *s, size_t n, const lw_step_kind kind, const int per_lane,
                             const int outputs, const int keep, const int met)
{
    const int dyad = kind >= LW_STEP_RRR && kind <= LW_STEP_PPR;
    const in_rows a = in_reg(k, in_of(s, kind, 0)), b = in_reg(k, in_of(s, kind, 1));
    const in_rows c = in_reg(k, in_of(s, kind, 2)), d = in_reg(k, in_of(s, kind, 3));
    const out_rows o = out_reg(k, out_of(s, kind, 0)), p = out_reg(k, out_of(s, kind, 1));
    const out_rows t = out_reg(k, out_of(s, kind, 2));
    const number_rows r = number_rows_of(k, s, kind);
    const lw_step_numbers shared = numbers_at(&r, s, 0, kind);
    double *margin = k->margin, *aux = aux_row(k, dyad ? s->dyad : 0);
    long long open = 0;
    LW_LANES(n) {
        lw_step_lane z;
        lw_step_numbers q = per_lane ? numbers_at(&r, s, i, kind) : shared;
        if (lw_step_is_input(kind))
            q.turn = lw_v2(r.c[i], r.s[i]);
        z.in[0] = get(a, i);
        z.in[1] = get(b, i);
        z.in[2] = get(c, i);
        z.in[3] = get(d, i);
        lw_step_value(kind, &z, &q, met);
        if (kind == LW_STEP_RRR)
            open |= z.open;
        if (outputs && (dyad || kind == LW_STEP_RACK))
            keep_margin(&margin[i], dyad ? &aux[i] : NULL, z.margin, dyad ? z.root : 1, outputs);
        if (keep & 1)
            put(o, i, z.out[0]);
        if (keep & 2)
            put(p, i, z.out[1]);
        if (keep & 4)
            put(t, i, z.out[2]);
    }
    return !(met && open);
}

/* Try first the cheaper loop for circles that all meet.  Both loops give the same bits in lanes whose circles meet. */
LW_INLINE void forward_rrr(const run *k, const lw_step *s, size_t n, const int per_lane, const int outputs, const int keep)
{
    if (!forward_lanes(k, s, n, LW_STEP_RRR, per_lane, outputs, keep, 1))
        forward_lanes(k, s, n, LW_STEP_RRR, per_lane, outputs, keep, 0);
}

/* As lw_step_value, whose number of products would be another in each step: one product after the other over all
 * lanes. */
LW_INLINE void forward_gear(const run *k, const lw_step *s, size_t n, const int per_lane)
{
    const out_rows o = out_reg(k, s->out[0]);
    const double *c = s->dim[0] < 0 ? reg_x(k, 1) : cos_of(k, s->dim[2]);
    const double *t = s->dim[0] < 0 ? reg_y(k, 1) : sin_of(k, s->dim[2]);
    const double c0 = *c, t0 = *t;
    LW_LANES(n) put(o, i, lw_v2(per_lane && s->dim[0] >= 0 ? c[i] : c0, per_lane && s->dim[0] >= 0 ? t[i] : t0));
    for (int h = 0; h < 2 && s->in[h] >= 0; h++)
        for (int m = 0; m < (s->power[h] < 0 ? -s->power[h] : s->power[h]); m++) {
            const in_rows u = in_reg(k, s->in[h]);
            const double sign = s->power[h] < 0 ? -1 : 1;
            LW_LANES(n) put(o, i, lw_v2_turn(lw_v2(o.x[i], o.y[i]), lw_v2(u.x[i], sign*u.y[i])));
        }
}

LW_INLINE void forward_kind(const run *k, const lw_step *s, int keep, size_t n, const lw_step_kind kind,
                            const int per_lane, const int outputs)
{
    if (kind == LW_STEP_RRR)
        switch ((s->out[1] < 0 ? keep & 1 : keep & 3) | (outputs == WITH_ROOTS)) {
        case 0:  forward_rrr(k, s, n, per_lane, outputs, 4); break;
        case 1:  forward_rrr(k, s, n, per_lane, outputs, 5); break;
        case 2:  forward_rrr(k, s, n, per_lane, outputs, 6); break;
        default: forward_rrr(k, s, n, per_lane, outputs, 7);
        }
    else if (kind == LW_STEP_GEAR)
        forward_gear(k, s, n, per_lane);
    else
        forward_lanes(k, s, n, kind, per_lane, outputs, (1 << lw_step_outputs(kind)) - 1, 0);
}

/* One copy of each loop for each combination of per_lane and outputs. */
LW_INLINE void step_forward(const run *k, const lw_step *s, int keep, size_t n, const int per_lane, const int outputs)
{
    switch (s->kind) {
#define X(name, ...) case LW_STEP_##name: forward_kind(k, s, keep, n, LW_STEP_##name, per_lane, outputs); break;
    LW_STEP_LIST(X)
#undef X
    case LW_STEP_HIGHER: break;                            /* see lw_forward */
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

/* Add the adjoint of input h, a point or a direction. */
LW_INLINE void add_bar(const lw_step_kind kind, const int h, out_rows to, size_t i, const lw_step_lane *z)
{
    if (lw_step_points(kind) >> h & 1)
        add_to(to, i, z->in_bar[h]);
    else if (h < lw_step_inputs(kind))
        to.x[i] += z->in_bar[h].x;
}

/* Adjoints of input h; spare rows for one that a gear lacks. */
LW_INLINE out_rows in_bar_of(const run *k, const lw_step *s, const lw_step_kind kind, const int h)
{
    return kind == LW_STEP_GEAR && s->in[h] < 0 ? (out_rows){ k->spare, k->spare + k->nb }
                                                : out_bar(k, in_of(s, kind, h));
}

/* Adjoints of output h; zeros for one that the step lacks. */
LW_INLINE in_rows out_bar_of(const run *k, const lw_step *s, const lw_step_kind kind, const int h)
{
    const int lacks = h >= lw_step_outputs(kind) || (kind == LW_STEP_RRR && h == 1 && s->out[h] < 0);
    return lacks ? in_reg(k, LW_ORIGIN_REG) : in_bar(k, s->out[h]);
}

LW_INLINE void back_lanes(const run *k, const lw_step *s, size_t n, double *input_bar, const lw_step_kind kind)
{
    const int dyad = kind >= LW_STEP_RRR && kind <= LW_STEP_PPR, dims = lw_step_dims(kind);
    const in_rows a = in_reg(k, in_of(s, kind, 0)), b = in_reg(k, in_of(s, kind, 1));
    const in_rows c = in_reg(k, in_of(s, kind, 2)), d = in_reg(k, in_of(s, kind, 3));
    const in_rows o = in_reg(k, out_of(s, kind, 0)), p = in_reg(k, out_of(s, kind, 1));
    const in_rows o_bar = out_bar_of(k, s, kind, 0), p_bar = out_bar_of(k, s, kind, 1);
    const in_rows t_bar = out_bar_of(k, s, kind, 2);
    const out_rows a_bar = in_bar_of(k, s, kind, 0), b_bar = in_bar_of(k, s, kind, 1);
    const out_rows c_bar = in_bar_of(k, s, kind, 2), d_bar = in_bar_of(k, s, kind, 3);
    double *x_bar = dim_bar(k, dims > 0 ? s->dim[0] : -1), *y_bar = dim_bar(k, dims > 1 ? s->dim[1] : -1);
    const number_rows r = number_rows_of(k, s, kind);
    const lw_step_numbers shared = numbers_at(&r, s, 0, kind);
    const double *inv = aux_row(k, dyad ? s->dyad : 0);
    LW_LANES(n) {
        lw_step_lane z;
        lw_step_numbers q = shared;
        if (lw_step_is_input(kind))
            q.turn = lw_v2(r.c[i], r.s[i]);
        z.in[0] = get(a, i);
        z.in[1] = get(b, i);
        z.in[2] = get(c, i);
        z.in[3] = get(d, i);
        z.out[0] = get(o, i);
        z.out[1] = get(p, i);
        z.out_bar[0] = get(o_bar, i);
        z.out_bar[1] = get(p_bar, i);
        z.out_bar[2] = get(t_bar, i);
        z.inv = dyad ? inv[i] : 0;
        lw_step_back(kind, &z, &q);
        if (lw_step_is_input(kind))
            input_bar[i] += z.input_bar;
        if (dims > 0)
            x_bar[i] += z.dim_bar[0];
        if (dims > 1)
            y_bar[i] += z.dim_bar[1];
        add_bar(kind, 0, a_bar, i, &z);
        add_bar(kind, 1, b_bar, i, &z);
        add_bar(kind, 2, c_bar, i, &z);
        add_bar(kind, 3, d_bar, i, &z);
    }
}

void lw_backward(const run *k, int which, size_t n, double *input_bar)
{
    const lw_plan *p = k->plan;
    for (int i = n_step_of(p, which) - 1; i >= 0; i--) {
        const lw_step *s = step_of(p, which, i);
        switch (s->kind) {
#define X(name, ...) case LW_STEP_##name: back_lanes(k, s, n, input_bar, LW_STEP_##name); break;
        LW_STEP_LIST(X)
#undef X
        case LW_STEP_HIGHER: lw_higher_backward(k, s, n); break;
        }
    }
}

/* ---- the margin and its adjoints ------------------------------------------------------------------------ */

/* Margin of step s in lane i.  With `seed` also add its adjoints.  Steps without a margin and higher groups: 1. */
static double step_margin(const run *k, const lw_step *s, size_t i, bool seed)
{
    if (s->dyad < 0 && s->kind != LW_STEP_RACK)
        return 1;
    const int inputs = lw_step_inputs(s->kind), dims = lw_step_dims(s->kind);
    lw_step_lane z = { .margin = 1 };
    lw_step_numbers q = { .mode = 1 };
    for (int h = 0; h < inputs; h++)
        z.in[h] = get(in_reg(k, s->in[h]), i);
    for (int h = 0; h < dims; h++)
        q.dim[h] = *dim_of(k, s->dim[h]);
    lw_step_prepare(s->kind, &q);
    lw_step_value(s->kind, &z, &q, 0);
    if (!seed)
        return z.margin;
    lw_step_margin_back(s->kind, &z, &q);
    for (int h = 0; h < inputs; h++)
        add_to(out_bar(k, s->in[h]), i, z.in_bar[h]);
    for (int h = 0; h < dims; h++)
        dim_bar(k, s->dim[h])[i] += z.dim_bar[h];
    return z.margin;
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
