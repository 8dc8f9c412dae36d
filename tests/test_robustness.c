/* The spread of a path under tolerances: the linear figure against differences of a plain formula, random linkages
 * against the linear figure where tolerances are small, and against a Monte Carlo of the test's own where they are
 * not. */
#include "optimise/report/robustness.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"
#include "tests/mbs_random.h"

enum { POSTURES = 24 };
static const double bar[9] = { 3.1, 1.0, 2.7, 2.2, 1.3, 0.9, 0.4, -0.3, 0.25 };

static void make_bar(lw_linkage *k, double *input)
{
    fourbar_linkage(k, bar, 1, 0.4);
    k->n_tracer = 1;
    k->tracer[0].link = 2;
    k->tracer[0].at = fourbar_at(bar, 1, 0.4).p;
    for (int i = 0; i < POSTURES; i++)
        input[i] = 2*LW_PI*i/POSTURES;
}

/* theta0 varies by the tolerance over the mean length, all others by a third of the tolerance. */
TEST(linear_figure_is_that_of_differences)
{
    lw_linkage k;
    lw_robustness r;
    lw_tolerances of = { .length = 1e-4, .trials = 4000, .seed = 1 };
    double input[POSTURES], size = 0, all = 0, part[9] = { 0 };
    make_bar(&k, input);
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_OK);
    for (int d = 0; d < 6; d++)                            /* r1 r2 r3 r4 cx cy                          */
        size += fabs(bar[d])/6;
    for (int d = 0; d < 9; d++)
        for (int i = 0; i < POSTURES; i++) {
            double up[9], down[9], h = 1e-6, sigma = of.length/3/(d == 8 ? size : 1);
            memcpy(up, bar, sizeof up);
            memcpy(down, bar, sizeof down);
            up[d] += h;
            down[d] -= h;
            lw_vec2 by = lw_v2_sub(fourbar_at(up, 1, 0.4 + input[i]).p, fourbar_at(down, 1, 0.4 + input[i]).p);
            part[d] += pow(sigma*lw_v2_norm(by)/(2*h), 2)/POSTURES;
        }
    for (int d = 0; d < 9; d++)
        all += part[d];
    CHECK_NEAR(r.rms, sqrt(all), 0, 1e-6);
    CHECK_INT(r.n_part, 9);
    int first = 0;
    for (int d = 0; d < 9; d++) {
        CHECK_NEAR(r.part[d], part[d]/all, 1e-6, 1e-6);
        first = part[d] > part[first] ? d : first;
    }
    CHECK_NEAR(r.part[r.first], r.part[first], 1e-12, 0);        /* cx, cy, x0, y0 matter equally     */
    CHECK(r.worst >= r.rms);
    CHECK_INT(r.open, 0);
    CHECK_NEAR(r.trial_rms, r.rms, 0, 0.05);               /* 4000 trials: 1 to 2 %                       */
    CHECK(r.within > r.worst && r.within < 5*r.worst);
}

/* The variances of place and angle of a link in the worst of 64 postures over the turn, by differences: of a motion the angle counts half
 * the diagonal of the target, of a function alone. */
TEST(deviation_is_that_of_differences)
{
    const double extent = 2.4, theta[2] = { 0 }, tolerance = 3e-3, h = 1e-6;
    const lw_tolerances of = { .length = tolerance };
    double start[2] = { 0.4, 0.9 }, input[POSTURES];
    lw_fit_report *r = calloc(1, sizeof *r);
    if (!r)
        return;
    r->turns = true;
    make_bar(&r->linkage, input);
    for (int function = 0; function < 2; function++) {
        const lw_target t = { .n = 2, .theta = (double *)theta, .extent = function ? 0 : extent };
        const lw_candidate c = { .input = start };
        double most = 0, size = 0, deviation;
        if (function) {                                    /* a tracer at the pin of the rocker on the coupler */
            fourbar_joints q = fourbar_at(bar, 1, 0.4);
            r->linkage.tracer[0].link = 3;
            r->linkage.tracer[0].at = q.b;
        }
        for (int d = 0; d < 4; d++)
            size += bar[d];
        size = (size + (function ? bar[3] : fabs(bar[4]) + fabs(bar[5])))/6;
        for (int i = 0; i < 64; i++) {
            double square = 0;
            for (int d = 0; d < 9; d++) {
                double up[9], down[9], sigma = tolerance/3/(d == 8 ? size : 1), at = 0.4 + 2*LW_PI*i/64;
                if (function && (d == 4 || d == 5))
                    continue;
                memcpy(up, bar, sizeof up);
                memcpy(down, bar, sizeof down);
                up[d] += h;
                down[d] -= h;
                fourbar_joints a = fourbar_at(up, 1, at), b = fourbar_at(down, 1, at);
                lw_vec2 la = lw_v2_sub(a.b, function ? a.b0 : a.a), lb = lw_v2_sub(b.b, function ? b.b0 : b.a);
                double turn = remainder(atan2(la.y, la.x) - atan2(lb.y, lb.x), 2*LW_PI)/(2*h);
                double place = function ? 0 : lw_v2_norm(lw_v2_sub(a.p, b.p))/(2*h);
                square += pow(sigma*place, 2) + pow(sigma*turn*(function ? 1 : 0.5*extent), 2);
            }
            most = fmax(most, square);
        }
        CHECK_INT(lw_robustness_deviation(&t, &c, r, &of, &deviation), LW_OK);
        CHECK_NEAR(deviation, sqrt(most), 0, 1e-6);
    }
    free(r);
}

/* The point of the four-bar `bar` where the pins of the crank on the ground, crank and coupler, coupler and rocker, rocker and
 * ground lie beside their places on the next link by e[4], from circles that meet. */
static lw_vec2 point_with_play(const double k[9], double input, const lw_vec2 e[4])
{
    lw_vec2 a = lw_v2_add(lw_v2_polar(k[1], input), lw_v2_add(e[0], e[1])), b0 = lw_v2_add(lw_v2(k[0], 0), lw_v2_add(e[2], e[3]));
    lw_vec2 along = lw_v2_sub(meet(a, k[2], b0, k[3], 1), a);
    return lw_v2_add(a, lw_v2_turn(along, lw_v2(k[4]/k[2], k[5]/k[2])));         /* in the frame of the ground */
}

/* A clearance of radius c: each pin is displaced along both axes with a standard deviation of c/2. */
TEST(clearance_moves_every_pin_both_ways)
{
    lw_linkage k;
    lw_robustness r;
    double input[POSTURES], all = 0, h = 1e-6, part[4] = { 0 };
    make_bar(&k, input);
    lw_tolerances of = { .clearance = 2e-4, .trials = 4000, .seed = 1 };
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_OK);
    for (int i = 0; i < POSTURES; i++) {
        for (int m = 0; m < 8; m++) {
            lw_vec2 up[4] = { { 0, 0 } }, down[4] = { { 0, 0 } };
            *(m % 2 ? &up[m/2].y : &up[m/2].x) = h;
            *(m % 2 ? &down[m/2].y : &down[m/2].x) = -h;
            double by = lw_v2_norm(lw_v2_sub(point_with_play(bar, 0.4 + input[i], up), point_with_play(bar, 0.4 + input[i], down)))/(2*h);
            part[m/2] += pow(0.5*of.clearance*by, 2)/POSTURES;
        }
    }
    for (int m = 0; m < 4; m++)
        all += part[m];
    CHECK_NEAR(r.rms, sqrt(all), 0, 1e-6);
    CHECK_NEAR(r.trial_rms, r.rms, 0, 0.05);
    CHECK_INT(r.n_part, 9 + 4);
    for (int j = 0; j < 4; j++)                            /* joints in the order of fourbar_linkage */
        CHECK_NEAR(r.part[9 + j], part[j]/all, 1e-6, 1e-6);
    CHECK(!strncmp(r.name[r.first], "pin ", 4));
}

/* Play is between two links: it does not matter which of them a pin is displaced on, beside sliders and on links of three joints too. */
TEST(play_is_between_two_links)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 1);
    int compared = 0;
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage k;
        lw_robustness one, other;
        const lw_tolerances of = { .clearance = 1e-3, .trials = 1, .seed = 1 };
        const double input = 0;
        if (trial % 2)
            random_type(&rng, &lw_type_table[trial/2 % 11], &k);
        else
            random_grown(&rng, 3, &k);
        if (lw_robustness_make(&k, &input, 1, &of, &one, NULL) != LW_OK)
            continue;
        for (int j = 0; j < k.n_joint; j++)
            if (j != k.input[0].joint && lw_joint_turns(k.joint[j].kind)) {
                int first = k.joint[j].link[0];
                k.joint[j].link[0] = k.joint[j].link[1];
                k.joint[j].link[1] = first;
            }
        CHECK_INT(lw_robustness_make(&k, &input, 1, &of, &other, NULL), LW_OK);
        CHECK_NEAR(other.rms, one.rms, 0, 1e-7);
        compared++;
    }
    CHECK(compared >= 50);
}

/* A linkage near a change point opens now and then; one that does not close is refused. */
TEST(open_linkages_are_counted)
{
    static const double tight[9] = { 3, 1, 2.5, 1.52, 0.5, 0.5, 0, 0, 0 };
    lw_linkage k;
    lw_robustness r;
    double input[POSTURES];
    make_bar(&k, input);
    fourbar_linkage(&k, tight, 1, 1);
    k.n_tracer = 1;
    k.tracer[0].link = 2;
    k.tracer[0].at = fourbar_at(tight, 1, 1).p;
    for (int i = 0; i < POSTURES; i++)
        input[i] = 2*LW_PI*i/POSTURES - 1;
    lw_tolerances of = { .length = 0.1, .trials = 500, .seed = 1 };
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_OK);
    CHECK(r.open > 0 && r.open < 500);
    of.length = -1;
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_E_ARG);
}
