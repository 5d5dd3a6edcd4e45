#!/usr/bin/env bash
# Tests that stipple gen writes the requested number of points, and the same bytes for the same seed
# and any number of threads. A sentence must say what is wrong with a request.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

header_count() { # file
    sed -n '/^end_header/q; s/^element vertex \([0-9]*\).*/\1/p' "$1"
}

header_bytes() { # file
    LC_ALL=C sed '/^end_header/q' "$1" | wc -c
}

for shape in bumpy terrain sphere plane torus sheet tree building; do
    stride=15 # three floats, three bytes; the sheet also has a class
    [ $shape = sheet ] && stride=16
    for count in 1 2 1000; do
        run "$STIPPLE" gen $shape -n $count -o "$FOLDER/p.ply" --force --quiet
        expect_code 0
        [ "$(header_count "$FOLDER/p.ply")" = $count ] || fail "$shape: header of $count"
        size=$(stat -c %s "$FOLDER/p.ply")
        [ $((size - $(header_bytes "$FOLDER/p.ply"))) = $((count * stride)) ] ||
            fail "$shape: $count points make $size bytes"
    done
done

# The file must say where the stations are and which one saw a point, and prep must turn normals to
# them.
header_line() { # file, line
    LC_ALL=C sed '/^end_header/q' "$1" | found -x "$2"
}
orientation() { # what info says of s.stipple
    run "$STIPPLE" info "$FOLDER/s.stipple" --json
    tr -d '\t ' <"$FOLDER/out" | sed -n '/"metadata"/q; s/^"orientation":"\(.*\)",$/\1/p'
}
stations() { # how many positions info lists
    run "$STIPPLE" info "$FOLDER/s.stipple" --json
    tr -d '\t\n ' <"$FOLDER/out" | grep -oP '"stations":\[\K.*?(?=\]\])' | grep -o '\[' | wc -l
}
prep() { # input... and options
    run "$STIPPLE" prep "$@" -o "$FOLDER/s.stipple" --force
    expect_code 0
}
# Counts the points of the sheet whose normal points to their own side: class 1 lies above, class 2
# below. After the export's header a point is six floats, three bytes of colour and the class.
right_sides() {
    run "$STIPPLE" export "$FOLDER/s.stipple" -o "$FOLDER/s.out.ply" --force --quiet
    expect_code 0
    local begin
    begin=$(header_bytes "$FOLDER/s.out.ply")
    paste <(od -An -v -w28 -tf4 -j "$begin" "$FOLDER/s.out.ply") \
        <(od -An -v -w28 -tu1 -j "$begin" "$FOLDER/s.out.ply") |
        awk '($35 == 1 && $6 > 0) || ($35 == 2 && $6 < 0)' | wc -l
}

run "$STIPPLE" gen sheet -n 20000 --stations 3 -o "$FOLDER/s.ply" --force --quiet
expect_code 0
header_line "$FOLDER/s.ply" 'comment station 2 [-0-9.e]* [-0-9.e]* [-0-9.e]*' || fail "no third station"
header_line "$FOLDER/s.ply" 'comment station 3 .*' && fail "a fourth station"
header_line "$FOLDER/s.ply" 'property uchar station' || fail "points do not name their stations"
prep "$FOLDER/s.ply"
expect_text err "orientation from 3 scanner positions"
[ "$(orientation)" = position ] || fail "not turned to the stations: $(orientation)"
[ "$(stations)" = 3 ] || fail "info lists $(stations) of 3 stations"
right=$(right_sides)
[ "$right" -ge 19980 ] || fail "$right of 20000 normals point to their side"
prep "$FOLDER/s.ply" --orient 0,0,9 --quiet
[ "$(orientation)/$(stations)" = position/1 ] || fail "--orient x,y,z does not win over stations"
right=$(right_sides)
[ "$right" -lt 15000 ] || fail "a position above turns $right of 20000 normals to their side"
prep "$FOLDER/s.ply" --orient propagate --quiet
[[ $(orientation)/$(stations) != position/* && $(stations) = 0 ]] ||
    fail "--orient propagate does not win over stations"


# Any number of threads must give the same bytes.
run "$STIPPLE" gen sheet -n 80000 --stations 3 --noise 0.1 -o "$FOLDER/a.ply" --threads 1 --force --quiet
run "$STIPPLE" gen sheet -n 80000 --stations 3 --noise 0.1 -o "$FOLDER/b.ply" --threads 3 --force --quiet
expect_code 0
cmp -s "$FOLDER/a.ply" "$FOLDER/b.ply" || fail "other threads, other stations"
prep "$FOLDER/a.ply" --threads 1 --quiet
mv "$FOLDER/s.stipple" "$FOLDER/one.stipple"
prep "$FOLDER/a.ply" --threads 3 --quiet
cmp -s "$FOLDER/one.stipple" "$FOLDER/s.stipple" || fail "other threads, other normals"

# prep must say that positions are lost.
LC_ALL=C sed '/^comment/d' "$FOLDER/s.ply" >"$FOLDER/lost.ply"
prep "$FOLDER/lost.ply"
expect_text err "; 20000 points name no scanner whose position is known"
[[ $(orientation)/$(stations) != position/* && $(stations) = 0 ]] || fail "oriented by lost positions"

# A single station sees one side of the sheet and needs no property.
run "$STIPPLE" gen sheet -n 20000 --stations 1 -o "$FOLDER/one.ply" --force --quiet
expect_code 0
header_line "$FOLDER/one.ply" 'property .* station' && fail "a property of stations, though there is just one station"
place=$(sed -n '/^end_header/q; s/^comment station 0 //p' "$FOLDER/one.ply" | tr ' ' ,)
[[ $place == *,*,* ]] || fail "the station's place is not told: '$place'"
for how in auto "$place"; do
    prep "$FOLDER/one.ply" --orient "$how"
    expect_text err "orientation from the scanner's position"
    [ "$(orientation)/$(stations)" = position/1 ] || fail "--orient $how: not turned to the station"
done

# Several inputs keep their stations apart: the second station of the second input sees what the
# first input's station does not.
for count in 1 2; do
    run "$STIPPLE" gen sphere -n 20000 --no-colour --stations $count --seed $count \
        -o "$FOLDER/ball$count.ply" --force --quiet
    expect_code 0
done
prep "$FOLDER/ball1.ply" "$FOLDER/ball2.ply"
expect_text err "orientation from 3 scanner positions"
run "$STIPPLE" export "$FOLDER/s.stipple" -o "$FOLDER/s.out.ply" --force --quiet
expect_code 0
right=$(od -An -v -w24 -tf4 -j "$(header_bytes "$FOLDER/s.out.ply")" "$FOLDER/s.out.ply" |
    awk '$1 * $4 + $2 * $5 + $3 * $6 > 0' | wc -l)
[ "$right" -ge 39960 ] || fail "$right of 40000 normals of two inputs point outward"

run "$STIPPLE" gen sheet -n 20000 --stations 2 --normals -o "$FOLDER/n.ply" --force --quiet
expect_code 0
prep "$FOLDER/n.ply" --quiet
[ "$(orientation)/$(stations)" = file/0 ] || fail "stations win over the file's normals"

# LAS: header and records must have the standard's lengths, and the points must be PLY's within a
# step.
las_number() { # file, offset, bytes
    od -An -v -tu"$3" -j "$2" -N "$3" "$1" | tr -d ' '
}
las_check() { # file, points, point format, record length
    [ "$(head -c 4 "$1")" = LASF ] || fail "$1 does not begin with LASF"
    [ "$(las_number "$1" 25 1)/$(las_number "$1" 104 1)" = 4/$3 ] || fail "$1 is not 1.4 format $3"
    [ "$(las_number "$1" 247 8)" = "$2" ] || fail "$1 counts $(las_number "$1" 247 8) points"
    [ "$(stat -c %s "$1")" = $((375 + $2 * $4)) ] || fail "$1 has $(stat -c %s "$1") bytes"
}
for count in 1 2 1000; do
    run "$STIPPLE" gen bumpy -n $count -o "$FOLDER/p.las" --force --quiet
    expect_code 0
    las_check "$FOLDER/p.las" $count 7 36
done
run "$STIPPLE" gen sheet -n 20000 --no-colour --stations 3 -o "$FOLDER/p.LAS" --force --quiet
expect_code 0
las_check "$FOLDER/p.LAS" 20000 6 30
sources=$(od -An -v -w30 -tu1 -j 375 "$FOLDER/p.LAS" | awk '{print $21 + 256 * $22}' | sort -un | xargs)
[ "$sources" = "1 2 3" ] || fail "point source IDs are $sources"
classes=$(od -An -v -w30 -tu1 -j 375 "$FOLDER/p.LAS" | awk '{print $17}' | sort -un | xargs)
[ "$classes" = "1 2" ] || fail "classes are $classes"
run "$STIPPLE" gen terrain -n 30000 --noise 0.5 --threads 1 -o "$FOLDER/p.las" --force --quiet
run "$STIPPLE" gen terrain -n 30000 --noise 0.5 --threads 3 -o "$FOLDER/q.las" --force --quiet
expect_code 0
cmp -s "$FOLDER/p.las" "$FOLDER/q.las" || fail "LAS: other threads, other bytes"
run "$STIPPLE" gen terrain -n 30000 --noise 0.5 -o "$FOLDER/p.ply" --force --quiet
run "$STIPPLE" gen terrain -n 30000 --noise 0.5 --no-colour -o "$FOLDER/q.ply" --force --quiet
paste <(od -An -v -w36 -td4 -j 375 "$FOLDER/p.las") <(od -An -v -w36 -tu2 -j 375 "$FOLDER/p.las") |
    awk '{print $1, $2, $3, $25, $26, $27}' >"$FOLDER/las.txt"
paste <(od -An -v -w12 -tf4 -j "$(header_bytes "$FOLDER/q.ply")" "$FOLDER/q.ply") \
    <(od -An -v -w15 -tu1 -j "$(header_bytes "$FOLDER/p.ply")" "$FOLDER/p.ply") |
    awk '{print $1, $2, $3, $16, $17, $18}' >"$FOLDER/ply.txt"
step=$(od -An -tf8 -j 131 -N 8 "$FOLDER/p.las")
rise=$(od -An -tf8 -j 171 -N 8 "$FOLDER/p.las")
wrong=$(paste "$FOLDER/las.txt" "$FOLDER/ply.txt" | awk -v step="$step" -v rise="$rise" '
    function far(a, b) { return a - b > 0.501 * step + 1e-4 || b - a > 0.501 * step + 1e-4 }
    far($1 * step, $7) || far($2 * step, $8) || far($3 * step + rise, $9) ||
    $4 != 257 * $10 || $5 != 257 * $11 || $6 != 257 * $12' | wc -l)
[ "$wrong/$(wc -l <"$FOLDER/las.txt")" = 0/30000 ] || fail "$wrong points of LAS are not PLY's"
prep "$FOLDER/p.las" --quiet
run "$STIPPLE" verify "$FOLDER/s.stipple" --quiet
expect_code 0
run "$STIPPLE" gen terrain -n 30000 --noise 0.5 -o "$FOLDER/p.laz" --force --quiet
expect_code 0
[ "$(stat -c %s "$FOLDER/p.laz")" -lt $(($(stat -c %s "$FOLDER/p.las") / 2)) ] || fail "LAZ is not half of LAS"
for ending in las laz; do
    prep "$FOLDER/p.$ending" --quiet
    run "$STIPPLE" export "$FOLDER/s.stipple" -o "$FOLDER/$ending.ply" --force --quiet
    expect_code 0
done
cmp "$FOLDER/las.ply" "$FOLDER/laz.ply" || fail "LAZ has other points than LAS"
run "$STIPPLE" gen sphere -n 10 --normals -o "$FOLDER/none.las"
expect_usage "LAS has no normals"
[ -e "$FOLDER/none.las" ] && fail "a refused request left a LAS file"

options="bumpy -n 100000 --order random --noise 0.2 --normals --quiet --force"
# shellcheck disable=SC2086
{
    run "$STIPPLE" gen $options --seed 4 --threads 1 -o "$FOLDER/a.ply"
    expect_code 0
    run "$STIPPLE" gen $options --seed 4 --threads 3 -o "$FOLDER/b.ply"
    expect_code 0
    run "$STIPPLE" gen $options --seed 5 -o "$FOLDER/c.ply"
    expect_code 0
}
cmp -s "$FOLDER/a.ply" "$FOLDER/b.ply" || fail "same seed, other threads: other bytes"
cmp -s "$FOLDER/a.ply" "$FOLDER/c.ply" && fail "another seed: the same bytes"

# The camera's file: its size is used unless --size is given. An invalid camera is refused.
picture_size() { # file.png
    od -An -t u1 -j 16 -N 8 "$1" | awk '{print ($3 * 256 + $4) "x" ($7 * 256 + $8)}'
}
truth=(gen bumpy --truth "$FOLDER/t.png" --quiet --force --camera "$FOLDER/c.json")
echo '{"eye": [3, 0, 0], "look": [0, 0, 0], "up": [0, 1, 0], "height": 3, "size": [48, 20]}' \
    >"$FOLDER/c.json"
run "$STIPPLE" "${truth[@]}"
expect_code 0
[ "$(picture_size "$FOLDER/t.png")" = 48x20 ] || fail "the camera's size is not the picture's"
run "$STIPPLE" "${truth[@]}" --size 24x30
expect_code 0
[ "$(picture_size "$FOLDER/t.png")" = 24x30 ] || fail "--size is not the picture's"
run "$STIPPLE" "${truth[@]}" --up 1,0,0
expect_failure "--up"
for text in '' '[]' '{"eye": [0, 0]}' '{"up": "y"}' '{"fovy_deg": "40"}' '{"size": [1e9, 1]}'; do
    echo "$text" >"$FOLDER/c.json"
    run "$STIPPLE" "${truth[@]}"
    expect_failure "c.json"
done

# The tree's mesh must have about as many vertices as requested, and be the same each time.
for file in a b; do
    run "$STIPPLE" gen tree -n 30000 --seed 4 --mesh "$FOLDER/$file.ply" --threads 2 --force --quiet
    expect_code 0
done
cmp -s "$FOLDER/a.ply" "$FOLDER/b.ply" || fail "the tree of one seed has two meshes"
count=$(header_count "$FOLDER/a.ply")
[ "$count" -gt 28500 ] && [ "$count" -le 30000 ] || fail "a tree of 30000 vertices has $count"
run "$STIPPLE" gen tree -n 1000 --mesh-triangles 10 --mesh "$FOLDER/none.ply"
expect_usage "give -n N for about N vertices"

run "$STIPPLE" gen sphere -n 0 -o "$FOLDER/none.ply"
expect_usage "give -n N, 1 or more"
run "$STIPPLE" gen sphere -n 10
expect_usage "no output"
run "$STIPPLE" gen cube -n 10 -o "$FOLDER/none.ply"
expect_usage "no shape is called cube"
run "$STIPPLE" gen torus --truth "$FOLDER/none.png"
expect_usage "--truth needs the shape bumpy"
run "$STIPPLE" gen sphere -n 10 --stations 65 -o "$FOLDER/none.ply"
expect_usage "at most 64"
[ -e "$FOLDER/none.ply" ] && fail "a refused request left a file"

end_test
