/* mbs/batch/kernel_gear_internal.h - gears among the equations of a higher group, eight lanes at a time.
 *
 * A gear's row is an angle that must be 0 and is linear in the turns and displacements.  The product of the unit
 * vectors to their powers has this angle.  The residual is the sine of the angle; the Jacobian holds the derivatives of
 * the angle, which are those of the sine at the solution. */
#ifndef LW_MBS_BATCH_KERNEL_GEAR_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_GEAR_INTERNAL_H

#include "mbs/batch/kernel_pack_internal.h"

/* Dimensions of the gears in the lanes: cosine and sine of the phase for wheels; 1/rho, shift and middle for racks. */
typedef struct meshes {
    pack c[LW_HIGHER_GEAR_MAX], s[LW_HIGHER_GEAR_MAX];
    pack by_rho[LW_HIGHER_GEAR_MAX], shift[LW_HIGHER_GEAR_MAX], middle[LW_HIGHER_GEAR_MAX];
} meshes;

LW_INLINE pack lane_row(const double *from, size_t i, const int per_lane)
{
    return per_lane ? get8(from + i) : all8(from[0]);
}

static void load_meshes(const run *k, const lw_higher *g, size_t i, int per_lane, meshes *m)
{
    for (int a = 0; a < g->n_gear; a++) {
        const lw_higher_gear *q = &g->gear[a];
        if (q->disp < 0) {
            m->c[a] = lane_row(cos_of(k, q->angle), i, per_lane);
            m->s[a] = lane_row(sin_of(k, q->angle), i, per_lane);
            continue;
        }
        pack rho = lane_row(dim_of(k, q->rho), i, per_lane);
        m->by_rho[a] = 1/choose8((mask)(abs8(rho) > LW_TINY), rho, all8(LW_TINY));
        m->shift[a] = lane_row(dim_of(k, q->shift), i, per_lane);
        m->middle[a] = lane_row(dim_of(k, q->middle), i, per_lane);
    }
}

/* The turn of the pinion when its rack is at displacement d. */
LW_INLINE pack rolled(const meshes *m, int a, pack d) { return (d - m->shift[a])*m->by_rho[a]; }

LW_INLINE void multiply(pack *x, pack *y, pack ux, pack uy)
{
    pack t = *x*ux - *y*uy;
    *y = *x*uy + *y*ux;
    *x = t;
}

static void multiply_power(pack *x, pack *y, pack ux, pack uy, int power)
{
    uy = power < 0 ? -uy : uy;
    for (int n = power < 0 ? -power : power; n > 0; n /= 2) {
        if (n & 1)
            multiply(x, y, ux, uy);
        multiply(&ux, &uy, ux, uy);
    }
}

/* The residual of row a: the sine of the angle; beyond a quarter turn a function that keeps rising. */
static pack mesh_left(const lw_higher_gear *q, const meshes *m, int a, const pack *ux, const pack *uy, const pack *d)
{
    pack x = all8(1), y = { 0 };
    if (q->disp < 0)
        multiply_power(&x, &y, m->c[a], m->s[a], -q->count);
    else {
        pack angle = rolled(m, a, d[q->disp]);
        for (int j = 0; j < LW_GROUP; j++) {
            lw_vec2 u = lw_sincos(angle[j]);
            x[j] = u.x;
            y[j] = -u.y;
        }
    }
    for (int h = 0; h < q->n_term; h++)
        multiply_power(&x, &y, ux[q->dir[h]], uy[q->dir[h]], q->power[h]);
    pack far = choose8((mask)(y < 0), -2 - y, 2 - y);
    return choose8((mask)(x > 0), y, far)*(1.0/q->count);
}

/* The margin of the racks: 1 in the middle, 0 at the ends. */
static pack rack_room(const lw_higher *g, const meshes *m, const pack *d)
{
    pack room = all8(1);
    for (int a = 0; a < g->n_gear; a++) {
        const lw_higher_gear *q = &g->gear[a];
        if (q->disp < 0)
            continue;
        pack t = (rolled(m, a, d[q->disp]) - m->middle[a])*(1/LW_RACK_REACH);
        room = less8(1 - t*t, room);
    }
    return room;
}

#endif
