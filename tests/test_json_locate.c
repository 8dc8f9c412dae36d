/* Places in JSON texts: against values that are found by searching for them.  The reader: against jansson's own. */
#include <jansson.h>
#include "grammar/text/json_internal.h"
#include "grammar/text/json_locate_internal.h"
#include "tests/check.h"

static const char text[] =
    "\xef\xbb\xbf {\n"
    "  \"a\\\"{\" : [ 1 , -2.5e3,\"]},:\" , [ ] , { } , {\"deep\": [[ [\"bottom\"] ]]}, true ],\r\n"
    "\t\"b\":null,\"c\":{\"d\":\"\\\\\",\"e\":\"last\"}\n"
    "}";

static void check_way(int n, const size_t *index, bool key, const char *want)
{
    lw_json_path path = { .n = n };
    for (int i = 0; i < n; i++)
        path.index[i] = index[i];
    size_t at = lw_json_locate(text, sizeof text - 1, &path, key);
    CHECK_INT(at, strstr(text, want) - text);
}

#define WAY(...) (int)(sizeof (size_t[]){ __VA_ARGS__ }/sizeof(size_t)), (size_t[]){ __VA_ARGS__ }

TEST(values_and_keys)
{
    check_way(0, NULL, false, "{\n");
    check_way(WAY(0), false, "[ 1");
    check_way(WAY(0), true, "\"a\\\"{\"");
    check_way(WAY(0, 0), false, "1 ,");
    check_way(WAY(0, 1), false, "-2.5e3");
    check_way(WAY(0, 2), false, "\"]},:\"");
    check_way(WAY(0, 3), false, "[ ]");
    check_way(WAY(0, 4), false, "{ }");
    check_way(WAY(0, 5), false, "{\"deep\"");
    check_way(WAY(0, 5, 0), true, "\"deep\"");
    check_way(WAY(0, 5, 0, 0, 0, 0), false, "\"bottom\"");
    check_way(WAY(0, 6), false, "true");
    check_way(WAY(1), false, "null");
    check_way(WAY(2, 0), false, "\"\\\\\"");
    check_way(WAY(2, 1), true, "\"e\"");
    check_way(WAY(2, 1), false, "\"last\"");
}

TEST(ways_that_lead_nowhere)
{
    static const size_t wrong[][2] = { { 0, 7 }, { 3, 0 }, { 1, 0 }, { 2, 2 } };
    for (size_t i = 0; i < sizeof wrong/sizeof *wrong; i++) {
        lw_json_path path = { .n = 2, .index = { wrong[i][0], wrong[i][1] } };
        CHECK_INT(lw_json_locate(text, sizeof text - 1, &path, false), sizeof text - 1);
    }
}

/* Texts cut anywhere: any answer within the text, no step beyond it. */
TEST(cut_texts_are_harmless)
{
    for (size_t size = 0; size < sizeof text; size++) {
        FREED char *copy = malloc(size + 1);
        memcpy(copy, text, size);
        for (size_t i = 0; i < 4; i++)
            for (size_t j = 0; j < 8; j++) {
                lw_json_path path = { .n = 3, .index = { i, j, 0 } };
                CHECK(lw_json_locate(copy, size, &path, (i + j)%2 == 0) <= size);
            }
    }
}

TEST(lines_and_columns)
{
    static const struct { size_t offset; long line, column; } known[] = {
        { 0, 1, 1 }, { 1, 1, 2 }, { 2, 1, 3 }, { 3, 2, 1 }, { 4, 3, 1 }, { 6, 3, 3 }, { 99, 3, 3 } };
    for (size_t i = 0; i < sizeof known/sizeof *known - 1; i++) {
        long line, column;
        lw_text_place("ab\n\ncd", 6, known[i].offset, &line, &column);
        CHECK_INT(line, known[i].line);
        CHECK_INT(column, known[i].column);
    }
}

static void check_same_as_jansson(const char *one, size_t size, size_t flags)
{
    json_error_t fault, other;
    json_t *root, *want = json_loadb(one, size, flags, &other);
    lw_status s = lw_json_load(one, size, flags, &root, &fault);
    bool same = want ? s == LW_OK && json_equal(root, want) && fault.position == other.position : s == LW_E_NOTATION && !root && fault.text[0];
    if (!same)
        fprintf(stderr, "%.*s\n  %s | %s\n", (int)size, one, fault.text, other.text);
    CHECK(same);
    json_decref(root);
    json_decref(want);
}

/* Whole texts, and each of them with bytes changed, left out or cut off. */
TEST(read_as_jansson_does)
{
    static const char *const texts[] = { "[]", "{}", "[1,-0,0.5,-1.25e+3,1E-2,123456789012345678,0e0]", "[1e400]", "[99999999999999999999]", "[01]", "[-]", "[1.]",
        "[.5]", "[+1]", "[1e]", "[nul]", "[tru e]", "[NaN]", "[true,false,null]", "{\"a\":1,\"a\":2}", "{\"a\" : {\"a\":[[],{}]} , \"b\":\"\"}", "[1,]", "{\"a\":1,}",
        "{\"a\"}", "{1:2}", "\"a\"", "1", "", "  ", "[1] x", "[1]]", "[\"\\u00e4\\u20AC\\ud834\\udd1e\\\"\\\\\\/\\b\\f\\n\\r\\t\"]", "[\"\\ud834\"]", "[\"\\ud834\\u0041\"]",
        "[\"\\udd1e\"]", "[\"\\u0000\"]", "[\"\\x\"]", "[\"\\u12g4\"]", "[\"a\nb\"]", "[\"\xc3\xa4\xf0\x9f\x98\x80\x7f\"]", "[\"\xc0\xaf\"]", "[\"\xed\xa0\x80\"]",
        "[\"\xff\"]", "[\"a", "[\"a\\", "[\"a\\\"", text + 3 };
    static const size_t flags[] = { 0, JSON_REJECT_DUPLICATES, JSON_DISABLE_EOF_CHECK, JSON_DECODE_INT_AS_REAL };
    static const char bytes[] = "[]{}:,\"\\ 01-.eEtfnu\x80\xff";
    lw_rng rng = check_rng(0);
    for (size_t i = 0; i < 4*(sizeof texts/sizeof *texts); i++) {
        const char *whole = texts[i/4];
        size_t size = strlen(whole);
        check_same_as_jansson(whole, size, flags[i%4]);
        for (int k = 0; k < 30 && size > 0; k++) {
            char copy[300];
            size_t at = lw_rng_bits(&rng)%size, n = k%3 == 1 ? at : size;
            memcpy(copy, whole, size + 1);
            if (k%3 == 0)
                copy[at] = bytes[lw_rng_bits(&rng)%(sizeof bytes - 1)];
            else if (k%3 == 2)
                memmove(copy + at, copy + at + 1, n-- - at);
            check_same_as_jansson(copy, n, flags[i%4]);
        }
    }
}

static char *nested(int depth)
{
    char *deep = calloc(1, 2*(size_t)depth + 1);
    memset(deep, '[', (size_t)depth);
    memset(deep + depth, ']', (size_t)depth);
    return deep;
}

TEST(depth_is_bounded)
{
    for (int depth = 2047; depth < 2050; depth++) {
        FREED char *deep = nested(depth);
        check_same_as_jansson(deep, strlen(deep), 0);
    }
}
