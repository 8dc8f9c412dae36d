/* grammar/model/spatial_read.c - a spatial model from JSON (docs/notation.md, "Spatial model").  Places and angles are in the
 * units of the file, all other values in SI units. */
#include "grammar/model/spatial.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/suggest.h"
#include "grammar/model/mesh.h"
#include "grammar/model/model_internal.h"

static lw_status has_memory(const void *p, lw_error *e)
{
    return p ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* A name that none of the n before it in the list has. */
static lw_status read_new_name(const lw_json_node *object, const char *what, const char *first, size_t stride, int n,
                               char *out, lw_error *e)
{
    lw_json_node node = *object;
    char name[LW_NAME_SIZE];
    lw_status s = lw_json_kind_of(object) == LW_JSON_OBJECT ? lw_read_need(object, "name", &node, e) : LW_OK;
    if (s == LW_OK)
        s = lw_json_name(&node, name, LW_NAME_SIZE, e);
    if (s == LW_OK && lw_read_find(object->json, name, first, stride, n) >= 0)
        s = lw_json_fault(&node, e, "two %ss are called \"%s\"", what, name);
    if (s == LW_OK)
        memcpy(out, name, sizeof name);
    return s;
}

/* ---- directions and frames --------------------------------------------------------------------- */

/* "frame": {"x": [..], "y": [..]}, two or three axes of a right-handed frame; the identity if it is left out. */
static lw_status read_frame(const lw_json_node *object, lw_mat3 *out, lw_error *e)
{
    static const char *const known[] = { "x", "y", "z" };
    static const double square = 1e-6;       /* cosine of the angle between axes that files may have [1] */
    lw_json_node frame, n;
    lw_vec3 axis[3];
    bool has[3];
    int count = 0;
    *out = lw_m3_columns(lw_v3(1, 0, 0), lw_v3(0, 1, 0), lw_v3(0, 0, 1));
    if (!lw_json_member(object, "frame", &frame))
        return LW_OK;
    lw_status s = lw_json_expect(&frame, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(&frame, known, COUNT(known), e);
    for (int i = 0; s == LW_OK && i < 3; i++) {
        has[i] = lw_json_member(&frame, known[i], &n);
        count += has[i];
        if (has[i])
            s = lw_read_direction(&n, &axis[i], e);
    }
    if (s == LW_OK && count < 2)
        s = lw_json_fault(&frame, e, "a frame needs two of its axes \"x\", \"y\", \"z\"");
    if (s != LW_OK)
        return s;
    for (int i = 0; i < 3; i++)
        for (int k = i + 1; k < 3; k++)
            if (has[i] && has[k] && fabs(lw_v3_dot(axis[i], axis[k])) > square)
                return lw_json_fault(&frame, e, "axes %s and %s are not orthogonal: they make an angle of %.6g degrees",
                                     known[i], known[k], acos(lw_v3_dot(axis[i], axis[k]))*180/LW_PI);
    int first = has[0] ? 0
        : 1;              /* the first axis given is kept; the next two follow it in the order x y z */
    lw_vec3 a = axis[first], other = has[(first + 1)%3] ? axis[(first + 1)%3] : axis[(first + 2)%3];
    other = lw_v3_sub(other, lw_v3_scale(a, lw_v3_dot(a, other)));
    other = lw_v3_scale(other, 1/lw_v3_norm(other));
    lw_vec3 b = has[(first + 1)%3] ? other : lw_v3_cross(other, a), c = lw_v3_cross(a, b), found[3];
    found[first] = a, found[(first + 1)%3] = b, found[(first + 2)%3] = c;
    if (count == 3 && lw_v3_dot(axis[(first + 2)%3], c) < 0)
        return lw_json_fault(&frame, e, "the axes are left-handed: z must be x cross y; turn one of them round");
    *out = lw_m3_columns(found[0], found[1], found[2]);
    return LW_OK;
}

/* ---- links ------------------------------------------------------------------------------------- */

/* Entries xx, yy, zz, xy, xz, yz of frame I frame^T. */
static void turn_tensor(const double given[6], const lw_mat3 *frame, double out[6])
{
    lw_vec3 r[3];                            /* rows of frame I */
    for (int i = 0; i < 3; i++) {
        lw_vec3 f = frame->row[i];
        r[i] = lw_v3(given[0]*f.x + given[3]*f.y + given[4]*f.z, given[3]*f.x + given[1]*f.y + given[5]*f.z,
                     given[4]*f.x + given[5]*f.y + given[2]*f.z);
    }
    for (int i = 0; i < 3; i++)
        out[i] = lw_v3_dot(r[i], frame->row[i]);
    out[3] = lw_v3_dot(r[0], frame->row[1]), out[4] = lw_v3_dot(r[0], frame->row[2]);
    out[5] = lw_v3_dot(r[1], frame->row[2]);
}

/* The tensor in ground axes; refuse what no body can have. */
static lw_status read_inertia(const lw_json_node *link, const lw_mat3 *frame, double out[6], lw_error *e)
{
    lw_json_node n;
    double given[6] = { 0 }, value[3];
    lw_mat3 axes;
    if (!lw_json_member(link, "inertia", &n))
        return LW_OK;
    lw_status s = lw_json_expect(&n, LW_JSON_ARRAY, e);
    size_t count = s == LW_OK ? lw_json_count(&n) : 0;
    if (s == LW_OK && count != 3 && count != 6)
        return lw_json_fault(&n, e, "an inertia in space has 3 numbers [Ixx, Iyy, Izz], or 6 with Ixy, Ixz, Iyz, the "
                                    "entries of the matrix");
    for (size_t i = 0; s == LW_OK && i < count; i++) {
        lw_json_node part = lw_json_element(&n, i);
        s = lw_json_number(&part, &given[i], e);
        if (s == LW_OK && !(fabs(given[i]) < 1e150))
            s = lw_json_fault(&part, e, "this number is too large");
    }
    if (s != LW_OK)
        return s;
    lw_m3_principal(given, value, &axes);
    double top = fmax(value[0], fmax(value[1], value[2])), sum = value[0] + value[1] + value[2];
    for (int i = 0; i < 3; i++)
        if (value[i] < -1e-12*top || top <= 0 ? value[i] != 0 : 2*value[i] > sum*(1 + 1e-9))
            return lw_json_fault(&n, e, "no body has this inertia: its principal values are %.6g, %.6g, %.6g kg m^2; "
                                        "none may be negative or exceed the sum of the "
                                        "others", value[0], value[1], value[2]);
    turn_tensor(given, frame, out);
    return LW_OK;
}

/* "mesh": the surface of the body, its axes those of the link's frame; the mass is the link's own or follows from a "density". */
static lw_status read_mesh(const lw_json_node *mesh, const lw_mat3 *frame, double metre, lw_spatial_body *b, lw_error *e)
{
    static const char *const known[] = { "file", "density", "unit", "at" };
    char path[LW_PATH_SIZE], *text = NULL;
    size_t size;
    lw_units units = { .metre = metre };
    lw_json_node n;
    lw_vec3 at = { 0 };
    lw_mesh_integrals found;
    double density = 0;
    bool has_density = false;
    const lw_number_key key = { "density", 1, LW_POSITIVE, &density, &has_density };
    lw_status s = lw_json_expect(mesh, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(mesh, known, COUNT(known), e)) == LW_OK)
        s = lw_read_numbers(mesh, &key, 1, e);
    if (s == LW_OK && has_density == b->given)
        s = lw_json_fault(mesh, e, "a mesh needs a \"density\" [kg/m^3], or the link a \"mass\" [kg]%s", has_density ? "; keep one" : "");
    if (s == LW_OK && lw_json_member(mesh, "at", &n))
        s = lw_read_triple(&n, metre, &at, e);
    if (s == LW_OK && lw_json_member(mesh, "unit", &n) && (s = lw_json_expect(&n, LW_JSON_TEXT, e)) == LW_OK &&
        !lw_units_set_length(&units, lw_json_text(&n)))
        s = lw_json_fault(&n, e, "unknown unit of length \"%s\"", lw_json_text(&n));
    if (s == LW_OK && (s = lw_read_beside(mesh, "file", ".stl", "a mesh of triangles", path, &text, &size, &n, e)) == LW_OK)
        s = lw_mesh_read(text, size, path, &found, e);
    free(text);
    if (s != LW_OK)
        return s;
    double unit = units.metre;
    if (has_density)
        b->mass = density*found.volume*unit*unit*unit;
    for (int i = 0; i < 6; i++)
        found.inertia[i] *= b->mass/found.volume*unit*unit;
    turn_tensor(found.inertia, frame, b->inertia);
    b->centre = lw_v3_add(at, lw_m3_apply(frame, lw_v3_scale(found.centre, unit)));
    b->given = true;
    return LW_OK;
}

/* The keys of contacts are known in the plane alone. */
static lw_status refuse_contact(const lw_json_node *object, lw_error *e)
{
    static const char *const planar[] = { "shapes", "contacts", "ropes" };
    lw_json_node at;
    for (int i = 0; i < COUNT(planar); i++)
        if (lw_json_member(object, planar[i], &at))
            return lw_json_fault(&at, e, "\"%s\" is for planar models: links in space do not touch each other. A \"stop\" of a joint, or a spring with a "
                                 "\"law\" that only pushes or only pulls, limits motion there", planar[i]);
    return LW_OK;
}

static lw_status read_link(const lw_json_node *link, lw_spatial *m, lw_error *e)
{
    static const char *const known[] = { "name", "mass", "centre", "inertia", "frame", "velocity", "angular_velocity",
                                         "elastic", "mesh" };
    lw_spatial_body *b = &m->body[m->n_link];
    lw_json_node n, centre, elastic, mesh;
    lw_mat3 frame;
    const lw_number_key mass = { "mass", 1, LW_NOT_NEGATIVE, &b->mass, &b->given };
    lw_status s = read_new_name(link, "link", LW_NAMES(m->body, m->n_link, lw_spatial_body), b->name, e);
    if (s != LW_OK)
        return s;
    m->n_link++;
    if (lw_json_kind_of(link) != LW_JSON_OBJECT)
        return LW_OK;
    bool has_centre = lw_json_member(link, "centre", &centre), has_inertia = lw_json_member(link, "inertia", &n);
    if ((s = refuse_contact(link, e)) == LW_OK && (s = lw_json_known_keys(link, known, COUNT(known), e)) == LW_OK && has_centre)
        s = lw_read_triple(&centre, m->units.metre, &b->centre, e);
    if (s == LW_OK && (s = read_frame(link, &frame, e)) == LW_OK &&
        (s = read_inertia(link, &frame, b->inertia, e)) == LW_OK)
        s = lw_read_numbers(link, &mass, 1, e);
    if (s == LW_OK && lw_json_member(link, "mesh", &mesh)) {
        if (has_centre || has_inertia || lw_json_member(link, "elastic", &n))
            return lw_json_fault(&mesh, e, "the centre and inertia of link \"%s\" follow from its mesh; leave out \"%s\"", b->name,
                                 has_centre ? "centre" : has_inertia ? "inertia" : "elastic");
        s = read_mesh(&mesh, &frame, m->units.metre, b, e);
        has_centre = true;
    }
    if (s == LW_OK && lw_json_member(link, "elastic", &elastic)) {
        if ((s = lw_elastic_check_link(link, &elastic, false, e)) == LW_OK)
            s = lw_elastic_read(&elastic, m->units.metre, true, &m->elastic[m->n_link - 1], e);
        m->n_elastic++;
    }
    if (s == LW_OK && (b->has_velocity = lw_json_member(link, "velocity", &n)))
        s = lw_read_triple(&n, 1, &b->velocity, e);
    if (s == LW_OK && (b->has_omega = lw_json_member(link, "angular_velocity", &n)))
        s = lw_read_triple(&n, 1, &b->omega, e);
    if (s == LW_OK && !b->given && (has_centre || has_inertia))
        s = lw_json_fault(link, e, "link \"%s\" has %s but no \"mass\"; write one [kg], 0 is allowed", b->name,
                          has_centre ? "a centre of mass" : "an inertia");
    if (s == LW_OK && b->mass > 0 && !has_centre)
        s = lw_json_fault(link, e, "link \"%s\" has a mass but no \"centre\" where it acts", b->name);
    return s;
}

static lw_status reserve_links(lw_spatial *m, size_t n, lw_error *e)
{
    m->body = calloc(n, sizeof *m->body);
    m->elastic = calloc(n, sizeof *m->elastic);
    return has_memory(m->body && m->elastic ? m->body : NULL, e);
}

/* Without "links" the links are the ground and all links that joints name, in that order. */
static lw_status gather_links(const lw_json_node *root, const lw_json_node *ground, lw_spatial *m, lw_error *e)
{
    lw_json_node joints, links;
    lw_status s = lw_read_need(root, "joints", &joints, e);
    if (s == LW_OK && (s = lw_read_list(&joints, 1, SIZE_MAX, e)) == LW_OK)
        s = reserve_links(m, 2*lw_json_count(&joints) + 2, e);
    if (s == LW_OK && ground)
        s = read_link(ground, m, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&joints); i++) {
        lw_json_node joint = lw_json_element(&joints, i);
        s = lw_json_expect(&joint, LW_JSON_OBJECT, e);
        if (s == LW_OK && (s = lw_read_need(&joint, "links", &links, e)) == LW_OK)
            s = lw_read_list(&links, 2, 2, e);
        for (size_t end = 0; s == LW_OK && end < 2; end++) {
            lw_json_node link = lw_json_element(&links, end);
            char name[LW_NAME_SIZE];
            s = lw_json_name(&link, name, sizeof name, e);
            if (s == LW_OK && lw_read_find(link.json, name, LW_NAMES(m->body, m->n_link, lw_spatial_body)) < 0)
                memcpy(m->body[m->n_link++].name, name, sizeof name);
        }
    }
    return s;
}

static lw_status read_links(const lw_json_node *root, lw_spatial *m, lw_error *e)
{
    lw_json_node links = *root, ground;
    bool has_ground = lw_json_member(root, "ground", &ground);
    lw_status s = LW_OK;
    if (!lw_json_member(root, "links", &links))
        s = gather_links(root, has_ground ? &ground : NULL, m, e);
    else if ((s = lw_read_list(&links, 2, SIZE_MAX, e)) == LW_OK &&
             (s = reserve_links(m, lw_json_count(&links) + 1, e)) == LW_OK)
        for (size_t i = 0; s == LW_OK && i < lw_json_count(&links); i++) {
            lw_json_node link = lw_json_element(&links, i);
            s = read_link(&link, m, e);
        }
    if (s != LW_OK)
        return s;
    if (has_ground)
        s = lw_spatial_read_link(&ground, m, &m->ground, e);
    else
        m->ground = lw_read_find(root->json, "ground", LW_NAMES(m->body, m->n_link, lw_spatial_body));
    if (s == LW_OK && m->ground < 0)
        return lw_json_fault(root, e, "\"ground\" is missing: name the fixed link, or call a link \"ground\"");
    if (s == LW_OK && (m->body[m->ground].has_velocity || m->body[m->ground].has_omega))
        return lw_json_fault(&links, e, "the ground does not move: leave \"velocity\" and \"angular_velocity\" of \"%s\" out", m->body[m->ground].name);
    return s != LW_OK || !m->elastic[m->ground].given ? s
         : lw_json_fault(&links, e, "the ground \"%s\" cannot be elastic; weld an elastic link to it", m->body[m->ground].name);
}

/* ---- joints ------------------------------------------------------------------------------------ */

static lw_status read_kind(const lw_json_node *joint, lw_spatial_kind *kind, lw_error *e)
{
    lw_json_node n;
    *kind = LW_SPATIAL_REVOLUTE;
    if (!lw_json_member(joint, "kind", &n))
        return LW_OK;
    lw_status s = lw_json_expect(&n, LW_JSON_TEXT, e);
    const char *text = s == LW_OK ? lw_json_text(&n) : "";
    const char *names[LW_SPATIAL_FREE + 1];
    for (int i = 0; s == LW_OK && i <= LW_SPATIAL_FREE; i++) {
        const lw_spatial_kind_row *row = lw_spatial_kind_of((lw_spatial_kind)i);
        names[i] = row->word;
        if (strcmp(text, row->word) == 0 || (text[0] == row->letter && !text[1])) {
            *kind = (lw_spatial_kind)i;
            return LW_OK;
        }
    }
    if (s != LW_OK)
        return s;
    if (!strcmp(text, "p") || !strcmp(text, "g"))
        return lw_json_fault(&n, e, text[0] == 'g' ? "gears (\"g\") are known in planar models only; in space they are \"couplings\""
                             : "pins in slots (\"p\") are known in planar models only");
    const char *near = lw_suggest(text, names, COUNT(names));
    return lw_json_fault(&n, e, "there is no joint kind \"%.40s\"%s%s%s; known are r revolute, t prismatic, c "
                                "cylindrical, b spherical, u universal, h screw, e planar, f fixed, o "
                                "free", text, LW_DID_YOU_MEAN(near));
}

/* The axes of a joint. */
static lw_status read_axes(const lw_json_node *joint, const lw_spatial *m, lw_spatial_joint *j, lw_error *e)
{
    const char *word = lw_spatial_kind_of(j->kind)->word;
    bool wants = lw_spatial_kind_of(j->kind)->turns || lw_spatial_kind_of(j->kind)->slides || j->kind ==
        LW_SPATIAL_UNIVERSAL;
    bool two = j->kind == LW_SPATIAL_UNIVERSAL, screw = j->kind == LW_SPATIAL_SCREW, given = false;
    lw_json_node n, second;
    lw_status s = LW_OK;
    if (lw_json_member(joint, "axis", &n) != wants)
        return wants ? lw_json_fault(joint, e, "a %s joint needs its \"axis\": [x, y, z]", word)
                     : lw_json_fault(&n, e, "a %s joint has no axis", word);
    if (wants)
        s = lw_read_direction(&n, &j->axis, e);
    if (s != LW_OK)
        return s;
    if (lw_json_member(joint, "second_axis", &second) != two)
        return two ? lw_json_fault(joint, e, "a universal joint needs \"second_axis\": the axis on its second link; "
                                             "\"axis\" is on the first")
                   : lw_json_fault(&second, e, "a %s joint has no second axis", word);
    if (two && (s = lw_read_direction(&second, &j->second, e)) == LW_OK &&
        lw_v3_norm(lw_v3_cross(j->axis, j->second)) < 1e-6)
        s = lw_json_fault(&second, e, "the axes of a universal joint must not be parallel");
    const lw_number_key lead = { "lead", m->units.metre, LW_ANY, &j->lead, &given };
    if (s == LW_OK)
        s = lw_read_numbers(joint, &lead, 1, e);
    if (s == LW_OK && given != screw)
        s = lw_json_fault(joint, e, screw ? "a screw joint needs its \"lead\", the slide per turn"
                          : "only screws have a \"lead\"");
    if (s == LW_OK && screw && j->lead == 0)
        s = lw_json_fault(joint, e, "a lead of 0 makes no screw: use a revolute joint");
    return s;
}

static lw_status read_stop(const lw_json_node *joint, const lw_spatial *m, lw_spatial_joint *j, lw_error *e)
{
    lw_json_node n;
    if (!lw_json_member(joint, "stop", &n))
        return LW_OK;
    const lw_spatial_kind_row *kind = lw_spatial_kind_of(j->kind);
    if (!kind->turns && !kind->slides)
        return lw_json_fault(&n, e, "a %s joint has no coordinate that a stop could limit", kind->word);
    lw_status s = lw_json_expect(&n, LW_JSON_OBJECT, e);
    return s == LW_OK ? lw_read_stop(&n, kind->turns ? m->units.radian : m->units.metre, &j->stop, e) : s;
}

static lw_status read_cone(const lw_json_node *joint, const lw_spatial *m, lw_spatial_joint *j, lw_error *e)
{
    static const char *const known[] = { "axis", "angle" };
    lw_json_node n, axis;
    if (!lw_json_member(joint, "cone", &n))
        return LW_OK;
    const lw_number_key angle = { "angle", m->units.radian, 1e-9, LW_PI, &j->cone, &j->has_cone };
    if (j->kind != LW_SPATIAL_SPHERICAL && j->kind != LW_SPATIAL_UNIVERSAL)
        return lw_json_fault(&n, e, "only spherical and universal joints have a \"cone\"");
    lw_status s = lw_json_expect(&n, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(&n, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_need(&n, "axis", &axis, e)) == LW_OK && (s = lw_read_direction(&axis, &j->cone_axis, e)) == LW_OK &&
        (s = lw_read_need(&n, "angle", &axis, e)) == LW_OK)
        s = lw_read_numbers(&n, &angle, 1, e);
    return s;
}

/* The kinds of joints that lw_spatial_open can open. */
static lw_status read_clearance(const lw_json_node *joint, const lw_spatial *m, lw_spatial_joint *j, lw_error *e)
{
    lw_json_node n;
    if (!lw_json_member(joint, "clearance", &n))
        return LW_OK;
    if (j->kind != LW_SPATIAL_SPHERICAL && j->kind != LW_SPATIAL_REVOLUTE)
        return lw_json_fault(&n, e, "in space only spherical and revolute joints have a \"clearance\"");
    lw_status s = lw_read_clearance(&n, m->units.metre, &j->clearance, e);
    if (s == LW_OK && j->clearance.model == LW_CLEARANCE_LINK)
        s = lw_json_fault(&n, e, "the model \"link\" is known in the plane only; in space take \"impact\", \"mlsd\", "
                                 "\"hunt-crossley\", \"lankarani-nikravesh\", or \"zero\" for a joint without clearance");
    return s;
}

/* Friction of a clearance is that of its joint: kept there, with the radius at which it acts. */
static lw_status take_contact_friction(const lw_json_node *joint, lw_spatial_joint *j, lw_error *e)
{
    if (!(j->clearance.friction > 0))
        return LW_OK;
    j->friction.coefficient = j->clearance.friction, j->friction.speed = j->clearance.friction_speed;
    return j->friction.radius > 0 ? LW_OK
         : lw_json_fault(joint, e, "friction of a clearance acts at the radius of the pin or ball: give the joint \"friction\": "
                                   "{\"coefficient\": %g, \"radius\": ...}", j->clearance.friction);
}

static lw_status read_friction(const lw_json_node *n, const lw_spatial *m, lw_spatial_joint *j, lw_error *e)
{
    bool known = j->kind <= LW_SPATIAL_UNIVERSAL;
    if (!known)
        return lw_json_fault(n, e, "a %s joint has no friction here; revolute, prismatic, cylindrical, spherical and universal joints "
                                   "have", lw_spatial_kind_of(j->kind)->word);
    return lw_read_friction(n, m->units.metre, j->kind != LW_SPATIAL_PRISMATIC, &j->friction, e);
}

static lw_status read_joint(const lw_json_node *joint, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    static const char *const known[] = { "name", "kind", "links", "at", "axis", "second_axis", "lead", "stop", "cone",
                                         "friction", "clearance" };
    lw_spatial_joint *j = &m->joint[index];
    lw_json_node links, n;
    lw_status s = lw_json_expect(joint, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(joint, known, COUNT(known), e)) == LW_OK &&
        (s = read_new_name(joint, "joint", LW_NAMES(m->joint, m->n_joint, lw_spatial_joint), j->name, e)) == LW_OK)
        s = read_kind(joint, &j->kind, e);
    if (s == LW_OK && (s = lw_read_need(joint, "links", &links, e)) == LW_OK)
        s = lw_read_list(&links, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node link = lw_json_element(&links, end);
        s = lw_spatial_read_link(&link, m, &j->link[end], e);
    }
    if (s == LW_OK && j->link[0] == j->link[1])
        s = lw_json_fault(&links, e, "a joint joins two different links, here both are \"%s\"",
                          m->body[j->link[0]].name);
    bool placed = lw_json_member(joint, "at", &n), loose = j->kind == LW_SPATIAL_FIXED || j->kind == LW_SPATIAL_FREE;
    if (s == LW_OK && (placed || !loose) && (s = lw_read_need(joint, "at", &n, e)) == LW_OK)
        s = lw_read_triple(&n, m->units.metre, &j->at, e);
    if (s == LW_OK && !placed)               /* anywhere: at the mass, which keeps the size of the scene */
        j->at = m->body[j->link[1]].centre;
    if (s == LW_OK && (s = read_axes(joint, m, j, e)) == LW_OK && (s = read_stop(joint, m, j, e)) == LW_OK &&
        (s = read_cone(joint, m, j, e)) == LW_OK)
        s = read_clearance(joint, m, j, e);
    if (s == LW_OK && lw_json_member(joint, "friction", &n))
        s = read_friction(&n, m, j, e);
    if (s == LW_OK)
        s = take_contact_friction(joint, j, e);
    m->n_joint++;
    return s;
}

/* Every link is joined to the ground, be it by a free joint. */
static lw_status check_connected(const lw_json_node *root, const lw_spatial *m, lw_error *e)
{
    lw_json_node joints = *root;
    bool *reached = calloc((size_t)m->n_link, sizeof *reached), more = true;
    if (!reached)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    reached[m->ground] = true;
    while (more) {
        more = false;
        for (int j = 0; j < m->n_joint; j++) {
            const int *l = m->joint[j].link;
            if (reached[l[0]] != reached[l[1]])
                reached[l[0]] = reached[l[1]] = more = true;
        }
    }
    int lost = 0;
    while (lost < m->n_link && reached[lost])
        lost++;
    free(reached);
    lw_json_member(root, "joints", &joints);
    return lost == m->n_link ? LW_OK
         : lw_json_fault(&joints, e, "no chain of joints connects link \"%s\" to the ground; a body that flies freely "
                                     "has a joint of kind \"free\" with the ground", m->body[lost].name);
}

/* ---- inputs and tracers ------------------------------------------------------------------------ */

static lw_status read_input(const lw_json_node *input, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    static const char *const known[] = { "joint", "tracer", "coordinate", "value", "first", "last", "motion", "speed" };
    lw_spatial_input *in = &m->input[m->n_input++];
    lw_json_node n;
    bool has_value, has_first = false, has_last = false;
    lw_status s = lw_json_expect(input, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(input, known, COUNT(known), e)) == LW_OK)
        s = lw_spatial_read_measure(input, m, true, "an input", &in->measure, e);
    if (s != LW_OK)
        return s;
    double unit = lw_spatial_measure_unit(m, in->measure);
    const lw_number_key numbers[] = {
        { "value", unit, LW_ANY, &in->value, &has_value }, { "first", unit, LW_ANY, &in->first, &has_first },
        { "last", unit, LW_ANY, &in->last, &has_last }, { "speed", 1, LW_ANY, &in->speed, &in->has_speed },
    };
    if (in->measure.of >= LW_OF_X) {
        const lw_vec3 *at = &m->tracer[in->measure.index].at;
        in->value = in->measure.of == LW_OF_X ? at->x : in->measure.of == LW_OF_Y ? at->y : at->z;
        if (lw_json_member(input, "value", &n))
            return lw_json_fault(&n, e, "the value of a tracer's coordinate in the posture is where the tracer is");
    }
    s = lw_read_numbers(input, numbers, COUNT(numbers), e);
    if (s == LW_OK && has_first != has_last)
        s = lw_json_fault(input, e, "\"first\" and \"last\" bound the motion together; give both or none");
    in->has_range = has_first && in->first != in->last;
    for (int i = 0; s == LW_OK && i + 1 < m->n_input; i++)
        if (m->input[i].measure.of == in->measure.of && m->input[i].measure.index == in->measure.index)
            s = lw_json_fault(input, e, "this is an input already");
    if (s == LW_OK && in->has_speed && lw_json_member(input, "motion", &n))
        return lw_json_fault(&n, e, "\"motion\" says where the input is at every time, \"speed\" how fast it starts "
                                    "before it runs freely; keep one");
    return s == LW_OK ? lw_read_expression(input, "motion", r, LW_OF_TIME, &in->motion, e) : s;
}

static lw_status read_inputs(const lw_json_node *root, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    lw_json_node one, many;
    bool has_one = lw_json_member(root, "input", &one), has_many = lw_json_member(root, "inputs", &many);
    if (has_one && has_many)
        return lw_json_fault(&many, e, "both \"input\" and \"inputs\" are given; keep one");
    lw_status s = has_many ? lw_read_list(&many, 1, SIZE_MAX, e) : LW_OK;
    size_t n = s == LW_OK && has_many ? lw_json_count(&many) : has_one;
    if (s == LW_OK)
        s = has_memory(m->input = calloc(n + 1, sizeof *m->input), e);
    for (size_t i = 0; s == LW_OK && i < n; i++) {
        lw_json_node input = has_many ? lw_json_element(&many, i) : one;
        s = read_input(&input, r, e);
    }
    return s;
}

/* "drives": joints whose motors move the model when the inputs prescribe a tool. */
static lw_status read_drives(const lw_json_node *root, lw_spatial *m, lw_error *e)
{
    static const char *const known[] = { "joint", "coordinate" };
    lw_json_node all;
    if (!lw_json_member(root, "drives", &all))
        return LW_OK;
    lw_status s = lw_read_list(&all, 1, SIZE_MAX, e);
    if (s == LW_OK)
        s = has_memory(m->drive = calloc(lw_json_count(&all), sizeof *m->drive), e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&all); i++) {
        lw_json_node one = lw_json_element(&all, i);
        lw_spatial_measure *d = &m->drive[m->n_drive++];
        s = lw_json_expect(&one, LW_JSON_OBJECT, e);
        if (s == LW_OK && (s = lw_json_known_keys(&one, known, COUNT(known), e)) == LW_OK)
            s = lw_spatial_read_measure(&one, m, false, "a drive", d, e);
        for (int k = 0; s == LW_OK && k + 1 < m->n_drive; k++)
            if (m->drive[k].of == d->of && m->drive[k].index == d->index)
                s = lw_json_fault(&one, e, "this is a drive already");
    }
    return s;
}

/* "couplings": gears, belts and ropes as sums of turns and slides that stay as they are. */
static lw_status read_coupling(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    static const char *const known[] = { "name", "terms" }, *const known_of_term[] = { "joint", "coordinate", "factor" };
    lw_spatial_coupling *c = &m->coupling[index];
    lw_json_node all;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK &&
        (s = read_new_name(object, "coupling", LW_NAMES(m->coupling, m->n_coupling, lw_spatial_coupling), c->name, e)) == LW_OK &&
        (s = lw_read_need(object, "terms", &all, e)) == LW_OK)
        s = lw_read_list(&all, 2, SIZE_MAX, e);
    m->n_coupling++;
    if (s == LW_OK) {
        c->of = calloc(lw_json_count(&all), sizeof *c->of);
        c->factor = calloc(lw_json_count(&all), sizeof *c->factor);
        s = has_memory(c->of && c->factor ? c : NULL, e);
    }
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&all); i++) {
        lw_json_node one = lw_json_element(&all, i), n;
        lw_spatial_measure *of = &c->of[c->n];
        double *factor = &c->factor[c->n];
        if ((s = lw_json_expect(&one, LW_JSON_OBJECT, e)) == LW_OK &&
            (s = lw_json_known_keys(&one, known_of_term, COUNT(known_of_term), e)) == LW_OK &&
            (s = lw_spatial_read_measure(&one, m, false, "a coupling", of, e)) == LW_OK && (s = lw_read_need(&one, "factor", &n, e)) == LW_OK)
            s = lw_json_number(&n, factor, e);
        if (s == LW_OK && !(fabs(*factor) > 1e-9 && fabs(*factor) < 1e9))
            s = lw_json_fault(&n, e, "a factor lies between 1e-9 and 1e9, or is negative");
        for (int k = 0; s == LW_OK && k < c->n; k++)
            if (c->of[k].of == of->of && c->of[k].index == of->index)
                s = lw_json_fault(&one, e, "this is a term already");
        c->n++;
    }
    for (int i = 0; s == LW_OK && lw_spatial_coupling_slides(c) && i < c->n; i++)
        c->factor[i] *= c->of[i].of == LW_OF_TURN ? m->units.metre : 1;
    return s;
}

static lw_status read_tracer(const lw_json_node *tracer, size_t index, const lw_reading *r, lw_error *e)
{
    lw_spatial *m = r->model;
    static const char *const known[] = { "name", "link", "at", "frame" };
    lw_spatial_tracer *t = &m->tracer[index];
    lw_json_node link, at;
    lw_mat3 frame;
    lw_status s = lw_json_expect(tracer, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(tracer, known, COUNT(known), e)) == LW_OK &&
        (s = read_new_name(tracer, "tracer", LW_NAMES(m->tracer, m->n_tracer, lw_spatial_tracer), t->name, e)) == LW_OK &&
        (s = lw_read_need(tracer, "link", &link, e)) == LW_OK && (s = lw_spatial_read_link(&link, m, &t->link, e)) == LW_OK &&
        (s = lw_read_need(tracer, "at", &at, e)) == LW_OK && (s = lw_read_triple(&at, m->units.metre, &t->at, e)) ==
            LW_OK)
        s = read_frame(tracer, &frame, e);
    if (s == LW_OK)
        t->frame = lw_quaternion_of_matrix(&frame);
    m->n_tracer++;
    return s;
}

/* ---- the whole --------------------------------------------------------------------------------- */

static lw_status check_centres(const lw_json_node *root, const lw_spatial *m, lw_error *e)
{
    double extent = 0;
    lw_status s = LW_OK;
    for (int i = 0; i < m->n_joint; i++)
        extent = lw_spatial_kind_of(m->joint[i].kind)->rows > 0 ? fmax(extent, lw_v3_norm(lw_v3_sub(m->joint[i].at, m->joint[0].at))) : extent;
    for (int i = 0; i < m->n_tracer; i++)
        extent = fmax(extent, lw_v3_norm(lw_v3_sub(m->tracer[i].at, m->joint[0].at)));
    for (int i = 0; s == LW_OK && i < 2*m->n_joint; i++) {
        const lw_spatial_joint *j = &m->joint[i/2];
        const lw_spatial_body *b = &m->body[j->link[i % 2]];
        if (lw_spatial_kind_of(j->kind)->rows > 0 && b->mass > 0)
            s = lw_read_check_centre(root, j->link[i % 2], b->name, lw_v3_norm(lw_v3_sub(b->centre, j->at)), extent, e);
    }
    return s;
}

static lw_status read_root(const lw_json_node *root, lw_spatial *m, lw_error *e)
{
    static const char *const known[] = { "linkwright", "name", "units", "links", "ground", "joints", "input", "inputs",
                                         "drives", "tracers", "$schema", "gravity", "springs", "dampers", "forces",
                                         "motors", "profiles", "states", "controllers", "cylinders", "couplings" };
    static const struct { const char *key; lw_read_one *read; } load[] = {
        { "springs", lw_read_spring }, { "dampers", lw_read_damper }, { "cylinders", lw_states_read_cylinder_ends },
        { "controllers", lw_states_read_controller }, { "forces", lw_read_force }, { "motors", lw_read_motor }
    };
    const lw_reading r = lw_spatial_reading(m);
    lw_json_node n;
    lw_status s = lw_json_expect(root, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_read_version(root, e)) == LW_OK && (s = refuse_contact(root, e)) == LW_OK)
        s = lw_json_known_keys(root, known, COUNT(known), e);
    if (s == LW_OK && lw_json_member(root, "name", &n)) {
        s = lw_json_expect(&n, LW_JSON_TEXT, e);
        if (s == LW_OK && *lw_json_text(&n))
            s = lw_json_name(&n, m->name, sizeof m->name, e);
    }
    if (s == LW_OK && (s = lw_read_units(root, &m->units, e)) == LW_OK)
        s = read_links(root, m, e);
    if (s != LW_OK)
        return s;
    size_t springs = lw_read_count(root, "springs") + lw_read_count(root, "dampers") + 1;
    m->joint = calloc(lw_read_count(root, "joints") + 1, sizeof *m->joint);
    m->coupling = calloc(lw_read_count(root, "couplings") + 1, sizeof *m->coupling);
    m->tracer = calloc(lw_read_count(root, "tracers") + 1, sizeof *m->tracer);
    size_t motors = lw_read_count(root, "motors") + 1;
    m->spring = calloc(springs + lw_read_count(root, "cylinders"), sizeof *m->spring);
    m->joint_spring = calloc(springs + motors, sizeof *m->joint_spring);
    m->force = calloc(2*lw_read_count(root, "forces") + 1, sizeof *m->force);
    m->motor = calloc(motors, sizeof *m->motor);
    m->states.rotor = calloc(motors, sizeof *m->states.rotor);
    if (!m->joint || !m->coupling || !m->tracer || !m->spring || !m->joint_spring || !m->force || !m->motor || !m->states.rotor)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if ((s = lw_read_need(root, "joints", &n, e)) == LW_OK && (s = lw_read_list(&n, 1, SIZE_MAX, e)) == LW_OK &&
        (s = lw_read_each(root, "joints", read_joint, &r, e)) == LW_OK && (s = check_connected(root, m, e)) == LW_OK &&
        (s = lw_read_each(root, "couplings", read_coupling, &r, e)) == LW_OK &&
        (s = lw_read_each(root, "tracers", read_tracer, &r, e)) == LW_OK && (s = check_centres(root, m, e)) == LW_OK &&
        (s = lw_moves_read_profiles(root, &m->n_profile, &m->profile, e)) == LW_OK && (s = read_inputs(root, &r, e)) == LW_OK)
        s = read_drives(root, m, e);
    if (s == LW_OK && lw_json_member(root, "gravity", &n))
        s = lw_read_triple(&n, 1, &m->gravity, e);
    if (s == LW_OK)
        s = lw_states_name(root, &m->states, e);
    for (int i = 0; s == LW_OK && i < COUNT(load); i++)
        s = lw_read_each(root, load[i].key, load[i].read, &r, e);
    return s == LW_OK ? lw_states_read(root, &r, e) : s;
}

lw_status lw_spatial_read(const char *text, size_t size, const char *file, lw_spatial *m, lw_error *e)
{
    lw_json json;
    memset(m, 0, sizeof *m);
    m->units = lw_units_si();
    lw_status s = lw_json_open(text, size, file, &json, e);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&json);
    s = read_root(&root, m, e);
    if (s == LW_OK)
        s = lw_spatial_add_rotors(&root, m, e);
    m->files = json.beside;
    json.beside = NULL;
    lw_json_close(&json);
    if (s != LW_OK)
        lw_spatial_free(m);
    return s;
}

/* Is it a kind of joints in space alone: a letter, or one of the words? */
static bool names_spatial_kind(const lw_json_node *joint)
{
    lw_json_node kind;
    const char *word = lw_json_member(joint, "kind", &kind) ? lw_json_text(&kind) : NULL;
    bool found = word && strlen(word) == 1 && strchr("cbuheo", *word);
    for (int k = 0; word && strlen(word) > 1 && k <= LW_SPATIAL_FREE; k++)
        found = found || strcmp(word, lw_spatial_kind_of((lw_spatial_kind)k)->word) == 0;
    return found;
}

bool lw_spatial_text(const char *text, size_t size)
{
    bool spatial;
    return lw_spatial_recognise(text, size, &spatial) == LW_OK && spatial;
}

lw_status lw_spatial_recognise(const char *text, size_t size, bool *spatial)
{
    static const char *const list[] = { "joints", "tracers" }, *const key[] = { "at", "axis" };
    lw_json json;
    lw_json_node all, n;
    bool three = false, two = false, word = false;
    *spatial = false;
    lw_status s = lw_json_open(text, size, "", &json, NULL);
    if (s != LW_OK)
        return s == LW_E_MEMORY ? s : LW_OK;
    lw_json_node root = lw_json_root(&json);
    for (int l = 0; l < 2; l++)
        if (lw_json_kind_of(&root) == LW_JSON_OBJECT && lw_json_member(&root, list[l], &all) &&
            lw_json_kind_of(&all) == LW_JSON_ARRAY)
            for (size_t i = 0; !three && i < lw_json_count(&all); i++) {
                lw_json_node one = lw_json_element(&all, i);
                if (lw_json_kind_of(&one) != LW_JSON_OBJECT)
                    continue;
                word = word || names_spatial_kind(&one);
                for (int k = 0; k < 2; k++)
                    if (lw_json_member(&one, key[k], &n) && lw_json_kind_of(&n) == LW_JSON_ARRAY) {
                        three = three || lw_json_count(&n) == 3;
                        two = two || lw_json_count(&n) == 2;
                    }
            }
    lw_json_close(&json);
    *spatial = three || (word && !two);
    return LW_OK;
}
