/* tests/cli_run.h - run the built program through the shell and look at all it prints.
 *
 * The commands know three words:
 *     $P   the program (LW_PROGRAM)
 *     $C   its test build, whose clock and end the environment sets: tests/fake_clock.c, tests/kill_at_write.c
 *     $D   a folder of this test's own, removed at the end
 * and $T, the test program itself, if the test sets it. */
#ifndef LW_TESTS_CLI_RUN_H
#define LW_TESTS_CLI_RUN_H

#include <fcntl.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdbool.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <wordexp.h>
#include "tests/check.h"
#include "tests/temporary.h"

typedef struct ran { int code; char *out, *err; } ran;

/* The whole file as text; "" when there is none.  Free with free(). */
static inline char *slurp(const char *path)
{
    struct stat about;
    FILE *f = fopen(path, "rb");
    size_t size = f && fstat(fileno(f), &about) == 0 ? (size_t)about.st_size : 0;
    char *text = calloc(1, size + 1);
    if (f && text)
        text[fread(text, 1, size, f)] = 0;
    if (f)
        fclose(f);
    return text;
}

/* Set P, C and D; harmless when they are set. */
static inline void run_prepare(void)
{
    const char *program = getenv("LW_PROGRAM");
    char test_build[300];
    program = program ? program : "build/linkwright";
    const char *name = strrchr(program, '/');
    snprintf(test_build, sizeof test_build, "%.*stests/linkwright", name ? (int)(name + 1 - program) : 0, program);
    setenv("D", temporary_folder(), 1);
    setenv("P", program, 1);
    setenv("C", test_build, 1);
}

/* Run a command that is one call of the program, "NAME=value $C word ...", without a shell, which takes as long to start as
 * the program.  Returns its exit code, 128 + the number of the signal that ended it, or -1: a shell has to read the command. */
static inline int run_directly(const char *command, const char *out, const char *err)
{
    wordexp_t words;
    posix_spawn_file_actions_t files;
    pid_t child;
    int n_name = 0, n_set = 0, status = -1;
    const char *program = strpbrk(command, "$`'\"");
    if (!program || !strchr("CPT", program[1]) || program[1] == 0 || program[2] != ' ' || program[0] != '$' || (program > command && program[-1] != ' '))
        return -1;
    if (wordexp(command, &words, WRDE_NOCMD) != 0)
        return -1;
    while (n_name < (int)words.we_wordc && strchr(words.we_wordv[n_name], '='))
        n_name++;
    while (environ[n_set])
        n_set++;
    char **set = calloc((size_t)(n_name + n_set + 1), sizeof *set);      /* the first of two values of a name counts */
    memcpy(set, words.we_wordv, (size_t)n_name*sizeof *set);
    memcpy(set + n_name, environ, (size_t)n_set*sizeof *set);
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, out, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    posix_spawn_file_actions_addopen(&files, 2, err, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    bool started = posix_spawnp(&child, words.we_wordv[n_name], &files, NULL, words.we_wordv + n_name, set) == 0;
    posix_spawn_file_actions_destroy(&files);
    free(set);
    wordfree(&words);
    if (!started || waitpid(child, &status, 0) != child)
        return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static inline ran run(const char *command)
{
    char line[4096], out[256], err[256];
    run_prepare();
    snprintf(out, sizeof out, "%s/stdout", getenv("D"));
    snprintf(err, sizeof err, "%s/stderr", getenv("D"));
    int code = run_directly(command, out, err);
    if (code < 0) {
        snprintf(line, sizeof line, "{ %s\n} > %s 2> %s < /dev/null", command, out, err);
        int status = system(line);
        code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    return (ran){ code, slurp(out), slurp(err) };
}

static char run_text[1 << 16];             /* the command of the last call of a function below whose name ends in _with */

#define RUN_FORMAT(format) \
    do { va_list arg_; va_start(arg_, format); int n_ = vsnprintf(run_text, sizeof run_text, format, arg_); va_end(arg_); \
         CHECK(n_ >= 0 && (size_t)n_ < sizeof run_text); } while (0)

/* run() of a text with arguments, as printf has them; likewise below. */
__attribute__((format(printf, 1, 2))) static inline ran run_with(const char *format, ...)
{
    RUN_FORMAT(format);
    return run(run_text);
}

static inline void ran_free(ran *r)
{
    free(r->out);
    free(r->err);
    *r = (ran){ 0 };
}

/* Run, and check the exit code and a part of each output (NULL: not looked at). */
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

__attribute__((format(printf, 4, 5)))
static inline void expect_with(int code, const char *out_has, const char *err_has, const char *format, ...)
{
    RUN_FORMAT(format);
    expect(run_text, code, out_has, err_has);
}

/* Every command and action that the program knows, as "fit" or "catalogue build", from its completion; returns their number. */
static inline int all_commands(char (*words)[48], int most)
{
    ran r = run("$P help --completion bash");
    int n = 0;
    char command[20] = "", action[20];
    for (char *line = r.out; line && n < most; line = strchr(line, '\n'), line += line != NULL) {
        char *actions = strstr(line, "-eq 2 ] && words=\""), *end = strchr(line, '\n');
        int head = 0;
        if (strncmp(line, "    ", 4) == 0 && sscanf(line + 4, "%19[a-z]) case%n", command, &head) == 1 && head)
            snprintf(words[n++], sizeof *words, "%s", command);
        if (!actions || !end || actions > end || n == 0)
            continue;
        n--;                                     /* the command runs by its actions only */
        actions += strlen("-eq 2 ] && words=\"");
        for (int used; n < most && sscanf(actions, "%19[a-z] %n", action, &used) == 1; actions += used)
            snprintf(words[n++], sizeof *words, "%s %s", command, action);
    }
    ran_free(&r);
    CHECK(n > 20);
    return n;
}

/* ---- tables -------------------------------------------------------------------------------------------------- */

enum { CELLS = 64 };

/* Split a line into cells: at commas, or at two or more blanks.  The line is changed; '#' and blanks before it go. */
static inline int split_cells(char *line, bool commas, char *cell[CELLS])
{
    int n = 0;
    line += strspn(line, "# ");
    while (n < CELLS) {
        char *end = commas ? strchr(line, ',') : strstr(line, "  ");
        cell[n++] = line;
        if (!end)
            break;
        *end = 0;
        line = end + 1 + (commas ? 0 : strspn(end + 1, " "));
    }
    return n;
}

static inline bool same_cell(const char *a, const char *b)
{
    char *end_a, *end_b;
    double x = strtod(a, &end_a), y = strtod(b, &end_b);
    return strcmp(a, b) == 0 || (end_a > a && end_b > b && *end_a == 0 && *end_b == 0 && x == y);
}

/* Has the table in `text` a row with these values in these columns, both separated by '|'?  Columns are found by their
 * names in the first line that holds the first of them; numbers are compared as numbers. */
static inline bool has_row(const char *text, const char *columns, const char *values)
{
    char *copy = strdup(text), *rest = copy, *names = strdup(columns), *wanted = strdup(values);
    char *cell[CELLS], *name[CELLS], *value[CELLS];
    int place[CELLS], n_name = 0, n_value = 0;
    bool headed = false, found = false, commas = strchr(text, ',') && !strstr(text, "  ");
    for (char *word = strtok(names, "|"); word && n_name < CELLS; word = strtok(NULL, "|"))
        name[n_name++] = word;
    for (char *at = wanted, *word; (word = strsep(&at, "|")) && n_value < CELLS;)
        value[n_value++] = word;
    for (char *line; !found && (line = strsep(&rest, "\n"));) {
        int n = split_cells(line, commas, cell), n_same = 0;
        for (int k = 0; k < n_name && headed; k++)
            n_same += place[k] < n && same_cell(cell[place[k]], value[k]);
        found = headed && n_same == n_name;
        for (int k = 0, n_found = 0; k < n_name && !headed; k++)
            for (int i = 0; i < n; i++)
                if (strcmp(cell[i], name[k]) == 0) {
                    place[k] = i;
                    headed = ++n_found == n_name;
                    break;
                }
    }
    free(copy), free(names), free(wanted);
    return found && n_name == n_value;
}

/* Run, and check that it ends well and prints a table with this row. */
static inline void expect_row(const char *command, const char *columns, const char *values)
{
    ran r = run(command);
    CHECK_INT(r.code, 0);
    CHECK(has_row(r.out, columns, values));
    if (!has_row(r.out, columns, values))
        fprintf(stderr, "%s\n  has no row %s = %s: %s%s", command, columns, values, r.out, r.err);
    ran_free(&r);
}

/* Run, and check that it ends well and prints these words, with any number of blanks between them. */
static inline void expect_words(const char *command, const char *words)
{
    ran r = run(command);
    char *to = r.out;
    CHECK_INT(r.code, 0);
    for (const char *from = r.out; *from; from++)
        if (*from != ' ' || to == r.out || to[-1] != ' ')
            *to++ = *from;
    *to = 0;
    CHECK_HAS(r.out, words);
    ran_free(&r);
}

#endif
