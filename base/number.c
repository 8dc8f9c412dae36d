#include "base/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/c_locale.h"
#include "base/real.h"

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

void lw_number_print_in(double v, double unit, char text[LW_NUMBER_SIZE])
{
    double w = v/unit;
    for (int digits = 15; digits <= 17; digits++) {
        double back;
        print_digits(w, digits, text);
        if (lw_number_parse(text, strlen(text), &back) != LW_OK || back*unit == v)
            break;
    }
}

void lw_number_print(double v, char text[LW_NUMBER_SIZE])
{
    lw_number_print_in(v, 1, text);
}
