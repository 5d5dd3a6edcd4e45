#!/usr/bin/env bash
# Tests profile: on a plane given as a grid, the table has exactly the samples near the line, in order,
# at their heights; the chart has a dot for each, in well-formed XML. Wrong requests get a sentence and
# leave no file.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# z = 5 + x / 2 + y / 4 with columns 2 apart; one sample is none.
awk 'BEGIN {
    print "ncols 60\nnrows 40\nxllcenter 100\nyllcenter 500\ncellsize 2\nNODATA_value -1"
    for (row = 39; row >= 0; row--)
        for (column = 0; column < 60; column++) {
            z = 5 + (100 + 2 * column) / 2 + (500 + 2 * row) / 4
            printf "%s%s", row == 20 && column == 30 ? -1 : z, column < 59 ? " " : "\n"
        }
}' >"$FOLDER/plane.asc"
model=$FOLDER/plane.stipple
"$STIPPLE" prep "$FOLDER/plane.asc" -o "$model" --precision exact --quiet || fail "no model"

# The samples at most width / 2 from the segment: distance x y z, by distance.
expected() { # x0 y0 x1 y1 width
    awk -v x0="$1" -v y0="$2" -v x1="$3" -v y1="$4" -v width="$5" 'BEGIN {
        length_ = sqrt((x1 - x0)^2 + (y1 - y0)^2); ux = (x1 - x0) / length_; uy = (y1 - y0) / length_
        for (row = 0; row < 40; row++) for (column = 0; column < 60; column++) {
            x = 100 + 2 * column; y = 500 + 2 * row
            along = (x - x0) * ux + (y - y0) * uy; off = (y - y0) * ux - (x - x0) * uy
            beyond = along < 0 ? -along : along > length_ ? along - length_ : 0
            if (sqrt(off^2 + beyond^2) > width / 2 || (row == 20 && column == 30)) continue
            if (beyond > 0) along = along < 0 ? 0 : length_
            printf "%.4f %.4f %.4f %.4f\n", along, x, y, 5 + x / 2 + y / 4
        }
    }' | sort -n -k1,1 -k4,4
}

check_line() { # x0 y0 x1 y1 width
    run "$STIPPLE" profile "$model" --line "$1,$2,$3,$4" --width "$5" -o "$FOLDER/p.csv" --force
    [ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
    [ "$(head -1 "$FOLDER/p.csv")" = distance,x,y,z,r,g,b ] || fail "$command: $(head -1 "$FOLDER/p.csv")"
    tail -n +2 "$FOLDER/p.csv" | awk -F, '{ printf "%.4f %.4f %.4f %.4f\n", $1, $2, $3, $4 }' >"$FOLDER/found"
    sort -s -c -n -k1,1 "$FOLDER/found" 2>/dev/null || fail "$command: not by distance"
    diff <(expected "$@") <(sort -n -k1,1 -k4,4 "$FOLDER/found") >/dev/null ||
        fail "$command: $(wc -l <"$FOLDER/found") points, $(expected "$@" | wc -l) expected"
    run "$STIPPLE" profile "$model" --line "$1,$2,$3,$4" --width "$5" -o "$FOLDER/p.svg" --force -q
    [ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
    python3 - "$FOLDER/p.svg" "$(sort -u -k1,1 -k4,4 "$FOLDER/found" | wc -l)" <<'END' || fail "$command: the chart"
import sys
import xml.etree.ElementTree as tree
dots = tree.parse(sys.argv[1]).getroot().findall("{http://www.w3.org/2000/svg}circle")
sys.exit(not 0.9 * int(sys.argv[2]) <= len(dots) <= int(sys.argv[2]))
END
}
check_line 100 500 218 578 3
check_line 218 520 100 520 0.5
check_line 130 498 130 600 4.5
check_line 150 540 151 540 9

# With a condition: the points of the profile that fulfil it, also by an attribute. Without one, none is read.
awk 'BEGIN { print "x,y,z,line"; for (i = 0; i < 4000; i++) print i % 80, int(i / 80), i % 7, i % 5 }' >"$FOLDER/lines.csv"
run "$STIPPLE" prep "$FOLDER/lines.csv" -o "$FOLDER/lines.stipple" --attributes all --precision exact --quiet
expect_code 0
run "$STIPPLE" profile "$FOLDER/lines.stipple" --line 0,20,79,20 --width 0.5 -o "$FOLDER/all.csv" -q
expect_code 0
run "$STIPPLE" profile "$FOLDER/lines.stipple" --line 0,20,79,20 --width 0.5 -o "$FOLDER/some.csv" -q --where 'line==3 && z>2'
expect_code 0
diff <(awk -F, 'NR == 1 || ((20 * 80 + $2) % 5 == 3 && $4 > 2)' "$FOLDER/all.csv") "$FOLDER/some.csv" >/dev/null ||
    fail "$command: $(wc -l <"$FOLDER/some.csv") lines"
[ "$(wc -l <"$FOLDER/some.csv")" -gt 5 ] || fail "$command: no points"
run "$STIPPLE" profile "$FOLDER/lines.stipple" --line 0,20,79,20 -o "$FOLDER/none.csv" --where 'line>7'
expect_failure "no point that fulfils --where"
run "$STIPPLE" profile "$FOLDER/lines.stipple" --line 0,20,79,20 -o "$FOLDER/none.csv" --where 'lime>7'
expect_failure "lime"
[ ! -e "$FOLDER/none.csv" ] || fail "a wrong condition leaves a file"

run "$STIPPLE" profile "$model" --line 100,510,218,510 -o "$FOLDER/usual.csv"
[ "$code" = 0 ] && [ "$(wc -l <"$FOLDER/usual.csv")" -gt 60 ] || fail "$command: $(cat "$FOLDER/err")"
run "$STIPPLE" profile "$model" --line 100,510,218,510 -o "$FOLDER/usual.csv"
expect_failure "exists"
for line in 0,0,1,1 5,5,5,5 1,2,3 1,2,3,4,5 a,b,c,d nan,0,1,1; do
    run "$STIPPLE" profile "$model" --line=$line -o "$FOLDER/none.csv"
    expect_failure "line"
done
run "$STIPPLE" profile "$model" --line 100,510,218,510 -o "$FOLDER/none.txt"
[ "$code" = 2 ] || fail "$command: exit $code"
[ -z "$(find "$FOLDER" -name 'none*')" ] || fail "a failed profile left a file"
end_test
