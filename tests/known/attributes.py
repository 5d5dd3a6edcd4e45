#!/usr/bin/env python3
"""Reads the attributes of a .stipple file by formats/SPEC.md alone, and prints them.

  attributes.py FILE [NAME...]

Prints a line for each point (level-0 sample of a leaf): its numbers as unsigned words of their type,
attribute by attribute in the order of the names, else of the file. If the file is wrong, a sentence on
stderr says why, and the exit code is 1."""

import json
import struct
import sys

sys.dont_write_bytecode = True

from codec_draco import read_column  # noqa: E402
from model import Cursor, Fault, families, require, signed  # noqa: E402
from read import Header, read_chunk, read_directory  # noqa: E402
from xxh3 import xxh3  # noqa: E402

BITS = {"u8": 8, "i8": 8, "u16": 16, "i16": 16, "u32": 32, "i32": 32, "u64": 64, "i64": 64, "f32": 32, "f64": 64}
WORD = (1 << 64) - 1
ROW, PAGE_ROWS = 56, 64


class Attribute:
    def __init__(self, facts):
        self.name, self.type = facts["name"], facts["type"]
        self.coarse, self.coarse_scale = facts.get("coarse"), facts.get("coarse_scale", 1.0)
        self.derived = facts.get("derived", False)
        require(self.type in BITS, f"{self.name}: type {self.type}")
        self.is_float = self.type[0] == "f"

    def guess(self, sample):
        green, red, blue, intensity = sample.colour
        field = {"red": red, "green": green, "blue": blue, "intensity": intensity}[self.coarse]
        return int(field * self.coarse_scale + 0.5)

    def of_decimal(self, whole, decimals):
        value = float(whole - (1 << 64) if whole >> 63 else whole) / 10.0 ** decimals
        return struct.unpack("<Q" if self.type == "f64" else "<I", struct.pack("<d" if self.type == "f64" else "<f", value))[0]


def read_head(cursor, attribute, name):
    how, pieces, decimals, base = struct.unpack("<BBBQ", cursor.take(11))
    groups, steps = [pieces], []
    if how == 4:
        count = cursor.number(1)
        require(1 <= count <= 2, f"{name}: {count} steps")
        for _ in range(count):
            step, pieces = struct.unpack("<dB", cursor.take(9))
            require(1 <= step <= 2.0 ** 40, f"{name}: a step of {step}")
            steps.append(step)
            groups.append(pieces)
    require(how <= 4 and max(groups) <= 4 and (decimals == 255 or (decimals <= 9 and attribute.is_float)),
            f"{name}: an unknown head")
    return how, groups, steps, decimals, base


def joined(parts, steps, name):
    """A difference of its parts."""
    value = parts[-1]
    for part, step in zip(parts[-2::-1], steps[::-1]):
        multiple = float(value) * step
        require(abs(multiple) < 2.0 ** 62, f"{name}: a step too many")
        value = signed(round(multiple) + part & WORD, 64)
    return value


def read_part(data, attribute, count, guesses, name):
    """The words of a part."""
    if count == 0:
        require(not data, f"{name}: bytes to spare")
        return []
    cursor = Cursor(data, name)
    how, groups, steps, decimals, base = read_head(cursor, attribute, name)
    which = read_column(cursor, count) if how in (2, 4) else None
    columns = [[read_column(cursor, count) for _ in range(pieces)] for pieces in groups]
    cursor.end()
    words, before, latest = [], base, [base] * 4
    for i in range(count):
        k = which[i] if which else 0
        require(0 <= k <= 4, f"{name}: an unknown sequence")
        predicted = (base, before, latest[k % 4], guesses[i] if how == 3 else None, latest[k % 4])[how]
        parts = [signed(sum(c[i] << 16 * p for p, c in enumerate(group)) & WORD, 64) for group in columns]
        word = predicted + joined(parts, steps, name) & WORD
        if which:
            del latest[k if k < 4 else 3]
            latest.insert(0, word)
        words.append(word)
        before = word
    return [attribute.of_decimal(w, decimals) for w in words] if decimals != 255 else words


def numbers_of(attribute, parts, patches, levels, name):
    """The words of all level-0 samples of a chunk."""
    above = None
    for level in (3, 2, 1, 0):
        at, lenders, stored = 0, [], []
        for p in patches:
            samples = levels[level][at:at + p.counts[level]]
            own = [None] * len(samples) # the parent that lends its number
            for j, children in enumerate(families(p, level) if level < 3 else ()):
                own[max(children, key=lambda k: (samples[k].radius, -k))] = j
            lenders.append(own)
            stored += [s for s, j in zip(samples, own) if j is None]
            at += p.counts[level]
        guesses = [attribute.guess(s) for s in stored] if attribute.coarse else None
        new = iter(read_part(parts[3 - level], attribute, len(stored), guesses, f"{name}, level {level}"))
        here, first = [], 0
        for p, own in zip(patches, lenders):
            here += [next(new) if j is None else above[first + j] for j in own]
            first += p.counts[level + 1] if level < 3 else 0
        above = here
    return above


class Table:
    """The section ATTR, and ATTD."""

    def __init__(self, data, header):
        places = {kind: (offset, size) for kind, offset, size in header.sections}
        require(b"ATTR" in places and b"ATTD" in places, "the file has no attributes")
        at, size = places[b"ATTR"]
        self.numbers, self.numbers_bytes = places[b"ATTD"]
        self.data, self.chunks = data, header.chunks
        length, zero, stored = struct.unpack_from("<IIQ", data, at)
        text = data[at + 16:at + 16 + length]
        require(zero == 0 and xxh3(text) == stored, "the list of attributes is damaged")
        self.attributes = [Attribute(a) for a in json.loads(text)]
        self.pages = at + 16 + length
        pages = (self.chunks + PAGE_ROWS - 1) // PAGE_ROWS
        self.page_bytes = self.chunks * ROW + 8 * pages
        require(16 + length + len(self.attributes) * self.page_bytes == size, "ATTR has another size")

    def parts(self, a, chunk):
        first = chunk - chunk % PAGE_ROWS
        rows = min(PAGE_ROWS, self.chunks - first)
        at = self.pages + a * self.page_bytes + first // PAGE_ROWS * (PAGE_ROWS * ROW + 8)
        page = self.data[at:at + rows * ROW]
        require(xxh3(page) == struct.unpack_from("<Q", self.data, at + rows * ROW)[0], "a page of ATTR is damaged")
        offset, *rest = struct.unpack_from("<Q4I4Q", page, (chunk - first) * ROW)
        out = []
        for size, stored in zip(rest[:4], rest[4:]):
            require(offset + size <= self.numbers_bytes, "a part lies outside ATTD")
            out.append(self.data[self.numbers + offset:self.numbers + offset + size])
            require(xxh3(out[-1]) == stored, f"chunk {chunk}: a part's checksum is wrong")
            offset += size
        return out


def print_file(path, names):
    with open(path, "rb") as file:
        data = file.read()
    header = Header(data)
    table = Table(data, header)
    known = [a.name for a in table.attributes]
    chosen = [known.index(name) for name in names] if names else range(len(known))
    for entry in read_directory(data, header):
        if entry.child_count > 0:
            continue
        patches, levels = read_chunk(data, header, entry)
        columns = []
        for a in chosen:
            attribute = table.attributes[a]
            columns.append([attribute.guess(s) for s in levels[0]] if attribute.derived else
                           numbers_of(attribute, table.parts(a, entry.id), patches, levels,
                                      f"chunk {entry.id}, {attribute.name}"))
        for row in zip(*columns):
            print(*(word & (1 << BITS[table.attributes[a].type]) - 1 for a, word in zip(chosen, row)))


def main():
    if len(sys.argv) < 2:
        sys.exit("usage: attributes.py FILE [NAME...]")
    try:
        print_file(sys.argv[1], sys.argv[2:])
    except (Fault, OSError, ValueError, KeyError, TypeError, IndexError, struct.error) as fault:
        print(f"attributes.py: {sys.argv[1]}: {fault}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
