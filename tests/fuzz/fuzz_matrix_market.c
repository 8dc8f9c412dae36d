/* Any bytes are a square matrix of finite numbers, or have an error with a place. */
#include <math.h>

#include "grammar/model/matrix_market.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_error e = { .text = "" };
    int n;
    double *a;
    lw_status s = lw_matrix_market_read((const char *)data, size, "f", &n, &a, &e);
    if (s != LW_OK) {
        demand(a == NULL && e.text[0] && (s != LW_E_NOTATION || (e.line > 0 && e.column > 0)));
        return 0;
    }
    demand(n >= 1 && n <= LW_MATRIX_MOST);
    for (int i = 0; i < n*n; i++)
        demand(isfinite(a[i]));
    free(a);
    return 0;
}
