#include "catalogues/pages/space_page.h"


#include "base/real.h"
#include "catalogues/draw/svg.h"
#include "catalogues/pages/page_files.h"             /* made from *.css and *.js by the Makefile */
#include "catalogues/pages/page_head.h"

static const char *const kind_name[] = { [LW_SPACE_BAR] = "bar", [LW_SPACE_PLATE] = "plate", [LW_SPACE_PIN] = "pin",
                                         [LW_SPACE_BALL] = "ball", [LW_SPACE_GUIDE] = "guide",
                                         [LW_SPACE_TRACER] = "tracer", [LW_SPACE_TIE] = "tie" };

static void number(lw_bytes *b, double v) { lw_bytes_number(b, v, 6); }

/* A place relative to the middle of the scene, in radii. */
static void put_place(lw_bytes *b, const lw_space_scene *s, lw_vec3 p)
{
    number(b, (p.x - s->middle.x)/s->radius);
    lw_bytes_text(b, ",");
    number(b, (p.y - s->middle.y)/s->radius);
    lw_bytes_text(b, ",");
    number(b, (p.z - s->middle.z)/s->radius);
}

static void put_vector(lw_bytes *b, const char *name, lw_vec3 a)
{
    lw_bytes_text(b, name);
    number(b, a.x);
    lw_bytes_text(b, ",");
    number(b, a.y);
    lw_bytes_text(b, ",");
    number(b, a.z);
    lw_bytes_text(b, "]");
}

static void put_shapes(lw_bytes *b, const lw_space_scene *s)
{
    for (int i = 0; i < s->n_shape; i++) {
        const lw_space_shape *shape = &s->shape[i];
        lw_bytes_text(b, i ? ",\n{\"kind\":\"" : "{\"kind\":\"");
        lw_bytes_text(b, kind_name[shape->kind]);
        lw_bytes_text(b, shape->grounded ? "\",\"grounded\":true,\"link\":" : "\",\"link\":");
        lw_bytes_integer(b, shape->link);
        if (shape->to >= 0) {
            lw_bytes_text(b, ",\"to\":");
            lw_bytes_integer(b, shape->to);
        }
        if (shape->tube > 0) {
            lw_bytes_text(b, ",\"tube\":");
            number(b, shape->tube/s->radius);
        }
        lw_bytes_text(b, ",\"p\":[");
        for (int k = 0; k < shape->n; k++) {
            lw_bytes_text(b, k ? "," : "");
            put_place(b, s, shape->p[k]);
        }
        lw_bytes_text(b, "]}");
    }
}

static void put_frames(lw_bytes *b, const lw_space_scene *s)
{
    for (size_t f = 0; f < s->n_frame; f++) {
        lw_bytes_text(b, f ? ",\n[" : "[");
        for (int i = 0; i < s->n_link; i++) {
            const lw_space_pose *q = &s->pose[f*(size_t)s->n_link + (size_t)i];
            double turn[] = { q->turn.w, q->turn.x, q->turn.y, q->turn.z };
            lw_bytes_text(b, i ? "," : "");
            put_place(b, s, q->at);
            for (int k = 0; k < 4; k++) {
                lw_bytes_text(b, ",");
                number(b, turn[k]);
            }
        }
        lw_bytes_text(b, "]");
    }
}

/* Write the data that space_page.js reads; lengths are in radii from the middle of the scene. */
static void put_data(lw_bytes *b, const lw_space_scene *s, lw_space_view view)
{
    lw_vec3 axis[3];
    lw_space_view_axes(s, view, axis);
    put_vector(b, "{\"up\":[", s->up);
    put_vector(b, ",\"right\":[", axis[0]);
    put_vector(b, ",\"front\":[", axis[2]);
    lw_bytes_text(b, s->loops ? ",\"loops\":true,\"seconds\":" : ",\"loops\":false,\"seconds\":");
    number(b, s->seconds);
    const lw_units *units = &s->model->units;
    lw_bytes_text(b, ",\"radius\":");
    number(b, s->radius/units->metre);
    lw_bytes_text(b, units->length[0] ? ",\"unit\":\"" : ",\"unit\":\"m");
    lw_bytes_text(b, units->length);
    lw_bytes_text(b, "\",\"origins\":[");
    for (int i = 0; i < s->n_link; i++) {
        lw_bytes_text(b, i ? "," : "");
        put_place(b, s, s->origin[i]);
    }
    lw_bytes_text(b, "],\"shapes\":[\n");
    put_shapes(b, s);
    lw_bytes_text(b, "],\"paths\":[");
    for (int t = 0; t < s->n_tracer; t++) {
        lw_bytes_text(b, t ? ",[" : "[");
        for (size_t i = 0; i < s->n_path; i++) {
            lw_bytes_text(b, i ? "," : "");
            put_place(b, s, s->path[i*(size_t)s->n_tracer + (size_t)t]);
        }
        lw_bytes_text(b, "]");
    }
    lw_bytes_text(b, "],\"frames\":[\n");
    put_frames(b, s);
    lw_bytes_text(b, "]}\n");
}

lw_status lw_space_page_write(const lw_space_scene *s, lw_space_view view, lw_bytes *out, lw_error *e)
{
    lw_bytes style = { 0 }, script = { 0 };
    lw_drawing still;
    *out = (lw_bytes){ 0 };
    lw_status status = lw_space_draw(s, 0, view, 960, 600, &still, e);
    if (status != LW_OK)
        return status;
    lw_page_style(&style, lw_page_css, lw_space_page_css);
    lw_page_script(&script, lw_space_page_js);
    lw_page_head(out, s->title, &style, &script, false);
    lw_page_text(out, "<header><h1>", s->title[0] ? s->title : "Mechanism in space", "</h1>\n");
    lw_page_text(out, "<p class=\"about\">", s->note, "</p></header>\n<main>\n");
    lw_bytes_text(out, "<figure><canvas id=\"view\" tabindex=\"0\" role=\"img\" hidden aria-label=\"The mechanism; arrow keys "
                       "turn it, plus and minus change its size, space starts and stops it\"></canvas>\n<div id=\"still\">");
    lw_svg_inline(&still, "still", out);
    lw_bytes_text(out, "</div></figure>\n<div class=\"transport\" hidden>\n"
                       "<button type=\"button\" id=\"play\">Play</button>\n"
                       "<input type=\"range\" id=\"time\" min=\"0\" step=\"any\" value=\"0\" aria-label=\"Time\"> <span id=\"clock\"></span>\n"
                       "<label>Speed <select id=\"speed\"><option>0.25</option><option>0.5</option><option selected>1</option>"
                       "<option>2</option><option>4</option></select></label>\n"
                       "<span class=\"views\"><button type=\"button\" data-view=\"home\">Home</button>\n"
                       "<button type=\"button\" data-view=\"front\">Front</button>\n"
                       "<button type=\"button\" data-view=\"side\">Side</button>\n"
                       "<button type=\"button\" data-view=\"top\">Top</button></span>\n</div>\n"
                       "<p class=\"hint\" id=\"keys\" hidden>Drag to turn, wheel or two fingers to zoom. Keys: arrows turn, + and - "
                       "zoom, space plays.</p>\n</main>\n<script type=\"application/json\" id=\"data\">\n");
    put_data(out, s, view);
    lw_bytes_text(out, "</script>\n<script>");
    lw_bytes_text(out, script.data ? script.data : "");
    lw_bytes_text(out, "</script>\n</body>\n</html>\n");
    out->failed = out->failed || style.failed || script.failed;
    lw_bytes_free(&style);
    lw_bytes_free(&script);
    lw_drawing_free(&still);
    return lw_bytes_end(out, e);
}
