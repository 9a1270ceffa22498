# SPDX-License-Identifier: MIT
"""Pictures that several tests of the program start from."""

import numpy as np
import pytest

from support import to_height
from support.pngs import write_png


@pytest.fixture
def surface(tmp_path):
    """h.png, 16 bit, of a surface that tiles; 40 high."""
    h = to_height.fractal(128)
    h = (h - h.min()) / np.ptp(h)
    write_png(tmp_path / "h.png", np.round(h * 65535).astype(np.uint16))
    return h * 40
