/* enumerate/symmetry.h - the symmetries of a mechanism: permutations of its links that keep joints, ground, inputs
 * and output, and the resulting permutations of its joints. */
#ifndef LW_ENUMERATE_SYMMETRY_H
#define LW_ENUMERATE_SYMMETRY_H

#include <stddef.h>
#include "grammar/topology/mechanism.h"

typedef struct lw_symmetry {
    size_t  n;                             /* number of symmetries; number 0 is the identity       */
    int     n_joint;
    uint8_t (*link)[LW_LINK_MAX];          /* (n) link i goes to link[k][i]; owned, see _free      */
    uint8_t (*joint)[LW_JOINT_MAX];        /* (n) the same for joints; owned                       */
} lw_symmetry;

/* Symmetries that keep joints, ground, inputs and output; with `kinds` also the kinds of joints
 * and the directions of sliders, else only their freedoms.  LW_E_MEMORY, also for more than 2^24 symmetries. */
lw_status lw_symmetry_of(const lw_mechanism *m, bool kinds, lw_symmetry *s);
void      lw_symmetry_free(lw_symmetry *s);

/* lowest[i] = the lowest link to which a symmetry that keeps the kinds maps link i; lowest (n_link).  Does not list
 * the symmetries.  LW_E_MEMORY. */
lw_status lw_mechanism_orbits(const lw_mechanism *m, uint8_t *lowest);

/* The mechanism in canonical form.  Two mechanisms are isomorphic, including ground, inputs and output, exactly when
 * their forms are equal; directions of sliders must not be chosen.  LW_E_MEMORY. */
lw_status lw_mechanism_canonical(const lw_mechanism *m, lw_mechanism *form);

#endif
