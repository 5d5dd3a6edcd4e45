"""Squares of a grid of heights, in codec 4: positions, normals and radii follow from places and heights."""

import math
import struct

from model import Sample, integer_normal, require

ROOT2 = 1.4142135623730951
SIDE, ORDER = 8, range(64)


def even_bits(i):
    return i & 1 | i >> 1 & 2 | i >> 2 & 4


def whole(x):
    return math.floor(x + 0.5) if -2.0 ** 30 <= x <= 2.0 ** 30 else 0


def mean(values):
    total = 0.0
    for v in values:
        total += v
    return total / len(values)


def children_of(patch, level):
    """For each sample of a level above 0 of a patch, the range of its children."""
    above, below = patch.counts[level], patch.counts[level - 1]
    return [(j * below // above, (j + 1) * below // above) for j in range(above)]


class Raster:
    def __init__(self, cursor):
        self.x, self.y, self.dx, self.dy, self.column, self.row = struct.unpack("<4d2I", cursor.take(40))
        require(all(abs(n) <= 8e15 for n in (self.x, self.y, self.dx, self.dy)) and self.dx and self.dy,
                f"{cursor.name}: a raster out of range")


def squares_of(raster, rows, patches, name):
    """Column, row and mask of each patch's square."""
    column, row, out = raster.column, raster.row, []
    for cells, patch in zip(rows, patches):
        column, row = column + cells[0], row + cells[1]
        mask = sum((255 - cells[2 + k] & 255) << 8 * k for k in range(8))
        require(0 <= column < 1 << 28 and 0 <= row < 1 << 28, f"{name}: a square out of range")
        require(bin(mask).count("1") == patch.counts[0], f"{name}: a square of other samples")
        out.append((column, row, mask))
    require(len({s[:2] for s in out}) == len(out), f"{name}: a square twice")
    return out


class Level:
    def __init__(self):
        self.places, self.x, self.y, self.z, self.cells = [], [], [], [], {}


class Block:
    """The samples of a block of squares as grids."""

    def __init__(self, raster, squares, patches, name):
        self.raster, self.patches, self.levels = raster, patches, [Level() for _ in range(4)]
        columns, rows = [s[0] for s in squares], [s[1] for s in squares]
        self.left, self.top = min(columns) * SIDE, min(rows) * SIDE
        self.width, self.height = ((max(n) - min(n) + 1) * SIDE for n in (columns, rows))
        require(self.width * self.height // 64 <= 4 * len(patches) + 64, f"{name}: squares far apart")
        self.exponent = min(p.exponent for p in patches)
        require(max(p.exponent for p in patches) - self.exponent <= 8, f"{name}: lattices too unlike")
        for square, patch in zip(squares, patches):
            begin = len(self.levels[0].places)
            self.place_finest(square, patch)
            for level in (1, 2, 3):
                begin = self.place_merged(level, patch, begin)

    def add(self, level, place, x, y):
        on = self.levels[level]
        on.cells[tuple(int(n) >> level for n in place)] = len(on.places)
        on.places.append(place)
        on.x.append(x)
        on.y.append(y)

    def place_finest(self, square, patch):
        inverse = math.ldexp(1.0, -patch.exponent)
        for i in ORDER:
            if square[2] >> i & 1:
                column, row = SIDE * square[0] + even_bits(i), SIDE * square[1] + even_bits(i >> 1)
                self.add(0, (float(column - self.left), float(row - self.top)),
                         float(round((self.raster.x + column * self.raster.dx) * inverse)),
                         float(round((self.raster.y + row * self.raster.dy) * inverse)))

    def place_merged(self, level, patch, begin):
        finer, first = self.levels[level - 1], len(self.levels[level].places)
        for low, high in children_of(patch, level):
            own = range(begin + low, begin + high)
            place = tuple(mean([finer.places[i][k] for i in own]) for k in range(2))
            self.add(level, place, float(round(mean([finer.x[i] for i in own]))),
                     float(round(mean([finer.y[i] for i in own]))))
        return first

    def at(self, level, column, row):
        return self.levels[level].cells.get((column, row), -1)

    def set_heights(self, level, samples):
        at, heights = 0, []
        for p in self.patches:
            steps = math.ldexp(1.0, p.exponent - self.exponent)
            heights += [(p.origin[2] + s.position[2]) * steps for s in samples[at:at + p.counts[level]]]
            at += p.counts[level]
        self.levels[level].z = heights

    def slopes(self, level, sample, values):
        """By column and by row."""
        on, out = self.levels[level], []
        column, row = (int(n) >> level for n in on.places[sample])
        for axis in range(2):
            near = [self.at(level, column + (1 - axis) * k, row + axis * k) for k in (-2, -1, 1, 2)]
            low, high = (n if n >= 0 else sample for n in near[1:3])
            side = 1 << level
            wide = (on.places[high][axis] - on.places[low][axis]) / side
            rise = values[high] - values[low]
            if low == high:
                out.append(0.0)
            elif (wide == 2 and near[0] >= 0 and near[3] >= 0 and
                    on.places[near[3]][axis] - on.places[near[0]][axis] == 4 * side):
                out.append((22.0 * rise - 3.0 * (values[near[3]] - values[near[0]])) / 32.0)
            else:
                out.append(rise / wide)
        return out

    def twist(self, level, sample, values):
        column, row = (int(n) >> level for n in self.levels[level].places[sample])
        near = [self.at(level, column + i, row + j) for j in (-1, 1) for i in (-1, 1)]
        if min(near) < 0:
            return 0.0
        v = [values[n] for n in near]
        return ((v[3] - v[2]) - (v[1] - v[0])) / 4.0

    def fitted(self, level, sample, reach):
        """The slopes of the plane through a window."""
        on = self.levels[level]
        column, row = (int(n) >> level for n in on.places[sample])
        n = x = y = z = xx = xy = yy = xz = yz = 0.0
        for j in range(-reach, reach + 1):
            for i in range(-reach, reach + 1):
                at = self.at(level, column + i, row + j)
                if at >= 0:
                    h = on.z[at]
                    n, x, y, z = n + 1, x + i, y + j, z + h
                    xx, xy, yy, xz, yz = xx + i * i, xy + i * j, yy + j * j, xz + i * h, yz + j * h
        xx, yy, xy, xz, yz = xx - x * x / n, yy - y * y / n, xy - x * y / n, xz - x * z / n, yz - y * z / n
        d, least = xx * yy - xy * xy, 2.0 ** -20
        if d > least:
            return (xz * yy - yz * xy) / d, (yz * xx - xz * xy) / d
        return (xz / xx, 0.0) if xx > least else (0.0, yz / yy) if yy > least else (0.0, 0.0)

    def kind(self, level, sample, s):
        x, y, z = integer_normal(s.u, s.v)
        upright, steep, ratio = float(z * z), 0, ROOT2
        while steep < 4 and x * x + y * y + z * z >= ratio * upright:
            steep, ratio = steep + 1, 2 * ratio
        column, row = (int(n) >> level for n in self.levels[level].places[sample])
        missing = any(0 <= column + i < self.width >> level and 0 <= row + j < self.height >> level and
                      self.at(level, column + i, row + j) < 0 for i in (-1, 0, 1) for j in (-1, 0, 1))
        return steep, missing


class Family:
    """What a parent tells of its children."""

    def __init__(self, block, level, parent, samples):
        self.place, self.count, self.level = block.levels[level + 1].places[parent], 0, level
        colours = [[s.colour[k] for s in samples] for k in range(3)]
        self.values = []
        for values in (*colours, block.levels[level + 1].z):
            self.values.append((values[parent], *block.slopes(level + 1, parent, values),
                                block.twist(level + 1, parent, values)))

    def expected(self, place):
        side = 2.0 ** (self.level + 1)
        c, r = ((place[k] - self.place[k]) / side for k in range(2))
        out = []
        for v, by_column, by_row, twist in self.values:
            e = v + (c * by_column + r * by_row)
            out.append(e + c * r * twist if self.count == 4 else e)
        return out


def height_of(patch, steps, cell, scale):
    p = min(max(steps - patch.origin[2], -65536.0), 131072.0)
    if scale and scale.used:
        place = int(p * scale.places + scale.offset[2] + 65536.5) - 65536
        return scale.position(2, (place + cell) & 65535)
    return (whole(p) + cell) & 65535


def decode_level(block, level, how, parents, tables):
    """The samples of a level. tables: of elder and of last children."""
    require(how < 16 and how & 7 <= 4, "a level of squares begins wrong")
    on, samples, cells = block.levels[level], [], []
    rows = [iter(t.rows) for t in tables]
    block.set_heights(level + 1, parents)
    parent = 0
    for patch in block.patches:
        steps = math.ldexp(1.0, patch.exponent - block.exponent)
        scale = tables[1].scale.of_patch(patch) if tables[1].scale else None
        for low, high in children_of(patch, level + 1):
            family, left = Family(block, level, parent, parents), [0.0] * 4
            family.count = high - low
            for k in range(family.count):
                elder = k + 1 < family.count
                row, i, up = next(rows[0 if elder else 1]), len(samples), parents[parent]
                s = Sample(0, (up.flags + row[1]) & 255, (up.class_id + row[2]) & 255)
                expected, share = family.expected(on.places[i]), 1.0 / (family.count - k)
                move = row[5] if how & 8 and elder else 0
                s.colour = [(whole(expected[n] + share * left[n]) + row[5 + n] + (move if n else 0)) & 255
                            for n in range(3)] + [(up.colour[3] + row[8]) & 255]
                s.position = [(whole(at - patch.origin[n]) + row[9 + n]) & 65535
                              for n, at in enumerate((on.x[i], on.y[i]))]
                s.position.append(height_of(patch, (expected[3] + share * left[3]) / steps, row[11], scale))
                values = [*s.colour[:3], (patch.origin[2] + s.position[2]) * steps]
                left = [left[n] + (expected[n] - values[n]) for n in range(4)]
                samples.append(s)
                cells.append((patch, row))
            parent += 1
    block.set_heights(level, samples)
    add_normals(block, level, how & 7, samples, cells, tables[1].shift)
    return samples


def add_normals(block, level, reach, samples, cells, shift):
    first, factor = block.patches[0].radius[level], math.ldexp(1.0, block.exponent - level)
    last = {}
    for i, (s, (patch, row)) in enumerate(zip(samples, cells)):
        slopes = block.fitted(level, i, reach) if reach else block.slopes(level, i, block.levels[level].z)
        a, b = (-slopes[0] * (factor / block.raster.dx), -slopes[1] * (factor / block.raster.dy))
        m = abs(a) + abs(b) + 1.0
        s.u, s.v = (min(((whole((t / m + 1.0) * 2047.5 / (1 << shift)) + cell) & 65535) << shift, 4095)
                    for t, cell in ((a, row[3]), (b, row[4])))
        kind, octaves = block.kind(level, i, s), 16 * (patch.exponent - block.exponent)
        s.radius = (last.get(kind, first) - octaves + row[0]) & 255
        last[kind] = s.radius + octaves
