/* catalogues/anatomy.c - see anatomy.h */
#include "catalogues/anatomy.h"

static bool has_pin(const lw_joint *j, int link)
{
    return (j->kind == LW_JOINT_REVOLUTE && (j->link[0] == link || j->link[1] == link))
        || (j->kind == LW_JOINT_SLOT && j->link[1] == link);
}

static bool has_tracer(const lw_linkage *k, int link)
{
    for (int i = 0; i < k->n_tracer; i++)
        if (k->tracer[i].link == link)
            return true;
    return false;
}

static double distance_from_line(const lw_joint *line, lw_vec2 p)
{
    return fabs(lw_v2_cross(line->along, lw_v2_sub(p, line->at)));
}

/* The pin of a link nearest to the line of slider j; -1 when it has none. */
static int nearest_pin(const lw_linkage *k, int link, const lw_joint *line)
{
    int best = -1;
    for (int i = 0; i < k->n_joint; i++)
        if (has_pin(&k->joint[i], link)
            && (best < 0 || distance_from_line(line, k->joint[i].at)
                            < distance_from_line(line, k->joint[best].at)))
            best = i;
    return best;
}

static double pin_distance(const lw_linkage *k, int link, const lw_joint *line)
{
    int pin = nearest_pin(k, link, line);
    return pin < 0 ? 0 : distance_from_line(line, k->joint[pin].at);
}

static int choose_guide(const lw_linkage *k, const lw_joint *j)
{
    if (j->kind == LW_JOINT_SLOT || j->link[0] == k->ground)
        return 0;
    if (j->link[1] == k->ground)
        return 1;
    double d0 = pin_distance(k, j->link[0], j), d1 = pin_distance(k, j->link[1], j);
    if (fabs(d0 - d1) > 0.02*(d0 + d1))
        return d0 < d1 ? 1 : 0;
    return has_tracer(k, j->link[1]) && !has_tracer(k, j->link[0]) ? 1 : 0;
}

static lw_vec2 foot(const lw_joint *line, lw_vec2 p)
{
    double t = lw_v2_dot(line->along, lw_v2_sub(p, line->at));
    return lw_v2_add(line->at, lw_v2_scale(line->along, t));
}

/* Where two lines meet; a's own point when they are parallel. */
static lw_vec2 crossing(const lw_joint *a, const lw_joint *b)
{
    double sine = lw_v2_cross(a->along, b->along);
    if (fabs(sine) < 1e-6)
        return a->at;
    double t = lw_v2_cross(lw_v2_sub(b->at, a->at), b->along)/sine;
    return lw_v2_add(a->at, lw_v2_scale(a->along, t));
}

static lw_vec2 block_place(const lw_linkage *k, int j, int block)
{
    const lw_joint *line = &k->joint[j];
    int pin = line->kind == LW_JOINT_SLOT ? j : nearest_pin(k, block, line);
    if (pin >= 0)
        return foot(line, k->joint[pin].at);
    for (int i = 0; i < k->n_joint; i++)
        if (i != j && k->joint[i].kind == LW_JOINT_SLIDER
            && (k->joint[i].link[0] == block || k->joint[i].link[1] == block))
            return crossing(line, &k->joint[i]);
    return line->at;
}

static void stretch(lw_slide *w, double t)
{
    w->lo = fmin(w->lo, t);
    w->hi = fmax(w->hi, t);
}

lw_slide lw_anatomy_slide(const lw_scene *s, int j)
{
    const lw_linkage *k = &s->linkage;
    const lw_joint *line = &k->joint[j];
    int g = choose_guide(k, line);
    lw_slide w = { .guide = line->link[g], .block = line->link[1 - g], .along = line->along };
    w.at = block_place(k, j, w.block);
    for (size_t f = 0; f < s->n_frame; f++) {            /* the block as the guide sees it move */
        lw_vec2 at = lw_scene_at(s, f, w.block, w.at), from = lw_scene_at(s, f, w.guide, w.at);
        lw_vec2 turn = s->place[f*(size_t)k->n_link + (size_t)w.guide].turn;
        stretch(&w, lw_v2_dot(w.along, lw_v2_unturn(lw_v2_sub(at, from), turn)));
    }
    for (int i = 0; i < k->n_joint && w.guide != k->ground; i++)
        if (has_pin(&k->joint[i], w.guide))
            stretch(&w, lw_v2_dot(w.along, lw_v2_sub(k->joint[i].at, w.at)));
    return w;
}

/* Add a node unless one is there already, within rounding of the coordinates. */
static int add_node(lw_node *node, int n, lw_vec2 at, int joint, int tracer)
{
    for (int i = 0; i < n; i++)
        if (lw_v2_norm(lw_v2_sub(node[i].at, at)) <= 1e-12*(fabs(at.x) + fabs(at.y)))
            return n;
    if (n == LW_NODE_MAX)
        return n;
    node[n] = (lw_node){ at, joint, tracer };
    return n + 1;
}

int lw_anatomy_nodes(const lw_scene *s, int link, lw_node node[LW_NODE_MAX])
{
    const lw_linkage *k = &s->linkage;
    int n = 0;
    for (int i = 0; i < k->n_joint; i++)
        if (has_pin(&k->joint[i], link))
            n = add_node(node, n, k->joint[i].at, i, -1);
    int n_pin = n;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *line = &k->joint[j];
        if ((line->kind != LW_JOINT_SLIDER && line->kind != LW_JOINT_SLOT)
            || (line->link[0] != link && line->link[1] != link))
            continue;
        lw_slide w = lw_anatomy_slide(s, j);
        if (w.block == link)
            n = add_node(node, n, w.at, -1, -1);
        else
            for (int i = 0; i < n_pin; i++)
                n = add_node(node, n, foot(line, node[i].at), -1, -1);
    }
    for (int i = 0; i < k->n_tracer; i++)
        if (k->tracer[i].link == link)
            n = add_node(node, n, k->tracer[i].at, -1, i);
    return n;
}
