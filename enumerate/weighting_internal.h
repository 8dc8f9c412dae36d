/* enumerate/weighting_internal.h - the search that listing and counting of weightings share.
 *
 * The search goes from one line that holds binary links to the next and skips the bare ones.  For each
 * critical set it keeps how many binary links the set still lacks.  A set that lacks all that are left is
 * tight: they must all go inside it.  So when one is left, the lines that can take it are those inside
 * every tight set. */
#ifndef LW_ENUMERATE_WEIGHTING_INTERNAL_H
#define LW_ENUMERATE_WEIGHTING_INTERNAL_H

#include "enumerate/canon.h"
#include "enumerate/critical.h"
#include "enumerate/weighting.h"

struct lw_weighting {
    lw_structure     s;
    int              dof, n_binary;
    int              most;                          /* binary links on one line                 */
    bool             parallel[LW_LINE_MAX];         /* to the line before it                    */
    lw_critical_list critical;
    size_t           n_element;                     /* automorphisms, the identity first        */
    uint8_t        (*circle)[LW_GRAPH_MAX];         /* circle c goes to circle[g][c]            */
    uint8_t        (*line)[LW_LINE_MAX];            /* line e goes to line[g][e]                */
};

/* One critical set per byte, sixteen to a block. */
typedef int8_t lw_weighting_lanes __attribute__((vector_size(16)));

/* A cycle of lines under an automorphism holds the same on each line: one unknown.  Under the identity
 * every line is an unknown, in the order of lines. */
typedef struct lw_unknown {
    int  n_line;
    bool fixed, turned;                   /* one line, kept in place; end for end                     */
} lw_unknown;

typedef struct lw_weighting_search {
    int        n_unknown, n_block;
    int        most;                      /* binary links on one line                                 */
    lw_unknown x[LW_LINE_MAX];
    uint64_t   tied;                      /* unknowns that hold at most as much as the one before     */
    uint64_t   single;                    /* unknowns of one line                                     */
    int        lines_left[LW_LINE_MAX + 1];
    lw_weighting_lanes  *column;                    /* (n_unknown) lines of the unknown in each set             */
    lw_weighting_lanes  *supply;                    /* (n_unknown + 1) what unknowns k .. can give each set     */
    lw_weighting_lanes  *lack;                      /* (n_unknown + 1) by depth: what each set is short of      */
    uint64_t  *inside;                    /* (sets) unknowns wholly inside a set                      */
} lw_weighting_search;

/* Where the search stands: unknowns before `next` are settled, the last of them holds `before`. */
typedef struct lw_weighting_state { int depth, next, before, left; } lw_weighting_state;

/* Memory for searches over w; then set one up for automorphism g. */
lw_status lw_search_open(lw_weighting_search *t, const lw_weighting *w);
void      lw_search_start(lw_weighting_search *t, const lw_weighting *w, size_t g);
void      lw_search_close(lw_weighting_search *t);

/* Unknowns that may be the next to hold something. */
uint64_t lw_weighting_candidates(const lw_weighting_search *t, const lw_weighting_state *s);

/* Most that unknown k may hold. */
static inline int lw_search_most(const lw_weighting_search *t, const lw_weighting_state *s, int k)
{
    int most = t->tied >> k & 1 && s->before < t->most ? s->before : t->most;
    return most*t->x[k].n_line <= s->left ? most : s->left/t->x[k].n_line;
}

/* Let unknown k hold n on each of its lines and all between it and s->next nothing; false when what is
 * left cannot satisfy every set, each asked alone. */
bool lw_search_settle(const lw_weighting_search *t, const lw_weighting_state *s, int k, int n, lw_weighting_state *after);

#endif
