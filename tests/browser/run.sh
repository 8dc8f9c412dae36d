#!/usr/bin/env bash
# The atlas in real browsers: make browser-test.   tests/browser/run.sh BUILD [FOLDER]
# Without FOLDER on the pages of tests/test_atlas_html.c.  What is missing (Chromium, Firefox, Node, npm) is skipped, with a word.
set -eu
build=$1
here=$(dirname "$0")
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
firefox=$(command -v firefox-esr || command -v firefox || true)
command -v node > /dev/null || { echo "browser: skipped, there is no node (Debian: nodejs)"; exit 0; }
mkdir -p "$build/browser"
real=$build/browser/real
rm -rf "$real" "$real.db"
for links in 4 6 8; do "$build/linkwright" catalogue build "$real.db" --links $links --multiple-joints --quiet; done
"$build/linkwright" catalogue build "$real.db" --links 6 --joints r,t --quiet
"$build/linkwright" catalogue html "$real.db" -o "$real" --quiet
[ -z "$firefox" ] || node "$here/atlas_search.mjs" "$real" "$firefox"
for need in "${chromium:-chromium}" npm; do
    command -v "$need" > /dev/null || { echo "browser: skipped, there is no $need (Debian: chromium, npm)"; exit 0; }
done
node "$here/atlas_search.mjs" "$real" "$chromium"
cp "$here"/package.json "$here"/atlas.mjs "$build/browser"
[ -d "$build/browser/node_modules/playwright-core" ] \
    || npm --prefix "$build/browser" install --no-audit --no-fund --silent \
    || { echo "browser: skipped, playwright-core cannot be installed from the npm registry"; exit 0; }
folder=${2:-$build/browser/atlas}
if [ $# -lt 2 ]; then
    rm -rf "$folder" "$folder-blocks"
    LW_ATLAS_FOLDER=$folder "$build/tests/test_atlas_html"
fi
"$build/linkwright" draw examples/space/bricard.json -o "$build/browser/bricard.html" --force --quiet
blocks=$folder-blocks
[ -d "$blocks" ] || blocks=
node "$build/browser/atlas.mjs" "$folder" "$chromium" "$real" "$build/browser/bricard.html" "$blocks"
