"""Corners of triangles that a block has told before."""

from model import Sample, require

TRIANGLES = 4
FIRST_ODDS = ((31, 91, 13, 89, 10), (186, 1, 11, 3, 12), (4, 1, 248, 1, 1), (30, 1, 1, 26, 156), (2, 1, 250, 1, 1),
              (46, 1, 2, 1, 92), (174, 1, 1, 13, 5), (226, 1, 1, 1, 1))


def odds_of(firsts):
    below = [128 * sum(firsts[:s]) for s in range(6)]
    return below + [below[5] + s * ((1 << 15) - below[5]) // 27 for s in range(1, 27)]


def read_corners(symbols, patches, name):
    """By sample of level 0: the sample that it equals, and that one's patch; None if it is told."""
    odds, out, recent = [odds_of(firsts) for firsts in FIRST_ODDS], [], []
    for patch in patches:
        agos = []
        for i in range(patch.counts[0]):
            if not patch.flags & TRIANGLES:
                out.append(None)
                continue
            one, two = agos[-1] if i % 3 else 0, agos[-2] if i % 3 == 2 else 0
            ago = symbols.symbol(0, odds[(0, 1 + min(one, 4), 7 if one and two else 6)[i % 3]], 5, 0)[0]
            if ago > 15:
                ago = 15 + (1 << ago - 16) + symbols.bits(0, ago - 16)
            require(ago <= len(recent), f"{name}: a corner that was never told")
            agos.append(ago)
            equal = recent.pop(ago - 1) if ago else None
            recent.insert(0, (len(out), patch))
            out.append(equal)
    return out


def has_corners(patches):
    return any(patch.flags & TRIANGLES for patch in patches)


class Equal:
    """A corner that is told before: sample and patch, among the samples so far; its own patch."""

    def __init__(self, corner, samples, patch):
        self.at, self.before = corner
        self.samples, self.patch = samples, patch

    def sample(self):
        """That sample, on the lattice of the corner's own patch."""
        s, shift = self.samples[self.at], self.before.exponent - self.patch.exponent
        radius = (s.radius + 16 * shift) & 255 if s.radius else 0
        out = Sample(radius, s.flags, s.class_id, s.u, s.v, s.colour)
        for axis in range(3):
            at = self.before.origin[axis] + s.position[axis]
            at = 0 if abs(shift) > 30 else at << shift if shift >= 0 else at >> -shift
            out.position[axis] = (at - self.patch.origin[axis]) & 65535
        return out

    def fill(self, child):
        for name, value in ((name, getattr(self.sample(), name)) for name in Sample.__slots__):
            setattr(child, name, value)
