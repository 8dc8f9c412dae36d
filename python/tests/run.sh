#!/usr/bin/env bash
# Run the tests of the Python package and end with a line as every test program: test_python: N passed, M failed.
#     python/tests/run.sh PYTHON PACKAGE_FOLDER
# Nothing passes or fails where PYTHON lacks cffi, numpy or pytest.
cd "$(dirname "$0")" || exit 1
if ! "$1" -c 'import cffi, numpy, pytest' 2>/dev/null; then
    echo "python3-cffi, python3-numpy or python3-pytest is missing: the package is not tested"
    echo "test_python: 0 passed, 0 failed"
    exit 0
fi
folder=$(mktemp -d) || exit 1
PYTHONPATH=$2 PYTHONDONTWRITEBYTECODE=1 "$1" -m pytest -q --tb=short -p no:cacheprovider --basetemp "$folder/t" . > "$folder/log" 2>&1
code=$?
cat "$folder/log"
count() { grep -oE "[0-9]+ $1" "$folder/log" | tail -n 1 | cut -d' ' -f1; }
passed=$(count passed)
failed=$(( $(count failed || echo 0) + $(count error || echo 0) + 0 ))
rm -rf "$folder"
[ "$code" -eq 0 ] || [ "$failed" -gt 0 ] || failed=1
echo "test_python: ${passed:-0} passed, $failed failed"
exit "$code"
