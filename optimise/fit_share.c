/* optimise/fit_share.c - which arm gets how much of the next round.
 *
 * Four-link types have fixed shares.  Families of any linkage are searched by successive halving (Karnin, Koren
 * & Somekh 2013; Jamieson & Talwalkar 2016): a round for all, the next for the better half, twice as much for
 * each, until a few are left; then all over again with other starts, since luck decides too.  What an arm
 * has found is its best f, at whatever price. */
#include <stdlib.h>

#include "optimise/fit_internal.h"
#include "optimise/problem_internal.h"

enum {
    LEAST_JOBS = 32,        /* of a round                                                         */
    LAST_ARMS = 3           /* of a sweep                                                         */
};

static void share_types(lw_search *s)
{
    s->n_job = 0;
    for (int i = 0; i < s->n_arm; i++) {
        long blocks = s->o->starts > 0 ? (s->o->starts + LW_BLOCK - 1)/LW_BLOCK : s->arm[i].fine.family->blocks;
        for (int k = 0; k < blocks && k < 8; k++)
            s->job[s->n_job++] = (lw_search_job){ i, false };
    }
}

typedef struct standing { double f; int arm; } standing;

static int by_f(const void *a, const void *b)
{
    const standing *p = a, *q = b;
    return p->f < q->f ? -1 : p->f > q->f ? 1 : p->arm - q->arm;
}

/* Where in a sweep is this round, 0 the one for all? */
static int rung_of(const lw_search *s, int round)
{
    int rungs = 1;
    for (int n = s->n_arm; n > LAST_ARMS; n = (n + 1)/2)
        rungs++;
    return round%rungs;
}

static void share_families(lw_search *s, int round)
{
    int rung = rung_of(s, round), n = s->n_arm < LW_JOB_MAX ? s->n_arm : LW_JOB_MAX, at = 0;
    standing *list = malloc(sizeof *list*(size_t)s->n_arm);
    s->n_job = 0;
    if (!list)
        return;                                          /* no jobs: the search ends with what it has */
    for (int i = 0; i < s->n_arm; i++)
        list[i] = (standing){ s->arm[i].best->n ? s->arm[i].best->item[0].f : INFINITY, i };
    qsort(list, (size_t)s->n_arm, sizeof *list, by_f);
    int jobs = n > LEAST_JOBS ? n : LEAST_JOBS;
    for (int r = 0; r < rung; r++)
        n = (n + 1)/2;
    for (; at < jobs; at++) {
        int arm = list[at%n].arm, turn = at/n;
        bool around = s->arm[arm].best->n > 0 && rung > 0 && (turn & 1) == (rung & 1);
        s->job[s->n_job++] = (lw_search_job){ arm, around };
    }
    free(list);
}

void lw_search_share(lw_search *s, int round)
{
    if (s->o->family)
        share_families(s, round);
    else
        share_types(s);
}
