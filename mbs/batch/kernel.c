/* Run the steps of a plan over blocks of lanes, from the caller's arrays to the caller's arrays. */
#include "mbs/batch/kernel_run_internal.h"

/* ---- lanes in blocks ----------------------------------------------------------------------------------- */

/* Does the loop of its own compute this? It knows no pins, no derivatives of margins, and no places alone. */
static bool is_fast(const lw_plan *p, int which, const lw_jacobian *out)
{
    return which >= 0 && p->output_fast_dyad[which].applies && !(out && (out->jm || !(out->jx || out->tx)));
}

static void set_ground(const run *k, bool fast) { ground_rows(k, fast ? 0 : k->nb); }

/* Lanes per block.  Points of a fast-dyad plan with one set of dimensions use no rows of the block: all lanes are one
 * block.  Frames of many candidates read only zeros beside the caller's numbers. */
static size_t block_size(const lw_plan *plan, const lw_lanes *in, int which, const rows *out, int frame)
{
    const lw_fast_dyad *f = &plan->output_fast_dyad[which];
    if (!f->applies || (!out->margin && out->u && !frame))
        return LW_BLOCK_LANES;
    if (!in->dim_stride && !in->mode_stride)
        return (size_t)-1;
    return frame && f->beta < 0 && in->dim_stride && in->mode_stride ? LW_ZEROS : LW_BLOCK_LANES;
}

/* Copy one set of numbers to every lane. */
static void spread(double *to, const double *from, int count, size_t nb)
{
    for (int d = 0; d < count; d++)
        for (size_t i = 0; i < nb; i++)
            to[(size_t)d*nb + i] = from[d];
}

/* Set dimensions and modes of the lanes: both shared, or both per lane.  Returns whether they are per lane. */
static int set_numbers(run *k, const lw_lanes *in, size_t first)
{
    int per_lane = in->dim_stride || in->mode_stride;
    k->dim = in->dim_stride ? in->dim + first : in->dim;
    k->dim_row = in->dim_stride ? in->dim_stride : 1;
    k->mode = in->mode_stride ? in->mode + first : in->mode;
    k->mode_row = in->mode_stride ? in->mode_stride : 1;
    if (per_lane && !in->dim_stride) {
        if (first == 0)
            spread(k->spread_dim, in->dim, k->plan->n_dim, k->nb);
        k->dim = k->spread_dim;
        k->dim_row = k->nb;
    }
    if (per_lane && !in->mode_stride) {
        if (first == 0)
            spread(k->spread_mode, in->mode, k->plan->n_mode, k->nb);
        k->mode = k->spread_mode;
        k->mode_row = k->nb;
    }
    return per_lane;
}

/* Set the inputs and the postures of higher groups, from lane `first` on. */
static void at_lanes(run *k, const lw_lanes *in, size_t first)
{
    k->c = in->c + first;
    k->s = in->s ? in->s + first : NULL;
    k->group_posture = k->group_postures ? k->group_postures + first : NULL;
    k->group_posture_row = LW_CHUNK + LW_GROUP;
}

/* Copy the lanes from `first` on, fewer than a group, to a full group that repeats the last lane. */
static lw_lanes pad(const run *k, const lw_lanes *in, size_t first)
{
    const lw_plan *p = k->plan;
    double *c = k->tail, *s = c + LW_GROUP, *mode = s + LW_GROUP, *dim = mode + (size_t)p->n_mode*LW_GROUP;
    lw_lanes out = { LW_GROUP, c, s, in->dim_stride ? dim : in->dim, in->dim_stride ? LW_GROUP : 0,
                     in->mode_stride ? mode : in->mode, in->mode_stride ? LW_GROUP : 0 };
    for (size_t i = 0; i < LW_GROUP; i++) {
        size_t from = first + i < in->n ? first + i : in->n - 1;
        c[i] = in->c[from];
        s[i] = p->input_is_slider ? 0 : in->s[from];
        for (int d = 0; in->dim_stride && d < p->n_dim; d++)
            dim[(size_t)d*LW_GROUP + i] = in->dim[(size_t)d*in->dim_stride + from];
        for (int d = 0; in->mode_stride && d < p->n_mode; d++)
            mode[(size_t)d*LW_GROUP + i] = in->mode[(size_t)d*in->mode_stride + from];
    }
    return out;
}

/* Row i of the outputs of a padded group, behind its inputs. */
static double *tail_row(const run *k, size_t i)
{
    return k->tail + (2 + (size_t)k->plan->n_mode + (size_t)k->plan->n_dim + i)*LW_GROUP;
}

static rows tail_places(const run *k)
{
    return (rows){ tail_row(k, 0), tail_row(k, 1), tail_row(k, 2), tail_row(k, 3), tail_row(k, 4) };
}

static void copy_out(double *to, const double *from, size_t n)
{
    if (to)
        memcpy(to, from, n*sizeof *to);
}

static double *at(double *row, size_t first) { return row ? row + first : NULL; }

/* ---- points and frames ----------------------------------------------------------------------------------- */

/* Move into the plane: turn by theta0, and shift points by x0, y0. */
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
    int per_lane = set_numbers(k, in, first), outputs = out->margin ? WITH_MARGIN : POSTURE_ONLY;
    at_lanes(k, in, first);
    if (per_lane || first == 0)
        set_turns(k, p->n_angle - frame, per_lane, n);
    if (p->output_fast_dyad[which].applies) {
        lw_fast_points(k, which, n, out, per_lane, frame);
        return;
    }
    lw_forward(k, which, n, per_lane, outputs);
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

static rows shift_rows(const rows *o, size_t first)
{
    return (rows){ at(o->x, first), at(o->y, first), at(o->u, first), at(o->v, first), at(o->margin, first) };
}

static void few_points(run *k, const lw_lanes *in, int which, const rows *out, int frame)
{
    lw_lanes lanes = pad(k, in, 0);
    rows to = tail_places(k);
    block_point(k, &lanes, which, 0, LW_GROUP, &to, frame);
    copy_out(out->x, to.x, in->n);
    copy_out(out->y, to.y, in->n);
    copy_out(out->u, to.u, in->n);
    copy_out(out->v, to.v, in->n);
    copy_out(out->margin, to.margin, in->n);
}

/* Compute whole groups in blocks.  The remaining lanes are computed as one more group, which overlaps the last one. */
static void points(const lw_plan *plan, const lw_lanes *in, int which, void *work, const double *group_postures, const rows *out, int frame)
{
    run k = start(plan, in->n, work);
    k.group_postures = group_postures;
    size_t full = in->n/LW_GROUP*LW_GROUP, block = block_size(plan, in, which, out, frame);
    set_ground(&k, is_fast(plan, which, NULL));
    if (in->n > 0 && in->n < LW_GROUP)
        few_points(&k, in, which, out, frame);
    for (size_t first = 0; first < full; first += block) {
        rows to = shift_rows(out, first);
        block_point(&k, in, which, first, full - first < block ? full - first : block, &to, frame);
    }
    if (full && full < in->n) {
        rows to = shift_rows(out, in->n - LW_GROUP);
        block_point(&k, in, which, in->n - LW_GROUP, LW_GROUP, &to, frame);
    }
}

/* Arguments of `points` for the chunks of a plan with higher groups. */
typedef struct chunk_points { const lw_plan *plan; int which, frame; const rows *out; } chunk_points;

static void points_of_chunk(void *caller, const lw_lanes *part, size_t first, void *work, const double *group_postures)
{
    const chunk_points *q = caller;
    rows to = shift_rows(q->out, first);
    points(q->plan, part, q->which, work, group_postures, &to, q->frame);
}

static void all_points(const lw_plan *plan, const lw_lanes *in, int which, void *work, const rows *out, int frame)
{
    if (plan->n_higher)
        lw_in_chunks(plan, in, work, points_of_chunk, &(chunk_points){ plan, which, frame, out });
    else
        points(plan, in, which, work, NULL, out, frame);
}

static void kernel_point(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                         double *x, double *y, double *u, double *v, double *margin)
{
    all_points(plan, in, which, work, &(rows){ x, y, u, v, margin }, 0);
}

static void kernel_frame(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                         double *ox, double *oy, double *dx, double *dy, double *margin)
{
    all_points(plan, in, which, work, &(rows){ ox, oy, dx, dy, margin }, 1);
}

/* ---- Jacobian --------------------------------------------------------------------------------------------- */

/* Clear the adjoints.  Derivatives by the dimensions will go to `row`, by the input to `input`.  row NULL: those by the
 * dimensions are not wanted; all of them go to one spare row. */
static void clear_adjoints(run *k, size_t n, double *row, size_t ld, double *input)
{
    const lw_plan *p = k->plan;
    k->row = row ? row : k->spare + 2*k->nb;
    k->row_row = row ? ld : 0;
    memset(k->bar, 0, 2*(size_t)p->n_reg*k->nb*sizeof(double));
    memset(input, 0, n*sizeof(double));
    for (int i = 0; row && i < p->n_dim; i++)
        memset(row + (size_t)i*ld, 0, n*sizeof(double));
}

static int point_of(const lw_plan *p, int which)
{
    return which < 0 ? p->joint_point[-1 - which] : p->output_point[which];
}

static int direction_of(const lw_plan *p, int which) { return which < 0 ? 1 : p->output_dir[which]; }

/* Derivatives of one component of the output.  seed, turn: adjoints of its point and direction. */
static void component(run *k, int which, size_t n, lw_vec2 seed, double turn, double *row, size_t ld, double *input)
{
    double *px = bar_x(k, point_of(k->plan, which)), *py = bar_y(k, point_of(k->plan, which));
    double *d = bar_x(k, direction_of(k->plan, which));
    clear_adjoints(k, n, row, ld, input);
    for (size_t i = 0; i < n; i++) {
        px[i] = seed.x;
        py[i] = seed.y;
        d[i] += turn;
    }
    lw_backward(k, which, n, input);
}

static void margin_component(run *k, int which, size_t n, const lw_jacobian *out, double *scrap)
{
    bool known[LW_BLOCK_LANES];
    double *input = out->tm ? out->tm : scrap;
    clear_adjoints(k, n, out->jm, out->ld, input);
    lw_seed_margin(k, which, n, known);
    lw_backward(k, which, n, input);
    for (size_t i = 0; i < n; i++)
        for (int d = 0; !known[i] && d <= k->plan->n_dim; d++)
            *(d < k->plan->n_dim ? &out->jm[(size_t)d*out->ld + i] : &input[i]) = NAN;
}

static void block_jacobian(run *k, const lw_lanes *in, int which, size_t first, size_t n, const lw_jacobian *out)
{
    const lw_plan *p = k->plan;
    set_numbers(k, in, first);
    at_lanes(k, in, first);
    if (first == 0)
        set_turns(k, p->n_angle, 0, n);
    if (is_fast(p, which, out)) {
        lw_fast_jacobian(k, which, n, out);
        return;
    }
    lw_forward(k, which, n, 0, WITH_ROOTS);
    copy_out(out->margin, k->margin, n);
    move_out(k, n, point_of(p, which), out->x, out->y, 0, 1);
    if (out->u && out->v)
        move_out(k, n, direction_of(p, which), out->u, out->v, 0, 0);
    if (out->jm)
        margin_component(k, which, n, out, k->spare + k->nb);
    if (!out->jx && !out->tx)
        return;
    double c = *cos_of(k, p->n_angle - 1), s = *sin_of(k, p->n_angle - 1), *scrap = k->spare + k->nb;
    component(k, which, n, lw_v2(c, -s), 0, out->jx, out->ld, out->tx ? out->tx : scrap);
    component(k, which, n, lw_v2(s, c), 0, out->jx ? out->jy : NULL, out->ld, out->ty ? out->ty : scrap);
    if (!out->jx)
        return;
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
                          at(o->tt, first), o->ld, at(o->jm, first), at(o->tm, first) };
}

static void copy_jacobian(const lw_jacobian *to, const lw_jacobian *from, int n_dim, size_t n)
{
    double *const single[][2] = { { to->x, from->x }, { to->y, from->y }, { to->u, from->u }, { to->v, from->v },
                                  { to->margin, from->margin }, { to->tx, from->tx }, { to->ty, from->ty },
                                  { to->tt, from->tt }, { to->tm, from->tm } };
    for (size_t i = 0; i < sizeof single/sizeof *single; i++)
        copy_out(single[i][0], single[i][1], n);
    double *const each[][2] = { { to->jx, from->jx }, { to->jx ? to->jy : NULL, from->jy }, { to->jt, from->jt },
                                { to->jm, from->jm } };
    for (size_t i = 0; i < sizeof each/sizeof *each; i++)
        for (int d = 0; each[i][0] && d < n_dim; d++)
            copy_out(each[i][0] + (size_t)d*to->ld, each[i][1] + (size_t)d*from->ld, n);
}

static void few_jacobian(run *k, const lw_lanes *in, int which, const lw_jacobian *out)
{
    lw_lanes lanes = pad(k, in, 0);
    size_t n_dim = (size_t)k->plan->n_dim;
    rows t = tail_places(k);
    lw_jacobian to = { t.x, t.y, t.u, t.v, t.margin, out->jx ? tail_row(k, 8) : NULL, tail_row(k, 8 + n_dim),
                       out->jt ? tail_row(k, 8 + 2*n_dim) : NULL, out->jx || out->tx ? tail_row(k, 5) : NULL, tail_row(k, 6), tail_row(k, 7),
                       LW_GROUP, out->jm ? tail_row(k, 9 + 3*n_dim) : NULL, tail_row(k, 8 + 3*n_dim) };
    block_jacobian(k, &lanes, which, 0, LW_GROUP, &to);
    copy_jacobian(out, &to, k->plan->n_dim, in->n);
}

/* The places of several pins and outputs, whose postures are worked out once, and the margin of the whole plan; at least
 * LW_GROUP lanes. */
static void places(const lw_plan *plan, const lw_lanes *in, int n, const int *which, void *work, const lw_jacobian *out)
{
    run k = start(plan, in->n, work);
    set_ground(&k, false);
    for (size_t done = 0, lanes; done < in->n; done += lanes) {
        size_t rest = in->n - done, first = rest < LW_GROUP ? in->n - LW_GROUP : done;
        lanes = rest < LW_BLOCK_LANES ? rest < LW_GROUP ? LW_GROUP : rest/LW_GROUP*LW_GROUP : LW_BLOCK_LANES;
        set_numbers(&k, in, first);
        at_lanes(&k, in, first);
        if (first == 0)
            set_turns(&k, plan->n_angle, 0, lanes);
        lw_forward(&k, LW_BATCH_JOINT(0), lanes, 0, WITH_MARGIN);
        for (int i = 0; i < n; i++) {
            move_out(&k, lanes, point_of(plan, which[i]), out[i].x + first, out[i].y + first, 0, 1);
            copy_out(at(out[i].margin, first), k.margin, lanes);
        }
    }
}

static void jacobians(const lw_plan *plan, const lw_lanes *in, int which, void *work, const double *group_postures, const lw_jacobian *out)
{
    run k = start(plan, in->n, work);
    k.group_postures = group_postures;
    size_t full = in->n/LW_GROUP*LW_GROUP;
    set_ground(&k, is_fast(plan, which, out));
    if (in->n > 0 && in->n < LW_GROUP)
        few_jacobian(&k, in, which, out);
    for (size_t first = 0; first < full; first += LW_BLOCK_LANES) {
        lw_jacobian to = shift_jacobian(out, first);
        block_jacobian(&k, in, which, first, full - first < LW_BLOCK_LANES ? full - first : LW_BLOCK_LANES, &to);
    }
    if (full && full < in->n) {
        lw_jacobian to = shift_jacobian(out, in->n - LW_GROUP);
        block_jacobian(&k, in, which, in->n - LW_GROUP, LW_GROUP, &to);
    }
}

typedef struct chunk_jacobian { const lw_plan *plan; int n; const int *which; const lw_jacobian *out; } chunk_jacobian;

static void jacobian_of_chunk(void *caller, const lw_lanes *part, size_t first, void *work, const double *group_postures)
{
    const chunk_jacobian *q = caller;
    for (int i = 0; i < q->n; i++) {
        lw_jacobian to = shift_jacobian(&q->out[i], first);
        jacobians(q->plan, part, q->which[i], work, group_postures, &to);
    }
}

static void kernel_jacobians(const lw_plan *plan, const lw_lanes *in, int n, const int *which, void *work, const lw_jacobian *out)
{
    bool only_places = n > 1 && !plan->n_higher && in->n >= LW_GROUP;
    for (int i = 0; i < n; i++)
        only_places &= !out[i].jx && !out[i].tx && !out[i].jm && !out[i].u && (which[i] < 0 || !out[i].margin);
    if (only_places) {
        places(plan, in, n, which, work, out);
        return;
    }
    if (plan->n_higher && n > 0)
        lw_in_chunks(plan, in, work, jacobian_of_chunk, &(chunk_jacobian){ plan, n, which, out });
    for (int i = 0; i < n && !plan->n_higher; i++)
        jacobians(plan, in, which[i], work, NULL, &out[i]);
}

/* ---- sum of squares with gradient ---------------------------------------------------------------------------- */

/* Add lane i to sum i modulo eight, so that the vector width does not change the order of additions. */
static void accumulate(double *acc, const double *row, size_t n)
{
    double a0 = acc[0], a1 = acc[1], a2 = acc[2], a3 = acc[3], a4 = acc[4], a5 = acc[5], a6 = acc[6], a7 = acc[7];
    for (size_t i = 0; i < n; i += LW_GROUP) {
        a0 += row[i];
        a1 += row[i + 1];
        a2 += row[i + 2];
        a3 += row[i + 3];
        a4 += row[i + 4];
        a5 += row[i + 5];
        a6 += row[i + 6];
        a7 += row[i + 7];
    }
    acc[0] = a0; acc[1] = a1; acc[2] = a2; acc[3] = a3; acc[4] = a4; acc[5] = a5; acc[6] = a6; acc[7] = a7;
}

static double total(const double *acc)
{
    return ((acc[0] + acc[4]) + (acc[2] + acc[6])) + ((acc[1] + acc[5]) + (acc[3] + acc[7]));
}

/* From the residuals: f, its derivatives by x0, y0, theta0, and the adjoint of the point in the ground frame. */
LW_INLINE void seed_sum(const run *k, int which, size_t n, const target *t, double *restrict f, const int weighted)
{
    const lw_plan *p = k->plan;
    const double c = *cos_of(k, p->n_angle - 1), s = *sin_of(k, p->n_angle - 1), x0 = k->dim[p->i_x0],
        y0 = k->dim[p->i_y0];
    const double *px = reg_x(k, p->output_point[which]), *py = reg_y(k, p->output_point[which]);
    const double *tx = t->x, *ty = t->y, *w = t->w;
    double *restrict bx = bar_x(k, p->output_point[which]), *restrict by = bar_y(k, p->output_point[which]);
    double *restrict gx = dim_bar(k, p->i_x0), *restrict gy = dim_bar(k, p->i_y0),
        *restrict gt = dim_bar(k, p->i_theta0);
    LW_LANES(n) {
        lw_vec2 q = lw_v2_turn(lw_v2(px[i], py[i]), lw_v2(c, s));
        double ex = q.x + x0 - tx[i], ey = q.y + y0 - ty[i], hx = weighted ? w[i]*ex : ex, hy = weighted ? w[i]*ey : ey;
        f[i] = ex*hx + ey*hy;
        gx[i] = 2*hx;
        gy[i] = 2*hy;
        gt[i] = 2*(q.x*hy - q.y*hx);
        bx[i] = 2*(c*hx + s*hy);
        by[i] = 2*(c*hy - s*hx);
    }
}

static void block_sum(run *k, const lw_lanes *in, int which, size_t first, size_t n, const target *t, double *acc)
{
    const lw_plan *p = k->plan;
    double *scrap = k->spare + k->nb, *f = scrap + k->nb;
    set_numbers(k, in, first);
    at_lanes(k, in, first);
    lw_forward(k, which, n, 0, WITH_ROOTS);
    memset(k->bar, 0, 2*(size_t)p->n_reg*k->nb*sizeof(double));
    memset(k->row, 0, (size_t)p->n_dim*k->nb*sizeof(double));
    if (t->w)
        seed_sum(k, which, n, t, f, 1);
    else
        seed_sum(k, which, n, t, f, 0);
    lw_backward(k, which, n, scrap);
    for (int d = 0; d < p->n_dim; d++)
        accumulate(acc + d*LW_GROUP, dim_bar(k, d), n);
    accumulate(acc + p->n_dim*LW_GROUP, f, n);
}

static void keep_least(double *restrict acc, const double *margin, size_t n)
{
    for (size_t i = 0; i < n; i += LW_GROUP)
        for (size_t j = 0; j < LW_GROUP; j++)
            acc[j] = lw_at_most(margin[i + j], acc[j]);
}

/* Write the sums of a fast-dyad plan to the gradient by its dimensions; 2 comes from the square. */
static void scatter(const lw_plan *p, int which, const sums *a, double *grad)
{
    const lw_fast_dyad *f = &p->output_fast_dyad[which];
    const struct { int dim; const double *acc; } to[] = {
        { f->r2, a->r2 }, { f->e_in, a->e_in }, { f->b, a->b }, { f->e, a->e },
        { f->beta < 0 ? -1 : p->angle[f->beta], a->beta },
        { f->d1, a->d1 }, { f->d2, a->d2 }, { p->i_cx[which], a->cx }, { p->i_cy[which], a->cy },
        { p->i_x0, a->x0 }, { p->i_y0, a->y0 }, { p->i_theta0, a->turn }
    };
    for (int d = 0; d < p->n_dim; d++)
        grad[d] = 0;
    for (size_t i = 0; i < sizeof to/sizeof *to; i++)
        if (to[i].dim >= 0)
            grad[to[i].dim] = 2*total(to[i].acc);
}

/* Targets of a padded group; the padding has weight 0. */
static target pad_target(const run *k, const target *t, size_t first, size_t rest)
{
    double *x = tail_row(k, 0), *y = tail_row(k, 1), *w = tail_row(k, 2);
    for (size_t i = 0; i < LW_GROUP; i++) {
        x[i] = i < rest ? t->x[first + i] : 0;
        y[i] = i < rest ? t->y[first + i] : 0;
        w[i] = i >= rest ? 0 : t->w ? t->w[first + i] : 1;
    }
    return (target){ x, y, w };
}

static double least8(const double *m)
{
    double a = m[0];
    for (int i = 1; i < LW_GROUP; i++)
        a = m[i] < a ? m[i] : a;
    return a;
}

static double fast_kernel_sum(run *k, const lw_lanes *in, int which, const target *t, double *grad, double *margin)
{
    size_t full = in->n/LW_GROUP*LW_GROUP, rest = in->n - full;
    sums a = { .margin = { 1, 1, 1, 1, 1, 1, 1, 1 } };
    k->c = in->c;
    k->s = in->s;
    lw_fast_sum(k, which, full, t, &a);
    if (rest) {
        lw_lanes last = pad(k, in, full);
        target here = pad_target(k, t, full, rest);
        k->c = last.c;
        k->s = last.s;
        lw_fast_sum(k, which, LW_GROUP, &here, &a);
    }
    if (grad)
        scatter(k->plan, which, &a, grad);
    if (margin)
        *margin = least8(a.margin);
    return total(a.f);
}

static double lane_sum(const lw_plan *plan, const lw_lanes *in, int which, void *work, const double *group_postures,
                       const double *tx, const double *ty, const double *w, double *grad, double *margin)
{
    run k = start(plan, in->n, work);
    k.group_postures = group_postures;
    target t = { tx, ty, w };
    size_t full = in->n/LW_GROUP*LW_GROUP, rest = in->n - full;
    double *acc = tail_row(&k, 3), smallest[LW_GROUP] = { 1, 1, 1, 1, 1, 1, 1, 1 };
    memset(acc, 0, (size_t)(plan->n_dim + 1)*LW_GROUP*sizeof(double));
    set_ground(&k, is_fast(plan, which, NULL));
    set_numbers(&k, in, 0);
    set_turns(&k, plan->n_angle, 0, 1);
    if (plan->output_fast_dyad[which].applies)
        return fast_kernel_sum(&k, in, which, &t, grad, margin);
    for (size_t first = 0; first < full; first += LW_BLOCK_LANES) {
        size_t n = full - first < LW_BLOCK_LANES ? full - first : LW_BLOCK_LANES;
        target here = { tx + first, ty + first, w ? w + first : NULL };
        block_sum(&k, in, which, first, n, &here, acc);
        keep_least(smallest, k.margin, n);
    }
    if (rest) {
        lw_lanes last = pad(&k, in, full);
        target here = pad_target(&k, &t, full, rest);
        k.group_postures = group_postures ? group_postures + full : NULL;
        block_sum(&k, &last, which, 0, LW_GROUP, &here, acc);
        keep_least(smallest, k.margin, LW_GROUP);
    }
    for (int d = 0; grad && d < plan->n_dim; d++)
        grad[d] = total(acc + d*LW_GROUP);
    if (margin)
        *margin = least8(smallest);
    return total(acc + plan->n_dim*LW_GROUP);
}

typedef struct chunk_sum { const lw_plan *plan; int which; target target; double *grad, *margin, f; } chunk_sum;

static void sum_of_chunk(void *caller, const lw_lanes *part, size_t first, void *work, const double *group_postures)
{
    chunk_sum *q = caller;
    double grad[LW_DIM_MAX], least;
    q->f += lane_sum(q->plan, part, q->which, work, group_postures, q->target.x + first, q->target.y + first,
                     q->target.w ? q->target.w + first : NULL, grad, &least);
    for (int d = 0; q->grad && d < q->plan->n_dim; d++)
        q->grad[d] += grad[d];
    if (q->margin)
        *q->margin = lw_at_most(least, *q->margin);
}

static double kernel_sum(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                         const double *tx, const double *ty, const double *w, double *grad, double *margin)
{
    chunk_sum q = { plan, which, { tx, ty, w }, grad, margin, 0 };
    if (!plan->n_higher)
        return lane_sum(plan, in, which, work, NULL, tx, ty, w, grad, margin);
    if (margin)
        *margin = 1;
    for (int d = 0; grad && d < plan->n_dim; d++)
        grad[d] = 0;
    lw_in_chunks(plan, in, work, sum_of_chunk, &q);
    return q.f;
}

static void kernel_turns(size_t n, const double *angle, double *c, double *s)
{
    turns(angle, (n + LW_GROUP - 1)/LW_GROUP*LW_GROUP, c, s);
}

extern const lw_kernels lw_kernels_here;
const lw_kernels lw_kernels_here = { LW_ISA_NAME, kernel_point, kernel_frame, kernel_jacobians, kernel_sum,
                                     lw_kernel_normal, lw_kernel_nearest, lw_kernel_costs, lw_kernel_in_order, kernel_turns,
                                     lw_kernel_group_posture, &lw_higher_size, &lw_follow_size };
