/* Motions of axes, work cycles, loads, motors and servo axes. */
#include "surface/surface.h"

#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "catalogues/store/drive_store.h"
#include "grammar/model/drive_parts.h"
#include "grammar/model/servo.h"
#include "grammar/model/work_cycle.h"
#include "mbs/drives/load.h"

LW_SURFACE_FILE(lw_servo)
LW_SURFACE_FILE(lw_work_cycle)

/* ---- work cycles ------------------------------------------------------------------------------------------------ */

int lw_work_cycle_count(const lw_work_cycle *cycle, char what)
{
    return what == 'a' ? cycle->n_axis : what == 'm' ? cycle->n_move : 0;
}

const char *lw_work_cycle_name(const lw_work_cycle *cycle, char what, int i)
{
    if (i < 0 || i >= lw_work_cycle_count(cycle, what))
        return NULL;
    return what == 'a' ? cycle->axis[i].name : cycle->move[i].name;
}

lw_status lw_work_cycle_times(const lw_work_cycle *cycle, int move, double *start, double *duration, double *dwell)
{
    if (move < 0 || move >= cycle->n_move)
        return LW_E_ARG;
    *start = cycle->move[move].start;
    *duration = cycle->move[move].duration;
    *dwell = cycle->move[move].dwell;
    return LW_OK;
}

double lw_work_cycle_end(const lw_work_cycle *cycle) { return cycle->end; }

/* ---- loads and parts -------------------------------------------------------------------------------------------- */

lw_status lw_model_loads(const lw_model *model, double from, double to, int intervals, lw_loads *out, lw_error *error)
{
    const lw_load_options o = { .from = from, .to = to, .intervals = intervals };
    return lw_loads_planar(model, &o, out, error);
}

lw_status lw_spatial_loads(const lw_spatial *model, double from, double to, int intervals, lw_loads *out, lw_error *error)
{
    const lw_load_options o = { .from = from, .to = to, .intervals = intervals };
    return lw_loads_spatial(model, &o, out, error);
}

lw_status lw_drive_parts_load(const char *path, lw_drive_parts **parts, lw_error *error)
{
    bool fresh = !*parts;
    char *text = NULL;
    size_t size = 0;
    if (fresh && !(*parts = calloc(1, sizeof **parts)))
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status s = lw_file_read(path, &text, &size, error);
    if (s == LW_OK && size >= 15 && memcmp(text, "SQLite format 3", 15) == 0)
        s = lw_store_read_drive_parts(path, *parts, error);
    else if (s == LW_OK)
        s = lw_drive_parts_read(text, size, path, *parts, error);
    free(text);
    if (s != LW_OK && fresh) {
        lw_drive_parts_destroy(*parts);
        *parts = NULL;
    }
    return s;
}

void lw_drive_parts_destroy(lw_drive_parts *parts)
{
    if (parts)
        lw_drive_parts_free(parts);
    free(parts);
}

static int kind_of(char kind) { return kind == 'm' ? 0 : kind == 'g' ? 1 : kind == 'a' ? 2 : -1; }

int lw_drive_parts_count(const lw_drive_parts *parts, char kind)
{
    return kind_of(kind) < 0 ? 0 : lw_part_count(parts, kind_of(kind));
}

const char *lw_drive_parts_name(const lw_drive_parts *parts, char kind, int i)
{
    return i < 0 || i >= lw_drive_parts_count(parts, kind) ? NULL : lw_part_name(parts, kind_of(kind), i);
}
