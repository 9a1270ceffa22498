# SPDX-License-Identifier: MIT
"""Normals textures in USD scenes: how shaders read them, whether they are well formed, clean copies.

``check`` opens .usd, .usda, .usdc and .usdz files with usd-core (``pip install
'normaltexture[usd]'``), finds the textures that feed normals inputs of UsdPreviewSurface and the
normalmap nodes of MaterialX, and judges texels, color space, scale and bias.  ``clean`` repairs the
textures.  ``validator.register`` adds the check to UsdValidation.
"""

from typing import TYPE_CHECKING, Any

from ._rules import RULES

if TYPE_CHECKING:
    from ._check import check
    from ._clean import clean
    from ._read import UsdError

_PLACES = {"check": "_check", "clean": "_clean", "UsdError": "_read"}


def __getattr__(name: str) -> Any:
    """What needs usd-core is imported when it is asked for."""
    from importlib import import_module

    from ..images import MissingLibraryError

    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        import_module("pxr")
    except ImportError:
        raise MissingLibraryError(
            "USD needs the package usd-core: pip install 'normaltexture[usd]'"
        ) from None
    return getattr(import_module(f".{_PLACES[name]}", __name__), name)


__all__ = ["RULES", "UsdError", "check", "clean"]
