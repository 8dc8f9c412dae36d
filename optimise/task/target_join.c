/* Join targets with the same number of rows into one target with several points. */
#include "base/real.h"
#include "optimise/task/target_internal.h"

#include <string.h>

/* Check that part k can be joined to the first one. */
static lw_status check_part(const lw_target *first, const lw_target *part, int k, lw_error *e)
{
    if (part->n != first->n)
        return lw_error_set(e, LW_E_ARG, "tracer %d has %zu stations, the first one %zu; they belong together row by "
                            "row", k + 1, part->n, first->n);
    if (part->n_also > 0 || first->n_also > 0)
        return lw_error_set(e, LW_E_ARG, "tracer %d has columns of further points itself; give each a target of its "
                            "own, or all of them one target", first->n_also > 0 ? 1 : k + 1);
    if (part->x && !first->x)
        return lw_error_set(e, LW_E_ARG, "tracer %d has a path and the first one none: put those with a path first", k + 1);
    for (size_t i = 0; i < part->n && part->angle && first->angle; i++)
        if (!(fabs(remainder(part->angle[i] - first->angle[i], 2*LW_PI)) <= 1e-9))
            return lw_error_set(e, LW_E_ARG, "station %zu has the input angle %.9g for the first tracer and %.9g for "
                                "tracer %d; one input moves all", i + 1, first->angle[i]/first->units.radian,
                                part->angle[i]/part->units.radian, k + 1);
    return LW_OK;
}

lw_status lw_target_join(const lw_target *const *part, int n_part, lw_target *t, lw_error *e)
{
    const lw_target *first = part[0];
    lw_also also[LW_ALSO_MAX];
    int n = first->n_also;
    const double *angle = first->angle;
    lw_status s = LW_OK;
    memset(t, 0, sizeof *t);
    memcpy(also, first->also, sizeof also);
    if (n_part > 1 + LW_ALSO_MAX)
        return lw_error_set(e, LW_E_ARG, "%d tracers; a target has %d points at most", n_part, 1 + LW_ALSO_MAX);
    for (int k = 1; k < n_part && s == LW_OK; k++) {
        s = check_part(first, part[k], k, e);
        also[n++] = (lw_also){ .x = part[k]->x, .y = part[k]->y, .theta = part[k]->theta, .weight = part[k]->weight };
        angle = angle ? angle : part[k]->angle;
    }
    if (s == LW_OK)
        s = lw_target_make_all(first->n, first->x, first->y, first->theta, angle, first->weight, also, n, first->closed, t, e);
    if (s != LW_OK)
        return s;
    for (int k = 0; k < n_part; k++)
        t->noise = fmax(t->noise, part[k]->noise);
    t->units = first->units;
    memcpy(t->line, first->line, sizeof *t->line*t->n);
    return LW_OK;
}
