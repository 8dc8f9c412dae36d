/* J'J and J'r by the batch: against the sums written out, columns in any order, and every instruction set the same
 * bits. */
#include "mbs/batch/batch.h"
#include "mbs/batch/kernels_internal.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

enum { COLUMN_MAX = 21, ROW_MAX = 3, LD_MAX = 136 };

static double row[ROW_MAX*COLUMN_MAX*LD_MAX], res[ROW_MAX*LD_MAX];

/* The sum in the order the header of mbs/batch/kernels_internal.h names: lane number modulo eight. */
static double slow(const lw_normal *q, const double *a, size_t a_step, const double *b, size_t b_step)
{
    double s[8] = { 0 };
    for (int r = 0; r < q->n_row; r++)
        for (size_t k = 0; k < q->ld; k++)
            s[k%8] += a[(size_t)r*a_step + k]*b[(size_t)r*b_step + k];
    return ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
}

static void check_one(lw_plan *plan, const lw_normal *q)
{
    double h[COLUMN_MAX*COLUMN_MAX], g[COLUMN_MAX];
    size_t step = q->row_step*q->ld;
    for (int isa = 0; lw_kernels_supported(isa); isa++) {
        int wrong = 0, touched = 0;
        plan->kernels = lw_kernels_supported(isa);
        for (int i = 0; i < COLUMN_MAX*COLUMN_MAX; i++)
            h[i] = -1;
        lw_batch_normal(plan, q, h, g);
        for (int i = 0; i < q->n; i++) {
            const double *a = row + (size_t)q->column[i]*q->ld;
            wrong += g[i] != slow(q, a, step, res, q->ld);
            for (int j = 0; j <= i; j++)
                wrong += h[i*q->n + j] != slow(q, a, step, row + (size_t)q->column[j]*q->ld, step);
            for (int j = i + 1; j < q->n; j++)
                touched += h[i*q->n + j] != -1;
        }
        CHECK_INT(wrong, 0);
        CHECK_INT(touched, 0);
    }
}

TEST(products_are_the_sums_written_out)
{
    lw_linkage k;
    lw_plan plan;
    int column[COLUMN_MAX];
    lw_rng r = check_rng(1);
    lw_type_linkage(lw_type_find("fourbar"), &k);
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1 }, &plan, NULL), LW_OK);
    for (int trial = 0; trial < 300; trial++) {
        size_t ld = 8*(1 + (size_t)trial%(LD_MAX/8));
        lw_normal q = { trial%(COLUMN_MAX + 1), 1 + trial%ROW_MAX, column, row, res, COLUMN_MAX, ld };
        for (int i = 0; i < q.n; i++)
            column[i] = trial%2 ? i : (7*i + trial)%COLUMN_MAX;
        for (size_t i = 0; i < sizeof row/sizeof *row; i++)
            row[i] = lw_rng_normal(&r);
        for (size_t i = 0; i < sizeof res/sizeof *res; i++)
            res[i] = lw_rng_normal(&r);
        check_one(&plan, &q);
    }
}
