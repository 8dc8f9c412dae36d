#include "optimise/task/read_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "base/file.h"
#include "optimise/task/target_outline.h"

lw_status lw_target_read_file(const char *path, const lw_target_options *o, lw_target *t, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = lw_file_read(path, &text, &size, e);
    const char *end = strrchr(path, '.');
    if (s == LW_OK)
        s = (end && strcasecmp(end, ".svg") == 0 ? lw_target_read_svg
             : end && strcasecmp(end, ".dxf") == 0 ? lw_target_read_dxf : lw_target_read)(text, size, path, o, t, e);
    free(text);
    return s;
}

/* Path of a file named in a task: relative to the task's folder, unless the name is absolute. */
static void beside(const char *path, const char *name, char *out, size_t size)
{
    const char *slash = strrchr(path, '/');
    int folder = name[0] == '/' || !slash ? 0 : (int)(slash - path) + 1;
    snprintf(out, size, "%.*s%s", folder, path, name);
}

/* Read a target of a task: its own stations, or a file named in it. */
static lw_status read_source(const char *path, const char *name, const lw_target *own, const lw_target_options *o,
                             lw_target *read, const lw_target **part, lw_error *e)
{
    char file[1024];
    *part = own;
    if (!name[0])
        return LW_OK;
    beside(path, name, file, sizeof file);
    *part = read;
    return lw_target_read_file(file, o, read, e);
}

static lw_status read_target(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t,
                             lw_error *e)
{
    lw_target read[1 + LW_ALSO_MAX], joined;
    const lw_target *part[1 + LW_ALSO_MAX];
    lw_target_options mine = o ? *o : (lw_target_options){ .closed = -1 };
    memset(read, 0, sizeof read);
    if (mine.closed < 0)
        mine.closed = task->closed;
    lw_status s = read_source(path, task->target, &task->stations, &mine, &read[0], &part[0], e);
    for (int i = 0; i < task->n_also && s == LW_OK; i++)
        s = read_source(path, task->also[i].target, &task->also[i].stations, &mine, &read[i + 1], &part[i + 1], e);
    if (s == LW_OK && (s = lw_target_join(part, 1 + task->n_also, &joined, e)) == LW_OK) {
        s = lw_task_file_target(task, &joined, t, e);
        lw_target_free(&joined);
    }
    for (int i = 0; i <= LW_ALSO_MAX; i++)
        lw_target_free(&read[i]);
    return s;
}

lw_status lw_task_file_read_file(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t,
                                 lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = lw_file_read(path, &text, &size, e);
    if (s == LW_OK)
        s = lw_task_file_read(text, size, path, task, e);
    free(text);
    if (s != LW_OK)
        return s;
    s = read_target(path, o, task, t, e);
    if (s != LW_OK && e && !e->file[0])
        snprintf(e->file, sizeof e->file, "%s", path);
    if (s != LW_OK)
        lw_task_file_free(task);
    return s;
}
