# SPDX-License-Identifier: MIT
"""Checks the normals textures of a glTF file: the program's findings and those of glTF's rules.

glTF says what a normals texture stores, so images are judged as standard normals, whatever their
texels look like.  Heights, photographs and the like are still called by their name.
"""

import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from .. import _ntp
from .._named import MAX_BYTES
from ._document import Document, GltfError, load
from ._pixels import Extracted, extract, media_type
from ._rules import RULES
from ._walk import (
    NormalImage,
    Use,
    is_odd_scale,
    normal_images,
    uses_without_coordinates,
)

Json = dict[str, Any]
GltfType = Literal["auto", "standard", "zzero", "xy"]

# From this confidence on a guess about texels is a warning; below it is a note.
SURE = 0.9
# What looks like this is judged as the standard normals that glTF asks for.
_READ_AS_STANDARD = ("zzero", "xy")

# Slots that are decoded from sRGB.
COLOR_SLOTS = {
    "basecolortexture",
    "emissivetexture",
    "diffusetexture",
    "specularglossinesstexture",
    "sheencolortexture",
    "specularcolortexture",
    "diffusetransmissioncolortexture",
}
# What `source` may name, and each extension.
FORMATS = {
    "": ("image/png", "image/jpeg"),
    "KHR_texture_basisu": ("image/ktx2",),
    "EXT_texture_webp": ("image/webp",),
    "EXT_texture_avif": ("image/avif",),
    "MSFT_texture_dds": ("image/vnd-ms.dds",),
}


def finding(rule: str, level: str, message: str, count: int = 0) -> Json:
    """A finding as the program spells it."""
    return {"id": rule, "level": level, "message": message, "count": count}


def declared_type(document: Document, index: int) -> str:
    """The media type that the file claims for an image, "" for none."""
    image = document.item("images", index)
    uri = str(image.get("uri", ""))
    if uri.startswith("data:"):
        return str(image.get("mimeType") or re.split("[;,]", uri[5:], maxsplit=1)[0])
    return str(image.get("mimeType", ""))


def document_findings(document: Document, image: NormalImage, data: bytes) -> list[Json]:
    """What the file around an image says, whatever its texels are."""
    found = []
    if image.other_uses:
        colors = [use for use in image.other_uses if use.slot.lower() in COLOR_SLOTS]
        names = ", ".join(sorted({use.slot for use in colors or image.other_uses}))
        level = "error" if colors else "warning"
        found.append(finding("NT060", level, f"the same image is used as {names}"))
    for use in image.uses:
        scale = use.info["scale"]
        if is_odd_scale(scale):
            found.append(finding("NT061", "warning", f"{use.pointer} has a scale of {scale:g}"))
        if use.info["mirrored"] or use.info["turned"]:
            how = "mirrored" if use.info["mirrored"] else "turned"
            found.append(
                finding("NT067", "info", f"{use.pointer} is {how} by KHR_texture_transform")
            )
    for use in uses_without_coordinates(document, image):
        found.append(
            finding(
                "NT062",
                "warning",
                f"a mesh with {use.pointer} has no TEXCOORD_{use.info['tex_coord']}",
            )
        )
    claimed, actual = declared_type(document, image.index), media_type(data)[0]
    if claimed and actual and claimed != actual:
        found.append(
            finding("NT063", "warning", f"the image is said to be {claimed} and is {actual}")
        )
    found += _extension_findings(document, image, actual)
    return found


def _names(document: Document, key: str) -> list[str]:
    """extensionsUsed or extensionsRequired."""
    found = document.json.get(key, [])
    return [str(name) for name in found] if isinstance(found, list) else []


def _extension_words(document: Document, use: Use, actual: str) -> Iterator[tuple[str, str]]:
    """(level, message) of what keeps readers from showing an image."""
    allowed = FORMATS.get(use.via)
    name = use.via or "source"
    if allowed is not None and actual and actual not in allowed:
        words = " or ".join(allowed)
        yield "error", f"{name} of texture {use.texture} is {actual}; it has to be {words}"
    if not use.via:
        return
    alone = use.role == "only"
    level = "error" if alone else "warning"
    if use.via not in _names(document, "extensionsUsed"):
        yield level, f"{use.via} is not in extensionsUsed: readers may ignore it"
    if alone and use.via not in _names(document, "extensionsRequired"):
        yield "warning", f"texture {use.texture} has no fallback, and {use.via} is not required"


def _extension_findings(document: Document, image: NormalImage, actual: str) -> list[Json]:
    told = [pair for use in image.uses for pair in _extension_words(document, use, actual)]
    return [finding("NT068", level, message) for level, message in dict.fromkeys(told)]


def texel_findings(file: Json, type: GltfType) -> list[Json]:
    """What glTF asks of texels beyond what the program has found."""
    found = []
    looks = file.get("looks_like", file)
    if type in _READ_AS_STANDARD:
        words = {"zzero": "z in 0..1", "xy": "no z"}[type]
        message = f"glTF reads standard normals; this image stores {words}, as --type says"
        found.append(finding("NT065", "error", message))
    elif looks["type"] == "zzero" and looks["confidence"] >= SURE:
        level = "error" if _ntp.worst_level(file) == "error" else "warning"
        sure = f"{100 * looks['confidence']:.0f} % sure"
        message = f"this image stores z in 0..1 (Z-zero, {sure}); glTF reads blue as -1..1"
        found.append(finding("NT065", level, message))
    if file["channels"] in (2, 4):
        found.append(
            finding("NT066", "warning", "the image has an alpha channel; nothing reads it")
        )
    return found


def where(entry: Mapping[str, Any]) -> str:
    """How messages name an image."""
    return f"{entry['path']}, image {entry['image']}"


def image_fields(document: Document, image: NormalImage) -> Json:
    """What stands beside a file's own fields: which file and image, and who uses it."""
    return {
        **_ntp.path_fields(document.path),
        "image": image.index,
        "name": image.name,
        "storage": image.kind,
        "uses": [use.to_dict() for use in image.uses],
        "other_uses": [use.to_dict() for use in image.other_uses],
    }


# What following a malformed file raises, and what a huge one does.
MALFORMED = (TypeError, AttributeError, KeyError, RecursionError, MemoryError)


def why(path: str | os.PathLike[str], error: BaseException) -> str:
    """The message about a file that could not be worked on."""
    if isinstance(error, MemoryError):
        return f"{os.fspath(path)}: not enough memory"
    if isinstance(error, OSError):
        return f"{error.filename or os.fspath(path)}: {error.strerror or error}"
    return str(error) if isinstance(error, GltfError) else f"{os.fspath(path)}: malformed: {error}"


def unreadable(path: str | os.PathLike[str], message: str) -> Json:
    """The entry of a file that could not be read."""
    return {
        **_ntp.path_fields(path),
        "status": "unreadable",
        "message": message,
        "type": None,
        "findings": [],
    }


def check_document(
    document: Document, options: tuple[str, ...] = (), y: str = "up", type: GltfType = "auto"
) -> list[Json]:
    """The entries of a loaded file's images, by index."""
    entries: list[Json] = []
    readable: list[tuple[Extracted, Json]] = []
    room = document.max_bytes
    with tempfile.TemporaryDirectory(prefix="ntp-gltf-") as scratch:
        folder = Path(scratch)
        for image in normal_images(document):
            entry = image_fields(document, image)
            entries.append(entry)
            try:
                data = document.image_bytes(image.index)
                room -= len(data)
                if room < 0:
                    raise document.fail("max_bytes (--max-bytes) leaves no room for this image")
            except GltfError as error:
                message = f"{where(entry)}: {str(error).removeprefix(f'{document.path}: ')}"
                entry.update(status="unreadable", message=message, type=None, findings=[])
                continue
            made = extract(image, data, folder)
            entry["findings"] = document_findings(document, image, data) + made.findings
            if made.path is None:
                why_not = finding("NT064", "info", made.why_not)
                entry["findings"] = by_level([*entry["findings"], why_not])
                message = f"{where(entry)}: {made.why_not}"
                entry.update(status="skipped", message=message, type=None)
            else:
                readable.append((made, entry))
        for xy in (False, True):  # those that hold x and y alone are judged as such
            some = [
                (made.path.name, entry) for made, entry in readable if made.path if made.xy == xy
            ]
            names = [name for name, _ in some]
            files = judge(folder, names, options, y, "xy" if xy else type) if some else []
            for (_, entry), file in zip(some, files, strict=True):
                _merge(entry, file, "auto" if xy else type)
    return entries


def judge(
    folder: Path, names: Sequence[str], options: tuple[str, ...], y: str, type: GltfType
) -> list[Json]:
    """What the program says about images in a folder, read as glTF reads them."""

    def run(some: Sequence[str], *more: str) -> list[Json]:
        checked, _ = _ntp.run_json("check", some, [*options, *more], cwd=folder)
        return list(checked["files"])

    files = run(names, "--y", y, "--type", type)
    told = "standard" if type == "auto" else type
    again = [i for i, f in enumerate(files) if type == "auto" and f["type"] in _READ_AS_STANDARD]
    if again:
        for i, file in zip(again, run([names[i] for i in again], "--y", y, "--type", told)):
            looks = {key: files[i][key] for key in ("type", "confidence", "reasons")}
            files[i] = {**file, "looks_like": looks}
    doubted = [i for i, f in enumerate(files) if any(n["id"] == "NT010" for n in f["findings"])]
    for i in doubted:  # with a direction required, the program does not say how sure it is
        as_told = files[i]["type"] if files[i]["type"] != "one-color" else told
        (free,) = run([names[i]], "--y", "auto", "--type", as_told)
        if free["y_confidence"] < SURE:
            for found in files[i]["findings"]:
                if found["id"] == "NT010":
                    found["level"] = "info"
    return files


def type_to_clean(judged: Json, type: str, method: str) -> tuple[str, str]:
    """As what, and how, an image that `judge` has seen is cleaned.

    Where channels are in wrong places or numbers were converted to sRGB, the program decides: it
    undoes that, or refuses.  A note NT040 says only that there are color chunks.
    """
    ids = {found["id"] for found in judged["findings"] if found["level"] != "info"}
    if ids & {"NT012", "NT040"}:
        return "auto", method
    if "looks_like" in judged:
        # x and y are right, and z was stored for other readers or not at all.
        return "standard", "derive"
    return type, method


def _merge(entry: Json, file: Json, type: GltfType) -> None:
    """Puts what the program said about an image into its entry."""
    about_container = entry["findings"]
    said = {key: value for key, value in file.items() if key not in ("path", "path_base64")}
    entry.update(said)
    if file["status"] != "ok":
        message = file["message"].partition(": ")[2] or file["message"]
        entry["message"] = f"{where(entry)}: {message}"
        return
    found = file["findings"] + about_container + texel_findings(file, type)
    for one in found:
        if one["id"] == "NT045":  # glTF says how normals are read: there is nobody to be asked
            one["level"] = "error"
    entry["findings"] = by_level(_once(found))


def _once(findings: list[Json]) -> list[Json]:
    """What the program and the descriptor both say is said once; the program's comes first."""
    both = {"NT036", "NT045", "NT053", "NT066"}
    known: set[str] = set()
    kept = []
    for one in findings:
        if one["id"] not in both or one["id"] not in known:
            kept.append(one)
        known.add(one["id"])
    return kept


def by_level(findings: list[Json]) -> list[Json]:
    """Findings, the gravest first."""
    return sorted(findings, key=lambda found: -_ntp.LEVELS.index(found["level"]))


def summarize(files: list[Json]) -> Json:
    """Counts over entries, as `ntp check` prints them, as far as they make sense here."""
    worst = [_ntp.worst_level(file) for file in files if file["status"] == "ok"]
    return {
        "files": len(files),
        "containers": len({_ntp.path_of(file) for file in files}),
        "well_formed": sum(level in (None, "info") for level in worst),
        "with_warnings": worst.count("warning"),
        "with_errors": worst.count("error"),
        "unreadable": sum(file["status"] == "unreadable" for file in files),
        "skipped": sum(file["status"] == "skipped" for file in files),
    }


def check(
    paths: Sequence[str | os.PathLike[str]] | str | os.PathLike[str],
    *,
    type: GltfType = "auto",
    y: str = "up",
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
    options: tuple[str, ...] = (),
) -> Json:
    """Checks the normals textures in glTF files.

    Parameters
    ----------
    paths
        One .gltf or .glb file, or several.
    type
        What the images hold.  "auto": standard normals, as glTF says, and an image that is clearly
        something else is reported.  "standard": standard normals, whatever they look like.
        "zzero", "xy": z in 0..1, or none, which glTF does not read.
    y
        Which way green has to point: "up" as glTF says, or "auto" to require nothing.
    root
        The folder in which all files have to lie that a glTF file names, links followed.  None:
        the folder of that file.
    max_bytes
        The most that is read of one glTF file, with its buffers; and the most of its images.
    options
        Further options of ``ntp check``, such as ``("--max-fail", "5")``.

    Returns
    -------
    dict
        Of the shape that ``ntp check --format json`` prints, with one entry for each image
        instead of each file; an entry also has ``image``, ``name``, ``storage``, ``uses`` and
        ``other_uses``.  A file that cannot be read is an entry with status "unreadable".

    Raises
    ------
    normaltexture._ntp.ProgramError
        The program ntp is missing or refuses an option.

    Examples
    --------
    >>> import json
    >>> from pathlib import Path
    >>> from normaltexture import gltf
    >>> wall = {"asset": {"version": "2.0"}, "images": [{"uri": "wall_n.png"}]}
    >>> wall |= {"textures": [{"source": 0}], "materials": [{"normalTexture": {"index": 0}}]}
    >>> size = Path("wall.gltf").write_text(json.dumps(wall))
    >>> (entry,) = gltf.check("wall.gltf")["files"]
    >>> entry["type"], entry["findings"][0]["id"], entry["uses"][0]["pointer"]
    ('standard', 'NT001', '/materials/0/normalTexture')
    """
    if isinstance(paths, str | os.PathLike):
        paths = [paths]
    files: list[Json] = []
    for path in paths:
        try:
            files += check_document(load(path, root=root, max_bytes=max_bytes), options, y, type)
        except (GltfError, OSError, *MALFORMED) as error:
            files.append(unreadable(path, why(path, error)))
    return {
        "schema_version": 1,
        "tool": _ntp.tool_fields(),
        "files": files,
        "summary": summarize(files),
    }


__all__ = ["RULES", "check", "check_document"]
