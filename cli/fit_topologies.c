#include "cli/fit_topologies.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "enumerate/canon.h"
#include "enumerate/higher.h"
#include "enumerate/mechanisms.h"
#include "grammar/sketch.h"

typedef struct maker {
    const cli_topology_wish *w;
    cli_topology_stage      *to;
    lw_mechanism_counts      counts;
    lw_rng                   rng;
    int                      chain;              /* number of the chain in the list, from 1        */
    int                      n2;                 /* joints of two freedoms of these chains         */
    unsigned                 turned;             /* slots on the later link, bit i: the i-th       */
    const cli_ratio         *ratio;              /* of the gear, NULL: there is none               */
    bool                     met[64];            /* names of `only` that something bore           */
    lw_error                 e;
} maker;

const char *cli_topology_fate_text(cli_topology_fate f)
{
    static const char *const text[CLI_TOPOLOGY_FATES] = {
        "fitted", "tracer link joined to the ground", "moves as one with fewer links",
        "no input by which it can be worked out", "no gear pair whose carrier and one wheel are known first",
        "worked out by groups beyond dyads", "not asked for"
    };
    return text[f];
}

/* ---- names -------------------------------------------------------------------------------------------- */

static int degree(const lw_mechanism *m, int link)
{
    int n = 0;
    for (int j = 0; j < m->n_joint; j++)
        n += m->link[j][0] == link || m->link[j][1] == link;
    return n;
}

/* Chains with joints of two freedoms: by links, those joints and number, the kinds of all joints, and the links that
 * carry the slots. */
static void higher_name(const maker *mk, const lw_mechanism *m, char *name, char *key, size_t size)
{
    unsigned bit = 1;
    int n = snprintf(name, size, "%d-link %d.%d %.*s", m->n_link, mk->n2, mk->chain, m->n_joint, m->kind);
    for (int j = 0; j < m->n_joint; j++)
        if (m->kind[j] == 'p') {
            n += snprintf(name + n, size - (size_t)n, "%s%d", bit == 1 ? ", slot " : "+",
                          m->link[j][(mk->turned & bit) != 0] + 1);
            bit <<= 1;
        }
    if (mk->ratio)
        n += snprintf(name + n, size - (size_t)n, ", ratio %s", mk->ratio->text);
    snprintf(name + n, size - (size_t)n, ", ground %d", m->ground + 1);
    snprintf(key, size, "%d.%d.%d", m->n_link, mk->n2, mk->chain);
}

/* Watt I, II, Stephenson I, II, III by the place of the ground; others by number. */
static void ground_name(const maker *mk, const lw_mechanism *m, char *name, char *key, size_t size)
{
    if (mk->n2 > 0) {
        higher_name(mk, m, name, key, size);
        return;
    }
    if (m->n_link != 6) {
        snprintf(name, size, "%d-link chain %d, ground %d", m->n_link, mk->chain, m->ground + 1);
        snprintf(key, size, "%d.%d", m->n_link, mk->chain);
        return;
    }
    int ternary[2], n = 0, beside = 0;
    for (int i = 0; i < 6; i++)
        if (degree(m, i) == 3)
            ternary[n++] = i;
    for (int i = 0; i < 2; i++)
        beside += lw_mechanism_joint(m, m->ground, ternary[i]) != LW_NONE;
    bool watt = lw_mechanism_joint(m, ternary[0], ternary[1]) != LW_NONE, three = degree(m, m->ground) == 3;
    int number = watt ? 1 + three : three ? 3 : beside == 2 ? 1 : 2;
    static const char *const roman[] = { "", "I", "II", "III" };
    snprintf(name, size, "%s %s", watt ? "Watt" : "Stephenson", roman[number]);
    snprintf(key, size, "%s%d", watt ? "watt" : "stephenson", number);
}

/* Is one of `keys` (separated by commas) the word or its beginning up to digits? */
static bool asked_for(maker *mk, const char *key)
{
    bool found = strcmp(mk->w->only, "all") == 0;
    int k = 0;
    for (const char *at = mk->w->only; *at; k++) {
        size_t n = strcspn(at, ",");
        bool whole = strncmp(key, at, n) == 0 && key[n] == 0;
        bool begins = strncmp(key, at, n) == 0 && at[n - 1] > '9' && key[n] <= '9';     /* "watt": both */
        if ((whole || begins) && k < 64)
            mk->met[k] = found = true;
        at += n + (at[n] == ',');
    }
    return found;
}

/* ---- one pair of ground and tracer link ----------------------------------------------------------------- */

static lw_status count_input(void *context, const lw_mechanism *m)
{
    (void)m;
    ((maker *)context)->to->n_driven++;
    return LW_OK;
}

static lw_status make_room(cli_topology_stage *s)
{
    if (s->n_family < s->capacity)
        return LW_OK;
    int most = s->capacity ? 2*s->capacity : 64;
    lw_family *f = realloc(s->family, sizeof *f*(size_t)most);
    s->family = f ? f : s->family;
    lw_linkage **k = realloc(s->linkage, sizeof *k*(size_t)most);
    s->linkage = k ? k : s->linkage;
    void *name = realloc(s->name, sizeof *s->name*(size_t)most);
    s->name = name ? name : s->name;
    if (!f || !k || !name)
        return LW_E_MEMORY;
    s->capacity = most;
    return LW_OK;
}

static lw_status add_family(maker *mk, const lw_linkage *k, const char *name)
{
    cli_topology_stage *s = mk->to;
    if (s->n_family == CLI_FAMILY_MOST)
        return lw_error_set(&mk->e, LW_E_ARG, "more than %d mechanisms of %d links with these kinds of joints: more than can be "
                            "searched at one time; ask for some with --topology, for fewer links or fewer --joints",
                            CLI_FAMILY_MOST, s->links);
    lw_status st = make_room(s);
    if (st != LW_OK)
        return st;
    lw_linkage *own = malloc(sizeof *own);
    if (!own)
        return LW_E_MEMORY;
    *own = *k;
    snprintf(own->name, sizeof own->name, "%s", name);
    s->linkage[s->n_family] = own;
    snprintf(s->name[s->n_family], sizeof s->name[0], "%s", name);
    s->n_family++;
    return LW_OK;
}

/* A linkage of the mechanism, its slots on the links that mk->turned says. */
static lw_status sketch(maker *mk, const lw_mechanism *m, lw_linkage *k)
{
    unsigned bit = 1;
    lw_status st = lw_linkage_sketch(m, &mk->rng, k);
    for (int j = 0; j < k->n_joint && st == LW_OK; j++)
        if (k->joint[j].kind == LW_JOINT_GEAR && mk->ratio)
            k->joint[j].ratio = mk->ratio->value;
        else if (k->joint[j].kind == LW_JOINT_SLOT) {
            bool later = mk->turned & bit;
            k->joint[j].link[0] = m->link[j][later];
            k->joint[j].link[1] = m->link[j][!later];
            bit <<= 1;
        }
    return st;
}

/* Links that a plan works out, dies in slots not counted. */
static int links_of(const lw_plan *plan, const lw_linkage *k)
{
    int n = 0;
    for (int i = 0; i < plan->n_link; i++)
        n += plan->link[i] < k->n_link;
    return n;
}

/* The linkage with this input, and how it can be worked out: 0 not at all, 1 with groups beyond dyads, 2 by
 * dyads; *links that the point feels. */
static int try_input(maker *mk, const lw_mechanism *m, int joint, lw_linkage *k, int *links)
{
    lw_mechanism driven = *m;
    lw_plan *plan = malloc(sizeof *plan);
    int way = 0;
    driven.n_input = 1;
    driven.input[0] = (uint8_t)joint;
    if (plan && sketch(mk, &driven, k) == LW_OK
        && lw_plan_make_geared(k, (lw_want){ .tracers = 1 }, plan, NULL) == LW_OK) {
        way = plan->n_higher > 0 ? 1 : 2;
        *links = links_of(plan, k);
    }
    free(plan);
    return way;
}

/* Joints that may drive, those that make the plainest plan first: pins at the ground, slides there. */
static int best_input(maker *mk, const lw_mechanism *m, lw_linkage *best, int *links)
{
    int way = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < m->n_joint && way < 2; j++) {
            bool ground = m->link[j][0] == m->ground || m->link[j][1] == m->ground;
            lw_linkage k;
            int felt, now;
            if (!ground || m->kind[j] != (pass ? 't' : 'r') || (now = try_input(mk, m, j, &k, &felt)) <= way)
                continue;
            way = now;
            *links = felt;
            *best = k;
        }
    return way;
}

/* By a pin or a slide: then its points draw circles or lines. */
static bool joined_to_ground(const lw_mechanism *m)
{
    int j = lw_mechanism_joint(m, m->ground, m->output);
    return j != LW_NONE && lw_kind_freedom(m->kind[j]) == 1;
}

/* Groups beyond dyads are followed with care and cost a hundred times as much: with slots and gears, of which there
 * are thousands, they are searched only where somebody names them. */
static bool too_dear(const maker *mk, int way)
{
    return way == 1 && mk->n2 > 0 && strcmp(mk->w->only, "all") == 0;
}

/* All inputs at the ground that a prescribed timing may mean. */
static lw_status add_timed(void *context, const lw_mechanism *m)
{
    maker *mk = context;
    char name[160], key[64], title[96];
    lw_linkage k;
    int links, way;
    if (m->kind[m->input[0]] != 'r')
        return LW_OK;
    way = try_input(mk, m, m->input[0], &k, &links);
    if (way == 0 || links < m->n_link || too_dear(mk, way))
        return LW_OK;
    ground_name(mk, m, title, key, sizeof title);
    snprintf(name, sizeof name, "%s, input %d, point on link %d", title, m->input[0] + 1, m->output + 1);
    mk->to->n_group += way == 1;
    return add_family(mk, &k, name);
}

static lw_status add_pair(maker *mk, const lw_mechanism *m, cli_topology_fate *fate)
{
    char title[96], key[64], name[160];
    lw_linkage k;
    int links = 0, before = mk->to->n_family;
    ground_name(mk, m, title, key, sizeof title);
    *fate = CLI_TOPOLOGY_NOT_ASKED;
    if (!asked_for(mk, key))
        return LW_OK;
    *fate = CLI_TOPOLOGY_CIRCLE;
    if (joined_to_ground(m) && mk->w->task != LW_TASK_FUNCTION)
        return LW_OK;
    int way = best_input(mk, m, &k, &links);
    bool fewer = way > 0 && links < m->n_link;
    *fate = way == 0 ? CLI_TOPOLOGY_NO_PLAN : fewer ? CLI_TOPOLOGY_SMALLER : CLI_TOPOLOGY_FITTED;
    if (*fate == CLI_TOPOLOGY_FITTED && too_dear(mk, way))
        *fate = CLI_TOPOLOGY_GROUP;
    if (*fate != CLI_TOPOLOGY_FITTED && !(fewer && mk->w->timed))
        return LW_OK;
    if (mk->w->timed) {
        lw_status st = lw_inputs_each(m, 1, true, add_timed, mk);
        *fate = mk->to->n_family > before ? CLI_TOPOLOGY_FITTED : CLI_TOPOLOGY_SMALLER;
        return st;
    }
    snprintf(name, sizeof name, "%s, point on link %d", title, m->output + 1);
    mk->to->n_group += way == 1;
    return add_family(mk, &k, name);
}

/* ---- variants ------------------------------------------------------------------------------------------- */

/* A vertex between the links of a joint. */
static void put_between(lw_graph *g, const lw_joint *q, int colour, int first, int second)
{
    int at = g->n++;
    g->colour[at] = (uint8_t)colour;
    g->tie[q->link[0]][at] = g->tie[at][q->link[0]] = (uint8_t)first;
    g->tie[q->link[1]][at] = g->tie[at][q->link[1]] = (uint8_t)second;
}

/* Of a ratio of small whole numbers the upper one, and 128 more. */
static int part_of_ratio(double ratio)
{
    for (int lower = 1; lower < LW_LAP_MAX; lower++)
        if (fabs(fabs(ratio)*lower - round(fabs(ratio)*lower)) < 1e-9 && fabs(ratio)*lower < 100)
            return 128 + (int)lround(fabs(ratio)*lower);
    return 128;
}

/* Links as vertices, coloured by ground and tracer, dies in slots too; the kinds of joints between them: canonical. */
static bool canonical(const lw_linkage *k, lw_graph *form)
{
    lw_graph g = { .n = k->n_link };
    uint8_t to[LW_GRAPH_MAX];
    g.colour[k->ground] = 1;
    g.colour[k->tracer[0].link] = (uint8_t)(2 + g.colour[k->tracer[0].link]);
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *q = &k->joint[j];
        if (q->kind == LW_JOINT_SLOT && g.n < LW_GRAPH_MAX)
            put_between(&g, q, 8, LW_JOINT_SLIDER, LW_JOINT_REVOLUTE);
        else if (q->kind == LW_JOINT_GEAR && g.n < LW_GRAPH_MAX)
            put_between(&g, q, q->ratio < 0 ? 16 : 17, part_of_ratio(1/q->ratio), part_of_ratio(q->ratio));
        else
            g.tie[q->link[0]][q->link[1]] = g.tie[q->link[1]][q->link[0]] = (uint8_t)q->kind;
    }
    if (lw_graph_label(&g, to) != LW_OK)
        return false;
    *form = (lw_graph){ .n = g.n };
    for (int i = 0; i < g.n; i++) {
        form->colour[to[i]] = g.colour[i];
        for (int l = 0; l < g.n; l++)
            form->tie[to[i]][to[l]] = g.tie[i][l];
    }
    return true;
}

/* A mechanism with a gear, with each ratio: what becomes of it with the one with which it does best. */
static lw_status add_geared(maker *mk, const lw_mechanism *m, int gears, cli_topology_fate *fate)
{
    lw_status st = LW_OK;
    *fate = CLI_TOPOLOGY_GEAR;
    for (int i = 0; st == LW_OK && gears == 1 && i < mk->w->n_ratio; i++) {
        cli_topology_fate now;
        mk->ratio = &mk->w->ratio[i];
        st = add_pair(mk, m, &now);
        now = now == CLI_TOPOLOGY_NO_PLAN ? CLI_TOPOLOGY_GEAR : now;
        if (*fate != CLI_TOPOLOGY_FITTED && now != CLI_TOPOLOGY_GEAR)
            *fate = now;
    }
    mk->ratio = NULL;
    return st;
}

static lw_status visit_variant(maker *mk, const lw_mechanism *m)
{
    cli_topology_fate fate;
    int gears = 0;
    for (int j = 0; j < m->n_joint; j++)
        gears += m->kind[j] == 'g';
    lw_status st = gears ? add_geared(mk, m, gears, &fate) : add_pair(mk, m, &fate);
    mk->to->n_pair++;
    mk->to->fate[fate]++;
    return st == LW_OK ? lw_inputs_each(m, 1, false, count_input, mk) : st;
}

/* Is this choice of slots, up to symmetry, one of those before? */
static bool seen(maker *mk, const lw_mechanism *m, lw_graph *form, int n)
{
    lw_linkage k;
    if (sketch(mk, m, &k) != LW_OK || !canonical(&k, &form[n]))
        return false;
    for (int i = 0; i < n; i++)
        if (memcmp(&form[i], &form[n], sizeof *form) == 0)
            return true;
    return false;
}

/* Each pin in a slot both ways: the slot on the one link, the pin on the other. */
static lw_status visit_pair(void *context, const lw_mechanism *m)
{
    maker *mk = context;
    int slots = 0, n = 0;
    lw_status st = LW_OK;
    for (int j = 0; j < m->n_joint; j++)
        slots += m->kind[j] == 'p';
    lw_graph *form = malloc(sizeof *form << slots);
    if (!form)
        return LW_E_MEMORY;
    for (mk->turned = 0; st == LW_OK && mk->turned < 1u << slots; mk->turned++)
        if (slots == 0 || !seen(mk, m, form, n)) {
            n++;
            st = visit_variant(mk, m);
        }
    free(form);
    mk->turned = 0;
    return st;
}

/* ---- the other way ---------------------------------------------------------------------------------- */

bool cli_topologies_name(void *topologies, const lw_linkage *k, char *name, size_t size)
{
    const cli_topologies *t = topologies;
    lw_graph want, have;
    if (!canonical(k, &want))
        return true;
    for (int i = 0; i < t->n; i++)
        for (int f = 0; t->stage[i].links == k->n_link && f < t->stage[i].n_family; f++)
            if (canonical(t->stage[i].linkage[f], &have) && memcmp(&want, &have, sizeof want) == 0) {
                const char *given = t->stage[i].name[f], *cut = strstr(given, ", input");
                snprintf(name, size, "%.*s", cut ? (int)(cut - given) : (int)strlen(given), given);
                return true;
            }
    return t->wish_all;
}

/* ---- a number of links ------------------------------------------------------------------------------------ */

static lw_status visit_chain(void *context, const lw_chain *c)
{
    maker *mk = context;
    lw_mechanism m;
    lw_mechanism_steps steps = { .ground = true, .kinds = mk->w->kinds, .output = true };
    lw_status st = lw_mechanism_from_chain(c, &m);
    mk->chain++;
    return st == LW_OK ? lw_mechanisms_each(&m, &steps, &mk->counts, visit_pair, NULL, mk) : st;
}

/* Chains with so many links of which n2 joints have two freedoms (Makkonen 1999, eq. 2, with F = 1). */
static lw_status visit_chains(maker *mk, int links, int n2)
{
    int twice = 3*(links - 1) - 1 - n2;
    mk->n2 = n2;
    mk->chain = 0;
    if (twice < 2 || twice % 2 || twice/2 + n2 > links*(links - 1)/2)
        return LW_OK;
    return lw_higher_each(links, 1, n2, 1, visit_chain, mk, &mk->e);
}

/* Those of pins and sliders alone (higher false), or those with slots and gears. */
static lw_status make_stage(maker *mk, int links, bool higher)
{
    lw_status st = LW_OK;
    cli_topology_stage *to = mk->to;
    mk->counts = (lw_mechanism_counts){ 0 };
    to->links = links;
    to->higher = higher;
    for (int n2 = higher; st == LW_OK && (n2 == 0 || (higher && links + n2 <= CLI_TOPOLOGY_EXPANDED)); n2++)
        st = visit_chains(mk, links, n2);
    to->n_chain = (long)mk->counts.n_chain;
    to->n_ground = (long)mk->counts.n_ground;
    to->n_labelled = (long)mk->counts.n_labelled;
    for (int i = 0; i < to->n_family; i++)
        to->family[i] = (lw_family){ .name = to->name[i], .linkage = to->linkage[i], .links = links };
    return st;
}

static lw_status read_ratio(const char *word, cli_ratio *r, lw_error *e)
{
    char *end, *over = NULL;
    double a = strtod(word, &end), b = 1;
    if (*end == '/')
        b = strtod(end + 1, &over);
    end = over ? over : end;
    r->value = a/b;
    snprintf(r->text, sizeof r->text, "%s", word);
    bool whole = a == round(a) && b == round(b) && fabs(a) >= 1 && fabs(b) >= 1 && fabs(a) <= LW_LAP_MAX
              && fabs(b) <= LW_LAP_MAX;
    if (end != word && *end == 0 && whole && (!over || over != word))
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "--gear-ratios takes whole numbers and fractions of whole numbers up to %d with commas "
                        "between, as -1,2,-1/2; '%s' is none", LW_LAP_MAX, word);
}

lw_status cli_ratios_read(const char *text, cli_ratio *ratio, int *n, lw_error *e)
{
    lw_status st = LW_OK;
    *n = 0;
    for (const char *at = text; st == LW_OK && *at; ) {
        char word[12] = "";
        size_t length = strcspn(at, ",");
        if (*n == CLI_RATIO_MAX)
            return lw_error_set(e, LW_E_ARG, "--gear-ratios takes %d ratios at most", CLI_RATIO_MAX);
        snprintf(word, sizeof word, "%.*s", (int)length, at);
        st = read_ratio(word, &ratio[*n], e);
        ++*n;
        at += length + (at[length] == ',');
    }
    return st == LW_OK && *n == 0 ? lw_error_set(e, LW_E_ARG, "--gear-ratios is empty") : st;
}

static lw_status check_names(const maker *mk, lw_error *e)
{
    int k = 0;
    for (const char *at = mk->w->only; strcmp(mk->w->only, "all") != 0 && *at; k++) {
        size_t n = strcspn(at, ",");
        if (k < 64 && !mk->met[k])
            return lw_error_set(e, LW_E_ARG, "--topology: nothing up to %d links is called '%.*s'; there are watt1, "
                                "watt2, stephenson1, stephenson2, stephenson3, chains by links and number as 8.5, and by links, "
                                "number of slots and gears, and number as 5.1.2", mk->w->links, (int)n, at);
        at += n + (at[n] == ',');
    }
    return LW_OK;
}

bool cli_topology_higher(const char *kinds)
{
    return strpbrk(kinds, "pg") != NULL;
}

/* A stage that holds nothing to count is none. */
static lw_status add_stage(maker *mk, cli_topologies *t, int links, bool higher)
{
    if (t->n == LW_STAGE_MAX)
        return LW_OK;
    mk->to = &t->stage[t->n];
    lw_rng_seed(&mk->rng, 1, (uint64_t)links);
    lw_status st = make_stage(mk, links, higher);
    t->n += mk->to->n_chain > 0;
    return st;
}

lw_status cli_topologies_make(const cli_topology_wish *w, cli_topologies *t, lw_error *e)
{
    maker *mk = calloc(1, sizeof *mk);
    lw_status st = mk ? LW_OK : LW_E_MEMORY;
    memset(t, 0, sizeof *t);
    if (mk)
        mk->w = w;
    t->wish_all = strcmp(w->only, "all") == 0;
    for (int links = 6; links <= w->links; links += 2)
        st = st == LW_OK ? add_stage(mk, t, links, false) : st;
    int most = w->links < CLI_TOPOLOGY_EXPANDED ? w->links : CLI_TOPOLOGY_EXPANDED - 1;
    if (!cli_topology_higher(w->kinds))
        most = 0;
    for (int links = 3; links <= most; links++)
        st = st == LW_OK ? add_stage(mk, t, links, true) : st;
    if (st == LW_OK)
        st = check_names(mk, e);
    else if (mk && mk->e.text[0])
        *e = mk->e;
    else
        lw_error_set(e, st, "out of memory");
    free(mk);
    if (st != LW_OK)
        cli_topologies_free(t);
    return st;
}

void cli_topologies_free(cli_topologies *t)
{
    for (int i = 0; i < t->n; i++) {
        cli_topology_stage *s = &t->stage[i];
        for (int k = 0; k < s->n_family; k++)
            free(s->linkage[k]);
        free(s->linkage);
        free(s->family);
        free(s->name);
    }
    memset(t, 0, sizeof *t);
}
