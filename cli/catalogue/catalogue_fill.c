/* linkwright catalogue build, add, curves - fill a catalogue. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "catalogues/build/build.h"
#include "catalogues/store/drive_store.h"
#include "cli/catalogue/catalogue.h"

#define CONTINUE "; the same command goes on from here"

static bool goes_on(void *watch, double done, double total)
{
    cli_catalogue_watch *w = watch;
    w->total = total;
    return cli_catalogue_goes_on(w, done);
}

static lw_build_control control_of(const cli_call *call, cli_catalogue_watch *w)
{
    const cli_catalogue_settings *s = call->settings;
    return (lw_build_control){ .jobs = call->common.jobs, .commit = s->commit, .seed = call->common.seed,
                               .command = call->line, .goes_on = goes_on, .context = w };
}

/* ---- build ---------------------------------------------------------------------------------------------- */

/* The joint kinds "r", "rt" or "t"; NULL for any other text. */
static const char *read_kinds(const char *text)
{
    static const char *const known[][2] = {
        { "r", "r" }, { "r,t", "rt" }, { "rt", "rt" }, { "t,r", "rt" }, { "t", "t" }
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++)
        if (strcmp(text, known[i][0]) == 0)
            return known[i][1];
    return NULL;
}

int cli_catalogue_build(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    lw_build_topologies what = { .kinds = read_kinds(s->joints), .any_input = s->input == 1,
                                 .pictures = !s->no_pictures };
    lw_store *store = NULL;
    lw_chains *chains = NULL;
    lw_build_counts n = { 0 };
    lw_error e = { 0 };
    if (s->links == 0)
        return cli_usage(call, "how many links? give --links P");
    if (!what.kinds)
        return cli_usage(call, "--joints takes r, t or r,t, not '%s'", s->joints);
    cli_catalogue_watch w = cli_catalogue_watch_begin(call, "build", "chains");
    lw_build_control control = control_of(call, &w);
    double start = lw_clock_wall();
    lw_status status = lw_chains_create(s->links, s->dof, call->common.jobs, &chains, &e);
    if (status == LW_OK)
        status = cli_catalogue_open(call, true, &store, &e);
    if (status == LW_OK)
        status = lw_build_chains(store, chains, &what, &control, &n, &e);
    int code = cli_catalogue_watch_end(&w, status < 0 ? cli_fail(call, &e) : CLI_DONE);
    if (status >= 0 && n.was_complete) {
        cli_note(call, "it is complete already: %llu chains", (unsigned long long)n.done);
    } else if (status >= 0) {
        if (n.before > 0)
            cli_note(call, "continued after %llu chains", (unsigned long long)n.before);
        cli_note(call, "%llu of %llu chains in %.2f s%s", (unsigned long long)n.done, (unsigned long long)n.total,
                 lw_clock_wall() - start, status == LW_OK ? "" : CONTINUE);
    }
    lw_store_close(store);
    lw_chains_free(chains);
    return code;
}

/* ---- add ------------------------------------------------------------------------------------------------ */

/* Motors, gears or amplifiers. */
static lw_status add_parts(const cli_call *call, const char *text, size_t size, lw_error *e)
{
    const char *file = call->parsed.word[2];
    lw_drive_parts p = { 0 };
    lw_store *store = NULL;
    lw_status status = lw_drive_parts_read(text, size, file, &p, e);
    if (status == LW_OK)
        status = cli_catalogue_open(call, true, &store, e);
    if (status == LW_OK)
        status = lw_store_add_drive_parts(store, &p, file, call->line, e);
    if (status == LW_OK)
        cli_note(call, "%d motors, %d gears, %d amplifiers added", p.n_motor, p.n_gear, p.n_amplifier);
    lw_store_close(store);
    lw_drive_parts_free(&p);
    return status;
}

int cli_catalogue_add(const cli_call *call)
{
    const char *file = call->parsed.word[2];
    lw_store *store = NULL;
    lw_build_counts n = { 0 };
    lw_error e = { 0 };
    char *text = NULL;
    size_t size;
    cli_catalogue_watch w = cli_catalogue_watch_begin(call, "add", "linkages");
    lw_build_control control = control_of(call, &w);
    lw_status status = cli_read_file(file, "results of fit or linkages (JSON)", &text, &size, &e);
    if (status == LW_OK && lw_drive_parts_is(text, size)) {
        status = add_parts(call, text, size, &e);
        free(text);
        return cli_catalogue_watch_end(&w, status == LW_OK ? CLI_DONE : cli_fail(call, &e));
    }
    if (status == LW_OK)
        status = cli_catalogue_open(call, true, &store, &e);
    if (status == LW_OK)
        status = lw_build_linkages(store, file, text, size, &control, &n, &e);
    if (status == LW_OK && n.done == 0)
        status = lw_error_at(&e, LW_NOTHING, file, 0, 0, "it holds no linkage");
    int code = cli_catalogue_watch_end(&w, status < 0 || status == LW_NOTHING ? cli_fail(call, &e) : CLI_DONE);
    if (status >= 0 && status != LW_NOTHING)
        cli_note(call, "%llu linkages read, %llu added%s", (unsigned long long)n.done, (unsigned long long)n.added,
                 status == LW_OK ? "" : CONTINUE);
    lw_store_close(store);
    free(text);
    return code;
}

/* ---- curves --------------------------------------------------------------------------------------------- */

int cli_catalogue_curves(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    bool six = s->links == 6;
    lw_curve_maker *maker = NULL;
    lw_store *store = NULL;
    lw_build_counts n = { 0 };
    lw_error e = { 0 };
    if (s->links != 0 && s->links != 4 && s->links != 6)
        return cli_usage(call, "curves are drawn for four or six links: --links 4 or 6, not %d", s->links);
    if (six && cli_given(&call->parsed, "type"))
        return cli_usage(call, "--type is for four links; --links 6 draws all chains, ground links and tracer links");
    if (s->samples == 0)
        return cli_usage(call, "how many curves? give --samples N");
    cli_catalogue_watch w = cli_catalogue_watch_begin(call, "curves", "samples");
    lw_build_control control = control_of(call, &w);
    double start = lw_clock_wall();
    lw_status status = six ? lw_curve_maker_links(6, call->common.jobs, &maker, &e)
                           : lw_curve_maker_create(s->types, &maker, &e);
    if (status == LW_OK)
        status = cli_catalogue_open(call, true, &store, &e);
    if (status == LW_OK)
        status = lw_build_curves(store, maker, (lw_atlas_kinds)s->curves, (uint64_t)s->samples,
                                 six ? "six links" : s->types, &control, &n, &e);
    int code = cli_catalogue_watch_end(&w, status < 0 ? cli_fail(call, &e) : CLI_DONE);
    if (status >= 0)
        cli_note(call, "%llu curves drawn in %.2f s; the catalogue has %llu of %llu samples%s",
                 (unsigned long long)n.added, lw_clock_wall() - start, (unsigned long long)n.done,
                 (unsigned long long)n.total, status == LW_OK ? "" : CONTINUE);
    lw_curve_maker_free(maker);
    lw_store_close(store);
    return code;
}
