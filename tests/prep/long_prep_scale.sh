#!/usr/bin/env bash
# Tests prep of 64 million points in random order in 1 GiB: an open surface (LAS) and a closed one
# (PLY). The process may never hold more than a tenth above the limit. Temporary files may take one
# and a half times the points' own size. The output must be sound.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
points=64000000
memory=$((1 << 30))
[ "$(df --output=avail -B1 "$FOLDER" | tail -1)" -gt $((10 * memory)) ] ||
    skip_test "10 GiB of room are needed in $FOLDER"

check() { # shape, scan
    "$STIPPLE" gen "$1" -n $points --order random -o "$2" --quiet || fail "$1: no scan"
    run "$STIPPLE" prep "$2" -o "$FOLDER/m.stipple" --memory 1G --stats "$FOLDER/stats.json" --force
    expect_code 0
    rm "$2"
    [ "$(field points_out)" = $points ] || fail "$1: $(field points_out) points"
    [ "$(field peak_rss_bytes)" -le $((memory / 10 * 11)) ] ||
        fail "$1: $(field peak_rss_bytes) bytes in memory"
    [ "$(field temporary_bytes)" -le $((points * 93 + (32 << 20))) ] ||
        fail "$1: $(field temporary_bytes) bytes of temporary files"
    "$STIPPLE" verify "$FOLDER/m.stipple" --quiet || fail "$1: not sound"
}

check terrain "$FOLDER/t.las"
check statue "$FOLDER/s.ply"
end_test
