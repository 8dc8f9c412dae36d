/* Access to the values of a JSON text, which jansson holds, and errors with their place. */
#include "grammar/text/json_internal.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "base/suggest.h"
#include "grammar/text/json_locate_internal.h"

static const char byte_order_mark[] = "\xef\xbb\xbf";

static bool is_blank(const char *text, size_t size)
{
    for (size_t i = 0; i < size; i++)
        if (text[i] != ' ' && text[i] != '\t' && text[i] != '\r' && text[i] != '\n')
            return false;
    return true;
}

lw_status lw_json_open(const char *text, size_t size, const char *file, lw_json *json, lw_error *e)
{
    size_t skip = size >= 3 && memcmp(text, byte_order_mark, 3) == 0 ? 3 : 0;
    json_error_t error;
    json_t *root;
    *json = (lw_json){ .text = text, .size = size, .file = file };
    if (is_blank(text + skip, size - skip))
        return lw_error_at(e, LW_E_NOTATION, file, 1, 1, "nothing is in this file; a JSON object { ... } is expected");
    lw_status s = lw_json_load(text + skip, size - skip, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &root, &error);
    json->root = root;
    if (s == LW_E_MEMORY)
        return lw_error_at(e, s, file, 0, 0, "out of memory");
    if (s == LW_OK)
        return s;
    long line, column;
    lw_text_place(text, size, skip + (size_t)error.position, &line, &column);
    return lw_error_at(e, LW_E_NOTATION, file, line, column, "this is not JSON: %s", error.text);
}

void lw_json_close(lw_json *json)
{
    json_decref(json->root);
    json->root = NULL;
    free(json->beside);
    for (int i = 0; i < LW_JSON_LISTS; i++)
        lw_key_table_free(&json->list[i].table);
}

lw_json_node lw_json_root(lw_json *json)
{
    return (lw_json_node){ .json = json, .value = json->root };
}

lw_json_kind lw_json_kind_of(const lw_json_node *n)
{
    switch (json_typeof((json_t *)n->value)) {
    case JSON_OBJECT:  return LW_JSON_OBJECT;
    case JSON_ARRAY:   return LW_JSON_ARRAY;
    case JSON_STRING:  return LW_JSON_TEXT;
    case JSON_INTEGER:
    case JSON_REAL:    return LW_JSON_NUMBER;
    default:           return LW_JSON_OTHER;
    }
}

int lw_json_truth(const lw_json_node *n)
{
    return json_is_true((json_t *)n->value) ? 1 : json_is_false((json_t *)n->value) ? 0 : -1;
}

size_t lw_json_count(const lw_json_node *n)
{
    return json_is_object((json_t *)n->value) ? json_object_size(n->value) : json_array_size(n->value);
}

lw_json_node lw_json_element(const lw_json_node *array, size_t index)
{
    return (lw_json_node){ .json = array->json, .parent = array, .index = index,
                           .value = json_array_get(array->value, index) };
}

/* jansson iterates over an object in the order of the text, so the count is the position in the text. */
bool lw_json_member(const lw_json_node *object, const char *key, lw_json_node *out)
{
    const char *name;
    json_t *value;
    size_t index = 0;
    json_object_foreach((json_t *)object->value, name, value) {
        if (strcmp(name, key) == 0) {
            *out = (lw_json_node){ object->json, object, key, index, value };
            return true;
        }
        index++;
    }
    return false;
}

void lw_json_children(const lw_json_node *parent, lw_json_node *out)
{
    const char *name;
    json_t *value;
    size_t index = 0;
    if (json_is_array((json_t *)parent->value)) {
        for (; index < json_array_size(parent->value); index++)
            out[index] = lw_json_element(parent, index);
        return;
    }
    json_object_foreach((json_t *)parent->value, name, value) {
        out[index] = (lw_json_node){ parent->json, parent, name, index, value };
        index++;
    }
}

/* ---- faults ------------------------------------------------------------------------------------ */

/* "joints[2].links[1]" from the root down to n. */
static int print_path(const lw_json_node *n, char *buf, size_t size, lw_json_path *path)
{
    if (!n->parent)
        return 0;
    int used = print_path(n->parent, buf, size, path);
    if (path->n < (int)(sizeof path->index/sizeof *path->index))
        path->index[path->n++] = n->index;
    if (used >= (int)size - 1)
        return used;
    return used + (n->key ? snprintf(buf + used, size - (size_t)used, "%s%s", used ? "." : "", n->key)
                          : snprintf(buf + used, size - (size_t)used, "[%zu]", n->index));
}

/* Distance from the opening quote of a text to its byte `at`.  An escape stands for one byte.  \uXXXX stands for
 * the one to three bytes of its character in UTF-8; a pair of them for four bytes, counted as two each. */
static size_t inside_text(const char *text, size_t size, size_t quote, size_t at)
{
    size_t i = quote + 1;
    for (size_t seen = 0; seen < at && i < size && text[i] != '"';) {
        bool escape = text[i] == '\\' && i + 1 < size, wide = escape && text[i + 1] == 'u';
        unsigned code = 0;
        if (wide && i + 6 <= size)
            sscanf(text + i + 2, "%4x", &code);
        seen += !wide || code < 0x80 ? 1 : code < 0x800 || (code >= 0xd800 && code < 0xe000) ? 2 : 3;
        i += wide ? 6 : escape ? 2 : 1;
    }
    return i < size ? i : size;
}

typedef enum { AT_VALUE, AT_KEY, AT_INSIDE } fault_place;

static lw_status fault(const lw_json_node *n, fault_place place, size_t at, lw_error *e, const char *format, va_list arg)
{
    char where[160] = "", text[640];
    lw_json_path path = { .n = 0 };
    long line, column;
    const lw_json *j = n->json;
    print_path(n, where, sizeof where, &path);
    vsnprintf(text, sizeof text, format, arg);
    size_t offset = lw_json_locate(j->text, j->size, &path, place == AT_KEY);
    if (place == AT_INSIDE)
        offset = inside_text(j->text, j->size, offset, at);
    lw_text_place(j->text, j->size, offset, &line, &column);
    return lw_error_at(e, LW_E_NOTATION, j->file, line, column, "%s%s%s", where, *where ? ": " : "", text);
}

lw_status lw_json_fault(const lw_json_node *n, lw_error *e, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    lw_status s = fault(n, AT_VALUE, 0, e, format, arg);
    va_end(arg);
    return s;
}

lw_status lw_json_fault_inside(const lw_json_node *n, size_t at, lw_error *e, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    lw_status s = fault(n, AT_INSIDE, at, e, format, arg);
    va_end(arg);
    return s;
}

static lw_status key_fault(const lw_json_node *n, lw_error *e, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static lw_status key_fault(const lw_json_node *n, lw_error *e, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    lw_status s = fault(n, AT_KEY, 0, e, format, arg);
    va_end(arg);
    return s;
}

/* ---- values ------------------------------------------------------------------------------------ */

static const char *kind_text(lw_json_kind kind)
{
    switch (kind) {
    case LW_JSON_OBJECT: return "an object { ... }";
    case LW_JSON_ARRAY:  return "a list [ ... ]";
    case LW_JSON_TEXT:   return "a text \"...\"";
    case LW_JSON_NUMBER: return "a number";
    case LW_JSON_OTHER:  break;
    }
    return "true, false or null";
}

lw_status lw_json_expect(const lw_json_node *n, lw_json_kind kind, lw_error *e)
{
    lw_json_kind found = lw_json_kind_of(n);
    if (found == kind)
        return LW_OK;
    return lw_json_fault(n, e, "%s is expected here, this is %s", kind_text(kind), kind_text(found));
}

lw_status lw_json_number(const lw_json_node *n, double *out, lw_error *e)
{
    lw_status s = lw_json_expect(n, LW_JSON_NUMBER, e);
    if (s == LW_OK)
        *out = json_number_value(n->value);
    return s;
}

const char *lw_json_text(const lw_json_node *n)
{
    return json_string_value(n->value);
}

lw_status lw_json_name(const lw_json_node *n, char *out, size_t size, lw_error *e)
{
    lw_status s = lw_json_expect(n, LW_JSON_TEXT, e);
    if (s != LW_OK)
        return s;
    size_t length = json_string_length(n->value);
    if (length == 0)
        return lw_json_fault(n, e, "an empty name; write one of 1 to %zu bytes", size - 1);
    if (length >= size)
        return lw_json_fault(n, e, "this name has %zu bytes; at most %zu are allowed", length, size - 1);
    if (lw_text_has_control(json_string_value(n->value)))
        return lw_json_fault(n, e, "this name holds a control character; a name is one line of text");
    memcpy(out, json_string_value(n->value), length + 1);
    return LW_OK;
}

static bool is_known(const char *key, const char *const *known, int n_known)
{
    for (int i = 0; i < n_known; i++)
        if (strcmp(key, known[i]) == 0)
            return true;
    return strncmp(key, "x-", 2) == 0;
}

/* The keys as one text, "a, b, c"; those that do not fit are "...". */
static void list_keys(const char *const *known, int n_known, char *out, size_t size)
{
    size_t at = 0;
    out[0] = 0;
    for (int i = 0; i < n_known; i++) {
        bool fits = at + strlen(known[i]) + sizeof ", , ..." <= size;
        at += (size_t)snprintf(out + at, size - at, "%s%s", i > 0 ? ", " : "", fits ? known[i] : "...");
        if (!fits)
            return;
    }
}

lw_status lw_json_known_keys(const lw_json_node *object, const char *const *known, int n_known, lw_error *e)
{
    const char *key;
    json_t *value;
    size_t index = 0;
    json_object_foreach((json_t *)object->value, key, value) {
        if (!is_known(key, known, n_known)) {
            lw_json_node n = { object->json, object, key, index, value };
            const char *near = lw_suggest(key, known, n_known);
            char list[400];
            list_keys(known, n_known, list, sizeof list);
            return key_fault(&n, e, "this key is not known%s%s%s; known here: %s; keys of your own begin with \"x-\"",
                             LW_DID_YOU_MEAN(near), list);
        }
        index++;
    }
    return LW_OK;
}

int lw_json_character(char c, char out[8])
{
    return c == '"' || c == '\\'        ? snprintf(out, 8, "\\%c", c)
         : (unsigned char)c < 0x20      ? snprintf(out, 8, "\\u%04x", (unsigned)c) : (out[0] = c, 1);
}
