# SPDX-License-Identifier: MIT
"""Under a sanitizer, which is slow, every fourth of many cases that all run the same code."""

import os

SANITIZED = bool(os.environ.get("NTP_SANITIZED"))
EVERY = 4 if SANITIZED else 1
