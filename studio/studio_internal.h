/* studio/studio_internal.h - what the answers of the server share. */
#ifndef STUDIO_STUDIO_INTERNAL_H
#define STUDIO_STUDIO_INTERNAL_H

#include <jansson.h>
#include <pthread.h>
#include <stdbool.h>
#include "base/bytes.h"
#include "grammar/linkage/assembly.h"
#include "grammar/linkage/linkage.h"
#include "studio/studio.h"

typedef struct studio_reply {
    int         status;               /* of HTTP; 200                                  */
    const char *type;                 /* media type                                    */
    lw_bytes    body;
} studio_reply;

struct studio_search;

struct studio {
    int             port;
    char            token[STUDIO_TOKEN_SIZE];
    char           *file, *text;      /* opened first; NULL: none                       */
    char           *atlas, *gallery;
    int             jobs;
    void           *daemon;           /* of libmicrohttpd                              */
    pthread_mutex_t lock;             /* of what follows                               */
    pthread_cond_t  news;             /* something changed in a search, or the end      */
    bool            closing;
    int             last_search;
    struct studio_search *search;     /* list                                          */
    int             atlas_state;      /* 0 none, 1 being made, 2 ready                  */
    double          atlas_done;
    volatile int    atlas_stop;
    pthread_t       atlas_maker;
    bool            has_maker;
};

/* Answer one question: fills r->body.  A status below 0 goes to the page as an error with its text. */
typedef lw_status studio_answer(studio *s, const json_t *ask, studio_reply *r, lw_error *e);

studio_answer studio_begin, studio_open, studio_motion, studio_analyse, studio_forces, studio_mobility, studio_assembly,
              studio_target, studio_search_start, studio_search_news, studio_search_stop, studio_nearest, studio_export,
              studio_chains, studio_chain_linkage, studio_gallery;

/* Answer the question `name` with a body of JSON, or refuse it with a reason: fills *r. */
void studio_ask(studio *s, const char *name, const lw_bytes *body, studio_reply *r);

void studio_searches_end(studio *s);
void studio_atlas_begin(studio *s, bool make);
void studio_atlas_end(studio *s);

/* ---- what a page asks for */

const char *studio_text(const json_t *ask, const char *key, const char *otherwise);
double      studio_real(const json_t *ask, const char *key, double otherwise);
bool        studio_bool(const json_t *ask, const char *key);

/* The member `key`, a JSON object or a text, as allocated text.  LW_E_ARG: there is none. */
lw_status studio_source(const json_t *ask, const char *key, char **text, size_t *size, lw_error *e);
lw_status studio_linkage(const json_t *ask, const char *key, lw_linkage *k, lw_error *e);
/* The same of any number of parts; free *a by lw_assembly_free, after a failure too. */
lw_status studio_parts(const json_t *ask, const char *key, lw_assembly *a, lw_error *e);

/* ---- what it gets: JSON, written as it is made */

void studio_put_key(lw_bytes *b, const char *key);                   /* ,"key":  without a comma behind { and [ */
void studio_put_text(lw_bytes *b, const char *key, const char *text);           /* NULL: null; key NULL: an element */
void studio_put_real(lw_bytes *b, const char *key, double v);                    /* not finite: null */
void studio_put_bool(lw_bytes *b, const char *key, bool v);
void studio_put_reals(lw_bytes *b, const char *key, const double *v, size_t n, size_t stride, double unit);

/* The linkage as docs/notation.md writes it. */
void studio_put_linkage(lw_bytes *b, const char *key, const lw_assembly *a);

#endif
