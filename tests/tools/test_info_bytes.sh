#!/usr/bin/env bash
# Tests `info --bytes`: what it counts adds up to the file, in every codec and version; of raw files it counts what
# the layout says.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
command -v python3 >/dev/null || skip_test "python3 is not installed"
cd "$FOLDER" || exit 1
"$STIPPLE" gen terrain -n 60000 -o s.ply --quiet || fail "no scan"

# Checks the output of info in ./out.
check_bytes() { # codec
    python3 - "$1" out <<'END' || return 1
import json, sys
info = json.load(open(sys.argv[2]))
found, samples, patches = info["bytes"], 0, 0
assert sum(found.values()) == info["file_bytes"], found
for depth in info["depths"]:
    samples += sum(depth["samples"])
    patches += depth["patches"]
names = ("positions", "normals", "radii", "colours", "intensities", "classes")
if sys.argv[1] == "raw":
    assert [found[n] for n in names] == [k * samples for k in (6, 3, 1, 3, 1, 2)], found
    assert 64 * patches <= found["patches"] <= 66 * patches, found
else:
    assert found["positions"] > found["normals"] > found["radii"] > found["intensities"], found
END
}

for format in 1 2; do
    for codec in raw draco zstd; do
        "$STIPPLE" prep s.ply -o m.stipple --codec $codec --format $format --force --quiet || fail "no model"
        "$STIPPLE" info m.stipple --bytes --json >out || fail "info --bytes $codec $format"
        check_bytes $codec || fail "bytes of $codec, format $format"
    done
done
"$STIPPLE" info m.stipple --bytes | found '^positions  *[0-9]*  *[0-9.]*$' || fail "no table"
"$STIPPLE" info m.stipple --bytes | found 'scale' && fail "a scan of floats keeps no scale"

# Coordinates in steps of 1/1024, in spacings far wider.
python3 - >steps.txt <<'END'
for i in range(4000):
    print(i % 64, i // 64, (i * 37 % 1024) / 1024)
END
"$STIPPLE" prep steps.txt -o steps.stipple --precision 0.0001 --quiet || fail "no model in steps"
"$STIPPLE" info steps.stipple --bytes | found '^Up to [0-9.]* bytes a point of the positions keep' ||
    fail "nothing about the scale"
head -c 3000 m.stipple >cut.stipple
run "$STIPPLE" info cut.stipple --bytes
[ "$code" = 1 ] || fail "a cut file is counted"
end_test
