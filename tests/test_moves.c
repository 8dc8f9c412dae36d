/* Lists of moves: exact series, kinks, and models that follow them. */
#include "grammar/model/spatial.h"
#include "mbs/dynamics/dynamics_space.h"
#include "tests/dynamics_run.h"

static drun d;

static void read_model(const char *profiles, const char *rest)
{
    char text[3000];
    json_format(text, sizeof text, "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'cart', 'mass': 2, "
                "'centre': [0, 0], 'inertia': 1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], "
                "'at': [0, 0], 'along': [1, 0]}], 'profiles': [%s], %s}", profiles, rest);
    drun_read_text(&d, text);
}

#define GO "{'name': 'go', 'speed': 3, 'acceleration': 20, 'jerk': 400, 'start': 0.1, 'from': 0.25, " \
           "'moves': [{'to': 1, 'dwell': 0.2}, {'to': 0, 'law': '%s', 'duration': 0.5}, {'to': 0.3, 'duration': 0.6}]}"

/* The Taylor polynomial of order 8 gives what stands nearby on its side; its first terms are those of profile and law. */
TEST(series_are_exact)
{
    for (int law = 0; lw_motion_law_get(law); law++) {
        char profiles[600];
        snprintf(profiles, sizeof profiles, GO, lw_motion_law_get(law)->name);
        read_model(profiles, "'input': {'joint': 'S', 'motion': 'profile(go)'}");
        const lw_moves *m = &d.model.profile[0];
        CHECK_NEAR(m->move[1].start, 0.1 + m->move[0].duration + 0.2, 1e-15, 0);
        int kinks = 0;
        for (double t = -0.1, next; t < m->end; t = next, kinks++) {
            next = lw_moves_next_kink(m, t);
            if (!(next < INFINITY))
                break;
            double middle = 0.5*(t + next), half = 0.5*(next - t), c[9], v[9], at[9] = { middle, 1 };
            lw_moves_series(m, middle, 1, 8, c);
            lw_expression_series(d.model.motion[0], 8, at, v);
            for (int k = 0; k < 9; k++)
                CHECK_NEAR(v[k], c[k], 0, 1e-15);
            for (double x = -0.2; x < 0.3; x += 0.1) {
                double sum = 0;
                for (int k = 8; k >= 0; k--)
                    sum = sum*x*half + c[k];
                CHECK_NEAR(lw_moves_at(m, middle + x*half).x, sum, 2e-8, 0);
                CHECK_NEAR(lw_expression_value(d.model.motion[0], (double[]){ middle + x*half }),
                           lw_moves_at(m, middle + x*half).x, 0, 0);
            }
            lw_moves_series(m, next, -1, 2, c);              /* both sides of a kink agree in way and speed */
            lw_moves_series(m, next, 1, 2, v);
            CHECK_NEAR(c[0], v[0], 1e-12, 0);
            CHECK_NEAR(c[1], v[1], 1e-11, 0);
        }
        CHECK(kinks >= 15);
        CHECK_NEAR(lw_moves_at(m, 9).x, 0.3, 0, 0);
        CHECK_NEAR(lw_moves_at(m, -9).x, 0.25, 0, 0);
    }
}

/* Way and speed of 2 kg under a force that a list of moves says, each turn anew; by Simpson's rule between the kinks, where
 * the force is of degree 2. */
static void exact_motion(double end, double *x, double *v)
{
    const lw_moves *m = &d.model.profile[0];
    enum { N = 200 };
    *x = *v = 0;
    for (double t = 0; t < end;) {
        double turn = floor(t/0.75 + 1e-12), own = t - 0.75*turn;
        double next = fmin(fmin(0.75*turn + lw_moves_next_kink(m, own + 1e-12), 0.75*(turn + 1)), end), h = (next - t)/N;
        for (int i = 0; i < N; i++) {
            double a = own + i*h, f[3], series[3];
            for (int k = 0; k < 3; k++) {
                lw_moves_series(m, a + 0.5*k*h, k == 2 ? -1 : 1, 0, series);
                f[k] = series[0];
            }
            *x += *v*h + h*h*(f[0] + 2*f[1])/6;              /* force 2 profile over 2 kg */
            *v += h*(f[0] + 4*f[1] + f[2])/6;
        }
        t = next;
    }
}

TEST(runs_stop_at_kinks)
{
    static const lw_formulation formulation[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                                  LW_FORMULATION_GGL };
    static const double off[] = { 1e-12, 1e-12, 1e-6, 1e-6 };
    lw_measure s;
    for (int k = 0; k < 4; k++) {
        double x, v;
        read_model("{'name': 'go', 'speed': 3, 'acceleration': 20, 'start': 0.1, 'moves': [{'to': 1}, {'to': 0}]}",
                   "'input': {'joint': 'S', 'speed': 0}, 'forces': [{'link': 'cart', 'at': [0, 0], 'fx': '2*profile(go, mod(t, 0.75))'}]");
        CHECK_INT(drun_to(&d, formulation[k], 1e-8, 2, 8), LW_OK);
        CHECK_TEXT(d.e.text, "");
        CHECK_INT(d.n_moment, 9);
        lw_measure_joint(&d.system, 0, d.q, d.v, false, &s);
        exact_motion(2, &x, &v);
        CHECK_NEAR(s.value, x, off[k], 0);
        CHECK_NEAR(s.rate, v, off[k], 0);
        CHECK(k > 1 || d.report.steps < 60);                 /* no step is wasted on a kink */
    }
}

/* Forces of 0.5 N s within 1 ms, in a second in which nothing else happens: the cart of 2 kg goes on at 0.25 m/s.  Samples before,
 * in and behind the pulse, or one at the end alone. */
TEST(short_pulses_are_seen)
{
    static const char *const pulse[] = { "step(t, 0.5, 0, 0.5005, 1000) - step(t, 0.5005, 0, 0.501, 1000)",
        "max(0, min(2e6*(t - 0.5), 2e6*(0.501 - t)))", "500*max(0, sign(t - 0.5)*sign(0.501 - t))" };
    static const struct { lw_formulation f; double off; } way[] = { { LW_FORMULATION_AUTO, 1e-8 }, { LW_FORMULATION_REDUCED, 1e-8 },
        { LW_FORMULATION_INDEX1, 1e-8 }, { LW_FORMULATION_CVODE, 1e-6 }, { LW_FORMULATION_GGL, 1e-6 }, { LW_FORMULATION_RADAU, 1e-8 },
        { LW_FORMULATION_ALPHA, 1e-4 } };
    for (int p = 0; p < 3; p++)
        for (int f = 0; f < 7; f++)
            for (int n = 1; n <= 2000; n = n == 1 ? 2 : 1000*n) {
                char rest[400];
                snprintf(rest, sizeof rest, "'input': {'joint': 'S', 'speed': 0}, 'forces': [{'link': 'cart', 'at': [0, 0], 'fx': '%s'}]",
                         pulse[p]);
                read_model("", rest);
                CHECK_INT(drun_to(&d, way[f].f, 1e-8, 1, n), LW_OK);
                CHECK_NEAR(d.v[0]*d.system.unit, 0.25, way[f].off, 0);
                CHECK_NEAR(d.t[d.n_moment - 1], 1, 0, 0);
            }
}

/* The same of smooth pulses, narrower than any first guess of a step: their impulse over the mass is the speed, at each tolerance, in
 * each formulation; of humps and a square wave of sines, whose kinks are found; and where an interval without pulses ends beside a row. */
TEST(smooth_pulses_are_seen)
{
    const double root_pi = sqrt(LW_PI);
    const struct { const char *text; double speed; } pulse[] = {
        { "500*exp(-((t - 0.4973)/1e-3)^2)", 0.25*root_pi }, { "5e5*exp(-((t - 0.9)/1e-6)^2)", 0.25*root_pi },
        { "50*(tanh((t - 0.5)/1e-3) - tanh((t - 0.51)/1e-3))", 0.5 },
        { "500/(1 + ((t - 0.3)/1e-4)^2)", 0.025*(atan(3e3) + atan(7e3)) },
        { "max(0, sin(4*pi*t))", 0.5/LW_PI }, { "sign(sin(5*t))", 0.5*(2*LW_PI/5 - 1) }, { "50*sin(5*pi*t)^2*step(t, 0.2, 1, 0.3, 0)", 2.5*(1.25 - 12/pow(LW_PI, 4)) }, { "500/cosh((t - 0.8)/1e-3)", 0.25*LW_PI },
        { "state(u)", 0.125*root_pi*(1 - 0.4) } };
    static const struct { lw_formulation f; double off; } way[] = { { LW_FORMULATION_REDUCED, 30 }, { LW_FORMULATION_INDEX1, 30 },
        { LW_FORMULATION_CVODE, 100 }, { LW_FORMULATION_GGL, 100 }, { LW_FORMULATION_RADAU, 30 }, { LW_FORMULATION_ALPHA, 100 } };     /* tolerances */
    for (int p = 0; p < 9; p++)
        for (int f = p == 8; f < 6; f++)
            for (int k = 0; k < 4; k++) {
                char rest[500];
                snprintf(rest, sizeof rest, "'input': {'joint': 'S', 'speed': 0}, 'states': [{'name': 'u', 'rate': '250*exp(-((t - 0.4)/1e-3)^2)', "
                         "'start': 0}], 'forces': [{'link': 'cart', 'at': [0, 0], 'fx': '%s'}]", pulse[p].text);
                if (f == 0)                                  /* it knows no states */
                    snprintf(rest, sizeof rest, "'input': {'joint': 'S', 'speed': 0}, 'forces': [{'link': 'cart', 'at': [0, 0], 'fx': '%s'}]",
                             pulse[p].text);
                read_model("", rest);
                double tolerance = k < 2 ? 1e-4 : f < 5 ? 1e-8 : 1e-5;       /* alpha is for loose ones */
                CHECK_INT(drun_to(&d, way[f].f, tolerance, 1, k % 2 ? 50 : 1), LW_OK);
                CHECK_NEAR(d.v[0]*d.system.unit, pulse[p].speed, way[f].off*tolerance, 0);
            }
}

static void refused(const char *profiles, const char *rest, const char *why)
{
    char text[2000];
    lw_model m;
    lw_error e = { 0 };
    json_format(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'cart'], 'joints': [{'name': 'S', 'kind': 't', 'links': "
                "['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]}], 'profiles': [%s], 'input': {'joint': 'S', 'motion': '%s'}}",
                profiles, rest);
    CHECK_INT(lw_model_read(text, strlen(text), "text", &m, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, why);
    CHECK(e.line > 0 && e.column > 0);
}

TEST(bad_moves_are_refused)
{
    static const char good[] = "{'name': 'go', 'speed': 1, 'acceleration': 1, 'moves': [{'to': 1}]}";
    char two[300];
    snprintf(two, sizeof two, "%s, %s", good, good);
    refused(good, "profile(gone)", "no profile \"gone\"");
    refused(good, "profile()", "name");
    refused(good, "profile(go, t", "')' is expected");
    refused(good, "profile(go, q(S))", "t alone");
    refused(two, "0", "two profiles");
    refused("{'name': 'go', 'moves': [{'to': 1}]}", "0", "limit");
    refused("{'name': 'go', 'speed': 1, 'acceleration': 1, 'moves': [{'to': 1, 'duration': 0.5}]}", "0", "duration");
    refused("{'name': 'go', 'speed': 1, 'acceleration': 1, 'moves': []}", "0", "moves");
    refused("{'name': 'go', 'moves': [{'to': 1, 'law': 'cycloid'}]}", "0", "\"duration\"");
}

/* A move by power takes three equal thirds, one for an oscillation leaves it at rest. */
TEST(power_and_frequency)
{
    read_model("{'name': 'go', 'speed': 9, 'acceleration': 20, 'jerk': 400, 'moves': [{'to': 1, 'frequency': 7}]}, "
               "{'name': 'far', 'mass': 2, 'moves': [{'to': 1, 'power': 100}]}", "'input': {'joint': 'S', 'motion': 'profile(go)'}");
    const lw_moves *m = &d.model.profile[0];
    double re = 0, im = 0, w = 8*atan(1)*7;
    enum { N = 200000 };
    for (int i = 0; i < N; i++) {                            /* the acceleration has no part at 7 Hz */
        double t = m->end*(i + 0.5)/N, a = lw_moves_at(m, t).a*m->end/N;
        re += a*cos(w*t);
        im += a*sin(w*t);
    }
    CHECK_NEAR(hypot(re, im), 0, 1e-6, 0);
    CHECK_NEAR(d.model.profile[1].end, 3*pow(2, -2/3.0)*pow(0.02, 1/3.0), 1e-11, 0);
}

/* The same profile in a model in space. */
TEST(profile_in_space)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], 'joints': "
        "[{'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'cart'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}], 'profiles': [{'name': 'go', "
        "'acceleration': 20, 'jerk': 400, 'moves': [{'to': 1}]}], 'inputs': [{'joint': 'S', 'motion': '%s'}]}";
    char own[900];
    lw_spatial m;
    json_format(own, sizeof own, text, "0.1 + 2*profile(go)");
    CHECK_OK(lw_spatial_read(own, strlen(own), "f", &m, &check_error));
    CHECK_NEAR(m.profile[0].end, 0.5, 1e-12, 0);
    for (double t = -0.1; t < 0.7; t += 0.05)
        CHECK_NEAR(lw_expression_value(m.input[0].motion, &t), 0.1 + 2*lw_moves_at(&m.profile[0], t).x, 1e-15, 0);
    lw_spatial_free(&m);
    json_format(own, sizeof own, text, "profile(gone)");
    CHECK_FAILS(lw_spatial_read(own, strlen(own), "f", &m, &check_error), LW_E_NOTATION, "gone");
}

typedef struct end { lw_dynamics *d; double x, v; } end;

static lw_status last_input(void *context, const lw_moment *moment)
{
    end *to = context;
    lw_space_moment all;
    lw_status s = lw_dynamics_space_moment(to->d, moment, &all, NULL);
    to->x = all.input[0];
    to->v = all.input_rate[0];
    return s;
}

/* A cart in space under a force with steps of the jerk: the error follows the tolerance, so no step goes over a kink. */
TEST(runs_in_space_stop_at_kinks)
{
    static const char *const load[] = { "'forces': [{'link': 'cart', 'at': [0, 0, 0], 'fx': '2*profile(go, mod(t, 0.75))'}]",
                                        "'springs': [{'joint': 'S', 'law': '2*profile(go, mod(t, 0.75))'}]" };
    static const char text[] = "{%s, 'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], "
        "'joints': [{'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'cart'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}], 'profiles': [{'name': 'go', "
        "'speed': 3, 'acceleration': 20, 'jerk': 400, 'start': 0.05, 'moves': [{'to': 0.4, 'dwell': 0.03}, {'to': 0}]}], 'inputs': [{'joint': 'S', "
        "'speed': 0}]}";
    static const lw_formulation formulation[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_RADAU };
    char own[1500];
    lw_spatial m;
    double x, v;
    read_model("{'name': 'go', 'speed': 3, 'acceleration': 20, 'jerk': 400, 'start': 0.05, 'moves': [{'to': 0.4, 'dwell': 0.03}, "
               "{'to': 0}]}", "'input': {'joint': 'S', 'speed': 0}");
    exact_motion(2, &x, &v);
    for (int k = 0; k < 6; k++) {
        json_format(own, sizeof own, text, load[k%2]);
        CHECK_SILENT(lw_spatial_read(own, strlen(own), "f", &m, &check_error));
        for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-3) {
            lw_dynamics_options o = lw_dynamics_options_default();
            lw_dynamics_report r = { 0 };
            lw_rest rest;
            end to = { 0 };
            o.formulation = formulation[k/2];
            o.relative = o.absolute = tolerance;
            o.to = 2;
            CHECK_OK(lw_dynamics_make_spatial(&m, &o, &to.d, &check_error));
            CHECK_SILENT(lw_dynamics_analyse(to.d, last_input, &to, &r, &rest, &check_error));
            double off = k < 2 ? 1e-12 : 200*tolerance;      /* index1 follows a polynomial exactly */
            CHECK_NEAR(to.x, x, off, 0);
            CHECK_NEAR(to.v, v, off, 0);
            CHECK(k > 1 || r.steps < 60);
            lw_dynamics_free(to.d);
        }
        lw_spatial_free(&m);
    }
}
