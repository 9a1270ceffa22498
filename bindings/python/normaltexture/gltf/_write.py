# SPDX-License-Identifier: MIT
"""Writes a glTF file with some images replaced; other bytes stay as they are where possible.

A replaced image in a buffer keeps its place.  What follows it moves, by a multiple of `SHIFT`, and
the offsets of those buffer views are corrected in the text.

Nothing is written outside the folder of the output, and nothing before all that is to be copied
could be opened.
"""

import base64
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

from .._atomic import write_atomically, write_inside
from .._named import is_inside
from ._document import CHUNK_BIN, Document, glb_bytes
from ._spans import Editor

# Shifts are multiples of this, so that accessors stay aligned to their components.
SHIFT = 8


@dataclass
class Replacement:
    """New bytes of an image, their media type, and the suffixes that fit it."""

    data: bytes
    mime: str = "image/png"
    suffixes: tuple[str, ...] = (".png",)


@dataclass
class Result:
    """The files to write: the document first."""

    files: dict[Path, bytes] = field(default_factory=dict)
    copies: dict[Path, Path] = field(default_factory=dict)  # target: source, read when written
    names: dict[str, Path] = field(default_factory=dict)  # uri: target, of replaced images


def why_fixed(document: Document, index: int, normals: set[int]) -> str:
    """Why an image cannot be replaced, "" when it can; `normals` are those that hold normals."""
    image = document.item("images", index)
    here = document.image_place(index)
    for number in range(len(document.items("images"))):
        if number not in normals and document.image_place(number) == here:
            return f"image {number}, which holds no normals, is kept in the same place"
    if "bufferView" not in image:
        return ""
    view = image["bufferView"]
    if any(n != index and document.item("images", n).get("bufferView") == view for n in normals):
        return "another image is kept in the same place"
    for accessor in document.items("accessors"):
        if accessor.get("bufferView") == view:
            return "an accessor reads the same bytes"
    buffer, start, end = document.view_range(view)
    for number, other_start, other_end in _ranges(document, buffer):
        if number != view and other_start < end and start < other_end:
            return f"buffer view {number} overlaps it"
    return ""


def _ranges(document: Document, buffer: int) -> Iterator[tuple[int, int, int]]:
    """(buffer view, first byte, end) of what views, and their extensions, hold in a buffer.

    Other buffers need not have bytes: what EXT_meshopt_compression packs has a view of its own into
    a buffer that is made when the file is loaded."""
    for number, view in enumerate(document.items("bufferViews")):
        if view.get("buffer") == buffer:
            _, start, end = document.view_range(number)
            yield number, start, end
        for _, body in _extensions(view, buffer):
            start, length = body.get("byteOffset", 0), body.get("byteLength", 0)
            if not isinstance(start, int) or not isinstance(length, int):
                raise document.fail(f"bufferViews[{number}] has an extension without a range")
            yield number, start, start + length


def _extensions(view: dict[str, Any], buffer: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """(name, body) of the extensions of a buffer view that point into a buffer."""
    extensions = view.get("extensions")
    for name, body in extensions.items() if isinstance(extensions, dict) else ():
        if isinstance(body, dict) and body.get("buffer") == buffer:
            yield name, body


def _replace_in_buffer(
    document: Document, editor: Editor, buffer: int, images: dict[int, Replacement]
) -> bytes:
    """The new bytes of a buffer; the offsets in the text are corrected."""
    places = []
    for index, new in images.items():
        view = document.item("images", index)["bufferView"]
        _, start, end = document.view_range(view)
        places.append((start, end, view, index, new))
    places.sort(key=lambda place: place[0])
    old = document.buffer(buffer)
    parts, at = [], 0
    shifts: list[tuple[int, int]] = []  # (from this old offset on, moved by so much)
    moved = 0
    for start, end, view, index, new in places:
        growth = len(new.data) - (end - start)
        padding = -growth % SHIFT
        parts += [old[at:start], new.data, bytes(padding)]
        at = end
        moved += growth + padding
        shifts.append((end, moved))
        editor.set(["bufferViews", view, "byteLength"], len(new.data))
        _set_mime(document, editor, index, new)
    parts.append(old[at:])
    for path, offset in _offsets(document, buffer):
        shift = max((entry for entry in shifts if entry[0] <= offset), default=(0, 0))[1]
        if shift:
            editor.set(path, offset + shift)
    data = b"".join(parts)
    editor.set(["buffers", buffer, "byteLength"], len(data))
    return data


def _offsets(document: Document, buffer: int) -> list[tuple[list[Any], int]]:
    """(path of the number, offset) of everything that points into a buffer."""
    found: list[tuple[list[Any], int]] = []
    for number, view in enumerate(document.items("bufferViews")):
        if view.get("buffer") == buffer:
            found.append((["bufferViews", number, "byteOffset"], view.get("byteOffset", 0)))
        for name, body in _extensions(view, buffer):
            path = ["bufferViews", number, "extensions", name, "byteOffset"]
            found.append((path, body.get("byteOffset", 0)))
    return found


def _set_mime(document: Document, editor: Editor, index: int, new: Replacement) -> None:
    image = document.item("images", index)
    if "mimeType" in image and image["mimeType"] != new.mime:
        editor.set(["images", index, "mimeType"], new.mime)


def _data_uri(old: str, data: bytes, mime: str | None = None) -> str:
    head = old[: old.index(",")]
    if mime is not None:
        head = f"data:{mime};base64"
    elif not head.lower().endswith(";base64"):
        head += ";base64"
    return f"{head},{base64.b64encode(data).decode('ascii')}"


def _inside(folder: Path, uri: str, document: Document) -> Path:
    """Where the file of a relative URI comes to lie in the folder of the output."""
    source = document.resolve(uri)
    if isinstance(source, bytes):
        raise document.fail(f"{uri[:40]!r} is not a file")
    relative = os.path.relpath(source.absolute(), document.path.absolute().parent)
    if os.path.isabs(relative) or relative.split(os.sep)[0] == os.pardir:
        raise document.fail(f"{uri!r} lies outside of the folder of the file: nothing is written")
    return folder / relative


def _free_name(document: Document, target: Path, suffix: str, result: Result) -> Path:
    """A name for a replaced file beside `target`.

    It is the same name with another suffix, or with "-clean" where the document names a file of
    that name.  A file of an earlier run is replaced."""
    taken = set(result.files)
    for uri in _external_uris(document):
        source = document.resolve(uri)
        if isinstance(source, Path):
            taken |= {source.absolute(), target.parent / source.name}
    names = [target.stem, f"{target.stem}-clean"]
    names += [f"{target.stem}-clean-{number}" for number in range(2, 1000)]
    for name in names:
        candidate = target.with_name(name + suffix)
        if not taken & {candidate, candidate.absolute()}:
            return candidate
    raise document.fail(f"no name is free for {target.name}")


def _same_file(target: Path, source: Path | bytes) -> bool:
    return isinstance(source, Path) and target.exists() and target.samefile(source)


def _replace_file(
    document: Document, editor: Editor, index: int, new: Replacement, output: Path, result: Result
) -> None:
    """An image in a file of its own: the same name where that is free to take."""
    uri = document.item("images", index)["uri"]
    if uri not in result.names:
        target = _inside(output.parent, uri, document)
        in_place = output.resolve() == document.path.resolve()
        beside_source = _same_file(target, document.resolve(uri)) and not in_place
        if beside_source or target.suffix.lower() not in new.suffixes:
            target = _free_name(document, target, new.suffixes[0], result)
        result.names[uri] = target
        result.files[target] = new.data
    _rename(document, editor, ["images", index, "uri"], uri, result.names[uri])
    _set_mime(document, editor, index, new)


def _rename(document: Document, editor: Editor, path: list[Any], uri: str, target: Path) -> None:
    source = document.resolve(uri)
    if isinstance(source, Path) and source.name != target.name:
        head, slash, _ = uri.rpartition("/")
        editor.set(path, head + slash + quote(target.name))


def _external_uris(document: Document) -> dict[str, list[tuple[str, int]]]:
    """{uri: what names it} of every buffer and image in a file of its own."""
    found: dict[str, list[tuple[str, int]]] = {}
    for key in ("buffers", "images"):
        for number, item in enumerate(document.items(key)):
            uri = item.get("uri")
            if isinstance(uri, str) and not uri.startswith("data:"):
                found.setdefault(uri, []).append((key, number))
    return found


def plan(
    document: Document, replacements: dict[int, Replacement], output: Path, copy_others: bool
) -> Result:
    """What is to be written for a copy of `document` at `output` with these images.

    Raises
    ------
    GltfError
        A file that is to be copied cannot be read, or one would lie outside the output's folder.
    """
    result = Result()
    editor = Editor(document.text)
    result.files[output] = b""  # first, filled below
    chunks = None if document.chunks is None else list(document.chunks)
    in_buffers: dict[int, dict[int, Replacement]] = {}
    replaced: set[tuple[str, int]] = set()
    for index, new in sorted(replacements.items()):
        image = document.item("images", index)
        replaced.add(("images", index))
        if "bufferView" in image:
            buffer = document.view_range(image["bufferView"])[0]
            in_buffers.setdefault(buffer, {})[index] = new
        elif document.image_kind(index) == "data":
            editor.set(["images", index, "uri"], _data_uri(image["uri"], new.data, new.mime))
            _set_mime(document, editor, index, new)
        else:
            _replace_file(document, editor, index, new, output, result)
    for buffer, images in in_buffers.items():
        data = _replace_in_buffer(document, editor, buffer, images)
        replaced.add(("buffers", buffer))
        uri = document.item("buffers", buffer).get("uri")
        if not isinstance(uri, str):
            assert chunks is not None  # view_range has read the binary chunk
            chunks[0] = (CHUNK_BIN, data)
        elif uri.startswith("data:"):
            editor.set(["buffers", buffer, "uri"], _data_uri(uri, data))
        else:
            _replace_buffer_file(document, editor, buffer, data, output, result)
    text = editor.apply()
    if text == document.text and chunks == document.chunks:
        result.files[output] = document.raw
    elif chunks is None:
        result.files[output] = text.encode("utf-8")
    else:
        result.files[output] = glb_bytes(text, chunks)
    if copy_others:
        _plan_copies(document, output, replaced, result)
    _refuse_links(document, output, result)
    return result


def _replace_buffer_file(
    document: Document, editor: Editor, buffer: int, data: bytes, output: Path, result: Result
) -> None:
    uri = document.item("buffers", buffer)["uri"]
    target = _inside(output.parent, uri, document)
    if _same_file(target, document.resolve(uri)) and output.resolve() != document.path.resolve():
        target = _free_name(document, target, target.suffix, result)
    _rename(document, editor, ["buffers", buffer, "uri"], uri, target)
    result.files[target] = data


def _plan_copies(
    document: Document, output: Path, replaced: set[tuple[str, int]], result: Result
) -> None:
    """The other files that the document names, where the copy goes to another folder.

    All of them have to be there, wherever the copy goes: a copy without them is not complete."""
    for uri, users in _external_uris(document).items():
        if all(user in replaced for user in users):
            continue
        source = document.resolve(uri)
        if isinstance(source, bytes):
            continue
        document.require_file(source)
        target = _inside(output.parent, uri, document)
        if target not in result.files and not (target.exists() and target.samefile(source)):
            result.copies[target] = source


def _refuse_links(document: Document, output: Path, result: Result) -> None:
    """No link in the folder of the output may lead out of it."""
    folder = os.path.realpath(output.parent)
    for target in [*result.files, *result.copies]:
        if target != output and not is_inside(os.path.realpath(target), folder):
            raise document.fail(f"{target} is a link that leads out of {output.parent}")


def write(document: Document, result: Result) -> None:
    """Writes a plan: images and buffers first, the document last.

    Raises
    ------
    GltfError
        A file that is to be copied cannot be read any more.
    OSError
        A file cannot be written, or changed after it was read.
    """
    output, *others = result.files
    folder = output.parent

    def put(target: Path, data: bytes) -> None:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_inside(folder, target, data, document.versions.get(os.path.realpath(target)))

    for target, source in result.copies.items():
        put(target, document.read_file(source))
    for target in others:
        put(target, result.files[target])
    folder.mkdir(parents=True, exist_ok=True)
    expected = document.versions.get(os.path.realpath(output))
    write_atomically(output, result.files[output], expected)


def valid_suffix(path: Path, document: Document) -> bool:
    """Whether the name of a copy fits its format, .glb or .gltf."""
    wanted = ".gltf" if document.chunks is None else ".glb"
    return re.fullmatch(re.escape(wanted), path.suffix, re.IGNORECASE) is not None
