/* linkwright profile - motion from one state to another: in least time under limits, or by a law. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/suggest.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/profile_cycle.h"
#include "cli/program/json.h"
#include "cli/program/output.h"

typedef struct settings {
    const char *from, *to, *speed, *acceleration, *jerk, *law, *plot;
    double      duration, frequency, swing, power, mass, dwell;
    int         rows;
    bool        straight;
} settings;

static const cli_option options[] = {
    { "from-state", 0, CLI_TEXT, offsetof(settings, from), "V,A", "0,0", "speed and acceleration at the start", 0, 0, NULL, NULL },
    { "to-state", 0, CLI_TEXT, offsetof(settings, to), "V,A", "0,0", "speed and acceleration at the end", 0, 0, NULL, NULL },
    { "speed-limit", 0, CLI_TEXT, offsetof(settings, speed), "V|MIN:MAX", NULL,
      "limit of the speed, in both directions or from MIN (negative) to MAX", 0, 0, NULL, NULL },
    { "acceleration-limit", 0, CLI_TEXT, offsetof(settings, acceleration), "A|MIN:MAX", NULL, "limit of the acceleration", 0, 0, NULL, NULL },
    { "jerk-limit", 0, CLI_TEXT, offsetof(settings, jerk), "J|MIN:MAX", NULL, "limit of the jerk", 0, 0, NULL, NULL },
    { "law", 0, CLI_TEXT, offsetof(settings, law), "NAME", NULL,
      "a law of motion instead of the quickest motion: 345, 4567, cycloid, modified-sine, modified-trapezoid, havsin, "
      "step (or copper-loss), trapezoid, triangle (or bang-bang); from rest to rest", 0, 0, NULL, "from-state" },
    { "duration", 0, CLI_REAL, offsetof(settings, duration), "T", NULL,
      "take just T seconds; without it, the least time within the limits", 1e-12, 1e12, NULL, NULL },
    { "frequency", 0, CLI_REAL, offsetof(settings, frequency), "F", NULL,
      "leave an oscillation of F Hz at rest at the end: the acceleration rises over whole periods of it; from rest to "
      "rest", 1e-9, 1e9, "acceleration-limit", "law" },
    { "swing", 0, CLI_REAL, offsetof(settings, swing), "F", NULL,
      "also print the amplitude of an oscillation of F Hz after the motion", 1e-9, 1e9, NULL, "law" },
    { "power", 0, CLI_REAL, offsetof(settings, power), "P", NULL,
      "limit of the power that moves the mass: sets the acceleration for the least time from rest to rest", 1e-12, 1e15, "mass", "law" },
    { "mass", 0, CLI_REAL, offsetof(settings, mass), "M", NULL, "the mass that is moved", 1e-15, 1e15, "power", NULL },
    { "dwell", 0, CLI_REAL, offsetof(settings, dwell), "T", "0", "rest of T seconds after each of several moves", 0, 1e12, NULL, "law" },
    { "straight", 0, CLI_FLAG, offsetof(settings, straight), NULL, NULL,
      "several axes move along a straight line, in phase; without it they begin and end together", 0, 0, NULL, NULL },
    { "steps", 'n', CLI_INT, offsetof(settings, rows), "N", "0",
      "print N + 1 rows of a table (CSV: t,x,v,a,j) instead of the summary", 0, 100000000, NULL, NULL },
    { "plot", 'p', CLI_PLOT, offsetof(settings, plot), "FILE", NULL,
      "draw way, speed, acceleration and jerk over time (.svg, .pdf, .png)", 0, 0, NULL, NULL },
    { .name = NULL }
};

/* One motion of one of the two sorts. */
typedef struct motion {
    int            law;                /* -1: by phases                                           */
    double         way, duration;
    lw_profile     profile;
    lw_axis_limits limits, reached;
    double         rms;                /* of the acceleration                                     */
} motion;

static void at(const motion *m, double t, double out[4])
{
    if (m->law < 0) {
        lw_axis_state s = lw_profile_at(&m->profile, t, &out[3]);
        out[0] = s.x, out[1] = s.v, out[2] = s.a;
        return;
    }
    lw_motion_law_at(m->law, t/m->duration, out);
    for (int d = 0; d < 4; d++)
        out[d] *= m->way/pow(m->duration, d);
}

static lw_status read_pair(const char *name, const char *text, double *a, double *b, lw_error *e)
{
    char *end;
    *a = strtod(text, &end);
    bool fine = end != text && *end == ',';
    if (fine) {
        const char *second = end + 1;
        *b = strtod(second, &end);
        fine = end != second && !*end && isfinite(*a) && isfinite(*b);
    }
    return fine ? LW_OK : lw_error_set(e, LW_E_ARG, "--%s is \"%.80s\"; expected speed and acceleration, like 0.5,0", name, text);
}

/* "V" or "MIN:MAX"; text NULL: no limit. */
static lw_status read_limit(const char *name, const char *text, double limit[2], lw_error *e)
{
    limit[0] = -INFINITY, limit[1] = INFINITY;
    if (!text)
        return LW_OK;
    char *end;
    double first = strtod(text, &end), last = first;
    bool fine = end != text;
    if (fine && *end == ':') {
        const char *second = end + 1;
        last = strtod(second, &end);
        fine = end != second;
    } else
        first = -first;
    limit[0] = first, limit[1] = last;
    if (fine && !*end && first < last && isfinite(first) && isfinite(last))
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "--%s is \"%.80s\"; expected a positive number, or MIN:MAX like -2:3", name, text);
}

static lw_status make_law(const settings *o, motion *m, lw_error *e)
{
    const lw_motion_law *law;
    const char *names[16];
    int n = 0;
    for (; (law = lw_motion_law_get(n)); n++)
        names[n] = law->name;
    m->law = lw_motion_law_find(o->law);
    if (m->law < 0) {
        const char *near = lw_suggest(o->law, names, n);
        return lw_error_set(e, LW_E_ARG, "--law: there is no law \"%.40s\"%s%s; linkwright help profile lists them",
                            o->law,
                            near ? ", did you mean " : "", near ? near : "");
    }
    law = lw_motion_law_get(m->law);
    double s = fabs(m->way), T = 0;
    for (int side = 0; side < 2; side++) {                 /* speed has one sign; acceleration and jerk have both */
        if ((side == 1) == (m->way > 0))
            T = fmax(T, s*law->speed_peak/fabs(m->limits.v[side]));
        T = fmax(T, sqrt(s*law->acceleration_peak/fabs(m->limits.a[side])));
        if (isfinite(m->limits.j[side]))
            T = fmax(T, pow(s*law->jerk_peak/fabs(m->limits.j[side]), 1/3.0));
    }
    if (isinf(T))
        return lw_error_set(e, LW_E_ARG, "--law %s: the acceleration steps, so that no limit of jerk can be kept; "
            "leave out --jerk-limit, or take cycloid, 345, modified-sine, ...", law->name);
    if (T == 0 && !(o->duration > 0))
        return lw_error_set(e, LW_E_ARG, "--law %s needs --duration, or a limit of speed, acceleration or jerk", law->name);
    if (o->duration > 0 && o->duration < T*(1 - 1e-12))
        return lw_error_set(e, LW_NOTHING, "the law %s needs at least %.9g s within these limits, not %g s", law->name, T, o->duration);
    m->duration = o->duration > 0 ? o->duration : T;
    double v = m->way*law->speed_peak/m->duration, a = s*law->acceleration_peak/pow(m->duration, 2);
    double j = s*law->jerk_peak/pow(m->duration, 3);
    m->reached = (lw_axis_limits){ { fmin(v, 0), fmax(v, 0) }, { -a, a }, { -j, j } };
    m->rms = s/pow(m->duration, 2)*sqrt(law->copper_loss);
    return LW_OK;
}

/* Root mean square of the acceleration, exact: it is linear in each phase.  In a power of two as unit: no square leaves the
 * range of numbers. */
static double rms_of(const lw_profile *p)
{
    double sum = 0, peak = 0;
    int unit;
    for (int i = 0; i <= p->n; i++)
        peak = fmax(peak, fabs(p->at[i].a));
    (void)frexp(peak, &unit);
    for (int i = 0; i < p->n; i++) {
        double d = p->t[i + 1] - p->t[i], a = ldexp(p->at[i].a, -unit);
        double b = p->jerk[i] != 0 ? ldexp(p->at[i + 1].a, -unit) : a;
        sum += d*(a*a + a*b + b*b)/3;
    }
    return p->duration > 0 ? ldexp(sqrt(sum/p->duration), unit) : 0;
}

static lw_status make_motion(const settings *o, motion *m, lw_error *e)
{
    lw_axis_state from = { 0 }, to = { .x = m->way };
    lw_status s = read_limit("speed-limit", o->speed, m->limits.v, e);
    if (s == LW_OK)
        s = read_limit("acceleration-limit", o->acceleration, m->limits.a, e);
    if (s == LW_OK)
        s = read_limit("jerk-limit", o->jerk, m->limits.j, e);
    if (s == LW_OK)
        s = read_pair("from-state", o->from, &from.v, &from.a, e);
    if (s == LW_OK)
        s = read_pair("to-state", o->to, &to.v, &to.a, e);
    if (s != LW_OK)
        return s;
    if ((o->frequency > 0 || o->power > 0) && (from.v != 0 || from.a != 0 || to.v != 0 || to.a != 0))
        return lw_error_set(e, LW_E_ARG,
                            "--frequency and --power are for motions from rest to rest; leave out --from-state and --to-state");
    if (o->law)
        return make_law(o, m, e);
    if (o->power > 0 && m->way != 0)
        lw_profile_limit_power(m->way, o->power, o->mass, &m->limits);
    if (o->frequency > 0)
        lw_profile_limit_frequency(m->way, o->frequency, &m->limits);
    m->law = -1;
    s = o->duration > 0 ? lw_profile_make_timed(from, to, &m->limits, o->duration, &m->profile, NULL, e)
                        : lw_profile_make(from, to, &m->limits, 0, &m->profile, e);
    m->duration = m->profile.duration;
    m->reached = lw_profile_extremes(&m->profile);
    m->rms = rms_of(&m->profile);
    return s;
}

/* Swing that an undamped oscillation of frequency f has after the motion, over its way: exact integral of the
 * acceleration with e^(i w t), phase by phase. */
static double swing(const motion *m, double f)
{
    double w = 2*LW_PI*f, re = 0, im = 0;
    const lw_profile *p = &m->profile;
    for (int i = 0; i < p->n; i++) {
        double a = p->at[i].a, j = p->jerk[i], b = j != 0 ? p->at[i + 1].a : a;
        double c0 = cos(w*p->t[i]), s0 = sin(w*p->t[i]), c1 = cos(w*p->t[i + 1]), s1 = sin(w*p->t[i + 1]);
        re += (b*s1 - a*s0)/w + j*(c1 - c0)/(w*w);
        im += (a*c0 - b*c1)/w + j*(s1 - s0)/(w*w);
    }
    return hypot(re, im)/w;
}

static void write_rows(FILE *f, const motion *m, int n)
{
    fputs("t,x,v,a,j\n", f);
    for (int i = 0; i <= n && !cli_interrupted(); i++) {
        double t = m->duration*i/n, x[4];
        at(m, i == n ? m->duration*(1 - 1e-15) : t, x);
        fprintf(f, "%.12g,%.12g,%.12g,%.12g,%.12g\n", t, i == n ? m->way : x[0], x[1], x[2], x[3]);
    }
}

static void range(FILE *f, const char *name, const double value[2], const double limit[2])
{
    double shown[2], size = fmax(fabs(value[0]), fabs(value[1]));
    for (int i = 0; i < 2; i++)
        shown[i] = fabs(value[i]) < 1e-12*size ? 0 : value[i];             /* rounding is no speed */
    fprintf(f, "%-14s%.9g to %.9g", name, shown[0], shown[1]);
    if (isfinite(limit[0]) || isfinite(limit[1]))
        fprintf(f, "   (limits %g to %g)", limit[0], limit[1]);
    fputc('\n', f);
}

static void write_text(FILE *f, const motion *m, double frequency)
{
    fprintf(f, "%-14s%.12g s\n", "duration", m->duration);
    if (m->law >= 0)
        fprintf(f, "%-14s%s: %s\n", "law", lw_motion_law_get(m->law)->name, lw_motion_law_get(m->law)->words);
    range(f, "speed", m->reached.v, m->limits.v);
    range(f, "acceleration", m->reached.a, m->limits.a);
    range(f, "jerk", m->reached.j, m->limits.j);
    fprintf(f, "%-14s%.9g\n", "a, rms", m->rms);
    if (m->way != 0 && m->duration > 0)
        fprintf(f, "%-14s%.6g   (integral of a^2 T^3/way^2; 12 is the least from rest to rest)\n", "copper loss",
                pow(m->rms*m->duration*m->duration/m->way, 2));
    if (frequency > 0)
        fprintf(f, "%-14s%.3g of an oscillation of %g Hz at the end\n", "swing", swing(m, frequency), frequency);
    if (m->law < 0)
        fprintf(f, "%-14s%s\n", "phases", "from t, duration, x, v, a, jerk");
    for (int i = 0; i < m->profile.n && m->law < 0; i++) {
        const lw_axis_state *s = &m->profile.at[i];
        fprintf(f, "  %-14.9g %-14.9g %-14.9g %-14.9g %-14.9g %.9g\n", m->profile.t[i],
                m->profile.t[i + 1] - m->profile.t[i],
                s->x, s->v, s->a, m->profile.jerk[i]);
    }
}

static void write_json(FILE *f, const motion *m, double frequency, int n)
{
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    cli_json_real(&j, "way", m->way);
    cli_json_real(&j, "duration", m->duration);
    cli_json_text(&j, "law", m->law < 0 ? "phases" : lw_motion_law_get(m->law)->name);
    cli_json_reals(&j, "speed", m->reached.v, 2);
    cli_json_reals(&j, "acceleration", m->reached.a, 2);
    cli_json_reals(&j, "jerk", m->reached.j, 2);
    cli_json_real(&j, "acceleration_rms", m->rms);
    if (frequency > 0)
        cli_json_real(&j, "swing", swing(m, frequency));
    if (m->law < 0) {
        cli_json_array(&j, "phases");
        for (int i = 0; i < m->profile.n; i++) {
            const lw_axis_state *s = &m->profile.at[i];
            cli_json_reals(&j, NULL, (double[]){ m->profile.t[i], s->x, s->v, s->a, m->profile.jerk[i] }, 5);
        }
        cli_json_end(&j);
    }
    if (n > 0) {
        cli_json_array(&j, "rows");
        for (int i = 0; i <= n && !cli_interrupted(); i++) {
            double x[5] = { m->duration*i/n };
            at(m, i == n ? m->duration*(1 - 1e-15) : x[0], x + 1);
            cli_json_reals(&j, NULL, x, 5);
        }
        cli_json_end(&j);
    }
    cli_json_end(&j);
}

static lw_status draw(const motion *m, const char *path, lw_error *e)
{
    enum { N = 2000 };
    static const char *const label[4] = { "way", "speed [1/s]", "acceleration [1/s^2]", "jerk [1/s^3]" };
    double *v = malloc(5*(N + 1)*sizeof *v);
    if (!v)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_series series[4];
    lw_plot plot[4];
    for (int i = 0; i <= N; i++) {
        double x[4];
        v[i] = m->duration*i/N;
        at(m, i == N ? m->duration*(1 - 1e-15) : v[i], x);
        for (int d = 0; d < 4; d++)
            v[(d + 1)*(N + 1) + i] = x[d];
    }
    for (int d = 0; d < 4; d++) {
        series[d] = (lw_series){ .name = "", .n = N + 1, .x = v, .y = v + (d + 1)*(N + 1) };
        plot[d] = (lw_plot){ .y_label = label[d], .x_label = d == 3 ? "time [s]" : NULL, .n_series = 1,
                             .series = &series[d] };
    }
    lw_status s = lw_draw_plots(4, plot, path, e);
    free(v);
    return s;
}

/* The i-th of a list "3,2,1", or the one that counts for all. */
static const char *item_of(const char *list, int i, int *length)
{
    const char *at = list;
    for (; i > 0 && strchr(list, ','); i--) {
        at = strchr(at, ',');
        if (!at++)
            return NULL;
    }
    *length = (int)strcspn(at, ",");
    return at;
}

/* Several moves, each of one axis or of several that begin and end together, are a work cycle. */
static int run_moves(const cli_call *call)
{
    const settings *o = call->settings;
    static const char *const others[] = { "from-state", "to-state", "law", "frequency", "swing", "power", "mass" };
    const char *keys[] = { "speed", "acceleration", "jerk" }, *limits[] = { o->speed, o->acceleration, o->jerk }, *at;
    char *text = NULL, *end;
    size_t size = 0;
    int n = 1, length = 0;
    for (size_t i = 0; i < sizeof others/sizeof *others; i++)
        if (cli_given(&call->parsed, others[i]))
            return cli_usage(call, "--%s is for a single move of a single axis", others[i]);
    for (const char *c = call->parsed.word[0]; *c; c++)
        n += *c == ',';
    double *place = calloc((size_t)n, sizeof *place);
    FILE *f = place ? open_memstream(&text, &size) : NULL;
    if (!f) {
        free(place);
        return cli_fail(call, &(lw_error){ .status = LW_E_MEMORY, .text = "out of memory" });
    }
    fputs("{\"linkwright-cycle\": 1, \"axes\": [", f);
    bool fine = true;
    for (int i = 0; i < n && fine; i++) {
        fprintf(f, "%s{\"name\": \"%d\"", i ? ", " : "", i + 1);
        for (int k = 0; k < 3 && fine; k++)
            if (limits[k]) {
                char one[64];
                double limit[2];
                at = item_of(limits[k], i, &length);
                snprintf(one, sizeof one, "%.*s", at ? length : 0, at ? at : "");
                fine = read_limit(keys[k], one, limit, NULL) == LW_OK && limit[0] < 0 && limit[1] > 0;
                fprintf(f, ", \"%s\": [%.17g, %.17g]", keys[k], limit[0], limit[1]);
            }
        fputc('}', f);
    }
    fputs("], \"moves\": [", f);
    for (int w = 0; w < call->parsed.n_word && fine; w++) {
        const char *ways = call->parsed.word[w];
        fprintf(f, "%s{\"to\": {", w ? ", " : "");
        int given = 1;
        for (const char *c = ways; *c; c++)
            given += *c == ',';
        fine = given == n;
        for (int i = 0; i < n && fine; i++) {
            at = item_of(ways, i, &length);
            double x = strtod(at, &end);
            place[i] += x;
            fine = end == at + length && length > 0 && isfinite(place[i]);
            fprintf(f, "%s\"%d\": %.17g", i ? ", " : "", i + 1, place[i]);
        }
        fprintf(f, "}, \"dwell\": %.17g", o->dwell);
        if (o->duration > 0)
            fprintf(f, ", \"duration\": %.17g", o->duration);
        fprintf(f, "%s}", o->straight ? ", \"straight\": true" : "");
    }
    fputs("]}", f);
    fclose(f);
    free(place);
    int code = fine ? cli_profile_cycle(call, text, size, o->rows, o->plot)
             : cli_usage(call, "several axes need a way each, \"1,0.2,0.8\", in each move, and limits like 3 or -1:3: one for all, "
                               "or one each");
    free(text);
    return code;
}

static int run(const cli_call *call)
{
    const settings *o = call->settings;
    static const cli_option row = { .kind = CLI_REAL };
    static const char *const others[] = { "from-state", "to-state", "speed-limit", "acceleration-limit", "jerk-limit", "law",
                                          "duration", "frequency", "swing", "power", "mass", "dwell", "straight" };
    motion m = { 0 };
    lw_output out;
    lw_error e = { 0 };
    size_t length = strlen(call->parsed.word[0]);
    if (length > 5 && strcmp(call->parsed.word[0] + length - 5, ".json") == 0) {
        if (call->parsed.n_word > 1)
            return cli_usage(call, "a cycle is a single file");
        for (size_t i = 0; i < sizeof others/sizeof *others; i++)
            if (cli_given(&call->parsed, others[i]))
                return cli_usage(call, "--%s is for a single motion; the file of a cycle has its own limits", others[i]);
        return cli_profile_cycle(call, NULL, 0, o->rows, o->plot);
    }
    if (call->parsed.n_word > 1 || strchr(call->parsed.word[0], ',') || o->dwell > 0)
        return run_moves(call);
    lw_status s = cli_value(&row, "WAY", call->parsed.word[0], &m.way, &e);
    if (s != LW_OK)
        return cli_usage(call, "%s", e.text);
    double frequency = o->swing > 0 ? o->swing : o->frequency;
    s = make_motion(o, &m, &e);
    if (s == LW_OK)
        s = cli_open(call, &out, &e);
    if (s != LW_OK)
        return s == LW_E_ARG ? cli_usage(call, "%s", e.text) : cli_fail(call, &e);
    if (call->common.json)
        write_json(out.f, &m, frequency, o->rows);
    else if (o->rows > 0)
        write_rows(out.f, &m, o->rows);
    else
        write_text(out.f, &m, frequency);
    int code = cli_close(call, &out, CLI_DONE);
    if (code == CLI_DONE && o->plot && draw(&m, o->plot, &e) != LW_OK)
        code = cli_fail(call, &e);
    return code;
}

const cli_command cli_profile_command = {
    .name = "profile",
    .words = "WAY[,WAY,...] ... or CYCLE.json",
    .title = "motion of an axis: least time under limits of speed, acceleration and jerk, or a law",
    .examples =
        "  linkwright profile 0.8 --speed-limit 3 --acceleration-limit 20 --jerk-limit 400          # metres, or any other unit\n"
        "  linkwright profile 0.1 --from-state 2,0 --speed-limit 3 --acceleration-limit 20 --jerk-limit 400   # "
            "already moving: it overshoots\n"
        "  linkwright profile 90 --law modified-sine --duration 0.5 -n 100 -o cam.csv  # degrees in half a second\n"
        "  linkwright profile 1 --acceleration-limit 20 --jerk-limit 400 --frequency 20 -p move.svg # no swing of 20 Hz afterwards\n"
        "  linkwright profile 1,0.2,0.8 --speed-limit 3 --acceleration-limit 20 --jerk-limit 400 --straight   # three axes, in phase\n"
        "  linkwright profile 0.5 0.3 -0.8 --acceleration-limit 20 --dwell 0.2   # three moves, each followed by a rest\n"
        "  linkwright profile examples/cycles/gantry.json                        # a work cycle: phase times of its moves\n",
    .about =
        "Prints the duration, the extremes of speed, acceleration and jerk, and the phases of constant jerk of a motion over\n"
        "WAY. All lengths (or angles) are in one unit of your choice, times in seconds. The motion is the quickest within the\n"
        "limits, from any speed and acceleration to any other; a limit that is not given does not count, but acceleration\n"
        "or jerk must have one. With --duration it takes just that time, as smoothly as a mixture of the two extreme\n"
        "motions does. With -n it prints a table, with --plot it draws the motion, with --json it prints everything.\n"
        "Exit code 1: no motion within the limits takes the duration; the message names the next one that is possible.\n"
        "\n"
        "Several ways with commas are axes that begin and end together. A limit counts for all, or is a list too. Ways in\n"
        "separate words are moves one after the other, with --dwell between them.\n"
        "\n"
        "A file with a work cycle (docs/profile.md, \"Work cycles\") is a list of moves of several axes with payloads, rests,\n"
        "overlaps and passing speeds. It prints when each move begins and how long it takes; exit code 1: the cycle takes\n"
        "longer than the file wants.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1000,
    .run = run
};
