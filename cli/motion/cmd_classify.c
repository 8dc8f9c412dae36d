/* linkwright classify - classify the motion of a four-bar by its four lengths. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/units.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "grammar/text/text_internal.h"
#include "mbs/kinematics/fourbar.h"

typedef struct settings {
    double tolerance;
    int    unit;              /* row of `units`                                                    */
} settings;

static const char *const units[] = { "deg", "rad", "turn" };

static const cli_option options[] = {
    { "tolerance", 0, CLI_REAL, offsetof(settings, tolerance), "E", "1e-12",
      "two sums of lengths are equal if they differ by at most E times the perimeter", 0, 0.1, NULL, NULL },
    { "angle-unit", 0, CLI_CHOICE, offsetof(settings, unit), "deg|rad|turn", "deg", "unit of the angles that are printed", 0, 0, NULL, NULL },
    { .name = NULL }
};

typedef struct unit { const char *name; double radian; } unit;

static unit angle_unit(int choice)
{
    lw_units u = lw_units_si();
    lw_units_set_angle(&u, units[choice]);
    return (unit){ units[choice], u.radian };
}

static const char *yes(bool b) { return b ? "yes" : "no"; }

static void angles(FILE *f, const char *head, const double *a, int n, const char *between, unit u)
{
    fprintf(f, "%-16s", head);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s%.10g", i ? between : "", a[i]/u.radian);
    fputs(n ? "" : "none", f);
    if (n)
        fprintf(f, " %s", u.name);
    if (n && u.radian != 1) {
        fputs("  (", f);
        for (int i = 0; i < n; i++)
            fprintf(f, "%s%.10g", i ? between : "", a[i]);
        fputs(" rad)", f);
    }
    fputc('\n', f);
}

static void write_text(FILE *f, const lw_fourbar_class *c, unit u)
{
    fprintf(f, "%-16s%d  %s  %s\n", "class", c->number, c->symbol, c->name);
    fprintf(f, "%-16s%s  (s + l - p - q = %.10g of the perimeter)\n", "Grashof", yes(c->grashof), c->change);
    fprintf(f, "%-16s%.10g of the perimeter away\n", "change point", c->margin);
    fprintf(f, "%-16s%s\n", "input turns", yes(c->crank));
    fprintf(f, "%-16s%s\n", "output turns", yes(c->rocker_turns));
    fprintf(f, "%-16s%d\n", "circuits", c->circuits);
    for (int i = 0; c->n_limit && i < c->n_range; i++)
        angles(f, i ? "" : "input range", c->range[i], 2, " to ", u);
    angles(f, "input limits", c->limit, c->n_limit, ", ", u);
    angles(f, "dead points", c->dead, c->n_dead, ", ", u);
    angles(f, "transmission", c->transmission, 2, " to ", u);
}

static void json_angles(cli_json *j, const char *key, const double *a, int n, unit u)
{
    double v[4];
    for (int i = 0; i < n; i++)
        v[i] = a[i]/u.radian;
    cli_json_reals(j, key, v, (size_t)n);
}

static void write_json(FILE *f, const double r[4], const lw_fourbar_class *c, unit u, int indent)
{
    cli_json j = cli_json_begin(f, indent);
    cli_json_object(&j, NULL);
    cli_json_reals(&j, "lengths", r, 4);
    cli_json_int(&j, "class", c->number);
    cli_json_text(&j, "symbol", c->symbol);
    cli_json_text(&j, "name", c->name);
    cli_json_bool(&j, "grashof", c->grashof);
    cli_json_real(&j, "grashof_excess", c->change);
    cli_json_real(&j, "change_point_margin", c->margin);
    cli_json_bool(&j, "input_turns", c->crank);
    cli_json_bool(&j, "output_turns", c->rocker_turns);
    cli_json_int(&j, "circuits", c->circuits);
    cli_json_object(&j, "units");
    cli_json_text(&j, "angle", u.name);
    cli_json_end(&j);
    cli_json_array(&j, "input_ranges");
    for (int i = 0; i < c->n_range; i++)
        json_angles(&j, NULL, c->range[i], 2, u);
    cli_json_end(&j);
    json_angles(&j, "input_limits", c->limit, c->n_limit, u);
    json_angles(&j, "dead_points", c->dead, c->n_dead, u);
    json_angles(&j, "transmission_angle", c->transmission, 2, u);
    cli_json_end(&j);
}

static void write_open(FILE *f, const double r[4])
{
    cli_json j = cli_json_begin(f, 0);
    cli_json_object(&j, NULL);
    cli_json_reals(&j, "lengths", r, 4);
    cli_json_text(&j, "class", NULL);
    cli_json_text(&j, "name", "cannot be assembled");
    cli_json_end(&j);
}

static lw_status read_lengths(const cli_call *call, double r[4], lw_error *e)
{
    static const char *const names[4] = { "L1, the frame", "L2, the input", "L3, the coupler",
                                          "L4, the output" };
    static const cli_option row = { .kind = CLI_REAL };
    for (int i = 0; i < 4; i++) {
        lw_status s = cli_value(&row, names[i], call->parsed.word[i], &r[i], e);
        if (s != LW_OK)
            return s;
    }
    return LW_OK;
}

/* ---- a table ------------------------------------------------------------------------------------ */

/* Read the columns of a line that ends at `end` as numbers, as far as they are.  Columns have semicolons or tabs between
 * them, and then decimal points or commas, else commas or blanks.  Returns the number of columns; *numbers: how many of
 * the first four are numbers. */
static int read_line(const char *at, const char *end, double r[4], int *numbers)
{
    static const cli_option row = { .kind = CLI_REAL };
    size_t length = (size_t)(end - at);
    const char *between = memchr(at, ';', length) ? " \t\r;" : memchr(at, '\t', length) ? " \t\r" : " \r,";
    int n = 0;
    *numbers = 0;
    while ((at += strspn(at, between)) < end) {
        char word[64];
        size_t size = strcspn(at, between), line = (size_t)(end - at);
        size = size < line ? size : line;
        snprintf(word, sizeof word, "%.*s", (int)(size < sizeof word ? size : sizeof word - 1), at);
        if (strchr(word, ','))
            *strchr(word, ',') = '.';
        *numbers += n < 4 && size < sizeof word && cli_value(&row, "length", word, &r[n], NULL) == LW_OK;
        n++;
        at += size;
    }
    return n;
}

static void write_row(FILE *f, const double r[4], const lw_fourbar_class *c, unit u)
{
    fprintf(f, "%.17g,%.17g,%.17g,%.17g,", r[0], r[1], r[2], r[3]);
    if (!c)
        fputs(",,cannot be assembled,,,,,,,\n", f);
    else
        fprintf(f, "%d,%s,\"%s\",%s,%s,%s,%d,%.10g,%.10g,%.10g\n", c->number, c->symbol, c->name, yes(c->grashof),
                yes(c->crank), yes(c->rocker_turns), c->circuits, c->margin, c->transmission[0]/u.radian,
                c->transmission[1]/u.radian);
}

/* Lines of four lengths; a first line of four names, empty lines and lines with # are passed over. */
static lw_status write_table(const cli_call *call, FILE *f, const char *file, const char *text, size_t size, lw_error *e)
{
    const settings *s = call->settings;
    unit u = angle_unit(s->unit);
    bool first = true, headed = call->common.json, any = false;
    lw_status checked = lw_text_check(text, size, file, e);
    if (checked != LW_OK)
        return checked;
    for (int line = 1; *text && !cli_interrupted(); line++) {
        const char *end = text + strcspn(text, "\n"), *at = text + strspn(text, " \t\r");
        lw_fourbar_class c;
        double r[4];
        text = *end ? end + 1 : end;
        if (at >= end || *at == '#')
            continue;
        int numbers, columns = read_line(at, end, r, &numbers);
        if (first && numbers == 0 && columns == 4) {
            first = false;
            continue;
        }
        if (numbers != 4 || columns != 4)
            return lw_error_at(e, LW_E_NOTATION, file, line, 0, "a line has four lengths, as 4,2,5,3; here %s %d %s of "
                               "them %d number%s", columns == 1 ? "is" : "are", columns, columns == 1 ? "column,"
                               : "columns,", numbers, lw_plural(numbers));
        first = false;
        if (!headed)
            fprintf(f, "l1,l2,l3,l4,class,symbol,name,grashof,input_turns,output_turns,circuits,change_point_margin,"
                    "transmission_min_%s,transmission_max_%s\n", u.name, u.name);
        headed = any = true;
        bool closes = lw_fourbar_classify(r, s->tolerance, &c, NULL) == LW_OK;
        if (!call->common.json)
            write_row(f, r, closes ? &c : NULL, u);
        else if (closes)
            write_json(f, r, &c, u, 0);
        else
            write_open(f, r);
    }
    if (!any && !cli_interrupted())
        return lw_error_at(e, LW_NOTHING, file, 0, 0, "the table has no line of four lengths, as 4,2,5,3");
    return LW_OK;
}

static int run_table(const cli_call *call)
{
    char *text = NULL;
    size_t size;
    lw_output o;
    lw_error e = { 0 };
    const char *file = call->parsed.word[0];
    if (cli_read_file(file, "lines of four lengths", &text, &size, &e) != LW_OK)
        return cli_fail(call, &e);
    lw_status st = cli_open(call, &o, &e);
    if (st == LW_OK && (st = write_table(call, o.f, file, text, size, &e)) != LW_OK)
        lw_output_abandon(&o);
    free(text);
    return st == LW_OK ? cli_close(call, &o, CLI_DONE) : cli_fail(call, &e);
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    double r[4];
    if (call->parsed.n_word == 1)
        return run_table(call);
    if (call->parsed.n_word != 4)
        return cli_usage(call, "give the four lengths L1 L2 L3 L4, or one file with four lengths in each line");
    lw_fourbar_class c;
    lw_output o;
    lw_error e = { 0 };
    if (read_lengths(call, r, &e) != LW_OK || lw_fourbar_classify(r, s->tolerance, &c, &e) != LW_OK || cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    unit u = angle_unit(s->unit);
    if (call->common.json)
        write_json(o.f, r, &c, u, 2);
    else
        write_text(o.f, &c, u);
    return cli_close(call, &o, CLI_DONE);
}

const cli_command cli_classify_command = {
    .name = "classify",
    .words = "L1 L2 L3 L4 | FILE.csv",
    .title = "type of motion of a four-bar, with limits, dead points and transmission angles",
    .examples =
        "  linkwright classify 4 2 5 3                     a crank-rocker? its limits\n"
        "  linkwright classify 4 2 4 2 --tolerance 1e-9    a parallelogram is a change point\n"
        "  linkwright classify 0.1 0.03 0.08 0.09 --json   the same for programs\n"
        "  linkwright classify lengths.csv                 a row for each line of four lengths\n",
    .about =
        "Give the lengths in the order frame, input, coupler, output, all in one unit. Classes are the numbers 1\n"
        "to 14 of Barker (1985). Input angles count counter-clockwise from the frame line. 'Limits' are input\n"
        "angles at which the motion must turn back. 'Dead points' are input angles at which input and coupler are\n"
        "in line, so that the output cannot drive. 'Transmission' is the range of the angle between coupler and\n"
        "output. Lengths that cannot be assembled give exit code 3.\n"
        "\n"
        "FILE has four lengths in each line, with commas or blanks between them; a first line of names and lines\n"
        "that begin with # are passed over, - is standard input. The answer is a CSV row for each, with --json one\n"
        "object a line; lengths that cannot be assembled have no class.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 4,
    .run = run,
    .reads = CLI_LENGTHS,
};
