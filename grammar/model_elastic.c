/* grammar/model_elastic.c - "elastic" of a link (docs/notation.md, "Elastic links"). */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "grammar/model_internal.h"
#include "grammar/read_internal.h"

/* "damping": a time, or a ratio at a frequency: d = 2 ratio/omega. */
static lw_status read_elastic_damping(const lw_json_node *n, lw_elastic *p, lw_error *e)
{
    static const char *const known[] = { "ratio", "at" };
    double ratio = 0, at = 0;
    lw_json_node need;
    if (lw_json_kind_of(n) == LW_JSON_NUMBER) {
        lw_status s = lw_json_number(n, &p->damping, e);
        return s != LW_OK || p->damping >= 0 ? s : lw_json_fault(n, e, "this time [s] must not be negative");
    }
    if (lw_json_kind_of(n) != LW_JSON_OBJECT)
        return lw_json_fault(n, e, "the damping of an elastic link is a time d [s], for damping d times the stiffness, or "
                             "{\"ratio\": ..., \"at\": a frequency in Hz}");
    const lw_number_key numbers[] = { { "ratio", 1, 0, 1, &ratio, NULL }, { "at", 1, LW_POSITIVE, &at, NULL } };
    lw_status s = lw_json_known_keys(n, known, COUNT(known), e);
    if (s == LW_OK && (s = lw_read_need(n, "ratio", &need, e)) == LW_OK && (s = lw_read_need(n, "at", &need, e)) == LW_OK)
        s = lw_read_numbers(n, numbers, COUNT(numbers), e);
    p->damping = s == LW_OK ? ratio/(LW_PI*at) : 0;
    return s;
}

static lw_status read_axis(const lw_json_node *n, const lw_model *m, lw_elastic *p, lw_error *e)
{
    lw_status s = lw_read_list(n, 2, 1000, e);
    if (s != LW_OK)
        return s;
    if (!(p->axis = calloc(lw_json_count(n), sizeof *p->axis)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; s == LW_OK && i < lw_json_count(n); i++) {
        lw_json_node point = lw_json_element(n, i);
        s = lw_read_pair(&point, m->linkage.units.metre, &p->axis[p->n_axis++], e);
        if (s == LW_OK && i > 0 && lw_v2_norm(lw_v2_sub(p->axis[i], p->axis[i - 1])) <= 0)
            s = lw_json_fault(&point, e, "the axis has a part of length 0");
    }
    return s;
}

static lw_status read_segments(const lw_json_node *n, lw_elastic *p, lw_error *e)
{
    const char *text = lw_json_text(n);
    double value = 0;
    if (text && strcmp(text, "auto") == 0)
        return LW_OK;
    lw_status s = lw_json_kind_of(n) == LW_JSON_NUMBER ? lw_json_number(n, &value, e) : LW_E_NOTATION;
    if (s != LW_OK || !(value >= 1 && value <= 10000) || floor(value) != value)
        return lw_json_fault(n, e, "\"segments\" is \"auto\" or a number of elements, 1 to 10000");
    p->segments = (int)value;
    return LW_OK;
}

lw_status lw_model_read_elastic(const lw_json_node *link, const lw_json_node *n, lw_model *m, int i, lw_error *e)
{
    static const char *const known[] = { "section", "material", "segments", "frequency", "damping", "mass", "axis" };
    static const char *const masses[] = { "lumped", "consistent" };
    lw_elastic *p = &m->elastic[i];
    lw_json_node at;
    int mass = 0;
    const lw_number_key frequency = { "frequency", 1, LW_POSITIVE, &p->frequency, NULL };
    lw_status s = lw_json_expect(n, LW_JSON_OBJECT, e);
    if (s == LW_OK && i == m->linkage.ground)
        s = lw_json_fault(n, e, "the ground cannot be elastic; weld an elastic link to it");
    if (s == LW_OK && lw_json_member(link, "mass", &at))
        s = lw_json_fault(&at, e, "the mass of an elastic link is that of its section and material; leave \"mass\" out, and weld "
                          "another link with the mass that it carries");
    if (s == LW_OK && (lw_json_member(link, "velocity", &at) || lw_json_member(link, "omega", &at)))
        s = lw_json_fault(&at, e, "an elastic link starts with the velocities of the rigid linkage; give the speed of an input");
    if (s == LW_OK && (s = lw_json_known_keys(n, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_need(n, "section", &at, e)) == LW_OK &&
        (s = lw_section_read(&at, m->linkage.units.metre, &p->section, e)) == LW_OK &&
        (s = lw_read_need(n, "material", &at, e)) == LW_OK)
        s = lw_material_read(&at, &p->material, e);
    if (s == LW_OK && lw_json_member(n, "segments", &at))
        s = read_segments(&at, p, e);
    if (s == LW_OK && lw_json_member(n, "frequency", &at) && p->segments)
        s = lw_json_fault(&at, e, "\"frequency\" is for \"segments\": \"auto\"; keep one");
    if (s == LW_OK)
        s = lw_read_numbers(n, &frequency, 1, e);
    if (s == LW_OK && lw_json_member(n, "damping", &at))
        s = read_elastic_damping(&at, p, e);
    if (s == LW_OK && lw_json_member(n, "mass", &at))
        s = lw_read_look_up(&at, "mass", masses, COUNT(masses), &mass, e);
    p->consistent = mass == 1;
    if (s == LW_OK && lw_json_member(n, "axis", &at))
        s = read_axis(&at, m, p, e);
    p->given = s == LW_OK;
    m->n_elastic += p->given;
    return s;
}

lw_status lw_model_check_elastic(const lw_json_node *root, const lw_model *m, lw_error *e)
{
    lw_json_node joints, at;
    lw_status s = m->n_elastic ? lw_read_need(root, "joints", &joints, e) : LW_OK;
    for (int i = 0; s == LW_OK && m->n_elastic && i < m->linkage.n_joint; i++) {
        const lw_joint *j = &m->linkage.joint[i];
        lw_json_node n = lw_json_element(&joints, (size_t)i);
        for (int end = 0; s == LW_OK && end < 2; end++) {
            const char *link = m->linkage.link_name[j->link[end]];
            if (!m->elastic[j->link[end]].given)
                continue;
            if (lw_joint_has_ratio(j->kind))
                s = lw_json_fault(&n, e, "a gear on the elastic link \"%s\" is not supported; weld a rigid wheel to it", link);
            else if (lw_joint_slides(j->kind) && end == 0)
                s = lw_json_fault(&n, e, "the elastic link \"%s\" cannot be a guide; name the links the other way round, or weld "
                                  "a rigid guide to it", link);
            else if (!lw_json_member(&n, "at", &at))
                s = lw_json_fault(&n, e, "a joint of the elastic link \"%s\" needs its place \"at\"", link);
        }
    }
    return s;
}
