# SPDX-License-Identifier: MIT
"""Cleaning: every texel a unit vector again."""

from collections.abc import Iterable
from dataclasses import dataclass
from threading import Lock
from typing import Any, Literal, overload

from numpy.typing import ArrayLike

from ._arrays import (
    ENCODINGS,
    TOUCH_ALL,
    TOUCH_NONE,
    AnyType,
    Output,
    Pixels,
    choose,
    memory,
    pixels,
    view,
)
from ._classify import resolve_both
from ._errors import check
from ._measure import _Result
from ._native import ffi, lib
from ._threads import COPYING, QUICK, run

Method = Literal["derive", "normalize", "auto"]
Verdict = Literal["neighbor", "rounded", "exact"]

_METHODS = {"derive": 0, "normalize": 1, "auto": -1, "keep": 2}
VERDICTS = {"neighbor": 0, "rounded": 1, "exact": 2}

# A plan is a table of 320 KiB that makes cleaning 8-bit images as fast as copying them; making it
# costs about as much as cleaning this many texels without one.
_PLAN_PAYS = 1 << 17
_plans: dict[tuple[int, ...], tuple[Any, Any]] = {}
_plans_lock = Lock()


@dataclass(frozen=True)
class CleanCounts(_Result):
    """What `clean` did.

    Attributes
    ----------
    changed : int
        Texels of which a sample changed.
    not_finite : int
        Float texels with a NaN, an infinity or length 0: made flat.
    """

    changed: int
    not_finite: int


def _plan(encoding: int, how: tuple[int, ...], options: Any) -> Any:
    """A plan made before, or a new one; plans are read-only and shared by threads."""
    key = (encoding, *how)
    with _plans_lock:
        if key not in _plans:
            size = lib.ntp_clean_plan_size()
            where, owner = memory(size)
            made = ffi.new("ntp_clean_plan **")
            check(lib.ntp_clean_plan_init(made, where, size, encoding, options), "clean")
            _plans[key] = made[0], owner
        return _plans[key][0]


@overload
def clean(
    src: ArrayLike,
    *,
    type: AnyType = ...,
    method: Method = ...,
    verdict: Verdict = ...,
    only_failing: bool = ...,
    keep_negative_z: bool = ...,
    touch_unused: bool = ...,
    return_counts: Literal[False] = ...,
    out: Pixels | None = ...,
    threads: int = ...,
) -> Pixels: ...
@overload
def clean(
    src: ArrayLike,
    *,
    type: AnyType = ...,
    method: Method = ...,
    verdict: Verdict = ...,
    only_failing: bool = ...,
    keep_negative_z: bool = ...,
    touch_unused: bool = ...,
    return_counts: Literal[True],
    out: Pixels | None = ...,
    threads: int = ...,
) -> tuple[Pixels, CleanCounts]: ...
def clean(
    src: ArrayLike,
    *,
    type: AnyType = "standard",
    method: Method = "derive",
    verdict: Verdict = "neighbor",
    only_failing: bool = False,
    keep_negative_z: bool = False,
    touch_unused: bool = False,
    return_counts: bool = False,
    out: Pixels | None = None,
    threads: int = 1,
) -> Pixels | tuple[Pixels, CleanCounts]:
    """Repair normals: each texel becomes a unit vector.  Cleaning twice changes nothing more.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).  It is not written.
    type : {"standard", "zzero", "xy", "vector", "auto"}
        How a normal is stored.  "auto" finds out by the texels, as `ntp clean` does, and refuses
        what is no normals texture.
    method : {"derive", "normalize", "auto"}
        "derive": keep x and y (pulled onto the unit disc where too long), compute z.  "normalize":
        divide each vector that is no honest rounding by its length; better after lossy compression
        or resizing.  "auto": what the errors of the texture speak for.
    verdict : {"neighbor", "rounded", "exact"}
        Which texels `only_failing` repairs.
    only_failing : bool
        Leave texels that pass `verdict` as they are.
    keep_negative_z : bool
        A negative z stays negative; otherwise it is mirrored first.
    touch_unused : bool
        Repair pure black, pure white and transparent texels too.
    return_counts : bool
        Return `CleanCounts` as well.
    out : array like src, optional
        Where to write; it may be `src` itself.
    threads : int
        How many threads share the rows; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array like src, or (array, CleanCounts)
        Alpha, and the third channel of `"xy"`, are copied.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    Integers throughout; docs/arithmetic.md has the proofs.  The test and the derived z are those
    of Eric Haines' NormalTextureProcessor (2024).

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> nt.clean(np.array([[[200, 100, 10], [255, 255, 128]]], np.uint8))
    array([[[200, 100, 229],
            [217, 217, 143]]], dtype=uint8)
    """
    source = pixels("src", src)
    code = choose("method", method, _METHODS)
    if type == "auto" or code < 0:
        type, code = resolve_both(source, type, code, threads)
    encoding = choose("type", type, ENCODINGS)
    how = (
        code,
        int(bool(keep_negative_z)),
        int(bool(only_failing)),
        choose("verdict", verdict, VERDICTS),
        TOUCH_ALL if touch_unused else TOUCH_NONE,
    )
    options = ffi.new("ntp_clean_options *", how)
    src_view = view("src", source, encoding)
    output = Output(source.shape, source.dtype, out)
    if out is not None:
        output.apart_from(True, src=source)
    dst = view("out", output.array, encoding, writable=True)
    plan = ffi.NULL
    if src_view.type == 0 and source.shape[0] * source.shape[1] >= _PLAN_PAYS:
        plan = _plan(encoding, how, options)

    def work(areas: Iterable[Any]) -> Any:
        counts = ffi.new("ntp_clean_counts *")
        for area in areas:
            check(lib.ntp_clean(dst, src_view, options, plan, counts, area), "clean")
        return counts

    grain = COPYING if code == 0 and src_view.type < 2 else QUICK
    parts = run(threads, source.shape[1], source.shape[0], work, grain)
    result: Pixels = output.finish()
    if not return_counts:
        return result
    return result, CleanCounts(
        sum(part.changed for part in parts), sum(part.not_finite for part in parts)
    )
