# SPDX-License-Identifier: MIT
"""Takes out of an sdist what is not built with the package; Meson runs it when it makes one."""

import os
import shutil
from pathlib import Path

for name in ("gimp-plugin", "tests/gimp", "bench", "fuzz"):
    shutil.rmtree(Path(os.environ["MESON_DIST_ROOT"]) / name)
