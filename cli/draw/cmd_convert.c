/* linkwright convert - linkages from one format to another. */
#include <stdlib.h>
#include <string.h>

#include "base/suggest.h"
#include "catalogues/exchange/format.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "grammar/model/model.h"

typedef struct settings {
    const char *from, *to, *unit, *input;
    int         result;
    double      width, thickness, hole, clearance;
} settings;

static const cli_option options[] = {
    { "from-format", 0, CLI_TEXT, offsetof(settings, from), "json|pyslvs|pmks|adams", NULL,
      "format of the input: json, pyslvs, pmks, adams; without this option it is recognised from the text", 0, 0, NULL, NULL },
    { "format", 0, CLI_TEXT, offsetof(settings, to),
      "json|pyslvs|adams|pmks|mjcf|urdf|sdf|acf|dxf|scad|step|stl|slvs|svg|poses|motiongen", NULL,
      "format of the output; without this option the end of the output's name decides (.json, .pyslvs, .txt, .adm, "
      ".xml, ...); standard output gets json", 0, 0, NULL, NULL },
    { "length-unit", 0, CLI_TEXT, offsetof(settings, unit), "UNIT", NULL,
      "length unit: m mm cm km um in ft; of input numbers that have no unit (default m), and of the output", 0, 0, NULL, NULL },
    { "input-joint", 0, CLI_TEXT, offsetof(settings, input), "JOINT", NULL,
      "drive this joint, a pin or a slider, instead of the input of the file", 0, 0, NULL, NULL },
    { "result", 'r', CLI_INT, offsetof(settings, result), "N", NULL,
      "take result number N of a file written by fit; default: the first", 1, 1e9, NULL, NULL },
    { "plate-width", 0, CLI_REAL, offsetof(settings, width), "MM", NULL,
      "dxf, scad, step, stl: width of a bar; without it two thirds of the shortest distance of two pins of a link, at "
          "most 2/25 of the size of the linkage", 1e-6, 1e9, NULL, NULL },
    { "plate-thickness", 0, CLI_REAL, offsetof(settings, thickness), "MM", NULL,
      "thickness of the plates; without it half their width", 1e-6, 1e9, NULL, NULL },
    { "hole", 0, CLI_REAL, offsetof(settings, hole), "MM", NULL,
      "diameter of the holes and width of the slots; without it 0.4 times the width of a bar", 1e-6, 1e9, NULL, NULL },
    { "hole-clearance", 0, CLI_REAL, offsetof(settings, clearance), "MM", "-1",
      "a pin's diameter is smaller than its hole by this; -1 means a twentieth of the hole", -1, 1e9, NULL, NULL },
    { .name = NULL }
};

/* ---- choices --------------------------------------------------------------------------------------- */

static lw_status format_named(const char *name, bool read, const lw_format **out, lw_error *e)
{
    const char *names[32];
    int n = 0;
    for (const lw_format *f = lw_formats; f->name; f++) {
        if (strcmp(f->name, name) == 0 && (read ? f->read != NULL : f->write != NULL)) {
            *out = f;
            return LW_OK;
        }
        if (n < 32 && (read ? f->read != NULL : f->write != NULL))
            names[n++] = f->name;
    }
    const char *near = lw_suggest(name, names, n);
    return lw_error_set(e, LW_E_ARG, "there is no format '%s' to %s%s%s%s; see 'linkwright help convert'", name,
                        read ? "read" : "write", near ? "; did you mean '" : "", near ? near : "", near ? "'?" : "");
}

static const lw_format *format_of_text(const char *text)
{
    for (const lw_format *f = lw_formats; f->name; f++)
        if (f->read && f->begins(text))
            return f;
    return lw_formats;
}

static lw_status format_of_output(const cli_call *call, const lw_format **out, lw_error *e)
{
    const char *path = call->common.output, *end = path ? strrchr(path, '.') : NULL;
    *out = lw_formats;
    if (!path || strcmp(path, "-") == 0)
        return LW_OK;
    for (const lw_format *f = lw_formats; f->name; f++)
        if (end && f->write && strcmp(f->end, end) == 0) {
            *out = f;
            return LW_OK;
        }
    return lw_error_set(e, LW_E_ARG, "the end of '%s' says no format; add --format", path);
}

static lw_status set_unit(const char *name, lw_units *u, lw_error *e)
{
    return lw_units_set_length(u, name) ? LW_OK
         : lw_error_set(e, LW_E_ARG, "there is no length unit '%s'; m, mm, cm, km, um, in and ft are known", name);
}

static lw_status no_joint(const char *name, const lw_assembly *linkage, lw_error *e)
{
    const char *near = LW_SUGGEST(name, linkage->joint, linkage->n_joint, name);
    return lw_error_set(e, LW_E_ARG, "there is no joint '%s'; %s '%s'%s", name, near ? "did you mean" : "the first is",
                        near ? near : linkage->joint[0].name, near ? "?" : "");
}

static lw_status set_input(const char *name, lw_assembly *linkage, lw_error *e)
{
    int j = 0;
    while (j < linkage->n_joint && strcmp(linkage->joint[j].name, name) != 0)
        j++;
    if (j == linkage->n_joint)
        return no_joint(name, linkage, e);
    if (!lw_joint_can_drive(linkage->joint[j].kind))
        return lw_error_set(e, LW_E_ARG, "joint '%s' is no pin or slider and cannot be driven", name);
    lw_input *in = realloc(linkage->input, ((size_t)linkage->n_input + 1)*sizeof *in);
    if (!in)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    in[0] = (lw_input){ .joint = j, .value = lw_assembly_posture_input(linkage, j) };
    linkage->input = in;
    linkage->n_input = 1;
    return LW_OK;
}

/* ---- run ------------------------------------------------------------------------------------------- */

/* Take the motions from the inputs of a model without masses: another joint is to be the input. */
static lw_status free_inputs(lw_model *m, lw_error *e)
{
    for (int i = 0; i < m->linkage.n_link; i++)
        if (m->body[i].mass > 0)
            return lw_error_set(e, LW_E_ARG, "--input-joint does not go with a model with masses, whose motions belong "
                                "to its own inputs; change the input in the file");
    for (int i = 0; i < m->linkage.n_input; i++) {
        lw_expression_free(m->motion[i]);
        m->motion[i] = NULL;
        m->has_speed[i] = false;
    }
    return LW_OK;
}

/* Read a linkage; *m gets it with its masses and loads if the text is our own and `loads` is set.  Or read a spatial model into
 * *space.  Free them with lw_assembly_free, cli_free_model and cli_free_spatial. */
static lw_status read_linkage(const cli_call *call, bool loads, lw_assembly *linkage, lw_model **m, lw_spatial **space, lw_error *e)
{
    const settings *s = call->settings;
    const char *path = call->parsed.n_word > 0 ? call->parsed.word[0] : "-";
    char *text = NULL;
    size_t size = 0;
    lw_units units = lw_units_si();
    const lw_format *f = NULL;
    lw_status status = lw_units_set_angle(&units, "deg") ? LW_OK : LW_E_ARG;
    if (s->unit)
        status = set_unit(s->unit, &units, e);
    if (status == LW_OK && s->from)
        status = format_named(s->from, true, &f, e);
    if (status == LW_OK)
        status = cli_read_file(path, "a linkage", &text, &size, e);
    if (status == LW_OK && !f)
        f = format_of_text(text);
    bool json = status == LW_OK && strcmp(f->name, "json") == 0;
    if (json && loads)
        status = cli_any_model_text(text, size, path, s->result, m, space, e);
    else if (json)
        status = cli_any_linkage_text(path, s->result, text, size, linkage, space, e);
    else if (status == LW_OK)
        status = f->read(text, size, path, &units, linkage, e);
    free(text);
    if (status == LW_OK && *space && (s->input || s->unit))
        return lw_error_set(e, LW_E_ARG, "--%s goes with planar linkages, and this model is spatial",
                            s->input ? "input-joint" : "length-unit");
    lw_assembly *parts = *m ? &(*m)->linkage : linkage;
    if (status == LW_OK && s->unit)
        status = set_unit(s->unit, &parts->units, e);
    if (status == LW_OK && s->input && *m)
        status = free_inputs(*m, e);
    if (status == LW_OK && s->input)
        status = set_input(s->input, parts, e);
    if (status == LW_OK && *m && (*m)->small)
        status = lw_assembly_linkage(parts, (*m)->small, e);
    if (status == LW_OK && *m && lw_assembly_copy(parts, linkage) != LW_OK)
        status = lw_error_set(e, LW_E_MEMORY, "out of memory");
    return status;
}

/* Plates are made in millimetres: say what a linkage without a unit is taken for. */
static void tell_unit(const cli_call *call, const lw_format *to, const lw_assembly *k)
{
    static const char *const made[] = { "dxf", "scad", "step", "stl" };
    for (size_t i = 0; i < sizeof made/sizeof *made && !k->units.length[0]; i++)
        if (strcmp(to->name, made[i]) == 0)
            cli_note(call, "the linkage names no unit of length: its numbers are taken as metres; "
                           "if they are not, add \"units\": {\"length\": \"mm\"} to the file");
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    lw_assembly k = { 0 };
    const lw_format *to = NULL;
    lw_output out;
    lw_bytes b = { 0 };
    lw_error e = { 0 };
    if ((s->to ? format_named(s->to, false, &to, &e) : format_of_output(call, &to, &e)) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (cli_given(&call->parsed, "json") && strcmp(to->name, "json") != 0)
        return cli_usage(call, "--json prints JSON, not %s; leave out one of them", to->name);
    lw_model *m = NULL;
    lw_spatial *space = NULL;
    if (read_linkage(call, to->loads, &k, &m, &space, &e) != LW_OK || cli_open(call, &out, &e) != LW_OK) {
        lw_assembly_free(&k);
        cli_free_model(m);
        cli_free_spatial(space);
        return cli_fail(call, &e);
    }
    if (!space)
        tell_unit(call, to, &k);
    lw_export_options o = { .model = m, .width = 1e-3*s->width, .thickness = 1e-3*s->thickness, .hole = 1e-3*s->hole,
                            .clearance = s->clearance < 0 ? -1 : 1e-3*s->clearance, .stop = cli_stop_flag() };
    lw_status st = space ? lw_format_write_space(to, space, &b, &e) : lw_format_write(to, &k, &o, &b, &e);
    lw_assembly_free(&k);
    cli_free_model(m);
    cli_free_spatial(space);
    if (st != LW_OK) {
        lw_output_abandon(&out);
        return cli_fail(call, &e);
    }
    fwrite(b.data, 1, b.size, out.f);
    lw_bytes_free(&b);
    return cli_close(call, &out, CLI_DONE);
}

const cli_command cli_convert_command = {
    .name = "convert",
    .words = "[FILE]",
    .title = "linkages from one format to another: JSON, Pyslvs, PMKS, ADAMS, MuJoCo, DXF, ...",
    .examples =
        "  linkwright convert jansen.json --format pyslvs             an expression for Pyslvs\n"
        "  linkwright convert table.txt --length-unit mm -o walker.json what PMKS wrote, in millimetres\n"
        "  linkwright convert found.json --plate-width 12 --plate-thickness 3 --hole 4 -o parts.dxf\n"
        "                                                              plates for a laser cutter\n"
        "  linkwright convert expression.pyslvs --input-joint P0 | linkwright draw - -o x.svg\n",
    .about =
        "Reads one linkage from FILE or standard input and recognises its format from the text. Spatial models are\n"
        "written to mjcf, adams and acf. Formats:\n"
        "  json     linkages as in docs/notation.md, and the results of fit\n"
        "  pyslvs   the mechanism expression of Pyslvs, M[J[R, P[0, 0], L[ground, crank]], ...]\n"
        "  pmks     the joint table of PMKS: crank,rod,R,0,30,tfff\n"
        "  adams    a dataset of ADAMS/Solver: PART, MARKER, JOINT, MOTION, REQUEST\n"
        "Formats that can only be written:\n"
        "  acf      the commands that run NAME.adm in ADAMS/Solver; NAME is the name of the linkage\n"
        "  mjcf     a model of MuJoCo: bodies, hinges, loops closed by constraints, a site for each tracer, masses and loads\n"
        "  urdf     a robot description: a tree of bodies; joints that close a loop are named in a comment and left out\n"
        "  sdf      the same for Gazebo and others, with the joints that close loops\n"
        "  dxf      plates to cut, with holes and slots, in millimetres; each link lies in a layer in which it passes\n"
        "           all other links over the whole motion; the name of a DXF layer, such as L2_ROD, says in which one\n"
        "           (exit code 1: there are no such layers)\n"
        "  scad     the same plates with their pins in OpenSCAD, moving with $t\n"
        "  step     the same plates and pins as solids, an assembly in STEP AP214\n"
        "  stl      the same as meshes, for printing\n"
        "  slvs     a sketch of SolveSpace that can be dragged\n"
        "  svg      the coupler curves as paths in millimetres; fit reads such a file as a target\n"
        "  poses    CSV: position and angle of each link in 180 poses\n"
        "  motiongen  JSON: joints, links as lists of joints, actuators, tracers with their curves\n"
        "Points of one link become tracers, and tracers become such points. pyslvs and pmks cannot express gears,\n"
        "welds away from a slider, names of joints, ranges of inputs and directions of tools. Linkages with gears or\n"
        "such welds are refused (exit code 3); the rest is left out.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 0,
    .most_words = 1,
    .run = run,
    .reads = CLI_LINKAGE | CLI_RESULTS | CLI_FOREIGN,
    .pictures = true,
};
