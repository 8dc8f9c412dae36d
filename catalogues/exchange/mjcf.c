#include "catalogues/exchange/mjcf.h"

#include <string.h>

#define DEEPEST 40                            /* greatest indentation: bodies of a chain stand inside each other */
#define STOP    10                            /* damping of stops over the critical one: nothing rebounds */
#define DRIVE   0.3                           /* angular frequency of a drive, times the step             */
#define RATIO   0.3                           /* of its damping to the critical one                       */

/* ---- text --------------------------------------------------------------------------------------- */

void lw_mjcf_tag(lw_bytes *out, int depth, const char *text)
{
    lw_bytes_text(out, "\n");
    for (int i = 0; i < depth && i < DEEPEST; i++)
        lw_bytes_text(out, "  ");
    lw_bytes_text(out, text);
}

static void begin_attribute(lw_bytes *out, const char *attribute)
{
    lw_bytes_text(out, " ");
    lw_bytes_text(out, attribute);
    lw_bytes_text(out, "=\"");
}

void lw_mjcf_numbers(lw_bytes *out, const char *attribute, const double *v, int n)
{
    begin_attribute(out, attribute);
    for (int i = 0; i < n; i++) {
        lw_bytes_text(out, i ? " " : "");
        lw_bytes_number(out, v[i], LW_MJCF_DIGITS);
    }
    lw_bytes_text(out, "\"");
}

void lw_mjcf_number(lw_bytes *out, const char *attribute, double v) { lw_mjcf_numbers(out, attribute, &v, 1); }

void lw_mjcf_vec(lw_bytes *out, const char *attribute, lw_vec3 v)
{
    lw_mjcf_numbers(out, attribute, (double[]){ v.x, v.y, v.z }, 3);
}

void lw_mjcf_name(lw_bytes *out, const char *attribute, const char *name, const char *more)
{
    begin_attribute(out, attribute);
    lw_bytes_xml(out, name);
    lw_bytes_text(out, more);
    lw_bytes_text(out, "\"");
}

void lw_mjcf_link(lw_bytes *out, const char *attribute, const char *name)
{
    lw_mjcf_name(out, attribute, name, strcmp(name, "world") == 0 ? " link" : "");
}

/* ---- bodies -------------------------------------------------------------------------------------- */

void lw_mjcf_coordinate_add(lw_mjcf_coordinate *c, double stiffness, double damping, double free)
{
    c->stiffness += stiffness;
    c->damping += damping;
    c->pull += stiffness*free;
}

void lw_mjcf_coordinate_put(lw_bytes *out, const lw_mjcf_coordinate *c)
{
    if (c->has_at)
        lw_mjcf_number(out, "ref", c->at);
    if (c->stiffness > 0) {
        lw_mjcf_number(out, "stiffness", c->stiffness);
        lw_mjcf_number(out, "springref", c->at + c->pull/c->stiffness);
    }
    if (c->damping > 0)
        lw_mjcf_number(out, "damping", c->damping);
    if (c->stop && (c->stop->has_least || c->stop->has_greatest)) {
        lw_bytes_text(out, " limited=\"true\"");
        lw_mjcf_numbers(out, "range", (double[]){ c->at + (c->stop->has_least ? c->stop->least : -1e6),
                                                  c->at + (c->stop->has_greatest ? c->stop->greatest : 1e6) }, 2);
    }
    if (c->armature > 0)
        lw_mjcf_number(out, "armature", c->armature);
}

void lw_mjcf_site(lw_bytes *out, int depth, const char *name, const char *more, lw_vec3 at, const char *attribute, const double *turn,
                  int n, double size)
{
    lw_mjcf_tag(out, depth, "<site");
    lw_mjcf_name(out, "name", name, more);
    lw_mjcf_vec(out, "pos", at);
    if (turn)
        lw_mjcf_numbers(out, attribute, turn, n);
    lw_mjcf_number(out, "size", size);
    lw_bytes_text(out, "/>");
}

/* Without recursion, since a chain may be as long as memory holds. */
void lw_mjcf_bodies(lw_bytes *out, const lw_export_tree *t, int ground, int first, lw_mjcf_begin *begin, void *context)
{
    int depth = first - 1, link = ground;
    begin(context, 1, ground);
    for (;;) {
        if (t->child[link] >= 0) {
            begin(context, ++depth, link = t->child[link]);
            continue;
        }
        for (; link != ground && t->next[link] < 0; link = t->parent[link])
            lw_mjcf_tag(out, depth--, "</body>");
        if (link == ground)
            return;
        lw_mjcf_tag(out, depth, "</body>");
        begin(context, depth, link = t->next[link]);
    }
}

/* ---- loads --------------------------------------------------------------------------------------- */

static void end_tendon(lw_bytes *out, const char *name, const char *const more[2])
{
    lw_bytes_text(out, ">");
    for (int end = 0; end < 2; end++) {
        lw_mjcf_tag(out, 3, "<site");
        lw_mjcf_name(out, "site", name, more[end]);
        lw_bytes_text(out, "/>");
    }
    lw_mjcf_tag(out, 2, "</spatial>");
}

void lw_mjcf_spring(lw_bytes *out, const char *name, double free, double stiffness, double damping, double width)
{
    lw_mjcf_tag(out, 2, "<spatial");
    lw_mjcf_name(out, "name", name, "");
    lw_mjcf_number(out, "springlength", free);
    lw_mjcf_number(out, "stiffness", stiffness);
    lw_mjcf_number(out, "damping", damping);
    lw_mjcf_number(out, "width", width);
    end_tendon(out, name, (const char *[]){ " start", " end" });
}

void lw_mjcf_rope(lw_bytes *out, const char *name, double length, double step, double width)
{
    lw_mjcf_tag(out, 2, "<spatial limited=\"true\" solimplimit=\"0.9999 0.9999 0.001\"");
    lw_mjcf_name(out, "name", name, " rope");
    lw_mjcf_numbers(out, "range", (double[]){ 0, length }, 2);
    lw_mjcf_numbers(out, "solreflimit", (double[]){ 2*step, STOP }, 2);
    lw_mjcf_number(out, "width", width);
    end_tendon(out, name, (const char *[]){ " rope start", " rope end" });
}

static void add_numbers(lw_bytes *out, const double *v, int n)
{
    for (int i = 0; i < n; i++) {
        lw_bytes_text(out, out->size > 0 ? " " : "");
        lw_bytes_number(out, v[i], LW_MJCF_DIGITS);
    }
}

void lw_mjcf_speeds(lw_mjcf_key *key, const double *v, int n) { add_numbers(&key->speeds, v, n); }

void lw_mjcf_key_free(lw_mjcf_key *key)
{
    lw_bytes_free(&key->controls);
    lw_bytes_free(&key->speeds);
}

void lw_mjcf_keyframe(lw_bytes *out, const lw_mjcf_key *key, int loads, bool moves)
{
    bool drives = key->controls.size > 0;
    moves = moves && key->speeds.size > 0;
    out->failed |= key->controls.failed || key->speeds.failed;
    if (!drives && !moves)
        return;
    lw_bytes_text(out, "\n  <keyframe>\n    <key name=\"posture\"");
    if (drives) {
        begin_attribute(out, "ctrl");
        lw_bytes_text(out, key->controls.data);
        for (int i = 0; i < loads; i++)
            lw_bytes_text(out, " 0");
        lw_bytes_text(out, "\"");
    }
    if (moves)
        lw_mjcf_name(out, "qvel", key->speeds.data, "");
    lw_bytes_text(out, "/>\n  </keyframe>");
}

void lw_mjcf_drive(lw_bytes *out, lw_mjcf_key *key, double control, double inertia, double step)
{
    double omega = DRIVE/step, stiffness = inertia*omega*omega;
    add_numbers(&key->controls, &control, 1);
    lw_mjcf_number(out, "gainprm", stiffness);
    lw_mjcf_numbers(out, "biasprm", (double[]){ 0, -stiffness, -2*RATIO*stiffness/omega }, 3);
}

void lw_mjcf_motor(lw_bytes *out, const char *name, const char *joint, double stall, double free_speed)
{
    lw_mjcf_tag(out, 2, "<general gainprm=\"0\" biastype=\"affine\"");
    lw_mjcf_name(out, "name", name, " motor");
    lw_mjcf_name(out, "joint", joint, "");
    lw_mjcf_numbers(out, "biasprm", (double[]){ stall, 0, -stall/free_speed }, 3);
    lw_bytes_text(out, "/>");
}

void lw_mjcf_force(lw_bytes *out, const char *name, bool follows, const double value[6])
{
    lw_mjcf_tag(out, 2, "<general gainprm=\"0\" biastype=\"affine\" biasprm=\"1 0 0\"");
    lw_mjcf_name(out, "name", name, " force");
    lw_mjcf_name(out, "site", name, " force");
    lw_bytes_text(out, follows ? "" : " refsite=\"axes of the world\"");
    lw_mjcf_numbers(out, "gear", value, 6);
    lw_bytes_text(out, "/>");
}

void lw_mjcf_sensor(lw_bytes *out, const char *tracer)
{
    lw_mjcf_tag(out, 2, "<framepos objtype=\"site\"");
    lw_mjcf_name(out, "objname", tracer, "");
    lw_bytes_text(out, "/>");
}

void lw_mjcf_head(lw_bytes *out, const char *name, lw_vec3 gravity, double step, double size, int rows, bool has_forces)
{
    lw_bytes_text(out, "<mujoco");
    lw_mjcf_name(out, "model", name, "");
    lw_bytes_text(out, ">\n  <!-- The controls of the drives are coordinates of their joints; those of the posture, and its speeds, are "
                       "in the keyframe. -->\n  <compiler angle=\"radian\" boundmass=\"1e-12\" boundinertia=\"1e-18\"/>"
                       "\n  <option integrator=\"RK4\"");
    lw_mjcf_vec(out, "gravity", gravity);
    lw_mjcf_number(out, "timestep", step);
    if (rows > 500) {
        lw_bytes_text(out, "/>\n  <size");
        lw_mjcf_number(out, "njmax", rows);
    }
    lw_bytes_text(out, "/>\n  <statistic");
    lw_mjcf_number(out, "extent", size);
    lw_bytes_text(out, "/>\n  <default>\n    <joint limited=\"false\"");
    lw_mjcf_numbers(out, "solreflimit", (double[]){ 2*step, STOP }, 2);
    lw_bytes_text(out, " solimplimit=\"0.9999 0.9999 0.001\"/>"
                       "\n    <geom contype=\"0\" conaffinity=\"0\" density=\"7850\" rgba=\"0.35 0.55 0.75 1\"/>"
                       "\n    <site rgba=\"0.85 0.35 0 1\"/>\n    <equality");
    lw_mjcf_numbers(out, "solref", (double[]){ 2*step, 1 }, 2);
    lw_bytes_text(out, " solimp=\"0.9999 0.9999 0.001\"/>\n  </default>\n  <worldbody>");
    if (has_forces)
        lw_bytes_text(out, "\n    <site name=\"axes of the world\" pos=\"0 0 0\" rgba=\"0 0 0 0\"/>");
}
