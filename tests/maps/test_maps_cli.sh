#!/usr/bin/env bash
# Tests elevation maps from the command line: what prep, its figures, info and export say, which
# options do not fit together, and that the model is drawn, each way.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
model="$FOLDER/m.stipple"

"$STIPPLE" gen torus -n 20k -o "$FOLDER/torus.ply" --quiet || fail "gen"
run "$STIPPLE" prep "$FOLDER/torus.ply" --maps -o "$model" --stats "$FOLDER/stats.json"
expect_code 0
expect_text err " samples stand for "
expect_text err "the surface of the maps is at most "
[ "$(($(field represented) + $(field as_points)))" = 20000 ] || fail "represented and as_points are not all points"
grep -A1 '"maps":[[:space:]]*{' "$FOLDER/stats.json" | grep -q '"maps":[[:space:]]*[1-9]' || fail "stats without maps"
"$STIPPLE" verify "$model" --quiet || fail "verify"

run "$STIPPLE" info "$model"
expect_code 0
expect_text out "resampled      "
expect_text out "               the surface is at most "
run "$STIPPLE" info "$model" --json
for key in represented as_points rejected samples cone_deg greatest mean; do
    expect_text out "\"$key\":"
done

run "$STIPPLE" export "$model" -o "$FOLDER/back.ply"
expect_code 0
expect_text err "holds resampled points: "
run "$STIPPLE" export "$model" -o "$FOLDER/back.ply" --force --quiet
expect_code 0
[ -s "$FOLDER/err" ] && fail "--quiet, but: $(cat "$FOLDER/err")"

# A model of points says nothing of maps.
"$STIPPLE" prep "$FOLDER/torus.ply" -o "$FOLDER/points.stipple" --quiet || fail "prep"
run "$STIPPLE" info "$FOLDER/points.stipple"
grep -q resampled "$FOLDER/out" && fail "info: resampled, without maps"
run "$STIPPLE" export "$FOLDER/points.stipple" -o "$FOLDER/back.ply" --force
grep -q resampled "$FOLDER/err" && fail "export: resampled, without maps"

refuse() { # options, and what the message says
    run "$STIPPLE" prep "$FOLDER/torus.ply" -o "$FOLDER/none.stipple" "${@:1:$#-1}"
    expect_code 2
    expect_text err "${!#}"
    [ -e "$FOLDER/none.stipple" ] && fail "$command: a file in spite of wrong options"
}
refuse --cone 60 "give --maps, too"
refuse --map-error 1 "give --maps, too"
refuse --gaps fill "give --maps, too"
refuse --maps --gaps wide "--gaps"
refuse --map-codec paper "give --maps, too"
refuse --maps --map-codec small "--map-codec"
refuse --maps --map-codec paper --format 1 "leave out --format 1"
refuse --maps --cone 5 "--cone: give 10 to 80"
refuse --maps --cone 81 "--cone: give 10 to 80"
refuse --maps --map-error -1 "--map-error: give a positive length"
refuse --maps --map-error 0 "--map-error: give a positive length"
refuse --maps --cone 0 "--cone: give 10 to 80"
refuse --maps --precision exact "--precision exact"
refuse --maps --attributes all "--attributes"
refuse --maps --orient none "--orient none"

# The codec of the paper holds the same samples.
run "$STIPPLE" prep "$FOLDER/torus.ply" --maps --map-codec paper -o "$FOLDER/paper.stipple"
expect_code 0
"$STIPPLE" verify "$FOLDER/paper.stipple" --quiet || fail "verify paper"
run "$STIPPLE" info "$FOLDER/paper.stipple"
expect_text out "codec          paper"
"$STIPPLE" convert "$FOLDER/paper.stipple" --codec draco -o "$FOLDER/compact.stipple" --quiet || fail "convert"
cmp "$model" "$FOLDER/compact.stipple" || fail "the paper's codec loses something"

# Gaps between maps are filled: the model says so, and the torus is closed.
run "$STIPPLE" prep "$FOLDER/torus.ply" --maps --gaps fill -o "$FOLDER/filled.stipple" --stats "$FOLDER/filled.json"
expect_code 0
expect_text err " triangles fill the gaps between maps; 0 edges stay open"
"$STIPPLE" verify "$FOLDER/filled.stipple" --quiet || fail "verify filled"
for key in between open_edges; do
    grep -q "\"$key\":" "$FOLDER/filled.json" || fail "stats without $key"
done
grep -q '"between":' "$FOLDER/stats.json" && fail "gaps are said to be filled, but are not"
run "$STIPPLE" info "$FOLDER/filled.stipple"
expect_text out " triangles fill the gaps between maps; 0 edges stay open"
run "$STIPPLE" info "$FOLDER/filled.stipple" --json
expect_text out '"between":'
run "$STIPPLE" info "$model"
grep -q "fill the gaps" "$FOLDER/out" && fail "info: gaps are filled, but are not"

# A ceiling, exactly along the axes: its map looks down.
awk 'BEGIN {
    print "ply\nformat ascii 1.0\nelement vertex 2048\nproperty float x\nproperty float y\nproperty float z"
    print "property float nx\nproperty float ny\nproperty float nz\nend_header"
    for (i = 0; i < 2048; i++) print i % 64, int(i / 64), 3, 0, 0, -1
}' >"$FOLDER/ceiling.ply"
run "$STIPPLE" prep "$FOLDER/ceiling.ply" --maps -o "$FOLDER/ceiling.stipple"
expect_code 0
expect_text err "1 maps of"
run "$STIPPLE" export "$FOLDER/ceiling.stipple" -o "$FOLDER/down.ply"
expect_code 0
! command -v python3 >/dev/null || python3 - "$FOLDER/down.ply" <<'END' || fail "a normal looks up"
import struct
import sys
data = open(sys.argv[1], "rb").read()
end = data.index(b"end_header\n") + 11
names = [line.split()[1:] for line in data[:end].decode().splitlines() if line.startswith("property")]
rows = struct.Struct("<" + "".join({"float": "f", "double": "d", "uchar": "B"}[kind] for kind, _ in names))
normals = [dict(zip((name for _, name in names), row))["nz"] for row in rows.iter_unpack(data[end:])]
sys.exit(len(normals) < 2048 or max(normals) > -0.99)
END

# A mesh in folds: samples of maps lie on its faces, and so are nearer to its vertices than those of the vertices
# alone, which lie between the folds.
folds() { # faces, and the file
    awk -v faces="$1" 'BEGIN {
        for (i = 0; i < 4096; i++) print "v", i % 64, int(i / 64), i % 64 % 2 * 0.3
        for (i = 0; faces && i < 4032; i++) if (i % 64 < 63) print "f", i + 1, i + 2, i + 66, i + 65
    }' >"$2"
}
folds 1 "$FOLDER/folds.obj"
folds 0 "$FOLDER/vertices.obj"
for name in folds vertices; do
    run "$STIPPLE" prep "$FOLDER/$name.obj" --maps --sample none -o "$FOLDER/$name.stipple" --stats "$FOLDER/$name.json"
    expect_code 0
    expect_text err "stand for 4096 points"
    "$STIPPLE" verify "$FOLDER/$name.stipple" --quiet || fail "verify $name"
done
mean() { grep -o '"mean":[^,}]*' "$FOLDER/$1.json" | tail -1 | cut -d: -f2; }
awk -v faces="$(mean folds)" -v vertices="$(mean vertices)" 'BEGIN { exit !(faces < 0.9 * vertices) }' ||
    fail "the faces of a mesh do not count: $(mean folds) and $(mean vertices)"

# A slanted wall, Z = 3 m + 0.8 X, by a camera whose depths come in steps of 60 mm: wider than maps average. Samples keep
# the normals that the whole image tells.
python3 - "$FOLDER/wall.pgm" <<'END'
import struct, sys
with open(sys.argv[1], 'wb') as out:
    out.write(b'P5\n320 240\n65535\n')
    for pixel in range(320 * 240):
        depth = 3000.0 / (1.0 - 0.8 * (pixel % 320 - 160) / 300.0)
        out.write(struct.pack('>H', int(depth / 60.0 + 0.5) * 60))
END
run "$STIPPLE" prep "$FOLDER/wall.pgm" --pinhole 300,300,160,120 --height-scale 0.001 --maps -o "$FOLDER/wall.stipple"
expect_code 0
run "$STIPPLE" export "$FOLDER/wall.stipple" -o "$FOLDER/wall.ply"
expect_code 0
python3 - "$FOLDER/wall.ply" <<'END' || fail "normals of a wall in steps"
import math, struct, sys
data = open(sys.argv[1], 'rb').read()
normals = [s[3:] for s in struct.iter_unpack('<6f', data[data.index(b'end_header\n') + 11:])]
wall = (0.8, 0.0, -1.0)
off = sum(math.acos(sum(a * b for a, b in zip(n, wall)) / math.sqrt(1.64)) for n in normals) / len(normals)
sys.exit(math.degrees(off) > 1.5)
END

# The same picture as of points, but for what resampling changes.
if "$STIPPLE" --help | found '^  render '; then
    for name in m points; do
        "$STIPPLE" render "$FOLDER/$name.stipple" -o "$FOLDER/$name.png" --size 200x200 --quiet || fail "render $name"
    done
    run "$STIPPLE" compare "$FOLDER/points.png" "$FOLDER/m.png"
    awk '$1 == "psnr_db" && $2 < 25 { exit 1 }' "$FOLDER/out" || fail "the picture of maps: $(cat "$FOLDER/out")"
    # Each way to draw maps is a picture of its own, near enough to that of points.
    declare -A pictures=()
    for way in mesh splats blend plain points; do
        run "$STIPPLE" render "$model" -o "$FOLDER/$way.png" --size 200x200 --threshold 0 --maps-as $way --force --quiet
        expect_code 0
        run "$STIPPLE" compare "$FOLDER/points.png" "$FOLDER/$way.png"
        awk '$1 == "psnr_db" && $2 < 20 { exit 1 }' "$FOLDER/out" || fail "--maps-as $way: $(cat "$FOLDER/out")"
        pictures[$(cksum <"$FOLDER/$way.png")]=$way
    done
    [ ${#pictures[@]} = 5 ] || fail "--maps-as: ${#pictures[@]} pictures of 5 ways: ${pictures[*]}"
    run "$STIPPLE" render "$model" -o "$FOLDER/x.png" --maps-as discs
    expect_code 2
    expect_text err "--maps-as"
fi
end_test
