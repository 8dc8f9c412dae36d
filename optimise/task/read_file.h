/* optimise/task/read_file.h - targets and tasks from files, with the files that a task names. */
#ifndef LW_OPTIMISE_TASK_READ_FILE_H
#define LW_OPTIMISE_TASK_READ_FILE_H

#include "base/file.h"
#include "optimise/task/task_file.h"

typedef enum lw_target_kind { LW_TARGET_KIND_TABLE, LW_TARGET_KIND_SVG, LW_TARGET_KIND_DXF } lw_target_kind;

/* The kind of a text: a drawing if the end of its name or its beginning says so, else a table. */
lw_target_kind lw_target_kind_of(const char *text, size_t size, const char *path);

/* A file that is often handed in by mistake: "a STEP model", and how to go on, which helps where a curve (drawing) is
 * wanted, where a table is, or anywhere. */
typedef enum lw_foreign_use { LW_FOREIGN_ANY, LW_FOREIGN_CURVE, LW_FOREIGN_TABLE } lw_foreign_use;
typedef struct lw_foreign { const char *what, *advice; lw_foreign_use use; } lw_foreign;

/* The kind of such a file by its beginning: a workbook, a picture of pixels, a mesh, an archive, ...; what NULL: none of them. */
lw_foreign lw_foreign_kind(const char *text, size_t size);

/* A table (CSV) or a drawing, from text; `file` decides by its end which of them, and is for messages; may be "".  A last station
 * that repeats the first one of a closed path without input angles is left out, here and below. */
lw_status lw_target_read_text(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);

/* A table (CSV) or a drawing.  "FILE#NAME" names a curve of a drawing (lw_target_options.curve).  "-" is standard
 * input.
 * LW_E_IO, and failures of the readers. */
lw_status lw_target_read_file(const char *path, const lw_target_options *o, lw_target *t, lw_error *e);

/* A task with its target: its own stations, or the files it names, beside it; dwells put in.  o overrules the file,
 * may be NULL.  After a failure neither needs _free. */
lw_status lw_task_file_read_file(const char *path, const lw_target_options *o, lw_task_file *task, lw_target *t, lw_error *e);

/* A task from text, which must hold its own stations.  LW_E_ARG: it names a file. */
lw_status lw_task_file_read_text(const char *text, size_t size, const char *file, lw_task_file *task, lw_target *t, lw_error *e);

/* Path of a file named in the task file `path`: relative to the task's folder, unless the name is absolute. */
lw_status lw_task_file_beside(const char *path, const char *name, char out[LW_PATH_SIZE], lw_error *e);

#endif
