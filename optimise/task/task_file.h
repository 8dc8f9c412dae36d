/* optimise/task/task_file.h - a task file: the task and the conditions of a linkage as one JSON object
 * (docs/notation.md, "Task"). */
#ifndef LW_OPTIMISE_TASK_TASK_FILE_H
#define LW_OPTIMISE_TASK_TASK_FILE_H

#include "optimise/task/specification.h"

#define LW_DWELL_MAX  8
#define LW_TASK_FILE_TEXT 256

/* A dwell: the output rests while the input moves from `from` to `to`. It adds `points` stations. */
typedef struct lw_dwell {
    double from, to;            /* input [rad]                                                     */
    double theta;               /* output or tool angle [rad], if the task has one                 */
    lw_vec2 at;                 /* point [m], if the task has one                                  */
    int    points;
    double weight;
} lw_dwell;

/* Targets of a further point. */
typedef struct lw_task_file_tracer {
    char      target[LW_TASK_FILE_TEXT];        /* as those of lw_task_file                                */
    lw_target stations;
} lw_task_file_tracer;

typedef struct lw_task_file {
    char        name[64];
    char        target[LW_TASK_FILE_TEXT];      /* CSV file, relative to the task file; "": `stations`  */
    lw_target   stations;                   /* given in the task itself; n 0: none                 */
    int         n_also;
    lw_task_file_tracer also[LW_ALSO_MAX];      /* further points, row by row with these (lw_target_join) */
    int         closed;                     /* 1, 0, -1: not given                                 */
    lw_fit_spec spec;
    unsigned    limits;                     /* LW_LIMIT_ bits of the limits that it gives, or switches off */
    double      smooth;                     /* as lw_target_options.smooth, in the unit of the target file */
    int         resample;                   /* as lw_target_options.stations                       */
    bool        has_task, has_timing;       /* given; else the target's columns decide             */
    int         links, dof;                 /* 0: not given                                        */
    char        joints[16], topology[LW_TASK_FILE_TEXT];      /* "": not given                          */
    int         n_dwell;
    lw_dwell    dwell[LW_DWELL_MAX];
    lw_units    units;
} lw_task_file;

/* Read a task. LW_E_NOTATION with line and column, also if conditions contradict each other; LW_E_MEMORY. After a
 * failure b needs no _free. */
lw_status lw_task_file_read(const char *text, size_t size, const char *file, lw_task_file *b, lw_error *e);
void      lw_task_file_free(lw_task_file *b);

/* Make a target t from the stations of the target (of all points, joined) and those of the dwells, in order of the
 * input. LW_E_ARG: a dwell in a target without input angles or with further points, or a station inside a forbidden
 * zone. */
lw_status lw_task_file_target(const lw_task_file *b, const lw_target *from, lw_target *t, lw_error *e);

#endif
