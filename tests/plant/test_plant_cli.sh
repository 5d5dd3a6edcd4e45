#!/usr/bin/env bash
# Tests prep --lines auto: it turns a plant's mesh into ribbons, tubes and triangles and accounts
# for every triangle.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

figure() { grep -o "\"$1\":[[:space:]]*[0-9]*" "$FOLDER/stats.json" | head -1 | grep -o '[0-9]*$'; }

run "$STIPPLE" gen tree -n 20000 -o "$FOLDER/tree.ply" --mesh "$FOLDER/mesh.ply" --quiet
expect_code 0
run "$STIPPLE" prep "$FOLDER/mesh.ply" -o "$FOLDER/t.stipple" --lines auto --stats "$FOLDER/stats.json"
expect_code 0
expect_text err "plants: $(figure ribbons) ribbons out of"
in=$(figure triangles_in)
[ "$in" -gt 20000 ] || fail "$in triangles of a tree of 20,000 vertices"
[ $(($(figure ribbon_triangles) + $(figure tube_triangles) + $(figure kept_triangles))) -eq "$in" ] ||
    fail "triangles are lost"
[ "$(figure triangles)" -eq "$(figure kept_triangles)" ] || fail "kept triangles are not all stored"
[ $(($(figure ribbons) + $(figure tubes))) -eq "$(figure strips)" ] || fail "not every line is stored"
[ $((100 * $(figure vertices_after))) -le $((35 * $(figure vertices_before))) ] ||
    fail "$(figure vertices_after) of $(figure vertices_before) vertices are left"

run "$STIPPLE" verify "$FOLDER/t.stipple"
expect_code 0
run "$STIPPLE" info "$FOLDER/t.stipple"
expect_text out "colour lines triangles"

# Scans beside the mesh stay points; scans alone are no plant.
run "$STIPPLE" prep "$FOLDER/mesh.ply" "$FOLDER/tree.ply" -o "$FOLDER/both.stipple" --lines auto
expect_code 0
expect_text err "20000 stored"
run "$STIPPLE" prep "$FOLDER/tree.ply" -o "$FOLDER/none.stipple" --lines auto
expect_code 1
expect_text err "tree.ply has no faces: --lines auto makes lines of a plant's mesh"
[ ! -e "$FOLDER/none.stipple" ] || fail "a file was written"
for other in --hybrid "--sample 100"; do
    run "$STIPPLE" prep "$FOLDER/mesh.ply" -o "$FOLDER/none.stipple" --lines auto $other
    expect_code 2
    expect_text err "--lines auto leaves no faces"
done

# A plant that is read as points gets a hint. Other meshes do not.
run "$STIPPLE" prep "$FOLDER/mesh.ply" -o "$FOLDER/points.stipple"
expect_code 0
expect_text err "mesh.ply looks like a plant: --lines auto turns"
run "$STIPPLE" gen statue --mesh "$FOLDER/statue-mesh.ply" --mesh-triangles 40000 --quiet
expect_code 0
run "$STIPPLE" prep "$FOLDER/statue-mesh.ply" -o "$FOLDER/statue.stipple"
expect_code 0
grep -q "looks like a plant" "$FOLDER/err" && fail "a statue is taken for a plant"
end_test
