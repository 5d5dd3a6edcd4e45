"""Codec 0: patches and samples as they are."""

from model import Cursor, Patch, Sample


def decode(segments, patch_count, linked, name):
    """Patches and samples of levels 0 to 3."""
    cursor = Cursor(segments[0], f"{name}, segment 0")
    patches, levels = [], [None] * 4
    for _ in range(patch_count):
        patches.append(Patch.unpack(cursor.take(64)))
        patches[-1].first_below = cursor.number(2) if linked else 0
    for level in (3, 2, 1, 0):
        if level < 2:
            cursor = Cursor(segments[2 - level], f"{name}, segment {2 - level}")
        count = sum(p.counts[level] for p in patches)
        levels[level] = [Sample.unpack(cursor.take(16)) for _ in range(count)]
        if level < 3:
            cursor.end()
    return patches, levels
