#!/usr/bin/env bash
# Every command and option that a page of the documentation shows exists in the program, and the README of each folder names its
# files, `weighting_search` also as `weighting`, `_search`.  $1: the program.
set -u
cd "$(dirname "$0")/.."
program=${1:-build/linkwright}
bad=0
declare -A help
while IFS= read -r line; do
    place=${line%%	*}
    words=${line#*	}
    command=$(awk '{ print $2 }' <<< "$words")
    [ -n "$command" ] && [[ $command =~ ^[a-z]+$ ]] || continue
    action=$(awk '{ print $3 }' <<< "$words")
    key=$command
    case $command in catalogue|grammar|bench|drive|family) key="$command $action" ;; help) continue ;; esac
    if [ -z "${help[$key]+known}" ]; then
        help[$key]=$($program help $key 2> /dev/null || $program help $command 2> /dev/null || echo none)
    fi
    if [ "${help[$key]}" = none ]; then
        echo "$place: linkwright $key: no such command"
        bad=1
        continue
    fi
    for option in $(grep -oE -- ' --[a-z][a-z-]*' <<< "$words"); do
        grep -qE -- "(^|[ ,])$option([ ,=]|\$)" <<< "${help[$key]}" ||
            { echo "$place: $key has no option $option"; bad=1; }
    done
done < <(grep -nE '^ +(\$ )?linkwright [a-z]|\| linkwright [a-z]|`linkwright [a-z]' README.md docs/*.md examples/README.md |
         sed -E 's/^([^:]*:[0-9]*):/\1\t/' |
         awk -F'\t' '{ n = split($2, part, "linkwright "); for (i = 2; i <= n; i++) {
             s = part[i]; sub(/[|#`].*/, "", s); sub(/ ([a-z]+)? *\(.*$/, "", s); print $1 "\tlinkwright " s } }')
for file in $(find base grammar enumerate mbs optimise catalogues surface -name '*.c'); do
    name=$(basename "$file" .c)
    readme=$(dirname "$file")/README.md
    [ -e "$readme" ] || readme=$(dirname "$(dirname "$file")")/README.md
    grep -qw "$name" "$readme" || { grep -q "${name%_*}" "$readme" && grep -q "_${name##*_}" "$readme"; } ||
        { echo "$readme does not name $name"; bad=1; }
done
[ $bad -eq 0 ] && echo "docs: fine"
exit $bad
