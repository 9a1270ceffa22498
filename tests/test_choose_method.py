# SPDX-License-Identifier: MIT
"""The chosen cleaning method, compared with the result of each method on textures with known
normals."""

from collections import Counter

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import maps
from support.damages import as_zzero, constant_blue, jpeg, resized, rounded, sample, wrong_z
from support.evidence import evidence
from support.judged import draw_seed, reason_text, tally_of
from support.sanitized import EVERY

DRAWS = 700
S = maps.STANDARD


@pytest.fixture(scope="module")
def seed():
    return draw_seed()


def choose(case, lossy=0):
    encoding = case.kind
    tally = tally_of(case, encoding)
    method, why = ntp.ffi.new("ntp_clean_method *"), ntp.ffi.new("ntp_reason *")
    ntp.check(ntp.lib.ntp_choose_method(method, why, tally.pointer, encoding, lossy))
    return method[0], reason_text(why), evidence(tally)


def mean_angle(levels, truth, m, zzero):
    """Mean angle in degrees between what the levels say and the undamaged vectors."""
    v = levels[..., :3].astype(float) * 2 / m - 1
    if zzero:
        v[..., 2] = levels[..., 2] / m
    dot, cross = (v * truth).sum(-1), np.linalg.norm(np.cross(v, truth), axis=-1)
    return np.degrees(np.arctan2(cross, dot)).mean()


def test_the_chosen_method_is_not_the_worse_one(seed):
    good, total, bad = 0, 0, []
    counts = Counter()
    for i in range(0, DRAWS, EVERY):
        case = maps.draw(np.random.default_rng([seed, 1, i]))
        if case.truth is None or case.kind > maps.ZZERO:
            continue
        pixels = np.ascontiguousarray(case.pixels)
        m = 255 if pixels.dtype == np.uint8 else 65535
        method, why, _ = choose(case)
        angles = [
            mean_angle(
                ntp.clean(pixels, case.kind, ntp.clean_options(k))[0], case.truth, m, case.kind
            )
            for k in range(3)
        ]
        total += 1
        counts[case.name, method] += 1
        if angles[method] <= 1.1 * min(angles[:2]) + 0.05:
            good += 1
        else:
            bad.append(f"{i} {case.name} {case.details}: {method} {why} {np.round(angles, 2)}")
    report = (
        f"NTP_SEED={seed}: {good} of {total}\n" + "\n".join(bad) + f"\n{sorted(counts.items())}"
    )
    print("\n" + report)
    assert total > 200 / EVERY
    assert good >= 0.95 * total, report


def test_method_of_plain_cases():
    rng = np.random.default_rng(5)
    n = sample("fractal", 0.8, rng)
    clean = maps.Case("clean", rounded(n), S)
    assert choose(clean)[0] == ntp.KEEP
    assert choose(maps.Case("flipped", rounded(n * [1, 1, -1]), S))[0] == ntp.KEEP
    assert choose(maps.Case("Z-zero", as_zzero(n, rng), maps.ZZERO))[0] == ntp.KEEP
    assert choose(maps.Case("wrong z", wrong_z(n, rng), S))[0] == ntp.DERIVE
    assert choose(maps.Case("blue 255", constant_blue(255)(n, rng), S))[0] == ntp.DERIVE
    assert choose(maps.Case("blue 255", constant_blue(255)(n, rng), S), 1)[0] == ntp.DERIVE
    assert choose(maps.Case("scaled", rounded(0.9 * n), S))[0] == ntp.NORMALIZE
    assert choose(maps.Case("scaled z", rounded(n * [1, 1, 0.85]), S))[0] == ntp.DERIVE
    too_blue = rounded(n)
    too_blue[..., 2] = np.minimum(too_blue[..., 2].astype(int) + 9, 255)
    assert choose(maps.Case("too blue", too_blue, S))[0] == ntp.DERIVE
    halved = resized(0.5, maps.Image.BOX)(n, rng)
    assert choose(maps.Case("halved", halved, S))[0] == ntp.NORMALIZE
    assert choose(maps.Case("JPEG", jpeg(85)(n, rng), S), 1)[0] == ntp.NORMALIZE
    one_off = rounded(n)
    one_off[3, 3, 2] = 90
    assert choose(maps.Case("one texel", one_off, S))[0] == ntp.DERIVE
    padded = rounded(n)
    padded[:20] = 0
    assert choose(maps.Case("padded", padded, S))[0] == ntp.KEEP
    assert choose(maps.Case("XY", rounded(n), maps.XY))[0] in (ntp.DERIVE, ntp.KEEP)
