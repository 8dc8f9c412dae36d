/* cli/program/data.h - where the published tables and problems lie. */
#ifndef CLI_PROGRAM_DATA_H
#define CLI_PROGRAM_DATA_H

#include <stddef.h>

/* Path of a file or folder of catalogues/data: in the sources, seen from here or from the built program,
 * or where `make install` put it beside the program, wherever that is.  Whether it is there the caller
 * finds out by reading it. */
void cli_data_path(const char *name, char *path, size_t size);

/* The folder in which docs/ and examples/ stand: the sources, or where `make install` put them. */
void cli_document_folder(char *path, size_t size);

#endif
