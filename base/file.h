/* base/file.h - read and write whole files; an output file is never left half-written.
 *
 * Output goes to a temporary file beside its target, which is renamed when it is complete.  A full disk or a read-only
 * folder leaves the old file as it was.  "-" is standard input or output. */
#ifndef LW_BASE_FILE_H
#define LW_BASE_FILE_H

#include <stdbool.h>
#include <stdio.h>
#include "base/error.h"

/* Read the whole file as a terminated string; *size does not count the terminator.  Free it with free().
 * LW_E_IO if it cannot be read (the text says so if it is a directory), is larger than 256 MiB or changes meanwhile. */
lw_status lw_file_read_bytes(const char *path, char **bytes, size_t *size, lw_error *e);

/* The same for a text: a byte order mark in front of it is dropped, and UTF-16 that begins with one becomes UTF-8. */
lw_status lw_file_read(const char *path, char **text, size_t *size, lw_error *e);

/* LW_E_IO if size or time of the regular file differ from those `before`: what was read in between belongs to no one version. */
struct stat;
lw_status lw_file_unchanged(int fd, const struct stat *before, const char *path, lw_error *e);

/* The error LW_E_IO "PATH: cannot be VERB: why" for an error number of the system. */
lw_status lw_file_failed(lw_error *e, const char *verb, const char *path, int number);

#define LW_PATH_SIZE 4096           /* of a path with its terminator: PATH_MAX */

typedef struct lw_output { FILE *f; char path[LW_PATH_SIZE], temp[LW_PATH_SIZE + 32]; bool partial; } lw_output;

/* Open a temporary file beside path and write to o->f.  Then call _commit (flush, sync to disk, check, rename) or
 * _abandon (remove).  After a failed commit the target is unchanged and the temporary file is removed. */
lw_status lw_output_open(lw_output *o, const char *path, lw_error *e);
lw_status lw_output_commit(lw_output *o, lw_error *e);
void      lw_output_abandon(lw_output *o);

/* For a program that a signal ends at once: what is written so far in the file `temp` of an output becomes `path`. False if
 * that is nothing.  It takes no memory and no locks. */
bool      lw_output_keep(const char *temp, const char *path);

/* As _commit, for a result that is not complete: the file becomes path + ".partial" and path stays as it was. LW_E_IO if
 * such a file exists that lw_output_commit_partial did not write (lw_file_is_own). */
lw_status lw_output_commit_partial(lw_output *o, lw_error *e);

/* Remove the temporary files that killed programs left in the folder of this output. */
void lw_output_clean(const char *path);

/* Was the file written by lw_output_commit, and not changed since?  Each committed file carries the attribute
 * `user.linkwright` with its size and time of change.  On a file without attributes (copied, or a file system that
 * keeps none) the command line at the start of the text decides: "# linkwright ..." or "command": "linkwright ...". */
bool lw_file_is_own(const char *path);

/* The same for long work that continues after the program was killed.  The temporary file is path + ".partial".  It is
 * opened for reading and writing with its earlier content, positioned at its start; _abandon and a failed commit keep
 * it.  LW_E_IO while another program writes it.  A pipe or device is opened as by _open. */
lw_status lw_output_open_partial(lw_output *o, const char *path, lw_error *e);

/* Open, write and commit `size` bytes. */
lw_status lw_file_write(const char *path, const void *bytes, size_t size, lw_error *e);

#endif
