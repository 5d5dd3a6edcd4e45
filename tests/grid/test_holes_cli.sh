#!/usr/bin/env bash
# Tests `prep --holes`: which rule a model has is in its metadata and in `info`; keep is the default, byte for byte;
# the same model comes of several files; other words, and inputs whose missing samples nobody knows, are refused.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# Heights with holes: columns from, columns to.
heights() {
    awk -v from="$1" -v to="$2" 'BEGIN {
        printf "ncols %d\nnrows 150\nxllcorner %d\nyllcorner 0\ncellsize 1\nnodata_value -9999\n", to - from, from
        for (j = 0; j < 150; j++) {
            for (i = from; i < to; i++)
                printf "%s ", (i * 7919 + j * 104729) % 31 == 0 || (i - 80)^2 + (j - 70)^2 < 90 ? -9999 : sprintf("%.2f", 9 * sin(i / 20))
            printf "\n"
        }
    }'
}
heights 0 200 >"$FOLDER/all.asc"
heights 0 90 >"$FOLDER/a.asc"
heights 90 200 >"$FOLDER/b.asc"

model() { # name, options...
    run "$STIPPLE" prep -q --force -o "$FOLDER/$1.stipple" "${@:2}"
    expect_code 0
}
model none "$FOLDER/all.asc"
model keep "$FOLDER/all.asc" --holes keep
model grow "$FOLDER/all.asc" --holes grow
model tiles "$FOLDER/a.asc" "$FOLDER/b.asc" --holes grow
cmp -s "$FOLDER/none.stipple" "$FOLDER/keep.stipple" || fail "keep is not the default"
cmp -s "$FOLDER/keep.stipple" "$FOLDER/grow.stipple" && fail "grow is keep"
run "$STIPPLE" verify "$FOLDER/grow.stipple"
expect_code 0
run "$STIPPLE" info "$FOLDER/keep.stipple"
expect_text out "holes          keep their width within the threshold"
run "$STIPPLE" info "$FOLDER/grow.stipple"
expect_text out "holes          only grow: nothing is drawn over a missing sample"
run "$STIPPLE" info "$FOLDER/tiles.stipple"
expect_text out "holes          only grow"

# A model that is added to is no grid any more.
run "$STIPPLE" prep --append "$FOLDER/b.asc" -o "$FOLDER/grow.stipple"
expect_code 0
run "$STIPPLE" info --json "$FOLDER/grow.stipple"
grep -q '"holes"' "$FOLDER/out" && fail "a model that was added to says that holes grow"
run "$STIPPLE" verify "$FOLDER/grow.stipple"
expect_code 0

run "$STIPPLE" prep "$FOLDER/all.asc" --holes shrink -o "$FOLDER/no.stipple"
expect_code 2
expect_text err "--holes"
run "$STIPPLE" prep --append "$FOLDER/b.asc" --holes grow -o "$FOLDER/grow.stipple"
expect_code 2
expect_text err "leave out"
seq 300 | awk '{ print $1 % 17, int($1 / 17), 0 }' >"$FOLDER/points.xyz"
run "$STIPPLE" prep "$FOLDER/points.xyz" --holes grow -o "$FOLDER/no.stipple"
expect_code 1
expect_text err "--holes grow: the input does not stay one grid of heights"
awk 'NR == 1 { print "ncols 40"; next } NR == 2 { print "nrows 40"; next } NR < 7 { print } NR > 6 && NR < 47 { print }' \
    "$FOLDER/all.asc" | cut -d' ' -f1-40 >"$FOLDER/small.asc"
sed -i 's/^xllcorner.*/xllcorner 10/; s/^yllcorner.*/yllcorner 50/; s/^cellsize.*/cellsize 0.001/' "$FOLDER/small.asc"
echo 'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]' \
    >"$FOLDER/small.prj"
model degrees "$FOLDER/small.asc" --holes grow
run "$STIPPLE" verify "$FOLDER/degrees.stipple"
expect_code 0
run "$STIPPLE" info "$FOLDER/degrees.stipple"
expect_text out "holes          only grow"

# An image of a depth camera.
awk 'BEGIN { printf "P2\n96 64\n65535\n"
    for (j = 0; j < 64; j++)
        for (i = 0; i < 96; i++)
            print (i - 50)^2 + (j - 30)^2 < 90 ? 0 : 1000 + i + 2 * j }' >"$FOLDER/depth.pgm"
model image "$FOLDER/depth.pgm" --pinhole 90,90,47.5,31.5 --holes grow
run "$STIPPLE" info "$FOLDER/image.stipple"
expect_text out "holes          only grow"
run "$STIPPLE" prep "$FOLDER/depth.pgm" --pinhole 90,90,47.5,31.5 --maps --holes grow -o "$FOLDER/no.stipple"
expect_code 1
expect_text err "--holes grow: the input does not stay one grid of heights, nor images"
[ -e "$FOLDER/no.stipple" ] && fail "a file was left"
end_test
