#!/usr/bin/env bash
# Tests the viewer on a virtual display: keys, mouse, sizes, pictures, ways to end.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"

open_viewer() { # options
    run_viewer model.stipple --size 400x400 "$@" || return 1
    xdotool mousemove 200 200
}

test_keys() {
    open_viewer || return
    expect_title "model.stipple: " start
    expect_title "threshold 1 px, auto (" start
    expect_title "), gauss, phong" start
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
    expect_title "px, geometry, gauss" l
    xdotool key l
    expect_title "px, compute, gauss" l
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
    expect_title "primitive" "shift and s"
    xdotool key s key s key s
    expect_title "unlit" s
    wait_for 30 screen_changed || fail "unlit looks like lambert"
    xdotool key c # the sphere has neither intensities nor classes
    expect_title "unlit, none" c
    xdotool key c
    expect_title "unlit, elevation in auto" "c twice"
    before=$(screen_sum)
    xdotool key shift+s key shift+s key g
    expect_title "phong, elevation in grey" g
    wait_for 30 screen_changed || fail "elevation looks like grey"
    xdotool key shift+g key shift+g
    expect_title "elevation in heat" "shift and g"
    xdotool key c
    wait_for 30 title_lacks elevation || fail "c: still elevation"
    expect_kill_by_key q
}

test_mouse() {
    open_viewer --shade normal || return
    local start
    start=$(rest_sum)
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

# Without --size the window is as large as the screen suggests; --size wins.
test_first_size() {
    run_viewer model.stipple || return
    geometry_is 480x360 || fail "not three quarters of the screen: $(xdotool getwindowgeometry "$window")"
    expect_kill_by_key q
    run_viewer model.stipple --size 600x460 || return
    geometry_is 600x460 || fail "not the size given: $(xdotool getwindowgeometry "$window")"
    expect_kill_by_key q
}
geometry_is() { xdotool getwindowgeometry "$window" | found "Geometry: $1\$"; }

# A window at rest must not go on drawing: its threads use next to no time.
test_rest() {
    open_viewer || return
    sleep 1
    local used
    used=$(cpu_ticks)
    sleep 2
    used=$(($(cpu_ticks) - used))
    [ "$used" -lt $(($(getconf CLK_TCK) / 2)) ] || fail "the viewer at rest used $used ticks in 2 s"
    expect_kill_by_key q
}
cpu_ticks() { awk '{ sub(/.*\) /, ""); print $12 + $13 }' "/proc/$viewer/stat"; }

test_shaders() {
    cp -r "$SOURCE/shaders" "$FOLDER/shaders"
    open_viewer --shaders "$FOLDER/shaders" || return
    before=$(screen_sum)
    # makes the passes that write the picture paint it green
    mapfile -t passes < <(grep -lE '^ *(picture = |imageStore\(picture,)' "$SOURCE"/shaders/*/*.{frag,comp})
    for name in "${passes[@]}"; do
        sed -E -e 's/^( *)picture = .*/\1picture = vec4(0.0, 1.0, 0.0, 1.0);/' \
            -e 's/imageStore\(picture, here, .*\);/imageStore(picture, here, uvec4(packUnorm4x8(vec4(0.0, 1.0, 0.0, 1.0))));/' \
            "$name" >"$FOLDER/saved"
        mv "$FOLDER/saved" "$FOLDER/shaders/${name#"$SOURCE"/shaders/}"
    done
    wait_for 30 screen_changed || fail "a saved shader is not shown"
    echo "no shader" >>"$FOLDER/shaders/${name#"$SOURCE"/shaders/}"
    wait_for 30 grep -q "${name##*/}" "$FOLDER/err" || fail "a shader's error is not told"
    has_ended && fail "a wrong shader ends the viewer"
    : >"$FOLDER/err"
    expect_kill_by_key q
}

# A rate that nothing holds: while the view moves, the picture is at most 4 px coarse and has fewer pixels, unless the
# machine is so busy that fewer pixels save no time (test_pace has the rules); at rest it is full again. Pauses between
# the events of a drag are no rest.
test_fps() {
    open_viewer --fps 1000 || return
    expect_title ", every sample, auto" "--fps at rest"
    local start drag said odd fewer=
    start=$(rest_sum)
    # If the machine holds up the events for a quarter of a second, the view is at rest: drags again.
    for _ in 1 2 3; do
        xdotool mousedown 1
        # shellcheck disable=SC2046
        xdotool $(for x in $(seq 100); do echo "mousemove $((200 + x)) 200 sleep 0.04"; done) &
        drag=$!
        expect_title " px" "a drag with --fps"
        said=$(while kill -0 $drag 2>/dev/null; do title; done | head -n -1 |
            sed 's/.*points, \(.*\), auto.*/\1/')
        odd=$(awk '!/^threshold [0-9.]+ px( at [0-9]+ x [0-9]+)?$/ || $2 > 4 { print "<" $0 ">" }' <<<"$said")
        wait $drag
        xdotool mouseup 1
        expect_title ", every sample, auto" "a drag that ended"
        [[ $said != *" at "* ]] || fewer=yes
        [ -n "$odd" ] || [ -z "$fewer" ] || break
    done
    [ -z "$odd" ] || fail "in each of three drags with --fps: $(sort -u <<<"$odd")"
    [ -n "$fewer" ] || fail "three drags with --fps 1000 never had fewer pixels"
    said=$(for _ in $(seq 10); do title; sleep 0.1; done)
    [[ $said != *" at "* ]] || fail "a view at rest goes back to fewer pixels"
    xdotool key h
    wait_for 30 screen_is "$start" || fail "at rest the picture is not the full one"
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

start_display 640 480
"$STIPPLE" gen sphere -n 20000 -o "$FOLDER/scan.ply" --quiet &&
    "$STIPPLE" prep "$FOLDER/scan.ply" -o "$FOLDER/model.stipple" --quiet || fail "no model"
test_keys
test_mouse
test_sizes
test_first_size
test_rest
test_fps
test_shaders
test_failures
end_test
