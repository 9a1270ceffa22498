# SPDX-License-Identifier: MIT
"""Cleans the normals textures that a USD scene names; its layers stay as they are, byte for byte."""

import os
import tempfile
import time
import zipfile
from pathlib import Path
from typing import Any

from .. import _ntp
from .._atomic import write_atomically, write_inside
from .._named import MAX_BYTES, is_inside, read_named
from ..gltf._check import by_level, type_to_clean
from ..gltf._pixels import media_type
from ._check import check_scene, first_decoding, image_fields, lost_layers, where
from ._pxr import Ar, Sdf, UsdUtils
from ._read import Scene, UsdError, load
from ._stage import NormalsImage

Json = dict[str, Any]


def _skip(entry: Json, message: str, status: str = "skipped") -> None:
    entry.update(status=status, message=f"{where(entry)}: {message}", written=False)


def _clean_bytes(data: bytes, type: str, method: str, folder: Path) -> tuple[bytes | None, Json]:
    """The new bytes of a PNG, None where nothing changes, and what was done."""
    source = folder / "image.png"
    source.write_bytes(data)
    words = ["-o", "cleaned", "--only-changed", "--type", type, "--method", method]
    done, _ = _ntp.run_json("clean", [source.name], words, cwd=folder)
    said = done["files"][0]
    for key in ("path", "path_base64", "output"):
        said.pop(key, None)
    if said["status"] != "ok" or not said.pop("written"):
        return None, said
    return (folder / "cleaned" / "image.png").read_bytes(), said


def _is_reachable(scene: Scene, resolved: str) -> bool:
    """Whether an image is a file, or one of the scene's own package and of none in that."""
    if not Ar.IsPackageRelativePath(resolved):
        return True
    package, inner = Ar.SplitPackageRelativePathOuter(resolved)
    own = os.path.realpath(package) == os.path.realpath(scene.path)
    return own and not Ar.IsPackageRelativePath(inner)


def _clean_image(
    scene: Scene, image: NormalsImage, found: Json, method: str
) -> tuple[Json, bytes | None]:
    entry = {**image_fields(scene, image), "status": "ok", "message": None, "written": False}
    entry["remaining"] = found["findings"]
    if found["status"] != "ok":
        entry.update(status=found["status"], message=found["message"])
        return entry, None
    data = scene.read(image.resolved)
    mime = media_type(data)[0] or "this format"
    read = first_decoding(image)
    if not _is_reachable(scene, image.resolved):
        _skip(entry, "lies in another package: clean that one")
    elif image.others:
        _skip(entry, f"is read by {image.others[0][0]} as well")
    elif mime != "image/png":
        _skip(entry, f"{mime} is not written: clean its source, or convert it to PNG")
    else:
        type, how = type_to_clean(found, read.type, method)
        if found["type"] in ("height", "not-normals", "object-space"):
            type = "auto"  # and the program refuses it
        with tempfile.TemporaryDirectory(prefix="ntp-usd-") as scratch:
            new, said = _clean_bytes(data, type, how, Path(scratch))
        entry.update(said, written=new is not None)
        if entry["message"]:
            reason = entry["message"].partition(": ")[2].partition("; --")[0]
            entry["message"] = f"{where(entry)}: {reason}"
        return entry, new
    return entry, None


def _inside(scene: Scene, path: str) -> Path:
    """Where a file lies below the root; nothing is written elsewhere."""
    root = os.path.realpath(scene.root)
    true = os.path.realpath(path)
    if not is_inside(true, root):
        raise UsdError(f"{path}: lies outside of {root}; nothing is written")
    return Path(os.path.relpath(true, root))


def _dependencies(scene: Scene) -> list[str]:
    """The files that a scene consists of: layers and assets, the scene first."""
    path = Sdf.AssetPath(os.fspath(scene.path))
    layers, assets, missing = UsdUtils.ComputeAllDependencies(path)
    if missing:
        raise UsdError(f"{scene.path}: {missing[0]} is not there: no copy is written")
    names = [os.fspath(scene.path), *(layer.realPath for layer in layers), *map(str, assets)]
    return list(dict.fromkeys(os.path.realpath(name) for name in names if os.path.exists(name)))


def _repacked(scene: Scene, new: dict[str, bytes]) -> bytes:
    """The package with other bytes of some files; each starts at a multiple of 64, as usdz asks."""
    with tempfile.TemporaryDirectory(prefix="ntp-usd-") as scratch:
        target = Path(scratch) / "package.usdz"
        writer = Sdf.ZipFileWriter.CreateNew(os.fspath(target))
        with zipfile.ZipFile(scene.path) as package:
            for number, info in enumerate(package.infolist()):
                name, part = info.filename, Path(scratch) / f"part{number}"
                part.write_bytes(new.get(name) or package.read(name))
                saved = time.mktime((*info.date_time, 0, 0, -1))
                os.utime(part, (saved, saved))  # the writer takes it over
                if not writer.AddFile(os.fspath(part), name):
                    raise UsdError(f"{scene.path}: {name} cannot be packed")
        if not writer.Save():
            raise UsdError(f"{scene.path}: cannot be packed")
        return target.read_bytes()


def _inner(resolved: str) -> str:
    """The name of a file within its package."""
    return resolved[resolved.index("[") + 1 : -1]


def _target_folder(scene: Scene, output: str | os.PathLike[str]) -> Path:
    """The folder for a copy of the root; the scene keeps its place in it."""
    target = Path(output)
    if target.suffix.lower() == scene.path.suffix.lower() and not target.is_dir():
        place = _inside(scene, os.fspath(scene.path))
        if target.name != place.name:
            raise ValueError(f"output: {os.fspath(target)!r}: the copy keeps the name {place.name}")
        target = target.parent
    if os.path.realpath(target) == os.path.realpath(scene.root):
        raise ValueError(f"output: {os.fspath(target)!r} holds the scene itself")
    return target


def _copy(scene: Scene, new: dict[str, bytes], folder: Path, dry_run: bool) -> list[Path]:
    """Writes the scene's files below a folder, some with new bytes."""
    changed = {os.path.realpath(name): data for name, data in new.items()}
    places = {name: _inside(scene, name) for name in _dependencies(scene)}
    for name in changed:
        places.setdefault(name, _inside(scene, name))
    outputs = []
    for name, place in places.items():
        target = folder / place
        outputs.append(target)
        if not dry_run:
            data = changed.get(name) or read_named(name, scene.root)[0]
            target.parent.mkdir(parents=True, exist_ok=True)
            write_inside(folder, target, data)
    return outputs


def _write(
    scene: Scene, new: dict[str, bytes], output: str | os.PathLike[str] | None, dry_run: bool
) -> list[Path]:
    """Writes what changed, in place or as a copy; the files that were written."""
    if scene.is_package:
        target = scene.path if output is None else Path(output)
        if target.is_dir() or (output is not None and target.suffix.lower() != ".usdz"):
            target = target / scene.path.name
        if output is not None and target.exists() and target.samefile(scene.path):
            raise ValueError(f"output: {os.fspath(target)!r} is the input; use --in-place")
        if new or output is not None:
            inner = {_inner(name): data for name, data in new.items()}
            data = _repacked(scene, inner) if new else scene.path.read_bytes()
            if not dry_run:
                target.parent.mkdir(parents=True, exist_ok=True)
                write_atomically(target, data)
            return [target]
        return []
    if output is not None:
        return _copy(scene, new, _target_folder(scene, output), dry_run)
    for name, data in new.items():
        _inside(scene, name)
        if not dry_run:
            expected = scene.versions.get(os.path.realpath(name))
            write_inside(Path(scene.root), Path(name), data, expected)
    return [Path(name) for name in new]


def _summary(entries: list[Json]) -> Json:
    states = [entry["status"] for entry in entries]
    return {
        "files": len(entries),
        "written": sum(entry["written"] for entry in entries),
        "unchanged": sum(e["status"] == "ok" and not e["written"] for e in entries),
        "skipped": states.count("skipped"),
        "refused": states.count("refused"),
        "failed": states.count("unreadable"),
    }


def clean(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    method: str = "auto",
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
    options: tuple[str, ...] = (),
    dry_run: bool = False,
) -> Json:
    """Cleans the normals textures of a scene.  Layers are not changed.

    Parameters
    ----------
    path
        A .usd, .usda, .usdc or .usdz file.
    output
        A folder for a copy of the scene with all files that it names; of a package, that of a
        .usdz too.  None: the textures themselves are replaced.
    method
        As ``ntp clean --method``.
    root, max_bytes, options
        As in `check`.
    dry_run
        Write nothing.

    Returns
    -------
    dict
        Of the shape that ``ntp clean --format json`` prints, with one entry for each image.  Its
        ``remaining`` are the findings that the image has in the copy.

    Raises
    ------
    UsdError
        The scene cannot be opened, or something would be written outside of its root.
    OSError
        A file cannot be read or written, or changed meanwhile.
    ValueError
        The output is the input.
    """
    scene = load(path, root=root, max_bytes=max_bytes)
    # Two layers may call different files by one name.
    checked = {(e["image"], e["resolved"]): e for e in check_scene(scene, options)}
    entries: list[Json] = []
    new: dict[str, bytes] = {}
    scene.max_bytes = max_bytes
    for image in scene.images():
        entry, data = _clean_image(scene, image, checked[image.asset, image.resolved], method)
        entries.append(entry)
        if data is not None:
            new[image.resolved] = data
            entry["remaining"] = _remaining(scene, image, data, options)
    entries += [{**entry, "written": False} for entry in lost_layers(scene)]
    outputs = _write(scene, new, output, dry_run)
    return {
        "schema_version": 1,
        "tool": _ntp.tool_fields(),
        "files": entries,
        "outputs": [_ntp.path_fields(name) for name in outputs],
        "summary": _summary(entries),
    }


def _remaining(
    scene: Scene, image: NormalsImage, data: bytes, options: tuple[str, ...]
) -> list[Json]:
    """The findings of an image in the copy: the clean bytes are checked as the old ones were."""
    (entry,) = check_scene(_Replaced(scene, image, data), options)
    return by_level(entry["findings"])


class _Replaced(Scene):
    """A scene of one image, with other bytes."""

    def __init__(self, scene: Scene, image: NormalsImage, data: bytes) -> None:
        super().__init__(scene.path, scene.stage, scene.root, scene.max_bytes)
        self.only, self.data = image, data

    def images(self) -> list[NormalsImage]:
        return [self.only]

    def read(self, resolved: str) -> bytes:
        return self.data
