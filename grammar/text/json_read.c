/* JSON texts into values of jansson.  jansson's own reader is not used: where memory is short it loses bytes of strings and numbers
 * without an error, and then reads past its memory. */
#include "grammar/text/json_internal.h"

#include <errno.h>
#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/c_locale.h"
#include "base/real.h"
#include "grammar/text/json_locate_internal.h"

enum { MOST_NESTED = 2048, LONGEST_NUMBER = 1000 };

typedef struct reader {
    const char   *text;
    size_t        size, at;
    size_t        flags;          /* jansson's */
    int           depth;
    lw_status     status;
    json_error_t *fault;
} reader;

static json_t *read_value(reader *r);

static int peek(const reader *r) { return r->at < r->size ? (unsigned char)r->text[r->at] : -1; }

static int next_token(reader *r)
{
    while (r->at < r->size && (r->text[r->at] == ' ' || r->text[r->at] == '\t' || r->text[r->at] == '\r' || r->text[r->at] == '\n'))
        r->at++;
    return peek(r);
}

static void refuse(reader *r, size_t at, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void refuse(reader *r, size_t at, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    vsnprintf(r->fault->text, sizeof r->fault->text, format, arg);
    va_end(arg);
    r->at = at;
    r->status = LW_E_NOTATION;
}

/* Number of bytes of the word or number at `at`. */
static size_t word_length(const reader *r, size_t at)
{
    size_t n = 0;
    while (at + n < r->size && !strchr(" \t\r\n,:[]{}\"", r->text[at + n]))
        n++;
    return n;
}

/* Something else than `expected` is here. */
static void unexpected(reader *r, const char *expected)
{
    size_t n = word_length(r, r->at);
    char here[24], clean[64];
    if (r->at == r->size) {
        refuse(r, r->at, "the text ends where %s is expected", expected);
        return;
    }
    snprintf(here, sizeof here, "%.*s", (int)(n == 0 ? 1 : n < 20 ? n : 20), r->text + r->at);
    lw_text_clean(clean, sizeof clean, here);
    refuse(r, r->at, "%s is expected here, not '%s'", expected, clean);
}

static void *no_memory(reader *r)
{
    r->status = LW_E_MEMORY;
    return NULL;
}

/* The four digits of \uXXXX; -1: they are none. */
static long hexadecimal(const char *digits)
{
    char four[5];
    snprintf(four, sizeof four, "%.4s", digits);
    return strspn(four, "0123456789abcdefABCDEF") == 4 ? strtol(four, NULL, 16) : -1;
}

/* Write the character of the escape at `at`; returns how many bytes the escape takes, 0: it is none.  `end`: of the string. */
static size_t escape(const reader *r, size_t at, size_t end, char **to)
{
    static const char letters[] = "\"\\/bfnrt", bytes[] = "\"\\/\b\f\n\r\t";
    const char *s = r->text + at, *letter = s[1] ? strchr(letters, s[1]) : NULL;
    if (letter) {
        *(*to)++ = bytes[letter - letters];
        return 2;
    }
    long code = s[1] == 'u' && at + 6 <= end ? hexadecimal(s + 2) : -1, second;
    bool pair = code >= 0xd800 && code < 0xdc00 && at + 12 <= end && s[6] == '\\' && s[7] == 'u' && (second = hexadecimal(s + 8)) >= 0xdc00 && second < 0xe000;
    if (code <= 0 || (code >= 0xd800 && code < 0xe000 && !pair))
        return 0;
    *to += lw_utf8_write((unsigned)(pair ? 0x10000 + ((code - 0xd800) << 10) + (second - 0xdc00) : code), *to);
    return pair ? 12 : 6;
}

/* The string at its opening quote.  Free with free(). */
static char *read_string(reader *r)
{
    size_t start = r->at + 1, end = start, n;
    for (; end < r->size && r->text[end] != '"'; end += r->text[end] == '\\' ? 2 : 1)
        if ((unsigned char)r->text[end] < 0x20) {
            refuse(r, end, "a text between quotes holds a control character; write \\n for a new line, \\t for a tab");
            return NULL;
        }
    if (end >= r->size) {
        refuse(r, start - 1, "the closing quote of this text is missing");
        return NULL;
    }
    char *out = malloc(end - start + 1), *to = out;
    for (size_t i = start; out && i < end; i += n) {
        unsigned code;
        n = r->text[i] == '\\' ? escape(r, i, end, &to) : (size_t)lw_utf8_read(r->text + i, &code);
        if (n == 0) {
            if (r->text[i] == '\\')
                refuse(r, i, "this is no escape of JSON, or of a character 0 or half a pair");
            else
                refuse(r, i, "the byte 0x%02x is no part of UTF-8", (unsigned char)r->text[i]);
            free(out);
            return NULL;
        }
        if (r->text[i] != '\\')
            memcpy(to, r->text + i, n), to += n;
    }
    if (!out)
        return no_memory(r);
    *to = 0;
    r->at = end + 1;
    return out;
}

static size_t skip_digits(const reader *r, size_t at)
{
    while (at < r->size && r->text[at] >= '0' && r->text[at] <= '9')
        at++;
    return at;
}

static json_t *read_number(reader *r)
{
    char digits[LONGEST_NUMBER + 1];
    size_t start = r->at, n = word_length(r, start), end = start + n, at = start + (r->text[start] == '-'), part = skip_digits(r, at);
    bool proper = part > at && (r->text[at] != '0' || part == at + 1), whole = part == end;
    if (proper && part < end && r->text[part] == '.') {
        at = part + 1;
        part = skip_digits(r, at);
        proper = part > at;
    }
    if (proper && part < end && (r->text[part] == 'e' || r->text[part] == 'E')) {
        at = part + 1 + (part + 1 < end && (r->text[part + 1] == '+' || r->text[part + 1] == '-'));
        part = skip_digits(r, at);
        proper = part > at;
    }
    if (!proper || part != end || n > LONGEST_NUMBER) {
        refuse(r, start, n > LONGEST_NUMBER ? "this number has more than %d bytes" : "this is no number of JSON", LONGEST_NUMBER);
        return NULL;
    }
    memcpy(digits, r->text + start, n);
    digits[n] = 0;
    errno = 0;
    double v = strtod(digits, NULL);
    long long integer = whole && !(r->flags & JSON_DECODE_INT_AS_REAL) ? strtoll(digits, NULL, 10) : 0;
    if (!isfinite(v) || (errno && integer)) {
        refuse(r, start, "this number is too large");
        return NULL;
    }
    r->at = end;
    json_t *value = whole && !(r->flags & JSON_DECODE_INT_AS_REAL) ? json_integer(integer) : json_real(v);
    return value ? value : no_memory(r);
}

static json_t *read_word(reader *r)
{
    const char *s = r->text + r->at;
    size_t n = word_length(r, r->at);
    json_t *value = n == 4 && memcmp(s, "true", 4) == 0 ? json_true() : n == 5 && memcmp(s, "false", 5) == 0 ? json_false()
                  : n == 4 && memcmp(s, "null", 4) == 0 ? json_null() : NULL;
    if (value)
        r->at += n;
    else
        unexpected(r, "a value");
    return value;
}

/* One element of an array, or one member of an object. */
static void read_element(reader *r, json_t *array)
{
    json_t *value = read_value(r);
    if (value && json_array_append_new(array, value) != 0)
        no_memory(r);
}

static void read_member(reader *r, json_t *object)
{
    size_t start = r->at;
    if (peek(r) != '"') {
        unexpected(r, "a key in quotes");
        return;
    }
    char *key = read_string(r);
    if (key && (r->flags & JSON_REJECT_DUPLICATES) && json_object_get(object, key))
        refuse(r, start, "a duplicate key: \"%.60s\" stands before in this object", key);
    else if (key && next_token(r) != ':')
        unexpected(r, "':'");
    else if (key) {
        r->at++;
        json_t *value = read_value(r);
        if (value && json_object_set_new_nocheck(object, key, value) != 0)
            no_memory(r);
    }
    free(key);
}

/* The list at '[', or the object at '{'. */
static json_t *read_container(reader *r)
{
    bool object = r->text[r->at] == '{';
    char close = object ? '}' : ']';
    json_t *value = object ? json_object() : json_array();
    if (!value)
        return no_memory(r);
    if (++r->depth > MOST_NESTED)
        refuse(r, r->at, "more than %d lists and objects within one another", MOST_NESTED);
    r->at += r->status == LW_OK;
    for (bool more = r->status == LW_OK && next_token(r) != close; more;) {
        if (object)
            read_member(r, value);
        else
            read_element(r, value);
        more = r->status == LW_OK && next_token(r) == ',';
        r->at += more;
        if (more)
            next_token(r);
        else if (r->status == LW_OK && peek(r) != close)
            unexpected(r, object ? "',' or '}'" : "',' or ']'");
    }
    r->depth--;
    r->at += r->status == LW_OK;
    if (r->status == LW_OK)
        return value;
    json_decref(value);
    return NULL;
}

static json_t *read_value(reader *r)
{
    int c = next_token(r);
    if (c == '{' || c == '[')
        return read_container(r);
    if (c == '-' || (c >= '0' && c <= '9'))
        return read_number(r);
    if (c != '"')
        return read_word(r);
    char *text = read_string(r);
    json_t *value = text ? json_string_nocheck(text) : NULL;
    if (text && !value)
        no_memory(r);
    free(text);
    return value;
}

lw_status lw_json_load(const char *text, size_t size, size_t flags, json_t **root, json_error_t *fault)
{
    *fault = (json_error_t){ .line = 0 };
    reader r = { .text = text, .size = size, .flags = flags, .fault = fault };
    lw_c_locale old = lw_c_locale_enter();          /* strtod */
    int c = next_token(&r);
    *root = NULL;
    if (c == '{' || c == '[')
        *root = read_container(&r);
    else
        unexpected(&r, "'{' or '['");
    lw_c_locale_leave(old);
    if (*root && !(flags & JSON_DISABLE_EOF_CHECK) && next_token(&r) >= 0)
        unexpected(&r, "the end of the text");
    if (r.status != LW_OK) {
        long line, column;
        lw_text_place(text, size, r.at, &line, &column);
        fault->line = (int)line;
        fault->column = (int)column;
        json_decref(*root);
        *root = NULL;
    }
    fault->position = (int)r.at;
    return r.status;
}
