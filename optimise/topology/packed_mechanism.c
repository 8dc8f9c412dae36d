#include "optimise/topology/packed_mechanism.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "grammar/linkage/sketch.h"

static const char letters[] = "rtpg";

#define WHOLE 1e-9              /* a number this near to a whole number is one                           */

lw_packed_mechanism lw_packed_mechanism_of(const lw_mechanism *m, int chain, unsigned turned, int ratio)
{
    lw_packed_mechanism p = { .chain = (uint16_t)chain, .ground = (uint8_t)m->ground, .tracer = (uint8_t)m->output,
                              .turned = (uint8_t)turned, .ratio = (uint8_t)ratio };
    for (int j = 0; j < m->n_joint; j++)
        p.kinds |= (uint32_t)(strchr(letters, m->kind[j]) - letters) << 2*j;
    return p;
}

lw_mechanism lw_packed_mechanism_unpack(const lw_numbered_chain *c, const lw_packed_mechanism *p)
{
    lw_mechanism m = c->m;
    m.ground = p->ground;
    m.output = p->tracer;
    for (int j = 0; j < m.n_joint; j++)
        m.kind[j] = letters[p->kinds >> 2*j & 3];
    return m;
}

/* ---- gears ---------------------------------------------------------------------------------------------- */

/* List the joints that are pairs of wheels.  Returns their number, or -1: a gear has no link that carries both its
 * sides, or several. */
static int wheel_pairs(const lw_linkage *linkage, int joint[LW_JOINT_MAX])
{
    int n = 0;
    lw_gear g;
    for (int j = 0; j < linkage->n_joint; j++) {
        if (linkage->joint[j].kind != LW_JOINT_GEAR)
            continue;
        if (lw_linkage_gear(linkage, j, &g, NULL) != LW_OK)
            return -1;
        if (g.slider[0] < 0 && g.slider[1] < 0)
            joint[n++] = j;
    }
    return n;
}

/* n^pairs, or something above LW_GEAR_SET_MAX. */
static int all_sets(int pairs, int n)
{
    int sets = 1;
    for (int g = 0; g < pairs && sets <= LW_GEAR_SET_MAX; g++)
        sets *= n;
    return sets;
}

int lw_gear_sets(const lw_linkage *linkage, const lw_ratio_list *gear)
{
    int joint[LW_JOINT_MAX], pairs = wheel_pairs(linkage, joint), sets = all_sets(pairs, gear->n);
    return pairs < 0 ? 0 : sets < LW_GEAR_SET_MAX ? sets : LW_GEAR_SET_MAX;
}

/* Number of the ratio that pair g has in a set; all count from 0. */
static int ratio_of(int set, int g, int pairs, int n)
{
    if (all_sets(pairs, n) > LW_GEAR_SET_MAX)
        return (set + set/n*g) % n;
    while (g-- > 0)
        set /= n;
    return set % n;
}

static void put_ratios(const lw_packed_mechanism *p, const lw_ratio_list *gear, lw_linkage *linkage)
{
    int joint[LW_JOINT_MAX], pairs = p->ratio > 0 ? wheel_pairs(linkage, joint) : 0;
    for (int g = 0; g < pairs; g++)
        linkage->joint[joint[g]].ratio = gear->of[ratio_of(p->ratio - 1, g, pairs, gear->n)].value;
}

/* ", ratio 2", ", ratios 2, -1". */
static int ratios_text(const lw_numbered_chain *c, const lw_packed_mechanism *p, const lw_ratio_choices *r, char *name, size_t size)
{
    lw_linkage k;
    int joint[LW_JOINT_MAX], n = 0;
    if (p->ratio == 0 || lw_packed_mechanism_sketch(c, p, r, &k) != LW_OK)
        return 0;
    int pairs = wheel_pairs(&k, joint);
    for (int g = 0; g < pairs; g++)
        n += snprintf(name + n, size - (size_t)n, "%s%s", g > 0 ? ", " : pairs > 1 ? ", ratios " : ", ratio ",
                      r->gear.of[ratio_of(p->ratio - 1, g, pairs, r->gear.n)].text);
    return n;
}

/* ---- a linkage ------------------------------------------------------------------------------------------ */

static void put_inputs(const lw_packed_mechanism *p, const lw_ratio_choices *r, lw_linkage *linkage)
{
    linkage->n_input = p->n_input;
    for (int i = 0; i < p->n_input; i++)
        linkage->input[i] = (lw_input){ .joint = p->input[i], .value = lw_linkage_posture_input(linkage, p->input[i]),
                                  .ratio = i > 0 ? r->tie.of[p->tie[i]].value : 0 };
}

lw_status lw_packed_mechanism_sketch(const lw_numbered_chain *c, const lw_packed_mechanism *p,
                                     const lw_ratio_choices *r, lw_linkage *linkage)
{
    lw_mechanism m = lw_packed_mechanism_unpack(c, p);
    lw_rng rng;
    unsigned bit = 1;
    lw_rng_seed(&rng, (uint64_t)c->n2 << 32 | (uint64_t)c->m.n_link << 16 | p->chain,
                (uint64_t)p->kinds << 24 | (uint64_t)p->ground << 16 | (uint64_t)p->tracer << 8 | p->turned);
    lw_status st = lw_linkage_sketch(&m, &rng, linkage);
    for (int j = 0; j < linkage->n_joint && st == LW_OK; j++)
        if (linkage->joint[j].kind == LW_JOINT_SLOT) {
            bool later = p->turned & bit;
            linkage->joint[j].link[0] = m.link[j][later];
            linkage->joint[j].link[1] = m.link[j][!later];
            bit <<= 1;
        }
    if (st != LW_OK)
        return st;
    put_ratios(p, &r->gear, linkage);
    put_inputs(p, r, linkage);
    return LW_OK;
}

/* ---- names -------------------------------------------------------------------------------------------- */

static int degree(const lw_mechanism *m, int link)
{
    int n = 0;
    for (int j = 0; j < m->n_joint; j++)
        n += m->link[j][0] == link || m->link[j][1] == link;
    return n;
}

/* Is a six-link chain Watt's, else Stephenson's?  *number: I, II, III by the ground link. */
static bool is_watt(const lw_mechanism *m, int ground, int *number)
{
    int ternary[2], n = 0, beside = 0;
    for (int i = 0; i < 6; i++)
        if (degree(m, i) == 3)
            ternary[n++] = i;
    for (int i = 0; i < 2; i++)
        beside += lw_mechanism_joint(m, ground, ternary[i]) != LW_NONE;
    bool watt = lw_mechanism_joint(m, ternary[0], ternary[1]) != LW_NONE, three = degree(m, ground) == 3;
    *number = watt ? 1 + three : three ? 3 : beside == 2 ? 1 : 2;
    return watt;
}

void lw_packed_mechanism_key(const lw_numbered_chain *c, const lw_packed_mechanism *p, char *key, size_t size)
{
    int number;
    if (c->n2 > 0)
        snprintf(key, size, "%d.%d.%d", c->m.n_link, c->n2, c->number);
    else if (c->m.n_link != 6)
        snprintf(key, size, "%d.%d", c->m.n_link, c->number);
    else {
        const char *chain = is_watt(&c->m, p->ground, &number) ? "watt" : "stephenson";
        snprintf(key, size, "%s%d", chain, number);
    }
}

/* Name of a mechanism with joints of two freedoms: number of links, of these joints, and of the chain; kinds of all
 * joints; links with the slots. */
static int higher_title(const lw_numbered_chain *c, const lw_packed_mechanism *p, const lw_ratio_choices *r, char *name, size_t size)
{
    lw_mechanism m = lw_packed_mechanism_unpack(c, p);
    unsigned bit = 1;
    int n = snprintf(name, size, "%d-link %d.%d %.*s", m.n_link, c->n2, c->number, m.n_joint, m.kind);
    for (int j = 0; j < m.n_joint; j++)
        if (lw_joint_has_slot(m.kind[j])) {
            n += snprintf(name + n, size - (size_t)n, "%s%d", bit == 1 ? ", slot " : "+", m.link[j][(p->turned & bit) != 0] + 1);
            bit <<= 1;
        }
    n += ratios_text(c, p, r, name + n, size - (size_t)n);
    return n + snprintf(name + n, size - (size_t)n, ", ground %d", p->ground + 1);
}

/* Name without inputs and tracer link; with the kinds of the joints if these are not all pins. */
static int title(const lw_numbered_chain *c, const lw_packed_mechanism *p, const lw_ratio_choices *r, char *name, size_t size)
{
    static const char *const roman[] = { "", "I", "II", "III" };
    lw_mechanism m = lw_packed_mechanism_unpack(c, p);
    int number, n_kind = p->kinds ? m.n_joint : 0;
    const char *blank = n_kind ? " " : "";
    if (c->n2 > 0)
        return higher_title(c, p, r, name, size);
    if (m.n_link != 6)
        return snprintf(name, size, "%d-link chain %d%s%.*s, ground %d", m.n_link, c->number, blank, n_kind, m.kind, m.ground + 1);
    const char *chain = is_watt(&m, m.ground, &number) ? "Watt" : "Stephenson";
    return snprintf(name, size, "%s %s%s%.*s", chain, roman[number], blank, n_kind, m.kind);
}

/* ", input 2", ", inputs 1+4 by -2", ", inputs 1+4+6 by -2 and 3". */
static int inputs_text(const lw_packed_mechanism *p, const lw_ratio_list *tie, char *name, size_t size)
{
    int n = 0;
    for (int i = 0; i < p->n_input; i++)
        n += snprintf(name + n, size - (size_t)n, "%s%d", i > 0 ? "+" : p->n_input > 1 ? ", inputs " : ", input ", p->input[i] + 1);
    for (int i = 1; i < p->n_input; i++)
        n += snprintf(name + n, size - (size_t)n, "%s%s", i == 1 ? " by " : " and ", tie->of[p->tie[i]].text);
    return n;
}

void lw_packed_mechanism_name(const lw_numbered_chain *c, const lw_packed_mechanism *p, const lw_ratio_choices *r,
                              bool input, char *name, size_t size)
{
    int n = title(c, p, r, name, size);
    if (input || p->n_input > 1)
        n += inputs_text(p, &r->tie, name + n, size - (size_t)n);
    snprintf(name + n, size - (size_t)n, ", point on link %d", p->tracer + 1);
}

/* ---- canonical form --------------------------------------------------------------------------------------- */

/* Add a vertex between the links of a joint. */
static void add_between(lw_graph *g, const lw_joint *q, int colour, int first, int second)
{
    int at = g->n++;
    g->colour[at] = (uint8_t)colour;
    g->tie[q->link[0]][at] = g->tie[at][q->link[0]] = (uint8_t)first;
    g->tie[q->link[1]][at] = g->tie[at][q->link[1]] = (uint8_t)second;
}

/* Numerator of a ratio of small whole numbers, plus 128. */
static int part_of_ratio(double ratio)
{
    for (int lower = 1; lower < LW_INPUT_TURNS_PER_PERIOD_MAX; lower++)
        if (fabs(fabs(ratio)*lower - round(fabs(ratio)*lower)) < WHOLE && fabs(ratio)*lower < 100)
            return 128 + (int)lround(fabs(ratio)*lower);
    return 128;
}

/* Rates of the inputs as whole numbers without a common divisor; false: the numbers are too large. */
static bool whole_rates(const lw_linkage *linkage, int rate[LW_INPUT_MAX])
{
    for (int lower = 1; lower < 128; lower++) {
        bool whole = true;
        for (int i = 0; i < linkage->n_input; i++) {
            double r = lower*(i > 0 ? linkage->input[i].ratio : 1);
            rate[i] = (int)lround(r);
            whole = whole && fabs(r - rate[i]) < WHOLE && abs(rate[i]) < 128;
        }
        if (whole)
            return true;
    }
    return false;
}

/* Add two joined vertices.  Each driven link is joined to the first or the second by the sign of its rate. */
static bool add_rates(const lw_linkage *linkage, lw_graph *g)
{
    int rate[LW_INPUT_MAX], box = g->n;
    if (g->n + 2 > LW_GRAPH_MAX || !whole_rates(linkage, rate))
        return false;
    g->n += 2;
    g->colour[box] = g->colour[box + 1] = 32;
    g->tie[box][box + 1] = g->tie[box + 1][box] = 1;
    for (int i = 0; i < linkage->n_input; i++) {
        const lw_joint *j = &linkage->joint[linkage->input[i].joint];
        int link = j->link[j->link[0] == linkage->ground], at = box + (rate[i] < 0);
        g->tie[link][at] = g->tie[at][link] = (uint8_t)(128 + abs(rate[i]));
    }
    return true;
}

static bool is_rack(const lw_linkage *linkage, int joint)
{
    lw_gear g;
    return lw_linkage_gear(linkage, joint, &g, NULL) == LW_OK && (g.slider[0] >= 0 || g.slider[1] >= 0);
}

lw_status lw_linkage_canonical_form(const lw_linkage *linkage, lw_graph *form)
{
    lw_graph g = { .n = linkage->n_link };
    uint8_t to[LW_GRAPH_MAX];
    g.colour[linkage->ground] = 1;
    g.colour[linkage->tracer[0].link] = (uint8_t)(2 + g.colour[linkage->tracer[0].link]);
    for (int j = 0; j < linkage->n_joint; j++) {
        const lw_joint *q = &linkage->joint[j];
        if (q->kind == LW_JOINT_SLOT && g.n < LW_GRAPH_MAX)
            add_between(&g, q, 8, LW_JOINT_SLIDER, LW_JOINT_REVOLUTE);
        else if (q->kind == LW_JOINT_GEAR && g.n < LW_GRAPH_MAX && is_rack(linkage, j))
            add_between(&g, q, 18, 1, 1);
        else if (q->kind == LW_JOINT_GEAR && g.n < LW_GRAPH_MAX)
            add_between(&g, q, q->ratio < 0 ? 16 : 17, part_of_ratio(1/q->ratio), part_of_ratio(q->ratio));
        else
            g.tie[q->link[0]][q->link[1]] = g.tie[q->link[1]][q->link[0]] = (uint8_t)q->kind;
    }
    if (linkage->n_input > 1 && !add_rates(linkage, &g))
        return LW_NOTHING;
    lw_status st = lw_graph_label(&g, to);
    if (st != LW_OK)
        return st;
    *form = (lw_graph){ .n = g.n };
    for (int i = 0; i < g.n; i++) {
        form->colour[to[i]] = g.colour[i];
        for (int l = 0; l < g.n; l++)
            form->tie[to[i]][to[l]] = g.tie[i][l];
    }
    return LW_OK;
}

/* ---- ratios ---------------------------------------------------------------------------------------------- */

static lw_status read_ratio(const char *option, const char *word, lw_ratio *r, lw_error *e)
{
    char *end, *over = NULL;
    double a = strtod(word, &end), b = 1;
    if (*end == '/')
        b = strtod(end + 1, &over);
    end = over ? over : end;
    r->value = a/b;
    snprintf(r->text, sizeof r->text, "%s", word);
    bool whole = a == round(a) && b == round(b) && fabs(a) >= 1 && fabs(b) >= 1
              && fabs(a) <= LW_INPUT_TURNS_PER_PERIOD_MAX && fabs(b) <= LW_INPUT_TURNS_PER_PERIOD_MAX;
    if (end != word && *end == 0 && whole && (!over || over != word))
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "%s takes whole numbers and fractions of whole numbers up to %d with commas "
                        "between, as -1,2,-1/2; '%s' is none", option, LW_INPUT_TURNS_PER_PERIOD_MAX, word);
}

lw_status lw_ratio_list_read(const char *option, const char *text, lw_ratio_list *r, lw_error *e)
{
    lw_status st = LW_OK;
    r->n = 0;
    for (const char *at = text; st == LW_OK && *at; ) {
        char word[12] = "";
        size_t length = strcspn(at, ",");
        if (r->n == LW_RATIO_MAX)
            return lw_error_set(e, LW_E_ARG, "%s takes %d ratios at most", option, LW_RATIO_MAX);
        snprintf(word, sizeof word, "%.*s", (int)length, at);
        st = read_ratio(option, word, &r->of[r->n++], e);
        at += length + (at[length] == ',');
    }
    return st == LW_OK && r->n == 0 ? lw_error_set(e, LW_E_ARG, "%s is empty", option) : st;
}
