#include "grammar/model/work_cycle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "grammar/linkage/read_internal.h"
#include "grammar/model/model_internal.h"

/* The position of each axis, and since when it rests. */
typedef struct plan { lw_work_cycle *c; lw_axis_state *at; double *free_at; double time; } plan;

/* 3 or, by direction, [-1, 3]; infinite when left out. */
static lw_status read_limit(const lw_json_node *object, const char *key, double limit[2], lw_error *e)
{
    lw_json_node n;
    lw_vec2 pair = { -INFINITY, INFINITY };
    bool given = lw_json_member(object, key, &n), both = given && lw_json_kind_of(&n) == LW_JSON_ARRAY;
    lw_status s = both ? lw_read_pair(&n, 1, &pair, e) : given ? lw_json_number(&n, &pair.y, e) : LW_OK;
    limit[0] = both ? pair.x : -pair.y;
    limit[1] = pair.y;
    if (s == LW_OK && !(limit[0] < 0 && limit[1] > 0))
        s = lw_json_fault(&n, e, "a limit is a number above 0, or one for each direction, like [-1, 3]");
    return s;
}

static lw_status read_axis(const lw_json_node *object, lw_work_cycle *c, lw_error *e)
{
    static const char *const known[] = { "name", "speed", "acceleration", "jerk", "at" };
    lw_cycle_axis *a = &c->axis[c->n_axis];
    lw_axis_limits *limits = &a->limits;
    const lw_number_key at = { "at", 1, LW_ANY, &a->start, NULL };
    lw_json_node n;
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK
        && (s = lw_read_need(object, "name", &n, e)) == LW_OK && (s = lw_json_name(&n, a->name, sizeof a->name,
            e)) == LW_OK)
        s = lw_read_numbers(object, &at, 1, e);
    for (int i = 0; s == LW_OK && i < c->n_axis; i++)
        if (strcmp(c->axis[i].name, a->name) == 0)
            s = lw_json_fault(&n, e, "the name \"%s\" is given twice", a->name);
    if (s == LW_OK && (s = read_limit(object, "speed", limits->v, e)) == LW_OK
        && (s = read_limit(object, "acceleration", limits->a, e)) == LW_OK)
        s = read_limit(object, "jerk", limits->j, e);
    if (s == LW_OK && isinf(limits->a[1]) && isinf(limits->j[1]))
        s = lw_json_fault(object, e, "axis \"%s\" needs a limit of \"acceleration\" or \"jerk\"", a->name);
    c->n_axis++;
    return s;
}

/* Values of axes, {"x": 0.5, "z": 1}; moves (may be NULL) marks the axes named. */
static lw_status read_places(const lw_json_node *object, const lw_work_cycle *c, double *value, bool *moves, lw_error *e)
{
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    const char **names = malloc((size_t)c->n_axis*sizeof *names);
    if (s == LW_OK && !names)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < c->n_axis; i++)
        names[i] = c->axis[i].name;
    if (s == LW_OK)
        s = lw_json_known_keys(object, names, c->n_axis, e);
    for (int i = 0; s == LW_OK && i < c->n_axis; i++) {
        lw_json_node n;
        if (!lw_json_member(object, names[i], &n))
            continue;
        s = lw_json_number(&n, &value[i], e);
        if (moves)
            moves[i] = true;
        else if (s == LW_OK && !(value[i] >= c->axis[i].limits.v[0] && value[i] <= c->axis[i].limits.v[1]))
            s = lw_json_fault(&n, e, "this speed is above the limit %g of axis \"%s\"", c->axis[i].limits.v[value[i] > 0], names[i]);
    }
    free(names);
    return s;
}

/* Plan the move once its goal is known. */
static lw_status plan_move(const lw_json_node *object, plan *p, lw_cycle_move *m, const double *goal,
                           const double *speed,
                           double duration, bool straight, lw_error *e)
{
    lw_work_cycle *c = p->c;
    size_t n = 0, count = (size_t)c->n_axis;
    lw_axis_state *from = calloc(2*count, sizeof *from), *to = from + count;
    lw_axis_limits *limits = calloc(count, sizeof *limits);
    lw_profile *profile = calloc(count, sizeof *profile);
    lw_error inner = { 0 };
    lw_status s = from && limits && profile ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < c->n_axis; i++) {
        if (m->moves[i] && p->free_at[i] > m->start + 1e-12)
            s = lw_json_fault(object, e, "axis \"%s\" still moves until %g s and cannot begin at %g s; a smaller "
                                         "\"blend\" before, or moves of different axes, may "
                                         "overlap", c->axis[i].name, p->free_at[i], m->start);
        else if (p->at[i].v != 0 && (!m->moves[i] || m->start > p->free_at[i] + 1e-12))
            s = lw_json_fault(object, e, "axis \"%s\" arrives here with a speed of %g and has to go on at once",
                              c->axis[i].name,
                              p->at[i].v);
        if (s == LW_OK && m->moves[i]) {
            from[n] = p->at[i];
            to[n] = (lw_axis_state){ goal[i], speed[i], 0 };
            limits[n++] = c->axis[i].limits;
        }
    }
    if (s == LW_OK && n == 0)
        s = lw_json_fault(object, e, "this move moves no axis; write \"to\": {\"%s\": ...}", c->axis[0].name);
    if (s == LW_OK) {
        s = lw_profile_make_axes((int)n, from, to, limits, duration, straight, profile, &inner);
        if (s == LW_NOTHING && !inner.text[0])
            lw_error_set(&inner, s, straight ? "the axes do not begin and end along one straight line" :
                         "no motion within the limits brings the axes there together");
        if (s != LW_OK)
            s = s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory") : lw_json_fault(object, e, "%s", inner.text);
    }
    for (int i = 0, k = 0; s == LW_OK && i < c->n_axis; i++)
        if (m->moves[i]) {
            m->profile[i] = profile[k];
            m->to[i] = goal[i];
            m->duration = fmax(m->duration, profile[k].duration);
            p->at[i] = to[k++];
        }
    for (int i = 0; s == LW_OK && i < c->n_axis; i++)
        if (m->moves[i])
            p->free_at[i] = m->start + m->duration;
    free(from);
    free(limits);
    free(profile);
    return s;
}

static lw_status read_move(const lw_json_node *object, plan *p, double *goal, double *speed, lw_error *e)
{
    static const char *const known[] = { "name", "to", "speed", "duration", "straight", "payload", "dwell", "blend" };
    lw_work_cycle *c = p->c;
    lw_cycle_move *m = &c->move[c->n_move], *before = c->n_move ? m - 1 : NULL;
    double blend = 0, duration = 0;
    bool straight = false;
    lw_json_node n;
    m->payload = before ? before->payload : 0;
    const lw_number_key numbers[] = { { "duration", 1, LW_POSITIVE, &duration, NULL }, { "payload", 1, 0, INFINITY,
         &m->payload, NULL },
                                      { "dwell", 1, 0, INFINITY, &m->dwell, NULL }, { "blend", 1, 0, INFINITY, &blend,
                                           NULL } };
    m->moves = calloc((size_t)c->n_axis, sizeof *m->moves);
    m->profile = calloc((size_t)c->n_axis, sizeof *m->profile);
    m->to = calloc((size_t)c->n_axis, sizeof *m->to);
    c->n_move++;
    if (!m->moves || !m->profile || !m->to)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    snprintf(m->name, sizeof m->name, "%d", c->n_move);
    memset(speed, 0, (size_t)c->n_axis*sizeof *speed);
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK
        && (s = lw_read_numbers(object, numbers, COUNT(numbers), e)) == LW_OK && lw_json_member(object, "name",
            &n))
        s = lw_json_name(&n, m->name, sizeof m->name, e);
    if (s == LW_OK && (s = lw_read_need(object, "to", &n, e)) == LW_OK)
        s = read_places(&n, c, goal, m->moves, e);
    if (s == LW_OK && lw_json_member(object, "speed", &n))
        s = read_places(&n, c, speed, NULL, e);
    if (s == LW_OK && lw_json_member(object, "straight", &n)) {
        straight = lw_json_truth(&n) == 1;
        if (lw_json_truth(&n) < 0)
            s = lw_json_fault(&n, e, "true or false is expected here");
    }
    if (s == LW_OK && blend > 0 && (!before || blend > before->duration || before->dwell > 0)) {
        lw_json_member(object, "blend", &n);
        s = lw_json_fault(&n, e, before && before->dwell > 0 ? "the move before is followed by a rest; a move cannot begin before it"
                          : "a move can begin at most as long before the end of the one before as that takes%s", before
                              ? "" :
                          ", and there is none before");
    }
    m->start = p->time - blend;
    if (s == LW_OK)
        s = plan_move(object, p, m, goal, speed, duration, straight, e);
    p->time = fmax(p->time, m->start + m->duration) + m->dwell;
    c->end = p->time;
    return s;
}

static lw_status read_all(const lw_json_node *root, lw_work_cycle *c, lw_error *e)
{
    static const char *const known[] = { "linkwright-cycle", "name", "axes", "moves", "cycle_time", "$schema" };
    lw_json_node n, axes, moves;
    double version = 0;
    const lw_number_key numbers[] = { { "cycle_time", 1, LW_POSITIVE, &c->wanted, NULL } };
    lw_status s = lw_json_expect(root, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(root, known, COUNT(known), e)) == LW_OK
        && (s = lw_read_need(root, "linkwright-cycle", &n, e)) == LW_OK && (s = lw_json_number(&n, &version,
            e)) == LW_OK && version != 1)
        s = lw_json_fault(&n, e, "version %g of the notation is unknown; this program reads version 1", version);
    if (s == LW_OK && lw_json_member(root, "name", &n))
        s = lw_json_name(&n, c->name, sizeof c->name, e);
    if (s == LW_OK && (s = lw_read_numbers(root, numbers, 1, e)) == LW_OK && (s = lw_read_need(root, "axes",
        &axes, e)) == LW_OK
        && (s = lw_read_list(&axes, 1, 64, e)) == LW_OK && (s = lw_read_need(root, "moves", &moves, e)) == LW_OK)
        s = lw_read_list(&moves, 1, 100000, e);
    if (s != LW_OK)
        return s;
    c->axis = calloc(lw_json_count(&axes), sizeof *c->axis);
    c->move = calloc(lw_json_count(&moves), sizeof *c->move);
    if (!c->axis || !c->move)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&axes); i++) {
        lw_json_node one = lw_json_element(&axes, i);
        s = read_axis(&one, c, e);
    }
    if (s != LW_OK)
        return s;
    size_t count = (size_t)c->n_axis;
    plan p = { c, calloc(count, sizeof *p.at), calloc(count, sizeof *p.free_at), 0 };
    double *goal = calloc(2*count, sizeof *goal);
    if (!p.at || !p.free_at || !goal)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < c->n_axis; i++)
        p.at[i].x = c->axis[i].start;
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&moves); i++) {
        lw_json_node one = lw_json_element(&moves, i);
        s = read_move(&one, &p, goal, goal + count, e);
    }
    for (int i = 0; s == LW_OK && i < c->n_axis; i++)
        if (p.at[i].v != 0) {
            lw_json_node last = lw_json_element(&moves, lw_json_count(&moves) - 1);
            s = lw_json_fault(&last, e, "axis \"%s\" still has a speed of %g at the end of the cycle", c->axis[i].name, p.at[i].v);
        }
    free(p.at);
    free(p.free_at);
    free(goal);
    return s;
}

lw_status lw_work_cycle_read(const char *text, size_t size, const char *file, lw_work_cycle *c, lw_error *e)
{
    lw_json json;
    lw_error own = { 0 };
    *c = (lw_work_cycle){ 0 };
    lw_status s = lw_json_open(text, size, file, &json, e ? e : &own);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&json);
    s = read_all(&root, c, e ? e : &own);
    lw_json_close(&json);
    if (s != LW_OK)
        lw_work_cycle_free(c);
    return s;
}

void lw_work_cycle_free(lw_work_cycle *c)
{
    for (int i = 0; i < c->n_move; i++) {
        free(c->move[i].moves);
        free(c->move[i].profile);
        free(c->move[i].to);
    }
    free(c->axis);
    free(c->move);
    *c = (lw_work_cycle){ 0 };
}

lw_axis_state lw_work_cycle_at(const lw_work_cycle *c, int axis, double t, double *jerk)
{
    lw_axis_state at = { c->axis[axis].start, 0, 0 };
    if (jerk)
        *jerk = 0;
    for (int i = c->n_move - 1; i >= 0; i--) {
        const lw_cycle_move *m = &c->move[i];
        if (!m->moves[axis] || t < m->start)
            continue;
        double end = m->profile[axis].duration;
        return t - m->start < end ? lw_profile_at(&m->profile[axis], t - m->start, jerk)
            : (lw_axis_state){ m->to[axis], 0, 0 };
    }
    return at;
}

double lw_work_cycle_payload(const lw_work_cycle *c, double t)
{
    int i = c->n_move - 1;
    while (i > 0 && t < c->move[i].start)
        i--;
    return c->move[i].payload;
}
