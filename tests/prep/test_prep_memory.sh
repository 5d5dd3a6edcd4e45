#!/usr/bin/env bash
# Tests prep within given memory: any number of threads and any memory must give the same bytes.
# Temporary files are announced before and removed after. If memory or room is too small, a message
# says so. Long runs try more numbers of threads and amounts of memory.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
scan="$FOLDER/scan.ply"
mkdir "$FOLDER/models" "$FOLDER/temp ö"
"$STIPPLE" gen bumpy -n 200000 --noise 0.1 --order random -o "$scan" --quiet || fail "no scan"
"$STIPPLE" prep "$scan" -o "$FOLDER/reference.stipple" --threads 1 --quiet || fail "no reference"
# A sphere sampled densely beside a large one sampled coarsely: voxels small enough for the one are
# many for the other, 22 MB of them.
awk 'BEGIN { for (i = 0; i < 60000; i++) {
    large = i % 3 == 0; n = large ? 20000 : 40000; at = large ? i / 3 : i - int(i / 3) - 1
    z = (2 * at + 1) / n - 1; r = sqrt(1 - z * z); size = large ? 5 : 1
    print size * r * cos(2.39996323 * at) + 8 * large, size * r * sin(2.39996323 * at), size * z } }' >"$FOLDER/two.xyz"

# Must give the same bytes; uses files if the points do not fit into half of the memory.
check_bytes() { # threads, memory, temporary files (yes, none for surfaces, or no)
    run "$STIPPLE" prep "$scan" -o "$FOLDER/models/m.stipple" --threads "$1" --memory "$2" \
        --temp "$FOLDER/temp ö" --stats "$FOLDER/stats.json" --force
    expect_code 0
    cmp -s "$FOLDER/models/m.stipple" "$FOLDER/reference.stipple" ||
        fail "$1 threads, $2: other bytes"
    if [ "$3" = yes ]; then
        expect_text err "temporary files: about 0."
        expect_text err "in $FOLDER/temp ö"
        [ "$(field temporary_bytes)" -gt 11200000 ] || fail "$2: no temporary files"
        # a third more than the points' own size, and what reading them takes
        [ "$(field temporary_bytes)" -lt $((200000 * 82 + 33554432)) ] ||
            fail "$2: more than was said"
    elif [ "$3" = none ]; then
        expect_text err "temporary files: about 0.0 GB, at most 0."
        [ "$(field temporary_bytes)" -lt 11200000 ] || fail "$2: the points lie in files"
    else
        [ "$(field temporary_bytes)" = 0 ] || fail "$2: temporary files without need"
    fi
    [ -z "$(ls -A "$FOLDER/temp ö")" ] || fail "$2: left $(ls -A "$FOLDER/temp ö")"
    [ "$(ls -A "$FOLDER/models")" = m.stipple ] || fail "$2: left $(ls -A "$FOLDER/models")"
}

check_bytes 1 90M yes
check_bytes 4 210M yes
check_bytes 2 256M none
check_bytes 4 8G no
check_closed() { # threads, memory
    "$STIPPLE" prep "$FOLDER/two.xyz" -o "$FOLDER/two-$2.stipple" --threads "$1" --memory "$2" \
        --temp "$FOLDER/temp ö" --stats "$FOLDER/stats.json" --force --quiet || fail "two spheres, $2"
    [ "$(field points_closed)" = 60000 ] || fail "two spheres, $2: not closed"
    cmp -s "$FOLDER/two-$2.stipple" "$FOLDER/two-2G.stipple" || fail "two spheres, $2: other bytes"
}
check_closed 4 2G
check_closed 2 256M
check_closed 1 91M
if is_long; then
    check_bytes 2 130M yes
    check_bytes 1 1G no
fi
rm -f "$FOLDER/models"/*

refuse() { # text, further words
    local text=$1
    shift
    run "$STIPPLE" prep "$scan" -o "$FOLDER/models/m.stipple" --threads 1 "$@"
    expect_failure "$text"
    [ -z "$(ls -A "$FOLDER/models")" ] || fail "$command: wrote $(ls -A "$FOLDER/models")"
}

refuse "of memory are too few" --memory 10M
refuse "no folder for temporary files" --memory 90M --temp "$FOLDER/none"

# A full disk, if a small one can be mounted: for temporary files and for the output.
if mkdir "$FOLDER/small" && mount -t tmpfs -o size=4M stipple-test "$FOLDER/small" 2>/dev/null; then
    trap 'umount "$FOLDER/small"; rm -rf "$FOLDER"' EXIT
    refuse "of temporary files are needed" --memory 90M --temp "$FOLDER/small"
    run "$STIPPLE" prep "$scan" -o "$FOLDER/small/m.stipple" --codec raw --quiet # larger than the disk
    expect_failure "the disk is full"
    [ -z "$(ls -A "$FOLDER/small")" ] || fail "a full disk: left $(ls -A "$FOLDER/small")"
fi
end_test
