#!/usr/bin/env bash
# Tests stipple-bench: it needs libstipple alone and prints one table.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

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
# Every road must draw something in some time; a coarser threshold must not draw more.
awk '
    NF == 0 { exit }
    /^(points|full|geometry|compute|cpu|splat) / {
        n = NF; rows++
        if ($(n - 2) + 0 <= 0 || $(n - 8) + 0 <= 0) { print "bad row: " $0; bad = 1 }
        if ($1 == before && $(n - 2) + 0 > drawn) { print "more drawn: " $0; bad = 1 }
        before = $1; drawn = $(n - 2) + 0
        if ($1 == "points" ? drawn != 5000 : drawn > 5000) { print "not as many: " $0; bad = 1 }
    }
    END { exit bad || rows != 18 }' "$FOLDER/out" >"$FOLDER/bad" ||
    fail "the table: $(cat "$FOLDER/bad" "$FOLDER/out")"
stage_rows=$(sed '1,/^$/d' "$FOLDER/out" | grep -cE '^(points|full|geometry|compute|cpu|splat) ')
[ "$stage_rows" = 18 ] || fail "the GPU's clock: $stage_rows rows: $(cat "$FOLDER/out")"

# Some roads, as CSV. Each stage must have a time, and all stages together may not take longer than
# the whole. The GPU's clock differs from the CPU's, hence 2 % and 0.1 ms.
run "$bench" "$FOLDER/model.stipple" --size 64x48 --repeat 3 --csv --roads compute,full,splat:1
expect_code 0
expect_empty err
awk -F, '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    { rows++; roads[$at["road"] ":" $at["threshold_px"]]++; all = 0 }
    NF < 23 || $NF !~ /"$/ { print "fields: " $0; bad = 1 }
    $at["points"] != 5000 || $at["width"] != 64 || $at["height"] != 48 { print "of what: " $0; bad = 1 }
    {
        for (name in at) if (name ~ /^gpu_/ && name != "gpu_all_ms") all += $at[name]
        waited = $at["project_ms"] + $at["pull_push_ms"] + $at["shade_ms"]
        if (all < $at["gpu_all_ms"] - 0.01 || all > $at["gpu_all_ms"] + 0.01) { print "sum: " $0; bad = 1 }
        if (waited < $at["waited_ms"] - 0.01 || waited > $at["waited_ms"] + 0.01) { print "waits: " $0; bad = 1 }
        if (all > 1.02 * waited + 0.1) { print "GPU longer than waited for: " $0; bad = 1 }
        if ($at["gpu_project_ms"] <= 0 || $at["gpu_resolve_ms"] <= 0 || $at["gpu_finish_ms"] <= 0) timeless++
    }
    # A software driver draws every sample by compute shaders, which list the samples first.
    $at["road"] == "full" && $at["gpu_choose_ms"] > 0 && !/llvmpipe/ { print "no such stage: " $0; bad = 1 }
    $at["road"] == "full" && $at["gpu_blend_ms"] > 0 { print "no such stage: " $0; bad = 1 }
    $at["road"] == "compute" && $at["gpu_blend_ms"] > 0 { print "no such stage: " $0; bad = 1 }
    $at["road"] == "splat" && $at["gpu_pull_ms"] + $at["gpu_push_ms"] > 0 { print "no such stage: " $0; bad = 1 }
    END {
        if (timeless == rows) { print "nothing timed"; bad = 1 }
        for (road in roads) if (roads[road] != 3) { print roads[road] " rounds of " road; bad = 1 }
        exit bad || rows != 18
    }' "$FOLDER/out" >"$FOLDER/bad" || fail "the CSV: $(cat "$FOLDER/bad" "$FOLDER/out")"
# Each road with each reconstruction; bare points and the road of splats have none to choose.
run "$bench" "$FOLDER/model.stipple" --size 64x48 --repeat 1 --csv --roads points,compute:1,splat:1 --reconstruct gauss,box
expect_code 0
expect_empty err
drawn=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    $at["frame_ms"] > 0 { printf "%s:%s ", $at["road"], $at["reconstruct"] }' "$FOLDER/out")
[ "$drawn" = "points:- compute:gauss compute:box splat:splat " ] || fail "reconstructions: $(cat "$FOLDER/out")"
run "$bench" "$FOLDER/model.stipple" --size 64x48 --repeat 1 --roads compute:1 --reconstruct box,template3
expect_code 0
[ "$(grep -cE '^compute 1 px (box|template3) ' "$FOLDER/out")" = 4 ] || fail "names: $(cat "$FOLDER/out")"
for words in gauss,boxes '' gauss,; do
    run "$bench" "$FOLDER/model.stipple" --reconstruct "$words"
    expect_usage "--reconstruct"
done
run "$bench" "$FOLDER/model.stipple" --reconstruct gauss,box,template3 # with all roads more than it can take
expect_usage "at most 32 roads"
run "$bench" "$FOLDER/model.stipple" --roads full,compute:3
expect_usage "--roads"

# The first picture: every stage once, and the picture is not empty.
run "$bench" "$FOLDER/model.stipple" --first --size 64x48
expect_code 0
expect_empty err
stages=$(awk '{ printf "%s ", $1 } $1 == "covered" && $2 < 1 { print "nothing" }' "$FOLDER/out")
[ "$stages" = "begun process context open root draw frame points covered " ] ||
    fail "the first picture: $stages"
run "$bench" "$FOLDER/none.stipple" --first
expect_failure "none.stipple"

# How it streams, as CSV.
run "$bench" "$FOLDER/model.stipple" --open --csv --size 64x48
expect_code 0
expect_empty err
awk -F, '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    $at["ready_s"] <= 0 || $at["first_s"] <= $at["ready_s"] || $at["complete_s"] < $at["first_s"] { bad = 1 }
    $at["complete"] != 1 || $at["bytes"] <= 0 || $at["bytes"] > $at["file_bytes"] { bad = 1 }
    $at["points"] != 5000 || $at["width"] != 64 || $at["height"] != 48 || $NF !~ /"$/ { bad = 1 }
    END { exit bad || NR != 2 }' "$FOLDER/out" || fail "streaming: $(cat "$FOLDER/out")"

# The table of ratios. Topics that draw need stipple-bench alone.
table() { run bash "$SOURCE/tools/bench/table" --output "$FOLDER/ratios" --size 64x48 --memory 256M "$@"; }
mkdir "$FOLDER/alone"
ln -s "$(realpath "$bench")" "$FOLDER/alone/stipple-bench"
cp "$FOLDER/model.stipple" "$FOLDER/larger.stipple"
table --build "$FOLDER/alone" --topics levels,roads,splat,stages,size --repeat 2 \
    --model "$FOLDER/model.stipple" "$FOLDER/larger.stipple"
expect_code 0
expect_empty err
expect_text out "64x48, 2 rounds"
rows_of() { awk -v topic="$1" '$1 == topic' "$FOLDER/out" | wc -l; }
for topic in levels:12 roads:26 splat:8 size:4; do
    [ "$(rows_of "${topic%:*}")" = "${topic#*:}" ] || fail "rows of $topic: $(cat "$FOLDER/out")"
done
[ "$(rows_of stages)" -ge 30 ] || fail "rows of stages: $(cat "$FOLDER/out")"

# The table's files must have this number of rows. Each row has a ratio between its least and its
# greatest, and so has the ratio of the medians. No row may name a folder of this machine.
check_csv() { # topic, rows
    awk -F'","' -v rows="$2" '
        NR == 1 { if (split($0, names, ",") != 14) { print "head: " $0; bad = 1 }; next }
        {
            text = $0
            gsub(/"[^"]*"/, "q", text)
            n = split(text, f, ",")
            if (n != 14 || f[1] !~ /^[0-9]+-[0-9]+-[0-9]+$/ || f[2] f[3] f[4] f[6] f[7] f[14] != "qqqqqq") {
                print "fields: " $0; bad = 1
            }
            if (f[11] < f[12] - 1e-6 || f[11] > f[13] + 1e-6) { print "median: " $0; bad = 1 }
            if (f[9] / f[10] < f[12] * 0.998 || f[9] / f[10] > f[13] * 1.002) { print "ratio: " $0; bad = 1 }
        }
        END { if (NR - 1 != rows) { print NR - 1 " rows"; bad = 1 }; exit bad }' "$FOLDER/ratios/$1.csv" >"$FOLDER/bad" ||
        fail "$1.csv: $(cat "$FOLDER/bad" "$FOLDER/ratios/$1.csv")"
    ! grep -F "$FOLDER" "$FOLDER/ratios/$1.csv" || fail "$1.csv names a folder"
}
for topic in levels roads splat stages size; do check_csv $topic "$(rows_of $topic)"; done
table --build "$FOLDER/alone" --topics splat --repeat 1 "$FOLDER/model.stipple"
expect_code 0
check_csv splat 12

# Codecs and prep have scripts of their own.
table --build "$(dirname "$STIPPLE")" --topics codecs,prep --repeat 1 --sizes 0.005 --shape sphere "$FOLDER/model.stipple"
expect_code 0
check_csv codecs 4
grep -q '"surface / all of prep","sphere",5000,' "$FOLDER/ratios/prep.csv" || fail "prep: $(cat "$FOLDER/out")"
check_csv prep "$(rows_of prep)"
for script in codecs prep-rate; do
    run bash "$SOURCE/tools/bench/$script" --help
    expect_code 0
    expect_text out "tools/bench/$script"
done
table --topics levels,speed "$FOLDER/model.stipple"
expect_code 2
expect_text err "speed"
table --build "$FOLDER/nowhere" "$FOLDER/model.stipple"
expect_code 1
expect_text err "is not there"
end_test
