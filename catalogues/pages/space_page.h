/* catalogues/pages/space_page.h - a page that shows a spatial model in motion and turns it by mouse, finger or keys.  It
 * opens from a disk and loads nothing; without scripts it shows a still picture. */
#ifndef LW_CATALOGUES_PAGES_SPACE_PAGE_H
#define LW_CATALOGUES_PAGES_SPACE_PAGE_H

#include "base/bytes.h"
#include "catalogues/draw/space_scene.h"

lw_status lw_space_page_write(const lw_space_scene *s, lw_space_view view, lw_bytes *out, lw_error *e);

#endif
