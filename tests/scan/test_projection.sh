#!/usr/bin/env bash
# Tests coordinate systems: points in degrees come to the zone of UTM they lie in, where Krueger's series
# says, and so do grids; inputs of several systems become one; --to; what is refused.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

wgs84='GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]'

# Easting and northing of "longitude latitude" lines in a zone of UTM: Krueger's series to n^4, right to
# a micrometre.
utm() { # zone
    awk -v zone="$1" '
    function tan_(x) { return sin(x) / cos(x) }
    function sinh_(x) { return (exp(x) - exp(-x)) / 2 }
    function cosh_(x) { return (exp(x) + exp(-x)) / 2 }
    function asinh_(x) { return x < 0 ? -log(-x + sqrt(x * x + 1)) : log(x + sqrt(x * x + 1)) }
    function atanh_(x) { return 0.5 * log((1 + x) / (1 - x)) }
    BEGIN {
        pi = atan2(0, -1); a = 6378137; f = 1 / 298.257223563; n = f / (2 - f); e = sqrt(f * (2 - f))
        A = a / (1 + n) * (1 + n^2 / 4 + n^4 / 64)
        h[1] = n / 2 - 2 * n^2 / 3 + 5 * n^3 / 16 + 41 * n^4 / 180
        h[2] = 13 * n^2 / 48 - 3 * n^3 / 5 + 557 * n^4 / 1440
        h[3] = 61 * n^3 / 240 - 103 * n^4 / 140
        h[4] = 49561 * n^4 / 161280
    }
    {
        l = ($1 - (6 * zone - 183)) * pi / 180; p = $2 * pi / 180
        s = sinh_(e * atanh_(e * sin(p))); t = tan_(p); t = t * sqrt(1 + s * s) - s * sqrt(1 + t * t)
        x = atan2(t, cos(l)); y = asinh_(sin(l) / sqrt(t * t + cos(l)^2))
        E = y; N = x
        for (j = 1; j <= 4; j++) { E += h[j] * cos(2 * j * x) * sinh_(2 * j * y); N += h[j] * sin(2 * j * x) * cosh_(2 * j * y) }
        printf "%.6f %.6f %s\n", 500000 + 0.9996 * A * E, 0.9996 * A * N + ($2 < 0 ? 10000000 : 0), $3
    }'
}

# Points of a model: x y z, in order.
points() { # model
    "$STIPPLE" export "$1" -o "$FOLDER/points.ply" --force --quiet || fail "export $1"
    python3 - "$FOLDER/points.ply" <<'END' | sort
import struct, sys
data = open(sys.argv[1], "rb").read()
head, body = data.split(b"end_header\n", 1)
kinds = {"float": "f", "double": "d", "uchar": "B", "ushort": "H", "int": "i", "uint": "I"}
fields = [line.split() for line in head.decode().split("\n") if line.startswith("property")]
row = struct.Struct("<" + "".join(kinds[f[1]] for f in fields))
for i in range(len(body) // row.size):
    v = dict(zip((f[2] for f in fields), row.unpack_from(body, i * row.size)))
    print("%.6f %.6f %.3f" % (v["x"], v["y"], v["z"]))
END
}

near() { # expected file, found file, metres
    paste -d' ' "$1" "$2" | awk -v most="$3" '
        { d = sqrt(($1 - $4)^2 + ($2 - $5)^2 + ($3 - $6)^2); worst = d > worst ? d : worst }
        END { printf "%d lines, %.6f off\n", NR, worst; exit !(NR > 0 && worst <= most) }' >"$FOLDER/near" ||
        fail "$command: $(cat "$FOLDER/near")"
}

scatter() { # longitude latitude: 40 places around
    awk -v x="$1" -v y="$2" 'BEGIN {
        for (i = 0; i < 40; i++) printf "%.8f %.8f %d\n", x + 0.00002 * (i % 7), y + 0.00002 * int(i / 7), 100 + i
    }'
}

# Degrees, by the .prj beside the file, to the zone at hand, north and south.
for place in "9.1 48.7 32" "-70.55 -33.41 19" "179.999 12 60"; do
    read -r x y zone <<<"$place"
    scatter "$x" "$y" >"$FOLDER/in.xyz"
    printf '%s' "$wgs84" >"$FOLDER/in.prj"
    run "$STIPPLE" prep "$FOLDER/in.xyz" -o "$FOLDER/m.stipple" --force --precision 0.0002
    [ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
    expect_text err "UTM zone $zone"
    utm "$zone" <"$FOLDER/in.xyz" | sort >"$FOLDER/expected"
    points "$FOLDER/m.stipple" >"$FOLDER/found"
    near "$FOLDER/expected" "$FOLDER/found" 0.001
    "$STIPPLE" info "$FOLDER/m.stipple" --json | found "UTM zone $zone" || fail "$command: info names no system"
done

# Degrees without a system: text whose columns are named so, or whose x and y are as fine as only degrees are, in
# either order; LAS whose lattice is. Metres stay, also those of a pole.
scatter 139.7 35.6 >"$FOLDER/degrees"
utm 54 <"$FOLDER/degrees" | sort >"$FOLDER/expected"
awk '{ print $2, $1, $3 }' "$FOLDER/degrees" >"$FOLDER/swapped.xyz"
awk 'BEGIN { print "id;lat;lon;alt" } { gsub(/[.]/, ","); print NR ";" $2 ";" $1 ";" $3 }' "$FOLDER/degrees" >"$FOLDER/named.csv"
cp "$FOLDER/degrees" "$FOLDER/plain.xyz"
python3 - "$FOLDER/degrees" "$FOLDER/lattice.las" <<'END'
import struct, sys
rows = [[float(v) for v in line.split()] for line in open(sys.argv[1])]
h = bytearray(227)
h[0:4], h[24], h[25] = b"LASF", 1, 2
struct.pack_into("<HIIBHI", h, 94, 227, 227, 0, 0, 20, len(rows))
struct.pack_into("<6d", h, 131, 1e-8, 1e-8, 0.01, 139, 35, 0)
for x, y, z in rows:
    h += struct.pack("<3i8x", round((x - 139) * 1e8), round((y - 35) * 1e8), round(z * 100))
open(sys.argv[2], "wb").write(h)
END
for input in plain.xyz swapped.xyz named.csv lattice.las; do
    run "$STIPPLE" prep "$FOLDER/$input" -o "$FOLDER/m.stipple" --force --precision 0.0002
    [ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
    expect_text err "1 of 1 inputs name no coordinate system, and their x and y are degrees"
    points "$FOLDER/m.stipple" >"$FOLDER/found"
    near "$FOLDER/expected" "$FOLDER/found" 0.002
done
awk '{ printf "%.6f %.6f %.6f\n", $1, $2, $3 + 0.123456 }' "$FOLDER/degrees" >"$FOLDER/pole.xyz"
run "$STIPPLE" prep "$FOLDER/pole.xyz" -o "$FOLDER/m.stipple" --force
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
! grep -q degrees\ of "$FOLDER/err" && ! grep -q 'brought to' "$FOLDER/err" || fail "$command: $(cat "$FOLDER/err")"

# Two systems become one: the second input is in another zone, and is brought to the first's.
mkdir "$FOLDER/two"
scatter 11.999 47.5 >"$FOLDER/degrees"
utm 32 <"$FOLDER/degrees" >"$FOLDER/two/a.xyz"
utm 33 <"$FOLDER/degrees" >"$FOLDER/b"
awk '{ print $1, $2, $3 + 50 }' "$FOLDER/b" >"$FOLDER/two/b.xyz"
for zone in "a 32 9" "b 33 15"; do
    read -r name number meridian <<<"$zone"
    printf 'PROJCS["WGS 84 / UTM zone %sN",%s,PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",%s],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]]' \
        "$number" "$wgs84" "$meridian" >"$FOLDER/two/$name.prj"
done
run "$STIPPLE" prep "$FOLDER/two/a.xyz" "$FOLDER/two/b.xyz" --to EPSG:32632 -o "$FOLDER/m.stipple" --force --precision 0.0002
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
expect_text err "1 of 2 inputs brought to WGS 84 / UTM zone 32N"
utm 32 <"$FOLDER/degrees" | awk '{ print; $3 += 50; print }' | sort >"$FOLDER/expected"
points "$FOLDER/m.stipple" >"$FOLDER/found"
near "$FOLDER/expected" "$FOLDER/found" 0.001
# Without --to, the first input's system is the one of all, and inputs that are in it stay as they are.
run "$STIPPLE" prep "$FOLDER/two" -o "$FOLDER/m.stipple" --force --precision 0.0002
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
expect_text err "1 of 2 inputs brought to WGS 84 / UTM zone 32N"
points "$FOLDER/m.stipple" >"$FOLDER/found"
near "$FOLDER/expected" "$FOLDER/found" 0.001
# Two texts of one system: nothing moves, and normals stay.
mkdir "$FOLDER/same"
printf 'ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n500000 5000000 7 0.6 0 0.8\n' |
    tee "$FOLDER/same/a.ply" >"$FOLDER/same/b.ply"
cp "$FOLDER/two/a.prj" "$FOLDER/same/a.prj"
sed 's/32N"/32N (ours)"/; s/,PARAMETER/, PARAMETER/g' "$FOLDER/two/a.prj" >"$FOLDER/same/b.prj"
run "$STIPPLE" prep "$FOLDER/same" -o "$FOLDER/m.stipple" --force
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
! grep -q 'brought to' "$FOLDER/err" || fail "$command: $(cat "$FOLDER/err")"
"$STIPPLE" export "$FOLDER/m.stipple" -o "$FOLDER/same.ply" --force --quiet
strings "$FOLDER/same.ply" | grep -q 'nx' || fail "the normals of one system are gone"
# A system that PROJ does not know: the points stay, and a sentence says so.
printf 'PROJCS["of a dream",GEOGCS["of a dream"' >"$FOLDER/same/b.prj"
run "$STIPPLE" prep "$FOLDER/same" -o "$FOLDER/m.stipple" --force
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
expect_text err "1 of 2 inputs name a system that PROJ does not know"
cp "$FOLDER/degrees" "$FOLDER/two/c.xyz"
printf '%s' "$wgs84" >"$FOLDER/two/c.prj"
run "$STIPPLE" prep "$FOLDER/two/b.xyz" "$FOLDER/two/c.xyz" -o "$FOLDER/m.stipple" --force --precision 0.0002
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
expect_text err "1 of 2 inputs brought to WGS 84 / UTM zone 33N"
awk '{ print; $3 -= 50; print }' "$FOLDER/two/b.xyz" | sort >"$FOLDER/expected"
points "$FOLDER/m.stipple" >"$FOLDER/found"
near "$FOLDER/expected" "$FOLDER/found" 0.001

# Published places, to a centimetre, and heights in the unit of the plane: EPSG's Guidance Note 7-2, examples of the
# Transverse Mercator and of Lambert's conics.
published() { # datum, its code, ellipsoid, longitude, latitude, system, easting, northing, height from 10
    echo "$4 $5 10" >"$FOLDER/published.xyz"
    printf 'GEOGCS["%s",DATUM["%s",SPHEROID["%s",%s],AUTHORITY["EPSG","%s"]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]' \
        "$1" "$1" "${3%%,*}" "${3#*,}" "$2" >"$FOLDER/published.prj"
    run "$STIPPLE" prep "$FOLDER/published.xyz" --to "$6" -o "$FOLDER/m.stipple" --force --precision 0.0002
    [ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
    echo "$7 $8 $9" >"$FOLDER/expected"
    points "$FOLDER/m.stipple" >"$FOLDER/found"
    near "$FOLDER/expected" "$FOLDER/found" 0.01
}
published OSGB_1936 6277 'Airy 1830,6377563.396,299.3249646' 0.5 50.5 EPSG:27700 577274.99 69740.50 10
published Jamaica_1969 6242 'Clarke 1866,6378206.4,294.978698213898' -76.94368333333 17.93216666667 EPSG:24200 255966.58 142493.51 10
published North_American_Datum_1927 6267 'Clarke 1866,6378206.4,294.978698213898' -96 28.5 EPSG:32040 2963503.91 254759.80 32.808

# A grid in degrees.
awk 'BEGIN {
    print "ncols 9\nnrows 6\nxllcenter 9.1\nyllcenter 48.7\ncellsize 0.00001"
    for (r = 5; r >= 0; r--) { line = ""; for (c = 0; c < 9; c++) line = line " " 300 + (c + 10 * r) / 8; print line }
}' >"$FOLDER/grid.asc"
printf '%s' "$wgs84" >"$FOLDER/grid.prj"
run "$STIPPLE" prep "$FOLDER/grid.asc" -o "$FOLDER/m.stipple" --force --precision 0.0002
[ "$code" = 0 ] || fail "$command: $(cat "$FOLDER/err")"
awk 'BEGIN { for (r = 0; r < 6; r++) for (c = 0; c < 9; c++) printf "%.8f %.8f %.3f\n", 9.1 + 0.00001 * c, 48.7 + 0.00001 * r, 300 + (c + 10 * r) / 8 }' |
    utm 32 | sort >"$FOLDER/expected"
points "$FOLDER/m.stipple" >"$FOLDER/found"
near "$FOLDER/expected" "$FOLDER/found" 0.001
"$STIPPLE" info "$FOLDER/m.stipple" | grep -q '^orientation  *file' || fail "a projected grid is no grid any more"

# With a spacing the grid has no place in the world: columns and rows are that far apart.
run "$STIPPLE" prep "$FOLDER/grid.asc" --spacing 30 -o "$FOLDER/m.stipple" --force
expect_code 0
points "$FOLDER/m.stipple" | awk '{ if ($1 > x) x = $1; if ($2 > y) y = $2 } END { exit !(x == 240 && y == 150) }' ||
    fail "--spacing on a grid in degrees: $(points "$FOLDER/m.stipple" | tail -1)"

# What cannot be.
printf '5 5 5\n6 6 6\n7 7 7\n' >"$FOLDER/plain.xyz"
run "$STIPPLE" prep "$FOLDER/plain.xyz" --to EPSG:25832 -o "$FOLDER/none.stipple"
expect_failure "does not say its coordinate system"
run "$STIPPLE" prep "$FOLDER/in.xyz" --to EPSG:99999999 -o "$FOLDER/none.stipple"
expect_failure "no way from"
for system in EPSG:4326 EPSG:4978; do
    run "$STIPPLE" prep "$FOLDER/in.xyz" --to $system -o "$FOLDER/none.stipple"
    expect_failure "$system has angles, or x, y and z from the earth"
done
printf 'v 9 48 1\nv 9.1 48 1\nv 9 48.1 2\nf 1 2 3\n' >"$FOLDER/mesh.obj"
printf '%s' "$wgs84" >"$FOLDER/mesh.prj"
run "$STIPPLE" prep "$FOLDER/mesh.obj" -o "$FOLDER/none.stipple"
expect_failure "has lines or faces"
[ -z "$(find "$FOLDER" -name 'none*')" ] || fail "a refused run left a file"
# A system that only GeoTIFF's keys or a .prj file name is kept as text, and goes into LAS files.
python3 - "$FOLDER/keys.las" <<'END'
import struct, sys
keys = [1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 2994]  # projected, NAD83(HARN) / Oregon GIC Lambert (ft)
record = struct.pack("<2x16sHH32s", b"LASF_Projection", 34735, 2 * len(keys), b"") + struct.pack("<12H", *keys)
head = struct.pack("<4sHH16xBB64xHHHIIBHI5I", b"LASF", 0, 0, 1, 2, 0, 0, 227, 227 + len(record), 1, 0, 20, 3, 3, 0, 0, 0, 0)
lattice = struct.pack("<12d", .01, .01, .01, 0, 0, 0, 7, 5, 7, 5, 7, 5)
points = b"".join(struct.pack("<3iHBBbBH", 100 * i, 100 * i, 100 * i, 0, 9, 2, 0, 0, 0) for i in (5, 6, 7))
open(sys.argv[1], "wb").write(head + lattice + record + points)
END
# Heights have the unit of their own system, if a key names one that PROJ knows; else that of x and y.
for system in 5703:5.000 9999:1.524; do
    python3 - "$FOLDER/keys.las" "$FOLDER/feet.las" ${system%:*} <<'END'
import struct, sys
data = bytearray(open(sys.argv[1], "rb").read())
keys = struct.pack("<4H", 4096, 0, 1, int(sys.argv[3]))
at = 227 + 54 + 24
struct.pack_into("<I", data, 96, struct.unpack_from("<I", data, 96)[0] + 8)
struct.pack_into("<H", data, 227 + 20, 32)
struct.pack_into("<H", data, 227 + 54 + 6, 3)
open(sys.argv[2], "wb").write(data[:at] + keys + data[at:])
END
    run "$STIPPLE" prep "$FOLDER/feet.las" --to EPSG:32610 -o "$FOLDER/m.stipple" --force
    expect_code 0
    points "$FOLDER/m.stipple" | awk '{ print $3 }' | sort -n | head -1 | awk -v z=${system#*:} '{ d = $1 - z } END { exit !(d < .01 && d > -.01) }' ||
        fail "heights of system $system: $(points "$FOLDER/m.stipple")"
done
printf '5 5 5\n6 6 6\n7 7 7\n' >"$FOLDER/beside.xyz"
printf '%s' "PROJCS[\"A plane\",$wgs84,PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"central_meridian\",9],UNIT[\"foot\",0.3048]]" \
    >"$FOLDER/beside.prj"
for input in 'keys.las:Oregon GIC Lambert (ft)' 'beside.xyz:A plane'; do
    run "$STIPPLE" prep "$FOLDER/${input%%:*}" -o "$FOLDER/told.stipple" --force --quiet
    expect_code 0
    run "$STIPPLE" export "$FOLDER/told.stipple" -o "$FOLDER/told.las" --force --quiet
    expect_code 0
    [[ $(tr -d '\0' <"$FOLDER/told.las") == *'PROJCS["'*"${input#*:}"* ]] || fail "$command: the file names no ${input#*:}"
    [ "${input%%:*}" != keys.las ] || python3 - "$FOLDER/told.las" <<'END' || fail "$command: the unit is not the foot"
import sys
text = open(sys.argv[1], "rb").read()
sys.exit(b'UNIT["foot",0.3048' not in text)
END
done

end_test
