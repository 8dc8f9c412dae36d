#include "optimise/topology/staged_search.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "optimise/topology/grow.h"

enum {
    PARENTS = 4,            /* linkages of a stage that get a dyad                                  */
    CHILDREN = 24,          /* that they have in all, half of them the best one's                    */
    OF_EACH = 4,            /* candidates of every number of links that are kept, in case the best has a defect */
    NEAREST = 12            /* candidates whose distance from the target is looked at               */
};
#define SAME     1e-9       /* relative difference of the objectives of one linkage, or of cognates  */
#define ROUNDING 1e-20      /* objectives below this are not compared                                */
#define STRAY    0.02       /* sizes of the target that a curve may leave it beside 1.5 times its greatest error */

typedef struct grown {
    int            n;
    lw_family_made made[CHILDREN];
    lw_family      family[CHILDREN];
} grown;

/* ---- the starts of a stage ------------------------------------------------------------------------ */

/* The range of the inputs at the stations. */
static void used_range(const lw_target *t, const lw_candidate *c, double *first, double *last)
{
    *first = *last = c->input[0];
    for (size_t i = 1; i < t->n; i++) {
        *first = fmin(*first, c->input[i]);
        *last = fmax(*last, c->input[i]);
    }
}

/* LW_OK, with a child or without one, or LW_E_MEMORY. */
static lw_status grow_one(const lw_target *t, const lw_search_stage *stage, const lw_candidate *c, const lw_fit_report *r,
                     lw_rng *rng, grown *to)
{
    double first, last;
    lw_family_made *g = &to->made[to->n];
    char name[sizeof g->name];
    used_range(t, c, &first, &last);
    lw_status st = lw_linkage_grow(&r->linkage, c->intended.turns && r->turns, first, last, rng, &g->linkage);
    if (st != LW_OK)
        return st == LW_E_MEMORY ? st : LW_OK;
    snprintf(name, sizeof name, "%.40s with a dyad more", lw_family_title(c->family));
    if (stage->name && !stage->name(stage->context, &g->linkage, name, sizeof name))
        return LW_OK;
    snprintf(g->linkage.name, sizeof g->linkage.name, "%.*s", (int)sizeof g->linkage.name - 1, name);
    memcpy(g->name, name, sizeof name);
    to->family[to->n++] = (lw_family){ .name = g->name, .linkage = &g->linkage, .posture = true,
                                       .links = lw_candidate_links(c) + 2 };
    return LW_OK;
}

static bool changes_mode(const lw_target *t, const lw_candidate *c)
{
    size_t dyads = (size_t)c->n_dyad;
    for (size_t i = dyads; c->mode_of && i < t->n*dyads; i++)
        if (c->mode_of[i] != c->mode_of[i - dyads])
            return true;
    return false;
}

/* Add dyads to the best results with `links` links.  LW_OK or LW_E_MEMORY. */
static lw_status grow(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, const lw_fit *from,
                      int links, grown *to)
{
    int parents = 0;
    lw_status st = LW_OK;
    lw_rng rng;
    lw_fit_report *r = malloc(sizeof *r);
    lw_rng_seed(&rng, o->seed, 0x67726f77u + (uint64_t)links);
    for (int i = 0; r && i < from->n && parents < PARENTS && st != LW_E_MEMORY; i++) {
        const lw_candidate *c = &from->candidate[i];
        if (lw_candidate_links(c) != links || changes_mode(t, c)
            || (st = lw_fit_report_make(t, &o->spec, c, r, NULL)) != LW_OK || !r->verified)
            continue;
        int children = parents == 0 ? CHILDREN/2 : CHILDREN/(2*(PARENTS - 1));
        parents++;
        for (int k = 0; st == LW_OK && k < children && to->n < CHILDREN; k++)
            st = grow_one(t, stage, c, r, &rng, to);
    }
    free(r);
    return r && st != LW_E_MEMORY ? LW_OK : LW_E_MEMORY;
}

/* ---- the list of results --------------------------------------------------------------------------- */

static int by_objective(const void *a, const void *b)
{
    const lw_candidate *p = a, *q = b;
    if (p->beyond != q->beyond)
        return p->beyond - q->beyond;
    if (p->objective != q->objective)
        return p->objective < q->objective ? -1 : 1;
    return lw_candidate_links(p) - lw_candidate_links(q);
}

/* Move the candidates of one more stage to `all`. */
static lw_status merge(lw_fit *all, lw_fit *more)
{
    lw_candidate *list = realloc(all->candidate, sizeof *list*(size_t)(all->n + more->n + 1));
    if (!list)
        return LW_E_MEMORY;
    for (int i = 0; i < more->n; i++)
        list[all->n + i] = more->candidate[i];
    all->candidate = list;
    all->n += more->n;
    qsort(list, (size_t)all->n, sizeof *list, by_objective);
    all->starts += more->starts;
    all->improved += more->improved;
    all->evals += more->evals;
    all->rounds += more->rounds;
    all->seconds += more->seconds;
    all->stop = more->stop;
    if (more->skipped[0] && !all->skipped[0])
        memcpy(all->skipped, more->skipped, sizeof all->skipped);
    more->n = 0;                                         /* they belong to `all` now               */
    return LW_OK;
}

/* ---- stages ------------------------------------------------------------------------------------------ */

/* Keep the results of one search of a stage. */
static lw_status take(lw_staged_search *out, lw_stage_result *r, lw_fit *fit, lw_error *e)
{
    r->starts += fit->starts;
    r->improved += fit->improved;
    r->evals += fit->evals;
    r->stop = fit->stop;
    r->best = fit->n ? fmin(r->best, fit->candidate[0].objective) : r->best;
    if (!r->state) {
        r->state = fit->state;
        r->n_state = fit->n_state > 0 ? fit->n_state - r->n_grown : 0;
        fit->state = NULL;
    }
    lw_status st = merge(&out->fit, fit) == LW_OK ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for the results");
    lw_fit_free(fit);
    return st;
}

static bool can_stray(const lw_target *t, const lw_fit_spec *s)
{
    return t->closed && s->by_default & LW_LIMIT_MOTION && lw_task_has_place(s->task) && s->timing == LW_TIMING_FREE;
}

/* Does the curve of the linkage with `links` links and the least error leave the closed target between the stations?
 * Then a search without timing, which compares both ways, finds better ones. */
static lw_status strays(const lw_target *t, const lw_fit_spec *s, const lw_fit *all, int links, bool *out)
{
    const lw_candidate *best = NULL;
    *out = false;
    for (int i = 0; i < all->n && can_stray(t, s); i++)
        if (lw_candidate_links(&all->candidate[i]) == links
            && (!best || all->candidate[i].objective < best->objective))
            best = &all->candidate[i];
    lw_fit_report *r = best ? malloc(sizeof *r) : NULL;
    lw_status st = !best ? LW_OK : r ? lw_fit_report_make(t, s, best, r, NULL) : LW_E_MEMORY;
    *out = best && st == LW_OK && r->stray.to_target > 1.5*r->error_max + STRAY*t->size;
    free(r);
    return st;
}

/* Run the searches of a stage: of four-link types the cranks, then the others; then once more if the best curve strays.
 * Each gets an equal part of the time that is left. */
static lw_status run_searches(const lw_target *t, lw_fit_options *o, int links, double seconds, lw_stage_result *r,
                              lw_staged_search *out, lw_error *e)
{
    enum { BOTH_WAYS = 2 };
    double end = lw_clock_wall() + seconds;
    bool whole = o->families || o->spec.exclude_drag_link, stopped = false, any = false, again = false;
    lw_status st = LW_OK;
    for (int i = whole ? 1 : 0; i <= BOTH_WAYS; i++) {
        lw_fit fit;
        lw_error why = { .text = "" };
        if (i == BOTH_WAYS && (st = strays(t, &o->spec, &out->fit, links, &again)) != LW_OK)
            return st;
        if (i == BOTH_WAYS && !again)
            break;
        o->part = whole || i == BOTH_WAYS ? LW_FIT_WHOLE : i == 0 ? LW_FIT_CRANKS : LW_FIT_OTHERS;
        o->both_ways = i == BOTH_WAYS;
        o->max_seconds = seconds > 0 ? fmax(1e-3, (end - lw_clock_wall())/(BOTH_WAYS - i + can_stray(t, &o->spec))) : 0;
        st = lw_fit_run(t, o, &fit, &why);
        if (st == LW_E_ARG && i == 1 && !whole && !any) {        /* no type can turn: this says it, or gives way */
            o->part = LW_FIT_WHOLE;
            st = lw_fit_run(t, o, &fit, &why);
        }
        bool found = st >= 0;
        if (found && take(out, r, &fit, e) != LW_OK)
            return LW_E_MEMORY;
        stopped |= st == LW_STOPPED;
        any |= found;
        if (!found && !(st == LW_E_ARG && !whole && (i == 0 || any))) {
            if (e)
                *e = why;
            return st;
        }
        if (st == LW_STOPPED && o->interrupt && *o->interrupt)
            break;
    }
    return stopped ? LW_STOPPED : LW_OK;
}

/* Is one of the linkages found near enough to the target to leave a stage out? */
static lw_status is_enough(const lw_target *t, const lw_fit_spec *s, double unless, const lw_fit *all, bool *enough)
{
    lw_fit_report *r = malloc(sizeof *r);
    lw_status st = r ? LW_OK : LW_E_MEMORY;
    *enough = false;
    for (int i = 0; i < all->n && i < NEAREST && !*enough && st == LW_OK && all->candidate[i].beyond == 0; i++) {
        st = lw_fit_report_make(t, s, &all->candidate[i], r, NULL);
        *enough = st == LW_OK && r->verified && !r->broken && lw_fit_report_misses(t, r) <= unless;
        st = st == LW_E_MEMORY ? st : LW_OK;
    }
    free(r);
    return st;
}

static lw_status run_stage(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, int before,
                           double seconds, lw_staged_search *out, lw_error *e)
{
    lw_fit_options mine = *o;
    lw_stage_result *r = &out->stage[out->n_stage++];
    grown *more = calloc(1, sizeof *more);
    *r = (lw_stage_result){ .links = stage->links, .best = INFINITY };
    bool grows = stage->families.make && before > 0 && !lw_task_has_angle(o->spec.task);
    if (!more || (grows && grow(t, o, stage, &out->fit, before, more) != LW_OK)) {
        free(more);
        return lw_error_set(e, LW_E_MEMORY, "no memory for linkages to grow");
    }
    r->n_grown = more->n;
    lw_families_pair pair = { stage->families, lw_families_of(more->family, more->n) };
    lw_families all = lw_families_join(&pair);
    double start = lw_clock_wall();
    mine.families = stage->families.make ? &all : NULL;
    mine.budget = stage->budget > 0 ? stage->budget : o->budget;
    lw_status st = run_searches(t, &mine, stage->links, seconds, r, out, e);
    r->seconds = lw_clock_wall() - start;
    free(more);
    return st;
}

/* Is it the same linkage, or a cognate: as many links and the same error to rounding? */
static bool same(const lw_candidate *a, const lw_candidate *b)
{
    return lw_candidate_links(a) == lw_candidate_links(b)
        && fabs(a->objective - b->objective) <= SAME*b->objective && b->objective > ROUNDING;
}

/* Keep `most` candidates, and `each` of every number of links. */
static void shorten(lw_staged_search *s, int most, int each)
{
    lw_fit *f = &s->fit;
    int n = 0;
    int seen[LW_LINK_MAX + 1] = { 0 };
    for (int i = 0; i < f->n; i++) {
        lw_candidate *c = &f->candidate[i];
        int links = lw_candidate_links(c);
        if ((n < most || seen[links] < each) && (n == 0 || !same(c, &f->candidate[n - 1]))) {
            f->candidate[n++] = *c;
            seen[links]++;
        } else {
            lw_candidate_free(c);
        }
    }
    f->n = n;
}

/* Part of the time that is left for stage i of n: more links take longer and gain more, as the square of the links beyond
 * two.  A stage that ends earlier leaves its time to the others. */
static double part_of_time(const lw_search_stage *stage, int i, int n)
{
    double mine = 1, all = 0;
    for (int k = i; k < n; k++) {
        double part = stage[k].unless > 0 ? 4 : (stage[k].links - 2.0)*(stage[k].links - 2.0);    /* as four links */
        mine = k == i ? part : mine;
        all += part;
    }
    return all > 0 ? mine/all : 1;
}

lw_status lw_staged_search_run(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, int n_stage,
                               lw_staged_search *out, lw_error *e)
{
    lw_status st = LW_OK;
    double start = lw_clock_wall();
    memset(out, 0, sizeof *out);
    for (int i = 0; i < n_stage && i < LW_STAGE_MAX; i++) {
        double left = o->max_seconds - (lw_clock_wall() - start);
        bool enough = false;
        if (stage[i].unless > 0 && is_enough(t, &o->spec, stage[i].unless, &out->fit, &enough) != LW_OK) {
            lw_staged_search_free(out);
            return lw_error_set(e, LW_E_MEMORY, "no memory for a report");
        }
        if (enough)
            break;
        lw_status now = run_stage(t, o, &stage[i], i > 0 ? stage[i].links - 2 : 0,
                                  o->max_seconds > 0 ? fmax(left*part_of_time(stage, i, n_stage), 1e-3) : 0, out, e);
        if (now < 0 && now != LW_E_KIND) {
            lw_staged_search_free(out);
            return now;
        }
        st = now == LW_STOPPED ? now : st;
        if (now == LW_STOPPED && o->interrupt && *o->interrupt)
            break;
    }
    shorten(out, 2*lw_fit_kept(o), o->spec.by_default ? 2*lw_fit_kept(o) : OF_EACH);
    return st == LW_OK && out->fit.n == 0 ? LW_NOTHING : st;
}

void lw_staged_search_free(lw_staged_search *s)
{
    lw_fit_free(&s->fit);
    for (int i = 0; i < s->n_stage; i++)
        free(s->stage[i].state);
    memset(s, 0, sizeof *s);
}
