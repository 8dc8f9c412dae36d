/* enumerate/ordered.c - see ordered.h. */
#include <stdlib.h>
#include "enumerate/ordered.h"

#define PIECE_MAX ((size_t)1 << 20)

void lw_ordered_open(lw_ordered *o, lw_text_sink *sink, void *context)
{
    *o = (lw_ordered){ .sink = sink, .context = context };
    pthread_mutex_init(&o->lock, NULL);
    pthread_cond_init(&o->moved, NULL);
}

lw_status lw_ordered_close(lw_ordered *o)
{
    for (int k = 0; k < LW_PARKED_MAX; k++)
        free(o->parked[k].text);
    pthread_cond_destroy(&o->moved);
    pthread_mutex_destroy(&o->lock);
    return o->status;
}

/* Below, `locked` functions are called with the lock held. */
static void stop_locked(lw_ordered *o, lw_status status)
{
    if (o->status == LW_OK)
        __atomic_store_n(&o->status, status, __ATOMIC_RELAXED);      /* lw_piece_space reads it without the lock */
    pthread_cond_broadcast(&o->moved);
}

void lw_ordered_stop(lw_ordered *o, lw_status status)
{
    pthread_mutex_lock(&o->lock);
    stop_locked(o, status);
    pthread_mutex_unlock(&o->lock);
}

static void pass_on_locked(lw_ordered *o, lw_ordered_part *p)
{
    if (o->status == LW_OK && p->size > 0) {
        lw_status status = o->sink(o->context, p->text, p->size);
        if (status != LW_OK)
            stop_locked(o, status);
    }
    p->size = 0;
}

void lw_piece_begin(lw_ordered_part *p, lw_ordered *o, size_t job) { *p = (lw_ordered_part){ .to = o, .job = job }; }

/* Wait for the job's turn and output its text so far. */
static void empty_piece(lw_ordered_part *p)
{
    lw_ordered *o = p->to;
    pthread_mutex_lock(&o->lock);
    while (o->status == LW_OK && o->turn != p->job)
        pthread_cond_wait(&o->moved, &o->lock);
    pass_on_locked(o, p);
    pthread_mutex_unlock(&o->lock);
}

char *lw_piece_space(lw_ordered_part *p, size_t most)
{
    if (p->size > 0 && p->size + most > PIECE_MAX)
        empty_piece(p);
    if (p->size + most > p->room) {
        size_t room = p->room ? 2*p->room : 4096;
        while (room < p->size + most)
            room *= 2;
        char *text = realloc(p->text, room);
        if (!text) {
            lw_ordered_stop(p->to, LW_E_MEMORY);
            return NULL;
        }
        p->text = text;
        p->room = room;
    }
    /* without the lock: a stop seen late only costs some text that is discarded */
    return __atomic_load_n(&p->to->status, __ATOMIC_RELAXED) == LW_OK ? p->text + p->size : NULL;
}

/* Give the turn to the next job, and output the parked texts that follow. */
static void advance_locked(lw_ordered *o)
{
    o->turn++;
    for (lw_ordered_part *next = &o->parked[o->turn % LW_PARKED_MAX]; o->is_parked[o->turn % LW_PARKED_MAX];
         next = &o->parked[o->turn % LW_PARKED_MAX]) {
        pass_on_locked(o, next);
        free(next->text);
        next->text = NULL;
        o->is_parked[o->turn % LW_PARKED_MAX] = false;
        o->turn++;
    }
    pthread_cond_broadcast(&o->moved);
}

void lw_piece_end(lw_ordered_part *p)
{
    lw_ordered *o = p->to;
    pthread_mutex_lock(&o->lock);
    while (o->status == LW_OK && p->job - o->turn >= LW_PARKED_MAX)
        pthread_cond_wait(&o->moved, &o->lock);
    if (o->status == LW_OK && o->turn != p->job) {
        o->parked[p->job % LW_PARKED_MAX] = *p;
        o->is_parked[p->job % LW_PARKED_MAX] = true;
        pthread_mutex_unlock(&o->lock);
        return;
    }
    pass_on_locked(o, p);
    if (o->status == LW_OK)
        advance_locked(o);
    pthread_mutex_unlock(&o->lock);
    free(p->text);
}
