/* tests/test_modes.c - eigenfrequencies with closed forms: pendula, chains, oscillators; rest; redundant rows. */
#include "tests/json_text.h"
#include "base/vec2.h"
#include "mbs/analysis/modes_fft.h"
#include "mbs/formulations/formulations.h"

static const double g = 9.81;

typedef struct scene { lw_model m; lw_system s; lw_forces f; double q[LW_SYSTEM_Q_MAX]; lw_modes modes; } scene;

/* A model from text; NULL when it cannot be read */
static scene *make(const char *format, ...) __attribute__((format(printf, 1, 2)));
static scene *make(const char *format, ...)
{
    static char text[1 << 16];
    va_list arg;
    va_start(arg, format);
    int n = vsnprintf(text, sizeof text, format, arg);
    va_end(arg);
    scene *s = calloc(1, sizeof *s);
    lw_error e = { 0 };
    lw_status st = lw_model_read(json_quotes(text), (size_t)n, "test", &s->m, &e);
    if (st == LW_OK)
        st = lw_forces_system(&s->m, false, &s->s, &e);
    if (st == LW_OK)
        st = lw_forces_make(&s->m, &s->s, NULL, &s->f, &e);
    if (st != LW_OK)
        fprintf(stderr, "%ld:%ld %s\n", e.line, e.column, e.text);
    CHECK_INT(st, LW_OK);
    lw_system_posture(&s->s, s->q);
    return s;
}

static lw_status find(scene *s, bool hold, bool rest)
{
    lw_modes_options o = { .hold_inputs = hold, .rest = rest };
    lw_error e = { 0 };
    lw_modes_free(&s->modes);
    lw_status st = lw_modes_find(&s->f, &o, 0.0, s->q, &s->modes, &e);
    if (st != LW_OK)
        CHECK(strlen(e.text) > 10);
    return st;
}

static void drop(scene *s)
{
    lw_modes_free(&s->modes);
    lw_forces_free(&s->f);
    lw_system_free(&s->s);
    lw_model_free(&s->m);
    free(s);
}

#define HEAD "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', "

/* ---- pendula ------------------------------------------------------------------------------------- */

/* w^2 = m g s/(I + m s^2); upside down it falls with that rate */
TEST(pendulum)
{
    for (int up = 0; up < 2; up++) {
        scene *s = make(HEAD "{'name': 'bob', 'mass': 2.5, 'centre': [%g, %g], 'inertia': 0.3}], 'joints': [{'name': 'A', 'links': ['ground', 'bob'], "
                        "'at': [1, 2]}], 'input': {'joint': 'A'}, 'tracers': [{'name': 'P', 'link': 'bob', 'at': [1, 1]}]}", 1.0, up ? 2.7 : 1.3);
        double w = sqrt(2.5*g*0.7/(0.3 + 2.5*0.49));
        CHECK_INT(find(s, false, false), LW_OK);
        CHECK_INT(s->modes.freedom, 1);
        CHECK_INT(s->modes.n_mode, 1);
        CHECK_NEAR(up ? s->modes.mode[0].re : s->modes.mode[0].im, w, 0, 1e-12);
        CHECK_NEAR(up ? s->modes.mode[0].im : s->modes.mode[0].re, 0, 0, 0);
        CHECK_NEAR(s->modes.mode[0].natural, w/(2*LW_PI), 0, 1e-12);
        CHECK_NEAR(s->modes.mode[0].damping, up ? -1 : 0, 0, 0);
        CHECK_NEAR(s->modes.unbalanced, 0, 1e-12, 0);
        CHECK(s->modes.conservative);
        CHECK_INT(find(s, true, false), LW_NOTHING);             /* held at its pin it has no freedom */
        drop(s);
    }
}

/* Two equal rods of length l, mass m at their ends: w^2 = (2 -+ sqrt 2) g/l; the second link turns +-sqrt 2 as far */
TEST(double_pendulum)
{
    scene *s = make(HEAD "{'name': 'a', 'mass': 3, 'centre': [0, -0.4]}, {'name': 'b', 'mass': 3, 'centre': [0, -0.8]}], 'joints': [{'name': 'A', "
                    "'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, -0.4]}]}");
    CHECK_INT(find(s, false, false), LW_OK);
    CHECK_INT(s->modes.n_mode, 2);
    for (int i = 0; i < 2; i++) {
        const lw_mode *m = &s->modes.mode[i];
        CHECK_NEAR(m->im*m->im, (2 + (i ? 1 : -1)*sqrt(2))*g/0.4, 0, 1e-12);
        CHECK_NEAR(m->shape[5]/m->shape[2], sqrt(2), 0, 1e-10);
        CHECK_NEAR(fabs(m->phase[5] - m->phase[2]), i ? LW_PI : 0, 1e-10, 0);
    }
    drop(s);
}

/* Laguerre polynomial of degree n and its slope */
static double laguerre(int n, double x, double *slope)
{
    double before = 1, now = 1 - x;
    for (int k = 1; k < n; k++) {
        double next = ((2*k + 1 - x)*now - k*before)/(k + 1);
        before = now;
        now = next;
    }
    *slope = n*(now - before)/x;
    return now;
}

/* n masses on a massless string of rods of length l: w^2 = (g/l) x with L_n(x) = 0 (Bernoulli) */
TEST(hanging_chains)
{
    for (int n = 2; n <= 20; n += 3) {
        char links[4096] = "", joints[4096] = "";
        for (int i = 1; i <= n; i++) {
            snprintf(links + strlen(links), 200, "%s{'name': 'l%d', 'mass': 0.7, 'centre': [0, %g]}",
                     i > 1 ? ", " : "",
                     i, -0.25*i);
            snprintf(joints + strlen(joints), 200, "%s{'name': 'j%d', 'links': ['%s%.0d', 'l%d'], 'at': [0, %g]}",
                     i > 1 ? ", " : "", i, i > 1 ? "l" : "ground", i - 1, i, -0.25*(i - 1));
        }
        scene *s = make(HEAD "%s], 'joints': [%s]}", links, joints);
        CHECK_INT(find(s, false, false), LW_OK);
        CHECK_INT(s->modes.n_mode, n);
        for (int i = 0; i < n && i < s->modes.n_mode; i++) {
            double w2 = pow(s->modes.mode[i].im, 2), x = w2*0.25/g, slope, left = laguerre(n, x, &slope);
            CHECK_NEAR(left/slope/x, 0, 1e-10, 0);               /* distance to the nearest root, relative */
            CHECK(i == 0 || w2 > 1.01*pow(s->modes.mode[i - 1].im, 2));
        }
        drop(s);
    }
}

/* ---- springs ------------------------------------------------------------------------------------- */

/* n masses of 2 kg on springs of 5000 N/m in a row, between walls or free, dampers beside the springs */
static scene *row_of_masses(int n, bool free, double damping)
{
    char links[8192] = "", joints[8192] = "", springs[8192] = "";
    for (int i = 1; i <= n; i++) {
        snprintf(links + strlen(links), 200, "%s{'name': 'l%d', 'mass': 2, 'centre': [%d, 0], 'inertia': 1}",
                 i > 1 ? ", " : "", i, i);
        snprintf(joints + strlen(joints), 200, "%s{'name': 'j%d', 'kind': 't', 'links': ['ground', 'l%d'], 'at': [%d, 0], 'along': [1, "
        "0]}", i > 1 ? ", " : "", i, i, i);
    }
    for (int i = free; i <= n - free; i++)
        snprintf(springs + strlen(springs), 200, "%s{'links': ['%s%.0d', '%s%.0d'], 'at': [[%d, 0], [%d, 0]], "
                 "'stiffness': 5000, 'damping': %.17g}", i > free ? ", " : "", i ? "l" : "ground", i,
                 i < n ? "l" : "ground", i < n ? i + 1 : 0, i, i + 1, damping);
    return make(HEAD "%s], 'joints': [%s], 'springs': [%s]}", links, joints, springs);
}

/* Half the wave of mode k (from 0) in a row: w = 2 sqrt(K/m) sin of it; free at both ends the first is a rigid
 * motion */
static double half_wave(int n, bool free, int k)
{
    return free ? k*LW_PI/(2*n) : (k + 1)*LW_PI/(2*(n + 1));
}

TEST(chains_of_springs)
{
    for (int n = 2; n <= 30; n += n < 6 ? 1 : 8)
        for (int free = 0; free < 2; free++) {
            scene *s = row_of_masses(n, free, 0);
            CHECK_INT(find(s, false, false), LW_OK);
            CHECK_INT(s->modes.n_mode, n);
            for (int k = 0; k < n; k++) {
                double w = 2*sqrt(2500)*sin(half_wave(n, free, k));
                CHECK_NEAR(s->modes.mode[k].im, w, 0, 1e-11);
                CHECK_NEAR(s->modes.mode[k].re, 0, 0, 0);
            }
            drop(s);
        }
}

static int by_size_of(const void *a, const void *b)
{
    double x = fabs(*(const double *)a), y = fabs(*(const double *)b);
    return (x > y) - (x < y);
}

/* Dampers in proportion to the springs: s^2 + (c/m) l s + (K/m) l = 0, l = 4 sin^2.  c makes one mode critical: its
 * root is double, to all digits, as is the 0 of a free row. */
TEST(damped_chains)
{
    for (int n = 2; n <= 30; n += n < 6 ? 1 : 8)
        for (int free = 0; free < 2; free++) {
            int critical = n/2, count = 0;
            double l = 4*pow(sin(half_wave(n, free, critical)), 2), c = 2*sqrt(5000*2/l), want[80];
            scene *s = row_of_masses(n, free, c);
            CHECK_INT(find(s, false, false), LW_OK);
            for (int k = 0; k < n; k++) {
                double lk = 4*pow(sin(half_wave(n, free, k)), 2), b = 0.5*c*lk/2, w2 = 2500*lk;
                double root = k < critical ? 0 : k > critical ? sqrt(b*b - w2) : 0;
                want[count++] = k < critical ? -sqrt(w2) : -(b + root);
                if (k >= critical)
                    want[count++] = -w2/(b + root);
            }
            CHECK_INT(s->modes.n_mode, count);
            qsort(want, (size_t)count, sizeof *want, by_size_of);
            for (int i = 0; i < count && i < s->modes.n_mode; i++) {
                const lw_mode *m = &s->modes.mode[i];
                CHECK_NEAR(hypot(m->re, m->im), fabs(want[i]), 0, 1e-10);
                CHECK(m->re <= 0);
                CHECK(want[i] != 0 || (m->re == 0 && m->im == 0));
                CHECK(fabs(fabs(want[i]) - sqrt(2500*l)) > 1e-9*sqrt(2500*l) || (m->im == 0 && m->damping == 1));
            }
            drop(s);
        }
}

/* n equal pendula side by side: one eigenvalue n times, with n shapes that differ; upside down it is real */
TEST(repeated)
{
    for (int up = 0; up < 2; up++)
        for (int n = 2; n <= 12; n += 5) {
            char links[4096] = "", joints[4096] = "";
            for (int i = 0; i < n; i++) {
                snprintf(links + strlen(links), 200, "%s{'name': 'p%d', 'mass': 3, 'centre': [%d, %g], 'inertia': 0.1}",
                         i ? ", " : "", i, i, up ? 0.7 : -0.7);
                snprintf(joints + strlen(joints), 200, "%s{'name': 'j%d', 'links': ['ground', 'p%d'], 'at': [%d, 0]}",
                         i ? ", " : "", i, i, i);
            }
            scene *s = make(HEAD "%s], 'joints': [%s]}", links, joints);
            CHECK_INT(find(s, false, false), LW_OK);
            CHECK_INT(s->modes.n_mode, n);
            double rate = sqrt(3*g*0.7/(0.1 + 3*0.49));
            for (int k = 0; k < n; k++) {
                CHECK_NEAR(s->modes.mode[k].im, up ? 0 : rate, 0, 1e-13);
                CHECK_NEAR(s->modes.mode[k].re, up ? rate : 0, 0, 1e-13);
                for (int j = 0; j < k; j++) {
                    double far = 0;
                    for (int i = 0; i < s->s.n_q; i++)
                        far = fmax(far, fabs(s->modes.mode[k].shape[i] - s->modes.mode[j].shape[i]));
                    CHECK(far > 0.1);
                }
            }
            drop(s);
        }
}

/* m x'' + c x' + k x = 0 below, at and above critical damping */
TEST(damping)
{
    const double m = 2, k = 800, w = 20;
    for (int i = 0; i < 5; i++) {
        double zeta = (double[]){ 0.01, 0.5, 0.999, 1.5, 20 }[i];
        scene *s = make(HEAD "{'name': 'm', 'mass': %g, 'centre': [0, 0]}], 'joints': [{'name': 'A', 'kind': 't', 'links': ['ground', 'm'], 'at': [0, 0], "
                        "'along': [0.6, 0.8]}], 'springs': [{'joint': 'A', 'stiffness': %g, 'damping': %.17g}]}", m, k, 2*zeta*m*w);
        CHECK_INT(find(s, false, true), LW_OK);
        CHECK(!s->modes.conservative);
        CHECK_INT(s->modes.n_mode, zeta < 1 ? 1 : 2);
        if (zeta < 1) {
            CHECK_NEAR(s->modes.mode[0].re, -zeta*w, 0, 1e-11);
            CHECK_NEAR(s->modes.mode[0].im, w*sqrt(1 - zeta*zeta), 0, 1e-10);
            CHECK_NEAR(s->modes.mode[0].damping, zeta, 0, 1e-11);
            CHECK_NEAR(s->modes.mode[0].natural, w/(2*LW_PI), 0, 1e-11);
        } else {
            double root = sqrt(zeta*zeta - 1);
            CHECK_NEAR(s->modes.mode[0].re, -w/(zeta + root), 0, 1e-9);
            CHECK_NEAR(s->modes.mode[1].re, -w*(zeta + root), 0, 1e-11);
        }
        /* it rests where weight and spring are in balance: 0.8 m g/k along the slide */
        double unit = s->s.unit;
        CHECK_NEAR(hypot(s->q[0], s->q[1])*unit, 0.8*m*g/k, 1e-13, 0);
        CHECK_NEAR(s->modes.unbalanced, 0, 1e-12, 0);
        drop(s);
    }
}

/* A damped double oscillator: shapes have phases; eigenvalues satisfy det(M s^2 + C s + K) = 0 */
TEST(phases)
{
    scene *s = make(HEAD "{'name': 'a', 'mass': 1, 'centre': [0, 0]}, {'name': 'b', 'mass': 3, 'centre': [1, 0]}], 'joints': [{'name': 'A', 'kind': 't', "
                    "'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0]}, {'name': 'B', 'kind': 't', 'links': ['a', 'b'], 'at': [1, 0], 'along': [1, "
                    "0]}], 'springs': [{'joint': 'A', 'stiffness': 100}, {'joint': 'B', 'stiffness': 60, 'damping': 4}]}");
    CHECK_INT(find(s, false, false), LW_OK);
    CHECK_INT(s->modes.n_mode, 2);
    for (int i = 0; i < s->modes.n_mode; i++) {
        const lw_mode *m = &s->modes.mode[i];
        double a = m->re, b = m->im, s2r = a*a - b*b, s2i = 2*a*b;
        double p_re = 60 + 4*a, p_im = 4*b;                      /* spring and damper between the two */
        double d1r = s2r + 100 + p_re, d1i = s2i + p_im, d2r = 3*s2r + p_re, d2i = 3*s2i + p_im;
        double re = d1r*d2r - d1i*d2i - (p_re*p_re - p_im*p_im), im = d1r*d2i + d1i*d2r - 2*p_re*p_im;
        CHECK_NEAR(hypot(re, im), 0, 1e-8, 0);
        CHECK(m->re < 0);
        CHECK(fabs(m->phase[0]) + fabs(m->phase[3]) > 0.01);
        /* x_b/x_a = p/(3 s^2 + p) */
        double size = hypot(p_re, p_im)/hypot(d2r, d2i);
        CHECK_NEAR(m->shape[3]/m->shape[0], size, 0, 1e-9);
        CHECK_NEAR(remainder(m->phase[3] - m->phase[0] - (atan2(p_im, p_re) - atan2(d2i, d2r)), 2*LW_PI), 0, 1e-9, 0);
    }
    drop(s);
}

/* ---- closed loops -------------------------------------------------------------------------------- */

/* A platform on three parallel massless rods of length l, one of them redundant: w^2 = g/l */
TEST(redundant_swing)
{
    scene *s = make(HEAD "{'name': 'a', 'mass': 0, 'centre': [0, 0]}, {'name': 'b', 'mass': 0, 'centre': [0, 0]}, {'name': 'c', 'mass': 0, 'centre': [0, "
                    "0]}, {'name': 'd', 'mass': 4, 'centre': [1.3, -2], 'inertia': 2}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, "
                    "{'name': 'B', 'links': ['ground', 'b'], 'at': [1, 0]}, {'name': 'C', 'links': ['ground', 'c'], 'at': [3, 0]}, {'name': 'D', 'links': "
                    "['a', 'd'], 'at': [0, -1.5]}, {'name': 'E', 'links': ['b', 'd'], 'at': [1, -1.5]}, {'name': 'F', 'links': ['c', 'd'], 'at': [3, "
                    "-1.5]}], 'input': {'joint': 'A'}}");
    CHECK_INT(find(s, false, false), LW_OK);
    CHECK_INT(s->modes.redundant, 1);
    CHECK_INT(s->modes.n_mode, 1);
    CHECK_NEAR(pow(s->modes.mode[0].im, 2), g/1.5, 0, 1e-11);
    drop(s);
}

/* Slider-crank with a spring at its slide, relaxed in the drawn posture: w^2 = K x'^2/I, I the masses reduced to
 * the crank */
TEST(slider_crank)
{
    const double r = 0.3, l = 0.8, k = 500;
    for (double t = 0.2; t < 3; t += 0.35) {
        double b = asin(r*sin(t)/l), db = r*cos(t)/(l*cos(b)), x = r*cos(t) + l*cos(b), dx = -r*sin(t) - l*sin(b)*db;
        double dcx = 0.5*(dx - r*sin(t)), dcy = 0.5*r*cos(t);
        double inertia = 0.05 + 1.3*0.16*r*r + 0.7*(dcx*dcx + dcy*dcy) + 0.02*db*db + 1.9*dx*dx;
        scene *s = make("{'linkwright': 1, 'links': ['ground', {'name': 'c', 'mass': 1.3, 'centre': [%.17g, %.17g], 'inertia': 0.05}, {'name': 'k', "
        "'mass': 0.7, 'centre': [%.17g, %.17g], 'inertia': 0.02}, {'name': 's', 'mass': 1.9, 'centre': [%.17g, 0]}], 'joints': [{'name': 'O', 'links': "
        "['ground', 'c'], 'at': [0, 0]}, {'name': 'A', 'links': ['c', 'k'], 'at': [%.17g, %.17g]}, {'name': 'B', 'links': ['k', 's'], 'at': [%.17g, 0]}, "
        "{'name': 'P', 'kind': 't', 'links': ['ground', 's'], 'at': [%.17g, 0], 'along': [1, 0]}], 'springs': [{'joint': 'P', 'stiffness': "
        "%g}]}", 0.4*r*cos(t), 0.4*r*sin(t),
            0.5*(r*cos(t) + x), 0.5*r*sin(t), x, r*cos(t), r*sin(t), x, x, k);
        CHECK_INT(find(s, false, false), LW_OK);
        CHECK_INT(s->modes.n_mode, 1);
        CHECK_NEAR(s->modes.mode[0].im, sqrt(k*dx*dx/inertia), 0, 1e-11);
        CHECK_NEAR(s->modes.unbalanced, 0, 1e-12, 0);
        drop(s);
    }
}

/* A pair of wheels, the second turning z times as fast, a torsion spring at the first: w^2 = K/(I1 + z^2 I2) */
TEST(geared_wheels)
{
    scene *s = make("{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 0.4}, {'name': 'b', 'mass': 3, 'centre': "
    "[3.5, 0], 'inertia': 5}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['ground', 'b'], 'at': [3.5, 0]}, "
    "{'name': 'G', 'kind': 'g', 'links': ['a', 'b'], 'at': [1, 0], 'ratio': -2.5}], 'springs': [{'joint': 'A', 'stiffness': 9}]}");
    CHECK_INT(find(s, false, false), LW_OK);
    CHECK_INT(s->modes.n_mode, 1);
    CHECK_NEAR(s->modes.mode[0].im, sqrt(9/(0.4 + 5*6.25)), 0, 1e-12);
    drop(s);
}

/* A four-bar with a spring at its input goes to rest; its frequency there is that of V''/M along the input, by
 * differences of the potential and of the places */
TEST(four_bar_at_rest)
{
    scene *s = make(HEAD "{'name': 'crank', 'mass': 1, 'centre': [0, 0.5], 'inertia': 0.1}, {'name': 'coupler', 'mass': 2, 'centre': [1.5, 1.4], "
                    "'inertia': 0.5}, {'name': 'rocker', 'mass': 1.5, 'centre': [3, 1], 'inertia': 0.4}], 'joints': [{'name': 'O', 'links': ['ground', "
                    "'crank'], 'at': [0, 0]}, {'name': 'A', 'links': ['crank', 'coupler'], 'at': [0, 1]}, {'name': 'B', 'links': ['coupler', 'rocker'], "
                    "'at': [3, 2]}, {'name': 'C', 'links': ['ground', 'rocker'], 'at': [3, 0]}], 'input': {'joint': 'O'}, 'springs': [{'joint': 'O', "
                    "'stiffness': 40}, {'links': ['ground', 'rocker'], 'at': [[4, 0], [3, 1.5]], 'stiffness': 30, 'free': 1}]}");
    CHECK_INT(find(s, false, true), LW_OK);
    CHECK_INT(s->modes.n_mode, 1);
    CHECK_NEAR(s->modes.unbalanced, 0, 1e-12, 0);
    double rest[LW_SYSTEM_Q_MAX], q[3][LW_SYSTEM_Q_MAX], v[3], h = 1e-4, mass = 0;
    memcpy(rest, s->q, sizeof rest);
    lw_modes_options held = { .hold_inputs = true };
    for (int i = 0; i < 3; i++) {
        /* hold the input h further: turn the crank and let the rest close */
        memcpy(s->q, rest, sizeof rest);
        s->q[2] += (i - 1)*h;
        double want = s->q[2];
        for (int round = 0; round < 50; round++) {               /* the projection moves the crank too: push it back */
            lw_modes_free(&s->modes);
            lw_modes_find(&s->f, &held, 0.0, s->q, &s->modes, NULL);
            if (fabs(s->q[2] - want) < 1e-15)
                break;
            s->q[2] = want;
        }
        memcpy(q[i], s->q, sizeof rest);
        v[i] = lw_forces_potential(&s->f, s->q);
    }
    for (int i = 0; i < s->s.n_q; i++)
        mass += s->f.mass[i]*pow((q[2][i] - q[0][i])/(2*h), 2);
    memcpy(s->q, rest, sizeof rest);
    CHECK_INT(find(s, false, false), LW_OK);
    CHECK_NEAR(pow(s->modes.mode[0].im, 2), (v[2] - 2*v[1] + v[0])/(h*h)/mass, 0, 1e-5);
    CHECK_NEAR((v[2] - v[0])/(2*h), 0, 1e-5, 0);                 /* it is at rest */
    drop(s);
}

/* From the side, and from just beside the upper rest point, a pendulum goes down; springs hold it elsewhere */
TEST(finds_rest)
{
    for (int i = 0; i < 4; i++) {
        double angle = (double[]){ 1.2, 3.0, -2.0, LW_PI - 1e-6 }[i];
        scene *s = make(HEAD "{'name': 'bob', 'mass': 2, 'centre': [%.17g, %.17g], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'bob'], "
                        "'at': [0, 0]}]}", sin(angle), -cos(angle));
        CHECK_INT(find(s, false, false), LW_OK);
        CHECK(s->modes.unbalanced > 1e-7);
        CHECK_INT(find(s, false, true), LW_OK);
        CHECK_NEAR(remainder(s->q[2] + angle, 2*LW_PI), 0, 1e-12, 0);
        CHECK_NEAR(s->modes.mode[0].im, sqrt(2*g/2.1), 0, 1e-12);
        CHECK_NEAR(s->modes.unbalanced, 0, 1e-12, 0);
        drop(s);
    }
    scene *s = make("{'linkwright': 1, 'links': ['ground', {'name': 'm', 'mass': 1, 'centre': [0, 0]}], 'joints': [{'name': 'A', 'kind': 't', 'links': "
                    "['ground', 'm'], 'at': [0, 0], 'along': [1, 0]}], 'forces': [{'link': 'm', 'at': [0, 0], 'fx': 5}]}");
    CHECK_INT(find(s, false, true), LW_E_NUMERIC);               /* driven away for ever */
    drop(s);
}

/* ---- by ear -------------------------------------------------------------------------------------- */

static lw_status listen(scene *s, bool hold, double *peak)
{
    lw_dynamics *d = NULL;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    o.hold_inputs = hold;
    CHECK_INT(lw_dynamics_make(&s->m, &o, &d, NULL), LW_OK);
    lw_status st = lw_modes_from_spectra(d, s->q, &s->modes, peak, NULL);
    lw_dynamics_free(d);
    return st;
}

/* Peaks of a free vibration of the full equations agree with the eigenfrequencies to 0.5 % (and much better) */
TEST(frequencies_from_spectra)
{
    static const char *const model[] = {
        HEAD "{'name': 'a', 'mass': 3, 'centre': [0, -0.4]}, {'name': 'b', 'mass': 3, 'centre': [0, -0.8], 'inertia': 0.01}], 'joints': [{'name': 'A', "
        "'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, -0.4]}]}",
        /* damped, and a loop with springs */
        HEAD "{'name': 'crank', 'mass': 1, 'centre': [0, 0.5], 'inertia': 0.1}, {'name': 'coupler', 'mass': 2, 'centre': [1.5, 1.4], 'inertia': 0.5}, "
        "{'name': 'rocker', 'mass': 1.5, 'centre': [3, 1], 'inertia': 0.4}, {'name': 'bob', 'mass': 0.4, 'centre': [2, 0.7], 'inertia': 0.02}], 'joints': "
        "[{'name': 'O', 'links': ['ground', 'crank'], 'at': [0, 0]}, {'name': 'A', 'links': ['crank', 'coupler'], 'at': [0, 1]}, {'name': 'B', 'links': "
        "['coupler', 'rocker'], 'at': [3, 2]}, {'name': 'C', 'links': ['ground', 'rocker'], 'at': [3, 0]}, {'name': 'D', 'links': ['coupler', 'bob'], "
        "'at': [2, 1.6]}], 'input': {'joint': 'O'}, 'springs': [{'joint': 'O', 'stiffness': 400, 'damping': 0.5}]}" };
    for (int i = 0; i < 2; i++) {
        scene *s = make("%s", model[i]);
        double peak[2*LW_SYSTEM_Q_MAX];
        CHECK_INT(find(s, false, true), LW_OK);
        CHECK_INT(s->modes.n_mode, 2);
        CHECK_INT(s->modes.conservative, i == 0);
        CHECK_INT(listen(s, false, peak), LW_OK);
        for (int k = 0; k < s->modes.n_mode; k++)
            CHECK_NEAR(peak[k], s->modes.mode[k].frequency, 0, 5e-5);
        /* the same with the input held: one mode fewer in the loop */
        if (i == 1) {
            CHECK_INT(find(s, true, false), LW_OK);
            CHECK_INT(s->modes.n_mode, 1);
            CHECK_INT(listen(s, true, peak), LW_OK);
            CHECK_NEAR(peak[0], s->modes.mode[0].frequency, 0, 5e-5);
        }
        drop(s);
    }
    scene *s = make(HEAD "{'name': 'm', 'mass': 1, 'centre': [0, 0], 'inertia': 1}], 'joints': [{'name': 'A', 'kind': 't', 'links': ['ground', 'm'], "
                    "'at': [0, 0], 'along': [1, 0]}]}");
    double peak[2*LW_SYSTEM_Q_MAX];
    CHECK_INT(find(s, false, false), LW_OK);
    CHECK_INT(listen(s, false, peak), LW_NOTHING);
    CHECK(isnan(peak[0]));
    drop(s);
}

TEST(refused)
{
    scene *s = make(HEAD "{'name': 'a', 'mass': 1, 'centre': [0, -1]}, {'name': 'feather', 'mass': 0, 'centre': [0, 0]}], 'joints': [{'name': 'A', "
                    "'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'feather'], 'at': [0, -1]}]}");
    lw_modes_options o = { 0 };
    CHECK_FAILS(lw_modes_find(&s->f, &o, 0, s->q, &s->modes, &check_error), LW_E_ARG, "\"feather\"");
    s->q[0] += 1e6;
    s->q[4] = NAN;
    lw_modes_free(&s->modes);
    CHECK(lw_modes_find(&s->f, &o, 0, s->q, &s->modes, &check_error) != LW_OK);
    drop(s);
}
