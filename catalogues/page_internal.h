/* catalogues/page_internal.h - the parts of a page that are made apart: motions and tables. */
#ifndef LW_CATALOGUES_PAGE_INTERNAL_H
#define LW_CATALOGUES_PAGE_INTERNAL_H

#include "catalogues/drawing.h"
#include "catalogues/page.h"

/* One JSON object, { "loops", "first", "links": [...] }, as page.js reads it: every link that moves on
 * the drawing, whole numbers only. */
void lw_page_motions(lw_bytes *b, const lw_scene *s, const lw_drawing *d);

/* The ranked results of a target; columns nobody filled are left out. */
void lw_page_table(lw_bytes *b, const lw_page_target *t, int target);

#endif
