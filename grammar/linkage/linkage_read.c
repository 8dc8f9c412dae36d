/* grammar/linkage/linkage_read.c - a linkage from JSON (docs/notation.md, "Linkage").  This file checks types and names;
 * lw_assembly_find_fault checks the whole, and its error gets a place in the text here. */
#include "base/real.h"
#include "grammar/linkage/assembly.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "grammar/linkage/linkage_internal.h"
#include "grammar/linkage/read_internal.h"

/* Is there memory at p? */
static lw_status has_memory(const void *p, lw_error *e)
{
    return p ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* The link that a node names; a new name adds a link. */
static lw_status meet_link(const lw_json_node *n, lw_assembly *assembly, lw_error *e)
{
    char name[LW_NAME_SIZE];
    lw_status s = lw_json_name(n, name, sizeof name, e);
    if (s == LW_OK && lw_read_find(n->json, name, *assembly->link_name, sizeof *assembly->link_name, assembly->n_link) < 0)
        strcpy(assembly->link_name[assembly->n_link++], name);
    return s;
}

/* ---- head -------------------------------------------------------------------------------------- */

lw_status lw_read_version(const lw_json_node *root, lw_error *e)
{
    lw_json_node n;
    double version = 0;
    if (!lw_json_member(root, "linkwright", &n))
        return lw_json_fault(root, e, "\"linkwright\": 1 is missing; it says which notation this file follows");
    lw_status s = lw_json_number(&n, &version, e);
    if (s == LW_OK && version != 1)
        return lw_json_fault(&n, e, "notation %g is not known here, only 1; a newer linkwright may read it", version);
    return s;
}

static lw_status read_unit(const lw_json_node *units, const char *key, const char *choice,
                           bool (*set)(lw_units *, const char *), lw_units *u, lw_error *e)
{
    lw_json_node n;
    if (!lw_json_member(units, key, &n))
        return LW_OK;
    lw_status s = lw_json_expect(&n, LW_JSON_TEXT, e);
    if (s == LW_OK && !set(u, lw_json_text(&n)))
        s = lw_json_fault(&n, e, "unknown unit \"%.20s\"; known are %s", lw_json_text(&n), choice);
    return s;
}

lw_status lw_read_units(const lw_json_node *root, lw_units *u, lw_error *e)
{
    static const char *const known[] = { "length", "angle" };
    lw_json_node n;
    if (!lw_json_member(root, "units", &n))
        return LW_OK;
    lw_status s = lw_json_expect(&n, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(&n, known, COUNT(known), e);
    if (s == LW_OK)
        s = read_unit(&n, "length", "m, mm, cm, km, um, in, ft", lw_units_set_length, u, e);
    if (s == LW_OK)
        s = read_unit(&n, "angle", "rad, deg, turn", lw_units_set_angle, u, e);
    return s;
}

/* An element of "links": a name, or an object with the name and the masses of a model. */
static lw_status read_link(const lw_json_node *n, lw_assembly *assembly, lw_error *e)
{
    static const char *const known[] = { "name", "mass", "centre", "inertia", "elastic", "velocity", "omega",
                                         "shapes" };
    lw_json_node name = *n;
    lw_status s = LW_OK;
    if (lw_json_kind_of(n) == LW_JSON_OBJECT) {
        s = lw_json_known_keys(n, known, COUNT(known), e);
        if (s == LW_OK)
            s = lw_read_need(n, "name", &name, e);
    }
    if (s == LW_OK)
        s = lw_json_name(&name, assembly->link_name[assembly->n_link], LW_NAME_SIZE, e);
    if (s == LW_OK)
        assembly->n_link++;
    return s;
}

/* Without "links" the links are the ground and all links that joints name, in that order. */
static lw_status gather_links(const lw_json_node *root, const lw_json_node *ground, lw_assembly *assembly, lw_error *e)
{
    lw_json_node joints, links;
    lw_status s = lw_read_need(root, "joints", &joints, e);
    if (s == LW_OK)
        s = lw_read_list(&joints, 1, SIZE_MAX, e);
    if (s == LW_OK)
        s = has_memory(assembly->link_name = calloc(2*lw_json_count(&joints) + 1, sizeof *assembly->link_name), e);
    if (s == LW_OK && ground)
        s = meet_link(ground, assembly, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&joints); i++) {
        lw_json_node joint = lw_json_element(&joints, i);
        s = lw_json_expect(&joint, LW_JSON_OBJECT, e);
        if (s == LW_OK)
            s = lw_read_need(&joint, "links", &links, e);
        if (s == LW_OK)
            s = lw_read_list(&links, 2, 2, e);
        for (size_t end = 0; s == LW_OK && end < 2; end++) {
            lw_json_node link = lw_json_element(&links, end);
            s = meet_link(&link, assembly, e);
        }
    }
    return s;
}

static lw_status read_links(const lw_json_node *root, lw_assembly *assembly, lw_error *e)
{
    lw_json_node links, ground;
    bool has_ground = lw_json_member(root, "ground", &ground);
    lw_status s = LW_OK;
    if (lw_json_member(root, "links", &links)) {
        s = lw_read_list(&links, 2, SIZE_MAX, e);
        if (s == LW_OK)
            s = has_memory(assembly->link_name = calloc(lw_json_count(&links) + 1, sizeof *assembly->link_name), e);
        for (size_t i = 0; s == LW_OK && i < lw_json_count(&links); i++) {
            lw_json_node link = lw_json_element(&links, i);
            s = read_link(&link, assembly, e);
        }
    } else
        s = gather_links(root, has_ground ? &ground : NULL, assembly, e);
    if (s == LW_OK && has_ground)
        return lw_read_link(&ground, assembly, &assembly->ground, e);
    for (int i = 0; s == LW_OK && i < assembly->n_link; i++)
        if (strcmp(assembly->link_name[i], "ground") == 0) {
            assembly->ground = i;
            return LW_OK;
        }
    return s == LW_OK ? lw_json_fault(root, e, "\"ground\" is missing: name the fixed link, or call a link \"ground\"") : s;
}

static lw_status read_head(const lw_json_node *root, lw_assembly *assembly, lw_error *e)
{
    static const char *const known[] = { "linkwright", "name", "units", "links", "ground", "joints", "input",
                                         "inputs", "tracers", "fit", "$schema", "gravity", "springs", "dampers",
                                         "forces", "motors", "states", "controllers", "cylinders", "profiles", "contacts", "ropes" };
    lw_json_node n;
    lw_status s = lw_json_expect(root, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_read_version(root, e);
    if (s == LW_OK)
        s = lw_json_known_keys(root, known, COUNT(known), e);
    if (s == LW_OK && lw_json_member(root, "name", &n)) {
        s = lw_json_expect(&n, LW_JSON_TEXT, e);
        if (s == LW_OK && *lw_json_text(&n))
            s = lw_json_name(&n, assembly->name, sizeof assembly->name, e);
    }
    if (s == LW_OK)
        s = lw_read_units(root, &assembly->units, e);
    return s == LW_OK ? read_links(root, assembly, e) : s;
}

/* ---- joints ------------------------------------------------------------------------------------ */

static lw_status read_kind(const lw_json_node *joint, lw_joint *j, lw_error *e)
{
    lw_json_node n;
    j->kind = LW_JOINT_REVOLUTE;
    if (!lw_json_member(joint, "kind", &n))
        return LW_OK;
    lw_status s = lw_json_expect(&n, LW_JSON_TEXT, e);
    if (s != LW_OK)
        return s;
    const char *kind = lw_json_text(&n);
    if (strlen(kind) != 1 || !lw_joint_is_kind(*kind))
        return lw_json_fault(&n, e, "unknown kind \"%.20s\"; known are \"r\" pin, \"t\" slider, \"p\" pin in slot, "
                             "\"g\" gear, \"f\" fixed, \"n\" free", kind);
    j->kind = (lw_joint_kind)*kind;
    return LW_OK;
}

/* Normalise a vector.  A vector of unit length to rounding keeps its bits, so that text written by
 * lw_linkage_write reads back the same. */
static lw_status read_unit_vector(const lw_json_node *n, lw_vec2 *out, lw_error *e)
{
    lw_status s = lw_read_pair(n, 1, out, e);
    if (s != LW_OK)
        return s;
    double size = hypot(out->x, out->y);
    if (!(size >= 1e-100))
        return lw_json_fault(n, e, "a direction needs a length; [1, 0] is along x");
    if (fabs(size - 1) > 4e-16)
        *out = lw_v2(out->x/size, out->y/size);
    return LW_OK;
}

static lw_status read_direction(const lw_json_node *joint, const lw_assembly *assembly, lw_joint *j, lw_error *e)
{
    lw_json_node along, angle;
    bool has_along = lw_json_member(joint, "along", &along), has_angle = lw_json_member(joint, "angle", &angle);
    double turn = 0;
    if (!lw_joint_slides(j->kind)) {
        if (has_along || has_angle)
            return lw_json_fault(has_along ? &along : &angle, e, "a joint of kind \"%c\" has no direction; only "
                                 "\"t\" and \"p\" have", (char)j->kind);
        return LW_OK;
    }
    if (has_along && has_angle)
        return lw_json_fault(&angle, e, "the direction is given twice; keep \"along\" or \"angle\"");
    if (has_along)
        return read_unit_vector(&along, &j->along, e);
    if (!has_angle)
        return lw_json_fault(joint, e, "a joint of kind \"%c\" slides: give \"along\": [dx, dy] or \"angle\"", (char)j->kind);
    lw_status s = lw_read_optional(joint, "angle", assembly->units.radian, &turn, &has_angle, e);
    j->along = lw_v2_polar(1, turn);
    return s;
}

static lw_status read_ratio(const lw_json_node *joint, lw_joint *j, lw_error *e)
{
    lw_json_node n;
    bool given;
    if (!lw_json_member(joint, "ratio", &n))
        return lw_joint_has_ratio(j->kind)
             ? lw_json_fault(joint, e, "gear \"%s\" has no ratio: give \"ratio\", the speed of its second link over "
                             "that of the first", j->name) : LW_OK;
    if (!lw_joint_has_ratio(j->kind))
        return lw_json_fault(&n, e, "a joint of kind \"%c\" has no ratio; only gears (\"g\") have", (char)j->kind);
    return lw_read_optional(joint, "ratio", 1, &j->ratio, &given, e);
}

static lw_status read_joint(const lw_json_node *joint, lw_assembly *assembly, lw_joint *j, lw_error *e)
{
    static const char *const known[] = { "name", "kind", "links", "at", "along", "angle", "ratio", "friction",
                                         "stop", "clearance" };
    lw_json_node name, links, at;
    lw_status s = lw_json_expect(joint, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(joint, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_need(joint, "name", &name, e)) == LW_OK)
        s = lw_json_name(&name, j->name, sizeof j->name, e);
    if (s == LW_OK)
        s = read_kind(joint, j, e);
    if (s == LW_OK && (s = lw_read_need(joint, "links", &links, e)) == LW_OK)
        s = lw_read_list(&links, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node link = lw_json_element(&links, end);
        s = lw_read_link(&link, assembly, &j->link[end], e);
    }
    bool placed = lw_json_member(joint, "at", &at);
    if (s == LW_OK && !placed && lw_joint_has_position(j->kind))
        s = lw_read_need(joint, "at", &at, e);
    if (s == LW_OK && placed)
        s = lw_read_pair(&at, assembly->units.metre, &j->at, e);
    if (s == LW_OK)
        s = read_direction(joint, assembly, j, e);
    return s == LW_OK ? read_ratio(joint, j, e) : s;
}

/* Convert the ratio of a rack, which contains a length, and compute a contact point that was left out. */
static lw_status finish_gear(const lw_json_node *joint, lw_assembly *assembly, int i, lw_error *e)
{
    lw_json_node at, ratio;
    lw_gear gear;
    lw_error why;
    lw_vec2 contact;
    lw_joint *j = &assembly->joint[i];
    bool placed = lw_json_member(joint, "at", &at);
    if (lw_assembly_gear(assembly, i, &gear, NULL, &why) != LW_OK)
        return placed ? LW_OK : lw_json_fault(joint, e, "%s", why.text);
    lw_json_member(joint, "ratio", &ratio);
    j->ratio *= lw_linkage_gear_unit(&gear, assembly->units.metre);
    if (!(fabs(j->ratio) > 0 && fabs(j->ratio) <= LW_COORDINATE_MAX))
        return lw_json_fault(&ratio, e, "the ratio of a gear is a number other than 0");
    if (!placed && lw_assembly_gear(assembly, i, &gear, &contact, &why) == LW_OK)
        j->at = contact;
    return LW_OK;
}

/* A weld or a free link without a place is put where the other joints of its links are. */
static void finish_weld(lw_assembly *assembly, int i)
{
    const lw_joint *weld = &assembly->joint[i];
    int link = weld->link[lw_joint_freedoms(weld->kind) == 3 && weld->link[0] == assembly->ground];
    for (int j = 0; j < assembly->n_joint; j++)
        if (lw_joint_has_position(assembly->joint[j].kind) && (assembly->joint[j].link[0] == link || assembly->joint[j].link[1] == link)) {
            assembly->joint[i].at = assembly->joint[j].at;
            return;
        }
}

static lw_status finish_joint(const lw_json_node *joint, lw_assembly *assembly, int i, lw_error *e)
{
    lw_json_node at;
    if (lw_joint_has_ratio(assembly->joint[i].kind))
        return finish_gear(joint, assembly, i, e);
    if (!lw_joint_has_position(assembly->joint[i].kind) && !lw_json_member(joint, "at", &at))
        finish_weld(assembly, i);
    return LW_OK;
}

static lw_status read_joints(const lw_json_node *root, lw_assembly *assembly, lw_error *e)
{
    lw_json_node joints;
    lw_status s = lw_read_need(root, "joints", &joints, e);
    if (s == LW_OK)
        s = lw_read_list(&joints, 1, SIZE_MAX, e);
    if (s == LW_OK)
        s = has_memory(assembly->joint = calloc(lw_json_count(&joints) + 1, sizeof *assembly->joint), e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&joints); i++) {
        lw_json_node joint = lw_json_element(&joints, i);
        s = read_joint(&joint, assembly, &assembly->joint[i], e);
        assembly->n_joint++;
    }
    for (int i = 0; s == LW_OK && i < assembly->n_joint; i++) {
        lw_json_node joint = lw_json_element(&joints, (size_t)i);
        s = finish_joint(&joint, assembly, i, e);
    }
    return s;
}

/* ---- inputs and tracers ------------------------------------------------------------------------ */

/* A tied input has no motion of its own. */
static lw_status read_tie(const lw_json_node *input, const lw_assembly *assembly, lw_input *in, lw_error *e)
{
    static const char *const own[] = { "first", "last", "motion", "speed" };
    lw_json_node n;
    bool given;
    if (!lw_json_member(input, "ratio", &n))
        return LW_OK;
    double unit = lw_assembly_tie_unit(assembly, (int)(in - assembly->input), assembly->units.metre);
    lw_status s = lw_read_optional(input, "ratio", unit, &in->ratio, &given, e);
    if (s == LW_OK && in->ratio == 0)
        return lw_json_fault(&n, e, "a ratio of 0 would hold the joint still; weld it, or leave \"ratio\" out");
    for (size_t i = 0; s == LW_OK && i < COUNT(own); i++)
        if (lw_json_member(input, own[i], &n))
            s = lw_json_fault(&n, e, "\"%s\" is for inputs that move by themselves; this one is tied to the first by its ratio", own[i]);
    return s;
}

static lw_status read_input(const lw_json_node *input, lw_assembly *assembly, lw_input *in, lw_error *e)
{
    static const char *const known[] = { "joint", "value", "first", "last", "motion", "speed", "ratio" };
    lw_json_node joint;
    bool has_value, has_first = false, has_last = false;
    lw_status s = lw_json_expect(input, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(input, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_need(input, "joint", &joint, e)) == LW_OK)
        s = lw_read_joint(&joint, assembly, &in->joint, e);
    if (s != LW_OK)
        return s;
    double unit = lw_joint_slides(assembly->joint[in->joint].kind) ? assembly->units.metre : assembly->units.radian;
    s = lw_read_optional(input, "value", unit, &in->value, &has_value, e);
    if (s == LW_OK)
        s = lw_read_optional(input, "first", unit, &in->first, &has_first, e);
    if (s == LW_OK)
        s = lw_read_optional(input, "last", unit, &in->last, &has_last, e);
    if (s == LW_OK && has_first != has_last)
        s = lw_json_fault(input, e, "\"first\" and \"last\" bound the motion together; give both or none");
    return s == LW_OK ? read_tie(input, assembly, in, e) : s;
}

static lw_status read_inputs(const lw_json_node *root, lw_assembly *assembly, lw_error *e)
{
    lw_json_node one, many;
    bool has_one = lw_json_member(root, "input", &one), has_many = lw_json_member(root, "inputs", &many);
    if (has_one && has_many)
        return lw_json_fault(&many, e, "both \"input\" and \"inputs\" are given; keep one");
    if (!has_one && !has_many)
        return LW_OK;
    lw_status s = has_many ? lw_read_list(&many, 1, SIZE_MAX, e) : LW_OK;
    size_t n = s == LW_OK && has_many ? lw_json_count(&many) : 1;
    if (s == LW_OK)
        s = has_memory(assembly->input = calloc(n, sizeof *assembly->input), e);
    for (size_t i = 0; s == LW_OK && i < n; i++) {
        lw_json_node input = has_many ? lw_json_element(&many, i) : one;
        assembly->n_input++;
        s = read_input(&input, assembly, &assembly->input[i], e);
    }
    return s;
}

static lw_status read_tracer(const lw_json_node *tracer, lw_assembly *assembly, lw_tracer *t, lw_error *e)
{
    static const char *const known[] = { "name", "link", "at", "angle" };
    lw_json_node name, link, at;
    bool given;
    lw_status s = lw_json_expect(tracer, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(tracer, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_need(tracer, "name", &name, e)) == LW_OK)
        s = lw_json_name(&name, t->name, sizeof t->name, e);
    if (s == LW_OK && (s = lw_read_need(tracer, "link", &link, e)) == LW_OK)
        s = lw_read_link(&link, assembly, &t->link, e);
    if (s == LW_OK && (s = lw_read_need(tracer, "at", &at, e)) == LW_OK)
        s = lw_read_pair(&at, assembly->units.metre, &t->at, e);
    if (s == LW_OK)
        s = lw_read_optional(tracer, "angle", assembly->units.radian, &t->angle, &given, e);
    return s;
}

static lw_status read_tracers(const lw_json_node *root, lw_assembly *assembly, lw_error *e)
{
    lw_json_node tracers;
    if (!lw_json_member(root, "tracers", &tracers))
        return LW_OK;
    lw_status s = lw_read_list(&tracers, 0, SIZE_MAX, e);
    if (s == LW_OK)
        s = has_memory(assembly->tracer = calloc(lw_json_count(&tracers) + 1, sizeof *assembly->tracer), e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&tracers); i++) {
        lw_json_node tracer = lw_json_element(&tracers, i);
        s = read_tracer(&tracer, assembly, &assembly->tracer[i], e);
        assembly->n_tracer++;
    }
    return s;
}

/* ---- the whole --------------------------------------------------------------------------------- */

/* The error of the check, with the place of the faulty part in the text. */
static lw_status fault_at(const lw_json_node *root, lw_linkage_place place, const char *text, lw_error *e)
{
    static const char *const list[] = {
        [LW_PART_LINK] = "links", [LW_PART_JOINT] = "joints", [LW_PART_INPUT] = "inputs",
        [LW_PART_TRACER] = "tracers",
    };
    lw_json_node all, one;
    if (place.part == LW_PART_WHOLE || !lw_json_member(root, list[place.part], &all)) {
        bool single = place.part == LW_PART_INPUT && lw_json_member(root, "input", &one);
        return lw_json_fault(single ? &one : root, e, "%s", text);
    }
    one = lw_json_element(&all, (size_t)place.index);
    return lw_json_fault(&one, e, "%s", text);
}

static bool input_has_value(const lw_json_node *root, int i)
{
    lw_json_node inputs, input, value;
    if (lw_json_member(root, "inputs", &inputs))
        input = lw_json_element(&inputs, (size_t)i);
    else
        lw_json_member(root, "input", &input);
    return lw_json_member(&input, "value", &value);
}

lw_status lw_assembly_read_root(const lw_json_node *root, lw_assembly *assembly, lw_error *e)
{
    lw_linkage_place place;
    lw_error fault;
    lw_status s = read_head(root, assembly, e);
    if (s == LW_OK)
        s = read_joints(root, assembly, e);
    if (s == LW_OK)
        s = read_inputs(root, assembly, e);
    if (s == LW_OK)
        s = read_tracers(root, assembly, e);
    lw_status found = s == LW_OK ? lw_assembly_find_fault(assembly, &place, &fault) : s;
    if (s == LW_OK && found == LW_E_MEMORY)
        return lw_error_set(e, found, "%s", fault.text);
    if (s == LW_OK && found != LW_OK)
        s = fault_at(root, place, fault.text, e);
    bool *given = s == LW_OK ? malloc((size_t)assembly->n_input + 1) : NULL;
    for (int i = 0; given && i < assembly->n_input; i++)
        given[i] = input_has_value(root, i);
    if (s == LW_OK && (!given || lw_assembly_set_inputs(assembly, given) != LW_OK))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(given);
    return s;
}

lw_status lw_read_result(lw_json *json, int which, lw_json_node place[4], lw_error *e)
{
    size_t n, at = which > 0 ? (size_t)which - 1 : 0;
    place[0] = lw_json_root(json);
    if (!lw_json_member(&place[0], "results", &place[1]) || lw_json_kind_of(&place[1]) != LW_JSON_ARRAY) {
        place[3] = place[0];
        return which == 0 ? LW_OK : lw_error_at(e, LW_E_ARG, json->file, 0, 0, "result %d is wanted, but the file holds "
                                                "one linkage and no list of results", which);
    }
    if (at >= (n = lw_json_count(&place[1])))
        return lw_error_at(e, LW_E_ARG, json->file, 0, 0, "result %zu is wanted, but there %s %zu", at + 1, n == 1 ? "is" : "are", n);
    place[2] = lw_json_element(&place[1], at);
    if (!lw_json_member(&place[2], "linkage", &place[3]))
        return lw_json_fault(&place[2], e, "this result has no linkage");
    return LW_OK;
}

/* Read an assembly and, unless linkage is NULL, copy it there. */
static lw_status read_result(const char *text, size_t size, const char *file, int which, lw_assembly *a, lw_linkage *linkage, lw_error *e)
{
    lw_json json;
    lw_error fault;
    lw_json_node place[4];
    *a = (lw_assembly){ .units = lw_units_si() };
    lw_status s = lw_json_open(text, size, file, &json, e);
    if (s != LW_OK)
        return s;
    if ((s = lw_read_result(&json, which, place, e)) == LW_OK)
        s = lw_assembly_read_root(&place[3], a, e);
    if (s == LW_OK && linkage && lw_assembly_linkage(a, linkage, &fault) != LW_OK)
        s = lw_json_fault(&place[3], e, "%s", fault.text);
    if (s != LW_OK)
        lw_assembly_free(a);
    lw_json_close(&json);
    return s;
}

lw_status lw_assembly_read_result(const char *text, size_t size, const char *file, int which, lw_assembly *a, lw_error *e)
{
    return read_result(text, size, file, which, a, NULL, e);
}

lw_status lw_linkage_read_result(const char *text, size_t size, const char *file, int which, lw_linkage *linkage, lw_error *e)
{
    lw_assembly a;
    *linkage = (lw_linkage){ .units = lw_units_si() };
    lw_status s = read_result(text, size, file, which, &a, linkage, e);
    lw_assembly_free(&a);
    return s;
}

lw_status lw_linkage_read(const char *text, size_t size, const char *file, lw_linkage *linkage, lw_error *e)
{
    return lw_linkage_read_result(text, size, file, 0, linkage, e);
}
