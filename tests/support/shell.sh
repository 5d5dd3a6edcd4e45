# shellcheck shell=bash disable=SC2034
# Helpers of the script tests; source it with the stipple program's path as $1.
# A failed check is printed and counted; end_test gives the exit code.
STIPPLE=${1:-${STIPPLE:-}}
SOURCE=${STIPPLE_SOURCE:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)}
FOLDER=$(mktemp -d)
trap 'rm -rf "$FOLDER"' EXIT
failures=0

fail() {
    echo "FAILED: $*" >&2
    failures=$((failures + 1))
}

skip_test() {
    echo "skipped: $*"
    exit 77
}

end_test() {
    if [ "$failures" != 0 ]; then
        echo "$failures checks failed" >&2
        exit 1
    fi
    exit 0
}

# run COMMAND...: puts the exit code into $code, stdout and stderr into $FOLDER/out and $FOLDER/err.
run() {
    code=0
    "$@" >"$FOLDER/out" 2>"$FOLDER/err" </dev/null || code=$?
    command="${*##*/}"
}

field() { # number of a field in $FOLDER/stats.json, as --stats writes it
    sed -n "s/.*\"$1\":[[:space:]]*\([0-9.e+-]*\).*/\1/p" "$FOLDER/stats.json" | head -1
}

expect_code() {
    [ "$code" = "$1" ] || fail "$command: exit $code, expected $1: $(head -3 "$FOLDER/err")"
}

expect_empty() { # out or err
    [ ! -s "$FOLDER/$1" ] || fail "$command: std$1 is not empty: $(head -3 "$FOLDER/$1")"
}

expect_lines() { # out or err, number
    local lines
    lines=$(wc -l <"$FOLDER/$1")
    [ "$lines" = "$2" ] || fail "$command: $lines lines on std$1, expected $2: $(head -3 "$FOLDER/$1")"
}

expect_text() { # out or err, a fixed text in it
    grep -qF -- "$2" "$FOLDER/$1" || fail "$command: no '$2' on std$1: $(head -3 "$FOLDER/$1")"
}

# Expects wrong usage: exit 2, nothing on stdout, one line on stderr with the text.
expect_usage() {
    expect_code 2
    expect_empty out
    expect_lines err 1
    expect_text err "$1"
}

# Expects a failure: exit 1, nothing on stdout, one line on stderr with the text.
expect_failure() {
    expect_code 1
    expect_empty out
    expect_lines err 1
    expect_text err "$1"
}
