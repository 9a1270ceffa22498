# SPDX-License-Identifier: MIT
"""Fewer tests under a sanitizer, where each start of the program gegl takes a second."""

import os


def pytest_collection_modifyitems(config, items):
    if os.environ.get("NTP_SANITIZED"):
        ours = [item for item in items if item.path.name == "test_gegl.py"]
        left_out = [item for i, item in enumerate(ours) if i % 6 != 0]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
