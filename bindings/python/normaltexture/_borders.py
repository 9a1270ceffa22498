# SPDX-License-Identifier: MIT
"""Detects the kernel and the borders that made a texture, as `ntp to-height` does.

For the borders, heights are made without the slopes at the edges, which then decide.
"""

from typing import Any

from ._errors import CancelledError, Status
from ._native import ffi, lib
from ._solve import Solver

_WRAP: int = lib.NTP_BORDER_WRAP
_AUTO: int = lib.NTP_HEIGHT_AUTO
_POISSON: int = lib.NTP_HEIGHT_POISSON_DCT
_FRANKOT_CHELLAPPA: int = lib.NTP_HEIGHT_FRANKOT_CHELLAPPA
_BAKED: int = lib.NTP_KERNEL_BAKED
# Tried where the edges show no border: one takes the place of the one before if the residual is
# clearly less.  In levels of 8 bit: where normals fit so well, no border is wrong.
_TRIED: tuple[int, ...] = (lib.NTP_BORDER_WRAP, lib.NTP_BORDER_EXTRAPOLATE, lib.NTP_BORDER_CLAMP)
_CLEARLY_BETTER, _FITS_WELL = 0.99, 0.4
_LEAST_SIDE = 16  # of a texture of which ntp_find_seams and ntp_find_border tell anything


def find_kernel(src: Any, touch_unused: int) -> int:
    """The kernel to reconstruct with."""
    origin = ffi.new("ntp_kernel_fit *")
    if lib.ntp_find_kernel(origin, src, touch_unused) != Status.OK:
        return int(lib.NTP_KERNEL_CENTRAL)
    return int(origin.kernel)


def _residual(solver: Solver, how: Any, src: Any, begin: float, end: float) -> float:
    """In levels of 8 bit; -1: these borders cannot be solved."""
    result = ffi.new("ntp_height_result *")
    status = solver.solve(how, result, begin, end)
    if status == Status.CANCELLED:
        raise CancelledError("height_from_normals: cancelled")
    if status != Status.OK:
        return -1.0
    residual: float = result.residual
    return residual if src.type == lib.NTP_TYPE_U8 else residual / 257


def _try_borders(
    first: Any, found: list[int], open_: tuple[bool, bool], fixed: Any, src: Any, solver: Solver
) -> None:
    """Solves with other borders on the axes that are open, and changes `found` to the best."""
    step = 0.35 / (1 + 2 * len(_TRIED))
    how = ffi.new("ntp_height_options *", first[0])
    how.residual_scope = lib.NTP_RESIDUAL_ALL
    names = ("border_x", "border_y")
    for i, name in enumerate(names):
        if not fixed[i]:
            setattr(how, name, found[i])
    least = _residual(solver, how, src, 0.15, 0.15 + step)
    if not least > _FITS_WELL:
        return
    for i, name in enumerate(names):
        for k, border in enumerate(_TRIED if open_[i] else ()):
            before = getattr(how, name)
            setattr(how, name, border)
            begin = 0.15 + step * (1 + i * len(_TRIED) + k)
            residual = _residual(solver, how, src, begin, begin + step)
            if 0 <= residual < _CLEARLY_BETTER * least:
                least = residual
            else:
                setattr(how, name, before)
        found[i] = getattr(how, name)


def _tiles_well(first: Any, fixed: Any, wraps: Any, src: Any, solver: Solver) -> bool:
    """Is the texture told to tile, and are heights that tile right?  Then no other border is
    better."""
    if not all(fixed[i] or wraps[i] for i in (0, 1)):
        return False
    how = ffi.new("ntp_height_options *", first[0])
    how.residual_scope = lib.NTP_RESIDUAL_ALL
    for i, name in enumerate(("border_x", "border_y")):
        if not fixed[i]:
            setattr(how, name, _WRAP)
    return 0 <= _residual(solver, how, src, 0.0, 0.07) <= _FITS_WELL


def choose_borders(
    how: Any, asked: tuple[int, int], src: Any, heights: Any, solver: Solver
) -> bool:
    """Sets the borders of `how`; -1 in `asked` means to detect them.  True if it solved."""
    method = how.method
    fixed = asked[0] >= 0, asked[1] >= 0
    how.border_x, how.border_y = max(asked[0], _WRAP), max(asked[1], _WRAP)
    if all(fixed) or method == _FRANKOT_CHELLAPPA:
        return False
    tells = min(src.width, src.height) >= _LEAST_SIDE
    wraps = False, False
    if method != _POISSON and tells:
        seams = ffi.new("ntp_seam[2]")
        lib.ntp_find_seams(seams, seams + 1, src, how.touch_unused)
        wraps = bool(seams[0].wraps), bool(seams[1].wraps)
    free = lib.ntp_free_border(how.kernel)
    found = [_WRAP if wraps[0] else free, _WRAP if wraps[1] else free]
    tried = tells and method in (_AUTO, _POISSON) and how.kernel != _BAKED
    if tried:
        first = ffi.new("ntp_height_options *", how[0])
        first.refine = first.detrend = first.residual_scope = 0
        first.border_x = how.border_x if fixed[0] else free
        first.border_y = how.border_y if fixed[1] else free
        if _tiles_well(first, fixed, wraps, src, solver):
            return True  # how has them already
        status = solver.solve(first, ffi.NULL, 0.07, 0.15)
        if status == Status.CANCELLED:
            raise CancelledError("height_from_normals: cancelled")
        fits = ffi.new("ntp_border_fit[2]")
        if status == Status.OK:
            for i in (0, 1):
                lib.ntp_find_border(fits + i, src, heights, first, i, wraps[i])
                found[i] = fits[i].border
            unknown = tuple(not fixed[i] and not fits[i].decided for i in (0, 1))
            if any(unknown):
                _try_borders(first, found, (unknown[0], unknown[1]), fixed, src, solver)
    for i, name in enumerate(("border_x", "border_y")):
        never = method == _POISSON and found[i] == _WRAP
        if not fixed[i]:
            setattr(how, name, free if never else found[i])
    return tried
