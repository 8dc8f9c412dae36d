/* cli/program/kept_answers.h - answers of numbered tasks in a file, so that no interruption loses more than the tasks at
 * work.
 *
 * The file holds a line `linkwright answers of H`, where H says which run it is, and for each answer a line
 * `task K bytes N check C`, N bytes and a line end.  C is the FNV-1a hash of K and of the bytes.  Files of the same
 * run can be joined by `cat`. */
#ifndef CLI_PROGRAM_KEPT_ANSWERS_H
#define CLI_PROGRAM_KEPT_ANSWERS_H

#include <stdbool.h>
#include <stdint.h>
#include "base/error.h"

typedef struct cli_kept cli_kept;

/* The number of a run: a hash of the build of the program, the command line without the options that only say where the
 * work is done or goes, and the contents of the files that it names, as far as they can be read.  LW_E_MEMORY. */
lw_status cli_kept_run(const char *line, int n_file, const char *const *file, uint64_t *run, lw_error *e);

/* Open the file, or make an empty one.  An incomplete last answer is removed.  LW_E_NOTATION: damaged, or of another run;
 * LW_E_IO, also while another program has it open; LW_E_MEMORY. */
lw_status cli_kept_open(const char *path, uint64_t run, cli_kept **k, lw_error *e);
void      cli_kept_close(cli_kept *k);

/* The check sum of an answer.  It covers the number of the task: an answer whose number has changed would be taken for
 * that of another task. */
uint64_t cli_kept_check(size_t task, const char *answer, size_t size);

/* The answer of a task; NULL: it is not there. */
const char *cli_kept_get(const cli_kept *k, size_t task, size_t *size);

/* Add an answer; it is on disk when this returns.  LW_E_IO, LW_E_MEMORY. */
lw_status cli_kept_add(cli_kept *k, size_t task, const char *answer, size_t size, lw_error *e);

#endif
