#include "catalogues/pages/fit_page.h"

#include <stdlib.h>
#include <string.h>

#include "base/growable_array.h"
#include "base/number.h"
#include "base/real.h"
#include "catalogues/draw/plot.h"
#include "catalogues/pages/page.h"

#define NAME_SIZE 256                  /* of a target, in titles                       */

static const lw_candidate *candidate_of(const lw_fitted *f, int i)
{
    return &f->fit->candidate[f->results->candidate[i]];
}

/* ---- words ---------------------------------------------------------------------------------------- */

double lw_fitted_value(const lw_units *u, const lw_fit_report *r, int dim, double si)
{
    if (r->dim_kind[dim] != LW_DIM_ANGLE)
        return si/u->metre;
    bool frame = strcmp(r->dim_name[dim], "theta0") == 0 && r->input_turns_per_period == 1;
    return frame && fabs(si) > LW_PI ? remainder(si, 2*LW_PI) : si;
}

const char *lw_fitted_order(lw_task task)
{
    return lw_task_has_place(task)
         ? "the error, in percent of the target's diagonal, of a four-bar of the target's size with transmission angles of 45 degrees that is as good"
         : "the error, in percent of the output's swing (at least 57 degrees), of a four-bar with lengths within a factor of 4 and transmission "
           "angles of 45 degrees that is as good";
}

bool lw_fitted_near_change_point(const lw_fit_report *r)
{
    return lw_fit_report_may_change(r, LW_NEAR_CHANGE_POINT);
}

void lw_fitted_dimensions(const lw_fitted *f, int result, FILE *to)
{
    const lw_fit_report *r = &f->results->report[result];
    const lw_candidate *c = candidate_of(f, result);
    static const char *const place[] = { "cx", "cy", "x0", "y0", "theta0" };
    const bool has_place = lw_task_has_place(f->task);
    for (int d = 0; d < c->n_dim; d++) {           /* what no one can make is printed as 0 */
        double least = r->dim_kind[d] == LW_DIM_ANGLE ? 1e-9 : 1e-9*r->size;
        bool idle = false;
        for (size_t k = 0; k < sizeof place/sizeof *place && !has_place; k++)
            idle |= strcmp(r->dim_name[d], place[k]) == 0;
        if (!idle)
            fprintf(to, " %s=%.6g", r->dim_name[d], fabs(c->dim[d]) < least ? 0 : lw_fitted_value(&f->target->units, r, d, c->dim[d]));
    }
    const double turn = 2*LW_PI*r->input_turns_per_period, deg = 180/LW_PI;
    if (!has_place && lw_joint_slides(r->linkage.joint[r->linkage.input[0].joint].kind))
        fprintf(to, " input0=%.6g", c->input0/f->target->units.metre);
    else if (!has_place)
        fprintf(to, " input0=%.6g", remainder(r->input_turns_per_period*c->input0, turn)*deg);
    if (!has_place)
        fprintf(to, " tool0=%.6g", remainder(c->tool0, 2*LW_PI)*deg);
}

/* ---- the plot ------------------------------------------------------------------------------------- */

#define SHOWN 7                        /* results; the eighth line is what is wanted */

typedef struct curves {
    int       n;
    lw_series series[SHOWN + 1];
    char      name[SHOWN][64];
    lw_vec2  *point;                   /* of all series, owned */
    int       n_point, room;
} curves;

static bool add_point(curves *c, double x, double y)
{
    lw_vec2 *point = lw_array_grow(c->point, c->n_point, &c->room, sizeof *point);
    if (!point)
        return false;
    c->point = point;
    c->point[c->n_point++] = lw_v2(x, y);
    c->series[c->n - 1].n++;
    return true;
}

/* Output over input in the units of the target: outwards from the first station, both ways, up to a limit of the input or a
 * little past the other stations, of a closed target through a whole turn.  sense -1: the input falls while the angles of
 * the stations rise. */
static bool add_function(curves *c, const lw_scene *s, const lw_target *t, double sense)
{
    const lw_tracer *out = &s->linkage.tracer[0];
    double u = t->units.radian, first = t->angle[0], last = t->angle[t->n - 1], middle = (first + last)/2;
    double half = fmax(t->closed ? LW_PI : 0, 0.55*fabs(last - first));
    bool ok = true;
    for (int way = -1; way <= 1; way += 2) {
        double x = first, y = t->theta[0] + remainder(out->angle - t->theta[0], 2*LW_PI), input = s->input[s->first_frame], before = 0;
        lw_vec2 turn = lw_v2(1, 0);
        ok = ok && (way < 0 || add_point(c, NAN, NAN)) && add_point(c, x/u, y/u);
        for (size_t k = 1; k < s->n_frame && ok; k++) {
            size_t at = s->first_frame + (way > 0 ? k : s->n_frame - k);
            if (!s->loops && (way > 0 ? at >= s->n_frame : k > s->first_frame))
                break;
            at %= s->n_frame;
            lw_vec2 now = s->place[at*(size_t)s->linkage.n_link + (size_t)out->link].turn;
            double by = sense*remainder(s->input[at] - input, 2*LW_PI);
            if (by*before < 0)                               /* past a limit of the input */
                break;
            x += by;
            before = by;
            y += atan2(lw_v2_cross(turn, now), lw_v2_dot(turn, now));
            input = s->input[at];
            turn = now;
            if (fabs(x - middle) > half)
                break;
            ok = add_point(c, x/u, y/u);
        }
    }
    return ok;
}

static bool add_path(curves *c, const lw_scene *s, int n_point)
{
    double u = s->linkage.units.metre;
    bool ok = true;
    for (int i = 0; i < s->n_curve && ok; i++) {
        const lw_curve *v = &s->curve[i];
        if (!v->shown_branch || v->tracer >= n_point)
            continue;
        for (size_t k = 0; k < v->n + v->closed && ok; k++)
            ok = add_point(c, v->p[k % v->n].x/u, v->p[k % v->n].y/u);
        ok = ok && add_point(c, NAN, NAN);
    }
    return ok;
}

static bool add_wanted(curves *c, const lw_target *t, bool function)
{
    double u = function ? t->units.radian : t->units.metre;
    bool ok = true;
    c->series[c->n++] = (lw_series){ .name = "wanted", .style = LW_SERIES_POINTS };
    for (size_t i = 0; i < t->n && ok; i++)
        ok = function ? add_point(c, t->angle[i]/u, t->theta[i]/u) : add_point(c, t->x[i]/u, t->y[i]/u);
    for (int k = 0; k < t->n_also && !function; k++)
        for (size_t i = 0; i < t->n && ok && t->also[k].x; i++)
            ok = add_point(c, t->also[k].x[i]/u, t->also[k].y[i]/u);
    return ok;
}

lw_status lw_fitted_curves(const lw_fitted *f, lw_drawing *d, lw_error *e)
{
    const lw_target *t = f->target;
    const lw_units *u = &t->units;
    bool function = !lw_task_has_place(f->task);
    char label[2][32], title[NAME_SIZE + 40];
    curves c = { 0 };
    lw_scene *scene = calloc(1, sizeof *scene);
    bool ok = scene && add_wanted(&c, t, function);
    lw_status st = LW_OK;
    for (int i = 0; i < f->results->n && i < SHOWN && ok && st == LW_OK; i++) {
        lw_scene_options o = lw_scene_options_default();
        o.n_frame = 720;
        const char *type = lw_family_title(candidate_of(f, i)->family);
        snprintf(c.name[i], sizeof c.name[i], "%d %.*s", i + 1, (int)strcspn(type, ","), type);
        st = lw_scene_make(&f->results->report[i].linkage, NULL, &o, scene, e);
        c.series[c.n++] = (lw_series){ .name = c.name[i] };
        ok = st != LW_OK || (function ? add_function(&c, scene, t, candidate_of(f, i)->intended.sense) : add_path(&c, scene, 1 + t->n_also));
        lw_scene_free(scene);
    }
    double *x = malloc((2*(size_t)c.n_point + 1)*sizeof *x), *y = x ? x + c.n_point : NULL;
    if (!ok || !x)
        st = lw_error_set(e, LW_E_MEMORY, "no memory for a plot");
    for (int i = 0; x && i < c.n_point; i++)
        x[i] = c.point[i].x, y[i] = c.point[i].y;
    for (size_t i = 0, at = 0; x && i < (size_t)c.n; at += c.series[i++].n)
        c.series[i].x = x + at, c.series[i].y = y + at;
    if (function)
        snprintf(label[0], sizeof label[0], "input angle [%s]", u->angle), snprintf(label[1], sizeof label[1], "output angle [%s]",
                                                                                 u->angle);
    else
        for (int k = 0; k < 2; k++)
            snprintf(label[k], sizeof label[k], "%c [%s]", "xy"[k], u->length[0] ? u->length : "units of the target");
    snprintf(title, sizeof title, "%.*s: wanted and reached", NAME_SIZE, f->name);
    lw_plot plot = { .title = title, .x_label = label[0], .y_label = label[1], .n_series = c.n, .series = c.series, .equal = !function };
    if (st == LW_OK)
        st = lw_plot_draw(&plot, d, e);
    free(x);
    free(c.point);
    free(scene);
    return st < 0 ? st : LW_OK;
}

lw_status lw_fitted_scene(const lw_fitted *f, int i, lw_scene *scene, lw_error *e)
{
    char title[NAME_SIZE + 128];
    lw_scene_options o = lw_scene_options_default();
    const lw_candidate *c = candidate_of(f, i);
    snprintf(title, sizeof title, "%.*s: %s", NAME_SIZE, f->name, lw_family_title(c->family));
    o.title = title;
    return lw_scene_make(&f->results->report[i].linkage, f->target->x ? f->target : NULL, &o, scene, e);
}

/* ---- the page ------------------------------------------------------------------------------------ */

typedef struct sheet {
    lw_scene       *scene;                         /* one for each result, as the following            */
    lw_page_result *result;
    char          (*limits)[256], (*dimensions)[512];   /* "": those of the scene                              */
    lw_drawing     curves;                         /* wanted and reached                               */
    char          (*class_name)[128], (*file)[NAME_SIZE + 24], about[384];
    int             n;
} sheet;

/* Dimensions of a function as its table gives them. */
static lw_status write_dimensions(const lw_fitted *f, int i, sheet *h, lw_error *e)
{
    FILE *text = fmemopen(h->dimensions[i], sizeof h->dimensions[i], "w");
    if (!text)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a page");
    lw_fitted_dimensions(f, i, text);
    fprintf(text, "; the input is at input0 %c angle, the angle of the output's link plus tool0 is theta; angles in deg",
            candidate_of(f, i)->intended.sense < 0 ? '-' : '+');
    fclose(text);
    return LW_OK;
}

static void describe(const lw_fitted *f, int i, sheet *h)
{
    const lw_fit_report *r = &f->results->report[i];
    const lw_candidate *c = candidate_of(f, i);
    if (r->has_class)
        snprintf(h->class_name[i], sizeof h->class_name[i], "%s %s%s", r->barker.symbol, r->barker.name,
                 lw_fitted_near_change_point(r) ? ", near a change point" : "");
    snprintf(h->file[i], sizeof h->file[i], "%s-%d.json", f->name, i + 1);
    lw_fit_report_active(r, h->limits[i], sizeof h->limits[i]);
    size_t at = strlen(h->limits[i]);
    if (r->broken)
        snprintf(h->limits[i] + at, sizeof h->limits[i] - at, "%sbeyond: %s", at ? "; " : "", r->broken_text);
    h->result[i] = (lw_page_result){
        .dimensions = h->dimensions[i][0] ? h->dimensions[i] : NULL,
        .input = lw_fit_report_input(r), .limits = h->limits[i][0] ? h->limits[i] : NULL,
        .stray = lw_fit_report_stray(r), .size = f->target->extent > 0 ? r->size/f->target->extent : 0,
        .scene = &h->scene[i], .type = lw_family_title(c->family),
        .class_name = r->has_class ? h->class_name[i] : NULL, .linkage = &r->linkage, .file = h->file[i],
        .transmission_min = r->transmission_min, .objective = lw_fit_report_objective(c, r), .counts_as = isnan(r->counts_as) ? 0 : r->counts_as,
        .error_mean = r->error_mean, .error_max = r->error_max, .error_percent = r->error_percent,
        .angle_mean = r->angle_mean, .angle_max = r->angle_max
    };
}

static lw_status fill_sheet(const lw_fitted *f, sheet *h, lw_page_target *t, lw_error *e)
{
    size_t most = (size_t)f->results->n;
    lw_status st = LW_OK;
    h->scene = calloc(most, sizeof *h->scene);
    h->result = calloc(most, sizeof *h->result);
    h->class_name = calloc(most, sizeof *h->class_name);
    h->file = calloc(most, sizeof *h->file);
    h->limits = calloc(most, sizeof *h->limits);
    h->dimensions = calloc(most, sizeof *h->dimensions);
    if (!h->dimensions || !h->limits || !h->scene || !h->result || !h->class_name || !h->file)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a page");
    for (; h->n < f->results->n && st == LW_OK; h->n++) {
        st = lw_fitted_scene(f, h->n, &h->scene[h->n], e);
        if (st == LW_OK && !lw_task_has_place(f->task))
            st = write_dimensions(f, h->n, h, e);
        describe(f, h->n, h);
    }
    if (st == LW_OK)
        st = lw_fitted_curves(f, &h->curves, e);
    const bool ordered = f->results->n > 0 && !isnan(f->results->report[0].counts_as);
    snprintf(h->about, sizeof h->about, "%zu point%s, %s; %ld local fit%s in %.1f s.%s%s%s", f->target->n, lw_plural((long long)f->target->n),
             f->target->closed ? "closed" : "open", f->fit->improved, lw_plural(f->fit->improved), f->fit->seconds,
             ordered ? " Results are ordered by what they count as: " : "", ordered ? lw_fitted_order(f->task) : "", ordered ? "." : "");
    *t = (lw_page_target){ .name = f->name, .about = h->about, .n_result = h->n,
                           .result = h->result, .curves = st == LW_OK && !lw_task_has_place(f->task) ? &h->curves : NULL };
    return st;
}

lw_status lw_fitted_page(const lw_fitted *f, int n_fitted, const char *title, lw_bytes *out, lw_error *e)
{
    sheet *h = calloc((size_t)n_fitted + 1, sizeof *h);
    lw_page_target *t = calloc((size_t)n_fitted + 1, sizeof *t);
    int n = 0;
    lw_status st = h && t ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for a page");
    for (int i = 0; i < n_fitted && st == LW_OK; i++)
        if (f[i].results->n > 0) {
            st = fill_sheet(&f[i], &h[n], &t[n], e);
            n++;
        }
    lw_page page = { .title = title, .n_target = n, .target = t };
    if (st == LW_OK)
        st = lw_page_write(&page, out, e);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < h[i].n; k++)
            lw_scene_free(&h[i].scene[k]);
        free(h[i].scene);
        free(h[i].result);
        free(h[i].class_name);
        free(h[i].file);
        free(h[i].limits);
        free(h[i].dimensions);
        lw_drawing_free(&h[i].curves);
    }
    free(h);
    free(t);
    return st;
}
