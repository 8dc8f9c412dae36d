/* Which input belongs to which station: the dynamic programme against all rising sequences, foot points
 * against a dense look at the curve, order by the min-max formula of isotonic regression. */
#include "tests/fit_problem.h"
#include "tests/mbs_linkage.h"

enum { M = LW_CURVE_SAMPLES };

/* A four-bar, and stations scattered about its curve. */
static void scatter(size_t n, lw_timing timing, double shake, int sense, lw_rng *rng, lw_problem *p, double *x)
{
    member m;
    stations st;
    OWN(lw_target) t = { 0 };
    lw_fit_spec spec = lw_fit_spec_default();
    spec.timing = timing;
    draw_member("crank-rocker", 1, false, rng, &m);
    trace_member(&m, n, &st);
    shake_stations(&st, shake, rng);
    target_of(&st, &spec, &t);
    CHECK_OK(lw_problem_make(&t, &spec, m.family, 1, sense, p, &check_error));
    variables_of(p, &m, x);
}

/* ---- order -------------------------------------------------------------------------------------- */

/* The nearest rising sequence at place i:  max over a <= i of min over b >= i of the mean of a .. b. */
static double isotonic(size_t n, const double *v, const double *w, size_t i)
{
    double most = -INFINITY;
    for (size_t a = 0; a <= i; a++) {
        double sum = 0, mass = 0, least = INFINITY;
        for (size_t b = a; b < n; b++) {
            sum += w[b]*v[b];
            mass += w[b];
            if (b >= i)
                least = fmin(least, sum/mass);
        }
        most = fmax(most, least);
    }
    return most;
}

TEST(order_is_isotonic_regression)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 400; trial++) {
        enum { MOST = 9 };
        double v[MOST], w[MOST], got[MOST], scratch[3*MOST];
        lw_problem p = { .n = 1 + (size_t)trial % MOST, .intended.sense = trial % 2 ? 1 : -1 };
        for (size_t i = 0; i < p.n; i++) {
            v[i] = trial % 3 ? lw_rng_range(&rng, -3, 3) : (int)lw_rng_range(&rng, -2, 3);
            w[i] = trial % 5 ? lw_rng_range(&rng, 0.1, 3) : 1;
            got[i] = p.intended.sense*v[i];
        }
        lw_timing_order(&p, got, w, scratch);
        for (size_t i = 0; i < p.n; i++) {
            CHECK_NEAR(p.intended.sense*got[i], isotonic(p.n, v, w, i), 1e-13, 1e-13);
            CHECK(i == 0 || p.intended.sense*got[i] >= p.intended.sense*got[i - 1]);
        }
    }
}

/* With the last at most a turn after the first: no point near by that keeps the order is nearer, and none
 * of many further ones (the problem is convex). */
TEST(order_goes_round_at_most_once)
{
    lw_rng rng = check_rng(8);
    int over = 0;
    for (int trial = 0; trial < 300; trial++) {
        enum { MOST = 6 };
        double v[MOST], w[MOST], got[MOST], scratch[3*MOST], f = 0;
        lw_problem p = { .n = 2 + (size_t)trial % (MOST - 1), .intended.sense = trial % 2 ? 1 : -1 };
        for (size_t i = 0; i < p.n; i++) {
            v[i] = 1.5*(double)i + 3*lw_rng_normal(&rng);
            w[i] = lw_rng_range(&rng, 0.1, 3);
            got[i] = p.intended.sense*v[i];
        }
        lw_timing_order(&p, got, w, scratch);
        for (size_t i = 0; i < p.n; i++) {
            got[i] *= p.intended.sense;
            CHECK(i == 0 || got[i] >= got[i - 1]);
            f += w[i]*pow(got[i] - v[i], 2);
        }
        CHECK(got[p.n - 1] - got[0] <= 2*LW_PI + 1e-14);
        over += got[p.n - 1] - got[0] >= 2*LW_PI;
        for (int other = 0; other < 2000; other++) {
            double step = pow(10, lw_rng_range(&rng, -4, 0.5)), g = 0, at = -INFINITY, first = 0;
            bool one_turn = true;
            for (size_t i = 0; i < p.n; i++) {
                double to = fmax(at, got[i] + (lw_rng_uniform(&rng) < 0.5 ? 0 : step*lw_rng_normal(&rng)));
                first = i ? first : to;
                at = to;
                one_turn &= at <= first + 2*LW_PI;
                g += w[i]*pow(at - v[i], 2);
            }
            CHECK(!one_turn || g >= f - 1e-12*f);
        }
    }
    CHECK(over > 50);
}

TEST(order_leaves_what_is_in_order)
{
    double v[5] = { -3, -1, -1, 0.5, 3 }, w[5] = { 1, 2, 3, 4, 5 }, got[5], scratch[15];
    lw_problem p = { .n = 5, .intended.sense = 1 };
    memcpy(got, v, sizeof v);
    lw_timing_order(&p, got, w, scratch);
    CHECK(memcmp(got, v, sizeof v) == 0);
}

/* ---- the dynamic programme ------------------------------------------------------------------------- */

/* Cheapest rising sequence of at most a turn from sample `first`, by trying all. */
static double all_sequences(const lw_problem *p, const lw_work *w, int first, size_t i, int from)
{
    double least = INFINITY;
    for (int k = from; k <= (i ? M : 0); k++) {
        int j = (first + (p->intended.sense > 0 ? k : M*M - k)) % M;
        double rest = i + 1 < p->n ? all_sequences(p, w, first, i + 1, k) : 0;
        least = fmin(least, w->cost[i*LW_COST_ROW + (size_t)j] + rest);
    }
    return least;
}

/* Costs from scratch: squared distances to pieces of the tangents at the samples, half a step to both sides. */
static void check_costs(const lw_problem *p, const lw_work *w)
{
    for (size_t i = 0; i < p->n; i++)
        for (int j = 0; j < M; j++) {
            int a = (j + M - 1)%M, b = (j + 1)%M;
            double part = w->curve_m[a] >= 0 && w->curve_m[b] >= 0 ? 0.25 : 0;
            lw_vec2 at = lw_v2(w->curve_x[j], w->curve_y[j]);
            lw_vec2 half = lw_v2_scale(lw_v2(w->curve_x[b] - w->curve_x[a], w->curve_y[b] - w->curve_y[a]), part);
            double d = lw_v2_nearer(lw_v2(p->x[i], p->y[i]), lw_v2_sub(at, half), lw_v2_add(at, half), INFINITY);
            CHECK_NEAR(w->cost[i*LW_COST_ROW + (size_t)j], p->w[i]*d*d, 1e-15, 1e-12);
        }
}

TEST(programme_finds_the_cheapest_sequence)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 60; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX], cheapest = INFINITY, over_all = INFINITY, got = INFINITY;
        scatter(3, LW_TIMING_FREE, 0.6, trial % 2 ? 1 : -1, &rng, &p, x);
        FREED lw_work *w = new_work(&p);
        CHECK(lw_timing_assign(&p, x, w));
        check_costs(&p, w);
        const short *steps = w->order + p.n;
        for (int first = 0; first < M; first++) {
            const double *c = w->cost;
            double all = all_sequences(&p, w, first, 0, 0), mine = 0;
            over_all = fmin(over_all, all);
            if (c[first] > c[(first + 1) % M] || c[first] > c[(first + M - 1) % M])
                continue;                                /* it starts where station 0 is nearest    */
            for (size_t i = 0; i < p.n; i++)
                mine += w->cost[i*LW_COST_ROW + (size_t)((first + p.intended.sense*steps[i] + M) % M)];
            cheapest = fmin(cheapest, all);
            got = fmin(got, mine);
        }
        CHECK_NEAR(got, cheapest, 0, 1e-13);
        CHECK(over_all <= got*(1 + 1e-13));
    }
}

/* ---- foot points ------------------------------------------------------------------------------------ */

/* Squared distance of station i to the curve at a phase, by a single posture. */
static double distance2(const lw_problem *p, const double *x, size_t i, double phase)
{
    lw_posture posture;
    lw_posture_solve(&p->plan, x, p->intended.mode, phase, 0, &posture);
    return p->w[i]*(pow(posture.tracer[0][0].x - p->x[i], 2) + pow(posture.tracer[0][0].y - p->y[i], 2));
}

/* Of each block of stations with one phase (round the turn, too) the sum is least there, among near ones. */
static void check_blocks(const lw_problem *p, const double *x, const lw_work *w)
{
    for (size_t a = 0, count; a < p->n; a += count) {
        count = 1;
        while (a + count < p->n && lw_timing_joined(p, w, a + count - 1))
            count++;
        size_t before = 0;                               /* stations behind the turn               */
        while (a == 0 && before < p->n && lw_timing_joined(p, w, p->n - 1 - before))
            before++;
        if (a > 0 && a + count == p->n && lw_timing_joined(p, w, p->n - 1))
            return;                                      /* seen with station 0                    */
        double here = 0, least = INFINITY;
        for (int k = 0; k <= 40; k++) {
            double sum = 0, by = k == 0 ? 0 : 1e-4*(k - 20);
            for (size_t i = 0; i < count + before; i++)
                sum += distance2(p, x, (a + i + p->n - before) % p->n, w->phase[a] + by);
            here = k == 0 ? sum : here;
            least = fmin(least, sum);
        }
        CHECK(here <= least + 1e-13);
    }
}

TEST(refined_stations_stand_at_their_feet)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 120; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        lw_timing timing = trial % 2 ? LW_TIMING_FREE : LW_TIMING_NONE;
        scatter(10, timing, trial % 3 ? 0.05 : 0.3, trial % 4 < 2 ? 1 : -1, &rng, &p, x);
        FREED lw_work *w = new_work(&p);
        CHECK(lw_timing_assign(&p, x, w) && lw_timing_refine(&p, x, w, 1000));      /* in a fit 60 steps are enough */
        check_blocks(&p, x, w);
        for (size_t i = 0; timing == LW_TIMING_FREE && i + 1 < p.n; i++)
            CHECK(p.intended.sense*(w->phase[i + 1] - w->phase[i]) >= 0);
        CHECK(timing == LW_TIMING_NONE || p.intended.sense*(w->phase[p.n - 1] - w->phase[0]) <= 2*LW_PI + 1e-9);
    }
}

/* Row i of the derivatives by variable d, at station k. */
static double row_at(const lw_problem *p, const lw_work *w, int i, int d, size_t k)
{
    return w->row[((size_t)i*(size_t)p->n_var + (size_t)d)*w->ld + k];
}

/* The derivatives by the variables are those along which the inputs follow: no change of the input of a station, or of the common input
 * of a block, makes them less, and they are the differences of the residuals with the inputs moved by `slide`.  Beside a cusp the inputs
 * slide hundreds of times as far as the variable moves, and the error of a difference grows with the third power of that: the step is
 * such that no input moves by more than 1e-5. */
static void check_elimination(const lw_problem *p, const double *x, lw_work *w, int d)
{
    double h = 1e-6, sum[STATION_MAX], by[2][2][STATION_MAX], phase[STATION_MAX], trial[LW_VAR_MAX];
    for (size_t k = 0; k < p->n; k++) {
        sum[k] = w->tangent[k]*row_at(p, w, 0, d, k) + w->tangent[w->ld + k]*row_at(p, w, 1, d, k);
        phase[k] = w->phase[k];
        h = fmin(h, 1e-5/fabs(w->slide[(size_t)d*w->ld + k]));
    }
    for (size_t b = 0; b < w->n_block; b++)
        for (size_t q = 1; q < w->block[b].count; q++) {
            size_t first = w->block[b].first, k = (first + q) % p->n;
            sum[first] += sum[k];
            sum[k] = 0;
            CHECK(w->slide[(size_t)d*w->ld + k] == w->slide[(size_t)d*w->ld + first]);
        }
    for (size_t k = 0; k < p->n; k++)
        CHECK_NEAR(sum[k], 0, 1e-10, 0);
    memcpy(trial, x, sizeof *trial*(size_t)p->n_var);
    for (int end = 0; end < 2; end++) {
        double to = end ? h : -h;
        trial[d] = x[d] + to;
        for (size_t k = 0; k < p->n; k++)
            w->phase[k] = phase[k] - to*w->slide[(size_t)d*w->ld + k];
        CHECK(lw_problem_turn_stations(p, trial, w) && lw_problem_lanes(p, trial, w));
        lw_problem_rows(p, trial, w, false);
        for (int i = 0; i < 2; i++)
            memcpy(by[end][i], w->res + (size_t)i*w->ld, sizeof *w->res*p->n);
    }
    for (int i = 0; i < 2; i++)
        for (size_t k = 0; k < p->n; k++)
            CHECK_NEAR((by[1][i][k] - by[0][i][k])/(2*h), row_at(p, w, i, d, k), 1e-6, 1e-6);
    memcpy(w->phase, phase, sizeof *phase*p->n);
}

TEST(inputs_are_eliminated_alone_and_in_blocks)
{
    lw_rng rng = check_rng(8);
    size_t blocks = 0;
    for (int trial = 0; trial < 20; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        scatter(10, LW_TIMING_FREE, 0.3, trial % 2 ? 1 : -1, &rng, &p, x);
        FREED lw_work *w = new_work(&p);
        CHECK(lw_timing_assign(&p, x, w) && lw_timing_refine(&p, x, w, 1000));
        CHECK(lw_problem_turn_stations(&p, x, w) && lw_problem_lanes(&p, x, w));
        lw_problem_rows(&p, x, w, true);
        blocks += w->n_block;
        for (int d = 0; d < p.n_var; d++)
            check_elimination(&p, x, w, d);
    }
    CHECK(blocks > 10);
}

/* How far the curve leaves its tangent at the sample of least cost for station i within half a step, where that tangent stands for it. */
static double sagitta(const lw_problem *p, const double *x, const lw_work *w, size_t i)
{
    const double *c = w->cost + i*LW_COST_ROW;
    double most = 0;
    int j = 0;
    for (int k = 1; k < M; k++)
        j = c[k] < c[j] ? k : j;
    int a = (j + M - 1)%M, b = (j + 1)%M;
    for (int side = -1; side <= 1; side += 2) {
        lw_posture z;
        lw_posture_solve(&p->plan, x, p->intended.mode, w->turn[j] + side*LW_PI/M, 0, &z);
        most = fmax(most, hypot(z.tracer[0][0].x - w->curve_x[j] - 0.25*side*(w->curve_x[b] - w->curve_x[a]),
                                z.tracer[0][0].y - w->curve_y[j] - 0.25*side*(w->curve_y[b] - w->curve_y[a])));
    }
    return sqrt(p->w[i])*most;
}

/* Where the order does not matter a station is as near as at any sample, but for the difference between the curve and its tangents,
 * which choose the branch; and but for stations between two far branches as near as anywhere. */
TEST(nearest_points_are_the_nearest)
{
    lw_rng rng = check_rng(4);
    int elsewhere = 0;
    for (int trial = 0; trial < 30; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        scatter(10, LW_TIMING_NONE, 0.05, 1, &rng, &p, x);
        FREED lw_work *w = new_work(&p);
        CHECK(lw_problem_settle(&p, x, w));
        for (size_t i = 0; i < p.n; i++) {
            double least = INFINITY;
            for (int k = 0; k < 4000; k++)
                least = fmin(least, distance2(&p, x, i, 2*LW_PI*k/4000));
            elsewhere += distance2(&p, x, i, w->phase[i]) > least + 1e-12;
            for (int j = 0; j < M; j++)
                CHECK(sqrt(distance2(&p, x, i, w->phase[i])) <= sqrt(distance2(&p, x, i, w->turn[j])) + sagitta(&p, x, w, i) + 1e-6);
        }
    }
    CHECK(elsewhere <= 6);                               /* of 300 */
}

/* Stations of the linkage itself go home, in either sense; those given twice share their input. */
TEST(own_stations_go_home)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 60; trial++) {
        member m;
        stations st, twice;
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        lw_fit_spec spec = lw_fit_spec_default();
        int sense = trial % 2 ? 1 : -1;
        draw_member(trial % 3 ? "crank-rocker" : "slider-crank", 1, false, &rng, &m);
        trace_member(&m, 8, &st);
        twice.n = 16;
        twice.closed = true;
        for (size_t i = 0; i < 16; i++) {
            size_t from = sense > 0 ? i/2 : 7 - i/2;
            twice.x[i] = st.x[from];
            twice.y[i] = st.y[from];
        }
        target_of(&twice, &spec, &t);
        CHECK_OK(lw_problem_make(&t, &spec, m.family, 1, sense, &p, &check_error));
        variables_of(&p, &m, x);
        FREED lw_work *w = new_work(&p);
        CHECK(lw_problem_value(&p, x, NULL, w) < 1e-24);
        for (size_t i = 0; i < 16; i++) {
            double home = st.input[sense > 0 ? i/2 : 7 - i/2];
            CHECK_NEAR(remainder(w->phase[i] - home, 2*LW_PI), 0, 1e-9, 0);
        }
    }
}

/* With as many stations as samples, too, where the curve has a narrow turn: the point lies beside the pole of the coupler in one posture,
 * in which it would have a cusp there. */
TEST(stations_beside_a_cusp_go_home)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 6);
    int lost = 0, tried = 0;
    for (int trial = 0; trial < 200; trial++) {
        member m;
        stations st;
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        const lw_fit_spec spec = lw_fit_spec_default();
        draw_member("crank-rocker", 1, false, &rng, &m);
        fourbar_joints q = fourbar_at(m.dim, m.mode, lw_rng_range(&rng, 0, 2*LW_PI));
        lw_vec2 crank = lw_v2_sub(q.a, q.a0), rocker = lw_v2_sub(q.b, q.b0), along = lw_v2_scale(lw_v2_sub(q.b, q.a), 1/m.dim[2]);
        double far = lw_v2_cross(lw_v2_sub(q.b0, q.a0), rocker)/lw_v2_cross(crank, rocker) - 1;      /* of the pole beyond the crank's pin */
        lw_vec2 pole = lw_v2_unturn(lw_v2_scale(crank, far), along);
        if (!(lw_v2_norm(pole) < 3*m.dim[0]))
            continue;
        *dim_named(&m, "cx") = pole.x + 0.02*m.dim[0]*lw_rng_normal(&rng);
        *dim_named(&m, "cy") = pole.y + 0.02*m.dim[0]*lw_rng_normal(&rng);
        trace_member(&m, 60, &st);
        target_of(&st, &spec, &t);
        CHECK_INT(lw_problem_make(&t, &spec, m.family, 1, 1, &p, NULL), LW_OK);
        variables_of(&p, &m, x);
        lw_work *w = new_work(&p);
        lost += !(lw_problem_value(&p, x, NULL, w) < 1e-20);
        tried++;
        free(w);
    }
    CHECK(tried > 100 && lost <= 0.16*tried);             /* 6 to 11 %; by distances to the samples alone 24 to 33 % */
}

/* ---- curve to target ----------------------------------------------------------------------------------- */

TEST(feet_on_the_polygon_are_the_nearest)
{
    lw_rng rng = check_rng(6);
    for (int trial = 0; trial < 20; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        scatter(7, LW_TIMING_NONE, 0.1, 1, &rng, &p, x);
        FREED lw_work *w = new_work(&p);
        CHECK(lw_problem_settle(&p, x, w));
        for (int j = 0; j < M; j++) {
            double sx = w->jac.x[p.n + (size_t)j], sy = w->jac.y[p.n + (size_t)j], least = INFINITY;
            lw_timing_samples(&p, w, w->jac.x + p.n, w->jac.y + p.n);
            for (size_t i = 0; i < p.n; i++)
                for (int q = 0; q <= 400; q++) {
                    size_t k = (i + 1) % p.n;
                    double u = q/400.0;
                    least = fmin(least, hypot(sx - p.x[i] - u*(p.x[k] - p.x[i]), sy - p.y[i] - u*(p.y[k] - p.y[i])));
                }
            CHECK_NEAR(hypot(sx - w->foot_x[j], sy - w->foot_y[j]), least, 1e-2, 0);
            CHECK(hypot(sx - w->foot_x[j], sy - w->foot_y[j]) <= least + 1e-14);
        }
    }
}

/* An open target: samples between the first and the last station count, the others do not. */
TEST(only_the_covered_piece_counts)
{
    int n_home = 0;
    lw_rng rng = check_rng(7);
    for (int trial = 0; trial < 30; trial++) {
        member m;
        stations st;
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        lw_fit_spec spec = lw_fit_spec_default();
        draw_member("crank-rocker", 1, false, &rng, &m);
        m.first = lw_rng_range(&rng, -3, 3);
        m.last = m.first + lw_rng_range(&rng, 1, 5);
        trace_member(&m, 12, &st);                       /* the last a step before m.last            */
        st.closed = false;
        spec.timing = LW_TIMING_NONE;
        target_of(&st, &spec, &t);
        CHECK_OK(lw_problem_make(&t, &spec, m.family, 1, 1, &p, &check_error));
        variables_of(&p, &m, x);
        FREED lw_work *w = new_work(&p);
        lw_problem_value(&p, x, NULL, w);
        bool home = true;                                /* none where the curve crosses or runs back on itself */
        for (size_t i = 0; i < 12; i++)
            home &= fabs(remainder(w->phase[i] - st.input[i], 2*LW_PI)) < 1e-6;
        n_home += home;
        for (int j = 0; home && j < M; j++) {
            double at = remainder(w->turn[j] - st.input[0], 2*LW_PI), span = st.input[11] - st.input[0];
            at += at < 0 ? 2*LW_PI : 0;
            bool counts = w->foot_x[j] != w->jac.x[p.n + (size_t)j] || w->foot_y[j] != w->jac.y[p.n + (size_t)j];
            CHECK_INT(counts, at <= span);
        }
    }
    CHECK(n_home > 15);
}
