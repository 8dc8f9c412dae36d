/* test_real.c - the elementary functions of base/real.h: errors against the C library's functions of long double, special
 * values against its functions of double, exact cases, and known bits. */
#include <float.h>
#include "base/real.h"
#include "tests/check.h"

/* The C library's functions of double, which the macros would replace. */
typedef double function(double x);
typedef double function_2(double x, double y);
typedef struct row {
    const char   *name;
    function     *own, *library;
    long double (*reference)(long double x);
    double        least, most, error;                /* arguments; greatest error [units in the last place] */
} row;

static const row rows[] = {
    { "sin", lw_real_sin, (sin), sinl, -8, 8, 0.9 },          { "sin", lw_real_sin, (sin), sinl, -1e6, 1e6, 0.9 },
    { "sin", lw_real_sin, (sin), sinl, 1e6, 1e18, 0.9 },      { "sin", lw_real_sin, (sin), sinl, -1e-6, 1e-6, 0.9 },
    { "cos", lw_real_cos, (cos), cosl, -8, 8, 0.9 },          { "cos", lw_real_cos, (cos), cosl, -1e6, 1e6, 0.9 },
    { "cos", lw_real_cos, (cos), cosl, -1e300, 1e300, 0.9 },  { "tan", lw_real_tan, (tan), tanl, -20, 20, 2.5 },
    { "atan", lw_real_atan, (atan), atanl, -3, 3, 0.55 },     { "atan", lw_real_atan, (atan), atanl, -1e9, 1e9, 0.55 },
    { "asin", lw_real_asin, (asin), asinl, -1, 1, 2.5 },      { "acos", lw_real_acos, (acos), acosl, -1, 1, 2.5 },
    { "exp", lw_real_exp, (exp), expl, -1, 1, 0.9 },          { "exp", lw_real_exp, (exp), expl, -740, 709, 0.9 },
    { "log", lw_real_log, (log), logl, 0.5, 2, 0.55 },        { "log", lw_real_log, (log), logl, 0, 1e300, 0.55 },
    { "log2", lw_real_log2, (log2), log2l, 0, 100, 0.55 },    { "log10", lw_real_log10, (log10), log10l, 0, 100, 0.55 },
    { "sinh", lw_real_sinh, (sinh), sinhl, -2, 2, 2.5 },      { "sinh", lw_real_sinh, (sinh), sinhl, -710, 710, 2.9 },
    { "cosh", lw_real_cosh, (cosh), coshl, -3, 3, 2.5 },      { "cosh", lw_real_cosh, (cosh), coshl, -710, 710, 2.9 },
    { "tanh", lw_real_tanh, (tanh), tanhl, -3, 3, 2.9 },
};

enum { N_ROW = sizeof rows/sizeof *rows, N_TRIAL = 20000 };

/* |got - want| in units of the last place of want, or of the least normal number. */
static double units(double got, long double want)
{
    int e;
    if (got == (double)want && isinf(got))
        return 0;
    frexpl(want, &e);
    if (got == (double)want)
        return fabs((double)((got - want)/ldexpl(1, (e < -1021 ? -1021 : e) - 53)));
    return (double)(fabsl(got - want)/ldexpl(1, (e < -1021 ? -1021 : e) - 53));
}

TEST(errors_are_small)
{
    lw_rng rng = check_rng(0);
    for (int i = 0; i < N_ROW; i++) {
        double worst = 0, at = 0;
        for (int n = 0; n < N_TRIAL; n++) {
            double x = lw_rng_range(&rng, rows[i].least, rows[i].most), u = units(rows[i].own(x), rows[i].reference(x));
            if (!(u <= worst))
                worst = u, at = x;
        }
        if (!(worst <= rows[i].error))
            fprintf(stderr, "%s(%a): %.3f units\n", rows[i].name, at, worst);
        CHECK(worst <= rows[i].error);
    }
}

/* Both coordinates over many sizes. */
TEST(two_arguments)
{
    double worst[5] = { 0 };
    lw_rng rng = check_rng(1);
    for (int n = 0; n < N_TRIAL; n++) {
        int e = n % 2 ? 4 : 900;
        double x = ldexp(lw_rng_range(&rng, -1, 1), (int)lw_rng_range(&rng, -e, e));
        double y = ldexp(lw_rng_range(&rng, -1, 1), (int)lw_rng_range(&rng, -e, e));
        double base = fabs(ldexp(x, n % 2 ? 0 : -800)) + 1e-3, by = lw_rng_range(&rng, -20, 20);
        double whole = lw_real_pow(base, floor(by)), of_whole = units(whole, powl(base, floor(by)));
        double u[5] = { units(lw_real_atan2(y, x), atan2l(y, x)), units(lw_real_hypot(x, y), hypotl(x, y)),
                        units(lw_real_pow(base, by), powl(base, by)),
                        fabs(whole) >= DBL_MIN ? of_whole : 0, of_whole };
        for (int k = 0; k < 5; k++)
            worst[k] = u[k] <= worst[k] ? worst[k] : u[k];
    }
    CHECK_NEAR(worst[0], 0, 0.55, 0);
    CHECK_NEAR(worst[1], 0, 0.55, 0);
    CHECK_NEAR(worst[2], 0, 0.9, 0);
    CHECK_NEAR(worst[3], 0, 0.55, 0);
    CHECK_NEAR(worst[4], 0, 0.8, 0);                     /* subnormal results are rounded twice */
}

static int same(double a, double b) { return (isnan(a) && isnan(b)) || (a == b && !signbit(a) == !signbit(b)); }

static const double special[] = { 0.0, -0.0, 1, -1, 0.5, 2, -2, 3, -3, 1e-320, -1e-320, 1e-300, 1e308, -1e308, INFINITY,
                                 -INFINITY, NAN, 4503599627370497.5, 9007199254740993.0 };

TEST(special_values)
{
    enum { N = sizeof special/sizeof *special };
    static const struct { const char *name; function_2 *own, *library; } pairs[] = {
        { "atan2", lw_real_atan2, (atan2) }, { "pow", lw_real_pow, (pow) }, { "hypot", lw_real_hypot, (hypot) },
    };
    for (int i = 0; i < N_ROW; i++)
        for (int k = 0; k < N; k++) {
            double x = special[k], own = rows[i].own(x), library = rows[i].library(x);
            int edge = x == 0 || isinf(x) || isnan(x) || isnan(library) || isinf(library);
            if (edge ? !same(own, library) : units(own, rows[i].reference(x)) > rows[i].error)
                fprintf(stderr, "%s(%g) = %a, not %a\n", rows[i].name, x, own, library);
            CHECK(edge ? same(own, library) : units(own, rows[i].reference(x)) <= rows[i].error);
        }
    for (int f = 0; f < 3; f++)
        for (int i = 0; i < N; i++)
            for (int k = 0; k < N; k++) {
                double own = pairs[f].own(special[i], special[k]), library = pairs[f].library(special[i], special[k]);
                int good = same(own, library) || units(own, library) <= 1;
                if (!good)
                    fprintf(stderr, "%s(%g, %g) = %a, not %a\n", pairs[f].name, special[i], special[k], own, library);
                CHECK(good);
            }
}

TEST(exact_cases)
{
    double ten = 1;
    for (int n = 0; n <= 22; n++, ten *= 10) {
        CHECK(lw_real_pow(10, n) == ten);
        CHECK(lw_real_log10(ten) == n);
        CHECK(lw_real_pow(10, -n) == 1/ten);
        CHECK(lw_real_exp(lw_real_log(2)*n) > 0);
    }
    for (int n = -1074; n < 1024; n++) {
        CHECK(lw_real_pow(2, n) == ldexp(1, n));
        CHECK(lw_real_log2(ldexp(1, n)) == n);
    }
    for (int k = -50; k < 50; k++) {
        double s, c;
        lw_real_sincos(0.7*k, &s, &c);
        CHECK(s == lw_real_sin(0.7*k) && c == lw_real_cos(0.7*k));
    }
    CHECK(lw_real_hypot(3, 4) == 5);
    CHECK(lw_real_exp(0) == 1);
    CHECK(lw_real_cos(0) == 1);
}

/* The same bits on every machine: a hash of many results, once worked out on x86-64. */
TEST(known_bits)
{
    uint64_t hash = 14695981039346656037u;
    lw_rng rng;
    lw_rng_seed(&rng, 1, 2);
    for (int n = 0; n < 1000; n++)
        for (int i = 0; i < N_ROW; i++) {
            double v = rows[i].own(lw_rng_range(&rng, rows[i].least, rows[i].most));
            uint64_t bits;
            memcpy(&bits, &v, sizeof bits);
            hash = (hash ^ bits)*1099511628211u;
        }
    CHECK(hash == UINT64_C(0xa1766c9e23a0f648));
}
