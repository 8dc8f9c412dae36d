/* Continuation: follow the higher groups of a plan from their seed along the input, lane by lane.
 *
 * Eight postures are tried at once (kernel_certified_step_internal.h) and accepted up to the first that is not
 * certified.  Lanes closer together than a step are interpolated.  At a limit of motion the steps become shorter; the
 * continuation ends when they are shorter than END. */
#include "mbs/batch/kernel_certified_step_internal.h"

#define STRIDE_FIRST 0.05                  /* first step: [rad], or times the size                    */
#define STRIDE_MAX 0.35                    /* longest step                                            */
#define STRIDE_BETWEEN 0.06                /* lanes closer to each other are interpolated             */
#define TIGHT 0.1                          /* margin of a dyad, and of a group, below which no lane   */
#define TIGHT_GROUP 0.03                   /* is interpolated                                         */
#define END 1e-6                           /* a shorter step ends the continuation                    */
#define END_FINE 1e-12

/* ---- a path of inputs ------------------------------------------------------------------------------------- */

static double unit_of(const follower *f)
{
    return f->plan->input_is_slider ? f->size : 1.0/f->plan->input_turns_per_period;
}

/* Start at the seed in mode[].  f->lost: there is no posture near it.  work: lw_continuation_size doubles. */
static void follow_from_seed(follower *f, const lw_plan *plan, const double *dim, const double *mode, bool fine, double *work)
{
    double input = mode[plan->n_mode - 1];
    f->plan = plan;
    f->fine = fine;
    f->size = lw_plan_size(plan, dim);
    f->k = start(plan, LW_GROUP, work);
    f->k.c = (const double *)&f->c;
    f->k.s = (const double *)&f->s;
    f->k.dim = dim;
    f->k.mode = mode;
    f->k.dim_row = f->k.mode_row = 1;
    ground_rows(&f->k, LW_GROUP);
    set_turns(&f->k, plan->n_angle, 0, 1);
    f->past_seed = f->pushed = f->tight = false;
    f->at.head = 0;
    f->at.n_past = 1;
    f->at.stride = STRIDE_FIRST*unit_of(f);
    f->at.past[0].t = input;
    for (int g = 0; g < plan->n_higher; g++) {
        const lw_higher *h = &plan->higher[g];
        const double *from = mode + h->first_mode;
        double *row = f->at.past[0].row + h->first_row;
        for (int a = 0; a < h->n_turn; a++, from++) {
            lw_vec2 u = turn(*from);
            *row++ = u.x;
            *row++ = u.y;
        }
        for (int d = 0; d < h->n_disp; d++)
            *row++ = *from++*f->size;
        take_group(&f->group[g], h);
        f->group[g].size = f->size;
        f->group[g].ends = !plan->input_is_slider;
        f->pushed |= f->group[g].driven;
        load_vectors(&f->k, &f->group[g], 0, 0);
        load_angles(&f->k, &f->group[g]);
        load_meshes(&f->k, h, 0, 0, &f->group[g].mesh);
    }
    try_steps(f, all8(input));
    f->lost = !f->certified[0];
    f->past_seed = true;
    if (!f->lost)
        accept(f, all8(input), 1);
}

/* Inputs to follow: `count` of them from t[first] on, up or down the array (step 1 or -1). */
typedef struct input_path { const double *t; size_t first, step, count; } input_path;

static double path_at(const input_path *path, size_t i) { return path->t[path->first + i*path->step]; }

/* Eight inputs to try, and the number of inputs of the path that each one has passed. */
typedef struct route { pack t; size_t passed[LW_GROUP]; int n; } route;

static void lay_route(const follower *f, const input_path *path, size_t i, route *r)
{
    double at = back(&f->at, 0)->t, unit = unit_of(f), stride = f->at.stride;
    double skip = f->tight ? 0 : fmin(stride, STRIDE_BETWEEN*unit);
    for (r->n = 0; r->n < LW_GROUP && i < path->count; r->n++) {
        double gap = path_at(path, i) - at;
        if (fabs(gap) <= 1.3*stride) {
            for (i++; i < path->count && fabs(path_at(path, i) - at) <= skip; )
                i++;
            at = path_at(path, i - 1);
        } else
            at += gap/ceil(fabs(gap)/stride);
        r->t[r->n] = at;
        r->passed[r->n] = i;
    }
    for (int j = r->n; j < LW_GROUP; j++)
        r->t[j] = at;
}

typedef struct chunk chunk;
static void put_passed(const follower *f, const chunk *q, const input_path *path, const route *r, size_t i, int count);
static void put_present(const follower *f, const chunk *q, const input_path *path, size_t i, size_t end);

/* Is a group, or a dyad that carries a group, near or past a limit, where the posture varies like the square root of
 * the input? */
static bool near_limit(const follower *f, int n)
{
    for (int j = 0; j < n; j++)
        if (f->k.margin[j] < TIGHT || f->margin[j] < TIGHT_GROUP)
            return true;
    return false;
}

/* Follow the path and store each posture reached in q, unless q is NULL.  Returns the number of inputs reached. */
static size_t follow_path(follower *f, const input_path *path, const chunk *q)
{
    double unit = unit_of(f);
    size_t i = 0;
    for (size_t tries = 0; i < path->count && tries < 4000 + path->count; tries++) {
        route r;
        int n = 0;
        lay_route(f, path, i, &r);
        double gap = fabs(r.t[0] - back(&f->at, 0)->t);
        try_steps(f, r.t);
        while (n < r.n && f->certified[n])
            n++;
        if (r.passed[r.n - 1] > i + (size_t)r.n && near_limit(f, r.n)) {           /* then interpolate none        */
            f->tight = true;
            continue;
        }
        f->tight = f->tight && near_limit(f, n);
        if (n == 0 && gap == 0) {            /* too near a limit for a step, but the posture is known */
            if (q)
                put_present(f, q, path, i, r.passed[0]);
            i = r.passed[0];
            continue;
        }
        if (n == 0) {
            f->at.stride = gap*fmin(0.5, fmax(0.125, 0.5/f->need[0]));
            bool at_seed = f->at.n_past == 1;       /* a seed beside a limit: the way from there begins in short steps */
            if (!(f->at.stride >= (f->fine || at_seed ? END_FINE : END)*unit))
                break;
            continue;
        }
        if (q)
            put_passed(f, q, path, &r, i, n);
        i = r.passed[n - 1];
        gap = n > 1 ? fabs(r.t[n - 1] - r.t[n - 2]) : gap;
        accept(f, r.t, n);
        if (n == r.n)
            f->at.stride = fmin(STRIDE_MAX*unit, fmax(f->at.stride, gap*fmin(2, 0.9/f->need[n - 1])));
        else
            f->at.stride = n < 3 ? 0.5*f->at.stride : f->at.stride;
    }
    return i;
}

/* Follow the groups to input `to`; false when a limit comes first. */
static bool advance(follower *f, double to) { return follow_path(f, &(input_path){ &to, 0, 1, 1 }, NULL) == 1; }

/* ---- a chunk of lanes ------------------------------------------------------------------------------------ */

struct chunk {
    size_t  n, row;                        /* lanes; doubles in a row of group_posture                   */
    double *group_posture;                 /* n_row rows, then the distance out of reach              */
    double  t[LW_CHUNK + LW_GROUP];        /* inputs in the order in which they are followed          */
    unsigned short lane[LW_CHUNK + LW_GROUP];        /* lane of each of these                         */
    bool    ordered, falls;                /* inputs only rise or only fall; most of them fall        */
    bool    in_place;                      /* lane[i] is i                                            */
};

/* Store posture j of the last try as lane `at`, which is reached. */
static void put_trial(const follower *f, const chunk *q, size_t at, int j)
{
    for (int r = 0; r < f->plan->n_row; r++)
        q->group_posture[(size_t)r*q->row + at] = f->row[r][j];
    q->group_posture[(size_t)f->plan->n_row*q->row + at] = 0;
}

/* Store the present posture as lane `at`. */
static void put_group_posture(const follower *f, const chunk *q, size_t at, double out_of_reach)
{
    for (int r = 0; r < f->plan->n_row; r++)
        q->group_posture[(size_t)r*q->row + at] = back(&f->at, 0)->row[r];
    q->group_posture[(size_t)f->plan->n_row*q->row + at] = out_of_reach;
}

/* Store the present posture as lanes i .. end-1 of the path. */
static void put_present(const follower *f, const chunk *q, const input_path *path, size_t i, size_t end)
{
    for (; i < end; i++)
        put_group_posture(f, q, q->lane[path->first + i*path->step], 0);
}

/* Write the inputs of the lanes as continuous numbers: the angle of a pin changes by at most half a turn per lane. */
static void unroll(const follower *f, const lw_lanes *in, chunk *q)
{
    const double *c = in->c, *s = in->s;
    double last = 0, turned = 0;
    int up = 0, down = 0;
    if (f->plan->input_is_slider)
        memcpy(q->t, c, q->n*sizeof *c);
    else
        for (size_t i = 0; i < q->n; i++)
            q->t[i] = lw_bearing(c[i], s[i]);
    for (size_t i = 0; i < q->n; i++) {
        double t = q->t[i], step = i > 0 ? t - last : 0, by = 0;
        if (!f->plan->input_is_slider && fabs(step) > LW_PI)
            by = step > 0 ? -2*LW_PI : 2*LW_PI;
        turned += by;
        up += step + by > 0;
        down += step + by < 0;
        last = t;
        q->t[i] = t + turned;
        q->lane[i] = (unsigned short)i;
    }
    q->ordered = !up || !down;
    q->falls = down > up;
    q->in_place = q->ordered && !q->falls;
}

/* Sort lanes that are in no order by their inputs within half a turn of the present one. */
static void sort_lanes(const follower *f, chunk *q)
{
    double now = back(&f->at, 0)->t;
    for (size_t i = 0; i < q->n; i++) {
        if (!f->plan->input_is_slider)
            q->t[i] = now + remainder(q->t[i] - now, 2*LW_PI);
        double t = q->t[i];
        unsigned short from = q->lane[i];
        size_t k = i;
        for (; k > 0 && q->t[k - 1] > t; k--) {
            q->t[k] = q->t[k - 1];
            q->lane[k] = q->lane[k - 1];
        }
        q->t[k] = t;
        q->lane[k] = from;
    }
}

static void reverse_lanes(chunk *q)
{
    for (size_t i = 0; i < q->n/2; i++) {
        double t = q->t[i];
        unsigned short from = q->lane[i];
        q->t[i] = q->t[q->n - 1 - i];
        q->lane[i] = q->lane[q->n - 1 - i];
        q->t[q->n - 1 - i] = t;
        q->lane[q->n - 1 - i] = from;
    }
}

/* An interpolating polynomial: its nodes and their constants. */
typedef struct between { const node *at; int n; double by[NODES]; } between;

LW_INLINE void between_at(const follower *f, const between *b, pack t, pack *row)
{
    pack weight[NODES];
    weights(b->at, b->n, b->by, t, weight);
    for (int h = 0; h < f->plan->n_higher; h++)
        blend(&f->plan->higher[h], b->at, b->n, weight, 1, row);
    row[f->plan->n_row] = (pack){ 0 };
}

/* Interpolate `count` lanes from `first` on, eight or more; the last eight may overlap those before. */
static void put_block(const follower *f, const chunk *q, const between *b, size_t first, size_t count)
{
    pack row[LW_GROUP_ROW_MAX + 1];
    for (size_t i = 0; i < count; i += LW_GROUP) {
        size_t at = first + (i + LW_GROUP <= count ? i : count - LW_GROUP);
        between_at(f, b, get8(q->t + at), row);
        for (int r = 0; r <= f->plan->n_row; r++)
            put8(q->group_posture + (size_t)r*q->row + at, row[r]);
    }
}

/* Interpolate lanes i .. end-1 of the path between nearby nodes. */
static void put_between(const follower *f, const chunk *q, const input_path *path, const node *near, int n, size_t i, size_t end)
{
    pack t = { 0 }, row[LW_GROUP_ROW_MAX + 1];
    between b = { near, n, { 0 } };
    if (i == end)
        return;
    constants(near, n, b.by);
    if (q->in_place && end - i >= LW_GROUP) {
        put_block(f, q, &b, path->step == 1 ? path->first + i : path->first - (end - 1), end - i);
        return;
    }
    for (; i < end; i += LW_GROUP) {
        size_t count = end - i < LW_GROUP ? end - i : LW_GROUP;
        for (size_t j = 0; j < LW_GROUP; j++)
            t[j] = path_at(path, i + (j < count ? j : count - 1));
        between_at(f, &b, t, row);
        for (int r = 0; r <= f->plan->n_row; r++)
            for (size_t j = 0; j < count; j++)
                q->group_posture[(size_t)r*q->row + q->lane[path->first + (i + j)*path->step]] = row[r][j];
    }
}

/* Store the lanes from i on that the first `count` inputs tried have passed. */
static void put_passed(const follower *f, const chunk *q, const input_path *path, const route *r, size_t i, int count)
{
    node all[3 + LW_GROUP];
    int n = 0;
    for (int a = f->at.n_past < 3 ? f->at.n_past - 1 : 2; a >= 0; a--)
        all[n++] = (node){ back(&f->at, a)->t, back(&f->at, a)->row, 1 };
    if (all[n - 1].t == r->t[0])
        n--;
    for (int s = 0, first = n; s < count; i = r->passed[s++]) {
        for (; n < first + count && n < first + s + 3; n++)
            all[n] = (node){ r->t[n - first], (const double *)f->row + (n - first), LW_GROUP };
        if (r->passed[s] == i)
            continue;
        int from = n > NODES ? n - NODES : 0;
        put_between(f, q, path, all + from, n - from, i, r->passed[s] - 1);
        size_t at = r->passed[s] - 1;
        put_trial(f, q, q->lane[path->first + at*path->step], s);
    }
}

/* Follow the lanes from `first` on in one direction (1 or -1); lanes beyond the end get the last posture. */
static void follow_lanes(follower *f, chunk *q, size_t first, size_t step)
{
    const input_path path = { q->t, first, step, step == 1 ? q->n - first : first + 1 };
    for (size_t i = follow_path(f, &path, q); i < path.count; i++) {
        double beyond = fabs(path_at(&path, i) - back(&f->at, 0)->t)/unit_of(f);
        put_group_posture(f, q, q->lane[first + i*step], fmax(beyond, BEYOND_LEAST));
    }
}

/* Copy the parts of the progress that are in use. */
static void copy_progress(progress *to, const progress *from, const lw_plan *plan)
{
    to->head = from->head;
    to->n_past = from->n_past;
    to->stride = from->stride;
    for (int i = 0; i < from->n_past; i++) {
        const place *p = back(from, i);
        place *copy = &to->past[(from->head + i)%PAST];
        copy->t = p->t;
        memcpy(copy->row, p->row, (size_t)plan->n_row*sizeof *p->row);
    }
    for (int h = 0; h < plan->n_higher; h++)
        if (plan->higher[h].n_slide > 0)
            memcpy(to->known[h], from->known[h], (size_t)plan->higher[h].n_dir*sizeof *to->known[h]);
    memcpy(to->bend, from->bend, lw_inverse_rows(plan)*sizeof *to->bend);
    memcpy(to->push, from->push, lw_inverse_rows(plan)*sizeof *to->push);
}

/* Follow all lanes of a chunk that share dimensions and seed.  When more chunks come, f is left at the last lane if the
 * lanes are in order, else where it started. */
static void follow_chunk(follower *f, const lw_lanes *in, bool more, chunk *q)
{
    size_t first = 0;
    progress here;
    unroll(f, in, q);
    if (!q->ordered)
        sort_lanes(f, q);
    else if (q->falls)
        reverse_lanes(q);
    if (q->ordered && !f->plan->input_is_slider) {
        double shift = 2*LW_PI*nearbyint((back(&f->at, 0)->t - 0.5*(q->t[0] + q->t[q->n - 1]))/(2*LW_PI));
        for (size_t i = 0; i < q->n; i++)
            q->t[i] += shift;
    }
    while (first < q->n && q->t[first] < back(&f->at, 0)->t)
        first++;
    bool down_last = q->falls || !q->ordered, both = first > 0 && first < q->n;
    bool none_last = first == (down_last ? 0 : q->n);
    if (both || more)
        copy_progress(&here, &f->at, f->plan);
    follow_lanes(f, q, down_last ? first : first - 1, down_last ? 1 : (size_t)-1);
    if (both || (more && none_last))
        copy_progress(&f->at, &here, f->plan);
    follow_lanes(f, q, down_last ? first - 1 : first, down_last ? (size_t)-1 : 1);
    if (more && !q->ordered)
        copy_progress(&f->at, &here, f->plan);
    else if (more && none_last)
        advance(f, q->t[down_last ? 0 : q->n - 1]);
}

/* Follow one lane that has dimensions or a seed of its own. */
static void follow_lane(follower *f, const lw_plan *plan, const lw_lanes *in, size_t at, double *work, chunk *q)
{
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    for (int d = 0; d < plan->n_dim; d++)
        dim[d] = in->dim_stride ? in->dim[(size_t)d*in->dim_stride + at] : in->dim[d];
    for (int m = 0; m < plan->n_mode; m++)
        mode[m] = in->mode_stride ? in->mode[(size_t)m*in->mode_stride + at] : in->mode[m];
    follow_from_seed(f, plan, dim, mode, false, work);
    double to = plan->input_is_slider ? in->c[at] : atan2(in->s[at], in->c[at]), now = back(&f->at, 0)->t, out = 1;
    if (!plan->input_is_slider)
        to = now + remainder(to - now, 2*LW_PI);
    if (!f->lost)
        out = advance(f, to) ? 0 : fmax(fabs(to - back(&f->at, 0)->t)/unit_of(f), 1e-12);
    put_group_posture(f, q, at, out);
}

/* Find the postures of the groups in all lanes of a chunk; repeat the last lane to a full group. */
static void group_postures_of_chunk(follower *f, const lw_plan *plan, const lw_lanes *in, bool more, double *work, chunk *q)
{
    q->n = in->n;
    if (in->dim_stride || in->mode_stride)
        for (size_t i = 0; i < in->n; i++)
            follow_lane(f, plan, in, i, work, q);
    else if (f->lost)
        for (size_t i = 0; i < in->n; i++)
            put_group_posture(f, q, i, 1);
    else
        follow_chunk(f, in, more, q);
    for (size_t i = in->n; i%LW_GROUP; i++)
        for (int r = 0; r <= plan->n_row; r++)
            q->group_posture[(size_t)r*q->row + i] = q->group_posture[(size_t)r*q->row + in->n - 1];
}

/* The lanes of a plan with higher groups, in chunks: the first part of the scratch. */
typedef struct chunks { follower f; chunk q; lw_lanes part; size_t first, next; double *lane_work; } chunks;
const size_t lw_follow_size = sizeof(chunks);

/* The posture of the groups at one input, for mbs/batch/posture.c. */
void lw_kernel_group_posture(const lw_plan *plan, const double *dim, const double *mode, double input, void *work,
                        lw_group_posture *group_posture)
{
    chunks *c = lw_scratch_align(work);
    follower *f = &c->f;
    follow_from_seed(f, plan, dim, mode, true, (double *)(c + 1));
    double to = input;
    if (!plan->input_is_slider)
        to = back(&f->at, 0)->t + remainder(input - back(&f->at, 0)->t, 2*LW_PI);
    bool there = !f->lost && advance(f, to);
    memset(group_posture, 0, sizeof *group_posture);
    memcpy(group_posture->row, back(&f->at, 0)->row, (size_t)plan->n_row*sizeof(double));
    group_posture->margin = 1;
    if (!there)
        group_posture->margin = f->lost ? -1 : -fmax(fabs(to - back(&f->at, 0)->t)/unit_of(f), 1e-12);
    double *inverse = group_posture->inverse;
    for (int g = 0; there && g < plan->n_higher; g++) {
        const eight *w = &f->group[g];
        group_posture->margin = fmin(group_posture->margin, w->margin[f->at_lane]);
        for (int i = 0; i < w->n*w->n; i++)
            *inverse++ = w->inv[i][f->at_lane];
    }
}

static lw_lanes part_of(const lw_lanes *in, size_t first, size_t n)
{
    lw_lanes p = *in;
    p.n = n;
    p.c = in->c + first;
    p.s = in->s ? in->s + first : NULL;
    p.dim = in->dim_stride ? in->dim + first : in->dim;
    p.mode = in->mode_stride ? in->mode + first : in->mode;
    return p;
}

static void begin_chunks(chunks *c, const lw_plan *plan, const lw_lanes *in, void *work)
{
    c->q.group_posture = work;
    c->q.row = LW_CHUNK + LW_GROUP;
    double *follow = c->q.group_posture + ((size_t)plan->n_row + 1)*c->q.row;
    c->lane_work = follow + lw_continuation_size(plan);
    c->next = 0;
    if (!in->dim_stride && !in->mode_stride)
        follow_from_seed(&c->f, plan, in->dim, in->mode, false, follow);
}

/* The last chunk is merged with the one before so that none is smaller than LW_GROUP lanes. */
static bool next_chunk(chunks *c, const lw_plan *plan, const lw_lanes *in)
{
    size_t rest = in->n - c->next, n = rest < LW_CHUNK + LW_GROUP ? rest : LW_CHUNK;
    if (rest == 0)
        return false;
    c->first = c->next;
    c->next += n;
    c->part = part_of(in, c->first, n);
    group_postures_of_chunk(&c->f, plan, &c->part, c->next < in->n, c->lane_work - lw_continuation_size(plan), &c->q);
    return true;
}

void lw_in_chunks(const lw_plan *plan, const lw_lanes *in, void *work, lw_chunk_work *work_on, void *caller)
{
    chunks *c = lw_scratch_align(work);
    begin_chunks(c, plan, in, (double *)(c + 1));
    while (next_chunk(c, plan, in))
        work_on(caller, &c->part, c->first, c->lane_work, c->q.group_posture);
}
