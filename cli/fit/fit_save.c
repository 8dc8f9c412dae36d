/* cli/fit/fit_save.c - write the results of a fit into a folder: linkages, pictures, an animation, one page. */
#include <stdlib.h>
#include <string.h>

#include "catalogues/pages/draw.h"
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
    const lw_fitted f = cli_fitted(s);
    lw_status st = LW_OK;
    for (int i = 0; i < s->search.results.n && st == LW_OK && quick; i++)
        st = save_linkage(s, i, folder, e);
    if (st != LW_OK || s->search.results.n == 0)
        return st;
    lw_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a picture");
    st = lw_fitted_scene(&f, 0, scene, e);
    for (size_t k = 0; k < sizeof kinds/sizeof *kinds && st == LW_OK; k++) {
        char path[CLI_PATH_SIZE];
        snprintf(path, sizeof path, "%s/%s.%s", folder, s->name, kinds[k].end);
        if (kinds[k].quick == quick)
            st = lw_draw_save(scene, kinds[k].kind, path, 0, 0, e);
    }
    lw_scene_free(scene);
    free(scene);
    lw_drawing d;
    if (st == LW_OK && quick && (st = lw_fitted_curves(&f, &d, e)) == LW_OK) {
        char path[CLI_PATH_SIZE];
        snprintf(path, sizeof path, "%s/%s-curve.svg", folder, s->name);
        st = lw_draw_drawing(&d, path, e);
        lw_drawing_free(&d);
    }
    return st;
}

lw_status cli_fit_page(const cli_fit_set *s, int n_set, const char *folder, lw_error *e)
{
    lw_fitted *f = calloc((size_t)n_set + 1, sizeof *f);
    lw_bytes bytes = { 0 };
    char path[CLI_PATH_SIZE];
    bool any = false;
    lw_status st = f ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for a page");
    for (int i = 0; i < n_set && f; i++) {
        f[i] = cli_fitted(&s[i]);
        any |= f[i].results->n > 0;
    }
    if (any)
        st = lw_fitted_page(f, n_set, "Linkages found", &bytes, e);
    snprintf(path, sizeof path, "%s/index.html", folder);
    if (any && st == LW_OK)
        st = lw_file_write(path, bytes.data, bytes.size, e);
    lw_bytes_free(&bytes);
    free(f);
    return st;
}
