/* catalogues/pages/page_motions.c - postures of a scene as short lists of whole numbers */
#include <math.h>

#include "catalogues/pages/page_internal.h"

/* Where shapes of a link in a panel are seen from: its reference point; in the enlarged panel its
 * tracer, so that rounding an angle moves nothing visibly. */
static lw_vec2 pole(const lw_scene *s, int link, int panel)
{
    if (panel > 0)
        for (int i = 0; i < s->linkage.n_tracer; i++)
            if (s->linkage.tracer[i].link == link)
                return s->linkage.tracer[i].at;
    return s->origin[link];
}

static bool moves_in(const lw_drawing *d, int link, int panel)
{
    for (size_t i = 0; i < d->n_shape; i++)
        if (d->shape[i].link == link && d->shape[i].panel == panel)
            return true;
    return false;
}

static long tenths(double px)
{
    return lround(10*fmin(fmax(px, -1e7), 1e7));
}

static void item(lw_bytes *b, long v)
{
    lw_bytes_text(b, ",");
    lw_bytes_integer(b, v);
}

/* [link, panel, from, then per frame x, y, angle as differences]: see page.js. */
static void motion_of(lw_bytes *b, const lw_scene *s, const lw_view *v, int link, int panel)
{
    lw_vec2 p = pole(s, link, panel), from = lw_view_pixel(v, p);
    lw_bytes_text(b, "[");
    lw_bytes_integer(b, link);
    item(b, panel);
    item(b, tenths(from.x));
    item(b, tenths(from.y));
    long x = 0, y = 0, angle = 0;
    double whole = 0;                                  /* the angle so far, turns counted [rad] */
    for (size_t f = 0; f < s->n_frame; f++) {
        lw_vec2 at = lw_view_pixel(v, lw_scene_at(s, f, link, p));
        lw_vec2 turn = s->place[f*(size_t)s->linkage.n_link + (size_t)link].turn;
        whole += remainder(atan2(-turn.y, turn.x) - whole, 2*LW_PI);         /* y down on a page */
        long now[3] = { tenths(at.x), tenths(at.y), lround(10000*whole) };
        item(b, now[0] - x);
        item(b, now[1] - y);
        item(b, now[2] - angle);
        x = now[0];
        y = now[1];
        angle = now[2];
    }
    lw_bytes_text(b, "]");
}

void lw_page_motions(lw_bytes *b, const lw_scene *s, const lw_drawing *d)
{
    lw_bytes_text(b, s->loops ? "{\"loops\":true,\"first\":" : "{\"loops\":false,\"first\":");
    lw_bytes_integer(b, (long)s->first_frame);
    lw_bytes_text(b, ",\"links\":[");
    const char *comma = "";
    for (int link = 0; link < s->linkage.n_link; link++)
        for (int panel = 0; panel < d->n_view; panel++)
            if (moves_in(d, link, panel)) {
                lw_bytes_text(b, comma);
                motion_of(b, s, &d->view[panel], link, panel);
                comma = ",\n";
            }
    lw_bytes_text(b, "]}");
}
