/* The Pyslvs expression: read, written, refused. */
#include "grammar/linkage/pyslvs.h"
#include "tests/points_linkage.h"

static const char slider[] =
    "# a slider-crank\n"
    "M[J[R, color[Green], P[0.0, 0.0], L[ground, crank]],\n"
    "  J[R, P[-30, +40.0], L[crank, rod]], #[ several\n lines #]\n"
    "  J[RP, A[30.0], color[(1, 2, 3)], P[1e2, .5], L[ground, rod, flap]],\n"
    "  J[P, color[Dark-Red], A[-90], P[100, 0.5], L[flap, weight]],\n"
    "  J[R, P[10, 20], L[rod,]],]\n"
    "# input 0 1\n";

TEST(a_text_as_people_write_it)
{
    lw_linkage k;
    lw_error e = { 0 };
    lw_units u = lw_units_si();
    lw_units_set_length(&u, "mm");
    CHECK_INT(read_small(lw_pyslvs_read, slider, &u, &k, &e), LW_OK);
    if (e.text[0])
        fprintf(stderr, "%ld:%ld %s\n", e.line, e.column, e.text);
    CHECK_INT(k.n_link, 5);
    CHECK_TEXT(k.link_name[k.ground], "ground");
    CHECK_INT(k.n_joint, 5);
    CHECK_INT(k.n_tracer, 1);
    CHECK_INT(k.joint[2].kind, LW_JOINT_SLOT);
    CHECK_TEXT(k.link_name[k.joint[2].link[0]], "ground");
    CHECK_TEXT(k.link_name[k.joint[2].link[1]], "rod");
    CHECK_NEAR(k.joint[2].at.x, 0.1, 1e-17, 0);
    CHECK_NEAR(k.joint[2].along.y, 0.5, 1e-15, 0);
    CHECK_INT(k.joint[3].kind, LW_JOINT_REVOLUTE);         /* rod and flap on the pin in the slot */
    CHECK_TEXT(k.joint[3].name, "P2_1");
    CHECK_INT(k.joint[4].kind, LW_JOINT_SLIDER);
    CHECK_NEAR(k.joint[4].along.y, -1, 1e-15, 0);
    CHECK_NEAR(k.tracer[0].at.y, 0.02, 1e-17, 0);
    CHECK_TEXT(k.tracer[0].name, "P4");
    CHECK_INT(k.n_input, 1);
    CHECK_INT(k.input[0].joint, 0);
    CHECK_NEAR(k.input[0].value, atan2(40, -30), 1e-15, 0);
    CHECK_NEAR(k.joint[1].at.x, -0.03, 1e-17, 0);
}

TEST(several_links_on_the_ground_pin)
{
    static const char text[] = "M[J[R, P[0, 0], L[a, ground, b]], J[R, P[1, 0], L[b, c]], J[R, P[0, 1], L[a]]]\n"
                               "# input 0 1";
    lw_linkage k;
    lw_units u = lw_units_si();
    CHECK_INT(read_small(lw_pyslvs_read, text, &u, &k, NULL), LW_OK);
    CHECK_INT(k.n_joint, 3);
    CHECK_INT(k.joint[0].link[0], k.ground);               /* the ground is the middle */
    CHECK_INT(k.joint[1].link[0], k.ground);
    CHECK_INT(k.input[0].joint, 1);
    CHECK_TEXT(k.link_name[k.joint[1].link[1]], "b");
}

TEST(written_as_pyslvs_writes)
{
    char *text = fourbar_text(lw_pyslvs_write);
    CHECK_HAS(text, "M[J[R, color[Green], P[0, 0], L[ground, L2]],\n");
    CHECK_HAS(text, "L[L3]]]\n# input 0 1\n");
    free(text);
    text = slide_text(lw_pyslvs_write);
    CHECK_TEXT(text, "M[J[P, A[30], color[Green], P[20, 0], L[ground, L2]]]\n# input 0 0\n");
    free(text);
}

TEST(faults)
{
    static const fault_row rows[] = {
        { "", 1, 1, "'M[' is expected" },
        { "M(", 1, 2, "'M[' is expected" },
        { "M[]", 1, 4, "no joint" },
        { "M[J[R, P[0, 0], L[ground, a]]", 1, 30, "',' or ']'" },
        { "M[J[R, P[0, 0], L[ground, a]]] x", 1, 32, "behind the expression" },
        { "M[J[Q, P[0, 0], L[ground, a]]]", 1, 5, "R, P or RP, not Q" },
        { "M[J[R; P[0, 0], L[ground, a]]]", 1, 6, "','" },
        { "M[J[P, P[0, 0], L[ground, a]]]", 1, 8, "A[...], is missing" },
        { "M[J[R, P[0; 0], L[ground, a]]]", 1, 11, "',' is expected between x and y" },
        { "M[J[R, P[0, 0,0], L[ground, a]]]", 1, 14, "']'" },
        { "M[J[R, P[x, 0], L[ground, a]]]", 1, 10, "x is wanted" },
        { "M[J[R, P[1.2.3, 0], L[ground, a]]]", 1, 10, "1.2.3 is no number" },
        { "M[J[R, P[0, 1e999], L[ground, a]]]", 1, 13, "too large" },
        { "M[J[R, P[0, 0], L[ground a]]]", 1, 26, "',' or ']'" },
        { "M[J[R, P[0, 0], L[ground, ground]]]", 1, 27, "named twice" },
        { "M[J[R, P[0, 0], L[ground, 3]]]", 1, 27, "a link's name" },
        { "M[J[R, P[0, 0], L[]]]", 1, 3, "on no link" },
        { "M[J[R, P[0, 0], L[a, b]]]", 1, 26, "called ground" },
        { "M[J[R, color[Green, P[0, 0", 1, 8, "not closed" },
        { "M[\n J[RP, A[0], P[0, 0], L[ground]]]", 2, 2, "two links at least" },
        { "M[J[R, P[0, 0], L[ground, a]], J[R, P[1, 0], L[b, c]]]", 1, 3, "ties link \"b\"" },
        { "#[ open", 1, 1, "not closed" },
        { "M[J[R, P[0, 0], L[ground, a]]]\n# input x", 2, 1, "numbers of two points" },
        { "M[J[R, P[0, 0], L[ground, a]]]\n# input 0 7", 2, 1, "no point 7" },
        { "M[J[R, P[0, 0], L[ground, a]], J[R, P[1, 0], L[ground]]]\n# input 0 1", 2, 1, "no moving link" },
        { "M[J[R, P[0, 0], L[ground, a, b, c, d, e, f, g, h, aaaaaaaaaabbbbbbbbbbccccccccccdd]]]", 1, 51,
          "1 to 31 bytes" },
    };
    check_faults(lw_pyslvs_read, rows, sizeof rows/sizeof *rows);
}

TEST(round_trips) { random_round_trips(lw_pyslvs_write, lw_pyslvs_read); }
TEST(several) { points_of_several_joints(lw_pyslvs_write, lw_pyslvs_read); }
TEST(names) { names_are_made_fit(lw_pyslvs_write, lw_pyslvs_read); }
TEST(not_written) { what_cannot_be_written(lw_pyslvs_write); }
