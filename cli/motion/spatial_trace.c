/* cli/motion/spatial_trace.c - paths of the tracers of a spatial model, as CSV or JSON. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "cli/motion/spatial.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "mbs/space/space_trace.h"

#define VALUES 22
static const char *const columns[VALUES] = { "x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "qw", "qx", "qy", "qz",
                                             "rx", "ry", "rz", "wx", "wy", "wz", "alpha_x", "alpha_y", "alpha_z" };

typedef struct rows {
    const lw_spatial *m;
    FILE    *f;
    cli_json json;
    bool     as_json, in_time;
    int      only;                       /* this tracer, -1: all */
    double   speed;                      /* rates are by time at this speed of the input; 0: by the input */
    double  *flat;
} rows;

int cli_spatial_refuse(const cli_call *call, const char *const *names)
{
    for (; *names; names++)
        if (cli_given(&call->parsed, *names))
            return cli_usage(call, "--%s is for planar models; this model is spatial", *names);
    return CLI_DONE;
}

static void put_vector(double *to, lw_vec3 a, double unit) { to[0] = a.x/unit, to[1] = a.y/unit, to[2] = a.z/unit; }

/* The numbers of a tracer in the units of the file. */
static void fill(const rows *r, const lw_space_tracer *t, double *out)
{
    double metre = r->m->units.metre, w = r->speed != 0 ? r->speed : 1;
    double quaternion[] = { t->turn.w, t->turn.x, t->turn.y, t->turn.z };
    put_vector(out, t->place, metre);
    put_vector(out + 3, lw_v3_scale(t->velocity, w), metre);
    put_vector(out + 6, lw_v3_scale(t->acceleration, w*w), metre);
    for (int i = 0; i < 4; i++)
        out[9 + i] = quaternion[0] < 0 ? -quaternion[i] : quaternion[i];
    put_vector(out + 13, lw_quaternion_vector(t->turn), r->m->units.radian);
    put_vector(out + 16, lw_v3_scale(t->omega, w), 1);
    put_vector(out + 19, lw_v3_scale(t->alpha, w*w), 1);
}

static double input_unit(const lw_spatial *m, int i)
{
    return m->input[i].measure.of == LW_OF_TURN ? m->units.radian : m->units.metre;
}

static void number(FILE *f, double v)
{
    char text[LW_NUMBER_SIZE];
    lw_number_print(v + 0.0, text);
    fputs(text, f);
}

static lw_status put_row(void *context, double u, const double *input, const lw_space_tracer *tracer)
{
    rows *r = context;
    double value[VALUES];
    size_t n = 0;
    int inputs = r->in_time ? r->m->n_input : 1;
    if (r->in_time)
        r->flat[n++] = u;
    for (int i = 0; i < inputs; i++)
        r->flat[n++] = input[i]/input_unit(r->m, i);
    for (int k = 0; k < r->m->n_tracer; k++) {
        if (r->only >= 0 && r->only != k)
            continue;
        fill(r, &tracer[k], value);
        if (r->as_json) {
            memcpy(r->flat + n, value, sizeof value);
            n += VALUES;
            continue;
        }
        for (size_t i = 0; i < n; i++)
            number(r->f, r->flat[i]), fputc(',', r->f);
        if (r->only < 0 && r->m->n_tracer > 1)
            fprintf(r->f, "%s,", r->m->tracer[k].name);
        for (int i = 0; i < VALUES; i++)
            number(r->f, value[i]), fputc(i + 1 < VALUES ? ',' : '\n', r->f);
    }
    if (r->as_json)
        cli_json_reals(&r->json, NULL, r->flat, n);
    return LW_OK;
}

static void name_input(int i, char *text, size_t size)
{
    if (i)
        snprintf(text, size, "input_%d", i + 1);
    else
        snprintf(text, size, "input");
}

static void put_head(rows *r)
{
    const lw_spatial *m = r->m;
    const char *length = m->units.length[0] ? m->units.length : "m";
    const char *by = r->in_time || r->speed != 0 ? "s" : m->input[0].measure.of == LW_OF_TURN ? "rad" : length;
    char name[LW_NAME_SIZE + 16];
    int inputs = r->in_time ? m->n_input : 1;
    if (!r->as_json) {
        fputs("# units: ", r->f);
        if (r->in_time)
            fputs("time s; ", r->f);
        for (int i = 0; i < inputs; i++) {
            name_input(i, name, sizeof name);
            fprintf(r->f, "%s %s; ", name, m->input[i].measure.of == LW_OF_TURN ? m->units.angle : length);
        }
        fprintf(r->f, "x y z %s; v a %s/%s %s/%s^2; q quaternion, r rotation vector %s; w alpha rad/%s rad/%s^2\n",
                length, length,
                by, length, by, m->units.angle, by, by);
        if (r->in_time)
            fputs("time,", r->f);
        for (int i = 0; i < inputs; i++) {
            name_input(i, name, sizeof name);
            fprintf(r->f, "%s,", name);
        }
        if (r->only < 0 && m->n_tracer > 1)
            fputs("tracer,", r->f);
        for (int i = 0; i < VALUES; i++)
            fprintf(r->f, "%s%c", columns[i], i + 1 < VALUES ? ',' : '\n');
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
        for (int i = 0; i < VALUES && (r->only < 0 || r->only == k); i++) {
            snprintf(name, sizeof name, "%s.%s", m->tracer[k].name, columns[i]);
            cli_json_text(&r->json, NULL, name);
        }
    cli_json_end(&r->json);
    cli_json_array(&r->json, "rows");
}

static lw_status choose(const cli_spatial_trace *o, const char *file, rows *r, lw_error *e)
{
    const lw_spatial *m = r->m;
    const char *names[64];
    r->only = -1;
    if (m->n_tracer == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "the model has no tracers: add points to follow, \"tracers\"");
    if (m->n_input == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "the model has no input to move: add an \"input\"");
    for (int k = 0; o->tracer && k < m->n_tracer; k++)
        if (strcmp(o->tracer, m->tracer[k].name) == 0)
            r->only = k;
    if (o->tracer && r->only < 0) {
        int n = m->n_tracer < 64 ? m->n_tracer : 64;
        for (int k = 0; k < n; k++)
            names[k] = m->tracer[k].name;
        const char *near = lw_suggest(o->tracer, names, n);
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "there is no tracer \"%.40s\"%s%s%s", o->tracer, near ?
                           "; did you mean \"" : "",
                           near ? near : "", near ? "\"?" : "");
    }
    bool slides = m->input[0].measure.of != LW_OF_TURN;
    return o->speed ? cli_speed(o->speed, slides, slides ? m->units.metre : 1, &r->speed, e) : LW_OK;
}

int cli_spatial_trace_run(const cli_call *call, const lw_spatial *m, const cli_spatial_trace *o)
{
    rows r = { .m = m, .as_json = call->common.json, .in_time = o->time_range != NULL };
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
    r.flat = malloc(((size_t)m->n_input + 1 + VALUES*(size_t)m->n_tracer)*sizeof *r.flat);
    st = r.flat ? cli_open(call, &out, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st != LW_OK)
        return free(r.flat), cli_fail(call, &e);
    r.f = out.f;
    put_head(&r);
    st = lw_space_trace_run(m, &t, put_row, &r, &e);
    free(r.flat);
    if (r.as_json) {
        cli_json_end(&r.json);
        cli_json_bool(&r.json, "complete", st == LW_OK);
        cli_json_end(&r.json);
    }
    if (st == LW_OK && (t.limit[0] || t.limit[1]))
        cli_note(call, "the input runs from %.9g to %.9g %s: %s", t.from/input_unit(m, 0), t.to/input_unit(m, 0),
                 m->input[0].measure.of == LW_OF_TURN ? m->units.angle : m->units.length,
                 t.limit[0] && t.limit[1] ? "both ends are limits of the motion" : "one end is a limit of the motion");
    if (st == LW_OK && !o->time_range && m->n_input > 1)
        cli_note(call, "the first input moves, the other%s stand%s still; --time-range moves all by their \"motion\"",
                 m->n_input > 2 ? "s" : "", m->n_input > 2 ? "" : "s");
    if (st != LW_OK && !e.file[0])
        snprintf(e.file, sizeof e.file, "%s", call->parsed.word[0]);
    return cli_close(call, &out, st == LW_OK ? CLI_DONE : cli_fail(call, &e));
}
