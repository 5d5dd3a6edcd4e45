"""Codecs 3 to 5: segments cut into blocks, and the table that tells of them."""

import math
import struct

import codec_draco
import codec_raw
import codec_zstd
from model import Cursor, require
from xxh3 import xxh3

PARTS = (codec_raw.decode, codec_draco.decode_block, codec_zstd.decode_block)
RECORD = struct.Struct("<HBB3Hh3I3Q6f4f4B4B4BB3s")


def error_of(exponent, code):
    return 2.0 ** exponent * 2 ** ((code - 1) / 8 - 8) if code else 0.0


class Record:
    """A block as the table has it."""

    def __init__(self, data, name):
        (patches, self.flags, zero, *rest) = RECORD.unpack(data)
        self.patches = patches + 1
        self.counts = [n + 1 for n in rest[0:3]] + [self.patches]
        exponent = rest[3]
        self.bytes, self.hashes, self.box, self.cone = rest[4:7], rest[7:10], rest[10:16], rest[16:20]
        self.errors = [[error_of(exponent, c) for c in rest[20 + k:24 + k]] for k in (0, 4)]
        self.colour, self.radius_code, self.exponent = rest[28:32], rest[32], exponent
        require(zero == 0 and rest[33] == bytes(3) and self.flags & ~5 == 0,
                f"{name}: reserved bits are set")
        require(-200 <= exponent <= 200 and all(math.isfinite(x) for x in self.box + self.cone),
                f"{name}: a number is out of range")


def read_index(segment, first, name):
    """Sizes of the parts; of segment 0 also patches and samples of levels 0 to 3; and where parts begin."""
    cursor = Cursor(segment, name)
    rows = []
    for _ in range(cursor.number(4)):
        size = cursor.number(4)
        counts = [cursor.number(2) + 1 for _ in range(4)] if first else []
        rows.append((size, counts[::-1][:3] + counts[:1]))
    return rows, cursor


def read(segments, codec, linked, records, name):
    """Patches and samples of levels 0 to 3 of a chunk; each block must be as its record says."""
    parts, counts = [], []
    for s, segment in enumerate(segments):
        rows, cursor = read_index(segment, s == 0, f"{name}, segment {s}")
        require(len(rows) == len(records), f"{name}, segment {s}: {len(rows)} blocks")
        counts = [row[1] for row in rows] if s == 0 else counts
        parts.append([cursor.take(row[0]) for row in rows])
        cursor.end()
    patches, levels, ends = [], [[], [], [], []], []
    for b, record in enumerate(records):
        where, own = f"{name}, block {b}", [part[b] for part in parts]
        require(record.counts == counts[b], f"{where}: the table has other counts")
        require([len(p) for p in own] == record.bytes and [xxh3(p) for p in own] == record.hashes,
                f"{where}: the table has other sizes or checksums")
        block_patches, block_levels = PARTS[codec - 3](own, record.patches, linked, where)
        require([len(level) for level in block_levels] == record.counts, f"{where}: counts are wrong")
        check_bounds(record, block_patches, where)
        patches += block_patches
        ends.append(len(patches))
        for all_samples, samples in zip(levels, block_levels):
            all_samples += samples
    return patches, levels, ends


def check_bounds(record, patches, name):
    for p in patches:
        step = 2.0 ** p.exponent
        for level in range(4):
            for k, codes in enumerate((p.error, p.tangential)):
                require(error_of(p.exponent, codes[level]) <= record.errors[k][level] * (1 + 1e-9),
                        f"{name}: an error exceeds the record's")
            require(p.colour[level] <= record.colour[level], f"{name}: a colour error exceeds the record's")
        radius = step * 2 ** ((p.bound_radius - 1) / 16) if p.bound_radius else 0.0
        for axis in range(3):
            centre = (p.origin[axis] + p.bound[axis]) * step
            require(record.box[axis] <= centre - radius * (1 - 1e-9) and
                    centre + radius * (1 - 1e-9) <= record.box[3 + axis],
                    f"{name}: a bound reaches outside the record's box")
        require(p.flags & 1 <= record.flags & 1, f"{name}: a patch is two-sided and its block is not")
        require(record.flags >> 2 & 1 <= p.flags >> 5 & 1, f"{name}: a patch is not closed and its block is")
