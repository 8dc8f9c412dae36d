/* catalogues/exchange/adams.c - read datasets of ADAMS/Solver: first the statements, then the linkage they describe. */
#include "catalogues/exchange/adams.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/growable_array.h"
#include "base/key_table.h"
#include "base/number.h"
#include "base/real.h"
#include "base/vec2.h"
#include "catalogues/exchange/export.h"
#include "grammar/text/text_internal.h"

/* ==== statements ============================================================================================== */

/* ---- lines ------------------------------------------------------------------------------------------- */

static void skip_line(lw_cursor *c)
{
    while (lw_cursor_peek(c) >= 0 && lw_cursor_next(c) != '\n')
        ;
}

/* Copy 'name' after adams_view_name= in a comment, cut to the space there is. */
static void take_name(const lw_cursor *at, char *name)
{
    static const char key[] = "adams_view_name='";
    size_t n = 0, end = at->at;
    while (end < at->size && at->text[end] != '\n')
        end++;
    const char *found = memmem(at->text + at->at, end - at->at, key, sizeof key - 1);
    if (!found)
        return;
    for (const char *c = found + sizeof key - 1; c < at->text + end && *c != '\'' && n + 1 < LW_NAME_SIZE; c++)
        name[n++] = *c;
    name[n] = 0;
}

/* Move to the next character of the statement: over blanks, comments, and line ends after which a comma follows. False:
 * end of the statement. */
static bool goes_on(lw_cursor *c)
{
    for (;;) {
        lw_cursor_skip(c, false, 0);
        int byte = lw_cursor_peek(c);
        if (byte == '\r') {
            lw_cursor_next(c);
            continue;
        }
        if (byte != '\n' && byte != '!')
            return byte >= 0;
        lw_cursor ahead = *c;
        for (;;) {                                     /* skip empty lines and comments */
            lw_cursor_skip(&ahead, true, '!');
            if (lw_cursor_peek(&ahead) != '!')
                break;
            skip_line(&ahead);
        }
        if (lw_cursor_peek(&ahead) != ',')
            return false;
        *c = ahead;
    }
}

/* ---- pieces ------------------------------------------------------------------------------------------- */

static bool is_letter(int byte) { return byte == '_' || (byte < 128 && byte > 0 && isalpha(byte)); }

static lw_status take_word(lw_cursor *c, char *word, size_t size, const char *what)
{
    lw_cursor start = *c;
    size_t n = 0;
    char name[24];
    for (int byte = lw_cursor_peek(c); is_letter(byte) || (n > 0 && ((byte >= '0' && byte <= '9') || byte == ':'));      /* R:R */
         byte = lw_cursor_peek(c)) {
        if (n + 1 == size)
            return lw_cursor_fail(&start, "this word is too long for %s", what);
        word[n++] = (char)toupper(lw_cursor_next(c));
    }
    word[n] = 0;
    return n > 0 ? LW_OK : lw_cursor_fail(&start, "%s is expected, not %s", what, lw_byte_name(lw_cursor_peek(&start), name));
}

/* Read a number; a D behind it means degrees. */
static lw_status take_number(lw_cursor *c, double *v)
{
    lw_cursor start = *c;
    size_t n = 0;
    for (int byte = lw_cursor_peek(c);; byte = lw_cursor_peek(c), n++) {
        bool exponent = n > 0 && (c->text[c->at - 1] == 'e' || c->text[c->at - 1] == 'E');
        if (!((byte >= '0' && byte <= '9') || byte == '.' || byte == 'e' || byte == 'E'
              || ((byte == '+' || byte == '-') && (n == 0 || exponent))))
            break;
        lw_cursor_next(c);
    }
    if (lw_number_parse(start.text + start.at, n, v) != LW_OK || !(fabs(*v) <= LW_COORDINATE_MAX))
        return lw_cursor_fail(&start, "a number is expected here");
    if (lw_cursor_peek(c) == 'D' || lw_cursor_peek(c) == 'd') {
        lw_cursor_next(c);
        *v *= LW_PI/180;
    }
    return LW_OK;
}

static bool begins_number(int byte)
{
    return (byte >= '0' && byte <= '9') || byte == '-' || byte == '+' || byte == '.';
}

/* Copy the rest of the statement unchanged. */
static lw_status take_expression(lw_cursor *c, lw_adams_argument *a)
{
    lw_cursor start = *c;
    size_t n = 0;
    while (goes_on(c)) {
        if (n + 1 == sizeof a->text)
            return lw_cursor_fail(&start, "the expression is longer than %zu characters", sizeof a->text - 1);
        a->text[n++] = (char)lw_cursor_next(c);
    }
    while (n > 0 && a->text[n - 1] == ' ')
        n--;
    a->text[n] = 0;
    return LW_OK;
}

/* Read comma-separated numbers, as long as numbers follow. */
static lw_status take_values(lw_cursor *c, lw_adams_argument *a)
{
    for (;;) {
        if (a->n == LW_ADAMS_VALUE_MAX)
            return lw_cursor_fail(c, "%s has more than %d values", a->key, LW_ADAMS_VALUE_MAX);
        lw_status s = take_number(c, &a->value[a->n++]);
        lw_cursor ahead = *c;
        if (s != LW_OK || !goes_on(&ahead) || lw_cursor_peek(&ahead) != ',')
            return s;
        lw_cursor_next(&ahead);
        lw_cursor_skip(&ahead, false, 0);
        if (!begins_number(lw_cursor_peek(&ahead)))
            return LW_OK;
        *c = ahead;
    }
}

static lw_status take_argument(lw_cursor *c, lw_adams_argument *a)
{
    *a = (lw_adams_argument){ .n = 0 };
    lw_status s = take_word(c, a->key, sizeof a->key, "an argument");
    if (s != LW_OK || !goes_on(c) || lw_cursor_peek(c) != '=')
        return s;
    lw_cursor_next(c);
    goes_on(c);
    if (strcmp(a->key, "FUNCTION") == 0)
        return take_expression(c, a);
    return begins_number(lw_cursor_peek(c)) ? take_values(c, a) : take_word(c, a->text, sizeof a->text, "a value");
}

/* ---- statements ---------------------------------------------------------------------------------------- */

static lw_status take_arguments(lw_cursor *c, lw_adams_statement *st)
{
    lw_status s = LW_OK;
    char name[24];
    bool first = true;
    while (s == LW_OK && goes_on(c)) {
        if (lw_cursor_peek(c) == ',') {
            lw_cursor_next(c);
            first = true;
            continue;
        }
        if (!first)
            return lw_cursor_fail(c, "a comma is expected, not %s", lw_byte_name(lw_cursor_peek(c), name));
        if (st->n_argument == LW_ADAMS_ARGUMENT_MAX)
            return lw_cursor_fail(c, "a statement has at most %d arguments", LW_ADAMS_ARGUMENT_MAX);
        s = take_argument(c, &st->argument[st->n_argument++]);
        first = false;
    }
    return s;
}

static lw_status take_statement(lw_cursor *c, lw_adams_statement *st)
{
    lw_status s = take_word(c, st->keyword, sizeof st->keyword, "a statement");
    if (s != LW_OK || !goes_on(c))
        return s;
    if (lw_cursor_peek(c) != '/')
        return lw_cursor_fail(c, "'/' is expected behind %s", st->keyword);
    lw_cursor_next(c);
    lw_cursor_skip(c, false, 0);
    lw_cursor_number(c, &st->id);
    return take_arguments(c, st);
}

lw_status lw_adams_scan(const char *text, size_t size, const char *file, lw_adams_visit *visit, void *context, lw_error *e)
{
    lw_error own;
    lw_cursor c = lw_cursor_start(text, size, file, e ? e : &own);
    char name[LW_NAME_SIZE] = "";
    lw_status s = lw_text_check(text, size, file, e);
    skip_line(&c);
    while (s == LW_OK) {
        lw_cursor_skip(&c, true, 0);
        int byte = lw_cursor_peek(&c);
        if (byte < 0)
            return LW_OK;
        if (byte == '!') {
            take_name(&c, name);
            skip_line(&c);
            continue;
        }
        lw_adams_statement st = { .line = c.line };
        memcpy(st.name, name, sizeof name);
        name[0] = 0;
        s = take_statement(&c, &st);
        if (s == LW_OK && strcmp(st.keyword, "END") == 0)
            return LW_OK;
        if (s == LW_OK)
            s = visit(context, &st, c.e);
    }
    return s;
}

const lw_adams_argument *lw_adams_find(const lw_adams_statement *s, const char *key)
{
    for (int i = 0; i < s->n_argument; i++)
        if (strcmp(s->argument[i].key, key) == 0)
            return &s->argument[i];
    return NULL;
}

/* ==== the linkage ============================================================================================= */

#define FLAT 1e-9                          /* relative tolerance for lying in the plane              */

typedef struct frame { double r[3][3], p[3]; } frame;

typedef struct part { int id; frame f; } part;

typedef struct marker { int id, part; frame f; } marker;       /* f: in the frame of its part          */

typedef struct coupler { int id, joint[2]; double scale[2]; char name[LW_NAME_SIZE]; long line; } coupler;

typedef struct reader {
    const char  *file;
    lw_assembly *k;
    part        *part;                     /* (n_link)                                               */
    marker      *marker;
    coupler     *coupler;
    int         *joint_id;                 /* (n_joint)                                              */
    int          n_marker, n_coupler;
    int          most_links, most_parts, most_joints, most_ids, most_inputs, most_tracers, most_markers, most_couplers;
    lw_key_table links, joints, parts, joint_ids, markers;     /* the first two by name, the others by number */
    double       metre;
    lw_error    *e;
} reader;

static lw_status fail(const reader *r, const lw_adams_statement *s, const char *text)
{
    return lw_error_at(r->e, LW_E_NOTATION, r->file, s->line, 1, "%s/%d: %s", s->keyword, s->id, text);
}

/* ---- frames --------------------------------------------------------------------------------------------- */

/* Rotation matrix from body-fixed turns about z, x, z. */
static void set_euler(frame *f, const double *a)
{
    double c[3], s[3];
    for (int i = 0; i < 3; i++) {
        c[i] = cos(a[i]);
        s[i] = sin(a[i]);
    }
    const double r[3][3] = {
        { c[0]*c[2] - s[0]*c[1]*s[2], -c[0]*s[2] - s[0]*c[1]*c[2],  s[0]*s[1] },
        { s[0]*c[2] + c[0]*c[1]*s[2], -s[0]*s[2] + c[0]*c[1]*c[2], -c[0]*s[1] },
        { s[1]*s[2],                   s[1]*c[2],                   c[1] }
    };
    memcpy(f->r, r, sizeof r);
}

static frame compose(const frame *a, const frame *b)
{
    frame f;
    for (int i = 0; i < 3; i++) {
        f.p[i] = a->p[i];
        for (int j = 0; j < 3; j++) {
            f.p[i] += a->r[i][j]*b->p[j];
            f.r[i][j] = a->r[i][0]*b->r[0][j] + a->r[i][1]*b->r[1][j] + a->r[i][2]*b->r[2][j];
        }
    }
    return f;
}

/* Read QG of a part or QP of a marker, with REULER. */
static lw_status read_frame(reader *r, const lw_adams_statement *s, const char *place, frame *f)
{
    const lw_adams_argument *at = lw_adams_find(s, place), *turn = lw_adams_find(s, "REULER");
    double angle[3] = { 0 };
    *f = (frame){ .p = { 0 } };
    if ((at && at->n != 3) || (turn && turn->n != 3))
        return fail(r, s, "a place or a turn has three numbers");
    for (int i = 0; i < 3; i++) {
        f->p[i] = at ? at->value[i]*r->metre : 0;
        angle[i] = turn ? turn->value[i] : 0;
        if (!(fabs(f->p[i]) <= LW_COORDINATE_MAX) || !(fabs(angle[i]) <= 1e6))
            return fail(r, s, "this number is too large");
    }
    set_euler(f, angle);
    return LW_OK;
}

/* ---- parts, markers ------------------------------------------------------------------------------------- */

/* Make room for one more than n items in *array.  false: out of memory. */
static bool grow(void *array, int n, int *most, size_t size)
{
    void *old, *more;
    memcpy(&old, array, sizeof old);
    more = lw_array_grow(old, n, most, size);
    if (more)
        memcpy(array, &more, sizeof more);
    return more;
}

/* The name in the comment, or the letter and the number; a name in use is changed.  It is entered as number `index`. */
static lw_status set_name(reader *r, const char *wanted, const char *letter, int id, lw_key_table *t, const void *names,
                          size_t stride, int index, char *name)
{
    memset(name, 0, LW_NAME_SIZE);
    snprintf(name, LW_NAME_SIZE, "%s", wanted);
    for (int n = 0; !name[0] || lw_key_table_find(t, names, stride, name, strlen(name) + 1) >= 0; n++)
        snprintf(name, LW_NAME_SIZE, n ? "%s%d_%d" : "%s%d", letter, id, n + 1);
    return lw_key_table_add(t, name, strlen(name) + 1, index) ? LW_OK : lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
}

/* The item with this number, of those that begin with one; -1: none. */
static int find_id(const lw_key_table *t, const void *items, size_t stride, double id)
{
    int key = fabs(id) < 1e9 ? (int)id : 0;
    return key == id ? lw_key_table_find(t, items, stride, &key, sizeof key) : -1;
}

/* Enter an item under its number, unless another one has it. */
static lw_status add_id(reader *r, lw_key_table *t, const void *items, size_t stride, int id, int index)
{
    bool there = lw_key_table_find(t, items, stride, &id, sizeof id) >= 0;
    return there || lw_key_table_add(t, &id, sizeof id, index) ? LW_OK : lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
}

static lw_status read_part(reader *r, const lw_adams_statement *s)
{
    lw_assembly *k = r->k;
    int n = k->n_link;
    if (find_id(&r->parts, r->part, sizeof *r->part, s->id) >= 0)
        return fail(r, s, "this part was there already");
    if (!grow(&k->link_name, n, &r->most_links, sizeof *k->link_name) || !grow(&r->part, n, &r->most_parts, sizeof *r->part))
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
    r->part[n].id = s->id;
    lw_status st = set_name(r, s->name, "part", s->id, &r->links, k->link_name, sizeof *k->link_name, n, k->link_name[n]);
    if (st == LW_OK)
        st = add_id(r, &r->parts, r->part, sizeof *r->part, s->id, n);
    if (lw_adams_find(s, "GROUND"))
        k->ground = n;
    k->n_link++;
    return st == LW_OK ? read_frame(r, s, "QG", &r->part[n].f) : st;
}

static lw_status read_marker(reader *r, const lw_adams_statement *s)
{
    const lw_adams_argument *of = lw_adams_find(s, "PART");
    if (!grow(&r->marker, r->n_marker, &r->most_markers, sizeof *r->marker))
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
    marker *m = &r->marker[r->n_marker];
    m->id = s->id;
    m->part = of && of->n == 1 ? find_id(&r->parts, r->part, sizeof *r->part, of->value[0]) : -1;
    if (m->part < 0)
        return fail(r, s, "PART = must name a part that stands before");
    lw_status st = add_id(r, &r->markers, r->marker, sizeof *m, s->id, r->n_marker);
    r->n_marker++;
    return st == LW_OK ? read_frame(r, s, "QP", &m->f) : st;
}

/* Find the marker that an argument names, and its frame in the plane. */
static lw_status find_marker(reader *r, const lw_adams_statement *s, const char *key, int *link, frame *f)
{
    const lw_adams_argument *a = lw_adams_find(s, key);
    int i = a && a->n == 1 ? find_id(&r->markers, r->marker, sizeof *r->marker, a->value[0]) : -1;
    if (i >= 0) {
        *link = r->marker[i].part;
        *f = compose(&r->part[*link].f, &r->marker[i].f);
        return LW_OK;
    }
    char text[64];
    snprintf(text, sizeof text, "%s = must name a marker", key);
    return fail(r, s, text);
}

/* ---- joints ----------------------------------------------------------------------------------------------- */

static lw_joint_kind kind_of(const lw_adams_statement *s)
{
    bool primitive = strcmp(s->keyword, "JPRIM") == 0;
    if (primitive)
        return lw_adams_find(s, "INPLANE") ? LW_JOINT_SLOT : 0;
    return lw_adams_find(s, "REVOLUTE") ? LW_JOINT_REVOLUTE : lw_adams_find(s, "TRANSLATIONAL") ? LW_JOINT_SLIDER
         : lw_adams_find(s, "FIXED") ? LW_JOINT_FIXED : 0;
}

/* Set the joint's direction from z of the J marker: perpendicular to the plane for a pin; in the plane, along the line
 * of a slider or perpendicular to that of a slot. */
static lw_status set_direction(reader *r, const lw_adams_statement *s, const frame *f, lw_joint *p)
{
    lw_vec2 z = lw_v2(f->r[0][2], f->r[1][2]);
    double length = lw_v2_norm(z);
    if (p->kind == LW_JOINT_REVOLUTE)
        return length < FLAT ? LW_OK : fail(r, s, "a pin must stand across the x-y plane");
    if (p->kind == LW_JOINT_FIXED)
        return LW_OK;
    if (fabs(f->r[2][2]) > FLAT)
        return fail(r, s, "the marker's z axis must lie in the x-y plane");
    z = lw_v2_scale(z, 1/length);
    p->along = p->kind == LW_JOINT_SLOT ? lw_v2(z.y, -z.x) : z;
    return LW_OK;
}

/* Room for one more joint. */
static lw_joint *new_joint(reader *r)
{
    lw_assembly *k = r->k;
    bool room = grow(&k->joint, k->n_joint, &r->most_joints, sizeof *k->joint)
                && grow(&r->joint_id, k->n_joint, &r->most_ids, sizeof *r->joint_id);
    if (!room)
        lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
    return room ? &k->joint[k->n_joint] : NULL;
}

static lw_status name_joint(reader *r, const char *wanted, const char *letter, int id, lw_joint *p)
{
    return set_name(r, wanted, letter, id, &r->joints, r->k->joint, sizeof *p, r->k->n_joint, p->name);
}

static lw_status read_joint(reader *r, const lw_adams_statement *s)
{
    lw_assembly *k = r->k;
    frame i, j;
    lw_joint_kind kind = kind_of(s);
    if (!kind)
        return fail(r, s, "joints are REVOLUTE, TRANSLATIONAL or FIXED, primitives INPLANE");
    lw_joint *p = new_joint(r);
    if (!p)
        return LW_E_MEMORY;
    *p = (lw_joint){ .kind = kind };
    lw_status st = find_marker(r, s, "I", &p->link[1], &i);
    if (st == LW_OK)
        st = find_marker(r, s, "J", &p->link[0], &j);
    if (st == LW_OK)
        st = set_direction(r, s, &j, p);
    if (st == LW_OK)
        st = name_joint(r, s->name, "joint", s->id, p);
    if (st != LW_OK)
        return st;
    const frame *at = kind == LW_JOINT_SLOT ? &i : &j;
    p->at = lw_v2(at->p[0], at->p[1]);
    r->joint_id[k->n_joint++] = s->id;
    return strcmp(s->keyword, "JOINT") ? LW_OK : add_id(r, &r->joint_ids, r->joint_id, sizeof *r->joint_id, s->id, k->n_joint - 1);
}

static int find_joint(const reader *r, double id) { return find_id(&r->joint_ids, r->joint_id, sizeof *r->joint_id, id); }

/* ---- gears ------------------------------------------------------------------------------------------------- */

static lw_status read_coupler(reader *r, const lw_adams_statement *s)
{
    const lw_adams_argument *joints = lw_adams_find(s, "JOINTS"), *scales = lw_adams_find(s, "SCALES");
    if (!joints || joints->n != 2 || !scales || scales->n < 1 || scales->n > 2)
        return fail(r, s, "JOINTS = has two joints here, SCALES = two numbers");
    coupler c = { .line = s->line, .id = s->id };
    for (int i = 0; i < 2; i++) {
        c.joint[i] = find_joint(r, joints->value[i]);
        if (c.joint[i] < 0)
            return fail(r, s, "JOINTS = must name joints that stand before");
    }
    c.scale[0] = scales->n == 2 ? scales->value[0] : 1;
    c.scale[1] = scales->value[scales->n - 1];
    memcpy(c.name, s->name, sizeof c.name);
    if (!(fabs(c.scale[0]) > 0 && fabs(c.scale[1]) > 0))
        return fail(r, s, "a scale must not be 0");
    if (!grow(&r->coupler, r->n_coupler, &r->most_couplers, sizeof c))
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
    r->coupler[r->n_coupler++] = c;
    return LW_OK;
}

/* The link of joint a that is not in joint b; -1: both join the same two links, or share none. */
static int side_link(const lw_assembly *linkage, int a, int b)
{
    const int *p = linkage->joint[a].link, *q = linkage->joint[b].link;
    bool first = p[0] == q[0] || p[0] == q[1], second = p[1] == q[0] || p[1] == q[1];
    return first == second ? -1 : first ? p[1] : p[0];
}

static lw_status add_gear(reader *r, const coupler *c)
{
    lw_assembly *k = r->k;
    int found[2];
    double sign[2];
    lw_gear g;
    lw_vec2 contact;
    lw_joint *p = new_joint(r);
    if (!p)
        return LW_E_MEMORY;
    *p = (lw_joint){ .kind = LW_JOINT_GEAR, .ratio = 1,
                     .link = { side_link(k, c->joint[0], c->joint[1]), side_link(k, c->joint[1], c->joint[0]) },
                     .at = lw_v2_scale(lw_v2_add(k->joint[c->joint[0]].at, k->joint[c->joint[1]].at), 0.5) };
    if (p->link[0] < 0 || p->link[1] < 0)
        return lw_error_at(r->e, LW_E_NOTATION, r->file, c->line, 1, "the coupled joints share no carrier");
    lw_status st = name_joint(r, c->name, "gear", c->id, p);
    if (st != LW_OK)
        return st;
    k->n_joint++;
    lw_error why = { 0 };
    if (lw_export_gear(k, k->n_joint - 1, found, sign, &why) != LW_OK || found[0] != c->joint[0] || found[1] != c->joint[1])
        return lw_error_at(r->e, LW_E_NOTATION, r->file, c->line, 1, "these joints make no gear pair on one carrier%s%s",
                           why.text[0] ? ": " : "", why.text);
    p->ratio = -c->scale[0]/c->scale[1]*sign[1]/sign[0];
    const lw_joint *wheel[] = { &k->joint[found[0]], &k->joint[found[1]] };
    bool turn = !lw_joint_slides(wheel[0]->kind) && !lw_joint_slides(wheel[1]->kind);
    if (turn && p->ratio != 1)                       /* on the line of these centres: the wheels may turn on other links, too */
        p->at = lw_v2_scale(lw_v2_sub(wheel[0]->at, lw_v2_scale(wheel[1]->at, p->ratio)), 1/(1 - p->ratio));
    if (lw_assembly_gear(k, k->n_joint - 1, &g, &contact, &why) != LW_OK)
        return lw_error_at(r->e, LW_E_NOTATION, r->file, c->line, 1, "%s", why.text);
    p->at = contact;
    return LW_OK;
}

/* ---- inputs, tracers ---------------------------------------------------------------------------------------- */

static lw_status read_motion(reader *r, const lw_adams_statement *s)
{
    const lw_adams_argument *of = lw_adams_find(s, "JOINT");
    lw_assembly *k = r->k;
    int j = of && of->n == 1 ? find_joint(r, of->value[0]) : -1;
    if (j < 0 || !lw_joint_can_drive(k->joint[j].kind))
        return fail(r, s, "JOINT = must name a pin or slider that stands before");
    if (!grow(&k->input, k->n_input, &r->most_inputs, sizeof *k->input))
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
    k->input[k->n_input++] = (lw_input){ .joint = j };
    return LW_OK;
}

static lw_status read_request(reader *r, const lw_adams_statement *s)
{
    lw_assembly *k = r->k;
    frame f;
    if (!lw_adams_find(s, "DISPLACEMENT"))
        return LW_OK;
    if (!grow(&k->tracer, k->n_tracer, &r->most_tracers, sizeof *k->tracer))
        return lw_error_set(r->e, LW_E_MEMORY, "out of memory for a dataset");
    lw_tracer *t = &k->tracer[k->n_tracer];
    *t = (lw_tracer){ .link = 0 };
    lw_status st = find_marker(r, s, "I", &t->link, &f);
    if (st != LW_OK)
        return st;
    t->at = lw_v2(f.p[0], f.p[1]);
    t->angle = atan2(f.r[1][0], f.r[0][0]);
    snprintf(t->name, sizeof t->name, "%s", s->name);
    for (int i = 0; i < k->n_tracer; i++)
        if (strcmp(k->tracer[i].name, t->name) == 0)
            t->name[0] = 0;
    if (!t->name[0])
        snprintf(t->name, sizeof t->name, "point %d", k->n_tracer + 1);
    k->n_tracer++;
    return LW_OK;
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static lw_status read_units(reader *r, const lw_adams_statement *s)
{
    static const struct { const char *adams, *ours; } names[] = {
        { "METER", "m" }, { "METRE", "m" }, { "MILLIMETER", "mm" }, { "MILLIMETRE", "mm" }, { "CENTIMETER", "cm" },
        { "KILOMETER", "km" }, { "INCH", "in" }, { "FOOT", "ft" }, { "MICROMETER", "um" }
    };
    const lw_adams_argument *length = lw_adams_find(s, "LENGTH");
    for (size_t i = 0; length && i < sizeof names/sizeof *names; i++)
        if (strcmp(length->text, names[i].adams) == 0) {
            lw_units_set_length(&r->k->units, names[i].ours);
            r->metre = r->k->units.metre;
            return LW_OK;
        }
    return length ? fail(r, s, "this unit of length is not known") : LW_OK;
}

static lw_status visit(void *context, const lw_adams_statement *s, lw_error *e)
{
    static const struct { const char *keyword; lw_status (*read)(reader *r, const lw_adams_statement *s); } rows[] = {
        { "UNITS", read_units }, { "PART", read_part }, { "MARKER", read_marker }, { "JOINT", read_joint },
        { "JPRIM", read_joint }, { "COUPLER", read_coupler }, { "MOTION", read_motion }, { "REQUEST", read_request }
    };
    (void)e;
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (strcmp(s->keyword, rows[i].keyword) == 0)
            return rows[i].read(context, s);
    return LW_OK;
}

static lw_status finish(reader *r)
{
    lw_assembly *k = r->k;
    lw_status s = LW_OK;
    if (k->n_link == 0 || k->ground < 0)
        return lw_error_at(r->e, LW_E_NOTATION, r->file, 1, 1, k->n_link == 0 ? "there is no PART in this dataset"
                           : "no PART is the GROUND");
    for (int n = 0; s == LW_OK && n < r->n_coupler; n++)
        s = add_gear(r, &r->coupler[n]);
    lw_error why = { 0 };
    if (s == LW_OK && lw_assembly_check(k, &why) != LW_OK)
        s = lw_error_at(r->e, LW_E_NOTATION, r->file, 1, 1, "%s", why.text);
    if (s == LW_OK && lw_assembly_set_inputs(k, NULL) != LW_OK)
        s = lw_error_set(r->e, LW_E_MEMORY, "out of memory");
    return s;
}

/* Set the linkage's name from the title, without the words that exports put before it. */
static void set_title(lw_assembly *linkage, const char *text, size_t size)
{
    static const char usual[] = "ADAMS/View model name: ";
    size_t skip = size >= sizeof usual - 1 && memcmp(text, usual, sizeof usual - 1) == 0 ? sizeof usual - 1 : 0, n = 0;
    for (size_t i = skip; i < size && text[i] != '\n' && text[i] != '\r' && n + 1 < sizeof linkage->name; i++)
        if (text[i] >= ' ' && text[i] < 127)
            linkage->name[n++] = text[i];
}

lw_status lw_adams_read(const char *text, size_t size, const char *file, lw_assembly *linkage, lw_error *e)
{
    lw_error own;
    *linkage = (lw_assembly){ .units = lw_units_si(), .ground = -1 };
    set_title(linkage, text, size);
    reader r = { .file = file, .k = linkage, .metre = 1, .e = e ? e : &own };
    lw_status s = lw_adams_scan(text, size, file, visit, &r, r.e);
    if (s == LW_OK)
        s = finish(&r);
    if (s != LW_OK)
        lw_assembly_free(linkage);
    free(r.part);
    free(r.marker);
    free(r.coupler);
    free(r.joint_id);
    lw_key_table *const tables[] = { &r.links, &r.joints, &r.parts, &r.joint_ids, &r.markers };
    for (size_t i = 0; i < sizeof tables/sizeof *tables; i++)
        lw_key_table_free(tables[i]);
    return s;
}
