/* test_cli_atlas.c - the catalogue commands curves, nearest, add, query and export; programs killed while they add
 * curves and linkages. */
#include "tests/catalogue_file.h"
#include "tests/cli_run.h"

TEST(curves)
{
    expect("$P catalogue curves $D/c.db", 2, NULL, "--samples N");
    expect("$P catalogue curves $D/c.db --samples 10 --type fourbra", 3, NULL, "no type 'fourbra'");
    expect("$P catalogue curves $D/c.db --links 4 --samples 4000", 0, "", "4000 of 4000 samples");
    expect("$P catalogue curves $D/c.db --links 4 --samples 4000", 0, "", "0 curves drawn");
    expect("$P catalogue curves $D/c.db --samples 500 --type slidercrank --curves closed", 0, "", "500 of 500");
    expect("$P catalogue check $D/c.db", 0, NULL, "whole");
}

TEST(nearest)
{
    expect("$P catalogue nearest $D/c.db examples/ellipse.csv --results 3", 0, "  3 ", "blocks read");
    expect("$P catalogue nearest $D/c.db examples/ellipse.csv --results 5 --json -o $D/near.json; $P draw $D/near.json "
           "--result 2 --target examples/ellipse.csv -o $D/near.svg && grep -c '</svg>' $D/near.svg", 0, "1\n", NULL);
    expect("$P catalogue nearest $D/c.db examples/letter-s.csv --shape open --results 1", 0, "  1 ", NULL);
    expect("$P catalogue nearest $D/c.db examples/ellipse.csv --full-turn --min-transmission-angle 30 --length-range 1:300 "
           "--results 3 | awk 'NR > 1 && $3 >= 30 && $4 == \"turns\"' | wc -l", 0, "3\n", NULL);
    expect("$P catalogue nearest $D/c.db examples/ellipse.csv --min-transmission-angle 89.8", 1, NULL, "meet these conditions");
    expect("$P catalogue nearest $D/c.db examples/ellipse.csv --length-range 0:0", 2, NULL, "excludes every linkage");
    expect("$P catalogue nearest $D/c.db examples/function-log.csv", 3, NULL, "x and y");
    expect("$P catalogue nearest $D/none.db examples/ellipse.csv", 3, NULL, "no such file");
    expect("$P catalogue build $D/empty.db --links 4 && $P catalogue nearest $D/empty.db examples/ellipse.csv", 1, NULL,
           "holds no closed curves");
}

/* Curves of six links are drawn and found, do not depend on the number of threads, and start a fit. */
TEST(six_links)
{
    expect("$P catalogue curves $D/s.db --links 6 --samples 1500 && $P catalogue curves $D/s2.db --links 6 --samples 1500 -j 1 -q && "
           "$P catalogue nearest $D/s.db examples/walking-foot.csv --results 9 > $D/1 && $P catalogue nearest $D/s2.db "
           "examples/walking-foot.csv --results 9 | cmp - $D/1 && cat $D/1", 0, ", point on link ", "1500 of 1500 samples");
    expect("$P catalogue nearest $D/s.db examples/letter-s.csv --json --results 3 > $D/six.json && "
           "$P draw $D/six.json --result 3 -o $D/six.svg && $P catalogue add $D/s.db $D/six.json && "
           "$P catalogue query $D/s.db links=6 --list linkages -f csv | wc -l", 0, "4\n", "3 added");
    expect("$P fit examples/letter-s.csv --unlimited --start-from $D/six.json --links 6 --budget 2000 --rounds 1 --timing none", 0, NULL, NULL);
    expect("$P catalogue curves $D/s.db --links 7 --samples 10", 2, NULL, "four, six or eight links");
    expect("$P catalogue curves $D/s.db --links 6 --type all --samples 10", 2, NULL, "--type is for four links");
}

TEST(add)
{
    expect("$P catalogue add $D/l.db examples/jansen.json && $P catalogue add $D/l.db examples/slider-crank.json", 0, "", "1 added");
    expect("$P catalogue add $D/l.db examples/jansen.json", 0, "", "1 linkages read, 0 added");
    expect("$P fit examples/ellipse.csv --unlimited --rounds 1 --starts 32 --quiet --results 2 --json > $D/fit.json; "
           "cat $D/fit.json $D/near.json | $P catalogue add $D/l.db -", 0, "", " 7 added");
    expect("$P catalogue add $D/l.db $D/fit.json", 0, "", "2 linkages read, 0 added");
    expect("echo '{\"a\": 1}' > $D/bad.json; $P catalogue add $D/l.db $D/bad.json", 3, NULL,
           "bad.json:1: this is neither a linkage");
    expect("printf '\\n\\n{\"results\": [}' > $D/bad.json; $P catalogue add $D/l.db $D/bad.json", 3, NULL,
           "bad.json:3:");
    expect("printf '\\n{\"results\": [{\"linkage\": {\"joints\": 5}}]}' > $D/bad.json; $P catalogue add $D/l.db "
           "$D/bad.json", 3, NULL, "bad.json:2: ");
    expect("$P catalogue check $D/l.db", 0, NULL, "whole");
    expect_row("$P catalogue query $D/l.db 'name~Jansen' --columns links,dof,kinds,closed", "links|dof|kinds|closed", "8|1|rrrrrrrrrr|1");
}

TEST(query)
{
    expect("$P catalogue build $D/q.db --links 8 && $P catalogue query $D/q.db 'symmetry=12'", 0, "Gr`KAC", NULL);
    expect("$P catalogue query $D/q.db 'links=8' --format csv --columns links,assortment | tail -1", 0, "8,4 4\r\n", NULL);
    expect("$P catalogue query $D/q.db 'links=8 and assortment=\"4 4\"' --json | wc -l", 0, "9\n", NULL);
    expect("$P catalogue query $D/q.db 'highest=3' --list mechanisms --sort modes --results 1", 0, "III3:", NULL);
    expect("$P catalogue query $D/q.db --list structures --format csv | wc -l", 0, "5\n", NULL);
    expect("$P catalogue query $D/q.db 'links=9'", 1, NULL, NULL);
    expect("$P catalogue query $D/q.db 'links=9 nad planar'", 3, NULL, "query:1:9:");
    expect("$P catalogue query $D/q.db --fields", 0, "transmission_min", NULL);
    expect("$P catalogue query $D/q.db 'SELECT count(*) AS n FROM ground' --sql --json", 0, "{\"n\":71}\n", NULL);
    expect("$P catalogue query $D/q.db \"ATTACH '$D/x' AS x\" --sql", 3, NULL, "nothing else");
    expect("$P catalogue query $D/q.db 'SELECT nothing FROM chain' --sql", 3, NULL, "SQL:1:8:");
    expect("$P catalogue query $D/q.db 'SELECT 1; DELETE FROM chain' --sql; $P catalogue query $D/q.db 'SELECT "
           "count(*) FROM chain' --sql", 0, "16", "one SELECT");
    expect("$P catalogue query $D/q.db 'WITH RECURSIVE x(a) AS (SELECT 1 UNION ALL SELECT a+1 FROM x) SELECT count(*) "
           "FROM x' --sql --time 1e-9", 5, NULL, NULL);
    /* control characters of a row do not reach the terminal */
    expect("$P catalogue add $D/l.db examples/jansen.json; python3 -c 'import sqlite3, sys\n"
           "with sqlite3.connect(sys.argv[1]) as db: db.execute(\"UPDATE linkage SET name = ?\", (\"J\\x1b[31mansen\",))' $D/l.db; "
           "$P catalogue query $D/l.db 'name~ansen and name~31' --columns name | tail -1", 0,
           "J?[31mansen", NULL);
    expect("sed \"s/Jansen leg/x'); DROP TABLE chain; --/\" examples/jansen.json > $D/drop.json; $P catalogue add "
           "$D/l.db $D/drop.json; $P catalogue query $D/l.db \"name=\\\"x'); DROP TABLE chain; --\\\"\" --columns id | "
           "wc -l", 0, "2\n", NULL);
}

/* The class of a mechanism of more than four links is that of its driven four-bar. */
TEST(a_class_of_six_links)
{
    expect("$P catalogue add $D/six.db tests/data/linkages/six-link-results.json && $P catalogue add $D/six.db examples/hoeken.json; "
           "$P catalogue query $D/six.db 'links=6 and sliders>=1 and class=GCRR and error<0.01' -f csv "
           "--columns links,dof,sliders,class,error,error_max,name", 0,
           "\n6,1,1,GCRR,0.005,0.00125,crank-rocker that drives a slider\r\n", NULL);
    expect("$P catalogue query $D/six.db 'links=6 and class=GCRR and error<0.004'", 1, NULL, NULL);
    expect("$P catalogue query $D/six.db 'error_max=1mm..1.3mm and not class=GRCR'", 0, "crank-rocker that", NULL);
    expect("$P catalogue query $D/six.db 'links=8..4'", 3, NULL, "query:1:10: nothing lies in a range");
    expect("$P catalogue query $D/six.db 'error<1e400'", 3, NULL, "query:1:7: '1e400' is too large a number");
}

TEST(export)
{
    expect("$P catalogue export $D/q.db | sort > $D/a; $P chains --links 8 | sort | cmp - $D/a && echo same", 0, "same\n", NULL);
    expect("$P catalogue export $D/q.db --list mechanisms | sort > $D/a; $P mechanisms --links 8 --input ground | sort "
           "| cmp - $D/a && echo same", 0, "same\n", NULL);
    expect("$P catalogue export $D/q.db --format lem", 2, NULL, "none of table|json|csv|graph6");
    expect("$P catalogue export $D/l.db --list linkages > $D/l.jsonl; $P catalogue add $D/l2.db $D/l.jsonl && "
           "$P catalogue export $D/l2.db --list linkages | cmp - $D/l.jsonl && echo same", 0, "same\n", "added");
    expect("$P catalogue export $D/q.db 'loops=3' --list structures", 3, NULL, "listed by query");
}

TEST(killed_adds)
{
    expect("mkdir $D/killed && $P catalogue nearest $D/c.db examples/ellipse.csv --results 150 --json -o $D/killed/many.json",
           0, NULL, NULL);
    kill_at_random("x.db", "catalogue add x.db many.json --commit 0.005", 12, "linkage|");
}

TEST(killed_curves)
{
    kill_at_random("y.db", "catalogue curves y.db --links 4 --samples 8000", 6, "sweep|");
}

/* A full disk, and a damaged file. */
TEST(damaged_atlases)
{
    expect("trap '' XFSZ; ulimit -f 300; $P catalogue curves $D/full.db --samples 20000", 3, NULL, "full.db: ");
    expect("$P catalogue curves $D/full.db --samples 20000 && $P catalogue check $D/full.db", 0, NULL, "whole");
    for (int at = 90000; at < 400000; at += 30011) {
        expect_with(0, NULL, NULL, "cp $D/c.db $D/wild.db; printf '\\377\\001\\377\\377\\377' | dd of=$D/wild.db bs=1 "
                    "seek=%d conv=notrunc 2>&-; $P catalogue nearest $D/wild.db examples/ellipse.csv > "
                    "/dev/null; c=$?; [ $c = 0 ] || [ $c = 3 ]", at);
    }
}

static void execute(const char *file, const char *sql)
{
    char path[200];
    sqlite3 *db;
    snprintf(path, sizeof path, "%s/%s", temporary_folder(), file);
    CHECK_INT(sqlite3_open(path, &db), SQLITE_OK);
    CHECK_INT(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}

/* Nobody gets hundreds of megabytes of pages by mistake. */
TEST(too_many_pages)
{
    expect("cp $D/q.db $D/big.db", 0, NULL, NULL);
    execute("big.db", "UPDATE chain SET grounds = 2000");
    expect("$P catalogue html $D/big.db -o $D/big; c=$?; test ! -e $D/big && exit $c", 2, NULL,
           "16 chains make about 211 MB of pages: --results 1000 takes the first thousand");
    expect("$P catalogue html $D/big.db -o $D/big --results 3 && ls $D/big | wc -l", 0, "4\n", "4 pages");
}

/* `catalogue check` finds content that is wrong although the SQLite file is whole, and other commands that meet it
 * report it. */
TEST(lies)
{
    static const struct { const char *sql, *says; } lie[] = {
        { "UPDATE chain SET graph6 = 'G]`H?c' WHERE id = 3", "1 of 16 chains are not what their label says" },
        { "UPDATE chain SET links = 7 WHERE id = 3", "1 of 16 chains" },
        { "PRAGMA foreign_keys=OFF; DELETE FROM ground WHERE chain = 5", "have not all their ground links" },
        { "DELETE FROM mechanism WHERE chain = 5", "have no input" },
        { "UPDATE chain SET structure = 2 WHERE structure = 3", "wrong structure" },
        { "PRAGMA foreign_keys=OFF; DELETE FROM run", "points to a row that is not there" },
        { "PRAGMA foreign_keys=OFF; DELETE FROM mechanism WHERE chain = 9; DELETE FROM ground WHERE chain = 9; "
          "DELETE FROM chain WHERE id = 9", "of a finished build are missing" },
    };
    for (size_t i = 0; i < sizeof lie/sizeof *lie; i++) {
        expect("cp $D/q.db $D/lie.db", 0, NULL, NULL);
        execute("lie.db", lie[i].sql);
        expect("$P catalogue check $D/lie.db", 3, NULL, lie[i].says);
    }
    expect("cp $D/c.db $D/lie.db", 0, NULL, NULL);
    execute("lie.db", "DELETE FROM curve_block WHERE id = 3");
    expect("$P catalogue check $D/lie.db", 3, NULL, "segments of curves lack blocks");
    execute("lie.db", "DELETE FROM curve_block");
    expect("$P catalogue nearest $D/lie.db examples/ellipse.csv", 3, NULL, "is not what its box says");
    execute("lie.db", "UPDATE sweep SET families = 'flying carpet'");
    expect("$P catalogue nearest $D/lie.db examples/ellipse.csv", 3, NULL, "no family 'flying carpet'");
    execute("lie.db", "UPDATE curve_segment SET boxes = zeroblob(1000)");
    expect("$P catalogue nearest $D/lie.db examples/ellipse.csv; c=$?; [ $c = 3 ] || [ $c = 1 ]", 0, NULL, NULL);
    expect("cp $D/l.db $D/lie.db", 0, NULL, NULL);
    execute("lie.db", "UPDATE linkage SET json = '{}', curve = zeroblob(7)");
    expect("$P catalogue export $D/lie.db --list linkages", 3, NULL, "a linkage that is none");
    expect("$P catalogue nearest $D/lie.db examples/ellipse.csv; c=$?; [ $c = 3 ] || [ $c = 1 ]", 0, NULL, NULL);
    expect("cp $D/q.db $D/lie.db", 0, NULL, NULL);
    execute("lie.db", "UPDATE mechanism SET kinds = 'zzz' WHERE id = 2");
    expect("$P catalogue export $D/lie.db --list mechanisms", 3, NULL, "row 2 has joints");
    /* a trigger or a view planted in the file cannot run a function */
    execute("lie.db", "CREATE TRIGGER planted AFTER INSERT ON run BEGIN SELECT load_extension('/tmp/x'); END");
    expect("$P catalogue build $D/lie.db --links 4", 3, NULL, "lie.db: ");
}
