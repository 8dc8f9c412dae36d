/* Painleve's problem: rods that slide on a floor with friction, against equations of their own. */
#include "tests/touch_run.h"

/* A rod of length 1 and mass 1 with its foot on the floor, in y = angle, rate, place and speed of the foot, height and rate of the foot.
 * slips: sense of the slip; 0: the foot sticks. */
typedef struct rod { double mu, inertia; int slips; bool flies; } rod;

/* The foot comes down with the acceleration  free + response N  while it slips; Painleve's paradox: response <= 0 */
static double response(const rod *r, const double *y)
{
    return 1 + 0.25/r->inertia*cos(y[0])*(cos(y[0]) + r->mu*r->slips*sin(y[0]));
}

static double free_of_force(const double *y) { return 0.5*sin(y[0])*y[1]*y[1] - g; }

static void foot_forces(const rod *r, const double *y, double *normal, double *across)
{
    double c = cos(y[0]), s = sin(y[0]), k = 0.25/r->inertia, ax = 0.5*c*y[1]*y[1], ay = free_of_force(y);
    double xx = 1 + k*s*s, xy = -k*s*c, yy = 1 + k*c*c, det = xx*yy - xy*xy;     /* accelerations of the foot by forces */
    *normal = r->flies ? 0 : r->slips ? -ay/response(r, y) : (xy*ax - xx*ay)/det;
    *across = r->flies ? 0 : r->slips ? -r->mu*r->slips**normal : (xy*ay - yy*ax)/det;
}

static lw_status rod_rate(void *context, double t, const double *y, double *dy)
{
    const rod *r = context;
    double normal, across, c = cos(y[0]), s = sin(y[0]);
    (void)t;
    foot_forces(r, y, &normal, &across);
    double alpha = 0.5*(s*across - c*normal)/r->inertia;
    dy[0] = y[1];
    dy[1] = alpha;
    dy[2] = y[3];
    dy[3] = r->flies || r->slips ? across + 0.5*(s*alpha + c*y[1]*y[1]) : 0;
    dy[4] = y[5];
    dy[5] = r->flies ? -g - 0.5*(c*alpha - s*y[1]*y[1]) : 0;
    return LW_OK;
}

/* Positive until the mode ends: by the force, by friction or the slip, in Painleve's paradox; and until the other end comes down. */
static lw_status rod_event(void *context, double t, const double *y, double *e)
{
    const rod *r = context;
    double normal, across;
    (void)t;
    foot_forces(r, y, &normal, &across);
    e[0] = r->flies ? y[4] : r->slips ? -free_of_force(y) : normal;
    e[1] = r->flies ? 1 : r->slips ? r->slips*y[3] : r->mu*normal - fabs(across);
    e[2] = r->slips && !r->flies ? response(r, y) : 1;
    e[3] = y[4] + sin(y[0]);
    return LW_OK;
}

/* The foot has come to rest, or no longer sticks: does it stick, slip, or leave the floor? */
static void choose(rod *r, const double *y)
{
    double normal, across;
    r->slips = 0;
    foot_forces(r, y, &normal, &across);
    r->flies = normal < -1e-9;
    r->slips = !r->flies && fabs(across) > r->mu*normal*(1 - 1e-12) ? across > 0 ? -1 : 1 : 0;
}

/* Follow the rod from y on.  Returns how far: until the other end or the foot comes down, or *jams. */
static double follow_rod(rod *r, double *y, double to, bool *jams)
{
    lw_ode ode = { .n = 6, .context = r, .rate = rod_rate, .n_event = 4, .event = rod_event, .direction = { -1, -1, -1, -1 } };
    lw_ode_options o = lw_ode_options_default();
    lw_ode_stop stop = LW_ODE_EVENT;
    lw_integrator w = { .t = 0 };
    FREED double *work = calloc(lw_integrate_work(6, 4), sizeof *work);
    o.relative = o.absolute = 1e-14;
    *jams = false;
    for (bool ends = false; !ends && stop != LW_ODE_END;) {
        CHECK_INT(lw_integrate_start(&w, &ode, &o, work, w.t, memcpy(y, w.y ? w.y : y, 6*sizeof *y), NULL), LW_OK);
        for (stop = LW_ODE_STEP; stop == LW_ODE_STEP && !*jams;)
            *jams = lw_integrate_step(&w, to, &stop, NULL) != LW_OK;
        *jams = *jams || w.events >> 2 & 1;
        ends = *jams || (w.events & 8) || (r->flies && (w.events & 1));
        if (ends || stop == LW_ODE_END)
            break;
        if (w.events & 1)
            r->flies = true;
        else {
            w.y[3] = 0;
            choose(r, w.y);
            *jams = ends = r->slips && response(r, w.y) <= 0;
        }
    }
    memcpy(y, w.y, 6*sizeof *y);
    return w.t;
}

/* Read the model of a rod of this angle, rate and speed of the foot. */
static void read_rod(const rod *r, double a, double w, double v, const char *law)
{
    char format[1200];
    double c = cos(a), s = sin(a);
    snprintf(format, sizeof format, FREE(FLOOR, "'mass': 1, 'centre': [%.17g, %.17g], 'inertia': %.17g, 'velocity': [%.17g, %.17g], 'omega': %.17g",
             "{'segment': [[0, 0], [%.17g, %.17g]]}", "'friction': %.17g%s"), 0.5*c, 0.5*s, r->inertia, v - 0.5*s*w, 0.5*c*w, w, c, s, r->mu,
             law);
    free_model(format, 0, 0);
}

/* Where the foot slips ahead of a steep rod no force goes on with the motion (Painleve): an impulse at the foot ends the slip, and the
 * angular momentum about the foot stays.  Returns whether that is so. */
static bool stop_foot(rod *r, double *y)
{
    double c = cos(y[0]), s = sin(y[0]);
    if (response(r, y) > 0 || free_of_force(y) >= 0)
        return false;
    y[1] = (r->inertia*y[1] + 0.25*y[1] - 0.5*s*y[3])/(r->inertia + 0.25*(c*c + s*s));
    y[3] = 0;
    choose(r, y);
    return true;
}

/* Rods of any friction that stick, slip, fly and turn back, below and beyond Painleve's paradox, as these few equations tell; and if
 * the force grows without limit on the way, the time and the reason. */
TEST(rods_with_friction)
{
    enum { RODS = 300, HARD = 4 };
    static const uint64_t hard[HARD] = { 207, 2154, 2776, 2928 };        /* two that jam, and two that come near it and do not */
    int jammed = 0, stopped = 0, moved = 0;
    for (int i = 0; i < RODS + HARD; i++) {
        lw_rng rng;
        lw_rng_seed(&rng, i < RODS ? check_seed() : 4242, i < RODS ? (uint64_t)i : hard[i - RODS]);
        rod r = { .mu = lw_rng_range(&rng, 0.1, 3) };
        r.inertia = lw_rng_range(&rng, 0, 1) < 0.5 ? 1/12.0 : lw_rng_range(&rng, 0.01, 0.2);
        double a = lw_rng_range(&rng, 0.15, LW_PI - 0.15), w = lw_rng_range(&rng, -4, 4), v = lw_rng_range(&rng, -3, 3);
        double y[6] = { a, w, 0, i == 0 ? 0 : v };
        bool jams;
        read_rod(&r, a, w, y[3], "");
        r.slips = v > 0 ? 1 : -1;
        r.flies = free_of_force(y) >= 0;
        if (i == 0)
            choose(&r, y);
        bool struck = stop_foot(&r, y);
        stopped += struck;
        double end = follow_rod(&r, y, 0.3, &jams);
        if (!jams && end < 0.3)                              /* the other end comes down */
            continue;
        lw_status s = drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 0.3, 5);
        if (jams) {
            CHECK_INT(s, LW_E_NUMERIC);
            CHECK_NEAR(d.report.t, end, 2e-6, 0);
            CHECK_HAS(d.e.text, "Painleve");
            jammed++;
        } else {
            CHECK_INT(s, LW_OK);
            CHECK_NEAR(d.q[2], y[0] - a, 1e-9, 0);
            CHECK_POINT(d.tracer[5], y[2], y[4], 1e-9, 0);
            CHECK(!struck || (d.report.event[0].impact && d.report.event[0].t == 0));
            CHECK(d.report.energy_error < 1e-10*d.report.energy_scale);
            moved++;
        }
    }
    CHECK(jammed > 1 && stopped > RODS/20 && moved > RODS/2);
}

/* Compliant contacts with smooth friction come near rigid ones: for smooth motions the difference falls with 1/stiffness, for
 * Painleve's impulse with its root. */
TEST(rods_on_stiff_floors)
{
    /* the last one: a step was taken whose stages that count all lay above the floor */
    static const struct { double mu, angle, rate, speed, stiffness[2], falls; } rods[] = {
        { 0.3, 1.2, 0, 1.5, { 1e5, 1e7 }, 0.02 }, { 0.7, 1, 1, 2, { 1e5, 1e7 }, 0.02 }, { 2, 2*LW_PI/3, 0, 5, { 1e4, 1e5 }, 0.4 },
        { 0.6, 1, 0.5, -1, { 1e4, 1e8 }, 1e-3 } };
    for (int i = 0; i < 4; i++) {
        rod r = { .mu = rods[i].mu, .inertia = 1/12.0, .slips = rods[i].speed > 0 ? 1 : -1 };
        double y[6] = { rods[i].angle, rods[i].rate, 0, rods[i].speed }, off[2];
        bool jams;
        for (int k = 0; k < 2; k++) {
            char law[120];
            double stiffness = rods[i].stiffness[k];
            snprintf(law, sizeof law, ", 'friction_speed': %g, 'stiffness': %g, 'damping': %g", i == 3 ? 1e-3 : 10/stiffness, stiffness,
                     4*sqrt(stiffness));
            read_rod(&r, rods[i].angle, rods[i].rate, rods[i].speed, law);
            CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, i == 3 ? 0.05 : 0.2, 5), LW_OK);
            if (k == 0) {
                stop_foot(&r, y);
                follow_rod(&r, y, i == 3 ? 0.05 : 0.2, &jams);
            }
            off[k] = fmax(fabs(d.q[2] - (y[0] - rods[i].angle)), hypot(d.tracer[5].x - y[2], d.tracer[5].y - y[4]));
        }
        CHECK(off[0] < 0.1 && off[1] < rods[i].falls*off[0]);
    }
}
