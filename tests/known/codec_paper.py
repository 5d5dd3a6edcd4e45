"""Codec 6: squares without an entropy coder, heights and normals of 48 bits a sample; all else as codec 0."""

import math
import struct

import codec_raw
import codec_squares
from model import Cursor, Patch, Sample, require

WIDE, NARROW = 3, 7


def normal_of(azimuth, inclination):
    turn, fall = (azimuth + 0.5) * math.pi / 32768, (inclination + 0.5) * math.pi / 65536
    direction = math.sin(fall) * math.cos(turn), math.sin(fall) * math.sin(turn), math.cos(fall)
    return codec_squares.code_of(direction, (0, 0), 0, False)


def read_fields(cursor, count):
    """Ten lists of numbers, one a sample."""
    varies = cursor.number(2)
    require(varies >> WIDE + NARROW == 0, f"{cursor.name}: a level of squares begins wrong")
    out = []
    for field in range(WIDE + NARROW):
        width, many = 2 if field < WIDE else 1, count if varies >> field & 1 else 1
        numbers = [cursor.number(width) for _ in range(many)]
        out.append(numbers if many > 1 else numbers * count)
    return out


def read_level(cursor, block, level):
    on, samples = block.levels[level], []
    fields = read_fields(cursor, len(on.places))
    moved, last = {}, -1
    for _ in range(cursor.number(4)):
        i, a, b = struct.unpack("<3H", cursor.take(6))
        require(last < i < len(on.places), f"{cursor.name}: moved samples are out of order")
        moved[i], last = (a, b), i
    owners = [p for p in block.patches for _ in range(p.counts[level])]
    for i, (patch, row) in enumerate(zip(owners, zip(*fields))):
        raster, tilt = block.rasters[on.rasters[i]], block.tilt(level, i)
        s = Sample(row[3], row[4], row[5], *normal_of(*row[1:3]), (row[7], row[6], *row[8:10]))
        s.position[raster.axis] = row[0]
        height = float(patch.origin[raster.axis] + row[0])
        for n, axis in enumerate(raster.others):
            place = codec_squares.whole(on.across[i][n] + tilt[n] * height - patch.origin[axis])
            s.position[axis] = place + moved.get(i, (0, 0))[n] & 65535
        samples.append(s)
    return samples


def read_squares(cursor, patches, tilted):
    rasters = codec_squares.tilted_rasters(cursor, len(patches)) if tilted else codec_squares.level_raster(cursor)
    columns = []
    for column in range(11 if tilted else 10):
        width = 1 if 2 <= column < 10 else 2
        columns.append([int.from_bytes(cursor.take(width), "little", signed=width == 2) for _ in patches])
    places = codec_squares.squares_of(rasters, list(zip(*columns)), cursor.name)
    return codec_squares.Block(rasters, places, patches, cursor.name)


def decode_block(parts, patch_count, linked, name):
    """Patches and samples of levels 0 to 3."""
    cursor = Cursor(parts[0], f"{name}, segment 0")
    kind, patches, levels = cursor.number(1), [], [None] * 4
    require(kind < 3, f"{name}: a block of kind {kind}")
    if kind == 0:
        return codec_raw.decode([parts[0][1:], *parts[1:]], patch_count, linked, name)
    for _ in range(patch_count):
        patches.append(Patch.unpack(cursor.take(64)))
        patches[-1].first_below = cursor.number(2) if linked else 0
    block = read_squares(cursor, patches, kind == 2)
    for level in (3, 2, 1, 0):
        if level < 2:
            cursor = Cursor(parts[2 - level], f"{name}, segment {2 - level}")
        levels[level] = read_level(cursor, block, level)
        if level < 3:
            cursor.end()
    return patches, levels
