/* cli/program/data.h - find the published tables and problems. */
#ifndef CLI_PROGRAM_DATA_H
#define CLI_PROGRAM_DATA_H

#include <stddef.h>

/* Path of a file or folder of catalogues/data: in the sources, relative to the current folder or to the program, or
 * where `make install` put it. The path is not checked; reading the file shows whether it exists. */
void cli_data_path(const char *name, char *path, size_t size);

/* The folder that holds docs/ and examples/: the sources, or where `make install` put them. */
void cli_document_folder(char *path, size_t size);

#endif
