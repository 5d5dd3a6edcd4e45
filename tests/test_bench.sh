#!/usr/bin/env bash
# stipple-bench: needs libstipple alone, and prints one table.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/support/shell.sh"

bench=$(dirname "$STIPPLE")/stipple-bench
[ -x "$bench" ] || skip_test "built without the renderer"

if ldd "$bench" | grep -E 'OpenImageIO|OpenMesh|libglfw'; then
    fail "stipple-bench needs more than libstipple"
fi
run "$bench" --help
expect_code 0
expect_text out "usage: stipple-bench"
run "$bench"
expect_usage "try stipple-bench --help"
run "$bench" "$FOLDER/none.stipple"
expect_failure "none.stipple"
run "$bench" --repeat 0 "$FOLDER/none.stipple"
expect_usage "--repeat"

"$STIPPLE" gen sphere -n 5000 -o "$FOLDER/scan.ply" --quiet &&
    "$STIPPLE" prep "$FOLDER/scan.ply" -o "$FOLDER/model.stipple" --quiet || fail "no model"
run "$bench" "$FOLDER/model.stipple" --size 64x48 --repeat 2
expect_code 0
expect_empty err
expect_text out "5000 points"
expect_text out "64x48, 2 rounds"
# Every road drew something in some time; a coarser threshold draws no more.
awk '
    /^(points|full|geometry|cpu) / {
        n = NF; rows++
        if ($(n - 2) + 0 <= 0 || $(n - 8) + 0 <= 0) { print "bad row: " $0; bad = 1 }
        if ($1 == before && $(n - 2) + 0 > drawn) { print "more drawn: " $0; bad = 1 }
        before = $1; drawn = $(n - 2) + 0
        if ($1 == "points" ? drawn != 5000 : drawn > 5000) { print "not as many: " $0; bad = 1 }
    }
    END { exit bad || rows != 8 }' "$FOLDER/out" >"$FOLDER/bad" ||
    fail "the table: $(cat "$FOLDER/bad" "$FOLDER/out")"

# The first picture: every stage once, and something is in it.
run "$bench" "$FOLDER/model.stipple" --first --size 64x48
expect_code 0
expect_empty err
stages=$(awk '{ printf "%s ", $1 } $1 == "covered" && $2 < 1 { print "nothing" }' "$FOLDER/out")
[ "$stages" = "begun process context open root draw frame points covered " ] ||
    fail "the first picture: $stages"
run "$bench" "$FOLDER/none.stipple" --first
expect_failure "none.stipple"
end_test
