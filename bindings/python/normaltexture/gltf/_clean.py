# SPDX-License-Identifier: MIT
"""Cleans the normals textures of a glTF file into a copy of it."""

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from .. import _ntp
from .._named import MAX_BYTES
from ..images import decode_to_png
from ._check import (
    MALFORMED,
    GltfType,
    by_level,
    check_document,
    document_findings,
    image_fields,
    judge,
    texel_findings,
    type_to_clean,
    where,
    why,
)
from ._document import Document, GltfError, load
from ._pixels import extract, is_plain_dds, lossless_webp, media_type, plain_dds, safe_name
from ._walk import NormalImage, normal_images
from ._write import Replacement, plan, valid_suffix, why_fixed, write

Json = dict[str, Any]
Method = Literal["derive", "normalize", "auto"]

WEBP = "image/webp"
WRITTEN = ("image/png", "image/jpeg", WEBP)


def _clean_words(entry: Json, how: Json) -> list[str]:
    """The options of `ntp clean` for an image: what it is, and the method."""
    type, method = how["type"], how["method"]
    if type == "auto":
        type, method = type_to_clean(entry, type, method)
    return ["--type", type, "--method", method]


def _convert_options(entry: Json, how: Json) -> list[str]:
    """The options of `ntp convert` that an image needs after cleaning; [] for none."""
    options = []
    opaque = any(finding["id"] == "NT041" for finding in entry["findings"])
    if how["type"] in ("zzero", "xy"):
        options += ["--type", how["type"], "--to", "standard"]
    if how["drop_alpha"] and opaque and entry["channels"] == 4:
        options += ["--channels", "xyz"]
    if how["flip_green"]:
        options += ["--y", "down", "--to-y", "up"]
    return options


def _clean_one(
    document: Document, image: NormalImage, entry: Json, folder: Path, how: Json
) -> tuple[bytes | None, Json]:
    """The new bytes of an image, None where nothing changes, and what was done."""
    data = document.image_bytes(image.index)
    source = folder / safe_name(image, media_type(data)[1])
    if media_type(data)[0] == WEBP:
        source = source.with_suffix(".png")
        data = decode_to_png(data, WEBP)
    source.write_bytes(data)
    words = ["-o", "cleaned", "--only-changed", *_clean_words(entry, how)]
    done, _ = _ntp.run_json("clean", [source.name], words, cwd=folder)
    said = done["files"][0]
    for key in ("path", "path_base64", "output"):
        said.pop(key, None)
    if said["status"] != "ok":
        return None, said
    result = folder / "cleaned" / f"{source.stem}.png"
    result = result if said.pop("written") else source
    convert = _convert_options(entry, how)
    srgb = any(finding["id"] == "NT045" for finding in entry["findings"])
    if convert or (srgb and source.suffix == ".dds" and result == source):
        if "--type" not in convert:
            convert += ["--type", "standard"]
        _ntp.run_json("convert", [result], ["-o", "converted.png", *convert], cwd=folder)
        result = folder / "converted.png"
    said["alpha_dropped"] = "--channels" in convert
    said["green_flipped"] = "--to-y" in convert
    return (None if result == source else result.read_bytes()), said


def _skip(entry: Json, message: str) -> None:
    entry.update(status="skipped", message=f"{where(entry)}: {message}", written=False)


def _clean_image(
    document: Document, image: NormalImage, found: Json, normals: set[int], how: Json
) -> tuple[Json, bytes | None]:
    """The entry of an image, and its new bytes or None."""
    entry = {**image_fields(document, image), "status": "ok", "message": None, "written": False}
    entry["remaining"] = found["findings"]
    if found["status"] != "ok":
        entry.update(status=found["status"], message=found["message"])
        return entry, None
    data = document.image_bytes(image.index)
    mime = media_type(data)[0]
    fixed = why_fixed(document, image.index, normals)
    if image.other_uses:
        slots = ", ".join(sorted({use.slot for use in image.other_uses}))
        _skip(entry, f"is used as {slots} as well")
    elif fixed:
        _skip(entry, fixed)
    elif mime not in WRITTEN and not is_plain_dds(data):
        _skip(entry, f"{mime} is not written: clean its source, and compress that anew")
    elif mime == "image/jpeg" and how["keep_jpeg"]:
        _skip(entry, "JPEG is left as it is")
    else:
        with tempfile.TemporaryDirectory(prefix="ntp-gltf-") as scratch:
            new, said = _clean_one(document, image, found, Path(scratch), how)
            if new is not None and mime == WEBP:
                new = lossless_webp(new)
                if new is None:
                    _skip(entry, "its numbers cannot be written as WebP")
                    return entry, None
            if new is not None and is_plain_dds(data):
                new = plain_dds(new)
            if new is not None:
                entry["remaining"] = _remaining(document, image, new, Path(scratch), how)
        entry.update(said, written=new is not None)
        if entry["message"]:  # without the program's advice, which names options of its own
            reason = entry["message"].partition(": ")[2].partition("; --")[0]
            entry["message"] = f"{where(entry)}: {reason}"
        return entry, new
    return entry, None


def _remaining(
    document: Document, image: NormalImage, new: bytes, folder: Path, how: Json
) -> list[Json]:
    """The findings of an image in the copy: the clean bytes are checked as the old ones were."""
    checked = folder / "check"
    checked.mkdir()
    path = extract(image, new, checked).path
    assert path is not None  # PNG, or WebP that was read before
    type: GltfType = "standard" if how["type"] in ("zzero", "xy") else how["type"]
    (file,) = judge(checked, [path.name], how["options"], "up", type)
    about_file = [f for f in document_findings(document, image, new) if f["id"] != "NT063"]
    return by_level(file["findings"] + about_file + texel_findings(file, type))


def _clean_images(document: Document, how: Json) -> tuple[list[Json], dict[int, Replacement]]:
    """The entries of all images, and what replaces those that change."""
    images = normal_images(document)
    normals = {image.index for image in images}
    checked = check_document(document, how["options"], type=how["type"])
    found = {entry["image"]: entry for entry in checked}
    entries, replacements = [], {}
    for image in images:
        entry, new = _clean_image(document, image, found[image.index], normals, how)
        entries.append(entry)
        if new is not None:
            mime, suffix = media_type(new)
            replacements[image.index] = Replacement(new, mime, (suffix,))
    return entries, replacements


def clean(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    type: GltfType = "auto",
    method: Method = "auto",
    drop_alpha: bool = True,
    flip_green: bool = False,
    keep_jpeg: bool = False,
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
    options: tuple[str, ...] = (),
    dry_run: bool = False,
) -> Json:
    """Writes a copy of a glTF file in which only normals textures differ, now clean.

    Parameters
    ----------
    path
        A .gltf or .glb file.
    output
        The copy, of the same kind.  In another folder, the other files that the document names
        are copied beside it, as they are.  In the same folder, cleaned images get new names.
        None: in place; JPEG images are then left.
    type
        What the images hold.  "auto": standard normals, as glTF says; an image that is clearly
        something else is refused.  "standard": standard normals, whatever they look like.
        "zzero", "xy": z in 0..1, or none; it becomes standard.
    method
        As ``ntp clean --method``.
    drop_alpha
        Drop an alpha channel that is opaque everywhere, as glTF asks for.
    flip_green
        Turn green from down (DirectX) to up in every normals texture.
    keep_jpeg
        Leave JPEG images as they are.  Otherwise they become PNG: JPEG cannot hold clean normals.
    root
        The folder in which all files have to lie that the document names, links followed.  None:
        its own folder.  Nothing is written outside of that one, whatever `root` is.
    max_bytes
        The most that is read of the file with its buffers; and the most of its images.
    options
        Options of ``ntp check`` for what remains, such as ``("--max-fail", "5")``.
    dry_run
        Write nothing.

    Returns
    -------
    dict
        Of the shape that ``ntp clean --format json`` prints, with one entry for each image.  Its
        ``remaining`` are the findings that the image has in the copy.

    Raises
    ------
    OSError
        A file cannot be read or written.
    GltfError
        The file is malformed, a file that it names is missing or refused, or something would be
        written outside of the output's folder.
    ValueError
        The output's name does not end as the input's, or is the input.

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
    document = load(path, root=root, max_bytes=max_bytes)
    target = Path(path if output is None else output)
    if not valid_suffix(target, document):
        kind = ".gltf" if document.chunks is None else ".glb"
        raise ValueError(f"output: {os.fspath(target)!r} does not end in {kind} as its input does")
    if output is not None and target.exists() and target.samefile(path):
        raise ValueError(f"output: {os.fspath(target)!r} is the input; without it this is replaced")
    how: Json = {"method": method, "drop_alpha": drop_alpha, "flip_green": flip_green, "type": type}
    how |= {"keep_jpeg": keep_jpeg or output is None, "options": options}
    try:
        entries, replacements = _clean_images(document, how)
        outputs: Sequence[Path] = []
        if replacements or output is not None:
            planned = plan(document, replacements, target, copy_others=output is not None)
            outputs = [*planned.files, *planned.copies]
            if not dry_run:
                write(document, planned)
    except MALFORMED as error:
        raise document.fail(why(path, error).removeprefix(f"{os.fspath(path)}: ")) from error
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
