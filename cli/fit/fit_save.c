/* cli/fit/fit_save.c - write the results of a fit into a folder: linkages, pictures, an animation, one page. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "catalogues/pages/page.h"
#include "cli/fit/fit.h"

void cli_fit_name(const char *path, char *name, size_t size)
{
    const char *slash = strrchr(path, '/');
    snprintf(name, size, "%s", strcmp(path, "-") == 0 ? "target" : slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot && dot != name)
        *dot = 0;
}

int cli_fit_check_folder(const cli_call *call, const char *folder, int results)
{
    static const char *const end[] = { ".svg", ".png", ".gif", "-curve.svg" };
    char name[CLI_FIT_NAME_SIZE], other[CLI_FIT_NAME_SIZE];
    int code = cli_make_folder(call, folder);
    if (code == CLI_DONE)
        code = cli_may_write_in(call, folder, "index.html");
    for (int i = 0; i < call->parsed.n_word && code == CLI_DONE; i++) {
        cli_fit_name(call->parsed.word[i], name, sizeof name);
        for (int k = 0; k < i; k++) {
            cli_fit_name(call->parsed.word[k], other, sizeof other);
            if (strcmp(name, other) == 0)
                return cli_usage(call, "%s and %s would be saved under one name, '%s'; rename one, or fit them one by "
                                 "one into folders of their own", call->parsed.word[k], call->parsed.word[i], name);
        }
        for (int k = 0; k < 4 && code == CLI_DONE; k++)
            code = cli_may_write_in(call, folder, "%s%s", name, end[k]);
        for (int k = 1; k <= results + LW_STAGE_MAX && code == CLI_DONE; k++)
            code = cli_may_write_in(call, folder, "%s-%d.json", name, k);
    }
    return code;
}

static lw_status make_scene(const cli_fit_set *s, int i, lw_scene *scene, lw_error *e)
{
    char title[CLI_FIT_NAME_SIZE + 128];
    lw_scene_options o = lw_scene_options_default();
    const lw_candidate *c = cli_fit_candidate(s, i);
    snprintf(title, sizeof title, "%s: %s", s->name, lw_family_title(c->family));
    o.title = title;
    return lw_scene_make(&s->search.results.report[i].linkage, s->target.x ? &s->target : NULL, &o, scene, e);
}

static lw_status save_linkage(const cli_fit_set *s, int i, const char *folder, lw_error *e)
{
    char path[CLI_PATH_SIZE];
    char *text = lw_linkage_write(&s->search.results.report[i].linkage, 1);
    if (!text)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the text of a linkage");
    snprintf(path, sizeof path, "%s/%s-%d.json", folder, s->name, i + 1);
    lw_status st = lw_file_write(path, text, strlen(text), e);
    free(text);
    return st;
}

lw_status cli_fit_save(const cli_fit_set *s, const char *folder, bool quick, lw_error *e)
{
    static const struct { lw_draw_kind kind; const char *end; bool quick; } kinds[] = {
        { LW_DRAW_SVG, "svg", true }, { LW_DRAW_PNG, "png", false }, { LW_DRAW_GIF, "gif", false }
    };
    lw_status st = LW_OK;
    for (int i = 0; i < s->search.results.n && st == LW_OK && quick; i++)
        st = save_linkage(s, i, folder, e);
    if (st != LW_OK || s->search.results.n == 0)
        return st;
    lw_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a picture");
    st = make_scene(s, 0, scene, e);
    for (size_t k = 0; k < sizeof kinds/sizeof *kinds && st == LW_OK; k++) {
        char path[CLI_PATH_SIZE];
        snprintf(path, sizeof path, "%s/%s.%s", folder, s->name, kinds[k].end);
        if (kinds[k].quick == quick)
            st = lw_draw_save(scene, kinds[k].kind, path, 0, 0, e);
    }
    lw_scene_free(scene);
    free(scene);
    lw_drawing d;
    if (st == LW_OK && quick && (st = cli_fit_curves(s, &d, e)) == LW_OK) {
        char path[CLI_PATH_SIZE];
        snprintf(path, sizeof path, "%s/%s-curve.svg", folder, s->name);
        st = lw_draw_drawing(&d, path, e);
        lw_drawing_free(&d);
    }
    return st;
}

/* ---- the page ------------------------------------------------------------------------------------ */

typedef struct sheet {
    lw_scene       *scene;                         /* one for each result, as the following            */
    lw_page_result *result;
    char          (*limits)[256], (*dimensions)[512];   /* "": those of the scene                              */
    lw_drawing     curves;                         /* wanted and reached                               */
    char          (*class_name)[128], (*file)[CLI_FIT_NAME_SIZE + 24], about[160];
    int             n;
} sheet;

/* Dimensions of a function as its table gives them. */
static lw_status write_dimensions(const cli_fit_set *s, int i, sheet *h, lw_error *e)
{
    FILE *text = fmemopen(h->dimensions[i], sizeof h->dimensions[i], "w");
    if (!text)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a page");
    cli_fit_dimensions(s, i, text);
    fprintf(text, "; the input is at input0 %c angle, the angle of the output's link plus tool0 is theta; angles in deg",
            cli_fit_candidate(s, i)->intended.sense < 0 ? '-' : '+');
    fclose(text);
    return LW_OK;
}

static void describe(const cli_fit_set *s, int i, sheet *h)
{
    const lw_fit_report *r = &s->search.results.report[i];
    const lw_candidate *c = cli_fit_candidate(s, i);
    if (r->has_class)
        snprintf(h->class_name[i], sizeof h->class_name[i], "%s %s%s", r->barker.symbol, r->barker.name,
                 cli_fit_near_change_point(r) ? ", near a change point" : "");
    snprintf(h->file[i], sizeof h->file[i], "%s-%d.json", s->name, i + 1);
    lw_fit_report_active(r, h->limits[i], sizeof h->limits[i]);
    size_t at = strlen(h->limits[i]);
    if (r->broken)
        snprintf(h->limits[i] + at, sizeof h->limits[i] - at, "%sbeyond: %s", at ? "; " : "", r->broken_text);
    h->result[i] = (lw_page_result){
        .dimensions = h->dimensions[i][0] ? h->dimensions[i] : NULL,
        .input = lw_fit_report_input(r), .limits = h->limits[i][0] ? h->limits[i] : NULL,
        .stray = lw_fit_report_stray(r), .size = s->target.extent > 0 ? r->size/s->target.extent : 0,
        .scene = &h->scene[i], .type = lw_family_title(c->family),
        .class_name = r->has_class ? h->class_name[i] : NULL, .linkage = &r->linkage, .file = h->file[i],
        .transmission_min = r->transmission_min, .objective = lw_fit_report_objective(c, r),
        .error_mean = r->error_mean, .error_max = r->error_max, .error_percent = r->error_percent,
        .angle_mean = r->angle_mean, .angle_max = r->angle_max
    };
}

static lw_status fill_sheet(const cli_fit_set *s, sheet *h, lw_page_target *t, lw_error *e)
{
    size_t most = (size_t)s->search.results.n;
    lw_status st = LW_OK;
    h->scene = calloc(most, sizeof *h->scene);
    h->result = calloc(most, sizeof *h->result);
    h->class_name = calloc(most, sizeof *h->class_name);
    h->file = calloc(most, sizeof *h->file);
    h->limits = calloc(most, sizeof *h->limits);
    h->dimensions = calloc(most, sizeof *h->dimensions);
    if (!h->dimensions || !h->limits || !h->scene || !h->result || !h->class_name || !h->file)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a page");
    for (; h->n < s->search.results.n && st == LW_OK; h->n++) {
        st = make_scene(s, h->n, &h->scene[h->n], e);
        if (st == LW_OK && !lw_task_has_place(s->spec.task))
            st = write_dimensions(s, h->n, h, e);
        describe(s, h->n, h);
    }
    if (st == LW_OK)
        st = cli_fit_curves(s, &h->curves, e);
    snprintf(h->about, sizeof h->about, "%zu points, %s; %ld local fits in %.1f s.", s->target.n,
             s->target.closed ? "closed" : "open", s->search.found.fit.improved, s->search.found.fit.seconds);
    *t = (lw_page_target){ .name = s->name, .about = h->about, .n_result = h->n,
                           .result = h->result, .curves = st == LW_OK && !lw_task_has_place(s->spec.task) ? &h->curves : NULL };
    return st;
}

lw_status cli_fit_page(const cli_fit_set *s, int n_set, const char *folder, lw_error *e)
{
    sheet *h = calloc((size_t)n_set + 1, sizeof *h);
    lw_page_target *t = calloc((size_t)n_set + 1, sizeof *t);
    lw_bytes bytes = { 0 };
    char path[CLI_PATH_SIZE];
    int n = 0;
    lw_status st = h && t ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory");
    for (int i = 0; i < n_set && st == LW_OK; i++)
        if (s[i].search.results.n > 0) {
            st = fill_sheet(&s[i], &h[n], &t[n], e);
            n++;
        }
    lw_page page = { .title = "Linkages found", .n_target = n, .target = t };
    if (st == LW_OK && n > 0)
        st = lw_page_write(&page, &bytes, e);
    snprintf(path, sizeof path, "%s/index.html", folder);
    if (st == LW_OK && n > 0)
        st = lw_file_write(path, bytes.data, bytes.size, e);
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
    lw_bytes_free(&bytes);
    free(h);
    free(t);
    return st;
}
