/* What kind of file is this?  Bridge to jansson. */
#include "cli/program/file_kind.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include "base/file.h"
#include "cli/program/command.h"
#include "grammar/model/spatial.h"
#include "grammar/text/json_internal.h"
#include "grammar/topology/notation.h"
#include "optimise/task/read_file.h"

bool cli_is_target(const char *text, size_t size)
{
    lw_target t;
    if (lw_target_read(text, size, "", NULL, &t, NULL) != LW_OK)
        return false;
    lw_target_free(&t);
    return true;
}

bool cli_can_read_again(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISREG(st.st_mode);
}

bool cli_is_catalogue(const char *path)
{
    static const char first[2][16] = { "SQLite format 3", { 0 } };      /* zeros: its first transaction was cut off, and SQLite puts it right */
    char head[16];
    FILE *f = cli_can_read_again(path) ? fopen(path, "rb") : NULL;
    bool read = f && fread(head, sizeof head, 1, f) == 1;
    bool is = read && (memcmp(head, first[0], sizeof head) == 0 || memcmp(head, first[1], sizeof head) == 0);
    if (f)
        fclose(f);
    return is;
}

/* ---- kinds of files ------------------------------------------------------------------------------- */

static cli_kind_of_file kind_of_json(const char *text, size_t size)
{
    json_error_t fault;
    json_t *root;
    lw_json_load(text, size, JSON_DISABLE_EOF_CHECK, &root, &fault);
    const json_t *joints = json_object_get(root, "joints");
    cli_kind_of_file kind = json_is_array(json_object_get(root, "results")) ? CLI_RESULTS
                          : json_object_get(root, "linkwright-task") ? CLI_TASK
                          : json_is_object(json_object_get(root, "model")) ? CLI_MASTER
                          : json_object_get(root, "linkwright-cycle") ? CLI_CYCLE
                          : json_is_object(json_object_get(root, "servo")) ? CLI_SERVO
                          : !joints ? CLI_UNKNOWN : json_is_array(json_array_get(joints, 0)) ? CLI_TOPOLOGIES
                              : CLI_LINKAGE;
    json_decref(root);
    return kind;
}

/* Is more than a byte in twenty no part of a text?  A few such bytes are errors in a text, whose places its reader tells. */
static bool is_binary(const char *text, size_t size)
{
    size_t n = size < 65536 ? size : 65536, odd = 0;
    for (size_t i = 0; i < n; i++)
        odd += (unsigned char)text[i] < ' ' && !strchr("\t\n\v\f\r", text[i] ? text[i] : 1);
    return 20*odd > n;
}

static cli_kind_of_file kind_of_text(const char *text, size_t size, const char *path)
{
    static lw_mechanism m;
    if (size >= 15 && memcmp(text, "SQLite format 3", 15) == 0)
        return CLI_CATALOGUE;
    if (lw_foreign_kind(text, size).what)
        return CLI_BINARY;
    if (is_binary(text, size))
        return CLI_BINARY;
    if (strlen(text) < size)                     /* what its reader says of the byte 0 tells more */
        return CLI_UNKNOWN;
    if (text[strspn(text, " \t\r\n")] == '{')
        return lw_spatial_text(text, size) ? CLI_SPATIAL : kind_of_json(text, size);
    if (text[0] == '<' && strstr(text, "<graphml"))
        return CLI_TOPOLOGIES;
    if (lw_target_kind_of(text, size, path) != LW_TARGET_KIND_TABLE)
        return CLI_DRAWING;
    if (cli_is_target(text, size))
        return CLI_TARGET;
    if (strncmp(text, "M[", 2) == 0 || strncmp(text, "ADAMS/", 6) == 0 || strstr(text, "\nPART/"))
        return CLI_FOREIGN;
    lw_topologies t = lw_topologies_open(text, size, path);
    return lw_topologies_next(&t, &m, NULL) == LW_OK ? CLI_TOPOLOGIES : CLI_UNKNOWN;
}

cli_kind_of_file cli_wrong_kind(const char *path, unsigned wanted, lw_error *e)
{
    static const struct { cli_kind_of_file kind; const char *is, *command; } rows[] = {
        { CLI_LINKAGE, "a linkage", "trace %s" }, { CLI_RESULTS, "a list of results", "trace %s" },
        { CLI_SPATIAL, "a model in space", "trace %s" }, { CLI_TARGET, "a target", "fit %s" }, { CLI_DRAWING, "a drawing", "fit %s" },
        { CLI_TASK, "a task", "fit %s" },
        { CLI_TOPOLOGIES, "a list of chains or mechanisms", "draw %s -o chains.svg" },
        { CLI_MASTER, "a master file of a product family", "family expand %s" },
        { CLI_CYCLE, "a work cycle", "profile %s" }, { CLI_SERVO, "a servo axis", "drive simulate %s" },
        { CLI_CATALOGUE, "a catalogue", "catalogue query %s" },
        { CLI_FOREIGN, "a linkage of another program", "convert %s -o linkage.json" },
        { CLI_BINARY, "no text in UTF-8 (a picture, an archive, another encoding)", NULL },
        { CLI_LENGTHS, "a table of lengths", NULL }
    };
    char *text = NULL, command[600], what[160] = "";
    size_t size, n = sizeof rows/sizeof *rows;
    if (!wanted || !cli_can_read_again(path) || lw_file_read(path, &text, &size, NULL) != LW_OK)
        return CLI_UNKNOWN;
    cli_kind_of_file kind = kind_of_text(text, size, path);
    lw_foreign foreign = kind == CLI_BINARY ? lw_foreign_kind(text, size) : (lw_foreign){ .what = NULL };
    free(text);
    if (kind == CLI_UNKNOWN || kind & wanted)
        return CLI_UNKNOWN;
    unsigned left = wanted & ~(unsigned)(CLI_RESULTS | (CLI_SPATIAL ^ CLI_LINKAGE));
    for (size_t i = 0; i < n; i++)
        if (left & rows[i].kind) {
            left &= ~(unsigned)rows[i].kind;
            snprintf(what + strlen(what), sizeof what - strlen(what), "%s%s", !what[0] ? "" : left ? ", " : " or ", rows[i].is);
        }
    if (foreign.what) {
        bool helps = foreign.use == LW_FOREIGN_ANY || (wanted & CLI_TARGET) || (foreign.use == LW_FOREIGN_TABLE && wanted & CLI_LENGTHS);
        lw_error_at(e, LW_E_NOTATION, path, 0, 0, "this is %s, not %s%s%s", foreign.what, what, helps ? "; " : "", helps ? foreign.advice : "");
        return kind;
    }
    for (size_t i = 0; i < n; i++) {
        if (rows[i].kind != kind)
            continue;
        snprintf(command, sizeof command, rows[i].command ? rows[i].command : "", path);
        lw_error_at(e, LW_E_NOTATION, path, kind == CLI_BINARY ? e->line : 0, kind == CLI_BINARY ? e->column : 0, "this is %s, not %s%s%s%s", rows[i].is, what,
                    rows[i].command ? ": did you mean 'linkwright " : "", command, rows[i].command ? "'?" : "");
    }
    return kind;
}
