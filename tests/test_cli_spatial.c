/* The program and spatial models: what it prints, and what it refuses with a status that is not 0. */
#include "base/vec2.h"
#include "tests/cli_json.h"

/* Several inputs, none with a range: the first one is to turn once, and it is said where it stops. */
TEST(several_inputs_without_a_range)
{
    expect("$P trace examples/space/delta-elastic.json -n 2", 4, NULL, "singular posture");
}

/* A stretched arm loses directions; a posture that is not singular has no such line.  The budget without sources says so. */
TEST(robots)
{
    expect("$P robot jacobian examples/space/arm.json", 0, "the tool's point cannot move in (0.000000, 1.000000, 0.000000); (0.000000, "
           "0.000000, 1.000000): a singular posture, place and turn of the tool have 3 of 6 freedoms", NULL);
    expect("$P robot jacobian examples/space/delta.json --tool-at 0,0,-1 | grep -c 'cannot move'", 1, "0", NULL);
    expect("$P robot jacobian examples/space/stewart.json --tool-at 0,0,0.8 --tool-turn 0,0,20", 0, "turned by (0, 0, 20) deg", NULL);
    expect("$P robot budget examples/space/delta-clearance.json --tool-force 1,2,1e308", 3, "", "--tool-force takes three numbers");
    expect("$P robot jacobian examples/3-rrr.json --tool-turn 20,", 3, NULL, "--tool-turn takes one number");
    expect("$P robot jacobian examples/space/delta.json --tool-turn 1,2,3", 3, NULL, "cannot turn the tool and keep its place");
    expect("$P robot jacobian examples/space/delta.json --drives-at 1,2", 3, NULL, "--drives-at takes 3 numbers");
    expect("$P robot jacobian examples/space/delta.json --drives-at 1,2,900", 4, NULL, "robot");
    expect("$P robot jacobian examples/space/stewart.json --tool-turn 0,0,100", 4, NULL,         /* Fichter 1986: at 90 degrees */
           "turned by 90 of 100 degrees");
    expect("$P robot jacobian examples/space/stewart.json --tool-turn 0,0,100", 4, NULL, "of 100 degrees: a posture in which the drives do not hold the tool");
    /* there and back: legs of a turned platform, as the drives of the forward kinematics */
    expect("$P robot jacobian examples/space/stewart.json --tool-at 0.05,-0.03,0.82 --tool-turn 5,-8,12 > $D/there; v=$(grep ^drive $D/there | "
           "awk '{printf s $3; s = \",\"}'); $P robot jacobian examples/space/stewart.json --drives-at $v | head -2", 0,
           "at (0.05, -0.03, 0.82) m\nturned by (5, -8, 12) deg", NULL);
    expect("$P robot jacobian examples/five-bar.json --tool-at 0,0", 4, NULL, "the tool stops at (0, 17.7403108, 0) mm: the limit of what the links can reach");
    expect("$P robot workspace examples/space/delta.json --max-condition 1.2", 4, NULL, "in the level plane: the condition number 1.63775 there exceeds --max-condition");
    expect("$P robot budget examples/space/delta.json", 3, NULL, "nothing lets the tool stray");
    expect("$P robot workspace examples/space/arm.json", 4, NULL, "the posture is singular, or the robot lacks this freedom");
    expect("$P robot map examples/space/arm.json", 4, NULL, "the posture is singular, or the robot lacks this freedom");
    expect("$P robot jacobian examples/space/arm.json --tool-at 0.1,0.1,0.9", 4, NULL, "the posture is singular, and the drives cannot move it "
           "this way; begin from another one");
    expect("echo '{@linkwright@: 1, @links@: [@ground@, {@name@: @a@, @mass@: 1, @centre@: [0.5, 0, 0], @inertia@: [1, 1, 1]}, {@name@: @b@, @mass@: 1, "
           "@centre@: [1.5, 0, 0], @inertia@: [1, 1, 1]}], @joints@: [{@name@: @A@, @kind@: @r@, @links@: [@ground@, @a@], @at@: [0, 0, 0], @axis@: [0, 0, 1]}, "
           "{@name@: @B@, @kind@: @r@, @links@: [@a@, @b@], @at@: [1, 0, 0], @axis@: [0, 0, 1]}], @drives@: [{@joint@: @A@}, "
           "{@joint@: @B@}], @tracers@: [{@name@: @T@, @link@: @b@, @at@: [2, 0, 0]}]}' | tr @ '\"' > $D/straight.json && "
           "$P robot jacobian $D/straight.json --tool-at 1.5,0.2,0", 4, NULL, "the posture is singular, or the robot lacks this freedom; begin from another one");
    expect("$P robot jacobian $D/straight.json --tool-at 1.5,0.2,0 --drives-at 1,20", 0, "at (1.5, 0.2, 0) m", NULL);
    /* drives without inputs: nothing holds the arm */
    expect("$P simulate $D/straight.json --to 0.1 -n 1", 0, NULL, "the \"drives\" have no force here");
    expect("! $P simulate examples/space/delta.json --to 0.1 -n 1 2>&1 | grep -q 'no force here'", 0, NULL, NULL);
    expect("sed 's/\"T\"/\"T,1\"/' $D/straight.json > $D/comma.json; $P simulate $D/comma.json --to 0.1 -n 1", 0, ",\"T,1.x\",", NULL);   /* one column */
    /* at its rim a driven model cannot close; slender bars without inertia about their axis have no part in that */
    expect("sed 's/\"coordinate\": \"z\", \"motion\": [^}]*}/\"coordinate\": \"z\", \"motion\": \"-0.65 - t\"}/' examples/space/delta.json > $D/rim.json; "
           "$P simulate $D/rim.json --to 1 -n 4 2>&1 >/dev/null | grep -c 'cannot be closed beyond.*m open$'", 0, "1", NULL);
    expect("$P convert examples/space/superelement.json --format acf", 3, NULL, "is a superelement, which is not written to ADAMS");
}

/* A five-bar goes down through the posture with its rods on one level line: one of them turns about its fixed pin there (-0.3, 0, 0.4). */
TEST(free_motions)
{
    expect("echo '{@linkwright@: 1, @links@: [@ground@, @a@, @b@, @c@, @d@], @joints@: ["
           "{@name@: @A@, @kind@: @r@, @links@: [@ground@, @a@], @at@: [0, 0, 0], @axis@: [0, 1, 0]}, "
           "{@name@: @B@, @kind@: @r@, @links@: [@a@, @b@], @at@: [0, 0, 0.5], @axis@: [0, 1, 0]}, "
           "{@name@: @P@, @kind@: @r@, @links@: [@b@, @c@], @at@: [0.5, 0, 1.12449979983984], @axis@: [0, 1, 0]}, "
           "{@name@: @C@, @kind@: @r@, @links@: [@c@, @d@], @at@: [1, 0, 0.5], @axis@: [0, 1, 0]}, "
           "{@name@: @D@, @kind@: @r@, @links@: [@ground@, @d@], @at@: [1, 0, 0], @axis@: [0, 1, 0]}], @drives@: [{@joint@: @A@}, {@joint@: @D@}], "
           "@inputs@: [{@tracer@: @T@, @coordinate@: @x@, @motion@: 0.5}, {@tracer@: @T@, @coordinate@: @z@, @motion@: @1.12449979983984 - t@}], "
           "@tracers@: [{@name@: @T@, @link@: @b@, @at@: [0.5, 0, 1.12449979983984]}]}' | tr @ '\"' > $D/five.json", 0, NULL, NULL);
    expect("$P trace $D/five.json --time-range 0:0.8:0.1", 0, NULL, "between t = 0.7 and 0.8 s the motion passes a parallel singularity");
    expect("$P trace $D/five.json --time-range 0:0.8:0.1", 0, NULL, "(link \"b\" turns about the axis (0.00, 1.00, 0.00) through (-0.3, 0, 0.4) m)");
    expect("$P robot jacobian $D/five.json --tool-at 0.5,0,0.3", 4, NULL,
           "stand still, link \"b\" turns about the axis (0.00, 1.00, 0.00) through (-0.3, 0, 0.4) m");
    expect("$P robot jacobian examples/space/stewart.json --tool-turn 0,0,100", 4, NULL,
           "link \"platform\" turns about the axis (0.00, 0.00, 1.00) through (0, 0, ");
}

TEST(traces)
{
    expect("$P trace examples/space/slider-crank.json -n 4 --tracer P", 0, "\n0,0.1999", NULL);
    expect("$P trace examples/space/bricard.json -n 4", 0, "units: input rad; x y z m", "both ends are limits of the motion");
    expect("$P trace examples/space/delta.json --time-range 0:0.1:0.05 --json", 0, "\"complete\": true", NULL);
    expect("$P trace examples/space/stewart.json --input-range 0:0.05 -n 2", 0, NULL, "the others stand still");
    expect("$P trace examples/space/sarrus.json --speed '60 rpm' -n 2", 0, "m/s", NULL);
    /* the joint of a link on a fixed pin draws a circle of radius 1 about it; a slide does not turn */
    expect("$P trace examples/space/bennett.json --geometry -n 7 | awk -F, 'NR > 2 && ($24 - 1)^2 < 1e-20 {n++} END {print n, $24}'",
           0, "8 ", NULL);
    expect("$P trace examples/space/sarrus.json --geometry -n 2 | tail -1 | grep -c ',,,$'", 0, "1", NULL);
    expect("$P trace examples/space/delta.json --time-range 0:0.2:0.02 --geometry --plot $D/space.svg && grep -c 'time \\[s\\]\\|place "
           "\\[m\\]\\|velocity \\[m/s\\]\\|curvature \\[1/m\\]' $D/space.svg", 0, "4", NULL);
    expect("$P trace examples/space/slider-crank.json --tracer Q", 3, NULL, "there is no tracer \"Q\"");
    expect("sed 's/\"motion\": -0.65/\"motion\": \"-0.65 - t\"/' examples/space/delta.json > $D/deep.json", 0, NULL, NULL);
    expect("$P trace $D/deep.json --time-range 0:1:0.1", 4, NULL, "open");
}

/* A hundred turns about a slanted axis: the quaternion is (cos(a/2), axis sin(a/2)) in every row, with no change of sign at half turns. */
TEST(quaternions_go_on)
{
    static const char check[] = " | awk -F, '/^(t|input),/ {for (i = 1; i <= NF; i++) at[$i] = i; next} /^[0-9]/ {n++; a = $(at[from])/2; p = of; "
        "e = ($(at[p \"qw\"]) - cos(a))^2 + $(at[p \"qx\"])^2 + ($(at[p \"qy\"]) - 0.6*sin(a))^2 + ($(at[p \"qz\"]) - 0.8*sin(a))^2; if (e > 1e-20) print a} "
        "END {print n}'";
    char command[1024];
    expect("echo '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 1, \"centre\": [1, 0, 0], \"inertia\": [1, 1, 1]}], "
           "\"joints\": [{\"name\": \"A\", \"kind\": \"revolute\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0, 0], \"axis\": [0, 0.6, 0.8]}], "
           "\"input\": {\"joint\": \"A\", \"motion\": \"200*pi*t\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"a\", \"at\": [1, 0, 0]}]}' "
           "> $D/turns.json", 0, NULL, NULL);
    snprintf(command, sizeof command, "$P simulate $D/turns.json -n 997 -q%s from=A.input of=P.", check);
    expect(command, 0, "998\n", NULL);
    snprintf(command, sizeof command, "$P trace $D/turns.json --input-range 0:628 -n 997 -q%s from=input", check);
    expect(command, 0, "998\n", NULL);
}

/* What is left when all but the spin of a bar between balls is held: nothing moves, also where the posture yields. */
TEST(idle_links_alone_do_not_move)
{
    static const struct { const char *axis, *verdict; } crank[] = {
        { "[0, 0, 1]", "rigid: nothing moves but idle links" }, { "[0, 1, 0]", "shaky: it yields, but only idle links move" } };
    for (size_t i = 0; i < sizeof crank/sizeof *crank; i++) {
        expect_with(0, NULL, NULL, "echo '{\"linkwright\": 1, \"links\": [\"ground\", \"crank\", \"bar\"], \"joints\": ["
                    "{\"name\": \"A\", \"kind\": \"revolute\", \"links\": [\"ground\", \"crank\"], \"at\": [0, 0, 0], \"axis\": %s}, "
                    "{\"name\": \"B\", \"kind\": \"spherical\", \"links\": [\"crank\", \"bar\"], \"at\": [1, 0, 0]}, "
                    "{\"name\": \"C\", \"kind\": \"spherical\", \"links\": [\"bar\", \"ground\"], \"at\": [1.5, 2, 0]}]}' > $D/idle.json", crank[i].axis);
        expect("$P mobility $D/idle.json", 0, crank[i].verdict, NULL);
    }
}

/* Rounded numbers: an overconstrained linkage is adjusted, and it is said by how much. */
TEST(rounded)
{
    expect("sed -E 's/([0-9]\\.[0-9]{4})[0-9]+/\\1/g' examples/space/bennett.json > $D/rounded.json && $P simulate $D/rounded.json -n 1", 0, NULL,
           "joints were moved by up to");
    expect("$P mobility $D/rounded.json", 0, "verdict         moves", NULL);
    expect("$P robot jacobian $D/rounded.json", 0, "tool 'P'", "joints were moved by up to");
    expect("$P mobility $D/rounded.json --tolerance 1e-12", 0, "rigid", "with joints open by up to");
    expect("sed -E 's/([0-9]\\.[0-9]{7})[0-9]+/\\1/g' examples/space/bennett.json > $D/finer.json && $P trace $D/finer.json -n 3", 0, NULL,
           "their axes turned by up to");
    expect("$P trace examples/space/bennett.json -n 3 2>&1 | grep -c overconstrained", 1, "0", NULL);
    /* crank and coupler in one plane, a ball, and a rocker across another plane: rigid, though it yields to first order */
    expect("printf '{\"linkwright\": 1, \"links\": [\"ground\", \"a\", \"b\", \"c\"], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0, 0], "
           "\"axis\": [0, 0, 1]}, {\"name\": \"B\", \"links\": [\"a\", \"b\"], \"at\": [0, 1, 0], \"axis\": [0, 0, 1]}, {\"name\": \"C\", \"kind\": \"b\", \"links\": "
           "[\"b\", \"c\"], \"at\": [2, 1.5, 0]}, {\"name\": \"D\", \"links\": [\"c\", \"ground\"], \"at\": [2, 0, 0], \"axis\": [0, 0.02, 1]}], \"input\": {\"joint\": "
           "\"A\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"b\", \"at\": [1, 1, 0]}]}' > $D/rigid.json; $P trace $D/rigid.json", 4, NULL,
           "its dimensions do not let it move farther");
}

/* Two parallel slides share the weight of a drawer in ways that rigid links leave open, and their friction depends on it. */
TEST(friction_of_redundant_slides)
{
    expect("m() { printf '{\"linkwright\": 1, \"gravity\": [0, 0, -9.81], \"links\": [\"ground\", {\"name\": \"drawer\", \"mass\": 1, \"centre\": [0, 0, 0], \"inertia\": "
           "[0.01, 0.01, 0.01]}], \"joints\": [{\"name\": \"A\", \"kind\": \"t\", \"links\": [\"ground\", \"drawer\"], \"at\": [0, 0.1, 0], \"axis\": [1, 0, 0]%s}, "
           "{\"name\": \"B\", \"kind\": \"t\", \"links\": [\"ground\", \"drawer\"], \"at\": [0, -0.1, 0], \"axis\": [1, 0, 0]}], "
           "\"forces\": [{\"link\": \"drawer\", \"at\": [0, 0.3, 0], \"fx\": \"3*t\"}]}' \"$1\"; }; "
           "m ', \"friction\": {\"coefficient\": 0.5}' > $D/rubs.json; m '' > $D/smooth.json", 0, NULL, NULL);
    expect("$P simulate $D/rubs.json --to 1 -n 1", 0, NULL, "friction acts in joints whose reactions are not unique");
    expect("$P simulate $D/smooth.json --to 1 -n 1 2>&1 | grep -c -e 'friction acts' -e 'are not unique'", 0, "1\n", "");
}

/* A parallelogram lying flat, drawn in space: several motions meet there.  With one input the posture is named; a second one that rests lets nothing
 * move; both together lead on.  At its dead centre a slider has no freedom. */
TEST(flat_parallelogram)
{
    expect("m() { printf '{\"linkwright\": 1, \"links\": [\"ground\", \"a\", \"b\", \"c\"], \"joints\": ["
           "{\"name\": \"A\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0, 0], \"axis\": [0, 0, 1]}, "
           "{\"name\": \"B\", \"links\": [\"a\", \"b\"], \"at\": [1, 0, 0], \"axis\": [0, 0, 1]}, "
           "{\"name\": \"C\", \"links\": [\"b\", \"c\"], \"at\": [5, 0, 0], \"axis\": [0, 0, 1]}, "
           "{\"name\": \"D\", \"kind\": \"%s\", \"links\": [\"ground\", \"c\"], \"at\": [4, 0, 0], \"axis\": [%s]}], "
           "\"inputs\": [%s], \"tracers\": [{\"name\": \"P\", \"link\": \"%s\", \"at\": [4, 0, 0]}]}' \"$@\"; }; "
           "a='{\"joint\": \"A\", \"motion\": \"2*t\"}' d='{\"joint\": \"D\", \"motion\": \"2*t\"}' r='{\"joint\": \"D\", \"motion\": 0}'; "
           "m r 0,0,1 \"$a\" b > $D/one.json; m r 0,0,1 \"$a, $r\" b > $D/rest.json; m r 0,0,1 \"$a, $d\" b > $D/two.json; "
           "m t 1,0,0 \"$a\" c > $D/slider.json", 0, NULL, NULL);
    expect("$P trace $D/one.json", 3, NULL, "singular: to first order the links have 2 freedoms there, but the motion has 1");
    expect("$P trace $D/rest.json", 4, NULL, "joints open beyond A = 0 rad, D = 0 rad");
    expect("$P trace $D/rest.json 2>&1 | wc -l", 0, "1\n", NULL);                    /* no posture is printed with rates that none can have */
    expect("sed 's/\\[1, 0, 0\\]/[1, 1, 0]/; s/\\[5, 0, 0\\]/[5, 1, 0]/' $D/rest.json > $D/up.json; $P trace $D/up.json --json", 3, NULL,
           "the model has 1 freedom and 2 inputs: 1 input is too many; A and D cannot all be inputs");
    expect("$P trace $D/up.json 2>&1 | wc -l", 0, "1\n", NULL);
    expect("$P trace $D/two.json --time-range 0:1:1 | cut -d, -f4,5", 0, "\n2.58385316345285", NULL);        /* 3 + cos 2 */
    expect("$P simulate $D/two.json", 0, NULL, NULL);
    expect("$P simulate $D/rest.json", 4, NULL, "the posture at the start is singular");
    expect("$P robot jacobian $D/two.json", 3, NULL, "the links have 1 freedom of motion, not one for each of the 2 drives");
    expect("$P robot jacobian $D/slider.json", 0, "vx               0", NULL);
    expect("$P robot jacobian $D/slider.json", 0, "a singular posture, place and turn of the tool have 0 of 1 freedoms", NULL);
}

/* Motions that move every freedom beyond a rigid stop, also there and back between two rows; sin(t) = 2/3 at t = 0.7297. */
TEST(driven_beyond_stops)
{
    expect("sed 's/\"to\": 1.2, \"dwell\"/\"to\": 3.2, \"dwell\"/' examples/space/boom.json > $D/side.json && $P simulate $D/side.json --to 12 -n 1", 4, "incomplete",
           "\"swing\" beyond its rigid stop");
    OWN(ran) r = run("$P simulate examples/space/boom.json --to 12 -n 1");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "feed.input,feed.rate,swing.rate");          /* "feed" is input and drive: its rate stands once */
    CHECK(strstr(r.err, "one name") == NULL && strstr(r.out, "dump.drive,feed.acceleration,feed.drive") != NULL);
    expect("echo '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 1, \"centre\": [0.5, 0], \"inertia\": 0.1}, {\"name\": \"b\", "
           "\"mass\": 1, \"centre\": [1.5, 0], \"inertia\": 0.1}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0]}, {\"name\": \"B\", "
           "\"links\": [\"a\", \"b\"], \"at\": [1, 0], \"stop\": {\"greatest\": 0.2}}], \"inputs\": [{\"joint\": \"A\", \"motion\": \"t\"}, {\"joint\": \"B\", "
           "\"motion\": \"pi + 0.3*sin(t)\"}]}' > $D/b.json && $P simulate $D/b.json --to 3 -n 1", 4, "incomplete", "\"B\" beyond its rigid stop, at t = 0.73");
    expect("sed 's/0.3\\*sin/0.19*sin/' $D/b.json > $D/c.json && $P simulate $D/c.json --to 3 -n 1", 0, NULL, NULL);
}

TEST(runs)
{
    expect("$P simulate examples/space/superelement.json --to 0.001 -n 1", 0, NULL, "link \"boom\" has no section: its inner forces are known");
    expect("$P simulate examples/space/superelement.json --to 0.001 -n 1 2>&1 | grep -c 'times its inertia'", 1, "0", NULL);
    expect("$P simulate examples/space/superelement-modes.json --to 0.01 -n 1 --explain", 0, NULL, "superelements between 3 nodes, with modes");
    expect("$P simulate examples/space/superelement.json --to 0.001 -n 1 --formulation ggl", 3, NULL, "the mass of superelements and of consistent bars depends on the posture");
    expect("$P simulate examples/space/delta.json --to 0.1 -n 10 --explain", 0, "M1.drive", "every freedom is driven");
    expect("$P simulate examples/space/bricard.json -n 2", 0, "kinetic,potential,work", "at P");
    expect("$P simulate examples/space/top.json -n 2 --json", 0, "\"formulation\": \"recursive\"", "energy error");
    expect("$P simulate examples/space/sarrus.json -a static", 1, NULL, "no static equilibrium");
    expect("$P simulate examples/space/slider-crank.json --speed 3 -n 2 --explain", 0, "A.drive", "driven");
    expect("$P simulate examples/space/slider-crank.json --formulation cvode --tolerance 1e-6 -n 2", 0, NULL, "energy error");
    expect("$P simulate examples/space/delta-elastic.json --to 1e-3 -n 1 -e", 0, NULL, "quasi-static run");
    expect("$P simulate examples/space/bricard.json --max-steps 3 --to 50", 5, NULL, "rows so far are kept");
}

/* A drive that moves to and fro excites by its acceleration over its speed, here in resonance; its speed alone would be 90 times slower. */
TEST(advice_for_a_shaken_arm)
{
    expect("echo '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"arm\", \"elastic\": {\"section\": {\"shape\": \"round\", \"diameter\": 0.02}, "
           "\"material\": \"steel\", \"axis\": [[0, 0], [0.5, 0]], \"segments\": 8}}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"arm\"], "
           "\"at\": [0, 0]}], \"input\": {\"joint\": \"A\", \"motion\": \"0.01*sin(400*t)\"}}' | $P simulate /dev/stdin --explain --to 0.05 -n 2", 0, NULL,
           "0.902 times the frequency of the drive, 400 rad/s (its speed, or acceleration over speed): vibrations matter");
}

/* 20 kN pull at a closed cylinder: F/A1 is far beyond 1 bar, in the plane and in space; 100 N are not. */
TEST(oil_below_vacuum)
{
    static const char *const at[2][2] = { { "[0.6, 0]", "[0, 0]" }, { "[0.6, 0, 0]", "[0, 0, 0]" } };
    for (int k = 0; k < 4; k++) {
        ran r = run_with("echo '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"m\", \"mass\": 100, \"centre\": %s, \"inertia\": %s}], \"joints\": "
                         "[{\"name\": \"S\", \"kind\": \"t\", \"links\": [\"ground\", \"m\"], \"at\": %s, %s}], \"cylinders\": [{\"name\": \"C\", \"links\": [\"ground\", \"m\"], \"at\": "
                         "[%s, %s], \"bore\": 0.05, \"rod\": 0.03, \"retracted\": 0.5, \"stroke\": 0.3, \"dead_volume\": 1e-5, \"pressures\": [5e5, 5e5]}], \"forces\": [{\"link\": \"m\", "
                         "\"at\": %s, \"fx\": %d}]}' > $D/pull.json; $P simulate $D/pull.json --to 0.1 -n 20", at[k%2][0], k%2 ? "[1, 1, 1]" : "1", at[k%2][0],
                         k%2 ? "\"axis\": [1, 0, 0]" : "\"angle\": 0", at[k%2][1], at[k%2][0], at[k%2][0], k < 2 ? 20000 : -100);
        CHECK_INT(r.code, 0);
        CHECK((strstr(r.err, "below vacuum") != NULL) == (k < 2));
        ran_free(&r);
    }
}

TEST(pictures)
{
    expect("$P simulate examples/space/top.json --to 0.1 -n 10 --gif $D/top.gif --plot $D/top.svg && head -c 6 $D/top.gif", 0,
           "GIF89a", "times slower");
    expect("$P simulate examples/space/delta-elastic.json --to 0.01 -n 3 --gif $D/bent.gif --plot $D/bent.svg --json && "
           "grep -c M1.drive $D/bent.svg", 0, "\"rows\"", "slower");
    expect("$P simulate examples/space/top.json --plot $D/no.svg --columns P.x,energy -n 2 && grep -c P.x $D/no.svg", 0, "1", NULL);
    expect("$P simulate examples/space/top.json --plot $D/no.svg --columns energy -n 2", 3, NULL, "no column is called energy");
}

/* Three slides with stops and three hinges through the tool: the volume is that of a box, each ray ends in one of its faces, and the hinge B with its
 * stop of 0.7 rad limits the tilt by t where sin(t) |cos(azimuth)| = sin(0.7). */
TEST(volumes_and_tilts)
{
    static const char text[] =
        "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"x\"}, {\"name\": \"y\"}, {\"name\": \"z\"}, {\"name\": "
        "\"a\"}, {\"name\": \"b\"}, {\"name\": \"c\"}], \"joints\": [{\"name\": \"X\", \"kind\": \"t\", \"links\": "
        "[\"ground\", \"x\"], \"at\": [0, 0, 0], \"axis\": [1, 0, 0], \"stop\": {\"least\": -0.2, \"greatest\": 0.2}}, "
        "{\"name\": \"Y\", \"kind\": \"t\", \"links\": [\"x\", \"y\"], \"at\": [0, 0, 0], \"axis\": [0, 1, 0], \"stop\": "
        "{\"least\": -0.15, \"greatest\": 0.15}}, {\"name\": \"Z\", \"kind\": \"t\", \"links\": [\"y\", \"z\"], \"at\": [0, 0, "
        "0], \"axis\": [0, 0, 1], \"stop\": {\"least\": -0.1, \"greatest\": 0.1}}, {\"name\": \"A\", \"links\": [\"z\", "
        "\"a\"], \"at\": [0, 0, 0], \"axis\": [1, 0, 0]}, {\"name\": \"B\", \"links\": [\"a\", \"b\"], \"at\": [0, 0, 0], "
        "\"axis\": [0, 1, 0], \"stop\": {\"least\": -0.7, \"greatest\": 0.7}}, {\"name\": \"C\", \"links\": [\"b\", \"c\"], "
        "\"at\": [0, 0, 0], \"axis\": [0, 0, 1]}], \"drives\": [{\"joint\": \"X\"}, {\"joint\": \"Y\"}, {\"joint\": \"Z\"}, "
        "{\"joint\": \"A\"}, {\"joint\": \"B\"}, {\"joint\": \"C\"}], \"tracers\": [{\"name\": \"T\", \"link\": \"c\", \"at\": "
        "[0, 0, 0]}]}";
    /* a box, and a needle, which few of the first rays meet: the estimated error is small, and the volume is within it */
    static const struct { const char *edit; double volume, share; } regions[] = { { "''", 0.4*0.3*0.2, 0.04 },
        { "-e s/0.2/1/g -e s/0.15/0.02/g -e s/0.1}/0.02}/g -e s/-0.1/-0.02/g", 2*0.04*0.04, 0.15 } };
    ran r = run_with("echo '%s' > $D/box.json", text);
    ran_free(&r);
    for (int i = 0; i < 2; i++) {
        json_t *t = json_with("sed %s $D/box.json > $D/region.json; $P robot workspace $D/region.json --volume --rays 12 --json", regions[i].edit);
        double error = json_real_value(json_object_get(t, "volume_error"));
        CHECK(error > 0 && error < regions[i].share*regions[i].volume);
        CHECK_NEAR(json_real_value(json_object_get(t, "volume")), regions[i].volume, error, 0);
        json_decref(t);
    }
    expect("$P robot workspace $D/box.json --volume --rays 3 | awk -F, 'NR > 2 { x = $4/0.2; y = $5/0.15; z = $6/0.1; x = x < 0 ? -x : x; y = y < 0 ? -y : y; "
           "z = z < 0 ? -z : z; m = x > y ? x : y; m = m > z ? m : z; n += m > 0.999999 && m < 1.000001 } END { print (n == NR - 2 && n > 60) }'", 0, "1", "estimated error");
    expect("$P robot reachability $D/box.json --rays 12 | awk -F, 'NR > 2 { c = cos($1*3.14159265358979/180); c = c < 0 ? -c : c; s = sin(0.7)/c; "
           "t = s < 1 ? atan2(s, sqrt(1 - s*s))*180/3.14159265358979 : 180; n += $2 - t < 1e-5 && t - $2 < 1e-5 } END { print n }'", 0, "12", "reachability index 0.57");
    /* a name with a comma and a quote is one field of a row */
    expect("sed 's/\"shoulder\"/\"left, \\\\\"high\\\\\"\"/g' examples/scara.json > $D/names.json; "
           "$P robot workspace $D/names.json --rays 6 | sed -n 6p; $P simulate $D/names.json --to 0.1 -n 1 | sed -n 3p | cut -c1-34", 0,
           ",\"the stop of joint \"\"left, \"\"high\"\"\"\"\"\nt,\"left, \"\"high\"\".input\",\"left,", NULL);
    expect("$P robot workspace examples/space/delta.json --volume --plot $D/edge.svg", 2, NULL, "--plot draws the edge in the level plane");
    expect("$P robot reachability examples/space/delta.json", 3, NULL, "cannot turn the tool and keep its place");
    /* Arm with seven joints: its wrist stays within 0.82 m of its shoulder, at z = 0.36 m.  After a turn of the tool, which rounds, too. */
    expect("$P robot workspace examples/space/arm.json --drives-at 10,40,20,-70,15,60,30 --rays 3 | awk -F, 'NR > 2 { printf \"%.6f %s \", $2, $6 }'", 0,
           "0.374179 the limit of what the drives can reach 0.644420 the limit of what the drives can reach 0.429753 the limit of what the drives can reach ", "area 0.293961 m^2");
    expect("$P robot workspace examples/space/arm.json --drives-at 10,40,20,-70,15,60,30 --rays 3 --max-condition 9", 0, NULL, "depends on the way there");
    /* A wrist of three pins through one point, its tool beside it: the angle between the first and the last axis, 78.69 degrees, goes from the
     * difference to the sum of the angles between neighbours, 73.30 and 86.77 degrees. */
    expect("echo '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\"}, {\"name\": \"b\"}, {\"name\": \"c\"}], \"joints\": [{\"name\": \"A\", "
           "\"links\": [\"ground\", \"a\"], \"at\": [0, 0, 0], \"axis\": [0, 0, 1]}, {\"name\": \"B\", \"links\": [\"a\", \"b\"], \"at\": [0, 0, 0], "
           "\"axis\": [0, 1, 0.3]}, {\"name\": \"C\", \"links\": [\"b\", \"c\"], \"at\": [0, 0, 0], \"axis\": [1, 0, 0.2]}], \"drives\": [{\"joint\": "
           "\"A\"}, {\"joint\": \"B\"}, {\"joint\": \"C\"}], \"tracers\": [{\"name\": \"T\", \"link\": \"c\", \"at\": [0.3, 0, 0.4]}]}' > $D/wrist.json; "
           "$P robot reachability $D/wrist.json --rays 4 | awk -F, 'NR == 3 || NR == 5 { printf \"%.6f \", $2 } NR == 4 || NR == 6 { printf \"%g \", $2 }'",
           0, "81.380156 180 65.221356 180", "0.5 m from its own");
    expect("$P robot workspace examples/3-rrr.json --volume", 3, NULL, "a robot in a plane has no volume");
    expect("$P robot reachability examples/3-rrr.json", 0, "the drives do not hold the tool", "reachability index");
}

/* ggl does not pass singular postures in space: index1 goes on there, to the same posture as auto, and that is said. */
TEST(a_run_is_handed_over)
{
    expect("for f in ggl auto; do $P simulate examples/space/sarrus.json --to 3 -n 3 --formulation $f 2>>$D/said | awk -F, '!/^#/ { q = $2 } END { printf \"%.6f \", q }'; done; "
           "grep -o 'the rest of the run is by index1' $D/said", 0, "4.811589 4.811589 the rest of the run is by index1", NULL);
}

/* What is not there for spatial models is refused, never ignored. */
TEST(refusals)
{
    expect("$P simulate examples/space/top.json -a linear --along 3", 2, NULL, "planar");
    expect("$P simulate examples/space/top.json --formulation reduced", 3, NULL, "its links move in space");
    expect("sed 's/0.9659258262890682, 0.2588190451025206/0.9, 0.4/' examples/space/bennett.json > $D/held.json && $P trace $D/held.json", 3, NULL,
           "cannot move in the posture of the file");
    expect("$P simulate examples/space/top.json --balance", 2, NULL, "planar");
    expect("$P simulate examples/space/top.json -a kinematic", 3, NULL, "more freedoms would have to be driven");
    expect("$P trace examples/space/bricard.json --cycle", 2, NULL, "planar");
    expect("$P trace examples/space/top.json", 3, NULL, "no input");
    expect("$P fit examples/space/top.json", 3, NULL, "");
    expect("$P clearance examples/space/top.json", 3, NULL, "spatial model");
    expect("$P convert examples/space/top.json --format dxf", 3, "", "planar linkages only");
    expect("$P convert examples/space/top.json --format mjcf --length-unit mm", 3, "", "--length-unit goes with planar");
}

/* A lift has no workspace in the level plane; a table of two slides has no limits there. */
TEST(workspaces)
{
    expect("echo '{\"linkwright\": 1, \"links\": [\"ground\", \"a\", \"b\"], \"joints\": [{\"name\": \"A\", \"kind\": \"prismatic\", \"links\": "
           "[\"ground\", \"a\"], \"at\": [0, 0, 0], \"axis\": [0, 0, 1]}, {\"name\": \"B\", \"kind\": \"prismatic\", \"links\": [\"a\", \"b\"], "
           "\"at\": [0, 0, 1], \"axis\": [1, 0, 0]}], \"drives\": [{\"joint\": \"A\"}, {\"joint\": \"B\"}], \"tracers\": [{\"name\": \"T\", "
           "\"link\": \"b\", \"at\": [0, 0, 1]}]}' > $D/tower.json; sed 's/.1, 0, 0./[0, 0, 1]/' $D/tower.json > $D/lift.json; "
           "sed 's/axis\": .0, 0, 1./axis\": [0, 1, 0]/' $D/tower.json > $D/table.json", 0, NULL, NULL);
    expect("$P robot workspace $D/lift.json --rays 8", 4, NULL, "cannot move the tool");
    expect("$P robot map $D/lift.json --places 3", 4, NULL, "cannot move the tool");
    expect("$P robot workspace $D/table.json --rays 8", 0, "none found", "in 8 of 8 directions");
    expect("$P robot workspace $D/table.json --rays 8 --json", 0, "\"without_limit\": 8", NULL);
    expect("$P robot workspace examples/space/delta.json --rays 8 --json", 0, "\"without_limit\": 0", NULL);
}

/* The output of a controller in space is a column: its gain times the difference of what is wanted and measured in the same row. */
TEST(controllers)
{
    expect("printf '{\"linkwright\": 1, \"gravity\": [0, 0, -9.81], \"links\": [\"ground\", {\"name\": \"b\", \"mass\": 1, \"centre\": [1, 0, 0], "
           "\"inertia\": [0.1, 0.1, 0.1]}], \"joints\": [{\"name\": \"A\", \"kind\": \"revolute\", \"links\": [\"ground\", \"b\"], \"at\": [0, 0, 0], "
           "\"axis\": [0, 1, 0]}], \"controllers\": [{\"name\": \"c\", \"wanted\": \"sin(t)\", \"measured\": \"q(A)\", \"proportional\": 2}]}' > $D/c.json; "
           "$P simulate $D/c.json --to 0.2 -n 4 -q | awk -F, '/^t,/ { for (i = 1; i <= NF; i++) at[$i] = i } /^0/ { n++; d = $(at[\"c.output\"]) - "
           "2*(sin($1) - 2*atan2($(at[\"b.qy\"]), $(at[\"b.qw\"]))); if (d*d > 1e-18) print; } END { print n }'", 0, "5\n", NULL);
}

/* The motion of an arm ends with a jump of its acceleration at a row: this has the one behind the jump, as docs/notation.md says; 6*1.2/0.3^2 = 80. */
TEST(rows_at_kinks)
{
    expect("echo '{@linkwright@: 1, @links@: [@ground@, {@name@: @hub@, @mass@: 1, @centre@: [0, 0, 0], @inertia@: [0.01, 0.01, 0.01]}, "
           "{@name@: @arm@, @elastic@: {@section@: {@shape@: @round@, @diameter@: 0.01}, @material@: @steel@, @axis@: [[0, 0, 0], [0.3, 0, 0]], "
           "@segments@: 2, @damping@: {@ratio@: 0.01, @at@: 30}}}], @joints@: [{@name@: @A@, @kind@: @r@, @links@: [@ground@, @hub@], @at@: [0, 0, 0], "
           "@axis@: [0, 0, 1]}, {@name@: @W@, @kind@: @f@, @links@: [@hub@, @arm@], @at@: [0, 0, 0]}], "
           "@input@: {@joint@: @A@, @motion@: @step(t, 0, 0, 0.3, 1.2)@}}' | tr @ '\"' > $D/kink.json; for f in radau alpha; do $P simulate $D/kink.json "
           "--to 0.4 -n 4 --formulation $f -q | awk -F, '/^[0-9]/ {printf \"%.0f \", sqrt($4^2)}'; done", 0, "80 27 27 0 0 80 27 27 0 0 ", NULL);
}

/* A gear pair of a linkage with more links than a plan has: its carrier is found among the links around it. */
TEST(gears_of_large_linkages)
{
    expect("python3 -c 'import json\n"
           "links = [\"ground\"] + [{\"name\": \"b%d\" % i, \"mass\": 1, \"centre\": [i, -0.5], \"inertia\": 0.1} for i in range(38)]\n"
           "joints = [{\"name\": \"J%d\" % i, \"links\": [\"ground\" if i < 2 else \"b%d\" % (i - 1), \"b%d\" % i], \"at\": [i, 0]} for i in range(38)]\n"
           "joints.append({\"name\": \"G\", \"kind\": \"g\", \"links\": [\"b0\", \"b1\"], \"ratio\": -2})\n"
           "print(json.dumps({\"linkwright\": 1, \"links\": links, \"joints\": joints, \"inputs\": [{\"joint\": \"J0\", \"speed\": 1}]}))' > $D/g.json; "
           "$P simulate $D/g.json --to 0.02 -n 2 -q | awk -F, '/^t,/ { for (i = 1; i <= NF; i++) at[$i] = i } /^0/ { n++; d = $(at[\"b1.omega\"]) + 2; "
           "if (d*d > 1e-12) print } END { print n }'", 0, "3\n", NULL);
}

TEST(files_for_other_programs)
{
    expect("$P convert examples/space/top.json -o $D/a.adm && grep -c SPHERICAL $D/a.adm", 0, "1\n", NULL);
    expect("$P convert - --format mjcf < examples/space/delta.json | grep -c '<connect'", 0, "5\n", NULL);
}

TEST(freedoms)
{
    expect_words("$P mobility examples/space/bennett.json", "\nfreedom 1");
    expect("$P mobility examples/space/bennett.json", 0, "tilt 2 of D", NULL);
    expect("$P mobility examples/space/delta.json", 0, "bar 1a, bar 1b", NULL);
    expect("$P mobility examples/space/bricard.json --json", 0, "\"redundant\": [", NULL);
    expect("sed 's/\\(\\.[0-9]\\{5\\}\\)[0-9]*/\\1/g' examples/space/bennett.json > $D/r.json", 0, NULL, NULL);
    expect_words("$P mobility $D/r.json", "\nfreedom 1");
    expect_words("$P mobility $D/r.json --tolerance 1e-12", "\nfreedom 0");
    expect_words("$P mobility $D/r.json --tolerance 1e-4", "\nfreedom 1");
    expect("$P mobility $D/r.json --tolerance 1e-12", 0, NULL, "m it has 1 freedom (\"--tolerance 0.0001\")");
    expect("sed 's/\"joint\": \"A\"}/\"joint\": \"A\", \"speed\": 2}/; s/-1.50271/-1.3/' $D/r.json > $D/v.json && $P simulate $D/v.json", 3, NULL, "nothing can move in this posture");
}
