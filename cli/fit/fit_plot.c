/* cli/fit/fit_plot.c - wanted and reached curves of results: the output over the input of a function, the path of a point. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/fit/fit.h"

#define SHOWN 7                        /* results; the eighth line is what is wanted */

typedef struct curves {
    int       n;
    lw_series series[SHOWN + 1];
    char      name[SHOWN][64];
    double   *numbers;                 /* x and y of all points in turn, owned */
    size_t    used, room;
} curves;

static bool add_point(curves *c, double x, double y)
{
    if (c->used + 2 > c->room) {
        size_t room = 2*c->room + 4096;
        double *more = realloc(c->numbers, room*sizeof *more);
        if (!more)
            return false;
        c->numbers = more;
        c->room = room;
    }
    c->numbers[c->used++] = x;
    c->numbers[c->used++] = y;
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

lw_status cli_fit_curves(const cli_fit_set *s, lw_drawing *d, lw_error *e)
{
    const lw_target *t = &s->target;
    const lw_units *u = &t->units;
    bool function = !lw_task_has_place(s->spec.task);
    char label[2][32], title[CLI_FIT_NAME_SIZE + 40];
    curves c = { 0 };
    lw_scene *scene = calloc(1, sizeof *scene);
    bool ok = scene && add_wanted(&c, t, function);
    lw_status st = LW_OK;
    for (int i = 0; i < s->search.results.n && i < SHOWN && ok && st == LW_OK; i++) {
        lw_scene_options o = lw_scene_options_default();
        o.n_frame = 720;
        const char *type = lw_family_title(cli_fit_candidate(s, i)->family);
        snprintf(c.name[i], sizeof c.name[i], "%d %.*s", i + 1, (int)strcspn(type, ","), type);
        st = lw_scene_make(&s->search.results.report[i].linkage, NULL, &o, scene, e);
        c.series[c.n++] = (lw_series){ .name = c.name[i] };
        ok = st != LW_OK || (function ? add_function(&c, scene, t, cli_fit_candidate(s, i)->intended.sense) : add_path(&c, scene, 1 + t->n_also));
        lw_scene_free(scene);
    }
    size_t room = c.used/2;
    double *y = malloc((room + 1)*sizeof *y);
    if (!ok || !y)
        st = lw_error_set(e, LW_E_MEMORY, "no memory for a plot");
    for (size_t i = 0; y && i < room; i++)                     /* pairs to rows: x in place, y apart */
        y[i] = c.numbers[2*i + 1], c.numbers[i] = c.numbers[2*i];
    for (size_t i = 0, at = 0; i < (size_t)c.n; at += c.series[i++].n)
        c.series[i].x = c.numbers + at, c.series[i].y = y + at;
    if (function)
        snprintf(label[0], sizeof label[0], "input angle [%s]", u->angle), snprintf(label[1], sizeof label[1], "output angle [%s]",
                                                                                 u->angle);
    else
        for (int k = 0; k < 2; k++)
            snprintf(label[k], sizeof label[k], "%c [%s]", "xy"[k], u->length[0] ? u->length : "units of the target");
    snprintf(title, sizeof title, "%s: wanted and reached", s->name);
    lw_plot plot = { .title = title, .x_label = label[0], .y_label = label[1], .n_series = c.n, .series = c.series, .equal = !function };
    if (st == LW_OK)
        st = lw_plot_draw(&plot, d, e);
    free(y);
    free(c.numbers);
    free(scene);
    return st < 0 ? st : LW_OK;
}
