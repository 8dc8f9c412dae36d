/* catalogues/draw/labels.c - see labels.h */
#include "catalogues/draw/labels.h"

#include <stdlib.h>

#include "base/real.h"
#include "catalogues/draw/drawing.h"

#define CELL 4.0                        /* [px]: finer than the letters, coarse enough to be fast */

lw_status lw_label_map_make(lw_label_map *m, double width, double height, lw_error *e)
{
    *m = (lw_label_map){ .columns = (int)ceil(width/CELL), .rows = (int)ceil(height/CELL) };
    m->ink = calloc((size_t)(m->columns + 1)*(size_t)(m->rows + 1), sizeof *m->ink);
    return m->ink ? LW_OK : lw_error_set(e, LW_E_MEMORY, "not enough memory to place labels");
}

void lw_label_map_free(lw_label_map *m)
{
    free(m->ink);
    m->ink = NULL;
}

static double *cell(const lw_label_map *m, int column, int row)
{
    return &m->ink[(size_t)row*(size_t)(m->columns + 1) + (size_t)column];
}

static void add_ink(lw_label_map *m, double x, double y, double weight)
{
    double column = floor(x/CELL), row = floor(y/CELL);
    if (column >= 0 && column < m->columns && row >= 0 && row < m->rows)
        *cell(m, (int)column + 1, (int)row + 1) += weight;
}

void lw_label_map_line(lw_label_map *m, lw_vec2 a, lw_vec2 b, double weight)
{
    lw_vec2 d = lw_v2_sub(b, a);
    double length = lw_v2_norm(d), limit = 8*CELL*(m->columns + m->rows);
    if (!(length <= limit))
        return;                                        /* far outside the page; callers clip what they draw */
    int n = (int)ceil(length/CELL) + 1;
    for (int i = 0; i <= n; i++)
        add_ink(m, a.x + d.x*i/n, a.y + d.y*i/n, weight);
}

void lw_label_map_disc(lw_label_map *m, lw_vec2 at, double radius, double weight)
{
    for (double y = -radius; y <= radius; y += CELL)
        for (double x = -radius; x <= radius; x += CELL)
            if (x*x + y*y <= radius*radius)
                add_ink(m, at.x + x, at.y + y, weight);
}

void lw_label_map_take(lw_label_map *m, lw_box box)
{
    if (m->n_taken < LW_LABEL_MAX)
        m->taken[m->n_taken++] = box;
}

/* Turn the amounts into sums over all cells above and to the left. */
static void sum_up(lw_label_map *m)
{
    for (int row = 1; row <= m->rows; row++)
        for (int column = 1; column <= m->columns; column++)
            *cell(m, column, row) += *cell(m, column - 1, row) + *cell(m, column, row - 1)
                                   - *cell(m, column - 1, row - 1);
    m->summed = true;
}

static int clamp_cell(double v, int most)
{
    return v > most ? most : v > 0 ? (int)v : 0;              /* 0 for NaN too */
}

static double ink_below(const lw_label_map *m, lw_box b)
{
    int x0 = clamp_cell(floor(b.x0/CELL), m->columns), x1 = clamp_cell(ceil(b.x1/CELL), m->columns);
    int y0 = clamp_cell(floor(b.y0/CELL), m->rows), y1 = clamp_cell(ceil(b.y1/CELL), m->rows);
    return *cell(m, x1, y1) - *cell(m, x0, y1) - *cell(m, x1, y0) + *cell(m, x0, y0);
}

static bool is_free(const lw_label_map *m, lw_box b, lw_box within)
{
    if (!(b.x0 >= within.x0 && b.y0 >= within.y0 && b.x1 <= within.x1 && b.y1 <= within.y1))
        return false;
    for (int i = 0; i < m->n_taken; i++) {
        const lw_box *t = &m->taken[i];
        if (b.x0 < t->x1 && t->x0 < b.x1 && b.y0 < t->y1 && t->y0 < b.y1)
            return false;
    }
    return true;
}

/* Box of half sizes (w, h) beside `from` in direction u, its nearest side `gap` away. */
static lw_box beside(lw_vec2 from, lw_vec2 u, double gap, double w, double h)
{
    double reach = fmin(w/fmax(fabs(u.x), 1e-9), h/fmax(fabs(u.y), 1e-9));
    lw_vec2 c = lw_v2_add(from, lw_v2_scale(u, gap + reach));
    return (lw_box){ c.x - w, c.y - h, c.x + w, c.y + h };
}

bool lw_label_map_place(lw_label_map *m, const char *text, double size, lw_vec2 a, lw_vec2 b, double gap, lw_box within, lw_vec2 *at)
{
    if (m->n_taken == LW_LABEL_MAX)                      /* others would not know of it */
        return false;
    enum { DIRECTIONS = 16, RINGS = 6 };
    static const double along[] = { 0.5, 0.38, 0.62, 0.25, 0.75 };
    bool point = a.x == b.x && a.y == b.y;
    double w = lw_text_width(text, size)/2 + 2, h = 0.6*size + 1, best = INFINITY;
    lw_box place = { 0 };
    if (!m->summed)
        sum_up(m);
    for (int t = 0; t < (point ? 1 : 5); t++)
        for (int ring = 0; ring < RINGS; ring++)
            for (int i = 0; i < DIRECTIONS; i++) {
                lw_vec2 from = lw_v2_add(a, lw_v2_scale(lw_v2_sub(b, a), along[t]));
                lw_vec2 u = lw_v2_polar(1, 2*LW_PI*(i + 0.5)/DIRECTIONS);
                lw_box box = beside(from, u, gap*(1 + 0.9*ring), w, h);
                double cost = 6*ink_below(m, box) + 2.5*ring + 0.3*t + (u.y > 0 ? 0.2 : 0);
                if (cost < best && is_free(m, box, within)) {
                    best = cost;
                    place = box;
                }
            }
    if (!isfinite(best))
        return false;
    lw_label_map_take(m, place);
    *at = lw_v2(place.x0 + 2, place.y1 - 0.32*size - 1);
    return true;
}
