#!/usr/bin/env bash
# Tests view --beside: each part of the picture is that of the side shown there, as a viewer with those options alone
# shows it; the divider, keys, picking, a second model, scans, budgets.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"
export XDG_CACHE_HOME="$FOLDER/cache"

# A narrow window has no panels. The picture in eight parts of 50 pixels, without their edges, where the divider may be, and below the sides' names.
WIDTH=400 HEIGHT=300
VIEW=(--size ${WIDTH}x$HEIGHT --eye 0,0,4 --look 0,0,0 --up 0,1,0 --fovy 45)
SETTINGS=(--threshold 2 --shade normal)

# Prints the checksum of each part.
parts() {
    python3 - "$screen" $SCREEN_WIDTH <<'PY'
import struct, sys, zlib
data, width = open(sys.argv[1], "rb").read(), int(sys.argv[2])
begin = struct.unpack_from(">I", data)[0] + 12 * struct.unpack_from(">I", data, 76)[0]
for x in range(0, 400, 50):
    rows = (begin + 4 * (y * width + x) for y in range(40, 300))
    print(zlib.crc32(b"".join(data[row + 40:row + 160] for row in rows)))
PY
}
# Remembers the parts that a viewer with these arguments alone shows, as number $1.
remember() { # number arguments
    local number=$1
    shift
    open_viewer "$@" || return
    rest_sum >/dev/null
    mapfile -t "alone$number" < <(parts)
    expect_kill_by_key q
}
# Prints for each part whose it is: 12 means that it is the same in both.
sides() {
    local now i text=
    mapfile -t now < <(parts)
    for i in {0..7}; do
        [ "${now[i]}" = "${alone1[i]}" ] && text+=1
        [ "${now[i]}" = "${alone2[i]}" ] && text+=2
        text+=.
    done
    echo "$text"
}
sides_are() { [ "$(sides)" = "$1" ]; }
expect_sides() { wait_for 60 sides_are "$1" || fail "$2: the parts are $(sides), expected $1"; }

open_viewer() { # arguments
    rm -rf "$XDG_STATE_HOME"
    run_viewer "$@" "${VIEW[@]}" || return 1
    xdotool mousemove 60 200
}
drag() { # from to
    xdotool mousemove "$1" 100 sleep 0.2 mousedown 1 mousemove $((($1 + $2) / 2)) 110 mousemove "$2" 120 mouseup 1
}

# The model's picture is empty in the outer parts.
test_settings() {
    remember 1 ball.stipple
    remember 2 ball.stipple "${SETTINGS[@]}"
    open_viewer ball.stipple --beside "${SETTINGS[*]}" || return
    expect_sides 12.12.1.1.2.2.12.12. "at first"
    drag 202 302
    expect_sides 12.12.1.1.1.1.12.12. "the divider at 300"
    press comma comma comma comma comma
    expect_sides 12.12.1.1.2.2.12.12. "five commas"
    press period comma comma comma comma comma comma
    expect_sides 12.12.2.2.2.2.12.12. "a point and six commas"
    drag 100 200
    expect_sides 12.12.1.1.2.2.12.12. "the divider at 200"
    press v
    expect_sides 12.12.1.1.1.1.12.12. "v: left alone"
    expect_title "ball.stipple (left)" "left alone"
    press v
    expect_sides 12.12.2.2.2.2.12.12. "v: right alone"
    expect_title "ball.stipple (right)" "right alone"
    press y
    expect_sides 12.12.1.1.1.1.12.12. "y: the other one"
    press v
    expect_sides 12.12.2.2.1.1.12.12. "v: both, swapped"
    press y
    expect_sides 12.12.1.1.2.2.12.12. "y again"
    xdotool windowsize --sync "$window" 200 200
    expect_title " points" "a small window"
    xdotool windowsize --sync "$window" $WIDTH $HEIGHT
    expect_sides 12.12.1.1.2.2.12.12. "the window's size"
    press p
    wait_for 60 test -s "$FOLDER/ball-1.png" || fail "p makes no picture"
    expect_sides 12.12.1.1.2.2.12.12. "after a picture"
    # What is alike is changed on both sides, what is not on the side under the cursor.
    press_at 300 150 r
    press s
    expect_title "ball.stipple (right): " "keys at the right"
    expect_title "threshold 2 px, auto (" "keys at the right"
    expect_title "), box, depth" "keys at the right"
    press_at 100 150 minus
    expect_title "ball.stipple (left): " "a key at the left"
    expect_title "), box, phong" "a key at the left"
    expect_title "threshold 2 px" "a key at the left"
    press plus
    press_at 300 150 k
    expect_title "threshold 1 px" "a key at the right, where both were alike"
    expect_title "depth, eye-dome" k
    expect_kill_by_key q
    [ ! -s "$FOLDER/err" ] || fail "messages: $(head -3 "$FOLDER/err")"
}

# At y = 75 is only the ball, at y = 150 the ring, too.
test_models() {
    remember 1 ball.stipple --threshold 2
    remember 2 "a ring.stipple"
    open_viewer ball.stipple --threshold 2 --beside "a ring.stipple --threshold 1" || return
    drag 200 250
    expect_sides 12.12.1.1.1.2.12.12. "two models"
    press_at 270 75 f # the ball is not shown here
    expect_title "a ring.stipple (right): " "f beside the ring"
    press_at 270 150 f
    expect_title ", marks: 1 (0 hidden)" "f on the ring"
    press_at 180 75 f
    expect_title "ball.stipple (left): " "f on the ball"
    expect_title ", marks: 2 (0 hidden)" "f on the ball"
    [ -s "$FOLDER/ball.stipple.marks.json" ] || fail "no file of marks"
    [ ! -e "$FOLDER/a ring.stipple.marks.json" ] || fail "the marks went to the second model"
    expect_kill_by_key q
}
press_at() { # x y key
    xdotool mousemove "$1" "$2" sleep 0.3
    press "$3"
}

# Both sides show a coarse model first. The scan is prepared once: the second side takes what the first one keeps.
test_scan() {
    local kept
    "$STIPPLE" gen sphere -n 300000 -o "$FOLDER/scan.ply" --quiet
    open_viewer scan.ply --beside "--shade normal" || return
    expect_title "scan.ply (left): " "a scan"
    expect_no_title coarse "a prepared scan"
    kept=$(find "$FOLDER/cache" -name '*.stipple' -printf '%i %f')
    xdotool mousemove 300 150 click 1
    expect_title "scan.ply (right): " "a click at the right"
    expect_no_title coarse "a scan that the first side prepared"
    wait_for 30 is_still
    [ "$(find "$FOLDER/cache" -name '*.stipple' -printf '%i %f')" = "$kept" ] || fail "the scan was prepared twice"
    expect_kill_by_key q
}

test_failures() {
    local least text
    run "$STIPPLE" view "$FOLDER/ball.stipple" --gpu-memory 1
    expect_failure "or more"
    least=$(grep -o 'memory [0-9]*M' "$FOLDER/err" | cut -d' ' -f2)
    open_viewer ball.stipple --gpu-memory "$least" || return
    expect_kill_by_key q
    run timeout 60 "$STIPPLE" view "$FOLDER/ball.stipple" --gpu-memory "$least" --beside "--lod cpu"
    expect_failure "or more, for each of the sides" # each has half
    run "$STIPPLE" view "$FOLDER/ball.stipple" --beside "$FOLDER/no file.stipple --lod cpu"
    expect_failure "no file.stipple: "
    run "$STIPPLE" view "$FOLDER/ball.stipple" --beside "--where gps_time>3"
    expect_failure "gps_time"
    for text in "--lod gpu" "--eye 1,2,3" "--gpu-memory 1G" "--exaggerate 2" "--shade 'unlit" "a b --aa 2"; do
        run "$STIPPLE" view "$FOLDER/ball.stipple" --beside "$text"
        expect_usage "stipple view"
    done
    run "$STIPPLE" view "$FOLDER/ball.stipple" --beside
    expect_usage "--beside needs a value"
    "$STIPPLE" view "$FOLDER/ball.stipple" --beside --help >"$FOLDER/out" || fail "--beside --help fails"
    grep -q -- '--reconstruct' "$FOLDER/out" || fail "--beside --help lacks --reconstruct"
    grep -q -- '--eye' "$FOLDER/out" && fail "--beside --help lists a camera"
}

start_display 640 480
for shape in ball:sphere "a ring:torus"; do
    "$STIPPLE" gen "${shape#*:}" -n 20000 -o "$FOLDER/${shape%:*}.ply" --quiet &&
        "$STIPPLE" prep "$FOLDER/${shape%:*}.ply" -o "$FOLDER/${shape%:*}.stipple" --quiet || fail "no model"
done
test_settings
test_models
test_scan
test_failures
end_test
