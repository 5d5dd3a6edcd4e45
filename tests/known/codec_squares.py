"""Squares of grids of heights, in codec 4: positions, normals and radii follow from places and heights."""

import bisect
import math
import struct

from known_odds import Known, runs
from model import Sample, integer_normal, place_before, require, signed, unit_normal
from odds import KnownNumbers, Numbers, Row

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
    """Heights go along `axis`; across[k] tells the places along axis (axis + 1 + k) % 3: a, b, c, d, e, f."""

    def __init__(self, level, axis, across, first, name):
        self.level, self.axis, self.across, self.first = level, axis, across, first
        self.area = across[0][1] * across[1][2] - across[0][2] * across[1][1]
        self.spreads = any(n for a in across for n in a[4:])
        require(axis < 3 and (self.area or self.spreads) and all(abs(n) <= 8e15 for a in across for n in a),
                f"{name}: a raster out of range")
        self.others = [(axis + 1) % 3, (axis + 2) % 3]


def level_raster(cursor):
    x, y, dx, dy, column, row = struct.unpack("<4d2I", cursor.take(40))
    return [Raster(True, 2, ((x, dx, 0.0, 0.0, 0.0, 0.0), (y, 0.0, dy, 0.0, 0.0, 0.0)), (column, row), cursor.name)]


def short_raster(cursor, axis):
    """Numbers are floats; of slopes the lowest byte, which is 0, is left out."""
    across = [[struct.unpack("<f", bytes(k > 0) + cursor.take(4 - (k > 0)))[0] for k in range(4)] + [0.0, 0.0]
              for _ in range(2)]
    return Raster(False, axis & ~8, across, tuple(cursor.take(2)), cursor.name)


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def camera_raster(cursor, kind):
    """All follows from where a camera is, along the axes from that of heights on, and from its rays."""
    along, *across = (struct.unpack("<f", b"\0" + cursor.take(3))[0] for _ in range(3))
    middle = struct.unpack("<2f", cursor.take(8))
    slopes = [struct.unpack("<f", cursor.take(4))[0] if kind >> 4 + i & 1 else 0.0 for i in range(4)]
    numbers = []
    for k in range(2):
        own = slopes[2 * k:2 * k + 2]
        numbers.append([across[k] - along * middle[k], *(single(0.0 - along * n) for n in own), middle[k], *own])
    return Raster(False, kind & 3, numbers, struct.unpack("<2H", cursor.take(4)), cursor.name)


def tilted_rasters(cursor, patches):
    count, out = cursor.number(2) + 1, []
    require(count <= patches, f"{cursor.name}: more rasters than patches")
    for _ in range(count):
        axis = cursor.number(1)
        if axis & 12 == 12:
            out.append(camera_raster(cursor, axis))
            continue
        if axis & 8:
            out.append(short_raster(cursor, axis))
            continue
        n = struct.unpack("<d3fd3f", cursor.take(40))
        spread = struct.unpack("<4f", cursor.take(16)) if axis & 4 else (0.0,) * 4
        out.append(Raster(False, axis & ~4, ([*n[:4], *spread[:2]], [*n[4:], *spread[2:]]),
                          struct.unpack("<2I", cursor.take(8)), cursor.name))
    return out


def squares_of(rasters, rows, name):
    """Column, row, mask and raster of each patch's square."""
    before, raster, out = [r.first for r in rasters], 0, []
    for cells in rows:
        raster += cells[10] if len(cells) > 10 else 0
        require(0 <= raster < len(rasters), f"{name}: a square of no raster")
        column, row = before[raster][0] + cells[0], before[raster][1] + cells[1]
        mask = sum((255 - cells[2 + k] & 255) << 8 * k for k in range(8))
        require(0 <= column < 1 << 28 and 0 <= row < 1 << 28, f"{name}: a square out of range")
        before[raster] = column, row
        out.append((column, row, mask, raster))
    alone = [(s[0], s[1], s[3]) for s in out if not rasters[s[3]].spreads]
    require(len(set(alone)) == len(alone), f"{name}: a square twice")
    return out


class Level:
    """across: of each sample, where it should be along the axes across its height, by column and row alone.
    rasters: of each sample, the number of its raster."""

    def __init__(self):
        self.places, self.across, self.rasters, self.z, self.cells = [], [], [], [], {}


class Block:
    """The samples of a block of squares as grids."""

    def __init__(self, rasters, squares, patches, name):
        self.rasters, self.squares, self.patches, self.stops = rasters, squares, patches, False
        self.levels, self.first, self.size, area = [Level() for _ in range(4)], {}, {}, 0
        for raster in {s[3] for s in squares}:
            own = [[s[k] for s in squares if s[3] == raster] for k in range(2)]
            self.first[raster] = [min(n) * SIDE for n in own]
            self.size[raster] = [(max(n) - min(n) + 1) * SIDE for n in own]
            area += self.size[raster][0] * self.size[raster][1] // 64
        most = min(4 * len(patches), sum(p.counts[0] for p in patches), 16384) + 256
        require(area <= most, f"{name}: squares far apart")
        self.exponent = min(p.exponent for p in patches)
        require(max(p.exponent for p in patches) - self.exponent <= 8, f"{name}: lattices too unlike")
        require(all(bin(s[2]).count("1") == p.counts[0] for s, p in zip(squares, patches)), f"{name}: a square of other samples")
        for square, patch in zip(squares, patches):
            begin = len(self.levels[0].places)
            self.place_finest(square, patch)
            for level in (1, 2, 3):
                begin = self.place_merged(level, patch, begin, square[3])

    def place(self, cells):
        """Finds the origins of patches. cells: six of each, two along each axis across the height, then two along it."""
        before = None
        for i, (patch, own) in enumerate(zip(self.patches, cells)):
            raster, tilt, at = self.rasters[self.squares[i][3]], self.tilt(3, i), self.levels[3].across[i]
            expected = 0.0
            if before:
                n = [a + b for a, b in zip(integer_normal(patch.u, patch.v), integer_normal(before.u, before.v))]
                vertex = [place_before(before, patch.exponent, axis, before.bound[axis]) for axis in range(3)]
                expected, rise, steep = float(signed(vertex[raster.axis], 32)), 0.0, float(n[raster.axis])
                for k, axis in enumerate(raster.others):
                    rise += n[axis] * ((at[k] + tilt[k] * expected) - signed(vertex[axis], 32))
                    steep += n[axis] * tilt[k]
                expected -= whole(rise / steep if steep else math.inf)
            self.place_along(patch, raster.axis, expected, own[4:])
            height = float(patch.origin[raster.axis] + patch.bound[raster.axis])
            for k, axis in enumerate(raster.others):
                self.place_along(patch, axis, at[k] + tilt[k] * height, own[2 * k:])
            before = patch

    @staticmethod
    def place_along(patch, axis, expected, cells):
        o = signed(whole(expected) - patch.bound[axis] + 3, 32) & ~7
        patch.origin[axis] = signed(o + 8 * cells[0] + (cells[1] >> 3 << 19) + (cells[1] & 7), 32)

    def add(self, level, place, across, raster):
        on = self.levels[level]
        on.cells[(raster, *(int(n) >> level for n in place))] = len(on.places)
        on.places.append(place)
        on.rasters.append(raster)
        on.across.append([float(round(n)) for n in across] if self.rasters[raster].level else across)

    def place_finest(self, square, patch):
        inverse, first = math.ldexp(1.0, -patch.exponent), self.first[square[3]]
        for i in ORDER:
            if square[2] >> i & 1:
                column, row = SIDE * square[0] + even_bits(i), SIDE * square[1] + even_bits(i >> 1)
                self.add(0, (float(column - first[0]), float(row - first[1])),
                         [(a[0] + column * a[1] + row * a[2]) * inverse for a in self.rasters[square[3]].across],
                         square[3])

    def place_merged(self, level, patch, begin, raster):
        finer, first = self.levels[level - 1], len(self.levels[level].places)
        for low, high in children_of(patch, level):
            own = range(begin + low, begin + high)
            self.add(level, tuple(mean([finer.places[i][k] for i in own]) for k in range(2)),
                     [mean([finer.across[i][k] for i in own]) for k in range(2)], raster)
        return first

    def at(self, level, raster, column, row):
        return self.levels[level].cells.get((raster, column, row), -1)

    def cell(self, level, sample):
        """Raster, column and row."""
        on = self.levels[level]
        return on.rasters[sample], *(int(n) >> level for n in on.places[sample])

    def tilt(self, level, sample):
        """How the place of a sample changes with the height, along both axes across it."""
        on = self.levels[level]
        number = on.rasters[sample]
        column, row = (self.first[number][k] + on.places[sample][k] for k in range(2))
        return [a[3] + (column * a[4] + row * a[5]) for a in self.rasters[number].across]

    def set_heights(self, level, samples):
        at, heights = 0, []
        for p, square in zip(self.patches, self.squares):
            steps, axis = math.ldexp(1.0, p.exponent - self.exponent), self.rasters[square[3]].axis
            heights += [(p.origin[axis] + s.position[axis]) * steps for s in samples[at:at + p.counts[level]]]
            at += p.counts[level]
        self.levels[level].z = heights

    def jump(self, level, sample):
        """How far the heights of samples are off that tell nothing of a sample's."""
        at = self.levels[level].z[sample] * math.ldexp(1.0, self.exponent)
        across = self.rasters[self.levels[level].rasters[sample]].across
        side = max(abs(a[i] + a[i + 3] * at) for a in across for i in (1, 2))
        return side * (8.0 * (1 << level)) * math.ldexp(1.0, -self.exponent)

    def beside(self, level, sample, ways, stops):
        """The samples that tell of a sample, so many columns and rows from it."""
        raster, column, row = self.cell(level, sample)
        near, z = [self.at(level, raster, column + c, row + r) for c, r in ways], self.levels[level].z
        most = self.jump(level, sample) if stops else None
        return [-1 if stops and i >= 0 and abs(z[i] - z[sample]) > most else i for i in near]

    def slopes(self, level, sample, values, stops=False):
        """By column and by row."""
        on, out = self.levels[level], []
        for axis in range(2):
            near = self.beside(level, sample, [((1 - axis) * k, axis * k) for k in (-2, -1, 1, 2)], stops)
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

    def twist(self, level, sample, values, stops):
        near = self.beside(level, sample, [(i, j) for j in (-1, 1) for i in (-1, 1)], stops)
        if min(near) < 0:
            return 0.0
        v = [values[n] for n in near]
        return ((v[3] - v[2]) - (v[1] - v[0])) / 4.0

    def fitted(self, level, sample, reach):
        """The slopes of the plane through a window."""
        on = self.levels[level]
        raster, column, row = self.cell(level, sample)
        n = x = y = z = xx = xy = yy = xz = yz = 0.0
        for j in range(-reach, reach + 1):
            for i in range(-reach, reach + 1):
                at = self.at(level, raster, column + i, row + j)
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
        number, column, row = self.cell(level, sample)
        raster, normal = self.rasters[number], integer_normal(s.u, s.v)
        tilt = self.tilt(level, sample)
        along = normal[raster.axis] + (tilt[0] * normal[raster.others[0]] + tilt[1] * normal[raster.others[1]])
        upright, steep, ratio = along * along, 0, ROOT2
        length = float(sum(n * n for n in normal)) * (1.0 + (tilt[0] * tilt[0] + tilt[1] * tilt[1]))
        while steep < 4 and length >= ratio * upright:
            steep, ratio = steep + 1, 2 * ratio
        width, height = (n >> level for n in self.size[number])
        missing = any(0 <= column + i < width and 0 <= row + j < height and
                      self.at(level, number, column + i, row + j) < 0 for i in (-1, 0, 1) for j in (-1, 0, 1))
        return steep, missing


class Family:
    """What a parent tells of its children. values: of all parents, a list for each of what is told."""

    def __init__(self, block, level, parent, values):
        self.place, self.count, self.level = block.levels[level + 1].places[parent], 0, level
        self.values = []
        for v in values:
            stops = block.stops and v is block.levels[level + 1].z
            self.values.append((v[parent], *block.slopes(level + 1, parent, v, stops), block.twist(level + 1, parent, v, stops)))

    def expected(self, place):
        side = 2.0 ** (self.level + 1)
        c, r = ((place[k] - self.place[k]) / side for k in range(2))
        out = []
        for v, by_column, by_row, twist in self.values:
            e = v + (c * by_column + r * by_row)
            out.append(e + c * r * twist if self.count == 4 else e)
        return out


def height_of(patch, axis, steps, cell, scale, coarser):
    p = min(max(steps - patch.origin[axis], -65536.0), 131072.0)
    if coarser is not None:
        first = -patch.origin[axis] & (1 << coarser) - 1
        place = whole(p) - first + (1 << coarser >> 1) >> coarser
        return first + ((place + cell & 65535 >> coarser) << coarser) & 65535
    if scale and scale.used:
        place = int(p * scale.places + scale.offset[axis] + 65536.5) - 65536
        return scale.position(axis, (place + cell) & 65535)
    return (whole(p) + cell) & 65535


def rung_of(patch, axis, z, steps, cell, ladder):
    """The position along the height of the rung that is `cell` after the one nearest to z."""
    over = bisect.bisect_left(ladder, z)
    if over == len(ladder) or (over and z - ladder[over - 1] <= ladder[over] - z):
        over -= 1
    return (whole(ladder[min(over + cell & 65535, len(ladder) - 1)] / steps - patch.origin[axis])) & 65535


NEAR = ((-1, 0, 2), (0, -1, 2), (-1, -1, 1), (1, -1, 1))  # column, row, what a magnitude counts
# In sixteenths: of the place among four children, of the last one of less than four, of others.
WEIGHTS = ((6, 7, -2, -1, 0, 6, 1, 0), (1, 5, 0, 1, 12, 8, 0, 0), (4, 4, -1, -3, 13, 4, -1, 0), (1, 1, 0, 0, 15, 1, 0, 0),
           (0, 0, 0, 0, 16, 0, 0, 0), (2, 2, 0, 0, 10, 10, 2, 0))
FOLLOWING = (0, 0, 0, 0, 0, 16, 0, 0)
BY_PARENTS = runs("../square/colour_weights.inc", 24)


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def sum_of(a, b):
    p = [single(x * y) for x, y in zip(a[:4], b)]
    for begin in range(4, len(a), 4):
        p = [single(p[i] + single(a[begin + i] * b[begin + i])) for i in range(4)]
    return single(single(p[0] + p[1]) + single(p[2] + p[3]))


class Rows:
    """Colours of level 0 by rows: green, red and blue of each sample in the order of cells."""

    def __init__(self, block, parents, symbols, by_parents):
        self.block, self.symbols, self.by_parents, follow = block, symbols, by_parents, symbols.bits(0, 1)
        require(symbols.known or not by_parents, "colours by parents have no known odds")
        self.weights = [[[w / 16 for w in (FOLLOWING if follow and v else k)] for v in range(3)] for k in WEIGHTS]
        if by_parents:
            self.weights = [[[w / 64 for w in BY_PARENTS[18 * follow + 3 * k + v]] for v in range(3)] for k in range(6)]
            self.last_odds = [Known(3, 0, 2, True).cells(v) for v in range(3)]
        self.colours = [[s.colour[k] for s in parents] for k in range(3)]
        self.off, self.size, self.values, self.parent = [], [], [], []
        self.left, self.counts, self.known, self.rows = [], [], [0] * len(parents), [0, 0]
        self.numbers = [[self.numbers_of(v, t) for v in range(3)] for t in range(2)]
        self.rest, self.around = [], []
        self.expect(self.colours)

    def numbers_of(self, channel, last):
        lane, first = channel & 1, 9 if channel == last == 0 else 8
        if not self.symbols.known:
            return Numbers(lane, first, None)
        return KnownNumbers(lane, first, None, Known(3, 0, last, True).cells(channel), False)

    def expect(self, values):
        places, parent = self.block.levels[0].places, 0
        for patch in self.block.patches:
            for low, high in children_of(patch, 1):
                family = Family(self.block, 0, parent, values)
                family.count = high - low
                self.left.append([0.0] * 3)
                self.counts.append(family.count)
                self.rest.append([family.count * values[v][parent] for v in range(3)])
                self.around.append(self.differences(parent, values) if self.by_parents else None)
                for _ in range(family.count):
                    self.off.append([single(e) for e in family.expected(places[len(self.off)])])
                    self.parent.append(parent)
                parent += 1

    def differences(self, parent, values):
        """How much the parents around one differ from it, by channel."""
        number, column, row = self.block.cell(1, parent)
        around = [self.block.at(1, number, column + c, row + r) for r in (-1, 0, 1) for c in (-1, 0, 1) if c or r]
        return [[(of[i] - of[parent]) / 4 if i >= 0 else 0.0 for i in around] for of in values]

    def read(self):
        """The colours of all samples."""
        self.size, self.values = [[0] * 3 for _ in self.off], [None] * len(self.off)
        cells = [self.block.cell(0, i) for i in range(len(self.off))]
        rasters = list(dict.fromkeys(s[3] for s in self.block.squares))
        for i in sorted(range(len(self.off)), key=lambda i: (rasters.index(cells[i][0]), cells[i][2], cells[i][1], -i)):
            number, column, row = cells[i]
            near = [self.block.at(0, number, column + c, row + r) for c, r, _ in NEAR]
            self.read_sample(i, near)
        return self.values

    def read_sample(self, sample, near):
        parent, inputs, value, beside = self.parent[sample], [0.0] * 8, [], None
        count, k = self.counts[parent], self.known[parent]
        self.known[parent] += 1
        last = k + 1 == count
        kind = k if count == 4 else 4 if last else 5
        shift = 5 + (self.rows[last] >= 64) + (self.symbols.known or self.rows[last] >= 256)
        share = single(1.0 / (count - k))
        all_shares = sum(n[2] for n, i in zip(NEAR, near) if i >= 0)
        for v in range(3):
            inputs[:4] = [self.off[i][v] if i >= 0 else 0.0 for i in near]
            inputs[4] = single(share * self.left[parent][v])
            if self.by_parents:
                inputs[8:] = [self.off[i][u] if i >= 0 and u < v else 0.0 for u in range(2) for i in near]
                inputs += self.around[parent][v]
            weights, expected = self.weights[kind][v], self.off[sample][v]
            hoped = single(expected + sum_of(weights, inputs))
            number = self.numbers[last][v]
            mean = number.mean
            if all_shares and not last:
                total = sum(n[2] * self.size[i][v] for n, i in zip(NEAR, near) if i >= 0)
                mean = (mean + (total * (65536 // all_shares) >> 8)) // 2
            number.beside = beside
            if last and self.by_parents:
                cell = self.read_last(parent, v, hoped, shift)
                value.append(self.rest[parent][v] + cell & 255)
            else:
                cell = number.read(self.symbols, Row(), shift, mean, 8)
                value.append(int(single(min(max(hoped, 0.0), 255.0) + 0.5)) + cell & 255)
            self.rest[parent][v] -= value[v]
            error = single(value[v] - hoped)
            step = single(single(error * (5 / 64)) / single(4.0 + sum_of(inputs, inputs)))
            self.weights[kind][v] = [single(w + single(x * step)) for w, x in zip(weights, inputs)]
            self.size[sample][v] = abs(cell)
            self.off[sample][v] = single(value[v] - expected)
            self.left[parent][v] = single(self.left[parent][v] - self.off[sample][v])
            if v < 2:
                inputs[5 + v] = self.off[sample][v]
            beside = number
        self.rows[last] += 1
        self.values[sample] = value

    def read_last(self, parent, v, hoped, shift):
        """The cell of a last child: what is off the rest of its parent's."""
        off = min(max(single(hoped - self.rest[parent][v]), -1.5), 1.5)
        count = self.counts[parent]
        kind = self.colours[v][parent] & 1 if count == 4 else 3 if count == 3 else 2
        number = KnownNumbers(v & 1, 0, None, None, False)
        number.odds_of = lambda *_: self.last_odds[v][7 * kind + int(single(2 * off + 3.5))]
        return number.read(self.symbols, Row(), shift, 0, 8)


def decode_level(block, level, how, more, parents, tables, ladder, symbols):
    """The samples of a level. tables: of elder and of last children. ladder: heights; empty: there is none. symbols: what
    follows the tables."""
    require(how & 7 < 7 or level < 2, "a level of squares begins wrong")
    multiple = more & 15 if level else 0
    require(level or not more & 12 and more & 3 != 2, "a level of squares goes on wrong")
    require(level or not more & 1 or not how & 40, "colours by rows follow or are loose")
    colours = Rows(block, parents, symbols, bool(more & 2)).read() if level == 0 and more & 1 else None
    on, samples, cells = block.levels[level], [], []
    rows = [iter(t.rows) for t in tables]
    block.set_heights(level + 1, parents)
    values = [[s.colour[k] for s in parents] for k in range(3)] + [block.levels[level + 1].z]
    parent = 0
    for patch, square in zip(block.patches, block.squares):
        raster = block.rasters[square[3]]
        steps = math.ldexp(1.0, patch.exponent - block.exponent)
        scale = tables[1].scale.of_patch(patch) if tables[1].scale else None
        coarser = max(multiple - (patch.exponent - block.exponent), 0) if multiple else None
        for low, high in children_of(patch, level + 1):
            family, left = Family(block, level, parent, values), [0.0] * 4
            family.count = high - low
            for k in range(family.count):
                elder = k + 1 < family.count
                row, i, up = next(rows[0 if elder else 1]), len(samples), parents[parent]
                s = Sample(0, (up.flags + row[1]) & 255, (up.class_id + row[2]) & 255)
                expected, share = family.expected(on.places[i]), 1.0 / (family.count - k)
                move = row[5] if how & 8 and elder else 0
                tied = 0.0 if how & 32 else share
                s.colour = [(whole(expected[n] + tied * left[n]) + row[5 + n] + (move if n else 0)) & 255
                            for n in range(3)] + [(up.colour[3] + row[8]) & 255]
                s.colour[:3] = colours[i] if colours else s.colour[:3]
                s.position = [0, 0, 0]
                z = expected[3] + share * left[3]
                s.position[raster.axis] = (rung_of(patch, raster.axis, z, steps, row[11], ladder) if ladder else
                                           height_of(patch, raster.axis, z / steps, row[11], scale, coarser))
                height = float(patch.origin[raster.axis] + s.position[raster.axis])
                tilt = block.tilt(level, i)
                for n, axis in enumerate(raster.others):
                    at = on.across[i][n] + tilt[n] * height
                    s.position[axis] = (whole(at - patch.origin[axis]) + row[9 + n]) & 65535
                own = [*s.colour[:3], height * steps]
                left = [left[n] + (expected[n] - own[n]) for n in range(4)]
                samples.append(s)
                cells.append((patch, row))
            parent += 1
    block.set_heights(level, samples)
    add_normals(block, level, how & 7, samples, cells, tables[1].shift, parents, more)
    return samples


def normal_of(block, level, sample, slopes):
    """The direction that slopes tell."""
    on, factor = block.levels[level], math.ldexp(1.0, block.exponent - level)
    raster = block.rasters[on.rasters[sample]]
    across = raster.across
    if raster.level:
        return -slopes[0] * (factor / across[0][1]), -slopes[1] * (factor / across[1][2]), 1.0
    rise, tilt = [s * factor for s in slopes], block.tilt(level, sample)
    height = on.z[sample] * math.ldexp(1.0, block.exponent)
    c, r = ([(across[k][1 + i] + across[k][4 + i] * height) + tilt[k] * rise[i] for k in range(2)] for i in range(2))
    out = [0.0] * 3
    out[raster.axis] = c[0] * r[1] - c[1] * r[0]
    out[raster.others[0]] = c[1] * rise[1] - rise[0] * r[1]
    out[raster.others[1]] = rise[0] * r[0] - c[0] * rise[1]
    return out


def code_of(direction, cells, shift, folded, sides=False):
    """The code u, v of a normal that is expected to have a direction."""
    x, y, z = direction
    m = abs(x) + abs(y) + abs(z) or math.nan
    x, y = x / m, y / m
    if z < 0.0:
        x, y = math.copysign(1.0 - abs(y), x), math.copysign(1.0 - abs(x), y)
    places = [(whole((t + 1.0) * 2047.5 / (1 << shift)) + cell) & 65535 for t, cell in ((x, cells[0]), (y, cells[1]))]
    if folded:
        top = 4095 + (1 << shift >> 1) >> shift
        places = [p - 65536 if p > 32767 else p for p in places]
        for i in range(2):
            if not 0 <= places[i] <= top:
                places[i] = -places[i] if places[i] < 0 else 2 * top - places[i]
                places[1 - i] = top - places[1 - i]
        places = [min(max(p, 0), top) for p in places]
        for i in range(2):
            if sides and places[i] in (0, top):
                places[1 - i] = min(places[1 - i], top - places[1 - i])
    return (min(p << shift, 4095) for p in places)


def add_normals(block, level, reach, samples, cells, shift, parents, more):
    on, last, coarse = block.levels[level], {}, more >> 5
    families, stride = None, 1 << 7 - shift - level if reach == 7 and shift <= 4 else 1
    if reach >= 5:
        units = [unit_normal(s.u, s.v) for s in parents]
        families = families_of(block, level, [[n[k] for n in units] for k in range(3)])
    for i, (s, (patch, row)) in enumerate(zip(samples, cells)):
        if families:
            family, k = next(families)
            left = [0.0] * 3 if k == 0 else left
            expected, share = family.expected(on.places[i]), 1.0 / (family.count - k)
            direction = [e + (share * t if reach == 5 else 0.0) for e, t in zip(expected, left)]
        else:
            direction = normal_of(block, level, i, block.fitted(level, i, reach) if reach else
                                  block.slopes(level, i, on.z))
        folded = reach >= 5 or block.rasters[on.rasters[i]].spreads
        s.u, s.v = code_of(direction, [stride * n for n in row[3:5]], shift, folded, bool(more & 16))
        if families:
            left = [t + (e - n) for t, e, n in zip(left, expected, unit_normal(s.u, s.v))]
        kind, octaves = block.kind(level, i, s), 16 * (patch.exponent - block.exponent)
        place = last.get(kind, block.patches[0].radius[level]) - octaves - 1 + (1 << coarse >> 1) >> coarse
        s.radius = 1 + ((place + row[0] & 255 >> coarse) << coarse) & 255
        last[kind] = s.radius + octaves


def families_of(block, level, values):
    """For each sample of a level its family, and which child it is."""
    parent = 0
    for patch in block.patches:
        for low, high in children_of(patch, level + 1):
            family = Family(block, level, parent, values)
            family.count = high - low
            yield from ((family, k) for k in range(family.count))
            parent += 1
