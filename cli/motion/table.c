#include "cli/motion/table.h"

#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "cli/program/output.h"

int cli_table_find(const cli_table *t, const char *name)
{
    for (int i = 0; i < t->n_column; i++)
        if (strcmp(t->column[i].name, name) == 0)
            return i;
    return -1;
}

void cli_table_free(cli_table *t)
{
    for (int i = 0; t->drive && i < t->n_drive; i++)
        free(t->drive[i].acceleration);
    free(t->column);
    free(t->row);
    free(t->drive);
    *t = (cli_table){ 0 };
}

static lw_status add_drive(cli_table *t, const char *name, bool slides, lw_error *e)
{
    char column[2*LW_NAME_SIZE + 24];
    cli_table_drive *d = &t->drive[t->n_drive++];
    *d = (cli_table_drive){ .slides = slides, .acceleration = calloc(t->n_row + 1, sizeof *d->acceleration) };
    snprintf(d->name, sizeof d->name, "%s", name);
    snprintf(column, sizeof column, "%s.rate", name);
    d->rate = cli_table_find(t, column);
    snprintf(column, sizeof column, "%s.drive", name);
    d->drive = cli_table_find(t, column);
    return d->acceleration ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* Second derivative of the motion at each time; behind a kink, as the forces are. */
static void accelerate(const cli_table *t, const lw_expression *motion, double factor, double *out)
{
    for (size_t r = 0; r < t->n_row; r++) {
        const double time[3] = { cli_table_at(t, r, 0), 1, 0 };
        double series[3] = { 0, 0, 0 }, v[3*LW_EXPRESSION_VARIABLE_MAX] = { 0 };
        memcpy(v, time, sizeof time);
        lw_expression_series(motion, 2, v, series);
        out[r] = 2*factor*series[2];
    }
}

static lw_status planar_table(const cli_call *call, lw_model *m, const cli_table_options *o, cli_table *t, lw_error *e)
{
    cli_simulate *c = calloc(1, sizeof *c);
    lw_dynamics_options d = lw_dynamics_options_default();
    if (!c)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    d.analysis = o->driven ? LW_ANALYSIS_KINEMATIC : LW_ANALYSIS_TRANSIENT;
    d.from = o->from;
    d.to = o->to;
    d.intervals = o->steps;
    d.stop = cli_stop_flag();
    c->call = call;
    c->keep = true;
    c->model = m;
    lw_status s = cli_simulate_speed(m, o->speed, "", e);
    if (s == LW_OK)
        s = cli_simulate_make(c, &d, "", e);
    if (s == LW_OK)
        s = lw_dynamics_run(c->d, cli_simulate_row, c, &c->report, e);
    t->n_column = c->n_column;
    t->n_row = c->n_row;
    t->row = c->row;
    c->row = NULL;
    t->column = s == LW_OK ? calloc((size_t)c->n_column + 1, sizeof *t->column) : NULL;
    t->drive = s == LW_OK ? calloc((size_t)m->linkage.n_input + 1, sizeof *t->drive) : NULL;
    if (s == LW_OK && (!t->column || !t->drive))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < t->n_column; i++) {
        snprintf(t->column[i].name, sizeof t->column[i].name, "%s", c->column[i].name);
        t->column[i].unit = c->column[i].unit;
    }
    for (int i = 0; s == LW_OK && i < m->linkage.n_input; i++) {
        const lw_input *in = &m->linkage.input[i];
        const lw_joint *j = &m->linkage.joint[in->joint];
        s = add_drive(t, j->name, lw_joint_slides(j->kind), e);
        if (s == LW_OK && m->motion[i])
            accelerate(t, m->motion[i], 1, t->drive[i].acceleration);
        else if (s == LW_OK && m->linkage.n_input > 0 && m->motion[0])
            accelerate(t, m->motion[0], in->ratio, t->drive[i].acceleration);       /* tied to the first */
    }
    c->model = NULL;                                          /* the caller's */
    cli_simulate_free(c);
    free(c);
    return s;
}

static lw_status spatial_table(lw_spatial *m, const cli_table_options *o, cli_table *t, lw_error *e)
{
    lw_space_options d = lw_space_options_default();
    d.analysis = o->driven ? LW_SPACE_KINEMATIC : LW_SPACE_TRANSIENT;
    d.from = o->from;
    d.to = o->to;
    d.intervals = o->steps;
    d.stop = cli_stop_flag();
    lw_status s = cli_spatial_table(m, &d, o->speed, t, e);
    int n = m->n_drive ? m->n_drive : m->n_input;
    t->drive = s == LW_OK ? calloc((size_t)n + 1, sizeof *t->drive) : NULL;
    if (s == LW_OK && !t->drive)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < n; i++) {
        lw_spatial_measure of = m->n_drive ? m->drive[i] : m->input[i].measure;
        char name[LW_NAME_SIZE + 16], column[LW_NAME_SIZE + 40];
        lw_spatial_measure_name(m, of, name, sizeof name);
        for (char *c = name; *c && !m->n_drive; c++)
            *c = *c == ' ' ? '_' : *c;
        s = add_drive(t, name, of.of != LW_OF_TURN, e);
        snprintf(column, sizeof column, "%s.acceleration", name);
        int at = cli_table_find(t, column);
        for (size_t r = 0; s == LW_OK && at >= 0 && r < t->n_row; r++)
            t->drive[i].acceleration[r] = cli_table_at(t, r, at);
    }
    return s;
}

lw_status cli_table_run(const cli_call *call, lw_model *planar, lw_spatial *spatial, const cli_table_options *o,
                        cli_table *t,
                        lw_error *e)
{
    *t = (cli_table){ 0 };
    return spatial ? spatial_table(spatial, o, t, e) : planar_table(call, planar, o, t, e);
}
