/* The columns and rows of a table. */
#include "cli/motion/table.h"

#include <stdlib.h>
#include <string.h>

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
