#!/usr/bin/env bash
# Every header compiles alone, all in one unit, and linkwright.h also as C++ and without any other of our headers.
#     tests/check_headers.sh COMPILER-FLAGS...
set -u
cd "$(dirname "$0")/.."
unit=$(mktemp -d) || exit 1
trap 'rm -rf "$unit"' EXIT
bad=0
rooms='base grammar enumerate mbs optimise catalogues surface'
headers="linkwright.h $(find $rooms -name '*.h' | grep -vE 'mbs/batch/kernel_|mbs/space/kernel_vec')"

for h in $headers; do echo "#include \"$h\""; done > "$unit/all.c"
for h in $headers; do echo "#include \"$h\"" > "$unit/$(tr / + <<< "$h").c"; done
# unused static functions are what a header of inline functions has
clang -std=c17 -fsyntax-only -Werror -Wno-unused-function "$@" "$unit"/*.c || bad=1

cp linkwright.h "$unit"
printf '#include <linkwright.h>\n#include <linkwright.h>\nint main() { return lw_version() == 0; }\n' > "$unit/one.cc"
for compiler in clang++ g++; do
    command -v $compiler > /dev/null || continue
    $compiler -Wall -Wextra -pedantic -Werror -fsyntax-only -I"$unit" "$unit/one.cc" || bad=1
done
[ $bad -eq 0 ] && echo "headers: fine"
exit $bad
