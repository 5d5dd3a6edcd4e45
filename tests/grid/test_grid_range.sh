#!/usr/bin/env bash
# Tests what prep makes of heights that few samples have: one spike, up or down, of a plain is not what the first view is
# chosen by; a number at either end that many samples have and that lies far from all others is told, as zeros of a depth
# image are; the sea is not.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# Heights of 120 x 90: an expression of column i and row j.
heights() {
    awk 'BEGIN {
        printf "ncols 120\nnrows 90\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
        for (j = 0; j < 90; j++) {
            for (i = 0; i < 120; i++)
                printf "%s ", '"$1"'
            printf "\n"
        }
    }'
}
plain='sprintf("%.2f", 3 * sin(i / 9) * cos(j / 8))'
model() { # name, heights
    heights "$2" >"$FOLDER/$1.asc"
    run "$STIPPLE" prep --force -o "$FOLDER/$1.stipple" "$FOLDER/$1.asc"
    expect_code 0
    cp "$FOLDER/err" "$FOLDER/$1.err"
    run "$STIPPLE" info --json "$FOLDER/$1.stipple"
}
quiet() { # name
    grep -q "first view\|heights are exactly\|differ by" "$FOLDER/$1.err" && fail "$1: $(cat "$FOLDER/$1.err")"
    grep -q first_view "$FOLDER/out" && fail "$1: the first view is not of all"
}

model plain "$plain"
quiet plain
for spike in 3000 -32000; do
    model spike "i == 40 && j == 50 ? $spike : $plain"
    grep -q '"why":[[:space:]]*"main"' "$FOLDER/out" || fail "spike of $spike: the plain is a speck"
    grep -q "first view of all but what lies far away" "$FOLDER/spike.err" || fail "spike of $spike: not told"
    grep -q "differ by" "$FOLDER/spike.err" && fail "spike of $spike: taken for depths"
done
model tower "i == 40 && j == 50 ? 300 : $plain" # in a picture of both the plain is no speck
quiet tower
model sea "i < 60 ? 0 : $plain + 3"
quiet sea
model zeros "i % 9 == 0 ? 0 : 900 + i / 2"
grep -q "zeros.asc: 12 % of its heights are exactly 0, far from all others" "$FOLDER/zeros.err" || fail "zeros are not told"
model ends "i % 9 == 0 ? 0 : i % 9 == 4 ? 65535 : 900 + i"
grep -q "12 % of its heights are exactly 0, 11 % of its heights are exactly 65535" "$FOLDER/ends.err" || fail "ends are not told"
run "$STIPPLE" prep --force -o "$FOLDER/none.stipple" "$FOLDER/zeros.asc" --invalid 0
grep -q "heights are exactly" "$FOLDER/err" && fail "zeros are told where they are no samples"
end_test
