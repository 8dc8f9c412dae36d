/* cli/motion/clearance.c - read the lists in the options of a sweep. */
#include "cli/motion/clearance.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/suggest.h"
#include "mbs/elastic/contact.h"

/* ---- lists --------------------------------------------------------------------------------------- */

static lw_status add(double **list, int *n, double v, const char *name, lw_error *e)
{
    if (*n == CLI_CLEARANCE_LIST_MAX)
        return lw_error_set(e, LW_E_ARG, "--%s lists more than %d numbers", name, CLI_CLEARANCE_LIST_MAX);
    if ((*n & (*n - 1)) == 0) {                      /* capacity doubles at powers of two */
        double *more = realloc(*list, sizeof **list*(size_t)(*n ? 2**n : 1));
        if (!more)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        *list = more;
    }
    (*list)[(*n)++] = v;
    return LW_OK;
}

static lw_status add_range(double **list, int *n, const double v[3], const char *name, const char *text, lw_error *e)
{
    double count = (v[1] - v[0])/v[2];
    if (!(count >= 0) || count > CLI_CLEARANCE_LIST_MAX)
        return lw_error_set(e, LW_E_ARG, "--%s: '%s' is no range FROM:TO:STEP of at most %d numbers", name, text, CLI_CLEARANCE_LIST_MAX);
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i <= (int)floor(count + 1e-9); i++)
        s = add(list, n, v[0] + i*v[2], name, e);
    return s;
}

/* Read one item: a number or FROM:TO:STEP. */
static lw_status add_item(double **list, int *n, char *item, const char *name, lw_error *e)
{
    static const cli_option real = { .kind = CLI_REAL };
    double v[3];
    int parts = 0;
    char whole[128];
    snprintf(whole, sizeof whole, "%s", item);
    for (char *p = item; p; parts++) {
        char *colon = strchr(p, ':');
        if (colon)
            *colon++ = 0;
        lw_status s = parts < 3 ? cli_value(&real, name, p, &v[parts], e)
                    : lw_error_set(e, LW_E_ARG, "--%s: '%s' has too many colons; a range is FROM:TO:STEP", name, whole);
        if (s != LW_OK)
            return s;
        p = colon;
    }
    if (parts == 2)
        return lw_error_set(e, LW_E_ARG, "--%s: '%s' lacks a step; a range is FROM:TO:STEP", name, whole);
    return parts == 1 ? add(list, n, v[0], name, e) : add_range(list, n, v, name, whole, e);
}

/* Read a list: "80:400:2" (from, to, step), "1e6,1e7", or both mixed. Free with free(). LW_E_ARG with a text. */
static lw_status read_list(const char *name, const char *text, double **list, int *n, lw_error *e)
{
    lw_status s = LW_OK;
    char *copy = strdup(text), *p = copy;
    *list = NULL;
    *n = 0;
    if (!copy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    while (s == LW_OK && p) {
        char *comma = strchr(p, ',');
        if (comma)
            *comma++ = 0;
        s = add_item(list, n, p, name, e);
        p = comma;
    }
    free(copy);
    if (s != LW_OK) {
        free(*list);
        *list = NULL;
    }
    return s;
}

static lw_status list_models(const char *text, lw_clearance_model *list, int *n, lw_error *e)
{
    static const char *const names[] = { "zero", "link", "mlsd", "impact", "hunt-crossley", "lankarani-nikravesh" };
    const int n_name = (int)(sizeof names/sizeof *names);
    *n = 0;
    for (const char *p = text; p; ) {
        size_t size = strcspn(p, ",");
        char word[32];
        snprintf(word, sizeof word, "%.*s", (int)(size < 31 ? size : 31), p);
        lw_clearance_model m = lw_clearance_named(word);
        const char *near = lw_suggest(word, names, n_name);
        if (m == LW_CLEARANCE_NONE)
            return lw_error_set(e, LW_E_ARG, "--model: there is no model of clearance '%s'; %s%s", word,
                                near ? "did you mean " : "they are zero, link, mlsd, impact, hunt-crossley, "
                                "lankarani-nikravesh", near ? near : "");
        if (*n == n_name)
            return lw_error_set(e, LW_E_ARG, "--model lists more than %d models", n_name);
        list[(*n)++] = m;
        p = p[size] ? p + size + 1 : NULL;
    }
    return LW_OK;
}

static lw_status positive(const double *v, int n, bool zero, const char *name, lw_error *e)
{
    for (int i = 0; i < n; i++)
        if (!(v[i] > 0 || (zero && v[i] == 0)))
            return lw_error_set(e, LW_E_ARG, "--%s: %g is out of range: %s", name, v[i], zero ? "0 or more" : "above 0");
    return LW_OK;
}

/* Read the list of an option; empty if the option is not given. */
static lw_status option_list(const char *name, const char *text, bool zero, double **list, int *n, lw_error *e)
{
    *n = 0;
    *list = NULL;
    if (!text)
        return LW_OK;
    lw_status s = read_list(name, text, list, n, e);
    return s == LW_OK ? positive(*list, *n, zero, name, e) : s;
}

lw_status cli_clearance_make(cli_clearance *c, const char *models, const char *stiffness, const char *damping,
                             const char *speeds, lw_error *e)
{
    lw_sweep_options *o = &c->o;
    lw_status s = models ? list_models(models, c->models, &o->n_model, e) : LW_OK;
    if (s == LW_OK)
        s = option_list("stiffness", stiffness, false, &c->stiffness, &o->n_stiffness, e);
    if (s == LW_OK)
        s = option_list("damping", damping, true, &c->damping, &o->n_damping, e);
    if (s == LW_OK && speeds)
        s = read_list("speed", speeds, &c->speed, &o->n_speed, e);
    else if (s == LW_OK)
        s = add(&c->speed, &o->n_speed, c->model->has_speed[0] ? c->model->speed[0]/o->unit : 0, "speed", e);
    o->model = c->models;
    o->stiffness = c->stiffness;
    o->damping = c->damping;
    o->speed = c->speed;
    return s == LW_OK ? lw_sweep_make(c->model, o, &c->sweep, e) : s;
}

void cli_clearance_free(cli_clearance *c)
{
    lw_sweep_free(&c->sweep);
    free(c->stiffness);
    free(c->damping);
    free(c->speed);
}

static void show(void *context, int n_done, int n_run)
{
    cli_progress_show(context, n_done, n_run, NULL);
}

lw_status cli_clearance_run(cli_clearance *c, lw_error *e)
{
    cli_progress progress = cli_progress_begin(c->call, "clearance", "runs");
    c->sweep.o.progress = show;
    c->sweep.o.context = &progress;
    lw_status s = lw_sweep_run(&c->sweep, e);
    cli_progress_end(&progress);
    return s;
}
