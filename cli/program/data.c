#include "cli/program/data.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

void cli_data_path(const char *name, char *path, size_t size)
{
    static const char *const beside[] = { "../catalogues/data", "../share/linkwright" };
    char program[512];
    ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    program[n > 0 ? n : 0] = 0;
    char *slash = strrchr(program, '/');
    if (slash)
        *slash = 0;
    snprintf(path, size, "catalogues/data/%s", name);
    for (int i = 0; i < 2 && access(path, F_OK) != 0; i++)
        snprintf(path, size, "%s/%s/%s", program, beside[i], name);
}
