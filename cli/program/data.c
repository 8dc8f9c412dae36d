#include "cli/program/data.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Folder of the running program; "" if it is unknown. */
static void program_folder(char *folder, size_t size)
{
    ssize_t n = readlink("/proc/self/exe", folder, size - 1);
    folder[n > 0 ? n : 0] = 0;
    char *slash = strrchr(folder, '/');
    if (slash)
        *slash = 0;
}

void cli_data_path(const char *name, char *path, size_t size)
{
    static const char *const beside[] = { "../catalogues/data", "../share/linkwright", "../../catalogues/data" };
    char program[512];
    program_folder(program, sizeof program);
    snprintf(path, size, "catalogues/data/%s", name);
    for (int i = 0; i < 3 && access(path, F_OK) != 0; i++)
        snprintf(path, size, "%s/%s/%s", program, beside[i], name);
}

void cli_document_folder(char *path, size_t size)
{
    char program[512];
    program_folder(program, sizeof program);
    *path = 0;
    for (int up = 0; up < 2 && (up == 0 || access(path, F_OK) != 0); up++) {
        char *slash = strrchr(program, '/');       /* build/ or build/san/ in the sources, bin/ when installed */
        if (slash)
            *slash = 0;
        snprintf(path, size, "%s/share/doc/linkwright", program);
        if (access(path, F_OK) != 0)
            snprintf(path, size, "%s/examples", program);
    }
    char *end = strrchr(path, '/');
    if (end && strcmp(end, "/examples") == 0)
        *end = 0;
}
