/* studio/put.c - read what a page asks, write what it gets. */
#include "studio/studio_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"

const char *studio_text(const json_t *ask, const char *key, const char *otherwise)
{
    const char *text = json_string_value(json_object_get(ask, key));
    return text ? text : otherwise;
}

double studio_real(const json_t *ask, const char *key, double otherwise)
{
    const json_t *v = json_object_get(ask, key);
    return json_is_number(v) ? json_number_value(v) : otherwise;
}

bool studio_bool(const json_t *ask, const char *key)
{
    return json_is_true(json_object_get(ask, key));
}

lw_status studio_source(const json_t *ask, const char *key, char **text, size_t *size, lw_error *e)
{
    const json_t *v = json_object_get(ask, key);
    *text = json_is_string(v) ? strdup(json_string_value(v)) : json_is_object(v) ? json_dumps(v, JSON_COMPACT) : NULL;
    if (!*text)
        return json_is_string(v) || json_is_object(v) ? lw_error_set(e, LW_E_MEMORY, "out of memory")
                 : lw_error_set(e, LW_E_ARG, "the request has no \"%s\" that is an object or a text", key);
    *size = strlen(*text);
    return LW_OK;
}

lw_status studio_linkage(const json_t *ask, const char *key, lw_linkage *k, lw_error *e)
{
    char *text;
    size_t size;
    lw_status s = studio_source(ask, key, &text, &size, e);
    if (s == LW_OK) {
        s = lw_linkage_read(text, size, "", k, e);
        free(text);
    }
    return s;
}

lw_status studio_parts(const json_t *ask, const char *key, lw_assembly *a, lw_error *e)
{
    char *text;
    size_t size;
    lw_status s = studio_source(ask, key, &text, &size, e);
    if (s == LW_OK) {
        s = lw_assembly_read_result(text, size, "", 0, a, e);
        free(text);
    }
    return s;
}

void studio_put_key(lw_bytes *b, const char *key)
{
    char last = b->size ? b->data[b->size - 1] : '{';
    if (last != '{' && last != '[')
        lw_bytes_add(b, ",", 1);
    if (key) {
        lw_bytes_add(b, "\"", 1);
        lw_bytes_text(b, key);
        lw_bytes_add(b, "\":", 2);
    }
}

void studio_put_text(lw_bytes *b, const char *key, const char *text)
{
    const char *at = text ? text : "";
    for (int n; *at && (n = (unsigned char)*at < 0x80 ? 1 : lw_text_character(at)) > 0; at += n)
        ;
    bool plain = *at == '\0';                            /* UTF-8 */
    json_t *v = !text ? json_null() : json_string(plain ? text : "?");
    char *quoted = json_dumps(v, JSON_ENCODE_ANY);
    json_decref(v);
    studio_put_key(b, key);
    if (quoted)
        lw_bytes_text(b, quoted);
    b->failed = b->failed || !quoted;
    free(quoted);
}

static void put_number(lw_bytes *b, double v)
{
    if (isfinite(v))
        lw_bytes_number(b, v, 8);
    else
        lw_bytes_text(b, "null");
}

void studio_put_real(lw_bytes *b, const char *key, double v)
{
    studio_put_key(b, key);
    put_number(b, v);
}

void studio_put_bool(lw_bytes *b, const char *key, bool v)
{
    studio_put_key(b, key);
    lw_bytes_text(b, v ? "true" : "false");
}

void studio_put_reals(lw_bytes *b, const char *key, const double *v, size_t n, size_t stride, double unit)
{
    studio_put_key(b, key);
    lw_bytes_add(b, "[", 1);
    for (size_t i = 0; i < n; i++) {
        if (i > 0)
            lw_bytes_add(b, ",", 1);
        put_number(b, v[i*stride]/unit);
    }
    lw_bytes_add(b, "]", 1);
}

void studio_put_linkage(lw_bytes *b, const char *key, const lw_assembly *a)
{
    char *text = lw_assembly_write(a, 0);
    studio_put_key(b, key);
    if (text)
        lw_bytes_text(b, text);
    b->failed = b->failed || !text;
    free(text);
}
