/* cli/motion/spatial_simulate.c - a run of a spatial model as rows of named columns, CSV or JSON. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/dynamics_report.h"
#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "cli/motion/table.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "mbs/formulations/formulations.h"

typedef struct run {
    const lw_spatial *m;
    const lw_space   *s;
    lw_dynamics      *d;
    lw_dynamics_report report;
    lw_rest           rest;
    lw_error         *e;
    lw_frame_motion  *tracer, *link;
    lw_space_inner   *inner;             /* of the nodes of one elastic link */
    cli_pull          pull;
    cli_suction       suction;
    cli_column       *column;
    int               n_column, capacity;
    const cli_column *renamed;           /* a column whose name another one before has; NULL: none */
    double           *row;
    FILE             *f;                 /* NULL: rows are only kept */
    bool              as_json, no_memory;
    cli_json          json;
    cli_table        *table;             /* NULL: rows are not kept */
    bool              film;              /* postures are kept, for a GIF */
    lw_space_pose    *pose;              /* [row*n_link + link] */
    lw_vec3          *path;              /* [row*n_tracer + tracer] */
} run;

static void add(run *r, const char *of, const char *part, const char *unit, double scale)
{
    if (r->n_column == r->capacity) {
        int capacity = 2*r->capacity + 64;
        cli_column *more = realloc(r->column, (size_t)capacity*sizeof *more);
        r->no_memory = r->no_memory || !more;
        if (!more)
            return;
        r->column = more;
        r->capacity = capacity;
    }
    cli_column *c = &r->column[r->n_column++];
    snprintf(c->name, sizeof c->name, "%s%s%s", of, *of && *part ? "." : "", part);
    c->unit = unit;
    c->scale = scale;
}

/* x, y, z after a prefix: "v" gives vx, vy, vz. */
static void add_vector(run *r, const char *of, const char *prefix, const char *unit, double scale)
{
    static const char axis[] = "xyz";
    char part[16];
    for (int i = 0; i < 3; i++) {
        snprintf(part, sizeof part, "%s%c", prefix, axis[i]);
        add(r, of, part, unit, scale);
    }
}

static void add_rate(run *r, const char *of, const char *part, bool turn, int order)
{
    const lw_units *u = &r->m->units;
    add(r, of, part, turn ? order == 1 ? "rad/s" : "rad/s^2" : lw_units_rate(u, order), turn ? 1 : 1/u->metre);
}

static void add_body(run *r, const char *name)
{
    static const char *const turn[] = { "qw", "qx", "qy", "qz" };
    const lw_units *u = &r->m->units;
    add_vector(r, name, "", u->length[0] ? u->length : "m", 1/u->metre);
    for (int i = 0; i < 4; i++)
        add(r, name, turn[i], "1", 1);
    add_vector(r, name, "v", lw_units_rate(u, 1), 1/u->metre);
    add_vector(r, name, "w", "rad/s", 1);
    add_vector(r, name, "a", lw_units_rate(u, 2), 1/u->metre);
    add_vector(r, name, "alpha_", "rad/s^2", 1);
}

static const char *force_unit(lw_spatial_measure of) { return of.of == LW_OF_TURN ? "N m" : "N"; }

static const lw_elastic_chain *chain_of(const run *r, int k)
{
    const lw_spatial_expansion *x = lw_dynamics_spatial_elastic(r->d);
    return x && k < x->n_chain ? &x->chain[k] : NULL;
}

/* Inside elastic links at their nodes. */
static void add_inner(run *r)
{
    static const char *const of[] = { "normal", "shear_y", "shear_z", "torque", "bending_y", "bending_z" };
    const lw_elastic_chain *c;
    for (int k = 0; (c = chain_of(r, k)); k++)
        for (int i = 0; i < c->n_bound && c->elastic->n_node == 0; i++) {
            for (int p = 0; p < 6; p++)
                add(r, r->m->body[c->node[i]].name, of[p], p < 3 ? "N" : "N m", 1);
            add(r, r->m->body[c->node[i]].name, "stress", "N/m^2", 1);
        }
}

/* Is a drive's measure that of an input, whose columns begin with its rate? */
static bool is_input(const lw_spatial *m, lw_spatial_measure of)
{
    bool is = false;
    for (int i = 0; i < m->n_input; i++)
        is = is || (m->input[i].measure.of == of.of && m->input[i].measure.index == of.index);
    return is;
}

static void make_columns(run *r)
{
    const lw_spatial *m = r->m;
    const char *length = m->units.length[0] ? m->units.length : "m";
    char name[LW_NAME_SIZE + 16];
    add(r, "t", "", "s", 1);
    for (int i = 0; i < m->n_input; i++) {
        lw_spatial_measure of = m->input[i].measure;
        bool turn = of.of == LW_OF_TURN;
        lw_spatial_measure_name(m, of, name, sizeof name);
        for (char *c = name; *c; c++)
            *c = *c == ' ' ? '_' : *c;
        add(r, name, "input", turn ? m->units.angle : length, turn ? 1/m->units.radian : 1/m->units.metre);
        add_rate(r, name, "rate", turn, 1);
        if (m->n_drive == 0) {
            add_rate(r, name, "acceleration", turn, 2);
            add(r, name, "drive", force_unit(of), 1);
        }
    }
    for (int i = 0; i < m->n_drive; i++) {
        lw_spatial_measure_name(m, m->drive[i], name, sizeof name);
        bool turn = m->drive[i].of == LW_OF_TURN;
        if (!is_input(m, m->drive[i]))
            add_rate(r, name, "rate", turn, 1);
        add_rate(r, name, "acceleration", turn, 2);
        add(r, name, "drive", force_unit(m->drive[i]), 1);
    }
    for (int i = 0; i < m->n_tracer; i++)
        add_body(r, m->tracer[i].name);
    for (int b = 0; b < r->s->n_body; b++)
        add_body(r, m->body[r->s->link_of[b]].name);
    for (int j = 0; j < m->n_joint; j++) {
        add_vector(r, m->joint[j].name, "f", "N", 1);
        add_vector(r, m->joint[j].name, "m", "N m", 1);
    }
    for (int i = 0; i < m->n_coupling; i++)
        add(r, m->coupling[i].name, "force", lw_spatial_coupling_slides(&m->coupling[i]) ? "N" : "N m", 1);
    for (int i = 0; i < m->n_contact; i++) {
        add(r, m->joint[m->contact[i]].name, "distance", length, 1/m->units.metre);
        add(r, m->joint[m->contact[i]].name, "contact", "N", 1);
    }
    add_inner(r);
    for (int i = 0; i < m->states.n_state; i++)
        add(r, m->states.state[i].name, "", m->states.state[i].unit, 1);
    for (int i = 0; i < m->states.n_signal; i++)
        add(r, m->states.signal[i].name, "", m->states.signal[i].unit, 1);
    add_vector(r, "momentum", "p", "kg m/s", 1);
    add_vector(r, "momentum", "l", "kg m^2/s", 1);
    add(r, "kinetic", "", "J", 1);
    add(r, "potential", "", "J", 1);
    if (lw_dynamics_spatial_elastic(r->d))
        add(r, "strain", "", "J", 1);
    add(r, "work", "", "J", 1);
    add(r, "residual", "", "1", 1);
    add(r, "residual_rate", "", "1/s", 1);
}

static void see_pull(run *r, const lw_space_moment *o, const lw_elastic_chain *c)
{
    const lw_section *p = &c->elastic->section;
    for (int i = 0; i + 1 < c->n_bound; i++) {
        lw_vec3 along = lw_v3_sub(o->frame[r->s->body_of[c->node[i + 1]] + 1].at, o->frame[r->s->body_of[c->node[i]] + 1].at);
        cli_pull_see(&r->pull, c, (r->inner[i].normal + r->inner[i + 1].normal)/2, lw_v3_norm(along), fmin(p->iy, p->iz));
    }
}

static double *put_inner(run *r, const lw_space_moment *o, double *to)
{
    const lw_elastic_chain *c;
    for (int k = 0; (c = chain_of(r, k)); k++) {
        lw_dynamics_space_inner(r->d, o, k, r->inner);
        if (c->condensed && c->elastic->n_node == 0)
            see_pull(r, o, c);
        for (int i = 0; i < c->n_bound && c->elastic->n_node == 0; i++) {
            const lw_space_inner *p = &r->inner[i];
            const double all[] = { p->normal, p->shear[0], p->shear[1], p->torque, p->bending[0], p->bending[1], p->stress };
            memcpy(to, all, sizeof all);
            to += sizeof all/sizeof *all;
        }
    }
    return to;
}

static double *put(double *to, lw_vec3 a)
{
    to[0] = a.x, to[1] = a.y, to[2] = a.z;
    return to + 3;
}

/* `to` holds the row before, which decides the sign of the quaternion. */
static double *put_body(double *to, const lw_frame_motion *m)
{
    to = put(to, m->place);
    lw_quaternion q = lw_quaternion_beside((lw_quaternion){ to[0], to[1], to[2], to[3] }, m->turn);
    *to++ = q.w, *to++ = q.x, *to++ = q.y, *to++ = q.z;
    return put(put(put(put(to, m->velocity), m->omega), m->acceleration), m->alpha);
}

static void put_number(FILE *f, double v)
{
    char text[LW_NUMBER_SIZE];
    if (isnan(v))
        return;
    lw_number_print(v + 0.0, text);
    fputs(text, f);
}

/* Acceleration of a measure [rad/s^2] or [m/s^2]. */
static double acceleration(const run *r, const lw_space_moment *o, lw_spatial_measure of)
{
    double value, out;
    lw_space_measured(r->s, o->frame, of, 0, o->a, &value, &out);
    return out - lw_space_measure_bias(r->s, o->frame, of, o->v)*lw_space_scale(r->s, of);
}

/* Room for a number of rows of `size` bytes, doubled when it is full; false: no memory. */
static bool make_room(void **rows, size_t n, size_t size)
{
    if (n & (n - 1))
        return true;
    void *more = realloc(*rows, (n ? 2*n : 1)*size + 1);
    *rows = more ? more : *rows;
    return more != NULL;
}

static lw_status keep_row(run *r)
{
    cli_table *t = r->table;
    size_t n = t->n_row, columns = (size_t)r->n_column, links = (size_t)r->m->n_link, tracers = (size_t)r->m->n_tracer;
    if (!make_room((void **)&t->row, n, columns*sizeof *t->row))
        return LW_E_MEMORY;
    memcpy(t->row + n*columns, r->row, columns*sizeof *r->row);
    if (r->film && (!make_room((void **)&r->pose, n, links*sizeof *r->pose) || !make_room((void **)&r->path, n, tracers*sizeof *r->path)))
        return LW_E_MEMORY;
    for (size_t i = 0; r->film && i < links; i++)
        r->pose[n*links + i] = (lw_space_pose){ r->link[i].place, r->link[i].turn };
    for (size_t i = 0; r->film && i < tracers; i++)
        r->path[n*tracers + i] = r->tracer[i].place;
    t->n_row++;
    return LW_OK;
}

static lw_status put_row(void *context, const lw_moment *moment)
{
    run *r = context;
    const lw_spatial *m = r->m;
    lw_space_moment all, *o = &all;
    lw_status st = lw_dynamics_space_moment(r->d, moment, o, r->e);
    if (st != LW_OK)
        return st;
    const lw_space *s = r->s;
    double *to = r->row;
    lw_vec3 linear, angular;
    *to++ = o->t;
    for (int i = 0; i < m->n_input; i++) {
        *to++ = o->input[i], *to++ = o->input_rate[i];
        if (m->n_drive == 0) {
            *to++ = acceleration(r, o, m->input[i].measure);
            *to++ = o->drive[i];
        }
    }
    for (int i = 0; i < m->n_drive; i++) {
        double value;
        lw_space_measured(s, o->frame, m->drive[i], 0, o->v, &value, to);
        to += !is_input(m, m->drive[i]);
        *to++ = acceleration(r, o, m->drive[i]);
        *to++ = o->drive[i];
    }
    lw_space_tracers(s, o->frame, o->q, o->v, o->a, r->tracer);
    for (int i = 0; i < m->n_tracer; i++)
        to = put_body(to, &r->tracer[i]);
    lw_space_links(s, o, r->link);
    for (int b = 0; b < s->n_body; b++)
        to = put_body(to, &r->link[s->link_of[b]]);
    for (int j = 0; j < m->n_joint; j++)
        to = put(put(to, o->joint[j].force), o->joint[j].moment);
    for (int i = 0; i < m->n_coupling; i++)
        *to++ = o->coupling[i];
    for (int i = 0; i < m->n_contact; i++) {
        lw_space_touch touch = lw_dynamics_space_touch(r->d, i, o);
        *to++ = touch.distance, *to++ = touch.force;
    }
    to = put_inner(r, o, to);
    cli_suction_see(&r->suction, &m->states, moment->z, moment->t);
    for (int i = 0; i < m->states.n_state; i++)
        *to++ = moment->z[i];
    for (int i = 0; i < m->states.n_signal; i++)
        *to++ = lw_dynamics_space_signal(r->d, i, o);
    lw_dynamics_space_momentum(r->d, o, &linear, &angular);
    to = put(put(to, linear), angular);
    *to++ = o->kinetic, *to++ = o->potential;
    if (lw_dynamics_spatial_elastic(r->d))
        *to++ = lw_dynamics_space_strain(r->d, o);
    *to++ = o->work, *to++ = o->off, *to++ = o->off_rate;
    for (int i = 0; i < r->n_column; i++)
        r->row[i] *= r->column[i].scale;
    lw_status kept = r->table ? keep_row(r) : LW_OK;
    if (r->f && r->as_json)
        cli_json_reals(&r->json, NULL, r->row, (size_t)r->n_column);
    else
        for (int i = 0; r->f && i < r->n_column; i++)
            put_number(r->f, r->row[i]), fputc(i + 1 < r->n_column ? ',' : '\n', r->f);
    return kept;
}

static void head(run *r, const cli_call *call)
{
    if (r->as_json)
        r->json = cli_columns_json(r->f, call, r->column, r->n_column);
    else
        cli_columns_print(r->f, r->column, r->n_column);
}

lw_status cli_spatial_speed(lw_spatial *m, const char *speed, lw_error *e)
{
    char text[96];
    bool used = false;
    if (!speed)
        return LW_OK;
    if (m->n_input == 0)
        return lw_error_set(e, LW_E_ARG, "--speed is for inputs, and the model has none");
    for (int i = 0; i < m->n_input; i++) {
        double value;
        if (m->input[i].motion)
            continue;
        lw_status st = cli_speed(speed, m->input[i].measure.of != LW_OF_TURN, 1, &value, e);
        if (st != LW_OK)
            return st;
        snprintf(text, sizeof text, "%.17g + %.17g*t", m->input[i].value, value);
        if ((st = lw_spatial_set_motion(m, i, text, e)) != LW_OK)
            return st;
        used = true;
    }
    return used ? LW_OK : lw_error_set(e, LW_E_ARG, "--speed is for inputs without a motion, and here each has one");
}

/* The model that is solved: its elastic links are nodes, everything else keeps its index. */
static void take_scene(run *r)
{
    const lw_elastic_chain *c;
    size_t most = 1;
    r->s = lw_dynamics_space(r->d);
    r->m = r->s->model;
    for (int k = 0; (c = chain_of(r, k)); k++)
        most = (size_t)c->n_node > most ? (size_t)c->n_node : most;
    r->inner = malloc(most*sizeof *r->inner);
    r->no_memory = r->no_memory || !r->inner;
}

static lw_status prepare(run *r, lw_spatial *m, const lw_dynamics_options *o, const char *speed)
{
    lw_status st = cli_spatial_speed(m, speed, r->e);
    if (st == LW_OK)
        st = lw_dynamics_make_spatial(m, o, &r->d, r->e);
    if (st != LW_OK)
        return st;
    r->report = *lw_dynamics_choice(r->d);
    take_scene(r);
    make_columns(r);
    r->row = calloc((size_t)r->n_column, sizeof *r->row);
    r->tracer = malloc(((size_t)m->n_tracer + 1)*sizeof *r->tracer);
    r->link = malloc((size_t)r->m->n_link*sizeof *r->link);
    if (r->no_memory || !r->row || !r->tracer || !r->link)
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    return cli_columns_differ(r->column, r->n_column, &r->renamed, r->e);
}

/* Print the contacts of joints with clearance in a run that reached time t. */
static void note_contacts(const cli_call *call, const run *r, double from, double t)
{
    for (int i = 0; i < r->m->n_contact; i++) {
        const lw_space_contact *p = lw_dynamics_space_contact(r->d, i);
        cli_note(call, "clearance of joint \"%s\": apart for %.3g %% of the time, contact lost %ld time%s, greatest force %.4g N, "
                 "greatest distance of the centres %.4g m", r->m->joint[p->joint].name, t > from ? 100*p->apart/(t - from) : 0,
                 p->losses, lw_plural(p->losses), p->force_most, p->distance_most);
    }
}

static void end(run *r)
{
    free(r->row), free(r->tracer), free(r->link), free(r->inner), free(r->column), free(r->pose), free(r->path);
    lw_dynamics_free(r->d);
}

lw_status cli_spatial_table(lw_spatial *m, const lw_dynamics_options *o, const char *speed, cli_table *t, lw_error *e)
{
    run r = { .m = m, .table = t, .e = e };
    lw_status st = prepare(&r, m, o, speed);
    if (st == LW_OK)
        st = lw_dynamics_analyse(r.d, put_row, &r, &r.report, &r.rest, e);
    t->n_column = r.n_column;
    t->column = r.column;
    r.column = NULL;
    end(&r);
    return st;
}

/* The motion of the rows; elastic links bend with their nodes. */
static lw_status save_gif(const cli_call *call, const run *r, const char *path)
{
    const cli_table *t = r->table;
    lw_vec3 *origin = calloc((size_t)r->m->n_link, sizeof *origin);
    double seconds = t->n_row > 1 ? cli_table_at(t, t->n_row - 1, 0) - cli_table_at(t, 0, 0) : 0;
    lw_space_scene_options o = { .n_frame = t->n_row, .pose = r->pose, .path = r->path, .origin = origin, .until = seconds };
    lw_space_scene scene;
    lw_bytes bytes = { 0 };
    if (!origin)
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    for (int b = 0; b < r->s->n_body; b++) {
        const double *q = r->s->start + 7*b, unit = r->s->unit;
        origin[r->s->link_of[b]] = lw_v3(unit*q[0], unit*q[1], unit*q[2]);
    }
    lw_status st = lw_space_scene_make(r->m, &o, &scene, r->e);
    if (st == LW_OK)
        st = lw_draw_space(&scene, lw_space_view_default(), LW_DRAW_GIF, 0, 0, &bytes, r->e);
    if (st == LW_OK)
        st = lw_file_write(path, bytes.data, bytes.size, r->e);
    if (st == LW_OK)
        cli_note_slower(call, t->n_row, seconds);
    free(origin);
    lw_bytes_free(&bytes);
    lw_space_scene_free(&scene);
    return st;
}

/* Draw the rows of a run that ended with `code`. */
static int pictures(const cli_call *call, const run *r, const cli_spatial_pictures *p, int code)
{
    char partial[LW_PATH_SIZE + 16];
    const char *to;
    lw_status st = LW_OK;
    *r->e = (lw_error){ 0 };
    if (p->plot && (to = cli_picture_path(call, p->plot, code, partial)))
        st = cli_table_plot(r->table, r->m->name, p->columns, to, r->e);
    if (st == LW_OK && p->gif && (to = cli_picture_path(call, p->gif, code, partial)))
        st = save_gif(call, r, to);
    return st == LW_OK ? code : cli_fail(call, r->e);
}

int cli_spatial_simulate(const cli_call *call, lw_spatial *m, const lw_dynamics_options *o, const char *speed,
                         bool explain, const cli_spatial_pictures *p)
{
    lw_error e = { 0 };
    cli_table kept = { 0 };
    bool picture = p->plot || p->gif;
    run r = { .m = m, .as_json = call->common.json, .e = &e, .table = picture ? &kept : NULL, .film = p->gif != NULL };
    lw_output out;
    int code;
    lw_status st = prepare(&r, m, o, speed);
    if (st == LW_OK && explain) {
        cli_dynamics_explain(call, &r.report);
        cli_explain_elastic_spatial(call, m, r.d, o->from, o->to);
    }
    if (st == LW_OK)
        st = cli_open(call, &out, &e);
    if (st == LW_OK) {
        cli_note_column(call, r.renamed);
        r.f = out.f;
        kept.n_column = r.n_column;
        kept.column = r.column;
        head(&r, call);
        st = lw_dynamics_analyse(r.d, put_row, &r, &r.report, &r.rest, &e);
        if (r.as_json)
            cli_dynamics_tail(&r.json, r.d, &r.report, st, &e);
        else
            cli_dynamics_remarks(r.f, &r.report, st, &e);
        cli_dynamics_notes(call, r.d, &r.report);
        cli_note_pull(call, &r.pull, r.pull.chain ? r.m->body[r.pull.chain->node[0]].name : "");
        cli_suction_note(call, &r.suction);
        if (explain)
            note_contacts(call, &r, o->from, r.report.t);
        if (r.report.formulation == LW_FORMULATION_AUTO && r.report.samples > 0)
            cli_note(call, "at rest after %d iterations, %s", r.rest.iterations, lw_rest_text(&r.rest));
        bool limit = st == LW_STOPPED && r.report.samples > 0;
        if (limit)
            cli_note(call, "%s; the rows so far are kept", e.text);
        if (!e.file[0])
            snprintf(e.file, sizeof e.file, "%s", call->parsed.word[0]);
        code = cli_close(call, &out, st == LW_OK ? CLI_DONE : limit ? CLI_LIMIT : cli_fail(call, &e));
        if (picture && kept.n_row > 0)
            code = pictures(call, &r, p, code);
    } else {
        if (!e.file[0])
            snprintf(e.file, sizeof e.file, "%s", call->parsed.word[0]);
        code = cli_fail(call, &e);
    }
    free(kept.row);
    end(&r);
    return code;
}
