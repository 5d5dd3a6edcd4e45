#!/usr/bin/env bash
# Tests the viewer's dialog for opening files: a path that is typed, a name that is pressed, a file
# that cannot be opened, and the list of files opened last.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"
export XDG_CACHE_HOME="$FOLDER/cache"
folder="$FOLDER/in einem Haus" # xdotool types no accents reliably

# The dialog covers the upper left of the picture, where the model is not.
dialog_is_there() { [ "$(lit_pixels 26 26 120 60)" -gt 100 ]; }
dialog_is_gone() { [ "$(lit_pixels 26 26 120 60)" -lt 100 ]; }
open_dialog() { # after
    press ctrl+o
    wait_for 30 dialog_is_there || fail "$1: no dialog"
    rest_sum >/dev/null
}
type_path() { # path
    open_dialog "$1"
    xdotool type "$1" # the field has the keyboard
    rest_sum >/dev/null
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
    open_dialog "at first"
    press Escape # closes the dialog alone
    wait_for 30 dialog_is_gone || fail "Esc does not close the dialog"
    has_ended && fail "Esc ends the viewer while the dialog is shown"
    type_path "$folder/quit ring.las" # a q in a path is no key
    new_window "quit ring.las" "a path and Enter"
    [ "$(recent)" = "quit ring.las ball.stipple" ] || fail "opened last: $(recent)"
    [[ $(xdotool getwindowgeometry "$window") == *500x400* ]] || fail "the window has another size"
    xdotool windowmove --sync "$window" 20 10
    type_path "$folder/broken.ply" # the viewer stays where it is
    wait_for 30 dialog_is_gone || fail "the dialog stays"
    [[ $(xdotool getwindowgeometry "$window") == *20,10* ]] || fail "a file that cannot be opened closes the window"
    new_window "quit ring.las" "a file that cannot be opened"
    [ "$(recent)" = "quit ring.las ball.stipple" ] || fail "a broken file is in the list: $(recent)"
    open_dialog "a folder"
    xdotool type "$FOLDER" # is entered: other names are listed
    rest_sum >/dev/null
    before=$(screen_sum)
    press Return
    wait_for 30 screen_changed || fail "Enter enters no folder"
    dialog_is_there || fail "a folder closes the dialog"
    press Escape
    wait_for 30 dialog_is_gone
    expect_kill_by_key q
}

# Names are pressed twice: of a file opened last, then of a file in its folder. The first of two
# presses on the button beside "open" adds a file.
test_press() {
    run_viewer ball.stipple --size 500x400 || return
    open_dialog "for a recent file"
    press_twice 157 # the second of those opened last
    new_window "quit ring.las" "a recent file"
    [ "$(recent)" = "quit ring.las ball.stipple" ] || fail "opened last: $(recent)"
    open_dialog "for a file to add"
    xdotool mousemove 100 157 sleep 0.3 click 1
    rest_sum >/dev/null
    xdotool mousemove 150 90 sleep 0.3 click 1
    expect_title " and 1 more" "a file that is added"
    expect_kill_by_key q
}
press_twice() { # y
    xdotool mousemove 100 "$1" sleep 0.3 click 1
    rest_sum >/dev/null
    xdotool click 1
}

start_display 640 480
mkdir "$folder"
"$STIPPLE" gen torus -n 3000 -o "$folder/quit ring.las" --quiet
"$STIPPLE" gen sphere -n 3000 -o "$FOLDER/ball.ply" --quiet
"$STIPPLE" prep "$FOLDER/ball.ply" -o "$FOLDER/ball.stipple" --quiet
echo 'no scan' >"$folder/broken.ply"
test_open
test_press
end_test
