/* grammar/family/master.c - read a master file: its tree, the names of its scopes, its formulas. */
#include "grammar/family/master_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/bytes.h"
#include "base/growable_array.h"
#include "base/number.h"
#include "base/suggest.h"
#include "base/units.h"

#define COUNT(a) ((int)(sizeof (a)/sizeof *(a)))

static lw_status no_memory(lw_error *e) { return lw_error_set(e, LW_E_MEMORY, "out of memory for a master file"); }

/* ---- the tree ------------------------------------------------------------------------------------ */

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

static size_t count_nodes(const lw_json_node *n)
{
    size_t sum = 1, count = lw_json_kind_of(n) <= LW_JSON_ARRAY ? lw_json_count(n) : 0;
    lw_json_node *child = count ? malloc(count*sizeof *child) : NULL;
    if (count && !child)
        return 0;
    if (count)
        lw_json_children(n, child);
    for (size_t i = 0; i < count && sum; i++) {
        size_t below = count_nodes(&child[i]);
        sum = below ? sum + below : 0;
    }
    free(child);
    return sum;
}

/* Fill *t and, behind m->n_template, its children. */
static lw_status fill_tree(lw_master *m, lw_template *t, lw_json_node json, lw_error *e)
{
    *t = (lw_template){ .json = json, .type = lw_json_kind_of(&json) };
    size_t count = t->type <= LW_JSON_ARRAY ? lw_json_count(&t->json) : 0;
    lw_json_node *child = count ? malloc(count*sizeof *child) : NULL;
    if (count && !child)
        return no_memory(e);
    t->n = (int)count;
    t->child = m->block + m->n_template;
    m->n_template += t->n;
    if (count)
        lw_json_children(&t->json, child);
    lw_status s = LW_OK;
    for (size_t i = 0; i < count && s == LW_OK; i++)
        s = fill_tree(m, &t->child[i], child[i], e);
    free(child);
    return s;
}

const char *lw_template_text(const lw_template *t) { return t ? lw_json_text(&t->json) : NULL; }

static lw_status expect(const lw_template *t, lw_json_kind kind, lw_error *e) { return lw_json_expect(&t->json, kind,
    e); }

/* ---- scopes -------------------------------------------------------------------------------------- */

typedef struct place { const lw_master *m; lw_scope *scope; bool in_part; } place;

static int find_symbol(const lw_scope *s, const char *name)
{
    for (int i = s->n - 1; i >= 0; i--)
        if (s->symbol[i].visible && strcmp(s->symbol[i].name, name) == 0)
            return i;
    return -1;
}

static int look_up(void *context, const char *word, char *why)
{
    const place *p = context;
    int at = find_symbol(p->scope, word), root = p->in_part ? find_symbol(&p->m->scope, word) : -1;
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

/* The number of the new symbol; -1: e is filled. */
static int add_symbol(lw_scope *s, const char *name, lw_template *node, lw_error *e)
{
    if (node && !is_name(name)) {
        lw_json_fault(&node->json, e, "\"%.60s\" cannot be a name; write letters, digits and _, a letter first, at "
                                      "most %d, and none of the words of formulas", name, LW_MASTER_NAME - 1);
        return -1;
    }
    int before = find_symbol(s, name);
    if (node && before >= 0) {
        lw_json_fault(&node->json, e, "the name \"%s\" is given twice", name);
        return -1;
    }
    lw_symbol *more = lw_array_grow(s->symbol, s->n, &s->capacity, sizeof *more);
    if (!more) {
        no_memory(e);
        return -1;
    }
    s->symbol = more;
    more[s->n] = (lw_symbol){ .visible = true, .node = node, .value = lw_amount_plain(0) };
    snprintf(more[s->n].name, sizeof more->name, "%s", name);
    return s->n++;
}

/* ---- formulas and texts -------------------------------------------------------------------------- */

static lw_status parse(const place *p, const lw_template *t, const char *text, size_t at, size_t size, lw_formula **out, lw_error *e)
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
        return no_memory(e);
    }
    memcpy(copy, text, size);
    copy[size] = '\0';
    t->piece[t->n_piece++] = (lw_piece){ copy, size, at, formula };
    return LW_OK;
}

/* "text {formula} text"; {{ and }} stand for braces. */
static lw_status compile_pieces(const place *p, lw_template *t, const char *text, lw_error *e)
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
                s = parse(p, t, text, at + 1, n, &f, e);
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

static lw_status compile_scalar(const place *p, lw_template *t, lw_error *e)
{
    const char *text = lw_template_text(t);
    lw_bytes b = { 0 };
    char digits[LW_NUMBER_SIZE];
    t->kind = LW_TEMPLATE_VERBATIM;
    if (text && text[0] == '=') {
        t->kind = LW_TEMPLATE_FORMULA;
        return parse(p, t, text, 1, strlen(text + 1), &t->formula, e);
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

static lw_status compile(const place *p, lw_template *t, const lw_key *key, const char *parent, lw_error *e);

/* "repeat": {"i": 3}, {"i": {"from": 0, "to": "=n"}}, {"side": ["left", "right"]}; several are nested. */
static lw_status compile_repeat(const place *p, lw_template *object, lw_error *e)
{
    static const char *const known[] = { "from", "to" };
    lw_template *r = object->repeat;
    lw_status s = expect(r, LW_JSON_OBJECT, e);
    if (s == LW_OK && r->n == 0)
        return lw_json_fault(&r->json, e, "a repeat needs a name and its values, as in {\"i\": 3}");
    object->index = s == LW_OK ? calloc((size_t)r->n, sizeof *object->index) : NULL;
    if (s == LW_OK && !object->index)
        s = no_memory(e);
    for (int i = 0; s == LW_OK && i < r->n; i++) {
        lw_template *values = &r->child[i];
        if (values->type == LW_JSON_OBJECT) {
            s = lw_json_known_keys(&values->json, known, COUNT(known), e);
            if (s == LW_OK && (!lw_template_member(values, "from") || !lw_template_member(values, "to")))
                s = lw_json_fault(&values->json, e, "both \"from\" and \"to\" are needed");
        } else if (values->type == LW_JSON_OTHER)
            s = lw_json_fault(&values->json, e, "a number, a list of values or {\"from\", \"to\"} is expected here");
        if (s == LW_OK)
            s = compile(p, values, NULL, NULL, e);
        if (s != LW_OK)
            break;
        object->index[i].values = values;
        object->index[i].symbol = add_symbol(p->scope, values->json.key, values, e);
        if (object->index[i].symbol < 0)
            return e ? e->status : LW_E_NOTATION;
        p->scope->symbol[object->index[i].symbol].node = NULL;
    }
    return s;
}

/* After the element: the indexes of its repeat are unknown outside. */
static void leave_repeat(const place *p, const lw_template *object)
{
    for (int i = 0; object->repeat && object->index && i < object->repeat->n; i++)
        p->scope->symbol[object->index[i].symbol].visible = false;
}

static lw_status compile_condition(const place *p, lw_template *t, lw_error *e)
{
    const char *text = lw_template_text(t);
    lw_status s = LW_OK;
    if (text && text[0] != '=') {
        t->kind = LW_TEMPLATE_FORMULA;
        s = parse(p, t, text, 0, strlen(text), &t->formula, e);
    } else
        s = compile_scalar(p, t, e);
    if (s == LW_OK && t->kind == LW_TEMPLATE_VERBATIM && lw_json_truth(&t->json) < 0)
        s = lw_json_fault(&t->json, e, "a condition is expected here, such as \"n > 2\"");
    return s;
}

/* "when" and "repeat" of an object in a list. */
static lw_status compile_head(const place *p, lw_template *t, lw_error *e)
{
    t->when = lw_template_member(t, "when");
    t->repeat = lw_template_member(t, "repeat");
    lw_status s = t->repeat ? compile_repeat(p, t, e) : LW_OK;
    return s == LW_OK && t->when ? compile_condition(p, t->when, e) : s;
}

static lw_status compile(const place *p, lw_template *t, const lw_key *key, const char *parent, lw_error *e)
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
                s = compile_head(p, element, e);
            if (s == LW_OK)
                s = compile(p, element, key, parent, e);
            if (element->type == LW_JSON_OBJECT)
                leave_repeat(p, element);
        }
        return s;
    }
    t->kind = LW_TEMPLATE_OBJECT;
    if (t->n == 1 && strcmp(t->child->json.key, "port") == 0) {
        t->kind = LW_TEMPLATE_PORT;
        return compile(p, t->child, NULL, NULL, e);
    }
    for (int i = 0; s == LW_OK && i < t->n; i++) {
        lw_template *member = &t->child[i];
        if (member != t->when && member != t->repeat)
            s = compile(p, member, lw_key_find(t->json.key ? t->json.key : parent, member->json.key), member->json.key, e);
    }
    return s;
}

/* ---- parameters ---------------------------------------------------------------------------------- */

static lw_status read_unit(const lw_template *t, lw_amount *unit, lw_error *e)
{
    lw_error inner = { 0 };
    const char *text = lw_template_text(t);
    if (!text)
        return lw_json_fault(&t->json, e, "a unit is expected here, such as \"mm\"");
    lw_status s = lw_unit_parse(text, strlen(text), unit, &inner);
    return s == LW_OK ? s : lw_template_fault(t, 0, &inner, e);
}

static lw_status constant_of(const lw_template *t, const lw_symbol *s, lw_amount *out, lw_error *e);

static lw_status read_range(lw_symbol *s, const lw_template *t, lw_error *e)
{
    lw_status st = expect(t, LW_JSON_ARRAY, e);
    if (st == LW_OK && t->n != 2)
        return lw_json_fault(&t->json, e, "a range has two numbers, [least, most]");
    for (int i = 0; st == LW_OK && i < 2; i++)
        st = lw_json_number(&t->child[i].json, i ? &s->info.most : &s->info.least, e);
    if (st == LW_OK && !(s->info.least < s->info.most))
        return lw_json_fault(&t->json, e, "the first number of a range must be less than the second");
    s->info.has_range = st == LW_OK;
    return st;
}

/* Everything of a parameter but its formula. */
static lw_status read_parameter(lw_symbol *s, lw_template *t, lw_error *e)
{
    static const char *const known[] = { "value", "unit", "range", "doc", "choices", "whole" };
    lw_template *unit, *range, *doc, *whole;
    s->info = (lw_parameter){ .name = s->name, .unit = "", .doc = "" };
    if (t->type != LW_JSON_OBJECT)
        return LW_OK;
    lw_status st = lw_json_known_keys(&t->json, known, COUNT(known), e);
    if (st == LW_OK && !lw_template_member(t, "value"))
        st = lw_json_fault(&t->json, e, "parameter \"%s\" has no \"value\"", s->name);
    if (st == LW_OK && (unit = lw_template_member(t, "unit"))) {
        st = read_unit(unit, &s->unit, e);
        s->has_unit = st == LW_OK;
        s->info.unit = st == LW_OK ? lw_template_text(unit) : "";
    }
    if (st == LW_OK && (range = lw_template_member(t, "range")))
        st = read_range(s, range, e);
    if (st == LW_OK && (doc = lw_template_member(t, "doc"))) {
        st = expect(doc, LW_JSON_TEXT, e);
        s->info.doc = st == LW_OK ? lw_template_text(doc) : "";
    }
    if (st == LW_OK && (whole = lw_template_member(t, "whole"))) {
        s->info.whole = lw_json_truth(&whole->json) == 1;
        if (lw_json_truth(&whole->json) < 0)
            st = lw_json_fault(&whole->json, e, "true or false is expected here");
    }
    if (st == LW_OK && (s->choices = lw_template_member(t, "choices"))) {
        st = expect(s->choices, LW_JSON_ARRAY, e);
        for (int i = 0; st == LW_OK && i < s->choices->n; i++)
            if (s->choices->child[i].type != LW_JSON_TEXT && s->choices->child[i].type != LW_JSON_NUMBER)
                st = lw_json_fault(&s->choices->child[i].json, e, "a text or a number is expected here");
    }
    return st;
}

/* A number in the unit of the symbol, a truth, a text; "=..." with units. */
static lw_status constant_of(const lw_template *t, const lw_symbol *s, lw_amount *out, lw_error *e)
{
    const char *text = lw_template_text(t);
    if (t->type == LW_JSON_NUMBER) {
        *out = s->has_unit ? s->unit : lw_amount_plain(0);
        return lw_json_number(&t->json, &out->number, e);
    }
    if (text && text[0] == '=') {
        lw_formula *f = NULL;
        lw_error inner = { 0 };
        lw_status st = lw_formula_parse(text + 1, strlen(text + 1), NULL, NULL, &f, &inner);
        if (st == LW_OK)
            st = lw_formula_value(f, (const lw_amount *const[2]){ NULL, NULL }, out, &inner);
        lw_formula_free(f);
        return st == LW_OK ? st : lw_template_fault(t, 1, &inner, e);
    }
    *out = text ? lw_amount_of_text(text) : (lw_amount){ .kind = LW_AMOUNT_TRUTH, .over = 1, .under = 1,
                                                     .number = lw_json_truth(&t->json) == 1 };
    if (!text && lw_json_truth(&t->json) < 0)
        return lw_json_fault(&t->json, e, "a number, a text, true or false is expected here");
    return LW_OK;
}

/* The value of a parameter or let.  A let is a formula in any case. */
static lw_status read_value(const place *p, lw_symbol *s, lw_error *e)
{
    lw_template *t = s->node, *value = t->type == LW_JSON_OBJECT && !s->let ? lw_template_member(t, "value") : t;
    const char *text = lw_template_text(value);
    size_t skip = text && text[0] == '=';
    s->node = value;
    if (text && (skip || s->let)) {
        lw_status st = parse(p, value, text, skip, strlen(text + skip), &s->formula, e);
        s->info.kind = LW_AMOUNT_NUMBER;
        return st;
    }
    lw_status st = constant_of(value, s, &s->value, e);
    s->info.kind = s->value.kind;
    if (st == LW_OK && s->has_unit && s->value.kind != LW_AMOUNT_NUMBER)
        st = lw_json_fault(&value->json, e, "a parameter with a unit needs a number");
    return st;
}

static lw_status add_names(lw_scope *scope, const lw_template *list, bool let, int *n, lw_error *e)
{
    lw_status s = list ? expect(list, LW_JSON_OBJECT, e) : LW_OK;
    for (int i = 0; list && s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i];
        int at = add_symbol(scope, t->json.key, t, e);
        if (at < 0)
            return e ? e->status : LW_E_NOTATION;
        scope->symbol[at].let = let;
        if (!let)
            s = read_parameter(&scope->symbol[at], t, e);
        if (n)
            ++*n;
    }
    return s;
}

/* Give each value its place after those it needs: 1 is being visited, 2 is done. */
static lw_status visit(lw_scope *scope, int in_part, int at, int *path, int depth, lw_error *e)
{
    lw_symbol *s = &scope->symbol[at];
    path[depth] = at;
    if (s->mark == 2 || !s->formula)
        return LW_OK;
    if (s->mark == 1) {
        char circle[400] = "";
        int first = 0;
        while (first < depth && path[first] != at)
            first++;
        for (int i = first; i <= depth && strlen(circle) < 300; i++)
            snprintf(circle + strlen(circle), sizeof circle - strlen(circle), "%s%s", i > first ? " -> " : "", scope->symbol[path[i]].name);
        return lw_json_fault(&s->node->json, e, "a value needs itself: %s", circle);
    }
    s->mark = 1;
    const int *word;
    int n = lw_formula_words(s->formula, &word);
    for (int i = 0; i < n; i++)
        if ((word[i] & 1) == in_part) {
            lw_status st = visit(scope, in_part, word[i] >> 1, path, depth + 1, e);
            if (st != LW_OK)
                return st;
        }
    s->mark = 2;
    scope->order[scope->n_order++] = at;
    return LW_OK;
}

static lw_status put_in_order(lw_scope *scope, int in_part, lw_error *e)
{
    int *path = malloc(((size_t)scope->n + 2)*sizeof *path);
    scope->order = malloc(((size_t)scope->n + 1)*sizeof *scope->order);
    lw_status s = path && scope->order ? LW_OK : no_memory(e);
    for (int i = 0; s == LW_OK && i < scope->n; i++)
        s = visit(scope, in_part, i, path, 0, e);
    free(path);
    return s;
}

/* Names first, so that values may use those that follow. */
static lw_status read_scope(const place *p, const lw_template *of, int *n_parameter, int *n_let, lw_error *e)
{
    lw_scope *scope = p->scope;
    int first = scope->n;
    lw_status s = add_names(scope, lw_template_member(of, "parameters"), false, n_parameter, e);
    if (s == LW_OK)
        s = add_names(scope, lw_template_member(of, "let"), true, n_let, e);
    for (int i = first; s == LW_OK && i < scope->n; i++)
        s = read_value(p, &scope->symbol[i], e);
    for (int i = 0; i < scope->n; i++)
        scope->symbol[i].info.name = scope->symbol[i].name;        /* the array has moved */
    return s == LW_OK ? put_in_order(scope, p->in_part, e) : s;
}

/* ---- parts and their use --------------------------------------------------------------------------- */

static lw_status find_part(const lw_master *m, const lw_template *t, int *out, lw_error *e)
{
    lw_status s = expect(t, LW_JSON_TEXT, e);
    const char *name = lw_template_text(t);
    for (*out = 0; s == LW_OK && *out < m->n_part; ++*out)
        if (strcmp(m->part[*out].name, name) == 0)
            return LW_OK;
    if (s != LW_OK)
        return s;
    const char *near = LW_SUGGEST(name, m->part, m->n_part, name);
    return lw_json_fault(&t->json, e, "there is no part \"%.60s\"%s%s%s", name, LW_DID_YOU_MEAN(near));
}

static lw_status read_with(const place *p, lw_use *u, lw_template *with, lw_error *e)
{
    lw_scope *scope = &p->m->part[u->part].scope;
    lw_status s = expect(with, LW_JSON_OBJECT, e);
    u->with = s == LW_OK ? calloc((size_t)with->n + 1, sizeof *u->with) : NULL;
    if (s == LW_OK && !u->with)
        s = no_memory(e);
    for (int i = 0; s == LW_OK && i < with->n; i++) {
        lw_template *t = &with->child[i];
        int at = find_symbol(scope, t->json.key);
        if (at < 0 || scope->symbol[at].let || at == LW_SYMBOL_SELF) {
            const char **names = malloc(((size_t)scope->n + 1)*sizeof *names);
            int n = 0;
            for (int k = 1; names && k < scope->n; k++)
                if (!scope->symbol[k].let && scope->symbol[k].visible)
                    names[n++] = scope->symbol[k].name;
            const char *near = names ? lw_suggest(t->json.key, names, n) : NULL;
            s = lw_json_fault(&t->json, e, "part \"%s\" has no parameter of this name%s%s%s", p->m->part[u->part].name, LW_DID_YOU_MEAN(near));
            free(names);
        } else
            s = compile(p, t, NULL, NULL, e);
        u->with[u->n_with].symbol = at;
        u->with[u->n_with++].value = t;
    }
    return s;
}

static lw_status read_use(const place *p, lw_use *u, lw_template *t, lw_error *e)
{
    static const char *const known[] = { "part", "name", "at", "angle", "axis", "attach", "to", "with", "when",
                                         "repeat", "doc" };
    lw_template *part = lw_template_member(t, "part"), *with = lw_template_member(t, "with");
    lw_status s = expect(t, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(&t->json, known, COUNT(known), e);
    if (s == LW_OK && !part)
        s = lw_json_fault(&t->json, e, "the \"part\" to use is missing");
    if (s == LW_OK)
        s = find_part(p->m, part, &u->part, e);
    if (s == LW_OK)
        s = compile_head(p, t, e);
    struct { const char *key; lw_template **at; } members[] = {
        { "name", &u->name }, { "at", &u->at }, { "angle", &u->angle }, { "axis", &u->axis }, { "attach", &u->attach },
        { "to", &u->to } };
    u->node = t;
    t->kind = LW_TEMPLATE_OBJECT;
    for (int i = 0; s == LW_OK && i < COUNT(members); i++) {
        *members[i].at = lw_template_member(t, members[i].key);
        if (*members[i].at)
            s = compile(p, *members[i].at, lw_key_find(NULL, members[i].key), NULL, e);
    }
    if (s == LW_OK && (!u->attach != !u->to))
        s = lw_json_fault(&t->json, e, "\"attach\" and \"to\" belong together: a port of the part, and the port that it is laid on");
    if (s == LW_OK && u->attach && u->at)
        s = lw_json_fault(&u->at->json, e, "\"to\" says where the part is; leave out \"at\"");
    if (s == LW_OK && u->axis && !u->angle)
        s = lw_json_fault(&u->axis->json, e, "an \"axis\" without \"angle\" turns nothing");
    if (s == LW_OK && with)
        s = read_with(p, u, with, e);
    leave_repeat(p, t);
    return s;
}

static lw_status read_uses(const place *p, const lw_template *list, lw_use **use, int *n, lw_error *e)
{
    lw_status s = list ? expect(list, LW_JSON_ARRAY, e) : LW_OK;
    if (!list || s != LW_OK)
        return s;
    *use = calloc((size_t)list->n + 1, sizeof **use);
    if (!*use)
        return no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++)
        s = read_use(p, &(*use)[(*n)++], &list->child[i], e);
    return s;
}

static lw_status read_ports(const place *p, lw_part *part, const lw_template *list, lw_error *e)
{
    static const char *const known[] = { "at", "angle", "axis", "doc" };
    lw_status s = expect(list, LW_JSON_OBJECT, e);
    part->port = s == LW_OK ? calloc((size_t)list->n + 1, sizeof *part->port) : NULL;
    if (s == LW_OK && !part->port)
        s = no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i];
        lw_port *port = &part->port[part->n_port++];
        *port = (lw_port){ t, lw_template_member(t, "at"), lw_template_member(t, "angle"),
                            lw_template_member(t, "axis") };
        s = expect(t, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_json_known_keys(&t->json, known, COUNT(known), e);
        if (s == LW_OK && !port->at)
            s = lw_json_fault(&t->json, e, "a port needs its place \"at\"");
        if (s == LW_OK)
            s = compile(p, t, NULL, NULL, e);
    }
    return s;
}

static lw_status read_part(lw_master *m, lw_part *part, lw_error *e)
{
    place p = { m, &part->scope, true };
    lw_template *t = part->node, *ports = lw_template_member(t, "ports");
    lw_status s = ports ? read_ports(&p, part, ports, e) : LW_OK;
    if (s == LW_OK)
        s = read_uses(&p, lw_template_member(t, "use"), &part->use, &part->n_use, e);
    static const char *const others[] = { "parameters", "let", "ports", "use", "doc" };
    for (int i = 0; s == LW_OK && i < t->n; i++) {
        lw_template *list = &t->child[i];
        bool other = strncmp(list->json.key, "x-", 2) == 0;
        for (int k = 0; k < COUNT(others); k++)
            other = other || strcmp(list->json.key, others[k]) == 0;
        if (other)
            continue;
        if (list->type != LW_JSON_ARRAY)
            s = lw_json_fault(&list->json, e, "a part holds parameters, let, ports, use and lists such as links, joints, forces");
        else
            s = compile(&p, list, lw_key_find(NULL, list->json.key), list->json.key, e);
    }
    return s;
}

/* A part that uses itself would never end. */
static lw_status visit_part(lw_master *m, int at, int *path, int depth, lw_error *e)
{
    lw_part *part = &m->part[at];
    path[depth] = at;
    if (part->mark == 2)
        return LW_OK;
    if (part->mark == 1) {
        char circle[400] = "";
        int first = 0;
        while (first < depth && path[first] != at)
            first++;
        for (int i = first; i <= depth && strlen(circle) < 300; i++)
            snprintf(circle + strlen(circle), sizeof circle - strlen(circle), "%s%.60s", i > first ? " -> " : "", m->part[path[i]].name);
        return lw_json_fault(&part->node->json, e, "a part uses itself: %s", circle);
    }
    part->mark = 1;
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < part->n_use; i++)
        s = visit_part(m, part->use[i].part, path, depth + 1, e);
    part->mark = 2;
    return s;
}

static lw_status read_parts(lw_master *m, const lw_template *list, lw_error *e)
{
    lw_status s = list ? expect(list, LW_JSON_OBJECT, e) : LW_OK;
    if (!list || s != LW_OK)
        return s;
    int *path = malloc(((size_t)list->n + 2)*sizeof *path);
    m->part = calloc((size_t)list->n + 1, sizeof *m->part);
    if (!m->part || !path)
        s = no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++) {
        lw_part *part = &m->part[m->n_part++];
        part->node = &list->child[i];
        part->name = part->node->json.key;
        s = expect(part->node, LW_JSON_OBJECT, e);
        if (s == LW_OK && add_symbol(&part->scope, "self", NULL, e) < 0)
            s = LW_E_MEMORY;
        place p = { m, &part->scope, true };
        if (s == LW_OK)
            s = read_scope(&p, part->node, NULL, NULL, e);
    }
    for (int i = 0; s == LW_OK && i < m->n_part; i++)
        s = read_part(m, &m->part[i], e);
    for (int i = 0; s == LW_OK && i < m->n_part; i++)
        s = visit_part(m, i, path, 0, e);
    free(path);
    return s;
}

/* ---- views, configurations, checks ------------------------------------------------------------------ */

/* Views that every master has, unless it says otherwise. */
static const struct { const char *name, *omit[20]; } own_views[] = {
    { "kinematic", { "mass", "centre", "inertia", "gravity", "springs", "dampers", "forces", "motors", "friction",
                     "stop",
                     "clearance", "elastic", "states", "controllers", "cylinders", "contacts", "ropes" } },
    { "dynamic", { "clearance", "elastic" } },
    { "elastic", { "clearance" } },
    { "clearance", { "elastic" } },
};

static bool omitted_by(const lw_setting *view, const char *key)
{
    for (int i = 0; view->omit && i < view->omit->n; i++)
        if (strcmp(lw_template_text(&view->omit->child[i]), key) == 0)
            return true;
    for (int i = 0; !view->omit && i < COUNT(own_views); i++)
        for (int k = 0; strcmp(own_views[i].name, view->name) == 0 && k < 20 && own_views[i].omit[k]; k++)
            if (strcmp(own_views[i].omit[k], key) == 0)
                return true;
    return false;
}

bool lw_master_omits(const lw_master *m, int view, const char *key)
{
    return view >= 0 && omitted_by(&m->view[view], key);
}

static lw_status read_set(const lw_master *m, lw_setting *setting, lw_template *set, lw_error *e)
{
    lw_status s = expect(set, LW_JSON_OBJECT, e);
    setting->set = s == LW_OK ? calloc((size_t)set->n + 1, sizeof *setting->set) : NULL;
    if (s == LW_OK && !setting->set)
        s = no_memory(e);
    for (int i = 0; s == LW_OK && i < set->n; i++) {
        lw_template *t = &set->child[i];
        int at = lw_master_find_parameter(m, t->json.key);
        if (at < 0) {
            const char *near = LW_SUGGEST(t->json.key, m->scope.symbol + 1, m->n_parameter, name);
            return lw_json_fault(&t->json, e, "there is no parameter of this name%s%s%s", LW_DID_YOU_MEAN(near));
        }
        s = constant_of(t, &m->scope.symbol[1 + at], &setting->set[setting->n].value, e);
        setting->set[setting->n++].symbol = 1 + at;
    }
    return s;
}

static lw_status read_settings(const lw_master *m, const lw_template *list, lw_setting *out, int *n, bool view, lw_error *e)
{
    static const char *const known[] = { "doc", "set", "omit" };
    lw_status s = list ? expect(list, LW_JSON_OBJECT, e) : LW_OK;
    for (int i = 0; list && s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i], *set = lw_template_member(t, "set"), *omit = lw_template_member(t, "omit");
        lw_setting *g = &out[*n];
        for (int k = 0; k < *n; k++)
            if (strcmp(out[k].name, t->json.key) == 0)      /* a view that every master has */
                g = &out[k];
        *n += g == &out[*n];
        *g = (lw_setting){ .name = t->json.key, .omit = omit };
        s = expect(t, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_json_known_keys(&t->json, known, view ? 3 : 2, e);
        if (s == LW_OK && set)
            s = read_set(m, g, set, e);
        if (s == LW_OK && omit)
            s = expect(omit, LW_JSON_ARRAY, e);
        for (int k = 0; s == LW_OK && omit && k < omit->n; k++)
            s = expect(&omit->child[k], LW_JSON_TEXT, e);
    }
    return s;
}

int lw_setting_find(const char *what, const lw_setting *list, int n, const char *name, lw_error *e)
{
    for (int i = 0; i < n; i++)
        if (strcmp(list[i].name, name) == 0)
            return i;
    const char *near = LW_SUGGEST(name, list, n, name);
    lw_error_set(e, LW_E_ARG, "there is no %s \"%.60s\"%s%s%s", what, name, LW_DID_YOU_MEAN(near));
    return -1;
}

static lw_status read_views(lw_master *m, lw_error *e)
{
    lw_template *list = lw_template_member(m->root, "views"), *choice = lw_template_member(m->root, "view");
    m->view = calloc(COUNT(own_views) + (size_t)(list ? list->n : 0) + 1, sizeof *m->view);
    m->default_view = -1;
    if (!m->view)
        return no_memory(e);
    for (int i = 0; i < COUNT(own_views); i++)
        m->view[m->n_view++].name = own_views[i].name;
    lw_status s = read_settings(m, list, m->view, &m->n_view, true, e);
    if (s != LW_OK || !choice || (s = expect(choice, LW_JSON_TEXT, e)) != LW_OK)
        return s;
    lw_error why = { 0 };
    m->default_view = lw_setting_find("view", m->view, m->n_view, lw_template_text(choice), &why);
    return m->default_view >= 0 ? LW_OK : lw_json_fault(&choice->json, e, "%s", why.text);
}

static lw_status read_checks(lw_master *m, const lw_template *list, lw_error *e)
{
    static const char *const known[] = { "require", "text" };
    place p = { m, &m->scope, false };
    lw_status s = list ? expect(list, LW_JSON_ARRAY, e) : LW_OK;
    if (!list || s != LW_OK)
        return s;
    m->check = calloc((size_t)list->n + 1, sizeof *m->check);
    if (!m->check)
        return no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i], *require = lw_template_member(t, "require"), *text = lw_template_member(t, "text");
        lw_check *c = &m->check[m->n_check++];
        s = expect(t, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_json_known_keys(&t->json, known, COUNT(known), e);
        if (s == LW_OK && !lw_template_text(require))
            s = lw_json_fault(&t->json, e, "a check needs \"require\", a condition such as \"a + b < c\"");
        if (s == LW_OK && text)
            s = expect(text, LW_JSON_TEXT, e);
        if (s != LW_OK)
            break;
        size_t skip = lw_template_text(require)[0] == '=';
        c->node = require;
        c->text = text ? lw_template_text(text) : "";
        s = parse(&p, require, lw_template_text(require), skip, strlen(lw_template_text(require) + skip), &c->formula, e);
    }
    return s;
}

/* ---- the file -------------------------------------------------------------------------------------- */

static lw_status read_units(lw_master *m, lw_error *e)
{
    lw_template *units = lw_template_member(m->model, "units");
    lw_unit_parse("m", 1, &m->length, NULL);
    lw_unit_parse("rad", 3, &m->angle, NULL);
    if (!units)
        return LW_OK;
    static const char *const known[] = { "length", "angle" };
    lw_units check = lw_units_si();
    lw_status s = expect(units, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(&units->json, known, COUNT(known), e);
    for (int i = 0; s == LW_OK && i < 2; i++) {
        lw_template *t = lw_template_member(units, known[i]);
        if (!t)
            continue;
        const char *name = lw_template_text(t);
        if (!name || !(i ? lw_units_set_angle(&check, name) : lw_units_set_length(&check, name)))
            return lw_json_fault(&t->json, e, "a unit of %s is expected here: %s", known[i],
                                 i ? "rad, deg or turn" : "m, mm, cm, km, um, in or ft");
        s = read_unit(t, i ? &m->angle : &m->length, e);
    }
    return s;
}

static lw_status read_root(lw_master *m, lw_error *e)
{
    static const char *const known[] = { "linkwright", "family", "doc", "parameters", "let", "parts", "model", "view",
                                         "views",
                                         "configurations", "checks", "$schema" };
    double version = 0;
    lw_template *root = m->root, *v = lw_template_member(root, "linkwright"), *family = lw_template_member(root, "family");
    lw_status s = expect(root, LW_JSON_OBJECT, e);
    if (s == LW_OK && lw_template_member(root, "joints"))
        return lw_json_fault(&root->json, e, "this is no master file but a model; a master holds it under \"model\"");
    if (s == LW_OK)
        s = lw_json_known_keys(&root->json, known, COUNT(known), e);
    if (s == LW_OK && !v)
        s = lw_json_fault(&root->json, e, "\"linkwright\": 1 is missing, the version of this notation");
    if (s == LW_OK)
        s = lw_json_number(&v->json, &version, e);
    if (s == LW_OK && version != 1)
        s = lw_json_fault(&v->json, e, "version %g of the notation is unknown; this program reads version 1", version);
    if (s == LW_OK && family)
        s = expect(family, LW_JSON_TEXT, e);
    m->model = lw_template_member(root, "model");
    if (s == LW_OK && !m->model)
        s = lw_json_fault(&root->json, e, "\"model\" is missing, the body of the model file");
    return s == LW_OK ? expect(m->model, LW_JSON_OBJECT, e) : s;
}

static lw_status read_model(lw_master *m, lw_error *e)
{
    place p = { m, &m->scope, false };
    lw_status s = read_uses(&p, lw_template_member(m->model, "use"), &m->use, &m->n_use, e);
    for (int i = 0; s == LW_OK && i < m->model->n; i++) {
        lw_template *t = &m->model->child[i];
        if (strcmp(t->json.key, "linkwright") == 0)
            s = lw_json_fault(&t->json, e, "the version stands beside \"model\", not in it");
        else if (strcmp(t->json.key, "use") != 0)
            s = compile(&p, t, lw_key_find(NULL, t->json.key), t->json.key, e);
    }
    return s;
}

static lw_status read_all(lw_master *m, const char *text, size_t size, const char *file, lw_error *e)
{
    m->text = malloc(size + 1);
    m->file = strdup(file);
    if (!m->text || !m->file)
        return no_memory(e);
    memcpy(m->text, text, size);
    m->text[size] = '\0';
    lw_status s = lw_json_open(m->text, size, m->file, &m->json, e);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&m->json);
    size_t count = count_nodes(&root);
    m->block = count && count < 1 << 30 ? calloc(count, sizeof *m->block) : NULL;
    if (!m->block)
        return no_memory(e);
    m->root = m->block;
    m->n_template = 1;
    place p = { m, &m->scope, false };
    int first = add_symbol(&m->scope, "view", NULL, e);
    if (first < 0)
        return LW_E_MEMORY;
    m->scope.symbol[LW_SYMBOL_VIEW].value = lw_amount_of_text("");
    if ((s = fill_tree(m, m->root, root, e)) != LW_OK || (s = read_root(m, e)) != LW_OK || (s = read_units(m,
        e)) != LW_OK
        || (s = read_scope(&p, m->root, &m->n_parameter, &m->n_let, e)) != LW_OK
        || (s = read_parts(m, lw_template_member(m->root, "parts"), e)) != LW_OK || (s = read_model(m, e)) != LW_OK
        || (s = read_views(m, e)) != LW_OK)
        return s;
    lw_template *configurations = lw_template_member(m->root, "configurations");
    m->configuration = calloc((size_t)(configurations ? configurations->n : 0) + 1, sizeof *m->configuration);
    if (!m->configuration)
        return no_memory(e);
    s = read_settings(m, configurations, m->configuration, &m->n_configuration, false, e);
    if (s == LW_OK)
        s = read_checks(m, lw_template_member(m->root, "checks"), e);
    for (int i = 0; i < m->scope.n; i++)
        m->scope.symbol[i].info.name = m->scope.symbol[i].name;
    return s;
}

lw_status lw_master_read(const char *text, size_t size, const char *file, lw_master **out, lw_error *e)
{
    lw_error own = { 0 };
    lw_master *m = calloc(1, sizeof *m);
    *out = NULL;
    if (!m)
        return no_memory(e);
    lw_status s = read_all(m, text, size, file, e ? e : &own);
    if (s == LW_OK)
        *out = m;
    else
        lw_master_free(m);
    return s;
}

static void free_scope(lw_scope *s)
{
    for (int i = 0; i < s->n; i++)
        lw_formula_free(s->symbol[i].formula);
    free(s->symbol);
    free(s->order);
}

static void free_uses(lw_use *use, int n)
{
    for (int i = 0; i < n; i++)
        free(use[i].with);
    free(use);
}

void lw_master_free(lw_master *m)
{
    if (!m)
        return;
    for (int i = 0; i < m->n_template; i++) {
        lw_template *t = &m->block[i];
        free(t->verbatim);
        free(t->index);
        lw_formula_free(t->formula);
        for (int k = 0; k < t->n_piece; k++) {
            free(t->piece[k].text);
            lw_formula_free(t->piece[k].formula);
        }
        free(t->piece);
    }
    for (int i = 0; i < m->n_part; i++) {
        free_scope(&m->part[i].scope);
        free_uses(m->part[i].use, m->part[i].n_use);
        free(m->part[i].port);
    }
    for (int i = 0; i < m->n_view; i++)
        free(m->view[i].set);
    for (int i = 0; i < m->n_configuration; i++)
        free(m->configuration[i].set);
    for (int i = 0; i < m->n_check; i++)
        lw_formula_free(m->check[i].formula);
    free_scope(&m->scope);
    free_uses(m->use, m->n_use);
    free(m->part);
    free(m->view);
    free(m->configuration);
    free(m->check);
    free(m->block);
    lw_json_close(&m->json);
    free(m->text);
    free(m->file);
    free(m);
}

lw_status lw_master_formula(const lw_master *m, const char *text, lw_formula **f, lw_error *e)
{
    place p = { m, (lw_scope *)&m->scope, false };
    return lw_formula_parse(text, strlen(text), look_up, &p, f, e);
}

/* ---- what is in it ----------------------------------------------------------------------------------- */

const char *lw_master_title(const lw_master *m)
{
    const char *text = lw_template_text(lw_template_member(m->root, "family"));
    return text ? text : "";
}

const lw_parameter *lw_master_parameter(const lw_master *m, int i)
{
    return i >= 0 && i < m->n_parameter ? &m->scope.symbol[1 + i].info : NULL;
}

const char *lw_master_let(const lw_master *m, int i)
{
    return i >= 0 && i < m->n_let ? m->scope.symbol[1 + m->n_parameter + i].name : NULL;
}

const char *lw_master_configuration(const lw_master *m, int i)
{
    return i >= 0 && i < m->n_configuration ? m->configuration[i].name : NULL;
}

const char *lw_master_view(const lw_master *m, int i) { return i >= 0 && i < m->n_view ? m->view[i].name : NULL; }

const char *lw_master_check_text(const lw_master *m, int i)
{
    return i < 0 || i >= m->n_check ? NULL : m->check[i].text[0] ? m->check[i].text : lw_template_text(m->check[i].node);
}

int lw_master_find_parameter(const lw_master *m, const char *name)
{
    for (int i = 0; i < m->n_parameter; i++)
        if (strcmp(m->scope.symbol[1 + i].name, name) == 0)
            return i;
    return -1;
}
