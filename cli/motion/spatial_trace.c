/* cli/motion/spatial_trace.c - paths of the tracers of a spatial model, as CSV or JSON. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/spatial.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "mbs/space/space_trace.h"

#define VALUES   22
#define GEOMETRY 5               /* more, with --geometry */
static const char *const columns[VALUES + GEOMETRY] = {
    "x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "qw", "qx", "qy", "qz", "rx", "ry", "rz", "wx", "wy", "wz", "alpha_x",
    "alpha_y", "alpha_z", "curvature", "axis_x", "axis_y", "axis_z", "pitch"
};

typedef struct rows {
    const lw_spatial *m;
    FILE    *f;
    cli_json json;
    bool     as_json, in_time, begun;
    int      only;                       /* this tracer, -1: all */
    double   speed;                      /* rates are by time at this speed of the input; 0: by the input */
    double  *flat;
    lw_quaternion *turn;                 /* (tracers) of the last row */
    int      values;                     /* of a tracer: VALUES, or VALUES + GEOMETRY */
    bool     plotted;
    size_t   n_kept, room;               /* rows kept for a plot: NaN where it is interrupted */
    double  *kept;                       /* (n_kept * (1 + values * tracers)) */
} rows;

int cli_spatial_refuse(const cli_call *call, const char *const *names)
{
    for (; *names; names++)
        if (cli_given(&call->parsed, *names))
            return cli_usage(call, "--%s is for planar models; this model is spatial", *names);
    return CLI_DONE;
}

static void put_vector(double *to, lw_vec3 a, double unit) { to[0] = a.x/unit, to[1] = a.y/unit, to[2] = a.z/unit; }

/* The numbers of a tracer in the units of the file.  *before: the quaternion of its last row, which decides the sign of the next one. */
static void fill(const rows *r, const lw_space_tracer *t, lw_quaternion *before, double *out)
{
    double metre = r->m->units.metre, w = r->speed != 0 ? r->speed : 1;
    lw_quaternion q = *before = lw_quaternion_beside(*before, t->turn);
    put_vector(out, t->place, metre);
    put_vector(out + 3, lw_v3_scale(t->velocity, w), metre);
    put_vector(out + 6, lw_v3_scale(t->acceleration, w*w), metre);
    out[9] = q.w, out[10] = q.x, out[11] = q.y, out[12] = q.z;
    put_vector(out + 13, lw_quaternion_vector(t->turn), r->m->units.radian);
    put_vector(out + 16, lw_v3_scale(t->omega, w), 1);
    put_vector(out + 19, lw_v3_scale(t->alpha, w*w), 1);
}

/* Curvature of the path; point and pitch of the screw axis about which the link moves now.  NaN where it stands still, or
 * does not turn. */
static void fill_geometry(const rows *r, const lw_space_tracer *t, double *out)
{
    double metre = r->m->units.metre, v = lw_v3_norm(t->velocity), w2 = lw_v3_dot(t->omega, t->omega);
    w2 = w2 > 1e-18*v*v ? w2 : 0;                              /* rounding of a link that only slides */
    out[0] = v > 0 ? lw_v3_norm(lw_v3_cross(t->velocity, t->acceleration))/(v*v*v)*metre : NAN;
    put_vector(out + 1, w2 > 0 ? lw_v3_add(t->place, lw_v3_scale(lw_v3_cross(t->omega, t->velocity), 1/w2))
                               : (lw_vec3){ NAN, NAN, NAN }, metre);
    out[4] = w2 > 0 ? lw_v3_dot(t->omega, t->velocity)/w2/metre : NAN;
}

static double input_unit(const lw_spatial *m, int i)
{
    return m->input[i].measure.of == LW_OF_TURN ? m->units.radian : m->units.metre;
}

static void number(FILE *f, double v)
{
    char text[LW_NUMBER_SIZE] = "";
    if (isfinite(v))
        lw_number_print(v + 0.0, text);
    fputs(text, f);
}

static int printed(const rows *r) { return r->only < 0 ? r->m->n_tracer : 1; }

/* Space for one more row of the plot; NULL: out of memory. */
static double *keep(rows *r)
{
    size_t width = 1 + (size_t)(r->values*printed(r));
    if (r->n_kept == r->room) {
        size_t room = 2*r->room + 512;
        double *grown = realloc(r->kept, room*width*sizeof *grown);
        if (!grown)
            return NULL;
        r->kept = grown;
        r->room = room;
    }
    return r->kept + r->n_kept++*width;
}

static void name_input(int i, char *text, size_t size)
{
    if (i)
        snprintf(text, size, "input_%d", i + 1);
    else
        snprintf(text, size, "input");
}

/* Before the first row: nothing is printed where there is none. */
static void put_head(rows *r)
{
    const lw_spatial *m = r->m;
    const char *length = m->units.length[0] ? m->units.length : "m";
    const char *by = r->in_time || r->speed != 0 ? "s" : m->input[0].measure.of == LW_OF_TURN ? "rad" : length;
    char name[LW_NAME_SIZE + 16];
    int inputs = r->in_time ? m->n_input : 1;
    r->begun = true;
    if (!r->as_json) {
        fputs("# units: ", r->f);
        if (r->in_time)
            fputs("time s; ", r->f);
        for (int i = 0; i < inputs; i++) {
            name_input(i, name, sizeof name);
            fprintf(r->f, "%s %s; ", name, m->input[i].measure.of == LW_OF_TURN ? m->units.angle : length);
        }
        fprintf(r->f, "x y z %s; v a %s/%s %s/%s^2; q quaternion, r rotation vector %s; w alpha rad/%s rad/%s^2", length, length,
                by, length, by, m->units.angle, by, by);
        if (r->values > VALUES)
            fprintf(r->f, "; curvature 1/%s; screw axis %s, pitch %s/rad", length, length, length);
        fputc('\n', r->f);
        if (r->in_time)
            fputs("time,", r->f);
        for (int i = 0; i < inputs; i++) {
            name_input(i, name, sizeof name);
            fprintf(r->f, "%s,", name);
        }
        if (r->only < 0 && m->n_tracer > 1)
            fputs("tracer,", r->f);
        for (int i = 0; i < r->values; i++)
            fprintf(r->f, "%s%c", columns[i], i + 1 < r->values ? ',' : '\n');
        return;
    }
    r->json = cli_json_begin(r->f, 2);
    cli_json_object(&r->json, NULL);
    cli_json_text(&r->json, "way", "space");
    cli_json_text(&r->json, "length_unit", length);
    cli_json_text(&r->json, "angle_unit", m->units.angle);
    cli_json_text(&r->json, "rates_by", by);
    cli_json_array(&r->json, "columns");
    if (r->in_time)
        cli_json_text(&r->json, NULL, "time");
    for (int i = 0; i < inputs; i++) {
        name_input(i, name, sizeof name);
        cli_json_text(&r->json, NULL, name);
    }
    for (int k = 0; k < m->n_tracer; k++)
        for (int i = 0; i < r->values && (r->only < 0 || r->only == k); i++) {
            snprintf(name, sizeof name, "%s.%s", m->tracer[k].name, columns[i]);
            cli_json_text(&r->json, NULL, name);
        }
    cli_json_end(&r->json);
    cli_json_array(&r->json, "rows");
}

static lw_status put_row(void *context, double u, const double *input, const lw_space_tracer *tracer)
{
    rows *r = context;
    double value[VALUES + GEOMETRY], *to = r->plotted ? keep(r) : NULL;
    if (r->plotted && !to)
        return LW_E_MEMORY;
    if (to)
        *to++ = r->in_time ? u : input[0]/input_unit(r->m, 0);
    size_t n = 0;
    if (!r->begun)
        put_head(r);
    int inputs = r->in_time ? r->m->n_input : 1;
    if (r->in_time)
        r->flat[n++] = u;
    for (int i = 0; i < inputs; i++)
        r->flat[n++] = input[i]/input_unit(r->m, i);
    for (int k = 0; k < r->m->n_tracer; k++) {
        if (r->only >= 0 && r->only != k)
            continue;
        fill(r, &tracer[k], &r->turn[k], value);
        fill_geometry(r, &tracer[k], value + VALUES);
        if (to)
            to = (double *)memcpy(to, value, (size_t)r->values*sizeof *to) + r->values;
        if (r->as_json) {
            memcpy(r->flat + n, value, (size_t)r->values*sizeof *value);
            n += (size_t)r->values;
            continue;
        }
        for (size_t i = 0; i < n; i++)
            number(r->f, r->flat[i]), fputc(',', r->f);
        if (r->only < 0 && r->m->n_tracer > 1)
            cli_csv_text(r->f, r->m->tracer[k].name), fputc(',', r->f);
        for (int i = 0; i < r->values; i++)
            number(r->f, value[i]), fputc(i + 1 < r->values ? ',' : '\n', r->f);
    }
    if (r->as_json)
        cli_json_reals(&r->json, NULL, r->flat, n);
    return LW_OK;
}

/* Panels of places, velocities, accelerations, and with --geometry of the curvature, over the input or the time. */
static lw_status plot_rows(const rows *r, const char *path, lw_error *e)
{
    enum { PANELS = 4, LINES = 6 };
    static const char *const what[PANELS] = { "place", "velocity", "acceleration", "curvature" };
    const lw_spatial *m = r->m;
    bool turns = m->input[0].measure.of == LW_OF_TURN;
    const char *length = m->units.length[0] ? m->units.length : "m", *by = r->in_time || r->speed != 0 ? "s" : turns ? "rad" : length;
    int panels = r->values > VALUES ? PANELS : PANELS - 1;
    size_t width = 1 + (size_t)(r->values*printed(r)), n = r->n_kept, line = 0;
    char name[PANELS][LINES][LW_NAME_SIZE + 16], label[PANELS][64], input[64];
    lw_series series[PANELS][LINES];
    lw_plot plot[PANELS];
    double *y = malloc((1 + PANELS*LINES)*(n + 1)*sizeof *y);
    if (!y)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < n; i++)
        y[i] = r->kept[i*width];
    snprintf(input, sizeof input, r->in_time ? "time [s]" : "input [%s]", turns ? m->units.angle : length);
    snprintf(label[0], sizeof label[0], "place [%s]", length);
    snprintf(label[1], sizeof label[1], "velocity [%s/%s]", length, by);
    snprintf(label[2], sizeof label[2], "acceleration [%s/%s^2]", length, by);
    snprintf(label[3], sizeof label[3], "curvature [1/%s]", length);
    for (int p = 0; p < panels; p++) {
        int each = p == PANELS - 1 ? 1 : 3, first = p == PANELS - 1 ? VALUES : 3*p;
        plot[p] = (lw_plot){ .title = p ? NULL : m->name, .y_label = label[p], .x_label = p == panels - 1 ? input : NULL,
                             .series = series[p], .height = 260*panels };
        for (int k = 0; k < printed(r); k++)
            for (int c = 0; c < each; c++) {
                double *to = y + ++line*(n + 1);
                for (size_t i = 0; i < n; i++)
                    to[i] = r->kept[i*width + 1 + (size_t)(k*r->values + first + c)];
                int s = plot[p].n_series++;
                snprintf(name[p][s], sizeof name[p][s], "%s.%s", m->tracer[r->only < 0 ? k : r->only].name,
                         each == 1 ? what[p] : columns[first + c]);
                series[p][s] = (lw_series){ .name = name[p][s], .n = n, .x = y, .y = to };
            }
    }
    lw_status s = lw_draw_plots(panels, plot, path, e);
    free(y);
    return s;
}

static lw_status choose(const cli_spatial_trace *o, const char *file, rows *r, lw_error *e)
{
    const lw_spatial *m = r->m;
    r->only = -1;
    if (m->n_tracer == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "the model has no tracers: add points to follow, \"tracers\"");
    if (m->n_input == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "the model has no input to move: add an \"input\"");
    for (int k = 0; o->tracer && k < m->n_tracer; k++)
        if (strcmp(o->tracer, m->tracer[k].name) == 0)
            r->only = k;
    if (o->tracer && r->only < 0) {
        const char *near = LW_SUGGEST(o->tracer, m->tracer, m->n_tracer, name);
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "there is no tracer \"%.40s\"%s%s%s", o->tracer, LW_DID_YOU_MEAN(near));
    }
    if (o->plot && printed(r) > 2)
        return lw_error_set(e, LW_E_ARG, "%d tracers are too many lines for one plot; --tracer NAME draws one", m->n_tracer);
    bool slides = m->input[0].measure.of != LW_OF_TURN;
    return o->speed ? cli_speed(o->speed, slides, slides ? m->units.metre : 1, &r->speed, e) : LW_OK;
}

int cli_spatial_trace_run(const cli_call *call, const lw_spatial *m, const cli_spatial_trace *o)
{
    rows r = { .m = m, .as_json = call->common.json, .in_time = o->time_range != NULL,
               .values = o->geometry ? VALUES + GEOMETRY : VALUES, .plotted = o->plot != NULL };
    lw_space_trace t = { .whole = !o->input_range && !o->time_range, .in_time = o->time_range != NULL, .intervals =
                         o->steps,
                         .stop = cli_stop_flag() };
    lw_error e = { 0 };
    lw_output out;
    lw_status st = choose(o, call->parsed.word[0], &r, &e);
    if (st == LW_OK && o->speed && o->time_range)
        return cli_usage(call, "--speed and --time-range exclude each other");
    if (st != LW_OK)
        return cli_fail(call, &e);
    if (o->input_range)
        t.from = o->input_range[0]*input_unit(m, 0), t.to = o->input_range[1]*input_unit(m, 0);
    if (o->time_range) {
        t.from = o->time_range[0], t.to = o->time_range[1];
        t.intervals = (int)floor((t.to - t.from)/o->time_range[2] + 1e-9);
        t.intervals = t.intervals > 0 ? t.intervals : 1;
        t.to = t.from + t.intervals*o->time_range[2];
    }
    r.flat = malloc(((size_t)m->n_input + 1 + (size_t)(r.values*m->n_tracer))*sizeof *r.flat);
    r.turn = calloc((size_t)m->n_tracer + 1, sizeof *r.turn);
    st = r.flat && r.turn ? cli_open(call, &out, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st != LW_OK)
        return free(r.flat), free(r.turn), cli_fail(call, &e);
    r.f = out.f;
    st = lw_space_trace_run(m, &t, put_row, &r, &e);
    free(r.flat), free(r.turn);
    if (r.as_json && r.begun) {
        cli_json_end(&r.json);
        cli_json_bool(&r.json, "complete", st == LW_OK);
        cli_json_end(&r.json);
    }
    if (st == LW_OK && (t.limit[0] || t.limit[1]))
        cli_note(call, "the input runs from %.9g to %.9g %s: %s", t.from/input_unit(m, 0), t.to/input_unit(m, 0),
                 m->input[0].measure.of == LW_OF_TURN ? m->units.angle : m->units.length,
                 t.limit[0] && t.limit[1] ? "both ends are limits of the motion" : "one end is a limit of the motion");
    for (int k = 0; k < 2 && st == LW_OK; k++)
        if (t.away[k] >= 0)
            cli_note(call, "beyond its %s value link \"%s\" slides away without bound; rows end where it is %.3g times the size of the model from "
                     "its place in the file", k ? "greatest" : "least", m->body[t.away[k]].name, t.distance[k]);
    bool turns = m->input[0].measure.of == LW_OF_TURN;
    if (st == LW_OK && t.lost)
        lw_note_lost(cli_notes(call), t.in_time ? "t" : "the input", t.lost_at, t.in_time ? 1 : input_unit(m, 0),
                     t.in_time ? "s" : turns ? m->units.angle : m->units.length, t.lost_how);
    if (st == LW_OK && t.moved > 0)
        lw_note_adjusted(cli_notes(call), t.moved, t.turned);
    if (st == LW_OK && t.open > 1e-9)
        cli_note(call, "joints stay open by up to %.2g (over the size of the model, or radians): the linkage is overconstrained and its numbers are "
                 "rounded; taken as drawn it does not move (\"mobility\"), and limits may be those of the rounding", t.open);
    if (st == LW_OK && !o->time_range && m->n_input > 1)
        cli_note(call, "the first input moves, the other%s stand%s still; --time-range moves all by their \"motion\"",
                 m->n_input > 2 ? "s" : "", m->n_input > 2 ? "" : "s");
    if (st != LW_OK && !e.file[0])
        snprintf(e.file, sizeof e.file, "%s", call->parsed.word[0]);
    int code = cli_close(call, &out, st == LW_OK ? CLI_DONE : cli_fail(call, &e));
    char partial[LW_PATH_SIZE + 16];
    const char *to = o->plot && (code == CLI_DONE || r.n_kept > 0) ? cli_picture_path(call, o->plot, code, partial) : NULL;
    if (to && plot_rows(&r, to, &e) != LW_OK)
        code = cli_fail(call, &e);
    free(r.kept);
    return code;
}
