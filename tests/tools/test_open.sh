#!/usr/bin/env bash
# Tests that commands which draw open scans: the picture is that of prep and render; what was
# prepared is kept, found, made anew, and bounded.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

"$STIPPLE" --help | found '^  render ' || skip_test "built without the renderer"
export XDG_CACHE_HOME="$FOLDER/cache" TMPDIR="$FOLDER/tmp"
cache="$XDG_CACHE_HOME/stipple"
scan="$FOLDER/a scan, château.ply"
mkdir "$TMPDIR"

render() { # scans and options: to $FOLDER/picture.png
    run "$STIPPLE" render "$@" -o "$FOLDER/picture.png" --size 64x64 --force
}
expect_picture() { # name of the picture that it must be
    expect_code 0
    expect_empty out
    cmp -s "$FOLDER/picture.png" "$FOLDER/$1.png" || fail "$command: not the picture $1"
}
kept() { find "$cache" -type f 2>/dev/null | wc -l; }
expect_kept() { [ "$(kept)" = "$1" ] || fail "$command: $(kept) files are kept, expected $1"; }
expect_no_litter() { [ -z "$(ls -A "$TMPDIR")" ] || fail "$command left $(ls -A "$TMPDIR")"; }

make_pictures() {
    "$STIPPLE" gen sphere -n 400 -o "$scan" --quiet
    "$STIPPLE" gen torus -n 300 -o "$FOLDER/torus.ply" --quiet
    "$STIPPLE" prep "$scan" -o "$FOLDER/one.stipple" --quiet
    "$STIPPLE" prep "$scan" "$FOLDER/torus.ply" -o "$FOLDER/two.stipple" --quiet
    for name in one two; do
        "$STIPPLE" render "$FOLDER/$name.stipple" -o "$FOLDER/$name.png" --size 64x64 --quiet
    done
}

# The same bytes as prep and render; the second time nothing is prepared; a changed scan is.
test_keeping() {
    render "$scan"
    expect_picture one
    expect_empty err
    expect_kept 1
    cmp -s "$cache"/*.stipple "$FOLDER/one.stipple" || fail "the model kept is not that of prep"
    local before
    before=$(stat -c '%i %Y' "$cache"/*.stipple)
    (cd "$FOLDER" && render "./a scan, château.ply" -q) # another name of the same scan
    [ "$(stat -c '%i %Y' "$cache"/*.stipple)" = "$before" ] || fail "the scan was prepared again"
    render "$scan" "$FOLDER/torus.ply"
    expect_picture two
    expect_kept 2
    cp -p "$scan" "$FOLDER/kept.ply"
    touch -d '2001-02-03 04:05' "$scan"
    render "$scan"
    expect_picture one
    expect_kept 3
    mv "$FOLDER/kept.ply" "$scan"
    printf damaged >"$(find "$cache" -inum "${before% *}")"
    render "$scan"
    expect_picture one
    expect_no_litter
}

test_bound() {
    rm -rf "$cache"
    render "$scan"
    touch -a -d '2001-02-03' "$cache"/*.stipple # used long ago
    local old=("$cache"/*.stipple)
    render "$FOLDER/torus.ply"
    expect_kept 2
    render "$scan" "$FOLDER/torus.ply" --cache-size "$(($(du -cb "$cache"/*.stipple | tail -1 | cut -f 1) + 1000))"
    expect_picture two
    [ ! -e "${old[0]}" ] || fail "the model that was not used for longest stays"
    [ "$(kept)" -lt 3 ] || fail "more is kept than --cache-size"
    render "$FOLDER/torus.ply" --cache-size 1 --cache "$FOLDER/own"
    expect_code 0
    [ -d "$FOLDER/own" ] && [ -z "$(ls "$FOLDER/own")" ] || fail "$command: keeps $(ls "$FOLDER/own")"
}

test_no_cache() {
    rm -rf "$cache"
    render "$scan" --no-cache
    expect_picture one
    expect_empty err
    [ ! -e "$cache" ] || fail "--no-cache makes a cache"
    render "$scan" --cache "$scan/none" # as if it were read-only
    expect_picture one
    expect_lines err 1
    expect_text err "for this time alone, in $TMPDIR"
    expect_no_litter
}

# A full disk, if a small one can be mounted.
test_full_disk() {
    mkdir "$FOLDER/disk"
    # shellcheck disable=SC2016
    run unshare -rm sh -c 'mount -t tmpfs -o size=4k none "$0" && exec "$@"' "$FOLDER/disk" \
        "$STIPPLE" render "$scan" --cache "$FOLDER/disk" -o "$FOLDER/picture.png" --size 64x64 --force
    grep -q "^mount\|^unshare" "$FOLDER/err" && { echo "full disks are not tested: nothing can be mounted here"; return; }
    expect_picture one
    expect_lines err 1
    expect_text err "the disk is full"
    expect_no_litter
}

test_two_at_once() {
    rm -rf "$cache"
    "$STIPPLE" render "$scan" -o "$FOLDER/other.png" --size 64x64 --quiet &
    render "$scan"
    wait $! || fail "the other of two at once fails"
    expect_picture one
    cmp -s "$FOLDER/other.png" "$FOLDER/one.png" || fail "the other of two at once draws another picture"
    expect_kept 1
    expect_no_litter
}

test_failures() {
    rm -rf "$cache"
    head -c 4000 "$scan" >"$FOLDER/cut.ply"
    run "$STIPPLE" prep "$FOLDER/cut.ply" -o "$FOLDER/cut.stipple" --quiet
    local sentence
    sentence=$(sed 's/^stipple prep: //' "$FOLDER/err")
    render "$FOLDER/cut.ply"
    expect_failure "$sentence"
    expect_kept 0
    render "$scan" "$FOLDER/cut.ply" # the other is drawn, but half a model is not kept
    expect_picture one
    expect_text err "not read: "
    expect_kept 0
    expect_no_litter
    render "$FOLDER/one.stipple" "$scan"
    expect_failure "one.stipple is no scan"
    printf 'no\1scan\0nor model' >"$FOLDER/odd.bin"
    render "$FOLDER/odd.bin"
    expect_failure "odd.bin is of no known format"
    expect_text err "nor is it a stipple chunk file"
    printf 'CDF\1' >"$FOLDER/heights.nc"
    render "$FOLDER/heights.nc"
    expect_failure "is a NetCDF file, which is not read here"
    : >"$FOLDER/nothing.las"
    render "$FOLDER/nothing.las"
    expect_failure "nothing.las is empty"
    run "$STIPPLE" tune "$scan" -o "$FOLDER/tune" --psnr 30 --save
    expect_failure "is a scan: --save changes models"
}

# A folder, and the other commands.
test_commands() {
    mkdir "$FOLDER/scans"
    cp "$scan" "$FOLDER/torus.ply" "$FOLDER/scans"
    render "$FOLDER/scans"
    expect_picture two
    run "$STIPPLE" fly "$scan" --turntable 1 --rate 1 -o "$FOLDER/frames" --size 32x32 --quiet
    expect_code 0
    expect_no_litter
}

# A camera's depths, taken for heights in pixels, stand like towers: a line says what to do.
test_depths() {
    local high
    for high in 100 1000; do
        awk -v high=$high 'BEGIN { print "P2 30 20 65535"; for (i = 0; i < 600; i++) print i % 2 * high }' >"$FOLDER/depths.pgm"
        rm -rf "$XDG_CACHE_HOME"
        render "$FOLDER/depths.pgm"
        expect_code 0
        cat "$FOLDER/err" >>"$FOLDER/said"
    done
    [ "$(cat "$FOLDER/said")" = "$FOLDER/depths.pgm: its heights differ by 34.5 times its width: if they are depths \
of a camera, give prep --pinhole fx,fy,cx,cy (--disparity F,B for disparities), else --height-scale or --spacing" ] ||
        fail "$command: $(cat "$FOLDER/said")"
}

make_pictures
test_keeping
test_bound
test_no_cache
test_full_disk
test_two_at_once
test_failures
test_commands
test_depths
end_test
