/* How a linkage moves: postures, ranges of its input, curves of its motions. */
#include "base/real.h"
#include "surface/surface.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/batch/batch.h"
#include "mbs/constraints/circuits.h"
#include "mbs/kinematics/instant.h"
#include "mbs/kinematics/point_path.h"
#include "mbs/kinematics/motion.h"
#include "mbs/batch/posture.h"

#define ALIGNMENT 64
#define LANES     256              /* inputs worked out at once */

struct lw_kinematics {
    lw_linkage linkage;
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    void      *work;
};

lw_status lw_kinematics_create(const lw_linkage *linkage, lw_kinematics **out, lw_error *error)
{
    lw_kinematics *k = calloc(1, sizeof *k);
    lw_plan_options o = { .kind = LW_PLAN_GEARED, .tracers = (1u << linkage->n_tracer) - 1, .all_joints = true };
    *out = NULL;
    if (!k)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    k->linkage = *linkage;
    lw_status s = lw_plan_make(linkage, o, &k->plan, error);
    if (s == LW_OK)
        s = lw_plan_read(&k->plan, linkage, k->dim, k->mode, &k->input, error);
    if (s == LW_OK) {
        size_t size = (lw_batch_work_size(&k->plan) + ALIGNMENT - 1)/ALIGNMENT*ALIGNMENT;
        k->work = aligned_alloc(ALIGNMENT, size);
        s = k->work ? LW_OK : lw_error_set(error, LW_E_MEMORY, "out of memory");
    }
    if (s == LW_OK)
        *out = k;
    else
        lw_kinematics_destroy(k);
    return s;
}

void lw_kinematics_destroy(lw_kinematics *kinematics)
{
    if (kinematics)
        free(kinematics->work);
    free(kinematics);
}

double lw_kinematics_input(const lw_kinematics *kinematics) { return kinematics->input; }
int    lw_kinematics_turns(const lw_kinematics *kinematics) { return kinematics->plan.input_turns_per_period; }
int    lw_kinematics_n_dimension(const lw_kinematics *kinematics) { return kinematics->plan.n_dim; }

static bool has_dimension(const lw_kinematics *k, int i) { return i >= 0 && i < k->plan.n_dim; }

const char *lw_kinematics_dimension_name(const lw_kinematics *kinematics, int i)
{
    return has_dimension(kinematics, i) ? kinematics->plan.dim[i].name : NULL;
}

double lw_kinematics_dimension(const lw_kinematics *kinematics, int i)
{
    return has_dimension(kinematics, i) ? kinematics->dim[i] : 0;
}

lw_status lw_kinematics_set_dimension(lw_kinematics *kinematics, int i, double value)
{
    if (!has_dimension(kinematics, i) || !isfinite(value))
        return LW_E_ARG;
    kinematics->dim[i] = value;
    return LW_OK;
}

lw_status lw_kinematics_posture(const lw_kinematics *kinematics, double input, int order, lw_vec2 *joint,
                                double *link_angle, lw_vec2 *tracer, double *margin)
{
    const lw_linkage *k = &kinematics->linkage;
    lw_posture posture;
    if (order < 0 || order > LW_ORDER_MAX)
        return LW_E_ARG;
    lw_status s = lw_posture_solve(&kinematics->plan, kinematics->dim, kinematics->mode, input, order, &posture);
    size_t n = (size_t)order + 1;
    for (int i = 0; i < k->n_joint && joint; i++)
        memcpy(joint + (size_t)i*n, posture.joint[i], n*sizeof *joint);
    for (int i = 0; i < k->n_link && link_angle; i++)
        memcpy(link_angle + (size_t)i*n, posture.angle[i], n*sizeof *link_angle);
    for (int i = 0; i < k->n_tracer && tracer; i++)
        memcpy(tracer + (size_t)i*n, posture.tracer[i], n*sizeof *tracer);
    if (margin)
        *margin = posture.margin;
    return s;
}

lw_status lw_kinematics_instant(const lw_kinematics *kinematics, double input, int link, int base, lw_instant_motion *out)
{
    lw_posture posture;
    *out = (lw_instant_motion){ .centre = { NAN, NAN }, .inflection = { NAN, NAN } };
    lw_status s = lw_posture_solve(&kinematics->plan, kinematics->dim, kinematics->mode, input, 2, &posture);
    return s == LW_OK ? lw_instant_motion_of(&kinematics->linkage, &posture, link, base, out) : s;
}

int lw_path_double_points(size_t n, const double *x, const double *y, lw_double_point *out, int most)
{
    return lw_point_path_doubles(n, x, y, out, most);
}

lw_status lw_kinematics_trace(lw_kinematics *kinematics, int tracer, size_t n, const double *input, double *x,
                              double *y, double *angle, double *margin)
{
    double c[LANES], s[LANES], u[LANES], v[LANES];
    if (tracer < 0 || tracer >= kinematics->linkage.n_tracer)
        return LW_E_ARG;
    for (size_t first = 0; first < n; first += LANES) {
        size_t here = n - first < LANES ? n - first : LANES;
        lw_lanes in = { .n = here, .c = c, .s = s, .dim = kinematics->dim, .mode = kinematics->mode };
        for (size_t i = 0; i < here; i++) {
            bool slider = kinematics->plan.input_is_slider;
            c[i] = slider ? input[first + i] : cos(input[first + i]);
            s[i] = slider ? 0 : sin(input[first + i]);
        }
        lw_batch_point(&kinematics->plan, &in, tracer, kinematics->work, x + first, y + first, angle ? u : NULL,
                       angle ? v : NULL, margin ? margin + first : NULL);
        for (size_t i = 0; i < here && angle; i++)
            angle[first + i] = atan2(v[i], u[i]);
    }
    return LW_OK;
}

lw_status lw_kinematics_linkage(const lw_kinematics *kinematics, double input, lw_linkage **out, lw_error *error)
{
    lw_status s = lw_linkage_copy(&kinematics->linkage, out);
    if (s == LW_OK)
        s = lw_plan_write(&kinematics->plan, kinematics->dim, kinematics->mode, input, *out);
    if (s == LW_OK)
        return s;
    lw_linkage_destroy(*out);
    *out = NULL;
    return lw_error_set(error, s, "%s", lw_status_text(s));
}

lw_status lw_kinematics_ranges(const lw_kinematics *kinematics, lw_range_visit *visit, void *context)
{
    if (kinematics->plan.n_higher > 0)
        return LW_E_KIND;
    lw_motion *m = malloc(sizeof *m);
    if (!m)
        return LW_E_MEMORY;
    lw_status s = lw_motion_find(&kinematics->plan, kinematics->dim, m);
    int own = s >= 0 ? lw_motion_arc(&kinematics->plan, m, kinematics->mode, kinematics->input) : -1;
    lw_status end = LW_OK;
    for (int i = 0; s != LW_OPEN && s >= 0 && i < m->n_arc && end == LW_OK; i++) {
        const lw_arc *a = &m->arc[i];
        lw_input_range range = { .first = a->first, .last = a->last, .turns = a->turns,
                                 .limit = { a->limit[0], a->limit[1] }, .circuit = a->circuit, .own = i == own,
                                 .transmission = { a->transmission_min, a->transmission_max } };
        end = visit(context, &range);
    }
    free(m);
    return end != LW_OK ? end : s;
}

lw_status lw_kinematics_explain(const lw_kinematics *kinematics, char **out)
{
    size_t size = lw_plan_explain(&kinematics->plan, &kinematics->linkage, NULL, 0) + 1;
    *out = malloc(size);
    if (!*out)
        return LW_E_MEMORY;
    lw_plan_explain(&kinematics->plan, &kinematics->linkage, *out, size);
    return LW_OK;
}

/* ---- curves ------------------------------------------------------------------------------------------------- */

struct lw_motion_curves {
    lw_system   s;
    lw_circuits c;
};

lw_status lw_motion_curves_create(const lw_linkage *linkage, int patience, uint64_t seed, lw_motion_curves **out, lw_error *error)
{
    lw_motion_curves *m = calloc(1, sizeof *m);
    lw_motion_curve_options o = { .input = 0 };
    *out = NULL;
    if (!m)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status s = lw_system_make(linkage, NULL, 0, &m->s, error);
    if (s == LW_OK)
        s = lw_circuits_find(&m->s, NULL, &o, patience, seed, &m->c, error);
    if (s == LW_OK)
        *out = m;
    else
        lw_motion_curves_destroy(m);
    return s;
}

void lw_motion_curves_destroy(lw_motion_curves *curves)
{
    if (curves) {
        lw_circuits_free(&curves->c);
        lw_system_free(&curves->s);
    }
    free(curves);
}

int lw_motion_curves_count(const lw_motion_curves *curves) { return curves->c.n; }

lw_status lw_motion_curves_info(const lw_motion_curves *curves, int curve, lw_motion_curve_info *out)
{
    int n;
    if (curve < 0 || curve >= curves->c.n)
        return LW_E_ARG;
    const lw_motion_curve *c = curves->c.curve[curve];
    const lw_motion_curve_event *event = lw_motion_curve_events(c, &n);
    *out = (lw_motion_curve_info){ .closed = lw_motion_curve_ended(c) == LW_MOTION_CURVE_CLOSED,
                                   .residual = lw_motion_curve_worst(c) };
    out->input_turns = out->closed ? lw_motion_curve_turns(c, -1) : 0;
    for (int i = 0; i < n; i++) {
        out->limits += event[i].kind == LW_EVENT_LIMIT;
        out->crossings += event[i].kind == LW_EVENT_CROSSING;
    }
    return LW_OK;
}

lw_status lw_motion_curves_trace(lw_motion_curves *curves, int curve, int tracer, size_t n, double *input, double *x, double *y)
{
    double q[LW_SYSTEM_Q_MAX];
    if (curve < 0 || curve >= curves->c.n || ((x || y) && (tracer < 0 || tracer >= curves->s.n_tracer)))
        return LW_E_ARG;
    lw_motion_curve *c = curves->c.curve[curve];
    bool closed = lw_motion_curve_ended(c) == LW_MOTION_CURVE_CLOSED;
    double step = lw_motion_curve_length(c)/(double)(closed || n < 2 ? n : n - 1);
    for (size_t i = 0; i < n; i++) {
        lw_motion_curve_posture(c, lw_motion_curve_station(c, step*(double)i), q, NULL);
        lw_vec2 p = x || y ? lw_system_point(&curves->s, curves->s.tracer_body[tracer], curves->s.tracer_arm[tracer], q)
                           : lw_v2(0, 0);
        if (input)
            input[i] = lw_motion_curve_input(c, q);
        if (x)
            x[i] = p.x;
        if (y)
            y[i] = p.y;
    }
    return LW_OK;
}
