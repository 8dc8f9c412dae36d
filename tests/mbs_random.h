/* tests/mbs_random.h - random linkages for the tests of the plan: four-link chains of every type and
 * bigger ones grown by dyads, told in random order. */
#ifndef LW_TESTS_MBS_RANDOM_H
#define LW_TESTS_MBS_RANDOM_H

#include "base/rng.h"
#include "mbs/plan/types.h"
#include "tests/mbs_linkage.h"

static inline lw_vec2 random_place(lw_rng *r) { return lw_v2(lw_rng_range(r, -2, 2), lw_rng_range(r, -2, 2)); }

/* A posture of this type: the place of every pin by chance; slides pass through a pin or a place of
 * their own. */
static inline void random_type(lw_rng *r, const lw_type *t, lw_linkage *k)
{
    blank_linkage(k, 4);
    for (int i = 0; i < 4; i++)
        add_joint(k, t->letters[i] == 'R' ? LW_JOINT_REVOLUTE : LW_JOINT_SLIDER, i, (i + 1)%4, random_place(r),
                  lw_rng_range(r, -LW_PI, LW_PI));
    add_input(k, 0, t->letters[0] == 'R' ? lw_linkage_posture_input(k, 0) : lw_rng_range(r, -1, 1));
    add_tracer(k, 2, random_place(r));
    k->tracer[0].angle = lw_rng_range(r, -1, 1);
}

/* A crank and n dyads of random kind hung on random links; a tracer on each link of the last. */
static inline void random_grown(lw_rng *r, int n_dyad, lw_linkage *k)
{
    static const char *const kind[] = { "RRR", "RRR", "RRP", "PRR", "RPR", "PRP", "PPR", "RPP" };
    blank_linkage(k, 2 + 2*n_dyad);
    add_pin(k, 0, 1, random_place(r));
    for (int i = 0; i < n_dyad; i++) {
        const char *word = kind[lw_rng_bits(r)%8];
        int first = 2 + 2*i, base = (int)(lw_rng_bits(r)%(uint64_t)first);
        int other = (base + 1 + (int)(lw_rng_bits(r)%(uint64_t)(first - 1)))%first;
        const int link[4] = { base, first, first + 1, other };
        for (int h = 0; h < 3; h++)
            add_joint(k, word[h] == 'R' ? LW_JOINT_REVOLUTE : LW_JOINT_SLIDER, link[h], link[h + 1], random_place(r),
                      lw_rng_range(r, -LW_PI, LW_PI));
    }
    add_input(k, 0, lw_linkage_posture_input(k, 0));
    add_tracer(k, 2*n_dyad, random_place(r));
    add_tracer(k, 2*n_dyad + 1, random_place(r));
}

/* The same linkage with its links numbered and its joints told another way round. */
static inline void shuffle_linkage(lw_rng *r, const lw_linkage *k, lw_linkage *s)
{
    int to[LW_LINK_MAX];
    *s = *k;
    for (int i = 0; i < k->n_link; i++) {
        int j = (int)(lw_rng_bits(r)%(uint64_t)(i + 1));
        to[i] = to[j];
        to[j] = i;
    }
    for (int i = 0; i < k->n_link; i++)
        memcpy(s->link_name[to[i]], k->link_name[i], LW_NAME_SIZE);
    s->ground = to[k->ground];
    for (int j = 0; j < k->n_joint; j++) {
        int swap = j != k->input[0].joint && lw_rng_bits(r) & 1;
        s->joint[j].link[0] = to[k->joint[j].link[swap]];
        s->joint[j].link[1] = to[k->joint[j].link[!swap]];
    }
    for (int i = 0; i < k->n_tracer; i++)
        s->tracer[i].link = to[k->tracer[i].link];
}

/* Jansen's leg of eleven bars in the posture at crank angle 0 (data/linkages/jansen.csv, first row): pins of
 * several bars are several joints at one place. */
static inline void jansen_linkage(lw_linkage *k)
{
    enum { GROUND, M, J, B, E, D, K, C, F, G, I, H, N };
    const lw_vec2 o = { 0, 0 }, a = { 15, 0 }, g = { -38, -7.8 },
                  p2 = { -24.013535097127790735, 31.272097454842680634 };
    const lw_vec2 p3 = { -74.794365380936053419, 8.1431702058961433062 };
    const lw_vec2 p4 = { -26.952107031572960150, -45.515170170081168150 };
    const lw_vec2 p5 = { -59.231514961415004055, -28.052930230747767324 };
    const lw_vec2 foot = { -43.160110524104723337, -91.756932926123223765 };
    static const int pin[][2] = { { GROUND, M }, { M, J }, { J, K }, { GROUND, B }, { GROUND, D }, { GROUND, C },
                                  { J, B }, { B, E }, { E, D }, { D, F }, { K, C }, { C, G }, { G, I }, { F, G },
                                  { G, H }, { I, H } };
    const lw_vec2 at[] = { o, a, a, g, g, g, p2, p2, p3, p3, p4, p4, p4, p5, p5, foot };
    blank_linkage(k, N);
    for (size_t i = 0; i < sizeof pin/sizeof *pin; i++)
        add_pin(k, pin[i][0], pin[i][1], at[i]);
    add_input(k, 0, 0);
    add_tracer(k, I, foot);
}

/* A topology of pins, its input at the first. */
typedef struct pin_net { const char *name; int n_link, n_joint, tracer, pair[10][2]; } pin_net;

/* The net with its pins and its tracer at random places in the square from -1 to 1. */
static inline lw_linkage random_net(const pin_net *net, lw_rng *rng)
{
    lw_linkage k;
    blank_linkage(&k, net->n_link);
    for (int j = 0; j < net->n_joint; j++)
        add_pin(&k, net->pair[j][0], net->pair[j][1], lw_v2(lw_rng_range(rng, -1, 1), lw_rng_range(rng, -1, 1)));
    add_input(&k, 0, 0);
    add_tracer(&k, net->tracer, lw_v2(lw_rng_range(rng, -1, 1), lw_rng_range(rng, -1, 1)));
    k.input[0].value = lw_linkage_posture_input(&k, 0);
    return k;
}

#endif
