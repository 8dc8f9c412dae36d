/* Several points of one mechanism: known linkages found again, derivatives against complex steps and differences,
 * faults. */
#include <complex.h>

#include "optimise/precision/exact.h"
#include "optimise/search/fit.h"
#include "optimise/search/random_linkage.h"
#include "optimise/report/report.h"
#include "optimise/search/start.h"
#include "optimise/problem/tracers.h"
#include "optimise/topology/point_links.h"
#include "tests/fit_problem.h"
#include "tests/six_bar.h"

enum { N = 14, WANTED = 3 };

/* ---- a crank-rocker with two points on its coupler and the angle of its rocker --------------------------- */

static const char *const names[] = { "r1", "r2", "r3", "r4", "cx", "cy", "cx2", "cy2", "x0", "y0", "theta0" };
enum { N_NAME = sizeof names/sizeof *names };

typedef struct machine { lw_plan plan; double dim[LW_DIM_MAX], mode, value[N_NAME]; } machine;
typedef struct rows { double x[N], y[N], x2[N], y2[N], theta3[N], angle[N]; } rows;

static void draw_machine(lw_rng *rng, machine *m)
{
    lw_linkage k;
    lw_error e = { .text = "" };
    lw_target like = { .n = 1, .n_also = 2, .also = { { .x = m->dim }, { .theta = m->dim } } };
    lw_fit_spec s = lw_fit_spec_default();
    double r2 = lw_rng_range(rng, 0.5, 1.2), size[3];
    CHECK_INT(lw_tracers_linkage(family_named("crank-rocker"), &like, &s, &k, &e), LW_OK);
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = lw_tracers_mask(&like), .all_joints = true }, &m->plan, &e), LW_OK);
    do
        for (int i = 0; i < 3; i++)
            size[i] = lw_rng_range(rng, 1.5, 4)*r2;
    while (size[0] > size[1] + size[2] - 1.2*r2 || size[1] > size[0] + size[2] - 1.2*r2 || size[2] > size[0] + size[1] - 1.2*r2);
    const double value[N_NAME] = { size[0], r2, size[1], size[2], lw_rng_range(rng, 0.2, 2),
                                   lw_rng_range(rng, 0.5, 1.5), lw_rng_range(rng, -1.5, 0.5),
                                   lw_rng_range(rng, -2, -0.5), lw_rng_range(rng, -2, 2), lw_rng_range(rng, -2, 2),
                                   lw_rng_range(rng, -3, 3) };
    memcpy(m->value, value, sizeof value);
    memset(m->dim, 0, sizeof m->dim);
    for (int i = 0; i < N_NAME; i++)
        m->dim[lw_plan_dim(&m->plan, names[i])] = value[i];
    m->mode = lw_rng_uniform(rng) < 0.5 ? -1 : 1;
}

/* Stations over a turn, the first at input `first`; the rocker carries a hand turned by 0.7 rad. */
static void trace_machine(const machine *m, double first, rows *r)
{
    for (int i = 0; i < N; i++) {
        lw_posture posture;
        r->angle[i] = 2*LW_PI*i/N;
        CHECK_INT(lw_posture_solve(&m->plan, m->dim, &m->mode, first + r->angle[i], 0, &posture), LW_OK);
        r->x[i] = posture.tracer[0][0].x;
        r->y[i] = posture.tracer[0][0].y;
        r->x2[i] = posture.tracer[1][0].x;
        r->y2[i] = posture.tracer[1][0].y;
        r->theta3[i] = posture.angle[3][0] + 0.7;
    }
}

static lw_target target_rows(rows *r, bool timed)
{
    lw_target t;
    lw_error e = { .text = "" };
    const lw_also also[] = { { .x = r->x2, .y = r->y2 }, { .theta = r->theta3 } };
    CHECK_INT(lw_target_make_all(N, r->x, r->y, NULL, timed ? r->angle : NULL, NULL, also, 2, 1, &t, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    return t;
}

static void check_found(const machine *m, const lw_target *t, const lw_fit_options *o, const lw_fit *fit)
{
    FREED lw_fit_report *r = malloc(sizeof *r);
    const lw_candidate *c = &fit->candidate[0];
    CHECK_OK(lw_fit_report_make(t, &o->spec, c, r, &check_error));
    CHECK(r->verified);
    CHECK_NEAR(c->objective, 0, 1e-22, 0);
    for (int i = 0; i < N_NAME; i++) {
        double off = c->dim[lw_plan_dim(&m->plan, names[i])] - m->value[i];
        CHECK_NEAR(strcmp(names[i], "theta0") == 0 ? remainder(off, 2*LW_PI) : off, 0, 1e-8, 0);
    }
    CHECK_NEAR(remainder(c->tool[1] - 0.7, 2*LW_PI), 0, 1e-8, 0);
    CHECK_INT(r->n_also, 2);
    CHECK(r->also[0].max < 1e-9 && isnan(r->also[0].angle_max));
    CHECK(isnan(r->also[1].max) && r->also[1].angle_max < 1e-9);
    CHECK_INT(r->linkage.n_tracer, WANTED);
    CHECK_INT(r->linkage.tracer[1].link, 2);
    CHECK_INT(r->linkage.tracer[2].link, 3);
    CHECK_NEAR(r->linkage.tracer[1].at.x, t->also[0].x[0], 1e-9, 0);
    CHECK_NEAR(remainder(r->linkage.tracer[2].angle - t->also[1].theta[0], 2*LW_PI), 0, 1e-9, 0);
    CHECK_INT(r->n_cognate, 0);
}

TEST(known_linkages_are_found_again)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 4; trial++) {
        machine m;
        rows r;
        OWN(lw_fit) fit = { 0 };
        lw_error e = { .text = "" };
        lw_fit_options o = lw_fit_options_default();
        draw_machine(&rng, &m);
        trace_machine(&m, lw_rng_range(&rng, -3, 3), &r);
        OWN(lw_target) t = target_rows(&r, trial % 2);
        o.spec.timing = trial % 2 ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
        o.spec.crank_only = o.spec.exclude_drag_link = true;
        CHECK_INT(lw_fit_run(&t, &o, &fit, &e), LW_OK);
        CHECK(fit.n > 0);
        if (fit.n > 0)
            check_found(&m, &t, &o, &fit);
    }
}

/* Place, size and all tracers follow from the shape by linear least squares: with the shape and first input of the
 * linkage that drew the target, the start is that linkage. */
TEST(start_solves_for_every_tracer)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 40; trial++) {
        machine m;
        rows r;
        OWN(lw_problem) p = { 0 };
        lw_error e = { .text = "" };
        double u[LW_START_DRAWS], shape[4], x[LW_VAR_MAX];
        const lw_family *f = family_named("crank-rocker");
        lw_fit_spec s = lw_fit_spec_default();
        draw_machine(&rng, &m);
        for (int i = 0; i < LW_START_DRAWS; i++)
            u[i] = lw_rng_range(&rng, 0.3, 0.7);
        f->draw(u, shape);
        for (int i = 0; i < 4; i++)
            m.dim[lw_plan_dim(&m.plan, names[i])] = 0.8*shape[i];
        trace_machine(&m, 2*LW_PI*u[3] - LW_PI, &r);
        OWN(lw_target) t = target_rows(&r, true);
        s.timing = LW_TIMING_PRESCRIBED;
        s.length_lo = s.position_lo = -(s.length_hi = s.position_hi = 1e6);
        s.length_lo = 0;
        CHECK_INT(lw_problem_make(&t, &s, f, m.mode, 1, &p, &e), LW_OK);
        CHECK_INT(lw_start_draws(&p), 4);
        FREED void *work = new_work(&p);
        CHECK_NEAR(lw_start(&p, u, x, work), 0, 1e-18, 0);
    }
}

/* ---- derivatives ------------------------------------------------------------------------------------------ */

typedef double complex number;             /* a real number with an imaginary step */
typedef struct place { number x, y; } place;

static place turned(place p, place u) { return (place){ p.x*u.x - p.y*u.y, p.x*u.y + p.y*u.x }; }

/* atan2 to first order in the step. */
static number angle_of(place u)
{
    double x = creal(u.x), y = creal(u.y);
    return atan2(y, x) + I*(x*cimag(u.y) - y*cimag(u.x))/(x*x + y*y);
}

static number square_turn(number a)
{
    number d = a - 2*LW_PI*round(creal(a)/(2*LW_PI));
    return d*d;
}

/* f of the four-bar by school geometry, and its terms by hand. */
static number value_by_hand(const lw_problem *p, const number *x, double side)
{
    number f = 0, v[N_NAME];
    for (int i = 0; i < N_NAME; i++)
        v[i] = x[lw_problem_index(p, names[i])];
    place whole = { ccos(v[10]), csin(v[10]) };
    for (size_t k = 0; k < p->n; k++) {
        number input = x[p->i_input0] + p->angle[k] - (p->datum == LW_DATUM_PLANE ? v[10] : 0);
        place a = { v[1]*ccos(input), v[1]*csin(input) }, d = { v[0] - a.x, -a.y };
        number r2 = d.x*d.x + d.y*d.y, along = (r2 + v[2]*v[2] - v[3]*v[3])/(2*r2);
        number across = side*csqrt(v[2]*v[2]/r2 - along*along);
        place ab = { d.x*along - d.y*across, d.y*along + d.x*across };
        place u = { ab.x/v[2], ab.y/v[2] }, w = { (a.x + ab.x - v[0])/v[3], (a.y + ab.y)/v[3] };
        for (int i = 0; i < 2; i++) {
            lw_aim aim = lw_problem_aim(p, i);
            place c = turned((place){ v[4 + 2*i], v[5 + 2*i] }, u);
            place q = turned((place){ a.x + c.x, a.y + c.y }, whole);
            number ex = q.x + v[8] - aim.x[k], ey = q.y + v[9] - aim.y[k];
            f += aim.wa[k]*aim.wa[k]*(ex*ex + ey*ey);
        }
        lw_aim aim = lw_problem_aim(p, 2);
        f += aim.wb[k]*aim.wb[k]*square_turn(angle_of(turned(w, whole)) + x[aim.i_tool] - aim.theta[k]);
    }
    return f;
}

TEST(gradient_is_that_of_complex_steps)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 60; trial++) {
        machine m;
        rows r;
        OWN(lw_problem) p = { 0 };
        lw_fit_spec s = lw_fit_spec_default();
        number at[LW_VAR_MAX] = { 0 };
        double x[LW_VAR_MAX] = { 0 }, grad[LW_VAR_MAX];
        draw_machine(&rng, &m);
        trace_machine(&m, 0, &r);
        for (int i = 0; i < N; i++) {
            r.x2[i] += 0.1*lw_rng_normal(&rng);
            r.y[i] += 0.1*lw_rng_normal(&rng);
            r.theta3[i] += 0.1*lw_rng_normal(&rng);
        }
        OWN(lw_target) t = target_rows(&r, true);
        for (int i = 0; i < N; i++)
            t.weight[i] = t.also[0].weight[i] = lw_rng_uniform(&rng);
        s.timing = LW_TIMING_PRESCRIBED;
        s.datum = (lw_datum[]){ LW_DATUM_FREE, LW_DATUM_FRAME, LW_DATUM_PLANE }[trial % 3];
        s.b = 2.5;
        CHECK_INT(lw_problem_make(&t, &s, family_named("crank-rocker"), m.mode, 1, &p, NULL), LW_OK);
        lw_problem_from_dims(&p, m.dim, x);
        for (int i = 0; i < p.n_var; i++)
            at[i] = x[i] += 0.01*lw_rng_normal(&rng);
        FREED void *work = new_work(&p);
        double f = lw_problem_value(&p, x, grad, work);
        double side = fabs(creal(value_by_hand(&p, at, 1)) - f) < fabs(creal(value_by_hand(&p, at, -1)) - f) ? 1 : -1;
        CHECK_NEAR(creal(value_by_hand(&p, at, side)), f, 0, 1e-11);
        for (int i = 0; i < p.n_var; i++) {
            at[i] += 1e-30*I;
            double want = cimag(value_by_hand(&p, at, side))/1e-30;
            at[i] = x[i];
            bool idle = i == lw_problem_index(&p, "cx3") || i == lw_problem_index(&p, "cy3");
            CHECK_NEAR(grad[i], idle ? 0 : want, 1e-11*(1 + f), 1e-10);
        }
    }
}

/* A six-bar whose second point lies on the coupler and whose stay turns a hand; the target is its own, shaken. */
static void shaken_six_bar(lw_linkage *k, bool timed, lw_rng *rng, lw_target *t)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    rows r;
    *k = six_bar();
    k->n_tracer = 3;
    k->tracer[1] = (lw_tracer){ .name = "Q", .link = 2, .at = { 1.5, 2.6 } };
    k->tracer[2] = (lw_tracer){ .name = "H", .link = 5, .at = { -3, 2.5 } };
    CHECK_INT(lw_plan_make(k, (lw_plan_options){ .tracers = 7, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, k, dim, mode, &input, NULL), LW_OK);
    for (int i = 0; i < N; i++) {
        lw_posture posture;
        r.angle[i] = 2*LW_PI*i/N;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + r.angle[i], 0, &posture), LW_OK);
        r.x[i] = posture.tracer[0][0].x + 0.03*lw_rng_normal(rng);
        r.y[i] = posture.tracer[0][0].y;
        r.x2[i] = posture.tracer[1][0].x;
        r.y2[i] = posture.tracer[1][0].y + 0.03*lw_rng_normal(rng);
        r.theta3[i] = posture.angle[5][0] + 0.03*lw_rng_normal(rng);
    }
    *t = target_rows(&r, timed);
}

/* Inputs of free stations are eliminated from the derivatives of all points together. */
TEST(gradient_of_a_six_bar_is_that_of_differences)
{
    int smooth = 0, all = 0;
    lw_rng rng = check_rng(4);
    for (int trial = 0; trial < 24; trial++) {
        lw_linkage k;
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        lw_error e = { .text = "" };
        double x[LW_VAR_MAX], grad[LW_VAR_MAX];
        lw_fit_spec s = lw_fit_spec_default();
        shaken_six_bar(&k, trial % 2, &rng, &t);
        lw_family f = { .name = "six-bar", .linkage = &k, .posture = true, .links = 6 };
        s.timing = trial % 2 ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
        CHECK_INT(lw_problem_make(&t, &s, &f, 1, 1, &p, &e), LW_OK);
        FREED void *work = new_work(&p);
        CHECK(lw_random_linkage_posture(&p, x, work));
        for (int i = 0; i < p.n_var; i++)
            if (p.lo[i] < p.hi[i])
                x[i] += 0.003*lw_rng_normal(&rng);
        double value = lw_problem_value(&p, x, grad, work);
        for (int i = 0; isfinite(value) && i < p.n_var; i++, all++) {
            double a = central_difference(&p, x, i, 1e-5, work), b = central_difference(&p, x, i, 4e-6, work), scale = 1 + value + fabs(grad[i]);
            if (!(fabs(a - b) <= 1e-7*scale))
                continue;
            CHECK_NEAR(grad[i], b, 1e-6*scale, 0);
            smooth++;
        }
    }
    CHECK(all > 300 && smooth > 0.8*all);
}

/* ---- links -------------------------------------------------------------------------------------------------- */

TEST(links_are_those_asked_for)
{
    double one[2] = { 0, 1 };
    static const struct { const char *family; lw_task task; bool place; lw_carrier carrier; lw_status status; int link; }
    row[] = {
        { "crank-rocker", LW_TASK_PATH, true, LW_CARRIER_ANY, LW_OK, 2 },
        { "crank-rocker", LW_TASK_PATH, false, LW_CARRIER_ANY, LW_OK, 3 },
        { "crank-rocker", LW_TASK_PATH, true, LW_CARRIER_INPUT, LW_OK, 1 },
        { "crank-rocker", LW_TASK_PATH, true, LW_CARRIER_OUTPUT, LW_OK, 3 },
        { "crank-rocker", LW_TASK_FUNCTION, false, LW_CARRIER_ANY, LW_OK, 2 },
        { "slider-crank", LW_TASK_PATH, false, LW_CARRIER_COUPLER, LW_OK, 2 },
        { "slider-crank", LW_TASK_PATH, true, LW_CARRIER_OUTPUT, LW_OK, 3 },
        { "slider-crank", LW_TASK_PATH, false, LW_CARRIER_ANY, LW_E_KIND, 0 },      /* a slide has no angle */
        { "slider-driven", LW_TASK_PATH, false, LW_CARRIER_INPUT, LW_E_KIND, 0 },
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        lw_linkage k;
        lw_fit_spec s = lw_fit_spec_default();
        lw_target t = { .n = 2, .n_also = 1, .also = { { .x = row[i].place ? one : NULL, .theta = row[i].place ? NULL : one } } };
        s.task = row[i].task;
        s.carrier[0] = row[i].carrier;
        CHECK_INT(lw_tracers_linkage(family_named(row[i].family), &t, &s, &k, NULL), row[i].status);
        if (row[i].status == LW_OK)
            CHECK_INT(k.tracer[1].link, row[i].link);
    }
}

/* A six-bar whose first point on the arm feels all links; on the coupler it would feel four. */
TEST(choices_of_links_are_counted_by_hand)
{
    double one[2] = { 0, 1 };
    static const struct { bool place; lw_carrier carrier; int n, link[5][2]; } row[] = {
        { true, LW_CARRIER_ANY, 3, { { 2, 4 }, { 4, 2 }, { 4, 4 } } },
        { false, LW_CARRIER_ANY, 5, { { 2, 4 }, { 4, 2 }, { 4, 3 }, { 4, 4 }, { 4, 5 } } },
        { false, LW_CARRIER_OUTPUT, 2, { { 4, 3 }, { 4, 5 } } },
        { true, LW_CARRIER_INPUT, 1, { { 4, 1 } } },
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        lw_linkage k = six_bar();
        lw_family f = { .name = "Stephenson III, point on link 5", .linkage = &k, .links = 6 };
        lw_fit_spec s = lw_fit_spec_default();
        lw_target t = { .n = 2, .n_also = 1, .also = { { .x = row[i].place ? one : NULL, .theta = row[i].place ? NULL : one } } };
        OWN(lw_point_links) spread = { 0 };
        s.carrier[0] = row[i].carrier;
        lw_families only = lw_families_of(&f, 1), all;
        FREED lw_family_made *made = malloc(sizeof *made);
        CHECK_INT(lw_point_links_make(&only, &t, &s, &spread, NULL), LW_OK);
        CHECK_INT(spread.n, row[i].n);
        all = lw_point_links_families(&spread);
        for (int c = 0; c < spread.n && c < row[i].n; c++) {
            CHECK_INT(all.make(all.of, c, made), LW_OK);
            CHECK_INT(made->linkage.n_tracer, 2);
            CHECK_INT(made->linkage.tracer[0].link, row[i].link[c][0]);
            CHECK_INT(made->linkage.tracer[1].link, row[i].link[c][1]);
            CHECK(made->family.linkage == &made->linkage && made->family.links == 6);
            CHECK_HAS(made->family.name, "Stephenson III, points on links ");
        }
        lw_point_links_free(&spread);
        k.n_tracer = 2;                                  /* one that brings its tracers stays as it is */
        k.tracer[1] = (lw_tracer){ .name = "Q", .link = 3, .at = { 7, 8 } };
        CHECK_INT(lw_point_links_make(&only, &t, &s, &spread, NULL), LW_OK);
        CHECK_INT(spread.n, 1);
        all = lw_point_links_families(&spread);
        CHECK_INT(all.make(all.of, 0, made), LW_OK);
        CHECK(made->linkage.tracer[1].link == 3 && made->linkage.tracer[1].at.x == 7);
    }
}

/* Two points on two links of a six-bar: found again by looking through the links that they may lie on. */
TEST(points_on_two_links_are_found_again)
{
    lw_linkage k = six_bar(), start;
    lw_plan plan;
    OWN(lw_target) t = { 0 };
    OWN(lw_point_links) spread = { 0 };
    OWN(lw_fit) fit = { 0 };
    lw_error e = { .text = "" };
    rows r;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    lw_fit_options o = lw_fit_options_default();
    k.n_tracer = 2;
    k.tracer[1] = (lw_tracer){ .name = "Q", .link = 2, .at = { 1.5, 2.6 } };
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 3, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
    for (int i = 0; i < N; i++) {
        lw_posture posture;
        r.angle[i] = 2*LW_PI*i/N;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + r.angle[i], 0, &posture), LW_OK);
        r.x[i] = posture.tracer[0][0].x;
        r.y[i] = posture.tracer[0][0].y;
        r.x2[i] = posture.tracer[1][0].x;
        r.y2[i] = posture.tracer[1][0].y;
    }
    const lw_also also = { .x = r.x2, .y = r.y2 };
    CHECK_INT(lw_target_make_all(N, r.x, r.y, NULL, r.angle, NULL, &also, 1, 1, &t, &e), LW_OK);
    start = six_bar();
    start.joint[4].at.x += 0.15;                         /* a neighbour, with one point               */
    start.joint[6].at.y -= 0.2;
    lw_family f = { .name = "six-bar, point on link 5", .linkage = &start, .posture = true, .links = 6 };
    o.spec.timing = LW_TIMING_PRESCRIBED;
    lw_families one = lw_families_of(&f, 1), all;
    CHECK_INT(lw_point_links_make(&one, &t, &o.spec, &spread, &e), LW_OK);
    all = lw_point_links_families(&spread);
    o.families = &all;
    o.budget = 30000;
    CHECK(lw_fit_run(&t, &o, &fit, &e) >= 0);
    CHECK(fit.n > 0);
    if (fit.n > 0) {
        FREED lw_fit_report *report = malloc(sizeof *report);
        CHECK_NEAR(fit.candidate[0].objective, 0, 1e-18, 0);
        CHECK_INT(fit.candidate[0].family->linkage->tracer[0].link, 4);
        CHECK_INT(fit.candidate[0].family->linkage->tracer[1].link, 2);
        CHECK_INT(lw_fit_report_make(&t, &o.spec, &fit.candidate[0], report, &e), LW_OK);
        CHECK(report->verified && report->also[0].max < 1e-8 && report->error_max < 1e-8);
    }
}

/* ---- faults --------------------------------------------------------------------------------------------------- */

TEST(contradictions_are_errors)
{
    double x[4] = { 0, 1, 1, 0 }, y[4] = { 0, 0, 1, 1 }, a[4] = { 0, 1, 2, 3 }, none[4] = { 0 };
    const lw_also whole = { .x = x, .y = y }, half = { .x = x }, nothing = { .weight = a }, idle = { .theta = a, .weight = none };
    OWN(lw_target) t = { 0 };
    lw_problem p;
    lw_error e = { .text = "" };
    lw_fit_spec s = lw_fit_spec_default();
    const lw_family *f = family_named("crank-rocker");
    CHECK_INT(lw_target_make_all(4, x, y, NULL, NULL, NULL, &half, 1, 1, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "point 2 needs x and y");
    CHECK_INT(lw_target_make_all(4, x, y, NULL, NULL, NULL, &nothing, 1, 1, &t, &e), LW_E_ARG);
    CHECK_INT(lw_target_make_all(4, x, y, NULL, NULL, NULL, &idle, 1, 1, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "all weights are 0");
    CHECK_INT(lw_target_make_all(4, NULL, NULL, a, a, NULL, &whole, 1, 0, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "number points with a path first");
    CHECK_INT(lw_target_make_all(4, x, y, NULL, NULL, NULL, &whole, LW_ALSO_MAX + 1, 0, &t, &e), LW_E_ARG);
    CHECK_INT(lw_target_make_all(4, x, y, a, a, NULL, &whole, 1, 1, &t, &e), LW_OK);
    s.timing = LW_TIMING_NONE;
    CHECK_INT(lw_problem_make(&t, &s, f, 1, 1, &p, &e), LW_E_ARG);
    CHECK_HAS(e.text, "timing none");
    s.timing = LW_TIMING_PRESCRIBED;
    s.task = LW_TASK_FUNCTION;
    CHECK_INT(lw_problem_make(&t, &s, f, 1, 1, &p, &e), LW_E_ARG);
    CHECK_HAS(e.text, "a function has no place");
    lw_fit_options o = lw_fit_options_default();
    lw_exact exact;
    o.types = "fourbar";
    CHECK_INT(lw_exact_run(&t, &o, &exact, &e), LW_E_ARG);
    CHECK_HAS(e.text, "precision points have one point");
}
