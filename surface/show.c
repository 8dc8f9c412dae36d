/* Pictures and catalogues. */
#include "base/real.h"
#include "surface/surface.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/file.h"
#include "catalogues/build/build.h"
#include "catalogues/draw/plot.h"
#include "catalogues/draw/sheet.h"
#include "catalogues/build/release.h"
#include "catalogues/pages/atlas_html.h"
#include "catalogues/pages/draw.h"
#include "catalogues/store/query.h"

/* ---- pictures ------------------------------------------------------------------------------------------------- */

struct lw_picture {
    bool       moves;                  /* a scene, else a drawing */
    lw_scene   scene;
    lw_drawing drawing;
};

static lw_status picture_of(const lw_assembly *parts, const lw_model *model, const lw_target *target, const char *title,
                            lw_picture **out, lw_error *error)
{
    lw_scene_options o = lw_scene_options_default();
    lw_picture *p = calloc(1, sizeof *p);
    *out = NULL;
    if (!p)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    o.title = title;
    o.model = model;
    p->moves = true;
    lw_status s = lw_scene_make_any(parts, model, target && target->x ? target : NULL, &o, &p->scene, error);
    if (s == LW_OK)
        *out = p;
    else
        lw_picture_destroy(p);
    return s;
}

lw_status lw_picture_of_linkage(const lw_linkage *linkage, const lw_target *target, const char *title, lw_picture **out, lw_error *error)
{
    return picture_of(LW_VIEW(linkage), NULL, target, title, out, error);
}

lw_status lw_picture_of_model(const lw_model *model, const lw_target *target, const char *title, lw_picture **out, lw_error *error)
{
    return picture_of(&model->linkage, model, target, title, out, error);
}

lw_status lw_picture_of_mechanisms(int n, const lw_mechanism *const *mechanism, const char *const *caption, int columns,
                                   const char *title, lw_picture **out, lw_error *error)
{
    lw_sheet_style style = lw_sheet_style_default();
    lw_picture *p = calloc(1, sizeof *p);
    lw_sheet_item *item = calloc((size_t)(n > 0 ? n : 0) + 1, sizeof *item);
    *out = NULL;
    lw_status s = p && item ? LW_OK : lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (s == LW_OK && (n < 1 || columns < 1))
        s = lw_error_set(error, LW_E_ARG, "a page needs a mechanism and a column");
    for (int i = 0; i < n && s == LW_OK; i++)
        item[i] = (lw_sheet_item){ .m = mechanism[i], .caption = caption ? caption[i] : NULL };
    style.columns = columns;
    style.rows = columns > 0 ? (n + columns - 1)/columns : 0;
    style.title = title;
    if (s == LW_OK)
        s = lw_sheet_draw(item, n, &style, 0, &p->drawing, error);
    free(item);
    if (s == LW_OK)
        *out = p;
    else
        free(p);
    return s;
}

void lw_picture_destroy(lw_picture *picture)
{
    if (picture && picture->moves)
        lw_scene_free(&picture->scene);
    else if (picture)
        lw_drawing_free(&picture->drawing);
    free(picture);
}

static lw_status picture_bytes(const lw_picture *p, const char *name, int width, int height, lw_bytes *b, lw_error *e)
{
    lw_draw_kind kind;
    lw_status s = lw_draw_kind_of(name, &kind, e);
    if (s != LW_OK)
        return s;
    return p->moves ? lw_draw_bytes(&p->scene, kind, width, height, b, e) : lw_draw_still(&p->drawing, kind, b, e);
}

lw_status lw_picture_write(const lw_picture *picture, const char *kind, int width, int height, char **out, size_t *size, lw_error *error)
{
    lw_bytes b = { 0 };
    *out = NULL;
    lw_status s = picture_bytes(picture, kind, width, height, &b, error);
    return s == LW_OK ? lw_surface_give(&b, out, size, error) : s;
}

lw_status lw_picture_save(const lw_picture *picture, const char *path, int width, int height, lw_error *error)
{
    lw_bytes b = { 0 };
    lw_status s = picture_bytes(picture, path, width, height, &b, error);
    if (s == LW_OK)
        s = lw_file_write(path, b.data, b.size, error);
    lw_bytes_free(&b);
    return s;
}

lw_status lw_plot_save(const char *path, const char *title, const char *x_label, const char *y_label, bool log_x,
                       bool log_y, int n_series, const lw_plot_series *series, lw_error *error)
{
    lw_series line[LW_SERIES_MAX];
    if (n_series < 1 || n_series > LW_SERIES_MAX)
        return lw_error_set(error, LW_E_ARG, "a plot has 1 to %d series", LW_SERIES_MAX);
    for (int i = 0; i < n_series; i++)
        line[i] = (lw_series){ .name = series[i].name, .n = series[i].n, .x = series[i].x, .y = series[i].y };
    lw_plot plot = { .title = title, .x_label = x_label, .y_label = y_label, .log_x = log_x, .log_y = log_y,
                     .n_series = n_series, .series = line };
    return lw_draw_plot(&plot, path, error);
}

/* ---- catalogues ------------------------------------------------------------------------------------------------ */

struct lw_catalogue { lw_store *store; };

lw_status lw_catalogue_open(const char *path, bool write, double wait, lw_catalogue **out, lw_error *error)
{
    lw_store_options o = { .write = write, .create = write, .wait = wait, .command = "a program with liblinkwright" };
    lw_catalogue *c = calloc(1, sizeof *c);
    *out = NULL;
    lw_status s = c ? lw_store_open(path, &o, &c->store, error) : lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        *out = c;
    else
        free(c);
    return s;
}

void lw_catalogue_close(lw_catalogue *catalogue)
{
    if (catalogue)
        lw_store_close(catalogue->store);
    free(catalogue);
}

typedef struct watch { const lw_catalogue_work *work; double begun; } watch;

static bool goes_on(void *context, double done, double total)
{
    const watch *w = context;
    if (w->work->stop && *w->work->stop)
        return false;
    return !w->work->progress
        || w->work->progress(w->work->context, total > 0 ? done/total : NAN, lw_clock_wall() - w->begun, NAN);
}

static lw_build_control control_of(const lw_catalogue_work *work, watch *w)
{
    static const lw_catalogue_work usual;
    *w = (watch){ .work = work ? work : &usual, .begun = lw_clock_wall() };
    return (lw_build_control){ .jobs = w->work->jobs, .commit = 2, .seed = w->work->seed,
                               .goes_on = goes_on, .context = w, .stop = w->work->stop };
}

lw_status lw_catalogue_add_chains(lw_catalogue *catalogue, int links, int dof, const char *kinds,
                                  const lw_catalogue_work *work, uint64_t *n, lw_error *error)
{
    watch w;
    lw_build_control control = control_of(work, &w);
    lw_build_topologies what = { .kinds = kinds, .pictures = true };
    lw_build_counts counts = { 0 };
    lw_chains *chains;
    lw_status s = lw_chains_create(links, dof, control.jobs, &chains, error);
    if (s != LW_OK)
        return s;
    s = lw_build_chains(catalogue->store, chains, &what, &control, &counts, error);
    lw_chains_free(chains);
    if (n)
        *n = counts.done;
    return s;
}

lw_status lw_catalogue_add_linkages(lw_catalogue *catalogue, const char *text, size_t size, const char *file, uint64_t *n, lw_error *error)
{
    watch w;
    lw_build_control control = control_of(NULL, &w);
    lw_build_counts counts = { 0 };
    lw_status s = lw_build_linkages(catalogue->store, file ? file : "", text, size, &control, &counts, error);
    if (n)
        *n = counts.added;
    return s;
}

lw_status lw_catalogue_add_curves(lw_catalogue *catalogue, const char *types, int links, uint64_t samples,
                                  const lw_catalogue_work *work, lw_error *error)
{
    watch w;
    lw_build_control control = control_of(work, &w);
    lw_build_counts counts = { 0 };
    lw_curve_maker *maker;
    char about[32];
    snprintf(about, sizeof about, "%d links", links);
    lw_status s = types ? lw_curve_maker_create(types, &maker, error)
                : lw_curve_maker_links(links, "r", control.jobs, w.work->stop, &maker, error);
    if (s != LW_OK)
        return s;
    s = lw_build_curves(catalogue->store, maker, LW_ATLAS_BOTH, samples, types ? types : about, &control, &counts, error);
    lw_curve_maker_free(maker);
    return s;
}

static lw_status ask(lw_store *store, lw_store_query *q, lw_catalogue_row *row, void *context, lw_error *e)
{
    q->row = row;
    q->context = context;
    return lw_store_ask(store, q, e);
}

lw_status lw_catalogue_query(lw_catalogue *catalogue, const char *question, const char *list, const char *columns,
                             const char *sort, long limit, lw_catalogue_row *row, void *context, lw_error *error)
{
    const char *lists[LW_LIST_ANY + 1] = { NULL };
    for (int i = 0; i < LW_LIST_ANY; i++)
        lists[i] = lw_list_names[i];
    int which = list ? lw_surface_word("list", list, lists, error) : LW_LIST_ANY;
    lw_query_options o = { .list = (lw_query_list)which, .columns = columns, .sort = sort, .limit = limit };
    lw_query *q = malloc(sizeof *q);
    if (which < 0 || !q) {
        free(q);
        return which < 0 ? LW_E_ARG : lw_error_set(error, LW_E_MEMORY, "out of memory");
    }
    lw_status s = lw_query_compile(question, &o, q, error);
    if (s == LW_OK) {
        lw_store_query asked = { .sql = q->sql.data, .value = q->value, .n_value = q->n_value };
        s = ask(catalogue->store, &asked, row, context, error);
    }
    lw_query_free(q);
    free(q);
    return s;
}

lw_status lw_catalogue_sql(lw_catalogue *catalogue, const char *sql, lw_catalogue_row *row, void *context, lw_error *error)
{
    lw_store_query q = { .sql = sql, .foreign = true };
    return ask(catalogue->store, &q, row, context, error);
}

lw_status lw_catalogue_nearest(lw_catalogue *catalogue, const lw_target *target, const lw_catalogue_filter *filter,
                               int count, lw_catalogue_hit_visit *visit, void *context, lw_error *error)
{
    lw_atlas_filter only = { 0 };
    if (filter)
        only = (lw_atlas_filter){ .turns = filter->turns, .min_transmission = filter->min_transmission,
                                  .min_length = filter->min_length, .max_length = filter->max_length };
    if (count < 1 || !target->x)
        return lw_error_set(error, LW_E_ARG, "a search needs a target with points, and a curve or more to find");
    lw_atlas_hit *hit = calloc((size_t)count, sizeof *hit);
    lw_vec2 *p = calloc(target->n, sizeof *p);
    int n = 0;
    lw_status s = hit && p ? LW_OK : lw_error_set(error, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < target->n && s == LW_OK; i++)
        p[i] = lw_v2(target->x[i], target->y[i]);
    if (s == LW_OK)
        s = lw_store_nearest(catalogue->store, p, target->n, target->closed, &only, count, hit, &n, NULL, error);
    for (int i = 0; i < n && s == LW_OK; i++) {
        lw_catalogue_hit one = { .distance = hit[i].distance, .distance_m = hit[i].distance_m, .family = hit[i].family,
                                 .linkage = &hit[i].linkage, .turns = hit[i].turns,
                                 .transmission = hit[i].transmission };
        s = visit(context, &one);
    }
    free(hit);
    free(p);
    return s;
}

lw_status lw_catalogue_check(lw_catalogue *catalogue, lw_error *error)
{
    uint64_t n_chain, n_open;
    return lw_build_check(catalogue->store, NULL, &n_chain, &n_open, error);
}

lw_status lw_catalogue_pages(lw_catalogue *catalogue, const char *folder, int links, int limit,
                             const lw_catalogue_work *work, lw_error *error)
{
    watch w;
    lw_build_control control = control_of(work, &w);
    lw_atlas_html_options o = lw_atlas_html_options_default();
    size_t n_page, n_byte;
    o.links = links;
    o.limit = limit;
    o.jobs = control.jobs;
    o.goes_on = control.goes_on;
    o.context = control.context;
    return lw_atlas_html_write(catalogue->store, folder, &o, &n_page, &n_byte, error);
}

lw_status lw_release(const char *folder, int links, const lw_catalogue_work *work, lw_error *error)
{
    watch w;
    char command[LW_RELEASE_COMMAND];
    lw_build_control control = control_of(work, &w);
    lw_release_size size = lw_release_sizes(links, command);
    control.seed = 1;
    control.command = command;
    return lw_release_write(folder, &size, &control, error);
}
