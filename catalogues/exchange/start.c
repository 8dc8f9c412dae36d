#include "catalogues/exchange/start.h"

#include <stdlib.h>
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/tree.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"

static bool any(lw_vec3 v) { return lw_v3_norm(v) > 0; }

static lw_status refuse_both(lw_error *e)
{
    return lw_error_set(e, LW_E_KIND, "some inputs have a motion, and other parts a speed at the start; a file for another program holds one "
                        "or the other");
}

/* ---- in space ------------------------------------------------------------------------------------- */

static lw_status space_twists(lw_dynamics *d, const lw_spatial *m, lw_export_twist *out, lw_error *e)
{
    const lw_space *s = lw_dynamics_space(d);
    double *q = calloc((size_t)(s->n_q + s->n_v) + 1, sizeof *q), *v = q + s->n_q;
    lw_space_frame *frame = calloc((size_t)s->n_body + 1, sizeof *frame);
    if (q && frame) {
        lw_dynamics_start(d, q, v);
        lw_space_place(s, q, frame);
        for (int i = 0; i < m->n_link; i++)
            if (i != m->ground)
                out[i] = (lw_export_twist){ lw_space_point_velocity(s, frame, lw_space_point_of(s, i, lw_v3(0, 0, 0)), v),
                                            lw_space_omega(frame, s->body_of[i], v) };
    }
    bool room = q && frame;
    free(q);
    free(frame);
    return room ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

lw_status lw_export_space_start(const lw_spatial *m, const lw_spatial *expanded, lw_export_twist **out, lw_error *e)
{
    bool moves = false, driven = false;
    for (int i = 0; i < m->n_link; i++)
        moves |= i != m->ground && ((m->body[i].has_velocity && any(m->body[i].velocity))
                                    || (m->body[i].has_omega && any(m->body[i].omega)));
    for (int i = 0; i < m->n_input; i++) {
        driven |= m->input[i].motion != NULL;
        moves |= !m->input[i].motion && m->input[i].has_speed && m->input[i].speed != 0;
    }
    *out = NULL;
    if (!moves || !lw_space_weighed(m))
        return LW_OK;
    if (driven)
        return refuse_both(e);
    lw_dynamics *d = NULL;
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_status s = lw_dynamics_make_spatial(m, &o, &d, e);
    if (s != LW_OK)
        return s;
    *out = calloc((size_t)expanded->n_link, sizeof **out);
    s = *out ? space_twists(d, expanded, *out, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_dynamics_free(d);
    return s;
}

/* ---- in the plane --------------------------------------------------------------------------------- */

static lw_status plane_twists(const lw_dynamics *d, int ground, lw_export_twist *out, lw_error *e)
{
    const lw_system *s = lw_dynamics_system(d);
    double *q = calloc(2*(size_t)s->n_q + 1, sizeof *q), *v = q + s->n_q;
    if (!q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_dynamics_start(d, q, v);
    for (int b = 0; b < s->n_body; b++) {
        lw_vec2 at[2];
        lw_system_point_series(s, b, lw_system_arm(s, b, lw_v2(0, 0)), 1, q, at);
        if (s->link[b] != ground)
            out[s->link[b]] = (lw_export_twist){ lw_v3(at[1].x, at[1].y, 0), lw_v3(0, 0, v[3*b + 2]) };
    }
    free(q);
    return LW_OK;
}

lw_status lw_export_start(const lw_model *m, lw_export_twist **out, lw_error *e)
{
    bool moves = false, driven = false;
    *out = NULL;
    if (!m || !lw_export_weighed(&m->linkage, m))
        return LW_OK;
    for (int i = 0; i < m->linkage.n_link; i++)
        moves |= m->body[i].has_velocity && (lw_v2_norm(m->body[i].velocity) > 0 || m->body[i].omega != 0);
    for (int i = 0; i < m->linkage.n_input; i++) {
        driven |= m->motion[i] != NULL;
        moves |= !m->motion[i] && m->has_speed[i] && m->speed[i] != 0;
    }
    if (!moves)
        return LW_OK;
    if (driven)
        return refuse_both(e);
    lw_dynamics *d = NULL;
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_status s = lw_dynamics_make(m, &o, &d, e);
    if (s != LW_OK)
        return s;
    *out = calloc((size_t)m->linkage.n_link, sizeof **out);
    s = *out ? plane_twists(d, m->linkage.ground, *out, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_dynamics_free(d);
    return s;
}

lw_export_twist lw_export_relative(const lw_export_twist *all, int link, int from, lw_vec3 at)
{
    if (!all)
        return (lw_export_twist){ { 0, 0, 0 }, { 0, 0, 0 } };
    lw_export_twist a = all[link], b = all[from];
    lw_vec3 omega = lw_v3_sub(a.omega, b.omega);
    return (lw_export_twist){ lw_v3_add(lw_v3_sub(a.velocity, b.velocity), lw_v3_cross(omega, at)), omega };
}
