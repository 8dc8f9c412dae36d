#include "grammar/topology/rule.h"

#include <string.h>
#include "grammar/text/text_internal.h"

static const struct { int links, kinds; } rule_row[] = {
    [1] = { 3, 2 }, [2] = { 4, 4 }, [3] = { 1, 0 }, [4] = { 2, 3 },
};

int lw_rule_kinds(int rule) { return rule >= 1 && rule <= 4 ? rule_row[rule].kinds : 0; }
int lw_rule_links(int rule) { return rule >= 1 && rule <= 4 ? rule_row[rule].links : 0; }

lw_production lw_production_of(int rule)
{
    lw_production p = { .rule = rule, .word = LW_NONE };
    memset(p.kind, LW_JOINT_REVOLUTE, (size_t)lw_rule_kinds(rule));
    return p;
}

static lw_status check_kinds(const lw_production *p, lw_error *e)
{
    for (int i = 0; i < lw_rule_kinds(p->rule); i++)
        if (!lw_joint_can_drive(p->kind[i]))
            return lw_error_set(e, LW_E_ARG, "rule %d makes joints k = r or t, %d of them", p->rule, lw_rule_kinds(p->rule));
    return LW_OK;
}

lw_status lw_rule_plant(const lw_production *p, lw_sentence *s, lw_error *e)
{
    if (p->rule != 1 && p->rule != 2)
        return lw_error_set(e, LW_E_ARG, "rule %d plants no seed; rules 1 and 2 do", p->rule);
    lw_status status = check_kinds(p, e);
    if (status != LW_OK)
        return status;
    int n = lw_rule_links(p->rule);
    memset(s, 0, sizeof *s);
    for (int i = 0; i < 2*n; i++) {
        s->part[i] = (uint8_t)(i % n + 1);
        s->joint[i] = i % n < lw_rule_kinds(p->rule) ? p->kind[i % n] : (char)LW_JOINT_SLOT;
    }
    s->n_word = 2;
    s->first[1] = n;
    s->first[2] = 2*n;
    return LW_OK;
}

/* A word on its own. */
typedef struct word { int n; uint8_t part[LW_ATOM_MAX]; char joint[LW_ATOM_MAX]; } word;

static void add_atom(word *w, int part, char joint)
{
    w->part[w->n] = (uint8_t)part;
    w->joint[w->n++] = joint;
}

static int find_part(const lw_sentence *s, int w, int part)
{
    for (int i = s->first[w]; i < s->first[w + 1]; i++)
        if (s->part[i] == part)
            return i;
    return LW_NONE;
}

/* The word to which the rule applies; LW_NONE when no word contains X and Y. */
static int find_word(const lw_sentence *s, const lw_production *p)
{
    for (int w = 0; w < s->n_word; w++)
        if ((p->word == LW_NONE || p->word == w) && find_part(s, w, p->x) != LW_NONE && find_part(s, w, p->y) != LW_NONE)
            return w;
    return LW_NONE;
}

/* X, the new string, without the Y it ends at. */
static void add_string(word *w, const lw_production *p, int next)
{
    if (p->rule == 3) {
        add_atom(w, p->x, LW_JOINT_REVOLUTE);
        add_atom(w, next, LW_JOINT_SLOT);
        return;
    }
    add_atom(w, p->x, p->kind[0]);
    add_atom(w, next, p->kind[1]);
    add_atom(w, next + 1, p->kind[2]);
}

/* Split word w.  `kept` is the word with the new string in place of the old string X .. Y.  `added` is the old
 * string read back from Y to X, closed by the new one. */
static void split(const lw_sentence *s, const lw_production *p, int w, int next, word *kept, word *added)
{
    int first = s->first[w], n = s->first[w + 1] - first, x = find_part(s, w, p->x) - first, y = x;
    word round = { 0 };
    while (s->part[first + y] != p->y)
        y = (y + 1) % n;
    kept->n = added->n = 0;
    for (int i = y; i != x; i = (i + 1) % n)
        add_atom(&round, s->part[first + i], s->joint[first + i]);
    add_string(&round, p, next);
    int start = 0;                            /* begin with the part the word began with, if kept */
    for (int i = 0; i < round.n; i++)
        if (round.part[i] == s->part[first])
            start = i;
    for (int i = 0; i < round.n; i++)
        add_atom(kept, round.part[(start + i) % round.n], round.joint[(start + i) % round.n]);
    for (int i = y; i != x; i = (i + n - 1) % n)
        add_atom(added, s->part[first + i], s->joint[first + (i + n - 1) % n]);
    add_string(added, p, next);
}

static void append(lw_sentence *s, const word *w)
{
    int at = s->first[s->n_word];
    memcpy(s->part + at, w->part, (size_t)w->n);
    memcpy(s->joint + at, w->joint, (size_t)w->n);
    s->first[++s->n_word] = at + w->n;
}

static void append_from(lw_sentence *s, const lw_sentence *from, int w)
{
    int at = s->first[s->n_word], n = from->first[w + 1] - from->first[w];
    memcpy(s->part + at, from->part + from->first[w], (size_t)n);
    memcpy(s->joint + at, from->joint + from->first[w], (size_t)n);
    s->first[++s->n_word] = at + n;
}

static int highest_part(const lw_sentence *s)
{
    int highest = 0;
    for (int i = 0; i < s->first[s->n_word]; i++)
        highest = s->part[i] > highest ? s->part[i] : highest;
    return highest;
}

static lw_status check_place(const lw_sentence *s, const lw_production *p, int *w, lw_error *e)
{
    if (p->rule != 3 && p->rule != 4)
        return lw_error_set(e, LW_E_ARG, "rule %d grows nothing; rules 3 and 4 do", p->rule);
    if (p->x == p->y)
        return lw_error_set(e, LW_E_ARG, "part %d would be joined to itself by the new string: X and Y must differ", p->x);
    if (highest_part(s) + lw_rule_links(p->rule) > LW_LINK_MAX)
        return lw_error_set(e, LW_E_ARG, "the chain would have more than %d links", LW_LINK_MAX);
    if (s->first[s->n_word] + 2*(LW_LINK_MAX + 3) > LW_ATOM_MAX || s->n_word == LW_WORD_MAX)
        return lw_error_set(e, LW_E_ARG, "the chain would have more than %d joints", LW_JOINT_MAX);
    *w = p->word >= s->n_word ? LW_NONE : find_word(s, p);
    if (*w == LW_NONE && p->word != LW_NONE)
        return lw_error_set(e, LW_E_ARG, "word %d does not hold both part %d and part %d", p->word + 1, p->x, p->y);
    if (*w == LW_NONE)
        return lw_error_set(e, LW_E_ARG, "no word holds both part %d and part %d: they do not lie at one region", p->x, p->y);
    return check_kinds(p, e);
}

lw_status lw_rule_apply(const lw_sentence *s, const lw_production *p, lw_sentence *out, lw_error *e)
{
    int at = 0;
    lw_status status = check_place(s, p, &at, e);
    if (status != LW_OK)
        return status;
    lw_sentence grown = { .basis = s->basis };
    word kept, added;
    split(s, p, at, highest_part(s) + 1, &kept, &added);
    for (int w = 0; w < s->n_word; w++)
        if (w == at) {
            append(&grown, &kept);
            append(&grown, &added);
        } else {
            append_from(&grown, s, w);
        }
    *out = grown;
    return LW_OK;
}

size_t lw_production_print(const lw_production *p, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    lw_text_add(&t, "rule %d", p->rule);
    if (p->rule > 2)
        lw_text_add(&t, " at %d,%d", p->x, p->y);
    if (p->rule > 2 && p->word != LW_NONE)
        lw_text_add(&t, " of word %d", p->word + 1);
    for (int i = 0; i < lw_rule_kinds(p->rule); i++)
        lw_text_add(&t, "%s%c", i == 0 ? ", k = " : " ", p->kind[i]);
    return t.length;
}
