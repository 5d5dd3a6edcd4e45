#!/usr/bin/env bash
# Tests frames of a depth camera that stands still: many patches lie on each square of pixels.
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
end_test
