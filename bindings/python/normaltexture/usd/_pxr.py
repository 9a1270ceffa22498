# SPDX-License-Identifier: MIT
"""The modules of usd-core, which have no types."""

from importlib import import_module
from typing import Any

Ar: Any = import_module("pxr.Ar")
Sdf: Any = import_module("pxr.Sdf")
Tf: Any = import_module("pxr.Tf")
Usd: Any = import_module("pxr.Usd")
UsdShade: Any = import_module("pxr.UsdShade")
UsdUtils: Any = import_module("pxr.UsdUtils")
