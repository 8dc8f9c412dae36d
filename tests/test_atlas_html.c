/* The web pages of a catalogue: every file there, every link in them leads somewhere, every policy names what stands
 * in the page, nothing a hostile catalogue holds becomes HTML; sizes.  How they behave in a browser:
 * tests/browser/, on the pages that this test leaves in LW_ATLAS_FOLDER when that is set. */
#include <dirent.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "catalogues/build/build.h"
#include "catalogues/pages/atlas_html.h"
#include "catalogues/store/sha256.h"
#include "grammar/topology/graph6.h"
#include "tests/all_chains.h"
#include "tests/check.h"
#include "tests/temporary.h"

static const char hostile[] = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&";

/* ---- a catalogue -------------------------------------------------------------------------------- */

static void put_chain(lw_store *s, const lw_chain *c, int loops, const char *evil)
{
    char graph6[LW_GRAPH6_SIZE];
    int n_with[LW_LINK_MAX];
    uint8_t ground[LW_LINK_MAX], alike[LW_LINK_MAX];
    lw_store_mechanism m[2] = { { .kinds = "rrrr", .inputs = evil ? evil : "1-2", .groups = "I1:2 II2:3,4", .n_group = 2,
                             .highest = 2, .modes = 2, .ground = 1 } };
    m[1] = m[0];
    m[1].kinds = "rrrt";
    m[1].n_slider = 1;
    lw_graph6_print(c, graph6, sizeof graph6);
    lw_chain_assortment(c, n_with);
    for (int i = 0; i < c->n_link; i++) {
        ground[i] = (uint8_t)(i + 1);
        alike[i] = 1;
    }
    lw_store_chain row = {
        .label = graph6, .graph6 = graph6, .franke = evil ? evil : "franke", .sentence = evil ? evil : "sentence",
        .matrix = "0 1\n0 0", .links = c->n_link, .dof = lw_chain_mobility(c), .joints = lw_chain_count(c, 1),
        .loops = loops, .n_with = n_with + 2, .assortment = evil ? evil : "4 4", .symmetry = 2, .planar = true,
        .n_ground = c->n_link, .ground = ground, .alike = alike, .n_mechanism = c->n_link == 4 ? 2 : 1, .mechanism = m,
    };
    CHECK_OK(lw_store_put_chain(s, &row, &check_error));
}

static lw_store *open_store(bool write)
{
    lw_store_options o = { .write = write, .create = write, .wait = 1, .command = "test" };
    lw_store *s = NULL;
    CHECK_OK(lw_store_open(temporary_file("a.db"), &o, &s, &check_error));
    return s;
}

static void make_store(void)
{
    lw_store *s = open_store(true);
    lw_store_run run = { "build", "test", "test", 1 };
    CHECK_OK(lw_store_begin(s, &check_error));
    CHECK_OK(lw_store_run_begin(s, &run, &check_error));
    for (int links = 4; links <= 8; links += 2) {
        chain_list list = all_chains(links, 1);
        for (int i = 0; i < list.n; i++)
            put_chain(s, &list.chain[i], (links - 2)/2, links == 6 && i == 0 ? hostile : NULL);
        free(list.chain);
    }
    CHECK_OK(lw_store_run_end(s, &check_error));
    CHECK_OK(lw_store_commit(s, &check_error));
    lw_build_counts counts;
    CHECK_OK(lw_build_multiple(s, 6, 1, &(lw_build_control){ .jobs = 1 }, &counts, &check_error));
    CHECK_INT(counts.done, 2);
    lw_store_close(s);
}

/* Linkages: two of the four-bar chain, one of a chain that is not there. */
static void put_linkages(void)
{
    static const char sql[] =
        "INSERT INTO linkage(hash, name, links, dof, joints, sliders, kinds, label, type, class, error_mean, json, run)"
        " SELECT ?1, ?2, 4, 1, 4, 0, 'rrrr', CASE WHEN ?3 THEN label END, ?2, ?2, ?4, ?5, 1 FROM chain WHERE links = 4";
    static const struct { const char *file, *name; bool known; } row[] = {
        { "examples/hoeken.json", "Hoeken", true }, { "examples/hoeken.json", hostile, true },
        { "examples/jansen.json", "Jansen", false } };
    sqlite3 *db;
    CHECK_INT(sqlite3_open(temporary_file("a.db"), &db), SQLITE_OK);
    char *evil = sqlite3_mprintf("UPDATE multiple SET assortment = %Q WHERE id = 1", hostile);
    CHECK_INT(sqlite3_exec(db, evil, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_free(evil);
    for (int i = 0; i < 3; i++) {
        char *json = NULL, hash[12];
        size_t size;
        sqlite3_stmt *t;
        snprintf(hash, sizeof hash, "%d", i);
        CHECK_INT(lw_file_read(row[i].file, &json, &size, NULL), LW_OK);
        CHECK_INT(sqlite3_prepare_v2(db, sql, -1, &t, NULL), SQLITE_OK);
        sqlite3_bind_text(t, 1, hash, -1, SQLITE_STATIC);
        sqlite3_bind_text(t, 2, row[i].name, -1, SQLITE_STATIC);
        sqlite3_bind_int(t, 3, row[i].known);
        if (i != 1)
            sqlite3_bind_double(t, 4, 0.001*(i + 1));
        sqlite3_bind_text(t, 5, json, -1, SQLITE_STATIC);
        CHECK_INT(sqlite3_step(t), SQLITE_DONE);
        sqlite3_finalize(t);
        free(json);
    }
    sqlite3_close(db);
}

/* ---- looking at pages --------------------------------------------------------------------------- */

static char *read_page(const char *file)
{
    char *text = NULL, name[256];
    size_t size;
    snprintf(name, sizeof name, "atlas/%s", file);
    CHECK_INT(lw_file_read(temporary_file(name), &text, &size, NULL), LW_OK);
    return text ? text : calloc(1, 1);
}

/* The hash of what stands between two tags is in the policy. */
static void check_hash(const char *page, const char *open, const char *close)
{
    const char *from = strstr(page, open), *to = from ? strstr(from + strlen(open), close) : NULL;
    char hash[LW_SHA256_TEXT + 16] = "sha256-";
    CHECK(from && to);
    if (!from || !to)
        return;
    from += strlen(open);
    lw_sha256_base64(from, (size_t)(to - from), hash + 7);
    const char *policy = strstr(page, "Content-Security-Policy"), *end = policy ? strchr(policy, '>') : NULL;
    const char *found = policy ? strstr(policy, hash) : NULL;
    CHECK(found && found < end);
}

static void check_links(const char *page)
{
    for (const char *at = page; (at = strstr(at, "href=\"")) != NULL;) {
        char file[256] = "atlas/";
        at += 6;
        size_t n = strcspn(at, "\"#");
        CHECK(n < 200);
        snprintf(file + 6, sizeof file - 6, "%.*s", (int)n, at);
        CHECK(n == 0 || access(temporary_file(file), R_OK) == 0);
    }
}

static int count(const char *text, const char *part)
{
    int n = 0;
    for (; (text = strstr(text, part)) != NULL; text += strlen(part))
        n++;
    return n;
}

static void check_page(const char *file)
{
    FREED char *page = read_page(file);
    CHECK_HAS(page, "default-src 'none'");
    CHECK(!strstr(page, "unsafe"));
    CHECK(!strstr(page, "alert(1)</script>") && !strstr(page, "<img"));
    CHECK_INT(count(page, "<script>"), 1);
    CHECK_INT(count(page, "<style>"), 1);
    CHECK(!strstr(page, " style=\"") && !strstr(page, " onclick") && !strstr(page, "javascript:"));
    check_hash(page, "<style>", "</style>");
    check_hash(page, "<script>", "</script>");
    check_links(page);
}

/* ---- tests -------------------------------------------------------------------------------------- */

static lw_status write_atlas(const char *dir, const lw_atlas_html_options *o, size_t *n_page, size_t *n_byte, lw_error *e)
{
    lw_store *s = open_store(false);
    lw_status st = lw_atlas_html_write(s, dir, o, n_page, n_byte, e);
    lw_store_close(s);
    return st;
}

TEST(pages)
{
    lw_atlas_html_options o = lw_atlas_html_options_default();
    size_t n_page, n_byte, size = 0;
    int n = 0;
    o.title = hostile;
    CHECK_OK(write_atlas(temporary_file("atlas"), &o, &n_page, &n_byte, &check_error));
    CHECK_INT(n_page, 1 + 1 + 2 + 16 + 2 + 1 + 2);     /* the last: the slider-crank, multiple joints */
    DIR *d = opendir(temporary_file("atlas"));
    for (struct dirent *f; d && (f = readdir(d)) != NULL;) {
        struct stat st;
        char name[300];
        if (f->d_name[0] == '.')
            continue;
        snprintf(name, sizeof name, "atlas/%s", f->d_name);
        CHECK(stat(temporary_file(name), &st) == 0);
        size += (size_t)st.st_size;
        check_page(f->d_name);
        n++;
    }
    if (d)
        closedir(d);
    CHECK_INT(n, n_page);
    CHECK_INT(size, n_byte);
    CHECK(n_byte/n_page < 70000);                /* 230 chains of ten links and these: under 20 MB */
}

TEST(what_a_page_holds)
{
    char *page = read_page("chain-8-1-5.html");
    CHECK_HAS(page, "<h1>Chain 5 of 16: 8 links, F = 1</h1>");
    CHECK_HAS(page, "href=\"chain-8-1-4.html\"");
    CHECK_HAS(page, "href=\"chain-8-1-6.html\"");
    CHECK_INT(count(page, "<svg"), 1 + 8);
    CHECK_INT(count(page, "class=\"copy\""), 6);
    CHECK_HAS(page, "I1:2 II2:3,4");
    free(page);
    page = read_page("chain-6-1-1.html");
    CHECK_HAS(page, "&lt;/script&gt;&lt;script&gt;alert(1)");
    free(page);
    page = read_page("chain-4-1-1.html");
    CHECK_HAS(page, "<a href=\"linkages-4-1-1.html\">2 linkages, moving</a>");
    free(page);
    page = read_page("linkages-4-1-1.html");
    CHECK_INT(count(page, "<figure"), 2);
    CHECK_HAS(page, "href=\"chain-4-1-1.html\"");
    CHECK(strstr(page, ">Hoeken<") < strstr(page, "&lt;/script&gt;"));            /* those with an error first */
    free(page);
    page = read_page("index.html");
    CHECK_HAS(page, "href=\"linkages-other.html\">1 linkage of another chain<");
    CHECK_INT(count(page, "class=\"number\" data-label=\"Chains\""), 4);
    CHECK_HAS(page, "\\u003c/script\\u003e");
    CHECK_HAS(page, ">16</td>");
    CHECK_HAS(page, "21 kinematic chains, 2 of them with multiple joints");
    free(page);
    page = read_page("chain-6-1-m2.html");                           /* three dyads on two pins */
    CHECK_HAS(page, "<h1>Chain 2 of 2: 6 links, F = 1, multiple joints</h1>");
    CHECK_HAS(page, "<code>3-4-6 1-2-5 5-6 2-4 1-3</code>");
    CHECK_INT(count(page, "class=\"copy\""), 1);
    CHECK_INT(count(page, "<svg"), 1 + 1);                           /* all links are alike */
    free(page);
}

/* The first chains alone; what is expected before is what is written, but for the overview and linkages. */
TEST(first_chains)
{
    lw_atlas_html_options o = lw_atlas_html_options_default();
    size_t n_page, n_byte, n_chain = 0;
    double bytes = 0;
    lw_store *s = open_store(false);
    CHECK_OK(lw_atlas_html_expect(s, &o, &n_chain, &bytes, &check_error));
    CHECK_INT(n_chain, 21);
    o.links = 8;
    o.limit = 5;
    CHECK_OK(lw_atlas_html_expect(s, &o, &n_chain, &bytes, &check_error));
    CHECK_INT(n_chain, 5);
    lw_store_close(s);
    CHECK_OK(write_atlas(temporary_file("five"), &o, &n_page, &n_byte, &check_error));
    CHECK(n_page >= 6 && n_page <= 7 && access(temporary_file("five/chain-8-1-5.html"), F_OK) == 0);
    CHECK(access(temporary_file("five/chain-8-1-6.html"), F_OK) != 0);
    CHECK_NEAR((double)n_byte, bytes, 40000, 0.25);
}

static bool after_three(void *context, double done, double total)
{
    CHECK(total == 21 && !context);
    return done < 3;
}

/* Families of more chains than single_pages: blocks that nothing hostile leaves, one page for all of them. */
TEST(large_families)
{
    lw_atlas_html_options o = lw_atlas_html_options_default();
    size_t n_page, n_byte, size;
    char *text = NULL;
    o.single_pages = 1;
    CHECK_OK(write_atlas(temporary_file("blocks"), &o, &n_page, &n_byte, &check_error));
    CHECK_INT(n_page, 1 + 2 + 2 + 1 + 3);     /* overview, four-bar and its sliders, linkages, chain.html, three blocks */
    CHECK(access(temporary_file("blocks/chain-4-1-1.html"), F_OK) == 0);
    CHECK(access(temporary_file("blocks/chain-6-1-1.html"), F_OK) != 0);
    for (int i = 0; i < 5; i++) {
        static const char *const file[] = { "blocks/index.html", "blocks/chain.html", "blocks/chain-4-1-1.html",
                                            "blocks/chains-6-1-0.js", "blocks/chains-6-1-m0.js" };
        CHECK_INT(lw_file_read(temporary_file(file[i]), &text, &size, NULL), LW_OK);
        if (i < 3)
            CHECK((strstr(text, "' 'self'\">") != NULL) == (i < 2));
        else
            CHECK(strstr(text, i < 4 ? "atlasBlocks.take(\"6-1-0\",2,[\n" : "atlasBlocks.take(\"6-1-m0\",2,[\n") && !strchr(text, '<'));
        free(text);
    }
}

TEST(limits_and_faults)
{
    lw_atlas_html_options o = lw_atlas_html_options_default();
    size_t n_page, n_byte;
    o.n_linkage = 1;
    o.links = 4;
    CHECK_OK(write_atlas(temporary_file("four"), &o, &n_page, &n_byte, &check_error));
    CHECK_INT(n_page, 5);
    o.n_linkage = 0;
    o.links = 6;
    CHECK_OK(write_atlas(temporary_file("six"), &o, &n_page, &n_byte, &check_error));
    CHECK_INT(n_page, 5);
    o.links = 7;
    CHECK_FAILS(write_atlas(temporary_file("seven"), &o, &n_page, &n_byte, &check_error), LW_NOTHING, "no chain");
    o.links = 0;
    o.goes_on = after_three;
    CHECK_INT(write_atlas(temporary_file("three"), &o, &n_page, &n_byte, &check_error), LW_STOPPED);
    CHECK_INT(n_page, 4);                               /* three chains, one with sliders */
    CHECK(access(temporary_file("three/index.html"), F_OK) != 0);
    o.goes_on = NULL;
    CHECK_FAILS(write_atlas(temporary_file("none/deep"), &o, &n_page, &n_byte, &check_error), LW_E_IO, "cannot be made");
    CHECK_INT(write_atlas(temporary_file("a.db"), &o, &n_page, &n_byte, &check_error), LW_E_IO);
}

CHECK_MAIN
{
    char line[500];
    make_store();
    put_linkages();
    check_run();
    const char *keep = getenv("LW_ATLAS_FOLDER");
    snprintf(line, sizeof line, "cp -r %s/atlas '%.200s'; cp -r %s/blocks '%.200s-blocks'", temporary_folder(),
             keep ? keep : "", temporary_folder(), keep ? keep : "");
    if (keep && system(line) != 0)
        perror(keep);
    return check_end();
}
