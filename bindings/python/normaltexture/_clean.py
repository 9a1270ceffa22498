# SPDX-License-Identifier: MIT
"""Cleaning: every texel a unit vector again."""

from collections.abc import Iterable
from dataclasses import dataclass
from threading import Lock
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, choose, memory, pixels, view
from ._classify import classify, natural_tally, resolve_both
from ._errors import check
from ._measure import _Result
from ._names import AUTO, CLEAN_METHODS, TOUCH_ALL, TOUCH_NONE, TYPES, VERDICTS
from ._native import ffi, lib
from ._threads import COPYING, QUICK, run
from ._undo import choose_undo, undone
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    CleanHow,
    CleanMethod,
    Floats,
    SampleT,
    Undone,
    Verdict,
)

_METHODS = {name: CLEAN_METHODS[name] for name in ("derive", "normalize")} | {"auto": AUTO}

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
        Texels in which a sample changed.
    not_finite : int
        Float texels with a NaN, an infinity or length 0: made flat.
    undone : {"red-blue", "green-blue", "dxt5nm", "inverted-blue", "srgb"} or None
        The accident that was undone first.
    """

    changed: int
    not_finite: int
    undone: Undone | None = None


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
    src: Floats,
    *,
    type: Literal["vector"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[CleanHow],
) -> NDArray[np.float32]: ...
@overload
def clean(
    src: NDArray[SampleT],
    *,
    type: AutoStored = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[CleanHow],
) -> NDArray[SampleT]: ...
def clean(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    method: CleanMethod = "auto",
    verdict: Verdict = "neighbor",
    only_failing: bool = False,
    keep_negative_z: bool = False,
    touch_unused: bool = False,
    undo: bool = False,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Repair normals: each texel becomes a unit vector.  Cleaning again changes nothing.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).  It is not written.
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored.  "auto" detects it from the texels, as `ntp clean` does, and refuses
        what is not a normals texture.  "vector": the components as they are, float32.
    method : {"auto", "derive", "normalize"}
        "derive": keep x and y (pulled onto the unit disc where too long), compute z.  "normalize":
        divide each vector that is not a correctly rounded unit vector by its length; better after
        lossy compression or resizing.  "auto": choose by the errors of the texture, as
        `choose_method` does; one in which every texel is a correctly rounded unit vector stays.
    verdict : {"neighbor", "rounded", "exact"}
        Which texels `only_failing` repairs.
    only_failing : bool
        Leave texels that pass `verdict` as they are.
    keep_negative_z : bool
        A negative z stays negative; otherwise it is mirrored first.
    touch_unused : bool
        Repair pure black, pure white and transparent texels too.
    undo : bool
        First undo what can be undone exactly: exchanged channels, DXT5nm (which gives three
        channels), inverted blue, numbers converted to sRGB.  With `type="auto"` it is undone also
        without this where that is at least 90 % sure; else such a texture is refused.
    out : array like src, optional
        Where to write; it may be `src` itself.
    threads : int
        How many threads share the rows; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array like src
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
    >>> nt.clean(np.array([[[200, 100, 10], [255, 255, 128]]], np.uint8), type="standard")
    array([[[200, 100, 229],
            [217, 217, 143]]], dtype=uint8)
    """
    return _clean(
        src, type, method, verdict, only_failing, keep_negative_z, touch_unused, undo, out, threads
    )[0]


@overload
def clean_with_counts(
    src: Floats,
    *,
    type: Literal["vector"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[CleanHow],
) -> tuple[NDArray[np.float32], CleanCounts]: ...
@overload
def clean_with_counts(
    src: NDArray[SampleT],
    *,
    type: AutoStored = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[CleanHow],
) -> tuple[NDArray[SampleT], CleanCounts]: ...
def clean_with_counts(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    method: CleanMethod = "auto",
    verdict: Verdict = "neighbor",
    only_failing: bool = False,
    keep_negative_z: bool = False,
    touch_unused: bool = False,
    undo: bool = False,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> tuple[NDArray[Any], CleanCounts]:
    """Repair normals, and count what was changed.

    Parameters
    ----------
    src, type, method, verdict, only_failing, keep_negative_z, touch_unused, undo, out, threads
        As in `clean`.

    Returns
    -------
    (array like src, CleanCounts)

    Raises
    ------
    ArgumentError, SampleTypeError
        As `clean`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> cleaned, counts = nt.clean_with_counts(nt.read("wall_n.png"))
    >>> counts.changed
    268
    """
    result, parts, accident = _clean(
        src, type, method, verdict, only_failing, keep_negative_z, touch_unused, undo, out, threads
    )
    changed = sum(part.changed for part in parts)
    if accident is not None:  # against what was given, not against what was undone
        changed = int((result[..., :3] != np.asarray(src)[..., :3]).any(axis=2).sum())
    return result, CleanCounts(changed, sum(part.not_finite for part in parts), accident)


def _clean(
    src: AnyPixels | Floats,
    type: AutoType,
    method: CleanMethod,
    verdict: Verdict,
    only_failing: bool,
    keep_negative_z: bool,
    touch_unused: bool,
    undo: bool,
    out: Any,
    threads: int,
) -> tuple[NDArray[Any], list[Any], Undone | None]:
    """The array, an ntp_clean_counts for each part of the work, and what was undone."""
    source = given = pixels("src", src, type)
    code = choose("method", method, _METHODS)
    measured = natural_tally(source, threads) if type == "auto" or undo else None
    accident = None
    if measured is not None:
        accident = choose_undo(source, type, undo, classify(measured))
    if accident is not None:
        source, type = undone(source, accident), "standard"
        if accident == "dxt5nm":  # there is no blue
            code = lib.NTP_CLEAN_DERIVE
    if type == "auto" or code == AUTO:
        type, code = resolve_both(source, type, code, threads, measured)
        if code == lib.NTP_CLEAN_KEEP and touch_unused:
            # Unused texels were not asked.  Normalizing repairs them, and leaves what is rounded.
            code = int(lib.NTP_CLEAN_NORMALIZE)
    encoding = choose("type", type, TYPES)
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
        output.apart_from(accident is None, src=given)
    dst = view("out", output.array, encoding, writable=True)
    plan = ffi.NULL
    if src_view.type == lib.NTP_TYPE_U8 and source.shape[0] * source.shape[1] >= _PLAN_PAYS:
        plan = _plan(encoding, how, options)

    def work(areas: Iterable[Any]) -> Any:
        counts = ffi.new("ntp_clean_counts *")
        for area in areas:
            check(lib.ntp_clean(dst, src_view, options, plan, counts, area), "clean")
        return counts

    is_quick = code == lib.NTP_CLEAN_DERIVE and source.dtype.kind == "u"
    grain = COPYING if is_quick else QUICK
    parts = run(threads, source.shape[1], source.shape[0], work, grain)
    result: NDArray[Any] = output.finish()
    return result, parts, accident
