#include "check.h"
#include "grammar/topology/mechanism_json.h"
#include "topology.h"

TEST(reads_back)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 500; trial++) {
        lw_mechanism m = random_topology(&rng, 1 + trial % 32, trial % 50, "rtpg"), back;
        char text[LW_MECHANISM_JSON_SIZE];
        m.ground = trial % 3 ? trial % m.n_link : LW_NONE;
        m.output = trial % 2 ? (trial + 1) % m.n_link : LW_NONE;
        for (int j = 0; j < m.n_joint && m.n_input < trial % 9; j++)
            if (lw_joint_freedoms(m.kind[j]) == 1)
                m.input[m.n_input++] = (uint8_t)j;
        size_t n = lw_mechanism_write(&m, text, sizeof text);
        CHECK(n < sizeof text);
        CHECK_INT(lw_mechanism_read(text, n, NULL, &back, NULL), LW_OK);
        CHECK(lw_mechanism_same(&m, &back));
    }
}

TEST(as_documented)
{
    static const char text[] = "{\"linkwright\": 1, \"links\": 4, \"joints\": [[1, 2, \"r\"], [1, 4, \"r\"], "
        "[2, 3, \"r\"], [3, 4, \"t\"]], \"ground\": 1, \"inputs\": [[1, 2]], \"output\": 3}";
    static const char loose[] = "{\"output\":3,\"inputs\":[[2,1]],\"ground\":1,\n\"joints\":[[4,3,\"t\"],"
        "[2,3],[4,1],[1,2]],\"links\":4, \"x-note\":\"mine\"}";
    lw_mechanism m, other;
    char out[LW_MECHANISM_JSON_SIZE];
    CHECK_INT(lw_mechanism_read(text, strlen(text), NULL, &m, NULL), LW_OK);
    CHECK_INT(lw_mechanism_read(loose, strlen(loose), NULL, &other, NULL), LW_OK);
    CHECK(lw_mechanism_same(&m, &other));
    lw_mechanism_write(&m, out, sizeof out);
    CHECK_TEXT(out, text);
}

TEST(faults_have_a_place)
{
    static const struct { const char *text; long line, column; const char *part; } known[] = {
        { "", 1, 1, "" },
        { "[1]", 1, 1, "" },
        { "{\"links\": 4}", 1, 1, "\"joints\" is missing" },
        { "{\"joints\": []}", 1, 1, "\"links\", their number" },
        { "{\"links\": 33, \"joints\": []}", 1, 11, "from 1 to 32" },
        { "{\"links\": 2.5, \"joints\": []}", 1, 11, "whole number" },
        { "{\"links\": [\"a\"], \"joints\": []}", 1, 11, "belongs to a linkage" },
        { "{\"links\": 2, \"joint\": []}", 1, 14, "joints" },
        { "{\"links\": 3,\n \"joints\": [[1, 2],\n  [2, 2]]}", 3, 3, "link 2 is joined to itself" },
        { "{\"links\": 3,\n \"joints\": [[1, 2],\n  [2, 1]]}", 3, 3, "2 and 1 are joined twice" },
        { "{\"links\": 3,\n \"joints\": [[1, 4]]}", 2, 17, "from 1 to 3" },
        { "{\"links\": 3, \"joints\": [[1, 2, \"k\"]]}", 1, 32, "a joint is \"r\"" },
        { "{\"links\": 3, \"joints\": [[1, 2, \"rr\"]]}", 1, 32, "a joint is \"r\"" },
        { "{\"links\": 3, \"joints\": [[1]]}", 1, 25, "its two links" },
        { "{\"links\": 3, \"joints\": [[1, 2, \"r\", 1]]}", 1, 25, "two links and a letter" },
        { "{\"links\": 3, \"joints\": [[1, 2]], \"inputs\": [[1, 3]]}", 1, 45, "joint of one freedom" },
        { "{\"links\": 3, \"joints\": [[1, 2, \"p\"]], \"inputs\": [[1, 2]]}", 1, 50, "one freedom" },
        { "{\"links\": 2, \"joints\": [[1, 2]], \"inputs\": [[1, 2], [2, 1]]}", 1, 53, "driven already" },
        { "{\"links\": 2, \"joints\": [[1, 2]], \"ground\": 0}", 1, 44, "from 1 to 2" },
        { "{\"links\": 2, \"joints\": [[1, 2]], \"output\": \"a\"}", 1, 44, "" },
        { "{\"links\": 2, \"joints\": [[1, 2]}", 1, 31, "" },
        { "{\"linkwright\": 2, \"links\": 2, \"joints\": [[1, 2]]}", 1, 16, "version" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_mechanism m;
        lw_error e = { 0 };
        CHECK_INT(lw_mechanism_read(known[i].text, strlen(known[i].text), "in", &m, &e), LW_E_NOTATION);
        CHECK_INT(e.line, known[i].line);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
    }
}
