/* Which samples of a curve belong to points in order: costs, and the cheapest assignment by dynamic programming, eight samples at a time. */
#include "mbs/batch/kernel_pack_internal.h"

void lw_kernel_costs(const lw_samples *of, size_t n, const double *x, const double *y, const double *weight, double factor, double *cost)
{
    const pack from = all8(-of->reach), to = all8(of->reach);
    for (size_t i = 0; i < n; i++) {
        const double w = weight[i]*factor;
        for (size_t j = 0; j < of->m; j += LW_GROUP) {
            const pack tx = get8(of->tangent_x + j), ty = get8(of->tangent_y + j);
            pack dx = x[i] - get8(of->x + j), dy = y[i] - get8(of->y + j);
            pack s = less8(more8((dx*tx + dy*ty)*get8(of->per + j), from), to);
            dx -= s*tx;
            dy -= s*ty;
            put8(cost + i*(of->m + LW_GROUP) + j, w*(dx*dx + dy*dy));
        }
    }
}

/* Each number becomes the least of those up to it. */
LW_INLINE pack least_so_far(pack a)
{
    const pack none = all8(INFINITY);
    a = less8(__builtin_shufflevector(none, a, 0, 8, 9, 10, 11, 12, 13, 14), a);
    a = less8(__builtin_shufflevector(none, a, 0, 0, 8, 9, 10, 11, 12, 13), a);
    return less8(__builtin_shufflevector(none, a, 0, 0, 0, 0, 8, 9, 10, 11), a);
}

double lw_kernel_in_order(size_t n, size_t m, const double *cost, size_t first, int sense, double enough, double *least)
{
    const size_t row = m + LW_GROUP;
    for (size_t k = 0; k <= m; k++)
        least[k] = cost[first];
    for (size_t i = 1; i < n; i++) {
        const double *c = cost + i*row, *before = least + (i - 1)*row;
        double *now = least + i*row, carry = INFINITY;
        if (before[m] >= enough)                         /* further points cost more                       */
            return INFINITY;
        for (size_t k = 0; k < m; k += LW_GROUP) {
            pack of = sense > 0 ? get8(c + ((first + k) & (m - 1))) : get8(c + ((first - k - (LW_GROUP - 1)) & (m - 1)));
            if (sense < 0)
                of = __builtin_shufflevector(of, of, 7, 6, 5, 4, 3, 2, 1, 0);
            pack all = least_so_far(get8(before + k) + of);
            put8(now + k, less8(all, all8(carry)));
            carry = all[LW_GROUP - 1] < carry ? all[LW_GROUP - 1] : carry;
        }
        const double last = before[m] + c[first];
        now[m] = last < carry ? last : carry;
    }
    return least[(n - 1)*row + m];
}
