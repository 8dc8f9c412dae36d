/* cli/fit/fit_spec.c - the conditions of a fit from the options of the command and a task file. */
#include "cli/fit/fit_settings.h"

#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/real.h"

enum { AUTO = 0 };

/* Read one bound such as "r1=5:50". */
static lw_status add_bound(const char *text, size_t n, const lw_units *u, lw_fit_spec *spec, lw_error *e)
{
    static const cli_option range = { .name = "bounds", .kind = CLI_RANGE };
    char word[80], *equals;
    double v[2];
    if (n >= sizeof word)
        n = sizeof word - 1;
    memcpy(word, text, n);
    word[n] = 0;
    equals = strchr(word, '=');
    lw_bound *b = &spec->bound[spec->n_bound];
    if (!equals || equals == word || equals - word >= (long)sizeof b->name)
        return lw_error_set(e, LW_E_ARG, "--bounds takes NAME=MIN:MAX with commas between, as r1=5:50,x0=0:0; '%s' is none", word);
    if (spec->n_bound == (int)(sizeof spec->bound/sizeof *spec->bound))
        return lw_error_set(e, LW_E_ARG, "--bounds takes %d names at most", spec->n_bound);
    *equals = 0;
    lw_status st = cli_value(&range, "bounds", equals + 1, v, e);
    if (st != LW_OK)
        return st;
    bool angle = strncmp(word, "theta", 5) == 0 || strncmp(word, "beta", 4) == 0
              || strncmp(word, "input", 5) == 0 || strncmp(word, "tool", 4) == 0;
    memcpy(b->name, word, strlen(word) + 1);
    b->lo = angle ? v[0] : v[0]*u->metre;
    b->hi = angle ? v[1] : v[1]*u->metre;
    spec->n_bound++;
    return LW_OK;
}

static lw_status read_bounds(const char *text, const lw_units *u, lw_fit_spec *spec, lw_error *e)
{
    lw_status st = LW_OK;
    while (text && *text && st == LW_OK) {
        size_t n = strcspn(text, ",");
        st = add_bound(text, n, u, spec, e);
        text += n + (text[n] == ',');
    }
    return st;
}

/* Does the command line decide this option: it is given, or there is no task file that could give it? */
static bool mine(const cli_call *call, const cli_fit_set *set, const char *option)
{
    return !set->has_task_file || cli_given(&call->parsed, option);
}

/* Read the conditions. Weights and ranges are in the user's unit; everything after this is in SI units. */
static void conditions(const cli_call *call, const cli_fit_set *set, lw_fit_spec *spec)
{
    const cli_fit_settings *s = call->settings;
    double m = set->target.units.metre;
    if (mine(call, set, "weight-path"))
        spec->a = s->weight_path/(m*m);
    if (mine(call, set, "weight-angle"))
        spec->b = s->weight_angle;
    if (mine(call, set, "angle-length"))
        spec->angle_length = s->angle_length*m;
    if (!(spec->b > 0))
        lw_fit_spec_weigh_angles(spec, &set->target, spec->angle_length);
    if (s->crank_only || s->full_turn)
        spec->crank_only = true;
    spec->exclude_drag_link = s->crank_only;
    if (cli_given(&call->parsed, "min-transmission-angle"))
        spec->min_transmission = s->min_transmission*LW_PI/180;
    if (mine(call, set, "max-acceleration")) {
        spec->max_acceleration = s->max_acceleration*m;
        spec->max_slide_acceleration = s->max_acceleration/m;
    }
    if (!lw_task_has_place(spec->task))                           /* the target is an angle: it has no unit of length */
        spec->max_acceleration /= mine(call, set, "max-acceleration") ? m : set->task_file.units.metre;
    if (mine(call, set, "length-range")) {
        spec->length_lo = s->length_range[0]*m;
        spec->length_hi = s->length_range[1]*m;
    }
    if (cli_given(&call->parsed, "length-ratio"))
        spec->length_ratio = s->length_ratio;
    if (cli_given(&call->parsed, "max-size"))
        spec->max_size = s->max_size;
    if (cli_given(&call->parsed, "class-margin"))
        spec->class_margin = s->class_margin;
    if (mine(call, set, "position-range")) {
        spec->position_lo = s->position_range[0]*m;
        spec->position_hi = s->position_range[1]*m;
    }
}

/* Read a length such as 1mm; without a unit in the unit u. */
static lw_status read_tolerance(const char *text, const lw_units *u, double *metres, lw_error *e)
{
    lw_units unit = *u;
    size_t n = strspn(text, "0123456789.eE+-");
    const char *end = text + n + strspn(text + n, " ");
    *metres = 0;
    if ((lw_number_parse(text, n, metres) != LW_OK || !(*metres > 0) || (*end && !lw_units_set_length(&unit, end))))
        return lw_error_set(e, LW_E_ARG, "--tolerance takes a length above 0, as 1mm, not '%s'", text);
    *metres *= unit.metre;
    return LW_OK;
}

/* Which limits are given, so that their defaults do not hold. */
static unsigned limits_given(const cli_call *call, const lw_fit_spec *spec)
{
    static const struct { const char *option; unsigned limit; } of[] = {
        { "min-transmission-angle", LW_LIMIT_TRANSMISSION }, { "length-ratio", LW_LIMIT_RATIO },
        { "max-size", LW_LIMIT_SIZE }, { "class-margin", LW_LIMIT_MARGIN }, { "through-limits", LW_LIMIT_MOTION },
    };
    const cli_fit_settings *s = call->settings;
    if (s->unlimited || s->exact)
        return LW_LIMIT_ALL;
    unsigned given = (spec->min_transmission > 0 ? LW_LIMIT_TRANSMISSION : 0)
                   | (spec->length_ratio > 0 ? LW_LIMIT_RATIO : 0);
    for (size_t i = 0; i < sizeof of/sizeof *of; i++)
        if (cli_given(&call->parsed, of[i].option))
            given |= of[i].limit;
    return given;
}

lw_timing cli_fit_timing(const cli_call *call, const cli_fit_set *set)
{
    const cli_fit_settings *s = call->settings;
    if (!mine(call, set, "timing") && set->task_file.has_timing)
        return set->task_file.spec.timing;
    return s->timing != AUTO ? (lw_timing)(s->timing - 1) : set->target.angle ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
}

lw_status cli_fit_make_spec(const cli_call *call, const cli_fit_set *set, lw_fit_spec *spec, lw_error *e)
{
    const cli_fit_settings *s = call->settings;
    const lw_target *t = &set->target;
    *spec = set->has_task_file ? set->task_file.spec : lw_fit_spec_default();
    if (mine(call, set, "task") || !set->task_file.has_task)
        spec->task = s->task == AUTO ? lw_task_suggested(t) : (lw_task)(s->task - 1);
    spec->timing = cli_fit_timing(call, set);
    spec->datum = (lw_datum[]){ LW_DATUM_FREE, LW_DATUM_FRAME, LW_DATUM_PLANE }[s->datum];
    conditions(call, set, spec);
    if (s->datum != 0 && spec->timing != LW_TIMING_PRESCRIBED)
        return lw_error_set(e, LW_E_ARG, "--angle-from has a meaning with prescribed timing only, and the target has no column angle");
    lw_fit_spec_set_limits(spec, t, limits_given(call, spec) | (set->has_task_file ? set->task_file.limits : 0));
    lw_status st = s->tolerance ? read_tolerance(s->tolerance, &t->units, &spec->tolerance, e) : LW_OK;
    if (st == LW_OK && spec->tolerance > 0 && (!lw_task_has_place(spec->task) || s->unlimited || s->exact))
        st = lw_error_set(e, LW_E_ARG, "--tolerance chooses among linkages by size and by their distance from a path: it "
                          "does not go together with a function, --unlimited or --exact");
    if (st != LW_OK)
        return st;
    st = mine(call, set, "point-links") ? cli_fit_carriers(s->point_links, t, spec->carrier, e) : LW_OK;
    return st == LW_OK ? read_bounds(s->bounds, &t->units, spec, e) : st;
}

/* Check that the names in --type are types. */
static lw_status check_types(const char *types, lw_error *e)
{
    for (const char *at = types; *at;) {
        char word[32] = "";
        size_t n = strcspn(at, ",");
        memcpy(word, at, n < sizeof word ? n : sizeof word - 1);
        if (strcmp(word, "all") != 0 && !lw_type_find(word)) {
            char known[256] = "all";
            for (const lw_type *t = lw_type_table; t->letters; t++)
                snprintf(known + strlen(known), sizeof known - strlen(known), ", %s", t->name);
            return lw_error_set(e, LW_E_ARG, "--type %s: no such type; known are %s", word, known);
        }
        at += n + (at[n] == ',');
    }
    return LW_OK;
}

lw_status cli_fit_read_tolerances(const char *text, const lw_units *u, lw_tolerances *of, lw_error *e)
{
    double *to[2] = { &of->length, &of->clearance };
    const char *at = text;
    for (int i = 0; i < 2 && (i == 0 || *at == ','); i++) {
        lw_units unit = *u;
        char name[8] = "", *end;
        at += i;
        double v = strtod(at, &end);
        size_t n = strcspn(end, ",");
        if (n > 0 && n < sizeof name)
            memcpy(name, end, n);
        if (end == at || !(v >= 0 && v < 1e300) || n >= sizeof name || (n > 0 && !lw_units_set_length(&unit, name)))
            return lw_error_set(e, LW_E_ARG, "--tolerances takes a length and perhaps a clearance, as 0.1mm,0.05mm, not '%s'", text);
        *to[i] = v*unit.metre;
        at = end + n;
    }
    return *at ? lw_error_set(e, LW_E_ARG, "--tolerances takes one or two lengths, not '%s'", text) : LW_OK;
}

/* Is `name` a dimension of one of the types? */
static bool is_dimension(const char *types, const char *name)
{
    if (strcmp(name, "input0") == 0 || strncmp(name, "tool", 4) == 0)
        return true;
    for (const lw_type *t = lw_type_table; t->letters; t++) {
        lw_linkage k;
        lw_plan plan;
        lw_type_linkage(t, &k);
        bool asked = strcmp(types, "all") == 0 || strstr(types, t->name) || strstr(types, t->letters);
        if (asked && lw_plan_make(&k, (lw_plan_options){ .tracers = 1 }, &plan, NULL) == LW_OK
            && lw_plan_dim(&plan, name) >= 0)
            return true;
    }
    return false;
}

lw_status cli_fit_check_conditions(const cli_call *call, lw_error *e)
{
    const cli_fit_settings *s = call->settings;
    lw_fit_spec spec = lw_fit_spec_default();
    lw_units si = lw_units_si();
    lw_status st = check_types(s->type, e);
    if (st == LW_OK)
        st = read_bounds(s->bounds, &si, &spec, e);
    for (int i = 0; i < spec.n_bound && st == LW_OK; i++)
        if (!is_dimension(s->type, spec.bound[i].name))
            st = lw_error_set(e, LW_E_ARG, "--bounds: no linkage of --type %s has a dimension '%s'; the "
                              "table of results shows their names", s->type, spec.bound[i].name);
    if (st == LW_OK && cli_given(&call->parsed, "length-range") && !(s->length_range[1] > 0))
        st = lw_error_set(e, LW_E_ARG, "--length-range %g:%g excludes every linkage: lengths are "
                          "positive", s->length_range[0], s->length_range[1]);
    if (st == LW_OK && !(s->weight_path > 0) && s->task != 2)
        st = lw_error_set(e, LW_E_ARG, "--weight-path must be positive; use --task function to fit angles alone");
    if (st == LW_OK && s->datum != 0 && s->timing > 1)
        st = lw_error_set(e, LW_E_ARG, "--angle-from has a meaning with prescribed timing only");
    return st;
}
