/* grammar/topology/sentence.c - chain -> sentence, and printing; sentence_read.c goes the other way. */
#include "grammar/topology/sentence.h"

#include <stdlib.h>
#include <string.h>
#include "grammar/text/text_internal.h"
#include "grammar/topology/circuit.h"
#include "grammar/topology/planar.h"

/* A closed walk over links, which becomes a word. */
typedef struct walk { int n; uint8_t link[2*LW_JOINT_MAX]; } walk;

/* 0-based links in the order of a cyclic shift, forwards or backwards. */
static walk turned(const walk *w, int start, bool backwards)
{
    walk out = { .n = w->n };
    for (int i = 0; i < w->n; i++)
        out.link[i] = w->link[backwards ? (start - i + w->n) % w->n : (start + i) % w->n];
    return out;
}

/* The lexicographically smallest shift. */
static walk least_turn(const walk *w, bool backwards)
{
    walk best = turned(w, 0, backwards);
    for (int start = 1; start < w->n; start++) {
        walk other = turned(w, start, backwards);
        if (memcmp(other.link, best.link, (size_t)w->n) < 0)
            best = other;
    }
    return best;
}

static int by_links(const void *a, const void *b)
{
    const walk *u = a, *v = b;
    int order = memcmp(u->link, v->link, (size_t)(u->n < v->n ? u->n : v->n));
    return order ? order : u->n - v->n;
}

static void add_word(const walk *w, const lw_mechanism *m, lw_sentence *s)
{
    int at = s->first[s->n_word];
    for (int i = 0; i < w->n; i++) {
        int a = w->link[i], b = w->link[(i + 1) % w->n];
        s->part[at + i] = (uint8_t)(a + 1);
        s->joint[at + i] = m->kind[lw_mechanism_joint(m, a, b)];
    }
    s->first[++s->n_word] = at + w->n;
}

/* The outer region and the mirror image can be chosen freely.  Choose a longest region as the outer one and, among
 * these, the one whose outer word is lexicographically smallest. */
static void choose_outer(const walk *region, int n, int *outer, bool *mirror)
{
    walk best = { 0 };
    for (int r = 0; r < n; r++)
        for (int back = 0; back < 2; back++) {
            walk w = least_turn(&region[r], back);
            if (w.n > best.n || (w.n == best.n && memcmp(w.link, best.link, (size_t)w.n) < 0)) {
                best = w;
                *outer = r;
                *mirror = !back;
            }
        }
}

/* Regions are traced in the same sense, each seen from inside.  The outer region is read from outside, so it turns
 * the other way in the same drawing (Makkonen 1999, paper F: all words clockwise). */
static void write_regions(const lw_regions *r, const lw_mechanism *m, lw_sentence *s)
{
    walk region[LW_REGION_MAX] = { 0 }, inner[LW_REGION_MAX];
    int outer = 0, n = 0;
    bool mirror = false;
    for (int k = 0; k < r->n_region; k++) {
        region[k] = (walk){ .n = r->first[k + 1] - r->first[k] };
        memcpy(region[k].link, r->vertex + r->first[k], (size_t)region[k].n);
    }
    choose_outer(region, r->n_region, &outer, &mirror);
    for (int k = 0; k < r->n_region; k++)
        if (k != outer)
            inner[n++] = least_turn(&region[k], mirror);
    qsort(inner, (size_t)n, sizeof *inner, by_links);
    walk first = least_turn(&region[outer], !mirror);
    add_word(&first, m, s);
    for (int k = 0; k < n; k++)
        add_word(&inner[k], m, s);
}

/* Joints in no circuit: removing one separates its ends. */
static bool is_bridge(const lw_chain_circuits *c, int a, int b)
{
    for (int k = 0; k < c->n_circuit; k++)
        for (int i = c->first[k]; i < c->first[k + 1]; i++) {
            int x = c->vertex[i], y = c->vertex[i + 1 < c->first[k + 1] ? i + 1 : c->first[k]];
            if ((x == a && y == b) || (x == b && y == a))
                return false;
        }
    return true;
}

static void write_basis(const lw_chain_circuits *c, const lw_mechanism *m, lw_sentence *s)
{
    s->basis = true;
    for (int k = 0; k < c->n_circuit; k++) {
        walk w = { .n = c->first[k + 1] - c->first[k] };
        memcpy(w.link, c->vertex + c->first[k], (size_t)w.n);
        walk up = least_turn(&w, false), down = least_turn(&w, true);
        add_word(by_links(&up, &down) <= 0 ? &up : &down, m, s);
    }
    for (int j = 0; j < m->n_joint; j++)
        if (is_bridge(c, m->link[j][0], m->link[j][1]))
            add_word(&(walk){ .n = 2, .link = { m->link[j][0], m->link[j][1] } }, m, s);
}

lw_status lw_sentence_from_mechanism(const lw_mechanism *m, lw_sentence *s)
{
    lw_chain c;
    lw_regions r;
    lw_chain_circuits basis;
    uint32_t adjacent[LW_LINK_MAX];
    lw_mechanism_chain(m, &c);
    for (int i = 0; i < m->n_link; i++)
        adjacent[i] = lw_chain_neighbours(&c, i);
    if (m->n_link < 2 || !lw_chain_is_connected(&c))
        return LW_E_ARG;
    memset(s, 0, sizeof *s);
    lw_status status = lw_planar_regions(m->n_link, adjacent, &r);
    if (status == LW_OK)
        write_regions(&r, m, s);
    else if (status == LW_NOTHING && (status = lw_circuit_basis(m->n_link, adjacent, &basis)) == LW_OK)
        write_basis(&basis, m, s);
    return status;
}

size_t lw_sentence_print(const lw_sentence *s, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    lw_text_add(&t, s->basis ? "(basis" : "(");
    for (int w = 0; w < s->n_word; w++) {
        lw_text_add(&t, w > 0 || s->basis ? " (" : "(");
        for (int i = s->first[w]; i < s->first[w + 1]; i++)
            lw_text_add(&t, "%s%d %c", i > s->first[w] ? " " : "", s->part[i], s->joint[i]);
        lw_text_byte(&t, ')');
    }
    lw_text_byte(&t, ')');
    return t.length;
}
