/* Rows in time: inputs that are functions of it. */
#include "cli/motion/trace_curve.h"

#include <math.h>
#include <string.h>

static void lead_text(const cli_curve_trace *t, bool units, char *text, size_t size)
{
    size_t n = (size_t)snprintf(text, size, units ? "time s" : "time");
    for (int i = 0; i < t->k->n_input && n < size; i++) {
        char number[16] = "";
        if (i > 0)
            snprintf(number, sizeof number, "_%d", i + 1);
        n += (size_t)snprintf(text + n, size - n, units ? "; input%s %s" : ",input%s", number,
                              cli_curve_unit_name(t, i));
    }
}

static void begin(cli_curve_trace *t)
{
    char text[512];
    if (!t->rows.json) {
        fprintf(t->rows.f, "# %s\n", t->line);
        lead_text(t, true, text, sizeof text);
        cli_rows_units(&t->rows, text, "s");
        for (int i = 0; i < t->k->n_input; i++) {
            const lw_expression *x = t->model->motion[i];
            fprintf(t->rows.f, "# input %d, %s: %s\n", i + 1, t->k->joint[t->k->input[i].joint].name,
                    x ? lw_expression_text(x) : t->k->input[i].ratio != 0 ? "goes with input 1" : "rests");
        }
    }
    lead_text(t, false, text, sizeof text);
    cli_rows_head(&t->rows, text);
    if (t->rows.json) {
        cli_json_array(t->rows.json, "arcs");
        cli_json_object(t->rows.json, NULL);
        cli_json_int(t->rows.json, "arc", 1);
        cli_json_array(t->rows.json, "rows");
    }
}

static void put_posture(cli_curve_trace *t, lw_prescribed_motion *d, bool first)
{
    double series[(CLI_ROW_ORDER + 1)*LW_SYSTEM_Q_MAX] = { 0 }, u[LW_INPUT_MAX];
    cli_row row = { .arc = 1, .mode = ".", .n_lead = 1 + t->k->n_input };
    row.rates = lw_prescribed_motion_rates(d, CLI_ROW_ORDER, series);
    memcpy(series, lw_prescribed_motion_pose(d), (size_t)t->s.n_q*sizeof *series);
    row.lead[0] = lw_prescribed_motion_time(d);
    lw_prescribed_motion_of_model((void *)t->model, lw_prescribed_motion_time(d), 0, u);
    for (int i = 0; i < t->k->n_input; i++)
        row.lead[1 + i] = u[i]/cli_curve_unit(t, i);
    cli_curve_values(t, series, first, &row);
    cli_rows_put(&t->rows, &row);
}

lw_status cli_time_print(cli_curve_trace *t, const double range[3], lw_error *e)
{
    lw_prescribed_motion *d;
    lw_status s = lw_prescribed_motion_create(&t->s, lw_prescribed_motion_of_model, (void *)t->model, range[0], &d, e);
    if (s != LW_OK)
        return s;
    double n = floor((range[1] - range[0])/range[2]*(1 + 1e-12));
    t->rows.total = n + 1;
    begin(t);
    for (double i = 0; i <= n && s == LW_OK && !cli_rows_stopped(&t->rows); i++) {
        s = lw_prescribed_motion_to(d, range[0] + i*range[2]);
        if (s == LW_OK)
            put_posture(t, d, i == 0);
    }
    if (s == LW_OPEN)
        lw_error_set(e, s, "the motions lead beyond a limit of the linkage (a dead point of its inputs) at t = %.12g s;"
                     " the rows end before it", lw_prescribed_motion_time(d));
    else if (s != LW_OK)
        lw_error_set(e, s, "the motion is lost at t = %.12g s: an input jumps or is no number there, or no step is "
                     "short enough to stay on the branch; the rows end before it", lw_prescribed_motion_time(d));
    double last;
    int crossings = lw_prescribed_motion_crossings(d, &last);
    if (crossings > 0 && !t->rows.json)
        fprintf(t->rows.f, "# branch points passed straight on: %d, the last at time %.12g\n", crossings, last);
    if (t->rows.json) {
        cli_json_end(t->rows.json);
        cli_json_int(t->rows.json, "branch_points", crossings);
        cli_json_end(t->rows.json);
        cli_json_end(t->rows.json);
    }
    lw_prescribed_motion_free(d);
    return s;
}
