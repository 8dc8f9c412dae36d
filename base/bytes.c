/* base/bytes.c - see bytes.h */
#include "base/bytes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"

void lw_bytes_free(lw_bytes *b)
{
    free(b->data);
    *b = (lw_bytes){ 0 };
}

static bool reserve(lw_bytes *b, size_t more)
{
    if (b->failed)
        return false;
    if (b->room - b->size > more)
        return true;
    size_t room = b->room ? b->room : 4096;
    while (room - b->size <= more) {
        if (room > (size_t)-1/4) {
            b->failed = true;
            return false;
        }
        room *= 2;
    }
    char *data = realloc(b->data, room);
    b->failed = !data;
    if (data) {
        b->data = data;
        b->room = room;
    }
    return !b->failed;
}

void lw_bytes_add(lw_bytes *b, const void *data, size_t size)
{
    if (size > (size_t)-1/4)
        b->failed = true;
    if (!reserve(b, size))
        return;
    if (size)
        memcpy(b->data + b->size, data, size);
    b->size += size;
    b->data[b->size] = 0;
}

void lw_bytes_text(lw_bytes *b, const char *text)
{
    lw_bytes_add(b, text, strlen(text));
}

/* Unicode 15, table 3-7. */
int lw_utf8_read(const char *text, unsigned *code)
{
    const unsigned char *s = (const unsigned char *)text;
    int n = s[0] < 0x80 ? 1 : s[0] >= 0xc2 && s[0] <= 0xdf ? 2 : (s[0] & 0xf0) == 0xe0 ? 3
          : s[0] >= 0xf0 && s[0] <= 0xf4 ? 4 : 0;
    unsigned c = s[0] & (n < 2 ? 0x7fu : 0xffu >> (n + 1));
    for (int i = 1; i < n; i++) {
        if ((s[i] & 0xc0) != 0x80)
            return 0;
        c = c << 6 | (s[i] & 0x3fu);
    }
    bool overlong = (n == 3 && c < 0x800) || (n == 4 && c < 0x10000);
    *code = c;
    return overlong || (c >= 0xd800 && c <= 0xdfff) || c > 0x10ffff ? 0 : n;
}

int lw_utf8_write(unsigned code, char out[4])
{
    static const unsigned first[] = { 0, 0xc0, 0xe0, 0xf0 };       /* of a character with so many more bytes */
    int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3, n = 0;
    out[n++] = (char)(first[more] | code >> 6*more);
    while (more-- > 0)
        out[n++] = (char)(0x80 | (code >> 6*more & 0x3f));
    return n;
}

/* XML 1.0, "Char". */
int lw_text_character(const char *text)
{
    unsigned c;
    int n = lw_utf8_read(text, &c);
    bool barred = (c < 0x20 && c != '\t' && c != '\n') || (c >= 0x7f && c < 0xa0) || (c & 0xfffe) == 0xfffe;
    return barred ? 0 : n;
}

bool lw_text_has_control(const char *text)
{
    for (const unsigned char *s = (const unsigned char *)text; *s; s++)
        if (*s < 0x20 || *s == 0x7f || (*s == 0xc2 && s[1] >= 0x80 && s[1] < 0xa0))
            return true;
    return false;
}

void lw_bytes_xml(lw_bytes *b, const char *text)
{
    const unsigned char *s = (const unsigned char *)text;
    while (*s) {
        int n = lw_text_character((const char *)s);
        switch (n ? *s : 0) {
        case 0:    lw_bytes_text(b, "\xef\xbf\xbd"); n = 1; break;
        case '&':  lw_bytes_text(b, "&amp;");  break;
        case '<':  lw_bytes_text(b, "&lt;");   break;
        case '>':  lw_bytes_text(b, "&gt;");   break;
        case '"':  lw_bytes_text(b, "&quot;"); break;
        case '\'': lw_bytes_text(b, "&#39;");  break;
        default:   lw_bytes_add(b, s, (size_t)n);
        }
        s += n;
    }
}

void lw_text_clean(char *out, size_t size, const char *text)
{
    const unsigned char *s = (const unsigned char *)text;
    size_t used = 0;
    while (*s) {
        int n = lw_text_character((const char *)s);
        size_t m = n ? (size_t)n : 3;
        if (used + m + 1 > size)
            break;
        memcpy(out + used, n ? (const char *)s : "\xef\xbf\xbd", m);
        used += m;
        s += n ? n : 1;
    }
    out[used] = 0;
}

void lw_bytes_fixed(lw_bytes *b, double v, int decimals)
{
    static const double power[] = { 1, 10, 100, 1e3, 1e4, 1e5, 1e6 };
    decimals = decimals < 0 ? 0 : decimals > 6 ? 6 : decimals;
    long long n = fabs(v) < 1e12 ? llround(v*power[decimals]) : 0, unit = (long long)power[decimals];
    char t[40];
    unsigned long long m = (unsigned long long)(n < 0 ? -n : n);
    int size = snprintf(t, sizeof t, "%s%llu", n < 0 ? "-" : "", m / (unsigned long long)unit);
    unsigned long long part = m % (unsigned long long)unit;
    if (part) {
        size += snprintf(t + size, sizeof t - (size_t)size, ".%0*llu", decimals, part);
        while (t[size - 1] == '0')
            size--;
    }
    lw_bytes_add(b, t, (size_t)size);
}

void lw_bytes_integer(lw_bytes *b, long v)
{
    char t[32];
    lw_bytes_add(b, t, (size_t)snprintf(t, sizeof t, "%ld", v));
}

/* The digits of v > 0, rounded to `digits` of them, and its exponent, without printf.  False: v is too large or small, or
 * so near to the middle between two texts that rounding in here could decide. */
static bool quick_digits(double v, int digits, char *d, int *exponent)
{
    static const double power[] = { 1, 10, 100, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
                                    1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };         /* exact */
    if (digits > 9 || !(v >= 1e-9 && v < 1e9))
        return false;
    int e = 0;
    if (v >= 1)
        while (v >= power[e + 1])
            e++;
    else
        for (e = -1; v*power[-e] < 1; e--)
            ;
    int k = digits - 1 - e;
    double x = k < 0 ? v/power[-k] : v*power[k], whole = floor(x), part = x - whole;
    if (fabs(part - 0.5) < 1e-5 || part > 1 - 1e-5)
        return false;
    unsigned long m = (unsigned long)whole + (part > 0.5);
    if (m < (unsigned long)power[digits - 1] || m >= (unsigned long)power[digits])
        return false;
    for (int i = digits; i-- > 0; m /= 10)
        d[i] = (char)('0' + m % 10);
    *exponent = e;
    return true;
}

void lw_number_text(char text[32], double v, int digits)
{
    digits = digits < 1 ? 1 : digits > 17 ? 17 : digits;
    if (!isfinite(v) || v == 0) {
        snprintf(text, 32, "%s", isnan(v) ? "nan" : v == 0 ? "0" : v > 0 ? "inf" : "-inf");
        return;
    }
    char t[48], d[20];                        /* digits and exponent, whatever stands for the point */
    int n = digits, exponent;
    if (!quick_digits(fabs(v), digits, d, &exponent)) {
        snprintf(t, sizeof t, "%.*e", digits - 1, fabs(v));
        char *e = strchr(t, 'e');
        exponent = atoi(e + 1);
        n = 0;
        for (char *c = t; c < e; c++)
            if (*c >= '0' && *c <= '9')
                d[n++] = *c;
    }
    while (n > 1 && d[n - 1] == '0')
        n--;
    char *o = text;
    if (v < 0)
        *o++ = '-';
    if (exponent < -4 || exponent >= (digits > 6 ? digits : 6)) {
        *o++ = d[0];
        if (n > 1)
            *o++ = '.';
        memcpy(o, d + 1, (size_t)(n - 1));
        snprintf(o + n - 1, 8, "e%d", exponent);
        return;
    }
    for (int i = exponent < 0 ? exponent : 0; i < n || i <= exponent; i++) {
        if (i == exponent + 1)
            *o++ = '.';
        *o++ = i >= 0 && i < n ? d[i] : '0';
    }
    *o = 0;
}

void lw_bytes_number(lw_bytes *b, double v, int digits)
{
    char t[32];
    lw_number_text(t, v, digits);
    lw_bytes_text(b, t);
}

bool lw_text_is_utf16(const char *text, size_t size)
{
    return size >= 2 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0);
}

char *lw_text_from_utf16(const char *text, size_t size, size_t *n)
{
    bool big = (unsigned char)text[0] == 0xfe;
    char *out = malloc((size/2 + 1)*3 + 1);
    unsigned pending = 0;                        /* the first half of a pair of surrogates */
    size_t to = 0;
    for (size_t i = 2; out && i < size; i += 2) {
        bool whole = i + 1 < size;
        unsigned unit = whole ? (unsigned)(unsigned char)text[i + !big] << 8 | (unsigned char)text[i + big] : 0xdc00, c = unit;
        bool second = unit >= 0xdc00 && unit < 0xe000;
        if (pending && second) {
            c = 0x10000 + ((pending - 0xd800) << 10) + (unit - 0xdc00);
            to -= 3;
        } else if (second || (unit >= 0xd800 && unit < 0xdc00)) {
            c = 0xfffd;
        }
        pending = unit >= 0xd800 && unit < 0xdc00 ? unit : 0;
        to += (size_t)lw_utf8_write(c, out + to);
    }
    if (out)
        out[to] = 0;
    *n = to;
    return out;
}

lw_status lw_bytes_end(lw_bytes *b, lw_error *e)
{
    if (!b->failed)
        return LW_OK;
    lw_bytes_free(b);
    return lw_error_set(e, LW_E_MEMORY, "not enough memory for the output");
}
