#include "catalogues/exchange/format.h"

#include <stdlib.h>
#include <string.h>
#include "catalogues/exchange/adams.h"
#include "catalogues/exchange/export.h"
#include "grammar/linkage/pmks.h"
#include "grammar/linkage/pyslvs.h"

static bool begins_with(const char *text, const char *word)
{
    return strncmp(text + strspn(text, " \t\r\n"), word, strlen(word)) == 0;
}

/* Append a text and free it. text NULL: return e's status, or LW_E_MEMORY if e is not set. */
static lw_status add(lw_bytes *out, char *text, lw_error *e)
{
    if (!text)
        return e && e->status < 0 ? e->status : LW_E_MEMORY;
    lw_bytes_text(out, text);
    free(text);
    return lw_bytes_end(out, e);
}

static bool begins_json(const char *text) { return begins_with(text, "{"); }

static lw_status read_json(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e)
{
    (void)units;
    return lw_assembly_read_result(text, size, file, 0, linkage, e);
}

static lw_status write_json(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    (void)o;
    char *text = lw_assembly_write(linkage, 2);
    return text ? add(out, text, e) : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
}

static bool begins_pyslvs(const char *text) { return begins_with(text, "M[") || begins_with(text, "#"); }
static bool begins_pmks(const char *text) { return text[0] != 0; }

/* A title may be any text; the first line that is a statement decides. */
static bool begins_adams(const char *text)
{
    return strncmp(text, "ADAMS/", 6) == 0 || strstr(text, "\nPART/") || strstr(text, "\nUNITS/");
}

static lw_status write_pyslvs(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    (void)o;
    lw_error own = { .status = LW_OK };
    return add(out, lw_pyslvs_write(linkage, e ? e : &own), e ? e : &own);
}

static lw_status write_pmks(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    (void)o;
    lw_error own = { .status = LW_OK };
    return add(out, lw_pmks_write(linkage, e ? e : &own), e ? e : &own);
}

static lw_status read_adams(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e)
{
    (void)units;
    return lw_adams_read(text, size, file, linkage, e);
}

const lw_format lw_formats[] = {
    { "json", ".json", begins_json, read_json, write_json, false, NULL },
    { "pyslvs", ".pyslvs", begins_pyslvs, lw_pyslvs_read, write_pyslvs, false, NULL },
    { "adams", ".adm", begins_adams, read_adams, lw_export_adams, true, lw_export_space_adams },
    { "pmks", ".txt", begins_pmks, lw_pmks_read, write_pmks, false, NULL },
    { "mjcf", ".xml", NULL, NULL, lw_export_mjcf, true, lw_export_space_mjcf },
    { "urdf", ".urdf", NULL, NULL, lw_export_urdf, true, NULL },
    { "sdf", ".sdf", NULL, NULL, lw_export_sdf, true, NULL },
    { "acf", ".acf", NULL, NULL, lw_export_adams_commands, true, lw_export_space_adams_commands },
    { "dxf", ".dxf", NULL, NULL, lw_export_dxf, false, NULL },
    { "scad", ".scad", NULL, NULL, lw_export_openscad, false, NULL },
    { "step", ".step", NULL, NULL, lw_export_step, false, NULL },
    { "stl", ".stl", NULL, NULL, lw_export_stl, false, NULL },
    { "slvs", ".slvs", NULL, NULL, lw_export_solvespace, false, NULL },
    { "svg", ".svg", NULL, NULL, lw_export_svg, false, NULL },
    { "poses", ".csv", NULL, NULL, lw_export_poses, false, NULL },
    { "motiongen", "", NULL, NULL, lw_export_joints, false, NULL },
    { .name = NULL }
};

const lw_format *lw_format_find(const char *name)
{
    for (const lw_format *f = lw_formats; f->name; f++)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}

lw_status lw_format_parse(const char *text, size_t size, const char *file, const char *format, lw_assembly *parts, lw_error *e)
{
    const lw_format *f = format ? lw_format_find(format) : lw_formats;
    lw_units units = lw_units_si();
    lw_units_set_angle(&units, "deg");                       /* what other programs write */
    *parts = (lw_assembly){ 0 };
    if (!f || !f->read)
        return lw_error_set(e, LW_E_ARG, "there is no format '%s' to read", format);
    char *copy = malloc(size + 1);                           /* with a terminator, to be looked at */
    if (!copy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(copy, text, size);
    copy[size] = 0;
    for (const lw_format *g = lw_formats; !format && g->name; g++)
        if (g->read && g->begins(copy)) {
            f = g;
            break;
        }
    lw_status s = f->read(copy, size, file, &units, parts, e);
    free(copy);
    return s;
}

lw_status lw_format_write(const lw_format *f, const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    const lw_model *m = f->loads && o ? o->model : NULL;
    const char *what = !m ? NULL : m->n_contact ? "contacts" : m->n_rope && f->write != lw_export_mjcf ? "ropes" : m->n_elastic ? "elastic links" : NULL;
    if (what)
        return lw_error_set(e, LW_E_KIND, "the model has %s, which are not written to %s: take them out of a copy of "
                            "the file to export the rest", what, f->name);
    lw_status s = m ? lw_export_states(&m->states, f->name, e) : LW_OK;
    if (s != LW_OK)
        return s;
    for (int j = 0; j < linkage->n_joint && f->write != write_json && !f->write_space; j++)
        if (lw_joint_freedoms(linkage->joint[j].kind) == 3)
            return lw_error_set(e, LW_E_KIND, "joint '%s' leaves its link free, which has no form in %s", linkage->joint[j].name, f->name);
    return f->write(linkage, o, out, e);
}

lw_status lw_format_write_space(const lw_format *f, const lw_spatial *m, lw_bytes *out, lw_error *e)
{
    if (f->write_space)
        return f->write_space(m, out, e);
    return lw_error_set(e, LW_E_KIND, "%s holds planar linkages only; mjcf and adams hold spatial models like this one", f->name);
}
