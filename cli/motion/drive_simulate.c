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

enum { COLUMNS = 12, POLES = LW_MATRIX_STATE_MAX };

typedef struct job {
    const cli_call *call;
    lw_servo   servo;
    lw_servo_options o;
    lw_servo_report  r;
    size_t     n_row;
    double    *row;                      /* (n_row * COLUMNS) */
    FILE      *f;                        /* gets each row at once; NULL: none does */
    int        n_pole;                   /* of the whole; < 0: not found */
    double     re[POLES], im[POLES];
    char       why[200];                 /* why they are not */
    lw_servo_margin margin[3];
} job;

static const char *const columns[COLUMNS] = { "t", "wanted", "wanted_speed", "position", "speed", "error", "motor_position",
                                              "motor_speed", "current", "voltage", "torque", "heat" };

static void print_row(const double *row, FILE *f)
{
    for (int c = 0; c < COLUMNS; c++) {
        char text[LW_NUMBER_SIZE];
        lw_number_print(row[c], text);
        fprintf(f, "%s%s", text, c + 1 < COLUMNS ? "," : "\n");
    }
}

static lw_status keep(void *context, const lw_servo_row *row)
{
    job *b = context;
    const double x[COLUMNS] = { row->t, row->wanted.x, row->wanted.v, row->position, row->speed, row->error,
                                row->motor_position, row->motor_speed, row->current, row->voltage, row->torque, row->heat };
    memcpy(b->row + b->n_row++*COLUMNS, x, sizeof x);
    if (b->f)
        print_row(x, b->f);
    return b->f && ferror(b->f) ? LW_E_IO : LW_OK;
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

static void print_head(const job *b, FILE *f)
{
    fputs("# units:", f);
    for (int c = 0; c < COLUMNS; c++)
        fprintf(f, "%c%s", c ? ',' : ' ', unit_of(&b->servo, c));
    fputc('\n', f);
    for (int c = 0; c < COLUMNS; c++)
        fprintf(f, "%s%s", c ? "," : "", columns[c]);
    fputc('\n', f);
}

static void print_json(const job *b, cli_json j, bool rows)
{
    figure figures[N_FIGURE];
    fill_figures(b, figures);
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
    put_names(j, "state_units", m->state_unit, m->n_state);
    put_names(j, "inputs", m->input, m->n_input);
    put_names(j, "input_units", m->input_unit, m->n_input);
    put_names(j, "outputs", m->output, m->n_output);
    put_names(j, "output_units", m->output_unit, m->n_output);
    put_matrix(j, "A", m->a, m->n_state, m->n_state);
    put_matrix(j, "B", m->b, m->n_state, m->n_input);
    put_matrix(j, "C", m->c, m->n_output, m->n_state);
    put_matrix(j, "D", m->d, m->n_output, m->n_input);
    cli_json_end(j);
}

/* Find the matrices of the closed loop.  *known is false if its sampling times have no common period. */
static lw_status find_whole(const job *b, lw_state_matrices *m, bool *known, lw_error *e)
{
    lw_error why = { 0 };
    lw_status s = lw_servo_closed(&b->servo, m, &why);
    *known = s == LW_OK;
    if (s == LW_OK || s == LW_E_KIND)
        return LW_OK;
    *e = why;
    return s;
}

static lw_status write_matrices(const job *b, const char *path, lw_error *e)
{
    lw_state_matrices plant, whole;
    bool known = false;
    if (find_whole(b, &whole, &known, e) != LW_OK)
        return e->status;
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_servo_plant(&b->servo, &plant);
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    put_matrices(&j, "plant", &plant);
    if (known)
        put_matrices(&j, "whole", &whole);
    cli_json_end(&j);
    lw_status s = fclose(f) == 0 ? lw_file_write(path, text, size, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(text);
    return s;
}

/* One matrix: a line of units, then names of the columns and rows, as pandas, Octave or a table read them. */
static lw_status write_table(const char *folder, const char *system, char which, double sample, int rows, int n,
                             const double *x, const char *const *row, const char *const *row_unit,
                             const char *const *column, const char *const *column_unit, lw_error *e)
{
    char path[CLI_PATH_SIZE], number[LW_NUMBER_SIZE];
    lw_output o;
    snprintf(path, sizeof path, "%s/%s-%c.csv", folder, system, which);
    lw_status s = lw_output_open(&o, path, e);
    if (s != LW_OK)
        return s;
    fprintf(o.f, "# %c of the %s, ", which, strcmp(system, "plant") == 0 ? "axis without controllers" : "closed loop");
    fprintf(o.f, sample > 0 ? "discrete, sample %.17g s\n" : "continuous\n", sample);
    fputs("name", o.f);
    for (int k = 0; k < n; k++)
        fprintf(o.f, ",%s [%s]", column[k], column_unit[k]);
    fputc('\n', o.f);
    for (int i = 0; i < rows; i++) {
        fprintf(o.f, "%s [%s]", row[i], row_unit[i]);
        for (int k = 0; k < n; k++) {
            lw_number_print(x[i*n + k] + 0.0, number);
            fprintf(o.f, ",%s", number);
        }
        fputc('\n', o.f);
    }
    return lw_output_commit(&o, e);
}

static lw_status write_tables(const char *folder, const char *system, const lw_state_matrices *m, lw_error *e)
{
    lw_status s = write_table(folder, system, 'A', m->sample, m->n_state, m->n_state, m->a, m->state, m->state_unit, m->state,
                              m->state_unit, e);
    if (s == LW_OK)
        s = write_table(folder, system, 'B', m->sample, m->n_state, m->n_input, m->b, m->state, m->state_unit, m->input, m->input_unit, e);
    if (s == LW_OK)
        s = write_table(folder, system, 'C', m->sample, m->n_output, m->n_state, m->c, m->output, m->output_unit, m->state,
                        m->state_unit, e);
    if (s == LW_OK)
        s = write_table(folder, system, 'D', m->sample, m->n_output, m->n_input, m->d, m->output, m->output_unit, m->input,
                        m->input_unit, e);
    return s;
}

static lw_status write_folder(const job *b, const char *folder, lw_error *e)
{
    lw_state_matrices m;
    bool known = false;
    lw_servo_plant(&b->servo, &m);
    lw_status s = write_tables(folder, "plant", &m, e);
    if (s == LW_OK)
        s = find_whole(b, &m, &known, e);
    return s == LW_OK && known ? write_tables(folder, "whole", &m, e) : s;
}

static int check_folder(const cli_call *call, const char *folder)
{
    int code = cli_make_folder(call, folder);
    for (int i = 0; i < 8 && code == CLI_DONE; i++)
        code = cli_may_write_in(call, folder, "%s-%c.csv", i < 4 ? "plant" : "whole", 'A' + i%4);
    return code;
}

/* ---- Bode plot ------------------------------------------------------------------------------------------------- */

enum { BODE = 1500 };

/* Frequencies worth a look: around the crossovers and where the phase is -180 degrees [rad/s]. */
static void bode_range(const job *b, double *low, double *high)
{
    *low = INFINITY, *high = 0;
    for (int k = 0; k < n_loop(b); k++) {
        const double at[] = { b->margin[k].crossover, b->margin[k].reversal };
        for (int i = 0; i < 2; i++)
            if (!isnan(at[i]))
                *low = fmin(*low, at[i]), *high = fmax(*high, at[i]);
    }
    if (!(*high > 0))
        *low = 1, *high = 1000;
    *low /= 30, *high *= 5;
}

/* f, gain [dB] and phase [deg] of a loop; NaN beyond half its sampling frequency. */
static void bode_loop(const job *b, int k, double low, double high, double *f, double *gain, double *phase)
{
    const lw_servo_loop *loops[] = { &b->servo.position, &b->servo.speed, &b->servo.circuit };
    double last = -LW_PI/2, most = loops[k]->sample > 0 ? LW_PI/loops[k]->sample : INFINITY;
    for (int i = 0; i < BODE; i++) {
        double w = low*pow(high/low, i/(BODE - 1.0)), g, p;
        f[i] = w <= most ? w/(2*LW_PI) : NAN;
        lw_servo_response(&b->servo, k, w, &g, &p);
        p += 2*LW_PI*rint((last - p)/(2*LW_PI));
        last = p;
        gain[i] = 20*log10(g);
        phase[i] = p*180/LW_PI;
    }
}

static lw_status draw_bode(const job *b, const char *path, lw_error *e)
{
    lw_series gains[6], phases[6], poles[POLES];
    lw_level zero = { "gain 1", 0 }, half = { "-180 degrees", -180 };
    char text[6][120], pole_text[POLES][80];
    double mark[3][6], low, high;
    int n = n_loop(b), n_gain = 0, n_phase = 0, n_pole = 0;
    double *x = malloc(3*3*BODE*sizeof *x);
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    bode_range(b, &low, &high);
    for (int k = 0; k < n; k++) {
        double *f = x + 3*k*BODE, *gain = f + BODE, *phase = gain + BODE;
        bode_loop(b, k, low, high, f, gain, phase);
        gains[n_gain++] = (lw_series){ .name = loop_name[k], .n = BODE, .x = f, .y = gain };
        phases[n_phase++] = (lw_series){ .name = loop_name[k], .n = BODE, .x = f, .y = phase };
    }
    for (int k = 0; k < n; k++) {
        const lw_servo_margin *m = &b->margin[k];
        const double *f = x + 3*k*BODE, *phase = f + 2*BODE;
        if (!isnan(m->reversal)) {
            mark[k][0] = m->reversal/(2*LW_PI), mark[k][1] = -20*log10(m->gain);
            snprintf(text[k], sizeof text[k], "%s margin %.3g dB at %.4g Hz", loop_name[k], 20*log10(m->gain), mark[k][0]);
            gains[n_gain++] = (lw_series){ .name = text[k], .n = 1, .x = &mark[k][0], .y = &mark[k][1], .style
                                           = LW_SERIES_POINTS };
        }
        if (!isnan(m->crossover)) {                        /* on the turn of the curve */
            double at = m->phase*180/LW_PI - 180, near = at;
            mark[k][2] = m->crossover/(2*LW_PI);
            for (int i = 0; i < BODE && f[i] <= mark[k][2]; i++)
                near = phase[i];
            mark[k][3] = at + 360*rint((near - at)/360);
            snprintf(text[3 + k], sizeof text[3], "%s margin %.3g deg at %.4g Hz", loop_name[k], m->phase*180/LW_PI, mark[k][2]);
            phases[n_phase++] = (lw_series){ .name = text[3 + k], .n = 1, .x = &mark[k][2], .y = &mark[k][3],
                                             .style = LW_SERIES_POINTS };
        }
    }
    for (int k = 0; k < b->n_pole; k++) {
        if (b->im[k] < 0)
            continue;
        bool twin = b->im[k] > 0;
        snprintf(pole_text[n_pole], sizeof pole_text[0], twin ? "%.5g +- %.5g i" : "%.5g", b->re[k], b->im[k]);
        int at = twin && k + 1 < b->n_pole && b->re[k + 1] == b->re[k] ? k : twin && k > 0 && b->re[k - 1] == b->re[k] ? k - 1 : k;
        poles[n_pole] = (lw_series){ .name = pole_text[n_pole], .n = twin ? 2 : 1, .x = &b->re[at], .y = &b->im[at], .style
                                     = LW_SERIES_POINTS };
        n_pole++;
    }
    lw_plot plot[3] = {
        { .title = b->servo.name[0] ? b->servo.name : "open loops", .y_label = "gain [dB]", .log_x = true, .n_series = n_gain,
          .series = gains, .n_level = 1, .level = &zero, .height = 960 },
        { .x_label = "frequency [Hz]", .y_label = "phase [deg]", .log_x = true, .n_series = n_phase, .series = phases,
          .n_level = 1, .level = &half },
        { .x_label = "poles of the whole: real part [1/s]", .y_label = "imaginary [1/s]", .n_series = n_pole, .series = poles } };
    lw_status s = lw_draw_plots(n_pole > 0 ? 3 : 2, plot, path, e);
    free(x);
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
    return s == LW_E_KIND ? LW_OK : lw_error_set(e, s, "the poles of the loop are not found: %s", inner.text[0] ? inner.text : lw_status_text(s));
}

static bool is_unstable(const job *b) { return b->n_pole > 0 && b->re[0] > 1e-9*fabs(b->re[b->n_pole - 1]); }

static lw_status read_job(job *b, const char *file, lw_error *e)
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
    return analyse(b, e);
}

static lw_status run_job(job *b, lw_error *e)
{
    lw_status st = lw_servo_run(&b->servo, &b->o, keep, b, &b->r, e);
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
    lw_output o;
    bool rows = cli_given(&call->parsed, "steps"), part = false;
    if (cli_given(&call->parsed, "to") && !(s->to > 0))
        return cli_usage(call, "--to must be greater than 0");
    int folder = s->folder ? check_folder(call, s->folder) : CLI_DONE;
    if (folder != CLI_DONE)
        return folder;
    job *b = calloc(1, sizeof *b);
    if (b)
        b->call = call;
    lw_status st = b ? read_job(b, call->parsed.word[1], &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        st = cli_open(call, &o, &e);
    cli_json j = { 0 };
    if (st == LW_OK) {                           /* an output that takes no line ends the work */
        if (call->common.json) {
            j = cli_json_begin(o.f, 2);
            cli_json_head(&j, call->line);
        } else if (rows) {
            print_head(b, o.f);
            b->f = o.f;
        }
        st = run_job(b, &e);
        if (st != LW_OK && ferror(o.f))
            lw_error_at(&e, LW_E_IO, o.path, 0, 0, "cannot be written");
        part = st != LW_OK && b->f && b->n_row > 0 && !ferror(o.f);
        if (st != LW_OK && !part)
            lw_output_abandon(&o);
    }
    int code = st == LW_OK ? CLI_DONE : part && st == LW_STOPPED ? CLI_LIMIT : cli_fail(call, &e);
    if (part)
        code = cli_close(call, &o, code);
    if (st == LW_OK) {
        if (is_unstable(b))
            cli_note(call, "the loop is unstable: its pole %.6g %+.6g i 1/s grows; what is printed holds within the limits of "
                     "the amplifier", b->re[0], fabs(b->im[0]));
        if (call->common.json)
            print_json(b, j, rows);
        else if (!rows)
            print_text(b, o.f);
        code = cli_close(call, &o, code);
        if (code == CLI_DONE && ((s->matrices && write_matrices(b, s->matrices, &e) != LW_OK) ||
                                 (s->folder && write_folder(b, s->folder, &e) != LW_OK) ||
                                 (s->bode && draw_bode(b, s->bode, &e) != LW_OK) ||
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
