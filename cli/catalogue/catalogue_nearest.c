/* linkwright catalogue nearest - find the curves of a catalogue that are most similar to a target. */
#include <stdlib.h>

#include "base/clock.h"
#include "base/real.h"
#include "catalogues/store/nearest.h"
#include "cli/catalogue/catalogue.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "mbs/plan/types.h"

static void print_dimensions(const lw_linkage *linkage, double unit, FILE *f)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_DYAD_MAX], input;
    if (lw_plan_make(linkage, (lw_plan_options){ .tracers = 1 }, &plan, NULL) != LW_OK
        || lw_plan_read(&plan, linkage, dim, mode, &input, NULL) != LW_OK)
        return;
    for (int d = 0; d < plan.n_dim; d++)
        fprintf(f, " %s=%.6g", plan.dim[d].name, plan.dim[d].kind == LW_DIM_ANGLE ? dim[d] : dim[d]/unit);
}

static void print_table(const lw_target *t, const lw_atlas_hit *hit, int n, FILE *f)
{
    fprintf(f, "  # distance  T[deg] input  family           dimensions [%s, rad]\n", t->units.length[0] ? t->units.length : "unit");
    for (int i = 0; i < n; i++) {
        char name[40];
        snprintf(name, sizeof name, hit[i].id ? "linkage %lld" : "%.0lld%s", hit[i].id, hit[i].family);
        fprintf(f, "%3d %8.5f  ", i + 1, hit[i].distance);
        fprintf(f, isnan(hit[i].transmission) ? "     -" : "%6.2f", hit[i].transmission*180/LW_PI);
        fprintf(f, " %-6s %-16s", hit[i].turns < 0 ? "-" : hit[i].turns ? "turns" : "rocks", name);
        print_dimensions(&hit[i].linkage, t->units.metre, f);
        fputc('\n', f);
    }
}

static void print_json(const cli_call *call, const lw_target *t, lw_atlas_hit *hit, int n, FILE *f)
{
    cli_json j = cli_json_begin(f, 0);
    cli_json_head(&j, call->line);
    cli_json_object(&j, "target");
    cli_json_text(&j, "file", call->parsed.word[2]);
    cli_json_int(&j, "points", (long long)t->n);
    cli_json_bool(&j, "closed", t->closed);
    cli_json_text(&j, "length_unit", t->units.length);
    cli_json_end(&j);
    cli_json_array(&j, "results");
    for (int i = 0; i < n; i++) {
        cli_json_object(&j, NULL);
        cli_json_int(&j, "rank", i + 1);
        const lw_type *type = lw_type_find(hit[i].type);
        cli_json_text(&j, "type", type ? type->name : NULL);
        cli_json_text(&j, "family", hit[i].family[0] ? hit[i].family : NULL);
        if (hit[i].id)
            cli_json_int(&j, "id", hit[i].id);
        cli_json_real(&j, "distance", hit[i].distance);
        cli_json_real(&j, "error_rms", hit[i].distance_m/t->units.metre);
        if (hit[i].turns >= 0)
            cli_json_bool(&j, "turns", hit[i].turns);
        cli_json_real(&j, "transmission_min", hit[i].transmission*180/LW_PI);
        hit[i].linkage.units = t->units;
        char *text = lw_linkage_write(&hit[i].linkage, 0);
        cli_json_raw(&j, "linkage", text);
        free(text);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_end(&j);
}

/* Number of curves to list. */
static int wanted(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    return s->results ? s->results : 20;
}

static lw_status search(const cli_call *call, const lw_target *t, lw_atlas_hit *hit, int *n, lw_error *e)
{
    lw_store *store = NULL;
    lw_atlas_search count = { 0 };
    const cli_catalogue_settings *s = call->settings;
    lw_atlas_filter filter = { .turns = s->full_turn, .min_transmission = s->min_transmission*LW_PI/180,
                               .min_length = s->length_range[0]*t->units.metre,
                               .max_length = s->length_range[1]*t->units.metre, .stop = cli_stop_flag() };
    lw_vec2 *p = malloc((t->n + 1)*sizeof *p);
    double start = lw_clock_wall();
    if (!p)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < t->n; i++)
        p[i] = lw_v2(t->x[i], t->y[i]);
    if (t->n_also > 0)
        cli_note(call, "%s: curves are compared with its first point alone", call->parsed.word[2]);
    lw_status status = cli_catalogue_open(call, false, &store, e);
    if (status == LW_OK)
        status = lw_store_nearest(store, p, t->n, t->closed, &filter, wanted(call), hit, n, &count, e);
    if (status >= 0)
        cli_note(call, "%llu curves, %llu of %llu blocks read, %llu compared, %.1f ms",
                 (unsigned long long)count.n_curve, (unsigned long long)count.n_read, (unsigned long long)count.n_block,
                 (unsigned long long)count.n_compared, 1e3*(lw_clock_wall() - start));
    lw_store_close(store);
    free(p);
    return status;
}

int cli_catalogue_nearest(const cli_call *call)
{
    if (wanted(call) > 100000)
        return cli_usage(call, "nearest lists at most 100000 curves, not %d", wanted(call));
    const cli_catalogue_settings *s = call->settings;
    if (cli_given(&call->parsed, "length-range") && !(s->length_range[1] > 0))
        return cli_usage(call, "--length-range %g:%g excludes every linkage", s->length_range[0], s->length_range[1]);
    lw_target t = { 0 };
    lw_output out;
    lw_error e = { 0 };
    int n = 0, code;
    lw_target_options o = { .closed = s->shape == 0 ? -1 : s->shape == 1 };
    cli_catalogue_limit(call);
    lw_atlas_hit *hit = calloc((size_t)wanted(call), sizeof *hit);
    lw_status status = hit ? cli_read_target(call->parsed.word[2], &o, &t, &e)
                           : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (status == LW_OK && !t.x)
        status = lw_error_at(&e, LW_E_ARG, call->parsed.word[2], 0, 0, "a function has no curve; x and y are wanted");
    if (status == LW_OK)
        status = search(call, &t, hit, &n, &e);
    if (status == LW_STOPPED) {
        cli_note(call, "stopped: these are the nearest of the curves that were compared");
        status = LW_OK;
    }
    if (status == LW_OK)
        status = cli_open(call, &out, &e);
    if (status != LW_OK) {
        code = cli_fail(call, &e);
    } else {
        if (call->common.json)
            print_json(call, &t, hit, n, out.f);
        else
            print_table(&t, hit, n, out.f);
        code = cli_close(call, &out, CLI_DONE);
    }
    lw_target_free(&t);
    free(hit);
    return code;
}
