/* Rows of a trace: one line per tracer in CSV, one list per pose in JSON. */
#include "cli/motion/trace_rows.h"

#include <string.h>
#include "base/clock.h"
#include "base/number.h"

#define COLUMNS "x,y,vx,vy,ax,ay,jx,jy,angle,angle_v,angle_a,angle_j"

void cli_row_values(const cli_rows *r, const lw_vec2 *p, const double *a, double angle, double *value)
{
    double length = r->k->units.metre;
    for (int order = 0; order <= CLI_ROW_ORDER; order++) {
        value[2*order]     = p[order].x/length;
        value[2*order + 1] = p[order].y/length;
        value[8 + order]   = order ? a[order] : angle/r->k->units.radian;
    }
}

static bool is_rate(int value) { return value >= 2 && value != 8; }

static bool wanted(const cli_rows *r, int tracer) { return r->tracers >> tracer & 1; }

void cli_row_number(FILE *f, double v)
{
    char text[LW_NUMBER_SIZE];
    lw_number_print(v + 0.0, text);                       /* -0 is 0 */
    fputs(text, f);
}

void cli_rows_units(const cli_rows *r, const char *lead, const char *by)
{
    const char *length = r->k->units.length[0] ? r->k->units.length : "length";
    fprintf(r->f, "# units: %s; x y %s; v a j %s/%s %s/%s^2 %s/%s^3; angle %s; angle_v _a _j "
            "rad/%s rad/%s^2 rad/%s^3\n", lead, length, length, by, length, by, length, by, r->k->units.angle, by, by,
            by);
}

static void json_head(const cli_rows *r, const char *lead)
{
    char name[LW_NAME_SIZE + 32];
    cli_json_array(r->json, "columns");
    for (const char *c = lead; *c; c += strcspn(c, ","), c += *c == ',') {
        snprintf(name, sizeof name, "%.*s", (int)strcspn(c, ","), c);
        cli_json_text(r->json, NULL, name);
    }
    for (int k = 0; k < r->k->n_tracer; k++)
        for (const char *c = COLUMNS; *c && wanted(r, k); c += strcspn(c, ","), c += *c == ',') {
            snprintf(name, sizeof name, "%s.%.*s", r->k->tracer[k].name, (int)strcspn(c, ","), c);
            cli_json_text(r->json, NULL, name);
        }
    cli_json_end(r->json);
}

static bool several(const cli_rows *r) { return __builtin_popcount(r->tracers) > 1; }

void cli_rows_head(const cli_rows *r, const char *lead)
{
    if (r->json)
        json_head(r, lead);
    else
        fprintf(r->f, "arc,mode,%s,%s" COLUMNS "\n", lead, several(r) ? "tracer," : "");
}

static void put_json(cli_rows *r, const cli_row *row)
{
    double flat[CLI_ROW_LEAD + LW_TRACER_MAX*CLI_ROW_VALUES];
    size_t n = 0;
    for (int i = 0; i < row->n_lead; i++)
        flat[n++] = row->lead[i] + 0.0;
    for (int k = 0; k < r->k->n_tracer; k++)
        for (int v = 0; v < CLI_ROW_VALUES && wanted(r, k); v++)
            flat[n++] = row->rates || !is_rate(v) ? row->value[k][v] + 0.0 : NAN;
    cli_json_reals(r->json, NULL, flat, n);
}

static void put_csv(cli_rows *r, const cli_row *row)
{
    for (int k = 0; k < r->k->n_tracer; k++) {
        if (!wanted(r, k))
            continue;
        fprintf(r->f, "%d,%s", row->arc, row->mode);
        for (int i = 0; i < row->n_lead; i++) {
            fputc(',', r->f);
            cli_row_number(r->f, row->lead[i]);
        }
        if (several(r))
            fprintf(r->f, ",%s", r->k->tracer[k].name);
        for (int v = 0; v < CLI_ROW_VALUES; v++) {
            fputc(',', r->f);
            if (row->rates || !is_rate(v))
                cli_row_number(r->f, row->value[k][v]);
        }
        fputc('\n', r->f);
    }
}

void cli_rows_put(cli_rows *r, const cli_row *row)
{
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
