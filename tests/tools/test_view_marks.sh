#!/usr/bin/env bash
# Tests what the viewer shows of a landscape: marks and their file, labels of contours, exaggerated
# heights, and the profile of a measured line with its files.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"

# From above: the terrain's 200 x 200 units fill the height.
VIEW=(--size 500x400 --eye 0,-60,260 --look 0,0,0 --up 0,0,1 --fovy 45)

open_viewer() { # options
    rm -rf "$XDG_STATE_HOME"
    run_viewer hill.stipple "${VIEW[@]}" "$@" || return 1
    xdotool mousemove 250 200
    sleep 0.6
}
# Prints the coordinates of mark number $2 of a file, or its count.
marks() { # file [number]
    python3 - "$@" <<'PY'
import json, sys
marks = json.load(open(sys.argv[1]))["marks"]
print(len(marks) if len(sys.argv) < 3 else "%.3f %.3f %.3f" % tuple(marks[int(sys.argv[2])]["position"]))
PY
}

# From above, three times as high: labels at rest, a mark with its true height, and the profile of a
# measured line. The window is closed while another profile is made.
test_from_above() {
    local file="$FOLDER/hill.stipple.marks.json"
    open_viewer --contours 2 --exaggerate 3 || return
    expect_title ", heights x 3" --exaggerate
    wait_for 30 has_labels || fail "no labels: $(title)"
    press f
    expect_title ", marks: 1 (0 hidden)" f
    wait_for 30 test -s "$file" || fail "f keeps no mark"
    marks "$file" 0 | awk '{ away = $1 * $1 + $2 * $2; d = $3 - 40 * exp(-away / 1200)
            exit !(away < 3000 && d < 1 && d > -1) }' || fail "the mark is not on the hill: $(marks "$file" 0)"
    xdotool mousemove 5 5
    press f t m # nothing is there to mark, and there is no line yet
    xdotool mousemove 150 200 sleep 0.3 click 1 sleep 0.8 mousemove 350 210 sleep 0.3 click 1
    expect_title " US ft, marks: 1" "two clicks" # the coordinate system's unit
    expect_title ", marks: 1 (" "f beside the model"
    chart_is_gone || fail "a chart before t"
    press t
    wait_for 30 chart_is_there || fail "no chart"
    press Escape
    wait_for 30 chart_is_gone || fail "Esc does not close the chart"
    expect_title measuring "Esc with a chart"
    press t q
    expect_end 0 "q after t"
}
chart_is_there() { [ "$(lit_pixels 14 190 60 200)" -gt 100 ]; }
chart_is_gone() { [ "$(lit_pixels 14 190 60 200)" -lt 100 ]; }
has_labels() { [[ $(title) =~ contours\ \([1-9][0-9]*\ labels\) ]]; }

# From the side: of the marks in the file given one stands before the hill and one behind it. A new
# one goes to that file alone.
test_given_marks() {
    echo '{"marks": [{"name": "near", "position": [0, -90, 0.5]}, {"name": "far", "position": [0, 90, 0.5]}]}' \
        >"$FOLDER/given.json"
    run_viewer hill.stipple --size 500x400 --eye 0,-300,15 --look 0,0,5 --up 0,0,1 --marks given.json || return
    expect_title ", marks: 2 (1 hidden)" "--marks"
    xdotool mousemove 250 190
    sleep 0.6
    press f
    expect_title ", marks: 3 (" "f with --marks"
    [ "$(marks "$FOLDER/given.json")" = 3 ] || fail "--marks: the mark is not in the file given"
    [ "$(marks "$FOLDER/hill.stipple.marks.json")" = 1 ] || fail "--marks: another file changed"
    expect_kill_by_key q
}

test_wrong_marks() {
    echo '{"marks": [{"name": "a"}]}' >"$FOLDER/wrong.json"
    run "$STIPPLE" view "$FOLDER/hill.stipple" --marks "$FOLDER/wrong.json"
    expect_failure 'wrong.json: mark 1 has no "position"'
}

start_display 640 480
python3 - >"$FOLDER/hill.xyz" <<'END'
from math import exp
for i in range(201):
    for j in range(201):
        x, y = i - 100.0, j - 100.0
        print("%g %g %.4f" % (x, y, 40.0 * exp(-(x * x + y * y) / 1200.0)))
END
cat >"$FOLDER/hill.prj" <<'END'
PROJCS["NAD83 / New York Long Island (ftUS)",GEOGCS["NAD83",DATUM["North_American_Datum_1983",
SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],
PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["latitude_of_origin",40.1666666666667],
PARAMETER["central_meridian",-74],PARAMETER["standard_parallel_1",41.0333333333333],
PARAMETER["standard_parallel_2",40.6666666666667],PARAMETER["false_easting",984250],
PARAMETER["false_northing",0],UNIT["US survey foot",0.304800609601219]]
END
"$STIPPLE" prep "$FOLDER/hill.xyz" -o "$FOLDER/hill.stipple" --quiet || fail "no model"
test_from_above
test_given_marks
test_wrong_marks
end_test
