/* main() of the tests and of the replay of fuzz targets. */
#include <stdio.h>
#include "tests/fresh_memory.h"
#include "tests/program.h"

/* "tests/test_chain.c" is the file of "test_chain". */
static int is_of(const char *file, const char *name)
{
    const char *base = strrchr(file, '/');
    size_t n = strlen(name);
    base = base ? base + 1 : file;
    return strncmp(base, name, n) == 0 && strcmp(base + n, ".c") == 0;
}

int main(int argc, char **argv)
{
    extern char *program_invocation_short_name;
    for (test_program *p = test_programs; p; p = p->next)
        if (is_of(p->file, program_invocation_short_name))
            return p->run(argc, argv);
    fprintf(stderr, "%s: no such tests\n", program_invocation_short_name);
    return 2;
}

/* The linker sends the library's calls of malloc here. */
void *__real_malloc(size_t n);
void *__wrap_malloc(size_t n);
void *__wrap_malloc(size_t n)
{
    return fill_with_nan(__real_malloc(n), n);
}
