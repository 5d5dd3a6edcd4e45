#!/usr/bin/env bash
# Tests `stipple convert`. Converting to another codec and back gives the same bytes, for any number
# of threads. Samples stay the same. A default threshold is kept, reported and drawn with. A failure
# leaves no half-written file.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
mkdir "$FOLDER/à b" && cd "$FOLDER/à b" || exit 1

"$STIPPLE" gen bumpy -n 60000 -o scan.ply --quiet && "$STIPPLE" prep scan.ply -o 'a ö.stipple' --quiet ||
    fail "no model"
"$STIPPLE" prep scan.ply -o z.stipple --codec zstd --quiet || fail "prep --codec zstd"

for codec in zstd raw draco; do
    for threads in 1 3; do
        run "$STIPPLE" convert 'a ö.stipple' -o "$codec$threads.stipple" --codec $codec --threads $threads
        expect_code 0
    done
    cmp "${codec}1.stipple" "${codec}3.stipple" || fail "$codec: other bytes with three threads"
    "$STIPPLE" info ${codec}1.stipple | found -E "^codec +$codec$" || fail "info does not say $codec"
    "$STIPPLE" info ${codec}1.stipple --json | found -E "\"codec\":[[:space:]]*\"$codec\"" || fail "info --json does not say $codec"
    "$STIPPLE" verify ${codec}1.stipple --quiet || fail "$codec: not sound"
    "$STIPPLE" convert ${codec}1.stipple -o back.stipple --codec draco --force --quiet
    cmp back.stipple 'a ö.stipple' || fail "$codec: other bytes after coming back"
    "$STIPPLE" export ${codec}1.stipple -o $codec.ply --quiet
done
cmp draco1.stipple 'a ö.stipple' || fail "converting to the file's own codec changes bytes"
cmp zstd1.stipple z.stipple || fail "prep and convert write other bytes"
cmp zstd.ply draco.ply && cmp raw.ply draco.ply || fail "points changed"

"$STIPPLE" convert z.stipple -o t.stipple --threshold 2.5 --quiet || fail "convert --threshold"
"$STIPPLE" verify t.stipple --quiet || fail "not sound with a threshold"
"$STIPPLE" info t.stipple >info.txt
grep -q '^threshold *2.5 px' info.txt || fail "info does not say the threshold"
"$STIPPLE" info t.stipple --json >info.json
grep -q '"threshold_px":[[:space:]]*2.5' info.json || fail "info --json does not"
"$STIPPLE" info z.stipple >info.txt
grep -q '^threshold' info.txt && fail "info says a threshold where none is"
"$STIPPLE" convert t.stipple -o t1.stipple --codec draco --quiet
"$STIPPLE" info t1.stipple >info.txt
grep -q '^threshold *2.5 px' info.txt || fail "convert loses the threshold"
if "$STIPPLE" --help | found '^  render'; then
    "$STIPPLE" render t.stipple -o default.png --size 200x200 --quiet || fail "render"
    "$STIPPLE" render z.stipple -o told.png --size 200x200 --threshold 2.5 --quiet
    "$STIPPLE" render t.stipple -o one.png --size 200x200 --threshold 1 --quiet
    "$STIPPLE" render z.stipple -o plain.png --size 200x200 --quiet
    cmp default.png told.png || fail "the model's threshold is not drawn with"
    cmp one.png plain.png || fail "--threshold does not come before the model's"
    cmp -s default.png plain.png && fail "2.5 px and 1 px look the same"
fi

# A directory entry of a leaf is lost: its payload of codec 2 brings it back.
directory=$(od -An -t u8 -j 32 -N 8 z.stipple | tr -d ' ')
cp z.stipple lost.stipple
head -c 256 /dev/zero | dd of=lost.stipple bs=1 seek=$((directory + 256)) conv=notrunc status=none
"$STIPPLE" verify --repair lost.stipple -o repaired.stipple --quiet || fail "a lost entry is not rebuilt"
cmp repaired.stipple z.stipple || fail "a rebuilt entry differs from the lost one"

run "$STIPPLE" convert z.stipple -o z.stipple --codec draco --force
expect_code 1
run "$STIPPLE" convert z.stipple -o t.stipple --codec draco
expect_code 1
run "$STIPPLE" convert z.stipple
expect_code 2
run "$STIPPLE" convert z.stipple -o n.stipple --threshold 0
expect_code 2
run "$STIPPLE" convert z.stipple -o n.stipple --codec gzip
expect_code 2
run "$STIPPLE" convert z.stipple -o nowhere/n.stipple
expect_code 1
head -c 100000 z.stipple >cut.stipple
run "$STIPPLE" convert cut.stipple -o n.stipple
expect_code 1
cp z.stipple bad.stipple
printf 'x' | dd of=bad.stipple bs=1 seek=60000 conv=notrunc status=none
for options in '' '--codec draco'; do
    run "$STIPPLE" convert bad.stipple -o n.stipple $options
    expect_code 1
done
[ -e n.stipple ] && fail "a failed conversion left a file"
# Simulates a full disk: files may not grow beyond 100 blocks of 1024 bytes.
(ulimit -f 100; trap '' XFSZ; "$STIPPLE" convert z.stipple -o n.stipple --codec raw --quiet 2>full.txt)
[ -e n.stipple ] && fail "a full disk left a file"
# Tries a read-only folder and a really full disk, if the system can make them.
mkdir locked && chmod 555 locked
if ! touch locked/try 2>/dev/null; then
    run "$STIPPLE" convert z.stipple -o locked/n.stipple
    expect_code 1
    expect_text err locked/n.stipple
fi
if mkdir small && mount -t tmpfs -o size=64k stipple-test small 2>/dev/null; then
    for options in '' '--threshold 3' '--codec raw'; do
        # shellcheck disable=SC2086
        run "$STIPPLE" convert z.stipple -o small/n.stipple $options
        expect_code 1
        expect_text err "the disk is full"
        [ -z "$(ls -A small)" ] || fail "a full disk: left $(ls -A small)"
    done
    umount small
fi
ls | found 'n.stipple.' && fail "temporary files are left"
end_test
