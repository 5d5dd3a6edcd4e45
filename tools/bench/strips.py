#!/usr/bin/env python3
"""Prints how many triangles a PLY mesh has, and into how many triangle strips a greedy walk cuts them.

  strips.py F.ply

From each triangle that is left, the walk goes over the edge of the latest two vertices for as long as there is another
triangle; of the three ways to begin it takes the longest."""

import array
import struct
import sys

SIZES = {"char": "b", "uchar": "B", "int8": "b", "uint8": "B", "short": "h", "ushort": "H", "int16": "h", "uint16": "H",
         "int": "i", "uint": "I", "int32": "i", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d"}


def read_triangles(path):
    """Corners of all triangles, one behind the other; the faces' list comes first among their properties."""
    file = open(path, "rb")
    ascii_, rest, elements = False, [], []
    for line in iter(file.readline, b"end_header\n"):
        words = line.decode("ascii", "replace").split()
        if words[:1] == ["format"]:
            ascii_, order = words[1] == "ascii", ">" if "big" in words[1] else "<"
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), rest := []))
        elif words[:1] == ["property"]:
            rest.append(words)
    out = array.array("I")
    for name, count, properties in elements:
        if name != "face" and ascii_:
            for _ in range(count):
                file.readline()
        elif name != "face":
            file.seek(struct.calcsize(order + "".join(SIZES[p[1]] for p in properties)) * count, 1)
        elif ascii_:
            for _ in range(count):
                out.extend(map(int, file.readline().split()[1:4]))
        else:
            tail = order + "".join(SIZES[p[1]] for p in properties[1:])
            row = struct.Struct(f"{order}{SIZES[properties[0][2]]}3{SIZES[properties[0][3]]}{tail[1:]}")
            for corners in row.iter_unpack(file.read(row.size * count)):
                out.extend(corners[1:4])
            return out
    return out


def edges_of(corners):
    """The one or two triangles of each edge, + 1, in one number."""
    out = {}
    for t in range(len(corners) // 3):
        a, b, c = corners[3 * t:3 * t + 3]
        for u, v in ((a, b), (b, c), (c, a)):
            key = u << 32 | v if u < v else v << 32 | u
            out[key] = out.get(key, 0) << 32 | t + 1
    return out


def walk(corners, edges, used, first, turn):
    """The triangles of the strip that begins with a triangle, its corners turned."""
    strip, last = [first], [corners[3 * first + (turn + k) % 3] for k in (1, 2)]
    while True:
        pair = edges[min(last) << 32 | max(last)]
        others = [t - 1 for t in (pair >> 32 & 0xFFFFFFFF, pair & 0xFFFFFFFF)
                  if t and not used[t - 1] and t - 1 not in strip[-3:] and t - 1 != first]
        if not others:
            return strip
        strip.append(others[0])
        own = corners[3 * others[0]:3 * others[0] + 3]
        last = [last[1], next((c for c in own if c not in last), last[0])]
        used[others[0]] = 2


def count_strips(corners):
    edges, used, strips = edges_of(corners), bytearray(len(corners) // 3), 0
    for first in range(len(used)):
        if used[first]:
            continue
        best = []
        for turn in range(3):
            strip = walk(corners, edges, used, first, turn)
            for t in strip:
                used[t] = 0
            best = max(best, strip, key=len)
        for t in best:
            used[t] = 1
        strips += 1
    return strips


triangles = read_triangles(sys.argv[1])
print(len(triangles) // 3, count_strips(triangles))
