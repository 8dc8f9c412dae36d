/* catalogues/store/atlas_internal.h - blocks of curves as they lie in the store. */
#ifndef LW_CATALOGUES_STORE_ATLAS_INTERNAL_H
#define LW_CATALOGUES_STORE_ATLAS_INTERNAL_H

#include "catalogues/store/atlas.h"

/* The terms, or else the linkages, of one block, which must be of this size. */
lw_status lw_store_block(lw_store *s, long long id, bool linkages, void *to, size_t size, lw_error *e);

#endif
