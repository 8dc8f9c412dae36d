/* catalogues/exchange/export_urdf.c - a linkage as a robot description: URDF (a tree) or SDF 1.7 (loops are joints
 * too).
 *
 * All frames are parallel to the world in the drawn posture, and all coordinates are 0 there. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/tree.h"

#define DIGITS 15
#define STEEL  7850.0                          /* [kg/m^3]                                                */

typedef struct writer {
    const lw_assembly *k;
    const lw_model   *m;
    lw_bytes         *out;
    lw_export_tree    tree;
    lw_owners         joints, tracers;         /* of each link                                            */
    lw_owners         inputs, springs;         /* of each joint                                           */
    lw_vec2          *rod;                     /* (n_joint + n_tracer) scratch                            */
    double            size;
    bool              sdf, weighed;
} writer;

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }
static void put_number(writer *w, double v) { lw_bytes_number(w->out, v, DIGITS); }

static void put_numbers(writer *w, const double *v, int n)
{
    for (int i = 0; i < n; i++) {
        put(w, i ? " " : "");
        put_number(w, v[i]);
    }
}

/* `before` name and `more` `after`, the name in XML. */
static void put_name(writer *w, const char *before, const char *name, const char *more, const char *after)
{
    put(w, before);
    lw_bytes_xml(w->out, name);
    put(w, more);
    put(w, after);
}

/* A place and a turn: attributes of <origin> in URDF, the text of <pose> in SDF. */
static void put_place(writer *w, const char *indent, lw_vec2 p, double pitch, double yaw)
{
    double v[6] = { p.x, p.y, 0, 0, pitch, yaw };
    put(w, indent);
    put(w, w->sdf ? "<pose>" : "<origin xyz=\"");
    put_numbers(w, v, w->sdf ? 6 : 3);
    if (!w->sdf) {
        put(w, "\" rpy=\"");
        put_numbers(w, v + 3, 3);
    }
    put(w, w->sdf ? "</pose>\n" : "\"/>\n");
}

/* ---- links ---------------------------------------------------------------------------------------- */

/* The rods from the frame's origin of a link to its other points: shapes, and mass, centre and inertia of steel rods.
 * */
typedef struct rods { int n; lw_vec2 *to; double mass, inertia; lw_vec2 centre; } rods;

static void add_rod(const writer *w, rods *r, int link, lw_vec2 at)
{
    lw_vec2 to = lw_v2_sub(at, lw_export_origin(&w->tree, link));
    if (lw_v2_norm(to) > 1e-9*w->size)
        r->to[r->n++] = to;
}

static void find_rods(const writer *w, int link, rods *r)
{
    const lw_assembly *k = w->k;
    double radius = 0.01*w->size, area = LW_PI*radius*radius;
    lw_vec2 sum = { 0, 0 };
    r->n = 0;
    r->to = w->rod;
    for (int at = w->joints.start[link]; at < w->joints.start[link + 1]; at++)
        add_rod(w, r, link, k->joint[w->joints.entry[at]/2].at);
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++)
        add_rod(w, r, link, k->tracer[w->tracers.entry[at]].at);
    r->mass = STEEL*(r->n > 0 ? 4*area*radius/3 : 4*LW_PI/3*8*radius*radius*radius);      /* a ball at the joint */
    r->inertia = 0.4*r->mass*radius*radius*(r->n > 0 ? 1 : 4);
    for (int i = 0; i < r->n; i++) {
        double l = lw_v2_norm(r->to[i]), m = STEEL*area*l;
        r->mass += m;
        r->inertia += m*l*l/3;
        sum = lw_v2_add(sum, lw_v2_scale(r->to[i], m/2));
    }
    r->centre = lw_v2_scale(sum, 1/r->mass);
    r->inertia -= r->mass*lw_v2_dot(r->centre, r->centre);
}

static void put_inertia(writer *w, double mass, lw_vec2 centre, double inertia)
{
    static const char *const names[] = { "ixx", "ixy", "ixz", "iyy", "iyz", "izz" };
    put(w, "    <inertial>\n");
    put_place(w, "      ", centre, 0, 0);
    put(w, w->sdf ? "      <mass>" : "      <mass value=\"");
    put_number(w, mass);
    put(w, w->sdf ? "</mass>\n      <inertia>" : "\"/>\n      <inertia");
    for (int i = 0; i < 6; i++) {
        double v = i == 0 || i == 3 || i == 5 ? inertia : 0;
        put(w, w->sdf ? "<" : " ");
        put(w, names[i]);
        put(w, w->sdf ? ">" : "=\"");
        put_number(w, v);
        put(w, w->sdf ? "</" : "\"");
        put(w, w->sdf ? names[i] : "");
        put(w, w->sdf ? ">" : "");
    }
    put(w, w->sdf ? "</inertia>\n    </inertial>\n" : "/>\n    </inertial>\n");
}

static void put_visual(writer *w, int number, lw_vec2 to)
{
    char name[48];
    double radius = 0.01*w->size, length = lw_v2_norm(to);
    snprintf(name, sizeof name, "    <visual name=\"rod %d\">\n", number);
    put(w, name);
    put_place(w, "      ", lw_v2_scale(to, 0.5), LW_PI/2, atan2(to.y, to.x));
    put(w, w->sdf ? "      <geometry><cylinder><radius>" : "      <geometry><cylinder radius=\"");
    put_number(w, radius);
    put(w, w->sdf ? "</radius><length>" : "\" length=\"");
    put_number(w, length);
    put(w, w->sdf ? "</length></cylinder></geometry>\n    </visual>\n" : "\"/></geometry>\n    </visual>\n");
}

static void put_link(writer *w, int link)
{
    rods r;
    find_rods(w, link, &r);
    put_name(w, "  <link name=\"", w->k->link_name[link], "", "\">\n");
    if (w->sdf)
        put_place(w, "    ", lw_export_origin(&w->tree, link), 0, 0);
    if (w->weighed) {                                  /* engines need some mass in every body */
        const lw_body *b = &w->m->body[link];
        double mass = b->mass > 0 ? b->mass : 1e-6;
        put_inertia(w, mass, b->given ? lw_v2_sub(b->centre, lw_export_origin(&w->tree, link)) : lw_v2(0, 0),
                    b->inertia > 0 ? b->inertia : 1e-6*mass*w->size*w->size);
    } else {
        put_inertia(w, r.mass, r.centre, r.inertia);
    }
    for (int i = 0; i < r.n; i++)
        put_visual(w, i + 1, r.to[i]);
    put(w, "  </link>\n");
}

/* ---- joints --------------------------------------------------------------------------------------- */

/* Write one joint. turns: about z, else along the joint's line; `more` distinguishes the two halves of a slot. */
static void put_joint(writer *w, int j, const char *more, const char *type, const char *parent, const char *parent_more,
                      const char *child, const char *child_more, lw_vec2 at, double sign)
{
    const lw_joint *p = &w->k->joint[j];
    const int *input = w->inputs.start + j;
    const lw_input *in = input[0] < input[1] ? &w->k->input[w->inputs.entry[input[0]]] : NULL;
    bool slides = strcmp(type, "prismatic") == 0, fixed = strcmp(type, "fixed") == 0, free = true;
    double low = slides ? -10*w->size : -1e9, high = -low, damping = 0, stiffness = 0, pull = 0;
    double axis[3] = { slides ? sign*p->along.x : 0, slides ? sign*p->along.y : 0, slides ? 0 : sign };
    if (in && in->first < in->last) {
        low = in->first - in->value;
        high = in->last - in->value;
        free = false;
    }
    for (int i = w->m ? w->springs.start[j] : 0; w->m && i < w->springs.start[j + 1]; i++) {
        const lw_joint_spring *spring = &w->m->joint_spring[w->springs.entry[i]];
        damping += spring->damping;
        stiffness += spring->stiffness;
        pull += spring->stiffness*spring->free;
    }
    bool around = !slides && free && !w->sdf;
    put_name(w, "  <joint name=\"", p->name, more, "\" type=\"");
    put(w, around && !fixed ? "continuous" : type);
    put_name(w, w->sdf ? "\">\n    <parent>" : "\">\n    <parent link=\"", parent, parent_more, w->sdf ? "</parent>\n" : "\"/>\n");
    put_name(w, w->sdf ? "    <child>" : "    <child link=\"", child, child_more, w->sdf ? "</child>\n" : "\"/>\n");
    put_place(w, "    ", at, 0, 0);
    if (!fixed) {
        put(w, w->sdf ? "    <axis>\n      <xyz>" : "    <axis xyz=\"");
        put_numbers(w, axis, 3);
        put(w, w->sdf ? "</xyz>\n" : "\"/>\n");
        if (!around) {
            put(w, w->sdf ? "      <limit><lower>" : "    <limit lower=\"");
            put_number(w, low);
            put(w, w->sdf ? "</lower><upper>" : "\" upper=\"");
            put_number(w, high);
            put(w, w->sdf ? "</upper></limit>\n" : "\" effort=\"1e9\" velocity=\"1e6\"/>\n");
        }
        if (damping > 0 || stiffness > 0) {
            put(w, w->sdf ? "      <dynamics><damping>" : "    <dynamics damping=\"");
            put_number(w, damping);
            if (w->sdf) {
                put(w, "</damping><spring_reference>");
                put_number(w, stiffness > 0 ? pull/stiffness : 0);
                put(w, "</spring_reference><spring_stiffness>");
                put_number(w, stiffness);
            }
            put(w, w->sdf ? "</spring_stiffness></dynamics>\n" : "\"/>\n");
        }
        put(w, w->sdf ? "    </axis>\n" : "");
    }
    put(w, "  </joint>\n");
}

static const char *body_name(const writer *w, int link)
{
    return w->sdf && link == w->k->ground ? "world" : w->k->link_name[link];
}

/* Write the joint between two links; a slot is a body of its own that slides on link[0], and a pin. */
static void put_pair(writer *w, int j, int parent, int child)
{
    const lw_joint *p = &w->k->joint[j];
    lw_vec2 from = w->sdf ? lw_export_origin(&w->tree, child) : parent == w->k->ground ? lw_v2(0, 0) : lw_export_origin(&w->tree, parent);
    lw_vec2 at = lw_v2_sub(p->at, from);
    double sign = lw_export_count_sign(w->k, j, child);
    const char *a = body_name(w, parent), *b = body_name(w, child);
    if (!lw_joint_has_slot(p->kind)) {
        put_joint(w, j, "", lw_joint_freedoms(p->kind) == 0 ? "fixed" : lw_joint_turns(p->kind) ? "revolute"
                  : "prismatic", a,
                  "", b, "", at, sign);
        return;
    }
    bool carries = p->link[0] == child;
    double mass = w->weighed ? 1e-6 : STEEL*1e-6*w->size*w->size*w->size;
    put_name(w, "  <link name=\"", p->name, " block", "\">\n");
    if (w->sdf)
        put_place(w, "    ", p->at, 0, 0);
    put_inertia(w, mass, lw_v2(0, 0), 1e-4*mass*w->size*w->size);
    put(w, "  </link>\n");
    put_joint(w, j, carries ? " turn" : " slide", carries ? "revolute" : "prismatic", a, "", p->name, " block",
              w->sdf ? lw_v2(0, 0) : at, carries ? sign : 1);
    put_joint(w, j, carries ? " slide" : " turn", carries ? "prismatic" : "revolute", p->name, " block", b, "",
              w->sdf ? at : lw_v2(0, 0), carries ? -1 : sign);
}

/* ---- the whole ------------------------------------------------------------------------------------ */

static lw_status check(const writer *w, lw_error *e)
{
    const lw_model *m = w->m;
    const char *form = w->sdf ? "SDF" : "URDF";
    for (int j = 0; j < w->k->n_joint; j++) {
        if (lw_joint_has_ratio(w->k->joint[j].kind))
            return lw_error_set(e, LW_E_KIND, "gear '%s' has no form in %s", w->k->joint[j].name, form);
        if (m && (m->friction[j].coefficient > 0 || m->clearance[j].model != LW_CLEARANCE_NONE || m->stop[j].has_least
                  || m->stop[j].has_greatest))
            return lw_error_set(e, LW_E_KIND, "joint '%s' has friction, clearance or a stop, which is not written to %s",
                                w->k->joint[j].name, form);
    }
    for (int i = 0; m && i < m->n_joint_spring; i++) {
        const lw_joint_spring *p = &m->joint_spring[i];
        if (p->law || lw_joint_has_slot(w->k->joint[p->joint].kind) || (!w->sdf && (p->stiffness > 0 || !w->tree.in_tree[p->joint])))
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' has no form in %s", p->name, form);
    }
    if (m && m->n_spring + m->n_force + m->n_motor > 0)
        return lw_error_set(e, LW_E_KIND, "springs between points, forces and motors have no form in %s", form);
    return LW_OK;
}

static void put_note(writer *w, int loops)
{
    put(w, w->sdf ? "  <!-- The coordinates of all joints are 0 in this posture; gravity is set in the world, speeds in the program." :
        "  <!-- The coordinates of all joints are 0 in this posture; URDF holds no gravity and no speeds.");
    if (loops > 0) {
        put(w, w->sdf ? " Joints that close a loop:" : " URDF is a tree. These joints close a loop and are left out; "
            "add them in the simulator as constraints:");
        for (int j = 0, n = 0; j < w->k->n_joint; j++) {
            const lw_joint *p = &w->k->joint[j];
            char name[LW_NAME_SIZE*3];
            if (w->tree.in_tree[j])
                continue;
            snprintf(name, sizeof name, "%s (%s, %s)", p->name, w->k->link_name[p->link[0]], w->k->link_name[p->link[1]]);
            for (char *c = name; *c; c++)
                *c = *c == '-' ? '_' : *c;                     /* two of them would end the comment */
            put_name(w, n++ ? ", " : " ", name, "", " at");
            put(w, " ");
            put_number(w, p->at.x);
            put(w, " ");
            put_number(w, p->at.y);
        }
        put(w, w->sdf ? "; the physics engine must support loops." : ".");
    }
    put(w, " -->\n");
}

static bool find_owners(writer *w)
{
    const lw_assembly *k = w->k;
    return LW_OWNERS(&w->joints, k->n_link, k->joint, k->n_joint, link, 2)
        && LW_OWNERS(&w->tracers, k->n_link, k->tracer, k->n_tracer, link, 1)
        && LW_OWNERS(&w->inputs, k->n_joint, k->input, k->n_input, joint, 1)
        && (!w->m || LW_OWNERS(&w->springs, k->n_joint, w->m->joint_spring, w->m->n_joint_spring, joint, 1));
}

static void free_writer(writer *w)
{
    lw_export_tree_free(&w->tree);
    lw_owners_free(&w->joints), lw_owners_free(&w->tracers);
    lw_owners_free(&w->inputs), lw_owners_free(&w->springs);
    free(w->rod);
}

static lw_status write_robot(const lw_assembly *linkage, const lw_export_options *o, bool sdf, lw_bytes *out, lw_error *e)
{
    writer w = { .k = linkage, .m = o ? o->model : NULL, .out = out, .size = lw_export_size(linkage), .sdf = sdf };
    lw_status s = lw_assembly_check(linkage, e);
    w.weighed = lw_export_weighed(linkage, w.m);
    if (s == LW_OK)
        s = lw_export_span(linkage, w.m, &w.tree, e);
    if (s == LW_OK)
        s = check(&w, e);
    if (s == LW_OK && !(find_owners(&w) && (w.rod = malloc(((size_t)linkage->n_joint + (size_t)linkage->n_tracer + 1)*sizeof *w.rod))))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s != LW_OK) {
        free_writer(&w);
        return s;
    }
    int loops = 0;
    for (int j = 0; j < linkage->n_joint; j++)
        loops += !w.tree.in_tree[j];
    put_name(&w, sdf ? "<?xml version=\"1.0\"?>\n<sdf version=\"1.7\">\n<model name=\""
             : "<?xml version=\"1.0\"?>\n<robot name=\"",
             linkage->name[0] ? linkage->name : "linkage", "", "\">\n");
    put_note(&w, loops);
    if (!sdf)
        put_name(&w, "  <link name=\"", linkage->link_name[linkage->ground], "", "\"/>\n");
    for (int i = 0; i < linkage->n_link; i++)
        if (i != linkage->ground)
            put_link(&w, i);
    for (int i = 0; i < linkage->n_link; i++)
        if (i != linkage->ground)
            put_pair(&w, w.tree.joint[i], w.tree.parent[i], i);
    for (int j = 0; sdf && j < linkage->n_joint; j++) {
        bool turned = linkage->joint[j].link[1] == linkage->ground;
        if (!w.tree.in_tree[j])
            put_pair(&w, j, linkage->joint[j].link[turned], linkage->joint[j].link[!turned]);
    }
    put(&w, sdf ? "</model>\n</sdf>\n" : "</robot>\n");
    free_writer(&w);
    return lw_bytes_end(out, e);
}

lw_status lw_export_urdf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    return write_robot(linkage, o, false, out, e);
}

lw_status lw_export_sdf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    return write_robot(linkage, o, true, out, e);
}
