/* grammar/linkage/linkage_internal.h - shared by the check and the reader of a linkage. */
#ifndef LW_GRAMMAR_LINKAGE_LINKAGE_INTERNAL_H
#define LW_GRAMMAR_LINKAGE_LINKAGE_INTERNAL_H

#include "grammar/linkage/assembly.h"

/* The faulty part of a linkage, from which the reader finds its place in the text. */
typedef enum lw_linkage_part {
    LW_PART_WHOLE, LW_PART_LINK, LW_PART_JOINT, LW_PART_INPUT, LW_PART_TRACER
} lw_linkage_part;

typedef struct lw_linkage_place {
    lw_linkage_part part;
    int             index;      /* of the link, joint, input or tracer */
} lw_linkage_place;

/* lw_assembly_check; on failure *place gets the faulty part. */
lw_status lw_assembly_find_fault(const lw_assembly *assembly, lw_linkage_place *place, lw_error *e);

#endif
