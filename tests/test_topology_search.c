/* A search over topologies in one call: results pass a second simulation, six links are never worse than four, the
 * answer does not depend on the number of threads, and the stop flag and the progress are honoured. */
#include <string.h>

#include "base/real.h"
#include "mbs/constraints/newton.h"
#include "optimise/topology/mechanism_set.h"
#include "optimise/topology/topology_search.h"
#include "tests/check.h"

static lw_topology_search_options options(int links, int jobs)
{
    lw_topology_search_options o = lw_topology_search_options_default();
    o.links = links;
    o.fit.jobs = jobs;
    o.fit.starts = 30;
    o.fit.max_rounds = 1;
    o.fit.budget = 3000;
    o.fit.n_result = 3;
    return o;
}

static lw_target target(void)
{
    static const double x[] = { 0, 1, 2, 3, 3, 2.6, 1.5, 0.4 }, y[] = { 0, 0.2, 0, 0.3, 1.2, 2, 1.7, 1.4 };
    lw_target t;
    CHECK_INT(lw_target_make(8, x, y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    return t;
}

/* Can the input of the linkage move, by its constraint equations alone? */
static bool drives(const lw_linkage *k)
{
    lw_newton *n;
    double reached;
    if (lw_newton_create(k, &n, NULL) != LW_OK)
        return false;
    double from = k->input[0].value;
    bool moves = lw_newton_move(n, from + 1e-3, &reached) == LW_OK || lw_newton_move(n, from - 1e-3, &reached) == LW_OK;
    lw_newton_free(n);
    return moves;
}

/* The default limits, but sizes up to two diagonals: the front of larger linkages takes most of the time. */
static void set_limits(lw_topology_search_options *o, const lw_target *t)
{
    o->fit.spec.max_size = 2;
    lw_fit_spec_set_limits(&o->fit.spec, t, LW_LIMIT_SIZE);
}

static double best_of(const lw_topology_search *s) { return s->found.fit.candidate[0].objective; }

TEST(six_links_are_never_worse_than_four)
{
    OWN(lw_target) t = target();
    lw_topology_search_options o = options(4, 2);
    OWN(lw_topology_search) four = { 0 }, six = { 0 }, again = { 0 };
    OWN(lw_fit) fit = { 0 };
    CHECK_INT(lw_topology_search_run(&t, &o, &four, NULL), LW_OK);
    o.fit.spec.crank_only = o.fit.spec.exclude_drag_link = true;
    CHECK_INT(lw_fit_run(&t, &o.fit, &fit, NULL), LW_OK);
    CHECK(best_of(&four) <= fit.candidate[0].objective);           /* it holds the search of cranks alone */
    o = options(6, 2);
    CHECK_INT(lw_topology_search_run(&t, &o, &six, NULL), LW_OK);
    CHECK(best_of(&six) <= best_of(&four));
    CHECK(six.results.n > 0 && six.n_links == 2 && six.by_links[0].links == 4 && six.by_links[1].links == 6);
    for (int i = 0; i < six.results.n; i++)
        CHECK(six.results.report[i].verified && drives(&six.results.report[i].linkage));
    o = options(6, 1);
    CHECK_INT(lw_topology_search_run(&t, &o, &again, NULL), LW_OK);
    CHECK_INT(six.found.fit.n, again.found.fit.n);
    for (int i = 0; i < six.found.fit.n && i < again.found.fit.n; i++) {
        const lw_candidate *a = &six.found.fit.candidate[i], *b = &again.found.fit.candidate[i];
        CHECK(a->objective == b->objective && strcmp(a->family->name, b->family->name) == 0);
        CHECK(memcmp(a->dim, b->dim, sizeof *a->dim*(size_t)a->n_dim) == 0);
    }
}

/* With default limits, too: cranks, the others, both ways, variants for the front, reports by several threads.  The front
 * holds the least error, but for the 2 % by which a row has to be better than each before it, and more rounds are never worse. */
TEST(default_limits_give_one_answer)
{
    OWN(lw_target) t = target();
    lw_topology_search found[3];
    double least[3] = { INFINITY, INFINITY, INFINITY };
    for (int i = 0; i < 3; i++) {
        lw_topology_search_options o = options(4, i == 1 ? 3 : 1);
        o.fit.max_rounds = i == 2 ? 2 : 1;
        set_limits(&o, &t);
        CHECK_INT(lw_topology_search_run(&t, &o, &found[i], NULL), LW_OK);
        const lw_fit_results *r = &found[i].results;
        for (int k = 0; k < r->n; k++)
            least[i] = fmin(least[i], found[i].found.fit.candidate[r->candidate[k]].objective);
        CHECK(r->n > 0 && r->n <= 3);
    }
    CHECK_INT(found[0].results.n, found[1].results.n);
    for (int k = 0; k < found[0].results.n && k < found[1].results.n; k++) {
        const lw_fit_report *a = &found[0].results.report[k], *b = &found[1].results.report[k];
        CHECK(a->objective == b->objective && a->size == b->size && a->transmission_min == b->transmission_min);
    }
    CHECK(least[2] <= 1.02*1.02*least[0]);               /* squares */
    for (int i = 0; i < 3; i++)
        lw_topology_search_free(&found[i]);
}

/* A smooth curve of three random harmonics, or two thirds of it. */
static lw_target random_target(lw_rng *rng, bool closed)
{
    enum { N = 16 };
    double x[N], y[N], part = closed ? 1 : 0.67, a[3], b[3], c[3], d[3];
    lw_target t;
    for (int h = 0; h < 3; h++) {
        a[h] = lw_rng_normal(rng)/(h*h + 1), b[h] = lw_rng_normal(rng)/(h*h + 1);
        c[h] = lw_rng_normal(rng)/(h*h + 1), d[h] = lw_rng_normal(rng)/(h*h + 1);
    }
    for (int i = 0; i < N; i++) {
        double u = 2*LW_PI*part*i/N;
        x[i] = y[i] = 0;
        for (int h = 0; h < 3; h++) {
            x[i] += a[h]*cos((h + 1)*u) + b[h]*sin((h + 1)*u);
            y[i] += c[h]*cos((h + 1)*u) + d[h]*sin((h + 1)*u);
        }
    }
    CHECK_INT(lw_target_make(N, x, y, NULL, NULL, NULL, closed, &t, NULL), LW_OK);
    return t;
}

/* The least of each measure over the rows: error, stray, Chamfer distance, size, and the greatest transmission angle up to 45
 * degrees. */
static void best_rows(const lw_fit_results *r, double best[5])
{
    for (int k = 0; k < 5; k++)
        best[k] = INFINITY;
    for (int i = 0; i < r->n; i++) {
        const lw_fit_report *p = &r->report[i];
        const double all[5] = { p->error_rms, lw_fit_report_stray(p), p->likeness.chamfer, p->size, -fmin(p->transmission_min, LW_PI/4) };
        for (int k = 0; k < 5; k++)
            best[k] = fmin(best[k], all[k]);
    }
}

/* A search of all four-bars holds that of cranks alone: with default limits no measure of its rows is worse, beyond the 2 % by which
 * rows are twins. */
TEST(rows_are_never_worse_than_those_of_cranks)
{
    lw_rng rng = check_rng(0);
    for (int trial = 0; trial < 2; trial++) {
        OWN(lw_target) t = random_target(&rng, trial % 2 == 0);
        double best[2][5];
        for (int cranks = 0; cranks < 2; cranks++) {
            lw_topology_search_options o = options(4, 1);
            OWN(lw_topology_search) found = { 0 };
            o.fit.n_result = 10;
            set_limits(&o, &t);
            if (cranks)
                o.fit.spec.crank_only = o.fit.spec.exclude_drag_link = true;
            lw_status st = lw_topology_search_run(&t, &o, &found, NULL);
            best[cranks][0] = INFINITY;
            CHECK(st == LW_OK || st == LW_NOTHING);
            if (st != LW_OK)
                continue;
            best_rows(&found.results, best[cranks]);
        }
        for (int k = 0; k < 5 && best[1][0] < INFINITY; k++)
            CHECK(best[0][k] <= best[1][k] + 0.021*fabs(best[1][k]));
    }
}

/* Stops a search as soon as it begins with six links. */
static void stop_at_six(void *stop, int links) { *(int *)stop = links == 6; }

/* Six links are searched if no four-bar counts as missing a function by less than 2.5 %: a rise with two dwells, but no small sine. */
TEST(functions_go_on_to_six_links)
{
    enum { N = 18 };                                      /* more than few stations, for which 1 % is asked */
    for (int dwells = 0; dwells < 2; dwells++) {
        double input[N], output[N];
        for (int i = 0; i < N; i++) {
            input[i] = 2*LW_PI*i/N;
            output[i] = dwells ? fmin(1, fmax(-1, 2*sin(input[i]))) : 0.1*sin(input[i]);
        }
        lw_topology_search_options o = lw_topology_search_options_default();
        OWN(lw_topology_search) found = { 0 };
        OWN(lw_target) t = { 0 };
        CHECK_INT(lw_target_make(N, NULL, NULL, output, input, NULL, 1, &t, NULL), LW_OK);
        int stop = 0;
        o.more = true;
        o.fit.spec.task = LW_TASK_FUNCTION;
        o.fit.begun = stop_at_six;
        o.fit.context = &stop;
        o.fit.interrupt = &stop;
        o.fit.starts = 40;
        o.fit.max_rounds = 1;
        lw_fit_spec_set_limits(&o.fit.spec, &t, 0);
        CHECK_INT(lw_topology_search_run(&t, &o, &found, NULL), dwells ? LW_STOPPED : LW_OK);
        CHECK_INT(stop, dwells);
    }
}

typedef struct watcher { int calls, stop; bool in_range; } watcher;

static void watch(void *context, double done, double seconds, double best)
{
    watcher *w = context;
    (void)seconds;
    (void)best;
    w->calls++;
    w->in_range &= done >= 0 && done <= 1;
    w->stop = 1;
}

/* A mechanism moves as one with fewer links only if it does with every joint at the ground as the input. */
TEST(the_joint_chosen_as_input_does_not_decide)
{
    lw_mechanism_request ask = { .links = 8, .dof = 1, .kinds = "r", .only = "all", .task = LW_TASK_PATH, .jobs = 1 };
    OWN(lw_mechanism_set) one = { 0 }, each = { 0 };
    CHECK_INT(lw_mechanism_set_make(&ask, &one, NULL), LW_OK);
    ask.timed = true;
    CHECK_INT(lw_mechanism_set_make(&ask, &each, NULL), LW_OK);
    for (int s = 0; s < 2; s++) {
        CHECK_INT(one.stage[s].tally.outcome[LW_PAIR_FITTED], s ? 170 : 8);
        for (int o = 0; o < LW_PAIR_OUTCOMES; o++)
            CHECK_INT(one.stage[s].tally.outcome[o], each.stage[s].tally.outcome[o]);
    }
}

TEST(progress_is_told_and_the_stop_flag_honoured)
{
    OWN(lw_target) t = target();
    lw_topology_search_options o = options(6, 1);
    OWN(lw_topology_search) s = { 0 };
    watcher w = { .in_range = true };
    o.fit.progress = watch;
    o.fit.context = &w;
    o.fit.interrupt = &w.stop;
    CHECK_INT(lw_topology_search_run(&t, &o, &s, NULL), LW_STOPPED);
    CHECK(w.calls > 0 && w.in_range);
    CHECK_INT(s.found.fit.stop, LW_STOP_USER);
    CHECK(s.found.fit.n > 0);                                      /* what the first round found is kept */
    CHECK(s.results.n > 0);                                        /* and simulated until one can be shown  */
    CHECK_INT(s.results.n_unseen, s.found.fit.n - s.results.n_left_out - s.results.n);
    CHECK(s.results.n_unseen > 0);
}
