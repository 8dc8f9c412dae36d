/* Decimal text to double and back. */
#include <locale.h>

#include "base/number.h"
#include "tests/check.h"

static lw_status parse(const char *s, double *v) { return lw_number_parse(s, strlen(s), v); }

TEST(what_is_a_number)
{
    static const struct { const char *text; double want; } good[] = {
        { "0", 0 }, { "-1", -1 }, { "+2", 2 }, { ".5", 0.5 }, { "3.", 3 }, { "1e3", 1000 },
        { "1E-3", 0.001 }, { "-0.25e+2", -25 }, { "00012", 12 }, { "1e-400", 0 },
        { "4.9406564584124654e-324", 4.9406564584124654e-324 },
        { "1.7976931348623157e308", 1.7976931348623157e308 },
    };
    for (size_t i = 0; i < sizeof good/sizeof *good; i++) {
        double v = 99;
        CHECK_INT(parse(good[i].text, &v), LW_OK);
        CHECK_NEAR(v, good[i].want, 0, 0);
    }
}

TEST(what_is_none)
{
    static const char *const bad[] = {
        "", " ", "1 ", " 1", "x", "1x", "1e", "1e+", "e5", ".", "-", "+", "--1", "+-1", "1,5", "1.2.3",
        "0x10", "1p3", "nan", "inf", "-inf", "NaN(1)", "1_000", "1e5.5", ("\xef\xbb\xbf" "1") };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        double v = 99;
        CHECK_INT(parse(bad[i], &v), LW_E_NOTATION);
        CHECK_NEAR(v, 99, 0, 0);
    }
    double v = 99;
    CHECK_INT(lw_number_parse("1\0", 2, &v), LW_E_NOTATION);
    CHECK_INT(parse("1e309", &v), LW_E_NUMERIC);
    CHECK_INT(parse("-1e999999999999999999999", &v), LW_E_NUMERIC);
    CHECK_NEAR(v, 99, 0, 0);
}

TEST(only_the_span_is_read)
{
    double v;
    CHECK_INT(lw_number_parse("12345", 3, &v), LW_OK);
    CHECK_NEAR(v, 123, 0, 0);
}

/* 1 + 2^-53 lies half way between two doubles and goes to the even one; a digit far behind decides. */
TEST(rounding_looks_at_every_digit)
{
    char text[1200] = "1.00000000000000011102230246251565404236316680908203125";
    double v;
    CHECK_INT(parse(text, &v), LW_OK);
    CHECK_NEAR(v, 1, 0, 0);
    size_t n = strlen(text);
    memset(text + n, '0', 700);
    strcpy(text + n + 700, "1");
    CHECK_INT(parse(text, &v), LW_OK);
    CHECK_NEAR(v, 1 + 0x1p-52, 0, 0);
    memset(text, '1', 1001);
    text[1001] = '\0';
    CHECK_INT(parse(text, &v), LW_E_NOTATION);
}

TEST(words_that_are_no_numbers)
{
    static const char *const words[] = { "nan", "NaN", "-nan", "inf", "+Inf", "-INFINITY" };
    for (size_t i = 0; i < sizeof words/sizeof *words; i++)
        CHECK(lw_number_is_word(words[i], strlen(words[i])));
    CHECK(!lw_number_is_word("na", 2));
    CHECK(!lw_number_is_word("", 0));
    CHECK(!lw_number_is_word("info", 4));
}

TEST(every_bit_pattern_comes_back)
{
    lw_rng r = check_rng(0);
    for (int i = 0; i < 20000; i++) {
        uint64_t bits = lw_rng_bits(&r), back_bits;
        double v, back = 0;
        char text[LW_NUMBER_SIZE];
        memcpy(&v, &bits, sizeof v);
        if (!isfinite(v))
            continue;
        lw_number_print(v, text);
        CHECK_INT(parse(text, &back), LW_OK);
        memcpy(&back_bits, &back, sizeof back);
        CHECK(bits == back_bits);
    }
}

TEST(short_where_short_is_exact)
{
    char text[LW_NUMBER_SIZE];
    static const struct { double v; const char *want; } cases[] = {
        { 0.1, "0.1" }, { -0.0, "-0" }, { 1./3, "0.3333333333333333" }, { 1e22, "1e+22" },
        { 0.1 + 0.2, "0.30000000000000004" }, { 20, "20" }, { 1./0., "inf" }, { -1./0., "-inf" } };
    for (size_t i = 0; i < sizeof cases/sizeof *cases; i++) {
        lw_number_print(cases[i].v, text);
        CHECK_TEXT(text, cases[i].want);
    }
    lw_number_print_in(0.03, 0.001, text);
    CHECK_TEXT(text, "30");
    lw_number_print_in(0.0254*7, 0.0254, text);
    CHECK_TEXT(text, "7");
}

/* What printf writes in the first of 15, 16, 17 digits that strtod reads back as v. */
static void print_by_libc(double v, double unit, char text[LW_NUMBER_SIZE])
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, LW_NUMBER_SIZE, "%.*g", digits, v/unit);
        if (!isfinite(v/unit) || strtod(text, NULL)*unit == v)
            break;
    }
}

static bool prints_as_libc(double v, double unit)
{
    char text[LW_NUMBER_SIZE], want[LW_NUMBER_SIZE];
    lw_number_print_in(v, unit, text);
    print_by_libc(v, unit, want);
    if (strcmp(text, want) != 0)
        printf("    %a in %g: %s, printf %s\n", v, unit, text, want);
    return strcmp(text, want) == 0;
}

/* Every magnitude, few digits, whole numbers, powers of 2 and 10 with their neighbours, ties. */
TEST(same_text_as_printf)
{
    int wrong = 0;
    lw_rng r = check_rng(2);
    for (int i = 0; i < 60000 && wrong < 10; i++) {
        uint64_t bits = lw_rng_bits(&r);
        double v, u = lw_rng_normal(&r);
        memcpy(&v, &bits, sizeof v);
        wrong += isfinite(v) && !prints_as_libc(v, 1);
        wrong += !prints_as_libc(ldexp(u, i % 240 - 140), 1) + !prints_as_libc(round(1e4*u)/1e4, 1)
               + !prints_as_libc(round(u*ldexp(1, i % 64)), 1) + !prints_as_libc((double)(bits >> i % 64), 1)
               + !prints_as_libc(u, 0.001) + !prints_as_libc(round(1e3*u)*0.001, 0.001) + !prints_as_libc(u, 3.14159265358979323846/180)
               + !prints_as_libc((double)(bits % (1 << 20))*ldexp(1, -(i % 60)), 1);
    }
    for (int e = -330; e <= 310; e++)
        for (int k = 0; k < 4; k++) {
            double v = k < 2 ? ldexp(1, 3*e) : pow(10, e);
            for (int step = -3; step <= 3 && isfinite(v); step++) {
                double w = v;
                for (int i = 0; i < abs(step); i++)
                    w = nextafter(w, step < 0 ? 0 : INFINITY);
                wrong += !prints_as_libc(k % 2 ? -w : w, 1);
            }
        }
    for (int e = -1074; e <= 1023; e++)
        wrong += !prints_as_libc(ldexp(1, e), 1) + !prints_as_libc(nextafter(ldexp(1, e), 0), 1);
    CHECK_INT(wrong, 0);
}

/* Written in another unit and read back: the bits again or their neighbour. */
TEST(units_cost_one_rounding_at_most)
{
    lw_rng r = check_rng(1);
    for (int i = 0; i < 5000; i++) {
        double v = lw_rng_normal(&r), w = 0;
        char text[LW_NUMBER_SIZE];
        lw_number_print_in(v, 0.001, text);
        CHECK_INT(parse(text, &w), LW_OK);
        CHECK_NEAR(w*0.001, v, 0, 0x1p-51);
    }
}

TEST(locale_does_not_matter)
{
    static const char *const names[] = { "de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "ps_AF.UTF-8" };
    for (size_t i = 0; i < sizeof names/sizeof *names; i++) {
        double v = 0;
        char text[LW_NUMBER_SIZE];
        setlocale(LC_ALL, names[i]);                 /* may not be installed: then nothing changes */
        CHECK_INT(parse("1.5", &v), LW_OK);
        CHECK_NEAR(v, 1.5, 0, 0);
        lw_number_print(2.25, text);
        CHECK_TEXT(text, "2.25");
    }
    setlocale(LC_ALL, "C");
}
