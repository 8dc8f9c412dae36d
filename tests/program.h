/* tests/program.h - many test programs in one: `make test` links their files once, and the name by which the program is called says
 * whose tests run. */
#ifndef LW_TESTS_PROGRAM_H
#define LW_TESTS_PROGRAM_H

typedef struct test_program { const char *file; int (*run)(int argc, char **argv); struct test_program *next; } test_program;
__attribute__((weak)) test_program *test_programs;       /* of all files that are linked: one variable */

/* In each file of tests once: what runs them, from the list of arguments to the exit code. */
#define TEST_PROGRAM(run) \
    __attribute__((constructor)) static void test_program_is_listed(void) \
    { static test_program here = { __BASE_FILE__, run, NULL }; here.next = test_programs; test_programs = &here; }

#endif
