/* catalogues/build/build_internal.h - transactions of a limited time, and what the files here ask their caller. */
#ifndef LW_CATALOGUES_BUILD_BUILD_INTERNAL_H
#define LW_CATALOGUES_BUILD_BUILD_INTERNAL_H

#include "base/clock.h"
#include "catalogues/build/build.h"
#include "enumerate/canon.h"

typedef struct lw_build_transaction {
    lw_store *store;
    double    commit;         /* [s] after which it is due                  */
    bool      open;
    double    begun;          /* clock [s]                                  */
} lw_build_transaction;

/* Begin it unless it is open. */
static inline lw_status lw_build_open(lw_build_transaction *t, lw_error *e)
{
    if (t->open)
        return LW_OK;
    lw_status s = lw_store_begin(t->store, e);
    t->open = s == LW_OK;
    t->begun = lw_clock_wall();
    return s;
}

static inline bool lw_build_due(const lw_build_transaction *t)
{
    return t->open && lw_clock_wall() - t->begun >= t->commit;
}

static inline lw_status lw_build_commit(lw_build_transaction *t, lw_error *e)
{
    lw_status s = t->open ? lw_store_commit(t->store, e) : LW_OK;
    t->open = t->open && s != LW_OK;
    return s;
}

static inline void lw_build_rollback(lw_build_transaction *t)
{
    if (t->open)
        lw_store_rollback(t->store);
    t->open = false;
}

static inline const char *lw_build_command(const lw_build_control *c) { return c->command ? c->command : ""; }

static inline bool lw_build_stopped(const lw_build_control *c) { return c->stop && *c->stop; }

static inline bool lw_build_goes_on(const lw_build_control *c, double done, double total)
{
    return !lw_build_stopped(c) && (!c->goes_on || c->goes_on(c->context, done, total));
}

/* Give the caller the fault that was found, with the text of the status where there is no other. */
static inline lw_status lw_build_fault(lw_status s, const lw_error *found, lw_error *e)
{
    if (s != LW_OK && !found->text[0])
        lw_graph_error(e, s);
    else if (s != LW_OK && e)
        *e = *found;
    return s;
}

#endif
