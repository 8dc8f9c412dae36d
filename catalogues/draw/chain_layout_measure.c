/* catalogues/draw/chain_layout_measure.c - how good a picture of a chain is, in numbers */
#include <math.h>

#include "catalogues/draw/chain_layout.h"

static int outline_of(const lw_chain_layout *l, int link, lw_vec2 *p)
{
    int n = 0;
    for (int k = l->first[link]; k < l->first[link + 1]; k++)
        p[n++] = l->at[l->ring[k]];
    if (n == 1)
        p[n++] = l->end[link];
    return n;
}

/* Do a b and c d cross, no end of one on the other taken as crossing? */
static bool segments_cross(lw_vec2 a, lw_vec2 b, lw_vec2 c, lw_vec2 d)
{
    lw_vec2 u = lw_v2_sub(b, a), v = lw_v2_sub(d, c);
    double s1 = lw_v2_cross(u, lw_v2_sub(c, a)), s2 = lw_v2_cross(u, lw_v2_sub(d, a));
    double s3 = lw_v2_cross(v, lw_v2_sub(a, c)), s4 = lw_v2_cross(v, lw_v2_sub(b, c));
    return s1*s2 < 0 && s3*s4 < 0;
}

static bool inside(const lw_vec2 *p, int n, lw_vec2 q)
{
    bool in = false;
    for (int i = 0, k = n - 1; n > 2 && i < n; k = i++)
        if ((p[i].y > q.y) != (p[k].y > q.y)
            && q.x < p[i].x + (q.y - p[i].y)*(p[k].x - p[i].x)/(p[k].y - p[i].y))
            in = !in;
    return in;
}

static int sides(int n)
{
    return n > 2 ? n : n - 1;
}

/* Corners that two links share are joints (or blocks) and do not count. */
static bool same_place(lw_vec2 a, lw_vec2 b)
{
    return a.x == b.x && a.y == b.y;
}

static bool links_cross(const lw_vec2 *p, int n, const lw_vec2 *q, int k, bool itself)
{
    for (int i = 0; i < sides(n); i++)
        for (int j = 0; j < sides(k); j++) {
            lw_vec2 a = p[i], b = p[(i + 1) % n], c = q[j], d = q[(j + 1) % k];
            bool touch = same_place(a, c) || same_place(a, d) || same_place(b, c) || same_place(b, d);
            if (!touch && segments_cross(a, b, c, d))
                return true;
        }
    for (int pass = 0; pass < 2 && !itself; pass++) {
        const lw_vec2 *out = pass ? q : p, *in = pass ? p : q;
        int n_out = pass ? k : n, n_in = pass ? n : k;
        for (int i = 0; i < n_in; i++) {
            bool corner = false;
            for (int j = 0; j < n_out; j++)
                corner = corner || same_place(out[j], in[i]);
            if (!corner && inside(out, n_out, in[i]))
                return true;
        }
    }
    return false;
}

/* Least angle between a side of one link and a side of the other at a corner they share; of one link: at its own
 * corners. */
static double least_angle(const lw_vec2 *p, int n, const lw_vec2 *q, int k, bool itself)
{
    double least = LW_PI;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < k; j++) {
            if (!same_place(p[i], q[j]))
                continue;
            for (int way = 0; way < 4; way++) {
                int a = (i + (way & 1 ? 1 : n - 1)) % n, b = (j + (way & 2 ? 1 : k - 1)) % k;
                lw_vec2 u = lw_v2_sub(p[a], p[i]), v = lw_v2_sub(q[b], q[j]);
                if (itself && (a == b || n < 3))
                    continue;
                least = fmin(least, fabs(atan2(lw_v2_cross(u, v), lw_v2_dot(u, v))));
            }
        }
    return least;
}

/* Squared. */
static double least_gap2(const lw_chain_layout *l, const lw_vec2 *p, int n)
{
    double least = 1e18;
    for (int i = 0; i < sides(n); i++)
        for (int j = 0; j < l->n_joint; j++) {
            lw_vec2 a = p[i], b = p[(i + 1) % n];
            if (same_place(a, l->at[j]) || same_place(b, l->at[j]))
                continue;
            lw_vec2 off = lw_v2_off_segment(l->at[j], a, b);
            double d2 = lw_v2_dot(off, off);
            least = d2 < least ? d2 : least;
        }
    return least;
}

void lw_chain_layout_measure(const lw_mechanism *m, lw_chain_layout *l)
{
    lw_vec2 p[LW_LINK_MAX + 1], q[LW_LINK_MAX + 1];
    double length = 0;
    int n_side = 0;
    l->n_cross = 0;
    l->least_angle = LW_PI;
    l->least_gap = 1e9;
    for (int i = 0; i < m->n_link; i++) {
        int n = outline_of(l, i, p);
        if (i == m->ground || (n == 2 && same_place(p[0], p[1])))
            continue;
        for (int k = 0; k < sides(n); k++, n_side++)
            length += lw_v2_norm(lw_v2_sub(p[(k + 1) % n], p[k]));
        l->least_gap = fmin(l->least_gap, sqrt(least_gap2(l, p, n)));
        for (int k = i; k < m->n_link; k++) {
            int n_other = outline_of(l, k, q);
            if (k == m->ground || (n_other == 2 && same_place(q[0], q[1])))
                continue;
            l->n_cross += links_cross(p, n, q, n_other, k == i);
            l->least_angle = fmin(l->least_angle, least_angle(p, n, q, n_other, k == i));
        }
    }
    l->least_gap *= n_side/fmax(length, 1e-9);
}
