#!/usr/bin/env bash
# Makes the known-answer files of files/ from scans of `stipple gen`, for a new version of the
# format. The files of released versions stay as they are.
#   make.sh PROGRAM FOLDER
set -euo pipefail
known=$(cd "$(dirname "$0")" && pwd)
program=$(realpath "$1")
mkdir -p "$2"
cd "$2"

# Prints a scan's points as lines of x y z r g b intensity class, then `far` points far away.
add_columns() { # scan.ply far
    python3 - "$1" "$2" <<'END'
import struct
import sys
data = open(sys.argv[1], "rb").read()
rows = struct.iter_unpack("<3f3B", data[data.index(b"end_header\n") + 11:])
for i, row in enumerate(rows):
    print(*row, (i * 37 + i * i // 50) % 4096, (i // 40) % 6)
for i in range(int(sys.argv[2])):
    print(9 + i, 8, 7, 200, 100, 50, 4000, 7)
END
}

answer() { # name scan options...
    local name=$1
    "$program" prep "$2" -o "${name}_raw.stipple" --codec raw --format 1 --normal-bits 12 --quiet "${@:3}"
    for codec in draco zstd; do
        "$program" convert "${name}_raw.stipple" -o "${name}_$codec.stipple" --codec $codec --quiet
    done
    python3 "$known/read.py" "${name}_raw.stipple" >"$name.samples"
}

"$program" gen sphere -n 600 -o sphere.ply --quiet
"$program" gen tree -n 500 -o leaves.ply --mesh tree.ply --quiet
"$program" gen statue -n 600 --noise 0.1 -o statue.ply --quiet
add_columns sphere.ply 0 >sphere.txt
add_columns statue.ply 2 >statue.txt
columns=x,y,z,r,g,b,i,class
answer points_1_0 sphere.txt --columns $columns --orient 0,0,0
answer lines_1_1 tree.ply --lines auto --recompute-normals
answer fits_1_2 statue.txt --columns $columns --outliers mark --orient 0,9,0

in_blocks() { # name scan options...
    local name=$1
    "$program" prep "$2" -o whole.stipple --format 1 --quiet --force "${@:3}"
    for codec in raw draco zstd; do
        "$program" convert whole.stipple -o "${name}_$codec.stipple" --codec $codec --format 2 --block 200 --quiet
    done
    python3 "$known/read.py" "${name}_raw.stipple" >"$name.samples"
}

"$program" gen tree -n 1200 -o leaves.ply --mesh tree.ply --quiet --force
in_blocks blocks_2_0 tree.ply --lines auto --recompute-normals
in_blocks grid_2_0 statue.txt --columns $columns --outliers mark --normal-bits 8
# The first files of version 2, blocks_2_0 and grid_2_0, have no odds. These have, and the second has a scale.
in_blocks odds_2_0 statue.txt --columns $columns --outliers mark --normal-bits 8
awk '{ for (i = 1; i <= 3; i++) $i = sprintf("%.2f", 9 * $i); print }' statue.txt >cm.txt
in_blocks scale_2_0 cm.txt --columns $columns --outliers mark
# From here on patches are predicted by middles.
"$program" gen statue -n 1200 --seed 2 -o middles.ply --quiet
in_blocks middles_2_0 middles.ply
# From here on parts are tight. The points have a scale; of maps, squares have tight tables, other parts are tight.
mkdir -p tight
"$program" gen statue -n 1000 --seed 3 -o middles.ply --quiet --force
add_columns middles.ply 0 | awk '{ for (i = 1; i <= 3; i++) $i = sprintf("%.2f", 9 * $i); print }' >cm.txt
in_blocks tight/points_2_0 cm.txt --columns $columns
"$program" gen statue -n 700 --seed 5 -o maps.ply --quiet
for codec in raw draco zstd; do
    "$program" prep maps.ply --maps -o "tight/maps_2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" tight/maps_2_0_raw.stipple >tight/maps_2_0.samples

# Points as LAS: times of a clock, colours and intensities of 16 bits, counters that come in runs.
python3 - attributes.las <<'END'
import math
import struct
import sys
count, tick, pulse, begin = 700, 1467.4587, 236.5511, struct.unpack("<Q", struct.pack("<d", 245379.25))[0]
kinds = ((5, "counter"), (9, "warmth"))
body = b"".join(struct.pack("<HBB32s156x", 0, kind, 0, name.encode()) for kind, name in kinds)
head = bytearray(375)
struct.pack_into("<4s20xBB", head, 0, b"LASF", 1, 4)
struct.pack_into("<HIIBHI", head, 94, 375, 375 + 54 + len(body), 1, 7, 44, 0)
struct.pack_into("<6d", head, 131, 0.01, 0.01, 0.01, 637000.0, 849000.0, 400.0)
struct.pack_into("<Q", head, 247, count)
out = bytes(head) + struct.pack("<H16sHH32s", 0, b"LASF_Spec", 4, len(body), b"") + body
for i in range(count):
    row, column = i // 28, i % 28
    z = round(60 * math.sin(row / 5) * math.cos(column / 6))
    time = begin + round(round((row * 1123 + column) * pulse) * tick)
    light = 200 * row + 977 * column
    out += struct.pack("<iiiHBBBBhHQ", 100 * column, 100 * row, z, light, 17 + 16 * (i % 5 == 0), i % 2 << 6, 2, 0,
                       100 * (column - 14), 7, time)
    out += struct.pack("<HHHIf", light, 65535 - light, 300 * column, i % 3 << 24 | i, round(20 + row / 8, 2))
open(sys.argv[1], "wb").write(out)
END
"$program" prep attributes.las --attributes all --precision exact --codec raw -o attributes_2_0_raw.stipple --quiet
for codec in draco zstd; do
    "$program" convert attributes_2_0_raw.stipple -o attributes_2_0_$codec.stipple --codec $codec --quiet
done
python3 "$known/read.py" attributes_2_0_raw.stipple >attributes_2_0.samples
python3 "$known/attributes.py" attributes_2_0_raw.stipple >attributes_2_0.numbers

# Files that points were added to.
mkdir -p grown
"$program" gen sphere -n 400 -o sphere.ply --quiet --force
"$program" gen sphere -n 60 --seed 7 -o more.ply --quiet
for codec in raw draco zstd; do
    "$program" prep sphere.ply -o "grown/2_1_$codec.stipple" --codec $codec --quiet
    "$program" prep --append more.ply -o "grown/2_1_$codec.stipple" --quiet
done
python3 "$known/read.py" grown/2_1_raw.stipple >grown/2_1.samples

# A grid of heights of two tiles: a slope with waves, a cliff, a hole and single samples that are missing.
awk 'BEGIN {
    print "ncols 264\nnrows 6\nxllcorner 100\nyllcorner 50\ncellsize 2\nNODATA_value -1"
    for (r = 0; r < 6; r++)
        for (c = 0; c < 264; c++) {
            none = (c > 40 && c < 46 && r > 1) || (7 * c + 13 * r) % 61 == 0
            z = 0.3 * c + r + 4 * sin(c / 5) + (c > 150 ? 60 : 0) + (31 * c + 17 * r) % 5 / 10
            printf "%s%s", none ? -1 : sprintf("%.1f", z), c < 263 ? " " : "\n"
        }
}' >grid.asc
for codec in raw draco zstd; do
    "$program" prep grid.asc -o "squares_2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" squares_2_0_raw.stipple >squares_2_0.samples

# Elevation maps: squares on tilted planes, and points that stay.
"$program" gen statue -n 700 --seed 4 -o maps.ply --quiet --force
for codec in raw draco zstd; do
    "$program" prep maps.ply --maps -o "maps_2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" maps_2_0_raw.stipple >maps_2_0.samples

# From here on parts of squares are tight, too: of the grid, and of maps.
"$program" gen statue -n 600 --seed 6 -o maps.ply --quiet --force
for codec in raw draco zstd; do
    "$program" prep grid.asc -o "tight/squares_2_0_$codec.stipple" --codec $codec --quiet
    "$program" prep maps.ply --maps -o "tight/tilted_2_0_$codec.stipple" --codec $codec --quiet
done
for name in squares tilted; do
    python3 "$known/read.py" "tight/${name}_2_0_raw.stipple" >"tight/${name}_2_0.samples"
done

# A depth camera's image: squares that spread, cut at the outline of a ball; a hole, and single pixels that are missing.
awk 'BEGIN {
    print "P2\n72 40\n65535"
    for (r = 0; r < 40; r++)
        for (c = 0; c < 72; c++) {
            ball = (c - 30) ^ 2 + (r - 18) ^ 2
            d = ball < 150 ? 900 - 2 * ball : 400 + 2 * c + 3 * r
            none = (c > 50 && c < 56 && r > 25) || (7 * c + 13 * r) % 61 == 0
            printf "%d%s", none ? 0 : 3000000 / (d + (31 * c + 17 * r) % 5), c < 71 ? " " : "\n"
        }
}' >depth.pgm
mkdir -p depth
for codec in raw draco zstd; do
    "$program" prep depth.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "depth/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" depth/2_0_raw.stipple >depth/2_0.samples

# From here on the table of blocks has small records.
"$program" gen tree -n 1400 --seed 8 -o leaves.ply --mesh tree.ply --quiet --force
"$program" prep tree.ply --lines auto --recompute-normals -o whole.stipple --format 1 --quiet --force
mkdir -p records
for codec in raw draco zstd; do
    "$program" convert whole.stipple -o "records/2_0_$codec.stipple" --codec $codec --format 2 --block 150 --quiet
done
python3 "$known/read.py" records/2_0_raw.stipple >records/2_0.samples

# From here on rasters of maps are short.
mkdir -p short
"$program" gen statue -n 650 --seed 9 -o maps.ply --quiet --force
for codec in raw draco zstd; do
    "$program" prep maps.ply --maps -o "short/maps_2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" short/maps_2_0_raw.stipple >short/maps_2_0.samples
# From here on depths that come in steps have a ladder.
awk 'NR < 4 { print; next } {
    for (c = 1; c <= NF; c++) printf "%d%s", $c ? 60000 / int(60000 / $c) : 0, c < NF ? " " : "\n"
}' depth.pgm >steps.pgm
mkdir -p ladder
for codec in raw draco zstd; do
    "$program" prep steps.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "ladder/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" ladder/2_0_raw.stipple >ladder/2_0.samples
# From here on colours may be loose: here they are smooth on the left, and noise on the right.
awk 'BEGIN {
    print "ncols 96\nnrows 24\nxllcorner 0\nyllcorner 0\ncellsize 1" >"hills.asc"
    print "P3\n96 24\n255"
    for (r = 0; r < 24; r++)
        for (c = 0; c < 96; c++) {
            printf "%.2f%s", 3 * sin(c / 9) + 2 * cos(r / 7), c < 95 ? " " : "\n" >"hills.asc"
            noise = c < 64 ? 0 : (c * c * 31 + r * r * 17 + c * r) % 60
            print int(90 + c / 3 + r / 2 + noise), int(80 + 20 * sin(c / 20) + noise), int(200 - c - r / 3 + noise)
        }
}' >hills.ppm
mkdir -p loose
for codec in raw draco zstd; do
    "$program" prep hills.asc --colour hills.ppm -o "loose/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" loose/2_0_raw.stipple >loose/2_0.samples

# From here on tight parts have short states.
mkdir -p states
"$program" gen statue -n 800 --seed 10 -o middles.ply --quiet --force
in_blocks states/2_0 middles.ply

# From here on indices of blocks have short rows.
mkdir -p rows
"$program" gen statue -n 900 --seed 11 -o middles.ply --quiet --force
in_blocks rows/2_0 middles.ply
# From here on radii are coarse, and positions of points lie on sublattices.
mkdir -p coarse
"$program" gen statue -n 1000 --seed 13 -o middles.ply --quiet --force
in_blocks coarse/2_0 middles.ply
# From here on odds are known; fits and closed samples tell of them, too.
mkdir -p known
"$program" gen statue -n 1200 --noise 0.5 --seed 15 -o middles.ply --quiet --force
in_blocks known/2_0 middles.ply
# From here on sublattices may be slanted.
mkdir -p slanted
"$program" gen statue -n 1600 --noise 0.3 --seed 21 -o middles.ply --quiet --force
in_blocks slanted/2_0 middles.ply
# From here on odds go by signed cells.
mkdir -p signed
"$program" gen statue -n 1800 --noise 0.3 --seed 23 -o middles.ply --quiet --force
in_blocks signed/2_0 middles.ply
# Maps as their paper stores them, and the same in the other codecs.
mkdir -p paper
"$program" gen statue -n 700 --seed 12 -o maps.ply --quiet --force
"$program" prep maps.ply --maps --map-codec paper -o paper/2_0_paper.stipple --quiet
for codec in raw draco zstd; do
    "$program" convert paper/2_0_paper.stipple -o "paper/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" paper/2_0_raw.stipple >paper/2_0.samples
# From here on equal corners of triangles are told once.
mkdir -p corners
"$program" gen sphere -n 300 --seed 14 -o maps.ply --quiet --force
for codec in raw draco zstd; do
    "$program" prep maps.ply --maps --gaps fill -o "corners/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" corners/2_0_raw.stipple >corners/2_0.samples
# From here on merged heights of squares have steps, and normals on sides of their grid are told by one code.
mkdir -p sides
for codec in raw draco zstd; do
    "$program" prep steps.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "sides/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" sides/2_0_raw.stipple >sides/2_0.samples
# From here on normals of noisy images follow from merged ones.
mkdir -p turns
awk 'BEGIN {
    print "P2\n72 40\n65535"
    for (r = 0; r < 40; r++)
        for (c = 0; c < 72; c++) {
            noise = (c * c * 31 + r * r * 17 + c * r * 7) % 60 / 100
            d = 2200 + 9 * c + (c > 40 && r > 10 ? 700 : 0) + 40 * sin(c / 9) * cos(r / 7)
            print (c - 20) ^ 2 + (r - 20) ^ 2 < 9 ? 0 : int(4e5 / int(4e5 / d + noise))
        }
}' >turns.pgm
for codec in raw draco zstd; do
    "$program" prep turns.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "turns/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" turns/2_0_raw.stipple >turns/2_0.samples
# From here on colours of level 0 come by rows.
mkdir -p painted
awk 'BEGIN {
    print "P3\n72 40\n255"
    for (r = 0; r < 40; r++)
        for (c = 0; c < 72; c++) {
            ball = (c - 30) ^ 2 + (r - 18) ^ 2 < 150
            noise = (c * c * 31 + r * r * 17 + c * r) % 23
            print int((ball ? 200 : 60) + c / 3 + noise), int((ball ? 40 : 90) + r / 2 + noise), int(ball ? 20 + noise : 250 - 3 * c)
        }
}' >paint.ppm
for codec in raw draco zstd; do
    "$program" prep depth.pgm --colour paint.ppm --pinhole 60,60,35.5,19.5 --height-scale 0.001 \
        -o "painted/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" painted/2_0_raw.stipple >painted/2_0.samples
# From here on odds of squares are known, too: of a grid, and of an image with colours by rows and a ladder.
for codec in raw draco zstd; do
    "$program" prep grid.asc -o "known/level_2_0_$codec.stipple" --codec $codec --quiet
    "$program" prep steps.pgm --colour paint.ppm --pinhole 60,60,35.5,19.5 --height-scale 0.001 \
        -o "known/depth_2_0_$codec.stipple" --codec $codec --quiet
done
for name in level depth; do
    python3 "$known/read.py" "known/${name}_2_0_raw.stipple" >"known/${name}_2_0.samples"
done
# From here on colours by rows are told by parents, too.
mkdir -p parents
for codec in raw draco zstd; do
    "$program" prep depth.pgm --colour paint.ppm --pinhole 60,60,35.5,19.5 --height-scale 0.001 \
        -o "parents/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" parents/2_0_raw.stipple >parents/2_0.samples
# From here on normals of noisy images that do not follow are whole strides off.
mkdir -p strides
for codec in raw draco zstd; do
    "$program" prep turns.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "strides/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" strides/2_0_raw.stipple >strides/2_0.samples
# From here on patches of squares are placed by them: of a grid, of maps, and of an image.
mkdir -p placed
"$program" gen statue -n 600 --seed 16 -o maps.ply --quiet --force
for codec in raw draco zstd; do
    "$program" prep grid.asc -o "placed/level_2_0_$codec.stipple" --codec $codec --quiet
    "$program" prep maps.ply --maps -o "placed/tilted_2_0_$codec.stipple" --codec $codec --quiet
    "$program" prep depth.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "placed/depth_2_0_$codec.stipple" --codec $codec --quiet
done
for name in level tilted depth; do
    python3 "$known/read.py" "placed/${name}_2_0_raw.stipple" >"placed/${name}_2_0.samples"
done
# From here on rasters of cameras follow from where these are. The second one is turned.
mkdir -p camera
printf '# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 40\nHEIGHT 72\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2880\nDATA ascii\n' >turned.pcd
awk 'BEGIN {
    for (c = 71; c >= 0; c--)
        for (r = 0; r < 40; r++) {
            z = 2 + c / 90 + (c > 40 && r > 10 ? 0.7 : 0)
            print (c - 35.5) * z / 60, z, (19.5 - r) * z / 60
        }
}' >>turned.pcd
for codec in raw draco zstd; do
    "$program" prep depth.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "camera/depth_2_0_$codec.stipple" --codec $codec --quiet
    "$program" prep turned.pcd -o "camera/turned_2_0_$codec.stipple" --codec $codec --quiet
done
for name in depth turned; do
    python3 "$known/read.py" "camera/${name}_2_0_raw.stipple" >"camera/${name}_2_0.samples"
done
# From here on errors of images are rounded, and axes of all squares.
mkdir -p rounded
"$program" gen statue -n 600 --seed 17 -o maps.ply --quiet --force
for codec in raw draco zstd; do
    "$program" prep depth.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "rounded/depth_2_0_$codec.stipple" --codec $codec --quiet
    "$program" prep maps.ply --maps -o "rounded/tilted_2_0_$codec.stipple" --codec $codec --quiet
done
for name in depth tilted; do
    python3 "$known/read.py" "rounded/${name}_2_0_raw.stipple" >"rounded/${name}_2_0.samples"
done
# From here on steps of normals are 3, 5 and 7 times a power of two, too, in tight parts and in loose ones.
mkdir -p steps
for name in steps/2_0,1500 steps/loose_2_0,2050; do
    "$program" gen terrain -n "${name#*,}" --noise 0.3 --seed 17 -o middles.ply --quiet --force
    in_blocks "${name%,*}" middles.ply
done
# From here on slopes of images' heights stop at jumps, and radii of merged samples are rounded to half octaves.
mkdir -p jumps
for codec in raw draco zstd; do
    "$program" prep depth.pgm --pinhole 60,60,35.5,19.5 --height-scale 0.001 -o "jumps/2_0_$codec.stipple" --codec $codec --quiet
done
python3 "$known/read.py" jumps/2_0_raw.stipple >jumps/2_0.samples
rm turned.pcd paint.ppm turns.pgm attributes.las depth.pgm hills.asc hills.ppm steps.pgm middles.ply more.ply cm.txt grid.asc maps.ply whole.stipple leaves.ply sphere.ply sphere.txt statue.ply statue.txt tree.ply
