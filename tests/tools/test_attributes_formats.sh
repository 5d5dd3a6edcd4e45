#!/usr/bin/env bash
# Tests attributes of PCD and text from end to end: what Python put into the files comes back through a model and
# export, point by point; inputs of both kinds join.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
command -v python3 >/dev/null || skip_test "python3 is not installed"
script=$FOLDER/scans.py
cat >"$script" <<'END_OF_PYTHON'
"""make FOLDER: a.csv, b.pcd, c.pcd of known points; check EXPORT.ply FILES: it has their points and numbers."""
import math, random, struct, sys

def points(name):
    """x, y, z and attributes by name; None: missing. Positions are unlike in all files."""
    r = random.Random(name)
    shift = {"a.csv": 0, "b.pcd": 100, "c.pcd": 200}[name]
    for i in range(2000):
        at = (i % 50 + shift, i // 50, round(math.sin(i % 50 / 9) + math.cos(i // 50 / 7), 3))
        if name == "a.csv":
            yield at, {"gps_time": None if i % 9 == 4 else 245370.417706 + i * 1e-6,
                       "return": r.randrange(1, 6), "id": r.randrange(1 << 53)}
        else:
            yield at, {"ring": r.randrange(1 << 16), "return": r.randrange(256),
                       "curve_0": r.randrange(-99, 99) / 4, "curve_1": float(i), "tick": r.randrange(-1 << 31, 1 << 31)}

def text(value):
    return "" if value is None else repr(value)

def pcd(name, binary):
    rows = list(points(name))
    head = ("VERSION 0.7\nFIELDS x y z ring return curve tick\nSIZE 8 8 8 2 1 4 4\nTYPE F F F U U F I\n"
            "COUNT 1 1 1 1 1 2 1\nWIDTH %d\nHEIGHT 1\nDATA %s\n" % (len(rows), "binary" if binary else "ascii"))
    out = head.encode()
    for at, v in rows:
        values = at + tuple(v[n] for n in ("ring", "return", "curve_0", "curve_1", "tick"))
        out += struct.pack("<dddHBffi", *values) if binary else (" ".join(map(repr, values)) + "\n").encode()
    return out

def make(folder):
    with open(folder + "/a.csv", "w") as f:
        f.write("gps_time,x,y,z,return,id\n")
        for at, v in points("a.csv"):
            f.write(",".join([text(v["gps_time"]), *map(repr, at), text(v["return"]), text(v["id"])]) + "\n")
    open(folder + "/b.pcd", "wb").write(pcd("b.pcd", True))
    open(folder + "/c.pcd", "wb").write(pcd("c.pcd", False))

def load(path):
    data = open(path, "rb").read()
    at = data.index(b"end_header\n") + 11
    kinds = {"float": "f", "double": "d", "uchar": "B", "ushort": "H", "short": "h", "int": "i", "uint": "I", "char": "b"}
    fields = [line.split() for line in data[:at].decode().split("\n") if line.startswith("property")]
    shape = struct.Struct("<" + "".join(kinds[f[1]] for f in fields))
    greatest = {"uchar": 255, "ushort": 65535, "uint": (1 << 32) - 1, "int": (1 << 31) - 1}
    for row in shape.iter_unpack(data[at:]):
        yield {f[2]: None if v != v else v for f, v in zip(fields, row)}, {f[2]: greatest.get(f[1]) for f in fields}

def check(path, names):
    wanted = {tuple(round(c, 3) for c in at): v for name in names for at, v in points(name)}
    found = 0
    for row, greatest in load(path):
        own = wanted.pop(tuple(round(row[a], 3) for a in "xyz"))
        for name in [n for n in row if n not in ("x", "y", "z", "nx", "ny", "nz")]:
            value = own.get(name)
            if value is None and name in greatest and greatest[name] is not None:
                value = greatest[name]
            assert row[name] == value, (row, own, name)
            found += 1
        assert all(n in row for n in own), (row, own)
    assert not wanted and found > 0, len(wanted)

if sys.argv[1] == "make":
    make(sys.argv[2])
else:
    check(sys.argv[2], sys.argv[3:])
END_OF_PYTHON
python3 "$script" make "$FOLDER" || fail "no files"

expect_ok() {
    run "$STIPPLE" "$@"
    [ "$code" = 0 ] || fail "$command: $(head -1 "$FOLDER/err")"
}

# come_back FILE...: prepared together, their points have the numbers that Python gave them.
come_back() {
    expect_ok prep "${@/#/$FOLDER/}" -o "$FOLDER/m.stipple" --attributes all --precision exact --force --quiet
    expect_ok verify "$FOLDER/m.stipple" --quiet
    expect_ok export "$FOLDER/m.stipple" -o "$FOLDER/m.ply" --force --quiet
    python3 "$script" check "$FOLDER/m.ply" "$@" || fail "$*: other numbers come back"
}
come_back a.csv
come_back b.pcd
come_back c.pcd
come_back a.csv b.pcd c.pcd

# Nothing is kept unless asked for, and prep says what there is. A part is kept by name.
run "$STIPPLE" prep "$FOLDER/b.pcd" -o "$FOLDER/none.stipple"
[ "$code" = 0 ] && found "ring, return, curve_0, curve_1, tick" "$FOLDER/err" || fail "prep does not name attributes"
expect_ok prep "$FOLDER/a.csv" -o "$FOLDER/part.stipple" --attributes id --quiet
expect_ok info "$FOLDER/part.stipple" --json
python3 - "$FOLDER/out" <<'END' || fail "other attributes than asked for"
import json, sys
sys.exit([a["name"] for a in json.load(open(sys.argv[1]))["extra_attributes"]] != ["id"])
END

# Columns without a header get names from --columns.
sed 1d "$FOLDER/a.csv" >"$FOLDER/bare.csv"
expect_ok prep "$FOLDER/bare.csv" -o "$FOLDER/m.stipple" --attributes all --columns gps_time,x,y,z,return,id \
    --precision exact --force --quiet
expect_ok export "$FOLDER/m.stipple" -o "$FOLDER/m.ply" --force --quiet
python3 "$script" check "$FOLDER/m.ply" a.csv || fail "named columns: other numbers come back"
run "$STIPPLE" prep "$FOLDER/bare.csv" -o "$FOLDER/x.stipple" --columns gps_time,x,y,z,return,id
[ "$code" = 1 ] && found "--attributes" "$FOLDER/err" || fail "a name that nobody keeps: exit $code"
end_test
