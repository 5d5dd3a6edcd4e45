"""Codec 2: planes of residuals in zstd frames. The program zstd decodes the frames."""

import math
import shutil
import struct
import subprocess

from codec_draco import SAMPLE_COLUMNS, coarsest_level, patch_columns, patches_of
from model import (Cursor, Fault, Sample, axes_of, families, integer_normal,
                   require, signed, step_code, step_place, unfold, weights_of)

PARTS = 32
PLANES = 16


def single(x):
    """A number rounded to IEEE 754's single precision."""
    return struct.unpack("<f", struct.pack("<f", x))[0]


def nearest(x):
    return math.floor(single(min(max(x, -65535.0), 65535.0) + 65536.5)) - 65536


def open_frame(data, size, name):
    """The content of one frame, which must state this size."""
    program = shutil.which("zstd")
    require(program, "the program zstd is missing: install it to read codec 2")
    require(data[:4] == b"\x28\xb5\x2f\xfd", f"{name}: no zstd frame")
    flags = data[4]
    require(flags & 3 == 0, f"{name}: the frame needs a dictionary")
    require(flags & 32 or flags >> 6, f"{name}: the frame does not say its size")
    at, width = (5 if flags & 32 else 6), (1, 2, 4, 8)[flags >> 6]
    said = int.from_bytes(data[at:at + width], "little") + (256 if width == 2 else 0)
    require(said == size, f"{name}: the frame holds {said} bytes, expected {size}")
    done = subprocess.run([program, "-d", "-c", "-q"], input=data, capture_output=True, check=False)
    if done.returncode != 0:
        raise Fault(f"{name}: {done.stderr.decode().strip()}")
    require(len(done.stdout) == size, f"{name}: the frame has {len(done.stdout)} bytes, expected {size}")
    return done.stdout


def tables_of(content, rows, columns):
    """The tables of patches and of level 3: low bytes of all cells of both, then their high bytes."""
    cells = len(content) // 2
    values = [unfold(content[i] | content[cells + i] << 8) for i in range(cells)]
    tables, at = [], 0
    for count in columns:
        tables.append(list(zip(*(values[at + c * rows:at + (c + 1) * rows] for c in range(count)))))
        at += count * rows
    return tables


class Planes:
    """The sixteen planes of a level, one byte per slot."""

    def __init__(self, cursor, families_count, block):
        sizes = [3 * families_count] * PLANES + [families_count] * PLANES
        mask = cursor.number(4)
        kind = cursor.number(1) if block else 0
        odd, shift = kind >> 4, kind & 15
        require(odd <= 3 and shift <= (9 if odd else 11), f"{cursor.name}: normals have steps of kind {kind}")
        self.step = 2 * odd + 1 << shift
        parts = [cursor.take(size) if mask >> i & 1 else None for i, size in enumerate(sizes)]
        rest = sum(size for part, size in zip(parts, sizes) if part is None)
        content = b""
        if rest:
            content = open_frame(cursor.take(len(cursor.data) - cursor.at), rest, cursor.name)
        cursor.end()
        at = 0
        for i, size in enumerate(sizes):
            if parts[i] is None:
                parts[i] = content[at:at + size]
                at += size
        self.parts, self.count = parts, families_count

    def byte(self, plane, family, slot):
        if slot == 3:
            return self.parts[PLANES + plane][family]
        return self.parts[plane][slot * self.count + family]

    def normals(self, family, slot):
        high = self.byte(9, family, slot)
        return (unfold(self.byte(7, family, slot) | (high & 15) << 8),
                unfold(self.byte(8, family, slot) | high >> 4 << 8))

    def position(self, axis, family, slot):
        return unfold(self.byte(10 + 2 * axis, family, slot) | self.byte(11 + 2 * axis, family, slot) << 8)


def normal_code(predicted, residual, step):
    if step == 1:
        return (predicted + residual) & 4095
    place = step_place(min(max(predicted, 0), 4095), step)
    return step_code((place + residual) & 4095, step)


def read_family(planes, f, parent, count, order):
    """The children of one parent; order: axes A, B, C."""
    slots = list(range(count - 1)) + [3]
    children = [Sample((parent.radius + planes.byte(0, f, slot)) & 255) for slot in slots]
    weights = weights_of([s.radius for s in children])
    n = integer_normal(parent.u, parent.v)
    d = float(-max(1024, abs(n[order[2]])) if n[order[2]] >= 0 else max(1024, abs(n[order[2]])))
    slopes = [single(n[axis] / d) for axis in order[:2]]
    begin = parent.colour + [parent.u, parent.v] + [parent.position[axis] for axis in order]
    moments = [0.0] * len(begin)
    for e, (slot, s) in enumerate(zip(slots, children)):
        share = single(1.0 / sum(weights[e:]))
        predicted = [b + nearest(single(m * share)) for b, m in zip(begin, moments)]
        s.flags = (parent.flags + planes.byte(1, f, slot)) & 255
        s.class_id = (parent.class_id + planes.byte(2, f, slot)) & 255
        green = (predicted[0] + planes.byte(3, f, slot)) & 255
        change = green - predicted[0] if slot < 3 else 0
        others = [predicted[1] + change, predicted[2] + change, predicted[3]]
        s.colour = [green] + [(o + planes.byte(4 + i, f, slot)) & 255 for i, o in enumerate(others)]
        s.u, s.v = (normal_code(p, r, planes.step) for p, r in zip(predicted[4:6], planes.normals(f, slot)))
        along = [planes.position(axis, f, slot) for axis in range(3)]
        if slot < 3:
            products = [single(a * b) for a, b in zip(slopes, along)]
            predicted[8] += nearest(single(products[0] + products[1]))
        for i, axis in enumerate(order):
            s.position[axis] = (predicted[6 + i] + along[i]) & 65535
        now = s.colour + [s.u, s.v] + [s.position[axis] for axis in order]
        moments = [single(m + single(weights[e] * (b - x))) for m, b, x in zip(moments, begin, now)]
    return children


def read_level(cursor, patches, level, coarser, block):
    planes, f, samples = Planes(cursor, len(coarser), block), 0, []
    for patch in patches:
        order = axes_of(integer_normal(patch.u, patch.v))
        for children in families(patch, level):
            samples += read_family(planes, f, coarser[f], len(children), order)
            f += 1
    return samples


def decode(segments, patch_count, linked, name, block=False):
    """Patches and samples of levels 0 to 3."""
    cursor = Cursor(segments[0], f"{name}, segment 0")
    columns = patch_columns(linked), SAMPLE_COLUMNS
    frame = cursor.take(cursor.number(4))
    content = open_frame(frame, 2 * patch_count * sum(columns), cursor.name)
    patch_rows, sample_rows = tables_of(content, patch_count, columns)
    patches = patches_of(patch_rows, linked)
    levels = [None, None, None, coarsest_level(sample_rows, patches)]
    for level in (2, 1, 0):
        if level < 2:
            cursor = Cursor(segments[2 - level], f"{name}, segment {2 - level}")
        levels[level] = read_level(cursor, patches, level, levels[level + 1], block)
    return patches, levels


def decode_block(segments, patch_count, linked, name):
    """A block's parts: normals may be on a grid."""
    return decode(segments, patch_count, linked, name, True)
