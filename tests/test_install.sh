#!/usr/bin/env bash
# make install, a program built against what was installed by pkg-config, make uninstall, and nothing left.
#     tests/test_install.sh MAKE-VARIABLES...
set -u
cd "$(dirname "$0")/.."
to=$(mktemp -d) || exit 1
trap 'rm -rf "$to"' EXIT
fail() { echo "install: $1" >&2; exit 1; }
quiet() { "$@" > "$to.log" 2>&1 || { cat "$to.log" >&2; rm -f "$to.log"; fail "$* failed"; }; rm -f "$to.log"; }

at=$to/stage/opt/linkwright
quiet make --no-print-directory "$@" install DESTDIR="$to/stage" PREFIX=/opt/linkwright LIBDIR=/opt/linkwright/lib64
for f in bin/linkwright include/linkwright.h lib64/liblinkwright.so lib64/liblinkwright.a lib64/pkgconfig/linkwright.pc \
         share/man/man1/linkwright.1 share/bash-completion/completions/linkwright share/linkwright/linkage.schema.json \
         share/doc/linkwright/docs/notation.md share/doc/linkwright/examples/jansen.json; do
    [ -e "$at/$f" ] || fail "$f is missing"
done
[ "$(grep -c '^LW_API' "$at/share/doc/linkwright/docs/library.md")" = "$(grep -c '^LW_API' linkwright.h)" ] || fail "the library's reference lacks functions"
[ "$(find "$at/include" -type f | wc -l)" = 1 ] || fail "more than one header"
"$at/bin/linkwright" help | grep -q "$at/share/doc/linkwright" || fail "help does not name the installed documents"
"$at/bin/linkwright" -V | grep -q "^linkwright [0-9]" || fail "-V says no version"
bash -n "$at/share/bash-completion/completions/linkwright" || fail "bash does not take its completion"

export PKG_CONFIG_PATH=$at/lib64/pkgconfig PKG_CONFIG_SYSROOT_DIR=$to/stage
flags=$(pkg-config --cflags --libs linkwright) || fail "pkg-config does not know it"
quiet ${CC:-cc} -I"$at/include" docs/examples/chains.c -L"$at/lib64" $flags -o "$to/shared"
LD_LIBRARY_PATH=$at/lib64 quiet "$to/shared"
unset PKG_CONFIG_SYSROOT_DIR
quiet ${CC:-cc} -I"$at/include" docs/examples/chains.c "$at/lib64/liblinkwright.a" \
    $(pkg-config --static --libs linkwright | sed 's/-L[^ ]*opt[^ ]*//g; s/-llinkwright//g') -o "$to/static"
quiet "$to/static"

quiet make --no-print-directory "$@" uninstall DESTDIR="$to/stage" PREFIX=/opt/linkwright LIBDIR=/opt/linkwright/lib64
left=$(find "$to/stage" ! -type d)
[ -z "$left" ] || fail "left behind: $left"
echo "install: fine"
