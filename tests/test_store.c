/* test_store.c - the store from inside: whose file it is, versions, transactions, the lock, a person's SQL. */
#include "catalogues/store/store_internal.h"

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/file.h"
#include "tests/check.h"
#include "tests/temporary.h"

static lw_store *open_store(const char *name, bool write, lw_status want, lw_error *e)
{
    lw_store *s;
    lw_store_options o = { .write = write, .create = write, .command = "the test" };
    *e = (lw_error){ 0 };
    CHECK_INT(lw_store_open(temporary_file(name), &o, &s, e), want);
    CHECK((s != NULL) == (want == LW_OK));
    return s;
}

static void execute(const char *name, const char *sql)
{
    sqlite3 *db;
    char *message = NULL;
    CHECK_INT(sqlite3_open(temporary_file(name), &db), SQLITE_OK);
    CHECK_INT(sqlite3_exec(db, sql, NULL, NULL, &message), SQLITE_OK);
    if (message)
        fprintf(stderr, "%s\n", message);
    sqlite3_free(message);
    sqlite3_close(db);
}

static lw_store_chain four_bar(void)
{
    static const int n_with[5] = { 4 };
    static const uint8_t ground[] = { 1 }, alike[] = { 4 };
    static const lw_store_mechanism m = { 1, "rrrr", "1-2", "I1:2 II2:3,4", 0, 2, 2, 2 };
    return (lw_store_chain){ "C]", "Cl", "() :4", "((1 r 2 r 4 r 3 r) (1 r 3 r 4 r 2 r))", "0 1 2 0\n", 4, 1, 4, 1, 0,
                             n_with, "4", 8, true, 1, ground, alike, 1, &m, NULL, 0 };
}

static long long count(lw_store *s, const char *table)
{
    char sql[100];
    long long n = -1;
    snprintf(sql, sizeof sql, "SELECT count(*) FROM %s", table);
    CHECK_INT(lw_store_number(s, sql, NULL, 0, &n, NULL), LW_OK);
    return n;
}

static void put_four_bar(lw_store *s)
{
    uint64_t done;
    bool complete;
    lw_store_chain c = four_bar();
    lw_store_run r = { "build", "links 4", "the test", 1 };
    CHECK_OK(lw_store_begin(s, &check_error));
    CHECK_OK(lw_store_run_begin(s, &r, &check_error));
    CHECK_OK(lw_store_build_begin(s, 4, 1, "r", &done, &complete, &check_error));
    CHECK_OK(lw_store_put_chain(s, &c, &check_error));
    CHECK_OK(lw_store_put_chain(s, &c, &check_error));
    CHECK_OK(lw_store_build_done(s, 1, true, &check_error));
    CHECK_OK(lw_store_run_end(s, &check_error));
}

TEST(keeps_what_was_committed)
{
    lw_store *s = open_store("a.db", true, LW_OK, &check_error);
    put_four_bar(s);
    lw_store_rollback(s);
    CHECK_INT(count(s, "chain"), 0);
    put_four_bar(s);
    CHECK_OK(lw_store_commit(s, &check_error));
    CHECK_INT(count(s, "chain"), 1);
    CHECK_INT(count(s, "mechanism"), 1);
    lw_store_close(s);
    s = open_store("a.db", true, LW_OK, &check_error);
    put_four_bar(s);
    lw_store_close(s);                                      /* not committed: gone, the run too */
    s = open_store("a.db", false, LW_OK, &check_error);
    CHECK_INT(count(s, "chain"), 1);
    CHECK_INT(count(s, "run"), 1);
    CHECK_OK(lw_store_verify(s, &check_error));
    CHECK_INT(lw_store_begin(s, &check_error), LW_E_ARG);             /* a store to read cannot be written */
    CHECK_INT(lw_store_found_version(s), lw_store_step_count);
    lw_store_close(s);
    lw_store_close(NULL);
}

TEST(knows_whose_file_it_is)
{
    lw_error e;
    execute("other.db", "CREATE TABLE chain(a); INSERT INTO chain VALUES(1)");
    open_store("other.db", true, LW_E_NOTATION, &e);
    CHECK_HAS(e.text, "another program");
    open_store("other.db", false, LW_E_NOTATION, &e);
    execute("claimed.db", "PRAGMA application_id=0x12345678; PRAGMA user_version=1; CREATE TABLE t(a)");
    open_store("claimed.db", true, LW_E_NOTATION, &e);
    CHECK_HAS(e.text, "0x12345678");
    execute("newer.db", "PRAGMA application_id=0x6C776361; PRAGMA user_version=999; CREATE TABLE t(a)");
    open_store("newer.db", true, LW_E_NOTATION, &e);
    CHECK_HAS(e.text, "version 999");
    CHECK_HAS(e.text, "newer program");
    execute("none.db", "PRAGMA application_id=0x6C776361; CREATE TABLE t(a)");
    open_store("none.db", true, LW_E_NOTATION, &e);
    /* says it is ours, but its tables are not: told when they are used */
    char sql[100];
    snprintf(sql, sizeof sql, "PRAGMA application_id=0x6C776361; PRAGMA user_version=%d; CREATE TABLE t(a)", lw_store_step_count);
    execute("hollow.db", sql);
    lw_store *s = open_store("hollow.db", true, LW_OK, &e);
    CHECK_INT(lw_store_begin(s, &e), LW_OK);
    lw_store_run r = { "build", "links 4", "the test", 1 };
    CHECK_FAILS(lw_store_run_begin(s, &r, &check_error), LW_E_NOTATION, "no such table");
    lw_store_close(s);
    open_store("nothing.db", false, LW_E_IO, &e);
    CHECK_HAS(e.text, "no such file");
}

/* A file of schema version 1 (four and six links) becomes one of today, read or written, and loses nothing. */
TEST(older_files_are_brought_up_to_date)
{
    lw_error e;
    size_t size;
    char *sql = NULL;
    CHECK_INT(lw_file_read("tests/data/catalogue-version-1.sql", &sql, &size, &e), LW_OK);
    execute("v1.db", sql);
    execute("v1-too.db", sql);
    free(sql);
    lw_store *s = open_store("v1.db", true, LW_OK, &e);
    CHECK_INT(lw_store_found_version(s), 1);
    CHECK_INT(count(s, "chain"), 3);
    CHECK_INT(count(s, "mechanism"), 10);
    CHECK_INT(count(s, "linkage"), 0);
    CHECK_INT(lw_store_verify(s, &e), LW_OK);
    lw_store_close(s);
    s = open_store("v1.db", false, LW_OK, &e);
    CHECK_INT(lw_store_found_version(s), lw_store_step_count);
    lw_store_close(s);
    s = open_store("v1-too.db", false, LW_OK, &e);
    CHECK_INT(lw_store_found_version(s), 1);
    CHECK_INT(count(s, "linkage"), 0);
    lw_store_close(s);
    /* one that cannot be written stays as it is, and says so */
    CHECK_INT(lw_file_read("tests/data/catalogue-version-1.sql", &sql, &size, &e), LW_OK);
    execute("v1-only.db", sql);
    free(sql);
    CHECK_INT(chmod(temporary_file("v1-only.db"), 0444), 0);
    open_store("v1-only.db", false, LW_E_IO, &e);
    CHECK_HAS(e.text, "read-only");
    /* a step that fails leaves version 1 behind */
    CHECK_INT(chmod(temporary_file("v1-only.db"), 0644), 0);
    execute("v1-only.db", "CREATE TABLE sweep(in_the_way)");
    open_store("v1-only.db", true, LW_E_NOTATION, &e);
    CHECK_HAS(e.text, "brought up to date");
    execute("v1-only.db", "DROP TABLE sweep; CREATE TABLE is_version_1(a CHECK (a = 1))");
    execute("v1-only.db", "INSERT INTO is_version_1 SELECT user_version FROM pragma_user_version");
}

TEST(one_writes_at_a_time)
{
    lw_error e;
    struct stat st;
    lw_store *first = open_store("lock.db", true, LW_OK, &e);
    open_store("lock.db", true, LW_E_IO, &e);
    CHECK_HAS(e.text, "the test");
    char who[40];
    snprintf(who, sizeof who, "process %ld", (long)getpid());
    CHECK_HAS(e.text, who);
    lw_store *reader = open_store("lock.db", false, LW_OK, &e);
    CHECK_INT(count(reader, "chain"), 0);
    lw_store_close(reader);
    lw_store_close(first);
    CHECK(stat(temporary_file("lock.db-lock"), &st) != 0);
    /* what a killed program left behind does not lock */
    FILE *f = fopen(temporary_file("lock.db-lock"), "w");
    fputs("process 1 (dead)\n", f);
    fclose(f);
    lw_store_close(open_store("lock.db", true, LW_OK, &e));
}

static lw_status take_row(void *context, int n_column, const char *const *name, const lw_value *value)
{
    (void)n_column, (void)name, (void)value;
    ++*(int *)context;
    return LW_OK;
}

static bool never(void *context) { (void)context; return false; }

static lw_status check_names(void *context, int n_column, const char *const *name, const lw_value *value)
{
    (void)context, (void)value;
    CHECK_INT(n_column, 2);
    CHECK_TEXT(name[0], "label");
    CHECK_TEXT(name[1], "number_of_links");
    return LW_OK;
}

/* SQLite compiles a statement anew when a pattern is bound to GLOB: the names must be those of the new one. */
TEST(names_of_columns)
{
    lw_value pattern = { .kind = LW_VALUE_TEXT, .text = "*", .size = 1 };
    lw_store *s = open_store("a.db", false, LW_OK, &check_error);
    lw_store_query q = { .sql = "SELECT label, links AS number_of_links FROM chain WHERE label GLOB ?1",
                         .value = &pattern, .n_value = 1, .row = check_names };
    CHECK_OK(lw_store_ask(s, &q, &check_error));
    lw_store_close(s);
}

TEST(a_persons_sql_only_reads)
{
    static const char *const bad[] = {
        "DELETE FROM chain", "UPDATE chain SET links = 5", "DROP TABLE chain", "ATTACH '/etc/passwd' AS x",
        "PRAGMA user_version=7", "PRAGMA writable_schema=1", "INSERT INTO chain SELECT * FROM chain", "VACUUM",
        "BEGIN EXCLUSIVE", "SELECT 1; DROP TABLE chain", "CREATE TEMP TABLE t(a)", "", "   ", "--", "CREATE TABLE x(a)",
        "SELECT load_extension('/tmp/x.so')", "WITH x(a) AS (SELECT 1) DELETE FROM chain", "REINDEX", "ANALYZE",
        "SELECT fts3_tokenizer('x')",
    };
    lw_error e;
    int n = 0;
    lw_store *s = open_store("a.db", false, LW_OK, &e);
    lw_store_query q = { .foreign = true, .row = take_row, .context = &n };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        q.sql = bad[i];
        CHECK(lw_store_ask(s, &q, &e) < 0);
    }
    CHECK_INT(n, 0);
    q.sql = "SELECT * FROM chain JOIN mechanism ON mechanism.chain = chain.id;  ";
    CHECK_INT(lw_store_ask(s, &q, &e), LW_OK);
    CHECK_INT(n, 1);
    q.sql = "SELECT linx FROM chain";
    CHECK_INT(lw_store_ask(s, &q, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "linx");
    CHECK_INT(e.column, 8);
    q.sql = "WITH RECURSIVE x(a) AS (SELECT 1 UNION ALL SELECT a + 1 FROM x) SELECT count(*) FROM x";
    q.goes_on = never;
    CHECK_INT(lw_store_ask(s, &q, &e), LW_STOPPED);
    lw_store_close(s);
}
