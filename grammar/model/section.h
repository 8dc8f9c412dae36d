/* grammar/model/section.h - cross-sections and materials of elastic links.
 *
 * Axes: x along the bar, y the height, z the width.  In a planar model y lies in the plane.  zeta is the shear factor of
 * Timoshenko's beam, zeta = A/I^2 int (S/width)^2 dA, with S the static moment of what lies beyond (Makkonen 1999,
 * appendix A): 6/5 for a rectangle, 10/9 for a circle, 2 for a thin tube, A/A_web where webs carry the shear. */
#ifndef LW_GRAMMAR_MODEL_SECTION_H
#define LW_GRAMMAR_MODEL_SECTION_H

#include <stdbool.h>
#include "base/error.h"
#include "base/vec3.h"

typedef struct lw_section {
    double area;                     /* [m^2] */
    double iy, iz;                   /* second moments for bending out of the plane (about y) and in it (about z) [m^4] */
    double it;                       /* torsion constant [m^4] */
    double zeta_y, zeta_z;           /* shear factors for forces along y and z */
    double y, z;                     /* distance of the outermost fibre from the axis [m] */
    double gyration_y, gyration_z;   /* radii of gyration of the mass about y and z [m]; 0: those of the area */
    bool   whole;                    /* Iy and It are given, not taken for Iz and 2 Iz */
    bool   round;                    /* a circle or a ring: bends about any axis alike */
} lw_section;

/* Squared radii of gyration of the mass about y and z [m^2]. */
double lw_section_mass_y(const lw_section *s);
double lw_section_mass_z(const lw_section *s);

typedef struct lw_material { double e, g, density; } lw_material;       /* [N/m^2] [N/m^2] [kg/m^3] */

#define LW_ELASTIC_SHORTEST 1e-9     /* shorter than this [m] is no bar */
#define LW_ELASTIC_SEGMENTS 10000    /* most elements of a link */

/* A link that bends and stretches: a bar along its axis, or a frame of straight bars (mbs/elastic). */
typedef struct lw_elastic {
    bool   given;                    /* otherwise the link is rigid */
    lw_section  section;
    lw_material material;
    int    segments;                 /* elements along the axis; 0: as many as `frequency` needs */
    double frequency;                /* [Hz]; 0: the first of the bar with hinged ends */
    double damping;                  /* time d: damping is d times the stiffness [s] */
    bool   consistent;               /* mass of the shape functions instead of lumps */
    int    n_axis;                   /* points of the axis; 0: the line of the link's joints */
    lw_vec3 *axis;                   /* in the posture [m]; in the plane z = 0 */
    int    pieces;                   /* > 0: condensed to superelements, as many along the axis */
    int    modes;                    /* > 0: Craig and Bampton's modes of each superelement, a multiple of 6 */
    bool   plane;                    /* of a planar model: the modes are motions in its plane    */
    int    n_node;                   /* > 0: instead of all but damping and consistent, a superelement with its own matrices, */
    lw_vec3 *node;                   /* nodes in the posture [m], */
    double *stiffness, *mass;        /* (6 n_node squared) by displacement and turn of each node about ground axes [N/m] [kg] */
    lw_vec3 height;                  /* in space: direction near which the y axis of the section lies; 0: the section is
                                        the same in all directions */
} lw_elastic;

/* A body with stiffness and mass between its nodes, which are links; elastic links become these, too. */
typedef struct lw_superelement {
    int      n, *link;                   /* (n) nodes, of which those from n_bound on carry modes       */
    int      n_bound;
    lw_vec3 *at;                         /* (n) in the posture [m]                                     */
    double  *stiffness;                  /* (6n x 6n) by displacement and turn of each node, about ground axes of the posture */
    double  *rate;                       /* (6n x 6n) all mass, by velocities of the nodes and rates of modes (mbs/elastic/superelement.c) */
    double  *turn;                       /* (9 x 6n x 6n) its parts where the frame turns; NULL: 0         */
    double  *first;                      /* (3 x 6n) first moment of all mass by e (mbs/elastic/superelement.h): its weight */
    double  *lump;                       /* (n) masses of the nodes, whose weight is in `first` [kg]   */
    double  *turning;                    /* (6n) inertias of the nodes in ground axes of the posture, as lw_spatial_body's */
    double   damping;                    /* [s]                                                        */
    lw_mat3  section[2];                 /* of a bar: axes of its section at its two ends in the posture, x along it */
    lw_vec3  beside;                     /* first moment about the first node that the nodes' places do not give `first` [kg m] */
} lw_superelement;

/* Its arrays. */
void lw_superelement_free(lw_superelement *p);

struct lw_json_node;

/* Read a section {"shape": ..., ...} with lengths times `metre`, or a material: a name or {"E", "G" or "nu", "density"}.
 * LW_E_NOTATION with line and column. */
lw_status lw_section_read(const struct lw_json_node *n, double metre, lw_section *s, lw_error *e);
lw_status lw_material_read(const struct lw_json_node *n, lw_material *m, lw_error *e);

/* Read the object "elastic" of a link, in the plane or in space; matrices from files beside the model's.  p needs
 * lw_elastic_free, after a failure too. */
lw_status lw_elastic_read(const struct lw_json_node *n, double metre, bool space, lw_elastic *p, lw_error *e);
void lw_elastic_free(lw_elastic *p);
/* LW_E_NOTATION: the object `link` has members that contradict "elastic", its member n. */
lw_status lw_elastic_check_link(const struct lw_json_node *link, const struct lw_json_node *n, bool ground, lw_error *e);

#endif
