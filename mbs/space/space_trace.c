/* mbs/space/space_trace.c - paths of tracers. */
#include "mbs/space/space_trace.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "mbs/space/space_adjust.h"
#include "mbs/space/space_hold.h"

/* Rates have no bound at a limit of the input: it is approached to this share of the range. */
static const double limit_inside = 1e-8;

void lw_space_tracers(const lw_space *s, const lw_space_frame *frame, const double *q, const double *v, const double *a,
                      lw_space_tracer *out)
{
    const lw_spatial *m = s->model;
    for (int i = 0; i < m->n_tracer; i++) {
        lw_space_point p = s->tracer[i];
        lw_space_tracer *t = &out[i];
        lw_vec3 w = lw_space_omega(frame, p.body, v), arm = lw_m3_apply(&frame[p.body + 1].turn, p.arm);
        lw_vec3 alpha = lw_space_omega(frame, p.body, a);         /* R alpha: omega x omega is 0 */
        lw_quaternion turn = { 1, 0, 0, 0 };
        if (p.body >= 0) {
            const double *at = q + 7*p.body;
            turn = lw_quaternion_times((lw_quaternion){ at[3], at[4], at[5], at[6] },
                                       lw_quaternion_inverse(s->axes[p.body]));
        }
        t->place = lw_space_point_at(frame, p);
        t->velocity = lw_space_point_velocity(s, frame, p, v);
        t->acceleration = lw_v3_add(lw_space_point_velocity(s, frame, p, a), lw_v3_cross(w, lw_v3_cross(w, arm)));
        t->turn = lw_quaternion_unit(lw_quaternion_times(turn, m->tracer[i].frame));
        t->omega = w;
        t->alpha = alpha;
    }
}

typedef struct one_input { const lw_spatial *m; const double *still; } one_input;

/* The first input runs, the others stand still. */
static lw_status first_alone(void *context, double u, double (*out)[3])
{
    const one_input *p = context;
    for (int i = 0; i < p->m->n_input; i++) {
        out[i][0] = (i == 0 ? u - lw_spatial_offset(&p->m->input[0]) : p->still[i]);
        out[i][1] = i == 0;
        out[i][2] = 0;
    }
    return LW_OK;
}

/* The last input at which all links were near. */
typedef struct near_places { const lw_space_follow *f; double u; } near_places;

static void note_near(void *context, const double *q)
{
    near_places *p = context;
    const lw_space *s = p->f->z.s;
    double most = 0;
    (void)q;
    for (int b = 0; b < s->n_body; b++)
        most = fmax(most, lw_space_distance(p->f, s->link_of[b]));
    if (most <= LW_SPACE_FAR)
        p->u = p->f->u;
}

/* The end of the input in one direction, k 0 down and 1 up, from the posture of the file; *inside: how far before it a trace ends where a link
 * slides away. */
static lw_status find_end(const lw_space *s, const lw_spatial_measure *input, int k, double *end, double *inside, lw_space_trace *o, lw_error *e)
{
    lw_space_follow f;
    double slide, left;
    lw_status st = lw_space_follow_make(s, input, 1, false, &f, e);
    if (st != LW_OK)
        return st;
    lw_space_follow_values(&f, end);
    near_places near = { &f, *end };
    f.passed = note_near;
    f.passed_by = &near;
    st = lw_space_reach(&f, *end + (k ? 2 : -2)*LW_PI, end, &o->limit[k], e);
    *inside = 0;
    if (st == LW_OK && o->limit[k] && (o->away[k] = lw_space_away(&f, &slide, &left)) >= 0)
        *inside = fmax(3*left, fabs(*end - near.u));             /* at half the slide or where it is no longer near */
    lw_space_follow_free(&f);
    return st;
}

/* Ends of the first input where none are given: its range in the file, a whole turn, or as far as it goes.  value (n):
 * scratch. */
static lw_status find_ends(const lw_space *s, const lw_spatial_measure *input, int n, double *value, lw_space_trace *o, lw_error *e)
{
    const lw_spatial_input *in = &s->model->input[0];
    double offset = lw_spatial_offset(in);
    if (in->has_range) {
        o->from = in->first, o->to = in->last;
        return LW_OK;
    }
    if (in->measure.of != LW_OF_TURN)
        return lw_error_set(e, LW_E_ARG, "the range of the input is needed: give it \"first\" and \"last\" in the file, or "
                            "--input-range%s", in->motion ? "; or move all inputs in time (--time-range)" : "");
    lw_space_follow f;
    double inside[2] = { 0, 0 };
    lw_status st = lw_space_follow_make(s, input, n, false, &f, e);
    if (st != LW_OK)
        return st;
    lw_space_follow_values(&f, value);
    lw_space_follow_free(&f);
    o->from = value[0], o->to = value[0] + 2*LW_PI;
    if (n == 1)
        st = find_end(s, input, 1, &o->to, &inside[1], o, e);
    if (st == LW_OK && o->limit[1])
        st = find_end(s, input, 0, &o->from, &inside[0], o, e);
    double least = limit_inside*(o->to - o->from);
    o->from += offset + (o->limit[0] ? fmax(least, inside[0]) : 0);
    o->to += offset - (o->limit[1] ? fmax(least, inside[1]) : 0);
    return st;
}

/* From f->q near a limit u* of the input to the posture q there.  Near the limit q* - q = A sqrt(u* - u), so u* - u = v.v/(2 v.a) and q* - q =
 * 2 (u* - u) v; the joints are then closed.  *by: the change of the input.  LW_OPEN: the postures do not move like this, and q is of no use.
 * LW_E_MEMORY. */
static lw_status step_to_limit(lw_space_follow *f, double *q, double *by)
{
    const lw_space *s = f->z.s;
    double vv = lw_dot(s->n_v, f->v, f->v), left = vv/(2*lw_dot(s->n_v, f->v, f->a)), size = 2*fabs(left)*sqrt(vv), before, *own = f->q;
    lw_space_follow joints;
    lw_status st = size < 1e-2 ? lw_space_follow_make(s, NULL, 0, true, &joints, NULL) : LW_OPEN;
    if (st != LW_OK)
        return st == LW_E_MEMORY ? st : LW_OPEN;
    memcpy(q, f->q, (size_t)s->n_q*sizeof *q);
    memcpy(joints.z.near + joints.z.n_extra, f->z.near + f->z.n_extra, (size_t)(joints.z.n_near - joints.z.n_extra)*sizeof *f->z.near);
    for (int i = 0; i < s->n_v; i++)
        joints.v[i] = 2*left*f->v[i];
    lw_space_move(s, q, joints.v);
    if ((st = lw_space_rows_arrange(&joints.z, q, NULL)) == LW_OK)
        st = lw_space_rows_close(&joints.z, q, joints.target, size);
    lw_space_follow_free(&joints);
    lw_space_follow_values(f, &before);
    f->q = q;
    lw_space_follow_values(f, by);
    f->q = own;
    *by -= before;
    return st == LW_E_MEMORY ? st : st == LW_OK && fabs(*by - left) < 0.1*fabs(left) ? LW_OK : LW_OPEN;
}

/* Tracers in the posture that f has reached.  end: 0 or 1 for the first and the last row, else -1.  If that end is a limit of the input, *u and the
 * tracers are those of the limit, without rates.  q: scratch.  LW_E_MEMORY. */
static lw_status show(lw_space_follow *f, int end, lw_space_trace *o, double *q, double *u, lw_space_tracer *tracer)
{
    const lw_space *s = f->z.s;
    double by;
    if (end >= 0 && o->away[end] >= 0)
        o->distance[end] = lw_space_distance(f, o->away[end]);
    lw_status st = end >= 0 && o->limit[end] && o->away[end] < 0 ? step_to_limit(f, q, &by) : LW_OPEN;
    bool limit = st == LW_OK;
    lw_space_rows_fill(&f->z, limit ? q : f->q, f->target);
    o->open = fmax(o->open, lw_space_rows_open(&f->z));
    lw_space_tracers(s, f->z.frame, limit ? q : f->q, f->v, f->a, tracer);
    for (int i = 0; limit && i < s->model->n_tracer; i++)
        tracer[i].velocity = tracer[i].acceleration = tracer[i].omega = tracer[i].alpha = (lw_vec3){ NAN, NAN, NAN };
    *u += limit ? by : 0;
    return st == LW_E_MEMORY ? st : LW_OK;
}

/* The rows between the ends, in the order of the input; those before the posture of the file are found on the way back
 * from it, so that each end is reached along the motion curve of the file. */
lw_status lw_space_trace_run(const lw_spatial *m, lw_space_trace *o, lw_space_row_sink *sink, void *context, lw_error *e)
{
    lw_space s = { 0 };
    lw_space_follow f = { 0 };
    lw_space_adjusted adjusted;
    o->away[0] = o->away[1] = -1;
    lw_status st = m->n_input > 0 ? LW_OK : lw_error_set(e, LW_E_ARG, "the model has no input, so there is nothing to move");
    if (st != LW_OK)
        return st;
    st = lw_space_adjust(m, &adjusted, e);
    o->moved = adjusted.moved, o->turned = adjusted.turned;
    m = &adjusted.model;
    st = st < 0 ? st : lw_space_make(m, &s, e);
    if (st != LW_OK)
        return lw_space_adjusted_free(&adjusted), st;
    lw_spatial_measure *input = calloc((size_t)m->n_input, sizeof *input);
    lw_space_tracer *tracer = calloc((size_t)m->n_tracer + 1, sizeof *tracer);
    double *value = calloc(4*(size_t)m->n_input + (size_t)s.n_q, sizeof *value), *q = value + 4*m->n_input;
    if (!input || !tracer || !value)
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; st == LW_OK && i < m->n_input; i++)
        input[i] = m->input[i].measure;
    if (st == LW_OK && !o->in_time && o->whole)
        st = find_ends(&s, input, m->n_input, value, o, e);
    if (st == LW_OK)
        st = lw_space_follow_make(&s, input, m->n_input, false, &f, e);
    if (st == LW_OK) {
        one_input one = { m, value };
        lw_space_path *path = o->in_time ? lw_space_motions : first_alone;
        void *with = o->in_time ? (void *)(uintptr_t)m : &one;
        double ends[2] = { o->from, o->to };
        lw_space_follow_values(&f, value);
        f.u = o->from;
        lw_space_watch w = { 0 };
        for (int k = 0; st == LW_OK && k <= o->intervals; k++) {
            double u = k == o->intervals ? o->to : o->from + (o->to - o->from)*k/o->intervals;
            if (o->stop && *o->stop)
                st = lw_error_set(e, LW_STOPPED, "stopped at %.9g", u);
            else
                st = k == 1 ? lw_space_watch_begin(&w, &f, e) : LW_OK;
            if (st == LW_OK)
                st = lw_space_follow_to(&f, path, with, u, e);
            if (st != LW_OK)
                break;
            lw_space_follow_rates(&f, path, with);
            if (k == 0 && lw_space_follow_opens(&f)) {       /* no row: the step out of it tells why */
                st = lw_space_follow_to(&f, path, with, o->from + (o->to - o->from)/o->intervals, e);
                if (st != LW_OK || (st = lw_space_follow_to(&f, path, with, u, e)) != LW_OK)
                    break;
                lw_space_follow_rates(&f, path, with);
            }
            int end = k == 0 ? 0 : k == o->intervals ? 1 : -1;
            if ((st = show(&f, end, o, q, &u, tracer)) != LW_OK) {
                lw_error_set(e, st, "out of memory");
                break;
            }
            if (end >= 0)
                ends[end] = u;
            double (*at)[3] = (double (*)[3])(void *)(value + m->n_input);
            if ((st = path(with, u, at)) != LW_OK)
                break;
            for (int i = 0; i < m->n_input; i++)          /* the values as people count them */
                f.target[i] = at[i][0] + lw_spatial_offset(&m->input[i]);
            st = sink(context, u, f.target, tracer);
        }
        if (st == LW_OK)
            o->from = ends[0], o->to = ends[1];
        o->lost = w.lost;
        memcpy(o->lost_at, w.between, sizeof w.between);
        memcpy(o->lost_how, w.how, sizeof w.how);
        lw_space_watch_end(&w);
    }
    lw_space_follow_free(&f);
    free(input), free(tracer), free(value);
    lw_space_free(&s);
    lw_space_adjusted_free(&adjusted);
    return st;
}
