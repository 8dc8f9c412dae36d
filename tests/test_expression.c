/* Expressions: values, faults with their columns, gradients against differences, series against
 * values nearby and against known ones. */
#include <locale.h>

#include "base/vec2.h"
#include "grammar/functions/expression.h"
#include "tests/check.h"

OWNS(lw_expression)

/* t is 0, x(NAME) 10 + first letter, any of w0 .. w99 its number */
static int lookup(void *context, const char *word, const char *name, char *why)
{
    int *n_asked = context;
    if (n_asked)
        ++*n_asked;
    if (strcmp(word, "t") == 0 && !name)
        return 0;
    if (strcmp(word, "u") == 0 && !name)
        return 1;
    if (strcmp(word, "x") == 0 && name && strcmp(name, "nowhere") == 0) {
        snprintf(why, 128, "there is no point called nowhere");
        return -1;
    }
    if (strcmp(word, "x") == 0 && name)
        return 10 + (unsigned char)name[0];
    if (word[0] == 'w' && word[1])
        return 1000 + atoi(word + 1);
    return -1;
}

static lw_expression *parse(const char *text)
{
    lw_expression *x = NULL;
    char buf[256];
    if (lw_expression_parse(text, strlen(text), lookup, NULL, &x, &check_error) != LW_OK) {
        lw_error_print(&check_error, buf, sizeof buf);
        fprintf(stderr, "%s: %s\n", text, buf);
    }
    CHECK(x != NULL);
    return x;
}

/* Value at t, u (in the order of first appearance). */
static double at(const char *text, double t, double u)
{
    OWNED(lw_expression) *x = parse(text);
    const int *which;
    double v[LW_EXPRESSION_VARIABLE_MAX];
    if (!x)
        return NAN;
    int n = lw_expression_variables(x, &which);
    for (int i = 0; i < n; i++)
        v[i] = which[i] == 0 ? t : u;
    double value = lw_expression_value(x, v);
    return value;
}

TEST(values)
{
    static const struct { const char *text; double want; } known[] = {
        { "1", 1 }, { " 1.5e-3 ", 0.0015 }, { ".5", 0.5 }, { "3.", 3 }, { "1e+2", 100 }, { "1E2", 100 },
        { "2+3*4", 14 }, { "(2+3)*4", 20 }, { "2-3-4", -5 }, { "8/4/2", 1 }, { "-2^2", -4 },
        { "2^-1", 0.5 }, { "2^3^2", 512 }, { "(-2)^3", -8 }, { "--3", 3 }, { "+-3", -3 }, { "2*-3", -6 },
        { "2^-(1+1)", 0.25 }, { "pi", LW_PI }, { "sin(pi/6)", 0.5 }, { "cos(pi/3)", 0.5 },
        { "tan(pi/4)", 1 }, { "asin(1)", LW_PI/2 }, { "acos(0.5)", LW_PI/3 }, { "atan(-1)", -LW_PI/4 },
        { "atan2(1, -1)", 3*LW_PI/4 }, { "sinh(1)", 1.1752011936438014 }, { "cosh(1)", 1.5430806348152437 },
        { "tanh(0.5)", 0.46211715726000975 }, { "exp(1)", 2.718281828459045 }, { "log(10)", 2.302585092994046 },
        { "sqrt(2)", 1.4142135623730951 }, { "abs(-3)", 3 }, { "sign(-3)", -1 }, { "sign(0)", 0 },
        { "min(3, 1, 2)", 1 }, { "max(3, 7, 2, 5)", 7 }, { "mod(7, 3)", 1 }, { "mod(-1, 3)", 2 },
        { "mod(1, -3)", -2 }, { "mod(-6, 3)", 0 }, { "hypot(3, -4)", 5 }, { "1\n+\t2\r\n", 3 },
        { "step(0.5, 0, 2, 1, 6)", 4 }, { "havsin(0.5, 0, 2, 1, 6)", 4 }, { "poly(3, 1, 5, 2, 1)", 13 },
        { "poly(3, 1, 5)", 5 }, { "table(1.5, 1, 10, 2, 30)", 20 }, { "table(3, 1, 10, 2, 30)", 50 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWNED(lw_expression) *x = parse(known[i].text);
        if (!x)
            continue;
        CHECK_NEAR(lw_expression_value(x, NULL), known[i].want, 1e-15, 1e-15);
        CHECK_INT(lw_expression_variables(x, NULL), 0);
        CHECK_TEXT(lw_expression_text(x), known[i].text);
    }
}

TEST(with_variables)
{
    CHECK_NEAR(at("2*t", 3, 0), 6, 0, 0);
    CHECK_NEAR(at("u - t", 3, 10), 7, 0, 0);
    CHECK_NEAR(at("u^t", 3, 2), 8, 0, 0);
    CHECK_NEAR(at("mod(t, u)", 7.5, 2), 1.5, 0, 0);
    CHECK(isnan(at("sqrt(t)", -1, 0)));
    CHECK(isnan(at("log(t) + 1", -1, 0)));
    CHECK(isnan(at("max(1, sqrt(t))", -1, 0)));
    CHECK(isnan(at("min(sqrt(t), 1)", -1, 0)));
    CHECK(isnan(at("abs(asin(t))", 2, 0)));
}

TEST(variables_in_order_of_appearance)
{
    OWNED(lw_expression) *x = parse("u + x(P)*t + x( Q )*u + x('R ()')");
    const int *which;
    if (!x)
        return;
    CHECK_INT(lw_expression_variables(x, &which), 5);
    CHECK_INT(which[0], 1);
    CHECK_INT(which[1], 10 + 'P');
    CHECK_INT(which[2], 0);
    CHECK_INT(which[3], 10 + 'Q');
    CHECK_INT(which[4], 10 + 'R');
    double v[] = { 2, 3, 5, 7, 11 }, dv[5];
    CHECK_NEAR(lw_expression_gradient(x, v, dv), 2 + 15 + 14 + 11, 0, 0);
    static const double want[] = { 8, 5, 3, 2, 1 };
    for (int i = 0; i < 5; i++)
        CHECK_NEAR(dv[i], want[i], 0, 0);
}

/* Makkonen 1999, paper A: by their formulas, here written out once more. */
TEST(motion_generators)
{
    for (double t = 0; t <= 4; t += 0.0625) {
        double u = (t - 1)/(3 - 1), inside = t > 1 && t < 3;
        double step = t <= 1 ? 5 : t >= 3 ? -2 : 5 + (-2 - 5)*u*u*(3 - 2*u);
        double half = t <= 1 ? 5 : t >= 3 ? -2 : (5 - 2)/2. + (-2 - 5)/2.*sin(u*LW_PI - LW_PI/2);
        CHECK_NEAR(at("step(t, 1, 5, 3, -2)", t, 0), step, inside ? 2e-15 : 0, 0);
        CHECK_NEAR(at("havsin(t, 1, 5, 3, -2)", t, 0), half, inside ? 2e-15 : 0, 0);
        double d = t - 0.5;
        CHECK_NEAR(at("poly(t, 0.5, 1, -2, 0, 4, 0.25)", t, 0), 1 - 2*d + 4*pow(d, 3) + 0.25*pow(d, 4), 1e-14, 1e-15);
    }
    CHECK_NEAR(at("step(t, u, t, u + 2, 2*t)", 3, 2), 4.5, 1e-15, 0);   /* ends may change */
    CHECK(isnan(at("step(t, u, 0, t, 1)", 1, 1)));
}

/* Through the points, two derivatives continuous, no bend at the ends, straight outside. */
TEST(natural_spline)
{
    static const char text[] = "table(t, 0, 1, 1, 3, 1.5, -1, 4, 0.5, 5, 2)";
    static const double x[] = { 0, 1, 1.5, 4, 5 }, y[] = { 1, 3, -1, 0.5, 2 };
    lw_expression *spline = parse(text);
    if (!spline)
        return;
    for (int i = 0; i < 5; i++) {
        CHECK_NEAR(lw_expression_value(spline, &x[i]), y[i], 0, 0);
        double to_right[] = { x[i], 1, 0, 0 }, to_left[] = { x[i], -1, 0, 0 }, r[4], l[4];
        lw_expression_series(spline, 3, to_right, r);
        lw_expression_series(spline, 3, to_left, l);
        CHECK_NEAR(r[0], y[i], 0, 0);
        CHECK_NEAR(l[1], -r[1], 1e-13, 0);
        CHECK_NEAR(l[2], r[2], 1e-13, 0);
        if (i == 0 || i == 4)
            CHECK_NEAR(r[2], 0, 1e-14, 0);
        else
            CHECK(fabs(l[3] + r[3]) > 1e-3);               /* where pieces meet the third one jumps */
    }
    for (int side = -1; side <= 1; side += 2) {
        double end = side < 0 ? 0 : 5, slope, v = end + 2*side;
        lw_expression_gradient(spline, &end, &slope);
        CHECK_NEAR(lw_expression_value(spline, &v), y[side < 0 ? 0 : 4] + 2*side*slope, 1e-14, 0);
    }
    lw_expression_free(spline);
    /* three points, h = 1: bend in the middle is 3/2 (y0 - 2 y1 + y2) */
    OWNED(lw_expression) *three = parse("table(t, 0, 1, 1, 4, 2, 2)");
    double middle[] = { 1, 1, 0 }, c[3];
    if (!three)
        return;
    lw_expression_series(three, 2, middle, c);
    CHECK_NEAR(c[2], 1.5*(1 - 8 + 2)/2, 1e-14, 0);
}

TEST(faults)
{
    static const struct { const char *text; int column; const char *part; } known[] = {
        { "", 1, "expected, not the end" },
        { "   ", 4, "the end" },
        { "1 +", 4, "the end" },
        { "1 + * 2", 5, "not '*'" },
        { "1 2", 3, "operator is missing" },
        { "2t", 2, "operator is missing before 't'" },
        { "2e", 2, "operator is missing" },
        { "1e+", 4, "digits of an exponent" },
        { "1.2.3", 4, "operator is missing" },
        { "1,5", 2, "decimal point" },
        { "(1 + 2", 7, "bracket of column 1 is open" },
        { "1 + 2)", 6, "closes nothing" },
        { "t $ 2", 3, "not '$'" },
        { "t \xe2\x88\x92 2", 3, "byte 0xe2" },
        { "sinn(t)", 1, "did you mean sin?" },
        { "1 + stpe(t, 0, 0, 1, 1)", 5, "did you mean step?" },
        { "2*SQRT(t)", 3, "did you mean sqrt?" },
        { "pie", 1, "did you mean pi?" },
        { "zebra*2", 1, "no function or variable zebra" },
        { "t(3)", 1, "no function or variable t" },
        { "x(nowhere)", 3, "no point called nowhere" },
        { "x( nowhere )", 4, "no point called nowhere" },
        { "x", 1, "no function or variable x" },
        { "x()", 3, "name of 1 to" },
        { "x(P", 4, ") is missing behind a name" },
        { "x('P)", 6, "' is missing" },
        { "x('P'", 6, "')' is missing" },
        { "sin", 4, "sin(x)" },
        { "sin t", 5, "'(' is expected: sin(x)" },
        { "sin()", 5, "not ')'" },
        { "sin(t, 2)", 8, "one too many: sin(x)" },
        { "atan2(t)", 8, "something is missing: atan2(y, x)" },
        { "min(t)", 6, "min(a, b, ...)" },
        { "step(t, 0, 0, 1)", 16, "step(x, x0, h0, x1, h1)" },
        { "step(t, 0, 0, 1, 1, 2)", 21, "one too many" },
        { "step(t, 1, 0, 1, 1)", 15, "x1 must be greater" },
        { "havsin(t, 1, 0,  0.5, 1)", 18, "x1 must be greater" },
        { "step(t 1)", 8, "',' or ')' is expected in step(" },
        { "poly(t, 0)", 10, "poly(x, x0, a0, a1, ...)" },
        { "table(t, 0, 1)", 14, "table(x, x1, y1, x2, y2, ...)" },
        { "table(t, 0, 1, 2, 3, 4)", 22, "has no y" },
        { "table(t, 0, 1, 0, 3)", 16, "must rise" },
        { "table(t, 0, u, 1, 3)", 13, "are numbers" },
        { "2*table(t, 0, 0, 1e-300, 1e300, 1, 0)", 3, "too far apart" },
        { "sqrt(-1)", 1, "no finite number" },
        { "t + 1/0", 6, "no finite number" },
        { "t*exp(1000)", 3, "no finite number" },
        { "1e999", 1, "too large" },
        { "t +\n zz", 6, "zz" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_expression *x;
        lw_error e = { 0 };
        lw_status s = lw_expression_parse(known[i].text, strlen(known[i].text), lookup, NULL, &x, &e);
        CHECK_INT(s, LW_E_NOTATION);
        CHECK(x == NULL);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
        if (e.column != known[i].column)
            fprintf(stderr, "    %s: %s\n", known[i].text, e.text);
    }
    lw_expression *x;
    lw_error e;
    CHECK_INT(lw_expression_parse("1\0+2", 4, lookup, NULL, &x, &e), LW_E_NOTATION);
    CHECK_INT(e.column, 2);
    CHECK_INT(lw_expression_parse("x(P\0)", 5, lookup, NULL, &x, NULL), LW_E_NOTATION);
    CHECK_INT(lw_expression_parse("t", 1, NULL, NULL, &x, NULL), LW_E_NOTATION);
}

static lw_status long_text(const char *head, const char *piece, int n, const char *tail, lw_error *e)
{
    size_t size = strlen(head) + (size_t)n*strlen(piece) + strlen(tail);
    char *text = malloc(size + 1);
    lw_expression *x;
    strcpy(text, head);
    for (int i = 0; i < n; i++)
        strcat(text, piece);
    strcat(text, tail);
    lw_status s = lw_expression_parse(text, size, lookup, NULL, &x, e);
    free(text);
    lw_expression_free(x);
    return s;
}

TEST(limits)
{
    lw_error e;
    CHECK_FAILS(long_text("", "(", 99, "t", &check_error), LW_E_NOTATION, "')' is expected");
    CHECK_INT(long_text("", "(", 1000, "t", &e), LW_E_NOTATION);
    CHECK_INT(e.column, 101);
    CHECK_HAS(e.text, "at most 100");
    CHECK_INT(long_text("", "-", 100000, "t", &e), LW_E_NOTATION);
    CHECK_INT(long_text("", "sin(", 100000, "t", &e), LW_E_NOTATION);
    CHECK_INT(long_text("2", "^2", 1000, "", &e), LW_E_NOTATION);
    CHECK_INT(long_text("t", "+t", 511, "", &e), LW_OK);
    CHECK_INT(long_text("t", "+t", 512, "", &e), LW_E_NOTATION);
    CHECK_INT(e.column, 2*512);
    CHECK_HAS(e.text, "at most 512");
    CHECK_INT(long_text("1", "+1", 100000, "", &e), LW_OK);  /* constants cost nothing */
    CHECK_INT(long_text("t", "", 0, "w", &e), LW_E_NOTATION);
    char text[512] = "t";
    for (int i = 0; i < 16; i++)
        snprintf(text + strlen(text), 16, "+w%d", i);
    CHECK_INT(long_text(text, "", 0, "", &e), LW_E_NOTATION);
    CHECK_INT(e.column, (long)strlen(text) - 2);
    CHECK_HAS(e.text, "at most 16");
    CHECK_INT(long_text(text + 2, "", 0, "+w3+w4", &e), LW_OK);
    CHECK_INT(long_text("", "abcdefghij", 100, "", &e), LW_E_NOTATION);
    CHECK_INT(long_text("x(", "abcdefghij", 100, ")", &e), LW_E_NOTATION);
    CHECK_INT(e.column, 3);
}

/* ---- derivatives ------------------------------------------------------------------------------- */

/* Of t and u, smooth for |t|, |u| < 1. */
static const char *const smooth[] = {
    "t + u", "t - u", "-t*u", "t/(2 + u)", "1/(3 + t*u)", "(2 + t)^2", "(t - u)^3", "(2 + t)^-2", "(2 + t*u)^1.5",
    "(2 + t)^(u - 0.3)", "2^(t + u)", "sin(2*t - u)", "cos(t + 3*u)", "tan(t*u + 0.2)", "asin(0.6*t - 0.2*u)",
    "acos(0.4*t*u)", "atan(2*t + u)", "atan2(t + 0.1, 2 + u)", "atan2(2 + t, u)", "atan2(t - 1.5, u - 2)",
    "sinh(t + u)", "cosh(t - u)", "tanh(2*t*u)", "exp(t - 2*u)", "log(3 + t - u)", "sqrt(2 + t*u)",
    "hypot(2 + t, u)", "hypot(t, u - 2)", "abs(t - 3)", "abs(3 - u)", "min(t, u + 4)", "max(t, u - 5)",
    "mod(t + 0.5*u + 2, 5) + mod(7.6 + 0.1*t, u + 5)", "sign(t - 2)*u",
    "step(t + u, -3, u, 4, 2*t)", "havsin(t*u, -2, 1, 2, t)",
    "step(t, -2 - u^2, 0, 2 + t*u, 1)", "poly(t, u, 1, 2, u, -3)", "table(0.2*t + 0.2*u, -1, 3, 0.5, 1, 1.5, 2, 2, 7)",
    "sin(exp(t)*cos(u))^2 + log(2 + tanh(t/(3 + u)))*sqrt(1.5 + u)", "((2 + t)*(2 + u))^70/1e40", "t^0 + u^1",
};
enum { N_SMOOTH = sizeof smooth/sizeof *smooth };

TEST(gradients_against_differences)
{
    lw_rng r = check_rng(0);
    for (int i = 0; i < N_SMOOTH; i++) {
        OWNED(lw_expression) *x = parse(smooth[i]);
        for (int trial = 0; x && trial < 20; trial++) {
            double v[2] = { lw_rng_range(&r, -0.9, 0.9), lw_rng_range(&r, -0.9, 0.9) }, dv[2];
            double f = lw_expression_gradient(x, v, dv), h = 1e-4;
            CHECK_NEAR(f, lw_expression_value(x, v), 0, 0);
            for (int k = 0; k < lw_expression_variables(x, NULL); k++) {
                double w[2] = { v[0], v[1] }, d[4];
                for (int j = 0; j < 4; j++) {              /* five points: error h^4 */
                    w[k] = v[k] + (j < 2 ? j - 2 : j - 1)*h;
                    d[j] = lw_expression_value(x, w);
                }
                double slope = (d[0] - 8*d[1] + 8*d[2] - d[3])/(12*h);
                CHECK_NEAR(dv[k], slope, 2e-10*(1 + fabs(f)), 1e-9);
                if (!(fabs(dv[k] - slope) < 2e-10*(1 + fabs(f)) + 1e-9*fabs(slope)))
                    fprintf(stderr, "    %s by variable %d\n", smooth[i], k);
            }
        }
    }
}

/* The series summed at a small s must be the value of the expression where the curve then is. */
TEST(series_against_values)
{
    enum { N = LW_SERIES_ORDER_MAX + 1 };
    lw_rng r = check_rng(1);
    for (int i = 0; i < N_SMOOTH; i++) {
        OWNED(lw_expression) *x = parse(smooth[i]);
        for (int trial = 0; x && trial < 20; trial++) {
            double v[2*N], c[N], s = 0.01, scale = 0;
            for (int k = 0; k < 2*N; k++)
                v[k] = lw_rng_range(&r, -0.7, 0.7);
            lw_expression_series(x, N - 1, v, c);
            for (int sign = -1; sign <= 1; sign += 2) {
                double w[2] = { 0, 0 }, sum = 0;
                for (int k = N - 1; k >= 0; k--) {
                    w[0] = w[0]*s*sign + v[k];
                    w[1] = w[1]*s*sign + v[N + k];
                    sum = sum*s*sign + c[k];
                    scale = fmax(scale, fabs(c[k])*pow(2*s, k));
                }
                /* what is cut off is of order s^9; c_7 and c_8, one of which may be 0, tell its size; rounding is
                 * that of the numbers in between, some of order one */
                double cut = 50*(fabs(c[N-2]) + fabs(c[N-1]))*pow(s, N);
                CHECK_NEAR(sum, lw_expression_value(x, w), 4e-14*fmax(scale, 0.1) + cut, 1e-15);
            }
            double first[2], low[3], v1[6];
            first[0] = v[0];
            first[1] = v[N];
            CHECK_NEAR(c[0], lw_expression_value(x, first), 0, 0);
            for (int k = 0; k < 3; k++) {                  /* a lower order gives the same terms */
                v1[k] = v[k];
                v1[3 + k] = v[N + k];
            }
            lw_expression_series(x, 2, v1, low);
            for (int k = 0; k < 3; k++)
                CHECK_NEAR(low[k], c[k], 1e-15*fabs(c[k]), 0);
        }
    }
}

TEST(known_series)
{
    static const struct { const char *text; double t0, want[6]; } known[] = {
        { "exp(t)", 0, { 1, 1, 1/2., 1/6., 1/24., 1/120. } },
        { "sin(t)", 0, { 0, 1, 0, -1/6., 0, 1/120. } },
        { "cos(t)", 0, { 1, 0, -1/2., 0, 1/24., 0 } },
        { "tan(t)", 0, { 0, 1, 0, 1/3., 0, 2/15. } },
        { "tanh(t)", 0, { 0, 1, 0, -1/3., 0, 2/15. } },
        { "asin(t)", 0, { 0, 1, 0, 1/6., 0, 3/40. } },
        { "acos(t)", 0, { LW_PI/2, -1, 0, -1/6., 0, -3/40. } },
        { "atan(t)", 0, { 0, 1, 0, -1/3., 0, 1/5. } },
        { "atan2(t, 1)", 0, { 0, 1, 0, -1/3., 0, 1/5. } },
        { "log(t)", 1, { 0, 1, -1/2., 1/3., -1/4., 1/5. } },
        { "sqrt(t)", 1, { 1, 1/2., -1/8., 1/16., -5/128., 7/256. } },
        { "1/t", 1, { 1, -1, 1, -1, 1, -1 } },
        { "t^0.5", 1, { 1, 1/2., -1/8., 1/16., -5/128., 7/256. } },
        { "t^-1", 1, { 1, -1, 1, -1, 1, -1 } },
        { "t^3", 0, { 0, 0, 0, 1, 0, 0 } },
        { "t^2.5", 0, { 0, 0, 0, NAN, NAN, NAN } },
        { "hypot(1, t)", 0, { 1, 0, 1/2., 0, -1/8., 0 } },
        { "hypot(3*t, 4*t)", 0, { 0, 5, 0, 0, 0, 0 } },
        { "step(t, 0, 0, 1, 1)", 0, { 0, 0, 3, -2, 0, 0 } },
        { "step(t, 0, 0, 1, 1)", 1, { 1, 0, 0, 0, 0, 0 } },
        { "step(-t, 0, 0, 1, 1)", 0, { 0, 0, 0, 0, 0, 0 } },
        { "step(2 - t, 0, 0, 1, 1)", 1, { 1, 0, -3, 2, 0, 0 } },
        { "havsin(2*t, 0, 0, 2, 1)", 0, { 0, 0, LW_PI*LW_PI/4, 0, -LW_PI*LW_PI*LW_PI*LW_PI/48, 0 } },
        { "havsin(t, 0, 0, 1, 1)", 1, { 1, 0, 0, 0, 0, 0 } },
        { "abs(t)", 0, { 0, 1, 0, 0, 0, 0 } },
        { "abs(-t)", 0, { 0, 1, 0, 0, 0, 0 } },
        { "abs(t^3 - t^2)", 0, { 0, 0, 1, -1, 0, 0 } },
        { "max(t, -t)", 0, { 0, 1, 0, 0, 0, 0 } },
        { "min(t, t^2)", 0, { 0, 0, 1, 0, 0, 0 } },
        { "min(t, 0)", 0, { 0, 0, 0, 0, 0, 0 } },
        { "sign(t)", 2, { 1, 0, 0, 0, 0, 0 } },
        { "mod(t, 1)", 2.5, { 0.5, 1, 0, 0, 0, 0 } },
        { "sqrt(t*0)", 3, { 0, 0, 0, 0, 0, 0 } },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWNED(lw_expression) *x = parse(known[i].text);
        double v[6] = { known[i].t0, 1 }, c[6];
        if (!x)
            continue;
        lw_expression_series(x, 5, v, c);
        for (int k = 0; k < 6; k++)
            if (isnan(known[i].want[k]))
                CHECK(isnan(c[k]));
            else
                CHECK_NEAR(c[k], known[i].want[k], 4e-16, 4e-16);
    }
    OWNED(lw_expression) *seven = parse("7");
    double c[4];
    if (!seven)
        return;
    lw_expression_series(seven, 3, NULL, c);
    CHECK_NEAR(c[0], 7, 0, 0);
    CHECK_NEAR(c[3], 0, 0, 0);
}

TEST(gradients_at_kinks)
{
    static const struct { const char *text; double at, want; } known[] = {
        { "abs(t)", 0, 1 }, { "step(t, 0, 0, 1, 1)", 0, 0 }, { "step(t, 0, 0, 1, 1)", 1, 0 },
        { "max(0, sqrt(t))*0 + t", 0, 1 }, { "max(1, sqrt(t))", 0, 0 }, { "hypot(t, t)", 0, 0 },
        { "table(t, 0, 0, 1, 1, 2, 0)", -1, 1.5 }, { "t^2", 0, 0 }, { "t^1", 0, 1 }, { "t^0", 0, 0 },
        { "sign(t)", 0, 0 }, { "t*sqrt(t)", 0, 0 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWNED(lw_expression) *x = parse(known[i].text);
        double dv = 99;
        if (!x)
            continue;
        lw_expression_gradient(x, &known[i].at, &dv);
        CHECK_NEAR(dv, known[i].want, 1e-14, 0);
    }
}

/* Kinks whose time is known, one after the other; at 1.5 two operands change over that are not chosen. */
TEST(kinks_of_the_time)
{
    static const struct { const char *text; double at[5]; } known[] = {
        { "abs(2*t - 1)", { 0.5, INFINITY } }, { "max(0, min(t - 1, 2 - t))", { 1, 1.5, 2, INFINITY } },
        { "min(t, 3 - t, 1)*sin(t)", { 1, 1.5, 2, INFINITY } }, { "abs(abs(t - 2) - 1)", { 1, 2, 3, INFINITY } },
        { "step(mod(t, 1), 0.25, 0, 0.5, 1)", { 0.25, 0.5, 1, 1.25, 1.5 } }, { "max(abs(t - 1), 2*sign(t - 2))", { 1, 2, 3, INFINITY } },
        { "max(x(P), t)", { INFINITY } }, { "t^2", { INFINITY } }, { "sign(sin(pi*t))", { 1, 2, 3, 4, 5 } },
        { "mod(t^2, 4)", { 2, 2.8284271247461903, 3.4641016151377544, 4, 4.47213595499958 } }, { "abs(log(t + 1) - 0.5)", { 0.6487212707001282, INFINITY } },
        { "max(0, cos(pi*t))*x(P)", { 0.5, 1.5, 2.5, 3.5, 4.5 } }, { "abs(sin(t)^2)", { INFINITY } },
        { "sign(tan(pi*t))", { 0.5, 1, 1.5, 2, 2.5 } }, { "table(2*sin(pi*t), -2, 0, 1, 3, 2, 1)", { 1.0/6, 5.0/6, 13.0/6, 17.0/6, 25.0/6 } } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWNED(lw_expression) *x = parse(known[i].text);
        double t = 0;
        for (int k = 0; x && k < 5 && t < INFINITY; k++) {
            t = lw_expression_next_kink(x, 0, t + 1e-12, 20);
            CHECK(t == known[i].at[k] || fabs(t - known[i].at[k]) < 1e-9);
        }
    }
}

/* Poles, ever faster oscillations and jumps are found; functions that only have an infinite slope, or whose parts jump, have none. */
TEST(breaks)
{
    static const struct { const char *text; double at, by; } known[] = {
        { "1/(1-t)", 1, INFINITY }, { "1/(t-0.5)^2", 0.5, INFINITY }, { "1e-6/(t-1/3)", 1.0/3, INFINITY }, { "tan(2*t)", LW_PI/4, INFINITY },
        { "sin(1/(1-t))", 1, INFINITY }, { "log(t-1)", INFINITY, 0 }, { "exp(100*t)", 0.28987896, INFINITY }, { "sign(t-1)", 1, 1 },
        { "atan(1/(1-t))", 1, LW_PI }, { "2*step(t,1,0,1.5,1)", INFINITY, 0 }, { "sqrt(abs(t-1))", INFINITY, 0 }, { "exp(-1/(t-1)^2)", INFINITY, 0 },
        { "mod(t,0.1)*(0.1-mod(t,0.1))", INFINITY, 0 }, { "1e4*sin(1e4*t)", INFINITY, 0 }, { "tanh(1e10*(t-1))", INFINITY, 0 }, { "1/(x(P)-t)", INFINITY, 0 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWNED(lw_expression) *x = parse(known[i].text);
        double by = 0, t = x ? lw_expression_next_break(x, 0, 0, 2, 0.1, &by) : NAN;
        CHECK(t == known[i].at || fabs(t - known[i].at) < 3e-5);
        CHECK(t == INFINITY || by == known[i].by || fabs(by - known[i].by) < 1e-6);
    }
}

/* Between samples of a calm interval a function changes by less than the samples show, or by little: looked at a thousand times as
 * densely.  A smooth function takes few intervals. */
TEST(calm_intervals)
{
    static const struct { const char *text; int most; } known[] = {
        { "exp(-((t - 0.5)/1e-3)^2)", 100 }, { "1/(1 + ((t - 2.1)/1e-4)^2)", 100 }, { "tanh(1000*(t - 1))", 100 }, { "sin(3*t)^50", 100 },
        { "exp(-(sin(3*t)/1e-3)^2)", 300 }, { "sin(10*t)", 40 }, { "cosh(t)^3", 20 }, { "sqrt(t + 1)*atan2(t, 2)", 4 }, { "hypot(sin(t), 2)", 20 },
        { "2^(-3*t)", 20 }, { "asin(t/4)", 4 }, { "t^3 - 2*t", 4 }, { "acos(t/4) + log(1 + t)", 4 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWNED(lw_expression) *x = parse(known[i].text);
        int n = 0;
        for (double t = 0; x && t < 3 && n < 1000; n++) {
            double end = lw_expression_calm(x, 0, false, 0, t, 3, 3e-9), low = INFINITY, high = -INFINITY;
            CHECK(end > t && end <= 3);
            for (int k = 0; k <= LW_CALM_SAMPLES; k++) {
                double at = t + (end - t)*k/LW_CALM_SAMPLES, f = lw_expression_value(x, &at);
                low = fmin(low, f), high = fmax(high, f);
            }
            for (int k = 0; k < 1000*LW_CALM_SAMPLES; k++) {
                double at = t + (end - t)*k/(1000*LW_CALM_SAMPLES), f = lw_expression_value(x, &at), room = high - low + 1e-3*fabs(f) + 1e-8;
                CHECK(f > low - room && f < high + room);
            }
            t = end;
        }
        CHECK(n <= known[i].most);
    }
}

TEST(locale_does_not_matter)
{
    static const char *const names[] = { "de_DE.UTF-8", "fi_FI.UTF-8", "fr_FR.UTF-8", "tr_TR.UTF-8" };
    double want = at("1.5*t + 0.25", 2, 0);
    for (size_t i = 0; i < sizeof names/sizeof *names; i++)
        if (setlocale(LC_ALL, names[i]))
            CHECK_NEAR(at("1.5*t + 0.25", 2, 0), want, 0, 0);
    setlocale(LC_ALL, "C");
    CHECK_NEAR(want, 3.25, 0, 0);
}

TEST(the_caller_is_asked_for_names)
{
    int n = 0;
    lw_expression *x;
    CHECK_INT(lw_expression_parse("t + x(P) + sin(t) + pi", 22, lookup, &n, &x, NULL), LW_OK);
    CHECK_INT(n, 3);
    CHECK_INT(lw_expression_variables(x, NULL), 2);
    lw_expression_free(x);
    lw_expression_free(NULL);
}
