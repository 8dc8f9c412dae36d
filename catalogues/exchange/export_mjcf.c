/* catalogues/exchange/export_mjcf.c - write a linkage as a model of MuJoCo (XML reference of MuJoCo 2.2). */
#include "catalogues/exchange/export.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define DIGITS 15

typedef struct writer {
    const lw_linkage *k;
    lw_bytes         *out;
    double            size;
    bool              in_tree[LW_JOINT_MAX];
    int               parent[LW_LINK_MAX];     /* parent link, and the joint to it; -1: none (ground) */
    int               joint[LW_LINK_MAX];
    lw_vec2           origin[LW_LINK_MAX];     /* of the body's frame [m]                           */
} writer;

/* ---- text --------------------------------------------------------------------------------------- */

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }

static void put_number(writer *w, double v) { lw_bytes_number(w->out, v, DIGITS); }

static void put_vec(writer *w, lw_vec2 v)
{
    put_number(w, v.x);
    put(w, " ");
    put_number(w, v.y);
    put(w, " 0");
}

static void put_indent(writer *w, int depth)
{
    put(w, "\n");
    while (depth-- > 0)
        put(w, "  ");
}

/* Write an attribute that holds a name followed by `more`. */
static void put_name(writer *w, const char *attribute, const char *name, const char *more)
{
    put(w, " ");
    put(w, attribute);
    put(w, "=\"");
    lw_bytes_xml(w->out, name);
    put(w, more);
    put(w, "\"");
}

/* As put_name for a link; the name "world" is reserved in MuJoCo. */
static void put_link(writer *w, const char *attribute, int link, const char *more)
{
    const char *name = w->k->link_name[link];
    put_name(w, attribute, name, strcmp(name, "world") == 0 && !*more ? " link" : more);
}

/* ---- the tree ----------------------------------------------------------------------------------- */

static bool is_input(const lw_linkage *k, int joint)
{
    for (int i = 0; i < k->n_input; i++)
        if (k->input[i].joint == joint)
            return true;
    return false;
}

/* Order in which the tree takes the joints: driven joints, joints of gear wheels, welds, sliders and slots; pins last,
 * because MuJoCo closes a loop at a pin directly. -1: never. */
static int rank_of(const lw_linkage *k, int joint, const bool *at_gear)
{
    lw_joint_kind kind = k->joint[joint].kind;
    return lw_joint_has_ratio(kind) ? -1 : is_input(k, joint) ? 0 : at_gear[joint] ? 1
         : lw_joint_freedoms(kind) == 0 ? 2 : lw_joint_turns(kind) ? 4 : 3;
}

static lw_status mark_gears(const lw_linkage *k, bool *at_gear, lw_error *e)
{
    for (int j = 0; j < k->n_joint; j++) {
        int joint[2];
        double sign[2];
        lw_status s = lw_joint_has_ratio(k->joint[j].kind) ? lw_export_gear(k, j, joint, sign, e) : LW_OK;
        if (s != LW_OK)
            return s;
        if (lw_joint_has_ratio(k->joint[j].kind))
            at_gear[joint[0]] = at_gear[joint[1]] = true;
    }
    return LW_OK;
}

/* Choose a spanning tree by rank (Kruskal). */
static void choose_tree(writer *w, const bool *at_gear)
{
    const lw_linkage *k = w->k;
    int group[LW_LINK_MAX];
    for (int i = 0; i < k->n_link; i++)
        group[i] = i;
    for (int rank = 0; rank <= 4; rank++)
        for (int j = 0; j < k->n_joint; j++) {
            int a = group[k->joint[j].link[0]], b = group[k->joint[j].link[1]];
            if (rank_of(k, j, at_gear) != rank || a == b)
                continue;
            w->in_tree[j] = true;
            for (int i = 0; i < k->n_link; i++)
                if (group[i] == b)
                    group[i] = a;
        }
}

/* Set parents, going away from the ground. False: a link is connected only by a gear. */
static bool root_tree(writer *w)
{
    const lw_linkage *k = w->k;
    int reached = 1;
    for (int i = 0; i < k->n_link; i++)
        w->parent[i] = w->joint[i] = -1;
    for (bool more = true; more;) {
        more = false;
        for (int j = 0; j < k->n_joint; j++)
            for (int side = 0; w->in_tree[j] && side < 2; side++) {
                int from = k->joint[j].link[side], to = k->joint[j].link[1 - side];
                if ((from != k->ground && w->parent[from] < 0) || to == k->ground || w->parent[to] >= 0)
                    continue;
                w->parent[to] = from;
                w->joint[to] = j;
                w->origin[to] = k->joint[j].at;
                more = ++reached > 0;
            }
    }
    return reached == k->n_link;
}

/* ---- bodies -------------------------------------------------------------------------------------- */

/* +1 if the turn or shift of `child` has the joint's sign, else -1. */
static double count_sign(const lw_linkage *k, int joint, int child)
{
    const lw_joint *p = &k->joint[joint];
    bool turned = lw_joint_turns(p->kind) && p->link[1] == k->ground;
    return (p->link[turned ? 0 : 1] == child) ? 1 : -1;
}

static void put_reference(writer *w, int joint)
{
    const lw_linkage *k = w->k;
    for (int i = 0; i < k->n_input; i++)
        if (k->input[i].joint == joint) {
            put(w, " ref=\"");
            put_number(w, k->input[i].value);
            put(w, "\"");
            return;
        }
}

static void put_slide(writer *w, int depth, int joint, double sign, const char *more)
{
    put_indent(w, depth);
    put(w, "<joint type=\"slide\"");
    put_name(w, "name", w->k->joint[joint].name, more);
    put(w, " axis=\"");
    put_vec(w, lw_v2_scale(w->k->joint[joint].along, sign));
    put(w, "\"");
    put_reference(w, joint);
    put(w, "/>");
}

/* Write the tree joint of a body; the body's frame begins at the joint's point. A slot slides on link[0] and turns at
 * the pin: seen from the pin's link, it turns first. */
static void put_joint(writer *w, int depth, int child)
{
    const lw_linkage *k = w->k;
    int j = w->joint[child];
    const lw_joint *p = &k->joint[j];
    double sign = count_sign(k, j, child);
    bool slot = lw_joint_has_slot(p->kind), carries = slot && p->link[0] == child;
    if (lw_joint_translates(p->kind) || (slot && !carries))
        put_slide(w, depth, j, sign, slot ? " slide" : "");
    if (lw_joint_turns(p->kind) || slot) {
        put_indent(w, depth);
        put(w, "<joint type=\"hinge\"");
        put_name(w, "name", p->name, slot ? " turn" : "");
        put(w, sign < 0 ? " axis=\"0 0 -1\"" : " axis=\"0 0 1\"");
        put_reference(w, j);
        put(w, "/>");
    }
    if (carries)
        put_slide(w, depth, j, -1, " slide");
}

static void put_rod(writer *w, int depth, lw_vec2 a, lw_vec2 b)
{
    bool ball = lw_v2_norm(lw_v2_sub(b, a)) < 1e-9*w->size;
    put_indent(w, depth);
    put(w, ball ? "<geom type=\"sphere\" pos=\"" : "<geom type=\"capsule\" fromto=\"");
    put_vec(w, a);
    if (!ball) {
        put(w, " ");
        put_vec(w, b);
    }
    put(w, "\" size=\"");
    put_number(w, (ball ? 0.02 : 0.01)*w->size);
    put(w, "\"/>");
}

/* Write rods from the frame's origin to the other points of the link, or a ball if there are none. */
static void put_shape(writer *w, int depth, int link)
{
    const lw_linkage *k = w->k;
    bool any = false;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *p = &k->joint[j];
        if ((p->link[0] != link && p->link[1] != link) || j == w->joint[link] || lw_joint_has_ratio(p->kind))
            continue;
        lw_vec2 to = lw_v2_sub(p->at, w->origin[link]);
        if (lw_v2_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, lw_v2(0, 0), to);
        any = true;
    }
    for (int t = 0; t < k->n_tracer; t++) {
        lw_vec2 to = lw_v2_sub(k->tracer[t].at, w->origin[link]);
        if (k->tracer[t].link != link || lw_v2_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, lw_v2(0, 0), to);
        any = true;
    }
    if (!any)
        put_rod(w, depth, lw_v2(0, 0), lw_v2(0, 0));
}

static void put_sites(writer *w, int depth, int link)
{
    const lw_linkage *k = w->k;
    for (int t = 0; t < k->n_tracer; t++) {
        if (k->tracer[t].link != link)
            continue;
        put_indent(w, depth);
        put(w, "<site");
        put_name(w, "name", k->tracer[t].name, "");
        put(w, " pos=\"");
        put_vec(w, lw_v2_sub(k->tracer[t].at, w->origin[link]));
        put(w, "\" euler=\"0 0 ");
        put_number(w, k->tracer[t].angle);
        put(w, "\" size=\"");
        put_number(w, 0.02*w->size);
        put(w, "\"/>");
    }
}

/* Write a body that slides on a line of link[0], for each loop that is closed by a slider or a slot. */
static void put_runners(writer *w, int depth, int link)
{
    const lw_linkage *k = w->k;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *p = &k->joint[j];
        if (w->in_tree[j] || p->link[0] != link || !lw_joint_slides(p->kind))
            continue;
        put_indent(w, depth);
        put(w, "<body");
        put_name(w, "name", p->name, " runner");
        put(w, " pos=\"");
        put_vec(w, lw_v2_sub(p->at, w->origin[link]));
        put(w, "\">");
        put_slide(w, depth + 1, j, 1, "");
        put_rod(w, depth + 1, lw_v2(0, 0), lw_v2(0, 0));
        put_indent(w, depth);
        put(w, "</body>");
    }
}

/* Write a link and its subtree; recursion as deep as the tree, at most LW_LINK_MAX. */
static void put_body(writer *w, int depth, int link)
{
    const lw_linkage *k = w->k;
    bool ground = link == k->ground;
    if (!ground) {
        put_indent(w, depth);
        put(w, "<body");
        put_link(w, "name", link, "");
        put(w, " pos=\"");
        put_vec(w, lw_v2_sub(w->origin[link], w->origin[w->parent[link]]));
        put(w, "\">");
        put_joint(w, depth + 1, link);
        put_shape(w, depth + 1, link);
    }
    put_sites(w, depth + 1, link);
    put_runners(w, depth + 1, link);
    for (int i = 0; i < k->n_link; i++)
        if (i != k->ground && w->parent[i] == link)
            put_body(w, depth + 1, i);
    if (!ground) {
        put_indent(w, depth);
        put(w, "</body>");
    }
}

/* ---- what closes the loops ----------------------------------------------------------------------- */

/* body1 must be a body: the ground is the world, so it is second and is left out. */
static void put_pair(writer *w, const char *kind, int joint, bool runner, bool anchor)
{
    const lw_linkage *k = w->k;
    const lw_joint *p = &k->joint[joint];
    int first = p->link[0] == k->ground || runner ? 1 : 0, a = p->link[first], b = p->link[1 - first];
    if (a == k->ground) {              /* the runner on a line of a moving link, connected to the ground */
        put_indent(w, 2);
        put(w, kind);
        put_name(w, "body1", p->name, " runner");
    } else {
        put_indent(w, 2);
        put(w, kind);
        put_link(w, "body1", a, "");
        if (runner)
            put_name(w, "body2", p->name, " runner");
        else if (b != k->ground)
            put_link(w, "body2", b, "");
    }
    if (anchor) {
        put(w, " anchor=\"");
        put_vec(w, a == k->ground ? lw_v2(0, 0) : lw_v2_sub(p->at, w->origin[a]));
        put(w, "\"");
    }
    put(w, "/>");
}

static lw_status put_gear(writer *w, int gear, lw_error *e)
{
    const lw_linkage *k = w->k;
    int joint[2];
    double sign[2];
    lw_status s = lw_export_gear(k, gear, joint, sign, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < 2; i++)
        if (!w->in_tree[joint[i]])
            return lw_error_set(e, LW_E_KIND, "gear '%s' runs on joint '%s', by which a loop is closed; MuJoCo couples "
                                "joints of its tree only", k->joint[gear].name, k->joint[joint[i]].name);
    put_indent(w, 2);
    put(w, "<joint");
    put_name(w, "joint1", k->joint[joint[1]].name, "");
    put_name(w, "joint2", k->joint[joint[0]].name, "");
    put(w, " polycoef=\"0 ");
    put_number(w, k->joint[gear].ratio*sign[0]*sign[1]);
    put(w, " 0 0 0\"/>");
    return LW_OK;
}

static void put_tie(writer *w, int input)
{
    put_indent(w, 2);
    put(w, "<joint");
    put_name(w, "joint1", w->k->joint[w->k->input[input].joint].name, "");
    put_name(w, "joint2", w->k->joint[w->k->input[0].joint].name, "");
    put(w, " polycoef=\"0 ");
    put_number(w, w->k->input[input].ratio);
    put(w, " 0 0 0\"/>");
}

static lw_status put_closures(writer *w, lw_error *e)
{
    lw_status s = LW_OK;
    put(w, "\n  <equality>");
    for (int j = 0; s == LW_OK && j < w->k->n_joint; j++) {
        if (w->in_tree[j])
            continue;
        switch (w->k->joint[j].kind) {
        case LW_JOINT_REVOLUTE: put_pair(w, "<connect", j, false, true);  break;
        case LW_JOINT_SLOT:     put_pair(w, "<connect", j, true, true);   break;
        case LW_JOINT_SLIDER:   put_pair(w, "<weld", j, true, false);     break;
        case LW_JOINT_FIXED:    put_pair(w, "<weld", j, false, false);    break;
        case LW_JOINT_GEAR:     s = put_gear(w, j, e);                    break;
        }
    }
    for (int i = lw_linkage_free_inputs(w->k); s == LW_OK && i < w->k->n_input; i++)
        put_tie(w, i);
    put(w, "\n  </equality>");
    return s;
}

/* ---- the whole ------------------------------------------------------------------------------------ */

static void put_drives(writer *w)
{
    const lw_linkage *k = w->k;
    put(w, "\n  <actuator>");
    for (int i = 0; i < lw_linkage_free_inputs(k); i++) {
        const lw_input *in = &k->input[i];
        put(w, "\n    <position kp=\"100\"");
        put_name(w, "name", k->joint[in->joint].name, " drive");
        put_name(w, "joint", k->joint[in->joint].name, "");
        if (in->first < in->last) {
            put(w, " ctrllimited=\"true\" ctrlrange=\"");
            put_number(w, in->first);
            put(w, " ");
            put_number(w, in->last);
            put(w, "\"");
        }
        put(w, "/>");
    }
    put(w, "\n  </actuator>\n  <sensor>");
    for (int t = 0; t < k->n_tracer; t++) {
        put(w, "\n    <framepos objtype=\"site\"");
        put_name(w, "objname", k->tracer[t].name, "");
        put(w, "/>");
    }
    put(w, "\n  </sensor>");
}

static void put_head(writer *w)
{
    put(w, "<mujoco");
    put_name(w, "model", w->k->name[0] ? w->k->name : "linkage", "");
    put(w, ">\n  <compiler angle=\"radian\" boundmass=\"1e-9\" boundinertia=\"1e-12\"/>"
           "\n  <option gravity=\"0 0 0\" timestep=\"0.001\"/>"
           "\n  <statistic extent=\"");
    put_number(w, w->size);
    put(w, "\"/>\n  <default>"
           "\n    <joint limited=\"false\"/>"
           "\n    <geom contype=\"0\" conaffinity=\"0\" density=\"7850\" rgba=\"0.35 0.55 0.75 1\"/>"
           "\n    <site rgba=\"0.85 0.35 0 1\"/>"
           "\n    <equality solref=\"0.004 1\" solimp=\"0.99 0.999 0.0001\"/>"
           "\n  </default>\n  <worldbody>");
}

static lw_status check_drives(const writer *w, lw_error *e)
{
    for (int i = 0; i < w->k->n_input; i++)
        if (!w->in_tree[w->k->input[i].joint])
            return lw_error_set(e, LW_E_KIND, "input '%s' closes a loop of inputs, which has no form in MJCF",
                                w->k->joint[w->k->input[i].joint].name);
    return LW_OK;
}

lw_status lw_export_mjcf(const lw_linkage *k, lw_bytes *out, lw_error *e)
{
    writer w = { .k = k, .out = out, .size = lw_export_size(k) };
    bool at_gear[LW_JOINT_MAX] = { false };
    lw_status s = lw_linkage_check(k, e);
    if (s == LW_OK)
        s = mark_gears(k, at_gear, e);
    if (s == LW_OK) {
        choose_tree(&w, at_gear);
        s = root_tree(&w) ? check_drives(&w, e)
          : lw_error_set(e, LW_E_KIND, "a link hangs on a gear alone, which has no form in MJCF");
    }
    if (s == LW_OK) {
        put_head(&w);
        put_body(&w, 1, k->ground);
        put(&w, "\n  </worldbody>");
        s = put_closures(&w, e);
    }
    if (s != LW_OK) {
        lw_bytes_free(out);
        return s;
    }
    put_drives(&w);
    put(&w, "\n</mujoco>\n");
    return lw_bytes_end(out, e);
}
