/* cli/bench/bench_problem.c - the published path problems with their bounds and figures. */
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/bench/bench.h"
#include "cli/program/data.h"
#include "cli/program/model.h"

/* Bounds, published errors as they evaluate here, and reachable errors. The comments of the files name the papers. */
static const cli_bench_figures table[] = {
    { "line6", "line6", { 5, 60 }, { -60, 60 }, LW_DATUM_FREE, false,
      { { "Cabrera", 3.63e-2 }, { "DE", 1.51e-2 }, { "MUMSA", 2.06e-4 }, { "later", 4e-12 } }, 1e-20 },      /* exact solutions exist: zero to rounding */
    { "arc5", "arc5", { 0, 50 }, { -50, 50 }, LW_DATUM_FRAME, true,
      { { "Kunjur", 9.53e-4 }, { "IOA", 4.27e-6 }, { "HCDJ", 1.92e-6 }, { "Cabrera", 1.83e-6 },
        { "MUMSA", 1.28e-6 } }, 7.4158e-7 },
    { "arch6", "arch6", { 5, 50 }, { -50, 50 }, LW_DATUM_FRAME, false,
      { { "published", 5.55 }, { "published", 2.58 } }, 2.58036 },
    { "arch6-wide", "arch6", { 0, 50 }, { -50, 50 }, LW_DATUM_FRAME, false,
      { { "published", 1.2162 } }, 1.2162 },
    { "arch6-unbounded", "arch6", { 0, 1e5 }, { -1e5, 1e5 }, LW_DATUM_FRAME, false, { { NULL, 0 } }, 0.55 },
    { "closed18", "closed18", { 0, 50 }, { -50, 50 }, LW_DATUM_FREE, false,
      { { "Kunjur", 6.61e-2 }, { "IOA", 3.50e-2 }, { "Cabrera", 3.37e-2 }, { "MUMSA", 1.94e-2 },
        { "HCDJ", 1.61e-2 } }, 9.0289e-3 },
    { "closed18free", "closed18free", { 0, 50 }, { -50, 50 }, LW_DATUM_FREE, false, { { NULL, 0 } },
      1.7729e-3 },                         /* by the points alone; the curve makes a long excursion between two of them */
    { "ellipse10", "ellipse10", { 5, 80 }, { -80, 80 }, LW_DATUM_FREE, false,
      { { "IOA", 2.23e-2 }, { "MUMSA", 4.77e-3 }, { "HCDJ", 4.20e-4 }, { "Lin", 4.02e-4 } },
      4.01992e-4 },
    { "ellipse10-unbounded", "ellipse10", { 0, 1e5 }, { -1e5, 1e5 }, LW_DATUM_FREE, false,
      { { NULL, 0 } }, 3e-8 },
};
enum { N_TABLE = sizeof table/sizeof *table };

/* Set the conditions of the published figures: a crank that is the shortest link, bounds in the unit of the target. */
static void make_spec(cli_bench_problem *p)
{
    static const char *const frame[] = { "x0", "y0", "theta0" };
    const cli_bench_figures *k = p->known;
    lw_fit_spec *s = &p->spec;
    double m = p->target.units.metre;
    *s = lw_fit_spec_default();
    s->timing = p->target.angle ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
    s->datum = k->datum;
    s->a = 1/(m*m);
    s->crank_only = s->exclude_drag_link = true;
    s->length_lo = k->length[0]*m;
    s->length_hi = k->length[1]*m;
    s->dimensions_only = true;                           /* as these problems are stated */
    s->position_lo = k->position[0]*m;
    s->position_hi = k->position[1]*m;
    for (int i = 0; k->at_origin && i < 3; i++)
        memcpy(s->bound[s->n_bound++].name, frame[i], strlen(frame[i]) + 1);
}

static lw_status add(const char *folder, const char *file, const cli_bench_figures *known, cli_bench_problem **list, int *n, lw_error *e)
{
    static const lw_target_options by_file = { .closed = -1 };
    cli_bench_problem *more = realloc(*list, sizeof **list*(size_t)(*n + 1));
    if (!more)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *list = more;
    cli_bench_problem *p = &more[*n];
    memset(p, 0, sizeof *p);
    snprintf(p->name, sizeof p->name, "%s", known ? known->name : file);
    snprintf(p->path, sizeof p->path, "%s/%s.csv", folder, file);
    lw_status st = cli_read_target(p->path, &by_file, &p->target, e);
    if (st != LW_OK)
        return st;
    p->known = known;
    ++*n;
    if (!p->target.x)
        return lw_error_at(e, LW_E_ARG, p->path, 0, 0, "a path is wanted: columns x and y");
    return LW_OK;
}

/* Set pointers to `own`; its addresses are final only when the list is complete. */
static void finish(cli_bench_problem *p, int n)
{
    for (int i = 0; i < n; i++) {
        if (!p[i].known) {
            p[i].own = (cli_bench_figures){ .name = p[i].name, .file = p[i].name };
            p[i].known = &p[i].own;
        }
        make_spec(&p[i]);
    }
}

static int other_csv(const struct dirent *d)
{
    size_t n = strlen(d->d_name);
    if (n < 5 || n > 60 || d->d_name[0] == '.' || strcmp(d->d_name + n - 4, ".csv") != 0)
        return 0;
    for (int i = 0; i < N_TABLE; i++)
        if (strncmp(table[i].file, d->d_name, n - 4) == 0 && strlen(table[i].file) == n - 4)
            return 0;
    return 1;
}

static bool is_there(const char *folder, const char *file)
{
    char path[CLI_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s.csv", folder, file);
    return access(path, F_OK) == 0;
}

static lw_status add_others(const char *folder, cli_bench_problem **p, int *n, lw_error *e)
{
    struct dirent **entry;
    lw_status st = LW_OK;
    int count = scandir(folder, &entry, other_csv, alphasort);
    if (count < 0)
        return lw_error_at(e, LW_E_IO, folder, 0, 0, "this folder of problems cannot be read; name another with --problems");
    for (int i = 0; i < count; i++) {
        char name[64];
        snprintf(name, sizeof name, "%.*s", (int)strlen(entry[i]->d_name) - 4, entry[i]->d_name);
        if (st == LW_OK)
            st = add(folder, name, NULL, p, n, e);
        free(entry[i]);
    }
    free(entry);
    return st;
}

lw_status cli_bench_load(const char *folder, cli_bench_problem **p, int *n, lw_error *e)
{
    char found[900];
    lw_status st = LW_OK;
    cli_data_path("paths", found, sizeof found);
    if (!folder)
        folder = found;
    *p = NULL;
    *n = 0;
    for (int i = 0; i < N_TABLE && st == LW_OK; i++)
        if (is_there(folder, table[i].file))
            st = add(folder, table[i].file, &table[i], p, n, e);
    if (st == LW_OK)
        st = add_others(folder, p, n, e);
    if (st == LW_OK && *n == 0)
        st = lw_error_at(e, LW_E_ARG, folder, 0, 0, "no CSV file of points in this folder");
    finish(*p, *n);
    return st;
}

void cli_bench_free(cli_bench_problem *p, int n)
{
    for (int i = 0; i < n; i++)
        lw_target_free(&p[i].target);
    free(p);
}
