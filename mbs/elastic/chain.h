/* mbs/elastic/chain.h - an elastic link as a chain of nodes, in the plane or in space, and what both expansions need. */
#ifndef LW_MBS_ELASTIC_CHAIN_H
#define LW_MBS_ELASTIC_CHAIN_H

#include "grammar/functions/expression.h"
#include "mbs/elastic/axis.h"

typedef struct lw_elastic_chain {
    int    link;                     /* of the model */
    const lw_elastic *elastic;       /* the model's */
    int    n_node, *node;            /* links of the expanded model, along the axis */
    int    n_bound;                  /* of the nodes, how many are places; those behind them carry modes of superelements */
    int    first_beam;               /* element i is between nodes i and i + 1: beam[first_beam + i]; of a condensed bar super[] */
    bool   condensed;                /* superelements between the nodes instead */
    double length, mass;             /* [m] [kg] */
    double frequency;                /* up to which elements chosen by themselves are good to 1 %; 0: their number was given [Hz] */
    double first;                    /* first bending frequency with hinged ends (Euler & Bernoulli) [Hz] */
    double too_much;                 /* how much the inertia of the lumped nodes exceeds that of the rigid link about its centre of mass, in
                                        the direction where it does most, as a share of it: 2/n^2 of a straight bar of n elements; 0 if condensed */
} lw_elastic_chain;

typedef struct lw_expression_list { int n; lw_expression **x; } lw_expression_list;

/* Make *x the mix of two expressions (lw_expression_mix); the list owns it. */
lw_status lw_expression_list_mix(lw_expression_list *list, const double weight[2], lw_expression *const of[2], lw_expression **x, lw_error *e);
void      lw_expression_list_free(lw_expression_list *list);

/* Why lw_elastic_line_pushes refuses. */
lw_status lw_elastic_line_off_axis(const char *force, const char *link, lw_error *e);
lw_status lw_elastic_line_on_nodes(const char *force, const char *link, lw_error *e);      /* of a link with its own matrices */

/* Number of nodes that carry the modes of a superelement: six modes each; in the plane three, along x and y and about z. */
int lw_elastic_modal_nodes(const lw_elastic *p);

/* Which of these n chains is that of the link; n: it is not elastic. */
int lw_elastic_chain_of(const lw_elastic_chain *chain, int n, int link);

/* Copy the data of the axis into the chain, and allocate its nodes. */
lw_status lw_elastic_chain_take(lw_elastic_chain *c, const lw_elastic_axis *a, lw_error *e);

/* Greatest stress of a section under tension and bending moment, N/A + |M| y/I [N/m^2], of the greater absolute value; NAN
 * without its height. */
double lw_section_stress(const lw_section *s, double normal, double moment);

/* The same with bending moments about y and z, NAN without height or width; shear and torsion are not in it. */
double lw_section_stress_space(const lw_section *s, double normal, double about_y, double about_z);

#endif
