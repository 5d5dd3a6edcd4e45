#!/usr/bin/env bash
# Tests `prep --grid`: scans of a room by a scanner in a pose (PTX) and by a camera turned in space (PCD) keep their
# rows and columns, take less space than points do, and lie on the room's walls; any other input says in a sentence
# why its rows and columns are not kept, and becomes points.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# Walls at x = -4 and 4, y = -3 and 3, z = -1 and 2, seen from (0.5, -0.4, 0.3). The scanner's axes and the camera's are
# turned by 0.7 about (2, 1, 2) / 3. rough: angles are off by so many steps.
room() { # kind, columns, rows [rough]
    awk -v kind="$1" -v columns="$2" -v rows="$3" -v rough="${4:-0}" '
    function hit(p, d, low, high) { return d > 0 ? (high - p) / d : d < 0 ? (low - p) / d : 1e9 }
    function least(a, b) { return a < b ? a : b }
    BEGIN {
        sx = 0.5; sy = -0.4; sz = 0.3; ax = az = 2 / 3; ay = 1 / 3; co = cos(0.7); si = sin(0.7)
        for (i = 0; i < 3; i++) {
            x = i == 0; y = i == 1; z = i == 2; along = (ax * x + ay * y + az * z) * (1 - co)
            m[i, 0] = x * co + (ay * z - az * y) * si + ax * along
            m[i, 1] = y * co + (az * x - ax * z) * si + ay * along
            m[i, 2] = z * co + (ax * y - ay * x) * si + az * along
        }
        if (kind == "ptx") {
            printf "%d\n%d\n%s %s %s\n", columns, rows, sx, sy, sz
            for (i = 0; i < 3; i++) printf "%.9f %.9f %.9f\n", m[i, 0], m[i, 1], m[i, 2]
            for (i = 0; i < 3; i++) printf "%.9f %.9f %.9f 0\n", m[i, 0], m[i, 1], m[i, 2]
            printf "%s %s %s 1\n", sx, sy, sz
        } else {
            printf "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT %d\n", columns, rows
            printf "VIEWPOINT %s %s %s 1 0 0 0\nPOINTS %d\nDATA ascii\n", sx, sy, sz, columns * rows
        }
        for (k = 0; k < columns * rows; k++) {
            if (kind == "ptx") { # column by column
                i = int(k / rows) + rough * ((k * 7919 % 101) / 50 - 1); j = k % rows
                a = i * 0.005; e = j * 0.005 - 0.3
                u = cos(a) * cos(e); v = sin(a) * cos(e); w = sin(e)
            } else {
                u = (k % columns - columns / 2) / 200; v = (int(k / columns) - rows / 2) / 200; w = 1
            }
            dx = u * m[0, 0] + v * m[1, 0] + w * m[2, 0]
            dy = u * m[0, 1] + v * m[1, 1] + w * m[2, 1]
            dz = u * m[0, 2] + v * m[1, 2] + w * m[2, 2]
            t = least(least(hit(sx, dx, -4, 4), hit(sy, dy, -3, 3)), hit(sz, dz, -1, 2))
            if (kind == "ptx" && k % 97 == 0) print "0 0 0 0.5"
            else if (kind == "ptx") printf "%.6f %.6f %.6f 0.5\n", t * u, t * v, t * w
            else printf "%.6f %.6f %.6f\n", sx + t * dx, sy + t * dy, sz + t * dz
        }
    }'
}

without() { # a text that is not in err
    ! grep -qF "$1" "$FOLDER/err" || fail "$command: says: $1"
}

model() { # name, arguments...
    local name=$1
    shift
    run "$STIPPLE" prep "$@" -o "$FOLDER/$name.stipple" --force
    expect_code 0
}

size() { wc -c <"$FOLDER/$1.stipple"; }

count() { # name, condition...
    local name=$1
    shift
    rm -f "$FOLDER/out.ply"
    run "$STIPPLE" export "$FOLDER/$name.stipple" -o "$FOLDER/out.ply" --quiet "$@"
    if [ "$code" = 0 ]; then sed -n 's/^element vertex //p;/^end_header/q' "$FOLDER/out.ply"; else cat "$FOLDER/err"; fi
}

on_walls() { # name, points
    "$STIPPLE" verify "$FOLDER/$1.stipple" --quiet 2>"$FOLDER/err" || fail "$1 is not sound"
    [ "$(count "$1")" = "$2" ] || fail "$1 has $(count "$1") points, expected $2"
    local inside='x > -3.998 && x < 3.998 && y > -2.998 && y < 2.998 && z > -0.998 && z < 1.998'
    local outside='x < -4.002 || x > 4.002 || y < -3.002 || y > 3.002 || z < -1.002 || z > 2.002'
    [[ $(count "$1" --where "($inside) || $outside") == *"no point is chosen"* ]] || fail "$1: points are off the walls"
}

room ptx 260 130 >"$FOLDER/scan.ptx"
room pcd 240 160 >"$FOLDER/turned.pcd"
room ptx 100 80 0.9 >"$FOLDER/rough.ptx"
cat "$FOLDER/rough.ptx" "$FOLDER/rough.ptx" >"$FOLDER/two.ptx"

model points "$FOLDER/scan.ptx"
without "rows and columns"
model scan "$FOLDER/scan.ptx" --grid
without "rows and columns"
on_walls scan $((260 * 130 - (260 * 130 - 1) / 97 - 1))
[ "$(size scan)" -lt $(($(size points) * 9 / 10)) ] || fail "rows and columns save less than a tenth: $(size scan) of $(size points) bytes"

model turned "$FOLDER/turned.pcd" --grid
without "rows and columns"
on_walls turned $((240 * 160))
[ "$(size turned)" -lt $((240 * 160 * 5 / 2)) ] || fail "the turned camera's image takes $(size turned) bytes"

# Several scans in one file.
room ptx 200 90 >"$FOLDER/other.ptx"
cat "$FOLDER/scan.ptx" "$FOLDER/other.ptx" >"$FOLDER/both.ptx"
model points "$FOLDER/both.ptx"
model both "$FOLDER/both.ptx" --grid
without "rows and columns"
on_walls both $((260 * 130 - (260 * 130 - 1) / 97 - 1 + 200 * 90 - (200 * 90 - 1) / 97 - 1))
[ "$(size both)" -lt $(($(size points) * 9 / 10)) ] || fail "rows and columns of two scans save less than a tenth: $(size both) of $(size points) bytes"

# Sentences.
model rough "$FOLDER/rough.ptx" --grid
expect_text err "rough.ptx: rows and columns are not kept: many points lie more than a quarter of a pixel off its rays"
model two "$FOLDER/two.ptx" --grid
expect_text err "two.ptx: rows and columns are not kept: many points lie more than a quarter of a pixel off its rays"
printf '%s\n' "0 0 0" "1 0 0" "0 1 0" >"$FOLDER/loose.xyz"
model loose "$FOLDER/loose.xyz" --grid
expect_text err "loose.xyz: rows and columns are not kept: none are read from it"
model loose "$FOLDER/loose.xyz"
without "rows and columns"
printf 'ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 7\n' >"$FOLDER/a.asc"
printf 'ncols 3\nnrows 2\nxllcorner 0.5\nyllcorner 9\ncellsize 1\n1 2 3\n4 5 7\n' >"$FOLDER/b.asc"
run "$STIPPLE" prep "$FOLDER/a.asc" --height-scale 0 -o "$FOLDER/flat.stipple"
expect_code 1
expect_text err "--height-scale 0: give a number other than 0"
model heights "$FOLDER/a.asc" --grid
without "rows and columns"
model heights "$FOLDER/a.asc" --outliers mark
expect_text err "a.asc: rows and columns are not kept: --outliers looks at points"
model heights "$FOLDER/a.asc" --recompute-normals
expect_text err "a.asc: rows and columns are not kept: --recompute-normals asks points for them"
model heights "$FOLDER/a.asc" "$FOLDER/b.asc"
expect_text err "rows and columns are not kept: those of the inputs do not go on from one to the other"
model heights "$FOLDER/a.asc" "$FOLDER/loose.xyz"
expect_text err "rows and columns are not kept: other inputs are no grids of heights"
end_test
