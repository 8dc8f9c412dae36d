/* optimise/problem/family.h - families of linkages of one topology, each with a way to draw random members.
 *
 * There are two kinds. Four-link chains have linear conditions under which the input turns fully, and random members
 * meet these conditions. Any other family is given by one linkage of its topology; members are drawn step by step along
 * its plan so that they close (optimise/search/random_linkage.h).
 *
 * The conditions are those of Grashof and similar ones, written so that each is linear: a four-bar's input is the
 * shortest link and turns fully exactly if each sum of r2 and one other link is at most the sum of the remaining two.
 * An absolute value of an offset becomes two rows. */
#ifndef LW_OPTIMISE_PROBLEM_FAMILY_H
#define LW_OPTIMISE_PROBLEM_FAMILY_H

#include "mbs/plan/types.h"
#include "optimise/task/specification.h"

#define LW_SHAPE_MAX 4
#define LW_DRAW_MAX  4

typedef struct lw_family {
    const char *name;                    /* "crank-rocker"                                         */
    const char *type;                    /* row of lw_type_table, by letters; NULL: any linkage    */
    bool        turns;                   /* the linear conditions make the input turn fully        */
    bool        drag_link;               /* turns, but the input is not the shortest link          */
    const char *shape[LW_SHAPE_MAX + 1]; /* dimensions that fix the shape up to its size; cx, cy   */
    const char *linear[4];               /* conditions >= 0, "+r3+r4-r1-r2"                        */
    int         blocks;                  /* jobs in each round of the search                       */
    int         n_draw;                  /* how many numbers in [0, 1) a draw uses                 */
    void      (*draw)(const double *u, double *shape);   /* draw a member of size about one        */
    const lw_linkage *linkage;           /* any linkage: one input, tracer 0 is the point that is fitted  */
    bool        posture;                 /* also start from the dimensions of `linkage` itself     */
    int         links;                   /* of the whole mechanism; 0: four                        */
} lw_family;

extern const lw_family lw_family_table[];             /* ends with name == NULL                    */

/* A linkage with the topology of the family. For a function the tracer's angle is the output. */
void lw_family_linkage(const lw_family *f, lw_task task, lw_linkage *linkage);

const char *lw_family_title(const lw_family *f);        /* "four-bar"; of any linkage its name    */
const char *lw_family_type(const lw_family *f);         /* "fourbar"                               */

#endif
