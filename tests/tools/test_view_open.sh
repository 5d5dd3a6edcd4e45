#!/usr/bin/env bash
# Tests how the viewer opens scans, on a virtual display: a coarse model first, then the whole one at
# the same camera; kept models; broken scans; ends in the middle; dropped scans.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"

DROP="$PWD/xdrop"
export XDG_CACHE_HOME="$FOLDER/cache" TMPDIR="$FOLDER/tmp"
export MESA_SHADER_CACHE_DIR="$FOLDER/shaders"
mkdir "$TMPDIR"
cache="$XDG_CACHE_HOME/stipple"
scan="a scan, château.ply"

expect_kept() { [ "$(find "$cache" -type f | wc -l)" = "$1" ] || fail "$2: $(ls -A "$cache") is kept"; }
expect_no_litter() { [ -z "$(ls -A "$TMPDIR")" ] || fail "$1 leaves $(ls -A "$TMPDIR")"; }
child() { pgrep -P "$viewer" >/dev/null; }
no_child() { ! child; }

# The whole model replaces the coarse one; the camera, which moved meanwhile, stays.
test_coarse_first() {
    run_viewer "$scan" --size 200x200 || return
    title_has "coarse: preparing" || fail "the first picture is not the coarse one: $(title)"
    expect_no_litter "a coarse model"
    local lit
    lit=$(lit_pixels 0 0 200 200)
    [ "$lit" -gt 2000 ] || fail "the coarse picture of a sphere has only $lit pixels"
    xdotool mousemove 100 100 click 5 click 5 click 5
    expect_no_title coarse "a prepared scan"
    wait_for 30 is_still
    sleep 0.5
    [ "$(lit_pixels 0 0 200 200)" -lt $((lit * 9 / 10)) ] || fail "the camera went home when the whole model came"
    expect_kept 1 "a scan"
    expect_kill_by_key q
    run_viewer "$scan" --size 200x200 || return
    title_lacks coarse || fail "a kept model is not found"
    test_drop
    expect_kill_by_key q
    expect_no_litter "a scan"
}

# Onto a window that is open.
test_drop() {
    [ -x "$DROP" ] || { echo "no file is dropped: built without X11"; return; }
    "$DROP" "$window" "file://$FOLDER/small.ply" || fail "the drop is not taken"
    expect_title "$scan and 1 more: " "a dropped scan"
    expect_no_title preparing "a dropped scan"
}

# A condition chooses in the coarse model as in the whole one: half of a sphere.
test_where() {
    local camera=(--size 200x200 --cull none --eye 4,0,0 --look 0,0,0 --up 0,0,1)
    rm -rf "$cache"
    run_viewer "$scan" "${camera[@]}" --where 'z>0' || return
    title_has "coarse: preparing" || fail "the first picture is not the coarse one: $(title)"
    local coarse whole sphere
    coarse=$(lit_pixels 0 0 200 200)
    expect_no_title coarse "a prepared scan"
    wait_for 30 is_still
    sleep 0.5
    whole=$(lit_pixels 0 0 200 200)
    expect_kill_by_key q
    rm -rf "$cache"
    run_viewer "$scan" "${camera[@]}" || return
    sphere=$(lit_pixels 0 0 200 200)
    [ $((4 * coarse)) -lt $((3 * sphere)) ] && [ $((4 * whole)) -lt $((3 * sphere)) ] &&
        [ $((5 * coarse)) -gt "$sphere" ] && [ $((5 * whole)) -gt "$sphere" ] ||
        fail "$coarse pixels of the coarse half, $whole of the half, $sphere of the sphere"
    expect_kill_by_key q
    run "$STIPPLE" view "$FOLDER/$scan" --where 'lime>7'
    expect_failure "lime"
}

# An end in the middle ends the child, too.
test_end() {
    rm -rf "$cache"
    run_viewer "$scan" --size 200x200 || return
    wait_for 30 child || fail "no child prepares the scan"
    local process
    process=$(pgrep -P "$viewer")
    expect_kill_by_key q
    [ ! -d "/proc/${process:-none}" ] || fail "the child goes on"
    expect_kept 0 "an end in the middle"
    expect_no_litter "an end in the middle"
}

# The coarse model stays, and one sentence says why.
test_broken() {
    printf '1 2 3\n4 5 six\n' >"$FOLDER/broken.xyz"
    run "$STIPPLE" view "$FOLDER/broken.xyz"
    expect_failure "broken.xyz: line 2"
    rm -rf "$cache"
    run_viewer "$scan" --size 200x200 || return
    wait_for 30 child || fail "no child prepares the scan"
    pkill -KILL -P "$viewer"
    wait_for 30 title_lacks preparing || fail "a killed child is not noticed"
    title_has coarse || fail "the coarse picture is gone: $(title)"
    grep -qx 'stipple view: prep was stopped' "$FOLDER/err" || fail "a killed child: $(head -3 "$FOLDER/err")"
    : >"$FOLDER/err"
    expect_kill_by_key q
    expect_kept 0 "a killed child"
    expect_no_litter "a killed child"
}

start_display 640 480
"$STIPPLE" gen sphere -n 110000 -o "$FOLDER/$scan" --quiet
"$STIPPLE" gen sphere -n 400 -o "$FOLDER/small.ply" --quiet
test_coarse_first
test_where
test_end
test_broken
end_test
