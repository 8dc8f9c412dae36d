/* Linkages: made, read, written, asked. */
#include "base/real.h"
#include "surface/surface.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "catalogues/exchange/format.h"
#include "grammar/linkage/sketch.h"
#include "grammar/topology/mechanism.h"
#include "mbs/constraints/mobility.h"

static void put_name(char *to, size_t size, const char *name, char letter, int i)
{
    if (name)
        lw_text_clean(to, size, name);
    else
        snprintf(to, size, "%c%d", letter, i + 1);
}

static lw_status fill(lw_linkage *linkage, int n_link, int ground, int n_joint, const lw_joint_info *joint, int n_input,
                      const lw_input_info *input, int n_tracer, const lw_tracer_info *tracer, lw_error *e)
{
    if (n_link < 1 || n_link > LW_LINK_MAX || n_joint < 0 || n_joint > LW_JOINT_MAX || n_input < 0
        || n_input > LW_INPUT_MAX || n_tracer < 0 || n_tracer > LW_TRACER_MAX)
        return lw_error_set(e, LW_E_ARG, "a linkage has 1 to %d links and up to %d joints, %d inputs and %d tracers",
                            LW_LINK_MAX, LW_JOINT_MAX, LW_INPUT_MAX, LW_TRACER_MAX);
    linkage->n_link = n_link;
    linkage->n_joint = n_joint;
    linkage->n_input = n_input;
    linkage->n_tracer = n_tracer;
    linkage->ground = ground;
    linkage->units = lw_units_si();
    for (int i = 0; i < n_link; i++)
        put_name(linkage->link_name[i], LW_NAME_SIZE, i == ground ? "ground" : NULL, 'L', i);
    for (int i = 0; i < n_joint; i++) {
        const lw_joint_info *from = &joint[i];
        lw_joint *j = &linkage->joint[i];
        bool line = lw_joint_slides(from->kind);
        double length = lw_v2_norm(from->along);
        if (!lw_joint_is_kind(from->kind))
            return lw_error_set(e, LW_E_ARG, "joint %d: its kind is one of r, t, p, g, f", i + 1);
        put_name(j->name, LW_NAME_SIZE, from->name, 'J', i);
        j->kind = (lw_joint_kind)from->kind;
        j->link[0] = from->link[0];
        j->link[1] = from->link[1];
        j->at = from->at;
        j->along = line && length > 0 ? lw_v2_scale(from->along, 1/length) : lw_v2(0, 0);
        j->ratio = lw_joint_has_ratio(from->kind) ? from->ratio : 0;
    }
    for (int i = 0; i < n_tracer; i++) {
        put_name(linkage->tracer[i].name, LW_NAME_SIZE, tracer[i].name, 'P', i);
        linkage->tracer[i].link = tracer[i].link;
        linkage->tracer[i].at = tracer[i].at;
        linkage->tracer[i].angle = tracer[i].angle;
    }
    for (int i = 0; i < n_input; i++)
        linkage->input[i] = (lw_input){ .joint = input[i].joint, .value = isnan(input[i].value) ? 0 : input[i].value,
                                  .first = input[i].first, .last = input[i].last, .ratio = input[i].ratio };
    lw_status s = lw_linkage_check(linkage, e);
    for (int i = 0; i < n_input && s == LW_OK; i++)
        if (isnan(input[i].value))
            linkage->input[i].value = lw_linkage_posture_input(linkage, input[i].joint);
    return s;
}

lw_status lw_linkage_create(int n_link, int ground, int n_joint, const lw_joint_info *joint, int n_input,
                            const lw_input_info *input, int n_tracer, const lw_tracer_info *tracer, lw_linkage **out,
                            lw_error *error)
{
    lw_linkage *k = calloc(1, sizeof *k);
    *out = NULL;
    if (!k)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status s = fill(k, n_link, ground, n_joint, joint, n_input, input, n_tracer, tracer, error);
    if (s == LW_OK)
        *out = k;
    else
        free(k);
    return s;
}

lw_status lw_linkage_parse(const char *text, size_t size, const char *file, const char *format, lw_linkage **out, lw_error *error)
{
    lw_assembly parts;
    *out = NULL;
    lw_linkage *k = calloc(1, sizeof *k);
    if (!k)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status s = lw_format_parse(text, size, file, format, &parts, error);
    if (s == LW_OK)
        s = lw_assembly_linkage(&parts, k, error);
    lw_assembly_free(&parts);
    if (s == LW_OK)
        *out = k;
    else
        free(k);
    return s;
}

static lw_status parse(const char *text, size_t size, const char *file, void *out, lw_error *e)
{
    return lw_linkage_parse(text, size, file, NULL, out, e);
}

lw_status lw_linkage_load(const char *path, lw_linkage **out, lw_error *error)
{
    *out = NULL;
    return lw_surface_load(path, parse, out, error);
}

typedef struct result { int which; lw_linkage **out; } result;

static lw_status parse_result(const char *text, size_t size, const char *file, void *context, lw_error *e)
{
    result *r = context;
    lw_linkage *k = calloc(1, sizeof *k);
    lw_status s = k ? lw_linkage_read_result(text, size, file, r->which, k, e)
                    : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        *r->out = k;
    else
        free(k);
    return s;
}

lw_status lw_linkage_load_result(const char *path, int which, lw_linkage **out, lw_error *error)
{
    result r = { which, out };
    *out = NULL;
    if (which < 1)
        return lw_error_set(error, LW_E_ARG, "results are counted from 1, not %d", which);
    return lw_surface_load(path, parse_result, &r, error);
}

lw_status lw_linkage_copy(const lw_linkage *linkage, lw_linkage **out) { return LW_SURFACE_COPY(linkage, out); }
void      lw_linkage_destroy(lw_linkage *linkage) { free(linkage); }

static lw_status export_bytes(const lw_linkage *linkage, const lw_format *f, lw_bytes *b, lw_error *e)
{
    lw_status s = lw_format_write(f, LW_VIEW(linkage), NULL, b, e);
    if (s != LW_OK)
        lw_bytes_free(b);
    return s;
}

lw_status lw_linkage_export(const lw_linkage *linkage, const char *format, char **out, size_t *size, lw_error *error)
{
    const lw_format *f = lw_format_find(format);
    lw_bytes b = { 0 };
    *out = NULL;
    if (!f || !f->write)
        return lw_error_set(error, LW_E_ARG, "there is no format '%s' to write", format);
    lw_status s = export_bytes(linkage, f, &b, error);
    return s == LW_OK ? lw_surface_give(&b, out, size, error) : s;
}

lw_status lw_model_export(const lw_model *model, const char *format, const lw_plate_options *plates, char **out,
                          size_t *size, lw_error *error)
{
    const lw_format *f = lw_format_find(format);
    lw_bytes b = { 0 };
    lw_export_options o = { .model = model, .clearance = -1 };
    if (plates)
        o = (lw_export_options){ .model = model, .width = plates->width, .thickness = plates->thickness, .hole = plates->hole,
                                 .clearance = plates->clearance };
    *out = NULL;
    if (!f || !f->write)
        return lw_error_set(error, LW_E_ARG, "there is no format '%s' to write", format);
    lw_status s = lw_format_write(f, &model->linkage, &o, &b, error);
    if (s != LW_OK)
        lw_bytes_free(&b);
    return s == LW_OK ? lw_surface_give(&b, out, size, error) : s;
}

lw_status lw_linkage_save(const lw_linkage *linkage, const char *format, const char *path, lw_error *error)
{
    const lw_format *f = format ? lw_format_find(format) : NULL;
    const char *end = strrchr(path, '.');
    lw_bytes b = { 0 };
    for (const lw_format *g = lw_formats; !format && end && g->name && !f; g++)
        if (g->write && strcmp(g->end, end) == 0)
            f = g;
    if (!f || !f->write)
        return lw_error_set(error, LW_E_ARG, "%s '%s' says no format to write", format ? "the name" : "the end of", format ? format : path);
    lw_status s = export_bytes(linkage, f, &b, error);
    if (s == LW_OK)
        s = lw_file_write(path, b.data, b.size, error);
    lw_bytes_free(&b);
    return s;
}

const char *lw_linkage_name(const lw_linkage *linkage) { return linkage->name; }

void lw_linkage_set_name(lw_linkage *linkage, const char *name)
{
    lw_text_clean(linkage->name, sizeof linkage->name, name);
}

/* ---- the parts of a linkage and of a model ------------------------------------------------------------------ */

static lw_status joint_info(const lw_assembly *a, int joint, lw_joint_info *out)
{
    if (joint < 0 || joint >= a->n_joint)
        return LW_E_ARG;
    const lw_joint *j = &a->joint[joint];
    *out = (lw_joint_info){ .name = j->name, .kind = (char)j->kind, .link = { j->link[0], j->link[1] }, .at = j->at,
                            .along = j->along, .ratio = j->ratio };
    return LW_OK;
}

static lw_status input_info(const lw_assembly *a, int input, lw_input_info *out)
{
    if (input < 0 || input >= a->n_input)
        return LW_E_ARG;
    const lw_input *i = &a->input[input];
    *out = (lw_input_info){ .joint = i->joint, .value = i->value, .first = i->first, .last = i->last,
                            .ratio = i->ratio };
    return LW_OK;
}

static lw_status tracer_info_of(const lw_assembly *a, int tracer, lw_tracer_info *out)
{
    if (tracer < 0 || tracer >= a->n_tracer)
        return LW_E_ARG;
    const lw_tracer *t = &a->tracer[tracer];
    *out = (lw_tracer_info){ .name = t->name, .link = t->link, .at = t->at, .angle = t->angle };
    return LW_OK;
}

int lw_linkage_n_link(const lw_linkage *linkage) { return linkage->n_link; }
int lw_linkage_n_joint(const lw_linkage *linkage) { return linkage->n_joint; }
int lw_linkage_n_input(const lw_linkage *linkage) { return linkage->n_input; }
int lw_linkage_n_tracer(const lw_linkage *linkage) { return linkage->n_tracer; }
int lw_linkage_ground(const lw_linkage *linkage) { return linkage->ground; }

int lw_model_n_link(const lw_model *model) { return model->linkage.n_link; }
int lw_model_n_joint(const lw_model *model) { return model->linkage.n_joint; }
int lw_model_n_input(const lw_model *model) { return model->linkage.n_input; }
int lw_model_n_tracer(const lw_model *model) { return model->linkage.n_tracer; }
int lw_model_ground(const lw_model *model) { return model->linkage.ground; }

const char *lw_linkage_link_name(const lw_linkage *linkage, int link)
{
    return link >= 0 && link < linkage->n_link ? linkage->link_name[link] : NULL;
}

const char *lw_model_link_name(const lw_model *model, int link)
{
    return link >= 0 && link < model->linkage.n_link ? model->linkage.link_name[link] : NULL;
}

lw_status lw_linkage_joint(const lw_linkage *linkage, int joint, lw_joint_info *out)
{
    return joint_info(LW_VIEW(linkage), joint, out);
}

lw_status lw_linkage_input(const lw_linkage *linkage, int input, lw_input_info *out)
{
    return input_info(LW_VIEW(linkage), input, out);
}

lw_status lw_linkage_tracer(const lw_linkage *linkage, int tracer, lw_tracer_info *out)
{
    return tracer_info_of(LW_VIEW(linkage), tracer, out);
}

lw_status lw_model_joint(const lw_model *model, int joint, lw_joint_info *out) { return joint_info(&model->linkage, joint, out); }
lw_status lw_model_input(const lw_model *model, int input, lw_input_info *out) { return input_info(&model->linkage, input, out); }
lw_status lw_model_tracer(const lw_model *model, int tracer, lw_tracer_info *out) { return tracer_info_of(&model->linkage, tracer, out); }

lw_status lw_linkage_set_tracer(lw_linkage *linkage, int tracer, const lw_tracer_info *tracer_info, lw_error *error)
{
    lw_tracer before[LW_TRACER_MAX];
    int n = linkage->n_tracer;
    if (tracer < 0 || tracer > n || tracer >= LW_TRACER_MAX)
        return lw_error_set(error, LW_E_ARG, "tracer %d: there are %d, and %d at most", tracer, n, LW_TRACER_MAX);
    memcpy(before, linkage->tracer, sizeof before);
    lw_tracer *t = &linkage->tracer[tracer];
    put_name(t->name, LW_NAME_SIZE, tracer_info->name, 'P', tracer);
    t->link = tracer_info->link;
    t->at = tracer_info->at;
    t->angle = tracer_info->angle;
    linkage->n_tracer = tracer == n ? n + 1 : n;
    lw_status s = lw_linkage_check(linkage, error);
    if (s != LW_OK) {
        memcpy(linkage->tracer, before, sizeof before);
        linkage->n_tracer = n;
    }
    return s;
}

lw_status lw_linkage_mechanism(const lw_linkage *linkage, lw_mechanism **out, lw_error *error)
{
    lw_mechanism m;
    *out = NULL;
    lw_mechanism_clear(&m, linkage->n_link);
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_mechanism_join(&m, linkage->joint[j].link[0], linkage->joint[j].link[1], (char)linkage->joint[j].kind) != LW_OK)
            return lw_error_set(error, LW_E_KIND, "joint %s: links of a chain share one joint at most, and no weld",
                                linkage->joint[j].name);
    m.ground = linkage->ground;
    for (int j = 0; j < m.n_joint; j++)                    /* rising, as inputs of a mechanism are */
        for (int i = 0; i < linkage->n_input; i++) {
            const int *link = linkage->joint[linkage->input[i].joint].link;
            if (lw_mechanism_joint(&m, link[0], link[1]) == j)
                m.input[m.n_input++] = (uint8_t)j;
        }
    if (linkage->n_tracer > 0 && linkage->tracer[0].link != linkage->ground)
        m.output = linkage->tracer[0].link;
    return LW_SURFACE_COPY(&m, out);
}

lw_status lw_linkage_of_mechanism(const lw_mechanism *mechanism, uint64_t seed, lw_linkage **out, lw_error *error)
{
    lw_rng rng;
    lw_linkage *k = calloc(1, sizeof *k);
    *out = NULL;
    if (!k)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_rng_seed(&rng, seed, 0);
    lw_status s = lw_linkage_sketch(mechanism, &rng, k);
    if (s == LW_OK)
        *out = k;
    else
        free(k);
    return s == LW_OK ? s : lw_error_set(error, s, "a linkage needs a ground link, and an output link for its tracer");
}

lw_status lw_linkage_analyse_mobility(const lw_linkage *linkage, double tolerance, uint64_t seed, lw_mobility_info *out, lw_error *error)
{
    lw_mobility_options o = { .tolerance = tolerance, .seed = seed };
    lw_mobility *m = malloc(sizeof *m);
    if (!m)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status s = lw_mobility_find(linkage, &o, m, error);
    if (s == LW_OK)
        *out = (lw_mobility_info){ .kind = lw_mobility_kind_text(m->kind), .count = m->count, .freedom = m->freedom,
                                   .generic = m->generic, .instant = m->instant, .redundant = m->n_redundant,
                                   .driven = m->driven, .idle = m->idle, .residual = m->residual };
    free(m);
    return s;
}
