/* optimise/precision/exact_rank.c - linkages of two guides and their defects; the list, sorted: without defect,
 * another order, a limit of the input between two positions, two circuits. */
#include "optimise/precision/exact_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/kinematics/motion.h"
#include "mbs/batch/posture.h"
#include "optimise/task/motion_limits.h"

enum { KIND_MAX = 16, WAY = 24 };
#define LONG_LINK 10.0         /* sizes of the target: longer links reduce the quality */
#define SAME_LINKAGE 1e-7
#define OFF          1e-9      /* allowed error at the stations, in sizes of the target or rad              */
#define ALIKE        0.1       /* linkages of a family nearer than this are listed once                    */

/* A type of linkage with its plan, made once. */
typedef struct kind {
    const lw_family *family;
    lw_linkage       k;
    lw_plan          plan;
} kind;

typedef struct entry {
    lw_candidate c;
    unsigned     defect;
    double       quality;
} entry;

struct lw_ranking {
    const lw_target      *t;
    const lw_fit_options *o;
    double   size, alike;
    int      n_kind, n, capacity, keep;
    kind    *of[KIND_MAX];
    entry   *item;                          /* (capacity) sorted                                 */
    long     n_by[4], n_real;               /* clean, order, branch, circuit                 */
    double  *input, *mode;                  /* of the linkage at hand                    (n) */
    bool     no_memory;                     /* for a linkage that was offered                        */
};

/* ---- one linkage ------------------------------------------------------------------------------------ */

static const lw_family *family_of(const char *letters)
{
    const lw_family *f = lw_family_table;
    while (f->name && (strcmp(f->type, letters) != 0 || (f->turns && strcmp(f[1].type ? f[1].type : "", letters) == 0)))
        f++;
    return f->name ? f : NULL;
}

/* Is this type one of o->types? */
static bool asked(const lw_fit_options *o, const char *letters)
{
    const lw_type *type = lw_type_find(letters);
    for (const char *at = o->types; *at;) {
        char word[32] = "";
        size_t n = strcspn(at, ",");
        memcpy(word, at, n < sizeof word ? n : sizeof word - 1);
        if (strcmp(word, "all") == 0 || (type && lw_type_find(word) == type))
            return true;
        at += n + (at[n] == ',');
    }
    return false;
}

static kind *kind_of(lw_ranking *r, const char *letters)
{
    for (int i = 0; i < r->n_kind; i++)
        if (strcmp(r->of[i]->family->type, letters) == 0)
            return r->of[i];
    const lw_family *f = family_of(letters);
    if (!f || !asked(r->o, letters) || r->n_kind == KIND_MAX)
        return NULL;
    kind *now = malloc(sizeof *now);
    if (!now) {
        lw_ranking_lose(r);
        return NULL;
    }
    now->family = f;
    lw_family_linkage(f, r->o->spec.task, &now->k);
    if (lw_plan_make(&now->k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &now->plan, NULL) != LW_OK) {
        free(now);
        return NULL;
    }
    r->of[r->n_kind++] = now;
    return now;
}

static void set_joint(lw_joint *j, lw_vec2 at, lw_vec2 along)
{
    j->at = at;
    if (!lw_joint_turns(j->kind))
        j->along = along;
}

/* Place the joints of a guide in a pose of the tool: at the ground, and at the coupler. */
static void place_guide(const lw_guide *g, lw_vec2 p, double angle, lw_joint *ground, lw_joint *moving)
{
    lw_vec2 u = lw_v2_polar(1, angle), at = lw_v2_add(p, lw_v2_turn(g->point, u));
    if (g->kind == LW_GUIDE_PR)
        set_joint(ground, at, g->along);
    else
        set_joint(ground, g->centre, lw_v2(0, 0));
    if (g->kind == LW_GUIDE_RP) {
        lw_vec2 w = lw_v2_turn(g->along, u);                 /* the point of the line nearest to the pin */
        at = lw_v2_add(at, lw_v2_scale(w, lw_v2_dot(w, lw_v2_sub(g->centre, at))));
        set_joint(moving, at, w);
    } else
        set_joint(moving, at, lw_v2(0, 0));
}

static void letters_of(const lw_guide *a, const lw_guide *b, char letters[5])
{
    static const char *const kinds[] = { "RR", "PR", "RP" };
    const char *x = kinds[a->kind], *y = kinds[b->kind];
    snprintf(letters, 5, "%c%c%c%c", x[0], x[1], y[1], y[0]);
}

/* Read the posture of k at a station: the dimensions at the first, input and mode at all.  false: the dimensions
 * differ, which rounding at a singular posture causes. */
static bool read_station(lw_ranking *r, kind *w, size_t i, lw_candidate *c)
{
    double dim[LW_DIM_MAX], mode[LW_DYAD_MAX];
    if (lw_plan_read(&w->plan, &w->k, i == 0 ? c->dim : dim, mode, &r->input[i], NULL) != LW_OK)
        return false;
    r->mode[i] = mode[0] < 0 ? -1 : 1;
    for (int d = 0; i > 0 && d < w->plan.n_dim; d++)
        if (w->plan.dim[d].kind == LW_DIM_LENGTH && !(fabs(dim[d] - c->dim[d]) <= 1e-6*(fabs(c->dim[d]) + r->size)))
            return false;
    return isfinite(r->input[i]);
}

/* ---- defects -------------------------------------------------------------------------------------- */

/* Is s[0], s[1], ... in cyclic order with this period, rising (sense 1) or falling, within one period? */
static bool cyclic(const double *s, size_t n, double period, int sense)
{
    double travel = 0;
    for (size_t i = 1; i < n; i++) {
        double d = fmod(sense*(s[i] - s[i - 1]), period);
        d += d < 0 ? period : 0;
        travel += d;
    }
    return travel < period*(1 + 1e-12);
}

static bool monotone(const double *s, size_t n, int sense)
{
    for (size_t i = 1; i < n; i++)
        if (!(sense*(s[i] - s[i - 1]) >= 0))
            return false;
    return true;
}

/* Make the inputs continuous, without jumps of a turn. */
static void count_on(lw_ranking *r, bool turns, const lw_range *arc, bool slider, int sense)
{
    for (size_t i = 0; i < r->t->n && !slider; i++)
        if (turns && i > 0) {
            double d = fmod(sense*(r->input[i] - r->input[i - 1]), 2*LW_PI);
            r->input[i] = r->input[i - 1] + sense*(d < 0 ? d + 2*LW_PI : d);
        } else if (!turns) {
            double mid = 0.5*(arc->first + arc->last);
            r->input[i] = mid + remainder(r->input[i] - mid, 2*LW_PI);
        }
}

/* Position along a circuit of two modes, 0 .. 2: rising in the mode of the first station, falling in the other. */
static bool circuit_order(lw_ranking *r, const lw_range *arc, double *s, int *sense)
{
    double whole = arc->last - arc->first;
    for (size_t i = 0; i < r->t->n; i++) {
        double up = (r->input[i] - arc->first)/whole;
        s[i] = r->mode[i] == r->mode[0] ? up : 2 - up;
    }
    *sense = cyclic(s, r->t->n, 2, 1) ? 1 : -1;
    return cyclic(s, r->t->n, 2, *sense);
}

/* Number of the circuit that holds a posture, and the range of its input; -1: none does.  A full turn is one circuit
 * for each mode; a range between limits is one circuit of both modes. */
static int circuit_of(const kind *w, const double *dim, double mode, double input, lw_range *r)
{
    double away = INFINITY;
    int at = -1;
    for (int side = 0; side < 2; side++) {
        lw_range now;
        if (lw_motion_range(&w->plan, dim, side ? -1 : 1, &now) != LW_OK)
            return -1;
        double mid = 0.5*(now.first + now.last), off = input - mid;
        if (!w->plan.input_is_slider)
            off = remainder(off, 2*LW_PI);
        double out = now.turns ? 0 : fabs(off) - 0.5*(now.last - now.first);
        if (out >= away)                                       /* one range has both sides              */
            continue;
        away = fmax(out, 0);
        at = now.turns || !now.limits ? 2*side + (mode < 0) : 4 + side;
        *r = now;
    }
    return at;
}

static unsigned find_defects(lw_ranking *r, const kind *w, lw_candidate *c, double *s)
{
    size_t n = r->t->n;
    lw_range a, here;
    unsigned defect = 0;
    int first = circuit_of(w, c->dim, r->mode[0], r->input[0], &a);
    c->intended.sense = 1;
    for (size_t i = 0; i < n; i++) {
        if (first < 0 || circuit_of(w, c->dim, r->mode[i], r->input[i], &here) != first)
            return LW_DEFECT_CIRCUIT;
        if (r->mode[i] != r->mode[0])
            defect |= LW_DEFECT_BRANCH;
    }
    bool slider = w->plan.input_is_slider, in_order;
    if (a.turns && !defect) {
        c->intended.sense = cyclic(r->input, n, 2*LW_PI, 1) ? 1 : -1;
        in_order = cyclic(r->input, n, 2*LW_PI, c->intended.sense);
        count_on(r, true, &a, slider, c->intended.sense);
    } else {
        count_on(r, false, &a, slider, 1);
        c->intended.sense = r->input[n - 1] >= r->input[0] ? 1 : -1;
        in_order = defect ? circuit_order(r, &a, s, &c->intended.sense) : monotone(r->input, n, c->intended.sense);
    }
    return in_order ? defect : defect | LW_DEFECT_ORDER;
}

/* ---- quality, conditions ----------------------------------------------------------------------------- */

/* The least margin (squared sine of the transmission angle) from station to station. */
static double least_margin(const lw_ranking *r, const kind *w, const lw_candidate *c)
{
    double least = INFINITY;
    for (size_t i = 0; i + 1 < r->t->n; i++) {
        double mode[LW_DYAD_MAX] = { r->mode[i] }, from = r->input[i], by = r->input[i + 1] - from;
        int steps = r->mode[i] == r->mode[i + 1] ? 4 : 0;
        for (int k = 0; k <= steps; k++) {
            lw_posture posture;
            if (lw_posture_solve(&w->plan, c->dim, mode, from + (steps ? by*k/steps : 0), 0, &posture) != LW_OK)
                return 0;
            least = fmin(least, posture.margin);
        }
    }
    return least;
}

/* Rough size of the linkage. */
static double extent(const lw_ranking *r, const kind *w, const lw_candidate *c)
{
    const lw_plan *p = &w->plan;
    const double *l = c->dim;
    double most = 0;
    if (!r->t->x)                              /* of a function, whose size is free: a ratio */
        return fmax(fmax(l[0], l[1]), fmax(l[2], l[3]))/fmin(fmin(l[0], l[1]), fmin(l[2], l[3]));
    for (int d = 0; d < p->n_dim; d++)
        if (p->dim[d].kind != LW_DIM_ANGLE && d != p->i_x0 && d != p->i_y0)
            most = fmax(most, fabs(c->dim[d]));
    if (r->t->x)
        most = fmax(most, hypot(c->dim[p->i_x0] - r->t->x[0], c->dim[p->i_y0] - r->t->y[0]));
    return most;
}

/* Does the motion meet the conditions: over a turn if the input turns, else from station to station? */
static bool moves_as_asked(const lw_ranking *r, const kind *w, const lw_candidate *c)
{
    enum { ROUND = 180 };
    const lw_fit_spec *s = &r->o->spec;
    lw_range range;
    lw_motion_limits limits = lw_motion_limits_begin();
    if (!(s->min_transmission > 0 || s->max_acceleration > 0 || s->n_zone > 0))
        return true;
    bool turns = !w->plan.input_is_slider && lw_motion_range(&w->plan, c->dim, r->mode[0], &range) == LW_OK
              && range.turns;
    for (size_t i = 0; i + 1 < r->t->n && !turns; i++) {
        double mode[LW_DYAD_MAX] = { r->mode[i] };
        lw_motion_limits_run(&w->plan, s, c->dim, mode, r->input[i], r->input[i + 1], WAY, &limits);
        if (r->mode[i] != r->mode[i + 1]) {                  /* across a dead point                    */
            limits.margin_least = 0;
            limits.acceleration = INFINITY;
        }
    }
    if (turns)
        lw_motion_limits_run(&w->plan, s, c->dim, c->intended.mode, 0, 2*LW_PI, ROUND, &limits);
    return lw_motion_limits_meets(&limits, s, &w->k, r->size, NULL, 0);
}

#define ROUNDING 1e-8     /* solutions meet bounds of one value to this, relative to the target */

/* Does it meet the requested bounds? */
static bool within_bounds(const lw_ranking *r, const kind *w, const lw_candidate *c)
{
    const lw_fit_spec *s = &r->o->spec;
    double least = INFINITY, most = 0;
    for (int d = 0; d < w->plan.n_dim; d++) {
        const lw_dim_info *info = &w->plan.dim[d];
        double v = c->dim[d], lo = -INFINITY, hi = INFINITY;
        if (info->kind == LW_DIM_LENGTH) {
            least = fmin(least, v);
            most = fmax(most, v);
        }
        if (info->kind == LW_DIM_LENGTH && s->length_hi > 0) {
            lo = s->length_lo;
            hi = s->length_hi;
        } else if (info->kind == LW_DIM_COORDINATE && s->position_lo < s->position_hi) {
            lo = s->position_lo;
            hi = s->position_hi;
        }
        for (int b = 0; b < s->n_bound; b++)
            if (strcmp(s->bound[b].name, info->name) == 0) {
                lo = s->bound[b].lo;
                hi = s->bound[b].hi;
            }
        double off = ROUNDING*(info->kind == LW_DIM_ANGLE ? 1 : r->size + fabs(v));
        if (info->kind == LW_DIM_ANGLE && isfinite(lo + hi))
            v = 0.5*(lo + hi) + remainder(v - 0.5*(lo + hi), 2*LW_PI);
        if (!(v >= lo - off && v <= hi + off))
            return false;
    }
    return !(s->length_ratio > 0 && most > s->length_ratio*least);
}

/* Does it meet crank_only and exclude_drag_link: the input turns fully, and is the shortest link? */
static bool turns_as_asked(const lw_ranking *r, const kind *w, const lw_candidate *c)
{
    const lw_fit_spec *s = &r->o->spec;
    lw_range range;
    if (!s->crank_only)
        return true;
    if (w->plan.input_is_slider || lw_motion_range(&w->plan, c->dim, r->mode[0], &range) != LW_OK || !range.turns)
        return false;
    if (!s->exclude_drag_link || strcmp(w->family->type, "RRRR") != 0)
        return true;
    return c->dim[1] <= fmin(c->dim[0], fmin(c->dim[2], c->dim[3]));
}

/* ---- the list ------------------------------------------------------------------------------------------ */

static bool better(const entry *a, const entry *b)
{
    return a->defect != b->defect ? a->defect < b->defect : a->quality > b->quality;
}

static bool same(const lw_ranking *r, const entry *a, const entry *b)
{
    if (a->c.family != b->c.family || a->c.n_dim != b->c.n_dim)
        return false;
    for (int d = 0; d < a->c.n_dim; d++) {
        double scale = fabs(a->c.dim[d]) + fabs(b->c.dim[d]) + a->c.dim[0];
        if (!(fabs(a->c.dim[d] - b->c.dim[d]) <= r->alike*scale))
            return false;
    }
    return true;
}

/* Are two four-bars cognates?  For a path one of the three is enough. */
static bool same_curve(const lw_ranking *r, const entry *a, const entry *b)
{
    double other[2][9], mode[2];
    if (lw_task_has_angle(r->o->spec.task) || strcmp(a->c.family->type, "RRRR") != 0
        || lw_fourbar_cognates(a->c.dim, a->c.intended.mode[0], other, mode) != LW_OK)
        return false;
    for (int i = 0; i < 3; i++) {
        const double *d = i < 2 ? other[i] : a->c.dim;
        lw_vec2 p = lw_v2(d[6], d[7]), q = lw_v2_add(p, lw_v2_polar(d[0], d[8]));
        lw_vec2 s = lw_v2(b->c.dim[6], b->c.dim[7]), t = lw_v2_add(s, lw_v2_polar(b->c.dim[0], b->c.dim[8]));
        double near = 1e-6*(r->size + d[0]);
        bool there = lw_v2_norm(lw_v2_sub(p, s)) < near && lw_v2_norm(lw_v2_sub(q, t)) < near
                   && fabs(d[1] - b->c.dim[1]) < near;
        bool turned = lw_v2_norm(lw_v2_sub(p, t)) < near && lw_v2_norm(lw_v2_sub(q, s)) < near
                    && fabs(d[1] - b->c.dim[3]) < near;
        if (there || turned)
            return true;
    }
    return false;
}

static void entry_free(entry *e)
{
    free(e->c.input);
    free(e->c.mode_of);
}

/* Insert it in order; a full list drops its worst. */
static void insert(lw_ranking *r, entry *now)
{
    int at = r->n;
    for (int i = 0; i < r->n; i++)
        if (same(r, &r->item[i], now) || same_curve(r, &r->item[i], now)) {
            if (!better(now, &r->item[i])) {
                entry_free(now);
                return;
            }
            entry_free(&r->item[i]);
            memmove(&r->item[i], &r->item[i + 1], (size_t)(r->n - i - 1)*sizeof *r->item);
            at = --r->n;
            break;
        }
    while (at > 0 && better(now, &r->item[at - 1]))
        at--;
    if (at >= r->capacity) {
        entry_free(now);
        return;
    }
    if (r->n == r->capacity)
        entry_free(&r->item[--r->n]);
    memmove(&r->item[at + 1], &r->item[at], (size_t)(r->n - at)*sizeof *r->item);
    r->item[at] = *now;
    r->n++;
}

static int worst_defect(unsigned defect)
{
    return defect & LW_DEFECT_CIRCUIT ? 3 : defect & LW_DEFECT_BRANCH ? 2 : defect & LW_DEFECT_ORDER ? 1 : 0;
}

/* Find defects and quality of the linkage whose inputs and modes are in r; false: it does not meet the request. */
static bool judge(lw_ranking *r, const kind *w, entry *now)
{
    double s[9];
    now->c.family = w->family;
    now->c.n_dim = w->plan.n_dim;
    now->c.intended.mode[0] = r->mode[0];
    now->c.stop = LW_STOP_F_TARGET;
    now->defect = find_defects(r, w, &now->c, s);
    double margin = now->defect & LW_DEFECT_CIRCUIT ? 0 : least_margin(r, w, &now->c);
    now->quality = sqrt(fmax(0, margin))/(1 + extent(r, w, &now->c)/(LONG_LINK*r->size));
    return within_bounds(r, w, &now->c) && turns_as_asked(r, w, &now->c) && moves_as_asked(r, w, &now->c);
}

/* Would it be listed? */
static bool wanted(const lw_ranking *r, const entry *now)
{
    return r->n < r->capacity || better(now, &r->item[r->n - 1]);
}

static bool own_arrays(lw_ranking *r, entry *now)
{
    size_t bytes = r->t->n*sizeof(double);
    now->c.input = malloc(bytes);
    now->c.mode_of = malloc(bytes);
    now->c.n_dyad = 1;
    if (!now->c.input || !now->c.mode_of) {
        lw_ranking_lose(r);
        entry_free(now);
        return false;
    }
    memcpy(now->c.input, r->input, bytes);
    memcpy(now->c.mode_of, r->mode, bytes);
    now->c.input0 = r->input[0];
    return true;
}

/* Eq. 17 at the postures that the plan computes for the stations. */
static double objective(const lw_ranking *r, const kind *w, const lw_candidate *c)
{
    const lw_target *t = r->t;
    const lw_fit_spec *s = &r->o->spec;
    bool place = lw_task_has_place(s->task);
    double f = 0;
    for (size_t i = 0; i < t->n; i++) {
        double mode[LW_DYAD_MAX] = { c->mode_of[i] };
        lw_posture posture;
        lw_posture_solve(&w->plan, c->dim, mode, c->input[i], 0, &posture);
        if (place) {
            double d = hypot(posture.tracer[0][0].x - t->x[i], posture.tracer[0][0].y - t->y[i]);
            f += s->a*t->weight[i]*d*d;
        }
        if (lw_task_has_angle(s->task)) {
            double d = remainder(posture.angle[place ? 2 : 3][0] + c->tool0 - t->theta[i], 2*LW_PI);
            f += s->b*t->weight[i]*d*d;
        }
    }
    return f;
}

/* Does the plan compute postures at the stations?  At a singular posture rounding decides the mode. */
static bool reaches(lw_ranking *r, const kind *w, entry *now)
{
    const lw_fit_spec *s = &r->o->spec;
    double near = OFF*r->size, weight = 0;
    for (size_t i = 0; i < r->t->n; i++)
        weight += r->t->weight[i];
    now->c.objective = objective(r, w, &now->c);
    if (now->c.objective <= weight*(s->a*near*near + s->b*OFF*OFF))
        return true;
    entry_free(now);
    return false;
}

/* Finish a linkage whose stations were read; its tool has this angle at the first station, and is on this link. */
static bool complete(lw_ranking *r, const kind *w, int link, double angle, entry *now)
{
    double mode[LW_DYAD_MAX] = { r->mode[0] };
    lw_posture posture;
    if (!judge(r, w, now))
        return false;
    if (lw_task_has_angle(r->o->spec.task) && lw_posture_solve(&w->plan, now->c.dim, mode, r->input[0], 0, &posture) == LW_OK)
        now->c.tool0 = remainder(angle - posture.angle[link][0], 2*LW_PI);
    return own_arrays(r, now) && reaches(r, w, now);
}

/* Make the linkage with guide `a` at the input; *now gets arrays of its own. */
static bool build(lw_ranking *r, const lw_guide *a, const lw_guide *b, const double *angle, entry *now)
{
    char letters[5];
    letters_of(a, b, letters);
    kind *w = kind_of(r, letters);
    if (!w)
        return false;
    for (size_t i = 0; i < r->t->n; i++) {
        lw_vec2 p = lw_v2(r->t->x[i], r->t->y[i]);
        place_guide(a, p, angle[i], &w->k.joint[0], &w->k.joint[1]);
        place_guide(b, p, angle[i], &w->k.joint[3], &w->k.joint[2]);
        w->k.tracer[0].at = p;
        if (!read_station(r, w, i, &now->c))
            return false;
    }
    return complete(r, w, 2, angle[0], now);
}

static void count(lw_ranking *r, entry *now)
{
    r->n_real++;
    r->n_by[worst_defect(now->defect)]++;
    if (wanted(r, now))
        insert(r, now);
    else
        entry_free(now);
}

void lw_ranking_offer(lw_ranking *r, const lw_guide *a, const lw_guide *b, const double *angle)
{
    entry one = { .c = { .input = NULL } }, two = one;
    bool first = build(r, a, b, angle, &one), second = build(r, b, a, angle, &two);
    if (first && second) {
        bool turn = better(&two, &one);
        entry_free(turn ? &one : &two);
        count(r, turn ? &two : &one);
    } else if (first || second)
        count(r, first ? &one : &two);
}

/* Make a function generator: frame along x with length one. */
static bool build_function(lw_ranking *r, const lw_function_bar *bar, entry *now)
{
    kind *w = kind_of(r, "RRRR");
    if (!w)
        return false;
    for (size_t i = 0; i < r->t->n; i++) {
        double in = bar->input0 + r->t->angle[i] - r->t->angle[0], out = bar->output0 + r->t->theta[i] - r->t->theta[0];
        lw_joint *j = w->k.joint;
        j[0].at = lw_v2(0, 0);
        j[3].at = lw_v2(bar->length[0], 0);
        j[1].at = lw_v2_polar(bar->length[1], in);
        j[2].at = lw_v2_add(j[3].at, lw_v2_polar(bar->length[3], out));
        w->k.tracer[0].at = j[2].at;
        if (!read_station(r, w, i, &now->c))
            return false;
    }
    return complete(r, w, 3, r->t->theta[0], now);
}

void lw_ranking_offer_function(lw_ranking *r, const lw_function_bar *bar)
{
    entry now = { .c = { .input = NULL } };
    if (build_function(r, bar, &now))
        count(r, &now);
}

/* ---- open, finish, close ------------------------------------------------------------------------------- */

lw_status lw_ranking_open(const lw_target *t, const lw_fit_options *o, bool family, lw_ranking **out, lw_error *e)
{
    lw_ranking *r = calloc(1, sizeof *r);
    *out = r;
    if (!r)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a list of linkages");
    r->t = t;
    r->o = o;
    r->size = t->x && t->size > 0 ? t->size : 1;
    r->alike = family ? ALIKE : SAME_LINKAGE;
    r->capacity = o->n_result > 0 ? o->n_result : 1;
    r->item = calloc((size_t)r->capacity + 1, sizeof *r->item);
    r->input = malloc(2*t->n*sizeof *r->input);
    r->mode = r->input + t->n;
    if (r->item && r->input)
        return LW_OK;
    lw_ranking_close(r);
    *out = NULL;
    return lw_error_set(e, LW_E_MEMORY, "no memory for a list of linkages");
}

bool lw_ranking_slides(const lw_ranking *r)
{
    for (const lw_type *t = lw_type_table; t->letters; t++)
        if (strcmp(t->letters, "RRRR") != 0 && asked(r->o, t->letters))
            return true;
    return false;
}

void lw_ranking_merge(lw_ranking *r, lw_ranking *from)
{
    if (!from)
        return;
    for (int i = 0; i < from->n; i++)
        if (wanted(r, &from->item[i]))
            insert(r, &from->item[i]);
        else
            entry_free(&from->item[i]);
    r->no_memory |= from->no_memory;
    r->n_real += from->n_real;
    for (int i = 0; i < 4; i++)
        r->n_by[i] += from->n_by[i];
    from->n = 0;
}

void lw_ranking_close(lw_ranking *r)
{
    if (!r)
        return;
    for (int i = 0; i < r->n; i++)
        entry_free(&r->item[i]);
    for (int i = 0; i < r->n_kind; i++)
        free(r->of[i]);
    free(r->item);
    free(r->input);
    free(r);
}

void lw_ranking_lose(lw_ranking *r) { r->no_memory = true; }

lw_status lw_ranking_finish(lw_ranking *r, lw_exact *out)
{
    size_t n = (size_t)r->n;
    out->n_real = r->n_real;
    out->n_clean = r->n_by[0];
    out->n_order = r->n_by[1];
    out->n_branch = r->n_by[2];
    out->n_circuit = r->n_by[3];
    out->fit.candidate = calloc(n + 1, sizeof *out->fit.candidate);
    out->defect = calloc(n + 1, sizeof *out->defect);
    out->quality = calloc(n + 1, sizeof *out->quality);
    if (r->no_memory || !out->fit.candidate || !out->defect || !out->quality)
        return LW_E_MEMORY;
    for (size_t i = 0; i < n; i++) {
        out->fit.candidate[i] = r->item[i].c;
        out->defect[i] = r->item[i].defect;
        out->quality[i] = r->item[i].quality;
    }
    out->fit.n = r->n;
    r->n = 0;                                    /* the candidates own their arrays now         */
    return n > 0 ? LW_OK : LW_NOTHING;
}
