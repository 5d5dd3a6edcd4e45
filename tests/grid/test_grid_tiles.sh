#!/usr/bin/env bash
# Tests grids of heights in several files: tiles that overlap by a row, in any order, make the very model that
# the whole grid makes, also in degrees; a hole of one file is filled by another; a file that breaks off is left out;
# tiles that do not fit become points.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

columns=150 rows=130

# Writes a part of the grid: first column and row, columns, rows. hole: samples up to this column are missing.
tile() { # name column row columns rows [cell [hole]]
    awk -v c0="$2" -v r0="$3" -v c="$4" -v r="$5" -v cell="${6:-10}" -v hole="${7:--1}" -v all="$rows" 'BEGIN {
        printf "ncols %d\nnrows %d\n", c, r
        printf "xllcorner %.7f\nyllcorner %.7f\n", (cell < 1 ? 15 : 500000) + c0 * cell, (cell < 1 ? 45 : 5000000) + (all - r0 - r) * cell
        printf "cellsize %.7f\nNODATA_value -9999\n", cell
        for (j = r0; j < r0 + r; j++) {
            for (i = c0; i < c0 + c; i++)
                printf "%s ", i <= hole || (i - 70)^2 + (j - 60)^2 < 40 ? -9999 : sprintf("%.2f", 80 * sin(i / 20) * cos(j / 15))
            print ""
        }
    }' >"$FOLDER/$1.asc"
}

model() { # name, inputs...
    local name=$1 file inputs=()
    shift
    for file in "$@"; do inputs+=("$FOLDER/$file.asc"); done
    run "$STIPPLE" prep "${inputs[@]}" -o "$FOLDER/$name.stipple" --force --stats "$FOLDER/stats.json"
}

exported() { # name
    "$STIPPLE" verify "$FOLDER/$1.stipple" --quiet 2>"$FOLDER/err" || fail "$1 is not sound"
    "$STIPPLE" export "$FOLDER/$1.stipple" -o "$FOLDER/$1.ply" --force --quiet || fail "export $1"
}

same() { # name name
    exported "$1"
    exported "$2"
    cmp -s "$FOLDER/$1.ply" "$FOLDER/$2.ply" || fail "$1 and $2 differ"
}

system='GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]'
for cell in 0.0003 10; do
    tile whole 0 0 $columns $rows $cell
    tile a 0 0 81 71 $cell
    tile b 80 0 70 71 $cell
    tile c 0 70 81 60 $cell
    tile d 80 70 70 60 $cell
    for name in whole a b c d; do
        rm -f "$FOLDER/$name.prj"
        [ "$cell" = 10 ] || echo "$system" >"$FOLDER/$name.prj"
    done
    model whole whole
    expect_code 0
    model tiles d b a c
    expect_code 0
    expect_text err "281 at a place of another file" # a column of 130 and a row of 150, and one more
    same whole tiles
done

# Missing samples of one file come from another.
tile holed 0 0 $columns $rows 10 60
model filled holed a c
expect_code 0
same whole filled

# What was read of a file that breaks off is gone.
model three a b c
expect_code 0
head -c "$(($(wc -c <"$FOLDER/d.asc") / 2))" "$FOLDER/d.asc" >"$FOLDER/cut.asc"
model cut a cut c b
expect_code 1
same three cut
model cut cut a b c
expect_code 1
same three cut

# Columns that do not go on, and cells of another size.
tile odd 80.5 70 70 60
model points a b c odd
expect_code 0
[ "$(field twice)" = 0 ] || fail "$command: tiles that do not fit became one grid"
tile odd 40 35 35 30 20
model points a b c odd
expect_code 0
[ "$(field twice)" = 0 ] || fail "$command: cells of two sizes became one grid"
end_test
