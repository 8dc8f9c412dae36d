/* cli/program/file_kind.h - tell the kinds of files apart. */
#ifndef CLI_PROGRAM_FILE_KIND_H
#define CLI_PROGRAM_FILE_KIND_H

#include "cli/program/command.h"

/* Is this the text of a target (CSV)? */
bool cli_is_target(const char *text, size_t size);

/* Is it a plain file?  A pipe can be read only once: a second read gets nothing, or waits for ever. */
bool cli_can_read_again(const char *path);

/* Is it an SQLite file? */
bool cli_is_catalogue(const char *path);

/* If the file is of a known kind (command.h) that is not among those wanted, set e: what it is, and the command that
 * reads it.  Call it after reading the file has failed.  Returns that kind; else CLI_UNKNOWN. */
cli_kind_of_file cli_wrong_kind(const char *path, unsigned wanted, lw_error *e);

#endif
