/* grammar/linkage/points.c - converts points with their links to joints, and back. */
#include "grammar/linkage/points_internal.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "base/number.h"

lw_points *lw_points_create(int most_points, int most_links)
{
    lw_points *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    p->most_points = most_points ? most_points : LW_JOINT_MAX + LW_TRACER_MAX;
    p->most_links = most_links ? most_links : LW_LINK_MAX;
    p->ground = -1;
    p->name = calloc((size_t)p->most_links, sizeof *p->name);
    p->point = calloc((size_t)p->most_points, sizeof *p->point);
    if (p->name && p->point)
        return p;
    lw_points_free(p);
    return NULL;
}

void lw_points_free(lw_points *p)
{
    for (int i = 0; p && p->point && i < p->most_points; i++)
        free(p->point[i].link);
    if (p) {
        free(p->name);
        free(p->point);
    }
    free(p);
}

/* false: out of memory. */
static bool add_link(lw_point *q, int link)
{
    if ((q->n_link & (q->n_link - 1)) == 0) {                  /* powers of two */
        int *more = realloc(q->link, (q->n_link ? 2*(size_t)q->n_link : 1)*sizeof *more);
        if (!more)
            return false;
        q->link = more;
    }
    q->link[q->n_link++] = link;
    return true;
}

/* ---- reading ----------------------------------------------------------------------------------- */

lw_status lw_points_add(lw_points *p, const lw_cursor *where, lw_point **out)
{
    if (p->n_point == p->most_points)
        return lw_cursor_fail(where, "this is one point too many: at most %d", p->most_points);
    *out = &p->point[p->n_point++];
    (*out)->where = *where;
    (*out)->driven_link = -1;
    return LW_OK;
}

lw_status lw_points_join(lw_points *p, lw_point *q, const lw_cursor *where, size_t n)
{
    char name[LW_NAME_SIZE];
    int l = 0;
    if (n == 0 || n >= sizeof name || memchr(where->text + where->at, '\0', n))
        return lw_cursor_fail(where, "a link's name has 1 to %d bytes", LW_NAME_SIZE - 1);
    memcpy(name, where->text + where->at, n);
    name[n] = '\0';
    while (l < p->n_link && strcmp(p->name[l], name) != 0)
        l++;
    for (int i = 0; i < q->n_link; i++)
        if (q->link[i] == l)
            return lw_cursor_fail(where, "link %s is named twice at one point", name);
    if (l == p->most_links)
        return lw_cursor_fail(where, "link %s is one too many: at most %d", name, p->most_links);
    if (l == p->n_link) {
        memcpy(p->name[p->n_link++], name, n + 1);
        if (strcmp(name, "ground") == 0)
            p->ground = l;
    }
    return add_link(q, l) ? LW_OK : lw_cursor_fail(where, "out of memory");
}

lw_status lw_points_number(lw_cursor *c, const char *what, double *v)
{
    lw_cursor start = *c;
    while (lw_cursor_peek(c) > 0 && strchr("0123456789+-.eE", lw_cursor_peek(c)))
        lw_cursor_next(c);
    lw_status s = lw_number_parse(c->text + start.at, c->at - start.at, v);
    char buf[24];
    if (s == LW_OK)
        return LW_OK;
    if (c->at == start.at)
        return lw_cursor_fail(&start, "%s is wanted, not %s", what, lw_byte_name(lw_cursor_peek(c), buf));
    return lw_cursor_fail(&start, "%s: %.*s is %s", what, c->at - start.at > 40 ? 40 : (int)(c->at - start.at),
                          c->text + start.at, s == LW_E_NUMERIC ? "too large" : "no number");
}

/* ---- points to joints -------------------------------------------------------------------------- */

static lw_status add_joint(lw_linkage *linkage, const lw_point *q, int point, int copy, lw_joint_kind kind, int a,
                           int b)
{
    if (linkage->n_joint == LW_JOINT_MAX)
        return lw_cursor_fail(&q->where, "this needs more than %d joints", LW_JOINT_MAX);
    lw_joint *j = &linkage->joint[linkage->n_joint++];
    *j = (lw_joint){ .kind = kind, .link = { a, b }, .at = q->at };
    if (copy == 0)
        snprintf(j->name, sizeof j->name, "P%d", point);
    else
        snprintf(j->name, sizeof j->name, "P%d_%d", point, copy);
    if (lw_joint_slides(kind))
        j->along = lw_v2_polar(1, q->angle);
    return LW_OK;
}

/* The link to which all others of a pin are joined: the ground, else the first. */
static int centre_of(const lw_points *p, const lw_point *q, int first)
{
    for (int i = first; q->n_link - first > 2 && i < q->n_link; i++)
        if (q->link[i] == p->ground)
            return i;
    return first;
}

static lw_status add_tracer(lw_linkage *linkage, const lw_point *q, int point)
{
    if (linkage->n_tracer == LW_TRACER_MAX)
        return lw_cursor_fail(&q->where, "this is one tracer (a point of one link) too many: at most %d",
                              LW_TRACER_MAX);
    lw_tracer *t = &linkage->tracer[linkage->n_tracer++];
    *t = (lw_tracer){ .link = q->link[0], .at = q->at };
    snprintf(t->name, sizeof t->name, "P%d", point);
    return LW_OK;
}

static lw_status add_point(const lw_points *p, int point, lw_linkage *linkage)
{
    const lw_point *q = &p->point[point];
    lw_status s = LW_OK;
    int first = q->type != LW_POINT_PIN, copy = 0;
    if (q->n_link == 0)
        return lw_cursor_fail(&q->where, "this point is on no link; name one, or leave the point out");
    if (first && q->n_link < 2)
        return lw_cursor_fail(&q->where, "a slider or a pin in a slot joins two links at least");
    if (q->n_link == 1)
        return add_tracer(linkage, q, point);
    if (first)
        s = add_joint(linkage, q, point, copy++, q->type == LW_POINT_SLIDER ? LW_JOINT_SLIDER : LW_JOINT_SLOT,
                      q->link[0], q->link[1]);
    int centre = q->type == LW_POINT_PIN ? centre_of(p, q, 0) : 1;
    for (int i = first; s == LW_OK && i < q->n_link; i++)
        if (i != centre)
            s = add_joint(linkage, q, point, copy++, q->type == LW_POINT_SLIDER ? LW_JOINT_FIXED : LW_JOINT_REVOLUTE,
                          q->link[centre], q->link[i]);
    return s;
}

/* The joint that the input of point q drives; the joints of q begin at `first`. */
static int driven_joint(const lw_linkage *linkage, const lw_point *q, int first)
{
    for (int j = first; q->driven_link >= 0 && j < linkage->n_joint; j++)
        if (linkage->joint[j].link[0] == q->driven_link || linkage->joint[j].link[1] == q->driven_link)
            return j;
    return first;
}

static lw_status add_input(lw_linkage *linkage, const lw_point *q, int first)
{
    if (q->type == LW_POINT_SLOT || q->n_link < 2)
        return lw_cursor_fail(&q->where, "only a pin of two links or a slider can be an input");
    if (linkage->n_input == LW_INPUT_MAX)
        return lw_cursor_fail(&q->where, "this is one input too many: at most %d", LW_INPUT_MAX);
    linkage->input[linkage->n_input++] = (lw_input){ .joint = driven_joint(linkage, q, first) };
    return LW_OK;
}

lw_status lw_points_linkage(const lw_points *p, const lw_units *units, const lw_cursor *end, lw_linkage *linkage)
{
    lw_error inner;
    memset(linkage, 0, sizeof *linkage);
    linkage->units = *units;
    linkage->n_link = p->n_link;
    memcpy(linkage->link_name, p->name, (size_t)p->n_link*sizeof *p->name);
    linkage->ground = p->ground;
    if (p->n_point == 0)
        return lw_cursor_fail(end, "there is no joint");
    for (int i = 0; i < p->n_point; i++) {
        int first = linkage->n_joint;
        lw_status s = add_point(p, i, linkage);
        if (s == LW_OK && p->point[i].driven)
            s = add_input(linkage, &p->point[i], first);
        if (s != LW_OK)
            return s;
    }
    if (p->ground < 0)
        return lw_cursor_fail(end, "no link is called ground; the fixed link must be");
    if (lw_linkage_check(linkage, &inner) != LW_OK)
        return lw_cursor_fail(&p->point[0].where, "%s", inner.text);
    for (int i = 0; i < linkage->n_input; i++)
        linkage->input[i].value = lw_linkage_posture_input(linkage, linkage->input[i].joint);
    return LW_OK;
}

/* ---- joints to points -------------------------------------------------------------------------- */

typedef struct grouping {
    const lw_assembly *k;
    bool *used;
    bool  whole;                       /* false: out of memory */
    int   lost;                        /* a driven joint between moving links among several; -1 */
} grouping;

static bool has_link(const lw_point *q, int first, int link)
{
    for (int i = first; i < q->n_link; i++)
        if (q->link[i] == link)
            return true;
    return false;
}

static bool same_place(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }

static bool is_driven(const grouping *g, int joint)
{
    for (int i = 0; i < g->k->n_input; i++)
        if (g->k->input[i].joint == joint)
            return true;
    return false;
}

static void note_input(const grouping *g, int joint, lw_point *q)
{
    const lw_joint *j = &g->k->joint[joint];
    if (!is_driven(g, joint))
        return;
    q->driven = true;
    q->driven_link = j->link[j->link[0] == g->k->ground || j->link[1] != g->k->ground];
}

/* If several links are on a driven pin, the text names the one that turns, relative to the ground if that is there. */
static void check_input(grouping *g, const lw_point *q)
{
    for (int i = 0; q->n_link > 2 && i < g->k->n_input; i++) {
        const lw_joint *j = &g->k->joint[g->k->input[i].joint];
        if (q->type == LW_POINT_PIN && same_place(j->at, q->at) && j->link[0] != g->k->ground
            && j->link[1] != g->k->ground && has_link(q, 0, j->link[0]) && has_link(q, 0, j->link[1]))
            g->lost = g->k->input[i].joint;
    }
}

/* Joints of this kind at the place of q that share a link with q (from `first` on) add their other link to q.  A
 * driven pin is not merged with a slot, which cannot be driven, nor with another driven pin. */
static void gather(grouping *g, lw_joint_kind kind, int first, lw_point *q)
{
    const lw_assembly *k = g->k;
    for (bool grew = true; grew;) {
        grew = false;
        for (int j = 0; j < k->n_joint; j++) {
            const lw_joint *o = &k->joint[j];
            if (g->used[j] || o->kind != kind || !same_place(o->at, q->at)
                || ((q->type == LW_POINT_SLOT || q->driven) && is_driven(g, j)))
                continue;
            bool a = has_link(q, first, o->link[0]), b = has_link(q, first, o->link[1]);
            if (a == b || has_link(q, 0, o->link[a ? 1 : 0]))
                continue;
            g->whole = add_link(q, o->link[a ? 1 : 0]) && g->whole;
            g->used[j] = grew = true;
            note_input(g, j, q);
        }
    }
}

/* The slot whose pin joint j is, or -1. */
static int slot_at(const grouping *g, const lw_joint *j)
{
    for (int i = 0; i < g->k->n_joint; i++) {
        const lw_joint *o = &g->k->joint[i];
        if (!g->used[i] && o->kind == LW_JOINT_SLOT && same_place(o->at, j->at)
            && (o->link[1] == j->link[0] || o->link[1] == j->link[1]) && o->link[0] != j->link[0]
            && o->link[0] != j->link[1])
            return i;
    }
    return -1;
}

/* The direction in degrees, rounded to the number that the user is likely to have written [deg]. */
static double angle_of(lw_vec2 along)
{
    double angle = atan2(along.y, along.x)*180/LW_PI, plain = round(angle*1e9)/1e9;
    return fabs(angle - plain) < 1e-13*(1 + fabs(angle)) ? plain : angle;
}

static lw_point_type type_of(lw_joint_kind kind)
{
    switch (kind) {
    case LW_JOINT_SLIDER: return LW_POINT_SLIDER;
    case LW_JOINT_SLOT:   return LW_POINT_SLOT;
    case LW_JOINT_REVOLUTE: case LW_JOINT_GEAR: case LW_JOINT_FIXED: case LW_JOINT_FREE: break;
    }
    return LW_POINT_PIN;
}

static void group_joint(grouping *g, int joint, lw_points *p)
{
    const lw_joint *j = &g->k->joint[joint];
    if (j->kind == LW_JOINT_REVOLUTE && !is_driven(g, joint) && slot_at(g, j) >= 0) {
        joint = slot_at(g, j);
        j = &g->k->joint[joint];
    }
    lw_point *q = &p->point[p->n_point++];
    *q = (lw_point){ .at = j->at, .angle = angle_of(j->along)*(LW_PI/180), .driven_link = -1 };
    g->used[joint] = true;
    g->whole = add_link(q, j->link[0]) && add_link(q, j->link[1]) && g->whole;
    if (!g->whole)
        return;
    note_input(g, joint, q);
    q->type = type_of(j->kind);
    gather(g, q->type == LW_POINT_SLIDER ? LW_JOINT_FIXED : LW_JOINT_REVOLUTE, q->type != LW_POINT_PIN, q);
    check_input(g, q);
    for (int i = 1; q->type == LW_POINT_PIN && q->n_link > 2 && i < q->n_link; i++)
        if (q->link[i] == g->k->ground) {                  /* first, as after reading */
            q->link[i] = q->link[0];
            q->link[0] = g->k->ground;
        }
}

/* True for a reserved name: a kind, the ground and, if nothing is driven, the name of PMKS' driven link. */
static bool is_word(const lw_assembly *linkage, const char *name)
{
    static const char *const words[] = { "r", "p", "rp", "g", "ground", "gnd", "grnd" };
    for (size_t i = 0; i < sizeof words/sizeof *words; i++)
        if (strcasecmp(name, words[i]) == 0)
            return true;
    return linkage->n_input == 0 && strcasecmp(name, "input") == 0;
}

static bool taken(const lw_points *p, int n, const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcasecmp(p->name[i], name) == 0)
            return true;
    return false;
}

static void name_links(const lw_assembly *linkage, lw_points *p)
{
    for (int l = 0; l < linkage->n_link; l++) {
        char *name = p->name[l], plain[LW_NAME_SIZE - 4];
        int n = 0;
        if (l == linkage->ground) {
            strcpy(name, "ground");
            continue;
        }
        if (isdigit((unsigned char)linkage->link_name[l][0]))
            plain[n++] = '_';
        for (const char *c = linkage->link_name[l]; *c && n < (int)sizeof plain - 1; c++)
            plain[n++] = isascii((unsigned char)*c) && isalnum((unsigned char)*c) ? *c : '_';
        plain[n] = '\0';
        snprintf(name, LW_NAME_SIZE, "%s", plain);
        for (int i = 2; is_word(linkage, name) || taken(p, l, name); i++)
            snprintf(name, LW_NAME_SIZE, "%.20s_%d", plain, i);
    }
}

static lw_status points_from(const lw_assembly *linkage, bool *used, lw_points *p, lw_error *e)
{
    grouping g = { .k = linkage, .used = used, .whole = true, .lost = -1 };
    lw_status s = lw_assembly_check(linkage, e);
    if (s != LW_OK)
        return s;
    p->n_link = linkage->n_link;
    p->ground = linkage->ground;
    name_links(linkage, p);
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_has_ratio(linkage->joint[j].kind))
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear, which has no form in this notation",
                                linkage->joint[j].name);
    int own = lw_assembly_free_inputs(linkage);
    if (own < linkage->n_input)
        return lw_error_set(e, LW_E_KIND,
                            "the input at joint \"%s\" is tied to the first, which has no form in this notation",
                            linkage->joint[linkage->input[own].joint].name);
    for (int j = 0; j < linkage->n_joint; j++)
        while (g.whole && !g.used[j] && linkage->joint[j].kind != LW_JOINT_FIXED)
            group_joint(&g, j, p);
    for (int j = 0; g.whole && j < linkage->n_joint; j++)
        if (!g.used[j])
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a weld that is not at a slider, which has no form "
                                "in this notation; make its two links one", linkage->joint[j].name);
    if (g.lost >= 0)
        return lw_error_set(e, LW_E_KIND, "input \"%s\" turns two moving links on a pin of several, which has no "
                            "form in this notation", linkage->joint[g.lost].name);
    for (int i = 0; i < linkage->n_tracer; i++) {
        lw_point *q = &p->point[p->n_point++];
        *q = (lw_point){ .at = linkage->tracer[i].at, .driven_link = -1 };
        g.whole = add_link(q, linkage->tracer[i].link) && g.whole;
    }
    return g.whole ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
}

/* ---- as text ------------------------------------------------------------------------------------- */

const char *const lw_point_type_text[3] = { "R", "P", "RP" };

lw_point_numbers lw_point_print(const lw_point *q, double metre)
{
    lw_point_numbers n;
    lw_number_print_in(q->at.x, metre, n.x);
    lw_number_print_in(q->at.y, metre, n.y);
    lw_number_print_in(q->angle, LW_PI/180, n.angle);
    return n;
}

char *lw_points_text(const lw_assembly *linkage, void (*print)(FILE *f, const lw_points *p, double metre), lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_points *p = lw_points_create(linkage->n_joint + linkage->n_tracer + 1, linkage->n_link + 1);
    bool *used = calloc((size_t)linkage->n_joint + 1, sizeof *used);
    lw_status s = p && used ? points_from(linkage, used, p, e) : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    FILE *f = s == LW_OK ? open_memstream(&text, &size) : NULL;
    if (f) {
        print(f, p, linkage->units.metre);
        if (fclose(f) != 0) {
            free(text);
            text = NULL;
        }
    }
    lw_points_free(p);
    free(used);
    if (!text && s == LW_OK)
        lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    return text;
}
