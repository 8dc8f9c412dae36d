/* grammar/topology/graph_read.c - see edges.h: DOT and GraphML, as far as they describe one undirected graph. */
#include <string.h>
#include "grammar/text/text_internal.h"
#include "grammar/topology/edges.h"

#define NAME_SIZE 64

typedef struct edge { int a, b; char kind; bool driven; lw_cursor at; } edge;

/* The graph read so far: nodes in the order in which they are named. */
typedef struct graph {
    int  n_node, n_edge, ground, output;
    char name[LW_LINK_MAX][NAME_SIZE];
    edge edge[LW_JOINT_MAX];
} graph;

static lw_status find_node(graph *g, const lw_cursor *at, const char *name, int *node)
{
    for (*node = 0; *node < g->n_node; ++*node)
        if (strcmp(g->name[*node], name) == 0)
            return LW_OK;
    if (g->n_node == LW_LINK_MAX)
        return lw_cursor_fail(at, "more than %d links", LW_LINK_MAX);
    memcpy(g->name[g->n_node++], name, NAME_SIZE);
    return LW_OK;
}

static lw_status add_edge(graph *g, const lw_cursor *at, int a, int b)
{
    if (a == b)
        return lw_cursor_fail(at, "link %s is joined to itself", g->name[a]);
    for (int k = 0; k < g->n_edge; k++)
        if ((g->edge[k].a == a && g->edge[k].b == b) || (g->edge[k].a == b && g->edge[k].b == a))
            return lw_cursor_fail(at, "links %s and %s are joined twice", g->name[a], g->name[b]);
    if (g->n_edge == LW_JOINT_MAX)
        return lw_cursor_fail(at, "more than %d joints", LW_JOINT_MAX);
    g->edge[g->n_edge++] = (edge){ a, b, LW_JOINT_REVOLUTE, false, *at };
    return LW_OK;
}

/* If the names are the numbers 1 .. n or 0 .. n - 1, they are the links; else links follow the order of the names. */
static void number_links(const graph *g, uint8_t *link)
{
    int value[LW_LINK_MAX], least = LW_LINK_MAX;
    uint64_t seen = 0;
    bool numbers = true;
    for (int i = 0; i < g->n_node && numbers; i++) {
        const char *digit = g->name[i];
        value[i] = 0;
        for (; *digit >= '0' && *digit <= '9' && value[i] <= LW_LINK_MAX; digit++)
            value[i] = 10*value[i] + *digit - '0';
        numbers = !*digit && value[i] <= LW_LINK_MAX && g->name[i][0];
        seen |= numbers ? (uint64_t)1 << value[i] : 0;
        least = numbers && value[i] < least ? value[i] : least;
    }
    uint64_t all = ((uint64_t)1 << g->n_node) - 1;
    numbers = numbers && least <= 1 && seen == all << least;
    for (int i = 0; i < g->n_node; i++)
        link[i] = (uint8_t)(numbers ? value[i] - least : i);
}

static lw_status assemble(const graph *g, const lw_cursor *start, lw_mechanism *m)
{
    uint8_t link[LW_LINK_MAX];
    uint64_t inputs = 0;
    if (g->n_edge == 0)
        return lw_cursor_fail(start, "there is no joint (edge)");
    for (int i = 0; i < g->n_node; i++) {
        bool joined = false;
        for (int k = 0; k < g->n_edge; k++)
            joined = joined || g->edge[k].a == i || g->edge[k].b == i;
        if (!joined)
            return lw_cursor_fail(start, "link %s has no joint", g->name[i]);
    }
    number_links(g, link);
    lw_mechanism_clear(m, g->n_node);
    for (int k = 0; k < g->n_edge; k++)
        lw_mechanism_join(m, link[g->edge[k].a], link[g->edge[k].b], g->edge[k].kind);
    for (int k = 0; k < g->n_edge; k++)
        if (g->edge[k].driven && lw_joint_freedoms(g->edge[k].kind) != 1)
            return lw_cursor_fail(&g->edge[k].at, "a driven joint has one freedom: r or t");
        else if (g->edge[k].driven)
            inputs |= (uint64_t)1 << lw_mechanism_joint(m, link[g->edge[k].a], link[g->edge[k].b]);
    if (__builtin_popcountll(inputs) > LW_INPUT_MAX)
        return lw_cursor_fail(start, "more than %d driven joints", LW_INPUT_MAX);
    for (; inputs; inputs &= inputs - 1)
        m->input[m->n_input++] = (uint8_t)__builtin_ctzll(inputs);
    m->ground = g->ground >= 0 ? link[g->ground] : LW_NONE;
    m->output = g->output >= 0 ? link[g->output] : LW_NONE;
    return LW_OK;
}

/* A joint letter as the whole text; anything else is a label of another program. */
static void take_kind(const char *text, edge *e)
{
    if (text[0] && !text[1] && lw_joint_freedoms(text[0]))
        e->kind = text[0];
}

/* ---- DOT ------------------------------------------------------------------------------------------ */

/* Skip blanks, line ends and comments. */
static void skip_dot(lw_cursor *c)
{
    for (;;) {
        lw_cursor_skip(c, true, '#');
        if (lw_cursor_begins(c, "//")) {
            while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '\n')
                lw_cursor_next(c);
        } else if (lw_cursor_begins(c, "/*")) {
            while (lw_cursor_peek(c) >= 0 && !lw_cursor_begins(c, "*/"))
                lw_cursor_next(c);
            lw_cursor_step(c, 2);
        } else {
            return;
        }
    }
}

static bool in_word(int byte)
{
    return (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z')
        || byte == '_' || byte == '.' || byte > 127;
}

/* An identifier, a number or a quoted text. */
static lw_status read_word(lw_cursor *c, char *word)
{
    lw_cursor at = *c;
    char name[24];
    int n = 0;
    bool quoted = lw_cursor_peek(c) == '"';
    memset(word, 0, NAME_SIZE);
    if (quoted)
        lw_cursor_next(c);
    while (quoted ? lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '"' : in_word(lw_cursor_peek(c))) {
        if (n == NAME_SIZE - 1)
            return lw_cursor_fail(&at, "a name is longer than %d bytes", NAME_SIZE - 1);
        word[n++] = (char)lw_cursor_next(c);
    }
    if (quoted && lw_cursor_next(c) != '"')
        return lw_cursor_fail(&at, "the quotation marks do not close");
    if (n == 0 && !quoted)
        return lw_cursor_fail(c, "%s where a name was expected", lw_byte_name(lw_cursor_peek(c), name));
    return LW_OK;
}

/* The attributes of the node, or of edges first .. of the statement. */
static lw_status read_attributes(lw_cursor *c, graph *g, int node, int first)
{
    char key[NAME_SIZE], value[NAME_SIZE];
    lw_cursor_next(c);                                    /* '[' */
    for (skip_dot(c); lw_cursor_peek(c) != ']'; skip_dot(c)) {
        int byte = lw_cursor_peek(c);
        if (byte == ',' || byte == ';') {
            lw_cursor_next(c);
            continue;
        }
        value[0] = '\0';
        lw_status s = read_word(c, key);
        skip_dot(c);
        if (s == LW_OK && lw_cursor_peek(c) == '=') {
            lw_cursor_next(c);
            skip_dot(c);
            s = read_word(c, value);
        }
        if (s != LW_OK)
            return s;
        if (node >= 0 && strcmp(key, "shape") == 0 && strcmp(value, "doublecircle") == 0)
            g->ground = node;
        if (node >= 0 && strcmp(key, "style") == 0 && strcmp(value, "bold") == 0)
            g->output = node;
        for (int k = first; node < 0 && k < g->n_edge; k++) {
            if (strcmp(key, "label") == 0)
                take_kind(value, &g->edge[k]);
            if (strcmp(key, "penwidth") == 0 && strcmp(value, "3") == 0)
                g->edge[k].driven = true;
        }
    }
    lw_cursor_next(c);
    return LW_OK;
}

/* "a", "a -- b -- c" or "key = value", with attributes. */
static lw_status read_statement(lw_cursor *c, graph *g)
{
    char word[NAME_SIZE];
    lw_cursor at = *c;
    int node = -1, next, first = g->n_edge;
    lw_status s = read_word(c, word);
    skip_dot(c);
    if (s == LW_OK && strcmp(word, "subgraph") == 0)
        return lw_cursor_fail(&at, "subgraphs are not read; write each joint as a -- b");
    bool defaults = strcmp(word, "node") == 0 || strcmp(word, "edge") == 0 || strcmp(word, "graph") == 0;
    if (s == LW_OK && lw_cursor_peek(c) == '=') {
        lw_cursor_next(c);
        skip_dot(c);
        return read_word(c, word);
    }
    if (s == LW_OK && !defaults)
        s = find_node(g, &at, word, &node);
    bool joined = false;
    while (s == LW_OK && lw_cursor_begins(c, "-")) {
        if (!lw_cursor_begins(c, "--"))
            return lw_cursor_fail(c, "joints have no direction: write -- instead of ->");
        lw_cursor_step(c, 2);
        skip_dot(c);
        at = *c;
        s = read_word(c, word);
        if (s == LW_OK)
            s = find_node(g, &at, word, &next);
        if (s == LW_OK && node < 0)
            s = lw_cursor_fail(&at, "a joint of what?");
        if (s == LW_OK)
            s = add_edge(g, &at, node, next);
        node = next;
        joined = true;
        skip_dot(c);
    }
    if (s == LW_OK && lw_cursor_peek(c) == '[')
        s = read_attributes(c, g, joined ? -1 : node, joined ? first : g->n_edge);
    return s;
}

lw_status lw_dot_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e), start = c;
    char word[NAME_SIZE];
    graph g = { .ground = -1, .output = -1 };
    skip_dot(&c);
    lw_status s = read_word(&c, word);
    skip_dot(&c);
    if (s == LW_OK && strcmp(word, "strict") == 0) {
        s = read_word(&c, word);
        skip_dot(&c);
    }
    if (s == LW_OK && strcmp(word, "graph") != 0)
        s = lw_cursor_fail(&start, "a DOT file of a chain begins with the word graph");
    if (s == LW_OK && lw_cursor_peek(&c) != '{')
        s = read_word(&c, word);
    skip_dot(&c);
    if (s == LW_OK && lw_cursor_next(&c) != '{')
        s = lw_cursor_fail(&c, "'{' was expected after the word graph");
    for (skip_dot(&c); s == LW_OK && lw_cursor_peek(&c) != '}'; skip_dot(&c))
        if (lw_cursor_peek(&c) == ';')
            lw_cursor_next(&c);
        else if (lw_cursor_peek(&c) < 0)
            s = lw_cursor_fail(&c, "the graph is cut short: '}' is missing");
        else
            s = read_statement(&c, &g);
    lw_cursor_next(&c);
    skip_dot(&c);
    if (s == LW_OK && lw_cursor_peek(&c) >= 0)
        s = lw_cursor_fail(&c, "something stands after the graph");
    return s == LW_OK ? assemble(&g, &start, m) : s;
}

/* ---- GraphML -------------------------------------------------------------------------------------- */

/* A tag: its name, whether it closes, and the attributes that matter here. */
typedef struct tag {
    char name[NAME_SIZE], id[NAME_SIZE], source[NAME_SIZE], target[NAME_SIZE], key[NAME_SIZE], attribute[NAME_SIZE];
    char direction[NAME_SIZE];
    bool closes, empty;                                   /* </name>, <name/> */
} tag;

/* Bytes up to one of `ends`, cut to the room there is. */
static void read_until(lw_cursor *c, const char *ends, char *out)
{
    int n = 0;
    memset(out, 0, NAME_SIZE);
    for (int byte; (byte = lw_cursor_peek(c)) >= 0 && !(byte && strchr(ends, byte)); lw_cursor_next(c))
        if (n < NAME_SIZE - 1)
            out[n++] = (char)byte;
}

/* Skip text up to the next tag, which is read.  false: no further tag. */
static bool next_tag(lw_cursor *c, tag *t, lw_status *s)
{
    char name[NAME_SIZE], value[NAME_SIZE];
    *t = (tag){ .name = "" };
    for (;;) {
        while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '<')
            lw_cursor_next(c);
        const char *end = lw_cursor_begins(c, "<!--") ? "-->" : lw_cursor_begins(c, "<?") ? "?>"
                        : lw_cursor_begins(c, "<!") ? ">" : NULL;
        if (!end)
            break;
        while (lw_cursor_peek(c) >= 0 && !lw_cursor_begins(c, end))
            lw_cursor_next(c);
    }
    if (lw_cursor_next(c) < 0)
        return false;
    t->closes = lw_cursor_peek(c) == '/';
    if (t->closes)
        lw_cursor_next(c);
    read_until(c, " \t\r\n/>", t->name);
    for (;;) {
        lw_cursor_skip(c, true, 0);
        int byte = lw_cursor_peek(c);
        t->empty = t->empty || byte == '/';
        if (byte < 0 || byte == '>')
            break;
        if (byte == '/') {
            lw_cursor_next(c);
            continue;
        }
        lw_cursor at = *c;
        read_until(c, "= \t\r\n/>", name);
        lw_cursor_skip(c, true, 0);
        int quote = lw_cursor_next(c) == '=' ? (lw_cursor_skip(c, true, 0), lw_cursor_next(c)) : -1;
        if (quote != '"' && quote != '\'') {
            *s = lw_cursor_fail(&at, "an attribute is written name=\"value\"");
            return false;
        }
        read_until(c, quote == '"' ? "\"" : "'", value);
        lw_cursor_next(c);
        char *to = strcmp(name, "id") == 0 ? t->id : strcmp(name, "source") == 0 ? t->source
                 : strcmp(name, "target") == 0 ? t->target : strcmp(name, "key") == 0 ? t->key
                 : strcmp(name, "attr.name") == 0 ? t->attribute
                 : strcmp(name, "edgedefault") == 0 || strcmp(name, "directed") == 0 ? t->direction : NULL;
        if (to)
            memcpy(to, value, NAME_SIZE);
    }
    lw_cursor_next(c);
    return true;
}

/* The keys of the document that have a meaning here. */
typedef struct keys { char kind[NAME_SIZE], driven[NAME_SIZE], ground[NAME_SIZE], output[NAME_SIZE]; } keys;

static void note_key(const tag *t, keys *k)
{
    char *to = strcmp(t->attribute, "kind") == 0 ? k->kind : strcmp(t->attribute, "driven") == 0 ? k->driven
             : strcmp(t->attribute, "ground") == 0 ? k->ground : strcmp(t->attribute, "output") == 0 ? k->output : NULL;
    if (to)
        memcpy(to, t->id, NAME_SIZE);
}

static void take_data(graph *g, const keys *k, const tag *t, const char *text, int node, int joint)
{
    bool yes = strcmp(text, "true") == 0 || strcmp(text, "1") == 0;
    if (node >= 0 && yes && strcmp(t->key, k->ground) == 0)
        g->ground = node;
    if (node >= 0 && yes && strcmp(t->key, k->output) == 0)
        g->output = node;
    if (joint >= 0 && yes && strcmp(t->key, k->driven) == 0)
        g->edge[joint].driven = true;
    if (joint >= 0 && strcmp(t->key, k->kind) == 0)
        take_kind(text, &g->edge[joint]);
}

lw_status lw_graphml_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e), start = c, at = c;
    keys k = { "kind", "driven", "ground", "output" };
    graph g = { .ground = -1, .output = -1 };
    lw_status s = lw_text_check(text, size, file, e);
    int node = -1, joint = -1, a, b;
    bool ended = false;
    for (tag t; s == LW_OK && !ended && next_tag(&c, &t, &s); at = c) {
        bool is_node = strcmp(t.name, "node") == 0, is_edge = strcmp(t.name, "edge") == 0;
        ended = t.closes && strcmp(t.name, "graphml") == 0;
        if (t.closes || strcmp(t.direction, "directed") == 0 || (is_edge && strcmp(t.direction, "true") == 0)) {
            if (!t.closes)
                s = lw_cursor_fail(&at, "joints have no direction: the graph must be undirected");
            node = is_node ? -1 : node;
            joint = is_edge ? -1 : joint;
        } else if (strcmp(t.name, "key") == 0) {
            note_key(&t, &k);
        } else if (is_node) {
            s = find_node(&g, &at, t.id, &node);
            node = t.empty ? -1 : node;
        } else if (is_edge) {
            s = find_node(&g, &at, t.source, &a);
            if (s == LW_OK)
                s = find_node(&g, &at, t.target, &b);
            if (s == LW_OK)
                s = add_edge(&g, &at, a, b);
            joint = s == LW_OK && !t.empty ? g.n_edge - 1 : -1;
        } else if (strcmp(t.name, "data") == 0 && !t.empty) {
            char value[NAME_SIZE];
            read_until(&c, "<", value);
            take_data(&g, &k, &t, value, node, joint);
        }
    }
    if (s == LW_OK && !ended)
        s = lw_cursor_fail(&c, "the document is cut short: </graphml> is missing");
    return s == LW_OK ? assemble(&g, &start, m) : s;
}
