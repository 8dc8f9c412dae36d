/* enumerate/published.h - published counts of chains, structures and mechanisms, and the recount of each.
 *
 * The table is comma-separated values with the header
 *
 *     family,dof,links,loops,what,count,source,verified_by
 *
 * `what` describes in words what was counted.  A row whose verified_by begins with "refuted" is a known erratum of
 * its source.  A table in recount.c assigns a way of counting to each wording. */
#ifndef LW_ENUMERATE_PUBLISHED_H
#define LW_ENUMERATE_PUBLISHED_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

typedef struct lw_published {
    long        line;                     /* in the file                                            */
    const char *family, *what, *source;   /* parts of `text`                                        */
    int         dof, links, loops;        /* -1 where the table has none                            */
    long long   count;
    bool        refuted;
} lw_published;

typedef struct lw_published_table {
    size_t        n;
    lw_published *row;                    /* (n) owned                                              */
    char         *text;                   /* owned                                                  */
} lw_published_table;

/* LW_E_NOTATION with line and column; LW_E_MEMORY. */
lw_status lw_published_read(const char *text, size_t size, const char *file, lw_published_table *t, lw_error *e);
void      lw_published_free(lw_published_table *t);

typedef enum lw_verdict {
    LW_AGREES, LW_DISAGREES,
    LW_ERRATUM,                           /* disagrees, and is known to be wrong                    */
    LW_TOO_LONG,                          /* would take longer than allowed                         */
    LW_NOT_COUNTED                        /* of a kind that is not counted here                     */
} lw_verdict;

typedef struct lw_recount_result {
    lw_verdict verdict;
    long long  counted;                   /* of the first three                                     */
    double     seconds;                   /* estimated, of LW_TOO_LONG; 0: the time was over before  */
} lw_recount_result;

/* Counts made so far, shared by rows about the same chains.  goes_on is called from time to time during a count, which is
 * given up when it returns false; NULL: none is.  lw_recount_create: NULL when out of memory. */
typedef struct lw_recount lw_recount;
lw_recount *lw_recount_create(int n_thread, bool (*goes_on)(void *context), void *context);
void        lw_recount_free(lw_recount *r);

/* Recount the row if the estimated time is within `seconds`; LW_TOO_LONG, too, if the count was given up.  LW_E_MEMORY. */
lw_status lw_recount_row(lw_recount *r, const lw_published *row, double seconds, lw_recount_result *result);

#endif
