/* mbs/space/star_volume.h - volume of a region as seen from a point: parts that lie behind its edge do not count.
 *
 * Rays from the point find the edge.  They are the corners and the middles of the edges of triangles on the unit sphere, which begin as
 * the faces of an octahedron.  The volume over a triangle is that of the four pyramids over the ends of its rays, plus a third of what
 * they have more than the one pyramid over its corners, since the error falls with the square of the size where the edge is smooth.
 * Triangles whose last division changed the volume most are divided further, until these changes add up to less than the wanted share.
 * Parts of the region that are narrower than the first triangles, and which no ray meets, are not seen. */
#ifndef LW_MBS_SPACE_STAR_VOLUME_H
#define LW_MBS_SPACE_STAR_VOLUME_H

#include "base/status.h"
#include "base/vec3.h"

/* Distance to the edge in a direction (a unit vector).  Any status but LW_OK ends the search. */
typedef lw_status lw_star_reach(void *context, lw_vec3 direction, double *far);

typedef struct lw_star_volume {
    double volume;                               /* [m^3]                                                */
    double error;                                /* what the last divisions changed, added up [m^3]      */
} lw_star_volume;

/* around: number of first rays along a great circle, rounded up to 16, 32, 64, ...; share: wanted error over the volume; most: once
 * there are so many rays nothing more is divided, so that the error may stay larger.  LW_E_MEMORY, or the status of reach. */
lw_status lw_star_volume_find(int around, double share, int most, lw_star_reach *reach, void *context, lw_star_volume *out);

#endif
