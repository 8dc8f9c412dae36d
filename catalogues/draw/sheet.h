/* catalogues/draw/sheet.h - many chains on a page, in rows, each with its caption. */
#ifndef LW_CATALOGUES_DRAW_SHEET_H
#define LW_CATALOGUES_DRAW_SHEET_H

#include "catalogues/draw/drawing.h"
#include "catalogues/draw/chain_layout.h"

typedef struct lw_sheet_style {
    int    columns, rows;         /* pictures on a page                                     (6, 8)      */
    double width, height;         /* of a full page [px]; A4 upright at 96 px an inch       (794, 1123) */
    bool   numbers;               /* of links                                               (false)     */
    bool   shrink;                /* a page with few pictures is only as large as needed    (true)      */
    const char *title;            /* above; NULL: none                                                  */
} lw_sheet_style;

lw_sheet_style lw_sheet_style_default(void);

/* One picture of a sheet. */
typedef struct lw_sheet_item {
    const lw_mechanism *m;
    const char         *caption;  /* NULL: none; cut where it is wider than its cell                    */
} lw_sheet_item;

/* Draw a page with items 0 .. n-1, at most columns*rows, and compute their layouts. page: number at the foot of the
 * page, 0: none. LW_E_ARG: sizes outside 64 .. 8192 px, cells under 32 px, no items or too many, an item without
 * picture. */
lw_status lw_sheet_draw(const lw_sheet_item *item, int n, const lw_sheet_style *s, int page, lw_drawing *d, lw_error *e);

#endif
