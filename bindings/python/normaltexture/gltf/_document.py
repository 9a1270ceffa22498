# SPDX-License-Identifier: MIT
"""A .gltf or .glb file as it is on disk: its JSON text, its chunks, its buffers and images.

Files come from anywhere, so everything is checked when it is looked up.  A wrong index, offset or
length is a GltfError that says which.  Files that the document names are opened by `_named`: they
are regular, not too large, and inside a folder.  Nothing is fetched from a network.
"""

import base64
import binascii
import json
import os
import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from .._named import MAX_BYTES, Version, open_named, read_named, version

GLB_MAGIC = b"glTF"
CHUNK_JSON = 0x4E4F534A
CHUNK_BIN = 0x004E4942
CHUNK_ALIGNMENT = 4

_DATA_URI = re.compile(r"data:(?P<mime>[^,;]*)(?P<parameters>(?:;[^,;]*)*),", re.DOTALL)
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")
_BOM = "\ufeff"


class GltfError(ValueError):
    """A file is no valid glTF, or names a file that is not read; the message says which."""


@dataclass
class Document:
    """One file, read whole.

    Attributes
    ----------
    path
        Where it was read from; relative URIs start in its directory.
    text
        Its JSON, character for character.
    json
        The same, parsed.
    chunks
        Of a .glb: (type, data) of every chunk after the JSON, in their order.  None: a .gltf.
    root
        The folder in which the files that it names have to lie.
    max_bytes
        The most that is held of it and its buffers together with one image.
    versions
        {true path: version} of every file that was read.
    """

    path: Path
    raw: bytes
    text: str
    json: dict[str, Any]
    chunks: list[tuple[int, bytes]] | None
    root: Path
    max_bytes: int = MAX_BYTES
    versions: dict[str, Version] = field(default_factory=dict, repr=False)
    _buffers: dict[int, bytes] = field(default_factory=dict, repr=False)
    _files: dict[Path, bytes] = field(default_factory=dict, repr=False)

    def fail(self, message: str) -> GltfError:
        return GltfError(f"{self.path}: {message}")

    def items(self, key: str) -> list[dict[str, Any]]:
        """A top-level list of objects, such as "images"; empty where there is none."""
        found = self.json.get(key, [])
        if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
            raise self.fail(f"{key} is not a list of objects")
        return found

    def item(self, key: str, index: Any) -> dict[str, Any]:
        """One of them; the index comes from the file too."""
        found = self.items(key)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise self.fail(f"{key}[{index!r}] does not exist")
        return found[index]

    def resolve(self, uri: str) -> Path | bytes:
        """The file that a URI names, or the bytes that it holds."""
        data = _DATA_URI.match(uri)
        if data is not None:
            body = uri[data.end() :]
            if not data["parameters"].lower().endswith(";base64"):
                return unquote(body).encode("latin-1", "replace")
            try:
                return base64.b64decode(unquote(body), validate=False)
            except (binascii.Error, ValueError) as error:
                raise self.fail(f"a data URI is not base64: {error}") from None
        if _SCHEME.match(uri) or uri.startswith("//"):
            raise self.fail(f"{uri[:80]!r} is not a local file")
        try:
            name = os.fsencode(unquote(uri))
        except UnicodeEncodeError:  # half a surrogate pair, which JSON can hold
            name = b"\0"
        if b"\0" in name:
            raise self.fail(f"{uri[:80]!r} is not a file name")
        return self.path.parent / os.fsdecode(name)

    def _room(self) -> int:
        """How many more bytes may be held."""
        held = sum(map(len, self._files.values()))
        return max(self.max_bytes - len(self.raw) - held, 0)

    def read_file(self, path: Path) -> bytes:
        """The content of a file that the document names.

        Raises
        ------
        GltfError
            It is missing, or refused.
        """
        try:
            data, status = read_named(path, self.root, self._room())
        except OSError as error:
            raise self.fail(f"{path}: {error.strerror or error}") from None
        self.versions[os.path.realpath(path)] = version(status)
        return data

    def require_file(self, path: Path) -> None:
        """Makes sure that `read_file` would read a file, without reading it."""
        try:
            os.close(open_named(path, self.root, self._room()))
        except OSError as error:
            raise self.fail(f"{path}: {error.strerror or error}") from None

    def fetch(self, uri: Any, *, keep: bool = False) -> bytes:
        """The bytes behind a URI; `keep` holds a file for the next call."""
        if not isinstance(uri, str):
            raise self.fail(f"{uri!r} is not a URI")
        found = self.resolve(uri)
        if isinstance(found, bytes):
            return found
        if found in self._files:
            return self._files[found]
        data = self.read_file(found)
        if keep:
            self._files[found] = data
        return data

    def buffer(self, index: Any) -> bytes:
        """The bytes of a buffer, exactly its byteLength."""
        spec = self.item("buffers", index)
        if index not in self._buffers:
            if "uri" in spec:
                self._buffers[index] = self.fetch(spec["uri"], keep=True)
            else:
                first = self.chunks[0] if self.chunks else (None, b"")
                if index != 0 or first[0] != CHUNK_BIN:
                    raise self.fail(f"buffers[{index}] has neither a uri nor a binary chunk")
                self._buffers[index] = first[1]
        length = spec.get("byteLength")
        if not isinstance(length, int) or not 0 < length <= len(self._buffers[index]):
            raise self.fail(f"buffers[{index}] is shorter than its byteLength")
        return self._buffers[index][:length]

    def view_range(self, index: Any) -> tuple[int, int, int]:
        """(buffer, first byte, end) of a buffer view."""
        view = self.item("bufferViews", index)
        buffer = view.get("buffer")
        start, length = view.get("byteOffset", 0), view.get("byteLength")
        size = len(self.buffer(buffer))
        if (
            not isinstance(buffer, int)
            or not isinstance(start, int)
            or not isinstance(length, int)
            or not 0 <= start <= start + length <= size
            or length == 0
        ):
            raise self.fail(f"bufferViews[{index}] lies outside its buffer")
        return buffer, start, start + length

    def image_bytes(self, index: Any) -> bytes:
        """The file that an image is: PNG, JPEG, ..."""
        image = self.item("images", index)
        if "bufferView" in image:
            buffer, start, end = self.view_range(image["bufferView"])
            return self.buffer(buffer)[start:end]
        if "uri" in image:
            return self.fetch(image["uri"])
        raise self.fail(f"images[{index}] has neither a uri nor a bufferView")

    def image_kind(self, index: int) -> str:
        """Where an image is kept: "buffer", "data" (a data URI) or "file"."""
        image = self.item("images", index)
        if "bufferView" in image:
            return "buffer"
        return "data" if str(image.get("uri", "")).startswith("data:") else "file"

    def image_place(self, index: int) -> Any:
        """Equal for images that are kept in the same place, by whatever names."""
        image = self.item("images", index)
        if "bufferView" in image or "uri" not in image:
            return "buffer view", image.get("bufferView")
        uri = image["uri"]
        try:
            found = self.resolve(uri)
        except (GltfError, TypeError):
            return uri
        return uri if isinstance(found, bytes) else os.path.realpath(found)


def _parse_glb(path: Path, raw: bytes) -> tuple[bytes, list[tuple[int, bytes]]]:
    if len(raw) < 12:
        raise GltfError(f"{path}: truncated")
    version, length = struct.unpack_from("<II", raw, 4)
    if version != 2:
        raise GltfError(f"{path}: glTF version {version}; version 2 is read")
    if length > len(raw):
        raise GltfError(f"{path}: truncated: {len(raw)} of {length} bytes")
    chunks: list[tuple[int, bytes]] = []
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", raw, at)
        if at + 8 + size > length:
            raise GltfError(f"{path}: a chunk is longer than the file")
        chunks.append((kind, raw[at + 8 : at + 8 + size]))
        at += 8 + size
    if not chunks or chunks[0][0] != CHUNK_JSON:
        raise GltfError(f"{path}: the first chunk is not JSON")
    return chunks[0][1], chunks[1:]


def load(
    path: str | os.PathLike[str],
    *,
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
) -> Document:
    """Reads a .gltf or .glb file; which of the two is told from its first bytes.

    Parameters
    ----------
    path
        The file.
    root
        The folder in which the files that it names have to lie.  None: its own folder.
    max_bytes
        The most that is held of it, of its buffers and of one of its images together.

    Raises
    ------
    OSError
        It cannot be read, is no regular file, or is too large.
    GltfError
        It is not glTF 2.
    """
    path = Path(path)
    raw, status = read_named(path, None, max_bytes)
    chunks = None
    body = raw
    if raw.startswith(GLB_MAGIC):
        body, chunks = _parse_glb(path, raw)
    if raw.startswith(b"version https://git-lfs"):
        raise GltfError(f"{path}: a Git LFS pointer, not the file: run `git lfs pull`")
    try:
        text = body.decode("utf-8")
        parsed = json.loads(text.removeprefix(_BOM))
    except (UnicodeDecodeError, ValueError, RecursionError) as error:
        raise GltfError(f"{path}: not glTF: {error}") from None
    if not isinstance(parsed, dict) or not isinstance(parsed.get("asset"), dict):
        raise GltfError(f"{path}: not glTF: there is no asset")
    if not str(parsed["asset"].get("version", "")).startswith("2."):
        raise GltfError(f"{path}: glTF version {parsed['asset'].get('version')!r}; 2 is read")
    document = Document(path, raw, text, parsed, chunks, Path(root or path.parent), max_bytes)
    document.versions[os.path.realpath(path)] = version(status)
    return document


def glb_bytes(text: str, chunks: list[tuple[int, bytes]]) -> bytes:
    """A .glb of a JSON text and further chunks, each padded as the format asks."""
    body = text.rstrip(" ").encode("utf-8")
    body += b" " * (-len(body) % CHUNK_ALIGNMENT)
    parts = [struct.pack("<II", len(body), CHUNK_JSON), body]
    for kind, data in chunks:
        padded = data + b"\0" * (-len(data) % CHUNK_ALIGNMENT)
        parts += [struct.pack("<II", len(padded), kind), padded]
    joined = b"".join(parts)
    return GLB_MAGIC + struct.pack("<II", 2, 12 + len(joined)) + joined
