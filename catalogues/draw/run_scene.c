/* catalogues/draw/run_scene.c - postures of a run -> places of links, paths of tracers, lines of elastic links. */
#include "catalogues/draw/run_scene.h"

#include <stdlib.h>
#include "base/real.h"
#include "base/vec2.h"
#include "mbs/elastic/superelement.h"

typedef struct run {
    const lw_system *sys;
    const lw_elastic_expansion *elastic;    /* NULL: none */
    size_t           n;
    const double    *q;                     /* (n) postures */
    double          *start;                 /* the posture of the file */
    lw_scene        *scene;
} run;

static const double *posture(const run *r, size_t frame) { return r->q + frame*(size_t)r->sys->n_q; }

/* The frame of a link in posture q: its body's; of an elastic link that of the line between its ends. */
static lw_place place_of(const run *r, int link, const double *q)
{
    const lw_system *sys = r->sys;
    const lw_elastic_expansion *x = r->elastic;
    int b = sys->body[link];
    for (int c = 0; x && c < x->n_chain; c++)
        if (x->chain[c].link == link) {
            int last = sys->body[x->chain[c].node[x->chain[c].n_bound - 1]];
            lw_vec2 from = lw_system_point(sys, b, lw_v2(0, 0), q), d = lw_v2_sub(lw_system_point(sys, last, lw_v2(0, 0), q), from);
            return (lw_place){ from, lw_v2_scale(d, 1/lw_v2_norm(d)) };
        }
    return b < 0 ? (lw_place){ { 0, 0 }, { 1, 0 } }
                 : (lw_place){ lw_system_point(sys, b, lw_v2(0, 0), q), lw_v2_polar(1, q[3*b + 2]) };
}

/* Use the postures as the frames of the scene. */
static bool set_frames(const run *r)
{
    lw_scene *s = r->scene;
    size_t links = (size_t)s->linkage.n_link;
    free(s->place);
    free(s->input);
    s->place = calloc(r->n*links + 1, sizeof *s->place);
    s->input = calloc(r->n + 1, sizeof *s->input);
    s->n_frame = r->n;
    s->first_frame = 0;
    s->loops = true;
    s->note[0] = '\0';
    for (size_t l = 0; s->place && l < links; l++) {
        lw_place first = place_of(r, (int)l, r->start);
        s->origin[l] = first.at;
        for (size_t i = 0; i < r->n; i++) {
            lw_place now = place_of(r, (int)l, posture(r, i));
            s->place[i*links + l] = (lw_place){ now.at, lw_v2_unturn(now.turn, first.turn) };
        }
    }
    return s->place && s->input;
}

/* The paths of the tracers in these frames, in place of those that they have for all inputs. */
static bool set_paths(const run *r)
{
    lw_scene *s = r->scene;
    while (s->n_curve > 0)
        free(s->curve[--s->n_curve].p);
    for (int t = 0; t < s->linkage.n_tracer && s->n_curve < s->max_curve; t++) {
        lw_vec2 *p = calloc(r->n + 1, sizeof *p);
        if (!p)
            return false;
        for (size_t i = 0; i < r->n; i++)
            p[i] = lw_system_point(r->sys, r->sys->tracer_body[t], r->sys->tracer_arm[t], posture(r, i));
        s->curve[s->n_curve++] = (lw_curve){ .tracer = t, .shown_branch = true, .n = r->n, .p = p };
    }
    return true;
}

/* Points along a chain of nodes in posture q: cubics between nodes, whose slopes there turn with the nodes from the posture q0 of the file. */
static void bend_at(const lw_system *sys, const int *node, int n, const double *q0, const double *q, int parts, lw_vec2 *p)
{
    for (int i = 0; i + 1 < n; i++) {
        lw_vec2 at[2], slope[2], first[2];
        for (int end = 0; end < 2; end++) {
            int b = sys->body[node[i + end]];
            at[end] = lw_system_point(sys, b, lw_v2(0, 0), q);
            first[end] = lw_system_point(sys, b, lw_v2(0, 0), q0);
        }
        lw_vec2 way = lw_v2_sub(at[1], at[0]);
        for (int end = 0; end < 2; end++) {
            int b = sys->body[node[i + end]];
            slope[end] = lw_v2_sub(lw_v2_turn(lw_v2_sub(first[1], first[0]), lw_v2_polar(1, q[3*b + 2] - q0[3*b + 2])), way);
        }
        for (int j = 0; j <= parts; j++) {
            double u = (double)j/parts, v = 1 - u;
            p[i*parts + j] = lw_v2_add(lw_v2_add(at[0], lw_v2_scale(way, u)), lw_v2_sub(lw_v2_scale(slope[0], u*v*v), lw_v2_scale(slope[1], u*u*v)));
        }
    }
}

/* A line through nodes in all frames. */
static bool add_bend(const run *r, int link, const int *node, int n)
{
    int parts = 1 + 16/n, points = parts*(n - 1) + 1;
    lw_bent_bar *b = &r->scene->bend[r->scene->n_bend++];
    *b = (lw_bent_bar){ link, points, calloc(r->n*(size_t)points + 1, sizeof *b->p) };
    for (size_t i = 0; b->p && i < r->n; i++)
        bend_at(r->sys, node, n, r->start, posture(r, i), parts, b->p + i*(size_t)points);
    return b->p != NULL;
}

/* The edges of the mesh of a superelement in all frames. */
static bool add_mesh(const run *r, const lw_elastic_chain *k, const lw_superelement *mesh)
{
    int (*edge)[2], n = lw_super_edges(k->n_bound, mesh->n, mesh->at, mesh->stiffness, &edge);
    bool room = n >= 0;
    for (int i = 0; room && i < n; i++)
        room = add_bend(r, k->link, (int[]){ k->node[edge[i][0]], k->node[edge[i][1]] }, 2);
    free(edge);
    return room;
}

/* The shapes of elastic links in all frames. */
static bool set_bends(const run *r)
{
    const lw_elastic_expansion *x = r->elastic;
    size_t most = 1;
    for (int c = 0; x && c < x->n_chain; c++)
        most += x->chain[c].elastic->n_node ? (size_t)x->chain[c].n_bound*(size_t)x->chain[c].n_bound/2 : 1;
    r->scene->bend = calloc(most, sizeof *r->scene->bend);
    bool room = r->scene->bend != NULL;
    for (int c = 0; room && x && c < x->n_chain; c++) {
        const lw_elastic_chain *k = &x->chain[c];
        room = k->elastic->n_node ? add_mesh(r, k, &x->model.super[k->first_beam]) : add_bend(r, k->link, k->node, k->n_bound);
    }
    return room;
}

lw_status lw_scene_of_run(const lw_model *m, const lw_dynamics *d, size_t n, const double *q, lw_scene *scene, lw_error *e)
{
    run r = { lw_dynamics_system(d), lw_dynamics_elastic(d), n, q, NULL, scene };
    lw_status s = lw_scene_make_any(&m->linkage, m, NULL, NULL, scene, e);
    if (s != LW_OK)
        return s;
    r.start = calloc((size_t)r.sys->n_q + 1, sizeof *r.start);
    scene->model = m;
    if (r.start)
        lw_system_posture(r.sys, r.start);
    if (!r.start || !set_frames(&r) || !set_paths(&r) || !set_bends(&r))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(r.start);
    return s;
}
