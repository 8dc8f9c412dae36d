#include "grammar/functions/moves.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "grammar/functions/motion_law.h"
#include "grammar/linkage/read_internal.h"

static lw_status read_move(const lw_json_node *object, const lw_axis_limits *limits, double mass, lw_moves *all, double *at,
                           double *time, lw_error *e)
{
    static const char *const known[] = { "to", "dwell", "law", "duration", "frequency", "power" };
    lw_move *m = &all->move[all->n];
    lw_json_node n;
    lw_error inner = { 0 };
    double to = 0, dwell = 0, duration = 0, frequency = 0, power = 0;
    const lw_number_key numbers[] = { { "to", 1, LW_ANY, &to, NULL }, { "dwell", 1, 0, INFINITY, &dwell, NULL },
                                      { "duration", 1, LW_POSITIVE, &duration, NULL },
                                      { "frequency", 1, LW_POSITIVE, &frequency, NULL },
                                      { "power", 1, LW_POSITIVE, &power, NULL } };
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(object, known, COUNT(known), e)) == LW_OK && (s = lw_read_need(object, "to", &n, e)) == LW_OK)
        s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    if (s != LW_OK)
        return s;
    *m = (lw_move){ .start = *time, .from = *at, .way = to - *at, .law = -1 };
    if (lw_json_member(object, "law", &n)) {
        const char *name = lw_json_text(&n);
        m->law = name ? lw_motion_law_find(name) : -1;
        if (m->law < 0)
            return lw_json_fault(&n, e, "there is no such law of motion; `linkwright help profile` lists them");
        m->duration = duration;
        if (frequency > 0 || power > 0)
            return lw_json_fault(object, e, "a law has no \"frequency\" or \"power\"; leave out one of both");
        if (!(duration > 0))
            return lw_json_fault(object, e, "a move by a law needs its \"duration\" [s]");
    } else {
        lw_axis_state from = { *at, 0, 0 }, there = { to, 0, 0 };
        lw_axis_limits own = *limits;
        if (power > 0 && !(mass > 0))
            return lw_json_fault(object, e, "a limit of \"power\" needs the \"mass\" [kg] beside \"moves\"");
        if (power > 0)
            lw_profile_limit_power(m->way, power, mass, &own);
        if (frequency > 0 && isinf(own.a[1]))
            return lw_json_fault(object, e, "\"frequency\" needs a limit of \"acceleration\"");
        if (frequency > 0)
            lw_profile_limit_frequency(m->way, frequency, &own);
        s = duration > 0 ? lw_profile_make_timed(from, there, &own, duration, &m->profile, NULL, &inner)
                         : lw_profile_make(from, there, &own, 0, &m->profile, &inner);
        if (s != LW_OK)
            return lw_json_fault(object, e, "%s", inner.text);
        m->duration = m->profile.duration;
    }
    all->n++;
    all->end = m->start + m->duration;
    *time = all->end + dwell;
    *at = to;
    return LW_OK;
}

lw_status lw_moves_read(const lw_json_node *object, lw_moves *m, lw_error *e)
{
    lw_json_node moves;
    double v = 0, a = 0, j = INFINITY, at = 0, time = 0, mass = 0;
    const lw_number_key numbers[] = { { "speed", 1, LW_POSITIVE, &v, NULL }, { "acceleration", 1, LW_POSITIVE, &a, NULL },
                                      { "jerk", 1, LW_POSITIVE, &j, NULL }, { "from", 1, LW_ANY, &at, NULL },
                                      { "start", 1, LW_ANY, &time, NULL }, { "mass", 1, LW_POSITIVE, &mass, NULL } };
    lw_status s = lw_read_need(object, "moves", &moves, e);
    if (s == LW_OK && (s = lw_read_list(&moves, 1, SIZE_MAX, e)) == LW_OK)
        s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    lw_axis_limits limits = lw_axis_limits_even(v > 0 ? v : INFINITY, a > 0 ? a : INFINITY, j);
    if (s == LW_OK && !(m->move = calloc(lw_json_count(&moves), sizeof *m->move)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&moves); i++) {
        lw_json_node one = lw_json_element(&moves, i);
        s = read_move(&one, &limits, mass, m, &at, &time, e);
    }
    return s;
}

const lw_moves *lw_moves_find(lw_json *json, int n, const lw_moves *all, const char *name)
{
    int i = lw_read_find(json, name, (const char *)all, sizeof *all, n);
    return i < 0 ? NULL : &all[i];
}

lw_status lw_moves_read_profiles(const lw_json_node *root, int *count, lw_moves **out, lw_error *e)
{
    static const char *const known[] = { "name", "speed", "acceleration", "jerk", "from", "start", "mass", "moves" };
    lw_json_node all, n;
    if (!lw_json_member(root, "profiles", &all))
        return LW_OK;
    lw_status s = lw_read_list(&all, 0, SIZE_MAX, e);
    if (s == LW_OK && !(*out = calloc(lw_json_count(&all) + 1, sizeof **out)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&all); i++) {
        lw_json_node one = lw_json_element(&all, i);
        lw_moves *p = &(*out)[*count];
        s = lw_json_expect(&one, LW_JSON_OBJECT, e);
        if (s == LW_OK && (s = lw_json_known_keys(&one, known, COUNT(known), e)) == LW_OK &&
            (s = lw_read_need(&one, "name", &n, e)) == LW_OK)
            s = lw_json_name(&n, p->name, sizeof p->name, e);
        if (s == LW_OK && lw_moves_find(root->json, *count, *out, p->name))
            s = lw_json_fault(&n, e, "there are two profiles with the name \"%s\"", p->name);
        ++*count;
        if (s == LW_OK)
            s = lw_moves_read(&one, p, e);
    }
    return s;
}

void lw_moves_free(lw_moves *m)
{
    free(m->move);
    memset(m, 0, sizeof *m);
}

/* Is t behind `place`, or at it and seen from behind it? */
static bool behind(double t, double place, int direction) { return t > place || (t == place && direction >= 0); }

void lw_moves_series(const lw_moves *m, double t, int direction, int order, double *out)
{
    int k = 0;
    for (int i = 0; i <= order; i++)
        out[i] = 0;
    while (k + 1 < m->n && behind(t, m->move[k + 1].start, direction))
        k++;
    const lw_move *p = &m->move[k];
    double u = t - p->start;
    if (!behind(t, p->start, direction) || behind(u, p->duration, direction)) {
        out[0] = behind(t, p->start, direction) ? p->from + p->way : p->from;
        return;
    }
    if (p->law < 0) {
        int i = p->profile.n - 1;
        while (i > 0 && !behind(u, p->profile.t[i], direction))
            i--;
        const lw_axis_state *from = &p->profile.at[i];
        double d = u - p->profile.t[i], j = p->profile.jerk[i];
        const double c[4] = { from->x + d*(from->v + d*(from->a/2 + d*j/6)), from->v + d*(from->a + d*j/2),
                              (from->a + d*j)/2, j/6 };
        for (int r = 0; r <= order && r < 4; r++)
            out[r] = c[r];
        return;
    }
    double scale = p->way;
    lw_motion_law_series(p->law, u/p->duration, direction, order, out);
    for (int r = 0; r <= order; r++, scale /= p->duration)
        out[r] *= scale;
    out[0] += p->from;
}

lw_axis_state lw_moves_at(const lw_moves *m, double t)
{
    double c[3];
    lw_moves_series(m, t, 1, 2, c);
    return (lw_axis_state){ c[0], c[1], 2*c[2] };
}

double lw_moves_next_kink(const lw_moves *m, double t)
{
    for (int k = 0; k < m->n; k++) {
        const lw_move *p = &m->move[k];
        double next = p->start + p->duration;
        if (next <= t)
            continue;
        if (p->start > t)
            return p->start;
        for (int i = p->law < 0 ? p->profile.n - 1 : 0; i > 0; i--)
            if (p->start + p->profile.t[i] > t)
                next = fmin(next, p->start + p->profile.t[i]);
        for (int i = 0; p->law >= 0; i++) {
            double border = lw_motion_law_border(p->law, i);
            if (border >= 1)
                break;
            if (p->start + border*p->duration > t)
                next = fmin(next, p->start + border*p->duration);
        }
        return next;
    }
    return INFINITY;
}
