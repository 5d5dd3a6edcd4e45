"""Shared by all codecs of SPEC.md: samples, patches, normals, weights, a cursor over bytes."""

import math
import struct

WEIGHTS = [max(1, round(1024 * 2 ** (-k / 8))) for k in range(77)]
PATCH = struct.Struct("<3ihBB4B4B4B4B4B3HB3sBB4B4B4B4B")
SAMPLE = struct.Struct("<3HBB3sB3BB")


class Fault(Exception):
    """A sentence that says what is wrong with the file."""


def require(condition, sentence):
    if not condition:
        raise Fault(sentence)


class Cursor:
    """Takes bytes one after the other."""

    def __init__(self, data, name):
        self.data, self.at, self.name = data, 0, name

    def take(self, count):
        require(0 <= count <= len(self.data) - self.at, f"{self.name}: ends too early")
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, count):
        return int.from_bytes(self.take(count), "little")

    def varint(self):
        value = shift = 0
        while True:
            byte = self.number(1)
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value
            require(shift < 64, f"{self.name}: a varint has no end")

    def end(self):
        require(self.at == len(self.data), f"{self.name}: {len(self.data) - self.at} bytes too many")


class Sample:
    """The 16 bytes by name; colour: green, red, blue, intensity; position: x, y, z."""

    __slots__ = ("radius", "flags", "class_id", "u", "v", "colour", "position")

    def __init__(self, radius=0, flags=0, class_id=0, u=0, v=0, colour=(0, 0, 0, 0), position=(0, 0, 0)):
        self.radius, self.flags, self.class_id, self.u, self.v = radius, flags, class_id, u, v
        self.colour, self.position = list(colour), list(position)

    @staticmethod
    def unpack(data):
        x, y, z, radius, flags, normal, class_id, r, g, b, i = SAMPLE.unpack(data)
        code = int.from_bytes(normal, "little")
        return Sample(radius, flags, class_id, code & 4095, code >> 12, (g, r, b, i), (x, y, z))

    def pack(self):
        g, r, b, i = self.colour
        normal = (self.u | self.v << 12).to_bytes(3, "little")
        return SAMPLE.pack(*self.position, self.radius, self.flags, normal, self.class_id, r, g, b, i)


class Patch:
    """The 64 bytes by name. Lists of levels begin with level 0; quarters are [level - 1][quarter]."""

    def __init__(self):
        self.origin, self.exponent, self.child, self.cone_angle = [0, 0, 0], 0, 0, 0
        self.counts, self.error, self.tangential, self.colour, self.radius = ([0] * 4 for _ in range(5))
        self.bound, self.bound_radius, self.u, self.v, self.flags = [0, 0, 0], 0, 0, 0, 0
        self.quarter_error, self.quarter_tangential = [[0] * 4, [0] * 4], [[0] * 4, [0] * 4]
        self.first_below = 0

    @staticmethod
    def unpack(data):
        p, f = Patch(), PATCH.unpack(data)
        p.origin, p.exponent, p.child, p.cone_angle = list(f[0:3]), f[3], f[4], f[5]
        p.counts, p.error, p.tangential = list(f[6:10]), list(f[10:14]), list(f[14:18])
        p.colour, p.radius, p.bound = list(f[18:22]), list(f[22:26]), list(f[26:29])
        p.bound_radius, p.flags = f[29], f[31]
        axis = int.from_bytes(f[30], "little")
        p.u, p.v = axis & 4095, axis >> 12
        p.quarter_error = [list(f[33:37]), list(f[37:41])]
        p.quarter_tangential = [list(f[41:45]), list(f[45:49])]
        require(f[32] == 0, "a patch's byte 47 is not zero")
        return p

    def pack(self):
        axis = (self.u | self.v << 12).to_bytes(3, "little")
        return PATCH.pack(*self.origin, self.exponent, self.child, self.cone_angle, *self.counts,
                          *self.error, *self.tangential, *self.colour, *self.radius, *self.bound,
                          self.bound_radius, axis, self.flags, 0, *self.quarter_error[0],
                          *self.quarter_error[1], *self.quarter_tangential[0],
                          *self.quarter_tangential[1])


def counts_of(level_0):
    counts = [level_0]
    for _ in range(3):
        counts.append((counts[-1] + 3) // 4)
    return counts


def families(patch, level):
    """For each sample of level + 1: the range of its children in the patch's level."""
    fine, coarse = patch.counts[level], patch.counts[level + 1]
    return [range(j * fine // coarse, (j + 1) * fine // coarse) for j in range(coarse)]


def signed(value, bits):
    """The number of least magnitude that equals the value modulo 2^bits."""
    value &= (1 << bits) - 1
    return value - (1 << bits) if value >> (bits - 1) else value


def unfold(value):
    return -(value + 1) // 2 if value & 1 else value // 2


def sign(x):
    return -1 if x < 0 else 1


def trunc_div(a, b):
    """a / b towards zero, b > 0."""
    return a // b if a >= 0 else -(-a // b)


def round_div(a, b):
    """a / b to nearest, halves away from zero, b > 0."""
    return sign(a) * ((2 * abs(a) + b) // (2 * b))


def integer_normal(u, v):
    x, y = 2 * u - 4095, 2 * v - 4095
    z = 4095 - abs(x) - abs(y)
    if z < 0:
        x, y = (4095 - abs(y)) * sign(x), (4095 - abs(x)) * sign(y)
    return x, y, z


def step_place(code, step):
    """The place on the grid of a step that is nearest to a code."""
    return (code - 2048 + (2047 // step + 1) * step + step // 2) // step


def step_code(place, step):
    return min(max(2048 + (max(place, 0) - 2047 // step - 1) * step, 0), 4095)


def unit_normal(u, v):
    """A vector of length 2^14."""
    n = integer_normal(u, v)
    r = math.isqrt(65536 * sum(c * c for c in n))
    return [(c * (2 ** 38 // r) + 32768) >> 16 for c in n]


def axes_of(n):
    """The axes A, B, C; C is the axis of the greatest component."""
    c = max(range(3), key=lambda i: abs(n[i]))
    return (c + 1) % 3, (c + 2) % 3, c


def direction_code(d, otherwise):
    length = sum(abs(c) for c in d)
    if length == 0:
        return otherwise
    x, y = d[0], d[1]
    if d[2] < 0:
        x, y = (length - abs(d[1])) * sign(d[0]), (length - abs(d[0])) * sign(d[1])
    return [trunc_div(4095 * (c + length) + length, 2 * length) for c in (x, y)]


def weights_of(radii):
    greatest = max(radii)
    return [WEIGHTS[min(greatest - r, len(WEIGHTS) - 1)] for r in radii]


def place_before(before, exponent, axis, steps):
    """The place so many steps from the origin of the patch before, on this lattice."""
    shift, o = before.exponent - exponent, before.origin[axis] + steps
    return 0 if abs(shift) > 30 else o << shift if shift >= 0 else trunc_div(o, 1 << -shift)
