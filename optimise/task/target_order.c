/* Check and order the input angles of the stations: one point for one angle, in cyclic order. */
#include "base/real.h"
#include "mbs/plan/plan.h"
#include "optimise/task/target_internal.h"

#include <stdio.h>
#include <stdlib.h>

#define TURN      (2*LW_PI)
/* angles closer than this are equal [rad]; so are points closer than this part of the path's size */
#define ANGLE_EPS 1e-9

/* "line 7" of the file, or "station 6" if there was no file. */
static const char *where(const lw_target *t, size_t i, char buf[40])
{
    if (t->line[i] > 0)
        snprintf(buf, 40, "line %ld", t->line[i]);
    else
        snprintf(buf, 40, "station %zu", i + 1);
    return buf;
}

/* ---- one point for one angle ------------------------------------------------------------------- */

typedef struct crank { double angle; size_t i; } crank;

static int by_angle(const void *a, const void *b)
{
    const crank *p = a, *q = b;
    if (p->angle != q->angle)
        return p->angle < q->angle ? -1 : 1;
    return (p->i > q->i) - (p->i < q->i);
}

static bool same_place(const double *x, const double *y, const double *theta, double size, size_t i, size_t k)
{
    if (x && !(hypot(x[k] - x[i], y[k] - y[i]) <= ANGLE_EPS*size))
        return false;
    return !theta || fabs(remainder(theta[k] - theta[i], TURN)) <= ANGLE_EPS;
}

static bool same_station(const lw_target *t, size_t i, size_t k)
{
    bool same = same_place(t->x, t->y, t->theta, t->size, i, k);
    for (int p = 0; p < t->n_also; p++)
        same &= same_place(t->also[p].x, t->also[p].y, t->also[p].theta, t->extent, i, k);
    return same;
}

void lw_target_drop_repeat(lw_target *t)
{
    char text[40];
    if (!t->closed || !t->x || t->angle || t->n < 4 || !same_station(t, 0, t->n - 1))
        return;
    t->n--;
    lw_target_add_note(t, "%s repeats the first station of the closed path and is left out", where(t, t->n, text));
}

static lw_status repeated(const lw_target *t, size_t i, size_t k, lw_target_place *place, lw_error *e)
{
    size_t first = i < k ? i : k, later = i < k ? k : i;
    char text[40];
    *place = (lw_target_place){ later, LW_TARGET_FIELD_ANGLE };
    return lw_error_set(e, LW_E_ARG, "the input angle %.9g %s stands in %s already, with other values; at one "
                        "input the linkage is in one place: change one of the two, or leave the column out if the "
                        "timing does not matter", t->angle[later]/t->units.radian, t->units.angle,
                        where(t, first, text));
}

/* Turns of the input over which a timing extends: an angle that occurs again in another turn may have another point. */
static double span(const lw_target *t)
{
    double least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < t->n; i++) {
        least = fmin(least, t->angle[i]);
        most = fmax(most, t->angle[i]);
    }
    return (most - least)/TURN;
}

static lw_status check_repeats(const lw_target *t, lw_target_place *place, lw_error *e)
{
    crank *c = malloc(t->n*sizeof *c);
    lw_status s = LW_OK;
    if (!c)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", t->n);
    bool once = span(t) <= 1 + ANGLE_EPS;
    for (size_t i = 0; i < t->n; i++)
        c[i] = (crank){ t->angle[i] - (once ? TURN*floor(t->angle[i]/TURN) : 0), i };
    qsort(c, t->n, sizeof *c, by_angle);
    for (size_t i = 0; s == LW_OK && i + 1 < t->n; i++)
        if (c[i+1].angle - c[i].angle <= ANGLE_EPS && !same_station(t, c[i].i, c[i+1].i))
            s = repeated(t, c[i].i, c[i+1].i, place, e);
    size_t last = t->n - 1;                      /* just below a full turn equals just above 0 */
    if (s == LW_OK && once && last > 0 && c[0].angle + TURN - c[last].angle <= ANGLE_EPS && !same_station(t, c[0].i, c[last].i))
        s = repeated(t, c[0].i, c[last].i, place, e);
    free(c);
    return s;
}

/* ---- cyclic order ------------------------------------------------------------------------------ */

/* Find the first and the second station where the angles go back when followed in the direction of `sense`; n if there
 * is none. */
static void find_turns(const lw_target *t, int sense, size_t turn[2])
{
    int found = 0;
    turn[0] = turn[1] = t->n;
    for (size_t i = 1; i < t->n && found < 2; i++)
        if (sense*(t->angle[i] - t->angle[i-1]) < 0)
            turn[found++] = i;
}

/* If the part after turn[0] is moved by a full turn: is that a step forwards, and is the whole at most one turn? Or do
 * the angles always go forwards, over at most as many turns as gears may take to repeat? */
static bool fits(const lw_target *t, int sense, const size_t turn[2])
{
    const double *a = t->angle;
    bool wraps = turn[0] < t->n;
    if (wraps && !(sense*(a[turn[0]] - a[turn[0]-1]) + TURN >= 0))
        return false;
    if (!wraps)
        return span(t) <= LW_INPUT_TURNS_PER_PERIOD_MAX + ANGLE_EPS;
    return turn[1] == t->n && sense*(a[t->n-1] - a[0]) + TURN <= TURN + ANGLE_EPS;
}

static lw_status unsorted(const lw_target *t, int sense, const size_t turn[2], lw_target_place *place, lw_error *e)
{
    /* a step back by half a turn or more counts as the one permitted wrap */
    bool wraps = turn[1] < t->n && fabs(t->angle[turn[0]] - t->angle[turn[0]-1]) >= LW_PI;
    size_t i = turn[wraps];
    char text[40];
    *place = (lw_target_place){ i < t->n ? i : t->n - 1, LW_TARGET_FIELD_ANGLE };
    if (i == t->n)
        return lw_error_set(e, LW_E_ARG, "the input angles run over %.4g turns; a target is %d turns of the input at "
                            "most, without turning back", span(t), LW_INPUT_TURNS_PER_PERIOD_MAX);
    return lw_error_set(e, LW_E_ARG, "the input angles %s up to %s and turn back here, from %.9g to %.9g %s; put the "
                        "lines in the order of their angles, or leave the column out if the timing does not matter",
                        sense > 0 ? "rise" : "fall", where(t, i - 1, text), t->angle[i-1]/t->units.radian,
                        t->angle[i]/t->units.radian, t->units.angle);
}

lw_status lw_target_order(lw_target *t, lw_target_place *place, lw_error *e)
{
    size_t turn[2][2];                                    /* rising, falling */
    lw_status s = check_repeats(t, place, e);
    if (s != LW_OK)
        return s;
    find_turns(t, 1, turn[0]);
    find_turns(t, -1, turn[1]);
    bool fit[2] = { fits(t, 1, turn[0]), fits(t, -1, turn[1]) };
    int best = fit[0] && (turn[0][0] == t->n || !fit[1] || turn[1][0] < t->n) ? 0 : 1;
    if (fit[best]) {
        for (size_t i = turn[best][0]; i < t->n; i++)
            t->angle[i] += best == 0 ? TURN : -TURN;
        return LW_OK;
    }
    size_t n_up = 0, n_down = 0;
    for (size_t i = 1; i < t->n; i++) {
        n_up += t->angle[i] > t->angle[i-1];
        n_down += t->angle[i] < t->angle[i-1];
    }
    best = n_up >= n_down ? 0 : 1;
    return unsorted(t, best == 0 ? 1 : -1, turn[best], place, e);
}
