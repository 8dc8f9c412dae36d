/* Describe a plan as text. */
#include "base/number.h"
#include "mbs/plan/plan_internal.h"

#include "grammar/text/text_internal.h"
#include "grammar/topology/circuit.h"

/* A group: its links, the links solved before it, its order and class. */
typedef struct group_text { uint32_t links, before; int order, n_class; } group_text;

static bool touches(const lw_linkage *linkage, int j, uint32_t links)
{
    return links >> linkage->joint[j].link[0] & 1 || links >> linkage->joint[j].link[1] & 1;
}

/* The order is the number of joints to links solved before.  The class is the larger of two numbers: the most joints
 * inside the group on one link, and the length of the longest loop of links.  A dyad is of class II. */
static void classify(const lw_linkage *linkage, group_text *t)
{
    int number[LW_LINK_MAX], inner[LW_LINK_MAX] = { 0 }, n = 0;
    uint32_t row[LW_LINK_MAX] = { 0 };
    lw_chain_circuits c;
    for (int i = 0; i < linkage->n_link; i++)
        number[i] = t->links >> i & 1 ? n++ : -1;
    for (int j = 0; j < linkage->n_joint; j++) {
        int a = linkage->joint[j].link[0], b = linkage->joint[j].link[1];
        if (number[a] >= 0 && number[b] >= 0) {
            row[number[a]] |= 1u << number[b];
            row[number[b]] |= 1u << number[a];
            inner[number[a]]++;
            inner[number[b]]++;
        } else if (touches(linkage, j, t->links))
            t->order += t->before >> (number[a] >= 0 ? b : a) & 1;
    }
    t->n_class = n == 1 ? 1 : 2;
    for (int i = 0; n > 2 && i < n; i++)
        t->n_class = inner[i] > t->n_class ? inner[i] : t->n_class;
    if (n > 2 && lw_circuit_basis(n, row, &c) == LW_OK)
        for (int i = 0; i < c.n_circuit; i++)
            if (c.first[i + 1] - c.first[i] > t->n_class)
                t->n_class = c.first[i + 1] - c.first[i];
}

static void add_group(lw_text *out, const lw_linkage *linkage, group_text *t, int number)
{
    static const char *const roman[] = { "", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X" };
    classify(linkage, t);
    lw_text_add(out, "%d. group of class ", number);
    if (t->n_class <= 10)
        lw_text_add(out, "%s", roman[t->n_class]);
    else
        lw_text_add(out, "%d", t->n_class);
    lw_text_add(out, ", order %d: links", t->order);
    for (int i = 0; i < linkage->n_link; i++)
        if (t->links >> i & 1)
            lw_text_add(out, " \"%s\"", linkage->link_name[i]);
    lw_text_add(out, ", joints");
    for (int j = 0; j < linkage->n_joint; j++) {
        uint32_t pair = 1u << linkage->joint[j].link[0] | 1u << linkage->joint[j].link[1];
        if (pair & t->links && !(pair & ~(t->links | t->before)))
            lw_text_add(out, " \"%s\"", linkage->joint[j].name);
    }
}

static void add_wheel(lw_text *out, lw_step_kind kind, const lw_joint *by)
{
    lw_text_add(out, "; %s by %s \"%s\"\n", kind == LW_STEP_RACK ? "moved" : "turned",
                lw_joint_has_ratio(by->kind) ? "gear" : "the tied input", by->name);
}

static void add_dyad(lw_text *out, const lw_step *s)
{
    static const char *const name[] = { [LW_STEP_RRR] = "RRR", [LW_STEP_RRP] = "RRP", [LW_STEP_RPR] = "RPR",
                                        [LW_STEP_PRP] = "PRP", [LW_STEP_PPR] = "PPR" };
    bool two = s->kind == LW_STEP_RRR || s->kind == LW_STEP_RRP || s->kind == LW_STEP_RPR;
    lw_text_add(out, "; dyad %s in closed form, %s\n", name[s->kind], two ? "two assemblies" : "one assembly");
}

static void add_higher(lw_text *out, const lw_higher *g)
{
    lw_text_add(out, "; Newton's method with %d unknown%s (%d turn%s, %d displacement%s) on %d loop%s", g->n_unknown,
                lw_plural(g->n_unknown), g->n_turn, lw_plural(g->n_turn), g->n_disp,
                lw_plural(g->n_disp), g->n_loop, lw_plural(g->n_loop));
    if (g->n_gear)
        lw_text_add(out, " and %d gear%s", g->n_gear, lw_plural(g->n_gear));
    lw_text_add(out, "\n");
}

/* The gear by which a step makes *link known; -1 when the step is of another kind. */
static int gear_of(const lw_plan *p, const lw_step *s, int *link)
{
    bool gear = (s->kind == LW_STEP_GEAR && s->dim[0] >= 0) || s->kind == LW_STEP_ROLL || s->kind == LW_STEP_RACK;
    if (!gear)
        return -1;
    const lw_dim_info *d = &p->dim[s->dim[0]];
    *link = d->link;
    for (int r = 0; s->kind == LW_STEP_ROLL && r < p->n_rack; r++)
        if (p->rack[r].joint == d->joint)
            *link = p->rack[r].pinion;
    return d->joint;
}

static void add_left_out(lw_text *out, const lw_plan *p, const lw_linkage *linkage, uint32_t known)
{
    int n = 0;
    for (int i = 0; i < linkage->n_link; i++)
        if (!(known >> i & 1))
            lw_text_add(out, "%s \"%s\"", n++ ? "" : "left out, as no output needs them: links", linkage->link_name[i]);
    for (int j = 0; n && j < linkage->n_joint; j++) {
        uint32_t pair = 1u << linkage->joint[j].link[0] | 1u << linkage->joint[j].link[1];
        if (pair & ~known)
            lw_text_add(out, "%s \"%s\"", n > 0 ? ", joints" : "", linkage->joint[j].name), n = -1;
    }
    lw_text_add(out, n ? "\n" : "nothing is left out\n");
    lw_text_add(out, "%d dimensions, %d numbers of assembly, %d steps\n", p->n_dim, p->n_mode, p->n_step);
}

size_t lw_plan_explain(const lw_plan *p, const lw_linkage *given, char *buf, size_t size)
{
    lw_linkage k;
    lw_text out = lw_text_start(buf, size);
    if (lw_plan_expand(given, &k, NULL, NULL) != LW_OK)
        return out.length;
    const char *from = k.link_name[p->input_link[0]], *to = k.link_name[p->input_link[1]];
    bool at_ground = p->input_link[0] == k.ground;
    uint32_t known = 1u << k.ground;
    int number = 1;
    lw_text_add(&out, "input: joint \"%s\" %s link \"%s\" against \"%s\"%s\n", k.joint[p->input_joint].name,
                p->input_is_slider ? "moves" : "turns", to, from, at_ground ? "" : ", inside a group");
    if (at_ground)
        known |= 1u << p->input_link[1];
    for (int i = 0; i < p->n_step; i++) {
        const lw_step *s = &p->step[i];
        group_text t = { .before = known };
        int wheel;
        if (s->kind == LW_STEP_HIGHER)
            for (int l = 0; l < p->higher[s->dim[0]].n_link; l++)
                t.links |= 1u << p->higher[s->dim[0]].link[l];
        else if (gear_of(p, s, &wheel) >= 0)
            t.links = 1u << wheel;
        else if (s->dyad >= 0)
            t.links = 1u << p->dyad[s->dyad].link[0] | 1u << p->dyad[s->dyad].link[1];
        if (!t.links)
            continue;
        add_group(&out, &k, &t, number++);
        if (s->kind == LW_STEP_HIGHER)
            add_higher(&out, &p->higher[s->dim[0]]);
        else if (gear_of(p, s, &wheel) >= 0)
            add_wheel(&out, s->kind, &k.joint[gear_of(p, s, &wheel)]);
        else
            add_dyad(&out, s);
        known |= t.links;
    }
    add_left_out(&out, p, &k, known);
    return out.length;
}
