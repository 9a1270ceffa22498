# SPDX-License-Identifier: MIT
"""Opens scenes, and brings the images that they name into a form that ntp reads."""

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import _files, images
from .._named import MAX_BYTES, Version, is_inside, read_named, version
from ..gltf._pixels import extract
from ..gltf._walk import NormalImage
from ._pxr import Ar, Tf, Usd
from ._stage import NormalsImage, normals_images


class UsdError(ValueError):
    """A scene that cannot be opened, or names a file that is not read; the message says which."""


@dataclass
class Scene:
    """An opened stage, and what was read of it."""

    path: Path
    stage: Any
    root: Path
    max_bytes: int
    versions: dict[str, Version] = field(default_factory=dict)

    @property
    def is_package(self) -> bool:
        return self.path.suffix.lower() == ".usdz"

    def lost(self) -> list[str]:
        """The layers that could not be opened, by name."""
        lost: list[str] = []
        for error in self.stage.GetCompositionErrors():
            name = getattr(error, "assetPath", "") or getattr(error, "resolvedAssetPath", "")
            if not name:
                told = re.search(r"@([^@]+)@", str(error))
                name = told[1] if told else ""
            if name:
                lost.append(name)
        return list(dict.fromkeys(lost))

    def images(self) -> list[NormalsImage]:
        """The images that hold normals."""
        return normals_images(self.stage)

    def read(self, resolved: str) -> bytes:
        """The content of an image: of a file inside the root, or of one in the scene's package."""
        if Ar.IsPackageRelativePath(resolved):
            return self._of_package(resolved)
        try:
            data, status = read_named(resolved, self.root, self.max_bytes)
        except OSError as error:
            raise UsdError(f"{resolved}: {error.strerror or error}") from None
        self.versions[os.path.realpath(resolved)] = version(status)
        self.max_bytes -= len(data)
        return data

    def _of_package(self, resolved: str) -> bytes:
        package = Ar.SplitPackageRelativePathOuter(resolved)[0]
        if not is_inside(os.path.realpath(package), os.path.realpath(self.root)):
            raise UsdError(f"{package}: lies outside of {self.root}")
        asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
        if not asset:
            raise UsdError(f"{resolved}: cannot be read")
        if asset.GetSize() > self.max_bytes:
            raise UsdError(f"{resolved}: max_bytes (--max-bytes) leaves no room for this image")
        data = bytes(asset.GetBuffer())
        self.max_bytes -= len(data)
        return data


def load(
    path: str | os.PathLike[str],
    *,
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
) -> Scene:
    """Opens a scene.

    Raises
    ------
    UsdError
        It is no USD.
    OSError
        It is missing, or no regular file.
    """
    path = Path(path)
    read_named(path, None, max_bytes)
    try:
        stage = Usd.Stage.Open(os.fspath(path), Usd.Stage.LoadAll)
    except Tf.ErrorException as error:
        told = str(error).strip().splitlines()
        raise UsdError(f"{path}: no USD: {told[-1].strip() if told else 'not opened'}") from None
    return Scene(path, stage, Path(root or path.parent), max_bytes)


@dataclass
class Picture:
    """An image as a file; `signed`: its floats are vectors of -1..1, which need no scale."""

    path: Path | None = None
    why_not: str = ""
    xy: bool = False
    signed: bool = False


def _of_floats(data: bytes, path: Path) -> Picture:
    """TIFF and EXR; floats become a PFM of 0..1."""
    pixels = images.read(data)
    if pixels.ndim == 2 or pixels.shape[2] < 3:
        raise ValueError("has no three channels")
    if pixels.dtype.kind == "u":
        _files.write(path.with_suffix(".png"), pixels)
        return Picture(path.with_suffix(".png"))
    pixels = np.ascontiguousarray(pixels[..., :3], np.float32)
    signed = bool((pixels < 0).any())
    stored = ((pixels + 1) / 2).astype(np.float32) if signed else pixels
    _files.write(path.with_suffix(".pfm"), stored)
    return Picture(path.with_suffix(".pfm"), signed=signed)


def picture(number: int, name: str, data: bytes, folder: Path) -> Picture:
    """Writes an image to a folder in a form that ntp reads."""
    image = NormalImage(number, name, "file", [], [])
    if images.media_type(data) in ("image/tiff", "image/x-exr"):
        try:
            return _of_floats(data, folder / f"{number}_image")
        except (ImportError, ValueError) as error:
            return Picture(why_not=str(error))
    made = extract(image, data, folder)
    if made.path is not None and made.path.suffix == ".bin":  # TGA has no signature
        made.path = made.path.rename(made.path.with_suffix(Path(name).suffix or ".bin"))
    return Picture(made.path, made.why_not, made.xy)
