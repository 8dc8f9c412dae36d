/* cli/motion/drive_simulate.c - the simulated loop of a servo axis: figures, rows, matrices, plot. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/number.h"
#include "base/real.h"
#include "base/vec2.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/drive.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "mbs/drives/servo_linear.h"
#include "mbs/drives/servo_run.h"

enum { COLUMNS = 12, POLES = LW_MATRIX_STATE_MAX };

typedef struct job {
    const cli_call *call;
    lw_servo   servo;
    lw_servo_options o;
    lw_servo_report  r;
    size_t     n_row;
    double    *row;                      /* (n_row * COLUMNS) */
    int        n_pole;                   /* of the whole; < 0: not found */
    double     re[POLES], im[POLES];
    char       why[200];                 /* why they are not */
    lw_servo_margin margin[3];
} job;

static const char *const columns[COLUMNS] = { "t", "wanted", "wanted_speed", "position", "speed", "error", "motor_position",
                                              "motor_speed", "current", "voltage", "torque", "heat" };

static lw_status keep(void *context, const lw_servo_row *row)
{
    job *b = context;
    const double x[COLUMNS] = { row->t, row->wanted.x, row->wanted.v, row->position, row->speed, row->error,
                                row->motor_position, row->motor_speed, row->current, row->voltage, row->torque, row->heat };
    memcpy(b->row + b->n_row++*COLUMNS, x, sizeof x);
    return LW_OK;
}

static const char *unit_of(const lw_servo *s, int column)
{
    static const char *const slide[COLUMNS] = { "s", "m", "m/s", "m", "m/s", "m", "m", "m/s", "A", "V", "N m", "J" };
    static const char *const shaft[COLUMNS] = { "s", "rad", "rad/s", "rad", "rad/s", "rad", "rad", "rad/s", "A", "V", "N m",
                                                "J" };
    return (s->slides ? slide : shaft)[column];
}

/* ---- text and JSON ------------------------------------------------------------------------------------------- */

typedef struct figure { const char *key, *words, *unit; double value; } figure;

enum { N_FIGURE = 21 };

static void fill_figures(const job *b, figure *f)
{
    const lw_servo_report *r = &b->r;
    const char *x = b->servo.slides ? "m" : "rad";
    const figure all[N_FIGURE] = {
        { "motion_end", "end of the motion", "s", r->end },
        { "error_peak", "greatest error", x, r->error_peak },
        { "error_peak_time", "  at", "s", r->error_peak_t },
        { "error_end", "error at the end of the run", x, r->error_end },
        { "settled", "inside the band from", "s", r->settled },
        { "overshoot", "overshoot", x, r->overshoot },
        { "current_peak", "greatest current", "A", r->current_peak },
        { "current_rms", "rms current", "A", r->current_rms },
        { "current_limited", "  at its limit", "s", r->current_limited },
        { "voltage_peak", "greatest voltage", "V", r->voltage_peak },
        { "voltage_limited", "  at its limit", "s", r->voltage_limited },
        { "torque_peak", "greatest torque of the motor", "N m", r->torque_peak },
        { "speed_peak", "greatest speed of the motor", "rad/s", r->speed_peak },
        { "electrical", "energy from the amplifier", "J", r->electrical },
        { "heat", "  heat in the copper", "J", r->heat },
        { "friction", "  friction", "J", r->friction },
        { "transmission", "  damping of the transmission", "J", r->transmission },
        { "stored", "  stored at the end", "J", r->stored },
        { "work", "work of the force on the load", "J", r->work },
        { "energy_error", "error of the balance", "J", r->energy_error },
        { "band", "band", x, b->o.band },
    };
    memcpy(f, all, sizeof all);
}

static const char *const loop_name[] = { "position", "speed", "current" };

static int n_loop(const job *b) { return b->servo.ideal_current ? 2 : 3; }

static void print_text(const job *b, FILE *f)
{
    figure figures[N_FIGURE];
    fill_figures(b, figures);
    for (int i = 0; i < N_FIGURE; i++)
        if (isfinite(figures[i].value))
            fprintf(f, "%-34s %.9g %s\n", figures[i].words, figures[i].value, figures[i].unit);
        else
            fprintf(f, "%-34s never\n", figures[i].words);
    for (int k = 0; k < n_loop(b); k++) {
        const lw_servo_margin *m = &b->margin[k];
        fprintf(f, "%s loop:%*s", loop_name[k], (int)(29 - strlen(loop_name[k])), "");
        if (isnan(m->crossover))
            fputs("gain below 1 everywhere", f);
        else
            fprintf(f, "crossover %.6g Hz, phase margin %.4g deg", m->crossover/(2*LW_PI), m->phase*180/LW_PI);
        if (!isnan(m->reversal))
            fprintf(f, ", gain margin %.4g dB at %.6g Hz", 20*log10(m->gain), m->reversal/(2*LW_PI));
        fputc('\n', f);
    }
    if (b->n_pole < 0)
        fprintf(f, "poles of the whole: not found: %s\n", b->why);
    else
        fputs("poles of the whole [1/s]:\n", f);
    for (int k = 0; k < b->n_pole; k++)
        if (b->im[k] >= 0)
            fprintf(f, b->im[k] > 0 ? "  %.9g +- %.9g i\n" : "  %.9g\n", b->re[k], b->im[k]);
}

static void print_rows(const job *b, FILE *f)
{
    fputs("# units:", f);
    for (int c = 0; c < COLUMNS; c++)
        fprintf(f, "%c%s", c ? ',' : ' ', unit_of(&b->servo, c));
    fputc('\n', f);
    for (int c = 0; c < COLUMNS; c++)
        fprintf(f, "%s%s", c ? "," : "", columns[c]);
    fputc('\n', f);
    for (size_t r = 0; r < b->n_row; r++)
        for (int c = 0; c < COLUMNS; c++) {
            char text[LW_NUMBER_SIZE];
            lw_number_print(b->row[r*COLUMNS + (size_t)c], text);
            fprintf(f, "%s%s", text, c + 1 < COLUMNS ? "," : "\n");
        }
}

static void print_json(const job *b, FILE *f, bool rows)
{
    figure figures[N_FIGURE];
    cli_json j = cli_json_begin(f, 2);
    fill_figures(b, figures);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "version", LW_VERSION);
    cli_json_text(&j, "command", b->call->line);
    for (int i = 0; i < N_FIGURE; i++)
        cli_json_real(&j, figures[i].key, figures[i].value);
    cli_json_array(&j, "loops");
    for (int k = 0; k < n_loop(b); k++) {
        cli_json_object(&j, NULL);
        cli_json_text(&j, "loop", loop_name[k]);
        cli_json_real(&j, "crossover", b->margin[k].crossover);
        cli_json_real(&j, "phase_margin", b->margin[k].phase);
        cli_json_real(&j, "reversal", b->margin[k].reversal);
        cli_json_real(&j, "gain_margin", b->margin[k].gain);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    if (b->n_pole >= 0)
        cli_json_bool(&j, "stable", b->n_pole == 0 || b->re[0] <= 0);
    cli_json_array(&j, "poles");
    for (int k = 0; k < b->n_pole; k++)
        cli_json_reals(&j, NULL, (double[]){ b->re[k], b->im[k] }, 2);
    cli_json_end(&j);
    if (rows) {
        cli_json_array(&j, "columns");
        for (int c = 0; c < COLUMNS; c++)
            cli_json_text(&j, NULL, columns[c]);
        cli_json_end(&j);
        cli_json_array(&j, "units");
        for (int c = 0; c < COLUMNS; c++)
            cli_json_text(&j, NULL, unit_of(&b->servo, c));
        cli_json_end(&j);
        cli_json_array(&j, "rows");
        for (size_t r = 0; r < b->n_row; r++)
            cli_json_reals(&j, NULL, b->row + r*COLUMNS, COLUMNS);
        cli_json_end(&j);
    }
    cli_json_end(&j);
}

/* ---- matrices -------------------------------------------------------------------------------------------------- */

static void put_matrix(cli_json *j, const char *key, const double *a, int rows, int n)
{
    cli_json_array(j, key);
    for (int i = 0; i < rows; i++)
        cli_json_reals(j, NULL, a + (size_t)i*(size_t)n, (size_t)n);
    cli_json_end(j);
}

static void put_names(cli_json *j, const char *key, const char *const *name, int n)
{
    cli_json_array(j, key);
    for (int i = 0; i < n; i++)
        cli_json_text(j, NULL, name[i]);
    cli_json_end(j);
}

static void put_matrices(cli_json *j, const char *key, const lw_state_matrices *m)
{
    cli_json_object(j, key);
    cli_json_real(j, "sample", m->sample);
    put_names(j, "states", m->state, m->n_state);
    put_names(j, "inputs", m->input, m->n_input);
    put_names(j, "outputs", m->output, m->n_output);
    put_matrix(j, "A", m->a, m->n_state, m->n_state);
    put_matrix(j, "B", m->b, m->n_state, m->n_input);
    put_matrix(j, "C", m->c, m->n_output, m->n_state);
    put_matrix(j, "D", m->d, m->n_output, m->n_input);
    cli_json_end(j);
}

static lw_status write_matrices(const job *b, const char *path, lw_error *e)
{
    lw_state_matrices plant, whole;
    lw_error none = { 0 };
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_servo_plant(&b->servo, &plant);
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    put_matrices(&j, "plant", &plant);
    if (lw_servo_closed(&b->servo, &whole, &none) == LW_OK)
        put_matrices(&j, "whole", &whole);
    cli_json_end(&j);
    lw_status s = fclose(f) == 0 ? lw_file_write(path, text, size, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(text);
    return s;
}

/* ---- plot -------------------------------------------------------------------------------------------------------- */

static lw_status draw(const job *b, const char *path, lw_error *e)
{
    static const int panel[][3] = { { 1, 3, -1 }, { 2, 4, -1 }, { 5, -1, -1 }, { 8, -1, -1 }, { 9, -1, -1 } };
    enum { PANELS = sizeof panel/sizeof *panel };
    lw_plot plot[PANELS] = { 0 };
    lw_series series[PANELS][2];
    char label[PANELS][40];
    size_t n = b->n_row;
    double *x = malloc(COLUMNS*n*sizeof *x);
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t r = 0; r < n; r++)
        for (size_t c = 0; c < COLUMNS; c++)
            x[c*n + r] = b->row[r*COLUMNS + c];
    for (int p = 0; p < PANELS; p++) {
        int count = 0;
        for (; panel[p][count] >= 0; count++)
            series[p][count] = (lw_series){ .name = columns[panel[p][count]], .n = n, .x = x,
                                            .y = x + (size_t)panel[p][count]*n };
        snprintf(label[p], sizeof label[p], "[%s]", unit_of(&b->servo, panel[p][0]));
        plot[p] = (lw_plot){ .y_label = label[p], .x_label = p == PANELS - 1 ? "t [s]" : NULL, .n_series = count,
                             .series = series[p] };
    }
    plot[0].title = b->servo.name[0] ? b->servo.name : NULL;
    plot[0].height = 200*PANELS;
    lw_status s = lw_draw_plots(PANELS, plot, path, e);
    free(x);
    return s;
}

/* ---- the action --------------------------------------------------------------------------------------------------- */

static lw_status analyse(job *b, lw_error *e)
{
    lw_state_matrices m;
    lw_error inner = { 0 };
    for (int k = 0; k < n_loop(b); k++)
        b->margin[k] = lw_servo_margin_of(&b->servo, k);
    lw_status s = lw_servo_closed(&b->servo, &m, &inner);
    if (s == LW_OK)
        s = lw_matrices_poles(&m, &b->n_pole, b->re, b->im);
    if (s == LW_OK)
        return s;
    b->n_pole = -1;
    snprintf(b->why, sizeof b->why, "%.190s", inner.text);
    return s == LW_E_KIND ? LW_OK : lw_error_set(e, s, "the poles of the loop are not found: %s", inner.text);
}

static bool is_unstable(const job *b) { return b->n_pole > 0 && b->re[0] > 1e-9*fabs(b->re[b->n_pole - 1]); }

static lw_status run_job(job *b, const char *file, lw_error *e)
{
    const cli_drive_settings *s = b->call->settings;
    char *text = NULL;
    size_t size = 0;
    lw_status st = cli_read_file(file, "servo axis", &text, &size, e);
    if (st == LW_OK)
        st = lw_servo_read(text, size, file, &b->servo, e);
    free(text);
    if (st != LW_OK)
        return st;
    b->o = lw_servo_options_default();
    b->o.to = cli_given(&b->call->parsed, "to") ? s->to : 0;
    b->o.intervals = s->steps;
    b->o.band = s->band;
    b->o.stop = cli_stop_flag();
    b->row = malloc(((size_t)s->steps + 1)*COLUMNS*sizeof *b->row);
    if (!b->row)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    st = analyse(b, e);
    if (st != LW_OK)
        return st;
    st = lw_servo_run(&b->servo, &b->o, keep, b, &b->r, e);
    if (st == LW_E_NUMERIC && is_unstable(b)) {
        char why[sizeof e->text];
        snprintf(why, sizeof why, "%.300s", e->text);
        lw_error_set(e, st, "%s: the loop is unstable, its pole %.6g %+.6g i 1/s grows", why, b->re[0], fabs(b->im[0]));
    }
    return st;
}

int cli_drive_simulate(const cli_call *call)
{
    const cli_drive_settings *s = call->settings;
    lw_error e = { 0 };
    lw_draw_kind kind;
    lw_output o;
    bool rows = cli_given(&call->parsed, "steps");
    if (cli_given(&call->parsed, "speed") || cli_given(&call->parsed, "from"))
        return cli_usage(call, "--speed and --from are options of 'drive load'");
    if (cli_given(&call->parsed, "to") && !(s->to > 0))
        return cli_usage(call, "--to must be greater than 0");
    if (s->plot && lw_draw_kind_of(s->plot, &kind, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    job *b = calloc(1, sizeof *b);
    if (b)
        b->call = call;
    lw_status st = b ? run_job(b, call->parsed.word[1], &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        st = cli_open(call, &o, &e);
    int code = st == LW_OK ? CLI_DONE : cli_fail(call, &e);
    if (st == LW_OK) {
        if (is_unstable(b))
            cli_note(call, "the loop is unstable: its pole %.6g %+.6g i 1/s grows; what is printed holds within the limits of "
                     "the amplifier", b->re[0], fabs(b->im[0]));
        if (call->common.json)
            print_json(b, o.f, rows);
        else if (rows)
            print_rows(b, o.f);
        else
            print_text(b, o.f);
        code = cli_close(call, &o, code);
        if (code == CLI_DONE && ((s->matrices && write_matrices(b, s->matrices, &e) != LW_OK) ||
                                 (s->plot && draw(b, s->plot, &e) != LW_OK)))
            code = cli_fail(call, &e);
    }
    if (b) {
        lw_servo_free(&b->servo);
        free(b->row);
    }
    free(b);
    return code;
}
