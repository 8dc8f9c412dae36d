/* test_query.c - questions to a catalogue: what they become, what is refused and where. */
#include "catalogues/store/query.h"

#include "tests/check.h"

static const lw_query_options any = { .list = LW_LIST_ANY };

/* What comes behind WHERE, without the order at the end. */
static void becomes(const char *text, lw_query_list list, const char *where)
{
    OWN(lw_query) q = { 0 };
    lw_error e = { 0 };
    lw_status s = lw_query_compile(text, &any, &q, &e);
    if (s != LW_OK)
        fprintf(stderr, "%s: %s\n", text, e.text);
    CHECK_INT(s, LW_OK);
    if (s != LW_OK)
        return;
    CHECK_INT(q.list, list);
    char *at = strstr(q.sql.data, " WHERE "), *end = strstr(q.sql.data, " ORDER BY ");
    CHECK(at && end);
    if (at && end) {
        *end = 0;
        CHECK_TEXT(at + 7, where);
    }
}

static void refused(const char *text, long column, const char *why)
{
    OWN(lw_query) q = { 0 };
    lw_error e = { 0 };
    lw_status s = lw_query_compile(text, &any, &q, &e);
    CHECK(s == LW_E_NOTATION || s == LW_E_ARG);
    if (e.column != column)
        fprintf(stderr, "%s: %s\n", text, e.text);
    CHECK_INT(e.column, column);
    CHECK_HAS(e.text, why);
}

TEST(questions)
{
    becomes("links=6 and sliders>=1 and class=GCRR and error<0.01", LW_LIST_LINKAGES,
            "k.links = ?1 AND k.sliders >= ?2 AND k.class = ?3 AND k.error < ?4");
    becomes("links = 8..10 and not planar", LW_LIST_CHAINS, "c.links BETWEEN ?1 AND ?2 AND NOT c.planar");
    becomes("links=8..10 or symmetry>1", LW_LIST_CHAINS, "c.links BETWEEN ?1 AND ?2 OR c.symmetry > ?3");
    becomes("(links==6 or links <> 8) and inputs='1-2'", LW_LIST_MECHANISMS, "(c.links = ?1 OR c.links != ?2) AND m.inputs = ?3");
    becomes("class in (GCRR, \"GCCC\") AND name != none", LW_LIST_LINKAGES, "k.class IN (?1, ?2) AND k.name IS NOT NULL");
    becomes("name~Jan or name~\"J*n\"", LW_LIST_LINKAGES, "k.name GLOB ?1 OR k.name GLOB ?2");
    becomes("planar = yes and planar=0", LW_LIST_CHAINS, "c.planar = ?1 AND c.planar = ?2");
    becomes("not not (planar)", LW_LIST_CHAINS, "NOT NOT (c.planar)");
    becomes("objective=none", LW_LIST_LINKAGES, "k.objective IS NULL");
    becomes("sliders=0", LW_LIST_MECHANISMS, "m.sliders = ?1");
}

TEST(values)
{
    OWN(lw_query) q = { 0 };
    CHECK_OK(lw_query_compile("error_max<2mm and transmission_min>=30deg and error < 1e-3 and objective>-2.5", &any, &q, &check_error));
    CHECK_INT(q.n_value, 4);
    CHECK_NEAR(q.value[0].real, 0.002, 1e-18, 0);
    CHECK_NEAR(q.value[1].real, 0.523598775598298873, 1e-15, 0);
    CHECK_NEAR(q.value[2].real, 0.001, 0, 0);
    CHECK_NEAR(q.value[3].real, -2.5, 0, 0);
    lw_query_free(&q);
    CHECK_OK(lw_query_compile("name='; DROP TABLE chain --' and name~part and label=\"it's\"", &any, &q, &check_error));
    CHECK(strstr(q.sql.data, "DROP") == NULL);
    CHECK_INT(q.value[0].size, 21);
    CHECK(memcmp(q.value[0].text, "; DROP TABLE chain --", 21) == 0);
    CHECK(q.value[1].size == 6 && memcmp(q.value[1].text, "*part*", 6) == 0);
    CHECK(q.value[2].size == 4 && memcmp(q.value[2].text, "it's", 4) == 0);
}

TEST(lists_columns_order)
{
    OWN(lw_query) q = { 0 };
    lw_query_options o = { .list = LW_LIST_CHAINS, .columns = "graph6,links", .sort = "-links,symmetry", .limit = 7 };
    CHECK_OK(lw_query_compile("", &o, &q, &check_error));
    CHECK_TEXT(q.sql.data, "SELECT c.graph6 AS \"graph6\", c.links AS \"links\" FROM chain c LEFT JOIN structure s ON "
                           "s.id = c.structure ORDER BY c.links DESC, c.symmetry LIMIT 7");
    lw_query_free(&q);
    CHECK_FAILS(lw_query_compile("class=GCRR", &o, &q, &check_error), LW_E_ARG, "chains have no field 'class'");
    lw_query_free(&q);
    o = (lw_query_options){ .list = LW_LIST_ANY, .columns = "graph6,claas" };
    CHECK_FAILS(lw_query_compile("", &o, &q, &check_error), LW_E_NOTATION, "did you mean 'class'?");
    lw_query_free(&q);
    o.columns = "graph6,class";
    CHECK_OK(lw_query_compile("", &o, &q, &check_error));
    CHECK_INT(q.list, LW_LIST_LINKAGES);
    lw_query_free(&q);
    o = (lw_query_options){ .list = LW_LIST_ANY, .sort = "links,,id" };
    CHECK_INT(lw_query_compile("", &o, &q, &check_error), LW_E_NOTATION);
}

TEST(faults)
{
    char deep[200], many[2000] = "links in (1";
    refused("linx=6", 1, "did you mean 'links'?");
    refused("links", 6, "wants a value");
    refused("links=", 7, "a value is wanted here");
    refused("links=six", 7, "a number is wanted, not 'six'");
    refused("links=6 and", 12, "ends where a field should follow");
    refused("links=6 links=7", 9, "and, or, or the end");
    refused("(links=6", 1, "'(' has no ')'");
    refused("links=6)", 8, "closes nothing");
    refused("links 6", 7, "one of = !=");
    refused("name='abc", 6, "no quote at its end");
    refused("label=Gr`KAC", 9, "quotes");
    refused("planar=maybe", 8, "yes or no");
    refused("links~8", 6, "is for texts");
    refused("links=2mm", 8, "no unit");
    refused("error_max<2miles", 12, "no unit");
    refused("name='a'..'b'", 9, "between numbers");
    refused("links<4..8", 8, "comes after '='");
    refused("links in 4", 10, "comes '('");
    refused("links in (4 5)", 13, "',' or ')'");
    refused("error<none", 7, "goes with =");
    refused("inputs='1-2' and error<1", 0, "no list has all these fields");
    refused("6=links", 1, "a field is wanted, not '6'");
    refused("links=6 and #", 13, "means nothing");
    memset(deep, '(', 120);
    deep[120] = 0;
    refused(deep, 51, "50 parentheses");
    for (int i = 0; i < 70; i++)
        strcat(many, ",1");
    strcat(many, ")");
    refused(many, 139, "more than 64 values");
}

/* Whatever is typed, nothing that was not in the tables comes into the SQL. */
TEST(wild_text)
{
    static const char *const word[] = {
        "links", "planar", "name", "and", "or", "not", "(", ")", "=", "..", "<", ">=", "~", "4", "4..8", "'x'", "in",
        ",", "none", "-1e5", "2mm", "error", "\"", ";", "--", "class", "%", "?1"
    };
    lw_rng rng = check_rng(8);
    int n_good = 0;
    for (int trial = 0; trial < 60000; trial++) {
        char text[400] = "";
        OWN(lw_query) q = { 0 };
        for (int i = (int)lw_rng_range(&rng, 1, 9); i > 0; i--) {
            strcat(text, word[(size_t)lw_rng_range(&rng, 0, sizeof word/sizeof *word)]);
            strcat(text, lw_rng_uniform(&rng) < 0.7 ? " " : "");
        }
        if (lw_query_compile(text, &any, &q, &check_error) == LW_OK) {
            n_good++;
            CHECK(strpbrk(q.sql.data, ";'-%\001") == NULL || strstr(q.sql.data, "k.joints - k.links"));
        }
    }
    CHECK(n_good > 50);
}
