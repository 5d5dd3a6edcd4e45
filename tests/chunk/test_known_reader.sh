#!/usr/bin/env bash
# Tests that tests/known/read.py, a reader written from SPEC.md alone, finds the same as our reader,
# in the known-answer files and in new models of every codec. It must also say what is wrong with
# damaged files. read.py is slow: each codec, version and place of damage is read, and in long runs all
# combinations.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
command -v python3 >/dev/null || skip_test "python3 is not installed"
command -v zstd >/dev/null || skip_test "the program zstd is not installed"
python=$(python3 -c 'import sys; print(sys.executable)') # python3 may be a script that looks for it each time
known=$SOURCE/tests/known
printer=$PWD/test_known
[ -x "$printer" ] || skip_test "test_known, which prints what our reader finds, is not built"

read_known() { # file
    run "$python" "$known/read.py" "$1"
    expect_code 0
    expect_empty err
}

test_answers() {
    local file name count=0
    for file in "$known"/files/*.stipple "$known"/files/*/*.stipple; do
        name=${file%_*}
        read_known "$file"
        cmp "$FOLDER/out" "$name.samples" || fail "read.py finds other samples in ${file##*/}"
        count=$((count + 1))
    done
    [ $count -ge 130 ] || fail "$count known-answer files, expected 130"
    for file in "$known"/files/attributes_2_0_*.stipple; do
        run "$python" "$known/attributes.py" "$file"
        expect_code 0
        cmp "$FOLDER/out" "$known/files/attributes_2_0.numbers" || fail "attributes.py finds other numbers in ${file##*/}"
    done
}

# Builds a model of the scan with each codec: our reader must print the same text for all, and read.py for those
# named. The first line must match $3.
compare_models() { # codecs that read.py reads, scan, first line, options
    local codec read=$1
    shift
    ! is_long || read='raw draco zstd'
    for codec in raw draco zstd; do
        "$STIPPLE" prep "$1" -o "$FOLDER/$codec.stipple" --codec $codec --quiet --force "${@:3}" ||
            fail "no model"
        "$printer" "$FOLDER/$codec.stipple" >"$FOLDER/$codec.samples" || fail "our reader fails: $codec"
        [[ " $read " == *" $codec "* ]] || continue
        read_known "$FOLDER/$codec.stipple"
        cmp "$FOLDER/out" "$FOLDER/$codec.samples" || fail "read.py finds other samples: $codec"
    done
    cmp "$FOLDER/raw.samples" "$FOLDER/draco.samples" || fail "draco holds other samples than raw"
    cmp "$FOLDER/raw.samples" "$FOLDER/zstd.samples" || fail "zstd holds other samples than raw"
    head -1 "$FOLDER/raw.samples" | found "$2" || fail "another model: $(head -1 "$FOLDER/raw.samples")"
}

# The models: a closed surface, which needs 32,768 points, and a plant of two tiers.
test_new_models() {
    "$STIPPLE" gen bumpy -n 33000 -o "$FOLDER/scan.ply" --quiet || fail "no scan"
    compare_models zstd "$FOLDER/scan.ply" "^version 1.2 attributes 193 " --format 1
    compare_models draco "$FOLDER/scan.ply" "^version 2.0 attributes 193 "
    "$STIPPLE" gen tree -n 4000 -o "$FOLDER/leaves.ply" --mesh "$FOLDER/plant.ply" --quiet || fail "no plant"
    compare_models 'raw draco' "$FOLDER/plant.ply" "^version 1.2 attributes 177 chunks 3 " --lines auto --format 1
    compare_models 'raw zstd' "$FOLDER/plant.ply" "^version 2.0 attributes 177 chunks 3 " --lines auto
}

# The damage: a changed byte at many places, a cut file, and an extended one.
# In a file of version 2 also: both copies of the header, a block, the table of blocks.
test_damage_of_blocks() {
    local file size at count=0
    for file in "$known"/files/{blocks_,scale_,squares_,tight/points_,records/,ladder/,coarse/,known/,known/level_,known/depth_,corners/,sides/,turns/,painted/,parents/,strides/,placed/depth_,slanted/,signed/}2_0_draco.stipple; do
        size=$(wc -c <"$file")
        for at in 9 600 1024 1500 2100 $((size - 3200)) $((size - 400)); do
            count=$((count + 1)) # seven places: a file gets those that the one before misses
            is_long || [ $((count % 2)) = 1 ] || continue
            cp "$file" "$FOLDER/bad.stipple"
            printf '\xa5' | dd of="$FOLDER/bad.stipple" bs=1 seek="$at" conv=notrunc status=none
            run "$python" "$known/read.py" "$FOLDER/bad.stipple"
            expect_failure bad.stipple
        done
    done
}

test_damage() {
    local file=$known/files/lines_1_1_zstd.stipple size at
    size=$(wc -c <"$file")
    for at in 0 9 100 250 256 3000 $((size / 2)) $((size - 700)) $((size - 300)) $((size - 1)); do
        cp "$file" "$FOLDER/bad.stipple"
        printf '\xa5' | dd of="$FOLDER/bad.stipple" bs=1 seek="$at" conv=notrunc status=none
        cmp -s "$file" "$FOLDER/bad.stipple" && fail "byte $at is not changed"
        run "$python" "$known/read.py" "$FOLDER/bad.stipple"
        expect_failure bad.stipple
    done
    head -c $((size - 8)) "$file" >"$FOLDER/bad.stipple"
    run "$python" "$known/read.py" "$FOLDER/bad.stipple"
    expect_failure "expected $size"
    { cat "$file" && echo; } >"$FOLDER/bad.stipple"
    run "$python" "$known/read.py" "$FOLDER/bad.stipple"
    expect_failure "expected $size"
}

# A survey, whose positions have a scale of 0.01: its raw and Draco models hold the same.
test_scale() {
    "$STIPPLE" gen terrain -n 3000 -o "$FOLDER/scan.ply" --quiet --force || fail "no scan"
    "$python" - "$FOLDER/scan.ply" >"$FOLDER/scan.txt" <<'END'
import struct
import sys
data = open(sys.argv[1], "rb").read()
for x, y, z, *_ in struct.iter_unpack("<3f3B", data[data.index(b"end_header\n") + 11:]):
    print(f"{20 * x + 637000:.2f} {20 * y + 851000:.2f} {20 * z:.2f}")
END
    compare_models 'raw draco' "$FOLDER/scan.txt" "^version 2.0 " --columns x,y,z
}

test_answers
test_new_models
test_scale
test_damage
test_damage_of_blocks
end_test
