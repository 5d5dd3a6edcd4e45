#!/usr/bin/env bash
# Tests tools/fetch-datasets with file:// addresses: resuming, checks, unpacking, missing files.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
command -v curl >/dev/null || skip_test "curl is not installed"

fetch=$SOURCE/tools/fetch-datasets
remote=$FOLDER/remote
local_="$FOLDER/some folder"
mkdir -p "$remote/inner"
seq 1 20000 >"$remote/plain.xyz"
echo ply >"$remote/inner/scan.ply"
tar -C "$remote" -czf "$remote/packed.tar.gz" inner
gzip -k "$remote/plain.xyz"
xz -k "$remote/plain.xyz" 2>/dev/null || cp "$remote/plain.xyz" "$remote/plain.xyz.xz"
echo damaged >"$remote/damaged.tar.gz"
size=$(stat -c %s "$remote/plain.xyz")
sum=$(sha256sum "$remote/plain.xyz" | cut -d ' ' -f 1)
url=file://$remote
cat >"$FOLDER/list.txt" <<LIST
# name | url | bytes | sha256 or - | licence | points | format

plain   | $url/plain.xyz     | $size | $sum | free | 20,000 | XYZ
unknown | $url/plain.xyz     | -     | -    | free | -      | XYZ
tar     | $url/packed.tar.gz | -     | -    | free | 1      | PLY
gz      | $url/plain.xyz.gz  | -     | -    | free | 1      | XYZ
xz      | $url/plain.xyz.xz  | -     | -    | free | 1      | XYZ
zip     | $url/packed.zip    | -     | -    | free | 1      | PLY
badsum  | $url/plain.xyz     | $size | 00   | free | 1      | XYZ
badsize | $url/plain.xyz     | 7     | -    | free | 1      | XYZ
missing | $url/none.ply      | -     | -    | free | 1      | PLY
damaged | $url/damaged.tar.gz | -    | -    | free | 1      | PLY
LIST

get() {
    run bash "$fetch" --list "$FOLDER/list.txt" -o "$local_" "$@"
}

expect_same() { # file under the folder, the original
    cmp -s "$local_/$1" "$2" || fail "$1 differs from the file offered"
}

expect_no_litter() {
    local left
    left=$(find "$local_" -name '*.part*' 2>/dev/null)
    [ -z "$left" ] || fail "$command: left behind: $left"
}

test_list() {
    run bash "$fetch" --list "$FOLDER/list.txt"
    expect_code 0
    expect_empty err
    expect_lines out 10
    run bash "$fetch"
    expect_code 0
    [ "$(wc -l <"$FOLDER/out")" -ge 10 ] || fail "datasets.txt lists less than ten scans"
    run bash "$fetch" --help
    expect_code 0
    run bash "$fetch" --bogus
    expect_usage "--bogus"
    run bash "$fetch" --list "$FOLDER/none.txt"
    expect_failure "cannot be read"
    get nosuch
    expect_failure "nosuch is not in the list"
}

test_good() {
    get plain unknown tar gz
    expect_code 0
    expect_empty err
    expect_same plain/plain.xyz "$remote/plain.xyz"
    expect_same unknown/plain.xyz "$remote/plain.xyz"
    expect_same tar/inner/scan.ply "$remote/inner/scan.ply"
    expect_same gz/plain.xyz "$remote/plain.xyz"
    get xz
    if command -v xz >/dev/null; then
        expect_code 0
        expect_same xz/plain.xyz "$remote/plain.xyz"
    else
        expect_failure "xz is not installed"
    fi
    expect_no_litter
    get plain
    expect_code 0
    expect_text out "there already"
    if command -v zip >/dev/null && command -v unzip >/dev/null; then
        (cd "$remote" && zip -qr packed.zip inner)
        get zip
        expect_code 0
        expect_same zip/inner/scan.ply "$remote/inner/scan.ply"
    fi
}

# A cut download must continue where it ended. The first half differs from the server's, which shows
# that it was kept.
test_resume() {
    rm -rf "$local_"
    mkdir -p "$local_"
    head -c 5000 "$remote/plain.xyz" | tr 0-9 x >"$local_/unknown.plain.xyz.part"
    get unknown
    expect_code 0
    { head -c 5000 "$remote/plain.xyz" | tr 0-9 x; tail -c +5001 "$remote/plain.xyz"; } >"$FOLDER/want"
    expect_same unknown/plain.xyz "$FOLDER/want"
    head -c 5000 "$remote/plain.xyz" >"$local_/plain.plain.xyz.part"
    get plain
    expect_code 0
    expect_same plain/plain.xyz "$remote/plain.xyz"
    rm -rf "$local_/plain"
    cp "$remote/plain.xyz" "$local_/plain.plain.xyz.part"
    get plain
    expect_code 0
    rm -rf "$local_/plain"
    cat "$remote/plain.xyz" "$remote/plain.xyz" >"$local_/plain.plain.xyz.part"
    get plain
    expect_code 0
    expect_same plain/plain.xyz "$remote/plain.xyz"
    expect_no_litter
}

test_bad() {
    rm -rf "$local_"
    for name in badsum:sha256 badsize:"instead of 7" missing:"could not be fetched" \
        damaged:"could not be unpacked"; do
        get "${name%%:*}"
        expect_code 1
        expect_lines err 1
        expect_text err "${name#*:}"
        [ ! -e "$local_/${name%%:*}" ] || fail "$name was kept in spite of its fault"
        expect_no_litter
    done
    : >"$FOLDER/file"
    run bash "$fetch" --list "$FOLDER/list.txt" -o "$FOLDER/file/x" plain
    expect_code 1
    expect_text err "cannot be made"
}

# The project's own list must have seven columns, unique names, and plausible addresses and numbers.
test_rows() {
    local bad
    bad=$(grep -vE '^\s*(#|$)' "$SOURCE/datasets.txt" |
        awk -F ' *[|] *' 'NF != 7 || $1 !~ /^[a-z0-9-]+$/ || seen[$1]++ || $2 !~ /^https?:\/\// ||
            $3 !~ /^([0-9]+|-)$/ ||
            ($4 != "-" && (length($4) != 64 || $4 ~ /[^0-9a-f]/)) || $5 == "" || $7 == ""')
    [ -z "$bad" ] || fail "datasets.txt has wrong rows: $bad"
}

test_list
test_good
test_resume
test_bad
test_rows
end_test
