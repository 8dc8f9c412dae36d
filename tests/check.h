/* tests/check.h - checks that print the values of a failure, count it, and go on.
 *
 *     TEST(closes_everywhere)
 *     {
 *         CHECK_NEAR(gap(), 0, 1e-12, 0);
 *     }
 *
 * A program runs its tests in the order in which they stand in the file; tests/check_main.c holds main().  A program that
 * has something to prepare writes CHECK_MAIN { ... }, which calls check_run() and ends with check_end().
 *
 * LW_SEED=... repeats a run with random numbers; check_seed() returns it, check_rng(n) is its n-th generator, and a check that
 * fails prints it.  LW_ONLY=text: only the tests whose names hold the text. */
#ifndef LW_TESTS_CHECK_H
#define LW_TESTS_CHECK_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "linkwright.h"
#include "tests/program.h"

/* Sanitizers take three to four times as long.  They look at memory and arithmetic, not at figures: one way through the code is enough
 * for them, and tests of figures that take the same way again are left out. */
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
enum { SANITIZED = true };
#else
enum { SANITIZED = false };
#endif

/* How many of n cases that take the same way through the code to run: with sanitizers a quarter, at least one. */
static inline int check_cases(int n) { return SANITIZED ? (n + 3)/4 : n; }

static int check_failed_here, check_n_passed, check_n_failed, check_n_shown;

static inline uint64_t check_seed(void)
{
    const char *s = getenv("LW_SEED");
    return s ? strtoull(s, NULL, 10) : 20260101u;
}

static inline lw_rng check_rng(uint64_t stream)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), stream);
    return rng;
}

/* Checks of CHECK_MAIN outside its tests count, too. */
static inline void check_count_outside(void)
{
    check_n_failed += check_failed_here;
    check_failed_here = 0;
}

static inline int check_fail(const char *file, int line)
{
    check_failed_here = 1;
    if (check_n_shown++ >= 20)
        return 0;                                    /* a loop of failures need not fill the screen */
    fprintf(stderr, "%s:%d: (LW_SEED=%llu) ", file, line, (unsigned long long)check_seed());
    return 1;
}

#define CHECK(cond) \
    do { if (!(cond) && check_fail(__FILE__, __LINE__)) fprintf(stderr, "not true: %s\n", #cond); } while (0)

/* |got - want| <= absolute + relative * |want|; NaN fails */
#define CHECK_NEAR(got, want, absolute, relative) \
    do { double g_ = (got), w_ = (want), t_ = (absolute) + (relative)*fabs(w_); \
         if (!(fabs(g_ - w_) <= t_) && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "%s = %.17g, want %s = %.17g, off by %.3g, allowed %.3g\n", \
                     #got, g_, #want, w_, fabs(g_ - w_), t_); } while (0)

/* Both coordinates of a point */
#define CHECK_POINT(got, want_x, want_y, absolute, relative) \
    do { CHECK_NEAR((got).x, want_x, absolute, relative); CHECK_NEAR((got).y, want_y, absolute, relative); } while (0)

#define CHECK_INT(got, want) \
    do { long long g_ = (long long)(got), w_ = (long long)(want); \
         if (g_ != w_ && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "%s = %lld, want %s = %lld\n", #got, g_, #want, w_); } while (0)

/* The call, or a status that was kept, is LW_OK; calls that take an lw_error get &check_error, whose text is shown if not. */
static lw_error check_error __attribute__((unused));
#define CHECK_OK(call) \
    do { lw_status s_ = (call); \
         if (s_ != LW_OK && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "%s = %d: %s\n", #call, (int)s_, check_error.text); \
         check_error.text[0] = '\0'; } while (0)

/* The call is LW_OK and leaves no message. */
#define CHECK_SILENT(call) \
    do { check_error.text[0] = '\0'; lw_status s_ = (call); \
         if ((s_ != LW_OK || check_error.text[0]) && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "%s = %d: %s\n", #call, (int)s_, check_error.text); \
         check_error.text[0] = '\0'; } while (0)

/* The call returns this status, and the text of check_error has this part. */
#define CHECK_FAILS(call, status, part) \
    do { lw_status s_ = (call), w_ = (status); const char *p_ = (part); \
         if ((s_ != w_ || !strstr(check_error.text, p_)) && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "%s = %d: \"%s\", want %d: \"%s\"\n", #call, (int)s_, check_error.text, (int)w_, p_); \
         check_error.text[0] = '\0'; } while (0)

#define CHECK_TEXT(got, want) \
    do { const char *g_ = (got), *w_ = (want); \
         if ((!g_ || strcmp(g_, w_) != 0) && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "%s = \"%s\", want \"%s\"\n", #got, g_ ? g_ : "(null)", w_); } while (0)

/* The text contains the part. */
#define CHECK_HAS(text, part) \
    do { const char *g_ = (text), *w_ = (part); \
         if ((!g_ || !strstr(g_, w_)) && check_fail(__FILE__, __LINE__)) \
             fprintf(stderr, "\"%s\" does not hold \"%s\"\n", g_ ? g_ : "(null)", w_); } while (0)

static inline bool check_wanted(const char *name)
{
    const char *only = getenv("LW_ONLY");
    return !only || strstr(name, only);
}

#define RUN(test) \
    do { check_count_outside(); \
         if (!check_wanted(#test)) break; \
         test(); \
         if (check_failed_here) { check_n_failed++; printf("FAIL %s\n", #test); check_failed_here = 0; } \
         else { check_n_passed++; } \
         fflush(stdout); } while (0)

/* A test of this program, in the list of those that check_run() runs. */
typedef struct check_test { void (*run)(void); struct check_test *next; } check_test;
static check_test *check_tests, **check_last __attribute__((unused)) = &check_tests;

#define TEST(name) TEST_IF(true, name)

/* A test of the figures of searches or runs whose code other tests run, too: left out with sanitizers. */
#define TEST_OF_FIGURES(name) TEST_IF(!SANITIZED, name)

#define TEST_IF(condition, name) \
    static void name(void); \
    static void name##_runs(void) { RUN(name); } \
    __attribute__((constructor)) static void name##_is_listed(void) \
    { static check_test test = { name##_runs, NULL }; if (condition) *check_last = &test, check_last = &test.next; } \
    static void name(void)

static inline void check_run(void)
{
    for (; check_tests; check_tests = check_tests->next)
        check_tests->run();
}

static inline const char *check_program(void)
{
    extern char *program_invocation_short_name;
    return program_invocation_short_name;
}

static inline int check_end(void)
{
    check_count_outside();
    check_n_failed += check_tests != NULL;           /* some test was not run */
    printf("%s: %d passed, %d failed\n", check_program(), check_n_passed, check_n_failed);
    return check_n_failed ? 1 : 0;
}

/* OWN(lw_target) t = { 0 };  a variable that lw_target_free() frees at the end of its block. */
#define OWN(type) __attribute__((cleanup(type##_free))) type

/* FREED char *text = ...;  memory that free() frees at the end of its block. */
#define FREED __attribute__((cleanup(check_free)))
static inline void check_free(void *pointer)
{
    void *p;
    memcpy(&p, pointer, sizeof p);
    free(p);
}

/* OWNS(lw_newton) once in the file, then OWNED(lw_newton) *s = NULL;  a pointer that lw_newton_free() frees in the same way. */
#define OWNED(type) __attribute__((cleanup(type##_owned))) type
#define OWNS(type) static inline void type##_owned(type **p) { type##_free(*p); }

/* CHECK_MAIN { ... }  the program's own order of work, with argc and argv; returns the exit code. */
#define CHECK_MAIN \
    static int check_own_main(int argc, char **argv); \
    static int (*check_main)(int argc, char **argv) = check_own_main; \
    static int check_own_main(int argc __attribute__((unused)), char **argv __attribute__((unused)))

static int (*check_main)(int argc, char **argv);          /* NULL unless CHECK_MAIN follows */
static int check_program_run(int argc, char **argv)
{
    if (check_main)
        return check_main(argc, argv);
    check_run();
    return check_end();
}
TEST_PROGRAM(check_program_run)

#endif
