/* mbs/kinematics/instant.c - instant centres and inflection circles. */
#include "mbs/kinematics/instant.h"

#define STILL 1e-9               /* relative angular speed by the input below which a link only shifts */

/* A point of the link with velocity and acceleration, and the link's angular velocity and acceleration. */
typedef struct state { lw_vec2 p, v, a; double w, e; } state;

static bool state_of(const lw_linkage *k, const lw_posture *posture, int link, state *s)
{
    const lw_vec2 *at = NULL;
    *s = (state){ .w = posture->angle[link][1], .e = posture->angle[link][2] };
    if (link == k->ground)
        return true;
    for (int i = 0; i < k->n_joint && !at; i++) {
        const lw_joint *j = &k->joint[i];
        if ((lw_joint_turns(j->kind) && (j->link[0] == link || j->link[1] == link)) || (lw_joint_has_slot(j->kind) && j->link[1] == link))
            at = posture->joint[i];
    }
    for (int i = 0; i < k->n_tracer && !at; i++)
        if (k->tracer[i].link == link)
            at = posture->tracer[i];
    if (at) {
        s->p = at[0];
        s->v = at[1];
        s->a = at[2];
    }
    return at != NULL;
}

static lw_vec2 velocity(const state *s, lw_vec2 p)
{
    return lw_v2_add(s->v, lw_v2_scale(lw_v2_perp(lw_v2_sub(p, s->p)), s->w));
}

static lw_vec2 acceleration(const state *s, lw_vec2 p)
{
    lw_vec2 r = lw_v2_sub(p, s->p);
    return lw_v2_add(s->a, lw_v2_sub(lw_v2_scale(lw_v2_perp(r), s->e), lw_v2_scale(r, s->w*s->w)));
}

/* The centre C has the same velocity on both links: v(p) + w i (C - p) = 0 for the relative motion, so C = p + i
 * v(p)/w. There the relative acceleration a needs no Coriolis term.  A point at r from C has the relative velocity w i
 * r and acceleration a + e i r - w^2 r; they are parallel where r a = w^2 r r, on the circle with the diameter a/w^2. */
static lw_instant_motion relative(const state *of, const state *from)
{
    lw_instant_motion out = { .centre = { NAN, NAN }, .inflection = { NAN, NAN }, .turn = of->w - from->w };
    if (!(fabs(out.turn) > STILL))
        return out;
    lw_vec2 v = lw_v2_sub(of->v, velocity(from, of->p));
    out.centre = lw_v2_add(of->p, lw_v2_scale(lw_v2_perp(v), 1/out.turn));
    lw_vec2 a = lw_v2_sub(acceleration(of, out.centre), acceleration(from, out.centre));
    out.inflection = lw_v2_add(out.centre, lw_v2_scale(a, 1/(out.turn*out.turn)));
    return out;
}

lw_instant_motion lw_instant_motion_at(const lw_vec2 p[3], const double angle[3])
{
    const state of = { p[0], p[1], p[2], angle[1], angle[2] }, ground = { .w = 0 };
    return relative(&of, &ground);
}

lw_status lw_instant_motion_of(const lw_linkage *k, const lw_posture *posture, int link, int base, lw_instant_motion *out)
{
    state of, from;
    *out = (lw_instant_motion){ .centre = { NAN, NAN }, .inflection = { NAN, NAN } };
    if (link < 0 || base < 0 || link >= k->n_link || base >= k->n_link || link == base)
        return LW_E_ARG;
    if (!state_of(k, posture, link, &of) || !state_of(k, posture, base, &from))
        return LW_E_KIND;
    *out = relative(&of, &from);
    return LW_OK;
}
