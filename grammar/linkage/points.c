/* grammar/linkage/points.c - converts points with their links to joints, and back. */
#include "grammar/linkage/points_internal.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "base/growable_array.h"
#include "base/number.h"

lw_points *lw_points_create(void)
{
    lw_points *p = calloc(1, sizeof *p);
    if (p)
        p->ground = -1;
    return p;
}

void lw_points_free(lw_points *p)
{
    if (!p)
        return;
    for (int i = 0; i < p->n_point; i++)
        free(p->point[i].link);
    free(p->name);
    free(p->point);
    lw_key_table_free(&p->index);
    free(p);
}

static lw_point *new_point(lw_points *p)
{
    lw_point *more = lw_array_grow(p->point, p->n_point, &p->most_points, sizeof *more);
    if (!more)
        return NULL;
    p->point = more;
    more[p->n_point] = (lw_point){ .driven_link = -1 };
    return &more[p->n_point++];
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
    *out = new_point(p);
    if (!*out)
        return lw_error_set(where->e, LW_E_MEMORY, "out of memory");
    (*out)->where = *where;
    return LW_OK;
}

lw_status lw_points_join(lw_points *p, lw_point *q, const lw_cursor *where, size_t n)
{
    char name[LW_NAME_SIZE] = "";
    if (n == 0 || n >= sizeof name || memchr(where->text + where->at, '\0', n))
        return lw_cursor_fail(where, "a link's name has 1 to %d bytes", LW_NAME_SIZE - 1);
    memcpy(name, where->text + where->at, n);
    name[n] = '\0';
    int l = lw_key_table_find(&p->index, p->name, sizeof *p->name, name, n + 1);
    for (int i = 0; l >= 0 && i < q->n_link; i++)
        if (q->link[i] == l)
            return lw_cursor_fail(where, "link %s is named twice at one point", name);
    if (l < 0) {
        l = p->n_link;
        char (*more)[LW_NAME_SIZE] = lw_array_grow(p->name, l, &p->most_links, sizeof *more);
        p->name = more ? more : p->name;
        if (!more || !lw_key_table_add(&p->index, name, n + 1, l))
            return lw_error_set(where->e, LW_E_MEMORY, "out of memory");
        memcpy(p->name[p->n_link++], name, sizeof name);
        if (strcmp(name, "ground") == 0)
            p->ground = l;
    }
    return add_link(q, l) ? LW_OK : lw_error_set(where->e, LW_E_MEMORY, "out of memory");
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

static void add_joint(lw_assembly *linkage, const lw_point *q, int point, int copy, lw_joint_kind kind, int a, int b)
{
    lw_joint *j = &linkage->joint[linkage->n_joint++];
    *j = (lw_joint){ .kind = kind, .link = { a, b }, .at = q->at };
    if (copy == 0)
        snprintf(j->name, sizeof j->name, "P%d", point);
    else
        snprintf(j->name, sizeof j->name, "P%d_%d", point, copy);
    if (lw_joint_slides(kind))
        j->along = lw_v2_polar(1, q->angle);
}

/* The link to which all others of a pin are joined: the ground, else the first. */
static int centre_of(const lw_points *p, const lw_point *q, int first)
{
    for (int i = first; q->n_link - first > 2 && i < q->n_link; i++)
        if (q->link[i] == p->ground)
            return i;
    return first;
}

static lw_status add_point(const lw_points *p, int point, lw_assembly *linkage)
{
    const lw_point *q = &p->point[point];
    int first = q->type != LW_POINT_PIN, copy = 0;
    if (q->n_link == 0)
        return lw_cursor_fail(&q->where, "this point is on no link; name one, or leave the point out");
    if (first && q->n_link < 2)
        return lw_cursor_fail(&q->where, "a slider or a pin in a slot joins two links at least");
    if (q->n_link == 1) {
        lw_tracer *t = &linkage->tracer[linkage->n_tracer++];
        *t = (lw_tracer){ .link = q->link[0], .at = q->at };
        snprintf(t->name, sizeof t->name, "P%d", point);
        return LW_OK;
    }
    if (first)
        add_joint(linkage, q, point, copy++, q->type == LW_POINT_SLIDER ? LW_JOINT_SLIDER : LW_JOINT_SLOT, q->link[0], q->link[1]);
    int centre = q->type == LW_POINT_PIN ? centre_of(p, q, 0) : 1;
    for (int i = first; i < q->n_link; i++)
        if (i != centre)
            add_joint(linkage, q, point, copy++, q->type == LW_POINT_SLIDER ? LW_JOINT_FIXED : LW_JOINT_REVOLUTE,
                      q->link[centre], q->link[i]);
    return LW_OK;
}

/* The joint that the input of point q drives; the joints of q begin at `first`. */
static int driven_joint(const lw_assembly *linkage, const lw_point *q, int first)
{
    for (int j = first; q->driven_link >= 0 && j < linkage->n_joint; j++)
        if (linkage->joint[j].link[0] == q->driven_link || linkage->joint[j].link[1] == q->driven_link)
            return j;
    return first;
}

static lw_status add_input(lw_assembly *linkage, const lw_point *q, int first)
{
    if (q->type == LW_POINT_SLOT || q->n_link < 2)
        return lw_cursor_fail(&q->where, "only a pin of two links or a slider can be an input");
    linkage->input[linkage->n_input++] = (lw_input){ .joint = driven_joint(linkage, q, first) };
    return LW_OK;
}

static lw_status fill(const lw_points *p, const lw_cursor *end, lw_assembly *linkage)
{
    lw_error inner;
    linkage->ground = p->ground;
    if (p->n_link > 0)
        memcpy(linkage->link_name, p->name, (size_t)p->n_link*sizeof *p->name);
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
    if (lw_assembly_check(linkage, &inner) != LW_OK)
        return lw_cursor_fail(&p->point[0].where, "%s", inner.text);
    return lw_assembly_set_inputs(linkage, NULL);
}

lw_status lw_points_linkage(const lw_points *p, const lw_units *units, const lw_cursor *end, lw_assembly *linkage)
{
    size_t joints = 1, points = (size_t)p->n_point;
    *linkage = (lw_assembly){ .units = *units, .n_link = p->n_link };
    if (p->n_point == 0)
        return lw_cursor_fail(end, "there is no joint");
    for (size_t i = 0; i < points; i++)
        joints += (size_t)p->point[i].n_link;
    linkage->link_name = calloc((size_t)p->n_link + 1, sizeof *linkage->link_name);
    linkage->joint = malloc(joints*sizeof *linkage->joint);
    linkage->input = malloc(points*sizeof *linkage->input);
    linkage->tracer = malloc(points*sizeof *linkage->tracer);
    bool whole = linkage->link_name && linkage->joint && linkage->input && linkage->tracer;
    lw_status s = whole ? fill(p, end, linkage) : lw_error_set(end->e, LW_E_MEMORY, "out of memory");
    if (s != LW_OK)
        lw_assembly_free(linkage);
    return s;
}

/* ---- joints to points -------------------------------------------------------------------------- */

typedef struct grouping {
    const lw_assembly *k;
    bool *used, *driven;               /* (n_joint) */
    int  *first, *next;                /* (n_joint) the first joint at the place of a joint, and the next one; -1: none */
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

static void note_input(const grouping *g, int joint, lw_point *q)
{
    const lw_joint *j = &g->k->joint[joint];
    if (!g->driven[joint])
        return;
    q->driven = true;
    q->driven_link = j->link[j->link[0] == g->k->ground || j->link[1] != g->k->ground];
}

/* If several links are on a driven pin, the text names the one that turns, relative to the ground if that is there. */
static void check_input(grouping *g, int first, const lw_point *q)
{
    for (int i = first; q->type == LW_POINT_PIN && q->n_link > 2 && i >= 0; i = g->next[i]) {
        const lw_joint *j = &g->k->joint[i];
        if (g->driven[i] && j->link[0] != g->k->ground && j->link[1] != g->k->ground && has_link(q, 0, j->link[0])
            && has_link(q, 0, j->link[1]))
            g->lost = i;
    }
}

/* Joints of this kind at the place of q that share a link with q (from `first` on) add their other link to q.  A
 * driven pin is not merged with a slot, which cannot be driven, nor with another driven pin. */
static void gather(grouping *g, int begin, lw_joint_kind kind, int first, lw_point *q)
{
    const lw_assembly *k = g->k;
    for (bool grew = true; grew;) {
        grew = false;
        for (int j = begin; j >= 0; j = g->next[j]) {
            const lw_joint *o = &k->joint[j];
            if (g->used[j] || o->kind != kind || ((q->type == LW_POINT_SLOT || q->driven) && g->driven[j]))
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
static int slot_at(const grouping *g, int joint)
{
    const lw_joint *j = &g->k->joint[joint];
    for (int i = g->first[joint]; i >= 0; i = g->next[i]) {
        const lw_joint *o = &g->k->joint[i];
        if (!g->used[i] && o->kind == LW_JOINT_SLOT && (o->link[1] == j->link[0] || o->link[1] == j->link[1])
            && o->link[0] != j->link[0] && o->link[0] != j->link[1])
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
    if (j->kind == LW_JOINT_REVOLUTE && !g->driven[joint] && slot_at(g, joint) >= 0) {
        joint = slot_at(g, joint);
        j = &g->k->joint[joint];
    }
    lw_point *q = new_point(p);
    g->used[joint] = true;
    g->whole = q && add_link(q, j->link[0]) && add_link(q, j->link[1]);
    if (!g->whole)
        return;
    q->at = j->at;
    q->angle = angle_of(j->along)*(LW_PI/180);
    note_input(g, joint, q);
    q->type = type_of(j->kind);
    gather(g, g->first[joint], q->type == LW_POINT_SLIDER ? LW_JOINT_FIXED : LW_JOINT_REVOLUTE, q->type != LW_POINT_PIN, q);
    check_input(g, g->first[joint], q);
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

/* Give every link a name that is new in small letters, too.  false: out of memory. */
static bool name_links(const lw_assembly *linkage, lw_points *p)
{
    char (*small)[LW_NAME_SIZE] = calloc((size_t)linkage->n_link, sizeof *small);
    p->name = calloc((size_t)linkage->n_link, sizeof *p->name);
    bool good = small && p->name;
    for (int l = 0; good && l < linkage->n_link; l++) {
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
        bool taken = true;
        for (int i = 1; taken; i++) {
            snprintf(name, LW_NAME_SIZE, i > 1 ? "%.20s_%d" : "%s", plain, i);
            for (n = 0; name[n]; n++)
                small[l][n] = (char)tolower((unsigned char)name[n]);
            small[l][n] = '\0';
            taken = is_word(linkage, name) || lw_key_table_find(&p->index, small, sizeof *small, small[l], (size_t)n + 1) >= 0;
        }
        good = lw_key_table_add(&p->index, small[l], (size_t)n + 1, l);
    }
    free(small);
    return good;
}

/* Which joints are driven; which lie at one place.  false: out of memory. */
static bool prepare(grouping *g)
{
    const lw_assembly *k = g->k;
    size_t n = (size_t)k->n_joint;
    lw_vec2 *at = malloc(n*sizeof *at);
    int *last = malloc(n*sizeof *last);
    lw_key_table place = { 0 };
    g->used = calloc(2*n, sizeof *g->used);
    g->first = malloc(2*n*sizeof *g->first);
    bool good = at && last && g->used && g->first;
    if (good) {
        g->driven = g->used + n;
        g->next = g->first + n;
    }
    for (int i = 0; good && i < k->n_input; i++)
        g->driven[k->input[i].joint] = true;
    for (int j = 0; good && j < k->n_joint; j++) {
        at[j] = lw_v2(k->joint[j].at.x + 0.0, k->joint[j].at.y + 0.0);       /* not -0 */
        int before = lw_key_table_find(&place, at, sizeof *at, &at[j], sizeof *at);
        g->first[j] = before >= 0 ? before : j;
        g->next[j] = -1;
        if (before >= 0)
            g->next[last[before]] = j;
        else
            good = lw_key_table_add(&place, &at[j], sizeof *at, j);
        last[g->first[j]] = j;
    }
    lw_key_table_free(&place);
    free(at);
    free(last);
    return good;
}

static lw_status points_from(grouping *g, lw_points *p, lw_error *e)
{
    const lw_assembly *linkage = g->k;
    lw_status s = lw_assembly_check(linkage, e);
    if (s != LW_OK)
        return s;
    p->n_link = linkage->n_link;
    p->ground = linkage->ground;
    g->whole = name_links(linkage, p) && prepare(g);
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_has_ratio(linkage->joint[j].kind))
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear, which has no form in this notation", linkage->joint[j].name);
    int own = lw_assembly_free_inputs(linkage);
    if (own < linkage->n_input)
        return lw_error_set(e, LW_E_KIND,
                            "the input at joint \"%s\" is tied to the first, which has no form in this notation",
                            linkage->joint[linkage->input[own].joint].name);
    for (int j = 0; j < linkage->n_joint; j++)
        while (g->whole && !g->used[j] && linkage->joint[j].kind != LW_JOINT_FIXED)
            group_joint(g, j, p);
    for (int j = 0; g->whole && j < linkage->n_joint; j++)
        if (!g->used[j])
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a weld that is not at a slider, which has no form "
                                "in this notation; make its two links one", linkage->joint[j].name);
    if (g->lost >= 0)
        return lw_error_set(e, LW_E_KIND, "input \"%s\" turns two moving links on a pin of several, which has no "
                            "form in this notation", linkage->joint[g->lost].name);
    for (int i = 0; g->whole && i < linkage->n_tracer; i++) {
        lw_point *q = new_point(p);
        g->whole = q && add_link(q, linkage->tracer[i].link);
        if (q)
            q->at = linkage->tracer[i].at;
    }
    return g->whole ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
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
    lw_points *p = lw_points_create();
    grouping g = { .k = linkage, .lost = -1 };
    lw_status s = p ? points_from(&g, p, e) : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    FILE *f = s == LW_OK ? open_memstream(&text, &size) : NULL;
    if (f) {
        print(f, p, linkage->units.metre);
        if (fclose(f) != 0) {
            free(text);
            text = NULL;
        }
    }
    lw_points_free(p);
    free(g.used);
    free(g.first);
    if (!text && s == LW_OK)
        lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    return text;
}
