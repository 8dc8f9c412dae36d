#!/usr/bin/env bash
# Run test programs, two and more at a time, and add up what they say.
#     tests/run.sh PROGRAM...
# A program prints "<name>: N passed, M failed" as its last line.  One that crashes, hangs for five
# minutes or says nothing counts as failed; the others still run.  The very last line is the sum,
# and the exit code tells whether anything failed.
set -u
logs=$(mktemp -d) || exit 1
trap 'rm -rf "$logs"' EXIT

run_one() {
    local log=$1/$(basename "$2") code summary
    timeout 300 "$2" > "$log" 2>&1
    code=$?
    summary=$(tail -n 1 "$log" | grep -E '^[^ ]+: [0-9]+ passed, [0-9]+ failed$')
    if [ -z "$summary" ] || { [ $code -ne 0 ] && [[ $summary == *", 0 failed" ]]; }; then
        summary="$(basename "$2"): 0 passed, 1 failed"
        echo "ended with exit code $code" >> "$log"
    fi
    if [[ $summary == *", 0 failed" ]]; then echo "$summary"; else
        { cat "$log"; echo "$summary"; } >&2
    fi
    echo "$summary" > "$log.sum"
}
export LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0
export -f run_one

printf '%s\0' "$@" | xargs -0 -r -n 1 -P "$(nproc)" bash -c 'run_one "$0" "$1"' "$logs"
cat "$logs"/*.sum 2>/dev/null | awk '
    { passed += $2; failed += $4 }
    END { printf "%d passed, %d failed\n", passed, failed; exit failed > 0 || passed == 0 }'
