#include "optimise/problem/family.h"

/* Logarithmic between lo and hi, because ratios of lengths matter and not differences. */
static double ratio(double u, double lo, double hi)
{
    return lo*exp(u*log(hi/lo));
}

/* An offset of either sign, mostly small compared to the links, sometimes not. */
static double offset(double u)
{
    double v = 2*u - 1;
    return v*v*v*8;
}

#define SLACK(u) ratio(u, 0.01, 30.0)

/* Draw four lengths, one of which is the shortest and equals one, by three slacks: s[j] is the amount by which the sum
 * of the two links other than j exceeds link j plus the shortest. */
static void grashof(const double *u, double *a, double *b, double *c)
{
    double s0 = SLACK(u[0]), s1 = SLACK(u[1]), s2 = SLACK(u[2]);
    *a = 1 + 0.5*(s1 + s2);
    *b = 1 + 0.5*(s0 + s2);
    *c = 1 + 0.5*(s0 + s1);
}

static void draw_crank_rocker(const double *u, double *r)
{
    r[1] = 1;
    grashof(u, &r[0], &r[2], &r[3]);
}

static void draw_drag_link(const double *u, double *r)
{
    r[0] = 1;
    grashof(u, &r[1], &r[2], &r[3]);
}

static void draw_four_bar(const double *u, double *r)
{
    r[1] = 1;
    r[0] = ratio(u[0], 0.1, 20);
    r[2] = ratio(u[1], 0.1, 20);
    r[3] = ratio(u[2], 0.1, 20);
}

/* A link of length one, an offset, and a link longer than both together. */
static void draw_long(const double *u, double *one, double *e, double *longer)
{
    *one = 1;
    *e = offset(u[0]);
    *longer = 1 + fabs(*e) + SLACK(u[1]);
}

static void draw_slider_crank(const double *u, double *s) { draw_long(u, &s[0], &s[2], &s[1]); }
static void draw_oscillating(const double *u, double *s)  { draw_long(u, &s[1], &s[2], &s[0]); }
static void draw_turning(const double *u, double *s)      { draw_long(u, &s[0], &s[2], &s[1]); }

static void draw_two_and_offset(const double *u, double *s)
{
    s[0] = 1;
    s[1] = ratio(u[0], 0.1, 20);
    s[2] = offset(u[1]);
}

static void draw_angle_last(const double *u, double *s)
{
    s[0] = 1;
    s[1] = LW_PI*(0.02 + 0.96*u[0]);
}

static void draw_angle_first(const double *u, double *s)
{
    s[0] = LW_PI*(0.02 + 0.96*u[0]);
    s[1] = 1;
}

static void draw_offsets(const double *u, double *s)
{
    s[0] = offset(u[0]);
    s[1] = 1;
}

#define FOUR { "r1", "r2", "r3", "r4" }
#define NO_CONDITION { NULL }

/* name, letters, turns, drag-link, shape, conditions, share, draws. The input of a yoke or an Oldham coupling always
 * turns fully and needs no condition. */
#define ROW(...) { __VA_ARGS__, NULL, false, 0 }
const lw_family lw_family_table[] = {
    ROW("crank-rocker", "RRRR", true, false, FOUR,
      { "+r3+r4-r1-r2", "+r1+r4-r2-r3", "+r1+r3-r2-r4" }, 4, 3, draw_crank_rocker ),
    ROW("drag-link", "RRRR", true, true, FOUR,
      { "+r3+r4-r1-r2", "+r2+r4-r1-r3", "+r2+r3-r1-r4" }, 2, 3, draw_drag_link ),
    ROW("any four-bar", "RRRR", false, false, FOUR, NO_CONDITION, 2, 3, draw_four_bar ),
    ROW("slider-crank", "RRRP", true, false, { "r2", "r3", "e1" },
      { "+r3-r2-e1", "+r3-r2+e1" }, 2, 2, draw_slider_crank ),
    ROW("any slider-crank", "RRRP", false, false, { "r2", "r3", "e1" }, NO_CONDITION, 1, 2,
      draw_two_and_offset ),
    ROW("oscillating", "RRPR", true, false, { "r1", "r2", "e3" },
      { "+r1-r2-e3", "+r1-r2+e3" }, 2, 2, draw_oscillating ),
    ROW("turning", "RRPR", true, false, { "r1", "r2", "e3" },
      { "+r2-r1-e3", "+r2-r1+e3" }, 2, 2, draw_turning ),
    ROW("any inverted", "RRPR", false, false, { "r1", "r2", "e3" }, NO_CONDITION, 1, 2,
      draw_two_and_offset ),
    ROW("slotted crank", "RPRR", true, false, { "r1", "r4", "e2" },
      { "+r4-r1-e2", "+r4-r1+e2" }, 1, 2, draw_slider_crank ),
    ROW("any slotted crank", "RPRR", false, false, { "r1", "r4", "e2" }, NO_CONDITION, 1, 2,
      draw_two_and_offset ),
    ROW("trammel", "PRRP", false, false, { "r3", "beta1" }, NO_CONDITION, 1, 1, draw_angle_last ),
    ROW("slider-driven", "PRRR", false, false, { "r3", "r4", "e1" }, NO_CONDITION, 1, 2,
      draw_two_and_offset ),
    ROW("slider-rocker", "PRPR", false, false, { "e3", "e1" }, NO_CONDITION, 1, 1, draw_offsets ),
    ROW("tangent", "RPRP", false, false, { "e2", "e1" }, NO_CONDITION, 1, 1, draw_offsets ),
    ROW("oldham", "RPPR", true, false, { "r1", "beta3" }, NO_CONDITION, 1, 1, draw_angle_last ),
    ROW("yoke", "RRPP", true, false, { "r2", "beta4" }, NO_CONDITION, 1, 1, draw_angle_last ),
    ROW("wedge", "PPRR", false, false, { "beta2", "r4" }, NO_CONDITION, 1, 1, draw_angle_first ),
    { .name = NULL }
};

void lw_family_linkage(const lw_family *f, lw_task task, lw_linkage *linkage)
{
    if (f->linkage) {
        *linkage = *f->linkage;
        return;
    }
    lw_type_linkage(lw_type_find(f->type), linkage);
    if (!lw_task_has_place(task))                          /* the output is the link at the ground   */
        linkage->tracer[0].link = 3;
}

const char *lw_family_title(const lw_family *f)
{
    return f->linkage ? f->name : lw_type_find(f->type)->title;
}

const char *lw_family_type(const lw_family *f)
{
    return f->linkage ? f->name : lw_type_find(f->type)->name;
}
