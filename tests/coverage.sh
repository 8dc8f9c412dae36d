#!/usr/bin/env bash
# Lines and branches of the library that the tests reach, by room and in all, from a build with --coverage.
#     tests/coverage.sh BUILD-FOLDER
# Kernels are compiled without counters.  A branch is one outcome of a decision in the machine's code, as gcov counts.
set -u
cd "$(dirname "$0")/.."
for room in base grammar enumerate mbs optimise catalogues surface; do
    find "$1/$room" -name '*.gcda' | sort | xargs -r gcov -n -b 2> /dev/null |
        awk -v room="$room/" '
            /^File /              { name = $2; gsub(/\047/, "", name); mine = index(name, room) == 1 && name ~ /[.]c$/ }
            mine && /^Lines/      { split($0, p, /[:% ]+/); lines = p[3] " " p[5] }
            mine && /^Taken/      { split($0, p, /[:% ]+/); print name, lines, p[5], p[7]; mine = 0 }
            mine && /^No branches/ { print name, lines, 100, 0; mine = 0 }'
done | awk '
    { split($1, d, "/"); r = d[1]
      l[r] += $3; hit[r] += $2*$3/100; b[r] += $5; took[r] += $4*$5/100
      printf "%-48s %6.1f %% of %5d lines  %6.1f %% of %5d branches\n", $1, $2, $3, $4, $5 }
    END { for (r in l) { L += l[r]; H += hit[r]; Br += b[r]; T += took[r]
              printf "%-48s %6.1f %% of %5d lines  %6.1f %% of %5d branches\n", r, 100*hit[r]/l[r], l[r], 100*took[r]/(b[r] ? b[r] : 1), b[r] }
          printf "%-48s %6.1f %% of %5d lines  %6.1f %% of %5d branches\n", "all", 100*H/L, L, 100*T/Br, Br }'
