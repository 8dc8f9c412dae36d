#include "optimise/topology/topology_search.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/number.h"
#include "base/real.h"
#include "optimise/topology/point_links.h"

enum { LINKS_MAX = 10 };
#define COUNT_TIME 0.5       /* of a time limit, for counting mechanisms before any is searched              */

/* The topologies and targets of a search. */
typedef struct plan {
    lw_mechanism_set set;
    int              n_start;
    lw_linkage      *start;                         /* copies, with names              (n_start)    */
    lw_family       *start_family;                  /* by rising number of links       (n_start)    */
    int              n_stage;
    lw_search_stage  stage[LW_STAGE_MAX];
    lw_families_pair pair[LW_STAGE_MAX];            /* mechanisms and starts of a stage             */
    lw_point_links   points[LW_STAGE_MAX];          /* of a target with several points              */
    int              pins[LW_STAGE_MAX];            /* stage of the search for the mechanisms of pins of each stage of
                                                     * `set`; -1: there is none                     */
    int              others[LW_STAGE_MAX];          /* the same for those with other joints         */
} plan;

lw_topology_search_options lw_topology_search_options_default(void)
{
    return (lw_topology_search_options){ .fit = lw_fit_options_default(), .freedoms = 1, .joints = "r",
                                         .topologies = "all", .gear_ratios = LW_DEFAULT_GEAR_RATIOS,
                                         .input_ratios = LW_DEFAULT_INPUT_RATIOS };
}

/* ---- starts ---------------------------------------------------------------------------------------------- */

lw_status lw_start_check(const lw_linkage *linkage, lw_error *e)
{
    int own = lw_linkage_free_inputs(linkage);
    const char *tied = own > 1 ? ", beside those tied to it by a ratio," : "";
    if (own == 1 && linkage->n_tracer > 0)
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "a linkage to start from has one input%s and a tracer; \"%.40s\" has %d input%s "
                        "and %d tracer%s", tied, linkage->name, own, lw_plural(own), linkage->n_tracer, lw_plural(linkage->n_tracer));
}

static int by_links(const void *a, const void *b)
{
    const lw_family *p = a, *q = b;
    if (p->links != q->links)
        return p->links - q->links;
    return p->linkage < q->linkage ? -1 : p->linkage > q->linkage;
}

/* Make each starting linkage a family whose first start is the linkage itself. */
static lw_status make_starts(const lw_topology_search_options *o, plan *p, lw_error *e)
{
    size_t n = (size_t)o->n_start;
    p->start = malloc(sizeof *p->start*(n + 1));
    p->start_family = malloc(sizeof *p->start_family*(n + 1));
    if (!p->start || !p->start_family)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the linkages to start from");
    for (; p->n_start < o->n_start; p->n_start++) {
        lw_linkage *k = &p->start[p->n_start];
        *k = o->start[p->n_start];
        lw_status st = lw_start_check(k, e);
        if (st != LW_OK)
            return st;
        if (!k->name[0])
            memcpy(k->name, "linkage", sizeof "linkage");
        p->start_family[p->n_start] = (lw_family){ .name = k->name, .linkage = k, .posture = true, .links = k->n_link };
    }
    qsort(p->start_family, n, sizeof *p->start_family, by_links);
    return LW_OK;
}

static lw_families starts_with(const plan *p, int links)
{
    int first = 0, n = 0;
    while (first < p->n_start && p->start_family[first].links < links)
        first++;
    while (first + n < p->n_start && p->start_family[first + n].links == links)
        n++;
    return lw_families_of(p->start_family + first, n);
}

/* ---- stages ---------------------------------------------------------------------------------------------- */

/* A stage of mechanisms, starts, or both.  Returns its number, or -1: there are LW_STAGE_MAX. */
static int add_stage(plan *p, lw_families mechanisms, lw_families starts, int links)
{
    if (p->n_stage == LW_STAGE_MAX)
        return -1;
    lw_families_pair *pair = &p->pair[p->n_stage];
    *pair = (lw_families_pair){ mechanisms, starts };
    p->stage[p->n_stage] = (lw_search_stage){ .links = links, .families = lw_families_join(pair), .context = &p->set,
                                              .name = p->set.n > 0 ? lw_mechanism_set_name : NULL };
    return p->n_stage++;
}

static void make_stages(const lw_topology_search_options *o, plan *p)
{
    const lw_families none = lw_families_of(NULL, 0);
    const lw_mechanism_set *set = &p->set;
    if (o->freedoms == 1)                                /* so have the four-link types             */
        p->stage[p->n_stage++] = (lw_search_stage){ .links = 4 };
    for (int i = 0; i < set->n; i++)
        p->pins[i] = p->others[i] = -1;
    for (int links = 2; links <= LW_LINK_MAX; links++) {
        lw_families starts = starts_with(p, links);
        int own = 0;
        while (own < set->n && (set->stage[own].links != links || set->stage[own].two_freedoms))
            own++;
        if (own < set->n)
            p->pins[own] = add_stage(p, lw_mechanism_stage_pins(&set->stage[own]), starts, links);
        else if (starts.n > 0)
            add_stage(p, none, starts, links);
    }
    for (int two = 0; two < 2; two++)                    /* sliders, then slots and gears           */
        for (int i = 0; i < set->n; i++) {
            lw_families others = lw_mechanism_stage_others(&set->stage[i]);
            if (set->stage[i].two_freedoms == two && (two || others.n > 0))
                p->others[i] = add_stage(p, others, none, set->stage[i].links);
        }
}

/* Replace the families of each stage by one for each choice of links for the target's further points. */
static lw_status choose_point_links(const lw_target *t, const lw_fit_spec *s, plan *p, lw_error *e)
{
    for (int i = 0; i < p->n_stage && t->n_also > 0; i++) {
        if (!p->stage[i].families.make)
            continue;
        lw_status st = lw_point_links_make(&p->stage[i].families, t, s, &p->points[i], e);
        if (st != LW_OK)
            return st;
        p->stage[i].families = lw_point_links_families(&p->points[i]);
    }
    return LW_OK;
}

static lw_status make_set(const lw_topology_search_options *o, int links, double start, plan *p, lw_error *e)
{
    const lw_fit_spec *s = &o->fit.spec;
    char kinds[5] = "";
    for (const char *at = o->joints; *at; at++)
        if (*at != ',' && !lw_joint_freedoms(*at))
            return lw_error_set(e, LW_E_ARG, "joints are r, t, p and g, with or without commas, not '%s'", o->joints);
        else if (*at != ',' && !strchr(kinds, *at))
            kinds[strlen(kinds)] = *at;
    lw_mechanism_request r = { .links = links, .dof = o->freedoms, .kinds = kinds, .only = o->topologies,
                               .task = s->task,
                               .timed = !lw_task_has_place(s->task) || s->timing == LW_TIMING_PRESCRIBED,
                               .jobs = o->fit.jobs, .interrupt = o->fit.interrupt };
    if (o->fit.max_seconds > 0 && !o->fit.sharing)       /* processes that share the work search the same stages */
        r.until = start + COUNT_TIME*o->fit.max_seconds;
    lw_status st = lw_ratio_list_read("gear_ratios", o->gear_ratios, &r.ratio.gear, e);
    if (st == LW_OK)
        st = lw_ratio_list_read("input_ratios", o->input_ratios, &r.ratio.tie, e);
    if (st != LW_OK)
        return st;
    if (links > 4 || lw_kinds_have_two_freedoms(kinds))
        return lw_mechanism_set_make(&r, &p->set, e);
    if (strcmp(o->topologies, "all") != 0)
        return lw_error_set(e, LW_E_ARG, "topology '%s' has more than four links; say how many with --links, or with "
                            "\"links\" in a task file", o->topologies);
    return LW_OK;
}

/* Are six links searched if four do not stay near the target?  Not where a pin alone moves the body so. */
static bool may_go_on(const lw_target *t, const lw_topology_search_options *o)
{
    const lw_fit_spec *s = &o->fit.spec;
    lw_vec2 pivot;
    double off;
    return o->more && !lw_pin_does(t, s, &pivot, &off) && o->links == 0 && o->freedoms == 1 && s->by_default
        && strcmp(o->joints, "r") == 0 && strcmp(o->topologies, "all") == 0 && strcmp(o->fit.types, "fourbar") == 0;
}

/* Is a point moved to and fro on a line at given times?  That is what a slider-crank is built for. */
static bool is_timed_stroke(const lw_target *t, const lw_fit_spec *s)
{
    return s->task == LW_TASK_PATH && s->timing == LW_TIMING_PRESCRIBED && t->n_also == 0 && lw_target_straight(t) <= LW_STRAIGHT*t->extent;
}

static lw_status make_plan(const lw_target *t, const lw_topology_search_options *o, double start, plan *p, lw_error *e)
{
    if (o->freedoms < 1 || o->freedoms > LW_PACKED_INPUT_MAX)
        return lw_error_set(e, LW_E_ARG, "mechanisms have 1 to %d degrees of freedom, not %d", LW_PACKED_INPUT_MAX, o->freedoms);
    int least = lw_mechanism_least_links(o->freedoms), links = o->links > 0 ? o->links : may_go_on(t, o) ? 6 : least;
    if (links < least || links > LINKS_MAX)
        return lw_error_set(e, LW_E_ARG, "with %d degrees of freedom mechanisms have %d to %d links, not %d",
                            o->freedoms, least, LINKS_MAX, links);
    lw_status st = make_set(o, links, start, p, e);
    if (st == LW_OK)
        st = make_starts(o, p, e);
    if (st != LW_OK)
        return st;
    make_stages(o, p);
    if (p->n_stage == 0 && p->set.uncounted > 0)
        return lw_error_set(e, LW_NOTHING, "the time ended while mechanisms were still counted: none was searched; give it longer, or fewer links");
    for (int i = 1; i < p->n_stage && may_go_on(t, o); i++)
        p->stage[i].unless = t->n > LW_FEW_STATIONS ? LW_ENOUGH : LW_GOOD;
    return choose_point_links(t, &o->fit.spec, p, e);
}

static void plan_free(plan *p)
{
    lw_mechanism_set_free(&p->set);
    free(p->start);
    free(p->start_family);
    for (int i = 0; i < p->n_stage; i++)
        lw_point_links_free(&p->points[i]);
    free(p);
}

/* ---- what came of it ------------------------------------------------------------------------------------- */

static void sum_links(const plan *p, lw_topology_search *out)
{
    for (int links = 1; links <= LW_LINK_MAX; links++) {
        lw_links_summary *s = &out->by_links[out->n_links];
        bool any = false;
        *s = (lw_links_summary){ .links = links, .best = -1 };
        for (int i = 0; i < p->n_stage; i++) {
            if (p->stage[i].links != links)
                continue;
            any = true;
            s->n_point_choice += p->points[i].n;
            if (i >= out->found.n_stage)
                continue;
            const lw_stage_result *r = &out->found.stage[i];
            s->n_stage++;
            s->n_grown += r->n_grown;
            s->starts += r->starts;
            s->improved += r->improved;
            s->seconds += r->seconds;
        }
        const lw_candidate *c = out->found.fit.candidate;
        const int *of = out->results.candidate;
        for (int i = 0; i < out->results.n; i++)
            if (lw_candidate_links(&c[of[i]]) <= links && (s->best < 0 || c[of[i]].objective < c[of[s->best]].objective))
                s->best = i;
        out->n_links += any;
    }
}

/* The states of the first n families of a stage of the search, or of all its choices of links for further points. */
static void count_states(const plan *p, const lw_topology_search *out, int stage, int n, long state[LW_FIT_STATES])
{
    const lw_stage_result *r = stage >= 0 && stage < out->found.n_stage ? &out->found.stage[stage] : NULL;
    n = stage >= 0 && p->points[stage].n_point > 0 ? p->points[stage].n : n;
    for (int i = 0; i < n; i++)
        state[r && i < r->n_state ? r->state[i] : LW_FIT_UNREACHED]++;
}

static void sum_mechanisms(const plan *p, lw_topology_search *out)
{
    out->n_input_ratio = p->set.ratio.tie.n;
    out->n_mechanisms = out->found.n_stage < p->n_stage && p->stage[out->found.n_stage].unless > 0 ? 0 : p->set.n;
    for (int i = 0; i < out->n_mechanisms; i++) {
        const lw_mechanism_stage *from = &p->set.stage[i];
        lw_mechanism_summary *s = &out->mechanisms[i];
        *s = (lw_mechanism_summary){ .links = from->links, .two_freedoms = from->two_freedoms, .tally = from->tally };
        count_states(p, out, p->pins[i], from->n_pins, s->state);
        count_states(p, out, p->others[i], from->n_family - from->n_pins, s->state);
    }
}

/* [s] a station: what the second simulation of a result takes on a machine that is busy with other work, too */
#define STATION_TIME 6e-5

/* Search; of a time limit, part of which the plan has taken since `start`, leave some for the second simulations of the
 * results. */
static lw_status run_stages(const lw_target *t, const lw_topology_search_options *all, double start, const plan *p,
                            lw_staged_search *found, lw_error *e)
{
    const lw_fit_options *o = &all->fit;
    lw_fit_options mine = *o;
    if (may_go_on(t, all) && is_timed_stroke(t, &o->spec))
        mine.types = "fourbar,slidercrank";
    if (o->max_seconds > 0) {
        double kept = fmax(fmin(0.3, 0.05*o->max_seconds), fmin(STATION_TIME*t->n, 0.3*o->max_seconds));
        mine.max_seconds = fmax(1e-3, o->max_seconds - kept - (lw_clock_wall() - start));
    }
    return lw_staged_search_run(t, &mine, p->stage, p->n_stage, found, e);
}

lw_status lw_topology_search_run(const lw_target *t, const lw_topology_search_options *o, lw_topology_search *out, lw_error *e)
{
    memset(out, 0, sizeof *out);
    plan *p = calloc(1, sizeof *p);
    if (!p)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    const double start = lw_clock_wall();
    const lw_results_effort effort = { .jobs = o->fit.jobs, .interrupt = o->fit.interrupt,
                                       .until = o->fit.max_seconds > 0 ? start + o->fit.max_seconds : 0 };
    lw_status st = make_plan(t, o, start, p, e), kept = LW_OK;
    if (st == LW_OK)
        st = run_stages(t, o, start, p, &out->found, e);
    if (st == LW_OK || st == LW_STOPPED)
        kept = lw_fit_results_make(t, &o->fit.spec, &out->found.fit, o->fit.n_result, NULL, &effort, &out->results, e);
    if (kept == LW_OK)
        lw_fit_results_end(t, &out->found.fit, &out->results);
    out->uncounted_links = p->set.uncounted;
    if (kept == LW_OK && st == LW_OK && (out->results.n_unseen > 0 || out->uncounted_links > 0)) {
        st = LW_STOPPED;
        out->found.fit.stop = o->fit.interrupt && *o->fit.interrupt ? LW_STOP_USER : LW_STOP_TIME;
    }
    st = kept == LW_OK ? st : kept;
    if (st == LW_OK || st == LW_STOPPED) {
        out->freedoms = o->freedoms;
        sum_links(p, out);
        sum_mechanisms(p, out);
    } else {
        if (st == LW_NOTHING && out->found.n_stage > 0)
            lw_error_set(e, st, "no linkage of these types within these bounds and conditions was found; widen the "
                         "bounds or allow more types");
        lw_topology_search_free(out);
        out->uncounted_links = p->set.uncounted;
    }
    plan_free(p);
    return st;
}

void lw_topology_search_free(lw_topology_search *s)
{
    lw_staged_search_free(&s->found);
    lw_fit_results_free(&s->results);
    memset(s, 0, sizeof *s);
}
