/* Pictures of chains: no crossing on all planar chains up to ten links, measured here again from the
 * places alone; distances, angles, symmetry; frames on a line; chains that are not planar. */
#include "catalogues/draw/chain_layout_internal.h"
#include "enumerate/multiple.h"
#include "grammar/topology/planar.h"
#include "tests/all_chains.h"
#include "tests/check.h"

/* ---- a second look at a layout, by exact signs and sampled areas -------------------------------- */

typedef struct shape { int n; lw_vec2 p[LW_LINK_MAX]; int joint[LW_LINK_MAX]; } shape;

static shape shape_of(const lw_chain_layout *l, int link)
{
    shape s = { 0 };
    for (int k = l->first[link]; k < l->first[link + 1]; k++) {
        s.joint[s.n] = l->ring[k];
        s.p[s.n++] = l->at[l->ring[k]];
    }
    if (s.n == 1) {
        s.joint[1] = -1 - link;
        s.p[s.n++] = l->end[link];
    }
    return s;
}

static double side_of(lw_vec2 a, lw_vec2 b, lw_vec2 c)
{
    return lw_v2_cross(lw_v2_sub(b, a), lw_v2_sub(c, a));
}

static bool in_shape(const shape *s, lw_vec2 q)                             /* winding number */
{
    double turn = 0;
    for (int i = 0; i < s->n; i++) {
        lw_vec2 a = lw_v2_sub(s->p[i], q), b = lw_v2_sub(s->p[(i + 1) % s->n], q);
        turn += atan2(lw_v2_cross(a, b), lw_v2_dot(a, b));
    }
    return s->n > 2 && fabs(turn) > LW_PI;
}

static bool far_apart(const shape *s, const shape *t)
{
    double s0 = 1e9, s1 = -1e9, t0 = 1e9, t1 = -1e9, u0 = 1e9, u1 = -1e9, v0 = 1e9, v1 = -1e9;
    for (int i = 0; i < s->n; i++) {
        s0 = fmin(s0, s->p[i].x), s1 = fmax(s1, s->p[i].x);
        u0 = fmin(u0, s->p[i].y), u1 = fmax(u1, s->p[i].y);
    }
    for (int i = 0; i < t->n; i++) {
        t0 = fmin(t0, t->p[i].x), t1 = fmax(t1, t->p[i].x);
        v0 = fmin(v0, t->p[i].y), v1 = fmax(v1, t->p[i].y);
    }
    return s1 < t0 || t1 < s0 || u1 < v0 || v1 < u0;
}

/* Do two links cross?  Points along the outline of one that lie in the other, and sides that cut sides. */
static bool overlap(const shape *s, const shape *t)
{
    for (int i = 0; i < (s->n > 2 ? s->n : 1) && !far_apart(s, t); i++) {
        lw_vec2 a = s->p[i], b = s->p[(i + 1) % s->n];
        for (int k = 1; k < 20; k++)
            if (in_shape(t, lw_v2_add(a, lw_v2_scale(lw_v2_sub(b, a), k/20.0))))
                return true;
        for (int j = 0; j < (t->n > 2 ? t->n : 1); j++) {
            lw_vec2 c = t->p[j], d = t->p[(j + 1) % t->n];
            if (side_of(a, b, c)*side_of(a, b, d) < -1e-12 && side_of(c, d, a)*side_of(c, d, b) < -1e-12)
                return true;
        }
    }
    return false;
}

static int count_overlaps(const lw_mechanism *m, const lw_chain_layout *l)
{
    int n = 0;
    for (int i = 0; i < m->n_link; i++)
        for (int k = 0; k < i; k++) {
            shape s = shape_of(l, i), t = shape_of(l, k);
            n += i != m->ground && k != m->ground && (overlap(&s, &t) || overlap(&t, &s));
        }
    return n;
}

/* Every joint stands in the rings of its two links, once. */
static void check_rings(const lw_mechanism *m, const lw_chain_layout *l)
{
    CHECK_INT(l->first[m->n_link], 2*m->n_joint);
    for (int i = 0; i < m->n_link; i++) {
        uint64_t seen = 0;
        for (int k = l->first[i]; k < l->first[i + 1]; k++) {
            int j = l->ring[k];
            CHECK(j < m->n_joint && (m->link[j][0] == i || m->link[j][1] == i) && !(seen >> j & 1));
            seen |= (uint64_t)1 << j;
        }
    }
}

static void check_ground(const lw_mechanism *m, const lw_chain_layout *l)
{
    double last = -1e9;
    for (int k = l->first[m->ground]; k < l->first[m->ground + 1]; k++) {
        lw_vec2 p = l->at[l->ring[k]];
        CHECK_NEAR(p.y, 0, 1e-12, 0);
        CHECK(p.x > last);
        last = p.x;
    }
    for (int j = 0; j < m->n_joint; j++) {
        bool on_line = m->link[j][0] == m->ground || m->link[j][1] == m->ground;
        for (int k = l->first[m->ground]; k < l->first[m->ground + 1]; k++)    /* the pin of a block */
            on_line = on_line || (l->at[j].x == l->at[l->ring[k]].x && l->at[j].y == 0);
        CHECK(on_line || l->at[j].y > 0.1);
    }
}

typedef struct worst { int n, n_planar, n_cross; double angle, gap; } worst;

static void look_at(const lw_mechanism *m, worst *w)
{
    lw_chain_layout l;
    uint32_t mask[LW_LINK_MAX] = { 0 };
    lw_chain c;
    bool planar;
    CHECK_OK(lw_chain_layout_make(m, &l, &check_error));
    lw_mechanism_chain(m, &c);
    for (int i = 0; i < m->n_link; i++)
        mask[i] = lw_chain_neighbours(&c, i);
    CHECK_INT(lw_planar_test(m->n_link, mask, &planar), LW_OK);
    CHECK_INT(l.planar, planar);
    int n_cross = count_overlaps(m, &l);
    CHECK_INT(l.n_cross, n_cross);
    if (planar)
        CHECK_INT(n_cross, 0);
    check_rings(m, &l);
    if (m->ground != LW_NONE)
        check_ground(m, &l);
    w->n++;
    w->n_planar += planar;
    w->n_cross += n_cross;
    w->angle = fmin(w->angle, l.least_angle);
    w->gap = fmin(w->gap, l.least_gap);
}

/* Every `step`-th chain. */
static worst look_at_all(int n_link, int dof, int step, bool grounded)
{
    chain_list list = all_chains(n_link, dof);
    worst w = { .angle = 9, .gap = 9 };
    for (int i = 0; i < list.n; i += step)
        for (int g = grounded ? 0 : LW_NONE; g < (grounded ? n_link : 0); g++) {
            lw_mechanism m;
            lw_mechanism_from_chain(&list.chain[i], &m);
            m.ground = g;
            look_at(&m, &w);
        }
    free(list.chain);
    return w;
}

/* ---- tests -------------------------------------------------------------------------------------- */

/* Least angle [degrees] and gap are what the method reaches, which draws with symmetry where it can; a bar is 1 long. */
static const struct { int n_link, dof, n_chain, n_planar, n_cross; double angle, gap; } known[] = {
    {  4, 1,   1,   1,  0, 89, 0.99 }, {  6, 1,  2,  2,  0,  45, 0.55 }, { 8, 1, 16, 16, 0, 21, 0.35 },
    { 10, 1, 230, 219, 11, 12, 0.31 }, {  5, 2,  1,  1,  0, 107, 0.99 }, { 7, 2,  3,  3, 0, 46, 0.62 },
    {  9, 2,  35,  35,  0, 35, 0.37 }, {  8, 3,  5,  5,  0,  45, 0.55 },
};

TEST(all_chains_up_to_ten_links)
{
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        worst w = look_at_all(known[i].n_link, known[i].dof, 1, false);
        CHECK_INT(w.n, known[i].n_chain);
        CHECK_INT(w.n_planar, known[i].n_planar);
        CHECK_INT(w.n_cross, known[i].n_cross);
        CHECK(w.angle*180/LW_PI > known[i].angle);
        CHECK(w.gap > known[i].gap);
    }
}

/* Sides of three links end to end that bend by less than 5 degrees would look like one bar with four pins. */
static int straight_rows(const lw_mechanism *m, const lw_chain_layout *l)
{
    struct { int link; lw_vec2 from, to; } side[4*LW_JOINT_MAX];
    int n = 0, n_row = 0;
    for (int i = 0; i < m->n_link; i++)
        for (int a = l->first[i], k = l->first[i + 1] - a, s = 0; s < (k > 2 ? k : k - 1); s++)
            for (int back = 0; back < 2; back++) {
                side[n].link = i;
                side[n].from = l->at[l->ring[a + (s + back) % k]];
                side[n++].to = l->at[l->ring[a + (s + 1 - back) % k]];
            }
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++)
            for (int c = 0; c < n; c++) {
                lw_vec2 u = lw_v2_sub(side[a].to, side[a].from), v = lw_v2_sub(side[b].to, side[b].from);
                lw_vec2 w = lw_v2_sub(side[c].to, side[c].from);
                n_row += side[a].link != side[b].link && side[b].link != side[c].link && side[a].link != side[c].link
                      && lw_v2_norm(lw_v2_sub(side[a].to, side[b].from)) == 0
                      && lw_v2_norm(lw_v2_sub(side[b].to, side[c].from)) == 0
                      && fabs(atan2(lw_v2_cross(u, v), lw_v2_dot(u, v))) < 5*LW_PI/180
                      && fabs(atan2(lw_v2_cross(v, w), lw_v2_dot(v, w))) < 5*LW_PI/180;
            }
    return n_row/2;
}

#define CAPACITY 4000

/* A chain of which some map has a symmetry that keeps the outer loop is drawn with symmetry. */
TEST(symmetric_where_possible)
{
    lw_embedding *map = malloc(CAPACITY*sizeof *map);
    chain_list list = all_chains(10, 1);
    int n_possible = 0, n_drawn = 0, n_row = 0;
    for (int i = 0; i < list.n; i++) {
        lw_mechanism m;
        lw_chain_layout l;
        int n_map = 0, most = 1;
        lw_mechanism_from_chain(&list.chain[i], &m);
        CHECK_INT(lw_chain_layout_make(&m, &l, NULL), LW_OK);
        if (lw_embeddings_find(&m, 0, CAPACITY, map, &n_map) == LW_OK)
            for (int k = 0; k < n_map; k++)
                most = map[k].symmetry > most ? map[k].symmetry : most;
        CHECK(n_map < CAPACITY);
        n_possible += most > 1;
        n_drawn += l.symmetry > 1;
        n_row += straight_rows(&m, &l);
    }
    CHECK_INT(n_possible, 71);
    CHECK_INT(n_drawn, 71);
    CHECK_INT(n_row, 0);
    free(list.chain);
    free(map);
}

TEST(frames_on_a_line)
{
    worst w = look_at_all(8, 1, 1, true);
    CHECK_INT(w.n, 16*8);
    CHECK_INT(w.n_cross, 0);
    CHECK(w.angle*180/LW_PI > 23 && w.gap > 0.34);
    w = look_at_all(9, 2, 1, true);
    CHECK_INT(w.n_cross, 0);
    CHECK(w.angle*180/LW_PI > 23 && w.gap > 0.32);
    w = look_at_all(10, 1, 1, true);
    CHECK_INT(w.n_planar, 219*10);
    CHECK_INT(w.n_cross, 11*10);                              /* one each, whatever the ground */
    CHECK(w.angle*180/LW_PI > 13 && w.gap > 0.27);
}

TEST(some_of_twelve_links)
{
    worst w = look_at_all(12, 1, 17, false);
    CHECK_INT(w.n, 6856/17 + 1);
    CHECK(w.angle*180/LW_PI > 12 && w.gap > 0.28);
    CHECK(w.n_cross < 2*(w.n - w.n_planar));
}

/* The image of the picture under its mirror line is the picture. */
TEST(symmetry_is_exact)
{
    lw_mechanism m;
    lw_chain_layout l;
    lw_chain c = watt_chain();
    lw_mechanism_from_chain(&c, &m);
    CHECK_INT(lw_chain_layout_make(&m, &l, NULL), LW_OK);
    CHECK_INT(l.symmetry, 4);
    lw_vec2 middle = { 0, 0 };
    for (int j = 0; j < m.n_joint; j++)
        middle = lw_v2_add(middle, lw_v2_scale(l.at[j], 1.0/m.n_joint));
    for (int j = 0; j < m.n_joint; j++) {
        double nearest = 9;
        for (int k = 0; k < m.n_joint; k++)
            nearest = fmin(nearest, hypot(2*middle.x - l.at[j].x - l.at[k].x, l.at[j].y - l.at[k].y));
        CHECK_NEAR(nearest, 0, 1e-9, 0);
    }
    c = ring_of(5);
    lw_mechanism_from_chain(&c, &m);
    CHECK_INT(lw_chain_layout_make(&m, &l, NULL), LW_OK);
    CHECK_INT(l.symmetry, 10);
    CHECK_NEAR(l.least_angle, 3*LW_PI/5, 1e-6, 0);
}

/* Chains that are not planar: one bar is cut, three bars of the complete graph of six links with a bar on each edge, and none of
 * K(3,3), which has no bar. */
TEST(same_chain_same_picture)
{
    lw_chain chain[3] = { nonplanar_chain(), { .n_link = 21 }, { .n_link = 6 } };
    const int most[3] = { 1, 9, 99 };
    for (int a = 0, bar = 6; a < 6; a++)
        for (int b = 0; b < a; b++, bar++) {
            CHECK_INT(lw_chain_join(&chain[1], a, bar, 1), LW_OK);
            CHECK_INT(lw_chain_join(&chain[1], b, bar, 1), LW_OK);
            if (a > 2 && b < 3)
                CHECK_INT(lw_chain_join(&chain[2], a, b, 1), LW_OK);
        }
    for (int i = 0; i < 3; i++) {
        lw_mechanism m;
        lw_chain_layout a, b;
        lw_mechanism_from_chain(&chain[i], &m);
        CHECK_INT(lw_chain_layout_make(&m, &a, NULL), LW_OK);
        CHECK_INT(lw_chain_layout_make(&m, &b, NULL), LW_OK);
        CHECK_INT(memcmp(a.at, b.at, sizeof a.at), 0);
        CHECK(a.n_cross >= (i == 1 ? 3 : 1) && a.n_cross <= most[i]);           /* K6 in the plane has three crossings at least */
        CHECK(!a.planar && a.least_gap > 1e-3);
    }
}

/* Open chains, fractionated ones, trees, crowds: any connected graph has a picture. */
TEST(anything_connected)
{
    lw_rng rng = check_rng(0);
    for (int trial = 0; trial < 300; trial++) {
        int n = 2 + (int)lw_rng_range(&rng, 0, trial % 10 ? 9 : 14);
        lw_mechanism m = random_topology(&rng, n, (int)lw_rng_range(&rng, 0, 5), "rtpg");
        lw_chain_layout l;
        m.ground = trial % 2 ? (int)lw_rng_range(&rng, 0, n) : LW_NONE;
        CHECK_OK(lw_chain_layout_make(&m, &l, &check_error));
        CHECK(isfinite(l.least_angle) && l.least_gap > 1e-3);
        if (l.planar)
            CHECK_INT(l.n_cross, 0);
    }
}

/* A crank, a rod and a block on the frame: the block's two joints are one point on the line. */
TEST(blocks)
{
    lw_mechanism m;
    lw_chain_layout l;
    lw_mechanism_clear(&m, 4);
    lw_mechanism_join(&m, 0, 1, 'r');
    lw_mechanism_join(&m, 1, 2, 'r');
    lw_mechanism_join(&m, 2, 3, 'r');
    lw_mechanism_join(&m, 0, 3, 't');
    m.ground = 0;
    CHECK_INT(lw_chain_layout_make(&m, &l, NULL), LW_OK);
    int slide = lw_mechanism_joint(&m, 0, 3), pin = lw_mechanism_joint(&m, 2, 3);
    CHECK_NEAR(lw_v2_norm(lw_v2_sub(l.at[slide], l.at[pin])), 0, 0, 0);
    check_ground(&m, &l);
}

TEST(faults)
{
    lw_mechanism m;
    lw_chain_layout l;
    lw_mechanism_clear(&m, 1);
    CHECK_FAILS(lw_chain_layout_make(&m, &l, &check_error), LW_E_ARG, "two links");
    lw_mechanism_clear(&m, 4);
    lw_mechanism_join(&m, 0, 1, 'r');
    lw_mechanism_join(&m, 2, 3, 'r');
    CHECK_FAILS(lw_chain_layout_make(&m, &l, &check_error), LW_E_ARG, "hang together");
}
/* Chains with multiple joints: all links of a pin meet in one point, no links of a planar one cross, the others have one
 * crossing, the frame stands on its line.  A picture has a symmetry wherever a map of the chain has one. */
typedef struct pins_seen { int n, n_drawn; bool grounded; } pins_seen;

static lw_status look_at_pins(void *context, const lw_multiple *pins)
{
    pins_seen *seen = context;
    lw_mechanism m;
    lw_chain_layout l;
    uint32_t axes;
    static lw_embedding map[CAPACITY];
    int n_map = 0, most = 1;
    CHECK_INT(lw_multiple_mechanism(pins, &m, &axes), LW_OK);
    if (seen->grounded)
        m.ground = seen->n%pins->n_link;
    CHECK_OK(lw_axes_layout_make(&m, axes, &l, &check_error));
    CHECK_INT(l.n_cross, !l.planar);
    CHECK(l.least_gap > 0.1 && l.least_angle > 0.1);
    check_rings(&m, &l);
    for (int i = pins->n_link; i < m.n_link; i++)
        for (int k = l.first[i]; k < l.first[i + 1]; k++)
            CHECK(!memcmp(&l.at[l.ring[k]], &l.at[l.ring[l.first[i]]], sizeof *l.at));
    m.n_link = pins->n_link;                                         /* the axes are no links to cross */
    CHECK_INT(count_overlaps(&m, &l), l.n_cross);
    for (int k = l.first[m.ground < 0 ? 0 : m.ground]; m.ground >= 0 && k < l.first[m.ground + 1]; k++)
        CHECK_NEAR(l.at[l.ring[k]].y, 0, 1e-12, 0);
    m.n_link += __builtin_popcount(axes);
    if (lw_embeddings_find(&m, axes, CAPACITY, map, &n_map) == LW_OK)
        for (int k = 0; k < n_map; k++)
            most = map[k].symmetry > most ? map[k].symmetry : most;
    CHECK_INT(l.symmetry > 1, most > 1);
    seen->n++;
    seen->n_drawn += l.symmetry > 1;
    return LW_OK;
}

TEST(multiple_joints)
{
    pins_seen eight = { 0 }, grounded = { .grounded = true }, two = { .grounded = true };
    CHECK_INT(lw_multiple_each(8, 1, 1, look_at_pins, &eight, NULL), LW_OK);
    CHECK_INT(lw_multiple_each(8, 1, 1, look_at_pins, &grounded, NULL), LW_OK);
    CHECK_INT(lw_multiple_each(9, 2, 1, look_at_pins, &two, NULL), LW_OK);
    CHECK_INT(eight.n, 44);
    CHECK_INT(two.n, 174);
    CHECK_INT(eight.n_drawn, 19);
}

