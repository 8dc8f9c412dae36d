/* A catalogue: fill it with six-link chains and coupler curves, ask it, and find the curves nearest to an ellipse.
 *
 *     cc catalogue.c $(pkg-config --cflags --libs linkwright) -lm -o catalogue
 *     ./catalogue small.db                                                                               */
#include <linkwright.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static lw_status print_row(void *context, int n_column, const char *const *name, const lw_value *value)
{
    ++*(int *)context;
    for (int i = 0; i < n_column; i++)
        if (value[i].kind == LW_VALUE_TEXT)
            printf("%s=%.*s ", name[i], (int)value[i].size, value[i].text);
        else
            printf("%s=%g ", name[i], value[i].kind == LW_VALUE_REAL ? value[i].real : (double)value[i].integer);
    putchar('\n');
    return LW_OK;
}

static lw_status print_hit(void *context, const lw_catalogue_hit *hit)
{
    double *nearest = context;
    if (*nearest < 0)
        *nearest = hit->distance;
    printf("%-16s %5.2f %% of the ellipse's size away\n", hit->family, 100*hit->distance);
    return LW_OK;
}

int main(int argc, char **argv)
{
    enum { N = 40 };
    char folder[] = "/tmp/linkwright-XXXXXX", path[64] = "";
    double x[N], y[N], nearest = -1;
    int rows = 0;
    uint64_t chains = 0;
    lw_catalogue *catalogue = NULL;
    lw_target *ellipse = NULL;
    lw_catalogue_work work = { 0 };
    lw_error error = { LW_OK, "", 0, 0, "" };
    const char *file = argc > 1 ? argv[1] : path;

    if (argc <= 1) {
        if (!mkdtemp(folder))
            return 1;
        snprintf(path, sizeof path, "%s/small.db", folder);
    }
    lw_status status = lw_catalogue_open(file, true, 0, &catalogue, &error);
    if (status == LW_OK)
        status = lw_catalogue_add_chains(catalogue, 6, 1, "r", &work, &chains, &error);
    if (status == LW_OK)
        status = lw_catalogue_query(catalogue, "links=6 and symmetry>1", "chains", "franke,symmetry,grounds", NULL, 0,
                                    print_row, &rows, &error);
    if (status == LW_OK)
        status = lw_catalogue_add_curves(catalogue, "fourbar", 4, 20000, &work, &error);
    for (int i = 0; i < N; i++) {
        x[i] = 0.2*cos(2*3.14159265358979323846*i/N);
        y[i] = 0.1*sin(2*3.14159265358979323846*i/N);
    }
    if (status == LW_OK)
        status = lw_target_create(N, x, y, NULL, NULL, NULL, 1, &ellipse, &error);
    if (status == LW_OK)
        status = lw_catalogue_nearest(catalogue, ellipse, NULL, 3, print_hit, &nearest, &error);
    if (status != LW_OK)
        fprintf(stderr, "%s\n", error.text);
    lw_target_destroy(ellipse);
    lw_catalogue_close(catalogue);
    if (argc <= 1) {
        remove(path);
        remove(folder);
    }
    return status == LW_OK && chains == 2 && rows == 2 && nearest >= 0 && nearest < 0.05 ? 0 : 1;
}
