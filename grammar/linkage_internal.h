/* grammar/linkage_internal.h - what the check and the reader of a linkage share. */
#ifndef LW_GRAMMAR_LINKAGE_INTERNAL_H
#define LW_GRAMMAR_LINKAGE_INTERNAL_H

#include "grammar/linkage.h"

/* Which part of a linkage is at fault, so that the reader can point to its place in the text. */
typedef enum lw_linkage_part {
    LW_PART_WHOLE, LW_PART_LINK, LW_PART_JOINT, LW_PART_INPUT, LW_PART_TRACER
} lw_linkage_part;

typedef struct lw_linkage_place {
    lw_linkage_part part;
    int             index;      /* of the link, joint, input or tracer */
} lw_linkage_place;

/* lw_linkage_check that also tells the place. */
lw_status lw_linkage_find_fault(const lw_linkage *k, lw_linkage_place *place, lw_error *e);

#endif
