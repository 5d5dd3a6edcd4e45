#!/usr/bin/env bash
# stipple gen writes as many points as asked for, the same bytes for the same seed and any number of
# threads, and says in one sentence what is wrong with a request.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/support/shell.sh"

header_count() { # file
    sed -n '/^end_header/q; s/^element vertex //p' "$1" | tr -d '\r'
}

header_bytes() { # file
    LC_ALL=C sed '/^end_header/q' "$1" | wc -c
}

for shape in bumpy terrain sphere plane torus sheet; do
    stride=15 # three floats, three bytes; the sheet has a class too
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

# A lone station sees one side of the sheet; by its place, which the file tells, normals are turned.
run "$STIPPLE" gen sheet -n 5000 --stations 1 -o "$FOLDER/s.ply" --force --quiet
expect_code 0
place=$(sed -n '/^end_header/q; s/^comment station 0 \([^,]*\).*/\1/p' "$FOLDER/s.ply" | tr ' ' ,)
[[ $place == *,*,* ]] || fail "the station's place is not told: '$place'"
run "$STIPPLE" prep "$FOLDER/s.ply" -o "$FOLDER/s.stipple" --orient "$place" --force --quiet
expect_code 0
run "$STIPPLE" info "$FOLDER/s.stipple" --json
tr -d '\t ' <"$FOLDER/out" | grep -qx '"orientation":"position",' || fail "not turned to the station"

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

# The camera's file: its size counts unless --size is given; what is no camera is refused.
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
