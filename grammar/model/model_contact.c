/* grammar/model/model_contact.c - shapes, contacts and ropes of a model from JSON (docs/notation.md, "Contact"). */
#include "grammar/model/model_internal.h"

#include <stdlib.h>
#include "base/real.h"
#include "base/vec2.h"
#include "grammar/linkage/read_internal.h"

/* Do the sides from corners i and k cross or touch, which are not neighbours? */
static bool sides_meet(const lw_contour *p, int i, int k)
{
    lw_vec2 a = p->at[i], b = p->at[(i + 1)%p->n], c = p->at[k], d = p->at[(k + 1)%p->n];
    if (fmax(a.x, b.x) < fmin(c.x, d.x) || fmax(c.x, d.x) < fmin(a.x, b.x) || fmax(a.y, b.y) < fmin(c.y, d.y)
        || fmax(c.y, d.y) < fmin(a.y, b.y))
        return false;
    lw_vec2 ab = lw_v2_sub(b, a), cd = lw_v2_sub(d, c);
    return lw_v2_cross(ab, lw_v2_sub(c, a))*lw_v2_cross(ab, lw_v2_sub(d, a)) <= 0
        && lw_v2_cross(cd, lw_v2_sub(a, c))*lw_v2_cross(cd, lw_v2_sub(b, c)) <= 0;
}

/* A solid has corners that differ and sides that meet at corners only. */
static lw_status check_corners(const lw_json_node *points, const lw_contour *p, lw_error *e)
{
    if (p->at[0].x == p->at[p->n - 1].x && p->at[0].y == p->at[p->n - 1].y)
        return lw_json_fault(points, e, "the last corner is the first one again; leave it out, since a polygon is closed");
    for (int i = 0; i < p->n; i++)
        for (int k = i + 2; k < p->n; k++)
            if ((k + 1)%p->n != i && sides_meet(p, i, k)) {
                lw_json_node one = lw_json_element(points, (size_t)k);
                return lw_json_fault(&one, e, "the side from corner %d meets that from corner %d: corners go round the polygon in order",
                                     k + 1, i + 1);
            }
    return LW_OK;
}

/* Corners in counter-clockwise order. */
static void turn_corners(lw_contour *p)
{
    double area = 0;
    for (int i = 0; i < p->n; i++)
        area += lw_v2_cross(p->at[i], p->at[(i + 1)%p->n]);
    for (int i = 0; area < 0 && i < p->n/2; i++) {
        lw_vec2 swap = p->at[i];
        p->at[i] = p->at[p->n - 1 - i];
        p->at[p->n - 1 - i] = swap;
    }
}

static lw_status read_shape(const lw_json_node *object, int link, lw_model *m, lw_error *e)
{
    static const char *const words[] = { "circle", "segment", "polygon", "line" };
    static const char *const known[] = { "circle", "segment", "polygon", "line", "radius" };
    double metre = m->linkage.units.metre;
    lw_contour *p = &m->shape[m->n_shape];
    lw_json_node points = { 0 }, other;
    int found = 0;
    bool radius = false;
    *p = (lw_contour){ .link = link };
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(object, known, COUNT(known), e);
    for (int i = 0; s == LW_OK && i < COUNT(words); i++)
        if (lw_json_member(object, words[i], &other)) {
            found++;
            p->kind = (lw_contour_kind)i;
            points = other;
        }
    if (s != LW_OK || found != 1)
        return s != LW_OK ? s : lw_json_fault(object, e, "a shape is one of \"circle\", \"segment\", \"polygon\" and \"line\"");
    bool circle = p->kind == LW_CONTOUR_CIRCLE, polygon = p->kind == LW_CONTOUR_POLYGON;
    if (!circle)
        s = lw_read_list(&points, polygon ? 3 : 2, polygon ? 10000 : 2, e);
    size_t n = circle ? 1 : s == LW_OK ? lw_json_count(&points) : 0;
    if (s == LW_OK && !(p->at = calloc(n, sizeof *p->at)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    m->n_shape += s == LW_OK;
    for (size_t i = 0; s == LW_OK && i < n; i++) {
        lw_json_node one = circle ? points : lw_json_element(&points, i);
        s = lw_read_pair(&one, metre, &p->at[p->n++], e);
        if (s == LW_OK && i > 0 && p->at[i].x == p->at[i - 1].x && p->at[i].y == p->at[i - 1].y)
            s = lw_json_fault(&one, e, "this point repeats the one before");
    }
    const lw_number_key thick = { "radius", metre, 0, INFINITY, &p->radius, &radius };
    if (s == LW_OK)
        s = lw_read_numbers(object, &thick, 1, e);
    if (s == LW_OK && circle && !(p->radius > 0))
        s = lw_json_fault(object, e, "a circle needs a \"radius\" greater than 0");
    if (s == LW_OK && radius && (polygon || p->kind == LW_CONTOUR_LINE))
        s = lw_json_fault(object, e, "only circles and segments have a \"radius\"");
    if (s == LW_OK && polygon && (s = check_corners(&points, p, e)) == LW_OK)
        turn_corners(p);
    return s;
}

/* The shapes of all links; first only their number. */
lw_status lw_model_read_shapes(const lw_json_node *root, lw_model *m, lw_error *e)
{
    lw_json_node links, shapes;
    size_t n = 0;
    lw_status s = LW_OK;
    if (!lw_json_member(root, "links", &links))
        return LW_OK;
    for (int pass = 0; s == LW_OK && pass < 2; pass++) {
        for (int i = 0; s == LW_OK && i < m->linkage.n_link; i++) {
            lw_json_node link = lw_json_element(&links, (size_t)i);
            if (lw_json_kind_of(&link) != LW_JSON_OBJECT || !lw_json_member(&link, "shapes", &shapes))
                continue;
            s = lw_read_list(&shapes, 0, SIZE_MAX, e);
            n += s == LW_OK ? lw_json_count(&shapes) : 0;
            for (size_t k = 0; s == LW_OK && pass && k < lw_json_count(&shapes); k++) {
                lw_json_node one = lw_json_element(&shapes, k);
                s = read_shape(&one, i, m, e);
            }
        }
        if (s == LW_OK && pass == 0 && !(m->shape = calloc(n + 1, sizeof *m->shape)))
            s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    return s;
}

static lw_status read_surface(const lw_json_node *object, bool rope, lw_surface *p, lw_error *e)
{
    lw_json_node n;
    const lw_number_key numbers[] = {
        { "restitution", 1, 0, 1, &p->restitution, NULL },
        { "stiffness", 1, LW_POSITIVE, &p->stiffness, NULL },
        { "exponent", 1, 1, 10, &p->exponent, NULL },
        { "damping", 1, 0, INFINITY, &p->damping, NULL },
        { "friction", 1, 0, INFINITY, &p->friction, NULL },
        { "friction_speed", 1, LW_POSITIVE, &p->friction_speed, NULL },
    };
    *p = (lw_surface){ .exponent = 1 };
    lw_status s = lw_read_numbers(object, numbers, rope ? 4 : COUNT(numbers), e);
    if (s != LW_OK)
        return s;
    if (p->stiffness > 0 && lw_json_member(object, "restitution", &n))
        return lw_json_fault(&n, e, "with a \"stiffness\" the loss follows from \"damping\"; leave \"restitution\" out");
    if (!(p->stiffness > 0) && (lw_json_member(object, "damping", &n) || lw_json_member(object, "exponent", &n)))
        return lw_json_fault(&n, e, "this belongs to a \"stiffness\", which is missing");
    if (!(p->stiffness > 0) && p->friction_speed > 0)
        return lw_json_fault(object, e, "rigid contact has set-valued friction; \"friction_speed\" needs a \"stiffness\"");
    return LW_OK;
}

static lw_status read_pair_of_links(const lw_json_node *object, lw_model *m, int link[2], lw_error *e)
{
    lw_json_node links;
    lw_status s = lw_read_need(object, "links", &links, e);
    if (s == LW_OK)
        s = lw_read_list(&links, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node one = lw_json_element(&links, end);
        s = lw_read_link(&one, &m->linkage, &link[end], e);
    }
    if (s == LW_OK && link[0] == link[1])
        s = lw_json_fault(&links, e, "this is link \"%s\" twice; name two links", m->linkage.link_name[link[0]]);
    return s;
}

lw_status lw_model_read_contact(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    lw_model *m = r->model;
    static const char *const known[] = { "name", "links", "friction", "friction_speed", "restitution", "stiffness",
                                         "exponent", "damping" };
    lw_contact *c = &m->contact[m->n_contact++];
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_own_name(object, "contact", index, c->name, e)) == LW_OK &&
        (s = read_pair_of_links(object, m, c->link, e)) == LW_OK)
        s = read_surface(object, false, &c->surface, e);
    for (const lw_contact *o = m->contact; s == LW_OK && o < c; o++)
        if ((o->link[0] == c->link[0] && o->link[1] == c->link[1]) || (o->link[0] == c->link[1] && o->link[1] == c->link[0]))
            s = lw_json_fault(object, e, "\"%s\" is a contact of these two links already, of all their shapes", o->name);
    for (int end = 0; s == LW_OK && end < 2; end++) {
        bool any = false;
        for (int i = 0; i < m->n_shape; i++)
            any = any || m->shape[i].link == c->link[end];
        if (!any)
            s = lw_json_fault(object, e, "link \"%s\" has no \"shapes\" that could touch", m->linkage.link_name[c->link[end]]);
    }
    return s;
}

lw_status lw_model_read_rope(const lw_json_node *object, size_t index, const lw_reading *reading, lw_error *e)
{
    lw_model *m = reading->model;
    static const char *const known[] = { "name", "links", "at", "length", "restitution", "stiffness", "exponent", "damping" };
    lw_rope *r = &m->rope[m->n_rope++];
    lw_json_node at;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_own_name(object, "rope", index, r->name, e)) == LW_OK &&
        (s = read_pair_of_links(object, m, r->link, e)) == LW_OK && (s = lw_read_need(object, "at", &at, e)) == LW_OK)
        s = lw_read_list(&at, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node point = lw_json_element(&at, end);
        s = lw_read_pair(&point, m->linkage.units.metre, &r->at[end], e);
    }
    if (s != LW_OK)
        return s;
    double apart = lw_v2_norm(lw_v2_sub(r->at[1], r->at[0]));
    const lw_number_key length = { "length", m->linkage.units.metre, LW_POSITIVE, &r->length, NULL };
    r->length = apart;
    s = lw_read_numbers(object, &length, 1, e);
    if (s == LW_OK && !(r->length > 0))
        s = lw_json_fault(object, e, "the ends of the rope are at one point: give its \"length\"");
    if (s == LW_OK && apart > r->length*(1 + 1e-9))
        s = lw_json_fault(object, e, "the ends are %.6g m apart in the posture, which is more than the length %.6g m", apart, r->length);
    return s == LW_OK ? read_surface(object, true, &r->surface, e) : s;
}
