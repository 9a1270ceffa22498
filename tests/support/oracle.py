# SPDX-License-Identifier: MIT
"""An independent model of libntp's arithmetic, for tests.

Written from the definitions (docs/arithmetic.md), not from the C code.  Every rule is written here
twice: once for one texel in Python integers and fractions, where a stored level is found by
searching for the one that satisfies the rule's inequality, and once for whole arrays in numpy
integers.  test_oracle.py compares the two with each other and with the published counts.

A texel is (r, g, b) in levels 0..M.  `zz` is true where blue is Z-zero (b/M).
"""

import functools
import math
from fractions import Fraction

import numpy as np

# ---------------------------------------------------------------------------- one texel


def encode(v, m):
    """The level of a component v (a Fraction) in -1..1: round half up, clamped."""
    return min(max(math.floor((v + 1) / 2 * m + Fraction(1, 2)), 0), m)


def encode_zzero(v, m):
    """The level of a Z-zero component v in 0..1."""
    return min(max(math.floor(v * m + Fraction(1, 2)), 0), m)


def radicand(r, g, m):
    """S = M*M - X*X - Y*Y: negative where x, y are longer than 1."""
    return m * m - (2 * r - m) ** 2 - (2 * g - m) ** 2


def _greatest(low, high, holds):
    """The greatest integer in low..high for which a monotone predicate holds."""
    while low < high:
        middle = (low + high + 1) // 2
        if holds(middle):
            low = middle
        else:
            high = middle - 1
    return low


def derived_blue(r, g, m, zz=False):
    """The level nearest to sqrt(1 - x*x - y*y)."""
    s = radicand(r, g, m)
    assert s >= 0
    if zz:  # b - 1/2 <= sqrt(S)
        return _greatest(0, m, lambda b: b == 0 or (2 * b - 1) ** 2 <= 4 * s)
    # (2b - M) - 1 <= sqrt(S)
    return _greatest((m + 1) // 2, m, lambda b: (2 * b - m - 1) ** 2 <= s)


def pull(r, g, m):
    """(r, g) moved onto the unit disc, as the definitions say; itself when inside."""
    if radicand(r, g, m) >= 0:
        return r, g
    x, y = 2 * r - m, 2 * g - m
    ax, ay = abs(x), abs(y)
    n = ax * ax + ay * ay

    def odd_below(a):  # the greatest odd o, -1 included, with o <= M*a/sqrt(n)
        return 2 * _greatest(0, m, lambda k: k == 0 or (2 * k - 1) ** 2 * n <= (m * a) ** 2) - 1

    ox, oy = odd_below(ax), odd_below(ay)
    if ax == ay:
        px, py = ox, oy
    else:
        corners = [(ox + i, oy + j) for i in (0, 2) for j in (0, 2)]
        inside = [c for c in corners if c[0] ** 2 + c[1] ** 2 <= m * m]
        scores = sorted((c[0] * ax + c[1] * ay, c) for c in inside)
        assert len(scores) < 2 or scores[-1][0] > scores[-2][0], "a tie"
        px, py = scores[-1][1]
    return (m + (px if x > 0 else -px)) // 2, (m + (py if y > 0 else -py)) // 2


def exact(r, g, b, m, zz=False, either_sign=False):
    if radicand(r, g, m) < 0:
        return False
    want = derived_blue(r, g, m, zz)
    return b == want or (either_sign and not zz and b == m - want)


def rounded(r, g, b, m, zz=False):
    """Does the box of half a level around the texel meet the unit sphere?"""
    return _box_meets_sphere(r, g, b, m, zz, Fraction(1, 2))


def neighbor(r, g, b, m, zz=False):
    """Among the 27 triplets one has length <= 1 and one has length >= 1."""
    steps = (-1, 0, 1)
    lengths = [
        (2 * (r + i) - m) ** 2 + (2 * (g + j) - m) ** 2 + ((b + k) if zz else 2 * (b + k) - m) ** 2
        for i in steps
        for j in steps
        for k in steps
    ]
    return min(lengths) <= m * m <= max(lengths)


def _box_meets_sphere(r, g, b, m, zz, half):
    low = high = Fraction(0)
    for c, zero in ((r, False), (g, False), (b, zz)):
        ends = [(c + s * half) / m if zero else (2 * (c + s * half) - m) / m for s in (-1, 1)]
        low += 0 if ends[0] <= 0 <= ends[1] else min(abs(e) for e in ends) ** 2
        high += max(abs(e) for e in ends) ** 2
    return low <= 1 <= high


def z_negative(b, m, zz=False):
    return not zz and b <= (m - 1) // 2


def levels_off(r, g, b, m, zz=False):
    """|b - derived|, mirrored where Z < 0; -1 where x, y are too long."""
    if radicand(r, g, m) < 0:
        return -1
    want = derived_blue(r, g, m, zz)
    if z_negative(b, m, zz):
        want = m - want
    return abs(b - want)


def normalized(r, g, b, m, zz=False):
    """The texel divided by its length, each channel correctly rounded."""
    v = [2 * r - m, 2 * g - m, b if zz else 2 * b - m]
    n = sum(c * c for c in v)

    def level(c, zero):
        c2 = c * c * m * m

        def low_enough(
            k,
        ):  # the rounding boundary below level k is not above c*M/sqrt(n)
            edge = Fraction(2 * k - 1, 2) if zero else Fraction(2 * k - m - 1)
            if edge < 0 or c < 0:
                if edge <= 0 <= c:
                    return True
                if edge >= 0 > c:
                    return False
                return edge * edge * n >= c2  # both negative
            return edge * edge * n <= c2

        return _greatest(0, m, low_enough)

    return level(v[0], False), level(v[1], False), level(v[2], zz)


def cleaned(r, g, b, m, zz=False, method="derive", keep=False):
    """What cleaning makes of one used texel."""
    if not keep and z_negative(b, m, zz):
        b = m - b
    if method == "keep":
        return r, g, b
    if method == "normalize":
        return (r, g, b) if rounded(r, g, b, m, zz) else normalized(r, g, b, m, zz)
    r, g = pull(r, g, m)
    blue = derived_blue(r, g, m, zz)
    return r, g, m - blue if z_negative(b, m, zz) else blue


def vector(texel, m, zz=False):
    r, g, b = texel
    return (2 * r - m) / m, (2 * g - m) / m, b / m if zz else (2 * b - m) / m


def angle(a, b):
    """Degrees between two vectors of floats."""
    cross = math.sqrt(
        (a[1] * b[2] - a[2] * b[1]) ** 2
        + (a[2] * b[0] - a[0] * b[2]) ** 2
        + (a[0] * b[1] - a[1] * b[0]) ** 2
    )
    return math.degrees(math.atan2(cross, sum(x * y for x, y in zip(a, b))))


# --------------------------------------------------------------------------- many texels


def isqrt(s):
    """floor(sqrt(s)) of an array of non-negative integers below 2**53, exactly."""
    root = np.sqrt(np.asarray(s, np.float64)).astype(np.int64)
    root -= root * root > s
    root += (root + 1) * (root + 1) <= s
    return root


def radicands(r, g, m):
    x, y = 2 * np.asarray(r, np.int64) - m, 2 * np.asarray(g, np.int64) - m
    return m * m - x * x - y * y


def derived_blues(r, g, m, zz=False):
    """Derived blue; meaningless where x, y are too long."""
    s = np.maximum(radicands(r, g, m), 0)
    return (isqrt(4 * s) + 1) // 2 if zz else (isqrt(s) + m + 1) // 2


def pulled(r, g, m):
    """Arrays (r, g) moved onto the unit disc."""
    x, y = np.broadcast_arrays(2 * np.asarray(r, np.int64) - m, 2 * np.asarray(g, np.int64) - m)
    ax, ay = np.abs(x), np.abs(y)
    n = ax * ax + ay * ay
    over = n > m * m

    def odd_below(a):  # from the real projection, then put right by exact comparison
        o = (m * a / np.sqrt(n)).astype(np.int64)
        o -= 1 - (o & 1)
        o = np.where(_squares_over(o + 2, n, m, a), o, o + 2)
        return np.where((o > 0) & _squares_over(o, n, m, a), o - 2, o)

    ox, oy = odd_below(ax), odd_below(ay)
    best = np.full(n.shape, -1, np.int64)
    px, py = ox.copy(), oy.copy()
    for i in (0, 2):
        for j in (0, 2):
            cx, cy = ox + i, oy + j
            score = np.where(cx * cx + cy * cy <= m * m, cx * ax + cy * ay, -1)
            better = score > best
            best = np.where(better, score, best)
            px, py = np.where(better, cx, px), np.where(better, cy, py)
    even = ax == ay
    px, py = np.where(even, ox, px), np.where(even, oy, py)
    px, py = np.where(over, np.sign(x) * px, x), np.where(over, np.sign(y) * py, y)
    return (px + m) // 2, (py + m) // 2


def _squares_over(o, n, m, a):
    """o*o*n > (m*a)**2 for o >= 0, without overflow: cross-divided with remainders."""
    if m == 255:
        return o * o * n > (m * a) ** 2
    # o*sqrt(n) against m*a: decided in floats unless within a margin, then in Python integers
    left, right = o * np.sqrt(n), np.asarray(m * a, np.float64)
    result = left > right
    for index in np.flatnonzero(np.abs(left - right) <= right * 1e-12):
        oo, nn, aa = (int(np.ravel(v)[index]) for v in (o, n, a))
        result.flat[index] = oo * oo * nn > (m * aa) ** 2
    return result


def in_shell(r, g, b, m, zz, step):
    """step 1: `rounded`; 2: `neighbor`.  Numerators over M (over 2M for Z-zero `rounded`)."""
    x, y, b = (np.asarray(c, np.int64) for c in (r, g, b))
    x, y = np.abs(2 * x - m), np.abs(2 * y - m)
    if step == 2:  # whole levels: |V| = 1 has the neighbors -1 and 3, none nearer to 0
        lx, ly = np.maximum(x - 2, 1), np.maximum(y - 2, 1)
        hx, hy = x + 2, y + 2
        lz, hz = (np.maximum(b - 1, 0), b + 1) if zz else (None, None)
        one = m
    else:
        lx, ly, hx, hy, one = x - 1, y - 1, x + 1, y + 1, m
        if zz:
            lx, ly, hx, hy, one = 2 * lx, 2 * ly, 2 * hx, 2 * hy, 2 * m
            lz, hz = np.maximum(2 * b - 1, 0), 2 * b + 1
    if not zz:
        z = np.abs(2 * b - m)
        lz, hz = (np.maximum(z - 2, 1), z + 2) if step == 2 else (z - 1, z + 1)
    return (lx * lx + ly * ly + lz * lz <= one * one) & (hx * hx + hy * hy + hz * hz >= one * one)


def flags(r, g, b, m, zz=False, keep=False):
    """The byte of ntp_validate, without NTP_FLAG_UNUSED."""
    r, g, b = (np.asarray(c, np.int64) for c in (r, g, b))
    inside = radicands(r, g, m) >= 0
    want = derived_blues(r, g, m, zz)
    is_exact = b == want
    if keep and not zz:
        is_exact |= b == m - want
    result = in_shell(r, g, b, m, zz, 2) * 1 + in_shell(r, g, b, m, zz, 1) * 2
    result = result + (inside & is_exact) * 4 + ~inside * 8
    if not zz:
        result = result + (b <= (m - 1) // 2) * 16
    return result.astype(np.uint8)


def unused(texels, m, touch=0):
    """Which texels of an (..., c) array of normals are unused; touch as in libntp.h (1, 2, 4)."""
    channels = texels.shape[-1]
    colors = texels[..., :3]
    none = np.zeros(texels.shape[:-1], bool)
    black = none if touch & 1 else np.all(colors == 0, axis=-1)
    white = none if touch & 2 else np.all(colors == m, axis=-1)
    clear = none if touch & 4 or channels != 4 else texels[..., -1] == 0
    return black | white | clear


def all_normalized(r, g, b, m, zz=False):
    """Arrays divided by their lengths (8 bit: exact in int64; 16 bit: use the slow one)."""
    assert m == 255
    v = [
        2 * np.asarray(r, np.int64) - m,
        2 * np.asarray(g, np.int64) - m,
        np.asarray(b, np.int64),
    ]
    if not zz:
        v[2] = 2 * v[2] - m
    n = v[0] ** 2 + v[1] ** 2 + v[2] ** 2

    def level(c):  # floor of |c|*M/L rounded to odd numerators, mirrored for c < 0
        root = isqrt(c * c * (m * m) // n)
        up = (root + m + 1) // 2
        return np.where(c < 0, m - up, up)

    blue = (isqrt(4 * v[2] * v[2] * (m * m) // n) + 1) // 2 if zz else level(v[2])
    return level(v[0]), level(v[1]), blue


@functools.cache
def derive_table(m=255, zz=False):
    """(256, 256, 3): the cleaned texel of each 8-bit (r, g), made by the slow model."""
    table = np.zeros((m + 1, m + 1, 3), np.int64)
    for r in range(m + 1):
        for g in range(m + 1):
            rr, gg = pull(r, g, m)
            table[r, g] = rr, gg, derived_blue(rr, gg, m, zz)
    table.flags.writeable = False
    return table


def all_cleaned(r, g, b, zz=False, method="derive", keep=False):
    """8-bit arrays cleaned; every texel is used.  Returns (..., 3)."""
    m = 255
    r, g, b = (np.asarray(c, np.int64) for c in (r, g, b))
    negative = (b <= (m - 1) // 2) & (not zz)
    if not keep:
        b = np.where(negative, m - b, b)
        negative = np.zeros_like(negative)
    if method == "keep":
        return np.stack(np.broadcast_arrays(r, g, b), -1)
    if method == "normalize":
        stay = in_shell(r, g, b, m, zz, 1)
        made = all_normalized(r, g, b, m, zz)
        return np.stack([np.where(stay, c, d) for c, d in zip((r, g, b), made)], -1)
    red, green, blue = np.moveaxis(derive_table(m, zz)[r, g], -1, 0)
    blue = np.where(negative, m - blue, blue)
    return np.stack(np.broadcast_arrays(red, green, blue), -1)


def angles(r, g, b, m, zz=False):
    """Degrees between the stored vectors and the cleaned ones (derive, sign not kept)."""
    r, g, b = np.broadcast_arrays(*(np.asarray(c, np.int64) for c in (r, g, b)))
    cr, cg = pulled(r, g, m)
    cb = derived_blues(cr, cg, m, zz)
    a = [2 * r - m, 2 * g - m, b if zz else 2 * b - m]
    c = [2 * cr - m, 2 * cg - m, cb if zz else 2 * cb - m]
    a, c = [v.astype(np.float64) for v in a], [v.astype(np.float64) for v in c]
    cross = np.sqrt(
        (a[1] * c[2] - a[2] * c[1]) ** 2
        + (a[2] * c[0] - a[0] * c[2]) ** 2
        + (a[0] * c[1] - a[1] * c[0]) ** 2
    )
    return np.degrees(np.arctan2(cross, a[0] * c[0] + a[1] * c[1] + a[2] * c[2]))


# ---------------------------------------------------------------------- closed-form counts


def count_passing(m, zz=False, step=2):
    """How many of the (M+1)**3 triplets pass `rounded` (1) or `neighbor` (2), in closed form.

    For one (|X|, |Y|) the passing blues are those whose least square is small enough and whose
    greatest is large enough: an interval, counted from two roots.  All numbers are whole and below
    2**35, so doubles hold them, and their roots lie on the right side of every whole number: next
    to k*k, with k below 2**18, roots are 1/(2k) from k, and doubles there lie far denser.
    """
    assert m < 1 << 16
    x = np.arange(1, m + 1, 2, dtype=np.float64)
    total = 0
    low, high = (np.maximum(x - 2, 1), x + 2) if step == 2 else (x - 1, x + 1)
    low, high = low * low, high * high
    for i in range(len(x)):
        room = (m * m - low[i]) - low[: i + 1]  # least square of z at most this
        room = room[room >= 0]  # elsewhere no blue passes; these come first, for low ascends
        need = (m * m - high[i]) - high[: len(room)]  # greatest square of z at least this
        counts = _blues_between(room, np.maximum(need, 0), m, zz, step)
        on_diagonal = counts[i] if len(room) > i else 0
        total += int(2 * counts.sum() - on_diagonal)
    return total * 4  # four signs of X, Y


def _blues_between(room, need, m, zz, step):
    """How many blues have their least square <= room and their greatest >= need, as doubles."""
    if zz and step == 2:  # |b - 1| <= top (b = 0 counts as 0), b + 1 >= needed
        last = np.minimum(np.floor(np.sqrt(room)) + 1, m)
        first = np.maximum(np.ceil(np.sqrt(need)) - 1, 0)
    elif zz:  # 2b - 1 <= sqrt(4 room), 2b + 1 >= sqrt(4 need)
        last = np.minimum(np.floor((np.floor(np.sqrt(4 * room)) + 1) / 2), m)
        first = np.floor(np.ceil(np.sqrt(4 * need)) / 2)
    else:  # odd |Z| with |Z| - step <= top (neighbor: 1 counts as 1) and |Z| + step >= needed
        top = np.floor(np.sqrt(room))
        most = 2 * np.floor((np.minimum(top + step, m) + 1) / 2) - 1
        if step == 2:
            most[top < 1] = -1
        least = 2 * np.floor(np.maximum(np.ceil(np.sqrt(need)) - step, 1) / 2) + 1
        return 2 * np.maximum((most - least) / 2 + 1, 0)
    return np.maximum(last - first + 1, 0)
