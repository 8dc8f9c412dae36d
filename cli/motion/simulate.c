#include "cli/motion/dynamics_report.h"
#include "cli/motion/simulate.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/real.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "mbs/formulations/formulations.h"

/* ---- columns ----------------------------------------------------------------------------------------- */

static void add(cli_simulate *s, const char *unit, double scale, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void add(cli_simulate *s, const char *unit, double scale, const char *format, ...)
{
    va_list arg;
    cli_column *c = &s->column[s->n_column++];
    va_start(arg, format);
    vsnprintf(c->name, sizeof c->name, format, arg);
    va_end(arg);
    c->unit = unit;
    c->scale = scale;
}

/* Memory for the columns and for a row. */
static lw_status reserve_columns(cli_simulate *s, lw_error *e)
{
    const lw_assembly *k = &lw_dynamics_model(s->d)->linkage;
    const lw_system *sys = lw_dynamics_system(s->d);
    size_t n = 1 + 3*(size_t)k->n_input + 6*(size_t)k->n_tracer + 9*(size_t)sys->n_body + 3*(size_t)k->n_joint + 8
             + (size_t)s->model->states.n_state + (size_t)s->model->states.n_signal + 1
             + 2*(size_t)s->model->n_contact + (size_t)s->model->n_rope;
    const lw_elastic_expansion *elastic = lw_dynamics_elastic(s->d);
    int most = 0;
    for (int c = 0; elastic && c < elastic->n_chain; c++) {
        n += 4*(size_t)elastic->chain[c].n_node + 1;
        most = elastic->chain[c].n_node > most ? elastic->chain[c].n_node : most;
    }
    s->inner = calloc((size_t)most + 1, sizeof *s->inner);
    s->n_column = 0;
    s->column = calloc(n, sizeof *s->column);
    s->scratch = calloc(n + 3*(size_t)sys->n_q + (size_t)k->n_input + 3*(size_t)k->n_joint + 1 + n, sizeof *s->scratch);
    return s->column && s->scratch && s->inner ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* The order is the same as in cli_simulate_row. */
static void name_columns(cli_simulate *s)
{
    const lw_assembly *k = &lw_dynamics_model(s->d)->linkage;
    const lw_system *sys = lw_dynamics_system(s->d);
    const lw_elastic_expansion *elastic = lw_dynamics_elastic(s->d);
    const char *length = k->units.length[0] ? k->units.length : "m", *angle = k->units.angle;
    double metre = 1/k->units.metre, radian = 1/k->units.radian;
    add(s, "s", 1, "t");
    for (int i = 0; i < k->n_input; i++) {
        const char *name = k->joint[k->input[i].joint].name;
        bool pin = lw_joint_turns(k->joint[k->input[i].joint].kind);
        add(s, pin ? angle : length, pin ? radian : metre, "%s.input", name);
        add(s, pin ? "rad/s" : lw_units_rate(&k->units, 1), pin ? 1 : metre, "%s.rate", name);
        add(s, pin ? "N m" : "N", 1, "%s.drive", name);
    }
    for (int i = 0; i < k->n_tracer; i++)
        for (int order = 0; order < 3; order++)
            for (int axis = 0; axis < 2; axis++)
                add(s, order ? lw_units_rate(&k->units, order) : length, metre, "%s.%s%c", k->tracer[i].name,
                    order == 0 ? "" : order == 1 ? "v" : "a", axis ? 'y' : 'x');
    for (int b = 0; b < sys->n_body; b++) {
        const char *name = k->link_name[sys->link[b]];
        add(s, length, metre, "%s.x", name);
        add(s, length, metre, "%s.y", name);
        add(s, angle, radian, "%s.turn", name);
        add(s, lw_units_rate(&k->units, 1), metre, "%s.vx", name);
        add(s, lw_units_rate(&k->units, 1), metre, "%s.vy", name);
        add(s, "rad/s", 1, "%s.omega", name);
        add(s, lw_units_rate(&k->units, 2), metre, "%s.ax", name);
        add(s, lw_units_rate(&k->units, 2), metre, "%s.ay", name);
        add(s, "rad/s^2", 1, "%s.alpha", name);
    }
    for (int i = 0; i < k->n_joint; i++) {
        add(s, "N", 1, "%s.fx", k->joint[i].name);
        add(s, "N", 1, "%s.fy", k->joint[i].name);
        add(s, "N m", 1, "%s.moment", k->joint[i].name);
    }
    for (int c = 0; elastic && c < elastic->n_chain; c++) {
        const lw_elastic_chain *chain = &elastic->chain[c];
        if (chain->elastic->n_node > 0)              /* without a section */
            continue;
        for (int i = 0; i < chain->n_bound; i++) {
            const char *name = k->link_name[chain->node[i]];
            add(s, "N", 1, "%s.normal", name);
            add(s, "N", 1, "%s.shear", name);
            add(s, "N m", 1, "%s.bending", name);
            add(s, "N/m^2", 1, "%s.stress", name);
        }
        add(s, "N/m^2", 1, "%s.stress", s->model->linkage.link_name[chain->link]);
    }
    for (int i = 0; i < s->model->n_contact; i++) {
        add(s, "N", 1, "%s.fx", s->model->contact[i].name);
        add(s, "N", 1, "%s.fy", s->model->contact[i].name);
    }
    for (int i = 0; i < s->model->n_rope; i++)
        add(s, "N", 1, "%s.tension", s->model->rope[i].name);
    add(s, "N", 1, "shaking.fx");
    add(s, "N", 1, "shaking.fy");
    add(s, "N m", 1, "shaking.moment");
    for (int i = 0; i < s->model->states.n_state; i++)
        add(s, s->model->states.state[i].unit, 1, "%s", s->model->states.state[i].name);
    for (int i = 0; i < s->model->states.n_signal; i++)
        add(s, s->model->states.signal[i].unit, 1, "%s", s->model->states.signal[i].name);
    add(s, "J", 1, "kinetic");
    add(s, "J", 1, "potential");
    if (elastic)
        add(s, "J", 1, "strain");
    add(s, "J", 1, "work");
    add(s, "1", 1, "residual");
    add(s, "1/s", 1, "residual_rate");
}

lw_status cli_simulate_speed(lw_model *m, const char *speed, const char *file, lw_error *e)
{
    char text[96];
    bool used = false;
    if (!speed)
        return LW_OK;
    if (m->linkage.n_input == 0)
        return lw_error_at(e, LW_E_ARG, file, 0, 0, "--speed is for inputs, and the model has none");
    for (int i = 0; i < lw_assembly_free_inputs(&m->linkage); i++) {
        if (m->motion[i])
            continue;
        double rate;
        lw_status s = cli_speed(speed, lw_joint_slides(m->linkage.joint[m->linkage.input[i].joint].kind), 1, &rate, e);
        if (s != LW_OK)
            return s;
        snprintf(text, sizeof text, "%.17g + %.17g*t", m->linkage.input[i].value, rate);
        s = lw_model_drive(m, i, text, e);
        if (s != LW_OK)
            return s;
        used = true;
    }
    return used ? LW_OK : lw_error_at(e, LW_E_ARG, file, 0, 0, "--speed is for inputs without a motion, and here each has one");
}

lw_status cli_simulate_make(cli_simulate *s, const lw_dynamics_options *o, const char *file, lw_error *e)
{
    lw_status st = lw_dynamics_make(s->model, o, &s->d, e);
    const cli_column *renamed = NULL;
    s->options = *o;
    if (st == LW_OK && (st = reserve_columns(s, e)) == LW_OK) {
        name_columns(s);
        st = cli_columns_differ(s->column, s->n_column, &renamed, e);
    }
    if (s->call)
        cli_note_column(s->call, renamed);
    if (st != LW_OK && !e->file[0])
        snprintf(e->file, sizeof e->file, "%s", file);
    return st;
}

/* ---- one row ------------------------------------------------------------------------------------------- */

static double *put_inputs(const cli_simulate *s, const lw_moment *m, double *to)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    const lw_assembly *k = &lw_dynamics_model(s->d)->linkage;
    double *drive = s->scratch + s->n_column + 3*sys->n_q;
    lw_measure z;
    lw_reactions_driving(s->d, m, drive);
    for (int i = 0; i < k->n_input; i++) {
        lw_measure_joint(sys, k->input[i].joint, m->q, m->v, false, &z);
        *to++ = k->input[i].value + z.value;
        *to++ = z.rate;
        *to++ = drive[i];
    }
    return to;
}

static double *put_tracers(const cli_simulate *s, const lw_moment *m, double *to)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    double *series = s->scratch + s->n_column;
    lw_vec2 p[3];
    for (int i = 0; i < sys->n_q; i++) {
        series[i] = m->q[i];
        series[sys->n_q + i] = m->v[i];
        series[2*sys->n_q + i] = 0.5*m->a[i];
    }
    for (int i = 0; i < sys->n_tracer; i++) {
        lw_system_point_series(sys, sys->tracer_body[i], sys->tracer_arm[i], 2, series, p);
        for (int order = 0; order < 3; order++) {
            *to++ = p[order].x*(order == 2 ? 2 : 1);
            *to++ = p[order].y*(order == 2 ? 2 : 1);
        }
    }
    return to;
}

static double *put_links(const cli_simulate *s, const lw_moment *m, double *to)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    for (int b = 0; b < sys->n_body; b++) {
        lw_vec2 at = lw_system_point(sys, b, lw_v2(0, 0), m->q);
        *to++ = at.x;
        *to++ = at.y;
        *to++ = m->q[3*b + 2];
        for (int i = 0; i < 3; i++)
            *to++ = m->v[3*b + i]*(i < 2 ? sys->unit : 1);
        for (int i = 0; i < 3; i++)
            *to++ = m->a[3*b + i]*(i < 2 ? sys->unit : 1);
    }
    return to;
}

static double *put_reaction(lw_reaction r, double *to)
{
    *to++ = r.force.x;
    *to++ = r.force.y;
    *to++ = r.moment;
    return to;
}

/* Inner forces of the nodes of an elastic link, and its greatest stress. */
static double *put_inner(cli_simulate *s, const lw_moment *m, int chain, double *to)
{
    const lw_elastic_chain *c = &lw_dynamics_elastic(s->d)->chain[chain];
    const lw_system *sys = lw_dynamics_system(s->d);
    int n = c->n_bound;
    double most = 0;
    lw_reactions_inner(s->d, m, chain, s->inner);
    for (int i = 0; c->condensed && i + 1 < n; i++) {
        lw_vec2 from = lw_system_point(sys, sys->body[c->node[i]], lw_v2(0, 0), m->q), end = lw_system_point(sys, sys->body[c->node[i + 1]], lw_v2(0, 0), m->q);
        cli_pull_see(&s->pull, c, (s->inner[i].normal + s->inner[i + 1].normal)/2, lw_v2_norm(lw_v2_sub(end, from)), c->elastic->section.iz);
    }
    for (int i = 0; i < n; i++) {
        *to++ = s->inner[i].normal;
        *to++ = s->inner[i].shear;
        *to++ = s->inner[i].moment;
        *to++ = s->inner[i].stress;
        most = fabs(s->inner[i].stress) <= fabs(most) ? most : s->inner[i].stress;
    }
    *to++ = most;
    return to;
}

/* forces: scratch. */
static double *put_contacts(const cli_simulate *s, const lw_moment *m, double *forces, double *to)
{
    lw_vec2 *contact = (lw_vec2 *)(void *)forces;
    double *rope = forces + 2*s->model->n_contact;
    lw_reactions_contacts(s->d, m, contact, rope);
    for (int i = 0; i < s->model->n_contact; i++) {
        *to++ = contact[i].x;
        *to++ = contact[i].y;
    }
    for (int i = 0; i < s->model->n_rope; i++)
        *to++ = rope[i];
    return to;
}

static void fill(cli_simulate *s, const lw_moment *m, double *row)
{
    const lw_elastic_expansion *elastic = lw_dynamics_elastic(s->d);
    const lw_assembly *k = &lw_dynamics_model(s->d)->linkage;
    double *drive = s->scratch + s->n_column + 3*lw_dynamics_system(s->d)->n_q;
    lw_reaction *joint = (lw_reaction *)(void *)(drive + k->n_input);
    double *to = row;
    *to++ = m->t;
    to = put_inputs(s, m, to);
    to = put_tracers(s, m, to);
    to = put_links(s, m, to);
    lw_reactions_joints(s->d, m, joint);
    for (int j = 0; j < k->n_joint; j++)
        to = put_reaction(joint[j], to);
    for (int c = 0; elastic && c < elastic->n_chain; c++)
        to = elastic->chain[c].elastic->n_node > 0 ? to : put_inner(s, m, c, to);
    to = put_contacts(s, m, (double *)(void *)(joint + k->n_joint), to);
    to = put_reaction(lw_reactions_shaking(s->d, m), to);
    for (int i = 0; i < s->model->states.n_state; i++)
        *to++ = m->z[i];
    for (int i = 0; i < s->model->states.n_signal; i++)
        *to++ = lw_forces_signal(lw_dynamics_forces(s->d), i, m->t, m->q, m->v);
    *to++ = m->kinetic;
    *to++ = m->potential;
    if (elastic)
        *to++ = lw_forces_strain(lw_dynamics_forces(s->d), m->q);
    *to++ = m->work;
    *to++ = m->off;
    *to++ = m->off_rate;
    for (int c = 0; c < s->n_column; c++)
        row[c] *= s->column[c].scale;
}

static lw_status grow(cli_simulate *s)
{
    size_t n_q = (size_t)lw_dynamics_system(s->d)->n_q, capacity = s->capacity ? 2*s->capacity : 256;
    double *row = realloc(s->row, capacity*(size_t)s->n_column*sizeof *row);
    if (row)
        s->row = row;
    double *q = realloc(s->q, capacity*n_q*sizeof *q);
    if (q)
        s->q = q;
    s->capacity = row && q ? capacity : s->capacity;
    return row && q ? LW_OK : LW_E_MEMORY;
}

lw_status cli_simulate_row(void *context, const lw_moment *m)
{
    cli_simulate *s = context;
    double *row = s->scratch;
    size_t n = (size_t)s->n_column, n_q = (size_t)lw_dynamics_system(s->d)->n_q;
    fill(s, m, row);
    cli_suction_see(&s->suction, &s->model->states, m->z, m->t);
    if (s->keep) {
        if (s->n_row == s->capacity && grow(s) != LW_OK)
            return LW_E_MEMORY;
        memcpy(s->row + s->n_row*n, row, n*sizeof *row);
        memcpy(s->q + s->n_row*n_q, m->q, n_q*sizeof *m->q);
    }
    s->n_row++;
    if (!s->f)
        return LW_OK;
    if (s->json) {
        cli_json_reals(&s->j, NULL, row, n);
        return LW_OK;
    }
    for (size_t c = 0; c < n; c++) {
        char text[LW_NUMBER_SIZE];
        lw_number_print(row[c], text);
        fprintf(s->f, "%s%s", c ? "," : "", isfinite(row[c]) ? text : "");
    }
    fputc('\n', s->f);
    return ferror(s->f) ? LW_E_IO : LW_OK;
}

/* ---- head, tail, report --------------------------------------------------------------------------------- */

/* " A B", the inputs that start at rest because their speed is not given. */
static void name_inputs_at_rest(const cli_simulate *s, char *text, size_t size)
{
    const lw_assembly *k = &lw_dynamics_model(s->d)->linkage;
    size_t used = 0;
    *text = '\0';
    for (int i = 0; i < lw_dynamics_system(s->d)->n_input && used < size; i++)
        if (lw_dynamics_starts_at_rest(s->d, i))
            used += (size_t)snprintf(text + used, size - used, " %s", k->joint[k->input[i].joint].name);
}

void cli_simulate_head(cli_simulate *s)
{
    if (!s->f)
        return;
    if (s->json) {
        s->j = cli_columns_json(s->f, s->call, s->column, s->n_column);
        return;
    }
    char text[1024];
    name_inputs_at_rest(s, text, sizeof text);
    if (text[0])
        fprintf(s->f, "# assumed: inputs without a speed start at rest:%s\n", text);
    cli_columns_print(s->f, s->column, s->n_column);
}

void cli_simulate_tail(cli_simulate *s, lw_status status, const lw_error *e)
{
    if (!s->f)
        return;
    if (s->json)
        cli_dynamics_tail(&s->j, s->d, &s->report, status, e);
    else
        cli_dynamics_remarks(s->f, &s->report, status, e);
}

void cli_simulate_free(cli_simulate *s)
{
    lw_dynamics_free(s->d);
    cli_free_model(s->model);
    free(s->row);
    free(s->q);
    free(s->column);
    free(s->scratch);
    free(s->inner);
}
