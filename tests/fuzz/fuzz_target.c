/* A target that can be read keeps what target.h promises, and can be made again from its arrays. */
#include <math.h>

#include "optimise/task/target.h"
#include "tests/fuzz/fuzz.h"

static void check_stations(const lw_target *t, int spread)
{
    demand(t->n >= 1 && t->n <= LW_STATION_MAX && !t->x == !t->y && t->weight && t->line);
    demand(t->x || (t->angle && t->theta));
    demand(isfinite(t->length) && isfinite(t->size) && t->length >= 0 && t->size >= 0);
    for (size_t i = 0; i < t->n; i++) {
        demand(!t->x || (isfinite(t->x[i]) && isfinite(t->y[i])));
        demand(!t->theta || isfinite(t->theta[i]));
        demand(isfinite(t->weight[i]) && t->weight[i] >= 0 && t->line[i] > (i && !spread ? t->line[i-1] : 0));
        for (int k = 0; k < t->n_also; k++) {
            const lw_also *a = &t->also[k];
            demand(!a->x == !a->y && (a->x || a->theta) && (!a->x || t->x) && a->weight[i] >= 0);
            demand((!a->x || (isfinite(a->x[i]) && isfinite(a->y[i]))) && (!a->theta || isfinite(a->theta[i])));
        }
        demand(!t->angle || i == 0 || (t->angle[i] - t->angle[i-1])*(t->angle[t->n-1] - t->angle[0]) >= 0);
    }
}

static int one_input(const uint8_t *data, size_t size)
{
    static const lw_target_options option[] = { { .closed = -1 },
        { .closed = 1, .length_unit = "mm", .angle_unit = "deg" }, { .length_unit = "in", .smooth = 0.1, .stations
                                                                     = 12 } };
    for (int i = 0; i < 3; i++) {
        lw_target t, again;
        lw_error e = { .text = "" };
        if (lw_target_read((const char *)data, size, "f", &option[i], &t, &e) != LW_OK) {
            demand(e.status != LW_OK && e.text[0] && memchr(e.text, '\0', sizeof e.text) != NULL);
            continue;
        }
        check_stations(&t, option[i].stations);
        demand(lw_target_make_all(t.n, t.x, t.y, t.theta, t.angle, t.weight, t.also, t.n_also, t.closed, &again, &e) == LW_OK);
        demand(again.closed == t.closed && again.length == t.length && again.size == t.size);
        demand(again.n_also == t.n_also && again.extent == t.extent && t.extent >= t.size);
        for (int k = 0; k < t.n_also; k++)
            demand(again.also[k].length == t.also[k].length && !again.also[k].x == !t.also[k].x);
        lw_target_free(&again);
        lw_target_free(&t);
    }
    return 0;
}
