/* Places in JSON texts: against values that are found by searching for them. */
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
        char *copy = malloc(size + 1);
        memcpy(copy, text, size);
        for (size_t i = 0; i < 4; i++)
            for (size_t j = 0; j < 8; j++) {
                lw_json_path path = { .n = 3, .index = { i, j, 0 } };
                CHECK(lw_json_locate(copy, size, &path, (i + j)%2 == 0) <= size);
            }
        free(copy);
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
