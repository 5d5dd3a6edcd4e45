#!/usr/bin/env bash
# Tests scans of every kind through prep, info, verify and export. Hostile scans and outputs must
# give one sentence and leave nothing behind.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

ply() { # number of vertices; then their lines on stdin
    printf 'ply\nformat ascii 1.0\nelement vertex %s\n' "$1"
    printf 'property float x\nproperty float y\nproperty float z\nend_header\n'
    cat
}

# Prints a bowl of 20 by 20 vertices as OBJ, OFF or STL; $1 says which.
bowl() {
    awk -v kind="$1" '
        function height(i, j) { return ((i - 9.5) ^ 2 + (j - 9.5) ^ 2) / 40 }
        function vertex(n) { return int(n / 20) " " n % 20 " " height(int(n / 20), n % 20) }
        function face(a, b, c) {
            if (kind == "obj")
                print "f", a + 1, b + 1, c + 1
            else if (kind == "off")
                print 3, a, b, c
            else
                printf "facet normal 0 0 0\nouter loop\nvertex %s\nvertex %s\nvertex %s\n" \
                    "endloop\nendfacet\n", vertex(a), vertex(b), vertex(c)
        }
        BEGIN {
            if (kind == "off")
                print "OFF\n400 722 0"
            if (kind == "stl")
                print "solid bowl"
            for (n = 0; n < 400 && kind != "stl"; n++)
                print (kind == "obj" ? "v " : "") vertex(n)
            for (i = 0; i < 19; i++)
                for (j = 0; j < 19; j++) {
                    face(20 * i + j, 20 * i + j + 20, 20 * i + j + 21)
                    face(20 * i + j, 20 * i + j + 21, 20 * i + j + 1)
                }
            if (kind == "stl")
                print "endsolid bowl"
        }' </dev/null
}

# prepared INPUT POINTS ORIENTATION options...: prep must store this many points with this
# orientation.
prepared() {
    local input=$1 points=$2 orientation=$3
    shift 3
    run "$STIPPLE" prep "$input" -o "$FOLDER/m.stipple" --quiet --force "$@"
    expect_code 0
    expect_empty out
    expect_empty err
    run "$STIPPLE" info "$FOLDER/m.stipple" --json
    expect_code 0
    tr -d '\t ' <"$FOLDER/out" | found -x "\"points\":$points," || fail "$input $*: not $points points"
    tr -d '\t ' <"$FOLDER/out" | found -x "\"orientation\":\"$orientation\"," ||
        fail "$input $*: orientation is not $orientation"
    run "$STIPPLE" verify "$FOLDER/m.stipple" --quiet
    expect_code 0
    run "$STIPPLE" export "$FOLDER/m.stipple" -o "$FOLDER/m.ply" --quiet --force
    expect_code 0
    head -c 1000 "$FOLDER/m.ply" | found -ax "element vertex $points" || fail "$input $*: export"
    rm -f "$FOLDER/m.stipple" "$FOLDER/m.ply"
}

# refused INPUT TEXT options...: prep must say one sentence with the text and write no output.
refused() {
    local input=$1 text=$2
    shift 2
    run "$STIPPLE" prep "$input" -o "$FOLDER/m.stipple" --quiet "$@"
    expect_failure "$text"
    expect_no_litter
}

expect_no_litter() {
    ls -A "$FOLDER" | grep -E 'm\.stipple|\.part$' && fail "$command left files"
}

for kind in obj off stl; do
    bowl $kind >"$FOLDER/bowl.$kind"
    prepared "$FOLDER/bowl.$kind" 400 file --sample none
    prepared "$FOLDER/bowl.$kind" 1234 file --sample 1234
done
# The bowl's vertices alone: as XYZ, with a header, as PTS, and with given columns.
bowl obj | sed -n 's/^v //p' >"$FOLDER/bowl.xyz"
prepared "$FOLDER/bowl.xyz" 400 unknown
{ echo 'Easting;Northing;Elevation' && tr ' .' ';,' <"$FOLDER/bowl.xyz"; } >"$FOLDER/bowl.csv"
prepared "$FOLDER/bowl.csv" 400 unknown
{ echo 400 && cat "$FOLDER/bowl.xyz"; } >"$FOLDER/bowl.pts"
prepared "$FOLDER/bowl.pts" 400 unknown
prepared "$FOLDER/bowl.xyz" 400 position --orient 9.5,9.5,100
awk '{ print NR, $3, $2, $1, "bowl" }' "$FOLDER/bowl.xyz" >"$FOLDER/turned.txt"
prepared "$FOLDER/turned.txt" 400 unknown --columns _,z,y,x
refused "$FOLDER/bowl.xyz" "no known column" --columns x,y,tint
refused "$FOLDER/bowl.obj" "this format names its own columns" --columns x,y,z
sed '200s/ .*//' "$FOLDER/bowl.xyz" >"$FOLDER/wrong.xyz"
refused "$FOLDER/wrong.xyz" "line 200 has 1 columns"
# Without the faces, nothing says which side of an open surface is outside.
prepared "$FOLDER/bowl.obj" 400 unknown --recompute-normals --sample none
prepared "$FOLDER/bowl.off" 1000 unknown --recompute-normals --sample 1000
mkdir "$FOLDER/été à côté"
cp "$FOLDER/bowl.off" "$FOLDER/été à côté/nuage de points.off"
prepared "$FOLDER/été à côté/nuage de points.off" 400 file --sample none

# A ball has no height, but in surveyors' files z is up.
for format in las ply; do
    run "$STIPPLE" gen sphere -n 1000 -o "$FOLDER/up.$format" --quiet
    expect_code 0
    run "$STIPPLE" prep "$FOLDER/up.$format" -o "$FOLDER/up-$format.stipple" --quiet
    expect_code 0
    run "$STIPPLE" info "$FOLDER/up-$format.stipple" --json
    expect_code 0
    expect_text out '"lambda"'
    count=0
    [ $format = ply ] || count=1
    [ "$(grep -c '"up":.*\[0, 0, 1\]' "$FOLDER/out")" = $count ] || fail "up of $format: $(grep '"up"' "$FOLDER/out")"
done

# Points that a LAS file withholds are rejects, listed by their index.
run "$STIPPLE" gen sphere -n 1000 -o "$FOLDER/held.las" --quiet
expect_code 0
for place in 0 7 999; do # records of 36 bytes after a header of 375; flags at 15
    printf '\004' | dd of="$FOLDER/held.las" bs=1 seek=$((375 + 36 * place + 15)) conv=notrunc 2>/dev/null
done
prepared "$FOLDER/held.las" 997 unknown --rejects "$FOLDER/held.csv"
printf 'file,index,reason\n"held.las",0,invalid\n"held.las",7,invalid\n"held.las",999,invalid\n' |
    cmp -s - <(sed "s|$FOLDER/||" "$FOLDER/held.csv") || fail "withheld points are not the rejects: $(head -5 "$FOLDER/held.csv")"
# Kept on request, they are points with an attribute, and a LAS file that is written withholds them again.
prepared "$FOLDER/held.las" 1000 unknown --withheld keep
run "$STIPPLE" prep "$FOLDER/held.las" -o "$FOLDER/kept.stipple" --withheld keep --attributes all --quiet
expect_code 0
run "$STIPPLE" export "$FOLDER/kept.stipple" -o "$FOLDER/kept.ply" --where 'withheld==1' --quiet
expect_code 0
[ "$(sed -n 's/^element vertex //p;/^end_header/q' "$FOLDER/kept.ply")" = 3 ] || fail "other points are withheld"
run "$STIPPLE" export "$FOLDER/kept.stipple" -o "$FOLDER/kept.las" --quiet
expect_code 0
prepared "$FOLDER/kept.las" 997 unknown
head -c 20000 "$FOLDER/held.las" >"$FOLDER/held-cut.las"
refused "$FOLDER/held-cut.las" "declares 1000 points, but the 19625 bytes from byte 375 on hold 545"

# A sparse survey far from the origin: no float holds its centimetres, yet they must come back to
# half a centimetre.
awk 'BEGIN { for (i = 0; i < 400; i++)
    printf "%.2f %.2f %.2f\n", 600000 + 40 * (i % 20) + 0.37, 8e5 + 40 * int(i / 20) + 0.01, i / 80 }' |
    ply 400 >"$FOLDER/far.ply"
run "$STIPPLE" prep "$FOLDER/far.ply" -o "$FOLDER/m.stipple" --quiet --force
expect_code 0
run "$STIPPLE" export "$FOLDER/m.stipple" -o "$FOLDER/m.ply" --quiet --force
expect_code 0
LC_ALL=C sed -n '/^property/p; /^end_header/q' "$FOLDER/m.ply" | found -ax 'property double y' ||
    fail "coordinates of six digits and two were written as floats"
header=$(LC_ALL=C sed '/^end_header/q' "$FOLDER/m.ply" | wc -c)
# A point has 36 bytes, so only every other point is aligned for doubles: reads from two starts.
back=$({
    od -An -v -w72 -tf8 -j "$header" "$FOLDER/m.ply"
    od -An -v -w72 -tf8 -j $((header + 36)) "$FOLDER/m.ply"
} | awk '
    function far(value, from) { value -= from; value -= 40 * int(value / 40 + 0.5)
        return value > 0.00501 || value < -0.00501 }
    !far($1, 600000.37) && !far($2, 800000.01)' | wc -l)
[ "$back" = 400 ] || fail "$back of 400 points came back where they were"
rm -f "$FOLDER/m.stipple" "$FOLDER/m.ply"

# The largest accepted coordinates, and larger ones.
far_points() { # exponent
    awk -v e="$1" 'BEGIN { for (i = 1; i <= 40; i++)
        printf "%d.25e%d %d.5e%d %d.125e%d\n", i * 7 % 11, e, i * 5 % 13, e, i * 3 % 17, e }' |
        ply 40 >"$FOLDER/huge.ply"
    run "$STIPPLE" prep "$FOLDER/huge.ply" -o "$FOLDER/m.stipple" --force
}
far_points 13
expect_code 0
expect_text err "40 points read, 40 stored, 0 rejected"
run "$STIPPLE" verify "$FOLDER/m.stipple" --quiet
expect_code 0
rm -f "$FOLDER/m.stipple"
far_points 20
expect_failure "they may reach 1e+15"

: >"$FOLDER/empty.ply"
refused "$FOLDER/empty.ply" "0 bytes"
ply 0 </dev/null >"$FOLDER/none.ply"
refused "$FOLDER/none.ply" "none.ply"
ply 2 >"$FOLDER/nan.ply" <<<$'nan 0 0\n0 inf 0'
refused "$FOLDER/nan.ply" "no valid point among 2: their coordinates are no numbers"
ply 3 >"$FOLDER/cut.ply" <<<'0 0 0'
refused "$FOLDER/cut.ply" "declares 3 vertices"
ply 3 >"$FOLDER/three.ply" <<<$'0 0 0\n1 0 0\n0 1 0'
refused "$FOLDER/three.ply" "no faces" --sample 10
refused "$FOLDER/three.ply" "all lie outside: give other --bounds" --bounds 7,7,8,8
refused "$FOLDER/three.ply" "none is as --where says" --where 'x==7'
echo hello >"$FOLDER/hello.dat"
refused "$FOLDER/hello.dat" "PLY, LAS, LAZ, COPC, EPT, PCD, E57, OBJ, OFF, STL, glTF, XYZ"
refused "$FOLDER/missing.ply" "missing.ply: cannot be opened"
mkdir "$FOLDER/without scans"
refused "$FOLDER/without scans" "has the name of a scan"
cp "$FOLDER/three.ply" "$FOLDER/kept.ply"
run "$STIPPLE" prep "$FOLDER/three.ply" -o "$FOLDER/./three.ply" --force --quiet
expect_failure "also an input"
cmp -s "$FOLDER/three.ply" "$FOLDER/kept.ply" || fail "prep wrote over its input"
run "$STIPPLE" prep "$FOLDER/three.ply" -o "$FOLDER/no folder/m.stipple" --quiet
expect_failure "cannot be created"
run "$STIPPLE" prep "$FOLDER/three.ply" -o "$FOLDER/hello.dat" --quiet
expect_failure "exists already"
[ "$(cat "$FOLDER/hello.dat")" = hello ] || fail "prep replaced a file without --force"
expect_no_litter
# An image that is a depth camera's without --pinhole is said to be one; with --spacing it is heights.
awk 'BEGIN {
    print "P2 320 240 65535"
    for (r = 0; r < 240; r++)
        for (c = 0; c < 320; c++)
            print (r < 20 || (c < 100 && c >= 90)) ? 0 : int(1400 / ((r - 119.5) / 262.5 + 0.6))
}' >"$FOLDER/d.pgm"
run "$STIPPLE" prep "$FOLDER/d.pgm" -o "$FOLDER/d.stipple"
expect_code 0
expect_text err "d.pgm: taken as a depth camera's image (--pinhole 262.5,262.5,159.5,119.5 --height-scale 0.001): give"
run "$STIPPLE" prep "$FOLDER/d.pgm" -o "$FOLDER/d.stipple" --spacing 1 --force
expect_code 0
found "depth camera's image (" <"$FOLDER/err" && fail "--spacing leaves it a camera's"
# Images of one size are one series: a frame of a bare wall, which alone is heights, is a camera's, too.
awk 'BEGIN {
    print "P2 320 240 65535"
    for (r = 0; r < 240; r++)
        for (c = 0; c < 320; c++)
            print (c >= 90 && c < 100) ? 0 : 2000
}' >"$FOLDER/wall.pgm"
run "$STIPPLE" prep "$FOLDER/wall.pgm" -o "$FOLDER/d.stipple" --force
expect_code 0
found "depth camera's image (" <"$FOLDER/err" && fail "a bare wall is taken as a camera's"
run "$STIPPLE" prep "$FOLDER/wall.pgm" "$FOLDER/d.pgm" -o "$FOLDER/d.stipple" --force
expect_code 0
expect_text err "wall.pgm: taken as a depth camera's image (--pinhole 262.5,262.5,159.5,119.5 --height-scale 0.001): give"
expect_text err "d.pgm: taken as"
# Floats have a unit of their own.
{
    printf 'Pf\n320 240\n-1.0\n'
    awk 'BEGIN { for (i = 0; i < 76800; i++) printf "@@@@" }'
} >"$FOLDER/wall.pfm"
run "$STIPPLE" prep "$FOLDER/d.pgm" "$FOLDER/wall.pfm" -o "$FOLDER/d.stipple" --force
expect_code 0
expect_text err "d.pgm: taken as"
found "wall.pfm: taken as" <"$FOLDER/err" && fail "floats are of the series of whole numbers"
# COLMAP's y points down, and its pictures stand upright.
{
    echo '#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)'
    awk 'BEGIN { for (i = 0; i < 900; i++) print i, i % 30, sin(i), int(i / 30), 9, 99, 9, 1, i, i }'
} >"$FOLDER/points3D.txt"
run "$STIPPLE" prep "$FOLDER/points3D.txt" -o "$FOLDER/colmap.stipple" --quiet
expect_code 0
found -a '"up":\[0, -1, 0\]' <"$FOLDER/colmap.stipple" || fail "the model of COLMAP does not say what is up"
# If a command needs a chunk file but gets a scan, it must name the command that makes one.
"$STIPPLE" gen sphere -n 500 -o "$FOLDER/ball.ply" --quiet --force
printf '1 2 3\n4 5 6\n7 8 9\n' >"$FOLDER/a few.xyz"
for command in "info" "verify" "export -o $FOLDER/none.ply" "convert -o $FOLDER/none.stipple"; do
    # shellcheck disable=SC2086
    run "$STIPPLE" ${command%% *} "$FOLDER/ball.ply" $([[ $command == *" "* ]] && echo "${command#* }")
    expect_failure "ball.ply is a scan (PLY), not a chunk file: make one with \`stipple prep $FOLDER/ball.ply"
    [ ! -e "$FOLDER/none" ] || fail "$command made something of a scan"
done
run "$STIPPLE" info "$FOLDER/a few.xyz"
expect_failure "is a scan (XYZ), not a chunk file"
printf 'no scan either' >"$FOLDER/none.bin"
run "$STIPPLE" info "$FOLDER/none.bin"
expect_failure "not a stipple chunk file"
end_test
