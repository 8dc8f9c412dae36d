/* enumerate/critical.c - see critical.h. */
#include <stdlib.h>
#include <string.h>
#include "base/growable_array.h"
#include "enumerate/critical.h"

/* A number for each circle. */
typedef uint8_t numbers __attribute__((vector_size(32)));

/* The search includes or excludes one circle after the other, highest number first.  A circle with less than two lines
 * to the others of its set can be left out: the set without it needs at least as many binary links.  So sets with such
 * a circle are not visited. */
typedef struct walk {
    const lw_structure *s;
    lw_critical_list   *list;
    numbers             tie[LW_CIRCLE_MAX];         /* lines to every circle */
} walk;

static lw_status append(lw_critical_list *list, uint32_t circles, int copies)
{
    lw_critical *set = lw_array_grow(list->set, list->n, &list->room, sizeof *set);
    if (!set)
        return LW_E_MEMORY;
    list->set = set;
    int room = 3*__builtin_popcount(circles) - 4;
    list->set[list->n++] = (lw_critical){ circles, 0, room, copies - room };
    return LW_OK;
}

/* inner[c]: lines from c to the set; most[c]: lines to the set and to circles that are not decided yet. */
static lw_status visit_sets(walk *w, int circle, uint32_t circles, int copies, const numbers *inner, const numbers *most)
{
    if (circle < 0) {
        bool overfull = (circles & (circles - 1)) && copies > 3*__builtin_popcount(circles) - 4;
        return overfull ? append(w->list, circles, copies) : LW_OK;
    }
    numbers fewer = *most - w->tie[circle], more = *inner + w->tie[circle];
    bool possible = true;
    for (uint32_t rest = circles; rest && possible; rest &= rest - 1)
        possible = fewer[__builtin_ctz(rest)] >= 2;
    lw_status status = possible ? visit_sets(w, circle - 1, circles, copies, inner, &fewer) : LW_OK;
    if (status != LW_OK || (*most)[circle] < 2)
        return status;
    return visit_sets(w, circle - 1, circles | (uint32_t)1 << circle, copies + 2*(*inner)[circle], &more, most);
}

static int by_size(const void *a, const void *b)
{
    const lw_critical *p = a, *q = b;
    int size = __builtin_popcount(p->circles) - __builtin_popcount(q->circles);
    return size ? size : (p->circles > q->circles) - (p->circles < q->circles);
}

/* Drop sets that contain a kept set with the same need; fill in the lines of the others. */
static void thin_out(const lw_structure *s, lw_critical_list *list, uint32_t exempt)
{
    int kept = 0;
    for (int k = 0; k < list->n; k++) {
        lw_critical t = list->set[k];
        bool implied = t.circles == exempt;
        for (int i = 0; i < kept && !implied; i++)
            implied = !(list->set[i].circles & ~t.circles) && list->set[i].need >= t.need;
        if (implied)
            continue;
        for (int e = 0; e < s->n_line; e++)
            if (t.circles >> s->end[e][0] & t.circles >> s->end[e][1] & 1)
                t.lines |= (uint64_t)1 << e;
        list->set[kept++] = t;
    }
    list->n = kept;
}

lw_status lw_critical_sets(const lw_structure *s, bool whole, lw_critical_list *list)
{
    walk w = { .s = s, .list = list };
    numbers inner = { 0 }, most = { 0 };
    for (int e = 0; e < s->n_line; e++) {
        w.tie[s->end[e][0]][s->end[e][1]]++;
        w.tie[s->end[e][1]][s->end[e][0]]++;
    }
    for (int c = 0; c < s->n_circle; c++)
        most += w.tie[c];
    list->n = 0;
    lw_status status = visit_sets(&w, s->n_circle - 1, 0, 0, &inner, &most);
    if (status != LW_OK)
        return status;
    qsort(list->set, (size_t)list->n, sizeof *list->set, by_size);
    thin_out(s, list, whole ? 0 : ((uint32_t)1 << s->n_circle) - 1);
    return LW_OK;
}
