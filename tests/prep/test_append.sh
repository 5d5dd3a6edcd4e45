#!/usr/bin/env bash
# Tests prep --append: what stays, what grows, what is refused, and that the model is whole at every moment.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
command -v python3 >/dev/null || skip_test "no python3"
model="$FOLDER/m.stipple" old="$FOLDER/old.stipple" grown="$FOLDER/grown.stipple"
size_of() { stat -c %s "$1"; }
points_of() { "$STIPPLE" info "$1" | sed -n 's/^points *//p'; }
expect_sound() { # file, what
    "$STIPPLE" verify "$1" --quiet || fail "$2: not sound"
}
expect_points() { # file, number, what
    [ "$(points_of "$1")" = "$2" ] || fail "$3: $(points_of "$1") points, expected $2"
}
append() { # file, arguments
    run "$STIPPLE" prep --append -o "$1" --threads 2 "${@:2}"
}

# Writes the points of a scan of `gen` whose x, y and z are above a limit, moved along x.
take_corner() { # from, to, limit, way
    python3 - "$@" <<'END'
import struct
import sys
data = open(sys.argv[1], "rb").read()
at = data.index(b"end_header\n") + 11
rows = [r for r in struct.iter_unpack("<3f3B", data[at:]) if min(r[:3]) > float(sys.argv[3])]
head = data[:at].replace(b"vertex %d" % ((len(data) - at) // 15), b"vertex %d" % len(rows))
way = float(sys.argv[4])
open(sys.argv[2], "wb").write(head + b"".join(struct.pack("<3f3B", r[0] + way, *r[1:]) for r in rows))
print(len(rows))
END
}

# Whether every point that one file of points has is in the other, too, with all its properties.
has_all() { # few, all
    python3 - "$@" <<'END'
import collections
import sys

def rows(path):
    data = open(path, "rb").read()
    at = data.index(b"end_header\n") + 11
    sizes = {"double": 8, "float": 4, "uchar": 1, "ushort": 2, "uint": 4}
    size = sum(sizes[l.split()[1]] for l in data[:at].decode().split("\n") if l.startswith("property"))
    return collections.Counter(data[i:i + size] for i in range(at, len(data), size))

missing = rows(sys.argv[1]) - rows(sys.argv[2])
sys.exit(f"{sum(missing.values())} points are not there" if missing else 0)
END
}

"$STIPPLE" gen sphere -n 80000 -o "$FOLDER/scan.ply" --quiet || fail "no scan"
"$STIPPLE" gen sphere -n 80000 --seed 1 -o "$FOLDER/other.ply" --quiet || fail "no other scan"
count=$(take_corner "$FOLDER/other.ply" "$FOLDER/more.ply" 0.5 0)
"$STIPPLE" prep "$FOLDER/scan.ply" -o "$old" --quiet || fail "no model"

# ---- what stays and what grows ----
cp "$old" "$grown"
append "$grown" "$FOLDER/more.ply"
expect_code 0
expect_empty out
expect_text err "the model had 80000 points and has $((80000 + count))"
expect_text err "proven closed"
expect_sound "$grown" "after an append"
expect_points "$grown" $((80000 + count)) "after an append"
touched=$(sed -n 's/.*; \([0-9]*\) of \([0-9]*\) leaves were touched$/\1 \2/p' "$FOLDER/err")
[ "${touched% *}" -lt "${touched#* }" ] || fail "all leaves were touched: $touched"
cmp -s <(tail -c +2049 "$old") <(head -c "$(size_of "$old")" "$grown" | tail -c +2049) ||
    fail "an append changed bytes of the model besides the header"
cmp -s <(head -c 1024 "$grown") <(head -c 2048 "$grown" | tail -c 1024) || fail "the headers differ"
run "$STIPPLE" info "$grown"
expect_text out "version        2.1"
expect_text out "unused  "
for file in old grown; do
    "$STIPPLE" export "$FOLDER/$file.stipple" -o "$FOLDER/$file.ply" --quiet || fail "no export"
done
has_all "$FOLDER/old.ply" "$FOLDER/grown.ply" || fail "an append changed points of the model"
python3 "$SOURCE/tests/known/read.py" "$grown" >"$FOLDER/read" || fail "the reader by the page fails"
[ "$(head -1 "$FOLDER/read" | grep -c "^version 2.1 ")" = 1 ] || fail "the reader: $(head -1 "$FOLDER/read")"
cp "$old" "$model"
run "$STIPPLE" prep --append "$FOLDER/more.ply" -o "$model" --threads 1 --memory 150M
cmp -s "$model" "$grown" || fail "another number of threads, or less memory, gives other bytes"

# Compacted, nothing is unused.
run "$STIPPLE" convert "$grown" -o "$FOLDER/compact.stipple"
expect_code 0
expect_sound "$FOLDER/compact.stipple" "compacted"
run "$STIPPLE" info "$FOLDER/compact.stipple"
expect_text out "version        2.0"
[ "$(size_of "$FOLDER/compact.stipple")" -lt "$(size_of "$grown")" ] || fail "convert saved nothing"

# Like the model of both scans at once.
"$STIPPLE" prep "$FOLDER/scan.ply" "$FOLDER/more.ply" -o "$FOLDER/both.stipple" --quiet
expect_points "$FOLDER/both.stipple" $((80000 + count)) "both at once"

# A list of unused bytes that is wrong, with right checksums. The change: of the first range, or of the section's size.
spoil() { # offset by, bytes by, size by
    python3 - "$SOURCE/tests/known" "$grown" "$FOLDER/spoilt" "$@" <<'END'
import struct
import sys
sys.path.insert(0, sys.argv[1])
sys.dont_write_bytecode = True
from xxh3 import xxh3
data = bytearray(open(sys.argv[2], "rb").read())
header = data[:1024]
place = next(at for at in range(168, 168 + 32 * header[160], 32) if header[at:at + 4] == b"FREE")
begin, size = struct.unpack_from("<QQ", header, place + 8)
by = [int(word) for word in sys.argv[4:]]
first = struct.unpack_from("<QQ", data, begin)
struct.pack_into("<QQ", data, begin, first[0] + by[0], first[1] + by[1])
struct.pack_into("<QQ", header, place + 16, size + by[2], xxh3(bytes(data[begin:begin + size + by[2]])))
struct.pack_into("<Q", header, 1016, xxh3(bytes(header[:1016])))
data[:2048] = header + header
open(sys.argv[3], "wb").write(data)
END
    run "$STIPPLE" verify "$FOLDER/spoilt" --quiet
}
spoil 0 0 0
expect_code 0
spoil 0 -1 0
expect_failure "its payload begins at byte"
spoil 1 -1 0
expect_failure "unused bytes begin at byte"
spoil -100 100 0
expect_failure "unused bytes begin at byte"
spoil 0 1000000000000 0
expect_failure "out of order or not among the payloads"
spoil 0 0 -8
expect_failure "part of a record"

# ---- once more ----
append "$model" "$FOLDER/more.ply" --quiet
expect_code 0
expect_sound "$model" "equal points again"
expect_points "$model" $((80000 + 2 * count)) "equal points again"
"$STIPPLE" export "$model" -o "$FOLDER/twice.ply" --quiet || fail "no export"
has_all "$FOLDER/grown.ply" "$FOLDER/twice.ply" || fail "a second append changed points"

take_corner "$FOLDER/other.ply" "$FOLDER/far.ply" 0.5 40 >/dev/null
append "$model" "$FOLDER/far.ply" --quiet
expect_code 0
expect_sound "$model" "points far away"
expect_points "$model" $((80000 + 3 * count)) "points far away"

# A model of one leaf grows to several.
"$STIPPLE" prep "$FOLDER/more.ply" -o "$FOLDER/one.stipple" --quiet
append "$FOLDER/one.stipple" "$FOLDER/scan.ply" --quiet
expect_code 0
expect_sound "$FOLDER/one.stipple" "one leaf"
expect_points "$FOLDER/one.stipple" $((80000 + count)) "one leaf"

# Points far from a model of one leaf, which touch no leaf.
"$STIPPLE" prep "$FOLDER/more.ply" -o "$FOLDER/one.stipple" --quiet --force
append "$FOLDER/one.stipple" "$FOLDER/far.ply" --quiet
expect_code 0
expect_sound "$FOLDER/one.stipple" "far from one leaf"
expect_points "$FOLDER/one.stipple" $((2 * count)) "far from one leaf"
"$STIPPLE" prep "$FOLDER/more.ply" -o "$FOLDER/few.stipple" --quiet
for file in few one; do
    "$STIPPLE" export "$FOLDER/$file.stipple" -o "$FOLDER/$file.ply" --quiet || fail "no export"
done
has_all "$FOLDER/few.ply" "$FOLDER/one.ply" || fail "points far from one leaf changed its points"

# Points that are sparser than the model become full leaves, not one for each width of its leaves: that
# would be 2300 here.
awk 'BEGIN { for (i = 0; i < 10000; i++) print 20 + i % 100, int(i / 100), sin(i / 900) }' >"$FOLDER/sparse.xyz"
cp "$old" "$model"
append "$model" "$FOLDER/sparse.xyz"
expect_code 0
grep -Eq '^[0-9]+ chunks stay, [1-9] are new' "$FOLDER/err" || fail "sparse points: $(grep stay, "$FOLDER/err")"
expect_sound "$model" "sparse points"

# ---- what is refused leaves the model as it was ----
refused() { # text, arguments
    cp "$old" "$model"
    append "$model" "${@:2}" --quiet
    expect_failure "$1"
    cmp -s "$old" "$model" || fail "$command: changed the model"
}
sed 's/^element vertex .*/element vertex 0/' "$FOLDER/more.ply" | head -c 200 >"$FOLDER/none.ply"
refused "nothing to write" "$FOLDER/none.ply"
head -c 2000 "$FOLDER/more.ply" >"$FOLDER/short.ply"
refused "short.ply" "$FOLDER/short.ply"
refused "is also an input" "$model"
cp "$old" "$model"
append "$model" "$FOLDER/more.ply" "$FOLDER/short.ply" --quiet
expect_code 1
expect_text err "1 of 2 inputs could not be read, as said above: $model has the points of the others"
expect_points "$model" $((80000 + count)) "with an input that cannot be read"
append "$model" "$FOLDER/more.ply" --codec zstd
expect_usage "--append"
append "$model" "$FOLDER/more.ply" --maps
expect_usage "--append"
"$STIPPLE" prep "$FOLDER/scan.ply" -o "$FOLDER/maps.stipple" --maps --quiet || fail "no maps"
run "$STIPPLE" prep --append "$FOLDER/more.ply" -o "$FOLDER/maps.stipple"
expect_failure "it was resampled"
"$STIPPLE" gen tree -n 500 -o "$FOLDER/leaves.ply" --mesh "$FOLDER/tree.ply" --quiet
printf 'v 0 0 0\nv 1 0 0\nl 1 2\n' >"$FOLDER/line.obj"
refused "lines or triangles" "$FOLDER/line.obj"
append "$FOLDER/missing.stipple" "$FOLDER/more.ply" --quiet
expect_failure "missing.stipple"
append "$model" "$FOLDER/more.ply" --outliers drop
expect_usage "--append"
for form in "version 1:--format 1" "attributes:--attributes all" "lines or triangles:--lines auto"; do
    scan="$FOLDER/more.ply"
    [ "${form#*:}" = "--lines auto" ] && scan="$FOLDER/tree.ply"
    [ "${form#*:}" = "--attributes all" ] && scan="$FOLDER/more.las" &&
        "$STIPPLE" export "$old" -o "$scan" --level 2 --quiet
    # shellcheck disable=SC2086
    "$STIPPLE" prep "$scan" -o "$FOLDER/form.stipple" --quiet --force ${form#*:}
    append "$FOLDER/form.stipple" "$FOLDER/more.ply" --quiet
    expect_failure "${form%%:*}"
done
cp "$old" "$model"
chmod a-w "$model"
append "$model" "$FOLDER/more.ply" --quiet
expect_failure "write"
chmod u+w "$model"
(
    failures=0
    flock 9
    append "$model" "$FOLDER/more.ply" --quiet
    expect_failure "another run is changing this file"
    exit $failures
) 9<"$model" || fail "a locked model"
cmp -s "$old" "$model" || fail "a model that cannot be written is changed"

# ---- a full disk ----
full() {
    cp "$old" "$FOLDER/disk/m.stipple" && append "$FOLDER/disk/m.stipple" "$FOLDER/more.ply" --quiet --temp "$FOLDER"
    expect_failure "the disk is full"
    cmp -s "$old" "$FOLDER/disk/m.stipple" || fail "a full disk changed the model"
}
if mkdir "$FOLDER/disk" && mount -t tmpfs -o size=$(($(size_of "$old") + 65536)) none "$FOLDER/disk" 2>/dev/null; then
    full
    umount "$FOLDER/disk"
fi

# ---- every state that a crash can leave ----
state() { # name, expected points, header at 0, header at 1024, file of the rest
    cat <(head -c 1024 "$3") <(head -c 2048 "$4" | tail -c 1024) <(tail -c +2049 "$5") >"$FOLDER/state"
    expect_points "$FOLDER/state" "$2" "$1"
    "$STIPPLE" export "$FOLDER/state" -o "$FOLDER/state.ply" --force --quiet || fail "$1: no export"
}
after=$((80000 + count))
head -c $(($(size_of "$old") + 5000)) "$grown" >"$FOLDER/part"
state "before the end is written" 80000 "$old" "$old" "$FOLDER/part"
state "before a header is written" 80000 "$old" "$old" "$grown"
state "one header written" $after "$old" "$grown" "$grown"
expect_sound "$FOLDER/state" "one header written"
state "the other header written" $after "$grown" "$old" "$grown"
cat <(head -c 1300 "$old") <(head -c 2048 "$grown" | tail -c 748) >"$FOLDER/torn"
state "half a header" 80000 "$old" "$FOLDER/torn" "$grown"
cp "$FOLDER/state" "$model"
append "$model" "$FOLDER/more.ply" --quiet
expect_code 0
expect_sound "$model" "an append after a crash"
expect_points "$model" $after "an append after a crash"

# ---- a grid of heights, whose holes stay open, is none with points from elsewhere ----
is_grid() { "$STIPPLE" info "$1" --json | grep -q '"grid":[[:space:]]*true'; }
awk 'BEGIN { print "P2\n40 30\n255"; for (i = 0; i < 1200; i++) print 40 + 7 * i % 13 }' >"$FOLDER/heights.pgm"
"$STIPPLE" prep "$FOLDER/heights.pgm" -o "$model" --quiet --force || fail "no grid"
is_grid "$model" || fail "a grid is not called one"
append "$model" "$FOLDER/more.ply"
expect_code 0
! is_grid "$model" || fail "a grid with other points is called one"

# ---- kills ----
kills=20
is_long && kills=200
began=$(date +%s%N)
cp "$old" "$model"
append "$model" "$FOLDER/more.ply" --quiet
took=$((($(date +%s%N) - began) / 1000000))
killed=0
for i in $(seq $kills); do
    cp "$old" "$model"
    "$STIPPLE" prep --append "$FOLDER/more.ply" -o "$model" --threads 2 --quiet &
    child=$!
    milliseconds=$((took * (i + 1) / kills))
    sleep "$((milliseconds / 1000)).$(printf %03d $((milliseconds % 1000)))"
    kill -KILL $child 2>/dev/null && killed=$((killed + 1))
    wait $child 2>/dev/null
    left=$(points_of "$model")
    [ "$left" = 80000 ] || [ "$left" = $after ] || fail "kill $i: $left points"
    [ "$left" != 80000 ] || cmp -s <(tail -c +2049 "$old") <(head -c "$(size_of "$old")" "$model" | tail -c +2049) ||
        fail "kill $i: the old model is changed"
    [ "$left" = 80000 ] || expect_sound "$model" "kill $i"
done
[ $killed -ge $((kills / 3)) ] || fail "only $killed of $kills runs were killed"
[ -z "$(find "$FOLDER" -name '*.part')" ] || fail "kills left files"
end_test
