#include "optimise/report/results.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "base/real.h"
#include "optimise/report/robustness.h"

static int bits(unsigned n)
{
    int count = 0;
    for (; n; n &= n - 1)
        count++;
    return count;
}

static bool first_with_its_links(const lw_fit_results *r, const lw_fit *fit, int i)
{
    for (int k = 0; k < r->n; k++)
        if (lw_candidate_links(&fit->candidate[r->candidate[k]]) == lw_candidate_links(&fit->candidate[i]))
            return false;
    return true;
}

/* How large a linkage is: its longest link in diagonals of the target.  A function has no length to compare with: of its
 * linkage a quarter of the ratio of the longest to the shortest link. */
#define PER_DIAGONAL 4.0
static double bulk_of(const lw_target *t, const lw_fit_report *r)
{
    return t->extent > 0 ? r->size/t->extent : lw_fit_report_ratio(t, r)/PER_DIAGONAL;
}

/* A result is worth a row beside one with less error if it is smaller or strays less by this factor, or ... */
#define SMALLER 0.8
/* (beside one that a designer would rather build by this) */
#define MUCH_SMALLER 0.7
/* ... its least transmission angle is greater by this, as long as the other has less than enough [rad]. */
#define GENTLER (5*LW_PI/180)
#define ENOUGH  (45*LW_PI/180)
/* For a linkage larger than BULKY sizes of the target, a transmission angle above FAIR counts as FAIR. */
#define BULKY   3
#define FAIR    (30*LW_PI/180)
/* The list ends where errors exceed WORSE times the least, and these parts of the target or angles [rad]; for linkages that leave the
 * target by FAR of its diagonal, or a function by FAR of the swing of its output, FAR_WORSE times. */
#define WORSE       5
#define ROUGH       0.01
#define ROUGH_ANGLE (1*LW_PI/180)
#define FAR         0.05
#define FAR_WORSE   2

static bool same_type(const lw_candidate *a, const lw_candidate *b)
{
    return lw_candidate_links(a) != lw_candidate_links(b) || (a->family->type != NULL) != (b->family->type != NULL)
        || !a->family->type || strcmp(a->family->type, b->family->type) == 0;
}

/* Does the linkage stay so near the target that nobody would build another one for less error?  Between the stations the target is a
 * guess, and it is known to its noise only. */
#define FINE     1e-4              /* of the target at the stations, and an angle [rad]; ...                   */
#define NO_ERROR 3e-4              /* ... and between them                                                      */
static bool is_fine(const lw_target *t, const lw_fit_report *r)
{
    return !(r->angle_max > FINE) && (!(t->extent > 0) || (r->error_max <= fmax(FINE*t->extent, t->noise)
                                                           && lw_fit_report_stray(r) <= fmax(NO_ERROR*t->extent, t->noise)));
}

#define NOISE 1e-9                 /* parts of the target, and angles [rad]: linkages that err by less meet it equally well */

/* The objective, but 0 where it is rounding. */
static double error_of(const lw_target *t, const lw_candidate *c, const lw_fit_report *r)
{
    return r->error_max > NOISE*t->extent || r->angle_max > NOISE ? c->objective : 0;
}

/* Is the result with report a at least as easy to build as b: b is neither simpler, nor smaller by `factor`, nor gentler, and does not turn alone? */
static bool is_as_easy(const lw_target *t, double factor, const lw_candidate *ca, const lw_fit_report *a, const lw_candidate *cb,
                       const lw_fit_report *b)
{
    return lw_candidate_links(ca) <= lw_candidate_links(cb) && a->turns >= b->turns && !(bulk_of(t, b) < factor*bulk_of(t, a))
        && (a->transmission_min >= ENOUGH || !(b->transmission_min > a->transmission_min + GENTLER));
}

/* Is the result with report a at least as good as b as far as it matters: it is as easy, and b is not nearer by `factor`? */
static bool covers(const lw_target *t, double factor, const lw_candidate *ca, const lw_fit_report *a, const lw_candidate *cb,
                   const lw_fit_report *b)
{
    return is_as_easy(t, factor, ca, a, cb, b) && same_type(ca, cb)
        && (is_fine(t, a) || !(lw_fit_report_stray(b) < factor*lw_fit_report_stray(a)
                               || error_of(t, cb, b) < factor*factor*error_of(t, ca, a)));
}

/* Numbers of a report in which a search over more should not be worse; less is better.  The first matter most. */
enum { ERROR, STRAY, CHAMFER, ANGLE, BULK, TRANSMISSION, SPREAD, MEASURES };
#define NO_BETTER 1e-3             /* relative: the best in a measure is not replaced by one better by less, a twin    */

/* How far the linkage is from the target, as a part of its diagonal, or of the swing of the output. */
static double part_missed(const lw_target *t, const lw_fit_report *r)
{
    return t->extent > 0 ? lw_fit_report_known_miss(t, r, 0)/t->extent : r->angle_max/lw_target_swing(t);
}

/* Must the input be reversed, where that of another linkage could turn on?  That of an open function is reversed anyway. */
static bool is_reversed(const lw_target *t, const lw_fit_report *r)
{
    return !r->turns && lw_target_prefers_turns(t);
}

/* The front of the candidates that can be results: of each number of links the one with the least error among those with no more links
 * ([1]: and whose input is not reversed), the best in each measure of those that are not rough, and the least part missed ([1] as before). */
typedef struct front {
    int    least[LW_LINK_MAX + 1][2], best[MEASURES];
    double missed[2];
} front;

/* Is the linkage far from the target, by more than its noise, where another one (whose input is not reversed, if its is not) is near? */
static bool is_lost(const lw_target *t, const front *f, const lw_fit_report *r)
{
    return f->missed[!is_reversed(t, r)] <= LW_NEAR && part_missed(t, r) > (t->extent > 0 ? fmax(FAR, t->noise/t->extent) : FAR);
}

/* Is candidate i lost, or so much worse than the one with the least error and no more links (and an input that is not reversed, if its is not) that
 * nobody wants it? */
static bool is_rough(const lw_target *t, const lw_fit *fit, const lw_fit_report *all, const front *f, int i)
{
    const lw_candidate *c = &fit->candidate[i];
    const lw_fit_report *r = &all[i];
    const int least = f->least[lw_candidate_links(c)][!is_reversed(t, r)];
    const lw_candidate *first = &fit->candidate[least];
    const lw_fit_report *best = &all[least];
    if (is_lost(t, f, r))
        return true;
    bool far = t->extent > 0 ? lw_fit_report_misses(t, r) > FAR*t->extent : r->angle_max > FAR*lw_target_swing(t);
    double worse = far ? FAR_WORSE : WORSE, less = far ? MUCH_SMALLER : 1;
    return c->objective > worse*worse*first->objective && !(lw_fit_report_stray(r) < less*lw_fit_report_stray(best))
        && (lw_fit_report_distance(t, r) > fmax(ROUGH*t->size, t->noise) || r->angle_max > ROUGH_ANGLE);
}

static void measures(const lw_target *t, const lw_candidate *c, const lw_fit_report *r, double m[MEASURES])
{
    const double bulk = bulk_of(t, r), gentle = fmin(r->transmission_min, bulk > BULKY ? FAIR : ENOUGH);
    const double all[MEASURES] = { sqrt(error_of(t, c, r)), lw_fit_report_stray(r), r->likeness.chamfer, r->angle_max > NOISE ? r->angle_max : 0,
                                   bulk, -gentle, r->spread };
    for (int i = 0; i < MEASURES; i++)
        m[i] = isnan(all[i]) ? INFINITY : all[i];
}

#define TWIN 0.02                  /* a row has to be better than each row before it, by this part in at least one measure */

/* Are they the same mechanism but for TWIN of each length, and of the size for places? */
static bool same_mechanism(const lw_candidate *ca, const lw_fit_report *a, const lw_candidate *cb, const lw_fit_report *b)
{
    bool same = strcmp(lw_family_title(ca->family), lw_family_title(cb->family)) == 0 && ca->n_dim == cb->n_dim
             && ca->n_dyad == cb->n_dyad && ca->intended.sense == cb->intended.sense;
    for (int i = 0; i < ca->n_dyad && same; i++)
        same = ca->intended.mode[i] == cb->intended.mode[i];
    for (int i = 0; i < ca->n_dim && same; i++) {
        double u = ca->dim[i], v = cb->dim[i], size = fmax(a->size, b->size);
        same = a->dim_kind[i] == LW_DIM_ANGLE ? fabs(remainder(u - v, 2*LW_PI)) <= TWIN
             : fabs(u - v) <= TWIN*(a->dim_kind[i] == LW_DIM_LENGTH ? fmax(fabs(u), fabs(v)) : size);
    }
    return same;
}

/* Is b, which comes after a, a linkage of the same type and number of links that is not better in any measure, nor turns alone; or the same
 * mechanism? */
static bool is_twin(const lw_target *t, const lw_candidate *ca, const lw_fit_report *a, const lw_candidate *cb, const lw_fit_report *b)
{
    double m[MEASURES], first[MEASURES];
    if (same_mechanism(ca, a, cb, b))
        return true;
    measures(t, ca, a, first);
    measures(t, cb, b, m);
    bool twin = lw_candidate_links(ca) == lw_candidate_links(cb) && same_type(ca, cb) && a->turns >= b->turns;
    for (int k = 0; k < MEASURES && twin; k++)
        twin = !(m[k] < first[k] - TWIN*fabs(first[k]));
    return twin;
}

static bool is_best(const front *f, int i)
{
    bool best = false;
    for (int k = 0; k < MEASURES; k++)
        best |= f->best[k] == i;
    return best;
}

/* Is candidate i the best in a measure in which none of the n rows is as good?  No curve is better than a fine one. */
static bool is_needed(const lw_target *t, const lw_fit *fit, const lw_fit_report *all, const front *f, const int *row, int n, int i)
{
    double m[MEASURES], of_row[MEASURES];
    unsigned missing = 0;
    measures(t, &fit->candidate[i], &all[i], m);
    for (int k = 0; k < MEASURES; k++)
        missing |= (unsigned)(f->best[k] == i) << k;
    for (int r = 0; r < n; r++) {
        measures(t, &fit->candidate[row[r]], &all[row[r]], of_row);
        for (int k = 0; k < MEASURES; k++)
            if (of_row[k] <= m[k] + NO_BETTER*fabs(m[k]) || ((k == STRAY || k == CHAMFER) && is_fine(t, &all[row[r]])))
                missing &= ~(1u << k);
    }
    return missing != 0;
}

static void find_front(const lw_target *t, const lw_fit *fit, const lw_fit_report *all, const bool *usable, unsigned broken,
                       int most, front *f)
{
    double least[MEASURES], m[MEASURES];
    f->missed[0] = f->missed[1] = INFINITY;
    for (int i = 0; i <= LW_LINK_MAX; i++)
        f->least[i][0] = f->least[i][1] = -1;
    for (int k = 0; k < MEASURES; k++) {
        f->best[k] = -1;
        least[k] = INFINITY;
    }
    for (int i = 0; i < fit->n; i++) {
        const lw_candidate *c = &fit->candidate[i];
        if (!usable[i] || bits(all[i].broken) > bits(broken))
            continue;
        for (int on = 0; on <= !is_reversed(t, &all[i]); on++)
            f->missed[on] = fmin(f->missed[on], part_missed(t, &all[i]));
        for (int n = lw_candidate_links(c); n <= LW_LINK_MAX; n++)
            for (int on = 0; on <= !is_reversed(t, &all[i]); on++) {
                int *least_of = &f->least[n][on];
                *least_of = *least_of < 0 || c->objective < fit->candidate[*least_of].objective ? i : *least_of;
            }
    }
    for (int i = 0; i < fit->n; i++) {
        const lw_candidate *c = &fit->candidate[i];
        if (!usable[i] || bits(all[i].broken) > bits(broken) || is_rough(t, fit, all, f, i))
            continue;
        measures(t, c, &all[i], m);
        for (int k = 0; k < MEASURES && k < most - 1; k++)
            if (isfinite(m[k]) && (f->best[k] < 0 || m[k] < least[k] - NO_BETTER*fabs(least[k]))) {
                least[k] = m[k];
                f->best[k] = i;
            }
    }
}

/* Should this report, whose error is not less than those before it, be a result too?  Without default limits the first
 * `most` are; with them there are as many as the front has. */
static bool is_wanted(const lw_target *t, const lw_fit_spec *s, const lw_fit *fit, int most, const lw_fit_report *all,
                      const front *f, const lw_fit_results *out, int i)
{
    if (!s->by_default)
        return out->n < most || first_with_its_links(out, fit, i);
    return !is_rough(t, fit, all, f, i) || (first_with_its_links(out, fit, i) && !is_lost(t, f, &all[i]));
}

/* Properties that a designer weighs against the error of a linkage; each is a logarithm, so that 0.7 counts as twice the error. */
#define PER_SIZE     0.85          /* twice the longest link, if longer than the target, counts as 1.8 times the error, beyond compact ones as ... */
#define PER_LESS     0.1           /* ... 3.2 times; half the longest link, if shorter than the target, as 0.93 times            */
#define PER_RATIO    0.85          /* beyond LW_EVEN, twice the ratio of longest to shortest link counts as 1.8 times the error */
#define PER_MISS     2.5           /* beyond LW_NEAR twice the error counts as 11 times: what is far from the target is not built for being simple */
#define PER_ANGLE    1.15          /* for each radian that the least transmission angle lacks of ENOUGH: 1.65 at 20 degrees */
#define PER_LINK     0.5           /* for each link more: two links with their three joints count as 2.7 times the error */
#define DOUBT        0.05          /* part of the distance from a smooth line through a few stations that counts as error */
#define ROCKING      0.2           /* an input that has to be reversed (is_reversed)                                */

static double cost_of_size(const lw_target *t, const lw_fit_report *r)
{
    const double bulk = bulk_of(t, r), compact = t->extent > 0 ? LW_COMPACT_SIZE : LW_COMPACT_RATIO/PER_DIAGONAL;
    return PER_LESS*log(fmin(1, fmax(bulk, 0.1))) + PER_SIZE*(log(fmax(1, bulk)) + log(fmax(1, bulk/compact)));
}

/* How far a linkage stays from the target as it is made, as a part of the diagonal, or of the swing of the output.  What is not known of it,
 * as clearance, bending and warmth, grows with its size. */
static double part_as_made(const lw_target *t, const lw_fit_report *r)
{
    const bool function = !(t->extent > 0);
    const double whole = function ? fmax(1, lw_target_swing(t)) : t->extent, made = isnan(r->as_made) ? LW_EXACT_ENOUGH*whole : r->as_made;
    const double unknown = LW_EXACT_ENOUGH*(function ? 1 : fmax(1, bulk_of(t, r)));
    return hypot(hypot(function ? r->angle_max : lw_fit_report_known_miss(t, r, DOUBT), made)/whole, fmax(unknown, t->noise/whole));
}

/* Less is better. */
static double cost_of(const lw_target *t, const lw_candidate *c, const lw_fit_report *r)
{
    double part = part_as_made(t, r), near = t->extent > 0 ? fmax(LW_NEAR, t->noise/t->extent) : LW_NEAR;
    return log(part) + PER_MISS*log(fmax(1, part/near)) + cost_of_size(t, r)
         + (t->extent > 0 ? PER_RATIO*log(lw_uneven(lw_fit_report_ratio(t, r), 1)) : 0)
         + PER_ANGLE*fmax(0, ENOUGH - r->transmission_min) + PER_LINK*lw_candidate_links(c) + (is_reversed(t, r) ? ROCKING : 0);
}

/* Move the first row with each number of links before the others: which linkage is the best with fewer links is the first thing to know
 * beside the first row. */
static void put_numbers_of_links_first(const lw_fit *fit, lw_fit_results *out)
{
    const int n = out->n;
    int firsts = 0;
    for (int i = 0; i < n; i++) {
        int now = out->candidate[i];
        out->n = firsts;
        if (!first_with_its_links(out, fit, now))
            continue;
        memmove(out->candidate + firsts + 1, out->candidate + firsts, sizeof now*(size_t)(i - firsts));
        out->candidate[firsts++] = now;
    }
    out->n = n;
}

/* Sort the front by cost and keep `most` rows, among them the best in each measure, and the first of each number of links. */
static void order_front(const lw_target *t, const lw_fit *fit, int most, const lw_fit_report *all, const front *f, lw_fit_results *out)
{
    int n = 0, to_come = 0;
    for (int i = 1; i < out->n; i++) {
        int now = out->candidate[i], at = i;
        double cost = cost_of(t, &fit->candidate[now], &all[now]);
        for (; at > 0 && cost_of(t, &fit->candidate[out->candidate[at - 1]], &all[out->candidate[at - 1]]) > cost; at--)
            out->candidate[at] = out->candidate[at - 1];
        out->candidate[at] = now;
    }
    for (int i = 0; i < out->n; i++)
        to_come += is_best(f, out->candidate[i]);
    for (int i = 0, n_front = out->n; i < n_front; i++) {
        int now = out->candidate[i];
        out->n = n;
        to_come -= is_best(f, now);
        bool twin = false, covered = false;
        for (int k = 0; k < n && !twin; k++) {
            const lw_candidate *better = &fit->candidate[out->candidate[k]];
            twin = is_twin(t, better, &all[out->candidate[k]], &fit->candidate[now], &all[now]);
            covered |= covers(t, MUCH_SMALLER, better, &all[out->candidate[k]], &fit->candidate[now], &all[now]);
        }
        if (!twin && (is_needed(t, fit, all, f, out->candidate, n, now) || (!covered && n + to_come < most) || first_with_its_links(out, fit, now)))
            out->candidate[n++] = now;
    }
    out->n = n;
    put_numbers_of_links_first(fit, out);
    for (int i = 0; i < n; i++)
        out->report[i] = all[out->candidate[i]];
}

static void leave_out(lw_fit_results *out, int candidate, const char *fault)
{
    lw_left_out *l = &out->left_out[out->n_left_out++];
    l->candidate = candidate;
    snprintf(l->fault, sizeof l->fault, "%s", fault);
}

/* Both candidates are within the tolerance: does i come before k, because it is simpler, or else smaller?  A linkage with lengths
 * of more than LW_EVEN to one counts as larger. */
static bool simpler(const lw_target *t, const lw_fit *fit, const lw_fit_report *all, int i, int k)
{
    int links = lw_candidate_links(&fit->candidate[i]) - lw_candidate_links(&fit->candidate[k]);
    const lw_fit_report *a = &all[i], *b = &all[k];
    return links != 0 ? links < 0
         : a->size*lw_uneven(lw_fit_report_ratio(t, a), 1) < b->size*lw_uneven(lw_fit_report_ratio(t, b), 1);
}

/* Put the candidates that stay within the tolerance into `order`, the simplest and smallest first.  A candidate after
 * the first is kept if its error is less than those of all before it by a fifth, or its transmission angle greater.  Returns
 * their number. */
static int within_tolerance(const lw_target *t, const lw_fit_spec *s, const lw_fit *fit, const lw_fit_report *all,
                            const bool *usable, unsigned broken, int *order)
{
    int n = 0, kept = 0;
    for (int i = 0; i < fit->n && s->tolerance > 0; i++) {
        if (!usable[i] || bits(all[i].broken) > bits(broken) || !(lw_fit_report_stray(&all[i]) <= s->tolerance))
            continue;
        int at = n++;
        for (; at > 0 && simpler(t, fit, all, i, order[at - 1]); at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
    for (int i = 0; i < n; i++) {
        bool wanted = true;
        for (int k = 0; k < kept && wanted; k++) {
            const lw_fit_report *a = &all[order[k]], *b = &all[order[i]];
            wanted = fit->candidate[order[i]].objective < SMALLER*SMALLER*fit->candidate[order[k]].objective
                  || (a->transmission_min < ENOUGH && b->transmission_min > a->transmission_min + GENTLER);
        }
        if (wanted)
            order[kept++] = order[i];
    }
    return kept;
}

#define MANY 1000              /* stations: the reports of a stopped search are made one at a time */

/* Reports to make, by several threads. */
typedef struct reports {
    const lw_target   *t;
    const lw_fit_spec *s;
    const lw_fit      *fit;
    const unsigned    *may_fail;
    const lw_results_effort *effort;
    lw_fit_report     *report;
    bool              *made, *usable;
    lw_status         *status;
    atomic_bool        any;                  /* there is one to keep                               */
} reports;

/* A tolerance of lengths, in diagonals of the target, that a workshop keeps without effort: +-0.08 mm of 200 mm (IT 10 of ISO 286-1). */
#define WORKSHOP 4e-4

/* How far linkages stray from the curve of this one, or their output from its angle, as they are made: two standard deviations in the worst
 * posture. */
static lw_status find_as_made(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r)
{
    const lw_tolerances workshop = { .length = WORKSHOP*(t->extent > 0 ? t->extent : PER_DIAGONAL*r->length_least) };
    const bool given = s->tolerances.length > 0 || s->tolerances.clearance > 0;
    double deviation;
    lw_status st = lw_robustness_deviation(t, c, r, given ? &s->tolerances : &workshop, &deviation);
    r->as_made = st == LW_OK ? 2*deviation : NAN;
    r->spread = given ? r->as_made : NAN;
    return st == LW_E_MEMORY ? st : LW_OK;
}

static bool is_stopped(const lw_results_effort *o)
{
    return (o->interrupt && *o->interrupt) || (o->until > 0 && lw_clock_wall() > o->until);
}

/* The report that the candidate has, or a new one. */
static lw_status report_of(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r)
{
    if (c->report) {
        *r = *c->report;
        return LW_OK;
    }
    lw_status st = lw_fit_report_make(t, s, c, r, NULL);
    return st == LW_OK ? find_as_made(t, s, c, r) : st;
}

double lw_fit_results_cost(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c)
{
    lw_fit_report *r = malloc(sizeof *r);
    bool usable = r && lw_fit_report_sketch(t, s, c, r) == LW_OK && !r->fault[0] && !r->broken && find_as_made(t, s, c, r) == LW_OK;
    double cost = usable ? cost_of(t, c, r) - 4*PER_LINK : INFINITY;
    free(r);
    return cost;
}

static void make_report(void *context, size_t i, int thread)
{
    (void)thread;
    reports *c = context;
    lw_fit_report *r = &c->report[i];
    if (c->any && !c->fit->candidate[i].report && is_stopped(c->effort))
        return;
    c->status[i] = report_of(c->t, c->s, &c->fit->candidate[i], r);
    c->made[i] = c->status[i] == LW_OK;
    bool passed = c->made[i] && (r->verified || (c->may_fail && c->may_fail[i] && r->meets));
    c->usable[i] = passed && !(r->broken & ~c->s->by_default);
    if (c->usable[i])
        c->any = true;
}

/* A report that failed for another reason than memory is made again, for its text. */
static lw_status first_fault(const reports *c, lw_error *e)
{
    for (int i = 0; i < c->fit->n; i++)
        if (c->status[i] != LW_OK)
            return lw_fit_report_make(c->t, c->s, &c->fit->candidate[i], &c->report[i], e) == LW_OK
                 ? lw_error_set(e, LW_E_MEMORY, "out of memory for a report") : c->status[i];
    return LW_OK;
}

lw_status lw_fit_results_make(const lw_target *t, const lw_fit_spec *s, const lw_fit *fit, int most,
                              const unsigned *may_fail, const lw_results_effort *effort, lw_fit_results *out, lw_error *e)
{
    size_t n = (size_t)fit->n + 1;
    *out = (lw_fit_results){ .candidate = calloc(n, sizeof *out->candidate), .report = calloc(n, sizeof *out->report),
                             .left_out = calloc(n, sizeof *out->left_out) };
    lw_fit_report *all = calloc(n, sizeof *all);
    bool *fit_for_use = calloc(2*n, sizeof *fit_for_use), any = false;
    lw_status *status = calloc(n, sizeof *status);
    lw_status st = out->candidate && out->report && out->left_out && all && fit_for_use && status
                 ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for %d results", fit->n);
    static const lw_results_effort whole = { .jobs = 1 };
    effort = effort ? effort : &whole;
    reports work = { .t = t, .s = s, .fit = fit, .may_fail = may_fail, .effort = effort, .report = all,
                     .made = fit_for_use + n, .usable = fit_for_use, .status = status };
    if (st == LW_OK) {
        int jobs = t->n >= MANY && is_stopped(effort) ? 1 : effort->jobs > 0 ? effort->jobs : lw_core_count();
        lw_parallel(jobs, (size_t)fit->n, make_report, &work);
        st = first_fault(&work, e);
    }
    free(status);
    for (int i = 0; i < fit->n && st == LW_OK; i++) {
        const lw_fit_report *r = &all[i];
        if (!work.made[i]) {
            out->n_unseen++;
            continue;
        }
        if (!fit_for_use[i])
            leave_out(out, i, r->verified || (may_fail && may_fail[i] && r->meets) ? r->broken_text : r->fault);
        else if (!any || bits(r->broken) < bits(out->broken))
            out->broken = r->broken;
        any |= fit_for_use[i];
    }
    int *order = st == LW_OK ? calloc(n, sizeof *order) : NULL;
    st = st == LW_OK && !order ? lw_error_set(e, LW_E_MEMORY, "no memory for %d results", fit->n) : st;
    out->n_within = st == LW_OK ? within_tolerance(t, s, fit, all, fit_for_use, out->broken, order) : 0;
    for (int i = 0; i < out->n_within && out->n < most; i++) {
        out->report[out->n] = all[order[i]];
        out->candidate[out->n++] = order[i];
    }
    free(order);
    front f;
    if (st == LW_OK)
        find_front(t, fit, all, fit_for_use, out->broken, most, &f);
    for (int i = 0; i < fit->n && st == LW_OK && out->n_within == 0; i++) {
        const lw_fit_report *r = &all[i];
        if (!fit_for_use[i])
            continue;
        if (bits(r->broken) > bits(out->broken)) {
            out->n_unfit++;
            for (int k = 0; k < LW_LIMITS; k++)
                out->unfit_by[k] += r->broken >> k & 1;
        } else if (is_wanted(t, s, fit, most, all, &f, out, i)) {
            out->report[out->n] = *r;
            out->candidate[out->n++] = i;
        }
    }
    if (st == LW_OK && s->by_default && out->n_within == 0)
        order_front(t, fit, most, all, &f, out);
    for (int i = 0; i < out->n && st == LW_OK && s->by_default; i++)
        out->report[i].counts_as = exp(cost_of(t, &fit->candidate[out->candidate[i]], &out->report[i]) - 4*PER_LINK);
    free(all);
    free(fit_for_use);
    if (st != LW_OK)
        lw_fit_results_free(out);
    return st;
}

void lw_fit_results_end(const lw_target *t, const lw_fit *fit, lw_fit_results *out)
{
    const int rows = out->n_within == 0 ? out->n : 0;
    double best = INFINITY;
    for (int i = 0; i < rows; i++)
        best = fmin(best, out->report[i].counts_as);
    for (int i = 0, n = 0; i < rows; i++) {
        const int now = out->candidate[i];
        const lw_fit_report *r = &out->report[i];
        bool poor = r->counts_as > fmax(WORSE*best, LW_ENOUGH), covered = false;
        out->n = n;
        for (int k = 0; k < n && poor && !covered; k++)
            covered = is_as_easy(t, MUCH_SMALLER, &fit->candidate[out->candidate[k]], &out->report[k], &fit->candidate[now], r)
                   && !(part_missed(t, &out->report[k]) > LW_NEAR
                        && fit->candidate[now].objective < SMALLER*SMALLER*fit->candidate[out->candidate[k]].objective);
        if (!covered) {
            out->report[n] = *r;
            out->candidate[n++] = now;
        }
        out->n = n;
    }
}

static void keep_report(void *context, size_t i, int thread)
{
    (void)thread;
    reports *c = context;
    lw_candidate *of = &c->fit->candidate[i];
    lw_fit_report *r = of->report || is_stopped(c->effort) ? NULL : malloc(sizeof *r);
    if (r && report_of(c->t, c->s, of, r) == LW_OK)
        of->report = r;
    else
        free(r);
}

void lw_fit_results_keep(const lw_target *t, const lw_fit_spec *s, lw_fit *fit, const lw_results_effort *effort)
{
    reports work = { .t = t, .s = s, .fit = fit, .effort = effort };
    lw_parallel(effort->jobs > 0 ? effort->jobs : lw_core_count(), (size_t)fit->n, keep_report, &work);
}

void lw_fit_results_free(lw_fit_results *r)
{
    free(r->candidate);
    free(r->report);
    free(r->left_out);
    memset(r, 0, sizeof *r);
}
