/* catalogues/exchange/export_motion.c - write the motion of a linkage as numbers: poses, curves, joints. */
#include <string.h>

#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/draw/scene.h"

#define DIGITS 12

static lw_status make(const lw_assembly *linkage, const lw_export_options *given, lw_scene *s, lw_error *e)
{
    lw_scene_options o = { .n_frame = LW_EXPORT_FRAMES, .n_curve_point = 360 };
    lw_status st = lw_scene_make_any(linkage, given ? given->model : NULL, NULL, &o, s, e);
    if (st != LW_OK || s->n_frame > 1)
        return st;
    char note[sizeof s->note];
    memcpy(note, s->note, sizeof note);
    lw_scene_free(s);
    return lw_error_set(e, LW_E_KIND, "the motion is not known. %s", note);
}

static void put_number(lw_bytes *out, const char *before, double v)
{
    lw_bytes_text(out, before);
    lw_bytes_number(out, v, DIGITS);
}

/* ---- CSV -------------------------------------------------------------------------------------------------- */

/* Write a field, quoted where CSV demands it. */
static void put_field(lw_bytes *out, const char *text)
{
    if (!strpbrk(text, ",\"\n\r")) {
        lw_bytes_text(out, text);
        return;
    }
    lw_bytes_text(out, "\"");
    for (const char *c = text; *c; c++)
        lw_bytes_text(out, (char[3]){ *c, *c == '"' ? '"' : 0, 0 });
    lw_bytes_text(out, "\"");
}

lw_status lw_export_poses(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_scene s;
    lw_status st = make(linkage, o, &s, e);
    if (st != LW_OK)
        return st;
    double metre = linkage->units.metre, radian = linkage->units.radian;
    bool slider = lw_joint_slides(linkage->joint[linkage->input[0].joint].kind);
    lw_bytes_text(out, "# units: ");
    lw_bytes_text(out, linkage->units.length[0] ? linkage->units.length : "m");
    lw_bytes_text(out, " ");
    lw_bytes_text(out, linkage->units.angle);
    lw_bytes_text(out, "\nframe,input,link,x,y,turn\n");
    for (size_t f = 0; f < s.n_frame; f++)
        for (int link = 0; link < linkage->n_link; link++) {
            const lw_place *p = &s.place[f*(size_t)linkage->n_link + (size_t)link];
            double input = linkage->input[0].value + s.input[f] - s.input[s.first_frame];
            lw_bytes_integer(out, (long)f);
            put_number(out, ",", input/(slider ? metre : radian));
            lw_bytes_text(out, ",");
            put_field(out, linkage->link_name[link]);
            put_number(out, ",", p->at.x/metre);
            put_number(out, ",", p->at.y/metre);
            put_number(out, ",", atan2(p->turn.y, p->turn.x)/radian);
            lw_bytes_text(out, "\n");
        }
    lw_scene_free(&s);
    return lw_bytes_end(out, e);
}

/* ---- SVG --------------------------------------------------------------------------------------------------- */

static void put_path(lw_bytes *out, const lw_curve *c, const char *name)
{
    bool pen = false;
    lw_bytes_text(out, "  <path data-tracer=\"");
    lw_bytes_xml(out, name);
    lw_bytes_text(out, "\" d=\"");
    for (size_t i = 0; i < c->n; i++) {
        if (!isfinite(c->p[i].x) || !isfinite(c->p[i].y)) {
            pen = false;
            continue;
        }
        put_number(out, pen ? " L" : i ? " M" : "M", 1000*c->p[i].x);
        put_number(out, ",", -1000*c->p[i].y);
        pen = true;
    }
    lw_bytes_text(out, c->closed ? " Z\"/>\n" : "\"/>\n");
}

static void grow_box(const lw_scene *s, lw_vec2 *lo, lw_vec2 *hi)
{
    *lo = lw_v2(INFINITY, INFINITY);
    *hi = lw_v2(-INFINITY, -INFINITY);
    for (int i = 0; i < s->n_curve; i++)
        for (size_t n = 0; s->curve[i].shown_branch && n < s->curve[i].n; n++) {
            lw_vec2 p = lw_v2(1000*s->curve[i].p[n].x, -1000*s->curve[i].p[n].y);
            if (isfinite(p.x) && isfinite(p.y)) {
                *lo = lw_v2(fmin(lo->x, p.x), fmin(lo->y, p.y));
                *hi = lw_v2(fmax(hi->x, p.x), fmax(hi->y, p.y));
            }
        }
    double edge = 0.05*fmax(hi->x - lo->x, hi->y - lo->y) + 1e-6;
    *lo = lw_v2_sub(*lo, lw_v2(edge, edge));
    *hi = lw_v2_add(*hi, lw_v2(edge, edge));
}

lw_status lw_export_svg(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_scene s;
    lw_vec2 lo, hi;
    if (linkage->n_tracer == 0)
        return lw_error_set(e, LW_E_KIND, "the linkage has no tracer, whose curve could be drawn");
    lw_status st = make(linkage, o, &s, e);
    if (st != LW_OK)
        return st;
    grow_box(&s, &lo, &hi);
    lw_bytes_text(out, "<svg xmlns=\"http://www.w3.org/2000/svg\"");
    put_number(out, " width=\"", hi.x - lo.x);
    put_number(out, "mm\" height=\"", hi.y - lo.y);
    put_number(out, "mm\" viewBox=\"", lo.x);
    put_number(out, " ", lo.y);
    put_number(out, " ", hi.x - lo.x);
    put_number(out, " ", hi.y - lo.y);
    put_number(out, "\" fill=\"none\" stroke=\"black\" stroke-width=\"", 0.004*(hi.x - lo.x + hi.y - lo.y));
    lw_bytes_text(out, "\">\n");
    for (int i = 0; i < s.n_curve; i++)
        if (s.curve[i].shown_branch)
            put_path(out, &s.curve[i], linkage->tracer[s.curve[i].tracer].name);
    lw_bytes_text(out, "</svg>\n");
    lw_scene_free(&s);
    return lw_bytes_end(out, e);
}

/* ---- JSON --------------------------------------------------------------------------------------------------- */

static void put_string(lw_bytes *out, const char *text)
{
    char clean[4*LW_NAME_SIZE + 64];
    lw_text_clean(clean, sizeof clean, text);
    lw_bytes_text(out, "\"");
    for (const char *c = clean; *c; c++)
        if (*c == '"' || *c == '\\')
            lw_bytes_text(out, (char[3]){ '\\', *c, 0 });
        else if ((unsigned char)*c < ' ')
            lw_bytes_text(out, " ");
        else
            lw_bytes_add(out, c, 1);
    lw_bytes_text(out, "\"");
}

static void put_pair(lw_bytes *out, lw_vec2 p, double unit)
{
    put_number(out, "[", p.x/unit);
    put_number(out, ", ", p.y/unit);
    lw_bytes_text(out, "]");
}

static void put_joints(const lw_assembly *linkage, lw_bytes *out)
{
    for (int j = 0; j < linkage->n_joint; j++) {
        const lw_joint *p = &linkage->joint[j];
        lw_bytes_text(out, j ? ",\n    {\"id\": " : "\n    {\"id\": ");
        lw_bytes_integer(out, j);
        lw_bytes_text(out, ", \"name\": ");
        put_string(out, p->name);
        lw_bytes_text(out, ", \"type\": \"");
        lw_bytes_text(out, lw_joint_word(p->kind));
        lw_bytes_text(out, "\", \"coord\": ");
        put_pair(out, p->at, linkage->units.metre);
        if (lw_joint_slides(p->kind))
            put_number(out, ", \"angle\": ", atan2(p->along.y, p->along.x)/linkage->units.radian);
        if (lw_joint_has_ratio(p->kind))
            put_number(out, ", \"ratio\": ", p->ratio);
        lw_bytes_text(out, p->link[0] == linkage->ground || p->link[1] == linkage->ground ? ", \"ground\": true}" : ", \"ground\": false}");
    }
}

static void put_links(const lw_assembly *linkage, lw_bytes *out)
{
    for (int link = 0; link < linkage->n_link; link++) {
        bool first = true;
        lw_bytes_text(out, link ? ",\n    {\"name\": " : "\n    {\"name\": ");
        put_string(out, linkage->link_name[link]);
        lw_bytes_text(out, link == linkage->ground ? ", \"ground\": true, \"joints\": [" : ", \"ground\": false, \"joints\": [");
        for (int j = 0; j < linkage->n_joint; j++)
            if (linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link) {
                lw_bytes_text(out, first ? "" : ", ");
                lw_bytes_integer(out, j);
                first = false;
            }
        lw_bytes_text(out, "]}");
    }
}

/* Write the points of a curve; null marks a break between two parts. */
static void put_curve(const lw_curve *c, double unit, lw_bytes *out)
{
    lw_bytes_text(out, ", \"closed\": ");
    lw_bytes_text(out, c->closed ? "true, \"curve\": [" : "false, \"curve\": [");
    for (size_t i = 0; i < c->n; i++) {
        lw_bytes_text(out, i ? ", " : "");
        if (isfinite(c->p[i].x) && isfinite(c->p[i].y))
            put_pair(out, c->p[i], unit);
        else
            lw_bytes_text(out, "null");
    }
    lw_bytes_text(out, "]");
}

static void put_tracers(const lw_scene *s, lw_bytes *out)
{
    const lw_assembly *k = &s->linkage;
    for (int t = 0; t < k->n_tracer; t++) {
        lw_bytes_text(out, t ? ",\n    {\"name\": " : "\n    {\"name\": ");
        put_string(out, k->tracer[t].name);
        lw_bytes_text(out, ", \"link\": ");
        put_string(out, k->link_name[k->tracer[t].link]);
        lw_bytes_text(out, ", \"coord\": ");
        put_pair(out, k->tracer[t].at, k->units.metre);
        for (int i = 0; i < s->n_curve; i++)
            if (s->curve[i].tracer == t && s->curve[i].shown_branch) {
                put_curve(&s->curve[i], k->units.metre, out);
                break;
            }
        lw_bytes_text(out, "}");
    }
}

lw_status lw_export_joints(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_scene s;
    lw_status st = make(linkage, o, &s, e);
    if (st != LW_OK)
        return st;
    lw_bytes_text(out, "{\n  \"name\": ");
    put_string(out, linkage->name);
    lw_bytes_text(out, ",\n  \"units\": {\"length\": ");
    put_string(out, linkage->units.length[0] ? linkage->units.length : "m");
    lw_bytes_text(out, ", \"angle\": ");
    put_string(out, linkage->units.angle);
    lw_bytes_text(out, "},\n  \"joints\": [");
    put_joints(linkage, out);
    lw_bytes_text(out, "\n  ],\n  \"links\": [");
    put_links(linkage, out);
    lw_bytes_text(out, "\n  ],\n  \"actuators\": [");
    for (int i = 0; i < linkage->n_input; i++) {
        lw_bytes_text(out, i ? ", " : "");
        lw_bytes_integer(out, linkage->input[i].joint);
    }
    lw_bytes_text(out, "],\n  \"couplerPoints\": [");
    put_tracers(&s, out);
    lw_bytes_text(out, "\n  ]\n}\n");
    lw_scene_free(&s);
    return lw_bytes_end(out, e);
}
