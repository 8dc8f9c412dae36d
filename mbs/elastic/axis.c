/* mbs/elastic/axis.c - axes, numbers of elements, nodes. */
#include "mbs/elastic/axis.h"

#include <stdlib.h>
#include "base/vec2.h"
#include "base/vector.h"

/* ---- axis ------------------------------------------------------------------------------------------- */

static const double on_line = 1e-9;              /* distance from the axis, over its length, that counts as 0 */
static const double same_place = 1e-6;           /* nodes nearer than this, over the length, are one */

/* The two of n places that are farthest apart. */
static double farthest(const lw_vec3 *at, int n, lw_vec3 end[2])
{
    double most = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            double d = lw_v3_norm(lw_v3_sub(at[i], at[j]));
            if (d > most) {
                most = d;
                end[0] = at[j];
                end[1] = at[i];
            }
        }
    return most;
}

/* Without an axis in the file: the line through the joints, or from the only joint to the farthest place, as far as places
 * lie on it. */
static lw_status default_axis(const char *name, const lw_elastic_places *p, lw_vec3 end[2], lw_error *e)
{
    lw_vec3 line[2];
    double size = farthest(p->at, p->n_joint, line);
    if (!(size > LW_ELASTIC_SHORTEST))
        size = farthest(p->at, p->n, line);
    if (!(size > LW_ELASTIC_SHORTEST))
        return lw_error_set(e, LW_E_ARG, "the elastic link \"%s\" has no length: all its joints and tracers are within %g m of one "
                            "place; put a tracer at its other end, or give its \"axis\" as a list of points", name, LW_ELASTIC_SHORTEST);
    lw_vec3 u = lw_v3_scale(lw_v3_sub(line[1], line[0]), 1/size);
    double least = 0, most = size;
    for (int i = 0; i < p->n; i++) {
        lw_vec3 d = lw_v3_sub(p->at[i], line[0]);
        bool off = lw_v3_norm(lw_v3_cross(u, d)) > on_line*size;
        if (off && i < p->n_joint)
            return lw_error_set(e, LW_E_ARG, "the joints of the elastic link \"%s\" do not lie on one line; give its \"axis\" as a "
                                "list of points: bars between them carry joints beside them on rigid arms", name);
        least = off ? least : fmin(least, lw_v3_dot(u, d));
        most = off ? most : fmax(most, lw_v3_dot(u, d));
    }
    end[0] = lw_v3_add(line[0], lw_v3_scale(u, least));
    end[1] = least == 0 && most == size ? line[1] : lw_v3_add(line[0], lw_v3_scale(u, most));
    return LW_OK;
}

/* Distance of `at` from part i of the axis; *s: that of the nearest point from the start of the part. */
static double distance(const lw_elastic_axis *a, int i, lw_vec3 at, double *s)
{
    lw_vec3 d = lw_v3_sub(a->point[i + 1], a->point[i]), to = lw_v3_sub(at, a->point[i]);
    double length = lw_v3_norm(d);
    *s = fmin(fmax(lw_v3_dot(to, d)/length, 0), length);
    return lw_v3_norm(lw_v3_sub(to, lw_v3_scale(d, *s/length)));
}

/* Distance along the axis of its point nearest to `at`. */
static double along(const lw_elastic_axis *a, lw_vec3 at)
{
    double best = INFINITY, found = 0, before = 0;
    for (int i = 0; i + 1 < a->n_point; i++) {
        double s, off = distance(a, i, at, &s);
        if (off < best) {
            best = off;
            found = before + s;
        }
        before += lw_v3_norm(lw_v3_sub(a->point[i + 1], a->point[i]));
    }
    return found;
}

/* An axis is a chain: where it comes back to itself its bars would lie one on the other without being joined. */
static lw_status check_open(const lw_elastic_axis *a, const char *name, lw_error *e)
{
    for (int k = 0; k < a->n_point; k++)
        for (int i = 0; i + 1 < a->n_point; i++) {
            double s;
            if ((k < i || k > i + 1) && distance(a, i, a->point[k], &s) <= same_place*a->length)
                return lw_error_set(e, LW_E_ARG, "the \"axis\" of the elastic link \"%s\" comes back to itself: its point %d lies on the bar from "
                                    "point %d to point %d, and would not be joined to it; divide the link there into links with joints of "
                                    "kind \"fixed\" between them", name, k + 1, i + 1, i + 2);
        }
    return LW_OK;
}

lw_vec3 lw_elastic_axis_point(const lw_elastic_axis *a, double s)
{
    for (int i = 0; i + 1 < a->n_point; i++) {
        lw_vec3 d = lw_v3_sub(a->point[i + 1], a->point[i]);
        double length = lw_v3_norm(d);
        if (s <= length || i + 2 == a->n_point)
            return s >= length ? a->point[i + 1] : lw_v3_add(a->point[i], lw_v3_scale(d, s/length));
        s -= length;
    }
    return a->point[0];
}

int lw_elastic_axis_node(const lw_elastic_axis *a, lw_vec3 at)
{
    double s = along(a, at);
    int best = 0;
    for (int i = 1; i < a->n_node; i++)
        best = fabs(a->node[i] - s) < fabs(a->node[best] - s) ? i : best;
    return best;
}

/* With q0 the mean of the density along an element of length h and -d, d what its ends have besides, the nodes get h q0/2 at h/6
 * from each, and -h d/5, h d/5 at h/12: the fixed-end forces of a slender beam, h^2 q0/12 and h^2 d/60 their moments.  The arms turn
 * with the nodes.  Shear changes the moments of d, which fall as h^3. */
int lw_elastic_line_pushes(const lw_elastic_axis *a, int i, lw_vec3 at, lw_vec3 to, bool varies, lw_elastic_push push[4])
{
    double s = along(a, at), t = along(a, to), way = lw_v3_norm(lw_v3_sub(to, at)), tiny = same_place*a->length;
    lw_vec3 off[2] = { lw_v3_sub(lw_elastic_axis_point(a, s), at), lw_v3_sub(lw_elastic_axis_point(a, t), to) };
    if (lw_v3_norm(off[0]) > tiny || lw_v3_norm(off[1]) > tiny || fabs(fabs(t - s) - way) > tiny)
        return -1;
    double from = a->node[i], end = a->node[i + 1], h = end - from, middle = 0.5*(from + end), x = (middle - s)/(t - s);
    if (middle < fmin(s, t) || middle > fmax(s, t))
        return 0;
    lw_vec3 p = lw_elastic_axis_point(a, from), along_h = lw_v3_sub(lw_elastic_axis_point(a, end), p);
    double mean = h/2/way, more = (t > s ? h/5 : -h/5)*3*h/(way*way);     /* densities are (4 - 6 x, 6 x - 2)/way of the forces */
    for (int k = 0; k < 2; k++) {
        push[k*(1 + varies)] = (lw_elastic_push){ lw_v3_add(p, lw_v3_scale(along_h, k ? 5/6. : 1/6.)),
                                                  { varies ? mean*(4 - 6*x) : 2*mean, varies ? mean*(6*x - 2) : 0 } };
        if (varies)
            push[2*k + 1] = (lw_elastic_push){ lw_v3_add(p, lw_v3_scale(along_h, k ? 11/12. : 1/12.)), { k ? -more : more, k ? more : -more } };
    }
    return varies ? 4 : 2;
}

/* ---- number of elements -------------------------------------------------------------------------------- */

/* Longest element times wave number for errors below 1 %: of a lumped chain in bending (a cantilever's first mode, whose
 * error 0.129 (wave number h)^2 is the greatest), of a consistent one, and of a lumped chain in tension. */
static const double lumped_bend = 0.277, consistent_bend = 1.2, lumped_stretch = 0.48;

/* Bending that counts: in the plane; in space, where the height has a direction, the softer one. */
static bool soft_about_y(const lw_elastic *p) { return lw_v3_norm(p->height) > 0 && p->section.iy < p->section.iz; }
static double second_moment(const lw_elastic *p) { return soft_about_y(p) ? p->section.iy : p->section.iz; }

/* Wave numbers [1/m] of bending (Timoshenko) and of stretch at the angular frequency w. */
static double wave_number(const lw_elastic *p, double w, bool bend)
{
    if (!bend)
        return w*sqrt(p->material.density/p->material.e);
    double line = p->material.density*p->section.area/(p->material.e*second_moment(p));
    double a = line*(soft_about_y(p) ? lw_section_mass_y(&p->section) : lw_section_mass_z(&p->section)),
           b = p->material.density*p->section.zeta_y/p->material.g;
    double c = 4*line/(w*w);
    return w*sqrt(0.5*(a + b + sqrt((a - b)*(a - b) + c)));
}

static double elements_for(const lw_elastic *p, double length, double frequency)
{
    double w = 2*LW_PI*frequency, bend = wave_number(p, w, true)*length, stretch = wave_number(p, w, false)*length;
    double n = p->consistent ? fmax(bend/consistent_bend, stretch/lumped_stretch)
                             : fmax(bend/lumped_bend, stretch/lumped_stretch);
    return fmax(ceil(n), 2);
}

/* ---- nodes ---------------------------------------------------------------------------------------------- */

/* Nodes at the corners of the axis and at the places; between them elements of about equal length, n in all unless places do
 * not fit that. */
static lw_status cut(lw_elastic_axis *a, const lw_elastic_places *p, int n, lw_error *e)
{
    size_t most = (size_t)(a->n_point + p->n), all = 2*most + (size_t)n + 2;
    double *hard = calloc(most + 1, sizeof *hard), sum = 0;
    a->node = calloc(all, sizeof *a->node);
    if (!hard || !a->node) {
        free(hard);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    int n_hard = 0;
    for (int i = 0; i < a->n_point; i++) {
        sum += i ? lw_v3_norm(lw_v3_sub(a->point[i], a->point[i - 1])) : 0;
        hard[n_hard++] = i + 1 == a->n_point ? a->length : sum;
    }
    for (int i = 0; i < p->n; i++)
        hard[n_hard++] = along(a, p->at[i]);
    lw_sort((size_t)n_hard, hard);
    a->node[a->n_node++] = 0;
    for (int i = 1; i < n_hard; i++) {
        double from = a->node[a->n_node - 1], gap = hard[i] - from;
        if (gap <= same_place*a->length)
            continue;
        int parts = (int)fmax(ceil(n*gap/a->length - 1e-6), 1);
        for (int k = 1; k <= parts; k++)
            a->node[a->n_node++] = k == parts ? hard[i] : from + gap*k/parts;
    }
    free(hard);
    return LW_OK;
}

lw_status lw_elastic_axis_make(const lw_elastic *p, const char *name, const lw_elastic_places *places, lw_elastic_axis *a, lw_error *e)
{
    *a = (lw_elastic_axis){ .point = p->n_axis ? p->axis : a->line, .n_point = p->n_axis ? p->n_axis : 2 };
    lw_status s = p->n_axis ? LW_OK : default_axis(name, places, a->line, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i + 1 < a->n_point; i++)
        a->length += lw_v3_norm(lw_v3_sub(a->point[i + 1], a->point[i]));
    s = check_open(a, name, e);
    if (s != LW_OK)
        return s;
    a->first = LW_PI/(2*a->length*a->length)*sqrt(p->material.e*second_moment(p)/(p->material.density*p->section.area));
    a->frequency = p->segments ? 0 : p->frequency > 0 ? p->frequency : a->first;
    double n = p->segments ? p->segments : elements_for(p, a->length, a->frequency);
    if (n > LW_ELASTIC_SEGMENTS)
        return lw_error_set(e, LW_E_ARG, "the elastic link \"%s\" would need %.3g elements to be right up to its \"frequency\" of %.9g Hz, more than %d; "
                            "its first bending "
                            "frequency with hinged ends is %.4g Hz", name, n, a->frequency, LW_ELASTIC_SEGMENTS, a->first);
    return cut(a, places, (int)n, e);
}
