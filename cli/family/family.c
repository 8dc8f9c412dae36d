/* What all actions of `linkwright family` share: the master, the variant that the options choose, lists. */
#include "cli/family/family.h"

#include <stdlib.h>
#include <string.h>
#include "cli/program/model.h"
#include "cli/program/output.h"

bool cli_family_next(const char **at, char *item, size_t size)
{
    int depth = 0;
    size_t n = 0;
    const char *c = *at;
    while (*c == ',' || *c == ' ')
        c++;
    for (; *c && (*c != ',' || depth > 0); c++) {
        depth += (*c == '(') - (*c == ')');
        if (n + 1 < size)
            item[n++] = *c;
    }
    item[n] = '\0';
    *at = c;
    return n > 0;
}

lw_status cli_family_set(const char *list, lw_variant *v, lw_error *e)
{
    char item[256];
    lw_status s = LW_OK;
    for (const char *at = list; s == LW_OK && at && cli_family_next(&at, item, sizeof item);) {
        char *equals = strchr(item, '=');
        if (!equals)
            return lw_error_set(e, LW_E_ARG, "--set is \"%.80s\"; expected NAME=VALUE", item);
        *equals = '\0';
        for (char *end = equals; end > item && end[-1] == ' ';)
            *--end = '\0';
        s = lw_variant_set(v, item, equals + 1 + strspn(equals + 1, " "), e);
    }
    return s;
}

lw_status cli_family_variant(const cli_call *call, const lw_master *m, lw_variant **v, lw_error *e)
{
    const cli_family_settings *o = call->settings;
    lw_status s = lw_variant_create(m, v);
    if (s != LW_OK)
        return lw_error_set(e, s, "out of memory");
    if (s == LW_OK && o->configuration)
        s = lw_variant_configure(*v, o->configuration, e);
    if (s == LW_OK && o->view)
        s = lw_variant_look(*v, o->view, e);
    return s == LW_OK ? cli_family_set(o->set, *v, e) : s;
}

lw_status cli_family_open(const cli_call *call, lw_master **m, lw_variant **v, lw_error *e)
{
    const char *path = call->parsed.word[1];
    char *text = NULL;
    size_t size = 0;
    *v = NULL;
    *m = NULL;
    lw_status s = cli_read_file(path, "a master file (JSON)", &text, &size, e);
    if (s == LW_OK)
        s = lw_master_read(text, size, path, m, e);
    free(text);
    return s == LW_OK ? cli_family_variant(call, *m, v, e) : s;
}

lw_status cli_family_read_back(const lw_expansion *x, lw_error *e)
{
    lw_model *planar = NULL;
    lw_spatial *spatial = NULL;
    lw_status s = cli_any_model_text(x->text, x->size, "", 0, &planar, &spatial, e);
    if (s != LW_OK)
        lw_expansion_fault(x, e);
    cli_free_model(planar);
    cli_free_spatial(spatial);
    return s;
}
