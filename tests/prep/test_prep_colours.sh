#!/usr/bin/env bash
# Tests points without a colour among points that have one: they are black in the file, light grey in the model.
# Black things, which have nearly black points, too, stay black. Attributes keep the file's numbers.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# LAS of a wave: every `black`-th point has no colour, every `dark`-th is nearly black; 0: none is.
write() { # file, black, dark
    python3 - "$@" <<'END'
import math, struct, sys
black, dark = int(sys.argv[2]), int(sys.argv[3])
h = bytearray(227)
h[0:4], h[24], h[25] = b"LASF", 1, 2
struct.pack_into("<HIIBHI", h, 94, 227, 227, 0, 2, 26, 6400)
struct.pack_into("<6d", h, 131, 0.01, 0.01, 0.01, 0, 0, 0)
for i in range(6400):
    x, y = i % 80, i // 80
    rgb = (0, 0, 0) if black and i % black == 0 else (1000, 900, 1100) if dark and i % dark == 1 else (40000, 30001, 65535)
    h += struct.pack("<3i8x3H", 10 * x, 10 * y, round(20 * math.sin(x / 9)), *rgb)
open(sys.argv[1], "wb").write(h)
END
}

# The colours of an exported LAS file that occur, with their numbers.
colours() { # file
    python3 - "$1" <<'END'
import collections, struct, sys
d = open(sys.argv[1], "rb").read()
at, form, size, count = struct.unpack_from("<I4xBH", d, 96) + struct.unpack_from("<I", d, 107)
count = count or struct.unpack_from("<Q", d, 247)[0]
rgb = {2: 20, 3: 28, 5: 28, 7: 30, 8: 30}[form & 63]
found = collections.Counter(struct.unpack_from("<3H", d, at + i * size + rgb) for i in range(count))
print(" ".join("%d,%d,%d:%d" % (*c, n) for c, n in sorted(found.items())))
END
}

expect_colours() { # expected, options of prep
    run "$STIPPLE" prep "$FOLDER/in.las" -o "$FOLDER/m.stipple" --force "${@:2}"
    expect_code 0
    grep -c 'have no colour' "$FOLDER/err" >"$FOLDER/told"
    "$STIPPLE" export "$FOLDER/m.stipple" -o "$FOLDER/out.las" --force --quiet || fail "export"
    [ "$(colours "$FOLDER/out.las")" = "$1" ] || fail "$command: $(colours "$FOLDER/out.las"), expected $1"
}

write "$FOLDER/in.las" 4 0
expect_colours "40092,30069,65535:4800 51400,51400,51400:1600"
expect_text err "1600 points have no colour"
expect_colours "0,0,0:1600 40000,30001,65535:4800" --attributes all
write "$FOLDER/in.las" 4 8 # a black thing
expect_colours "0,0,0:1600 1028,1028,1028:800 40092,30069,65535:4000"
[ "$(<"$FOLDER/told")" = 0 ] || fail "black things are told to have no colour"
write "$FOLDER/in.las" 200 0 # a few black points
expect_colours "0,0,0:32 40092,30069,65535:6368"

end_test
