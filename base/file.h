/* base/file.h - whole files in, whole files out: nothing half-written.
 *
 * Output goes to a temporary beside its target and is renamed when complete, so that a full disk or
 * a read-only folder leaves the old file as it was.  "-" is standard input or output. */
#ifndef LW_BASE_FILE_H
#define LW_BASE_FILE_H

#include <stdbool.h>
#include <stdio.h>
#include "base/error.h"

/* The whole file as a terminated string; *size without the terminator.  Free with free().
 * LW_E_IO for what cannot be read (a directory is named as such), files over 256 MiB are refused. */
lw_status lw_file_read(const char *path, char **text, size_t *size, lw_error *e);

typedef struct lw_output { FILE *f; char path[1024], temp[1088]; bool partial; } lw_output;

/* Open a temporary beside path; write to o->f; then _commit (flush, sync to disk, check, rename) or
 * _abandon (remove).  After a failed commit the target is untouched and the temporary gone. */
lw_status lw_output_open(lw_output *o, const char *path, lw_error *e);
lw_status lw_output_commit(lw_output *o, lw_error *e);
void      lw_output_abandon(lw_output *o);

/* The same for long work that is gone on with after the program was killed: the temporary is path with ".partial"
 * behind it, for reading too, with what it already holds, the position at its start; _abandon and a failed commit
 * leave it there.  LW_E_IO while another program writes it.  A pipe or device is opened as by _open. */
lw_status lw_output_open_partial(lw_output *o, const char *path, lw_error *e);

/* open + write + commit of bytes that are ready. */
lw_status lw_file_write(const char *path, const void *bytes, size_t size, lw_error *e);

#endif
