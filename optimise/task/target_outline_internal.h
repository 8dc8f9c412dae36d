/* optimise/task/target_outline_internal.h - the curves of a drawing, and how stations are placed on them. */
#ifndef LW_OPTIMISE_TASK_TARGET_OUTLINE_INTERNAL_H
#define LW_OPTIMISE_TASK_TARGET_OUTLINE_INTERNAL_H

#include "base/vec2.h"
#include "optimise/task/target_outline.h"

#define LW_OUTLINE_MAX  4000000       /* points of a drawing                                        */
#define LW_DRAWN_CURVE_MAX 50000         /* curves, or pieces of them                                  */
#define LW_OUTLINE_ARCS 128           /* steps of a curve segment, or of a turn of an arc           */

/* An affine map: x' = a x + c y + e, y' = b x + d y + f. */
typedef struct lw_affine { double a, b, c, d, e, f; } lw_affine;

static inline lw_vec2 lw_affine_point(const lw_affine *m, lw_vec2 p)
{
    return lw_v2(m->a*p.x + m->c*p.y + m->e, m->b*p.x + m->d*p.y + m->f);
}

/* First n, then m. */
static inline lw_affine lw_affine_product(const lw_affine *m, const lw_affine *n)
{
    return (lw_affine){ m->a*n->a + m->c*n->b, m->b*n->a + m->d*n->b, m->a*n->c + m->c*n->d, m->b*n->c + m->d*n->d,
                        m->a*n->e + m->c*n->f + m->e, m->b*n->e + m->d*n->f + m->f };
}

/* A curve as a polygon of many points; its names are what a person may call it by. */
typedef struct lw_outline {
    size_t   n, room;
    lw_vec2 *p;                       /* in the drawing's units                (n) owned            */
    long    *line;                    /* line of the file of each point        (n) owned            */
    bool     closed;                  /* the file says so; the last point is not the first again    */
    char     name[3][48];             /* its own, its label, its group or layer; "": none           */
} lw_outline;

typedef struct lw_outlines {
    lw_outline *curve;                /* (n) owned                                                  */
    int         n, room;
    size_t      points;               /* of all curves                                              */
    bool        failed;               /* no memory, or too many points or curves                    */
    bool        only_points;          /* the curve is a list of points, not a line through them     */
    const char *unit;                 /* length unit, and how many of it one unit of the drawing is */
    double      scale;
    bool        unit_given;           /* the file says so                                           */
} lw_outlines;

/* Begin a curve; it gets the points that follow. Repeated points are left out. */
void lw_outlines_begin(lw_outlines *d, const char *name, const char *label, const char *group);
void lw_outlines_add(lw_outlines *d, lw_vec2 p, long line);
void lw_outlines_close(lw_outlines *d);
void lw_outlines_free(lw_outlines *d);

/* Make stations in metres of the curves that the options name. */
lw_status lw_outlines_target(lw_outlines *d, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);

/* ---- places along a curve (target_resample.c) ---- */

/* Place m >= 2 stations along the polygon of n >= 2 points. Corners are stations, if they are not too many; between
 * them, two thirds of the stations follow the length and one third the turning of the curve, if by_curvature, else all
 * of them the length. from[i]: index of the point before station i. */
lw_status lw_resample(const lw_vec2 *p, size_t n, bool closed, bool by_curvature, size_t m, lw_vec2 *out, size_t *from, lw_error *e);

/* Move the points onto the smoothest cubic spline that no point leaves by more than `distance` (Reinsch 1967): the
 * least integral of the squared second derivative by chord length. *rms, *most: the distances moved. Points that
 * repeat the one before move with it. */
lw_status lw_smooth(double *x, double *y, size_t n, bool closed, double distance, double *rms, double *most, lw_error *e);

#define LW_NOISE_POINTS 20              /* fewest points whose noise can be estimated */

/* Standard deviation of the noise of n points across their path: the median of their differences (Gasser, Sroka &
 * Jennen-Steinmetz 1986), of the order 2, 4, 6 or 8 that leaves least of the path itself.  work: (n).  n >= 9. */
double lw_noise(const double *x, const double *y, size_t n, bool closed, double *work);

/* Put in order, smooth and resample a target as the options say (closed: of the file, too); adds to its note. LW_E_ARG: it is no path, or has more columns. */
lw_status lw_target_treat(lw_target *t, int closed, const lw_target_options *o, lw_error *e);

#endif
