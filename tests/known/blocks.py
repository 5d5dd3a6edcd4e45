"""Codecs 3 to 6: segments cut into blocks, and the table that tells of them."""

import math
import struct

import codec_draco
import codec_paper
import codec_raw
import codec_zstd
from model import Cursor, require
from xxh3 import xxh3

PARTS = (codec_raw.decode, codec_draco.decode_block, codec_zstd.decode_block, codec_paper.decode_block)
RECORD = struct.Struct("<H3H9sB3sBh4B4B4B3IQ")
WIDE_RECORD = struct.Struct("<HBB3Hh3I3Q6f4f4B4B4BB3s")


def error_of(exponent, code):
    return 2.0 ** exponent * 2 ** ((code - 1) / 8 - 8) if code else 0.0


class Record:
    """A block as the table has it; box: the chunk's."""

    def __init__(self, data, box, name):
        (patches, *rest) = RECORD.unpack(data)
        self.patches = patches + 1
        self.counts = [n + 1 for n in rest[0:3]] + [self.patches]
        self.bytes = [int.from_bytes(rest[3][3 * s:3 * s + 3], "little") for s in range(3)]
        exponent = rest[7]
        self.errors = [[error_of(exponent, c) for c in rest[8 + k:12 + k]] for k in (0, 4)]
        self.colour, self.radius_code, self.exponent = rest[16:20], rest[6], exponent
        self.hashes, word = rest[20:23], rest[23]
        self.flags = word >> 60 & 1 | word >> 59 & 4
        places = [word >> 10 * k & 1023 for k in range(6)]
        self.box = [box[k % 3] + (box[3 + k % 3] - box[k % 3]) * place / 1023 for k, place in enumerate(places)]
        require(word >> 62 == 0, f"{name}: reserved bits are set")
        require(-200 <= exponent <= 200, f"{name}: a number is out of range")


class WideRecord:
    """The same in a table of wide records."""

    def __init__(self, data, _box, name):
        (patches, self.flags, zero, *rest) = WIDE_RECORD.unpack(data)
        self.patches = patches + 1
        self.counts = [n + 1 for n in rest[0:3]] + [self.patches]
        exponent = rest[3]
        self.bytes, self.box, self.cone = list(rest[4:7]), rest[10:16], rest[16:20]
        self.hashes = tuple(h & 0xFFFFFFFF for h in rest[7:10])
        self.errors = [[error_of(exponent, c) for c in rest[20 + k:24 + k]] for k in (0, 4)]
        self.colour, self.radius_code, self.exponent = rest[28:32], rest[32], exponent
        require(zero == 0 and rest[33] == bytes(3) and self.flags & ~5 == 0,
                f"{name}: reserved bits are set")
        require(-200 <= exponent <= 200 and all(math.isfinite(x) for x in self.box + self.cone),
                f"{name}: a number is out of range")


def unpack(data, count):
    """The records of a packed table."""
    require(len(data) > 16, "the packed table is cut")
    kind, stored, checksum = struct.unpack_from("<4sIQ", data, 0)
    require(kind == b"BLK3" and stored == count, "the packed table is not one of so many records")
    require(xxh3(data[16:]) == checksum, "the packed table's checksum is wrong")
    planes = codec_zstd.open_frame(data[16:], count * RECORD.size, "the packed table")
    return bytes(planes[c * count + r] for r in range(count) for c in range(RECORD.size))


def read_index(segment, first, name):
    """Sizes of the parts; of segment 0 also patches and samples of levels 0 to 3; and where parts begin."""
    cursor = Cursor(segment, name)
    rows, count = [], cursor.number(4)
    for _ in range(count & 0x7FFFFFFF if count >> 31 else 0):
        size = cursor.varint()
        patches = cursor.varint() + 1 if first else 0
        counts = [64 * patches - cursor.varint()] if first else []
        for _ in range(2 if first else 0):
            counts.append((counts[-1] + 3) // 4 + cursor.varint())
        rows.append((size, counts + [patches] if first else []))
    for _ in range(0 if count >> 31 else count):
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
        require([len(p) for p in own] == record.bytes and
                [xxh3(p) & 0xFFFFFFFF for p in own] == list(record.hashes),
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
            slack = 1e-6 * (record.box[3 + axis] - record.box[axis])
            require(record.box[axis] - slack <= centre - radius * (1 - 1e-9) and
                    centre + radius * (1 - 1e-9) <= record.box[3 + axis] + slack,
                    f"{name}: a bound reaches outside the record's box")
        require(p.flags & 1 <= record.flags & 1, f"{name}: a patch is two-sided and its block is not")
        require(record.flags >> 2 & 1 <= p.flags >> 5 & 1, f"{name}: a patch is not closed and its block is")
