#include "cli/family/family_measure.h"

#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/suggest.h"
#include "cli/motion/table_run.h"
#include "cli/program/model.h"
#include "mbs/space/robot.h"

enum { PEAK, MAX, MIN, MEAN, RMS, RANGE, FIRST, LAST, INTEGRAL, OF_COLUMN = INTEGRAL, FREQUENCY, ARC,
       CONDITION, FIGURES };
static const char *const figures[] = { "peak", "max", "min", "mean", "rms", "range", "first", "last", "integral",
                                       "frequency", "arc", "condition" };

static const char *trim(char *text)
{
    for (size_t n = strlen(text); n > 0 && text[n - 1] == ' '; n--)
        text[n - 1] = '\0';
    return text + strspn(text, " ");
}

/* "rms(lift.drive)"; several arguments make a formula. */
static void read_one(cli_measure *m)
{
    const char *open = strchr(m->text, '(');
    size_t n = strlen(m->text), word = open ? (size_t)(open - m->text) : 0;
    char inside[128];
    m->figure = -1;
    if (!open || m->text[n - 1] != ')')
        return;
    snprintf(inside, sizeof inside, "%.*s", (int)(n - 2 - word), open + 1);
    for (int i = 0; i < FIGURES && !strpbrk(inside + (inside[0] == '*'), ",()+*/"); i++)
        if (strlen(figures[i]) == word && strncmp(figures[i], m->text, word) == 0) {
            snprintf(m->column, sizeof m->column, "%s", trim(inside));
            m->figure = i;
        }
}

lw_status cli_measures_read(const char *list, int *n, cli_measure *m, lw_error *e)
{
    char item[256];
    *n = 0;
    for (const char *at = list; cli_family_next(&at, item, sizeof item);) {
        if (*n == CLI_MEASURE_MAX)
            return lw_error_set(e, LW_E_ARG, "at most %d figures can be measured", CLI_MEASURE_MAX);
        cli_measure *k = &m[(*n)++];
        *k = (cli_measure){ .figure = -1 };
        const char *text = trim(item);
        if (strlen(text) >= sizeof k->text)
            return lw_error_set(e, LW_E_ARG, "\"%.60s\" is too long", text);
        strcpy(k->text, text);
        read_one(k);
    }
    return *n > 0 ? LW_OK : lw_error_set(e, LW_E_ARG, "this list of figures is empty");
}

/* ---- a run ------------------------------------------------------------------------------------------- */

static lw_status make_model(lw_variant *v, lw_model **m, lw_spatial **spatial, lw_expansion *x, lw_error *e)
{
    *m = NULL;
    *spatial = NULL;
    lw_status s = lw_variant_hold_checks(v, e);
    if (s == LW_OK)
        s = lw_variant_expand(v, x, e);
    return s == LW_OK ? cli_any_model_text(x->text, x->size, "", 0, m, spatial, e) : s;
}

static lw_status run_model(const cli_call *call, lw_model *m, lw_spatial *spatial, cli_table *t, lw_error *e)
{
    const cli_family_settings *o = call->settings;
    const cli_table_options run = { .from = o->from, .to = o->to, .steps = o->steps, .speed = o->speed };
    return cli_table_run(call, m, spatial, &run, t, e);
}

static bool ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), k = strlen(end);
    return n > k && strcmp(text + n - k, end) == 0;
}

lw_status cli_measures_default(const cli_call *call, lw_variant *v, int *n, cli_measure *m, lw_error *e)
{
    static const char *const forms[] = { "peak(%.*s.drive)", "rms(%.*s.drive)", "peak(%.*s.rate)" };
    lw_model *model;
    lw_spatial *spatial;
    lw_expansion x = { 0 };
    cli_table t = { 0 };
    lw_status s = make_model(v, &model, &spatial, &x, e);
    *n = 0;
    if (s == LW_OK)
        s = run_model(call, model, spatial, &t, e);
    for (int i = 0; s == LW_OK && i < t.n_column && *n + 3 <= CLI_MEASURE_MAX; i++)
        for (int k = 0; k < 3 && ends_with(t.column[i].name, ".drive"); k++) {
            cli_measure *one = &m[(*n)++];
            *one = (cli_measure){ .figure = -1 };
            snprintf(one->text, sizeof one->text, forms[k], (int)strlen(t.column[i].name) - 6, t.column[i].name);
            read_one(one);
        }
    if (s == LW_OK && *n == 0)
        s = lw_error_set(e, LW_E_ARG, "the model has no input; --measure names the figures");
    if (s != LW_OK && s != LW_E_ARG)
        lw_expansion_fault(&x, e);
    cli_table_free(&t);
    lw_expansion_free(&x);
    cli_free_model(model);
    cli_free_spatial(spatial);
    return s;
}

/* Sample r of a column; NAME.power is speed times drive. */
static double sample(const cli_table *c, int column, int rate, size_t r)
{
    return cli_table_at(c, r, column)*(rate < 0 ? 1 : cli_table_at(c, r, rate));
}

/* Column and, of NAME.power, that of the speed; column -1: there is none. */
static int find_column(const cli_table *c, const char *name, int *rate)
{
    char of[128];
    int column = cli_table_find(c, name);
    *rate = -1;
    if (column < 0 && ends_with(name, ".power")) {
        int n = (int)strlen(name) - 6;
        snprintf(of, sizeof of, "%.*s.rate", n, name);
        *rate = cli_table_find(c, of);
        snprintf(of, sizeof of, "%.*s.drive", n, name);
        column = *rate >= 0 ? cli_table_find(c, of) : -1;
    }
    return column;
}

static double figure_in(const cli_table *c, int figure, int column, int rate)
{
    double most = -INFINITY, least = INFINITY, sum = 0, square = 0, before = 0, step = 0;
    for (size_t r = 0; r < c->n_row; r++) {
        double x = sample(c, column, rate, r);
        most = fmax(most, x);
        least = fmin(least, x);
        if (r > 0) {
            step = cli_table_at(c, r, 0) - cli_table_at(c, r - 1, 0);
            sum += (x + before)/2*step;
            square += (x*x + x*before + before*before)/3*step;
        }
        before = x;
    }
    double time = cli_table_at(c, c->n_row - 1, 0) - cli_table_at(c, 0, 0);
    const double values[] = { fmax(most, -least), most, least, sum/time, sqrt(square/time), most - least,
                              sample(c, column, rate, 0), before, sum };
    return values[figure];
}

/* "*.drive" stands for the column of every drive: the greatest of their figures, of min the least. */
static lw_status figure_of(const cli_table *c, cli_measure *m, double *out, lw_error *e)
{
    int column = -1, rate = -1, each = strncmp(m->column, "*.", 2) == 0;
    for (int i = 0; each && i < c->n_column; i++) {
        char name[2*LW_NAME_SIZE + 64];
        if (!ends_with(c->column[i].name, ".drive"))
            continue;
        snprintf(name, sizeof name, "%.*s%s", (int)strlen(c->column[i].name) - 6, c->column[i].name, m->column + 1);
        int of_rate, at = find_column(c, name, &of_rate);
        if (at < 0)
            continue;
        double x = figure_in(c, m->figure, at, of_rate);
        *out = column < 0 ? x : m->figure == MIN ? fmin(*out, x) : fmax(*out, x);
        column = at;
        rate = of_rate;
    }
    if (!each) {
        column = find_column(c, m->column, &rate);
        if (column >= 0)
            *out = figure_in(c, m->figure, column, rate);
    }
    if (column < 0) {
        const char *near = LW_SUGGEST(m->column, c->column, c->n_column, name);
        return lw_error_set(e, LW_E_ARG, "%s: no column is called \"%s\"%s%s%s; 'linkwright simulate' names them", m->text,
                            m->column, near ? "; did you mean " : "", near ? near : "", near ? "?" : "");
    }
    snprintf(m->unit, sizeof m->unit, "%s%s", rate >= 0 ? "W" : c->column[column].unit, m->figure != INTEGRAL ? ""
             : rate >= 0 || strcmp(c->column[column].unit, "1") != 0 ? " s" : "");
    if (m->figure == INTEGRAL && rate >= 0)
        strcpy(m->unit, "J");
    return isfinite(*out) ? LW_OK : lw_error_set(e, LW_E_NUMERIC, "%s is no finite number", m->text);
}

typedef struct modes { int n; double natural[256]; } modes;

static lw_status take_mode(void *context, const lw_vibration_info *mode)
{
    modes *k = context;
    if (k->n < 256)
        k->natural[k->n++] = mode->natural;
    return LW_OK;
}

/* frequency(3): the third natural frequency about the posture of the file. */
static lw_status frequencies(const lw_model *model, const lw_spatial *spatial, int n, cli_measure *m, double *value, lw_error *e)
{
    modes k = { 0 };
    lw_status s = spatial ? lw_spatial_vibrations(spatial, true, false, take_mode, &k, e)
                : lw_model_vibrations(model, false, false, take_mode, &k, e);
    for (int i = 0; s == LW_OK && i < n; i++) {
        char *end;
        long number = m[i].figure == FREQUENCY ? strtol(m[i].column, &end, 10) : 0;
        if (m[i].figure != FREQUENCY)
            continue;
        if (*end || number < 1 || number > k.n)
            return lw_error_set(e, LW_E_ARG, "%s: the model has %d natural frequenc%s", m[i].text, k.n, k.n == 1 ? "y" : "ies");
        value[i] = k.natural[number - 1];
        strcpy(m[i].unit, "Hz");
    }
    return s;
}

/* The results of `trace` for the arc that holds the posture of the file. */
static lw_status take_arc(void *context, const lw_input_range *range)
{
    if (range->own)
        *(lw_input_range *)context = *range;
    return LW_OK;
}

static lw_status arcs(const lw_model *model, int n, cli_measure *m, double *value, lw_error *e)
{
    lw_kinematics *k = NULL;
    lw_input_range own = { .first = NAN };
    const lw_linkage *linkage = lw_model_linkage(model);
    lw_status s = linkage ? lw_kinematics_create(linkage, &k, e) : lw_error_set(e, LW_E_KIND, "this model is too large for arcs");
    if (s == LW_OK && (s = lw_kinematics_ranges(k, take_arc, &own)) != LW_OK)
        lw_error_set(e, s, "the range of the input is not known: %s", lw_status_text(s));
    else if (s == LW_OK && isnan(own.first))
        s = lw_error_set(e, LW_OPEN, "no arc holds the posture of the file");
    for (int i = 0; s == LW_OK && i < n; i++) {
        static const char *const parts[] = { "first", "last", "range", "transmission" };
        const lw_input *in = &model->linkage.input[0];
        bool slides = lw_joint_slides(model->linkage.joint[in->joint].kind);
        double unit = slides ? model->linkage.units.metre : model->linkage.units.radian;
        double offset = in->value - lw_kinematics_input(k);              /* as the file counts */
        const double values[] = { (own.first + offset)/unit, (own.last + offset)/unit, (own.last - own.first)/unit,
                                  own.transmission[0]*180/LW_PI };
        int which = 0;
        if (m[i].figure != ARC)
            continue;
        while (which < 4 && strcmp(m[i].column, parts[which]) != 0)
            which++;
        if (which == 4) {
            s = lw_error_set(e, LW_E_ARG, "%s: expected arc(first), arc(last), arc(range) or arc(transmission)", m[i].text);
            break;
        }
        value[i] = values[which];
        const char *length = model->linkage.units.length;
        snprintf(m[i].unit, sizeof m[i].unit, "%s", which == 3 ? "deg" : !slides ? model->linkage.units.angle : *length ? length : "m");
    }
    lw_kinematics_destroy(k);
    return s;
}

/* Greatest condition number of a tool along its path in the run. */
static lw_status condition(const lw_spatial *spatial, const cli_table *t, cli_measure *m, double *value, lw_error *e)
{
    char name[3][160];
    int column[3];
    lw_robot r;
    lw_robot_pose pose;
    if (!spatial)
        return lw_error_set(e, LW_E_KIND, "%s: condition numbers are known of spatial models with drives and a tool", m->text);
    for (int k = 0; k < 3; k++) {
        snprintf(name[k], sizeof name[k], "%s.%c", m->column, 'x' + k);
        column[k] = cli_table_find(t, name[k]);
    }
    lw_status s = lw_robot_make(spatial, m->column, &r, e);
    bool made = s == LW_OK;
    *value = 0;
    strcpy(m->unit, "1");
    for (size_t row = 0; s == LW_OK && row < t->n_row; row++) {
        double f = spatial->units.metre;
        lw_vec3 at = { f*cli_table_at(t, row, column[0]), f*cli_table_at(t, row, column[1]), f*cli_table_at(t, row, column[2]) };
        s = lw_robot_move(&r, at, NULL, e);
        if (s == LW_OK && (s = lw_robot_measure(&r, &pose, e)) == LW_OK)
            *value = fmax(*value, pose.condition);
    }
    if (made)
        lw_robot_free(&r);
    return s;
}

lw_status cli_measures_run(const cli_call *call, lw_variant *v, int n, cli_measure *m, double *value, lw_error *e)
{
    bool run = false, vibrates = false, turns = false;
    for (int i = 0; i < n; i++) {
        run = run || (m[i].figure >= 0 && m[i].figure <= OF_COLUMN) || m[i].figure == CONDITION;
        vibrates = vibrates || m[i].figure == FREQUENCY;
        turns = turns || m[i].figure == ARC;
    }
    lw_status s = lw_variant_hold_checks(v, e);
    for (int i = 0; s == LW_OK && i < n; i++)
        if (m[i].figure < 0 && (s = lw_variant_quantity(v, m[i].text, &value[i], m[i].unit, e)) != LW_OK) {
            char text[sizeof e->text];
            snprintf(text, sizeof text, "%s: %.300s", m[i].text, e->text);
            s = lw_error_set(e, s == LW_E_NOTATION ? LW_E_ARG : s, "%s", text);
        }
    if (s != LW_OK || (!run && !vibrates && !turns))
        return s;
    lw_expansion x = { 0 };
    lw_model *model;
    lw_spatial *spatial;
    cli_table t = { 0 };
    s = make_model(v, &model, &spatial, &x, e);
    if (s == LW_OK && vibrates)
        s = frequencies(model, spatial, n, m, value, e);
    if (s == LW_OK && turns)
        s = spatial ? lw_error_set(e, LW_E_KIND, "arcs are known of planar linkages only") : arcs(model, n, m, value, e);
    if (s == LW_OK && run)
        s = run_model(call, model, spatial, &t, e);
    for (int i = 0; s == LW_OK && i < n; i++)
        if (m[i].figure >= 0 && m[i].figure <= OF_COLUMN)
            s = figure_of(&t, &m[i], &value[i], e);
        else if (m[i].figure == CONDITION)
            s = condition(spatial, &t, &m[i], &value[i], e);
    if (s != LW_OK && s != LW_E_ARG)
        lw_expansion_fault(&x, e);
    cli_table_free(&t);
    lw_expansion_free(&x);
    cli_free_model(model);
    cli_free_spatial(spatial);
    return s;
}
