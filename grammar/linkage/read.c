/* grammar/linkage/read.c - pairs, lists, numbers in a range, names of links and joints. */
#include "base/file.h"
#include "base/real.h"
#include "base/vec3.h"
#include "grammar/linkage/read_internal.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/suggest.h"

lw_status lw_read_need(const lw_json_node *object, const char *key, lw_json_node *out, lw_error *e)
{
    return lw_json_member(object, key, out) ? LW_OK : lw_json_fault(object, e, "\"%s\" is missing", key);
}

lw_status lw_read_beside(const lw_json_node *object, const char *key, const char *ending, const char *what, char *path, char **text,
                         size_t *size, lw_json_node *at, lw_error *e)
{
    lw_status s = lw_read_need(object, key, at, e);
    if (s == LW_OK)
        s = lw_json_expect(at, LW_JSON_TEXT, e);
    if (s != LW_OK)
        return s;
    const char *name = lw_json_text(at), *file = at->json->file ? at->json->file : "", *end = strrchr(file, '/');
    size_t length = strlen(name), tail = strlen(ending);
    if (length <= tail || strcmp(name + length - tail, ending) != 0)
        return lw_json_fault(at, e, "\"%s\" names %s, NAME%s", key, what, ending);
    int folder = end && *name != '/' ? (int)(end - file) + 1 : 0;
    if (snprintf(path, LW_PATH_SIZE, "%.*s%s", folder, file, name) >= LW_PATH_SIZE)
        return lw_json_fault(at, e, "the path is too long");
    if ((s = lw_file_read(path, text, size, e)) != LW_OK)
        return s == LW_E_MEMORY ? s : lw_json_fault(at, e, "the file \"%.200s\" cannot be read", path);
    size_t n = strlen(path) + 1;
    char *longer = realloc(at->json->beside, at->json->beside_size + n + 1);
    if (!longer)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(longer + at->json->beside_size, path, n);
    at->json->beside = longer;
    at->json->beside_size += n;
    longer[at->json->beside_size] = 0;
    return LW_OK;
}

lw_status lw_read_list(const lw_json_node *n, size_t least, size_t most, lw_error *e)
{
    lw_status s = lw_json_expect(n, LW_JSON_ARRAY, e);
    size_t count = s == LW_OK ? lw_json_count(n) : least;
    if (count >= least && count <= most)
        return s;
    if (most == SIZE_MAX)
        return lw_json_fault(n, e, "a list of at least %zu is expected here, this one has %zu", least, count);
    if (least == most)
        return lw_json_fault(n, e, "a list of %zu is expected here, this one has %zu", least, count);
    return lw_json_fault(n, e, "a list of %zu to %zu is expected here, this one has %zu", least, most, count);
}

/* n numbers times unit. */
static lw_status read_vector(const lw_json_node *n, size_t size, double unit, double *out, lw_error *e)
{
    lw_status s = lw_read_list(n, size, size, e);
    for (size_t i = 0; s == LW_OK && i < size; i++) {
        lw_json_node part = lw_json_element(n, i);
        s = lw_json_number(&part, &out[i], e);
        out[i] *= unit;
        if (s == LW_OK && !(fabs(out[i]) <= LW_COORDINATE_MAX))
            s = lw_json_fault(&part, e, "this number is too large; at most %g m are allowed", LW_COORDINATE_MAX);
    }
    return s;
}

lw_status lw_read_pair(const lw_json_node *n, double unit, lw_vec2 *out, lw_error *e)
{
    double v[2] = { 0, 0 };
    lw_status s = read_vector(n, 2, unit, v, e);
    *out = lw_v2(v[0], v[1]);
    return s;
}

lw_status lw_read_triple(const lw_json_node *n, double unit, lw_vec3 *out, lw_error *e)
{
    double v[3] = { 0, 0, 0 };
    lw_status s = read_vector(n, 3, unit, v, e);
    *out = (lw_vec3){ v[0], v[1], v[2] };
    return s;
}

lw_status lw_read_direction(const lw_json_node *n, lw_vec3 *out, lw_error *e)
{
    lw_status s = lw_read_triple(n, 1, out, e);
    double size = lw_v3_norm(*out);
    if (s == LW_OK && !(size > 1e-200))
        return lw_json_fault(n, e, "a direction must not be [0, 0, 0]");
    *out = lw_v3_scale(*out, 1/size);
    *out = lw_v3_scale(*out, 1/lw_v3_norm(*out));
    return s;
}

lw_status lw_read_optional(const lw_json_node *object, const char *key, double unit, double *out, bool *given, lw_error *e)
{
    lw_json_node n;
    double v;
    *given = lw_json_member(object, key, &n);
    if (!*given)
        return LW_OK;
    lw_status s = lw_json_number(&n, &v, e);
    if (s == LW_OK && !(fabs(v*unit) <= LW_COORDINATE_MAX))
        s = lw_json_fault(&n, e, "this number is too large");
    if (s == LW_OK)
        *out = v*unit;
    return s;
}

/* ---- names ------------------------------------------------------------------------------------- */

static int find(const char *name, const char *const *names, int n)
{
    for (int i = 0; i < n; i++)
        if (strcmp(name, names[i]) == 0)
            return i;
    return -1;
}

lw_status lw_read_look_up(const lw_json_node *n, const char *what, const char *const *names, int n_name, int *out, lw_error *e)
{
    lw_status s = lw_json_expect(n, LW_JSON_TEXT, e);
    if (s != LW_OK)
        return s;
    const char *name = lw_json_text(n);
    *out = find(name, names, n_name);
    if (*out >= 0)
        return LW_OK;
    const char *near = lw_suggest(name, names, n_name);
    if (near)
        return lw_json_fault(n, e, "there is no %s \"%.40s\"; did you mean \"%s\"?", what, name, near);
    return lw_json_fault(n, e, "there is no %s \"%.40s\"", what, name);
}

lw_status lw_read_name_of(const lw_json_node *n, const char *what, const char *first, size_t stride, int n_name, int *out, lw_error *e)
{
    lw_status s = lw_json_expect(n, LW_JSON_TEXT, e);
    if (s != LW_OK)
        return s;
    const char *name = lw_json_text(n);
    if ((*out = lw_read_find(n->json, name, first, stride, n_name)) >= 0)
        return LW_OK;
    const char **names = malloc((size_t)n_name*sizeof *names + 1);
    if (!names)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < n_name; i++)
        names[i] = first + (size_t)i*stride;
    s = lw_read_look_up(n, what, names, n_name, out, e);
    free(names);
    return s;
}

lw_status lw_read_link(const lw_json_node *n, const lw_assembly *assembly, int *out, lw_error *e)
{
    return lw_read_name_of(n, "link", (const char *)assembly->link_name, sizeof *assembly->link_name, assembly->n_link, out, e);
}

lw_status lw_read_joint(const lw_json_node *n, const lw_assembly *assembly, int *out, lw_error *e)
{
    return lw_read_name_of(n, "joint", (const char *)assembly->joint + offsetof(lw_joint, name), sizeof *assembly->joint,
                   assembly->n_joint, out, e);
}

static lw_status read_number(const lw_json_node *object, const lw_number_key *want, lw_error *e)
{
    bool given;
    lw_json_node n;
    lw_status s = lw_read_optional(object, want->key, want->unit, want->out, &given, e);
    if (want->given)
        *want->given = given;
    if (s != LW_OK || !given || (*want->out >= want->least && *want->out <= want->most))
        return s;
    lw_json_member(object, want->key, &n);
    if (want->least == 0 && want->most == INFINITY)
        return lw_json_fault(&n, e, "this must not be negative");
    if (want->most == INFINITY)
        return lw_json_fault(&n, e, "this must be greater than 0");
    return lw_json_fault(&n, e, "this must lie between %g and %g", want->least, want->most);
}

lw_status lw_read_numbers(const lw_json_node *object, const lw_number_key *want, int n, lw_error *e)
{
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < n; i++)
        s = read_number(object, &want[i], e);
    return s;
}

/* The table of a list with all its names; NULL: there are too many lists, or memory is short. */
static lw_key_table *table_of(lw_json *json, const char *first, size_t stride, int n)
{
    lw_json_names *list = json->list;
    while (list < json->list + LW_JSON_LISTS && list->first && list->first != first)
        list++;
    if (list == json->list + LW_JSON_LISTS)
        return NULL;
    list->first = first;
    for (; list->n < n; list->n++) {
        const char *name = first + (size_t)list->n*stride;
        size_t size = strlen(name) + 1;
        if (lw_key_table_find(&list->table, first, stride, name, size) < 0 && !lw_key_table_add(&list->table, name, size, list->n))
            return NULL;
    }
    return &list->table;
}

int lw_read_find(lw_json *json, const char *name, const char *first, size_t stride, int n)
{
    enum { FEW = 32 };
    size_t size = strlen(name) + 1;
    lw_key_table *t = json && n > FEW && size <= LW_NAME_SIZE ? table_of(json, first, stride, n) : NULL;
    if (t)
        return lw_key_table_find(t, first, stride, name, size);
    for (int i = 0; i < n; i++)
        if (strcmp(name, first + (size_t)i*stride) == 0)
            return i;
    return -1;
}

int lw_read_find_or_say(lw_json *json, const char *what, const char *name, const char *first, size_t stride, int n, char *why)
{
    int at = lw_read_find(json, name, first, stride, n);
    if (at >= 0)
        return at;
    const char *near = lw_suggest_of(name, first, stride, false, n);
    snprintf(why, LW_WHY_SIZE, near ? "there is no %s \"%.40s\"; did you mean \"%s\"?" : "there is no %s \"%.40s\"", what, name, near);
    return -1;
}

lw_status lw_read_own_name(const lw_json_node *object, const char *what, size_t index, char name[LW_NAME_SIZE], lw_error *e)
{
    lw_json_node n;
    if (lw_json_member(object, "name", &n))
        return lw_json_name(&n, name, LW_NAME_SIZE, e);
    snprintf(name, LW_NAME_SIZE, "%s %zu", what, index + 1);
    return LW_OK;
}

lw_status lw_read_names_differ(const lw_json_node *root, const char *const *keys, int n_key, lw_error *e)
{
    lw_json_node all;
    size_t most = 0;
    lw_status s = LW_OK;
    for (int k = 0; s == LW_OK && k < n_key; k++)
        if (lw_json_member(root, keys[k], &all) && (s = lw_read_list(&all, 0, SIZE_MAX, e)) == LW_OK)
            most += lw_json_count(&all);
    if (s != LW_OK)
        return s;
    char (*names)[LW_NAME_SIZE] = malloc((most + 1)*sizeof *names), what[LW_NAME_SIZE];
    lw_key_table known = { 0 };
    int n = 0;
    if (!names)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int k = 0; s == LW_OK && k < n_key; k++) {
        if (!lw_json_member(root, keys[k], &all))
            continue;
        snprintf(what, sizeof what, "%.*s", (int)strlen(keys[k]) - 1, keys[k]);
        for (size_t i = 0; s == LW_OK && i < lw_json_count(&all); i++, n++) {
            lw_json_node one = lw_json_element(&all, i);
            if ((s = lw_json_expect(&one, LW_JSON_OBJECT, e)) != LW_OK || (s = lw_read_own_name(&one, what, i, names[n], e)) != LW_OK)
                break;
            size_t size = strlen(names[n]) + 1;
            if (lw_key_table_find(&known, names, sizeof *names, names[n], size) >= 0)
                s = lw_json_fault(&one, e, "this is the second %s of the name \"%s\"; names must differ", what, names[n]);
            else if (!lw_key_table_add(&known, names[n], size, n))
                s = lw_error_set(e, LW_E_MEMORY, "out of memory");
        }
    }
    lw_key_table_free(&known);
    free(names);
    return s;
}
