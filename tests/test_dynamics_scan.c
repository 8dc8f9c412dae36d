/* Random models with singular postures, run on several grids: not one difference from the exact motion or between
 * formulations goes without a word.  A run gives all its samples, or a status.  LW_SCAN=N takes N models of each kind
 * instead of a few, LW_SEED=... others. */
#include <complex.h>

#include "mbs/analysis/reactions.h"
#include "tests/dynamics_run.h"
#include "tests/model_text.h"

OWNS(lw_dynamics)

static drun d;

static int models(int few)
{
    const char *all = getenv("LW_SCAN");
    return all ? atoi(all) : check_cases(few);
}

/* The seed of a run without LW_SEED leaves the models as they are. */
static void seed_with(uint64_t seed, uint64_t kind, int k)
{
    lw_rng_seed(&rng, kind + 100*(seed - 20260101u), (uint64_t)k);
}

static void seed_model(uint64_t kind, int k)
{
    seed_with(check_seed(), kind, k);
}

static void put_pin(const char *name, const char *first, const char *second, double x, double y)
{
    put("%s{'name': '%s', 'links': ['%s', '%s'], 'at': [%.17g, %.17g]}", *name == 'A' ? "" : ", ", name, first, second,
        x, y);
}

/* A parallelogram with `cranks` cranks, whose bars never turn; or a slider-crank with equal crank and rod, whose rod
 * turns as much as the crank, the other way.  Cranks of length 1 at the angle `start`. */
static void write_linkage(bool slider, int cranks, double start)
{
    double x = cos(start), y = sin(start), at[4] = { 0, between(1.5, 4), 0, 0 };
    char bar[] = "b0", crank[] = "c0", pin[] = "A0";
    at[2] = at[1] + between(0.5, 3);
    used = 0;
    put("{'linkwright': 1, 'links': ['ground'");
    if (slider) {
        put_link("c0", x/2, y/2);
        put_link("b0", 1.5*x, y/2);
        put_link("slider", 2*x, 0);
        put("], 'joints': [");
        put_pin("A0", "ground", "c0", 0, 0);
        put_pin("B0", "c0", "b0", x, y);
        put_pin("C0", "b0", "slider", 2*x, 0);
        put(", {'name': 'D', 'kind': 't', 'links': ['ground', 'slider'], 'at': [%.17g, 0], 'along': [1, 0]}]", 2*x);
        return;
    }
    for (int i = 0; i < cranks; i++)
        crank[1] = (char)('0' + i), put_link(crank, at[i] + x/2, y/2);
    for (int i = 0; i + 1 < cranks; i++)
        bar[1] = (char)('0' + i), put_link(bar, (at[i] + at[i + 1])/2 + x, y);
    put("], 'joints': [");
    for (int i = 0; i < cranks; i++) {
        pin[0] = 'A', pin[1] = crank[1] = (char)('0' + i);
        put("%s", i ? ", " : "");
        put_pin(pin, "ground", crank, at[i], 0);
        for (int side = -1; side <= 0; side++)
            if (i + side >= 0 && i + side < cranks - 1) {
                pin[0] = side ? 'C' : 'B', bar[1] = (char)('0' + i + side);
                put_pin(pin, crank, bar, at[i] + x, y);
            }
    }
    put("]");
}

/* ---- driven ---------------------------------------------------------------------------------------- */

typedef struct exact {
    const lw_dynamics *d;
    bool   slider;
    int    n_crank, n_row, without;
    double start, off, power;
} exact;

static lw_status compare(void *context, const lw_moment *m)
{
    exact *z = context;
    const lw_system *s = lw_dynamics_system(z->d);
    const lw_forces *f = lw_dynamics_forces(z->d);
    double force[LW_SYSTEM_Q_MAX], drive[LW_INPUT_MAX], turn = m->q[2], need = 0, most = 0;
    for (int b = 1; b < s->n_body; b++) {
        double should = z->slider ? b == 1 ? -turn : 0 : b < z->n_crank ? turn : 0;
        z->off = fmax(z->off, fabs(m->q[3*b + 2] - should));
        should = z->slider ? b == 1 ? -m->v[2] : 0 : b < z->n_crank ? m->v[2] : 0;
        z->off = fmax(z->off, fabs(m->v[3*b + 2] - should)/fmax(1, fabs(m->v[2])));
    }
    lw_forces_apply(f, m->t, m->q, m->v, force, NULL, NULL, NULL);
    for (int i = 0; i < s->n_q; i++) {
        need += (f->mass[i]*m->a[i] - force[i])*m->v[i];
        most += fabs((f->mass[i]*m->a[i] - force[i])*m->v[i]);
    }
    lw_reactions_driving(z->d, m, drive);
    if (fabs(m->v[2]) > 1e-3)
        z->power = fmax(z->power, isfinite(drive[0]) ? fabs(drive[0]*m->v[2] - need)/most : INFINITY);
    bool known = true;
    for (int i = 0; i < s->n_row; i++)
        known = known && isfinite(m->l[i]);
    z->without += !known;
    z->n_row++;
    return LW_OK;
}

/* Parallelograms of two and three cranks and slider-cranks with equal crank and rod, driven over singular postures at
 * constant and at varying speed, or turning back beside one: all samples of every grid are on the exact motion, and the drive gives the power. */
TEST(driven)
{
    static const int grid[] = { 7, 36, 97, 100, 360 };
    int without = 0;
    for (int k = 0; k < 3*models(3); k++) {
        seed_model(11, k);
        bool slider = k%3 == 2;
        exact z = { .slider = slider, .n_crank = 2 + k%3 };
        z.start = k%4 != 1 ? between(0.3, 1.2) : LW_PI/2*(slider ? 0.5 : 1);
        write_linkage(slider, z.n_crank, z.start);
        put(", 'gravity': [0, -9.81], 'input': {'joint': 'A0', 'motion': '");
        double f = k%5 ? 1 : 0.001, value = slider || k%4 != 1 ? z.start : LW_PI/2;
        if (k%2)
            put("%.17g + %.17g*t'}}", value, 2*LW_PI*f);
        else
            put("%.17g + %.17g*sin(%.17g*t)'}}", value, k%4 == 2 ? (slider ? 0.5 : 1)*LW_PI - z.start + 0.005 : between(1, 9), 2*LW_PI*f);
        drun_read_text(&d, text);
        for (int g = 0; g < 5; g++)
            for (int slow = 0; slow < (g == 1 ? 2 : 1); slow++) {
                OWNED(lw_dynamics) *made = NULL;
                d.o.analysis = slow ? LW_ANALYSIS_QUASISTATIC : LW_ANALYSIS_KINEMATIC;
                d.o.to = 1/f;
                d.o.intervals = grid[g];
                z.n_row = 0, z.off = z.power = 0;
                d.e.text[0] = 0;
                lw_status s = lw_dynamics_make(&d.model, &d.o, &made, &d.e);
                z.d = made;
                if (s == LW_OK)
                    s = lw_dynamics_run(made, compare, &z, &d.report, &d.e);
                CHECK_INT(s, LW_OK);
                CHECK_INT(z.n_row, grid[g] + 1);
                CHECK(z.off < 1e-8);
                CHECK(slow || z.power < 1e-8);
            }
        without += z.without;
    }
    CHECK(without > 0);
}

/* ---- linkages with closed forms ------------------------------------------------------------------------- */

/* Linkages whose links lie in line at change points, by their crank angle with complex numbers: antiparallelograms (`idler`: with a gear
 * outside that follows the crank), kites, whose coupler turns once while the crank turns twice, five-bars with cranks geared 1 to -1, and
 * parallelograms whose cranks are geared by an idler, too. */
typedef enum closed_kind { ANTI, ANTI_WITH_GEAR, KITE, GEARED_FIVE_BAR, GEARED_PARALLELOGRAM, N_CLOSED } closed_kind;
typedef struct closed { closed_kind kind; double ground, crank, rod, side, start; int n; } closed;

/* Places of the first pins of crank, follower, and the others, and their directions. */
static void place_links(const closed *z, double turn, double complex at[4], double complex along[4])
{
    double g = z->ground, a = z->crank, angle = z->start + turn;
    double complex pin = a*cexp(I*angle), other = g + pin, end;
    at[0] = 0, at[1] = g, at[2] = pin;
    along[0] = cexp(I*angle), along[1] = along[0], along[2] = 1;
    if (z->kind == ANTI || z->kind == ANTI_WITH_GEAR) {
        double half = 0.5*remainder(angle, 2*LW_PI);
        along[1] = cexp(-2*I*atan2((g + a)/(g - a)*sin(half), cos(half)));
        along[2] = (g + a*along[1] - pin)/g;
        at[3] = -1, along[3] = cexp(-2*I*angle);
    } else if (z->kind == KITE) {                            /* the crank is as long as the ground link */
        end = (g*cos(angle/2) + z->side*sqrt(z->rod*z->rod - g*g*sin(angle/2)*sin(angle/2)))*cexp(I*angle/2);
        at[2] = g*cexp(I*angle);
        along[1] = (end - g)/z->rod, along[2] = (end - at[2])/z->rod;
    } else if (z->kind == GEARED_FIVE_BAR) {
        other = g - conj(pin);
        end = g/2 + I*(cimag(pin) + z->side*sqrt(z->rod*z->rod - (g/2 - creal(pin))*(g/2 - creal(pin))));
        at[3] = other, along[1] = conj(along[0]), along[2] = (end - pin)/z->rod, along[3] = (end - other)/z->rod;
    } else
        at[3] = g/2, along[3] = conj(along[0]);
}

static void put_gear(const char *name, const char *first, const char *second, double x, double ratio)
{
    put(", {'name': '%s', 'kind': 'g', 'links': ['%s', '%s'], 'at': [%.17g, 0], 'ratio': %.17g}", name, first, second, x, ratio);
}

/* Write one, up to its input. */
static void write_closed(closed *z, closed_kind kind)
{
    double complex at[4], along[4], end;
    char name[] = "l0";
    *z = (closed){ .kind = kind, .ground = between(2.2, 4), .crank = between(0.5, 1), .side = between(-1, 1) < 0 ? -1 : 1,
                   .start = between(0.3, 1.2), .n = kind == ANTI || kind == KITE ? 3 : 4 };
    z->crank = kind == KITE ? z->ground : z->crank;
    z->rod = kind == KITE ? z->ground*between(1.1, 2) : z->ground/2 + z->crank + between(0.1, 1);
    place_links(z, 0, at, along);
    used = 0;
    put("{'linkwright': 1, 'gravity': [1, -9.81], 'links': ['ground'");
    for (int i = 0; i < z->n; i++) {
        double complex c = at[i] + 0.4*along[i];
        name[1] = (char)('0' + i);
        put_link(name, creal(c), cimag(c));
    }
    put("], 'joints': [");
    put_pin("A", "ground", "l0", 0, 0);
    put_pin("D", "ground", "l1", z->ground, 0);
    put_pin("B", "l0", "l2", creal(at[2]), cimag(at[2]));
    end = kind == GEARED_FIVE_BAR ? at[2] + z->rod*along[2] : z->ground + (kind == KITE ? z->rod : z->crank)*along[1];
    put_pin("C", kind == GEARED_FIVE_BAR ? "l3" : "l1", "l2", creal(end), cimag(end));
    if (kind == GEARED_FIVE_BAR)
        put_pin("E", "l1", "l3", creal(at[3]), cimag(at[3]));
    else if (z->n == 4)
        put_pin("W", "ground", "l3", creal(at[3]), 0);
    if (kind == GEARED_FIVE_BAR)
        put_gear("G", "l0", "l1", z->ground/2, -1);
    if (kind == ANTI_WITH_GEAR)
        put_gear("G", "l0", "l3", -2.0/3, -2);
    if (kind == GEARED_PARALLELOGRAM) {
        put_gear("G", "l0", "l3", z->ground/4, -1);
        put_gear("H", "l3", "l1", 3*z->ground/4, -1);
    }
    put("], ");
}

typedef struct closed_off { const closed *z; double off, last; int n; } closed_off;

static lw_status keep_closed_off(void *context, const lw_moment *m)
{
    closed_off *k = context;
    double complex at[4], along[4], first[4];
    place_links(k->z, 0, at, first);
    place_links(k->z, k->last = m->q[2], at, along);
    for (int i = 1; i < k->z->n; i++)
        k->off = fmax(k->off, cabs(cexp(I*m->q[3*i + 2]) - along[i]/first[i]));
    k->n++;
    return LW_OK;
}

/* Driven at constant speed or to and fro, and moving by their weight: on the closed form in every row, whatever the grid. */
TEST(closed_forms)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL };
    static const int grid[] = { 7, 36, 97, 100, 360 };
    for (int k = 0; k < N_CLOSED*models(2); k++) {
        closed z;
        closed_off w = { .z = &z };
        seed_model(17, k);
        write_closed(&z, (closed_kind)(k%N_CLOSED));
        int before = used;
        double speed = between(3, 7)*(k%2 ? -1 : 1), last = NAN;
        for (int run = 0; run < 8; run++) {
            OWNED(lw_dynamics) *made = NULL;
            bool driven = run < 4;
            used = before;
            if (driven)
                put(run%2 ? "'input': {'joint': 'A', 'motion': '%.17g + %.17g*t'}}" : "'input': {'joint': 'A', 'motion': '%.17g + %.17g*sin(2*t)'}}",
                    z.start, speed);
            else
                put("'input': {'joint': 'A', 'speed': %.17g}}", speed);
            drun_read_text(&d, text);
            d.o.analysis = run < 2 ? LW_ANALYSIS_KINEMATIC : driven ? LW_ANALYSIS_QUASISTATIC : LW_ANALYSIS_DYNAMIC;
            d.o.formulation = driven ? LW_FORMULATION_AUTO : each[run - 4];
            d.o.intervals = grid[(k + run)%5];
            d.o.relative = d.o.absolute = 1e-9;
            d.o.to = driven ? 2 : 1;
            w.off = w.n = 0;
            CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
            CHECK_INT(made ? lw_dynamics_run(made, keep_closed_off, &w, &d.report, &d.e) : LW_E_ARG, LW_OK);
            CHECK_INT(w.n, d.o.intervals + 1);
            CHECK_NEAR(w.off, 0, driven ? 1e-8 : 1e-7, 0);
            CHECK(driven || d.report.energy_error < 1e-5*d.report.energy_scale);
            CHECK(!(fabs(w.last - last) > 1e-4));
            last = driven ? NAN : run == 4 ? w.last : last;
        }
    }
}

/* ---- forward ----------------------------------------------------------------------------------------- */

static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_QUADRATURE, LW_FORMULATION_REDUCED,
                                       LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL };
enum { N_EACH = sizeof each/sizeof *each };
static const double tolerances[] = { 1e-6, 1e-7, 1e-8, 1e-9, 1e-10 };
static const int grids[] = { 7, 36, 97, 100, 360 };

/* Distance of a forward run from the exact curve of postures, and its last crank angle. */
typedef struct forward { bool slider; int n_crank, n_body; double off, last; long n; } forward;

static lw_status keep_off(void *context, const lw_moment *m)
{
    forward *z = context;
    for (int b = 1; b < z->n_body; b++) {
        double should = z->slider ? b == 1 ? -m->q[2] : 0 : b < z->n_crank ? m->q[2] : 0;
        z->off = fmax(z->off, fabs(m->q[3*b + 2] - should));
    }
    z->last = m->q[2];
    z->n++;
    return LW_OK;
}

static lw_status run_forward(forward *z, lw_formulation f, double tolerance, int grid)
{
    OWNED(lw_dynamics) *made = NULL;
    d.o.formulation = f;
    d.o.relative = d.o.absolute = tolerance;
    d.o.intervals = grid;
    d.e.text[0] = 0;
    z->off = 0, z->n = 0;
    lw_status s = lw_dynamics_make(&d.model, &d.o, &made, &d.e);
    if (s == LW_OK) {
        z->n_body = lw_dynamics_system(made)->n_body;
        s = lw_dynamics_run(made, keep_off, z, &d.report, &d.e);
    }
    return s;
}

/* Free runs of one freedom over singular postures, with gravity, a damper, friction or a stop that is struck: either on
 * the exact curve in all samples, or a status.  Without friction and stops all formulations agree in time. */
TEST(one_freedom)
{
    int failed = 0, runs = 0, n = models(7);
    for (int i = 0; i <= n; i++) {
        /* 93: with a stop; a step went to the other branch.  Last: a sample within a step over a flat posture */
        int k = i == n ? 24 : i == 6 ? 93 : i;
        seed_with(i == n ? 77 : check_seed(), 13, k);
        forward z = { .slider = k%3 == 2, .n_crank = 2 + k%3 };
        int extra = k/3%4;                       /* none, damper, friction, stop */
        write_linkage(z.slider, z.n_crank, between(0.3, 1.2));
        put(", 'gravity': [0, -9.81], 'input': {'joint': 'A0', 'speed': %.17g}}", between(2, 6)*(k%2 ? -1 : 1));
        drun_read_text(&d, text);
        d.o.to = 1.5;
        d.o.max_step = 20000;
        if (extra == 1)
            d.model.joint_spring[d.model.n_joint_spring++] = (lw_joint_spring){ .joint = 0, .damping = 0.2 };
        if (extra == 2)
            d.model.friction[0] = (lw_friction){ 0.1, 0.02, k%2 ? 0.01 : 0 };
        if (extra == 3)
            d.model.stop[0] = (lw_joint_stop){ .has_least = true, .least = -5, .has_greatest = true, .greatest = 5,
                                               .restitution = 0.6 };
        double tolerance = tolerances[k%5], last = NAN;
        for (int f = 0; f < N_EACH; f++) {
            lw_status s = run_forward(&z, each[f], tolerance, grids[(k + f)%5]);
            if (s == LW_E_KIND)
                continue;
            runs++;
            failed += s != LW_OK && !strstr(d.e.text, "friction jams the linkage");
            CHECK(s == LW_OK || d.e.text[0]);
            CHECK(s != LW_OK || z.n == grids[(k + f)%5] + 1);
            CHECK(z.off < 1e3*tolerance + 1e-9);
            if (s == LW_OK && extra < 2) {
                CHECK(!(fabs(z.last - last) > 1e5*tolerance));
                last = f == 0 ? z.last : last;
            }
        }
    }
    CHECK(10*failed <= runs);
}

/* Friction in all pins of a parallelogram, which may jam in a flat posture: on the exact curve in all samples, or a
 * status with a reason.  All formulations jam at the same time, whatever the grid. */
TEST(friction_in_all_pins)
{
    /* index1 named another reason; another time, by 0.035 s; two more that named another reason */
    static const struct { uint64_t seed; int k; } hard[] = { { 20260101, 72 }, { 20260101, 120 }, { 99, 136 }, { 99, 224 } };
    enum { N_HARD = sizeof hard/sizeof *hard };
    int jammed = 0, n = models(4);
    for (int i = 0; i < n + N_HARD; i++) {
        int k = i < n ? i : hard[i - n].k;
        seed_with(i < n ? check_seed() : hard[i - n].seed, 12, k);
        forward z = { .slider = k%2, .n_crank = 2 };
        bool auto_jams = false;
        double jam = 0;
        write_linkage(z.slider, 2, between(0.3, 1.2));
        put(", 'gravity': [0, -9.81], 'input': {'joint': 'A0', 'speed': -1}}");
        drun_read_text(&d, text);
        for (int j = 0; j < 4; j++)
            if (d.model.linkage.joint[j].kind == LW_JOINT_REVOLUTE)
                d.model.friction[j] = (lw_friction){ k%4 < 2 ? 0.1 : 0, 0.05, k%3 ? 0.01 : 0 };
        d.o.to = 2;
        d.o.max_step = 30000;
        for (int f = 0; f < N_EACH; f++) {
            lw_status s = run_forward(&z, each[f], tolerances[k%5], grids[(k + f)%5]);
            if (s == LW_E_KIND)
                continue;
            CHECK(s == LW_OK || strstr(d.e.text, "friction jams the linkage") || (f > 0 && s == LW_STOPPED));
            CHECK(s != LW_OK || z.n == grids[(k + f)%5] + 1);
            CHECK(z.off < 1e3*tolerances[k%5] + 1e-9);
            if (f == 0 && s != LW_OK)
                auto_jams = true, jam = d.report.t, jammed++;
            CHECK(f == 0 || auto_jams == (s != LW_OK));
            CHECK(!auto_jams || fabs(d.report.t - jam) < 0.02);
        }
    }
    CHECK(jammed > 0);
}

/* ---- forces in singular postures ----------------------------------------------------------------------- */

typedef struct carried_by { const lw_dynamics *d; lw_reaction pin[4]; double turn; } carried_by;

static lw_status keep_pins(void *context, const lw_moment *m)
{
    carried_by *z = context;
    lw_reactions_joints(z->d, m, z->pin);
    z->turn = m->q[2];
    return LW_OK;
}

/* A balanced parallelogram turns freely at constant speed, and its cranks carry the coupler by forces along themselves:
 * in the flat posture, and near it, by formulas.  With the centre of the coupler off the line of its pins, these forces
 * have a pole there, and are left out. */
TEST(forces_in_flat_postures)
{
    static const double away[] = { 0, 1e-6, 1e-4, -1e-3, 1e-2, 0.03 };
    for (int k = 0; k < 2*N_EACH*6; k++) {
        seed_model(15, k/N_EACH);
        double length = between(2, 4), start = between(0.5, 1.2), x = between(0.5, 1.5), w = between(1, 3), mass = between(1, 3);
        double h = k/N_EACH%2 ? 0.2 : 0, off = away[k/N_EACH/2];
        used = 0;
        put("{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 0.1}, {'name': 'c',"
            " 'mass': 2, 'centre': [%.17g, 0], 'inertia': 0.2}, {'name': 'b', 'mass': %.17g, 'centre': [%.17g, %.17g],"
            " 'inertia': 0.3}], 'joints': [", length, mass, cos(start) + x, sin(start) + h);
        put_pin("A", "ground", "a", 0, 0);
        put_pin("B", "a", "b", cos(start), sin(start));
        put_pin("C", "c", "b", length + cos(start), sin(start));
        put_pin("D", "c", "ground", length, 0);
        put("], 'input': {'joint': 'A', 'speed': %.17g}}", -w);
        drun_read_text(&d, text);
        carried_by z = { 0 };
        lw_dynamics *made = NULL;
        d.o.formulation = each[k%N_EACH];
        d.o.intervals = 1;
        d.o.to = (start - off)/w;
        d.e.text[0] = 0;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
        z.d = made;
        CHECK_INT(lw_dynamics_run(made, keep_pins, &z, &d.report, &d.e), LW_OK);
        lw_dynamics_free(made);
        double angle = start + z.turn, s = sin(angle), c = cos(angle), along = mass*w*w*((length - x)*s + h*c)/(length*s);
        CHECK_NEAR(angle, off, 1e-7, 0);
        if (h > 0 && off == 0)                           /* the time of the pole is known to the tolerance */
            CHECK(isnan(z.pin[1].force.x) || fabs(z.pin[1].force.x) > 1e4);
        else {
            CHECK_NEAR(z.pin[1].force.x, -along*c, 0, 1e-6 + (h > 0 ? 1e-6/fabs(off) : 0));
            CHECK_NEAR(z.pin[1].force.y, -along*s, 1e-6, 1e-6);
        }
    }
}

/* ---- two freedoms ------------------------------------------------------------------------------------- */

/* A parallelogram with cranks of length 1 whose coupler, which does not turn, carries a pendulum.  crank: inertia of both
 * about their pins; moment: their mass times distance of the centre; carried: mass of the coupler. */
typedef struct carried { double crank, moment, carried, mass, arm, inertia; } carried;

static lw_status carried_rate(void *context, double t, const double *y, double *dy)
{
    const carried *z = context;
    const double g = 9.81, pull = z->mass*z->arm;
    double a = z->crank + z->carried + z->mass, b = pull*cos(y[0] - y[1]), c = z->inertia + pull*z->arm;
    double p = -g*(z->moment + z->carried + z->mass)*cos(y[0]) - pull*sin(y[0] - y[1])*y[3]*y[3];
    double q = -g*pull*cos(y[1]) + pull*sin(y[0] - y[1])*y[2]*y[2], det = a*c - b*b;
    (void)t;
    dy[0] = y[2];
    dy[1] = y[3];
    dy[2] = (p*c - b*q)/det;
    dy[3] = (a*q - b*p)/det;
    return LW_OK;
}

static lw_status crank_rate(void *context, double t, const double *y, double *g)
{
    (void)context, (void)t;
    *g = y[2];
    return LW_OK;
}

/* Angle at which the crank first turns back when it starts from y at this speed; infinite: not within 1.5 s.  *when: the time. */
static double turns_back_at(const carried *z, const double y[4], double speed, double *when)
{
    lw_ode ode = { .n = 4, .context = (void *)z, .rate = carried_rate, .n_event = 1, .event = crank_rate };
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double work[LW_INTEGRATE_WORK(4, 1)];
    o.relative = o.absolute = 1e-14;
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0, (double[]){ y[0], y[1], speed, y[3] }, NULL), LW_OK);
    while (stop == LW_ODE_STEP && lw_integrate_step(&w, 1.5, &stop, NULL) == LW_OK) {
    }
    *when = w.t;
    return stop == LW_ODE_EVENT ? w.y[0] : INFINITY;
}

/* Write such a model and its equations, with its start in y.  beyond: it starts below the flat posture, and turns back so far
 * behind it, at the time *when; NAN: it starts anywhere. */
static void write_carried(int k, double beyond, carried *z, double y[4], double *when)
{
    double start = between(0.3, 1.2), length = between(1.5, 3), m[2] = { between(0.5, 2), between(0.5, 2) };
    double r[2] = { between(0.2, 0.8), between(0.2, 0.8) }, own[2] = { between(0.05, 0.5), between(0.05, 0.5) };
    double hang = between(-2, 2), at = between(0.2, 1.3), speed = between(1, 5)*(k%2 ? -1 : 1);
    double cx, cy;
    *z = (carried){ .carried = between(0.5, 2), .mass = between(0.3, 1), .arm = between(0.3, 1),
                    .inertia = between(0.02, 0.2) };
    z->crank = own[0] + m[0]*r[0]*r[0] + own[1] + m[1]*r[1]*r[1];
    z->moment = m[0]*r[0] + m[1]*r[1];
    if (!isnan(beyond)) {
        double slow = 0.2, fast = 8;
        memcpy(y, (double[]){ -start, hang, 0, 0 }, 4*sizeof *y);
        for (int i = 0; i < 60; i++)
            *(turns_back_at(z, y, 0.5*(slow + fast), when) < beyond ? &slow : &fast) = 0.5*(slow + fast);
        start = -start, speed = slow;
        CHECK_NEAR(turns_back_at(z, y, slow, when), beyond, 1e-10, 0);
    }
    cx = cos(start), cy = sin(start);
    used = 0;
    put("{'linkwright': 1, 'links': ['ground'");
    for (int i = 0; i < 2; i++)
        put(", {'name': 'crank%d', 'mass': %.17g, 'centre': [%.17g, %.17g], 'inertia': %.17g}", i, m[i],
            i*length + r[i]*cx, r[i]*cy, own[i]);
    put(", {'name': 'coupler', 'mass': %.17g, 'centre': [%.17g, %.17g], 'inertia': 0.3}", z->carried, length/2 + cx,
        cy + 0.1);
    put(", {'name': 'bob', 'mass': %.17g, 'centre': [%.17g, %.17g], 'inertia': %.17g}], 'joints': [", z->mass,
        cx + at + z->arm*cos(hang), cy + z->arm*sin(hang), z->inertia);
    put_pin("A", "ground", "crank0", 0, 0);
    put_pin("B", "ground", "crank1", length, 0);
    put_pin("C", "crank0", "coupler", cx, cy);
    put_pin("D", "crank1", "coupler", length + cx, cy);
    put_pin("P", "coupler", "bob", cx + at, cy);
    put("], 'inputs': [{'joint': 'A', 'speed': %.17g}, {'joint': 'P', 'speed': 0}], 'gravity': [0, -9.81]}", speed);
    memcpy(y, (double[]){ start, hang, speed, 0 }, 4*sizeof *y);
}

/* By how much a small change of the state anywhere on the way from y grows until the time `to`; y is moved there. */
static double growth_of_errors(const carried *z, double y[4], double to)
{
    enum { PLACES = 10 };
    static const double small = 1e-7;
    const lw_ode ode = { .n = 4, .context = (void *)z, .rate = carried_rate };
    double way[PLACES][4], most = 0;
    for (int i = 0; i < PLACES; i++) {
        memcpy(way[i], y, sizeof way[i]);
        drun_exact(&ode, to*i/PLACES, y, to*(i + 1)/PLACES);
    }
    for (int i = 0; i < PLACES; i++)
        for (int j = 0; j < 4; j++) {
            double moved[4];
            memcpy(moved, way[i], sizeof moved);
            moved[j] += small;
            drun_exact(&ode, to*i/PLACES, moved, to);
            most = fmax(most, fabs(moved[0] - y[0])/small);
        }
    return most;
}

/* The crank's turn and speed at the samples of a run of 2 s, and how far one is off in all of them and at the end. */
enum { CARRIED_ROWS = 80 };
typedef struct carried_way { double y[CARRIED_ROWS + 1][4], off, off_at_end; int n; } carried_way;

static lw_status compare_carried(void *context, const lw_moment *m)
{
    carried_way *z = context;
    const double *y = z->y[z->n++];
    z->off_at_end = fmax(fabs(m->q[2] - (y[0] - z->y[0][0])), fabs(m->q[5] - (y[0] - z->y[0][0])));
    z->off = fmax(z->off, fmax(z->off_at_end, fabs(m->v[2] - y[2])/fmax(1, fabs(y[2]))));
    return LW_OK;
}

/* Runs of them, and the error that they may have over the tolerance and the growth of errors. */
static const struct { lw_formulation f; double tolerance, off; } run[] = {
    { LW_FORMULATION_AUTO, 1e-6, 10 }, { LW_FORMULATION_AUTO, 1e-8, 10 }, { LW_FORMULATION_AUTO, 1e-10, 10 },
    { LW_FORMULATION_AUTO, 1e-12, 100 }, { LW_FORMULATION_CVODE, 1e-8, 1000 }, { LW_FORMULATION_GGL, 1e-8, 1000 } };

/* The error falls with the tolerance, over and over singular postures; it is some tolerances times the growth of errors. */
TEST(two_freedoms)
{
    /* a step's error that its estimate missed; steps around a singular posture that ended on the other branch; ways that
     * turn back beside one; a sample within a step over one */
    static const struct { uint64_t seed; int k; } hard[] = { { 99, 268 }, { 99, 48 }, { 5, 29 }, { 5, 131 }, { 31, 153 },
                                                           { 99, 118 } };
    enum { N_HARD = sizeof hard/sizeof *hard };
    int n = models(5);
    for (int i = 0; i < n + N_HARD; i++) {
        int k = i < n ? i : hard[i - n].k;
        carried z;
        carried_way way;
        const lw_ode ode = { .n = 4, .context = &z, .rate = carried_rate };
        double y[4];
        seed_with(i < n ? check_seed() : hard[i - n].seed, 14, k);
        write_carried(k, NAN, &z, y, NULL);
        for (int row = 0; row <= CARRIED_ROWS; row++) {
            memcpy(way.y[row], row ? way.y[row - 1] : y, sizeof y);
            drun_exact(&ode, 2.0*(row - 1)/CARRIED_ROWS, way.y[row], row ? 2.0*row/CARRIED_ROWS : -2.0/CARRIED_ROWS);
        }
        double growth = fmax(1, growth_of_errors(&z, y, 2));
        drun_read_text(&d, text);
        d.o.max_step = 50000;
        d.o.to = 2;
        d.o.intervals = CARRIED_ROWS;
        for (int r = 0; r < 6; r++) {
            OWNED(lw_dynamics) *made = NULL;
            d.o.formulation = run[r].f;
            d.o.relative = d.o.absolute = run[r].tolerance;
            d.e.text[0] = 0;
            double allowed = run[r].off*run[r].tolerance*growth;
            way.off = way.n = 0;
            CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
            CHECK_INT(lw_dynamics_run(made, compare_carried, &way, &d.report, &d.e), LW_OK);
            CHECK_INT(way.n, CARRIED_ROWS + 1);
            CHECK_NEAR(way.off_at_end, 0, allowed, 0);
            CHECK_NEAR(way.off, 0, fmax(3*allowed, 1e-8), 0);         /* 1e-8: of steps over a turn */
        }
    }
}

/* Motions that turn back shortly behind a flat posture, in it, or before it, keep to the tolerance as well. */
TEST(turning_back)
{
    static const double beyond[] = { 0.02, 5e-3, 1e-3, 3e-5, 0, -3e-4, -0.01 };
    enum { N = sizeof beyond/sizeof *beyond };
    for (int k = 0; k < N*models(2); k++) {
        carried z;
        double y[4], start, when;
        seed_model(16, k/N);
        write_carried(k/N, beyond[k%N], &z, y, &when);
        start = y[0];
        double to = when + 0.5, growth = fmax(1, growth_of_errors(&z, y, to));
        drun_read_text(&d, text);
        d.o.max_step = 50000;
        for (int r = 0; r < 6; r++) {
            CHECK_INT(drun_to(&d, run[r].f, run[r].tolerance, to, 20), LW_OK);
            CHECK_INT(d.n_moment, 21);
            CHECK_NEAR(d.q[2], y[0] - start, run[r].off*run[r].tolerance*growth, 0);
            CHECK_NEAR(d.q[5], y[0] - start, run[r].off*run[r].tolerance*growth, 0);
        }
    }
}
