/* catalogues/exchange/plane.h - a planar linkage with its loads as a spatial model in the plane z = 0, for the writers of spatial models. */
#ifndef LW_CATALOGUES_EXCHANGE_PLANE_H
#define LW_CATALOGUES_EXCHANGE_PLANE_H

#include "grammar/model/model.h"
#include "grammar/model/spatial.h"

typedef struct lw_export_plane {
    lw_model   model;          /* the linkage with its loads; its arrays are those of the model given, if any */
    bool       given;          /* there is one; otherwise the arrays of `model` belong to it */
    lw_spatial space;          /* as lw_spatial_joint_by_joint makes it, with motions, laws, forces and motors of the model; gears and tied
                                  inputs are couplings, of two terms each */
} lw_export_plane;

/* m: of the same linkage; NULL: no masses, no loads.  Both must outlive p.  LW_E_KIND: a gear that lw_export_gear refuses; failures of
 * lw_assembly_check; LW_E_MEMORY.  Free it after a failure too. */
lw_status lw_export_plane_make(const lw_assembly *linkage, const lw_model *m, lw_export_plane *p, lw_error *e);
void      lw_export_plane_free(lw_export_plane *p);

/* A pin in a slot among the joints of such a model. */
static inline bool lw_export_is_slot(const lw_spatial_joint *p) { return p->kind == LW_SPATIAL_PLANAR && lw_v3_norm(p->second) > 0; }

#endif
