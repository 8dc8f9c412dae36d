/* catalogues/pages/sha256.h - the SHA-256 hash (FIPS 180-4), by which a page's content security policy names the
 * one script and the one style sheet it allows. */
#ifndef LW_CATALOGUES_PAGES_SHA256_H
#define LW_CATALOGUES_PAGES_SHA256_H

#include <stddef.h>

#define LW_SHA256_TEXT 45          /* 44 letters of base 64 and a terminator */

void lw_sha256_base64(const void *data, size_t size, char text[LW_SHA256_TEXT]);

#endif
