#!/usr/bin/env bash
# Prepares, verifies and draws real scans of every kind: all small ones, and of the room, the only one that is seen
# from inside, a sixteenth of the points. long_real_scans.sh tries all. Skips unless STIPPLE_SCANS names a folder: the
# project may not distribute the scans.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/real_scans.sh"

check_folder -5000000c 6 192

room=rooms/room-3.23M-rgb.ply
if [ -e "$STIPPLE_SCANS/$room" ] && command -v python3 >/dev/null; then
    mkdir "$FOLDER/rooms"
    python3 - "$STIPPLE_SCANS/$room" >"$FOLDER/$room" <<'END'
import sys
data = open(sys.argv[1], "rb").read()
begin = data.index(b"end_header\n") + 11
kept = [data[at:at + 15] for at in range(begin, len(data), 16 * 15)]
sys.stdout.buffer.write(data[:begin].replace(b"vertex 3234126", b"vertex %d" % len(kept)) + b"".join(kept))
END
    STIPPLE_SCANS=$FOLDER check_file $room
fi
end_test
