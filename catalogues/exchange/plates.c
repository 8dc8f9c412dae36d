#include "catalogues/exchange/plates.h"
#include "base/real.h"

#include <stdio.h>
#include <stdlib.h>

#define MM  1000.0
#define GAP 0.1                            /* between layers, of the thickness                         */

/* Room for the loops of any one plate. */
static lw_status allocate(lw_plates *w)
{
    int holes = 0, corners = 1;
    for (int i = 0; i < w->scene.linkage.n_link; i++) {
        const lw_plate *p = &w->layers.plate[i];
        holes = p->n_hole > holes ? p->n_hole : holes;
        corners = p->n_corner > corners ? p->n_corner : corners;
    }
    w->side = malloc(2*((size_t)corners + 2*(size_t)holes)*sizeof *w->side);
    w->hole = malloc(((size_t)holes + 1)*sizeof *w->hole);
    return w->side && w->hole ? LW_OK : LW_E_MEMORY;
}

lw_status lw_plates_make(const lw_assembly *linkage, const lw_export_options *o, lw_plates **out, lw_error *e)
{
    lw_plates *w = calloc(1, sizeof *w);
    lw_plate_size size = { o ? o->width/2 : 0, o ? o->hole/2 : 0, o ? o->thickness : 0, o ? o->clearance : -1 };
    if (!w)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for plates");
    lw_status s = lw_scene_make_any(linkage, o ? o->model : NULL, NULL, &(lw_scene_options){ .n_frame = LW_PLATES_FRAMES, .stop = o ? o->stop : NULL },
                                    &w->scene, e);
    w->scene.model = o ? o->model : NULL;                      /* layers make more postures of it */
    if (s == LW_OK)
        s = lw_layers_find(&w->scene, &size, &w->layers, e);
    if (s == LW_OK && allocate(w) != LW_OK)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory for plates");
    if (s == LW_OK)
        *out = w;
    else
        lw_plates_free(w);
    return s;
}

void lw_plates_free(lw_plates *w)
{
    lw_scene_free(&w->scene);
    lw_layers_free(&w->layers);
    free(w->side), free(w->hole);
    free(w);
}

lw_status lw_plates_check_holes(const lw_plates *w, lw_error *e)
{
    for (int i = 0; i < w->scene.linkage.n_link; i++) {
        const lw_plate *p = &w->layers.plate[i];
        for (int a = 0; a < p->n_hole; a++)
            for (int b = 0; b < a; b++) {
                lw_vec2 ends[2][2] = { { p->hole[a].a, p->hole[a].b }, { p->hole[b].a, p->hole[b].b } };
                int n[2] = { lw_v2_norm(lw_v2_sub(ends[0][0], ends[0][1])) > 0 ? 2 : 1,
                             lw_v2_norm(lw_v2_sub(ends[1][0], ends[1][1])) > 0 ? 2 : 1 };
                if (lw_hull_distance(ends[0], n[0], ends[1], n[1]) <= 2*w->layers.bore)
                    return lw_error_set(e, LW_E_KIND, "two holes or slots of link '%s' meet; solids need them apart, "
                                        "so choose smaller holes, or export dxf or scad", w->scene.linkage.link_name[i]);
            }
    }
    return LW_OK;
}

void lw_plates_room(const lw_plates *w, char *text, size_t size)
{
    char room[32];
    lw_number_text(room, MM*w->layers.room, 3);
    int n = snprintf(text, size, isfinite(w->layers.room) ? "in each layer at least %s mm are free over the whole motion"
                     : "in no layer anything passes anything", room);
    if (!w->layers.fewest && n < (int)size)
        snprintf(text + n, size - (size_t)n, "; fewer layers may do");
}

void lw_loop_widen(const lw_vec2 *p, int n, double r, lw_plate_side *side, lw_plate_loop *loop)
{
    loop->side = side;
    loop->n = 0;
    loop->radius = r;
    if (n == 1) {
        loop->side[loop->n++] = (lw_plate_side){ lw_v2_add(p[0], lw_v2(r, 0)), p[0], true };
        return;
    }
    for (int i = 0; i < n; i++) {
        lw_vec2 a = p[i], b = p[(i + 1) % n], d = lw_v2_sub(b, a);
        lw_vec2 off = lw_v2_scale(lw_v2_perp(d), -r/lw_v2_norm(d));
        loop->side[loop->n++] = (lw_plate_side){ lw_v2_add(a, off), { 0, 0 }, false };
        loop->side[loop->n++] = (lw_plate_side){ lw_v2_add(b, off), b, true };
    }
}

int lw_plates_count(const lw_plates *w) { return w->scene.linkage.n_link + w->layers.n_pin; }

void lw_plates_slab(lw_plates *w, int i, lw_slab *s)
{
    const lw_layers *l = &w->layers;
    double floor = (1 + GAP)*l->thickness;
    int n_link = w->scene.linkage.n_link;
    lw_plate_side *side = w->side;
    s->n_hole = 0;
    s->hole = w->hole;
    if (i >= n_link) {
        const lw_pin *p = &l->pin[i - n_link];
        snprintf(s->name, sizeof s->name, "pin %d", i - n_link + 1);
        s->low = p->low*floor;
        s->high = p->high*floor + l->thickness;
        lw_loop_widen(&p->at, 1, l->pin_radius, side, &s->outline);
        return;
    }
    const lw_plate *p = &l->plate[i];
    snprintf(s->name, sizeof s->name, "%s", w->scene.linkage.link_name[i]);
    s->low = l->layer[i]*floor;
    s->high = s->low + l->thickness;
    lw_loop_widen(p->corner, p->n_corner, l->radius, side, &s->outline);
    side += s->outline.n;
    for (int h = 0; h < p->n_hole; h++) {
        const lw_vec2 ends[2] = { p->hole[h].a, p->hole[h].b };
        bool round = lw_v2_norm(lw_v2_sub(ends[1], ends[0])) < 1e-9*l->radius;
        lw_loop_widen(ends, round ? 1 : 2, l->bore, side, &s->hole[s->n_hole]);
        side += s->hole[s->n_hole++].n;
    }
}
