/* test_cli_studio.c - the command that serves the page: address, port and token of the next run, ends, wrong words. */
#include "tests/cli_run.h"

#define ENV "XDG_STATE_HOME=$D/state XDG_CACHE_HOME=$D/cache "
#define SHORT ENV "$P studio --no-browser --time 0.3 "

TEST(it_prints_its_address_and_ends)
{
    expect(SHORT, 5, "http://127.0.0.1:", "Ctrl-C ends it");
    expect(SHORT "--json --quiet", 5, "{\"address\": \"http://127.0.0.1:", NULL);
    expect(SHORT "examples/jansen.json", 5, "http://127.0.0.1:", NULL);
    expect(ENV "sh -c '$P studio --no-browser > $D/address & sleep 0.5; kill -INT $!; wait $!'", 130, NULL, NULL);
}

TEST(the_next_run_has_the_same_address)
{
    expect(SHORT "> $D/one; " SHORT "> $D/two; cmp $D/one $D/two && stat -c %a $D/state/linkwright/studio", 0, "600", NULL);
    /* a file that others can read, or one with nonsense, is not believed */
    expect("chmod 644 $D/state/linkwright/studio; " SHORT "> $D/two; cmp -s $D/one $D/two", 1, NULL, NULL);
    expect("echo 80 0000 > $D/state/linkwright/studio; " SHORT, 5, "http://127.0.0.1:", NULL);
}

TEST(wrong_words)
{
    expect("$P studio $D/nothing.json --no-browser", 3, NULL, "nothing.json");
    expect("$P studio --no-browser --atlas $D/nothing.db", 3, NULL, "nothing.db");
    expect("$P studio --port 70000", 2, NULL, "port");
    expect("$P studio --no-browser -o $D/x", 2, NULL, "-o does not go with studio");
    expect("$P studio a b", 2, NULL, "one word too many");
    expect(ENV "sh -c '$P studio --no-browser --time 2 > $D/a & sleep 0.7; port=$(sed s/.*:// $D/a | cut -d/ -f1); "
           "$P studio --no-browser --port $port; code=$?; kill $!; wait; exit $code'", 3, NULL, "cannot listen on port");
}
