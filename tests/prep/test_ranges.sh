#!/usr/bin/env bash
# Tests the largest and the smallest numbers of a model: within the limits a picture does not depend
# on the unit; beyond them prep refuses.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# A ball of 1500 points; its radius is a power of two, exact in 17 digits.
ball() { # exponent
    awk -v e="$1" 'BEGIN {
        printf "ply\nformat ascii 1.0\nelement vertex 1500\nproperty double x\nproperty double y\n"
        printf "property double z\nend_header\n"
        s = 2 ^ e
        for (i = 0; i < 1500; i++) {
            z = 1 - (2 * i + 1) / 1500; r = sqrt(1 - z * z); t = 2.399963229728653 * i
            printf "%.17g %.17g %.17g\n", r * cos(t) * s, r * sin(t) * s, z * s
        }
    }' >"$FOLDER/ball.ply"
    run "$STIPPLE" prep "$FOLDER/ball.ply" -o "$FOLDER/ball.stipple" --force --quiet
}

points() { # lines of coordinates
    {
        printf 'ply\nformat ascii 1.0\nelement vertex %d\nproperty double x\nproperty double y\n' $#
        printf 'property double z\nend_header\n'
        printf '%s\n' "$@"
    } >"$FOLDER/points.ply"
    rm -f "$FOLDER/points.stipple"
    run "$STIPPLE" prep "$FOLDER/points.ply" -o "$FOLDER/points.stipple" --quiet
}

draws=0
"$STIPPLE" --help | found '^  render ' && draws=1
for e in 0 49 -49 20 -20; do
    ball $e
    expect_code 0
    run "$STIPPLE" verify "$FOLDER/ball.stipple" --quiet
    expect_code 0
    [ $draws = 1 ] || continue
    run "$STIPPLE" render "$FOLDER/ball.stipple" -o "$FOLDER/$e.png" --size 64x64 --quiet
    expect_code 0
    cmp -s "$FOLDER/0.png" "$FOLDER/$e.png" || fail "a ball of radius 2^$e looks otherwise"
done
for e in 50 64 83; do
    ball $e
    expect_failure "larger units"
done
for e in -51 -64 -83 -300; do
    ball $e
    expect_failure "smaller units"
done

points "0 0 0" "1e-38 0 0" "0 1e-38 0" "5e16 0 0"
expect_failure "a coordinate is 5e+16"
[ ! -e "$FOLDER/points.stipple" ] || fail "$command: wrote a file"
# What programs write for no coordinate, as GDAL and VTK do, spoils no scan, nor its precision.
points "0 0 0" "0.125 0 0" "0 0.125 0" "3.4028235e38 0 0" "0 -1e30 0" "0 0 1.7976931348623157e308"
expect_code 0
run "$STIPPLE" prep "$FOLDER/points.ply" -o "$FOLDER/points.stipple" --force
expect_text err "6 points read, 3 stored, 3 rejected (3 not finite)"
for far in 1e3 1e9 9e14; do
    for near in 1e-38 1e-20 1e-9 1e-3; do
        points "0 0 0" "$near 0 0" "0 $near 0" "$far 0 0"
        expect_code 0
        run "$STIPPLE" verify "$FOLDER/points.stipple" --quiet
        expect_code 0
    done
done
# Eyes and angles beyond what any model needs.
if [ $draws = 1 ]; then
    ball 0
    for options in "--eye 1e18,0,0" "--eye 0,0,4 --look 1e300,0,0" "--fovy 1e-9"; do
        # shellcheck disable=SC2086
        run "$STIPPLE" render "$FOLDER/ball.stipple" -o "$FOLDER/far.png" --size 64x64 --quiet $options
        expect_failure "the camera"
    done
    for options in "--eye 1e17,0,0" "--fovy 1e-5" "--fovy 179.999"; do
        # shellcheck disable=SC2086
        run "$STIPPLE" render "$FOLDER/ball.stipple" -o "$FOLDER/far.png" --size 64x64 --quiet --force $options
        expect_code 0
    done
fi
points "3 4 5" "3 4 5"
expect_code 0
end_test
