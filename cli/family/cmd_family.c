/* linkwright family - product families: master files with parameters that expand to models. */
#include "base/number.h"
#include "cli/family/family.h"

#include <stdlib.h>
#include <string.h>

#include "cli/program/json.h"
#include "cli/program/output.h"

#define PLACE(member) offsetof(cli_family_settings, member)

static const cli_option options[] = {
    { "configuration", 0, CLI_TEXT, PLACE(configuration), "NAME", NULL,
      "expand, check, sweep, optimise: the values of this configuration of the master", 0, 0, NULL, NULL },
    { "set", 0, CLI_TEXT, PLACE(set), "NAME=VALUE,...", NULL,
      "set parameters, in their own unit or in another: \"reach=3,wall=8 mm\"", 0, 0, NULL, NULL },
    { "view", 0, CLI_TEXT, PLACE(view), "NAME", NULL,
      "which view to make: kinematic, dynamic, elastic, clearance, or one of the master; without it that of the "
      "master, or everything", 0, 0, NULL, NULL },
    { "map", 0, CLI_OUTPUT, PLACE(map), "FILE", NULL, "expand: also write where each line of the model comes from, as CSV", 0, 0, NULL, NULL },
    { "vary", 0, CLI_TEXT, PLACE(vary), "NAME=FROM:TO,...", NULL,
      "sweep, optimise: parameters to vary, in their units; a grid takes NAME=FROM:TO:N, and NAME alone its range in the master", 0, 0, NULL, NULL },
    { "measure", 0, CLI_TEXT, PLACE(measure), "FIGURE,...", NULL,
      "sweep: figures of each variant, listed above; without it peak and rms of each drive, and its greatest speed", 0, 0, NULL, NULL },
    { "samples", 0, CLI_INT, PLACE(samples), "N", NULL,
      "sweep: N points that fill the ranges evenly (Sobol's sequence) instead of a grid", 1, 1000000, NULL, NULL },
    { "sensitivity", 0, CLI_FLAG, PLACE(sensitivity), NULL, NULL,
      "sweep: percent of change of each figure for one percent of each parameter, about the chosen variant", 0, 0, NULL, "samples" },
    { "plot", 'p', CLI_PLOT, PLACE(plot), "FILE", NULL, "sweep: draw the figures over the first parameter, as SVG, PDF or PNG", 0, 0, NULL, NULL },
    { "normalised", 0, CLI_FLAG, PLACE(normalised), NULL, NULL,
      "sweep: draw each figure divided by its value in the chosen variant", 0, 0, "plot", NULL },
    { "minimise", 0, CLI_TEXT, PLACE(minimise), "FIGURE", NULL, "optimise: the figure to make small", 0, 0, NULL, "maximise" },
    { "maximise", 0, CLI_TEXT, PLACE(maximise), "FIGURE", NULL, "optimise: the figure to make large", 0, 0, NULL, NULL },
    { "require", 0, CLI_TEXT, PLACE(require), "FIGURE<=N,...", NULL,
      "optimise: conditions besides the checks of the master: FIGURE<=N or FIGURE>=N", 0, 0, NULL, NULL },
    { "solver", 0, CLI_TEXT, PLACE(solver), "NAME", "cobyla",
      "optimise: method of NLopt without derivatives: cobyla, neldermead, sbplx, bobyqa; isres, crs, direct, esch "
      "search the whole range", 0, 0, NULL, NULL },
    { "max-evaluations", 0, CLI_INT, PLACE(max_evals), "N", "500", "optimise: greatest number of models", 1, 10000000, NULL, NULL },
    { "from", 0, CLI_REAL, PLACE(from), "T", "0", "sweep, optimise: start of the run of a model [s]", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, PLACE(to), "T", "1", "sweep, optimise: end of the run of a model [s]", 0, 0, NULL, NULL },
    { "steps", 'n', CLI_INT, PLACE(steps), "N", "200", "sweep, optimise: number of time intervals of a run", 1, 10000000, NULL, NULL },
    { "speed", 's', CLI_TEXT, PLACE(speed), "W", NULL,
      "sweep, optimise: drive the inputs without a motion at this constant speed [rad/s] or [m/s], or with a unit: \"60 rpm\"", 0, 0, NULL, NULL },
    { .name = NULL }
};

static const cli_action actions[] = {
    { "expand", "MASTER.json",
      "Writes the model of the chosen parameters as an ordinary model file. The model is read back first, and all checks of\n"
      "the master must hold; errors name the line and column of the master.\n",
      1, 1, cli_family_expand, CLI_MASTER, "JSON" },
    { "table", "MASTER.json",
      "Prints the parameters, derived values and checks of all configurations, one column each.\n",
      1, 1, cli_family_table, CLI_MASTER, "text" },
    { "check", "MASTER.json",
      "Makes every configuration in every view, reads each model back, and works out all checks. Exit code 1: something\n"
      "fails.\n",
      1, 1, cli_family_check, CLI_MASTER, "text" },
    { "sweep", "MASTER.json --vary NAME=FROM:TO:N",
      "Varies parameters over a grid or an even design, or about the chosen variant, and prints figures of each model. A figure is\n"
      "FUNCTION(COLUMN) over a run as of 'linkwright simulate': peak (greatest magnitude), max, min, mean, rms, range, first,\n"
      "last, integral of a column, such as rms(lift.drive), and NAME.power of a drive; *.drive is all drives at once.\n"
      "frequency(K) is the K-th natural frequency, condition(TOOL) the greatest condition number of a robot, arc(range) and\n"
      "arc(transmission) what 'linkwright trace' says of a linkage with one input (docs/family.md). Any other figure is\n"
      "a formula over parameters and derived values. A variant that fails has empty figures and the reason.\n",
      1, 1, cli_family_sweep, CLI_MASTER, NULL },
    { "optimise", "MASTER.json --vary NAME,... --minimise FIGURE",
      "Finds the parameters within their ranges that make a figure least or greatest, under the checks of the master and\n"
      "--require. A local method starts from the chosen variant.\n",
      1, 1, cli_family_optimise, CLI_MASTER, NULL },
    { .name = NULL }
};

/* ---- what all actions share -------------------------------------------------------------------------- */

static int end(const cli_call *call, lw_master *m, lw_variant *v, int code, lw_status s, const lw_error *e)
{
    lw_variant_free(v);
    lw_master_free(m);
    return s == LW_OK ? code : s == LW_E_ARG ? cli_usage(call, "%s", e->text) : cli_fail(call, e);
}

/* ---- expand -------------------------------------------------------------------------------------------- */

static lw_status write_map(const char *path, const lw_expansion *x, lw_error *e)
{
    lw_output o;
    lw_status s = lw_output_open(&o, path, e);
    if (s != LW_OK)
        return s;
    fputs("line,master_line,master_column\n", o.f);
    long line = 1;
    for (const char *at = x->text; *at; line++, at += strcspn(at, "\n") + 1) {
        long to_line, to_column, column = 1 + (long)strspn(at, " ");
        if (lw_expansion_place(x, line, column, &to_line, &to_column))
            fprintf(o.f, "%ld,%ld,%ld\n", line, to_line, to_column);
    }
    return lw_output_commit(&o, e);
}

int cli_family_expand(const cli_call *call)
{
    const cli_family_settings *o = call->settings;
    lw_master *m;
    lw_variant *v;
    lw_expansion x = { 0 };
    lw_error e = { 0 };
    lw_output out;
    lw_status s = cli_family_open(call, &m, &v, &e);
    if (s == LW_OK)
        s = lw_variant_hold_checks(v, &e);
    if (s == LW_OK)
        s = lw_variant_expand(v, &x, &e);
    if (s == LW_OK)
        s = cli_family_read_back(&x, &e);
    if (s == LW_OK)
        s = cli_open(call, &out, &e);
    int code = CLI_DONE;
    if (s == LW_OK) {
        fwrite(x.text, 1, x.size, out.f);
        code = cli_close(call, &out, CLI_DONE);
        if (code == CLI_DONE && o->map)
            s = write_map(o->map, &x, &e);
    }
    lw_expansion_free(&x);
    return end(call, m, v, code, s, &e);
}

/* ---- table ---------------------------------------------------------------------------------------------- */

enum { CELL = 64 };

/* Column c of the table: 0 the defaults, then the configurations. */
static lw_status choose_column(const cli_call *call, lw_variant *v, const lw_master *m, int c, lw_error *e)
{
    const cli_family_settings *o = call->settings;
    lw_status s = lw_variant_configure(v, c > 0 ? lw_master_configuration(m, c - 1) : NULL, e);
    return s == LW_OK ? cli_family_set(o->set, v, e) : s;
}

/* Cells of parameter or let `row`, of the checks behind them. */
static lw_status cell(lw_variant *v, const lw_master *m, int row, int n_value, char text[CELL], lw_error *e)
{
    lw_amount a, left, right;
    bool holds;
    lw_status s;
    if (row < n_value) {
        s = lw_variant_value(v, row, &a, e);
        if (s == LW_OK)
            lw_variant_print(v, row, &a, text, CELL);
        return s;
    }
    (void)m;
    s = lw_variant_check(v, row - n_value, &holds, &left, &right, e);
    if (s == LW_OK)
        snprintf(text, CELL, "%s", holds ? "holds" : "FAILS");
    return s;
}

static const char *row_name(const lw_master *m, int row, int n_parameter, int n_value)
{
    return row < n_parameter ? lw_master_parameter(m, row)->name : row < n_value ? lw_master_let(m, row - n_parameter)
         : lw_master_check_text(m, row - n_value);
}

static void print_table(const cli_call *call, FILE *f, const lw_master *m, int rows, int columns, int n_parameter,
                        int n_value,
                        char (*text)[CELL])
{
    int first = 0, *width = calloc((size_t)columns + 1, sizeof *width);
    if (!width) {
        cli_lost();
        return;
    }
    for (int r = 0; r < rows; r++) {
        int n = (int)strlen(row_name(m, r, n_parameter, n_value));
        first = n > first && n <= 60 ? n : first;
        for (int c = 0; c < columns; c++) {
            int k = (int)strlen(text[r*columns + c]);
            width[c] = k > width[c] ? k : width[c];
        }
    }
    const char *title = lw_master_title(m);
    fprintf(f, "%s%s%-*s", title, *title ? "\n\n" : "", first, "");
    for (int c = 0; c < columns; c++) {
        const char *name = c ? lw_master_configuration(m, c - 1) : "(defaults)";
        width[c] = (int)strlen(name) > width[c] ? (int)strlen(name) : width[c];
        fprintf(f, "  %-*s", c < columns - 1 ? width[c] : 0, name);
    }
    fputc('\n', f);
    for (int r = 0; r < rows; r++) {
        if (r == n_parameter || r == n_value)
            fputc('\n', f);
        fprintf(f, "%-*s", first, row_name(m, r, n_parameter, n_value));
        for (int c = 0; c < columns; c++)
            fprintf(f, "  %-*s", c < columns - 1 ? width[c] : 0, text[r*columns + c]);
        fputc('\n', f);
    }
    (void)call;
    free(width);
}

/* "2.4 m" as 2.4 and its unit; a text, true and false as they are. */
static void json_cell(cli_json *j, const char *text, const char *unit)
{
    char *end;
    double x = strtod(text, &end);
    size_t n = strlen(unit);
    if (end > text && (*end == '\0' || (*end == ' ' && strlen(end + 1) == n && strcmp(end + 1, unit) == 0)))
        cli_json_real(j, NULL, x);
    else if (strcmp(text, "true") == 0 || strcmp(text, "false") == 0)
        cli_json_bool(j, NULL, *text == 't');
    else
        cli_json_text(j, NULL, text);
}

static void print_json(const cli_call *call, FILE *f, const lw_master *m, int rows, int columns, int n_parameter,
                       int n_value,
                       char (*text)[CELL])
{
    cli_json j = cli_json_begin(f, 2);
    cli_json_head(&j, call->line);
    cli_json_text(&j, "family", lw_master_title(m));
    cli_json_array(&j, "configurations");
    for (int c = 0; c < columns; c++)
        cli_json_text(&j, NULL, c ? lw_master_configuration(m, c - 1) : NULL);
    cli_json_end(&j);
    static const char *const names[] = { "parameters", "let", "checks" };
    const int first[] = { 0, n_parameter, n_value, rows };
    for (int k = 0; k < 3; k++) {
        cli_json_array(&j, names[k]);
        for (int r = first[k]; r < first[k + 1]; r++) {
            cli_json_object(&j, NULL);
            cli_json_text(&j, k < 2 ? "name" : "text", row_name(m, r, n_parameter, n_value));
            const char *space = strchr(text[r*columns], ' '), *unit = k == 0 ? lw_master_parameter(m, r)->unit
                              : k == 1 && space ? space + 1 : "";
            if (k < 2)
                cli_json_text(&j, "unit", unit);
            if (k == 0)
                cli_json_text(&j, "doc", lw_master_parameter(m, r)->doc);
            cli_json_array(&j, k < 2 ? "values" : "holds");
            for (int c = 0; c < columns; c++)
                if (k < 2)
                    json_cell(&j, text[r*columns + c], unit);
                else
                    cli_json_bool(&j, NULL, strcmp(text[r*columns + c], "holds") == 0);
            cli_json_end(&j);
            cli_json_end(&j);
        }
        cli_json_end(&j);
    }
    cli_json_end(&j);
}

int cli_family_table(const cli_call *call)
{
    lw_master *m;
    lw_variant *v;
    lw_error e = { 0 };
    lw_output out;
    int n_parameter = 0, n_value, rows, columns = 1;
    lw_status s = cli_family_open(call, &m, &v, &e);
    if (s != LW_OK)
        return end(call, m, v, 0, s, &e);
    while (lw_master_parameter(m, n_parameter))
        n_parameter++;
    for (n_value = n_parameter; lw_master_let(m, n_value - n_parameter);)
        n_value++;
    for (rows = n_value; lw_master_check_text(m, rows - n_value);)
        rows++;
    while (lw_master_configuration(m, columns - 1))
        columns++;
    char (*text)[CELL] = calloc((size_t)rows*(size_t)columns + 1, sizeof *text);
    if (!text)
        s = lw_error_set(&e, LW_E_MEMORY, "out of memory");
    for (int c = 0; s == LW_OK && c < columns; c++) {
        s = choose_column(call, v, m, c, &e);
        for (int r = 0; s == LW_OK && r < rows; r++)
            s = cell(v, m, r, n_value, text[r*columns + c], &e);
    }
    if (s == LW_OK)
        s = cli_open(call, &out, &e);
    int code = CLI_DONE;
    if (s == LW_OK) {
        (call->common.json ? print_json : print_table)(call, out.f, m, rows, columns, n_parameter, n_value, text);
        code = cli_close(call, &out, CLI_DONE);
    }
    free(text);
    return end(call, m, v, code, s, &e);
}

/* ---- check ----------------------------------------------------------------------------------------------- */

/* One configuration in one view (NULL: everything).  Counts and prints what fails, as an object of w unless that is NULL. */
static lw_status try_one(FILE *f, cli_json *w, lw_variant *v, const char *configuration, const char *view, long *n, long *n_failed)
{
    lw_error e = { 0 };
    lw_expansion x = { 0 };
    char text[900];
    lw_status s = view ? lw_variant_look(v, view, &e) : lw_variant_hold_checks(v, &e);
    if (s == LW_OK)
        s = lw_variant_expand(v, &x, &e);
    if (s == LW_OK)
        s = cli_family_read_back(&x, &e);
    lw_expansion_free(&x);
    ++*n;
    if (s == LW_OK || s == LW_E_MEMORY)
        return s;
    lw_error_print(&e, text, sizeof text);
    if (w) {
        cli_json_object(w, NULL);
        cli_json_text(w, "configuration", configuration);
        if (view)
            cli_json_text(w, "view", view);
        cli_json_text(w, "fault", text);
        cli_json_end(w);
    } else
        fprintf(f, "%s%s%s: %s\n", configuration, view ? ", view " : "", view ? view : "", text);
    ++*n_failed;
    return LW_OK;
}

int cli_family_check(const cli_call *call)
{
    const cli_family_settings *o = call->settings;
    lw_master *m;
    lw_variant *v;
    lw_error e = { 0 };
    lw_output out;
    long n = 0, n_failed = 0, n_configuration = 0, n_view = 0;
    lw_status s = cli_family_open(call, &m, &v, &e);
    if (s == LW_OK)
        s = cli_open(call, &out, &e);
    if (s != LW_OK)
        return end(call, m, v, 0, s, &e);
    cli_json json = cli_json_begin(out.f, 2), *w = call->common.json ? &json : NULL;
    if (w) {
        cli_json_head(w, call->line);
        cli_json_array(w, "faults");
    }
    for (int c = 0; s == LW_OK && (c == 0 || lw_master_configuration(m, c - 1)); c++) {
        const char *name = c ? lw_master_configuration(m, c - 1) : "(defaults)";
        if (o->configuration && strcmp(name, o->configuration) != 0)
            continue;
        n_configuration++;
        s = choose_column(call, v, m, c, &e);
        if (s == LW_OK)
            s = lw_variant_look(v, o->view, &e);
        if (s == LW_OK)
            s = try_one(out.f, w, v, name, NULL, &n, &n_failed);
        for (int k = 0; s == LW_OK && !o->view && lw_master_view(m, k); k++) {
            s = try_one(out.f, w, v, name, lw_master_view(m, k), &n, &n_failed);
            n_view = k + 1;
        }
    }
    if (w) {
        cli_json_end(w);
        cli_json_int(w, "configurations", n_configuration);
        cli_json_int(w, "views", n_view + 1);
        cli_json_int(w, "models", n);
        cli_json_int(w, "failed", n_failed);
        cli_json_end(w);
    } else
        fprintf(out.f, "%ld configuration%s in %ld view%s: %ld model%s, %ld failed\n", n_configuration,
            lw_plural(n_configuration),
            n_view + 1, n_view ? "s" : "", n, lw_plural(n), n_failed);
    int code = cli_close(call, &out, s != LW_OK ? cli_exit_code(s) : n_failed ? CLI_NOTHING : CLI_DONE);
    return end(call, m, v, code, s, &e);
}

const cli_command cli_family_command = {
    .name = "family",
    .words = "ACTION MASTER.json",
    .title = "product families: master files with parameters, parts and views that expand to models",
    .examples =
        "  linkwright family table examples/families/loader.json                 # all configurations side by side\n"
        "  linkwright family expand examples/families/loader.json --configuration large -o large.json\n"
        "  linkwright family expand examples/families/loader.json --set \"reach=3 m\" --view kinematic\n"
        "  linkwright family check examples/families/loader.json                 # every configuration in every view\n"
        "  linkwright family sweep examples/families/loader.json --vary reach=2:3:11 --to 2 -p reach.svg --normalised\n"
        "  linkwright family sweep examples/families/loader.json --vary reach,drop --sensitivity --to 2\n"
        "  linkwright family optimise examples/families/loader.json --vary drop,pin_height --minimise \"peak(lift.drive)\" --to 2\n",
    .about =
        "A master file describes all sizes and variants of a product: parameters with units and ranges, formulas, parts\n"
        "that are used several times, conditions, views and checks (docs/family.md).\n",
    .options = options,
    .settings_size = sizeof(cli_family_settings),
    .actions = actions
};
