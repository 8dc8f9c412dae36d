#include "cli/motion/trace.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "cli/program/output.h"
#include "mbs/kinematics/output_limits.h"

#define TURN_MAX 64

/* ---- ranges ------------------------------------------------------------------------------------ */

/* Input as the user counts it (directions in the plane; displacements by `value` of the file) minus input of the plan
 * (in the ground frame of the linkage). */
static double offset(const cli_trace *t) { return t->k.input[0].value - t->input; }

static double input_unit(const cli_trace *t)
{
    return t->plan.input_is_slider ? t->k.units.metre : t->k.units.radian;
}

static double shown_input(const cli_trace *t, double input)
{
    return (input + offset(t))/input_unit(t);
}

static double turn_of(const cli_trace *t) { return t->plan.input_is_slider ? 0 : 2*LW_PI; }

/* Add the part first .. last of an arc, shifted by whole turns for display. */
static void add_piece(cli_trace *t, int arc, double first, double last, double turns)
{
    const lw_arc *a = &t->motion.arc[arc];
    if (last < first)
        return;
    if (t->n_piece == CLI_PIECE_MAX) {
        t->dropped = true;
        return;
    }
    double move = turns*turn_of(t);
    t->piece[t->n_piece++] = (cli_piece){ arc, first + move, last + move,
                                          { a->limit[0] && first == a->first, a->limit[1] && last == a->last } };
}

/* Add a whole arc: a full turn starts at 0, a range starts within half a turn of 0. */
static void whole_arc(cli_trace *t, int arc)
{
    const lw_arc *a = &t->motion.arc[arc];
    double zero = -offset(t);
    if (a->turns)
        add_piece(t, arc, zero, zero + turn_of(t), 0);
    else if (t->plan.input_is_slider)
        add_piece(t, arc, a->first, a->last, 0);
    else
        add_piece(t, arc, a->first, a->last, -ceil((a->first - zero - LW_PI)/turn_of(t)));
}

/* Add the parts of the arc in from .. to, once for each number of whole turns that brings it there. */
static void cut_arc(cli_trace *t, int arc)
{
    const lw_arc *a = &t->motion.arc[arc];
    double from = t->from - offset(t), to = t->to - offset(t), turn = turn_of(t);
    if (a->turns) {
        add_piece(t, arc, from, to, 0);
        return;
    }
    double n0 = turn > 0 ? ceil((from - a->last)/turn) : 0;
    double n1 = turn > 0 ? floor((to - a->first)/turn) : 0;
    for (double n = n0; n <= n1 && !t->dropped; n++)
        add_piece(t, arc, fmax(a->first, from - n*turn), fmin(a->last, to - n*turn), n);
}

void cli_trace_pieces(cli_trace *t, bool only_file)
{
    int file_arc = lw_motion_arc(&t->plan, &t->motion, t->mode, t->input);
    t->n_piece = 0;
    t->dropped = false;
    for (int i = 0; i < t->motion.n_arc; i++) {
        if (only_file && i != file_arc)
            continue;
        if (t->whole)
            whole_arc(t, i);
        else
            cut_arc(t, i);
    }
}

/* ---- one row ----------------------------------------------------------------------------------- */

/* Angle of the tool, by whole turns near that of the row before. */
static double tool_angle(const cli_trace *t, const lw_posture *posture, int tracer, const double *before)
{
    double a = posture->angle[t->k.tracer[tracer].link][0] + t->tool[tracer];
    return before ? *before + remainder(a - *before, 2*LW_PI) : remainder(a, 2*LW_PI);
}

/* Derivatives are by the input in its own unit (rad, or the length unit of the file), or by time with --speed. */
static void row_values(const cli_trace *t, const lw_posture *posture, int tracer, double angle, double *v)
{
    lw_vec2 p[LW_ORDER_MAX + 1];
    double a[LW_ORDER_MAX + 1], scale = 1;
    double by = t->timed ? t->speed : t->plan.input_is_slider ? t->k.units.metre : 1;
    for (int order = 0; order <= LW_ORDER_MAX; order++, scale *= by) {
        p[order] = lw_v2_scale(posture->tracer[tracer][order], scale);
        a[order] = posture->angle[t->k.tracer[tracer].link][order]*scale;
    }
    cli_row_values(&t->rows, p, a, angle, v);
}

/* Print row `i` of `steps` of a piece. angle[] carries the tool angles [rad] from row to row. */
static void put_row(cli_trace *t, const cli_piece *p, const char *mode, int i, double *angle)
{
    CLI_ROW_SPACE;
    cli_row r = { .arc = p->arc + 1, .mode = mode, .n_lead = 1, .lead = lead, .value = value };
    bool end0 = i == 0, end1 = i == t->steps, limit = (end0 && p->limit[0]) || (end1 && p->limit[1]);
    const lw_arc *arc = &t->motion.arc[p->arc];
    double signs[LW_MODE_MAX];
    double input = end0 ? p->first : end1 ? p->last : p->first + (p->last - p->first)*i/t->steps;
    lw_posture posture;
    memcpy(signs, arc->mode, sizeof signs);
    if (limit)
        signs[arc->flips[end1]] = 0;
    lw_status s = lw_posture_solve(&t->plan, t->dim, signs, input, LW_ORDER_MAX, &posture);
    r.lead[0] = shown_input(t, input);
    r.rates = s == LW_OK && posture.margin > 0 && !limit;
    for (int k = 0; k < t->k.n_tracer; k++) {
        if (!cli_rows_want(&t->rows, k))
            continue;
        angle[k] = tool_angle(t, &posture, k, i ? &angle[k] : NULL);
        row_values(t, &posture, k, angle[k], r.value[k]);
    }
    cli_rows_put(&t->rows, &r);
}

static void put_rows(cli_trace *t, const cli_piece *p, const char *mode)
{
    double angle[LW_TRACER_MAX];
    for (int i = 0; i <= t->steps && !cli_rows_stopped(&t->rows); i++)
        put_row(t, p, mode, i, angle);
    if (!t->rows.json)
        cli_rows_arc_end(&t->rows, p->arc + 1);
}

static const char *mode_text(const cli_trace *t, const lw_arc *a, char *text)
{
    int n = t->plan.n_dyad;
    for (int d = 0; d < n; d++)
        text[d] = a->mode[d] < 0 ? '-' : '+';
    text[n] = 0;
    return text;
}

/* ---- CSV --------------------------------------------------------------------------------------- */

static void csv_arc(const cli_trace *t, const cli_piece *p)
{
    const lw_arc *a = &t->motion.arc[p->arc];
    char mode[LW_MODE_MAX + 1];
    fprintf(t->rows.f, "# arc %d: mode %s, circuit %d, input ", p->arc + 1, mode_text(t, a, mode), a->circuit + 1);
    cli_row_number(t->rows.f, shown_input(t, p->first));
    fputs(p->limit[0] ? " (limit) to " : " to ", t->rows.f);
    cli_row_number(t->rows.f, shown_input(t, p->last));
    fprintf(t->rows.f, "%s%s, transmission %.6g to %.6g deg%s\n", p->limit[1] ? " (limit)" : "",
            a->turns && t->whole ? ", turns fully" : "", a->transmission_min*180/LW_PI,
            a->transmission_max*180/LW_PI, t->whole ? "" : " over the whole arc");
}

static void csv_turnings(const cli_trace *t, const cli_piece *p)
{
    lw_output_limits turn[TURN_MAX];
    const double *mode = t->motion.arc[p->arc].mode;
    int n = lw_output_limits_find(&t->plan, &t->k, t->dim, mode, p->first, p->last, turn, TURN_MAX);
    for (int i = 0; i < n; i++) {
        fprintf(t->rows.f, "# dead point of arc %d: %s turns back at input ", p->arc + 1, t->k.link_name[turn[i].link]);
        cli_row_number(t->rows.f, shown_input(t, turn[i].input));
        fputc('\n', t->rows.f);
    }
}

void cli_trace_csv(cli_trace *t)
{
    fprintf(t->rows.f, "# %s\n", t->line);
    const char *length = t->k.units.length[0] ? t->k.units.length : "length";
    char lead[64];
    snprintf(lead, sizeof lead, "input %s", t->plan.input_is_slider ? length : t->k.units.angle);
    cli_rows_units(&t->rows, lead, t->timed ? "s" : t->plan.input_is_slider ? length : "rad");
    for (int i = 0; i < t->n_piece && !cli_rows_stopped(&t->rows); i++) {       /* turnings take longer than rows */
        csv_arc(t, &t->piece[i]);
        csv_turnings(t, &t->piece[i]);
    }
    cli_rows_head(&t->rows, "input");
    for (int i = 0; i < t->n_piece && !t->rows.cut_short; i++) {
        char mode[LW_MODE_MAX + 1];
        put_rows(t, &t->piece[i], mode_text(t, &t->motion.arc[t->piece[i].arc], mode));
    }
}

/* ---- JSON -------------------------------------------------------------------------------------- */

static void json_piece(cli_trace *t, cli_json *j, const cli_piece *p)
{
    const lw_arc *a = &t->motion.arc[p->arc];
    char mode[LW_MODE_MAX + 1];
    lw_output_limits turn[TURN_MAX];
    cli_json_object(j, NULL);
    cli_json_int(j, "arc", p->arc + 1);
    cli_json_text(j, "mode", mode_text(t, a, mode));
    cli_json_int(j, "circuit", a->circuit + 1);
    cli_json_reals(j, "range", (double[]){ shown_input(t, p->first), shown_input(t, p->last) }, 2);
    cli_json_bool(j, "first_is_limit", p->limit[0]);
    cli_json_bool(j, "last_is_limit", p->limit[1]);
    cli_json_bool(j, "turns", a->turns);
    cli_json_reals(j, "transmission_angle", (double[]){ a->transmission_min/t->k.units.radian,
                                                        a->transmission_max/t->k.units.radian }, 2);
    cli_json_array(j, "dead_points");
    int n = lw_output_limits_find(&t->plan, &t->k, t->dim, a->mode, p->first, p->last, turn, TURN_MAX);
    for (int i = 0; i < n; i++) {
        cli_json_object(j, NULL);
        cli_json_text(j, "link", t->k.link_name[turn[i].link]);
        cli_json_real(j, "input", shown_input(t, turn[i].input));
        cli_json_end(j);
    }
    cli_json_end(j);
    cli_json_array(j, "rows");
    put_rows(t, p, mode);
    cli_json_end(j);
    cli_rows_arc_end(&t->rows, p->arc + 1);
    cli_json_end(j);
}

void cli_trace_json(cli_trace *t)
{
    cli_json j = cli_json_begin(t->rows.f, 1);
    t->rows.json = &j;
    cli_json_head(&j, t->line);
    cli_json_text(&j, "name", t->k.name);
    cli_json_text(&j, "way", "plan");
    cli_json_object(&j, "units");
    cli_json_text(&j, "length", t->k.units.length);
    cli_json_text(&j, "angle", t->k.units.angle);
    cli_json_text(&j, "rates_by", t->timed ? "s" : t->plan.input_is_slider ? "length" : "rad");
    cli_json_end(&j);
    cli_rows_head(&t->rows, "input");
    cli_json_array(&j, "arcs");
    for (int i = 0; i < t->n_piece && !t->rows.cut_short; i++)
        json_piece(t, &j, &t->piece[i]);
    cli_json_end(&j);
    cli_json_end(&j);
}

void cli_note_nearly_flat(const cli_call *call, const lw_linkage *linkage)
{
    cli_trace *t = calloc(1, sizeof *t);
    if (t && lw_plan_make(linkage, (lw_plan_options){ .all_joints = true }, &t->plan, NULL) == LW_OK && t->plan.n_dyad == 1
        && lw_plan_read(&t->plan, linkage, t->dim, t->mode, &t->input, NULL) == LW_OK
        && lw_motion_find(&t->plan, t->dim, &t->motion) == LW_OK) {
        int arc = lw_motion_arc(&t->plan, &t->motion, t->mode, t->input);
        double left = arc < 0 ? 0 : lw_motion_nearly_flat(&t->motion, t->motion.arc[arc].circuit, !t->plan.input_is_slider);
        if (left > 0)
            cli_note(call, "two links come within %.2g deg of a straight line without passing it, as in a parallelogram or a kite drawn with "
                     "rounded numbers; the motion follows the rounded numbers, with exact ones it would pass a change point there "
                     "(see 'linkwright classify')", left*180/LW_PI);
    }
    free(t);
}
