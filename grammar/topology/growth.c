#include "grammar/topology/growth.h"

#include <string.h>
#include "grammar/text/text_internal.h"
#include "grammar/topology/planar.h"

/* ---- growing ----------------------------------------------------------------------------------- */

static lw_status plant(lw_mechanism *m, const lw_production *p)
{
    int n = lw_rule_links(p->rule);
    lw_status s = lw_mechanism_clear(m, n);
    for (int i = 0; i < n && s == LW_OK; i++)
        s = lw_mechanism_join(m, i, (i + 1) % n, i < lw_rule_kinds(p->rule) ? p->kind[i] : (char)LW_JOINT_SLOT);
    return s;
}

/* Joints of the new string, from X to Y. */
static const char *string_kinds(const lw_production *p)
{
    return p->rule == 3 ? "rp" : p->kind;
}

lw_status lw_mechanism_grow(lw_mechanism *m, const lw_production *p)
{
    for (int i = 0; i < lw_rule_kinds(p->rule); i++)
        if (!lw_joint_can_drive(p->kind[i]))
            return LW_E_ARG;
    if (p->rule == 1 || p->rule == 2)
        return plant(m, p);
    int n = lw_rule_links(p->rule);
    if (n == 0 || p->x == p->y || p->x < 1 || p->y < 1 || p->x > m->n_link || p->y > m->n_link
        || m->n_link + n > LW_LINK_MAX || m->n_joint + n + 1 > LW_JOINT_MAX || m->n_input > 0)
        return LW_E_ARG;
    lw_status s = LW_OK;
    int at = p->x - 1;
    for (int i = 0; i <= n && s == LW_OK; i++) {
        int next = i < n ? m->n_link++ : p->y - 1;
        s = lw_mechanism_join(m, at, next, string_kinds(p)[i]);
        at = next;
    }
    return s;
}

lw_status lw_growth_sentence(const lw_growth *g, int n_step, lw_sentence *s, lw_error *e)
{
    if (n_step < 1 || n_step > g->n_step)
        return lw_error_set(e, LW_E_ARG, "a derivation has 1 to %d steps", g->n_step);
    lw_status status = lw_rule_plant(&g->step[0], s, e);
    for (int i = 1; i < n_step && status == LW_OK; i++)
        status = lw_rule_apply(s, &g->step[i], s, e);
    return status;
}

/* ---- removing lines ------------------------------------------------------------------------------- */

/* The piece that one step back removes: links q[0 .. n-1] from x to y, as links of the mechanism. */
typedef struct piece { int rule, n, x, y, q[2]; char kind[4]; } piece;

static uint32_t neighbours(const lw_chain *c, uint32_t left, int i)
{
    return lw_chain_neighbours(c, i) & left;
}

static char kind_of(const lw_mechanism *m, int i, int k)
{
    return m->kind[lw_mechanism_joint(m, i, k)];
}

static bool is_k(char kind) { return lw_joint_can_drive(kind); }

/* Rule 3 backwards at the binary link q. */
static bool is_rule_3(const lw_mechanism *m, uint32_t beside, int q, piece *p)
{
    int side[2] = { __builtin_ctz(beside), __builtin_ctz(beside & (beside - 1)) };
    bool turned = kind_of(m, q, side[0]) == LW_JOINT_SLOT;
    *p = (piece){ .rule = 3, .n = 1, .x = side[turned], .y = side[!turned], .q = { q } };
    return kind_of(m, q, p->x) == LW_JOINT_REVOLUTE && kind_of(m, q, p->y) == LW_JOINT_SLOT;
}

/* Rule 4 backwards at the binary link q and a binary link beside it. */
static bool is_rule_4(const lw_mechanism *m, const lw_chain *c, uint32_t left, int q, piece *p)
{
    uint32_t beside = neighbours(c, left, q);
    for (uint32_t s = beside; s; s &= s - 1) {
        int second = __builtin_ctz(s);
        uint32_t far = neighbours(c, left, second) & ~(1u << q);
        if (__builtin_popcount(far) != 1)
            continue;
        int x = __builtin_ctz(beside & ~(1u << second)), y = __builtin_ctz(far);
        *p = (piece){ .rule = 4, .n = 2, .x = x, .y = y, .q = { q, second },
                      .kind = { kind_of(m, x, q), kind_of(m, q, second), kind_of(m, second, y) } };
        if (is_k(p->kind[0]) && is_k(p->kind[1]) && is_k(p->kind[2]))
            return true;
    }
    return false;
}

static bool find_piece(const lw_mechanism *m, const lw_chain *c, uint32_t left, piece *p)
{
    for (uint32_t s = left; s; s &= s - 1) {
        int q = __builtin_ctz(s);
        uint32_t beside = neighbours(c, left, q);
        if (__builtin_popcount(beside) == 2 && (is_rule_3(m, beside, q, p) || is_rule_4(m, c, left, q, p)))
            return true;
    }
    return false;
}

static bool is_ring(const lw_chain *c, uint32_t left)
{
    for (uint32_t s = left; s; s &= s - 1)
        if (__builtin_popcount(neighbours(c, left, __builtin_ctz(s))) != 2)
            return false;
    return true;
}

/* The seed that equals a ring: read the ring from the link behind the p, or from the lowest link. */
static piece seed_of(const lw_mechanism *m, const lw_chain *c, uint32_t left, uint8_t *link_of)
{
    int n = __builtin_popcount(left), at = __builtin_ctz(left);
    int before = __builtin_ctz(neighbours(c, left, at));
    piece p = { .rule = n == 3 ? 1 : 2, .n = n };
    for (int turn = 0; turn < n && n == 3 && kind_of(m, before, at) != LW_JOINT_SLOT; turn++) {
        int next = __builtin_ctz(neighbours(c, left, at) & ~(1u << before));
        before = at;
        at = next;
    }
    for (int i = 0; i < n; i++) {
        int next = __builtin_ctz(neighbours(c, left, at) & ~(1u << before));
        link_of[i] = (uint8_t)at;
        p.kind[i] = kind_of(m, at, next);
        before = at;
        at = next;
    }
    return p;
}

/* Steps in forward order, in the numbering of the derivation. */
static void write_steps(const piece *back, int n_back, const piece *seed, lw_growth *g)
{
    uint8_t part_of[LW_LINK_MAX] = { 0 };
    int n_part = seed->n;
    for (int i = 0; i < n_part; i++)
        part_of[g->link_of[i]] = (uint8_t)(i + 1);
    g->n_step = 0;
    g->step[g->n_step] = lw_production_of(seed->rule);
    memcpy(g->step[g->n_step++].kind, seed->kind, (size_t)lw_rule_kinds(seed->rule));
    for (int i = n_back - 1; i >= 0; i--) {
        lw_production p = lw_production_of(back[i].rule);
        p.x = part_of[back[i].x];
        p.y = part_of[back[i].y];
        memcpy(p.kind, back[i].kind, (size_t)lw_rule_kinds(p.rule));
        for (int q = 0; q < back[i].n; q++) {
            g->link_of[n_part] = (uint8_t)back[i].q[q];
            part_of[back[i].q[q]] = (uint8_t)++n_part;
        }
        g->step[g->n_step++] = p;
    }
}

/* ---- words ------------------------------------------------------------------------------------- */

/* A region as the set of its joints, numbered as in the whole mechanism. */
typedef struct drawing { int n; uint64_t side[LW_REGION_MAX]; } drawing;

static lw_status draw(const lw_mechanism *m, const lw_chain *c, drawing *d)
{
    lw_regions r;
    uint32_t row[LW_LINK_MAX];
    for (int i = 0; i < c->n_link; i++)
        row[i] = lw_chain_neighbours(c, i);
    lw_status s = lw_planar_regions(c->n_link, row, &r);
    d->n = s == LW_OK ? r.n_region : 0;
    for (int k = 0; k < d->n; k++) {
        d->side[k] = 0;
        for (int i = r.first[k]; i < r.first[k + 1]; i++) {
            int next = i + 1 < r.first[k + 1] ? i + 1 : r.first[k];
            d->side[k] |= (uint64_t)1 << lw_mechanism_joint(m, r.vertex[i], r.vertex[next]);
        }
    }
    return s;
}

/* Joints of a piece as bits. */
static uint64_t joints_of(const lw_mechanism *m, const piece *p)
{
    uint64_t set = 0;
    int at = p->x;
    for (int i = 0; i <= p->n; i++) {
        int next = i < p->n ? p->q[i] : p->y;
        set |= (uint64_t)1 << lw_mechanism_joint(m, at, next);
        at = next;
    }
    return set;
}

/* Remove the piece from the drawing: the two regions beside it become one.  Returns the sides of the merged one. */
static uint64_t merge(drawing *d, uint64_t string)
{
    int at[2] = { 0, 0 }, n = 0;
    for (int k = 0; k < d->n && n < 2; k++)
        if (d->side[k] & string)
            at[n++] = k;
    uint64_t merged = (d->side[at[0]] | d->side[at[1]]) & ~string;
    d->side[at[0]] = merged;
    d->side[at[1]] = d->side[--d->n];
    return merged;
}

static uint64_t sides_of(const lw_mechanism *m, const lw_growth *g, const lw_sentence *s, int w)
{
    uint64_t set = 0;
    for (int i = s->first[w]; i < s->first[w + 1]; i++) {
        int next = i + 1 < s->first[w + 1] ? i + 1 : s->first[w];
        set |= (uint64_t)1 << lw_mechanism_joint(m, g->link_of[s->part[i] - 1], g->link_of[s->part[next] - 1]);
    }
    return set;
}

/* Choose for every step the word it works on, so that the words become the regions of the drawing. */
static lw_status choose_words(const lw_mechanism *m, drawing *d, const piece *back, int n_back, lw_growth *g, lw_error *e)
{
    uint64_t merged[LW_LINK_MAX];
    lw_sentence s;
    for (int i = 0; i < n_back; i++)
        merged[i] = merge(d, joints_of(m, &back[i]));
    lw_status status = lw_rule_plant(&g->step[0], &s, e);
    for (int i = 1; i < g->n_step && status == LW_OK; i++) {
        for (int w = 0; w < s.n_word && g->step[i].word == LW_NONE; w++)
            if (sides_of(m, g, &s, w) == merged[n_back - i])
                g->step[i].word = w;
        status = lw_rule_apply(&s, &g->step[i], &s, e);
    }
    return status;
}

lw_status lw_growth_find(const lw_mechanism *m, lw_growth *g, lw_reach *reach, uint32_t *core, lw_error *e)
{
    lw_chain c;
    drawing d;
    piece back[LW_LINK_MAX];
    int n_back = 0;
    lw_mechanism_chain(m, &c);
    uint32_t left = lw_chain_links(&c);
    lw_status s = lw_chain_check(&c, e);
    *reach = lw_chain_mobility(&c) != 1 ? LW_NOT_MOBILITY
           : memchr(m->kind, LW_JOINT_GEAR, (size_t)m->n_joint) ? LW_NOT_GEAR : LW_REACHED;
    if (s != LW_OK || *reach != LW_REACHED)
        return s;
    for (; !is_ring(&c, left) && find_piece(m, &c, left, &back[n_back]); n_back++)
        for (int i = 0; i < back[n_back].n; i++)
            left &= ~(1u << back[n_back].q[i]);
    if (!is_ring(&c, left)) {
        *reach = LW_NOT_CORE;
        if (core)
            *core = left;
        return LW_OK;
    }
    piece seed = seed_of(m, &c, left, g->link_of);
    write_steps(back, n_back, &seed, g);
    s = draw(m, &c, &d);
    if (s == LW_NOTHING) {
        *reach = LW_REACHED_NO_REGIONS;
        return LW_OK;
    }
    return s == LW_OK ? choose_words(m, &d, back, n_back, g, e) : s;
}

/* ---- the reason as text -------------------------------------------------------------------------------- */

/* The links where a subdivision of K5 or K3,3 branches. */
static void name_witness(lw_text *t, const lw_chain *c)
{
    uint32_t row[LW_LINK_MAX], witness[LW_LINK_MAX];
    int n = 0;
    for (int i = 0; i < c->n_link; i++)
        row[i] = lw_chain_neighbours(c, i);
    if (lw_planar_witness(c->n_link, row, witness) != LW_OK)
        return;
    lw_text_add(t, " (links");
    for (int i = 0; i < c->n_link; i++)
        if (__builtin_popcount(witness[i]) > 2) {
            lw_text_add(t, " %d", i + 1);
            n++;
        }
    lw_text_add(t, " are tied together as in %s)", n == 5 ? "K5" : "K3,3");
}

size_t lw_reach_print(const lw_mechanism *m, lw_reach reach, uint32_t core, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    lw_chain c;
    lw_mechanism_chain(m, &c);
    switch (reach) {
    case LW_REACHED:
        lw_text_add(&t, "rules 1 to 4 reach it");
        break;
    case LW_REACHED_NO_REGIONS:
        lw_text_add(&t, "rules 1 to 4 reach it only where X and Y need not lie at one region: its "
                    "graph is not planar, so it has no sentence of regions");
        name_witness(&t, &c);
        break;
    case LW_NOT_MOBILITY:
        lw_text_add(&t, "rules 1 to 4 keep F = 1, this chain has F = %d", lw_chain_mobility(&c));
        break;
    case LW_NOT_GEAR:
        lw_text_add(&t, "no rule makes a joint g");
        break;
    case LW_NOT_CORE:
        lw_text_add(&t, "taking strings away backwards ends at links");
        for (uint32_t s = core; s; s &= s - 1)
            lw_text_add(&t, " %d", __builtin_ctz(s) + 1);
        lw_text_add(&t, ", which are no seed and have no line of two binary links (rule 4) or of one between r and p (rule 3)");
        break;
    }
    return t.length;
}
