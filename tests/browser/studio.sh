#!/usr/bin/env bash
# The studio in a real browser.   tests/browser/studio.sh LINKWRIGHT [long] [FOLDER FOR PICTURES]
# Skipped, with a word, where there is no Chromium or Node.
set -eu
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
for need in "${chromium:-chromium}" node; do
    command -v "$need" > /dev/null || { echo "skipped, there is no $need (Debian: chromium, nodejs)"; echo "test_studio_page: 0 passed, 0 failed"; exit 0; }
done
# under the address sanitizer freed memory counts as used until it leaves the quarantine: a small one, so that growth is seen
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}quarantine_size_mb=4:thread_local_quarantine_size_kb=64"
[ "${2:-short}" != long ] || node "$(dirname "$0")/wire.mjs" "$1"
if [ "${2:-short}" = long ]; then                 # in Firefox too; with pen, two fingers and phone width in Chromium alone
    firefox=$(command -v firefox-esr || command -v firefox || true)
    if [ -n "$firefox" ]; then echo "in $firefox:"; node "$(dirname "$0")/studio.mjs" "$1" "$firefox" short; else
        echo "skipped in Firefox: there is none (Debian: firefox-esr)"; fi
fi
exec node "$(dirname "$0")/studio.mjs" "$1" "$chromium" "${2:-short}" ${3:+"$3"}
