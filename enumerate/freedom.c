#include "enumerate/freedom.h"

#include <string.h>
#include "grammar/text/text_internal.h"

#define CONDITION_MAX (3*LW_JOINT_MAX)

/* A condition between two links: on places (any forest) or on turning speeds alone (forest 0). */
typedef struct condition { uint8_t a, b; bool turning; int8_t forest; } condition;

typedef struct splitting {
    int       n_link, n;
    condition of[CONDITION_MAX];
} splitting;

/* ---- matroid union ----------------------------------------------------------------------------- */

/* For the tree of forest f that contains link `from`: the condition by which each link is reached first; -1 for the
 * root, -2 for links not in the tree. */
static void reach(const splitting *s, int f, int from, short *by)
{
    uint8_t queue[LW_LINK_MAX];
    int head = 0, tail = 0;
    for (int i = 0; i < s->n_link; i++)
        by[i] = -2;
    by[from] = -1;
    queue[tail++] = (uint8_t)from;
    while (head < tail) {
        int at = queue[head++];
        for (int c = 0; c < s->n; c++) {
            const condition *k = &s->of[c];
            int other = k->a == at ? k->b : k->b == at ? k->a : -1;
            if (k->forest == f && other >= 0 && by[other] == -2) {
                by[other] = (short)c;
                queue[tail++] = (uint8_t)other;
            }
        }
    }
}

/* Breadth-first search over the conditions that would have to change their forest if condition `fresh` is added.
 * Returns the one that fits into *forest directly, or -1.  from[c]: the condition that takes the place of c. */
static int search(const splitting *s, int fresh, short *from, int *forest)
{
    short queue[CONDITION_MAX], by[LW_LINK_MAX];
    bool seen[CONDITION_MAX] = { false };
    int head = 0, tail = 0;
    queue[tail++] = (short)fresh;
    seen[fresh] = true;
    from[fresh] = -1;
    while (head < tail) {
        int c = queue[head++];
        for (int f = 0; f < (s->of[c].turning ? 1 : 3); f++) {
            if (s->of[c].forest == f)
                continue;
            reach(s, f, s->of[c].a, by);
            int at = s->of[c].b;
            if (by[at] == -2) {
                *forest = f;
                return c;
            }
            while (by[at] >= 0) {                         /* the circuit that c would close */
                int on = by[at];
                at = s->of[on].a == at ? s->of[on].b : s->of[on].a;
                if (!seen[on]) {
                    seen[on] = true;
                    from[on] = (short)c;
                    queue[tail++] = (short)on;
                }
            }
        }
    }
    return -1;
}

/* True if the condition is independent of those in s; with `keep` it is added to s. */
static bool add(splitting *s, int a, int b, bool turning, bool keep)
{
    short from[CONDITION_MAX];
    int fresh = s->n, forest, c;
    s->of[fresh] = (condition){ (uint8_t)a, (uint8_t)b, turning, -1 };
    c = search(s, fresh, from, &forest);
    if (c < 0 || !keep)
        return c >= 0;
    s->n++;
    while (c >= 0) {                                      /* each takes the place it wanted */
        int freed = s->of[c].forest;
        s->of[c].forest = (int8_t)forest;
        forest = freed;
        c = from[c];
    }
    return true;
}

/* ---- joints as conditions ---------------------------------------------------------------------- */

/* Add the conditions of joint j; false at the first dependent one. */
static bool add_joint(splitting *s, const lw_mechanism *m, int j)
{
    int a = m->link[j][0], b = m->link[j][1];
    bool slider = lw_joint_holds_rotation(m->kind[j]);
    return add(s, a, b, slider, true)
        && (lw_joint_freedoms(m->kind[j]) == 2 || add(s, a, b, false, true));
}

/* A cam and its follower may both only slide. */
static bool may_not_turn(const lw_mechanism *m, int j)
{
    return m->translating_cams && lw_joint_has_ratio(m->kind[j]);
}

/* True if every freedom of joint j is used: a condition that blocks it would be independent. */
static bool is_used(splitting *s, const lw_mechanism *m, int j)
{
    int a = m->link[j][0], b = m->link[j][1];
    bool turns = !lw_joint_holds_rotation(m->kind[j]) && !may_not_turn(m, j), slides = !lw_joint_holds_point(m->kind[j]);
    return (!turns || add(s, a, b, true, false)) && (!slides || add(s, a, b, false, false));
}

/* ---- loops of sliders -------------------------------------------------------------------------- */

static int root_of(uint8_t *above, int i)
{
    while (above[i] != i)
        i = above[i] = above[above[i]];
    return i;
}

/* The sliders on the way from link a to link b, using sliders below number n only. */
static uint64_t slider_path(const lw_mechanism *m, int a, int b, int n)
{
    uint64_t way[LW_LINK_MAX] = { 0 };
    uint32_t seen = 1u << a;
    for (bool grown = true; grown && !(seen >> b & 1);) {
        grown = false;
        for (int j = 0; j < n; j++)
            for (int side = 0; side < 2 && lw_joint_holds_rotation(m->kind[j]); side++) {
                int from = m->link[j][side], to = m->link[j][!side];
                if ((seen >> from & 1) && !(seen >> to & 1)) {
                    seen |= 1u << to;
                    way[to] = way[from] | (uint64_t)1 << j;
                    grown = true;
                }
            }
    }
    return way[b];
}

/* Loops of sliders with at most one other joint.  This test is fast, and its reasons are the easiest to understand. */
static lw_void slider_loops(const lw_mechanism *m, uint64_t *joints)
{
    uint8_t above[LW_LINK_MAX];
    for (int i = 0; i < m->n_link; i++)
        above[i] = (uint8_t)i;
    for (int j = 0; j < m->n_joint; j++) {
        int a = root_of(above, m->link[j][0]), b = root_of(above, m->link[j][1]);
        if (lw_joint_holds_rotation(m->kind[j]) && a == b) {
            *joints = (uint64_t)1 << j | slider_path(m, m->link[j][0], m->link[j][1], j);
            return LW_VOID_SLIDER_LOOP;
        }
        if (lw_joint_holds_rotation(m->kind[j]))
            above[a] = (uint8_t)b;
    }
    for (int j = 0; j < m->n_joint; j++)
        if (!lw_joint_holds_rotation(m->kind[j]) && !may_not_turn(m, j)
            && root_of(above, m->link[j][0]) == root_of(above, m->link[j][1])) {
            *joints = (uint64_t)1 << j | slider_path(m, m->link[j][0], m->link[j][1], m->n_joint);
            return LW_VOID_NO_TURN;
        }
    return LW_VOID_NOT;
}

lw_void lw_mechanism_void(const lw_mechanism *m, uint64_t *joints)
{
    splitting s = { .n_link = m->n_link };
    uint64_t ignored;
    joints = joints ? joints : &ignored;
    *joints = 0;
    lw_void quick = slider_loops(m, joints);
    if (quick != LW_VOID_NOT)
        return quick;
    for (int j = 0; j < m->n_joint; j++)
        if (!add_joint(&s, m, j)) {
            *joints = (uint64_t)1 << j;
            return LW_VOID_DEPENDENT;
        }
    for (int j = 0; j < m->n_joint; j++)
        if (!is_used(&s, m, j))
            *joints |= (uint64_t)1 << j;
    return *joints ? LW_VOID_LOCKED : LW_VOID_NOT;
}

bool lw_mechanism_drives(const lw_mechanism *m, uint64_t joints)
{
    splitting s = { .n_link = m->n_link };
    for (int j = 0; j < m->n_joint; j++)
        if (!add_joint(&s, m, j))
            return false;
    for (; joints; joints &= joints - 1) {
        int j = __builtin_ctzll(joints);
        if (!add(&s, m->link[j][0], m->link[j][1], !lw_joint_holds_rotation(m->kind[j]), true))
            return false;
    }
    return true;
}

uint64_t lw_mechanism_drivers(const lw_mechanism *m)
{
    splitting s = { .n_link = m->n_link };
    uint64_t drivers = 0;
    for (int j = 0; j < m->n_joint; j++)
        if (!add_joint(&s, m, j))
            return 0;
    for (int j = 0; j < m->n_joint; j++)
        if (add(&s, m->link[j][0], m->link[j][1], !lw_joint_holds_rotation(m->kind[j]), false))
            drivers |= (uint64_t)1 << j;
    return drivers;
}

size_t lw_void_print(const lw_mechanism *m, lw_void reason, uint64_t joints, char *buf, size_t size)
{
    static const char *const text[] = {
        [LW_VOID_NOT] = "not void",
        [LW_VOID_SLIDER_LOOP] = "a loop of sliders only",
        [LW_VOID_NO_TURN] = "links that only sliders connect never turn, but are to turn at one joint",
        [LW_VOID_DEPENDENT] = "sliders keep links parallel, so that F counts wrongly; seen at joint",
        [LW_VOID_LOCKED] = "F counts rightly, but never moves",
    };
    lw_text t = lw_text_start(buf, size);
    lw_text_add(&t, "%s", text[reason]);
    for (const char *lead = ": "; joints; joints &= joints - 1, lead = " ") {
        int j = __builtin_ctzll(joints);
        lw_text_add(&t, "%s%d-%d:%c", lead, m->link[j][0] + 1, m->link[j][1] + 1, m->kind[j]);
    }
    return t.length;
}
