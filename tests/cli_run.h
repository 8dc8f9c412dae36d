/* tests/cli_run.h - run the built program (LW_PROGRAM) through the shell and look at all it said. */
#ifndef LW_TESTS_CLI_RUN_H
#define LW_TESTS_CLI_RUN_H

#include <sys/wait.h>
#include "tests/check.h"

typedef struct ran { int code; char *out, *err; } ran;

static inline char *slurp(const char *path)
{
    FILE *f = fopen(path, "rb");
    char *text = calloc(1, 1 << 22);
    if (f && text)
        text[fread(text, 1, (1 << 22) - 1, f)] = 0;
    if (f)
        fclose(f);
    return text;
}

/* "$P" in the command stands for the program, "$D" for a folder of this test's own. */
static inline ran run(const char *command)
{
    static char folder[64];
    if (!folder[0]) {
        snprintf(folder, sizeof folder, "/tmp/lw-cli-XXXXXX");
        const char *program = getenv("LW_PROGRAM");
        if (!mkdtemp(folder))
            abort();
        setenv("D", folder, 1);
        setenv("P", program ? program : "build/linkwright", 1);
    }
    char line[4096], out[96], err[96];
    snprintf(out, sizeof out, "%s/stdout", folder);
    snprintf(err, sizeof err, "%s/stderr", folder);
    snprintf(line, sizeof line, "{ %s\n} > %s 2> %s < /dev/null", command, out, err);
    int status = system(line);
    return (ran){ WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err) };
}

static inline void ran_free(ran *r)
{
    free(r->out);
    free(r->err);
}

/* Run, and check the exit code and a part of what it said (NULL: not looked at). */
static inline void expect(const char *command, int code, const char *out_has, const char *err_has)
{
    ran r = run(command);
    if (r.code != code)
        fprintf(stderr, "%s\n  said: %s", command, r.err);
    CHECK_INT(r.code, code);
    if (out_has)
        CHECK_HAS(r.out, out_has);
    if (err_has)
        CHECK_HAS(r.err, err_has);
    ran_free(&r);
}

static inline void run_end(void)
{
    if (getenv("D") && system("rm -rf \"$D\"") != 0)
        perror("rm");
}

#endif
