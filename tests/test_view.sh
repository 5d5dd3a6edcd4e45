#!/usr/bin/env bash
# The viewer in a virtual display: keys, mouse, sizes, pictures, ways to end.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/support/shell.sh"

for tool in Xvfb xdotool; do
    command -v $tool >/dev/null || skip_test "$tool is not installed"
done
"$STIPPLE" --help | grep -q '^  view ' || skip_test "built without the renderer"

export XDG_STATE_HOME="$FOLDER/state"
SCREEN_WIDTH=640 SCREEN_HEIGHT=480
screen="$FOLDER/Xvfb_screen0"
viewer=
server=

stop() {
    if [ -n "$viewer" ]; then kill -KILL "$viewer" 2>/dev/null; fi
    if [ -n "$server" ]; then kill "$server" 2>/dev/null && wait "$server" 2>/dev/null; fi
    rm -rf "$FOLDER"
}
trap stop EXIT

start_display() {
    # -noreset: without it the server begins anew, and refuses a viewer, each time the last one leaves
    Xvfb -displayfd 3 -screen 0 ${SCREEN_WIDTH}x${SCREEN_HEIGHT}x24 -fbdir "$FOLDER" -nocursor \
        -noreset -nolisten tcp 3>"$FOLDER/display" 2>"$FOLDER/xvfb.log" &
    server=$!
    for _ in $(seq 100); do
        [ -s "$FOLDER/display" ] && break
        sleep 0.1
    done
    [ -s "$FOLDER/display" ] || skip_test "Xvfb does not start: $(tail -1 "$FOLDER/xvfb.log")"
    DISPLAY=:$(cat "$FOLDER/display")
    export DISPLAY
}

# wait_for SECONDS COMMAND...: until it succeeds.
wait_for() {
    local end=$((SECONDS + $1))
    shift
    until "$@"; do
        [ $SECONDS -lt $end ] || return 1
        sleep 0.1
    done
}

title() { xdotool getwindowname "$window" 2>/dev/null; }
title_has() { [[ $(title) == *"$1"* ]]; }
title_lacks() { [[ $(title) != *"$1"* ]]; }
expect_title() { wait_for 60 title_has "$1" || fail "$2: no '$1' in the title '$(title)'"; }
find_window() {
    window=$(xdotool search --all --onlyvisible --pid "$viewer" --name 'ms, ' 2>/dev/null) &&
        [ -n "$window" ]
}
window_or_end() { find_window || has_ended; }
has_ended() { ! kill -0 "$viewer" 2>/dev/null; }

# The screen as hexadecimal pixels, one a line; Xvfb keeps it as an XWD file.
screen_pixels() {
    local header colours
    header=$(od -An -tu4 --endian=big -N4 "$screen")
    colours=$(od -An -tu4 --endian=big -j76 -N4 "$screen")
    tail -c +$((header + 12 * colours + 1)) "$screen" | od -An -v -tx4 -w4
}
# Pixels that are not black in a rectangle of the screen: x0 y0 x1 y1.
lit_pixels() {
    screen_pixels | awk -v w=$SCREEN_WIDTH -v x0="$1" -v y0="$2" -v x1="$3" -v y1="$4" '
        { i = NR - 1; x = i % w; y = int(i / w) }
        x >= x0 && x < x1 && y >= y0 && y < y1 && substr($1, 3) != "000000" { n++ }
        END { print n + 0 }'
}
screen_sum() { cksum <"$screen"; }
screen_changed() { [ "$(screen_sum)" != "$before" ]; }

open_viewer() { # options
    "$STIPPLE" view "$FOLDER/model.stipple" --size 400x400 "$@" \
        >"$FOLDER/out" 2>"$FOLDER/err" </dev/null &
    viewer=$!
    command="view $*"
    wait_for 60 window_or_end && find_window || { fail "no window: $(head -3 "$FOLDER/err")"; return 1; }
    xdotool windowmove "$window" 0 0 mousemove 200 200 windowfocus --sync "$window"
    # every chunk is there, and the position known to the window
    wait_for 60 is_still || fail "chunks stay missing: $(title)"
}
is_still() { ! title_has missing; }

expect_end() { # exit code, after
    wait_for 30 has_ended || { fail "$2 does not end the viewer"; kill -KILL "$viewer"; }
    wait "$viewer" && code=0 || code=$?
    viewer=
    [ "$code" = "$1" ] || fail "$2: exit $code, expected $1: $(head -3 "$FOLDER/err")"
    expect_empty out
    expect_empty err
}

test_keys() {
    open_viewer || return
    expect_title "model.stipple: " start
    expect_title "threshold 1 px, geometry, gauss, phong" start
    lit=$(lit_pixels 0 0 400 400)
    [ "$lit" -gt 8000 ] || fail "the picture of a sphere has only $lit pixels"
    outside=$(lit_pixels 400 0 640 480)
    [ "$outside" = 0 ] || fail "$outside pixels lit beside the window"
    before=$(screen_sum)
    xdotool key minus
    expect_title "threshold 2 px" minus
    xdotool key plus key plus
    expect_title "threshold 0.5 px" plus
    xdotool key l
    expect_title "px, cpu" l
    xdotool key l
    expect_title "every sample, full" l
    xdotool key shift+l
    expect_title "px, cpu" "shift and l"
    xdotool key r
    expect_title "box" r
    xdotool key shift+r key shift+r
    expect_title "points" "shift and r"
    xdotool key shift+s
    expect_title "confidence" "shift and s"
    xdotool key s key s key s
    expect_title "normal" s
    wait_for 30 screen_changed || fail "normals look like phong"
    xdotool key c # the sphere has neither intensities nor classes
    expect_title "normal, none" c
    xdotool key c
    expect_title "normal, elevation in auto" "c twice"
    before=$(screen_sum)
    xdotool key shift+s key shift+s key g
    expect_title "phong, elevation in grey" g
    wait_for 30 screen_changed || fail "elevation looks like normals"
    xdotool key shift+g key shift+g
    expect_title "elevation in heat" "shift and g"
    xdotool key c
    wait_for 30 title_lacks elevation || fail "c: still elevation"
    expect_kill_by_key q
}

expect_kill_by_key() {
    xdotool key "$1"
    expect_end 0 "key $1"
}

test_mouse() {
    open_viewer --shade normal || return
    local start
    start=$(screen_sum)
    for action in "1" "3" "2"; do
        before=$(screen_sum)
        xdotool mousemove 200 200 mousedown "$action" mousemove 210 205 mousemove 260 230 \
            mouseup "$action"
        wait_for 30 screen_changed || fail "a drag with button $action changes nothing"
        sleep 0.5
    done
    before=$(screen_sum)
    xdotool key h
    wait_for 30 screen_is "$start" || fail "key h does not lead back to the first picture"
    lit=$(lit_pixels 0 0 400 400)
    xdotool mousemove 200 200 click 5 click 5 click 5 click 5
    wait_for 30 fewer_lit "$lit" || fail "the wheel towards the user shows no smaller sphere"
    xdotool key h
    wait_for 30 screen_is "$start" || fail "key h does not undo the wheel"
    xdotool mousemove 200 200 click 4 click 4
    wait_for 30 more_lit "$lit" || fail "the wheel away from the user shows no larger sphere"
    expect_kill_by_key Escape
}
screen_is() { [ "$(screen_sum)" = "$1" ]; }
fewer_lit() { [ "$(lit_pixels 0 0 400 400)" -lt $(($1 * 8 / 10)) ]; }
more_lit() { [ "$(lit_pixels 0 0 400 400)" -gt $(($1 * 12 / 10)) ]; }

test_sizes() {
    open_viewer || return
    lit=$(lit_pixels 0 0 400 400)
    for size in "240 240" "1 1" "301 97" "63 255" "400 400"; do
        # shellcheck disable=SC2086
        xdotool windowsize --sync "$window" $size
        sleep 0.3
        has_ended && { fail "a window of $size ends the viewer: $(head -3 "$FOLDER/err")"; return; }
    done
    wait_for 30 about_lit "$lit" || fail "after resizing the picture is not as at first"
    xdotool windowunmap "$window"
    sleep 0.6
    has_ended && fail "a hidden window ends the viewer"
    xdotool windowmap "$window"
    wait_for 30 about_lit "$lit" || fail "a window shown again is not drawn"
    kill -TERM "$viewer"
    expect_end 0 SIGTERM
}
about_lit() {
    local now
    now=$(lit_pixels 0 0 400 400)
    [ "$now" -gt $(($1 * 9 / 10)) ] && [ "$now" -lt $(($1 * 11 / 10)) ]
}

# A window at rest must not go on drawing: its threads use next to no time.
test_rest() {
    open_viewer || return
    sleep 1
    local used
    used=$(cpu_ticks)
    sleep 2
    used=$(($(cpu_ticks) - used))
    [ "$used" -lt $(($(getconf CLK_TCK) / 2)) ] || fail "at rest for 2 s it worked for $used ticks"
    expect_kill_by_key q
}
cpu_ticks() { awk '{ sub(/.*\) /, ""); print $12 + $13 }' "/proc/$viewer/stat"; }

test_shaders() {
    cp -r "$SOURCE/shaders" "$FOLDER/shaders"
    open_viewer --shaders "$FOLDER/shaders" || return
    before=$(screen_sum)
    # the passes that write the picture make it green
    mapfile -t passes < <(grep -lE '^ *picture = ' "$SOURCE"/shaders/*.frag)
    for name in "${passes[@]}"; do
        sed -E 's/^( *)picture = .*/\1picture = vec4(0.0, 1.0, 0.0, 1.0);/' "$name" >"$FOLDER/saved"
        mv "$FOLDER/saved" "$FOLDER/shaders/${name##*/}"
    done
    wait_for 30 screen_changed || fail "a saved shader is not shown"
    echo "no shader" >>"$FOLDER/shaders/${name##*/}"
    wait_for 30 grep -q "${name##*/}" "$FOLDER/err" || fail "a shader's error is not told"
    has_ended && fail "a wrong shader ends the viewer"
    : >"$FOLDER/err"
    expect_kill_by_key q
}

test_failures() {
    run env -u DISPLAY -u WAYLAND_DISPLAY "$STIPPLE" view "$FOLDER/model.stipple"
    expect_failure "stipple render"
    expect_failure "stipple fly"
    run env MESA_GL_VERSION_OVERRIDE=3.3 "$STIPPLE" view "$FOLDER/model.stipple"
    expect_failure "OpenGL 4.5"
    run "$STIPPLE" view "$FOLDER/none.stipple"
    expect_failure "none.stipple"
    run "$STIPPLE" view --threshold -1 "$FOLDER/model.stipple"
    expect_usage "--threshold"
}

start_display
"$STIPPLE" gen sphere -n 20000 -o "$FOLDER/scan.ply" --quiet &&
    "$STIPPLE" prep "$FOLDER/scan.ply" -o "$FOLDER/model.stipple" --quiet || fail "no model"
test_keys
test_mouse
test_sizes
test_rest
test_shaders
test_failures
end_test
