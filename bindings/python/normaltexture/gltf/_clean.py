# SPDX-License-Identifier: MIT
"""Cleans the normals textures of a glTF file into a copy of it."""

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from .. import _ntp
from ._check import check_document, image_fields, media_type, safe_name
from ._document import Document, GltfError, load
from ._walk import NormalImage, normal_images
from ._write import Replacement, plan, valid_suffix, why_fixed, write

Json = dict[str, Any]
Method = Literal["derive", "normalize", "auto"]


def _convert_options(entry: Json, *, drop_alpha: bool, flip_green: bool) -> list[str]:
    """The options of `ntp convert` that an image needs after cleaning; [] for none."""
    options = []
    opaque = any(finding["id"] == "NT041" for finding in entry["findings"])
    if drop_alpha and opaque and entry["channels"] == 4:
        options += ["--channels", "xyz"]
    if flip_green:
        options += ["--from-y", "down", "--to-y", "up"]
    return options


def _clean_one(
    document: Document, image: NormalImage, entry: Json, folder: Path, how: Json
) -> tuple[bytes | None, Json]:
    """The new bytes of an image, None where nothing changes, and what was done."""
    data = document.image_bytes(image.index)
    source = folder / safe_name(image, media_type(data)[1])
    source.write_bytes(data)
    done, _ = _ntp.run_json(
        "clean",
        [source.name],
        ["-o", "cleaned", "--only-changed", "--method", how["method"]],
        cwd=folder,
    )
    said = done["files"][0]
    for key in ("path", "path_base64", "output"):
        said.pop(key, None)
    if said["status"] != "ok":
        return None, said
    result = folder / "cleaned" / f"{source.stem}.png"
    result = result if said.pop("written") else source
    convert = _convert_options(entry, drop_alpha=how["drop_alpha"], flip_green=how["flip_green"])
    if convert:
        _ntp.run_json("convert", [result], ["-o", "converted.png", *convert], cwd=folder)
        result = folder / "converted.png"
    said["alpha_dropped"] = "--channels" in convert
    said["green_flipped"] = "--from-y" in convert
    return (None if result == source else result.read_bytes()), said


def _skip(entry: Json, message: str) -> None:
    entry.update(status="skipped", message=message, written=False)


def _clean_image(
    document: Document, image: NormalImage, found: Json, normals: set[int], how: Json
) -> tuple[Json, bytes | None]:
    """The entry of an image, and its new bytes or None."""
    entry = {**image_fields(document, image), "status": "ok", "message": None, "written": False}
    where = f"{entry['path']}, image {image.index}"
    if found["status"] != "ok":
        entry.update(status=found["status"], message=found["message"])
        return entry, None
    data = document.image_bytes(image.index)
    mime = media_type(data)[0]
    fixed = why_fixed(document, image.index, normals)
    if image.other_uses:
        slots = ", ".join(sorted({use.slot for use in image.other_uses}))
        _skip(entry, f"{where}: is used as {slots} as well")
    elif fixed:
        _skip(entry, f"{where}: {fixed}")
    elif mime not in ("image/png", "image/jpeg"):
        _skip(entry, f"{where}: {mime} is not written")
    elif mime == "image/jpeg" and how["keep_jpeg"]:
        _skip(entry, f"{where}: JPEG is left as it is")
    else:
        with tempfile.TemporaryDirectory(prefix="ntp-gltf-") as scratch:
            new, said = _clean_one(document, image, found, Path(scratch), how)
        entry.update(said, written=new is not None)
        if entry["message"]:  # without the program's advice, which names options of its own
            reason = entry["message"].partition(": ")[2].partition("; --")[0]
            entry["message"] = f"{where}: {reason}"
        return entry, new
    return entry, None


def _clean_images(document: Document, how: Json) -> tuple[list[Json], dict[int, Replacement]]:
    """The entries of all images, and what replaces those that change."""
    images = normal_images(document)
    normals = {image.index for image in images}
    found = {entry["image"]: entry for entry in check_document(document)}
    entries, replacements = [], {}
    for image in images:
        entry, new = _clean_image(document, image, found[image.index], normals, how)
        entries.append(entry)
        if new is not None:
            replacements[image.index] = Replacement(new)
    return entries, replacements


def clean(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    method: Method = "derive",
    drop_alpha: bool = True,
    flip_green: bool = False,
    keep_jpeg: bool = False,
    dry_run: bool = False,
) -> Json:
    """Writes a copy of a glTF file in which only normals textures differ, now clean.

    Parameters
    ----------
    path
        A .gltf or .glb file.
    output
        The copy, of the same kind.  In another directory, the other files that the document
        names are copied beside it, as they are.  In the same directory, cleaned images get new
        names.  None: in place; JPEG images are then left.
    method
        As ``ntp clean --method``.
    drop_alpha
        Drop an alpha channel that is opaque everywhere, as glTF asks for.
    flip_green
        Turn green from down (DirectX) to up in every normals texture.
    keep_jpeg
        Leave JPEG images as they are.  Otherwise they become PNG: JPEG cannot hold clean normals.
    dry_run
        Write nothing.

    Returns
    -------
    dict
        Of the shape that ``ntp clean --format json`` prints, with one entry for each image.

    Raises
    ------
    OSError
        A file cannot be read or written.
    GltfError
        The file is malformed, or something would be written outside the output's directory.
    ValueError
        The output's name does not end as the input's.

    Examples
    --------
    >>> import json
    >>> from pathlib import Path
    >>> from normaltexture import gltf
    >>> wall = {"asset": {"version": "2.0"}, "images": [{"uri": "wall_n.png"}]}
    >>> wall |= {"textures": [{"source": 0}], "materials": [{"normalTexture": {"index": 0}}]}
    >>> size = Path("wall.gltf").write_text(json.dumps(wall))
    >>> gltf.clean("wall.gltf", "clean/wall.gltf")["files"][0]["changed"]
    268
    >>> gltf.check("clean/wall.gltf")["summary"]["with_errors"]
    0
    """
    document = load(path)
    target = Path(path if output is None else output)
    if not valid_suffix(target, document):
        kind = ".gltf" if document.chunks is None else ".glb"
        raise ValueError(f"output {os.fspath(target)!r} does not end in {kind}")
    how = {"method": method, "drop_alpha": drop_alpha, "flip_green": flip_green}
    how["keep_jpeg"] = keep_jpeg or output is None
    try:
        entries, replacements = _clean_images(document, how)
        outputs: Sequence[Path] = []
        if replacements or output is not None:
            planned = plan(document, replacements, target, copy_others=output is not None)
            outputs = [*planned.files, *planned.copies]
            if not dry_run:
                write(planned)
    except (TypeError, AttributeError, KeyError) as error:
        raise document.fail(f"malformed: {error}") from error
    states = [entry["status"] for entry in entries]
    return {
        "schema_version": 1,
        "tool": _ntp.tool_fields(),
        "files": entries,
        "outputs": [_ntp.path_fields(name) for name in outputs],
        "summary": {
            "files": len(entries),
            "written": sum(entry["written"] for entry in entries),
            "unchanged": sum(e["status"] == "ok" and not e["written"] for e in entries),
            "skipped": states.count("skipped"),
            "refused": states.count("refused"),
            "failed": states.count("unreadable"),
        },
    }


__all__ = ["GltfError", "clean"]
