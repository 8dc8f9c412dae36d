/* test_release.c - the data set of chains, mechanisms and Assur groups: the same bytes again, sums as other programs read
 * them, counts as published, no chain twice, and a stopped call that goes on. */
#include "catalogues/build/release.h"

#include <sys/stat.h>
#include <unistd.h>
#include "base/file.h"
#include "enumerate/canon.h"
#include "grammar/topology/graph6.h"
#include "tests/check.h"
#include "tests/temporary.h"

static const lw_release_size small = { .chains = 9, .mechanisms = 8, .groups = 8 };

static const char *at(const char *folder, const char *name)
{
    static char path[2][600];
    static int turn;
    turn = !turn;
    snprintf(path[turn], sizeof path[turn], "%s/%s/%s", temporary_folder(), folder, name);
    return path[turn];
}

static char *read_whole(const char *folder, const char *name, size_t *size)
{
    char *text = NULL;
    CHECK_OK(lw_file_read(at(folder, name), &text, size, &check_error));
    return text;
}

static lw_status write_to(const char *folder, const lw_build_control *control)
{
    char path[600];
    lw_error e = { 0 };
    snprintf(path, sizeof path, "%s/%s", temporary_folder(), folder);
    mkdir(path, 0777);
    lw_status s = lw_release_write(path, &small, control, &e);
    if (s != LW_OK && s != LW_STOPPED)
        fprintf(stderr, "%s\n", e.text);
    return s;
}

static bool shell(const char *format, const char *folder)
{
    char line[800], path[600];
    snprintf(path, sizeof path, "%s/%s", temporary_folder(), folder);
    snprintf(line, sizeof line, format, path);
    return system(line) == 0;
}

static bool stop_late(void *context, double done, double total)
{
    (void)total;
    return done < *(double *)context;
}

/* One thread and a commit for each chain; two threads and one commit; and a call that is stopped several times. */
TEST(same_bytes)
{
    double most[] = { 3, 60, 250, 1e9 };
    CHECK_INT(write_to("one", &(lw_build_control){ .jobs = 1, .commit = 0, .command = "test" }), LW_OK);
    CHECK_INT(write_to("two", &(lw_build_control){ .jobs = 2, .commit = 100, .command = "test" }), LW_OK);
    for (size_t i = 0; i < sizeof most/sizeof *most; i++) {
        lw_build_control control = { .jobs = 2, .command = "test", .goes_on = stop_late, .context = &most[i] };
        bool last = i + 1 == sizeof most/sizeof *most;
        CHECK_INT(write_to("three", &control), last ? LW_OK : LW_STOPPED);
        CHECK((access(at("three", "SHA256SUMS"), F_OK) == 0) == last);
    }
    CHECK(shell("cd %s && cd .. && diff -r one two && diff -r one three", "one"));
    CHECK(shell("cd %s && sha256sum -c --quiet SHA256SUMS && test $(find . -type f | wc -l) = $(($(wc -l < SHA256SUMS) + 1))", "one"));
}

/* The sums of the lists are those kept in the tree, which were written once and must never change. */
TEST(same_as_kept)
{
    size_t n, m;
    char *sums = read_whole("one", "SHA256SUMS", &n), *kept = NULL;
    CHECK_OK(lw_file_read("tests/data/release-9.sha256", &kept, &m, &check_error));
    int lines = 0;
    for (char *line = kept ? strtok(kept, "\n") : NULL; line; line = strtok(NULL, "\n"), lines++)
        CHECK_HAS(sums, line);
    CHECK_INT(lines, 29);
    free(sums);
    free(kept);
}

/* Published: OEIS A233288 and the table of counts of this tree (catalogues/data); Assur groups 1, 2, 10, 173
 * (Peisakh 1985; Yan & Hwang).  Every chain has the freedoms of its file, and no two are isomorphic. */
TEST(right_counts)
{
    static const struct { const char *file; int links, dof, n; } known[] = {
        { "chains/links-04-dof-1.g6", 4, 1, 1 },   { "chains/links-06-dof-1.g6", 6, 1, 2 },
        { "chains/links-08-dof-1.g6", 8, 1, 16 },  { "chains/links-07-dof-2.g6", 7, 2, 3 },
        { "chains/links-09-dof-2.g6", 9, 2, 35 },  { "chains/links-08-dof-3.g6", 8, 3, 5 },
        { "chains/links-09-dof-0.g6", 9, 0, 28 },  { "chains/links-07-dof-0.g6", 7, 0, 3 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        static lw_chain seen[64];
        size_t size;
        int n = 0;
        FREED char *text = read_whole("one", known[i].file, &size);
        for (char *line = text ? strtok(text, "\n") : NULL; line && n < 64; line = strtok(NULL, "\n"), n++) {
            lw_chain c;
            CHECK_INT(lw_graph6_read(line, strlen(line), NULL, &c, NULL), LW_OK);
            CHECK_INT(c.n_link, known[i].links);
            CHECK_INT(3*(c.n_link - 1) - 2*lw_chain_count(&c, 1), known[i].dof);
            CHECK_INT(lw_chain_canonical(&c, &seen[n]), LW_OK);
            for (int k = 0; k < n; k++)
                CHECK(memcmp(&seen[k], &seen[n], sizeof seen[n]) != 0);
        }
        CHECK_INT(n, known[i].n);
    }
    size_t size;
    FREED char *counts = read_whole("one", "counts.csv", &size);
    CHECK_HAS(counts, "mechanisms,6,1,5,");
    CHECK_HAS(counts, "mechanisms,8,1,71,");
    CHECK_HAS(counts, "mechanisms,7,2,11,");
    CHECK_HAS(counts, "assur-groups,2,0,1,");
    CHECK_HAS(counts, "assur-groups,4,0,2,");
    CHECK_HAS(counts, "assur-groups,6,0,10,");
    CHECK_HAS(counts, "assur-groups,8,0,173,");
}

TEST(bad_sizes)
{
    static const lw_release_size bad[] = { { 2, 3, 2 }, { 6, 7, 4 }, { 6, 4, 0 }, { 6, 2, 4 }, { 99, 5, 4 } };
    lw_error e;
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++)
        CHECK_INT(lw_release_write(temporary_folder(), &bad[i], &(lw_build_control){ 0 }, &e), LW_E_ARG);
    CHECK_INT(lw_release_write("/dev/null/at/all", &small, &(lw_build_control){ 0 }, &e), LW_E_IO);
}
