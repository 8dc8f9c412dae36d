/* grammar/model/model_states.c - expressions of a model, and parts with states of first order: "states", "controllers", "cylinders", and
 * motors with an electrical circuit or a wanted torque (docs/notation.md, "States").
 *
 * Each part becomes expressions: the rates of its states, and the law of a spring that pushes.  So its derivatives
 * are exact, and the dynamics know states and laws only. */
#include "base/real.h"
#include "grammar/model/model_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "grammar/linkage/read_internal.h"

/* ---- states and signals --------------------------------------------------------------------------------- */

enum { STATES, SIGNALS };                      /* of lw_states.named */

/* A new state; its number, -1: out of memory. */
static int add_state(lw_states *z, const char *name, const char *unit, double scale)
{
    lw_state *more = realloc(z->state, ((size_t)z->n_state + 1)*sizeof *more);
    if (!more)
        return -1;
    z->state = more;
    more[z->n_state] = (lw_state){ .unit = unit, .scale = scale };
    snprintf(more[z->n_state].name, sizeof more->name, "%s", name);
    return lw_key_table_add(&z->named[STATES], more[z->n_state].name, strlen(more[z->n_state].name) + 1, z->n_state) ? z->n_state++ : -1;
}

/* A signal "name.what" takes x over.  LW_E_MEMORY. */
static lw_status add_signal(lw_states *z, const char *name, const char *what, const char *unit, lw_expression *x, lw_error *e)
{
    lw_signal *more = realloc(z->signal, ((size_t)z->n_signal + 1)*sizeof *more);
    if (!more) {
        lw_expression_free(x);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    z->signal = more;
    more[z->n_signal] = (lw_signal){ .unit = unit, .value = x };
    char *all = more[z->n_signal].name;
    snprintf(all, sizeof more->name, "%s.%s", name, what);
    return lw_key_table_add(&z->named[SIGNALS], all, strlen(all) + 1, z->n_signal++) ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* A word of a text that the program writes: an expression to insert, or (expression NULL) a variable. */
typedef struct lw_generated { const char *word; const lw_expression *expression; int variable; } lw_generated;
typedef struct generated_words { const lw_generated *word; int n; } generated_words;

static const lw_generated *find_word(const generated_words *g, const char *word)
{
    for (int i = 0; i < g->n; i++)
        if (strcmp(word, g->word[i].word) == 0)
            return &g->word[i];
    return NULL;
}

static int generated_variable(void *context, const char *word, const char *name, char *why)
{
    const lw_generated *w = find_word(context, word);
    (void)name, (void)why;
    return w && !w->expression ? w->variable : -1;
}

static const lw_expression *generated_insert(void *context, const char *word, const char *name)
{
    const lw_generated *w = find_word(context, word);
    (void)name;
    return w ? w->expression : NULL;
}

static lw_status parse_generated(const char *text, const lw_generated *word, int n, lw_expression **out, lw_error *e)
{
    generated_words g = { word, n };
    lw_expression_words words = { .context = &g, .variable = generated_variable, .insert = generated_insert };
    return lw_expression_parse_words(text, strlen(text), &words, out, e);
}

/* The same for a text with numbers; a fault in it is that of an object of the file: expressions too long for one. */
static lw_status generate(const lw_json_node *object, const lw_generated *word, int n, lw_expression **out, lw_error *e, const char *text)
{
    lw_error inner = { 0 };
    lw_status s = parse_generated(text, word, n, out, &inner);
    return s == LW_OK ? s : s == LW_E_MEMORY ? lw_error_set(e, s, "%s", inner.text)
                      : lw_json_fault(object, e, "the expressions here are too long together: %s", inner.text);
}

lw_status lw_expression_mix(const double weight[2], lw_expression *const of[2], lw_expression **out, lw_error *e)
{
    const lw_generated word[] = { { "a", of[0], 0 }, { "b", of[1], 0 } };
    char text[80];
    if (!of[0] && !of[1])
        return LW_OK;
    if (of[0] && of[1])
        snprintf(text, sizeof text, "%.17g*a + (%.17g)*b", weight[0], weight[1]);
    else
        snprintf(text, sizeof text, "%.17g*%s", weight[of[0] ? 0 : 1], of[0] ? "a" : "b");
    return parse_generated(text, word, COUNT(word), out, e);
}

static int variable_of_state(int i) { return lw_variable(LW_QUANTITY_STATE, i); }

static int find_state(const lw_states *z, const char *name, const char *what)
{
    char all[sizeof z->state->name];
    int size = snprintf(all, sizeof all, what ? "%s.%s" : "%s", name, what) + 1;
    return size > (int)sizeof all ? -1 : lw_key_table_find(&z->named[STATES], z->state, sizeof *z->state, all, (size_t)size);
}

/* ---- expressions ------------------------------------------------------------------------------------------ */

typedef struct look { const lw_reading *r; lw_expression_scope scope; lw_json *json; } look;

/* A state, or a spring or cylinder: state(name), length(name), rate(name). */
static int look_up_named(const look *l, const char *word, const char *name, char *why)
{
    const lw_reading *r = l->r;
    bool state = strcmp(word, "state") == 0;
    if (!state && strcmp(word, "length") != 0 && strcmp(word, "rate") != 0)
        return -1;
    if (!name) {
        snprintf(why, LW_WHY_SIZE, "%s needs the name of a %s: %s(...)", word, state ? "state" : "spring or cylinder", word);
        return -1;
    }
    int at = state ? find_state(r->states, name, NULL) : lw_read_find_spring(r, l->json, name, why);
    if (at < 0 && state)
        snprintf(why, LW_WHY_SIZE, "there is no state \"%.40s\" (those of motors: NAME.current; of cylinders: NAME.p1)", name);
    return at < 0 ? -1 : lw_variable(state ? LW_QUANTITY_STATE : word[0] == 'l' ? LW_QUANTITY_SPRING_LENGTH : LW_QUANTITY_SPRING_RATE, at);
}

/* output(name) of a controller, or the part before the point of a signal's name. */
static const lw_expression *insert_signal(void *context, const char *word, const char *name)
{
    const look *l = context;
    const lw_states *z = l->r->states;
    char all[sizeof z->signal->name];
    if (l->scope != LW_OF_STATE || !name || snprintf(all, sizeof all, "%s.%s", name, word) >= (int)sizeof all)
        return NULL;
    int i = lw_key_table_find(&z->named[SIGNALS], z->signal, sizeof *z->signal, all, strlen(all) + 1);
    return i < 0 ? NULL : z->signal[i].value;
}

static const struct lw_moves *find_profile(void *context, const char *name)
{
    const look *l = context;
    const lw_reading *r = l->r;
    return lw_moves_find(l->json, *r->n_profile, *r->profile, name);
}

/* The state of integral(x) or lag(x, time). */
static int integrate(void *context, lw_expression *x, double lag, double start)
{
    lw_states *all = ((const look *)context)->r->states;
    char name[2*LW_NAME_SIZE];
    do                                         /* a state of the file may have such a name */
        snprintf(name, sizeof name, "%s %d", lag > 0 ? "lag" : "integral", ++all->n_made[lag > 0]);
    while (find_state(all, name, NULL) >= 0);
    int i = add_state(all, name, "1", 1);
    if (i < 0) {
        lw_expression_free(x);
        return -1;
    }
    lw_state *z = &all->state[i];
    z->start = isnan(start) ? 0 : start;
    if (!(lag > 0)) {
        z->rate = x;
        return lw_variable(LW_QUANTITY_STATE, i);
    }
    if (isnan(start))
        z->start_at = x;
    const lw_generated word[] = { { "x", x, 0 }, { "z", NULL, lw_variable(LW_QUANTITY_STATE, i) } };
    char text[64];
    snprintf(text, sizeof text, "(x - z)/%.17g", lag);
    lw_status s = parse_generated(text, word, COUNT(word), &z->rate, NULL);
    if (!isnan(start))
        lw_expression_free(x);
    return s == LW_OK ? lw_variable(LW_QUANTITY_STATE, i) : -1;
}

static int look_up_variable(void *context, const char *word, const char *name, char *why)
{
    const look *l = context;
    if (strcmp(word, "t") == 0 && !name)
        return lw_variable(LW_QUANTITY_T, 0);
    if (l->scope == LW_OF_STATE) {
        int at = look_up_named(l, word, name, why);
        if (at < 0 && !why[0] && strcmp(word, "output") == 0)
            snprintf(why, LW_WHY_SIZE, "there is no controller \"%.40s\" before this one", name ? name : "");
        return at >= 0 || why[0] ? at : l->r->variable(l->r->model, l->json, word, name, why);
    }
    const char *first = l->scope == LW_OF_LENGTH ? "length" : "displacement";
    if (l->scope != LW_OF_TIME && !name && strcmp(word, first) == 0)
        return lw_variable(LW_QUANTITY_LENGTH, 0);
    if (l->scope != LW_OF_TIME && !name && strcmp(word, "rate") == 0)
        return lw_variable(LW_QUANTITY_RATE, 0);
    if (l->scope == LW_OF_TIME)
        snprintf(why, LW_WHY_SIZE, "the motion of an input depends on t alone, not on \"%.40s\"", word);
    else
        snprintf(why, LW_WHY_SIZE, "the law of a spring depends on %s, rate and t alone, not on \"%.40s\"", first, word);
    return -1;
}

/* Numbers are expressions too. */
static lw_status read_expression(const lw_json_node *n, const lw_reading *r, lw_expression_scope scope, lw_expression **out, lw_error *e)
{
    lw_error inner = { 0 };
    look l = { r, scope, n->json };
    lw_expression_words words = { &l, look_up_variable, insert_signal, scope == LW_OF_STATE ? integrate : NULL,
                                  r->profile ? find_profile : NULL };
    char digits[LW_NUMBER_SIZE];
    double value;
    const char *text = lw_json_text(n);
    if (lw_json_kind_of(n) == LW_JSON_NUMBER) {
        lw_json_number(n, &value, e);
        lw_number_print(value, digits);
        text = digits;
    }
    if (!text)
        return lw_json_fault(n, e, "a number or an expression \"...\" is expected here");
    lw_status s = lw_expression_parse_words(text, strlen(text), &words, out, &inner);
    if (s == LW_OK)
        return s;
    *out = NULL;
    if (s != LW_E_NOTATION)
        return lw_error_set(e, s, "%s", inner.text);
    return lw_json_fault_inside(n, inner.column > 0 ? (size_t)inner.column - 1 : 0, e, "%s", inner.text);
}

lw_status lw_read_expression(const lw_json_node *object, const char *key, const lw_reading *r, lw_expression_scope scope,
                             lw_expression **out, lw_error *e)
{
    lw_json_node n;
    return lw_json_member(object, key, &n) ? read_expression(&n, r, scope, out, e) : LW_OK;
}

lw_status lw_read_line_load(const lw_json_node *object, const char *key, const lw_reading *r, double length, lw_expression **first,
                            lw_expression **second, bool *varies, lw_error *e)
{
    lw_json_node n, part;
    lw_expression *density[2] = { NULL, NULL };
    if (!lw_json_member(object, key, &n))
        return LW_OK;
    bool both = lw_json_kind_of(&n) == LW_JSON_ARRAY;
    lw_status s = both ? lw_read_list(&n, 2, 2, e) : LW_OK;
    for (int i = 0; s == LW_OK && i < 1 + both; i++) {
        part = both ? lw_json_element(&n, (size_t)i) : n;
        s = read_expression(&part, r, LW_OF_STATE, &density[i], e);
    }
    for (int i = 0; s == LW_OK && i < 2; i++)
        s = lw_expression_mix((const double[]){ both ? length*(2 - i)/6 : length/2, length*(1 + i)/6 }, density, i ? second : first, e);
    if (s == LW_E_NOTATION && e->line == 0)
        s = lw_json_fault(&n, e, "the expressions here are too long together");
    *varies = *varies || both;
    lw_expression_free(density[0]);
    lw_expression_free(density[1]);
    return s;
}

lw_status lw_motion_replace(const char *text, const int *n_profile, lw_moves *const *profile, lw_expression **motion, bool *has_speed,
                            lw_error *e)
{
    const lw_reading r = { .n_profile = n_profile, .profile = profile };
    look l = { .r = &r, .scope = LW_OF_TIME };
    lw_expression *x;
    lw_status s = lw_expression_parse_words(text, strlen(text), &(lw_expression_words){ .context = &l, .variable = look_up_variable,
                                            .moves = find_profile }, &x, e);
    if (s != LW_OK)
        return s;
    lw_expression_free(*motion);
    *motion = x;
    *has_speed = false;
    return LW_OK;
}

lw_status lw_motion_check(const lw_expression *motion, const char *input, double from, double to, lw_error *e)
{
    static const double most = 0.1;                          /* change within rounding of a time [rad] or [m] */
    double by = 0, t = motion ? lw_expression_next_break(motion, lw_variable(LW_QUANTITY_T, 0), from, to, most, &by) : INFINITY;
    if (t == INFINITY)
        return LW_OK;
    if (by < INFINITY)
        return lw_error_set(e, LW_E_ARG, "the motion of input \"%s\" jumps by %.3g at t = %.9g s: end the run before it, or take step() "
                            "with a short duration", input, by, t);
    return lw_error_set(e, LW_E_ARG, "the motion of input \"%s\" is so fast near t = %.9g s, as near a pole, that the time has too few digits: "
                        "end the run before it", input, t);
}

double lw_motion_frequency(const lw_expression *motion, bool turns, double speed, double from, double to)
{
    enum { SAMPLES = 200 };
    double fastest = fabs(speed), up = 0, down = 0;          /* greatest accelerations in both directions */
    for (int k = 0; motion && k <= SAMPLES; k++) {
        double at[3] = { from + (to - from)*k/SAMPLES, 1, 0 }, out[3];
        lw_expression_series(motion, 2, at, out);
        if (isfinite(out[1]) && isfinite(out[2])) {
            fastest = fmax(fastest, fabs(out[1]));
            up = fmax(up, 2*out[2]);
            down = fmax(down, -2*out[2]);
        }
    }
    bool to_and_fro = fastest > 0 && fmin(up, down) > 0.1*fmax(up, down);
    return fmax(turns ? fastest : 0, to_and_fro ? fmax(up, down)/fastest : 0);
}

/* ---- names ------------------------------------------------------------------------------------------------ */

static lw_status name_state(const lw_json_node *object, lw_states *z, const char *name, const char *what, const char *unit,
                            double scale, lw_error *e)
{
    char all[sizeof z->state->name];
    snprintf(all, sizeof all, what ? "%s.%s" : "%s", name, what);
    if (find_state(z, all, NULL) >= 0)
        return lw_json_fault(object, e, "there are two states with the name \"%s\"", all);
    return add_state(z, all, unit, scale) < 0 ? lw_error_set(e, LW_E_MEMORY, "out of memory") : LW_OK;
}

static bool is_electrical(const lw_json_node *object)
{
    lw_json_node n;
    return lw_json_kind_of(object) == LW_JSON_OBJECT
        && (lw_json_member(object, "resistance", &n) || lw_json_member(object, "voltage", &n));
}

static lw_status name_list(const lw_json_node *root, const char *key, lw_states *z, lw_error *e)
{
    lw_json_node all;
    char what[16], name[LW_NAME_SIZE];
    snprintf(what, sizeof what, "%.*s", (int)strlen(key) - 1, key);
    if (!lw_json_member(root, key, &all))
        return LW_OK;
    lw_status s = lw_read_list(&all, 0, SIZE_MAX, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&all); i++) {
        lw_json_node object = lw_json_element(&all, i);
        s = lw_json_expect(&object, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_read_own_name(&object, what, i, name, e);
        if (s != LW_OK)
            return s;
        if (key[0] == 's')
            s = name_state(&object, z, name, NULL, "1", 1, e);
        if (key[0] == 'c' && (s = name_state(&object, z, name, "p1", "Pa", 1e5, e)) == LW_OK)
            s = name_state(&object, z, name, "p2", "Pa", 1e5, e);
        if (key[0] == 'm' && is_electrical(&object) && (s = name_state(&object, z, name, "current", "A", 1, e)) == LW_OK &&
            (s = name_state(&object, z, name, "electrical", "J", 1, e)) == LW_OK)
            s = name_state(&object, z, name, "heat", "J", 1, e);
    }
    return s;
}

lw_status lw_states_name(const lw_json_node *root, lw_states *z, lw_error *e)
{
    static const char *const lists[][3] = {
        { "springs", "dampers", "cylinders" }, { "forces" }, { "motors" }, { "controllers" }, { "contacts", "ropes" }, { "couplings" }
    };
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < COUNT(lists); i++)
        s = lw_read_names_differ(root, lists[i], lists[i][1] ? lists[i][2] ? 3 : 2 : 1, e);
    if (s == LW_OK)
        s = name_list(root, "states", z, e);
    if (s == LW_OK)
        s = name_list(root, "motors", z, e);
    return s == LW_OK ? name_list(root, "cylinders", z, e) : s;
}

/* ---- states ------------------------------------------------------------------------------------------------ */

static lw_status read_state(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    static const char *const known[] = { "name", "rate", "start", "scale" };
    char name[LW_NAME_SIZE];
    lw_json_node n;
    double scale = 1;
    const lw_number_key numbers[] = { { "scale", 1, LW_POSITIVE, &scale, NULL } };
    lw_expression *rate = NULL, *start = NULL;
    lw_status s = lw_json_known_keys(object, known, COUNT(known), e);
    if (s == LW_OK && (s = lw_read_need(object, "rate", &n, e)) == LW_OK &&
        (s = lw_read_own_name(object, "state", index, name, e)) == LW_OK &&
        (s = lw_read_numbers(object, numbers, COUNT(numbers), e)) == LW_OK &&
        (s = lw_read_expression(object, "rate", r, LW_OF_STATE, &rate, e)) == LW_OK)
        s = lw_read_expression(object, "start", r, LW_OF_STATE, &start, e);
    if (s != LW_OK) {
        lw_expression_free(rate);
        return s;
    }
    lw_state *z = &r->states->state[find_state(r->states, name, NULL)];
    z->rate = rate;
    z->start_at = start;
    z->scale = scale;
    return LW_OK;
}

/* ---- controllers -------------------------------------------------------------------------------------------- */

typedef struct controller {
    double proportional, integral, derivative, filter, least, greatest, unwind;
    bool   has_least, has_greatest;
    lw_expression *wanted, *measured, *feed;     /* feed NULL: none */
    int    sum, slow;                            /* states: the integral, the filtered measure; -1: none */
} controller;

static lw_status read_controller_numbers(const lw_json_node *object, controller *c, lw_error *e)
{
    static const char *const known[] = { "name", "wanted", "measured", "proportional", "integral", "derivative",
                                         "filter", "feed_forward", "least", "greatest", "unwind" };
    *c = (controller){ .least = -INFINITY, .greatest = INFINITY, .sum = -1, .slow = -1 };
    const lw_number_key numbers[] = {
        { "proportional", 1, LW_ANY, &c->proportional, NULL }, { "integral", 1, LW_ANY, &c->integral, NULL },
        { "derivative", 1, LW_ANY, &c->derivative, NULL }, { "filter", 1, LW_POSITIVE, &c->filter, NULL },
        { "least", 1, LW_ANY, &c->least, &c->has_least }, { "greatest", 1, LW_ANY, &c->greatest, &c->has_greatest },
        { "unwind", 1, LW_POSITIVE, &c->unwind, NULL },
    };
    lw_json_node n;
    lw_status s = lw_json_known_keys(object, known, COUNT(known), e);
    if (s == LW_OK && (s = lw_read_need(object, "wanted", &n, e)) == LW_OK && (s = lw_read_need(object, "measured", &n, e)) == LW_OK)
        s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    if (s != LW_OK)
        return s;
    if (c->has_least && c->has_greatest && !(c->least < c->greatest))
        return lw_json_fault(object, e, "\"least\" must be less than \"greatest\"");
    if (c->derivative != 0 && !(c->filter > 0))
        return lw_json_fault(object, e, "\"derivative\" needs a \"filter\": the time of its lag [s]");
    if (c->integral != 0 && (c->has_least || c->has_greatest) && c->unwind == 0 && !(c->proportional/c->integral > 0))
        return lw_json_fault(object, e, "limits with \"integral\" alone need \"unwind\": the time [s] in which the integral "
                             "follows the limited output");
    c->unwind = c->unwind > 0 ? c->unwind : c->proportional/c->integral;
    return LW_OK;
}

static lw_status name_controller_states(const lw_json_node *object, lw_states *states, const char *name, controller *c, lw_error *e)
{
    lw_status s = LW_OK;
    if (c->integral != 0 && (s = name_state(object, states, name, "integral", "1", 1, e)) == LW_OK)
        c->sum = states->n_state - 1;
    if (s == LW_OK && c->derivative != 0 && (s = name_state(object, states, name, "filtered", "1", 1, e)) == LW_OK)
        c->slow = states->n_state - 1;
    return s;
}

/* The output without limits (*all) and within them, and the rates of the states. */
static lw_status generate_controller(const lw_json_node *object, const controller *c, lw_state *state, lw_expression **all,
                                     lw_expression **limited, lw_error *e)
{
    lw_generated word[] = {
        { "w", c->wanted, 0 }, { "y", c->measured, 0 }, { "sum", NULL, c->sum < 0 ? 0 : variable_of_state(c->sum) },
        { "slow", NULL, c->slow < 0 ? 0 : variable_of_state(c->slow) }, { "feed", c->feed, 0 }, { "u", NULL, 0 }, { "all", NULL, 0 },
    };
    char text[400];
    int used = snprintf(text, sizeof text, "%.17g*(w - y)", c->proportional);
    if (c->sum >= 0)
        used += snprintf(text + used, sizeof text - (size_t)used, " + sum");
    if (c->slow >= 0)
        used += snprintf(text + used, sizeof text - (size_t)used, " - %.17g*(y - slow)/%.17g", c->derivative, c->filter);
    if (c->feed)
        snprintf(text + used, sizeof text - (size_t)used, " + feed");
    lw_status s = generate(object, word, COUNT(word), all, e, text);
    word[6].expression = *all;
    used = snprintf(text, sizeof text, "%s%sall", c->has_greatest ? "min(" : "", c->has_least ? "max(" : "");
    if (c->has_least)
        used += snprintf(text + used, sizeof text - (size_t)used, ", %.17g)", c->least);
    if (c->has_greatest)
        snprintf(text + used, sizeof text - (size_t)used, ", %.17g)", c->greatest);
    if (s == LW_OK)
        s = generate(object, word, COUNT(word), limited, e, text);
    word[5].expression = *limited;
    used = snprintf(text, sizeof text, "%.17g*(w - y)", c->integral);
    if (c->has_least || c->has_greatest)
        snprintf(text + used, sizeof text - (size_t)used, " + (u - all)/%.17g", c->unwind);
    if (s == LW_OK && c->sum >= 0)
        s = generate(object, word, COUNT(word), &state[c->sum].rate, e, text);
    snprintf(text, sizeof text, "(y - slow)/%.17g", c->filter);
    if (s == LW_OK && c->slow >= 0)
        s = generate(object, word, COUNT(word), &state[c->slow].rate, e, text);
    if (s == LW_OK && c->slow >= 0)
        s = generate(object, word, COUNT(word), &state[c->slow].start_at, e, "y");
    return s;
}

/* u = limit(p e + I - d y' + feed), e = wanted - measured, I' = i e + (u - unlimited u)/unwind; y' is that of measured
 * behind a lag of time "filter". */
lw_status lw_states_read_controller(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    controller c;
    char name[LW_NAME_SIZE];
    lw_expression *all = NULL, *limited = NULL;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_read_own_name(object, "controller", index, name, e)) == LW_OK)
        s = read_controller_numbers(object, &c, e);
    if (s != LW_OK)
        return s;
    for (int k = 0; k < r->states->n_signal; k++)
        if (strncmp(r->states->signal[k].name, name, strlen(name)) == 0 && strcmp(r->states->signal[k].name + strlen(name), ".output") == 0)
            return lw_json_fault(object, e, "there are two controllers with the name \"%s\"", name);
    if ((s = lw_read_expression(object, "wanted", r, LW_OF_STATE, &c.wanted, e)) == LW_OK &&
        (s = lw_read_expression(object, "measured", r, LW_OF_STATE, &c.measured, e)) == LW_OK)
        s = lw_read_expression(object, "feed_forward", r, LW_OF_STATE, &c.feed, e);
    if (s == LW_OK && (s = name_controller_states(object, r->states, name, &c, e)) == LW_OK)
        s = generate_controller(object, &c, r->states->state, &all, &limited, e);
    if (s == LW_OK) {
        s = add_signal(r->states, name, "output", "1", limited, e);
        limited = NULL;
    }
    lw_expression_free(c.wanted);
    lw_expression_free(c.measured);
    lw_expression_free(c.feed);
    lw_expression_free(all);
    lw_expression_free(limited);
    return s;
}

/* ---- motors ------------------------------------------------------------------------------------------------- */

bool lw_is_driven_motor(const lw_json_node *object)
{
    lw_json_node n;
    return is_electrical(object) || (lw_json_kind_of(object) == LW_JSON_OBJECT && lw_json_member(object, "torque", &n));
}

/* The stator is on the ground at a joint to ground, else on the joint's first link.  A rotor turns ratio times as far as the joint on the link of
 * its stator: with the moving link or, between moving links, with the second one where the ratio is 1 and as a link of its own where it is not. */
static lw_status add_rotor(const lw_json_node *object, const char *name, lw_states *z, const lw_motor_joint *j, double inertia, double ratio, lw_error *e)
{
    int link = j->link[0] == j->ground ? j->link[1] : j->link[1] == j->ground ? j->link[0] : -1;
    lw_rotor *r = &z->rotor[z->n_rotor++];
    if (link < 0 && j->turns && ratio == 1)
        link = j->link[1];
    *r = (lw_rotor){ j->joint, link, link < 0 ? inertia : inertia*ratio*ratio, link < 0 ? ratio : 0, "" };
    if (link < 0 && strlen(name) + strlen(LW_ROTOR_LINK) >= sizeof r->name)
        return lw_json_fault(object, e, "the rotor of this motor is a link \"NAME" LW_ROTOR_LINK "\": give it a name of at most %d bytes",
                             (int)(sizeof r->name - sizeof LW_ROTOR_LINK));
    if (link < 0)
        snprintf(r->name, sizeof r->name, "%s", name);
    return LW_OK;
}

/* L i' = u - R i - K w,  torque K i,  w = ratio v: the electrical power u i and the heat R i^2 are summed. */
static lw_status read_circuit(const lw_json_node *object, const char *name, const lw_motor_joint *j, const lw_reading *r, lw_error *e)
{
    double resistance = 0, inductance = 0, constant = 0, inertia = 0, ratio = 1, start = 0;
    const lw_number_key numbers[] = {
        { "resistance", 1, 0, INFINITY, &resistance, NULL }, { "inductance", 1, 0, INFINITY, &inductance, NULL },
        { "torque_constant", 1, LW_ANY, &constant, NULL }, { "inertia", 1, 0, INFINITY, &inertia, NULL },
        { "ratio", 1, LW_ANY, &ratio, NULL }, { "current", 1, LW_ANY, &start, NULL },
    };
    static const char *const needed[] = { "voltage", "resistance", "inductance", "torque_constant" };
    lw_json_node n;
    lw_expression *voltage = NULL;
    char text[256];
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < COUNT(needed); i++)
        s = lw_read_need(object, needed[i], &n, e);
    if (s == LW_OK && (s = lw_read_numbers(object, numbers, COUNT(numbers), e)) == LW_OK && !(inductance > 0))
        s = lw_json_fault(&n, e, "a motor with a voltage needs an \"inductance\" above 0 [H]");
    if (s == LW_OK && ratio == 0)
        s = lw_json_fault(object, e, "\"ratio\" of a motor is its speed over that of the joint, and not 0");
    if (s == LW_OK && inertia > 0)
        s = add_rotor(object, name, r->states, j, inertia, ratio, e);
    if (s == LW_OK)
        s = lw_read_expression(object, "voltage", r, LW_OF_STATE, &voltage, e);
    if (s != LW_OK)
        return s;
    int current = find_state(r->states, name, "current");
    const lw_generated word[] = { { "u", voltage, 0 }, { "i", NULL, variable_of_state(current) },
                                  { "v", NULL, j->rate } };
    r->states->state[current].start = start;
    snprintf(text, sizeof text, "(u - %.17g*i - %.17g*v)/%.17g", resistance, constant*ratio, inductance);
    s = generate(object, word, COUNT(word), &r->states->state[current].rate, e, text);
    if (s == LW_OK)
        s = generate(object, word, COUNT(word), &r->states->state[current + 1].rate, e, "u*i");
    snprintf(text, sizeof text, "%.17g*i^2", resistance);
    if (s == LW_OK)
        s = generate(object, word, COUNT(word), &r->states->state[current + 2].rate, e, text);
    snprintf(text, sizeof text, "%.17g*i", constant*ratio);
    if (s == LW_OK)
        s = generate(object, word, COUNT(word), j->law, e, text);
    return s == LW_OK ? add_signal(r->states, name, "voltage", "V", voltage, e) : (lw_expression_free(voltage), s);
}

/* The wanted torque within +-stall (1 -+ v/free_speed). */
static lw_status read_curve(const lw_json_node *object, const lw_motor_joint *j, const lw_reading *r, lw_error *e)
{
    double stall = 0, free_speed = 0;
    const lw_number_key numbers[] = { { "stall", 1, LW_POSITIVE, &stall, NULL },
                                      { "free_speed", 1, LW_POSITIVE, &free_speed, NULL } };
    lw_json_node n;
    lw_expression *torque = NULL;
    char text[256];
    lw_status s = lw_read_need(object, "stall", &n, e);
    if (s == LW_OK && (s = lw_read_need(object, "free_speed", &n, e)) == LW_OK &&
        (s = lw_read_numbers(object, numbers, COUNT(numbers), e)) == LW_OK)
        s = lw_read_expression(object, "torque", r, LW_OF_STATE, &torque, e);
    if (s != LW_OK)
        return s;
    const lw_generated word[] = { { "u", torque, 0 }, { "v", NULL, lw_variable(LW_QUANTITY_RATE, 0) } };
    snprintf(text, sizeof text, "min(max(u, -%.17g*(1 + v/%.17g)), %.17g*(1 - v/%.17g))", stall, free_speed, stall, free_speed);
    s = generate(object, word, COUNT(word), j->law, e, text);
    lw_expression_free(torque);
    return s;
}

lw_status lw_states_read_motor(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    static const char *const circuit[] = { "name", "joint", "voltage", "resistance", "inductance", "torque_constant",
                                           "inertia", "ratio", "current" };
    static const char *const curve[] = { "name", "joint", "torque", "stall", "free_speed" };
    char name[LW_NAME_SIZE];
    lw_motor_joint joint;
    bool electrical = is_electrical(object);
    lw_status s = lw_json_known_keys(object, electrical ? circuit : curve, electrical ? COUNT(circuit) : COUNT(curve), e);
    if (s == LW_OK && (s = lw_read_own_name(object, "motor", index, name, e)) == LW_OK)
        s = r->motor_place(object, r->model, &joint.joint, e);
    if (s != LW_OK)
        return s;
    r->motor_spring(joint.joint, name, r->model, &joint);
    return electrical ? read_circuit(object, name, &joint, r, e) : read_curve(object, &joint, r, e);
}

/* ---- cylinders ----------------------------------------------------------------------------------------------- */

lw_status lw_states_read_cylinder_ends(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    lw_status s = lw_read_own_name(object, "cylinder", index, (*r->spring)[*r->n_spring].name, e);
    return s == LW_OK ? lw_read_ends(object, r, e) : s;
}

/* Lengths [m], pressures [Pa], flows [m^3/s]; [0]: the chamber at the blank end of the bore, [1]: that around the rod. */
typedef struct cylinder {
    double bore, rod, retracted, stroke, dead, bulk, flow, drop, supply, tank, leakage, relief, relief_flow, friction, slow, damping, stop,
           stop_damping;
    double start[2];                             /* pressures */
    bool   has_relief, has_flow, has_supply;
} cylinder;

static lw_status read_cylinder_pressures(const lw_json_node *object, double start[2], lw_error *e)
{
    lw_json_node n;
    if (!lw_json_member(object, "pressures", &n))
        return LW_OK;
    lw_status s = lw_read_list(&n, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node one = lw_json_element(&n, end);
        s = lw_json_number(&one, &start[end], e);
        if (s == LW_OK && start[end] < 0)
            s = lw_json_fault(&one, e, "a pressure must not be negative");
    }
    return s;
}

static lw_status read_cylinder_numbers(const lw_json_node *object, double metre, cylinder *c, lw_error *e)
{
    static const char *const known[] = { "name", "links", "at", "bore", "rod", "retracted", "stroke", "dead_volume",
                                         "bulk_modulus", "pressures", "valve", "flow", "drop", "supply", "tank",
                                         "leakage", "relief", "relief_flow", "friction", "friction_speed", "damping",
                                         "stop_stiffness", "stop_damping" };
    static const char *const needed[] = { "bore", "retracted", "stroke", "dead_volume" };
    *c = (cylinder){ .bulk = 1.4e9, .drop = 3.5e6, .relief = INFINITY, .slow = 1e-3, .stop = 1e8 };
    const lw_number_key numbers[] = {
        { "bore", metre, LW_POSITIVE, &c->bore, NULL }, { "rod", metre, 0, INFINITY, &c->rod, NULL },
        { "retracted", metre, 0, INFINITY, &c->retracted, NULL }, { "stroke", metre, LW_POSITIVE, &c->stroke, NULL },
        { "dead_volume", 1, LW_POSITIVE, &c->dead, NULL }, { "bulk_modulus", 1, LW_POSITIVE, &c->bulk, NULL },
        { "flow", 1, LW_POSITIVE, &c->flow, &c->has_flow }, { "drop", 1, LW_POSITIVE, &c->drop, NULL },
        { "supply", 1, 0, INFINITY, &c->supply, &c->has_supply }, { "tank", 1, 0, INFINITY, &c->tank, NULL },
        { "leakage", 1, 0, INFINITY, &c->leakage, NULL }, { "relief", 1, 0, INFINITY, &c->relief, &c->has_relief },
        { "relief_flow", 1, LW_POSITIVE, &c->relief_flow, NULL }, { "friction", 1, 0, INFINITY, &c->friction, NULL },
        { "friction_speed", 1, LW_POSITIVE, &c->slow, NULL }, { "damping", 1, 0, INFINITY, &c->damping, NULL },
        { "stop_stiffness", 1, LW_POSITIVE, &c->stop, NULL }, { "stop_damping", 1, 0, INFINITY, &c->stop_damping, NULL },
    };
    lw_json_node n;
    lw_status s = lw_json_known_keys(object, known, COUNT(known), e);
    for (int i = 0; s == LW_OK && i < COUNT(needed); i++)
        s = lw_read_need(object, needed[i], &n, e);
    if (s == LW_OK && (s = lw_read_numbers(object, numbers, COUNT(numbers), e)) == LW_OK)
        s = read_cylinder_pressures(object, c->start, e);
    if (s != LW_OK)
        return s;
    if (lw_json_member(object, "valve", &n) && !(c->has_flow && c->has_supply))
        return lw_json_fault(&n, e, "a valve needs its \"flow\" [m^3/s] at the pressure \"drop\", and the \"supply\" pressure");
    if (!(c->rod < c->bore))
        return lw_json_fault(object, e, "\"rod\" must be less than \"bore\"");
    if (c->has_relief && !(c->relief_flow > 0))
        return lw_json_fault(object, e, "\"relief\" needs a \"relief_flow\": flow over the pressure above it [m^3/s per Pa]");
    return LW_OK;
}

/* The opening of the valve, which opens no wider than fully; NULL: none. */
static lw_status read_valve(const lw_json_node *object, const lw_reading *r, lw_expression **valve, lw_error *e)
{
    lw_expression *opening = NULL;
    lw_status s = lw_read_expression(object, "valve", r, LW_OF_STATE, &opening, e);
    const lw_generated word[] = { { "u", opening, 0 } };
    *valve = NULL;
    if (s == LW_OK && opening)
        s = generate(object, word, COUNT(word), valve, e, "min(max(u, -1), 1)");
    lw_expression_free(opening);
    return s;
}

/* Oil that flows into the chamber `end`, whose pressure is the state `own`, over leaks, the relief and the valve (NULL: none). */
static lw_status cylinder_flow(const lw_json_node *object, const cylinder *c, int end, int own, int other, lw_expression *valve,
                               lw_expression **flow, lw_error *e)
{
    const lw_generated word[] = { { "u", valve, 0 }, { "p", NULL, variable_of_state(own) }, { "other", NULL, variable_of_state(other) } };
    double least_opening = c->drop/1e4*c->drop/1e4;
    char text[1024];
    int used = snprintf(text, sizeof text, "%.17g*(other - p)", c->leakage);
    if (c->has_relief)
        used += snprintf(text + used, sizeof text - (size_t)used, " - %.17g*max(p - %.17g, 0)", c->relief_flow, c->relief);
    if (valve)
        snprintf(text + used, sizeof text - (size_t)used, " + %.17g*(max(%su, 0)*(%.17g - p)/((%.17g - p)^2 + %.17g)^0.25"
                 " - max(%su, 0)*(p - %.17g)/((p - %.17g)^2 + %.17g)^0.25)", c->flow/sqrt(c->drop), end ? "-" : "", c->supply,
                 c->supply, least_opening, end ? "" : "-", c->tank, c->tank, least_opening);
    return generate(object, word, COUNT(word), flow, e, text);
}

static double cylinder_area(const cylinder *c, int end)
{
    return end ? LW_PI/4*(c->bore*c->bore - c->rod*c->rod) : LW_PI/4*c->bore*c->bore;
}

/* The rate of the pressure at `end`, from the oil that flows there and the motion of the piston. */
static lw_status cylinder_pressure(const lw_json_node *object, const cylinder *c, int end, lw_expression *flow, int spring,
                                   lw_expression **rate, lw_error *e)
{
    const lw_generated word[] = { { "q", flow, 0 }, { "l", NULL, lw_variable(LW_QUANTITY_SPRING_LENGTH, spring) },
                                  { "v", NULL, lw_variable(LW_QUANTITY_SPRING_RATE, spring) } };
    double area = cylinder_area(c, end)*(end ? -1 : 1), zero = end ? c->retracted + c->stroke : c->retracted;
    char text[400];
    snprintf(text, sizeof text, "%.17g*(q - %.17g*v)/(%.17g + %.17g*(l - %.17g))", c->bulk, area, c->dead, area, zero);
    return generate(object, word, COUNT(word), rate, e, text);
}

/* The pull of the cylinder over its length and its rate. */
static lw_status cylinder_law(const lw_json_node *object, const cylinder *c, int p, lw_expression **law, lw_error *e)
{
    const lw_generated word[] = { { "p1", NULL, variable_of_state(p) }, { "p2", NULL, variable_of_state(p + 1) },
                                  { "l", NULL, lw_variable(LW_QUANTITY_LENGTH, 0) }, { "v", NULL, lw_variable(LW_QUANTITY_RATE, 0) } };
    double extended = c->retracted + c->stroke;
    char text[1024];
    int used = snprintf(text, sizeof text, "%.17g*p2 - %.17g*p1 + %.17g*v", cylinder_area(c, 1), cylinder_area(c, 0), c->damping);
    if (c->friction > 0)
        used += snprintf(text + used, sizeof text - (size_t)used, " + %.17g*tanh(v/%.17g)", c->friction, c->slow);
    used += snprintf(text + used, sizeof text - (size_t)used, " + %.17g*(max(l - %.17g, 0) - max(%.17g - l, 0))", c->stop, extended,
                     c->retracted);
    if (c->stop_damping > 0)
        snprintf(text + used, sizeof text - (size_t)used, " + %.17g*v*(1 - sign(l - %.17g)*sign(%.17g - l))/2", c->stop_damping,
                 c->retracted, extended);
    return generate(object, word, COUNT(word), law, e, text);
}

/* With x = length - retracted, areas A and volumes V0 at the ends of the stroke s:
 *     p1' = K (Q1 - A1 x')/(V0 + A1 x),   p2' = K (Q2 + A2 x')/(V0 + A2 (s - x)),   push  p1 A1 - p2 A2 - friction.
 * An edge of the valve that is open by u passes u flow sqrt(dp/drop); near dp = 0, where the root has no slope, it is
 * replaced by dp/(dp^2 + (drop/1e4)^2)^(1/4).  Beyond the stroke a spring and a damper hold. */
static lw_status read_cylinder(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    cylinder c;
    char name[LW_NAME_SIZE];
    lw_expression *valve = NULL, *flow[2] = { NULL, NULL };
    lw_status s = lw_read_own_name(object, "cylinder", index, name, e);
    if (s == LW_OK && (s = read_cylinder_numbers(object, r->units->metre, &c, e)) == LW_OK)
        s = read_valve(object, r, &valve, e);
    if (s != LW_OK)
        return s;
    int spring = lw_read_find_spring(r, object->json, name, NULL), p = find_state(r->states, name, "p1");
    lw_spring *jack = &(*r->spring)[spring];
    double length = lw_read_drawn_length(r, jack), *extent = jack->extent;
    extent[0] = c.retracted, extent[1] = c.retracted + c.stroke;
    if (length < extent[0] || length > extent[1])
        s = lw_json_fault(object, e, "the cylinder is %.6g m long in the posture, which is not within %.6g .. %.6g m", length,
                          extent[0], extent[1]);
    for (int end = 0; s == LW_OK && end < 2; end++) {
        r->states->state[p + end].start = c.start[end];
        s = cylinder_flow(object, &c, end, p + end, p + !end, valve, &flow[end], e);
        if (s == LW_OK)
            s = cylinder_pressure(object, &c, end, flow[end], spring, &r->states->state[p + end].rate, e);
    }
    if (s == LW_OK)
        s = cylinder_law(object, &c, p, &jack->law, e);
    lw_expression_free(flow[0]);
    lw_expression_free(flow[1]);
    if (valve && s == LW_OK)
        return add_signal(r->states, name, "valve", "1", valve, e);
    lw_expression_free(valve);
    return s;
}

/* ---- lists --------------------------------------------------------------------------------------------------- */

size_t lw_read_count(const lw_json_node *root, const char *key)
{
    lw_json_node all;
    return lw_json_member(root, key, &all) && lw_json_kind_of(&all) == LW_JSON_ARRAY ? lw_json_count(&all) : 0;
}

lw_status lw_read_each(const lw_json_node *root, const char *key, lw_read_one *read, const lw_reading *r, lw_error *e)
{
    lw_json_node all;
    if (!lw_json_member(root, key, &all))
        return LW_OK;
    lw_status s = lw_read_list(&all, 0, SIZE_MAX, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&all); i++) {
        lw_json_node one = lw_json_element(&all, i);
        s = read(&one, i, r, e);
    }
    return s;
}

lw_status lw_states_read(const lw_json_node *root, const lw_reading *r, lw_error *e)
{
    lw_status s = lw_read_each(root, "states", read_state, r, e);
    if (s == LW_OK)
        s = lw_read_each(root, "cylinders", read_cylinder, r, e);
    for (int i = 0; i < 2; i++)
        lw_key_table_free(&r->states->named[i]);
    return s;
}
