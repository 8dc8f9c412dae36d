/* studio/studio.h - the page where one draws a path, searches and drags linkages, and the small server behind it.
 *
 * The server listens on the loopback address only.  Every address it answers begins with a random token; requests of
 * other origins, without the token or with too large a body are refused.  The server keeps no document: a page sends
 * with each request all that the answer depends on, so a server that is started again goes on where the old one ended.
 * Only searches that run belong to the server. */
#ifndef STUDIO_STUDIO_H
#define STUDIO_STUDIO_H

#include "base/error.h"

#define STUDIO_TOKEN_SIZE 33          /* 32 letters and the terminator */

typedef struct studio_options {
    int         port;                 /* 0: any free one                                                  */
    const char *token;                /* 32 letters 0-9a-f; NULL: a new one from the system's random bytes */
    const char *file;                 /* name of the file that the page opens first; NULL: none           */
    const char *text;                 /* its contents (size); copied                                      */
    size_t      size;
    const char *atlas;                /* catalogue with coupler curves; NULL: no nearest mechanisms       */
    const char *gallery;              /* folder of known mechanisms with an index.json; NULL: none        */
    bool        make_atlas;           /* make the catalogue in the background if it is not there          */
    int         jobs;                 /* threads of a search; below 1: one for each core                  */
} studio_options;

typedef struct studio studio;

/* Start the server in threads of its own.  LW_E_IO: the port is taken; LW_E_MEMORY. */
lw_status studio_start(const studio_options *options, studio **out, lw_error *e);

int         studio_port(const studio *s);
const char *studio_token(const studio *s);

/* End searches and answers that wait, and close the port. */
void studio_stop(studio *s);

#endif
