/* mbs/constraints/motion_curve_make.c - making a curve of postures. */
#include "base/number.h"
#include "mbs/constraints/motion_curve_internal.h"

#include <stdlib.h>
#include <string.h>

static lw_status check(const lw_system *s, const lw_motion_curve_options *o, lw_error *e)
{
    if (o->input < 0 || o->input >= s->n_input)
        return lw_error_set(e, LW_E_ARG, "the linkage has no input to move it by");
    int missing = s->n_q - s->n_row - s->n_input;
    if (missing > 0)
        return lw_error_set(e, LW_E_ARG, "the linkage has %d freedoms but %d input%s; drive %d more joint%s",
                            s->n_q - s->n_row, s->n_input, lw_plural(s->n_input), missing,
                            lw_plural(missing));
    return LW_OK;
}

/* Links that are small beside the arm of a tracer move as far as that arm, where sliders guide them. */
static double usual_reach(const lw_system *s)
{
    double size = 1.0;
    for (int i = 0; i < s->n_tracer; i++)
        size = fmax(size, lw_v2_norm(s->tracer_arm[i]));
    return 30.0*size;
}

static bool allocate(const lw_system *s, const lw_motion_curve_options *o, lw_motion_curve *b)
{
    size_t inputs = (size_t)s->n_input;
    int n_rest = 0, *all = malloc((2*inputs + 1)*sizeof *all), *rest = all ? all + inputs : NULL;
    for (int i = 0; all && i < s->n_input; i++) {
        all[i] = i;
        if (i != o->input)
            rest[n_rest++] = i;
    }
    b->s = s;
    b->n = s->n_q;
    b->input = o->input;
    b->reach = o->reach > 0.0 ? o->reach : usual_reach(s);
    b->stop = o->stop;
    b->most = o->most_segments > 0 ? o->most_segments : 20000;
    b->series = calloc((size_t)(LW_MOTION_CURVE_ORDER + 1 + 3 + LW_MOTION_CURVE_BESIDE)*(size_t)b->n
                       + 2*inputs*(LW_MOTION_CURVE_ORDER + 1), sizeof *b->series);
    bool made = b->series && all && lw_continuation_create(s, rest, n_rest, true, &b->f)
                && lw_continuation_create(s, all, s->n_input, false, &b->driven);
    free(all);
    if (!made)
        return false;
    b->a = b->series + (LW_MOTION_CURVE_ORDER + 1)*b->n;
    b->b = b->a + b->n;
    b->c = b->b + b->n;
    b->beside = b->c + b->n;
    b->motion = b->beside + LW_MOTION_CURVE_BESIDE*b->n;
    return true;
}

/* The other inputs stay where they are in the posture. */
static lw_status place_start(lw_motion_curve *b, const double *q)
{
    b->node = calloc(64, sizeof *b->node);
    if (!b->node)
        return LW_E_MEMORY;
    b->node[0].q = calloc(3*(size_t)b->n, sizeof(double));
    if (!b->node[0].q)
        return LW_E_MEMORY;
    b->n_node = 1;
    if (q)
        memcpy(b->node[0].q, q, (size_t)b->n*sizeof *q);
    else
        lw_system_posture(b->s, b->node[0].q);
    for (int i = 0; i < b->f.n_held; i++)
        b->f.value[i] = lw_system_measure(b->s, b->s->input_joint[b->f.held[i]], b->node[0].q, NULL);
    return LW_OK;
}

lw_status lw_motion_curve_create(const lw_system *s, const double *q, const lw_motion_curve_options *o, lw_motion_curve **out, lw_error *e)
{
    *out = NULL;
    lw_status status = check(s, o, e);
    if (status != LW_OK)
        return status;
    lw_motion_curve *b = calloc(1, sizeof *b);
    if (!b || !allocate(s, o, b) || place_start(b, q) != LW_OK) {
        lw_motion_curve_free(b);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    status = lw_motion_curve_walk(b, e);
    if (status == LW_OK && lw_motion_curve_find_events(b) != LW_OK)
        status = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (status != LW_OK) {
        lw_motion_curve_free(b);
        return status;
    }
    *out = b;
    return LW_OK;
}
