/* catalogues/store/query_fields.c - the fields of a query. A new field is a new row. */
#include "catalogues/store/query.h"

const char *const lw_list_names[LW_LIST_ANY + 1] = { "chains", "mechanisms", "linkages", "structures", "any" };

#define OF_CHAIN(x)        { "c." x, "c." x, "c." x, NULL }
#define OF_CHAIN_TOO(x)    { "c." x, "c." x, "k." x, NULL }
#define OF_STRUCTURE(x)    { "s." x, "s." x, "s." x, "s." x }
#define OF_MECHANISM(x)    { NULL, "m." x, NULL, NULL }
#define OF_LINKAGE(x)      { NULL, NULL, "k." x, NULL }
#define OF_RUN(x) \
    { "(SELECT " x " FROM run WHERE id = c.run)", "(SELECT " x " FROM run WHERE id = m.run)", \
      "(SELECT " x " FROM run WHERE id = k.run)", "(SELECT " x " FROM run WHERE id = s.run)" }

const lw_query_field lw_fields[] = {
    { "id", "number of the row", LW_FIELD_INTEGER, { "c.id", "m.id", "k.id", "s.id" } },
    { "links", "number of links", LW_FIELD_INTEGER, OF_CHAIN_TOO("links") },
    { "dof", "degree of freedom", LW_FIELD_INTEGER, OF_CHAIN_TOO("dof") },
    { "joints", "number of joints", LW_FIELD_INTEGER, OF_CHAIN_TOO("joints") },
    { "loops", "independent loops", LW_FIELD_INTEGER, { "c.loops", "c.loops", "(k.joints - k.links + 1)", "s.loops" } },
    { "graph6", "the chain", LW_FIELD_TEXT, OF_CHAIN("graph6") },
    { "label", "canonical label of the chain", LW_FIELD_TEXT, OF_CHAIN_TOO("label") },
    { "assortment", "links with 2, 3, 4, ... joints: \"4 4 0\"", LW_FIELD_TEXT, OF_CHAIN("assortment") },
    { "binary", "links with two joints", LW_FIELD_INTEGER, OF_CHAIN("binary") },
    { "ternary", "links with three joints", LW_FIELD_INTEGER, OF_CHAIN("ternary") },
    { "quaternary", "links with four joints", LW_FIELD_INTEGER, OF_CHAIN("quaternary") },
    { "quinary", "links with five joints", LW_FIELD_INTEGER, OF_CHAIN("quinary") },
    { "senary", "links with six joints", LW_FIELD_INTEGER, OF_CHAIN("senary") },
    { "symmetry", "order of the automorphism group", LW_FIELD_INTEGER, OF_CHAIN("symmetry") },
    { "grounds", "choices of the ground link up to symmetry", LW_FIELD_INTEGER, OF_CHAIN("grounds") },
    { "planar", "the graph is planar", LW_FIELD_FLAG, { "c.planar", "c.planar", "c.planar", "s.planar" } },
    { "franke", "Franke's notation", LW_FIELD_TEXT, OF_CHAIN("franke") },
    { "sentence", "the sentence", LW_FIELD_TEXT, OF_CHAIN("sentence") },
    { "matrix", "link adjacency matrix", LW_FIELD_TEXT, OF_CHAIN("matrix") },
    { "structure", "Franke structure", LW_FIELD_TEXT, OF_STRUCTURE("form") },
    { "derivation", "of the structure", LW_FIELD_TEXT, OF_STRUCTURE("derivation") },
    { "circles", "links with three joints or more", LW_FIELD_INTEGER, OF_STRUCTURE("circles") },
    { "lines", "of the structure", LW_FIELD_INTEGER, OF_STRUCTURE("lines") },
    { "ground", "the fixed link", LW_FIELD_INTEGER, OF_MECHANISM("ground") },
    { "kinds", "joint kinds, a letter each", LW_FIELD_TEXT, { NULL, "m.kinds", "k.kinds", NULL } },
    { "sliders", "number of sliders", LW_FIELD_INTEGER, { NULL, "m.sliders", "k.sliders", NULL } },
    { "inputs", "driven joints, by their links: 1-2", LW_FIELD_TEXT, OF_MECHANISM("inputs") },
    { "assur", "Assur groups in order of solution: class, order, links", LW_FIELD_TEXT, OF_MECHANISM("assur") },
    { "groups", "number of Assur groups", LW_FIELD_INTEGER, OF_MECHANISM("groups_n") },
    { "highest", "class of the highest Assur group", LW_FIELD_INTEGER, OF_MECHANISM("highest") },
    { "modes", "assembly modes, over the complex numbers", LW_FIELD_INTEGER, OF_MECHANISM("modes") },
    { "name", "of the linkage", LW_FIELD_TEXT, OF_LINKAGE("name") },
    { "type", "letters of a four-link chain: RRRP", LW_FIELD_TEXT, OF_LINKAGE("type") },
    { "family", "that the fit looked in", LW_FIELD_TEXT, OF_LINKAGE("family") },
    { "class", "Barker's class of the four-bar that is driven: GCRR", LW_FIELD_TEXT, OF_LINKAGE("class") },
    { "task", "path, function or motion", LW_FIELD_TEXT, OF_LINKAGE("task") },
    { "timing", "prescribed, free or none", LW_FIELD_TEXT, OF_LINKAGE("timing") },
    { "target", "file of the target", LW_FIELD_TEXT, OF_LINKAGE("target") },
    { "source", "file that was added", LW_FIELD_TEXT, OF_LINKAGE("source") },
    { "objective", "of the fit", LW_FIELD_REAL, OF_LINKAGE("objective") },
    { "error", "mean distance of the stations as a fraction of the length of the path: 0.01 is 1 %",
      LW_FIELD_REAL, OF_LINKAGE("error") },
    { "error_mean", "mean distance [m]", LW_FIELD_LENGTH, OF_LINKAGE("error_mean") },
    { "error_rms", "root mean square distance [m]", LW_FIELD_LENGTH, OF_LINKAGE("error_rms") },
    { "error_max", "greatest distance [m]", LW_FIELD_LENGTH, OF_LINKAGE("error_max") },
    { "error_curve", "greatest distance of the curve from the target [m]", LW_FIELD_LENGTH, OF_LINKAGE("error_curve") },
    { "angle_error", "mean error of the tool or output [rad]", LW_FIELD_ANGLE, OF_LINKAGE("angle_error") },
    { "crank", "the input turns fully", LW_FIELD_FLAG, OF_LINKAGE("crank") },
    { "circuits", "of the linkage", LW_FIELD_INTEGER, OF_LINKAGE("circuits") },
    { "transmission_min", "least transmission angle, folded to 0 to 90 deg [rad]", LW_FIELD_ANGLE,
      OF_LINKAGE("transmission_min") },
    { "transmission_max", "greatest transmission angle, folded to 0 to 90 deg [rad]", LW_FIELD_ANGLE,
      OF_LINKAGE("transmission_max") },
    { "size", "of the curve: root mean square distance from its middle [m]", LW_FIELD_LENGTH, OF_LINKAGE("size") },
    { "closed", "the curve is closed", LW_FIELD_FLAG, OF_LINKAGE("closed") },
    { "json", "the linkage as it is read and written", LW_FIELD_TEXT, OF_LINKAGE("json") },
    { "program", "version that wrote the row", LW_FIELD_TEXT, OF_RUN("program") },
    { "seed", "of that run", LW_FIELD_TEXT, OF_RUN("seed") },
    { "command", "of that run", LW_FIELD_TEXT, OF_RUN("command") },
    { .name = NULL }
};
