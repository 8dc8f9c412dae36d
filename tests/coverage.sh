#!/usr/bin/env bash
# Lines and branches of the library that the tests reach, by file, by room and in all, from a build by `make coverage`.
#     tests/coverage.sh BUILD-FOLDER
# Kernels are compiled without counters.  A branch is one outcome of a condition in the source, each operand of && and || alone.
set -u
cd "$(dirname "$0")/.."
llvm-profdata merge -sparse "$1"/profiles/*.profraw -o "$1/all.profdata" || exit 1
llvm-cov report "$1/liblinkwright.so" -instr-profile="$1/all.profdata" | awk -v root="${PWD#/}/" '
    { sub("^" root, "", $1); split($1, d, "/"); r = d[1] }
    $1 ~ /^(base|grammar|enumerate|mbs|optimise|catalogues|surface)\/.*[.]c$/ {
        l[r] += $8; missed[r] += $9; b[r] += $11; untaken[r] += $12; print_row($1, $8, $9, $11, $12) }
    function print_row(name, lines, missed, branches, untaken) {
        printf "%-48s %6.1f %% of %5d lines  %6.1f %% of %5d branches\n", name, 100 - 100*missed/(lines ? lines : 1), lines,
               100 - 100*untaken/(branches ? branches : 1), branches }
    END { n = split("base grammar enumerate mbs optimise catalogues surface", room, " ")
          for (i = 1; i <= n; i++) {
              r = room[i]; L += l[r]; M += missed[r]; B += b[r]; U += untaken[r]; print_row(r, l[r], missed[r], b[r], untaken[r]) }
          print_row("all", L, M, B, U) }'
