#!/usr/bin/env bash
# Tests files whose table of blocks is packed: a reader written from SPEC.md alone finds the same records; damage is
# said in one sentence, and mended without loss.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$FOLDER" || exit 1

"$STIPPLE" gen bumpy -n 200000 -o scan.ply --quiet && "$STIPPLE" prep scan.ply -o sound.stipple --quiet || fail "no model"

u64() { # file, byte
    od -An -t u8 -j "$2" -N 8 "$1" | tr -d ' '
}

# The packed table is the first section.
[ "$(head -c 172 sound.stipple | tail -c 4)" = BLK3 ] || fail "no packed table"
table=$(u64 sound.stipple 176)
bytes=$(u64 sound.stipple 184)
count=$(($(od -An -t u4 -j 172 -N 4 sound.stipple) >> 1))
[ "$bytes" -lt $((count * 56 * 3 / 4)) ] || fail "$count records take $bytes bytes"

# Versions of a file: as written before, and converted to and fro.
run "$STIPPLE" convert sound.stipple -o one.stipple --format 1 --quiet
expect_code 0
run "$STIPPLE" convert one.stipple -o two.stipple --format 2 --quiet
expect_code 0
cmp -s sound.stipple two.stipple || fail "another file after version 1"

wipe() { # file, byte, count
    head -c "$3" /dev/zero | dd of="$1" bs=1 seek="$2" conv=notrunc status=none
}

# Repairs damaged.stipple; the points are all there.
repair() { # what was damaged
    run "$STIPPLE" verify damaged.stipple --quiet
    [ "$code" != 0 ] || fail "$1: verify finds nothing"
    rm -f repaired.stipple
    run "$STIPPLE" verify --repair damaged.stipple -o repaired.stipple
    expect_code 0
    expect_text out "nothing is lost"
    run "$STIPPLE" verify repaired.stipple --quiet
    expect_code 0
}

cp sound.stipple damaged.stipple
printf '\x55' | dd of=damaged.stipple bs=1 seek=$((table + 1000)) conv=notrunc status=none
cmp -s sound.stipple damaged.stipple && printf '\x54' | dd of=damaged.stipple bs=1 seek=$((table + 1000)) conv=notrunc status=none
repair "a byte of the table"
cmp -s sound.stipple repaired.stipple || fail "a byte of the table: other bytes"

cp sound.stipple damaged.stipple
wipe damaged.stipple $((table + 200)) 300
for command in "verify damaged.stipple" "export damaged.stipple -o out.ply"; do
    # shellcheck disable=SC2086
    run "$STIPPLE" $command --quiet
    [ "$code" != 0 ] || continue
    expect_failure "damaged.stipple"
done
repair "a part of the table"
cmp -s sound.stipple repaired.stipple || fail "a part of the table: other bytes"

cp sound.stipple damaged.stipple
wipe damaged.stipple 0 2048
repair "both headers"
"$STIPPLE" export sound.stipple -o sound.ply --quiet && "$STIPPLE" export repaired.stipple -o repaired.ply --quiet &&
    cmp -s sound.ply repaired.ply || fail "both headers: other points"

# Where the table ends is told from the metadata, which is kept.
told() { # file
    "$STIPPLE" info "$1" | grep -E '^(orientation|lambda|displacement) '
}
cp sound.stipple damaged.stipple
wipe damaged.stipple 0 2048
wipe damaged.stipple "$table" 300
repair "both headers and the table"
[ "$(told repaired.stipple)" = "$(told sound.stipple)" ] || fail "both headers and the table: the metadata is lost"

# Attributes that lay beside the table are lost with it, which is said.
awk 'BEGIN { print "x,y,z,heat"; for (i = 0; i < 150000; i++) print i % 400, int(i / 400), sin(i / 37), i * 7919 % 9973 }' >heat.csv
"$STIPPLE" prep heat.csv -o heat.stipple --attributes all --quiet || fail "no model with attributes"
[ "$(head -c 204 heat.stipple | tail -c 4)" = BLK3 ] || fail "no packed table behind the attributes' numbers"
cp heat.stipple damaged.stipple
wipe damaged.stipple 0 2048
wipe damaged.stipple $(($(u64 heat.stipple 208) + 200)) 300
run "$STIPPLE" verify --repair damaged.stipple -o repaired.stipple --force
expect_code 1
expect_text err "its attributes are lost"

# The reader from SPEC.md.
if command -v python3 >/dev/null && command -v zstd >/dev/null; then
    run python3 -c "
import sys
sys.path.insert(0, '$SOURCE/tests/known')
import read
data = open('sound.stipple', 'rb').read()
header = read.Header(data)
entries = read.read_directory(data, header)
found = [read.read_records(header, e, f'chunk {e.id}') for e in entries]
print(sum(len(f) for f in found), sum(r.counts[0] for f in found for r in f) == sum(e.counts[0] for e in entries))"
    expect_code 0
    expect_text out "$count True"
fi
end_test
