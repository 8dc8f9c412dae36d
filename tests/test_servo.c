/* Servo axes against closed forms, published figures and independent computations. */
#include "base/vec2.h"
#include "mbs/drives/servo_linear.h"
#include "tests/json_text.h"

static lw_servo servo;
static lw_error e;

static lw_status read_text(const char *format)
{
    char text[4000];
    json_format(text, sizeof text, "%s", format);
    e = (lw_error){ 0 };
    return lw_servo_read(text, strlen(text), "text", &servo, &e);
}

static void read_servo(const char *parts)
{
    char text[4000];
    snprintf(text, sizeof text, "{'linkwright': 1, 'servo': {%s}}", parts);
    CHECK_INT(read_text(text), LW_OK);
    CHECK_TEXT(e.text, "");
}

static lw_servo_report run(double to, double tolerance)
{
    lw_servo_options o = lw_servo_options_default();
    lw_servo_report r;
    o.to = to;
    o.tolerance = tolerance;
    CHECK_INT(lw_servo_run(&servo, &o, NULL, NULL, &r, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    return r;
}

#define MOTOR "'motor': {'torque_constant': 1.6, 'inertia': 0.0011, 'resistance': 30, 'inductance': 0.0703}"
#define STILL "'motion': {'expression': '0'}"

/* Poles of speed over voltage of the motor of Makkonen 1999, table 4, alone and with 200 kg at its best radius. */
TEST(poles_of_a_motor)
{
    static const struct { const char *load; double pole[2]; } known[] = {
        { "'control': {'position': {'gain': 1}, 'speed': {'proportional': 1}, 'current': {'bandwidth': 1}}",
          { -101.91534671, -324.8271853 } },
        { "'transmission': {'radius': 0.0059700}, 'load': {'mass': 200}, "
          "'control': {'position': {'gain': 1}, 'speed': {'proportional': 1}, 'current': {'bandwidth': 1}}",
          { -10.6359496, -416.1065824 } },
    };
    for (int k = 0; k < 2; k++) {
        char text[1000];
        lw_state_matrices m;
        double re[16], im[16];
        int n;
        snprintf(text, sizeof text, MOTOR ", %s, " STILL, known[k].load);
        read_servo(text);
        lw_servo_plant(&servo, &m);
        CHECK_INT(lw_matrices_poles(&m, &n, re, im), LW_OK);
        CHECK_INT(n, 3);
        CHECK_NEAR(re[0], 0, 1e-9, 0);
        CHECK_NEAR(re[1], known[k].pole[0], 0, k ? 2e-5 : 1e-9);      /* the radius is printed with 3 digits */
        CHECK_NEAR(re[2], known[k].pole[1], 0, 1e-6);
        for (int i = 0; i < 3; i++)
            CHECK(im[i] == 0);
        lw_servo_free(&servo);
    }
}

#define RIGID "'motor': {'torque_constant': 1, 'inertia': 0.001, 'resistance': 0.5}, 'transmission': {'radius': 0.01}, " \
              "'load': {'mass': 10}, "
#define DOUBLE_S "'motion': {'speed': 3, 'acceleration': 20, 'jerk': 400, 'moves': [{'to': 1}]}"

/* Rigid axis, double S of 1 m, gain 20 1/s, speed controller 200 1/s and 1e4 1/s^2, ideal current; the figures are those
 * of the classical method of order 4 with steps of 0.1 ms. */
TEST(a_rigid_axis_follows)
{
    static const struct { double share, peak, settled; } known[] = { { 0, 0.14798496250, 0.71275080 },
                                                                         { 1, 0.00110453914, 0.41112516 } };
    for (int k = 0; k < 2; k++) {
        char text[1000];
        snprintf(text, sizeof text, RIGID "'control': {'position': {'gain': 20, 'speed_feed_forward': %g}, "
                 "'speed': {'proportional': 200, 'integral': 1e4}}, " DOUBLE_S, known[k].share);
        read_servo(text);
        lw_servo_report r = run(1.2, 1e-10);
        CHECK_NEAR(r.end, 0.533333333, 1e-9, 0);
        CHECK_NEAR(r.error_peak, known[k].peak, 5e-7, 0);
        CHECK_NEAR(r.settled, known[k].settled, 2e-6, 0);
        CHECK(fabs(r.energy_error) < 1e-8*r.electrical);
        lw_servo_free(&servo);
    }
}

/* Behind a ramp the position lags by v/gain. */
TEST(a_ramp_lags)
{
    read_servo(RIGID "'control': {'position': {'gain': 20}, 'speed': {'proportional': 200, 'integral': 1e4}}, 'motion': {'expression': '0.3*t'}");
    CHECK_NEAR(run(3, 1e-12).error_end, 0.3/20, 1e-9, 0);
    lw_servo_free(&servo);
    read_servo(MOTOR ", 'control': {'position': {'gain': 20, 'sample': 1e-3}, 'speed': {'proportional': 150, 'integral': 5e3, 'sample': 5e-4, 'delay': "
               "5e-4}, 'current': {'bandwidth': 3000, 'sample': 1e-4, 'delay': 1e-4, 'emf_compensation': true}}, 'motion': {'expression': '2*t'}");
    /* the samples lie between two of the position: the error is that of the sample, 2/20, on average half a period more */
    lw_servo_report r = run(3, 1e-10);
    CHECK_NEAR(r.error_end, 2.0/20, 1e-6, 0);
    CHECK(fabs(r.energy_error) < 1e-8*r.electrical);
    lw_servo_free(&servo);
}

#define ALL "'motor': {'torque_constant': 0.5, 'inertia': 0.0005, 'resistance': 1.2, 'inductance': 4e-3, 'coulomb': 0.02, " \
            "'viscous': 1e-4}, 'amplifier': {'voltage': 100, 'current': 12}, 'transmission': {'radius': 0.01, " \
            "'stiffness': 2e6, 'damping': 400, 'backlash': 2e-5}, 'load': {'mass': 20, 'coulomb': 20, 'breakaway': 30, " \
            "'stribeck': 0.02, 'viscous': 15, 'force': '-5*(t > 0)'}, 'encoder': {'steps': 4096, 'at': '%s'}, " \
            "'control': {'position': {'gain': 40, 'speed_feed_forward': 1, 'sample': 1e-3}, 'speed': {'proportional': 150, " \
            "'integral': 3000, 'sample': 2.5e-4, 'delay': 1e-4}, 'current': {'bandwidth': 4000, 'sample': 6.25e-5, " \
            "'delay': 3e-5}}, 'motion': {'speed': 1, 'acceleration': 8, 'jerk': 200, 'moves': [{'to': 0.2, 'dwell': 0.1}, " \
            "{'to': 0, 'law': '345', 'duration': 0.4}]}"

/* Everything at once keeps its energy, whatever the tolerance. */
TEST(everything_keeps_its_energy)
{
    char text[3000];
    double peak[2];
    for (int k = 0; k < 2; k++) {
        char *at, all[] = ALL;
        at = strstr(all, "*(t > 0)");
        memset(at, ' ', 8);
        snprintf(text, sizeof text, all, "motor");
        read_servo(text);
        lw_servo_report r = run(0, k ? 1e-11 : 1e-9);
        peak[k] = r.error_peak;
        CHECK(fabs(r.energy_error) < 1e-8*r.electrical);
        CHECK(r.friction > 0 && r.transmission > 0 && r.heat > 0 && r.work != 0);
        CHECK(r.error_peak < 2e-3 && fabs(r.error_end) < 2e-4 && r.current_peak <= 12 && r.voltage_peak <= 100);
        lw_servo_free(&servo);
    }
    CHECK_NEAR(peak[0], peak[1], 0, 0.02);               /* encoder steps make the motion sensitive */
}

/* Speed of a rigid axis: P + I over s^2, a known margin; a delay T costs w T of phase. */
TEST(margins_in_closed_form)
{
    read_servo(RIGID "'control': {'position': {'gain': 20}, 'speed': {'proportional': 200}}, " STILL);
    lw_servo_margin m = lw_servo_margin_of(&servo, LW_SERVO_SPEED);      /* 200/s */
    CHECK_NEAR(m.crossover, 200, 1e-6, 0);
    CHECK_NEAR(m.phase, LW_PI/2, 1e-9, 0);
    CHECK(isnan(m.reversal));
    m = lw_servo_margin_of(&servo, LW_SERVO_POSITION);                   /* 20*200/(s (s + 200)) */
    double w2 = 0.5*(-4e4 + sqrt(1.6e9 + 4*1.6e7)), w = sqrt(w2);
    CHECK_NEAR(m.crossover, w, 1e-6, 0);
    CHECK_NEAR(m.phase, LW_PI/2 - atan(w/200), 1e-9, 0);
    lw_servo_free(&servo);
    read_servo(RIGID "'control': {'position': {'gain': 20, 'sample': 1e-3, 'delay': 1e-3}, 'speed': {'proportional': 200, "
               "'sample': 1e-3, 'delay': 5e-4}}, " STILL);
    m = lw_servo_margin_of(&servo, LW_SERVO_SPEED);
    CHECK_NEAR(m.phase, LW_PI/2 - m.crossover*(0.5e-3 + 0.5e-3), 1e-9, 0);
    CHECK_NEAR(m.reversal, LW_PI/2/1e-3, 1e-3, 0);
    lw_servo_free(&servo);
}

static double greatest_pole(double *im)
{
    lw_state_matrices m;
    double re[16], i[16];
    int n = 0;
    CHECK_INT(lw_servo_closed(&servo, &m, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    CHECK_INT(lw_matrices_poles(&m, &n, re, i), LW_OK);
    *im = fabs(i[0]);
    return n ? re[0] : NAN;
}

/* Poles of the whole: of an ideal axis those of a polynomial; sampled, those of the map from sample to sample. */
TEST(poles_of_the_whole)
{
    double im;
    read_servo(RIGID "'control': {'position': {'gain': 20}, 'speed': {'proportional': 200}}, " STILL);
    CHECK_NEAR(greatest_pole(&im), -100 + sqrt(1e4 - 4000), 1e-9, 0);
    lw_servo_free(&servo);
    /* v+ = v + T a, x+ = x + T v + T^2/2 a, a = 200 (20 (-x) - v), all sampled at T */
    read_servo(RIGID "'control': {'position': {'gain': 20, 'sample': 2e-3}, 'speed': {'proportional': 200, 'sample': 2e-3}}, "
               STILL);
    double T = 2e-3, k = 200, b = 20, trace = 2 - k*T - b*k*T*T/2, det = (1 - b*k*T*T/2)*(1 - k*T) + b*k*T*(T - k*T*T/2);
    double z = 0.5*(trace + sqrt(trace*trace - 4*det));
    CHECK_NEAR(greatest_pole(&im), log(z)/T, 1e-7, 0);
    lw_servo_free(&servo);
    /* gains beyond the margin: the pole on the right side, and the run that grows as it says */
    read_servo(RIGID "'control': {'position': {'gain': 20, 'sample': 1e-3}, 'speed': {'proportional': 2200, 'sample': 1e-3}}, "
               "'motion': {'expression': '1e-6*t^2'}");
    double growth = greatest_pole(&im);
    CHECK(growth > 0);
    lw_servo_report r = run(0.1, 1e-9), s = run(0.15, 1e-9);
    CHECK_NEAR(log(s.error_peak/r.error_peak)/0.05, growth, 0, 0.05);
    lw_servo_free(&servo);
    read_servo(RIGID "'control': {'position': {'gain': 20, 'sample': 1e-3}, 'speed': {'proportional': 100, 'sample': 3e-4}}, "
               STILL);
    lw_state_matrices m;
    CHECK_INT(lw_servo_closed(&servo, &m, &e), LW_E_KIND);
    CHECK_HAS(e.text, "no multiple");
    lw_servo_free(&servo);
}

/* The matrices of the whole give the run: a step of the wanted position, by summing sampled equations. */
TEST(matrices_give_the_run)
{
    read_servo(MOTOR ", 'transmission': {'ratio': 5, 'stiffness': 3e3, 'damping': 1}, 'load': {'inertia': 0.02}, 'encoder': {'steps': 1e9}, 'control': "
               "{'position': {'gain': 10, 'sample': 1e-3}, 'speed': {'proportional': 60, 'integral': 500, 'sample': 5e-4, 'delay': 5e-4}, 'current': "
               "{'bandwidth': 2000, 'sample': 1e-4, 'delay': 1e-4}}, 'motion': {'expression': '0.1'}");
    lw_state_matrices m;
    double x[16] = { 0 }, y[16];
    CHECK_INT(lw_servo_closed(&servo, &m, &e), LW_OK);
    for (int k = 0; k < 200; k++) {
        for (int i = 0; i < m.n_state; i++) {
            y[i] = m.b[i*4]*0.01;                          /* from 0.1 to 0.11: the run begins at rest at 0.1 */
            for (int j = 0; j < m.n_state; j++)
                y[i] += m.a[i*m.n_state + j]*x[j];
        }
        memcpy(x, y, sizeof x);
    }
    double position = 0;
    for (int j = 0; j < m.n_state; j++)
        position += m.c[j]*x[j];
    lw_servo_free(&servo);
    read_servo(MOTOR ", 'transmission': {'ratio': 5, 'stiffness': 3e3, 'damping': 1}, 'load': {'inertia': 0.02}, 'encoder': {'steps': 1e9}, 'control': "
               "{'position': {'gain': 10, 'sample': 1e-3}, 'speed': {'proportional': 60, 'integral': 500, 'sample': 5e-4, 'delay': 5e-4}, 'current': "
               "{'bandwidth': 2000, 'sample': 1e-4, 'delay': 1e-4}}, 'motion': {'expression': '0.01*step(t, -1, 0, 1e-9, 1)'}");
    /* the run starts at the wanted position at t = 0: a step right behind it */
    lw_servo_report r = run(0.2, 1e-10);
    CHECK(r.steps > 0);
    lw_servo_free(&servo);
    CHECK_NEAR(position, 0.01, 5e-3, 0);
}

/* The same through the library's own functions. */
TEST(the_library_runs_files)
{
    lw_servo *p = NULL;
    lw_servo_options o = lw_servo_options_default();
    lw_servo_report r;
    double re[16], im[16];
    int n;
    CHECK_INT(lw_servo_load("examples/drives/servo-axis.json", &p, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    if (!p)
        return;
    CHECK_INT(lw_servo_run(p, &o, NULL, NULL, &r, &e), LW_OK);
    CHECK(r.error_peak < 2e-3 && r.settled < r.end && fabs(r.energy_error) < 1e-8*r.electrical);
    CHECK_INT(lw_servo_poles(p, &n, re, im, &e), LW_OK);
    CHECK(n > 5 && re[0] < 0);
    lw_servo_destroy(p);
    CHECK_INT(lw_servo_load("examples/pendulum.json", &p, &e), LW_E_NOTATION);
    CHECK(p == NULL);
}

static void refused(const char *parts, const char *why)
{
    char text[3000];
    snprintf(text, sizeof text, "{'linkwright': 1, 'servo': {%s}}", parts);
    CHECK_INT(read_text(text), LW_E_NOTATION);
    CHECK_HAS(e.text, why);
    CHECK(e.line > 0 && e.column > 0);
}

#define LOOPS "'control': {'position': {'gain': 20}, 'speed': {'proportional': 200}}, "

TEST(bad_files_are_refused)
{
    refused(LOOPS STILL, "\"motor\"");
    refused(MOTOR ", " LOOPS "'motion': {'moves': []}", "motion.moves");
    refused(MOTOR ", " LOOPS "'motion': {'speed': 1, 'acceleration': 1, 'moves': [{}]}", "\"to\"");
    refused(MOTOR ", " LOOPS "'motion': {'speed': 1, 'acceleration': 1, 'moves': [{'to': 1, 'law': 'x', 'duration': 1}]}",
            "law of motion");
    refused(MOTOR ", " LOOPS "'motion': {'expression': 'q(A)'}", "t alone");
    refused(MOTOR ", 'load': {'mass': 1}, " LOOPS STILL, "\"radius\"");
    refused(MOTOR ", 'transmission': {'backlash': 1}, " LOOPS STILL, "\"stiffness\"");
    refused(MOTOR ", 'transmission': {'ratio': 1, 'radius': 1}, " LOOPS STILL, "keep one");
    refused(MOTOR ", 'encoder': {'steps': 100}, " LOOPS STILL, "\"sample\"");
    refused(MOTOR ", 'control': {'position': {'gain': 20, 'sample': 1, 'delay': 2}, 'speed': {'proportional': 1}}, " STILL,
            "delay");
    refused("'motor': {'torque_constant': 1, 'inertia': 1, 'resistance': 1}, 'control': {'position': {'gain': 1}, "
            "'speed': {'proportional': 1}, 'current': {'bandwidth': 1}}, " STILL, "\"inductance\"");
}
