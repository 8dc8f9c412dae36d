/* enumerate/critical.c - see critical.h. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/critical.h"

/* The search over all sets includes or excludes one circle after the other, highest number first. */
typedef struct walk {
    const lw_structure *s;
    lw_critical_list   *list;
    uint8_t             tie[LW_CIRCLE_MAX][LW_CIRCLE_MAX];
} walk;

static lw_status append(lw_critical_list *list, uint32_t circles, int copies)
{
    if (list->n == list->room) {
        int room = list->room ? 2*list->room : 64;
        lw_critical *set = realloc(list->set, (size_t)room*sizeof *set);
        if (!set)
            return LW_E_MEMORY;
        list->set = set;
        list->room = room;
    }
    int room = 3*__builtin_popcount(circles) - 4;
    list->set[list->n++] = (lw_critical){ circles, 0, room, copies - room };
    return LW_OK;
}

/* inner[c] = lines between circle c and the set. */
static lw_status visit_sets(walk *w, int circle, uint32_t circles, int copies, const uint8_t *inner)
{
    if (circle < 0) {
        bool overfull = (circles & (circles - 1)) && copies > 3*__builtin_popcount(circles) - 4;
        return overfull ? append(w->list, circles, copies) : LW_OK;
    }
    uint8_t with[LW_CIRCLE_MAX];
    lw_status status = visit_sets(w, circle - 1, circles, copies, inner);
    if (status != LW_OK)
        return status;
    for (int c = 0; c < circle; c++)
        with[c] = (uint8_t)(inner[c] + w->tie[circle][c]);
    return visit_sets(w, circle - 1, circles | (uint32_t)1 << circle, copies + 2*inner[circle], with);
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
    uint8_t inner[LW_CIRCLE_MAX] = { 0 };
    for (int e = 0; e < s->n_line; e++) {
        w.tie[s->end[e][0]][s->end[e][1]]++;
        w.tie[s->end[e][1]][s->end[e][0]]++;
    }
    list->n = 0;
    lw_status status = visit_sets(&w, s->n_circle - 1, 0, 0, inner);
    if (status != LW_OK)
        return status;
    qsort(list->set, (size_t)list->n, sizeof *list->set, by_size);
    thin_out(s, list, whole ? 0 : ((uint32_t)1 << s->n_circle) - 1);
    return LW_OK;
}
