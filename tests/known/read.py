#!/usr/bin/env python3
"""Reads a .stipple file by formats/SPEC.md alone, and prints its content.

  read.py FILE

Prints a line for each chunk, patch and sample. Patches and samples are printed as their bytes in
codec 0, whatever the codec of the file; a patch's samples follow it from level 3 to level 0. If the
file is wrong, a sentence on stderr says why, and the exit code is 1. Checks checksums, frame,
directory, tree, links and boxes; `stipple verify` checks more. Needs only Python 3, and the program
zstd for codecs 2 and 5."""

import json
import math
import struct
import sys

sys.dont_write_bytecode = True

import blocks  # noqa: E402
import codec_draco  # noqa: E402
import codec_raw  # noqa: E402
import codec_zstd  # noqa: E402
from model import Fault, counts_of, families, integer_normal, require  # noqa: E402
from xxh3 import xxh3  # noqa: E402

NONE = 2 ** 32 - 1
CODECS = (codec_raw, codec_draco, codec_zstd)
PAGE = 64


class Header:
    """The file's first bytes by name."""

    def __init__(self, data):
        require(len(data) >= 256 and data[:8] == b"STIPPLE\0", "no chunk file")
        self.major, self.minor, self.bytes, self.chunks, page, self.entry_bytes, self.depth = \
            struct.unpack_from("<HH5I", data, 8)
        require(1 <= self.major <= 2, f"version {self.major}.{self.minor} is unknown")
        require((256, 1024)[self.major - 1] <= self.bytes <= (65536, 1024)[self.major - 1] and self.bytes <= len(data),
                "the header's size is wrong")
        stored = struct.unpack_from("<Q", data, self.bytes - 8)[0]
        require(xxh3(data[:self.bytes - 8]) == stored, "the header's checksum is wrong")
        (self.directory, self.metadata, self.metadata_bytes, self.metadata_hash, self.points,
         self.attributes, self.orientation, self.scale) = struct.unpack_from("<5QIId", data, 32)
        self.box = struct.unpack_from("<6d", data, 88)
        root, zero, file_bytes = struct.unpack_from("<I4sQ", data, 136)
        require(self.chunks >= 1 and page == PAGE and 256 <= self.entry_bytes <= 4096 and root == 0 and
                1 <= self.depth <= 256, "the header's counts are wrong")
        self.sections, self.payloads, self.unused, rest = [], self.bytes, [], 152
        self.records, self.record = b"", (blocks.RECORD.size, blocks.Record)
        if self.major == 2:
            rest = self.read_sections(data)
        require(self.minor > (2, 1)[self.major - 1] or
                zero + data[rest:self.bytes - 8] == bytes(self.bytes - rest - 4),
                "the header's rest is not zero")
        require(file_bytes == len(data) or (self.major > 1 and file_bytes < len(data)), f"the file has {len(data)} bytes, expected {file_bytes}")
        require(self.metadata_bytes <= 2 ** 26 and
                self.metadata + self.metadata_bytes == self.directory, "the metadata's place is wrong")
        pages = (self.chunks + PAGE - 1) // PAGE
        require(self.directory + self.chunks * self.entry_bytes + 8 * pages == file_bytes,
                "the directory does not end the file")
        least = 2 if self.attributes & 192 else 1 if self.attributes & 48 else 0
        require(self.major > 1 or self.minor >= least, f"version 1.{self.minor} with attributes {self.attributes}")
        require(self.orientation <= 4 and math.isfinite(self.scale) and self.scale > 0 and
                all(math.isfinite(b) for b in self.box), "a number of the header is wrong")


    def read_sections(self, data):
        """Reads what version 2 adds to the header; returns where it ends."""
        require(data[:self.bytes] == data[self.bytes:2 * self.bytes], "the header's copies differ")
        self.payloads, self.unused = 2 * self.bytes, []
        self.generation, count = struct.unpack_from("<QI", data, 152)
        require(self.generation >= 1 and count <= 16, "the header's generation or sections are wrong")
        for i in range(count):
            kind, flags, offset, size, stored = struct.unpack_from("<4sIQQQ", data, 168 + 32 * i)
            require(not self.sections or offset == self.sections_end, "sections do not follow each other")
            require(xxh3(data[offset:offset + size]) == stored, f"section {kind}: the checksum is wrong")
            require(kind in (b"BLK2", b"BLK3", b"BLKS") or not flags & 1, f"section {kind} is needed and unknown")
            if kind == b"BLK3":
                self.records = blocks.unpack(data[offset:offset + size], flags >> 1)
            if kind in (b"BLK2", b"BLKS"):
                self.records = data[offset:offset + size]
            if kind == b"BLKS":
                self.record = blocks.WIDE_RECORD.size, blocks.WideRecord
            if kind == b"FREE":
                require(size % 16 == 0 and self.minor > 0, "the list of unused bytes is wrong")
                self.unused = list(struct.iter_unpack("<2Q", data[offset:offset + size]))
                require(all(bytes_ > 0 for _, bytes_ in self.unused), "an unused range is empty")
            self.sections.append((kind, offset, size))
            self.sections_end = offset + size
        require(not self.sections or self.sections_end == self.metadata,
                "sections do not end where the metadata begins")
        return 168 + 32 * count

    def payloads_end(self):
        return self.sections[0][1] if self.sections else self.metadata


class Entry:
    """A chunk as the directory describes it."""

    def __init__(self, data, number):
        self.id = number
        self.offset, *self.ends, self.parent = struct.unpack_from("<Q4I", data, 0)
        self.hashes = struct.unpack_from("<3Q", data, 24)
        (self.first_child, self.child_count, self.patches, *self.counts) = \
            struct.unpack_from("<7I", data, 48)
        self.codec, self.depth, self.flags, zero, self.points = struct.unpack_from("<4BQ", data, 76)
        self.origin = struct.unpack_from("<3d", data, 88)
        floats = struct.unpack_from("<24f", data, 112)
        self.box = floats[0:6]
        self.errors = floats[10:14], floats[14:18], floats[18:22]
        self.radii = floats[22:24]
        self.linked = self.flags >> 1 & 1
        self.first_block, self.blocks, self.blocks_hash = struct.unpack_from("<IIQ", data, 208)
        name = f"chunk {number}"
        require((self.blocks > 0) == (self.codec > 2), f"{name}: blocks and codec do not agree")
        require(all(math.isfinite(x) for x in self.origin + floats), f"{name}: a number is not finite")
        require(zero == 0 and self.flags < 8, f"{name}: reserved bits are set")
        require(self.ends == sorted(self.ends), f"{name}: segments are out of order")
        require((self.first_child == NONE) == (self.child_count == 0) and self.child_count <= 64,
                f"{name}: children are wrong")
        require(1 <= self.patches == self.counts[3] and max(self.counts) <= 65536,
                f"{name}: counts are wrong")
        require(self.codec < len(CODECS) + len(blocks.PARTS), f"{name}: codec {self.codec} is unknown")


def read_directory(data, header):
    entries = []
    for page in range(0, header.chunks, PAGE):
        at = header.directory + page * header.entry_bytes + 8 * (page // PAGE)
        count = min(PAGE, header.chunks - page)
        size = count * header.entry_bytes
        require(xxh3(data[at:at + size]) == struct.unpack_from("<Q", data, at + size)[0],
                f"directory page {page // PAGE}: the checksum is wrong")
        entries += [Entry(data[at + i * header.entry_bytes:], page + i) for i in range(count)]
    return entries


def check_tree(header, entries):
    following = 1
    for e in entries:
        require((e.parent == NONE) == (e.id == 0), f"chunk {e.id}: the parent is wrong")
        if e.child_count:
            require(e.first_child == following, f"chunk {e.id}: ids are not breadth first")
        following += e.child_count
        require(following <= len(entries), f"chunk {e.id}: children are beyond the directory")
        children = entries[e.first_child:e.first_child + e.child_count] if e.child_count else []
        require(all(c.parent == e.id and c.depth == e.depth + 1 for c in children),
                f"chunk {e.id}: children name another parent or depth")
        points = sum(c.points for c in children) if children else e.counts[0]
        require(points == e.points, f"chunk {e.id}: points_under does not add up")
    require(following == len(entries) and entries[0].depth == 0, "chunks are in no tree")
    require(max(e.depth for e in entries) + 1 == header.depth, "the tree's depth is wrong")
    require(entries[0].points == header.points, "point_count is not that of the leaves")
    at = header.payloads
    ranges = [(e.offset, e.ends[2], f"chunk {e.id}") for e in entries]
    ranges += [(offset, size, "unused bytes") for offset, size in header.unused]
    for offset, size, name in sorted(ranges):
        require(offset == at, f"{name}: a gap before, or an overlap")
        at += size
    require(at == header.payloads_end(), "payloads do not end where sections or metadata begin")
    records = 0
    for e in entries:
        require(e.blocks == 0 or e.first_block == records, f"chunk {e.id}: its records are out of order")
        records += e.blocks
    require(records * header.record[0] == len(header.records), "the table has more records than blocks")


def read_records(header, entry, name):
    size, record = header.record
    at = entry.first_block * size
    records = header.records[at:at + entry.blocks * size]
    require(xxh3(records) == entry.blocks_hash, f"{name}: the checksum of its records is wrong")
    return [record(records[i:i + size], entry.box, f"{name}, a record") for i in range(0, len(records), size)]


def read_chunk(data, header, entry):
    name, begin, segments = f"chunk {entry.id}", 0, []
    for i, end in enumerate(entry.ends):
        segments.append(data[entry.offset + begin:entry.offset + end])
        require(xxh3(segments[-1]) == entry.hashes[i], f"{name}, segment {i}: the checksum is wrong")
        begin = end
    entry.block_ends = [entry.patches]
    if entry.codec < len(CODECS):
        patches, levels = CODECS[entry.codec].decode(segments, entry.patches, entry.linked, name)
    else:
        patches, levels, entry.block_ends = blocks.read(
            segments, entry.codec, entry.linked, read_records(header, entry, name), name)
    require(len(patches) == entry.patches, f"{name}: {len(patches)} patches")
    for level in range(4):
        require(len(levels[level]) == entry.counts[level] == sum(p.counts[level] for p in patches),
                f"{name}: level {level} has other samples than the directory says")
    for k, p in enumerate(patches):
        require(p.counts == counts_of(p.counts[0]) and 1 <= p.counts[0] <= 64,
                f"{name}, patch {k}: counts are wrong")
        require(p.child < entry.child_count or (p.child == 255 and entry.child_count == 0),
                f"{name}, patch {k}: there is no child {p.child}")
        for what, quarters in ((p.error, p.quarter_error), (p.tangential, p.quarter_tangential)):
            require([max(q) for q in quarters] == what[1:3] and
                    not any(sum((q[p.counts[2]:] for q in quarters), [])),
                    f"{name}, patch {k}: errors of quarters are wrong")
    return patches, levels


def world(entry, patch, position):
    step = 2.0 ** patch.exponent
    return tuple(o + (b + p) * step for o, b, p in zip(entry.origin, patch.origin, position))


def unit(coded):
    """The normal of a sample, or the cone's axis of a patch."""
    n = integer_normal(coded.u, coded.v)
    return [c / math.hypot(*n) for c in n]


def radius_of(patch, code):
    return 2.0 ** (patch.exponent + (code - 1) / 16) if code else 0.0


def error_of(patch, code):
    return 2.0 ** (patch.exponent + (code - 1) / 8 - 8) if code else 0.0


def key(entry, patch, sample):
    """What a patch vertex of a child and its sample in the parent have in common."""
    radius = 16 * patch.exponent + sample.radius if sample.radius else -2 ** 16
    rest = sample.flags, sample.class_id, sample.u, sample.v, tuple(sample.colour)
    return world(entry, patch, sample.position), radius, rest


def vertices(entry, chunk):
    return [key(entry, p, s) for p, s in zip(chunk[0], chunk[1][3])]


def check_links(entries, chunks):
    """Checks that the level-0 samples of a parent are the children's patch vertices."""
    for e in entries:
        if e.child_count == 0:
            continue
        below = [vertices(entries[e.first_child + c], chunks[e.first_child + c])
                 for c in range(e.child_count)]
        named, begin = [[] for _ in below], 0
        for k, p in enumerate(chunks[e.id][0]):
            samples = [key(e, p, s) for s in chunks[e.id][1][0][begin:begin + p.counts[0]]]
            begin += p.counts[0]
            named[p.child] += samples
            first = p.first_below
            ends = entries[e.first_child + p.child].block_ends
            require(len(ends) == 1 or (e.linked and
                                       not any(first < end < first + p.counts[0] for end in ends)),
                    f"chunk {e.id}, patch {k}: it stands for patches of two blocks")
            require(not e.linked or below[p.child][first:first + p.counts[0]] == samples,
                    f"chunk {e.id}, patch {k}: not the vertices that it is linked with")
        require(all(sorted(a) == sorted(b) for a, b in zip(named, below)),
                f"chunk {e.id}: its samples are not the vertices of its children")


def check_patch(entry, patch, samples, name):
    """Checks that the entry holds the patch, and the patch its samples (lists of levels 0 to 3)."""
    for level in range(4):
        errors = (error_of(patch, patch.error[level]), error_of(patch, patch.tangential[level]),
                  patch.colour[level])
        require(all(e <= of[level] for e, of in zip(errors, entry.errors)),
                f"{name}: an error exceeds the chunk's")
        codes = [s.radius for s in samples[level]]
        require(max(codes) <= patch.radius[level], f"{name}: a radius exceeds the patch's")
        require(all(entry.radii[0] <= radius_of(patch, c) and
                    radius_of(patch, c) <= entry.radii[1] for c in codes),
                f"{name}: a radius is beyond the chunk's")
        bound = world(entry, patch, patch.bound)
        reach = radius_of(patch, patch.bound_radius)
        require(all(math.dist(world(entry, patch, s.position), bound) <= reach for s in samples[level]),
                f"{name}: a sample is outside the patch's bound")
    cosine = math.cos(min(math.pi, patch.cone_angle * math.pi / 255)) - 1e-6
    axis = unit(patch)
    require(all(sum(a * b for a, b in zip(axis, unit(s))) >= cosine for s in samples[0] if s.flags & 2),
            f"{name}: a normal is outside the cone")


def check_kinds(entry, patch, samples, name):
    """Checks the flags of a patch and of its samples. samples: lists of levels 0 to 3."""
    kinds = {s.flags >> 4 & 3 for s in samples[0]}
    strip, triangles, leaf = patch.flags & 2, patch.flags & 4, entry.child_count == 0
    require(patch.flags < 64 and (leaf or not patch.flags & 30), f"{name}: its flags are wrong")
    if strip:
        require(not triangles and kinds in ({1}, {2}), f"{name}: a strip of kinds {kinds}")
    elif triangles:
        count = len(samples[0])
        require(kinds == {3} and count % 3 == 0 and all(s.flags & 48 == 0 for s in sum(samples[1:], [])),
                f"{name}: triangles of kinds {kinds}")
    else:
        require(not leaf or kinds == {0}, f"{name}: a surface of kinds {kinds}")
    require(patch.flags & 1 or all(s.flags & 3 == 3 for s in samples[0]), f"{name}: is two-sided")
    require(not patch.flags & 32 or all(s.flags & 8 for s in samples[0]), f"{name}: is not closed")
    for level in range(3):
        for above, group in zip(samples[level + 1], families(patch, level)):
            flags = [samples[level][i].flags for i in group]
            require(all(bool(above.flags & bit) == all(f & bit for f in flags) for bit in (4, 8)),
                    f"{name}: a sample of level {level + 1} is marked otherwise than its children")
            require(above.flags >> 6 == min(f >> 6 for f in flags),
                    f"{name}: a sample of level {level + 1} has not the least fit of its children")


def check_closed(header, metadata):
    """Checks the grid of cubes outside if samples are closed. A file that was repaired or has grown may lack the grid."""
    if not header.attributes & 64 or ("closed" not in metadata and metadata.keys() & {"repaired", "grown"}):
        return
    require("closed" in metadata, "metadata: closed is missing")
    closed = metadata["closed"]
    cells = closed["cells"]
    require(closed["points"] >= 1 and closed["cell"] > 0 and len(closed["origin"]) == len(cells) == 3 and
            all(1 <= n <= 256 for n in cells), "metadata: the grid is wrong")
    require(sum(closed["outside"]) == math.prod(cells), "metadata: the runs do not fill the grid")
    require(len(closed.get("openings", [])) <= 128 and
            all(len(ball) == 4 for ball in closed.get("openings", [])), "metadata: openings are wrong")


def check_points(header, entries, chunks):
    """Checks that patches hold their samples, and that the header's box holds the points."""
    for e, (patches, levels) in zip(entries, chunks):
        samples = [iter(level) for level in levels]
        for k, p in enumerate(patches):
            own = [[next(samples[level]) for _ in range(p.counts[level])] for level in range(4)]
            check_patch(e, p, own, f"chunk {e.id}, patch {k}")
            check_kinds(e, p, own, f"chunk {e.id}, patch {k}")
            places = [world(e, p, s.position) for s in own[0]] if e.child_count == 0 else []
            require(all(header.box[i] <= place[i] <= header.box[3 + i]
                        for place in places for i in range(3)),
                    f"chunk {e.id}, patch {k}: a point is outside the file's box")


def lines_of_chunk(entry, chunk):
    patches, levels = chunk
    yield f"chunk {entry.id}"
    begin = [0] * 4
    for p in patches:
        yield f"patch {p.pack().hex()} {p.first_below if entry.linked else '-'}"
        for level in (3, 2, 1, 0):
            for s in levels[level][begin[level]:begin[level] + p.counts[level]]:
                yield f"{level} {s.pack().hex()}"
            begin[level] += p.counts[level]


def read_file(path):
    with open(path, "rb") as file:
        data = file.read()
    header = Header(data)
    metadata = data[header.metadata:header.metadata + header.metadata_bytes]
    require(xxh3(metadata) == header.metadata_hash, "the metadata's checksum is wrong")
    facts = json.loads(metadata.decode("utf-8"))
    require(isinstance(facts, dict), "the metadata is no JSON object")
    check_closed(header, facts)
    entries = read_directory(data, header)
    check_tree(header, entries)
    chunks = [read_chunk(data, header, e) for e in entries]
    check_links(entries, chunks)
    check_points(header, entries, chunks)
    print(f"version {header.major}.{header.minor} attributes {header.attributes} "
          f"chunks {header.chunks} points {header.points}")
    for e, chunk in zip(entries, chunks):
        print("\n".join(lines_of_chunk(e, chunk)))


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: read.py FILE")
    try:
        read_file(sys.argv[1])
    except (Fault, OSError, ValueError, KeyError, TypeError, IndexError, struct.error) as fault:
        print(f"read.py: {sys.argv[1]}: {fault}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
