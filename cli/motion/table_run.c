/* Run a planar or a spatial model and keep its rows. */
#include <stdlib.h>

#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "cli/motion/table_run.h"
#include "cli/program/output.h"
#include "mbs/formulations/formulations.h"

static lw_status planar_table(const cli_call *call, lw_model *m, const cli_table_options *o, cli_table *t, lw_error *e)
{
    cli_simulate *c = calloc(1, sizeof *c);
    lw_dynamics_options d = lw_dynamics_options_default();
    if (!c)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
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
    t->column = c->column;
    c->column = NULL;
    c->model = NULL;                                          /* the caller's */
    cli_simulate_free(c);
    free(c);
    return s;
}

static lw_status spatial_table(lw_spatial *m, const cli_table_options *o, cli_table *t, lw_error *e)
{
    lw_dynamics_options d = lw_dynamics_options_default();
    d.from = o->from;
    d.to = o->to;
    d.intervals = o->steps;
    d.stop = cli_stop_flag();
    return cli_spatial_table(m, &d, o->speed, t, e);
}

lw_status cli_table_run(const cli_call *call, lw_model *planar, lw_spatial *spatial, const cli_table_options *o, cli_table *t, lw_error *e)
{
    *t = (cli_table){ 0 };
    return spatial ? spatial_table(spatial, o, t, e) : planar_table(call, planar, o, t, e);
}
