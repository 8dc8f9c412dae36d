/* test_derivation.c - derivations as text: every one of up to six loops reads back and replays; faults have a column. */
#include <string.h>
#include "enumerate/structures.h"
#include "grammar/topology/derivation.h"
#include "tests/check.h"

TEST(all_read_back)
{
    lw_structures *set = NULL;
    CHECK_INT(lw_structures_create(6, 1, &set), LW_OK);
    for (int l = 2; l <= 6; l++)
        for (size_t k = 0; k < lw_structures_count(set, l); k++) {
            lw_derivation d, back;
            lw_structure s, again;
            char text[LW_DERIVATION_SIZE], structure[LW_STRUCTURE_SIZE];
            lw_structures_get(set, l, k, &s);
            lw_structures_derive(set, l, k, &d);
            size_t n = lw_derivation_print(&d, text, sizeof text);
            CHECK_INT(n, strlen(text));
            CHECK_INT(lw_derivation_read(text, n, NULL, &back, NULL), LW_OK);
            CHECK_INT(lw_derivation_replay(&back, &again), LW_OK);
            CHECK(lw_structure_same(&again, &s));
            CHECK_INT(lw_structure_print(&s, structure, sizeof structure), strlen(structure));
        }
    lw_structures_free(set);
}

TEST(known_texts)
{
    lw_derivation d;
    lw_structure s;
    char text[LW_STRUCTURE_SIZE];
    const char *line = "theta 3(1,2) 4(6)\r\n";
    CHECK_INT(lw_derivation_read(line, strlen(line), NULL, &d, NULL), LW_OK);
    CHECK_INT(lw_derivation_replay(&d, &s), LW_OK);
    lw_structure_print(&s, text, sizeof text);
    CHECK_TEXT(text, "(3 3 3 3 3 3) 1-2 1-3 1-4 2-3 2-4 3-5 4-6 5-6 5-6");
    CHECK_INT(lw_structure_print(&s, text, 4), 49);                        /* counts what did not fit */
    CHECK_TEXT(text, "(3 ");
}

TEST(faults_have_a_column)
{
    static const struct { const char *text; long column; const char *says; } bad[] = {
        { "", 1, "seed" }, { "beta 1(1,2)", 1, "seed" }, { "theta  1(1,2)", 7, "rule, 1 to 4" },
        { "theta 5(1,2)", 7, "rule, 1 to 4" }, { "theta 1[1,2]", 8, "'('" }, { "theta 1(1)", 10, "two numbers" },
        { "theta 1(2,1)", 7, "no such circles" }, { "theta 1(1,3)", 7, "no such circles" }, { "theta,", 6, "blank" },
        { "theta 4(1,2)", 10, "one line" }, { "theta 2(1,4)", 7, "no such" }, { "theta 1(999,1)", 14, "two numbers" } };
    for (size_t k = 0; k < sizeof bad/sizeof *bad; k++) {
        lw_derivation d;
        lw_error e = { 0 };
        CHECK_INT(lw_derivation_read(bad[k].text, strlen(bad[k].text), "f", &d, &e), LW_E_NOTATION);
        CHECK_INT(e.column, bad[k].column);
        CHECK_HAS(e.text, bad[k].says);
    }
    char line[400] = "theta";
    for (int k = 0; k < LW_LOOP_MAX - 1; k++)
        strcat(line, " 1(1,2)");
    lw_derivation d;
    lw_error e = { 0 };
    CHECK_INT(lw_derivation_read(line, strlen(line), "f", &d, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "too many");
}
