/* optimise/task/read_file.h - targets and tasks from files, with the files that a task names. */
#ifndef LW_OPTIMISE_TASK_READ_FILE_H
#define LW_OPTIMISE_TASK_READ_FILE_H

#include "optimise/task/task_file.h"

/* CSV; by the end of the name SVG or DXF.  "-" is standard input.  LW_E_IO, and failures of the readers. */
lw_status lw_target_read_file(const char *path, const lw_target_options *o, lw_target *t, lw_error *e);

/* A task with its target: its own stations, or the files it names, beside it; dwells put in.  o overrules the file,
 * may be NULL.  After a failure neither needs _free. */
lw_status lw_task_file_read_file(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t,
                                 lw_error *e);

#endif
