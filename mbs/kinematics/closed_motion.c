/* mbs/kinematics/closed_motion.c - follow the legs from limit to limit until the motion closes. */
#include "mbs/kinematics/closed_motion.h"

#include <assert.h>
#include <string.h>

#include "base/vector.h"
#include "mbs/batch/batch.h"
#include "mbs/batch/posture.h"
#include "mbs/kinematics/motion_internal.h"
#include "mbs/plan/plan_internal.h"
#include "mbs/plan/sincos_internal.h"

enum { N_SAMPLE = 64, BLOCK = 32 };

typedef struct walk {
    const lw_plan *plan;
    const double  *dim;
    void          *batch;
    const lw_step *step[LW_DYAD_MAX];            /* the dyads that outputs depend on, in order       */
    int            n_step;
    double         reach;                        /* length of input searched: a turn, or of a slide */
    bool           touches;                      /* a margin came close to 0 without reaching it    */
    double         behind;                       /* the linkage does not close so far behind the last limit, nor a turn on from there; 0: not known */
} walk;

/* A limit lies between these inputs: the linkage closes at `inside` and does not close at `outside`. */
typedef struct bracket { double inside, outside; } bracket;

static void set_walk(walk *w, const lw_plan *plan, const double *dim, void *batch)
{
    bool seen[LW_STEP_MAX] = { false };
    *w = (walk){ .plan = plan, .dim = dim, .batch = batch, .reach = 2*LW_PI };
    for (int o = 0; o < plan->n_output; o++)
        for (int i = 0; i < plan->n_output_step[o]; i++)
            seen[plan->output_step[o][i]] = true;
    for (int i = 0; i < plan->n_step; i++)
        if (seen[i] && plan->step[i].dyad >= 0)
            w->step[w->n_step++] = &plan->step[i];
    if (!plan->input_is_slider)
        return;
    w->reach = 0;
    for (int d = 0; d < plan->n_dim; d++)
        if (plan->dim[d].kind != LW_DIM_ANGLE && plan->dim[d].role < LW_ROLE_CX)
            w->reach += fabs(dim[d]);
}

/* ---- margins ------------------------------------------------------------------------------------- */

/* Margins of n <= BLOCK postures; stride: as dim_stride of mbs/batch/batch.h. */
static void lane_margins(const walk *w, const double *dim, size_t stride, const double *mode, size_t n, const double *input, double *margin)
{
    double c[BLOCK], s[BLOCK], x[BLOCK], y[BLOCK], m[BLOCK];
    for (size_t i = 0; i < n; i++) {
        lw_vec2 u = lw_sincos(input[i]);
        c[i] = w->plan->input_is_slider ? input[i] : u.x;
        s[i] = w->plan->input_is_slider ? 0 : u.y;
        margin[i] = INFINITY;
    }
    lw_lanes in = { .n = n, .c = c, .s = s, .dim = dim, .dim_stride = stride, .mode = mode };
    for (int o = 0; o < w->plan->n_output; o++) {
        lw_batch_point(w->plan, &in, o, w->batch, x, y, NULL, NULL, m);
        for (size_t i = 0; i < n; i++)
            margin[i] = lw_lesser(margin[i], m[i]);
    }
}

/* The margin of dyad *which at one input.  If *which is -1, or a dyad before it does not close, *which becomes the
 * first dyad that does not close, or else the one of least margin.  *outside: some dyad does not close.  Margins of
 * dyads behind such a dyad have no meaning. */
static double one_margin(const walk *w, const double *mode, double input, int *which, bool *outside)
{
    lw_vec2 reg[LW_REG_MAX];
    double m[LW_DYAD_MAX];
    int first = -1, least = 0;
    lw_posture_registers(w->plan, w->dim, mode, input, reg);
    for (int i = 0; i < w->n_step; i++) {
        lw_opening o = lw_dyad_opening(w->dim, w->step[i], reg);
        m[i] = o.less*o.more;
        if (first < 0 && m[i] < 0)
            first = i;
        if (m[i] < m[least])
            least = i;
    }
    *outside = first >= 0;
    if (*which < 0 || (first >= 0 && first != *which))
        *which = first >= 0 ? first : least;
    return m[*which];
}

/* ---- limits -------------------------------------------------------------------------------------- */

/* The linkage closes at three samples, and the margin is least at the middle one.  Find an input between them where it
 * does not close; sample closer as long as a parabola through the lowest three comes near 0. */
static bool dips(walk *w, const double *mode, const double *at, const double *m, bracket *b)
{
    double input[BLOCK], margin[BLOCK], first = at[0], last = at[2], v[3] = { m[0], m[1], m[2] };
    bool close = false;
    for (int level = 0; level < 4; level++) {
        double bend = v[0] - 2*v[1] + v[2], slope = v[2] - v[0];
        int least = 1;
        if (v[1] >= v[0] || v[1] > v[2] || v[1] - slope*slope/(8*bend) > 0.2*v[1])
            break;
        for (int i = 0; i < BLOCK; i++)
            input[i] = first + (last - first)*i/(BLOCK - 1);
        lane_margins(w, w->dim, 0, mode, BLOCK, input, margin);
        for (int i = 1; i < BLOCK; i++)
            if (margin[i] < 0) {
                *b = (bracket){ input[i - 1], input[i] };
                return true;
            }
        for (int i = 2; i < BLOCK - 1; i++)
            if (margin[i] < margin[least])
                least = i;
        first = input[least - 1];
        last = input[least + 1];
        memcpy(v, margin + least - 1, sizeof v);
        close |= v[1] < LW_CLOSED_MOTION_TOUCH;
    }
    w->touches |= close;
    return false;
}

/* Bracket the first limit between `from`, a posture or a limit, and from + reach.  Samples are dense near `from`, where
 * postures vary like the square root of the input.  false: there is none. */
static bool next_limit(walk *w, const double *mode, double from, double reach, bracket *b)
{
    double at[BLOCK + 2] = { from, from }, m[BLOCK + 2] = { 0, 0 };
    for (int block = 0; block < N_SAMPLE/BLOCK; block++) {
        for (int i = 0; i < BLOCK; i++) {
            double t = (double)(block*BLOCK + i + 1)/N_SAMPLE;
            at[i + 2] = from + reach*t*t;
        }
        lane_margins(w, w->dim, 0, mode, BLOCK, at + 2, m + 2);
        for (int i = 2; i < BLOCK + 2; i++) {
            if (block*BLOCK + i > 3 && m[i] >= 0 && dips(w, mode, at + i - 2, m + i - 2, b))
                return true;
            if (m[i] < 0) {
                *b = (bracket){ at[i - 1], at[i] };
                return true;
            }
        }
        memcpy(at, at + BLOCK, sizeof at[0]*2);
        memcpy(m, m + BLOCK, sizeof m[0]*2);
    }
    return false;
}

/* The limit in a bracket: a root of the margin of the first dyad that does not close, by regula falsi with the Illinois
 * weights (Dowell & Jarratt 1971).  That dyad may change while the bracket becomes smaller. */
static double limit_in(const walk *w, const double *mode, bracket b, int *which)
{
    bool outside;
    int side = 0;
    *which = -1;
    double f_outside = one_margin(w, mode, b.outside, which, &outside);
    double f_inside = one_margin(w, mode, b.inside, which, &outside);
    for (int i = 0; i < 100; i++) {
        int dyad = *which;
        double m = b.inside + (b.outside - b.inside)*f_inside/(f_inside - f_outside);
        if (!(f_inside > 0 && f_outside < 0) || (i & 15) == 15)         /* and sometimes, against slow progress */
            m = 0.5*(b.inside + b.outside);
        double f = one_margin(w, mode, m, &dyad, &outside);
        if (m == b.inside || m == b.outside || f == 0)
            return m;
        if (dyad != *which) {
            *which = dyad;
            f_inside = one_margin(w, mode, b.inside, which, &outside);
            outside = true;
            side = 0;
        }
        double *held = outside ? &f_inside : &f_outside;             /* halved when this end stays again         */
        *held *= side == (outside ? -1 : 1) ? 0.5 : 1;
        side = outside ? -1 : 1;
        *(outside ? &b.outside : &b.inside) = m;
        *(outside ? &f_outside : &f_inside) = f;
    }
    return 0.5*(b.inside + b.outside);
}

/* ---- legs ---------------------------------------------------------------------------------------- */

/* Find an input between `from` and the limit `end` where the linkage does not close, by samples that are dense near the
 * end; those of next_limit are far apart there. */
static bool outside_before(walk *w, const double *mode, double from, double end, bracket *b)
{
    double at[BLOCK], m[BLOCK];
    for (int i = 0; i < BLOCK; i++) {
        double t = 1 - (i + 0.5)/BLOCK;
        at[i] = end + (from - end)*t*t;
    }
    lane_margins(w, w->dim, 0, mode, BLOCK, at, m);
    for (int i = 0; i < BLOCK; i++) {
        if (i > 1 && m[i] >= 0 && dips(w, mode, at + i - 2, m + i - 2, b))
            return true;
        if (m[i] < 0) {
            *b = (bracket){ i > 0 ? at[i - 1] : from, at[i] };
            return true;
        }
    }
    return false;
}

/* The end of the leg that begins at `from` and goes up (sense 1) or down (-1), and the dyad whose limit it is.  limit: is `from` a
 * limit?  false: there is no end. */
static bool leg_end(walk *w, const double *mode, double from, int sense, bool limit, double *end, int *which)
{
    bracket b = { from, from };
    double reach = sense*(w->reach - w->behind);
    for (int tries = 0; tries < 3 && b.inside == from; tries++) {      /* sample a short leg closer        */
        if (!next_limit(w, mode, from, reach, &b))
            return false;
        reach = b.outside - from;
    }
    if (limit && b.inside == from)
        return false;
    *end = limit_in(w, mode, b, which);
    for (int tries = 0; tries < 3 && outside_before(w, mode, from, *end, &b); tries++)
        *end = limit_in(w, mode, b, which);
    w->behind = w->plan->input_is_slider ? 0 : fabs(b.outside - *end);
    return true;
}

/* Move *input to the nearest sample where the linkage closes in this assembly mode; false: it closes at none. */
static bool find_inside(const walk *w, const double *mode, double *input)
{
    double at[BLOCK], m[BLOCK], middle = *input;
    for (int block = 0; block < N_SAMPLE/BLOCK; block++) {
        for (int i = 0; i < BLOCK; i++) {
            int k = (block*BLOCK + i + 1)/2;
            at[i] = middle + w->reach*(i % 2 ? k : -k)/N_SAMPLE;
        }
        lane_margins(w, w->dim, 0, mode, BLOCK, at, m);
        for (int i = 0; i < BLOCK; i++)
            if (m[i] > 0) {
                *input = at[i];
                return true;
            }
    }
    return false;
}

/* Is `end` the limit below the start, which lies in the bracket, apart from whole turns (*gain)? */
static bool is_below(const walk *w, bracket below, double end, double *gain)
{
    double turns = w->plan->input_is_slider ? 0 : round((end - below.outside)/(2*LW_PI)), near = 1e-12*w->reach;
    *gain = 2*LW_PI*turns + 0.0;                             /* + 0.0: not -0                            */
    return end - *gain >= below.outside - near && end - *gain <= below.inside + near;
}

/* Add a leg that ends at a limit of dyad `which`, and change the mode of that dyad. */
static void add_leg(const walk *w, double *mode, double end, int which, lw_closed_motion *c)
{
    lw_leg *leg = &c->leg[c->n++];
    leg->last = end;
    leg->dyad = w->step[which]->dyad;
    memcpy(leg->mode, mode, sizeof *mode*(size_t)w->plan->n_dyad);
    mode[leg->dyad] *= lw_step_has_modes(w->step[which]) ? -1 : 0;
}

lw_status lw_closed_motion_find(const lw_plan *plan, const double *dim, const double *mode, double input, void *batch, lw_closed_motion *c)
{
    walk w;
    bracket below;
    int which;
    double end, now[LW_DYAD_MAX];
    size_t modes = sizeof *now*(size_t)plan->n_dyad;
    c->n = 0;
    c->gain = 0;
    if (plan->n_higher > 0 || plan->n_output == 0)
        return LW_E_KIND;
    set_walk(&w, plan, dim, batch);
    if (!find_inside(&w, mode, &input))
        return LW_OPEN;
    bool down = next_limit(&w, mode, input, -w.reach, &below);
    w.behind = down && !plan->input_is_slider ? input - below.outside : 0;
    bool up = leg_end(&w, mode, input, 1, false, &end, &which);
    if (up && !down && !plan->input_is_slider) {             /* the gap above comes again a turn before */
        below = (bracket){ input, end - w.reach };
        down = true;
    }
    if (!up && !down && !plan->input_is_slider)
        return w.touches ? LW_STOPPED : LW_OK;
    if (!up || !down)
        return LW_STOPPED;
    memcpy(now, mode, modes);
    add_leg(&w, now, end, which, c);
    while (c->n < LW_LEG_MAX && leg_end(&w, now, end, c->n % 2 ? -1 : 1, true, &end, &which)) {
        add_leg(&w, now, end, which, c);
        if (now[c->leg[c->n - 1].dyad] == 0)                 /* slides become parallel                   */
            return LW_STOPPED;
        if (c->n % 2 == 0 && memcmp(now, mode, modes) == 0 && is_below(&w, below, end, &c->gain))
            return w.touches ? LW_STOPPED : LW_OK;
    }
    return LW_STOPPED;
}

/* ---- derivatives --------------------------------------------------------------------------------- */

/* An output that depends on this dyad. */
static int output_behind(const lw_plan *plan, int dyad)
{
    for (int o = 0; o < plan->n_output; o++)
        for (int i = 0; i < plan->n_output_step[o]; i++)
            if (plan->step[plan->output_step[o][i]].dyad == dyad)
                return o;
    assert(0);
    return 0;
}

void lw_closed_motion_slopes(const lw_plan *plan, const double *dim, const lw_closed_motion *c, void *batch, double *by)
{
    for (int j = 0; j < c->n; j++) {
        const lw_leg *leg = &c->leg[j];
        double *row = by + (size_t)j*LW_DIM_MAX, x, y, margin, by_input;
        lw_vec2 u = plan->input_is_slider ? lw_v2(leg->last, 0) : lw_sincos(leg->last);
        lw_batch_jacobian(plan, &(lw_lanes){ .n = 1, .c = &u.x, .s = &u.y, .dim = dim, .mode = leg->mode },
                          output_behind(plan, leg->dyad), batch,
                          &(lw_jacobian){ .x = &x, .y = &y, .margin = &margin, .ld = 1, .jm = row, .tm = &by_input });
        for (int d = 0; d < plan->n_dim; d++)
            row[d] = -row[d]/by_input;
    }
}
