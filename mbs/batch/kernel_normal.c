/* J'J and J'r from rows over lanes, several products at a time.
 *
 * Every product has eight sums (lane number modulo eight), added in a fixed order.  So the bits do not depend on the
 * number of products computed at a time. */
#include "mbs/batch/kernel_pack_internal.h"

#if defined(__AVX512F__)
#define ABREAST 4                          /* products at a time: their sums stay in registers        */
#else
#define ABREAST 2
#endif

/* Products of column a with columns b[0 .. count-1].  a_step, b_step: distance between components. */
LW_INLINE void products(const lw_normal *q, const double *a, size_t a_step, const double *const *b, size_t b_step,
                        const int count, double *to)
{
    pack s[ABREAST] = { 0 };
    for (int r = 0; r < q->n_row; r++)
        for (size_t k = 0; k < q->ld; k += LW_GROUP) {
            const pack x = get8(a + (size_t)r*a_step + k);
            for (int c = 0; c < count; c++)
                s[c] += x*get8(b[c] + (size_t)r*b_step + k);
        }
    for (int c = 0; c < count; c++)
        to[c] = ((s[c][0] + s[c][4]) + (s[c][1] + s[c][5])) + ((s[c][2] + s[c][6]) + (s[c][3] + s[c][7]));
}

void lw_kernel_normal(const lw_normal *q, double *h, double *g)
{
    size_t step = q->row_step*q->ld;
    for (int i = 0; i < q->n; i++) {
        const double *a = q->row + (size_t)q->column[i]*q->ld, *b[ABREAST], *r = q->res;
        int j = 0;
        products(q, a, step, &r, q->ld, 1, g + i);
        for (; j + ABREAST <= i + 1; j += ABREAST) {
            for (int c = 0; c < ABREAST; c++)
                b[c] = q->row + (size_t)q->column[j + c]*q->ld;
            products(q, a, step, b, step, ABREAST, h + i*q->n + j);
        }
        for (; j <= i; j++) {
            b[0] = q->row + (size_t)q->column[j]*q->ld;
            products(q, a, step, b, step, 1, h + i*q->n + j);
        }
    }
}
