/* cli/motion/simulate_picture.c - plots and animations of a run. */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/suggest.h"
#include "catalogues/draw/gif.h"
#include "catalogues/pages/draw.h"
#include "cli/program/output.h"
#include "cli/motion/simulate.h"
#include "mbs/elastic/superelement.h"

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

/* The frame of a link in posture q: its body's; of an elastic link that of the line between its ends. */
static lw_place place_of(const cli_simulate *s, int link, const double *q)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    const lw_elastic_expansion *x = lw_dynamics_elastic(s->d);
    int b = sys->body[link];
    for (int c = 0; x && c < x->n_chain; c++)
        if (x->chain[c].link == link) {
            int last = sys->body[x->chain[c].node[x->chain[c].n_bound - 1]];
            lw_vec2 from = lw_system_point(sys, b, lw_v2(0, 0), q), d = lw_v2_sub(lw_system_point(sys, last, lw_v2(0, 0), q), from);
            return (lw_place){ from, lw_v2_scale(d, 1/lw_v2_norm(d)) };
        }
    return b < 0 ? (lw_place){ { 0, 0 }, { 1, 0 } }
                 : (lw_place){ lw_system_point(sys, b, lw_v2(0, 0), q), lw_v2_polar(1, q[3*b + 2]) };
}

/* The paths of the tracers as the rows have them, in place of those that they have for all inputs. */
static bool take_paths(const cli_simulate *s, lw_scene *scene)
{
    size_t first = 1 + 3*(size_t)s->model->linkage.n_input, columns = (size_t)s->n_column;
    const lw_assembly *k = &scene->linkage;
    while (scene->n_curve > 0)
        free(scene->curve[--scene->n_curve].p);
    for (int t = 0; t < k->n_tracer && scene->n_curve < scene->max_curve; t++) {
        lw_vec2 *p = calloc(scene->n_frame + 1, sizeof *p);
        if (!p)
            return false;
        for (size_t f = 0; f < scene->n_frame; f++)
            p[f] = lw_v2_scale(lw_v2(s->row[f*columns + first + 6*(size_t)t], s->row[f*columns + first + 6*(size_t)t + 1]), k->units.metre);
        scene->curve[scene->n_curve++] = (lw_curve){ .tracer = t, .shown_branch = true, .n = scene->n_frame, .p = p };
    }
    return true;
}

/* Use the postures of the run as frames of a scene. */
static lw_status set_frames(const cli_simulate *s, lw_scene *scene, lw_error *e)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    size_t n = s->n_row, links = (size_t)s->model->linkage.n_link;
    double *start = calloc((size_t)sys->n_q + 1, sizeof *start);
    lw_place *place = calloc(n*links + 1, sizeof *place);
    double *input = calloc(n + 1, sizeof *input);
    if (!start || !place || !input) {
        free(start);
        free(place);
        free(input);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    lw_system_posture(sys, start);
    for (size_t l = 0; l < links; l++) {
        lw_place first = place_of(s, (int)l, start);
        scene->origin[l] = first.at;
        for (size_t i = 0; i < n; i++) {
            lw_place now = place_of(s, (int)l, s->q + i*(size_t)sys->n_q);
            place[i*links + l] = (lw_place){ now.at, lw_v2_unturn(now.turn, first.turn) };
        }
    }
    free(start);
    scene->note[0] = '\0';
    scene->model = s->model;
    free(scene->place);
    free(scene->input);
    scene->place = place;
    scene->input = input;
    scene->n_frame = n;
    scene->first_frame = 0;
    scene->loops = true;
    return take_paths(s, scene) ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* Points along a chain of nodes in posture q: cubics between nodes, whose slopes there turn with the nodes from the posture q0 of the file. */
static void bend_at(const lw_system *sys, const int *node, int n, const double *q0, const double *q, int parts, lw_vec2 *p)
{
    for (int i = 0; i + 1 < n; i++) {
        lw_vec2 at[2], slope[2], first[2];
        for (int end = 0; end < 2; end++) {
            int b = sys->body[node[i + end]];
            at[end] = lw_system_point(sys, b, lw_v2(0, 0), q);
            first[end] = lw_system_point(sys, b, lw_v2(0, 0), q0);
        }
        lw_vec2 way = lw_v2_sub(at[1], at[0]);
        for (int end = 0; end < 2; end++) {
            int b = sys->body[node[i + end]];
            slope[end] = lw_v2_sub(lw_v2_turn(lw_v2_sub(first[1], first[0]), lw_v2_polar(1, q[3*b + 2] - q0[3*b + 2])), way);
        }
        for (int j = 0; j <= parts; j++) {
            double u = (double)j/parts, v = 1 - u;
            p[i*parts + j] = lw_v2_add(lw_v2_add(at[0], lw_v2_scale(way, u)), lw_v2_sub(lw_v2_scale(slope[0], u*v*v), lw_v2_scale(slope[1], u*u*v)));
        }
    }
}

/* A line through nodes in all rows.  false: no memory. */
static bool make_bend(const cli_simulate *s, int link, const int *node, int n, const double *q0, lw_bent_bar *bend)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    int parts = 1 + 16/n, points = parts*(n - 1) + 1;
    *bend = (lw_bent_bar){ link, points, calloc(s->n_row*(size_t)points + 1, sizeof *bend->p) };
    for (size_t i = 0; bend->p && i < s->n_row; i++)
        bend_at(sys, node, n, q0, s->q + i*(size_t)sys->n_q, parts, bend->p + i*(size_t)points);
    return bend->p != NULL;
}

/* The edges of the mesh of a superelement in all rows, from *n on.  false: no memory. */
static bool bend_mesh(const cli_simulate *s, const lw_elastic_chain *k, const lw_superelement *mesh, const double *q0, lw_bent_bar *bend, int *n)
{
    int (*edge)[2] = malloc((size_t)k->n_bound*(size_t)k->n_bound/2*sizeof *edge + 1);
    int n_edge = edge ? lw_super_edges(k->n_bound, mesh->n, mesh->at, mesh->stiffness, edge) : 0;
    bool room = edge != NULL;
    for (int i = 0; room && i < n_edge; i++)
        room = make_bend(s, k->link, (int[]){ k->node[edge[i][0]], k->node[edge[i][1]] }, 2, q0, &bend[(*n)++]);
    free(edge);
    return room;
}

/* The shapes of elastic links in all rows; *bend needs free_bends. */
static lw_status make_bends(const cli_simulate *s, lw_bent_bar **bend, int *n, lw_error *e)
{
    const lw_elastic_expansion *x = lw_dynamics_elastic(s->d);
    const lw_system *sys = lw_dynamics_system(s->d);
    double *q0 = calloc((size_t)sys->n_q + 1, sizeof *q0);
    size_t most = 1;
    *n = 0;
    for (int c = 0; x && c < x->n_chain; c++)
        most += x->chain[c].elastic->n_node ? (size_t)x->chain[c].n_bound*(size_t)x->chain[c].n_bound/2 : 1;
    *bend = calloc(most, sizeof **bend);
    bool room = *bend && q0;
    if (q0)
        lw_system_posture(sys, q0);
    for (int c = 0; room && x && c < x->n_chain; c++) {
        const lw_elastic_chain *k = &x->chain[c];
        room = k->elastic->n_node ? bend_mesh(s, k, &x->model.super[k->first_beam], q0, *bend, n)
                                  : make_bend(s, k->link, k->node, k->n_bound, q0, &(*bend)[(*n)++]);
    }
    free(q0);
    return room ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

static void free_bends(lw_bent_bar *bend, int n)
{
    for (int c = 0; bend && c < n; c++)
        free(bend[c].p);
    free(bend);
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
    lw_status st = lw_scene_make_any(&s->model->linkage, s->model, NULL, NULL, &scene, e);
    if (st == LW_OK)
        st = set_frames(s, &scene, e);
    lw_bent_bar *bend = NULL;
    int n_bend = 0;
    if (st == LW_OK)
        st = make_bends(s, &bend, &n_bend, e);
    scene.bend = bend;
    scene.n_bend = n_bend;
    if (st == LW_OK)
        st = lw_gif_write(&scene, &o, &bytes, e);
    if (st == LW_OK)
        st = lw_file_write(path, bytes.data, bytes.size, e);
    if (st == LW_OK)
        cli_note_slower(s->call, s->n_row, seconds);
    free_bends(bend, n_bend);
    lw_bytes_free(&bytes);
    lw_scene_free(&scene);
    return st;
}
