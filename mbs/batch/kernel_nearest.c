/* Nearest points of a polyline, eight points at a time. */
#include "mbs/batch/kernel_pack_internal.h"

void lw_kernel_nearest(const lw_polyline *line, size_t n, const double *x, const double *y, double *near_x, double *near_y)
{
    size_t sides = line->closed ? line->n : line->n - 1;
    for (size_t k = 0; k < n; k += LW_GROUP) {
        const pack px = get8(x + k), py = get8(y + k);
        pack fx = all8(line->x[0]), fy = all8(line->y[0]);
        pack least = (px - fx)*(px - fx) + (py - fy)*(py - fy);
        for (size_t i = 0; i < sides; i++) {
            size_t next = i + 1 < line->n ? i + 1 : 0;
            double ax = line->x[i], ay = line->y[i], dx = line->x[next] - ax, dy = line->y[next] - ay;
            double d2 = dx*dx + dy*dy, ux = d2 > 0 ? dx/d2 : 0, uy = d2 > 0 ? dy/d2 : 0;
            pack t = less8(more8((px - ax)*ux + (py - ay)*uy, all8(0)), all8(1));
            pack qx = ax + t*dx, qy = ay + t*dy;
            pack d = (px - qx)*(px - qx) + (py - qy)*(py - qy);
            mask nearer = (mask)(d < least);
            least = choose8(nearer, d, least);
            fx = choose8(nearer, qx, fx);
            fy = choose8(nearer, qy, fy);
        }
        put8(near_x + k, fx);
        put8(near_y + k, fy);
    }
}
