# SPDX-License-Identifier: MIT
"""Many files on many machines, and heightfields larger than memory, by Dask.

``check`` and ``clean`` process files in batches, on the workers of a cluster if there is one, and
return one report, whichever worker did what and however many died meanwhile.
``normals_from_height`` makes normals of a chunked Dask array, tile by tile, with the bytes that the
whole array would have given.

It needs the extra: ``pip install 'normaltexture[dask]'``.  The workers need the package and see
the files under the same paths.
"""

import importlib
import os
import shutil
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _ntp
from ._errors import ArgumentError
from ._height import normals_from_height as _normals_from_height
from ._names import BORDERS, KERNELS
from ._native import ffi, lib
from .typing import Border, Kernel

if TYPE_CHECKING:
    import dask.array as da

Json = dict[str, Any]
PathLike = str | os.PathLike[str]

# Files that one task works on: enough to hide its cost, few enough to spread and to repeat.
BATCH = 16


def _named(paths: Any) -> list[str]:
    """The argument `paths`, with a sentence for what it may be mistaken for."""
    if isinstance(paths, np.ndarray) and paths.dtype.kind not in "UO":
        raise ArgumentError(
            "paths: must name image files, not hold texels; "
            "nt.check takes files too, and nt.clean takes arrays"
        )
    if isinstance(paths, str | os.PathLike):
        raise ArgumentError(f"paths={os.fspath(paths)!r}: must be a list of paths, not one path")
    try:
        return [os.fspath(path) for path in paths]
    except TypeError as error:
        raise ArgumentError(f"paths: must be a list of paths: {error}") from None


def _batches(paths: Iterable[PathLike], size: int) -> list[list[str]]:
    names = _named(paths)
    if size < 1:
        raise ArgumentError(f"batch={size!r}: must be at least 1")
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ArgumentError(f"paths: {twice!r} is there twice")
    return [names[i : i + size] for i in range(0, len(names), size)]


def _dask(part: str) -> Any:
    try:
        return importlib.import_module(f"dask.{part}")
    except ImportError as error:
        message = f"this needs dask: pip install 'normaltexture[dask]' ({error})"
        raise ImportError(message) from error


def _has_scheduler() -> bool:
    """Whether there is a client, or the user has chosen a scheduler."""
    if _dask("config").get("scheduler", None) is not None:
        return True
    try:
        importlib.import_module("distributed").default_client()
    except (ImportError, ValueError):
        return False
    return True


def _run(work: Callable[..., Any], batches: Sequence[Any], **options: Any) -> list[Any]:
    """The results of all batches in their order: a bag with a partition for each."""
    bag = _dask("bag").from_sequence(batches, npartitions=len(batches)).map(work, **options)
    # Without a cluster threads do: the work is done by the program, a process of its own.
    results: list[Any] = bag.compute(**({} if _has_scheduler() else {"scheduler": "threads"}))
    return results


def _report(results: Iterable[tuple[list[Json], Json]]) -> Json:
    """One report of the batches, in the order of the paths."""
    files: list[Json] = []
    summary: Json = {}
    for part, counts in results:
        files += part
        for key, count in counts.items():
            if key == "rule":  # the options are those of all batches
                summary[key] = count
            elif isinstance(count, int):
                summary[key] = summary.get(key, 0) + count
            else:
                kept = summary.setdefault(key, {})
                for name, number in count.items():
                    kept[name] = kept.get(name, 0) + number
    return {"schema_version": 1, "tool": _ntp.tool_fields(), "files": files, "summary": summary}


# ------------------------------------------------------------------------------ checking


def _check_batch(names: list[str], options: tuple[str, ...]) -> tuple[list[Json], Json]:
    report, _ = _ntp.run_json("check", names, [*options, "--jobs", "1"])
    return report["files"], report["summary"]


def check(paths: Iterable[PathLike], *, options: Sequence[str] = (), batch: int = BATCH) -> Json:
    """Checks many files, each of them on some worker.

    Parameters
    ----------
    paths
        Image files.  Each is judged; directories are not searched.
    options
        Options of ``ntp check``, such as ``("--y", "up")``.
    batch
        Files of one task.

    Returns
    -------
    dict
        As ``ntp check --format json`` prints it: one entry for each path, in the order given.

    Raises
    ------
    ArgumentError
        A path is given twice, or `paths` holds no paths.
    normaltexture._ntp.ProgramError
        The program ntp is missing on a worker or refuses an option.

    Notes
    -----
    It runs on the Dask client that is current, or else on the processors of this machine.  A task whose
    worker dies is run again elsewhere; checking changes nothing, so that is harmless.

    Examples
    --------
    >>> from normaltexture import distributed
    >>> report = distributed.check(["wall_n.png"])
    >>> report["summary"]["files"]
    1
    """
    batches = _batches(paths, batch)
    if not batches:
        return _report([])
    return _report(_run(_check_batch, batches, options=tuple(options)))


# ------------------------------------------------------------------------------ cleaning


def _target(name: str, base: str, output: str) -> Path:
    """Where the clean copy of a file goes: its path below `base`, as a PNG."""
    relative = os.path.relpath(os.path.abspath(name), base)
    return Path(output, relative).with_suffix(".png")


def _publish(made: Path, target: Path) -> str:
    """Gives a finished file its name, once.

    A hard link fails where the name is taken; so of two attempts at one task, whichever comes
    first publishes, and the other finds the same bytes there.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.link(made, target)
    except FileExistsError:
        if target.read_bytes() != made.read_bytes():
            return "exists"
        return "earlier"
    return "now"


def _clean_batch(
    work: list[tuple[str, str]], scratch: str, options: tuple[str, ...]
) -> tuple[list[Json], Json]:
    """Cleans files into a directory of this attempt alone, then publishes them."""
    own = Path(scratch, uuid.uuid4().hex)
    own.mkdir(parents=True)
    files: list[Json] = []
    summary = {"files": 0, "written": 0, "unchanged": 0, "skipped": 0, "refused": 0, "failed": 0}
    try:
        for number, (name, target) in enumerate(work):
            made = own / f"{number}.png"
            report, _ = _ntp.run_json("clean", [name], [*options, "-o", str(made), "--jobs", "1"])
            (entry,) = report["files"]
            counts = report["summary"]
            if entry["written"]:
                state = _publish(made, Path(target))
                entry["output"] = target
                entry["published"] = state
                if state == "exists":
                    message = f"{target}: exists already, with other content"
                    entry.update(status="failed", message=message, written=False)
                    counts = {"files": 1, "failed": 1}
            files.append(entry)
            for key in summary:
                summary[key] += counts.get(key, 0)
    finally:
        shutil.rmtree(own, ignore_errors=True)
    return files, summary


def clean(
    paths: Iterable[PathLike],
    output: PathLike,
    *,
    base: PathLike | None = None,
    options: Sequence[str] = (),
    batch: int = BATCH,
) -> Json:
    """Cleans many files into a directory, each of them on some worker, each written once.

    Parameters
    ----------
    paths
        Image files.
    output
        A directory that all workers see, on a file system with hard links.  Existing files are
        never overwritten: a file of the same name stays if it has the same bytes, so that an
        interrupted run can be started again, and is an error otherwise.
    base
        The directory below which paths are kept; default: the deepest that all files lie in.
    options
        Options of ``ntp clean``, such as ``("--method", "auto", "--only-changed")``.
    batch
        Files of one task.

    Returns
    -------
    dict
        As ``ntp clean --format json`` prints it: one entry for each path, in the order given.
        ``published`` in an entry is "now", or "earlier" where an attempt before this one (of a
        worker that died, or of a run that was interrupted) had finished the file.

    Raises
    ------
    ArgumentError
        A path is given twice, lies outside `base`, or two files would get the same output.
    normaltexture._ntp.ProgramError
        The program ntp is missing on a worker or refuses an option.

    Notes
    -----
    Each file is made complete under another name and then linked to its own, which only one of
    several attempts can do.  Leftovers of dead workers are removed at the end.
    """
    batches = _batches(paths, batch)
    if not batches:
        return _report([])
    names = [os.path.abspath(name) for part in batches for name in part]
    top = (
        os.path.abspath(base)
        if base is not None
        else os.path.commonpath([os.path.dirname(name) for name in names])
    )
    outside = [name for name in names if os.path.commonpath([name, top]) != top]
    if outside:
        raise ArgumentError(f"paths: {outside[0]!r} lies outside base={top!r}")
    out = os.path.abspath(output)
    targets = [[(name, str(_target(name, top, out))) for name in part] for part in batches]
    taken: dict[str, str] = {}
    for name, target in (pair for part in targets for pair in part):
        if target in taken:
            raise ArgumentError(f"paths: {taken[target]!r} and {name!r} would both be {target!r}")
        taken[target] = name
    scratch = os.path.join(out, f".ntp-{uuid.uuid4().hex}")
    os.makedirs(scratch)
    try:
        results = _run(_clean_batch, targets, scratch=scratch, options=tuple(options))
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return _report(results)


# --------------------------------------------------------------------------- heightfields


def reach(kernel: Kernel = "central") -> int:
    """How many texels on each side a normal depends on.

    Parameters
    ----------
    kernel
        One of `normaltexture.normals_from_height`.

    Returns
    -------
    int
        1..4 texels.

    Raises
    ------
    ArgumentError
        For another kernel.

    Examples
    --------
    >>> from normaltexture import distributed
    >>> distributed.reach("gimp9")
    4
    """
    if kernel not in KERNELS:
        raise ArgumentError(f"kernel={kernel!r}: must be one of {', '.join(KERNELS)}")
    how = ffi.new("ntp_normals_options *")
    how.scale = 1.0
    how.kernel = KERNELS[kernel]
    found: int = lib.ntp_normals_reach(how)
    return found


def _tile(
    heights: NDArray[Any],
    *,
    trims: Mapping[int, tuple[int, bool]],
    cuts: tuple[int, ...],
    how: Mapping[str, Any],
    block_id: tuple[int, ...] | None = None,
) -> NDArray[Any]:
    """The normals of one tile, which comes with its surroundings; the result is without them."""
    normals: NDArray[Any] = _normals_from_height(heights, **how)
    if block_id is None:
        return normals
    for axis, (depth, wraps) in trims.items():
        first = depth if wraps or block_id[axis] > 0 else 0
        last = depth if wraps or block_id[axis] < cuts[axis] - 1 else 0
        normals = normals[(slice(None),) * axis + (slice(first, normals.shape[axis] - last),)]
    return np.ascontiguousarray(normals)


def _least_chunks(chunks: tuple[int, ...], least: int) -> tuple[int, ...]:
    """The same length in chunks of at least so many: small ones join their neighbors."""
    joined: list[int] = []
    for chunk in chunks:
        if joined and joined[-1] < least:
            joined[-1] += chunk
        else:
            joined.append(chunk)
    if len(joined) > 1 and joined[-1] < least:
        joined[-2:] = [joined[-2] + joined[-1]]
    return tuple(joined)


def normals_from_height(
    height: "da.Array",
    scale: float,
    *,
    kernel: Kernel = "central",
    border: Border = "wrap",
    border_x: Border | None = None,
    border_y: Border | None = None,
    **options: Any,
) -> "da.Array":
    """Makes normals from a chunked heightfield, such as the tiles of a terrain.

    Parameters
    ----------
    height
        A Dask array of shape (height, width) or (height, width, 1 to 4), of uint8, uint16, float32
        or float64, which is rounded to float32.  Chunks smaller than the kernel needs are joined.
    scale, kernel, border, border_x, border_y
        As of `normaltexture.normals_from_height`.
    options
        Further arguments of that function: strength, dx, dy, invert, source, to, to_y, depth, blue, min_z,
        alpha.  What needs more than a neighborhood (dither) is refused.

    Returns
    -------
    dask.array.Array
        (height, width, channels), not computed yet, chunked as `height` is.  Computed, it has the
        bytes that `normaltexture.normals_from_height` makes of the whole array, at every border.

    Raises
    ------
    ArgumentError
        An argument is out of range or cannot be used here.

    Examples
    --------
    >>> import dask.array as da, numpy as np, normaltexture as nt
    >>> from normaltexture import distributed
    >>> terrain = np.add.outer(np.arange(40.0), np.arange(60.0)).astype(np.float32) ** 0.5
    >>> tiles = da.from_array(terrain, chunks=(16, 16))
    >>> normals = distributed.normals_from_height(tiles, scale=5, border="clamp")
    >>> whole = nt.normals_from_height(terrain, scale=5, border="clamp")
    >>> bool((normals.compute(scheduler="threads") == whole).all())
    True
    """
    for name in ("dither", "out", "threads"):
        if name in options:
            raise ArgumentError(f"{name}: cannot be used on a chunked array")
    if isinstance(scale, str):
        raise ArgumentError(
            f"scale={scale!r}: must be a number, because a tile does not show the whole; "
            "nt.suggest_scale finds one"
        )
    if isinstance(height, np.ndarray) or not hasattr(height, "chunks"):
        raise ArgumentError(
            f"height: must be a Dask array, not {type(height).__name__}; dask.array.from_array "
            "makes one, and nt.normals_from_height takes numpy arrays"
        )
    if height.ndim not in (2, 3):
        raise ArgumentError(f"height: its shape is {height.shape}, not that of an image")
    borders = {0: border_y or border, 1: border_x or border}
    for value in borders.values():
        if value not in BORDERS:
            raise ArgumentError(f"border={value!r}: must be one of {', '.join(BORDERS)}")
    how = {
        "scale": scale,
        "kernel": kernel,
        "border_x": borders[1],
        "border_y": borders[0],
        "source": "red",  # tiles are not asked one by one what they are
        **options,
    }
    radius = reach(kernel)
    # Mirrored and extrapolated borders read a little farther in than the kernel reaches out.
    least = 2 * radius + 2
    chunks = tuple(
        _least_chunks(c, least) if axis < 2 else (sum(c),) for axis, c in enumerate(height.chunks)
    )
    tiles: Any = height
    tiles = tiles.rechunk(chunks)
    example = _normals_from_height(np.zeros((1, 1, *tiles.shape[2:]), tiles.dtype), **how)
    # An axis in one chunk is whole: the library sees to its border itself.
    trims = {
        axis: (radius, borders[axis] == "wrap") for axis in (0, 1) if len(tiles.chunks[axis]) > 1
    }
    depth = {axis: trims[axis][0] if axis in trims else 0 for axis in range(tiles.ndim)}
    boundary = {
        axis: "periodic" if axis in trims and trims[axis][1] else "none"
        for axis in range(tiles.ndim)
    }
    channels = {"new_axis": [2]} if tiles.ndim == 2 else {}
    normals: da.Array = _dask("array").map_overlap(
        _tile,
        tiles,
        depth=depth,
        boundary=boundary,
        trim=False,
        allow_rechunk=False,
        dtype=example.dtype,
        meta=np.empty((0, 0, 0), example.dtype),
        chunks=(*tiles.chunks[:2], (example.shape[2],)),
        trims=trims,
        cuts=tiles.numblocks,
        how=how,
        **channels,
    )
    return normals


__all__ = ["BATCH", "check", "clean", "normals_from_height", "reach"]
