/* catalogues/store/sha256.h - the SHA-256 hash (FIPS 180-4).
 *
 * It identifies the linkages of a catalogue: existing files hold such hashes (column linkage.hash), so another hash
 * would store known linkages a second time.  The pages use it for their content security policy: the hash of the one
 * script and the one style sheet allowed is stricter than 'unsafe-inline', which would allow any.  A data set lists the
 * hashes of its files. */
#ifndef LW_CATALOGUES_STORE_SHA256_H
#define LW_CATALOGUES_STORE_SHA256_H

#include <stddef.h>

#define LW_SHA256_TEXT 45          /* 44 letters of base 64 and a terminator */
#define LW_SHA256_HEX  65          /* 64 hexadecimal digits and a terminator */

void lw_sha256_base64(const void *data, size_t size, char text[LW_SHA256_TEXT]);
void lw_sha256_hex(const void *data, size_t size, char text[LW_SHA256_HEX]);       /* as sha256sum prints it */

#endif
