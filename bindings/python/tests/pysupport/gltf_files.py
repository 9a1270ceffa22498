# SPDX-License-Identifier: MIT
"""glTF files for tests, made from nothing: a quad with materials, its images kept in every way.

`Model` collects images and materials; `save` writes a .glb, a .gltf with files beside it, or a
.gltf that holds everything in data URIs.  The JSON is laid out oddly on purpose (spacing, numbers
such as 1.50 and 1e-05, an escaped name), so that a copy shows whether bytes were kept.
"""

import base64
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

QUAD = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0)
COORDINATES = struct.pack("<8f", 0, 0, 1, 0, 0, 1, 1, 1)
INDICES = struct.pack("<6H", 0, 1, 2, 2, 1, 3)


@dataclass
class Model:
    images: list = field(default_factory=list)  # (name, bytes, mime)
    materials: list = field(default_factory=list)
    textures: list = field(default_factory=list)
    texcoord: bool = True

    def image(self, name, data, mime="image/png"):
        self.images.append((name, data, mime))
        self.textures.append({"source": len(self.images) - 1})
        return len(self.textures) - 1

    def material(self, name, **slots):
        """Slots by key: a texture index or a whole texture info; extensions as they are."""
        material = {"name": name}
        for key, value in slots.items():
            place = material
            if key in ("baseColorTexture", "metallicRoughnessTexture"):
                place = material.setdefault("pbrMetallicRoughness", {})
            place[key] = {"index": value} if isinstance(value, int) else value
        self.materials.append(material)

    def _json(self, views, buffer, image_entries):
        attributes = {"POSITION": 0}
        if self.texcoord:
            attributes["TEXCOORD_0"] = 1
        accessor = {"componentType": 5126, "count": 4}
        parts = [
            {"attributes": attributes, "indices": 2, "material": number}
            for number in range(len(self.materials))
        ]
        return {
            "asset": {"version": "2.0", "generator": "a \u201ctest\u201d \u00e9"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "scale": ["1.50", "1e-05", "-0.0"]}],
            "meshes": [{"primitives": parts}],
            "accessors": [
                {"bufferView": 0, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0], **accessor},
                {"bufferView": 1, "type": "VEC2", **accessor},
                {"bufferView": 2, "type": "SCALAR", "componentType": 5123, "count": 6},
            ],
            "bufferViews": views,
            "buffers": [buffer],
            "images": image_entries,
            "textures": self.textures,
            "materials": self.materials,
        }

    def _text(self, document):
        """Odd but valid: numbers as written above, tabs, a space before each colon."""
        text = json.dumps(document, indent="\t", separators=(" ,", " : "))
        for number in ("1.50", "1e-05", "-0.0"):
            text = text.replace(f'"{number}"', number)
        return text + "\n"

    def _buffer(self, with_images):
        """(bytes, buffer views) of the geometry, with images in between when they are here."""
        views, data = [], b""

        def add(part):
            nonlocal data
            data += bytes(-len(data) % 4)
            view = {"buffer": 0, "byteOffset": len(data), "byteLength": len(part)}
            if not data:
                del view["byteOffset"]  # 0 is the default
            views.append(view)
            data += part

        add(QUAD)
        later = [COORDINATES, INDICES]
        image_views = []
        if with_images:  # the first image stands before geometry, the others behind it
            for number, (_, image, _) in enumerate(self.images):
                if number == 1:
                    for part in later:
                        add(part)
                    later = []
                image_views.append(len(views))
                add(image)
        geometry = [0]
        for part in later:
            add(part)
        for number, view in enumerate(views):
            if number and number not in image_views:
                geometry.append(number)
        return data, views, geometry, image_views

    def save(self, path, how="glb"):
        """how: "glb", "files" (.gltf, .bin and images), "data" (.gltf alone), "bin" (images in a
        .bin beside a .gltf)."""
        path = Path(path)
        data, views, geometry, image_views = self._buffer(how in ("glb", "bin"))
        buffer = {"byteLength": len(data)}
        entries = []
        for number, (name, image, mime) in enumerate(self.images):
            entry = {"name": name} if how != "files" else {}
            if image_views:
                entry |= {"bufferView": image_views[number], "mimeType": mime}
            elif how == "data":
                entry["uri"] = f"data:{mime};base64,{base64.b64encode(image).decode()}"
            else:
                (path.parent / name).parent.mkdir(parents=True, exist_ok=True)
                (path.parent / name).write_bytes(image)
                entry["uri"] = name.replace(" ", "%20")
            entries.append(entry)
        if how == "data":
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode(
                "ascii"
            )
        elif how != "glb":
            buffer["uri"] = "geometry.bin"
            (path.parent / "geometry.bin").write_bytes(data)
        document = self._json(views, buffer, entries)
        for accessor, view in zip(document["accessors"], geometry, strict=True):
            accessor["bufferView"] = view
        text = self._text(document)
        path.write_bytes(glb(text, data) if how == "glb" else text.encode())
        return path


def glb(text, data, extra=b""):
    """A .glb of a JSON text and a binary chunk."""
    body = text.encode()
    body += b" " * (-len(body) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<I4s", len(body), b"JSON") + body
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data + extra
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def parse(path):
    """(JSON, its text, binary chunk) of a file, by our own few lines."""
    raw = Path(path).read_bytes()
    if not raw.startswith(b"glTF"):
        return json.loads(raw), raw.decode(), b""
    version, total = struct.unpack_from("<II", raw, 4)
    assert version == 2 and total == len(raw) and total % 4 == 0
    chunks, at = [], 12
    while at < total:
        size, kind = struct.unpack_from("<I4s", raw, at)
        assert size % 4 == 0
        chunks.append((kind, raw[at + 8 : at + 8 + size]))
        at += 8 + size
    assert at == total and chunks[0][0] == b"JSON" and chunks[1][0] == b"BIN\0"
    return json.loads(chunks[0][1]), chunks[0][1].decode(), chunks[1][1]


def view_bytes(document, buffer, view):
    view = document["bufferViews"][view]
    start = view.get("byteOffset", 0)
    part = buffer[start : start + view["byteLength"]]
    assert len(part) == view["byteLength"]
    return part


def accessor_bytes(document, buffer):
    """The bytes behind each accessor."""
    return [view_bytes(document, buffer, a["bufferView"]) for a in document["accessors"]]


def resources(path):
    """(buffer, image bytes) of a saved file, however it keeps them."""
    document, _, chunk = parse(path)

    def fetch(uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        return (Path(path).parent / uri.replace("%20", " ")).read_bytes()

    spec = document["buffers"][0]
    buffer = fetch(spec["uri"]) if "uri" in spec else chunk
    assert len(buffer) >= spec["byteLength"]
    images = [
        fetch(image["uri"]) if "uri" in image else view_bytes(document, buffer, image["bufferView"])
        for image in document["images"]
    ]
    return buffer, images


def noise_color(side=32, seed=5):
    """An image that is no normals texture."""
    rng = np.random.default_rng(seed)
    return rng.integers(0, 256, (side, side, 3)).astype(np.uint8)


def solid_uastc(color):
    """A block of UASTC whose 16 texels have one color: mode 8, and no hints."""
    red, green, blue, alpha = (int(level) for level in color)
    bits = 0b10111 | red << 5 | green << 13 | blue << 21 | alpha << 29
    return bits.to_bytes(16, "little")


def ktx2(
    blocks,
    *,
    model=166,
    channels=(0,),
    transfer=1,
    primaries=0,
    flags=0,
    scheme=0,
    layers=0,
    faces=1,
    depth=0,
    size=None,
    vulkan=0,
    keys=(),
):
    """A KTX2 of one level; `blocks` (rows, columns, 4) are the colors of its blocks of UASTC."""
    rows, columns = blocks.shape[:2]
    width, height = size or (4 * columns, 4 * rows)
    body = b"".join(solid_uastc(color) for color in blocks.reshape(-1, 4))
    samples = b"".join(
        struct.pack("<HBB4BII", 0, 127, channel, 0, 0, 0, 0, 0, 0xFFFFFFFF) for channel in channels
    )
    block = struct.pack("<IHH4B", 0, 2, 24 + len(samples), model, primaries, transfer, flags)
    block += bytes([3, 3, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0]) + samples
    descriptor = struct.pack("<I", 4 + len(block)) + block
    pairs = b""
    for key, value in keys:
        pair = key.encode() + b"\0" + value.encode() + b"\0"
        pairs += struct.pack("<I", len(pair)) + pair + bytes(-len(pair) % 4)
    at = 104
    place = (at, len(descriptor), at + len(descriptor) if pairs else 0, len(pairs), 0, 0)
    start = at + len(descriptor) + len(pairs)
    start += -start % 16
    head = struct.pack("<9I", vulkan, 1, width, height, depth, layers, faces, 1, scheme)
    index = struct.pack("<4I2Q3Q", *place, start, len(body), len(body))
    file = b"\xabKTX 20\xbb\r\n\x1a\n" + head + index + descriptor + pairs
    return file + bytes(start - len(file)) + body
