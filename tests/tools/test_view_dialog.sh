#!/usr/bin/env bash
# Tests the viewer's dialog for opening files: a path that is typed, a name that is pressed, a file
# that cannot be opened, and the list of files opened last.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"
export XDG_CACHE_HOME="$FOLDER/cache"
folder="$FOLDER/in einem été"

type_path() { # path
    press ctrl+o
    sleep 0.5
    xdotool mousemove 200 53 sleep 0.3 click 1 sleep 0.3 type "$1"
    sleep 0.3
    press Return
}
new_window() { # title, after
    wait_for 60 find_window && wait_for 60 title_begins "$1" || fail "$2: the title is '$(title)', expected $1"
    xdotool windowmove "$window" 0 0 windowfocus --sync "$window"
}
title_begins() { find_window && [[ $(title) == "$1"* ]]; }
recent() { # the files opened last, on one line
    python3 -c 'import json, sys
print(*(p.rpartition("/")[2] for p in json.load(open(sys.argv[1]))["files"]))' "$XDG_STATE_HOME/stipple/recent.json"
}

test_open() {
    run_viewer ball.stipple --size 500x400 || return
    press ctrl+o
    sleep 0.5
    press Escape # closes the dialog alone
    sleep 0.5
    has_ended && fail "Esc ends the viewer while the dialog is shown"
    type_path "$folder/ring.las"
    new_window ring.las "a path and Enter"
    [ "$(recent)" = "ring.las ball.stipple" ] || fail "opened last: $(recent)"
    [[ $(xdotool getwindowgeometry "$window") == *500x400* ]] || fail "the window has another size"
    type_path "$folder/broken.ply"
    sleep 1
    new_window ring.las "a file that cannot be opened"
    [ "$(recent)" = "ring.las ball.stipple" ] || fail "a broken file is in the list: $(recent)"
    type_path "$folder" # is entered; the dialog stays
    sleep 0.5
    press ctrl+o # lists the model's folder: two recent files, then ../, broken.ply, ring.las
    before=$(screen_sum)
    press Escape
    wait_for 30 screen_changed || fail "no dialog"
    expect_kill_by_key q
}

# A name is pressed twice.
test_press() {
    run_viewer ball.stipple --size 500x400 || return
    press ctrl+o
    sleep 0.5
    xdotool mousemove 100 157 sleep 0.3 click 1 sleep 0.5 click 1 # the second of the files opened last
    new_window ring.las "a recent file"
    [ "$(recent)" = "ring.las ball.stipple" ] || fail "opened last: $(recent)"
    expect_kill_by_key q
}

start_display 640 480
mkdir "$folder"
"$STIPPLE" gen torus -n 3000 -o "$folder/ring.las" --quiet
"$STIPPLE" gen sphere -n 3000 -o "$FOLDER/ball.ply" --quiet
"$STIPPLE" prep "$FOLDER/ball.ply" -o "$FOLDER/ball.stipple" --quiet
echo 'no scan' >"$folder/broken.ply"
test_open
test_press
end_test
