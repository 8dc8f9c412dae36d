/* tests/clearance_models.h - models with clearance for tests: paper C's four-bar turned, mirrored and in other units,
 * random linkages with masses. */
#ifndef LW_TESTS_CLEARANCE_MODELS_H
#define LW_TESTS_CLEARANCE_MODELS_H

#include "grammar/model/model.h"
#include "mbs/clearance/clearance.h"
#include "tests/mbs_random.h"

/* Makkonen 1999, paper C, appendix 1, read with its errata; `unit` "m", "mm", "in" ..., metre its size; turned by
 * `turn`, mirrored at the y axis first.  The caller gives the speed when running: of opposite sign when mirrored. */
static inline lw_status paper_c(const char *unit, double metre, double turn, bool mirrored, lw_model *m, lw_error *e)
{
    const double r2 = 0.1, r3 = 0.39, r4 = 0.58;
    lw_vec2 o = { 0, 0 }, a = { 0, r2 }, c = lw_v2_add(lw_v2(0.8, 0), lw_v2_polar(0.1, 70*LW_PI/180));
    lw_vec2 ac = lw_v2_sub(c, a);
    double r42 = lw_v2_norm(ac), q42 = acos((r3*r3 + r42*r42 - r4*r4)/(2*r3*r42)) + atan2(ac.y, ac.x);
    lw_vec2 b = lw_v2_add(a, lw_v2_polar(r3, q42)), along2 = lw_v2(0, 1), along4 = lw_v2_scale(lw_v2_sub(b, c), 1/r4);
    lw_vec2 p[] = { o, a, b, c, lw_v2_scale(along2, 0.0174), lw_v2_add(a, lw_v2_polar(0.195, q42)),
                    lw_v2_add(c, lw_v2_scale(along4, 0.329)), lw_v2(0, -9.81) };
    for (int i = 0; i < 8; i++) {
        p[i].x *= mirrored ? -1 : 1;
        p[i] = lw_v2_scale(lw_v2_turn(p[i], lw_v2_polar(1, turn)), i < 7 ? 1/metre : 1);
    }
    char text[3000];
    int n = snprintf(text, sizeof text, "{\"linkwright\": 1, \"units\": {\"length\": \"%s\"}, \"links\": [\"ground\","
        "{\"name\": \"crank\", \"mass\": 12.9, \"centre\": [%.17g, %.17g], \"inertia\": 0.2188},"
        "{\"name\": \"coupler\", \"mass\": 2.41, \"centre\": [%.17g, %.17g], \"inertia\": 0.053},"
        "{\"name\": \"rocker\", \"mass\": 5.04, \"centre\": [%.17g, %.17g], \"inertia\": 0.2094}], \"joints\": ["
        "{\"name\": \"O\", \"links\": [\"ground\", \"crank\"], \"at\": [%.17g, %.17g]},"
        "{\"name\": \"A\", \"links\": [\"crank\", \"coupler\"], \"at\": [%.17g, %.17g]},"
        "{\"name\": \"B\", \"links\": [\"coupler\", \"rocker\"], \"at\": [%.17g, %.17g], \"clearance\": "
        "{\"model\": \"impact\", \"gap\": %.17g, \"stiffness\": 1e8, \"damping\": 3000, \"depth\": %.17g}},"
        "{\"name\": \"C\", \"links\": [\"ground\", \"rocker\"], \"at\": [%.17g, %.17g]}],"
        "\"input\": {\"joint\": \"O\", \"speed\": 9.6}, \"gravity\": [%.17g, %.17g]}", unit,
        p[4].x, p[4].y, p[5].x, p[5].y, p[6].x, p[6].y, p[0].x, p[0].y, p[1].x, p[1].y, p[2].x, p[2].y,
        1e-4/metre, 1.2e-6/metre, p[3].x, p[3].y, p[7].x, p[7].y);
    return lw_model_read(text, (size_t)n, "paper C", m, e);
}

/* Masses for every link, gravity; clearance of 1 % of the size at pin `joint`. */
static inline void give_masses(lw_rng *r, const lw_linkage *k, int joint, lw_model *m)
{
    lw_model_from_linkage(k, m);
    for (int l = 0; l < k->n_link; l++)
        m->body[l] = (lw_body){ .given = true, .mass = lw_rng_range(r, 0.5, 3), .centre = random_place(r), .inertia = lw_rng_range(r, 0.1, 1) };
    m->gravity = lw_v2(lw_rng_range(r, -3, 3), -9.81);
    m->has_speed[0] = true;
    m->speed[0] = lw_rng_range(r, -2, 2);
    if (joint >= 0)
        m->clearance[joint] = (lw_clearance){ .model = LW_CLEARANCE_IMPACT, .gap = 0.01, .stiffness = 1e4,
                                             .exponent = 1,
                                              .restitution = 1, .friction_speed = 1e-3 };
}

/* A random pin of the linkage; -1: it has none */
static inline int random_pin(lw_rng *r, const lw_linkage *k)
{
    int start = (int)(lw_rng_bits(r)%(uint64_t)k->n_joint);
    for (int i = 0; i < k->n_joint; i++)
        if (k->joint[(start + i)%k->n_joint].kind == LW_JOINT_REVOLUTE)
            return (start + i)%k->n_joint;
    return -1;
}

/* The first 256 samples of a run; a visitor that keeps them. */
typedef struct track { int n; lw_clearance_sample s[256]; } track;

static inline lw_status keep(void *context, const lw_clearance_sample *s)
{
    track *t = context;
    if (t->n < 256)
        t->s[t->n++] = *s;
    return LW_OK;
}

#endif
