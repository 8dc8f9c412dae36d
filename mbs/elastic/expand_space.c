/* mbs/elastic/expand_space.c - elastic links of a spatial model as chains of nodes. */
#include "mbs/elastic/expand_space.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/elastic/superelement.h"

typedef struct work {
    const lw_spatial     *m;
    lw_spatial_expansion *x;
    lw_elastic_axis      *full;      /* per chain that is condensed: all nodes; the chain's axis has those that are kept */
    bool                  in_time;
    lw_vec3               from;      /* a place of the chain being filled */
    lw_spatial_body       whole;     /* of its parts: mass, first moment and inertia about that place */
} work;

/* Places of the link at which something acts: joints, tracers, ends of springs, forces. */
static lw_status find_places(const lw_spatial *m, int link, lw_elastic_places *p, lw_error *e)
{
    *p = (lw_elastic_places){ .at = calloc((size_t)(m->n_joint + m->n_tracer + 2*m->n_spring + m->n_force) + 1, sizeof *p->at) };
    if (!p->at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int j = 0; j < m->n_joint; j++)
        if (m->joint[j].link[0] == link || m->joint[j].link[1] == link)
            p->at[p->n++] = m->joint[j].at;
    p->n_joint = p->n;
    for (int i = 0; i < m->n_tracer; i++)
        if (m->tracer[i].link == link)
            p->at[p->n++] = m->tracer[i].at;
    lw_elastic_take_loads(link, m->n_force, m->force, m->n_spring, m->spring, p);
    return LW_OK;
}

/* Keep the ends, the nodes where something acts, and those that cut the bar into pieces. */
static lw_status keep_nodes(work *w, int chain, const lw_elastic_places *at, lw_error *e)
{
    lw_elastic_axis *a = &w->x->chain[chain].axis, *full = &w->full[chain];
    const lw_elastic *p = w->x->chain[chain].elastic;
    int n = a->n_node, pieces = p->pieces > 0 ? p->pieces : n - 1;
    *full = *a;
    a->node = calloc((size_t)n, sizeof *a->node);
    if (!a->node)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    a->n_node = 0;
    for (int i = 0; i < n; i++) {
        bool kept = false;
        for (int k = 0; k <= pieces; k++)
            kept = kept || i == (k*(n - 1) + pieces/2)/pieces;
        for (int k = 0; k < at->n; k++)
            kept = kept || i == lw_elastic_axis_node(full, at->at[k]);
        for (int k = 0; k < w->m->n_force; k++) {        /* those that a line load covers */
            const lw_force *f = &w->m->force[k];
            if (f->link == w->x->chain[chain].link && (f->line == LW_LINE_EVEN || f->line == LW_LINE_VARYING)) {
                int one = lw_elastic_axis_node(full, f->at), other = lw_elastic_axis_node(full, f[1].at);
                kept = kept || (i >= one && i <= other) || (i >= other && i <= one);
            }
        }
        if (kept)
            a->node[a->n_node++] = full->node[i];
    }
    return LW_OK;
}

/* Number of nodes that carry the modes of piece i of a condensed bar: as many as are wanted, or as its inner nodes make. */
static int modal_nodes_of_piece(const work *w, int chain, int i)
{
    const lw_elastic_axis *full = &w->full[chain], *kept = &w->x->chain[chain].axis;
    int wanted = lw_elastic_modal_nodes(w->x->chain[chain].elastic), inner = 0;
    for (int k = 0; k < full->n_node; k++)
        inner += full->node[k] > kept->node[i] && full->node[k] < kept->node[i + 1];
    return inner < wanted ? inner : wanted;
}

/* The nodes of a link with its own matrices: all; or, with modes, those on which something acts, two at least, and those that carry modes. */
static lw_status plan_matrices(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = c->elastic;
    int more = lw_elastic_modal_nodes(p), n = 0, *keep = c->keep = calloc((size_t)p->n_node + 1, sizeof *keep);
    bool *kept = calloc((size_t)p->n_node, sizeof *kept);
    lw_elastic_places at = { 0 };
    lw_status s = keep && kept ? find_places(w->m, c->link, &at, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int k = 0; s == LW_OK && k < at.n; k++) {
        int best = 0;
        for (int i = 1; i < p->n_node; i++)
            best = lw_v3_norm(lw_v3_sub(p->node[i], at.at[k])) < lw_v3_norm(lw_v3_sub(p->node[best], at.at[k])) ? i : best;
        n += !kept[best];
        kept[best] = true;
    }
    int bound = n > 2 ? n : 2, wanted = more ? bound : p->n_node;
    if (s == LW_OK && more && bound + more > p->n_node)
        s = lw_error_set(e, LW_E_ARG, "the elastic link \"%s\" has %d \"modes\" in a superelement of %d inner nodes, which has %d; take fewer, or "
                         "a finer mesh", c->name, p->modes, p->n_node - bound, (p->plane ? 3 : 6)*(p->n_node - bound));
    for (; s == LW_OK && n < wanted; n++) {      /* the one farthest from those that are kept */
        double most = -1;
        int best = 0;
        for (int i = 0; i < p->n_node; i++) {
            double away = INFINITY;
            for (int k = 0; k < p->n_node; k++)
                away = kept[k] ? fmin(away, lw_v3_norm(lw_v3_sub(p->node[i], p->node[k]))) : away;
            if (!kept[i] && away > most)
                most = away, best = i;
        }
        kept[best] = true;
    }
    for (int i = 0; s == LW_OK && i < p->n_node; i++)
        if (kept[i])
            keep[c->n_node++] = i;
    c->n_bound = c->n_node;
    c->n_node += s == LW_OK ? more : 0;
    free(kept), free(at.at);
    c->node = s == LW_OK ? calloc((size_t)c->n_node, sizeof *c->node) : NULL;
    return s != LW_OK || c->node ? s : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

static lw_status plan_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    lw_elastic_places at;
    c->condensed = c->elastic->pieces > 0 || c->elastic->n_node > 0 || (w->in_time && c->elastic->consistent);
    if (c->elastic->n_node > 0)
        return plan_matrices(w, chain, e);
    lw_status s = find_places(w->m, c->link, &at, e);
    if (s == LW_OK)
        s = lw_elastic_axis_make(c->elastic, c->name, &at, &c->axis, e);
    if (s == LW_OK && c->condensed)
        s = keep_nodes(w, chain, &at, e);
    free(at.at);
    if (s != LW_OK || (s = lw_elastic_chain_take(c, e)) != LW_OK)
        return s;
    if (c->elastic->modes) {
        for (int i = 0; i + 1 < c->n_bound; i++)
            c->n_node += modal_nodes_of_piece(w, chain, i);
        int *node = realloc(c->node, (size_t)c->n_node*sizeof *node);
        if (!node)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        c->node = node;
    }
    return LW_OK;
}

/* A copy of n entries, with room for `more`; never NULL but without memory. */
static void *copy(const void *from, int n, int more, size_t size)
{
    void *to = calloc((size_t)(n + more) + 1, size);
    if (to && from && n > 0)
        memcpy(to, from, (size_t)n*size);
    return to;
}

/* The expanded model: links grow, what refers to them is copied, the rest is shared. */
static lw_status reserve(work *w, int nodes, int beams, lw_error *e)
{
    const lw_spatial *m = w->m;
    lw_spatial *to = &w->x->model;
    *to = *m;
    to->n_elastic = 0, to->elastic = NULL;
    to->body = copy(m->body, m->n_link, nodes, sizeof *m->body);
    to->joint = copy(m->joint, m->n_joint, 0, sizeof *m->joint);
    to->tracer = copy(m->tracer, m->n_tracer, 0, sizeof *m->tracer);
    to->spring = copy(m->spring, m->n_spring, 0, sizeof *m->spring);
    to->force = copy(NULL, 0, lw_elastic_spread_room(m->n_force, m->force, beams), sizeof *m->force);
    to->n_force = 0;
    to->beam = copy(NULL, 0, beams, sizeof *to->beam);
    to->super = copy(NULL, 0, beams + m->n_elastic, sizeof *to->super);
    to->states.rotor = copy(m->states.rotor, m->states.n_rotor, 0, sizeof *m->states.rotor);
    return to->body && to->joint && to->tracer && to->spring && to->force && to->beam && to->super && to->states.rotor
         ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* Axes of an element from `a` to `b`: x along it, y in the plane of the height. */
static lw_status element_axes(const lw_elastic_chain *c, lw_vec3 along, lw_mat3 *out, lw_error *e)
{
    static const double least = 1e-6;            /* sine of the angle between height and axis */
    lw_vec3 height = c->elastic->height;
    if (!(lw_v3_norm(height) > 0))
        height = lw_v3_across(along);            /* all directions are alike */
    lw_vec3 z = lw_v3_cross(along, height);
    if (!(lw_v3_norm(z) > least))
        return lw_error_set(e, LW_E_ARG, "the \"height\" of the elastic link \"%s\" lies along its axis; give a direction across it",
                            c->name);
    z = lw_v3_scale(z, 1/lw_v3_norm(z));
    *out = lw_m3_columns(along, lw_v3_cross(z, along), z);
    return LW_OK;
}

/* Add a diagonal tensor in the given axes. */
static void add_inertia(lw_spatial_body *b, const lw_mat3 *axes, const double value[3])
{
    static const int at[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++) {
            lw_vec3 c = lw_m3_column(axes, k);
            const double x[3] = { c.x, c.y, c.z };
            b->inertia[i] += value[k]*x[at[i][0]]*x[at[i][1]];
        }
}

/* Add a body with its inertia about its centre of mass to one with its first moment and its inertia about `from`. */
static void add_body(double mass, lw_vec3 place, const double inertia[6], lw_vec3 from, lw_spatial_body *to)
{
    lw_vec3 at = lw_v3_sub(place, from);
    const double about[6] = { at.y*at.y + at.z*at.z, at.x*at.x + at.z*at.z, at.x*at.x + at.y*at.y, -at.x*at.y, -at.x*at.z, -at.y*at.z };
    to->mass += mass;
    to->centre = lw_v3_add(to->centre, lw_v3_scale(at, mass));
    for (int k = 0; k < 6; k++)
        to->inertia[k] += inertia[k] + mass*about[k];
}

/* Inertia about the centre of mass of such a sum; returns the centre. */
static lw_vec3 about_centre(const lw_spatial_body *sum, lw_vec3 from, double inertia[6])
{
    lw_vec3 c = lw_v3_scale(sum->centre, 1/sum->mass);
    lw_spatial_body less = { .mass = 0 };
    add_body(-sum->mass, c, sum->inertia, lw_v3(0, 0, 0), &less);
    memcpy(inertia, less.inertia, sizeof less.inertia);
    return lw_v3_add(from, c);
}

/* Add an element as a uniform bar. */
static void add_bar(const lw_spatial *m, const lw_spatial_beam *b, lw_vec3 from, lw_spatial_body *to)
{
    lw_spatial_body bar = { .mass = b->mass };
    double length = b->length*b->length/12, iy = b->gyration[0], iz = b->gyration[1];
    add_inertia(&bar, &b->axes, (const double[]){ b->mass*(iy + iz), b->mass*(length + iy), b->mass*(length + iz) });
    add_body(b->mass, lw_v3_scale(lw_v3_add(m->body[b->link[0]].centre, m->body[b->link[1]].centre), 0.5), bar.inertia, from, to);
}

/* lw_elastic_chain.too_much */
static double too_much_inertia(const work *w, const lw_elastic_chain *c)
{
    lw_spatial_body lumped = { .mass = 0 };
    double is[6], has[6], value[3], most = 0;
    lw_mat3 axes;
    for (int i = 0; i < c->n_node; i++) {
        const lw_spatial_body *b = &w->x->model.body[c->node[i]];
        add_body(b->mass, b->centre, b->inertia, w->from, &lumped);
    }
    about_centre(&lumped, w->from, is);
    about_centre(&w->whole, w->from, has);
    lw_m3_principal(has, value, &axes);
    for (int i = 0; i < 3; i++) {
        lw_vec3 e = lw_m3_column(&axes, i);
        double now = is[0]*e.x*e.x + is[1]*e.y*e.y + is[2]*e.z*e.z + 2*(is[3]*e.x*e.y + is[4]*e.x*e.z + is[5]*e.y*e.z);
        most = value[i] > 0 ? fmax(most, now/value[i] - 1) : most;
    }
    return most;
}

/* Nodes of a chain as links without mass, at the given places. */
static lw_status fill_nodes(work *w, lw_elastic_chain *c, lw_error *e)
{
    lw_spatial *to = &w->x->model;
    int piece = -1, left = 0;                /* of its modal nodes */
    for (int i = 0; i < c->n_node; i++) {
        int link = i ? to->n_link++ : c->link;
        c->node[i] = link;
        bool modal = i >= c->n_bound;        /* at the first node of its superelement */
        while (modal && !c->elastic->n_node && left == 0)
            left = modal_nodes_of_piece(w, (int)(c - w->x->chain), ++piece);
        left -= modal;
        int at = !modal ? i : c->elastic->n_node ? 0 : piece;
        to->body[link] = (lw_spatial_body){ .given = true, .centre = c->keep ? c->elastic->node[c->keep[at]]
                                                                            : lw_elastic_axis_point(&c->axis, c->axis.node[at]) };
        if (snprintf(to->body[link].name, LW_NAME_SIZE, "%s.%d", c->name, i) >= LW_NAME_SIZE)
            return lw_error_set(e, LW_E_ARG, "the name of the elastic link \"%s\" is too long: its nodes are called \"NAME.0\", "
                                "\"NAME.1\", ...; at most %d bytes", c->name, LW_NAME_SIZE - 7);
    }
    return LW_OK;
}

static lw_status fill_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = c->elastic;
    const lw_section *q = &p->section;
    lw_spatial *to = &w->x->model;
    c->first_beam = to->n_beam;
    lw_status s = fill_nodes(w, c, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i + 1 < c->n_node; i++) {
        lw_spatial_beam *b = &to->beam[to->n_beam++];
        lw_vec3 d = lw_v3_sub(to->body[c->node[i + 1]].centre, to->body[c->node[i]].centre);
        double h = lw_v3_norm(d);
        *b = (lw_spatial_beam){ .link = { c->node[i], c->node[i + 1] }, .length = h, .damping = p->damping, .mass = p->material.density*q->area*h,
                                .gyration = { lw_section_mass_y(q), lw_section_mass_z(q) }, .consistent = p->consistent };
        if ((s = element_axes(c, lw_v3_scale(d, 1/h), &b->axes, e)) != LW_OK)
            return s;
        lw_beam_space_stiffness(q, &p->material, h, b->stiffness);
        const double half = 0.5*b->mass, inertia[3] = { half*(b->gyration[0] + b->gyration[1]), half*b->gyration[0], half*b->gyration[1] };
        add_bar(to, b, w->from, &w->whole);
        for (int end = 0; end < 2; end++) {
            to->body[b->link[end]].mass += 0.5*b->mass;
            add_inertia(&to->body[b->link[end]], &b->axes, inertia);
        }
    }
    return LW_OK;
}

/* Of a superelement: stiffness, rate and turn as lw_superelement's; mass, from which the masses of its nodes and its weight come. */
typedef struct matrices { double *stiffness, *mass, *rate, *turn; } matrices;

static void free_matrices(matrices *m)
{
    free(m->stiffness), free(m->mass), free(m->rate), free(m->turn);
}

/* A superelement between the nodes link of the model; takes the matrices over. */
static lw_status add_superelement(work *w, int n, int n_bound, const int *link, double damping, const matrices *from, lw_error *e)
{
    lw_spatial *to = &w->x->model;
    lw_superelement *p = &to->super[to->n_super++];
    double total, rigid[6], *mass = from->mass, *lump = calloc((size_t)n, sizeof *lump), *inertia = calloc(6*(size_t)n, sizeof *inertia);
    lw_vec3 centre;
    *p = (lw_superelement){ .n = n, .n_bound = n_bound, .link = calloc((size_t)n, sizeof *p->link), .at = calloc((size_t)n, sizeof *p->at),
                            .stiffness = from->stiffness, .rate = from->rate, .turn = from->turn,
                            .first = calloc(18*(size_t)n, sizeof *p->first), .lump = lump, .turning = inertia, .damping = damping };
    lw_status s = lump && inertia && p->link && p->at && p->first ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < n; i++)
        p->link[i] = link[i], p->at[i] = to->body[link[i]].centre;
    if (s == LW_OK) {
        lw_super_rigid_mass(n, p->at, mass, &total, &centre, rigid);
        add_body(total, centre, rigid, w->from, &w->whole);
        lw_super_lump(n, p->at, mass, total, centre, rigid, lump, inertia);
        for (int i = 0; i < 36*n*n; i++)
            if (i/(6*n)%6 < 3)
                p->first[i/(6*n)%6*6*n + i%(6*n)] += mass[i];
        p->beside = lw_v3_scale(lw_v3_sub(centre, p->at[0]), total);
        for (int i = 0; i < 6*n; i++) {
            lw_vec3 away = lw_v3_sub(p->at[i/6], p->at[0]);
            double along = i%6 == 0 ? away.x : i%6 == 1 ? away.y : i%6 == 2 ? away.z : 0;
            p->beside = lw_v3_sub(p->beside, lw_v3_scale(lw_v3(p->first[i], p->first[6*n + i], p->first[12*n + i]), along));
        }
        s = total > 0 ? LW_OK : lw_error_set(e, LW_E_ARG, "the mass matrix of the elastic link \"%s\" has no mass when the body moves",
                                             to->body[link[0]].name);
    }
    for (int i = 0; s == LW_OK && i < n; i++) {
        lw_spatial_body *b = &to->body[link[i]];
        b->mass += lump[i];
        for (int k = 0; k < 6; k++)
            b->inertia[k] += inertia[6*i + k];
    }
    free(mass);
    return s;
}

/* Matrices of the elements first .. last of a chain, whose nodes are links 0, 1, ... of m, condensed to its two ends and modes. */
static lw_status condense(const lw_spatial *m, int first, int last, const lw_elastic *p, int more_nodes, matrices *out)
{
    int nodes = last - first + 1, rows = 6*nodes;
    double *k = out->stiffness = calloc((size_t)rows*(size_t)rows, sizeof *k), *a = out->mass = calloc((size_t)rows*(size_t)rows, sizeof *a);
    if (!k || !a)
        return LW_E_MEMORY;
    for (int i = first; i < last; i++) {
        const lw_spatial_beam *beam = &m->beam[i];
        lw_beam_space b = { .length = beam->length, .axes = { beam->axes, beam->axes } };
        lw_beam_node node[2] = { { .at = m->body[i].centre }, { .at = m->body[i + 1].centre } };
        lw_beam_space_state z;
        double more[12][12] = { { 0 } };
        for (int side = 0; side < 2; side++)
            node[side].turn = lw_m3_columns(lw_v3(1, 0, 0), lw_v3(0, 1, 0), lw_v3(0, 0, 1));
        memcpy(b.stiffness, beam->stiffness, sizeof b.stiffness);
        lw_beam_space_at(&b, node, true, NULL, &z);
        if (p->consistent)
            lw_beam_space_mass(beam, more);
        const double half = beam->mass/2, *gyration = beam->gyration;
        const double lump[6] = { half, half, half, half*(gyration[0] + gyration[1]), half*gyration[0], half*gyration[1] };
        for (int x = 0; x < 12; x++)
            more[x][x] += lump[x%6];
        for (int x = 0; x < 12; x++)
            for (int y = 0; y < 12; y++) {
                int at = (6*(i - first) + x)*rows + 6*(i - first) + y;
                const double *row[2] = { &beam->axes.row[x%3].x, &beam->axes.row[y%3].x };
                k[at] -= 0.5*(z.by_x[x][y] + z.by_x[y][x]);
                for (int c = 0; c < 3; c++)
                    for (int d = 0; d < 3; d++)
                        a[at] += row[0][c]*more[x/3*3 + c][y/3*3 + d]*row[1][d];
            }
    }
    return lw_super_reduce(rows, k, a, 2, (const int[]){ 0, nodes - 1 }, (const lw_vec3[]){ m->body[first].centre, m->body[last].centre },
                           more_nodes, p->plane, &out->rate, &out->turn);
}

/* A bar of elements condensed to superelements between its nodes that are kept. */
static lw_status fill_pieces(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain], all = *c;
    const lw_elastic_axis *full = &w->full[chain], *kept = &c->axis;
    size_t n = (size_t)full->n_node + 1;
    int modal = c->n_bound, link[LW_SUPER_NODES];
    lw_spatial_expansion mesh = { .model = { .n_link = 1, .body = calloc(n, sizeof *mesh.model.body), .beam = calloc(n, sizeof *mesh.model.beam) },
                                  .chain = &all };
    work part = { .x = &mesh };
    all.link = 0, all.axis = *full, all.n_node = all.n_bound = full->n_node, all.node = calloc(n, sizeof *all.node);
    lw_status s = all.node && mesh.model.body && mesh.model.beam ? fill_nodes(w, c, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        s = fill_chain(&part, 0, e);
    c->first_beam = w->x->model.n_super;
    for (int i = 0, first = 0; s == LW_OK && i + 1 < kept->n_node; i++) {
        int last = first + 1;
        matrices of = { 0 };
        while (full->node[last] < kept->node[i + 1])
            last++;
        int more = modal_nodes_of_piece(w, chain, i);
        s = condense(&mesh.model, first, last, c->elastic, more, &of);
        for (int k = 0; k < 2 + more; k++)
            link[k] = c->node[k < 2 ? i + k : modal + k - 2];
        modal += more;
        if (s == LW_OK)
            s = add_superelement(w, 2 + more, 2, link, c->elastic->damping, &of, e);
        else {
            free_matrices(&of);
            lw_error_set(e, s, "the elastic link \"%s\" cannot be condensed", c->name);
        }
        if (s == LW_OK)
            for (int end = 0; end < 2; end++)
                w->x->model.super[c->first_beam + i].section[end] = mesh.model.beam[end ? last - 1 : first].axes;
        first = last;
    }
    free(all.node), free(mesh.model.body), free(mesh.model.beam);
    return s;
}

/* A superelement with its own matrices. */
static lw_status fill_matrices(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = c->elastic;
    size_t size = 36*(size_t)p->n_node*(size_t)p->n_node*sizeof(double);
    lw_vec3 centre, *at = calloc((size_t)c->n_bound, sizeof *at);
    matrices m = { .stiffness = malloc(size), .mass = malloc(size) };
    double rigid[6];
    lw_status s = m.stiffness && m.mass && at ? fill_nodes(w, c, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        memcpy(m.stiffness, p->stiffness, size);
        memcpy(m.mass, p->mass, size);
        lw_super_rigid_mass(p->n_node, p->node, m.mass, &c->mass, &centre, rigid);
    }
    for (int i = 0; s == LW_OK && i < c->n_bound; i++)
        at[i] = p->node[c->keep[i]];
    if (s == LW_OK && (s = lw_super_reduce(6*p->n_node, m.stiffness, m.mass, c->n_bound, c->keep, at,
                                           lw_elastic_modal_nodes(p), p->plane, &m.rate, &m.turn)) != LW_OK)
        lw_error_set(e, s, "the elastic link \"%s\" cannot be condensed: its stiffness does not hold the inner nodes, or their mass is not "
                     "positive definite", c->name);
    free(at);
    if (s == LW_OK)
        return add_superelement(w, c->n_node, c->n_bound, c->node, p->damping, &m, e);
    free_matrices(&m);
    return s;
}

static int node_for(const lw_spatial_expansion *x, int link, lw_vec3 at) { return lw_elastic_chain_node(x->chain, x->n_chain, link, at); }

static void attach(lw_spatial_expansion *x)
{
    lw_spatial *to = &x->model;
    for (int i = 0; i < to->states.n_rotor; i++)
        to->states.rotor[i].link = node_for(x, to->states.rotor[i].link, to->joint[to->states.rotor[i].joint].at);
    for (int j = 0; j < to->n_joint; j++)
        for (int end = 0; end < 2; end++)
            to->joint[j].link[end] = node_for(x, to->joint[j].link[end], to->joint[j].at);
    for (int i = 0; i < to->n_tracer; i++)
        to->tracer[i].link = node_for(x, to->tracer[i].link, to->tracer[i].at);
    lw_elastic_attach(x->chain, x->n_chain, to->n_force, to->force, to->n_spring, to->spring);
}

lw_status lw_spatial_expand(const lw_spatial *m, bool in_time, lw_spatial_expansion *x, lw_error *e)
{
    size_t n = (size_t)m->n_elastic + 1;
    *x = (lw_spatial_expansion){ .chain = calloc(n, sizeof *x->chain) };
    work w = { .m = m, .x = x, .full = calloc(n, sizeof *w.full), .in_time = in_time };
    int more = 0;
    lw_status s = x->chain && w.full ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int l = 0; s == LW_OK && l < m->n_link; l++) {
        if (!m->elastic[l].given)
            continue;
        x->chain[x->n_chain] = (lw_elastic_chain){ .link = l, .name = m->body[l].name, .elastic = &m->elastic[l] };
        s = plan_chain(&w, x->n_chain++, e);
        more += x->chain[x->n_chain - 1].n_node - 1;
    }
    if (s == LW_OK)
        s = reserve(&w, more, more, e);
    for (int k = 0; s == LW_OK && k < x->n_chain; k++) {
        w.whole = (lw_spatial_body){ .mass = 0 };
        w.from = x->chain[k].elastic->n_node > 0 ? x->chain[k].elastic->node[0] : lw_elastic_axis_point(&x->chain[k].axis, 0);
        s = x->chain[k].elastic->n_node > 0 ? fill_matrices(&w, k, e) : x->chain[k].condensed ? fill_pieces(&w, k, e)
          : fill_chain(&w, k, e);
        if (s == LW_OK && !x->chain[k].condensed)
            x->chain[k].too_much = too_much_inertia(&w, &x->chain[k]);
    }
    if (s == LW_OK)
        s = lw_elastic_spread(x->chain, x->n_chain, m->n_force, m->force, &x->own, x->model.force, &x->model.n_force, e);
    if (s == LW_OK)
        attach(x);
    for (int k = 0; w.full && k < m->n_elastic; k++)
        free(w.full[k].node);
    free(w.full);
    return s;
}

void lw_spatial_expansion_free(lw_spatial_expansion *x)
{
    lw_elastic_chains_free(x->chain, x->n_chain);
    for (int k = 0; k < x->model.n_super; k++)
        lw_superelement_free(&x->model.super[k]);
    void *const own[] = { x->model.super, x->model.body, x->model.joint, x->model.tracer, x->model.spring, x->model.force,
                          x->model.beam, x->model.states.rotor };
    for (size_t i = 0; i < sizeof own/sizeof *own; i++)
        free(own[i]);
    lw_expression_list_free(&x->own);
    memset(x, 0, sizeof *x);
}

/* ---- rigid ----------------------------------------------------------------------------------------------- */

/* Each element is a uniform bar. */
static void join(const lw_spatial_expansion *x, const lw_elastic_chain *c, lw_spatial_body *b)
{
    const lw_spatial *m = &x->model;
    char name[LW_NAME_SIZE];
    memcpy(name, b->name, sizeof name);
    *b = (lw_spatial_body){ .given = true };
    memcpy(b->name, name, sizeof name);
    if (c->elastic->n_node > 0) {
        lw_super_rigid_mass(c->elastic->n_node, c->elastic->node, c->elastic->mass, &b->mass, &b->centre, b->inertia);
        return;
    }
    lw_spatial_body sum = { .mass = 0 };
    lw_vec3 from = m->body[c->node[0]].centre;
    for (int i = 0; i + 1 < c->n_node; i++)
        add_bar(m, &m->beam[c->first_beam + i], from, &sum);
    b->mass = sum.mass;
    b->centre = about_centre(&sum, from, b->inertia);
}

lw_status lw_spatial_rigid(const lw_spatial *m, lw_spatial *rigid, lw_error *e)
{
    lw_spatial_expansion x = { 0 };
    *rigid = *m;
    rigid->n_elastic = 0, rigid->elastic = NULL;
    rigid->body = copy(m->body, m->n_link, 0, sizeof *m->body);
    if (!rigid->body)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_spatial bars = *m;                    /* condensed bars count as what they are condensed from */
    bars.elastic = copy(m->elastic, m->n_link, 0, sizeof *m->elastic);
    for (int i = 0; bars.elastic && i < m->n_link; i++)
        bars.elastic[i].pieces = bars.elastic[i].modes = 0;
    lw_status s = bars.elastic ? lw_spatial_expand(&bars, false, &x, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int k = 0; s == LW_OK && k < x.n_chain; k++)
        join(&x, &x.chain[k], &rigid->body[x.chain[k].link]);
    lw_spatial_expansion_free(&x);
    free(bars.elastic);
    if (s != LW_OK)
        lw_spatial_rigid_free(rigid);
    return s;
}

void lw_spatial_rigid_free(lw_spatial *rigid)
{
    free(rigid->body);
    memset(rigid, 0, sizeof *rigid);
}
