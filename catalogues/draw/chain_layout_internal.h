/* catalogues/draw/chain_layout_internal.h - the steps of a layout: embedding (chain_embedding.c), map of joints, first
 * places, relaxing (chain_web.c). */
#ifndef LW_CATALOGUES_DRAW_CHAIN_LAYOUT_INTERNAL_H
#define LW_CATALOGUES_DRAW_CHAIN_LAYOUT_INTERNAL_H

#include "catalogues/draw/chain_layout.h"

#define LW_DART_MAX   (2*LW_JOINT_MAX)
#define LW_WEB_VERTEX (LW_JOINT_MAX + LW_LINK_MAX)
#define LW_WEB_EDGE   (2*LW_JOINT_MAX + LW_LINK_MAX)
#define LW_WEB_GROUP  64

/* Order of joints around every link.  Dart 2j leaves link[0] of joint j, dart 2j + 1 its link[1]; a dart's
 * other side is dart ^ 1.  after[d]: the dart that follows d around its link. */
typedef struct lw_rings {
    int     n_link, n_dart;
    uint32_t axes;                   /* bits of links that are axes of multiple joints: points, all their joints in one */
    uint8_t link[LW_DART_MAX];
    uint8_t after[LW_DART_MAX];
} lw_rings;

/* Number of loops (faces) of an embedding; loop_of (n_dart) may be NULL. To follow the loop of a dart, go over its
 * joint and leave the link there by the next dart. */
int lw_rings_loops(const lw_rings *r, uint8_t *loop_of);

/* A picture to draw: the order of joints around each link, and the dart at which the outer loop is entered.  With a
 * ground, that dart arrives at the ground, whose joints are then read from the dart after it. */
typedef struct lw_embedding {
    lw_rings rings;
    uint8_t  outer;
    int      n_loop, n_outer, symmetry;
    uint64_t hash;
    double   promise;                /* smaller values are tried first */
} lw_embedding;

/* Find the embeddings of the planar chain m (axes: as in lw_rings) with their outer loops, each once up to symmetry, the most promising first;
 * *n_embedding of them, at most `capacity`.  LW_NOTHING: the graph is not planar. */
lw_status lw_embeddings_find(const lw_mechanism *m, uint32_t axes, int capacity, lw_embedding *embedding, int *n_embedding);

/* The automorphisms of the map that keep its outer loop: to[g][dart]; mirror[g] when they turn it over;
 * the first is the identity; n of them, at most LW_WEB_GROUP. */
typedef struct lw_layout_symmetry {
    int     n;
    uint8_t to[LW_WEB_GROUP][LW_DART_MAX];
    bool    mirror[LW_WEB_GROUP];
} lw_layout_symmetry;
void lw_embedding_symmetry(const lw_mechanism *m, const lw_embedding *w, lw_layout_symmetry *g);

/* The map of joints: vertices are joints and free ends; edges bars and sides of polygons. */
typedef struct lw_web {
    int     n_vertex, n_edge;
    uint8_t vertex_of[LW_JOINT_MAX], end_of[LW_LINK_MAX];
    uint8_t edge[LW_WEB_EDGE][2], edge_link[LW_WEB_EDGE];
    int     n_face, face_first[LW_DART_MAX + LW_LINK_MAX + 1];
    uint8_t face[3*LW_DART_MAX];         /* vertices of loops and polygons; the outer loop is face 0     */
    int     n_ground;
    uint8_t ground[LW_LINK_MAX];         /* vertices on the line, from left to right                     */
    int     n_link;                      /* links as lists of vertices, the ground left out              */
    int     link_first[LW_LINK_MAX + 1];
    uint8_t link[2*LW_JOINT_MAX + LW_LINK_MAX];
    int     n_group;                     /* symmetries: p[to[v]] = turn p[v], mirrored first when mirror */
    uint8_t to[LW_WEB_GROUP][LW_WEB_VERTEX];
    bool    mirror[LW_WEB_GROUP];
    lw_vec2 turn[LW_WEB_GROUP];
} lw_web;

void lw_web_make(const lw_mechanism *m, const lw_embedding *embedding, lw_web *w);

/* First places p (n_vertex), no crossing.  LW_E_MEMORY. */
lw_status lw_web_start(const lw_web *w, lw_vec2 *p);

/* Wanted distances in the map, computed once; scale = 1/length^2. */
typedef struct lw_layout_spring { uint8_t a, b; double length, scale, weight; } lw_layout_spring;
typedef struct lw_relax {
    int        n_spring, n_corner;
    uint32_t   ghost;                    /* bits of links whose sides repel nothing */
    lw_layout_spring *spring;
    uint8_t  (*corner)[3];               /* joint, and the other ends of two sides that meet in it */
    double    *number;                   /* scratch of the descent               */
} lw_relax;
lw_status lw_relax_make(const lw_web *w, lw_relax *r);
void      lw_relax_free(lw_relax *r);

/* Descend in energy from the places p; no crossing appears or disappears.  Returns the energy. */
double lw_relax_run(const lw_web *w, const lw_relax *r, int steps, lw_vec2 *p);

#endif
