/* grammar/text/json_internal.h - JSON texts written by people.  Every error is reported with its line and column: errors
 * of syntax, and errors of meaning found later.
 *
 * A node is a value together with the path to it from the root.  It lives on the caller's stack and
 * points to its parent, which must outlive it.  Here only json.c and json_read.c include jansson. */
#ifndef LW_GRAMMAR_TEXT_JSON_INTERNAL_H
#define LW_GRAMMAR_TEXT_JSON_INTERNAL_H

#include "base/key_table.h"
#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

/* A list of names, found by hashing (lw_read_find). */
typedef struct lw_json_names { const char *first; int n; lw_key_table table; } lw_json_names;
enum { LW_JSON_LISTS = 8 };

typedef struct lw_json {
    const char *text;          /* the caller's, kept for line and column */
    size_t      size;
    const char *file;
    void       *root;          /* jansson's                              */
    lw_json_names list[LW_JSON_LISTS];     /* the lists that names of the text were looked for in */
    char       *beside;        /* paths of the files read for names in the text, as lw_spatial's `files` */
    size_t      beside_size;
} lw_json;

typedef struct lw_json_node {
    lw_json                   *json;
    const struct lw_json_node *parent;   /* NULL: the root                                 */
    const char                *key;      /* its name in an object, NULL in an array        */
    size_t                     index;    /* its place in an array or object, from 0        */
    void                      *value;    /* jansson's                                      */
} lw_json_node;

typedef enum lw_json_kind { LW_JSON_OBJECT, LW_JSON_ARRAY, LW_JSON_TEXT, LW_JSON_NUMBER, LW_JSON_OTHER } lw_json_kind;

/* Parse; the text must outlive the result.  Duplicate keys, texts with NUL and numbers outside the range of a
 * double are refused; a UTF-8 byte order mark is skipped.  LW_E_NOTATION with line and column, LW_E_MEMORY. */
lw_status lw_json_open(const char *text, size_t size, const char *file, lw_json *json, lw_error *e);
void      lw_json_close(lw_json *json);

/* Read a text into jansson's values, as its json_loadb does with these flags: JSON_REJECT_DUPLICATES, JSON_DISABLE_EOF_CHECK and
 * JSON_DECODE_INT_AS_REAL.  `position` of *fault is the byte behind the value.  LW_E_NOTATION: *fault says why, and where the first byte of the
 * fault is, *root is NULL.  LW_E_MEMORY. */
struct json_t;
struct json_error_t;
lw_status lw_json_load(const char *text, size_t size, size_t flags, struct json_t **root, struct json_error_t *fault);

lw_json_node lw_json_root(lw_json *json);
lw_json_kind lw_json_kind_of(const lw_json_node *n);

/* Elements of an array or object; 0 for others. */
size_t lw_json_count(const lw_json_node *n);
/* The element of an array; index < lw_json_count. */
lw_json_node lw_json_element(const lw_json_node *array, size_t index);
/* The member of an object; false when there is none. */
bool lw_json_member(const lw_json_node *object, const char *key, lw_json_node *out);

/* All elements or members, in the order of the text; out (lw_json_count). */
void lw_json_children(const lw_json_node *parent, lw_json_node *out);

/* Fill e with the place of the node and the text, preceded by its path, e.g. "joints[2].at: ".
 * Returns LW_E_NOTATION. */
lw_status lw_json_fault(const lw_json_node *n, lw_error *e, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same at byte `at` (from 0) of the contents of a text node. */
lw_status lw_json_fault_inside(const lw_json_node *n, size_t at, lw_error *e, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* An error unless the node is of this kind. */
lw_status lw_json_expect(const lw_json_node *n, lw_json_kind kind, lw_error *e);
lw_status lw_json_number(const lw_json_node *n, double *out, lw_error *e);
/* Copy a text of 1 to size-1 bytes into out.  lw_json_text returns the node's own text without a copy. */
lw_status lw_json_name(const lw_json_node *n, char *out, size_t size, lw_error *e);
const char *lw_json_text(const lw_json_node *n);     /* NULL when it is no text */

/* 1 true, 0 false, -1: neither. */
int lw_json_truth(const lw_json_node *n);

/* An error at the first unknown key of an object, with a suggestion.  Keys that begin with "x-" are free for
 * users and are accepted. */
lw_status lw_json_known_keys(const lw_json_node *object, const char *const *known, int n_known, lw_error *e);

/* The character of a text as a JSON string has it: itself or an escape.  Returns the number of bytes. */
int lw_json_character(char c, char out[8]);

#endif
