/* test_motor.c - tables of parts; the choice of motors against a slow second opinion and known answers; table 4 of
 * the source. */
#include "base/vec2.h"
#include "grammar/model/spatial.h"
#include "mbs/drives/motor.h"
#include "tests/check.h"

static lw_error error;

/* Makkonen 1999, table 4, to the printed digits; the stroke of its second branch is not printed: it is 4 m. */
TEST(table_4)
{
    const lw_motor_part m = { .torque_constant = 1.6, .resistance = 30, .inductance = 0.0703, .inertia = 0.0011,
                              .torque = 2.1,
                              .speed = 100*LW_PI };
    const double mass = 200, way = 4, limit = 20;
    lw_radius r = lw_radius_at(&m, mass, way, limit, lw_radius_of_way(&m, mass, way));
    CHECK_NEAR(r.r, 0.0059700, 5e-8, 0);
    CHECK_NEAR(r.alpha, 255.222, 5e-4, 0);
    CHECK_NEAR(r.speed, 1.876, 5e-4, 0);
    CHECK_NEAR(r.printed_way, 0.176, 5e-4, 0);
    CHECK_NEAR(r.printed_time, 0.188, 5e-4, 0);
    CHECK_NEAR(100*r.efficiency, 86.63, 5e-3, 0);
    CHECK_NEAR(r.acceleration, 1.5237, 5e-5, 0);                  /* what the axis truly does */
    CHECK_NEAR(r.time, 3.36366, 5e-6, 0);
    r = lw_radius_at(&m, mass, way, limit, lw_radius_printed(&m, limit));
    CHECK_NEAR(r.r, 0.010476, 5e-7, 0);
    CHECK_NEAR(r.alpha, 91.106, 5e-4, 0);                         /* printed 91.087 */
    CHECK_NEAR(r.acceleration, 0.9544, 5e-5, 0);
    r = lw_radius_at(&m, mass, way, limit, lw_radius_of_acceleration(&m, mass));
    CHECK_NEAR(r.r, 2.345e-3, 5e-7, 0);
    CHECK_NEAR(r.acceleration, 2.2386, 5e-5, 0);
}

/* No radius of a fine grid is better than the best one; the formula holds where the speed is reached. */
TEST(best_radius)
{
    for (int trial = 0; trial < 50; trial++) {
        lw_motor_part m = { .inertia = 1e-4*exp(0.1*trial), .torque = 1 + trial%7, .speed = 100 + 20*(trial%11) };
        double mass = 1 + 5*(trial%13), way = 0.01*exp(0.15*trial), r = lw_radius_best(&m, mass, way);
        double best = lw_radius_at(&m, mass, way, 1, r).time, formula = lw_radius_of_way(&m, mass, way);
        for (int k = -3000; k <= 3000; k++)
            CHECK(lw_radius_at(&m, mass, way, 1, r*exp(k*1e-3)).time >= best*(1 - 1e-12));
        lw_radius f = lw_radius_at(&m, mass, way, 1, formula);
        if (way >= f.speed*f.speed/f.acceleration)
            CHECK_NEAR(f.time, best, 1e-9*best, 0);
    }
}

TEST(tables)
{
    static const char text[] = "# motors\r\n name , torque_constant [N m/A], resistance [ohm],inertia [kg m^2],torque "
                               "[N m],speed [rpm],x-shop\r\n"
                               "\"A 1\",1,2,3,4,60,here\r\n\r\nB,0.5,2,3e-4,4,120,\r\n";
    OWN(lw_drive_parts) p = { 0 };
    CHECK_INT(lw_drive_parts_read(text, strlen(text), "f", &p, &error), LW_OK);
    CHECK_INT(p.n_motor, 2);
    CHECK_TEXT(p.motor[0].name, "A 1");
    CHECK_NEAR(p.motor[0].speed, 2*LW_PI, 1e-14, 0);
    CHECK_NEAR(p.motor[1].inertia, 3e-4, 0, 0);
    static const char gear[] = "name,ratio,radius [mm],efficiency [%]\nG,10,,95\nW,1,30,\n";
    CHECK_INT(lw_drive_parts_read(gear, strlen(gear), "f", &p, &error), LW_OK);
    CHECK_INT(p.n_gear, 2);
    CHECK_NEAR(p.gear[0].efficiency, 0.95, 1e-15, 0);
    CHECK_NEAR(p.gear[1].radius, 0.03, 1e-16, 0);
    static const struct { const char *text, *says; long line, column; } wrong[] = {
        { "", "no part", 1, 1 }, { "a,b\n1,2\n", "no table of parts", 1, 1 },
        { "name,ratio\n", "no part", 1, 1 }, { "name,ratio,radus\nG,1,2\n", "did you mean \"radius\"", 1, 12 },
        { "name,ratio,radius [kg]\nG,1,2\n", "needs a unit like [m]", 1, 12 }, { "name,ratio,radius [mn]\nG,1,2\n",
                                                                                 "no unit", 1, 20 },
        { "name,ratio\nH\x1b[31m,1\n", "a control character", 2, 1 }, { "name,ratio\nH,x\n", "a number above 0", 2, 3 }, { "name,ratio\nH,-1\n", "a number above 0", 2, 3 },
        { "name,ratio\nH\n", "has 1 fields", 2, 1 }, { "name,ratio\nH,1\nH,2\n", "given twice", 3, 1 },
        { "name,ratio,efficiency\nH,1,95\n", "too large", 2, 5 }, { "ratio\n5\n", "\"name\" is missing", 1, 1 },
        { "name,torque_constant\nM,1\n", "\"resistance\" [ohm] of a motor is missing", 1, 1 },
        { "name,ratio,ratio\nG,1,1\n", "given twice", 1, 12 } };
    for (size_t i = 0; i < sizeof wrong/sizeof *wrong; i++) {
        error = (lw_error){ 0 };
        CHECK_INT(lw_drive_parts_read(wrong[i].text, strlen(wrong[i].text), "f", &p, &error), LW_E_NOTATION);
        CHECK_HAS(error.text, wrong[i].says);
        CHECK_INT(error.line, wrong[i].line);
        CHECK_INT(error.column, wrong[i].column);
        CHECK(p.n_motor == 2 && p.n_gear == 2 && p.n_amplifier == 0);
    }
}

enum { N = 1001 };
static double work[2*N];

/* A mass that is moved to and fro: torque J a; the figures of motor torque follow by hand. */
TEST(known_choice)
{
    static double v[N], f[N], a[N];
    const double mass = 20, top = 5, w = 2*LW_PI;
    for (int k = 0; k < N; k++) {
        v[k] = top*sin(w*k/1000.0);
        a[k] = top*w*cos(w*k/1000.0);
        f[k] = mass*a[k];
    }
    lw_load l = { "x", true, N, 1e-3, v, f, a, { mass, mass }, NULL };
    lw_load_figures g = lw_load_figures_of(&l);
    CHECK_NEAR(g.torque_peak, mass*top*w, 1e-9, 0);
    CHECK_NEAR(g.torque_rms, mass*top*w/sqrt(2), 0, 1e-5);
    CHECK_NEAR(g.energy_out, mass*top*top, 0, 1e-4);                 /* m v^2/2 twice a cycle */
    CHECK_NEAR(g.energy_back, mass*top*top, 0, 1e-4);
    lw_motor_part motor = { "M", .torque_constant = 0.5, .resistance = 2, .inertia = 1e-3, .torque = 5, .torque_peak
                            = 15, .speed = 300 };
    lw_gear_part gear = { "G", .ratio = 1, .radius = 0.02 };
    lw_amplifier_part amplifier = { "A", .voltage = 300, .current = 12, .current_peak = 40, .peak_time = 1 };
    lw_drive_parts p = { 1, 1, 1, &motor, &gear, &amplifier };
    lw_drive_choice c = lw_drive_try(&l, &p, 0, 0, 0, INFINITY, work);
    double torque = (mass*0.02 + 1e-3/0.02)*top*w, current = torque/0.5;
    CHECK_NEAR(c.ratio, 50, 1e-12, 0);
    CHECK_NEAR(c.torque_peak, torque, 1e-12, 1e-12);
    CHECK_NEAR(c.torque_rms, torque/sqrt(2), 0, 1e-5);
    CHECK_NEAR(c.speed, 250, 1e-9, 0);
    CHECK_NEAR(c.inertia_ratio, mass*0.02*0.02/1e-3, 1e-12, 0);
    CHECK_NEAR(c.voltage, hypot(2*current, 0.5*250), 0, 1e-4);       /* cos and sin */
    CHECK_NEAR(c.heat, 2*current*current/2, 0, 1e-4);
    motor.inductance = 0.05;                                          /* L dI/dt is against the back EMF here */
    c = lw_drive_try(&l, &p, 0, 0, 0, INFINITY, work);
    CHECK_NEAR(c.voltage, hypot(2*current, 0.5*250 - 0.05*current*w), 0, 1e-4);
    CHECK_INT(c.torque_steps, 0);
    for (int k = 500; k < N; k++)                                     /* a step of torque: no infinite voltage */
        f[k] += 100;
    lw_drive_choice step = lw_drive_try(&l, &p, 0, 0, 0, INFINITY, work);
    CHECK_INT(step.torque_steps, 1);
    CHECK(step.voltage < c.voltage + 2*100*0.02/0.5 + 1);
    for (int k = 500; k < N; k++)
        f[k] = mass*a[k];
    /* i^2 t on a fine grid, from the middle of a cycle */
    double charge = 0, most = 0;
    for (int k = 0; k < 400000; k++) {
        double i = current*cos(w*k*1e-5);
        charge = fmax(0, charge + (i*i - 144)*1e-5);
        most = fmax(most, k < 200000 ? most : charge);
    }
    CHECK(c.fails & 1u << LW_DRIVE_CURRENT_RMS);
    gear.efficiency = 0.8;                                            /* the losses help to brake */
    c = lw_drive_try(&l, &p, 0, 0, 0, 5, work);
    CHECK(c.fails & 1u << LW_DRIVE_INERTIA);
    CHECK_NEAR(c.torque_peak, (mass*0.02/0.8 + 1e-3/0.02)*top*w, 0, 1e-9);
    amplifier.current = 21.9;
    c = lw_drive_try(&l, &p, 0, 0, 0, INFINITY, work);
    CHECK(!(c.fails & 1u << LW_DRIVE_CURRENT_RMS) && c.i2t > 0);
    CHECK(most > 0);
}

/* The ranking: possible ones first and by cost, the front has no better pair; all choices are there. */
TEST(ranking)
{
    static double v[N], f[N], a[N];
    lw_motor_part motor[6];
    lw_gear_part gear[7] = { { "wheel", .ratio = 1, .radius = 0.1 } };
    for (int k = 0; k < N; k++) {
        v[k] = 3*sin(0.01*k);
        f[k] = 30 + 10*cos(0.01*k);
        a[k] = 30*cos(0.01*k);
    }
    for (int i = 0; i < 6; i++)
        motor[i] = (lw_motor_part){ .torque_constant = 1, .resistance = 1, .inertia = 1e-4*(1 + i), .torque = 1 + i,
                                    .speed = 300, .price = 100*(1 + i) };
    for (int i = 1; i < 7; i++)
        gear[i] = (lw_gear_part){ .ratio = 4*i*i, .efficiency = 0.9, .price = 50 + 10*i };
    lw_load l = { "q", false, N, 1e-3, v, f, a, { NAN, NAN }, NULL };
    lw_drive_parts p = { 6, 7, 0, motor, gear, NULL };
    lw_drive_choice *c;
    bool *front;
    size_t n, good = 0;
    CHECK_INT(lw_drive_choose(&l, &p, 10, &(const volatile int){ 1 }, &n, &c, &front, &error), LW_STOPPED);
    CHECK_INT((int)n, 0);
    free(c), free(front);
    CHECK_INT(lw_drive_choose(&l, &p, 10, NULL, &n, &c, &front, &error), LW_OK);
    CHECK_INT((int)n, 36);                                            /* the wheel does not turn a joint */
    for (size_t i = 0; i < n; i++) {
        lw_drive_choice again = lw_drive_try(&l, &p, c[i].motor, c[i].gear, -1, 10, work);
        CHECK(again.fails == c[i].fails && again.cost == c[i].cost);
        good += !c[i].fails;
        if (i > 0)
            CHECK(!c[i - 1].fails >= !c[i].fails && (c[i].fails || c[i - 1].cost <= c[i].cost));
        bool beaten = c[i].fails;
        for (size_t k = 0; k < n; k++)
            beaten = beaten || (!c[k].fails && c[k].cost <= c[i].cost && c[k].worst < c[i].worst)
                  || (!c[k].fails && c[k].cost < c[i].cost && c[k].worst <= c[i].worst);
        CHECK(front[i] == !beaten);
    }
    CHECK(good > 3 && good < n);
    free(c);
    free(front);
}

/* Reflected inertia of the motors of a DELTA robot, whose tool is driven: the same as the matrix M of dT = M d(q''), from runs
 * in which the tool gets a sudden acceleration along each axis. */
TEST(inertia_of_drives)
{
    enum { D = 3 };
    const double end = 0.03, extra = 1000;
    double torque[D][D], rate[D][D];
    lw_spatial *m;
    lw_loads base, more;
    CHECK_INT(lw_spatial_load("examples/space/delta.json", &m, &error), LW_OK);
    CHECK_INT(lw_spatial_loads(m, end - 1e-7, end, 1, &base, &error), LW_OK);
    CHECK_INT(base.n, D);
    for (int c = 0; c < D; c++) {
        char was[400], text[500];
        snprintf(was, sizeof was, "%s", lw_expression_text(m->input[c].motion));
        snprintf(text, sizeof text, "%s + %g*max(t - %.17g, 0)^2", was, extra/2, end);
        CHECK_INT(lw_spatial_set_motion(m, c, text, &error), LW_OK);
        CHECK_INT(lw_spatial_loads(m, end - 1e-7, end, 1, &more, &error), LW_OK);
        for (int i = 0; i < D && more.n == D; i++) {
            torque[i][c] = more.load[i].torque[1] - base.load[i].torque[1];
            rate[i][c] = more.load[i].acceleration[1] - base.load[i].acceleration[1];
        }
        lw_loads_free(&more);
        CHECK_INT(lw_spatial_set_motion(m, c, was, &error), LW_OK);
    }
    for (int i = 0; i < D; i++) {                         /* row i of M: M rate = torque, by Cramer's rule on rate^T */
        double a[D][D + 1];
        for (int r = 0; r < D; r++) {
            for (int c = 0; c < D; c++)
                a[r][c] = rate[c][r];
            a[r][D] = torque[i][r];
        }
        for (int k = 0; k < D; k++)
            for (int r = 0; r < D; r++)
                for (int c = D; r != k && c >= k; c--)
                    a[r][c] -= a[r][k]/a[k][k]*a[k][c];
        double inertia = a[i][D]/a[i][i];
        CHECK_NEAR(base.load[i].inertia[1], inertia, 0, 1e-5);
        CHECK(base.load[i].inertia[0] <= base.load[i].inertia[1] && inertia > 0.05);
    }
    lw_loads_free(&base);
    lw_spatial_destroy(m);
}
