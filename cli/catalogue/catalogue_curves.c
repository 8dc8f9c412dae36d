/* linkwright catalogue curves, nearest - an atlas of coupler curves: drawn, and searched. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "catalogues/store/nearest.h"
#include "cli/catalogue/catalogue.h"
#include "optimise/topology/mechanism_set.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "mbs/plan/types.h"

/* ---- curves ------------------------------------------------------------------------------------------ */

typedef struct job {
    const cli_call     *call;
    lw_store           *store;
    lw_curve_maker     *maker;
    lw_atlas_sweep      sweep;
    uint64_t            wanted, n_curve;
    cli_catalogue_watch watch;
    lw_error            e;
} job;

static lw_status draw_segment(job *j)
{
    lw_atlas_tree tree[2];
    uint64_t left = j->wanted - j->sweep.samples;
    size_t n = left < LW_SEGMENT_MAX ? (size_t)left : LW_SEGMENT_MAX;
    lw_status s = lw_atlas_segment(j->maker, j->sweep.seed, j->sweep.segments, n, j->sweep.kinds, j->call->common.jobs,
                                   tree);
    if (s != LW_OK)
        return lw_error_set(&j->e, s, "%s", lw_status_text(s));
    s = lw_store_begin(j->store, &j->e);
    if (s == LW_OK)
        s = lw_store_put_segment(j->store, tree, n, &j->e);
    j->sweep.samples += n;
    j->sweep.segments++;
    if (s == LW_OK && j->sweep.samples >= j->wanted)
        s = lw_store_run_end(j->store, &j->e);
    if (s == LW_OK)
        s = lw_store_commit(j->store, &j->e);
    else
        lw_store_rollback(j->store);
    j->n_curve += tree[0].n + tree[1].n;
    lw_atlas_tree_free(&tree[0]);
    lw_atlas_tree_free(&tree[1]);
    return s;
}

static lw_status begin(job *j)
{
    const cli_catalogue_settings *s = j->call->settings;
    char what[128];
    snprintf(what, sizeof what, "%llu curves of %.90s", (unsigned long long)j->wanted,
             s->links == 6 ? "six links" : s->types);
    lw_store_run run = { "curves", what, j->call->line, j->call->common.seed };
    j->sweep = (lw_atlas_sweep){ .families = lw_curve_maker_families(j->maker), .kinds = (lw_atlas_kinds)s->curves,
                                 .seed = j->call->common.seed };
    lw_status status = lw_store_begin(j->store, &j->e);
    if (status == LW_OK)
        status = lw_store_sweep_begin(j->store, &j->sweep, &j->e);
    if (status == LW_OK && j->sweep.samples < j->wanted)
        status = lw_store_run_begin(j->store, &run, &j->e);
    if (status == LW_OK)
        return lw_store_commit(j->store, &j->e);
    lw_store_rollback(j->store);
    return status;
}

/* Every mechanism of pins with so many links whose tracer does more than with fewer links, an input for each. */
static lw_status add_topologies(job *j, int links)
{
    lw_mechanism_set all;
    lw_mechanism_request w = { .links = links, .dof = 1, .kinds = "r", .only = "all", .task = LW_TASK_PATH,
                            .jobs = j->call->common.jobs };
    lw_family_made *made = malloc(sizeof *made);
    lw_status status = made ? lw_mechanism_set_make(&w, &all, &j->e) : lw_error_set(&j->e, LW_E_MEMORY, "out of memory");
    if (status != LW_OK) {
        free(made);
        return status;
    }
    for (int i = 0; i < all.n; i++) {
        lw_families f = lw_mechanism_stage_families(&all.stage[i]);
        for (int n = 0; n < f.n && all.stage[i].links == links && status == LW_OK; n++) {
            status = f.make(f.of, n, made);
            if (status == LW_OK)
                status = lw_curve_maker_add(j->maker, made->name, &made->linkage, &j->e);
            status = status == LW_E_KIND ? LW_OK : status;
        }
    }
    free(made);
    lw_mechanism_set_free(&all);
    return status;
}

static lw_status draw_all(job *j)
{
    const cli_catalogue_settings *s = j->call->settings;
    bool six = s->links == 6;
    lw_status status = lw_curve_maker_create(six ? NULL : s->types, &j->maker, &j->e);
    if (status == LW_OK && six)
        status = add_topologies(j, s->links);
    if (status == LW_OK)
        status = cli_catalogue_open(j->call, true, &j->store, &j->e);
    if (status == LW_OK)
        status = begin(j);
    while (status == LW_OK && j->sweep.samples < j->wanted) {
        if (!cli_catalogue_goes_on(&j->watch, (double)j->sweep.samples))
            return LW_STOPPED;
        status = draw_segment(j);
    }
    return status;
}

int cli_catalogue_curves(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    if (s->links != 0 && s->links != 4 && s->links != 6)
        return cli_usage(call, "curves are drawn of four or six links: --links 4 or 6, not %d", s->links);
    if (s->links == 6 && cli_given(&call->parsed, "types"))
        return cli_usage(call, "--types are those of four links; with --links 6 all chains, ground and tracer links "
                         "are drawn");
    if (s->samples == 0)
        return cli_usage(call, "how many curves? give --samples N");
    job j = { .call = call, .wanted = (uint64_t)s->samples };
    j.watch = cli_catalogue_watch_begin(call, "curves", "samples");
    j.watch.total = (double)j.wanted;
    double start = lw_clock_wall();
    lw_status status = draw_all(&j);
    int code = cli_catalogue_watch_end(&j.watch, status < 0 ? cli_fail(call, &j.e) : CLI_DONE);
    double seconds = lw_clock_wall() - start;
    if (status >= 0)
        cli_note(call, "%llu curves drawn in %.2f s; %llu of %llu samples are in the catalogue%s",
                 (unsigned long long)j.n_curve, seconds, (unsigned long long)j.sweep.samples,
                 (unsigned long long)j.wanted, status == LW_OK ? "" : "; the same command goes on from here");
    lw_curve_maker_free(j.maker);
    lw_store_close(j.store);
    return code;
}

/* ---- nearest ----------------------------------------------------------------------------------------- */

static void print_dimensions(const lw_linkage *k, double unit, FILE *f)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_DYAD_MAX], input;
    if (lw_plan_make(k, (lw_plan_outputs){ 1, false }, &plan, NULL) != LW_OK
        || lw_plan_read(&plan, k, dim, mode, &input, NULL) != LW_OK)
        return;
    for (int d = 0; d < plan.n_dim; d++)
        fprintf(f, " %s=%.6g", plan.dim[d].name, plan.dim[d].kind == LW_DIM_ANGLE ? dim[d] : dim[d]/unit);
}

static void print_table(const lw_target *t, const lw_atlas_hit *hit, int n, FILE *f)
{
    fprintf(f, "  # distance  family            dimensions [%s, rad]\n", t->units.length[0] ? t->units.length : "unit");
    for (int i = 0; i < n; i++) {
        char name[40];
        snprintf(name, sizeof name, hit[i].id ? "linkage %lld" : "%.0lld%s", hit[i].id, hit[i].family);
        fprintf(f, "%3d %8.5f  %-16s", i + 1, hit[i].distance, name);
        print_dimensions(&hit[i].linkage, t->units.metre, f);
        fputc('\n', f);
    }
}

static void print_json(const cli_call *call, const lw_target *t, lw_atlas_hit *hit, int n, FILE *f)
{
    cli_json j = cli_json_begin(f, 0);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "version", LW_VERSION);
    cli_json_text(&j, "command", call->line);
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
        hit[i].linkage.units = t->units;
        char *text = lw_linkage_write(&hit[i].linkage, 0);
        if (text)
            cli_json_raw(&j, "linkage", text);
        free(text);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_end(&j);
}

static lw_status search(const cli_call *call, const lw_target *t, lw_atlas_hit *hit, int *n, lw_error *e)
{
    const cli_catalogue_settings *s = call->settings;
    lw_store *store = NULL;
    lw_atlas_search count = { 0 };
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
        status = lw_store_nearest(store, p, t->n, t->closed, s->neighbours, hit, n, &count, e);
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
    const cli_catalogue_settings *s = call->settings;
    lw_target t = { 0 };
    lw_output out;
    lw_error e = { 0 };
    int n = 0, code;
    lw_target_options o = { .closed = s->shape == 0 ? -1 : s->shape == 1 };
    lw_atlas_hit *hit = calloc((size_t)s->neighbours, sizeof *hit);
    lw_status status = hit ? cli_read_target(call->parsed.word[2], &o, &t, &e)
                           : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (status == LW_OK && !t.x)
        status = lw_error_at(&e, LW_E_ARG, call->parsed.word[2], 0, 0, "a function has no curve; x and y are wanted");
    if (status == LW_OK)
        status = search(call, &t, hit, &n, &e);
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
