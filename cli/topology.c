#include "cli/topology.h"

#include <stdlib.h>

int cli_topologies_each(const cli_call *call, const char *file, bool keep_going, cli_topology_visit *visit,
                        void *context)
{
    char *text;
    size_t size;
    lw_error e = { 0 };
    const char *path = file ? file : "-";
    int code = CLI_DONE;
    if (lw_file_read(path, &text, &size, &e) != LW_OK)
        return cli_fail(call, &e);
    lw_topologies t = lw_topologies_open(text, size, path);
    while (!cli_interrupted()) {
        lw_mechanism m;
        e = (lw_error){ 0 };
        lw_status s = lw_topologies_next(&t, &m, &e);
        if (s == LW_NOTHING)
            break;
        bool was_read = s == LW_OK;
        if (was_read)
            s = visit(context, &m, &e);
        if (s == LW_OK)
            continue;
        if (s == LW_STOPPED)
            break;
        if (was_read && e.line == 0 && s != LW_E_IO) {      /* a fault of the piece as a whole */
            snprintf(e.file, sizeof e.file, "%s", path);
            e.line = t.first_line;
            e.column = 1;
        }
        code = cli_fail(call, &e);
        if (!keep_going)
            break;
    }
    free(text);
    return code;
}

lw_status cli_topology_write(FILE *f, const lw_notation *n, const lw_mechanism *m, lw_error *e)
{
    char text[LW_NOTATION_SIZE];
    size_t length;
    lw_status s = n->print(m, text, sizeof text, &length);
    if (s != LW_OK)
        return lw_error_set(e, s, "this topology cannot be written as %s", n->name);
    fputs(text, f);
    fputc('\n', f);
    return ferror(f) ? lw_error_set(e, LW_E_IO, "output cannot be written") : LW_OK;
}
