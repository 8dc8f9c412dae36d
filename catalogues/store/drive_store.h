/* catalogues/store/drive_store.h - motors, gears and amplifiers in a catalogue. */
#ifndef LW_CATALOGUES_STORE_DRIVE_STORE_H
#define LW_CATALOGUES_STORE_DRIVE_STORE_H

#include "catalogues/store/store.h"
#include "grammar/model/drive_parts.h"

/* Store the parts; one that has the name of an earlier one replaces it. */
lw_status lw_store_add_drive_parts(lw_store *s, const lw_drive_parts *p, const char *file, const char *command, lw_error *e);

/* Append all parts of the catalogue `path`. */
lw_status lw_store_read_drive_parts(const char *path, lw_drive_parts *p, lw_error *e);

#endif
