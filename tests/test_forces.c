/* Loads of random models: derivatives against differences, potential and power against the forces. */
#include "mbs/equations/forces.h"
#include "tests/dynamics_run.h"

static lw_model model;
static lw_system sys;
static lw_forces forces;

/* A slider, a crank on it, a link on a pin, a slot: every load between them, random numbers. */
static const char format[] =
    "{'linkwright': 1, 'units': {'length': 'm', 'angle': 'rad'}, 'links': ['ground',{'name': 'cart', 'mass': %g, 'centre': [0.2, 0.1], 'inertia': 0.3},"
    "{'name': 'arm', 'mass': 1.5, 'centre': [1, %g], 'inertia': 0.2},{'name': 'bob', 'mass': 0.7, 'centre': [2, 0.4]}],'joints': [{'name': 'S', 'kind': "
    "'t', 'links': ['ground', 'cart'], 'at': [0, 0], 'along': [0.8, 0.6]%s},{'name': 'A', 'links': ['cart', 'arm'], 'at': [0.5, 0.2]%s},{'name': 'B', "
    "'kind': 't', 'links': ['arm', 'bob'], 'at': [1.7, 0.3], 'along': [0.6, -0.8]}],'gravity': [0.4, -9.81],'springs': [{'links': ['ground', 'bob'], "
    "'at': [[-0.3, 1], [2.1, 0.6]], 'stiffness': 70, 'free': 0.8%s},{'links': ['cart', 'bob'], 'at': [[0.1, 0.3], [1.9, 0]], 'stiffness': 30},{'joint': "
    "'A', 'stiffness': 12, 'free': 0.3},{'joint': 'B', 'stiffness': 40}%s], %s'tracers': [{'name': 'P', 'link': 'bob', 'at': [2.4, 0.1]}, {'name': 'Q', "
    "'link': 'arm', 'at': [0.9, 0.8]}]}";

static const char laws[] =
    ", {'links': ['arm', 'ground'], 'at': [[1.1, 0.4], [0, -2]],'law': '30*(length - 1)^3 + 2*rate + rate*length + t'},{'joint': 'B', 'law': "
    "'-5*displacement^3 - rate*abs(rate) + sin(t)'},{'joint': 'S', 'law': '-3*rate*displacement^2'}";
static const char more[] =
    "'dampers': [{'links': ['cart', 'arm'], 'at': [[-1, 0.2], [1.6, 0.4]], 'damping': 4},{'joint': 'S', 'damping': 2.5}],'motors': [{'joint': 'A', "
    "'stall': 6, 'free_speed': 9}, {'joint': 'S', 'stall': -6, 'free_speed': -3}],'forces': [{'link': 'bob', 'at': [2.2, 0.3], 'frame': 'link', 'fx': "
    "'3*sin(2*t) - x(P)*vy(Q)','fy': 'q(A)*v(B)'},{'link': 'arm', 'at': [0.6, 1.2], 'fx': 'vx(P)^2 - y(Q)', 'fy': 'omega(bob)*angle(arm)','torque': 'v(S) "
    "- q(B)^2'},{'link': 'cart', 'at': [0.6, 0.2], 'frame': 'link', 'fy': '-vx(Q)*5'}],";

static double one(lw_rng *r) { return lw_rng_range(r, -1, 1); }

/* The model, without or with loads that have no potential. */
static void make(lw_rng *r, bool all)
{
    static const char soft[] = ", 'stop': {'least': -0.2, 'greatest': 0.3, 'stiffness': 400%s}";
    char text[6000], stops[2][100];
    lw_error e = { 0 };
    for (int i = 0; i < 2; i++)
        snprintf(stops[i], sizeof stops[i], soft, all ? ", 'damping': 7" : "");
    json_format(text, sizeof text, format, 1 + 0.5*one(r), one(r), stops[0], stops[1], all ? ", 'damping': 3" : "",
                all ? laws : "", all ? more : "");
    lw_status s = lw_model_read(text, strlen(text), "text", &model, &e);
    CHECK_TEXT(e.text, "");
    CHECK_INT(s, LW_OK);
    CHECK_INT(lw_forces_system(&model, false, &sys, &e), LW_OK);
    CHECK_INT(lw_forces_make(&model, &sys, NULL, &forces, &e), LW_OK);
    CHECK_INT(forces.conservative, !all);
}

static void state(lw_rng *r, double *q, double *v)
{
    lw_system_posture(&sys, q);
    for (int i = 0; i < sys.n_q; i++) {
        q[i] += 0.5*one(r);
        v[i] = 3*one(r);
    }
}

/* Differences of a smooth function of one coordinate: of order 4; false beside a kink, where two orders disagree;
 * *worst: by how much. */
static bool difference(int i, bool of_q, double *q, double *v, double t, double *out, double *worst)
{
    double f[5][LW_SYSTEM_Q_MAX], *x = of_q ? q + i : v + i, keep = *x, size = 1;
    *worst = 0;
    static const double at[] = { -2, -1, 1, 2 };
    const double h = 1e-4;
    for (int k = 0; k < 4; k++) {
        *x = keep + at[k]*h;
        lw_forces_apply(&forces, t, q, v, f[k], NULL, NULL, NULL);
    }
    *x = keep;
    for (int k = 0; k < sys.n_q; k++) {
        out[k] = (8*(f[2][k] - f[1][k]) - (f[3][k] - f[0][k]))/(12*h);
        *worst = fmax(*worst, fabs(out[k] - (f[3][k] - f[0][k])/(4*h)));
        size = fmax(size, fabs(out[k]));
    }
    return *worst < 1e-5*size;
}

TEST(derivatives)
{
    lw_rng r = check_rng(0);
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX], f[LW_SYSTEM_Q_MAX], got[LW_SYSTEM_Q_MAX];
    double dq[LW_SYSTEM_Q_MAX*LW_SYSTEM_Q_MAX], dv[LW_SYSTEM_Q_MAX*LW_SYSTEM_Q_MAX];
    int n_seen = 0, n_left = 0;
    for (int round = 0; round < 200; round++) {
        make(&r, true);
        int n = sys.n_q;
        double t = one(&r);
        state(&r, q, v);
        lw_forces_apply(&forces, t, q, v, f, dq, dv, NULL);
        for (int j = 0; j < 2*n; j++) {
            const double *want = j < n ? dq : dv;
            double worst;
            if (!difference(j%n, j < n, q, v, t, got, &worst)) {
                n_left++;
                continue;
            }
            n_seen++;
            for (int i = 0; i < n; i++)
                CHECK_NEAR(want[i*n + j%n], got[i], 1e-6 + worst, 1e-6);
        }
        lw_forces_free(&forces);
        lw_system_free(&sys);
        lw_model_free(&model);
    }
    CHECK(n_seen > 20*n_left);
}

/* Forces with a potential are its slope; the others do work at the power reported. */
TEST(potential_and_power)
{
    lw_rng r = check_rng(1);
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX], f[LW_SYSTEM_Q_MAX], power;
    int n_seen = 0;
    for (int round = 0; round < 200; round++) {
        make(&r, round & 1);
        state(&r, q, v);
        lw_forces_apply(&forces, one(&r), q, v, f, NULL, NULL, &power);
        double work = 0, rise = 0, size = 1, kink = 0;
        for (int i = 0; i < sys.n_q; i++) {
            double keep = q[i], e[4], h = 1e-4;
            for (int k = 0; k < 4; k++) {
                q[i] = keep + h*(k < 2 ? k - 2 : k - 1);
                e[k] = lw_forces_potential(&forces, q);
            }
            q[i] = keep;
            double slope = (8*(e[2] - e[1]) - (e[3] - e[0]))/(12*h);
            double bent = fabs(slope - (e[3] - e[0])/(4*h));     /* where a stop begins within 2h, at least the error of the slope */
            bool smooth = bent < 1e-5*(1 + fabs(slope));
            if (!(round & 1) && smooth)
                CHECK_NEAR(-f[i], slope, 1e-7 + bent, 1e-7);
            kink += !smooth;
            work += f[i]*v[i];
            rise += slope*v[i];
            size += fabs(f[i]*v[i]);
        }
        n_seen += kink == 0;
        if (kink == 0)
            CHECK_NEAR(work + rise, power, 1e-7*size, 0);
        lw_forces_free(&forces);
        lw_system_free(&sys);
        lw_model_free(&model);
    }
    CHECK(n_seen > 150);
}
