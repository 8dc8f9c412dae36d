/* test_cli_draw.c - `linkwright draw` on the models of examples/. */
#include "tests/cli_run.h"

/* Ropes and springs are on the page, with the two links that hold them, and both links have motions. */
TEST(ties_of_pages)
{
    expect("$P draw examples/andrews.json -o $D/ties.html && grep -c 'data-ends=\"-1 3\" data-panel=\"0\"' $D/ties.html && "
           "grep -c '^.3,0,\\|\\[3,0,' $D/ties.html", 0, "1\n1", NULL);
    expect("$P draw examples/dynamics/rope.json -o $D/rope.html -q && grep -c '<polyline.*data-ends=\"' $D/rope.html", 0, "1", NULL);
    expect("$P draw examples/dynamics/boom-cylinder.json -o $D/jack.html -q && grep -c 'data-ends=.*data-rigid=\"1\"' $D/jack.html", 0, "3", NULL);
}

TEST(pictures)
{
    static const struct { const char *name, *head; } kind[] = {
        { "svg", "<?xml" }, { "png", "PNG" }, { "pdf", "%PDF" }, { "gif", "GIF89a" }, { "html", "<!" } };
    for (size_t i = 0; i < sizeof kind/sizeof *kind; i++) {
        expect_with(0, kind[i].head, NULL, "$P draw examples/hoeken.json -n 4 --size 200x150 -o $D/x.%s && head -c 8 $D/x.%s",
                    kind[i].name, kind[i].name);
        expect_with(0, NULL, NULL, "$P draw examples/hoeken.json -n 4 --size 200x150 -f %s | cmp - $D/x.%s", kind[i].name, kind[i].name);
    }
    expect("$P draw examples/hoeken.json -t examples/ellipse.csv", 0, "</svg>", NULL);
    expect("for f in examples/*.json; do $P draw $f -o $D/x.svg || exit 1; done", 0, NULL, NULL);
    expect("$P draw examples/hoeken.json -o $D/x.bmp", 2, NULL, "svg");
    expect("$P draw examples/hoeken.json --json", 2, NULL, "no meaning");
    expect("$P draw examples/hoeken.json --size 10x10", 2, NULL, "out of range");
    expect("$P draw examples/hoeken.json --size 100", 2, NULL, "WIDTHxHEIGHT");
    expect("$P draw examples/hoeken.json -t none.csv", 3, NULL, "no such file");
    expect("$P draw examples/hoeken.json -o /dev/full -f svg", 3, NULL, "no space left");
}

TEST(results_of_a_fit)
{
    expect("{ echo '{\"results\": [{\"linkage\":'; cat examples/hoeken.json; echo '}, {\"linkage\":'; "
           "cat examples/jansen.json; echo '}, {\"type\": 1}]}'; } > $D/r.json", 0, NULL, NULL);
    expect("$P draw $D/r.json", 0, "Hoeken", NULL);
    expect("$P draw $D/r.json --result 2", 0, "Jansen", NULL);
    expect("$P draw $D/r.json --result 3", 3, NULL, "has no linkage");
    expect("$P draw $D/r.json --result 4", 3, NULL, "there are 3");
    expect("$P draw examples/hoeken.json --result 1", 3, NULL, "no list of results");
}

/* Gears, inputs between moving links, several inputs, and more bars than needed: all can be drawn in motion. */
TEST(any_linkage)
{
    expect("for f in geared-five-bar five-bar loader mobility/focal mobility/parallelogram; do "
           "$P draw examples/$f.json -n 6 -o $D/x.html || exit 1; grep -q '\"links\":\\[' $D/x.html || exit 1; "
           "$P draw examples/$f.json -n 3 --size 200x150 -o $D/x.gif || exit 1; done", 0, NULL, NULL);
    expect("$P draw examples/loader.json -n 4 --to 0.5 -o $D/x.gif", 0, NULL, NULL);
    expect("$P draw examples/geared-five-bar.json --all-modes", 0, "other-curve", NULL);
    expect("$P draw examples/mobility/shaky.json", 0, "Shown without motion", "no input");
    expect("$P draw examples/space/crane.json", 0, NULL, "3 more inputs are needed to move it by inputs alone; 'linkwright simulate' moves it");
    expect("$P draw examples/loader.json --to -1", 2, NULL, "out of range");
    /* the boom of the cylinder turns all round, in space (its twin in the plane x z) too: sqrt(0.4^2 + 0.8^2) +- 1 m; within its stroke nothing is said */
    expect("$P draw examples/dynamics/boom-cylinder.json", 0, "Shown beyond the stroke", "cylinder \"lift\": about 105.8 to 1894 mm instead of 700 to 1300");
    expect("sed 's/\"speed\": 0/\"first\": -3, \"last\": 20/' examples/dynamics/boom-cylinder.json > $D/range.json && "
           "! $P draw $D/range.json 2>&1 | grep -q beyond", 0, NULL, NULL);
    expect("sed 's/\\[\\(-*[0-9]*\\), \\(-*[0-9]*\\)\\]/[\\1, 0, \\2]/g; s/-9.81\\]/0, -9.81]/; s/\"inertia\": 900/\"inertia\": [900, 900, 900]/; "
           "s/\"name\": \"A\"/\"name\": \"A\", \"axis\": [0, -1, 0]/' examples/dynamics/boom-cylinder.json > $D/space.json && $P draw $D/space.json", 0,
           NULL, "cylinder \"lift\": about 105.8 to 1894 mm instead of 700 to 1300");
    expect("! $P draw examples/scara.json 2>&1 | grep beyond", 0, NULL, NULL);              /* the first of three inputs stays within its stop */
    /* the block of a crank of 1 and a rod of 3 goes from 2 to 4, that is -2 to 0 from the posture; the rod turns by asin(1/3) either way */
    expect("echo '{@linkwright@: 1, @units@: {@length@: @m@, @angle@: @deg@}, @links@: [@ground@, @crank@, @rod@, @block@], @joints@: ["
           "{@name@: @A@, @links@: [@ground@, @crank@], @at@: [0, 0]}, {@name@: @B@, @links@: [@crank@, @rod@], @at@: [1, 0]}, {@name@: @C@, @links@: [@rod@, "
           "@block@], @at@: [4, 0], @stop@: {@least@: -15}}, {@name@: @S@, @kind@: @t@, @links@: [@ground@, @block@], @at@: [4, 0], @along@: [1, 0]}], "
           "@input@: {@joint@: @A@}}' | tr @ '\"' > $D/stop.json; $P draw $D/stop.json", 0, NULL, "joint \"C\": about -19.4");
    expect("sed 's/, \"stop\": [^}]*}//; s/\"along\": .1, 0./&, \"stop\": {\"least\": -1, \"greatest\": 0.1}/' $D/stop.json | $P draw -", 0, NULL,
           "joint \"S\": about -2 to 0 m instead of -1 to 0.1");
    expect("sed 's/\\[\\([0-9]\\), 0\\]/[\\1, 0, 0]/g; s/\"along\"/\"axis\"/; s/\"[ABC]\", /&\"axis\": [0, 0, 1], /g' "
           "$D/stop.json > $D/stop3.json; $P draw $D/stop3.json", 0, NULL, "joint \"C\": about -19.4");
}

/* Two linkages in one picture, and what cannot be compared. */
TEST(compared)
{
    expect("$P draw examples/hoeken.json examples/chebyshev.json", 0, "second linkage", NULL);
    expect("test $($P draw examples/hoeken.json examples/chebyshev.json | grep -c other-curve) = 4", 0, NULL, NULL);
    expect("$P draw examples/hoeken.json none.json", 3, "", "no such file");
    expect("$P chains --links 6 -o $D/six.g6; $P draw $D/six.g6 examples/hoeken.json", 2, "", "compared");
    expect("$P draw examples/space/bennett.json examples/hoeken.json", 3, "", "planar");
    expect("$P draw examples/hoeken.json --azimuth 3", 3, "", "spatial");
}

/* Outlines that touch, ropes and springs are parts of the picture, and ropes follow both ends in an animation. */
TEST(parts_of_models)
{
    expect("$P draw examples/dynamics/boxes.json -q | grep -c '<polygon[^>]*class=\"link\"'", 0, "3", NULL);
    expect("$P draw examples/dynamics/rope.json -q | grep -c 'class=\"link\"[^>]*stroke=\"#b87a00\"'", 0, "1", NULL);
    expect("$P draw examples/andrews.json -q | grep -c '<polyline points=.*class=.link.*#b87a00'", 0, "1", NULL);
    expect("$P draw examples/elastic-frame.json -q | grep -c '<polyline points=.[-0-9.]*,[-0-9.]* [-0-9.]*,[-0-9.]* [-0-9.]*,[-0-9.]* "
           "[-0-9.]*,[-0-9.]*. class=.link. [^>]*fill=.none'", 0, "1", NULL);            /* three bars, not a plate */
}
