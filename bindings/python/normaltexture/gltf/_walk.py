# SPDX-License-Identifier: MIT
"""Which images of a glTF file are normals textures, and what else uses them.

A slot is any key of a material, or of one of its extensions, that ends in "Texture" and holds a
texture index: normalTexture, clearcoatNormalTexture and whatever extensions follow that custom
hold normals.  A texture names its image by `source`, and alternatives by extensions
(KHR_texture_basisu, EXT_texture_webp, ...); each of them counts.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ._document import Document

REPEAT = 10497  # the sampler's default wrap
WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}


@dataclass(frozen=True)
class Use:
    """A slot of a material that shows an image.

    ``slot`` is its key, ``pointer`` its JSON pointer, ``via`` the texture extension through which
    the image is named ("" for `source`).  ``role`` says who takes it: "only" where the texture names
    no other image, "fallback" where an extension names a better one, "preferred" where it is that.
    glTF does not rank extensions: a reader that knows several may take any of them.
    """

    material: int
    material_name: str
    slot: str
    pointer: str
    texture: int
    via: str
    role: str
    info: dict[str, Any] = field(compare=False, hash=False)

    @property
    def holds_normals(self) -> bool:
        return self.slot.lower().endswith("normaltexture")

    def to_dict(self) -> dict[str, Any]:
        wrap_s, wrap_t = self.info["wrap"]
        return {
            "material": self.material,
            "material_name": self.material_name,
            "slot": self.slot,
            "pointer": self.pointer,
            "texture": self.texture,
            "via": self.via,
            "role": self.role,
            "scale": self.info["scale"],
            "tex_coord": self.info["tex_coord"],
            "wrap_s": wrap_s,
            "wrap_t": wrap_t,
        }


@dataclass
class NormalImage:
    """An image that at least one slot reads normals from."""

    index: int
    name: str
    kind: str  # "file", "data" or "buffer"
    uses: list[Use]
    other_uses: list[Use]  # slots that read something else from it


def _slots(node: dict[str, Any], pointer: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """(key, JSON pointer, texture info) of a material and its extensions."""
    for key, value in node.items():
        if not isinstance(value, dict):
            continue
        here = f"{pointer}/{key.replace('~', '~0').replace('/', '~1')}"
        if key.lower().endswith("texture") and isinstance(value.get("index"), int):
            yield key, here, value
        elif key != "extras":
            yield from _slots(value, here)


def _sources(texture: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """(extension, image index) of a texture; the extension of plain `source` is ""."""
    if "source" in texture:
        yield "", texture["source"]
    extensions = texture.get("extensions")
    if isinstance(extensions, dict):
        for name, body in extensions.items():
            if isinstance(body, dict) and "source" in body:
                yield name, body["source"]


def _role(via: str, number: int) -> str:
    if number == 1:
        return "only"
    return "preferred" if via else "fallback"


def _number(value: Any, default: float) -> float:
    return float(value) if isinstance(value, int | float) else default


def _info(document: Document, texture: dict[str, Any], slot: dict[str, Any]) -> dict[str, Any]:
    """What about a use decides how its normals are read."""
    sampler: dict[str, Any] = {}
    if "sampler" in texture:
        sampler = document.item("samplers", texture["sampler"])
    extensions = slot.get("extensions")
    transform = extensions.get("KHR_texture_transform") if isinstance(extensions, dict) else None
    scale = transform.get("scale") if isinstance(transform, dict) else None
    mirrored = False
    if isinstance(scale, list) and len(scale) == 2:
        mirrored = _number(scale[0], 1) * _number(scale[1], 1) < 0
    return {
        "scale": _number(slot.get("scale"), 1.0),
        "tex_coord": slot.get("texCoord", 0),
        "wrap": tuple(WRAPS.get(sampler.get(key, REPEAT), "unknown") for key in ("wrapS", "wrapT")),
        "mirrored": mirrored,
        "turned": isinstance(transform, dict) and _number(transform.get("rotation"), 0) != 0,
    }


def all_uses(document: Document) -> dict[int, list[Use]]:
    """{image index: the slots that show it}."""
    found: dict[int, list[Use]] = {}
    for number, material in enumerate(document.items("materials")):
        for key, pointer, slot in _slots(material, f"/materials/{number}"):
            texture = document.item("textures", slot["index"])
            info = _info(document, texture, slot)
            sources = list(_sources(texture))
            for via, image in sources:
                document.item("images", image)
                name = str(material.get("name", ""))
                role = _role(via, len(sources))
                use = Use(number, name, key, pointer, slot["index"], via, role, info)
                found.setdefault(image, []).append(use)
    return found


def _image_name(document: Document, index: int) -> str:
    image = document.item("images", index)
    if image.get("name"):
        return str(image["name"])
    if document.image_kind(index) == "file":
        return str(image.get("uri", "")).rpartition("/")[2]
    return ""


def normal_images(document: Document) -> list[NormalImage]:
    """The images that hold normals, by index."""
    images = []
    for index, uses in sorted(all_uses(document).items()):
        normals = [use for use in uses if use.holds_normals]
        others = [use for use in uses if not use.holds_normals]
        if normals:
            name = _image_name(document, index)
            images.append(NormalImage(index, name, document.image_kind(index), normals, others))
    return images


def uses_without_coordinates(document: Document, image: NormalImage) -> list[Use]:
    """Uses on a mesh that has no texture coordinates for them."""
    missing = []
    for use in image.uses:
        wanted = f"TEXCOORD_{use.info['tex_coord']}"
        for mesh in document.items("meshes"):
            for part in mesh.get("primitives", []):
                attributes = part.get("attributes", {})
                if part.get("material") == use.material and wanted not in attributes:
                    missing.append(use)
    return list(dict.fromkeys(missing))


def is_odd_scale(scale: float) -> bool:
    """Zero switches the texture off, a negative scale turns bumps into dents."""
    return not math.isfinite(scale) or scale <= 0
