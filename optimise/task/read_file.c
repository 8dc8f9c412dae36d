#include "optimise/task/read_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include "base/file.h"
#include "optimise/task/target_internal.h"
#include "optimise/task/target_outline.h"
#include "optimise/task/target_tour.h"

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

/* A part of a text, which need not end with a 0. */
typedef struct span { const char *at; size_t n; } span;

/* Cut the first line, or what is left of it behind spaces, off a text; false: there is none. */
static bool next_line(span *text, span *line)
{
    if (text->n == 0)
        return false;
    size_t n = 0, first = 0;
    while (n < text->n && !strchr("\n\r", text->at[n] ? text->at[n] : ' '))
        n++;
    while (first < n && (text->at[first] == ' ' || text->at[first] == '\t'))
        first++;
    *line = (span){ text->at + first, n - first };
    text->at += n + (n < text->n);
    text->n -= n + (n < text->n);
    return true;
}

/* Number of the first bytes that are among those of `set`. */
static size_t count_of(span s, const char *set)
{
    size_t n = 0;
    while (n < s.n && s.at[n] && strchr(set, s.at[n]))
        n++;
    return n;
}

static span past(span s, size_t n)
{
    return (span){ s.at + n, s.n - n };
}

static bool begins(span s, const char *with)
{
    size_t n = strlen(with);
    return s.n >= n && memcmp(s.at, with, n) == 0;
}

/* A Wavefront OBJ: comments (#) and lines that name objects and materials, then a vertex: v X Y Z. */
static bool is_obj(span text)
{
    static const char *const before[] = { "mtllib ", "usemtl ", "o ", "g ", "s " };
    span line;
    while (next_line(&text, &line)) {
        size_t i = 0;
        if (begins(line, "v "))
            return count_of(past(line, 1 + count_of(past(line, 1), " ")), "+-.0123456789") > 0;
        while (i < sizeof before/sizeof *before && !begins(line, before[i]))
            i++;
        if (line.n > 0 && line.at[0] != '#' && i == sizeof before/sizeof *before)
            return false;
    }
    return false;
}

/* An IGES file: lines of 80 columns, of which column 73 has the letter of the section, S at first, and the last seven its number. */
static bool is_iges(span text)
{
    return text.n >= 80 && !memchr(text.at, '\n', 80) && text.at[72] == 'S' && count_of(past(text, 73), " 0") == 6 && text.at[79] == '1';
}

/* G-code (ISO 6983): % and a number of the program, comments in brackets or behind ';', then a word such as G21, N10 G0 or M82. */
static bool is_g_code(span text)
{
    static const char digits[] = "0123456789.";
    span line;
    while (next_line(&text, &line)) {
        if (line.n > 0 && strchr("NO", line.at[0] ? line.at[0] : ' ') && count_of(past(line, 1), digits) > 0) {
            line = past(line, 1 + count_of(past(line, 1), digits));
            line = past(line, count_of(line, " "));
        }
        if (line.n == 0 || strchr(";(%", line.at[0] ? line.at[0] : ' '))
            continue;
        size_t n = count_of(past(line, 1), digits);
        return strchr("GMT", line.at[0] ? line.at[0] : ' ') && n > 0 && (line.n == 1 + n || count_of(past(line, 1 + n), " \t;(FGMNSTXYZ") > 0);
    }
    return false;
}

#define DRAW_IT "export the sketch of the curve as DXF or SVG"
#define MESH   { "a mesh of triangles", DRAW_IT, LW_FOREIGN_CURVE }
#define PIXELS { "a picture of pixels", "trace its curve (Inkscape: Path > Trace Bitmap) and save that as SVG", LW_FOREIGN_CURVE }

lw_foreign lw_foreign_kind(const char *text, size_t size)
{
    static const struct { size_t at; const char *bytes; size_t n; lw_foreign is; } rows[] = {
        { 0, "PK\3\4", 4, { "a workbook (Excel, LibreOffice) or an archive", "save the sheet as CSV", LW_FOREIGN_TABLE } },
        { 0, "\xd0\xcf\x11\xe0", 4, { "a workbook of Excel", "save the sheet as CSV", LW_FOREIGN_TABLE } },
        { 0, "AC10", 4, { "a DWG drawing", "save it as DXF", LW_FOREIGN_CURVE } },
        { 0, "AutoCAD Binary DXF", 18, { "a binary DXF", "save it as DXF text (ASCII)", LW_FOREIGN_CURVE } },
        { 0, "\x1f\x8b", 2, { "a compressed file", "unpack it first (an SVGZ is an SVG compressed by gzip)", LW_FOREIGN_ANY } },
        { 0, "%PDF", 4, { "a PDF", "save the drawing as SVG or DXF", LW_FOREIGN_CURVE } },
        { 0, "%!PS", 4, { "a PostScript file", "save the drawing as SVG or DXF", LW_FOREIGN_CURVE } },
        { 0, "\x89PNG", 4, PIXELS }, { 0, "\xff\xd8\xff", 3, PIXELS }, { 0, "GIF8", 4, PIXELS }, { 0, "II*\0", 4, PIXELS }, { 0, "MM\0*", 4, PIXELS },
        { 8, "WEBP", 4, PIXELS }, { 4, "ftypheic", 8, PIXELS }, { 4, "ftypavif", 8, PIXELS }, { 6, "\0\0\0\0\x36\0\0\0", 8, PIXELS },
        { 0, "ISO-10303-21", 12, { "a STEP model", DRAW_IT, LW_FOREIGN_CURVE } },
        { 0, "SQLite format 3", 15, { "a catalogue of linkwright or another database", "'linkwright catalogue' reads catalogues", LW_FOREIGN_ANY } },
        { 0, "solid ", 6, MESH }, { 0, "solid\n", 6, MESH }, { 0, "solid\r", 6, MESH }, { 0, "ply\n", 4, MESH }, { 0, "ply\r", 4, MESH },
        { 0, "\xb1\xb2\xb3SolveSpace", 13, { "a sketch of SolveSpace", "export it as DXF or SVG", LW_FOREIGN_CURVE } }
    }, elements[] = {
        { 0, "mujoco", 6, { "a model of MuJoCo (MJCF)", "linkwright does not read it", LW_FOREIGN_ANY } },
        { 0, "robot", 5, { "a robot in URDF", "linkwright does not read it", LW_FOREIGN_ANY } },
        { 0, "sdf", 3, { "a model in SDFormat", "linkwright does not read it", LW_FOREIGN_ANY } },
        { 0, "html", 4, { "a web page", "linkwright writes pages and does not read them", LW_FOREIGN_ANY } }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (size >= rows[i].at + rows[i].n && memcmp(text + rows[i].at, rows[i].bytes, rows[i].n) == 0)
            return rows[i].is;
    size_t n = 0;
    const char *element = first_element(text, size, &n);
    for (size_t i = 0; element && i < sizeof elements/sizeof *elements; i++)
        if (n == elements[i].n && memcmp(element, elements[i].bytes, n) == 0)
            return elements[i].is;
    span all = { text, size };
    return is_binary_stl(text, size) || is_obj(all) ? (lw_foreign)MESH
         : is_iges(all) ? (lw_foreign){ "an IGES model", DRAW_IT, LW_FOREIGN_CURVE }
         : is_g_code(all) ? (lw_foreign){ "a G-code program", "save the drawing that it was made from as DXF or SVG", LW_FOREIGN_CURVE }
         : (lw_foreign){ .what = NULL };
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
    lw_foreign foreign = lw_foreign_kind(text, size);
    *t = (lw_target){ .n = 0 };
    if (foreign.what)
        return lw_error_at(e, LW_E_NOTATION, file, 0, 0, "this is %s, not a target; %s", foreign.what, foreign.advice);
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

lw_status lw_target_read_text(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e)
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

static lw_status read_target(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t, lw_error *e)
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
        if (s == LW_OK && !task->target[0])
            s = lw_target_look_at_order(t, mine.closed, e);
        if (s == LW_OK)
            lw_target_drop_repeat(t);
    }
    for (int i = 0; i <= LW_ALSO_MAX; i++)
        lw_target_free(&read[i]);
    return s;
}

lw_status lw_task_file_read_file(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t, lw_error *e)
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

lw_status lw_task_file_read_text(const char *text, size_t size, const char *file, lw_task_file *task, lw_target *t, lw_error *e)
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
