"""The curves that known odds begin with, by table and column."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "formats/chunk/codec/odds"
PATCH_COLUMNS, SAMPLE_COLUMNS = 46, 12
HOW, COUNT = 34, 36


def runs(name, length):
    numbers = [int(n) for n in (FOLDER / name).read_text().replace(",", " ").split()]
    return [numbers[i:i + length] for i in range(0, len(numbers), length)]


CURVES, COLUMNS = runs("known_curves.inc", 32), runs("known_columns.inc", COUNT)


class Known:
    """The columns of a table."""

    def __init__(self, columns, level, last):
        samples = 0 if level is None else 1 + 2 * (2 - level) + last
        self.first = PATCH_COLUMNS + SAMPLE_COLUMNS * samples if columns == SAMPLE_COLUMNS else 0

    def odds(self, column, place):
        return list(CURVES[COLUMNS[self.first + column][place]])

    def how(self, column, before_varies):
        return self.odds(column, HOW + (not before_varies))

    def cells(self, column):
        return [self.odds(column, place) for place in range(HOW)]
