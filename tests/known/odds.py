"""Odds: columns of cells whose symbols have odds that follow from the cells before."""

from known_odds import SIGNED_COLUMNS
from model import require, signed

SYMBOLS, FAR, MOST, LANES, ALL = 32, 31, 15, 2, 1 << 15
NONE, SMALL, MIDDLE, LARGE = range(4)
# By size of the mean, then NONE, SMALL, MIDDLE, LARGE.
RATIOS = ((983, 737, 983, 1327), (2891, 2170, 2891, 3897), (5749, 4326, 5749, 7713),
          (11246, 8542, 11246, 14840), (20832, 16304, 20832, 26261), (33927, 28285, 33927, 39657),
          (46343, 41561, 46343, 50585))
# By columns of the table: of samples 12, of squares 10 or 11, of ladders 2, of patches all others.
KINDS = {12: (1, 2), 10: tuple(range(2, 10)), 11: tuple(range(2, 10)), 2: ()}
PATCH_KINDS = (7, 8)
BESIDE = {12: {4: 3, 6: 5, 7: 6, 10: 9, 11: 10}, 10: {1: 0}, 11: {1: 0}, 2: {1: 0}}
PATCH_ALONE = (0, 1, 9)
# Of patches by middles: the first means, by column.
PATCH_FIRST = (4, 13, 7, 13, 7, 11, 7, 0, 0, 11, 11, 12, 12, 12, 12, 11, 11, 11, 11, 9, 9, 9, 9, 13, 12, 11, 11, 11, 11,
               10, 10, 10, 10, 14, 11, 8, 9, 11, 19, 19, 19, 8, 12, 16, 16, 16)
# Tight tables: first means of patches, by column; and of samples, of levels 3 (0), of elder (1) and last (2) children.
TIGHT_PATCHES = (4, 14, 8, 15, 8, 10, 8, 0, 0, 12, 12, 9, 10, 8, 13, 11, 11, 11, 11, 10, 10, 10, 10, 4, 13, 11, 11, 11,
                 10, 10, 10, 10, 10, 13, 11, 9, 9, 12, 9, 3, 3, 9, 12, 17, 17, 16)
# The same of patches that are placed by their squares.
PLACED_PATCHES = TIGHT_PATCHES[:1] + (3, 8, 3, 8, 12, 8, 0, 0, 3) + TIGHT_PATCHES[10:]
TIGHT_SAMPLES = ((3, 0, 0, 4, 4, 13, 10, 10, 13, 3, 3, 3), (8, 0, 0, 11, 11, 9, 8, 8, 11, 13, 13, 10),
                 (8, 0, 0, 8, 8, 8, 8, 8, 8, 9, 9, 9))
# The same of ladders; of squares: their own table, and samples, by whether they are merged, then by whether last children.
TIGHT_LADDER = (12, 3)
TIGHT_OWN = (8, 8, 0, 0, 0, 0, 0, 0, 0, 0, 5)
TIGHT_SQUARES = (((7, 0, 0, 7, 7, 9, 8, 8, 8, 3, 3, 11), (7, 0, 0, 7, 7, 8, 8, 8, 8, 3, 3, 9)),
                 ((10, 0, 0, 12, 12, 9, 8, 8, 8, 6, 6, 12), (10, 0, 0, 12, 12, 8, 8, 8, 8, 6, 6, 9)))
# Columns of patches whose cells are not positive, and not negative, as a rule.
FALLING, RISING = (9, *range(15, 23), *range(25, 33), 35, 36), (2, 4, 6, 38, 41)


# In the byte of sizes: states that are not short.
LONG = 6
# Of B, among elder children, the odds that are known differ by how many siblings follow.
POSITION_B = 10


def is_sized(cursor, marks=(0, 1)):
    """Whether states of as many bytes as they need follow; mark 0: of known odds."""
    head = cursor.data[cursor.at:cursor.at + 4]
    if len(head) < 4 or head[3] >> 6 not in marks:
        return False
    return 1 <= head[3] & 7 <= 5 or head[3] & 7 == LONG and head[3] >> 6 == 0 and 1 <= head[3] >> 3 <= 5


class Symbols:
    """The symbols of a table, or of all tables of a tight part."""

    def __init__(self, cursor, tight=False):
        self.cursor, self.last = cursor, 1 << 31
        self.known = tight and is_sized(cursor, (0,))
        if tight and is_sized(cursor):
            first, sizes = cursor.take(3), cursor.number(1)
            more, second = (sizes & 7, (sizes >> 3 & 7) + 1) if sizes & 7 != LONG else (sizes >> 3, 3 + (sizes >> 3))
            self.last = 1 << 31 if sizes & 7 == LONG else 1 << 15
            first += cursor.take(more)
            self.states = [int.from_bytes(s, "little") for s in (first, cursor.take(second))]
        elif tight:
            self.states = [(cursor.number(4) & (1 << 31) - 1) << 32 | cursor.number(4), cursor.number(8)]
        else:
            self.states = [cursor.number(8) for _ in range(LANES)]
        self.how = [0, 3 << 13, 15 << 11] + [ALL - 4 * (SYMBOLS - s) for s in range(3, SYMBOLS)]

    def bits(self, lane, count):
        state = self.states[lane]
        self.states[lane] = self.refilled(state >> count)
        return state & (1 << count) - 1

    def refilled(self, state):
        if state >= 1 << 31 or self.last == 1 << 15 and self.cursor.at == len(self.cursor.data):
            return state
        return state << 32 | self.cursor.number(4)

    def symbol(self, lane, odds, shift, count):
        """A symbol, and the plain bits behind it."""
        state = self.states[lane]
        place = state & ALL - 1
        symbol = max(s for s in range(SYMBOLS) if odds[s] <= place)
        end = odds[symbol + 1] if symbol + 1 < SYMBOLS else ALL
        state = (end - odds[symbol]) * (state >> 15) + place - odds[symbol]
        self.states[lane] = self.refilled(state >> count)
        for s in range(SYMBOLS):
            odds[s] += ((s if s <= symbol else ALL - SYMBOLS + s) - odds[s]) >> shift
        return symbol, state & (1 << count) - 1

    def end(self):
        self.cursor.end()
        require(self.states == [self.last] * LANES, f"{self.cursor.name}: the symbols do not end")


def falling_odds(ratio, side):
    weights = [4096]
    for _ in range(MOST + 1):
        weights.append(weights[-1] * ratio >> 16)
    below, above = ([w >> 5 * (side == wrong) for w in weights[1:MOST + 1]] for wrong in (1, -1))
    weights = below[::-1] + weights[:1] + above + weights[MOST + 1:]
    return [sum(weights[:s]) * (ALL - 4 * SYMBOLS) // sum(weights) + 4 * s for s in range(SYMBOLS)]


class Numbers:
    """A column of numbers."""

    def __init__(self, lane, first, beside, side=0):
        self.lane, self.mean, self.beside, self.size, self.cells, self.highs = lane, 1 << first, beside, NONE, [], []
        self.odds = [[falling_odds(ratio, side) for ratio in row] for row in RATIOS]

    def odds_of(self, size, _row):
        return self.odds[size][self.beside.size if self.beside else NONE]

    def read(self, symbols, row, shift, mean=None, bits=16):
        """The next cell, modulo 2^bits. mean: in place of the column's."""
        length = (self.mean if mean is None else mean).bit_length()
        low = max(length - 10, 0)
        odds = self.odds_of(min(max(length, 4), 10) - 4, row)
        symbol, plain = symbols.symbol(self.lane, odds, shift, low)
        high = symbol - MOST
        if symbol == FAR:
            head = symbols.bits(self.lane, 5)
            high = MOST + (1 << (head >> 1)) + symbols.bits(self.lane, head >> 1)
            high = -high if head & 1 else high
        cell = signed((high << low) + plain - (1 << low >> 1), bits)
        self.highs.append(high)
        self.size = SMALL if high == 0 else MIDDLE if abs(high) < 3 else LARGE
        self.mean += 32 * abs(cell) - (self.mean >> 3)
        self.cells.append(cell)
        return cell


class KnownNumbers(Numbers):
    """A column of numbers whose odds are known."""

    def __init__(self, lane, first, beside, odds, is_b):
        self.lane, self.mean, self.beside, self.size, self.cells, self.highs = lane, 1 << first, beside, NONE, [], []
        self.odds, self.is_b = odds, is_b

    def odds_of(self, size, row):
        if not self.beside:
            return self.odds[4 * size + row.left]
        return self.odds[4 * size + self.beside.size + (3 * (row.left - 1) if self.is_b and row.left else 0)]


def side_of(high):
    return 2 + (high > 0) + (high > 2) - (high < 0) - (high < -2)


class SignedNumbers(Numbers):
    """A column of numbers whose odds go by signed cells; paired: and by the column beside; learns: and change."""

    def __init__(self, lane, first, beside, odds, paired, learns):
        self.lane, self.mean, self.beside, self.size, self.cells, self.highs = lane, 1 << first, beside, NONE, [], []
        self.odds, self.paired, self.learns = odds, paired, learns
        self.highs.append(0)

    def odds_of(self, size, row):
        odds = self.odds[self.place(size, row)]
        return odds if self.learns else list(odds)

    def place(self, size, row):
        elder = side_of(self.highs[-1])
        if not self.paired:
            return 13 * size + (0, 7, 1, 0)[row.left] + (1 + elder if row.has_elder else 0)
        before, beside = self.beside.highs[-2:] if self.beside else (0, 0)
        sign = 1 + (elder > 1) + (elder > 2) + 3 * (before < 0) if row.has_elder else 0
        return 7 * (5 * size + side_of(beside)) + sign


class Kinds:
    """A column of kinds: flags, classes, children."""

    size = NONE

    def __init__(self, lane, step=512):
        self.lane, self.before, self.cells = lane, 0, []
        odds = [0] + [ALL - step * (17 - s) for s in range(1, 16)] + [ALL - 4 * (SYMBOLS - s) for s in range(16, SYMBOLS)]
        self.upper, self.lower = [list(odds) for _ in range(16)], [list(odds) for _ in range(4)]

    def odds_of(self, _row):
        return self.upper[self.before >> 4], self.lower

    def read(self, symbols, row, shift):
        odds, lower = self.odds_of(row)
        upper = symbols.symbol(self.lane, odds, shift, 0)[0] & 15
        odds = lower[2 * (upper != 0) + (self.before & 15 != 0)]
        self.before = upper << 4 | symbols.symbol(self.lane, odds, shift, 0)[0] & 15
        self.cells.append(signed(self.before, 8))


class KnownKinds(Kinds):
    """A column of kinds whose odds are known."""

    def __init__(self, lane, odds):
        self.lane, self.before, self.cells, self.upper, self.lower = lane, 0, [], odds[:16], odds[16:24]

    def odds_of(self, row):
        upper = self.before >> 4 if row is NO_PARENT else self.before >> 6 | 4 * row.fit
        return self.upper[upper], self.lower[4 * row.closed:]


class Row:
    """What is known of a row: how many siblings follow, the parent's fit, and whether the parent is closed."""

    has_elder = False

    def __init__(self, left=0, flags=0):
        self.left, self.fit, self.closed = left, flags >> 6, flags >> 3 & 1


NO_PARENT = Row()


def beside_of(column, columns):
    """The column beside one of a table."""
    if columns in BESIDE:
        return BESIDE[columns].get(column)
    return None if column in PATCH_ALONE else column - 1


def tight_column(lane, c, columns, table, firsts, known, signed_level):
    kinds = KINDS.get(columns, PATCH_KINDS)
    if signed_level is not None and c in SIGNED_COLUMNS:
        beside = table.get(beside_of(c, columns))
        return SignedNumbers(lane, firsts[c], beside, known.signed(signed_level, c), c in BESIDE[columns],
                             signed_level == 0)
    if known:
        beside, is_b = table.get(beside_of(c, columns)), columns == 12 and c == POSITION_B
        return KnownKinds(lane, known.cells(c)) if c in kinds else KnownNumbers(lane, firsts[c], beside, known.cells(c), is_b)
    side = (c in RISING) - (c in FALLING) if columns not in KINDS else 0
    return Kinds(lane, 128) if c in kinds else Numbers(lane, firsts[c], table.get(beside_of(c, columns)), side)


def read_rows(symbols, rows, table, firsts, known=False, kinds=()):
    """Reads all cells. firsts: None, or the first means that row 0 leaves as they are; kinds: of rows, if they are known."""
    for row in range(rows):
        for c, column in table.items():
            shift = 6 + (row >= 64) if known else 5 + (row >= 64) + (row >= 256)
            column.read(symbols, kinds[row] if kinds else NO_PARENT, shift)
            if firsts and row == 0:
                column.mean = 1 << firsts[c]
    return {c: column.cells for c, column in table.items()}


def tight_columns(symbols, rows, columns, coded, firsts, known=None, kinds=(), signed_level=None):
    """The cells of the columns `coded` of a tight table; signed_level: the level, if odds go by signed cells."""
    for before, row in zip(kinds, kinds[1:]):
        row.has_elder = before.left == row.left + 1
    table = {}
    for i, c in enumerate(coded):
        table[c] = tight_column(i % LANES, c, columns, table, firsts, known, signed_level)
    return read_rows(symbols, rows, table, firsts, known, kinds)


def read_columns(cursor, rows, columns, same, middles, tight):
    """The cells of each column that is not in `same`; takes the rest of the cursor. middles, tight: of patches."""
    kinds = KINDS.get(columns, PATCH_KINDS)
    coded = [c for c in range(columns) if c not in same]
    if not coded:
        return {}
    if tight:
        symbols = Symbols(cursor)
        cells = tight_columns(symbols, rows, columns, coded, TIGHT_PATCHES)
        symbols.end()
        return cells
    table = {}
    for lane, c in enumerate(coded):
        if c in kinds:
            table[c] = Kinds(lane % LANES)
            continue
        first = PATCH_FIRST[c] if middles else cursor.number(1)
        require(first <= 23, f"{cursor.name}: the first mean of a column is 2^{first}")
        table[c] = Numbers(lane % LANES, first, table.get(beside_of(c, columns)))
    symbols = Symbols(cursor)
    cells = read_rows(symbols, rows, table, PATCH_FIRST if middles else None)
    symbols.end()
    return cells
