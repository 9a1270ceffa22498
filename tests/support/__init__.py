# SPDX-License-Identifier: MIT
"""What tests share: oracles and models, made textures, readers and writers, callers of GIMP.

A module here holds no test.  Oracles and models use nothing from the code that they check.
"""

import os

# Before numpy is imported: each process of pytest-xdist has one core, and threads that wait for the
# cores of others took most of the time of matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
