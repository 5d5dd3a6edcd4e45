#!/usr/bin/env bash
# Tests `prep --normal-bits`: what it says, that files are sound and smaller, that given normals are
# rounded only if the option asks for it, and that versions 1 and 2 hold the same samples. Each number of bits is tried
# with Draco, some with zstd; in long runs all are.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$FOLDER" || exit 1

bits_of() { # model
    "$STIPPLE" info "$1" --json | sed -n 's/.*"normal_bits":[[:space:]]*\([0-9]*\).*/\1/p' | head -1
}

expect_bits() { # model bits
    [ "$(bits_of "$1")" = "$2" ] || fail "$1: $(bits_of "$1") bits, expected $2"
    run "$STIPPLE" info "$1"
    found "of 2 x $2 bits" out || fail "$command: does not say the bits"
}

prepare() { # scan model options...
    run "$STIPPLE" prep "$1" -o "$2" --force --stats stats.json "${@:3}"
    expect_code 0
    run "$STIPPLE" verify "$2"
    expect_code 0
}

test_every_grid() {
    local bits size codecs before=999999999
    for bits in 12 11 10 9 8 7 6; do
        codecs='draco zstd'
        is_long || [ $((bits % 3)) = 0 ] || codecs=draco
        for codec in $codecs; do
            prepare noisy.ply $codec.stipple --normal-bits $bits --codec $codec
            expect_bits $codec.stipple $bits
            "$STIPPLE" convert $codec.stipple -o there.stipple --format 1 --force --quiet || fail "convert"
            "$STIPPLE" convert there.stipple -o back.stipple --format 2 --force --quiet || fail "convert"
            cmp $codec.stipple back.stipple || fail "$codec, $bits bits: conversion changes it"
        done
        if [ "$codecs" != draco ]; then
            "$STIPPLE" convert zstd.stipple -o other.stipple --codec draco --force --quiet || fail "convert"
            cmp draco.stipple other.stipple || fail "$bits bits: codecs hold other samples"
        fi
        [ $bits != 12 ] || cp draco.stipple whole.stipple
        size=$(stat -c %s draco.stipple)
        [ "$size" -lt "$before" ] || fail "$bits bits take $size bytes, one more $before"
        before=$size
    done
}

# More noise leaves fewer bits; smooth models keep many.
test_auto() {
    local quiet noisy
    prepare smooth.ply smooth.stipple
    quiet=$(bits_of smooth.stipple)
    [ "$quiet" -ge 9 ] || fail "a smooth surface keeps $quiet bits"
    run "$STIPPLE" prep noisy.ply -o noisy.stipple --force --stats stats.json
    expect_code 0
    expect_text err "normals are rounded to 2 x"
    run "$STIPPLE" verify noisy.stipple
    expect_code 0
    noisy=$(bits_of noisy.stipple)
    [ "$noisy" -lt "$quiet" ] || fail "a noisy surface keeps $noisy bits, a smooth one $quiet"
    [ "$noisy" -ge 6 ] || fail "a noisy surface keeps $noisy bits"
    [ "$(field normal_bits)" = "$noisy" ] || fail "--stats has other bits: $(field normal_bits)"
    for threads in 1 3; do
        "$STIPPLE" prep noisy.ply -o again.stipple --threads $threads --force --quiet || fail "prep"
        cmp noisy.stipple again.stipple || fail "$threads threads write other bytes"
    done
    [ "$(stat -c %s noisy.stipple)" -lt "$(stat -c %s whole.stipple)" ] || fail "rounding saves nothing"
}

step_of() { # model
    "$STIPPLE" info "$1" --json | sed -n 's/.*"normal_step":[[:space:]]*\([0-9]*\).*/\1/p' | head -1
}

# Between two numbers of bits there are three steps more. Only Draco in blocks has them.
test_steps() {
    local step
    prepare rough.ply rough.stipple
    step=$(step_of rough.stipple)
    [ "${step:-0}" -gt 8 ] && [ "$step" -lt 16 ] || fail "rounded by a step of '$step'"
    [ "$(bits_of rough.stipple)" = 9 ] || fail "step $step: $(bits_of rough.stipple) bits"
    run "$STIPPLE" info rough.stipple
    found "of 2 x 8\.[0-9]* bits" out || fail "$command: does not say the bits"
    prepare rough.ply nine.stipple --normal-bits 9
    [ "$(stat -c %s rough.stipple)" -lt "$(stat -c %s nine.stipple)" ] || fail "step $step saves nothing"
    prepare rough.ply zstd.stipple --codec zstd
    [ "$(step_of zstd.stipple)" = "$step" ] || fail "zstd: a step of $(step_of zstd.stipple)"
    prepare rough.ply first.stipple --format 1
    [ -z "$(step_of first.stipple)" ] || fail "format 1: a step of $(step_of first.stipple)"
    cp rough.stipple grown.stipple
    "$STIPPLE" prep noisy.ply --append -o grown.stipple --quiet || fail "append"
    [ "$(step_of grown.stipple)" = "$step" ] || fail "appended points change the step"
}

test_given() {
    prepare given.ply given.stipple
    prepare given.ply whole.stipple --normal-bits 12
    cmp given.stipple whole.stipple || fail "given normals are rounded"
    prepare given.ply eight.stipple --normal-bits 8
    expect_bits eight.stipple 8
    [ "$(stat -c %s eight.stipple)" -lt "$(stat -c %s whole.stipple)" ] || fail "rounding saves nothing"
}

test_wrong() {
    local bits
    for bits in 5 13 0 x 8.5 -1; do
        run "$STIPPLE" prep noisy.ply -o wrong.stipple --normal-bits $bits
        expect_failure normal-bits
        [ ! -e wrong.stipple ] || fail "--normal-bits $bits writes a file"
    done
}

"$STIPPLE" gen bumpy -n 20000 -o smooth.ply --quiet || fail "gen"
"$STIPPLE" gen statue -n 20000 --noise 0.2 -o noisy.ply --quiet || fail "gen"
"$STIPPLE" gen terrain -n 20000 --noise 0.3 -o rough.ply --quiet || fail "gen"
"$STIPPLE" gen bumpy -n 20000 --noise 0.2 --normals -o given.ply --quiet || fail "gen"
test_every_grid
test_auto
test_steps
test_given
test_wrong
end_test
