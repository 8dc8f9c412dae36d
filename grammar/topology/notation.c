#include "grammar/topology/notation.h"

#include <string.h>
#include "grammar/topology/edges.h"
#include "grammar/topology/franke.h"
#include "grammar/topology/graph6.h"
#include "grammar/topology/lam.h"
#include "grammar/topology/mechanism_json.h"
#include "grammar/topology/sentence.h"

/* ---- the rows ---------------------------------------------------------------------------------- */

/* The chain of a text as a mechanism, whose limit of joints is lower. */
static lw_status from_chain(const lw_chain *c, const char *file, lw_mechanism *m, lw_error *e)
{
    if (lw_mechanism_from_chain(c, m) != LW_OK)
        return lw_error_at(e, LW_E_NOTATION, file ? file : "", 1, 1, "more than %d joints", LW_JOINT_MAX);
    return LW_OK;
}

static lw_status read_graph6(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_chain c;
    lw_status s = lw_graph6_read(text, size, file, &c, e);
    return s == LW_OK ? from_chain(&c, file, m, e) : s;
}

static lw_status print_graph6(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    lw_chain c;
    lw_mechanism_chain(m, &c);
    *length = lw_graph6_print(&c, buf, size);
    return LW_OK;
}

static lw_status read_lam(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_lam a;
    lw_status s = lw_lam_read(text, size, file, &a, e);
    if (s == LW_OK)
        lw_lam_mechanism(&a, m, NULL);
    return s;
}

static lw_status print_lam(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    lw_lam a;
    lw_lam_from_mechanism(m, &a);
    *length = lw_lam_print(&a, buf, size);
    return LW_OK;
}

static lw_status read_sentence(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_sentence s;
    lw_status status = lw_sentence_read(text, size, file, &s, e);
    return status == LW_OK ? lw_sentence_mechanism(&s, m, e) : status;
}

static lw_status print_sentence(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    lw_sentence s;
    lw_status status = lw_sentence_from_mechanism(m, &s);
    if (status == LW_OK)
        *length = lw_sentence_print(&s, buf, size);
    return status;
}

static lw_status read_franke(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_franke f;
    lw_chain c;
    lw_status s = lw_franke_read(text, size, file, &f, e);
    if (s == LW_OK)
        s = lw_franke_chain(&f, &c);
    return s == LW_OK ? from_chain(&c, file, m, e) : s;
}

static lw_status print_franke(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    lw_franke f;
    lw_chain c;
    lw_mechanism_chain(m, &c);
    lw_status s = lw_franke_from_chain(&c, &f);
    if (s == LW_OK)
        *length = lw_franke_print(&f, buf, size);
    return s;
}

static lw_status print_edges(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    *length = lw_edges_print(m, buf, size);
    return LW_OK;
}

static lw_status print_json(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    *length = lw_mechanism_write(m, buf, size);
    return LW_OK;
}

static lw_status print_dot(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    *length = lw_dot_print(m, "topology", buf, size);
    return LW_OK;
}

static lw_status print_graphml(const lw_mechanism *m, char *buf, size_t size, size_t *length)
{
    *length = lw_graphml_print(m, buf, size);
    return LW_OK;
}

enum { GRAPH6, LAM, SENTENCE, FRANKE, EDGES, JSON, DOT, GRAPHML };

const lw_notation lw_notations[] = {
    [GRAPH6] = { "graph6", LW_GRAPH6_SIZE, false, false, false, read_graph6, print_graph6 },
    [LAM] = { "lam", LW_LAM_SIZE, true, true, false, read_lam, print_lam },
    [SENTENCE] = { "sentence", LW_SENTENCE_SIZE, false, true, false, read_sentence, print_sentence },
    [FRANKE] = { "franke", LW_FRANKE_SIZE, false, false, false, read_franke, print_franke },
    [EDGES] = { "edges", LW_EDGES_SIZE, false, true, true, lw_edges_read, print_edges },
    [JSON] = { "json", LW_MECHANISM_JSON_SIZE, false, true, true, lw_mechanism_read, print_json },
    [DOT] = { "dot", LW_DOT_SIZE, true, true, true, lw_dot_read, print_dot },
    [GRAPHML] = { "graphml", LW_GRAPHML_SIZE, true, true, true, lw_graphml_read, print_graphml },
    { .name = NULL }
};

const lw_notation *lw_notation_find(const char *name)
{
    for (const lw_notation *n = lw_notations; n->name; n++)
        if (strcmp(n->name, name) == 0)
            return n;
    return NULL;
}

/* ---- streams ----------------------------------------------------------------------------------- */

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* "graph" or "strict" and a byte that ends the word; no graph6 text of a chain begins so. */
static bool begins_graph(const char *text, size_t size)
{
    static const char *const word[] = { "graph", "strict", "digraph" };
    for (int k = 0; k < 3; k++) {
        size_t n = strlen(word[k]);
        if (size > n && memcmp(text, word[k], n) == 0 && (is_blank(text[n]) || text[n] == '{' || text[n] == '/'))
            return true;
    }
    return false;
}

const lw_notation *lw_notation_of(const char *text, size_t size)
{
    size_t i = 0, k;
    while (i < size && is_blank(text[i]))
        i++;
    for (k = i + 1; k < size && is_blank(text[k]); k++)
        continue;
    char first = i < size ? text[i] : 0, second = k < size ? text[k] : 0;
    if (first == '{')
        return &lw_notations[JSON];
    if (first == '<')
        return &lw_notations[GRAPHML];
    if (begins_graph(text + i, size - i))
        return &lw_notations[DOT];
    if (first == ';' || (first == '(' && !is_digit(second) && (second != ')' || k + 1 >= size)))
        return &lw_notations[SENTENCE];
    if (first == '(')
        return &lw_notations[FRANKE];
    if (!is_digit(first))
        return &lw_notations[GRAPH6];
    while (i < size && is_digit(text[i]))
        i++;
    return &lw_notations[i < size && text[i] == '-' ? EDGES : LAM];
}

/* Length of a piece that ends where its brackets close; up to the end of the text if they do not close. */
static size_t bracketed(const char *text, size_t size, char open, char close, char comment)
{
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < size; i++) {
        if (comment && text[i] == comment)
            while (i + 1 < size && text[i + 1] != '\n')
                i++;
        else if (quoted)
            i += text[i] == '\\', quoted = i < size && text[i] != '"';
        else if (text[i] == '"' && !comment)
            quoted = true;
        else if (text[i] == open)
            depth++;
        else if (text[i] == close && --depth == 0)
            return i + 1;
    }
    return size;
}

static size_t line_length(const char *text, size_t size)
{
    const char *end = memchr(text, '\n', size);
    return end ? (size_t)(end - text) : size;
}

static bool is_empty(const char *text, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!is_blank(text[i]))
            return false;
    return true;
}

/* Up to the next empty line. */
static size_t block_length(const char *text, size_t size)
{
    size_t n = 0;
    while (n < size) {
        size_t line = line_length(text + n, size - n);
        if (is_empty(text + n, line))
            break;
        n += line + (n + line < size);
    }
    return n;
}

static size_t up_to(const char *text, size_t size, const char *end)
{
    const char *at = memmem(text, size, end, strlen(end));
    return at ? (size_t)(at - text) + strlen(end) : size;
}

static size_t piece_length(const lw_notation *n, const char *text, size_t size)
{
    size_t line = line_length(text, size), length;
    if (n == &lw_notations[LAM])
        return block_length(text, size);
    if (n == &lw_notations[SENTENCE])
        length = bracketed(text, size, '(', ')', ';');
    else if (n == &lw_notations[JSON])
        length = bracketed(text, size, '{', '}', 0);
    else if (n == &lw_notations[DOT])
        length = bracketed(text, size, '{', '}', 0);
    else if (n == &lw_notations[GRAPHML])
        length = up_to(text, size, "</graphml>");
    else
        return line;
    return length + line_length(text + length, size - length);   /* the rest of the line belongs to the fault */
}

lw_topologies lw_topologies_open(const char *text, size_t size, const char *file)
{
    return (lw_topologies){ .text = text, .size = size, .file = file, .line = 1 };
}

/* Step over empty lines and '#' lines. */
static void skip_between(lw_topologies *t)
{
    while (t->at < t->size) {
        size_t n = line_length(t->text + t->at, t->size - t->at);
        if ((!is_empty(t->text + t->at, n) && t->text[t->at] != '#') || (t->more && t->at + n == t->size))
            return;
        t->at += n + (t->at + n < t->size);
        t->line++;
    }
}

lw_status lw_topologies_next(lw_topologies *t, lw_mechanism *m, lw_error *e)
{
    skip_between(t);
    if (t->at == t->size)
        return t->more ? LW_STOPPED : LW_NOTHING;
    const char *text = t->text + t->at;
    t->notation = lw_notation_of(text, t->size - t->at);
    t->first_line = t->line;
    t->length = piece_length(t->notation, text, t->size - t->at);
    if (t->more && t->at + t->length == t->size)
        return LW_STOPPED;
    lw_status s = t->notation->read(text, t->length, t->file, m, e);
    if (s != LW_OK && e && e->line > 0)
        e->line += t->line - 1;
    long line = t->line;
    for (size_t i = 0; i < t->length; i++)
        line += text[i] == '\n';
    t->at += t->length;
    if (t->at < t->size && t->text[t->at] == '\n') {
        t->at++;
        line++;
    }
    t->line = line;
    return s;
}
