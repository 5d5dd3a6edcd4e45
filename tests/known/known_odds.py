"""The curves that known odds begin with, by table and column."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "formats/chunk/codec/odds"
PATCH_COLUMNS, SAMPLE_COLUMNS = 46, 12
HOW, COUNT = 34, 36


def runs(name, length):
    numbers = [int(n) for n in (FOLDER / name).read_text().replace(",", " ").split()]
    return [numbers[i:i + length] for i in range(0, len(numbers), length)]


CURVES, COLUMNS, OF_SQUARES, SIGNED_CURVES, SIGNED = (runs(*n) for n in (("known_curves.inc", 32), ("known_columns.inc", COUNT),
                                                  ("known_squares.inc", COUNT), ("signed_curves.inc", 32),
                                                  ("signed_columns.inc", 1099)))
# By signed cells: the columns, and how many odds each has, by whether one is beside it.
SIGNED_COLUMNS = {0: 91, 3: 91, 4: 245, 5: 91, 6: 245, 7: 245, 9: 91}
# In the list of squares, behind the tables that points have, too: by columns of a table, and colours by rows.
OTHERS = {10: 0, 11: 0, 2: 11}
COLOURS = 13


class Known:
    """The columns of a table; columns: 3 of colours by rows, where last is 2 of last children by parents."""

    def __init__(self, columns, level, last, squares=False):
        samples, behind = 0 if level is None else 1 + 2 * (2 - level) + last, PATCH_COLUMNS + 7 * SAMPLE_COLUMNS
        self.columns, self.first = OF_SQUARES if squares else COLUMNS, 0
        if columns == SAMPLE_COLUMNS:
            self.first = PATCH_COLUMNS + SAMPLE_COLUMNS * samples
        elif columns in OTHERS:
            self.first = behind + OTHERS[columns]
        elif columns == 3:
            self.first = behind + COLOURS + 3 * last

    def odds(self, column, place):
        return list(CURVES[self.columns[self.first + column][place]])

    def how(self, column, before_varies):
        return self.odds(column, HOW + (not before_varies))

    @staticmethod
    def signed(level, column):
        begin = sum(width for c, width in SIGNED_COLUMNS.items() if c < column)
        return [list(SIGNED_CURVES[curve]) for curve in SIGNED[2 - level][begin:begin + SIGNED_COLUMNS[column]]]

    def cells(self, column):
        return [self.odds(column, place) for place in range(HOW)]
