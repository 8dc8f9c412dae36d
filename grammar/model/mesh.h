/* grammar/model/mesh.h - mass properties of a body from its surface, a closed mesh of triangles (STL, text or binary). */
#ifndef LW_GRAMMAR_MODEL_MESH_H
#define LW_GRAMMAR_MODEL_MESH_H

#include <stddef.h>
#include "base/error.h"
#include "base/vec3.h"

typedef struct lw_mesh_integrals {
    double  volume;                  /* [unit^3] */
    lw_vec3 centre;                  /* of the volume [unit] */
    double  inertia[6];              /* about the centre, of density 1 [unit^5]: xx, yy, zz, xy, xz, yz of the matrix */
} lw_mesh_integrals;

/* Exact integrals of the polyhedron, in the length unit of the file; cavities are shells whose faces look inwards.  LW_E_NOTATION: no
 * STL file, a mesh that is not closed (the text says where), or one inside out. */
lw_status lw_mesh_read(const char *text, size_t size, const char *file, lw_mesh_integrals *out, lw_error *e);

#endif
