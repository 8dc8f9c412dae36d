/* test_cli_disk.c - full disks: each file is complete or not there. */
#include <stdbool.h>
#include "tests/cli_run.h"

/* Run the script in a file system of one mebibyte that is mounted for this command only. $T is the source tree; the
 * function "full" fills the disk. */
#define ON_SMALL_DISK(script) \
    "T=$PWD P=$(realpath $P); export T P; mkdir -p $D/disk; unshare -rm sh -c 'mount -t tmpfs -o size=1m none " \
    "$D/disk; cd $D/disk; full() { head -c 2M /dev/zero > fill; }; end() { echo code $?; ls; echo end; }; " \
    "check() { cd $T && $P catalogue check $D/disk/a.db; }; " \
    script "' 2> $D/said; code=$?; grep -v head: $D/said >&2; exit $code"

static bool permitted(void)
{
    OWN(ran) r = run(ON_SMALL_DISK("touch mounted"));
    bool may = r.code == 0 && r.err[0] == 0;
    if (!may)
        printf("left out: mounting a small file system of one's own is not permitted here\n");
    return may;
}

/* What was committed stays, without journal and lock; a new file that never held anything is removed. */
static void catalogues(void)
{
    expect(ON_SMALL_DISK("$P catalogue curves a.db --samples 100000 -q; end; check"), 0,
           "code 3\na.db\nend\n", "the disk is full; what was committed before is kept");
    expect(ON_SMALL_DISK("$P catalogue build a.db --links 6 -q && full; $P catalogue build a.db --links 10 -q; end; "
                         "rm fill; check"), 0, "code 3\na.db\nfill\nend\n", "disk is full");
    expect(ON_SMALL_DISK("$P catalogue build a.db --links 6 -q && full; "
                         "$P catalogue add a.db $T/examples/jansen.json; end; rm fill; check"), 0,
           "code 3\na.db\nfill\nend\n", "disk is full");
    expect(ON_SMALL_DISK("full; $P catalogue build a.db --links 6; end"), 0, "code 3\nfill\nend\n", "disk is full");
}

/* Each file is complete or not there. */
static void other_files(void)
{
    expect(ON_SMALL_DISK("$P catalogue build a.db --links 8 -q; full; $P catalogue html a.db -o p; echo code $?; "
                         "for f in p/*; do test ! -e $f || tail -c 8 $f | grep -q html || echo half $f; done; echo e"),
           0, "code 3\ne\n", "no space left");
    expect(ON_SMALL_DISK("$P catalogue build a.db --links 8 -q; full; $P catalogue export a.db -o x; echo code $?; "
                         "$P catalogue query a.db -f csv -o x; end"), 0, "code 3\ncode 3\na.db\nfill\nend\n",
           "x: cannot be written: no space left");
    expect(ON_SMALL_DISK("$P catalogue build a.db --links 8 -q; full; $P catalogue export a.db > out; end"), 0,
           "code 3\n", "standard output: cannot be written: no space left");
    expect(ON_SMALL_DISK("full; echo begin; for f in svg png gif pdf html; do $P draw $T/examples/jansen.json -o x.$f; "
                         "test $? = 3 || echo $f; done; for f in dxf csv xml; do "
                         "$P convert $T/examples/jansen.json -o x.$f; test $? = 3 || echo $f; done; ls; echo end"),
           0, "begin\nfill\nend\n", "x.svg: cannot be written");
}

CHECK_MAIN
{
    if (permitted()) {
        RUN(catalogues);
        RUN(other_files);
    }
    return check_end();
}
