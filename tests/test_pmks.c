/* The joint table of PMKS: read, written, refused. */
#include "grammar/linkage/pmks.h"
#include "tests/points_linkage.h"

static lw_linkage read_text(const char *text)
{
    lw_linkage k;
    lw_error e = { 0 };
    lw_units u = lw_units_si();
    lw_status s = read_small(lw_pmks_read, text, &u, &k, &e);
    CHECK_INT(s, LW_OK);
    if (s != LW_OK) {
        fprintf(stderr, "    %ld:%ld: %s\n", e.line, e.column, e.text);
        exit(1);
    }
    return k;
}

TEST(lines_of_a_file)
{
    lw_linkage k = read_text("ground, input,R,0,0.00\r\n\r\ncoupler input,RP,2,0.00,30\ncoupler,ground,R,5,0.00\n"
                             "coupler\tr\t-4\t0.5\nd=0\ne=0.01\n");
    CHECK_INT(k.n_link, 3);
    CHECK_INT(k.n_joint, 3);
    CHECK_INT(k.n_tracer, 1);
    CHECK_INT(k.joint[1].kind, LW_JOINT_SLOT);
    CHECK_TEXT(k.link_name[k.joint[1].link[0]], "coupler");        /* the first link carries the slot */
    CHECK_NEAR(k.joint[1].along.y, 0.5, 1e-15, 0);
    CHECK_NEAR(k.tracer[0].at.y, 0.5, 0, 0);
    CHECK_INT(k.n_input, 1);                               /* called input, at the ground */
    CHECK_INT(k.input[0].joint, 0);
}

TEST(a_web_address)
{
    lw_linkage k = read_text("http://somewhere/pmks.html?set=s5&mech=ground%20crank%20R%201.5%200%200%20ffft|"
                             "crank rod R 0 3 0 ffff|rod gnd P 4 0 -90 tfff|");
    CHECK_INT(k.n_joint, 3);
    CHECK_INT(k.n_input, 1);
    CHECK_NEAR(k.joint[0].at.x, 1.5, 0, 0);
    CHECK_INT(k.joint[2].link[1], k.ground);
    CHECK_NEAR(k.joint[2].along.y, -1, 1e-15, 0);
    k = read_text("mech=\nground,n0,R,45.5,35.25,45,tfff\nn0,1,P,42,38,0,tfft\n");
    CHECK_INT(k.input[0].joint, 1);                        /* a slider, flagged */
    CHECK_INT(k.joint[1].link[1], k.ground);
}

TEST(written_as_pmks_writes)
{
    char *text = fourbar_text(lw_pmks_write);
    CHECK_HAS(text, "ground,L2,R,0,0,ffft\nL2,L3,R,");
    CHECK_HAS(text, ",ffff\nL3,R,");
    CHECK_HAS(text, ",tfff\n");
    free(text);
    text = slide_text(lw_pmks_write);
    CHECK_TEXT(text, "ground,L2,P,20,0,30,ffft\n");
    free(text);
}

TEST(faults)
{
    static const fault_row rows[] = {
        { "", 1, 1, "no joint" },
        { "ground,a,0,0\n", 1, 1, "there is no R, P or RP" },
        { "R,0,0\n", 1, 1, "" },
        { "ground,a,R,0\n", 1, 12, "x and y" },
        { "ground,a,R\n", 1, 10, "x and y" },
        { "ground,a,R,x,0\n", 1, 12, "x is wanted" },
        { "ground,a,R,0,1.5k\n", 1, 14, "y: this is no number" },
        { "ground,a,R,0,0,zz\n", 1, 16, "the angle" },
        { "ground,a,R,0,0,5,ffff,3\n", 1, 23, "this is more" },
        { "ground,a,R,0,0\n\nb,c,G,4,0\n", 3, 5, "gears" },
        { "ground,ground,R,0,0\n", 1, 8, "named twice" },
        { "a,b,R,0,0\n", 2, 1, "called ground" },
        { "ground,a,R,0,0\nb,c,R,1,1\n", 1, 1, "ties link \"b\"" },
        { "ground,a,R,0,0\na,b,RP,1,1,0,ffft\n", 2, 1, "only a pin" },
        { "ground,a,R,0,0\na,R,1,1,0,ffft\n", 2, 1, "only a pin" },
        { "ground,a,R,0,0|a,R,1e400,1\n", 1, 20, "too large" },
        { "ground,a,R,0,0\naaaaaaaaaabbbbbbbbbbccccccccccdd,R,1,1", 2, 1, "1 to 31 bytes" },
    };
    check_faults(lw_pmks_read, rows, sizeof rows/sizeof *rows);
}

TEST(round_trips) { random_round_trips(lw_pmks_write, lw_pmks_read); }
TEST(several) { points_of_several_joints(lw_pmks_write, lw_pmks_read); }
TEST(names) { names_are_made_fit(lw_pmks_write, lw_pmks_read); }
TEST(not_written) { what_cannot_be_written(lw_pmks_write); }
