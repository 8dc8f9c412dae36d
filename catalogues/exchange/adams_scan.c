/* catalogues/exchange/adams_scan.c - a dataset of ADAMS/Solver as a list of statements. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"
#include "base/vec2.h"
#include "catalogues/exchange/adams.h"
#include "grammar/text_internal.h"

/* ---- lines ------------------------------------------------------------------------------------------- */

static void skip_line(lw_cursor *c)
{
    while (lw_cursor_peek(c) >= 0 && lw_cursor_next(c) != '\n')
        ;
}

/* 'name' behind adams_view_name= in a comment, as far as it fits. */
static void take_name(const lw_cursor *at, char *name)
{
    static const char key[] = "adams_view_name='";
    size_t n = 0, end = at->at;
    while (end < at->size && at->text[end] != '\n')
        end++;
    const char *found = memmem(at->text + at->at, end - at->at, key, sizeof key - 1);
    if (!found)
        return;
    for (const char *c = found + sizeof key - 1; c < at->text + end && *c != '\'' && n + 1 < LW_NAME_SIZE; c++)
        name[n++] = *c;
    name[n] = 0;
}

/* On to what belongs to the statement: over blanks, comments, and line ends that a comma follows.  False at
 * its end. */
static bool goes_on(lw_cursor *c)
{
    for (;;) {
        lw_cursor_skip(c, false, 0);
        int byte = lw_cursor_peek(c);
        if (byte == '\r') {
            lw_cursor_next(c);
            continue;
        }
        if (byte != '\n' && byte != '!')
            return byte >= 0;
        lw_cursor ahead = *c;
        for (;;) {                                     /* lines without anything, and comments */
            lw_cursor_skip(&ahead, true, '!');
            if (lw_cursor_peek(&ahead) != '!')
                break;
            skip_line(&ahead);
        }
        if (lw_cursor_peek(&ahead) != ',')
            return false;
        *c = ahead;
    }
}

/* ---- pieces ------------------------------------------------------------------------------------------- */

static bool is_letter(int byte) { return byte == '_' || (byte < 128 && byte > 0 && isalpha(byte)); }

static lw_status take_word(lw_cursor *c, char *word, size_t size, const char *what)
{
    lw_cursor start = *c;
    size_t n = 0;
    char name[24];
    for (int byte = lw_cursor_peek(c); is_letter(byte) || (n > 0 && byte >= '0' && byte <= '9');
         byte = lw_cursor_peek(c)) {
        if (n + 1 == size)
            return lw_cursor_fail(&start, "this word is too long for %s", what);
        word[n++] = (char)toupper(lw_cursor_next(c));
    }
    word[n] = 0;
    return n > 0 ? LW_OK : lw_cursor_fail(&start, "%s is expected, not %s", what,
                                          lw_byte_name(lw_cursor_peek(&start), name));
}

/* A number; a D behind it says degrees. */
static lw_status take_number(lw_cursor *c, double *v)
{
    lw_cursor start = *c;
    size_t n = 0;
    for (int byte = lw_cursor_peek(c);; byte = lw_cursor_peek(c), n++) {
        bool exponent = n > 0 && (c->text[c->at - 1] == 'e' || c->text[c->at - 1] == 'E');
        if (!((byte >= '0' && byte <= '9') || byte == '.' || byte == 'e' || byte == 'E'
              || ((byte == '+' || byte == '-') && (n == 0 || exponent))))
            break;
        lw_cursor_next(c);
    }
    if (lw_number_parse(start.text + start.at, n, v) != LW_OK || !(fabs(*v) <= LW_COORDINATE_MAX))
        return lw_cursor_fail(&start, "a number is expected here");
    if (lw_cursor_peek(c) == 'D' || lw_cursor_peek(c) == 'd') {
        lw_cursor_next(c);
        *v *= LW_PI/180;
    }
    return LW_OK;
}

static bool begins_number(int byte)
{
    return (byte >= '0' && byte <= '9') || byte == '-' || byte == '+' || byte == '.';
}

/* The rest of the statement, as it is. */
static lw_status take_expression(lw_cursor *c, lw_adams_argument *a)
{
    lw_cursor start = *c;
    size_t n = 0;
    while (goes_on(c)) {
        if (n + 1 == sizeof a->text)
            return lw_cursor_fail(&start, "the expression is longer than %zu characters", sizeof a->text - 1);
        a->text[n++] = (char)lw_cursor_next(c);
    }
    while (n > 0 && a->text[n - 1] == ' ')
        n--;
    a->text[n] = 0;
    return LW_OK;
}

/* Numbers apart by commas, as long as numbers follow. */
static lw_status take_values(lw_cursor *c, lw_adams_argument *a)
{
    for (;;) {
        if (a->n == LW_ADAMS_VALUE_MAX)
            return lw_cursor_fail(c, "%s has more than %d values", a->key, LW_ADAMS_VALUE_MAX);
        lw_status s = take_number(c, &a->value[a->n++]);
        lw_cursor ahead = *c;
        if (s != LW_OK || !goes_on(&ahead) || lw_cursor_peek(&ahead) != ',')
            return s;
        lw_cursor_next(&ahead);
        lw_cursor_skip(&ahead, false, 0);
        if (!begins_number(lw_cursor_peek(&ahead)))
            return LW_OK;
        *c = ahead;
    }
}

static lw_status take_argument(lw_cursor *c, lw_adams_argument *a)
{
    *a = (lw_adams_argument){ .n = 0 };
    lw_status s = take_word(c, a->key, sizeof a->key, "an argument");
    if (s != LW_OK || !goes_on(c) || lw_cursor_peek(c) != '=')
        return s;
    lw_cursor_next(c);
    goes_on(c);
    if (strcmp(a->key, "FUNCTION") == 0)
        return take_expression(c, a);
    return begins_number(lw_cursor_peek(c)) ? take_values(c, a) : take_word(c, a->text, sizeof a->text, "a value");
}

/* ---- statements ---------------------------------------------------------------------------------------- */

static lw_status take_arguments(lw_cursor *c, lw_adams_statement *st)
{
    lw_status s = LW_OK;
    char name[24];
    bool first = true;
    while (s == LW_OK && goes_on(c)) {
        if (lw_cursor_peek(c) == ',') {
            lw_cursor_next(c);
            first = true;
            continue;
        }
        if (!first)
            return lw_cursor_fail(c, "a comma is expected, not %s", lw_byte_name(lw_cursor_peek(c), name));
        if (st->n_argument == LW_ADAMS_ARGUMENT_MAX)
            return lw_cursor_fail(c, "a statement has at most %d arguments", LW_ADAMS_ARGUMENT_MAX);
        s = take_argument(c, &st->argument[st->n_argument++]);
        first = false;
    }
    return s;
}

static lw_status take_statement(lw_cursor *c, lw_adams_statement *st)
{
    lw_status s = take_word(c, st->keyword, sizeof st->keyword, "a statement");
    if (s != LW_OK || !goes_on(c))
        return s;
    if (lw_cursor_peek(c) != '/')
        return lw_cursor_fail(c, "'/' is expected behind %s", st->keyword);
    lw_cursor_next(c);
    lw_cursor_skip(c, false, 0);
    lw_cursor_number(c, &st->id);
    return take_arguments(c, st);
}

lw_status lw_adams_scan(const char *text, size_t size, const char *file, lw_adams_visit *visit, void *context,
                        lw_error *e)
{
    lw_error own;
    lw_cursor c = lw_cursor_start(text, size, file, e ? e : &own);
    char name[LW_NAME_SIZE] = "";
    lw_status s = LW_OK;
    skip_line(&c);
    while (s == LW_OK) {
        lw_cursor_skip(&c, true, 0);
        int byte = lw_cursor_peek(&c);
        if (byte < 0)
            return LW_OK;
        if (byte == '!') {
            take_name(&c, name);
            skip_line(&c);
            continue;
        }
        lw_adams_statement st = { .line = c.line };
        memcpy(st.name, name, sizeof name);
        name[0] = 0;
        s = take_statement(&c, &st);
        if (s == LW_OK && strcmp(st.keyword, "END") == 0)
            return LW_OK;
        if (s == LW_OK)
            s = visit(context, &st, c.e);
    }
    return s;
}

const lw_adams_argument *lw_adams_find(const lw_adams_statement *s, const char *key)
{
    for (int i = 0; i < s->n_argument; i++)
        if (strcmp(s->argument[i].key, key) == 0)
            return &s->argument[i];
    return NULL;
}
