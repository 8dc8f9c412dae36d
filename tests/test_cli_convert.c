/* test_cli_convert.c - `linkwright convert`: examples there and back, formats told by content, units, refusals. */
#include "tests/cli_run.h"

TEST(examples_there_and_back)
{
    expect("for e in chebyshev inverted-slider-crank jansen scott-russell trammel; do for t in pyslvs pmks; do"
           " f=examples/$e.json; $P convert $f --format $t > $D/a || exit 1; $P convert $D/a -o $D/b.json || exit 1;"
           " $P convert $D/b.json --format $t > $D/c || exit 1; cmp $D/a $D/c || exit 1;"
           " $P trace $D/b.json -m file -n 7 > $D/2 || exit 1; done; done", 0, NULL, NULL);
}

TEST(the_text_tells_its_format)
{
    expect("$P convert examples/jansen.json --format pyslvs > $D/j.pyslvs", 0, NULL, NULL);
    expect("$P convert - < $D/j.pyslvs", 0, "\"name\": \"P3_1\"", NULL);
    expect("$P convert < $D/j.pyslvs -o $D/j.txt; cat $D/j.txt", 0, "crank,j,k,R,", NULL);
    expect("$P convert $D/j.txt --format pyslvs | diff - $D/j.pyslvs", 0, NULL, NULL);
    expect("$P convert $D/j.txt -o $D/k.json && $P trace $D/k.json -n 4", 0, "7,--+", NULL);
    expect("$P convert $D/j.txt --from-format pyslvs", 3, NULL, ":1:1: 'M[' is expected");
}

TEST(units)
{
    expect("echo 'ground,a,R,10,0,ffft|a,b,R,20,0|b,ground,R,20,10' > $D/u.txt", 0, NULL, NULL);
    expect("$P convert $D/u.txt --length-unit mm", 0, "\"length\": \"mm\"", NULL);
    expect("$P convert $D/u.txt --length-unit mm -o $D/u.json", 0, NULL, NULL);
    expect("$P convert $D/u.json --length-unit cm --format pmks", 0, "a,b,R,2,0,ffff", NULL);
    expect("sed '/\"units\"/d' examples/chebyshev.json | $P convert - -o $D/u.dxf", 0, NULL, "taken as metres");
    expect("$P convert examples/chebyshev.json -o $D/v.dxf 2>&1 | grep -c metres", 1, "0", NULL);
}

TEST(an_input_is_chosen)
{
    expect("echo 'M[J[R, P[0, 0], L[ground, a]], J[R, P[0, 1], L[a, b]], J[P, A[0], P[1, 0], L[ground, b]]]' > $D/i", 0, NULL, NULL);
    expect("$P convert $D/i", 0, NULL, NULL);
    expect("$P convert $D/i --format pmks --input-joint P2", 0, "ground,b,P,1,0,0,ffft", NULL);
    expect("$P convert $D/i --format pyslvs --input-joint P0", 0, "# input 0 1", NULL);
    expect("$P convert $D/i --input-joint P7", 3, NULL, "there is no joint 'P7'");
}

/* A row of 100 four-bars, 201 links on one ground, with an input chosen: there and back through each format that is read. */
TEST(more_links_than_a_plan_holds)
{
    expect("awk 'BEGIN { printf \"M[J[R, P[0, 0], L[ground, c0]]\"; for (i = 1; i <= 100; i++) printf "
           "\", J[R, P[%d, 0], L[ground, c%d]], J[R, P[%d, 1], L[c%d, r%d]], J[R, P[%d.25, 1.25], L[r%d, c%d]]\", 3*i, i, 3*i-3, i-1, i, "
           "3*i, i, i; print \"]\" }' > $D/long && $P convert $D/long --input-joint P0 -o $D/long.json && "
           "for t in pyslvs pmks adams; do $P convert $D/long.json --format $t > $D/1; $P convert $D/1 --from-format $t > $D/1.json; "
           "test $(grep -c '\"at\"' $D/1.json) = 301 && $P convert $D/1.json --format $t | cmp - $D/1 || exit 1; done; "
           "grep -A3 '\"input' $D/1.json", 0, "\"P0\"", NULL);
    expect("$P convert $D/long --input-joint P1000", 3, NULL, "there is no joint 'P1000'");
}

TEST(refusals)
{
    expect("for x in xml urdf sdf adm; do $P convert examples/dynamics/newtons-cradle.json -o $D/x.$x 2> $D/why && exit 1; "
           "grep -q contacts $D/why || exit 1; test ! -e $D/x.$x || exit 1; done", 0, NULL, NULL);
    expect("$P convert examples/elastic-slider-crank.json -o $D/x.xml", 3, "", "elastic links");
    expect("$P convert examples/dynamics/boom-cylinder.json -o $D/x.urdf", 3, "", "'lift.p1' is a variable of first order");
    expect("$P convert examples/dynamics/boxes.json -o $D/x.dxf", 3, "", "leaves its link free");
    expect("$P convert examples/jansen.json --format pyslv", 2, NULL, "did you mean 'pyslvs'");
    expect("$P convert examples/jansen.json -o $D/x.dat", 2, NULL, "add --format");
    expect("$P convert examples/jansen.json --from-format qmks", 3, NULL, "did you mean 'pmks'");
    expect("$P convert nowhere.txt", 3, NULL, "nowhere.txt");
    expect("echo 'ground,a,R,0,x' | $P convert", 3, NULL, "1:14: y is wanted");
    expect("$P convert examples/jansen.json --length-unit ell", 3, NULL, "no length unit 'ell'");
    expect("echo 'ground,a,R,0,x' | $P convert -o $D/never.json; test ! -e $D/never.json", 0, NULL, NULL);
    expect("printf '' | $P convert", 3, NULL, "");
    expect("$P help convert", 0, "the joint table of PMKS", NULL);
}

TEST(files_for_other_programs)
{
    expect("$P convert examples/hoeken.json -o $D/h.xml && cat $D/h.xml", 0, "<mujoco model=", NULL);
    expect("$P convert examples/slider-crank.json -o $D/s.adm && $P convert $D/s.adm --format adams | diff - $D/s.adm", 0, NULL, NULL);
    expect("$P convert $D/s.adm | $P trace - -n 3", 0, NULL, NULL);
    expect("$P convert examples/hoeken.json --format acf", 0, "SIMULATE/KINEMATICS", NULL);
    expect("$P convert examples/klann.json -o $D/k.dxf && cat $D/k.dxf", 0, "_CRANK\n", NULL);
    expect("$P convert examples/klann.json -o $D/k.scad && cat $D/k.scad", 0, "module link5()", NULL);
    expect("$P convert examples/geared-five-bar.json --format dxf", 3, NULL, "gears and welds are not cut");
    expect("$P convert examples/hoeken.json -o $D/c.svg && cat $D/c.svg", 0, "<path data-tracer=\"P\" d=\"M", NULL);
    expect("printf '<svg><path d=\"M40 0A40 15 0 0 1-40 0A40 15 0 0 1 40 0Z\"/></svg>' > $D/e.svg;"
           "$P fit $D/e.svg --type trammel --rounds 1 --results 1", 0, "60 points, closed", NULL);
    expect("$P fit examples/README.md.dxf", 3, NULL, "README.md.dxf");
    expect("$P convert examples/klann.json -o $D/k.csv && head -2 $D/k.csv", 0, "frame,input,link,x,y,turn", NULL);
    expect("$P convert examples/klann.json -o $D/k.slvs && grep -a -c AddConstraint $D/k.slvs", 0, NULL, NULL);
    expect("$P convert examples/klann.json --format motiongen", 0, "\"couplerPoints\"", NULL);
    expect("$P convert examples/hoeken.json --from-format mjcf", 3, NULL, "no format 'mjcf' to read");
    expect("printf '%s' '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"arm\", \"mass\": 1, \"centre\": [1, 0], \"velocity\": [0, 3], "
           "\"omega\": 3}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"arm\"], \"at\": [0, 0]}]}' > $D/spun.json; "
           "$P convert $D/spun.json --format mjcf", 0, "<key name=\"posture\" qvel=\"3\"/>", NULL);
    expect("$P convert $D/spun.json --format adams", 0, ", VY = 3, VZ = 0\n, WX = 0, WY = 0, WZ = 3\n", NULL);
    expect("sed 's/\"joints\"/\"input\": {\"joint\": \"A\", \"motion\": \"3*t\"}, \"joints\"/' $D/spun.json | $P convert --format mjcf", 3, NULL,
           "some inputs have a motion, and other parts a speed at the start");
    expect("$P convert $D/spun.json --format urdf", 0, "URDF holds no gravity and no speeds", NULL);
}

/* Every kind of linkage is written in every format, or refused with the joint that the format cannot hold. */
TEST(every_kind_in_every_format)
{
    static const char *const cannot[][2] = {
        { "geared-five-bar", "pyslvs pmks dxf scad slvs" }, { "loader", "dxf scad" },      /* no order of layers without collision */
    };
    for (int i = 0; i < 2; i++) {
        expect_with(0, "end", i ? "there are no layers" : "joint \"G\" is a gear", "for t in %s; do $P convert examples/%s.json --format $t -o $D/no.$t; "
                    "test $? = %d -a ! -e $D/no.$t || echo $t; done; echo end", cannot[i][1], cannot[i][0], i ? 1 : 3);
    }
    expect("for t in pyslvs pmks; do $P convert examples/tied-five-bar.json --format $t; done", 3, "", "joint \"B\" is tied to the first");
    expect("for m in examples/hoeken examples/slider-crank examples/inverted-slider-crank examples/trammel "
           "examples/klann examples/jansen tests/data/linkages/triad-eight-bar tests/data/linkages/scotch-yoke "
           "examples/five-bar; do for t in json pyslvs pmks adams acf mjcf dxf scad slvs svg poses motiongen; do "
           "$P convert $m.json --format $t -o $D/all.$t && test -s $D/all.$t || echo $m $t; rm -f $D/all.$t; done; done "
           "> $D/bad; cat $D/bad; test ! -s $D/bad", 0, NULL, NULL);
    /* the triad and the slot through the formats that can be read: the same text again, and the same curve */
    expect("for m in triad-eight-bar scotch-yoke; do for t in pyslvs pmks adams; do "
           "u=mm; test $t != adams || u=m; $P convert tests/data/linkages/$m.json | $P convert --format $t > $D/1; "
           "$P convert $D/1 --from-format $t --length-unit $u -o $D/1.json; $P convert $D/1.json --format $t > $D/2; "
           "$P convert $D/2 --from-format $t --length-unit $u --format $t | cmp - $D/2 || exit 1; done; done", 0, NULL, NULL);
    expect("for t in pyslvs pmks adams; do u=mm; test $t != adams || u=m; f=tests/data/linkages/triad-eight-bar.json; "
           "$P convert $f --format svg | grep -o ' d=.*' > $D/1; $P convert $f --format $t > $D/2; "
           "$P convert $D/2 --from-format $t --length-unit $u --format svg | grep -o ' d=.*' | cmp - $D/1 || exit 1; done", 0, NULL, NULL);
}
