/* Rows of a trace: one line per tracer in CSV, one list per posture in JSON. */
#include "cli/motion/trace_rows.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/number.h"
#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/program/output.h"
#include "mbs/kinematics/instant.h"
#include "mbs/kinematics/point_path.h"

#define COLUMNS "x,y,vx,vy,ax,ay,jx,jy,angle,angle_v,angle_a,angle_j"
#define GEOMETRY ",curvature,pole_x,pole_y,pole_u,pole_v,inflection_x,inflection_y"

void cli_row_values(const cli_rows *r, const lw_vec2 *p, const double *a, double angle, double *value)
{
    double length = r->k.units.metre;
    for (int order = 0; order <= CLI_ROW_ORDER; order++) {
        value[2*order]     = p[order].x/length;
        value[2*order + 1] = p[order].y/length;
        value[8 + order]   = order ? a[order] : angle/r->k.units.radian;
    }
    double *g = value + CLI_ROW_VALUES, speed = lw_v2_norm(p[1]);
    lw_instant_motion m = lw_instant_motion_at(p, a);
    lw_vec2 own = lw_v2_turn(lw_v2_sub(m.centre, p[0]), lw_v2_polar(1, -angle));
    g[0] = speed > 0 ? lw_v2_cross(p[1], p[2])/(speed*speed*speed)*length : NAN;
    g[1] = m.centre.x/length;
    g[2] = m.centre.y/length;
    g[3] = own.x/length;
    g[4] = own.y/length;
    g[5] = m.inflection.x/length;
    g[6] = m.inflection.y/length;
}

const char *cli_input_unit(const lw_assembly *k, int input)
{
    const char *length = k->units.length[0] ? k->units.length : "length";
    return cli_input_slides(k, input) ? length : k->units.angle;
}

void cli_time_columns(const lw_assembly *k, bool units, char *text, size_t size)
{
    size_t n = (size_t)snprintf(text, size, units ? "time s" : "time");
    for (int i = 0; i < k->n_input && n < size; i++) {
        char number[16] = "";
        if (i > 0)
            snprintf(number, sizeof number, "_%d", i + 1);
        n += (size_t)snprintf(text + n, size - n, units ? "; input%s %s" : ",input%s", number, cli_input_unit(k, i));
    }
}

static const char *columns(const cli_rows *r) { return r->geometry ? COLUMNS GEOMETRY : COLUMNS; }

static int n_value(const cli_rows *r) { return r->geometry ? CLI_ROW_MOST : CLI_ROW_VALUES; }

static bool is_rate(int value) { return value >= 2 && value != 8; }

void cli_row_number(FILE *f, double v)
{
    char text[LW_NUMBER_SIZE];
    lw_number_print(v + 0.0, text);                       /* -0 is 0 */
    fputs(text, f);
}

void cli_rows_units(const cli_rows *r, const char *lead, const char *by)
{
    const char *length = r->k.units.length[0] ? r->k.units.length : "length";
    if (r->kept) {
        size_t word = strcspn(lead, " ;"), unit = lead[word] == ' ' ? strcspn(lead + word + 1, " ;") : 0;
        snprintf(r->kept->lead, sizeof r->kept->lead, "%.*s [%.*s]", (int)word, lead, (int)unit, lead + word + 1);
        snprintf(r->kept->by, sizeof r->kept->by, "%s", by);
    }
    fprintf(r->f, "# units: %s; x y %s; v a j %s/%s %s/%s^2 %s/%s^3; angle %s; angle_v _a _j "
            "rad/%s rad/%s^2 rad/%s^3", lead, length, length, by, length, by, length, by, r->k.units.angle, by, by, by);
    if (r->geometry)
        fprintf(r->f, "; curvature 1/%s; pole inflection %s", length, length);
    fputc('\n', r->f);
}

static void json_head(const cli_rows *r, const char *lead)
{
    char name[LW_NAME_SIZE + 32];
    cli_json_array(r->json, "columns");
    for (const char *c = lead; *c; c += strcspn(c, ","), c += *c == ',') {
        snprintf(name, sizeof name, "%.*s", (int)strcspn(c, ","), c);
        cli_json_text(r->json, NULL, name);
    }
    for (int k = 0; k < r->k.n_tracer; k++)
        for (const char *c = columns(r); *c && cli_rows_want(r, k); c += strcspn(c, ","), c += *c == ',') {
            snprintf(name, sizeof name, "%s.%.*s", r->k.tracer[k].name, (int)strcspn(c, ","), c);
            cli_json_text(r->json, NULL, name);
        }
    cli_json_end(r->json);
}

static bool several(const cli_rows *r) { return cli_rows_tracers(r) > 1; }

void cli_rows_head(const cli_rows *r, const char *lead)
{
    if (r->kept && !r->kept->lead[0]) {                    /* JSON says the units elsewhere */
        snprintf(r->kept->lead, sizeof r->kept->lead, "%.*s", (int)strcspn(lead, ","), lead);
        snprintf(r->kept->by, sizeof r->kept->by, "unit");
    }
    if (r->json)
        json_head(r, lead);
    else
        fprintf(r->f, "arc,mode,%s,%s%s\n", lead, several(r) ? "tracer," : "", columns(r));
}

static void put_json(cli_rows *r, const cli_row *row)
{
    double *flat = malloc(((size_t)row->n_lead + (size_t)r->k.n_tracer*CLI_ROW_MOST + 1)*sizeof *flat);
    size_t n = 0;
    if (!flat) {
        cli_lost();
        return;
    }
    for (int i = 0; i < row->n_lead; i++)
        flat[n++] = row->lead[i] + 0.0;
    for (int k = 0; k < r->k.n_tracer; k++)
        for (int v = 0; v < n_value(r) && cli_rows_want(r, k); v++)
            flat[n++] = row->rates || !is_rate(v) ? row->value[k][v] + 0.0 : NAN;
    cli_json_reals(r->json, NULL, flat, n);
    free(flat);
}

static void put_csv(cli_rows *r, const cli_row *row)
{
    for (int k = 0; k < r->k.n_tracer; k++) {
        if (!cli_rows_want(r, k))
            continue;
        fprintf(r->f, "%d,%s", row->arc, row->mode);
        for (int i = 0; i < row->n_lead; i++) {
            fputc(',', r->f);
            cli_row_number(r->f, row->lead[i]);
        }
        if (several(r))
            fputc(',', r->f), cli_csv_text(r->f, r->k.tracer[k].name);
        for (int v = 0; v < n_value(r); v++) {
            fputc(',', r->f);
            if ((row->rates || !is_rate(v)) && isfinite(row->value[k][v]))
                cli_row_number(r->f, row->value[k][v]);
        }
        fputc('\n', r->f);
    }
}

static double *new_row(cli_kept *kept)
{
    if (kept->n == kept->capacity) {
        size_t capacity = 2*kept->capacity + 1024;
        double *grown = realloc(kept->row, capacity*(size_t)kept->width*sizeof *grown);
        kept->failed = kept->failed || !grown;
        if (!grown)
            return NULL;
        kept->row = grown;
        kept->capacity = capacity;
    }
    return kept->row + kept->n++*(size_t)kept->width;
}

static void keep(cli_rows *r, const cli_row *row)
{
    cli_kept *kept = r->kept;
    if (kept->only && kept->only != row->arc)
        return;
    kept->width = 1 + n_value(r)*cli_rows_tracers(r);
    for (int gap = kept->arc != row->arc && kept->n; gap >= 0; gap--) {
        double *to = new_row(kept);
        if (!to)
            return;
        int n = 0;
        to[n++] = gap ? NAN : row->lead[0];
        for (int k = 0; k < r->k.n_tracer; k++)
            for (int v = 0; v < n_value(r) && cli_rows_want(r, k); v++)
                to[n++] = gap || (is_rate(v) && !row->rates) ? NAN : row->value[k][v];
    }
    kept->arc = row->arc;
}

lw_status cli_rows_plot(const cli_rows *r, const char *path, lw_error *e)
{
    enum { LINES = 8, PANELS = 5 };
    static const char *const part[PANELS][2] = { { "x", "y" }, { "vx", "vy" }, { "ax", "ay" }, { "curvature", NULL },
                                                 { "pole_x", "pole_y" } };
    static const int first[PANELS] = { 0, 2, 4, CLI_ROW_VALUES, CLI_ROW_VALUES + 1 };
    int panels = r->geometry ? PANELS : 3;
    const cli_kept *kept = r->kept;
    const char *length = r->k.units.length[0] ? r->k.units.length : "length";
    int tracers = cli_rows_tracers(r), n_line = 2*tracers;
    if (kept->failed)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (n_line > LINES)
        return lw_error_set(e, LW_E_ARG, "%d tracers are too many lines for one plot; --tracer NAME draws one", tracers);
    double *y = malloc((size_t)(1 + (PANELS + 1)*n_line)*(kept->n + 1)*sizeof *y);
    char name[PANELS][LINES][LW_NAME_SIZE + 8], label[PANELS][64];
    lw_series series[PANELS][LINES];
    lw_plot plot[PANELS];
    if (!y)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double middle[2], reach = 0;
    for (size_t i = 0; i < kept->n; i++)
        y[i] = kept->row[i*(size_t)kept->width];
    for (int c = 0; c < 2; c++) {
        double least = INFINITY, most = -INFINITY;
        for (size_t i = 0; i < kept->n; i++) {
            least = fmin(least, kept->row[i*(size_t)kept->width + (size_t)(1 + c)]);
            most = fmax(most, kept->row[i*(size_t)kept->width + (size_t)(1 + c)]);
        }
        middle[c] = 0.5*(least + most);
        reach = fmax(reach, most - least);
    }
    for (int k = 0, t = 0; k < r->k.n_tracer; k++) {
        for (int panel = 0; panel < panels && cli_rows_want(r, k); panel++)
            for (int c = 0; c < 2 && part[panel][c]; c++) {
                int line = 2*t + c;
                double *to = y + (size_t)(1 + panel*n_line + line)*kept->n, *x = y;
                for (size_t i = 0; i < kept->n; i++)
                    to[i] = kept->row[i*(size_t)kept->width + (size_t)(1 + t*n_value(r) + first[panel] + c)];
                if (first[panel] > CLI_ROW_VALUES) {            /* it runs off to infinity: gaps in its line */
                    x = y + (size_t)(1 + PANELS*n_line + line)*kept->n;
                    for (size_t i = 0; i < kept->n; i++)
                        x[i] = fabs(to[i] - middle[c]) < 3*reach ? y[i] : NAN;
                }
                snprintf(name[panel][line], sizeof name[panel][line], "%s.%s", r->k.tracer[k].name, part[panel][c]);
                series[panel][part[panel][1] ? line : t] = (lw_series){ .name = name[panel][line], .n = kept->n, .x = x, .y = to };
            }
        t += cli_rows_want(r, k);
    }
    snprintf(label[0], sizeof label[0], "place [%s]", length);
    snprintf(label[1], sizeof label[1], "velocity [%s/%s]", length, kept->by);
    snprintf(label[2], sizeof label[2], "acceleration [%s/%s^2]", length, kept->by);
    snprintf(label[3], sizeof label[3], "curvature [1/%s]", length);
    snprintf(label[4], sizeof label[4], "instant centre [%s]", length);
    for (int panel = 0; panel < panels; panel++)
        plot[panel] = (lw_plot){ .title = panel ? NULL : r->k.name, .y_label = label[panel],
                                 .n_series = part[panel][1] ? n_line : tracers,
                                 .series = series[panel], .x_label = panel == panels - 1 ? kept->lead : NULL,
                                 .height = 260*panels };
    lw_status s = lw_draw_plots(panels, plot, path, e);
    free(y);
    return s;
}

/* Rows of this arc for its double points: input, then x and y of each printed tracer. */
static void keep_path(cli_rows *r, const cli_row *row)
{
    size_t width = 1 + 2*(size_t)cli_rows_tracers(r), n = 0;
    if (r->n_path == r->room) {
        size_t room = 2*r->room + 512;
        double *grown = realloc(r->path, room*width*sizeof *grown);
        if (!grown) {
            cli_lost();
            return;
        }
        r->path = grown;
        r->room = room;
    }
    double *to = r->path + r->n_path++*width;
    to[n++] = row->lead[0];
    for (int k = 0; k < r->k.n_tracer; k++)
        for (int v = 0; v < 2 && cli_rows_want(r, k); v++)
            to[n++] = row->value[k][v];
}

static double input_at(const double *input, size_t n, double step)
{
    size_t i = (size_t)fmin(fmax(floor(step), 0), (double)n - 2);
    return input[i] + (step - (double)i)*(input[i + 1] - input[i]);
}

static void put_double(cli_rows *r, int arc, const char *name, const lw_double_point *d, const double *input, size_t n)
{
    const double v[4] = { d->at.x, d->at.y, input_at(input, n, d->first), input_at(input, n, d->second) };
    if (r->json) {
        cli_json_object(r->json, NULL);
        cli_json_text(r->json, "tracer", name);
        cli_json_reals(r->json, "at", v, 2);
        cli_json_reals(r->json, "inputs", v + 2, 2);
        cli_json_end(r->json);
    } else
        fprintf(r->f, "# double point of arc %d: %s at %.10g, %.10g, inputs %.10g and %.10g\n", arc, name, v[0], v[1], v[2], v[3]);
}

void cli_rows_arc_end(cli_rows *r, int arc)
{
    enum { MOST = 64 };
    lw_double_point found[MOST];
    size_t n = r->n_path, width = 1 + 2*(size_t)cli_rows_tracers(r), column = 1;
    if (!r->geometry)
        return;
    double *line = malloc(3*(n + 1)*sizeof *line);             /* input, x, y */
    if (!line)
        cli_lost();
    if (r->json)
        cli_json_array(r->json, "double_points");
    for (int k = 0; k < r->k.n_tracer && line && n > 1; k++) {
        if (!cli_rows_want(r, k))
            continue;
        for (size_t i = 0; i < n; i++) {
            line[i] = r->path[i*width];
            line[n + i] = r->path[i*width + column];
            line[2*n + i] = r->path[i*width + column + 1];
        }
        int all = lw_point_path_doubles(n, line + n, line + 2*n, found, MOST);
        for (int d = 0; d < all; d++)
            put_double(r, arc, r->k.tracer[k].name, &found[d], line, n);
        column += 2;
    }
    if (r->json)
        cli_json_end(r->json);
    free(line);
    free(r->path);
    r->path = NULL;
    r->n_path = r->room = 0;
}

void cli_rows_put(cli_rows *r, const cli_row *row)
{
    if (r->geometry)
        keep_path(r, row);
    if (r->kept)
        keep(r, row);
    if (r->json)
        put_json(r, row);
    else
        put_csv(r, row);
    r->done++;
}

bool cli_rows_stopped(cli_rows *r)
{
    cli_progress_show(r->progress, r->done, r->total, NULL);
    if (*r->stop || (r->until > 0 && lw_clock_wall() > r->until))
        r->cut_short = true;
    return r->cut_short;
}
