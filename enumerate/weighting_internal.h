/* enumerate/weighting_internal.h - the search shared by listing and counting of weightings.
 *
 * The search goes from one line with binary links to the next and skips lines without any.  For each critical set it
 * stores how many binary links the set still lacks.  A set that lacks as many as are left is tight: all of them must
 * go inside it.  So when one binary link is left, the lines that can take it are those inside every tight set. */
#ifndef LW_ENUMERATE_WEIGHTING_INTERNAL_H
#define LW_ENUMERATE_WEIGHTING_INTERNAL_H

#include "enumerate/canon.h"
#include "enumerate/critical.h"
#include "enumerate/weighting.h"

struct lw_weighting {
    lw_structure     s;
    int              n_binary;
    int              most;                          /* binary links on one line                 */
    bool             parallel[LW_LINE_MAX];         /* to the line before it                    */
    lw_critical_list critical;
    size_t           n_element;                     /* automorphisms, the identity first        */
    uint8_t        (*circle)[LW_GRAPH_MAX];         /* circle c goes to circle[g][c]            */
    uint8_t        (*line)[LW_LINE_MAX];            /* line e goes to line[g][e]                */
};

/* One critical set per byte, sixteen to a block. */
typedef int8_t lw_weighting_lanes __attribute__((vector_size(16)));

/* All lines of a cycle under an automorphism have the same weight, which is one unknown.  Under the identity every
 * line is an unknown, in the order of lines. */
typedef struct lw_unknown {
    int  n_line;
    bool fixed, turned;                   /* one line that is mapped to itself; reversed              */
} lw_unknown;

typedef struct lw_weighting_search {
    int        n_unknown, n_block;
    int        most;                      /* binary links on one line                                 */
    lw_unknown x[LW_LINE_MAX];
    uint64_t   tied;                      /* unknowns not larger than the one before                  */
    uint64_t   single, pairs;             /* unknowns of one line, of two                             */
    int        lines_left[LW_LINE_MAX + 1];
    lw_weighting_lanes  *column;                    /* (n_unknown) lines of the unknown in each set             */
    lw_weighting_lanes  *supply;                    /* (n_unknown + 1) most that unknowns k .. can add to each set */
    lw_weighting_lanes  *lack;                      /* (n_unknown + 1) by depth: what each set still lacks         */
    uint64_t  *inside;                    /* (sets) unknowns wholly inside a set                      */
    uint64_t            *lacking;         /* (sets) scratch: those that lack one binary link           */
} lw_weighting_search;

/* State of the search: unknowns before `next` are set, the last of them to `before`. */
typedef struct lw_weighting_state { int depth, next, before, left; } lw_weighting_state;

/* Allocate memory for searches over w; start a search for automorphism g, where line e goes to line[e] (n_line), and
 * parallel lines from number `apart` on are distinguishable.  The unknowns follow the lines in `order`, which keeps
 * parallel lines together (n_line; NULL: their numbers). */
lw_status lw_search_open(lw_weighting_search *t, const lw_weighting *w);
void      lw_search_start(lw_weighting_search *t, const lw_weighting *w, size_t g, const uint8_t *line, int apart, const uint8_t *order);
void      lw_search_close(lw_weighting_search *t);

/* Unknowns from s->next on that are inside every tight set. */
uint64_t lw_weighting_allowed(const lw_weighting_search *t, const lw_weighting_state *s);

/* The allowed unknowns that can get the next nonzero value: they are not tied to a line without binary links. */
uint64_t lw_weighting_candidates(const lw_weighting_search *t, const lw_weighting_state *s);

/* The unknowns inside each set that lacks one binary link: inside (sets).  Returns the number of such sets. */
int lw_weighting_lacking_one(const lw_weighting_search *t, const lw_weighting_state *s, uint64_t *inside);

/* Largest value of unknown k. */
static inline int lw_search_most(const lw_weighting_search *t, const lw_weighting_state *s, int k)
{
    int most = t->tied >> k & 1 && s->before < t->most ? s->before : t->most;
    return most*t->x[k].n_line <= s->left ? most : s->left/t->x[k].n_line;
}

/* Set unknown k to n on each of its lines, and all unknowns from s->next up to it to 0.  False when the binary links
 * that are left cannot satisfy every set, each set taken alone. */
bool lw_search_settle(const lw_weighting_search *t, const lw_weighting_state *s, int k, int n, lw_weighting_state *after);

#endif
