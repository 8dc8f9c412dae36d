#include "optimise/task/read_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include "base/file.h"
#include "optimise/task/target_internal.h"
#include "optimise/task/target_outline.h"

/* Name of the first element of an XML text, of *n bytes; NULL: there is none. */
static const char *first_element(const char *text, size_t size, size_t *n)
{
    const char *at = text, *end = text + size;
    while (at < end) {
        if (strchr(" \t\r\n\xef\xbb\xbf", *at) && *at) {
            at++;
        } else if (*at != '<' || end - at < 4) {
            return NULL;
        } else if (at[1] == '?' || at[1] == '!') {
            bool comment = memcmp(at, "<!--", 4) == 0;
            while (++at < end && !(*at == '>' && (!comment || memcmp(at - 2, "--", 2) == 0)))
                ;
            at += at < end;
        } else {
            const char *name = ++at;
            while (at < end && !strchr(" \t\r\n/>", *at))
                at++;
            *n = (size_t)(at - name);
            return name;
        }
    }
    return NULL;
}

/* A binary STL: 80 bytes, the number of triangles, 50 bytes for each. */
static bool is_binary_stl(const char *text, size_t size)
{
    const unsigned char *n = (const unsigned char *)text + 80;
    return size >= 84 && size == 84 + 50*((size_t)n[0] | (size_t)n[1] << 8 | (size_t)n[2] << 16 | (size_t)n[3] << 24);
}

lw_status lw_refuse_foreign(const char *text, size_t size, const char *path, lw_error *e)
{
    static const char mesh[] = "a mesh of triangles; export the sketch of the curve as DXF or SVG";
    static const char pixels[] = "a picture of pixels; trace its curve (Inkscape: Path > Trace Bitmap) and save that "
        "as SVG";
    static const struct { const char *bytes; size_t n; const char *what; } rows[] = {
        { "PK\3\4", 4, "a workbook (Excel, LibreOffice) or an archive; save the sheet as CSV" },
        { "\xd0\xcf\x11\xe0", 4, "a workbook of Excel; save the sheet as CSV" },
        { "AC10", 4, "a DWG drawing; save it as DXF" },
        { "AutoCAD Binary DXF", 18, "a binary DXF; save it as DXF text (ASCII)" },
        { "\x1f\x8b", 2, "compressed; unpack it first (an SVGZ is an SVG compressed by gzip)" },
        { "%PDF", 4, "a PDF; save the drawing as SVG or DXF" },
        { "%!PS", 4, "PostScript; save the drawing as SVG or DXF" },
        { "\x89PNG", 4, pixels },
        { "\xff\xd8\xff", 3, pixels },
        { "GIF8", 4, pixels },
        { "ISO-10303-21", 12, "a STEP model; export the sketch of the curve as DXF or SVG" },
        { "SQLite format 3", 15, "a catalogue of linkwright or another database, not a target; 'linkwright catalogue' "
                                 "reads catalogues" },
        { "solid ", 6, mesh }, { "solid\n", 6, mesh }, { "solid\r", 6, mesh }, { "ply\n", 4, mesh }, { "ply\r", 4, mesh },
        { "\xb1\xb2\xb3SolveSpace", 13, "a sketch of SolveSpace; export it as DXF or SVG" }
    }, elements[] = {
        { "mujoco", 6, "a model of MuJoCo (MJCF); linkwright does not read it" },
        { "robot", 5, "a robot in URDF; linkwright does not read it" },
        { "sdf", 3, "a model in SDFormat; linkwright does not read it" }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (size >= rows[i].n && memcmp(text, rows[i].bytes, rows[i].n) == 0)
            return lw_error_at(e, LW_E_NOTATION, path, 0, 0, "this is %s", rows[i].what);
    size_t n = 0;
    const char *element = first_element(text, size, &n);
    for (size_t i = 0; element && i < sizeof elements/sizeof *elements; i++)
        if (n == elements[i].n && memcmp(element, elements[i].bytes, n) == 0)
            return lw_error_at(e, LW_E_NOTATION, path, 0, 0, "this is %s", elements[i].what);
    return is_binary_stl(text, size) ? lw_error_at(e, LW_E_NOTATION, path, 0, 0, "this is %s", mesh) : LW_OK;
}

static bool ends_in(const char *path, const char *end)
{
    size_t n = strlen(path), m = strlen(end);
    return n > m && strcasecmp(path + n - m, end) == 0;
}

lw_target_kind lw_target_kind_of(const char *text, size_t size, const char *path)
{
    size_t at = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (at < size && strchr(" \t\r\n", text[at]) && text[at])
        at++;
    size_t n = size - at, word = 0, line = 0;
    const char *s = text + at;
    if (ends_in(path, ".svg") || (n > 0 && *s == '<'))
        return LW_TARGET_KIND_SVG;
    while (line < n && s[line] != '\n' && s[line] != '\r')
        line++;
    for (word = line; word < n && strchr(" \t\r\n", s[word]) && s[word];)
        word++;
    bool dxf = (line == 1 && *s == '0' && n - word >= 7 && memcmp(s + word, "SECTION", 7) == 0)
            || (line == 3 && memcmp(s, "999", 3) == 0);
    return dxf || ends_in(path, ".dxf") ? LW_TARGET_KIND_DXF : LW_TARGET_KIND_TABLE;
}

/* The curve that a path names behind '#', as in "leg.svg#path10"; NULL: none. If there is a file of the whole
 * name, it is meant. */
static const char *find_curve(const char *path)
{
    const char *hash = strrchr(path, '#');
    return hash && hash > path && access(path, F_OK) != 0 ? hash + 1 : NULL;
}

static lw_status read_text(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_status s = lw_refuse_foreign(text, size, file, e);
    *t = (lw_target){ .n = 0 };
    if (s != LW_OK)
        return s;
    switch (lw_target_kind_of(text, size, file)) {
    case LW_TARGET_KIND_SVG:
        return lw_target_read_svg(text, size, file, o, t, e);
    case LW_TARGET_KIND_DXF:
        return lw_target_read_dxf(text, size, file, o, t, e);
    case LW_TARGET_KIND_TABLE:
        break;
    }
    return lw_target_read(text, size, file, o, t, e);
}

/* With all rows of a table, as they belong to those of other targets. */
static lw_status read_file(const char *path, const lw_target_options *o, lw_target *t, lw_error *e)
{
    char *text = NULL, file[4096];
    size_t size = 0;
    lw_target_options mine = o ? *o : (lw_target_options){ .closed = -1 };
    const char *curve = find_curve(path);
    snprintf(file, sizeof file, "%.*s", curve ? (int)(curve - 1 - path) : (int)strlen(path), path);
    mine.curve = curve ? curve : mine.curve;
    lw_status s = lw_file_read(file, &text, &size, e);
    *t = (lw_target){ .n = 0 };
    if (s == LW_OK && curve && lw_target_kind_of(text, size, file) == LW_TARGET_KIND_TABLE)
        s = lw_error_at(e, LW_E_ARG, file, 0, 0, "'#%s' names a curve of a drawing, but this is a table", curve);
    if (s == LW_OK)
        s = read_text(text, size, file, &mine, t, e);
    free(text);
    return s;
}

lw_status lw_target_read_text(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t,
                              lw_error *e)
{
    lw_status s = read_text(text, size, file, o, t, e);
    if (s == LW_OK)
        lw_target_drop_repeat(t);
    return s;
}

lw_status lw_target_read_file(const char *path, const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_status s = read_file(path, o, t, e);
    if (s == LW_OK)
        lw_target_drop_repeat(t);
    return s;
}

lw_status lw_task_file_beside(const char *path, const char *name, char out[LW_PATH_SIZE], lw_error *e)
{
    const char *slash = strrchr(path, '/');
    int folder = name[0] == '/' || !slash ? 0 : (int)(slash - path) + 1;
    return snprintf(out, LW_PATH_SIZE, "%.*s%s", folder, path, name) < LW_PATH_SIZE ? LW_OK
         : lw_error_at(e, LW_E_IO, path, 0, 0, "the path of a target named in this file is too long");
}

/* Read a target of a task: its own stations, or a file named in it. */
static lw_status read_source(const char *path, const char *name, const lw_target *own, const lw_target_options *o,
                             lw_target *read, const lw_target **part, lw_error *e)
{
    char file[LW_PATH_SIZE];
    *part = own;
    if (!name[0])
        return LW_OK;
    lw_status s = lw_task_file_beside(path, name, file, e);
    *part = read;
    return s == LW_OK ? read_file(file, o, read, e) : s;
}

static lw_status read_target(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t,
                             lw_error *e)
{
    lw_target read[1 + LW_ALSO_MAX], joined;
    const lw_target *part[1 + LW_ALSO_MAX];
    lw_target_options mine = o ? *o : (lw_target_options){ .closed = -1 };
    memset(read, 0, sizeof read);
    if (mine.closed < 0)
        mine.closed = task->closed;
    if (!mine.stations)
        mine.stations = task->resample;
    if (mine.smooth == 0)
        mine.smooth = task->smooth;
    lw_status s = read_source(path, task->target, &task->stations, &mine, &read[0], &part[0], e);
    for (int i = 0; i < task->n_also && s == LW_OK; i++)
        s = read_source(path, task->also[i].target, &task->also[i].stations, &mine, &read[i + 1], &part[i + 1], e);
    if (s == LW_OK && (s = lw_target_join(part, 1 + task->n_also, &joined, e)) == LW_OK) {
        s = lw_task_file_target(task, &joined, t, e);
        lw_target_free(&joined);
        if (s == LW_OK && read[0].note[0])
            memcpy(t->note, read[0].note, sizeof t->note);
        if (s == LW_OK)
            lw_target_drop_repeat(t);
    }
    for (int i = 0; i <= LW_ALSO_MAX; i++)
        lw_target_free(&read[i]);
    return s;
}

lw_status lw_task_file_read_file(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t,
                                 lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = lw_file_read(path, &text, &size, e);
    if (s == LW_OK)
        s = lw_task_file_read(text, size, path, task, e);
    free(text);
    if (s != LW_OK)
        return s;
    s = read_target(path, o, task, t, e);
    if (s != LW_OK && e && !e->file[0])
        snprintf(e->file, sizeof e->file, "%s", path);
    if (s != LW_OK)
        lw_task_file_free(task);
    return s;
}

lw_status lw_task_file_read_text(const char *text, size_t size, const char *file, lw_task_file *task, lw_target *t,
                                 lw_error *e)
{
    lw_status s = lw_task_file_read(text, size, file, task, e);
    if (s != LW_OK)
        return s;
    const char *named = task->target;
    for (int i = 0; i < task->n_also && !named[0]; i++)
        named = task->also[i].target;
    s = named[0] ? lw_error_set(e, LW_E_ARG, "the task names the file %.200s; it must hold its stations itself", named)
                 : read_target(file, NULL, task, t, e);
    if (s != LW_OK)
        lw_task_file_free(task);
    return s;
}
