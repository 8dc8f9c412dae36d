/* grammar/family/master_compile.c - the names of scopes; formulas and texts of a master file are compiled. */
#include "grammar/family/master_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/bytes.h"
#include "base/growable_array.h"
#include "base/number.h"
#include "base/suggest.h"
#include "base/units.h"

lw_template *lw_template_member(const lw_template *object, const char *key)
{
    for (int i = 0; object && object->type == LW_JSON_OBJECT && i < object->n; i++)
        if (strcmp(object->child[i].json.key, key) == 0)
            return &object->child[i];
    return NULL;
}

lw_status lw_template_fault(const lw_template *t, size_t at, const lw_error *inner, lw_error *e)
{
    if (inner->status != LW_E_NOTATION)
        return lw_error_set(e, inner->status, "%s", inner->text);
    return lw_json_fault_inside(&t->json, at + (inner->column > 0 ? (size_t)inner->column - 1 : 0), e, "%s", inner->text);
}

const char *lw_template_text(const lw_template *t) { return t ? lw_json_text(&t->json) : NULL; }

/* ---- scopes -------------------------------------------------------------------------------------- */

int lw_scope_find(const lw_scope *s, const char *name)
{
    for (int i = s->n - 1; i >= 0; i--)
        if (s->symbol[i].visible && strcmp(s->symbol[i].name, name) == 0)
            return i;
    return -1;
}

static int look_up(void *context, const char *word, char *why)
{
    const lw_master_place *p = context;
    int at = lw_scope_find(p->scope, word), root = p->in_part ? lw_scope_find(&p->m->scope, word) : -1;
    if (at >= 0)
        return 2*at + p->in_part;
    if (root >= 0)
        return 2*root;
    int n = p->scope->n + (p->in_part ? p->m->scope.n : 0), used = 0;
    const char **names = malloc(((size_t)n + 1)*sizeof *names);
    for (int i = 0; names && i < p->scope->n; i++)
        if (p->scope->symbol[i].visible)
            names[used++] = p->scope->symbol[i].name;
    for (int i = 0; names && p->in_part && i < p->m->scope.n; i++)
        if (p->m->scope.symbol[i].visible)
            names[used++] = p->m->scope.symbol[i].name;
    const char *near = names ? lw_suggest(word, names, used) : NULL;
    if (near)
        snprintf(why, 256, "there is no parameter %.60s here; did you mean %s?", word, near);
    free(names);
    return -1;
}

static bool is_name(const char *name)
{
    static const char *const taken[] = { "as", "and", "or", "not", "true", "false", "pi", "if", "self", "view" };
    for (int i = 0; i < COUNT(taken); i++)
        if (strcmp(name, taken[i]) == 0)
            return false;
    size_t n = strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    return n > 0 && n < LW_MASTER_NAME && !name[n] && !(name[0] >= '0' && name[0] <= '9');
}

int lw_scope_add(lw_scope *s, const char *name, lw_template *node, lw_error *e)
{
    if (node && !is_name(name)) {
        lw_json_fault(&node->json, e, "\"%.60s\" cannot be a name; write letters, digits and _, a letter first, at "
                                      "most %d, and none of the words of formulas", name, LW_MASTER_NAME - 1);
        return -1;
    }
    int before = lw_scope_find(s, name);
    if (node && before >= 0) {
        lw_json_fault(&node->json, e, "the name \"%s\" is given twice", name);
        return -1;
    }
    lw_symbol *more = lw_array_grow(s->symbol, s->n, &s->capacity, sizeof *more);
    if (!more) {
        lw_master_no_memory(e);
        return -1;
    }
    s->symbol = more;
    more[s->n] = (lw_symbol){ .visible = true, .node = node, .value = lw_amount_plain(0) };
    snprintf(more[s->n].name, sizeof more->name, "%s", name);
    return s->n++;
}

/* ---- formulas and texts -------------------------------------------------------------------------- */

lw_status lw_master_parse_formula(const lw_master_place *p, const lw_template *t, const char *text, size_t at, size_t size, lw_formula **out, lw_error *e)
{
    lw_error inner = { 0 };
    lw_status s = lw_formula_parse(text + at, size, look_up, (void *)p, out, &inner);
    return s == LW_OK ? s : lw_template_fault(t, at, &inner, e);
}

/* The units in which numbers of this key may be given. */
static void set_units(const lw_master *m, lw_template *t)
{
    for (int i = 0; t->key && i < LW_KEY_UNITS && t->key->units[i]; i++) {
        lw_amount *u = &t->unit[t->n_unit++];
        lw_unit_parse(t->key->units[i], strlen(t->key->units[i]), u, NULL);
        const int8_t *d = u->dimension.of;
        for (int k = 0; k < abs(d[LW_DIMENSION_METRE]) && t->key->posture; k++) {
            u->over *= d[LW_DIMENSION_METRE] > 0 ? m->length.over : m->length.under;
            u->under *= d[LW_DIMENSION_METRE] > 0 ? m->length.under : m->length.over;
        }
        if (t->key->posture && d[LW_DIMENSION_METRE] == 0 && d[LW_DIMENSION_RADIAN] == 1) {
            u->over = m->angle.over;
            u->under = m->angle.under;
        }
    }
}

static lw_status add_piece(lw_template *t, const char *text, size_t size, size_t at, lw_formula *formula, lw_error *e)
{
    lw_piece *more = realloc(t->piece, (size_t)(t->n_piece + 1)*sizeof *more);
    char *copy = malloc(size + 1);
    if (more)
        t->piece = more;
    if (!more || !copy) {
        free(copy);
        lw_formula_free(formula);
        return lw_master_no_memory(e);
    }
    memcpy(copy, text, size);
    copy[size] = '\0';
    t->piece[t->n_piece++] = (lw_piece){ copy, size, at, formula };
    return LW_OK;
}

/* "text {formula} text"; {{ and }} stand for braces. */
static lw_status compile_pieces(const lw_master_place *p, lw_template *t, const char *text, lw_error *e)
{
    size_t start = 0, at = 0;
    lw_status s = LW_OK;
    t->kind = LW_TEMPLATE_PIECES;
    while (s == LW_OK && text[at]) {
        char c = text[at];
        if (c != '{' && c != '}') {
            at++;
        } else if (text[at + 1] == c) {
            s = add_piece(t, text + start, at + 1 - start, start, NULL, e);
            start = at += 2;
        } else if (c == '}') {
            return lw_json_fault_inside(&t->json, at, e, "this '}' closes nothing; write }} for a brace");
        } else {
            size_t n = strcspn(text + at + 1, "}");
            lw_formula *f = NULL;
            if (!text[at + 1 + n])
                return lw_json_fault_inside(&t->json, at, e, "this '{' has no '}'; write {{ for a brace");
            s = add_piece(t, text + start, at - start, start, NULL, e);
            if (s == LW_OK)
                s = lw_master_parse_formula(p, t, text, at + 1, n, &f, e);
            if (s == LW_OK)
                s = add_piece(t, "", 0, at + 1, f, e);
            start = at += n + 2;
        }
    }
    return s == LW_OK ? add_piece(t, text + start, at - start, start, NULL, e) : s;
}

void lw_master_quote(lw_bytes *b, const char *text)
{
    char code[8];
    lw_bytes_add(b, "\"", 1);
    for (const char *c = text; *c; c++)
        lw_bytes_add(b, code, (size_t)lw_json_character(*c, code));
    lw_bytes_add(b, "\"", 1);
}

static lw_status compile_scalar(const lw_master_place *p, lw_template *t, lw_error *e)
{
    const char *text = lw_template_text(t);
    lw_bytes b = { 0 };
    char digits[LW_NUMBER_SIZE];
    t->kind = LW_TEMPLATE_VERBATIM;
    if (text && text[0] == '=') {
        t->kind = LW_TEMPLATE_FORMULA;
        return lw_master_parse_formula(p, t, text, 1, strlen(text + 1), &t->formula, e);
    }
    if (text && strpbrk(text, "{}"))
        return compile_pieces(p, t, text, e);
    if (t->type == LW_JSON_NUMBER) {
        lw_json_number(&t->json, &t->number, NULL);
        lw_number_print(t->number, digits);
        lw_bytes_text(&b, digits);
    } else if (text)
        lw_master_quote(&b, text);
    else
        lw_bytes_text(&b, lw_json_truth(&t->json) == 1 ? "true" : lw_json_truth(&t->json) == 0 ? "false" : "null");
    lw_status s = lw_bytes_end(&b, e);
    t->verbatim = b.data;
    return s;
}


/* "repeat": {"i": 3}, {"i": {"from": 0, "to": "=n"}}, {"side": ["left", "right"]}; several are nested. */
static lw_status compile_repeat(const lw_master_place *p, lw_template *object, lw_error *e)
{
    static const char *const known[] = { "from", "to" };
    lw_template *r = object->repeat;
    lw_status s = lw_template_expect(r, LW_JSON_OBJECT, e);
    if (s == LW_OK && r->n == 0)
        return lw_json_fault(&r->json, e, "a repeat needs a name and its values, as in {\"i\": 3}");
    object->index = s == LW_OK ? calloc((size_t)r->n, sizeof *object->index) : NULL;
    if (s == LW_OK && !object->index)
        s = lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < r->n; i++) {
        lw_template *values = &r->child[i];
        if (values->type == LW_JSON_OBJECT) {
            s = lw_json_known_keys(&values->json, known, COUNT(known), e);
            if (s == LW_OK && (!lw_template_member(values, "from") || !lw_template_member(values, "to")))
                s = lw_json_fault(&values->json, e, "both \"from\" and \"to\" are needed");
        } else if (values->type == LW_JSON_OTHER)
            s = lw_json_fault(&values->json, e, "a number, a list of values or {\"from\", \"to\"} is expected here");
        if (s == LW_OK)
            s = lw_master_compile(p, values, NULL, NULL, e);
        if (s != LW_OK)
            break;
        object->index[i].values = values;
        object->index[i].symbol = lw_scope_add(p->scope, values->json.key, values, e);
        if (object->index[i].symbol < 0)
            return e ? e->status : LW_E_NOTATION;
        p->scope->symbol[object->index[i].symbol].node = NULL;
    }
    return s;
}

void lw_master_leave_repeat(const lw_master_place *p, const lw_template *object)
{
    for (int i = 0; object->repeat && object->index && i < object->repeat->n; i++)
        p->scope->symbol[object->index[i].symbol].visible = false;
}

static lw_status compile_condition(const lw_master_place *p, lw_template *t, lw_error *e)
{
    const char *text = lw_template_text(t);
    lw_status s = LW_OK;
    if (text && text[0] != '=') {
        t->kind = LW_TEMPLATE_FORMULA;
        s = lw_master_parse_formula(p, t, text, 0, strlen(text), &t->formula, e);
    } else
        s = compile_scalar(p, t, e);
    if (s == LW_OK && t->kind == LW_TEMPLATE_VERBATIM && lw_json_truth(&t->json) < 0)
        s = lw_json_fault(&t->json, e, "a condition is expected here, such as \"n > 2\"");
    return s;
}

lw_status lw_master_compile_head(const lw_master_place *p, lw_template *t, lw_error *e)
{
    t->when = lw_template_member(t, "when");
    t->repeat = lw_template_member(t, "repeat");
    lw_status s = t->repeat ? compile_repeat(p, t, e) : LW_OK;
    return s == LW_OK && t->when ? compile_condition(p, t->when, e) : s;
}

lw_status lw_master_compile(const lw_master_place *p, lw_template *t, const lw_key *key, const char *parent, lw_error *e)
{
    lw_status s = LW_OK;
    t->key = key;
    if (t->type != LW_JSON_OBJECT && t->type != LW_JSON_ARRAY) {
        s = compile_scalar(p, t, e);
        if (t->kind != LW_TEMPLATE_VERBATIM || t->type == LW_JSON_NUMBER)
            set_units(p->m, t);
        return s;
    }
    if (t->type == LW_JSON_ARRAY) {
        t->kind = LW_TEMPLATE_ARRAY;
        for (int i = 0; s == LW_OK && i < t->n; i++) {
            lw_template *element = &t->child[i];
            if (element->type == LW_JSON_OBJECT)
                s = lw_master_compile_head(p, element, e);
            if (s == LW_OK)
                s = lw_master_compile(p, element, key, parent, e);
            if (element->type == LW_JSON_OBJECT)
                lw_master_leave_repeat(p, element);
        }
        return s;
    }
    t->kind = LW_TEMPLATE_OBJECT;
    if (t->n == 1 && strcmp(t->child->json.key, "port") == 0) {
        t->kind = LW_TEMPLATE_PORT;
        return lw_master_compile(p, t->child, NULL, NULL, e);
    }
    for (int i = 0; s == LW_OK && i < t->n; i++) {
        lw_template *member = &t->child[i];
        if (member != t->when && member != t->repeat)
            s = lw_master_compile(p, member, lw_key_find(t->json.key ? t->json.key : parent, member->json.key), member->json.key, e);
    }
    return s;
}

lw_status lw_master_formula(const lw_master *m, const char *text, lw_formula **f, lw_error *e)
{
    lw_master_place p = { m, (lw_scope *)&m->scope, false };
    return lw_formula_parse(text, strlen(text), look_up, &p, f, e);
}
