/* grammar/linkage/assembly.h - links, joints, inputs and tracer points in one posture, as many as memory holds.
 *
 * The same parts as a linkage (grammar/linkage/linkage.h), which is plain data of fixed capacity for plans, kernels and
 * fits.  Models hold an assembly (grammar/model/model.h).  An assembly that is read owns its arrays: lw_assembly_free.  A
 * view of a linkage owns nothing. */
#ifndef LW_GRAMMAR_LINKAGE_ASSEMBLY_H
#define LW_GRAMMAR_LINKAGE_ASSEMBLY_H

#include "grammar/linkage/linkage.h"

typedef struct lw_assembly {
    char       name[64];
    int        n_link, n_joint, n_input, n_tracer;
    int        ground;                        /* the fixed link    */
    char     (*link_name)[LW_NAME_SIZE];
    lw_joint  *joint;
    lw_input  *input;
    lw_tracer *tracer;
    lw_units   units;
    bool       has_nodes;                     /* links may be tied by elements instead of joints (mbs/elastic/expand.h) */
} lw_assembly;

/* Free the arrays of an assembly that was read or copied, and zero it. */
void lw_assembly_free(lw_assembly *a);

/* A view of the linkage, which must outlive it. */
lw_assembly lw_linkage_view(const lw_linkage *linkage);
#define LW_VIEW(linkage) ((lw_assembly[1]){ lw_linkage_view(linkage) })      /* as an argument */

/* Copy a to linkage.  LW_E_KIND: it has more parts than a linkage holds; the text says how many. */
lw_status lw_assembly_linkage(const lw_assembly *a, lw_linkage *linkage, lw_error *e);

/* Copy `from`, arrays too.  LW_E_MEMORY: *to is empty. */
lw_status lw_assembly_copy(const lw_assembly *from, lw_assembly *to);

/* As the functions of a linkage (grammar/linkage/linkage.h). */
int       lw_assembly_mobility(const lw_assembly *a);
int       lw_assembly_free_inputs(const lw_assembly *a);
double    lw_assembly_tied_input(const lw_assembly *a, int i, double first);

/* Unit of the ratio of input i, with `metre` the length unit: metre if it slides and the first input turns,
 * 1/metre if it turns and the first slides, else 1. */
double    lw_assembly_tie_unit(const lw_assembly *a, int i, double metre);
/* Free what was read by lw_assembly_free. */
lw_status lw_assembly_read_result(const char *text, size_t size, const char *file, int which, lw_assembly *a, lw_error *e);
char     *lw_assembly_write(const lw_assembly *a, int indent);      /* as lw_linkage_write */
double    lw_assembly_posture_input(const lw_assembly *a, int joint);
/* Set the values of the inputs, but those given (n_input; NULL: none), from the posture. LW_E_MEMORY. */
lw_status lw_assembly_set_inputs(lw_assembly *a, const bool *given);
lw_status lw_assembly_check(const lw_assembly *a, lw_error *e);

/* As lw_linkage_gear; *contact is the pitch point (lw_gear_contact) unless NULL.  LW_E_MEMORY. */
lw_status lw_assembly_gear(const lw_assembly *a, int joint, lw_gear *g, lw_vec2 *contact, lw_error *e);

#endif
