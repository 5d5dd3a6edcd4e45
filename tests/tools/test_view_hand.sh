#!/usr/bin/env bash
# Tests the viewer with the events of a real display: navigation, panels, clip box, measuring,
# bookmarks, paths, screenshots, dropped files, full screen.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/viewer.sh"

DROP="$PWD/xdrop"
# The sphere of radius 1, seen from a distance of 4: f = 600 / (2 tan 22.5 degrees) = 724.3 pixels.
WIDTH=900 HEIGHT=600
VIEW=(--eye 0,0,4 --look 0,0,0 --up 0,1,0 --fovy 45)

# Each viewer must start like the first one; hidden panels would be remembered.
open_viewer() { # options
    rm -rf "$XDG_STATE_HOME"
    run_viewer "$@" --size ${WIDTH}x$HEIGHT "${VIEW[@]}" || return 1
    xdotool mousemove 20 300
}
settle() { sleep 0.6; }

test_panels() {
    open_viewer model.stipple || return
    local narrow wide
    settle
    narrow=$(lit_pixels $((WIDTH - 100)) 0 $WIDTH $HEIGHT)
    [ "$narrow" -gt $((90 * HEIGHT)) ] || fail "no panel at the right: $narrow pixels lit"
    before=$(screen_sum)
    press Tab
    wait_for 30 panel_is_gone || fail "Tab does not hide the panel"
    wide=$(rest_sum)
    press F1
    wait_for 30 screen_changed || fail "F1 shows nothing"
    before=$(screen_sum)
    press Escape
    wait_for 30 screen_is "$wide" || fail "Esc does not close the help"
    has_ended && fail "Esc in the help ends the viewer"
    press Tab
    wait_for 30 panel_is_back || fail "Tab does not show the panel again"
    # the mouse button over the panels belongs to them: a drag there turns nothing
    settle
    xdotool mousemove $((WIDTH - 150)) 10 mousedown 1 mousemove $((WIDTH - 300)) 100 mouseup 1
    settle
    lit=$(lit_pixels 0 0 $((WIDTH - 340)) $HEIGHT)
    [ "$lit" -gt 0 ] || fail "a drag on the panel moved the model out of sight"
    press Tab
    settle
    expect_kill_by_key q
    grep -q '"panels":.*false' "$XDG_STATE_HOME/stipple/view.json" || fail "the viewer forgets that panels are hidden"
}
panel_is_gone() { [ "$(lit_pixels $((WIDTH - 20)) 0 $WIDTH $HEIGHT)" = 0 ]; }
panel_is_back() { [ "$(lit_pixels $((WIDTH - 20)) 0 $WIDTH $HEIGHT)" -gt $((15 * HEIGHT)) ]; }

test_navigation() {
    open_viewer model.stipple || return
    press Tab o
    expect_title ", orthographic" o
    press o
    expect_no_title ", orthographic" "o again"
    settle
    lit=$(lit_pixels 0 0 $WIDTH $HEIGHT)
    press n
    expect_title ", fly" n
    xdotool keydown w sleep 0.7 keyup w
    wait_for 30 more_lit "$lit" || fail "w held does not fly nearer"
    expect_title ", phong" "w: s and w are no keys of drawing while flying"
    settle
    before=$(screen_sum)
    xdotool mousemove 450 300 mousedown 1 mousemove 455 300 mousemove 480 310 mouseup 1
    wait_for 30 screen_changed || fail "a drag does not look about"
    before=$(screen_sum)
    xdotool keydown d sleep 0.4 keyup d
    wait_for 30 screen_changed || fail "d held does not fly to the right"
    press n
    expect_title ", walk" "n twice"
    press Escape
    expect_no_title ", walk" "Esc while walking"
    press h k
    expect_title ", eye-dome" k
    press k
    expect_no_title ", eye-dome" "k twice"
    expect_kill_by_key q
}
more_lit() { [ "$(lit_pixels 0 0 $WIDTH $HEIGHT)" -gt $(($1 * 11 / 10)) ]; }

# The walker must stand on the terrain's ground, not in the air.
test_walk() {
    rm -rf "$XDG_STATE_HOME"
    run_viewer terrain.stipple --size 500x400 || return
    local eye
    press n n
    expect_title ", walk" "n twice"
    sleep 2
    xdotool keydown w sleep 1 keyup w
    sleep 1
    press b
    wait_for 30 test -s "$FOLDER/terrain.stipple.views.json" || fail "b keeps no view"
    eye=$(tr -d ' \n\t' <"$FOLDER/terrain.stipple.views.json" | sed -n 's/.*"eye":\[\([^]]*\)\].*/\1/p')
    awk -v eye="$eye" 'BEGIN { split(eye, e, ","); above = e[3] - 5 * sin(e[1] / 12) * cos(e[2] / 12)
            exit !(above > 0.9 && above < 2.5) }' ||
        fail "the walker's eye at $eye is not 1.7 above the ground"
    press Escape
    expect_no_title ", walk" "Esc while walking"
    expect_kill_by_key Escape
}

test_clip() {
    open_viewer model.stipple || return
    press x
    expect_title ", clipped" x
    settle
    # the panel narrows the picture, but its height is the window's: the centre of the high y face
    # stands 724.3 * 1 / 4 pixels above the middle
    local middle=$(((WIDTH - 330) / 2)) full half
    full=$(lit_pixels 20 0 $((WIDTH - 340)) $((HEIGHT / 2 - 40)))
    xdotool mousemove $middle 119 mousedown 1 sleep 0.2 mousemove $middle 150 sleep 0.2 \
        mousemove $middle 300 sleep 0.2 mouseup 1
    wait_for 30 upper_is_dark "$full" || fail "a handle dragged down does not clip the upper half"
    press x
    expect_no_title ", clipped" "x again"
    wait_for 30 upper_is_lit "$full" || fail "without the clip box the upper half stays away"
    expect_kill_by_key q
}
upper_is_dark() { [ "$(lit_pixels 20 0 $((WIDTH - 340)) $((HEIGHT / 2 - 40)))" -lt $(($1 / 4)) ]; }
upper_is_lit() { [ "$(lit_pixels 20 0 $((WIDTH - 340)) $((HEIGHT / 2 - 40)))" -gt $(($1 / 2)) ]; }

# Two points on the sphere, 100 pixels to either side of the middle, are 0.855 apart.
test_measure() {
    open_viewer model.stipple || return
    press Tab m
    expect_title ", measuring" m
    settle
    xdotool mousemove 350 300 sleep 0.3 click 1 sleep 0.8 mousemove 550 300 sleep 0.3 click 1
    expect_title ", measuring 0.8" "two clicks"
    # a second line: it follows the cursor, and the first one stays
    xdotool mousemove 350 360 sleep 0.3 click 1 sleep 0.8 mousemove 550 360
    wait_for 30 is_orange 425 360 || fail "no line follows the cursor"
    is_orange 350 300 || fail "a second measurement removes the first one's mark"
    xdotool click 1
    expect_title ", measuring 0.8" "four clicks"
    settle
    is_orange 425 300 && is_orange 425 360 || fail "measured lines do not stay"
    press Escape
    expect_no_title measuring "Esc while measuring"
    # sets a pivot, then turns about it
    settle
    before=$(screen_sum)
    xdotool mousemove 450 300 click 1 sleep 0.1 click 1
    settle
    xdotool mousedown 1 mousemove 480 300 mousemove 560 320 mouseup 1
    wait_for 30 screen_changed || fail "no turn about the pivot"
    expect_kill_by_key q
}

# Whether a mark of the measuring is drawn about a place.
is_orange() { # x y
    [ "$(pixels_of ffb347 $(($1 - 5)) $(($2 - 5)) $(($1 + 6)) $(($2 + 6)))" != 0 ]
}

# The bar of colours at the left of the picture, beside the sphere.
test_legend() {
    open_viewer model.stipple || return
    press Tab
    settle
    [ "$(bar_pixels)" = 0 ] || fail "a colour bar though samples have colours of their own"
    press c c
    expect_title ", elevation in auto" "c twice"
    wait_for 30 bar_is_there || fail "no colour bar: $(bar_pixels) pixels"
    press shift+s
    expect_title "primitive" "shift and s"
    wait_for 30 bar_is_gone || fail "a colour bar though other colours are shown"
    expect_kill_by_key q
}
bar_pixels() { lit_pixels 14 $((HEIGHT / 2 - 80)) 26 $((HEIGHT / 2 + 80)); }
bar_is_there() { [ "$(bar_pixels)" = $((12 * 160)) ]; }
bar_is_gone() { [ "$(bar_pixels)" = 0 ]; }

test_keeping() {
    open_viewer model.stipple || return
    press Tab
    wait_for 30 panel_is_gone || fail "Tab does not hide the panel"
    local first
    first=$(rest_sum)
    press b
    wait_for 30 test -s "$FOLDER/model.stipple.views.json" || fail "b keeps no view"
    press plus minus
    xdotool mousemove 450 300 click 4 click 4
    settle
    press 1
    wait_for 30 screen_is "$first" || fail "key 1 does not lead back to the bookmark"
    # if the file cannot be written, the views go to the folder of states
    rm "$FOLDER/model.stipple.views.json"
    mkdir "$FOLDER/model.stipple.views.json"
    press b
    wait_for 30 has_state || fail "no views in the folder of states"
    rmdir "$FOLDER/model.stipple.views.json"
    expect_kill_by_key q
}
has_state() { compgen -G "$XDG_STATE_HOME/stipple/model.stipple-*.views.json" >/dev/null; }

test_path() {
    open_viewer model.stipple || return
    press ctrl+r
    expect_title ", recording" ctrl+r
    xdotool mousemove 300 300 mousedown 1 mousemove 330 300 sleep 0.4 mousemove 360 310 sleep 0.4 \
        mousemove 400 310 mouseup 1
    settle
    press ctrl+r
    expect_no_title ", recording" "ctrl+r again"
    wait_for 30 test -s "$FOLDER/model-1.path.json" || fail "no path was written"
    [ "$(grep -c '"time"' "$FOLDER/model-1.path.json")" -ge 3 ] || fail "the path has no keyframes"
    expect_kill_by_key q
    run "$STIPPLE" fly "$FOLDER/model.stipple" --path "$FOLDER/model-1.path.json" --size 32x32 \
        --rate 2 -o "$FOLDER/frames" --quiet
    expect_code 0
    [ -s "$FOLDER/frames/frame_000001.png" ] || fail "fly makes no frames of the path"
}

test_screenshot() {
    local WIDTH=450 HEIGHT=300 # without panels, which need 720; and a picture for a file is drawn many times
    open_viewer model.stipple || return
    panel_is_gone || fail "a panel in a narrow window"
    press p
    wait_for 60 test -s "$FOLDER/model-1.png" || fail "p makes no picture"
    settle
    press p
    wait_for 60 test -s "$FOLDER/model-2.png" || fail "the second picture has not the next name"
    expect_outline "$FOLDER/model-1.png" smooth
    cmp -s "$FOLDER/model-1.png" "$FOLDER/model-2.png" || fail "two pictures of a view differ"
    expect_kill_by_key q
    run "$STIPPLE" render "$FOLDER/model.stipple" "${VIEW[@]}" --size ${WIDTH}x$HEIGHT \
        -o "$FOLDER/render.png" --quiet
    expect_code 0
    run "$STIPPLE" compare "$FOLDER/model-1.png" "$FOLDER/render.png" --json
    expect_code 0
    cp "$FOLDER/out" "$FOLDER/stats.json"
    awk -v psnr="$(field psnr_db)" 'BEGIN { exit !(psnr == "" || psnr > 45) }' ||
        fail "a screenshot is not what render draws: $(field psnr_db) dB"
}

test_drop() {
    [ -x "$DROP" ] || { echo "no file is dropped: built without X11"; return; }
    open_viewer model.stipple || return
    settle
    "$DROP" "$window" "file://$FOLDER/terr%61in.stipple" || fail "the drop is not taken"
    expect_title "and 1 more: " "a drop"
    "$DROP" "$window" "file://$FOLDER/none.stipple" "file://$FOLDER/scan.xml" ||
        fail "the second drop is not taken"
    settle
    has_ended && fail "dropping what is no model ends the viewer"
    expect_title "and 1 more: " "a drop of what is no model"
    expect_kill_by_key q
    open_viewer model.stipple terrain.stipple || return
    expect_title "and 1 more: " "two models"
    expect_kill_by_key q
}

test_full_screen() {
    open_viewer model.stipple || return
    press F11
    wait_for 30 geometry_is ${SCREEN_WIDTH}x$SCREEN_HEIGHT || fail "F11 does not fill the screen"
    settle
    press Escape
    wait_for 30 geometry_is ${WIDTH}x$HEIGHT || fail "Esc does not end the full screen"
    has_ended && fail "Esc in full screen ends the viewer"
    expect_kill_by_key Escape
}
geometry_is() { xdotool getwindowgeometry "$window" | found "Geometry: $1\$"; }

hills() {
    awk 'BEGIN { for (x = -40; x <= 40; x += 0.5) for (y = -40; y <= 40; y += 0.5)
        print x, y, 5 * sin(x / 12) * cos(y / 12) }'
}

start_display 1100 750
"$STIPPLE" gen sphere -n 40000 -o "$FOLDER/scan.ply" --quiet &&
    "$STIPPLE" prep "$FOLDER/scan.ply" -o "$FOLDER/model.stipple" --quiet &&
    hills >"$FOLDER/ground.xyz" &&
    "$STIPPLE" prep "$FOLDER/ground.xyz" -o "$FOLDER/terrain.stipple" --quiet || fail "no models"
for name in ${ONLY:-panels navigation walk clip measure legend keeping path screenshot drop full_screen}; do
    "test_$name"
done
end_test
