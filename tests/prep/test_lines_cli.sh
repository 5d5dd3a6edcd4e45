#!/usr/bin/env bash
# Tests lines on the command line: read from PLY and OBJ, exported as PLY, and reported by prep,
# info and verify.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# helix N [PROPERTY]: N vertices and N - 1 edges, with a lone point and four wrong edges; red edges.
helix() {
    printf 'ply\nformat ascii 1.0\nelement vertex %d\n' $(($1 + 1))
    printf 'property float x\nproperty float y\nproperty float z\n%s' "${2:-}"
    printf 'element edge %d\nproperty int vertex1\nproperty int vertex2\n' $(($1 + 3))
    printf 'property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n'
    awk -v n="$1" -v wide="${2:+ 0.05}" 'BEGIN {
        for (i = 0; i < n; i++) print cos(i / 10), sin(i / 10), i / 100 wide
        print 3, 3, 3 wide
        for (i = 0; i + 1 < n; i++) print i, i + 1, 255, 0, 0
        print 5, 5, 1, 1, 1; print 1, 0, 9, 9, 9; print 7, 99999, 1, 1, 1; print -1, 0, 0, 0, 0 }'
}

helix 3000 $'property float radius\n' >"$FOLDER/helix.ply"
run "$STIPPLE" prep "$FOLDER/helix.ply" -o "$FOLDER/h.stipple" --stats "$FOLDER/stats.json"
expect_code 0
expect_text err "1 points read, 1 stored, 0 rejected"
expect_text err "lines: 1 of 3000 vertices and 2999 segments are stored"
expect_text err "4 of 3003 edges are left out: 2 name a vertex that does not exist, 1 join a vertex with itself, 1 are there already"
for pair in strips:1 vertices:3000 segments:2999 edges_in:3003 no_vertex:2 no_length:1 repeated:1; do
    grep -q "\"${pair%:*}\":[[:space:]]*${pair#*:},\$" "$FOLDER/stats.json" || fail "stats: $pair"
done

run "$STIPPLE" verify "$FOLDER/h.stipple"
expect_code 0
run "$STIPPLE" info "$FOLDER/h.stipple"
expect_code 0
expect_text out "1 strips, 3000 vertices, 2999 segments"
expect_text out "version        2.0"
expect_text out "colour lines"
run "$STIPPLE" info "$FOLDER/h.stipple" --json
expect_text out '"lines"'

# Export and prep again must give the same lines, whichever chunks held their parts.
run "$STIPPLE" export "$FOLDER/h.stipple" -o "$FOLDER/out.ply" --quiet
expect_code 0
for line in "element vertex 3001" "element edge 2999" "property float radius"; do
    grep -aqx "$line" "$FOLDER/out.ply" || fail "export: no $line"
done
run "$STIPPLE" prep "$FOLDER/out.ply" -o "$FOLDER/again.stipple"
expect_code 0
expect_text err "lines: 1 of 3000 vertices and 2999 segments are stored"
grep -q "left out" "$FOLDER/err" && fail "prep leaves out edges of an exported file"

# The number of threads must not matter.
for threads in 1 3; do
    run "$STIPPLE" prep "$FOLDER/helix.ply" -o "$FOLDER/t$threads.stipple" --quiet --threads $threads
    expect_code 0
done
cmp "$FOLDER/t1.stipple" "$FOLDER/t3.stipple" || fail "threads change the file"

# OBJ, with --line-radius because the file states no width.
awk 'BEGIN { for (i = 0; i < 500; i++) print "v", cos(i / 10), sin(i / 10), i / 100
    printf "l"; for (i = 1; i <= 500; i++) printf " %d", i; print "" }' >"$FOLDER/line.obj"
run "$STIPPLE" prep "$FOLDER/line.obj" -o "$FOLDER/l.stipple" --line-radius 0.25
expect_code 0
expect_text err "lines: 1 of 500 vertices and 499 segments are stored"
run "$STIPPLE" verify "$FOLDER/l.stipple"
expect_code 0
expect_text out "sound"
run "$STIPPLE" export "$FOLDER/l.stipple" -o "$FOLDER/l.ply" --quiet
expect_code 0
run "$STIPPLE" prep "$FOLDER/line.obj" -o "$FOLDER/l.stipple" --line-radius -1
expect_code 2
expect_text err "--line-radius: give a positive length"

# Lines beside other inputs. Lines that need too much memory must be refused before anything is
# written.
run "$STIPPLE" gen sphere -n 5000 -o "$FOLDER/s.ply" --quiet
run "$STIPPLE" prep "$FOLDER/s.ply" "$FOLDER/line.obj" "$FOLDER/helix.ply" -o "$FOLDER/all.stipple"
expect_code 0
expect_text err "5001 points read, 5001 stored"
expect_text err "lines: 2 of 3500 vertices and 3498 segments are stored"
run "$STIPPLE" verify "$FOLDER/all.stipple"
expect_code 0

# Repair: a leaf of lines is lost, and the rest is sound.
cp "$FOLDER/h.stipple" "$FOLDER/hurt.stipple"
printf 'damage' | dd of="$FOLDER/hurt.stipple" bs=1 seek=3000 conv=notrunc status=none
run "$STIPPLE" verify "$FOLDER/hurt.stipple"
expect_code 1
run "$STIPPLE" verify "$FOLDER/hurt.stipple" --repair -o "$FOLDER/mended.stipple"
run "$STIPPLE" verify "$FOLDER/mended.stipple"
expect_code 0
run "$STIPPLE" export "$FOLDER/mended.stipple" -o "$FOLDER/mended.ply" --quiet
end_test
