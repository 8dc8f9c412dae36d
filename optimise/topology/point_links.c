#include "optimise/topology/point_links.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/growable_array.h"
#include "optimise/problem/tracers.h"

typedef struct choice {
    const lw_linkage  *linkage;                      /* of the family                                */
    const lw_target   *t;
    const lw_fit_spec *s;
    lw_point_links  *out;
    lw_point_choice   now;
    bool               partial[LW_LINK_MAX];         /* its motion depends on fewer links            */
} choice;

/* Does the motion of this link depend on fewer links than there are? */
static bool depends_on_fewer(const lw_linkage *linkage, int link, lw_plan *plan)
{
    lw_linkage alone = *linkage;
    lw_tracers_put(&alone, 0, link);
    return lw_plan_make(&alone, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_HIGHER }, plan, NULL) == LW_OK
        && plan->n_link < linkage->n_link;
}

/* May point i (0: the first) lie on this link? */
static bool suits(const choice *c, int i, int link)
{
    const lw_linkage *k = c->linkage;
    const lw_also *a = i > 0 ? &c->t->also[i - 1] : NULL;
    lw_carrier is = lw_tracers_carrier(k, link), carrier = i > 0 ? c->s->carrier[i - 1] : LW_CARRIER_ANY;
    bool place = a ? a->x != NULL : lw_task_has_place(c->s->task);
    bool angle = a ? a->theta != NULL : lw_task_has_angle(c->s->task);
    if (link == k->ground || (angle && lw_tracers_only_slides(k, link)))
        return false;
    if (i == 0 && link != k->tracer[0].link && !c->partial[link])
        return false;
    if (carrier != LW_CARRIER_ANY)
        return is == carrier;
    return place ? is == LW_CARRIER_COUPLER || (i == 0 && link == k->tracer[0].link) : is != LW_CARRIER_INPUT;
}

static lw_status add_choice(choice *c)
{
    lw_point_links *s = c->out;
    if (s->n == LW_POINT_CHOICE_MAX)
        return LW_E_ARG;
    lw_point_choice *more = lw_array_grow(s->choice, s->n, &s->capacity, sizeof *more);
    if (!more)
        return LW_E_MEMORY;
    s->choice = more;
    s->choice[s->n++] = c->now;
    return LW_OK;
}

/* Choose links for point i and the points after it; met: a point lies on the link of the family's tracer. */
static lw_status choose(choice *c, int i, bool met)
{
    const lw_linkage *k = c->linkage;
    lw_status st = LW_OK;
    if (i > c->t->n_also || i > LW_ALSO_MAX)
        return met ? add_choice(c) : LW_OK;
    for (int l = 0; l < k->n_link && st == LW_OK; l++)
        if (suits(c, i, l)) {
            c->now.link[i] = (signed char)l;
            st = choose(c, i + 1, met || l == k->tracer[0].link);
        }
    return st;
}

static lw_status list_choices(choice *c, lw_plan *plan)
{
    const lw_linkage *k = c->linkage;
    c->now.link[0] = -1;
    if (k->n_tracer > c->t->n_also)
        return add_choice(c);
    for (int l = 0; l < k->n_link; l++)
        c->partial[l] = l != k->ground && depends_on_fewer(k, l, plan);
    return choose(c, 0, false);
}

lw_status lw_point_links_make(const lw_families *of, const lw_target *t, const lw_fit_spec *s, lw_point_links *out, lw_error *e)
{
    lw_plan *plan = malloc(sizeof *plan);
    lw_family_made *made = malloc(sizeof *made);
    lw_status st = plan && made ? LW_OK : LW_E_MEMORY;
    *out = (lw_point_links){ .of = *of, .n_point = 1 + t->n_also };
    for (int i = 0; i < of->n && st == LW_OK; i++) {
        choice c = { .linkage = &made->linkage, .t = t, .s = s, .out = out, .now.family = i };
        if ((st = of->make(of->of, i, made)) == LW_OK)
            st = list_choices(&c, plan);
    }
    free(made);
    free(plan);
    if (st == LW_OK)
        return LW_OK;
    lw_point_links_free(out);
    if (st == LW_E_MEMORY)
        return lw_error_set(e, st, "no memory for the choices of links");
    return lw_error_set(e, LW_E_ARG, "there are more than %d choices of links for %d points; say on which links "
                        "the further points lie (input, coupler, output), or search fewer topologies",
                        LW_POINT_CHOICE_MAX, 1 + t->n_also);
}

void lw_point_links_free(lw_point_links *s)
{
    free(s->choice);
    memset(s, 0, sizeof *s);
}

static lw_status make_choice(const void *of, int i, lw_family_made *made)
{
    const lw_point_links *s = of;
    const lw_point_choice *c = &s->choice[i];
    lw_linkage *k = &made->linkage;
    lw_status st = s->of.make(s->of.of, c->family, made);
    if (st != LW_OK)
        return st;
    made->name[strcspn(made->name, ",")] = 0;
    for (int p = 0; p < s->n_point && p <= LW_ALSO_MAX; p++) {
        int link = c->link[0] < 0 ? k->tracer[p].link : c->link[p];
        if (c->link[0] >= 0 && (p > 0 || link != k->tracer[0].link))
            lw_tracers_put(k, p, link);
        size_t at = strlen(made->name);
        snprintf(made->name + at, sizeof made->name - at, "%s%d", p == 0 ? ", points on links " : ", ", link + 1);
    }
    snprintf(k->name, sizeof k->name, "%.*s", (int)sizeof k->name - 1, made->name);
    return LW_OK;
}

static lw_turn turn_of_choice(const void *of, int i)
{
    const lw_point_links *s = of;
    return s->of.turn(s->of.of, s->choice[i].family);
}

lw_families lw_point_links_families(const lw_point_links *s)
{
    return (lw_families){ s->n, make_choice, turn_of_choice, s };
}
