/* cli/motion/table.h - a run in time, kept as rows of the named columns of `simulate`. */
#ifndef CLI_MOTION_TABLE_H
#define CLI_MOTION_TABLE_H

#include "cli/program/command.h"
#include "cli/program/json.h"
#include "grammar/model/model.h"

typedef struct cli_column { char name[2*LW_NAME_SIZE + 24]; const char *unit; double scale; } cli_column;

typedef struct cli_table cli_table;
struct cli_table {
    int               n_column;
    cli_column       *column;            /* the first is t [s] */
    size_t            n_row;
    double           *row;               /* (n_row * n_column) */
};

void cli_table_free(cli_table *t);

/* Number columns that would have the name of one before: "P.x 2".  *first: the first of them, or NULL.  LW_E_MEMORY. */
lw_status cli_columns_differ(cli_column *column, int n, const cli_column **first, lw_error *e);
void      cli_note_column(const cli_call *call, const cli_column *first);        /* say so; NULL: nothing */

/* What stands before the rows: units and names, each a line of CSV; or JSON up to the list of rows. */
void     cli_columns_print(FILE *f, const cli_column *column, int n);
cli_json cli_columns_json(FILE *f, const cli_call *call, const cli_column *column, int n);

int cli_table_find(const cli_table *t, const char *name);        /* -1: no such column */

/* Plot the columns whose names, or their parts before the point, are in a list; NULL: the drives, or the energies if there are
 * none. */
lw_status cli_table_plot(const cli_table *t, const char *title, const char *columns, const char *path, lw_error *e);

static inline double cli_table_at(const cli_table *t, size_t row, int column)
{
    return t->row[row*(size_t)t->n_column + (size_t)column];
}

#endif
