/* linkwright draw - a picture or an animation of a linkage; sheets of chains and mechanisms. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "cli/draw/draw.h"
#include "cli/program/file_kind.h"
#include "cli/program/model.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"
#include "grammar/topology/notation.h"

typedef cli_draw_settings settings;

/* The first choices are formats of pictures, the rest notations of topologies, which the input is then read in. */
#define PICTURES 6

static const cli_option options[] = {
    { "target", 't', CLI_INPUT, offsetof(settings, target), "FILE", NULL, "linkage: also draw the points of this target", 0, 0, NULL, NULL },
    { "size", 0, CLI_SIZE, offsetof(settings, size), "WIDTHxHEIGHT", NULL,
      "size in pixels; without it a size that suits the format, A4 for sheets", 64, 8192, NULL, NULL },
    { "steps", 'n', CLI_INT, offsetof(settings, steps), "N", "120", "linkage: number of postures in an animation", 2, 10000, NULL, NULL },
    { "result", 'r', CLI_INT, offsetof(settings, result), "N", "0",
      "linkage: draw result N of a file written by fit, 1 is the best; 0: the best, or the only linkage in the file", 0, 1000000, NULL, NULL },
    { "format", 'f', CLI_CHOICE, offsetof(settings, format),
      "name|svg|pdf|png|gif|html|g6|graph6|lam|sentence|franke|edges|json", "name",
      "format of the picture; 'name': by the end of the output's name, svg on standard output. The name of a notation "
      "means that the input holds chains; their notation is recognised from the text", 0, 0, NULL, NULL },
    { "title", 0, CLI_TEXT, offsetof(settings, title), "TEXT", NULL, "title; without it the name of the linkage", 0, 0, NULL, NULL },
    { "all-modes", 0, CLI_FLAG, offsetof(settings, all_modes), NULL, NULL,
      "linkage: also draw the curves of the other assembly modes, dashed", 0, 0, NULL, NULL },
    { "to", 0, CLI_REAL, offsetof(settings, until), "T", "0",
      "linkage whose inputs have motions in time: show them from 0 to T [s]; 0: until they repeat or come to rest", 0, 1e6, NULL, NULL },
    { "azimuth", 0, CLI_REAL, offsetof(settings, azimuth), "DEG", "35",
      "spatial model: direction it is seen from, about the upward axis [degrees]", -360, 360, NULL, NULL },
    { "elevation", 0, CLI_REAL, offsetof(settings, elevation), "DEG", "25",
      "spatial model: height it is seen from, above the level plane [degrees]", -90, 90, NULL, NULL },
    { "grid", 0, CLI_SIZE, offsetof(settings, grid), "COLUMNSxROWS", "6x8", "chains: number of pictures on a page", 1, 64, NULL, NULL },
    { "each", 0, CLI_FLAG, offsetof(settings, each), NULL, NULL, "chains: one page or file for each chain", 0, 0, NULL, "grid" },
    { "caption", 0, CLI_CHOICE, offsetof(settings, caption), "number|graph6|joints|assortment|none", "number",
      "chains: text below each picture; the assortment counts binary, ternary, ... links", 0, 0, NULL, NULL },
    { "numbers", 0, CLI_FLAG, offsetof(settings, numbers), NULL, NULL, "chains: number the links", 0, 0, NULL, NULL },
    { "keep-going", 'k', CLI_FLAG, offsetof(settings, keep_going), NULL, NULL,
      "chains: after an error in the input, continue with the next chain", 0, 0, NULL, NULL },
    { .name = NULL }
};

static lw_status choose_kind(const cli_call *call, lw_draw_kind *kind, lw_error *e)
{
    static const lw_draw_kind kinds[] = { LW_DRAW_SVG, LW_DRAW_SVG, LW_DRAW_PDF, LW_DRAW_PNG,
                                          LW_DRAW_GIF, LW_DRAW_HTML };
    const settings *s = call->settings;
    bool by_name = s->format == 0 || s->format >= PICTURES;
    *kind = by_name ? LW_DRAW_SVG : kinds[s->format];
    if (by_name && call->common.output && strcmp(call->common.output, "-") != 0)
        return lw_draw_kind_of(call->common.output, kind, e);
    return LW_OK;
}

/* The linkage of the second file, in the same picture. */
static lw_status compare(const cli_call *call, lw_scene *scene, lw_error *e)
{
    lw_scene_options o = lw_scene_options_default();
    lw_scene *other = calloc(1, sizeof *other);
    lw_model *m = other ? cli_read_model(call->parsed.word[1], 0, e) : NULL;
    lw_status st = !other ? lw_error_set(e, LW_E_MEMORY, "out of memory") : m ? LW_OK : e->status;
    o.model = m;
    o.stop = cli_stop_flag();
    if (st == LW_OK)
        st = lw_scene_make_any(&m->linkage, m, NULL, &o, other, e);
    if (st == LW_OK)
        st = lw_scene_compare(scene, other, e);
    if (other)
        lw_scene_free(other);
    free(other);
    cli_free_model(m);
    return st;
}

static lw_status make_picture(const cli_call *call, const lw_model *m, const lw_target *t, lw_draw_kind kind, lw_bytes *bytes, lw_error *e)
{
    const settings *s = call->settings;
    lw_scene_options o = lw_scene_options_default();
    o.title = s->title;
    o.n_frame = (size_t)s->steps;
    o.other_branches = s->all_modes;
    o.model = m;
    o.until = s->until;
    o.stop = cli_stop_flag();
    lw_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status st = lw_scene_make_any(&m->linkage, m, t, &o, scene, e);
    if (st == LW_OK && scene->note[0])
        cli_note(call, "%s", scene->note);
    if (st == LW_OK && call->parsed.n_word > 1)
        st = compare(call, scene, e);
    if (st == LW_OK)
        st = lw_draw_bytes(scene, kind, s->size[0], s->size[1], bytes, e);
    lw_scene_free(scene);
    free(scene);
    return st;
}

static lw_status draw_spatial(const cli_call *call, const lw_spatial *m, lw_draw_kind kind, lw_bytes *bytes, lw_error *e)
{
    const settings *s = call->settings;
    lw_space_scene_options o = { .title = s->title, .n_frame = (size_t)s->steps, .until = s->until, .stop = cli_stop_flag() };
    lw_space_view view = { .azimuth = s->azimuth*LW_PI/180, .elevation = s->elevation*LW_PI/180 };
    lw_space_scene scene;
    lw_status st = lw_space_scene_make(m, &o, &scene, e);
    if (st == LW_OK && scene.note[0])
        cli_note(call, "%s", scene.note);
    if (st == LW_OK)
        st = lw_draw_space(&scene, view, kind, s->size[0], s->size[1], bytes, e);
    lw_space_scene_free(&scene);
    return st;
}

static lw_status draw(const cli_call *call, lw_draw_kind kind, lw_bytes *bytes, lw_error *e)
{
    static const lw_target_options by_file = { .closed = -1 };
    const settings *s = call->settings;
    lw_target t = { 0 };
    lw_model *m = NULL;
    lw_spatial *spatial = NULL;
    lw_status st = cli_read_any_model(call->parsed.n_word ? call->parsed.word[0] : "-", s->result, &m, &spatial, e);
    static const char *const planar[] = { "target", "all-modes", NULL }, *const of_space[] = { "azimuth", "elevation", NULL };
    for (const char *const *name = spatial ? planar : of_space; st == LW_OK && *name; name++)
        if (cli_given(&call->parsed, *name))
            st = lw_error_set(e, LW_E_ARG, "--%s is for %s models, and this one is %s", *name,
                              spatial ? "planar" : "spatial", spatial ? "spatial" : "planar");
    if (spatial && call->parsed.n_word > 1 && st == LW_OK)
        st = lw_error_set(e, LW_E_ARG, "two planar linkages can be compared, and this model is spatial");
    if (spatial) {
        st = st != LW_OK ? st : draw_spatial(call, spatial, kind, bytes, e);
        cli_free_spatial(spatial);
        return st;
    }
    if (st == LW_OK && s->target)
        st = cli_read_target(s->target, &by_file, &t, e);
    if (st == LW_OK)
        st = make_picture(call, m, s->target ? &t : NULL, kind, bytes, e);
    lw_target_free(&t);
    cli_free_model(m);
    return st;
}

static int draw_linkage(const cli_call *call, lw_draw_kind kind)
{
    lw_bytes bytes = { 0 };
    lw_output o;
    lw_error e = { 0 };
    if (draw(call, kind, &bytes, &e) != LW_OK || cli_open(call, &o, &e) != LW_OK) {
        lw_bytes_free(&bytes);
        return cli_fail(call, &e);
    }
    fwrite(bytes.data, 1, bytes.size, o.f);            /* cli_close checks the stream for errors */
    lw_bytes_free(&bytes);
    return cli_close(call, &o, CLI_DONE);
}

/* Does the file hold topologies? It does unless it begins as a JSON object that is no mechanism: linkages and results
 * of fits begin so. */
static bool holds_topologies(const char *path)
{
    char *text = NULL;
    size_t size;
    lw_mechanism m;
    if (lw_file_read(path, &text, &size, NULL) != LW_OK)
        return false;                                              /* the reader of linkages then reports the error */
    size_t blank = strspn(text, " \t\r\n");
    lw_topologies t = lw_topologies_open(text, size, path);
    bool yes = text[blank] && (text[blank] != '{' || lw_topologies_next(&t, &m, NULL) == LW_OK);
    size_t n = strlen(path);
    if (n > 4 && strcmp(path + n - 4, ".csv") == 0 && cli_is_target(text, size))
        yes = false;
    free(text);
    return yes;
}

/* Does standard input hold topologies?  If it does not begin as JSON, it does, and they are read from it as they come.  JSON may hold either: all
 * of it is read into a file in memory, which replaces standard input. */
static lw_status look_at_input(bool *topologies, lw_error *e)
{
    lw_bytes begin = { 0 };                      /* blank lines count in the places of errors */
    char c = 0, *text = NULL;
    size_t size = 0;
    ssize_t n;
    while ((n = read(STDIN_FILENO, &c, 1)) == 1) {
        lw_bytes_add(&begin, &c, 1);
        if (!c || !strchr(" \t\r\n", c))
            break;
    }
    *topologies = n != 1 || (c != '{' && c != '\xef');                  /* or a byte order mark */
    lw_status s = lw_bytes_end(&begin, e);
    while (*topologies && s == LW_OK && begin.size > 0)
        ungetc((unsigned char)begin.data[--begin.size], stdin);
    if (!*topologies && s == LW_OK)
        s = cli_read_file("-", "a linkage, chains or mechanisms", &text, &size, e);
    if (!*topologies && s == LW_OK) {
        FILE *f = fdopen(memfd_create("standard input", MFD_CLOEXEC), "w+");
        bool kept = f && fwrite(begin.data, 1, begin.size, f) == begin.size && fwrite(text, 1, size, f) == size && fflush(f) == 0
                 && dup2(fileno(f), STDIN_FILENO) >= 0 && lseek(STDIN_FILENO, 0, SEEK_SET) == 0;
        if (!kept)
            s = lw_error_at(e, LW_E_IO, "-", 0, 0, "cannot be kept in memory: %s", strerror(errno));
        if (f)
            fclose(f);
        if (kept) {
            *topologies = holds_topologies("-");
            lseek(STDIN_FILENO, 0, SEEK_SET);
        }
    }
    free(text);
    lw_bytes_free(&begin);
    return s;
}

/* NULL, or the name of an option that does not apply to what is drawn. */
static const char *misplaced(const cli_call *call, bool chains)
{
    static const char *const of_linkage[] = { "target", "steps", "result", "all-modes", "to", "azimuth", "elevation", NULL };
    static const char *const of_chains[] = { "grid", "each", "caption", "numbers", "keep-going", NULL };
    for (const char *const *name = chains ? of_linkage : of_chains; *name; name++)
        if (cli_given(&call->parsed, *name))
            return *name;
    return NULL;
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    lw_draw_kind kind;
    lw_error e = { 0 };
    const char *file = call->parsed.n_word ? call->parsed.word[0] : "-";
    bool standard = strcmp(file, "-") == 0, chains = s->format >= PICTURES;
    if (call->common.json)
        return cli_usage(call, "--json has no meaning here; 'linkwright trace --json' prints the curves");
    if (choose_kind(call, &kind, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (!chains && standard && isatty(STDIN_FILENO))
        chains = call->parsed.n_word == 0;
    else if (!chains && standard && look_at_input(&chains, &e) != LW_OK)
        return cli_fail(call, &e);
    else if (!chains && !standard)
        chains = cli_can_read_again(file) && holds_topologies(file);
    const char *wrong = misplaced(call, chains);
    if (wrong)
        return cli_usage(call, "--%s is for %s, and this %s", wrong, chains ? "linkages" : "chains and mechanisms",
                         chains ? "draws chains" : "is a linkage");
    if (call->parsed.n_word > 1 && chains)
        return cli_usage(call, "two files are compared if they are linkages, and '%s' holds chains", file);
    return chains ? cli_draw_chains(call, file, kind) : draw_linkage(call, kind);
}

const cli_command cli_draw_command = {
    .name = "draw",
    .words = "[FILE [SECOND]]",
    .title = "picture of a linkage (SVG, PDF, PNG, GIF, HTML); sheets of chains and mechanisms (SVG, PDF, PNG)",
    .examples =
        "  linkwright draw examples/hoeken.json -o hoeken.svg             a picture\n"
        "  linkwright draw examples/jansen.json -o leg.gif --size 400x300 an animation\n"
        "  linkwright draw examples/loader.json -o loader.html            several inputs move by their motions\n"
        "  linkwright draw examples/space/delta.json -o delta.html        in space: a page that turns by mouse\n"
        "  linkwright draw examples/space/bricard.json --azimuth 60 -o bricard.svg\n"
        "  linkwright draw best.json -t examples/ellipse.csv -o best.png  with the points it was made for\n"
        "  linkwright draw examples/hoeken.json examples/chebyshev.json -o two.svg   two linkages in one picture\n"
        "  linkwright draw fits.json --result 2 -o second.pdf             the second best of a fit\n"
        "  linkwright chains --links 10 | linkwright draw -o ten.pdf      230 chains on five pages\n"
        "  linkwright draw --format g6 < chains.g6 > sheet.svg            chains of any notation, one page\n"
        "  linkwright mechanisms --links 6 --input ground | linkwright draw --numbers -o six.png\n"
        "  linkwright chains --links 8 | linkwright draw --each -o eight.svg   eight-001.svg and so on\n",
    .about =
        "FILE is a linkage (docs/notation.md) or the output of 'linkwright fit --json'; - is standard input. The\n"
        "linkage is drawn in the posture of its file, with the curves of its tracers and labels at joints and lengths.\n"
        "A model in space is drawn in parallel projection, what is nearer over what is farther; .html is a page in which it\n"
        "moves and is turned by mouse, finger or keys.\n"
        "SECOND is a linkage to compare it with, drawn thin with its curves in red.\n"
        "An animation moves the first input until the motion closes, or within its range or the stop of its joint. If\n"
        "several inputs have motions or ranges, they move together.\n"
        "FILE can also hold chains or mechanisms in any notation; without FILE standard input is read.\n"
        "They are drawn as in textbooks: bars, polygons, pins. If the graph of a chain is planar, no two links cross,\n"
        "else as few as can be found. The joints of a ground link stand on one line. Several pages are written as\n"
        "numbered files, or as one PDF.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 0,
    .most_words = 2,
    .run = run,
    .reads = CLI_LINKAGE | CLI_RESULTS | CLI_TOPOLOGIES,
    .pictures = true,
};
