#include "surface/surface.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/file.h"
#include "base/real.h"
#include "mbs/analysis/notes.h"

const char *lw_version(void) { return LW_VERSION_STRING; }

void lw_free(void *text) { free(text); }

lw_status lw_surface_copy(const void *from, size_t size, void **out)
{
    *out = malloc(size);
    if (!*out)
        return LW_E_MEMORY;
    memcpy(*out, from, size);
    return LW_OK;
}

lw_status lw_surface_give(lw_bytes *b, char **out, size_t *size, lw_error *e)
{
    *out = NULL;
    lw_bytes_add(b, "", 0);
    lw_status s = lw_bytes_end(b, e);
    if (s != LW_OK)
        return s;
    if (size)
        *size = b->size;
    *out = b->data ? b->data : calloc(1, 1);
    memset(b, 0, sizeof *b);
    return *out ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

int lw_surface_word(const char *what, const char *word, const char *const *list, lw_error *e)
{
    char known[256] = "";
    for (int i = 0; list[i]; i++) {
        if (word && strcmp(word, list[i]) == 0)
            return i;
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "", list[i]);
    }
    lw_error_set(e, LW_E_ARG, "%s '%s' is not known; known are %s", what, word ? word : "", known);
    return -1;
}

lw_status lw_surface_load(const char *path, lw_surface_reader *read, void *context, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = lw_file_read(path, &text, &size, e);
    if (s == LW_OK)
        s = read(text, size, path, context, e);
    free(text);
    return s;
}

lw_status lw_surface_parse_new(const char *text, size_t size, const char *file, lw_surface_reader *read, size_t room,
                               void **out, lw_error *e)
{
    void *made = calloc(1, room);
    lw_status s = made ? read(text, size, file, made, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    *out = s == LW_OK ? made : NULL;
    if (s != LW_OK)
        free(made);
    return s;
}

typedef struct made { lw_surface_reader *read; size_t room; void **out; } made;

static lw_status read_new(const char *text, size_t size, const char *file, void *context, lw_error *e)
{
    const made *m = context;
    return lw_surface_parse_new(text, size, file, m->read, m->room, m->out, e);
}

lw_status lw_surface_load_new(const char *path, lw_surface_reader *read, size_t room, void **out, lw_error *e)
{
    *out = NULL;
    return lw_surface_load(path, read_new, &(made){ read, room, out }, e);
}

/* ---- what runs in the plane and in space share ----------------------------------------------------------- */

lw_simulation_options lw_simulation_options_default(void)
{
    return (lw_simulation_options){ .analysis = "transient", .formulation = "auto", .to = 1, .intervals = 100,
                                    .tolerance = 1e-10 };
}

lw_status lw_surface_options(const lw_simulation_options *options, lw_dynamics_options *out, lw_error *error)
{
    static const char *const analyses[] = { "transient", "static", "quasistatic", "kinematic", "dynamic", NULL };
    const lw_simulation_options all = options ? *options : lw_simulation_options_default();
    const char *formulations[LW_FORMULATION_GGL + 2] = { NULL };
    for (int i = 0; i <= LW_FORMULATION_GGL; i++)
        formulations[i] = lw_formulation_name((lw_formulation)i);
    int analysis = lw_surface_word("analysis", all.analysis, analyses, error);
    int formulation = analysis < 0 ? -1 : lw_surface_word("formulation", all.formulation, formulations, error);
    if (formulation < 0)
        return LW_E_ARG;
    if (all.intervals < 1 || !isfinite(all.from) || !(all.tolerance > 0))
        return lw_error_set(error, LW_E_ARG, "a simulation needs a time from which it starts, an interval and a positive tolerance");
    *out = lw_dynamics_options_default();
    out->analysis = (lw_analysis)analysis;
    out->formulation = (lw_formulation)formulation;
    out->from = all.from;
    out->to = all.to;
    out->intervals = all.intervals;
    out->relative = out->absolute = all.tolerance;
    out->max_step = all.max_steps;
    out->until = all.max_seconds > 0 ? lw_clock_wall() + all.max_seconds : 0;
    out->stop = all.stop;
    out->force = all.force;
    out->rigid = all.rigid;
    out->compare = !all.once;
    return LW_OK;
}

void lw_surface_notes(lw_note_sink to, const lw_dynamics *d, const lw_dynamics_report *r)
{
    if (to.say)
        lw_dynamics_notes(to, d, r);
}

void lw_surface_report(const lw_dynamics_report *r, lw_simulation_report *out)
{
    *out = (lw_simulation_report){ .formulation = lw_formulation_name(r->formulation), .freedom = r->freedom,
                                   .unknowns = r->unknowns, .redundant = r->redundant, .steps = r->steps,
                                   .refused = r->refused, .evaluations = r->rates, .t = r->t,
                                   .energy_error = r->energy_error, .residual = r->worst_off, .coarse_tolerance = r->coarse.tolerance,
                                   .place_off = r->coarse.place, .turn_off = r->coarse.turn };
    memcpy(out->why, r->why, sizeof out->why);
}
