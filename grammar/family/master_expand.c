/* grammar/family/master_expand.c - the model file of a variant.
 *
 * First all parts are placed: each use becomes an instance with its own values and its frame in the model.  Then the
 * keys of the model are written; lists continue with the elements of the instances.  Each value written is noted with
 * the template that it came from, for errors of the reader of the model. */
#include "grammar/family/master_expansion_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/bytes.h"
#include "base/growable_array.h"
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "base/vec2.h"

#define INSTANCE_MAX  10000
#define REPEAT_MAX    100000
#define ELEMENT_MAX   1000000
#define TEXT_MAX      (64u << 20)

typedef struct writer {
    const lw_master *m;
    lw_variant *v;
    map        *map;
    lw_bytes    out;
    long        n_element;
    int         now;                     /* instance whose values count; -1: the model */
    lw_error   *e;
} writer;

/* ---- memory, errors ------------------------------------------------------------------------------ */

static void *take(map *p, size_t size)
{
    size = (size + 15)/16*16;
    if (!p->memory || p->memory->room - p->memory->used < size) {
        size_t room = size > 16384 ? size : 16384;
        block *b = malloc(sizeof *b + 16 + room);
        if (!b)
            return NULL;
        *b = (block){ p->memory, 0, room };
        p->memory = b;
    }
    char *data = (char *)(p->memory + 1) + p->memory->used;
    p->memory->used += size;
    return memset(data, 0, size);
}

static lw_status no_memory(const writer *w) { return lw_error_set(w->e, LW_E_MEMORY, "out of memory for a model"); }

static lw_status fault(const writer *w, const lw_template *t, const char *format, ...) __attribute__((format(printf, 3, 4)));
static lw_status fault(const writer *w, const lw_template *t, const char *format, ...)
{
    char text[400];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    lw_status s = lw_json_fault(&t->json, w->e, "%s", text);
    lw_master_name_instances(w->map, w->now, w->e);
    return s;
}

static lw_status note(writer *w, const lw_template *t, bool key)
{
    map *p = w->map;
    mark *more = lw_array_grow(p->mark, p->n_mark, &p->mark_room, sizeof *more);
    if (!more)
        return no_memory(w);
    p->mark = more;
    more[p->n_mark++] = (mark){ (uint32_t)w->out.size, (uint32_t)(t - w->m->block), w->now, key };
    if (w->out.size > TEXT_MAX)
        return fault(w, t, "the model is larger than 64 MB");
    return w->out.failed ? no_memory(w) : LW_OK;
}

/* ---- values ---------------------------------------------------------------------------------------- */

static lw_amount *values_now(const writer *w) { return w->now < 0 ? w->v->value : w->map->instance[w->now].value; }

static lw_status formula_value(const writer *w, const lw_template *t, const lw_formula *f, size_t at, lw_amount *out)
{
    lw_error inner = { 0 };
    const lw_amount *const value[2] = { w->v->value, w->now < 0 ? NULL : w->map->instance[w->now].value };
    lw_status s = lw_formula_value(f, value, out, &inner);
    if (s == LW_OK)
        return s;
    s = lw_template_fault(t, at, &inner, w->e);
    lw_master_name_instances(w->map, w->now, w->e);
    return s;
}

static size_t formula_at(const lw_template *t) { const char *text = lw_json_text(&t->json); return text
                                                 && text[0] == '='; }

static const char *unit_names(const lw_template *t, char text[96])
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < t->n_unit && used < 90; i++)
        used += (size_t)snprintf(text + used, 96 - used, "%s%s", i ? " or " : "",
                                 strcmp(t->key->units[i], "1") == 0 ? "plain number" : t->key->units[i]);
    return text;
}

/* The number of a scalar as it stands in the model file: in the unit of its key. */
static lw_status in_unit_of_key(const writer *w, const lw_template *t, const lw_formula *f, const lw_amount *a, double *out)
{
    char text[96], one[64];
    const lw_amount *as = lw_formula_unit(f), plain = lw_amount_plain(1);
    for (int i = 0; i < t->n_unit; i++)
        if (lw_amount_in(a, &t->unit[i], out)) {
            if (as && (as->over != t->unit[i].over || as->under != t->unit[i].under))
                return fault(w, t, "this key has its own unit in the model; leave out the \"as\"");
            return LW_OK;
        }
    lw_dimension_print(a->dimension, one, sizeof one);
    if (t->n_unit)
        return fault(w, t, "the units do not fit: [%s] is expected, this is [%s]", unit_names(t, text), one);
    if (lw_amount_in(a, as ? as : &plain, out))
        return LW_OK;
    const lw_json_node *n = &t->json;
    while (!n->key && n->parent)
        n = n->parent;
    return fault(w, t, "the unit of \"%s\" is not known here and this is in [%s]; write the unit of the number, as in \"= ... as mm\"",
                 n->key ? n->key : "this", one);
}

/* A scalar as a number in the unit of its key. */
static lw_status number_of(const writer *w, const lw_template *t, double *out)
{
    lw_amount a;
    *out = t->number;
    if (t->type == LW_JSON_NUMBER)
        return LW_OK;
    if (t->kind != LW_TEMPLATE_FORMULA)
        return fault(w, t, "a number or a formula \"=...\" is expected here");
    lw_status s = formula_value(w, t, t->formula, 1, &a);
    if (s == LW_OK && a.kind != LW_AMOUNT_NUMBER)
        return fault(w, t, "a number is expected here");
    return s == LW_OK ? in_unit_of_key(w, t, t->formula, &a, out) : s;
}

/* Computed numbers have 15 digits: 0.1 + 0.2 is 0.3, as a person would write it.  No -0. */
static void print_computed(double v, char digits[LW_NUMBER_SIZE]) { lw_number_text(digits, v + 0.0, 15); }

/* Append an amount as the text of a piece: in SI, or in the unit after `as`. */
static void add_amount(lw_bytes *b, const lw_amount *a, const lw_formula *f)
{
    char digits[LW_NUMBER_SIZE];
    double x = lw_amount_si(a);
    if (a->kind != LW_AMOUNT_NUMBER) {
        lw_bytes_text(b, a->kind == LW_AMOUNT_TEXT ? a->text : a->number != 0 ? "true" : "false");
        return;
    }
    if (lw_formula_unit(f))
        lw_amount_in(a, lw_formula_unit(f), &x);
    print_computed(x, digits);
    lw_bytes_text(b, digits);
}

static lw_status pieces_text(writer *w, const lw_template *t, lw_bytes *b)
{
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < t->n_piece; i++) {
        lw_amount a;
        if (!t->piece[i].formula) {
            lw_bytes_add(b, t->piece[i].text, t->piece[i].size);
            continue;
        }
        s = formula_value(w, t, t->piece[i].formula, t->piece[i].at, &a);
        if (s == LW_OK)
            add_amount(b, &a, t->piece[i].formula);
    }
    return s;
}

/* A text that lives as long as the expansion. */
static lw_status text_of(writer *w, const lw_template *t, const char **out)
{
    lw_bytes b = { 0 };
    lw_amount a;
    lw_status s = LW_OK;
    if (t->kind == LW_TEMPLATE_VERBATIM && t->type == LW_JSON_TEXT) {
        *out = lw_json_text(&t->json);
        return LW_OK;
    }
    if (t->kind == LW_TEMPLATE_PIECES)
        s = pieces_text(w, t, &b);
    else if (t->kind == LW_TEMPLATE_FORMULA) {
        s = formula_value(w, t, t->formula, 1, &a);
        if (s == LW_OK && a.kind != LW_AMOUNT_TEXT)
            s = fault(w, t, "a text is expected here");
        if (s == LW_OK)
            lw_bytes_text(&b, a.text);
    } else
        s = fault(w, t, "a text is expected here");
    char *copy = s == LW_OK ? take(w->map, b.size + 1) : NULL;
    if (s == LW_OK && (!copy || b.failed))
        s = no_memory(w);
    if (s == LW_OK)
        memcpy(copy, b.data ? b.data : "", b.size);
    *out = copy;
    lw_bytes_free(&b);
    return s;
}

/* The value of a parameter of a part, of an index: any scalar. */
static lw_status amount_of(writer *w, const lw_template *t, lw_amount *out)
{
    lw_status s = LW_OK;
    const char *text;
    if (t->kind == LW_TEMPLATE_FORMULA)
        s = formula_value(w, t, t->formula, formula_at(t), out);
    else if (t->type == LW_JSON_NUMBER)
        *out = lw_amount_plain(t->number);
    else if (t->type == LW_JSON_TEXT) {
        s = text_of(w, t, &text);
        *out = lw_amount_of_text(text);
    } else if (t->type == LW_JSON_OTHER && lw_json_truth(&t->json) >= 0)
        *out = (lw_amount){ .kind = LW_AMOUNT_TRUTH, .number = lw_json_truth(&t->json), .over = 1, .under = 1 };
    else
        s = fault(w, t, "a number, a text, true or false is expected here");
    if (s == LW_OK && out->kind == LW_AMOUNT_TEXT && t->kind == LW_TEMPLATE_FORMULA) {
        char *copy = take(w->map, strlen(out->text) + 1);
        if (!copy)
            return no_memory(w);
        out->text = strcpy(copy, out->text);
    }
    return s;
}

static lw_status condition(writer *w, const lw_template *t, bool *out)
{
    lw_amount a;
    lw_status s;
    *out = true;
    if (!t || (s = amount_of(w, t, &a)) != LW_OK)
        return t ? s : LW_OK;
    *out = a.number != 0;
    return a.kind == LW_AMOUNT_TRUTH ? LW_OK : fault(w, t, "a condition is expected here, such as \"n > 2\"");
}

/* ---- repeats ----------------------------------------------------------------------------------------- */

typedef lw_status element_fn(writer *w, const lw_template *t, void *context);

static lw_status whole_of(writer *w, const lw_template *t, double *out)
{
    lw_amount a;
    lw_status s = amount_of(w, t, &a);
    if (s != LW_OK)
        return s;
    *out = lw_amount_si(&a);
    if (a.kind != LW_AMOUNT_NUMBER || !lw_dimension_fits(a.dimension, lw_amount_plain(0).dimension)
        || *out != round(*out)
        || !(fabs(*out) < 1e9))
        return fault(w, t, "a whole number is expected here");
    return LW_OK;
}

/* Call `each` for the element with all values of the indexes from number k on. */
static lw_status repeat(writer *w, const lw_template *t, int k, element_fn *each, void *context)
{
    bool wanted = true;
    lw_status s = LW_OK;
    if (!t->repeat || k == t->repeat->n) {
        s = condition(w, t->when, &wanted);
        return s == LW_OK && wanted ? each(w, t, context) : s;
    }
    const lw_template *values = t->index[k].values;
    lw_amount *index = &values_now(w)[t->index[k].symbol];
    if (values->kind == LW_TEMPLATE_ARRAY) {
        for (int i = 0; s == LW_OK && i < values->n; i++)
            if ((s = amount_of(w, &values->child[i], index)) == LW_OK)
                s = repeat(w, t, k + 1, each, context);
        return s;
    }
    double from = 1, to = 0;
    if (values->kind == LW_TEMPLATE_OBJECT) {
        s = whole_of(w, lw_template_member(values, "from"), &from);
        if (s == LW_OK)
            s = whole_of(w, lw_template_member(values, "to"), &to);
    } else
        s = whole_of(w, values, &to);
    if (s == LW_OK && to - from >= REPEAT_MAX)
        return fault(w, values, "this asks for %.0f elements; at most %d are made", to - from + 1, REPEAT_MAX);
    if (s == LW_OK && values->kind != LW_TEMPLATE_OBJECT && to < 0)
        return fault(w, values, "a number of elements of at least 0 is expected here, this is %g", to);
    for (double i = from; s == LW_OK && i <= to; i++) {
        *index = lw_amount_plain(i);
        s = repeat(w, t, k + 1, each, context);
    }
    return s;
}

/* ---- frames -------------------------------------------------------------------------------------------- */

static const frame still = { .r = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };

/* cos and sin, exact for multiples of 30 degrees where they are decimal. */
static void turn_of(const lw_amount *a, double *c, double *s)
{
    static const lw_amount degree = { .dimension = { { 0, 0, 0, 0, 0, 1 } }, .number = 1, .over = LW_PI, .under = 180 };
    double deg = 0, x = lw_amount_si(a);
    *c = cos(x);
    *s = sin(x);
    lw_amount_in(a, &degree, &deg);
    if (fmod(deg, 30) != 0)
        return;
    static const double half = 0.5;
    const double root = sqrt(0.75), table[12] = { 0, half, root, 1, root, half, 0, -half, -root, -1, -root, -half };
    int k = (int)fmod(deg/30, 12);
    k += k < 0 ? 12 : 0;
    *s = table[k];
    *c = table[(k + 3)%12];
}

static void settle(frame *f)
{
    f->turned = f->moved = f->out_of_plane = false;
    for (int i = 0; i < 3; i++) {
        f->moved = f->moved || f->t[i] != 0;
        for (int k = 0; k < 3; k++)
            f->turned = f->turned || f->r[i][k] != (i == k);
    }
    f->out_of_plane = f->r[2][2] != 1 || f->t[2] != 0;
}

/* a after b: first b, then a, as points go out of their part. */
static frame compose(const frame *a, const frame *b)
{
    frame f = { .angle = a->angle + b->angle };
    for (int i = 0; i < 3; i++) {
        f.t[i] = a->t[i];
        for (int k = 0; k < 3; k++) {
            f.t[i] += a->r[i][k]*b->t[k];
            for (int n = 0; n < 3; n++)
                f.r[i][k] += a->r[i][n]*b->r[n][k];
        }
    }
    settle(&f);
    return f;
}

static frame inverse(const frame *a)
{
    frame f = { .angle = -a->angle };
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            f.r[i][k] = a->r[k][i];
            f.t[i] -= a->r[k][i]*a->t[k];
        }
    settle(&f);
    return f;
}

static lw_status read_vector(writer *w, const lw_template *t, int least, double out[3])
{
    lw_status s = LW_OK;
    out[0] = out[1] = out[2] = 0;
    if (t->kind != LW_TEMPLATE_ARRAY || t->n < least || t->n > 3)
        return fault(w, t, least == 3 ? "three numbers [x, y, z] are expected here" : "[x, y] or [x, y, z] is expected here");
    for (int i = 0; s == LW_OK && i < t->n; i++)
        s = number_of(w, &t->child[i], &out[i]);
    return s;
}

/* Rodrigues' formula; the axis when left out is z. */
static lw_status read_turn(writer *w, const lw_template *angle, const lw_template *axis, frame *f)
{
    double a[3] = { 0, 0, 1 }, c, s, x;
    lw_amount amount = w->m->angle;
    lw_status st = axis ? read_vector(w, axis, 3, a) : LW_OK;
    if (st == LW_OK)
        st = number_of(w, angle, &x);
    if (st != LW_OK)
        return st;
    double length = sqrt(a[0]*a[0] + a[1]*a[1] + a[2]*a[2]);
    if (!(length > 0) || !isfinite(length))
        return fault(w, axis, "this axis has no direction");
    amount.number = x;
    turn_of(&amount, &c, &s);
    for (int i = 0; i < 3; i++)
        a[i] /= length;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            f->r[i][k] = i == k && a[i]*a[i] == 1 ? 1 : (i == k ? c : 0) + (1 - c)*a[i]*a[k];
    f->r[0][1] -= s*a[2];
    f->r[1][0] += s*a[2];
    f->r[0][2] += s*a[1];
    f->r[2][0] -= s*a[1];
    f->r[1][2] -= s*a[0];
    f->r[2][1] += s*a[0];
    f->angle = a[2] > 0 ? lw_amount_si(&amount) : -lw_amount_si(&amount);
    settle(f);
    return LW_OK;
}

/* The frame of "instance.port" among the instances of the scope that is being written. */
static lw_status find_port(writer *w, const lw_template *t, frame *out)
{
    const char *text;
    lw_status s = text_of(w, t, &text);
    if (s != LW_OK)
        return s;
    const char *dot = strrchr(text, '.');
    size_t n = dot ? (size_t)(dot - text) : 0;
    int at = dot ? w->map->n_instance - 1 : -1;
    while (at >= 0 && (w->map->instance[at].parent != w->now || strlen(w->map->instance[at].name) != n
                       || memcmp(w->map->instance[at].name, text, n) != 0))
        at--;
    if (at < 0)
        return fault(w, t, "a port of a part used before is expected here, as \"name.port\"; there is no \"%.60s\"", text);
    const instance *of = &w->map->instance[at];
    int k = 0;
    while (k < of->part->n_port && strcmp(of->part->port[k].node->json.key, dot + 1) != 0)
        k++;
    if (k == of->part->n_port) {
        const char **names = malloc(((size_t)k + 1)*sizeof *names);
        for (int i = 0; names && i < k; i++)
            names[i] = of->part->port[i].node->json.key;
        const char *near = names ? lw_suggest(dot + 1, names, k) : NULL;
        s = fault(w, t, "part \"%s\" has no port \"%.60s\"%s%s%s", of->part->name, dot + 1, LW_DID_YOU_MEAN(near));
        free(names);
        return s;
    }
    frame local = still;
    int before = w->now;
    w->now = at;
    s = read_vector(w, of->part->port[k].at, 2, local.t);
    if (s == LW_OK && of->part->port[k].angle)
        s = read_turn(w, of->part->port[k].angle, of->part->port[k].axis, &local);
    w->now = before;
    settle(&local);
    *out = compose(&w->map->instance[at].at, &local);
    return s;
}

/* ---- instances ------------------------------------------------------------------------------------------ */

static lw_status place_instances(writer *w, const lw_use *use, int n, int parent);

static lw_status set_values(writer *w, const lw_use *u, int at)
{
    instance *x = &w->map->instance[at];
    const lw_scope *scope = &x->part->scope;
    lw_amount *value = x->value;
    lw_status s = LW_OK;
    for (int i = 0; i < scope->n; i++)
        value[i] = scope->symbol[i].value;
    value[LW_SYMBOL_SELF] = lw_amount_of_text(x->name);
    for (int i = 0; s == LW_OK && i < u->n_with; i++) {            /* in the scope of the user */
        const lw_symbol *y = &scope->symbol[u->with[i].symbol];
        const lw_template *t = u->with[i].value;
        s = amount_of(w, t, &value[u->with[i].symbol]);
        if (s == LW_OK && y->has_unit && t->type == LW_JSON_NUMBER) {
            value[u->with[i].symbol] = y->unit;
            value[u->with[i].symbol].number = t->number;
        }
    }
    w->now = at;
    for (int k = 0; s == LW_OK && k < scope->n_order; k++) {
        int i = scope->order[k];
        bool given = false;
        for (int n = 0; n < u->n_with; n++)
            given = given || u->with[n].symbol == i;
        if (!given)
            s = formula_value(w, scope->symbol[i].node, scope->symbol[i].formula, formula_at(scope->symbol[i].node), &value[i]);
    }
    for (int i = 1; s == LW_OK && i < scope->n; i++) {
        const lw_symbol *y = &scope->symbol[i];
        const lw_parameter *p = &y->info;
        double number = value[i].number;
        char one[64];
        if (!y->node || y->let)
            continue;
        for (int n = 0; n < u->n_with; n++)
            if (u->with[n].symbol == i)
                w->now = x->parent;
        const lw_template *blame = w->now == at ? y->node : u->node;
        lw_dimension_print(value[i].dimension, one, sizeof one);
        if (value[i].kind != (y->formula ? value[i].kind : p->kind))
            s = fault(w, blame, "%s of part \"%s\" is a %s", p->name, x->part->name, p->kind == LW_AMOUNT_TEXT ? "text"
                      : p->kind == LW_AMOUNT_TRUTH ? "condition" : "number");
        else if (value[i].kind == LW_AMOUNT_NUMBER && y->has_unit && !lw_amount_in(&value[i], &y->unit, &number))
            s = fault(w, blame, "%s of part \"%s\" is in [%s], its unit is [%s]", p->name, x->part->name, one, p->unit);
        else if (value[i].kind == LW_AMOUNT_NUMBER && !y->has_unit && !y->formula
                 && !lw_dimension_fits(value[i].dimension, lw_amount_plain(0).dimension))
            s = fault(w, blame, "%s of part \"%s\" is in [%s], but it is a plain number; give it a \"unit\"", p->name, x->part->name, one);
        else if (p->has_range && value[i].kind == LW_AMOUNT_NUMBER && !(number >= p->least && number <= p->most))
            s = fault(w, blame, "%s = %g of part \"%s\" is outside its range %g to %g %s", p->name, number,
                      x->part->name, p->least,
                      p->most, p->unit);
        w->now = at;
    }
    return s;
}

static lw_status place_one(writer *w, const lw_template *t, void *context)
{
    const lw_use *u = context;
    map *p = w->map;
    int at = p->n_instance, parent = w->now;
    (void)t;
    if (at == INSTANCE_MAX)
        return fault(w, u->node, "more than %d parts are used", INSTANCE_MAX);
    instance *more = lw_array_grow(p->instance, at, &p->instance_room, sizeof *more);
    if (!more)
        return no_memory(w);
    p->instance = more;
    const lw_part *part = &w->m->part[u->part];
    instance x = { .part = part, .name = part->name, .parent = parent, .at = still };
    lw_status s = u->name ? text_of(w, u->name, &x.name) : LW_OK;
    for (int i = at - 1; s == LW_OK && i >= 0 && u->name; i--)
        if (p->instance[i].parent == parent && strcmp(p->instance[i].name, x.name) == 0)
            return fault(w, u->node, "the name \"%.60s\" is given to two parts", x.name);
    for (int i = at - 1; s == LW_OK && i >= 0 && !u->name; i--)
        if (p->instance[i].parent == parent && strcmp(p->instance[i].name, x.name) == 0)
            return fault(w, u->node, "part \"%s\" is used several times; give each use a \"name\", as in \"arm {i}\"",
                         x.name);
    if (s == LW_OK && !(x.value = take(p, ((size_t)part->scope.n + 1)*sizeof *x.value)))
        s = no_memory(w);
    if (s == LW_OK && u->at)
        s = read_vector(w, u->at, 2, x.at.t);
    if (s == LW_OK && u->angle)
        s = read_turn(w, u->angle, u->axis, &x.at);
    settle(&x.at);
    frame port = still;
    if (s == LW_OK && u->to)
        s = find_port(w, u->to, &port);
    if (s != LW_OK)
        return s;
    p->instance[p->n_instance++] = x;
    s = set_values(w, u, at);
    w->now = parent;
    /* port of the user, the turn of this use, inverse of the part's port */
    if (s == LW_OK && u->attach) {
        const char *name;
        frame own = still;
        s = text_of(w, u->attach, &name);
        int k = 0;
        while (s == LW_OK && k < part->n_port && strcmp(part->port[k].node->json.key, name) != 0)
            k++;
        if (s == LW_OK && k == part->n_port)
            return fault(w, u->attach, "part \"%s\" has no port \"%.60s\"", part->name, name);
        w->now = at;
        if (s == LW_OK)
            s = read_vector(w, part->port[k].at, 2, own.t);
        if (s == LW_OK && part->port[k].angle)
            s = read_turn(w, part->port[k].angle, part->port[k].axis, &own);
        w->now = parent;
        settle(&own);
        frame back = inverse(&own), turned = compose(&port, &x.at);
        p->instance[at].at = compose(&turned, &back);
    } else if (s == LW_OK && parent >= 0)
        p->instance[at].at = compose(&p->instance[parent].at, &x.at);
    return s == LW_OK ? place_instances(w, part->use, part->n_use, at) : s;
}

static lw_status place_instances(writer *w, const lw_use *use, int n, int parent)
{
    int before = w->now;
    lw_status s = LW_OK;
    w->now = parent;
    for (int i = 0; s == LW_OK && i < n; i++)
        s = repeat(w, use[i].node, 0, place_one, (void *)&use[i]);
    w->now = before;
    return s;
}

/* ---- output ------------------------------------------------------------------------------------------------ */

static lw_status put(writer *w, const lw_template *t);

static void put_text(writer *w, const char *text) { lw_bytes_text(&w->out, text); }

static void put_number(writer *w, double v)
{
    char digits[LW_NUMBER_SIZE];
    print_computed(v, digits);
    put_text(w, digits);
}

static lw_status put_numbers(writer *w, const lw_template *t, const double *v, int n)
{
    lw_status s = note(w, t, false);
    put_text(w, "[");
    for (int i = 0; s == LW_OK && i < n; i++) {
        put_text(w, i ? ", " : "");
        s = note(w, i < t->n ? &t->child[i] : t, false);
        put_number(w, v[i]);
    }
    put_text(w, "]");
    return s;
}

static const frame *frame_now(const writer *w) { return w->now < 0 ? &still : &w->map->instance[w->now].at; }

/* [x, y], [x, y, z] or a list of such. */
static lw_status put_vector(writer *w, const lw_template *t)
{
    const frame *f = frame_now(w);
    double v[3], r[3];
    lw_status s = LW_OK;
    if (t->n > 0 && (t->child[0].kind == LW_TEMPLATE_ARRAY || t->child[0].kind == LW_TEMPLATE_PORT)) {
        s = note(w, t, false);
        put_text(w, "[");
        for (int i = 0; s == LW_OK && i < t->n; i++) {
            put_text(w, i ? ", " : "");
            s = t->child[i].kind == LW_TEMPLATE_ARRAY ? put_vector(w, &t->child[i]) : put(w, &t->child[i]);
        }
        put_text(w, "]");
        return s;
    }
    s = read_vector(w, t, 2, v);
    if (s == LW_OK && t->n == 2 && f->out_of_plane)
        return fault(w, t, "two numbers are of the plane, but this part is turned or moved out of it; write three");
    for (int i = 0; i < 3; i++) {
        r[i] = t->key->geometry == LW_KEY_POINT ? f->t[i] : 0;
        for (int k = 0; k < 3; k++)
            r[i] += f->r[i][k]*v[k];
    }
    return s == LW_OK ? put_numbers(w, t, r, t->n) : s;
}

/* xx yy zz [xy xz yz] in the axes of the part, written in those of the model. */
static lw_status put_tensor(writer *w, const lw_template *t)
{
    static const int row[6] = { 0, 1, 2, 0, 0, 1 }, column[6] = { 0, 1, 2, 1, 2, 2 };
    const frame *f = frame_now(w);
    double in[3][3] = { { 0 } }, out[6] = { 0 };
    lw_status s = LW_OK;
    if (t->n != 3 && t->n != 6)
        return fault(w, t, "three or six numbers are expected here");
    for (int i = 0; s == LW_OK && i < t->n; i++) {
        double v;
        s = number_of(w, &t->child[i], &v);
        in[row[i]][column[i]] = in[column[i]][row[i]] = v;
    }
    for (int i = 0; i < 6; i++)
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                out[i] += f->r[row[i]][a]*in[a][b]*f->r[column[i]][b];
    bool diagonal = t->n == 3 && out[3] == 0 && out[4] == 0 && out[5] == 0;
    return s == LW_OK ? put_numbers(w, t, out, diagonal ? 3 : 6) : s;
}

/* A value that the frame of its part changes.  False: it is written as it is. */
static bool is_geometric(const writer *w, const lw_template *t)
{
    const frame *f = frame_now(w);
    if (!t->key || (!f->turned && !f->moved))
        return false;
    switch (t->key->geometry) {
    case LW_KEY_POINT:     return t->kind == LW_TEMPLATE_ARRAY;
    case LW_KEY_DIRECTION: return f->turned && t->kind == LW_TEMPLATE_ARRAY;
    case LW_KEY_ANGLE:     return f->turned && t->kind != LW_TEMPLATE_OBJECT;
    case LW_KEY_TENSOR:    return f->turned && t->kind == LW_TEMPLATE_ARRAY;
    case LW_KEY_FORCE:     return f->turned;
    default:               return false;
    }
}

static lw_status put_geometric(writer *w, const lw_template *t, const lw_template *object)
{
    const frame *f = frame_now(w);
    const lw_template *axes = object ? lw_template_member(object, "frame") : NULL;
    double v;
    switch (t->key->geometry) {
    case LW_KEY_TENSOR:
        if (!axes)
            return put_tensor(w, t);
        break;                                        /* its own axes are turned instead */
    case LW_KEY_FORCE:
        if (!axes || !lw_json_text(&axes->json) || strcmp(lw_json_text(&axes->json), "link") != 0)
            return fault(w, t, "this part is turned; a force in it needs \"frame\": \"link\"");
        break;
    case LW_KEY_ANGLE: {
        if (f->out_of_plane)
            return fault(w, t, "an angle is of the plane, but this part is turned out of it");
        lw_status s = number_of(w, t, &v);
        if (s != LW_OK)
            return s;
        lw_amount turn = lw_amount_plain(f->angle);
        turn.dimension.of[LW_DIMENSION_RADIAN] = 1;
        double more = 0;
        lw_amount_in(&turn, &w->m->angle, &more);
        if ((s = note(w, t, false)) == LW_OK)
            put_number(w, v + more);
        return s;
    }
    default:
        return put_vector(w, t);
    }
    return put(w, t);                                 /* as it stands */
}

typedef struct list { bool lines, any; const char *indent; } list;

static lw_status put_element(writer *w, const lw_template *t, void *context)
{
    list *l = context;
    put_text(w, l->any ? l->lines ? ",\n    " : ", " : l->lines ? "[\n    " : "[");
    l->any = true;
    if (++w->n_element > ELEMENT_MAX)
        return fault(w, t, "the model has more than %d elements", ELEMENT_MAX);
    return put(w, t);
}

static lw_status put_elements(writer *w, const lw_template *t, list *l)
{
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < t->n; i++)
        s = repeat(w, &t->child[i], 0, put_element, l);
    return s;
}

static bool omits(const writer *w, const char *key) { return lw_master_omits(w->m, w->v->view, key); }

/* An elastic link has no mass of its own: the mass in the master is that of the rigid link. */
static bool is_rigid_only(const char *key) { return strcmp(key, "mass") == 0 || strcmp(key, "centre") == 0
                                             || strcmp(key, "inertia") == 0; }

static lw_status put_object(writer *w, const lw_template *t)
{
    bool any = false, elastic = !omits(w, "elastic") && lw_template_member(t, "elastic");
    lw_status s = LW_OK;
    put_text(w, "{");
    for (int i = 0; s == LW_OK && i < t->n; i++) {
        const lw_template *c = &t->child[i];
        if (c == t->when || c == t->repeat || omits(w, c->json.key) || (elastic && is_rigid_only(c->json.key)))
            continue;
        put_text(w, any ? ", " : "");
        any = true;
        s = note(w, c, true);
        lw_master_quote(&w->out, c->json.key);
        put_text(w, ": ");
        if (s == LW_OK)
            s = is_geometric(w, c) ? put_geometric(w, c, t) : put(w, c);
    }
    put_text(w, "}");
    return s;
}

static lw_status put_formula(writer *w, const lw_template *t)
{
    lw_amount a;
    double v;
    lw_status s = formula_value(w, t, t->formula, formula_at(t), &a);
    if (s != LW_OK)
        return s;
    if (a.kind == LW_AMOUNT_TEXT)
        lw_master_quote(&w->out, a.text);
    else if (a.kind == LW_AMOUNT_TRUTH)
        put_text(w, a.number != 0 ? "true" : "false");
    else if ((s = in_unit_of_key(w, t, t->formula, &a, &v)) == LW_OK)
        put_number(w, v);
    return s;
}

static lw_status put(writer *w, const lw_template *t)
{
    lw_status s = note(w, t, false);
    if (s != LW_OK)
        return s;
    switch (t->kind) {
    case LW_TEMPLATE_VERBATIM:
        put_text(w, t->verbatim);
        return LW_OK;
    case LW_TEMPLATE_FORMULA:
        return put_formula(w, t);
    case LW_TEMPLATE_PIECES: {
        lw_bytes b = { 0 };
        s = pieces_text(w, t, &b);
        if (s == LW_OK && !b.failed)
            lw_master_quote(&w->out, b.data ? b.data : "");
        s = s == LW_OK && b.failed ? no_memory(w) : s;
        lw_bytes_free(&b);
        return s;
    }
    case LW_TEMPLATE_OBJECT:
        return put_object(w, t);
    case LW_TEMPLATE_PORT: {
        frame f;
        s = find_port(w, t->child, &f);
        bool plane = f.t[2] == 0 && !f.out_of_plane;
        return s == LW_OK ? put_numbers(w, t, f.t, plane ? 2 : 3) : s;
    }
    case LW_TEMPLATE_ARRAY: {
        list l = { .lines = false };
        s = put_elements(w, t, &l);
        put_text(w, l.any ? "]" : "[]");
        return s;
    }
    }
    return LW_OK;
}

static bool has_object(const lw_template *t)
{
    for (int i = 0; t && i < t->n; i++)
        if (t->child[i].type == LW_JSON_OBJECT)
            return true;
    return false;
}

/* The list `key` of the model (own: NULL for none) and of all parts. */
static lw_status put_list(writer *w, const char *key, const lw_template *own)
{
    const lw_template *first = own;
    list l = { .lines = has_object(own) };
    size_t size = w->out.size;
    int n_mark = w->map->n_mark;
    for (int i = 0; i < w->map->n_instance; i++) {
        const lw_template *t = lw_template_member(w->map->instance[i].part->node, key);
        first = first ? first : t;
        l.lines = l.lines || has_object(t);
    }
    put_text(w, ",\n  ");
    lw_status s = note(w, first, true);
    lw_master_quote(&w->out, key);
    put_text(w, ": ");
    if (s == LW_OK)
        s = note(w, first, false);
    if (s == LW_OK && own)
        s = put_elements(w, own, &l);
    for (int i = 0; s == LW_OK && i < w->map->n_instance; i++) {
        const lw_template *t = lw_template_member(w->map->instance[i].part->node, key);
        w->now = i;
        if (t)
            s = put_elements(w, t, &l);
    }
    w->now = -1;
    put_text(w, !l.any ? "[]" : l.lines ? "\n  ]" : "]");
    if (s == LW_OK && !l.any && first->n > 0 && !w->out.failed) {      /* nothing is left of it */
        w->out.size = size;
        w->out.data[size] = '\0';
        w->map->n_mark = n_mark;
    }
    return s;
}

static bool is_list_of_parts(const char *key)
{
    static const char *const others[] = { "parameters", "let", "ports", "use", "doc" };
    for (size_t i = 0; i < sizeof others/sizeof *others; i++)
        if (strcmp(key, others[i]) == 0)
            return false;
    return strncmp(key, "x-", 2) != 0;
}

static lw_status put_model(writer *w)
{
    const lw_template *model = w->m->model;
    lw_status s = LW_OK;
    put_text(w, "{\n  \"linkwright\": 1");
    for (int i = 0; s == LW_OK && i < model->n; i++) {
        const lw_template *t = &model->child[i];
        if (strcmp(t->json.key, "use") == 0 || omits(w, t->json.key))
            continue;
        if (t->type == LW_JSON_ARRAY && (!t->key || t->key->geometry == LW_KEY_PLAIN)) {
            s = put_list(w, t->json.key, t);
            continue;
        }
        put_text(w, ",\n  ");
        s = note(w, t, true);
        lw_master_quote(&w->out, t->json.key);
        put_text(w, ": ");
        if (s == LW_OK)
            s = put(w, t);
    }
    bool *seen = take(w->map, (size_t)w->m->n_part + 1);
    const char *more[64];                             /* keys that only parts have */
    int n_more = 0;
    for (int i = 0; s == LW_OK && seen && i < w->map->n_instance; i++) {
        const lw_part *part = w->map->instance[i].part;
        for (int k = 0; s == LW_OK && !seen[part - w->m->part] && k < part->node->n; k++) {
            const char *key = part->node->child[k].json.key;
            bool done = !is_list_of_parts(key) || lw_template_member(model, key) || omits(w, key);
            for (int n = 0; n < n_more; n++)
                done = done || strcmp(more[n], key) == 0;
            if (done)
                continue;
            if (n_more == 64)
                return fault(w, &part->node->child[k], "the parts have more than 64 kinds of lists");
            more[n_more++] = key;
            s = put_list(w, key, NULL);
        }
        seen[part - w->m->part] = true;
    }
    if (!seen)
        return no_memory(w);
    put_text(w, "\n}\n");
    return s == LW_OK && w->out.failed ? no_memory(w) : s;
}

lw_status lw_variant_expand(lw_variant *v, lw_expansion *out, lw_error *e)
{
    lw_error own = { 0 };
    *out = (lw_expansion){ 0 };
    lw_status s = lw_variant_update(v, e ? e : &own);
    if (s != LW_OK)
        return s;
    map *p = calloc(1, sizeof *p);
    writer w = { .m = v->m, .v = v, .map = p, .now = -1, .e = e ? e : &own };
    if (!p)
        return no_memory(&w);
    p->m = v->m;
    *out = (lw_expansion){ .map = p };
    s = place_instances(&w, v->m->use, v->m->n_use, -1);
    if (s == LW_OK)
        s = put_model(&w);
    out->text = w.out.data;
    out->size = w.out.size;
    if (s != LW_OK)
        lw_expansion_free(out);
    return s;
}

void lw_expansion_free(lw_expansion *x)
{
    map *p = x->map;
    for (block *b = p ? p->memory : NULL, *next; b; b = next) {
        next = b->next;
        free(b);
    }
    if (p) {
        free(p->instance);
        free(p->mark);
    }
    free(p);
    free(x->text);
    *x = (lw_expansion){ 0 };
}
