/* catalogues/draw/plot.c - see plot.h */
#include "catalogues/draw/plot.h"

#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "base/real.h"

#define LETTER   12.0           /* size of the letters [px] */
#define TICK_MAX 64
#define TICKS_APART 70.0      /* about [px] */
#define ROUNDING 1e-13          /* |y| up to here, all over a linear axis, is drawn as zero     */
#define ROW      18.0           /* height of a row of the legend [px] */

typedef struct lw_axis {
    bool   logarithmic, degrees;
    double lo, hi;                  /* range of the numbers, or of their logarithms                */
    double from, to;                /* places of lo and hi on the page [px]                        */
    int    n_tick, digits;          /* digits: enough that neighbouring ticks read differently    */
    double tick[TICK_MAX];          /* numbers, not logarithms                                     */
} lw_axis;

typedef struct lw_chart {
    const lw_plot *p;
    lw_drawing *d;
    double  begin, width, top, height, legend;      /* its part of the page; where legends begin   [px] */
    lw_axis x, y;
    double  rounding;               /* greatest |y| where all of them are rounding, else 0         */
} lw_chart;

static bool fits(const lw_axis *a, double v)
{
    return isfinite(v) && (!a->logarithmic || v > 0);
}

static double measure(const lw_axis *a, double v)
{
    return a->logarithmic ? log10(v) : v;
}

static double place(const lw_axis *a, double v)
{
    return a->from + (a->to - a->from)*((measure(a, v) - a->lo)/(a->hi - a->lo));
}

static void include(lw_axis *a, double v)
{
    a->lo = fmin(a->lo, measure(a, v));
    a->hi = fmax(a->hi, measure(a, v));
}

static void add_tick(lw_axis *a, double v)
{
    double m = measure(a, v), slack = 1e-9*(a->hi - a->lo);
    if (a->n_tick < TICK_MAX && m >= a->lo - slack && m <= a->hi + slack)
        a->tick[a->n_tick++] = v;
}

/* Ticks in steps of 1, 2 or 5 times a power of ten, about n of them; of degrees in parts of a turn where they are many. */
static void even_ticks(lw_axis *a, double n)
{
    static const double of_turn[] = { 15, 30, 45, 60, 90, 180, 360 };
    double rough = (a->hi - a->lo)/n, power = pow(10, floor(log10(rough))), m = rough/power;
    double step = power*(m <= 1 ? 1 : m <= 2 ? 2 : m <= 5 ? 5 : 10);
    for (int i = 6; a->degrees && rough > 10 && i >= 0; i--)
        step = of_turn[i] >= rough ? of_turn[i] : step;
    a->digits = (int)fmin(fmax(2 + ceil(log10(fmax(fabs(a->lo), fabs(a->hi))/step)), 1), 17);
    for (double i = ceil(a->lo/step - 1e-9); i*step <= a->hi + 1e-9*step && a->n_tick < TICK_MAX; i++)
        add_tick(a, i*step);
}

/* About n ticks: at whole decades, or every k-th if there are many and two of these are in the range; at 1, 2, 5 within a few decades if there is
 * room; at 1, 3 where there is only one whole decade. */
static void decade_ticks(lw_axis *a, double n)
{
    int step = (int)fmax(1, ceil((a->hi - a->lo)/n)), first = (int)floor(a->lo), last = (int)ceil(a->hi);
    a->digits = 1;
    bool room = a->hi - a->lo < fmin(2.2, 0.4*n);
    for (bool fine = room, again = true; again; fine = step == 1, step = 1) {
        a->n_tick = 0;
        for (int k = first; k <= last; k++)
            for (int digit = 1; digit <= 5; digit += digit > 1 ? 3 : room ? 1 : 2)
                if ((digit == 1 && (k - first) % step == 0) || fine)
                    add_tick(a, digit*pow(10, k));
        again = a->n_tick < 2 && !fine;
    }
}

/* Widen an empty range and choose ticks. */
static void settle(lw_axis *a, double n_tick)
{
    double middle = (a->lo + a->hi)/2, least = a->logarithmic ? 0.35 : fmax(1e-12*fabs(middle), 1e-300);
    if (a->hi - a->lo < least) {
        double half = a->logarithmic ? 0.5 : middle != 0 ? 0.5*fabs(middle) : 1;
        a->lo = middle - half;
        a->hi = middle + half;
    }
    double air = 0.03*(a->hi - a->lo);
    a->lo -= air;
    a->hi += air;
    if (a->logarithmic)
        decade_ticks(a, n_tick);
    else
        even_ticks(a, n_tick);
}

/* Find the ranges of both axes. False: no point of any series can be shown. */
static bool find_ranges(lw_chart *c)
{
    bool any = false;
    c->x = (lw_axis){ .logarithmic = c->p->log_x, .degrees = c->p->x_label && strstr(c->p->x_label, "[deg]"), .lo = INFINITY, .hi = -INFINITY };
    c->y = (lw_axis){ .logarithmic = c->p->log_y, .degrees = c->p->y_label && strstr(c->p->y_label, "[deg]"), .lo = INFINITY, .hi = -INFINITY };
    for (int i = 0; i < c->p->n_series; i++) {
        const lw_series *s = &c->p->series[i];
        for (size_t k = 0; k < s->n; k++)
            if (fits(&c->x, s->x[k]) && fits(&c->y, s->y[k])) {
                include(&c->x, s->x[k]);
                include(&c->y, s->y[k]);
                any = true;
            }
    }
    for (int i = 0; any && i < c->p->n_level; i++)
        if (fits(&c->y, c->p->level[i].y))
            include(&c->y, c->p->level[i].y);
    double most = fmax(fabs(c->y.lo), fabs(c->y.hi));
    c->rounding = any && !c->p->log_y && most > 0 && most <= ROUNDING ? most : 0;
    if (c->rounding > 0)
        c->y.lo = -1, c->y.hi = 1;
    return any;
}

static lw_shape *text(lw_chart *c, lw_role role, const char *t, double x, double y, double align)
{
    return lw_drawing_text(c->d, role, t, lw_v2(x, y), LETTER, align);
}

static void rule(lw_chart *c, lw_role role, lw_vec2 a, lw_vec2 b, lw_ink ink, double width)
{
    lw_shape *s = lw_drawing_line(c->d, role, a, b);
    s->stroke = ink;
    s->width = width;
}

static void draw_axes(lw_chart *c)
{
    const lw_axis *x = &c->x, *y = &c->y;
    char t[32];
    for (int i = 0; i < x->n_tick; i++) {
        double at = place(x, x->tick[i]);
        lw_number_text(t, x->tick[i], x->digits);
        rule(c, LW_ROLE_GRID, lw_v2(at, y->from), lw_v2(at, y->to), LW_INK_GRID, 1);
        text(c, LW_ROLE_TICK, t, at, y->from + 17, 0.5)->item = i;
    }
    for (int i = 0; i < y->n_tick; i++) {
        double at = place(y, y->tick[i]);
        lw_number_text(t, y->tick[i], y->digits);
        rule(c, LW_ROLE_GRID, lw_v2(x->from, at), lw_v2(x->to, at), LW_INK_GRID, 1);
        text(c, LW_ROLE_TICK, t, x->from - 7, at + 4, 1)->item = i;
    }
    lw_vec2 corner[3] = { { x->from, y->to }, { x->from, y->from }, { x->to, y->from } };
    lw_shape *s = lw_drawing_path(c->d, LW_ROLE_AXIS, corner, 3, false);
    s->stroke = LW_INK_TEXT;
    s->width = 1.4;
    double middle = (y->from + y->to)/2;
    if (c->p->x_label)
        text(c, LW_ROLE_AXIS, c->p->x_label, (x->from + x->to)/2, y->from + 38, 0.5);
    if (c->p->y_label)
        text(c, LW_ROLE_AXIS, c->p->y_label, c->begin + 20, middle, 0.5)->turn = -LW_PI/2;
    if (c->p->title) {
        s = lw_drawing_text(c->d, LW_ROLE_TITLE, c->p->title, lw_v2(x->from, c->top + 24), 16, 0);
        s->bold = true;
    }
    if (c->rounding > 0) {
        char note[64];
        snprintf(note, sizeof note, "zero: only rounding, up to %.0e", c->rounding);
        text(c, LW_ROLE_NOTE, note, x->to - 4, y->to + 14, 1);
    }
}

static lw_ink series_ink(int i)
{
    static const lw_ink ink[] = { LW_INK_BLUE, LW_INK_RED, LW_INK_GREEN, LW_INK_PURPLE,
                                  LW_INK_ORANGE, LW_INK_SKY, LW_INK_TEXT, LW_INK_YELLOW };
    return ink[i % 8];
}

/* Series of the same ink differ by marker and dashes. */
static void marker(lw_chart *c, lw_role role, int series, size_t item, lw_vec2 at)
{
    static const int corners[] = { 0, 4, 3, 4 };
    int kind = (series + series/8) % 4, n = corners[kind];
    lw_vec2 p[4];
    for (int k = 0; k < n; k++)
        p[k] = lw_v2_add(at, lw_v2_polar(4.6, 2*LW_PI*k/n - LW_PI/2 + (kind == 1 ? LW_PI/4 : 0)));
    lw_shape *s = n ? lw_drawing_path(c->d, role, p, (size_t)n, true)
                    : lw_drawing_circle(c->d, role, at, 3.6);
    s->item = (int)item;
    s->fill = series_ink(series);
    s->stroke = LW_INK_PAPER;
    s->width = 0.8;
}

static void line(lw_chart *c, lw_role role, int series, const lw_vec2 *p, size_t n)
{
    lw_shape *s = lw_drawing_path(c->d, role, p, n, false);
    s->item = series;
    s->stroke = series_ink(series);
    s->width = 1.9;
    s->dashed = series >= 8;
}

static void draw_series(lw_chart *c, int series)
{
    enum { RUN = 512 };                              /* a long line is drawn in pieces of this many points */
    const lw_series *s = &c->p->series[series];
    lw_vec2 run[RUN + 2];
    size_t n = 0;
    bool points = s->style == LW_SERIES_POINTS;
    for (size_t k = 0; k < s->n && !points; k++) {
        if (isnan(s->x[k]) && n > 0) {               /* a gap */
            line(c, LW_ROLE_SERIES, series, run, n);
            n = 0;
        }
        if (!fits(&c->x, s->x[k]) || !fits(&c->y, s->y[k]))
            continue;
        lw_vec2 at = lw_v2(place(&c->x, s->x[k]), place(&c->y, s->y[k]));
        if (n && s->style == LW_SERIES_STEPS) {
            run[n] = lw_v2(at.x, run[n - 1].y);
            n++;
        }
        run[n++] = at;
        if (n >= RUN) {
            line(c, LW_ROLE_SERIES, series, run, n);
            run[0] = at;
            n = 1;
        }
    }
    if (n > 1)
        line(c, LW_ROLE_SERIES, series, run, n);
    for (size_t k = 0; k < s->n && (s->n <= 80 || points); k++)
        if (fits(&c->x, s->x[k]) && fits(&c->y, s->y[k]))
            marker(c, LW_ROLE_MARKER, series, k, lw_v2(place(&c->x, s->x[k]), place(&c->y, s->y[k])));
}

static void draw_levels(lw_chart *c)
{
    for (int i = 0; i < c->p->n_level; i++) {
        const lw_level *l = &c->p->level[i];
        if (!fits(&c->y, l->y))
            continue;
        double at = place(&c->y, l->y);
        lw_shape *s = lw_drawing_line(c->d, LW_ROLE_LEVEL, lw_v2(c->x.from, at), lw_v2(c->x.to, at));
        s->item = i;
        s->stroke = LW_INK_TEXT;
        s->width = 1.4;
        s->dashed = true;
        text(c, LW_ROLE_LEVEL, l->name, c->x.to - 4, at - 5, 1);
    }
}

static double legend_width(const lw_plot *p)
{
    double w = 0;
    for (int i = 0; i < p->n_series; i++)
        w = fmax(w, lw_text_width(p->series[i].name, LETTER));
    return w > 0 ? w + 50 : 14;
}

static void draw_legend(lw_chart *c)
{
    int row = 0;
    for (int i = 0; i < c->p->n_series; i++) {
        if (!*c->p->series[i].name)
            continue;
        double x = c->legend, y = c->y.to + 8 + ROW*row++;
        lw_vec2 sample[2] = { { x, y }, { x + 22, y } };
        if (c->p->series[i].style != LW_SERIES_POINTS)
            line(c, LW_ROLE_LEGEND, i, sample, 2);
        marker(c, LW_ROLE_LEGEND, i, 0, lw_v2(x + 11, y));
        text(c, LW_ROLE_LEGEND, c->p->series[i].name, x + 28, y + 4, 0);
    }
}

/* Width of the numbers along the y axis. */
static double tick_width(const lw_axis *a)
{
    double w = 0;
    char t[32];
    for (int i = 0; i < a->n_tick; i++) {
        lw_number_text(t, a->tick[i], a->digits);
        w = fmax(w, lw_text_width(t, LETTER));
    }
    return w;
}

/* Give both axes the same scale: the one with the finer scale gets a wider range and new ticks. */
static void make_equal(lw_axis *x, lw_axis *y)
{
    double sx = fabs(x->to - x->from)/(x->hi - x->lo), sy = fabs(y->to - y->from)/(y->hi - y->lo);
    lw_axis *a = sx > sy ? x : y;
    double middle = (a->lo + a->hi)/2, half = 0.5*(a->hi - a->lo)*fmax(sx, sy)/fmin(sx, sy);
    a->lo = middle - half;
    a->hi = middle + half;
    a->n_tick = 0;
    even_ticks(a, fmax(fabs(a->to - a->from)/70, 1));
}

/* The part of the y axis, and how much room its numbers and label need on the left [px]. */
static double settle_y(lw_chart *c)
{
    c->y.to = c->top + (c->p->title ? 40 : 16);
    c->y.from = c->top + c->height - (c->p->x_label ? 50 : 30);
    settle(&c->y, fmax((c->y.from - c->y.to)/fmin(TICKS_APART, c->height/6), 1));
    return (c->p->y_label ? 38 : 14) + tick_width(&c->y);
}

static void draw_chart(lw_chart *c, double left)
{
    c->x.from = c->begin + left;
    c->x.to = c->begin + c->width - 8;
    settle(&c->x, fmax((c->x.to - c->x.from)/TICKS_APART, 1));
    if (c->p->equal)
        make_equal(&c->x, &c->y);
    if (c->x.n_tick > 0) {                                 /* the last number, half of which may stand out, stays on the page */
        char last[32];
        lw_number_text(last, c->x.tick[c->x.n_tick - 1], c->x.digits);
        double end = place(&c->x, c->x.tick[c->x.n_tick - 1]) + lw_text_width(last, LETTER)/2;
        c->x.to -= fmax(end - (c->d->width - 6), 0);
    }
    draw_axes(c);
    draw_levels(c);
    for (int i = 0; i < c->p->n_series; i++)
        draw_series(c, i);
    draw_legend(c);
}

lw_status lw_plot_draw_stack(int n, const lw_plot *p, lw_drawing *d, lw_error *e)
{
    int columns = p->columns > 0 ? p->columns : 1, rows = (n + columns - 1)/columns;
    *d = (lw_drawing){ .width = p->width > 0 ? p->width : 800, .height = p->height > 0 ? p->height : n > 1 ? 220*rows
                       : 560 };
    if (!(d->width >= 64 && d->width <= 8192 && d->height >= 64 && d->height <= 8192))
        return lw_error_set(e, LW_E_ARG, "a plot of %g by %g px: sizes are 64 to 8192", d->width, d->height);
    if (n < 1 || n > LW_PANEL_MAX)
        return lw_error_set(e, LW_E_ARG, "%d plots on one page: 1 to %d go", n, LW_PANEL_MAX);
    for (int i = 0; i < n; i++)
        if (p[i].n_series < 0 || p[i].n_series > LW_SERIES_MAX || p[i].n_level < 0 || p[i].n_level > LW_LEVEL_MAX)
            return lw_error_set(e, LW_E_ARG, "%d series and %d levels: a plot takes up to %d and %d",
                                p[i].n_series, p[i].n_level, LW_SERIES_MAX, LW_LEVEL_MAX);
    lw_chart chart[LW_PANEL_MAX];
    bool any[LW_PANEL_MAX], some = false;
    double left = 0, right = 0;
    lw_vec2 page[4] = { { 0, 0 }, { d->width, 0 }, { d->width, d->height }, { 0, d->height } };
    lw_text_clean(d->title, sizeof d->title, p->title ? p->title : "Plot");
    snprintf(d->about, sizeof d->about, "%d series", p->n_series);
    lw_drawing_path(d, LW_ROLE_PAPER, page, 4, true)->fill = LW_INK_PAPER;
    for (int i = 0; i < n; i++) {                              /* all in one width */
        chart[i] = (lw_chart){ .p = &p[i], .d = d, .top = d->height*(i/columns)/rows, .height = d->height/rows };
        any[i] = find_ranges(&chart[i]);
        some = some || any[i];
        if (any[i]) {
            left = fmax(left, settle_y(&chart[i]));
            right = fmax(right, fmin(legend_width(&p[i]), 0.4*d->width));
        }
    }
    for (int i = n - 1 - columns; i >= 0; i--)                /* without a label of its own: that below */
        chart[i].x.degrees = p[i].x_label ? chart[i].x.degrees : chart[i + columns].x.degrees;
    for (int i = 0; i < n; i++) {
        lw_chart *c = &chart[i];
        c->width = (d->width - right)/columns;
        c->begin = c->width*(i % columns);
        c->legend = d->width - right + 6;
        if (any[i])
            draw_chart(c, left);
        else
            text(c, LW_ROLE_NOTE, "no point to show", c->begin + c->width/2, c->top + c->height/2, 0.5);
    }
    lw_status st = lw_drawing_end(d, e);
    return st == LW_OK && !some ? LW_NOTHING : st;
}

lw_status lw_plot_draw(const lw_plot *p, lw_drawing *d, lw_error *e) { return lw_plot_draw_stack(1, p, d, e); }
