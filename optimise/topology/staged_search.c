#include "optimise/topology/staged_search.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "optimise/report/results.h"
#include "optimise/topology/grow.h"

enum {
    PARENTS = 4,            /* linkages of a stage that get a dyad                                  */
    CHILDREN = 24,          /* that they have in all, half of them the best one's                    */
    AGAIN = 8,              /* linkages that a stage found before and starts from again              */
    FIRST = 10000,          /* evaluations of the first part of a stage in parts of fixed ends (in_ends) */
    FIRST_TIMED = 4,        /* under a time limit, the first part of a stage's budget: one in so many, ... */
    FIRST_TYPES = 32,       /* ... and of the rounds of four-link types: one so long that time cuts it finds no small linkages */
    UNLESS = 3,             /* ... of a stage with `unless`: so many times less, ...                 */
    ASKED = 16,             /* ... and with default limits of families whose number of links is asked for: more links are reached soon */
    ENOUGH = 30000,         /* evaluations of a stage in such parts after which it may end because the first row is good, ... */
    WELL = 300000,          /* ... or, unless stations are few, because of `unless`, or because it gains no more, ... */
    EXACT = 100000,         /* ... or because the target is met exactly: there may be smaller linkages */
    SMALL = 100000,         /* evaluations of a part, with default limits, below which only its last search makes a front */
    OF_EACH = 4,            /* candidates of every number of links that are kept, in case the best has a defect */
    ROWS = 24,              /* rows that the next search starts from, with default limits            */
    PARTS = 4,              /* small cranks have one of so many parts of a budget, and all others one, at first  */
    NEAREST = 12            /* candidates of each number of links that the first searches of a stage look at */
};
#define SAME     1e-9       /* relative difference of the objectives of one linkage, or of cognates  */
#define ROUNDING 1e-20      /* objectives below this are not compared                                */
#define NO_SMALLER 1.02      /* sizes that differ less are alike                                      */
#define LEAST_PART 0.02      /* of a time limit, that is worth another part of the search            */
#define POOR     0.05       /* a stage in parts of fixed ends goes on while the first row counts as more than this, ... */
#define GAIN     0.95       /* ... or as so many times what it did before the last part, or less     */
#define STRAY    0.02       /* sizes of the target that a curve may leave it beside 1.5 times its greatest error */

/* Linkages that a stage starts from. */
typedef struct starts {
    int            n;
    lw_family_made made[CHILDREN + AGAIN];
    lw_family      family[CHILDREN + AGAIN];
} starts;

/* One part of the search: a stage, for the first time or again. */
typedef struct stage_part {
    const lw_target       *t;
    const lw_fit_options  *o;        /* budget and rounds are those of the part                     */
    const lw_search_stage *stage;
    double                 end;      /* wall clock; 0: no limit                                     */
    bool                   grows;    /* from the best linkages with two links fewer, with a dyad added */
    bool                   in_part;  /* the stage has a larger budget than this part                */
    long                   left;     /* of that budget: a search that needs more is not begun       */
    lw_stage_result       *r;
    lw_staged_search      *out;
    lw_error              *e;
} stage_part;

/* ---- the starts of a stage ------------------------------------------------------------------------ */

/* LW_OK, with a child or without one; a failure of the name; LW_E_MEMORY. */
static lw_status grow_one(const lw_target *t, const lw_fit_spec *s, const lw_search_stage *stage, const lw_candidate *c,
                          const lw_fit_report *r, lw_rng *rng, starts *to)
{
    double first, last;
    lw_family_made *g = &to->made[to->n];
    char name[sizeof g->name];
    lw_fit_report_range(t, c, &first, &last);
    lw_status st = lw_linkage_grow(&r->linkage, c->intended.turns && r->turns, first, last, s->min_transmission, rng, &g->linkage);
    if (st != LW_OK)
        return st == LW_E_MEMORY ? st : LW_OK;
    snprintf(name, sizeof name, "%.40s with a dyad more", lw_family_title(c->family));
    st = stage->name ? stage->name(stage->context, &g->linkage, name, sizeof name) : LW_OK;
    if (st != LW_OK)
        return st == LW_NOTHING ? LW_OK : st;
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

/* The next row after `at` (-1: the first) with `links` links that a search can start from: in the order of the rows, or
 * by_error in the order of the candidates, which is that of their errors.  rows->n: there is none. */
static int next_row(const lw_target *t, const lw_fit *from, const lw_fit_results *rows, int links, bool by_error, int at)
{
    int next = rows->n;
    for (int i = by_error ? 0 : at + 1; i < rows->n; i++) {
        const lw_candidate *c = &from->candidate[rows->candidate[i]];
        if (lw_candidate_links(c) != links || changes_mode(t, c) || (by_error && at >= 0 && rows->candidate[i] <= rows->candidate[at]))
            continue;
        if (!by_error)
            return i;
        next = next == rows->n || rows->candidate[i] < rows->candidate[next] ? i : next;
    }
    return next;
}

/* Add dyads to the best results with two links less; part: how often the stage was searched before.  LW_OK or LW_E_MEMORY. */
static lw_status grow(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, const lw_fit *from,
                      const lw_fit_results *rows, int part, starts *to)
{
    int parents = 0, links = stage->links - 2;
    bool by_error = part == 0;
    lw_status st = LW_OK;
    lw_rng rng;
    lw_rng_seed(&rng, o->seed, 0x67726f77u + (uint64_t)links + ((uint64_t)part << 32));
    for (int i = next_row(t, from, rows, links, by_error, -1); i < rows->n && parents < PARENTS && st == LW_OK;
         i = next_row(t, from, rows, links, by_error, i)) {
        int children = parents++ == 0 ? CHILDREN/2 : CHILDREN/(2*(PARENTS - 1));
        for (int k = 0; st == LW_OK && k < children && to->n < CHILDREN; k++)
            st = grow_one(t, &o->spec, stage, &from->candidate[rows->candidate[i]], &rows->report[i], &rng, to);
    }
    return st;
}

/* Start again from the best results with `links` links. */
static void start_again(const lw_target *t, const lw_fit *from, const lw_fit_results *rows, int links, starts *to)
{
    for (int i = next_row(t, from, rows, links, false, -1), n = 0; i < rows->n && n < AGAIN;
         i = next_row(t, from, rows, links, false, i), n++) {
        lw_family_made *g = &to->made[to->n];
        g->linkage = rows->report[i].linkage;
        snprintf(g->name, sizeof g->name, "%.90s", lw_family_title(from->candidate[rows->candidate[i]].family));
        to->family[to->n++] = (lw_family){ .name = g->name, .linkage = &g->linkage, .posture = true, .links = links };
    }
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

/* Was it found by a search for cranks?  Such searches do not see what others find, and are those of a search for cranks alone. */
static bool is_of_cranks(const lw_candidate *c) { return c->part != LW_FIT_OTHERS; }

/* Is it the same linkage, or a cognate: as many links and the same error to rounding? */
static bool same(const lw_candidate *a, const lw_candidate *b)
{
    return lw_candidate_links(a) == lw_candidate_links(b)
        && fabs(a->objective - b->objective) <= SAME*b->objective && b->objective > ROUNDING;
}

/* Has one of the first n candidates, whose errors are not greater, as many links, no greater size and no less transmission angle? */
static bool is_dominated(const lw_fit *f, int n, const lw_candidate *c)
{
    bool dominated = false;
    for (int k = 0; k < n && !dominated; k++) {
        const lw_candidate *a = &f->candidate[k];
        dominated = lw_candidate_links(a) == lw_candidate_links(c) && !a->shrunk && a->intended.turns >= c->intended.turns
                 && is_of_cranks(a) >= is_of_cranks(c) && a->longest <= NO_SMALLER*c->longest && a->gentle >= c->gentle;
    }
    return dominated;
}

/* Keep the first candidates, some of every number of links, and with default limits some of each part of the types or dimensions: small
 * linkages and those without a crank may be first in another measure than the error.  And keep those that none before is as good as
 * in size and transmission angle, all that have a report, since rows may be among them or may have been those of a smaller budget, and all
 * that are shrunk. */
static void shorten(lw_staged_search *s, const lw_fit_options *o)
{
    const bool front = o->spec.by_default;
    const int kept = lw_fit_kept(o), most = 2*kept, each = front ? most : OF_EACH, of_part = front ? kept : 0;
    lw_fit *f = &s->fit;
    int n = 0, others = 0, last = -1;                     /* not shrunk                                                */
    int seen[LW_LINK_MAX + 1] = { 0 }, seen_of[LW_LINK_MAX + 1][LW_FIT_PARTS] = { 0 };
    for (int i = 0; i < f->n; i++) {
        lw_candidate *c = &f->candidate[i];
        int links = lw_candidate_links(c);
        bool wanted = others < most || seen[links] < each || seen_of[links][c->part] < of_part
                   || (front && !is_dominated(f, n, c));
        bool twin = last >= 0 && same(c, &f->candidate[last]);
        if (c->shrunk) {
            f->candidate[n++] = *c;
        } else if (c->report || (wanted && !twin)) {
            last = n;
            f->candidate[n++] = *c;
            others++;
            seen[links]++;
            seen_of[links][c->part]++;
        } else {
            lw_candidate_free(c);
        }
    }
    f->n = n;
}

/* ---- stages ------------------------------------------------------------------------------------------ */

/* Keep the results of one search of a stage, n_start of whose families are linkages to start from. */
static lw_status take(const stage_part *p, int n_start, lw_fit *fit)
{
    lw_stage_result *r = p->r;
    r->starts += fit->starts;
    r->improved += fit->improved;
    r->evals += fit->evals;
    r->stop = fit->stop;
    r->best = fit->n ? fmin(r->best, fit->candidate[0].objective) : r->best;
    for (int i = 0; r->state && i < r->n_state; i++)
        r->state[i] = fit->state[i] > r->state[i] ? fit->state[i] : r->state[i];
    if (!r->state) {
        r->state = fit->state;
        r->n_state = fit->n_state > 0 ? fit->n_state - n_start : 0;
        fit->state = NULL;
    }
    lw_status st = merge(&p->out->fit, fit) == LW_OK ? LW_OK : lw_error_set(p->e, LW_E_MEMORY, "no memory for the results");
    lw_fit_free(fit);
    return st;
}

/* May a search both ways find better linkages?  Of open targets it is made in later parts of a stage only: short searches lost more by
 * its time than they gained. */
static bool can_stray(const stage_part *p, bool later)
{
    const lw_target *t = p->t;
    const lw_fit_spec *s = &p->o->spec;
    return (t->closed || later) && s->by_default & LW_LIMIT_MOTION && lw_task_has_place(s->task) && s->timing == LW_TIMING_FREE;
}

/* Does the curve of the linkage of the stage with the least error (of those found by the searches for cranks, or of all) leave the
 * target between the stations?  Then a search without timing, which compares both ways, finds better ones. */
static lw_status strays(const stage_part *p, bool cranks, bool later, bool *out)
{
    const lw_candidate *best = NULL;
    const lw_fit *all = &p->out->fit;
    *out = false;
    for (int i = 0; i < all->n && can_stray(p, later); i++)
        if (lw_candidate_links(&all->candidate[i]) == p->stage->links && !all->candidate[i].shrunk
            && (!cranks || is_of_cranks(&all->candidate[i]))
            && (!best || all->candidate[i].objective < best->objective))
            best = &all->candidate[i];
    lw_fit_report *r = best ? malloc(sizeof *r) : NULL;
    lw_status st = !best ? LW_OK : r ? lw_fit_report_make(p->t, &p->o->spec, best, r, NULL) : LW_E_MEMORY;
    *out = best && st == LW_OK && r->stray.to_target > 1.5*r->error_max + STRAY*p->t->size;
    free(r);
    return st;
}

/* Is a search for small linkages worth while: may results be larger by default than those? */
static bool can_be_compact(const lw_fit_options *o)
{
    unsigned limit = lw_task_has_place(o->spec.task) ? LW_LIMIT_SIZE : LW_LIMIT_RATIO;
    return o->spec.by_default & limit;
}

/* The searches of a stage.  Of four-link types: the cranks, then the others; small cranks; then cranks and others once more, from
 * the curve to the target too, if the best curve strays.  Those of the cranks do not depend on the others: a search of all is
 * never worse than one of cranks alone.  Of families the same: all searches for cranks (run_parts), then those for others. */
enum { CRANKS, OTHERS, COMPACT, BOTH_WAYS, OTHERS_BOTH_WAYS, SEARCHES };

static lw_status run_search(const stage_part *p, const lw_fit_options *o, int search, lw_fit_part part, bool later, lw_fit *fit,
                            lw_error *e)
{
    lw_fit_options mine = *o;
    mine.part = search == COMPACT ? LW_FIT_COMPACT : part;
    mine.both_ways = search >= BOTH_WAYS || (search == COMPACT && o->families && can_stray(p, later));
    mine.cost = lw_fit_results_cost;
    return lw_fit_run(p->t, &mine, fit, e);
}

static bool any_with(const lw_fit *f, int links)
{
    for (int i = 0; i < f->n; i++)
        if (lw_candidate_links(&f->candidate[i]) == links)
            return true;
    return false;
}

/* Do the parts of a stage end whatever its budget is? */
static bool in_ends(const lw_fit_options *o, const lw_search_stage *stage)
{
    return o->spec.by_default && stage->families.make && !(o->max_seconds > 0);
}

/* Seconds of a search that may last until `end`. */
static double seconds_until(double end)
{
    return end > 0 ? fmax(1e-3, end - lw_clock_wall()) : 0;
}

/* Make the reports of what a search found now, so that rows are chosen among all of it whenever the stages end.  Under a time limit they take
 * no longer than the search took.  (Without it, four-link types are searched as a whole: nothing of them can be lost.) */
static void keep_reports(const stage_part *p, double seconds)
{
    const lw_fit_options *o = p->o;
    const double until = p->end > 0 ? fmin(p->end, lw_clock_wall() + seconds) : 0;
    const lw_results_effort effort = { .jobs = o->jobs, .until = until, .interrupt = o->interrupt };
    if (!o->spec.by_default || (p->end <= 0 && !p->stage->families.make))
        return;
    if (p->stage->families.make)
        shorten(p->out, o);                               /* linkages found again need no report           */
    lw_fit_results_keep(p->t, &o->spec, &p->out->fit, &effort);
}

/* Run the searches of four-link types. */
static lw_status run_types(const stage_part *p)
{
    static const lw_fit_part part[SEARCHES] = { LW_FIT_CRANKS, LW_FIT_OTHERS, LW_FIT_COMPACT, LW_FIT_CRANKS, LW_FIT_OTHERS };
    lw_fit_options mine = *p->o;
    bool whole = mine.spec.exclude_drag_link, stopped = false, any = false, again = false;
    const bool both = can_stray(p, false), wanted[SEARCHES] = { !whole, true, can_be_compact(&mine), both, both && !whole };
    lw_status st = LW_OK;
    for (int i = CRANKS; i < SEARCHES; i++) {
        lw_fit fit;
        lw_error why = { .text = "" };
        if (i >= BOTH_WAYS && wanted[i] && (st = strays(p, i == BOTH_WAYS && !whole, false, &again)) != LW_OK)
            return st;
        if (!wanted[i] || (i >= BOTH_WAYS && !again))
            continue;
        mine.max_seconds = seconds_until(p->end);
        mine.whole_rounds = any_with(&p->out->fit, p->stage->links);
        st = run_search(p, &mine, i, whole ? LW_FIT_WHOLE : part[i], false, &fit, &why);
        if (st == LW_E_ARG && i == OTHERS && !whole && !any)     /* no type can turn: this says it, or gives way */
            st = run_search(p, &mine, i, LW_FIT_WHOLE, false, &fit, &why);
        bool found = st >= 0;
        double seconds = found ? fit.seconds : 0;
        if (found && take(p, 0, &fit) != LW_OK)
            return LW_E_MEMORY;
        keep_reports(p, seconds);
        stopped |= st == LW_STOPPED;
        any |= found;
        if (!found && !(st == LW_E_ARG && (i >= COMPACT || (!whole && (i == CRANKS || any))))) {
            if (p->e)
                *p->e = why;
            return st;
        }
        if (st == LW_STOPPED)
            break;
    }
    return stopped ? LW_STOPPED : LW_OK;
}

/* The rows that a person would see of the first NEAREST candidates (of cranks, or of all) of every number of links, and of `mine`
 * of those of the stage; *seen: these candidates, which belong to p->out.  LW_E_MEMORY. */
static lw_status make_rows(const stage_part *p, bool cranks, int mine, lw_fit *seen, lw_fit_results *rows)
{
    const lw_fit_options *o = p->o;
    const lw_results_effort effort = { .jobs = o->jobs, .until = p->end, .interrupt = o->interrupt };
    lw_fit *all = &p->out->fit;
    int n[LW_LINK_MAX + 1] = { 0 }, *of = malloc(sizeof *of*((size_t)all->n + 1));
    *seen = (lw_fit){ .candidate = malloc(sizeof *seen->candidate*((size_t)all->n + 1)) };
    if (!of || !seen->candidate) {
        free(of);
        return LW_E_MEMORY;
    }
    for (int i = 0; i < all->n; i++) {
        int its = lw_candidate_links(&all->candidate[i]);
        if ((!cranks || is_of_cranks(&all->candidate[i])) && !all->candidate[i].shrunk && n[its]++ < (its == p->stage->links ? mine : NEAREST)) {
            of[seen->n] = i;
            seen->candidate[seen->n++] = all->candidate[i];
        }
    }
    lw_fit_results_keep(p->t, &o->spec, seen, &effort);
    for (int i = 0; i < seen->n; i++)
        all->candidate[of[i]].report = seen->candidate[i].report;
    free(of);
    lw_fit_spec spec = o->spec;
    spec.tolerance = 0;                                   /* the tolerance chooses at the end; the search is that without it */
    return lw_fit_results_make(p->t, &spec, seen, o->spec.by_default ? ROWS : all->n, NULL, &effort, rows, NULL);
}

/* Searches for cranks have the numbers 0, 1, ..., the others those from this on: all draw starts of their own. */
enum { FIRST_OTHER = 1 << 16 };

static int number_of(lw_fit_part part, int n_before) { return (part == LW_FIT_OTHERS ? FIRST_OTHER : 0) + n_before; }

/* Which search of these parts found the first row with `links` links? */
static int best_search(const lw_fit *seen, const lw_fit_results *rows, int links, int first_part, const int *search, int n)
{
    for (int i = 0; i < rows->n; i++) {
        const lw_candidate *c = &seen->candidate[rows->candidate[i]];
        int part = c->part_number - first_part;
        if (lw_candidate_links(c) == links && part >= 0 && part < n)
            return search[part];
    }
    return OTHERS;
}

/* A search of the families of a stage, one of the searches that a part consists of. */
typedef struct family_search {
    lw_fit_part kind;                /* of cranks, of others, or of all                             */
    int         search;              /* COMPACT, ...                                                */
    int         n_before;            /* how often the stage was searched for this kind before       */
    bool        later;               /* an earlier part has searched the stage for this kind        */
    long        budget, sweep;       /* as in lw_fit_options                                        */
    bool        last;                /* of the searches of a part: the others make no front         */
} family_search;

/* Search the families of a stage once, from the best linkages found before. */
static lw_status run_families(const stage_part *p, const family_search *f, const lw_fit *seen, const lw_fit_results *rows)
{
    lw_fit_options mine = *p->o;
    lw_fit fit;
    starts *more = calloc(1, sizeof *more);
    lw_status st = more && p->grows ? grow(p->t, p->o, p->stage, seen, rows, f->n_before, more) : more ? LW_OK : LW_E_MEMORY;
    if (st != LW_OK) {
        free(more);
        return lw_error_set(p->e, LW_E_MEMORY, "no memory for linkages to start from");
    }
    p->r->n_grown += more->n;
    if (f->n_before > 0)
        start_again(p->t, seen, rows, p->stage->links, more);
    lw_families_pair pair = { p->stage->families, lw_families_of(more->family, more->n) };
    lw_families all = lw_families_join(&pair);
    mine.families = &all;
    mine.part_number = number_of(f->kind, f->n_before);
    mine.budget = f->budget;
    mine.no_front = !f->last && p->o->spec.by_default && p->o->budget < SMALL;
    mine.sweep = f->sweep;
    mine.max_seconds = seconds_until(p->end);
    mine.whole_rounds = any_with(&p->out->fit, p->stage->links);
    p->r->n_part++;
    st = run_search(p, &mine, f->search, f->kind, f->later, &fit, p->e);
    double seconds = st >= 0 ? fit.seconds : 0;
    if (st >= 0 && take(p, more->n, &fit) != LW_OK)
        st = LW_E_MEMORY;
    if (st >= 0)
        keep_reports(p, seconds);
    free(more);
    return st;
}

/* Search the families of a stage for cranks, for others, or whole, with this budget; *n: how often that was done.  A search that needs more
 * than p->left is not begun, nor any after it, since a larger budget would have another one; *whole: all were begun.  If small cranks are
 * searched too, either search has a quarter of the budget, and so has the search both ways if the best curve strays.  The search that
 * found the first of the rows that a person would see now has the rest, and makes a front of what all of them found. */
static lw_status run_searches(const stage_part *p, lw_fit_part kind, long budget, int *n, bool *whole)
{
    const bool cranks = kind == LW_FIT_CRANKS, compact = can_be_compact(p->o) && kind != LW_FIT_OTHERS;
    bool again = false, stopped = false, exact = false;
    long left = budget, quarter = (left + PARTS - 1)/PARTS;
    int search[PARTS], n_first = *n;
    for (int k = 0; left > 0 && !(exact && k > 1); k++) {
        lw_fit seen = { 0 };
        lw_fit_results rows = { 0 };
        lw_status st = p->grows || *n > 0 ? make_rows(p, cranks, k < 2 ? NEAREST : p->out->fit.n, &seen, &rows) : LW_OK;
        if (st == LW_OK && k == 2)
            st = strays(p, cranks, n_first > 0, &again);
        if (st == LW_OK) {
            bool last = !compact || k > 2 || (k == 2 && !again);
            search[k] = k == 0 ? OTHERS : k == 1 ? COMPACT : !last ? BOTH_WAYS
                      : best_search(&seen, &rows, p->stage->links, number_of(kind, n_first), search, k);
            family_search f = { kind, search[k], *n, n_first > 0, last || quarter > left ? left : quarter, p->o->sweep, last };
            if (f.sweep == 0 && (p->in_part || p->o->spec.by_default))
                f.sweep = f.budget/2;
            *whole = budget - left + f.budget <= p->left;
            left = *whole ? left - f.budget : 0;
            st = *whole ? run_families(p, &f, &seen, &rows) : LW_OK;
            *n += *whole;
        } else
            lw_error_set(p->e, st, "no memory for reports");
        lw_fit_results_free(&rows);
        free(seen.candidate);
        if (st < 0 && !(st == LW_E_ARG && search[k] >= COMPACT))
            return st;
        stopped |= st == LW_STOPPED;
        exact |= p->r->stop == LW_STOP_F_TARGET;
        if (st == LW_STOPPED)
            break;
    }
    return stopped ? LW_STOPPED : LW_OK;
}

/* What does the row count as that a person would see first of the linkages found (of the cranks, or of all)?  INFINITY: there is none, or it is not
 * within the tolerance while there may be more links (begun: these were searched before).  All linkages have reports after this.  LW_E_MEMORY. */
static lw_status first_counts_as(const lw_target *t, const lw_fit_options *o, double end, bool begun, bool cranks, lw_staged_search *out,
                                 double *counts_as)
{
    const lw_results_effort effort = { .jobs = o->jobs, .until = end, .interrupt = o->interrupt };
    const lw_fit *all = &out->fit;
    const double tolerance = o->spec.tolerance;
    lw_fit_results rows;
    *counts_as = INFINITY;
    shorten(out, o);
    lw_fit_results_keep(t, &o->spec, &out->fit, &effort);
    lw_fit seen = { .candidate = malloc(sizeof *seen.candidate*((size_t)all->n + 1)) };
    for (int i = 0; seen.candidate && i < all->n; i++)
        if (!cranks || is_of_cranks(&all->candidate[i]))
            seen.candidate[seen.n++] = all->candidate[i];
    lw_status st = seen.candidate ? lw_fit_results_make(t, &o->spec, &seen, ROWS, NULL, &effort, &rows, NULL) : LW_E_MEMORY;
    free(seen.candidate);
    if (st == LW_OK) {
        if (rows.n > 0 && rows.broken == 0 && (tolerance == 0 || rows.n_within > 0))
            *counts_as = tolerance > 0 && !begun ? 0 : rows.report[0].counts_as;
        lw_fit_results_free(&rows);
    }
    return st == LW_E_MEMORY ? st : LW_OK;
}

/* Search the families of a stage, with default limits for cranks first, as a search for cranks alone does; then, with half as much, for
 * others, unless a linkage is found that is enough, or only cranks can run through a closed function. */
static lw_status run_all_families(const stage_part *p)
{
    const lw_fit_options *o = p->o;
    double counts_as = INFINITY;
    const bool must_turn = o->spec.crank_only || (p->t->closed && !lw_task_has_place(o->spec.task));
    lw_fit_part kind = o->spec.by_default ? LW_FIT_CRANKS : LW_FIT_WHOLE;
    bool whole = true;
    lw_status st = run_searches(p, kind, o->budget, &p->r->n_of[0], &whole);
    lw_stop stop = p->r->stop;
    if ((st != LW_OK && st != LW_E_KIND) || !whole || kind != LW_FIT_CRANKS || must_turn || stop == LW_STOP_F_TARGET)
        return st;
    if (p->stage->unless > 0 && (st = first_counts_as(p->t, o, p->end, true, false, p->out, &counts_as)) != LW_OK)
        return lw_error_set(p->e, st, "no memory for a report");
    st = counts_as <= fmax(p->stage->unless, LW_ENOUGH) ? LW_OK : run_searches(p, LW_FIT_OTHERS, (o->budget + 1)/2, &p->r->n_of[1], &whole);
    p->r->stop = st == LW_STOPPED ? p->r->stop : stop;    /* an exact find of the others does not end the search for cranks */
    return st;
}

/* ---- which stage gets the next evaluations -------------------------------------------------------- */

/* With default limits and without a time limit, families are searched in parts that end after 1e4, 3e4, 1e5, 3e5, ... evaluations of a stage,
 * whatever the budget; the stage that had least has the next part, and the first part that does not fit ends the search.  No find with a report is
 * dropped: so a run does all that one with a smaller budget (of 1e4 at least) does, and then more.
 *
 * Under a time limit parts are twice as large as those before, the first a sixty-fourth of the stage's budget (without default limits a quarter, with
 * `unless` a twelfth) or a thirty-second of its rounds. After the first parts, the stage whose last part lowered the logarithm of the error most per
 * evaluation has the next part; before that each whose first part lowered it has a second one, that with most links first: how much the first part gains
 * does not tell how much the second will. If time does not end it before, each has its own budget in the end, the last part of more links after all of
 * fewer. No part depends on the time limit, and what was found is kept: so a search with more time does all that one with less does, and then more. */
typedef struct contest {
    bool   timed;
    long   whole[LW_STAGE_MAX];      /* budget of each                                              */
    long   part[LW_STAGE_MAX];       /* budget of the last part of each                             */
    long   spent[LW_STAGE_MAX];      /* of all its parts                                            */
    long   left[LW_STAGE_MAX];       /* of its budget; 0: it takes no part any more                 */
    double rate[LW_STAGE_MAX];       /* what the last part gained per evaluation; INFINITY: it was the first, and gained */
    double counts_as[LW_STAGE_MAX];  /* with `unless`: the first row when that was looked at last   */
    bool   beyond;                   /* all had their budgets: time alone ends the search           */
} contest;

/* Budget of the next part of stage i. */
static long next_part(const contest *c, const lw_fit_options *o, const lw_search_stage *stage, int i)
{
    if (in_ends(o, &stage[i])) {
        long end = FIRST;
        for (bool three = true; end <= c->spent[i]; three = !three)
            end = three ? 3*end : end/3*10;
        return c->spent[i] == 0 && c->whole[i] < end ? c->whole[i] : end - c->spent[i];
    }
    if (c->part[i] > 0)
        return 2*c->part[i] < c->left[i] ? 2*c->part[i] : c->left[i];
    const bool families = stage[i].families.make != NULL;
    long usual = families && c->whole[i] > LW_FIT_BUDGET ? LW_FIT_BUDGET : c->whole[i];
    int parts = (families ? FIRST_TIMED : FIRST_TYPES)*(stage[i].unless > 0 ? UNLESS : families && o->spec.by_default ? ASKED : 1);
    return c->timed ? (usual + parts - 1)/parts : c->whole[i];
}

/* The least objective with at most so many links. */
static double least_of(const lw_fit *f, int links)
{
    double least = INFINITY;
    for (int i = 0; i < f->n; i++)
        if (f->candidate[i].beyond == 0 && lw_candidate_links(&f->candidate[i]) <= links)
            least = fmin(least, f->candidate[i].objective);
    return least;
}

/* The stage that gets the next part: the one that gained most; of several that gained as much the one that had least, under a time limit
 * of these the one with most links.  -1: none. */
static int winner(const contest *c, const lw_fit_options *o, const lw_search_stage *stage, int n)
{
    int best = -1;
    long fewer = 0;                  /* what stages with fewer links have left                      */
    for (int i = 0; i < n; i++) {
        bool may = c->left[i] > 0 && (fewer == 0 || next_part(c, o, stage, i) < c->left[i]);
        fewer += c->left[i];
        bool had_less = best >= 0 && (c->timed ? c->spent[i] <= c->spent[best] : c->spent[i] < c->spent[best]);
        if (may && (best < 0 || c->rate[i] > c->rate[best] || (c->rate[i] == c->rate[best] && had_less)))
            best = i;
    }
    return best;
}

/* Give the families of all stages more, unless the target is met exactly.  false: none of them can go on. */
static bool go_beyond(contest *c, const lw_search_stage *stage, const lw_staged_search *out)
{
    for (int i = 0; i < out->n_stage; i++)
        if (out->stage[i].stop == LW_STOP_F_TARGET)
            return false;
    for (int i = 0; i < out->n_stage; i++)
        if (stage[i].families.make && out->stage[i].evals > 0) {
            c->left[i] = LONG_MAX/4;
            c->beyond = true;
        }
    return c->beyond;
}

/* Search stage i with this budget and until `end` at most, and see what it gained.  Of four-link types the budget is a part of the
 * rounds. */
static lw_status run_part(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, int i, long budget,
                          double end, contest *c, lw_staged_search *out, lw_error *e)
{
    lw_stage_result *r = &out->stage[i];
    lw_fit_options mine = *o;
    const stage_part p = { .t = t, .o = &mine, .stage = &stage[i], .end = end, .grows = i > 0 && !lw_task_has_angle(o->spec.task),
                           .in_part = budget < c->whole[i], .left = c->left[i], .r = r, .out = out, .e = e };
    double before = least_of(&out->fit, stage[i].links), whole = (double)c->whole[i];
    long spent = r->evals;
    mine.families = NULL;
    mine.budget = budget;
    if (!stage[i].families.make) {
        mine.rounds_from = (whole - (double)c->left[i])/whole;
        mine.rounds_to = (whole - (double)(c->left[i] - budget))/whole;
    }
    if (o->begun)
        o->begun(o->context, stage[i].links);
    double start = lw_clock_wall();
    lw_status st = stage[i].families.make ? run_all_families(&p) : run_types(&p);
    r->n_part += stage[i].families.make == NULL;
    r->seconds += lw_clock_wall() - start;
    double after = least_of(&out->fit, stage[i].links);
    spent = r->evals - spent;
    const bool first = c->spent[i] == 0, over = !c->timed && budget > c->left[i], met = r->stop == LW_STOP_F_TARGET;
    c->part[i] = budget;
    c->spent[i] += budget;
    c->left[i] = (met && !(in_ends(o, &stage[i]) && c->spent[i] < EXACT)) || budget > c->left[i] ? 0 : c->left[i] - budget;
    for (int k = 0; k < LW_STAGE_MAX && over; k++)
        c->left[k] = 0;
    c->rate[i] = !c->timed || !(after < before) || spent == 0 || isinf(before) ? 0 : first ? INFINITY
               : log((before + ROUNDING)/(after + ROUNDING))/(double)spent;
    for (int k = 0; k < out->n_stage; k++)                /* better linkages to add a dyad to: as promising  */
        if (stage[k].links == stage[i].links + 2)
            c->rate[k] = fmax(c->rate[k], c->rate[i]);
    return st;
}

/* Is stage i, with `unless`, left out or ended, and all after it?  It is not begun if the first row is good.  In parts of fixed ends it ends when that is not
 * poor and the last part gained little: where six links do better than four, they mostly do so in their first parts. */
static lw_status is_over(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, bool begun, double end, lw_staged_search *out,
                         contest *c, int i, bool *over)
{
    const bool ends = in_ends(o, stage);
    double now, *before = &c->counts_as[i];
    *over = false;
    if (!(stage->unless > 0) || (begun && ends && c->spent[i] < ENOUGH))
        return LW_OK;
    lw_status st = first_counts_as(t, o, end, begun, o->spec.by_default && lw_target_prefers_turns(t), out, &now);
    const bool gained = begun && ends && now <= GAIN**before;
    const bool early = begun && ends && t->n > LW_FEW_STATIONS && c->spent[i] < WELL;
    *over = now <= (early ? fmin(stage->unless, LW_GOOD) : stage->unless) || (begun && !early && now <= (ends ? POOR : LW_ENOUGH) && !gained);
    *before = now;
    return st;
}

lw_status lw_staged_search_run(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, int n_stage,
                               lw_staged_search *out, lw_error *e)
{
    lw_status st = LW_OK;
    const double end = o->max_seconds > 0 ? lw_clock_wall() + o->max_seconds : 0;
    contest c = { .timed = end > 0 };
    bool asked = false;
    memset(out, 0, sizeof *out);
    n_stage = n_stage < LW_STAGE_MAX ? n_stage : LW_STAGE_MAX;
    for (;;) {
        bool first = out->n_stage < n_stage, enough;
        int i = first ? out->n_stage : winner(&c, o, stage, n_stage);
        bool over = end > 0 && end - lw_clock_wall() <= LEAST_PART*o->max_seconds;
        if (i < 0 && end > 0 && o->budget <= 0 && !c.beyond && go_beyond(&c, stage, out))
            i = winner(&c, o, stage, n_stage);
        if (i < 0 || (over && (!first || out->fit.n > 0))) {
            st = i < 0 || c.beyond ? st : LW_STOPPED;
            break;
        }
        if (is_over(t, o, &stage[i], !first, end, out, &c, i, &enough) != LW_OK) {
            lw_staged_search_free(out);
            return lw_error_set(e, LW_E_MEMORY, "no memory for a report");
        }
        if (enough) {                                     /* neither this stage nor those after it             */
            n_stage = out->n_stage < n_stage ? out->n_stage : n_stage;
            for (int k = i; k < n_stage; k++)
                c.left[k] = 0;
            continue;
        }
        if (first) {
            out->stage[out->n_stage++] = (lw_stage_result){ .links = stage[i].links, .best = INFINITY };
            c.whole[i] = c.left[i] = stage[i].budget > 0 ? stage[i].budget : o->budget > 0 ? o->budget : LW_FIT_BUDGET;
        }
        lw_status now = run_part(t, o, stage, i, next_part(&c, o, stage, i), end, &c, out, e);
        if (now < 0 && now != LW_E_KIND) {
            lw_staged_search_free(out);
            return now;
        }
        asked = o->interrupt && *o->interrupt;
        st = now == LW_STOPPED && (asked || !c.beyond) ? now : st;
        if (now == LW_STOPPED && asked)
            break;
    }
    if (end > 0 && !asked)
        out->fit.stop = st == LW_STOPPED ? LW_STOP_TIME : c.beyond && out->fit.stop == LW_STOP_TIME ? LW_STOP_EVALS : out->fit.stop;
    shorten(out, o);
    return st == LW_OK && out->fit.n == 0 ? LW_NOTHING : st;
}

void lw_staged_search_free(lw_staged_search *s)
{
    lw_fit_free(&s->fit);
    for (int i = 0; i < s->n_stage; i++)
        free(s->stage[i].state);
    memset(s, 0, sizeof *s);
}
