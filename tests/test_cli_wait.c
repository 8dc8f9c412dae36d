/* test_cli_wait.c - commands that wait for standard input say so on a terminal, and a signal ends them at once. */
#include "tests/cli_run.h"

/* A pipe into which nobody writes is held open for an hour; the command must end before. The signal is sent until
 * it arrives, because the shell starts a background command with Ctrl-C ignored. */
#define WAITING(command, signal) \
    "mkfifo $D/pipe; sleep 3600 > $D/pipe & s=$!; " command " < $D/pipe & p=$!; " \
    "while kill -" signal " $p; do sleep 0.05; done; wait $p; c=$?; " \
    "kill $s && echo still held; rm $D/pipe; exit $c"

TEST(signals)
{
    expect(WAITING("$P trace -", "TERM"), 143, "still held\n", NULL);
    expect(WAITING("$P mechanisms", "TERM"), 143, "still held\n", NULL);
    expect(WAITING("$P fit - -o $D/found.json", "TERM"), 143, "still held\n", NULL);
    expect(WAITING("$P grammar parse", "INT"), 130, "still held\n", NULL);
    expect("ls -A $D | grep -c tmp", 1, "0", NULL);
}

TEST(terminals)
{
    OWN(ran) r = run("command -v script");
    if (r.code == 0) {
        expect("script -qec \"$P trace -\" $D/typed < /dev/null; cat $D/typed", 0, "waiting for a linkage", NULL);
        expect("script -qec \"$P chains --links 6\" $D/typed < /dev/null; grep -c waiting $D/typed", 1, "0", NULL);
        expect("script -qec \"$P grammar parse\" $D/typed < /dev/null; cat $D/typed", 0, "waiting for chains", NULL);
    }
    ran_free(&r);
    r = run("$P trace - ");
    CHECK(!strstr(r.err, "waiting"));
}
