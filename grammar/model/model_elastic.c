/* grammar/model/model_elastic.c - "elastic" of a link (docs/notation.md, "Elastic links"). */
#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "base/real.h"
#include "grammar/linkage/read_internal.h"
#include "grammar/model/matrix_market.h"
#include "grammar/model/model_internal.h"

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

static lw_status read_axis(const lw_json_node *n, double metre, bool space, lw_elastic *p, lw_error *e)
{
    lw_status s = lw_read_list(n, 2, 1000, e);
    if (s != LW_OK)
        return s;
    if (!(p->axis = calloc(lw_json_count(n), sizeof *p->axis)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; s == LW_OK && i < lw_json_count(n); i++) {
        lw_json_node point = lw_json_element(n, i);
        s = lw_read_place(&point, metre, space, &p->axis[i], e);
        p->n_axis++;
        double length = i > 0 ? lw_v3_norm(lw_v3_sub(p->axis[i], p->axis[i - 1])) : 1;
        if (s == LW_OK && !(length > LW_ELASTIC_SHORTEST))
            s = lw_json_fault(&point, e, "a part of the axis has length %g m, which is no bar (shorter than %g m)", length, LW_ELASTIC_SHORTEST);
    }
    return s;
}

/* Where the section is not the same in all directions, its height has to have one. */
static lw_status read_height(const lw_json_node *elastic, const lw_json_node *section, lw_elastic *p, lw_error *e)
{
    const lw_section *q = &p->section;
    lw_json_node n;
    if (!q->whole)
        return lw_json_fault(section, e, "in space a section needs \"Iy\" and \"It\", too");
    if (lw_json_member(elastic, "height", &n))
        return lw_read_direction(&n, &p->height, e);
    if (fabs(q->iy - q->iz) <= 1e-9*q->iz && fabs(q->zeta_y - q->zeta_z) <= 1e-9*q->zeta_y
        && fabs(lw_section_mass_y(q) - lw_section_mass_z(q)) <= 1e-9*lw_section_mass_z(q))
        return LW_OK;
    return lw_json_fault(section, e, "this section is stiffer or heavier in one direction than in the other: add \"height\": [x, y, z], the "
                         "direction in which its height lies");
}

static lw_status read_segments(const lw_json_node *n, lw_elastic *p, lw_error *e)
{
    const char *text = lw_json_text(n);
    double value = 0;
    if (text && strcmp(text, "auto") == 0)
        return LW_OK;
    lw_status s = lw_json_kind_of(n) == LW_JSON_NUMBER ? lw_json_number(n, &value, e) : LW_E_NOTATION;
    if (s != LW_OK || !(value >= 1 && value <= LW_ELASTIC_SEGMENTS) || floor(value) != value)
        return lw_json_fault(n, e, "\"segments\" is \"auto\" or a number of elements, 1 to %d", LW_ELASTIC_SEGMENTS);
    p->segments = (int)value;
    return LW_OK;
}

/* ---- superelements ------------------------------------------------------------------------------------------ */

/* The matrix of the file that a member names, beside the file of the model; symmetric, of 6 rows a node. */
static lw_status read_matrix(const lw_json_node *object, const char *key, int nodes, double **out, lw_error *e)
{
    lw_json_node at;
    char path[LW_PATH_SIZE], *text = NULL;
    size_t size;
    int n = 0;
    double most = 0, skew = 0;
    lw_status s = lw_read_beside(object, key, ".mtx", "a file of the Matrix Market", path, &text, &size, &at, e);
    if (s == LW_OK)
        s = lw_matrix_market_read(text, size, path, &n, out, e);
    free(text);
    for (int i = 0; s == LW_OK && i < n*n; i++) {
        most = fmax(most, fabs((*out)[i]));
        skew = fmax(skew, fabs((*out)[i] - (*out)[i%n*n + i/n]));
    }
    if (s == LW_OK && n != 6*nodes)
        s = lw_json_fault(&at, e, "the matrix has %d rows; with %d nodes it needs %d, the displacements and turns x y z of each node", n,
                          nodes, 6*nodes);
    if (s == LW_OK && (!(most > 0) || skew > 1e-8*most))
        s = lw_json_fault(&at, e, !(most > 0) ? "the matrix is 0" : "the matrix is not symmetric");
    return s;
}

/* Does the stiffness let the body move as a rigid one?  Each of these motions is to cause no forces. */
static lw_status check_rigid(const lw_json_node *n, const lw_elastic *p, lw_error *e)
{
    static const char *const motion[] = { "along x", "along y", "along z", "about x", "about y", "about z" };
    int rows = 6*p->n_node;
    double most = 0, size = 0;
    for (int i = 0; i < rows*rows; i++)
        most = fmax(most, fabs(p->stiffness[i]));
    for (int i = 1; i < p->n_node; i++)
        size = fmax(size, lw_v3_norm(lw_v3_sub(p->node[i], p->node[0])));
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < rows; i++) {
            double force = 0;
            for (int j = 0; j < p->n_node; j++) {
                lw_vec3 axis = lw_v3(k%3 == 0, k%3 == 1, k%3 == 2);
                lw_vec3 move = k < 3 ? axis : lw_v3_cross(axis, lw_v3_sub(p->node[j], p->node[0]));
                const double x[6] = { move.x, move.y, move.z, k > 2 ? axis.x : 0, k > 2 ? axis.y : 0, k > 2 ? axis.z : 0 };
                for (int c = 0; c < 6; c++)
                    force += p->stiffness[i*rows + 6*j + c]*x[c];
            }
            if (fabs(force) > 1e-6*most*fmax(1, size))
                return lw_json_fault(n, e, "the stiffness resists a motion of the whole body %s: %.3g N or N m against %.3g of the greatest "
                                     "entry; is it fixed somewhere, are the nodes elsewhere, or is it in other units than N/m, N and N m (N/mm, N mm)?",
                                     motion[k], fabs(force), most);
        }
    return LW_OK;
}

/* Cholesky's method on a + by b, both (n x n): the first row without a pivot above this part of its diagonal; n: it is positive definite. */
static const double least_pivot = 1e-13;

static lw_status find_indefinite(int n, const double *a, double by, const double *b, int *row)
{
    double *l = malloc((size_t)n*(size_t)n*sizeof *l);
    if (!l)
        return LW_E_MEMORY;
    for (*row = 0; *row < n; ++*row) {
        double *own = l + *row*n, diagonal = a[*row*(n + 1)] + by*b[*row*(n + 1)], left = diagonal;
        for (int j = 0; j < *row; j++) {
            double sum = a[*row*n + j] + by*b[*row*n + j];
            for (int k = 0; k < j; k++)
                sum -= own[k]*l[j*n + k];
            own[j] = sum/l[j*(n + 1)];
            left -= own[j]*own[j];
        }
        if (!(left > least_pivot*diagonal))
            break;
        own[*row] = sqrt(left);
    }
    free(l);
    return LW_OK;
}

/* The mass of the whole body is the same in all directions; no motion has a negative energy. */
static lw_status check_definite(const lw_json_node *n, const lw_elastic *p, lw_error *e)
{
    int rows = 6*p->n_node, row;
    double total[9] = { 0 }, most = 0;
    for (int i = 0; i < rows*rows; i++)
        if (i/rows%6 < 3 && i%rows%6 < 3)
            total[i/rows%6*3 + i%rows%6] += p->mass[i];
    double mean = (total[0] + total[4] + total[8])/3;
    for (int i = 0; i < 9; i++)
        if (!(fabs(total[i] - (i%4 ? 0 : mean)) <= 1e-6*mean))
            return lw_json_fault(n, e, "the mass of the whole body differs from one direction to the other: %.6g, %.6g, %.6g kg along x, y, z; are the "
                                 "rows in the order of the nodes, x y z and turns of each?", total[0], total[4], total[8]);
    lw_status s = find_indefinite(rows, p->mass, 0, p->mass, &row);
    if (s == LW_OK && row < rows)
        return lw_json_fault(n, e, "the mass matrix is not positive definite: a motion of its first %d rows has no mass", row + 1);
    for (int i = 0; i < rows; i++)
        most = fmax(most, p->stiffness[i*(rows + 1)]/p->mass[i*(rows + 1)]);
    if (s == LW_OK)                          /* rigid motions have no stiffness, so a little mass is added */
        s = find_indefinite(rows, p->stiffness, 1e-9*most, p->mass, &row);
    if (s == LW_OK && (row < rows || !(most > 0)))
        return lw_json_fault(n, e, "the stiffness has a displacement with negative energy, of its first %d rows", row + 1);
    return s == LW_OK ? s : lw_error_set(e, s, "out of memory");
}

/* "modes": they are the coordinates of whole nodes. */
static lw_status read_modes(const lw_json_node *n, lw_elastic *p, lw_error *e)
{
    double modes = 0;
    const lw_number_key key = { "modes", 1, 0, 60, &modes, NULL };
    lw_status s = lw_read_numbers(n, &key, 1, e);
    p->modes = (int)modes;
    return s == LW_OK && (p->modes%6 || modes != p->modes) ? lw_json_fault(n, e, "\"modes\" is a multiple of 6, at most 60") : s;
}

/* {"nodes": [[x, y, z], ...], "stiffness": "K.mtx", "mass": "M.mtx"} and "damping"; in the plane [x, y] */
static lw_status read_superelement(const lw_json_node *n, double metre, bool space, lw_elastic *p, lw_error *e)
{
    static const char *const known[] = { "nodes", "stiffness", "mass", "damping", "modes" };
    lw_json_node nodes, at;
    lw_status s = lw_json_known_keys(n, known, COUNT(known), e);
    if (s == LW_OK && (s = lw_read_need(n, "nodes", &nodes, e)) == LW_OK)
        s = lw_read_list(&nodes, 2, LW_MATRIX_MOST/6, e);
    if (s != LW_OK)
        return s;
    p->node = calloc(lw_json_count(&nodes), sizeof *p->node);
    if (!p->node)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&nodes); i++) {
        lw_json_node one = lw_json_element(&nodes, i);
        s = lw_read_place(&one, metre, space, &p->node[i], e);
        for (size_t k = 0; s == LW_OK && k < i; k++)
            if (lw_v3_norm(lw_v3_sub(p->node[i], p->node[k])) == 0)
                s = lw_json_fault(&one, e, "two nodes are at one place");
    }
    p->n_node = (int)lw_json_count(&nodes);
    if (s == LW_OK && (s = read_matrix(n, "stiffness", p->n_node, &p->stiffness, e)) == LW_OK &&
        (s = read_matrix(n, "mass", p->n_node, &p->mass, e)) == LW_OK)
        s = check_rigid(n, p, e);
    for (int i = 0; s == LW_OK && i < 6*p->n_node; i++)
        if (!(p->mass[i*6*p->n_node + i] > 0))
            s = lw_json_fault(n, e, "the mass matrix has %.3g on its diagonal at row %d; it is to be above 0", p->mass[i*6*p->n_node + i], i + 1);
    if (s == LW_OK)
        s = check_definite(n, p, e);
    if (s == LW_OK && lw_json_member(n, "damping", &at))
        s = read_elastic_damping(&at, p, e);
    if (s == LW_OK)
        s = read_modes(n, p, e);
    p->given = s == LW_OK;
    return s;
}

void lw_superelement_free(lw_superelement *p)
{
    free(p->link), free(p->at), free(p->stiffness), free(p->rate), free(p->turn), free(p->first), free(p->lump), free(p->turning);
}

void lw_elastic_free(lw_elastic *p)
{
    free(p->axis), free(p->node), free(p->stiffness), free(p->mass);
}

lw_status lw_elastic_read(const lw_json_node *n, double metre, bool space, lw_elastic *p, lw_error *e)
{
    static const char *const known[] = { "section", "material", "segments", "frequency", "damping", "mass", "axis", "superelements", "modes",
                                         "height" };
    static const char *const masses[] = { "lumped", "consistent" };
    lw_json_node section, at;
    int mass = 0;
    const lw_number_key frequency = { "frequency", 1, LW_POSITIVE, &p->frequency, NULL };
    double pieces = 0;
    const lw_number_key condensed = { "superelements", 1, 1, 100, &pieces, NULL };
    lw_status s = lw_json_expect(n, LW_JSON_OBJECT, e);
    p->plane = !space;
    if (s == LW_OK && !space && lw_json_member(n, "height", &at))
        s = lw_json_fault(&at, e, "\"height\" is for models in space: give every place three numbers, joints with \"axis\": [0, 0, 1]");
    if (s == LW_OK && (lw_json_member(n, "stiffness", &at) || lw_json_member(n, "nodes", &at)))
        return read_superelement(n, metre, space, p, e);
    if (s == LW_OK && (s = lw_json_known_keys(n, known, COUNT(known) - !space, e)) == LW_OK &&
        (s = lw_read_need(n, "section", &section, e)) == LW_OK &&
        (s = lw_section_read(&section, metre, &p->section, e)) == LW_OK &&
        (s = lw_read_need(n, "material", &at, e)) == LW_OK)
        s = lw_material_read(&at, &p->material, e);
    if (s == LW_OK && space)
        s = read_height(n, &section, p, e);
    if (s == LW_OK && lw_json_member(n, "segments", &at))
        s = read_segments(&at, p, e);
    if (s == LW_OK && lw_json_member(n, "frequency", &at) && p->segments)
        s = lw_json_fault(&at, e, "\"frequency\" is for \"segments\": \"auto\"; keep one");
    if (s == LW_OK)
        s = lw_read_numbers(n, &frequency, 1, e);
    if (s == LW_OK)
        s = lw_read_numbers(n, &condensed, 1, e);
    p->pieces = (int)pieces;
    if (s == LW_OK && pieces != p->pieces)
        s = lw_json_fault(n, e, "\"superelements\" is a whole number");
    if (s == LW_OK)
        s = read_modes(n, p, e);
    if (s == LW_OK && p->modes && !p->pieces)
        s = lw_json_fault(n, e, "\"modes\" are those of \"superelements\"; give their number, too");
    if (s == LW_OK && lw_json_member(n, "damping", &at))
        s = read_elastic_damping(&at, p, e);
    if (s == LW_OK && lw_json_member(n, "mass", &at))
        s = lw_read_look_up(&at, "mass", masses, COUNT(masses), &mass, e);
    p->consistent = mass == 1;
    if (s == LW_OK && lw_json_member(n, "axis", &at))
        s = read_axis(&at, metre, space, p, e);
    p->given = s == LW_OK;
    return s;
}

lw_status lw_elastic_check_link(const lw_json_node *link, const lw_json_node *n, bool ground, lw_error *e)
{
    static const char *const start[] = { "velocity", "omega", "angular_velocity" }, *const mass[] = { "mass", "centre", "inertia" };
    lw_json_node at;
    if (ground)
        return lw_json_fault(n, e, "the ground cannot be elastic; weld an elastic link to it");
    for (int i = 0; i < COUNT(mass); i++)
        if (lw_json_member(link, mass[i], &at))
            return lw_json_fault(&at, e, "the mass of an elastic link is that of its section and material; leave \"%s\" out, and "
                                 "weld another link with the mass that it carries", mass[i]);
    for (int i = 0; i < COUNT(start); i++)
        if (lw_json_member(link, start[i], &at))
            return lw_json_fault(&at, e, "an elastic link starts with the velocities of the rigid linkage; give the speed of an input");
    return LW_OK;
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
