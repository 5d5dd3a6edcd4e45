#!/usr/bin/env bash
# Tests several inputs of which each would be sound alone: frames of a depth camera that stands still, so that many
# patches lie on each square of pixels; scans of which one has a single point; points of which some have normals.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

frames=()
for k in $(seq 12); do
    awk 'BEGIN { printf "P2\n72 40\n65535\n"
        for (j = 0; j < 40; j++)
            for (i = 0; i < 72; i++)
                print int(1100 + 60 * sin(i / 9) + 40 * cos(j / 7)) }' >"$FOLDER/d$k.pgm"
    frames+=("$FOLDER/d$k.pgm")
done
run "$STIPPLE" prep "${frames[@]}" --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "$FOLDER/m.stipple"
expect_code 0
expect_text err "34560 points read, 34560 stored, 0 rejected"
run "$STIPPLE" verify "$FOLDER/m.stipple"
expect_code 0

# Depth images of one small scene with noise, holes, and deeper stripes: discs merged from pixels of two
# depths may lie outside the box of their patch.
frames=()
for k in 1 2 3; do # stripes 2, 2 and 3 pixels wide, 2, 3 and 4 times as deep
    awk -v k=$k 'function random() { seed = (seed * 16807) % 2147483647; return seed / 2147483647 }
        BEGIN { seed = 1000 + k * 7919
            split("0.1 0.4 0.5", holes)
            print "P2\n80 60\n65535"
            for (j = 0; j < 60; j++)
                for (i = 0; i < 80; i++) {
                    z = int(1100 + 60 * sin(i / 9) + 40 * cos(j / 7) + 5 * random())
                    print random() < holes[k] ? 0 : int(i / (k < 3 ? 2 : 3)) % 2 ? (k + 1) * z : z } }' >"$FOLDER/deep$k.pgm"
    frames+=("$FOLDER/deep$k.pgm")
done
run "$STIPPLE" prep "${frames[@]}" --pinhole 60,60,39.5,29.5 --height-scale 0.001 -o "$FOLDER/m.stipple" --force
expect_code 0
run "$STIPPLE" verify "$FOLDER/m.stipple"
expect_code 0

# A scan of 40 x 30 pixels, and one in which a single pixel has a point.
scan() { # number of the only pixel, or -1
    awk -v only="$1" 'BEGIN { print "40\n30\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1"
        for (i = 0; i < 40; i++)
            for (j = 0; j < 30; j++)
                if (only >= 0 && i * 30 + j != only)
                    print "0 0 0 0.5"
                else
                    printf "%.5f %.5f %.5f 0.5\n", 2, (i - 19.5) * 0.04, (j - 14.5) * 0.04 }'
}
for only in 600 610; do
    { scan -1; scan $only; } >"$FOLDER/scans.ptx"
    for holes in keep grow; do
        run "$STIPPLE" prep "$FOLDER/scans.ptx" --grid --holes $holes -o "$FOLDER/m.stipple" --force
        expect_code 0
        run "$STIPPLE" verify "$FOLDER/m.stipple"
        expect_code 0
    done
done

# A ball, whose normals are told only for its upper half.
ball() { # sign of z, normals or not
    awk -v up="$1" -v told="$2" 'BEGIN { for (i = 0; i < 1500; i++) {
        z = up * (i + 0.5) / 1500
        x = sqrt(1 - z * z) * cos(2.4 * i)
        y = sqrt(1 - z * z) * sin(2.4 * i)
        printf told ? "%.6f %.6f %.6f %.6f %.6f %.6f\n" : "%.6f %.6f %.6f\n", x, y, z, x, y, z } }'
}
{ echo "x y z nx ny nz" && ball 1 1; } >"$FOLDER/upper.txt"
ball -1 0 >"$FOLDER/lower.xyz"
run "$STIPPLE" prep "$FOLDER/upper.txt" "$FOLDER/lower.xyz" -o "$FOLDER/m.stipple" --force
expect_code 0
run "$STIPPLE" verify "$FOLDER/m.stipple"
expect_code 0
end_test
