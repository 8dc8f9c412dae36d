#include "base/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/c_locale.h"
#include "base/real.h"
#include "base/whole.h"

#define NUMBER_TEXT_MAX 1000    /* 767 digits decide the rounding of every double */

static size_t skip_digits(const char *s, size_t i, size_t n)
{
    while (i < n && s[i] >= '0' && s[i] <= '9')
        i++;
    return i;
}

static bool is_number(const char *s, size_t n)
{
    size_t i = n > 0 && (s[0] == '+' || s[0] == '-'), start = i;
    i = skip_digits(s, i, n);
    size_t n_digit = i - start;
    if (i < n && s[i] == '.') {
        start = ++i;
        i = skip_digits(s, i, n);
        n_digit += i - start;
    }
    if (n_digit == 0)
        return false;
    if (i < n && (s[i] == 'e' || s[i] == 'E')) {
        i++;
        if (i < n && (s[i] == '+' || s[i] == '-'))
            i++;
        start = i;
        i = skip_digits(s, i, n);
        if (i == start)
            return false;
    }
    return i == n;
}

lw_status lw_number_parse(const char *s, size_t n, double *out)
{
    char text[NUMBER_TEXT_MAX + 1];
    if (n > NUMBER_TEXT_MAX || !is_number(s, n))
        return LW_E_NOTATION;
    memcpy(text, s, n);
    text[n] = '\0';
    lw_c_locale old = lw_c_locale_enter();
    double v = strtod(text, NULL);
    lw_c_locale_leave(old);
    if (!isfinite(v))
        return LW_E_NUMERIC;
    *out = v;
    return LW_OK;
}

bool lw_number_is_word(const char *s, size_t n)
{
    static const char *const words[] = { "nan", "inf", "infinity", "1.#inf", "1.#qnan" };
    if (n > 0 && (*s == '+' || *s == '-'))
        s++, n--;
    for (size_t i = 0; i < sizeof words/sizeof *words; i++)
        if (strlen(words[i]) == n && strncasecmp(s, words[i], n) == 0)
            return true;
    return false;
}

/* ---- printing ---------------------------------------------------------------------------------- */

/* %.*g with a point, whatever the locale writes there (one byte or several). */
static void print_digits(double v, int digits, char text[LW_NUMBER_SIZE])
{
    char raw[2*LW_NUMBER_SIZE];
    int n = 0;
    snprintf(raw, sizeof raw, "%.*g", digits, v);
    for (const char *s = raw; *s && n < LW_NUMBER_SIZE - 1; s++)
        if (strchr("0123456789+-einfa", *s))
            text[n++] = *s;
        else if (n == 0 || text[n-1] != '.')
            text[n++] = '.';
    text[n] = '\0';
}

#define DIGITS    17
#define LEAST     1e-36                 /* beyond these two, the numbers below do not fit            */
#define GREATEST  1e17

/* The first 17 digits of v = m 2^e, and exactly what is behind them: with p = 17 - point,
 *     m 5^p = first 2^shift + rest,  0 <= rest < 2^shift;  neighbours of v lie `unit` = 5^p apart in this scale. */
typedef struct decimal {
    uint64_t first;
    lw_whole rest, unit;
    int      shift, point;              /* point: digits before the decimal point                    */
    bool     negative, even, least;     /* m is even; m is 2^52: the neighbour below is half as near */
} decimal;

static uint64_t five_to(int p)
{
    uint64_t v = 1;
    for (uint64_t f = 5; p; p >>= 1, f *= f)
        if (p & 1)
            v *= f;
    return v;
}

static void take_digits(uint64_t m, int e, int p, decimal *d)
{
    d->unit = (lw_whole)five_to(p > 27 ? 27 : p)*five_to(p > 27 ? p - 27 : 0);         /* 5^27 < 2^64 */
    lw_whole low = (lw_whole)m*(uint64_t)d->unit, high = (lw_whole)m*(uint64_t)(d->unit >> 64) + (low >> 64);
    int s = d->shift = -(e + p) > 0 ? -(e + p) : 0;
    d->rest = 0;
    if (s == 0) {                                                     /* an integer below 1e17 */
        d->first = (uint64_t)low << (e + p);
        d->unit <<= e + p;
    } else if (s < 64) {
        d->first = (uint64_t)(high << (64 - s)) | (uint64_t)low >> s;
        d->rest = (uint64_t)low & (((uint64_t)1 << s) - 1);
    } else {
        d->first = (uint64_t)(high >> (s - 64));
        d->rest = (high & (((lw_whole)1 << (s - 64)) - 1)) << 64 | (uint64_t)low;
    }
}

static bool decimal_of(double v, decimal *d)
{
    int e;
    double a = fabs(v);
    if (!(a >= LEAST && a < GREATEST))
        return false;
    uint64_t m = (uint64_t)ldexp(frexp(a, &e), 53);
    d->negative = v < 0;
    d->even = m % 2 == 0;
    d->least = m == (uint64_t)1 << 52;
    d->point = (int)floor((e - 1)*0.30102999566398120) + 1;           /* or one more */
    take_digits(m, e - 53, DIGITS - d->point, d);
    if (d->first >= (uint64_t)1e17)
        take_digits(m, e - 53, DIGITS - ++d->point, d);
    return true;
}

/* Round to 15, 16 or 17 digits, half to even, and write them as %.*g does. Does the text read back as the same double? */
static bool put_decimal(const decimal *d, int digits, char text[LW_NUMBER_SIZE])
{
    uint64_t ten = digits == 15 ? 100 : digits == 16 ? 10 : 1, q = d->first/ten, r = d->first % ten;
    lw_whole half = d->shift ? (lw_whole)1 << (d->shift - 1) : 0;
    if (ten > 1 ? r > ten/2 || (r == ten/2 && (d->rest > 0 || q % 2)) : half && (d->rest > half || (d->rest == half && q % 2)))
        q++;
    int64_t off = (int64_t)(q*ten - d->first);                        /* a unit is at most 22.3 2^shift */
    bool back = off >= -12 && off <= 12;
    if (back) {
        lw_whole apart = off > 0 ? ((lw_whole)off << d->shift) - d->rest : ((lw_whole)-off << d->shift) + d->rest;
        apart *= d->least && off <= 0 ? 4 : 2;
        back = apart < d->unit || (apart == d->unit && d->even);
    }
    int exponent = d->point - 1, n = digits;
    if (q == (uint64_t)1e17/ten) {
        q /= 10;
        exponent++;
    }
    char digit[DIGITS], *o = text;
    for (int i = digits; i-- > 0; q /= 10)
        digit[i] = (char)('0' + q % 10);
    while (n > 1 && digit[n-1] == '0')
        n--;
    bool power = exponent < -4 || exponent >= digits;
    int point = power ? 0 : exponent;                                 /* the digit before the point */
    if (d->negative)
        *o++ = '-';
    for (int i = point < 0 ? point : 0; i < n || i <= point; i++) {
        if (i == point + 1)
            *o++ = '.';
        *o++ = i >= 0 && i < n ? digit[i] : '0';
    }
    if (power) {
        *o++ = 'e';
        *o++ = exponent < 0 ? '-' : '+';
        *o++ = (char)('0' + abs(exponent)/10);
        *o++ = (char)('0' + abs(exponent) % 10);
    }
    *o = '\0';
    return back;
}

void lw_number_print_in(double v, double unit, char text[LW_NUMBER_SIZE])
{
    double w = v/unit;
    decimal d;
    bool known = decimal_of(w, &d);
    for (int digits = 15; digits <= DIGITS; digits++) {
        double back = w;
        if (!known)
            print_digits(w, digits, text);
        if (!(known && put_decimal(&d, digits, text))) {
            if (known && unit == 1)
                continue;
            if (lw_number_parse(text, strlen(text), &back) != LW_OK)
                break;
        }
        if (back*unit == v)
            break;
    }
}

void lw_number_print(double v, char text[LW_NUMBER_SIZE])
{
    lw_number_print_in(v, 1, text);
}

const char *lw_plural(long long n)
{
    return n == 1 ? "" : "s";
}
