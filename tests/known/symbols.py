"""Draco's coded symbols (bitstream 2.2 and later): bit lengths or values by rANS, after Draco's
bitstream specification."""

from model import require


class Rans:
    """One table of probabilities and the bytes coded with it."""

    def __init__(self, cursor, bits, most):
        self.precision = 1 << min(max(3 * bits // 2, 12), 20)
        frequencies, count = [], cursor.varint()
        require(count <= most, f"{cursor.name}: {count} symbols are too many")
        while len(frequencies) < count:
            byte = cursor.number(1)
            if byte & 3 == 3:  # a run of symbols that do not occur
                frequencies += [0] * ((byte >> 2) + 1)
                continue
            frequencies.append(byte >> 2 | cursor.number(byte & 3) << 6)
        require(len(frequencies) == count, f"{cursor.name}: a run of symbols is too long")
        require(sum(frequencies) == self.precision, f"{cursor.name}: the frequencies' sum is wrong")
        self.slots = [symbol for symbol, f in enumerate(frequencies) for _ in range(f)]
        self.frequencies, self.begins, begin = frequencies, [], 0
        for f in frequencies:
            self.begins.append(begin)
            begin += f
        self.data = cursor.take(cursor.varint())
        require(self.data, f"{cursor.name}: no coded bytes")
        size = (self.data[-1] >> 6) + 1
        require(size <= len(self.data), f"{cursor.name}: the coder's state is cut")
        self.end = len(self.data) - size
        state = int.from_bytes(self.data[self.end:], "little") & ((1 << (8 * size - 2)) - 1)
        self.state = state + 4 * self.precision

    def next(self):
        while self.state < 4 * self.precision and self.end > 0:
            self.end -= 1
            self.state = self.state << 8 | self.data[self.end]
        quotient, rest = divmod(self.state, self.precision)
        symbol = self.slots[rest]
        self.state = quotient * self.frequencies[symbol] + rest - self.begins[symbol]
        return symbol


class Bits:
    """Takes bits from bit 0 of the first byte on; the first bit taken is the lowest of a value."""

    def __init__(self, data, name):
        self.data, self.at, self.name = data, 0, name

    def take(self, count):
        require(self.at + count <= 8 * len(self.data), f"{self.name}: low bits end too early")
        byte, bit = divmod(self.at, 8)
        self.at += count
        value = int.from_bytes(self.data[byte:(self.at + 7) // 8], "little")
        return value >> bit & ((1 << count) - 1)

    def bytes_taken(self):
        return (self.at + 7) // 8


def read_symbols(cursor, count):
    """The numbers of a stream; the lowest bit of each symbol is the sign."""
    scheme = cursor.number(1)
    require(scheme in (0, 1), f"{cursor.name}: scheme {scheme} of symbols is unknown")
    if scheme == 0:
        lengths = Rans(cursor, 5, 33)
        bits = Bits(cursor.data[cursor.at:], cursor.name)
        symbols = [bits.take(lengths.next()) for _ in range(count)]
        cursor.take(bits.bytes_taken())
    else:
        length = cursor.number(1)
        require(1 <= length <= 18, f"{cursor.name}: a bit length of {length}")
        coder = Rans(cursor, length, 65536)
        symbols = [coder.next() for _ in range(count)]
    return [-((s + 1) // 2) if s & 1 else s // 2 for s in symbols]
