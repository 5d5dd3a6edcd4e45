#!/usr/bin/env bash
# Tests that a file appears whole or not at all: on full disks, beside links made by others, and if
# many processes write it at once. Kills must leave nothing behind. In long runs each film fills each disk.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
model="$FOLDER/m.stipple"
have_renderer() {
    "$STIPPLE" --help | found '^  render '
}
"$STIPPLE" gen sphere -n 3000 -o "$FOLDER/s.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/s.ply" -o "$model" --quiet || fail "no model"

# Runs a command on a new disk of the given size; lists what is left there in $FOLDER/out.
on_disk() { # size, words; {} is the folder
    local size=$1
    shift
    # shellcheck disable=SC2016
    run unshare -rm sh -c 'folder=$0 && mount -t tmpfs -o "$1" none "$folder" && shift && "$@"
        code=$?; ls "$folder"; exit $code' "$FOLDER/disk" "size=$size" "$STIPPLE" \
        "${@//\{\}/$FOLDER/disk}" --quiet
}

# The command must say one sentence of ours and leave nothing on the disk.
expect_full() {
    expect_code 1
    expect_lines err 1
    expect_text err "stipple "
    expect_text err "$1"
    expect_empty out
}

test_full_disks() {
    local ending
    mkdir "$FOLDER/disk"
    # shellcheck disable=SC2016
    if ! unshare -rm sh -c 'mount -t tmpfs -o size=64k none "$0"' "$FOLDER/disk" 2>/dev/null; then
        echo "full disks are not tested: nothing can be mounted here"
        return
    fi
    on_disk 4k convert "$model" -o '{}/c.stipple'
    expect_full "the disk is full"
    on_disk 4k export "$model" -o '{}/e.ply'
    expect_full "the disk is full"
    have_renderer || return 0
    for ending in jpg png tif bmp; do
        on_disk 4k render "$model" -o "{}/p.$ending" --size 200x200
        expect_full "the disk is full"
    done
    command -v ffmpeg >/dev/null || return 0
    local film sizes
    for film in mp4:4k mov:16k mkv:4k webm:16k; do
        ending=${film%:*} sizes=${film#*:}
        ! is_long || sizes='4k 16k'
        for size in $sizes; do
            on_disk "$size" fly "$model" --turntable 1 --rate 10 --size 200x200 --threads 1 -o "{}/f.$ending"
            expect_full "f.$ending: "
        done
    done
}

# A link lies under a name that one could guess from the process number.
test_links() {
    echo kept >"$FOLDER/kept"
    mkdir "$FOLDER/linked"
    # shellcheck disable=SC2016
    run bash -c 'ln -s "$0" "$1.$$.part"; exec "$2" convert "$3" -o "$1" --quiet' "$FOLDER/kept" \
        "$FOLDER/linked/c.stipple" "$STIPPLE" "$model"
    expect_code 0
    [ "$(cat "$FOLDER/kept")" = kept ] || fail "$command: wrote through a stranger's link"
    [ "$(ls "$FOLDER/linked" | wc -l)" = 2 ] || fail "$command: a stranger's link is gone"
}

test_together() {
    local i children=()
    for i in $(seq 24); do
        "$STIPPLE" convert "$model" -o "$FOLDER/together.stipple" --force --quiet 2>>"$FOLDER/err" &
        children+=($!)
    done
    for i in "${children[@]}"; do
        wait "$i" || fail "one of many processes that write one output fails: $(cat "$FOLDER/err")"
    done
    "$STIPPLE" verify "$FOLDER/together.stipple" --quiet || fail "the output of many processes is not sound"
    [ -z "$(find "$FOLDER" -maxdepth 1 -name 'together*part')" ] || fail "many processes left files behind"
}

# Kills tune as soon as it writes. The next run must leave its report and nothing else.
test_killed_tune() {
    local child i
    have_renderer || return 0
    mkdir "$FOLDER/tune"
    for i in 1 2 3; do
        "$STIPPLE" tune "$model" -o "$FOLDER/tune/t" --force --size 64x64 --views 1 --repeat 1 --quiet \
            >/dev/null 2>&1 &
        child=$!
        while kill -0 $child 2>/dev/null && ! ls "$FOLDER/tune" | found part; do :; done
        kill -KILL $child 2>/dev/null
        wait $child 2>/dev/null
    done
    run "$STIPPLE" tune "$model" -o "$FOLDER/tune/t" --force --size 64x64 --views 1 --repeat 1 --quiet
    expect_code 0
    [ "$(ls -A "$FOLDER/tune")" = t ] || fail "$command: left $(ls -A "$FOLDER/tune")"
}

test_full_disks
test_links
test_together
test_killed_tune
end_test
