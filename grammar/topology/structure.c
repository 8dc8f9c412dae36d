/* grammar/topology/structure.c - see structure.h. */
#include <string.h>
#include "grammar/topology/structure.h"

void lw_structure_degrees(const lw_structure *s, uint8_t *degree)
{
    memset(degree, 0, s->n_circle);
    for (int e = 0; e < s->n_line; e++) {
        degree[s->end[e][0]]++;
        degree[s->end[e][1]]++;
    }
}

void lw_structure_rows(const lw_structure *s, uint32_t *row)
{
    memset(row, 0, s->n_circle*sizeof *row);
    for (int e = 0; e < s->n_line; e++) {
        row[s->end[e][0]] |= (uint32_t)1 << s->end[e][1];
        row[s->end[e][1]] |= (uint32_t)1 << s->end[e][0];
    }
}

/* Circles reached from `start` inside `allowed`. */
static uint32_t flood(const uint32_t *row, uint32_t start, uint32_t allowed)
{
    uint32_t seen = start, fresh = start;
    while (fresh) {
        uint32_t more = row[__builtin_ctz(fresh)] & allowed & ~seen;
        fresh &= fresh - 1;
        seen |= more;
        fresh |= more;
    }
    return seen;
}

/* In a 2-connected graph a line u - v is removable if no third circle then separates u from v. */
bool lw_structure_removable(const lw_structure *s, int line)
{
    if (lw_structure_loops(s) <= 2)
        return false;
    uint32_t row[LW_CIRCLE_MAX];
    int u = s->end[line][0], v = s->end[line][1];
    bool parallel = (line > 0 && memcmp(s->end[line - 1], s->end[line], 2) == 0)
                 || (line + 1 < s->n_line && memcmp(s->end[line + 1], s->end[line], 2) == 0);
    if (parallel)
        return true;
    lw_structure_rows(s, row);
    uint32_t from = (uint32_t)1 << u, goal = (uint32_t)1 << v, all = ((uint32_t)1 << s->n_circle) - 1;
    row[u] &= ~goal;
    row[v] &= ~from;
    for (uint32_t rest = all & ~from & ~goal; rest; rest &= rest - 1)
        if (!(flood(row, from, all & ~(rest & -rest)) & goal))
            return false;
    return true;
}

/* Append line a - b, keeping the rows in order. */
static void insert_line(lw_structure *s, int a, int b)
{
    uint8_t low = (uint8_t)(a < b ? a : b), high = (uint8_t)(a < b ? b : a);
    int k = s->n_line++;
    for (; k > 0 && (s->end[k - 1][0] > low || (s->end[k - 1][0] == low && s->end[k - 1][1] > high)); k--)
        memcpy(s->end[k], s->end[k - 1], 2);
    s->end[k][0] = low;
    s->end[k][1] = high;
}

static void delete_line(lw_structure *s, int line)
{
    int after = --s->n_line - line;
    memmove(s->end[line], s->end[line + 1], 2*(size_t)after);
    memset(s->end[s->n_line], 0, 2);
}

void lw_structure_relabel(const lw_structure *s, const uint8_t *to, lw_structure *out)
{
    lw_structure renamed = { .n_circle = s->n_circle };
    for (int e = 0; e < s->n_line; e++)
        insert_line(&renamed, to[s->end[e][0]], to[s->end[e][1]]);
    *out = renamed;
}

bool lw_structure_same(const lw_structure *a, const lw_structure *b)
{
    return a->n_circle == b->n_circle && a->n_line == b->n_line
        && memcmp(a->end, b->end, 2*(size_t)a->n_line) == 0;
}

static void join(lw_chain *c, int i, int k)
{
    c->one[i] |= (uint32_t)1 << k;
    c->one[k] |= (uint32_t)1 << i;
}

lw_status lw_structure_chain(const lw_structure *s, const uint8_t *weight, lw_chain *c)
{
    int n_link = s->n_circle, next = s->n_circle;
    for (int e = 0; e < s->n_line; e++)
        n_link += weight[e];
    if (n_link > LW_LINK_MAX)
        return LW_E_ARG;
    *c = (lw_chain){ .n_link = n_link };
    for (int e = 0; e < s->n_line; e++) {
        int from = s->end[e][0], to = s->end[e][1];
        if (weight[e] == 0 && c->one[from] >> to & 1)
            return LW_E_ARG;
        for (int k = 0; k < weight[e]; k++, from = next++)
            join(c, from, next);
        join(c, from, to);
    }
    return LW_OK;
}

lw_structure lw_structure_theta(void)
{
    return (lw_structure){ .n_circle = 2, .n_line = 3, .end = { { 0, 1 }, { 0, 1 }, { 0, 1 } } };
}

static bool ear_fits(const lw_structure *s, lw_ear ear)
{
    switch (ear.rule) {
    case LW_EAR_CIRCLES:     return ear.a < ear.b && ear.b < s->n_circle;
    case LW_EAR_CIRCLE_LINE: return ear.a < s->n_circle && ear.b < s->n_line;
    case LW_EAR_LINES:       return ear.a < ear.b && ear.b < s->n_line;
    case LW_EAR_LINE:        return ear.a == ear.b && ear.a < s->n_line;
    default:                 return false;
    }
}

/* Put a new circle on the line u - v, which the caller has removed; returns its number. */
static int split(lw_structure *s, const uint8_t *line)
{
    int circle = s->n_circle++;
    insert_line(s, line[0], circle);
    insert_line(s, circle, line[1]);
    return circle;
}

lw_status lw_structure_grow(const lw_structure *s, lw_ear ear, lw_structure *out)
{
    if (!ear_fits(s, ear) || lw_structure_loops(s) >= LW_LOOP_MAX)
        return LW_E_ARG;
    lw_structure grown = *s;
    uint8_t line_a[2], line_b[2];
    memcpy(line_a, s->end[ear.a], 2);
    memcpy(line_b, s->end[ear.b], 2);
    int from = ear.a, to = ear.b;
    switch (ear.rule) {
    case LW_EAR_CIRCLE_LINE:
        delete_line(&grown, ear.b);
        to = split(&grown, line_b);
        break;
    case LW_EAR_LINES:
        delete_line(&grown, ear.b);
        delete_line(&grown, ear.a);
        from = split(&grown, line_a);
        to = split(&grown, line_b);
        break;
    case LW_EAR_LINE:
        delete_line(&grown, ear.a);
        from = grown.n_circle++;
        to = grown.n_circle++;
        insert_line(&grown, line_a[0], from);
        insert_line(&grown, from, to);
        insert_line(&grown, to, line_a[1]);
        break;
    default:
        break;
    }
    insert_line(&grown, from, to);
    *out = grown;
    return LW_OK;
}

lw_status lw_derivation_replay(const lw_derivation *d, lw_structure *out)
{
    lw_structure s = lw_structure_theta();
    lw_status status = LW_OK;
    for (int k = 0; k < d->n_ear && status == LW_OK; k++)
        status = lw_structure_grow(&s, d->ear[k], &s);
    if (status == LW_OK)
        *out = s;
    return status;
}
