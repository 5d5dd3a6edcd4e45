# shellcheck shell=bash disable=SC2034
# Helpers of the script tests; source it with the stipple program's path as $1.
# A failed check is printed and counted; end_test gives the exit code.
STIPPLE=${1:-${STIPPLE:-}}
SOURCE=${STIPPLE_SOURCE:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)}
FOLDER=$(mktemp -d)
trap 'rm -rf "$FOLDER"' EXIT
failures=0

# Whether all is tried, as in long runs, not a sample: tests/CMakeLists.txt gives --every as $2.
every=${2:-}
is_long() { [ "$every" = --every ]; }

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

# As grep -q, but reads to the end: grep -q ends at the first match, and a program that still writes
# into the pipe would fail by SIGPIPE.
found() { [ "$(grep -c "$@")" != 0 ]; }

field() { # number of a field in $FOLDER/stats.json, as --stats writes it
    sed -n "s/.*\"$1\":[[:space:]]*\([0-9.e+-]*\).*/\1/p; T; q" "$FOLDER/stats.json"
}

# Numbers of pixels of a PNG of 8-bit RGBA that are covered in part, and in whole.
alphas() { # picture
    python3 - "$1" <<'END'
import struct, sys, zlib
data, at, packed = open(sys.argv[1], "rb").read(), 8, b""
while at < len(data):
    size, kind = struct.unpack(">I4s", data[at:at + 8])
    body = data[at + 8:at + 8 + size]
    if kind == b"IHDR":
        width, height, depth, colours = struct.unpack(">IIBB", body[:10])
        assert (depth, colours) == (8, 6)
    packed += body if kind == b"IDAT" else b""
    at += 12 + size
raw, row, counts = zlib.decompress(packed), bytearray(4 * width), [0] * 256
for y in range(height):
    line = raw[y * (4 * width + 1):(y + 1) * (4 * width + 1)]
    above, row = row, bytearray(4 * width)
    for x in range(3, 4 * width, 4): # only alphas are undone
        a, b, c = row[x - 4] if x > 3 else 0, above[x], above[x - 4] if x > 3 else 0
        near = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
        row[x] = line[x + 1] + (0, a, b, (a + b) // 2, near)[line[0]] & 255
        counts[row[x]] += 1
print(sum(counts[1:255]), counts[255])
END
}

# The picture's outline is covered in part (smooth) or has only pixels of alpha 0 and 255 (hard).
expect_outline() { # picture, smooth or hard
    local part whole
    command -v python3 >/dev/null || return 0
    read -r part whole < <(alphas "$1")
    [ "${whole:-0}" -gt 0 ] || fail "$command: nothing of $1 is covered"
    if [ "$2" = smooth ]; then
        [ "${part:-0}" -gt 10 ] || fail "$command: ${part:-no} pixels of $1 are covered in part"
    else
        [ "${part:-1}" = 0 ] || fail "$command: ${part:-no} pixels of $1 are covered in part"
    fi
}

expect_code() {
    [ "$code" = "$1" ] || fail "$command: exit $code, expected $1: $(head -3 "$FOLDER/err")"
}

expect_empty() { # out or err
    [ ! -s "$FOLDER/$1" ] || fail "$command: std$1 is not empty: $(head -3 "$FOLDER/$1")"
}

# A program that is started costs a hundredth of a second in a virtual machine, and these are called thousands of times.
expect_lines() { # out or err, number
    local text
    IFS= read -rd '' text <"$FOLDER/$1"
    text=${text//[!$'\n']/}
    [ ${#text} = "$2" ] || fail "$command: ${#text} lines on std$1, expected $2: $(head -3 "$FOLDER/$1")"
}

expect_text() { # out or err, a fixed text in it
    local text
    IFS= read -rd '' text <"$FOLDER/$1"
    [[ $text == *"$2"* ]] || fail "$command: no '$2' on std$1: $(head -3 "$FOLDER/$1")"
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
