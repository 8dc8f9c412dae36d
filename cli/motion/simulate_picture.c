/* cli/motion/simulate_picture.c - plots and animations of a run. */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/suggest.h"
#include "catalogues/draw/gif.h"
#include "catalogues/draw/run_scene.h"
#include "catalogues/pages/draw.h"
#include "cli/program/output.h"
#include "cli/motion/simulate.h"

/* Is the column in the list, by its name or by the part of its name before the point? */
static bool wanted(const cli_table *t, int c, const char *list, bool driven)
{
    const char *name = t->column[c].name, *dot = strrchr(name, '.');
    if (!list)
        return driven ? dot && strcmp(dot, ".drive") == 0 : strcmp(name, "kinetic") == 0 || strcmp(name, "potential") == 0;
    for (const char *p = list; *p;) {
        size_t n = strcspn(p, ",");
        if ((strlen(name) == n && strncmp(name, p, n) == 0) || (dot && (size_t)(dot - name) == n && strncmp(name, p, n) == 0))
            return true;
        p += n + (p[n] == ',');
    }
    return false;
}

/* Does a drive exert a force?  Those of inputs that run freely are 0 or missing. */
static bool is_driven(const cli_table *t)
{
    for (int c = 1; c < t->n_column; c++) {
        const char *dot = strrchr(t->column[c].name, '.');
        for (size_t i = 0; dot && strcmp(dot, ".drive") == 0 && i < t->n_row; i++)
            if (fabs(cli_table_at(t, i, c)) > 0)
                return true;
    }
    return false;
}

/* The quantity that belongs to a unit: "force [N]"; other units stand alone. */
static void label_of(char *to, size_t size, const char *unit)
{
    static const char *const known[][2] = {
        { "rad/s", "angular velocity" },
        { "rad/s^2", "angular acceleration" }, { "N", "force" }, { "N m", "torque" }, { "J", "energy" },
        { "N/m^2", "stress" }, { "W", "power" }, { "A", "current" }, { "V", "voltage" } };
    lw_units u = lw_units_si();
    char length[8] = "";
    const char *slash = strchr(unit, '/');
    snprintf(length, sizeof length, "%.*s", slash ? (int)(slash - unit) : 0, unit);
    const char *what = lw_units_set_length(&u, unit) ? "place" : lw_units_set_angle(&u, unit) ? "angle" : NULL;
    if (lw_units_set_length(&u, length))
        what = strcmp(slash, "/s") == 0 ? "velocity" : strcmp(slash, "/s^2") == 0 ? "acceleration" : NULL;
    for (size_t i = 0; !what && i < sizeof known/sizeof *known; i++)
        what = strcmp(unit, known[i][0]) == 0 ? known[i][1] : NULL;
    snprintf(to, size, "%s%s[%s]", what ? what : "", what ? " " : "", unit);
}

lw_status cli_table_plot(const cli_table *s, const char *title, const char *columns, const char *path, lw_error *e)
{
    enum { LINES = 8 };                                    /* that can be told apart in a panel */
    lw_series series[LW_PANEL_MAX][LINES];
    lw_plot plot[LW_PANEL_MAX] = { 0 };
    char label[LW_PANEL_MAX][64];
    size_t n = s->n_row;
    int panels = 0, lines = 0;
    bool driven = is_driven(s);
    double *x = calloc((LW_PANEL_MAX*LINES + 1)*(n + 1), sizeof *x);
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < n; i++)
        x[i] = s->row[i*(size_t)s->n_column];
    lw_status st = LW_OK;
    for (int c = 1; c < s->n_column && st == LW_OK; c++) {
        if (!wanted(s, c, columns, driven))
            continue;
        int p = 0;                                         /* a panel of this unit with room */
        while (p < panels && (strcmp(plot[p].y_label, s->column[c].unit) != 0 || plot[p].n_series == LINES))
            p++;
        if (p == LW_PANEL_MAX)
            st = lw_error_set(e, LW_E_ARG, "these columns need more than %d panels of %d lines; --columns names fewer",
                              LW_PANEL_MAX, LINES);
        else {
            if (p == panels)
                plot[panels++] = (lw_plot){ .y_label = s->column[c].unit, .series = series[p] };
            double *y = x + (size_t)++lines*(n + 1);
            for (size_t i = 0; i < n; i++)
                y[i] = s->row[i*(size_t)s->n_column + (size_t)c];
            series[p][plot[p].n_series++] = (lw_series){ .name = s->column[c].name, .n = n, .x = x, .y = y };
        }
    }
    if (st == LW_OK && panels == 0) {
        const char *near = columns ? LW_SUGGEST(columns, s->column, s->n_column, name) : NULL;
        st = lw_error_set(e, LW_E_ARG, "no column is called %s%s%s; the first line of the CSV names them",
                          columns ? columns : "drive", near ? ", did you mean " : "", near ? near : "");
    } else if (st == LW_OK) {
        plot[0].title = title;
        plot[0].height = panels == 1 ? 560 : fmin(260*panels, 8000);
        plot[panels - 1].x_label = "t [s]";
        for (int p = 0; p < panels; p++) {
            label_of(label[p], sizeof label[p], plot[p].y_label);
            plot[p].y_label = label[p];
        }
        st = lw_draw_plots(panels, plot, path, e);
    }
    free(x);
    return st;
}

void cli_note_slower(const cli_call *call, size_t n_frame, double seconds)
{
    double slower;
    lw_gif_options_in_time(n_frame, seconds, &slower);
    if (slower > 1.05)
        cli_note(call, "the animation is %.3g times slower than the motion of %.3g s", slower, seconds);
}

lw_status cli_simulate_gif(const cli_simulate *s, const char *path, lw_error *e)
{
    lw_scene scene;
    lw_bytes bytes = { 0 };
    double seconds = s->n_row > 1 ? s->row[(s->n_row - 1)*(size_t)s->n_column] - s->row[0] : 0;
    lw_gif_options o = lw_gif_options_in_time(s->n_row, seconds, NULL);
    lw_status st = lw_scene_of_run(s->model, s->d, s->n_row, s->q, &scene, e);
    if (st == LW_OK)
        st = lw_gif_write(&scene, &o, &bytes, e);
    if (st == LW_OK)
        st = lw_file_write(path, bytes.data, bytes.size, e);
    if (st == LW_OK)
        cli_note_slower(s->call, s->n_row, seconds);
    lw_bytes_free(&bytes);
    lw_scene_free(&scene);
    return st;
}
