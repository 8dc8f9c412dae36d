/* cli/bench/bench_choice.c - is the formulation that `auto` takes the fastest one at equal error?  Models of every kind by
 * every formulation that can do them, and the ratio of the times. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "base/vec2.h"
#include "catalogues/pages/draw.h"
#include "cli/bench/bench_mbs.h"
#include "cli/program/data.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"

enum { MOMENTS = 100, REPEAT_MAX = 30, TOLERANCES = 16, LEVELS = 4 };

static const double give_up = 30, too_slow = 0.5;         /* [s] for one run: of wall time; of processor time, for its repeats */
static const double level[LEVELS] = { 1e-3, 1e-4, 1e-6, 1e-8 };

/* A model of the examples, or made here.  Links without a mass get 1 kg, models without weight gravity; inputs run freely. */
typedef struct subject {
    const char *name, *file;             /* file of examples/; NULL: made by `make` with n */
    double to;                           /* [s] */
    double decay;                        /* [1/s] about the fastest decay that a damper in each joint adds; 0: none */
    double friction, motor;              /* coefficient in all joints; stall torque over weight times size, at the input */
    double smooth;                       /* speed below which the friction is smoothed [m/s]; 0: set-valued */
    double speed;                        /* of all inputs at the start [rad/s]; 0: what the file says */
    void (*make)(FILE *f, int n);
    int    n;
    double exact;                        /* tolerance of the first reference; 0: 1e-12 */
    bool   hard;                         /* a hard case: a panel in the plot, smaller errors, `capture` too */
} subject;

/* ---- models made here ------------------------------------------------------------------------------------------- */

/* A rope of n links, level, pinned at one end. */
static void rope(FILE *f, int n)
{
    fputs("'gravity': [0, -9.81], 'links': ['ground'", f);
    for (int i = 1; i <= n; i++)
        fprintf(f, ",{'name': 'b%d', 'mass': %.17g, 'centre': [%.17g, 0], 'inertia': %.17g}", i, 1./n, (i - 0.5)/n,
                1./12/n/n/n);
    fputs("], 'joints': [", f);
    for (int i = 1; i <= n; i++)
        fprintf(f, "%s{'name': 'J%d', 'links': ['%s%.0d', 'b%d'], 'at': [%.17g, 0]}", i > 1 ? "," : "", i,
                i > 1 ? "b" : "ground", i - 1, i, (i - 1.)/n);
    fputs("]", f);
}

/* n + 1 cranks on the ground, 1 m apart, their ends joined by n rods; crank i ends at `first`, then `next` + (i - 1) `more` [m]. */
static void cranks(FILE *f, int n, double speed, double first, double next, double more)
{
    fprintf(f, "'gravity': [0, -9.81], 'input': {'joint': 'A0', 'speed': %.17g}, 'links': ['ground'", speed);
    for (int i = 0; i <= n; i++)
        fprintf(f, ",'c%d'", i);
    for (int i = 0; i < n; i++)
        fprintf(f, ",'r%d'", i);
    fputs("], 'joints': [{'name': 'A0', 'links': ['ground', 'c0'], 'at': [0, 0]}", f);
    for (int i = 1; i <= n; i++) {
        double end = next + (i - 1)*more, before = i > 1 ? end - more : first;
        fprintf(f, ",{'name': 'A%d', 'links': ['ground', 'c%d'], 'at': [%d, 0]},"
                "{'name': 'B%d', 'links': ['c%d', 'r%d'], 'at': [%d, %.17g]},"
                "{'name': 'C%d', 'links': ['r%d', 'c%d'], 'at': [%d, %.17g]}", i, i, i, i, i - 1, i - 1, i - 1, before,
                i, i - 1, i, i, end);
    }
    fputs("]", f);
}

/* A crank of 0.3 m that drives n rockers one after another: n dyads. */
static void dyads(FILE *f, int n) { cranks(f, n, -8, 0.3, 0.81, 0.01); }

/* n four-bars in a row, all cranks equal. */
static void row_of_loops(FILE *f, int n) { cranks(f, n, -1, 1, 1, 0); }

/* A pendulum on a pendulum that is 10^n times as heavy. */
static void light_last(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': ['ground', {'name': 'one', 'mass': 1e%d, 'centre': [1, 0]},"
            "{'name': 'two', 'mass': 1, 'centre': [2, 0]}], 'joints': [{'name': 'A', 'links': ['ground', 'one'], 'at': [0, 0]},"
            "{'name': 'B', 'links': ['one', 'two'], 'at': [1, 0]}]", n);
}

/* A loop of massless links that swings a wheel. */
static void massless(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': ['ground', {'name': 'wheel', 'mass': %d, 'centre': [-1, 0], 'inertia': 0.3},"
            "{'name': 'crank', 'mass': 0}, {'name': 'coupler', 'mass': 0}, {'name': 'rocker', 'mass': 0}],"
            "'joints': [{'name': 'W', 'kind': 'f', 'links': ['wheel', 'crank'], 'at': [0, 0]},"
            "{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]}, {'name': 'B', 'links': ['crank', 'coupler'], 'at': [0, 1]},"
            "{'name': 'C', 'links': ['coupler', 'rocker'], 'at': [2.5, 2]},"
            "{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2.5, 0]}], 'input': {'joint': 'A', 'speed': -1}", n);
}

/* A parallelogram whose sides are equal, flat twice in each turn, on a base that swings. */
static void on_a_swing(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': ['ground', {'name': 'base', 'mass': %d, 'centre': [0.5, 0]}, 'c0', 'c1', 'r0'], 'input': "
            "{'joint': 'A0', 'speed': -5}, 'joints': [{'name': 'P', 'links': ['ground', 'base'], 'at': [0.5, 1]}, {'name': 'A0', 'links': ['base', "
            "'c0'], 'at': [0, 0]}, {'name': 'A1', 'links': ['base', 'c1'], 'at': [1, 0]}, {'name': 'B', 'links': ['c0', 'r0'], 'at': [0, 1]}, "
            "{'name': 'C', 'links': ['r0', 'c1'], 'at': [1, 1]}]", n);
}

/* A cart that rolls n metres a second, with a pendulum. */
static void cart(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [0, 0]}, {'name': 'bob', 'mass': 1, 'centre': "
            "[1, 0], 'inertia': 0.1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]}, {'name': 'A', "
            "'links': ['cart', 'bob'], 'at': [0, 0]}], 'input': {'joint': 'S', 'speed': %d}", n);
}

/* A wavy rope of n links falls on a compliant floor. */
static void falling(FILE *f, int n)
{
    fputs("'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], [1, 0]]}]}", f);
    for (int i = 0; i < n; i++) {
        double x = 0.1*i, y = 0.2 + 0.05*sin(0.6*i), next = 0.2 + 0.05*sin(0.6*(i + 1));
        fprintf(f, ",{'name': 'b%d', 'mass': 0.1, 'centre': [%.17g, %.17g], 'inertia': 1e-4, 'shapes': [{'segment': [[%.17g, %.17g], [%.17g, %.17g]], "
                "'radius': 0.005}]}", i, x + 0.05, 0.5*(y + next), x, y, x + 0.1, next);
    }
    fputs("], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', 'b0']}", f);
    for (int i = 1; i < n; i++)
        fprintf(f, ",{'name': 'J%d', 'links': ['b%d', 'b%d'], 'at': [%.17g, %.17g]}", i, i - 1, i, 0.1*i, 0.2 + 0.05*sin(0.6*i));
    fputs("], 'contacts': [", f);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s{'links': ['ground', 'b%d'], 'stiffness': 2000, 'damping': 0.5, 'friction': 0.5, 'friction_speed': 0.05}", i ? "," : "", i);
    fputs("]", f);
}

/* A block on a slope that its friction stops; n: speed below which the friction is smoothed, 10^-n m/s, 0: set-valued. */
static void block(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': ['ground', {'name': 'block', 'mass': 2, 'centre': [0, 0], 'inertia': 0.1}],"
            "'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'block'], 'at': [0, 0], 'along': [0.9210609940028851, "
            "0.3894183423086505], 'friction': {'coefficient': 0.43%s%.0d}}], 'input': {'joint': 'S', 'speed': 3}",
            n ? ", 'speed': 1e-" : "", n);
}

/* A block that a spring pulls along the ground at 0.2 m/s, and that sticks and slips; n: speed of the friction, 10^-n m/s. */
static void pulled(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': ['ground', {'name': 'block', 'mass': 1, 'centre': [0, 0], 'inertia': 0.1}, "
            "{'name': 'puller', 'mass': 1, 'centre': [1, 0], 'inertia': 0.1}], "
            "'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'block'], 'at': [0, 0], 'along': [1, 0], 'friction': {'coefficient': 0.3, 'speed': "
            "1e-%d}}, {'name': 'T', 'kind': 't', 'links': ['ground', 'puller'], 'at': [1, 0], 'along': [1, 0]}], "
            "'inputs': [{'joint': 'T', 'motion': '0.2*t'}], "
            "'springs': [{'links': ['block', 'puller'], 'at': [[0, 0], [1, 0]], 'stiffness': 50}]", n);
}

/* Painleve's rod: its foot slides ahead of it, and friction stops it at once. */
static void rod(FILE *f, int n)
{
    fprintf(f, "'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], [1, 0]]}]}, {'name': 'rod', 'mass': 1, 'centre': "
            "[-0.25, 0.4330127018922193], 'inertia': 0.08333333333333333, 'velocity': [%d, 0], 'shapes': [{'segment': [[0, 0], [-0.5, "
            "0.8660254037844386]]}]}], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', 'rod']}], 'contacts': [{'links': ['ground', 'rod'], "
            "'friction': 2}]", n);
}

static const subject subjects[] = {
    { "pendulum", "pendulum.json", .to = 10 },
    { "N-four-bar, N = 2", "two-four-bars.json", .to = 10, .hard = true },
    { "squeezer", "andrews.json", .to = 0.03 },
    { "slider-crank", "slider-crank.json", .to = 2 },
    { "inverted slider-crank", "inverted-slider-crank.json", .to = 1 },
    { "Hoeken", "hoeken.json", .to = 1, .speed = 5 },
    { "Jansen", "jansen.json", .to = 1 },
    { "Klann", "klann.json", .to = 1 },
    { "geared five-bar", "geared-five-bar.json", .to = 1 },
    { "five-bar", "five-bar.json", .to = 0.5 },
    { "3-RRR", "3-rrr.json", .to = 0.3, .speed = 1 },
    { "SCARA", "scara.json", .to = 1, .speed = 2 },
    { "inversor", "dynamics/inversor.json", .to = 1 },
    { "ladder", "dynamics/falling-ladder.json", .to = 2 },
    { "trebuchet", "dynamics/trebuchet.json", .to = 1 },
    { "governor", "dynamics/governor.json", .to = 2 },
    { "shaken pendulum", "dynamics/shaken-pendulum.json", .to = 2 },
    { "servo arm", "dynamics/servo-arm.json", .to = 1, .hard = true },
    { "boom on oil", "dynamics/boom-cylinder.json", .to = 1 },
    { "slider-crank, decay 1", "slider-crank.json", .to = 2, .decay = 1 },
    { "slider-crank, decay 100", "slider-crank.json", .to = 2, .decay = 100 },
    { "slider-crank, decay 1e5", "slider-crank.json", .to = 2, .decay = 1e5 },
    { "Jansen, decay 10", "jansen.json", .to = 1, .decay = 10 },
    { "Jansen, decay 1e3", "jansen.json", .to = 1, .decay = 1e3 },
    { "five-bar, decay 10", "five-bar.json", .to = 0.5, .decay = 10 },
    { "five-bar, decay 1e3", "five-bar.json", .to = 0.5, .decay = 1e3 },
    { "five-bar, decay 1e5", "five-bar.json", .to = 0.5, .decay = 1e5 },
    { "3-RRR, decay 1e4", "3-rrr.json", .to = 0.3, .decay = 1e4, .speed = 1 },
    { "slider-crank, friction", "slider-crank.json", .to = 2, .friction = 0.1, .motor = 2 },
    { "Jansen, friction", "jansen.json", .to = 1, .friction = 0.05, .motor = 2 },
    { "five-bar, smooth friction", "five-bar.json", .to = 0.5, .friction = 0.1, .smooth = 0.01 },
    { "nine dyads", NULL, .to = 5, .make = dyads, .n = 9 },
    { "nine dyads, decay 1", NULL, .to = 5, .decay = 1, .make = dyads, .n = 9 },
    { "nine dyads, motor and friction", NULL, .to = 5, .friction = 0.05, .motor = 1, .make = dyads, .n = 9, .hard = true },
    { "rope of 10", NULL, .to = 0.3, .make = rope, .n = 10 },
    { "rope of 10, decay 10", NULL, .to = 0.5, .decay = 10, .make = rope, .n = 10 },
    { "rope of 10, decay 1e3", NULL, .to = 0.5, .decay = 1e3, .make = rope, .n = 10 },
    { "rope of 50", NULL, .to = 0.3, .make = rope, .n = 50 },
    { "rope of 50, decay 100", NULL, .to = 0.3, .decay = 100, .make = rope, .n = 50 },
    { "rope of 6, smooth friction", NULL, .to = 2, .friction = 0.3, .smooth = 1e-3, .make = rope, .n = 6 },
    { "rope of 5 comes to rest", NULL, .to = 5, .friction = 2.5, .smooth = 1e-3, .make = rope, .n = 5 },
    { "rope of 2 comes to rest", NULL, .to = 10, .friction = 2.5, .smooth = 1e-4, .make = rope, .n = 2, .hard = true },
    { "block sticks and slips", NULL, .to = 10, .make = pulled, .n = 3, .hard = true },
    { "N-four-bar, N = 15", NULL, .to = 2, .make = row_of_loops, .n = 15 },
    { "N-four-bar, N = 40, decay 1", NULL, .to = 1, .decay = 1, .make = row_of_loops, .n = 40, .hard = true },
    { "elastic slider-crank", "elastic-slider-crank.json", .to = 0.1 },
    { "elastic cantilever", "elastic-cantilever.json", .to = 0.1 },
    { "elastic spin-up", "elastic-spin-up.json", .to = 1 },
    { "slider-crank in space", "space/slider-crank.json", .to = 1 },
    { "Bricard", "space/bricard.json", .to = 5 },
    { "governor in space, dampers", "space/governor.json", .to = 1 },
    { "top", "space/top.json", .to = 1 },
    { "Sarrus", "space/sarrus.json", .to = 1, .hard = true },
    { "arm", "space/arm.json", .to = 1 },
    { "masses 1e8 to 1", NULL, .to = 2, .make = light_last, .n = 8, .hard = true },
    { "massless loop", NULL, .to = 0.4, .make = massless, .n = 1, .hard = true },
    { "block stops, set-valued", NULL, .to = 2, .make = block, .hard = true },
    { "block stops, smoothed", NULL, .to = 2, .make = block, .n = 3, .hard = true },
    { "rhombus on a swing", NULL, .to = 2, .make = on_a_swing, .n = 1, .hard = true },
    { "cart at 100 m/s", NULL, .to = 30, .make = cart, .n = 100, .hard = true },
    { "1000 links fall", NULL, .to = 0.25, .make = falling, .n = 1000, .exact = 1e-8, .hard = true },
    { "N-four-bar, 1000 s", "two-four-bars.json", .to = 1000, .hard = true },
    { "a million periods", "pendulum.json", .to = 2e6, .hard = true },
    { "Painleve's rod", NULL, .to = 0.3, .make = rod, .n = 5, .hard = true },
    { "Newton's cradle", "dynamics/newtons-cradle.json", .to = 2, .hard = true },
    { "rolling wheel", "dynamics/rolling-wheel.json", .to = 1, .hard = true },
    { "rope goes slack", "dynamics/rope.json", .to = 1, .hard = true },
    { "hook holds", "dynamics/hook.json", .to = 1, .hard = true },
    { "walking machine", "dynamics/walking-machine.json", .to = 0.5, .hard = true },
};

/* ---- reading ------------------------------------------------------------------------------------------------------ */

typedef struct scene { bool in_space; lw_model plane; lw_spatial space; } scene;

static double size_of(const lw_model *m)
{
    double most = 0;
    for (int i = 0; i < m->linkage.n_joint; i++)
        for (int j = 0; j < i; j++)
            most = fmax(most, lw_v2_norm(lw_v2_sub(m->linkage.joint[i].at, m->linkage.joint[j].at)));
    return most > 0 ? most : 1;
}

static void give_mass(lw_model *m, int link)
{
    lw_body *b = &m->body[link];
    double n = 0, spread = 0;
    lw_vec2 at[2] = { 0 };
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < m->linkage.n_joint; j++)
            if (m->linkage.joint[j].link[0] == link || m->linkage.joint[j].link[1] == link) {
                lw_vec2 p = m->linkage.joint[j].at;
                at[0] = pass ? at[0] : lw_v2_add(at[0], p);
                n += !pass;
                spread += pass ? lw_v2_dot(lw_v2_sub(p, at[1]), lw_v2_sub(p, at[1]))/n : 0;
                at[1] = lw_v2_scale(at[0], 1/n);
            }
    *b = (lw_body){ .given = true, .mass = 1, .centre = at[1], .inertia = fmax(spread, 1e-3*size_of(m)*size_of(m)) };
}

static lw_status dress(lw_model *m, const subject *s, lw_error *e)
{
    int n_joint = m->linkage.n_joint, has = 0;
    double size = size_of(m), mass = 0;
    for (int i = 0; i < m->linkage.n_link; i++)
        has += m->body[i].given;
    for (int i = 0; i < m->linkage.n_link; i++) {
        if (i != m->linkage.ground && !m->body[i].given && !(m->n_elastic && m->elastic[i].given))
            give_mass(m, i);
        mass += m->body[i].mass/(m->linkage.n_link - 1);
    }
    for (int i = 0; i < m->linkage.n_input && (s->speed != 0 || !has); i++) {
        lw_expression_free(m->motion[i]), m->motion[i] = NULL;
        m->has_speed[i] = m->has_speed[i] || s->speed != 0;
        m->speed[i] = s->speed != 0 ? s->speed : m->speed[i];
    }
    if (!has)
        m->gravity = lw_v2(0, -9.81);
    lw_joint_spring *more = s->decay > 0 ? realloc(m->joint_spring, sizeof *more*(size_t)(m->n_joint_spring + n_joint)) : NULL;
    if (s->decay > 0 && !more)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    m->joint_spring = more ? more : m->joint_spring;
    for (int j = 0; j < n_joint; j++) {
        bool turns = lw_joint_turns(m->linkage.joint[j].kind);
        if (s->decay > 0)
            m->joint_spring[m->n_joint_spring++] = (lw_joint_spring){ .name = "damper", .joint = j,
                                                                      .damping = s->decay*mass*(turns ? size*size/100 : 1) };
        if (s->friction > 0)
            m->friction[j] = (lw_friction){ .coefficient = s->friction, .radius = turns ? 0.02*size : 0, .speed = s->smooth };
    }
    if (s->motor > 0 && (m->motor = malloc(sizeof *m->motor)))
        m->motor[m->n_motor++] = (lw_motor){ .name = "motor", .joint = m->linkage.input[0].joint, .stall = s->motor*mass*9.81*size,
                                            .free_speed = 20 };
    return LW_OK;
}

static lw_status read_subject(const subject *s, scene *out, lw_error *e)
{
    char path[2*CLI_PATH_SIZE], *text = NULL;
    size_t size = 0;
    lw_status st = LW_OK;
    if (s->file) {
        char folder[CLI_PATH_SIZE];
        cli_document_folder(folder, sizeof folder);
        snprintf(path, sizeof path, "%s/examples/%s", folder, s->file);
        st = lw_file_read(path, &text, &size, e);
    } else {
        snprintf(path, sizeof path, "%s", s->name);
        FILE *f = open_memstream(&text, &size);
        if (!f)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        fputs("{'linkwright': 1, ", f);
        s->make(f, s->n);
        fputs("}", f);
        st = fclose(f) == 0 ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
        for (size_t i = 0; i < size; i++)
            text[i] = text[i] == '\'' ? '"' : text[i];
    }
    out->in_space = s->file && strncmp(s->file, "space/", 6) == 0;
    if (st == LW_OK)
        st = out->in_space ? lw_spatial_read(text, size, path, &out->space, e) : lw_model_read(text, size, path, &out->plane, e);
    if (st == LW_OK && !out->in_space && (st = dress(&out->plane, s, e)) != LW_OK)
        lw_model_free(&out->plane);
    free(text);
    return st;
}

static void free_scene(scene *s)
{
    if (s->in_space)
        lw_spatial_free(&s->space);
    else
        lw_model_free(&s->plane);
}

/* ---- runs --------------------------------------------------------------------------------------------------------- */

/* q[k*n + i] at moment k; by: the formulation at the end of the run. */
typedef struct motion { int n, n_moment; double *q; lw_formulation by; } motion;

static lw_status keep(void *context, const lw_moment *m)
{
    motion *k = context;
    if (k->q)
        memcpy(k->q + (size_t)k->n_moment*(size_t)k->n, m->q, (size_t)k->n*sizeof *k->q);
    k->n_moment++;
    return LW_OK;
}

static lw_status make(const scene *s, const lw_dynamics_options *o, lw_dynamics **d, lw_error *e)
{
    return s->in_space ? lw_dynamics_make_spatial(&s->space, o, d, e) : lw_dynamics_make(&s->plane, o, d, e);
}

/* Run once.  k->q, if given, has room for all moments; *seconds is lowered to the processor time of the run. */
static lw_status run_once(const scene *s, const lw_dynamics_options *o, motion *k, cli_mbs_row *row, lw_error *e)
{
    lw_dynamics *d;
    lw_dynamics_report r = { 0 };
    double start = lw_clock_cpu();
    lw_status st = make(s, o, &d, e);
    double made = lw_clock_cpu();
    if (st != LW_OK)
        return st;
    k->n_moment = 0;
    st = lw_dynamics_run(d, keep, k, &r, e);
    if (row && st == LW_OK) {
        row->make = fmin(row->make, made - start);
        row->seconds = fmin(row->seconds, lw_clock_cpu() - made);
        row->energy = r.energy_error/r.energy_scale;
        row->steps = r.steps, row->rates = r.rates;
    }
    k->by = r.formulation;
    lw_dynamics_free(d);
    return st == LW_OK ? cli_mbs_own(&r, o, e) : st;
}

/* Greatest difference of a coordinate.  In space a body has a place and a quaternion, which stands for the same turn with either
 * sign. */
static double apart(const motion *a, const motion *b, bool in_space)
{
    double most = 0;
    for (int i = 0; i < (MOMENTS + 1)*a->n; i++) {
        double sign = 1;
        if (in_space && i % 7 > 2) {
            const double *p = a->q + i - i % 7 + 3, *q = b->q + i - i % 7 + 3;
            sign = p[0]*q[0] + p[1]*q[1] + p[2]*q[2] + p[3]*q[3] < 0 ? -1 : 1;
        }
        most = fmax(most, fabs(a->q[i] - sign*b->q[i]));
    }
    return most;
}

/* The runs of one model. */
typedef struct study {
    const subject *s;
    scene scene;
    int    n_formulation;
    lw_formulation formulation[16];
    motion got, exact[2];                 /* exact[1]: by another formulation than exact[0] */
    lw_formulation by[2];
    int    n_exact;
    double known;                         /* what the two differ by */
    lw_formulation chosen[TOLERANCES];    /* by `auto` at 1e-k, at the end of its run; AUTO: not run */
} study;

static lw_dynamics_options options(const study *y, lw_formulation f, double tolerance)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.formulation = f;
    o.to = y->s->to;
    o.intervals = MOMENTS;
    o.relative = o.absolute = tolerance;
    o.max_step = 200000;
    o.stop = cli_stop_flag();
    o.until = lw_clock_wall() + give_up;
    return o;
}

/* Which formulations can do the model? */
static lw_status look(study *y, lw_error *e)
{
    lw_dynamics *d;
    lw_dynamics_options first = options(y, LW_FORMULATION_AUTO, 1e-6);
    lw_status st = make(&y->scene, &first, &d, e);
    if (st == LW_OK) {
        y->got.n = y->scene.in_space ? lw_dynamics_space(d)->n_q : lw_dynamics_system(d)->n_q;
        lw_dynamics_free(d);
    }
    for (int f = 1; f <= LW_FORMULATION_GGL && st == LW_OK; f++) {
        lw_error why = { 0 };
        lw_dynamics_options o = options(y, (lw_formulation)f, 1e-6);
        lw_dynamics_report r = { 0 };
        o.to *= 1e-6;                        /* a run tells whether it smooths friction that is set-valued */
        if ((f == LW_FORMULATION_CAPTURE && !y->s->hard) || make(&y->scene, &o, &d, &why) != LW_OK)
            continue;
        lw_dynamics_run(d, NULL, NULL, &r, &why);
        lw_dynamics_free(d);
        if (!r.smooth_friction)
            y->formulation[y->n_formulation++] = (lw_formulation)f;
    }
    for (int i = 0; i < 3 && st == LW_OK; i++) {
        motion *m = i ? &y->exact[i - 1] : &y->got;
        m->n = y->got.n;
        m->q = malloc((size_t)(m->n*(MOMENTS + 1))*sizeof *m->q);
        st = m->q ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    return st;
}

/* References by two formulations, as accurate as they are.  Where the second is by a multistep method, it is the one that agrees best
 * with the first. */
static void find_exact(study *y)
{
    static const struct { lw_formulation by; double tolerance; bool multistep; } order[] = {
        { LW_FORMULATION_INDEX1, 1e-12, false }, { LW_FORMULATION_REDUCED, 1e-12, false }, { LW_FORMULATION_RECURSIVE, 1e-12, false },
        { LW_FORMULATION_RADAU, 1e-12, false }, { LW_FORMULATION_QUADRATURE, 1e-12, false }, { LW_FORMULATION_GGL, 1e-11, true },
        { LW_FORMULATION_CVODE, 1e-11, true }, { LW_FORMULATION_CVODE, 1e-13, true } };
    bool rough = true;
    for (size_t i = 0; i < sizeof order/sizeof *order && rough && !cli_interrupted(); i++)
        for (int k = 0; k < y->n_formulation; k++) {
            lw_error e = { 0 };
            bool second = y->n_exact > 0;
            lw_dynamics_options o = options(y, order[i].by, second || y->s->exact == 0 ? order[i].tolerance : y->s->exact);
            motion *got = second ? &y->got : &y->exact[0];
            o.until += 3*give_up;
            if (y->formulation[k] != order[i].by || (second && y->by[0] == order[i].by) || run_once(&y->scene, &o, got, NULL, &e) != LW_OK)
                continue;
            double off = second ? apart(got, &y->exact[0], y->scene.in_space) : 0;
            rough = !second || order[i].multistep;
            if (second && y->n_exact == 2 && off >= y->known)
                continue;
            if (second) {
                motion swap = y->exact[1];
                y->exact[1] = y->got, y->got = swap, y->known = off;
            }
            y->by[second] = order[i].by, y->n_exact = 1 + second;
        }
}

/* The rows of one formulation. */
static lw_status run_formulation(cli_mbs *b, study *y, lw_formulation f, lw_error *e)
{
    int failed = 0;
    double least = y->n_exact > 1 ? 0 : y->s->exact > 0 ? 10*y->s->exact : 1e-11;      /* of a run that may be compared with itself */
    double enough = y->s->hard ? 1e-11 : 0.5*level[LEVELS - 1];
    for (int k = b->loosest; k <= b->tightest && pow(10, -k) > 0.9*least && failed < 2 && !cli_interrupted(); k++) {
        lw_error why = { 0 };
        cli_mbs_row *row = cli_mbs_add(b, y->s->name, lw_formulation_name(f), pow(10, -k));
        if (!row)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        lw_dynamics_options o = options(y, f, row->tolerance);
        lw_status st = run_once(&y->scene, &o, &y->got, NULL, &why);
        row->error = st == LW_OK && y->n_exact > 0 ? apart(&y->got, &y->exact[y->n_exact > 1 && y->by[0] == y->got.by], y->scene.in_space) : NAN;
        row->known = y->s->hard ? y->known : NAN;
        if (f == LW_FORMULATION_AUTO)
            y->chosen[k] = y->got.by;
        double until = lw_clock_wall() + b->time;
        motion none = { 0 };
        for (int i = 0; i < REPEAT_MAX && st == LW_OK && (i == 0 || lw_clock_wall() < until) && !cli_interrupted(); i++)
            o.until = lw_clock_wall() + give_up, st = run_once(&y->scene, &o, &none, row, &why);
        failed = st == LW_OK ? 0 : failed + 1;
        if (st != LW_OK)
            snprintf(row->note, sizeof row->note, "%.*s", (int)strcspn(why.text, "\n"), why.text);
        if (row->seconds > (y->s->hard ? 4 : 1)*too_slow || row->error < enough)
            break;
    }
    return LW_OK;
}

/* Least time of formulation f for an error, between two tolerances by their logarithms, unless `auto` takes two formulations at them. */
static double time_for(const cli_mbs *b, const study *y, lw_formulation f, double error)
{
    double least = INFINITY;
    for (int i = 0; i < b->n; i++) {
        const cli_mbs_row *r = &b->row[i], *last = i ? r - 1 : r;
        int k = (int)lrint(-log10(r->tolerance));
        if (strcmp(r->problem, y->s->name) || strcmp(r->solver, lw_formulation_name(f)))
            continue;
        if (r->error <= error)
            least = fmin(least, r->seconds);
        bool both = last != r && last->problem == r->problem && strcmp(last->solver, r->solver) == 0 && last->error > error && r->error < error;
        if (both && r->error > 0 && (f || y->chosen[k - 1] == y->chosen[k]))
            least = fmin(least, exp(log(last->seconds) + log(r->seconds/last->seconds)*log(last->error/error)/log(last->error/r->error)));
    }
    return least;
}

static void compare(const cli_mbs *b, const study *y, double *worst)
{
    char took[80] = "";
    for (int k = b->loosest; k <= b->tightest; k++)
        if (y->chosen[k] && (k == b->loosest || y->chosen[k] != y->chosen[k - 1]))
            snprintf(took + strlen(took), sizeof took - strlen(took), "%s%s", *took ? ", " : "", lw_formulation_name(y->chosen[k]));
    printf("| %s | %s |", y->s->name, took);
    for (int i = 0; i < LEVELS; i++) {
        double own = time_for(b, y, LW_FORMULATION_AUTO, level[i]), best = INFINITY;
        lw_formulation by = LW_FORMULATION_AUTO;
        bool own_is_one = strchr(took, ',') == NULL;     /* then the rows of that formulation are the same runs, measured again */
        for (int k = 0; k < y->n_formulation; k++) {
            double t = time_for(b, y, y->formulation[k], level[i]);
            if (y->formulation[k] == LW_FORMULATION_CAPTURE)
                continue;
            if (own_is_one && y->formulation[k] == y->chosen[b->loosest]) {
                own = fmin(own, t);
                continue;
            }
            by = t < best ? y->formulation[k] : by;
            best = fmin(best, t);
        }
        best = fmin(best, own);
        if (!isfinite(best) || level[i] < 3*y->known)
            fputs(" - |", stdout);
        else if (own <= best)
            printf(" %.3g |", 1e3*own);
        else
            printf(" %.3g, %.2f x %s |", 1e3*own, own/best, lw_formulation_name(by));
        if (isfinite(best) && level[i] >= 3*y->known)
            *worst = fmax(*worst, own/best);
    }
    printf(" %.0e |\n", y->known);
}

/* Save the plot of the hard cases: a panel for each, with error over time of every formulation that can do it. */
static lw_status save_hard(const cli_mbs *b, const char *folder, lw_error *e)
{
    enum { COLUMNS = 3, FORMULATIONS = LW_FORMULATION_GGL + 1 };
    char path[CLI_PATH_SIZE];
    lw_series (*series)[FORMULATIONS] = calloc(LW_PANEL_MAX, sizeof *series);
    double *numbers = malloc(sizeof *numbers*(2*(size_t)b->n + 1));
    lw_plot plot[LW_PANEL_MAX] = { { .width = 1100, .columns = COLUMNS } };
    lw_level known[LW_PANEL_MAX];
    bool taken[FORMULATIONS] = { false };
    int n = 0;
    for (int i = 0; i < b->n && series && numbers; i++) {
        const cli_mbs_row *r = &b->row[i];
        int f = 0;
        if (isnan(r->known))
            continue;
        if (n == 0 || strcmp(plot[n - 1].title, r->problem)) {
            if (n == LW_PANEL_MAX)
                break;
            plot[n].title = r->problem, plot[n].log_x = plot[n].log_y = true;
            plot[n].series = series[n], plot[n].n_series = FORMULATIONS;
            plot[n].y_label = n % COLUMNS == 0 ? "greatest error" : NULL;
            known[n] = (lw_level){ "", r->known };
            plot[n].level = &known[n], plot[n].n_level = r->known > 0;
            for (int k = 0; k < FORMULATIONS; k++)
                series[n][k] = (lw_series){ .name = "", .style = k ? LW_SERIES_LINE : LW_SERIES_POINTS };
            n++;
        }
        while (f < FORMULATIONS - 1 && strcmp(r->solver, lw_formulation_name((lw_formulation)f)))
            f++;
        lw_series *to = &series[n - 1][f];
        to->x = to->n ? to->x : numbers + i, to->y = to->n ? to->y : numbers + b->n + i;
        to->n++, taken[f] = true;
        numbers[i] = r->seconds, numbers[b->n + i] = r->error < 1e-16 ? 1e-16 : r->error;
    }
    for (int i = n > COLUMNS ? n - COLUMNS : 0; i < n; i++)
        plot[i].x_label = "processor time [s]";
    for (int f = 0; f < FORMULATIONS && n > 0; f++)          /* one legend for all */
        if (taken[f])
            series[n > COLUMNS ? COLUMNS - 1 : n - 1][f].name = lw_formulation_name((lw_formulation)f);
    snprintf(path, sizeof path, "%s/mbs-choice.svg", folder);
    lw_status st = !series || !numbers ? lw_error_set(e, LW_E_MEMORY, "out of memory") : n ? lw_draw_plots(n, plot, path, e) : LW_OK;
    free(series), free(numbers);
    return st == LW_NOTHING ? LW_OK : st;
}

/* Does an entry of the list take the model? */
static bool is_asked(const char *cases, const subject *s)
{
    bool asked = false;
    for (; *cases && !asked; cases += strcspn(cases, ","), cases += *cases == ',') {
        char text[64];
        int length = (int)strcspn(cases, ",");
        snprintf(text, sizeof text, "%.*s", length > 7 ? length - 7 : 0, cases + 7);
        asked = strncmp(cases, "choice", 6) == 0 && (length == 6 || strstr(s->name, text) || (s->hard && strcmp(text, "hard") == 0));
    }
    return asked;
}

lw_status cli_mbs_choice(cli_mbs *b, const char *cases, const char *folder, lw_error *e)
{
    lw_status st = LW_OK;
    double worst = 1;
    int n = 0;
    for (size_t i = 0; i < sizeof subjects/sizeof *subjects; i++)
        n += is_asked(cases, &subjects[i]);
    if (n == 0)
        return lw_error_set(e, LW_E_ARG, "no model of choice has this text in its name");
    fputs("Time of `auto` [ms] for an error of, and how many times that of the fastest where that is another one:\n\n"
          "| model | `auto` takes | 0.001 | 0.0001 | 1e-06 | 1e-08 | references differ |\n|---|---|---|---|---|---|---|\n", stdout);
    for (size_t i = 0; i < sizeof subjects/sizeof *subjects && st == LW_OK && !cli_interrupted(); i++) {
        if (!is_asked(cases, &subjects[i]))
            continue;
        study *y = calloc(1, sizeof *y);
        if (!y)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        y->s = &subjects[i];
        st = read_subject(y->s, &y->scene, e);
        if (st == LW_OK) {
            st = look(y, e);
            if (st == LW_OK)
                find_exact(y);
            for (int k = 0; k <= y->n_formulation && st == LW_OK; k++)
                st = run_formulation(b, y, k ? y->formulation[k - 1] : LW_FORMULATION_AUTO, e);
            if (st == LW_OK)
                compare(b, y, &worst);
            fflush(stdout);
            free_scene(&y->scene);
        }
        free(y->got.q), free(y->exact[0].q), free(y->exact[1].q), free(y);
    }
    if (st == LW_OK)
        printf("\nWorst ratio: %.2f\n\n", worst);
    return st == LW_OK && folder ? save_hard(b, folder, e) : st;
}
