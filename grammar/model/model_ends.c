/* grammar/model/model_ends.c - places, and what acts between two of them: springs and cylinders. */
#include "grammar/model/model_internal.h"

lw_status lw_read_place(const lw_json_node *n, double metre, bool spatial, lw_vec3 *out, lw_error *e)
{
    lw_vec2 flat = { 0, 0 };
    if (spatial)
        return lw_read_triple(n, metre, out, e);
    lw_status s = lw_read_pair(n, metre, &flat, e);
    *out = lw_v3(flat.x, flat.y, 0);
    return s;
}

double lw_read_drawn_length(const lw_reading *r, const lw_spring *p)
{
    lw_vec3 d = lw_v3_sub(p->at[1], p->at[0]);
    return r->spatial ? lw_v3_norm(d) : lw_v2_norm(lw_v3_xy(d));
}

lw_status lw_read_ends(const lw_json_node *object, const lw_reading *r, lw_error *e)
{
    lw_spring *p = &(*r->spring)[(*r->n_spring)++];
    lw_json_node links, at;
    lw_status s = lw_read_need(object, "links", &links, e);
    if (s == LW_OK && (s = lw_read_list(&links, 2, 2, e)) == LW_OK && (s = lw_read_need(object, "at", &at, e)) == LW_OK)
        s = lw_read_list(&at, 2, 2, e);
    for (size_t end = 0; s == LW_OK && end < 2; end++) {
        lw_json_node link = lw_json_element(&links, end), point = lw_json_element(&at, end);
        s = r->link(&link, r->model, &p->link[end], e);
        if (s == LW_OK)
            s = lw_read_place(&point, r->units->metre, r->spatial, &p->at[end], e);
        if (s == LW_OK && end && p->link[0] == p->link[1])
            s = lw_json_fault(&links, e, "both ends are on link \"%s\": nothing between them can move", lw_json_text(&link));
    }
    p->free = lw_read_drawn_length(r, p);
    return s;
}

int lw_read_find_spring(const lw_reading *r, lw_json *json, const char *name, char *why)
{
    return lw_read_find_or_say(json, "spring or cylinder between two points", name, LW_NAMES(*r->spring, *r->n_spring, lw_spring), why);
}
