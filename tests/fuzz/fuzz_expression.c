/* An expression that can be read has the same value by itself, with its gradient and as a series, and its text can be
 * read again. */
#include <math.h>
#include "grammar/functions/expression.h"
#include "tests/fuzz/fuzz.h"

static int lookup(void *context, const char *word, const char *name, char *why)
{
    (void)context;
    if (name && !strcmp(name, "none"))
        memcpy(why, "there is none", 14);
    else if (strlen(word) == 1)
        return (unsigned char)word[0]*256 + (name ? (unsigned char)name[0] : 0);
    return -1;
}

static int same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

static int one_input(const uint8_t *data, size_t size)
{
    enum { N = LW_EXPRESSION_VARIABLE_MAX, TERMS = LW_SERIES_ORDER_MAX + 1 };
    double v[N], dv[N], series[N*TERMS], out[TERMS];
    lw_expression *x, *again;
    lw_error e = { 0 };
    if (lw_expression_parse((const char *)data, size, lookup, NULL, &x, &e) != LW_OK) {
        if (e.column < 1 || (size_t)e.column > size + 1)
            abort();
        return 0;
    }
    int n = lw_expression_variables(x, NULL);
    for (int i = 0; i < n; i++) {
        v[i] = 0.5*i - 1;
        for (int k = 0; k < TERMS; k++)
            series[i*TERMS + k] = k ? 0.25*k : v[i];
    }
    double f = lw_expression_value(x, v);
    lw_expression_series(x, TERMS - 1, series, out);
    if (!same(f, lw_expression_gradient(x, v, dv)) || !same(f, out[0])
        || lw_expression_parse(lw_expression_text(x), size, lookup, NULL, &again, NULL) != LW_OK
        || !same(f, lw_expression_value(again, v)))
        abort();
    lw_expression_free(x);
    lw_expression_free(again);
    return 0;
}
