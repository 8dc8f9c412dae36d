/* mbs/elastic/expand.h - elastic links of a model as chains of nodes and beam elements.
 *
 * An elastic link becomes n elements between n + 1 nodes, which are links with lumped masses: half the mass of each element
 * and half of its rotary inertia rho I h at either end.  Joints, tracers, springs and forces of the link act on the node at
 * their place; beside the axis, through a rigid arm from the nearest point of it; a load along a line on the nodes that it
 * covers.  All other links, joints, tracers and inputs keep their indices, so expressions stay valid; node 0 of a link has the index of the link. */
#ifndef LW_MBS_ELASTIC_EXPAND_H
#define LW_MBS_ELASTIC_EXPAND_H

#include "grammar/model/model.h"
#include "mbs/elastic/axis.h"

typedef struct lw_elastic_chain {
    int    link;                     /* of the model */
    const lw_elastic *elastic;       /* the model's */
    int    n_node, *node;            /* links of the expanded model, along the axis */
    int    n_bound;                  /* condensed: of the nodes, how many are places; those behind them carry modes */
    int    first_beam;               /* element i is between nodes i and i + 1: beam[first_beam + i]; of a condensed bar super[] */
    bool   condensed;                /* superelements between the nodes instead (in space) */
    double length, mass;             /* [m] [kg] */
    double frequency;                /* up to which elements chosen by themselves are good to 1 %; 0: their number was given [Hz] */
    double first;                    /* first bending frequency with hinged ends (Euler & Bernoulli) [Hz] */
    double too_much;                 /* how much the inertia of the lumped nodes exceeds that of the rigid link about its centre of mass, in
                                        the direction where it does most, as a share of it: 2/n^2 of a straight bar of n elements; 0 if condensed */
} lw_elastic_chain;

typedef struct lw_expression_list { int n; lw_expression **x; } lw_expression_list;

typedef struct lw_elastic_expansion {
    lw_model model;                  /* shares expressions and names with the model it comes from, which must outlive it */
    int      n_chain;
    lw_elastic_chain *chain;
    lw_expression_list own;          /* of loads that are spread over elements */
} lw_elastic_expansion;

/* LW_E_ARG: an axis that does not follow from the joints, or has no length (the link is named).  x needs
 * lw_elastic_expansion_free, after a failure too. */
lw_status lw_elastic_expand(const lw_model *m, lw_elastic_expansion *x, lw_error *e);
void      lw_elastic_expansion_free(lw_elastic_expansion *x);

/* The same model with its elastic links as rigid bars of the same mass; *rigid needs lw_elastic_rigid_free. */
lw_status lw_elastic_rigid(const lw_model *m, lw_model *rigid, lw_error *e);
void      lw_elastic_rigid_free(lw_model *rigid);

/* Make *x the mix of two expressions (lw_expression_mix); the list owns it. */
lw_status lw_expression_list_mix(lw_expression_list *list, const double weight[2], lw_expression *const of[2], lw_expression **x, lw_error *e);
void      lw_expression_list_free(lw_expression_list *list);

/* Why lw_elastic_line_pushes refuses. */
lw_status lw_elastic_line_off_axis(const char *force, const char *link, lw_error *e);

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
