/* enumerate/ordered.h - outputs the text of parallel jobs in the order of the jobs.
 *
 * Jobs 0, 1, 2, ... must be started in rising order, as base/parallel.h does.  The text of a job that finishes early
 * is parked, up to 64 of them.  A job whose text exceeds a megabyte waits for its turn and then passes the text on
 * as it comes.  So memory stays bounded however unequal the jobs are. */
#ifndef LW_ENUMERATE_ORDERED_H
#define LW_ENUMERATE_ORDERED_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include "base/status.h"

/* Receives the whole text piece by piece, in order, one call at a time, from any of the threads.  A status other than
 * LW_OK stops all jobs. */
typedef lw_status lw_text_sink(void *context, const char *text, size_t size);

#define LW_PARKED_MAX 64

typedef struct lw_ordered_part {
    struct lw_ordered *to;
    size_t             job, size, room;
    char              *text;
} lw_ordered_part;

typedef struct lw_ordered {
    pthread_mutex_t lock;
    pthread_cond_t  moved;
    size_t          turn;                        /* the job whose text is being output            */
    lw_ordered_part        parked[LW_PARKED_MAX];       /* by job modulo the size; text NULL: empty      */
    bool            is_parked[LW_PARKED_MAX];
    lw_text_sink   *sink;
    void           *context;
    lw_status       status;
} lw_ordered;

void      lw_ordered_open(lw_ordered *o, lw_text_sink *sink, void *context);
lw_status lw_ordered_close(lw_ordered *o);       /* the status that stopped it, or LW_OK */

/* To output the text of a job, call begin; then, as often as needed, reserve space for some bytes, write up to that
 * many, and add the number written; then end.  lw_piece_space returns NULL when all jobs are stopped; call end then.
 * Every job must begin and end. */
void  lw_piece_begin(lw_ordered_part *p, lw_ordered *o, size_t job);
char *lw_piece_space(lw_ordered_part *p, size_t most);
static inline void lw_piece_add(lw_ordered_part *p, size_t size) { p->size += size; }
void  lw_piece_end(lw_ordered_part *p);

/* Stop all jobs with this status, unless they are stopped already. */
void lw_ordered_stop(lw_ordered *o, lw_status status);

#endif
