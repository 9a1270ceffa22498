# SPDX-License-Identifier: MIT
"""What the tests of the package share besides `support` of the repository's tests.

A module here holds no test.
"""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]
