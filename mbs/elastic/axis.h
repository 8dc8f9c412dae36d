/* mbs/elastic/axis.h - the axis of an elastic link and where its nodes lie on it, in the plane (z = 0) or in space. */
#ifndef LW_MBS_ELASTIC_AXIS_H
#define LW_MBS_ELASTIC_AXIS_H

#include "grammar/model/section.h"

/* Places of a link at which something acts, those of its joints first [m]. */
typedef struct lw_elastic_places { int n, n_joint; lw_vec3 *at; } lw_elastic_places;

typedef struct lw_elastic_axis {
    lw_vec3  line[2];                /* the axis where the file gives none */
    const lw_vec3 *point;            /* (n_point) of a line of straight parts */
    int      n_point, n_node;
    double  *node;                   /* (n_node) distance of the nodes along the axis [m]; free() */
    double   length;
    double   frequency;              /* up to which elements chosen by themselves are good to 1 %; 0: their number was given [Hz] */
    double   first;                  /* first bending frequency with hinged ends (Euler & Bernoulli) [Hz] */
} lw_elastic_axis;

/* Put nodes at the corners of the axis and at the places, and elements of about equal length between them; a refers to
 * itself and to p, so it stays where it is.  LW_E_ARG: no axis follows from the joints, or it has no length (the link
 * `name`), or its frequency needs more than LW_ELASTIC_SEGMENTS elements. */
lw_status lw_elastic_axis_make(const lw_elastic *p, const char *name, const lw_elastic_places *places, lw_elastic_axis *a, lw_error *e);

/* The point at distance s along the axis; the node whose distance is nearest to that of the point of the axis nearest to
 * `at`. */
lw_vec3 lw_elastic_axis_point(const lw_elastic_axis *a, double s);
int     lw_elastic_axis_node(const lw_elastic_axis *a, lw_vec3 at);

/* A load that is linear along an element, as forces on its nodes that bend it as the load does: at `place` on the rigid body of the
 * node, weight[0] of the force at the start of the line load and weight[1] of that at its end (lw_line_load). */
typedef struct lw_elastic_push { lw_vec3 place; double weight[2]; } lw_elastic_push;

/* Forces on the element after node i by the line load from `at` to `to`: those on its first node, then as many on its second.  Returns
 * how many in all, at most 4; 0: the load is elsewhere; -1: the line is not on one straight part of the axis. */
int lw_elastic_line_pushes(const lw_elastic_axis *a, int i, lw_vec3 at, lw_vec3 to, bool varies, lw_elastic_push push[4]);

#endif
