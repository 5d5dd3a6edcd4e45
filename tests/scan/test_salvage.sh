#!/usr/bin/env bash
# Tests prep --salvage: of a file that is cut anywhere, all whole records are stored, and all others that
# it declares are counted as lost. A whole file gives the same model with it and without. Without it, a
# cut file is refused.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
stats=$FOLDER/stats.json

count() { # key
    sed -n "s/.*\"$1\":[[:space:]]*\([0-9]*\).*/\1/p" "$stats" | head -1
}

# The model of a file that is cut to so many bytes has this many points, and the rest of all are lost.
expect_salvaged() { # file, bytes, points, all
    local cut=$FOLDER/cut.${1##*.} stored
    head -c "$2" "$FOLDER/$1" >"$cut"
    run "$STIPPLE" prep "$cut" -o "$FOLDER/cut.stipple" --quiet --force
    expect_failure "cut."
    run "$STIPPLE" prep "$cut" -o "$FOLDER/cut.stipple" --quiet --force --salvage --stats "$stats" --attributes all
    [ "$code" = 0 ] || { fail "$1 cut to $2 bytes: $(cat "$FOLDER/err")"; return; }
    stored=$(count points_out)
    [ "$(count points_in)" = "$4" ] && [ "$(count lost)" = $(($4 - stored)) ] ||
        fail "$1 cut to $2 bytes: of $(count points_in) points $stored are stored, $(count lost) lost"
    [ "$stored" = "$3" ] || fail "$1 cut to $2 bytes: $stored points are stored, expected $3"
    run "$STIPPLE" verify "$FOLDER/cut.stipple" --quiet
    expect_code 0
}

"$STIPPLE" gen bumpy -n 3000 -o "$FOLDER/a.ply" --quiet && "$STIPPLE" gen bumpy -n 3000 -o "$FOLDER/a.las" --quiet &&
    "$STIPPLE" gen bumpy -n 90000 -o "$FOLDER/a.laz" --quiet || fail "no scans"
head=$(grep -abo end_header "$FOLDER/a.ply" | cut -d: -f1)
begin=$((head + 11))
bytes=$((($(wc -c <"$FOLDER/a.ply") - begin) / 3000))
expect_salvaged a.ply $((begin + 1234 * bytes)) 1234 3000
expect_salvaged a.ply $((begin + 1234 * bytes + bytes - 1)) 1234 3000
begin=$(od -An -tu4 -j96 -N4 "$FOLDER/a.las" | tr -d ' ')
bytes=$(od -An -tu2 -j105 -N2 "$FOLDER/a.las" | tr -d ' ')
expect_salvaged a.las $((begin + 2999 * bytes + 1)) 2999 3000
expect_salvaged a.las $((begin + 7 * bytes)) 7 3000
# A header that counts otherwise than its file loses nothing without a word.
cp "$FOLDER/a.las" "$FOLDER/counts.las"
printf '\005' | dd of="$FOLDER/counts.las" bs=1 seek=107 conv=notrunc status=none
run "$STIPPLE" prep "$FOLDER/counts.las" -o "$FOLDER/counts.stipple"
expect_text err "the legacy one 5: 3000 were read"
# Of layered LAZ, whole chunks of 50,000 points.
expect_salvaged a.laz $(($(wc -c <"$FOLDER/a.laz") * 3 / 4)) 50000 90000
python3 - "$FOLDER" <<'END' || skip_test "python3 is not installed"
import struct, sys
folder = sys.argv[1]
rows = [(i % 60, i // 60, (i * 7 % 11) / 10) for i in range(3000)]
head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 3000\nHEIGHT 1\nPOINTS 3000\nDATA "
open(folder + "/a.pcd", "wb").write((head + "binary\n").encode() + b"".join(struct.pack("<3f", *r) for r in rows))
open(folder + "/t.pcd", "w").write(head + "ascii\n" + "".join("%d %d %.1f\n" % r for r in rows))
END
begin=$(($(grep -abo 'DATA binary' "$FOLDER/a.pcd" | cut -d: -f1) + 12))
expect_salvaged a.pcd $((begin + 12 * 2000 + 5)) 2000 3000
line=$(grep -n '^0 40 ' "$FOLDER/t.pcd" | cut -d: -f1) # the 2401st point
expect_salvaged t.pcd $(($(head -$((line - 1)) "$FOLDER/t.pcd" | wc -c) + 3)) 2400 3000

for file in a.ply a.las a.pcd t.pcd; do
    run "$STIPPLE" prep "$FOLDER/$file" -o "$FOLDER/whole.stipple" --quiet --force
    expect_code 0
    run "$STIPPLE" prep "$FOLDER/$file" -o "$FOLDER/same.stipple" --quiet --force --salvage
    expect_code 0
    cmp "$FOLDER/whole.stipple" "$FOLDER/same.stipple" || fail "$file: --salvage changes a whole file"
done

# Points whose faces are cut off are stored without them, with their attributes.
{
    printf 'ply\nformat ascii 1.0\nelement vertex 400\nproperty float x\nproperty float y\nproperty float z\n'
    printf 'property float rank\nelement face 400\nproperty list uchar int vertex_indices\nend_header\n'
    awk 'BEGIN { for (i = 0; i < 400; i++) print i % 20, int(i / 20), i % 3, i; for (i = 0; i < 99; i++) print 3, i, i + 1, i + 20 }'
} >"$FOLDER/faces.ply"
run "$STIPPLE" prep "$FOLDER/faces.ply" -o "$FOLDER/faces.stipple" --quiet
expect_failure "faces.ply"
run "$STIPPLE" prep "$FOLDER/faces.ply" -o "$FOLDER/faces.stipple" --quiet --salvage --attributes all --stats "$stats" --force
expect_code 0
[ "$(count points_out)" = 400 ] || fail "$command: $(count points_out) points are stored"
run "$STIPPLE" info "$FOLDER/faces.stipple"
expect_text out rank
end_test
