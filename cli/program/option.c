#include "cli/program/option.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"

#define ROW(name, letter, kind, member, argument, fallback, help, least, most) \
    { name, letter, kind, offsetof(cli_common, member), argument, fallback, help, least, most, NULL, NULL }

const cli_option cli_common_options[] = {
    ROW("output", 'o', CLI_OUTPUT, output, "FILE", NULL, "write to this file, completely or not at all, instead of standard output", 0, 0),
    ROW("force",  0, CLI_FLAG, force, NULL, NULL,
        "also replace existing files that linkwright did not write; an input of the same command is never replaced", 0,
        0),
    ROW("json",   0, CLI_FLAG, json, NULL, NULL, "print JSON instead of text; -o FILE.json does the same", 0, 0),
    ROW("seed",   0, CLI_SEED, seed, "N", "1", "seed of the random numbers; the same seed gives the same answer", 0, 0),
    ROW("jobs",  'j', CLI_INT, jobs, "N", "0", "number of threads, 0 for one per core; the answer is the same for any number", 0, 1024),
    ROW("time",   0, CLI_REAL, time, "SECONDS", "0", "stop after this time and keep what was found; 0 is no limit", 0, 1e9),
    ROW("memory", 0, CLI_REAL, memory, "GB", NULL,
        "greatest memory of the program; work that would need more ends in order. Without it three quarters of the machine's", 0.01, 1e6),
    ROW("quiet", 'q', CLI_FLAG, quiet, NULL, NULL, "print no progress and no notes on standard error", 0, 0),
    ROW("help",  'h', CLI_FLAG, help, NULL, NULL, "show this text", 0, 0),
    { .name = NULL }
};

static int row_by_name(const cli_option *options, const char *name, size_t size)
{
    for (int i = 0; options && options[i].name; i++)
        if (strlen(options[i].name) == size && strncmp(options[i].name, name, size) == 0)
            return i;
    return -1;
}

static int row_by_letter(const cli_option *options, char letter)
{
    for (int i = 0; options && options[i].name; i++)
        if (options[i].letter && options[i].letter == letter)
            return i;
    return -1;
}

/* ---- values ------------------------------------------------------------------------------------ */

static bool any_range(const cli_option *r) { return r->least == 0 && r->most == 0; }

static lw_status check_range(const cli_option *r, const char *name, const char *text, double v, lw_error *e)
{
    if (any_range(r) || (v >= r->least && v <= r->most))
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "%s %s: %s is out of range; allowed is %g to %g", name, r->argument, text, r->least, r->most);
}

static lw_status real_value(const cli_option *r, const char *name, const char *text, size_t size, double *v, lw_error *e)
{
    if (lw_number_parse(text, size, v) != LW_OK)
        return lw_error_set(e, LW_E_ARG, "%s %s: '%.*s' is no number; write it as 2, -0.5 or 1e-3", name, r->argument,
                            (int)size, text);          /* the argument names the unit */
    return check_range(r, name, text, *v, e);
}

static lw_status int_value(const cli_option *r, const char *name, const char *text, size_t size, int *v, lw_error *e)
{
    double d = 0;
    if (lw_number_parse(text, size, &d) != LW_OK || d != floor(d) || fabs(d) > INT_MAX)
        return lw_error_set(e, LW_E_ARG, "%s: '%.*s' is no whole number of at most %d", name, (int)size, text, INT_MAX);
    *v = (int)d;
    return check_range(r, name, text, d, e);
}

static lw_status seed_value(const char *name, const char *text, uint64_t *v, lw_error *e)
{
    bool digits = *text && strspn(text, "0123456789") == strlen(text);
    errno = 0;
    unsigned long long n = digits ? strtoull(text, NULL, 10) : 0;
    if (!digits || errno == ERANGE)
        return lw_error_set(e, LW_E_ARG, "%s: '%s' is no seed; it is a whole number from 0 to %llu", name, text, ULLONG_MAX);
    *v = n;
    return LW_OK;
}

/* Split text at `mark` into two parts. False: no such mark. */
static bool split(const char *text, char mark, size_t size[2], const char *part[2])
{
    const char *m = strchr(text, mark);
    if (!m)
        return false;
    part[0] = text;
    part[1] = m + 1;
    size[0] = (size_t)(m - text);
    size[1] = strlen(m + 1);
    return true;
}

static lw_status range_value(const cli_option *r, const char *name, const char *text, double *v, lw_error *e)
{
    size_t size[2];
    const char *part[2];
    if (!split(text, ':', size, part))
        return lw_error_set(e, LW_E_ARG, "%s: '%s' is no range; write MIN:MAX, for example 0.5:20", name, text);
    for (int i = 0; i < 2; i++) {
        lw_status s = real_value(r, name, part[i], size[i], &v[i], e);
        if (s != LW_OK)
            return s;
    }
    if (v[0] > v[1])
        return lw_error_set(e, LW_E_ARG, "%s: the range %s is empty; the smaller number comes first", name, text);
    return LW_OK;
}

static lw_status size_value(const cli_option *r, const char *name, const char *text, int *v, lw_error *e)
{
    size_t size[2];
    const char *part[2];
    if (!split(text, 'x', size, part))
        return lw_error_set(e, LW_E_ARG, "%s: '%s' is no size; write WIDTHxHEIGHT, for example 800x600", name, text);
    for (int i = 0; i < 2; i++) {
        lw_status s = int_value(r, name, part[i], size[i], &v[i], e);
        if (s != LW_OK)
            return s;
    }
    return LW_OK;
}

static lw_status choice_value(const cli_option *r, const char *name, const char *text, int *v, lw_error *e)
{
    size_t length = strlen(text);
    const char *c = r->argument;
    for (int i = 0; c; i++) {
        size_t size = strcspn(c, "|");
        if (size == length && strncmp(c, text, size) == 0) {
            *v = i;
            return LW_OK;
        }
        c = c[size] ? c + size + 1 : NULL;
    }
    return lw_error_set(e, LW_E_ARG, "%s: '%s' is none of %s", name, text, r->argument);
}

lw_status cli_value(const cli_option *r, const char *name, const char *text, void *value, lw_error *e)
{
    switch (r->kind) {
    case CLI_FLAG:   *(bool *)value = true;          return LW_OK;
    case CLI_TEXT:
    case CLI_INPUT:
    case CLI_STORE:
    case CLI_OUTPUT:
    case CLI_PLOT:
    case CLI_GIF:    *(const char **)value = text;   return LW_OK;
    case CLI_INT:    return int_value(r, name, text, strlen(text), value, e);
    case CLI_SEED:   return seed_value(name, text, value, e);
    case CLI_REAL:   return real_value(r, name, text, strlen(text), value, e);
    case CLI_RANGE:  return range_value(r, name, text, value, e);
    case CLI_SIZE:   return size_value(r, name, text, value, e);
    case CLI_CHOICE: return choice_value(r, name, text, value, e);
    }
    return LW_E_ARG;
}

/* ---- parsing ----------------------------------------------------------------------------------- */

typedef struct parser {
    const cli_option *own;
    char             *settings;
    cli_common       *common;
    cli_parsed       *p;
    lw_error         *e;
    int               argc, at;       /* argv[at] is the next word                                 */
    char            **argv;
} parser;

/* A row that was found in one of the two tables. */
typedef struct found { const cli_option *row; void *value; uint64_t *given, bit; } found;

static found place_of(parser *q, int own, int common)
{
    if (own >= 0)
        return (found){ &q->own[own], q->settings + q->own[own].place, &q->p->given,
                        UINT64_C(1) << own };
    if (common >= 0)
        return (found){ &cli_common_options[common],
                        (char *)q->common + cli_common_options[common].place,
                        &q->p->given_common, UINT64_C(1) << common };
    return (found){ NULL, NULL, NULL, 0 };
}

static lw_status defaults(parser *q)
{
    for (int table = 0; table < 2; table++) {
        const cli_option *rows = table ? cli_common_options : q->own;
        for (int i = 0; rows && rows[i].name; i++) {
            found f = place_of(q, table ? -1 : i, table ? i : -1);
            lw_status s = rows[i].fallback
                        ? cli_value(f.row, f.row->name, rows[i].fallback, f.value, q->e) : LW_OK;
            if (s != LW_OK)
                return s;
        }
    }
    return LW_OK;
}

static lw_status unknown_option(parser *q, const char *word, size_t size)
{
    const char *names[2*CLI_OPTION_MAX];
    int n = 0;
    for (int table = 0; table < 2; table++) {
        const cli_option *rows = table ? cli_common_options : q->own;
        for (int i = 0; rows && rows[i].name; i++)
            names[n++] = rows[i].name;
    }
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)size, word);
    const char *near = lw_suggest(name, names, n);
    if (near)
        return lw_error_set(q->e, LW_E_ARG, "there is no option --%s; did you mean --%s?", name, near);
    return lw_error_set(q->e, LW_E_ARG, "there is no option --%s", name);
}

/* Report an unknown letter. A letter means the same in every command, so most options have none: list the options that
 * begin with it. */
static lw_status unknown_letter(parser *q, char letter)
{
    char names[256] = "";
    for (int table = 0; table < 2; table++) {
        const cli_option *rows = table ? cli_common_options : q->own;
        for (int i = 0; rows && rows[i].name; i++) {
            size_t n = strlen(names);
            if (rows[i].name[0] == letter)
                snprintf(names + n, sizeof names - n, "%s--%s", n ? ", " : "", rows[i].name);
        }
    }
    return lw_error_set(q->e, LW_E_ARG, "there is no option -%c%s%s", letter, names[0] ? "; by this letter begin " : "", names);
}

static bool is_number(const char *w) { return (w[1] >= '0' && w[1] <= '9') || w[1] == '.'; }

/* Take the value of an option: `value` is the text after '=' or the letter, or NULL if the value is the next word. */
static lw_status take(parser *q, found f, const char *shown, const char *value)
{
    if (*f.given & f.bit)
        return lw_error_set(q->e, LW_E_ARG, "%s is given twice; give it once", shown);
    *f.given |= f.bit;
    if (f.row->kind == CLI_FLAG) {
        if (value)
            return lw_error_set(q->e, LW_E_ARG, "%s takes no value", shown);
        return cli_value(f.row, shown, "", f.value, q->e);
    }
    if (!value) {
        const char *next = q->at < q->argc ? q->argv[q->at] : NULL;
        if (!next || (strncmp(next, "--", 2) == 0))
            return lw_error_set(q->e, LW_E_ARG, "%s needs a value: %s %s%s", shown, shown,
                                f.row->argument, next ? " (or with '=' when it begins with --)" : "");
        value = next;
        q->at++;
    }
    return cli_value(f.row, shown, value, f.value, q->e);
}

static lw_status long_option(parser *q, const char *word)
{
    size_t size = strcspn(word + 2, "=");
    const char *value = word[2 + size] ? word + 2 + size + 1 : NULL;
    found f = place_of(q, row_by_name(q->own, word + 2, size), row_by_name(cli_common_options, word + 2, size));
    if (!f.row)
        return unknown_option(q, word + 2, size);
    char shown[64];
    snprintf(shown, sizeof shown, "--%s", f.row->name);
    return take(q, f, shown, value);
}

/* Read -abc: several flags, of which the last may take a value. */
static lw_status short_options(parser *q, const char *word)
{
    for (const char *c = word + 1; *c; c++) {
        found f = place_of(q, row_by_letter(q->own, *c), row_by_letter(cli_common_options, *c));
        char shown[4] = { '-', *c, 0, 0 };
        if (!f.row && c == word + 1 && isalpha((unsigned char)c[1]))
            return unknown_option(q, word + 1, strlen(word + 1));
        if (!f.row)
            return unknown_letter(q, *c);
        bool flag = f.row->kind == CLI_FLAG;
        lw_status s = take(q, f, shown, flag || !c[1] ? NULL : c + 1 + (c[1] == '='));
        if (s != LW_OK || !flag)
            return s;
    }
    return LW_OK;
}

static lw_status check_partners(parser *q)
{
    for (int i = 0; q->own && q->own[i].name; i++) {
        const cli_option *r = &q->own[i];
        if (!(q->p->given >> i & 1))
            continue;
        if (r->needs && !cli_given(q->p, r->needs))
            return lw_error_set(q->e, LW_E_ARG, "--%s needs --%s beside it", r->name, r->needs);
        if (r->excludes && cli_given(q->p, r->excludes))
            return lw_error_set(q->e, LW_E_ARG, "--%s and --%s contradict each other; leave one out", r->name, r->excludes);
    }
    return LW_OK;
}

lw_status cli_parse(const cli_option *options, int argc, char **argv, void *settings, cli_common *common, cli_parsed *p, lw_error *e)
{
    *p = (cli_parsed){ .options = options };
    *common = (cli_common){ 0 };
    p->word = calloc((size_t)argc + 1, sizeof *p->word);
    if (!p->word)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    parser q = { options, settings, common, p, e, argc, 0, argv };
    lw_status s = defaults(&q);
    bool only_words = false;
    while (s == LW_OK && q.at < argc) {
        const char *w = argv[q.at++];
        if (only_words || w[0] != '-' || !w[1] || is_number(w))
            p->word[p->n_word++] = w;
        else if (strcmp(w, "--") == 0)
            only_words = true;
        else if (w[1] == '-')
            s = long_option(&q, w);
        else
            s = short_options(&q, w);
    }
    return s == LW_OK && !common->help ? check_partners(&q) : s;
}

bool cli_given(const cli_parsed *p, const char *name)
{
    int own = row_by_name(p->options, name, strlen(name));
    if (own >= 0)
        return p->given >> own & 1;
    int common = row_by_name(cli_common_options, name, strlen(name));
    return common >= 0 && (p->given_common >> common & 1);
}

/* ---- help -------------------------------------------------------------------------------------- */

#define HELP_COLUMN 30
#define HELP_WIDTH  96

/* Print text folded into lines that begin at column `left`. */
static void fold(const char *text, int left, FILE *f)
{
    int at = left;
    while (*text) {
        int size = (int)strcspn(text, " ");
        if (at > left && at + 1 + size > HELP_WIDTH) {
            fprintf(f, "\n%*s", left, "");
            at = left;
        }
        at += fprintf(f, "%s%.*s", at > left ? " " : "", size, text);
        text += size;
        text += strspn(text, " ");
    }
    fputc('\n', f);
}

void cli_option_text(const cli_option *r, char text[CLI_HELP_SIZE])
{
    snprintf(text, CLI_HELP_SIZE, "%s%s%s%s%s%s%s%s", r->help, r->needs ? "; with --" : "",
             r->needs ? r->needs : "", r->excludes ? "; not with --" : "",
             r->excludes ? r->excludes : "", r->fallback ? " (default " : "",
             r->fallback ? r->fallback : "", r->fallback ? ")" : "");
}

void cli_option_help(const cli_option *r, FILE *f)
{
    char head[128], text[CLI_HELP_SIZE];
    char letter[8] = "    ";
    if (r->letter)
        snprintf(letter, sizeof letter, "-%c, ", r->letter);
    snprintf(head, sizeof head, "  %s--%s%s%s", letter, r->name, r->argument ? " " : "", r->argument ? r->argument : "");
    cli_option_text(r, text);
    int n = fprintf(f, "%s", head);
    if (n >= HELP_COLUMN)
        fprintf(f, "\n%*s", HELP_COLUMN, "");
    else
        fprintf(f, "%*s", HELP_COLUMN - n, "");
    fold(text, HELP_COLUMN, f);
}

void cli_common_help(const cli_option *shadow, FILE *f)
{
    for (const cli_option *r = cli_common_options; r->name; r++)
        if (row_by_name(shadow, r->name, strlen(r->name)) < 0)
            cli_option_help(r, f);
}
