#!/usr/bin/env bash
# Tests `prep --hybrid` of a mesh with large and small faces.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# A floor of two large triangles around a fine dome.
awk 'BEGIN {
    n = 60
    print "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3\nf 1 3 4"
    for (y = 0; y <= n; y++) for (x = 0; x <= n; x++) {
        u = x / n * 4 - 2; v = y / n * 4 - 2; print "v", u, v, 3 * exp(-u * u - v * v) }
    for (y = 0; y < n; y++) for (x = 0; x < n; x++) {
        a = 5 + y * (n + 1) + x; b = a + n + 1
        print "f", a, a + 1, b; print "f", a + 1, b + 1, b } }' >"$FOLDER/dome.obj"

run "$STIPPLE" prep "$FOLDER/dome.obj" -o "$FOLDER/d.stipple" --hybrid --stats "$FOLDER/stats.json"
expect_code 0
expect_text err "3721 points read, 3721 stored"
expect_text err "2 triangles are stored"
grep -q '"triangles":[[:space:]]*2,$' "$FOLDER/stats.json" || fail "stats: triangles"
run "$STIPPLE" verify "$FOLDER/d.stipple"
expect_code 0
run "$STIPPLE" info "$FOLDER/d.stipple"
expect_text out "triangles      2; 6 of the points are their corners"
expect_text out "version        2.0"
run "$STIPPLE" export "$FOLDER/d.stipple" -o "$FOLDER/d.ply" --quiet
expect_code 0
grep -aqx "element vertex 3727" "$FOLDER/d.ply" || fail "export: vertices"
grep -aqx "element face 2" "$FOLDER/d.ply" || fail "export: faces"

# Tests sampling, a mesh of large faces only, and that any number of threads gives the same bytes.
run "$STIPPLE" prep "$FOLDER/dome.obj" -o "$FOLDER/s.stipple" --hybrid --sample 20000
expect_code 0
expect_text err "2 triangles are stored"
run "$STIPPLE" verify "$FOLDER/s.stipple"
expect_code 0
for threads in 1 3; do
    run "$STIPPLE" prep "$FOLDER/dome.obj" -o "$FOLDER/a$threads.stipple" --hybrid --threads $threads \
        --sample 100000000 --quiet
    expect_code 0
done
cmp "$FOLDER/a1.stipple" "$FOLDER/a3.stipple" || fail "threads change the file"
run "$STIPPLE" info "$FOLDER/a1.stipple"
expect_text out "triangles      7202;"
run "$STIPPLE" verify "$FOLDER/a1.stipple"
expect_code 0

# A damaged file is repaired, and the result must be sound.
cp "$FOLDER/a1.stipple" "$FOLDER/hurt.stipple"
printf 'damage' | dd of="$FOLDER/hurt.stipple" bs=1 seek=100000 conv=notrunc status=none
run "$STIPPLE" verify "$FOLDER/hurt.stipple" --repair -o "$FOLDER/mended.stipple"
run "$STIPPLE" verify "$FOLDER/mended.stipple"
expect_code 0

# A mesh of large faces is sampled without being asked, and told apart from a scan's.
printf 'v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 2 2 3\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n' >"$FOLDER/roof.obj"
run "$STIPPLE" prep "$FOLDER/roof.obj" -o "$FOLDER/r.stipple"
expect_code 0
expect_text err "4 triangles are stored"
expect_text err "has large faces: they stay triangles"
run "$STIPPLE" verify "$FOLDER/r.stipple"
expect_code 0
run "$STIPPLE" prep "$FOLDER/roof.obj" -o "$FOLDER/v.stipple" --sample none
expect_code 0
expect_text err "5 points read, 5 stored"
for wrong in 0 -1 many; do
    run "$STIPPLE" prep "$FOLDER/roof.obj" -o "$FOLDER/w.stipple" --sample $wrong
    expect_failure "give the number of points, or none"
done

run "$STIPPLE" gen sphere -n 100 -o "$FOLDER/points.ply" --quiet
run "$STIPPLE" prep "$FOLDER/points.ply" -o "$FOLDER/p.stipple" --hybrid
expect_failure "has no faces to make a hybrid surface of"
end_test
