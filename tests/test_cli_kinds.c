/* Every command that is given a file of another kind says what it is, and which command reads it. */
#include "tests/cli_run.h"

TEST(wrong_kinds)
{
    static const struct { const char *kind, *file, *is, *advice; } files[] = {
        { "linkage", "examples/hoeken.json", "this is a linkage, not a", "linkwright trace" },
        { "target", "examples/ellipse.csv", "this is a target, not a", "linkwright fit" },
        { "drawing", "examples/drawings/foot-inkscape.svg", "this is a drawing, not a", "linkwright fit" },
        { "drawing", "examples/drawings/slot-autocad.dxf", "this is a drawing, not a", "linkwright fit" },
        { "task", "examples/tasks/dwell.json", "this is a task, not a", "linkwright fit" },
        { "chains", "$D/chains.g6", "this is a list of chains or mechanisms, not a", "linkwright draw" },
        { "chains", "$D/mechanisms", "this is a list of chains or mechanisms, not a", "linkwright draw" },
        { "catalogue", "$D/c.db", "this is a catalogue", "linkwright catalogue" },
        { "foreign", "$D/x.pyslvs", "this is a linkage of another program", "linkwright convert" }
    };
    static const struct { const char *command, *reads; } commands[] = {
        { "trace", "linkage" }, { "simulate", "linkage" }, { "mobility", "linkage" }, { "clearance", "linkage" },
        { "draw -o $D/x.svg --force", "linkage chains" }, { "convert", "linkage foreign" },
        { "fit --time 0.1", "target drawing task" }, { "fit examples/ellipse.csv --start-from", "linkage" },
        { "mechanisms", "chains" }, { "grammar parse", "chains" }, { "classify", "" }, { "catalogue query",
            "catalogue" },
        { "catalogue html -o $D/h", "catalogue" }, { "catalogue nearest $D/c.db", "target drawing" },
        { "catalogue add $D/c.db", "linkage" }
    };
    expect("$P chains -l 6 -o $D/chains.g6 --quiet", 0, "", NULL);
    expect("$P mechanisms -l 4 -o $D/mechanisms --quiet", 0, "", NULL);
    expect("$P catalogue build $D/c.db -l 4 --quiet", 0, NULL, NULL);
    expect("$P convert examples/hoeken.json -o $D/x.pyslvs", 0, NULL, NULL);
    for (size_t c = 0; c < sizeof commands/sizeof *commands; c++)
        for (size_t f = 0; f < sizeof files/sizeof *files; f++) {
            char line[512];
            if (strstr(commands[c].reads, files[f].kind))
                continue;
            snprintf(line, sizeof line, "$P %s %s", commands[c].command, files[f].file);
            OWN(ran) r = run(line);
            CHECK_INT(r.code, 3);
            CHECK_TEXT(r.out, "");
            bool own = strcmp(files[f].kind, "catalogue") == 0 && strncmp(commands[c].command, "catalogue", 9) == 0;
            if (!own) {                            /* as a second catalogue it is another fault */
                if (!strstr(r.err, files[f].is))
                    fprintf(stderr, "    %s\n", line);
                CHECK_HAS(r.err, files[f].is);
                CHECK_HAS(r.err, files[f].advice);
            }
        }
}

/* Files that are handed in as targets by mistake, by how they begin. */
TEST(foreign_targets)
{
    static const struct { const char *begin, *says; } rows[] = {
        { "PK\\003\\004\\000", "workbook" }, { "\\320\\317\\021\\340", "workbook of Excel" }, { "AC1027", "DWG" },
        { "AutoCAD Binary DXF", "binary DXF" }, { "\\037\\213", "compressed" }, { "%%PDF-1.4", "PDF" },
        { "\\211PNG", "picture of pixels" }, { "ISO-10303-21;", "STEP" }, { "solid cube\\n", "mesh of triangles" },
        { "ply\\nformat ascii 1.0\\n", "mesh of triangles" }, { "\\261\\262\\263SolveSpaceREVa\\n", "sketch of SolveSpace" },
        { "<?xml version=\"1.0\"?>\\n<!-- <svg> -->\\n<mujoco model=\"a\"><worldbody/></mujoco>", "MJCF" },
        { "<robot name=\"a\"><link name=\"b\"/></robot>", "URDF" }, { "\\357\\273\\277 <sdf/>", "SDFormat" }, { "<svg/>", "no visible path" },
        { "<robots/>", "no visible path" }, { "# Blender\\nmtllib a.mtl\\no Cube\\nv 1 -1 .5\\n", "mesh of triangles, not a target" },
        { "%%\\nO1000 (FOOT)\\nN10 G21 G90\\nN20 G0 X0\\n", "G-code" }, { ";FLAVOR:Marlin\\r\\nM82\\r\\n", "G-code" }, { "G,x\\n1,2\\n", "unknown column" },
        { "o,x\\nv 1 2\\n", "unknown column" }, { "<!DOCTYPE html>\\n<html lang=\"en\">", "web page" }, { "%-72sS      1\\n", "IGES" }, { "\\0\\0\\0\\030ftypheic", "picture of pixels" }, { "<!-- <robot", "no visible path" }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        expect_with(3, "", rows[i].says, "printf '%s' > $D/foreign; $P fit $D/foreign", rows[i].begin);
    }
    expect("(head -c 80 /dev/zero; printf '\\001\\000\\000\\000'; head -c 50 /dev/zero) > $D/foreign; $P fit $D/foreign", 3, "", "mesh of triangles");
    expect("$P trace $D/foreign", 3, "", "this is a mesh of triangles, not a linkage\n");
    expect("printf 'PK\\003\\004' > $D/foreign; $P classify $D/foreign", 3, "", "archive, not a table of lengths; save the sheet as CSV\n");
    expect("$P fit examples/space/boom.json", 3, "", "this is a model in space, not a target, a drawing or a task: did you mean 'linkwright trace "
           "examples/space/boom.json'?\n");
    expect("printf '{\"type\":\"FeatureCollection\"}' > $D/other.json; $P fit $D/other.json", 3, "", "this is no task");
    expect("$P classify $D/c.db", 3, "", "this is a catalogue");
}
