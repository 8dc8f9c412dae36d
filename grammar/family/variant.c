/* grammar/family/variant.c - a variant of a master: its settings, and the values that follow from them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/bytes.h"
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "grammar/family/master_internal.h"

lw_status lw_variant_create(const lw_master *m, lw_variant **out)
{
    lw_variant *v = *out = calloc(1, sizeof *v);
    if (!v)
        return LW_E_MEMORY;
    size_t n = (size_t)m->scope.n;
    *v = (lw_variant){ .m = m, .view = m->default_view, .configuration = -1, .given = calloc(n, sizeof *v->given),
                       .own = calloc(n, sizeof *v->own), .value = calloc(n, sizeof *v->value),
                       .text = calloc(n, sizeof *v->text) };
    if (v->given && v->own && v->value && v->text)
        return LW_OK;
    lw_variant_free(v);
    *out = NULL;
    return LW_E_MEMORY;
}

void lw_variant_free(lw_variant *v)
{
    if (!v)
        return;
    for (int i = 0; v->text && i < v->m->scope.n; i++)
        free(v->text[i]);
    free(v->given);
    free(v->own);
    free(v->value);
    free(v->text);
    free(v);
}

/* Choose one of n settings by its name, or `other` where name is NULL. */
static lw_status choose(lw_variant *v, int *chosen, const char *what, const lw_setting *list, int n, const char *name, int other, lw_error *e)
{
    lw_error why = { 0 };
    int at = name ? lw_setting_find(what, list, n, name, &why) : other;
    if (name && at < 0)
        return lw_error_at(e, LW_E_ARG, v->m->file, 0, 0, "%s", why.text);
    *chosen = at;
    v->fresh = false;
    return LW_OK;
}

lw_status lw_variant_configure(lw_variant *v, const char *name, lw_error *e)
{
    return choose(v, &v->configuration, "configuration", v->m->configuration, v->m->n_configuration, name, -1, e);
}

lw_status lw_variant_look(lw_variant *v, const char *name, lw_error *e)
{
    return choose(v, &v->view, "view", v->m->view, v->m->n_view, name, v->m->default_view, e);
}

lw_status lw_variant_set_number(lw_variant *v, int parameter, double value)
{
    if (parameter < 0 || parameter >= v->m->n_parameter || !isfinite(value))
        return LW_E_ARG;
    const lw_symbol *s = &v->m->scope.symbol[1 + parameter];
    if (s->info.kind != LW_AMOUNT_NUMBER)
        return LW_E_ARG;
    v->own[1 + parameter] = s->has_unit ? s->unit : lw_amount_plain(0);
    v->own[1 + parameter].number = value;
    v->given[1 + parameter] = true;
    v->fresh = false;
    return LW_OK;
}

lw_status lw_variant_set(lw_variant *v, const char *name, const char *value, lw_error *e)
{
    int at = lw_master_find_parameter(v->m, name);
    if (at < 0) {
        const char *near = LW_SUGGEST(name, v->m->scope.symbol + 1, v->m->n_parameter, name);
        return lw_error_at(e, LW_E_ARG, v->m->file, 0, 0, "there is no parameter \"%.60s\"%s%s%s", name, LW_DID_YOU_MEAN(near));
    }
    const lw_symbol *s = &v->m->scope.symbol[1 + at];
    char *copy = strdup(value);
    lw_formula *f = NULL;
    lw_amount a = lw_amount_of_text(copy);
    lw_error inner = { 0 };
    if (!copy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a variant");
    lw_status st = LW_OK;
    if (s->info.kind != LW_AMOUNT_TEXT) {
        st = lw_formula_parse(value, strlen(value), NULL, NULL, &f, &inner);
        if (st == LW_OK)
            st = lw_formula_value(f, (const lw_amount *const[2]){ NULL, NULL }, &a, &inner);
        lw_formula_free(f);
        if (st == LW_OK && a.kind == LW_AMOUNT_NUMBER && s->has_unit
            && lw_dimension_fits(a.dimension, lw_amount_plain(0).dimension)) {
            double number = lw_amount_si(&a);
            a = s->unit;                                 /* a plain number is in the unit of the parameter */
            a.number = number;
        }
        if (st == LW_OK && a.kind != s->info.kind)
            st = lw_error_set(&inner, LW_E_NOTATION, "%s is expected", s->info.kind == LW_AMOUNT_TRUTH ? "true or false" : "a number");
    }
    if (st != LW_OK) {
        free(copy);
        return lw_error_at(e, st == LW_E_NOTATION ? LW_E_ARG : st, v->m->file, 0, 0, "%s = %.60s: %s", name, value, inner.text);
    }
    free(v->text[1 + at]);
    v->text[1 + at] = copy;
    v->own[1 + at] = a;
    v->given[1 + at] = true;
    v->fresh = false;
    return LW_OK;
}

/* Does a value suit its parameter: unit, range, choices? */
static lw_status suits(const lw_variant *v, const lw_symbol *s, const lw_amount *a, lw_error *e)
{
    const lw_parameter *p = &s->info;
    double x = a->number;
    char text[96];
    lw_amount plain = lw_amount_plain(1);
    const lw_json_node *at = &s->node->json;
    if (s->let)
        return LW_OK;
    if (a->kind == LW_AMOUNT_NUMBER && !lw_amount_in(a, s->has_unit ? &s->unit : &plain, &x)) {
        lw_dimension_print(a->dimension, text, sizeof text);
        return lw_json_fault(at, e, "the value of %s is in [%s], its unit is [%s]", s->name, text, s->has_unit ? p->unit : "1");
    }
    lw_variant_print(v, (int)(s - v->m->scope.symbol) - 1, a, text, sizeof text);
    if (p->has_range && a->kind == LW_AMOUNT_NUMBER && !(x >= p->least && x <= p->most))
        return lw_json_fault(at, e, "%s = %s is outside its range %g to %g %s", s->name, text, p->least, p->most, p->unit);
    if (p->whole && a->kind == LW_AMOUNT_NUMBER && x != round(x))
        return lw_json_fault(at, e, "%s = %s is no whole number", s->name, text);
    bool found = !s->choices;
    for (int i = 0; s->choices && i < s->choices->n; i++) {
        const lw_template *c = &s->choices->child[i];
        double number = 0;
        found = found || (a->kind == LW_AMOUNT_TEXT && lw_template_text(c) && strcmp(lw_template_text(c), a->text) == 0)
             || (a->kind == LW_AMOUNT_NUMBER && c->type == LW_JSON_NUMBER && lw_json_number(&c->json, &number,
                 NULL) == LW_OK
                 && number == x);
    }
    return found ? LW_OK : lw_json_fault(at, e, "%s = %s is none of its choices", s->name, text);
}

static void apply_setting(lw_variant *v, const lw_setting *s, bool *done)
{
    for (int i = 0; i < s->n; i++) {
        v->value[s->set[i].symbol] = s->set[i].value;
        done[s->set[i].symbol] = true;
    }
}

lw_status lw_variant_update(lw_variant *v, lw_error *e)
{
    const lw_master *m = v->m;
    const lw_scope *scope = &m->scope;
    if (v->fresh)
        return LW_OK;
    bool *done = calloc((size_t)scope->n, sizeof *done);
    if (!done)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a variant");
    for (int i = 0; i < scope->n; i++)
        v->value[i] = scope->symbol[i].value;
    v->value[LW_SYMBOL_VIEW] = lw_amount_of_text(v->view >= 0 ? m->view[v->view].name : "");
    if (v->view >= 0)
        apply_setting(v, &m->view[v->view], done);
    if (v->configuration >= 0)
        apply_setting(v, &m->configuration[v->configuration], done);
    for (int i = 0; i < scope->n; i++)
        if (v->given[i]) {
            v->value[i] = v->own[i];
            done[i] = true;
        }
    lw_status s = LW_OK;
    for (int i = 1; s == LW_OK && i <= m->n_parameter; i++)       /* values given before formulas over them */
        if (done[i] || !scope->symbol[i].formula)
            s = suits(v, &scope->symbol[i], &v->value[i], e);
    for (int k = 0; s == LW_OK && k < scope->n_order; k++) {
        int i = scope->order[k];
        const lw_symbol *y = &scope->symbol[i];
        const char *text = lw_template_text(y->node);
        lw_error inner = { 0 };
        if (done[i])
            continue;
        s = lw_formula_value(y->formula, (const lw_amount *const[2]){ v->value, NULL }, &v->value[i], &inner);
        if (s != LW_OK)
            s = lw_template_fault(y->node, text && text[0] == '=', &inner, e);
    }
    for (int i = 1; s == LW_OK && i <= m->n_parameter; i++)
        if (!done[i] && scope->symbol[i].formula)
            s = suits(v, &scope->symbol[i], &v->value[i], e);
    free(done);
    v->fresh = s == LW_OK;
    return s;
}

lw_status lw_variant_value(lw_variant *v, int parameter, lw_amount *out, lw_error *e)
{
    lw_status s = parameter >= 0 && parameter < v->m->n_parameter + v->m->n_let ? lw_variant_update(v, e)
                : lw_error_set(e, LW_E_ARG, "there is no such parameter");
    if (s == LW_OK)
        *out = v->value[1 + parameter];
    return s;
}

lw_status lw_variant_quantity(lw_variant *v, const char *text, double *out, char *unit, lw_error *e)
{
    lw_formula *f = NULL;
    lw_amount a;
    lw_status s = lw_variant_update(v, e);
    if (s == LW_OK)
        s = lw_master_formula(v->m, text, &f, e);
    if (s == LW_OK)
        s = lw_formula_value(f, (const lw_amount *const[2]){ v->value, NULL }, &a, e);
    if (s == LW_OK && a.kind != LW_AMOUNT_NUMBER)
        s = lw_error_set(e, LW_E_KIND, "this is a %s, no number", a.kind == LW_AMOUNT_TEXT ? "text" : "condition");
    if (s == LW_OK) {
        const lw_amount *as = lw_formula_unit(f);
        const char *name = as ? strstr(text, " as ") : NULL;
        *out = lw_amount_si(&a);
        if (as)
            lw_amount_in(&a, as, out);
        if (unit && name)
            snprintf(unit, 64, "%s", name + 4);
        else if (unit) {
            lw_dimension_print(a.dimension, unit, 64);
            if (strcmp(unit, "plain number") == 0)
                strcpy(unit, "1");
        }
    }
    lw_formula_free(f);
    return s;
}

void lw_variant_print(const lw_variant *v, int parameter, const lw_amount *a, char *text, size_t size)
{
    char digits[LW_NUMBER_SIZE], unit[64];
    const lw_symbol *s = parameter >= 0 && parameter < v->m->n_parameter ? &v->m->scope.symbol[1 + parameter] : NULL;
    double x = lw_amount_si(a);
    if (a->kind != LW_AMOUNT_NUMBER) {
        snprintf(text, size, "%s", a->kind == LW_AMOUNT_TEXT ? a->text : a->number != 0 ? "true" : "false");
        return;
    }
    lw_dimension_print(a->dimension, unit, sizeof unit);
    bool own = s && s->has_unit && lw_amount_in(a, &s->unit, &x);
    lw_number_text(digits, x, 10);
    snprintf(text, size, "%s%s%s", digits, own || strcmp(unit, "plain number") != 0 ? " " : "",
             own ? s->info.unit : strcmp(unit, "plain number") != 0 ? unit : "");
}

lw_status lw_variant_check(lw_variant *v, int i, bool *holds, lw_amount *left, lw_amount *right, lw_error *e)
{
    if (i < 0 || i >= v->m->n_check)
        return lw_error_set(e, LW_E_ARG, "there is no such check");
    const lw_check *c = &v->m->check[i];
    lw_error inner = { 0 };
    lw_amount truth;
    lw_status s = lw_variant_update(v, e);
    if (s != LW_OK)
        return s;
    s = lw_formula_compare(c->formula, (const lw_amount *const[2]){ v->value, NULL }, &truth, left, right, &inner);
    if (s == LW_OK && truth.kind != LW_AMOUNT_TRUTH)
        return lw_json_fault(&c->node->json, e, "this is no condition; write a comparison, such as a + b < c");
    *holds = s == LW_OK && truth.number != 0;
    return s == LW_OK ? s : lw_template_fault(c->node, lw_template_text(c->node)[0] == '=', &inner, e);
}

lw_status lw_variant_hold_checks(lw_variant *v, lw_error *e)
{
    bool holds = true;
    lw_amount left, right;
    char a[96], b[96];
    for (int i = 0; i < v->m->n_check; i++) {
        lw_status s = lw_variant_check(v, i, &holds, &left, &right, e);
        if (s != LW_OK)
            return s;
        lw_variant_print(v, -1, &left, a, sizeof a);
        lw_variant_print(v, -1, &right, b, sizeof b);
        if (!holds)
            return lw_json_fault(&v->m->check[i].node->json, e, "this check does not hold: %s (%s against %s)",
                                 lw_master_check_text(v->m, i), a, b);
    }
    return LW_OK;
}
