#!/usr/bin/env bash
# Tests `stipple compare`: what it prints, in both forms, and how it fails.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$FOLDER" || exit 1

# Writes an 8x4 picture as uncompressed TIFF, RGBA 8, with the greys of the left and the right half
# and the alpha of the right half.
tiff() { # file left right alpha
    local pixel left right row='' image='' i
    hex() { printf '\\x%02x' "$1"; }
    left=$(hex "$2")$(hex "$2")$(hex "$2")$(hex 255)
    right=$(hex "$3")$(hex "$3")$(hex "$3")$(hex "$4")
    for pixel in "$left" "$right"; do
        for ((i = 0; i < 4; i++)); do row+=$pixel; done
    done
    for ((i = 0; i < 4; i++)); do image+=$row; done
    entry() { # tag type count value, little-endian
        printf '\\x%02x\\x%02x\\x%02x\\x00\\x%02x\\x00\\x00\\x00\\x%02x\\x00\\x00\\x00' \
            $(($1 & 255)) $(($1 >> 8)) "$2" "$3" "$4"
    }
    # header, then pixels at 8 (128 bytes), bits per sample at 136, directory at 144
    # shellcheck disable=SC2059
    printf "II\\x2a\\x00\\x90\\x00\\x00\\x00$image\\x08\\x00\\x08\\x00\\x08\\x00\\x08\\x00\\x0b\\x00$(
        entry 256 3 1 8
        entry 257 3 1 4
        entry 258 3 4 136
        entry 259 3 1 1
        entry 262 3 1 2
        entry 273 4 1 8
        entry 277 3 1 4
        entry 278 3 1 4
        entry 279 4 1 128
        entry 284 3 1 1
        entry 338 3 1 2
    )\\x00\\x00\\x00\\x00" >"$1"
}

tiff a.tif 110 110 255
tiff b.tif 100 100 255
tiff half.tif 100 0 0
tiff empty.tif 0 0 0
cp a.tif "a name with ä.tif"

run "$STIPPLE" compare a.tif b.tif
expect_code 0
expect_empty err
expect_lines out 7
expect_text out "psnr_db 28.1308" # 20 log10(255 / 10)
expect_text out "psnr_inside_db 28.1308"
expect_text out "coverage_a 1.000000"
expect_text out "holes 0"
expect_text out "spill 0"

run "$STIPPLE" compare "a name with ä.tif" a.tif --json
expect_code 0
expect_empty err
expect_lines out 1
expect_text out '"psnr_db": 999.0000'
expect_text out '"ssim": 1.000000'
expect_text out '"coverage_b": 1.000000'

# The right half is missing; nothing lies beyond the picture's edges.
run "$STIPPLE" compare half.tif b.tif --json
expect_code 0
expect_text out '"coverage_a": 0.500000'
expect_text out '"holes": 16'
expect_text out '"spill": 0'
expect_text out '"psnr_inside_db": 999.0000'
run "$STIPPLE" compare b.tif half.tif
expect_code 0
expect_text out "spill 12"
expect_text out "holes 0"

# A failure is one sentence on stderr and exit 1. Wrong usage is exit 2.
expect_failure() { # text
    expect_code 1
    expect_empty out
    expect_lines err 1
    expect_text err "$1"
}
run "$STIPPLE" compare a.tif none.tif
expect_failure "none.tif"
head -c 100 a.tif >cut.tif
run "$STIPPLE" compare a.tif cut.tif
expect_failure "cut.tif"
echo "no picture" >text.png
run "$STIPPLE" compare text.png a.tif
expect_failure "text.png"
tiff black.tif 0 0 0
run "$STIPPLE" compare black.tif empty.tif
expect_code 0 # both cover the left half, in black
expect_text out "psnr_db 999.0000"

run "$STIPPLE" compare a.tif
expect_code 2
expect_empty out
run "$STIPPLE" compare a.tif b.tif a.tif
expect_code 2
run "$STIPPLE" compare a.tif b.tif --wrong
expect_usage "--wrong"
run "$STIPPLE" compare --help
expect_code 0
expect_empty err
for word in psnr_db psnr_inside_db ssim coverage_a coverage_b holes spill; do
    expect_text out "$word"
done
end_test
