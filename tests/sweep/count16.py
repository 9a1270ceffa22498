# SPDX-License-Identifier: MIT
"""The 16-bit counts of the definitions, by the oracle's closed form over all (|X|, |Y|)."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from support import oracle

PUBLISHED = {
    ("standard", "rounded"): 20_238_939_248,
    ("zzero", "rounded"): 16_865_913_328,
    ("standard", "neighbor"): 40_477_870_768,
    ("zzero", "neighbor"): 33_731_822_088,
}

wrong = 0
for (encoding, verdict), want in PUBLISHED.items():
    got = oracle.count_passing(65535, encoding == "zzero", 1 + (verdict == "neighbor"))
    print(f"{encoding} {verdict}: {got}, published {want}", flush=True)
    wrong += got != want
sys.exit(wrong != 0)
