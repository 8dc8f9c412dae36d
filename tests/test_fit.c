/* The whole search, on published problems and hard targets; every claim is worked out again from the
 * dimensions by the four-bar of tests/mbs_linkage.h. */
#include "optimise/search/fit.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

/* ---- what a candidate is worth ------------------------------------------------------------------ */

static lw_vec2 coupler_point(const lw_candidate *c, double mode, double input)
{
    return fourbar_at(c->dim, mode, input).p;
}

static double mode_at(const lw_candidate *c, size_t i) { return c->mode_of ? c->mode_of[i] : c->intended.mode[0]; }

static double objective(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c)
{
    double f = 0;
    for (size_t i = 0; i < t->n; i++) {
        lw_vec2 p = coupler_point(c, mode_at(c, i), c->input[i]);
        f += s->a*t->weight[i]*(pow(p.x - t->x[i], 2) + pow(p.y - t->y[i], 2));
    }
    return f;
}

/* Stations far from the origin lose digits in their coordinates, and so does f; near a limit of motion
 * half of the digits of an input are lost. */
static void check_claim(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c)
{
    double far = 0;
    for (size_t i = 0; i < t->n; i++)
        far = fmax(far, fmax(fabs(t->x[i]), fabs(t->y[i])));
    double digits = 1e-14*far + (c->mode_of ? 1e-8 : 1e-12)*t->size;
    CHECK_NEAR(objective(t, s, c), c->objective, digits*digits + digits*sqrt(c->objective), 1e-9);
}

static void check_order(const lw_target *t, const lw_candidate *c)
{
    for (size_t i = 0; i + 1 < t->n; i++)
        CHECK(c->mode_of || c->intended.sense*(c->input[i + 1] - c->input[i]) >= 0);
    CHECK(c->mode_of || fabs(c->input[t->n - 1] - c->input[0]) <= 2*LW_PI + 1e-9);
}

/* Largest distance of curve a from the polygon of curve b. */
static double curve_gap(const lw_candidate *a, const lw_candidate *b)
{
    enum { N = 360 };
    lw_vec2 on_b[N + 1];
    double most = 0;
    for (int k = 0; k <= N; k++)
        on_b[k] = coupler_point(b, b->intended.mode[0], 2*LW_PI*k/N);
    for (int i = 0; i < N; i++) {
        lw_vec2 p = coupler_point(a, a->intended.mode[0], 2*LW_PI*i/N);
        double least = INFINITY;
        for (int k = 0; k < N; k++)
            least = lw_v2_nearer(p, on_b[k], on_b[k + 1], least);
        most = fmax(most, least);
    }
    return most;
}

static bool turns(const lw_candidate *c) { return c->family->turns; }

static void check_list(const lw_target *t, const lw_fit_options *o, const lw_fit *fit)
{
    for (int i = 0; i < fit->n; i++) {
        const lw_candidate *c = &fit->candidate[i];
        check_claim(t, &o->spec, c);
        CHECK(i == 0 || c->objective >= fit->candidate[i - 1].objective);
        if (o->spec.timing == LW_TIMING_FREE)
            check_order(t, c);
        for (int k = 0; k < i; k++)
            if (turns(c) && turns(&fit->candidate[k]))
                CHECK(curve_gap(c, &fit->candidate[k]) > 1e-5*t->size);
    }
}

/* ---- published problems ----------------------------------------------------------------------------- */

static void read_file(const char *path, lw_target *t)
{
    static char text[8192];
    lw_error e = { .text = "" };
    FILE *f = fopen(path, "r");
    size_t n = f ? fread(text, 1, sizeof text, f) : 0;
    if (f)
        fclose(f);
    CHECK_INT(lw_target_read(text, n, path, NULL, t, &e), LW_OK);
}

static void read_target(const char *name, lw_target *t)
{
    char path[128];
    snprintf(path, sizeof path, "catalogues/data/paths/%s.csv", name);
    read_file(path, t);
}

typedef struct published {
    const char *name;
    double      length_lo, length_hi, position;   /* coordinates in [-position, position]            */
    bool        frame, home;                      /* angles from the frame; x0 = y0 = theta0 = 0     */
    double      reachable;                        /* in the file's comments                          */
} published;

static const published problems[] = {
    { "arc5",         0, 50, 50, true,  true,  7.4158e-7  },
    { "arch6",        5, 50, 50, true,  false, 2.58036    },
    { "arch6",        0, 50, 50, true,  false, 1.2162     },
    { "closed18",     0, 50, 50, false, false, 9.0289e-3  },
    { "closed18free", 0, 50, 50, false, false, 1.7729e-3  },
    { "ellipse10",    5, 80, 80, false, false, 4.01992e-4 },
    { "line6",        5, 60, 60, false, false, 1e-25      },       /* 0 to rounding: (1e-14 * 45)^2 * 6 */
};
enum { N_PROBLEM = sizeof problems/sizeof *problems };

static lw_fit_options options_of(const published *p, const lw_target *t)
{
    static const char *const place[] = { "x0", "y0", "theta0" };
    lw_fit_options o = lw_fit_options_default();
    lw_fit_spec *s = &o.spec;
    s->timing = t->angle ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
    s->datum = p->frame ? LW_DATUM_FRAME : LW_DATUM_FREE;
    s->crank_only = s->exclude_drag_link = true;
    s->length_lo = p->length_lo;
    s->length_hi = p->length_hi;
    s->position_lo = -p->position;
    s->position_hi = p->position;
    for (int k = 0; p->home && k < 3; k++)
        snprintf(s->bound[s->n_bound++].name, sizeof s->bound[0].name, "%s", place[k]);
    return o;
}

/* Bounds of the file; the input shortest and turning. */
static void check_bounds(const published *p, const lw_candidate *c)
{
    const double *r = c->dim;
    for (int i = 0; i < 4; i++)
        CHECK(r[i] > 0 && r[i] >= p->length_lo*(1 - 1e-14) && r[i] <= p->length_hi*(1 + 1e-14));
    for (int i = 4; i < 8; i++)
        CHECK(fabs(r[i]) <= p->position*(1 + 1e-14));
    for (int i = 6; p->home && i < 9; i++)
        CHECK(r[i] == 0);
    CHECK(r[1] <= fmin(r[0], fmin(r[2], r[3])));
    double longest = fmax(r[0], fmax(r[2], r[3]));
    CHECK(2*(r[1] + longest) <= r[0] + r[1] + r[2] + r[3]);
}

/* Ends a search that has reached a figure. */
typedef struct figure { double wanted; int reached; } figure;

static void look_at(void *context, double done, double seconds, double best)
{
    (void)done, (void)seconds;
    figure *f = context;
    f->reached = best <= f->wanted;
}

TEST(reach_the_published_figures)
{
    for (int i = 0; i < check_cases(N_PROBLEM); i++) {
        const published *p = &problems[i];
        OWN(lw_target) t = { 0 };
        OWN(lw_fit) fit = { 0 };
        lw_error e = { .text = "" };
        read_target(p->name, &t);
        figure wanted = { .wanted = p->reachable };
        lw_fit_options o = options_of(p, &t);
        o.progress = look_at;
        o.context = &wanted;
        o.interrupt = &wanted.reached;
        lw_status st = lw_fit_run(&t, &o, &fit, &e);
        CHECK_INT(st, wanted.reached ? LW_STOPPED : LW_OK);
        CHECK(fit.n > 0);
        if (fit.n > 0 && !(fit.candidate[0].objective <= 1.01*p->reachable))
            fprintf(stderr, "%s: %g\n", p->name, fit.candidate[0].objective);
        CHECK(fit.n > 0 && fit.candidate[0].objective <= 1.01*p->reachable);
        check_list(&t, &o, &fit);
        for (int k = 0; k < fit.n; k++) {
            const lw_candidate *c = &fit.candidate[k];
            check_bounds(p, c);
            for (size_t q = 0; t.angle && q < t.n; q++)  /* the inputs are those prescribed          */
                CHECK_NEAR(remainder(c->input[q] - t.angle[q] - c->input0, 2*LW_PI), 0, 1e-14, 0);
            CHECK(!p->frame || c->input0 == 0);
        }
    }
}

/* ---- repeats ---------------------------------------------------------------------------------------- */

static void same_fit(const lw_fit *a, const lw_fit *b, size_t n)
{
    CHECK_INT(a->n, b->n);
    CHECK(a->evals == b->evals && a->rounds == b->rounds && a->stop == b->stop);
    for (int i = 0; i < a->n && i < b->n; i++) {
        const lw_candidate *p = &a->candidate[i], *q = &b->candidate[i];
        CHECK(p->family == q->family && p->intended.mode[0] == q->intended.mode[0] && p->intended.sense == q->intended.sense);
        CHECK(memcmp(p->dim, q->dim, sizeof *p->dim*(size_t)p->n_dim) == 0);
        CHECK(memcmp(p->input, q->input, sizeof *p->input*n) == 0);
        CHECK(p->objective == q->objective && p->evals == q->evals);
    }
}

TEST(repeat_on_any_number_of_threads)
{
    static const char *const names[] = { "closed18", "line6", "closed18free" };
    for (int i = 0; i < 3; i++) {
        OWN(lw_target) t = { 0 };
        lw_fit fit[3];
        read_target(names[i], &t);
        lw_fit_options o = lw_fit_options_default();
        o.spec.timing = t.angle ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
        o.types = i == 1 ? "all" : "fourbar";
        o.seed = 17;
        o.max_rounds = i == 0 ? 2 : 1;
        o.starts = 100;
        for (int k = 0; k < 3; k++) {
            o.jobs = k + 1;
            lw_status st = lw_fit_run(&t, &o, &fit[k], NULL);
            CHECK(st == LW_OK && fit[k].n > 0);
            CHECK(fit[k].rounds >= 1 && fit[k].rounds <= o.max_rounds);
            CHECK(fit[k].starts % (100*fit[k].rounds) == 0 && fit[k].evals >= fit[k].starts);
            same_fit(&fit[k], &fit[0], t.n);
        }
        for (int k = 0; k < 3; k++)
            lw_fit_free(&fit[k]);
    }
}

/* ---- hard targets ------------------------------------------------------------------------------------- */

enum { MOST = 40 };
typedef struct points { size_t n; double x[MOST], y[MOST]; bool closed; } points;

static lw_status fit_points(const points *p, const char *types, int rounds, long starts, lw_target *t, lw_fit_options *o,
                            lw_fit *fit, lw_error *e)
{
    *e = (lw_error){ .text = "" };
    memset(fit, 0, sizeof *fit);
    CHECK_INT(lw_target_make(p->n, p->x, p->y, NULL, NULL, NULL, p->closed, t, e), LW_OK);
    *o = lw_fit_options_default();
    o->types = types;
    o->max_rounds = rounds;
    o->starts = starts;
    return lw_fit_run(t, o, fit, e);
}

/* Best objective over the square of the size, all claims checked. */
static double best_from(const points *p, int rounds, long starts)
{
    OWN(lw_target) t = { 0 };
    lw_fit_options o;
    OWN(lw_fit) fit = { 0 };
    lw_status st = fit_points(p, "fourbar", rounds, starts, &t, &o, &fit, &check_error);
    CHECK_OK(st);
    double f = fit.n > 0 ? fit.candidate[0].objective/(t.size*t.size) : INFINITY;
    check_list(&t, &o, &fit);
    return f;
}

static double best_of(const points *p, int rounds) { return best_from(p, rounds, 0); }

static points curve(size_t n, void (*at)(double u, double *x, double *y))
{
    points p = { .n = n, .closed = true };
    for (size_t i = 0; i < n; i++)
        at(2*LW_PI*(double)i/(double)n, &p.x[i], &p.y[i]);
    return p;
}

static void eight(double u, double *x, double *y) { *x = 2*sin(u); *y = sin(2*u); }
static void cusp(double u, double *x, double *y) { *x = 2*cos(u) + cos(2*u); *y = 2*sin(u) + sin(2*u); }
static void egg(double u, double *x, double *y) { *x = 3*cos(u); *y = (1 + 0.3*cos(u))*sin(u); }

TEST(few_points_are_met_exactly)
{
    points two = { 2, { 0, 3 }, { 1, -1 }, false }, three = { 3, { 0, 1, 3 }, { 0, 2, 1 }, false };
    points twice = { 6, { 0, 0, 1, 1, 3, 3 }, { 0, 0, 2, 2, 1, 1 }, false };
    points line = { 7, { 0, 1, 2, 3, 4, 5, 6 }, { 0, 1, 2, 3, 4, 5, 6 }, false };
    CHECK(best_from(&two, 1, 100) < 1e-24);
    CHECK(best_from(&three, 1, 100) < 1e-24);
    CHECK(best_from(&twice, 1, 100) < 1e-24);
    CHECK(best_from(&line, 1, 100) < 1e-11);                    /* not to rounding: the valley is flat     */
}

TEST(one_place_is_refused)
{
    points p = { 1, { 4 }, { 2 }, false }, again = { 3, { 4, 4, 4 }, { 2, 2, 2 }, false };
    const points *each[] = { &p, &again };
    for (int i = 0; i < 2; i++) {
        OWN(lw_target) t = { 0 };
        lw_fit_options o;
        OWN(lw_fit) fit = { 0 };
        CHECK_FAILS(fit_points(each[i], "fourbar", 1, 0, &t, &o, &fit, &check_error), LW_E_ARG, "point");
        CHECK_INT(fit.n, 0);
    }
}

TEST_OF_FIGURES(crossings_and_cusps_are_followed)
{
    points p = curve(24, eight);
    CHECK(best_of(&p, 2) < 2e-3);                        /* rms of a hundredth of the size           */
    p = curve(24, cusp);
    CHECK(best_of(&p, 2) < 2e-3);
}

/* How much farther the point is from the target between the first station and the last than twice what it is at a station. */
static double excess(const lw_target *t, const lw_candidate *c)
{
    enum { STEPS = 500 };
    double most = 0, off = 0;
    for (size_t i = 0; i < t->n; i++) {
        lw_vec2 p = coupler_point(c, c->intended.mode[0], c->input[i]);
        off = fmax(off, hypot(p.x - t->x[i], p.y - t->y[i]));
    }
    for (int k = 0; k <= STEPS; k++) {
        double least = INFINITY, input = c->input[0] + (c->input[t->n - 1] - c->input[0])*k/STEPS;
        lw_vec2 p = coupler_point(c, c->intended.mode[0], input);
        for (size_t i = 1; i < t->n; i++)
            least = lw_v2_nearer(p, lw_v2(t->x[i - 1], t->y[i - 1]), lw_v2(t->x[i], t->y[i]), least);
        most = fmax(most, least);
    }
    return most - 2*off;
}

/* Without limits a list begins with linkages that stay near a drawn curve between its stations too, even if others have a
 * smaller error at the stations. */
TEST(a_drawn_curve_is_followed_between_its_stations)
{
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) fit = { 0 };
    lw_error e = { .text = "" };
    lw_fit_options o = lw_fit_options_default();
    o.max_rounds = 5;
    o.seed = 2;                                          /* in so few rounds not every seed finds such linkages */
    o.n_result = 30;                                     /* those that stray are the last ones of the list      */
    read_file("examples/letters/X.csv", &t);
    CHECK_INT(lw_fit_run(&t, &o, &fit, &e), LW_OK);
    double allowed = lw_stray_allowed(&t, t.n)*t.size, least = INFINITY;
    bool strays = false;
    for (int i = 0; i < fit.n; i++) {
        const lw_candidate *c = &fit.candidate[i];
        bool now = !c->mode_of && excess(&t, c) > 1.05*allowed;
        CHECK(c->mode_of || now || !strays || excess(&t, c) > 0.95*allowed);
        strays |= now;
        least = fmin(least, c->objective);
    }
    CHECK(strays && least < fit.candidate[0].objective);
}

/* Order, size and place are not what a path is. */
TEST_OF_FIGURES(the_same_path_gives_the_same_figure)
{
    static const struct { double size, x, y; bool backwards; } as[] = {
        { 1, 0, 0, true }, { 1e9, 0, 0, false }, { 1e-9, 0, 0, false }, { 1, 1e6, -1e6, false },
        { 1e9, 3e9, 5e9, true }, { 1e-9, 2e-9, -7e-9, true }
    };
    points p = curve(12, egg);
    double want = best_of(&p, 2);
    CHECK(want > 1e-12 && want < 1e-3);
    for (size_t k = 0; k < sizeof as/sizeof *as; k++) {
        points q = p;
        for (size_t i = 0; i < p.n; i++) {
            size_t from = as[k].backwards ? p.n - 1 - i : i;
            q.x[i] = as[k].size*p.x[from] + as[k].x;
            q.y[i] = as[k].size*p.y[from] + as[k].y;
        }
        CHECK_NEAR(best_of(&q, 2), want, 0, 1e-3);
    }
}

/* Thirty points without a pattern: nothing comes near, and the figures say so. */
TEST(what_cannot_be_met_is_reported_as_it_is)
{
    points p = { .n = 30, .closed = false };
    uint64_t z = 12345;
    for (size_t i = 0; i < 2*p.n; i++) {
        z = z*6364136223846793005u + 1442695040888963407u;
        (i % 2 ? p.y : p.x)[i/2] = (double)(z >> 11)/9007199254740992.0;
    }
    double f = best_of(&p, 1);
    CHECK(f > 1e-2 && isfinite(f));
}

/* ---- types, limits, faults ------------------------------------------------------------------------------ */

TEST(every_type_of_linkage_is_searched)
{
    points p = curve(10, egg);
    lw_target t;
    lw_fit_options o;
    lw_fit fit;
    CHECK_OK(fit_points(&p, "all", 1, 0, &t, &o, &fit, &check_error));
    CHECK(fit.n > 3);
    bool other_type = false;                             /* the best of each goes on                */
    for (int i = 0; i + 1 < fit.n; i++) {
        CHECK(fit.candidate[i].objective <= fit.candidate[i + 1].objective);
        other_type |= strcmp(fit.candidate[i].family->type, fit.candidate[i + 1].family->type) != 0;
    }
    CHECK(other_type);
    lw_fit_free(&fit);
    lw_target_free(&t);
    static const char *const one[] = { "slidercrank", "RRPR", "PRRP", "slottedcrank,trammel" };
    for (int k = 0; k < 4; k++) {
        CHECK_OK(fit_points(&p, one[k], 1, 0, &t, &o, &fit, &check_error));
        for (int i = 0; i < fit.n; i++) {
            const lw_type *type = lw_type_find(fit.candidate[i].family->type);
            CHECK(strstr(one[k], type->name) || strstr(one[k], type->letters));
        }
        lw_fit_free(&fit);
        lw_target_free(&t);
    }
}

/* A function: the search reaches what was known (tests/data/tasks), and lists no proportions twice. */
TEST(functions_are_generated)
{
    enum { N = 21 };
    double in[N], out[N];
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) fit = { 0 };
    for (int i = 0; i < N; i++) {                        /* log10 of 1 .. 2 over 60 and 90 degrees  */
        in[i] = LW_PI/3*i/(N - 1);
        out[i] = LW_PI/2*log(1 + (double)i/(N - 1))/log(2);
    }
    CHECK_INT(lw_target_make(N, NULL, NULL, out, in, NULL, 0, &t, NULL), LW_OK);
    lw_fit_options o = lw_fit_options_default();
    o.spec.task = LW_TASK_FUNCTION;
    o.types = "all";
    o.max_rounds = 2;
    CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_OK);
    CHECK(fit.n > 1 && fit.candidate[0].objective < 1e-6);
    for (int i = 0; i < fit.n; i++)
        for (int k = 0; k < i; k++) {
            const lw_candidate *a = &fit.candidate[i], *b = &fit.candidate[k];
            double most = strcmp(a->family->type, b->family->type) ? 1 : 0;
            for (int d = 0; d < 4 && a->n_dim == b->n_dim; d++)
                most = fmax(most, fabs(fabs(a->dim[d]) - fabs(b->dim[d])));
            CHECK(most > 1e-4);
        }
}

/* A function whose output falls as the input rises is the same work for a linkage whose input turns the other way. */
TEST(a_function_may_turn_either_way)
{
    enum { N = 15 };
    double in[N], out[N], best[2];
    for (int way = 0; way < 2; way++) {
        OWN(lw_target) t = { 0 };
        OWN(lw_fit) fit = { 0 };
        for (int i = 0; i < N; i++) {
            in[i] = LW_PI/2*i/(N - 1);
            out[i] = (way ? -1 : 1)*LW_PI/2*pow((double)i/(N - 1), 2);
        }
        CHECK_INT(lw_target_make(N, NULL, NULL, out, in, NULL, 0, &t, NULL), LW_OK);
        lw_fit_options o = lw_fit_options_default();
        o.spec.task = LW_TASK_FUNCTION;
        o.max_rounds = 3;
        CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_OK);
        best[way] = fit.candidate[0].objective;
        const lw_candidate *c = &fit.candidate[0];
        for (int i = 1; i < N; i++)
            CHECK_NEAR(c->input[i] - c->input[0], c->intended.sense*in[i], 1e-12, 0);
    }
    CHECK_NEAR(best[0], best[1], 0, 0.02);
}

/* The same motion in another unit of length is the same work. */
TEST(the_unit_of_a_motion_does_not_matter)
{
    enum { N = 6 };
    static const double theta[N] = { 0, 0.2, 0.5, 0.7, 0.8, 1.1 };
    double dim[2][LW_DIM_MAX], worst = 0;
    int n_dim = 0;
    for (int k = 0; k < 2; k++) {
        double size = k ? 1e-3 : 1, x[N], y[N];
        OWN(lw_target) t = { 0 };
        OWN(lw_fit) fit = { 0 };
        for (int i = 0; i < N; i++) {
            x[i] = size*0.4*i;
            y[i] = size*(0.3*i - 0.05*i*i);
        }
        CHECK_INT(lw_target_make(N, x, y, theta, NULL, NULL, 0, &t, NULL), LW_OK);
        lw_fit_options o = lw_fit_options_default();
        o.spec.task = LW_TASK_MOTION;
        lw_fit_spec_weigh_angles(&o.spec, &t, 0);
        CHECK_NEAR(o.spec.angle_length, 0.5*t.extent, 0, 1e-15);
        o.max_rounds = 2;
        CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_OK);
        n_dim = fit.candidate[0].n_dim;
        memcpy(dim[k], fit.candidate[0].dim, sizeof dim[k]);
    }
    for (int d = 0; d + 1 < n_dim; d++)                       /* the last is theta0               */
        worst = fmax(worst, fabs(1e3*dim[1][d] - dim[0][d]));
    CHECK(worst < 1e-4);
}

static volatile int interrupt;
static void stop_after_a_round(void *context, double done, double seconds, double best)
{
    int *rounds = context;
    CHECK(done > 0 && done <= 1 && seconds >= 0 && best >= 0);
    ++*rounds;
    interrupt = 1;
}

TEST(stops_when_told_and_keeps_what_it_has)
{
    points p = curve(20, eight);
    int rounds = 0;
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) fit = { 0 };
    CHECK_INT(lw_target_make(p.n, p.x, p.y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    lw_fit_options o = lw_fit_options_default();
    interrupt = 0;
    o.interrupt = &interrupt;
    o.progress = stop_after_a_round;
    o.context = &rounds;
    o.starts = 400;
    CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_STOPPED);
    CHECK_INT(fit.stop, LW_STOP_USER);
    CHECK_INT(rounds, 1);
    CHECK(fit.n > 0);
    check_list(&t, &o, &fit);
    lw_fit_free(&fit);
    CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_STOPPED);        /* it still stands               */
    CHECK_INT(fit.n, 0);
    lw_fit_free(&fit);
    o.interrupt = NULL;
    o.progress = NULL;
    o.max_seconds = 1e-6;
    CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_STOPPED);
    CHECK_INT(fit.stop, LW_STOP_TIME);
    check_list(&t, &o, &fit);
}

TEST(says_why_nothing_can_be_done)
{
    points p = curve(8, egg);
    OWN(lw_target) t = { 0 };
    lw_fit_options o;
    lw_fit fit;
    lw_error e;
    CHECK_INT(fit_points(&p, "fivebar", 1, 0, &t, &o, &fit, &e), LW_E_ARG);
    CHECK(e.text[0]);
    lw_target_free(&t);
    CHECK_INT(lw_target_make(p.n, p.x, p.y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    o = lw_fit_options_default();
    o.spec.length_lo = 2;
    o.spec.length_hi = 1;
    CHECK_FAILS(lw_fit_run(&t, &o, &fit, &check_error), LW_E_ARG, "bounds");
    o = lw_fit_options_default();
    o.spec.task = LW_TASK_MOTION;
    CHECK_FAILS(lw_fit_run(&t, &o, &fit, &check_error), LW_E_ARG, "theta");
}

/* A crank-rocker with an input longer than every other link: bounds that Grashof's condition contradicts. */
TEST(contradictory_bounds_give_nothing)
{
    points p = curve(8, egg);
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) fit = { 0 };
    CHECK_INT(lw_target_make(p.n, p.x, p.y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    lw_fit_options o = lw_fit_options_default();
    o.spec.crank_only = o.spec.exclude_drag_link = true;
    o.spec.length_lo = 1;
    o.spec.length_hi = 2;
    o.spec.n_bound = 1;
    o.spec.bound[0] = (lw_bound){ "r2", 3, 4 };
    o.max_rounds = 1;
    CHECK_INT(lw_fit_run(&t, &o, &fit, NULL), LW_NOTHING);
    CHECK_INT(fit.n, 0);
}
