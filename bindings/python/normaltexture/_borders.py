# SPDX-License-Identifier: MIT
"""Detects the kernel and the borders that made a texture, as `ntp to-height` does."""

from typing import Any

from ._errors import Status
from ._native import ffi, lib
from ._solve import Solver

_WRAP: int = lib.NTP_BORDER_WRAP
_POISSON: int = lib.NTP_HEIGHT_POISSON_DCT
_FRANKOT_CHELLAPPA: int = lib.NTP_HEIGHT_FRANKOT_CHELLAPPA
SHARE = 0.2  # of the progress


def find_kernel(src: Any, how: Any) -> int:
    """The kernel to reconstruct with; telescoping cannot do baked slopes."""
    origin = ffi.new("ntp_kernel_fit *")
    failed = lib.ntp_find_kernel(origin, src, how.touch_unused) != Status.OK
    sums = how.method == lib.NTP_HEIGHT_TELESCOPING and origin.kernel == lib.NTP_KERNEL_BAKED
    return int(lib.NTP_KERNEL_CENTRAL if failed or sums else origin.kernel)


def choose_borders(how: Any, asked: tuple[int, int], src: Any, solver: Solver) -> bool:
    """Sets the borders of `how`; -1 in `asked` means to detect them.  True if that took a while."""
    method = how.method
    how.border_x, how.border_y = max(asked[0], _WRAP), max(asked[1], _WRAP)
    open_ = asked[0] < 0, asked[1] < 0
    if not any(open_) or method == _FRANKOT_CHELLAPPA:
        return False
    seams = ffi.new("ntp_seam[2]")
    if method != _POISSON:
        lib.ntp_find_seams(seams, seams + 1, src, how.touch_unused)
    found = solver.find_borders(how, open_, (seams[0].wraps, seams[1].wraps), 0.0, SHARE)
    for i, name in enumerate(("border_x", "border_y")):
        never = method == _POISSON and found[i].border == _WRAP
        if open_[i]:
            setattr(how, name, lib.ntp_free_border(how.kernel) if never else found[i].border)
    return True
