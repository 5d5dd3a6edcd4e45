"""Codecs 1 and 4: tables of residuals, and the predictions of patches and samples."""

import math
import struct

import codec_squares
from corners import Equal, has_corners, read_corners
from known_odds import Known
from model import (Cursor, Patch, Sample, axes_of, counts_of, direction_code, families, integer_normal, place_before,
                   require, round_div, sign, signed, step_code, step_place, trunc_div, unit_normal, weights_of)
from odds import PLACED_PATCHES, TIGHT_LADDER, TIGHT_OWN, TIGHT_PATCHES, TIGHT_SAMPLES, TIGHT_SQUARES, Row, Symbols, is_sized, read_columns, tight_columns
from symbols import Bits, read_symbols

SAMPLE_COLUMNS = 12
SQUARE_COLUMNS = 10
LADDER_COLUMNS = 2
# First and last columns that share a stream.
PATCH_STREAMS = ((1, 3), (4, 6), (7, 9), (10, 13), (14, 18), (19, 23), (24, 28), (29, 33), (34, 37),
                 (38, 40), (41, 42), (43, 44))
SAMPLE_STREAMS = ((1, 2), (3, 4), (6, 7), (9, 11))


def patch_columns(linked):
    return 46 if linked else 45


def read_column(cursor, rows):
    word = cursor.number(4)
    size, first, kept = word & 0xFFFFFF, word >> 24 & 15, word >> 28
    stream = Cursor(cursor.take(size), cursor.name + ", stream")
    high = read_symbols(stream, rows)
    stream.end()
    if kept == 0:
        return high
    bits = Bits(cursor.data[cursor.at:], cursor.name)
    cells, m = [], 8 << first
    for h in high:
        k = (m >> (3 + kept)).bit_length()
        cell = signed((h << k) + bits.take(k) - ((1 << k) >> 1), 16)
        cells.append(cell)
        m += abs(cell) - (m >> 3)
    cursor.take(bits.bytes_taken())
    return cells


def streams_of(rows, columns, block):
    """The columns of each stream of a table: in a short table of a block, some share one."""
    joined = {SAMPLE_COLUMNS: SAMPLE_STREAMS, SQUARE_COLUMNS: ()}.get(columns, PATCH_STREAMS) if block and rows < 768 else ()
    firsts = {first: last for first, last in joined}
    streams, c = [], 0
    while c < columns:
        last = firsts.get(c, c)
        streams.append(range(c, last + 1))
        c = last + 1
    return streams


class Scale:
    """The scan's own scale, which positions of level 0 may have."""

    def __init__(self, block):
        self.step, *self.phase = struct.unpack("<d3H", block.take(14))
        require(0 < self.step <= 1e15, f"{block.name}: a scale of {self.step}")

    def of_patch(self, patch):
        lattice = math.ldexp(1.0, patch.exponent)
        return PatchScale(self, patch, self.step / lattice, lattice / self.step)


class PatchScale:
    def __init__(self, scale, patch, steps, places):
        self.used = 1 < steps <= 4096
        self.steps, self.places, self.offset = steps, places, []
        for origin, phase in zip(patch.origin, scale.phase):
            at = origin * places - phase / 65536.0
            self.offset.append(at - math.floor(at))

    def place(self, axis, position):
        return int(position * self.places + self.offset[axis] + 65536.5) - 65536

    def position(self, axis, place):
        return (int((place - self.offset[axis]) * self.steps + 65536.5) - 65536) & 65535


class Sublattice:
    """The positions that a patch may have: 0 all of its lattice."""

    def __init__(self, number, origin):
        self.number, self.octave, self.kind, self.origin = number, number // 3, number % 3, origin

    def add_slanted(self, child, axis, done, predicted, cell):
        """done: the other two axes."""
        parts = 2 * (self.number - 15) + 5
        total = sum((child.position[a] + self.origin[a]) << a for a in done)
        offset = next(o for o in range(parts) if (total + (o + self.origin[axis] << axis)) % parts == 0)
        place = (predicted - offset + parts // 2) // parts + cell
        child.position[axis] = (place * parts + offset) & 65535

    def add(self, child, axis, done, predicted, cell):
        """done: the axes that the child has."""
        if self.number >= 15 and len(done) < 2:
            child.position[axis] = (predicted + cell) & 65535
            return
        if self.number >= 15:
            self.add_slanted(child, axis, done, predicted, cell)
            return
        at = [child.position[a] + self.origin[a] for a in done]
        bound = {0: 0, 1: len(done) == 2, 2: len(done) > 0}[self.kind]
        odd = (sum(at) if self.kind == 1 else at[0]) & 1 << self.octave if bound else 0
        shift = self.octave + bound
        offset = (odd - self.origin[axis]) & (2 << self.octave) - 1
        place = (predicted - offset + (1 << shift >> 1) >> shift) + cell
        child.position[axis] = ((place << shift) + offset) & 65535


def add_coordinate(child, axis, done, predicted, cell, scale, sublattice):
    if scale and scale.used:
        place = (scale.place(axis, predicted & 65535) + cell) & 65535
        child.position[axis] = scale.position(axis, place)
    else:
        sublattice.add(child, axis, done, predicted, cell)


class Table:
    """Rows of cells; of a block's table also the shift and step of normals, the scale, whether level (1) or tilted (3) squares
    follow, and whether patches are predicted by middles, and as in tight tables."""

    def __init__(self, rows=(), shift=0, scale=None, squares=0, middles=0, tight=0, radii=0, odd=0):
        self.rows, self.shift, self.scale, self.squares, self.middles = rows, shift, scale, squares, middles
        self.tight, self.radii, self.step, self.sublattices = tight, radii, 2 * odd + 1 << shift, []


def read_table(cursor, rows, columns, joined=False, level=None):
    if rows == 0:
        return Table()
    block = Cursor(cursor.take(cursor.number(4)), cursor.name)
    mask, shift, odd, by_odds, scale, squares, middles, tight = block.number(8), 0, 0, False, None, 0, 0, 0
    if joined:
        by_odds, mask = mask >> 59 & 1, mask & ~(1 << 59)
        if columns == SAMPLE_COLUMNS:
            mask, shift = mask & (1 << 60) - 1, mask >> 60
            if level is not None:
                odd, mask = mask >> 56 & 3, mask & ~(3 << 56)
            require(shift <= (9 if odd else 11), f"{cursor.name}: normals are shifted by {shift} bits")
        if level == 0 and mask >> 58 & 1:
            mask, scale = mask & ~(1 << 58), Scale(block)
        if columns >= patch_columns(False):
            squares = mask >> 57 & 3
            mask &= ~(3 << 57) if squares & 1 else -1
            middles, mask = mask >> 56 & 1, mask & ~(1 << 56)
            tight = middles and mask >> 55 & 1
            mask &= ~(1 << 55) if tight else -1
    require(mask >> columns == 0, f"{cursor.name}: the mask has bits beyond the last column")
    same = {c: signed(block.number(2), 16) for c in range(columns) if mask >> c & 1}
    table = {c: [same[c]] * rows for c in same}
    if by_odds:
        table.update(read_columns(block, rows, columns, same, middles, tight))
    else:
        for stream in streams_of(rows, columns, joined):
            varying = [c for c in stream if c not in same]
            cells = read_column(block, rows * len(varying)) if varying else []
            table.update((c, cells[i * rows:(i + 1) * rows]) for i, c in enumerate(varying))
    block.end()
    return Table(list(zip(*(table[c] for c in range(columns)))), shift, scale, squares, middles, tight, 0, odd)


class TightTables:
    """The tables of a tight part."""

    def __init__(self, cursor, squares=False):
        self.symbols, self.name, self.scale, self.squares = Symbols(cursor, True), cursor.name, None, squares
        self.patch_count, self.coarse, self.sublattices, self.shift, self.placed, self.corners = 0, None, [], None, 0, False

    def read_sublattices(self, count):
        each = 1024 if count == 15 else 768
        odds = [0] + [(1 << 14) + each * (s - 1) if s < count else (1 << 15) - 4 * (32 - s) for s in range(1, 32)]
        for _ in range(self.patch_count):
            change = self.symbols.symbol(0, odds, 4, 0)[0]
            require(change < count, f"{self.name}: a sublattice that there is not")
            self.sublattices.append(((self.sublattices or [0])[-1] + change) % count)

    def read_corners(self, patches):
        """What corners.read_corners returns, or nothing."""
        self.shift = self.symbols.bits(0, 4)
        if self.shift != 14:
            return []
        self.shift, self.corners = None, True
        return read_corners(self.symbols, patches, self.name)

    def read(self, rows, columns, level=None, last=False, kinds=()):
        """The next table: of patches, of their squares, or of samples; level: None for level 3; kinds: of its rows."""
        symbols, shift, odd, radii, same, coded, count, signed_level = self.symbols, 0, 0, 0, {}, [], 15, None
        if rows == 0:
            return Table()
        if columns == SAMPLE_COLUMNS and self.coarse:
            shift, odd, radii = self.coarse
        elif columns == SAMPLE_COLUMNS:
            shift, self.shift = symbols.bits(0, 4) if self.shift is None else self.shift, None
            if shift == 13 and level is not None and not last and symbols.known and not self.squares and not self.corners:
                shift, signed_level = symbols.bits(0, 4), level
            if shift == 15 and level is not None and not self.squares:
                shift = symbols.bits(0, 4)
                if shift == 15 and level == 0:
                    shift, count = symbols.bits(0, 4), 19
                if shift == 14:
                    shift, odd = symbols.bits(0, 4), symbols.bits(0, 2)
                self.coarse = shift, odd, radii = shift, odd, symbols.bits(0, 3)
            require(shift <= (9 if odd else 11), f"{self.name}: normals are shifted by {shift} bits")
        if level == 0 and self.scale is None:
            self.scale = symbols.bits(0, 1)
            if self.scale:
                data = b"".join(symbols.bits(0, 16).to_bytes(2, "little") for _ in range(7))
                self.scale = Scale(Cursor(data, self.name))
            if self.coarse and symbols.bits(0, 1):
                self.read_sublattices(count)
        known = Known(columns, level, last, self.squares) if symbols.known else None
        for c in range(columns):
            odds = known.how(c, c == 0 or coded[-1:] == [c - 1]) if known else symbols.how
            how = symbols.symbol(0, odds, 5, 0)[0]
            require(how <= 2, f"{self.name}: a column is coded in way {how}")
            if how == 0:
                coded.append(c)
            else:
                same[c] = [signed(symbols.bits(0, 16), 16) if how == 2 else 0] * rows
        patches = columns >= patch_columns(False)
        if columns == SAMPLE_COLUMNS and self.squares and level is not None:
            firsts = TIGHT_SQUARES[level > 0][last]
        elif columns == SAMPLE_COLUMNS:
            firsts = TIGHT_SAMPLES[0 if level is None else 1 + last]
        else:
            firsts = PLACED_PATCHES if patches and self.placed else TIGHT_PATCHES if patches else TIGHT_LADDER if columns == LADDER_COLUMNS else TIGHT_OWN
        table = tight_columns(symbols, rows, columns, coded, firsts, known, kinds, signed_level) | same
        return Table(list(zip(*(table[c] for c in range(columns)))), shift, self.scale, 0, patches, patches, radii, odd)

    def end(self):
        self.symbols.end()


class LooseTables:
    """The tables of any other part, and what stands between them."""

    def __init__(self, cursor, joined):
        self.cursor, self.joined = cursor, joined

    def read(self, rows, columns, level=None, last=False, _kinds=()):
        return read_table(self.cursor, rows, columns, self.joined, level)

    def end(self):
        self.cursor.end()


def tables_of(cursor, joined):
    tight = joined and (is_sized(cursor) or len(cursor.data) >= 8 and cursor.data[3] & 128)
    return TightTables(cursor) if tight else LooseTables(cursor, joined)


def squares_begin(cursor, tight, finest=False):
    """The tables of a level of squares, the bytes that it begins with, and the number of its ladder's rungs."""
    how = cursor.number(1)
    require(not how & 64 or how >> 7, f"{cursor.name}: a level of squares begins with {how}")
    more = cursor.number(1) if how & 64 else 0
    require(tight is None or how >> 7 == tight, f"{cursor.name}: a level of squares begins with {how}")
    require(how >> 7 or how & 7 < 7, f"{cursor.name}: strides of a part that is not tight")
    require(not how & 16 or (how >> 7 and finest), f"{cursor.name}: a ladder of a level that has none")
    rungs = cursor.number(2) + 1 if how & 16 else 0
    return TightTables(cursor, True) if how >> 7 else LooseTables(cursor, True), (how & 47, more), rungs


def quarters(cells, patch, before, tight):
    """The columns: those of the coarsest level, of quarters of levels 2 and 1, and of level 0. before: errors of the patch
    before, by level."""
    count = patch.counts[2]
    coarsest = (before[3] + cells[0]) & 255
    two = [((coarsest if q < count else 0) + cells[1 + q]) & 255 for q in range(4)]
    one = [(two[q] + cells[5 + q]) & 255 for q in range(4)]
    return [((before[0] if tight else max(one)) + cells[9]) & 255, max(one), max(two), coarsest], [one, two]


def finer(cells, before, drops=(0, 0, 0, 0)):
    """Turns cells of levels 3 to 0 into a list of levels 0 to 3."""
    out = []
    for cell, drop in zip(cells, drops):
        before = (before - drop + cell) & 255
        out.insert(0, before)
    return out


def middle_of(cells):
    """The centre of a patch's bound in a tight table."""
    turned = cells[0] & 65535
    x = (512 + (turned << 9 | turned >> 7)) & 65535
    return [x, (x + cells[1]) & 65535, (x + cells[1] + cells[2]) & 65535]


def origin_by_middles(patch, before, cells):
    n = [a + b for a, b in zip(integer_normal(patch.u, patch.v), integer_normal(before.u, before.v))] if before else [0, 0, 0]
    axes = axes_of(n) if before else (0, 1, 2)
    rise = 0
    for k, axis in enumerate(axes):
        o = place_before(before, patch.exponent, axis, before.bound[axis]) - patch.bound[axis] if before else 0
        if k == 2 and n[axis]:
            o -= trunc_div(rise * sign(n[axis]), abs(n[axis]))
        o = signed(o, 32) & ~7
        first, second = cells[2 * k:2 * k + 2]
        patch.origin[axis] = signed(o + 8 * first + (second >> 3 << 19) + (second & 7), 32)
        rise += n[axis] * signed(patch.origin[axis] - o, 32)


def unshifted(rows, errors, axes):
    """Rows of patches whose errors count 2^errors, and whose axes' codes count steps of a grid."""
    before = [0, 0]
    for row in map(list, rows):
        for c in (*range(14, 23), *range(24, 33)):
            row[c] <<= errors
        for i in range(2 if axes else 0):
            code = max(0, min((before[i] + (1 << axes >> 1) >> axes) + row[43 + i] << axes, 4095))
            row[43 + i], before[i] = code - before[i], code
        yield row


def patches_of(rows, linked, middles=0, tight=0, placed=None):
    """placed: what codec_squares.squares_of returns, if patches are placed by their squares; then origins are missing."""
    patches, before = [], Patch()
    if middles:
        before.bound = [512] * 3
    if tight:
        before.child = 255
    for cells in rows:
        p = Patch()
        p.exponent = signed(before.exponent + cells[0], 16)
        for i in range(0 if middles else 3):
            o = place_before(before, p.exponent, i, 0)
            p.origin[i] = signed(o + cells[1 + 2 * i] + 65536 * cells[2 + 2 * i], 32)
        p.child = (before.child + cells[7]) & 255
        p.flags = (before.flags + cells[8]) & 255
        most = bin(placed[len(patches)][2]).count("1") if placed else 64
        count = ((most if tight else before.counts[0]) + cells[9]) & 255
        require(1 <= count <= 64, f"a patch of {count} samples")
        p.counts = counts_of(count)
        p.radius = finer(cells[10:14], before.radius[3], (0, 15, 16, 11) if tight else (0, 0, 0, 0))
        p.error, p.quarter_error = quarters(cells[14:24], p, before.error, tight)
        p.tangential, p.quarter_tangential = quarters(cells[24:34], p, before.tangential, tight)
        p.colour = finer(cells[34:38], before.colour[3])
        p.bound = [(before.bound[i] + cells[38 + i]) & 65535 for i in range(3)]
        if tight:
            p.colour[0], p.bound = (before.colour[0] + cells[37]) & 255, middle_of(cells[38:41])
        p.bound_radius = (p.radius[3] + cells[41]) & 255
        p.cone_angle = (before.cone_angle + cells[42]) & 255
        p.u, p.v = (before.u + cells[43]) & 4095, (before.v + cells[44]) & 4095
        if middles and not placed:
            origin_by_middles(p, before if patches else None, cells[1:7])
        if linked:
            p.first_below = (cells[45] + (before.first_below + before.counts[0] if patches else 0)) & 65535
        patches.append(p)
        before = p
    return patches


def add_colour(sample, predicted, cells, with_green):
    """Turns columns 5 to 8 into green, red, blue and intensity."""
    green = (predicted[0] + cells[0]) & 255
    change = signed(green - predicted[0], 8) if with_green else 0
    sample.colour = [green, (predicted[1] + change + cells[1]) & 255,
                     (predicted[2] + change + cells[2]) & 255, (predicted[3] + cells[3]) & 255]


def add_normal(sample, predicted, cells, step):
    """Turns columns 3 and 4 into u and v."""
    if step > 1:
        sample.u, sample.v = (step_code(step_place(p, step) + cell, step) for p, cell in zip(predicted, cells))
    else:
        sample.u, sample.v = ((p + cell) & 4095 for p, cell in zip(predicted, cells))


def coarsest_level(rows, patches, step=1):
    samples, before = [], Sample()
    for patch, cells in zip(patches, rows):
        s = Sample((patch.radius[3] + cells[0]) & 255, (before.flags + cells[1]) & 255,
                   (before.class_id + cells[2]) & 255)
        add_normal(s, (patch.u, patch.v), cells[3:5], step)
        add_colour(s, before.colour, cells[5:9], True)
        for axis, cell in zip(axes_of(integer_normal(s.u, s.v)), cells[9:12]):
            s.position[axis] = (patch.bound[axis] + cell) & 65535
        samples.append(s)
        before = s
    return samples


class Turnings:
    """How normals change from place to place among the samples of one parent."""

    def __init__(self, samples):
        self.n = n = len(samples)
        normals = [unit_normal(s.u, s.v) for s in samples]
        total = [sum(c) for c in zip(*normals)]
        self.axes = axes_of(total)[:2]
        along = []
        for axis in self.axes:
            middle = sum(s.position[axis] for s in samples)
            along.append([n * s.position[axis] - middle for s in samples])
        self.s = 0
        while max(abs(d) for d in along[0] + along[1]) >= 1 << (12 + self.s):
            self.s += 1
        a, b = ([d >> self.s for d in line] for line in along)
        squares_a, squares_b = sum(x * x for x in a), sum(x * x for x in b)
        g = ((squares_a + squares_b) >> 4) + 1
        aa, bb, ab = squares_a + g, squares_b + g, sum(x * y for x, y in zip(a, b))
        determinant = float(aa * bb - ab * ab)
        self.slopes = []
        for c in range(3):
            e = [n * normal[c] - total[c] for normal in normals]
            ae, be = sum(x * y for x, y in zip(a, e)), sum(x * y for x, y in zip(b, e))
            self.slopes.append((math.trunc(float((ae * bb - be * ab) << 12) / determinant),
                                math.trunc(float((be * aa - ae * ab) << 12) / determinant)))

    def of(self, child, parent):
        o = [child.position[axis] - parent.position[axis] for axis in self.axes]
        turning = [(fa * o[0] + fb * o[1]) >> (12 + self.s) for fa, fb in self.slopes]
        return [min(max(t, -32767), 32767) for t in turning]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


class NormalsOfFamily:
    """Predicts the normals of a parent's children, one after the other."""

    def __init__(self, parent, weights, turnings):
        self.parent, self.weights, self.turnings = parent, weights, turnings
        self.p = unit_normal(parent.u, parent.v)
        self.s, self.q = [0, 0, 0], [0, 0, 0]

    def predict(self, e, child):
        code, weights, p, s = (self.parent.u, self.parent.v), self.weights, self.p, self.s
        if len(weights) == 1:
            return code
        if e == len(weights) - 1:
            t = dot(p, s) >> 14
            h = t + math.isqrt(max(0, t * t - dot(s, s) + (weights[e] << 14) ** 2))
            return direction_code([(h * p[c] >> 14) - s[c] for c in range(3)], code)
        turning, rest = self.turnings.of(child, self.parent), sum(weights[e:])
        d = [sum(weights) * p[c] - s[c] + self.q[c] + rest * turning[c] for c in range(3)]
        self.q = [q + weights[e] * t for q, t in zip(self.q, turning)]
        return direction_code(d, code)

    def add(self, e, child):
        self.s = [s + self.weights[e] * n for s, n in zip(self.s, unit_normal(child.u, child.v))]


def family(parent, children, rows, steps, scales, sublattice, turnings):
    """Fills all but the radii of a parent's children."""
    weights = weights_of([s.radius for s in children])
    n = integer_normal(parent.u, parent.v)
    a, b, c = axes_of(n)
    normals = NormalsOfFamily(parent, weights, turnings)
    for e, (child, cells, step, scale) in enumerate(zip(children, rows, steps, scales)):
        last, rest = e == len(children) - 1, sum(weights[e:])
        if isinstance(cells, Equal):
            cells.fill(child)
            normals.predict(e, child)
            normals.add(e, child)
            continue

        def left(what, i):
            value = getattr(parent, what)[i]
            total = sum(w * (value - getattr(s, what)[i]) for w, s in zip(weights[:e], children))
            return value + round_div(total, rest)

        child.flags = (parent.flags + cells[1]) & 255
        child.class_id = (parent.class_id + cells[2]) & 255
        add_colour(child, [left("colour", i) & 255 for i in range(4)], cells[5:9], not last)
        predicted = [left("position", i) & 65535 for i in range(3)]
        for done, axis, cell in zip(((), (a,)), (a, b), cells[9:11]):
            add_coordinate(child, axis, done, predicted[axis], cell, scale, sublattice)
        if not last:
            d_a, d_b = (child.position[axis] - predicted[axis] for axis in (a, b))
            slope = -(n[a] * d_a + n[b] * d_b)
            predicted[c] += round_div(slope * sign(n[c]), abs(n[c]))
        add_coordinate(child, c, (a, b), predicted[c], cells[11], scale, sublattice)
        add_normal(child, normals.predict(e, child), cells[3:5], step)
        normals.add(e, child)


def told_of(corners, patches, level, parents):
    """The rows of elder and of last children of a level that are told."""
    told, i = ([], []), 0
    for children, parent in zip((c for patch in patches for c in families(patch, level)), parents):
        for k in children:
            if not (corners and corners[i]):
                told[k == children[-1]].append(Row(children[-1] - k, parent.flags))
            i += 1
    return told


def finer_level(elder, last, patches, level, coarser, sublattices, corners):
    """The samples of a level; elder, last: tables of read_table; coarser: the samples of level + 1."""
    elder_rows, last_rows, out, begin = iter(elder.rows), iter(last.rows), [], 0
    for patch, number in zip(patches, sublattices or [0] * len(patches)):
        sublattice = Sublattice(number, patch.origin)
        elder_scale, last_scale = (t.scale and t.scale.of_patch(patch) for t in (elder, last))
        parents = coarser[begin:begin + patch.counts[level + 1]]
        begin += len(parents)
        ranges = families(patch, level)
        first = len(out)
        equals = corners[first:first + patch.counts[level]] or [None] * patch.counts[level]
        rows = [[Equal(equals[i], out, patch) if equals[i] else next(last_rows if i == children[-1] else elder_rows)
                 for i in children] for children in ranges]
        m = 16 * patch.radius[level]
        lasts = [k == len(children) - 1 for children in ranges for k in range(len(children))]
        for row, is_last in zip(sum(rows, []), lasts):
            grid = (last if is_last else elder).radii
            place = ((m + 8 >> 4) - 1 + (1 << grid >> 1) >> grid) + (0 if isinstance(row, Equal) else row[0])
            out.append(Sample(row.sample().radius if isinstance(row, Equal) else ((place << grid) + 1) & 255))
            m = (m + 16 * out[-1].radius) >> 1
        samples = out[first:]
        groups = [range(1)] if level == 2 else families(patch, level + 1)
        for group in groups:
            turnings = Turnings([parents[k] for k in group])
            for k in group:
                children = [samples[i] for i in ranges[k]]
                steps = [elder.step] * (len(children) - 1) + [last.step]
                scales = [elder_scale] * (len(children) - 1) + [last_scale]
                family(parents[k], children, rows[k], steps, scales, sublattice, turnings)
    return out


def read_rasters(cursor, count, tilted):
    return codec_squares.tilted_rasters(cursor, count) if tilted else codec_squares.level_raster(cursor)


def ladder_of(rows, name):
    """Heights, which grow, from their second differences."""
    out, step = [], 0
    for low, high in rows:
        step += low + 65536 * high
        out.append(signed((out[-1] if out else 0) + step, 32))
        require(len(out) < 2 or out[-1] > out[-2], f"{name}: a ladder that does not grow")
        step = step if len(out) > 1 else 0
    return out


def squares_of(tables, rasters, patch_count, name):
    """The squares whose table comes next."""
    rows = tables.read(patch_count, SQUARE_COLUMNS + (not rasters[0].level)).rows
    return codec_squares.squares_of(rasters, rows, name)


def decode(segments, patch_count, linked, name, joined=False):
    """Patches and samples of levels 0 to 3."""
    cursor = Cursor(segments[0], f"{name}, segment 0")
    rasters, how, rungs, kind, placed, shifts = None, None, 0, 0, 0, (0, 0)
    if joined and len(cursor.data) >= 4 and cursor.data[3] == 64:
        kind = cursor.number(4)
        require(kind & 3 << 6 != 3 << 6 and kind < 0x40000200, f"{cursor.name}: squares of kind {kind:x}")
        rasters, placed, shifts = read_rasters(cursor, patch_count, kind & 1), kind & 2, (kind >> 2 & 3, kind >> 4 & 15)
        tables, how, rungs = squares_begin(cursor, 1)
    else:
        tables = tables_of(cursor, joined)
    if placed:
        tables.placed = placed
    table = tables.read(patch_count, patch_columns(linked))
    if placed:
        places = squares_of(tables, rasters, patch_count, cursor.name)
    patches = patches_of(unshifted(table.rows, *shifts), linked, table.middles, table.tight, placed and places)
    if table.squares & 1:
        rasters = read_rasters(cursor, patch_count, table.squares >> 1)
    if rasters and not placed:
        places = squares_of(tables, rasters, patch_count, cursor.name)
    squares = codec_squares.Block(rasters, places, patches, cursor.name) if rasters else None
    if squares:
        squares.stops = bool(kind & 256)
    if placed:
        squares.place([row[1:7] for row in table.rows])
    coarsest = tables.read(patch_count, SAMPLE_COLUMNS)
    levels = [None, None, None, coarsest_level(coarsest.rows, patches, coarsest.step)]
    for level in (2, 1, 0):
        if level < 2:
            cursor = Cursor(segments[2 - level], f"{name}, segment {2 - level}")
            tables, how, rungs = (squares_begin(cursor, None, level == 0) if squares else
                                  (tables_of(cursor, joined), None, 0))
        elif isinstance(tables, LooseTables) and squares:
            how = squares_begin(cursor, 0)[1]
        tables.patch_count, corners = patch_count, []
        if level == 0 and isinstance(tables, TightTables) and has_corners(patches):
            corners = tables.read_corners(patches)
        told = told_of(corners, patches, level, levels[level + 1])
        ladder = ladder_of(tables.read(rungs, LADDER_COLUMNS).rows, cursor.name)
        both = [tables.read(len(rows), SAMPLE_COLUMNS, level, last, rows) for last, rows in enumerate(told)]
        levels[level] = (codec_squares.decode_level(squares, level, *how, levels[level + 1], both, ladder,
                                                    getattr(tables, "symbols", None)) if squares else
                         finer_level(*both, patches, level, levels[level + 1], getattr(tables, "sublattices", []), corners))
        tables.end()
    return patches, levels


def decode_block(segments, patch_count, linked, name):
    """A block's parts: some columns share streams."""
    return decode(segments, patch_count, linked, name, True)
