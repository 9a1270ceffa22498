# SPDX-License-Identifier: MIT
"""Checks the normals textures of USD scenes: the program's findings and those of shading.

What an image holds follows from how it is read: a scale of 2 and a bias of -1 read standard
normals; a negative scale of x or y reads an image in which it is inverted; blue with a scale of 1
and a bias of 0 is Z-zero.
"""

import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import _ntp
from .._named import MAX_BYTES
from ..gltf._check import SURE, GltfType, by_level, finding, judge, summarize
from ._read import Picture, Scene, UsdError, load, picture
from ._stage import NormalsImage, Reading

Json = dict[str, Any]

# How far the level that becomes 0 may lie from the middle: 128 of 255 is 0.002 off.
MIDDLE_OFF = 0.01
SAME = 1e-3


@dataclass(frozen=True)
class Decoding:
    """What scale and bias read an image as."""

    type: GltfType = "standard"
    y: str = "up"
    strength: float = 1.0
    wrong: str = ""  # why they cannot be right, "" where they can


def _centered(scale: float, bias: float) -> bool:
    """Whether the middle of the stored range becomes 0."""
    return scale != 0 and abs(bias / scale + 0.5) <= MIDDLE_OFF


def _plain(reading: Reading) -> bool:
    """Neither scale nor bias, for what has to be normals."""
    return reading.scale[:3] == (1, 1, 1) and reading.bias[:3] == (0, 0, 0)


def decoding(reading: Reading, signed: bool) -> Decoding:
    """What an image has to hold for these scale and bias; `signed`: its floats are vectors."""
    (sx, sy, sz), (bx, by, bz) = reading.scale[:3], reading.bias[:3]
    said = f"scale {(sx, sy, sz)} and bias {(bx, by, bz)}".replace(".0,", ",").replace(".0)", ")")
    if signed:
        preview = "UsdUVTexture" in reading.node
        right = _plain(reading) if preview else False
        return Decoding(wrong="" if right else f"{said} read floats that are vectors already")
    if not (_centered(sx, bx) and _centered(sy, by)):
        missing = "no scale and bias" if _plain(reading) else said
        return Decoding(wrong=f"{missing}: x and y are not read as -1..1")
    if abs(abs(sx) - abs(sy)) > SAME * abs(sx):
        return Decoding(wrong=f"{said}: x and y have different strengths")
    # Where one of both is inverted, the image looks like one whose green points down.
    up = "up" if sx * sy > 0 else "down"
    if _centered(sz, bz) and sz > 0:
        return Decoding("standard", up, abs(sx) / sz)
    if abs(bz) <= SAME and sz > 0:
        return Decoding("zzero", up, abs(sx) / (2 * sz))
    return Decoding(wrong=f"{said}: z is not read as 0..1 or -1..1")


def _color_space(reading: Reading, deep: bool, gray: bool) -> tuple[str, str] | None:
    """(level, message) about the color space; `deep`: more than 8 bits."""
    space = reading.color_space
    if "UsdUVTexture" in reading.node:
        if space == "raw":
            return None
        if space == "sRGB":
            return "error", f"{reading.shader} has sourceColorSpace sRGB"
        named = "sourceColorSpace auto" if space else "no sourceColorSpace, which is auto"
        if deep or gray:
            return "warning", f"{reading.shader} has {named}; only raw is safe"
        return (
            "error",
            f"{reading.shader} has {named}: 8 bits and three channels are taken for sRGB",
        )
    if "_color" in reading.node and space.lower() not in ("raw", "data", "none"):
        return "error", f"{reading.shader} is {reading.node}, which gives colors; take vector3"
    if space.lower().startswith(("srgb", "g22", "rec709_display", "gamma")):
        return "warning", f"{reading.shader} has the color space {space!r} on data"
    return None


def _shading(reading: Reading, deep: bool, signed: bool, gray: bool) -> Iterator[Json]:
    """What is wrong with how a shader reads an image."""
    space = _color_space(reading, deep, gray)
    if space is not None:
        yield finding("NT070", *space)
    if not reading.direct:
        words = f"{reading.shader} reaches {reading.input} through other nodes"
        yield finding("NT073", "info", f"{words}, which are not followed")
        return
    if reading.output not in ("rgb", "rgba", "out"):
        message = f"{reading.input} reads outputs:{reading.output} of {reading.shader}"
        yield finding("NT073", "error", message)
    read = decoding(reading, signed)
    if read.wrong:
        yield finding("NT071", "error", f"{reading.shader}: {read.wrong}")
    elif abs(read.strength - 1) > SAME:
        yield finding("NT072", "info", f"{reading.shader} has a strength of {read.strength:g}")


def shading_findings(image: NormalsImage, *, deep: bool, signed: bool, gray: bool) -> list[Json]:
    """What the shaders around an image say."""
    told = [one for r in image.readings for one in _shading(r, deep, signed, gray)]
    if image.others:
        colors = [name for name, space in image.others if space.lower() not in ("raw", "data")]
        names = ", ".join(sorted({name for name in colors or [name for name, _ in image.others]}))
        level = "error" if colors else "warning"
        told.append(finding("NT060", level, f"the same image is read by {names}"))
    return list({(one["id"], one["message"]): one for one in told}.values())


def where(entry: Json) -> str:
    """How messages name an image."""
    return f"{entry['path']}, {entry['image']}"


def image_fields(scene: Scene, image: NormalsImage) -> Json:
    return {
        **_ntp.path_fields(scene.path),
        "image": image.asset,
        "resolved": image.resolved,
        "uses": [reading.to_dict() for reading in image.readings],
        "other_uses": [{"shader": name, "color_space": space} for name, space in image.others],
    }


def first_decoding(image: NormalsImage, signed: bool = False) -> Decoding:
    """How an image is judged: by the first shader that reads it rightly."""
    direct = [decoding(reading, signed) for reading in image.readings if reading.direct]
    right = [read for read in direct if not read.wrong]
    return right[0] if right else Decoding()


def _unreadable(entry: Json, message: str) -> None:
    message = f"{where(entry)}: {message}"
    entry.update(status="unreadable", message=message, type=None, findings=[])


def lost_layers(scene: Scene) -> list[Json]:
    """An entry for each layer that the scene names and that USD could not open."""
    entries = []
    for name in scene.lost():
        message = f"{scene.path}: {name} could not be opened, and what it holds was not checked"
        if name.lower().endswith(".mtlx"):
            message += "; usd-core reads no .mtlx, other builds of USD do"
        entry: Json = {**_ntp.path_fields(scene.path), "status": "unreadable", "message": message}
        entries.append({**entry, "type": None, "findings": []})
    return entries


def check_scene(scene: Scene, options: tuple[str, ...] = (), y: str = "up") -> list[Json]:
    """The entries of a scene's images."""
    entries: list[Json] = []
    groups: dict[tuple[GltfType, str], list[tuple[Json, NormalsImage, Picture]]] = {}
    with tempfile.TemporaryDirectory(prefix="ntp-usd-") as scratch:
        folder = Path(scratch)
        for number, image in enumerate(scene.images()):
            entry = image_fields(scene, image)
            entries.append(entry)
            if not image.resolved:
                _unreadable(entry, "is not there")
                continue
            try:
                data = scene.read(image.resolved)
            except UsdError as error:
                _unreadable(entry, str(error))
                continue
            made = picture(number, os.path.basename(image.asset), data, folder)
            if made.path is None:
                found = shading_findings(image, deep=False, signed=False, gray=False)
                found.append(finding("NT064", "info", made.why_not))
                message = f"{where(entry)}: {made.why_not}"
                entry.update(status="skipped", message=message, type=None, findings=by_level(found))
                continue
            read = first_decoding(image, made.signed)
            type: GltfType = "auto" if read.type == "standard" else read.type
            type = "xy" if made.xy else type
            way = read.y if y == "up" else "auto"
            groups.setdefault((type, way), []).append((entry, image, made))
        for (type, way), group in groups.items():
            names = [made.path.name for _, _, made in group if made.path is not None]
            files = judge(folder, names, options, way, type)
            for (entry, image, made), file in zip(group, files, strict=True):
                _merge(entry, image, made, file)
    return entries


def _merge(entry: Json, image: NormalsImage, made: Picture, file: Json) -> None:
    """Puts what the program said about an image into its entry."""
    entry.update({k: v for k, v in file.items() if k not in ("path", "path_base64")})
    if file["status"] != "ok":
        _unreadable(entry, file["message"].partition(": ")[2] or file["message"])
        return
    deep = file["bit_depth"] > 8
    gray = file["channels"] < 3
    found = shading_findings(image, deep=deep, signed=made.signed, gray=gray)
    looks = file.get("looks_like", {})
    if looks.get("type") == "zzero" and looks["confidence"] >= SURE:
        message = "this image stores z in 0..1 (Z-zero); scale and bias read it as -1..1"
        found.append(finding("NT071", "warning", message))
    entry["findings"] = by_level(file["findings"] + found)


# What opening and following a scene raises.
MALFORMED = (UsdError, OSError, RuntimeError, MemoryError, RecursionError)


def why(path: str | os.PathLike[str], error: BaseException) -> str:
    """The message about a scene that could not be worked on."""
    if isinstance(error, MemoryError):
        return f"{os.fspath(path)}: not enough memory"
    if isinstance(error, OSError):
        return f"{error.filename or os.fspath(path)}: {error.strerror or error}"
    return str(error) if isinstance(error, UsdError) else f"{os.fspath(path)}: malformed: {error}"


def check(
    paths: Sequence[str | os.PathLike[str]] | str | os.PathLike[str],
    *,
    y: str = "up",
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
    options: tuple[str, ...] = (),
) -> Json:
    """Checks the normals textures in USD scenes.

    Parameters
    ----------
    paths
        One .usd, .usda, .usdc or .usdz file, or several.
    y
        "up": green points as scale and bias say; "auto": nothing is required.
    root
        The folder in which all textures have to lie, links followed.  None: that of the scene.
    max_bytes
        The most that is read of the textures of a scene.
    options
        Further options of ``ntp check``.

    Returns
    -------
    dict
        Of the shape that ``ntp check --format json`` prints, with an entry for each image.
    """
    files: list[Json] = []
    for path in [paths] if isinstance(paths, str | os.PathLike) else paths:
        try:
            scene = load(path, root=root, max_bytes=max_bytes)
            files += check_scene(scene, options, y) + lost_layers(scene)
        except MALFORMED as error:
            entry: Json = {**_ntp.path_fields(path), "status": "unreadable", "type": None}
            files.append({**entry, "message": why(path, error), "findings": []})
    return {
        "schema_version": 1,
        "tool": _ntp.tool_fields(),
        "files": files,
        "summary": summarize(files),
    }
