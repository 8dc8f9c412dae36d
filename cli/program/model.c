/* Read files of the user; a file of another kind is named. */
#include "cli/program/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/program/file_kind.h"
#include "cli/program/output.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"
#include "grammar/topology/notation.h"

/* After a failed read of a linkage: does the file hold something else, for which there is a command? */
static lw_status hint(const char *path, const char *text, size_t size, lw_status s, lw_error *e)
{
    bool spatial = false;
    if (s == LW_E_NOTATION && lw_spatial_recognise(text, size, &spatial) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (spatial)
        return lw_error_at(e, LW_E_NOTATION, path, 0, 0, "this is a spatial model, and this command knows planar "
                           "ones only; trace, simulate, mobility, robot, draw and convert know spatial models");
    if (s == LW_E_NOTATION)
        cli_wrong_kind(path, CLI_LINKAGE | CLI_RESULTS, e);
    return s;
}

lw_status cli_linkage_text(const char *path, int which, const char *text, size_t size, lw_linkage *linkage, lw_error *e)
{
    return hint(path, text, size, lw_linkage_read_result(text, size, path, which, linkage, e), e);
}

/* A text that is no planar linkage, as `s` says, may be a spatial model. */
static lw_status or_spatial(const char *path, const char *text, size_t size, lw_status s, lw_spatial **out, lw_error *e)
{
    bool spatial = false;
    lw_status known = s == LW_E_NOTATION && out ? lw_spatial_recognise(text, size, &spatial) : LW_OK;
    if (known == LW_OK && !spatial)
        return hint(path, text, size, s, e);
    lw_spatial *m = known == LW_OK ? calloc(1, sizeof *m) : NULL;
    if (!m)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    s = lw_spatial_read(text, size, path, m, e);
    for (const char *file = m->files; s == LW_OK && file && *file; file += strlen(file) + 1)
        s = cli_name_input(file, e);
    if (s == LW_OK) {
        *out = m;
        *e = (lw_error){ 0 };                    /* why it is no planar linkage */
    } else {
        cli_free_spatial(m);
    }
    return s;
}

lw_status cli_any_model_text(const char *text, size_t size, const char *path, int which, lw_model **planar,
                             lw_spatial **spatial, lw_error *e)
{
    lw_model *m = calloc(1, sizeof *m);
    *planar = NULL;
    if (spatial)
        *spatial = NULL;
    if (!m)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_model_read_result(text, size, path, which, m, e);
    if (s == LW_OK)
        *planar = m;
    else {
        free(m);
        s = or_spatial(path, text, size, s, spatial, e);
    }
    return s;
}

lw_status cli_read_any_model(const char *path, int which, lw_model **planar, lw_spatial **spatial, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    *planar = NULL;
    if (spatial)
        *spatial = NULL;
    lw_status s = cli_read_file(path, "a linkage (JSON)", &text, &size, e);
    if (s == LW_OK)
        s = cli_any_model_text(text, size, path, which, planar, spatial, e);
    free(text);
    return s;
}

lw_status cli_any_linkage_text(const char *path, int which, const char *text, size_t size, lw_assembly *k,
                               lw_spatial **spatial, lw_error *e)
{
    *spatial = NULL;
    return or_spatial(path, text, size, lw_assembly_read_result(text, size, path, which, k, e), spatial, e);
}

lw_model *cli_read_model(const char *path, int which, lw_error *e)
{
    lw_model *m;
    cli_read_any_model(path, which, &m, NULL, e);
    return m;
}

void cli_free_spatial(lw_spatial *m)
{
    if (m)
        lw_spatial_free(m);
    free(m);
}

void cli_free_model(lw_model *m)
{
    if (m)
        lw_model_free(m);
    free(m);
}

/* Status of a read that may have waited for input: Ctrl-C ends it. */
static lw_status waited(const char *path, lw_status s, lw_error *e)
{
    bool stopped = strcmp(path, "-") == 0 && cli_interrupted();
    return stopped ? lw_error_at(e, LW_STOPPED, path, 0, 0, "interrupted while it was read") : s;
}

lw_status cli_read_target(const char *path, const lw_target_options *o, lw_target *t, lw_error *e)
{
    if (strcmp(path, "-") == 0)
        cli_say_waiting("a target (CSV)");
    return waited(path, lw_target_read_file(path, o, t, e), e);
}

lw_status cli_read_task_file(const char *path, const lw_target_options *o, lw_task_file *b, lw_target *t, lw_error *e)
{
    if (strcmp(path, "-") == 0)
        cli_say_waiting("a task (JSON)");
    lw_status s = waited(path, lw_task_file_read_file(path, o, b, t, e), e);
    cli_kind_of_file kind = s == LW_E_NOTATION ? cli_wrong_kind(path, CLI_TARGET | CLI_DRAWING | CLI_TASK, e) : CLI_UNKNOWN;
    if (kind == CLI_LINKAGE || kind == CLI_RESULTS) {
        size_t used = strlen(e->text);
        snprintf(e->text + used, sizeof e->text - used, " Or 'linkwright fit TARGET --start-from %s'?", path);
    }
    return s;
}

lw_status cli_speed(const char *text, bool slides, double plain, double *speed, lw_error *e)
{
    static const struct { const char *name; double factor; } turning[] = {
        { "rad/s", 1 }, { "deg/s", LW_PI/180 }, { "rpm", LW_PI/30 }, { "r/min", LW_PI/30 }, { "1/min", LW_PI/30 },
        { "turn/s", 2*LW_PI }, { "Hz", 2*LW_PI } };
    char *end, name[8] = "";
    double value = strtod(text, &end), factor = end != text && fabs(value) <= 1e60 ? plain : 0;
    while (*end == ' ')
        end++;
    size_t n = strlen(end);
    if (factor != 0 && n > 0) {
        factor = 0;
        for (size_t i = 0; i < sizeof turning/sizeof *turning && !slides; i++)
            if (!strcmp(end, turning[i].name))
                factor = turning[i].factor;
        lw_units u = lw_units_si();
        if (slides && n > 2 && n < sizeof name && !strcmp(end + n - 2, "/s")) {
            memcpy(name, end, n - 2);
            factor = lw_units_set_length(&u, name) ? u.metre : 0;
        }
    }
    *speed = value*factor;
    if (factor != 0)
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "--speed is \"%.60s\"; expected a number, alone or with a unit, of at most 1e60: %s", text,
                        slides ? "m/s, mm/s, cm/s, in/s, ... (the input slides)" :
                        "rpm, rad/s, deg/s, turn/s, Hz (the input turns)");
}
