/* cli/robot/robot_map.c - condition number, lowest eigenfrequency and errors of the tool over a grid. */
#include "cli/robot/robot.h"

#include <stdlib.h>
#include "base/number.h"
#include "catalogues/pages/draw.h"
#include "cli/program/json.h"
#include "cli/program/progress.h"
#include "mbs/analysis/held.h"

#define BANDS 6

typedef struct map {
    bool   frequency, budget;                    /* asked for: --eigenfrequency, --errors                 */
    double *x, *y, *value;                       /* (grid * grid) places and what the plot shows of them  */
    int    n, lost;                              /* places measured; places that the tool does not reach  */
    lw_held held;
    lw_budget_options how;
    lw_budget_stiffness stiff;
    lw_robot_pose pose;                          /* of the last place, with what is asked for             */
    double hertz;
    lw_budget errors;
    double worst;                                /* greatest error of the tool [m], where, by which source */
    lw_vec3 worst_at;
    char   worst_by[96];
} map;

/* Edges of bands for frequencies: even steps of 1, 2, 2.5 or 5 times a power of ten. */
static void even_edges(const map *m, double edge[BANDS + 1])
{
    double least = INFINITY, most = 0;
    for (int i = 0; i < m->n; i++)
        least = fmin(least, m->value[i]), most = fmax(most, m->value[i]);
    double rough = fmax(most - least, 1e-3*most + 1e-9)/(BANDS - 1), ten = pow(10, floor(log10(rough)));
    double step = ten*(rough <= ten ? 1 : rough <= 2*ten ? 2 : rough <= 2.5*ten ? 2.5 : rough <= 5*ten ? 5 : 10), first = step*floor(least/step);
    for (int b = 0; b <= BANDS; b++)
        edge[b] = first + b*step;
}

/* Edges of bands for errors, which grow much towards the edge of the workspace: 1, 2, 5, 10, ... times a power of ten. */
static void rising_edges(const map *m, double edge[BANDS + 1])
{
    static const double step[] = { 1, 2, 5 };
    double least = INFINITY;
    for (int i = 0; i < m->n; i++)
        least = fmin(least, m->value[i]);
    double ten = least > 0 ? pow(10, floor(log10(least)*(1 + 1e-12))) : 1;
    int first = least >= 5*ten ? 2 : least >= 2*ten ? 1 : 0;
    for (int b = 0; b < BANDS; b++)
        edge[b] = step[(first + b)%3]*ten*pow(10, (first + b)/3);
    edge[0] = fmin(edge[0], least);
    edge[BANDS] = INFINITY;
}

/* Points by bands of the value. */
static int draw_map(const cli_robot *j, const map *m, const char *path, int code)
{
    lw_series series[BANDS];
    char name[BANDS][40], label[2][40];
    lw_error e;
    double edge[BANDS + 1] = { 1, 1.5, 2, 3, 5, 10, INFINITY };
    if (m->budget)
        rising_edges(m, edge);
    else if (m->frequency)
        even_edges(m, edge);
    double *xy = malloc(2*(size_t)m->n*sizeof *xy + 1);
    int used = 0, n_series = 0;
    if (!xy)
        return cli_fail(j->call, &(lw_error){ .status = LW_E_MEMORY, .text = "out of memory" });
    for (int b = 0; b < BANDS; b++) {
        int first = used;
        for (int i = 0; i < m->n; i++)
            if (m->value[i] >= edge[b] && m->value[i] < edge[b + 1]) {
                xy[used] = m->x[i];
                xy[m->n + used++] = m->y[i];
            }
        if (isfinite(edge[b + 1]))
            snprintf(name[b], sizeof name[b], "%g to %g%s", edge[b], edge[b + 1], m->budget || !m->frequency ? "" : " Hz");
        else
            snprintf(name[b], sizeof name[b], "above %g", edge[b]);
        if (used > first)
            series[n_series++] = (lw_series){ .name = name[b], .n = (size_t)(used - first), .x = xy + first,
                                              .y = xy + m->n + first, .style = LW_SERIES_POINTS };
    }
    snprintf(label[0], sizeof label[0], "to the right [%s]", j->unit);
    snprintf(label[1], sizeof label[1], "ahead [%s]", j->unit);
    lw_plot plot = { .title = m->budget ? "Greatest error of the tool" : m->frequency ? "Lowest eigenfrequency, drives held"
                     : "Condition number of the Jacobian",
                     .x_label = label[0], .y_label = label[1], .n_series = n_series, .series = series, .equal = true, .width = 760, .height = 640 };
    lw_status st = lw_draw_plot(&plot, path, &e);
    free(xy);
    return st < 0 ? cli_fail(j->call, &e) : code;
}

static void map_free(map *m)
{
    lw_budget_free(&m->errors);
    lw_budget_stiffness_free(&m->stiff);
    lw_held_free(&m->held);
}

/* Whatever the places need beside the posture itself. */
static int map_begin(cli_robot *j, map *m)
{
    *m = (map){ .frequency = j->s->frequency, .budget = j->s->budget };
    bool ready = (!m->frequency || lw_held_make(j->m, &m->held, &j->e) == LW_OK) &&
                 (!m->budget || (cli_robot_budget_options(j, &m->how, &j->e) == LW_OK && lw_budget_stiffness_make(j->m, &m->how, &m->stiff, &j->e) == LW_OK));
    return ready ? CLI_DONE : cli_fail(j->call, &j->e);
}

/* Half the width of the grid: how far the tool gets in twelve directions, and a little more. */
static double map_reach(cli_robot *j)
{
    double reach = 0;
    for (int i = 0; i < 12 && !cli_interrupted(); i++) {
        double far = 0;
        if (cli_robot_follow_ray(j, 2*LW_PI*i/12, &far) == LW_OK)
            reach = fmax(reach, far);
    }
    return 1.02*reach;
}

/* Move the tool to a place and measure it there.  LW_OPEN: it is not reached, or the drives lose the tool there. */
static lw_status map_measure(cli_robot *j, map *m, lw_vec3 to)
{
    static const double near_limits = 1e-5;      /* of the size: a place so near to a limit may count as not reached */
    cli_robot_go_back(j);
    j->r.least = near_limits;
    lw_status st = lw_robot_move(&j->r, to, NULL, &j->e);
    if (st == LW_OK)
        st = lw_robot_measure(&j->r, &m->pose, &j->e);
    if (st == LW_OK && m->frequency && (st = lw_held_frequency(&m->held, &j->r, &m->hertz, &j->e)) == LW_OPEN)
        st = LW_E_NUMERIC;
    if (st == LW_OK && m->budget) {
        lw_budget_free(&m->errors);
        st = lw_budget_make(&j->r, &m->stiff, &m->how, &m->errors, &j->e);
    }
    return st;
}

static void map_head(const cli_robot *j, const map *m, cli_json *w, FILE *f)
{
    if (w) {
        cli_json_head(w, j->call->line);
        cli_json_text(w, "length_unit", j->unit);
        cli_json_array(w, "places");
    } else
        fprintf(f, "# units: x y z %s; singular values m/rad or m/m%s%s%s\nx,y,z,condition,greatest,least,manipulability%s%s\n", j->unit,
                m->frequency ? "; frequency Hz" : "", m->budget ? "; error_worst error_rms " : "", m->budget ? j->unit : "",
                m->frequency ? ",frequency" : "", m->budget ? ",error_worst,error_rms,contributor" : "");
}

/* A place as an object of w, or as a line if w is NULL. */
static void put_place(const cli_robot *j, const map *m, cli_json *w, FILE *f, lw_vec3 at, const char *by)
{
    const lw_robot_pose *p = &m->pose;
    double place[] = { at.x/j->metre + 0.0, at.y/j->metre + 0.0, at.z/j->metre + 0.0 };
    double value[] = { p->condition, p->singular[0], p->singular[p->rank - 1], p->manipulability };
    static const char *const key[] = { "condition", "greatest", "least", "manipulability" };
    if (w) {
        cli_json_object(w, NULL);
        cli_json_reals(w, "place", place, 3);
    } else
        fprintf(f, "%.9g,%.9g,%.9g", place[0], place[1], place[2]);
    for (int i = 0; i < 4; i++)
        w ? cli_json_real(w, key[i], value[i]) : (void)fprintf(f, ",%.9g", value[i]);
    if (m->frequency)
        w ? cli_json_real(w, "frequency", m->hertz) : (void)fprintf(f, ",%.9g", m->hertz);
    if (m->budget && w) {
        cli_json_real(w, "error_worst", m->errors.worst/j->metre);
        cli_json_real(w, "error_rms", m->errors.rms/j->metre);
        cli_json_text(w, "contributor", by);
    } else if (m->budget) {
        fprintf(f, ",%.9g,%.9g,", m->errors.worst/j->metre, m->errors.rms/j->metre);
        cli_csv_text(f, by);
    }
    w ? cli_json_end(w) : (void)fputc('\n', f);
}

/* The place of the grid at (a, b) to the right and ahead of `centre`: measured, written and kept for the plot. */
static lw_status map_visit(cli_robot *j, map *m, lw_vec3 centre, double a, double b, cli_json *w, FILE *f)
{
    char name[96];
    lw_vec3 to = lw_v3_add(centre, lw_v3_add(lw_v3_scale(j->right, a), lw_v3_scale(j->ahead, b)));
    lw_status st = map_measure(j, m, to);
    m->lost += st == LW_OPEN;
    if (st != LW_OK)
        return st == LW_OPEN ? LW_OK : st;
    const char *by = m->errors.n ? cli_robot_source_name(&m->errors.source[0], name, sizeof name) : "";
    put_place(j, m, w, f, to, by);
    if (m->budget && m->errors.worst > m->worst) {
        m->worst = m->errors.worst, m->worst_at = to;
        snprintf(m->worst_by, sizeof m->worst_by, "%s", by);
    }
    m->x[m->n] = a/j->metre;
    m->y[m->n] = b/j->metre;
    m->value[m->n++] = m->budget ? m->errors.worst/j->metre : m->frequency ? m->hertz : m->pose.condition;
    return LW_OK;
}

static void map_notes(const cli_robot *j, const map *m)
{
    cli_note(j->call, "%d place%s; %d of the grid %s not reached on a straight way from the tool", m->n, lw_plural(m->n), m->lost,
             m->lost == 1 ? "is" : "are");
    if (m->worst > 0)
        cli_note(j->call, "error of the tool at most %.4g %s, at (%.6g, %.6g, %.6g) %s, where the greatest contributor is the %s", m->worst/j->metre,
                 j->unit, m->worst_at.x/j->metre, m->worst_at.y/j->metre, m->worst_at.z/j->metre, j->unit, m->worst_by);
}

/* The places of the map, and its notes. */
static int write_map(cli_robot *j, map *m, const lw_robot_pose *p, FILE *f)
{
    const cli_call *call = j->call;
    int n = j->s->grid, code = CLI_DONE;
    double reach = map_reach(j);
    if (cli_robot_gets_nowhere(j, p, reach) && !cli_interrupted())
        code = cli_robot_cannot_move(j, p), n = 0;
    j->r.least = 1e-4;                           /* where ways end is not shown */
    cli_progress progress = cli_progress_begin(call, "map", "places");
    cli_json json = cli_json_begin(f, 2), *w = call->common.json ? &json : NULL;
    map_head(j, m, w, f);
    for (int i = 0; i < n*n && !cli_interrupted(); i++) {
        double a = reach*(2.0*(i % n)/(n - 1) - 1), b = reach*(2.0*(i/n)/(n - 1) - 1);
        if (map_visit(j, m, p->place, a, b, w, f) != LW_OK) {
            code = cli_fail(call, &j->e);
            break;
        }
        cli_progress_show(&progress, i, (double)n*n, NULL);
    }
    cli_progress_end(&progress);
    if (w) {
        cli_json_end(w);
        cli_json_bool(w, "complete", code == CLI_DONE && !cli_interrupted());
        cli_json_end(w);
    }
    if (n > 0)
        map_notes(j, m);
    return code;
}

int cli_robot_map(const cli_call *call)
{
    cli_robot j;
    map m = { .n = 0 };
    lw_robot_pose p;
    lw_output o;
    size_t most = (size_t)((const cli_robot_settings *)call->settings)->grid;
    most *= most;
    int code = cli_robot_begin_ways(call, &j, &p, 3*most);
    if (code == CLI_DONE)
        code = map_begin(&j, &m);
    if (code == CLI_DONE && cli_open(call, &o, &j.e) != LW_OK)
        code = cli_fail(call, &j.e);
    if (code == CLI_DONE) {
        m.x = j.more, m.y = m.x + most, m.value = m.y + most;
        code = write_map(&j, &m, &p, o.f);
        code = cli_close(call, &o, code == CLI_DONE && m.n == 0 ? CLI_NOTHING : code);
        char partial[LW_PATH_SIZE + 16];
        const char *to = j.s->plot && m.n > 0 ? cli_picture_path(call, j.s->plot, code, partial) : NULL;
        if (to)
            code = draw_map(&j, &m, to, code);
    }
    map_free(&m);
    cli_robot_end(&j);
    return code;
}
