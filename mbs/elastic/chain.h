/* mbs/elastic/chain.h - an elastic link as a chain of nodes, in the plane or in space, and what both expansions need. */
#ifndef LW_MBS_ELASTIC_CHAIN_H
#define LW_MBS_ELASTIC_CHAIN_H

#include "grammar/model/model.h"
#include "mbs/elastic/axis.h"

typedef struct lw_elastic_chain {
    int    link;                     /* of the model */
    const char *name;                /* of the link, the model's */
    const lw_elastic *elastic;       /* the model's */
    lw_elastic_axis axis;            /* with the nodes that are kept; none of a link with its own matrices */
    int   *keep;                     /* of those: which of the nodes are places (n_bound), ascending */
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

void      lw_expression_list_free(lw_expression_list *list);

/* Number of nodes that carry the modes of a superelement: six modes each; in the plane three, along x and y and about z. */
int lw_elastic_modal_nodes(const lw_elastic *p);

/* The node of an elastic link nearest along the axis to `at`; a link without a chain among these n stays. */
int lw_elastic_chain_node(const lw_elastic_chain *chain, int n, int link, lw_vec3 at);

/* Add the places of the forces, except torques, and of the ends of springs of a link; p->at has room. */
void lw_elastic_take_loads(int link, int n_force, const lw_force *force, int n_spring, const lw_spring *spring, lw_elastic_places *p);

/* Number of forces that these make when their lines are spread over a model of n_beam elements. */
int lw_elastic_spread_room(int n_force, const lw_force *force, int n_beam);

/* Append copies of the forces to to[*n_to]: line loads of elastic links on the nodes that they cover, with expressions that `own` owns.
 * LW_E_ARG: the line is not on a straight part of the axis, or its link has matrices of its own (force and link are named). */
lw_status lw_elastic_spread(const lw_elastic_chain *chain, int n, int n_force, const lw_force *force, lw_expression_list *own, lw_force *to,
                            int *n_to, lw_error *e);

/* Let forces that are not spread, and springs, act on the nodes at their places. */
void lw_elastic_attach(const lw_elastic_chain *chain, int n, int n_force, lw_force *force, int n_spring, lw_spring *spring);

/* Copy the data of the axis into the rest of the chain, and allocate its nodes. */
lw_status lw_elastic_chain_take(lw_elastic_chain *c, lw_error *e);
void      lw_elastic_chains_free(lw_elastic_chain *chain, int n);

/* Greatest stress of a section under tension and bending moment, N/A + |M| y/I [N/m^2], of the greater absolute value; NAN
 * without its height. */
double lw_section_stress(const lw_section *s, double normal, double moment);

/* The same with bending moments about y and z, NAN without height or width; shear and torsion are not in it. */
double lw_section_stress_space(const lw_section *s, double normal, double about_y, double about_z);

#endif
