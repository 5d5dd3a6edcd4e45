#!/usr/bin/env bash
# Tests prep of a depth camera's points without a word of the camera: they are seen from the origin,
# upright, and face it; the same points elsewhere are not.
set -uo pipefail
source "$(dirname "$0")/../support/shell.sh"

frame() # SHIFT: a floor and a wall, z forward and y down
{
    awk -v shift="$1" 'BEGIN {
        for (row = -60; row < 60; row++)
            for (column = -80; column < 80; column++) {
                u = column / 130; v = row / 130
                z = v > 0.3 ? 1.2 / v : 4 - u
                printf "%.6f %.6f %.6f\n", u * z + shift, v * z, z
            }
    }'
}
frame 0 >"$FOLDER/own.xyz"
frame 0.7 >"$FOLDER/other.xyz"
run "$STIPPLE" prep "$FOLDER/own.xyz" -o "$FOLDER/own.stipple"
expect_code 0
expect_text err "orientation from the scanner's position"
run "$STIPPLE" info "$FOLDER/own.stipple"
expect_text out "from 0 0 0: where the scanner was"
run "$STIPPLE" info --json "$FOLDER/own.stipple"
tr -d ' \t\n' <"$FOLDER/out" | grep -q '"up":\[0,-1,0\],"first_view"' ||
    fail "y points down there, also where the whole is seen"
run "$STIPPLE" prep "$FOLDER/other.xyz" -o "$FOLDER/other.stipple"
expect_code 0
grep -q scanner "$FOLDER/err" && fail "a scanner was found where there was none"
end_test
