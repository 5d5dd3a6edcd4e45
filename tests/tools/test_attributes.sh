#!/usr/bin/env bash
# Tests attributes: every field of every LAS record comes back through a model and export, in all point
# formats without waveforms; inputs with other fields join; pictures show an attribute as they show the
# same numbers as intensities; damage of any byte of the sections is found.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
command -v python3 >/dev/null || skip_test "python3 is not installed"
script=$FOLDER/las.py
cat >"$script" <<'END'
"""make F.las FORMAT EXTRA COUNT: points on a wavy ground with fields of any bits; same A.las B.las:
both have the same records, as multisets, whatever their headers say of the order; show F.las."""
import math, random, struct, sys

SIZE = {0: 20, 1: 28, 2: 26, 3: 34, 6: 30, 7: 36, 8: 38}
TYPES = {1: "B", 2: "b", 3: "H", 4: "h", 5: "I", 6: "i", 7: "Q", 8: "q", 9: "f", 10: "d"}

def number(r, kind):
    if kind in "fd":
        return r.choice([r.uniform(-1e6, 1e6), round(r.uniform(-99, 99), 3), 0.0, float("inf")])
    bits = 8 * struct.calcsize(kind)
    return r.randrange(1 << bits) - (1 << bits >> 1 if kind.islower() else 0)

def record(r, form, i, extra):
    x, y = i % 60 * 100 + r.randrange(40), i // 60 * 100 + r.randrange(40)
    z = int(300 * math.sin(x / 900) * math.cos(y / 700))
    out = struct.pack("<iii", x + 7, y - 5, z)
    level = r.randrange(256)
    out += struct.pack("<H", level * 257 if form == 6 else r.randrange(65536))
    if form >= 6:
        flags = r.randrange(256) & ~4  # not withheld
        out += struct.pack("<BBBBhH", r.randrange(256), flags, r.randrange(256),
                           level if form == 6 else r.randrange(256), r.randrange(-30000, 30000),
                           r.randrange(65536))
        out += struct.pack("<d", 245370.417706 + i * 1e-6 if i % 2 else r.uniform(0, 1e9))
        out += struct.pack("<HHH", *(r.randrange(65536) for _ in range(3))) if form >= 7 else b""
        out += struct.pack("<H", r.randrange(65536)) if form == 8 else b""
    else:
        out += struct.pack("<BBbBH", r.randrange(256), r.randrange(128), r.randrange(-90, 91),
                           r.randrange(256), r.randrange(65536))
        out += struct.pack("<d", r.uniform(0, 604800)) if form in (1, 3) else b""
        out += struct.pack("<HHH", *(r.randrange(256) for _ in range(3))) if form in (2, 3) else b""
    for kind in extra:
        value = number(r, TYPES[kind])
        out += struct.pack("<" + TYPES[kind], value)
    return out

def make(path, form, extra, count):
    r = random.Random(form * 100 + len(extra))
    kinds = [int(k) for k in extra.split(",") if k]
    vlr = b""
    if kinds:
        body = b"".join(struct.pack("<HBB32s156x", 0, k, 0, ("extra %d of type %d" % (i, k)).encode())
                        for i, k in enumerate(kinds))
        vlr = struct.pack("<H16sHH32s", 0, b"LASF_Spec", 4, len(body), b"") + body
    size = SIZE[form] + sum(struct.calcsize("<" + TYPES[k]) for k in kinds)
    head = bytearray(375)
    head[:4] = b"LASF"
    head[24:26] = bytes([1, 4])
    struct.pack_into("<HIIBHI", head, 94, 375, 375 + len(vlr), 1 if kinds else 0, form, size,
                     count if form < 6 else 0)
    struct.pack_into("<6d", head, 131, 0.01, 0.01, 0.001, 500000.0, 4000000.0, 100.0)
    struct.pack_into("<Q", head, 247, count)
    with open(path, "wb") as f:
        f.write(head + vlr + b"".join(record(r, form, i, kinds) for i in range(count)))

def load(path):
    data = open(path, "rb").read()
    begin, = struct.unpack_from("<I", data, 96)
    form, size, legacy = struct.unpack_from("<BHI", data, 104)
    count = struct.unpack_from("<Q", data, 247)[0] or legacy
    lattice = struct.unpack_from("<6d", data, 131)
    return form, size, lattice, sorted(data[begin + i * size:begin + (i + 1) * size] for i in range(count))

def show(path):
    """Some fields of format 8 with two extra bytes fields: a double, a byte."""
    form, size, _, records = load(path)
    for r in records:
        print(struct.unpack_from("<Q", r, 22)[0], r[17], *struct.unpack_from("<HHH", r, 30),
              struct.unpack_from("<H", r, 36)[0], struct.unpack_from("<H", r, 12)[0], r[15] >> 3 & 1,
              struct.unpack_from("<I", r, 38)[0], r[42])

if sys.argv[1] == "make":
    make(sys.argv[2], int(sys.argv[3]), sys.argv[4], int(sys.argv[5]))
elif sys.argv[1] == "show":
    show(sys.argv[2])
else:
    sys.exit(0 if load(sys.argv[2]) == load(sys.argv[3]) else 1)
END

expect_ok() {
    run "$STIPPLE" "$@"
    [ "$code" = 0 ] || fail "$command: $(head -1 "$FOLDER/err")"
}

# Every record comes back, from both codecs, as LAS and as LAZ, which our own reader unpacks.
for case in 0: 1:1,2,3,4 3:5,6,7,8,9,10 6: 8:9,1; do
    format=${case%%:*} extra=${case#*:}
    name=$FOLDER/f$format
    python3 "$script" make "$name.las" "$format" "$extra" 1500 || fail "no file of format $format"
    expect_ok prep "$name.las" -o "$name.stipple" --attributes all --precision exact --quiet
    expect_ok verify "$name.stipple" --quiet
    expect_ok convert "$name.stipple" -o "$name.z.stipple" --codec zstd --quiet
    expect_ok export "$name.z.stipple" -o "$name.back.las" --quiet
    python3 "$script" same "$name.las" "$name.back.las" || fail "format $format does not come back"
    expect_ok export "$name.stipple" -o "$name.laz" --quiet
    expect_ok prep "$name.laz" -o "$name.z.stipple" --attributes all --precision exact --quiet --force
    expect_ok export "$name.z.stipple" -o "$name.back.las" --quiet --force
    python3 "$script" same "$name.las" "$name.back.las" || fail "format $format does not come back from LAZ"
done

# A reader written from SPEC.md alone finds the numbers.
python3 "$SOURCE/tests/known/attributes.py" "$FOLDER/f8.stipple" gps_time user_data red green blue nir intensity \
    overlap "extra 0 of type 9" "extra 1 of type 1" | sort >"$FOLDER/told"
python3 "$script" show "$FOLDER/f8.las" | sort | cmp - "$FOLDER/told" || fail "attributes.py finds other numbers"

# The same bytes for any number of threads, and in little memory.
expect_ok prep "$FOLDER/f3.las" -o "$FOLDER/t.stipple" --attributes all --precision exact --threads 1 --memory 200M --quiet
cmp "$FOLDER/t.stipple" "$FOLDER/f3.stipple" || fail "other bytes by one thread and in little memory"

# Named attributes alone; others are left out. Wrong names get a sentence with the right ones.
expect_ok prep "$FOLDER/f8.las" -o "$FOLDER/n.stipple" --attributes gps_time,user_data --quiet
expect_ok info "$FOLDER/n.stipple" --json
python3 - "$FOLDER/out" <<'END' || fail "other attributes than asked for"
import json, sys
names = [a["name"] for a in json.load(open(sys.argv[1]))["extra_attributes"]]
sys.exit(sorted(names) != ["gps_time", "user_data"])
END
run "$STIPPLE" prep "$FOLDER/f8.las" -o "$FOLDER/x.stipple" --attributes gps_tim --quiet
[ "$code" = 1 ] && found gps_tim "$FOLDER/err" || fail "an unknown attribute: exit $code"
[ ! -e "$FOLDER/x.stipple" ] || fail "an unknown attribute leaves a file"
run "$STIPPLE" prep "$FOLDER/f8.las" -o "$FOLDER/x.stipple" --attributes all --format 1 --quiet
[ "$code" = 2 ] || fail "--format 1 with attributes: exit $code"
run "$STIPPLE" convert "$FOLDER/n.stipple" -o "$FOLDER/x.stipple" --format 1
[ "$code" = 1 ] && found drop-attributes "$FOLDER/err" || fail "attributes lost in version 1: exit $code"
expect_ok convert "$FOLDER/n.stipple" -o "$FOLDER/x.stipple" --format 1 --drop-attributes --quiet

# Inputs with other fields: what one lacks is missing there, and nothing else changes.
"$STIPPLE" gen sphere -n 2000 -o "$FOLDER/s.ply" --quiet || fail "no sphere"
expect_ok prep "$FOLDER/f0.las" "$FOLDER/f8.las" "$FOLDER/s.ply" -o "$FOLDER/m.stipple" --attributes all --quiet
expect_ok verify "$FOLDER/m.stipple" --quiet
expect_ok export "$FOLDER/m.stipple" -o "$FOLDER/m.ply" --quiet
python3 - "$FOLDER/m.ply" <<'END' || fail "missing numbers"
import math, struct, sys
data = open(sys.argv[1], "rb").read()
head, at = data[:data.index(b"end_header\n")].decode().split("\n"), data.index(b"end_header\n") + 11
kinds = {"float": "f", "double": "d", "uchar": "B", "ushort": "H", "short": "h", "int": "i", "uint": "I", "char": "b"}
names = [line.split()[2] for line in head if line.startswith("property")]
shape = struct.Struct("<" + "".join(kinds[line.split()[1]] for line in head if line.startswith("property")))
count = {"gps": 0, "nir": 0, "rank": 0, "user": 0}
for i in range(5000):
    row = dict(zip(names, shape.unpack_from(data, at + i * shape.size)))
    count["gps"] += math.isnan(row["gps_time"])
    count["nir"] += row["nir"] == (1 << 32) - 1
    count["rank"] += row["scan_angle_rank"] == 32767
    count["user"] += row["user_data"] == 65535
sys.exit(count != {"gps": 3500, "nir": 3500, "rank": 3500, "user": 2000})
END

# Types widen once, however many inputs come after the first that lacks something.
expect_ok prep "$FOLDER/s.ply" "$FOLDER/f0.las" "$FOLDER/f1.las" "$FOLDER/f3.las" -o "$FOLDER/w.stipple" \
    --attributes user_data --quiet
expect_ok info "$FOLDER/w.stipple" --json
found '"type":.*"u16"' "$FOLDER/out" || fail "another type: $(grep -A3 user_data "$FOLDER/out")"

# Conditions and boxes choose the same points, in the same order, as Python does among all of them.
expect_ok export "$FOLDER/m.stipple" -o "$FOLDER/some.ply" --quiet \
    --where '(user_data<100||gps_time>3e8)&&!(scan_angle_rank==32767&&x>500010)' --clip=-1,-1,0,600000,4000017,500
python3 - "$FOLDER/m.ply" "$FOLDER/some.ply" <<'END' || fail "not the points of the condition and the box"
import struct, sys
def load(path):
    data = open(path, "rb").read()
    at = data.index(b"end_header\n") + 11
    kinds = {"float": "f", "double": "d", "uchar": "B", "ushort": "H", "short": "h", "int": "i", "uint": "I", "char": "b"}
    fields = [line.split() for line in data[:at].decode().split("\n") if line.startswith("property")]
    shape = struct.Struct("<" + "".join(kinds[f[1]] for f in fields))
    return [f[2] for f in fields], list(shape.iter_unpack(data[at:]))
names, rows = load(sys.argv[1])
def taken(row):
    p = dict(zip(names, row))
    angle, user = p["scan_angle_rank"], p["user_data"]  # the greatest number: missing
    return ((user < 100 or p["gps_time"] > 3e8) and not (angle == 32767 and False) and
            -1 <= p["x"] <= 600000 and -1 <= p["y"] <= 4000017 and 0 <= p["z"] <= 500)
wanted = [row for row in rows if taken(row)]
sys.exit(not 100 < len(wanted) < len(rows) or repr(load(sys.argv[2])) != repr((names, wanted)))
END
expect_ok export "$FOLDER/f8.stipple" -o "$FOLDER/some.las" --where 'user<100 && red>=32768' --quiet
python3 "$script" show "$FOLDER/f8.las" | awk '$2 < 100 && $3 >= 32768' | sort >"$FOLDER/wanted"
python3 "$script" show "$FOLDER/some.las" | sort | cmp - "$FOLDER/wanted" || fail "not the records of the condition"
box=500000,4000000,0,500030,4000017,500
for ending in las laz; do
    expect_ok export "$FOLDER/f8.stipple" -o "$FOLDER/part.$ending" --where 'user<100' --clip=$box --quiet
done
expect_ok prep "$FOLDER/part.laz" -o "$FOLDER/part.stipple" --attributes all --precision exact --quiet
expect_ok export "$FOLDER/part.stipple" -o "$FOLDER/part.back.las" --quiet
python3 "$script" same "$FOLDER/part.las" "$FOLDER/part.back.las" || fail "LAZ of a part has other records"
run "$STIPPLE" export "$FOLDER/f8.stipple" -o "$FOLDER/none/f8.laz"
expect_failure "none"
run "$STIPPLE" export "$FOLDER/f8.stipple" -o "$FOLDER/part.laz"
expect_failure "exists"

# prep --where stores the records that export --where and awk choose, also by attributes that it does not keep, and
# counts the others; the bytes are the same for any number of threads and any memory.
condition='user<100 && red>=32768'
expect_ok prep "$FOLDER/f8.las" -o "$FOLDER/w8.stipple" --where "$condition" --attributes all --precision exact \
    --stats "$FOLDER/stats.json" --rejects "$FOLDER/rejects.csv" --quiet
expect_ok export "$FOLDER/w8.stipple" -o "$FOLDER/w8.las" --quiet
python3 "$script" show "$FOLDER/w8.las" | sort | cmp - "$FOLDER/wanted" || fail "prep --where stores other records"
expect_ok prep "$FOLDER/f8.las" -o "$FOLDER/w8.t.stipple" --where "$condition" --attributes all --precision exact \
    --threads 1 --memory 200M --quiet
cmp "$FOLDER/w8.stipple" "$FOLDER/w8.t.stipple" || fail "prep --where: other bytes by one thread and in little memory"
expect_ok prep "$FOLDER/f8.las" -o "$FOLDER/w8.n.stipple" --where "$condition" --stats "$FOLDER/none.json" --quiet
expect_ok info "$FOLDER/w8.n.stipple" --json
python3 - "$FOLDER"/{wanted,stats.json,none.json,out,rejects.csv} <<'END' || fail "prep --where: other counts"
import json, sys
count = sum(1 for _ in open(sys.argv[1]))
for path in sys.argv[2:4]:
    stats = json.load(open(path))
    if stats["points_out"] != count or stats["rejected"]["where"] != 1500 - count or stats["points_in"] != 1500:
        sys.exit("%s: %s" % (path, stats["rejected"]))
metadata = json.load(open(sys.argv[4]))["metadata"]
rejects = [line.split(",")[-1] for line in open(sys.argv[5])][1:]
sys.exit(metadata["rejected"]["where"] != 1500 - count or rejects != ["where\n"] * (1500 - count) or
         metadata["sources"][0]["where"] != "user<100 && red>=32768")
END
# Where an input lacks an attribute, its points fulfil no comparison; without a class they have class 0.
for condition in 'gps_time>3e8||user_data<100' '!(nir<1000)&&z>99' 'class!=7&&x<500020'; do
    expect_ok prep "$FOLDER/f0.las" "$FOLDER/f8.las" "$FOLDER/s.ply" -o "$FOLDER/wm.stipple" --attributes all \
        --where "$condition" --stats "$FOLDER/wm.json" --quiet --force
    expect_ok export "$FOLDER/m.stipple" -o "$FOLDER/wm.ply" --where "$condition" --quiet --force
    written=$(sed -n 's/^element vertex //p;/^end_header/q' "$FOLDER/wm.ply")
    found "\"points_out\":.*\b$written," "$FOLDER/wm.json" && [ "$written" -gt 100 ] && [ "$written" -lt 4900 ] ||
        fail "prep --where '$condition' stores other points than the $written of export"
done
for words in "--where user_dat=1" "--where height>0" "--where x>1e9" "--where scan>1"; do
    # shellcheck disable=SC2086
    run "$STIPPLE" prep "$FOLDER/f8.las" "$FOLDER/f3.las" -o "$FOLDER/no.stipple" $words
    expect_failure "$([ "$words" = "--where x>1e9" ] && echo "no valid point" || echo "--where")"
    [ ! -e "$FOLDER/no.stipple" ] || fail "$command: left a file"
done
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n' >"$FOLDER/line.obj"
run "$STIPPLE" prep "$FOLDER/line.obj" -o "$FOLDER/no.stipple" --where 'z>1'
expect_failure "among points alone"

expect_ok export "$FOLDER/f8.stipple" -o "$FOLDER/coarse.ply" --level 2 --quiet
[ "$(sed -n 's/^element vertex //p;/^end_header/q' "$FOLDER/coarse.ply")" -lt 750 ] || fail "level 2 is not coarser"
for words in "--where user_dat=1" "--where height>0" "--where x>1e9" "--clip 1,2" "--clip 0,0,0,1,1,1"; do
    # shellcheck disable=SC2086
    run "$STIPPLE" export "$FOLDER/f8.stipple" -o "$FOLDER/no.ply" $words
    expect_failure "--"
    [ ! -e "$FOLDER/no.ply" ] || fail "$command: left a file"
done

# Format 6's user data are its intensities over 257: both make the same picture of every sample.
if "$STIPPLE" render --help >"$FOLDER/help" 2>&1; then
    for colour in intensity:0,1 user_data:0,255; do
        expect_ok render "$FOLDER/f6.stipple" -o "$FOLDER/${colour%%:*}.png" --size 200x200 --threshold 0 \
            --palette viridis --colour "${colour%%:*}" --colour-range "${colour#*:}" --quiet
    done
    cmp "$FOLDER/intensity.png" "$FOLDER/user_data.png" || fail "an attribute is not shown as it is"
    expect_ok render "$FOLDER/f6.stipple" -o "$FOLDER/data.png" --size 200x200 --threshold 0 \
        --palette viridis --colour user --colour-range 0,255 --quiet
    cmp "$FOLDER/user_data.png" "$FOLDER/data.png" || fail "a part of a name is not the attribute"
    # The same for conditions: on an attribute, and on another that the samples have, too. What is drawn is what export
    # writes, also of a scan in place of a model.
    for condition in 'user<100' 'intensity<25700'; do
        expect_ok render "$FOLDER/f6.stipple" -o "$FOLDER/${condition%%<*}.w.png" --size 200x200 --threshold 0 \
            --view whole --cull none --lod geometry --where "$condition" --stats "$FOLDER/${condition%%<*}.json" --quiet
    done
    cmp "$FOLDER/user.w.png" "$FOLDER/intensity.w.png" || fail "the same condition draws another picture"
    expect_ok export "$FOLDER/f6.stipple" -o "$FOLDER/drawn.ply" --where 'user<100' --quiet
    drawn=$(sed -n 's/^element vertex //p;/^end_header/q' "$FOLDER/drawn.ply")
    [ "$drawn" -gt 300 ] && found "\"points_drawn\":.*\b$drawn," "$FOLDER/user.json" ||
        fail "render --where does not draw the $drawn points that export writes"
    expect_ok render "$FOLDER/f6.las" -o "$FOLDER/scan.png" --size 200x200 --threshold 0 --view whole --cull none \
        --lod geometry --where 'user<100' --no-cache --stats "$FOLDER/scan.json" --quiet
    found "\"points_drawn\":.*\b$drawn," "$FOLDER/scan.json" || fail "another part of the scan is drawn"
    for words in "--where user_dat=1" "--where height>0"; do
        # shellcheck disable=SC2086
        run "$STIPPLE" tune "$FOLDER/f8.stipple" -o "$FOLDER/no.png" $words
        expect_failure "--where"
        # shellcheck disable=SC2086
        run "$STIPPLE" render "$FOLDER/f8.stipple" -o "$FOLDER/no.png" $words
        expect_failure "--where"
        [ ! -e "$FOLDER/no.png" ] || fail "$command: left a file"
    done
    run "$STIPPLE" render "$FOLDER/f6.stipple" -o "$FOLDER/x.png" --colour nir
    [ "$code" = 1 ] && found user_data "$FOLDER/err" || fail "an attribute that is not there: exit $code"
fi

# A flipped bit in either section is found.
python3 - "$FOLDER/n.stipple" <<'END' || fail "no two sections of attributes"
import struct, sys
data, files = open(sys.argv[1], "rb").read(), 0
for i in range(struct.unpack_from("<I", data, 160)[0]):
    kind, _, begin, size = struct.unpack_from("<4sIQQ", data, 168 + 32 * i)
    for k in range(6 if kind in (b"ATTR", b"ATTD") else 0):
        flipped = bytearray(data)
        flipped[begin + k * size // 6] ^= 1 << k
        open("%s.%d" % (sys.argv[1], files), "wb").write(flipped)
        files += 1
sys.exit(files != 12)
END
for flipped in "$FOLDER"/n.stipple.*; do
    run "$STIPPLE" verify "$flipped" --quiet
    [ "$code" = 1 ] || fail "a flipped bit: exit $code"
done
# Without both copies of the header, a repair finds the sections and loses nothing; if it cannot keep the
# attributes, it says so.
python3 - "$FOLDER/n.stipple" "$FOLDER/lost.stipple" "$FOLDER/worse.stipple" <<'END'
import struct, sys
data = bytearray(open(sys.argv[1], "rb").read())
begin, = struct.unpack_from("<Q", data, 168 + 8)
data[8:16] = data[1032:1040] = bytes(8)
open(sys.argv[2], "wb").write(data)
data[begin + 100:begin + 200] = bytes(100)
open(sys.argv[3], "wb").write(data)
END
expect_ok verify "$FOLDER/lost.stipple" --repair -o "$FOLDER/found.stipple" --quiet
cmp "$FOLDER/found.stipple" "$FOLDER/n.stipple" || fail "a lost header is not found again"
run "$STIPPLE" verify "$FOLDER/worse.stipple" --repair -o "$FOLDER/found.stipple" --force
[ "$code" = 1 ] && found "attributes are lost" "$FOLDER/err" || fail "attributes are lost without a word: exit $code"
expect_ok verify "$FOLDER/found.stipple" --quiet
end_test
