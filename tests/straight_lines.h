/* tests/straight_lines.h - linkages that draw an exact line, and pass change points. */
#ifndef LW_TESTS_STRAIGHT_LINES_H
#define LW_TESTS_STRAIGHT_LINES_H

#include "tests/mbs_linkage.h"

/* Coupler twice the crank, pinned in its middle, input at t: its end moves on x = 0. */
static inline void scott_russell(lw_linkage *l, double t)
{
    lw_vec2 a = lw_v2_polar(1.0, t), b = lw_v2(2.0*cos(t), 0.0);
    blank_linkage(l, 4);
    add_pin(l, 0, 1, lw_v2(0.0, 0.0));
    add_pin(l, 1, 2, a);
    add_pin(l, 2, 3, b);
    add_slide(l, 0, 3, b, 0.0);
    add_input(l, 0, t);
    add_tracer(l, 2, lw_v2(0.0, 2.0*sin(t)));              /* as far beyond A as B is before it */
}

/* Arms 5, rhombus 3; the pin P of a crank r about (c, 0), r = c, so that its circle goes through the
 * inversor's pole: Q moves on x = 16/(2 c). */
static inline void peaucellier(lw_linkage *l, double c, double t)
{
    lw_vec2 o = lw_v2(0.0, 0.0), p = lw_v2(c + c*cos(t), c*sin(t));
    lw_vec2 a = meet(o, 5.0, p, 3.0, 1.0), b = meet(o, 5.0, p, 3.0, -1.0);
    lw_vec2 q = lw_v2_sub(lw_v2_add(a, b), p);
    static const int joint[10][2] = {            /* ground, crank, two arms, AP, BP, AQ, BQ */
        { 0, 1 }, { 1, 4 }, { 4, 5 }, { 0, 2 }, { 0, 3 }, { 2, 4 }, { 2, 6 }, { 3, 5 }, { 3, 7 }, { 6, 7 }
    };
    lw_vec2 at[10] = { lw_v2(c, 0.0), p, p, o, o, a, a, b, b, q };
    blank_linkage(l, 8);
    for (int j = 0; j < 10; j++)
        add_pin(l, joint[j][0], joint[j][1], at[j]);
    add_input(l, 0, t);
    add_tracer(l, 6, q);
}

#endif
