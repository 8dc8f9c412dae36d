/* cli/draw/convert.c - the table of formats. */
#include "cli/draw/convert.h"

#include <stdlib.h>
#include <string.h>
#include "catalogues/exchange/adams.h"
#include "catalogues/exchange/export.h"
#include "cli/program/model.h"
#include "grammar/pmks.h"
#include "grammar/pyslvs.h"

static bool begins_with(const cli_text *t, const char *word)
{
    size_t at = strspn(t->text, " \t\r\n");
    return strncmp(t->text + at, word, strlen(word)) == 0;
}

static lw_status print(FILE *f, char *text)
{
    if (!text)
        return LW_E_MEMORY;
    fputs(text, f);
    free(text);
    return LW_OK;
}

/* ---- JSON ---------------------------------------------------------------------------------------- */

static bool begins_json(const cli_text *t) { return begins_with(t, "{"); }

static lw_status read_json(cli_text *t, lw_linkage *k, lw_error *e)
{
    return cli_linkage_text(t->path, t->result, &t->text, &t->size, k, e);
}

static lw_status write_json(const lw_linkage *k, FILE *f, lw_error *e)
{
    lw_status s = print(f, lw_linkage_write(k, 2));
    return s == LW_OK ? s : lw_error_set(e, s, "out of memory for a linkage");
}

/* ---- Pyslvs ---------------------------------------------------------------------------------------- */

static bool begins_pyslvs(const cli_text *t) { return begins_with(t, "M[") || begins_with(t, "#"); }

static lw_status read_pyslvs(cli_text *t, lw_linkage *k, lw_error *e)
{
    return lw_pyslvs_read(t->text, t->size, t->path, &t->units, k, e);
}

static lw_status write_pyslvs(const lw_linkage *k, FILE *f, lw_error *e)
{
    char *text = lw_pyslvs_write(k, e);
    return text ? print(f, text) : e->status;
}

/* ---- PMKS ------------------------------------------------------------------------------------------ */

static bool begins_pmks(const cli_text *t) { return t->size > 0; }

static lw_status read_pmks(cli_text *t, lw_linkage *k, lw_error *e)
{
    return lw_pmks_read(t->text, t->size, t->path, &t->units, k, e);
}

static lw_status write_pmks(const lw_linkage *k, FILE *f, lw_error *e)
{
    char *text = lw_pmks_write(k, e);
    return text ? print(f, text) : e->status;
}

/* ---- files for other programs ------------------------------------------------------------------------ */

static lw_status write_bytes(lw_status (*export)(const lw_linkage *k, lw_bytes *out, lw_error *e), const lw_linkage *k,
                             FILE *f, lw_error *e)
{
    lw_bytes b = { 0 };
    lw_status s = export(k, &b, e);
    if (s == LW_OK)
        fwrite(b.data, 1, b.size, f);
    lw_bytes_free(&b);
    return s;
}

static lw_status write_mjcf(const lw_linkage *k, FILE *f, lw_error *e) { return write_bytes(lw_export_mjcf, k, f, e); }

static lw_status write_adams(const lw_linkage *k, FILE *f, lw_error *e)
{
    return write_bytes(lw_export_adams, k, f, e);
}

static lw_status write_acf(const lw_linkage *k, FILE *f, lw_error *e)
{
    return write_bytes(lw_export_adams_commands, k, f, e);
}

static lw_status write_dxf(const lw_linkage *k, FILE *f, lw_error *e) { return write_bytes(lw_export_dxf, k, f, e); }

static lw_status write_scad(const lw_linkage *k, FILE *f, lw_error *e)
{
    return write_bytes(lw_export_openscad, k, f, e);
}

static lw_status write_slvs(const lw_linkage *k, FILE *f, lw_error *e)
{
    return write_bytes(lw_export_solvespace, k, f, e);
}

static lw_status write_svg(const lw_linkage *k, FILE *f, lw_error *e) { return write_bytes(lw_export_svg, k, f, e); }

static lw_status write_poses(const lw_linkage *k, FILE *f, lw_error *e)
{
    return write_bytes(lw_export_poses, k, f, e);
}

static lw_status write_joints(const lw_linkage *k, FILE *f, lw_error *e)
{
    return write_bytes(lw_export_joints, k, f, e);
}

/* A title may say anything; a line with a statement decides. */
static bool begins_adams(const cli_text *t)
{
    return strncmp(t->text, "ADAMS/", 6) == 0 || strstr(t->text, "\nPART/") || strstr(t->text, "\nUNITS/");
}

static lw_status read_adams(cli_text *t, lw_linkage *k, lw_error *e)
{
    return lw_adams_read(t->text, t->size, t->path, k, e);
}

const cli_format cli_formats[] = {
    { "json", "linkages of linkwright, and the results of fit", ".json", begins_json, read_json, write_json },
    { "pyslvs", "the mechanism expression of Pyslvs", ".pyslvs", begins_pyslvs, read_pyslvs, write_pyslvs },
    { "adams", "a dataset of ADAMS/Solver", ".adm", begins_adams, read_adams, write_adams },
    { "pmks", "the joint table of PMKS", ".txt", begins_pmks, read_pmks, write_pmks },
    { "mjcf", "a model of MuJoCo", ".xml", NULL, NULL, write_mjcf },
    { "acf", "the commands that run a dataset in ADAMS/Solver", ".acf", NULL, NULL, write_acf },
    { "dxf", "plates to cut, DXF R12", ".dxf", NULL, NULL, write_dxf },
    { "scad", "plates in layers, OpenSCAD", ".scad", NULL, NULL, write_scad },
    { "slvs", "a sketch of SolveSpace", ".slvs", NULL, NULL, write_slvs },
    { "svg", "the tracers' curves as SVG paths", ".svg", NULL, NULL, write_svg },
    { "poses", "place and turn of each link over the motion, CSV", ".csv", NULL, NULL, write_poses },
    { "motiongen", "joints, links, actuators, curves in the style of MotionGen", "", NULL, NULL, write_joints },
    { .name = NULL }
};
