#!/usr/bin/env bash
# Tests files of version 2: `prep` and `convert --format 2` write the same bytes, for any
# number of threads; converting back gives the file of version 1; files grow little if at all; points, info and
# pictures stay the same. In long runs each model is converted by both numbers of threads.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$FOLDER" || exit 1

# growth OLD NEW PERCENT: NEW may be larger than OLD by so much; below 0: it must be smaller.
growth() {
    local old new
    old=$(stat -c %s "$1")
    new=$(stat -c %s "$2")
    echo "$2: $old to $new bytes"
    [ $((new * 100)) -le $((old * (100 + $3))) ] || fail "$2: $old bytes became $new"
}

# check NAME CODEC PERCENT THREADS...: scan.ply in both versions, converted by so many threads.
check() {
    local one=$1-$2-1.stipple two=$1-$2-2.stipple threads=("${@:4}")
    ! is_long || threads=(1 3)
    "$STIPPLE" prep $1.ply -o $one --codec $2 --format 1 --quiet || fail "prep $1 $2"
    "$STIPPLE" prep $1.ply -o $two --codec $2 --quiet || fail "prep $1 $2 in blocks"
    for count in "${threads[@]}"; do
        "$STIPPLE" convert $one -o there.stipple --format 2 --threads $count --force --quiet ||
            fail "convert --format 2 $1 $2"
        cmp there.stipple $two || fail "$1 $2: prep and convert write other bytes"
    done
    "$STIPPLE" convert $two -o back.stipple --format 1 --force --quiet || fail "convert --format 1 $1 $2"
    cmp back.stipple $one || fail "$1 $2: other bytes after coming back"
    "$STIPPLE" verify $two --quiet || fail "$1 $2: not sound"
    growth $one $two "$3"
}

"$STIPPLE" gen terrain -n 300000 -o terrain.ply --quiet || fail "gen terrain"
"$STIPPLE" gen bumpy -n 60000 -o bumpy.ply --quiet || fail "gen bumpy"
check terrain draco 5 1 3
check terrain zstd 4 3
check bumpy draco -4 3
check bumpy raw 1 1

"$STIPPLE" convert terrain-draco-2.stipple -o zstd.stipple --codec zstd --quiet || fail "convert --codec of version 2"
cmp zstd.stipple terrain-zstd-2.stipple || fail "another codec does not give the file that prep writes"
"$STIPPLE" info terrain-draco-2.stipple | found '2\.0' || fail "info does not say the version"
for version in 1 2; do
    "$STIPPLE" export terrain-draco-$version.stipple -o points$version.ply --quiet || fail "export of version $version"
done
cmp points1.ply points2.ply || fail "points differ"
if "$STIPPLE" --help | found '^  render'; then
    for version in 1 2; do
        "$STIPPLE" render terrain-draco-$version.stipple -o picture$version.png --size 200x200 --quiet ||
            fail "render of version $version"
    done
    cmp picture1.png picture2.png || fail "pictures differ"
fi

# A directory entry of a leaf is lost: the indices of its blocks bring it back.
directory=$(od -An -t u8 -j 32 -N 8 terrain-draco-2.stipple | tr -d ' ')
cp terrain-draco-2.stipple lost.stipple
head -c 256 /dev/zero | dd of=lost.stipple bs=1 seek=$((directory + 256)) conv=notrunc status=none
"$STIPPLE" verify --repair lost.stipple -o repaired.stipple --quiet || fail "a lost entry is not rebuilt"
cmp repaired.stipple terrain-draco-2.stipple || fail "a rebuilt entry differs from the lost one"
end_test
