#!/usr/bin/env bash
# Run test programs, two more at a time than there are processors, since some wait, and add up their results.
#     tests/run.sh PROGRAM...
# The last line of a program is "<name>: N passed, M failed".  A program counts as failed if it crashes, prints no such
# line, leaves a file in its folder for temporary files, or runs for more than LW_TEST_SECONDS (an hour: only a program
# that hangs runs so long).  The other programs still run.  The very last line is the sum; the exit code is 0 if nothing
# failed.  LW_TEST_TIMES=FILE adds a line to FILE for each program: seconds of the user, of the system, elapsed.
set -u
logs=$(mktemp -d) || exit 1
trap 'rm -rf "$logs"' EXIT

run_one() {
    local log=$1/$(basename "$2") code summary left
    mkdir "$log.tmp"
    TIMEFORMAT="%U %S %R $(basename "$2")"
    { time TMPDIR=$log.tmp timeout "${LW_TEST_SECONDS:-3600}" "$2" > "$log" 2>&1; } 2>> "${LW_TEST_TIMES:-/dev/null}"
    code=$?
    left=$(ls -A "$log.tmp")
    rm -rf "$log.tmp"
    summary=$(tail -n 1 "$log" | grep -E '^[^ ]+: [0-9]+ passed, [0-9]+ failed$')
    if [ -z "$summary" ] || [ -n "$left" ] || { [ $code -ne 0 ] && [[ $summary == *", 0 failed" ]]; }; then
        summary="$(basename "$2"): 0 passed, 1 failed"
        echo "ended with exit code $code${left:+, left behind: $left}" >> "$log"
    fi
    if [[ $summary == *", 0 failed" ]]; then echo "$summary"; else
        { cat "$log"; echo "$summary"; } >&2
    fi
    echo "$summary" > "$log.sum"
}
export PATH=/usr/bin:$PATH       # python3 of the system: those of version managers take ten times as long to start
export LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0
export -f run_one

printf '%s\0' "$@" | xargs -0 -r -n 1 -P "$(($(nproc) + 2))" bash -c 'run_one "$0" "$1"' "$logs"
cat "$logs"/*.sum 2>/dev/null | awk '
    { passed += $2; failed += $4 }
    END { printf "%d passed, %d failed\n", passed, failed; exit failed > 0 || passed == 0 }'
