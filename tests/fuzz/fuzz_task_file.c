/* Any bytes are a task with sane numbers, which gives a target or a reason why not, or have an error with a place. */
#include <math.h>

#include "optimise/task/task_file.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static lw_task_file b;
    lw_error e = { .text = "" };
    lw_target t;
    lw_status s = lw_task_file_read((const char *)data, size, "f", &b, &e);
    if (refused(s, &e))
        return 0;
    demand(b.target[0] != 0 || b.stations.n > 0);
    demand(b.spec.n_zone <= LW_ZONE_MAX && b.n_dwell <= LW_DWELL_MAX);
    demand(b.links == 0 || (b.links >= 4 && b.links % 2 == 0));
    for (int i = 0; i < b.n_dwell; i++)
        demand(b.dwell[i].from < b.dwell[i].to && b.dwell[i].points >= 2);
    const lw_target *part[1 + LW_ALSO_MAX] = { &b.stations };
    bool whole = b.stations.n > 0;
    for (int i = 0; i < b.n_also; i++) {
        demand(!b.also[i].target[0] == (b.also[i].stations.n > 0));
        whole &= b.also[i].stations.n > 0;
        part[i + 1] = &b.also[i].stations;
    }
    if (whole && lw_target_join(part, 1 + b.n_also, &t, &e) == LW_OK) {
        demand(t.n == b.stations.n && t.n_also == b.stations.n_also + b.n_also);
        lw_target_free(&t);
    }
    if (b.stations.n > 0 && lw_task_file_target(&b, &b.stations, &t, &e) == LW_OK) {
        demand(t.n >= b.stations.n);
        lw_target_free(&t);
    }
    lw_task_file_free(&b);
    return 0;
}
