/* Searches by number of links: a six-bar's curve is found again, more links are never worse, and the answer does
 * not depend on the number of threads. */
#include "mbs/plan/types.h"
#include "optimise/report/results.h"
#include "optimise/topology/staged_search.h"
#include "tests/six_bar.h"

static lw_fit_options options(lw_timing timing, int jobs)
{
    lw_fit_options o = lw_fit_options_default();
    o.spec.timing = timing;
    o.jobs = jobs;
    o.budget = 60000;
    o.max_rounds = 6;
    o.n_result = 5;
    return o;
}

/* Best objective with so many links. */
static double best_of(const lw_staged_search *s, int links)
{
    double best = INFINITY;
    for (int i = 0; i < s->fit.n; i++)
        if (lw_candidate_links(&s->fit.candidate[i]) == links)
            best = fmin(best, s->fit.candidate[i].objective);
    return best;
}

TEST(the_true_topology_gives_the_curve_back)
{
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4 }, { .links = 6, .families = lw_families_of(&f, 1) } };
    lw_fit_options o = options(LW_TIMING_PRESCRIBED, 0);
    OWN(lw_target) t = { 0 };
    OWN(lw_staged_search) s = { 0 };
    lw_error e = { .text = "" };
    o.max_rounds = 40;
    o.budget = 1000000;
    six_bar_target(&k, 40, true, &t);
    CHECK_INT(lw_staged_search_run(&t, &o, stage, 2, &s, &e), LW_OK);
    CHECK(best_of(&s, 6) < 1e-20);
    CHECK(best_of(&s, 4) > 1e-4);
    FREED lw_fit_report *r = malloc(sizeof *r);
    CHECK_INT(lw_fit_report_make(&t, &o.spec, &s.fit.candidate[0], r, &e), LW_OK);
    CHECK(r->verified && r->error_max < 1e-9);
}

TEST_OF_FIGURES(more_links_are_never_worse)
{
    static const double px[] = { 0, 1, 2, 3, 3, 2.6, 1.5, 0.4 }, py[] = { 0, 0.2, 0, 0.3, 1.2, 2, 1.7, 1.4 };
    lw_linkage k = six_bar();
    lw_family six = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4 }, { .links = 6, .families = lw_families_of(&six, 1) },
                         { .links = 8, .families = lw_families_of(NULL, 0) } };     /* of eight only grown ones */
    lw_fit_options o = options(LW_TIMING_FREE, 0);
    OWN(lw_target) t = { 0 };
    OWN(lw_staged_search) s = { 0 };
    o.budget = 15000;
    CHECK_INT(lw_target_make(8, px, py, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    CHECK_INT(lw_staged_search_run(&t, &o, stage, 3, &s, NULL), LW_OK);
    CHECK(best_of(&s, 6) <= best_of(&s, 4)*(1 + 1e-9) + 1e-26);      /* f of an exact fit is rounding */
    CHECK(best_of(&s, 8) <= best_of(&s, 6)*(1 + 1e-9) + 1e-26);
    CHECK(s.stage[2].n_grown > 4);
    for (int i = 0; i < s.fit.n; i++) {
        FREED lw_fit_report *r = malloc(sizeof *r);
        CHECK_INT(lw_fit_report_make(&t, &o.spec, &s.fit.candidate[i], r, NULL), LW_OK);
        CHECK_NEAR(r->objective, s.fit.candidate[i].objective, 1e-12, 1e-6);
    }
}

/* A target that no linkage of these stages meets, so that no search ends early. */
static void make_unmet(const lw_linkage *k, lw_target *t)
{
    six_bar_target(k, 9, true, t);
    for (int i = 0; i < 9; i += 3)
        t->x[i] += i % 2 ? 0.4 : -0.4;
}

/* A time limit that does not end the search makes parts of it. */
TEST(stages_are_searched_in_parts)
{
    lw_linkage k = six_bar();
    lw_family six = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4 }, { .links = 6, .families = lw_families_of(&six, 1) },
                         { .links = 8, .families = lw_families_of(NULL, 0) } };
    lw_fit_options o = options(LW_TIMING_FREE, 0);
    OWN(lw_staged_search) s = { 0 };
    OWN(lw_target) t = { 0 };
    o.budget = 2000;
    o.max_rounds = 8;
    o.max_seconds = 1e4;
    make_unmet(&k, &t);
    CHECK_INT(lw_staged_search_run(&t, &o, stage, 3, &s, NULL), LW_OK);
    CHECK_INT(s.stage[0].n_part, 6);                     /* twice a thirty-second, then 1/16, 1/8, ... of its rounds */
    CHECK_INT(s.stage[1].n_part, 3);                     /* a quarter, half, a quarter of its evaluations     */
    CHECK_INT(s.stage[2].n_part, 3);
}

/* A user who stops the search after so many rounds. */
typedef struct stopper { int rounds, most, stop; } stopper;

static void count_round(void *context, double done, double seconds, double best)
{
    (void)done, (void)seconds, (void)best;
    stopper *s = context;
    s->stop = ++s->rounds >= s->most;
}

/* Stops a search in its fourth part. */
typedef struct in_parts { int part, stop; double done; } in_parts;

static void count_part(void *context, double done, double seconds, double best)
{
    (void)seconds, (void)best;
    in_parts *s = context;
    s->part += done < s->done;
    s->done = done;
    s->stop = s->part == 3;
}

/* Without a budget a search goes on until the time ends: three parts are what it does without a limit. */
TEST(time_goes_beyond_the_usual_budget)
{
    lw_linkage k = six_bar();
    lw_family six = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage = { .links = 6, .families = lw_families_of(&six, 1) };
    lw_fit_options o = options(LW_TIMING_PRESCRIBED, 0);
    in_parts at = { .part = 0 };
    OWN(lw_staged_search) s = { 0 };
    OWN(lw_target) t = { 0 };
    make_unmet(&k, &t);
    o.budget = 0;
    o.max_seconds = 1e4;
    o.progress = count_part;
    o.context = &at;
    o.interrupt = &at.stop;
    CHECK_INT(lw_staged_search_run(&t, &o, &stage, 1, &s, NULL), LW_STOPPED);
    CHECK_INT(s.fit.stop, LW_STOP_USER);
    CHECK_INT(s.stage[0].n_part, 4);
}

/* Under a time limit a search that is stopped later has done all that one stopped earlier has, and found nothing worse. */
TEST(more_time_is_never_worse)
{
    lw_linkage k = six_bar();
    lw_family six = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4 }, { .links = 6, .families = lw_families_of(&six, 1) } };
    double least[2] = { INFINITY, INFINITY };
    OWN(lw_target) t = { 0 };
    make_unmet(&k, &t);
    for (int most = 2; most <= 10; most += 4) {
        lw_fit_options o = options(LW_TIMING_FREE, 0);
        stopper stop = { .most = most };
        OWN(lw_staged_search) s = { 0 };
        o.max_rounds = 8;
        o.budget = 5000;
        o.max_seconds = 1e4;
        o.progress = count_round;
        o.context = &stop;
        o.interrupt = &stop.stop;
        CHECK_INT(lw_staged_search_run(&t, &o, stage, 2, &s, NULL), LW_STOPPED);
        CHECK_INT(stop.rounds, most);
        for (int links = 4; links <= 6; links += 2) {
            CHECK(best_of(&s, links) <= least[links/2 - 2]*(1 + 1e-9));
            least[links/2 - 2] = best_of(&s, links);
        }
    }
}

/* Small linkages are among those kept, though many larger ones of many parts have less error. */
TEST_OF_FIGURES(small_linkages_are_kept)
{
    enum { N = 8 };
    double px[N], py[N];
    for (int i = 0; i < N; i++)
        px[i] = i/(N - 1.0), py[i] = 0;
    lw_fit_options o = lw_fit_options_default();
    lw_search_stage stage = { .links = 4 };
    OWN(lw_target) t = { 0 };
    OWN(lw_staged_search) s = { 0 };
    int small = 0;
    o.spec.by_default = LW_LIMIT_ALL;
    o.max_rounds = 1;
    o.max_seconds = 1e4;                                /* so that it searches in parts */
    CHECK_INT(lw_target_make(N, px, py, NULL, NULL, NULL, 0, &t, NULL), LW_OK);
    CHECK_INT(lw_staged_search_run(&t, &o, &stage, 1, &s, NULL), LW_OK);
    for (int i = 0; i < s.fit.n; i++)
        small += s.fit.candidate[i].part == LW_FIT_COMPACT;
    CHECK(2*small > lw_fit_kept(&o));                   /* less the same linkages found again */
    FREED lw_fit_report *r = malloc(sizeof *r);
    double least = INFINITY;                            /* and those of middle size are fitted: a straight line has many exact large ones */
    for (int i = 0; i < s.fit.n && r; i++)
        if (s.fit.candidate[i].beyond == 0 && lw_fit_report_make(&t, &o.spec, &s.fit.candidate[i], r, NULL) == LW_OK && r->turns
            && r->size < 2.5 && r->transmission_min > 30*LW_PI/180)
            least = fmin(least, r->error_max);
    CHECK(least < 1e-4);
}

/* Least objective of the results that turn, of at most this size and with a transmission angle of 40 degrees. */
static double least_within(const lw_target *t, const lw_fit_spec *spec, const lw_staged_search *s, double size)
{
    double least = INFINITY;
    FREED lw_fit_report *r = malloc(sizeof *r);
    for (int i = 0; i < s->fit.n && r; i++)
        if (s->fit.candidate[i].beyond == 0 && lw_fit_report_make(t, spec, &s->fit.candidate[i], r, NULL) == LW_OK && r->turns
            && r->verified && r->size <= 1.001*size*t->extent && r->transmission_min >= 40*LW_PI/180 - 1e-4)
            least = fmin(least, s->fit.candidate[i].objective);
    return least;
}

/* Results of each size and transmission angle are nearly as good as those of a search with these as its limits; they may be larger by
 * a step from size to size. */
TEST_OF_FIGURES(the_front_has_no_gaps)
{
    enum { N = 10 };
    static const double size[] = { 1.4, 1.96 };
    double px[N], py[N];
    for (int i = 0; i < N; i++) {
        px[i] = 2*cos(2*LW_PI*i/N);
        py[i] = sin(2*LW_PI*i/N);
    }
    lw_fit_options o = lw_fit_options_default();
    lw_search_stage stage = { .links = 4 };
    OWN(lw_target) t = { 0 };
    lw_staged_search all, limited;
    o.spec.by_default = LW_LIMIT_ALL;
    o.max_rounds = 1;
    CHECK_INT(lw_target_make(N, px, py, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    CHECK_INT(lw_staged_search_run(&t, &o, &stage, 1, &all, NULL), LW_OK);
    for (int i = 0; i < 2; i++) {
        lw_fit_options mine = o;
        mine.spec.min_transmission = 40*LW_PI/180;
        mine.spec.length_lo = 0.01;
        mine.spec.length_hi = size[i]*t.extent;
        CHECK_INT(lw_staged_search_run(&t, &mine, &stage, 1, &limited, NULL), LW_OK);
        CHECK(least_within(&t, &o.spec, &all, size[i]/0.9) < 1.3*least_within(&t, &mine.spec, &limited, size[i]));
        lw_staged_search_free(&limited);
    }
    lw_staged_search_free(&all);
}

/* The least lw_fit_report.counts_as of four-bars for a closed path of 24 stations. */
static double first_four_bar(double x[24], double y[24])
{
    lw_fit_options o = lw_fit_options_default();
    lw_search_stage stage = { .links = 4 };
    lw_fit_results rows;
    OWN(lw_target) t = { 0 };
    OWN(lw_staged_search) s = { 0 };
    o.max_rounds = 1;
    CHECK_INT(lw_target_make(24, x, y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    lw_fit_spec_set_limits(&o.spec, &t, 0);
    CHECK_INT(lw_staged_search_run(&t, &o, &stage, 1, &s, NULL), LW_OK);
    CHECK_INT(lw_fit_results_make(&t, &o.spec, &s.fit, 10, NULL, NULL, &rows, NULL), LW_OK);
    double counts_as = rows.n > 0 ? rows.report[0].counts_as : INFINITY;
    lw_fit_results_free(&rows);
    return counts_as;
}

/* Five poses of a garage door are met to a thousandth of their diagonal by linkages of many shapes.  Of these a search that knows what they
 * count as finds one that counts as less than the best of those which least squares happens to reach, and the second simulation agrees.
 * Another seed and the mirror image find one that counts as much. */
TEST_OF_FIGURES(poses_are_met_by_the_linkage_that_counts_as_least)
{
    enum { UNKNOWN, KNOWN, MIRRORED, RUNS };
    double x[] = { 0, 0.15, 0.5, 0.95, 1.25 }, y[] = { 1.05, 1.35, 1.75, 2.1, 2.2 }, theta[] = { 90, 75, 45, 15, 0 }, least[RUNS];
    for (int i = 0; i < 5; i++)
        theta[i] *= LW_PI/180;
    for (int run = 0; run < RUNS; run++) {
        lw_fit_options o = lw_fit_options_default();
        lw_fit_results rows;
        OWN(lw_fit) fit = { 0 };
        OWN(lw_target) t = { 0 };
        for (int i = 0; i < 5 && run == MIRRORED; i++) {
            y[i] *= -1;
            theta[i] *= -1;
        }
        CHECK_INT(lw_target_make(5, x, y, theta, NULL, NULL, 0, &t, NULL), LW_OK);
        o.spec.task = LW_TASK_MOTION;
        o.max_rounds = 1;
        o.starts = 1;
        o.seed = run == MIRRORED ? 2 : 1;
        o.cost = run == UNKNOWN ? NULL : lw_fit_results_cost;
        lw_fit_spec_set_limits(&o.spec, &t, 0);
        CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_OK);
        CHECK_INT(lw_fit_results_make(&t, &o.spec, &fit, 10, NULL, NULL, &rows, NULL), LW_OK);
        least[run] = rows.n > 0 ? rows.report[0].counts_as : INFINITY;
        CHECK(rows.n > 0 && rows.report[0].verified);
        lw_fit_results_free(&rows);
    }
    CHECK(least[KNOWN] < 0.8*least[UNKNOWN]);
    CHECK_NEAR(least[MIRRORED], least[KNOWN], 0, 0.1);
}

/* A path whose stations come in the opposite order has other starts, and chains along which other sizes are found.  The front of its
 * linkages is as dense, so the first row is as good. */
TEST_OF_FIGURES(the_direction_changes_no_first_row)
{
    double x[24], y[24], back_x[24], back_y[24];
    for (int i = 0; i < 24; i++) {                        /* a foot: a line, and half an ellipse back above it  */
        double angle = LW_PI*(i - 12)/12;
        x[i] = i < 12 ? 40 - 80.0*i/12 : -40*cos(angle);
        y[i] = i < 12 ? 0 : 24*sin(angle);
        back_x[23 - i] = x[i];
        back_y[23 - i] = y[i];
    }
    CHECK_NEAR(first_four_bar(back_x, back_y), first_four_bar(x, y), 0, 0.02);
}

static void make_open_path(const lw_linkage *k, lw_target *t)
{
    enum { N = 8 };
    double x[2*N], y[2*N], angle[2*N];
    six_bar_curve(k, 2*N, x, y, angle);
    for (int i = 0; i < N; i += 2)
        y[i] += 0.05;
    CHECK_INT(lw_target_make(N, x, y, NULL, NULL, NULL, 0, t, NULL), LW_OK);
}

/* Two stages of one family each, a four-link mechanism whose slider drives it, and a six-bar, for an open path with default limits. */
static void search_open_path(bool crank_only, double tolerance, double max_seconds, int n_stage, double unless, long budget, lw_staged_search *s)
{
    lw_linkage slider, k = six_bar();
    lw_type_linkage(lw_type_find("sliderdriven"), &slider);
    lw_family four = { .name = "slider", .linkage = &slider, .links = 4 }, six = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4, .families = lw_families_of(&four, 1) },
                                { .links = 6, .families = lw_families_of(&six, 1), .unless = unless } };
    lw_fit_options o = lw_fit_options_default();
    OWN(lw_target) t = { 0 };
    o.spec.timing = LW_TIMING_FREE;
    o.spec.crank_only = o.spec.exclude_drag_link = crank_only;
    o.spec.tolerance = tolerance;
    o.budget = budget;
    o.max_seconds = max_seconds;
    make_open_path(&k, &t);
    lw_fit_spec_set_limits(&o.spec, &t, 0);
    CHECK_INT(lw_staged_search_run(&t, &o, stage, n_stage, s, NULL), LW_OK);
}

static bool holds(const lw_staged_search *s, const lw_candidate *c)
{
    bool found = false;
    for (int i = 0; i < s->fit.n && !found; i++)
        found = s->fit.candidate[i].n_dim == c->n_dim && memcmp(s->fit.candidate[i].dim, c->dim, sizeof *c->dim*(size_t)c->n_dim) == 0;
    return found;
}

/* A search for all linkages finds all that one for cranks alone finds. */
TEST(a_search_of_all_holds_that_of_cranks)
{
    OWN(lw_staged_search) all = { 0 }, cranks = { 0 };
    search_open_path(false, 0, 0, 2, 0, 2000, &all);
    search_open_path(true, 0, 0, 2, 0, 2000, &cranks);
    CHECK(cranks.fit.n > 1 && all.stage[1].n_of[1] > 0);
    for (int i = 0; i < cranks.fit.n; i++)
        CHECK(holds(&all, &cranks.fit.candidate[i]));
}

/* A search with a tolerance finds all that one without it finds, and smaller linkages within it. */
TEST(a_search_within_a_tolerance_holds_that_without)
{
    OWN(lw_staged_search) all = { 0 }, within = { 0 };
    int smaller = 0;
    search_open_path(false, 0, 0, 2, 0, 2000, &all);
    search_open_path(false, 1, 0, 2, 0, 2000, &within);
    CHECK(all.fit.n > 1);
    for (int i = 0; i < all.fit.n; i++)
        CHECK(holds(&within, &all.fit.candidate[i]));
    for (int i = 0; i < within.fit.n; i++)
        smaller += within.fit.candidate[i].shrunk;
    CHECK(smaller > 0);
}

/* A larger budget finds all that a smaller one finds, so its first row is no worse; also one that ends within a part, of which it makes
 * the first searches. */
TEST(a_larger_budget_is_never_worse)
{
    static const long budget[] = { 10000, 15000, 20000 };
    enum { RUNS = sizeof budget/sizeof *budget };
    lw_staged_search s[RUNS];
    double first[RUNS];
    lw_linkage k = six_bar();
    lw_fit_spec spec = lw_fit_spec_default();
    OWN(lw_target) t = { 0 };
    make_open_path(&k, &t);
    spec.timing = LW_TIMING_FREE;
    lw_fit_spec_set_limits(&spec, &t, 0);
    for (int r = 0; r < RUNS; r++) {
        lw_fit_results rows;
        search_open_path(false, 0, 0, 2, 0, budget[r], &s[r]);
        CHECK_INT(lw_fit_results_make(&t, &spec, &s[r].fit, 10, NULL, NULL, &rows, NULL), LW_OK);
        first[r] = rows.n > 0 ? rows.report[0].counts_as : INFINITY;
        lw_fit_results_free(&rows);
        CHECK(isfinite(first[r]));
        for (int i = 0; r > 0 && i < s[r - 1].fit.n; i++)
            CHECK(holds(&s[r], &s[r - 1].fit.candidate[i]));
        CHECK(r == 0 || (first[r] <= first[r - 1] && s[r].stage[0].n_part > s[r - 1].stage[0].n_part));
    }
    for (int r = 0; r < RUNS; r++)
        lw_staged_search_free(&s[r]);
}

/* A linkage whose input rocks is near enough: then cranks are searched, and only they. */
TEST(more_links_are_left_out_if_a_crank_is_enough)
{
    OWN(lw_staged_search) s = { 0 };
    search_open_path(false, 0, 0, 2, 1e9, 400, &s);
    CHECK_INT(s.n_stage, 2);
    CHECK(s.stage[1].n_of[0] > 0);
    CHECK_INT(s.stage[1].n_of[1], 0);
}

/* Search a four-bar, then a six-bar unless the first row of the four-bars counts as no more than `unless`, for a straight line, along which a
 * level body moves if `level`.  near: how near four-bars are, as a part of the diagonal; counts_as: of the first row of the four-bars. */
static int stages_of_a_line(bool level, double unless, double *near, double *counts_as)
{
    double x[9], y[9] = { 0 }, theta[9] = { 0 };
    lw_linkage four, k = six_bar();
    lw_type_linkage(lw_type_find("fourbar"), &four);
    lw_family bars = { .name = "four-bar", .linkage = &four, .links = 4 }, six = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4, .families = lw_families_of(&bars, 1) },
                                { .links = 6, .families = lw_families_of(&six, 1), .unless = unless, .budget = 10 } };
    lw_fit_options o = lw_fit_options_default();
    FREED lw_fit_report *r = malloc(sizeof *r);
    OWN(lw_staged_search) s = { 0 };
    OWN(lw_target) t = { 0 };
    for (int i = 0; i < 9; i++)
        x[i] = i;
    CHECK_INT(lw_target_make(9, x, y, level ? theta : NULL, NULL, NULL, 0, &t, NULL), LW_OK);
    o.spec.task = level ? LW_TASK_MOTION : LW_TASK_PATH;
    o.spec.timing = LW_TIMING_FREE;
    o.budget = level ? 10000 : 300;                           /* the front of large four-bars takes more                 */
    lw_fit_spec_set_limits(&o.spec, &t, 0);
    CHECK_INT(lw_staged_search_run(&t, &o, stage, 2, &s, NULL), LW_OK);
    lw_fit four_bars = { .candidate = s.fit.candidate };      /* the first by error: with a crank, or no row              */
    lw_fit_results rows;
    *near = INFINITY;
    for (int i = 0; i < s.fit.n; i++) {
        lw_candidate c = s.fit.candidate[i];
        if (lw_candidate_links(&c) != 4 || c.part == LW_FIT_OTHERS)
            continue;
        s.fit.candidate[i] = s.fit.candidate[four_bars.n];
        s.fit.candidate[four_bars.n++] = c;
        if (lw_fit_report_make(&t, &o.spec, &c, r, NULL) == LW_OK && r->verified && !r->broken)
            *near = fmin(*near, lw_fit_report_distance(&t, r)/t.extent);
    }
    CHECK_INT(lw_fit_results_make(&t, &o.spec, &four_bars, 24, NULL, NULL, &rows, NULL), LW_OK);
    *counts_as = rows.n > 0 ? rows.report[0].counts_as : INFINITY;
    lw_fit_results_free(&rows);
    int n = s.n_stage;
    return n;
}

/* A four-bar that is near the target but large, or has small transmission angles, is no reason to leave six links out. */
TEST(six_links_follow_where_the_first_row_counts_as_far)
{
    double near, counts_as, again[2];
    CHECK_INT(stages_of_a_line(false, INFINITY, &near, &counts_as), 1);
    CHECK(near < 0.5*counts_as && counts_as < INFINITY);
    CHECK_INT(stages_of_a_line(false, 1.01*counts_as, &again[0], &again[1]), 1);
    CHECK_INT(stages_of_a_line(false, 0.99*counts_as, &again[0], &again[1]), 2);
}

/* The jaw of a gripper: four-bars are within LW_NEAR of its poses, but only large ones. */
TEST(six_links_where_a_large_four_bar_would_be_first)
{
    double near, counts_as;
    CHECK_INT(stages_of_a_line(true, LW_ENOUGH, &near, &counts_as), 2);
    CHECK(near < LW_NEAR && counts_as > LW_ENOUGH);
}

/* Under a time limit reports are made during the search: when the time ends, the rows are chosen among all that was found. */
TEST(reports_are_made_before_the_time_ends)
{
    OWN(lw_staged_search) s = { 0 };
    int n_report = 0;                                   /* they may take as long as the search: on a busy machine some are left for later */
    search_open_path(false, 0, 1e4, 1, 0, 400, &s);
    CHECK(s.fit.n > 1);
    for (int i = 0; i < s.fit.n; i++)
        n_report += s.fit.candidate[i].report != NULL;
    CHECK(n_report > 0);
}

TEST(threads_do_not_change_the_answer)
{
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .links = 6 };
    lw_search_stage stage[] = { { .links = 4 }, { .links = 6, .families = lw_families_of(&f, 1) } };
    OWN(lw_target) t = { 0 };
    lw_staged_search s[2];
    six_bar_target(&k, 12, false, &t);
    for (int i = 0; i < 2; i++) {
        lw_fit_options o = options(LW_TIMING_FREE, 1 + 2*i);
        o.budget = 20000;
        o.max_rounds = 3;
        CHECK_INT(lw_staged_search_run(&t, &o, stage, 2, &s[i], NULL), LW_OK);
    }
    CHECK_INT(s[0].fit.n, s[1].fit.n);
    CHECK_INT(s[0].fit.evals, s[1].fit.evals);
    for (int i = 0; i < s[0].fit.n && i < s[1].fit.n; i++)
        CHECK(memcmp(s[0].fit.candidate[i].dim, s[1].fit.candidate[i].dim, sizeof(double)*(size_t)s[0].fit.candidate[i].n_dim) == 0);
    lw_staged_search_free(&s[0]);
    lw_staged_search_free(&s[1]);
}

/* A linkage to start from is tried in both senses: a target drawn the other way round is met at once, too. */
TEST(a_start_may_run_either_way)
{
    enum { N = 32 };                                     /* as many families as a round has jobs      */
    static lw_family list[N];
    lw_linkage k = six_bar();
    double x[18], y[18], angle[18], back_x[18], back_y[18];
    six_bar_curve(&k, 18, x, y, angle);
    for (int i = 0; i < 18; i++) {
        back_x[i] = x[17 - i];
        back_y[i] = y[17 - i];
    }
    for (int i = 0; i < N; i++)
        list[i] = (lw_family){ .name = "six-bar", .linkage = &k, .posture = i == 0, .links = 6 };
    lw_families f = lw_families_of(list, N);
    for (int back = 0; back < 2; back++) {
        lw_fit_options o = options(LW_TIMING_FREE, 0);
        OWN(lw_target) t = { 0 };
        OWN(lw_fit) fit = { 0 };
        o.families = &f;
        o.max_rounds = 1;
        CHECK_INT(lw_target_make(18, back ? back_x : x, back ? back_y : y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
        CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_OK);
        CHECK(fit.n > 0 && fit.candidate[0].objective < 1e-20);
    }
}

/* A Stephenson III whose pins are some percent off the one that drew the curve: its curve is far off, drawn linkages are nearer, but from
 * it alone a narrow valley leads to the exact one. */
static const char off_linkage[] =
    "{\"linkwright\":1,\"links\":[\"ground\",\"crank\",\"coupler\",\"rocker\",\"fifth\",\"sixth\"],\"ground\":\"ground\",\"joints\":["
    "{\"name\":\"O\",\"kind\":\"r\",\"links\":[\"ground\",\"crank\"],\"at\":[0.38,0.374]},"
    "{\"name\":\"A\",\"kind\":\"r\",\"links\":[\"crank\",\"coupler\"],\"at\":[0.314,0.493]},"
    "{\"name\":\"B\",\"kind\":\"r\",\"links\":[\"coupler\",\"rocker\"],\"at\":[0.956,-0.115]},"
    "{\"name\":\"C\",\"kind\":\"r\",\"links\":[\"rocker\",\"ground\"],\"at\":[-0.406,0.09]},"
    "{\"name\":\"P\",\"kind\":\"r\",\"links\":[\"coupler\",\"fifth\"],\"at\":[0.302,0.316]},"
    "{\"name\":\"D\",\"kind\":\"r\",\"links\":[\"fifth\",\"sixth\"],\"at\":[0.927,-0.22]},"
    "{\"name\":\"S\",\"kind\":\"r\",\"links\":[\"ground\",\"sixth\"],\"at\":[-0.362,-0.546]}],"
    "\"input\":{\"joint\":\"O\",\"value\":0},\"tracers\":[{\"name\":\"T\",\"link\":\"fifth\",\"at\":[-0.386,-0.346]}]}";

/* Is the linkage that drew the curve found from pins moved by this much more? */
static bool found_from(double by, uint64_t stream)
{
    static const double x[] = { -0.3864314103, -0.381469212, -0.371949006, -0.359332543, -0.345823266,
    -0.3338144834, -0.3257242644, -0.3238647914, -0.3290763226, -0.3391239921,
    -0.349673706, -0.3572396508, -0.3609753117, -0.3622746058, -0.3633425728,
    -0.3659219283, -0.370611777, -0.3767546101, -0.3827378737, -0.3865494919 };
    static const double y[] = { -0.3455171706, -0.3944746265, -0.4503473585, -0.5088948686, -0.5662205389,
    -0.6183804356, -0.6600861993, -0.684394606, -0.6853777176, -0.6614504268,
    -0.61612828, -0.5563445604, -0.4901185555, -0.4249197279, -0.3669898981,
    -0.3212115872, -0.29109542, -0.2787116835, -0.2845900315, -0.3076876915 };
    lw_linkage k = { 0 };
    lw_rng rng;
    lw_error e = { .text = "" };
    CHECK_INT(lw_linkage_read(off_linkage, sizeof off_linkage - 1, "off", &k, &e), LW_OK);
    lw_rng_seed(&rng, 7, stream);
    for (int j = 0; j < k.n_joint; j++) {
        k.joint[j].at.x += by*lw_rng_normal(&rng);
        k.joint[j].at.y += by*lw_rng_normal(&rng);
    }
    lw_family f = { .name = "six-bar", .linkage = &k, .posture = true, .links = 6 };
    lw_families all = lw_families_of(&f, 1);
    lw_fit_options o = options(LW_TIMING_FREE, 1);
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) fit = { 0 };
    o.families = &all;
    o.budget = 1;
    o.max_rounds = 1;
    CHECK_INT(lw_target_make(20, x, y, NULL, NULL, NULL, 1, &t, &e), LW_OK);
    CHECK(lw_fit_run(&t, &o, &fit, &e) >= 0);
    return fit.n > 0 && fit.candidate[0].objective < 1e-16;
}

TEST(a_given_start_is_improved_though_drawn_ones_are_nearer)
{
    CHECK(found_from(0, 0));
}

/* Straight steps end beside the valley. */
TEST(steps_follow_the_bend_of_a_valley)
{
    CHECK(found_from(0.08, 29));
}

/* More families than a sweep may look at: some have their turn in a later one, some none, by any number of threads. */
TEST(families_beyond_a_sweep)
{
    enum { N = 120 };
    static lw_family list[N];
    lw_linkage k = six_bar();
    OWN(lw_target) t = { 0 };
    lw_fit fit[2];
    six_bar_target(&k, 9, false, &t);
    for (int i = 0; i < 9; i += 3)                       /* not to be met: no search ends early       */
        t.x[i] += i % 2 ? 0.4 : -0.4;
    for (int i = 0; i < N; i++)
        list[i] = (lw_family){ .name = "six-bar", .linkage = &k, .links = 6 };
    lw_families f = lw_families_of(list, N);
    for (int i = 0; i < 2; i++) {
        lw_fit_options o = options(LW_TIMING_FREE, 1 + 2*i);
        o.families = &f;
        o.sweep = 100;
        o.budget = 1000000;
        o.max_rounds = 6;
        CHECK_INT(lw_fit_run(&t, &o, &fit[i], NULL), LW_OK);
    }
    int count[LW_FIT_STATES] = { 0 };
    CHECK_INT(fit[0].n_state, N);
    for (int i = 0; i < N; i++)
        count[fit[0].state[i]]++;
    CHECK_INT(count[LW_FIT_CLOSED], 64);                 /* two sweeps of the 32 that keep threads busy */
    CHECK_INT(count[LW_FIT_UNREACHED], N - 64);
    CHECK(memcmp(fit[0].state, fit[1].state, N) == 0);
    CHECK_INT(fit[0].evals, fit[1].evals);
    CHECK_INT(fit[0].n, fit[1].n);
    for (int i = 0; i < fit[0].n && i < fit[1].n; i++) {
        const lw_candidate *a = &fit[0].candidate[i], *b = &fit[1].candidate[i];
        CHECK(a->family == &a->own->family && a->family->linkage == &a->own->linkage);
        CHECK(memcmp(a->dim, b->dim, sizeof(double)*(size_t)a->n_dim) == 0);
    }
    lw_fit_free(&fit[0]);
    lw_fit_free(&fit[1]);
}
