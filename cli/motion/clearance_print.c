/* cli/motion/clearance_print.c - print and plot a sweep, or one run in full. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/clearance.h"
#include "cli/program/json.h"
#include "mbs/elastic/contact.h"

static const char *joint_name(const cli_clearance *c, int joint) { return c->model->linkage.joint[joint].name; }

/* Print a number, or nothing if it is not finite. */
static void cell(FILE *f, double v)
{
    fputc(',', f);
    if (isfinite(v))
        fprintf(f, "%.10g", v);
}

/* ---- tables -------------------------------------------------------------------------------------- */

static const char *contact_word(const lw_sweep_row *r, int joint)
{
    return r->status != LW_OK ? "failed" : r->r.joint[joint].lost ? "lost" : "kept";
}

void cli_clearance_csv(const cli_clearance *c, FILE *f)
{
    fprintf(f, "# %s\n# speed of the input at the start [%s], times [s], forces [N], distances of the centres [m], "
            "criterion [rad/(N s)]\n", c->call->line, c->unit);
    fputs("joint,model,stiffness,damping,speed,contact,first_loss,losses,apart,force_most,distance_most,criterion,"
          "speed_least,speed_most,energy_first,energy_last,steps\n", f);
    for (int i = 0; i < c->sweep.n_row; i++) {
        const lw_sweep_row *r = &c->sweep.row[i];
        const lw_sweep_law *l = &c->sweep.law[r->law];
        for (int j = 0; r->done && j < r->r.n_joint; j++) {
            const lw_clearance_outcome *o = &r->r.joint[j];
            cli_csv_text(f, joint_name(c, o->joint));
            fprintf(f, ",%s", lw_clearance_name(l->model));
            cell(f, l->stiffness), cell(f, l->damping), cell(f, r->speed);
            fprintf(f, ",%s", contact_word(r, j));
            cell(f, o->first);
            fprintf(f, ",%ld", o->losses);
            cell(f, o->apart), cell(f, o->force_most), cell(f, o->distance_most), cell(f, o->criterion);
            cell(f, r->r.speed_least/c->o.unit), cell(f, r->r.speed_most/c->o.unit);
            cell(f, r->r.energy_first), cell(f, r->r.energy_last);
            fprintf(f, ",%ld\n", r->r.steps);
        }
    }
}

static void interval(FILE *f, double from, double to)
{
    char t[64] = "-";
    if (!isnan(from))
        snprintf(t, sizeof t, "%.6g - %.6g", from, to);
    fprintf(f, "  %-19s", t);
}

void cli_clearance_limits(const cli_clearance *c, FILE *f)
{
    fprintf(f, "%-10s %-20s %10s %10s  %-19s  %-19s  %s\n", "joint", "model", "K [N/m]", "c [N s/m]", "kept - lost", "lost - kept", "lost");
    for (int i = 0; i < c->sweep.n_limit; i++) {
        const lw_sweep_limit *l = &c->sweep.limit[i];
        const lw_sweep_law *law = &c->sweep.law[l->law];
        const char *name = "";
        for (int r = 0; r < c->sweep.n_row; r++)
            if (c->sweep.row[r].done)
                name = joint_name(c, c->sweep.row[r].r.joint[l->joint].joint);
        fprintf(f, "%-10s %-20s %10.4g %10.4g", name, lw_clearance_name(law->model), law->stiffness, law->damping);
        interval(f, l->kept, l->lost);
        interval(f, l->lost_again, l->kept_again);
        fprintf(f, "  %d of %d\n", l->n_lost, l->n);
    }
}

static void json_joint(cli_json *j, const cli_clearance *c, const lw_sweep_row *r, int k)
{
    const lw_clearance_outcome *o = &r->r.joint[k];
    cli_json_object(j, NULL);
    cli_json_text(j, "joint", joint_name(c, o->joint));
    cli_json_text(j, "contact", contact_word(r, k));
    cli_json_real(j, "first_loss", o->first);
    cli_json_int(j, "losses", o->losses);
    cli_json_real(j, "apart", o->apart);
    cli_json_real(j, "force_most", o->force_most);
    cli_json_real(j, "distance_most", o->distance_most);
    cli_json_real(j, "criterion", o->criterion);
    cli_json_end(j);
}

static void json_run(cli_json *j, const cli_clearance *c, const lw_sweep_row *r)
{
    const lw_sweep_law *l = &c->sweep.law[r->law];
    cli_json_object(j, NULL);
    cli_json_text(j, "model", lw_clearance_name(l->model));
    cli_json_real(j, "stiffness", l->stiffness);
    cli_json_real(j, "damping", l->damping);
    cli_json_real(j, "speed", r->speed);
    cli_json_text(j, "status", lw_status_name(r->status));
    if (r->why[0])
        cli_json_text(j, "why", r->why);
    cli_json_real(j, "speed_least", r->r.speed_least/c->o.unit);
    cli_json_real(j, "speed_most", r->r.speed_most/c->o.unit);
    cli_json_real(j, "energy_first", r->r.energy_first);
    cli_json_real(j, "energy_last", r->r.energy_last);
    cli_json_int(j, "steps", r->r.steps);
    cli_json_array(j, "joints");
    for (int k = 0; k < r->r.n_joint; k++)
        json_joint(j, c, r, k);
    cli_json_end(j);
    cli_json_end(j);
}

void cli_clearance_json(const cli_clearance *c, FILE *f)
{
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "command", c->call->line);
    cli_json_text(&j, "speed_unit", c->unit);
    cli_json_array(&j, "runs");
    for (int i = 0; i < c->sweep.n_row; i++)
        if (c->sweep.row[i].done)
            json_run(&j, c, &c->sweep.row[i]);
    cli_json_end(&j);
    cli_json_array(&j, "limits");
    for (int i = 0; i < c->sweep.n_limit; i++) {
        const lw_sweep_limit *l = &c->sweep.limit[i];
        cli_json_object(&j, NULL);
        cli_json_text(&j, "model", lw_clearance_name(c->sweep.law[l->law].model));
        cli_json_real(&j, "stiffness", c->sweep.law[l->law].stiffness);
        cli_json_real(&j, "damping", c->sweep.law[l->law].damping);
        cli_json_int(&j, "joint", l->joint);
        cli_json_reals(&j, "kept_lost", (double[]){ l->kept, l->lost }, 2);
        cli_json_reals(&j, "lost_kept", (double[]){ l->lost_again, l->kept_again }, 2);
        cli_json_int(&j, "lost", l->n_lost);
        cli_json_int(&j, "of", l->n);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_end(&j);
}

/* ---- pictures ------------------------------------------------------------------------------------ */

lw_status cli_clearance_plot(const cli_clearance *c, const char *path, lw_error *e)
{
    lw_series series[LW_SERIES_MAX];
    char name[LW_SERIES_MAX][64], label[64];
    int n_series = 0;
    double *numbers = malloc(sizeof *numbers*(4*(size_t)c->sweep.n_row + 1)), *p = numbers;
    if (!numbers)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (lw_clearance_model m = LW_CLEARANCE_ZERO; m <= LW_CLEARANCE_LANKARANI; m++)
        for (int lost = 0; lost < 2; lost++) {
            size_t n = 0;
            double *x = p, *y = p + c->sweep.n_row;
            for (int i = 0; i < c->sweep.n_row; i++) {
                const lw_sweep_row *r = &c->sweep.row[i];
                bool any = false;
                for (int j = 0; j < r->r.n_joint; j++)
                    any = any || r->r.joint[j].lost;
                if (!r->done || r->status != LW_OK || c->sweep.law[r->law].model != m || any != (bool)lost)
                    continue;
                x[n] = r->speed;
                y[n++] = c->sweep.law[r->law].stiffness;
            }
            if (n == 0)
                continue;
            memmove(x + n, y, sizeof *y*n);
            snprintf(name[n_series], sizeof name[n_series], "%s, %s", lw_clearance_name(m), lost ? "lost" : "kept");
            series[n_series] = (lw_series){ name[n_series], n, x, x + n, LW_SERIES_POINTS };
            p += 2*n;
            n_series++;
        }
    snprintf(label, sizeof label, "speed of the input at the start [%s]", c->unit);
    lw_plot plot = { .title = "Contact", .x_label = label, .y_label = "stiffness of the contact [N/m]", .log_y = true,
                     .n_series = n_series, .series = series };
    lw_status s = lw_draw_plot(&plot, path, e);
    free(numbers);
    return s == LW_NOTHING ? LW_OK : s;
}

/* Collect the points of one contact law, in contact or not. x holds two numbers per point. Returns the number of
 * points. */
static size_t passes_of(const cli_clearance *c, int law, bool touching, double *x)
{
    size_t n = 0;
    for (int pass = 0; pass < 2; pass++) {
        double *y = x + n;
        n = 0;
        for (int i = 0; i < c->sweep.n_row; i++) {
            const lw_sweep_row *r = &c->sweep.row[i];
            for (int k = 0; r->law == law && r->done && r->status == LW_OK && k < r->n_pass; k++)
                if (r->pass[k].touching == touching)
                    (pass ? y : x)[n++] = pass ? r->pass[k].direction : r->speed;
        }
    }
    return n;
}

lw_status cli_clearance_passes(const cli_clearance *c, const char *path, lw_error *e)
{
    lw_series series[LW_SERIES_MAX];
    char name[LW_SERIES_MAX][64], label[64];
    size_t n_number = 1;
    int n_series = 0;
    if (2*c->sweep.n_law > LW_SERIES_MAX)
        return lw_error_set(e, LW_E_ARG, "--passes shows %d laws at most, the lists make %d", LW_SERIES_MAX/2, c->sweep.n_law);
    for (int i = 0; i < c->sweep.n_row; i++)
        n_number += 2*(size_t)c->sweep.row[i].n_pass;
    double *x = malloc(n_number*sizeof *x), *p = x;
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int law = 0; law < c->sweep.n_law; law++)
        for (int apart = 0; apart < 2; apart++) {
            size_t n = passes_of(c, law, !apart, p);
            if (n == 0)
                continue;
            snprintf(name[n_series], sizeof name[n_series], "%s %.3g, %s", lw_clearance_name(c->sweep.law[law].model),
                     c->sweep.law[law].stiffness, apart ? "apart" : "touching");
            series[n_series] = (lw_series){ name[n_series], n, p, p + n, LW_SERIES_POINTS };
            n_series++;
            p += 2*n;
        }
    snprintf(label, sizeof label, "speed of the input at the start [%s]", c->unit);
    lw_plot plot = { .title = "Pin in its bush, each time the input passes its start", .x_label = label,
                     .y_label = "direction [deg]", .n_series = n_series, .series = series, .width = 1000,
                     .height = 560 };
    lw_status s = lw_draw_plot(&plot, path, e);
    free(x);
    return s == LW_NOTHING ? LW_OK : s;
}

typedef struct samples { lw_clearance_sample *s; size_t n, capacity; } samples;

static lw_status keep(void *context, const lw_clearance_sample *s)
{
    samples *l = context;
    if (cli_interrupted())
        return LW_STOPPED;
    if (l->n == l->capacity) {
        size_t capacity = 2*l->capacity + 1024;
        lw_clearance_sample *more = realloc(l->s, capacity*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        l->s = more;
        l->capacity = capacity;
    }
    l->s[l->n++] = *s;
    return LW_OK;
}

static lw_status write_history(const cli_clearance *c, const samples *l, const char *path, lw_error *e)
{
    lw_output o;
    lw_status s = lw_output_open(&o, path, e);
    if (s != LW_OK)
        return s;
    fprintf(o.f, "# %s\n# t [s], input [rad or m], pin from bush in the bush's frame [m], force > 0 presses [N], "
            "energy [J]\nt,input,input_rate,energy", c->call->line);
    for (int j = 0; l->n && j < l->s[0].n_point; j++) {
        const char *name = joint_name(c, l->s[0].point[j].joint);
        fprintf(o.f, ",x(%s),y(%s),force(%s),touching(%s)", name, name, name, name);
    }
    for (size_t i = 0; i < l->n; i++) {
        const lw_clearance_sample *p = &l->s[i];
        fprintf(o.f, "\n%.12g,%.12g,%.12g,%.12g", p->t, p->input, p->input_rate, p->energy);
        for (int j = 0; j < p->n_point; j++)
            fprintf(o.f, ",%.12g,%.12g,%.12g,%d", p->point[j].in_bush.x, p->point[j].in_bush.y, p->point[j].force, p->point[j].touching);
    }
    fputc('\n', o.f);
    return lw_output_commit(&o, e);
}

/* Plot the path of the pin in its bush: while it settles, afterwards, and the circle of contact [um]. */
static lw_status draw_path(const cli_clearance *c, const samples *l, const char *path, lw_error *e)
{
    enum { ROUND = 361 };
    double *x = malloc(sizeof *x*(2*l->n + 2*ROUND)), *y = x + l->n + ROUND;
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    size_t settled = 0;
    double gap = l->n ? c->sweep.law[0].m->clearance[l->s[0].point[0].joint].gap*1e6 : 1;
    for (int i = 0; i < ROUND; i++) {
        x[i] = gap*cos(2*LW_PI*i/(ROUND - 1));
        y[i] = gap*sin(2*LW_PI*i/(ROUND - 1));
    }
    for (size_t i = 0; i < l->n; i++) {
        x[ROUND + i] = l->s[i].point[0].in_bush.x*1e6;
        y[ROUND + i] = l->s[i].point[0].in_bush.y*1e6;
        settled += l->s[i].t < c->o.run.settle;
    }
    lw_series series[] = { { "gap", ROUND, x, y, LW_SERIES_LINE },
                           { "settling", settled, x + ROUND, y + ROUND, LW_SERIES_LINE },
                           { "settled", l->n - settled, x + ROUND + settled, y + ROUND + settled, LW_SERIES_LINE } };
    char title[96];
    snprintf(title, sizeof title, "Centre of the pin in its bush at %g %s", c->speed[0], c->unit);
    lw_plot plot = { .title = title, .x_label = "x [um]", .y_label = "y [um]", .n_series = 3, .series = series,
                     .equal = true, .width = 700, .height = 620 };
    lw_status s = lw_draw_plot(&plot, path, e);
    free(x);
    return s == LW_NOTHING ? LW_OK : s;
}

static lw_status draw_force(const cli_clearance *c, const samples *l, const char *path, lw_error *e)
{
    double *t = malloc(sizeof *t*(2*l->n + 1)), *f = t + l->n;
    if (!t)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < l->n; i++) {
        t[i] = l->s[i].t;
        f[i] = l->s[i].point[0].force;
    }
    char title[96];
    snprintf(title, sizeof title, "Force in the joint at %g %s", c->speed[0], c->unit);
    lw_series series = { l->n ? joint_name(c, l->s[0].point[0].joint) : "", l->n, t, f, LW_SERIES_LINE };
    lw_plot plot = { .title = title, .x_label = "t [s]", .y_label = "force [N]", .n_series = 1, .series = &series,
                     .width = 900, .height = 420 };
    lw_status s = lw_draw_plot(&plot, path, e);
    free(t);
    return s == LW_NOTHING ? LW_OK : s;
}

lw_status cli_clearance_detail(cli_clearance *c, const char *history, const char *path, const char *force, lw_error *e)
{
    samples l = { 0 };
    lw_clearance_result r;
    lw_clearance_options o = c->o.run;
    o.speed = c->model->motion[0] ? NAN : c->speed[0]*c->o.unit;
    o.sink = keep, o.context = &l;
    o.every = o.every > 0 ? o.every : o.time/10000;
    lw_status s = lw_clearance_run(c->sweep.law[0].scene, &o, &r, e), run = s;
    if (l.n > 0)
        s = LW_OK;                                   /* a run that stopped early is written as far as it went */
    int code = cli_exit_code(run);
    char part[LW_PATH_SIZE + 16];
    const char *to;
    if (s == LW_OK && history && (to = cli_picture_path(c->call, history, code, part)))
        s = write_history(c, &l, to, e);
    if (s == LW_OK && path && (to = cli_picture_path(c->call, path, code, part)))
        s = draw_path(c, &l, to, e);
    if (s == LW_OK && force && (to = cli_picture_path(c->call, force, code, part)))
        s = draw_force(c, &l, to, e);
    free(l.s);
    return s == LW_OK ? run : s;
}
