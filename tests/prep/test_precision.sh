#!/usr/bin/env bash
# Tests how far stored points are from the points read. prep, its figures, the file and info must
# say it. If the distance exceeds the scan's resolution, prep must say what to do.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
model="$FOLDER/m.stipple"

# A square of 20 m in millimetres; with far=1, points kilometres around it too.
survey() {
    awk -v far="$1" 'BEGIN {
        for (i = 0; i < 4000; i++) printf "%.3f %.3f %.3f\n", i % 63 * 0.317, int(i / 63) * 0.313, i % 7 * 0.011
        for (i = 0; i < 40 * far; i++) printf "%.3f %.3f %.3f\n", i * 711.123 % 9001, i * i * 377.421 % 9001, i % 9 * 33.017
    }' >"$2"
}
survey 0 "$FOLDER/near.xyz"
survey 1 "$FOLDER/far.xyz"

# of_stats KEY: prints this key of "displacement".
of_stats() {
    sed -n "/\"displacement\"/,/}/s/.*\"$1\":[[:space:]]*\([0-9.e+-]*\).*/\1/p" "$FOLDER/stats.json"
}
holds() { # an expression of awk
    awk "BEGIN { exit !($1) }" || fail "$command: $1"
}
prepared() {
    run "$STIPPLE" prep "$@" -o "$model" --force --stats "$FOLDER/stats.json"
    expect_code 0
    expect_text err "stored positions are off by at most "
    for key in greatest mean beyond changed; do
        [ -n "$(of_stats $key)" ] || fail "$*: stats without displacement.$key"
    done
    "$STIPPLE" verify "$model" --quiet || fail "$*: verify"
    "$STIPPLE" info "$model" >"$FOLDER/info"
    grep -q '^displacement   of stored points: .* at most, .* on average' "$FOLDER/info" || fail "$*: info"
    "$STIPPLE" info "$model" --json >"$FOLDER/info.json"
    [ "$(grep -c '"displacement":' "$FOLDER/info.json")" = 2 ] || fail "$*: info --json, its own and metadata's"
}

prepared "$FOLDER/near.xyz"
holds "$(of_stats greatest) <= 0.0005 && $(of_stats mean) > 0 && $(of_stats beyond) == 0"
grep -q 'off by more than' "$FOLDER/err" && fail "a remark where nothing is lost"
prepared "$FOLDER/far.xyz"
holds "$(of_stats greatest) > 0.001 && $(of_stats beyond) > 0"
expect_text err "of them are off by more than 0.0005, half the input's own scale"
expect_text err "give --precision exact"
grep -q 'are farther off than the input resolves' "$FOLDER/info" || fail "info: points beyond"
prepared "$FOLDER/far.xyz" --precision 0.0001
expect_text err "of them are off by more than 0.0001, the precision given"
# A scale far below the distance between points, as some programs give LAS: no advice that would shrink every disc.
prepared "$FOLDER/near.xyz" --precision 1e-9
expect_text err "of them are off by more than 1e-09, the precision given: that is so far below the distance"
grep -q 'give --precision exact' "$FOLDER/err" && fail "advice for outliers where all points are off"
prepared "$FOLDER/far.xyz" --precision exact
holds "$(of_stats greatest) <= 0.0005 && $(of_stats changed) == 0 && $(of_stats beyond) == 0"
expect_text err "every stored position rounds to the very number that was read"
grep -q '"exact":[[:space:]]*true' "$FOLDER/info.json" || fail "metadata: exact"
# Exported numbers must be those of the file.
"$STIPPLE" export "$model" -o "$FOLDER/out.ply" --quiet
head -c 300 "$FOLDER/out.ply" | found -a 'property double x' || fail "export: floats for millimetres over kilometres"
# A grid of heights: exact is no finer, so prep must not advise it.
awk 'BEGIN { print "ncols 60\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 500"
    for (i = 0; i < 3000; i++) printf "%.6f%s", sin(i * 0.1) * 400 + cos(i / 60), i % 60 == 59 ? "\n" : " " }' >"$FOLDER/grid.asc"
prepared "$FOLDER/grid.asc" --precision 0.000001
holds "$(of_stats greatest) > 0.000001 && $(of_stats beyond) > 0"
expect_text err "off by more than 1e-06, the precision given: a grid's samples lie too far apart for finer steps, also with --precision exact"
finest=$(of_stats greatest)
prepared "$FOLDER/grid.asc" --precision exact
holds "$(of_stats greatest) >= $finest"
# Doubles of sixteen digits have more bits than a patch can store, and prep must say so.
awk 'BEGIN { for (i = 0; i < 3000; i++) printf "%.15f %.15f %.15f\n", sin(i), cos(i), sin(i * 0.7) }' >"$FOLDER/digits.xyz"
prepared "$FOLDER/digits.xyz" --precision exact
expect_text err "stored positions do not round to the very numbers that were read"

for length in 0 -1 1mm exactly; do
    run "$STIPPLE" prep "$FOLDER/near.xyz" -o "$FOLDER/new.stipple" --precision="$length"
    expect_failure "--precision $length: give a positive length, or exact"
done

# No scale or precision is so coarse that the file could not say its error.
for place in '0 0 0' '3 4 5'; do
    printf '%s\n%s\n' "$place" "$place" >"$FOLDER/place.xyz"
    prepared "$FOLDER/place.xyz" --precision 1e29
done

# Joining overlapping scans moves points: the distance must be reported, stored and bounded.
"$STIPPLE" gen sphere -n 20000 --noise 0.5 -o "$FOLDER/noisy.ply" --quiet
prepared "$FOLDER/noisy.ply" --layers joined
expect_text err "layers are joined: points were moved by at most "
grep -q '^layers         joined: points were moved by .* at most, .* on average' "$FOLDER/info" || fail "info: joined"
"$STIPPLE" export "$model" -o "$FOLDER/joined.ply" --quiet
[ "$(strings -n 3 "$FOLDER/joined.ply" | grep -m1 'element vertex')" = "element vertex 20000" ] || fail "joined: points"
prepared "$FOLDER/noisy.ply"
grep -q '^layers' "$FOLDER/info" && fail "info: joined without --layers"
run "$STIPPLE" prep "$FOLDER/noisy.ply" -o "$FOLDER/none.stipple" --layers joined --precision exact
expect_code 2
expect_text err "--layers joined moves points, --precision exact keeps them"

# For a scan with noisy normals prep must say how to join overlapping scans, but not if they are
# joined already.
awk 'BEGIN {
    srand(1)
    printf "ply\nformat ascii 1.0\nelement vertex 10000\n"
    n = split("x y z nx ny nz", name, " ")
    for (i = 1; i <= n; i++) printf "property float %s\n", name[i]
    printf "end_header\n"
    for (i = 0; i < 10000; i++)
        printf "%d %d 0 %.3f %.3f 1\n", i % 100, i / 100, 0.6 * (rand() - 0.5), 0.6 * (rand() - 0.5)
}' >"$FOLDER/normals.ply"
prepared "$FOLDER/normals.ply"
expect_text err "normals of the input are averaged"
expect_text err "if these are overlapping scans, --layers joined"
prepared "$FOLDER/normals.ply" --layers joined
! grep -q "if these are overlapping scans" "$FOLDER/err" || fail "the hint is given though layers are joined"
end_test
