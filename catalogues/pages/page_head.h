/* catalogues/pages/page_head.h - the beginning of every page: policy, style sheet, title. */
#ifndef LW_CATALOGUES_PAGES_PAGE_HEAD_H
#define LW_CATALOGUES_PAGES_PAGE_HEAD_H

#include <stdbool.h>

#include "base/bytes.h"

/* Write `text`, escaped, between two pieces of HTML; NULL is an empty text. */
void lw_page_text(lw_bytes *b, const char *open, const char *text, const char *close);

/* ",12": the next number of a list. */
void lw_page_number(lw_bytes *b, long n);

/* The inks as variables, light and dark, and their classes; then the lines of one or two files (second may be NULL). */
void lw_page_style(lw_bytes *out, const char *const *first, const char *const *second);
void lw_page_script(lw_bytes *out, const char *const *text);

/* From <!DOCTYPE> to <body>.  The policy lets the page load nothing; it allows one style sheet and one script, named by
 * their hashes.  The caller writes the script as "<script>" text "</script>" where it belongs.  `loads`: the page may also
 * load scripts from its own folder. */
void lw_page_head(lw_bytes *b, const char *title, const lw_bytes *style, const lw_bytes *script, bool loads);

#endif
