/* The table of published counts: reading it, faults in it, and a recount of every row of up to 13 links. */
#include "check.h"
#include "base/file.h"
#include "enumerate/published.h"

#define HEADER "family,dof,links,loops,what,count,source,verified_by\n"

static lw_published_table read_table(void)
{
    lw_published_table t = { 0 };
    FREED char *text = NULL;
    size_t size = 0;
    CHECK_OK(lw_file_read("catalogues/data/published-counts.csv", &text, &size, &check_error));
    CHECK_SILENT(lw_published_read(text, size, NULL, &t, &check_error));
    return t;
}

TEST(every_quick_row)
{
    lw_published_table t = read_table();
    lw_recount *r = lw_recount_create(1, NULL, NULL);
    int n[LW_NOT_COUNTED + 1] = { 0 };
    CHECK(r != NULL && t.n > 200);
    for (size_t i = 0; i < t.n; i++) {
        lw_recount_result result;
        if (t.row[i].links > 13)
            continue;
        CHECK_INT(lw_recount_row(r, &t.row[i], 1e9, &result), LW_OK);
        n[result.verdict]++;
        if (result.verdict == LW_DISAGREES || (result.verdict == LW_NOT_COUNTED && t.row[i].family[0] != 'p')) {
            fprintf(stderr, "line %ld: %s, %s: %lld\n", t.row[i].line, t.row[i].family, t.row[i].what, result.counted);
            CHECK(0);
        }
    }
    CHECK(n[LW_AGREES] > 215);
    CHECK_INT(n[LW_ERRATUM], 1);                       /* 6855 twelve-link chains */
    CHECK_INT(n[LW_NOT_COUNTED], 8);                   /* planetary gear trains */
    lw_recount_free(r);
    lw_published_free(&t);
}

/* May the count go on?  So many times. */
static bool some_times(void *context)
{
    return (*(long *)context)-- > 0;
}

/* A count that is given up, at any point, gives no number, and the same table counts rightly afterwards. */
TEST(counts_that_are_given_up)
{
    static const char rows[] = HEADER
        "simple-joint,2,9,3,all chains,40,s,x\n" "contracted graph,,,5,total,118,s,x\n" "multiple-joint,1,6,2,chains with at least one multiple joint,2,s,x\n"
        "lower+higher pairs,1,5,,chains with 9 higher pairs,1,s,x\n" "R/P labelled,1,6,2,valid labelled chains with 3 P joints,19,s,x\n";
    lw_published_table t;
    CHECK_OK(lw_published_read(rows, strlen(rows), NULL, &t, &check_error));
    for (size_t i = 0; i < t.n; i++) {
        lw_recount_result result = { .verdict = LW_TOO_LONG };
        long n_given_up = 0;
        for (long n = 0; result.verdict == LW_TOO_LONG; n = 2*n + 1) {
            long left = n;
            lw_recount *r = lw_recount_create(1, some_times, &left);
            CHECK_INT(lw_recount_row(r, &t.row[i], 1e9, &result), LW_OK);
            n_given_up += result.verdict == LW_TOO_LONG;
            left = 1000000;
            lw_recount_result again;
            CHECK_INT(lw_recount_row(r, &t.row[i], 1e9, &again), LW_OK);
            CHECK_INT(again.verdict, LW_AGREES);
            lw_recount_free(r);
        }
        CHECK(n_given_up > 0);
        CHECK_INT(result.verdict, LW_AGREES);
    }
    lw_published_free(&t);
}

TEST(limits_and_faults)
{
    static const char rows[] = HEADER
        "simple-joint,1,18,8,nonfractionated chains,1535380884,\"a \"\"source\"\", quoted\",x\r\n\n"
        "simple-joint,1,8,3,nonfractionated chains,17,s,x\n"
        "simple-joint,1,8,3,nonfractionated chains,17,s,refuted: it is 16\n"
        "simple-joint,1,8,3,something else,17,s,x\n";
    static const struct { double seconds; lw_verdict verdict; } known[] = {
        { 1e-9, LW_TOO_LONG }, { 1e9, LW_DISAGREES }, { 1e9, LW_ERRATUM }, { 1e9, LW_NOT_COUNTED } };
    lw_published_table t;
    lw_recount *r = lw_recount_create(1, NULL, NULL);
    lw_error e = { 0 };
    CHECK_INT(lw_published_read(rows, strlen(rows), NULL, &t, &e), LW_OK);
    CHECK_INT(t.n, 4);
    CHECK_TEXT(t.row[0].source, "a \"source\", quoted");
    CHECK_INT(t.row[1].line, 4);
    for (size_t i = 0; i < t.n; i++) {
        lw_recount_result result;
        CHECK_INT(lw_recount_row(r, &t.row[i], known[i].seconds, &result), LW_OK);
        CHECK_INT(result.verdict, known[i].verdict);
        if (i == 0)
            CHECK(result.seconds > 1e-9);
    }
    lw_published_free(&t);
    lw_recount_free(r);
    static const struct { const char *text; long line; const char *part; } faults[] = {
        { "a,b\n", 1, "header" }, { HEADER "x,1,2\n", 2, "3 fields" }, { HEADER "x,1,2,3,w,many,s,v\n", 2, "'many'" },
        { HEADER "\nx,one,2,3,w,1,s,v\n", 3, "small numbers" }, { "", 1, "header" },
    };
    for (size_t i = 0; i < sizeof faults/sizeof *faults; i++) {
        CHECK_INT(lw_published_read(faults[i].text, strlen(faults[i].text), "f", &t, &e), LW_E_NOTATION);
        CHECK_INT(e.line, faults[i].line);
        CHECK_HAS(e.text, faults[i].part);
    }
}
