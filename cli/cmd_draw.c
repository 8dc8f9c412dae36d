/* linkwright draw - a picture or an animation of a linkage, with its curves and its target. */
#include <stdlib.h>

#include "catalogues/draw.h"
#include "cli/model.h"
#include "cli/output.h"

typedef struct settings {
    const char *target, *title;
    int         size[2];
    int         steps, result, format;
    bool        all_modes;
} settings;

static const cli_option options[] = {
    { "target", 't', CLI_TEXT, offsetof(settings, target), "FILE", NULL,
      "draw the points of this target too", 0, 0, NULL, NULL },
    { "size", 's', CLI_SIZE, offsetof(settings, size), "WIDTHxHEIGHT", NULL,
      "size in pixels; without it what suits the format", 64, 8192, NULL, NULL },
    { "steps", 'n', CLI_INT, offsetof(settings, steps), "N", "120",
      "postures of the motion, for animations", 2, 10000, NULL, NULL },
    { "result", 'r', CLI_INT, offsetof(settings, result), "N", "0",
      "which result of a file that fit wrote, 1 is the best; 0 the best, or the one linkage there is",
      0, 1000000, NULL, NULL },
    { "format", 'f', CLI_CHOICE, offsetof(settings, format), "name|svg|pdf|png|gif|html", "name",
      "format; 'name' goes by the end of the output's name and is svg on standard output", 0, 0, NULL, NULL },
    { "title", 0, CLI_TEXT, offsetof(settings, title), "TEXT", NULL,
      "title; without it the name of the linkage", 0, 0, NULL, NULL },
    { "all-modes", 'a', CLI_FLAG, offsetof(settings, all_modes), NULL, NULL,
      "the curves of the other assembly modes too, dashed", 0, 0, NULL, NULL },
    { .name = NULL }
};

static lw_status choose_kind(const cli_call *call, lw_draw_kind *kind, lw_error *e)
{
    static const lw_draw_kind kinds[] = { LW_DRAW_SVG, LW_DRAW_SVG, LW_DRAW_PDF, LW_DRAW_PNG,
                                          LW_DRAW_GIF, LW_DRAW_HTML };
    const settings *s = call->settings;
    *kind = kinds[s->format];
    if (s->format == 0 && call->common.output)
        return lw_draw_kind_of(call->common.output, kind, e);
    return LW_OK;
}

static lw_status make_picture(const cli_call *call, const lw_linkage *k, const lw_target *t,
                              lw_draw_kind kind, lw_bytes *bytes, lw_error *e)
{
    const settings *s = call->settings;
    lw_scene_options o = lw_scene_options_default();
    o.title = s->title;
    o.n_frame = (size_t)s->steps;
    o.other_branches = s->all_modes;
    lw_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status st = lw_scene_make(k, t, &o, scene, e);
    if (st == LW_OK && scene->note[0])
        cli_note(call, "%s", scene->note);
    if (st == LW_OK)
        st = lw_draw_bytes(scene, kind, s->size[0], s->size[1], bytes, e);
    lw_scene_free(scene);
    free(scene);
    return st;
}

static lw_status draw(const cli_call *call, lw_draw_kind kind, lw_bytes *bytes, lw_error *e)
{
    static const lw_target_options by_file = { -1, NULL, NULL };
    const settings *s = call->settings;
    lw_linkage *k = calloc(1, sizeof *k);
    lw_target t = { 0 };
    lw_status st = k ? cli_read_linkage(call->parsed.word[0], s->result, k, e)
                     : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && s->target)
        st = cli_read_target(s->target, &by_file, &t, e);
    if (st == LW_OK)
        st = make_picture(call, k, s->target ? &t : NULL, kind, bytes, e);
    lw_target_free(&t);
    free(k);
    return st;
}

static int run(const cli_call *call)
{
    lw_draw_kind kind;
    lw_bytes bytes = { 0 };
    lw_output o;
    lw_error e = { 0 };
    if (call->common.json)
        return cli_usage(call, "--json has no meaning here; 'linkwright trace --json' prints the curves");
    if (choose_kind(call, &kind, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (draw(call, kind, &bytes, &e) != LW_OK || cli_open(call, &o, &e) != LW_OK) {
        lw_bytes_free(&bytes);
        return cli_fail(call, &e);
    }
    fwrite(bytes.data, 1, bytes.size, o.f);            /* cli_close looks at the stream's error */
    lw_bytes_free(&bytes);
    return cli_close(call, &o, CLI_DONE);
}

const cli_command cli_draw_command = {
    .name = "draw",
    .words = "MODEL.json",
    .title = "picture (SVG, PDF, PNG) or animation (GIF, HTML) of a linkage",
    .examples =
        "  linkwright draw examples/hoeken.json -o hoeken.svg             a picture\n"
        "  linkwright draw examples/jansen.json -o leg.gif --size 400x300 an animation\n"
        "  linkwright draw best.json -t examples/ellipse.csv -o best.png  with the points it was made for\n"
        "  linkwright draw fits.json --result 2 -o second.pdf             the second best of a fit\n",
    .about =
        "The linkage is drawn in the posture of its file, with the curves of its tracers, joints and\n"
        "lengths labelled. MODEL is a linkage (docs/notation.md) or what 'linkwright fit --json'\n"
        "printed; - is standard input.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1,
    .run = run,
};
