/* The columns and rows of a table. */
#include "cli/motion/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/key_table.h"
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
    free(t->column);
    free(t->row);
    *t = (cli_table){ 0 };
}

lw_status cli_columns_differ(cli_column *column, int n, const cli_column **first, lw_error *e)
{
    lw_key_table names = { 0 };
    bool room = true;
    *first = NULL;
    for (int i = 0; room && i < n; i++) {
        cli_column *c = &column[i];
        char name[sizeof c->name - 12];
        snprintf(name, sizeof name, "%.*s", (int)sizeof name - 1, c->name);
        for (int k = 2; lw_key_table_find(&names, column, sizeof *column, c->name, strlen(c->name) + 1) >= 0; k++) {
            snprintf(c->name, sizeof c->name, "%s %d", name, k);
            *first = *first ? *first : c;
        }
        room = lw_key_table_add(&names, c->name, strlen(c->name) + 1, i);
    }
    lw_key_table_free(&names);
    return room ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void cli_note_column(const cli_call *call, const cli_column *first)
{
    if (first)
        cli_note(call, "two columns would have one name, so one of them is called \"%s\": give tracers, links, joints, states and what else has "
                 "columns different names", first->name);
}

void cli_columns_print(FILE *f, const cli_column *column, int n)
{
    fputs("# units:", f);
    for (int c = 0; c < n; c++)
        fprintf(f, "%c%s", c ? ',' : ' ', column[c].unit);
    fputc('\n', f);
    for (int c = 0; c < n; c++)
        fputs(c ? "," : "", f), cli_csv_text(f, column[c].name);
    fputc('\n', f);
}

cli_json cli_columns_json(FILE *f, const cli_call *call, const cli_column *column, int n)
{
    cli_json j = cli_json_begin(f, 1);
    cli_json_head(&j, call->line);
    cli_json_array(&j, "columns");
    for (int c = 0; c < n; c++)
        cli_json_text(&j, NULL, column[c].name);
    cli_json_end(&j);
    cli_json_array(&j, "units");
    for (int c = 0; c < n; c++)
        cli_json_text(&j, NULL, column[c].unit);
    cli_json_end(&j);
    cli_json_array(&j, "rows");
    return j;
}
