/* studio/files.c - what comes into the page and what leaves it: files, targets, chains, the gallery, exports. */
#include "studio/studio_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "base/real.h"
#include "catalogues/exchange/format.h"
#include "grammar/text/json_internal.h"
#include "linkwright.h"
#include "optimise/task/read_file.h"

/* {}: what the page begins with. */
lw_status studio_begin(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    (void)ask, (void)e;
    lw_bytes_text(&r->body, "{");
    studio_put_text(&r->body, "version", lw_version());
    studio_put_text(&r->body, "file", s->file);
    studio_put_text(&r->body, "text", s->text);
    pthread_mutex_lock(&s->lock);
    studio_put_real(&r->body, "atlas", s->atlas_state);
    pthread_mutex_unlock(&s->lock);
    lw_bytes_text(&r->body, "}\n");
    return LW_OK;
}

/* ---- targets --------------------------------------------------------------------------------------------------- */

static void put_target(lw_bytes *b, const lw_target *t, double unit, bool rows)
{
    const double *x, *y, *theta, *angle;
    size_t n = lw_target_n(t);
    lw_target_stations(t, &x, &y, &theta, &angle);
    studio_put_bool(b, "closed", lw_target_closed(t));
    studio_put_real(b, "length", lw_target_length(t)/unit);
    studio_put_text(b, "note", lw_target_note(t));
    if (x)
        studio_put_reals(b, "x", x, n, 1, unit);
    if (y)
        studio_put_reals(b, "y", y, n, 1, unit);
    if (theta && rows)
        studio_put_reals(b, "theta", theta, n, 1, 1);
    if (angle && rows)
        studio_put_reals(b, "angle", angle, n, 1, 1);
}

/* { text, name, unit, stations, smooth, closed }: stations of a path, in the unit; of a table, of an SVG or DXF drawing,
 * or of what was drawn on the page, which comes as an SVG path. */
lw_status studio_target(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    lw_target *t = NULL;
    lw_units u = lw_units_si();
    char *text;
    size_t size;
    const char *unit = studio_text(ask, "unit", "mm");
    const json_t *closed = json_object_get(ask, "closed");
    lw_target_options o = { .closed = json_is_boolean(closed) ? json_is_true(closed) : -1,
                            .length_unit = studio_bool(ask, "force_unit") ? unit : NULL,
                            .curve = studio_text(ask, "curve", NULL), .stations = (int)studio_real(ask, "stations", 0),
                            .smooth = studio_real(ask, "smooth", 0) };
    (void)s;
    if (!lw_units_set_length(&u, unit))
        return lw_error_set(e, LW_E_ARG, "there is no unit '%.20s'", unit);
    lw_status st = studio_source(ask, "text", &text, &size, e);
    if (st != LW_OK)
        return st;
    st = lw_target_parse(text, size, studio_text(ask, "name", ""), &o, &t, e);
    free(text);
    if (st != LW_OK)
        return st;
    lw_bytes_text(&r->body, "{");
    put_target(&r->body, t, u.metre, true);
    lw_bytes_text(&r->body, "}\n");
    lw_target_destroy(t);
    return st;
}

/* ---- linkages --------------------------------------------------------------------------------------------------- */

static bool is_target(const char *text, const char *name)
{
    const char *dot = strrchr(name, '.');
    const char *const ends[] = { ".csv", ".svg", ".dxf", ".txt" };
    for (int i = 0; dot && i < 4; i++)
        if (strcasecmp(dot, ends[i]) == 0)
            return i < 3 || text[strspn(text, " \t\r\n")] != '{';
    return false;
}

/* Every result of a fit, or one linkage. */
static lw_status put_linkages(lw_bytes *b, const char *text, size_t size, const char *name, lw_error *e)
{
    lw_assembly k = { 0 };
    json_t *all = NULL;
    size_t blank = strspn(text, " \t\r\n\xef\xbb\xbf");
    bool json = text[blank] == '{';
    lw_bytes_text(b, "{");
    studio_put_text(b, "kind", "linkage");
    studio_put_key(b, "linkages");
    lw_bytes_text(b, "[");
    lw_status s = json ? lw_assembly_read_result(text, size, name, 0, &k, e)         /* the first one, with places in messages */
                       : lw_format_parse(text, size, name, NULL, &k, e);
    if (s == LW_OK)
        studio_put_linkage(b, NULL, &k);
    json_error_t fault;
    if (s == LW_OK && json && lw_json_load(text + blank, size - blank, 0, &all, &fault) == LW_E_MEMORY)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    json_t *results = json_object_get(all, "results");
    for (size_t i = 1; s == LW_OK && i < json_array_size(results); i++) {
        char *one = json_dumps(json_object_get(json_array_get(results, i), "linkage"), JSON_COMPACT | JSON_REAL_PRECISION(17));
        lw_assembly_free(&k);
        s = one ? lw_assembly_read_result(one, strlen(one), name, 0, &k, e)
                : lw_error_set(e, LW_E_NOTATION, "result %zu has no linkage", i + 1);
        if (s == LW_OK)
            studio_put_linkage(b, NULL, &k);
        free(one);
    }
    json_decref(all);
    lw_assembly_free(&k);
    lw_bytes_text(b, "]}\n");
    return s;
}

/* { text, name, unit }: what a dropped file holds: linkages as docs/notation.md writes them, or a target. */
lw_status studio_open(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    char *text;
    size_t size;
    const char *name = studio_text(ask, "name", "");
    lw_status st = studio_source(ask, "text", &text, &size, e);
    if (st != LW_OK)
        return st;
    lw_foreign foreign = lw_foreign_kind(text, size);
    if (foreign.what) {
        st = lw_error_at(e, LW_E_NOTATION, name, 0, 0, "this is %s, not a linkage or a target; %s", foreign.what, foreign.advice);
    } else if (is_target(text, name)) {
        lw_target *t = NULL;
        lw_target_options o = { .closed = -1 };
        st = lw_target_parse(text, size, name, &o, &t, e);
        if (st == LW_OK) {
            lw_bytes_text(&r->body, "{");
            studio_put_text(&r->body, "kind", "target");
            studio_put_text(&r->body, "unit", t->units.length[0] ? t->units.length : "m");
            put_target(&r->body, t, t->units.metre, true);
            lw_bytes_text(&r->body, "}\n");
        }
        lw_target_destroy(t);
    } else
        st = put_linkages(&r->body, text, size, name, e);
    (void)s;
    free(text);
    return st;
}

/* {}: the list of known mechanisms; { name }: the file of one.  Only names of the list are read. */
lw_status studio_gallery(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    char path[LW_PATH_SIZE], *text = NULL;
    size_t size, i;
    const char *name = studio_text(ask, "name", NULL);
    const json_t *row;
    json_error_t fault;
    bool known = false;
    if (!s->gallery)
        return lw_error_set(e, LW_E_IO, "the gallery is not installed");
    snprintf(path, sizeof path, "%s/index.json", s->gallery);
    lw_status st = lw_file_read(path, &text, &size, e);
    json_t *list = NULL;
    if (st == LW_OK)
        st = lw_json_load(text, size, 0, &list, &fault);
    json_array_foreach(list, i, row)
        known = known || (name && strcmp(name, studio_text(row, "name", "")) == 0);
    json_decref(list);
    if (st == LW_OK && name) {
        free(text);
        text = NULL;
        snprintf(path, sizeof path, "%s/%s.json", s->gallery, known ? name : "");
        st = known ? lw_file_read(path, &text, &size, e) : lw_error_set(e, LW_E_ARG, "the gallery has no \"%.60s\"", name);
    }
    if (st == LW_OK)
        lw_bytes_add(&r->body, text, size);
    free(text);
    return st;
}

/* ---- chains to build from ---------------------------------------------------------------------------------------- */

typedef struct chain_list { lw_bytes *b; int n; } chain_list;

static lw_status put_mechanism(void *context, const lw_mechanism *m)
{
    chain_list *list = context;
    char *json = NULL;
    lw_error e;
    lw_picture *picture = NULL;
    char *svg = NULL;
    size_t size;
    const char *caption = NULL;
    if (list->n++ >= 400)
        return LW_STOPPED;
    lw_status s = lw_mechanism_to_text(m, "json", &json, &e);
    if (s == LW_OK)
        s = lw_picture_of_mechanisms(1, &m, &caption, 1, NULL, &picture, &e);
    if (s == LW_OK)
        s = lw_picture_write(picture, "svg", 160, 120, &svg, &size, &e);
    if (s == LW_OK) {
        studio_put_key(list->b, NULL);
        lw_bytes_text(list->b, "{");
        studio_put_text(list->b, "mechanism", json);
        studio_put_text(list->b, "picture", svg);
        lw_bytes_text(list->b, "}");
    }
    lw_picture_destroy(picture);
    lw_free(svg);
    lw_free(json);
    return s;
}

static lw_status put_chain(void *context, const lw_chain *chain)
{
    lw_mechanism *m = NULL;
    lw_choices choices = lw_choices_default();
    choices.inputs = 1;
    choices.output = true;
    lw_status s = lw_mechanism_of_chain(chain, &m);
    if (s == LW_OK)
        s = lw_enumerate_mechanisms(m, &choices, put_mechanism, context, NULL, NULL);
    lw_mechanism_destroy(m);
    return s;
}

/* { links }: mechanisms of pins with so many links, each choice of ground, input and output once, with a picture. */
lw_status studio_chains(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    int links = (int)studio_real(ask, "links", 4);
    lw_enumeration what = lw_enumeration_default(links, 1);
    chain_list list = { &r->body, 0 };
    what.jobs = 1;
    (void)s;
    if (links != 4 && links != 6 && links != 8)
        return lw_error_set(e, LW_E_ARG, "chains of 4, 6 or 8 links");
    lw_bytes_text(&r->body, "{");
    studio_put_key(&r->body, "mechanisms");
    lw_bytes_text(&r->body, "[");
    lw_status st = lw_enumerate_chains(&what, put_chain, &list, e);
    lw_bytes_text(&r->body, "]}\n");
    return st == LW_STOPPED ? LW_OK : st;
}

/* { mechanism, seed, unit, size, at }: a linkage of this topology that closes, of about this size, in the unit. */
lw_status studio_chain_linkage(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    const char *text = studio_text(ask, "mechanism", "");
    lw_mechanism *m = NULL;
    lw_linkage *k = NULL;
    double size = studio_real(ask, "size", 100);
    lw_units u = lw_units_si();
    (void)s;
    lw_units_set_length(&u, studio_text(ask, "unit", "mm"));
    lw_units_set_angle(&u, "deg");
    lw_status st = lw_mechanism_from_text(text, strlen(text), "json", &m, e);
    if (st == LW_OK)
        st = lw_linkage_of_mechanism(m, (uint64_t)fabs(studio_real(ask, "seed", 1)), &k, e);
    if (st == LW_OK) {
        lw_vec2 least = { INFINITY, INFINITY }, most = { -INFINITY, -INFINITY };
        for (int i = 0; i < k->n_joint; i++) {
            lw_vec2 p = k->joint[i].at;
            least = (lw_vec2){ fmin(least.x, p.x), fmin(least.y, p.y) };
            most = (lw_vec2){ fmax(most.x, p.x), fmax(most.y, p.y) };
        }
        double scale = size*u.metre/fmax(hypot(most.x - least.x, most.y - least.y), 1e-300);
        lw_linkage_lay(k, false, 0, scale, (lw_vec2){ -scale*(least.x + most.x)/2, -scale*(least.y + most.y)/2 });
        k->units = u;
        lw_bytes_text(&r->body, "{");
        studio_put_linkage(&r->body, "linkage", LW_VIEW(k));
        lw_bytes_text(&r->body, "}\n");
    }
    lw_linkage_destroy(k);
    lw_mechanism_destroy(m);
    return st;
}

/* ---- take away ----------------------------------------------------------------------------------------------------- */

static const struct { const char *format, *type; bool picture; } formats[] = {
    { "json", "application/json", false },  { "svg", "image/svg+xml", true },    { "pdf", "application/pdf", true },
    { "png", "image/png", true },           { "gif", "image/gif", true },        { "html", "text/html", true },
    { "dxf", "image/vnd.dxf", false },      { "scad", "text/plain", false },     { "mjcf", "application/xml", false },
    { "poses", "text/csv", false },         { "step", "model/step", false },     { "stl", "model/stl", false },
    { "urdf", "application/xml", false },   { "sdf", "application/xml", false }, { "adams", "text/plain", false },
    { "slvs", "text/plain", false },        { "pyslvs", "text/plain", false },   { "pmks", "text/plain", false },
    { "motiongen", "application/json", false },
};

static lw_status export_picture(const json_t *ask, const lw_model *m, const char *format, char **out, size_t *size, lw_error *e)
{
    lw_picture *p = NULL;
    lw_target *t = NULL;
    char *text = NULL;
    size_t n;
    if (json_object_get(ask, "target") && studio_source(ask, "target", &text, &n, NULL) == LW_OK)
        lw_target_parse(text, n, NULL, NULL, &t, NULL);
    free(text);
    lw_status s = lw_model_linkage(m) ? lw_picture_of_linkage(lw_model_linkage(m), t, NULL, &p, e)
                                      : lw_picture_of_model(m, t, NULL, &p, e);
    if (s == LW_OK)
        s = lw_picture_write(p, format, 0, 0, out, size, e);
    lw_picture_destroy(p);
    lw_target_destroy(t);
    return s;
}

/* { linkage, format, target }: the bytes of a file.  The JSON of a linkage goes out as the page holds it, with masses and
 * all. */
lw_status studio_export(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    const char *format = studio_text(ask, "format", "");
    size_t i = 0, n = sizeof formats/sizeof *formats, size = 0;
    char *text, *out = NULL;
    lw_model *m = NULL;
    (void)s;
    while (i < n && strcmp(formats[i].format, format) != 0)
        i++;
    if (i == n)
        return lw_error_set(e, LW_E_ARG, "there is no format '%.20s'", format);
    lw_status st = studio_source(ask, "linkage", &text, &size, e);
    if (st != LW_OK)
        return st;
    st = lw_model_parse(text, size, NULL, &m, e);
    if (st == LW_OK && strcmp(format, "json") == 0) {
        out = text;
        text = NULL;
    } else if (st == LW_OK && formats[i].picture)
        st = export_picture(ask, m, format, &out, &size, e);
    else if (st == LW_OK)
        st = lw_model_export(m, format, NULL, &out, &size, e);
    if (st == LW_OK) {
        r->type = formats[i].type;
        lw_bytes_add(&r->body, out, size);
    }
    lw_free(out);
    free(text);
    lw_model_destroy(m);
    return st;
}
