#!/usr/bin/env bash
# Tests the command `stipple verify --repair`: its exit codes, its messages, what it writes, and
# what it never does.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$FOLDER" || exit 1
points=200000

"$STIPPLE" gen bumpy -n $points -o scan.ply --quiet && "$STIPPLE" prep scan.ply -o sound.stipple --format 1 --quiet ||
    fail "no model"
"$STIPPLE" export sound.stipple -o sound.ply --quiet || fail "no export"

u64() { # file, byte
    od -An -t u8 -j "$2" -N 8 "$1" | tr -d ' '
}

u32() {
    od -An -t u4 -j "$2" -N 4 "$1" | tr -d ' '
}

# damage BYTE COUNT: damaged.stipple becomes the sound file with COUNT bytes wiped from BYTE on.
damage() {
    cp sound.stipple damaged.stipple
    head -c "$2" /dev/zero | dd of=damaged.stipple bs=1 seek="$1" conv=notrunc status=none
}

repair() { # further words
    rm -f repaired.stipple
    run "$STIPPLE" verify --repair damaged.stipple --quiet "$@"
}

vertices() { # F.ply
    head -c 400 "$1" | grep -a '^element vertex' | cut -d ' ' -f 3
}

# Prints the points of a PLY, one per line, sorted.
sorted_points() {
    local header
    header=$(head -c 2000 "$1" | grep -a -b '^end_header' | cut -d : -f 1)
    od -An -v -t x1 -w"$2" -j $((header + 11)) "$1" | sort
}

# The last leaf has the last entry of the directory.
directory=$(u64 sound.stipple 32)
chunks=$(u32 sound.stipple 16)
leaf=$((directory + 256 * (chunks - 1)))
payload=$(u64 sound.stipple $leaf)
level_0=$(u32 sound.stipple $((leaf + 12)))
leaf_points=$(u32 sound.stipple $((leaf + 60)))
[ "$chunks" -gt 1 ] && [ "$chunks" -le 64 ] || fail "$chunks chunks: the test needs 2 to 64, one page"

# Wrong arguments.
cp sound.stipple damaged.stipple
run "$STIPPLE" verify damaged.stipple --repair
expect_usage "add -o OUT.stipple, or --force"
run "$STIPPLE" verify damaged.stipple -o repaired.stipple
expect_usage "without --repair"
run "$STIPPLE" verify damaged.stipple --repair -o damaged.stipple --force
expect_failure "is also an input"

# A sound file: nothing is written.
run "$STIPPLE" verify --repair sound.stipple -o repaired.stipple
expect_code 0
expect_text out "nothing to repair, nothing written"
[ ! -e repaired.stipple ] || fail "a sound file was written again"

# A repair without loss writes the original bytes.
damage 20 64
run "$STIPPLE" verify damaged.stipple --quiet
expect_failure "damaged.stipple"
rm -f repaired.stipple
run "$STIPPLE" verify --repair damaged.stipple -o repaired.stipple
expect_code 0
expect_text out "the header is rebuilt; its checksum proves it"
expect_text out "repaired.stipple: repaired: nothing is lost"
cmp repaired.stipple sound.stipple || fail "the header was not brought back"
run "$STIPPLE" verify --repair damaged.stipple -o repaired.stipple
expect_failure "exists already"
run "$STIPPLE" verify --repair damaged.stipple --force --quiet
expect_code 0
cmp damaged.stipple sound.stipple || fail "the file was not repaired in its place"

# A repair with loss names the lost leaf and exits with 1. The output is sound, and exactly that
# leaf's points are missing.
damage $((payload + level_0 + 100)) 400
repair -o repaired.stipple
expect_code 1
expect_lines err 1
expect_text err "but $leaf_points points are lost"
run "$STIPPLE" verify repaired.stipple --quiet
expect_code 0
run "$STIPPLE" info repaired.stipple
expect_text out "repaired       1 time: $leaf_points points are lost"
run "$STIPPLE" export repaired.stipple -o left.ply
expect_code 0
expect_text err "stand in for lost points are left out"
[ "$(vertices left.ply)" = $((points - leaf_points)) ] || fail "$(vertices left.ply) points are left"
row=$(($(stat -c %s sound.ply) / points)) # a row's bytes; the header is shorter than a row a point
sorted_points sound.ply "$row" >all.txt
sorted_points left.ply "$row" >left.txt
[ "$(comm -13 all.txt left.txt | wc -l)" = 0 ] || fail "the repaired file has points that the sound file lacks"
[ "$(comm -23 all.txt left.txt | wc -l)" = "$leaf_points" ] || fail "other points are lost, too"

# The output draws: the region of the lost leaf is covered as before.
if "$STIPPLE" render --help >/dev/null 2>&1; then
    for model in sound repaired; do
        run "$STIPPLE" render "$model.stipple" -o "$model.png" --size 128x128 --quiet
        [ "$code" = 0 ] || break
    done
    if [ "$code" = 0 ]; then
        run "$STIPPLE" compare sound.png repaired.png --json
        expect_code 0
        holes=$(grep -o '"holes":[^,}]*' out | tr -d ' ' | cut -d : -f 2)
        awk -v h="$holes" 'BEGIN { exit !(h != "" && h < 0.01) }' || fail "holes where the leaf was: $holes"
    fi
fi

# A repair with loss never replaces the damaged file.
cp damaged.stipple before
repair --force
expect_failure "give another output with -o"
cmp -s before damaged.stipple || fail "the damaged file was changed"

# If nothing can be repaired, one sentence says so, and nothing is written.
cp sound.stipple damaged.stipple
truncate -s $((directory - 10)) damaged.stipple
repair -o repaired.stipple
expect_failure "cannot be repaired"
[ ! -e repaired.stipple ] || fail "something was written of a file beyond repair"
echo "no chunk file" >damaged.stipple
repair -o repaired.stipple
expect_failure "not a stipple chunk file"
repair -o none/repaired.stipple
expect_failure "none/repaired.stipple"

# Tries a read-only folder and a full disk, if the system can make them.
damage $((payload + level_0 + 100)) 400
mkdir locked && chmod 555 locked
if ! touch locked/try 2>/dev/null; then
    repair -o locked/repaired.stipple
    expect_failure "locked/repaired.stipple"
fi
for what in "$((payload + level_0 + 100)) 400" "20 64"; do # a new model, and a copy
    # shellcheck disable=SC2086
    damage $what
    if mkdir -p small && mount -t tmpfs -o size=64k stipple-test small 2>/dev/null; then
        repair -o small/repaired.stipple
        expect_failure "the disk is full"
        [ -z "$(ls -A small)" ] || fail "a full disk: left $(ls -A small)"
        umount small
    fi
done
[ -z "$(find . -name '*.part')" ] || fail "left $(find . -name '*.part')"
end_test
