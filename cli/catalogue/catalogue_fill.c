/* linkwright catalogue build, add, curves - fill a catalogue. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/number.h"
#include "catalogues/build/build.h"
#include "catalogues/store/drive_store.h"
#include "cli/catalogue/catalogue.h"
#include "cli/program/file_kind.h"
#include "cli/program/mpi_jobs.h"

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
                               .command = call->line, .goes_on = goes_on, .context = w, .stop = cli_stop_flag() };
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
    lw_build_counts n = { 0 }, multiple = { 0 };
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
    if (status == LW_OK && s->multiple)
        status = lw_build_multiple(store, s->links, s->dof, &control, &multiple, &e);
    int code = cli_catalogue_watch_end(&w, status < 0 ? cli_fail(call, &e) : CLI_DONE);
    if (status >= 0 && n.was_complete) {
        cli_note(call, "it is complete already: %llu chains", (unsigned long long)n.done);
    } else if (status >= 0) {
        if (n.before > 0)
            cli_note(call, "continued after %llu chains", (unsigned long long)n.before);
        cli_note(call, "%llu of %llu chains in %.2f s%s", (unsigned long long)n.done, (unsigned long long)n.total,
                 lw_clock_wall() - start, status == LW_OK ? "" : CONTINUE);
    }
    if (status == LW_OK && s->multiple)
        cli_note(call, "%llu chains with multiple joints", (unsigned long long)multiple.done);
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
        cli_note(call, "%d motor%s, %d gear%s, %d amplifier%s added", p.n_motor, lw_plural(p.n_motor), p.n_gear, lw_plural(p.n_gear), p.n_amplifier,
                 lw_plural(p.n_amplifier));
    lw_store_close(store);
    lw_drive_parts_free(&p);
    return status;
}

/* The curves of another catalogue. */
static lw_status add_curves(const cli_call *call, const char *file, lw_error *e)
{
    char what[128];
    uint64_t n = 0;
    lw_store *part = NULL, *store = NULL;
    snprintf(what, sizeof what, "curves of %.100s", file);
    lw_store_run run = { "add", what, call->line, 0 };
    /* opened first, so that it is known to be a catalogue of this version */
    lw_status status = lw_store_open(file, &(lw_store_options){ .wait = 5, .command = call->line }, &part, e);
    if (status == LW_OK)
        status = cli_catalogue_open(call, true, &store, e);
    if (status == LW_OK)
        status = lw_store_add_curves(store, lw_store_path(part), &run, &n, e);
    if (status == LW_OK || status == LW_NOTHING)
        cli_note(call, status == LW_OK ? "%llu curves added" : "its curves are in the catalogue already", (unsigned long long)n);
    lw_store_close(store);
    lw_store_close(part);
    return status == LW_NOTHING ? LW_OK : status;
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
    if (cli_is_catalogue(file))
        return cli_catalogue_watch_end(&w, add_curves(call, file, &e) == LW_OK ? CLI_DONE : cli_fail(call, &e));
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

/* A run under mpirun: a task is a segment; its answer is the two trees. */
typedef struct remote {
    lw_build_sweep          b;
    lw_store               *store;               /* process 0 */
    const lw_build_control *control;
    lw_build_counts        *n;
    lw_error               *e;
} remote;

static lw_status work_segment(void *context, size_t k, lw_bytes *answer)
{
    remote *r = context;
    lw_atlas_tree tree[2];
    lw_build_control alone = *r->control;
    alone.jobs = 1;
    lw_status status = lw_build_sweep_draw(&r->b, k, &alone, tree);
    for (int i = 0; i < 2 && status == LW_OK; i++) {
        const lw_atlas_tree *t = &tree[i];
        lw_bytes_add(answer, &t->n, sizeof t->n);
        lw_bytes_add(answer, &t->n_block, sizeof t->n_block);
        lw_bytes_add(answer, t->terms, t->n*sizeof *t->terms);
        lw_bytes_add(answer, t->row, t->n*sizeof *t->row);
        lw_bytes_add(answer, t->box, t->n_block*sizeof *t->box);
        lw_atlas_tree_free(&tree[i]);
    }
    return status;
}

/* A copy of n items from the answer. */
static void *copy_items(const char **at, size_t n, size_t size)
{
    void *copy = malloc(n*size + 1);
    if (copy)
        memcpy(copy, *at, n*size);
    *at += n*size;
    return copy;
}

static lw_status take_segment(void *context, size_t k, const char *answer, size_t size)
{
    remote *r = context;
    lw_atlas_tree tree[2] = { { .closed = true }, { .closed = false } };
    bool good = true;
    (void)k, (void)size;
    for (int i = 0; i < 2; i++) {
        lw_atlas_tree *t = &tree[i];
        memcpy(&t->n, answer, sizeof t->n);
        memcpy(&t->n_block, answer + sizeof t->n, sizeof t->n_block);
        answer += sizeof t->n + sizeof t->n_block;
        t->terms = copy_items(&answer, t->n, sizeof *t->terms);
        t->row = copy_items(&answer, t->n, sizeof *t->row);
        t->box = copy_items(&answer, t->n_block, sizeof *t->box);
        good = good && t->terms && t->row && t->box;
    }
    if (!good) {
        lw_atlas_tree_free(&tree[0]);
        lw_atlas_tree_free(&tree[1]);
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    }
    lw_status status = lw_build_sweep_put(&r->b, r->store, tree, r->n, r->e);
    bool over = r->b.sweep.samples >= r->b.n_sample;
    return status != LW_OK || over
        || r->control->goes_on(r->control->context, (double)r->b.sweep.samples, (double)r->b.n_sample)
         ? status : LW_STOPPED;
}

static bool is_stored(void *context, size_t k)
{
    return k < ((remote *)context)->b.sweep.segments;
}

/* Process 0 has the store, the others have NULL. */
static lw_status draw_remote(remote *r, const char *about, bool *ran)
{
    lw_status status = r->store ? lw_build_sweep_begin(&r->b, r->store, about, r->control, r->n, r->e) : LW_OK;
    if (status == LW_OK && !r->n->was_complete && r->b.sweep.samples != r->b.sweep.segments*r->b.size)
        status = lw_error_set(r->e, LW_E_ARG, "the last segment of the catalogue is short, which --mpi does not know; go on without --mpi");
    if (status != LW_OK)
        return status;
    *ran = true;
    cli_mpi_work w = { r->n->was_complete ? 0 : r->b.n_segment, work_segment, take_segment, r, is_stored, 2 };
    status = cli_mpi_run(&w);
    if (status != LW_OK && status != LW_STOPPED && !*r->e->text)
        lw_error_set(r->e, status, "%s", lw_status_text(status));
    return status;
}

static lw_curve_maker *make_maker(const cli_call *call, lw_error *e)
{
    const cli_catalogue_settings *s = call->settings;
    lw_curve_maker *maker = NULL;
    (void)(s->links > 4 ? lw_curve_maker_links(s->links, read_kinds(s->joints), call->common.jobs, cli_stop_flag(), &maker, e)
                        : lw_curve_maker_create(s->types, &maker, e));
    return maker;
}

/* A process that is not process 0. */
static void run_as_worker(const cli_call *call, const lw_build_control *control, bool *ran)
{
    const cli_catalogue_settings *s = call->settings;
    lw_error e = { 0 };
    lw_build_counts n = { 0 };
    remote r = { .control = control, .n = &n, .e = &e };
    lw_curve_maker *maker = make_maker(call, &e);
    if (maker && lw_build_sweep_make(maker, (lw_atlas_kinds)s->curves, (uint64_t)s->samples, control, &r.b, &e) == LW_OK)
        (void)draw_remote(&r, "", ran);
    lw_curve_maker_free(maker);
}

static int draw_curves(const cli_call *call, lw_build_control *control, cli_catalogue_watch *w, bool *ran)
{
    const cli_catalogue_settings *s = call->settings;
    bool sliders = s->links > 4 && strcmp(read_kinds(s->joints), "rt") == 0;
    char more[64];
    snprintf(more, sizeof more, "%s links%s", s->links == 8 ? "eight" : "six", sliders ? " with sliders" : "");
    const char *about = s->links > 4 ? more : s->types;
    uint64_t n_sample = (uint64_t)s->samples;
    lw_store *store = NULL;
    lw_build_counts n = { 0 };
    lw_error e = { 0 };
    remote r = { .control = control, .n = &n, .e = &e };
    double start = lw_clock_wall();
    lw_curve_maker *maker = make_maker(call, &e);
    lw_status status = maker ? lw_build_sweep_make(maker, (lw_atlas_kinds)s->curves, n_sample, control, &r.b, &e)
                             : e.status;
    if (status == LW_OK)
        status = cli_catalogue_open(call, true, &store, &e);
    r.store = store;
    if (status == LW_OK)
        status = s->mpi ? draw_remote(&r, about, ran)
               : lw_build_curves(store, maker, (lw_atlas_kinds)s->curves, n_sample, about, control, &n, &e);
    int code = cli_catalogue_watch_end(w, status < 0 ? cli_fail(call, &e) : CLI_DONE);
    if (status >= 0 && !maker)
        cli_note(call, "%s", e.text);
    else if (status >= 0)
        cli_note(call, "%llu curves drawn in %.2f s; the catalogue has %llu of %llu samples%s",
                 (unsigned long long)n.added, lw_clock_wall() - start, (unsigned long long)n.done,
                 (unsigned long long)n.total, status == LW_OK ? "" : CONTINUE);
    lw_curve_maker_free(maker);
    lw_store_close(store);
    return code;
}

int cli_catalogue_curves(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    bool ran = false;
    const char *kinds = read_kinds(s->joints);
    if (s->links != 0 && s->links != 4 && s->links != 6 && s->links != 8)
        return cli_usage(call, "curves are drawn for four, six or eight links: --links 4, 6 or 8, not %d", s->links);
    if (s->links > 4 && cli_given(&call->parsed, "type"))
        return cli_usage(call, "--type is for four links; with more links all chains, ground links and tracer links are drawn");
    if (!kinds || (strcmp(kinds, "r") != 0 && (strcmp(kinds, "rt") != 0 || s->links < 6)))
        return cli_usage(call, "curves with sliders are drawn of four links, by --type, and of six or eight, by --joints r,t, not by "
                         "--joints %s", s->joints);
    if (s->samples == 0)
        return cli_usage(call, "how many curves? give --samples N");
    int part = 0, n_part = 0;
    int code = s->part ? cli_read_part(call, s->part, &part, &n_part) : CLI_DONE;
    if (code == CLI_DONE && s->mpi)
        code = cli_mpi_check(call);
    if (code != CLI_DONE)
        return code;
    int rank = s->mpi ? cli_mpi_begin() : 0;
    cli_catalogue_watch w = { 0 };
    if (rank == 0)
        w = cli_catalogue_watch_begin(call, "curves", "samples");
    lw_build_control control = control_of(call, &w);
    control.part = part;
    control.n_part = n_part;
    if (rank > 0)
        run_as_worker(call, &control, &ran);
    else
        code = draw_curves(call, &control, &w, &ran);
    if (s->mpi)
        cli_mpi_end(ran);
    return code;
}
