/* test_cli_clearance.c - `linkwright clearance`: tables, limits, pictures, wrong use. */
#include "tests/cli_run.h"

#define MODEL "examples/clearance-four-bar.json"

static int lines_with(const char *text, const char *part)
{
    int n = 0;
    for (const char *p = text; (p = strstr(p, part)); p++)
        n++;
    return n;
}

TEST(table)
{
    ran r = run("$P clearance " MODEL " --speeds 92,94 --model impact,mlsd");
    CHECK_INT(r.code, 0);
    CHECK_INT(lines_with(r.out, "\nB,"), 4);
    CHECK(has_row(r.out, "joint|model|stiffness|damping|speed|contact|first_loss|losses|apart", "B|impact|1e8|3000|92|kept||0|0"));
    CHECK(has_row(r.out, "joint|model|speed|contact", "B|impact|94|lost"));
    CHECK_HAS(r.out, ",94,lost,0.6");                        /* [s] */
    CHECK(has_row(r.out, "joint|model|stiffness|damping|speed|contact", "B|mlsd|1e8|3000|92|kept"));
    ran_free(&r);
    expect_row("$P clearance " MODEL, "speed|contact", "92|kept");      /* the speed of the file, 92 r/min */
}

/* The output does not depend on the number of threads, apart from the command line in it. */
TEST(threads)
{
    ran a = run("$P clearance " MODEL " --speeds 90:110:5 --stiffness 1e6,1e7 -j 1 | grep -v '^#'");
    ran b = run("$P clearance " MODEL " --speeds 90:110:5 --stiffness 1e6,1e7 -j 3 | grep -v '^#'");
    CHECK_INT(lines_with(a.out, "\n"), 11);
    CHECK_TEXT(a.out, b.out);
    ran_free(&a), ran_free(&b);
}

TEST(limits)
{
    OWN(ran) r = run("$P clearance " MODEL " --speeds 90:98:4 --limits --refine 1");
    CHECK_INT(r.code, 0);
    const char *row = strstr(r.out, "impact");
    double k = 0, c = 0, kept = 0, lost = 0;
    CHECK(row && sscanf(row, "impact %lf %lf %lf - %lf", &k, &c, &kept, &lost) == 4);
    CHECK(k == 1e8 && c == 3000);
    CHECK(kept >= 92 && lost <= 95 && lost - kept <= 1 && lost > kept);
    CHECK_HAS(r.out, "2 of 3");
    ran_free(&r);
    r = run("$P clearance " MODEL " --speeds 90:98:4 --json");
    CHECK_HAS(r.out, "\"kept_lost\": [90, 94]");
    CHECK_HAS(r.out, "\"lost_kept\": [null, null]");
    CHECK_HAS(r.out, "\"speed_unit\": \"rpm\"");
}

TEST(pictures)
{
    ran r = run("$P clearance " MODEL " --speeds 94 --to 0.2 --settle 0.1 --every 0.001 --path $D/path.svg --force-plot $D/f.pdf "
                "--history $D/h.csv && $P clearance " MODEL " --speeds 90,98 --stiffness 1e6,1e8 --plot $D/map.svg && "
                "grep -c 'class=\"series' $D/path.svg && head -c 4 $D/f.pdf && wc -l < $D/h.csv && grep -c 'class=\"marker' $D/map.svg");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "%PDF");
    CHECK_HAS(r.out, "204\n");                               /* two comments, heading, 201 rows */
    ran_free(&r);
    /* at a regular speed the points of all turns differ by a pixel or two, at an irregular one they scatter */
    r = run("$P clearance " MODEL " --speeds 90,120 --to 6 --settle 4 --passes $D/p.svg > $D/x && grep 'class=\"marker' $D/p.svg | "
            "sed 's/.*cx=\"//; s/\" cy=\"/ /; s/\".*//' | awk '{if(!($1 in least) || $2<least[$1]) least[$1]=$2; "
            "if(!($1 in most) || $2>most[$1]) most[$1]=$2} END{for(x in least) print "
            "(most[x]-least[x] < 3 ? \"still\" : \"wild\")}' | sort");
    CHECK_TEXT(r.out, "still\nwild\n");
    ran_free(&r);
    expect("sed -n 3p $D/h.csv", 0, "t,input,input_rate,energy,x(B),y(B),force(B),touching(B)", NULL);
}

TEST(wrong_use)
{
    /* a law that feels no stiffness, or no damping, is one row, and a list that no law feels is refused */
    ran r = run("$P clearance " MODEL " --speeds 92 --to 0.1 --settle 0.05 --model zero,mlsd,hunt-crossley --stiffness 1e7,1e8 --damping 10,20 | cut -d, -f2-4");
    CHECK_INT(lines_with(r.out, "\nzero,"), 1);
    CHECK_INT(lines_with(r.out, "\nmlsd,"), 4);
    CHECK_INT(lines_with(r.out, "\nhunt-crossley,"), 2);
    ran_free(&r);
    expect("$P clearance " MODEL " --model hunt-crossley,lankarani-nikravesh --damping 10,20", 3, NULL, "a damping of the contact has no effect");
    expect("$P clearance " MODEL " --model zero,link --stiffness 1e7", 3, NULL, "a stiffness of the contact has no effect");
    expect("$P clearance " MODEL " --to 1e5 --time 1e-9 --speeds 92,94", 5, "joint,model", "2 of 2 runs were not made");
    expect("$P clearance", 2, NULL, "MODEL.json");
    expect("$P clearance " MODEL " --speeds 80:400", 3, NULL, "lacks a step");
    expect("$P clearance " MODEL " --speeds 80:400:-1", 3, NULL, "no range");
    expect("$P clearance " MODEL " --speeds 80:400:1:2", 3, NULL, "too many colons");
    expect("$P clearance " MODEL " --speeds fast", 3, NULL, "speed");
    expect("$P clearance " MODEL " --stiffness 0", 3, NULL, "above 0");
    expect("$P clearance " MODEL " --damping=-1", 3, NULL, "0 or more");
    expect("$P clearance " MODEL " --model imapct", 3, NULL, "did you mean impact");
    expect("$P clearance " MODEL " --speed-unit m/s", 3, NULL, "an input that turns");
    expect("$P clearance " MODEL " --speeds 90,92 --path $D/no.svg", 2, NULL, "one speed and one law");
    expect("$P clearance examples/slider-crank.json", 3, NULL, "no joint has clearance");
    expect("$P clearance $D/none.json", 3, NULL, "none.json");
    expect("sed 's/\"name\": \"B\",/\"name\": \"B\", \"kind\": \"t\", \"along\": [1, 0],/' " MODEL " > $D/slide.json; "
           "$P clearance $D/slide.json", 3, NULL, "slide.json:15:");
    expect("sed 's/\"speed\": 9.6[0-9]*/\"motion\": \"3*t\"/' " MODEL " > $D/driven.json; "
           "$P clearance $D/driven.json --speeds 90", 3, NULL, "motion");
    expect("sed 's/\"mass\": 2.41, //' " MODEL " > $D/light.json; $P clearance $D/light.json", 3, NULL, "coupler");
}
