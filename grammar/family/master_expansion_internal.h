/* grammar/family/master_expansion_internal.h - what an expansion keeps: its parts with their frames, and where each value came from. */
#ifndef LW_GRAMMAR_FAMILY_MASTER_EXPANSION_INTERNAL_H
#define LW_GRAMMAR_FAMILY_MASTER_EXPANSION_INTERNAL_H

#include "grammar/family/master_internal.h"

/* angle [rad] about z */
typedef struct frame { double r[3][3], t[3]; bool turned, moved, out_of_plane; double angle; } frame;

typedef struct instance {
    const lw_part *part;
    const char    *name;
    int            parent;               /* -1: the model */
    lw_amount     *value;                /* of its scope */
    frame          at;
} instance;

/* A place of the output and the template it was written from. */
typedef struct mark { uint32_t out, node; int32_t instance; bool key; } mark;

/* memory of an expansion; the data follow */
typedef struct block { struct block *next; size_t used, room; } block;

typedef struct map {
    const lw_master *m;
    int       n_instance, instance_room, n_mark, mark_room;
    instance *instance;
    mark     *mark;
    block    *memory;
} map;

/* Add the names of the instance, and of those that it is in, to the text of e. */
void lw_master_name_instances(const map *p, int at, lw_error *e);

#endif
