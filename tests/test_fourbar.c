/* tests/test_fourbar.c - Barker's classes, limits, dead points and transmission angles against a
 * brute-force twin that turns the links, and near change points against expansions. */
#include "mbs/kinematics/fourbar.h"
#include "base/vec2.h"
#include "tests/check.h"

/* --- the twin: closes or not, by distances only --- */

static double diagonal(double g, double a, double t)
{
    return hypot(g - a*cos(t), a*sin(t));
}

/* can the four-bar stand with link i (1 input, 2 coupler, 3 output) at angle t from the frame? */
static bool stands(const double r[4], int i, double t)
{
    double d = diagonal(r[0], r[i], t), x = r[i == 1 ? 2 : 1], y = r[i == 3 ? 2 : 3];
    double slack = 1e-13*(r[0] + r[1] + r[2] + r[3]);
    return d <= x + y + slack && d >= fabs(x - y) - slack;
}

static bool turns(const double r[4], int i)
{
    for (int k = -180; k <= 180; k++)
        if (!stands(r, i, k*LW_PI/180.0))
            return false;
    return true;
}


/* Barker's symbol from what turns: classes with s + l < p + q and > p + q. */
static void twin_symbol(const double r[4], char *out)
{
    bool c[4] = { false, turns(r, 1), turns(r, 2), turns(r, 3) };
    if (c[1] || c[2] || c[3]) {
        sprintf(out, "G%c%c%c", c[1] ? 'C' : 'R', c[2] ? 'C' : 'R', c[3] ? 'C' : 'R');
        return;
    }
    int longest = 0;
    for (int i = 1; i < 4; i++)
        if (r[i] > r[longest])
            longest = i;
    sprintf(out, "RRR%d", longest + 1);
}

static void permute(const double base[4], int number, double r[4])
{
    int left[4] = { 0, 1, 2, 3 };
    for (int i = 0; i < 4; i++) {
        int k = number % (4 - i);
        number /= 4 - i;
        r[i] = base[left[k]];
        for (int j = k; j < 3 - i; j++)
            left[j] = left[j + 1];
    }
}

/* Every class by every permutation of lengths that belong to it; letters say what turns. */
TEST(classes_of_all_permutations)
{
    static const double base[4][4] = { { 2, 5, 6, 7 }, { 3, 4, 5, 7 }, { 1, 2, 3, 4.5 }, { 4, 5, 6, 10 } };
    int seen[15] = { 0 };
    for (int k = 0; k < 4; k++)
        for (int n = 0; n < 24; n++) {
            double r[4];
            char want[8];
            lw_fourbar_class c;
            permute(base[k], n, r);
            CHECK_INT(lw_fourbar_classify(r, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
            twin_symbol(r, want);
            CHECK_TEXT(c.symbol, want);
            CHECK_INT(c.crank, turns(r, 1));
            CHECK_INT(c.rocker_turns, turns(r, 3));
            CHECK_INT(c.grashof, want[0] == 'G');
            CHECK_INT(c.circuits, want[0] == 'G' ? 2 : 1);
            seen[c.number]++;
        }
    for (int i = 1; i <= 8; i++)
        CHECK(seen[i] >= 6);
}

/* docs/theory.md, four-bar classes 9 to 14; equality is exact here, all lengths being integers. */
TEST(classes_of_change_points)
{
    static const struct { double r[4]; int number; const char *symbol; bool crank, rocker; } known[] = {
        { { 2, 4, 5, 3 }, 9,  "CPCCC", true,  true  }, { { 2, 3, 4, 5 }, 9, "CPCCC", true, true },
        { { 4, 2, 5, 3 }, 10, "CPCRR", true,  false }, { { 3, 2, 4, 5 }, 10, "CPCRR", true, false },
        { { 5, 4, 2, 3 }, 11, "CPRCR", false, false }, { { 3, 4, 2, 5 }, 11, "CPRCR", false, false },
        { { 5, 3, 4, 2 }, 12, "CPRRC", false, true  }, { { 3, 5, 4, 2 }, 12, "CPRRC", false, true },
        { { 5, 2, 5, 2 }, 13, "CP2X",  true,  true  },            /* parallelogram                */
        { { 2, 5, 2, 5 }, 13, "CP2X",  true,  true  },
        { { 2, 2, 5, 5 }, 13, "CP2X",  true,  true  },            /* kite, deltoid                */
        { { 5, 5, 2, 2 }, 13, "CP2X",  false, true  },
        { { 2, 5, 5, 2 }, 13, "CP2X",  true,  true  },
        { { 5, 2, 2, 5 }, 13, "CP2X",  true,  false },
        { { 3, 3, 3, 3 }, 14, "CP3X",  true,  true  },            /* rhombus                      */
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_fourbar_class c;
        CHECK_INT(lw_fourbar_classify(known[i].r, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
        CHECK_INT(c.number, known[i].number);
        CHECK_TEXT(c.symbol, known[i].symbol);
        CHECK(c.grashof && c.margin == 0.0 && c.change == 0.0 && c.circuits == 1);
        CHECK_INT(c.crank, turns(known[i].r, 1));
        CHECK_INT(c.crank, known[i].crank);
        CHECK_INT(c.rocker_turns, turns(known[i].r, 3));
        CHECK_INT(c.rocker_turns, known[i].rocker);
    }
}

static double bisect(const double r[4], double good, double bad)
{
    for (int i = 0; i < 100; i++) {
        double t = 0.5*(good + bad);
        double d = diagonal(r[0], r[1], t);
        if (d <= r[2] + r[3] && d >= fabs(r[2] - r[3]))
            good = t;
        else
            bad = t;
    }
    return good;
}

static void draw_lengths(lw_rng *rng, double r[4])
{
    double longest, sum;
    do {
        sum = longest = 0.0;
        for (int i = 0; i < 4; i++) {
            r[i] = lw_rng_range(rng, 0.1, 1.0);
            sum += r[i];
            longest = fmax(longest, r[i]);
        }
    } while (sum - 2.0*longest < 1e-3);
}

/* limits found by turning the input in small steps and bisecting */
static void check_limits(const double r[4], const lw_fourbar_class *c)
{
    enum { N = 2000 };
    int n = 0;
    for (int k = 0; k < N; k++) {
        double t = -LW_PI + 2.0*LW_PI*k/N, u = -LW_PI + 2.0*LW_PI*(k + 1)/N;
        double d0 = diagonal(r[0], r[1], t), d1 = diagonal(r[0], r[1], u);
        bool in0 = d0 <= r[2] + r[3] && d0 >= fabs(r[2] - r[3]);
        bool in1 = d1 <= r[2] + r[3] && d1 >= fabs(r[2] - r[3]);
        if (in0 == in1)
            continue;
        CHECK(n < c->n_limit);
        double want = in0 ? bisect(r, t, u) : bisect(r, u, t);
        double slope = fabs(r[0]*r[1]*sin(want));
        CHECK_NEAR(c->limit[n], want, 1e-14/fmin(slope, 1.0) + 4e-16, 0);
        n++;
    }
    CHECK_INT(n, c->n_limit);
}

/* one posture of the twin: transmission angle, and the sine of the angle from crank to coupler */
static void posture(const double r[4], double t, double mode, double *transmission, double *line)
{
    double d = diagonal(r[0], r[1], t), b = r[2], h = r[3];
    *transmission = acos(fmax(-1.0, fmin(1.0, (b*b + h*h - d*d)/(2.0*b*h))));
    double turn = atan2(-r[1]*sin(t), r[0] - r[1]*cos(t));
    double inner = mode*acos(fmax(-1.0, fmin(1.0, (b*b + d*d - h*h)/(2.0*b*d))));
    *line = sin(turn + inner - t);
}

static void check_sweep(const double r[4], const lw_fourbar_class *c)
{
    enum { N = 4000 };
    double least = LW_PI, most = 0.0, last = 0.0;
    int n_dead = 0;
    for (int mode = -1; mode <= 1; mode += 2)
        for (int k = 0; k < c->n_range; k++)
            for (int i = 0; i <= N; i++) {
                double first = c->range[k][0], span = c->range[k][1] - first, m, line;
                double x = -cos(LW_PI*i/N);                   /* dense at the ends */
                double t = first + 0.5*span*(1.0 + (c->n_limit ? x : 2.0*i/N - 1.0));
                posture(r, t, mode, &m, &line);
                least = fmin(least, m);
                most = fmax(most, m);
                n_dead += i > 0 && line*last < 0.0;
                last = line;
                CHECK(m >= c->transmission[0] - 1e-7 && m <= c->transmission[1] + 1e-7);
            }
    CHECK_NEAR(least, c->transmission[0], 3e-3, 0);
    CHECK_NEAR(most, c->transmission[1], 3e-3, 0);
    CHECK_INT(n_dead, c->n_dead);
    for (int i = 0; i < c->n_dead; i++) {
        double m, one, two;
        posture(r, c->dead[i], 1.0, &m, &one);
        posture(r, c->dead[i], -1.0, &m, &two);
        CHECK_NEAR(fmin(fabs(one), fabs(two)), 0.0, 1e-6, 0);
        CHECK(i == 0 || c->dead[i] > c->dead[i - 1]);
    }
}

TEST(random_lengths_agree_with_the_sweep)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        double r[4];
        char want[8];
        lw_fourbar_class c;
        draw_lengths(&rng, r);
        CHECK_INT(lw_fourbar_classify(r, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
        if (c.margin < 1e-3)
            continue;                       /* the sampled twin cannot see narrow gaps */
        twin_symbol(r, want);
        CHECK_TEXT(c.symbol, want);
        CHECK_INT(c.crank, c.n_limit == 0);
        check_limits(r, &c);
        check_sweep(r, &c);
    }
}

static void same_class(const lw_fourbar_class *p, const lw_fourbar_class *q, double tolerance)
{
    CHECK_INT(p->number, q->number);
    CHECK_INT(p->n_limit, q->n_limit);
    CHECK_INT(p->n_dead, q->n_dead);
    CHECK_NEAR(p->margin, q->margin, tolerance, 0);
    CHECK_NEAR(p->change, q->change, tolerance, 0);
    for (int i = 0; i < p->n_limit; i++)
        CHECK_NEAR(p->limit[i], q->limit[i], 100.0*tolerance, 0);
    for (int i = 0; i < p->n_dead; i++)
        CHECK_NEAR(p->dead[i], q->dead[i], 100.0*tolerance, 0);
}

TEST(unit_does_not_matter)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 300; trial++) {
        double r[4], two[4], ten[4], far[4];
        lw_fourbar_class a, b, c, d;
        draw_lengths(&rng, r);
        for (int i = 0; i < 4; i++) {
            two[i] = ldexp(r[i], -300);
            ten[i] = r[i]*1e9;
            far[i] = r[i]*1e-9;
        }
        lw_fourbar_classify(r, LW_FOURBAR_TOLERANCE, &a, NULL);
        lw_fourbar_classify(two, LW_FOURBAR_TOLERANCE, &b, NULL);
        lw_fourbar_classify(ten, LW_FOURBAR_TOLERANCE, &c, NULL);
        lw_fourbar_classify(far, LW_FOURBAR_TOLERANCE, &d, NULL);
        same_class(&b, &a, 0.0);
        if (a.margin > 1e-3) {
            same_class(&c, &a, 1e-15);
            same_class(&d, &a, 1e-15);
        }
    }
}

/* g + a - b - h = q exactly: the outer limit stands at pi - e with
 * 4 g a sin^2(e/2) = (g + a)^2 - (b + h)^2 = q (g + a + b + h).  For q < 0 the crank turns, and the
 * transmission angle comes as near to pi as  4 b h sin^2(m/2) = -q (g + a + b + h). */
TEST(accurate_near_the_outer_change_point)
{
    for (int k = 8; k <= 50; k++) {
        double q = ldexp(1.0, -k), g = 4.0, a = 2.0, b = 3.0;
        double wide[4] = { g, a, b, 3.0 - q }, turning[4] = { g, a, b, 3.0 + q };
        lw_fourbar_class c;
        CHECK_INT(lw_fourbar_classify(wide, 0.0, &c, NULL), LW_OK);
        CHECK_TEXT(c.symbol, "RRR1");
        CHECK_INT(c.n_limit, 2);
        double e = 2.0*asin(sqrt(q*(12.0 - q)/(4.0*g*a)));
        CHECK_NEAR(LW_PI - c.limit[1], e, 4e-16, 4e-16);
        CHECK_NEAR(c.limit[0], -c.limit[1], 0, 0);
        CHECK_NEAR(c.change, q/(12.0 - q), 0, 4e-16);
        CHECK_NEAR(c.margin, q/(12.0 - q), 0, 4e-16);

        CHECK_INT(lw_fourbar_classify(turning, 0.0, &c, NULL), LW_OK);
        CHECK_TEXT(c.symbol, "GCRR");
        CHECK_INT(c.n_limit, 0);
        double m = 2.0*asin(sqrt(q*(12.0 + q)/(4.0*b*(3.0 + q))));
        CHECK_NEAR(LW_PI - c.transmission[1], m, 4e-16, 4e-16);
        CHECK_NEAR(c.change, -q/(12.0 + q), 0, 4e-16);

        double tolerance = 1.5*q/12.0;       /* now it counts as a change point, from both sides */
        CHECK_INT(lw_fourbar_classify(wide, tolerance, &c, NULL), LW_OK);
        CHECK(c.number == 10 && c.n_limit == 0 && c.crank);
        CHECK_INT(lw_fourbar_classify(turning, tolerance, &c, NULL), LW_OK);
        CHECK(c.number == 10 && c.n_limit == 0 && c.crank);
        CHECK_NEAR(c.transmission[1], LW_PI, 0, 0);
    }
}

/* |g - a| against |b - h|: the inner limit stands at e with
 * 4 g a sin^2(e/2) = (b - h)^2 - (g - a)^2. */
TEST(accurate_near_the_inner_change_point)
{
    for (int k = 8; k <= 50; k++) {
        double q = ldexp(1.0, -k);
        double r[4] = { 4.0, 3.0, 3.5, 2.5 - q };               /* |b - h| = 1 + q, |g - a| = 1 */
        lw_fourbar_class c;
        CHECK_INT(lw_fourbar_classify(r, 0.0, &c, NULL), LW_OK);
        double e = 2.0*asin(sqrt(q*(2.0 + q)/48.0));
        CHECK_INT(c.n_limit, 4);
        CHECK_NEAR(c.limit[2], e, 0, 1e-15);
        CHECK_NEAR(c.limit[1], -e, 0, 1e-15);
        CHECK_INT(c.n_range, 2);
        CHECK_NEAR(c.range[1][0], e, 0, 1e-15);
        CHECK_NEAR(c.transmission[0], 0.0, 0, 0);
    }
}

/* Computed with 22 digits from the two triangles: the rocker's angles at the dead centres of 4 1 3.5 3,
 * measured at its pivot from the frame, and the end of the swing of 4 3 2 2.5. */
TEST(dead_centres_and_limits_as_known)
{
    double r[4] = { 4, 1, 3.5, 3 }, rocking[4] = { 4, 3, 2, 2.5 };
    const double folded = 0.6741305066673151775421, extended = 1.371564239549725741635;
    lw_fourbar_class c;
    CHECK_INT(lw_fourbar_classify(r, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
    CHECK_INT(c.n_dead, 4);
    for (int i = 0; i < 4; i++) {
        /* in line: B at r2 + r3 along the crank, or at r2 - r3 */
        double out = fabs(hypot(4.5*cos(c.dead[i]) - 4.0, 4.5*sin(c.dead[i])) - 3.0) < 1e-9 ? 4.5 : -2.5;
        double x = 4.0 - out*cos(c.dead[i]), y = out*sin(c.dead[i]);
        CHECK_NEAR(fabs(atan2(y, x)), out > 0.0 ? extended : folded, 0, 4e-16);
    }
    CHECK_INT(lw_fourbar_classify(rocking, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
    CHECK_INT(c.n_limit, 2);
    CHECK_NEAR(c.limit[1]*180.0/LW_PI, 78.5848422572695088631, 0, 4e-16);
}

TEST(length_ratio_of_a_million)
{
    double r[4] = { 1.0, 1e-6, 1.0, 1.0 };
    lw_fourbar_class c;
    CHECK_INT(lw_fourbar_classify(r, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
    CHECK_TEXT(c.symbol, "GCRR");
    /* diagonal 1 -+ 1e-6 opposite of the angle between two sides of 1: 2 asin(d/2) */
    CHECK_NEAR(c.transmission[0], 2.0*asin((1.0 - 1e-6)/2.0), 0, 1e-15);
    CHECK_NEAR(c.transmission[1], 2.0*asin((1.0 + 1e-6)/2.0), 0, 1e-15);
}

TEST(says_why_it_cannot_be)
{
    static const struct { double r[4], tolerance; const char *part[3]; } bad[] = {
        { { 1, 1, 10, 2 },   1e-12, { "coupler (10)", "sum of the other three (4)", "exceeds it by 6" } },
        { { 6, 1, 3, 2 },    1e-12, { "frame (6)", "other three (6)", "equals it" } },
        { { 1, 0, 1, 1 },    1e-12, { "input", "is 0", "positive" } },
        { { 1, 1, -2, 1 },   1e-12, { "coupler", "-2", "positive" } },
        { { 1, 1, 1, NAN },  1e-12, { "output", "nan", "finite" } },
        { { INFINITY, 1, 1, 1 }, 1e-12, { "frame", "inf", "finite" } },
        { { 4, 2, 5, 3 },    -1.0,  { "tolerance", "-1", "at least 0" } },
        { { 4, 2, 5, 3 },    NAN,   { "tolerance", "nan", "at least 0" } },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        lw_fourbar_class c;
        lw_error e = { 0 };
        CHECK_INT(lw_fourbar_classify(bad[i].r, bad[i].tolerance, &c, &e), LW_E_ARG);
        CHECK_INT(e.status, LW_E_ARG);
        for (int k = 0; k < 3; k++)
            CHECK_HAS(e.text, bad[i].part[k]);
        CHECK_INT(lw_fourbar_classify(bad[i].r, bad[i].tolerance, &c, NULL), LW_E_ARG);
    }
}
