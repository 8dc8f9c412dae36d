/* grammar/family/master.c - read a master file: its tree, parameters, parts, views and checks. */
#include "grammar/family/master_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/growable_array.h"
#include "base/suggest.h"
#include "base/units.h"

/* ---- the tree ------------------------------------------------------------------------------------ */

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
        return lw_master_no_memory(e);
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
    lw_status st = lw_template_expect(t, LW_JSON_ARRAY, e);
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
        st = lw_template_expect(doc, LW_JSON_TEXT, e);
        s->info.doc = st == LW_OK ? lw_template_text(doc) : "";
    }
    if (st == LW_OK && (whole = lw_template_member(t, "whole"))) {
        s->info.whole = lw_json_truth(&whole->json) == 1;
        if (lw_json_truth(&whole->json) < 0)
            st = lw_json_fault(&whole->json, e, "true or false is expected here");
    }
    if (st == LW_OK && (s->choices = lw_template_member(t, "choices"))) {
        st = lw_template_expect(s->choices, LW_JSON_ARRAY, e);
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
static lw_status read_value(const lw_master_place *p, lw_symbol *s, lw_error *e)
{
    lw_template *t = s->node, *value = t->type == LW_JSON_OBJECT && !s->let ? lw_template_member(t, "value") : t;
    const char *text = lw_template_text(value);
    size_t skip = text && text[0] == '=';
    s->node = value;
    if (text && (skip || s->let)) {
        lw_status st = lw_master_parse_formula(p, value, text, skip, strlen(text + skip), &s->formula, e);
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
    lw_status s = list ? lw_template_expect(list, LW_JSON_OBJECT, e) : LW_OK;
    for (int i = 0; list && s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i];
        int at = lw_scope_add(scope, t->json.key, t, e);
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
    lw_status s = path && scope->order ? LW_OK : lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < scope->n; i++)
        s = visit(scope, in_part, i, path, 0, e);
    free(path);
    return s;
}

/* Names first, so that values may use those that follow. */
static lw_status read_scope(const lw_master_place *p, const lw_template *of, int *n_parameter, int *n_let, lw_error *e)
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
    lw_status s = lw_template_expect(t, LW_JSON_TEXT, e);
    const char *name = lw_template_text(t);
    for (*out = 0; s == LW_OK && *out < m->n_part; ++*out)
        if (strcmp(m->part[*out].name, name) == 0)
            return LW_OK;
    if (s != LW_OK)
        return s;
    const char *near = LW_SUGGEST(name, m->part, m->n_part, name);
    return lw_json_fault(&t->json, e, "there is no part \"%.60s\"%s%s%s", name, LW_DID_YOU_MEAN(near));
}

static lw_status read_with(const lw_master_place *p, lw_use *u, lw_template *with, lw_error *e)
{
    lw_scope *scope = &p->m->part[u->part].scope;
    lw_status s = lw_template_expect(with, LW_JSON_OBJECT, e);
    u->with = s == LW_OK ? calloc((size_t)with->n + 1, sizeof *u->with) : NULL;
    if (s == LW_OK && !u->with)
        s = lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < with->n; i++) {
        lw_template *t = &with->child[i];
        int at = lw_scope_find(scope, t->json.key);
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
            s = lw_master_compile(p, t, NULL, NULL, e);
        u->with[u->n_with].symbol = at;
        u->with[u->n_with++].value = t;
    }
    return s;
}

static lw_status read_use(const lw_master_place *p, lw_use *u, lw_template *t, lw_error *e)
{
    static const char *const known[] = { "part", "name", "at", "angle", "axis", "attach", "to", "with", "when",
                                         "repeat", "doc" };
    lw_template *part = lw_template_member(t, "part"), *with = lw_template_member(t, "with");
    lw_status s = lw_template_expect(t, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(&t->json, known, COUNT(known), e);
    if (s == LW_OK && !part)
        s = lw_json_fault(&t->json, e, "the \"part\" to use is missing");
    if (s == LW_OK)
        s = find_part(p->m, part, &u->part, e);
    if (s == LW_OK)
        s = lw_master_compile_head(p, t, e);
    struct { const char *key; lw_template **at; } members[] = {
        { "name", &u->name }, { "at", &u->at }, { "angle", &u->angle }, { "axis", &u->axis }, { "attach", &u->attach },
        { "to", &u->to } };
    u->node = t;
    t->kind = LW_TEMPLATE_OBJECT;
    for (int i = 0; s == LW_OK && i < COUNT(members); i++) {
        *members[i].at = lw_template_member(t, members[i].key);
        if (*members[i].at)
            s = lw_master_compile(p, *members[i].at, lw_key_find(NULL, members[i].key), NULL, e);
    }
    if (s == LW_OK && (!u->attach != !u->to))
        s = lw_json_fault(&t->json, e, "\"attach\" and \"to\" belong together: a port of the part, and the port that it is laid on");
    if (s == LW_OK && u->attach && u->at)
        s = lw_json_fault(&u->at->json, e, "\"to\" says where the part is; leave out \"at\"");
    if (s == LW_OK && u->axis && !u->angle)
        s = lw_json_fault(&u->axis->json, e, "an \"axis\" without \"angle\" turns nothing");
    if (s == LW_OK && with)
        s = read_with(p, u, with, e);
    lw_master_leave_repeat(p, t);
    return s;
}

static lw_status read_uses(const lw_master_place *p, const lw_template *list, lw_use **use, int *n, lw_error *e)
{
    lw_status s = list ? lw_template_expect(list, LW_JSON_ARRAY, e) : LW_OK;
    if (!list || s != LW_OK)
        return s;
    *use = calloc((size_t)list->n + 1, sizeof **use);
    if (!*use)
        return lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++)
        s = read_use(p, &(*use)[(*n)++], &list->child[i], e);
    return s;
}

static lw_status read_ports(const lw_master_place *p, lw_part *part, const lw_template *list, lw_error *e)
{
    static const char *const known[] = { "at", "angle", "axis", "doc" };
    lw_status s = lw_template_expect(list, LW_JSON_OBJECT, e);
    part->port = s == LW_OK ? calloc((size_t)list->n + 1, sizeof *part->port) : NULL;
    if (s == LW_OK && !part->port)
        s = lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i];
        lw_port *port = &part->port[part->n_port++];
        *port = (lw_port){ t, lw_template_member(t, "at"), lw_template_member(t, "angle"),
                            lw_template_member(t, "axis") };
        s = lw_template_expect(t, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_json_known_keys(&t->json, known, COUNT(known), e);
        if (s == LW_OK && !port->at)
            s = lw_json_fault(&t->json, e, "a port needs its place \"at\"");
        if (s == LW_OK)
            s = lw_master_compile(p, t, NULL, NULL, e);
    }
    return s;
}

static lw_status read_part(lw_master *m, lw_part *part, lw_error *e)
{
    lw_master_place p = { m, &part->scope, true };
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
            s = lw_master_compile(&p, list, lw_key_find(NULL, list->json.key), list->json.key, e);
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
    lw_status s = list ? lw_template_expect(list, LW_JSON_OBJECT, e) : LW_OK;
    if (!list || s != LW_OK)
        return s;
    int *path = malloc(((size_t)list->n + 2)*sizeof *path);
    m->part = calloc((size_t)list->n + 1, sizeof *m->part);
    if (!m->part || !path)
        s = lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++) {
        lw_part *part = &m->part[m->n_part++];
        part->node = &list->child[i];
        part->name = part->node->json.key;
        s = lw_template_expect(part->node, LW_JSON_OBJECT, e);
        if (s == LW_OK && lw_scope_add(&part->scope, "self", NULL, e) < 0)
            s = LW_E_MEMORY;
        lw_master_place p = { m, &part->scope, true };
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
    lw_status s = lw_template_expect(set, LW_JSON_OBJECT, e);
    setting->set = s == LW_OK ? calloc((size_t)set->n + 1, sizeof *setting->set) : NULL;
    if (s == LW_OK && !setting->set)
        s = lw_master_no_memory(e);
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
    lw_status s = list ? lw_template_expect(list, LW_JSON_OBJECT, e) : LW_OK;
    for (int i = 0; list && s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i], *set = lw_template_member(t, "set"), *omit = lw_template_member(t, "omit");
        lw_setting *g = &out[*n];
        for (int k = 0; k < *n; k++)
            if (strcmp(out[k].name, t->json.key) == 0)      /* a view that every master has */
                g = &out[k];
        *n += g == &out[*n];
        *g = (lw_setting){ .name = t->json.key, .omit = omit };
        s = lw_template_expect(t, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_json_known_keys(&t->json, known, view ? 3 : 2, e);
        if (s == LW_OK && set)
            s = read_set(m, g, set, e);
        if (s == LW_OK && omit)
            s = lw_template_expect(omit, LW_JSON_ARRAY, e);
        for (int k = 0; s == LW_OK && omit && k < omit->n; k++)
            s = lw_template_expect(&omit->child[k], LW_JSON_TEXT, e);
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
        return lw_master_no_memory(e);
    for (int i = 0; i < COUNT(own_views); i++)
        m->view[m->n_view++].name = own_views[i].name;
    lw_status s = read_settings(m, list, m->view, &m->n_view, true, e);
    if (s != LW_OK || !choice || (s = lw_template_expect(choice, LW_JSON_TEXT, e)) != LW_OK)
        return s;
    lw_error why = { 0 };
    m->default_view = lw_setting_find("view", m->view, m->n_view, lw_template_text(choice), &why);
    return m->default_view >= 0 ? LW_OK : lw_json_fault(&choice->json, e, "%s", why.text);
}

static lw_status read_checks(lw_master *m, const lw_template *list, lw_error *e)
{
    static const char *const known[] = { "require", "text" };
    lw_master_place p = { m, &m->scope, false };
    lw_status s = list ? lw_template_expect(list, LW_JSON_ARRAY, e) : LW_OK;
    if (!list || s != LW_OK)
        return s;
    m->check = calloc((size_t)list->n + 1, sizeof *m->check);
    if (!m->check)
        return lw_master_no_memory(e);
    for (int i = 0; s == LW_OK && i < list->n; i++) {
        lw_template *t = &list->child[i], *require = lw_template_member(t, "require"), *text = lw_template_member(t, "text");
        lw_check *c = &m->check[m->n_check++];
        s = lw_template_expect(t, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_json_known_keys(&t->json, known, COUNT(known), e);
        if (s == LW_OK && !lw_template_text(require))
            s = lw_json_fault(&t->json, e, "a check needs \"require\", a condition such as \"a + b < c\"");
        if (s == LW_OK && text)
            s = lw_template_expect(text, LW_JSON_TEXT, e);
        if (s != LW_OK)
            break;
        size_t skip = lw_template_text(require)[0] == '=';
        c->node = require;
        c->text = text ? lw_template_text(text) : "";
        s = lw_master_parse_formula(&p, require, lw_template_text(require), skip, strlen(lw_template_text(require) + skip), &c->formula, e);
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
    lw_status s = lw_template_expect(units, LW_JSON_OBJECT, e);
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
    lw_status s = lw_template_expect(root, LW_JSON_OBJECT, e);
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
        s = lw_template_expect(family, LW_JSON_TEXT, e);
    m->model = lw_template_member(root, "model");
    if (s == LW_OK && !m->model)
        s = lw_json_fault(&root->json, e, "\"model\" is missing, the body of the model file");
    return s == LW_OK ? lw_template_expect(m->model, LW_JSON_OBJECT, e) : s;
}

static lw_status read_model(lw_master *m, lw_error *e)
{
    lw_master_place p = { m, &m->scope, false };
    lw_status s = read_uses(&p, lw_template_member(m->model, "use"), &m->use, &m->n_use, e);
    for (int i = 0; s == LW_OK && i < m->model->n; i++) {
        lw_template *t = &m->model->child[i];
        if (strcmp(t->json.key, "linkwright") == 0)
            s = lw_json_fault(&t->json, e, "the version stands beside \"model\", not in it");
        else if (strcmp(t->json.key, "use") != 0)
            s = lw_master_compile(&p, t, lw_key_find(NULL, t->json.key), t->json.key, e);
    }
    return s;
}

static lw_status read_all(lw_master *m, const char *text, size_t size, const char *file, lw_error *e)
{
    m->text = malloc(size + 1);
    m->file = strdup(file);
    if (!m->text || !m->file)
        return lw_master_no_memory(e);
    memcpy(m->text, text, size);
    m->text[size] = '\0';
    lw_status s = lw_json_open(m->text, size, m->file, &m->json, e);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&m->json);
    size_t count = count_nodes(&root);
    m->block = count && count < 1 << 30 ? calloc(count, sizeof *m->block) : NULL;
    if (!m->block)
        return lw_master_no_memory(e);
    m->root = m->block;
    m->n_template = 1;
    lw_master_place p = { m, &m->scope, false };
    int first = lw_scope_add(&m->scope, "view", NULL, e);
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
        return lw_master_no_memory(e);
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
        return lw_master_no_memory(e);
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
