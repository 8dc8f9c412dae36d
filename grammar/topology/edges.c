#include "grammar/topology/edges.h"

#include <string.h>
#include "grammar/text/text_internal.h"

static bool driven(const lw_mechanism *m, int joint)
{
    return memchr(m->input, joint, (size_t)m->n_input) != NULL;
}

size_t lw_edges_print(const lw_mechanism *m, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    for (int j = 0; j < m->n_joint; j++) {
        lw_text_add(&t, "%s%d-%d", j > 0 ? " " : "", lw_mechanism_printed(m, j, 0) + 1, lw_mechanism_printed(m, j, 1) + 1);
        if (m->kind[j] != LW_JOINT_REVOLUTE)
            lw_text_add(&t, ":%c", m->kind[j]);
        if (driven(m, j))
            lw_text_byte(&t, '!');
    }
    if (m->ground != LW_NONE)
        lw_text_add(&t, " @%d", m->ground + 1);
    if (m->output != LW_NONE)
        lw_text_add(&t, " >%d", m->output + 1);
    return t.length;
}

/* One "a-b:k!" of the text, in the order of reading. */
typedef struct item { int a, b; char kind; bool driven; lw_cursor at; } item;

typedef struct reading {
    item      item[LW_JOINT_MAX];
    int       n_item, highest, ground, output;
    lw_cursor ground_at, output_at;
} reading;

static lw_status read_link(lw_cursor *c, int *link)
{
    lw_cursor at = *c;
    char name[24];
    if (!lw_cursor_number(c, link))
        return lw_cursor_fail(&at, "%s where a link number was expected", lw_byte_name(lw_cursor_peek(c), name));
    if (*link < 1 || *link > LW_LINK_MAX)
        return lw_cursor_fail(&at, "links are numbered 1 to %d", LW_LINK_MAX);
    return LW_OK;
}

/* ":k" and "!" after "a-b". */
static lw_status read_marks(lw_cursor *c, item *it)
{
    char name[24];
    it->kind = LW_JOINT_REVOLUTE;
    if (lw_cursor_peek(c) == ':') {
        lw_cursor_next(c);
        int byte = lw_cursor_peek(c);
        if (byte < 0 || byte > 127 || !lw_joint_freedoms((char)byte))
            return lw_cursor_fail(c, "%s is no joint letter; a joint is r (pin), t (slider), p (pin "
                                  "in slot) or g (gear or cam)", lw_byte_name(byte, name));
        it->kind = (char)lw_cursor_next(c);
    }
    if (lw_cursor_peek(c) == '!') {
        if (lw_joint_freedoms(it->kind) != 1)
            return lw_cursor_fail(c, "a driven joint has one freedom: r or t");
        lw_cursor_next(c);
        it->driven = true;
    }
    return LW_OK;
}

static lw_status read_joint(lw_cursor *c, reading *r)
{
    item it = { .at = *c };
    char name[24];
    lw_status s = read_link(c, &it.a);
    if (s == LW_OK && lw_cursor_peek(c) != '-')
        s = lw_cursor_fail(c, "%s where '-' between two links was expected", lw_byte_name(lw_cursor_peek(c), name));
    if (s == LW_OK) {
        lw_cursor_next(c);
        s = read_link(c, &it.b);
    }
    if (s == LW_OK)
        s = read_marks(c, &it);
    if (s != LW_OK)
        return s;
    if (it.a == it.b)
        return lw_cursor_fail(&it.at, "link %d is joined to itself", it.a);
    for (int k = 0; k < r->n_item; k++)
        if (r->item[k].a + r->item[k].b == it.a + it.b && (r->item[k].a == it.a || r->item[k].a == it.b))
            return lw_cursor_fail(&it.at, "links %d and %d are joined twice", it.a, it.b);
    if (r->n_item == LW_JOINT_MAX)
        return lw_cursor_fail(&it.at, "more than %d joints", LW_JOINT_MAX);
    r->item[r->n_item++] = it;
    r->highest = it.a > r->highest ? it.a : r->highest;
    r->highest = it.b > r->highest ? it.b : r->highest;
    return LW_OK;
}

/* "@n" or ">n", once each. */
static lw_status read_choice(lw_cursor *c, reading *r)
{
    lw_cursor at = *c;
    bool ground = lw_cursor_next(c) == '@';
    int *choice = ground ? &r->ground : &r->output, link;
    lw_status s = read_link(c, &link);
    if (s == LW_OK && *choice)
        s = lw_cursor_fail(&at, "a second %s link", ground ? "ground" : "output");
    if (s == LW_OK)
        *choice = link;
    *(ground ? &r->ground_at : &r->output_at) = at;
    return s;
}

static lw_status assemble(const reading *r, const lw_cursor *start, lw_mechanism *m)
{
    uint32_t named = 0;
    uint64_t inputs = 0;
    if (r->n_item == 0)
        return lw_cursor_fail(start, "there is no joint");
    if (r->ground > r->highest)
        return lw_cursor_fail(&r->ground_at, "link %d has no joint", r->ground);
    if (r->output > r->highest)
        return lw_cursor_fail(&r->output_at, "link %d has no joint", r->output);
    lw_mechanism_clear(m, r->highest);
    for (int k = 0; k < r->n_item; k++) {
        lw_mechanism_join(m, r->item[k].a - 1, r->item[k].b - 1, r->item[k].kind);
        named |= 1u << (r->item[k].a - 1) | 1u << (r->item[k].b - 1);
    }
    if (named & (named + 1))
        return lw_cursor_fail(start, "there is a link %d but no link %d", r->highest, 1 + __builtin_ctz(~named));
    for (int k = 0; k < r->n_item; k++)
        if (r->item[k].driven)
            inputs |= (uint64_t)1 << lw_mechanism_joint(m, r->item[k].a - 1, r->item[k].b - 1);
    if (__builtin_popcountll(inputs) > LW_INPUT_MAX)
        return lw_cursor_fail(start, "more than %d driven joints", LW_INPUT_MAX);
    for (; inputs; inputs &= inputs - 1)
        m->input[m->n_input++] = (uint8_t)__builtin_ctzll(inputs);
    m->ground = r->ground ? r->ground - 1 : LW_NONE;
    m->output = r->output ? r->output - 1 : LW_NONE;
    return LW_OK;
}

lw_status lw_edges_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e), start = c;
    lw_mechanism out;
    reading r = { 0 };
    lw_status s = LW_OK;
    for (;;) {
        lw_cursor_skip(&c, false, 0);
        int byte = lw_cursor_peek(&c);
        if (s != LW_OK || byte < 0 || byte == '\n' || byte == '\r')
            break;
        s = byte == '@' || byte == '>' ? read_choice(&c, &r) : read_joint(&c, &r);
    }
    lw_cursor_skip(&c, true, 0);
    if (s == LW_OK && lw_cursor_peek(&c) >= 0)
        s = lw_cursor_fail(&c, "one line of text is one chain");
    if (s == LW_OK)
        s = assemble(&r, &start, &out);
    if (s == LW_OK)
        *m = out;
    return s;
}

size_t lw_dot_print(const lw_mechanism *m, const char *name, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    lw_text_add(&t, "graph %s {\n  node [shape=circle];\n", name);
    for (int i = 0; i < m->n_link; i++)
        if (i == m->ground || i == m->output)
            lw_text_add(&t, "  %d [%s%s%s];\n", i + 1, i == m->ground ? "shape=doublecircle" : "",
                        i == m->ground && i == m->output ? " " : "",
                        i == m->output ? "style=bold" : "");
    for (int j = 0; j < m->n_joint; j++)
        lw_text_add(&t, "  %d -- %d [label=\"%c\"%s];\n", m->link[j][0] + 1, m->link[j][1] + 1,
                    m->kind[j], driven(m, j) ? " penwidth=3" : "");
    lw_text_add(&t, "}\n");
    return t.length;
}

size_t lw_graphml_print(const lw_mechanism *m, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    lw_text_add(&t, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n");
    lw_text_add(&t, "  <key id=\"kind\" for=\"edge\" attr.name=\"kind\" attr.type=\"string\"/>\n"
                "  <key id=\"driven\" for=\"edge\" attr.name=\"driven\" attr.type=\"boolean\"/>\n");
    lw_text_add(&t, "  <key id=\"ground\" for=\"node\" attr.name=\"ground\" attr.type=\"boolean\"/>\n"
                "  <key id=\"output\" for=\"node\" attr.name=\"output\" attr.type=\"boolean\"/>\n"
                "  <graph edgedefault=\"undirected\">\n");
    for (int i = 0; i < m->n_link; i++)
        lw_text_add(&t, "    <node id=\"%d\">%s%s</node>\n", i + 1,
                    i == m->ground ? "<data key=\"ground\">true</data>" : "",
                    i == m->output ? "<data key=\"output\">true</data>" : "");
    for (int j = 0; j < m->n_joint; j++)
        lw_text_add(&t, "    <edge source=\"%d\" target=\"%d\"><data key=\"kind\">%c</data>%s</edge>\n",
                    m->link[j][0] + 1, m->link[j][1] + 1, m->kind[j],
                    driven(m, j) ? "<data key=\"driven\">true</data>" : "");
    lw_text_add(&t, "  </graph>\n</graphml>\n");
    return t.length;
}
