# shellcheck shell=bash disable=SC2034
# Helpers for tests of the viewer; source it after shell.sh. They start a virtual display with nothing
# else on it and the viewer in it, and read the viewer's title and pixels.

for tool in Xvfb xdotool python3; do
    command -v $tool >/dev/null || skip_test "$tool is not installed"
done
"$STIPPLE" --help | found '^  view ' || skip_test "built without the renderer"

export XDG_STATE_HOME="$FOLDER/state"
screen="$FOLDER/Xvfb_screen0"
viewer=
server=
counter=

stop() {
    if [ -n "$viewer" ]; then kill -KILL "$viewer" 2>/dev/null; fi
    if [ -n "$counter" ]; then kill "$counter" 2>/dev/null; fi
    if [ -n "$server" ]; then kill "$server" 2>/dev/null && wait "$server" 2>/dev/null; fi
    chmod -R u+w "$FOLDER" 2>/dev/null
    rm -rf "$FOLDER"
}
trap stop EXIT

start_display() { # width height
    SCREEN_WIDTH=$1
    SCREEN_HEIGHT=$2
    # without -noreset the server starts anew whenever the last viewer leaves, and then refuses
    # viewers
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
    start_counter
}

# wait_for SECONDS COMMAND...: repeats the command until it succeeds.
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
expect_no_title() { wait_for 60 title_lacks "$1" || fail "$2: '$1' in the title '$(title)'"; }
find_window() {
    window=$(xdotool search --all --onlyvisible --pid "$viewer" --name 'ms, ' 2>/dev/null) &&
        [ -n "$window" ]
}
window_or_end() { find_window || has_ended; }
has_ended() { ! kill -0 "$viewer" 2>/dev/null; }

# Counts the pixels of a colour (lit: any but black) in a rectangle of the screen, which Xvfb keeps as an XWD file.
pixels_of() { # colour as rrggbb, or lit; then x0 y0 x1 y1
    local number
    echo "$*" >&7
    read -rt 60 number <&8
    echo "$number"
}
# Starts the process that counts for pixels_of: one for all, since python3 takes long to start.
start_counter() {
    mkfifo "$FOLDER/asked" "$FOLDER/answers"
    exec 7<>"$FOLDER/asked" 8<>"$FOLDER/answers"
    python3 -c '
import struct, sys
for line in sys.stdin:
    colour, x0, y0, x1, y1 = line.split()
    x0, y0, x1, y1 = map(int, (x0, y0, x1, y1))
    data, width = open(sys.argv[1], "rb").read(), int(sys.argv[2])
    begin = struct.unpack_from(">I", data)[0] + 12 * struct.unpack_from(">I", data, 76)[0]
    part = b"".join(data[begin + 4 * (y * width + x0):begin + 4 * (y * width + x1)] for y in range(y0, y1))
    count, wanted, other = len(part) // 4, 0 if colour == "lit" else int(colour, 16), 0
    for channel in range(3): # blue, green, red: another bit in one of them makes another colour
        same = bytes([wanted >> 8 * channel & 255]) * count
        other |= int.from_bytes(part[channel::4], "little") ^ int.from_bytes(same, "little")
    same = other.to_bytes(count, "little").count(0)
    print(count - same if colour == "lit" else same, flush=True)
' "$screen" $SCREEN_WIDTH <"$FOLDER/asked" >"$FOLDER/answers" 7>&- 8>&- &
    counter=$!
}
lit_pixels() { pixels_of lit "$@"; } # x0 y0 x1 y1
screen_sum() { cksum <"$screen"; }
# Prints the sum of the picture at rest: the last frame adds smooth edges, and nothing changes for 1.5 s after it.
rest_sum() {
    local last='' same=0
    while [ $same -lt 3 ]; do
        sleep 0.5
        [ "$(screen_sum)" = "$last" ] && same=$((same + 1)) || same=0
        last=$(screen_sum)
    done
    echo "$last"
}
screen_changed() { [ "$(screen_sum)" != "$before" ]; }
screen_is() { [ "$(screen_sum)" = "$1" ]; }

is_still() { ! title_has missing; }

# run_viewer ARGUMENTS...: starts the viewer in the test's folder, with its window in the screen's
# corner.
run_viewer() {
    (cd "$FOLDER" && exec "$STIPPLE" view "$@") >"$FOLDER/out" 2>"$FOLDER/err" </dev/null &
    viewer=$!
    command="view $*"
    wait_for 60 window_or_end && find_window ||
        { fail "no window: $(head -3 "$FOLDER/err")"; return 1; }
    xdotool windowmove "$window" 0 0 windowfocus --sync "$window"
    # every chunk is loaded, and the window knows its position
    wait_for 60 is_still || fail "chunks stay missing: $(title)"
}

expect_end() { # exit code, after
    wait_for 30 has_ended || { fail "$2 does not end the viewer"; kill -KILL "$viewer"; }
    wait "$viewer" && code=0 || code=$?
    viewer=
    [ "$code" = "$1" ] || fail "$2: exit $code, expected $1: $(head -3 "$FOLDER/err")"
    expect_empty out
    expect_empty err
}

expect_kill_by_key() {
    xdotool key "$1"
    expect_end 0 "key $1"
}

# press KEYS...: one after the other.
press() {
    local key
    for key in "$@"; do
        xdotool key "$key"
        sleep 0.05
    done
}
