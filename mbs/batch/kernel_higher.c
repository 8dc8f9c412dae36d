/* Higher groups as steps of a plan, eight lanes at a time: Newton's method converges to rounding from the nearby
 * posture of the continuation; then derivatives are computed. */
#include "mbs/batch/kernel_newton_internal.h"

/* ---- forwards ----------------------------------------------------------------------------------------- */

static double *inverse_rows(const run *k, const lw_higher *g)
{
    double *at = k->inverse;
    for (const lw_higher *h = k->plan->higher; h < g; h++)
        at += (size_t)(h->n_unknown*h->n_unknown)*k->nb;
    return at;
}

static void take_group_posture(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    const double *row = k->group_posture + (size_t)g->first_row*k->group_posture_row + i;
    for (int a = 0; a < g->n_turn; a++, row += 2*k->group_posture_row) {
        w->ux[w->at[a]] = get8(row);
        w->uy[w->at[a]] = get8(row + k->group_posture_row);
    }
    for (int d = 0; d < g->n_disp; d++, row += k->group_posture_row)
        w->d[d] = get8(row);
    turn_directions(w);
}

#define ASTRAY 0.03                        /* a step this long leads to another posture: [rad], or times the size */

/* Set steps that are too long to 0.  Returns their lanes. */
LW_INLINE mask hold_astray(const int n, eight *w, mask within)
{
    mask near = within;
    for (int r = 0; r < n; r++)
        near &= (mask)(abs8(w->step[r]) < ASTRAY*(r < w->g->n_turn ? 1 : w->size));
    for (int r = 0; r < n; r++)
        w->step[r] = where8(near, w->step[r]);
    return within & ~near;
}

/* Converge from the group posture to rounding.  Its error is about 1e-10, or below 0.001 in interpolated lanes.  Lanes
 * out of reach do not move.  A lane whose step is too long counts as out of reach. */
LW_INLINE void settle_of(const int n, eight *w, const double *out_of_reach, int outputs)
{
    const double enough = outputs == WITH_ROOTS ? 1e-20 : 1e-16;      /* squared step; inverses are from before it   */
    const pack beyond = get8(out_of_reach);
    mask astray = { 0 };
    for (int i = 0; i < 5; i++) {
        newton_of(n, w);
        if (outputs >= WITH_MARGIN)
            measure_of(n, w);
        astray |= hold_astray(n, w, (mask)(beyond <= 0));
        if (!(most8(apply_step(w)) >= enough))
            break;
    }
    w->margin = choose8(astray, all8(-BEYOND_LEAST), w->margin);
    w->margin = choose8((mask)(beyond > 0), -beyond, w->margin);
}
LW_BY_SIZE(settle, (eight *w, const double *out_of_reach, int outputs), w, out_of_reach, outputs)

/* The unit of length for displacements, from the dimensions of lane i. */
static double size_at(const run *k, size_t i)
{
    double dim[LW_DIM_MAX];
    for (int d = 0; d < k->plan->n_dim; d++)
        dim[d] = dim_of(k, d)[i];
    return lw_plan_size(k->plan, dim);
}

const size_t lw_higher_size = sizeof(eight);

void lw_higher_forward(const run *k, const lw_step *s, size_t n, int per_lane, int outputs)
{
    const lw_higher *g = &k->plan->higher[s->dim[0]];
    const double *reach = k->group_posture + (size_t)k->plan->n_row*k->group_posture_row;
    double *inverse = inverse_rows(k, g);
    eight *w = k->group;
    take_group(w, g);
    w->size = size_at(k, 0);
    w->ends = !k->plan->input_is_slider;
    w->margin = (pack){ 0 };
    if (!per_lane) {
        load_vectors(k, w, 0, 0);
        load_angles(k, w);
        load_meshes(k, g, 0, 0, &w->mesh);
    }
    for (size_t i = 0; i < n; i += LW_GROUP) {
        if (per_lane) {
            w->size = size_at(k, i);
            load_vectors(k, w, i, 1);
            load_meshes(k, g, i, 1, &w->mesh);
            load_known(k, w, i, 1);
        } else
            load_known(k, w, i, 0);
        take_group_posture(k, w, i);
        settle(w, reach + i, outputs);
        put_group(k, w, i);
        if (outputs >= WITH_MARGIN)
            put8(k->margin + i, less8(w->margin, get8(k->margin + i)));
        mask sound = (mask)(w->margin > LW_MARGIN_FLAT);
        for (int c = 0; outputs == WITH_ROOTS && c < w->n*w->n; c++)
            put8(inverse + (size_t)c*k->nb + i, where8(sound, w->inv[c]));
    }
}

/* ---- backwards ---------------------------------------------------------------------------------------- */

/* F = 0 gives J dx = -dF.  With J' lambda = bar, a change dF adds -lambda dF; w->f becomes -lambda. */
static void multipliers(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    const double *inverse = inverse_rows(k, g) + i;
    for (int r = 0; r < w->n; r++)
        w->f[r] = (pack){ 0 };
    for (int c = 0; c < w->n; c++) {
        pack bar = get8(bar_x(k, c < g->n_turn ? g->turn_reg[c] : g->disp_reg[c - g->n_turn]) + i);
        for (int r = 0; r < w->n; r++)
            w->f[r] -= get8(inverse + (size_t)(c*w->n + r)*k->nb)*bar;
    }
}

LW_INLINE void add8(double *to, pack v) { put8(to, get8(to) + v); }

/* Pass the adjoints of directions on to the directions, dimensions and registers that turn them, last to first. */
static void back_directions(const run *k, eight *w, size_t i, pack *turn)
{
    const lw_higher *g = w->g;
    for (int a = g->n_dir - 1; a >= 0; a--) {
        const lw_higher_dir *q = &g->dir[a];
        if (q->base < 0 && q->root >= 0)
            continue;
        double sign = q->input < 0 ? -1 : 1;
        add8((q->dim >= 0 ? dim_bar(k, q->dim) : bar_x(k, q->reg)) + i, sign*turn[a]);
        if (q->base >= 0)
            turn[q->base] += turn[a];
    }
}

/* Adjoints of phases, racks and directions from the rows of gears. */
static void back_gears(const run *k, const eight *w, size_t i, pack *turn)
{
    const lw_higher *g = w->g;
    for (int a = 0; a < g->n_gear; a++) {
        const lw_higher_gear *q = &g->gear[a];
        pack f = w->f[2*g->n_loop + a];
        for (int h = 0; h < q->n_term; h++)
            turn[q->dir[h]] += (double)q->power[h]/q->count*f;
        if (q->phase >= 0)
            add8(dim_bar(k, q->phase) + i, -f);
        if (q->disp < 0)
            continue;
        pack by_rho = f*w->mesh.by_rho[a];
        add8(dim_bar(k, q->shift) + i, by_rho);
        add8(dim_bar(k, q->rho) + i, by_rho*rolled(&w->mesh, a, w->d[q->disp]));
        if (q->disp == g->n_disp)
            add8(bar_x(k, g->disp_reg[q->disp]) + i, -by_rho);
    }
}

static void back_eight(const run *k, eight *w, size_t i)
{
    const lw_higher *g = w->g;
    pack turn[LW_HIGHER_DIR_MAX];
    for (int a = 0; a < g->n_dir; a++)
        turn[a] = (pack){ 0 };
    for (int p = 0; p < g->n_point; p++) {
        const lw_higher_point *q = &g->point[p];
        double sign = q->sign;
        add8(bar_x(k, q->reg) + i, sign*w->f[2*q->loop]);
        add8(bar_y(k, q->reg) + i, sign*w->f[2*q->loop + 1]);
    }
    for (int v = 0; v < g->n_vector; v++) {
        const lw_higher_vector *q = &g->vector[v];
        pack fx = w->f[2*q->loop], fy = w->f[2*q->loop + 1], ux = w->ux[q->dir], uy = w->uy[q->dir];
        double sign = q->sign;
        if (q->x >= 0)
            add8(dim_bar(k, q->x) + i, sign*(fx*ux + fy*uy));
        if (q->y >= 0)
            add8(dim_bar(k, q->y) + i, sign*(fy*ux - fx*uy));
    }
    for (int e = 0; e < g->n_entry; e++) {
        int dir = g->entry[e].dir, loop = g->entry[e].loop;
        pack cx = w->cx[e], cy = w->cy[e], ux = w->ux[dir], uy = w->uy[dir];
        turn[dir] += w->f[2*loop + 1]*(cx*ux - cy*uy) - w->f[2*loop]*(cx*uy + cy*ux);
    }
    for (int e = 0; e < g->n_slide; e++) {
        const lw_higher_slide *q = &g->slide[e];
        pack fx = w->f[2*q->loop], fy = w->f[2*q->loop + 1], ux = w->ux[q->dir], uy = w->uy[q->dir];
        double sign = q->sign;
        turn[q->dir] += sign*w->d[q->disp]*(fy*ux - fx*uy);
        if (q->disp == g->n_disp)
            add8(bar_x(k, g->disp_reg[q->disp]) + i, sign*(fx*ux + fy*uy));
    }
    back_gears(k, w, i, turn);
    back_directions(k, w, i, turn);
}

void lw_higher_backward(const run *k, const lw_step *s, size_t n)
{
    const lw_higher *g = &k->plan->higher[s->dim[0]];
    eight *w = k->group;
    take_group(w, g);
    load_vectors(k, w, 0, 0);
    load_angles(k, w);
    load_meshes(k, g, 0, 0, &w->mesh);
    for (size_t i = 0; i < n; i += LW_GROUP) {
        load_known(k, w, i, 0);
        for (int a = 0; a < g->n_turn; a++) {
            w->ux[w->at[a]] = get8(reg_x(k, g->turn_reg[a]) + i);
            w->uy[w->at[a]] = get8(reg_y(k, g->turn_reg[a]) + i);
        }
        for (int d = 0; d < g->n_disp; d++)
            w->d[d] = get8(reg_x(k, g->disp_reg[d]) + i);
        turn_directions(w);
        multipliers(k, w, i);
        back_eight(k, w, i);
    }
}
