/* catalogues/draw/sheet.c - see sheet.h */
#include "catalogues/draw/sheet.h"

#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "base/number.h"
#include "catalogues/draw/chain_drawing.h"

#define EDGE    24.0        /* around a page [px]                           */
#define HEAD    26.0        /* for a title, and for a page number           */
#define LETTER  10.0        /* size of a caption                            */

lw_sheet_style lw_sheet_style_default(void)
{
    return (lw_sheet_style){ .columns = 6, .rows = 8, .width = 794, .height = 1123, .shrink = true };
}

/* Copy a text, cut to a width with an ellipsis if it is too long. */
static void fit_text(const char *text, double size, double width, char *out, size_t room)
{
    lw_text_clean(out, room - 4, text);
    size_t n = strlen(out);
    if (lw_text_width(out, size) <= width)
        return;
    do {
        while (n > 0 && ((unsigned char)out[--n] & 0xc0) == 0x80)
            ;
        strcpy(out + n, "\xe2\x80\xa6");
    } while (n > 0 && lw_text_width(out, size) > width);
}

static void put_text(lw_drawing *d, lw_role role, const char *text, double size, double width, lw_vec2 at)
{
    char fitting[512];
    fit_text(text, size, width, fitting, sizeof fitting);
    lw_drawing_text(d, role, fitting, at, size, 0.5);
}

static lw_status put_item(const lw_sheet_item *item, lw_box cell, bool numbers, lw_drawing *d, lw_error *e)
{
    lw_chain_layout l;
    lw_status s = lw_chain_layout_make(item->m, &l, e);
    if (s != LW_OK)
        return s;
    double gap = 0.05*(cell.x1 - cell.x0), below = item->caption ? 1.5*LETTER : 0;
    lw_box box = { cell.x0 + gap, cell.y0 + gap, cell.x1 - gap, cell.y1 - gap - below };
    lw_chain_draw_into(item->m, &l, box, numbers, d);
    if (item->caption)
        put_text(d, LW_ROLE_NOTE, item->caption, LETTER, cell.x1 - cell.x0 - 6, lw_v2((cell.x0 + cell.x1)/2, cell.y1 - 0.6*LETTER));
    return LW_OK;
}

lw_status lw_sheet_draw(const lw_sheet_item *item, int n, const lw_sheet_style *s, int page, lw_drawing *d, lw_error *e)
{
    *d = (lw_drawing){ .width = s->width, .height = s->height };
    if (!(s->width >= 64 && s->width <= 8192 && s->height >= 64 && s->height <= 8192))
        return lw_error_set(e, LW_E_ARG, "a page is 64 to 8192 px wide and high");
    if (n < 1 || s->columns < 1 || s->rows < 1 || n > s->columns*s->rows)
        return lw_error_set(e, LW_E_ARG, "%d pictures for %d columns and %d rows", n, s->columns, s->rows);
    double head = s->title ? HEAD : 0, foot = page ? HEAD : 0;
    double w = (s->width - 2*EDGE)/s->columns, h = (s->height - 2*EDGE - head - foot)/s->rows;
    if (!(w >= 32 && h >= 32))
        return lw_error_set(e, LW_E_ARG, "pictures of %.0f by %.0f px are too small: fewer columns and rows, or a larger page", w, h);
    int columns = s->shrink && n < s->columns ? n : s->columns;
    int rows = s->shrink ? (n + columns - 1)/columns : s->rows;
    d->width = 2*EDGE + columns*w;
    d->height = 2*EDGE + rows*h + head + foot;
    lw_vec2 corner[4] = { { 0, 0 }, { d->width, 0 }, { d->width, d->height }, { 0, d->height } };
    lw_drawing_path(d, LW_ROLE_PAPER, corner, 4, true)->fill = LW_INK_PAPER;
    if (s->title)
        put_text(d, LW_ROLE_TITLE, s->title, 15, d->width - 2*EDGE, lw_v2(d->width/2, EDGE + 8));
    for (int i = 0; i < n; i++) {
        double x = EDGE + i % columns*w, y = EDGE + head + i/columns*h;
        lw_status st = put_item(&item[i], (lw_box){ x, y, x + w, y + h }, s->numbers, d, e);
        if (st != LW_OK) {
            lw_drawing_free(d);
            return st;
        }
    }
    char number[24];
    snprintf(number, sizeof number, "%d", page);
    if (page)
        put_text(d, LW_ROLE_NOTE, number, LETTER, 60, lw_v2(d->width/2, d->height - EDGE));
    lw_text_clean(d->title, sizeof d->title, s->title ? s->title : "Kinematic chains");
    snprintf(d->about, sizeof d->about, "%d kinematic chain%s in %d column%s", n, lw_plural(n), columns, lw_plural(columns));
    return lw_drawing_end(d, e);
}
